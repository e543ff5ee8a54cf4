"""Periodic orbits: known ones, what is stated of their errors, and bad input."""

from __future__ import annotations

import math
import pickle
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import floquetrod as fr
from floquetrod.orbits.collocation import BorderRow, Collocation
from floquetrod.orbits.newton import corrected
from tests.conftest import depth


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


@pytest.mark.parametrize("tolerance", [1e-3, pytest.param(1e-6, marks=pytest.mark.slow)])
def test_errors_cover_the_truth(tolerance: float) -> None:
    for system, start, near, period, _ in KNOWN[:2] + KNOWN[3:]:
        orbit, exact = (fr.periodic_orbit(system, start, near, tolerance=each) for each in (tolerance, 1e-12))
        times = np.linspace(0.0, orbit.period, 301)
        if system is DUFFING:  # the phase of the others is free
            gap = float((np.abs(orbit(times) - exact(times)) / orbit.point.scale).max())
            assert 1e-15 < gap <= orbit.error < 10.0 * tolerance
        assert abs(orbit.period - period) <= orbit.period_error + exact.period_error
        found = zip(orbit.stability.multipliers, orbit.stability.multiplier_errors, strict=True)
        for (mu, error), true in zip(found, exact.stability.multipliers, strict=True):
            assert abs(mu - true) <= error + 1e-25


def test_the_linearised_system_has_the_multipliers() -> None:
    orbit = fr.periodic_orbit(DUFFING, [1.0, 0.0])
    other = fr.stability(orbit.linearised)
    assert other.status == orbit.status
    found, known = orbit.stability, np.array(other.multipliers)
    for mu, error in zip(found.multipliers, found.multiplier_errors, strict=True):
        nearest = int(np.abs(known - mu).argmin())
        assert abs(mu - known[nearest]) <= error + other.multiplier_errors[nearest] < 1e-8


def test_an_orbit_starts_from_a_record_of_motion_and_from_another_orbit() -> None:
    orbit = fr.periodic_orbit(VAN_DER_POL, [2.0, 0.0])
    times = np.linspace(3.0, 25.0, 600)
    again = fr.periodic_orbit(VAN_DER_POL, (times, orbit(times) + 1e-3 * np.sin(50.0 * times)[:, None]))
    assert abs(again.period - orbit.period) < 1e-12
    moved = fr.periodic_orbit(VAN_DER_POL.with_parameters(mu=1.05), orbit)
    assert moved.period > orbit.period + 1e-3
    forced = fr.periodic_orbit(DUFFING, [1.0, 0.0])
    times = np.linspace(7.3, 16.0, 300)
    assert np.abs(fr.periodic_orbit(DUFFING, (times, forced(times))).states[0] - forced.states[0]).max() < 1e-11


@pytest.mark.parametrize(
    "field",
    [
        lambda t, x: (x[1], -x[0] - x[0] ** 3),  # the periods differ: deviations grow linearly
        lambda t, x: (x[0] * (1.0 - x[1]), x[1] * (x[0] - 1.0)),
    ],
)
def test_the_verdict_on_an_orbit_of_a_conservative_system_is_undecided(field: Any) -> None:
    orbit = fr.periodic_orbit(fr.NonlinearSystem(field), [1.2, 1.0], period=6.0)
    assert orbit.status == "undecided"
    assert not orbit.stability.strongly_stable
    assert "another one is 1 to rounding" in str(orbit)


def test_an_orbit_of_a_linear_oscillator_is_stable_but_not_strongly() -> None:
    orbit = fr.periodic_orbit(fr.NonlinearSystem(lambda t, x: (x[1], -x[0])), [1.2, 1.0], period=6.0)
    assert orbit.status == "stable"
    assert not orbit.stability.strongly_stable


def test_orbits_of_a_conservative_system_form_a_family() -> None:
    """The period of the pendulum by the arithmetic-geometric mean; its multipliers are both 1."""
    system = fr.NonlinearSystem(lambda t, x: (x[1], -np.sin(x[0])))
    orbit = fr.periodic_orbit(system, [1.0, 0.0])
    energy = 0.5 * orbit.states[0, 1] ** 2 - math.cos(orbit.states[0, 0])  # -cos of the amplitude
    a, b = 1.0, math.sqrt(0.5 * (1.0 - energy))
    for _ in range(6):
        a, b = 0.5 * (a + b), math.sqrt(a * b)
    assert abs(orbit.period - 2.0 * math.pi / a) < 1e-11
    assert abs(orbit.stability.multipliers[0] - 1.0) < 1e-12


