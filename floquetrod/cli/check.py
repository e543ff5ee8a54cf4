"""`floquetrod check`: one rod under one load, or one system of equations."""

from __future__ import annotations

import argparse
import json
import re
import textwrap
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import floquetrod as fr
from floquetrod._util.interchange import by_keys
from floquetrod._util.result_report import Report
from floquetrod._util.waiting import Waiting
from floquetrod.cli.common import (
    ROD_AND_LOAD,
    add_subject,
    describe_command,
    figures,
    read_friction,
    read_tolerance,
    read_units,
    require_no_values,
    write_figures,
)
from floquetrod.cli.loads import add_question, read_question, warn_of_hertz
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser
from floquetrod.floquet.margins import Margin
from floquetrod.floquet.registry import METHODS
from floquetrod.floquet.status import STATUS_CODES, Status
from floquetrod.parameter import REQUIRED
from floquetrod.rod.answers.reports import shown_in
from floquetrod.rod.answers.rod_stability import RodStability, damping_lines
from floquetrod.rod.answers.search_pieces import FEW_MODES
from floquetrod.rod.loads.load import AxialLoad, Load, LoadSource, Quantity
from floquetrod.rod.model.beam import CONDITIONS
from floquetrod.rod.model.parameters import INSTEAD, ROD

_HELP = """\
Decide whether a rod is stable under an axial load, which modes grow and how fast, and how far the load is from a change
of the verdict; or whether a system of periodic equations from a file is stable, with its multipliers.

examples:
  floquetrod example my_rod.toml wire.toml well.toml record.csv system.toml
  floquetrod check --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr --frequency 150rad/s
  floquetrod check --rod my_rod.toml --mean 12N --amplitude 3N --frequency 24Hz
  floquetrod check --rod nitinol --mean 0.3Fcr --amplitude 0.2Fcr --frequency 85rad/s --growth-tolerance 0.7 --json
  floquetrod check --rod nitinol --mean 0.825Fcr --amplitude 0.7Fcr --frequency 150rad/s --friction 0.1 --kick 50mm/s
  floquetrod check --rod my_rod.toml --mean 12N --amplitude 3N --frequency 24Hz --unit Fcr,rpm --exit-code
  floquetrod check --rod wire.toml --mean 0.3Fcr --amplitude 0.2Fcr --frequency 20Hz --out shape.png
  floquetrod check --rod well.toml --mean 0.5Fcr --amplitude 0.3Fcr --frequency 4Hz --wave held
  floquetrod check --rod my_rod.toml --force record.csv --mean 12N --out fit.png
  floquetrod check --system system.toml --exit-code

The answer is in the units of the question or of --unit; --json is in N, rad/s and m/s.
margins: how far each quantity may fall or rise, with the others unchanged, until the verdict changes.
exit status: 0 for every verdict; with --exit-code 0 stable, 1 unstable, 3 undecided; 2 for invalid input.
{rod_file}
  catalogue = "2.00x0.156 CT90"
  bore = "4.778in"
  length = "200ft"
  inclination = "60deg"
  ends = "clamped-hinged"

coupled modes: ends that are not hinged, weight along an inclined rod and axial waves (--wave) couple the modes.  The
answer then names the resonances, and --out draws the shape that grows along the rod.  --mean-at none neglects the
weight along the rod: the modes of an inclined hinged rod are then independent, as --friction requires.

system files: TOML, or npz with arrays of the same names.  M q'' + (C + G) q' + K(t) q = 0, any consistent units:
  [system]
  stiffness = [[1, 0], [0, 4]]                # mean of K; positive restores
  cosines = [[[0.1, 0.2], [0.2, 0.16]]]       # a matrix for each harmonic of K(t); also sines
  frequency = 3.0                             # angular; or period
frequency, period and delay may have a unit, such as "24Hz": time is then in seconds, and the matrices must be in
seconds, too.  For matrices in 1/ns give 4.8 GHz as 30.16, which is in rad/ns.
Optional are mass (symmetric, positive), damping and gyroscopic (skew).  For x' = A(t) x give mean, not stiffness.
Delayed terms:
  [[system.delayed]]
  delay = 0.5
  matrix = [[0.1, 0], [0, 0]]                 # also cosines and sines
In TOML files a text in place of a number is a formula of [parameters], a table that may be empty, which --help-all of
chart explains; --set omega=2.5 gives one of these its value.  How far a parameter may change until the verdict does is
drawn by chart; as a number it is fr.margin in Python.
"""


