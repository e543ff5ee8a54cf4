"""Compiled code of responses: Hill's matrix as a band, and extremes of Fourier series."""
