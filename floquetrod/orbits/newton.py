"""Newton's method for the equations of a periodic orbit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.orbits.collocation import BorderRow, Collocation, Condensed, Point, Step

ENOUGH = 1e-10
"""Size of a step, relative, after which the next one would change rounding only."""

NEARLY = 1e-7
"""Size of a step, relative, below which one that does not shrink any more is rounding."""

_MOST_STEPS = 40
_SMALL = 2e-2  # of a step, up to which it is made whole where steps contract, whatever the residual (a choice)
_CLOSE = 1e-4  # of a step, below which matrices are kept: the next ones shrink by about as much (a choice)
_CONTRACTED = 1e-2  # of the step before, beyond which they are computed again (a choice)
_ROUNDING = 1e-14  # of a step that changes nothing
_LEAST_SHARE = 2.0**-12  # of a step, below which there is none that leads on


class NoOrbitError(ValueError):
    """Newton's method found no periodic orbit; the message gives its last point.

    Attributes
    ----------
    point : Point or None
        The last point.
    """

    point: Point | None = None


class Corrected(NamedTuple):
    """A point that satisfies the equations, the linearised equations there, and the number of steps it took."""

    point: Point
    condensed: Condensed
    steps: int


class Known(NamedTuple):
    """Rates and residual at a point, and derivatives with the parameter at all points near it; None for not known."""

    rates: Floats | None = None
    residual: Floats | None = None
    by_parameter: Floats | None = None


def corrected(
    collocation: Collocation,
    point: Point,
    rows: Sequence[BorderRow],
    most_steps: int = _MOST_STEPS,
    known: Known | None = None,
) -> Corrected:
    """Return the solution of the equations and rows near a point; `NoOrbitError` where Newton's method finds none.

    ``known`` holds the values computed before at the point.
    """
    (rates, residual, by_parameter), before, chord = known or Known(), np.inf, False
    condensed: Condensed | None = None
    scale = point.scale
    with np.errstate(all="ignore"):
        for count in range(1, most_steps + 1):
            if chord and condensed is not None and rates is not None and residual is not None:
                condensed = collocation.recondensed(condensed, point, rates, residual)
            else:
                condensed, scale = collocation.linearised(point, rates, residual, by_parameter), point.scale
            step, size = _step(collocation, condensed, rows, point, scale, count)
            if not chord and size <= _ROUNDING and stage_size(step, point, scale) <= _ROUNDING:
                return Corrected(collocation.moved(point, step), condensed, count)
            sure = NEARLY < size <= _SMALL and size < 0.5 * before
            start = point
            point, rates, residual = _followed(collocation, point, step, condensed, scale, count, sure)
            rest = size / before * size if chord else 0.0  # of the chord method, whose steps shrink by one factor
            if (size <= ENOUGH and rest <= _ROUNDING) or (size <= NEARLY and size > 0.3 * before):
                if chord or stage_size(step, start, scale) > _ROUNDING:
                    condensed = collocation.linearised(point, rates, residual, by_parameter)
                return Corrected(point, condensed, count)
            chord = size <= _CLOSE and (size < _CONTRACTED * before or not chord)
            before = size
    raise _lost(collocation, point, f"after {most_steps} steps, the last one of {before:.1g} of the states")


def step_size(step: Step, point: Point, scale: Floats) -> float:
    """Return the size of a step, as a fraction of the states and of the free scalars."""
    size = float((np.abs(step.nodes) / scale).max())
    return max(size, abs(float(step.scalars[0])) / max(point.period, 1e-300)) if len(step.scalars) == 1 else size


def stage_size(step: Step, point: Point, scale: Floats) -> float:
    """Return the size of a step, that at the Gauss points included."""
    return max(step_size(step, point, scale), float((np.abs(step.stages) / scale).max()))


def _step(
    collocation: Collocation, condensed: Condensed, rows: Sequence[BorderRow], point: Point, scale: Floats, count: int
) -> tuple[Step, float]:
    """Return the whole step and its size."""
    try:
        step = collocation.solved(condensed, rows, point, scale)
    except np.linalg.LinAlgError:
        raise _lost(collocation, point, f"in step {count}, where the equations are singular") from None
    size = step_size(step, point, scale)
    if not (math.isfinite(size) and all(map(math.isfinite, step.scalars.tolist()))):
        raise _lost(collocation, point, f"in step {count}, where the function is not finite")
    return step, size


def _followed(
    collocation: Collocation, point: Point, step: Step, condensed: Condensed, scale: Floats, count: int, sure: bool
) -> tuple[Point, Floats, Floats]:
    """Return the point after as much of a step as makes the residual smaller, after all of a ``sure`` one.

    With the rates and the residual there.  Where motion jumps, a residual of 1e-8 may mean a step of 1e-2: it says less
    than steps that contract.
    """
    share = 1.0
    while share >= _LEAST_SHARE:
        trial = collocation.moved(point, step, share)
        if trial.period > 0.0 and (sure or np.isfinite(trial.nodes).all()):
            rates = collocation.rates(trial)
            residual = collocation.residual(trial, rates)
            if sure:
                return trial, rates, residual
            missed_there = _missed(residual, scale)
            if missed_there <= 1e-11 or missed_there <= (1.0 - 0.25 * share) * _missed(condensed.residual, scale):
                return trial, rates, residual
        share *= 0.5
    raise _lost(collocation, point, f"in step {count}, which makes the residual larger however short it is")


def _missed(residual: Floats, scale: Floats) -> float:
    """Return the size of a residual, as a fraction of the states."""
    relative = residual / scale
    return math.sqrt(float(np.vdot(relative, relative)) / relative.size)


def _lost(collocation: Collocation, point: Point, how: str) -> NoOrbitError:
    """Return the error that says where Newton's method stood."""
    missed = _missed(collocation.residual(point), point.scale)
    state = ", ".join(f"{value:.6g}" for value in point.nodes[0, :6])
    error = NoOrbitError(
        f"no periodic orbit was found: Newton's method ended {how}; its last point has the period {point.period:.6g} "
        f"and the state ({state}{', ...' if point.nodes.shape[1] > 6 else ''}), with the equations missed by "
        f"{missed:.1g} of the states; start closer to an orbit"
    )
    error.point = point
    return error
