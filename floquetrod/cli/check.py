"""`floquetrod check`: one rod under one load, or one system of equations."""

from __future__ import annotations

import argparse
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import floquetrod as fr
from floquetrod.cli import coupled, independent, kick, system, verdicts
from floquetrod.cli.common import (
    ROD_OPTIONS,
    Answer,
    add_friction,
    add_rod,
    add_units,
    check_out,
    describe_command,
    read_friction,
    read_rod,
    read_tolerance,
    read_units,
)
from floquetrod.cli.loads import (
    LOAD_OPTIONS,
    RECORD_OPTIONS,
    add_kind,
    add_load,
    read_kind,
    read_load,
    read_record,
    require_quantities,
    warn_of_hertz,
)
from floquetrod.cli.waiting import Waiting
from floquetrod.floquet.verdict import Status
from floquetrod.plotting import charts
from floquetrod.rod.load import KINDS, Load
from floquetrod.rod.verdict import RodStability
from floquetrod.units import Unit

_HELP = """\
Decide whether a rod is stable under an axial load, which modes grow and how fast, and how far the load is from a change
of the verdict; or whether a system of periodic equations from a file is stable, with its multipliers.

examples:
  floquetrod check --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr --frequency 150rad/s
  floquetrod check --rod my_rod.toml --mean 12N --amplitude 3N --frequency 24Hz
  floquetrod check --rod nitinol --mean 0.3Fcr --amplitude 0.2Fcr --frequency 85rad/s --growth-tolerance 0.7 --json
  floquetrod check --rod nitinol --mean 0.825Fcr --amplitude 0.7Fcr --frequency 150rad/s --friction 0.1 --kick 50mm/s
  floquetrod check --rod my_rod.toml --mean 12N --amplitude 3N --frequency 24Hz --unit Fcr,rpm --exit-code
  floquetrod check --rod examples/wire.toml --mean 0.3Fcr --amplitude 0.2Fcr --frequency 20Hz --plot shape.png
  floquetrod check --rod examples/well.toml --mean 0.5Fcr --amplitude 0.3Fcr --frequency 4Hz --wave held
  floquetrod check --rod my_rod.toml --force record.csv --mean 12N --plot-force fit.png
  floquetrod check --system my_system.toml --exit-code

The answer is in the units of the question or of --unit; --json is in N, rad/s and m/s.
margins: how far each quantity may fall or rise, with the others unchanged, until the verdict changes.
exit status: 0 for every verdict; with --exit-code 0 stable, 1 unstable, 3 undecided; 2 for invalid input.
rod files: TOML with youngs_modulus, density, radius, length and channel_radius; optional are gravity, damping_rate,
inner_radius, fluid_inside, fluid_outside, added_mass_coefficient and inclination (from the vertical).  Values are SI
numbers or strings such as "68GPa", "2.375in", "8.6ppg" or "60deg".  diameter, inner_diameter, wall_thickness and
channel_diameter may replace radii.  ends is "hinged", "clamped", "guided", "free", or two of them, the upper end first,
such as "clamped-hinged".  A steel pipe needs only its name, the bore (the diameter of the hole) and the length:
  catalogue = "2.00x0.156 CT90"
  bore = "4.778in"
  length = "200ft"
  inclination = "60deg"
  ends = "clamped-hinged"

coupled modes: ends that are not hinged, weight along an inclined rod and axial waves (--wave) couple the modes.  The
answer then names the resonances, and --plot draws the shape that grows along the rod.  --mean-at none neglects the
weight along the rod: the modes of an inclined hinged rod are then independent, as --friction requires.

system files: TOML, or npz with arrays of the same names.  M q'' + (C + G) q' + K(t) q = 0, any consistent units:
  [system]
  stiffness = [[1, 0], [0, 4]]                # mean of K; positive restores
  cosines = [[[0.1, 0.2], [0.2, 0.16]]]       # a matrix for each harmonic of K(t); also sines
  frequency = 3.0                             # angular; or period
Optional are mass (symmetric, positive), damping and gyroscopic (skew).  For x' = A(t) x give mean, not stiffness.
"""


