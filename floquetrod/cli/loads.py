"""The load in the terminal: its quantities, and what kind of load it is."""

from __future__ import annotations

import argparse
import itertools
import re
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple

import floquetrod as fr
from floquetrod import units
from floquetrod._util.result_report import Report
from floquetrod._util.waiting import Waiting, say
from floquetrod.cli.common import (
    add_friction,
    add_rod,
    add_units,
    read_range,
    read_rod,
    read_tolerance,
    read_units,
    require_one_value,
    typed_unit,
)
from floquetrod.cli.messages import option
from floquetrod.parameter import Subsystem, unknown
from floquetrod.rod import reading
from floquetrod.rod.loads.load import LOAD, QUANTITIES, Load, LoadSource, Quantity
from floquetrod.rod.model.plausibility import suspicion_of_hertz, warn_of_record


def add_question(
    command: argparse.ArgumentParser,
    subject: Any = None,
    *,
    subsystem: Subsystem = "modes",
    classified: bool = True,
    friction: bool = False,
    ranges: bool = False,
) -> None:
    """Add the options of a question about a rod and its load, which may be ``ranges``; the rest as in `add_rod`.

    Options for what the ``subsystem`` that answers would ignore are left out.
    """
    add_rod(command, subject, classified=classified)
    if friction:
        add_friction(command)
    add_units(command)
    _add_load(command, ranges)
    _add_kind(command, subsystem)


def _add_load(command: argparse.ArgumentParser, ranges: bool) -> None:
    """Add the options for mean, amplitude and frequency, which may be ``ranges``."""
    for name in QUANTITIES:
        described = LOAD[name].option
        if described is not None:
            text = f", or a range such as {described.range}" if ranges else ""
            command.add_argument(option(name), metavar=described.metavar, help=described.help.format(range=text))
    command.epilog = f"{command.epilog}\n{_units()}"


def _units() -> str:
    """Return a paragraph on the units that may be typed."""
    lines = ["units, in any case but that of M for mega and m for milli; a number without one is in the first:"]
    for quantity, name in (
        ("force", "forces"),
        ("frequency", "frequencies"),
        ("speed", "speeds"),
        ("length", "lengths"),
    ):
        more = ", Fcr (the critical force of the rod), % (of that force)" if quantity == "force" else ""
        lines.append(f"  {name:<12} {', '.join(units.units_of(quantity))}{more}")
    return "\n".join(lines)


def _add_kind(command: argparse.ArgumentParser, subsystem: Subsystem) -> None:
    """Add the options that say what kind of load it is."""
    for name, parameter in LOAD.items():
        if parameter.option is not None and name not in QUANTITIES and parameter not in unknown(LOAD, subsystem):
            help_, metavar, *_, named, choices = parameter.option
            command.add_argument(option(named or name), metavar=metavar, choices=choices, help=help_)
    command.add_argument(
        "--force",
        metavar="FILE",
        help="a measured force, a text file with columns of time and force, which is positive in compression, such as "
        "record.csv: gives the waveform, and mean, amplitude and frequency unless options give them",
    )
    for name, heading, examples in (("time", "time or t", "s or ms"), ("force", "force or f", "kN or lbf")):
        command.add_argument(
            f"--{name}-column",
            metavar="HEADING",
            help=f"heading, with its unit or without, or number, from 0, of the column of {name} (default: {heading})",
        )
        command.add_argument(
            f"--{name}-unit", metavar="UNIT", help=f"unit of {name}, such as {examples} (default: that of its heading)"
        )
    command.add_argument(
        "--force-frequency",
        metavar="FREQUENCY",
        help="approximate frequency of the fundamental of a measured force, such as 10.8Hz, known within a tenth; it "
        "is refined (default: it is searched for)",
    )


def _read_record(options: argparse.Namespace) -> fr.ForceRecord | None:
    """Return the measured force, None without any."""
    if options.force is None:
        return reading.read_record(vars(options), option)
    with Waiting(f"reading and fitting {options.force}"):
        return reading.read_record(vars(options), option)


def _read_kind(options: argparse.Namespace) -> tuple[fr.ForceRecord | None, Load]:
    """Return the measured force, and a load of the kind that the options describe, with the numbers of the record."""
    record = _read_record(options)
    return record, reading.read_kind(vars(options), record, option)


def _require_quantities(options: argparse.Namespace) -> None:
    """Raise ValueError where a quantity of the load is missing, and no record gives it."""
    if options.force is not None:
        return
    missing = [f"--{name}" for name in QUANTITIES if getattr(options, name) is None]
    if missing:
        push = "; --mean is the constant push, 0 for a rod only shaken" if "--mean" in missing else ""
        if missing == ["--frequency"] and re.fullmatch(r"[+-]?0*\.?0*\s*[A-Za-z]*", str(options.amplitude)):
            push = "; with --amplitude 0 any will do, such as --frequency 1Hz"
        see = f"(see floquetrod {options.command} --help){push}"
        raise ValueError(f"the following arguments are required: {', '.join(missing)} {see}")


