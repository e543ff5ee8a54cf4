"""Mathieu's equation: arrays, tongues, curves, solutions."""
