"""The discretised rod against closed forms, without and with the wall."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from driven import AT_REST, FREE_SPACE, SHORT, along, bend, drive, frequency
from floquetrod._util.compilation import compiled
from floquetrod.kernels import cosserat
from floquetrod.simulation.mesh import DiscreteRod
from floquetrod.simulation.time_steps import SAFETY, critical_time_step

ROD_MASS = SHORT.mass_per_length
STIFFNESS = SHORT.flexural_rigidity


def nodes(mesh: DiscreteRod) -> np.ndarray:
    """Return the places of the nodes from 0 to 1."""
    return np.arange(mesh.segments + 1) / mesh.segments


def shaken(mesh: DiscreteRod, rng: np.random.Generator, size: float = 0.1) -> Any:
    """Return a rod with every node and every segment strained at random."""
    rod, n = mesh.straight(), mesh.segments
    for axis in "xyz":
        rod[axis][: n + 1] += size * mesh.segment_length * rng.uniform(-1, 1, n + 1)
    q = np.array([np.ones(n), *(size * rng.uniform(-1, 1, (3, n)))])
    rod["q0"][:n], rod["q1"][:n], rod["q2"][:n], rod["q3"][:n] = q / np.linalg.norm(q, axis=0)
    return rod


def become(rod: Any, other: Any) -> None:
    for name in rod.dtype.names:
        rod[name][:] = other[name]


def elastic(mesh: DiscreteRod, rod: Any) -> float:
    energies = mesh.energies(rod)
    return sum(energies[name] for name in ("stretch", "shear", "bend", "twist"))


@pytest.mark.kernels
def test_forces_and_torques_are_the_gradient_of_the_energy(rng: np.random.Generator) -> None:
    mesh = DiscreteRod(SHORT, 8)
    rod, n, step = shaken(mesh, rng), 8, 1e-12
    physics = mesh.physics(AT_REST, step, ends=cosserat.FREE)._replace(**FREE_SPACE)
    moved = rod.copy()
    compiled(cosserat.advance)(moved, 1, physics)
    mass = np.full(n + 1, mesh.segment_mass)
    mass[[0, n]] *= 0.5
    scale = mesh.rod.youngs_modulus * mesh.rod.area

    def slope(change: Any, size: float) -> float:
        sides = []
        for sign in (1.0, -1.0):
            other = rod.copy()
            change(other, sign * size)
            sides.append(elastic(mesh, other))
        return (sides[0] - sides[1]) / (2.0 * size)

    for i in range(n + 1):
        for axis in "xyz":
            found = mass[i] * moved[f"v{axis}"][i] / step
            expected = -slope(
                lambda r, h, axis=axis, i=i: r[axis].__setitem__(i, r[axis][i] + h), 1e-6 * mesh.segment_length
            )
            assert found == pytest.approx(expected, abs=1e-6 * scale)
    inertia = {"w1": mesh.inertia, "w2": mesh.cross_inertia, "w3": mesh.cross_inertia}
    for i in range(n):
        for name, moment in inertia.items():

            def turn(r: Any, angle: float, name: str = name, i: int = i) -> None:
                r[name][i] = angle
                cosserat.drift(r, 1.0, physics)

            found = moment * moved[name][i] / step
            assert found == pytest.approx(-slope(turn, 1e-6), abs=1e-6 * scale * mesh.segment_length)


@pytest.mark.kernels
def test_rigid_motion_strains_nothing(rng: np.random.Generator) -> None:
    mesh = DiscreteRod(SHORT, 8)
    rod, n = mesh.straight(), 8
    q = rng.normal(size=4)
    a, b, c, d = q / np.linalg.norm(q)
    turn = np.array(
        [
            [1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)],
            [2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)],
            [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)],
        ]
    )
    places = np.array([rod[axis][: n + 1] for axis in "xyz"])
    moved = turn @ places + rng.normal(size=(3, 1))
    for axis, values in zip("xyz", moved, strict=True):
        rod[axis][: n + 1] = values
    for name, value in zip(("q0", "q1", "q2", "q3"), (a, b, c, d), strict=True):
        rod[name][:n] = value
    assert elastic(mesh, rod) == pytest.approx(0.0, abs=1e-20)
    step = critical_time_step(mesh)[0]
    compiled(cosserat.advance)(rod, 20, mesh.physics(AT_REST, step, ends=cosserat.FREE)._replace(**FREE_SPACE))
    assert np.abs([rod[axis][: n + 1] for axis in "xyz"] - moved).max() < 1e-13


def hinged_frequency(segments: int, mode: int) -> float:
    mesh = DiscreteRod(SHORT, segments)
    exact = math.sqrt(STIFFNESS / ROD_MASS) * (mode * math.pi / SHORT.length) ** 2
    shape = 1e-6 * np.sin(mode * math.pi * nodes(mesh))

    def start(rod: Any) -> None:
        rod["y"][: segments + 1] = shape
        along(rod, segments)

    time, records = drive(mesh, 6 * math.pi / exact, start, ends=cosserat.HINGED, **FREE_SPACE)
    values = np.array([shape @ record["y"][: segments + 1] for record in records])
    return frequency(time, values, exact) / exact


def test_hinged_bending_frequencies_converge_at_second_order() -> None:
    for mode in (1, 2):
        coarse, fine = hinged_frequency(20, mode) - 1.0, hinged_frequency(40, mode) - 1.0
        assert abs(fine) < 3e-3 * mode**2
        assert coarse / fine == pytest.approx(4.0, rel=0.05)
        assert abs((4 * fine - coarse) / 3) < 3e-5 * mode**4  # what is left: rotary inertia and shear


def cantilever_frequency(segments: int) -> float:
    """Return it over the exact one; the clamp holds the slope in the middle of the first segment."""
    mesh = DiscreteRod(SHORT, segments)
    length = SHORT.length - 0.5 * mesh.segment_length
    root = 1.8751040687119611
    exact = math.sqrt(STIFFNESS / ROD_MASS) * (root / length) ** 2
    x = root * np.maximum(nodes(mesh) * SHORT.length - 0.5 * mesh.segment_length, 0.0) / length
    part = (math.cosh(root) + math.cos(root)) / (math.sinh(root) + math.sin(root))
    shape = 1e-6 * (np.cosh(x) - np.cos(x) - part * (np.sinh(x) - np.sin(x)))
    shape[:2] = 0.0

    def start(rod: Any) -> None:
        rod["y"][: segments + 1] = shape
        along(rod, segments)

    time, records = drive(mesh, 6 * math.pi / exact, start, ends=cosserat.CLAMPED, **FREE_SPACE)
    values = np.array([shape @ record["y"][: segments + 1] for record in records])
    return frequency(time, values, exact) / exact


def test_cantilever_frequency_converges() -> None:
    coarse, fine = cantilever_frequency(20) - 1.0, cantilever_frequency(40) - 1.0
    assert abs(fine) < 2e-3
    assert abs(fine) < 0.4 * abs(coarse)


@pytest.mark.parametrize("kind", ["stretch", "twist"])
def test_wave_speeds(kind: str) -> None:
    n = 40
    mesh = DiscreteRod(SHORT, n)
    speed = SHORT.wave_speed if kind == "stretch" else math.sqrt(mesh.shear_modulus / SHORT.density)
    exact = math.pi * speed / SHORT.length
    places = nodes(mesh) if kind == "stretch" else (np.arange(n) + 0.5) / n
    field = "vx" if kind == "stretch" else "w1"
    shape = np.cos(math.pi * places)

    def start(rod: Any) -> None:
        rod[field][: shape.size] = 1e-6 * shape

    time, records = drive(mesh, 6 * math.pi / exact, start, part_of_step=0.2, **FREE_SPACE)
    values = np.array([shape @ record[field][: shape.size] for record in records])
    # Equal masses on equal springs: sin(k l / 2) / (k l / 2) of the speed in a continuous rod.
    half = math.pi / (2 * n)
    assert frequency(time, values, exact) / exact == pytest.approx(math.sin(half) / half, rel=3e-5)


def test_euler_load() -> None:
    """In free space sigma^2 of mode 1 is linear in the force and vanishes at Euler's load."""
    n = 40
    mesh = DiscreteRod(SHORT, n)
    euler = STIFFNESS * (math.pi / SHORT.length) ** 2
    shape = np.sin(math.pi * nodes(mesh))
    squares = []
    for part in (0.9, 1.1):
        scale = math.sqrt(0.1 * euler * (math.pi / SHORT.length) ** 2 / ROD_MASS)

        def start(rod: Any) -> None:
            rod["y"][: n + 1] = 1e-7 * shape
            along(rod, n)

        load = fr.AxialLoad(part * euler, 0.0, 1.0)
        time, records = drive(mesh, 1.5 / scale, start, ends=cosserat.HINGED, load=load, **FREE_SPACE)
        values = np.array([shape @ record["y"][: n + 1] for record in records])
        values /= values[0]
        if part < 1.0:
            squares.append(-(frequency(time, values, scale) ** 2))
        else:
            squares.append((np.arccosh(values[-1]) / time[-1]) ** 2)
    zero = 0.9 + 0.2 * -squares[0] / (squares[1] - squares[0])
    half = math.pi / (2 * n)
    assert zero == pytest.approx((math.sin(half) / half) ** 2, rel=1e-3)


