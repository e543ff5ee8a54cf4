"""Tables of keys and values that people write in files."""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Iterable
from pathlib import Path
from typing import Any

from floquetrod._util.suggest import did_you_mean

_LARGEST = 1 << 20  # bytes that are read (a choice)


def read_toml(path: Path, what: str) -> dict[str, Any]:
    """Return the table in a TOML file, a pipe or a device; ValueError, which names ``what`` and path, where it cannot.

    More than a megabyte is not read.
    """
    try:
        with path.open("rb") as file:
            content = file.read(_LARGEST + 1)
        if len(content) > _LARGEST:
            raise ValueError(f"it has more than {_LARGEST:,} bytes")
        return tomllib.loads(content.decode("utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise ValueError(f"{what} {path} cannot be read: {error}") from None


def require_known(keys: Iterable[str], known: Collection[str]) -> None:
    """Raise ValueError for the first of ``keys`` that is not known, with the known one like it, or all of them."""
    unknown = next((key for key in keys if key not in known), None)
    if unknown is not None:
        hint = did_you_mean(unknown, known)
        raise ValueError(f"unknown key {unknown!r}{f'{hint} The' if hint else '; the'} keys are {', '.join(known)}")
