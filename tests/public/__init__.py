"""What holds for every public callable and every result."""
