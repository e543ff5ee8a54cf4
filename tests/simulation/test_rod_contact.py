"""The discretised rod against closed forms on the floor: indentation, swing, rolling, braking, sticking."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.simulation.rod_mesh import DiscreteRod
from tests.driven import LOOSE, SHORT, bend, drive, energies, frequency, places

ROD_MASS = SHORT.mass_per_length
TUBE = LOOSE.replace(inner_radius=0.7e-3, fluid_inside=900.0, fluid_outside=1000.0)


@pytest.mark.parametrize("rod", [LOOSE, TUBE])
@pytest.mark.parametrize("indentation", [1e-3, 1e-4])
def test_a_rod_laid_down_is_indented_as_stated(rod: fr.Rod, indentation: float) -> None:
    mesh = DiscreteRod(rod, 10, indentation=indentation)

    def start(record: Any) -> None:
        record["z"][:] = -rod.radial_clearance

    _, records = drive(mesh, 0.1, start, samples=1)
    depth = -mesh.nodes(records[-1], "z") - rod.radial_clearance
    assert depth == pytest.approx(indentation * rod.radial_clearance, rel=1e-6)
    first, last = energies(mesh, records[0]), energies(mesh, records[-1])
    lost = first["gravity"] + first["contact"] - last["gravity"] - last["contact"]
    assert last["dissipated_contact"] == pytest.approx(lost, rel=1e-2)


def swing(rod: fr.Rod, friction: float) -> tuple[float, np.ndarray]:
    """Return the square of the frequency of a small swing, times the radius of its circle, and the angles."""
    mesh = DiscreteRod(rod, 10)
    rest = rod.radial_clearance + mesh.depth_at_rest
    guess = math.sqrt(rod.effective_gravity / rest / (1.5 if friction else 1.0))
    time, records = drive(
        mesh, 6 * math.pi / guess, lambda record: bend(mesh, record, np.full(11, 1e-3 * rest)), friction=friction
    )
    angle = np.array([np.arctan2(mesh.nodes(r, "y")[5], -mesh.nodes(r, "z")[5]) for r in records])
    return frequency(time, angle, guess) ** 2 * rest, angle


def test_swing() -> None:
    """Without friction sqrt(g / R); rolling adds half the mass to what moves, sqrt(2 g / (3 R)), and loses nothing."""
    for friction, part in ((0.0, 1.0), (0.5, 2.0 / 3.0)):
        found, angle = swing(LOOSE, friction)
        assert found == pytest.approx(part * SHORT.gravity, rel=4e-6)
        assert np.ptp(angle[-60:]) == pytest.approx(np.ptp(angle[:60]), rel=1e-3)


def test_swing_of_a_tube_in_fluids() -> None:
    """w_e / m_t in place of g; rolling adds the spin of the material, 2 rho I / r^2."""
    found, _ = swing(TUBE, 0.0)
    assert found == pytest.approx(TUBE.effective_gravity, rel=4e-6)
    rolling = TUBE.mass_per_length + 2.0 * TUBE.density * TUBE.second_moment / TUBE.radius**2
    assert swing(TUBE, 0.5)[0] == pytest.approx(TUBE.effective_gravity * TUBE.mass_per_length / rolling, rel=4e-6)


@pytest.mark.parametrize("rod", [LOOSE, TUBE])
def test_braking_distance_along_the_channel(rod: fr.Rod) -> None:
    """Friction of the weight stops the mass that moves along, the material's alone."""
    mesh, speed, friction = DiscreteRod(rod, 10), 0.05, 0.1
    deceleration = friction * rod.weight_per_length / (rod.density * rod.area)

    def start(record: Any) -> None:
        mesh.nodes(record, "vx")[:] = speed

    _, records = drive(mesh, 1.5 * speed / deceleration, start, samples=3, friction=friction)
    distance = mesh.nodes(records[-1], "x") - mesh.nodes(records[0], "x")
    assert distance == pytest.approx(speed**2 / (2 * deceleration), rel=1e-6)
    assert np.abs(mesh.nodes(records[-1], "vx")).max() < 1e-15
    lost = energies(mesh, records[-1])["dissipated_friction"]
    assert lost == pytest.approx(energies(mesh, records[0])["kinetic"], rel=1e-6)


@pytest.mark.kernels
def test_a_skid_ends_rolling_at_two_thirds_of_its_speed() -> None:
    mesh, speed, friction = DiscreteRod(LOOSE, 8), 1e-3, 0.2

    def start(rod: Any) -> None:
        mesh.nodes(rod, "vy")[:] = speed

    end = speed / (3.0 * friction * SHORT.gravity)
    _, records = drive(mesh, 1.02 * end, start, samples=2, friction=friction)
    across = mesh.nodes(records[-1], "vy")
    assert across == pytest.approx(2.0 / 3.0 * speed, rel=1e-2)
    assert mesh.nodes(records[-1], "spin") * SHORT.radius == pytest.approx(-across, rel=1e-9)


def pressed_apart(mesh: DiscreteRod, part: float, friction: float) -> Any:
    """Return a start in which elastic forces along the rod reach ``part`` of what friction can hold."""
    wave = math.pi / SHORT.length
    size = part * friction * ROD_MASS * SHORT.gravity / (SHORT.youngs_modulus * SHORT.area * wave**2)

    def start(rod: Any) -> None:
        mesh.nodes(rod, "x")[:] -= size * np.cos(math.pi * places(mesh))

    return start


