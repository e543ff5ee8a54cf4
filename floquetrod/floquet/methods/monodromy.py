"""The 2x2 map over a period, by Taylor series of high order."""

from __future__ import annotations

import math
import sys
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from floquetrod import equations
from floquetrod._util import validate
from floquetrod._util.arrays import EPS, Floats
from floquetrod._util.compilation import INTERPRETED_UP_TO, runner
from floquetrod.equations import Equation, Piece
from floquetrod.equations.base import from_instant
from floquetrod.floquet.kernels.taylor import ORDER, REACH, advance
from floquetrod.floquet.verdict import Cost, Stability, classify

_MOST_STEPS = 1_000_000


class _UndampedPiece(NamedTuple):
    """A piece of the undamped coefficient, p + c^2, in doubles: where it begins, its length and its series."""

    start: float
    length: float
    mean: float
    slope: float
    amplitudes: tuple[complex, ...]


class _Map(NamedTuple):
    """Solutions (u1, u1', u2, u2') * 2**exponent at the end, from (1, 0, 0, 1), and the steps they took."""

    y: Floats
    exponent: int
    steps: int


def monodromy(equation: Equation, *, rtol: float = 1e-12) -> Stability:
    """Classify by the map over a period, integrated with Taylor series of order 24.

    Where the coefficient is even about an instant, half a period from there is enough: with y1, y2 the cosine- and
    sine-like solutions and h half the period, trace - 2 = 4 y1'(h) y2(h) and trace + 2 = 4 y1(h) y2'(h), products
    that keep their digits where the trace loses them.

    Parameters
    ----------
    equation : Equation
        Damping c by the exact substitution A = exp(-c tau) u, p -> p + c^2.  Steps end where pieces of the coefficient
        meet.
    rtol : float
        Accuracy required of the map, relative to its largest entry: steps are halved until halving changes no more.

    Returns
    -------
    Stability
        ``error`` is an estimate: the change on halving the steps, and rounding.

    Raises
    ------
    TypeError, ValueError
        For anything but an equation, and an accuracy that is not positive.
    """
    equations.require(equation)
    rtol = validate.positive("rtol", rtol)
    half = equation.half()
    pieces = _stretches(equation.pieces() if half is None else half, 0.0, equation)
    frequency = max(_frequency(piece, equation.period) for piece in pieces)
    needed = _needed(pieces, frequency)
    if needed > _MOST_STEPS:
        note = f"would take {needed:.3g} steps or more, above the limit of {_MOST_STEPS}; use another method"
        return Stability.declined(equation, "monodromy", Cost(0, "steps"), note)
    fine, change, total = _converged(pieces, equation.period, frequency, rtol)
    relative = change + 4.0 * EPS * (fine.steps + 4)
    sign, excess, exponent, error = _excess(fine, relative, frequency, half is not None)
    return classify(
        equation,
        "monodromy",
        sign=sign,
        excess=excess,
        exponent=exponent,
        excess_error=error,
        cost=Cost(total, "steps"),
    )


def monodromy_matrix(equation: Equation, *, rtol: float = 1e-12, start: float = 0.0) -> Floats:
    """Return the matrix that carries (A, A') from tau = ``start`` over one period.

    Parameters
    ----------
    equation : Equation
    rtol : float
        Accuracy relative to the largest entry.
    start : float
        Where the period begins; the matrix depends on it, its eigenvalues do not.

    Returns
    -------
    ndarray (2, 2)
        Of determinant exp(-2 c period) (Liouville).

    Raises
    ------
    OverflowError
        Where an entry exceeds the range of a double; `monodromy` carries such growth as a logarithm.
    """
    equations.require(equation)
    rtol, start = validate.positive("rtol", rtol), validate.finite("start", start)
    pieces = _stretches(*from_instant(equation.pieces(), start, equation.period), equation)
    frequency = max(_frequency(piece, equation.period) for piece in pieces)
    needed = _needed(pieces, frequency)
    if needed > _MOST_STEPS:
        raise ValueError(
            f"equation would take {needed:.3g} steps or more, above the limit of {_MOST_STEPS}; "
            "its coefficient is too large or its period too long"
        )
    fine, _, _ = _converged(pieces, equation.period, frequency, rtol)
    # Growth and decay are combined before either is applied: alone they may leave the range that their product keeps.
    power = fine.exponent - equation.damping * equation.period / math.log(2.0)
    whole = math.floor(power)
    with np.errstate(over="ignore", under="ignore"):
        y = np.ldexp(fine.y * 2.0 ** (power - whole), whole)
    if not np.isfinite(y).all():
        raise OverflowError("the map over a period exceeds the range of a double; use monodromy(...).exponents")
    # (A, A') = exp(-c tau) (u, u' - c u)
    c = equation.damping
    shear = np.array([[1.0, 0.0], [-c, 1.0]])
    back = np.array([[1.0, 0.0], [c, 1.0]])
    matrix: Floats = shear @ np.array([[y[0], y[2]], [y[1], y[3]]]) @ back
    return matrix