def test_a_period_of_the_forcing_may_be_several() -> None:
    orbit = fr.periodic_orbit(DUFFING, [1.0, 0.0], 4.0 * math.pi / 1.2)
    single = fr.periodic_orbit(DUFFING, [1.0, 0.0]).stability.multipliers
    for mu in orbit.stability.multipliers:
        assert np.abs(np.square(single) - mu).min() < 1e-10
    with pytest.raises(ValueError, match="1 to 1000 times the system's"):
        fr.periodic_orbit(DUFFING, [1.0, 0.0], 3.0)


def test_derivatives_with_a_parameter_and_the_tangent_of_a_branch() -> None:
    """What continuation needs: along the tangent the equations stay satisfied to second order."""
    orbit = fr.periodic_orbit(DUFFING, [1.0, 0.0])
    given = orbit.collocation
    collocation = Collocation(orbit.system, given.mesh, given.degree, given.turns, "omega")
    point = orbit.point._replace(value=1.2)
    row = BorderRow(np.zeros_like(point.nodes), np.array([1.0]), 1.2)
    tangent = collocation.tangent(collocation.linearised(point), [row], point.scale)
    assert tangent.scalars[0] == pytest.approx(1.0)
    ahead = fr.periodic_orbit(DUFFING.with_parameters(omega=1.2 + 1e-4), orbit)
    behind = fr.periodic_orbit(DUFFING.with_parameters(omega=1.2 - 1e-4), orbit)
    slope = (ahead.states[0] - behind.states[0]) / 2e-4
    assert np.abs(tangent.nodes[0] - slope).max() < 1e-6
    moved = corrected(collocation, collocation.moved(point, tangent, 1e-3), [row._replace(target=1.201)])
    assert moved.point.value == pytest.approx(1.201, abs=1e-14)
    assert moved.point.period == pytest.approx(2.0 * math.pi / 1.201, abs=1e-12)


@pytest.mark.parametrize(
    ("function", "start", "message"),
    [
        (lambda t, x: (x[1],), [1.0, 0.0], "function must return 2 rates"),
        (lambda t, x: (x[1], math.nan), [1.0, 0.0], "function must return finite rates"),
        (lambda t, x: None, [1.0, 0.0], "got None"),
        (lambda t, x: (x[1], np.cos(0.7 * t) - x[0]), [1.0, 0.0], "function is not periodic in 1"),
        (lambda t, x: (x[0] ** 2,), [1.0], "start diverges"),
        (lambda t, x: (x[0] ** 2,), [100.0], "start diverges"),
        (lambda t, x: (np.sqrt(0.5 - x[0]) + 1.0,), [0.0], "start diverges: .* or is not finite"),
    ],
)
def test_functions_that_are_not_as_they_should_be(function: Any, start: Any, message: str) -> None:
    with pytest.raises((ValueError, TypeError), match=message):
        fr.periodic_orbit(fr.NonlinearSystem(function, period=1.0), start)


