"""Arguments that say how a table is read."""

from __future__ import annotations

from typing import Any

from floquetrod._util import validate


def column_argument(name: str, value: Any) -> str | int | None:
    """Return the argument that chooses a column: a heading, a number from 0, or None."""
    if value is None or isinstance(value, str):
        return value
    return validate.integer(name, value, 0, hint="give the heading of a column or its number, 0 for the first")


def column_text(text: str | None) -> str | int | None:
    """Return the column that a text chooses, a number from 0 or a heading; None for an empty text."""
    written = (text or "").strip()
    return None if not written else int(written) if written.isdecimal() else written


def delimiter_argument(value: Any) -> str | None:
    r"""Return the argument ``delimiter``: one character, where "\t" and "tab" are the tab, or None."""
    if isinstance(value, str) and value.strip().lower() in ("\\t", "tab"):
        return "\t"
    if value is not None and (not isinstance(value, str) or len(value) != 1 or value in '"#\r\n.-+' or value.isalnum()):
        kind = ValueError if isinstance(value, str) else TypeError
        raise kind(f"delimiter must be one character such as ',', ';' or '\\t', got {validate.short(value)}")
    return value
