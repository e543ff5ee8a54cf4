"""Tables of keys and values that people write in files."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any

from floquetrod._util.example_files import where_to_get
from floquetrod._util.sealed_files import require_regular
from floquetrod._util.suggest import did_you_mean

_LARGEST = 1 << 20  # bytes that are read (a choice)


def read_toml(path: Path, what: str) -> dict[str, Any]:
    """Return the table in a TOML file of at most a megabyte; ValueError names ``what`` and path where it cannot."""
    import tomllib

    try:
        require_regular(path)
        with path.open("rb") as file:
            content = file.read(_LARGEST + 1)
        if len(content) > _LARGEST:
            raise ValueError(f"it has more than {_LARGEST:,} bytes")
        return tomllib.loads(content.decode("utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise ValueError(f"{what} {path} cannot be read: {error}") from None


def require_keys(keys: Iterable[str], known: Collection[str]) -> None:
    """Raise ValueError for the first unknown of ``keys``, with the nearest known one, or all of them."""
    unknown = next((key for key in keys if key not in known), None)
    if unknown is not None:
        hint = did_you_mean(unknown, known)
        raise ValueError(f"unknown key {unknown!r}{f'{hint} The' if hint else '; the'} keys are {', '.join(known)}")


def require_file(name: str, path: Path, wanted: str, others: Sequence[str] = ()) -> None:
    """Raise ValueError, naming a file or one of ``others`` that may be meant, where there is nothing at a path."""
    try:
        if path.is_dir():
            raise ValueError(f"{name} must be {wanted}, and {str(path)!r} is a folder; name a file in it")
        if path.exists():
            return
    except OSError as error:  # a name too long, say
        raise ValueError(f"{name} must be {wanted}, got {str(path)!r}: {error.strerror}") from None
    beside: list[str] = []
    with suppress(OSError):
        beside = [file.name for file in islice(path.parent.iterdir(), _LOOKED_AT)]
    hint = where_to_get(path.name) or did_you_mean(path.name, [*others, *beside])
    folder = "" if path.parent.is_dir() else f"; there is no folder {str(path.parent)!r}"
    raise ValueError(f"{name} must be {wanted}, got {str(path)!r}: there is no such file{folder or hint}")


_LOOKED_AT = 10_000  # files of a folder among which one is searched for (a choice)
