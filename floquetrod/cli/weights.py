"""`floquetrod weights`: pick-up and slack-off weights of a string over its depth, for several factors of friction."""

from __future__ import annotations

import argparse
from functools import partial

from floquetrod._util.waiting import Waiting
from floquetrod.cli.common import (
    add_far_force,
    add_rod,
    add_survey,
    describe_command,
    figures,
    read_force,
    read_rod,
    read_survey,
    write_figures,
)
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser
from floquetrod.cli.reach import (
    add_depths,
    add_helical,
    add_well_file,
    add_wellhead,
    read_depths,
    read_wellhead,
    units_along,
)

_HELP = """\
Draw pick-up and slack-off weights of a string over the depth of its lower end, for several factors of friction.

examples:
  floquetrod example survey.csv tubing.toml
  floquetrod weights --well survey.csv --rod tubing.toml --friction 0.2,0.3,0.4
  floquetrod weights --well survey.csv --rod tubing.toml --friction 0.2,0.3@1500m,0.25,0.4@1500m
  floquetrod weights --well survey.csv --rod tubing.toml --mu 0.2,0.3 --out weights.png --unit ft,lbf
  floquetrod weights --well survey.csv --rod tubing.toml --mu 0.3 --wellhead-pressure 3000psi \\
      --stripper 2kip

The weight is what the hook or the injector carries, negative where it has to push: the weight in fluid, less the push
of --wellhead-pressure on the cross-section, with friction of the wall and of the --stripper against the motion.  A
string that is slacked off may buckle, and ends where it locks up.  Measured weights beside the lines tell the friction
of a well.  In --friction a number begins another factor, and one with a depth continues the one before it: 0.2,0.3 are
two factors, 0.2,0.3@1500m is one of 0.2 down to 1500 m and 0.3 below.  Depths are measured depths.
"""


def add(command: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(command, _HELP, _weights, ("well", "rod", "friction", "out", "unit"), has_assumptions=True)
    add_well_file(command, required=True)
    add_survey(command)
    add_rod(command, classified=False, in_a_well=True)
    command.add_argument(
        "--friction",
        "--mu",
        required=True,
        metavar="LIST",
        help="coefficients of friction with the wall, such as 0.2,0.3,0.4, each with others from a depth on as in "
        "0.2,0.35@1500m",
    )
    add_far_force(command)
    add_wellhead(command, "wellhead_pressure", "stripper")
    add_helical(command)
    add_depths(command)
    command.add_argument(
        "--unit",
        metavar="UNITS",
        help="units of the answer, such as ft,lbf (default: those of the question, else m,kN)",
    )
    command.add_output("--out", figures, "write the chart (.png, .pdf, .svg)")


def _weights(options: argparse.Namespace) -> Output:
    from floquetrod.rod import reading

    shown = units_along(options, "length", "force")
    rod, path = read_rod(options), read_survey(options, options.well)
    with Waiting("moving the string"):
        found = rod.surface_weights(
            path,
            reading.read_frictions(options.friction, "--friction"),
            far_force=read_force(options.far_force, "--far-force", rod),
            depth=None if options.depths is None else read_depths(options.depths),
            helical=options.helical,
            **read_wellhead(options),
        )
    written = write_figures(options.out, partial(found.plot, **shown))
    return output(options, partial(found.report, **shown), found.as_dict, written=written)
