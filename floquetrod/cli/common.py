"""What the commands share: quantities with units, the rod, files, warnings."""

from __future__ import annotations

import argparse
import logging
import math
import os
import re
import shlex
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import floquetrod as fr
from floquetrod import units
from floquetrod._util.arguments import argument_of, wrong_value
from floquetrod._util.suggest import did_you_mean
from floquetrod._util.waiting import Waiting, say
from floquetrod.cli.messages import option
from floquetrod.cli.parser import POINTS, Parser, ratio
from floquetrod.rod.model.parameters import GIVEN, INSTEAD, OF_A_SECTION, units_given

if TYPE_CHECKING:
    from floquetrod.rod.loads import load

_TINY, LARGEST = 1e-9, 1e12  # what the library takes, in SI units: a typing error lies beyond

_UNASKED = {"speed": "mm/s"}  # units of answers that are not SI
_SHOWN = ("force", "frequency", "speed", "length", "pressure")  # kinds of quantity that --unit is for

_MOST_POINTS = 25_000_000  # half a gigabyte with growth rates


def describe_command(
    command: Parser, text: str, run: Any, common: Sequence[str], *, has_assumptions: bool = False
) -> None:
    """Give a command its help, which begins with the first paragraph of ``text`` and ends with the rest.

    The first paragraph of that rest are the examples; ``common`` are the options that --help shows, at most five.
    Reports of a command whose answer has assumptions list them on request.
    """
    command.show_most_used(*common)
    command.description, _, command.epilog = text.partition("\n\n")
    command.formatter_class = argparse.RawDescriptionHelpFormatter
    command.add_argument("--json", action="store_true", help="print JSON, units in the names")
    if has_assumptions:
        command.add_argument("--assumptions", action="store_true", help="list the assumptions of the answer")
    command.set_defaults(run=run, parser=command)


ROD_AND_LOAD = ("rod", "mean", "amplitude", "frequency")
"""Options that every question about a rod under a load needs."""

OPTIONS = {name: parameter.option for name, parameter in GIVEN.items() if parameter.option is not None}
"""Options for parameters of the rod."""

SURVEY_OPTIONS = ("depth_unit", "angle_unit", "survey_columns", "delimiter", "sheet", "to")
"""Options that say how a survey is read."""

ROD_OPTIONS = ("rod", *OPTIONS, *SURVEY_OPTIONS)
"""Options of `add_rod` that describe the rod."""


def add_rod(
    command: argparse.ArgumentParser, subject: Any = None, *, classified: bool = True, in_a_well: bool = False
) -> None:
    """Add the options that describe a rod and, where it is to be classified, which growth matters.

    ``subject`` is the group of options one of which is required, where --rod is one of several.  A string pushed
    ``in_a_well`` takes its channel from there.
    """
    (command if subject is None else subject).add_argument(
        "--rod",
        required=subject is None,
        help="nitinol (the reference rod), a steel pipe by its size in inches such as '2.00x0.156 CT90' (with --bore "
        "and --length), or a TOML file",
    )
    for name, described in OPTIONS.items():
        if described.in_a_well or not in_a_well:
            kind = Path if name == "path" else str
            command.add_argument(option(name), metavar=described.metavar, type=kind, help=described.help)
    if not in_a_well:
        add_survey(command)
    if classified:
        command.add_argument(
            "--growth-tolerance",
            metavar="RATE",
            help="growth in 1/s up to which a mode counts as stable (default: 0 to check and map, 1e-6 to certify and "
            "for ranges)",
        )


def add_subject(command: argparse.ArgumentParser) -> Any:
    """Add the option for a system, and return the group of what a question may be about, for `add_rod`."""
    subject = command.add_mutually_exclusive_group(required=True)
    subject.add_argument(
        "--system",
        metavar="FILE",
        help="a TOML or npz file with the matrices of a system, see floquetrod check --help-all",
    )
    command.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        help="value of a parameter of the system's file; may be repeated",
    )
    return subject


def require_no_values(options: argparse.Namespace) -> None:
    """Raise ValueError where parameters of a system were given beside a rod."""
    if options.set:
        raise ValueError(f"--set belongs to --system, got {options.set[0]!r} with --rod")


