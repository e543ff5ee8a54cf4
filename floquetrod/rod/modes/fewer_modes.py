"""The growth of fewer coupled modes, from the fastest solution of all of them.

Let P be the map of the fewer modes over a period, x the start of a solution of all of them that grows by mu, cut to the
fewer, and z^H the left eigenvector that belongs to it, cut likewise.  Then (z^H P x) / (z^H x) is the multiplier of the
fewer except for an error of second order in what was cut off.  P being symplectic, z = J^T y, y the start of the
solution that decays by 1 / conj(mu).

Where K is even about the beginning, half a period is enough.  Let V be the map over it and R (v, p) = (v, -p).  Then
P = R V^-1 R V, the decaying solution begins with R conj(x), and the quotient is v(T/2) . p(T/2) over v . p, of x; the
solution is one of the fewer as far as R V x = mu V R x.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Complexes, Floats
from floquetrod.equations import HillSystem
from floquetrod.floquet.kernels.system_large import ModalEquations
from floquetrod.floquet.kernels.system_march import March
from floquetrod.floquet.methods.system_half_period import SolvedPairs
from floquetrod.floquet.methods.system_monodromy import SolvedMany
from floquetrod.floquet.multipliers.fastest_solutions import FastSolutions

_ACCURACY = 1e-10  # of the solution after a period
_WORTH = 50.0  # modes over the root of third order of the segments up to which a verdict takes longer (measured)
_LARGEST_CHANGE = 1e-3  # of x over a period, beyond growth, up to which the solution is that of the fewer (a choice)
_CERTAIN = 100.0  # errors by which it is certain to grow


class Fastest(NamedTuple):
    """The fastest solution of u'' + K(t) u = 0: its initial (u, u'), and the solution that decays as fast."""

    system: HillSystem  # without damping
    even: float | None  # instant of evenness from which it begins; None: from 0, and K need not be even
    damping: float  # rate that was removed, in 1/s
    start: Complexes  # (2 n,)
    partner: Complexes  # (2 n,)

    @classmethod
    def of(cls, solved: SolvedMany | SolvedPairs, freed: tuple[HillSystem, float]) -> Fastest | None:
        """Return the fastest solution; None where it is not certain that one grows without damping."""
        (system, damping), solution = freed, solved.fastest()
        if solution is None or system.mass is not None or system.pieces:
            return None
        mu, error, *states = solution
        if not abs(mu) - 1.0 > _CERTAIN * error:
            return None
        form = system.even_form if isinstance(solved, SolvedPairs) else None
        return cls(system, None if form is None else float(form.start), damping, *states)

    @classmethod
    def followed(cls, fast: FastSolutions, freed: tuple[HillSystem, float]) -> Fastest | None:
        """Return the fastest solution of those that grow fast; None where none does."""
        if fast.start is None or fast.partner is None:
            return None
        system, damping = freed
        return cls(system, None, damping, fast.start, fast.partner)

    def among(self, system: HillSystem, basis: Floats) -> Fastest:
        """Return the solution as a solution of all equations, damped ones, in whose basis (n, m) these are written."""
        free, damping = system.undamped or (system, 0.0)

        def lifted(state: Complexes) -> Complexes:
            return np.concatenate([basis @ half for half in np.split(state, 2)])

        return Fastest(free, self.even, damping, lifted(self.start), lifted(self.partner))

    def rate_with(self, count: int) -> float | None:
        """Return the growth rate in 1/s of the first ``count`` modes.

        None where the solution is not one of theirs, and where a verdict on them takes less time.
        """
        system, period = self.system, float(self.system.period)
        n, few = system.order, slice(count)
        harmonics = system.harmonics[:, few, few]
        if self.even is not None:
            turns = np.exp(2j * math.pi * self.even / period * np.arange(1, len(harmonics) + 1))
            harmonics = (harmonics * turns[:, None, None]).real.astype(complex)
        parts = ModalEquations.as_they_are(system.stiffness[few, few], harmonics)
        march = March.with_all_terms(
            parts, period, _ACCURACY, (count / _WORTH) ** 3, share=1.0 if self.even is None else 0.5
        )
        if march is None:
            return None
        kept = np.r_[0:count, n : n + count]
        start, partner = march.states(np.stack([self.start[kept], self.partner[kept]], axis=1)).T
        positions, momenta = slice(count), slice(count, None)
        if self.even is None:
            end = _carried(march, start[:, None])[:, 0]
            mu = complex(_symplectic(partner.conj(), end) / _symplectic(partner.conj(), start))
            missed = end - mu * start
        else:
            back = np.concatenate([start[positions], -start[momenta]])
            end, reversed_end = _carried(march, np.stack([start, back], axis=1)).T
            mu = complex((end[positions] @ end[momenta]) / (start[positions] @ start[momenta]))
            missed = np.concatenate([end[positions], -end[momenta]]) - mu * reversed_end
        if not np.linalg.norm(missed) <= _LARGEST_CHANGE * np.linalg.norm(end):
            return None
        return math.log(abs(mu)) / period - self.damping


def _carried(march: March, states: Complexes) -> Complexes:
    """Return complex states (2 n, q) as they are at the end."""
    moved = march.carried(np.hstack([states.real, states.imag]), _ACCURACY)
    return np.asarray(moved[:, : states.shape[1]] + 1j * moved[:, states.shape[1] :])


def _symplectic(x: Complexes, y: Complexes) -> complex:
    """Return J^T one times the other."""
    n = len(x) // 2
    return complex(x[:n] @ y[n:] - x[n:] @ y[:n])
