"""A verdict on a rod, and how far its string can be pushed, as a document to pass on."""

from __future__ import annotations

import datetime
import functools
import inspect
import math
import platform
import re
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import UnionType
from typing import Any, NamedTuple

from floquetrod._util import validate
from floquetrod._util.plausibility_warning import PlausibilityWarning
from floquetrod._util.progress import Progress
from floquetrod._util.result_report import Report, Reported, Table
from floquetrod._util.version import __version__
from floquetrod.floquet.equation_margins import charted_ranges, damping_in_words, in_one_line, margins_in_words
from floquetrod.floquet.references import ROD as ROD_REFERENCES
from floquetrod.floquet.references import references
from floquetrod.floquet.verdict import Stability
from floquetrod.plane import Chart
from floquetrod.plotting import chart_plot, document, reach_plot
from floquetrod.plotting.document import Document, DocumentSection, Illustration
from floquetrod.plotting.record_plot import draw_record
from floquetrod.rod.answers.evidence import NoisyCoupledEvidence, TwoFrequencyCoupledEvidence, TwoFrequencyEvidence
from floquetrod.rod.answers.reports import answer_units, load_lines, shown_in
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.answers.steady_motion import SteadyMotion
from floquetrod.rod.answers.string_reach import Reach, frequency_table
from floquetrod.rod.large_orbits import grown
from floquetrod.rod.loads.record import ForceRecord
from floquetrod.rod.model.assumptions import IMMERSED, SHAPE, UniformForceWarning
from floquetrod.rod.model.data import RodData, UniformPart
from floquetrod.rod.model.parameters import ROD
from floquetrod.rod.model.rod_in_words import size_in_words, table_of_parts
from floquetrod.rod.stability_map import stability_map
from floquetrod.systems import family_charts
from floquetrod.units import AnswerUnits, Unit, unit
from floquetrod.wells.path import WellPath

_POINTS = {True: (160, 120), False: (64, 48)}  # of the map, where bands are exact and where loads take milliseconds
_MAP_SECONDS, _FEWEST = 10.0, 12  # a map may take, and the fewest rows of one (a choice)
_STEEP = 0.25 * math.pi  # inclination in rad up to which criteria of vertical wells are told (a choice)
_NO_ROW = ("path", "sections", "bores")  # parameters that are told in words
_ROOM = 1.25  # about the load, in terms of it


def save_report(
    result: Reported,
    path: str | Path,
    *,
    reach: Reach | None = None,
    motion: SteadyMotion | None = None,
    record: ForceRecord | None = None,
    units: Mapping[str, str] | None = None,
    margins: bool | None = None,
    command: str = "",
    project: str = "",
    files: Mapping[str, str | Path] | None = None,
    progress: Progress | None = None,
) -> Path:
    """Write a report on a result into one file, HTML or PDF.

    For most results their text and figure.  For a verdict on a rod and for a reach one report: what was asked about,
    that is rod, load, well, friction, tool and files; the verdict in a box; margins, and about how large the motion
    becomes; a map about the load; how far the string can be pushed, with its forces, stress and waves; constant forces
    at which the rod buckles by the literature; the assumptions; versions and the command that makes the report again.
    For a verdict on Mathieu's equation or Meissner's also the damping that stabilises it, the forcing that changes it,
    and a chart with the equation in it.

    Parameters
    ----------
    result : RodStability, a chart, or another result with a ``report()``
        The result of ``rod.stability(load)``, or, for example, `Reach`, `SteadyMotion`, `PeriodicOrbit`, `SafeBox`,
        `Proof`.  The options from ``reach`` to ``margins`` are about verdicts on rods, ``units`` about a `Reach`, too.
    path : str or path
        Ends in .html, a page with its figures inside, or .pdf.  It is written completely or not at all.
    reach : Reach, optional
        The result of ``rod.reach``, to be included.
    motion : SteadyMotion, optional
        The result of ``rod.steady_motion(load)``, which takes some seconds: the size of the motion with all modes, and
        its effect on the rod.
    record : ForceRecord, optional
        The measured force that the verdict is about, to be drawn with its fit.
    units : mapping, optional
        In which to show load, forces, lengths and pressures, as in ``verdict.report``; the reach too.
    margins : bool, optional
        Whether to search the margins; by default where they take some seconds at most.
    command : str
        The command that makes the file again; by default none is named.
    project : str
        What the report is for, which it says below its title, beside the date.
    files : mapping, optional
        Files of the question by what they hold, such as ``{"survey": "well 7.csv"}``.
    progress : callable, optional
        Of the margins, as in ``verdict.margins``.

    Returns
    -------
    Path

    Raises
    ------
    ValueError, TypeError
        For other endings; for a ``result`` without a report; for a ``reach``, ``motion`` or ``record`` of another
        type.

    Examples
    --------
    >>> import floquetrod as fr
    >>> verdict = fr.Rod.nitinol().stability(fr.AxialLoad(0.34, 0.34, 150.0))
    >>> fr.save_report(verdict, "report.html", units={"mean": "Fcr", "frequency": "Hz"}).name  # doctest: +SKIP
    'report.html'
    """
    what = "a result with a report, such as what rod.stability returned, or a chart"
    _require("result", result, Reported | Chart, what)
    if reach is not None:
        _require("reach", reach, Reach, "what rod.reach returned")
    if motion is not None:
        _require("motion", motion, SteadyMotion, "what rod.steady_motion returned")
    if record is not None:
        _require("record", record, ForceRecord, "what fr.ForceRecord.from_csv returned")
    if margins is not None:
        validate.flag("margins", margins)
    validate.instance("command", command, str, "leave it out where there is none")
    validate.instance("project", project, str, "the name of a job, say")
    if files is not None and not isinstance(files, Mapping):
        raise validate.wrong_type("files", f"must be such as {{'survey': 'well.csv'}}, got {validate.short(files)}")
    validate.progress(progress)
    options = _Options(reach, motion, record, units, margins, command, project, dict(files or {}), progress)
    return document.save(document.checked_path(path), _document(result, options))