SLIDING = SHORT.replace(ends="guided")


def test_a_stuck_rod_stays_put() -> None:
    """The nodes next to the ends, where the order falls, feel a little more than this: they slip once, and stay."""
    mesh, friction = DiscreteRod(SLIDING, 40), 0.1
    _, records = drive(mesh, 1.0, pressed_apart(mesh, 0.99, friction), samples=20, friction=friction)
    first, soon, last = (mesh.nodes(records[place], "x") for place in (0, 1, -1))
    assert np.abs(last - first)[4:-4].max() < 1e-15
    assert np.abs(last - soon).max() < 1e-15
    assert np.abs(last - first).max() < 1e-12
    assert np.abs(mesh.nodes(records[-1], "vx")).max() == 0.0


def test_static_friction_is_kinetic_friction() -> None:
    """What stays put for ever at 0.99 of the limit, above, slips at 1.02 of it."""
    mesh, friction = DiscreteRod(SLIDING, 40), 0.1
    _, records = drive(mesh, 1e-4, pressed_apart(mesh, 1.02, friction), samples=2, friction=friction)
    moved = mesh.nodes(records[-1], "x") - mesh.nodes(records[0], "x")
    assert np.abs(moved[[0, -1]]).min() > 1e-12


PUSHED = SHORT.replace(length=1.0, damping_rate=5.0)
GRIP = 0.1
LIMIT = GRIP * PUSHED.weight_per_length * PUSHED.length


@pytest.mark.parametrize("segments", [20, *(pytest.param(n, marks=pytest.mark.slow) for n in (40, 80))])
@pytest.mark.parametrize("ends", ["hinged", "clamped", "guided", "free"])
def test_a_rod_pushed_along_slides_at_the_friction_of_its_weight(ends: str, segments: int) -> None:
    """Ends carry their share of it, held across the channel or not, so no number of segments shows."""

    def pushed(part: float) -> fr.Simulation:
        return fr.simulate(
            PUSHED.replace(ends=ends),
            fr.AxialWave(part * LIMIT, 0.0, 100.0, far_end="free"),
            duration=0.1,
            friction=GRIP,
            far_force=0.0,
            segments=segments,
            frames=6,
            perturbation=fr.Perturbation(),
        )

    held, slid = pushed(0.998), pushed(1.002)
    assert np.abs(held.positions[-1] - held.positions[1])[:, 0].max() < 1e-12
    assert np.abs(held.velocities[-1]).max() < 1e-12
    assert np.diff(slid.positions[..., 0].min(axis=1)).min() > 1e-7
    assert slid.energy["dissipated_friction"][-1] == pytest.approx(
        LIMIT * np.mean(slid.positions[-1, :, 0] - slid.positions[0, :, 0]), rel=1e-3
    )


@pytest.mark.parametrize("ends", ["hinged", pytest.param("guided", marks=pytest.mark.slow)])
def test_the_friction_of_a_fed_rod_is_that_of_its_weight_along_its_way(ends: str) -> None:
    """Once the waves of the start have died down and no section moves back; the force at the fed end pays for it."""
    for segments in (20, 40, 80):
        run = fr.simulate(
            PUSHED.replace(ends=ends),
            fr.AxialWave(LIMIT, 0.0, 100.0, far_end="free", axial_damping=100.0),
            duration=0.2,
            friction=GRIP,
            far_force=0.0,
            feed_speed=0.02,
            segments=segments,
            frames=6,
            perturbation=fr.Perturbation(),
        )
        way = run.positions[-1, :, 0] - run.positions[2, :, 0]
        mean = (way.sum() - 0.5 * (way[0] + way[-1])) / segments
        lost = run.energy["dissipated_friction"]
        # Damping changes speeds between the two of a step whose mean friction is counted with.
        of_damping = 100.0 * run.time_steps.size
        assert lost[-1] - lost[2] == pytest.approx(LIMIT * mean, rel=of_damping)
        assert np.abs(run.energy_error).max() < of_damping * run.energy["work"][-1]


def test_a_bent_rod_sticks_around_the_channel() -> None:
    """Damped, for what sticks still rolls to and fro against its torsional stiffness, and loses nothing by that."""
    rod = fr.Rod.nitinol().replace(damping_rate=400.0)
    mesh, friction, mode = DiscreteRod(rod, 100), 0.1, 6
    limit = friction * rod.gravity / (rod.natural_frequency(mode) ** 2 * rod.radial_clearance)
    shape = np.sin(mode * math.pi * places(mesh))
    _, records = drive(
        mesh,
        0.6,
        lambda record: bend(mesh, record, rod.radial_clearance * np.sin(0.9 * limit * shape)),
        samples=3,
        friction=friction,
    )
    last = records[-1]
    assert np.abs(mesh.nodes(last, "vy")).max() < 1e-9
    assert np.abs(mesh.nodes(last, "spin")).max() < 1e-6
    angle = np.arctan2(mesh.nodes(last, "y"), -mesh.nodes(last, "z"))
    assert (2.0 / 100.0) * angle @ shape == pytest.approx(0.9 * limit, rel=0.02)
