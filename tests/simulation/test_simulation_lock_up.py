"""Lock-up of strings in strongly bent wells, at its full length, judged by the simulator."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

import floquetrod as fr
from tests.conftest import some

PIPE = fr.Rod(youngs_modulus=0.2e9, density=1000.0, radius=0.01, length=1.0, channel_radius=0.015)
FORCE = PIPE.critical_force
FAR = 0.25 * FORCE
"""Compression in N at the lower end."""

WELLS = {
    "turn": (0.0, 0.4, 0.8),
    "build": (0.4, 0.0, 1.8),
    "building turn": (0.08, 0.39, 1.0),
}
"""Curvatures in 1/m, and a friction with which strings lock up before they have turned around."""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning"),  # a laboratory's bends
]


def bent(build: float, turn: float, length: float) -> fr.WellPath:
    """Return a well of constant curvatures, a build alone being level at its middle, others at the lower end."""
    depth = np.linspace(0.0, length, 201)
    angle = 0.5 * math.pi + build * (depth - (length if turn else 0.5 * length))
    middle = np.sin(0.5 * (angle[1:] + angle[:-1]))
    return fr.WellPath(depth, angle, np.concatenate([[0.0], np.cumsum(turn * np.diff(depth) / middle)]))


def locked(path: fr.WellPath, friction: float) -> float:
    """Return the length in m at which a string locks up whose lower end is where the path ends."""
    end = float(path.stations[-1])
    found = PIPE.mean_force(path, friction, bottom=end, far_force=FAR, depth=np.linspace(0.0, end, 4001))
    return end - float(found.depth[np.isinf(found.force)].max())


def pushed(path: fr.WellPath, friction: float, length: float, feed: float) -> fr.Simulation:
    """Return a string of a length that lies to the end of a path, fed by a part of its length."""
    depth = float(path.stations[-1]) - length
    return fr.simulate(
        PIPE.replace(length=length, ends="free", damping_rate=60.0, path=path, depth=depth),
        fr.AxialWave(FAR, 0.0, 1.0, axial_damping=2.0, far_end="free"),
        friction=friction,
        far_force=FAR,
        feed_speed=0.05,
        duration=feed * length / 0.05,
        segments=math.ceil(68.0 * length),  # 12 in half a wave under 16 critical forces
        perturbation=fr.Perturbation.random(1e-2, seed=1),
        frames=100,
    )


def moved(run: fr.Simulation) -> NDArray[np.float64]:
    """Return how far the nodes have come over the last fifth of the frames, in m."""
    return np.asarray(run.positions[-1, :, 0] - run.positions[-20, :, 0])


def found(run: fr.Simulation, friction: float) -> float:
    """Return the length in m at which the force is infinite, if what is added above is a helix."""
    top = run.end_forces[-20:, 0].mean()
    return float(run.rod.length + 4.0 * PIPE.flexural_rigidity / (friction * PIPE.radial_clearance * top))


@pytest.mark.parametrize("well", some(WELLS, 2, 1))
def test_a_bent_string_locks_up_within_five_per_cent_of_where_the_mean_force_says(well: str) -> None:
    """As long as theory lets it be it slides still; what its force leaves to go is known from its helix alone.

    Bends change that length by more than a half, as the string grips the wall and lies, and its force grows as a
    rope's around a bollard.
    """
    build, turn, friction = WELLS[well]
    path = bent(build, turn, 14.0 / friction)
    length = locked(path, friction)
    straight = locked(fr.WellPath.straight(length=100.0, inclination=0.5 * math.pi), friction)
    assert length < 0.5 * straight
    run = pushed(path, friction, length, 0.03)
    way = moved(run)
    assert way[-1] == pytest.approx(way[0], rel=0.05)  # it slides all along
    assert run.end_forces[-20:, 0].mean() > 20.0 * FORCE
    assert 1.0 < found(run, friction) / length < 1.05


def test_a_straight_string_gets_further_by_a_twelfth() -> None:
    """There it is buckled for half its length, and presses less than theory says, the more so where it winds back."""
    path, friction = fr.WellPath.straight(length=50.0, inclination=0.5 * math.pi), 0.8
    length = locked(path, friction)
    run = pushed(path, friction, 0.95 * length, 0.012)
    way = moved(run)
    assert way[-1] == pytest.approx(way[0], rel=0.05)
    assert 1.05 < found(run, friction) / length < 1.12


@pytest.mark.parametrize("well", some(WELLS, 2, 1))
def test_a_bent_string_longer_than_that_is_stuck(well: str) -> None:
    build, turn, friction = WELLS[well]
    path = bent(build, turn, 14.0 / friction)
    run = pushed(path, friction, 1.2 * locked(path, friction), 0.005)
    way = moved(run)
    assert way[-1] < 0.1 * way[0]
    assert run.end_forces[-1, 0] > 20.0 * FORCE
