"""Arrays in, arrays out; scalars in, Python scalars out: the convention of every public function over arrays.

shape, (x, y) = broadcast(x=validate.array("x", x), y=validate.array("y", y))
return shaped(computed(x, y), shape)
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]
Complexes: TypeAlias = NDArray[np.complex128]
Bools: TypeAlias = NDArray[np.bool_]

EPS = 2.220446049250313e-16
"""The distance of 1 from the next double."""


def broadcast(**arrays: NDArray[Any]) -> tuple[tuple[int, ...], tuple[NDArray[Any], ...]]:
    """Return the common shape of arrays and each of them in it, flat and contiguous; ValueError names them."""
    shapes = {array.shape for array in arrays.values()}
    try:
        shape = shapes.pop() if len(shapes) == 1 else np.broadcast_shapes(*shapes)
    except ValueError:
        *first, last = arrays
        listed = ", ".join(str(array.shape) for array in arrays.values())
        raise ValueError(f"{', '.join(first)} and {last} must broadcast to one shape, got shapes {listed}") from None
    validate.elements(", ".join(arrays), math.prod(shape))
    flat = []
    for array in arrays.values():
        if array.shape == shape:
            flat.append(array.ravel())
        else:  # a third of the time of a copy of `numpy.broadcast_to`
            wide = np.empty(shape, array.dtype)
            wide[...] = array
            flat.append(wide.ravel())
    return shape, tuple(flat)


def are_diagonal(matrices: NDArray[Any]) -> bool:
    """Return whether matrices (..., n, n) are zero beside their diagonals."""
    return bool(np.count_nonzero(matrices) == np.count_nonzero(np.diagonal(matrices, axis1=-2, axis2=-1)))


def norms(matrices: NDArray[Any]) -> NDArray[np.float64]:
    """Return the Frobenius norms of matrices (..., m, n), infinite where squares overflow, 0 where they underflow."""
    sizes = np.abs(matrices) if matrices.dtype.kind == "c" else matrices
    with np.errstate(over="ignore", under="ignore"):
        return np.asarray(np.sqrt(np.square(sizes).sum(axis=(-2, -1))))


def inverses(matrices: NDArray[Any]) -> NDArray[Any]:
    """Return the inverses of matrices (b, n, n), NaN for singular and infinite ones."""
    finite = np.isfinite(matrices).all(axis=(-2, -1))
    if not finite.all():
        result = np.full_like(matrices, np.nan)
        result[finite] = inverses(matrices[finite])
        return result
    try:
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            return np.asarray(np.linalg.inv(matrices))
    except np.linalg.LinAlgError:  # one of them is singular: it spoils no other
        if len(matrices) == 1:
            return np.full_like(matrices, np.nan)
        return np.concatenate([inverses(matrix[None]) for matrix in matrices])


def shaped(values: Any, shape: tuple[int, ...]) -> Any:
    """Return results in the common shape of their arguments.

    Parameters
    ----------
    values : ndarray or numpy scalar
        As many results as ``shape`` has elements.
    shape : tuple of int
        Common shape of the arguments; () where all of them were scalars.

    Returns
    -------
    bool, int, float, complex or ndarray
        A Python scalar for the shape (), so that results compare, print and serialise as numbers do; else an array of
        the type of ``values``.

    Examples
    --------
    >>> shaped(np.array([True]), ()), shaped(np.float64(0.5), ()), shaped(np.arange(4), (2, 2)).tolist()
    (True, 0.5, [[0, 1], [2, 3]])
    """
    return values.reshape(shape) if shape else values.item()
