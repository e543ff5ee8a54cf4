"""Arrays in, arrays out; numbers in, Python numbers out: what every public function over arrays does alike."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def broadcast(**arrays: NDArray[Any]) -> tuple[tuple[int, ...], tuple[NDArray[Any], ...]]:
    """Return the common shape of arrays and each of them in it, flat and contiguous; ValueError names them."""
    try:
        shape = np.broadcast_shapes(*(array.shape for array in arrays.values()))
    except ValueError:
        *some, last = arrays
        shapes = ", ".join(str(array.shape) for array in arrays.values())
        raise ValueError(f"{', '.join(some)} and {last} must broadcast to one shape, got shapes {shapes}") from None
    whole = (array if array.shape == shape else np.broadcast_to(array, shape) for array in arrays.values())
    return shape, tuple(np.ascontiguousarray(array).ravel() for array in whole)


def shaped(values: NDArray[Any], shape: tuple[int, ...]) -> Any:
    """Return flat results in their shape; one without dimensions as a Python bool, int, float or complex."""
    return values.reshape(shape) if shape else values.item()


def plain(values: Any) -> Any:
    """Return an array as it is, and one without dimensions as a Python number."""
    return shaped(np.asarray(values), np.shape(values))
