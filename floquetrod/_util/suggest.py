"""Parts of messages: values in a few words, and names near to an unknown one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from reprlib import Repr
from typing import Any

_SHORT = Repr()  # goes through no more than it shows: nested lists may hold one list many times
_SHORT.maxlevel = 4
_SHORT.maxlist = _SHORT.maxtuple = _SHORT.maxdict = _SHORT.maxset = 20
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 200  # more than the cut below leaves


def short(value: Any) -> str:
    """Return the text of a value for a message, at most 80 characters."""
    try:
        text = _SHORT.repr(value)
    except Exception:  # an integer of more digits than Python prints, or whatever an object's own text raises
        text = f"a {type(value).__name__} that cannot be printed"
    return text if len(text) <= 80 else f"{text[:77]}..."


def printable(text: str) -> str:
    r"""Return a text for a terminal, unprintable characters, such as escape codes in the name of a file, escaped.

    >>> print(printable("a\x1b[31m.csv"))
    a\x1b[31m.csv
    """
    signs = (sign if sign.isprintable() or sign == "\n" else sign.encode("unicode_escape").decode() for sign in text)
    return text if text.isprintable() else "".join(signs)


def listed(values: Sequence[Any]) -> str:
    """Return values one after the other; of more than nine the first eight, and how many more there are.

    >>> listed([3, 4, 5]), listed(range(1, 156))
    ('3, 4, 5', '1, 2, 3, 4, 5, 6, 7, 8 and 147 more')
    """
    if len(values) <= 9:
        return ", ".join(map(str, values))
    return f"{', '.join(map(str, values[:8]))} and {len(values) - 8:,} more"


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return "; did you mean X?" for the known name nearest to a wrong one, in any case; "" where none is near.

    >>> did_you_mean("nitinal", ["nitinol", "steel"])
    '; did you mean nitinol?'
    """
    from difflib import get_close_matches

    names = {candidate.lower(): candidate for candidate in known}
    near = get_close_matches(name.lower(), names, n=1, cutoff=0.6)
    return f"; did you mean {names[near[0]]}?" if near else ""
