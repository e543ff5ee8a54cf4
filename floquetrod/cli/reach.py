"""`floquetrod reach`: how far a string can be pushed into a well that bends, and whether a vibration tool helps."""

from __future__ import annotations

import argparse
from pathlib import Path

import floquetrod as fr
from floquetrod import units
from floquetrod.cli.common import add_rod, add_survey_units, check_out, describe_command, read_rod, read_survey
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser
from floquetrod.cli.waiting import Waiting

_HELP = """\
Say how far a string of this section can be pushed into a well, and what a tool that shakes it changes.

examples:
  floquetrod reach --well examples/survey.csv --rod examples/tubing.toml --friction 0.3
  floquetrod reach --well examples/survey.csv --rod examples/tubing.toml --friction 0.3 --tool 5kN@18Hz@30m
  floquetrod reach --well examples/survey.csv --rod examples/tubing.toml --friction 0.25,0.35@1500m --push 50kN
  floquetrod reach --well examples/survey.csv --rod examples/tubing.toml --friction 0.3 --figure reach.png

The survey has columns such as MD (m), Inc (deg) and Azi (deg).  The string is pushed at the first station; its length
and inclination follow from the well.  At lock-up no force there moves the lower end.  The table has the force that it
takes at the injector, and the greatest that arrives at the bit.  A tool inside the string sends half its force each
way, one at the lower end all of it up.  Friction is less as far as the wave moves the string faster than it slides,
--speed.  The wave may make waves across the string grow against friction: the answer says where, how fast and in which
half wave, and which frequencies of the tool are useful: they gain reach, and nothing grows.  Depths are measured
depths; forces are effective, push positive; without --push the upper end is pushed as hard as it takes.
"""


def add(command: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(command, _HELP, _reach, ("well", "rod", "friction", "tool", "figure"))
    add_well(command, required=True)
    add_survey_units(command)
    add_rod(command, classified=False, in_a_well=True)
    command.add_argument("--figure", metavar="FILE", type=Path, help="write a figure of all of it (.png, .pdf, .svg)")


def add_well(command: argparse.ArgumentParser, *, required: bool) -> None:
    """Add the options that describe a well and how a string is pushed into it."""
    command.add_argument("--well", required=required, metavar="FILE", type=Path, help="survey, a text file of columns")
    command.add_argument(
        "--friction",
        "--mu",
        required=required,
        metavar="MU",
        help="coefficient of friction with the wall, such as 0.3, or 0.2,0.35@1500m with another from 1500 m on",
    )
    command.add_argument(
        "--tool", metavar="FORCE@FREQUENCY[@LENGTH]", help="a tool that shakes the string, that far above its lower end"
    )
    command.add_argument("--speed", default="0.05m/s", help="speed at which the string slides (default 0.05m/s)")
    command.add_argument("--far-force", metavar="FORCE", default="0", help="mean force at the lower end (default: 0)")
    command.add_argument("--push", metavar="FORCE", help="force at the upper end, such as 20kN")
    command.add_argument(
        "--helical",
        choices=("energy", "loading", "alone", "always"),
        default="energy",
        help="when it becomes a helix: from sqrt(2), 1.83 or 2 sqrt(2) times the force at which it snakes, or always",
    )


def read_reach(options: argparse.Namespace, rod: fr.Rod) -> fr.Reach:
    """Return how far a string can be pushed into the well of the options."""
    from floquetrod.rod import reading

    path = read_survey(options, options.well)
    with Waiting("pushing the string"):
        return rod.reach(
            path,
            reading.read_friction(options.friction, "--friction"),
            tool=None if options.tool is None else reading.read_tool(options.tool, "--tool"),
            speed=units.quantity(options.speed, "--speed", "speed"),
            far_force=_force(options.far_force, "--far-force", rod),
            push=None if options.push is None else _force(options.push, "--push", rod),
            helical=options.helical,
        )


def _reach(options: argparse.Namespace) -> Output:
    from floquetrod.plotting import charts

    if options.figure is not None:
        check_out(options.figure, charts.FIGURES, "--figure")
    found = read_reach(options, read_rod(options))
    if options.figure is not None:
        charts.save_figure(found.plot(), options.figure)
    return output(options, found.report, found.as_dict)


def _force(text: str, name: str, rod: fr.Rod) -> float:
    return units.quantity(text, name, "force", critical_force=rod.critical_force)