_STATUS: dict[Status, int] = {"stable": 0, "unstable": 1, "undecided": 3}
"""Exit statuses of --exit-code; 2 is for input that cannot be used."""

_OF_A_ROD = (
    *KINDS,
    *LOAD_OPTIONS,
    "growth_tolerance",
    *ROD_OPTIONS,
    "friction",
    "kick",
    "unit",
    "modes",
    "margins",
    "plot",
    "plot_force",
)
"""Options that say nothing about a system."""

_QUICK = 50  # coupled modes up to which margins take some seconds (a choice)
_LAST_MODE = 20_000  # far beyond any mode that matters: a typing error must not fill the memory (a choice)


def add(check: argparse.ArgumentParser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(check, _HELP, _check)
    subject = check.add_mutually_exclusive_group(required=True)
    subject.add_argument(
        "--system", metavar="FILE", help="a TOML or npz file with the matrices of a system, see floquetrod check --help"
    )
    add_rod(check, subject)
    add_friction(check)
    add_load(check)
    add_kind(check)
    add_units(check)
    check.add_argument("--exit-code", action="store_true", help="exit with 1 when unstable, 3 when undecided")
    check.add_argument(
        "--modes", metavar="LIST", help="modes to check, such as 1-25 or 6,7,8 (default: all that can matter)"
    )
    check.add_argument(
        "--margins",
        action=argparse.BooleanOptionalAction,
        help=f"search the margins and the damping that stabilises (default: up to {_QUICK} coupled modes)",
    )
    check.add_argument(
        "--plot",
        metavar="FILE",
        type=Path,
        help="write the shape along the rod in which coupled modes grow (.png, .pdf, .svg)",
    )
    check.add_argument(
        "--plot-force", metavar="FILE", type=Path, help="write the measured force with its fit (.png, .pdf, .svg)"
    )
    check.add_argument("--method", help="of a system: half_period, monodromy, ... (default: the first that decides)")


def _check(options: argparse.Namespace) -> Answer:
    if options.system is not None:
        system.require_alone(options, [name for name in _OF_A_ROD if getattr(options, name) is not None])
        answer, status = system.judge(options)
        return answer._replace(status=_STATUS[status] if options.exit_code else 0)
    if options.method is not None:
        raise ValueError(
            f"--method belongs to --system, got {options.method!r} with --rod: the methods for a rod follow from its "
            "load"
        )
    require_quantities(options)
    rod = read_rod(options)
    record = read_record(options, rod)
    question = _Question(
        rod,
        record,
        all(getattr(options, name) is None for name in {*KINDS, *LOAD_OPTIONS} - {"force", *RECORD_OPTIONS}),
        read_load(options, rod, read_kind(options, record)),
        _modes(options.modes),
        read_tolerance(options),
        read_friction(options),
        read_units(options, rod),
        options.margins,
        options.plot,
    )
    warn_of_hertz("--frequency", options.frequency, rod, [question.load], question.tolerance)
    if options.plot is not None:
        _require_shape(question, options.plot)
    _draw_record(record, options.plot_force)
    status, numbers, lines = _judged(question)
    written = [str(path) for path in (options.plot, options.plot_force) if path is not None]
    if written:
        numbers["written"] = written
        lines.append(f"written   {', '.join(written)}")
    text = json.dumps(numbers, indent=2, allow_nan=False) if options.json else "\n".join(lines)
    return Answer(text, _STATUS[status] if options.exit_code else 0)


class _Question(NamedTuple):
    rod: fr.Rod
    force: fr.ForceRecord | None
    is_whole: bool  # whether the record says all about the load
    load: Load
    modes: list[int] | None
    tolerance: float
    rubbing: tuple[float, float] | None
    shown: dict[str, Unit]
    margins: bool | None
    plot: Path | None

    def searched(self, result: RodStability) -> bool:
        """Return whether margins are to be searched: where that was asked for, else where it takes some seconds."""
        if self.margins is not None:
            return self.margins
        return self.rod.modes_under(self.load).prompt or result.modes_checked <= _QUICK


def _judged(asked: _Question) -> tuple[Status, dict[str, Any], list[str]]:
    """Return the verdict on a rod, the numbers for JSON, and the lines of the report."""
    rod, load, shown = asked.rod, asked.load, asked.shown
    if asked.rubbing is not None:
        mu, speed = asked.rubbing
        with Waiting("deciding stability"):
            verdict = rod.stability(load, modes=asked.modes, growth_tolerance=asked.tolerance, friction=mu, kick=speed)
        linear, margins = verdict.linear, _margins(asked, verdict.linear)
        record: dict[str, Any] = {
            "with_friction": kick.record(verdict),
            "without_friction": independent.record(linear, margins),
        }
        lines = [*kick.report(verdict, shown["kick"]), "", "without friction:"]
        return verdict.status, record, [*lines, *independent.report(linear, shown, margins)]
    # A record as it is, so that its noise counts; its fit where options say more about the load.
    judged = asked.force if asked.force is not None and asked.is_whole else load
    with Waiting("deciding stability", "verdicts") as progress:
        result = rod.stability(judged, modes=asked.modes, growth_tolerance=asked.tolerance, progress=progress)
    margins = _margins(asked, result)
    if asked.rod.modes_under(load).prompt:
        return result.status, independent.record(result, margins), independent.report(result, shown, margins)
    record, lines = coupled.record(result, margins), coupled.report(result, shown, margins)
    if asked.force is not None:
        left_out = "" if asked.is_whole else "; the error leaves out its noise, because options change the load"
        with Waiting("comparing with a sine"):
            sine = _sine(asked)
        record["force_record"] = _force_record(asked.force) | {"noise_in_error": asked.is_whole}
        record["sine_of_the_same_amplitude"] = {
            "status": sine.status,
            "growth_rate_per_s": sine.growth_rate,
        }
        lines.append(f"sine      of the same mean, amplitude and frequency: {sine.status}{_growing(sine)}")
        lines.append(f"record    {repr(asked.force)[1:-1]}{left_out}")
    if asked.plot is not None:
        with Waiting(f"writing {asked.plot}"):
            charts.save_figure(result.plot(), asked.plot)
    return result.status, record, lines


def _margins(asked: _Question, result: RodStability) -> verdicts.Margins | None:
    """Return the margins, None where they are not wanted; the verdict is said while the search takes its time."""
    if not asked.searched(result):
        return None
    with Waiting(f"{result.status}; searching the margins", "percent") as progress:
        return verdicts.search(result, progress)


def _sine(asked: _Question) -> RodStability:
    """Return the verdict on the load without its higher harmonics."""
    sine: Load = replace(asked.load, waveform="sine")
    return asked.rod.stability(sine, growth_tolerance=asked.tolerance)


def _growing(verdict: RodStability) -> str:
    return f", {verdict.growth_rate:.6g} 1/s" if verdict.growth_rate > 0.0 else ""


def _force_record(record: fr.ForceRecord) -> dict[str, Any]:
    """Return the fit of a measured force for JSON."""
    return {
        "mean_N": record.mean,
        "mean_error_N": record.mean_error,
        "amplitude_N": record.amplitude,
        "frequency_rad_per_s": record.frequency,
        "frequency_error_rad_per_s": record.frequency_error,
        "harmonics_kept": list(record.kept),
        "noise_N": record.noise,
        "periods": record.periods,
        "note": record.note,
    }


def _draw_record(record: fr.ForceRecord | None, path: Path | None) -> None:
    """Draw the fit of a measured force into a file, where one was asked for."""
    if path is None:
        return
    if record is None:
        raise ValueError(
            f"--plot-force needs --force, got {str(path)!r} alone: it draws the measured force and its fit"
        )
    check_out(path, charts.FIGURES, "--plot-force")
    charts.save_figure(record.plot()[0], path)


def _require_shape(asked: _Question, path: Path) -> None:
    """Raise ValueError where there is no shape to draw, or no file to write it to."""
    check_out(path, charts.FIGURES, "--plot")
    if asked.rod.modes_under(asked.load).prompt:
        raise ValueError(
            f"--plot draws the shape in which coupled modes grow, got {str(path)!r} for independent ones, which "
            "grow as sines; floquetrod map draws where they do"
        )


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
