"""A verdict on a rod, and how far its string can be pushed, as a document to pass on."""

from __future__ import annotations

import functools
import inspect
import platform
import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from floquetrod._util import validate
from floquetrod._util.plausibility_warning import PlausibilityWarning
from floquetrod._util.progress import Progress
from floquetrod._util.result_report import Report, Reported, Table
from floquetrod._util.version import __version__
from floquetrod.plotting import chart_plot, document
from floquetrod.plotting.document import DocumentSection
from floquetrod.rod.answers.reports import answer_units, shown_in
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.answers.steady_motion import SteadyMotion
from floquetrod.rod.answers.string_reach import Reach
from floquetrod.rod.large_orbits import grown
from floquetrod.rod.model.assumptions import Assumption, UniformForceWarning
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.parameters import ROD
from floquetrod.rod.stability_map import stability_map
from floquetrod.units import AnswerUnits, Unit, unit

_POINTS = {True: (160, 120), False: (64, 48)}  # of the map, where bands are exact and where loads take milliseconds
_ROOM = 1.25  # about the load, in terms of it


def save_report(
    result: Reported,
    path: str | Path,
    *,
    reach: Reach | None = None,
    motion: SteadyMotion | None = None,
    units: Mapping[str, str] | None = None,
    margins: bool | None = None,
    command: str = "",
    progress: Progress | None = None,
) -> Path:
    """Write a report on a result into one file, HTML or PDF.

    For most results their text and figure.  For a verdict on a rod more: rod, load and verdict with margins, and about
    how large the motion becomes; a map about the load; constant forces at which the rod buckles by the literature, and
    the stress; how far its string can be pushed; the assumptions; versions and the command that makes the report again.

    Parameters
    ----------
    result : RodStability or another result with a ``report()``
        The result of ``rod.stability(load)``, or, for example, `Reach`, `SteadyMotion`, `PeriodicOrbit`, `SafeBox`,
        `Proof`.  The options from ``reach`` to ``margins`` are about verdicts on rods, ``units`` about a `Reach`, too.
    path : str or path
        Ends in .html, a page with its figures inside, or .pdf.  It is written completely or not at all.
    reach : Reach, optional
        The result of ``rod.reach``, to be included.
    motion : SteadyMotion, optional
        The result of ``rod.steady_motion(load)``, which takes some seconds: the size of the motion with all modes, and
        its effect on the rod.
    units : mapping, optional
        In which to show load, forces, lengths and pressures, as in ``verdict.report``; the reach too.
    margins : bool, optional
        Whether to search the margins; by default where they take some seconds at most.
    command : str
        The command that makes the file again; by default the expression in Python.
    progress : callable, optional
        Of the margins, as in ``verdict.margins``.

    Returns
    -------
    Path

    Raises
    ------
    ValueError, TypeError
        For other endings; for a ``result`` without a report; for a ``reach`` or ``motion`` of another type.

    Examples
    --------
    >>> import floquetrod as fr
    >>> verdict = fr.Rod.nitinol().stability(fr.AxialLoad(0.34, 0.34, 150.0))
    >>> fr.save_report(verdict, "report.html", units={"mean": "Fcr", "frequency": "Hz"}).name  # doctest: +SKIP
    'report.html'
    """
    _require("result", result, Reported, "a result with a report, such as what rod.stability returned")
    if reach is not None:
        _require("reach", reach, Reach, "what rod.reach returned")
    if motion is not None:
        _require("motion", motion, SteadyMotion, "what rod.steady_motion returned")
    if margins is not None:
        validate.flag("margins", margins)
    validate.instance("command", command, str, "leave it out for the expression in Python")
    validate.progress(progress)
    return document.save(path, *_contents(result, _Asked(reach, motion, units, margins, command, progress)))


class _Asked(NamedTuple):
    """What a document shall hold: the options of `save_report`."""

    reach: Reach | None
    motion: SteadyMotion | None
    units: Mapping[str, str] | None
    margins: bool | None
    command: str
    progress: Progress | None


@functools.singledispatch
def _contents(result: Any, asked: _Asked) -> tuple[str, list[DocumentSection]]:
    """Return the title and the sections of a document about a result."""
    takes_units = "units" in inspect.signature(result.report).parameters
    if asked.units is not None and not takes_units:
        raise validate.wrong_value("units", f"must be left out, since a {type(result).__name__} has a report without")
    said = result.report(asked.units) if takes_units else result.report()
    drawn = DocumentSection(type(result).__name__, said.with_assumptions(), getattr(result, "plot", None))
    return repr(result)[1:-1], [drawn, _made(getattr(result, "references", ()), asked.command)]


@_contents.register
def _(result: Reach, asked: _Asked) -> tuple[str, list[DocumentSection]]:
    (section,) = _reach(result, asked.units)
    said = Report("") if section.report is None else section.report.with_assumptions()
    return said.headline, [section._replace(report=said), _made((), asked.command)]


@_contents.register
def _(result: RodStability, asked: _Asked) -> tuple[str, list[DocumentSection]]:
    shown = shown_in(asked.units, result.rod, result.load)
    return f"Stability of a rod: {result.status}", [
        _verdict(result, asked),
        _data(result.rod, answer_units(shown)),
        *_map(result, shown),
        *_motion(asked.motion, asked.units),
        _statics(result, answer_units(shown)),
        *_reach(asked.reach, asked.units),
        _assumed(result, asked.reach, answer_units(shown)),
        _made(result.references, asked.command or f"{result.rod!r}.stability({result.load!r})"),
    ]


