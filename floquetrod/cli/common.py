"""What the commands share: their parser, quantities with units, the rod, progress."""

from __future__ import annotations

import argparse
import logging
import math
import sys
import time
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import floquetrod as fr
from floquetrod import units
from floquetrod._util.files import writable
from floquetrod.floquet.systems.result import Resonance
from floquetrod.rod.load import LIMITS, Quantity
from floquetrod.units import Unit

_TINY, LARGEST = 1e-9, 1e12  # what the library takes, in SI units: a typing error lies beyond

KINDS: dict[Quantity, str] = {"mean": "force", "amplitude": "force", "frequency": "frequency"}
"""Quantities of a load and their kind."""

_SHOWN = ("force", "frequency", "speed")  # kinds of quantity that --unit is for


class Answer(NamedTuple):
    """What a command prints, and its exit status."""

    text: str
    status: int = 0


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        """Raise ValueError, which the terminal shows as one line."""
        raise ValueError(f"{message} (see {self.prog} --help)")


def add_command(commands: Any, name: str, summary: str, text: str, run: Any) -> argparse.ArgumentParser:
    """Add a subcommand whose help begins with the first paragraph of ``text`` and ends with the rest."""
    first, _, rest = text.partition("\n\n")
    command: argparse.ArgumentParser = commands.add_parser(
        name, help=summary, description=first, epilog=rest, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    command.add_argument("--json", action="store_true", help="print JSON, units in the names")
    command.set_defaults(run=run)
    return command


def add_rod(command: argparse.ArgumentParser, subject: Any = None, *, judged: bool = True) -> None:
    """Add the options that describe a rod and, where it is to be classified, which growth matters.

    ``subject`` is the group of options one of which is required, where --rod is one of several.
    """
    text = "nitinol (the reference rod), or a TOML file"
    if subject is None:
        command.add_argument("--rod", required=True, help=text)
    else:
        subject.add_argument("--rod", help=text)
    command.add_argument("--damping-rate", help="decay rate of free motion in 1/s (replaces that of the rod)")
    if judged:
        command.add_argument(
            "--growth-tolerance",
            help="growth in 1/s up to which a mode counts as stable (default 0)",
        )


def add_units(command: argparse.ArgumentParser) -> None:
    """Add the option that says in which units to answer."""
    command.add_argument("--unit", help="units of the answer, such as Hz or Hz,Fcr (default: those of the question)")


def add_friction(command: argparse.ArgumentParser) -> None:
    """Add the options that describe friction and a kick."""
    command.add_argument(
        "--friction", "--mu", type=float, help="coefficient of friction between rod and channel (needs --kick)"
    )
    command.add_argument(
        "--kick", help="transverse speed each mode is disturbed with, such as 50mm/s (needs --friction)"
    )


def read_friction(options: argparse.Namespace) -> tuple[float, float] | None:
    """Return the coefficient of friction and the kick in m/s, None without either; one alone is refused."""
    if options.friction is None:
        if options.kick is not None:
            raise ValueError("--kick needs --friction: without friction an unstable mode grows whatever the kick")
        return None
    if options.kick is None:
        raise ValueError(
            "--friction needs --kick: friction holds every rod that nothing disturbs, so a verdict without a kick "
            "would say nothing; add the transverse speed each mode is disturbed with, such as --kick 50mm/s"
        )
    return options.friction, units.quantity(options.kick, "--kick", "speed", least=_TINY, largest=LARGEST)


def read_tolerance(options: argparse.Namespace) -> float:
    """Return the growth tolerance in 1/s."""
    given = "0" if options.growth_tolerance is None else options.growth_tolerance
    return units.quantity(given, "--growth-tolerance", "rate", least=0.0, largest=LARGEST)


def read_quantity(text: str, name: Quantity, rod: fr.Rod, given: str | None = None) -> float:
    """Return a quantity of the load in SI units; messages quote ``given`` in place of the text."""
    least, largest = LIMITS[name][:2]
    force = rod.critical_force
    return units.quantity(
        text, f"--{name}", KINDS[name], critical_force=force, least=least, largest=largest, given=given
    )


def read_range(text: str, name: Quantity, rod: fr.Rod) -> list[float]:
    """Return one quantity, or both ends of a range; a first end without a unit has that of the second."""
    first, colon, last = text.partition(":")
    if not colon:
        return [read_quantity(text, name, rod)]
    unit = units.unit_of(last) or ""
    ends = [(first + (unit if units.unit_of(first) == "" else ""), first), (last, last)]
    low, high = (read_quantity(end, name, rod, f"{typed!r} in {text!r}") for end, typed in ends)
    if not low < high:
        raise ValueError(f"--{name} must be a range whose first end is the lower one, got {text!r}")
    return [low, high]


def read_units(options: argparse.Namespace, rod: fr.Rod) -> dict[str, Unit]:
    """Return the unit in which to speak of each quantity: that of --unit, else the one it was given in, else SI.

    The end of a range without a unit has that of the other.  The options may have no --kick; its unit is then mm/s.
    """
    chosen: dict[str, str] = {}
    for name in filter(None, (options.unit or "").split(",")):
        kind = units.kind_of(name.strip())
        if kind not in _SHOWN:
            every = "; ".join(f"{kind}: {', '.join(units.units_of(kind, 1.0))}" for kind in _SHOWN)
            raise ValueError(f"--unit must name units such as Hz,Fcr, got {name!r} in {options.unit!r} ({every})")
        if kind in chosen:
            raise ValueError(f"--unit must name one unit of {kind}, got {chosen[kind]} and {name} in {options.unit!r}")
        chosen[kind] = name.strip()
    found: dict[str, Unit] = {}
    for name, kind in [*KINDS.items(), ("kick", "speed")]:
        text = getattr(options, name, None)
        typed = units.unit_of(text.rpartition(":")[2]) if isinstance(text, str) else None
        wanted = chosen.get(kind, ("mm/s" if kind == "speed" else "") if typed is None else typed)
        found[name] = units.unit(wanted, f"--{name}", kind, rod.critical_force)
    return found


def read_rod(options: argparse.Namespace) -> fr.Rod:
    """Return the rod that the options describe."""
    try:
        rod = fr.Rod.nitinol() if options.rod == "nitinol" else fr.Rod.from_toml(options.rod)
    except (ValueError, OSError) as error:
        raise ValueError(f"--rod must be nitinol or a TOML file: {error}") from None
    if options.damping_rate is not None:
        rate = units.quantity(options.damping_rate, "--damping-rate", "rate", least=0.0, largest=LARGEST)
        rod = rod.replace(damping_rate=rate)
    return rod


def check_out(path: Path, kinds: Sequence[str], name: str = "--out") -> None:
    """Raise ValueError, before anything is computed, where a file could not be written."""
    if kinds and path.suffix not in kinds:
        raise ValueError(f"{name} must end in {', '.join(kinds[:-1])} or {kinds[-1]}, got {str(path)!r}")
    try:
        is_folder, has_folder = path.is_dir(), path.parent.is_dir()
    except OSError as error:  # a name too long, say
        raise ValueError(f"{name} {str(path)!r}: {error}") from None
    if is_folder:
        raise ValueError(f"{name} must be a file, and {str(path)!r} is a folder")
    if not has_folder:
        raise ValueError(
            f"{name} {str(path)!r}: there is no folder {str(path.parent)!r}; make it first, or write elsewhere"
        )
    try:
        writable(path)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None


def number(value: float) -> float | None:
    """Return ``value``, or None where JSON has no number for it: infinite means never, or not within reach."""
    return value if math.isfinite(value) else None


def resonance_record(resonance: Resonance, growth: str) -> dict[str, Any]:
    """Return a resonance for JSON, its growth rate under the name ``growth``."""
    return {
        "name": str(resonance),
        "kind": resonance.kind,
        "modes": list(resonance.modes),
        "order": resonance.order,
        growth: resonance.growth_rate,
    }


@contextmanager
def compiling_told() -> Iterator[None]:
    """Report on stderr, the first time that something is compiled, what is being waited for."""
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
            print("floquetrod: compiling (once), some seconds", file=sys.stderr, flush=True)
            self.told = True


class Progress:
    """A progress line on stderr once work has taken a second, if stderr is a terminal.

    Both are counted from the first report: what was done before it may have been done in an earlier run, or taken the
    time to compile.
    """

    def __init__(self, what: str) -> None:
        self.what = what
        self.first: tuple[float, int] | None = None
        self.open = False

    def __call__(self, done: int, total: int) -> None:
        """Report ``done`` of ``total``."""
        now = time.monotonic()
        self.first = self.first or (now, done)
        if now - self.first[0] < 1.0 or not sys.stderr.isatty():
            return
        rate = (done - self.first[1]) / max(now - self.first[0], 1e-9)
        speed = f", {rate:,.0f} a second, {(total - done) / rate:.0f} s left" if rate > 0.0 else ""
        line = f"{done:,} of {total:,} {self.what}{speed}"
        print(f"\r{line:<78}", end="\n" if done == total else "", file=sys.stderr, flush=True)
        self.open = done != total

    def close(self) -> None:
        """End the line where work was cut short."""
        if self.open:
            print(file=sys.stderr, flush=True)
            self.open = False


def roughly(seconds: float) -> str:
    """Return a time in the largest unit of which it has at least two."""
    for unit, length in (("days", 86400.0), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds >= 2.0 * length:
            return f"{seconds / length:.0f} {unit}"
    return f"{seconds:.0f} seconds"


@contextmanager
def warnings_at_once(progress: Progress) -> Iterator[None]:
    """Report a checkpoint that cannot be written at once, while the cause can still be removed."""
    with warnings.catch_warnings():
        collect = warnings.showwarning

        def tell(message: Any, category: Any, *rest: Any, **more: Any) -> None:
            if not issubclass(category, fr.CheckpointWarning):
                collect(message, category, *rest, **more)
                return
            progress.close()
            print(f"floquetrod: warning: {message}", file=sys.stderr, flush=True)

        warnings.simplefilter("default", fr.CheckpointWarning)
        warnings.showwarning = tell
        yield
