"""Systems of equations: verdicts over batches, charts, first-order theory."""

from __future__ import annotations

from floquetrod.systems.arrays import growth_rate, is_stable, multipliers
from floquetrod.systems.first_order import FirstOrderTongue, first_order_tongues

__all__ = ["FirstOrderTongue", "first_order_tongues", "growth_rate", "is_stable", "multipliers"]