def add_survey(command: argparse.ArgumentParser) -> None:
    """Add the options that say how a survey is read."""
    command.add_argument("--depth-unit", metavar="UNIT", help="unit of depths in a survey whose headings name none")
    command.add_argument("--angle-unit", metavar="UNIT", help="unit of its angles, where they name none: deg")
    command.add_argument(
        "--survey-columns",
        metavar="DEPTH,INCLINATION,AZIMUTH",
        help="headings of its columns, or their numbers from 0, such as MD,INCL,AZIM_GN or 1,2,3; one may be left out, "
        "such as ,,AZIM_GN (default: usual headings)",
    )
    command.add_argument("--delimiter", metavar="CHARACTER", help="separator of its columns, such as ';' or tab")
    command.add_argument("--sheet", metavar="NAME", help="sheet of a workbook, by its name or its number from 0")
    command.add_argument("--to", metavar="DEPTH", help="depth such as 5200ft to which it is projected straight")


def read_survey(options: argparse.Namespace, path: Path) -> fr.WellPath:
    """Return the well whose survey is in a file, and say what was left out of it."""
    from floquetrod.rod.reading import read_well

    well = read_well({name: getattr(options, name) for name in SURVEY_OPTIONS}, path, option)
    if well.note:
        say(f"floquetrod: survey {path}: {well.note}")
    if well.start > 0.0 and getattr(options, "well", None) is not None:
        length = units.AnswerUnits.named(given=well.given_units).length
        say(f"floquetrod: survey {path}: the string begins at {length.show(well.start)}, the first station")
    return well


def add_units(command: argparse.ArgumentParser) -> None:
    """Add the option that says in which units to answer."""
    command.add_argument(
        "--unit", metavar="UNITS", help="units of the answer, such as Hz,Fcr or ft,lbf (default: those of the question)"
    )


def add_friction(command: argparse.ArgumentParser) -> None:
    """Add the options that describe friction and a kick."""
    add_coefficient(command, "needs --kick")
    command.add_argument(
        "--kick",
        metavar="SPEED",
        help="transverse speed each mode is disturbed with, such as 50mm/s (needs --friction)",
    )


def add_coefficient(command: argparse.ArgumentParser, note: str) -> None:
    """Add the option for the coefficient of friction; ``note`` is what its help adds."""
    text = f"coefficient of friction between rod and channel, such as 0.3 or 30%% ({note})"
    command.add_argument("--friction", "--mu", type=ratio, metavar="MU", help=text)


def add_wall_friction(command: argparse.ArgumentParser, *, required: bool = False, default: str | None = None) -> None:
    """Add the option for friction along the channel, which `reading.read_friction` reads."""
    command.add_argument(
        "--friction",
        "--mu",
        required=required,
        default=default,
        metavar="MU",
        help="coefficient of friction with the wall, such as 0.3 or 30%%, or 0.2,0.35@1500m with another from 1500 m on"
        + ("" if default is None else f" (default {default})"),
    )


def add_far_force(command: argparse.ArgumentParser) -> None:
    """Add the option for the force at the lower end of a string."""
    command.add_argument("--far-force", metavar="FORCE", default="0", help="mean force at the lower end (default: 0)")


def add_push(command: argparse.ArgumentParser) -> None:
    """Add the options for the forces at both ends of a string, which `read_push` reads."""
    add_far_force(command)
    command.add_argument("--push", metavar="FORCE", help="greatest push at the surface, such as 20kN (default: any)")


def read_push(options: argparse.Namespace, rod: fr.Rod) -> tuple[float, float | None]:
    """Return the force in N at the lower end, and that at the upper one where it was given."""
    push = None if options.push is None else read_force(options.push, "--push", rod)
    return read_force(options.far_force, "--far-force", rod), push


def add_tool(command: argparse.ArgumentParser) -> None:
    """Add the option for a vibration tool, which `reading.read_tool` reads."""
    command.add_argument(
        "--tool",
        metavar="FORCE@FREQUENCY[@LENGTH]",
        help="a vibration tool, this far above the lower end; 5kN@18Hz@30m+3kN@29Hz has a second sine",
    )


