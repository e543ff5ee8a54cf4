"""Converters between the common forms of Mathieu's equation.

======================  ================================================  ==========================
name                    equation                                          time
======================  ================================================  ==========================
(alpha, beta)           A'' = (beta + alpha sin tau) A                    period 2 pi in tau
(a, q)                  y'' + (a - 2 q cos 2 z) y = 0                     period pi in z, tau = 2 z + pi/2
(delta, epsilon)        x'' + (delta + epsilon cos t) x = 0               period 2 pi in t, t = tau + pi/2
======================  ================================================  ==========================

The shift of time changes no verdict, multiplier or growth rate; a growth rate per unit z is twice that per unit tau.
All functions broadcast over arrays.
"""

from __future__ import annotations

from typing import Any

from floquetrod._util import validate
from floquetrod._util.arrays import shaped

__all__ = ["from_aq", "from_delta_epsilon", "to_aq", "to_delta_epsilon"]

_LARGEST = 4.0 * validate.LARGEST


def other_forms(owner: str, verb: str = "returns alpha and beta") -> dict[str, str]:
    """Return the remedies for parameters of the other forms, by name, where alpha and beta are arguments.

    Without them the nearest name would be suggested, which is the opposite of what was meant: beta = -delta.
    """
    aq = f"{owner}.from_aq(a, q) {verb} for y'' + (a - 2 q cos 2 z) y = 0"
    delta = f"{owner}.from_delta_epsilon(delta, epsilon) {verb} for x'' + (delta + epsilon cos t) x = 0"
    return dict.fromkeys(("a", "q"), aq) | dict.fromkeys(("delta", "epsilon"), delta)


def to_aq(alpha: Any, beta: Any) -> tuple[Any, Any]:
    """Return (a, q) = (-4 beta, 2 alpha), the parameters of y'' + (a - 2 q cos 2 z) y = 0.

    Returns
    -------
    tuple of two floats or ndarrays
        a and q, in the shape of ``beta`` and of ``alpha``.

    Raises
    ------
    TypeError, ValueError
        For anything but finite numbers.

    Examples
    --------
    >>> to_aq(0.5, -0.25)
    (1.0, 1.0)
    """
    return _scaled("beta", beta, -4.0), _scaled("alpha", alpha, 2.0)


def from_aq(a: Any, q: Any) -> tuple[Any, Any]:
    """Return (alpha, beta) = (q / 2, -a / 4) for y'' + (a - 2 q cos 2 z) y = 0 (DLMF 28.2.1).

    Returns
    -------
    tuple of two floats or ndarrays
        alpha and beta, in the shape of ``q`` and of ``a``.

    Raises
    ------
    TypeError, ValueError
        For anything but finite numbers.

    Examples
    --------
    >>> from_aq(1.0, 1.0)
    (0.5, -0.25)
    """
    return _scaled("q", q, 0.5), _scaled("a", a, -0.25)


def to_delta_epsilon(alpha: Any, beta: Any) -> tuple[Any, Any]:
    """Return (delta, epsilon) = (-beta, alpha), the parameters of x'' + (delta + epsilon cos t) x = 0.

    With tau = t - pi/2, sin tau = -cos t, so A'' = (beta + alpha sin tau) A reads x'' + (-beta + alpha cos t) x = 0.

    Returns
    -------
    tuple of two floats or ndarrays
        delta and epsilon, in the shape of ``beta`` and of ``alpha``.

    Raises
    ------
    TypeError, ValueError
        For anything but finite numbers.

    Examples
    --------
    >>> to_delta_epsilon(0.5, -0.25)
    (0.25, 0.5)
    """
    return _scaled("beta", beta, -1.0), _scaled("alpha", alpha, 1.0)


def from_delta_epsilon(delta: Any, epsilon: Any) -> tuple[Any, Any]:
    """Return (alpha, beta) = (epsilon, -delta) for x'' + (delta + epsilon cos t) x = 0.

    Returns
    -------
    tuple of two floats or ndarrays
        alpha and beta, in the shape of ``epsilon`` and of ``delta``.

    Raises
    ------
    TypeError, ValueError
        For anything but finite numbers.

    Examples
    --------
    >>> from_delta_epsilon(0.25, 0.5)
    (0.5, -0.25)
    """
    return _scaled("epsilon", epsilon, 1.0), _scaled("delta", delta, -1.0)


def _scaled(name: str, values: Any, factor: float) -> Any:
    array = validate.array(name, values, least=-_LARGEST, largest=_LARGEST)
    return shaped(factor * array, array.shape)