class Question(NamedTuple):
    """A rod, a measured force, None without any, a load, and what verdicts are about: the force with its noise."""

    rod: fr.Rod
    record: fr.ForceRecord | None
    load: Load
    source: Load | LoadSource


def read_question(options: argparse.Namespace, *, required: bool = True) -> Question:
    """Return the rod and the load, whose quantities may be ``required``.

    Where options change a measured force, the errors of its other numbers count in verdicts.
    """
    if required:
        _require_quantities(options)
    for name in QUANTITIES:
        require_one_value(getattr(options, name), name)
    rod = read_rod(options)
    record, like = _read_kind(options)
    load = reading.read_load(vars(options), rod, like, option)
    if record is None:
        return Question(rod, None, load, load)
    warn_of_record(rod, record, load)
    from floquetrod.rod.loads.record import ChangedRecord

    def change(fit: Load) -> Load:
        like = reading.read_kind(vars(options), record, option, fit)
        return reading.read_load(vars(options), rod, like, option)

    return Question(rod, record, load, record if _is_record_alone(options) else ChangedRecord(record, change))


def _is_record_alone(options: argparse.Namespace) -> bool:
    """Return whether a measured force says all about the load."""
    own = {*QUANTITIES, *reading.LOAD_OPTIONS} - {"force", *reading.RECORD_OPTIONS}
    return all(getattr(options, name, None) is None for name in own)


class Ranges(NamedTuple):
    """A question about loads on a rod: of each quantity a value or both ends of a range, or the values of ``like``.

    ``left_out`` are the sines of a measured force that ``like`` does not hold, in words.
    """

    rod: fr.Rod
    like: Load
    values: dict[Quantity, list[float]]
    tolerance: float
    shown: dict[str, str]
    left_out: str

    def titled(self, report: Report) -> Report:
        """Return a report whose headline says which sines the answer leaves out."""
        return replace(report, headline=self.with_left_out(report.headline))

    def with_left_out(self, headline: str) -> str:
        """Return a headline that says which sines the answer leaves out."""
        return f"{headline}, without {self.left_out}" if self.left_out else headline

    @property
    def as_numbers(self) -> dict[str, str]:
        """The same for JSON."""
        return {"left_out": self.left_out} if self.left_out else {}

    @property
    def varied(self) -> list[Quantity]:
        """Quantities with a range."""
        return [name for name, ends in self.values.items() if len(ends) > 1]

    @property
    def varied_in_words(self) -> str:
        """Those, as typed."""
        return f"ranges for --{' and --'.join(self.varied)}" if self.varied else "one value for each"

    def warn_of_hertz(self, options: argparse.Namespace) -> None:
        """Warn as `warn_of_hertz` does of the loads at the ends of ranges."""
        every = itertools.product(*self.values.values())
        loads = (self.like.with_numbers(**dict(zip(self.values, each, strict=True))) for each in every)
        warn_of_hertz("--frequency", options.frequency, self.rod, loads, self.tolerance)


def read_ranges(options: argparse.Namespace) -> Ranges:
    """Return the question that options ask."""
    _require_quantities(options)
    rod = read_rod(options)
    from floquetrod.rod.loads.record_period import NoPeriodError

    try:
        record, like = _read_kind(options)
    except NoPeriodError as error:
        if ":" not in (options.amplitude or ""):
            raise
        raise ValueError(
            f"{error}; for --amplitude {options.amplitude}, a range, a record without a sine has no waveform: beside "
            "that range give --mean and a density, --noise, and the --frequency of a sine in place of --force"
        ) from None
    texts = {name: getattr(options, name) for name in QUANTITIES}
    values = {n: [getattr(like, n)] if text is None else read_range(text, n, rod) for n, text in texts.items()}
    if record is not None:
        warn_of_record(rod, record, like, values["frequency"])
    shown = read_units(options, rod, like)
    frequency = shown["frequency"] if typed_unit(options.frequency or "") else ""
    typed = units.GivenUnits(force=shown.get("force", ""), frequency=frequency)
    like = replace(like).given_in(typed.or_else(like.given_units))
    left_out = "" if record is None else record._left_out_in_words(like)
    return Ranges(rod, like, values, read_tolerance(options), shown, left_out)


def warn_of_hertz(
    name: str, text: str | None, rod: fr.Rod, loads: Iterable[Load], tolerance: float = 0.0, known: int | None = None
) -> None:
    """Warn where a frequency typed without a unit would, in Hz, change the verdict on one of the loads.

    ``name`` is what gave it, ``known`` the verdict on a single load where it has been found: 1, 0 or -1.
    """
    warning = "" if text is None else suspicion_of_hertz(name, text, rod, loads, tolerance, known)
    if warning:
        say(f"floquetrod: warning: {warning}")
