"""The load in the terminal: its quantities, and what kind of load it is."""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import floquetrod as fr
from floquetrod import units
from floquetrod._util.arguments import argument_of
from floquetrod.cli.common import LARGEST, read_quantity, read_range, require_file
from floquetrod.cli.waiting import Waiting, say
from floquetrod.rod.load import KINDS, Load, Quantity, kind
from floquetrod.rod.plausibility import may_be_hertz, verdicts_in_hertz, warn_of_load

_L = TypeVar("_L", bound=Load)

RECORD_OPTIONS = ("time_column", "force_column", "time_unit", "force_unit")
"""What says how to read --force."""

LOAD_OPTIONS = ("mean_at", "wave", "axial_damping", "force", *RECORD_OPTIONS)
"""What `add_kind` adds."""


_LOAD_HELP: dict[Quantity, tuple[str, str]] = {
    "mean": ("mean force such as 0.2Fcr, 20%%, 12N or 3lbf{}; negative pulls", "0:1.2Fcr"),
    "amplitude": ("amplitude of the force such as 0.2Fcr, 20%%, 3N or 1lbf{}; 0 is the static limit", "0:0.5Fcr"),
    "frequency": ("frequency such as 24Hz, 1440rpm or 150 (rad/s){}", "10Hz:60Hz"),
}
"""Help of the quantities of a load, and an example of a range."""


def add_load(command: argparse.ArgumentParser, *, ranges: bool = False, together: bool = False) -> None:
    """Add the options for mean, amplitude and frequency, which may be ``ranges`` or be left out ``together``."""
    for name, (text, example) in _LOAD_HELP.items():
        given = text.format(f", or a range such as {example}" if ranges else "")
        rest = "; give all three or none" if together else ""
        command.add_argument(f"--{name}", metavar=KINDS[name].upper(), help=given + rest)
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


def add_kind(command: argparse.ArgumentParser) -> None:
    """Add the options that say what kind of load it is."""
    command.add_argument(
        "--mean-at",
        metavar="FRACTION",
        help="position along an inclined rod where the mean force is given, from 0, the upper end, to 1 (default 0.5); "
        "none neglects the weight along the rod",
    )
    command.add_argument(
        "--wave",
        choices=("held", "free", "driven"),
        help="the upper end sends axial waves; the lower end is held, free, or driven like the upper one",
    )
    command.add_argument(
        "--axial-damping", metavar="RATE", help="decay rate of axial waves in 1/s (needs --wave; default 0)"
    )
    command.add_argument(
        "--force",
        metavar="FILE",
        help="a measured force, a text file with columns of time and force such as record.csv: gives the waveform, and "
        "mean, amplitude and frequency unless options give them",
    )
    for name, heading, examples in (("time", "time or t", "s or ms"), ("force", "force or f", "kN or lbf")):
        command.add_argument(
            f"--{name}-column",
            metavar="HEADING",
            help=f"heading or number, from 0, of the column of {name} (default: {heading})",
        )
        command.add_argument(
            f"--{name}-unit",
            metavar="UNIT",
            help=f"unit of {name}, such as {examples} (default: that of its heading)",
        )


def read_record(options: argparse.Namespace, rod: fr.Rod) -> fr.ForceRecord | None:
    """Return the measured force, None without any; warns where it may be in another unit than N."""
    if options.force is None:
        for name in RECORD_OPTIONS:
            if getattr(options, name) is not None:
                option, given = name.replace("_", "-"), getattr(options, name)
                raise ValueError(f"--{option} needs --force, got {given!r} alone: it says how to read that file")
        return None
    columns = (
        None if text is None else int(text) if text.isdecimal() else text
        for text in (options.time_column, options.force_column)
    )
    wanted = "--force must be a text file with columns of time and force"
    try:
        require_file("--force", Path(options.force), "a text file with columns of time and force")
        with Waiting(f"reading and fitting {options.force}"):
            record = fr.ForceRecord.from_csv(
                options.force, *columns, time_unit=options.time_unit, force_unit=options.force_unit
            )
        if not record.force_unit_named:
            warn_of_load(rod, record)
        return record
    except (ValueError, OSError) as error:
        about = argument_of(error)
        if about is None or about.name not in _OF_COLUMNS:
            raise ValueError(
                message if (message := str(error)).startswith("--force") else f"{wanted}: {error}"
            ) from None
        message = about.named(_OF_COLUMNS[about.name])
        raise ValueError(f"{wanted}: {message}" if about.where else message) from None


_OF_COLUMNS = {
    "time": "--time-column",
    "force": "--force-column",
    **{f"{n}_unit": f"--{n}-unit" for n in ("time", "force")},
}
"""Options for the arguments of `floquetrod.ForceRecord.from_csv`."""


