"""What the commands share: their parser, quantities with units, the rod, progress."""

from __future__ import annotations

import argparse
import logging
import math
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple, NoReturn

import floquetrod as fr
from floquetrod import units

KINDS = {"mean": "force", "amplitude": "force", "frequency": "frequency"}
"""Quantities of a load and their kind."""


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


def add_rod(command: argparse.ArgumentParser, *, judged: bool = True) -> None:
    """Add the options that describe a rod and, where it is to be judged, which growth matters."""
    command.add_argument("--rod", required=True, help="nitinol (the reference rod), or a TOML file")
    command.add_argument("--damping-rate", help="decay rate of free motion in 1/s (replaces that of the rod)")
    if judged:
        command.add_argument(
            "--growth-tolerance", default="0", help="growth in 1/s up to which a mode counts as stable"
        )


def add_friction(command: argparse.ArgumentParser) -> None:
    """Add the options that describe friction and a kick."""
    command.add_argument("--mu", type=float, help="coefficient of friction between rod and channel")
    command.add_argument("--kick", help="transverse speed each mode is disturbed with, such as 50mm/s (needs --mu)")


def read_friction(options: argparse.Namespace) -> fr.Coulomb | None:
    """Return friction and kick, None where there is none; a kick left out is zero."""
    if options.mu is None:
        if options.kick is not None:
            raise ValueError("--kick needs --mu: without friction every kick sets off what is unstable")
        return None
    return fr.Coulomb(options.mu, 0.0 if options.kick is None else units.quantity(options.kick, "--kick", "speed"))


def read_quantity(text: str, name: str, rod: fr.Rod) -> float:
    """Return a quantity of the load in SI units."""
    return units.quantity(text, f"--{name}", KINDS[name], critical_force=rod.critical_force)


def read_range(text: str, name: str, rod: fr.Rod) -> list[float]:
    """Return one quantity, or both ends of a range; a first end without a unit has that of the second."""
    first, colon, last = text.partition(":")
    if colon and units.unit_of(first) == "":
        first += units.unit_of(last) or ""
    return [read_quantity(part, name, rod) for part in ((first, last) if colon else (first,))]


def read_rod(options: argparse.Namespace) -> fr.Rod:
    """Return the rod that the options describe."""
    rod = fr.Rod.nitinol() if options.rod == "nitinol" else fr.Rod.from_toml(options.rod)
    if options.damping_rate is not None:
        rod = rod.replace(damping_rate=units.quantity(options.damping_rate, "--damping-rate", "rate"))
    return rod


def number(value: float) -> float | None:
    """Return ``value``, or None where JSON has no number for it: infinite means never, or not within reach."""
    return value if math.isfinite(value) else None


@contextmanager
def compiling_told() -> Iterator[None]:
    """Say on stderr, the first time that something is compiled, what the silence is about."""
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
    """A line on stderr once work has taken a second, when there is a terminal to read it.

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
