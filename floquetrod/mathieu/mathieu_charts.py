"""Stability charts over the plane of two parameters of an equation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from floquetrod import equations
from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod._util.progress import Progress
from floquetrod.equations import Equation, Mathieu, TwoFrequencies
from floquetrod.mathieu.array_functions import growth_rate, is_stable
from floquetrod.mathieu.paper_criterion import FiniteTimeCriterion
from floquetrod.mathieu.tongue_bands import tongue_bands
from floquetrod.mathieu.tongue_curves import Window
from floquetrod.mathieu.tongue_regions import UndampedEquations
from floquetrod.plane import Axis, Chart, Family, FoundBands, Verdicts, axis_values, charted
from floquetrod.systems.family_charts import Members

_NEGLIGIBLE = 1e-9  # growth per unit tau, tenfold in 4e8 periods, up to which a tongue is left out


def chart(
    alpha: Any,
    beta: Any,
    damping: float = 0.0,
    *,
    equation: Callable[[float, float, float], Equation | TwoFrequencies] = Mathieu,
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
    equation : callable (alpha, beta, damping) -> Equation or TwoFrequencies
        The family charted: `Mathieu`, `Meissner`, or any function that returns an equation, such as
        ``lambda a, b, c: Hill(b, sines=(a, 0.3 * a), damping=c)``.  Mathieu's is a thousand times faster than others,
        which `floquetrod.stability` classifies one by one.
    growth : bool
        Whether to compute growth rates too, which costs about fifty times a verdict of Mathieu's equation.
    growth_tolerance : float
        Growth per unit tau up to which a point counts as stable; with two frequencies greater than 0.
    criterion : FiniteTimeCriterion, optional
        The paper's test in place of stability for all time; Mathieu's equation only.
    workers : int, optional
        Threads; by default one for each core when there is enough to do.
    progress : callable, optional
        Called with the numbers of points done and to do.

    Returns
    -------
    Chart
        ``stable`` at every point, rows over beta.

    Raises
    ------
    TypeError, ValueError
        For axes that do not increase, numbers out of these ranges, a function that returns no equation, and a
        criterion for other equations than Mathieu's.

    Examples
    --------
    >>> chart((0.0, 2.0, 5), (-1.0, 0.0, 3)).stable.sum().item()
    3
    """
    x = Axis("alpha", r"\alpha", "", axis_values("alpha", alpha))
    y = Axis("beta", r"\beta", "", axis_values("beta", beta))
    c = validate.within("damping", damping, 0.0, validate.LARGEST_DAMPING, "give one number for the whole chart")
    tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
    growth, workers = validate.flag("growth", growth), validate.workers(workers)
    validate.progress(progress)
    example = validate.function("equation", equation)(0.0, 0.0, 0.0)
    if not isinstance(example, TwoFrequencies):
        equations.require(example)
    if criterion is not None:
        validate.instance("criterion", criterion, FiniteTimeCriterion)
        criterion.require_alone(growth_tolerance=tolerance)
        equations.require(example, (Mathieu,), by="FiniteTimeCriterion")
    family: Family = MathieuPlane(c, tolerance, criterion, workers, equation)
    if equation is not Mathieu and criterion is None:
        fixed = (_fixed(c),)
        family = Members(_Damped(equation, c), ("alpha", "beta"), example, tolerance, workers, fixed, "equation")
    return charted(family, x, y, growth=growth, progress=progress)


def _fixed(damping: float) -> tuple[str, float, str]:
    return "damping", damping, "per unit of tau"


@dataclass(frozen=True)
class _Damped:
    """A family of equations with one damping."""

    equation: Callable[[float, float, float], Equation | TwoFrequencies]
    damping: float

    def __call__(self, alpha: float, beta: float) -> Equation | TwoFrequencies:
        return self.equation(alpha, beta, self.damping)


@dataclass(frozen=True)
class MathieuPlane(Family):
    """Mathieu's equation over alpha (x) and beta (y), with exact bands; or over what a function makes of them.

    For a test in finite time bands are traced.
    """

    damping: float
    growth_tolerance: float
    test: FiniteTimeCriterion | None
    workers: int | None
    equation: Callable[[float, float, float], Any] = Mathieu
    growth_unit: str = "per tau"

    @property
    def prompt(self) -> bool:
        """Whether there are exact bands."""
        return self.test is None

    @property
    def criterion(self) -> str:
        """What passes the test."""
        return "" if self.test is None else str(self.test)

    def subject(self) -> dict[str, Any]:
        """Return the equation's name and its damping."""
        return {"kind": Mathieu(0.0, 0.0).title, "fixed": [list(_fixed(self.damping))]}

    def verdicts(self, x: Floats, y: Floats, *, growth: bool = False, quick: bool = False) -> Verdicts:
        """Return verdicts; growth, where it need not be known, is not."""
        place = self._coefficients(x, y)
        rate = growth_rate(*place, workers=self.workers) if growth or self.growth_tolerance else np.nan
        if self.growth_tolerance:
            return Verdicts(rate <= self.growth_tolerance, rate)
        stable = is_stable if self.test is None else self.test.is_stable
        return Verdicts(stable(*place, workers=self.workers), rate)

    def _coefficients(self, x: Floats, y: Floats) -> tuple[Any, Any, Any]:
        """Return alpha, beta and damping at places."""
        if self.equation is Mathieu:
            return x, y, self.damping
        members = [self.equation(a, b, self.damping) for a, b in np.broadcast(x, y)]
        names = ("alpha", "beta", "damping")
        shape = np.broadcast_shapes(x.shape, y.shape)
        alpha, beta, damping = (np.reshape([getattr(each, name) for each in members], shape) for name in names)
        return alpha, beta, damping

    def growth(self, x: Floats, y: Floats) -> Floats:
        """Return growth rates, which tell nothing about a test in finite time."""
        return super().growth(x, y) if self.test is None else np.full(x.shape, np.nan)

    def exact_bands(self, x: Axis, y: Axis, accuracy: float, progress: Progress | None) -> FoundBands | None:
        """Return the bands of every tongue."""
        if self.test is not None:
            return None
        oscillators = UndampedEquations(
            np.array([-(self.damping**2)]), np.ones(1), self.damping, self.growth_tolerance, _NEGLIGIBLE
        )
        (first, last), (low, high) = x.values.tolist(), y.values.tolist()
        window = Window("mean", "amplitude", 1.0, low, high, (first, last))
        return tongue_bands(oscillators, window, "amplitude", accuracy, progress, modes=None)
