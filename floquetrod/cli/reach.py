"""`floquetrod reach`: how far a string can be pushed into a well that bends, and whether a vibration tool helps."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

import floquetrod as fr
from floquetrod import units
from floquetrod._util.waiting import Waiting
from floquetrod.cli.common import (
    add_project,
    add_push,
    add_rod,
    add_survey,
    add_tool,
    add_wall_friction,
    command_typed,
    describe_command,
    documents,
    figures,
    files_named,
    read_push,
    read_rod,
    read_survey,
    units_shown,
    write_each,
    write_figures,
)
from floquetrod.cli.messages import option
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser
from floquetrod.rod.model.wellhead import WELLHEAD

_SPEED = "0.05m/s"  # where none is given
_EVEN = 10  # depths between two ends

_HELP = """\
Compute how far a string, also a tapered one, can be pushed into a well, without and with a vibration tool.

examples:
  floquetrod example survey.csv tubing.toml
  floquetrod reach --well survey.csv --rod tubing.toml --friction 0.3
  floquetrod reach --well survey.csv --rod tubing.toml --mu 0.3 --tool 5kN@18Hz@30m --speed 0.2m/s
  floquetrod reach --well survey.csv --rod tubing.toml --friction 0.25,0.35@1500m --push 50kN
  floquetrod reach --well survey.csv --rod tubing.toml --friction 0.3 --out reach.png
  floquetrod reach --well survey.csv --rod tubing.toml --mu 0.3 --depths 9000:9900ft --unit ft,lbf

