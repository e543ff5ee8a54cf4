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
from numpy.typing import NDArray

from floquetrod.equations import HillSystem
from floquetrod.floquet.methods.system_monodromy import SolvedMany
from floquetrod.floquet.systems.fastest import FastSolutions

_ACCURACY = 1e-10  # of the motion over a period, relative
_LARGEST_CHANGE = 1e-3  # of x over a period, beyond growth, up to which the solution is that of the fewer (a choice)
_CERTAIN = 100.0  # errors by which it is certain to grow


class Fastest(NamedTuple):
    """The fastest solution of a system with damping removed.

    Attributes
    ----------
    system : HillSystem
        Without damping.
    damping : float
        The rate that was removed, in 1/s.
    start, partner : ndarray (2 n,)
        (u, u') at the beginning of the solution and of the one that decays as fast.
    """

    system: HillSystem
    damping: float
    start: NDArray[np.complex128]
    partner: NDArray[np.complex128]

    @classmethod
    def of(cls, solved: SolvedMany, freed: tuple[HillSystem, float]) -> Fastest | None:
        """Return the fastest solution; None where it is not certain that one grows without damping."""
        discs = solved.discs
        if discs is None:
            return None
        i = int(np.abs(discs.values).argmax())
        mu = discs.values[i]
        if not abs(mu) - 1.0 > _CERTAIN * discs.radii[i]:
            return None
        other = int(np.abs(discs.values * np.conj(mu) - 1.0).argmin())
        return cls(*freed, solved.state(i), solved.state(other))

    @classmethod
    def followed(cls, fast: FastSolutions, freed: tuple[HillSystem, float]) -> Fastest | None:
        """Return the fastest solution of those that grow fast; None where none does."""
        if fast.start is None or fast.partner is None:
            return None
        return cls(*freed, fast.start, fast.partner)

    def rate_with(self, count: int) -> float | None:
        """Return the growth rate in 1/s of the first ``count`` modes; None where the solution is not one of theirs."""
        n, period = self.system.order, float(self.system.period)
        kept = np.r_[0:count, n : n + count]
        start, left = self.start[kept], _turned(self.partner[kept])
        end = _carried(self.system, start, count)
        mu = complex((left.conj() @ end) / (left.conj() @ start))
        if not np.linalg.norm(end - mu * start) <= _LARGEST_CHANGE * np.linalg.norm(end):
            return None
        return math.log(abs(mu)) / period - self.damping


def _turned(state: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return J^T y of a state y = (u, u'), J = [[0, I], [-I, 0]]."""
    positions, velocities = np.split(state, 2)
    return np.concatenate([-velocities, positions])


def _carried(system: HillSystem, start: NDArray[np.complex128], count: int) -> NDArray[np.complex128]:
    """Return the state of the first ``count`` equations after a period."""
    from scipy.integrate import solve_ivp

    mean = np.ascontiguousarray(system.stiffness[:count, :count])
    parts = [z[:count, :count] for z in system.harmonics]
    waves = [(np.ascontiguousarray(z.real), np.ascontiguousarray(z.imag)) for z in parts]
    period = float(system.period)

    def slope(t: float, packed: NDArray[np.float64]) -> NDArray[np.float64]:
        positions, velocities = packed.reshape(2, count, 2)
        force = mean @ positions
        for k, (real, imaginary) in enumerate(waves, start=1):
            angle = 2.0 * math.pi * k * t / period
            force += real @ (math.cos(angle) * positions) - imaginary @ (math.sin(angle) * positions)
        return np.concatenate([velocities, -force]).ravel()

    packed = start.view(float).reshape(2 * count, 2).ravel()
    scale = float(np.abs(packed).max())
    found = solve_ivp(slope, (0.0, period), packed, method="DOP853", rtol=_ACCURACY, atol=_ACCURACY * scale)
    return np.asarray(found.y[:, -1].copy().view(complex))
