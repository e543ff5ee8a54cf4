"""`floquetrod ranges`: every stability interval of one quantity of the load."""

from __future__ import annotations

import argparse
from typing import Any

from floquetrod._util.result_report import Report
from floquetrod._util.waiting import Waiting
from floquetrod.cli.common import ROD_AND_LOAD, describe_command, figures, write_figures
from floquetrod.cli.loads import add_question, read_ranges
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser
from floquetrod.rod.model.constants import SLOW_GROWTH

_HELP = """\
List the stable and unstable intervals of one quantity of the load: give a range for it, and values for the others.

examples:
  floquetrod example my_rod.toml wire.toml well.toml record.csv
  floquetrod ranges --rod nitinol --amplitude 0.2Fcr --frequency 150rad/s --mean 0:1.2Fcr
  floquetrod ranges --rod nitinol --mean 0.34Fcr --amplitude 0.2Fcr --frequency 10Hz:60Hz --out ranges.png
  floquetrod ranges --rod my_rod.toml --mean 12N --frequency 24Hz --amplitude 0:5N
  floquetrod ranges --rod wire.toml --amplitude 0.2Fcr --frequency 20Hz --mean 0:1Fcr
  floquetrod ranges --rod well.toml --mean 0.5Fcr --frequency 4Hz --amplitude 0:0.5Fcr --wave held
  floquetrod ranges --rod my_rod.toml --force record.csv --mean 0:12N

The ends of the intervals are the boundaries of resonance tongues, computed without a grid.  Tongues that grow no faster
than --growth-tolerance, by default 1e-6 1/s (tenfold in a month), are left out and counted; 0 lists them all.  The
answer is in the unit of the range, or of --unit, and the ends of safe ranges are rounded inwards to the digits shown
(--full has nine); --json is in N and rad/s.  For each unstable band it gives the mode that grows fastest, its growth
rate in 1/s and where it occurs, and the damping rate that stabilises the whole band.

Clamped, guided or free ends, weight along an inclined rod and axial waves (--wave) couple the modes.  Loads are then
sampled, and the answer says how narrow an unstable band may have been missed.  The damping rate is then the one that
stabilises the load with the fastest growth.
"""


def add(ranges: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(ranges, _HELP, _ranges, (*ROD_AND_LOAD, "growth_tolerance"))
    add_question(ranges, ranges=True)
    ranges.add_output("--out", figures, "write a figure (.png, .pdf, .svg)")
    ranges.set_defaults(growth_tolerance=f"{SLOW_GROWTH:g}")
    ranges.add_argument("--full", action="store_true", help="list every interval and band, with nine digits and causes")


def _ranges(options: argparse.Namespace) -> Output:
    asked = read_ranges(options)
    rod, like, values, tolerance, shown, _ = asked
    varied = asked.varied
    if len(varied) != 1:
        other = (
            "of two ranges floquetrod map draws the stability, and certify proves it"
            if varied
            else "floquetrod check answers about one load"
        )
        raise ValueError(
            "exactly one of --mean, --amplitude, --frequency must be a range such as 0:1.2Fcr or 10Hz:60Hz, got "
            f"{asked.varied_in_words}; {other}"
        )
    asked.warn_of_hertz(options)
    low, high = values.pop(varied[0])
    fixed: dict[str, Any] = {name: value for name, (value,) in values.items()}
    with Waiting(f"searching along the {varied[0]}", "parts") as progress:
        found = rod.ranges(varied[0], like, (low, high), **fixed, growth_tolerance=tolerance, progress=progress)
    with Waiting("finding the fastest growth and the damping required", "unstable parts") as progress:
        found.find_unstable(progress)
    unit = shown[varied[0]]
    written = write_figures(options.out, lambda: found.plot(unit=unit))
    is_measured = options.force is not None and isinstance(like.noise, tuple)
    beside = [("", "the errors of its density, which check counts, are left out")] if is_measured else []

    def report() -> Report:
        return asked.titled(found.report(unit, full=options.full).with_lines(beside, before="sampled"))

    return output(options, report, lambda: found.as_dict() | asked.as_numbers, written=written)
