"""Responses to forces: one answer, a spectrum, a map of loads and a covariance, beside DOP853 with a linear solve."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import floquetrod as fr
from benchmarks.measure import Row, best_of
from floquetrod.responses.many import scalar_responses

_POINTS, _LOADS = 400, 100


def run() -> list[Row]:
    """Return times, ours and those of DOP853 at rtol 1e-12."""
    equation = fr.Mathieu(0.3, -0.6, 0.01)
    pair = fr.HillSystem([[1.0, 0.0], [0.0, 4.0]], [[[0.1, 0.2], [0.2, 0.16]]], damping=np.diag([0.02, 0.03]))
    amplifier = fr.HillSystem([[1.0]], sines=[[[0.03]]], damping=[[0.02]], period=math.pi)
    frequencies = np.linspace(0.9, 1.1, _POINTS)
    rng = np.random.default_rng(1)
    beta = -rng.uniform(0.3, 30.0, _LOADS**2)
    alpha, damping = 0.3 * rng.random(_LOADS**2) * -beta, rng.uniform(0.01, 0.1, _LOADS**2)

    def single(t: float, x: Any) -> Any:
        return [x[1], (-0.6 + 0.3 * math.sin(t)) * x[0] - 0.02 * x[1] + 1.0]

    def coupled(t: float, x: Any) -> Any:
        force = pair.stiffness @ x[:2] + math.cos(t) * (pair.cosines[0] @ x[:2])
        return np.concatenate([x[2:], [1.0, 0.5] - force - [0.02 * x[2], 0.03 * x[3]]])

    def wave(t: float, x: Any, w: float) -> Any:
        return [x[1], np.exp(1j * w * t) - (1.0 + 0.03 * math.sin(2.0 * t)) * x[0] - 0.02 * x[1]]

    def largest_of_pair() -> Any:
        return fr.response(pair, [1.0, 0.5]).largest

    ours = {
        "one equation, largest": best_of(lambda: fr.response(equation, 1.0).largest),
        "one oscillator as a system": best_of(lambda: fr.response(amplifier, 1.0).largest),
        "two coupled equations": best_of(largest_of_pair),
        f"spectrum of {_POINTS} frequencies": best_of(lambda: fr.gain(amplifier, frequency=frequencies)),
        f"{_LOADS} x {_LOADS} equations, largest": best_of(
            lambda: scalar_responses(beta, -1j * alpha[:, None], damping, 1.0, 1.0), 3
        ),
    }
    one = best_of(lambda: _marched(single, 2.0 * math.pi, 2), 3)
    peers = [
        one,
        best_of(lambda: _marched(lambda t, x: wave(t, x, 0.0), math.pi, 2, complex), 3),
        best_of(lambda: _marched(coupled, 2.0 * math.pi, 4), 3),
        _POINTS * best_of(lambda: _marched(lambda t, x: wave(t, x, 0.97), math.pi, 2, complex, 0.97), 3),
        _LOADS**2 * one,
    ]
    targets = (0.2, 0.2, 0.2, 20.0, 2000.0)
    return [
        Row(name, 1e3 * seconds, "ms", "DOP853", 1e3 * peer, at_most=target)
        for (name, seconds), peer, target in zip(ours.items(), peers, targets, strict=True)
    ]


def _marched(
    rates: Callable[[float, Any], Any], period: float, states: int, kind: Any = float, w: float = 0.0
) -> float:
    """Return the largest first coordinate at 100 instants of the steady motion, by maps that DOP853 marches."""
    times = np.linspace(0.0, period, 101)
    ends = [
        solve_ivp(rates, (0.0, period), np.array(start, dtype=kind), "DOP853", times, rtol=1e-12, atol=1e-13).y
        for start in (np.zeros(states), *np.eye(states))
    ]
    maps = np.stack([end - ends[0] for end in ends[1:]], axis=1)
    turn = np.exp(1j * w * period) if w else 1.0
    start = np.linalg.solve(turn * np.eye(states) - maps[:, :, -1], ends[0][:, -1])
    return float(np.abs(ends[0] + np.einsum("ijt,j->it", maps, start))[0].max())