@pytest.mark.parametrize(
    ("system", "start", "message"),
    [
        (VAN_DER_POL, [0.0, 0.0], r"start is a state of rest, \(0, 0\), where nothing moves: .* such as \(0\.1, 0\)$"),
        (VAN_DER_POL.with_parameters(mu=-1.0), [0.5, 0.0], "leads to a state of rest"),
        (VAN_DER_POL.with_parameters(mu=-1.0), [4.0, 0.0], "start diverges"),
        (VAN_DER_POL, [2.0, 0.0, 1.0], "function must return 3 rates"),
        (VAN_DER_POL, [[2.0, 0.0]], "start must be a state"),
        (VAN_DER_POL, ([0.0, 1.0], [[2.0, 0.0], [1.0, 1.0]]), "8 instants or more"),
        (DUFFING, (np.linspace(0.0, 1.0, 50), np.ones((50, 2))), "start must cover a period"),
        (fr.NonlinearSystem(lambda t, x: (x[1], np.cos(t) - x[0])), [1.0, 0.0], "depends on time; give its period"),
    ],
)
def test_starts_that_lead_nowhere(system: Any, start: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fr.periodic_orbit(system, start)


def test_a_state_of_rest_is_named_with_a_period_too() -> None:
    with pytest.raises(ValueError, match=r"^start is a state of rest, \(0, 0\)"):
        fr.periodic_orbit(VAN_DER_POL, [0.0, 0.0], period=6.66)


def test_rows_that_the_integration_did_not_reach_do_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    def stalls(function: Any, state: Any, times: Any, **options: Any) -> Any:
        states = np.full((len(times), len(state)), 1e299)  # memory that was not set
        states[:51] = state
        function(times[49], state)
        return states, {"message": "Excess work done on this call (perhaps wrong Dfun type)."}

    monkeypatch.setattr("scipy.integrate.odeint", stalls)
    with pytest.raises(ValueError, match="start leads to motion that cannot be followed"):
        fr.periodic_orbit(VAN_DER_POL, [2.0, 0.0])


def test_motion_of_two_periods_is_led_to_them_and_to_the_orbit_of_one() -> None:
    def duffing(t: Any, x: Any) -> Any:
        return x[1], -0.3 * x[1] + x[0] - x[0] ** 3 + 0.28 * np.cos(1.2 * t)

    words = (
        r"after 2 periods, not after one; give period = 2 \* 5\.23599, or follow the orbit of one period by fr\.follow"
    )
    with pytest.raises(ValueError, match=words):
        fr.periodic_orbit(fr.NonlinearSystem(duffing, period=2.0 * np.pi / 1.2), [1.0, 0.0])


def test_newton_says_where_it_stood() -> None:
    motion = np.array([3.0, 3.0, 3.0]) * np.cos(np.arange(0.0, 9.0, 0.02))[:, None]
    with pytest.raises(fr.NoOrbitError, match=r"its last point has the period .* missed by") as caught:
        fr.periodic_orbit(LORENZ, (np.arange(0.0, 9.0, 0.02), motion), 0.01)
    assert caught.value.point is not None


@pytest.mark.parametrize("unit", [1e-4, 1e4])
def test_units_of_time_and_of_states_do_not_matter(unit: float) -> None:
    """Of van der Pol's oscillator in other units, position in one and time in another."""

    def rates(t: Any, x: Any) -> Any:
        return x[1], (1.0 - (unit * x[0]) ** 2) * x[1] / unit - x[0] / unit**2

    orbit = fr.periodic_orbit(fr.NonlinearSystem(rates), [2.0 / unit, 0.0])
    assert orbit.period / unit == pytest.approx(6.663286859323131, rel=1e-13)
    assert orbit.stability.multipliers[0].real == pytest.approx(8.596950636038e-4, rel=1e-9)
    assert orbit.error < 1e-9


def mixed(rng: np.random.Generator) -> tuple[Any, Any, list[float], bool]:
    """Return rates, a start, and the logarithms of the multipliers, of deviations that decay at rates far apart.

    y' = (L + M cos t) (y - g) + g' in skew axes, L and M diagonal, g = cos t: multipliers exp(2 pi L).  Every other one
    beside the autonomous circle r' = r - r^3 instead, whose own is exp(-4 pi), and without M and g.
    """
    count, autonomous = int(rng.integers(1, 6)), bool(rng.integers(2))
    rates = -(10.0 ** rng.uniform(-2.0, 1.9, count))
    rates[0] = rng.choice([-0.05, 0.03, 0.2])
    axes = np.eye(count) + 0.3 * rng.normal(size=(count, count)) / math.sqrt(count)
    matrix = axes @ np.diag(rates) @ np.linalg.inv(axes)
    swing = axes @ np.diag(rng.uniform(-0.3, 0.3, count)) @ np.linalg.inv(axes)
    logs = sorted((2.0 * math.pi * rates).tolist() + ([-4.0 * math.pi] if autonomous else []), reverse=True)

    def forced(t: Any, x: Any) -> Any:
        y = x - np.cos(t)
        return matrix @ y + np.cos(t) * (swing @ y) - np.sin(t)

    def circling(t: Any, x: Any) -> Any:
        square = x[0] ** 2 + x[1] ** 2
        return np.concatenate([[x[0] - x[1] - square * x[0], x[0] + x[1] - square * x[1]], matrix @ x[2:]])

    return (circling, [1.0, 0.0] + [0.0] * count, logs, True) if autonomous else (forced, [1.0] * count, logs, False)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(60, 6)))
def test_each_multiplier_has_an_error_of_its_own(seed: int) -> None:
    """Logarithms known by construction, from 1 to -500: a small one that is not known well leaves the others sure."""
    rates, start, logs, autonomous = mixed(np.random.default_rng(seed))
    system = fr.NonlinearSystem(rates, period=None if autonomous else 2.0 * math.pi)
    orbit = fr.periodic_orbit(system, start, 2.0 * math.pi)
    assert orbit.status == ("unstable" if logs[0] > 0.0 else "stable")
    found = orbit.stability
    for exponent, error, log in zip(found.exponents, found.exponent_errors, logs, strict=True):
        assert abs(exponent.real * orbit.period - log) <= error * orbit.period + 1e-13 * abs(log)
        assert error * orbit.period < 1e-3
    assert "another one is 1" not in found.note


