"""Tables of keys and values that people write in files."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable


def require_known(keys: Iterable[str], known: Collection[str]) -> None:
    """Raise ValueError for the first of ``keys`` that is not known, with the known one like it, or all of them."""
    unknown = next((key for key in keys if key not in known), None)
    if unknown is not None:
        close = difflib.get_close_matches(unknown, known, 1)
        hint = f"did you mean {close[0]!r}?" if close else f"the keys are {', '.join(known)}"
        raise ValueError(f"unknown key {unknown!r}; {hint}")