def read_friction(options: argparse.Namespace) -> tuple[float, float] | None:
    """Return the coefficient of friction and the kick in m/s, None without either; one alone is refused."""
    if options.friction is None:
        if options.kick is not None:
            raise ValueError(
                f"--kick needs --friction, got {options.kick!r} alone: without friction an unstable mode grows "
                "whatever the kick; add it, such as --friction 0.1"
            )
        return None
    if options.kick is None:
        raise ValueError(
            f"--friction needs --kick, got {options.friction:g} alone: friction holds every undisturbed rod; add the "
            "transverse speed each mode is disturbed with, such as --kick 50mm/s"
        )
    return options.friction, units.quantity(options.kick, "--kick", "speed", least=_TINY, largest=LARGEST)


def read_tolerance(options: argparse.Namespace) -> float:
    """Return the growth tolerance in 1/s."""
    given = "0" if options.growth_tolerance is None else options.growth_tolerance
    return units.quantity(given, "--growth-tolerance", "rate", least=0.0, largest=LARGEST)


def read_quantity(text: str, name: load.Quantity, rod: fr.Rod, given: str | None = None) -> float:
    """Return a quantity of the load in SI units; messages quote ``given`` in place of the text."""
    from floquetrod.rod import reading

    if given is None:
        require_one_value(text, name)
    return reading.read_quantity(text, name, rod, option, given)


def require_one_value(text: str | None, name: load.Quantity) -> None:
    """Raise ValueError for a range of a quantity of the load."""
    if text is not None and ":" in text:
        raise ValueError(
            f"--{name} must be one value here, got {text!r}; floquetrod ranges takes a range of one quantity, map and "
            "certify take ranges of two"
        )


def read_force(text: str, name: str, rod: fr.Rod) -> float:
    """Return a force in N that an option gives."""
    return units.quantity(text, name, "force", critical_force=rod.force_unit)


_NO_COLON = re.compile(r"\s*(\d[\d.]*[a-zA-Z/%]*)\s*(?:[-\N{EN DASH};,]|\.\.+|to)\s*(\d[\d.]*[a-zA-Z/%]+)\s*")


def read_range(text: str, name: load.Quantity, rod: fr.Rod) -> list[float]:
    """Return one quantity, or both ends of a range; a first end without a unit has the unit of the second."""
    first, colon, last = text.partition(":")
    apart = None if colon else _NO_COLON.fullmatch(text)
    if apart is not None:
        typed = f"{apart[1]}:{apart[2]}"
        raise ValueError(f"--{name} must be one value or a range with a colon, got {text!r}; write {typed}")
    if not colon:
        return [read_quantity(text, name, rod)]
    ends = zip(units.same_unit(first, last), (first, last), strict=True)
    low, high = (read_quantity(end, name, rod, f"{typed!r} in {text!r}") for end, typed in ends)
    if not low < high:
        raise ValueError(f"--{name} must be a range whose first end is the lower one, got {text!r}")
    return [low, high]


def units_asked(text: str | None, kinds: Sequence[str] = _SHOWN, such_as: str = "Hz,Fcr or ft,lbf") -> dict[str, str]:
    """Return the units of --unit by their kinds."""
    chosen: dict[str, str] = {}
    for name in filter(None, (each.strip() for each in (text or "").split(","))):
        kind = units.kind_of(name) or ""
        if kind not in kinds:
            every = "; ".join(f"{kind}: {', '.join(units.units_of(kind, 1.0))}" for kind in kinds)
            near = did_you_mean(name, [each for kind in kinds for each in units.units_of(kind, 1.0)])
            raise ValueError(f"--unit must name units such as {such_as}, got {name!r} in {text!r}{near} ({every})")
        if kind in chosen:
            raise ValueError(f"--unit must name one unit of {kind}, got {chosen[kind]} and {name} in {text!r}")
        chosen[kind] = name
    return chosen


_WITH_LENGTHS, _WITH_FORCES = ("length", "depth", "depths"), ("mean", "amplitude", "push", "far_force", "tool")


def units_typed(options: argparse.Namespace) -> dict[str, str]:
    """Return the units in which lengths along the rod and forces were typed, except for those in critical forces."""
    typed_units = {}
    for kind, names in (("length", _WITH_LENGTHS), ("force", _WITH_FORCES)):
        texts = (getattr(options, name, None) for name in names)
        typed = (typed_unit(text.partition("@")[0]) for text in texts if isinstance(text, str))
        if name := next((each for each in typed if each and units.is_unit(each, kind)), None):
            typed_units[kind] = name
    return typed_units


