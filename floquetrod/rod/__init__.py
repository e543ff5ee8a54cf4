"""A rod in a channel: its data, its loads, the equations of its modes, and every question about its stability."""
