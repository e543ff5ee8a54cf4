"""Records and work space of the kernels for motions against friction; gamma = 1 throughout."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.compilation import kernel
from floquetrod.friction.kernels.cell import HALVINGS, TERMS

PERIOD = 2.0 * math.pi


def _record(*names: str) -> np.dtype[np.void]:
    return np.dtype([(name, np.float64) for name in names], align=True)


COEFFICIENTS = _record("alpha", "beta", "damping")
"""Of an equation."""

CELL = _record("m11", "m12", "m21", "m22", "f1", "f2", "change_a", "change_velocity", "change_forced", "e1", "e2")
"""The matrix and the forcing of (A, A') over a cell for s = 1; bounds on what A = 1, A' = 1 and the forcing change in
A' anywhere in it; the row of the escape test abs(e1 A + e2 A') > 1 at its beginning."""

BASIS = np.dtype([(name, np.float64, (TERMS,)) for name in ("from_a", "from_velocity", "forced")], align=True)
"""The Taylor series of A from A = 1, from A' = 1 and of the motion forced with s = 1, in the cell's length."""

LEFT_VECTOR = _record("l1", "l2", "length")
"""At the beginning of a cell, and its length before it was made 1."""

ORBIT = _record("a", "velocity", "phase", "periods", "reversals", "sticks", "fate")
"""The state of an orbit: A, A', the phase in [0, 2 pi) and the number of whole periods before it; how often it has come
to a stop and stuck so far; its fate, NaN before it is followed."""

SAMPLE = _record("tau", "a", "velocity", "state")
"""A recorded motion; ``state`` is the sign of A' after it, 0 where it sticks."""

FINDINGS = _record("slow_fate", "invariant_phase", "invariant_low", "invariant_high")
"""What orbits of an equation have shown: the fate of slow motion outwards, and an interval of abs(A) that keeps what
sticks in it at a phase; below zero what is not known."""


class Workspace(NamedTuple):
    """Scratch arrays: series of p and of A, the coefficients of s A', and the pieces searched for a zero of s A'."""

    p: Any
    a: Any
    rate: Any
    pieces: Any


@kernel
def workspace() -> Workspace:
    """Return scratch arrays."""
    return Workspace(np.empty(TERMS), np.empty(TERMS), np.empty(TERMS), np.empty((HALVINGS + 3, TERMS)))