def units_shown(options: argparse.Namespace, kinds: Sequence[str], such_as: str) -> dict[str, str]:
    """Return the units of an answer by their kinds, from --unit, else as typed; a critical force is no unit."""
    shown = {**units_typed(options), **units_asked(options.unit, kinds, such_as)}
    for kind, name in shown.items():
        units.unit(name, "--unit", kind)
    return shown


def typed_unit(text: str) -> str | None:
    """Return the unit of a quantity, or of the last one of a range or a list; "" for none, None for no quantity."""
    return units.unit_of(re.split("[:,]", text)[-1])


def read_units(options: argparse.Namespace, rod: fr.Rod, like: load.Load | None = None) -> dict[str, str]:
    """Return the unit of each quantity in the answer: from --unit, else the unit it was given in, else SI.

    An end of a range without a unit has the unit of the other end; a force without one is shown in that of another.
    Without --kick the unit of kicks is mm/s.
    Quantities that no option gives, but the load ``like`` of a measured force, are in the unit in which another force
    was typed, else in the record's.
    Other forces, lengths and pressures are among them where something tells their unit.
    """
    from floquetrod.rod.loads.load import LOAD, QUANTITIES

    chosen, typed_units = units_asked(options.unit), units_typed(options)
    of_record = {} if like is None else {**like.given_units._asdict(), **typed_units}
    found: dict[str, str] = {}
    for name, kind in [*((name, LOAD[name].kind) for name in QUANTITIES), ("kick", "speed")]:
        text = getattr(options, name, None)
        typed = typed_unit(text) if isinstance(text, str) else None
        if typed == "" and kind == "force":  # such as an amplitude of 0 beside a mean in lbf
            typed = typed_units.get(kind, "")
        unasked = of_record.get(kind) or _UNASKED.get(kind, "")
        wanted = chosen.get(kind, unasked if typed is None else typed)
        found[name] = units.unit(wanted, f"--{name}", kind, rod.force_unit).name
    asked = {kind: name for kind, name in chosen.items() if kind in ("force", "length", "pressure")}
    if not units.is_unit(asked.get("force", ""), "force"):  # critical forces, of which one is said in another unit
        asked.pop("force", None)
    more = {kind: units.unit(name, "--unit", kind).name for kind, name in {**typed_units, **asked}.items()}
    return {**found, **more}


_KINDS = {
    **dict.fromkeys(("mean", "amplitude", "push", "far_force"), "force"),
    **dict.fromkeys(("kick", "random", "speed", "feed_speed"), "speed"),
    "frequency": "frequency",
    "depths": "length",
    "natural_curvature": "curvature",
    **dict.fromkeys(("wellhead_pressure", "pressure_inside"), "pressure"),
    "stripper": "force",
}
"""Kinds of quantities that options give, beside those of a rod."""


def bare_numbers_typed(options: argparse.Namespace) -> list[str]:
    """Return warnings of numbers typed without a unit that may be meant in another one, where others have theirs."""
    from floquetrod.bare_numbers import Quantity, bare_numbers

    kinds = {**{name: GIVEN[name].kind for name in OPTIONS if name != "path"}, **_KINDS}
    typed = {name: text for name, text in vars(options).items() if text != options.parser.get_default(name)}
    quantities = [Quantity(option(name), typed[name], kind) for name, kind in kinds.items() if name in typed]
    shown = [name.strip() for name in (getattr(options, "unit", None) or "").split(",")]
    return [number.warning for number in bare_numbers(quantities, shown=shown)]


def read_rod(options: argparse.Namespace) -> fr.Rod:
    """Return the rod that the options describe, given in the units of the options, then the units of its file."""
    rod = _rod(options)
    typed = units_given({name: getattr(options, name, None) for name in OPTIONS if name != "path"})
    return rod.given_in(typed.or_else(rod.given_units))


