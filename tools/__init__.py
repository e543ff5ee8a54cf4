"""What checks a release: `make dist`, `make compatibility`."""
