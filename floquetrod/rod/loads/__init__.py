"""The force on a rod: sines, axial waves, measured records."""
