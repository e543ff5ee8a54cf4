"""Compiled code for strings in a well that a tool shakes."""
