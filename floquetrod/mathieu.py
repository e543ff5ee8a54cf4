"""Mathieu's equation A'' + 2 c A' = (beta + alpha sin tau) A over arrays, and its transition curves.

The functions broadcast like numpy ufuncs, use all cores on large input and release the GIL.  Accuracy and method are
those of the spectral method: exact counts for verdicts, Hill's determinants for everything else.
"""

from __future__ import annotations

import functools
import importlib
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod import _validate, equations
from floquetrod._arrays import broadcast, shaped
from floquetrod._compile import over_chunks
from floquetrod._version import __version__
from floquetrod.characteristic import TransitionCurves, characteristic_values, transition_curves
from floquetrod.chart import Axis, Chart, Progress, axis_values, fill_rows
from floquetrod.criterion import PaperCriterion
from floquetrod.equations import Equation, Mathieu, SquareWave
from floquetrod.kernels import mathieu as kernels
from floquetrod.verdict import stability

_PATIENCE = 100
"""Times as many points as are always interpreted before growth is compiled, which takes seconds (heuristic)."""

__all__ = [
    "TransitionCurves",
    "characteristic_values",
    "chart",
    "discriminant",
    "growth_rate",
    "is_stable",
    "multipliers",
    "transition_curves",
]


def is_stable(alpha: Any, beta: Any, damping: Any = 0.0, *, workers: int | None = None) -> Any:
    """Return whether every solution stays bounded.

    Parameters
    ----------
    alpha, beta : array_like of float
        Amplitude and mean of the coefficient; magnitudes up to 1e9.
    damping : array_like of float
        c >= 0, the decay rate per unit tau of the free motion.
    workers : int, optional
        Threads; by default one for each core when there is enough to do.

    Returns
    -------
    bool or ndarray of bool
        In the broadcast shape; a Python bool for numbers alone.  A point on a transition curve to rounding may fall
        either way: `floquetrod.stability` says so, `floquetrod.certify` proves the side.

    Examples
    --------
    >>> is_stable(0.5, [-0.3, -0.6])
    array([False,  True])
    """
    if type(alpha) is type(beta) is type(damping) is float and damping == 0.0:  # the quick way for a single verdict
        _validate.workers(workers)
        return kernels.is_stable_scalar(_validate.coefficient("alpha", alpha), _validate.coefficient("beta", beta))
    arrays = _arrays(alpha, beta, damping)
    undamped = not arrays["damping"].any()
    if undamped and not arrays["damping"].shape:
        del arrays["damping"]
    shape, arguments = broadcast(**arrays)
    if undamped:
        arguments = arguments[:2]
    out = np.empty(arguments[0].size, dtype=np.bool_)
    few = out.size < 64  # blocks pay from a few of them on
    fill = kernels.damped_stable_fill if not undamped else kernels.stable_one_by_one if few else kernels.stable_fill
    over_chunks(fill, arguments, out, workers=workers, patience=0 if undamped else _PATIENCE)
    return shaped(out, shape)


def growth_rate(alpha: Any, beta: Any, damping: Any = 0.0, *, workers: int | None = None) -> Any:
    """Return the growth rate of the fastest solution, per unit tau; 0 where stable.

    Arguments as in `is_stable`.  Relative accuracy 1e-8 or better where the undamped rate exceeds 1e-9.

    Examples
    --------
    >>> growth_rate(1e-8, -0.25)
    4.999999999999999e-09
    """
    shape, (a, b, c) = broadcast(**_arrays(alpha, beta, damping))
    out = np.empty(a.size)
    over_chunks(kernels.growth_fill, (a, b, c), out, workers=workers, patience=_PATIENCE)
    return shaped(out, shape)


def discriminant(alpha: Any, beta: Any, damping: Any = 0.0, *, workers: int | None = None) -> Any:
    """Return the trace of the monodromy matrix, +-inf beyond the range of a double.

    Arguments as in `is_stable`.  Without damping the equation is stable where its magnitude is below 2.

    Examples
    --------
    >>> round(discriminant(0.0, -1.0 / 16.0), 12) + 0.0
    0.0
    """
    shape, (a, b, c) = broadcast(**_arrays(alpha, beta, damping))
    out = np.empty(a.size)
    over_chunks(kernels.discriminant_fill, (a, b, c), out, workers=workers)
    return shaped(out, shape)


def multipliers(alpha: Any, beta: Any, damping: Any = 0.0, *, workers: int | None = None) -> Any:
    """Return both Floquet multipliers, the larger first, in a last axis of length 2 (complex).

    Arguments as in `is_stable`.  Their product is exp(-4 pi c); the small one keeps its digits beside a huge one.

    Examples
    --------
    >>> multipliers(0.0, [-0.25, 0.0]).shape
    (2, 2)
    """
    shape, (a, b, c) = broadcast(**_arrays(alpha, beta, damping))
    out = np.empty((a.size, 2), dtype=np.complex128)
    over_chunks(kernels.multipliers_fill, (a, b, c), out, workers=workers)
    return out.reshape((*shape, 2))


