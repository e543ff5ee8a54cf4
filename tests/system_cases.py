"""Systems with known growth rates, shared by the tests.

The rates are the largest ln|mu| / T per unit time: enclosed in ball arithmetic to 28 digits and integrated with DOP853.
Coupled Mathieu equations after Hsu, J. Appl. Mech. 30 (1963) 367; the follower load after Herrmann, and Sinha and Wu
(1991); the clamped beam after Bolotin, and Iwatsubo (1974); the blade after Peters and Hohenemser (1971); ground
resonance with one lag damper out in the form of Hammond, J. Am. Helicopter Soc. 19(4) (1974), its data recalled.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

import floquetrod as fr


def coupled(w: float, c: tuple[float, float] = (0.0, 0.0), strength: float = 0.2) -> fr.HillSystem:
    """Two coupled Mathieu equations of natural frequencies 1 and 2."""
    coupling = strength * np.array([[0.5, 1.0], [1.0, 0.8]])
    damping = np.diag([2.0 * c[0], 2.0 * c[1]])
    return fr.HillSystem(np.diag([1.0, 4.0]), cosines=[coupling], damping=damping, period=2.0 * math.pi / w)


def follower(p1: float = 0.6, p2: float = 0.8, w: float = 3.0, b: float = 0.02) -> fr.HillSystem:
    """Return a double pendulum under a pulsating follower load."""
    restoring = np.array([[2.0, -1.0], [-1.0, 1.0]])
    load = np.array([[1.0, -0.5], [0.0, 0.5]])
    mass = [[3.0, 1.0], [1.0, 1.0]]
    return fr.HillSystem(
        restoring - p1 * load, cosines=[-p2 * load], mass=mass, damping=b * restoring, period=2.0 * math.pi / w
    )


def beam(w: float, n: int = 4) -> fr.HillSystem:
    """``n`` Galerkin modes of a clamped beam under the axial load 10 + 8 cos w t."""

    def characteristic(b: float) -> float:
        return math.cos(b) - 1.0 / math.cosh(b)

    b = np.array(
        [
            brentq(characteristic, (i + 0.5) * math.pi - 0.3, (i + 0.5) * math.pi + 0.3, xtol=1e-15, rtol=1e-15)
            for i in range(1, n + 1)
        ]
    )
    s = (np.cosh(b) - np.cos(b)) / (np.sinh(b) - np.sin(b))
    load = np.zeros((n, n))
    for i in range(n):
        for j in range(n):
            if i == j:
                load[i, i] = s[i] * b[i] * (s[i] * b[i] - 2.0)
            elif (i + j) % 2 == 0:
                load[i, j] = -8.0 * b[i] ** 2 * b[j] ** 2 * (s[j] * b[j] - s[i] * b[i]) / (b[j] ** 4 - b[i] ** 4)
    load = 0.5 * (load + load.T)
    return fr.HillSystem(np.diag(b**4) - 10.0 * load, cosines=[-8.0 * load], period=2.0 * math.pi / w)


def blade(m: float, g: float = 12.0, p: float = 1.0) -> fr.PeriodicSystem:
    """Flapping of a rotor blade of Lock number ``g`` at the advance ratio ``m``."""
    mean = [[0.0, 1.0], [-p * p, -g / 8.0]]
    cosine = [[0.0, 0.0], [-g / 8.0 * 4.0 / 3.0 * m, 0.0]]
    sine = [[0.0, 0.0], [0.0, -g / 8.0 * 4.0 / 3.0 * m]]
    return fr.PeriodicSystem(mean, cosines=[cosine], sines=[sine, [[0.0, 0.0], [-g / 8.0 * m * m, 0.0]]])


def ground(speed: float = 18.0) -> fr.PeriodicSystem:
    """Ground resonance of a rotor of four blades, one without its lag damper, at ``speed`` rad/s."""
    blade_mass, moment, inertia, hinge = 94.9, 289.1, 1084.7, 0.3048
    hub, spring, damper = 8026.6, 1240481.8, 51078.7
    lag = np.array([0.0, 4067.5, 4067.5, 4067.5])

    def coefficient(t: float) -> np.ndarray:
        mass, damping, stiffness = np.zeros((6, 6)), np.zeros((6, 6)), np.zeros((6, 6))
        for i, angle in enumerate(speed * t + 0.5 * math.pi * np.arange(4)):
            s, c = math.sin(angle), math.cos(angle)
            mass[i, i], damping[i, i], stiffness[i, i] = inertia, lag[i], hinge * moment * speed**2
            mass[i, 4] = mass[4, i] = -moment * s
            mass[i, 5] = mass[5, i] = moment * c
            stiffness[4, i], stiffness[5, i] = moment * speed**2 * s, -moment * speed**2 * c
            damping[4, i], damping[5, i] = -2.0 * speed * moment * c, -2.0 * speed * moment * s
        for i in (4, 5):
            mass[i, i], damping[i, i], stiffness[i, i] = hub + 4.0 * blade_mass, damper, spring
        right = np.linalg.solve(mass, np.hstack([-stiffness, -damping]))
        return np.vstack([np.hstack([np.zeros((6, 6)), np.eye(6)]), right])

    return fr.PeriodicSystem.from_function(coefficient, 2.0 * math.pi / speed)


def wide() -> fr.HillSystem:
    """Return a pair of multipliers near 1 beside one of 1e+16 and 1e-16."""
    return fr.HillSystem(np.diag([-36.0, 1.0]), cosines=[np.full((2, 2), 0.3)])


CASES: dict[str, tuple[fr.HillSystem | fr.PeriodicSystem, float, str]] = {
    "coupled, w = 3": (coupled(3.0), 0.03532777753665963, "unstable"),
    "coupled, w = 2.95": (coupled(2.95), 0.02512182920908255, "unstable"),
    "coupled, w = 2": (coupled(2.0), 0.02496431619264695, "unstable"),
    "coupled, w = 1": (coupled(1.0), 0.0, "stable"),
    "coupled, damped": (coupled(3.1, (0.002, 0.2)), 0.0027590001070383, "unstable"),
    "coupled, w = 3.1": (coupled(3.1), 0.0, "stable"),
    "follower": (follower(), 0.1094453127093562, "unstable"),
    "beam, w = 40": (beam(40.0), 1.123052773707724, "unstable"),
    "beam, w = 136.25": (beam(136.25), 0.4303691990675693, "unstable"),
    "beam, w = 80": (beam(80.0), 0.0, "stable"),
    "blade, m = 1.5": (blade(1.5), 0.0906136082791130, "unstable"),
    "blade, m = 1": (blade(1.0), -0.75, "stable"),
    "ground resonance": (ground(), 0.0417346158618409, "unstable"),
}
"""Systems, the largest real part of their exponents per unit time, and their status."""
