"""The answer of `floquetrod check` about a kick against friction."""

from __future__ import annotations

import math
from typing import Any

import floquetrod as fr
from floquetrod.cli.common import number
from floquetrod.units import Unit


def report(result: fr.FrictionalRodStability, shown: Unit) -> list[str]:
    """Return the lines about friction: the verdict first, a table of the modes that grow without it last.

    Speeds are in the unit ``shown``.
    """
    headline = result.status.upper()
    if result.unstable_modes:
        names = ", ".join(map(str, result.unstable_modes))
        headline += f": the kick destabilises mode{'s' if len(result.unstable_modes) > 1 else ''} {names}"
    inside = result.in_modes
    lines = [
        headline,
        "",
        f"friction  mu {result.friction:g}: gamma {inside.gamma:.4g}; "
        f"the rod slides axially at {shown.show(inside.v_a, 3)}",
        f"kick      {shown.show(result.kick)} in each mode: eps {inside.epsilon:.4g}",
        f"needed    {_needed(result, shown)}",
    ]
    if math.isfinite(result.critical_kick.none_up_to):
        lines.append(f"proved    {_proved(result.critical_kick.none_up_to, shown)}")
    if result.modes:
        lines += ["", f"mode  {f'kick needed {shown.name}':>16}  this kick"]
    for mode, fate in zip(result.modes, result.fates, strict=True):
        lines.append(f"{mode:4d}  {shown.of(result.critical_kicks[mode]):16.6g}  {fate.status}: {fate.reason}")
    return lines


def _proved(none_up_to: float, shown: Unit) -> str:
    if none_up_to == 0.0:
        return "nothing for any kick, however small"
    return f"no kick up to {shown.show(none_up_to)} buckles the rod"


def _needed(result: fr.FrictionalRodStability, shown: Unit) -> str:
    kick = result.critical_kick
    if math.isinf(kick.kick):
        return "no kick buckles the rod: no mode grows even without friction"
    if kick.mode is None:
        return "the smallest kick that buckles the rod could not be decided"
    return f"{shown.show(kick.kick)} is the smallest found to buckle the rod, into mode {kick.mode}"


def record(result: fr.FrictionalRodStability) -> dict[str, Any]:
    """Return the same as numbers for JSON."""
    inside, kick = result.in_modes, result.critical_kick
    return {
        "status": result.status,
        "unstable_modes": list(result.unstable_modes),
        "mu": result.friction,
        "mu_theta": inside.mu_theta,
        "kick_m_per_s": result.kick,
        "axial_velocity_m_per_s": inside.v_a,
        "gamma": inside.gamma,
        "epsilon": inside.epsilon,
        "critical_kick_m_per_s": number(kick.kick),
        "critical_mode": kick.mode,
        "no_kick_buckles_up_to_m_per_s": number(kick.none_up_to),
        "modes": [
            {"mode": mode, "critical_kick_m_per_s": number(result.critical_kicks[mode]), "fate": fate.status}
            for mode, fate in zip(result.modes, result.fates, strict=True)
        ],
    }
