"""Shared helpers that know nothing of stability: validation, compilation, files, roots, arrays."""
