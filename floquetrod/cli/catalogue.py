"""`floquetrod catalogue`: the pipes and rods known by their size."""

from __future__ import annotations

import argparse

from floquetrod.cli.common import describe_command
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser

_HELP = """\
List the steel pipes and rods that --rod knows by their size in inches: coiled tubing, drill pipe, tubing, sucker rods.

examples:
  floquetrod catalogue
  floquetrod catalogue 2.00
  floquetrod catalogue '3/4 rod'

Without a size one line a diameter, its walls and its grades with their yield strengths; with the beginning of a name
one line a pipe, in inches and mm, with the weight in air of its body, of sucker rods with their couplings.  Commands on
rods take a whole name: lock-up --rod '2.00x0.156 CT90' --bore 4.778in --length 200ft --friction 0.3.  A rod of your own
is a TOML file; floquetrod example writes some to begin with.
"""


def add(command: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(command, _HELP, _catalogue, ("size",))
    command.add_argument("size", metavar="SIZE", nargs="?", default="", help="beginning of a name such as 2.00 or 3/4")


def _catalogue(options: argparse.Namespace) -> Output:
    from floquetrod.rod.model.catalogue import catalogue

    listed = catalogue(options.size)
    return output(options, listed.report, listed.as_dict)