_STATUS: dict[Status, int] = {"stable": 0, "unstable": 1, "undecided": 3}
"""Exit statuses of --exit-code; 2 is for input that cannot be used."""

_LAST_MODE = 20_000  # far beyond any mode that matters: a typing error must not fill the memory


def rod_file_in_words() -> str:
    """Return which keys a rod file has, from the records of the parameters, in lines for the help."""
    required = [name for name, parameter in ROD.items() if parameter.default is REQUIRED]
    notes = {"gravity": " (9.81 m/s^2 unless given)", "inclination": " (from the vertical)"}
    optional = [f"{name}{notes.get(name, '')}" for name in ROD if name not in required]
    instead = [f"{name} ({replaced})" for name, replaced in INSTEAD.items()]
    text = (
        f"rod files: TOML with {_and(required)}; optional are {_and(optional)}.  Values are SI numbers or strings such "
        f'as "68GPa", "2.375in", "8.6ppg" or "60deg".  May be given in place of a parameter: {_and(instead)}.  ends is '
        f"{', '.join(map(json.dumps, CONDITIONS))}, or two of them, the upper end first, such "
        'as "clamped-hinged".  A string of several sections has tables [[sections]] from its upper end down, each '
        "with a length and a name or a diameter, see floquetrod example string.toml, and bores such as "
        '[["0m", "4.778in"], ["1500m", "6.184in"]].  A steel pipe needs only its name, the bore (the diameter of the '
        "hole) and the length:"
    )
    return "\n".join(textwrap.wrap(text, 119, break_on_hyphens=False))


def _and(names: Sequence[str]) -> str:
    return f"{', '.join(names[:-1])} and {names[-1]}"


def add(check: Parser) -> None:
    """Add help and options of the command to its parser."""
    text = _HELP.replace("{rod_file}", rod_file_in_words())
    describe_command(check, text, _check, ("system", *ROD_AND_LOAD), has_assumptions=True)
    add_question(check, add_subject(check), friction=True)
    check.add_argument("--exit-code", action="store_true", help="exit with 1 when unstable, 3 when undecided")
    check.add_argument(
        "--modes", metavar="LIST", help="modes to check, such as 1-25 or 6,7,8 (default: all that can matter)"
    )
    check.add_argument(
        "--margins",
        action=argparse.BooleanOptionalAction,
        help="compute the margins and the damping that stabilises (default: up to "
        f"{FEW_MODES} coupled modes; under a record, of independent modes and one harmonic)",
    )
    check.add_output(
        "--out",
        figures,
        "write a figure of the shape that grows, below a measured force and its fit (.png, .pdf, .svg)",
    )
    names = ", ".join(method.name for method in METHODS if method.systems is not None)
    check.add_argument("--method", help=f"of a system: {names} (default: the first that decides)")


