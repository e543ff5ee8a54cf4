"""Systems whose exponents are known by construction, with multipliers over many decades.

x = P(t) exp(R t) with P periodic, of finite Fourier series as is its inverse, makes A = (P' + P R) P^-1 a finite series
and the eigenvalues of R the exponents, up to multiples of i w.  P is a product of rotations of two axes by whole turns
and of shears by a sine, each of which has such an inverse.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import floquetrod as fr


class KnownSystem(NamedTuple):
    """A system, its exponents, and by how much rounding of its coefficients may move these."""

    system: fr.PeriodicSystem
    exponents: NDArray[Any]  # (N,), by falling real parts
    moved: float


def _factor(rng: np.random.Generator, angle: NDArray[Any], n: int) -> tuple[NDArray[Any], ...]:
    """Return a periodic matrix at angles w t, its inverse, and its derivative by the angle, (m, n, n) each."""
    i, j = rng.choice(n, 2, replace=False)
    p = np.broadcast_to(np.eye(n), (len(angle), n, n)).copy()
    inverse, slope = p.copy(), np.zeros(p.shape)
    if rng.random() < 0.5:
        turns = int(rng.integers(1, 3))
        c, s = np.cos(turns * angle), np.sin(turns * angle)
        for matrix, sign in ((p, 1.0), (inverse, -1.0)):
            matrix[:, i, i], matrix[:, j, j], matrix[:, i, j], matrix[:, j, i] = c, c, -sign * s, sign * s
        slope[:, i, i], slope[:, j, j] = -turns * s, -turns * s
        slope[:, i, j], slope[:, j, i] = -turns * c, turns * c
    else:
        size, turn = rng.uniform(-0.8, 0.8), rng.uniform(0.0, 2.0 * math.pi)
        p[:, i, j], inverse[:, i, j] = size * np.sin(angle + turn), -size * np.sin(angle + turn)
        slope[:, i, j] = size * np.cos(angle + turn)
    return p, inverse, slope


def known_system(rng: np.random.Generator, decades: float = 40.0, most: int = 5) -> KnownSystem:
    """Return a random system of 2 to ``most`` equations whose multipliers span up to so many decades."""
    n, period = int(rng.integers(2, most + 1)), float(10.0 ** rng.uniform(-1.0, 1.0))
    w = 2.0 * math.pi / period
    angle = 2.0 * math.pi * np.arange(64) / 64
    reals = rng.uniform(-0.5, 0.5, n) * rng.uniform(0.05, 1.0) * decades * math.log(10.0) / period
    matrix, exponents = np.diag(reals).astype(float), reals.astype(complex)
    if n > 2 and rng.random() < 0.4:  # a pair
        turn = rng.uniform(0.05, 0.45) * w
        matrix[:2, :2] = [[reals[0], -turn], [turn, reals[0]]]
        exponents[:2] = complex(reals[0], turn), complex(reals[0], -turn)
    p, inverse, slope = (np.broadcast_to(m, (64, n, n)) for m in (np.eye(n), np.eye(n), np.zeros((n, n))))
    for _ in range(int(rng.integers(1, 4))):
        q, back, dq = _factor(rng, angle, n)
        slope = slope @ q + p @ dq
        p, inverse = p @ q, back @ inverse
    a = (w * slope + p @ matrix) @ inverse
    waves = np.fft.rfft(a, axis=0) / 64.0
    size = float(np.abs(a).max())
    waves[np.abs(waves) < 1e-15 * size] = 0.0
    kept = 1 + max((k for k in range(1, 32) if waves[k].any()), default=0)
    system = fr.PeriodicSystem(
        waves[0].real, list(2.0 * waves[1:kept].real), list(-2.0 * waves[1:kept].imag), period=period
    )
    spread = float(max(np.linalg.norm(p[k], 2) * np.linalg.norm(inverse[k], 2) for k in range(64)))
    return KnownSystem(system, exponents[np.argsort(-exponents.real)], 64.0 * n * spread * 2.0**-52 * size)


def shifts(found: complex, known: NDArray[Any], w: float) -> NDArray[Any]:
    """Return the distances of an exponent from known ones, multiples of i w aside."""
    gap = found - known
    return np.abs(gap.real + 1j * (gap.imag - w * np.round(gap.imag / w)))


def unmatched(system: KnownSystem, found: Any) -> list[str]:
    """Return which of the exponents that a verdict states are no exponents within their errors, in words."""
    w, wrong = 2.0 * math.pi / float(system.system.period), []
    left = list(range(len(system.exponents)))
    stated = sorted(zip(found.exponents, found.exponent_errors, strict=True), key=lambda one: one[1])
    for exponent, error in stated:
        if exponent != exponent:
            if error < math.inf:
                wrong.append(f"NaN with the error {error}")
            continue
        if not error < math.inf:
            wrong.append(f"{exponent} with an infinite error")
            continue
        away = shifts(exponent, system.exponents[left], w)
        nearest = int(away.argmin())
        if away[nearest] > error + system.moved:
            wrong.append(f"{exponent} +- {error}, nearest {system.exponents[left[nearest]]}")
        left.pop(nearest)
    return wrong
