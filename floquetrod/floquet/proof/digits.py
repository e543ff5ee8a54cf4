"""As many digits as it takes: a proof is attempted with more of them until it succeeds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from floquetrod.floquet.proof.balls import Doubles
from floquetrod.floquet.proof.integers import Integers
from floquetrod.floquet.proof.many_digits import TooMuchWork, Unresolved
from floquetrod.floquet.proof.proof import Proof

FIRST = 15
"""Digits of the first attempt: those of doubles."""


def balls(digits: int) -> Doubles | Integers:
    """Return the arithmetic of balls with so many digits."""
    return Doubles() if digits <= Doubles.digits else Integers(digits)


def settled(attempt: Callable[[int], Proof], most: int, undecided: Callable[[int, str], Proof]) -> Proof:
    """Return the first proof that succeeds, of attempts with twice as many digits each, up to ``most``.

    An attempt raises `Unresolved` where its digits are too few and `TooMuchWork` where they are too many; ``undecided``
    makes the answer of the digits and the reason then.  What is not finite decides nothing, and is no error.
    """
    digits, reason = min(FIRST, most), ""
    while True:
        try:
            with np.errstate(all="ignore"):
                return attempt(digits)
        except (Unresolved, np.linalg.LinAlgError) as why:
            reason = f"{why} with {digits} digits"
            if digits >= most:
                return undecided(digits, reason)
        except TooMuchWork as why:
            before = f"{reason}; " if reason else ""
            return undecided(digits, f"{before}{why} would take too long")
        digits = min(2 * digits, most)
