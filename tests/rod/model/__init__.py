"""What a rod is made of: beams, pipes, sizes, formulas."""
