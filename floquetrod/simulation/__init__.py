"""The whole nonlinear rod, step by step: a confirmation independent of the mode equations."""