The survey has columns such as MD (m), Inc (deg) and Azi (deg).  The string is pushed at the first station; its length
and inclination follow from the well.  It reaches the greatest depth at which no stress exceeds --yield-share of the
yield strength, where that is known, with no more than --push at the surface; at lock-up, which is told beside it, no
force moves the lower end.  The table has the force required at the surface, and the largest force that reaches the
bit.  With --wellhead-pressure and --stripper the injector works against these too, and with --pressure-inside the
stress is von Mises' with that of the pressures.  A tool inside the string sends half its force each way, one at the
lower end all of it up.  Friction is reduced where the wave moves the string faster than it slides, so that the gain
hangs on --speed: it is told for three speeds.  The wave may make lateral waves grow against friction: the answer says
where, at what rate and with which half wave, and which frequencies of the tool are useful, that is, gain reach without
such growth.  Depths are measured depths; forces are effective, positive in compression.
"""


def add(command: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(command, _HELP, _reach, ("well", "rod", "friction", "tool", "speed"), has_assumptions=True)
    add_well(command, required=True)
    add_survey(command)
    add_rod(command, classified=False, in_a_well=True)
    add_depths(command)
    command.add_argument(
        "--unit",
        metavar="UNITS",
        help="units of the answer, such as ft,lbf,psi,rpm (default: those of the question: its options, its "
        "survey, its rod; else m,kN,MPa,Hz)",
    )
    command.add_output("--out", figures, "write a figure (.png, .pdf, .svg)")
    add_project(command)
    command.add_output("--report", documents, "write a report with all of it into one file (.html, .pdf)")


def add_well(command: argparse.ArgumentParser, *, required: bool) -> None:
    """Add the options that describe a well and how a string is pushed into it."""
    add_well_file(command, required=required)
    add_wall_friction(command, required=required)
    add_tool(command)
    command.add_argument(
        "--speed",
        default=_SPEED,
        help="speed at which the string slides while the tool works, such as 40ft/min (default 0.05m/s)",
    )
    add_push(command)
    add_wellhead(command, *WELLHEAD)
    command.add_argument(
        "--yield-share",
        metavar="SHARE",
        default="0.8",
        help="largest stress as a fraction of the yield strength, such as 0.6 or 60%%, or none for any (default 0.8)",
    )
    add_helical(command)


def add_well_file(command: argparse.ArgumentParser, *, required: bool) -> None:
    """Add the option of the file that holds the survey of a well."""
    command.add_argument("--well", required=required, metavar="FILE", type=Path, help="survey, a text file of columns")


def add_helical(command: argparse.ArgumentParser) -> None:
    """Add the option of the criterion for a helix."""
    command.add_argument(
        "--helical",
        choices=("energy", "loading", "alone", "always"),
        default="energy",
        help="when it becomes a helix: from sqrt(2), 1.83 or 2 sqrt(2) times the force at which it snakes, or always "
        "(default: energy, the first)",
    )


def add_depths(command: argparse.ArgumentParser) -> None:
    """Add the option of the depths of the lower end."""
    command.add_argument(
        "--depths",
        metavar="LIST",
        help="measured depths of the lower end, such as 9000ft,9500ft, or 9000:9900ft for ten of them "
        "(default: all of the well)",
    )


def add_wellhead(command: argparse.ArgumentParser, *names: str) -> None:
    """Add the options for parameters of a wellhead, which `read_wellhead` reads."""
    for name in names:
        described = WELLHEAD[name].option
        if described is not None:
            command.add_argument(option(name), metavar=described.metavar, help=described.help)


def read_wellhead(options: argparse.Namespace) -> dict[str, str]:
    """Return the parameters of the wellhead that were given, as typed."""
    return {name: text for name in WELLHEAD if (text := getattr(options, name, None)) is not None}


def read_reach(options: argparse.Namespace, rod: fr.Rod, depth: Sequence[str] | None = None) -> fr.results.Reach:
    """Return how far a string can be pushed into the well of the options, with the forces at depths with their unit."""
    from floquetrod.rod import reading

    path, (far_force, push) = read_survey(options, options.well), read_push(options, rod)
    share = options.yield_share.strip().lower()
    with Waiting("pushing the string"):
        reach = rod.reach(
            path,
            reading.read_friction(options.friction, "--friction"),
            tool=None if options.tool is None else reading.read_tool(options.tool, "--tool"),
            speed=units.quantity(options.speed, "--speed", "speed"),
            far_force=far_force,
            push=push,
            yield_share=None if share == "none" else units.quantity(share, "--yield-share", "ratio"),
            helical=options.helical,
            depth=depth,
            **read_wellhead(options),
        )
    typed = units.GivenUnits.of(speed=options.speed if options.speed != _SPEED else None)
    return reach.given_in(typed.or_else(reach.given_units._replace(speed="")))


def _reach(options: argparse.Namespace) -> Output:
    shown = units_along(options, "length", "force", "pressure", "frequency")
    found = read_reach(options, read_rod(options), None if options.depths is None else read_depths(options.depths))
    named = {"length" if name == "depth" else name: unit for name, unit in shown.items()}
    written = write_figures(options.out, partial(found.plot, **shown)) + write_each(
        options.report,
        lambda path: fr.save_report(
            found, path, units=named, command=command_typed(), project=options.project, files=files_named(options)
        ),
    )
    return output(options, partial(found.report, **shown), found.as_dict, written=written)


def units_along(options: argparse.Namespace, *kinds: str) -> dict[str, str]:
    """Return the units of an answer along a well, by the names of its arguments: lengths are depths."""
    shown = units_shown(options, kinds, "ft,lbf")
    return {"depth" if kind == "length" else kind: name for kind, name in shown.items()}


def read_depths(text: str) -> list[str]:
    """Return the depths of a list, or ten from one to another, in one unit; a unit at the end is the unit of all."""
    parts = text.replace(":", ",").split(",")
    values = [units.quantity(each, "--depths", "length") for each in units.same_unit(*parts)]
    if ":" in text:
        if len(values) != 2:
            raise ValueError(
                f"--depths must be a list such as 9000ft,9500ft or two ends such as 9000:9900ft, got {text!r}"
            )
        values = np.linspace(values[0], values[1], _EVEN).tolist()
    unit = units.unit(units.unit_of(parts[-1]) or "", "--depths", "length")
    return [f"{float(unit.of(each))!r}{unit.name}" for each in values]
