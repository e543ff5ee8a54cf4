"""`floquetrod report`: a rod under a load in one file."""

from __future__ import annotations

import argparse
from pathlib import Path

import floquetrod as fr
from floquetrod._util.waiting import Waiting
from floquetrod.cli import reach
from floquetrod.cli.common import (
    ROD_AND_LOAD,
    add_project,
    command_typed,
    describe_command,
    documents,
    files_named,
    read_tolerance,
    read_units,
    write_each,
)
from floquetrod.cli.loads import add_question, read_question
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser
from floquetrod.rod.model.wellhead import WELLHEAD

_HELP = """\
Write a report on a rod under a load into one file: a page with its figures, or a PDF.

examples:
  floquetrod example tubing.toml survey.csv
  floquetrod report --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr --frequency 150rad/s --out nitinol.html
  floquetrod report --rod tubing.toml --mean 3kN --amplitude 2kN --frequency 4Hz --out tubing.pdf
  floquetrod report --rod tubing.toml --mean 3kN --amplitude 2kN --frequency 4Hz --well survey.csv --mu 0.3

It holds what was asked about, the verdict with growth and margins, a map of mean forces and frequencies about the load,
the constant forces at which the rod buckles by the literature, the stress and its share of yield where the grade is
known, the assumptions, and the command that makes it again; with --motion how large the motion becomes, and with --well
how far the string can be pushed into that well.
"""


def add(command: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(command, _HELP, _report, (*ROD_AND_LOAD, "out"))
    add_question(command)
    reach.add_well(command, required=False)
    command.add_argument(
        "--margins",
        action=argparse.BooleanOptionalAction,
        help="compute the margins and the damping that stabilises (default: where that takes some seconds)",
    )
    command.add_argument(
        "--motion", action="store_true", help="say how large the motion becomes, all modes together: some seconds"
    )
    add_project(command)
    command.add_output("--out", documents, "file to write (.html, .pdf)", default="report.html")


def _report(options: argparse.Namespace) -> Output:
    _require_well(options)
    rod, record, load, source = read_question(options)
    tolerance, shown = read_tolerance(options), read_units(options, rod, load)
    pushed = None if options.well is None else reach.read_reach(options, rod)
    with Waiting("deciding stability", "verdicts") as progress:
        verdict = rod.stability(source, growth_tolerance=tolerance, progress=progress)
    motion = None
    if options.motion:
        with Waiting(f"{verdict.status}; following the motion"):
            motion = rod.steady_motion(load)

    def write(path: Path) -> None:
        with Waiting(f"{verdict.status}; writing {path}", "percent") as progress:
            fr.save_report(
                verdict,
                path,
                reach=pushed,
                motion=motion,
                record=record,
                units=shown,
                margins=options.margins,
                command=command_typed(),
                project=options.project,
                files=files_named(options),
                progress=progress,
            )

    written = write_each(options.out, write)
    headline = verdict.report(shown).headline
    return output(options, lambda: headline, lambda: {"status": verdict.status}, written=written)


def _require_well(options: argparse.Namespace) -> None:
    """Raise ValueError where options about a well miss it, or it misses its friction."""
    if options.well is not None and options.friction is None:
        raise ValueError("--well needs --friction, the coefficient with its wall, such as --friction 0.3")
    if options.well is None:
        for name in ("friction", "tool", "push", *WELLHEAD):
            if (given := getattr(options, name)) is not None:
                raise ValueError(
                    f"--{name.replace('_', '-')} needs --well, got {given!r} alone: it is about the well the string is "
                    "pushed into; add --well survey.csv"
                )