class _Options(NamedTuple):
    """What a document shall hold: the options of `save_report`."""

    reach: Reach | None
    motion: SteadyMotion | None
    record: ForceRecord | None
    units: Mapping[str, str] | None
    margins: bool | None
    command: str
    project: str
    files: Mapping[str, str | Path]
    progress: Progress | None

    @property
    def of_reach(self) -> dict[str, str]:
        """The units that were asked for, as `Reach.report` and `Reach.plot` take them."""
        kinds = {"length": "depth", "force": "force", "pressure": "pressure", "frequency": "frequency"}
        return {kinds[name]: unit for name, unit in (self.units or {}).items() if name in kinds}


def _require(name: str, value: Any, kind: type | UnionType, what: str) -> None:
    if not isinstance(value, kind):
        raise validate.wrong_type(name, f"must be {what}, got {validate.short(value)}")


@functools.singledispatch
def _document(result: Any, options: _Options) -> Document:
    """Return the document about a result."""
    takes_units = "units" in inspect.signature(result.report).parameters
    if options.units is not None and not takes_units:
        raise validate.wrong_value("units", f"must be left out, since a {type(result).__name__} has a report without")
    report = result.report(options.units) if takes_units else result.report()
    illustrations = [Illustration(functools.partial(_plot, result), report.headline)] if hasattr(result, "plot") else []
    sections = [
        *_files(options),
        DocumentSection("Answer", replace(report, headline="").with_assumptions(), illustrations),
        _made(getattr(result, "references", ()), options),
    ]
    title = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", type(result).__name__).capitalize()
    return Document(title, _about(options), [_sentence(report.headline or repr(result)[1:-1])], sections)


@_document.register
def _(result: Stability, options: _Options) -> Document:
    if options.units is not None:
        raise validate.wrong_value("units", "must be left out, since an equation has none")
    nearest, *others = [*margins_in_words(result), ""]
    changes = [("damping", damping_in_words(result)), ("margins", nearest), *(("", text) for text in others)]
    report = result.report().with_lines([(label, text) for label, text in changes if text], before="trace")
    answer = DocumentSection("Answer", replace(report, headline="").with_assumptions(), _chart_about(result))
    sections = [*_files(options), answer, _made(result.references, options)]
    return Document("Stability of an equation", _about(options), [in_one_line(result)], sections)


