"""Mathieu's equation A'' + 2 c A' = (beta + alpha sin tau) A over arrays, its charts and its transition curves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from floquetrod._util.lazy import names_of

if TYPE_CHECKING:
    from floquetrod.mathieu.arrays import discriminant, exponents, growth_rate, is_stable, multipliers
    from floquetrod.mathieu.characteristic import (
        TransitionCurves,
        characteristic_values,
        tongue_widths,
        transition_curves,
    )
    from floquetrod.mathieu.charts import chart
    from floquetrod.mathieu.solutions import (
        FloquetSolution,
        characteristic_function,
        floquet_solutions,
        real_order_values,
    )

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
        "mathieu.arrays": ("discriminant", "exponents", "growth_rate", "is_stable", "multipliers"),
        "mathieu.characteristic": ("TransitionCurves", "characteristic_values", "tongue_widths", "transition_curves"),
        "mathieu.charts": ("chart",),
        "mathieu.solutions": ("FloquetSolution", "characteristic_function", "floquet_solutions", "real_order_values"),
    },
)
