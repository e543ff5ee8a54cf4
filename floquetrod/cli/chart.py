"""`floquetrod chart`: a family of systems over the plane of two of its parameters."""

from __future__ import annotations

import argparse
from pathlib import Path

import floquetrod as fr
from floquetrod._util.tables import require_file
from floquetrod._util.waiting import Waiting
from floquetrod.cli.common import (
    add_picture,
    bands_in_numbers,
    bands_listed,
    describe_command,
    find_bands,
    read_points,
    require_bands_of_csv,
    write_charts,
)
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser, real_number
from floquetrod.cli.system import unit_of_time, unit_of_time_in_numbers
from floquetrod.equations.system_files import SystemFamily, read_family

_HELP = """\
Draw the stability of a family of systems, whose matrices depend on parameters, over two of these.

examples:
  floquetrod example family.toml
  floquetrod chart --system family.toml
  floquetrod chart --system family.toml --growth --points 300x200 --out tongues.pdf
  floquetrod chart --system family.toml --pixels --out chart.png --out chart.npz --json

The file has a table [system], as for floquetrod check --system, in which a text may stand in place of any number: a
formula of parameters.  The table [parameters] gives two of these a range, the first to be drawn to the right, and any
others a number:

  [system]
  stiffness = [[1, 0], [0, 4]]
  cosines = [[["0.5*epsilon", "epsilon"], ["epsilon", "0.8*epsilon"]]]
  damping = [["2*zeta", 0], [0, "4*zeta"]]
  frequency = "omega"

  [parameters]
  omega = "1.5:4.5"
  epsilon = "0:0.6"
  zeta = 0.01

Formulas have + - * / **, brackets, pi, sqrt, exp, log, sin, cos and tan; in first order without delays also i, for
complex entries.  They are computed, not run: a file from elsewhere can do no harm.  Equations with delays and with
coefficients in pieces are taken likewise.

Systems of several equations take minutes: --points 60x45 takes a quarter of the time for a first look.

The unstable bands are listed, and in the figure a label 1+2·1 says modes 1 + 2, tongue 1: tongue m is where the
frequency is about 2/m times that of one mode, or 1/m of the sum, or the difference, of two.  Tongues that merge in one
band are listed below it, and labelled where they begin.

A .png, .pdf or .svg file is a figure, a .csv file the vertices of the bands, a .npz file all the numbers
(floquetrod.Chart.load reads it); give --out twice for both.  Growth is per unit of time, the unit of the period.
"""


def add(chart: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(chart, _HELP, _chart, ("system", "points", "growth", "out"))
    chart.add_argument("--system", metavar="FILE", required=True, help="a TOML file with a family of systems")
    tolerance = "growth per unit of time up to which a system counts as stable (default: 0)"
    chart.add_argument("--growth-tolerance", metavar="RATE", type=real_number, default=0.0, help=tolerance)
    add_picture(chart, "120x90", "chart.png")


def _chart(options: argparse.Namespace) -> Output:
    require_bands_of_csv(options)
    columns, rows = read_points(options.points)
    family = _read(options)
    over = {name: (*ends, count) for (name, ends), count in zip(family.over.items(), (columns, rows), strict=True)}
    with Waiting("deciding stability", "points") as progress:
        chart = fr.chart(
            family.system,
            over,
            growth=options.growth,
            growth_tolerance=options.growth_tolerance,
            progress=progress,
        )
    bands = find_bands(options, chart)
    written = write_charts(options.out, chart, chart, lambda: chart.plot(bands=bands))
    record = {
        "points": int(chart.stable.size),
        "stable_share": float(chart.stable.mean()),
        "undecided": chart.undecided,
        "bands": len(chart.bands) if bands else None,
        "tongues_left_out": chart.bands.tongues_left_out if bands else None,
        "unstable": bands_in_numbers(chart.bands) if bands else None,
        **unit_of_time_in_numbers(family.with_unit),
    }
    lines = [chart.caption, *([bands_listed(chart.bands)] if bands else []), *unit_of_time(family.with_unit)]
    return output(options, lambda: "\n".join(lines), lambda: record, written=written)


def _read(options: argparse.Namespace) -> SystemFamily:
    """Return the family of ``options.system``."""
    require_file("--system", Path(options.system), "a TOML file")
    try:
        return read_family(options.system)
    except ValueError as error:
        raise ValueError(f"--system: {error}") from None
