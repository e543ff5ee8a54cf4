"""The 2x2 map over a period, by Taylor series of high order."""

from __future__ import annotations

import cmath
import math
import sys
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod import equations
from floquetrod._util import validate
from floquetrod._util.compilation import INTERPRETED_UP_TO, runner
from floquetrod.equations import Equation, Mathieu, Meissner
from floquetrod.floquet.result import Cost, Stability, judge
from floquetrod.kernels.taylor import ORDER, REACH, advance

_MOST_STEPS = 1_000_000
_EPS = 2.220446049250313e-16


class _Piece(NamedTuple):
    """A stretch of time on which the coefficient is one Fourier series."""

    mean: float
    amplitudes: tuple[complex, ...]
    start: float
    length: float


class _Map(NamedTuple):
    """Solutions (u1, u1', u2, u2') * 2**exponent at the end, from (1, 0, 0, 1), and the steps they took."""

    y: NDArray[np.float64]
    exponent: int
    steps: int


def monodromy(equation: Equation, *, rtol: float = 1e-12) -> Stability:
    """Judge by the map over a period, integrated with Taylor series of order 24.

    Where the coefficient is even about an instant, half a period from there is enough: with y1, y2 the cosine- and
    sine-like solutions and h half the period, trace - 2 = 4 y1'(h) y2(h) and trace + 2 = 4 y1(h) y2'(h), products
    that keep their digits where the trace loses them.

    Parameters
    ----------
    equation : Mathieu, Meissner or Hill
        Damping c by the exact substitution A = exp(-c tau) u, p -> p + c^2.  The constant stretches of a square wave
        are integrated like anything else; steps end at the jumps.
    rtol : float
        Accuracy asked of the map, relative to its largest entry: steps are halved until halving changes no more.

    Returns
    -------
    Stability
        ``error`` is an estimate: the change on halving the steps, and rounding.
    """
    equations.require(equation)
    rtol = validate.positive("rtol", rtol)
    pieces, half = _pieces(equation)
    frequency = max(_frequency(piece, equation.period) for piece in pieces)
    needed = _needed(pieces, frequency)
    if needed > _MOST_STEPS:
        finer = "square_wave" if isinstance(equation, Meissner) else "spectral"
        return judge(
            equation,
            "monodromy",
            sign=1,
            excess=0.0,
            excess_error=math.inf,
            cost=Cost(0, "steps"),
            note=f"would take {needed:.3g} steps or more, above the limit of {_MOST_STEPS}; use method={finer!r}",
        )
    fine, change, total = _converged(pieces, equation.period, frequency, rtol)
    relative = change + 4.0 * _EPS * (fine.steps + 4)
    sign, excess, exponent, error = _excess(fine, relative, frequency, half)
    return judge(
        equation,
        "monodromy",
        sign=sign,
        excess=excess,
        exponent=exponent,
        excess_error=error,
        cost=Cost(total, "steps"),
    )