def _rod(options: argparse.Namespace) -> fr.Rod:
    """Return the rod that the options describe, its numbers in SI units."""
    from floquetrod.rod.reading import is_pipe, named_rod

    changes: dict[str, Any] = {
        name: GIVEN[name].quantity(text, option(name))
        for name in OPTIONS
        if name not in ("path", "depth") and (text := getattr(options, name, None)) is not None
    }
    changes |= _on_path(options)
    if is_pipe(options.rod):
        if getattr(options, "well", None) is not None:
            changes.setdefault("length", 1000.0)  # that of a string in a well follows from there
        missing = [f"--{key}" for key in ("bore", "length") if key not in changes]
        if missing:
            _require_listed(options.rod, missing)
            raise ValueError(
                f"--rod {options.rod!r} needs {' and '.join(missing)}: a pipe's size says neither the diameter of its "
                "hole nor its length; or write all of it into a TOML file"
            )
        return fr.Rod.catalogue(options.rod, **changes)
    rod = named_rod("--rod", options.rod)
    _require_of_the_whole(options, rod, changes)
    if "bore" in changes:
        changes["channel_diameter"] = changes.pop("bore")
    return rod.replace(**changes) if changes else rod


def _require_of_the_whole(options: argparse.Namespace, rod: fr.Rod, changes: Iterable[str]) -> None:
    """Raise ValueError for an option that sets what each section of the rod, or each bore, has for itself."""
    for name in changes:
        table = "sections" if INSTEAD.get(name, name) in OF_A_SECTION else "bores" if name == "bore" else ""
        if table and getattr(rod, table):
            raise ValueError(
                f"{option(name)} must not be given for a rod of several {table}, got {getattr(options, name)!r}: each "
                f"has its own; change it in {options.rod}"
            )


def _require_listed(name: str, missing: Sequence[str]) -> None:
    """Raise ValueError for a pipe that the catalogue does not hold, which names the missing options, too."""
    from floquetrod.rod.model.catalogue import pipe

    try:
        pipe(name)
    except ValueError as error:
        about = argument_of(error)
        if about is None:
            raise
        raise wrong_value("name", about.problem, f"; a pipe needs {' and '.join(missing)}, too") from None


def _on_path(options: argparse.Namespace) -> dict[str, Any]:
    """Return the path of a well and the depth of the rod's upper end, where they were given."""
    path, depth = getattr(options, "path", None), getattr(options, "depth", None)
    if path is None:
        if depth is not None:
            raise ValueError(f"--depth needs --path, got {depth!r} alone: it is a depth in that well; add its survey")
        return {}
    for name in ("inclination", "curvature"):
        if getattr(options, name) is not None:
            raise ValueError(f"--{name} must not be given with --path, whose survey determines it; leave one out")
    start = 0.0 if depth is None else GIVEN["depth"].quantity(depth, "--depth")
    return {"path": read_survey(options, path), "depth": start}


def add_picture(command: Parser, points: str, default: str) -> None:
    """Add the options that say how a chart is drawn and where it is written."""
    shape = command.add_mutually_exclusive_group()
    shape.add_argument(
        "--bands",
        action="store_true",
        help="draw the unstable bands as shapes (the default where they take about as long as the points)",
    )
    shape.add_argument("--pixels", action="store_true", help="draw the points in place of bands")
    help_points = f"columns x rows (default {points}); fewer take less time"
    command.add_argument("--points", metavar=POINTS, default=points, help=help_points)
    command.add_argument("--growth", action="store_true", help="shade by growth rate")
    command.add_output("--out", chart_files, "file to write", default=default)


def require_bands_of_csv(options: argparse.Namespace) -> None:
    """Raise ValueError for a .csv file of a chart drawn by its points."""
    if options.pixels and (vertices := next((path for path in options.out if path.suffix == ".csv"), None)):
        raise ValueError(f"--out {vertices}: a .csv file holds the vertices of bands; leave out --pixels")


def find_bands(options: argparse.Namespace, chart: fr.Chart) -> bool:
    """Find the bands of a chart where they are to be drawn, and return whether they are."""
    prompt = chart.source is not None and chart.source.prompt
    if not (options.bands or (prompt and not options.pixels)):
        return False
    with Waiting("finding bands", "steps along boundaries") as progress:
        chart.find_bands(progress=progress)
    return True


_ROUNDING = 1e-9  # of an axis, below which an end of a band is 0: vertices err by more (a choice)
_LISTED_BANDS = 12  # of a chart that are listed in the terminal, the fastest growing ones (a choice)


