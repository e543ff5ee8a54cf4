"""Random rods, loads, dampings and tolerances, and their growth by the oracle: formulas owed to Eq. (4) alone."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

import floquetrod as fr
from tests.fuzz import oracle

UNSEEN = 1e-11
"""Growth per unit tau below which a mode is left to the package: the oracle could not see it."""


class Question(NamedTuple):
    """A rod, a load (N, N, rad/s) and a growth tolerance (1/s)."""

    rod: fr.Rod
    mean: float
    amplitude: float
    frequency: float
    tolerance: float

    def __str__(self) -> str:
        """Return it as an expression."""
        rest = f"mean={self.mean!r}, amplitude={self.amplitude!r}, frequency={self.frequency!r}"
        return f"{named(self.rod)}: {rest}, growth_tolerance={self.tolerance!r}"


def named(rod: fr.Rod) -> str:
    """Return the shortest expression for a rod."""
    reference = fr.Rod.nitinol()
    if rod == reference.replace(damping_rate=rod.damping_rate):
        return f"fr.Rod.nitinol().replace(damping_rate={rod.damping_rate!r})"
    return "fr." + repr(rod)


def decades(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a number between ``low`` and ``high``, uniform in its logarithm."""
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def draw_rod(rng: np.random.Generator) -> fr.Rod:
    """Return the reference rod or one about as realistic, with no, little or much damping."""
    rod = fr.Rod.nitinol()
    if rng.random() < 0.7:
        radius = decades(rng, 3e-4, 5e-3)
        gap = radius * decades(rng, 0.3, 10.0)
        rod = fr.Rod(
            decades(rng, 1e9, 2.5e11), decades(rng, 900.0, 9000.0), radius, 1.0, radius + gap, rng.uniform(1.0, 20.0)
        )
        rod = rod.replace(length=decades(rng, 1.5, 14.0) / rod.critical_mode)
    rates = (0.0, decades(rng, 1e-4, 0.05), decades(rng, 0.05, 1.0))
    return rod.replace(damping_rate=rod.pendulum_frequency * float(rng.choice(rates)))


def draw(rng: np.random.Generator) -> Question:
    """Return a question whose load is of the order of the rod's own forces and frequencies."""
    rod = draw_rod(rng)
    unit = rod.critical_force
    mean = float(rng.uniform(-0.2, 1.2)) * unit
    tolerance = float(rng.choice((0.0, decades(rng, 1e-6, 1e-2), decades(rng, 1e-2, 0.1 * rod.pendulum_frequency))))
    return Question(
        rod,
        mean,
        decades(rng, 0.01, 1.2) * unit,
        decades(rng, 0.5, 6.0) * rod.pendulum_frequency,
        tolerance,
    )


def coefficients(rod: fr.Rod, mean: Any, amplitude: Any, frequency: Any, mode: Any) -> tuple[Any, Any]:
    """Return alpha and beta of a mode, Eq. (4) of DOI 10.1115/1.4031710."""
    w2 = (mode * math.pi / rod.length) ** 2
    section = math.pi * rod.radius**2
    rigidity = rod.youngs_modulus * 0.25 * math.pi * rod.radius**4
    inertia = rod.density * section * np.asarray(frequency, dtype=np.float64) ** 2
    weight = rod.density * section * rod.gravity / (rod.channel_radius - rod.radius)
    return w2 * amplitude / inertia, (mean * w2 - rigidity * w2 * w2 - weight) / inertia


def growth(
    rod: fr.Rod,
    mean: ArrayLike,
    amplitude: ArrayLike,
    frequency: ArrayLike,
    mode: ArrayLike,
    accuracy: float = 1e-10,
    unless_below: float = -math.inf,
) -> oracle.Growth:
    """Return net growth rates in 1/s, damping taken off, with their bounds.

    Where energy alone shows that the growth stays at or below ``unless_below`` it is not computed: minus infinity.
    """
    omega = np.asarray(frequency, dtype=np.float64)
    alpha, beta = coefficients(rod, mean, amplitude, omega, np.asarray(mode, dtype=np.float64))
    alpha, b, omega = np.broadcast_arrays(alpha, beta + (rod.damping_rate / omega) ** 2, omega)
    asked = np.atleast_1d(~_quiet(alpha, b, (rod.damping_rate + unless_below) / omega))
    rates = oracle.growth(np.atleast_1d(alpha)[asked], np.atleast_1d(b)[asked], accuracy)
    full = [np.full(asked.shape, -math.inf) for _ in rates]
    for whole, rate in zip(full, rates, strict=True):
        whole[asked] = rate * np.atleast_1d(omega)[asked] - rod.damping_rate
    return oracle.Growth(*(whole.reshape(alpha.shape) for whole in full))


def modes_seen(rod: fr.Rod, mean: Any, amplitude: Any, frequency: Any, tolerance: float) -> list[int]:
    """Return the modes that may grow faster than the tolerance by what the oracle can see, anywhere among the loads.

    Left out is what cannot grow: where b = beta + c^2 < 0 energy gives u <= alpha / (pi sqrt(-b)), and tongue n is
    q^n / (4^(n-1) ((n-1)!)^2) wide (DLMF 28.6(i)) where q is far below n^2.
    """
    omega = np.asarray(frequency, dtype=np.float64)
    found: list[int] = []
    quiet = 0
    for mode in range(1, 2000):
        alpha, beta = coefficients(rod, mean, amplitude, omega, mode)
        alpha, b = np.broadcast_arrays(alpha, beta + (rod.damping_rate / omega) ** 2)
        if _may_grow(alpha, b, (rod.damping_rate + tolerance) / omega):
            found.append(mode)
            quiet = 0
        else:
            quiet += 1
            if quiet > 3 and mode > 2.0 * rod.critical_mode:
                break
    return found


def _may_grow(alpha: Any, b: Any, level: Any) -> bool:
    quiet = _quiet(alpha, b, level)
    if quiet.all():
        return False
    if not (b[~quiet] < 0.0).all():
        return True
    n, q = 2.0 * math.sqrt(float(-b[~quiet].max())), 2.0 * float(alpha.max())
    if n < 2.0 or q > 0.125 * n * n:
        return True
    width = n * math.log(max(q, 1e-300)) - (n - 1.0) * math.log(4.0) - 2.0 * math.lgamma(n)
    return width > math.log(UNSEEN)


def _quiet(alpha: Any, b: Any, level: Any) -> Any:
    """Return where u'^2 - b u^2 grows too slowly for u to grow faster than ``level``."""
    swings = b < 0.0
    return swings & (alpha <= math.pi * np.sqrt(np.where(swings, -b, 1.0)) * level)
