"""What follows from the matrices of a system alone, in exact arithmetic, without its map over a period."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.equations.pieces import TimedPiece, in_time
from floquetrod.floquet.proof.balls import up
from floquetrod.floquet.proof.exact import Exact, exact, identity, is_positive

_MOST_ROWS = 24  # of matrices in exact arithmetic: a tenth of a second (a choice)


def norm_kept(system: HillSystem | PeriodicSystem) -> str | None:
    """Return that A(t) is minus its conjugate transpose; None where it is not, entry by entry, or known to an error."""
    if isinstance(system, HillSystem) or system.coefficient_error or not system.keeps_norm:
        return None
    turned = "conjugate transpose" if system.is_complex else "transpose"
    return f"A(t) is minus its {turned} at all times, so every solution keeps its norm"


def overdamped(system: HillSystem | PeriodicSystem) -> str | None:
    """Return that M = I, and that C, K(t) and C^2 - K(t) are symmetric and positive definite at all times; or None.

    With s = q + C^-1 q' and w = C^-1 q' the energy s^T C s + w^T C w then decreases at the rate 2 s^T K s + 2 w^T (C^2
    - K) w.
    """
    if isinstance(system, PeriodicSystem) or system.mass is not None or system.gyroscopic is not None:
        return None
    damping = system.damping
    if damping is None or not system.is_symmetric or not np.array_equal(damping, damping.T):
        return None
    if system.order > _MOST_ROWS or not is_positive(exact(damping)):
        return None
    c = np.array(exact(damping), dtype=object)
    for piece in in_time(system):
        swing = _swing(piece)
        around = Fraction(float(up(swing + system.order * system.coefficient_error)))
        mean = np.array(exact(piece.mean), dtype=object)
        shift = np.array(identity(system.order), dtype=object) * around
        if not all(is_positive(m.tolist()) for m in (mean - shift, c @ c - mean - shift)):
            return None
    return (
        "C, K(t) and C^2 - K(t) are positive definite at all times, so the energy s^T C s + w^T C w of s = q + C^-1 q' "
        "and w = C^-1 q' decreases, and every solution decays"
    )


def _swing(piece: TimedPiece) -> float:
    """Return an upper bound of how far a piece of K is from its mean, in the 2-norm, by row sums."""
    swing = sum(float(np.abs(wave).sum(axis=-1).max()) for wave in piece.harmonics)
    if piece.slope is not None:
        farthest = float(max(abs(piece.begin - piece.origin), abs(piece.begin + piece.length - piece.origin)))
        swing += farthest * float(np.abs(piece.slope).sum(axis=-1).max())
    return float(up(swing * (1.0 + 1e-12)))  # rounding of the sums


def turning(system: HillSystem | PeriodicSystem) -> str | None:
    """Return that nothing but an invertible G acts: M q'' + G q' = 0, so that M q' + G q is constant; or None."""
    if isinstance(system, PeriodicSystem) or not system.is_constant or system.damping is not None:
        return None
    if system.coefficient_error or system.gyroscopic is None or system.order > _MOST_ROWS:
        return None
    if any(matrix.any() for matrix in system.every_matrix) or not _is_invertible(exact(system.gyroscopic)):
        return None
    return "there is no stiffness and G is invertible, so q' keeps its energy, M q' + G q is constant, and q is bounded"


def expanding(system: HillSystem | PeriodicSystem) -> str | None:
    """Return that the mean of the trace of A is positive (Liouville): of one Fourier series, M = I, or None."""
    if system.pieces or getattr(system, "mass", None) is not None:
        return None
    if isinstance(system, HillSystem):
        trace, off = -_trace(system.damping), Fraction(0)
    else:
        real = system.real_form
        trace, off = _trace(real.mean), real.order * Fraction(system.coefficient_error)
    if not trace > off:
        return None
    return "the mean trace of A(t) is positive, so the product of all multipliers exceeds 1, and a solution grows"


def _trace(matrix: Floats | None) -> Fraction:
    return Fraction(0) if matrix is None else sum((Fraction(float(v)) for v in np.diag(matrix)), Fraction(0))


def _is_invertible(matrix: Exact) -> bool:
    """Return whether elimination finds a pivot in every column."""
    rows = [list(row) for row in matrix]
    for i in range(len(rows)):
        k = next((k for k in range(i, len(rows)) if rows[k][i] != 0), None)
        if k is None:
            return False
        rows[i], rows[k] = rows[k], rows[i]
        for row in rows[i + 1 :]:
            factor = row[i] / rows[i][i]
            for j in range(i, len(rows)):
                row[j] -= factor * rows[i][j]
    return True
