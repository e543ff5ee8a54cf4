"""Milling cutters."""
