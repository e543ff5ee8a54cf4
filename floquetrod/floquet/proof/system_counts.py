"""Strong stability by counting: negative eigenvalues of Hill's operator at a few angles.

With the period as the unit of time, L = -M d2/dt2 - G d/dt - K(t) acts on q(t + 1) = exp(2 pi i f) q(t); N(f) is the
number of its negative eigenvalues.  It jumps only where exp(2 pi i f) is a multiplier, by at most the number of
multipliers there, and by just that where their Krein signs agree.  The upper half of the unit circle has room for n
multipliers: if N varies by n over some angles from 0 to 1/2, all multipliers lie on the circle and none meets one of
the opposite sign.  If n - abs(N(1/2) - N(0)) is odd, so is the number of pairs of real multipliers off the circle.
R. Bott, Comm. Pure Appl. Math. 9 (1956) 171, doi:10.1002/cpa.3160090204.

In a Fourier basis L is an infinite matrix of blocks; blocks with abs(k) <= m are kept.  Let the others by
themselves be at least tau I, tau > 0, and let r bound what couples them to the kept ones on either side.  Then L has as
many negative eigenvalues as the kept matrix less some matrix between zero and r^2 / tau I in its last blocks on either
side.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from floquetrod.floquet.proof.balls import Array, down, up
from floquetrod.floquet.proof.inertia import Inertia, inertia
from floquetrod.floquet.proof.many_digits import TooMuchWork, Unresolved
from floquetrod.floquet.proof.system_problem import Arithmetic, Matrix, Oscillators, row_sum

_GRID = 2.0**40
_CLOSE = 1e-9  # in turns: no sample between closer multipliers separates them (a choice)
_MOST_BLOCKS = 2**11  # so that an angle plus a block's number is exact
_TWO_PI_BELOW = 6.283185307179586


class Truncation(NamedTuple):
    """Hill's matrix cut off."""

    last: int  # blocks with abs(k) <= last are kept
    radius: float  # r^2 / tau


class Counts(NamedTuple):
    """Numbers of negative eigenvalues by angle in turns, ascending, and the least margin of a sign."""

    angles: tuple[float, ...]
    negative: tuple[int, ...]
    margin: float

    @property
    def variation(self) -> int:
        """Return how much the number varies from the first angle to the last."""
        return int(np.abs(np.diff(self.negative)).sum())

    @property
    def across(self) -> int | None:
        """Return abs(N(1/2) - N(0)), None where either is not known."""
        if not self.angles or self.angles[0] != 0.0 or self.angles[-1] != 0.5:
            return None
        return abs(self.negative[-1] - self.negative[0])

    def krein_sign(self, turns: Array) -> int:
        """Return the Krein sign of all multipliers exp(2 pi i turns), of one half of the circle; 0 where it is mixed.

        N falls by it, where all multipliers are on the circle.
        """
        upper = turns >= 0.0
        if not (upper.all() or not upper.any()):
            return 0
        below = np.searchsorted(self.angles, np.abs(turns).min(), side="left") - 1
        above = np.searchsorted(self.angles, np.abs(turns).max(), side="right")
        if below < 0 or above >= len(self.angles):
            return 0
        jumps = np.diff(self.negative[below : above + 1])
        if int(np.abs(jumps).sum()) != len(turns) or abs(int(jumps.sum())) != len(turns):
            return 0
        return int(-np.sign(jumps.sum())) * (1 if upper.all() else -1)


def angles_between(multipliers: Array) -> list[float]:
    """Return angles in turns, 0, 1/2 and between approximate multipliers."""
    turns = np.sort(np.abs(np.angle(multipliers)) / (2.0 * math.pi))
    middles = 0.5 * (turns[1:] + turns[:-1])[np.diff(turns) > _CLOSE]
    return sorted({0.0, 0.5, *(round(float(angle) * _GRID) / _GRID for angle in middles)})


def count(arithmetic: Arithmetic, system: Oscillators, angles: Sequence[float]) -> Counts:
    """Count the negative eigenvalues of Hill's operator at the angles where that can be determined."""
    truncation = _truncation(system, _last(arithmetic, system))
    arithmetic.check_work(8.0 * len(angles) * ((2 * truncation.last + 1) * system.order) ** 3)
    known: list[tuple[float, Inertia]] = []
    for angle in angles:
        try:
            known.append((angle, inertia(arithmetic, *_matrix(arithmetic, system, truncation, angle))))
        except Unresolved:
            continue
    margin = min((item.margin for _, item in known), default=0.0)
    return Counts(tuple(angle for angle, _ in known), tuple(item.negative for _, item in known), margin)


