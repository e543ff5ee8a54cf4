"""Compiled code for the modes of a rod over arrays of loads."""
