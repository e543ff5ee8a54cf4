"""Periodic orbits and their branches."""
