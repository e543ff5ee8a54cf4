"""Loads on a rod: waves, records, resonances."""
