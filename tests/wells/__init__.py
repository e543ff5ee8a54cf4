"""Wells: surveys, paths, drag, reach, surface weights."""
