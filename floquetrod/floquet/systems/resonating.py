"""The modes of q'' + 2 c q' + K(t) q = 0 that may take part in a resonance, as a system of their own.

Modes are those of the mean stiffness.  In these K = diag(s) + sum_k Re Z_k exp(i k w t) lies between diag(s - d) and
diag(s + d), where d are the sums of the rows of sum_k |Z_k|, so that mode j swings at no more than w_j =
sqrt(s_j + d_j).  Two modes resonate where their frequencies add up to a multiple of w: a mode with w_j + w_i < w for
every mode i resonates with none, as long as K stays positive, s > d.

Such modes are left out.  Others drive them, but off resonance, and are driven back: what that changes is left out too.
It falls with the distance between the modes, as the highest resonate and these are the lowest.  Of strings their
growth came out the same to 1e-6 1/s (tested).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import EPS, Floats
from floquetrod.equations import HillSystem
from floquetrod.equations.matrices import mirrored
from floquetrod.floquet.kernels.system_large import in_modes

_APART = 0.9  # sum of two frequencies over that of a resonance, up to which they are far from it (measured)
_FEWEST = 9  # modes kept: fewer take no less time (measured)
_WORTH = 0.8  # share of the equations that may be left for this to be worthwhile (a choice)


class Resonating(NamedTuple):
    """Modes that may resonate."""

    system: HillSystem  # damping included
    basis: Floats  # (n, kept), q = basis v, orthonormal
    below: int  # modes left out, which all swing more slowly


def resonating(system: HillSystem) -> Resonating | None:
    """Return the modes that may resonate; None where these are most modes, and of other systems."""
    freed = system.undamped
    if freed is None or freed[0].structure != "hamiltonian" or system.mass is not None or system.pieces:
        return None
    free, damping = freed
    n, w = free.order, 2.0 * math.pi / float(free.period)
    if free.gyroscopic is not None or not np.isfinite(free.stiffness).all():
        return None
    harmonics = free.harmonics
    rates, modes, (cosines, sines) = in_modes(free.stiffness, (harmonics.real, harmonics.imag))
    reach = np.hypot(cosines, sines).sum(axis=(0, 2))
    if not (rates - reach > 0.0).all():
        return None
    highest = np.maximum.accumulate(np.sqrt(rates + reach))
    below = min(int(np.count_nonzero(highest + highest[-1] < _APART * w)), n - _FEWEST)
    if below <= 0 or n - below > _WORTH * n:
        return None
    kept = slice(below, None)
    rounding = EPS * (4.0 + 2.0 * math.sqrt(n)) * float(rates[-1] + reach.max())  # of the eigenvectors (measured)
    part = HillSystem(
        np.diag(rates[kept] + damping * damping),
        list(mirrored(cosines[:, kept, kept])),
        list(mirrored(-sines[:, kept, kept])) if sines.any() else (),
        damping=2.0 * damping * np.eye(n - below) if damping else None,
        period=float(free.period),
        coefficient_error=free.coefficient_error + rounding / (n - below),
    )
    return Resonating(part, modes[:, kept], below)
