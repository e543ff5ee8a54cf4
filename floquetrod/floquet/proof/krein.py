"""Strong stability of a Hamiltonian map over a period by the Krein signs of its multipliers, whatever made the map.

A map M keeps a Hermitian form: M^H G M = G, G = i (q^H p - p^H q) in positions and momenta.  For an arc of the unit
circle, of middle exp(i c) and half width d, the function sin((phi - c + d) / 2) / sin((phi - c - d) / 2) of exp(i phi)
is real on the circle, and negative on just the arc.  G f(M) is Hermitian, so is the congruent matrix

    H = 2 cos(d) G - exp(-i c) G M - exp(i c) (G M)^H,

and its signature is -2 times the sum of the Krein signs of the multipliers on the arc: G itself has signature 0, and
pairs off the circle add nothing.  The upper half of the circle has room for n multipliers: where the magnitudes of the
sums over arcs from 1 to -1 add up to n, all multipliers lie on the circle, and none meets one of the opposite sign
(I. M. Gel'fand and V. B. Lidskii; V. A. Yakubovich and V. M. Starzhinskii, *Linear Differential Equations with
Periodic Coefficients*, 1975, chapter 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from floquetrod.floquet.proof.inertia import inertia
from floquetrod.floquet.proof.system_problem import Arithmetic, Matrix


class KreinSums(NamedTuple):
    """Sums of Krein signs over arcs that meet at angles in turns, ascending, and the least margin of a sign."""

    angles: tuple[float, ...]
    sums: tuple[int, ...]
    margin: float

    @property
    def definite(self) -> int:
        """How many multipliers of the upper half of the circle are known to be definite."""
        return sum(map(abs, self.sums))


def krein_sums(arithmetic: Arithmetic, matrix: Matrix, form: Matrix, angles: Sequence[float]) -> KreinSums:
    """Sum the Krein signs between angles from 0 to 1/2; raises `Unresolved` where a multiplier may be at one."""
    product, sums, margin = form @ matrix, [], 1.0
    for low, high in pairwise(angles):
        cosines, sines = arithmetic.turns(np.array([0.5 * (low + high), 0.5 * (high - low)]))
        turned = product * (cosines[0] - sines[0].times_i())
        hermitian = (form * cosines[1]).shifted(2.0) - turned - turned.adjoint()
        signs = inertia(arithmetic, hermitian, hermitian.upper().max(axis=1))
        sums.append(signs.negative - form.shape[0] // 2)
        margin = min(margin, signs.margin)
    return KreinSums(tuple(angles), tuple(sums), margin)
