"""`floquetrod check`: one rod under one load, or one system of equations."""

from __future__ import annotations

import argparse
import json
import math
import re
from typing import Any

import floquetrod as fr
from floquetrod.cli import kick, system
from floquetrod.cli.common import (
    KINDS,
    Answer,
    add_command,
    add_friction,
    add_rod,
    add_units,
    describe_load,
    number,
    read_friction,
    read_load,
    read_rod,
    read_tolerance,
    read_units,
)
from floquetrod.cli.waiting import waiting
from floquetrod.floquet.verdict import Status
from floquetrod.rod.verdict import Margin
from floquetrod.units import Unit

_HELP = """\
Say whether a rod is stable under an axial load, which modes grow, how fast, and how far the load is from a change;
or whether a system of periodic equations from a file is stable, with its multipliers.

examples:
  floquetrod check --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr --frequency 150
  floquetrod check --rod my_rod.toml --mean 12N --amplitude 3N --frequency 24Hz
  floquetrod check --rod nitinol --mean 0.3Fcr --amplitude 0.2Fcr --frequency 85 --growth-tolerance 0.7 --json
  floquetrod check --rod nitinol --mean 0.825Fcr --amplitude 0.7Fcr --frequency 150 --friction 0.1 --kick 50mm/s
  floquetrod check --rod my_rod.toml --mean 12N --amplitude 3N --frequency 24Hz --unit Fcr,rpm --exit-code
  floquetrod check --system my_system.toml --exit-code

forces: N, kN, lbf or Fcr (the critical force of the rod).  frequencies: rad/s (none means this), Hz, rpm.
kicks: m/s, mm/s, cm/s, ft/s.  The answer is in the units of the question or of --unit; --json is in N, rad/s and m/s.
margins: how far each quantity may fall or rise, the others staying as they are, until the verdict changes.
exit status: 0 whatever the verdict; with --exit-code 0 stable, 1 unstable, 3 undecided; 2 for input it cannot use.
rod files: TOML with youngs_modulus, density, radius, length, channel_radius and, if you like, gravity, damping_rate,
inner_radius, fluid_inside, fluid_outside, added_mass_coefficient and inclination (from the vertical), as SI numbers or
strings such as "68GPa", "2.375in", "8.6ppg" or "60deg"; radii, or diameter, inner_diameter, wall_thickness and
channel_diameter in their place.

system files: TOML, or npz with arrays of the same names.  M q'' + (C + G) q' + K(t) q = 0, any consistent units:
  [system]
  stiffness = [[1, 0], [0, 4]]                # mean of K; positive restores
  cosines = [[[0.1, 0.2], [0.2, 0.16]]]       # a matrix for each harmonic of K(t); sines alike
  frequency = 3.0                             # angular; or period
and, if you like, mass (symmetric, positive), damping and gyroscopic (skew).  For x' = A(t) x, mean in place of
stiffness.
"""


def add(commands: Any) -> None:
    """Add the command to the parser."""
    summary = "say whether a rod under an axial load, or a system of equations, is stable"
    check = add_command(commands, "check", summary, _HELP, _check)
    subject = check.add_mutually_exclusive_group(required=True)
    subject.add_argument("--system", help="a TOML or npz file with the matrices of a system, see below")
    add_rod(check, subject)
    add_friction(check)
    check.add_argument("--mean", help="mean force, such as 0.2Fcr or 0.34N; negative pulls")
    check.add_argument("--amplitude", help="amplitude of the force; 0 is the static limit")
    check.add_argument("--frequency", help="frequency, such as 150 (rad/s) or 24Hz")
    add_units(check)
    check.add_argument("--exit-code", action="store_true", help="exit with 1 when unstable, 3 when undecided")
    check.add_argument("--modes", help="modes to look at, such as 1-25 or 6,7,8 (default: all that can matter)")
    check.add_argument("--method", help="of a system: half_period, monodromy, ... (default: the first that decides)")


_STATUS: dict[Status, int] = {"stable": 0, "unstable": 1, "undecided": 3}
"""Exit statuses of --exit-code; 2 is for input that cannot be used."""

_OF_A_ROD = (*KINDS, "growth_tolerance", "damping_rate", "friction", "kick", "unit", "modes")
"""Options that say nothing about a system."""

_LAST_MODE = 20_000  # far beyond any mode that matters: a typing error must not fill the memory (a choice)