@_document.register
def _(result: Chart, options: _Options) -> Document:
    if options.units is not None:
        raise validate.wrong_value("units", "must be left out: a chart has the units of its ranges, or chart.in_units")
    drawn = Illustration(functools.partial(_plot, result), f"{_sentence(result.heading)}: the chart.")
    sections = [*_files(options), DocumentSection("Answer", None, [drawn]), _made((), options)]
    return Document("Chart of stability", _about(options), [_sentence(repr(result)[1:-1])], sections)


@_document.register
def _(result: Reach, options: _Options) -> Document:
    shown = answer_units(shown_in(options.units, result.rod, result))
    inputs = [_string_data(result.rod, shown), _well(result, options)]
    sections = [
        DocumentSection("Inputs", _joined([*inputs, *_file_reports(options)])),
        *_reach(result, options),
        _buckling(_level(result.rod), shown, is_vertical=_is_steep(result.path)),
        _assumed([*SHAPE, *(IMMERSED if any(result.fluids) else ())], result, shown),
        _made(references(ROD_REFERENCES), options),
    ]
    return Document("Reach of a string", _about(options), [_sentence(_of_reach(result, options).headline)], sections)


@_document.register
def _(result: RodStability, options: _Options) -> Document:
    shown = shown_in(options.units, result.rod, result.load)
    units, reach = answer_units(shown), options.reach
    report = _verdict(result, options)
    of_load = Report("Load", _load(result, shown, options))
    of_well = [] if reach is None else [_well(reach, options)]
    verdict = [_sentence(report.headline)]
    verdict += [] if reach is None else [_sentence(_of_reach(reach, options).headline)]
    is_vertical = result.rod.inclination < _STEEP or (reach is not None and _is_steep(reach.path))
    sections = [
        DocumentSection("Inputs", _joined([_rod_data(result.rod, units), of_load, *of_well, *_file_reports(options)])),
        DocumentSection("Stability", replace(report, headline=""), [*_shape(result), *_map(result, shown)]),
        *_measured(shown, options),
        *_motion(options),
        *([] if reach is None else _reach(reach, options)),
        _buckling(result.rod, units, result, is_vertical=is_vertical),
        _assumed(result.assumptions, reach, units),
        _made(result.references, options),
    ]
    return Document("Stability of a rod", _about(options), verdict, sections)


# --- what was asked about ---


def _about(options: _Options) -> list[str]:
    """Return the project, where one was given, and the date."""
    today = datetime.date.today()
    return [*filter(None, [options.project]), f"{today.day} {today:%B %Y}", f"floquetrod {__version__}"]


def _sentence(text: str) -> str:
    """Return a text with a capital letter."""
    return text[:1].upper() + text[1:]


def _joined(reports: Sequence[Report]) -> Report:
    """Return reports one after the other."""
    first, *others = reports
    return replace(first, rest=_joined(others)) if others else first


def _load(verdict: RodStability, shown: Mapping[str, Unit], options: _Options) -> list[tuple[str, str]]:
    """Return the load, and the fit of the measured force."""
    lines = [("force" * bool(name), text) for name, text in load_lines(verdict.load, shown, verdict.rod)]
    if options.record is None:
        return lines
    return [*lines, ("record", options.record._beside_in_words(verdict.load, shown["force"], shown["frequency"]))]


def _rod_data(rod: RodData, units: AnswerUnits) -> Report:
    """Return what the rod is, parameter by parameter, with its sections in a table."""
    values = rod.as_dict()
    lines = _sections(rod, units) + [_row(name, values[name], units) for name in values if name not in _NO_ROW]
    if rod.path is not None:
        lines.append(("path", rod.path.in_words(units.length)))
    return Report("Rod", _with_weight(lines, rod, units), table_of_parts(rod, units))


def _string_data(rod: RodData, units: AnswerUnits) -> Report:
    """Return what the string is, without what it has from its well."""
    lines = [
        _row(name, value, units)
        for name, value in rod.as_dict().items()
        if name not in _NO_ROW and "strings" not in ROD[name].without_effect_on
    ]
    return Report("String", _sections(rod, units) + _with_weight(lines, rod, units), table_of_parts(rod, units))


def _with_weight(lines: list[tuple[str, str]], rod: RodData, units: AnswerUnits) -> list[tuple[str, str]]:
    """Return parameters with, below the density, the mass per length that follows: what a pipe is known by."""
    labels = [label for label, _ in lines]
    if "density" not in labels:  # of several sections
        return lines
    after = labels.index("density") + 1
    weight = ("weight in air", units.mass_per_length.show(rod.material.density * rod.area, 4))
    return [*lines[:after], weight, *lines[after:]]


