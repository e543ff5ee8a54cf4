"""Characteristic values and transition curves of Mathieu's equation, right for every order and q."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Floats, broadcast, shaped
from floquetrod._util.compilation import over_chunks
from floquetrod._util.content import ByContent
from floquetrod.mathieu.kernels import characteristic_bisection as kernels

_LARGEST_ALPHA = 0.5 * validate.LARGEST  # as far as q = 2 alpha may go
_CHUNK = 64  # values a thread takes at a time: each costs microseconds


def characteristic_values(order: Any, q: Any, kind: str, *, workers: int | None = None) -> Any:
    """Return a_m(q) or b_m(q) of y'' + (a - 2 q cos 2 z) y = 0.

    Parameters
    ----------
    order : array_like of int
        m: 0, 1, 2, ... for kind "a"; 1, 2, ... for kind "b".
    q : array_like of float
        Any real, magnitude at most 1e9; broadcasts with ``order``.
    kind : {"a", "b"}
        "a": solution even in z, "b": odd (DLMF 28.2(v)).  In A'' = (beta + alpha sin tau) A the curve is
        beta = -a / 4 at alpha = q / 2.
    workers : int, optional
        Threads; by default one for each core when there is enough to do.

    Returns
    -------
    float or ndarray of float
        Absolute error within a few units of rounding of max(1, abs(a), abs(q)).

    Raises
    ------
    TypeError, ValueError
        For orders that are no whole numbers or too low for the kind, for numbers out of these ranges, and for
        shapes that do not broadcast.

    Examples
    --------
    >>> round(characteristic_values(3, 15.5, "a"), 10)
    16.5475476467
    """
    odd_solution = validate.choice("kind", kind, ("a", "b")) == "b"
    hint = "real_order_values accepts others" + (", and there is no b_0" if odd_solution else "")
    orders = validate.integer_array("order", order, 1 if odd_solution else 0, hint=hint)
    shape, (m, x) = broadcast(order=orders, q=validate.array("q", q))
    out = np.empty(m.size)
    over_chunks(kernels.characteristic_fill, (m, x, np.full(m.size, odd_solution)), out, workers=workers, chunk=_CHUNK)
    return shaped(out, shape)


def tongue_widths(order: Any, q: Any, *, workers: int | None = None) -> Any:
    """Return the width abs(a_m(q) - b_m(q)) of tongue m, accurate relative to itself however thin.

    Arguments as in `characteristic_values`, orders from 1.

    Returns
    -------
    float or ndarray of float
        In the broadcast shape, in the unit of a.

    Raises
    ------
    TypeError, ValueError
        As `characteristic_values`.

    Examples
    --------
    >>> f"{tongue_widths(20, 1.0):.6e}"
    '4.916838e-46'
    """
    shape, (m, x) = broadcast(order=validate.integer_array("order", order, 1), q=validate.array("q", q))
    out = np.empty(m.size)
    over_chunks(kernels.width_fill, (m, x), out, workers=workers, chunk=_CHUNK)
    return shaped(out, shape)


@dataclass(frozen=True, eq=False, repr=False)
class TransitionCurves(ByContent):
    """Curves beta(alpha) between stability and instability of A'' = (beta + alpha sin tau) A.

    Attributes
    ----------
    alpha : ndarray (n,)
        Where the curves are given.
    orders : tuple of int, length k
        Their orders m; on curves of even order a solution has period 2 pi, of odd order 4 pi.
    even : ndarray (k, n)
        beta = -a_m / 4.
    odd : ndarray (k, n)
        beta = -b_m / 4; NaN for order 0, which has no second curve.
    width : ndarray (k, n)
        Width of tongue m in beta, abs(even - odd) but accurate relative to itself; infinite for order 0, the
        half-plane of static buckling.
    """

    alpha: Floats
    orders: tuple[int, ...]
    even: Floats
    odd: Floats
    width: Floats

    def period(self, order: int) -> float:
        """Return the period of the solution on the curves of ``order``: 2 pi when even, 4 pi when odd.

        Returns
        -------
        float
            In the unit of tau.

        Raises
        ------
        TypeError, ValueError
            For anything but a whole number from 0.
        """
        order = validate.integer("order", order, 0)
        return 2.0 * math.pi if order % 2 == 0 else 4.0 * math.pi

    def plot(self, ax: Any = None) -> Any:
        """Draw the curves, each with its name, into matplotlib axes, new ones by default.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.
        """
        from floquetrod.plotting.chart_plot import draw_curves

        return draw_curves(self, ax)

    def __repr__(self) -> str:
        """Say what curves these are."""
        return f"<transition curves of orders {', '.join(map(str, self.orders))} at {self.alpha.size} values of alpha>"


def transition_curves(alpha: Any, orders: Any) -> TransitionCurves:
    """Return the transition curves of the given orders over ``alpha``.

    Parameters
    ----------
    alpha : array_like of float, one-dimensional or a single number
        Amplitude of the coefficient.
    orders : int or sequence of int
        An int n means the orders 0 to n.

    Returns
    -------
    TransitionCurves
        beta of both curves of each order, at each alpha.

    Raises
    ------
    TypeError, ValueError
        For orders that are no whole numbers from 0, and for ``alpha`` in more than one dimension.

    Examples
    --------
    >>> transition_curves([0.0, 0.5], 1).even.round(6).tolist()
    [[-0.0, 0.113785], [-0.25, -0.464777]]
    """
    values = np.atleast_1d(validate.array("alpha", alpha, least=-_LARGEST_ALPHA, largest=_LARGEST_ALPHA))
    if values.ndim != 1:
        raise ValueError(f"alpha must be one-dimensional, got shape {values.shape}; ravel it first")
    if validate.iterable(orders):
        listed = validate.integers("orders", orders, 0)
    else:
        listed = tuple(range(validate.integer("orders", orders, 0, validate.MOST_NUMBERS) + 1))
    m = np.array(listed, dtype=np.int64)[:, None]
    q = 2.0 * values
    even = -0.25 * characteristic_values(m, q, "a")
    odd = np.full(even.shape, math.nan)
    width = np.full(even.shape, math.inf)
    some = m[:, 0] > 0
    if some.any():
        odd[some] = -0.25 * characteristic_values(m[some], q, "b")
        width[some] = 0.25 * tongue_widths(m[some], q)
    return TransitionCurves(values, listed, even, odd, width)
