"""Compiled code of the simulated rod: its time step, and the points of a well's axis beside its nodes."""
