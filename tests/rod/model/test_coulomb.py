"""Friction of a rod: equations (15)-(18), and what the paper and we find for the reference rod."""

from __future__ import annotations

import math

import numpy as np
import pytest

import floquetrod as fr
from tests.conftest import depth
from tests.inside import mode_friction

ROD = fr.Rod.nitinol()
KICK = {"friction": 0.1, "kick": 0.05}


def load(share: float, frequency: float, amplitude: float = 0.7) -> fr.AxialLoad:
    return fr.AxialLoad(share * ROD.critical_force, amplitude * ROD.critical_force, frequency)


@pytest.mark.parametrize("frequency", [85.0, 150.0])
def test_axial_sliding_hardly_matters_for_this_rod(frequency: float) -> None:
    inside = mode_friction(ROD, **KICK, amplitude=load(0.4, frequency).amplitude, frequency=frequency)
    assert 3e-4 < inside.v_a < 7e-4
    assert inside.mu_theta == pytest.approx(0.1, rel=1e-4)
    assert inside.gamma == pytest.approx(4.0 * inside.mu_theta * 9.81 / (math.pi * frequency**2 * 3.9e-3))
    assert inside.epsilon == pytest.approx(0.05 / (frequency * 3.9e-3))


@pytest.mark.parametrize(
    ("share", "frequency", "modes"),
    [(0.118, 85.0, ()), (0.118, 150.0, ()), (0.424, 85.0, ()), (0.424, 150.0, (8,)), (0.825, 85.0, (6, 7, 8))],
)
def test_modes_that_a_kick_sets_off(share: float, frequency: float, modes: tuple[int, ...]) -> None:
    verdict = ROD.stability(load(share, frequency), **KICK)
    assert verdict.unstable_modes == modes
    assert verdict.stable is not bool(modes)


@pytest.mark.slow
def test_escape_speeds_at_150() -> None:
    verdict = ROD.stability(load(0.825, 150.0), **KICK)
    assert verdict.unstable_modes == (9, 10)
    speeds = {mode: round(1e3 * speed, 2) for mode, speed in verdict.critical_kicks.items()}
    assert speeds == {8: 51.06, 9: 32.12, 10: 48.76, 12: 128.79}
    kick, mode, none_up_to = ROD.critical_kick(load(0.825, 150.0), friction=0.1)
    assert (kick, mode) == (pytest.approx(0.03211843, rel=1e-6), 9)
    assert none_up_to == pytest.approx(0.0278299, rel=1e-5)


def test_the_critical_kick_is_where_the_verdict_turns() -> None:
    kick, mode, none_up_to = ROD.critical_kick(load(0.6, 110.0), friction=0.2)
    assert ROD.stability(load(0.6, 110.0), friction=0.2, kick=none_up_to).stable
    assert ROD.stability(load(0.6, 110.0), friction=0.2, kick=kick * (1.0 - 1e-6)).stable
    assert mode in ROD.stability(load(0.6, 110.0), friction=0.2, kick=kick * (1.0 + 1e-6)).unstable_modes


def test_without_friction_or_growth() -> None:
    assert ROD.critical_kick(load(0.825, 150.0), friction=0.0) == (0.0, 9, 0.0)  # of those that grow, the fastest
    quiet = load(0.05, 150.0, amplitude=0.2)
    assert ROD.critical_kick(quiet, friction=0.1) == (math.inf, None, math.inf)
    assert ROD.stability(quiet, friction=0.0, kick=1.0).stable


@pytest.mark.slow
def test_maps_agree_with_single_loads() -> None:
    shares, frequencies = np.array([0.118, 0.424, 0.825]), np.array([60.0, 85.0, 110.0, 150.0][:: depth(1, 2)])
    unit = ROD.critical_force
    chart = fr.stability_map(ROD, mean=shares * unit, amplitude=0.7 * unit, frequency=frequencies, **KICK)
    speeds, modes, proved = ROD.critical_kick(
        mean=shares[:, None] * unit, amplitude=0.7 * unit, frequency=frequencies, friction=0.1
    )
    for i, share in enumerate(shares):
        for j, frequency in enumerate(frequencies):
            assert chart.stable[i, j] == ROD.stability(load(share, frequency), **KICK).stable
            kick, mode, none_up_to = ROD.critical_kick(load(share, frequency), friction=0.1)
            assert speeds[i, j] == pytest.approx(kick, rel=1e-12)
            assert modes[i, j] == (mode or 0)
            assert proved[i, j] == pytest.approx(none_up_to, rel=1e-12)
    assert "kick 0.05 m/s" in chart.caption


ASKED = {
    "stability": lambda **given: ROD.stability(load(0.4, 85.0), **given),
    "is_stable": lambda **given: ROD.is_stable(mean=0.1, amplitude=0.3, frequency=85.0, **given),
    "verdicts": lambda **given: ROD.verdicts(mean=[0.1], amplitude=0.3, frequency=85.0, **given),
    "stability_map": lambda **given: fr.stability_map(
        ROD, mean=(0.1, 0.5, 3), amplitude=0.3, frequency=(50.0, 100.0, 3), **given
    ),
}


@pytest.mark.parametrize("name", ASKED)
@pytest.mark.parametrize(
    ("given", "error", "message"),
    [
        ({"friction": -0.1, "kick": 0.05}, ValueError, "friction must be zero or more"),
        ({"friction": math.nan, "kick": 0.05}, ValueError, "friction must be finite"),
        ({"friction": "0.1", "kick": 0.05}, TypeError, "friction must be a real number"),
        ({"friction": 0.1, "kick": -0.05}, ValueError, "kick must be greater than zero"),
        ({"friction": 0.1, "kick": 0.0}, ValueError, "kick must be greater than zero.* critical_kick"),
        ({"friction": 0.1}, ValueError, "kick must be given with friction.* kick=0.05 .* critical_kick"),
        ({"kick": 0.05}, ValueError, "friction must be given with a kick, got kick = 0.05 alone: .* friction=0.1"),
    ],
)
def test_friction_and_kick_go_together(
    name: str, given: dict[str, object], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        ASKED[name](**given)


def test_friction_of_zero_is_none() -> None:
    assert ROD.stability(load(0.4, 85.0), friction=0.0) == ROD.stability(load(0.4, 85.0))


def test_how_large_a_kick_must_be_needs_friction_alone() -> None:
    assert ROD.critical_kick(load(0.825, 150.0), friction=0.1).kick > 0.0
    with pytest.raises(ValueError, match="friction must be zero or more"):
        ROD.critical_kick(mean=0.3, amplitude=0.3, frequency=150.0, friction=-0.1)


def test_a_single_load_comes_back_as_python_numbers() -> None:
    found = ROD.critical_kick(
        mean=0.825 * ROD.critical_force, amplitude=0.7 * ROD.critical_force, frequency=150.0, friction=0.1
    )
    assert [type(part) for part in found] == [float, int, float]
    assert found == ROD.critical_kick(load(0.825, 150.0), friction=0.1)
    assert type(ROD.verdicts(mean=0.1, amplitude=0.3, frequency=85.0, **KICK)) is int


def test_a_map_of_growth_is_one_without_friction() -> None:
    with pytest.raises(ValueError, match="growth"):
        fr.stability_map(ROD, mean=(0.1, 0.5, 3), amplitude=0.3, frequency=(50.0, 100.0, 3), growth=True, **KICK)


def test_a_verdict_with_friction_is_a_sentence() -> None:
    assert "destabilises modes 9, 10" in repr(ROD.stability(load(0.825, 150.0), friction=0.1, kick=0.05))