def _check(options: argparse.Namespace) -> Answer:
    if options.system is not None:
        given = [name for name in _OF_A_ROD if getattr(options, name) is not None]
        if given:
            raise ValueError(
                f"--{given[0].replace('_', '-')} belongs to --rod: a system is described by its file alone"
            )
        answer, status = system.judge(options)
        return answer._replace(status=_STATUS[status] if options.exit_code else 0)
    if options.method is not None:
        raise ValueError("--method belongs to --system: the methods for a rod follow from its load")
    missing = [f"--{name}" for name in KINDS if getattr(options, name) is None]
    if missing:
        raise ValueError(f"the following arguments are required: {', '.join(missing)} (see floquetrod check --help)")
    rod = read_rod(options)
    load = read_load(options, rod)
    tolerance, rubbing, modes = read_tolerance(options), read_friction(options), _modes(options.modes)
    shown = read_units(options, rod)
    with waiting("deciding stability and searching the margins"):
        if rubbing is None:
            linear = rod.stability(load, modes=modes, growth_tolerance=tolerance)
            if not isinstance(linear, fr.RodStability):
                raise ValueError("coupled modes: to come")
            status, record, lines = linear.status, _record(linear), _report(linear, shown)
        else:
            mu, speed = rubbing
            verdict = rod.stability(load, modes=modes, growth_tolerance=tolerance, friction=mu, kick=speed)
            status = verdict.status
            record = {"with_friction": kick.record(verdict), "without_friction": _record(verdict.linear)}
            lines = [*kick.report(verdict, shown["kick"]), "", "without friction:", *_report(verdict.linear, shown)]
    text = json.dumps(record, indent=2, allow_nan=False) if options.json else "\n".join(lines)
    return Answer(text, _STATUS[status] if options.exit_code else 0)


def _modes(text: str | None) -> list[int] | None:
    if text is None:
        return None
    modes: set[int] = set()
    for part in text.split(","):
        match = re.fullmatch(r"\s*(\d{1,9})\s*(?:-\s*(\d{1,9})\s*)?", part, re.ASCII)
        if match is None:
            raise ValueError(f"--modes must be like 1-25 or 6,7,8, got {text!r}")
        first, last = int(match[1]), int(match[2] or match[1])
        if not 1 <= first <= last <= _LAST_MODE:
            raise ValueError(f"--modes must count upwards between 1 and {_LAST_MODE}, got {part.strip()!r} in {text!r}")
        modes.update(range(first, last + 1))
    return sorted(modes)


def _report(result: fr.RodStability, shown: dict[str, Unit]) -> list[str]:
    rod = result.rod
    headline = result.status.upper()
    if result.status == "unstable":
        names = ", ".join(map(str, result.unstable_modes))
        headline += f": modes {names} grow" if len(result.unstable_modes) > 1 else f": mode {names} grows"
    lines = [
        headline,
        "",
        f"rod       critical force {rod.critical_force:.4g} N, critical mode {rod.critical_mode:.3g}",
        f"load      {describe_load(result.load, shown, rod)}",
    ]
    if rod.departures:
        lines[3:3] = [
            f"          {rod.departures}; SI units",
            f"          inertia {rod.mass_per_length:.4g} kg/m, weight in fluid {rod.weight_per_length:.4g} N/m, "
            f"E I {rod.flexural_rigidity:.4g} N m^2, half wave {rod.critical_half_wave:.4g} m",
        ]
        lines.append(f"assumed   {'; '.join(result.assumptions)}")
    if result.growth_rate > 0.0:
        time = f"tenfold in {result.time_to_grow(10.0):.4g} s"
        lines.append(f"growth    {result.growth_rate:.6g} 1/s in mode {result.fastest_mode}, {time}")
    lines += _margins(result, shown)
    damping = result.damping_to_stabilise
    if damping > 0.0:
        enough = "no damping suffices: the mean force alone buckles a mode"
        lines.append(f"damping   {enough if math.isinf(damping) else f'stable at any rate above {damping:.6g} 1/s'}")
    worst = max(verdict.error for verdict in result.mode_verdicts)
    methods = ", ".join(sorted({verdict.method for verdict in result.mode_verdicts}))
    lines += [
        f"checked   {result.cutoff}",
        f"method    {methods}; discriminants good to {worst:.0e} relative",
        "",
        "mode       alpha         beta  where                  growth 1/s",
    ]
    for mode, equation, verdict, rate in _near_trouble(result):
        where = str(verdict.interval) if verdict.interval else verdict.status
        lines.append(f"{mode:4d}  {equation.alpha:10.5g}  {equation.beta:11.6g}  {where:<21}  {rate:10.4g}")
    return lines


