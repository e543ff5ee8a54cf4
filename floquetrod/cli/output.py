"""An answer of the terminal: what a result says, as text or as JSON."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from typing import Any, NamedTuple

from floquetrod._util.report import Report
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
) -> Output:
    """Return the report, or the record with the version where JSON was asked for; the other is not made."""
    if options.json:
        return Output(json.dumps({**record(), "version": __version__}, indent=2, allow_nan=False), status)
    return Output(str(report()), status)
