"""Kernel that finds the extremes of Fourier series, over arrays of series."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np

from floquetrod._util.compilation import kernel

_NEGLIGIBLE = 1e-17  # part of the largest amplitude below which a harmonic does not matter
_SMALL = 1e-4  # part of the second largest, below which it moves no extreme by a step of the grid (heuristic)
_CLOSE = 0.55  # part of the largest square on the grid that a maximum between its points may have there
_STEPS = 60


@kernel
def square_at(
    amplitudes: Any, low: int, high: int, middle: int, real: bool, angle: float
) -> tuple[float, float, float]:
    """Return |u|^2 at an angle and its first two derivatives; of a ``real`` u from its harmonics k >= 0 alone."""
    turn = cmath.exp(complex(0.0, angle))
    first = middle if real else low
    wave = cmath.exp(complex(0.0, angle * (first - middle)))
    u = v = w = complex(0.0, 0.0)
    for k in range(first, high + 1):
        value = amplitudes[k] * wave
        order = float(k - middle)
        if real and k > middle:
            value *= 2.0
        u += value
        v += complex(0.0, order) * value
        w -= order * order * value
        wave *= turn
    if real:
        return u.real * u.real, 2.0 * u.real * v.real, 2.0 * (v.real * v.real + u.real * w.real)
    return (
        u.real * u.real + u.imag * u.imag,
        2.0 * (u.real * v.real + u.imag * v.imag),
        2.0 * (v.real * v.real + v.imag * v.imag + u.real * w.real + u.imag * w.imag),
    )


@kernel
def grid_values(amplitudes: Any, reach: int, middle: int, real: bool, values: Any) -> None:
    """Set ``values`` to |u|^2 at equal steps of the period, from the harmonics up to ``reach``."""
    points = len(values)
    turn = cmath.exp(complex(0.0, 2.0 * math.pi / points))
    step = complex(1.0, 0.0)
    for i in range(points):
        total = amplitudes[middle]
        wave = complex(1.0, 0.0)
        for k in range(1, reach + 1):
            wave *= step
            if real:
                total += 2.0 * amplitudes[middle + k] * wave
            else:
                total += amplitudes[middle + k] * wave + amplitudes[middle - k] * wave.conjugate()
        values[i] = total.real * total.real if real else total.real * total.real + total.imag * total.imag
        step *= turn


@kernel
def largest_fill(amplitudes: Any, out: Any, real: bool) -> None:
    """Fill ``out`` (n, 2) with the largest modulus of each series over a period, and its angle.

    Where ``real`` the series are: the harmonics -k and k are conjugates.
    """
    # A grid of eight points for the shortest wave that matters to where extremes are, then at each maximum on the grid
    # that may be the largest the zero of the derivative between its neighbours, by Newton's method with bisection
    # where that leaves the bracket, of the whole series.
    for b in range(len(out)):
        count = len(amplitudes[b])
        middle = (count - 1) // 2
        top, second = 0.0, 0.0
        for k in range(count):
            size = max(abs(amplitudes[b][k].real), abs(amplitudes[b][k].imag))
            if size > top:
                top, second = size, top
            else:
                second = max(second, size)
        out[b, 0], out[b, 1] = 0.0, 0.0
        if top == 0.0:
            continue
        if not top < math.inf:
            out[b, 0], out[b, 1] = math.nan, math.nan
            continue
        low, high, reach = middle, middle, 1 if middle > 0 else 0
        for k in range(count):
            size = max(abs(amplitudes[b][k].real), abs(amplitudes[b][k].imag))
            if size > _NEGLIGIBLE * top:
                low, high = min(low, k), max(high, k)
                if size > _SMALL * second:
                    reach = max(reach, abs(k - middle))
        points = 8 * reach + 8
        step = 2.0 * math.pi / points
        values = np.empty(points)
        grid_values(amplitudes[b], reach, middle, real, values)
        best = 0.0
        for i in range(points):
            best = max(best, values[i])
        largest, where = 0.0, 0.0
        for i in range(points):
            if values[i] < _CLOSE * best or values[i] < values[i - 1] or values[i] < values[(i + 1) % points]:
                continue
            left, right, angle = (i - 1.0) * step, (i + 1.0) * step, i * step
            for _ in range(_STEPS):
                value, slope, bend = square_at(amplitudes[b], low, high, middle, real, angle)
                if value > largest:
                    largest, where = value, angle
                if slope > 0.0:
                    left = angle
                elif slope < 0.0:
                    right = angle
                else:
                    break
                after = angle - slope / bend if bend < 0.0 else left
                if not left < after < right:
                    after = 0.5 * (left + right)
                if abs(after - angle) <= 1e-8 * step or right - left <= 1e-8 * step:
                    break
                angle = after
        out[b, 0], out[b, 1] = math.sqrt(largest), where
