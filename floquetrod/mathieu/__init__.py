"""Mathieu's equation A'' + 2 c A' = (beta + alpha sin tau) A over arrays, its charts and its transition curves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from floquetrod._util.lazy import names_of

if TYPE_CHECKING:
    from floquetrod.mathieu.array_functions import discriminant, exponents, growth_rate, is_stable, multipliers
    from floquetrod.mathieu.characteristic_curves import (
        TransitionCurves,
        characteristic_values,
        tongue_widths,
        transition_curves,
    )
    from floquetrod.mathieu.floquet_functions import (
        FloquetSolution,
        characteristic_function,
        floquet_solutions,
        real_order_values,
    )
    from floquetrod.mathieu.mathieu_charts import chart

__all__ = [
    "FloquetSolution",
    "TransitionCurves",
    "characteristic_function",
    "characteristic_values",
    "chart",
    "discriminant",
    "exponents",
    "floquet_solutions",
    "growth_rate",
    "is_stable",
    "multipliers",
    "real_order_values",
    "tongue_widths",
    "transition_curves",
]

__getattr__, __dir__ = names_of(
    __name__,
    {
        "mathieu.array_functions": ("discriminant", "exponents", "growth_rate", "is_stable", "multipliers"),
        "mathieu.characteristic_curves": (
            "TransitionCurves",
            "characteristic_values",
            "tongue_widths",
            "transition_curves",
        ),
        "mathieu.mathieu_charts": ("chart",),
        "mathieu.floquet_functions": (
            "FloquetSolution",
            "characteristic_function",
            "floquet_solutions",
            "real_order_values",
        ),
    },
)
