"""Kernels: floats and arrays in, floats and arrays out; compiled or interpreted as the work deserves."""