def chart(
    alpha: Any,
    beta: Any,
    damping: float = 0.0,
    *,
    equation: Callable[[float, float, float], Equation] = Mathieu,
    growth: bool = False,
    growth_tolerance: float = 0.0,
    criterion: PaperCriterion | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Chart:
    """Return the stability chart (Ince-Strutt diagram) over a rectangle of the (alpha, beta) plane.

    Parameters
    ----------
    alpha, beta : tuple (low, high, number) or increasing array
        Columns and rows.
    damping : float
        c, one value for the whole chart.
    equation : callable (alpha, beta, damping) -> Equation
        The family charted: `Mathieu`, `SquareWave`, or any function that returns an equation, such as
        ``lambda a, b, c: Hill(b, sines=(a, 0.3 * a), damping=c)``.  Mathieu's is a thousand times faster than others,
        which `floquetrod.stability` judges one by one.
    growth : bool
        Whether to compute growth rates too, which costs about fifty times a verdict of Mathieu's equation.
    growth_tolerance : float
        Growth per unit tau up to which a point counts as stable.
    criterion : PaperCriterion, optional
        The paper's test in place of stability for ever; Mathieu's equation only.
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
    c = _validate.within("damping", damping, 0.0, _validate.LARGEST**0.5, "give one number for the whole chart")
    tolerance = _validate.tolerance("growth_tolerance", growth_tolerance)
    growth = _validate.flag("growth", growth)
    workers = _validate.workers(workers)
    _validate.progress(progress)
    kind = _name(_validate.function("equation", equation)(0.0, 0.0, 0.0))
    if criterion is not None:
        _validate.instance("criterion", criterion, PaperCriterion)
        criterion.require_alone(growth_tolerance=tolerance)
        equations.require(equation(0.0, 0.0, 0.0), (Mathieu,), by="PaperCriterion")
    judge = _judge_mathieu if equation is Mathieu else functools.partial(_judge_each, equation)

    def rows(values: NDArray[np.float64]) -> tuple[NDArray[Any], ...]:
        status, rate = judge(x.values, values, c, tolerance, growth, workers)
        if criterion is not None:
            status = criterion.is_stable(x.values, values, c, workers=workers).astype(np.int8)
        return status, rate

    status, rate = fill_rows(rows, y.values, x.values.size, (np.int8, np.float64), progress)
    subject = {"kind": kind, "fixed": [["damping", c, "per unit of tau"]]}
    return Chart(
        x,
        y,
        status == 1,
        rate if growth else None,
        None,
        "per tau",
        subject,
        tolerance,
        "" if criterion is None else str(criterion),
        int((status < 0).sum()),
        __version__,
    )


def _judge_mathieu(
    alpha: NDArray[np.float64], beta: NDArray[np.float64], c: float, tolerance: float, growth: bool, workers: int | None
) -> tuple[Any, Any]:
    """Return 1 where stable and 0 where not, and the growth rate where it was needed."""
    rate = growth_rate(alpha, beta, c, workers=workers) if growth or tolerance > 0.0 else np.zeros(())
    return (rate <= tolerance if tolerance > 0.0 else is_stable(alpha, beta, c, workers=workers)), rate


def _judge_each(
    equation: Callable[[float, float, float], Equation],
    alpha: NDArray[np.float64],
    beta: NDArray[np.float64],
    c: float,
    tolerance: float,
    *_: Any,
) -> tuple[NDArray[np.int8], NDArray[np.float64]]:
    """Return 1 where stable, 0 where not and -1 where undecided, and the growth rate, one equation after another."""
    importlib.import_module("numba")  # once it is loaded, scalar methods run as machine code
    status = np.empty((beta.size, alpha.size), dtype=np.int8)
    rate = np.empty(status.shape)
    for row, y in enumerate(beta.ravel().tolist()):
        for column, x in enumerate(alpha.tolist()):
            result = stability(equation(x, y, c))
            rate[row, column] = result.growth_rate
            small = 0.0 < result.growth_rate <= tolerance
            status[row, column] = -1 if result.status == "undecided" else result.status == "stable" or small
    return status, rate


def _name(equation: Equation) -> str:
    equations.require(equation)
    names = {Mathieu: "Mathieu's equation", SquareWave: "Meissner's equation (square wave)"}
    return names.get(type(equation), "Hill's equation")


def _arrays(alpha: Any, beta: Any, damping: Any) -> dict[str, NDArray[np.float64]]:
    return {
        "alpha": _validate.array("alpha", alpha),
        "beta": _validate.array("beta", beta),
        "damping": _validate.array("damping", damping, least=0.0, largest=_validate.LARGEST**0.5),
    }
