"""`floquetrod lock-up`: how far a string can be pushed along its channel before friction stops it."""

from __future__ import annotations

import argparse

from floquetrod.cli.common import (
    add_coefficient,
    add_push,
    add_rod,
    describe_command,
    read_push,
    read_rod,
    units_shown,
)
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser

_HELP = """\
Say how far a string of this section, of any length, can be pushed down the channel before it locks up.

examples:
  floquetrod lock-up --rod '2.00x0.156 CT90' --bore 4.778in --length 1000m --friction 0.3
  floquetrod lock-up --rod nitinol --friction 0.2 --far-force 0.5Fcr --push 10N

Friction along the channel of a string that lies as a helix wherever it is compressed: at lock-up no force at its upper
end moves the lower one.  With --push also how long a string that force can push.
"""


def add(command: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(command, _HELP, _lock_up, ("rod", "bore", "length", "friction", "push"), has_assumptions=True)
    add_rod(command, classified=False)
    add_coefficient(command, "required")
    add_push(command)
    command.add_argument(
        "--unit", metavar="UNITS", help="units of the answer, such as ft,lbf (default: those of the question)"
    )


def _lock_up(options: argparse.Namespace) -> Output:
    if options.friction is None:
        raise ValueError("--friction is required: without friction nothing locks up; add it, such as --friction 0.3")
    shown = units_shown(options, ("length", "force"), "ft,lbf")
    rod = read_rod(options)
    far, push = read_push(options, rod)
    found = rod.lock_up(options.friction, far)
    return output(options, lambda: found.report(push, **shown), lambda: found.as_dict(push))
