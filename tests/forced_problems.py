"""Drawn problems under forces, and their steady motion by DOP853."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

import floquetrod as fr


class Forced(NamedTuple):
    """A problem, and the arguments of its force."""

    equation: Any
    force: Any
    options: dict[str, Any]

    @property
    def order(self) -> int:
        """Number of coordinates."""
        return 1 if isinstance(self.equation, fr.equations.Equation) else int(self.equation.order)


def drawn(seed: int) -> Forced:
    """Return an equation or a system, with a constant, periodic or other force."""
    rng = np.random.default_rng(seed)
    kind = seed % 3
    if kind == 0:
        size = 10.0 ** rng.uniform(-1.0, 1.3)
        damping = 10.0 ** rng.uniform(-2.0, -0.3) * math.sqrt(size)
        equation: Any = fr.Hill(
            -size,
            tuple(rng.normal(size=2) * 0.15 * size),
            tuple(rng.normal(size=rng.integers(0, 3)) * 0.15 * size),
            period=float(rng.uniform(0.5, 7.0)),
            damping=float(damping),
        )
        n = 1
    else:
        n = int(rng.integers(1, 4))
        root = rng.normal(size=(n, n))
        if kind == 1:
            stiffness = root @ root.T + np.diag(rng.uniform(0.5, 8.0, n))
            mass = np.eye(n) + 0.1 * (root @ root.T)
            mass = 0.5 * (mass + mass.T)
            gyro = rng.normal(size=(n, n)) * 0.2
            equation = fr.HillSystem(
                stiffness,
                [0.1 * rng.normal(size=(n, n)) for _ in range(2)],
                [0.1 * rng.normal(size=(n, n))],
                mass=mass,
                damping=0.3 * np.eye(n) + 0.05 * root @ root.T,
                gyroscopic=gyro - gyro.T,
                period=float(rng.uniform(0.5, 6.0)),
            )
        else:
            equation = fr.PeriodicSystem(
                rng.normal(size=(n, n)) - (1.0 + n) * np.eye(n),
                [0.5 * rng.normal(size=(n, n))],
                [0.5 * rng.normal(size=(n, n)) for _ in range(2)],
                period=float(rng.uniform(0.5, 6.0)),
            )
    force = rng.normal(size=n)
    options: dict[str, Any] = {}
    what = int(rng.integers(0, 3))
    if what == 1:
        options = {"cosines": [rng.normal(size=n)], "sines": [rng.normal(size=n), rng.normal(size=n)]}
    elif what == 2:
        options = {"frequency": float(rng.uniform(0.0, 6.0))}
        force = force + 1j * rng.normal(size=n)
    if kind == 0 and what == 1:
        options = {name: [float(v[0]) for v in values] for name, values in options.items()}
    return Forced(equation, force, options)


def values_of(forced: Forced, t: float) -> Any:
    """Return the force at a time."""
    options, force = forced.options, np.atleast_1d(forced.force)
    if "frequency" in options:
        return force * np.exp(1j * options["frequency"] * t)
    turn = 2.0 * math.pi / float(forced.equation.period)
    total = force.real.astype(float)
    for k, value in enumerate(options.get("cosines", ()), start=1):
        total = total + np.atleast_1d(value) * math.cos(k * turn * t)
    for k, value in enumerate(options.get("sines", ()), start=1):
        total = total + np.atleast_1d(value) * math.sin(k * turn * t)
    return total


def matrices_of(forced: Forced) -> tuple[Any, Any]:
    """Return A(t) of the state (q, q') or x as mean and Fourier coefficients, and what the force acts on."""
    equation, n = forced.equation, forced.order
    if isinstance(equation, fr.PeriodicSystem):
        series = [(k, equation.cosines, equation.sines) for k in range(max(len(equation.cosines), len(equation.sines)))]
        waves = [(_at(c, k, n), _at(s, k, n)) for k, c, s in series]
        return (equation.mean, waves), np.eye(n)
    if isinstance(equation, fr.HillSystem):
        mass = np.eye(n) if equation.mass is None else equation.mass
        rates = sum((m for m in (equation.damping, equation.gyroscopic) if m is not None), np.zeros((n, n)))
        mean, cosines, sines = equation.stiffness, equation.cosines, equation.sines
    else:
        mass, rates, mean = np.eye(1), np.array([[2.0 * equation.damping]]), np.array([[-equation.mean]])
        cosines, sines = ([np.array([[-v]]) for v in values] for values in (equation.cosines, equation.sines))
    inverse = np.linalg.inv(mass)

    def lower(stiffness: Any) -> Any:
        whole = np.zeros((2 * n, 2 * n))
        whole[n:, :n] = -inverse @ stiffness
        return whole

    first = lower(mean)
    first[:n, n:], first[n:, n:] = np.eye(n), -inverse @ rates
    count = max(len(cosines), len(sines))
    return (first, [(lower(_at(cosines, k, n)), lower(_at(sines, k, n))) for k in range(count)]), np.concatenate(
        [np.zeros((n, n)), inverse]
    )


def _at(series: Any, k: int, n: int) -> Any:
    return series[k] if k < len(series) else np.zeros((n, n))


def by_dop853(forced: Forced, parts: int = 16) -> tuple[Any, Any]:
    """Return the steady motion (parts + 1, n) at equal times over a period, from its start by a linear solve."""
    n, period = forced.order, float(forced.equation.period)
    states = n if isinstance(forced.equation, fr.PeriodicSystem) else 2 * n
    times = np.linspace(0.0, period, parts + 1)
    real = "frequency" not in forced.options
    start = np.concatenate([np.zeros((states, 1)), np.eye(states)], axis=1)

    (mean, waves), into = matrices_of(forced)
    turn = 2.0 * math.pi / period

    def rates(t: float, flat: Any) -> Any:
        columns = flat.reshape(states, states + 1)
        matrix = mean
        for k, (cosine, sine) in enumerate(waves, start=1):
            matrix = matrix + math.cos(k * turn * t) * cosine + math.sin(k * turn * t) * sine
        result = matrix @ columns
        result[:, 0] += into @ values_of(forced, t)
        return result.ravel()

    initial = start.ravel() if real else start.ravel().astype(complex)
    run = solve_ivp(rates, (0.0, period), initial, "DOP853", times, rtol=3e-14, atol=1e-15)
    columns = run.y.reshape(states, states + 1, len(times))
    factor = np.exp(1j * forced.options.get("frequency", 0.0) * period)
    first = np.linalg.solve(factor * np.eye(states) - columns[:, 1:, -1], columns[:, 0, -1])
    motion = columns[:, 0] + np.einsum("ijt,j->it", columns[:, 1:], first)
    return times, motion[:n].T
