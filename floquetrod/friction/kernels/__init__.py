"""Compiled code of motions against friction."""
