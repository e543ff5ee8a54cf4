"""Names of growing solutions: which natural frequencies of the mean system combine with the forcing.  A heuristic."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.floquet.systems.result import Resonance

_HIGHEST_ORDER = 40  # of a resonance that is looked for
_MOST_MODES = 60  # of a system whose resonances are named: their number grows with the square
_PER_ORDER = 0.05  # what an order is thought to cost, in detuning relative to w: low orders grow faster
_NOTHING = 1e-9


def name(system: HillSystem | PeriodicSystem, exponents: tuple[complex, ...]) -> tuple[Resonance, ...]:
    """Return the names of the growing solutions, the fastest first, each name once."""
    poles = _mean_exponents(system)
    if poles is None or len(poles) > _MOST_MODES:
        return ()
    differences = not isinstance(system, HillSystem) or system.gyroscopic is not None or not system.is_symmetric
    found: dict[tuple[str, tuple[int, ...], int], Resonance] = {}
    for exponent in exponents:
        if exponent.real <= 0.0 or exponent.imag < -_NOTHING:
            continue
        candidates = list(_candidates(poles, exponent, 2.0 * math.pi / float(system.period), differences))
        if candidates:
            _, best = min(candidates, key=lambda pair: pair[0])
            found.setdefault((best.kind, best.modes, best.order), best)
    return tuple(found.values())


def _mean_exponents(system: HillSystem | PeriodicSystem) -> NDArray[np.complex128] | None:
    """Return exponents of the mean system, one of each pair, those with the lowest frequency first."""
    mean = (system.as_periodic_system() if isinstance(system, HillSystem) else system).mean
    if not np.isfinite(mean).all():
        return None
    values = np.linalg.eigvals(mean).astype(np.complex128)
    size = float(np.abs(values).max(initial=0.0))
    values = values[np.argsort(values.imag + 1e-6 * values.real)[::-1]]
    oscillating = values[values.imag > _NOTHING * size]
    still = np.sort(values[np.abs(values.imag) <= _NOTHING * size].real)[::-1]
    # Real exponents come in pairs, of which the growing one names a mode.
    modes = np.concatenate([still[: math.ceil(len(still) / 2)].astype(np.complex128), oscillating[::-1]])
    return np.asarray(modes)


def _candidates(
    poles: NDArray[np.complex128], exponent: complex, w: float, differences: bool
) -> Iterator[tuple[float, Resonance]]:
    """Yield names with a measure of how badly each fits: detuning and mismatch of the angle, over w, plus its order.

    Without ``differences`` none of that kind: all modes have one Krein sign.
    """
    frequencies = poles.imag

    def off(angle: float) -> float:
        """Distance of the exponent's frequency from an angle, modulo w."""
        return abs((exponent.imag - angle + 0.5 * w) % w - 0.5 * w) / w

    def entry(misfit: float, kind: str, modes: tuple[int, ...], order: int) -> tuple[float, Resonance]:
        resonance = Resonance(kind, modes, order, exponent.real)  # type: ignore[arg-type]
        return misfit + _PER_ORDER * order, resonance

    for i, fi in enumerate(frequencies):
        if poles[i].real > 0.0 and fi == 0.0:
            yield entry(off(0.0) + abs(poles[i].real - exponent.real) / w, "buckling", (i + 1,), 0)
            continue
        for order in _orders(2.0 * fi, w):
            yield entry(abs(2.0 * fi - order * w) / w + 2.0 * off(0.5 * order * w), "direct", (i + 1,), order)
        for j in range(i + 1, len(frequencies)):
            fj = frequencies[j]
            for total, kind in ((fi + fj, "sum"), (fj - fi, "difference"))[: 1 + differences]:
                for order in _orders(total, w):
                    misfit = abs(total - order * w) / w + min(off(fi), off(-fi)) + min(off(fj), off(-fj))
                    yield entry(misfit, kind, (i + 1, j + 1), order)
    for i, pole in enumerate(poles):
        if pole.real > _NOTHING and pole.imag > 0.0:  # the mean system flutters: two modes have met
            yield entry(off(pole.imag), "difference", (i + 1, i + 1), 0)


def _orders(total: float, w: float) -> range:
    """Return the orders k next to total = k w, from 1 on."""
    nearest = round(min(total / w, 1e6))
    return range(max(1, nearest - 1), min(nearest + 2, _HIGHEST_ORDER + 1))
