"""The files of `floquetrod/examples`, which help texts and pages name and `floquetrod example` writes."""

from __future__ import annotations

import re
from pathlib import Path

_FOLDER = Path(__file__).parents[1] / "examples"


def names() -> list[str]:
    """Return the names of the files there are."""
    return sorted(file.name for file in _FOLDER.iterdir() if file.name.endswith((".toml", ".csv")))


def content(name: str) -> str:
    """Return the text of a file."""
    return (_FOLDER / name).read_text(encoding="utf-8")


def summary(name: str) -> str:
    """Return the first sentence of a file, which describes its content."""
    first = content(name).partition("\n")[0].removeprefix("# ")
    return re.split(r"(?<=[.?])\s", first)[0]


def commands(name: str) -> list[str]:
    """Return the commands that the first lines of a file show."""
    return re.findall(r"^#   (floquetrod .+)$", content(name), re.MULTILINE)


def where_to_get(name: str) -> str:
    """Return what to say of a file that is missing and is one of these: the command that writes it; "" of others."""
    return f"; floquetrod example {name} writes an example" if name in names() else ""
