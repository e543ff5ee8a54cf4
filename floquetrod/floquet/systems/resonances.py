"""Names of growing solutions: which natural frequencies of the mean system combine with the forcing.  A heuristic."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.floquet.systems.result import Resonance

_HIGHEST_ORDER = 40  # of a resonance that is looked for
_MOST_MODES = 60  # of a system whose resonances are named: their number grows with the square
_PER_ORDER = 0.05  # what an order is thought to cost, in detuning relative to w: low orders grow faster
_UNCOUPLED = 0.2  # what it costs that the harmonic of that order does not couple the modes, alike
_NOTHING = 1e-9


def name(system: HillSystem | PeriodicSystem, exponents: tuple[complex, ...]) -> tuple[Resonance, ...]:
    """Return the names of the growing solutions, the fastest first, each name once."""
    equations = system.order if isinstance(system, HillSystem) else 0.5 * system.order
    modes = _mean_modes(system) if equations <= _MOST_MODES else None
    if modes is None or len(modes.poles) > _MOST_MODES:
        return ()
    differences = not isinstance(system, HillSystem) or system.gyroscopic is not None or not system.is_symmetric
    found: dict[tuple[str, tuple[int, ...], int], Resonance] = {}
    for exponent in exponents:
        if exponent.real <= 0.0 or exponent.imag < -_NOTHING:
            continue
        candidates = list(_candidates(modes, exponent, 2.0 * math.pi / float(system.period), differences))
        if candidates:
            _, best = min(candidates, key=lambda pair: pair[0])
            found.setdefault((best.kind, best.modes, best.order), best)
    return tuple(found.values())


class _Modes(NamedTuple):
    """Modes of the mean system, the lowest frequency first.

    Attributes
    ----------
    poles : ndarray (m,) of complex
        An exponent of each, with positive imaginary part where it oscillates.
    up, down : ndarray (m,) of int
        Places of the exponent and of its conjugate in ``coupling``.
    coupling : ndarray (H, N, N)
        How each harmonic couples exponents, both ways, relative to the strongest coupling of that harmonic.
    """

    poles: NDArray[np.complex128]
    up: NDArray[np.intp]
    down: NDArray[np.intp]
    coupling: NDArray[np.float64]


def _mean_modes(system: HillSystem | PeriodicSystem) -> _Modes | None:
    """Return the modes of the mean system; None where they cannot be computed."""
    first = system.as_periodic_system() if isinstance(system, HillSystem) else system
    try:
        values, vectors = np.linalg.eig(first.mean)
        inverse = np.linalg.inv(vectors)
    except np.linalg.LinAlgError:
        return None
    values = values.astype(np.complex128)
    size = float(np.abs(values).max(initial=0.0))
    oscillating = np.flatnonzero(values.imag > _NOTHING * size)
    oscillating = oscillating[np.argsort(values[oscillating].imag, kind="stable")]
    still = np.flatnonzero(np.abs(values.imag) <= _NOTHING * size)
    still = still[np.argsort(-values[still].real, kind="stable")]
    # Real exponents come in pairs, of which the growing one names a mode.
    up = np.concatenate([still[: math.ceil(len(still) / 2)], oscillating])
    partners = np.abs(values[None, :] - values[up][:, None].conj()).argmin(axis=1)
    with np.errstate(all="ignore"):
        forward = np.abs(inverse @ first.harmonics @ vectors)
        backward = np.abs(inverse @ first.harmonics.conj() @ vectors)
        both = np.sqrt(forward * np.swapaxes(backward, -1, -2))
        strongest = both.max(axis=(-2, -1), keepdims=True, initial=0.0)
        coupling = np.nan_to_num(both / strongest)
    return _Modes(values[up], up, partners, coupling)


def _candidates(modes: _Modes, exponent: complex, w: float, differences: bool) -> Iterator[tuple[float, Resonance]]:
    """Yield names with a measure of how badly each fits: detuning and mismatch of the angle, over w, plus its order.

    Without ``differences`` none of that kind: all modes have one Krein sign.
    """
    poles, frequencies = modes.poles, modes.poles.imag

    def off(angle: float) -> float:
        """Distance of the exponent's frequency from an angle, modulo w."""
        return abs((exponent.imag - angle + 0.5 * w) % w - 0.5 * w) / w

    def uncoupled(order: int, one: int, other: int) -> float:
        """Return what it costs that a harmonic does not couple two exponents: several harmonics together might."""
        known = 1 <= order <= len(modes.coupling)
        return _UNCOUPLED if known and modes.coupling[order - 1, one, other] < _NOTHING else 0.0

    def entry(
        misfit: float, kind: Literal["direct", "sum", "difference", "buckling"], members: tuple[int, ...], order: int
    ) -> tuple[float, Resonance]:
        return misfit + _PER_ORDER * order, Resonance(kind, tuple(i + 1 for i in members), order, exponent.real)

    for i, fi in enumerate(frequencies):
        if poles[i].real > 0.0 and fi == 0.0:
            yield entry(off(0.0) + abs(poles[i].real - exponent.real) / w, "buckling", (i,), 0)
            continue
        for order in _orders(2.0 * fi, w):
            misfit = abs(2.0 * fi - order * w) / w + 2.0 * off(0.5 * order * w)
            yield entry(misfit + uncoupled(order, modes.up[i], modes.down[i]), "direct", (i,), order)
        for j in range(i + 1, len(frequencies)):
            fj = frequencies[j]
            angles = min(off(fi), off(-fi)) + min(off(fj), off(-fj))
            for order in _orders(fi + fj, w):
                misfit = abs(fi + fj - order * w) / w + angles + uncoupled(order, modes.up[i], modes.down[j])
                yield entry(misfit, "sum", (i, j), order)
            for order in _orders(fj - fi, w) if differences else ():
                misfit = abs(fj - fi - order * w) / w + angles + uncoupled(order, modes.up[i], modes.up[j])
                yield entry(misfit, "difference", (i, j), order)
    for i, pole in enumerate(poles):
        if pole.real > _NOTHING * abs(pole) and pole.imag > 0.0 and len(poles) > 1:  # two modes of the mean have met
            j = min((k for k in range(len(poles)) if k != i), key=lambda k: abs(frequencies[k] - pole.imag))
            yield entry(off(pole.imag), "difference", (min(i, j), max(i, j)), 0)


def _orders(total: float, w: float) -> range:
    """Return the orders k next to total = k w, from 1 on."""
    nearest = round(min(total / w, 1e6))
    return range(max(1, nearest - 1), min(nearest + 2, _HIGHEST_ORDER + 1))
