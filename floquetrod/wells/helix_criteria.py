"""Criteria for a helix, by the ratio of F^2 R / (4 E I) to the contact force of the lying string."""

HELIX_RATIOS = {"energy": 2.0, "loading": 1.83**2, "alone": 8.0}
"""Smallest ratios of F^2 R / (4 E I) to the contact force of the string that lies with a helix, by criterion.

In a straight channel the compression F is then sqrt(2) (Chen, Lin & Cheatham 1990), 1.83 (Wu & Juvkam-Wold 1993) or
2 sqrt(2) (Mitchell 1996) times the critical force.  The first follows by energy in bends too
(page `theory/mean_force`), the other two are taken to keep their ratio to it.
"""

HELIX_RULES = {
    "energy": "taken to begin at sqrt(2) times the force at which it snakes (energy)",
    "loading": "taken to begin at 1.83 times the force at which it snakes (loading)",
    "alone": "taken to begin at 2 sqrt(2) times the force at which it snakes (alone)",
    "always": "taken to be one wherever it is pushed (always)",
}
"""The criteria in words, each with its name."""
