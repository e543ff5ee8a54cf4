"""Newton's method for the equations of a periodic orbit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.orbits.collocation import BorderRow, Collocation, Condensed, Point, Step

_MOST_STEPS = 40
_ENOUGH = 1e-10  # of a step, relative: what the next one would change is rounding
_NEARLY = 1e-7  # of a step, from which on one that does not shrink any more is rounding
_SMALL = 2e-2  # of a step, up to which it is made whole where steps contract, whatever the residual (a choice)
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


def corrected(
    collocation: Collocation, point: Point, rows: Sequence[BorderRow], most_steps: int = _MOST_STEPS
) -> Corrected:
    """Return the solution of the equations and rows near a point; `NoOrbitError` where Newton's method finds none."""
    before, rates = np.inf, None
    with np.errstate(all="ignore"):
        for count in range(1, most_steps + 1):
            condensed = collocation.linearised(point, rates)
            step = _step(collocation, condensed, rows, point, count)
            size = step_size(step, point)
            sure = _NEARLY < size <= _SMALL and size < 0.5 * before
            point, rates = _followed(collocation, point, step, condensed, count, sure)
            if size <= _ENOUGH or (size <= _NEARLY and size > 0.3 * before):
                return Corrected(point, collocation.linearised(point, rates), count)
            before = size
    raise _lost(collocation, point, f"after {most_steps} steps, the last one of {before:.1g} of the states")


def step_size(step: Step, point: Point) -> float:
    """Return the size of a step, as a fraction of the states and of the free scalars."""
    scalars = np.abs(step.scalars).max(initial=0.0) / max(point.period, 1e-300)
    return max(float((np.abs(step.nodes) / point.scale).max()), float(scalars) if len(step.scalars) == 1 else 0.0)


def _step(collocation: Collocation, condensed: Condensed, rows: Sequence[BorderRow], point: Point, count: int) -> Step:
    """Return the whole step."""
    try:
        step = collocation.solved(condensed, rows, point)
    except np.linalg.LinAlgError:
        raise _lost(collocation, point, f"in step {count}, where the equations are singular") from None
    if not (np.isfinite(step.nodes).all() and np.isfinite(step.scalars).all()):
        raise _lost(collocation, point, f"in step {count}, where the function is not finite")
    return step


def _followed(
    collocation: Collocation, point: Point, step: Step, condensed: Condensed, count: int, sure: bool
) -> tuple[Point, Floats]:
    """Return the point after as much of a step as makes the residual smaller, after all of a ``sure`` one, and rates.

    Where motion jumps, a residual of 1e-8 may mean a step of 1e-2: it says less than steps that contract.
    """
    missed = _missed(condensed.residual, point)
    share = 1.0
    while share >= _LEAST_SHARE:
        trial = collocation.moved(point, step, share)
        if trial.period > 0.0 and np.isfinite(trial.nodes).all():
            rates = collocation.rates(trial)
            missed_there = _missed(collocation.residual(trial, rates), point)
            if sure or missed_there <= (1.0 - 0.25 * share) * missed or missed_there <= 1e-11:
                return trial, rates
        share *= 0.5
    raise _lost(collocation, point, f"in step {count}, which makes the residual larger however short it is")


def _missed(residual: Floats, point: Point) -> float:
    """Return the size of a residual, as a fraction of the states."""
    return float(np.sqrt(np.square(residual / point.scale).mean()))


def _lost(collocation: Collocation, point: Point, how: str) -> NoOrbitError:
    """Return the error that says where Newton's method stood."""
    missed = _missed(collocation.residual(point), point)
    state = ", ".join(f"{value:.6g}" for value in point.nodes[0, :6])
    error = NoOrbitError(
        f"no periodic orbit was found: Newton's method ended {how}; its last point has the period {point.period:.6g} "
        f"and the state ({state}{', ...' if point.nodes.shape[1] > 6 else ''}), with the equations missed by "
        f"{missed:.1g} of the states; start closer to an orbit"
    )
    error.point = point
    return error
