"""`floquetrod reproduce`: the published study, recomputed."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

from floquetrod._util.waiting import say
from floquetrod.cli.common import describe_command
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser

_HELP = """\
Recompute the figures and check the claims of the published study (DOI 10.1115/1.4031710).

examples:
  floquetrod reproduce --quick
  floquetrod reproduce --out my_folder
  floquetrod reproduce --simulations --out my_folder

Writes the figures (PNG), claims.md, claims.json and report.html, which holds everything.  --quick takes coarser maps
and some seconds.  --simulations adds Figures 4 and 7 and claims F4, F7 and E by simulating the whole rod 89 times, some
two minutes of processor time shared among all processors; with --quick 65 times.  The exit status is 1 if the verdict
on a claim differs from the one that this version expects.
"""


def add(reproduce: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(reproduce, _HELP, _reproduce, ("quick", "simulations", "out", "json"))
    reproduce.add_argument("--quick", action="store_true", help="coarser maps, in seconds")
    reproduce.add_argument("--simulations", action="store_true", help="simulate the rods of Figures 4 and 7, too")
    reproduce.add_argument(
        "--out", metavar="FOLDER", type=Path, default=Path("reproduction"), help="folder (default: reproduction)"
    )


def _reproduce(options: argparse.Namespace) -> Output:
    from floquetrod.studies.report import verdict
    from floquetrod.studies.reproduction import FULL, QUICK, reproduce

    if options.out.exists() and not options.out.is_dir():
        raise ValueError(f"--out must be a folder, and {str(options.out)!r} is a file")
    detail = QUICK if options.quick else FULL
    result = reproduce(options.out, detail=detail, simulations=options.simulations, progress=_progress())
    status = 1 if result.lost else 0
    written = [str(path) for path in result.written]
    record = {"written": written, "claims": {claim.id: verdict(claim) for claim in result.claims}}
    lines = [f"{claim.id:<7} {verdict(claim):<8} {claim.computed}" for claim in result.claims]
    return output(options, lambda: "\n".join([*lines, "", f"written: {', '.join(written)}"]), lambda: record, status)


def _progress() -> Any:
    """Return a function that says on stderr what is being done or, of simulations, was done, and since when."""
    start = time.monotonic()

    def progress(what: str, done: int, total: int) -> None:
        say(f"[{done:2d}/{total}] {time.monotonic() - start:5.1f} s  {what}")

    return progress
