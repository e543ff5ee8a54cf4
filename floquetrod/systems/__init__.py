"""Systems of equations: verdicts over batches, charts, first-order theory."""

from __future__ import annotations

from floquetrod.equations.batches import stack
from floquetrod.systems.arrays import growth_rate, is_stable, multipliers
from floquetrod.systems.charts import chart
from floquetrod.systems.first_order import FirstOrderTongue, first_order_tongues

__all__ = ["FirstOrderTongue", "chart", "first_order_tongues", "growth_rate", "is_stable", "multipliers", "stack"]
