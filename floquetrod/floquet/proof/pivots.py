"""Counts of eigenvalues by the signs of pivots."""

from __future__ import annotations

from typing import Any, NamedTuple

from floquetrod.floquet.proof.many_digits import Unresolved
from floquetrod.floquet.proof.proof import Enclosure


class Count(NamedTuple):
    """How many eigenvalues lie below the equation's and none at it, with the pivots closest to zero."""

    below: int
    enclosures: tuple[Enclosure, ...]


class Pivots(NamedTuple):
    """The number of negative pivots of a matrix, and the pivot closest to zero."""

    negative: int
    closest: Any


def no_sign() -> Unresolved:
    """Return the exception for a pivot that may be zero."""
    return Unresolved("a pivot of Hill's matrix cannot be distinguished from zero")


def closer(least: Any, pivot: Any) -> Any:
    """Return whichever of two enclosures that exclude zero comes closer to it; ``least`` may be None."""
    return pivot if least is None or abs(pivot).a < abs(least).a else least
