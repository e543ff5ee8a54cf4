"""When motion returns to its start, at all or except for coordinates that grow, such as angles."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.equations import NonlinearSystem

CLOSE = 0.02  # gap, part of the motion, up to which motion that settles is near enough (a choice)
_TURN = 2.0 * math.pi
_PERIODS = 10  # over whose halves motion that has settled grows alike
_ALIKE = 1e-3  # of the growth, by which halves may differ (a choice)
_INVARIANT = 1e-9  # of the rates, up to which they do not depend on a shift


def returned(times: Floats, states: Floats, rates: Floats) -> float | None:
    """Return the time since motion last was near where it ends, moving the same way; None where it was not."""
    size = sizes(states)
    ahead = ((states - states[-1]) / size) @ (rates[-1] / size)
    crossings = np.flatnonzero((ahead[:-1] < 0.0) & (ahead[1:] >= 0.0))[::-1]
    crossings = crossings[crossings < len(times) - 3]
    for i in crossings:
        share = -ahead[i] / (ahead[i + 1] - ahead[i])
        there = states[i] + share * (states[i + 1] - states[i])
        if float((np.abs(there - states[-1]) / sizes(states[i:])).max()) < 2.0 * CLOSE:
            return float(times[-1] - times[i] - share * (times[i + 1] - times[i]))
    return None


def sizes(states: Floats) -> Floats:
    """Return how far motion goes in each of its components, not less than 1e-6 of the largest magnitude of them all.

    In an invariant plane a component is 0 except for errors of the integration.
    """
    return np.asarray(np.maximum(np.ptp(states, axis=0), 1e-6 * float(np.abs(states).max()) + 1e-300))


def require_no_rotation(
    system: NonlinearSystem, times: Floats, states: Floats, rates: Floats, march: Callable[[Floats, float], Floats]
) -> None:
    """Raise ValueError where motion has settled to one that returns except for coordinates that grow.

    ``march`` gives the states of the motion from a state over a time.
    """
    drifting = np.flatnonzero(np.abs(states[-1] - states[0]) > _TURN).tolist()
    angles = [j for j in drifting if _is_invariant(system, times, states, j, _TURN)]
    if not angles:
        return
    free = [j for j in angles if _is_invariant(system, times, states, j, 1.0)]  # whose value does not matter
    turning, others = [j for j in angles if j not in free], [j for j in range(states.shape[1]) if j not in angles]
    x, v = states[:, turning], rates[:, turning]
    seen = np.concatenate([states[:, others], np.cos(x), np.sin(x)], axis=1)
    speeds = np.concatenate([rates[:, others], -v * np.sin(x), v * np.cos(x)], axis=1)
    period = returned(times, seen, speeds) if seen.shape[1] else None
    if period is None:
        return
    later = march(states[-1], _PERIODS * period)[:, angles]
    halves = np.diff(later[[0, (len(later) - 1) // 2, -1]], axis=0)
    if (np.abs(halves[1] - halves[0]) > _ALIKE * np.abs(halves).max(axis=0)).any():
        return
    growth = halves.sum(axis=0) / _PERIODS
    raise ValueError(_cause(angles, free, growth, period))


def _is_invariant(system: NonlinearSystem, times: Floats, states: Floats, j: int, shift: float) -> bool:
    """Return whether the rates do not change with a shift of one coordinate."""
    some = slice(None, None, max(1, len(states) // 20))
    moved = states[some].copy()
    moved[:, j] += shift
    rates = system.rates(times[some], states[some])
    gaps = np.abs(system.rates(times[some], moved) - rates)
    return bool((gaps <= _INVARIANT * np.abs(rates).max()).all())


def _cause(angles: list[int], free: list[int], growth: Floats, period: float) -> str:
    """Return what grows, by how much, and the way out, in words."""
    turns = np.rint(growth / _TURN).astype(int).tolist()
    sizes_in_turns = {n: f"{n} * 2 pi" for n in turns} | {1: "2 pi", -1: "-2 pi"}
    grown = [
        f"state {j} grows by {f'{growth[k]:.6g}' if j in free else sizes_in_turns[turns[k]]}"
        for k, j in enumerate(angles)
    ]
    ways = [f"leave state {j} out, nothing depends on it" for j in free]
    if len(free) < len(angles):
        given = ", ".join(f"{j}: {turns[k]} * 2 * math.pi" for k, j in enumerate(angles) if j not in free)
        ways.append(f"give winding={{{given}}}")
    return (
        f"start leads to motion that rotates: {', '.join(grown)} in every period of about {period:.6g}, so that it is "
        f"no periodic orbit; {'; '.join(ways)}"
    )