def _sections(rod: RodData, units: AnswerUnits) -> list[tuple[str, str]]:
    """Return a line about sections and bores; none of a uniform rod."""
    return [("sections", size_in_words(rod, units))] if rod.sections or rod.bores else []


def _row(name: str, value: Any, units: AnswerUnits) -> tuple[str, str]:
    """Return the name and the value of a parameter, diameters in mm and in, as in catalogues."""
    words, shown = ROD[name].in_words(value, units)
    words = words.replace("youngs", "Young's")
    if ROD[name].is_shown_as_diameter:
        other = unit("mm" if units.across.name == "in" else "in", name, "length")
        return words, f"{shown} ({other.show(2.0 * value, 4)})"
    return words, shown


def _well(reach: Reach, options: _Options) -> Report:
    """Return the well, friction, limits and the tool."""
    shown = _reach_units(reach, options)
    lines = [("path", reach.path.in_words(shown.length)), ("friction", reach.friction.in_words(shown.length))]
    push = shown.force.show(reach.push, 4) if math.isfinite(reach.push) else "any"
    lines += [("greatest push", push), ("force at the lower end", shown.force.show(reach.far_force, 4))]
    if reach.yield_share is not None and reach.yield_strength is not None:
        lines.append(("largest stress", f"{100.0 * reach.yield_share:.3g} % of the yield strength"))
    lines += [line for line in reach.report(**options.of_reach).lines if line[0] == "wellhead"]
    if reach.tool is not None:
        lines.append(("vibration tool", reach.tool.in_words(shown)))
        lines.append(("speed of sliding", shown.speed.show(reach.sliding, 3)))
    return Report("Well", lines)


def _reach_units(reach: Reach, options: _Options) -> AnswerUnits:
    """Return the units in which a reach is told."""
    asked = (options.units or {}).get
    return AnswerUnits.named(
        asked("force"),
        asked("length"),
        asked("pressure"),
        asked("frequency"),
        given=reach.given_units,
        usual_force="kN",
    )


def _file_reports(options: _Options) -> list[Report]:
    lines = [(name, str(path)) for name, path in options.files.items()]
    return [Report("Files", lines)] if lines else []


def _files(options: _Options) -> list[DocumentSection]:
    return [DocumentSection("Inputs", report) for report in _file_reports(options)]


# --- answers ---


def _verdict(verdict: RodStability, options: _Options) -> Report:
    """Return the lines on a verdict beside rod, load and assumptions."""
    searched = verdict.has_quick_margins if options.margins is None else options.margins
    report = verdict.report(options.units, verdict.margins(progress=options.progress) if searched else None)
    if verdict.rod.varies:  # whose sections are among the inputs
        report = replace(report, table=None)
    large = grown(verdict.rod, verdict.load, verdict)
    if large is not None:
        report = report.with_lines([("grows to", large.in_words)], before="margins" if searched else "checked")
    return _without(report, "load", "assumed", "stress")


def _without(report: Report, *labels: str) -> Report:
    """Return a report without some of its lines, and those that continue them."""
    kept, last = [], ""
    for label, text in report.lines:
        last = label or last
        if last not in labels:
            kept.append((label, text))
    return replace(report, lines=kept, assumptions=())


def _shape(verdict: RodStability) -> list[Illustration]:
    """Return the figure of the shape in which coupled modes grow."""
    if verdict.evidence.has_exact_margins or not verdict.resonances:
        return []
    caption = "Shape along the rod in which motion grows: at one instant, and its envelope over a period."
    return [Illustration(lambda figure: verdict.plot(figure.subplots()), caption, 0.5)]


def _chart_about(verdict: Stability) -> list[Illustration]:
    """Return the chart about an equation, over its forcing and its mean; none where it has no such numbers."""
    equation = verdict.equation
    ranges = charted_ranges(equation)
    if not ranges:
        return []

    def draw(figure: Any) -> Any:
        over = {name: (*ends, number) for (name, ends), number in zip(ranges.items(), _POINTS[False], strict=True)}
        axes = family_charts.chart(functools.partial(replace, equation), over).plot(figure.subplots())
        x, y = (getattr(equation, name) for name in ranges)
        chart_plot.mark(axes, x, y, "the equation")

    damped = f", with the damping {equation.damping:g}" if equation.damping else ""
    words = " and ".join(ranges)
    return [Illustration(draw, f"The equation among others with other {words}{damped}: unstable where coloured.")]


