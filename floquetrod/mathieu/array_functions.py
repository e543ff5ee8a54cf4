"""Mathieu's equation A'' + 2 c A' = (beta + alpha sin tau) A over arrays.

The functions broadcast like numpy ufuncs, use all cores on large input and release the GIL.  As in the spectral method,
verdicts come from exact counts of eigenvalues, everything else from Hill's determinants.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Bools, Floats, broadcast, shaped
from floquetrod._util.calling import call_hints
from floquetrod._util.compilation import INTERPRETED_UP_TO, over_chunks
from floquetrod.equations.conventions import other_forms
from floquetrod.floquet.kernels import mathieu_discriminant as kernels
from floquetrod.floquet.mathieu_chains import mathieu_counts as counts

_CHUNK = 1024
"""Points a thread takes at a time; each costs a microsecond, far out more, and a verdict without damping much less."""

_COMPILE_AFTER = 100
"""Times as many points as are always interpreted before growth is compiled, which takes seconds (heuristic)."""

_hints = call_hints(**other_forms("conventions"))


@_hints
def is_stable(alpha: Any, beta: Any, damping: Any = 0.0, *, workers: int | None = None) -> Any:
    """Return whether every solution stays bounded.

    Parameters
    ----------
    alpha : array_like of float
        Amplitude of the coefficient, magnitude up to 1e9; without unit.
    beta : array_like of float
        Mean of the coefficient, magnitude up to 1e9; without unit.
    damping : array_like of float
        c >= 0, the decay rate per unit tau of the free motion.
    workers : int, optional
        Threads; by default one for each core when there is enough to do.

    Returns
    -------
    bool or ndarray of bool
        In the broadcast shape; a Python bool for numbers alone.  A point on a transition curve to rounding may fall
        either way: `floquetrod.stability` says so, `floquetrod.certify` proves the side.

    Raises
    ------
    TypeError, ValueError
        For numbers out of these ranges, and for shapes that do not broadcast.

    Examples
    --------
    >>> is_stable(0.5, [-0.3, -0.6])
    array([False,  True])
    """
    if type(alpha) is type(beta) is type(damping) is float and damping == 0.0:  # the quick way for a single verdict
        validate.workers(workers)
        return kernels.is_stable(validate.coefficient("alpha", alpha), validate.coefficient("beta", beta), 0.0)
    if type(damping) is float and damping == 0.0:
        shape, (a, b) = broadcast(alpha=validate.array("alpha", alpha), beta=validate.array("beta", beta))
        return shaped(flat_stable(a, b, workers=workers), shape)
    shape, (a, b, c) = broadcast(**_arrays(alpha, beta, damping))
    return shaped(flat_stable(a, b, c if c.any() else None, workers=workers), shape)


def flat_stable(
    alpha: Floats,
    beta: Floats,
    damping: Floats | None = None,
    *,
    workers: int | None = None,
    in_blocks: bool = True,
) -> Bools:
    """Return `is_stable` of checked flat arrays, ``damping`` None where there is none.

    ``in_blocks``: a verdict takes 5 ns instead of 43, but compiling the first one takes 2 s instead of 0.5 s.
    """
    out = np.empty(alpha.size, dtype=np.int8)
    if damping is None:
        few = out.size < 64 or not in_blocks  # blocks pay from a few of them on
        fill = counts.shown_one_by_one if few else counts.shown_fill
        over_chunks(fill, [alpha, beta], out, workers=workers)
        near = (out == counts.NEAR_A_BAND).nonzero()[0]
        if near.size:
            out[near] = _growth(alpha[near], beta[near], np.zeros(near.size), workers) == 0.0
    else:
        inputs = [alpha, beta, damping]
        over_chunks(
            kernels.damped_stable_fill, inputs, out, workers=workers, chunk=_CHUNK, compile_after=_COMPILE_AFTER
        )
    return out.view(np.bool_)


@_hints
def growth_rate(alpha: Any, beta: Any, damping: Any = 0.0, *, workers: int | None = None) -> Any:
    """Return the growth rate of the fastest solution, per unit tau; 0 where stable.

    Arguments as in `is_stable`.  Relative accuracy 1e-8 or better where the undamped rate exceeds 1e-9.

    Returns
    -------
    float or ndarray of float
        In the broadcast shape.

    Raises
    ------
    TypeError, ValueError
        As `is_stable`.

    Examples
    --------
    >>> growth_rate(1e-8, -0.25)
    4.999999999999999e-09
    """
    shape, (a, b, c) = broadcast(**_arrays(alpha, beta, damping))
    return shaped(_growth(a, b, c, workers), shape)


def _growth(a: Floats, b: Floats, c: Floats, workers: int | None) -> Floats:
    """Return growth rates, flat."""
    out = np.empty(a.size)
    rows = 2.0 * math.sqrt(max(float(np.abs(part).max(initial=0.0)) for part in (a, b)))  # of Hill's matrix
    few = int(INTERPRETED_UP_TO / (1.0 + 0.02 * max(0.0, rows - 600.0)))  # from there on each takes longer (measured)
    over_chunks(
        kernels.growth_fill,
        (a, b, c),
        out,
        workers=workers,
        chunk=_CHUNK,
        interpret_up_to=few,
        compile_after=_COMPILE_AFTER,
    )
    return out


@_hints
def discriminant(alpha: Any, beta: Any, damping: Any = 0.0, *, workers: int | None = None) -> Any:
    """Return the trace of the monodromy matrix, +-inf beyond the range of a double.

    Arguments as in `is_stable`.  Without damping the equation is stable where its magnitude is below 2.

    Returns
    -------
    float or ndarray of float
        In the broadcast shape.

    Raises
    ------
    TypeError, ValueError
        As `is_stable`.

    Examples
    --------
    >>> round(discriminant(0.0, -1.0 / 16.0), 12) + 0.0
    0.0
    """
    shape, (a, b, c) = broadcast(**_arrays(alpha, beta, damping))
    out = np.empty(a.size)
    over_chunks(kernels.discriminant_fill, (a, b, c), out, workers=workers, chunk=_CHUNK)
    return shaped(out, shape)


@_hints
def multipliers(alpha: Any, beta: Any, damping: Any = 0.0, *, workers: int | None = None) -> Any:
    """Return both Floquet multipliers, the larger first, in a last axis of length 2 (complex).

    Arguments as in `is_stable`.  Their product is exp(-4 pi c); the small one keeps its digits beside a huge one.

    Returns
    -------
    ndarray of complex
        (..., 2), behind the broadcast shape.

    Raises
    ------
    TypeError, ValueError
        As `is_stable`.

    Examples
    --------
    >>> multipliers(0.0, [-0.25, 0.0]).shape
    (2, 2)
    """
    shape, (a, b, c) = broadcast(**_arrays(alpha, beta, damping))
    out = np.empty((a.size, 2), dtype=np.complex128)
    over_chunks(kernels.multipliers_fill, (a, b, c), out, workers=workers, chunk=_CHUNK)
    return shaped(out, (*shape, 2))


@_hints
def exponents(alpha: Any, beta: Any, damping: Any = 0.0, *, per: str = "tau", workers: int | None = None) -> Any:
    """Return both Floquet exponents, in a last axis of length 2 (complex), the one that grows faster first.

    Arguments as in `is_stable`, alpha and beta, not a and q, which `floquetrod.conventions.from_aq` turns into them.
    Real parts are growth rates, negative ones too, finite however large or small the multipliers; imaginary parts lie
    in [0, 1/2] first and in [-1/2, 0] second, but both are 1/2 where multipliers are negative.  ``per`` is "tau", or
    "z" for the exponents of y'' + (a - 2 q cos 2 z) y = 0, which are twice as large; their imaginary part is the order
    nu up to its sign and an even number.

    Returns
    -------
    ndarray of complex
        (..., 2), behind the broadcast shape.

    Raises
    ------
    TypeError, ValueError
        As `is_stable`, and for another ``per``.

    Examples
    --------
    >>> exponents(0.5, [-0.25, -0.6], per="z").round(6).tolist()
    [[(0.453454+1j), (-0.453454+1j)], [0.558628j, -0.558628j]]
    """
    unit = 2.0 if validate.choice("per", per, ("tau", "z")) == "z" else 1.0
    shape, (a, b, c) = broadcast(**_arrays(alpha, beta, damping))
    out = np.empty((a.size, 2), dtype=np.complex128)
    over_chunks(kernels.exponents_fill, (a, b, c), out, workers=workers, chunk=_CHUNK)
    return shaped(unit * out, (*shape, 2))


def _arrays(alpha: Any, beta: Any, damping: Any) -> dict[str, Floats]:
    return {
        "alpha": validate.array("alpha", alpha),
        "beta": validate.array("beta", beta),
        "damping": validate.array("damping", damping, least=0.0, largest=validate.LARGEST_DAMPING),
    }
