"""Compiled code for Mathieu's equation over arrays."""
