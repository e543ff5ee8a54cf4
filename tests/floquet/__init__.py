"""Verdicts: every method, its kernels, its errors, and proofs."""