@pytest.mark.parametrize("mu", [1.0, 5.0, pytest.param(20.0, marks=pytest.mark.slow)])
def test_extremes_are_those_between_the_nodes(mu: float) -> None:
    """Van der Pol's extremes by DOP853 where a rate of change is 0."""
    orbit = fr.periodic_orbit(VAN_DER_POL.with_parameters(mu=mu), [2.0, 0.0])

    def rates(t: float, x: Any) -> Any:
        return van_der_pol(t, x, mu)

    events = [lambda t, x, k=k: rates(t, x)[k] for k in (0, 1)]
    start = orbit.states[0]
    motion = solve_ivp(rates, (0.0, orbit.period), start, "DOP853", rtol=3e-14, atol=1e-14, events=events)
    known = np.array([states[:, k].max() for k, states in enumerate(motion.y_events)])
    assert (np.abs(orbit.largest - known) <= orbit.error * orbit.point.scale + 1e-12 * known).all()
    assert np.abs(orbit.least + orbit.largest).max() <= 2.0 * orbit.error * known.max()  # x and -x obey the same
    times = np.concatenate([orbit.extremes.largest_at, orbit.extremes.least_at]) * orbit.period
    there = orbit(times)[[0, 1, 2, 3], [0, 1, 0, 1]]
    assert np.allclose(there, np.concatenate([orbit.largest, orbit.least]), rtol=1e-12, atol=0.0)
    assert f"-{known[1]:.6g} to {known[1]:.6g}" in str(orbit)
    assert orbit.plot().lines[1].get_ydata().max() == pytest.approx(known[1], rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("period", [None, pytest.param(1615.0, marks=pytest.mark.slow)])
def test_a_relaxation_oscillation_of_a_thousand(period: float | None) -> None:
    """The period by its asymptotic series, (3 - 2 log 2) mu + 7.01432 mu^(-1/3) + O(log mu / mu) (Dorodnitsyn)."""
    mu = 1000.0
    orbit = fr.periodic_orbit(VAN_DER_POL.with_parameters(mu=mu), [2.0, 0.0], period)
    series = (3.0 - 2.0 * math.log(2.0)) * mu + 7.01432 * mu ** (-1.0 / 3.0)
    assert abs(orbit.period - series) < 2.0 * math.log(mu) / mu
    assert orbit.status == "stable"
    assert orbit.error < 1e-7
    assert abs(orbit.largest[0] - 2.0 - 0.7793 * mu ** (-4.0 / 3.0)) < 1e-5


TURN = 2.0 * math.pi


@pytest.mark.parametrize("start", [[0.0, 0.0], [0.3, 3.0]])
@pytest.mark.parametrize("period", [None, 2.66])
def test_motion_that_rotates_is_refused_with_its_cause(start: list[float], period: float | None) -> None:
    system = fr.NonlinearSystem(lambda t, x: (x[1], 1.2 - 0.5 * x[1] - np.sin(x[0])))
    words = r"state 0 grows by 2 pi in every period of about 2\.65.*give winding=\{0: 1 \* 2 \* math\.pi\}"
    with pytest.raises(ValueError, match=words):
        fr.periodic_orbit(system, start, period)


def test_the_way_out_of_a_rotation_leads_to_its_orbit() -> None:
    def in_cosine_and_sine(t: Any, x: Any) -> Any:
        c, s, w = x
        round_up = 1.0 - c * c - s * s
        return -s * w + round_up * c, c * w + round_up * s, 1.2 - 0.5 * w - s

    orbit = fr.periodic_orbit(fr.NonlinearSystem(in_cosine_and_sine), [1.0, 0.0, 2.0])
    assert orbit.status == "stable"
    angle = math.atan2(*orbit.states[0, [1, 0]])
    motion = solve_ivp(
        lambda t, x: (x[1], 1.2 - 0.5 * x[1] - np.sin(x[0])),
        (0.0, orbit.period),
        [angle, orbit.states[0, 2]],
        "DOP853",
        rtol=1e-13,
        atol=1e-13,
    )
    assert np.abs(motion.y[:, -1] - [angle + TURN, orbit.states[0, 2]]).max() < 1e-10


def test_a_state_that_nothing_depends_on_is_named() -> None:
    system = fr.NonlinearSystem(lambda t, x: (*van_der_pol(t, x[:2], 1.0), 1.0 + 0.0 * x[0]))
    with pytest.raises(ValueError, match=r"state 2 grows by 6\.66329 in every period .* leave state 2 out"):
        fr.periodic_orbit(system, [2.0, 0.0, 0.0])


def test_motion_that_slows_down_does_not_count_as_a_rotation() -> None:
    system = fr.NonlinearSystem(lambda t, x: (x[1], -0.05 * x[1] - np.sin(x[0])))
    with pytest.raises(ValueError, match="a state of rest"):
        fr.periodic_orbit(system, [0.0, 6.0])
