"""Friction of a rod: equations (15)-(18), and what the paper and we find for the reference rod."""

from __future__ import annotations

import math

import numpy as np
import pytest

import floquetrod as fr

ROD = fr.Rod.nitinol()
KICK = fr.Coulomb(mu=0.1, velocity=0.05)


def load(share: float, frequency: float, amplitude: float = 0.7) -> fr.AxialLoad:
    return fr.AxialLoad(share * ROD.critical_force, amplitude * ROD.critical_force, frequency)


@pytest.mark.parametrize("frequency", [85.0, 150.0])
def test_axial_sliding_hardly_matters_for_this_rod(frequency: float) -> None:
    inside = KICK.in_mode_equation(ROD, load(0.4, frequency))
    assert 3e-4 < inside.v_a < 7e-4
    assert inside.mu_theta == pytest.approx(0.1, rel=1e-4)
    assert inside.gamma == pytest.approx(4.0 * inside.mu_theta * 9.81 / (math.pi * frequency**2 * 3.9e-3))
    assert inside.epsilon == pytest.approx(0.05 / (frequency * 3.9e-3))


@pytest.mark.parametrize(
    ("share", "frequency", "modes"),
    [(0.118, 85.0, ()), (0.118, 150.0, ()), (0.424, 85.0, ()), (0.424, 150.0, (8,)), (0.825, 85.0, (6, 7, 8))],
)
def test_modes_that_a_kick_sets_off(share: float, frequency: float, modes: tuple[int, ...]) -> None:
    verdict = ROD.stability(load(share, frequency), friction=KICK)
    assert verdict.unstable_modes == modes
    assert verdict.stable is not bool(modes)


def test_escape_speeds_at_150() -> None:
    verdict = ROD.stability(load(0.825, 150.0), friction=KICK)
    assert verdict.unstable_modes == (9, 10)
    speeds = {mode: round(1e3 * speed, 2) for mode, speed in verdict.critical_velocities.items()}
    assert speeds == {8: 51.06, 9: 32.12, 10: 48.76, 12: 128.79}
    velocity, mode, none_up_to = ROD.critical_velocity(load(0.825, 150.0), mu=0.1)
    assert (velocity, mode) == (pytest.approx(0.03211843, rel=1e-6), 9)
    assert none_up_to == pytest.approx(0.0278299, rel=1e-5)


def test_the_critical_kick_is_where_the_verdict_turns() -> None:
    velocity, mode, none_up_to = ROD.critical_velocity(load(0.6, 110.0), mu=0.2)
    assert ROD.stability(load(0.6, 110.0), friction=fr.Coulomb(0.2, none_up_to)).stable
    assert ROD.stability(load(0.6, 110.0), friction=fr.Coulomb(0.2, velocity * (1.0 - 1e-6))).stable
    assert mode in ROD.stability(load(0.6, 110.0), friction=fr.Coulomb(0.2, velocity * (1.0 + 1e-6))).unstable_modes


def test_without_friction_or_growth() -> None:
    assert ROD.critical_velocity(load(0.825, 150.0), mu=0.0) == (0.0, 9, 0.0)  # of those that grow, the fastest
    quiet = load(0.05, 150.0, amplitude=0.2)
    assert ROD.critical_velocity(quiet, mu=0.1) == (math.inf, None, math.inf)
    assert ROD.stability(quiet, friction=fr.Coulomb(0.0, 1.0)).stable


def test_maps_agree_with_single_loads() -> None:
    shares, frequencies = np.array([0.118, 0.424, 0.825]), np.array([60.0, 85.0, 110.0, 150.0])
    unit = ROD.critical_force
    chart = fr.stability_map(ROD, mean=shares * unit, amplitude=0.7 * unit, frequency=frequencies, friction=KICK)
    speeds, modes, proved = ROD.critical_velocities(shares[:, None] * unit, 0.7 * unit, frequencies, 0.1)
    for i, share in enumerate(shares):
        for j, frequency in enumerate(frequencies):
            assert chart.stable[i, j] == ROD.stability(load(share, frequency), friction=KICK).stable
            velocity, mode, none_up_to = ROD.critical_velocity(load(share, frequency), mu=0.1)
            assert speeds[i, j] == pytest.approx(velocity, rel=1e-12)
            assert modes[i, j] == (mode or 0)
            assert proved[i, j] == pytest.approx(none_up_to, rel=1e-12)
    assert "kick 0.05 m/s" in chart.caption


@pytest.mark.parametrize(
    ("mu", "velocity", "name"),
    [(-0.1, 0.05, "mu"), (0.1, -0.05, "velocity"), (0.1, 0.0, "velocity"), (math.nan, 0.05, "mu")],
)
def test_bad_friction_is_refused(mu: float, velocity: float, name: str) -> None:
    with pytest.raises(ValueError, match=name):
        fr.Coulomb(mu, velocity)


def test_friction_without_a_kick_is_no_question_but_how_large_it_must_be_is() -> None:
    with pytest.raises(TypeError, match="velocity"):
        fr.Coulomb(0.1)  # type: ignore[call-arg]
    with pytest.raises(ValueError, match=r"velocity must be greater than zero.* critical_velocity"):
        fr.Coulomb(0.1, 0.0)
    assert ROD.critical_velocity(load(0.825, 150.0), mu=0.1).velocity > 0.0


def test_friction_has_to_be_a_coulomb() -> None:
    with pytest.raises(TypeError, match="Coulomb"):
        ROD.stability(load(0.4, 85.0), friction=0.1)  # type: ignore[call-overload]
    with pytest.raises(ValueError, match="growth"):
        fr.stability_map(ROD, mean=(0.1, 0.5, 3), amplitude=0.3, frequency=(50.0, 100.0, 3), growth=True, friction=KICK)


def test_a_verdict_with_friction_is_a_sentence() -> None:
    push = fr.AxialLoad(0.825 * ROD.critical_force, 0.7 * ROD.critical_force, 150.0)
    assert "sets off modes 9, 10" in repr(ROD.stability(push, friction=fr.Coulomb(0.1, 0.05)))