def test_static_sag() -> None:
    """Hinged, under its own weight: 5 rho A g L^4 / (384 EI) in the middle."""
    rod = SHORT.replace(length=0.2, damping_rate=150.0, channel_radius=0.1)
    mesh = DiscreteRod(rod, 30)

    def start(record: Any) -> None:
        record["z"][:] = 0.0

    _, records = drive(mesh, 0.15, start, ends=cosserat.HINGED, samples=1, contact=0.0)
    sag = -records[-1]["z"][15]
    exact = 5 * rod.mass_per_length * rod.gravity * rod.length**4 / (384 * rod.flexural_rigidity)
    assert sag == pytest.approx(exact, rel=3e-3)
    weight = mesh.energies(records[-1])["gravity"] - mesh.energies(records[0])["gravity"]
    assert weight < 0.0


def test_energy_does_not_drift_in_a_million_steps(rng: np.random.Generator) -> None:
    mesh = DiscreteRod(SHORT, 8)

    def start(rod: Any) -> None:
        become(rod, shaken(mesh, rng, 1e-3))

    seconds = 1e6 * critical_time_step(mesh)[0] * 0.5
    time, records = drive(mesh, seconds, start, samples=500, part_of_step=0.5, **FREE_SPACE)
    energies = [mesh.energies(record) for record in records]
    total = np.array([sum(e[name] for name in ("kinetic", "stretch", "shear", "bend", "twist")) for e in energies])
    slope = np.polyfit(time / seconds, total / total[0], 1)[0]
    noise = np.std(total / total[0]) / math.sqrt(len(total) / 12)
    assert abs(slope) < max(5 * noise, 1e-9)
    assert noise < 1e-2


