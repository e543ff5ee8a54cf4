"""Mathieu's equation A'' + 2 c A' = (beta + alpha sin tau) A over arrays, its charts and its transition curves."""

from __future__ import annotations

from floquetrod.mathieu.arrays import discriminant, growth_rate, is_stable, multipliers
from floquetrod.mathieu.characteristic import TransitionCurves, characteristic_values, tongue_widths, transition_curves
from floquetrod.mathieu.charts import chart

__all__ = [
    "TransitionCurves",
    "characteristic_values",
    "chart",
    "discriminant",
    "growth_rate",
    "is_stable",
    "multipliers",
    "tongue_widths",
    "transition_curves",
]
