"""Critical kicks against scans of 4,000 kicks, what is proved against both, and fates against DOP853 with events."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

import floquetrod as fr
from tests.fuzz import oracle, rods
from tests.fuzz.core import Found, limit

CASES = 12
QUICK = 1

AT_ONCE = 10
"""Equations of a case."""

SCAN = 4000
TOO_HIGH = 0.003
"""Relative excess over the smallest kick of the scan that a critical kick may have."""

_MISSES = 2  # of AT_ONCE, where one in two hundred is expected


def check(rng: np.random.Generator) -> Found:
    """Compare critical kicks with scans, and some fates with an integration by scipy."""
    points = np.array([growing(rng) for _ in range(AT_ONCE)]).T
    with limit():
        found = fr.friction.critical_kick(points[0], points[1], damping=points[2]).smallest_found
    failures, misses = [], 0
    for *point, value in zip(*points, np.asarray(found, dtype=np.float64), strict=True):
        alpha, beta, c = map(float, point)
        line = f"fr.friction.critical_kick({alpha!r}, {beta!r}, damping={c!r}).smallest_found = {float(value)!r}"
        wrong, missed = compare(alpha, beta, c, float(value), rng)
        misses += missed
        failures += [f"{line}: {what}" for what in wrong]
        failures += [
            f"fr.friction.fates({alpha!r}, {beta!r}, 1.0, kick, damping={c!r}): {w}" for w in fate(alpha, beta, c, rng)
        ]
    if misses > _MISSES:
        failures.append(f"{misses} of {AT_ONCE} critical kicks are not the smallest of a scan: {points.tolist()}")
    return Found(2 * AT_ONCE, failures)


def growing(rng: np.random.Generator) -> tuple[float, float, float]:
    """Return alpha, beta and damping of an equation that grows at a healthy rate without friction."""
    while True:
        alpha, beta = rods.decades(rng, 0.05, 5.0), float(rng.uniform(-4.0, 1.0))
        c = float(rng.choice([0.0, rods.decades(rng, 1e-3, 0.1)]))
        if float(oracle.growth(alpha, beta + c * c).low) - c > 0.01:
            return alpha, beta, c


def compare(alpha: float, beta: float, c: float, found: float, rng: np.random.Generator) -> tuple[list[str], bool]:
    """Return what is wrong about a critical kick, and whether a smaller kick escapes at all."""
    if not math.isfinite(found):
        return ["no number, where growth is healthy"], False
    low, high = fr.friction.certain_kicks(fr.FrictionalMathieu(alpha, beta, 1.0, c))
    wrong = []
    if not low * (1.0 - 1e-12) <= found <= high * (1.0 + 1e-6):
        wrong.append(f"lies outside what is proved, {(low, high)}")
    kicks = 0.9 * low * (1.2 * max(found, high) / low) ** np.sort(rng.random(SCAN))
    if math.isinf(high):
        kicks = 0.9 * low * (2.0 * found / low) ** np.sort(rng.random(SCAN))
    kicks[-1] = found * (1.0 + 1e-6)
    fates: NDArray[Any] = fr.friction.fates(alpha, beta, 1.0, kicks, damping=c)
    escapes = kicks[fates == fr.friction.ESCAPES]
    if (escapes <= low).any() or (kicks[fates == fr.friction.BOUNDED] > high * (1.0 + 1e-9)).any():
        wrong.append(f"a kick contradicts what is proved, {(low, high)}")
    smallest = float(escapes.min(initial=math.inf))
    if smallest == math.inf:
        wrong.append("no kick of the scan escapes, not even that just above")
    if found > smallest * (1.0 + TOO_HIGH):
        wrong.append(f"{found / smallest - 1.0:.2%} too high: {smallest!r} escapes")
    return wrong, found > smallest * (1.0 + 1e-6)


def fate(alpha: float, beta: float, c: float, rng: np.random.Generator) -> list[str]:
    """Compare one kick with its integration; a kick on an edge of the fractal is no question."""
    low, high = fr.friction.certain_kicks(fr.FrictionalMathieu(alpha, beta, 1.0, c))
    kick = rods.decades(rng, low, min(high, 100.0 * low))
    near = fr.friction.fates(alpha, beta, 1.0, kick * (1.0 + np.linspace(-1e-7, 1e-7, 9)), damping=c)
    if near.min() != near.max() or near[0] == fr.friction.UNDECIDED:
        return []
    escapes = integrate(alpha, beta, c, kick, high)
    if escapes is not None and (near[0] == fr.friction.ESCAPES) != bool(escapes):
        return [f"kick {kick!r} gives {int(near[0])}, DOP853 with events that it {'escapes' if escapes else 'sticks'}"]
    return []


def integrate(alpha: float, beta: float, c: float, kick: float, certain: float, periods: int = 30) -> int | None:
    """Return 1 when the motion outgrows all friction, 0 when it sticks for ever, None where that is not seen."""
    from scipy.integrate import solve_ivp

    tau, a, sign = 0.0, 0.0, 1.0
    velocity = kick
    end = 2.0 * math.pi * periods
    for _ in range(40 * periods):
        if abs(a) + abs(velocity) > 1e5 * certain:
            return 1

        def motion(t: float, state: Any, sign: float = sign) -> list[float]:
            return [state[1], (beta + alpha * math.sin(t)) * state[0] - sign - 2.0 * c * state[1]]

        def stop(t: float, state: Any, sign: float = sign, start: float = tau) -> float:
            return sign * state[1] if t > start + 1e-9 else 1.0

        def far(t: float, state: Any) -> float:
            return abs(state[0]) + abs(state[1]) - 1e6 * certain

        stop.terminal, stop.direction, far.terminal = True, -1.0, True  # type: ignore[attr-defined]
        done = solve_ivp(
            motion, (tau, end), [a, velocity], "DOP853", events=[stop, far], rtol=1e-11, atol=1e-12, max_step=0.3
        )
        tau, (a, velocity) = float(done.t[-1]), map(float, done.y[:, -1])
        if done.t_events[1].size:
            return 1
        if not done.t_events[0].size:
            return None
        velocity = 0.0
        if abs(a) * (abs(alpha) + abs(beta)) <= 1.0:
            return 0
        tau = _released(alpha, beta, a, tau, end)
        if tau >= end:
            return None
        sign = math.copysign(1.0, (beta + alpha * math.sin(tau)) * a)
    return None


def _released(alpha: float, beta: float, a: float, tau: float, end: float) -> float:
    """Return when the pull on a motion at rest next exceeds friction."""
    from scipy.optimize import brentq

    def surplus(t: float) -> float:
        return abs((beta + alpha * math.sin(t)) * a) - 1.0

    if surplus(tau) > 0.0:
        return tau
    times = np.arange(tau, min(end, tau + 2.0 * math.pi) + 0.01, 0.01)
    over = np.flatnonzero(np.abs((beta + alpha * np.sin(times)) * a) > 1.0)
    if not over.size:
        return end
    at = float(brentq(surplus, times[over[0] - 1], times[over[0]]))
    return at + 1e-9
