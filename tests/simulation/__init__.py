"""The simulated rod: its physics, its runs, its files."""
