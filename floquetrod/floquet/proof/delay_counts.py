"""How many multipliers of a system with delays lie outside the unit circle, proved by the turns of a determinant.

Let all delays and the period be whole numbers of steps h, q of them a period.  A solution with x(t + T) = z x(t) is
told by its q parts y_k(s) = x(k h + s), 0 <= s <= h.  With w = 1 / z the part that a delay of p steps reads is
w^m y_l, l = (k - p) mod q, m = (l - k + p) / q: the parts obey an ordinary linear system Y' = A(s, w) Y, a polynomial
in w, with Y(0) = P(w) Y(h), where P moves every part on by one, and the last to the first times w.  So

    f(w) = det(I - P(w) Phi(w)),  Phi(w) the map of that system over h,

is an entire function of w with f(0) = 1, and its zeros are the 1 / z, as often as z is a multiplier: characteristic
matrices of J. Sieber and R. Szalai, SIAM J. Appl. Dyn. Syst. 10 (2011) 129, doi:10.1137/100796455, here without poles.
The multipliers outside the circle are the zeros inside it, which the turns of f along it count.

Where all delays are multiples of c > 1 periods, Phi depends on u = w^c alone, and f is a polynomial in w whose n + 1
coefficients are entire functions of u: these are enclosed in place of f, so that long delays take no more points.

f is enclosed at N points of the circle.  Its Taylor coefficients are at most M(R) / R^k, M(R) a bound of |f| on the
circle of radius R (Gronwall, Hadamard), which bounds what the polynomial through these values is off by.  The
polynomial is enclosed on arcs so short that on each f stays in a disc that does not reach zero.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from floquetrod.equations import DelaySystem
from floquetrod.equations.pieces import exact_period
from floquetrod.floquet.proof.balls import Array, Doubles, up
from floquetrod.floquet.proof.many_digits import TooMuchWork, Unresolved
from floquetrod.floquet.proof.system_flow import monodromy
from floquetrod.floquet.proof.system_numbers import system_problem
from floquetrod.floquet.proof.system_problem import (
    Arithmetic,
    BallPiece,
    ExactRange,
    FirstOrder,
    Flow,
    Matrix,
    balanced,
)

_MOST_STATES = 24  # of all parts together (a choice: seconds)
_MOST_PERIODS = 32  # that a delay may last, or as many times what all delays are multiples of (a choice)
_LONGEST = 1000  # periods of a delay (a choice: a minute)
_MOST_POINTS = 512, 128  # of the circle, in doubles and with more digits (a choice)
_LEFT_OUT = 1e-15  # of f, which the points are chosen for
_CLEAR = 0.7  # part of its centre's modulus that a disc about f may have as radius; the turn is then below 90 degrees
_FIRST_ARCS = 128
_TERMS = 10  # of Taylor's series on an arc (a choice)
_MOST_ARCS = 2**12  # examined in one round, or some times the largest power (a choice)
_AT_ONCE = 2**12  # arcs (a choice)
_FINEST = 2**34  # arcs of a circle


class _Term(NamedTuple):
    """A coefficient in first order and balls."""

    steps: int  # back that it reads
    pieces: list[BallPiece]


class _StepPiece(NamedTuple):
    """A piece of the step."""

    begin: Fraction  # as a fraction of the period, as is the length
    length: Fraction
    powers: dict[int, BallPiece]  # A(s, w) by powers of w


class _StepSystem(NamedTuple):
    """Y' = A(s, w) Y over a step with the period as the unit of time."""

    parts: int  # of a period
    intervals: list[_StepPiece]
    states: int
    common: int  # the map is a function of w to this power; powers in pieces are of that


def hindrance(system: DelaySystem) -> str:
    """Return why multipliers of a system are not counted; "" where they are."""
    shares = _shares(system)[1]
    parts, states = _size(system, shares)
    most = _MOST_STATES * parts // states
    if not most:
        return f"not implemented for more than {_MOST_STATES} states with delays"
    if parts > most:
        return (
            "not implemented for incommensurate delays: exactly, these and the period are no whole numbers of a step "
            f"of which a period has at most {most}"
        )
    if any(share > _MOST_PERIODS * _common(shares) or share > _LONGEST for share in shares):
        if _common(shares) > 1:
            return f"not implemented for delays of more than {_LONGEST} periods"
        whole = "of a step of which the longest has" if system.is_constant else "of periods,"
        return f"not implemented for incommensurate delays, that are not whole numbers {whole} at most {_MOST_PERIODS}"
    return ""


