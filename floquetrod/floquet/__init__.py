"""Is every solution bounded, and how fast does it grow: verdicts on one equation, by several methods, and proofs."""

from __future__ import annotations

from floquetrod.floquet.verdict import Cost, Interval, Stability, Verdict

__all__ = ["Cost", "Interval", "Stability", "Verdict"]
