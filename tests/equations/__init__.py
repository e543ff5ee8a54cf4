"""Equations and systems as values."""
