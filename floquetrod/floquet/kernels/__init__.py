"""Compiled code of verdicts on one equation or system."""
