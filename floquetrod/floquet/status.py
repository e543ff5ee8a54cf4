"""Stable, unstable, undecided: the rules that decide for a number or a count, and the codes of a status in arrays.

A number is a growth, an excess or a stiffness with its sign turned: positive where motion grows.  Of a system the rule
is `floquetrod.floquet.multipliers.classification`, which compares multipliers with the unit circle; of a rod it is the
rule for a number applied to the growth of its modes, with a tolerance, in `floquetrod.rod.modes`.
"""

from __future__ import annotations

import warnings
from typing import Any, Literal

import numpy as np

from floquetrod._util.calling import level_of_caller

Status = Literal["stable", "unstable", "undecided"]

STABLE, UNSTABLE, UNDECIDED = 1, 0, -1

STATUS_CODES: dict[Status, int] = {"stable": STABLE, "unstable": UNSTABLE, "undecided": UNDECIDED}
"""What stands for a status in arrays, everywhere."""


def status_of(growth: Any, error: Any = 0.0) -> Status:
    """Return the status of a number that grows where it is positive, known to within its error."""
    return "unstable" if growth > error else "stable" if growth < -error else "undecided"


def status_between(low: float, high: float) -> Status:
    """Return the status of a number between two: undecided where they have different signs, or either is zero."""
    return "unstable" if low > 0.0 else "stable" if high < 0.0 else "undecided"


def status_of_count(below: int | None) -> Status:
    """Return the status of Hill's equation with a number of eigenvalues below its own: bounded where it is odd."""
    return "undecided" if below is None else "stable" if below % 2 else "unstable"


class UndecidedWarning(UserWarning):
    """Some problems could not be decided, and count as not known to be stable, or not known to escape."""


def are(status: Status, codes: Any, what: str, remedy: str) -> Any:
    """Return whether codes are known to be of a status: undecided ones are False, with one warning that counts them.

    Parameters
    ----------
    status : {"stable", "unstable"}
    codes : int or ndarray of int
        `STATUS_CODES`.
    what : str
        Subject of the codes, and the property that is not known: "{} of {} loads ... and count as not stable".
    remedy : str
        What to call to see which they are.

    Returns
    -------
    bool or ndarray of bool
        In the shape of the codes.

    Examples
    --------
    >>> are("stable", np.array([1, 0], dtype=np.int8), "systems could not be decided", "see each")
    array([ True, False])
    """
    unknown = int(np.count_nonzero(np.equal(codes, UNDECIDED)))
    if unknown:
        told = f"{unknown} of {np.size(codes)} {what}; {remedy}"
        warnings.warn(told, UndecidedWarning, stacklevel=level_of_caller())
    return codes == STATUS_CODES[status]
