"""Compiled code of proofs for boxes of loads and rods."""
