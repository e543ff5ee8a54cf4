"""An answer of the terminal: what a result says, as text or as JSON."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from floquetrod._util.report import Report
from floquetrod._util.version import __version__
from floquetrod.units import Unit


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


def names(shown: Mapping[str, Unit]) -> dict[str, str]:
    """Return units by their names, as reports take them."""
    return {name: unit.name for name, unit in shown.items()}
