"""Kernels: floats and arrays in, floats and arrays out; interpreted for small work, compiled for large."""
