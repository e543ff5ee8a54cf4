"""What stands for stable, unstable and undecided in arrays, and arrays of truth values made of it."""

from __future__ import annotations

import warnings
from typing import Any, Literal

import numpy as np

from floquetrod._util.calling import level_of_caller

Status = Literal["stable", "unstable", "undecided"]

STABLE, UNSTABLE, UNDECIDED = 1, 0, -1

STATUS_CODES: dict[Status, int] = {"stable": STABLE, "unstable": UNSTABLE, "undecided": UNDECIDED}
"""What stands for a status in arrays, everywhere."""


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
