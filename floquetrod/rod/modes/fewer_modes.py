"""The growth of fewer coupled modes, from the fastest solution of all of them.

Let P be the map of the fewer modes over a period, x the start of a solution of all of them that grows by mu, cut to the
fewer, and z^H the left eigenvector that belongs to it, cut likewise.  Then (z^H P x) / (z^H x) is the multiplier of the
fewer except for an error of second order in what was cut off.  P being symplectic, z = J^T y, y the start of the
solution that decays by 1 / conj(mu).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Complexes, Floats
from floquetrod.equations import HillSystem
from floquetrod.floquet.kernels.system_large import Parts
from floquetrod.floquet.kernels.system_march import March
from floquetrod.floquet.methods.system_half_period import SolvedPairs
from floquetrod.floquet.methods.system_monodromy import SolvedMany
from floquetrod.floquet.systems.fastest import FastSolutions

_ACCURACY = 1e-10  # of the solution after a period
_WORTH = 50.0  # modes over the root of third order of the segments up to which a verdict takes longer (measured)
_LARGEST_CHANGE = 1e-3  # of x over a period, beyond growth, up to which the solution is that of the fewer (a choice)
_CERTAIN = 100.0  # errors by which it is certain to grow


class Fastest(NamedTuple):
    """The fastest solution of u'' + K(t) u = 0, from where (u, u') begins and that of the one that decays as fast."""

    stiffness: Floats  # (n, n), mean of K
    harmonics: Complexes  # (H, n, n), from that instant on
    period: float
    damping: float  # rate that was removed, in 1/s
    start: Complexes  # (2 n,)
    partner: Complexes  # (2 n,)

    @classmethod
    def of(cls, solved: SolvedMany | SolvedPairs, freed: tuple[HillSystem, float]) -> Fastest | None:
        """Return the fastest solution; None where it is not certain that one grows without damping."""
        (system, damping), found = freed, solved.fastest()
        if found is None or system.mass is not None or system.pieces:
            return None
        mu, error, *states = found
        if not abs(mu) - 1.0 > _CERTAIN * error:
            return None
        form = system.even_form if isinstance(solved, SolvedPairs) else None
        harmonics = system.harmonics if form is None else form.amplitudes.astype(complex)
        return cls(system.stiffness, harmonics, float(system.period), damping, *states)

    @classmethod
    def followed(cls, fast: FastSolutions, freed: tuple[HillSystem, float]) -> Fastest | None:
        """Return the fastest solution of those that grow fast; None where none does."""
        if fast.start is None or fast.partner is None:
            return None
        system, damping = freed
        return cls(system.stiffness, system.harmonics, float(system.period), damping, fast.start, fast.partner)

    def rate_with(self, count: int) -> float | None:
        """Return the growth rate in 1/s of the first ``count`` modes.

        None where the solution is not one of theirs, and where a verdict on them takes less time.
        """
        n = len(self.stiffness)
        parts = Parts.of(self.stiffness[:count, :count], self.harmonics[:, :count, :count])
        march = March.with_all_terms(parts, self.period, _ACCURACY, (count / _WORTH) ** 3)
        if march is None:
            return None
        kept = np.r_[0:count, n : n + count]
        start, partner = march.states(np.stack([self.start[kept], self.partner[kept]], axis=1)).T
        moved = march.carried(np.stack([start.real, start.imag], axis=1), _ACCURACY)
        end, left = moved[:, 0] + 1j * moved[:, 1], np.concatenate([-partner[count:], partner[:count]]).conj()
        mu = complex((left @ end) / (left @ start))
        if not np.linalg.norm(end - mu * start) <= _LARGEST_CHANGE * np.linalg.norm(end):
            return None
        return math.log(abs(mu)) / self.period - self.damping
