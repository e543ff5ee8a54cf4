"""An answer of the terminal: what a result says, as text or as JSON."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from floquetrod._util.result_report import Report
from floquetrod._util.version import __version__


class Output(NamedTuple):
    """What a command prints, and its exit status."""

    text: str
    status: int = 0


def output(
    options: argparse.Namespace,
    report: Callable[[], Report | str],
    record: Callable[[], dict[str, Any]],
    status: int = 0,
    written: Sequence[str] = (),
) -> Output:
    """Return the report, or the record with the version where JSON was asked for; the other is not made.

    Both tell which files were ``written``, of commands that write any.  JSON has all assumptions, the report
    on request.
    """
    if options.json:
        files = {"written": list(written)} if written or options.parser.outputs else {}
        return Output(json.dumps({**record(), **files, "version": __version__}, indent=2, allow_nan=False), status)
    said = report()
    if isinstance(said, Report) and getattr(options, "assumptions", False):
        said = said.with_assumptions()
    return Output("\n".join([str(said), *([f"written: {', '.join(written)}"] if written else [])]), status)