def _stretches(pieces: tuple[Piece, ...], start: float, equation: Equation) -> list[_UndampedPiece]:
    """Return the pieces over a period from ``start`` on, with the damping removed."""
    square = Fraction(equation.damping) ** 2
    stretches, share = [], Fraction(0)
    for piece in pieces:
        mean = float(Fraction(piece.start) + square)  # rounded once
        begin, length = start + float(share) * equation.period, float(piece.share) * equation.period
        if length > 0.0:
            stretches.append(_UndampedPiece(begin, length, mean, float(piece.slope), piece.harmonics))
        share += piece.share
    return stretches


def _frequency(piece: _UndampedPiece, period: float) -> float:
    """Return a frequency that bounds how fast solution and coefficient vary."""
    omega = 2.0 * math.pi / period
    largest = abs(piece.mean) + abs(piece.slope) * piece.length + sum(map(abs, piece.amplitudes))
    return math.sqrt(largest) + omega * max(1, len(piece.amplitudes))


def _needed(pieces: list[_UndampedPiece], frequency: float) -> float:
    """Return the steps of the first two maps together, possibly infinite."""
    return 3.0 * frequency * math.fsum(piece.length for piece in pieces) / REACH


def _converged(pieces: list[_UndampedPiece], period: float, frequency: float, rtol: float) -> tuple[_Map, float, int]:
    """Return the map once halving the steps changes it by no more than ``rtol``, that change, and all steps taken.

    It also stops where rounding or the limit on steps allows no more; the change then shows it.
    """
    wanted = max(1, math.ceil(_needed(pieces, frequency) / 3.0))
    coarse = _carry(pieces, period, wanted)
    total = coarse.steps
    while True:
        fine = _carry(pieces, period, 2 * wanted)
        total += fine.steps
        change = _change(coarse, fine, frequency)
        if change <= max(rtol, 64.0 * EPS * fine.steps) or 6 * wanted > _MOST_STEPS:
            return fine, change, total
        coarse, wanted = fine, 2 * wanted


def _carry(pieces: list[_UndampedPiece], period: float, steps: int) -> _Map:
    """Carry the unit solutions over the pieces in about ``steps`` steps."""
    whole = sum(piece.length for piece in pieces)
    y = np.array([1.0, 0.0, 0.0, 1.0])
    exponent, taken = 0, 0
    # Machine code is a hundred times faster, not worth loading numba for a few steps.
    run = runner(advance, steps, interpret_up_to=0 if "numba" in sys.modules else INTERPRETED_UP_TO)
    for piece in pieces:
        share = max(1, math.ceil(steps * piece.length / whole - 1e-9))
        real = np.array([z.real for z in piece.amplitudes])
        imag = np.array([z.imag for z in piece.amplitudes])
        omega = 2.0 * math.pi / period
        exponent += run(piece.mean, piece.slope, real, imag, omega, piece.start, piece.length, share, ORDER, y)
        taken += share
    # The kernel scales when it must; two maps compare only once both are scaled alike.
    shift = math.frexp(np.abs(y).max())[1]
    return _Map(np.ldexp(y, -shift), exponent + shift, taken)


def _change(coarse: _Map, fine: _Map, frequency: float) -> float:
    """Return the difference of two maps relative to the largest entry, slopes in units of the frequency."""
    unit = np.array([1.0, 1.0 / frequency, frequency, 1.0])
    shift = coarse.exponent - fine.exponent
    if abs(shift) > 60:
        return math.inf
    return float((np.abs(np.ldexp(coarse.y, shift) - fine.y) * unit).max() / (np.abs(fine.y) * unit).max())


def _excess(end: _Map, relative: float, frequency: float, half: bool) -> tuple[int, float, int, float]:
    """Return sign, X, its binary exponent and its error relative to max(1, |X|)."""
    y1, dy1, y2, dy2 = map(float, end.y)
    # Entries are comparable once slopes are measured in units of the frequency.
    size = max(abs(y1), abs(dy1) / frequency, abs(y2) * frequency, abs(dy2))
    error = relative * size
    if not half:
        trace = y1 + dy2
        whole = math.ldexp(1.0, -min(end.exponent, 1000))
        excess = 0.25 * (abs(trace) - 2.0 * whole)
        scale = max(whole, abs(excess))
        return (1 if trace >= 0.0 else -1), excess, end.exponent, 0.5 * error / scale
    first, second, e = dy1, y2, 2 * end.exponent
    spread = error * frequency * abs(second) + error / frequency * abs(first) + error * error
    sign = 1
    if first * second < -0.5 * math.ldexp(1.0, -min(e, 1000)):
        first, second, sign = -y1, dy2, -1
        spread = error * (abs(first) + abs(second)) + error * error
    excess = first * second
    return sign, excess, e, spread / max(math.ldexp(1.0, -min(e, 1000)), abs(excess))
