"""Verdicts and margins in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from floquetrod.floquet.margins import Margin
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import Load
from floquetrod.units import Unit

MARGINS: dict[str, Callable[[RodStability], Margin]] = {
    "frequency": lambda verdict: verdict.frequency_margin,
    "mean": lambda verdict: verdict.mean_force_margin,
    "amplitude": lambda verdict: verdict.amplitude_margin,
}
"""How far each quantity may go, the quickest to find first."""


def verdict_words(status: str, rate: float, what: str) -> str:
    """Return the verdict; ``what`` grows at ``rate``, in 1/s, where it is unstable."""
    if status != "unstable":
        return status
    return f"unstable: {what} at {rate:.3g} 1/s, tenfold in {math.log(10.0) / rate:.3g} s" if rate else "unstable"


def margin_words(margins: Mapping[str, Margin], load: Load, shown: Mapping[str, Unit]) -> str:
    """Return between what each quantity may move, the others staying, until the verdict changes."""
    phrases = []
    for name, margin in margins.items():
        unit, here = shown[name], getattr(load, name)
        low, high = (f"{unit.of(here + change):.4g}" for change in (-margin.below, margin.above))
        ends = [f"above {low}"] if math.isfinite(margin.below) else []
        ends += [f"below {high}"] if math.isfinite(margin.above) else []
        if len(ends) == 2:
            ends = [f"{low} to {high}"]
        phrases.append(f"{name} {ends[0]} {unit.name}" if ends else f"any {name} in reach")
    return "same verdict for " + ", ".join(phrases) if phrases else ""
