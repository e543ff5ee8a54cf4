"""Run the benchmarks named on the command line, or all: every module beside this one that defines ``run``.

`--page FILE` writes the tables as a page of Markdown, with the machine and the versions of what ran.
"""

from __future__ import annotations

import argparse
import datetime
import importlib
import os
import pkgutil
import platform
import sys
from collections.abc import Iterator, Sequence
from importlib import metadata
from pathlib import Path

from benchmarks.measure import Row

HELPERS = {"__main__", "cosserat", "measure", "peers"}
PACKAGES = (
    *("floquetrod", "numpy", "scipy", "numba", "mpmath"),
    *("skhippr", "pyelastica", "welleng", "torque_drag", "qutip", "bifpy"),  # the peers, where they are installed
)
_COLUMNS = ("what", "value", "unit", "peer takes", "of", "target", "met")


def main(arguments: Sequence[str]) -> int:
    """Print one table per benchmark; return 1 when a promise was not kept, 2 when a name is unknown."""
    known = sorted({module.name for module in pkgutil.iter_modules([str(Path(__file__).parent)])} - HELPERS)
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"one of {', '.join(known)}; all by default")
    parser.add_argument("--page", type=Path, metavar="FILE", help="write the tables as a page of Markdown, too")
    options = parser.parse_args(arguments)
    unknown = [name for name in options.names if name not in known]
    if unknown:
        print(f"no benchmark {', '.join(unknown)}; there are {', '.join(known)}", file=sys.stderr)
        return 2
    tables: dict[str, list[Row]] = {}
    for name in options.names or known:
        tables[name] = importlib.import_module(f"benchmarks.{name}").run()
        print(f"\n{name}\n{table(tables[name])}")
        if options.page:  # after each, so that what was measured is kept if a later one fails
            options.page.write_text("\n".join(page(tables)) + "\n", encoding="utf-8")
    return 0 if not any(row.met is False for rows in tables.values() for row in rows) else 1


def table(rows: list[Row]) -> str:
    """Return the rows as a text table."""
    cells = [_COLUMNS, *map(_cells, rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return "\n".join("  ".join(map(str.ljust, line, widths)).rstrip() for line in cells)


def page(tables: dict[str, list[Row]]) -> Iterator[str]:
    """Yield the lines of a page of Markdown: machine and versions, then a table for each benchmark."""
    yield "# Figures beside peers\n"
    yield f"One run of `python -m benchmarks` on {datetime.date.today():%d %B %Y}: {_processor()}, {os.cpu_count()}"
    yield f"threads, {platform.system()}, Python {platform.python_version()}, {', '.join(_versions())}."
    yield "Ratios carry over to other machines, absolute times do not. *Peer takes* is the peer's figure over ours:"
    yield "below 1 the peer is better."
    better = [f"{row.name} ({row.against}, {_ratio(row)})" for rows in tables.values() for row in rows if _loses(row)]
    if better:
        yield f"\nA peer takes less in: {'; '.join(better).replace('|', chr(92) + '|')}."
    for name, rows in tables.items():
        documentation = (importlib.import_module(f"benchmarks.{name}").__doc__ or "").strip().split("\n\n")[0]
        yield f"\n## {name}\n\n{documentation}\n"
        yield f"| {' | '.join(_COLUMNS)} |"
        yield f"|{' --- |' * len(_COLUMNS)}"
        for row in rows:
            yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in _cells(row))} |"


def _loses(row: Row) -> bool:
    """Return whether the peer's figure is smaller."""
    return row.ratio is not None and row.ratio < 1.0


def _ratio(row: Row) -> str:
    """Return the peer's figure over ours as text."""
    return "" if row.ratio is None else f"{row.ratio:,.3g} x"


def _cells(row: Row) -> tuple[str, ...]:
    """Return the texts of a row."""
    ratio = _ratio(row)
    answer = {True: "yes", False: "NO", None: ""}[row.met]
    return row.name, f"{row.value:.3g}", row.unit, ratio, row.against, row.target, answer


def _processor() -> str:
    """Return the name of the processor, as Linux tells it, or of its architecture."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def _versions() -> Iterator[str]:
    """Yield the versions of the packages that are installed."""
    for package in PACKAGES:
        try:
            yield f"{package} {metadata.version(package)}"
        except metadata.PackageNotFoundError:
            continue


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
