"""Periodic orbits: known ones, what is stated of their errors, and bad input."""

from __future__ import annotations

import math
import pickle
from typing import Any

import numpy as np
import pytest

import floquetrod as fr


def van_der_pol(t: Any, x: Any, mu: float) -> Any:
    return x[1], mu * (1 - x[0] ** 2) * x[1] - x[0]


def lorenz(t: Any, x: Any, s: float, r: float, b: float) -> Any:
    return s * (x[1] - x[0]), x[0] * (r - x[2]) - x[1], x[0] * x[1] - b * x[2]


def duffing(t: Any, x: Any, omega: float) -> Any:
    return x[1], np.cos(omega * t) - 0.2 * x[1] - x[0] - x[0] ** 3


VAN_DER_POL = fr.NonlinearSystem(van_der_pol, parameters={"mu": 1.0})
LORENZ = fr.NonlinearSystem(lorenz, parameters={"s": 10.0, "r": 28.0, "b": 8.0 / 3.0})
DUFFING = fr.NonlinearSystem(duffing, period="2*pi/omega", parameters={"omega": 1.2})
AB = [-13.763610682134, -19.578751942452, 27.0]

# Period and multipliers by DOP853 at 3e-14 with Newton's method on the return map; the small one of van der Pol's
# equation with mu = 3 from the integral of mu (1 - x^2) along it, the same way.
KNOWN = [
    (VAN_DER_POL, [2.0, 0.0], None, 6.663286859323131, [8.59695064e-4]),
    (VAN_DER_POL.with_parameters(mu=3.0), [2.0, 0.0], None, 8.859095499719906, [6.98947562608e-16]),
    (LORENZ, AB, 1.5586, 1.5586522107161747, [4.71294727, 1.19e-10]),
    (DUFFING, [1.0, 0.0], None, 2.0 * math.pi / 1.2, [-0.51519043 + 0.29240148j, -0.51519043 - 0.29240148j]),
]


@pytest.mark.parametrize(("system", "start", "near", "period", "multipliers"), KNOWN)
def test_known_orbits(system: Any, start: Any, near: Any, period: float, multipliers: list[complex]) -> None:
    orbit = fr.periodic_orbit(system, start, near)
    assert abs(orbit.period - period) < 1e-11
    assert orbit.period_error < 1e-11
    verdict = orbit.stability
    for mu, known in zip(sorted(verdict.multipliers, key=abs), sorted(multipliers, key=abs), strict=True):
        nearest = min(multipliers, key=lambda each: abs(each - mu))
        assert abs(mu - nearest) < max(1e-8 * max(map(abs, multipliers)) * (abs(known) > 0.1), 2e-3 * abs(nearest) * 5)
    assert verdict.status == ("unstable" if max(map(abs, multipliers)) > 1.0 else "stable")
    trivial = orbit.trivial_multiplier_less_1
    assert trivial is None if system is DUFFING else trivial < 1e-12


def test_the_size_of_an_orbit() -> None:
    orbit = fr.periodic_orbit(DUFFING, [1.0, 0.0])
    angles = np.linspace(0.0, orbit.period, 20_001)
    assert abs(np.abs(orbit(angles)[:, 0]).max() - 1.29374591) < 1e-8
    series = sum((orbit.harmonics[k] * np.exp(1j * k * 1.2 * 0.7)).real for k in range(len(orbit.harmonics)))
    assert np.abs(series - orbit(0.7)).max() < 1e-10


def test_an_orbit_is_kept() -> None:
    orbit = fr.periodic_orbit(DUFFING, [1.0, 0.0])
    again = pickle.loads(pickle.dumps(orbit))
    assert again == orbit
    assert again.stability.multipliers == orbit.stability.multipliers
    assert "two degrees" in str(orbit)


@pytest.mark.parametrize(
    ("function", "start", "message"),
    [
        (lambda t, x: (x[1],), [1.0, 0.0], "function must return 2 rates"),
        (lambda t, x: (x[1], math.nan), [1.0, 0.0], "function must return finite rates"),
        (lambda t, x: None, [1.0, 0.0], "got None"),
        (lambda t, x: (x[1], np.cos(0.7 * t) - x[0]), [1.0, 0.0], "function is not periodic in 1"),
        (lambda t, x: (x[0] ** 2,), [1.0], "start flows away"),
    ],
)
def test_functions_that_are_not_as_they_should_be(function: Any, start: Any, message: str) -> None:
    with pytest.raises((ValueError, TypeError), match=message):
        fr.periodic_orbit(fr.NonlinearSystem(function, period=1.0), start)
