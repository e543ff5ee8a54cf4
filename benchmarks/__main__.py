"""Run the benchmarks named on the command line, or all: every module beside this one that defines ``run``."""

from __future__ import annotations

import importlib
import pkgutil
import sys
from pathlib import Path

from benchmarks.measure import Row

HELPERS = {"__main__", "cosserat", "measure", "peers"}


def main(names: list[str]) -> int:
    """Print one table per benchmark; return 1 when a promise was not kept, 2 when a name is unknown."""
    known = sorted({module.name for module in pkgutil.iter_modules([str(Path(__file__).parent)])} - HELPERS)
    unknown = [name for name in names if name not in known]
    if unknown:
        print(f"no benchmark {', '.join(unknown)}; there are {', '.join(known)}", file=sys.stderr)
        return 2
    kept = True
    for name in names or known:
        rows: list[Row] = importlib.import_module(f"benchmarks.{name}").run()
        print(f"\n{name}\n{table(rows)}")
        kept = kept and not any(row.met is False for row in rows)
    return 0 if kept else 1


def table(rows: list[Row]) -> str:
    """Return the rows as a text table."""
    answers = {True: "yes", False: "NO", None: ""}
    cells = [("what", "value", "unit", "peer takes", "of", "target", "met")]
    cells += [
        (
            row.name,
            f"{row.value:.3g}",
            row.unit,
            "" if row.ratio is None else f"{row.ratio:,.3g} x",
            row.against,
            row.target,
            answers[row.met],
        )
        for row in rows
    ]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return "\n".join("  ".join(map(str.ljust, line, widths)).rstrip() for line in cells)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
