"""Many digits: Taylor series in fixed-point arithmetic with a bound of their error, and eigenvalues to as many digits.

The coefficients are the doubles given, taken exactly: mass and uniform damping are divided out and removed in many
digits.  No symmetry is used in the integration, so that what other methods derive from symmetries is checked here.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.equations.complex_form import complex_matrix
from floquetrod.equations.hill_system import states
from floquetrod.equations.pieces import TimedPiece
from floquetrod.floquet.multipliers import independent_solutions, precise_maps, precise_spectra
from floquetrod.floquet.multipliers.classification import LogDiscs, ManyDigits, classify_multipliers, classify_pairs
from floquetrod.floquet.multipliers.precise_maps import PeriodMap, PieceSeries, Plan
from floquetrod.floquet.multipliers.symplectic import pair_matrix
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.problems import undamped_pairs
from floquetrod.floquet.verdict import Cost

_MOST_DIGITS = 120  # to which digits are raised while the verdict is open, unless asked otherwise
_LARGEST_WORK = 5e7  # products of entries, times their cost: about ten seconds (measured)
_FEWEST_PRODUCTS = 10  # of matrices of the order of the system in first order, that a map takes at least
_MOST_ENTRIES = 200_000  # of matrices, each a number of many digits: a second before anything is computed (measured)
_SETTLED = 1e-13  # relative error of the multipliers: more digits than a double's are of no use
_MOST_TRIES = 4  # to reach the digits wanted, which the product of the maps may lose
_LEAST_ERROR = 1e-300  # of a map, so that it is a double


class _PreciseSystem(NamedTuple):
    """A system in first order: its pieces per unit of phase, and how its pairs are read off the map.

    ``kind`` is "hamiltonian" (canonical coordinates), "reversible" (an even instant at the start) or "general";
    ``damping`` is the uniform damping removed; ``uncertainty`` the error of the coefficients.
    """

    pieces: tuple[PieceSeries, ...]
    kind: str
    damping: float
    uncertainty: float


def reference(
    system: HillSystem | PeriodicSystem, *, digits: int = 30, most_digits: int = _MOST_DIGITS
) -> SystemStability:
    """Classify a system with the map over a period computed to ``digits`` digits.

    Systems whose multipliers come in mu, 1 / mu are classified by y = (mu + 1/mu - 2) / 4 of their pairs, without
    uniform damping; others by their multipliers.

    Parameters
    ----------
    system : HillSystem or PeriodicSystem
        The matrices and the period are taken as the exact binary numbers they are.
    digits : int
        Decimal digits of the map relative to its norm, from 10 to 1000.
    most_digits : int
        While the verdict is undecided, ``digits`` are doubled up to this number, as far as the work allows; 10 to 1000.
        120 by default.

    Returns
    -------
    SystemStability
        The error of the map is a bound on truncation and rounding; the error of the multipliers a bound for all maps
        within that error.  "undecided" where a multiplier cannot be distinguished from the unit circle, or several from
        each other, with all these digits, whose number is in ``note``, and where the work would take more than about
        ten seconds.

    Raises
    ------
    TypeError, ValueError
        For digits other than whole numbers from 10 to 1000.

    Examples
    --------
    >>> reference(HillSystem([[1.0, 0.0], [0.0, 4.0]], cosines=[[[0.1, 0.2], [0.2, 0.16]]])).strongly_stable
    True
    """
    from mpmath.ctx_mp import MPContext

    digits = validate.integer("digits", digits, 10, 1000)
    most_digits = validate.integer("most_digits", most_digits, 10, 1000)
    result: SystemStability | None = None
    terms = 0
    while True:
        context = MPContext()
        verdict, used, numerical = _attempt(system, context, digits, terms)
        terms += used
        if verdict is None:
            note = f"{digits} digits would take too long"
            return (
                SystemStability.declined(system, "reference", Cost(terms, "terms"), note) if result is None else result
            )
        if verdict.status == "undecided":
            verdict = replace(verdict, note=f"{verdict.note}, computed to {digits} digits")
        if result is None or verdict.status != "undecided" or _known(verdict) >= _known(result):
            result = verdict
        settled = result.status != "undecided" and result.error < _SETTLED
        if settled or not numerical or 2 * digits > most_digits:
            return result
        digits *= 2


def _known(result: SystemStability) -> int:
    """Return how many exponents are known."""
    return sum(exponent == exponent for exponent in result.exponents)


def _attempt(
    system: HillSystem | PeriodicSystem, context: Any, digits: int, before: int
) -> tuple[SystemStability | None, int, bool]:
    """Return the verdict (None: too much work), the terms, and whether more digits would make the error smaller."""
    waves = sum(len(piece.harmonics) for piece in by_pieces.in_time(system))
    rows = states(by_pieces.real_form(system))
    if _FEWEST_PRODUCTS * rows**3 > _LARGEST_WORK or 2 * waves * rows**2 > _MOST_ENTRIES:
        return None, 0, True
    context.dps = 2 * digits + 40
    more, total = 0.0, 0
    for _ in range(_MOST_TRIES):
        problem = _problem(system, context)
        planned = precise_maps.plan(problem.pieces, digits + more)
        if planned is None or _work(problem, planned) > _LARGEST_WORK:
            return None, total, True
        period_map = precise_maps.period_map(problem.pieces, context, planned)
        total += period_map.terms
        size = max(float(abs(v)) for v in period_map.matrix.flat)
        missing = float(context.log10(period_map.error / max(size, 1.0))) + digits
        if not 0.0 < missing < math.inf:
            break
        more += missing + 1.0
    order = len(period_map.matrix)
    uncertainty = problem.uncertainty * order * size
    error = max(float(period_map.error), _LEAST_ERROR)
    cost = Cost(before + total, "terms")
    result = _classified(system, problem, period_map, error + uncertainty, context, cost)
    return result, total, uncertainty < error


def _work(problem: _PreciseSystem, planned: Sequence[Plan]) -> float:
    """Return about how many small products of integers a plan takes."""
    work = 0.0
    for series, one in zip(problem.pieces, planned, strict=True):
        order, waves = len(series.mean), series.waves
        width = int(np.count_nonzero((waves != 0).any(axis=(0, 1)))) if len(waves) else 0
        mixed = len(waves) * width * order  # products for a term, for each one before it and for each row
        each = order**3 * (1.0 if series.slope is None else 2.0) + mixed * (0.25 * one.order + width) + 40
        work += one.terms * each * (1.0 + (one.bits / 1500.0) ** 1.6)
    return work


def _problem(system: HillSystem | PeriodicSystem, context: Any) -> _PreciseSystem:
    """Return a system in first order, per unit of phase, in the precision of a context."""
    freed = undamped_pairs(system)
    kind: str = freed[0].structure if freed else "general"
    damping, period = freed[1] if freed else 0.0, by_pieces.exact_period(system)
    pieces = by_pieces.in_time(system)
    if isinstance(system, HillSystem):
        if freed and kind == "reversible" and isinstance(freed[0], HillSystem):
            pieces = by_pieces.between(pieces, _even_start(freed[0]), period)
        of_mean, of_other, spread = _first_order(system, kind, damping, context)
    else:
        of_mean = of_other = functools.partial(_exact, context=context)
        spread = 1.0
    every = [(of_mean(p.mean), None if p.slope is None else of_other(p.slope), _waves(p, of_other)) for p in pieces]
    unit = _number(period, context) / (2 * context.pi)
    size = np.maximum.reduce(
        [_size(*piece_sizes, float(p.length)) for piece_sizes, p in zip(every, pieces, strict=True)]
    )
    scales = _scales(size, kind != "general", 1.0 / float(unit))
    ratio = scales[None, :] / scales[:, None]
    turn, order = 2 * context.pi / _number(period, context), len(ratio)
    series = []
    for piece, (mean, slope, waves) in zip(pieces, every, strict=True):
        if slope is not None:
            mean, slope = mean + slope * _number(piece.begin - piece.origin, context), slope * ratio * unit**2
        turned = np.array([w * ratio * unit for w in waves], dtype=object).reshape(len(waves), order, order)
        begin, length = (_number(time, context) * turn for time in (piece.begin, piece.length))
        series.append(PieceSeries(mean * ratio * unit, turned, begin, length, slope))
    uncertainty = float(period) * system.coefficient_error * spread * float(ratio.max())
    return _PreciseSystem(tuple(series), kind, damping, uncertainty)


def _even_start(system: HillSystem) -> Fraction:
    """Return an instant about which a reversible system is even: of a single sine, a quarter of its period."""
    if system.pieces:
        return system.even_start or Fraction(0)
    alone = system.even_form is not None and float(system.even_form.start) != 0.0
    return Fraction(system.period) / (4 * len(system.harmonics)) if alone else Fraction(0)


def _waves(piece: TimedPiece, of: Callable[[Floats], NDArray[Any]]) -> list[NDArray[Any]]:
    return [of(part) for z in piece.harmonics for part in (z.real, -z.imag)]


def _size(mean: NDArray[Any], slope: NDArray[Any] | None, waves: list[NDArray[Any]], length: float) -> Floats:
    """Return about how large each entry may be."""
    parts = [mean, *waves] if slope is None else [mean, *waves, slope * length]
    return np.asarray(sum(np.abs(part.astype(float)) for part in parts))


def _first_order(
    system: HillSystem, kind: str, damping: float, context: Any
) -> tuple[Callable[..., NDArray[Any]], Callable[..., NDArray[Any]], float]:
    """Return functions from a mean of K, and from its other matrices, to matrices of first order without damping.

    In (q, p), p = M q' + G q / 2, where it is Hamiltonian, else in (q, q').  Also by how much an error of K's entries
    may grow on the way.
    """
    n = system.order
    zero, one = (_exact(array, context) for array in (np.zeros((n, n)), np.eye(n)))

    def matrix(value: Floats | None) -> NDArray[Any]:
        return zero if value is None else _exact(value, context)

    mass = one if system.mass is None else _exact(system.mass, context)
    inverse, gyroscopic = _inverse(mass, context), matrix(system.gyroscopic)
    c = context.mpf(damping)
    if kind == "hamiltonian":
        half = gyroscopic / 2
        bent = c * c * mass + np.dot(half, np.dot(inverse, half))
        drift = np.dot(inverse, half)

        def whole(mean: Floats) -> NDArray[Any]:
            return np.block([[-drift, inverse], [bent - _exact(mean, context), -np.dot(half, inverse)]])

        return whole, lambda part: np.block([[zero, zero], [-_exact(part, context), zero]]), 1.0
    friction = zero if kind == "reversible" else np.dot(inverse, matrix(system.damping) + gyroscopic)

    def moving(mean: Floats) -> NDArray[Any]:
        return np.block([[zero, one], [c * c * one - np.dot(inverse, _exact(mean, context)), -friction]])

    def other(part: Floats) -> NDArray[Any]:
        return np.block([[zero, zero], [-np.dot(inverse, _exact(part, context)), zero]])

    return moving, other, float(np.abs(inverse.astype(float)).sum(axis=1).max())


def _scales(size: Floats, paired: bool, w: float) -> Floats:
    """Return powers of two by which coordinates are divided: one for all momenta where the map comes in pairs."""
    if not paired:
        return independent_solutions.balance(size)
    n = len(size) // 2
    lower, upper = float(np.linalg.norm(size[n:, :n])), float(np.linalg.norm(size[:n, n:]))
    scale = 2.0 ** round(math.log2(max(math.sqrt(lower / upper), 0.01 * w / upper))) if upper > 0.0 else 1.0
    return np.concatenate([np.ones(n), np.full(n, scale)])


def _classified(
    system: HillSystem | PeriodicSystem,
    problem: _PreciseSystem,
    period_map: PeriodMap,
    error: float,
    context: Any,
    cost: Cost,
) -> SystemStability:
    """Return the verdict that the map over a period allows."""
    # General systems: discs about the eigenvalues mu of the map over a period.  Where multipliers come in mu, 1 / mu:
    # discs about the numbers y = (mu + 1 / mu - 2) / 4 = sinh^2(log(mu) / 2), half as many, eigenvalues of the matrix
    # of pairs, or, for a reversible map S, of (S_11 - 1) / 2, S_11 its upper left block, as S + 1/S is twice its
    # diagonal blocks.  Multipliers that meet at 1 or -1 are square roots there; y is not, and keeps its digits.  Growth
    # over a period is |Re 2 asinh(sqrt y)| less damping times period, both in many digits: the difference may be far
    # smaller than either.
    if isinstance(system, PeriodicSystem) and system.is_complex:
        period_map = period_map._replace(matrix=complex_matrix(period_map.matrix))
    if problem.kind == "general":
        discs = precise_spectra.eigenvalue_discs(period_map.matrix, error, context)
        return classify_multipliers(system, "reference", _logarithms(discs, context) if discs else None, cost=cost)
    n = len(period_map.matrix) // 2
    size = max(float(abs(v)) for v in period_map.matrix.flat)
    slip = error + math.ldexp(n * n * (1.0 + size), 8 - context.prec)  # with the rounding
    reduced = None
    if problem.kind == "hamiltonian":
        reduced = pair_matrix(period_map.matrix, slip, math.ldexp(1.0, -context.prec))
        matrix, slip = reduced.matrix, reduced.error
    else:
        matrix = (period_map.matrix[:n, :n] - _exact(np.eye(n), context)) / 2
    pairs = precise_spectra.eigenvalue_discs(matrix, slip, context)
    if pairs is None:
        return classify_pairs(system, "reference", None, cost=cost)
    krein = None if reduced is None else functools.partial(precise_spectra.krein_sign, reduced, pairs)
    limit = context.mpf(problem.damping) * _number(by_pieces.exact_period(system), context)
    growth = [abs((2 * context.asinh(context.sqrt(y))).real) - limit for y in pairs.values]
    digits = ManyDigits(
        np.array([complex(1 + y) for y in pairs.values]),
        np.array([float(g) for g in growth]),
        lambda cluster: precise_spectra.discriminant(pairs, cluster),
    )
    return classify_pairs(system, "reference", pairs.rounded(), krein=krein, digits=digits, cost=cost)


def _logarithms(discs: precise_spectra.PreciseDiscs, context: Any) -> LogDiscs:
    """Return the logarithms of multipliers, rounded after they are taken."""
    values, low, high, radii = [], [], [], []
    for mu, radius in zip(discs.values, discs.radii.tolist(), strict=True):
        size = abs(mu)
        values.append(complex(context.log(mu)) if size > 0 else complex(-745.0, 0.0))
        low.append(float(context.log(size - radius)) if size > radius else -math.inf)
        high.append(float(context.log(size + radius)))
        radii.append(-math.log1p(-float(radius / size)) if size > radius else math.inf)
    return LogDiscs(np.array(values), np.array(low), np.array(high), np.array(radii), discs.clusters)


def _exact(matrix: Floats, context: Any) -> NDArray[Any]:
    """Return doubles as numbers of mpmath."""
    return np.array([context.mpf(v) for v in matrix.ravel().tolist()], dtype=object).reshape(matrix.shape)


def _number(value: Fraction, context: Any) -> Any:
    """Return an exact number in the precision of a context."""
    return context.mpf(value.numerator) / value.denominator


def _inverse(matrix: NDArray[Any], context: Any) -> NDArray[Any]:
    inverse = context.inverse(context.matrix(matrix.tolist()))
    return np.array(inverse.tolist(), dtype=object).reshape(matrix.shape)