def _sizes(system: Oscillators) -> tuple[float, float, float, float]:
    """Return bounds: the mass from below, from above the gyroscopic matrix, the stiffness and all of its waves."""
    gyroscopic = row_sum(system.gyroscopic) if system.gyroscopic is not None else 0.0
    return 1.0 - system.defect, gyroscopic, row_sum(system.stiffness), sum(row_sum(wave) for wave in system.waves)


def _last(arithmetic: Arithmetic, system: Oscillators) -> int:
    """Return the block after which Hill's matrix may be cut off.

    Far enough for tau > waves, and for the cut not to be felt at the eigenvalues close to zero (heuristic).
    """
    mass, gyroscopic, stiffness, waves = _sizes(system)
    need = (gyroscopic + math.sqrt(gyroscopic**2 + 4.0 * mass * (stiffness + 2.0 * waves))) / (2.0 * mass)
    if not need < _MOST_BLOCKS:
        raise TooMuchWork("so many blocks of Hill's matrix")
    reach = len(system.waves)
    return reach + math.ceil(need / _TWO_PI_BELOW) + (2 + arithmetic.digits // 5 if reach else 0)


def _truncation(system: Oscillators, last: int) -> Truncation:
    """Return Hill's matrix cut off after the block ``last``."""
    mass, gyroscopic, stiffness, waves = _sizes(system)
    nu = _TWO_PI_BELOW * (last + 0.5)  # the least frequency left out, at angles up to 1/2
    tail = down(mass * nu * nu) - up(up(nu * gyroscopic) + up(stiffness + waves))
    if not (tail > 0.0 and 2.0 * nu * mass > gyroscopic):
        raise Unresolved("the part of Hill's matrix that is left out cannot be bounded")
    return Truncation(last, up(0.25 * up(waves * waves) / tail * (1.0 + 1e-9)) if system.waves else 0.0)


def _matrix(arithmetic: Arithmetic, system: Oscillators, truncation: Truncation, angle: float) -> tuple[Matrix, Array]:
    """Enclose a matrix with as many negative eigenvalues as Hill's operator; return it and the sizes of its rows."""
    n, last, reach = system.order, truncation.last, len(system.waves)
    blocks = np.arange(2 * last + 1)
    frequency = arithmetic.two_pi() * arithmetic.exact(angle + (blocks - last))
    nu = frequency[:, None, None]
    mass = arithmetic.exact(np.eye(n))
    if system.excess is not None:
        mass = mass + system.excess
    diagonal = nu * nu * mass[None] - system.stiffness[None]
    if system.gyroscopic is not None:
        diagonal = diagonal - nu * system.gyroscopic.times_i()[None]
    real = system.gyroscopic is None and all(wave.is_real for wave in system.waves)
    matrix = arithmetic.zeros((len(blocks), n, len(blocks), n), real=real)
    matrix[blocks, :, blocks, :] = diagonal
    for j, wave in enumerate(system.waves, 1):
        coupling = -wave.shifted(0.5)
        matrix[blocks[j:], :, blocks[:-j], :] = coupling
        matrix[blocks[:-j], :, blocks[j:], :] = coupling.adjoint()
    if reach:
        edge = np.full((n, n), 0.5 * truncation.radius)
        for side in (slice(None, reach), slice(-reach, None)):
            ends = blocks[side]
            matrix[ends, :, ends, :] = matrix[ends, :, ends, :] - arithmetic.exact(edge * np.eye(n))
            matrix[side, :, side, :] = matrix[side, :, side, :].widened(edge[:, None, :])
    sizes = np.abs(frequency.centre()[:, None]) ** 2 + sum(
        (wave.upper().sum(1) for wave in system.waves), system.stiffness.upper().sum(1)
    )
    size = len(blocks) * n
    return matrix.each(lambda a: a.reshape(size, size)), np.maximum(sizes, 1e-12 * sizes.max()).reshape(size)
