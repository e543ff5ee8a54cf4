"""What reports of verdicts on rods share, whatever couples their modes."""

from __future__ import annotations

import math
from typing import Any

from floquetrod.cli.common import number
from floquetrod.cli.loads import describe_kind, describe_load
from floquetrod.rod.load import Progress, Quantity
from floquetrod.rod.verdict import MARGIN_SECONDS, Margin, RodStability
from floquetrod.units import Unit


def subject(result: RodStability, shown: dict[str, Unit]) -> list[str]:
    """Return lines about the rod and the load, and what is taken for granted where that is more than the study does."""
    rod, load = result.rod, result.load
    lines = [f"rod       critical force {rod.critical_force:.4g} N, critical mode {rod.critical_mode:.3g}"]
    if rod.departures:
        lines += [
            f"          {rod.departures}; SI units",
            f"          inertia {rod.mass_per_length:.4g} kg/m, weight in fluid {rod.weight_per_length:.4g} N/m, "
            f"E I {rod.flexural_rigidity:.4g} N m^2, half wave {rod.critical_half_wave:.4g} m",
        ]
    lines.append(f"load      {describe_load(load, shown, rod)}")
    lines += [f"          {text}" for text in describe_kind(load, shown, rod)]
    if rod.departures or load.departures:
        lines.append(f"assumed   {'; '.join(result.assumptions)}")
    return lines


Margins = dict[Quantity, Margin]


def margins(result: RodStability, found: Margins, shown: dict[str, Unit], enough: str) -> list[str]:
    """Return how far the load is from a change of the verdict, in the units asked for, and the damping it would take.

    ``enough`` says which damping rates are, with {} for the least.
    """
    change = {"stable": "unstable", "unstable": "stable"}.get(result.status, "decided")
    lines: list[str] = []
    for name, margin in found.items():
        sides = [(margin.below, "lower"), (margin.above, "higher")]
        known = [f"{shown[name].show(value, 4)} {way}" for value, way in sides if math.isfinite(value)]
        words = f"{change} {' or '.join(known)}" if known else _unchanged(margin, name, shown[name])
        lines.append(f"{'' if lines else 'margins':<8}  {_WORDS[name]:<11} {words}")
    damping = result.damping_to_stabilise
    if damping > 0.0:
        none = "no damping suffices: the mean force alone buckles a mode"
        lines.append(f"damping   {none if math.isinf(damping) else enough.format(f'{damping:.6g} 1/s')}")
    return lines


def search(result: RodStability, progress: Progress) -> Margins:
    """Return the margins, and let the verdict find the damping that stabilises; report hundredths of all four."""
    found: Margins = {}
    for i, quantity in enumerate(_WORDS):

        def told(done: int, parts: int, before: int = 25 * i) -> None:
            progress(before + 25 * done // parts, 100)

        found[quantity] = result.margin(quantity, seconds=MARGIN_SECONDS, progress=told)
    _ = result.damping_to_stabilise
    progress(100, 100)
    return found


def _unchanged(margin: Margin, name: Quantity, unit: Unit) -> str:
    """Return that no change was found, and up to where was searched."""
    if not any(margin.searched):
        return "not searched, which would take minutes"
    if not margin.resolution:
        return f"no change {_REACH[name]}"
    below, above = (unit.show(value, 4) for value in margin.searched)
    return f"no change from {below} lower to {above} higher"


_WORDS: dict[Quantity, str] = {"mean": "mean force", "amplitude": "amplitude", "frequency": "frequency"}
_REACH: dict[Quantity, str] = {
    "mean": "within 8 Fcr either way",
    "amplitude": "from zero to 2 Fcr above",
    "frequency": "from a ninth to nine times this frequency",
}


def verdict_record(result: RodStability, found: Margins | None) -> dict[str, Any]:
    """Return status, growth and, where margins were searched, those and damping for JSON."""
    return {
        "status": result.status,
        "unstable_modes": list(result.unstable_modes),
        "growth_rate_per_s": number(result.growth_rate),
        "decay_rate_per_s": result.decay_rate,
        "fastest_mode": result.fastest_mode,
        "time_to_grow_tenfold_s": number(result.time_to_grow(10.0)),
        **({} if found is None else _margins_record(result, found)),
        "modes_checked": result.modes_checked,
    }


def _margins_record(result: RodStability, margins: Margins) -> dict[str, Any]:
    names = {"mean": ("mean_force", "N"), "amplitude": ("amplitude", "N"), "frequency": ("frequency", "rad_per_s")}
    found: dict[str, Any] = {}
    for quantity, margin in margins.items():
        name, unit = names[quantity]
        found |= {
            f"{name}_margin_below_{unit}": number(margin.below),
            f"{name}_margin_above_{unit}": number(margin.above),
            f"{name}_margin_resolution_{unit}": margin.resolution,
            f"{name}_margin_searched_{unit}": [number(reach) for reach in margin.searched],
        }
    return {**found, "damping_to_stabilise_per_s": number(result.damping_to_stabilise)}


def subject_record(result: RodStability) -> dict[str, Any]:
    """Return the rod, what is taken for granted, and the numbers of the load for JSON."""
    rod, load = result.rod, result.load
    return {
        "growth_tolerance_per_s": result.growth_tolerance,
        "critical_force_N": rod.critical_force,
        "rod": rod.as_dict(),
        "mass_per_length_kg_per_m": rod.mass_per_length,
        "weight_per_length_N_per_m": rod.weight_per_length,
        "flexural_rigidity_N_m2": rod.flexural_rigidity,
        "assumptions": list(result.assumptions),
        "mean_N": load.mean,
        "amplitude_N": load.amplitude,
        "frequency_rad_per_s": load.frequency,
        **({} if load.is_uniform else {"axial_response": rod.axial_response(load).as_dict()}),
    }