def _margins(result: fr.RodStability, shown: dict[str, Unit]) -> list[str]:
    """Return how far each quantity of the load is from a change of the verdict, in the units asked for."""
    change = {"stable": "unstable", "unstable": "stable"}.get(result.status, "decided")
    lines: list[str] = []
    for name, margin in _all_margins(result).items():
        sides = [(margin.below, "lower"), (margin.above, "higher")]
        known = [f"{shown[name].show(value, 4)} {way}" for value, way in sides if math.isfinite(value)]
        words = f"{change} {' or '.join(known)}" if known else f"no change {_REACH[name]}"
        lines.append(f"{'' if lines else 'margins':<8}  {_WORDS[name]:<11} {words}")
    return lines


_WORDS = {"mean": "mean force", "amplitude": "amplitude", "frequency": "frequency"}
_REACH = {
    "mean": "within 8 Fcr either way",
    "amplitude": "from zero to 2 Fcr above",
    "frequency": "from a ninth to nine times this frequency",
}


def _all_margins(result: fr.RodStability) -> dict[str, Margin]:
    """Return the margins of a load by quantity."""
    return {
        "mean": result.mean_force_margin,
        "amplitude": result.amplitude_margin,
        "frequency": result.frequency_margin,
    }


def _near_trouble(result: fr.RodStability) -> list[tuple[int, fr.Mathieu, fr.Stability, float]]:
    """Return the unstable modes and the five whose discriminants come nearest to the boundary, in order of mode."""
    rows = list(zip(result.modes, result.mode_equations, result.mode_verdicts, result.mode_growth_rates, strict=True))

    def room(row: tuple[int, fr.Mathieu, fr.Stability, float]) -> float:
        return -math.inf if row[2].status != "stable" else 2.0 - abs(row[2].discriminant)

    troubled = sum(row[2].status != "stable" for row in rows)
    return sorted(sorted(rows, key=room)[: max(5, troubled)])


def _record(result: fr.RodStability) -> dict[str, Any]:
    margins = _all_margins(result)
    return {
        "status": result.status,
        "unstable_modes": list(result.unstable_modes),
        "growth_rate_per_s": result.growth_rate,
        "fastest_mode": result.fastest_mode,
        "time_to_grow_tenfold_s": number(result.time_to_grow(10.0)),
        "mean_force_margin_below_N": number(margins["mean"].below),
        "mean_force_margin_above_N": number(margins["mean"].above),
        "amplitude_margin_below_N": number(margins["amplitude"].below),
        "amplitude_margin_above_N": number(margins["amplitude"].above),
        "frequency_margin_below_rad_per_s": number(margins["frequency"].below),
        "frequency_margin_above_rad_per_s": number(margins["frequency"].above),
        "damping_to_stabilise_per_s": number(result.damping_to_stabilise),
        "modes_checked": result.modes_checked,
        "left_out_growth_bound_per_s": number(result.left_out_bound),
        "growth_tolerance_per_s": result.growth_tolerance,
        "critical_force_N": result.rod.critical_force,
        "rod": result.rod.as_dict(),
        "mass_per_length_kg_per_m": result.rod.mass_per_length,
        "weight_per_length_N_per_m": result.rod.weight_per_length,
        "flexural_rigidity_N_m2": result.rod.flexural_rigidity,
        "assumptions": list(result.assumptions),
        "mean_N": result.load.mean,
        "amplitude_N": result.load.amplitude,
        "frequency_rad_per_s": result.load.frequency,
        "modes": [
            {
                "mode": mode,
                "alpha": equation.alpha,
                "beta": equation.beta,
                "status": verdict.status,
                "interval": str(verdict.interval) if verdict.interval else None,
                "growth_rate_per_s": float(rate),
                "discriminant": number(verdict.discriminant),
                "discriminant_relative_error": number(verdict.error),
                "method": verdict.method,
            }
            for mode, equation, verdict, rate in zip(
                result.modes, result.mode_equations, result.mode_verdicts, result.mode_growth_rates, strict=True
            )
        ],
        "version": fr.__version__,
    }
