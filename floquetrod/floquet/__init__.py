"""Is every solution bounded, and how fast does it grow: verdicts on one equation, by several methods, and proofs."""
