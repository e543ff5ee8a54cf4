"""`python -m studies`: the published study, recomputed."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from floquetrod._util.waiting import say
from floquetrod.cli.common import compiling_told
from floquetrod.cli.main import drop_unwritten
from floquetrod.cli.output import Output, output
from studies.report import verdict
from studies.reproduction import FULL, QUICK, draw_one, reproduce

_HELP = """\
Recompute the figures and check the claims of the published study (DOI 10.1115/1.4031710).

examples:
  python -m studies --quick
  python -m studies --out my_folder
  python -m studies --simulations --out my_folder
  python -m studies --only 3b

Writes the figures (PNG), claims.md, claims.json and report.html, which holds everything.  --quick takes coarser maps
and some seconds.  --simulations adds Figures 4 and 7 and claims F4, F7 and E by simulating the whole rod 89 times, some
two minutes of processor time shared among all processors; with --quick 65 times.  The exit status is 1 if the verdict
on a claim differs from the one that this version expects, 2 for input it cannot use and 130 after Ctrl-C.  --only draws
one figure, or one panel of it, as PNG and PDF with its data as CSV, and checks no claim.
"""


def _reproduce(options: argparse.Namespace) -> Output:
    if options.out.exists() and not options.out.is_dir():
        raise ValueError(f"--out must be a folder, and {str(options.out)!r} is a file")
    detail = QUICK if options.quick else FULL
    if options.only is not None:
        if options.simulations:
            raise ValueError(f"--simulations is for the whole study, got it beside --only {options.only}; leave it out")
        paths = draw_one(options.out, options.only, detail=detail, progress=_progress())
        names = [str(path) for path in paths]
        return output(options, lambda: f"drawn: {options.only}", dict, written=names)
    result = reproduce(options.out, detail=detail, simulations=options.simulations, progress=_progress())
    status = 1 if result.lost else 0
    written = [str(path) for path in result.written]
    record = {"claims": {claim.id: verdict(claim) for claim in result.claims}}
    lines = [f"{claim.id:<7} {verdict(claim):<8} {claim.computed}" for claim in result.claims]
    return output(options, lambda: "\n".join([*lines, ""]), lambda: record, status, written)


def _progress() -> Callable[[str, int, int], None]:
    """Return a function that says on stderr what is being done or, of simulations, was done, and since when."""
    start = time.monotonic()

    def progress(what: str, done: int, total: int) -> None:
        say(f"[{done:2d}/{total}] {time.monotonic() - start:5.1f} s  {what}")

    return progress


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command and return the exit status."""
    parser = argparse.ArgumentParser("python -m studies", formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.description, _, parser.epilog = _HELP.partition("\n\n")
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--quick", action="store_true", help="coarser maps, in seconds")
    parser.add_argument("--simulations", action="store_true", help="simulate the rods of Figures 4 and 7, too")
    parser.add_argument("--only", metavar="FIGURE", help="one figure with its data: 3, its panel 3b, or kick")
    parser.add_argument(
        "--out", metavar="FOLDER", type=Path, default=Path("reproduction"), help="folder (default: reproduction)"
    )
    options = parser.parse_args(argv)
    try:
        with compiling_told():
            answer = _reproduce(options)
        print(answer.text, flush=True)
    except BrokenPipeError:  # the reader has seen enough
        return 0
    except (ValueError, OSError) as error:
        say(f"studies: error: {error}")
        return 2
    except KeyboardInterrupt:
        say("studies: interrupted")
        return 130
    finally:
        drop_unwritten()
    return answer.status


if __name__ == "__main__":
    sys.exit(main())