def _require(name: str, value: Any, kind: type, what: str) -> None:
    if not isinstance(value, kind):
        raise validate.wrong_type(name, f"must be {what}, got {validate.short(value)}")


def _verdict(verdict: RodStability, asked: _Asked) -> DocumentSection:
    searched = verdict.has_quick_margins if asked.margins is None else asked.margins
    said = verdict.report(asked.units, verdict.margins(progress=asked.progress) if searched else None)
    large = grown(verdict.rod, verdict.load, verdict)
    if large is not None:
        said = said.with_lines([("grows to", large.in_words)], before="margins" if searched else "checked")
    shape = None if verdict.evidence.has_exact_margins or not verdict.resonances else verdict.plot
    return DocumentSection("Verdict", said, shape)


def _data(rod: RodData, units: AnswerUnits) -> DocumentSection:
    """Return what the rod is, parameter by parameter."""
    rows = [_row(name, value, units) for name, value in rod.as_dict().items()]
    return DocumentSection("The rod", Report("", (), Table((("parameter", "<24"), ("value", "<1")), rows)))


def _row(name: str, value: Any, units: AnswerUnits) -> tuple[str, str]:
    """Return the name and the value of a parameter, diameters in mm and in, as in catalogues."""
    words, shown = ROD[name].in_words(value, units)
    if ROD[name].is_shown_as_diameter:
        other = unit("mm" if units.across.name == "in" else "in", name, "length")
        return words, f"{shown} ({other.show(2.0 * value)})"
    return words, shown


def _map(verdict: RodStability, shown: Mapping[str, Unit]) -> list[DocumentSection]:
    """Return the map about the load; none without vibration, whose stability no frequency changes."""
    rod: Any = verdict.rod
    load = verdict.load
    if load.amplitude == 0.0:
        return []
    columns, rows = _POINTS[verdict.evidence.has_exact_margins]
    largest = _ROOM * max(rod.critical_force, abs(load.mean))

    def draw() -> Any:
        with warnings.catch_warnings():  # which are about other loads than the one that was asked about
            warnings.simplefilter("ignore", UniformForceWarning)
            warnings.simplefilter("ignore", PlausibilityWarning)
            return drawn()

    def drawn() -> Any:
        chart = stability_map(
            rod,
            load,
            mean=(min(0.0, _ROOM * load.mean), largest, rows),
            frequency=(0.4 * load.frequency, 1.8 * load.frequency, columns),
            amplitude=load.amplitude,
            growth_tolerance=verdict.growth_tolerance,
        ).in_units(mean=shown["mean"].name, frequency=shown["frequency"].name, amplitude=shown["amplitude"].name)
        axes = chart.plot(bands=verdict.evidence.has_exact_margins)
        chart_plot.mark(axes, shown["frequency"].of(load.frequency), shown["mean"].of(load.mean), "the load")
        return axes

    return [DocumentSection("Other mean forces and frequencies", None, draw)]


def _motion(motion: SteadyMotion | None, units: Mapping[str, str] | None) -> list[DocumentSection]:
    return [] if motion is None else [DocumentSection("Motion after the onset", motion.report(units))]


def _statics(verdict: RodStability, units: AnswerUnits) -> DocumentSection:
    """Return forces that buckle the rod without vibration, and the stress."""
    rod, load = verdict.rod, verdict.load
    try:
        forces, unknown = rod.critical_forces, []
    except ValueError as error:  # the rod has a parameter that they do not know
        forces, unknown = {}, [("buckling", str(error))]
    rows = [
        (name, units.force.show(force, 5), f"{load.mean / force:.3g}", f"{meaning} ({source})")
        for name, (force, meaning, source) in forces.items()
    ]
    table = Table((("buckling", "<16"), ("force", ">12"), ("mean / force", ">12"), ("meaning", "<1")), rows)
    lines = [*unknown, ("stress", rod.stress(load).in_words(units.pressure))]
    if rod.yield_strength is None:
        lines.append(("", "the yield strength is not known: give Rod(yield_strength=) or a grade"))
    lines.append(("", "before the rod moves; pressures inside and outside taken as equal"))
    return DocumentSection("Constant forces and stress", Report("", lines, table))


def _reach(reach: Reach | None, asked: Mapping[str, str] | None) -> list[DocumentSection]:
    """Return how far the string can be pushed, in the units asked for and else its own."""
    if reach is None:
        return []
    kinds = {"length": "depth", "force": "force", "pressure": "pressure", "frequency": "frequency"}
    named = {kinds[name]: unit for name, unit in (asked or {}).items() if name in kinds}
    return [DocumentSection("Reach", reach.report(**named), functools.partial(reach.plot, **named))]


def _assumed(verdict: RodStability, reach: Reach | None, units: AnswerUnits) -> DocumentSection:
    """Return the assumptions of the verdict and the reach, each with its limit."""
    listed = []
    for text in verdict.assumptions:
        listed += [("", f"- {text}"), *([("", f"    {text.limit}")] if isinstance(text, Assumption) else [])]
    if reach is not None:
        listed += [("", f"- reach: {text}") for text in reach.assumptions_in(units.speed)]
    return DocumentSection("Assumptions, and their limits", Report("", listed))


def _made(references: Iterable[str], again: str) -> DocumentSection:
    lines = [("made by", f"floquetrod {__version__}, Python {platform.python_version()}")]
    lines += [("again", again)] if again else []
    lines += [("cite" if i == 0 else "", text) for i, text in enumerate(references)]
    return DocumentSection("How this was made", Report("", lines))
