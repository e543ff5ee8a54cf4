"""Systems whose exponents are known exactly: no method states an error that leaves them out, nor grows from nothing."""

from __future__ import annotations

import cmath
import math
import warnings
from typing import Any

import numpy as np

import floquetrod as fr
from floquetrod.floquet.registry import applicable
from tests.fuzz.core import limit
from tests.fuzz.system_draws import decades

_ROUNDING = 1e-14  # of exponents times the period: they are doubles


def draw(rng: np.random.Generator) -> tuple[Any, list[complex]]:
    """Return a system and its exponents times the period.

    Triangular systems of first order, whose exponents are the means of their diagonals, in any order of coordinates;
    and systems that are constant, B, in coordinates that turn by half a turn in a period.
    """
    period = decades(rng, 0.5, 8.0)
    if rng.random() < 0.3:
        b = rng.normal(size=(2, 2)) * decades(rng, 1e-3, 1.0)
        b[1, 1] = -b[0, 0] if rng.random() < 0.5 else b[1, 1]
        p, q = 0.5 * (b[0, 0] + b[1, 1]), 0.5 * (b[0, 0] - b[1, 1])
        r, s = 0.5 * (b[0, 1] + b[1, 0]), 0.5 * (b[1, 0] - b[0, 1])
        mean = np.array([[p, -s], [s, p]])
        waves = [np.array([[q, r], [r, -q]])], [np.array([[-r, q], [q, r]])]
        root = cmath.sqrt((period * q) ** 2 + (period * r) ** 2 - (period * s - math.pi) ** 2)
        # Rounding of the sums may make the system another by as much.
        doubt = 8.0 * np.finfo(float).eps * period * float(np.abs(b).sum())
        system = fr.PeriodicSystem(mean, *waves, period=period, coefficient_error=doubt / period)
        return system, [period * p + sign * root + math.pi * 1j for sign in (1.0, -1.0)]
    n, count = int(rng.integers(1, 4)), int(rng.integers(1, 3))
    means = rng.choice([0.0, 0.0, -1e-300, -0.25], n)
    places = np.triu(np.ones((n, n)), 1) * (rng.random() < 0.7)
    mean = np.diag(means) + places * rng.normal(size=(n, n))
    size = decades(rng, 1e-2, 2.0)
    waves = size * rng.normal(size=(2, count, n, n)) * (places + np.eye(n))
    order = rng.permutation(n)
    turned = np.ix_(order, order)
    system = fr.PeriodicSystem(
        mean[turned], [w[turned] for w in waves[0]], [w[turned] for w in waves[1]], period=period
    )  # fmt: skip
    return system, [complex(period * m) for m in means]


def disagreements(rng: np.random.Generator) -> list[str]:
    """Return what is wrong about answers on one system of known exponents, each on a line."""
    system, exact = draw(rng)
    lines = []
    for method in ("auto", *(method.name for method in applicable(system))):
        with limit(60.0):
            lines += [f"{method}: {line}" for line in against(fr.stability(system, method), exact)]
    with limit(60.0), warnings.catch_warnings():
        warnings.simplefilter("ignore", fr.UndecidedWarning)
        stable, rate = fr.systems.is_stable(system), fr.systems.growth_rate(system)
    largest = max(e.real for e in exact)
    if (stable and largest > _ROUNDING) or rate * system.period > max(largest, 0.0) + 1e-4:
        lines.append(f"is_stable {stable}, growth_rate {rate!r}, exactly {largest / system.period!r}")
    return [f"{system!r} {exact}: {line}" for line in lines]


def against(result: Any, exact: list[complex]) -> list[str]:
    """Return how a result contradicts exact exponents times the period."""
    lines = []
    largest = max(e.real for e in exact)
    if result.status == "unstable" and largest <= 0.0 and result.growth_rate > 0.0:
        lines.append(f"unstable, grows at {result.growth_rate!r} +- {result.error:.3g}, exactly {largest!r}")
    if result.status == "stable" and (largest > 0.0 or (largest == 0.0 and result.structure == "general")):
        lines.append(f"stable, exactly {largest!r} by the period")
    for exponent, error in zip(result.exponents, result.exponent_errors, strict=True):
        gaps = [exponent * result.period - e for e in exact]
        away = min(math.hypot(g.real, (g.imag + math.pi) % (2.0 * math.pi) - math.pi) for g in gaps)
        slack = _ROUNDING * (1.0 + max(abs(e) for e in exact))
        if exponent.imag == 0.0 and largest == 0.0 and len(exact) == 1:
            slack = 0.0  # nothing is rounded
        if away > error * result.period * (1.0 + 1e-9) + slack:
            lines.append(f"exponent {exponent!r} +- {error:.3g}, {away / result.period:.3g} from any")
    return lines
