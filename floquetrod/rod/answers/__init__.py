"""Answers about a rod under a load: verdicts, intervals, proofs, and their reports."""
