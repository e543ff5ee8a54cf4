"""Many brackets at once: zeros and largest values of functions, and the ends of statements."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from floquetrod._util.arrays import EPS, Bools, Floats, Ints

_GOLDEN = 0.3819660112501051  # (3 - sqrt(5)) / 2


def roots(
    function: Callable[[Floats, Ints], Floats],
    low: Floats,
    high: Floats,
    at_low: Floats,
    at_high: Floats,
    accuracy: Floats | None = None,
) -> Floats:
    """Return a zero of a function in each of many brackets, to rounding: Chandrupatla's method.

    ``function(x, i)`` returns the values at places x, one for each, in the brackets of number i.  The values ``at_low``
    and ``at_high`` have opposite signs, or are zero; NaN counts as negative.

    With an ``accuracy`` for each bracket, for costly functions, straight lines give the first place and the
    zero in a bracket no wider than twice this.

    T. R. Chandrupatla, Adv. Eng. Software 28 (1997) 145, doi:10.1016/S0965-9978(96)00051-8.
    """
    a, b, fa, fb = low.copy(), high.copy(), at_low.copy(), at_high.copy()
    c, fc = a.copy(), fa.copy()
    least = np.zeros(a.shape) if accuracy is None else accuracy
    open_ = np.flatnonzero((fa != 0.0) & (fb != 0.0) & (np.abs(b - a) > 2.0 * least))
    t = np.full(a.shape, 0.5)
    if accuracy is not None:
        nearest = least[open_] / np.abs(b - a)[open_]
        t[open_] = np.clip(_on_line(fa, fb)[open_], nearest, 1.0 - nearest)
    while open_.size:
        i = open_
        x = a[i] + t[i] * (b[i] - a[i])
        value = function(x, i)
        same = (value > 0.0) == (fa[i] > 0.0)
        c[i], fc[i] = np.where(same, a[i], b[i]), np.where(same, fa[i], fb[i])
        b[i], fb[i] = np.where(same, b[i], a[i]), np.where(same, fb[i], fa[i])
        a[i], fa[i] = x, value
        width = np.abs(b[i] - a[i])
        size = np.abs(np.where(np.abs(fa[i]) < np.abs(fb[i]), a[i], b[i]))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            closest = np.maximum(2.0 * EPS * size, least[i]) / width
            xi, phi = (a[i] - b[i]) / (c[i] - b[i]), (fa[i] - fb[i]) / (fc[i] - fb[i])
            inverse = fa[i] / (fb[i] - fa[i]) * fc[i] / (fb[i] - fc[i])
            inverse += (c[i] - a[i]) / (b[i] - a[i]) * fa[i] / (fc[i] - fa[i]) * fb[i] / (fc[i] - fb[i])
            smooth = (phi * phi < xi) & ((1.0 - phi) ** 2 < 1.0 - xi) & np.isfinite(inverse)
        t[i] = np.clip(np.where(smooth, inverse, 0.5), np.minimum(closest, 0.5), np.maximum(1.0 - closest, 0.5))
        open_ = i[(fa[i] != 0.0) & ~(closest > 0.5)]
    if accuracy is not None:
        return np.asarray(a + np.clip(_on_line(fa, fb), 0.0, 1.0) * (b - a))
    return np.where((fb == 0.0) | (np.abs(fb) < np.abs(fa)), b, a)


def _on_line(fa: Floats, fb: Floats) -> Floats:
    """Return the part of the way from a to b at which straight lines cross zero; half where a value is not finite."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        share = fa / (fa - fb)
    return np.where(np.isfinite(share), share, 0.5)


def bisected(
    holds: Callable[[Floats], Bools], low: Floats, high: Floats, halvings: int, *, relative: float = 0.0
) -> tuple[Floats, Floats]:
    """Return brackets in which a statement ceases to hold, after at most ``halvings``: their ends ``low`` and ``high``.

    ``holds`` takes a place in every bracket; the statement holds at ``low``, and does not at ``high``, which may be
    lower or higher and is not examined.  No more are halved once every bracket is no wider than ``relative`` of its
    end ``high``.
    """
    for _ in range(halvings):
        if not (np.abs(high - low) > relative * np.abs(high)).any():
            break
        middle = 0.5 * (low + high)
        here = holds(middle)
        low, high = np.where(here, middle, low), np.where(here, high, middle)
    return low, high


def largest(
    function: Callable[[Floats, Ints], Floats], low: Floats, high: Floats, sections: int
) -> tuple[Floats, Floats]:
    """Return where functions with one summit are largest in each of many brackets, and their values: golden sections.

    They are as in `roots`, and are not evaluated at the ends; each section leaves 0.62 of a bracket.
    """
    brackets = np.arange(low.size)
    left, right = low + _GOLDEN * (high - low), high - _GOLDEN * (high - low)
    at_left, at_right = function(left, brackets), function(right, brackets)
    for _ in range(sections):
        is_left = at_left >= at_right  # the larger lies left
        low, high = np.where(is_left, low, left), np.where(is_left, right, high)
        x = np.where(is_left, low + _GOLDEN * (high - low), high - _GOLDEN * (high - low))
        value = function(x, brackets)
        left, right = np.where(is_left, x, right), np.where(is_left, left, x)
        at_left, at_right = np.where(is_left, value, at_right), np.where(is_left, at_left, value)
    is_left = at_left >= at_right
    return np.where(is_left, left, right), np.where(is_left, at_left, at_right)