def _size(system: DelaySystem, shares: list[Fraction]) -> tuple[int, int]:
    """Return the steps of a period, and the unknowns of all of them."""
    parts = math.lcm(*(share.denominator for share in shares))
    return parts, parts * system.order * (1 + system.is_second_order)


def _common(shares: list[Fraction]) -> int:
    """Return of how many periods, or whole parts of all delays, every delay is a multiple; 1 of parts of periods."""
    whole = all(share.denominator == 1 for share in shares)
    return math.gcd(*(int(share) for share in shares)) if whole and shares else 1


def outside(arithmetic: Arithmetic, system: DelaySystem) -> int:
    """Return how many multipliers lie outside the unit circle, none of them on it.

    Raises `Unresolved` where the digits are too few, `TooMuchWork` where it would take too long.
    """
    problem = _problem(arithmetic, system)
    count, left_out = _points(problem, arithmetic.digits)
    if problem.common == 1:
        values = arithmetic.zeros((count // 2 + 1,), real=False)
        for j in range(count // 2 + 1):
            values[j] = _value(arithmetic, problem, Fraction(j, count))
        return _turns(arithmetic, np.arange(count), _polynomial(arithmetic, values, count), left_out)
    terms = arithmetic.zeros((count // 2 + 1, problem.states), real=False)
    for j in range(count // 2 + 1):
        terms[j] = _by_powers(arithmetic, _map(arithmetic, problem, Fraction(j, count)))
    polynomial = arithmetic.zeros((problem.states * count + 1,), real=True)
    polynomial[0] = arithmetic.exact(np.ones(()))
    for k in range(problem.states):
        polynomial[1 + k * count : 1 + (k + 1) * count] = _polynomial(arithmetic, terms[:, k], count)
    exponents = np.add.outer(np.arange(1, problem.states + 1), problem.common * np.arange(count)).ravel()
    exponents = np.concatenate([[0], exponents])
    # Small terms, at most as large as their coefficients, are left out, too.
    sizes = polynomial.upper()
    order = np.argsort(sizes)
    dropped = np.cumsum(sizes[order]) <= 16.0 * (left_out + len(sizes) * float(sizes.min()))
    left_out = float(up(left_out + up(sizes[order[dropped]].sum() * (1.0 + 1e-12))))
    kept = np.sort(order[~dropped])
    return _turns(arithmetic, exponents[kept], polynomial[kept], left_out)


def _problem(arithmetic: Arithmetic, system: DelaySystem) -> _StepSystem:
    period, shares = _shares(system)
    parts, states = _size(system, shares)
    common = _common(shares)
    steps = [0, *(int(share * parts) // common for share in shares)]
    terms = list(map(_Term, steps, _coefficients(arithmetic, system, period)))
    ends = {piece.begin % Fraction(1, parts) for term in terms for piece in term.pieces}
    intervals = [
        _interval(arithmetic, terms, parts, low, high)
        for low, high in pairwise(sorted(ends | {Fraction(0), Fraction(1, parts)}))
    ]
    return _StepSystem(parts, intervals, states, common)


def _shares(system: DelaySystem) -> tuple[Fraction, list[Fraction]]:
    """Return the period and the delays as parts of it; where nothing varies, what all delays are multiples of."""
    delays = [Fraction(delay) for delay in system.delays]
    period = exact_period(system.present)
    if system.is_constant and delays:
        whole = math.lcm(*(delay.denominator for delay in delays))
        period = Fraction(math.gcd(*(int(delay * whole) for delay in delays)), whole)
    return period, [delay / period for delay in delays]


def _coefficients(arithmetic: Arithmetic, system: DelaySystem, period: Fraction) -> list[list[BallPiece]]:
    """Return the pieces of all coefficients in first order, in coordinates that balance the rows of their sum."""
    every = [system_problem(each) for each in (system.present, *(term.coefficient for term in system.delayed))]
    pieces = [[piece._replace(begin=piece.begin * each.period.low / period) for piece in each.pieces] for each in every]
    whole, unit = replace(every[0], pieces=tuple(itertools.chain.from_iterable(pieces))), ExactRange(period, period)
    if isinstance(whole, FirstOrder):
        first_order = whole.stretches(arithmetic, unit)
    else:
        first_order = whole.oscillators(arithmetic, unit, freed=False).stretches(arithmetic, own=len(pieces[0]))
    rest = iter(balanced(first_order, arithmetic.exact(np.eye(1))).pieces)
    return [list(itertools.islice(rest, len(each))) for each in pieces]


def _interval(arithmetic: Arithmetic, terms: list[_Term], parts: int, low: Fraction, high: Fraction) -> _StepPiece:
    """Return the coefficients of all parts of a solution over a piece of the step."""
    n = terms[0].pieces[0].mean.shape[0]
    powers: dict[int, BallPiece] = {}
    for k, term in itertools.product(range(parts), terms):
        column = (k - term.steps) % parts
        power = (column - k + term.steps) // parts
        phase = Fraction(k, parts)
        piece = next(each for each in reversed(term.pieces) if each.begin <= phase + low)
        if power not in powers:
            powers[power] = BallPiece(low, high - low, arithmetic.zeros((parts * n, parts * n), real=True), None, [])
        place = np.ix_(range(k * n, (k + 1) * n), range(column * n, (column + 1) * n))
        powers[power] = _added(arithmetic, powers[power], _moved(arithmetic, piece, phase + low, phase), place)
    return _StepPiece(low, high - low, powers)


def _moved(arithmetic: Arithmetic, piece: BallPiece, time: Fraction, phase: Fraction) -> BallPiece:
    """Return what a piece is from a time on, its waves turned by a phase."""
    mean = piece.mean
    if piece.slope is not None:
        mean = mean + piece.slope * arithmetic.rational(time - piece.begin)
    waves = [wave * _turned(arithmetic, k * phase) for k, wave in enumerate(piece.waves, 1)]
    return piece._replace(mean=mean, waves=waves)


def _turned(arithmetic: Arithmetic, turns: Fraction) -> Matrix:
    """Enclose exp(2 pi i turns)."""
    turns %= 1
    cosine, sine = arithmetic.turns(np.array(turns - (turns > Fraction(1, 2)), dtype=object))
    return cosine + sine.times_i()


def _added(arithmetic: Arithmetic, whole: BallPiece, own: BallPiece, block_index: Any) -> BallPiece:
    """Return a stretch with another's matrices added in a place."""
    shape = whole.mean.shape

    def plus(matrix: Matrix | None, block: Matrix | None, *, real: bool) -> Matrix | None:
        if block is None:
            return matrix
        total = arithmetic.zeros(shape, real=real) if matrix is None else matrix
        total[block_index] = total[block_index] + block
        return total

    waves = [plus(one, other, real=False) for one, other in itertools.zip_longest(whole.waves, own.waves)]
    mean, slope = plus(whole.mean, own.mean, real=True), plus(whole.slope, own.slope, real=True)
    return whole._replace(mean=mean, slope=slope, waves=waves)


def _points(problem: _StepSystem, digits: int) -> tuple[int, float]:
    """Return at how many points f is taken, and what the polynomial through its values is off by within the circle."""
    best = math.inf, 0.0, 0.0
    for radius in np.geomspace(1.02, 1e4, 80).tolist():
        # A row of P Phi has at most the norm |w| |Phi|, that of I one more.
        largest = problem.states * float(np.logaddexp(0.0, math.log(radius) + _growth(problem, radius)))
        points = (largest - math.log(_LEFT_OUT * (1.0 - 1.0 / radius))) / math.log(radius)
        best = min(best, (points, radius, largest))
    most = _MOST_POINTS[digits > Doubles.digits]
    if not best[0] < most:
        raise TooMuchWork(f"more than {most} points of a circle")
    count, (_, radius, largest) = 2 ** math.ceil(math.log2(max(best[0], 8.0))), best
    return count, 2.0 * math.exp(largest - count * math.log(radius)) / (1.0 - 1.0 / radius) * (1.0 + 1e-9)


def _growth(problem: _StepSystem, radius: float) -> float:
    """Return a bound of the logarithm of the norm of Phi(w), |w| = radius: the integral of a logarithmic norm."""
    total = 0.0
    for interval in problem.intervals:
        norm = 0.0
        for power, stretch in interval.powers.items():
            size: Callable[[Matrix], Array] = (lambda matrix: matrix.upper()) if power else _symmetric
            sizes = [size(matrix) for matrix in (stretch.mean, *stretch.waves)]
            sizes += [] if stretch.slope is None else [size(stretch.slope) * float(interval.length)]
            norm += radius**power * float(np.linalg.norm(np.sum(sizes, axis=0)))
        total += float(interval.length) * norm
    return float(up(total))


def _symmetric(matrix: Matrix) -> Array:
    """Return bounds of the entries of the symmetric part, of a wave at any time."""
    centre, offset = matrix.centre(), matrix.offset()
    return up(0.5 * (np.abs(centre + centre.T) + offset + offset.T))


def _map(arithmetic: Arithmetic, problem: _StepSystem, turns: Fraction) -> Matrix:
    """Enclose Phi where w, or its power that Phi depends on, is exp(2 pi i turns)."""
    n = problem.states
    real = monodromy(arithmetic, Flow([_real_stretch(arithmetic, each, turns) for each in problem.intervals], None))
    return real[:n, :n] + real[n:, :n].times_i()


def _value(arithmetic: Arithmetic, problem: _StepSystem, turns: Fraction) -> Matrix:
    """Enclose f at exp(2 pi i turns)."""
    n = problem.states
    moved = _map(arithmetic, problem, turns).each(lambda a: np.roll(a, n // problem.parts, axis=0))
    first = slice(0, n // problem.parts)
    moved[first] = moved[first] * _turned(arithmetic, turns)
    return _determinant(arithmetic, arithmetic.exact(np.eye(n, dtype=complex)) - moved)


def _by_powers(arithmetic: Arithmetic, matrix: Matrix) -> Matrix:
    """Enclose the coefficients of w, w^2, ... of det(I - w matrix), by Faddeev's and Leverrier's recursion."""
    n = matrix.shape[0]
    one, product = arithmetic.exact(np.eye(n, dtype=complex)), matrix
    found = arithmetic.zeros((n,), real=False)
    for k in range(1, n + 1):
        trace = arithmetic.zeros((), real=False)
        for i in range(n):
            trace = trace + product[i, i]
        found[k - 1] = -trace.over(k)
        product = matrix @ (product + one * found[k - 1])
    return found


def _real_stretch(arithmetic: Arithmetic, interval: _StepPiece, turns: Fraction) -> BallPiece:
    """Return a piece for one w: the real parts of the unknowns, then the imaginary ones."""
    n = len(next(iter(interval.powers.values())).mean.centre())
    waves = max(len(stretch.waves) for stretch in interval.powers.values())
    sloped = any(stretch.slope is not None for stretch in interval.powers.values())
    mean, slope = (arithmetic.zeros((2 * n, 2 * n), real=True) for _ in range(2))
    others = [arithmetic.zeros((2 * n, 2 * n), real=False) for _ in range(waves)]
    for power, stretch in interval.powers.items():
        cosine, sine = _turned(arithmetic, power * turns).parts()

        def put(to: Matrix, matrix: Matrix, c: Matrix = cosine, s: Matrix = sine) -> None:
            for rows, columns, part in (
                (0, 0, matrix * c),
                (0, n, -(matrix * s)),
                (n, 0, matrix * s),
                (n, n, matrix * c),
            ):
                place = slice(rows, rows + n), slice(columns, columns + n)
                to[place] = to[place] + part

        put(mean, stretch.mean)
        if stretch.slope is not None:
            put(slope, stretch.slope)
        for wave, matrix in zip(others, stretch.waves, strict=False):
            put(wave, matrix)
    return BallPiece(interval.begin, interval.length, mean, slope if sloped else None, others)


def _determinant(arithmetic: Arithmetic, matrix: Matrix) -> Matrix:
    """Enclose a determinant without divisions: R. S. Bird, Inf. Process. Lett. 111 (2011) 1072."""
    n = matrix.shape[0]
    product = matrix
    for _ in range(n - 1):
        upper = product.each(lambda a: np.triu(a, 1))
        below = arithmetic.zeros((), real=False)
        for i in reversed(range(n)):
            upper[i, i] = -below
            below = below + product[i, i]
        product = upper @ matrix
    return product[0, 0] if n % 2 else -product[0, 0]


def _polynomial(arithmetic: Arithmetic, values: Matrix, count: int) -> Matrix:
    """Return the real coefficients of the polynomial through values on the upper half of the circle, and conjugates."""
    k, j = np.arange(count), np.arange(count // 2 + 1)
    cosine, sine = _cosines(arithmetic, np.outer(k, j), count)
    weights = np.where((j == 0) | (j == count // 2), 1.0, 2.0)
    real, imaginary = values.parts()
    return (cosine @ real.shifted(weights) + sine @ imaginary.shifted(weights)).over(count)


def _cosines(arithmetic: Arithmetic, numerators: Array, denominator: int) -> tuple[Matrix, Matrix]:
    """Enclose cos and sin of 2 pi times fractions, whose denominator is a power of two."""
    turned = numerators % denominator / denominator
    cosine, sine = arithmetic.turns(np.where(turned > 0.5, turned - 1.0, turned))
    return cosine, sine


def _turns(arithmetic: Arithmetic, exponents: Array, polynomial: Matrix, left_out: float) -> int:
    """Return how often f turns about zero along the circle, of its coefficients of powers of w."""
    chosen = np.array([[float(math.comb(int(each), m)) for m in range(_TERMS + 1)] for each in exponents])
    sizes = up(up(chosen * polynomial.upper()[:, None]).sum(0) * (1.0 + 1e-12))
    terms = polynomial[:, None] * arithmetic.exact(chosen[:, :_TERMS])
    longest = 2 ** math.ceil(math.log2(max(int(exponents.max()), 1)))
    number, most = max(_FIRST_ARCS, longest), max(_MOST_ARCS, 4 * longest)
    arcs, places, values = np.arange(number), [], []
    while arcs.size:
        arithmetic.check_work(float(arcs.size * terms.shape[0] * _TERMS))
        open_arcs = []
        for some in np.array_split(arcs, math.ceil(arcs.size / _AT_ONCE)):
            cosine, sine = _cosines(arithmetic, np.outer(2 * some + 1, exponents), 2 * number)
            taylor = (cosine + sine.times_i()) @ terms
            centres, half = taylor.centre()[:, 0], math.pi / number * (1.0 + 1e-15)
            # Taylor's series about the centre, its last term for any place; binomials were rounded.
            steps = half ** np.arange(1, _TERMS + 1)
            bounds = np.concatenate([taylor.upper()[:, 1:], np.zeros((len(some), 1))], 1) + 2.0**-52 * sizes[1:]
            bounds[:, -1] = sizes[-1]
            radius = up(taylor.offset()[:, 0] + left_out + up(bounds @ steps))
            clear = radius < _CLEAR * np.abs(centres)
            places.append((2.0 * some[clear] + 1.0) / number)
            values.append(centres[clear])
            open_arcs.append(some[~clear])
        arcs = np.concatenate(open_arcs)
        arcs, number = np.concatenate([2 * arcs, 2 * arcs + 1]), 2 * number
        if arcs.size > most or number > _FINEST:
            raise Unresolved("a multiplier cannot be distinguished from one on the unit circle")
    along = np.concatenate(values)[np.argsort(np.concatenate(places))]
    return round(float(np.angle(np.roll(along, -1) / along).sum()) / (2.0 * math.pi))
