"""Calls of a user's function that numba has compiled, at many instants from compiled code."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats


def is_compiled(call: Any) -> bool:
    """Return whether a function is one compiled by numba."""
    return hasattr(call, "py_func") and hasattr(call, "signatures")


def at_points(
    call: Any, times: Floats, states: NDArray[Any], parameters: Mapping[str, float], shape: tuple[int, ...]
) -> NDArray[Any]:
    """Return the values (k, *shape) of a compiled function at times (k,) and states (k, n)."""
    listed = list(inspect.signature(call.py_func).parameters.values())[2:]
    arguments = tuple(float(parameters.get(parameter.name, parameter.default)) for parameter in listed)
    values = np.empty((len(times), *shape), dtype=states.dtype)
    _loop(len(shape))(call, np.ascontiguousarray(times), np.ascontiguousarray(states), arguments, values)
    return values


@functools.cache
def _loop(depth: int) -> Any:
    """Return the compiled loop over instants, of a function that returns a vector or a matrix."""
    import numba

    def vectors(function: Any, times: Any, states: Any, arguments: Any, result: Any) -> None:
        for k in range(len(times)):
            values = function(times[k], states[k], *arguments)
            for i in range(result.shape[1]):
                result[k, i] = values[i]

    def matrices(function: Any, times: Any, states: Any, arguments: Any, result: Any) -> None:
        for k in range(len(times)):
            values = function(times[k], states[k], *arguments)
            for i in range(result.shape[1]):
                for j in range(result.shape[2]):
                    result[k, i, j] = values[i][j]

    compile_loop: Any = numba.njit
    return compile_loop(vectors if depth == 1 else matrices)
