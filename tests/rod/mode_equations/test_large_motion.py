"""The equations of a rod on its wall at finite angles: held to closed forms, to shared truth, and to other formulas."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import j1

import floquetrod as fr
from floquetrod._util.arrays import Floats
from floquetrod.rod.mode_equations import large_motion
from floquetrod.rod.model import lift_off
from floquetrod.rod.model.lift_off import LiftOff
from tests.inside import LargeMotion, Load, Shapes

ROD = fr.Rod.nitinol()
CRITICAL = ROD.critical_force


def motion(rod: fr.Rod, under: Load, modes: list[int], **options: Any) -> LargeMotion:
    """Return the equations in the modes of these numbers."""
    shapes = Shapes.of(rod, under, max(modes))
    chosen = [list(shapes.numbers).index(mode) for mode in modes]
    return LargeMotion(rod, under, shapes.some(chosen), **options)


def load(mean: float, amplitude: float = 0.0, frequency: float = 100.0) -> fr.AxialLoad:
    return fr.AxialLoad(mean * CRITICAL, amplitude * CRITICAL, frequency)


def march(equations: LargeMotion, span: float, state: Any, **options: Any) -> Any:
    def rates(t: float, y: Floats) -> Floats:
        return equations.rates(np.array([t]), y[None])[0]

    return solve_ivp(rates, (0.0, span), state, method="DOP853", **options)


def at_rest(equations: LargeMotion, start: Any) -> Floats:
    a = np.array(start, dtype=float)
    for _ in range(60):
        gradient, stiffness = equations.potential(np.zeros(1), a[None], True)
        step = np.linalg.solve(stiffness[0], -gradient[0])
        a += step * min(1.0, 0.05 / max(np.abs(step).max(), 1e-300))
    return a


def test_static_angle_of_one_sine_is_that_of_the_shared_truth_and_of_bessel_functions() -> None:
    equations = motion(ROD, load(1.06), [6], indentation=0.0)
    a = at_rest(equations, [0.2])
    largest = float(equations.angles(np.append(a, 0.0)[None]).max())
    assert largest == pytest.approx(0.30096, abs=1e-5)
    k = 6 * math.pi / ROD.length
    bent = ROD.flexural_rigidity * k**4 * (largest + 1.5 * largest**3)
    weight = 2.0 * ROD.mass_per_length * ROD.effective_gravity / ROD.radial_clearance * float(j1(largest))
    assert bent + weight == pytest.approx(1.06 * CRITICAL * k**2 * largest, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("angle", "with_inertia", "without"), [(0.1382, 74.3900, 74.3960), (0.27254, 76.0236, 76.0535)]
)
def test_free_motion_is_as_fast_as_the_shared_truth_says(angle: float, with_inertia: float, without: float) -> None:
    for modes, expected in (([7, 21], with_inertia), ([7], without)):
        equations = motion(ROD, load(0.2), modes, indentation=0.0, shortens=len(modes) > 1)

        def turns(t: float, y: Floats) -> float:
            return float(y[len(y) // 2])

        a = np.zeros(len(modes))
        a[0] = angle / math.sqrt(2.0)
        for _ in range(20 * (len(modes) - 1)):  # the third harmonic along the rod follows at once
            gradient, stiffness = equations.potential(np.zeros(1), a[None], True)
            a[1] -= gradient[0, 1] / stiffness[0, 1, 1]
        found = march(equations, 0.05, [*a, *(0.0 * a)], events=turns, rtol=1e-10, atol=1e-12).t_events[0]
        assert math.pi / found[found > 0.03][0] == pytest.approx(expected, rel=4e-6)


@pytest.mark.parametrize("ends", ["hinged", "clamped", "clamped-hinged", "guided"])
@pytest.mark.parametrize("wave", [False, True])
def test_the_derivatives_are_those_of_the_rates(ends: str, wave: bool) -> None:
    rng = np.random.default_rng(1)
    kind = partial(fr.AxialWave, far_end="held", axial_damping=3.0) if wave else fr.AxialLoad
    rod = ROD.replace(ends=ends, damping_rate=0.7, inclination="70deg")
    equations = motion(rod, kind(0.5, 0.4, 120.0), [2, 5, 7])
    times, states = np.array([0.01, 0.3]), rng.normal(size=(2, 6)) * [0.05, 0.05, 0.05, 3.0, 3.0, 3.0]
    found = equations.jacobians(times, states)
    moved = [
        (equations.rates(times, states + step) - equations.rates(times, states - step)) / 2e-6
        for step in 1e-6 * np.eye(6)
    ]
    assert np.abs(found - np.stack(moved, axis=-1)).max() < 1e-9 * np.abs(found).max()


def test_small_motion_is_that_of_the_linear_modes() -> None:
    for ends in ("hinged", "clamped"):
        rod = ROD.replace(ends=ends, damping_rate=0.3)
        under = load(0.3, 0.2, 140.0)
        equations = motion(rod, under, [6, 7])
        free = equations.jacobians(np.array([math.pi / 140.0]), np.zeros((1, 4)))[0]  # where the vibration vanishes
        assert np.linalg.eigvals(free).real == pytest.approx(-0.3, abs=1e-10)
        if ends == "hinged":
            assert np.sort(-np.diag(free[2:, :2])) == pytest.approx(
                [
                    ROD.natural_frequency(m) ** 2
                    - 0.3 * CRITICAL * (m * math.pi / ROD.length) ** 2 / ROD.mass_per_length
                    for m in (6, 7)
                ],
                rel=1e-10,
            )


def test_energy_is_kept_without_damping_and_lost_to_it() -> None:
    rod = ROD.replace(ends="clamped")
    equations = motion(rod, load(0.5), [4, 6, 8], indentation=0.0)
    found = march(equations, 0.05, [0.1, -0.05, 0.03, 1.0, 2.0, 0.0], rtol=1e-9, atol=1e-10, t_eval=[0.0, 0.02, 0.05])
    energies = [energy(equations, state) for state in found.y.T]
    assert np.ptp(energies) < 1e-7 * np.abs(energies).max()


def energy(equations: LargeMotion, state: Floats) -> float:
    """Return the energy over m R^2 L by the formulas of the module, on the nodes."""
    rod, shapes = equations.rod, equations.shapes
    a, v = np.split(state, 2)
    theta, slope, curve = (a @ part for part in (shapes.values, shapes.slopes, shapes.curves))
    length, mass = rod.length, rod.mass_per_length
    bent = 0.5 * rod.flexural_rigidity / mass / length**4 * (curve**2 + slope**4)
    pushed = 0.5 * equations.load.mean / mass / length**2 * slope**2
    weight = rod.pendulum_frequency**2 * (1.0 - np.cos(theta))
    shorter = large_motion._integrals(shapes.nodes, slope * (v @ shapes.slopes), False)
    along = rod.mass_along / mass * (rod.radial_clearance / length) ** 2
    moving = 0.5 * (v @ shapes.values) ** 2 + 0.5 * along * shorter**2
    return float((bent - pushed + weight + moving) @ shapes.weights)


def test_lift_off_is_that_of_a_soft_and_of_a_hard_wall() -> None:
    lift = LiftOff(rigidity=2.0, weight=3.0, indentation=1e-6)
    b = (2.0 * 1e-6 / 3.0) ** 0.25
    soft, hard = 1e-3 * 1e-6 / b**2, 1e4 * 1e-6 / b**2
    slope = soft / (math.sqrt(2.0) * 1.5**0.25) * b
    assert lift.energy(soft, 1.0).value == pytest.approx(-0.5 * 2.0 * soft * slope, rel=5e-3)
    assert lift.energy(hard, 1.0).value == pytest.approx(-2.0 / 7.5 * math.sqrt(2.0 / 3.0) * hard**2.5, rel=5e-3)


def test_the_derivatives_of_the_energy_of_lift_off_are_its_own() -> None:
    lift = LiftOff(rigidity=2.0, weight=3.0, indentation=1e-6)
    curvature, contact, step = np.array([5e-4, 3e-3, 0.03, 0.5]), np.array([1.0, 0.8, 1.1, 0.7]), 1e-5
    at = lift.energy(curvature, contact)
    wider = [lift.energy(curvature * (1.0 + s), contact) for s in (-step, step)]
    harder = [lift.energy(curvature, contact * (1.0 + s)) for s in (-step, step)]

    def slope(pair: list[Any], name: str, size: Floats) -> Floats:
        return (getattr(pair[1], name) - getattr(pair[0], name)) / (2.0 * step * size)

    assert at.by_curvature == pytest.approx(slope(wider, "value", curvature), rel=1e-6)
    assert at.by_curvature_twice == pytest.approx(slope(wider, "by_curvature", curvature), rel=1e-6)
    assert at.by_contact == pytest.approx(slope(harder, "value", contact), rel=1e-6)
    assert at.by_both == pytest.approx(slope(harder, "by_curvature", contact), rel=1e-6)
    assert at.by_contact_twice == pytest.approx(slope(harder, "by_contact", contact), rel=1e-6)


def test_the_slope_of_lift_off_does_not_jump_where_solving_for_it_ends() -> None:
    last = lift_off._LARGEST
    (below, above), (slope_below, slope_above), _ = lift_off._slope(last * np.array([1.0 - 1e-6, 1.0 + 1e-6]))
    assert above == pytest.approx(below, rel=4e-6)
    assert slope_above == pytest.approx(slope_below, rel=1e-5)
    for k in (0.5, 20.0, 59.0, 61.0, 120.0, 400.0):
        assert lift_off._slope(np.array(k))[0] == pytest.approx(lift_off._solved(k), rel=3e-3 if k < last else 1e-4)


def test_shapes_are_orthonormal_even_or_odd_and_the_modes_under_the_mean_force() -> None:
    for ends in ("hinged", "clamped", "hinged-clamped"):
        shapes = Shapes.of(ROD.replace(ends=ends), load(0.6), 14)
        assert (shapes.values * shapes.weights) @ shapes.values.T == pytest.approx(
            np.eye(len(shapes.numbers)), abs=1e-11
        )
        if ends != "hinged-clamped":
            assert sorted(zip(shapes.numbers[:14], shapes.even[:14], strict=True)) is not None
            mirrored = shapes.values[:, ::-1]
            assert np.where(shapes.even[:, None], mirrored, -mirrored) == pytest.approx(shapes.values, abs=1e-7)
