"""Charts and bands over a plane of two parameters."""