def monodromy_matrix(equation: Equation, *, rtol: float = 1e-12, start: float = 0.0) -> NDArray[np.float64]:
    """Return the matrix that carries (A, A') from tau = ``start`` over one period.

    Parameters
    ----------
    equation : Mathieu, Meissner or Hill
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
    pieces = _from(equation, start)
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
    matrix: NDArray[np.float64] = shear @ np.array([[y[0], y[2]], [y[1], y[3]]]) @ back
    return matrix


def _pieces(equation: Equation) -> tuple[list[_Piece], bool]:
    """Return what to integrate, and whether it is half a period from an instant of even symmetry."""
    c2 = equation.damping**2
    if isinstance(equation, Mathieu):  # beta + alpha sin tau about pi / 2: beta + alpha cos
        return [_Piece(equation.beta + c2, (complex(equation.alpha, 0.0),), 0.0, math.pi)], True
    if isinstance(equation, Meissner):
        high, low = math.fsum((equation.beta, equation.alpha, c2)), math.fsum((equation.beta, -equation.alpha, c2))
        return [_Piece(high, (), 0.0, 0.5 * math.pi), _Piece(low, (), 0.0, 0.5 * math.pi)], True
    amplitudes = _symmetric(equation.harmonics)
    if amplitudes is not None:
        return [_Piece(equation.mean + c2, amplitudes, 0.0, 0.5 * equation.period)], True
    return _from(equation, 0.0), False


def _from(equation: Equation, start: float) -> list[_Piece]:
    """Return the pieces of one whole period from ``start``."""
    c2 = equation.damping**2
    if isinstance(equation, Meissner):
        index, phase = divmod(start, math.pi)  # together, so that rounding beside a jump cannot set them at odds
        first = -1.0 if index % 2.0 else 1.0
        values = [math.fsum((equation.beta, s * equation.alpha, c2)) for s in (first, -first)]
        lengths = (math.pi - phase, math.pi, phase)
        pairs = zip((values[0], values[1], values[0]), lengths, strict=True)
        return [_Piece(value, (), 0.0, length) for value, length in pairs if length > 0.0]
    hill = equation.as_hill()
    return [_Piece(hill.mean + c2, hill.harmonics, start, hill.period)]


def _symmetric(harmonics: tuple[complex, ...]) -> tuple[complex, ...] | None:
    """Return the real amplitudes about an instant of even symmetry, None where there is none (to rounding)."""
    first = next((k for k, z in enumerate(harmonics, start=1) if z != 0.0), None)
    if first is None:
        return ()
    for turn in range(2 * first):
        phase = (math.pi * turn - cmath.phase(harmonics[first - 1])) / first
        turned = [z * cmath.exp(1j * k * phase) for k, z in enumerate(harmonics, start=1)]
        if all(abs(z.imag) <= 8.0 * _EPS * k * abs(z) for k, z in enumerate(turned, start=1)):
            return tuple(complex(z.real, 0.0) for z in turned)
    return None


def _frequency(piece: _Piece, period: float) -> float:
    """Return a frequency that bounds how fast solution and coefficient vary."""
    turn = 2.0 * math.pi / period
    return math.sqrt(abs(piece.mean) + sum(map(abs, piece.amplitudes))) + turn * max(1, len(piece.amplitudes))


def _needed(pieces: list[_Piece], frequency: float) -> float:
    """Return the steps of the first two maps together, possibly infinite."""
    return 3.0 * frequency * math.fsum(piece.length for piece in pieces) / REACH


def _converged(pieces: list[_Piece], period: float, frequency: float, rtol: float) -> tuple[_Map, float, int]:
    """Return the map once halving the steps changes it by no more than ``rtol``, that change, and all steps taken.

    It also stops where rounding or the limit on steps allows no more; the change then tells.
    """
    wanted = max(1, math.ceil(_needed(pieces, frequency) / 3.0))
    coarse = _carry(pieces, period, wanted)
    total = coarse.steps
    while True:
        fine = _carry(pieces, period, 2 * wanted)
        total += fine.steps
        change = _change(coarse, fine, frequency)
        if change <= max(rtol, 64.0 * _EPS * fine.steps) or 6 * wanted > _MOST_STEPS:
            return fine, change, total
        coarse, wanted = fine, 2 * wanted


def _carry(pieces: list[_Piece], period: float, steps: int, order: int = ORDER) -> _Map:
    """Carry the unit solutions over the pieces in about ``steps`` steps."""
    whole = sum(piece.length for piece in pieces)
    y = np.array([1.0, 0.0, 0.0, 1.0])
    exponent, taken = 0, 0
    # Machine code is a hundred times faster, but for a few steps not worth loading numba.
    run = runner(advance, steps, interpret_up_to=0 if "numba" in sys.modules else INTERPRETED_UP_TO)
    for piece in pieces:
        share = max(1, math.ceil(steps * piece.length / whole - 1e-9))
        real = np.array([z.real for z in piece.amplitudes])
        imag = np.array([z.imag for z in piece.amplitudes])
        turn = 2.0 * math.pi / period
        exponent += run(piece.mean, real, imag, turn, piece.start, piece.length, share, order, y)
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
