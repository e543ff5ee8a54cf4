"""What is answered about a rod under a load: verdicts, intervals, proofs, and what they say."""
