"""Stability charts over the plane of two parameters of an equation."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod import equations
from floquetrod._util import validate
from floquetrod.equations import Equation, Mathieu
from floquetrod.floquet import one_by_one
from floquetrod.mathieu.arrays import growth_rate, is_stable
from floquetrod.mathieu.criterion import FiniteTimeCriterion
from floquetrod.mathieu.tongue_bands import ExactMathieuBands
from floquetrod.plane import Axis, Chart, Progress, axis_values, charted


def chart(
    alpha: Any,
    beta: Any,
    damping: float = 0.0,
    *,
    equation: Callable[[float, float, float], Equation] = Mathieu,
    growth: bool = False,
    growth_tolerance: float = 0.0,
    criterion: FiniteTimeCriterion | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Chart:
    """Return the stability chart (Ince-Strutt diagram) over a rectangle of the (alpha, beta) plane.

    Parameters
    ----------
    alpha : tuple (low, high, number) or increasing array
        Columns.
    beta : tuple (low, high, number) or increasing array
        Rows.
    damping : float
        c, one value for the whole chart.
    equation : callable (alpha, beta, damping) -> Equation
        The family charted: `Mathieu`, `Meissner`, or any function that returns an equation, such as
        ``lambda a, b, c: Hill(b, sines=(a, 0.3 * a), damping=c)``.  Mathieu's is a thousand times faster than others,
        which `floquetrod.stability` classifies one by one.
    growth : bool
        Whether to compute growth rates too, which costs about fifty times a verdict of Mathieu's equation.
    growth_tolerance : float
        Growth per unit tau up to which a point counts as stable.
    criterion : FiniteTimeCriterion, optional
        The paper's test in place of stability for all time; Mathieu's equation only.
    workers : int, optional
        Threads; by default one for each core when there is enough to do.
    progress : callable, optional
        Called with the numbers of points done and to do.

    Examples
    --------
    >>> chart((0.0, 2.0, 5), (-1.0, 0.0, 3)).stable.sum().item()
    3
    """
    x = Axis("alpha", r"\alpha", "", axis_values("alpha", alpha))
    y = Axis("beta", r"\beta", "", axis_values("beta", beta))
    c = validate.within("damping", damping, 0.0, validate.LARGEST_DAMPING, "give one number for the whole chart")
    tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
    growth = validate.flag("growth", growth)
    workers = validate.workers(workers)
    validate.progress(progress)
    example = validate.function("equation", equation)(0.0, 0.0, 0.0)
    equations.require(example)
    if criterion is not None:
        validate.instance("criterion", criterion, FiniteTimeCriterion)
        criterion.require_alone(growth_tolerance=tolerance)
        equations.require(example, (Mathieu,), by="FiniteTimeCriterion")
    classify = _classify_mathieu if equation is Mathieu else functools.partial(_classify_each, equation)
    judge: Any = None if equation is Mathieu else _JudgeEach(equation, c, tolerance)
    judge = judge if criterion is None else _JudgeByCriterion(criterion, c, workers)

    def rows(values: NDArray[np.float64]) -> tuple[NDArray[Any], ...]:
        status, rate = classify(x.values, values, c, tolerance, growth, workers)
        if criterion is not None:
            status = criterion.is_stable(x.values, values, c, workers=workers).astype(np.int8)
        return status, rate

    return charted(
        x,
        y,
        rows,
        growth=growth,
        growth_tolerance=tolerance,
        growth_unit="per tau",
        subject=lambda: {"kind": example.title, "fixed": [["damping", c, "per unit of tau"]]},
        criterion="" if criterion is None else str(criterion),
        rows_at_once=None if equation is Mathieu else 1,
        progress=progress,
        source=ExactMathieuBands(x.ends, y.ends, c, tolerance) if equation is Mathieu and criterion is None else None,
        judge=judge,
        prompt=criterion is None,
    )


@dataclass(frozen=True)
class _JudgeEach:
    """Verdicts on members of a family of equations at any places."""

    equation: Callable[[float, float, float], Equation]
    damping: float
    tolerance: float

    def __call__(
        self, alpha: NDArray[np.float64], beta: NDArray[np.float64]
    ) -> tuple[NDArray[np.int8], NDArray[np.float64]]:
        """Return status and growth rate."""
        members = [self.equation(x, y, self.damping) for x, y in zip(alpha.tolist(), beta.tolist(), strict=True)]
        return one_by_one.verdicts(members, self.tolerance)


@dataclass(frozen=True)
class _JudgeByCriterion:
    """Verdicts by the paper's test on Mathieu's equation at any places; growth is not known."""

    criterion: FiniteTimeCriterion
    damping: float
    workers: int | None

    def __call__(
        self, alpha: NDArray[np.float64], beta: NDArray[np.float64]
    ) -> tuple[NDArray[np.int8], NDArray[np.float64]]:
        """Return status and NaN."""
        stable = self.criterion.is_stable(alpha, beta, self.damping, workers=self.workers)
        return np.asarray(stable).astype(np.int8), np.full(alpha.size, np.nan)


def _classify_mathieu(
    alpha: NDArray[np.float64], beta: NDArray[np.float64], c: float, tolerance: float, growth: bool, workers: int | None
) -> tuple[Any, Any]:
    """Return 1 where stable and 0 where not, and the growth rate where it was needed."""
    rate = growth_rate(alpha, beta, c, workers=workers) if growth or tolerance > 0.0 else np.zeros(())
    return (rate <= tolerance if tolerance > 0.0 else is_stable(alpha, beta, c, workers=workers)), rate


def _classify_each(
    equation: Callable[[float, float, float], Equation],
    alpha: NDArray[np.float64],
    beta: NDArray[np.float64],
    c: float,
    tolerance: float,
    *_: Any,
) -> tuple[NDArray[np.int8], NDArray[np.float64]]:
    """Return 1 where stable, 0 where not and -1 where undecided, and the growth rate, one equation after another."""
    places = (part.ravel() for part in np.meshgrid(alpha, beta))
    status, rate = _JudgeEach(equation, c, tolerance)(*places)
    return status.reshape(beta.size, -1), rate.reshape(beta.size, -1)
