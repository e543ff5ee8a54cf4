"""Eigenvalue counts of Hill's infinite matrices: the default verdict, exact where rounding lets it decide."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import EPS
from floquetrod.equations import Equation, Mathieu, MathieuAQ, in_tau
from floquetrod.floquet import registry
from floquetrod.floquet.hill_count import MOST_ROWS, hill_count
from floquetrod.floquet.kernels import mathieu_discriminant as kernels
from floquetrod.floquet.mathieu_chains.certain_count import certain_count
from floquetrod.floquet.status import status_of_count
from floquetrod.floquet.verdict import Cost, Interval, Stability, Status, classify

_LARGEST_ERROR = 1e-3  # of the excess, relative: beyond it the growth rate is no longer worth stating (a choice)


def spectral(equation: Equation) -> Stability:
    """Classify by counting the eigenvalues of Hill's matrices below the value that the equation has.

    Solutions are bounded when the number of periodic and antiperiodic eigenvalues of -u'' + p u below zero is odd
    (oscillation theorem; DLMF 28.2(v) for Mathieu, Magnus and Winkler, *Hill's Equation*, Thm. 2.1 for Hill).

    *Mathieu.*  The matrices split into four tridiagonal chains (`mathieu_counts`); eigenvalues below a are as many as
    negative pivots d_k = D_k - a - q^2 / d_(k-1).  Stopping rule: let d_k > q and D_j - a >= 2 q for all j > k. Then
    d_(k+1) = D_(k+1) - a - q^2 / d_k > 2 q - q = q, and so on: no later pivot is negative, and the count of the
    infinite matrix is the count of its first k rows.  Every pivot is enclosed between two doubles rounded outwards; a
    pivot whose enclosure contains zero makes the verdict "undecided", so a verdict given is a proof.

    *Hill.*  In the basis exp(i k W tau) the matrix H is Hermitian and banded.  Partition it as [[H_K, C], [C*, T]] with
    T >= delta = ((K + 1) W)^2 + mean - sum abs(z_k) > 0.  By Sylvester's law N(H) = N(H_K - C T^-1 C*), and since
    0 <= C T^-1 C* <= C C* / delta, N(H_K) <= N(H) <= N(H_K - C C* / delta).  K grows until both ends agree; an
    eigenvalue within rounding of zero makes the verdict "undecided".

    Parameters
    ----------
    equation : Equation
        One whose coefficient is a Fourier series all over the period, such as `Mathieu` and `Hill`.
        Damping c is treated by the exact substitution A = exp(-c tau) u, p -> p + c^2.

    Returns
    -------
    Stability
        ``error`` is a first-order estimate of rounding for Mathieu; for Hill the change from K to K + 4.

    Raises
    ------
    TypeError
        For an equation whose coefficient is no Fourier series.

    Examples
    --------
    >>> spectral(Mathieu(alpha=1e-8, beta=-0.25)).growth_rate
    4.999999999999999e-09
    """
    registry.require(equation, "spectral")
    return _mathieu(equation) if isinstance(equation, Mathieu | MathieuAQ) else _hill(equation)


def _mathieu(equation: Mathieu | MathieuAQ) -> Stability:
    alpha, beta, damping = (getattr(in_tau(equation), name) for name in ("alpha", "beta", "damping"))
    sign, value, exponent, error, rows = kernels.discriminant_excess(alpha, beta, damping)
    size = min(1.0, abs(math.ldexp(value, min(exponent, 60))))
    excess_error = error * size if value != 0.0 else error
    if not excess_error < math.inf:  # alpha^2 is beyond the range of a double, and X that of alpha = 0 to rounding
        _, unforced, shift, unforced_error, _ = kernels.discriminant_excess(0.0, beta, damping)
        excess_error = unforced_error + abs(size - min(1.0, abs(math.ldexp(unforced, min(shift, 60)))))
    below, pivots = certain_count(alpha, beta, damping)
    status = status_of_count(below)
    interval = None if below is None else Interval.from_count(below)
    return classify(
        equation,
        "spectral",
        sign=sign,
        excess=value,
        exponent=exponent,
        excess_error=excess_error,
        interval=interval,
        undamped_status=status,
        cost=Cost(pivots + rows, "pivots"),
        note="a pivot cannot be distinguished from zero in double precision" if status == "undecided" else "",
    )


# --- general Hill equations ------------------------------------------------------------------------------------------


def _hill(equation: Equation) -> Stability:
    # First the count, which decides (`hill_count`, K = ``cut`` harmonics).  Then the growth: the Floquet exponent as an
    # eigenvalue of Hill's truncated pencil, for K and K + 4, whose difference is the estimate of the truncation.
    # W = ``turn`` = 2 pi / period; mean includes c^2, so that exponents are those of the equation without damping.
    (piece,) = equation.pieces()
    harmonics = np.array(piece.harmonics, dtype=np.complex128)
    mean = float(piece.start) + equation.damping**2
    bound = float(np.abs(harmonics).sum())
    turn = 2.0 * math.pi / equation.period
    count = hill_count(mean, harmonics, turn)
    below, cut, rows = count.below, count.cut, count.rows
    if count.is_too_large:
        note = f"needs Hill matrices of more than {MOST_ROWS} rows; use method='monodromy'"
        return Stability.declined(equation, "spectral", Cost(rows, "rows"), note)
    status = status_of_count(below)
    coarse = _central_exponent(mean, harmonics, turn, cut)
    fine = _central_exponent(mean, harmonics, turn, cut + 4)
    sign, excess, exponent = _excess_of_exponent(fine, turn, status)
    note = "an eigenvalue cannot be distinguished from zero in double precision" if status == "undecided" else ""
    # X responds to the square of the exponent near a boundary and to T times it far away.
    scale = math.pi / turn
    change = abs(fine - coarse) * scale * 2.0 * max(abs(fine * scale), 1.0) + abs(fine - coarse) ** 2 * scale**2
    rounding = 8.0 * EPS * (1.0 + scale * (abs(mean) + bound + (cut * turn) ** 2) / turn)
    error = change + rounding
    if not error <= _LARGEST_ERROR:
        # The count holds, but the eigenvalues of a matrix so far from normal say nothing of the growth.
        status, error = "undecided", math.inf
        note = "grows too much in a period for eigenvalues in double precision; use method='monodromy'"
    return classify(
        equation,
        "spectral",
        sign=sign,
        excess=excess,
        exponent=exponent,
        excess_error=error,
        interval=None if below is None else Interval.from_count(below),
        undamped_status=status,
        cost=Cost(rows + 8 * cut, "rows"),
        note=note,
    )


def _central_exponent(mean: float, harmonics: NDArray[Any], turn: float, cut: int) -> complex:
    """Return the Floquet exponent, real part >= 0, imaginary part in [0, W / 2], from Hill's quadratic pencil.

    With u = exp(s tau) sum c_k exp(i k W tau) and v = u', the pencil is an ordinary eigenvalue problem for s; of its
    eigenvalues, copies of +-s shifted by i k W, the central ones are the least harmed by the truncation.
    """
    frequencies = np.arange(-cut, cut + 1.0) * turn
    size = len(frequencies)
    coupling = np.diag(np.full(size, mean, dtype=np.complex128))
    for j, amplitude in enumerate(harmonics, start=1):
        if j < size:
            coupling += np.diag(np.full(size - j, 0.5 * amplitude), -j)
            coupling += np.diag(np.full(size - j, 0.5 * np.conj(amplitude)), j)
    shift = np.diag(-1j * frequencies)
    values = np.linalg.eigvals(np.block([[shift, np.eye(size)], [coupling, shift]]))
    central = values[np.abs(values.imag) <= 0.5 * turn * (1.0 + 1e-9)]
    if not len(central):  # a truncation far too small; the error estimate will say so
        return 0j
    best = central[np.argmax(central.real)]
    return complex(abs(best.real), abs(best.imag))


def _excess_of_exponent(exponent: complex, turn: float, status: Status) -> tuple[int, float, int]:
    """Return sign, X and binary exponent of X for a Floquet exponent of the undamped equation."""
    half = math.pi / turn
    sign = 1 if exponent.imag < 0.25 * turn else -1
    if status == "unstable":
        rise = exponent.real * half
        if rise < 300.0:
            return sign, math.sinh(rise) ** 2, 0
        power = 2.0 * rise / math.log(2.0)
        whole = math.floor(power)
        return sign, 0.25 * 2.0 ** (power - whole), whole
    angle = exponent.imag * half
    turned = math.sin(angle) ** 2 if sign > 0 else math.cos(angle) ** 2
    if status == "undecided":  # either part may be rounding: both count
        return sign, math.sinh(min(exponent.real * half, 300.0)) ** 2 - turned, 0
    return sign, -turned, 0
