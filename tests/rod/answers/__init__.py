"""Ranges, stress, sliding of a rod."""
