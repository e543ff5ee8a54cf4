"""A kick against Coulomb friction: does A'' + 2 c A' = (beta + alpha sin tau) A - gamma sign(A') escape, ever?

Every motion starts at A(0) = 0 with A'(0) = epsilon, the kick.  It either stays bounded for ever or grows in the end
like the growing Floquet solution; which, is decided for all time and not for some number of periods.  The equation is
Eq. (14) of DOI 10.1115/1.4031710; derivations and proofs are in docs/friction.md.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod import _validate, mathieu
from floquetrod._compile import broadcast, over_chunks
from floquetrod.kernels import friction as kernels

UNDECIDED, BOUNDED, ESCAPES = -1, 0, 1
"""Values of `outcome`."""

_EFFORT = 500_000  # cells an orbit may take, 32 or more to a period: a few thousandths of a second (a choice)
_FEW = 4  # orbits that are cheaper interpreted than numba is to load (measured)


class UndecidedWarning(UserWarning):
    """Some orbits could not be decided; they are not counted among those that escape."""


def outcome(
    alpha: Any,
    beta: Any,
    gamma: Any,
    epsilon: Any,
    damping: Any = 0.0,
    *,
    effort: int = _EFFORT,
    workers: int | None = None,
) -> Any:
    """Return the fate of each kick: `ESCAPES` (1), `BOUNDED` (0) or `UNDECIDED` (-1), as int8.

    Parameters
    ----------
    alpha, beta, gamma, epsilon, damping : array_like
        Broadcast against each other.  gamma and damping are zero or more; a negative kick is the mirror image of its
        positive.  Fastest where epsilon varies along the last axis.
    effort : int
        Cells an orbit may take before it is given up as undecided.
    workers : int, optional
        Threads; by default all cores.

    Notes
    -----
    Without friction an orbit escapes where Mathieu's equation is unstable and the kick is not zero.  Where it is
    stable no kick escapes: proved but for exact resonances, which no double hits (docs/friction.md).

    Examples
    --------
    >>> outcome(0.0, 0.25, 1.0, [1.999, 2.001]).tolist()
    [0, 1]
    """
    shape, alpha, beta, gamma, kick, c = _arguments(alpha, beta, gamma, epsilon, damping)
    fates = _fates(alpha, beta, gamma, kick, c, effort, workers)
    result = np.where(fates == kernels.GROWS, ESCAPES, np.where(fates < kernels.GROWS, BOUNDED, UNDECIDED))
    return result.astype(np.int8).reshape(shape) if shape else np.int8(result[0])


def escapes(
    alpha: Any,
    beta: Any,
    gamma: Any,
    epsilon: Any,
    damping: Any = 0.0,
    *,
    effort: int = _EFFORT,
    workers: int | None = None,
) -> Any:
    """Return whether each kick escapes for good, as bool; arguments as in `outcome`.

    Warns
    -----
    UndecidedWarning
        When some orbits could not be decided: False there means "not known to escape"; `outcome` tells which.

    Examples
    --------
    >>> escapes(1.0, [0.3, -0.7], 1.0, 2.0).tolist()
    [True, False]
    """
    fate = outcome(alpha, beta, gamma, epsilon, damping, effort=effort, workers=workers)
    unknown = int(np.count_nonzero(fate == UNDECIDED))
    if unknown:
        warnings.warn(
            f"{unknown} of {np.size(fate)} kicks could not be decided and count as not escaping; "
            "friction.outcome tells which, a larger effort may settle them",
            UndecidedWarning,
            stacklevel=2,
        )
    return fate == ESCAPES


def _fates(
    alpha: NDArray[np.float64],
    beta: NDArray[np.float64],
    gamma: NDArray[np.float64],
    kick: NDArray[np.float64],
    damping: NDArray[np.float64],
    effort: int,
    workers: int | None,
) -> NDArray[np.int8]:
    """Return why each run ended, as the kernels number it."""
    effort = _validate.integer("effort", effort, 1)
    rate = _rates(alpha, beta, damping, workers)
    out = np.empty(kick.size, dtype=np.int8)
    free = gamma == 0.0
    with np.errstate(over="ignore"):
        scaled = kick / np.where(free, 1.0, gamma)
    runs = np.where(free, -1.0, rate)
    limit = np.full(kick.size, effort, dtype=np.int64)
    inputs = (alpha, beta, damping, runs, scaled, limit)
    over_chunks(kernels.outcome_fill, inputs, out, workers=workers, chunk=64, interpret_up_to=_FEW)
    out[free & (rate >= 0.0) & (kick > 0.0)] = kernels.GROWS
    return out


def _rates(
    alpha: NDArray[np.float64], beta: NDArray[np.float64], damping: NDArray[np.float64], workers: int | None
) -> NDArray[np.float64]:
    """Return growth rates without friction, -1 where nothing grows."""
    stable = mathieu.is_stable(alpha, beta, damping, workers=workers)
    return np.where(stable, -1.0, mathieu.growth_rate(alpha, beta, damping, workers=workers))


def _arguments(alpha: Any, beta: Any, gamma: Any, epsilon: Any, damping: Any) -> tuple[Any, ...]:
    """Return the common shape and the flat arrays of arguments that broadcast; kicks by their size."""
    largest = np.finfo(np.float64).max
    arrays = (
        _validate.array("alpha", alpha),
        _validate.array("beta", beta),
        _validate.array("gamma", gamma, least=0.0, largest=largest),
        np.abs(_validate.array("epsilon", epsilon, least=-largest, largest=largest)),
        _validate.array("damping", damping, least=0.0, largest=_validate.LARGEST**0.5),
    )
    try:
        shape, flat = broadcast(*arrays)
    except ValueError:
        shapes = ", ".join(str(array.shape) for array in arrays)
        raise ValueError(
            f"alpha, beta, gamma, epsilon and damping must broadcast to one shape, got shapes {shapes}"
        ) from None
    return (shape, *flat)
