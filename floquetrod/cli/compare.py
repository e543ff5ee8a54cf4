"""`floquetrod compare`: one equation, every method."""

from __future__ import annotations

import argparse

import floquetrod as fr
from floquetrod._util.waiting import Waiting
from floquetrod.cli.common import describe_command
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser, real_number

_HELP = """\
Compare on one equation A'' + 2 c A' = (beta + alpha sin tau) A all methods that apply, and show where they agree.

examples:
  floquetrod compare --alpha 0.5 --beta -0.25
  floquetrod compare --alpha 0.5 --beta -0.25 --damping 0.1 --waveform square
"""


def add(compare: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(compare, _HELP, _compare, ("alpha", "beta", "damping", "waveform", "json"))
    compare.add_argument("--alpha", required=True, type=real_number, help="amplitude of the coefficient")
    compare.add_argument("--beta", required=True, type=real_number, help="mean of the coefficient")
    compare.add_argument("--damping", type=real_number, default=0.0, help="c, per unit tau (default 0)")
    compare.add_argument("--waveform", choices=("sine", "square"), default="sine", help="shape of the coefficient")


def _compare(options: argparse.Namespace) -> Output:
    kind = fr.Meissner if options.waveform == "square" else fr.Mathieu
    equation = kind(options.alpha, options.beta, options.damping)
    with Waiting("asking every method"):
        comparison = fr.compare(equation)
    return output(options, comparison.report, comparison.as_dict)
