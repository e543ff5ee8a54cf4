"""Calls of a user's function that numba has compiled, at many instants from compiled code."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats

_FEW = 64  # functions whose loops are cached


def is_compiled(call: Any) -> bool:
    """Return whether a function is one compiled by numba."""
    return hasattr(call, "py_func") and hasattr(call, "signatures")


def at_points(
    call: Any, times: Floats, states: NDArray[Any], parameters: Mapping[str, float], shape: tuple[int, ...]
) -> NDArray[Any]:
    """Return the values (k, *shape) of a compiled function at times (k,) and states (k, n)."""
    loop, names = _loop(call, len(shape))
    arguments = tuple([float(parameters.get(name, default)) for name, default in names])
    values = np.empty((len(times), *shape), dtype=states.dtype)
    loop(np.ascontiguousarray(times), np.ascontiguousarray(states), arguments, values)
    return values


@functools.lru_cache(_FEW)
def _loop(function: Any, depth: int) -> tuple[Any, list[tuple[str, Any]]]:
    """Return the compiled loop of a function over instants, and its parameters by name, with their defaults.

    The function returns a vector or, for the depth 2, a matrix.
    """
    import numba

    def vectors(times: Any, states: Any, arguments: Any, result: Any) -> None:
        for k in range(len(times)):
            values = function(times[k], states[k], *arguments)
            for i in range(result.shape[1]):
                result[k, i] = values[i]

    def matrices(times: Any, states: Any, arguments: Any, result: Any) -> None:
        for k in range(len(times)):
            values = function(times[k], states[k], *arguments)
            for i in range(result.shape[1]):
                for j in range(result.shape[2]):
                    result[k, i, j] = values[i][j]

    listed = list(inspect.signature(function.py_func).parameters.values())[2:]
    compile_loop: Any = numba.njit
    loop = compile_loop(vectors if depth == 1 else matrices)
    return loop, [(parameter.name, parameter.default) for parameter in listed]