def _points(verdict: RodStability) -> tuple[int, int]:
    """Return columns and rows of the map, fewer where a verdict takes long."""
    evidence, (columns, rows) = verdict.evidence, _POINTS[verdict.evidence.has_exact_margins]
    if not isinstance(evidence, NoisyCoupledEvidence | TwoFrequencyEvidence | TwoFrequencyCoupledEvidence):
        return columns, rows
    share = min(1.0, math.sqrt(_MAP_SECONDS / (columns * rows * evidence.seconds)))
    return int(share * columns), int(share * rows)


def _map(verdict: RodStability, shown: Mapping[str, Unit]) -> list[Illustration]:
    """Return the map about the load.

    None where it would take long, and without vibration, whose stability no frequency changes.
    """
    rod: Any = verdict.rod
    load = verdict.load
    if load.amplitude == 0.0:
        return []
    columns, rows = _points(verdict)
    if rows < _FEWEST:
        return []
    largest = _ROOM * max(rod.critical_force, abs(load.mean))

    def draw(figure: Any) -> Any:
        with warnings.catch_warnings():  # which are about other loads than the one that was asked about
            warnings.simplefilter("ignore", UniformForceWarning)
            warnings.simplefilter("ignore", PlausibilityWarning)
            chart = stability_map(
                rod,
                load,
                mean=(min(0.0, _ROOM * load.mean), largest, rows),
                frequency=(0.4 * load.frequency, 1.8 * load.frequency, columns),
                amplitude=load.amplitude,
                growth_tolerance=verdict.growth_tolerance,
            ).in_units(mean=shown["mean"].name, frequency=shown["frequency"].name, amplitude=shown["amplitude"].name)
        axes = chart.plot(figure.subplots(), bands=verdict.evidence.has_exact_margins)
        chart_plot.mark(axes, shown["frequency"].of(load.frequency), shown["mean"].of(load.mean), "the load")

    caption = (
        "Other mean forces and frequencies, with this amplitude: where the rod is stable and where some mode grows."
    )
    return [Illustration(draw, caption)]


def _measured(shown: Mapping[str, Unit], options: _Options) -> list[DocumentSection]:
    """Return the figure of the measured force."""
    record = options.record
    if record is None:
        return []
    caption = "Measured force and its fit over the first periods; below its spectrum, the harmonics kept and the noise."
    drawn = Illustration(lambda figure: draw_record(record, figure.subplots(2, 1), shown["force"]), caption, 0.7)
    return [DocumentSection("Measured force", None, [drawn])]


def _motion(options: _Options) -> list[DocumentSection]:
    if options.motion is None:
        return []
    return [DocumentSection("Motion after the onset", options.motion.report(options.units).with_assumptions())]


def _buckling(
    rod: RodData, units: AnswerUnits, verdict: RodStability | None = None, *, is_vertical: bool
) -> DocumentSection:
    """Return constant forces at which the literature has the rod buckle, those that apply, and the stress of a load."""
    parts = {_name_of(part, rod, units): part.rod for part in rod.uniform_parts}
    forces: dict[str, Any] = {}
    unknown: list[tuple[str, str]] = []
    try:
        for which, part in parts.items():
            forces |= {f"{name}{which}": force for name, force in part.critical_forces.items()}
    except ValueError as error:  # the rod has a parameter that they do not know
        forces, unknown = {}, [("buckling", str(error))]
    mean = None if verdict is None else verdict.load.mean
    rows = [
        (name, units.force.show(force, 4), *([] if mean is None else [f"{mean / force:.3g}"]), f"{meaning} ({source})")
        for name, (force, meaning, source) in forces.items()
        if is_vertical or not name.startswith("vertical")
    ]
    share = [] if mean is None else [("mean / force", ">12")]
    width = max((len(name) for name in forces), default=16)
    table = Table((("buckling", f"<{width}"), ("force", ">12"), *share, ("meaning", "<1")), rows) if rows else None
    lines = list(unknown)
    if verdict is not None:
        lines.append(("stress", verdict.rod.stress(verdict.load).in_words(units.pressure)))
        if rod.yield_strength is None:
            lines.append(("", "the yield strength is not known"))
        lines.append(("", "before the rod moves; pressures inside and outside taken as equal"))
    title = "Constant forces" if verdict is None else "Constant forces and stress"
    return DocumentSection(f"{title}{' where the well is level' if verdict is None else ''}", Report("", lines, table))


