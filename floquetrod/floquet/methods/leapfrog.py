"""The paper's test: integrate 100 periods by leapfrog and look whether the motion has grown a million times."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from floquetrod import equations
from floquetrod._util import validate
from floquetrod._util.arrays import EPS, Floats
from floquetrod._util.compilation import runner
from floquetrod.equations import Equation, Piece
from floquetrod.equations.base import value_on
from floquetrod.floquet.kernels.leapfrog_map import leapfrog_map_fill
from floquetrod.floquet.kernels.powers import displacement_fill
from floquetrod.floquet.verdict import Cost, Stability, Status, classify, discriminant_excess_of

_MOST_STEPS = 100_000_000  # steps of a run, a choice: a fraction of a second to a second
_FINEST_GRID = 4096  # steps of a period that pieces may ask for so that they meet at steps (a choice)
_STEPS_A_WAVE = 16  # fewest steps to a wave of the highest harmonic, a multiple of four (heuristic)
_INTERPRETED_STEPS = 1000  # left to the interpreter: two milliseconds (measured)
_COMPILE_AFTER = 200  # times as many before anything is compiled: half a second, as long as numba takes to load
_LARGEST_REACH = 1e50  # step^2 times coefficient: what one step multiplies by, beyond any useful step, yet in range


def leapfrog(equation: Equation, *, step: float = 5e-4, periods: int = 100, limit: float = 1e6) -> Stability:
    """Classify by the paper's test (6): stable when abs(A(end)) / A'(0) stays below a limit.

    A(0) = 0, A'(0) = 1; kick-drift-kick leapfrog (second order, symplectic); DOI 10.1115/1.4031710, section 3.2.

    Parameters
    ----------
    equation : Equation
        Damping is integrated directly, split symmetrically about the kicks.
    step : float
        Largest step in tau; the period is divided into a multiple of four steps no longer than this, 16 or more for
        each wave of the coefficient's highest harmonic.
    periods : int
        Periods integrated.
    limit : float
        Growth that counts as instability.

    Returns
    -------
    Stability
        ``status`` is the outcome of the test; ``growth_rate`` the mean rate over the run; ``discriminant`` belongs to
        the scheme's own map over a period, ``error`` its estimate from steps twice and four times as long. "undecided"
        when the run would take too many steps.

    Raises
    ------
    TypeError, ValueError
        For anything but an equation, a step or limit that is not positive, a limit up to 1, and fewer periods than
        1.

    Notes
    -----
    Growth slower than about ln(limit) / (periods period), 0.022 per unit tau by default, cannot be seen.  "About": the
    motion ends at K exp(growth time), and K is small where the growing mode passes through zero at the end (near
    beta = -0.25 the threshold is 0.026), large where the motion is slow (near beta = 0 = alpha it is below 0.020).
    """
    equations.require(equation)
    step = validate.positive("step", step)
    periods = validate.integer("periods", periods, 1)
    limit = validate.positive("limit", limit)
    if limit <= 1.0:
        raise ValueError(f"limit must be greater than 1, got {limit!r}: a bounded motion already reaches 1")
    pieces = equation.pieces()
    harmonics = max(1, *(len(piece.harmonics) for piece in pieces))
    least = _STEPS_A_WAVE * harmonics
    needed = max(least, equation.period / step) * periods
    if needed > _MOST_STEPS:
        note = (
            f"would take {needed:.3g} steps, above the limit of {_MOST_STEPS:.0e}; take a longer step or fewer periods"
        )
        return Stability.declined(equation, "leapfrog", Cost(0, "steps"), note)
    # With every other and every fourth step too, the coefficient jumps at steps, if its pieces allow.
    grid = math.lcm(4, *(4 * piece.share.denominator for piece in pieces))
    grid = grid if grid <= _FINEST_GRID else 4
    count = grid * math.ceil(max(least, equation.period / step) / grid)
    table = _table(equation, pieces, count)
    step = equation.period / count
    reach = step * step * np.abs(table).max()
    if not reach < _LARGEST_REACH:
        raise ValueError(
            f"step = {step:g} is too long: step^2 times the coefficient is {reach:.3g}; take a shorter step"
        )
    maps = np.array([_map(table[::stride], equation) for stride in (1, 2, 4)])
    reached = np.empty(1)
    displacement_fill(maps[:1].tolist(), reached, periods)
    log_growth = math.log(10.0) * float(reached[0])
    time = periods * equation.period
    traces = [(float(one[0] + one[3]), float(one[4])) for one in maps]
    trace, shift = traces[0]
    fine, double, fourfold = (value * math.exp(max(-700.0, min(700.0, lift - shift))) for value, lift in traces)
    # Second order: the fine map is off by a third of its difference from that of double steps, a quarter of what comes
    # next; more where steps are long or the coefficient jumps between them, or where two maps meet by chance.  To that
    # comes what all maps hide where the motion lags far behind, and a rounding at every step.
    change = max(abs(double - fine), 0.25 * abs(fourfold - double))
    size = max(math.exp(-min(700.0, shift)), abs(trace))
    error = change / size + _lag(table, step, equation) ** 2 + count * EPS
    sign, excess, exponent = _excess(trace, shift + equation.damping * equation.period)
    status: Status = "stable" if log_growth < math.log(limit) else "unstable"
    note = f"cannot see growth below about {math.log(limit) / time:.2g} per unit {equation.time}"
    if step * step * table.min() < -4.0:  # the scheme's own limit for an oscillator: step times frequency at most 2
        note += "; the step is too long for this coefficient: the scheme itself is unstable"
    return classify(
        equation,
        "leapfrog",
        sign=sign,
        excess=excess,
        exponent=exponent,
        excess_error=error,
        tested=(status, log_growth / time),
        cost=Cost(count * periods, "steps"),
        note=note,
    )


def _excess(trace: float, lift: float) -> tuple[int, float, int]:
    """Return sign, X and its binary exponent for the undamped discriminant trace * exp(lift)."""
    if trace == 0.0 or lift < 400.0:
        return *discriminant_excess_of(trace * math.exp(min(lift, 400.0))), 0
    power = (math.log(abs(trace)) + lift) / math.log(2.0)
    if power < 900.0:
        return *discriminant_excess_of(math.copysign(2.0**power, trace)), 0
    exponent = math.floor(power)
    return (1 if trace > 0.0 else -1), 0.25 * 2.0 ** (power - exponent), exponent


def _lag(table: Floats, step: float, equation: Equation) -> float:
    """Return by how much the scheme shifts phase or logarithm over a period, to leading order in the step.

    An oscillator of frequency w is too fast by w^3 step^2 / 24 (WKB, w^2 = |p|); strong damping c, where A decays at
    |p| / 2c, is off by c |p| step^2 / 6.
    """
    size = np.abs(table)
    return equation.period * step * step * float(np.mean(size * (np.sqrt(size) + 4.0 * equation.damping))) / 24.0


def _table(equation: Equation, pieces: tuple[Piece, ...], count: int) -> Floats:
    """Return the coefficient at equal steps over a period, where pieces meet the mean of both."""
    tau = np.arange(count) * (equation.period / count)
    if len(pieces) == 1:
        return np.asarray(equation.coefficient(tau), dtype=np.float64)
    table, end = np.zeros(count + 1), Fraction(0)
    for piece in pieces:
        begin, end = end, end + piece.share * count
        first, last = math.ceil(begin), math.floor(end)
        t = np.arange(first, last + 1, dtype=np.float64) * (equation.period / count)
        weight = np.ones(t.size)
        weight[0] -= 0.5 * (first == begin)
        weight[-1] -= 0.5 * (last == end)
        table[first : last + 1] += weight * value_on(piece, t, float(begin) * equation.period / count, equation.period)
    table[0] += table[count]
    return table[:count]


def _map(table: Floats, equation: Equation) -> Floats:
    """Return the scheme's map over a period (5,), as `leapfrog_map_fill` does."""
    out = np.empty((1, 5))
    fill = runner(leapfrog_map_fill, len(table), interpret_up_to=_INTERPRETED_STEPS, compile_after=_COMPILE_AFTER)
    one, damping = np.ones(1), np.array([equation.damping])
    inputs: Any = (one, 0.0 * one, damping, out, np.ascontiguousarray(table))
    if fill is leapfrog_map_fill:  # interpreted: plain floats are faster than numpy's
        inputs = one.tolist(), [0.0], damping.tolist(), out, table.tolist()
    fill(*inputs, equation.period)
    return np.asarray(out[0])
