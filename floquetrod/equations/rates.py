"""Values of a user's function f(t, x, **parameters) at many instants, and its derivatives, checked."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import EPS, Floats
from floquetrod.equations.compiled_rates import at_points, is_compiled

Parameters = Mapping[str, float]

_COMPLEX_STEP = 1e-100  # the derivative is exact to rounding however small it is
_STEP = 4e-4  # of differences, part of a component's size: truncation 4e-14 of the fifth derivative, rounding 1e-12
_SMALLER_STEPS = 2e-5, 1e-6  # rounding of the last: 1e-9
_DIFFERENCES = ((-2.0, 1.0 / 12.0), (-1.0, -8.0 / 12.0), (1.0, 8.0 / 12.0), (2.0, -1.0 / 12.0))
_AGREEMENT = 1e-5  # of derivatives with differences, part of the change of the component's rate (a choice)
_DIFFERENCES_ERROR = 1e-11  # of derivatives by differences, in the same sense (measured)


class Disagreement(NamedTuple):
    """The entry of the derivatives that agrees worst with differences: size relative to its row, indices, values."""

    size: float
    row: int
    column: int
    given: float
    expected: float
    instant: int


class RateFunction:
    """A function f and its way of being called: all instants at once, one at a time, or from compiled code.

    The first call determines the way; copies of a system with other parameters share it.
    """

    def __init__(self, function: Callable[..., Any], jacobian: Callable[..., Any] | None) -> None:
        """Store the functions; the first call determines how they are called."""
        self.function, self.jacobian = function, jacobian
        self.complex_steps = jacobian is None
        self._at_once: dict[str, bool] = {}
        self._order = 0

    @property
    def derivatives_error(self) -> float:
        """Relative error of the derivatives, rounding, or the error of differences where these are used."""
        return 16.0 * EPS if self.jacobian is not None or self.complex_steps else _DIFFERENCES_ERROR

    def __reduce__(self) -> tuple[Any, ...]:
        return (RateFunction, (self.function, self.jacobian))

    def start(self, time: float, state: Floats, parameters: Parameters) -> None:
        """Call the function at one state for the first time, to determine the way to call it.

        ValueError names its fault: a wrong shape, a value that is not finite.
        """
        if self._order == len(state) and "function" in self._at_once:
            return
        self._order = len(state)
        self._at_once.clear()
        size = np.maximum(np.abs(state), 0.1)
        trials = state + size * np.array([[0.0], [0.011], [-0.007]]) * np.cos(np.arange(1, len(state) + 1))
        times = time + np.array([0.0, 0.31, 0.77])
        single = self._singly("function", self.function, times, trials, parameters)
        if not np.isfinite(single[0]).all():
            raise ValueError(f"function must return finite rates, got {single[0].tolist()} {_place(time, state)}")
        self._at_once["function"] = self._same_at_once("function", self.function, times, trials, parameters, single)
        if self.jacobian is not None:
            single = self._singly("jacobian", self.jacobian, times, trials, parameters)
            self._at_once["jacobian"] = self._same_at_once("jacobian", self.jacobian, times, trials, parameters, single)
        elif self.complex_steps:
            self.complex_steps = self._takes_complex(times, trials, parameters)

    def values(self, times: Floats, states: NDArray[Any], parameters: Parameters) -> Floats:
        """Return the rates (k, n) at times (k,) and states (k, n), which may be complex."""
        if self._order != states.shape[1] or not self._at_once:
            self.start(float(times[0]), states[0].real, parameters)
        with np.errstate(all="ignore"):
            return self._all("function", self.function, times, states, parameters)

    def derivatives(self, times: Floats, states: Floats, parameters: Parameters) -> Floats:
        """Return the derivatives (k, n, n)."""
        self.start(float(times[0]), states[0], parameters)
        with np.errstate(all="ignore"):
            if self.jacobian is not None:
                return self._all("jacobian", self.jacobian, times, states, parameters)
            if self.complex_steps:
                return self._by_complex_steps(times, states, parameters)
            return self.by_differences(times, states, parameters)

    def disagreement(
        self, times: Floats, states: Floats, parameters: Parameters, step: float = _STEP
    ) -> Disagreement | None:
        """Return the entry where derivatives disagree most with differences of the function; None where they agree."""
        derivatives = self.derivatives(times, states, parameters)
        expected = self.by_differences(times, states, parameters, step)
        sizes = np.maximum(np.abs(states).max(axis=0), 1e-300)
        reach = np.abs(expected) * sizes
        largest = np.maximum(reach.max(axis=(0, 2)), np.abs(self.values(times, states, parameters)).max(axis=0))
        deviations = np.abs(derivatives - expected) * sizes / np.maximum(largest[None, :, None], 1e-300)
        deviations = np.where(np.isfinite(deviations), deviations, np.inf)
        k, i, j = map(int, np.unravel_index(int(deviations.argmax()), deviations.shape))
        size = float(deviations[k, i, j])
        if size <= _AGREEMENT:
            return None
        return Disagreement(size, i, j, float(derivatives[k, i, j]), float(expected[k, i, j]), k)

    def require_derivatives(self, times: Floats, states: Floats, parameters: Parameters) -> None:
        """Raise ValueError where a given Jacobian matrix disagrees with differences, naming the entry.

        Where complex steps disagree, because f takes a magnitude, say, go over to differences.
        """
        if self.jacobian is None and not self.complex_steps:
            return
        worst = self.disagreement(times, states, parameters)
        if worst is None:
            return
        if self.jacobian is None:
            self.complex_steps = False
            return
        # Where derivatives change within a step, smaller steps agree; wrong derivatives are wrong with every step.
        if any(self.disagreement(times, states, parameters, step) is None for step in _SMALLER_STEPS):
            return
        raise ValueError(
            f"jacobian[{worst.row}, {worst.column}] = {worst.given:.6g} disagrees with differences of function, "
            f"{worst.expected:.6g}, {_place(float(times[worst.instant]), states[worst.instant])}"
        )

    def by_differences(self, times: Floats, states: Floats, parameters: Parameters, step: float = _STEP) -> Floats:
        """Return the derivatives (k, n, n) by central differences of fourth order."""
        count, n = states.shape
        steps = step * np.maximum(np.abs(states).max(axis=0), 1e-3 * float(np.abs(states).max()) + 1e-100)
        moved = np.stack([states[None] + share * np.diag(steps)[:, None] for share, _ in _DIFFERENCES])
        instants = np.broadcast_to(times, (4, n, count)).ravel()
        values = self.values(instants, moved.reshape(-1, n), parameters).reshape(4, n, count, n)
        slopes = np.einsum("a,ajki->kij", [factor for _, factor in _DIFFERENCES], values)
        return np.asarray(slopes / steps)

    def _by_complex_steps(self, times: Floats, states: Floats, parameters: Parameters) -> Floats:
        """Return the derivatives as imaginary parts of the function of complex states."""
        count, n = states.shape
        moved = np.empty((n, n, count), dtype=np.complex128)  # component, then the one that a step is made in
        moved.real, moved.imag = states.T[:, None], 0.0
        moved.imag[range(n), range(n)] = _COMPLEX_STEP
        instants = np.concatenate([times] * n)
        values = self.values(instants, moved.reshape(n, n * count).T, parameters)
        derivatives = np.empty((count, n, n))
        np.divide(values.imag.reshape(n, count, n).transpose(1, 2, 0), _COMPLEX_STEP, out=derivatives)
        return derivatives

    def _takes_complex(self, times: Floats, states: Floats, parameters: Parameters) -> bool:
        """Return whether the function of complex states gives its derivatives."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")  # that an imaginary part is discarded
                return self.disagreement(times, states, parameters) is None
        except Exception:  # whatever a function of real numbers raises for complex ones
            return False

    def _all(self, name: str, call: Any, times: Floats, states: NDArray[Any], parameters: Parameters) -> NDArray[Any]:
        """Return the values of a function at all instants, called in its way."""
        way = self._together if self._at_once.get(name) and not is_compiled(call) else self._singly
        return np.asarray(way(name, call, times, states, parameters))

    def _same_at_once(
        self, name: str, call: Any, times: Floats, states: Floats, parameters: Parameters, single: NDArray[Any]
    ) -> bool:
        """Return whether a function called with arrays returns the same values as one instant at a time."""
        if is_compiled(call):
            return False
        try:
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("error")
                together = self._together(name, call, times, states, parameters)
        except Exception:  # whatever a function of numbers raises for arrays
            return False
        rounding = 1e-12 * float(np.abs(single[np.isfinite(single)]).max(initial=0.0))  # of sums in another order
        return bool(np.allclose(together, single, rtol=1e-12, atol=rounding, equal_nan=True))

    def _together(self, name: str, call: Any, times: Floats, states: NDArray[Any], parameters: Parameters) -> Any:
        """Return the values of a function called once, with x (n, k)."""
        count, n = states.shape
        returned = call(times, states.T, **parameters)
        shape = (n,) if name == "function" else (n, n)
        if isinstance(returned, np.ndarray) and returned.dtype != object:
            values = np.broadcast_to(returned if returned.ndim > len(shape) else returned[..., None], (*shape, count))
            return np.ascontiguousarray(np.moveaxis(values, -1, 0))
        values = np.empty((count, *shape), dtype=states.dtype)
        _fill(values.T if name == "function" else values.transpose(1, 2, 0), returned, len(shape))
        return values

    def _singly(self, name: str, call: Any, times: Floats, states: NDArray[Any], parameters: Parameters) -> Any:
        """Return the values of a function called at one instant after the other."""
        count, n = states.shape
        shape = (n,) if name == "function" else (n, n)
        if is_compiled(call) and self._at_once:
            return at_points(call, times, states, parameters, shape)
        values = np.empty((count, *shape), dtype=states.dtype)
        for k in range(count):
            value = _array(
                name, call(float(times[k]), states[k].copy(), **parameters), states.dtype, times[k], states[k]
            )
            if value.shape != shape:
                wanted = f"{n} rates, one for each state" if name == "function" else f"a matrix {n} x {n}"
                raise ValueError(f"{name} must return {wanted}, got shape {value.shape}; start has {n} states")
            values[k] = value
        return values


def _fill(array: NDArray[Any], nested: Any, depth: int) -> None:
    """Write nested sequences of arrays or numbers into an array; ValueError where lengths differ."""
    if len(nested) != len(array):
        raise ValueError("lengths differ")
    for row, value in zip(array, nested, strict=True):
        if depth > 1:
            _fill(row, value, depth - 1)
        else:
            row[...] = value


def _array(name: str, returned: Any, kind: Any, time: float, state: NDArray[Any]) -> NDArray[Any]:
    """Return the value of a function at one instant as an array; TypeError where it is not one of real numbers."""
    if returned is None:
        raise TypeError(f"{name} must return numbers, got None; does it end in a return?")
    try:
        array = np.asarray(returned)
        if array.dtype.kind not in "iufc" or (array.dtype.kind == "c" and kind != np.complex128):
            raise TypeError
    except Exception:  # ragged, or no numbers
        raise TypeError(
            f"{name} must return real numbers, got {validate.short(returned)} {_place(time, state)}"
        ) from None
    return array


def _place(time: float, state: NDArray[Any]) -> str:
    listed = ", ".join(f"{value:.6g}" for value in state[:6].real) + (", ..." if len(state) > 6 else "")
    return f"at t = {time:.6g}, x = ({listed})"
