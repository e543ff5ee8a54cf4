"""`floquetrod compare`: one equation, every method."""

from __future__ import annotations

import argparse
import json

import floquetrod as fr
from floquetrod.cli.common import Answer, describe_command, number
from floquetrod.cli.parser import real_number
from floquetrod.cli.waiting import Waiting

_HELP = """\
Compare on one equation A'' + 2 c A' = (beta + alpha sin tau) A all methods that apply, and show where they agree.

examples:
  floquetrod compare --alpha 0.5 --beta -0.25
  floquetrod compare --alpha 0.5 --beta -0.25 --damping 0.1 --waveform square
"""


def add(compare: argparse.ArgumentParser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(compare, _HELP, _compare)
    compare.add_argument("--alpha", required=True, type=real_number, help="amplitude of the coefficient")
    compare.add_argument("--beta", required=True, type=real_number, help="mean of the coefficient")
    compare.add_argument("--damping", type=real_number, default=0.0, help="c, per unit tau (default 0)")
    compare.add_argument("--waveform", choices=("sine", "square"), default="sine", help="shape of the coefficient")


def _compare(options: argparse.Namespace) -> Answer:
    kind = fr.Meissner if options.waveform == "square" else fr.Mathieu
    equation = kind(options.alpha, options.beta, options.damping)
    with Waiting("asking every method"):
        comparison = fr.compare(equation)
    if not options.json:
        return Answer(repr(comparison))
    rows = [
        {
            "method": r.method,
            "status": r.status,
            "growth_rate_per_tau": number(r.growth_rate),
            "discriminant": number(r.discriminant),
            "log_abs_discriminant": number(r.log_abs_discriminant),
            "discriminant_relative_error": number(r.error),
            "cost": str(r.cost),
            "seconds": seconds,
            "note": r.note,
        }
        for r, seconds in zip(comparison.results, comparison.seconds, strict=True)
        if isinstance(r, fr.Stability)
    ]
    record = {
        "agree": comparison.agree,
        "disagreements": list(comparison.disagreements),
        "methods": rows,
        "version": fr.__version__,
    }
    return Answer(json.dumps(record, indent=2, allow_nan=False))