def _check(options: argparse.Namespace) -> Output:
    if options.system is not None:
        from floquetrod.cli import system

        system.require_alone(options)
        about_system, verdict = system.classify(options)
        return about_system._replace(status=_STATUS[verdict] if options.exit_code else 0)
    require_no_values(options)
    if options.method is not None:
        raise ValueError(
            f"--method belongs to --system, got {options.method!r} with --rod: the methods for a rod follow from its "
            "load"
        )
    modes = _modes(options.modes)
    rod, record, load, source = read_question(options)
    question = _Question(
        rod,
        record,
        load,
        source,
        modes,
        read_tolerance(options),
        read_friction(options),
        read_units(options, rod, load),
        options.margins,
    )
    result = _verdict(question)
    known = STATUS_CODES[result.linear.status] if question.modes is None else None  # a hint is about all modes
    warn_of_hertz("--frequency", options.frequency, rod, [question.load], question.tolerance, known)
    written, undrawn = _draw(question, result, options.out)
    said = _Said(result, _margins(question, result), *_sine_beside(question))
    angle, about = _grown(question, result)
    said.numbers.update(about)
    said = said._replace(grown=angle)
    if said.margins is None and options.margins is None:
        damping, rate = _damping(result)
        said.numbers.update(rate)
        left_out = result.linear.left_out
        why = f"not searched, because they would leave out {left_out}; add --margins for them" if left_out else ""
        said = said._replace(not_searched=[("margins", why or _NOT_SEARCHED), *damping])
    said.lines.extend(undrawn)
    moved, sizes = _moved(question, result)
    said.lines.extend(moved)
    said.numbers.update(sizes)
    status = _STATUS[result.status] if options.exit_code else 0
    return output(options, lambda: said.report(question.shown), said.record, status, written=written)


class _Said(NamedTuple):
    """A verdict, and the remarks beside it."""

    result: RodStability | fr.results.FrictionalRodStability
    margins: dict[Quantity, Margin] | None
    lines: list[tuple[str, str]]
    numbers: dict[str, Any]
    not_searched: Sequence[tuple[str, str]] = ()
    grown: Sequence[tuple[str, str]] = ()

    def report(self, shown: dict[str, str]) -> Report:
        """Return the report in units."""
        said = self.result.report(shown, self.margins)
        labels = [label for label, _ in said.lines]
        said = said.with_lines(self.grown, before=labels[labels.index("growth") + 1] if "growth" in labels else None)
        return said.with_lines(self.not_searched, before="checked").with_lines(self.lines)

    def record(self) -> dict[str, Any]:
        """Return the numbers."""
        return self.result.as_dict(self.margins) | self.numbers


_NOT_SEARCHED = "not searched, because this takes hundreds of verdicts; add --margins"


class _Question(NamedTuple):
    rod: fr.Rod
    force: fr.ForceRecord | None
    load: Load
    source: Load | LoadSource  # of the load: the measured force with its noise
    modes: list[int] | None
    tolerance: float
    mu_and_kick: tuple[float, float] | None
    shown: dict[str, str]
    margins: bool | None


def _verdict(question: _Question) -> RodStability | fr.results.FrictionalRodStability:
    """Return the verdict on a rod, with friction where that was asked for."""
    if question.mu_and_kick is not None:
        mu, speed = question.mu_and_kick
        with Waiting("deciding stability"):
            return question.rod.stability(
                question.load, modes=question.modes, growth_tolerance=question.tolerance, friction=mu, kick=speed
            )
    with Waiting("deciding stability", "verdicts") as progress:
        return question.rod.stability(
            question.source, modes=question.modes, growth_tolerance=question.tolerance, progress=progress
        )


def _margins(
    question: _Question, result: RodStability | fr.results.FrictionalRodStability
) -> dict[Quantity, Margin] | None:
    """Return the margins, where they were asked for, else where they take some seconds; None without.

    Of a record they do where they follow from tongues.  The verdict is said while the search takes its time.
    """
    unasked = result.has_quick_margins and (question.force is None or result.linear.has_exact_margins)
    if not (unasked if question.margins is None else question.margins):
        return None
    with Waiting(f"{result.status}; searching the margins", "percent") as progress:
        return result.margins(progress=progress)


