"""`floquetrod check --system` and `certify --system`: one system of equations from a file."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import cast

import floquetrod as fr
from floquetrod._util.tables import require_file
from floquetrod._util.waiting import Waiting
from floquetrod.cli.messages import option
from floquetrod.cli.output import Output, output
from floquetrod.equations.system_files import SystemFile, read_system_file
from floquetrod.floquet.verdict import Status

_OF_A_SYSTEM = ("command", "system", "set", "method", "exit_code", "json")
"""Options that go with a system."""


def require_alone(options: argparse.Namespace) -> None:
    """Raise ValueError where options of a rod were given beside a system."""
    for name, value in vars(options).items():
        if name not in _OF_A_SYSTEM and value != options.parser.get_default(name):
            got = "" if isinstance(value, bool) else f", got {str(value)!r}"
            margins = "; fr.margin in Python finds the margins of its parameters" if name == "margins" else ""
            raise ValueError(f"{option(name)} belongs to --rod{got}: a system is described by its file alone{margins}")


def classify(options: argparse.Namespace) -> tuple[Output, Status]:
    """Return what to print about the system of ``options.system``, and the verdict."""
    system, with_unit = _read(options)
    with Waiting("deciding stability, and what damping it takes"):
        result = fr.stability(system, method=options.method or "auto")
        said = output(
            options,
            lambda: "\n\n".join([str(result.report(damping=True)), *unit_of_time(with_unit)]),
            lambda: result.as_dict(damping=True) | unit_of_time_in_numbers(with_unit),
        )
    return said, result.status


def prove(options: argparse.Namespace) -> tuple[Output, Status]:
    """Return what to print about the proof of the system of ``options.system``, and what was proved."""
    system, with_unit = _read(options)
    with Waiting("proving"):
        proof = cast(fr.results.Proof, fr.certify(system))  # no box
    said = output(
        options,
        lambda: "\n".join([str(proof.report()), *unit_of_time(with_unit)]),
        lambda: proof.as_dict() | unit_of_time_in_numbers(with_unit),
    )
    return said, proof.status


def unit_of_time(with_unit: str) -> list[str]:
    """Return a line on the unit of time where a time or a frequency in a system file is ``with_unit``, else none."""
    if not with_unit:
        return []
    return [f"Time is in seconds, because {with_unit} has a unit: the matrices must be in seconds, too."]


def unit_of_time_in_numbers(with_unit: str) -> dict[str, str | None]:
    """Return the unit of time for JSON: "s" where a time or a frequency has a unit, else None, the file's own."""
    return {"time_unit": "s" if with_unit else None}


def _read(options: argparse.Namespace) -> SystemFile:
    """Return the system of ``options.system``, and what there has a unit."""
    require_file("--system", Path(options.system), "a TOML or npz file")
    try:
        return read_system_file(options.system, _values(options.set))
    except ValueError as error:
        raise ValueError(f"--system: {error}") from None


def _values(typed: list[str]) -> dict[str, str]:
    """Return the parameters of --set as texts by name."""
    values: dict[str, str] = {}
    for text in typed:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise ValueError(f"--set must be a parameter and its value such as omega=2.5, got {text!r}")
        if values.setdefault(name, value) != value:
            raise ValueError(f"--set must give {name} once, got {values[name]!r} and {value!r}")
    return values
