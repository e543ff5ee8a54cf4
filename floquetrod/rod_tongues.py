"""Where a rod's modes grow along one direction of the load, mean force, amplitude or frequency: complete, no grid."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from floquetrod._compile import compiled
from floquetrod.kernels import characteristic
from floquetrod.kernels import mathieu as kernels
from floquetrod.load import AxialLoad
from floquetrod.rod_data import RodData
from floquetrod.tongues import part_above, unstable_intervals

_FINEST = 1e-9  # bands of amplitude narrower than this share of the range may be stepped over


class UnstableRange(NamedTuple):
    """The rod's ``mode`` grows for loads between ``low`` and ``high``, in resonance tongue ``tongue``."""

    low: float
    high: float
    mode: int
    tongue: int


def unstable_mean_forces(
    rod: RodData, load: AxialLoad, modes: Iterable[int], tolerance: float, low: float, high: float
) -> list[UnstableRange]:
    """Return where modes grow faster than ``tolerance`` (1/s) as the mean force goes from ``low`` to ``high`` (N).

    At a given amplitude a mode's alpha is fixed and beta is linear in the mean force: the ends are characteristic
    values mapped back.
    """
    omega = load.frequency
    found = []
    for mode in modes:
        equation = rod.mode_equations(load, [mode])[0]
        scale = rod.mode_family(1.0, 0.0, omega)[1] * mode**2  # beta gained by 1 N
        ends = (equation.beta + (force - load.mean) * scale for force in (low, high))
        offset = load.mean - equation.beta / scale
        for part in unstable_intervals(equation.alpha, equation.damping, tolerance / omega, *ends):
            found.append(UnstableRange(offset + part.low / scale, offset + part.high / scale, mode, part.order))
    return found


def unstable_frequencies(
    rod: RodData, load: AxialLoad, modes: Iterable[int], tolerance: float, low: float, high: float
) -> list[UnstableRange]:
    """Return where modes grow faster than ``tolerance`` (1/s) as the frequency goes from ``low`` to ``high`` (rad/s).

    Alpha, beta and c^2 are all proportional to x = 1 / omega^2, so that Hill's matrix is K - x V with K = diag(k^2)
    and V fixed.  Where an eigenvalue passes zero, K v = x V v, its slope is -v.V v = -v.K v / x <= 0: eigenvalues pass
    zero downwards only, the count of negative ones never falls as x grows, and bisection on it finds every passage.
    """
    found = []
    for mode in modes:
        unit = rod.mode_equations(AxialLoad(load.mean, load.amplitude, 1.0), [mode])[0]
        q, a = 2.0 * unit.alpha, -4.0 * (unit.beta + unit.damping**2)

        def surplus(omega: float, alpha: float = unit.alpha, beta: float = unit.beta) -> float:
            x = 1.0 / (omega * omega)
            rate = kernels.growth(alpha * x, beta * x, rod.damping_rate / omega)
            return rate * omega - tolerance if rate > 0.0 else -1.0

        exact = rod.damping_rate == 0.0 and tolerance == 0.0
        for below, start, end in _passages(a, q, low, high):
            if below % 2:
                continue
            part = (start, end) if exact else part_above(surplus, start, end)
            if part is not None and part[1] > part[0]:
                found.append(UnstableRange(*part, mode, below // 2))
    return found


def _passages(a: float, q: float, low: float, high: float) -> list[tuple[int, float, float]]:
    """Return (count, start, end) of the pieces of [low, high] of frequency on which the count is constant."""

    def count(omega: float) -> int:
        x = 1.0 / (omega * omega)
        if q == 0.0:  # without forcing a tongue has no width: only buckling is left
            return 0 if a <= 0.0 else 1
        return max(0, kernels.count_below(a * x, q * x))

    pieces = []
    end, here = high, count(high)
    last = count(low)
    while here < last:
        bottom, top = low, end  # the count exceeds `here` at the bottom, not at the top
        for _ in range(100):
            middle = 0.5 * (bottom + top)
            if middle <= bottom or middle >= top:
                break
            if count(middle) > here:
                bottom = middle
            else:
                top = middle
        pieces.append((here, top, end))
        end, here = bottom, count(bottom)  # may pass several at once where they are closer than rounding
    pieces.append((here, low, end))
    return pieces


def unstable_amplitudes(
    rod: RodData, load: AxialLoad, modes: Iterable[int], tolerance: float, low: float, high: float
) -> list[UnstableRange]:
    """Return where modes grow faster than ``tolerance`` (1/s) as the amplitude goes from ``low`` to ``high`` (N).

    Beta is fixed and alpha proportional to the amplitude; every passage of a characteristic value through a = -4 beta
    is found by a march that its greatest slope, 2, makes complete (`floquetrod.kernels.characteristic.crossings`).
    """
    if high <= 0.0:
        return []
    march = compiled(characteristic.crossings)
    found = []
    for mode in modes:
        top = rod.mode_equations(AxialLoad(load.mean, high, load.frequency), [mode])[0]
        q, a = 2.0 * top.alpha, -4.0 * (top.beta + top.damping**2)
        ends = [0.0, q, q * low / high]
        out = np.empty(64)
        for order in range(int(math.sqrt(max(0.0, a) + 2.0 * q)) + 2):
            if order * order - 2.0 * q > a:
                continue
            for odd_solution in (False, True)[: 1 + (order > 0)]:
                ends += out[: march(order, odd_solution, a, q, _FINEST * q, out)].tolist()
        places = [place for place in sorted(set(ends)) if place >= q * low / high]
        for start, end in pairwise(places):
            below = kernels.count_below(a, 0.5 * (start + end))
            if below < 0 or below % 2:
                continue

            def surplus(place: float, beta: float = top.beta, damping: float = top.damping) -> float:
                rate = kernels.growth(0.5 * place, beta, damping)
                return rate * load.frequency - tolerance if rate > 0.0 else -1.0

            exact = rod.damping_rate == 0.0 and tolerance == 0.0
            part = (start, end) if exact else part_above(surplus, start, end)
            if part is not None:
                found.append(UnstableRange(part[0] * high / q, part[1] * high / q, mode, below // 2))
    return found