def read_kind(options: argparse.Namespace, record: fr.ForceRecord | None) -> Load:
    """Return a load of the kind that the options describe, its numbers those of the record."""
    if options.axial_damping is not None and options.wave is None:
        raise ValueError(
            f"--axial-damping needs --wave, got {options.axial_damping!r} alone: without waves the force is the same "
            "all along the rod; add --wave held, free or driven"
        )
    at = 0.5 if options.mean_at is None else _fraction(options.mean_at)
    load = replace(kind(record), mean_at=at)
    if options.wave is None:
        return load
    given = "0" if options.axial_damping is None else options.axial_damping
    damping = units.quantity(given, "--axial-damping", "rate", least=0.0, largest=LARGEST)
    return fr.AxialWave(**load.as_dict(), far_end=options.wave, axial_damping=damping)


def _fraction(text: str) -> float | None:
    """Return a fraction of the length, None for the word none."""
    if text.strip().lower() == "none":
        return None
    try:
        return units.quantity(text, "--mean-at", "ratio", least=0.0, largest=1.0)
    except ValueError:
        raise ValueError(
            "--mean-at must be a fraction of the length from 0, the upper end, to 1, the lower, or none, which "
            f"neglects the weight along the rod; got {text!r}"
        ) from None


def require_quantities(options: argparse.Namespace) -> None:
    """Raise ValueError where a quantity of the load is missing, and no record gives it."""
    if options.force is not None:
        return
    missing = [f"--{name}" for name in KINDS if getattr(options, name) is None]
    if missing:
        raise ValueError(
            f"the following arguments are required: {', '.join(missing)} (see floquetrod {options.command} --help)"
        )


def read_load(options: argparse.Namespace, rod: fr.Rod, like: _L) -> _L:
    """Return the load that the options describe, of the kind of ``like``, which gives the numbers left out."""
    given = {name: text for name in KINDS if (text := getattr(options, name)) is not None}
    numbers = {name: getattr(like, name) for name in KINDS}
    return like.with_numbers(**(numbers | {name: read_quantity(text, name, rod) for name, text in given.items()}))


def read_values(options: argparse.Namespace, rod: fr.Rod, like: Load) -> dict[Quantity, list[float]]:
    """Return every quantity of the load, one value or both ends of a range; those left out are those of ``like``."""
    texts = {name: getattr(options, name) for name in KINDS}
    return {n: [getattr(like, n)] if text is None else read_range(text, n, rod) for n, text in texts.items()}


def warn_of_hertz(name: str, text: str | None, rod: fr.Rod, loads: Iterable[Load], tolerance: float = 0.0) -> bool:
    """Warn where a frequency typed without a unit would, in Hz, change the verdict on one of the loads; tell whether.

    ``name`` is what gave it.  Verdicts are those without friction.  Where modes are coupled, and a verdict takes its
    time, a single load is suspected as in `floquetrod.rod.plausibility`.
    """
    if text is None or units.unit_of(text.rpartition(":")[2]) != "":
        return False
    loads = list(loads)
    for load in loads:
        reading = ""
        if rod.modes_under(load).prompt:
            reading = _in_hertz(rod, load, tolerance)
        elif len(loads) == 1 and may_be_hertz(rod, load):
            reading = "below all but the narrowest resonances of this rod, which as many Hz are not"
        if reading:
            at = "" if len(loads) == 1 else f", under mean {load.mean:.4g} N and amplitude {load.amplitude:.4g} N"
            say(f"floquetrod: warning: {name} {text} is taken in rad/s: {reading}{at}; write {_with_unit(text)}")
            return True
    return False


def _with_unit(text: str) -> str:
    """Return a frequency, or a range, as it is written in rad/s and in Hz."""
    typed = text.strip()
    return f"{typed}rad/s or {typed}Hz"


def corners(values: Mapping[Quantity, Sequence[float]], like: Load) -> Iterator[Load]:
    """Yield the loads at the ends of ranges."""
    for numbers in itertools.product(*values.values()):
        yield like.with_numbers(**dict(zip(values, numbers, strict=True)))


def _in_hertz(rod: fr.Rod, load: Load, tolerance: float) -> str:
    """Return how the verdict differs where a frequency is read in Hz, "" where it does not or is not known."""
    try:
        verdicts = verdicts_in_hertz(rod, load, tolerance)
    except ValueError:  # as many Hz are far beyond this rod
        return ""
    words = {(1, 0): ("no mode grows", "one does"), (0, 1): ("a mode grows", "none does")}.get(verdicts)
    return f"at {load.frequency:.4g} rad/s {words[0]}, at {load.frequency:.4g} Hz {words[1]}" if words else ""
