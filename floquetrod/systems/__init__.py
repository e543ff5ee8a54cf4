"""Systems of equations: verdicts over batches, charts, first-order theory."""

from __future__ import annotations

from typing import TYPE_CHECKING

from floquetrod._util.lazy import names_of

if TYPE_CHECKING:
    from floquetrod.equations.batches import stack
    from floquetrod.systems.batch_verdicts import growth_rate, is_stable, multipliers
    from floquetrod.systems.family_charts import chart
    from floquetrod.systems.first_order import FirstOrderTongue, first_order_tongues

__all__ = ["FirstOrderTongue", "chart", "first_order_tongues", "growth_rate", "is_stable", "multipliers", "stack"]

__getattr__, __dir__ = names_of(
    __name__,
    {
        "equations.batches": ("stack",),
        "systems.batch_verdicts": ("growth_rate", "is_stable", "multipliers"),
        "systems.family_charts": ("chart",),
        "systems.first_order": ("FirstOrderTongue", "first_order_tongues"),
    },
)
