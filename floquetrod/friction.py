"""A kick against Coulomb friction: does A'' + 2 c A' = (beta + alpha sin tau) A - gamma sign(A') escape, ever?

Every motion starts at A(0) = 0 with A'(0) = epsilon, the kick.  It either stays bounded for ever or grows in the end
like the growing Floquet solution; which, is decided for all time and not for some number of periods.  The equation is
Eq. (14) of DOI 10.1115/1.4031710; derivations and proofs are in docs/friction.md.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod import _validate, mathieu
from floquetrod._compile import broadcast, compiled, fastest, over_chunks
from floquetrod.equations import FrictionalMathieu, require
from floquetrod.kernels import friction as kernels
from floquetrod.kernels.frictional_leapfrog import frictional_leapfrog_fill

UNDECIDED, BOUNDED, ESCAPES = -1, 0, 1
"""Values of `outcome`."""

_EFFORT = 500_000  # cells an orbit may take, 32 or more to a period: a few thousandths of a second (a choice)
_SHORT = 2000  # cells that are cheaper interpreted than numba is to load (measured)


class UndecidedWarning(UserWarning):
    """Some orbits could not be decided; they are not counted among those that escape."""


def outcome(
    alpha: Any,
    beta: Any,
    gamma: Any,
    epsilon: Any,
    damping: Any = 0.0,
    *,
    effort: int = _EFFORT,
    workers: int | None = None,
) -> Any:
    """Return the fate of each kick: `ESCAPES` (1), `BOUNDED` (0) or `UNDECIDED` (-1), as int8.

    Parameters
    ----------
    alpha, beta, gamma, epsilon, damping : array_like
        Broadcast against each other.  gamma and damping are zero or more; a negative kick is the mirror image of its
        positive.  Fastest where epsilon varies along the last axis.
    effort : int
        Cells an orbit may take before it is given up as undecided.
    workers : int, optional
        Threads; by default all cores.

    Notes
    -----
    Without friction an orbit escapes where Mathieu's equation is unstable and the kick is not zero.  Where it is
    stable no kick escapes: proved but for exact resonances, which no double hits (docs/friction.md).

    Examples
    --------
    >>> outcome(0.0, 0.25, 1.0, [1.999, 2.001]).tolist()
    [0, 1]
    """
    shape, alpha, beta, gamma, kick, c = _arguments(alpha, beta, gamma, epsilon, damping)
    fates = _fates(alpha, beta, gamma, kick, c, effort, workers)
    result = np.where(fates == kernels.GROWS, ESCAPES, np.where(fates < kernels.GROWS, BOUNDED, UNDECIDED))
    return result.astype(np.int8).reshape(shape) if shape else np.int8(result[0])


def escapes(
    alpha: Any,
    beta: Any,
    gamma: Any,
    epsilon: Any,
    damping: Any = 0.0,
    *,
    effort: int = _EFFORT,
    workers: int | None = None,
) -> Any:
    """Return whether each kick escapes for good, as bool; arguments as in `outcome`.

    Warns
    -----
    UndecidedWarning
        When some orbits could not be decided: False there means "not known to escape"; `outcome` tells which.

    Examples
    --------
    >>> escapes(1.0, [0.3, -0.7], 1.0, 2.0).tolist()
    [True, False]
    """
    fate = outcome(alpha, beta, gamma, epsilon, damping, effort=effort, workers=workers)
    unknown = int(np.count_nonzero(fate == UNDECIDED))
    if unknown:
        warnings.warn(
            f"{unknown} of {np.size(fate)} kicks could not be decided and count as not escaping; "
            "friction.outcome tells which, a larger effort may settle them",
            UndecidedWarning,
            stacklevel=2,
        )
    return fate == ESCAPES


def critical_perturbation(
    alpha: Any,
    beta: Any,
    gamma: Any = 1.0,
    damping: Any = 0.0,
    *,
    upto: Any = math.inf,
    samples: int = 32,
    effort: int = 100_000,
    workers: int | None = None,
) -> Any:
    """Return the infimum of kicks epsilon that escape; infinite where none does, NaN where it could not be decided.

    No kick up to gamma / sqrt(abs(alpha) + abs(beta)) escapes, and every kick beyond a bound known in closed form does
    (docs/friction.md).  In between ``samples`` kicks are tried upwards in geometric steps, closer together where
    neighbouring orbits differ in kind; the first escape is bisected to 1e-9, and kicks below it are tried at distances
    that shrink.  A range of escaping kicks that lies lower and between two kicks tried is missed.

    Parameters
    ----------
    alpha, beta, gamma, damping : array_like
        Broadcast against each other; the result is proportional to gamma.
    upto : array_like
        Kicks beyond it are not looked at: the result is infinite where none up to it escapes.  Quicker, and decided
        where only large kicks cannot be.
    samples : int
        Kicks tried.
    effort, workers : int
        As in `outcome`.

    Examples
    --------
    >>> round(float(critical_perturbation(0.0, 0.25)), 9)
    2.0
    """
    limited = np.asarray(upto, dtype=np.float64)
    if not (limited > 0.0).all():
        raise ValueError(f"upto must be greater than zero, got {upto!r}; leave it out to look at every kick")
    largest = np.finfo(np.float64).max
    shape, alpha, beta, gamma, limit, c = _arguments(alpha, beta, gamma, np.minimum(limited, largest), damping)
    samples = _validate.integer("samples", samples, 1)
    effort = _validate.integer("effort", effort, 1)
    rate = _rates(alpha, beta, c, workers)
    out = np.empty(alpha.size)
    counts = np.full(alpha.size, samples, dtype=np.int64), np.full(alpha.size, effort, dtype=np.int64)
    with np.errstate(over="ignore"):
        limit = np.where(gamma > 0.0, limit / np.where(gamma > 0.0, gamma, 1.0), np.inf)
    inputs = (alpha, beta, c, rate, *counts, limit)
    over_chunks(kernels.critical_fill, inputs, out, workers=workers, chunk=64, interpret_up_to=0)
    out = np.where(gamma > 0.0, gamma * out, np.where(rate < 0.0, math.inf, 0.0))
    return out.reshape(shape) if shape else float(out[0])


class KickRange(NamedTuple):
    """Kicks between ``low`` and ``high``."""

    low: float
    high: float


@dataclass(frozen=True, repr=False)
class EscapeRanges:
    """All ranges of kicks that escape, as finely as kicks were tried.

    Attributes
    ----------
    equation : FrictionalMathieu
    intervals : tuple of KickRange
        Ranges of kicks that escape, increasing; the last is unbounded.
    bounded_up_to, escapes_above : float
        Proved: no kick up to the one escapes, every kick above the other does.
    step : float
        Ratio of neighbouring kicks tried less one: ranges and gaps narrower than this may be missed.
    undecided : int
        Kicks tried whose fate could not be told; they count as not escaping.
    """

    equation: FrictionalMathieu
    intervals: tuple[KickRange, ...]
    bounded_up_to: float
    escapes_above: float
    step: float
    undecided: int

    def __contains__(self, epsilon: float) -> bool:
        """Return whether a kick of size ``epsilon`` lies in one of the ranges."""
        return any(r.low < abs(epsilon) < r.high for r in self.intervals)

    def __repr__(self) -> str:
        """Return the ranges as a sentence."""
        shown = [f"({r.low:.6g}, {r.high:.6g})" for r in self.intervals[:6]]
        more = f" and {len(self.intervals) - 6} more" if len(self.intervals) > 6 else ""
        what = f"escapes for kicks in {', '.join(shown)}{more}" if shown else "no kick escapes"
        unknown = f"; {self.undecided} kicks undecided" if self.undecided else ""
        return f"<{what}; tried in steps of {100.0 * self.step:.2g} %{unknown}>"


def escape_ranges(
    equation: FrictionalMathieu, *, samples: int = 2000, effort: int = _EFFORT, workers: int | None = None
) -> EscapeRanges:
    """Return all ranges of kicks that escape: the outcome need not be monotone in the kick.

    ``samples`` kicks in geometric progression between what provably never and what always escapes are followed, and
    every change of outcome between neighbours is bisected to 1e-10.  The edges may be fractal: more samples then show
    more and narrower ranges.

    Examples
    --------
    >>> escape_ranges(FrictionalMathieu(alpha=0.0, beta=0.25, gamma=1.0))
    <escapes for kicks in (2, inf); tried in steps of 0 %>
    """
    require(equation, (FrictionalMathieu,), "escape_ranges")
    samples = _validate.integer("samples", samples, 2)
    e = equation
    low, high = certain_kicks(e)
    if not high < math.inf:
        return EscapeRanges(e, (), low, high, 0.0, 0)
    if high <= low * (1.0 + 1e-10):
        return EscapeRanges(e, (KickRange(high, math.inf),), low, high, 0.0, 0)

    def fates(kicks: NDArray[np.float64]) -> NDArray[np.int8]:
        result = outcome(e.alpha, e.beta, e.gamma, kicks, e.damping, effort=effort, workers=workers)
        return np.asarray(result, dtype=np.int8)

    kicks = low * (high / low) ** np.linspace(0.0, 1.0, samples)
    kicks[-1] = high * (1.0 + 1e-10)
    found = fates(kicks)
    escaped = found == ESCAPES
    change = np.flatnonzero(escaped[1:] != escaped[:-1])
    below, above = kicks[change], kicks[change + 1]
    while (above - below > 1e-10 * above).any():
        middle = 0.5 * (below + above)
        same = (fates(middle) == ESCAPES) == escaped[change]
        below, above = np.where(same, middle, below), np.where(same, above, middle)
    edges = [*map(float, above), math.inf]
    intervals = tuple(KickRange(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True))
    return EscapeRanges(e, intervals, low, high, (high / low) ** (1.0 / samples) - 1.0, int((found == UNDECIDED).sum()))


def certain_kicks(equation: FrictionalMathieu) -> KickRange:
    """Return the kick up to which none escapes, and that above which every one does: both proved.

    The second is infinite where nothing grows without friction.  docs/friction.md derives them.

    Examples
    --------
    >>> certain_kicks(FrictionalMathieu(alpha=0.0, beta=0.25, gamma=1.0)).low
    2.0
    """
    require(equation, (FrictionalMathieu,), "certain_kicks")
    alpha, beta, c = equation.alpha, equation.beta, equation.damping
    largest = abs(alpha) + abs(beta)
    rate = float(_rates(np.array([alpha]), np.array([beta]), np.array([c]), 1)[0])
    if rate < 0.0:
        return KickRange(math.inf, math.inf)
    if largest == 0.0:
        return KickRange(math.inf, math.inf) if equation.gamma > 0.0 else KickRange(0.0, 0.0)
    table, _ = _table(equation, rate)
    first = abs(float(table[0, 10]))
    high = equation.gamma / first if first > 0.0 else math.inf
    return KickRange(equation.gamma / math.sqrt(largest), high)


@dataclass(frozen=True, repr=False)
class Fate:
    """What becomes of one kick.

    Attributes
    ----------
    equation, epsilon : FrictionalMathieu, float
        What was asked.
    status : {"bounded", "escapes", "undecided"}
    reason : str
        How it is known.
    tau : float
        Time at which it was known.
    reversals, sticks : int
        How often the motion had come to a stop by then, and how often it had stuck.
    """

    equation: FrictionalMathieu
    epsilon: float
    status: Literal["bounded", "escapes", "undecided"]
    reason: str
    tau: float
    reversals: int
    sticks: int

    def __repr__(self) -> str:
        """Return the fate as a sentence."""
        when = f" after {self.tau / (2.0 * math.pi):.3g} periods and {self.reversals} stops" if self.tau > 0.0 else ""
        return f"<{self.status}: {self.reason}; known{when or ' at once'}>"


_REASONS: dict[int, tuple[Literal["bounded", "escapes", "undecided"], str]] = {
    kernels.NO_GROWTH: ("bounded", "nothing grows without friction"),
    kernels.STUCK: ("bounded", "sticks for ever"),
    kernels.CREEPS: ("bounded", "creeps inwards, a little every period"),
    kernels.TRAPPED: ("bounded", "sticks and slips within bounds, as far as sampling shows"),
    kernels.GROWS: ("escapes", "the growing Floquet solution has outgrown friction"),
    kernels.LIMIT: ("undecided", "not decided within the effort allowed"),
}


def fate(equation: FrictionalMathieu, epsilon: float, *, effort: int = _EFFORT) -> Fate:
    """Return what becomes of one kick A(0) = 0, A'(0) = epsilon, and how that is known.

    Examples
    --------
    >>> fate(FrictionalMathieu(alpha=1.0, beta=0.3, gamma=1.0), 2.0).status
    'escapes'
    """
    require(equation, (FrictionalMathieu,), "fate")
    epsilon = _validate.finite("epsilon", epsilon)
    effort = _validate.integer("effort", effort, 1)
    e = equation
    rate = float(_rates(np.array([e.alpha]), np.array([e.beta]), np.array([e.damping]), 1)[0])
    start = np.zeros(7)
    code = _code(e, abs(epsilon), rate, effort, start)
    status, reason = _REASONS[code]
    return Fate(e, epsilon, status, reason, float(start[2] + 2.0 * math.pi * start[6]), int(start[4]), int(start[5]))


def _code(e: FrictionalMathieu, kick: float, rate: float, effort: int, start: NDArray[np.float64]) -> int:
    """Return why the run of one kick ended, as the kernels number it."""
    if rate < 0.0:
        return kernels.NO_GROWTH
    if e.gamma == 0.0:
        return kernels.GROWS if kick > 0.0 else kernels.STUCK
    return _one(e, rate, kick / e.gamma, effort, start)


def _one(e: FrictionalMathieu, rate: float, kick: float, effort: int, start: NDArray[np.float64]) -> int:
    """Return the fate of one kick: interpreted where that is soon known, else compiled."""
    table, work = _table(e, rate)
    if kick * kick * (abs(e.alpha) + abs(e.beta)) > 1.0:
        start[1] = kick
        none = np.empty((0, 4))
        code = int(kernels.run(e.alpha, e.beta, e.damping, table, start, min(effort, _SHORT), effort, True, none, work))
        if code < kernels.LIMIT:
            return code
    judge = compiled(kernels.judge) if effort > _SHORT else kernels.judge
    return int(judge(e.alpha, e.beta, e.damping, table, kick, effort, True, start, work))


@dataclass(frozen=True, repr=False)
class Trajectory:
    """A motion from A(0) = 0, A'(0) = epsilon.

    Attributes
    ----------
    equation, epsilon : FrictionalMathieu, float
    tau, A, velocity : ndarray
        Times, A and A', at equal steps and at every stop and release.
    state : ndarray of int8
        1 or -1, the sign of A', where it moves (at a stop: into which it moves off); 0 where it sticks.
    """

    equation: FrictionalMathieu
    epsilon: float
    tau: NDArray[np.float64]
    A: NDArray[np.float64]
    velocity: NDArray[np.float64]
    state: NDArray[np.int8]

    def __repr__(self) -> str:
        """Return what was followed."""
        end = f"A = {self.A[-1]:.6g}, A' = {self.velocity[-1]:.6g}"
        return f"<motion from A' = {self.epsilon:g} over {self.tau[-1] / (2.0 * math.pi):.4g} periods, to {end}>"


def trajectory(equation: FrictionalMathieu, epsilon: float, *, periods: int = 20) -> Trajectory:
    """Return the motion from A(0) = 0, A'(0) = epsilon over whole periods, to rounding.

    Examples
    --------
    >>> motion = trajectory(FrictionalMathieu(alpha=0.0, beta=0.25, gamma=1.0), 1.9)
    >>> int(motion.state[-1]), bool(motion.A[-1] < 4.0)
    (0, True)
    """
    require(equation, (FrictionalMathieu,), "trajectory")
    epsilon = _validate.finite("epsilon", epsilon)
    periods = _validate.integer("periods", periods, 1)
    e = equation
    scale = e.gamma if e.gamma > 0.0 else abs(epsilon)
    table, work = _table(e, 0.0)
    if e.gamma == 0.0:
        table[:, 4:6] = 0.0
    start = np.zeros(7)
    start[1] = abs(epsilon) / scale if scale > 0.0 else 0.0
    most = periods * (2 * len(table) + 40)
    record = np.empty((most + 16, 4))
    run = fastest(kernels.run, most // 1000)
    with np.errstate(over="ignore", invalid="ignore"):
        run(e.alpha, e.beta, e.damping, table, start, most, periods, False, record, work)
    rows = record[: int(np.argmax(np.isinf(record[:, 0])))]
    rows[:, 1:3] *= math.copysign(scale, epsilon)
    rows[:, 3] *= math.copysign(1.0, epsilon)
    end = 2.0 * math.pi * periods
    rows = rows[rows[:, 0] <= end * (1.0 + 1e-12)]  # a stick may last beyond
    if rows[-1, 0] < end and rows[-1, 3] == 0.0:
        rows = np.vstack([rows, [end, rows[-1, 1], 0.0, 0.0]])
    tau, a, v, state = (np.ascontiguousarray(column) for column in rows.T)
    return Trajectory(e, epsilon, tau, a, v, state.astype(np.int8))


def _table(equation: FrictionalMathieu, rate: float) -> tuple[NDArray[np.float64], Any]:
    """Return the cells of a period and the workspace that goes with them."""
    e = equation
    count = kernels.cell_count(e.alpha, e.beta, e.damping)
    table, work = np.empty((count, kernels.COLUMNS)), kernels.workspace()
    fastest(kernels.prepare, count // 4)(e.alpha, e.beta, e.damping, rate, table, work)
    return table, work


def leapfrog_escapes(
    alpha: Any,
    beta: Any,
    gamma: Any,
    epsilon: Any,
    damping: Any = 0.0,
    *,
    periods: int = 100,
    step: float = 5e-4,
    limit: float = 1e6,
) -> Any:
    """Return what the paper's test says: whether abs(A) / epsilon reaches ``limit`` after 100 periods of leapfrog.

    Kick, drift, kick; friction is an impulse that stops a motion without turning it, so that it sticks.  Motions that
    grow more slowly than ln(limit) over the time followed pass for stable.  gamma must be positive; other arguments
    as in `outcome`.

    Examples
    --------
    >>> leapfrog_escapes(1.0, 0.3, 1.0, [0.5, 2.0], step=0.01).tolist()
    [False, True]
    """
    shape, alpha, beta, gamma, kick, c = _arguments(alpha, beta, gamma, epsilon, damping)
    if not (gamma > 0.0).all():
        raise ValueError("gamma must be greater than zero here; without friction use method='leapfrog' of stability")
    periods = _validate.integer("periods", periods, 1)
    count = math.ceil(2.0 * math.pi / _validate.positive("step", step))
    limit = _validate.positive("limit", limit)
    sine = np.sin(2.0 * math.pi * np.arange(count) / count)
    out = np.empty(alpha.size, dtype=np.bool_)

    run = fastest(frictional_leapfrog_fill, alpha.size * periods * count // 1000)
    run(alpha, beta, c, kick / gamma, sine, periods, limit, out)
    return out.reshape(shape) if shape else bool(out[0])


def _fates(
    alpha: NDArray[np.float64],
    beta: NDArray[np.float64],
    gamma: NDArray[np.float64],
    kick: NDArray[np.float64],
    damping: NDArray[np.float64],
    effort: int,
    workers: int | None,
) -> NDArray[np.int8]:
    """Return why each run ended, as the kernels number it."""
    effort = _validate.integer("effort", effort, 1)
    rate = _rates(alpha, beta, damping, workers)
    out = np.empty(kick.size, dtype=np.int8)
    if kick.size == 1:
        one = FrictionalMathieu(float(alpha[0]), float(beta[0]), float(gamma[0]), float(damping[0]))
        out[0] = _code(one, float(kick[0]), float(rate[0]), effort, np.zeros(7))
        return out
    free = gamma == 0.0
    with np.errstate(over="ignore"):
        scaled = kick / np.where(free, 1.0, gamma)
    runs = np.where(free, -1.0, rate)
    limit = np.full(kick.size, effort, dtype=np.int64)
    inputs = (alpha, beta, damping, runs, scaled, limit)
    over_chunks(kernels.outcome_fill, inputs, out, workers=workers, chunk=64, interpret_up_to=0)
    out[free & (rate >= 0.0) & (kick > 0.0)] = kernels.GROWS
    return out


def _rates(
    alpha: NDArray[np.float64], beta: NDArray[np.float64], damping: NDArray[np.float64], workers: int | None
) -> NDArray[np.float64]:
    """Return growth rates without friction, -1 where nothing grows."""
    # Without damping by counting, which also sees growth that is linear or too slow for a double.
    damped = damping > 0.0
    stable = np.empty(alpha.size, dtype=np.bool_)
    stable[~damped] = mathieu.is_stable(alpha[~damped], beta[~damped], workers=workers)
    stable[damped] = mathieu.is_stable(alpha[damped], beta[damped], damping[damped], workers=workers)
    return np.where(stable, -1.0, mathieu.growth_rate(alpha, beta, damping, workers=workers))


def _arguments(alpha: Any, beta: Any, gamma: Any, epsilon: Any, damping: Any) -> tuple[Any, ...]:
    """Return the common shape and the flat arrays of arguments that broadcast; kicks by their size."""
    largest = np.finfo(np.float64).max
    arrays = (
        _validate.array("alpha", alpha),
        _validate.array("beta", beta),
        _validate.array("gamma", gamma, least=0.0, largest=largest),
        np.abs(_validate.array("epsilon", epsilon, least=-largest, largest=largest)),
        _validate.array("damping", damping, least=0.0, largest=_validate.LARGEST**0.5),
    )
    try:
        shape, flat = broadcast(*arrays)
    except ValueError:
        shapes = ", ".join(str(array.shape) for array in arrays)
        raise ValueError(
            f"alpha, beta, gamma, epsilon and damping must broadcast to one shape, got shapes {shapes}"
        ) from None
    return (shape, *flat)
