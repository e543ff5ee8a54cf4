"""What no part of the package owns: caches, files, locks, compiling, equality."""
