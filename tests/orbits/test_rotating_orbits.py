"""Guards orbits of motion that rotates: a pendulum turned by a torque, driven or not, followed, saved."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import floquetrod as fr

TURN = 2.0 * math.pi


def pendulum(t: Any, x: Any, torque: float = 1.2, damping: float = 0.5, drive: float = 0.0, w: float = 2.0) -> Any:
    """Return the rates of phi'' + c phi' + sin phi = torque + drive sin(w t)."""
    return x[1], torque + drive * np.sin(w * t) - damping * x[1] - np.sin(x[0])


def test_a_pendulum_turns_as_an_integration_says() -> None:
    orbit = fr.periodic_orbit(fr.NonlinearSystem(pendulum), [0.0, 2.0], winding={0: TURN})
    whole = solve_ivp(pendulum, (0.0, orbit.period), orbit.states[0], method="DOP853", rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(whole.y[:, -1] - orbit.states[0], [TURN, 0.0], atol=1e-10)
    assert orbit.multipliers[0].real == pytest.approx(math.exp(-0.5 * orbit.period), abs=1e-12)  # Liouville
    np.testing.assert_allclose(orbit.states[-1] - orbit.states[0], [TURN, 0.0], atol=1e-14)
    np.testing.assert_allclose(orbit(3.25 * orbit.period) - orbit(0.25 * orbit.period), [3.0 * TURN, 0.0], atol=1e-11)
    speed = TURN / orbit.period
    assert orbit.harmonics[0, 1].real == pytest.approx(speed, rel=1e-12)  # the mean of phi'


def test_fast_rotation_is_that_of_its_expansion() -> None:
    # phi' is about V = torque / c, and turns once in about 2 pi / V: sin phi takes 1 / (2 V^3) of the torque.
    orbit = fr.periodic_orbit(fr.NonlinearSystem(lambda t, x: pendulum(t, x, 5.0)), [0.0, 9.0], winding={0: TURN})
    speed = TURN / orbit.period
    assert 5.0 - 0.5 * speed == pytest.approx(0.5 / speed**2 * 0.5 / speed, rel=0.02)


def test_a_driven_pendulum_locks_to_its_drive() -> None:
    free = fr.periodic_orbit(fr.NonlinearSystem(pendulum), [0.0, 2.0], winding={0: TURN})
    w = 1.01 * TURN / free.period
    system = fr.NonlinearSystem(lambda t, x: pendulum(t, x, 1.2, 0.5, 0.4, w), period=TURN / w)
    orbit = fr.periodic_orbit(system, free.states[0], winding={0: TURN})
    assert orbit.status == "stable"
    product = math.prod(abs(multiplier) for multiplier in orbit.multipliers)
    assert product == pytest.approx(math.exp(-0.5 * orbit.period), rel=1e-10)


def test_turning_the_other_way_is_the_mirror_image() -> None:
    one = fr.periodic_orbit(fr.NonlinearSystem(pendulum), [0.0, 2.0], winding={0: TURN})
    mirrored = fr.NonlinearSystem(lambda t, x: pendulum(t, x, -1.2))
    other = fr.periodic_orbit(mirrored, [0.0, -2.0], winding={0: -TURN})
    assert other.period == pytest.approx(one.period, rel=1e-11)


def test_a_branch_of_rotation_is_followed_and_read(tmp_path: Path) -> None:
    system = fr.NonlinearSystem(lambda t, x, torque: pendulum(t, x, torque), parameters={"torque": 1.2})
    orbit = fr.periodic_orbit(system, [0.0, 2.0], winding={0: TURN})
    branch = fr.follow(orbit, over={"torque": (1.1, 1.6)})
    direct = fr.periodic_orbit(system.with_parameters(torque=1.6), [0.0, 3.0], winding={0: TURN})
    assert branch.orbits[-1].period == pytest.approx(direct.period, rel=1e-9)
    branch.save(tmp_path / "branch.npz")
    again = fr.Branch.load(tmp_path / "branch.npz", system)
    assert again.orbits[-1].states[-1, 0] - again.orbits[-1].states[0, 0] == pytest.approx(TURN)
    assert fr.periodic_orbit(system.with_parameters(torque=1.6), branch.orbits[-1]).period == pytest.approx(
        direct.period, rel=1e-9
    )


@pytest.mark.parametrize(
    ("winding", "words"),
    [
        ({}, "winding must be a mapping"),
        (TURN, "winding must be a mapping"),
        ([TURN, 0.0], "winding must be a mapping"),
        ({2: TURN}, "winding .*must be at most 1, got 2"),
        ({-1: TURN}, "winding .*must be 0 or more"),
        ({0: 0.0}, "winding must not be 0"),
        ({0: math.nan}, r"winding\[0\]"),
        ({0: 1.0}, "winding must leave the rates as they are"),
        ({1: TURN}, "winding must leave the rates as they are"),
    ],
)
def test_a_wrong_winding_is_refused(winding: Any, words: str) -> None:
    with pytest.raises((TypeError, ValueError), match=words) as error:
        fr.periodic_orbit(fr.NonlinearSystem(pendulum), [0.0, 2.0], winding=winding)
    assert "\n" not in str(error.value)


def test_motion_that_comes_to_rest_does_not_rotate() -> None:
    system = fr.NonlinearSystem(lambda t, x: pendulum(t, x, 0.2, 1.0))
    with pytest.raises(ValueError, match="does not rotate"):
        fr.periodic_orbit(system, [0.0, 2.0], winding={0: TURN})