def bands_listed(bands: fr.results.Bands) -> str:
    """Return the caption of bands, and a table of the fastest growing ones with their ranges along both axes."""
    from floquetrod._util.result_report import Table
    from floquetrod.plane.bands import beginning

    if not len(bands):
        return bands.caption
    x, y = (f"{axis.name} / {axis.unit}" if axis.unit else axis.name for axis in (bands.x, bands.y))
    columns = ("unstable", x, y, f"largest growth {_rate(bands.growth_unit)}", "at")
    fastest = sorted(bands, key=lambda band: 0.0 if math.isnan(band.largest_growth) else -band.largest_growth)
    rows = [
        row
        for band in fastest[:_LISTED_BANDS]
        for row in (
            (
                band.name or "band",
                *(
                    f"{_end(values.min(), axis)} to {_end(values.max(), axis)}"
                    for values, axis in ((band.x, bands.x), (band.y, bands.y))
                ),
                "not known" if math.isnan(band.largest_growth) else f"{band.largest_growth:.5g}",
                f"{band.place[0]:.5g}, {band.place[1]:.5g}",
            ),
            *(
                (f"  merged: {t.name}", "", "", "", f"begins at {', '.join(map(_span, beginning(band, t)))}")
                for t in band.merged
            ),
        )
    ]
    more = len(bands) - _LISTED_BANDS
    rest = f"and {more:,} more, which grow more slowly: --json lists all" if more > 0 else ""
    return f"{bands.caption}\n\n{Table([(title, '<') for title in columns], rows, rest)}"


def _end(value: float, axis: Any) -> str:
    """Return an end of a band along an axis; 0 where rounding errors differ from it, relative to the axis."""
    width = float(axis.values[-1] - axis.values[0])
    return f"{0.0 if abs(value) < _ROUNDING * width else value:.5g}"


def _span(ends: tuple[float, float]) -> str:
    """Return a range, or a number where it is one."""
    return " to ".join(dict.fromkeys(f"{end:.5g}" for end in ends))


def _rate(unit: str) -> str:
    return unit if unit.startswith("per ") else f"/ ({unit})"


def bands_in_numbers(bands: fr.results.Bands) -> list[dict[str, Any]]:
    """Return bands for JSON: their resonances, their ranges along both axes, and where they grow fastest."""
    from floquetrod._util.interchange import with_unit
    from floquetrod._util.result_report import number
    from floquetrod.plane.bands import beginning

    x, y = (with_unit(axis.name, axis.unit) for axis in (bands.x, bands.y))
    growth = f"largest_growth_{bands.growth_unit.replace('1/s', 'per s').replace(' ', '_')}"
    return [
        {
            "name": band.name,
            "mode": band.mode,
            "partner": band.partner,
            "tongue": band.tongue,
            x: [float(band.x.min()), float(band.x.max())],
            y: [float(band.y.min()), float(band.y.max())],
            growth: number(band.largest_growth),
            "at": list(band.place),
            "merged": [
                {
                    "name": tongue.name,
                    "mode": tongue.mode,
                    "partner": tongue.partner,
                    "tongue": tongue.tongue,
                    "begins_at": list(tongue.place),
                    "begins_along": [list(ends) for ends in beginning(band, tongue)],
                }
                for tongue in band.merged
            ],
        }
        for band in bands
    ]


def read_points(text: str) -> tuple[int, int]:
    """Return columns and rows."""
    match = re.fullmatch(r"(\d{1,6})x(\d{1,6})", text, re.ASCII)
    columns, rows = (int(match[1]), int(match[2])) if match else (0, 0)
    if min(columns, rows) < 2 or columns * rows > _MOST_POINTS:
        apart = re.fullmatch(r"\s*(\d{1,6})[^\d.]+(\d{1,6})\s*", text, re.ASCII) if match is None else None
        remedy = f"; write {apart[1]}x{apart[2]}" if apart and not text.strip().startswith("-") else ""
        raise ValueError(
            f"--points must be columns x rows such as 400x300, two or more and {_MOST_POINTS:,} in all at most, "
            f"got {text!r}{remedy}"
        )
    return columns, rows


def figures() -> tuple[str, ...]:
    """Return the ends of names of figures."""
    from floquetrod.plotting import chart_plot

    return chart_plot.FIGURES


def chart_files() -> tuple[str, ...]:
    """Return the ends of names of files that hold a chart: its picture, its bands or all its numbers."""
    return (*figures(), ".csv", ".npz")