def _name_of(part: UniformPart, rod: RodData, units: AnswerUnits) -> str:
    """Return how buckling of a part of a string is told apart: by its section, its bore or both."""
    section = f", section {part.section + 1}" if rod.sections[1:] else ""
    bore = f", bore {units.across.show(2.0 * part.rod.channel_radius, 4)}" if rod.bores[1:] else ""
    return section + bore


def _level(rod: RodData) -> RodData:
    """Return a rod where the well is level, as criteria of buckling are told for a string."""
    return rod if rod.path is not None else rod.replace(inclination=0.5 * math.pi, curvature=0.0)


def _is_steep(path: WellPath) -> bool:
    """Return whether a well is anywhere nearer to the vertical than to the horizontal."""
    return bool(path.inclination.min() < _STEEP)


def _of_reach(reach: Reach, options: _Options) -> Report:
    """Return the lines on a reach beside well, tool and assumptions."""
    return _without(reach.report(**options.of_reach), "assumed", "wellhead")


def _reach(reach: Reach, options: _Options) -> list[DocumentSection]:
    """Return how far the string can be pushed, what stops it, and its forces, stress and waves."""
    shown, has_tool = _reach_units(reach, options), bool(reach.tool)
    tool = " with the tool" if has_tool else ""

    def answer(figure: Any) -> Any:
        return reach_plot.draw_reach(reach, shown, "", figure)

    both = ", without the tool and with it" if has_tool else ""
    illustrations = [
        Illustration(
            answer,
            f"Force at the surface over the depth of the lower end{both}; force and stress in the string, pushed as "
            f"far as it goes{tool}.",
            1.1,
        ),
        _drawn(reach_plot.draw_well, reach, shown, "The well from its side, with the string as far as it goes.", 0.48),
        _drawn(
            reach_plot.draw_lower_end,
            reach,
            shown,
            f"Largest force that arrives at the lower end, the upper end pushed as hard as allowed{both}.",
            0.45,
        ),
        _drawn(
            reach_plot.draw_wall, reach, shown, f"Contact with the wall, and friction along the string{tool}.", 0.52
        ),
    ]
    if has_tool:
        caption = "Growth of lateral waves along the string, and the fastest growth with other frequencies of the tool."
        illustrations.append(_drawn(reach_plot.draw_growth, reach, shown, caption, 0.72))
    sections = [DocumentSection("Reach", replace(_of_reach(reach, options), headline=""), illustrations)]
    table = frequency_table(reach, shown)
    return sections + ([] if table is None else [DocumentSection("Frequencies of the tool", Report("", [], table))])


def _drawn(draw: Any, reach: Reach, shown: AnswerUnits, caption: str, height: float) -> Illustration:
    """Return a figure of a reach."""
    return Illustration(lambda figure: draw(reach, shown, figure), caption, height)


def _plot(result: Any, figure: Any) -> Any:
    """Draw a result of any kind into a figure."""
    if "figure" in inspect.signature(result.plot).parameters:
        return result.plot(figure)
    return result.plot(figure.subplots())


# --- what holds ---


def _assumed(assumptions: Sequence[str], reach: Reach | None, units: AnswerUnits) -> DocumentSection:
    """Return the assumptions of the verdict and the reach, each with its limit."""
    rows = [(str(text), getattr(text, "limit", "")) for text in assumptions]
    if reach is not None:
        rows += [(text, "") for text in reach.assumptions_in(units.speed)]
    lines = [(f"{k}", f"{_sentence(text)}{f' ({limit})' if limit else ''}.") for k, (text, limit) in enumerate(rows, 1)]
    return DocumentSection("Assumptions, and their limits", Report("", lines))


def _made(references: Iterable[str], options: _Options) -> DocumentSection:
    lines = [("made by", f"floquetrod {__version__}, Python {platform.python_version()}")]
    lines += [("again", options.command)] if options.command else []
    lines += [("cite" if i == 0 else "", text) for i, text in enumerate(references)]
    return DocumentSection("How this was made", Report("", lines))