def test_second_order_in_time(rng: np.random.Generator) -> None:
    mesh = DiscreteRod(SHORT, 10)
    first = shaken(mesh, rng, 1e-3)
    ends = []
    for part in (0.1, 0.05, 0.025):
        _, records = drive(mesh, 5e-5, lambda rod: become(rod, first), samples=1, part_of_step=part, **FREE_SPACE)
        ends.append(np.array([records[-1][axis][:11] for axis in "xyz"]))
    ratio = np.abs(ends[0] - ends[1]).max() / np.abs(ends[1] - ends[2]).max()
    assert ratio == pytest.approx(4.0, rel=0.15)


@pytest.mark.parametrize("segments", [30, 200])
def test_the_bound_on_the_step_is_sharp(segments: int, rng: np.random.Generator) -> None:
    mesh = DiscreteRod(SHORT, segments, contact_damping=0.0)
    grown = []
    for part in (0.99 / SAFETY, 1.01 / SAFETY):
        step = critical_time_step(mesh)[0] * part
        rod = shaken(mesh, rng, 1e-9)
        compiled(cosserat.advance)(rod, 3000, mesh.physics(AT_REST, step, ends=cosserat.FREE)._replace(**FREE_SPACE))
        grown.append(np.abs(rod["vy"][: segments + 1]).max())
    assert grown[0] < 1e-2
    assert not grown[1] < 1e2  # NaN included


@pytest.mark.parametrize("indentation", [1e-3, 1e-4])
def test_a_rod_laid_down_sinks_in_as_stated(indentation: float) -> None:
    mesh = DiscreteRod(SHORT, 10, indentation=indentation)

    def start(rod: Any) -> None:
        rod["z"][:] = -SHORT.radial_clearance

    _, records = drive(mesh, 0.1, start, samples=1)
    depth = -records[-1]["z"][:11] - SHORT.radial_clearance
    assert depth == pytest.approx(indentation * SHORT.radial_clearance, rel=1e-6)
    energies = mesh.energies(records[-1])
    start_energy = mesh.energies(records[0])
    lost = start_energy["gravity"] + start_energy["contact"] - energies["gravity"] - energies["contact"]
    assert energies["dissipated_contact"] == pytest.approx(lost, rel=1e-2)


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_swing(friction: float) -> None:
    """Without friction sqrt(g / R); rolling adds half the mass to what moves, sqrt(2 g / (3 R)), and loses nothing."""
    mesh = DiscreteRod(SHORT, 10)
    rest = SHORT.radial_clearance + mesh.depth_at_rest
    exact = math.sqrt(SHORT.gravity / rest / (1.5 if friction else 1.0))
    time, records = drive(
        mesh, 6 * math.pi / exact, lambda rod: bend(rod, mesh, np.full(11, 1e-3 * rest)), friction=friction
    )
    angle = np.array([np.arctan2(record["y"][5], -record["z"][5]) for record in records])
    assert frequency(time, angle, exact) == pytest.approx(exact, rel=2e-6)
    assert np.ptp(angle[-60:]) == pytest.approx(np.ptp(angle[:60]), rel=1e-3)


