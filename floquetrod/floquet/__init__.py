"""Is every solution bounded, and how fast does it grow: verdicts by several methods, and proofs."""

from __future__ import annotations

from floquetrod.floquet.verdict import Cost, FloquetVerdict, Interval, Stability, Verdict

__all__ = ["Cost", "FloquetVerdict", "Interval", "Stability", "Verdict"]