def _damping(
    result: RodStability | fr.results.FrictionalRodStability,
) -> tuple[list[tuple[str, str]], dict[str, Any]]:
    """Return the damping that stabilises an unstable rod of few modes, whose margins were not searched."""
    if result.status != "unstable" or not result.has_quick_margins:
        return [], {}
    with Waiting("unstable; searching the damping"):
        return damping_lines(result.linear), by_keys(result.linear, "damping_to_stabilise_per_s")


def _grown(
    question: _Question, result: RodStability | fr.results.FrictionalRodStability
) -> tuple[list[tuple[str, str]], dict[str, Any]]:
    """Return about how far the mode that grows fastest moves in the end, by a tenth of a second's estimate."""
    if question.mu_and_kick is not None or result.status != "unstable":
        return [], {}
    from floquetrod.rod.large_orbits import grown

    found = grown(question.rod, question.load, result.linear)
    if found is None:
        return [], {}
    return [("grows to", found.in_words)], {"grows_to_about_rad": None if found.is_beyond else found.orbit.amplitude}


def _moved(
    question: _Question, result: RodStability | fr.results.FrictionalRodStability
) -> tuple[list[tuple[str, str]], dict[str, Any]]:
    """Return how much a stable rod moves because it is not straight."""
    if question.rod.natural_shape is None or question.mu_and_kick is not None or result.status != "stable":
        return [], {}
    from floquetrod.rod.shape_response import response as response_to

    known = result.linear if question.modes is None and question.tolerance == 0.0 and question.force is None else None
    try:
        response = response_to(question.rod._modes_under(question.load), question.load, verdict=known)
    except ValueError as error:
        return [("moves", f"unknown: {error}")], {"moves_m": None}
    return [("moves", f"{response.in_words(question.shown)}, because of its natural shape")], {
        "moves_m": response.largest
    }


def _sine_beside(question: _Question) -> tuple[list[tuple[str, str]], dict[str, Any]]:
    """Return what a measured force adds: its fit, and the verdict on a sine of the same amplitude."""
    if question.force is None or question.mu_and_kick is not None:
        return [], {}
    with Waiting("comparing with a sine"):
        sine = _sine(question)
    shown = shown_in(question.shown, question.rod)
    without_noise = ", without noise" if question.load.noise else ""
    lines = [
        ("sine", f"of the same mean, amplitude and frequency{without_noise}: {sine.status}{_growing(sine)}"),
        ("record", question.force._beside_in_words(question.load, shown["force"], shown["frequency"])),
    ]
    numbers = {
        "force_record": question.force.as_dict() | {"noise_in_error": True},
        "sine_of_the_same_amplitude": {"status": sine.status, "growth_rate_per_s": sine.growth_rate},
    }
    return lines, numbers


def _sine(question: _Question) -> RodStability:
    """Return the verdict on the load without its higher harmonics, its noise and its second sine."""
    sine: Load = replace(question.load, waveform="sine", noise=0.0)
    if isinstance(sine, AxialLoad):
        sine = replace(sine, second=None)
    return question.rod.stability(sine, growth_tolerance=question.tolerance)


def _growing(verdict: RodStability) -> str:
    return f", {verdict.growth_rate:.6g} 1/s" if verdict.growth_rate > 0.0 else ""


def _draw(
    question: _Question, result: RodStability | fr.results.FrictionalRodStability, paths: Sequence[Path]
) -> tuple[list[str], list[tuple[str, str]]]:
    """Draw a measured force and the shape that grows into files; return their names, or why there is no shape."""
    if not paths:
        return [], []
    from floquetrod.plotting.record_plot import draw_record, draw_record_and_shape

    record, force = question.force, shown_in(question.shown, question.rod)["force"]
    try:
        drawn = result.plot() if record is None else draw_record_and_shape(record, result, force)
    except ValueError as error:
        undrawn = [("shape", f"not drawn: {error}")]
        return ([] if record is None else write_figures(paths, lambda: draw_record(record, None, force)[0])), undrawn
    return write_figures(paths, lambda: drawn), []


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