def test_braking_distance_along_the_channel() -> None:
    mesh = DiscreteRod(SHORT, 10)
    speed, friction = 0.05, 0.1

    def start(rod: Any) -> None:
        rod["vx"][:11] = speed

    stop = speed / (friction * SHORT.gravity)
    _, records = drive(mesh, 1.5 * stop, start, samples=3, friction=friction)
    distance = np.mean(records[-1]["x"][:11] - records[0]["x"][:11])
    assert distance == pytest.approx(speed**2 / (2 * friction * SHORT.gravity), rel=1e-6)
    assert np.abs(records[-1]["vx"][:11]).max() == 0.0
    lost = mesh.energies(records[-1])["dissipated_friction"]
    assert lost == pytest.approx(mesh.energies(records[0])["kinetic"], rel=1e-6)


@pytest.mark.kernels
def test_a_skid_ends_rolling_at_two_thirds_of_its_speed() -> None:
    mesh = DiscreteRod(SHORT, 8)
    speed, friction = 1e-3, 0.2

    def start(rod: Any) -> None:
        rod["vy"][:9] = speed

    end = speed / (3.0 * friction * SHORT.gravity)
    _, records = drive(mesh, 1.02 * end, start, samples=2, friction=friction)
    last = records[-1]
    assert last["vy"][:9] == pytest.approx(2.0 / 3.0 * speed, rel=1e-2)
    assert last["w1"][:8] * SHORT.radius == pytest.approx(-last["vy"][:8], rel=1e-9)


def pressed_apart(mesh: DiscreteRod, part: float, friction: float) -> Any:
    """Return a start in which elastic forces along the rod reach ``part`` of what friction can hold."""
    wave = math.pi / SHORT.length
    size = part * friction * ROD_MASS * SHORT.gravity / (SHORT.youngs_modulus * SHORT.area * wave**2)

    def start(rod: Any) -> None:
        rod["x"][: mesh.segments + 1] -= size * np.cos(math.pi * nodes(mesh))

    return start


def test_a_stuck_rod_stays_put() -> None:
    mesh, friction = DiscreteRod(SHORT, 20), 0.1
    _, records = drive(mesh, 1.0, pressed_apart(mesh, 0.99, friction), samples=2, friction=friction)
    crept = np.abs(records[-1]["x"][:21] - records[0]["x"][:21]).max()
    assert crept < 1e-15
    assert np.abs(records[-1]["vx"][:21]).max() == 0.0


def test_static_friction_is_kinetic_friction() -> None:
    """What stays put for ever at 0.99 of the limit, above, slips at 1.02 of it."""
    mesh, friction = DiscreteRod(SHORT, 20), 0.1
    _, records = drive(mesh, 1e-4, pressed_apart(mesh, 1.02, friction), samples=2, friction=friction)
    assert np.abs(records[-1]["x"][[0, 20]] - records[0]["x"][[0, 20]]).min() > 1e-12


def test_a_bent_rod_sticks_around_the_channel() -> None:
    """Damped, for what sticks still rolls to and fro against its torsional stiffness, and loses nothing by that."""
    rod = fr.Rod.nitinol().replace(damping_rate=400.0)
    mesh, friction, mode = DiscreteRod(rod, 100), 0.1, 6
    limit = friction * rod.gravity / (rod.natural_frequency(mode) ** 2 * rod.radial_clearance)
    shape = np.sin(mode * math.pi * nodes(mesh))
    _, records = drive(
        mesh,
        0.6,
        lambda record: bend(record, mesh, rod.radial_clearance * np.sin(0.9 * limit * shape)),
        samples=3,
        ends=cosserat.HINGED,
        friction=friction,
    )
    for record in records[-1:]:
        assert np.abs(record["slip_t"][1:100]).max() < 1e-12
        assert np.abs(record["vy"][:101]).max() < 1e-9
        angle = np.arctan2(record["y"][:101], -record["z"][:101])
        assert (2.0 / 100.0) * angle @ shape == pytest.approx(0.9 * limit, rel=0.02)
