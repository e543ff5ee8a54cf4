"""The modes of q'' + 2 c q' + K(t) q = 0 that may take part in a resonance, as a system of their own.

In the modes of the mean stiffness K = diag(s) + sum_k Re Z_k exp(i k w t) lies between diag(s - d) and
diag(s + d), where d are the sums of the rows of sum_k |Z_k|, so that mode j swings at no more than w_j =
sqrt(s_j + d_j).  Two modes resonate where their frequencies add up to a multiple of w: a mode with w_j + w_i < w for
every mode i resonates with none, as long as K stays positive, s > d.

Such modes are left out.  The others drive them, but off resonance, and are driven back; this is neglected too.  It
falls with the distance between the modes, as the highest resonate and these are the lowest.  The growth of strings
came out the same to 1e-6 1/s (tested).
"""

from __future__ import annotations

import math
from typing import NamedTuple, Self

import numpy as np

from floquetrod._util.arrays import EPS, Floats
from floquetrod.equations.hill_system import HillSystem, damped
from floquetrod.equations.matrices import mirrored
from floquetrod.floquet.kernels.system_large import in_modes

_APART = 0.9  # sum of two frequencies over that of a resonance, up to which they are far from it (measured)
_FEWEST = 9  # modes kept: fewer take no less time (measured)
_WORTH = 0.8  # largest share of the equations that may remain (a choice)


class Resonating(NamedTuple):
    """Modes that may resonate."""

    free: HillSystem  # without damping
    damping: float  # rate c
    basis: Floats  # (n, kept), q = basis v, orthonormal
    below: int  # modes left out, which all swing more slowly

    @classmethod
    def _of(cls, system: HillSystem, damping: float, modes: _StiffnessModes, below: int) -> Self:
        """Return all but the first modes ``below``, with period and coefficient error of ``system``."""
        kept, sines = slice(below, None), modes.sines
        count = len(modes.rates) - below
        rounding = EPS * (4.0 + 2.0 * math.sqrt(len(modes.rates))) * float(modes.rates[-1] + modes.reach.max())
        free = HillSystem(
            np.diag(modes.rates[kept]),
            list(mirrored(modes.cosines[:, kept, kept])),
            list(mirrored(-sines[:, kept, kept])) if sines.any() else (),
            period=float(system.period),
            coefficient_error=system.coefficient_error + rounding / count,  # of the eigenvectors (measured)
        )
        return cls(free, damping, modes.vectors[:, kept], below)

    @property
    def system(self) -> HillSystem:
        """The modes as a system of their own, damping included."""
        return damped(self.free, self.damping) if self.damping else self.free

    def without_last(self, count: int) -> Self | None:
        """Return the modes of the motion whose last ``count`` coordinates are zero; None where too few modes remain."""
        kept = self.basis.shape[1]
        if kept < count + _FEWEST:
            return None
        moving = np.linalg.qr(self.basis[-count:].T, mode="complete")[0][:, count:]
        modes = _StiffnessModes.of(self.free, moving)
        rest = self._of(self.free, self.damping, modes, max(0, modes.below_resonance(self.free)))
        return rest._replace(basis=self.basis @ rest.basis, below=self.below + rest.below)


class _StiffnessModes(NamedTuple):
    """Modes of the mean stiffness."""

    rates: Floats  # (n,), their stiffness
    vectors: Floats  # (m, n), orthonormal
    cosines: Floats  # (H, n, n), of the stiffness, in these modes
    sines: Floats
    reach: Floats  # (n,), how far each may be from its mean stiffness

    @classmethod
    def of(cls, free: HillSystem, moving: Floats | None = None) -> Self:
        """Return the modes of a system without damping, all or in a subspace of an orthonormal basis (m, n)."""
        matrices = [free.stiffness, free.harmonics.real, free.harmonics.imag]
        if moving is not None:
            matrices = [moving.T @ matrix @ moving for matrix in matrices]
        rates, vectors, (cosines, sines) = in_modes(matrices[0], matrices[1:])
        reach = (np.hypot(cosines, sines) if sines.any() else np.abs(cosines)).sum(axis=(0, 2))
        return cls(rates, vectors if moving is None else moving @ vectors, cosines, sines, reach)

    def below_resonance(self, system: HillSystem) -> int:
        """Return how many of the slowest are below all resonances, so that some are left; 0 unless K is positive."""
        if not (self.rates - self.reach > 0.0).all():
            return 0
        highest = np.maximum.accumulate(np.sqrt(self.rates + self.reach))
        far = highest + highest[-1] < _APART * 2.0 * math.pi / float(system.period)
        return min(int(np.count_nonzero(far)), len(far) - _FEWEST)


def resonating(system: HillSystem) -> Resonating | None:
    """Return the modes that may resonate; None where these are most modes, and for systems of another form."""
    freed = system.undamped
    if freed is None or freed[0].structure != "hamiltonian" or system.mass is not None or system.pieces:
        return None
    free, damping = freed
    if free.gyroscopic is not None or not np.isfinite(free.stiffness).all():
        return None
    modes = _StiffnessModes.of(free)
    below = modes.below_resonance(free)
    if below <= 0 or free.order - below > _WORTH * free.order:
        return None
    return Resonating._of(free, damping, modes, below)
