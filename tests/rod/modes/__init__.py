"""Kinds of modes: coupled, bent, noisy, of several sections."""