def table_or_figure() -> tuple[str, ...]:
    """Return the ends of names of figures and tables."""
    return (*figures(), ".csv")


def documents() -> tuple[str, ...]:
    """Return the ends of names of reports."""
    from floquetrod.plotting import document

    return document.KINDS


def require_writable(options: argparse.Namespace) -> None:
    """Raise ValueError, before anything is computed, where a file named for the answer could not be written.

    One that is named twice would be written over, as would one that the command reads.
    """
    from floquetrod._util.sealed_files import writable

    named = [(action, path) for action in options.parser.outputs for path in getattr(options, action.dest)]
    taken = [os.path.realpath(given) for given in vars(options).values() if named and isinstance(given, Path | str)]
    for action, path in named:
        name, kinds = action.option_strings[0], action.kinds()
        if path.suffix not in kinds:
            raise ValueError(f"{name} must end in {', '.join(kinds[:-1])} or {kinds[-1]}, got {str(path)!r}")
        try:
            writable(path)
        except (ValueError, OSError) as error:  # a name too long, say
            raise ValueError(f"{name} {str(path)!r}: {error}") from None
        if os.path.realpath(path) in taken:
            raise ValueError(f"{path} is named twice; give every file its own name")
        taken.append(os.path.realpath(path))


def write_each(paths: Sequence[Path], write: Callable[[Path], Any]) -> list[str]:
    """Write files one after another and return their names, which `output` tells."""
    for path in paths:
        with Waiting(f"writing {path}"):
            write(path)
    return [str(path) for path in paths]


def write_figures(paths: Sequence[Path], draw: Callable[[], Any]) -> list[str]:
    """Write a drawing into files, where there are any, and return their names."""
    if not paths:
        return []
    from floquetrod.plotting import chart_plot

    drawn = draw()
    return write_each(paths, lambda path: chart_plot.save_figure(drawn, path))


def write_charts(paths: Sequence[Path], chart: fr.Chart, drawn: fr.Chart, draw: Callable[[], Any]) -> list[str]:
    """Write a chart into files, and return their names: all its numbers, or bands or a picture of it ``drawn``."""
    from floquetrod.plotting import chart_plot

    def write(path: Path) -> None:
        if path.suffix == ".npz":
            chart.save(path)
        elif path.suffix == ".csv":
            drawn.bands.to_csv(path)
        else:
            chart_plot.save_figure(draw(), path)

    return write_each(paths, write)


def add_project(command: argparse.ArgumentParser) -> None:
    """Add the option for what a report is for."""
    command.add_argument("--project", metavar="NAME", default="", help="what the report is for, told below its title")


_FILES = {"rod": "rod", "well": "survey", "path": "survey", "force": "measured force"}
"""What the files hold that options name."""


def files_named(options: argparse.Namespace) -> dict[str, str]:
    """Return the files that options name, by what they hold; a rod of the catalogue is in none."""
    named = [(held, getattr(options, name, None)) for name, held in _FILES.items()]
    return {held: str(file) for held, file in named if file is not None and Path(file).is_file()}


def command_typed() -> str:
    """Return the command as it was typed."""
    return shlex.join(["floquetrod", *sys.argv[1:]])


@contextmanager
def compiling_told() -> Iterator[None]:
    """Report on stderr, the first time that something is compiled, that this takes time."""
    log, teller = logging.getLogger("floquetrod.compile"), _CompilingTold()
    level = log.level
    log.setLevel(logging.INFO)
    log.addHandler(teller)
    try:
        yield
    finally:
        log.removeHandler(teller)
        log.setLevel(level)


class _CompilingTold(logging.Handler):
    told = False

    def emit(self, record: logging.LogRecord) -> None:
        if not self.told:
            say("floquetrod: compiling, once; this takes some seconds")
            self.told = True


@contextmanager
def warnings_at_once() -> Iterator[None]:
    """Report a checkpoint that cannot be written at once, while the cause can still be removed."""
    with warnings.catch_warnings():
        collect = warnings.showwarning

        def tell(message: Any, category: Any, *rest: Any, **more: Any) -> None:
            if not issubclass(category, fr.CheckpointWarning):
                collect(message, category, *rest, **more)
                return
            say(f"floquetrod: warning: {message}")

        warnings.simplefilter("default", fr.CheckpointWarning)
        warnings.showwarning = tell
        yield
