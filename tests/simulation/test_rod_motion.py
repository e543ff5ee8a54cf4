"""The discretised rod in free space against closed forms: gradient of the energy, frequencies, order, time step."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod._util.compilation import compiled
from floquetrod.simulation.kernels import rod_step
from floquetrod.simulation.rod_mesh import DiscreteRod
from floquetrod.simulation.step_size import SAFETY, critical_time_step
from tests.conftest import depth
from tests.driven import (
    AT_REST,
    ENDS,
    FREE_SPACE,
    LOOSE,
    SHORT,
    at_start,
    become,
    drive,
    elastic,
    energies,
    frequencies,
    frequency,
    hold,
    places,
    shaken,
    stiffness,
)

BENDING = math.sqrt(SHORT.flexural_rigidity / SHORT.mass_per_length) / SHORT.length**2

ROOTS = {
    "hinged-hinged": math.pi,
    "guided-guided": math.pi,
    "hinged-guided": 0.5 * math.pi,
    "clamped-clamped": 4.730040744862704,
    "free-free": 4.730040744862704,
    "clamped-hinged": 3.926602312047919,
    "hinged-free": 3.926602312047919,
    "clamped-guided": 2.365020372431352,
    "guided-free": 2.365020372431352,
    "free-clamped": 1.8751040687119611,
}
"""Wavenumbers times length of the lowest vibration that bends a beam: cos k cosh k = 1 and so on, by ends."""


@pytest.mark.kernels
@pytest.mark.parametrize("friction", [1e-6, pytest.param(0.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("ends", ["-".join(pair) for pair in itertools.product(ENDS, ENDS)])
def test_forces_and_torques_are_the_gradient_of_the_energy(
    ends: str, friction: float, rng: np.random.Generator
) -> None:
    """One short step gives every node the speed that the slope of the energy says; without contact nothing rubs."""
    mesh, step = DiscreteRod(SHORT.replace(ends=ends), 8), 1e-12
    rod, (_, physics) = shaken(mesh, rng), at_start(mesh, step, friction=friction, **FREE_SPACE)
    if not friction:
        rod["angle"][:] = 0.0
    moved = rod.copy()
    compiled(rod_step.advance)(moved, 1, physics)
    share, held = mesh.nodes(rod, "share"), {0: ends.split("-")[0], 8: ends.split("-")[1]}
    scale = mesh.rod.youngs_modulus * mesh.rod.area
    motions = [("x", "vx", mesh.mass_along, 1.0), ("y", "vy", mesh.segment_mass, 1.0)]
    motions += [("z", "vz", mesh.segment_mass, 1.0), ("angle", "spin", mesh.inertia, mesh.segment_length)]
    for i in range(9):
        for place, speed, inertia, lever in motions[: 4 if friction else 3]:
            fixed = {"x": (), "angle": ("clamped", "guided")}.get(place, ("hinged", "clamped"))
            if held.get(i) in fixed:
                assert mesh.nodes(moved, speed)[i] == 0.0
                continue
            size = 1e-6 * mesh.segment_length / lever
            sides = []
            for sign in (1.0, -1.0):
                other = rod.copy()
                mesh.nodes(other, place)[i] += sign * size
                sides.append(elastic(mesh, other))
            found = inertia * share[i] * mesh.nodes(moved, speed)[i] / step
            assert found == pytest.approx((sides[1] - sides[0]) / (2.0 * size), abs=1e-6 * scale * lever)


@pytest.mark.kernels
def test_rigid_motion_strains_nothing(rng: np.random.Generator) -> None:
    mesh = DiscreteRod(LOOSE, 8)
    rod, physics = at_start(mesh, critical_time_step(mesh)[0], **FREE_SPACE)
    a, b, c, d = (q := rng.normal(size=4)) / np.linalg.norm(q)
    turn = np.array(
        [
            [1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)],
            [2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)],
            [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)],
        ]
    )
    moved = turn @ np.array([mesh.nodes(rod, axis) for axis in "xyz"]) + rng.normal(size=(3, 1))
    for axis, values in zip("xyz", moved, strict=True):
        mesh.nodes(rod, axis)[:] = values
    assert elastic(mesh, rod) == pytest.approx(0.0, abs=1e-20)
    compiled(rod_step.advance)(rod, 20, physics)
    assert np.abs([mesh.nodes(rod, axis) for axis in "xyz"] - moved).max() < 1e-13


@pytest.mark.kernels
@pytest.mark.parametrize("ends", ["-".join(pair) for pair in itertools.product(ENDS, ENDS)][:: depth(1, 3)])
def test_the_linearised_rod_is_symmetric_and_stores_no_negative_energy(ends: str) -> None:
    mesh = DiscreteRod(SHORT.replace(ends=ends), 10)
    for axis in "xyz":
        matrix, masses = stiffness(mesh, axis)
        largest = np.abs(matrix).max()
        assert np.abs(matrix - matrix.T).max() < 1e-10 * largest
        assert np.linalg.eigvalsh(0.5 * (matrix + matrix.T)).min() > -1e-10 * largest
        assert (masses > 0.0).all()


@pytest.mark.parametrize("ends", ROOTS)
def test_bending_frequencies_converge_at_fourth_order(ends: str) -> None:
    exact = BENDING * ROOTS[ends] ** 2

    def error(segments: int) -> float:
        found = frequencies(DiscreteRod(SHORT.replace(ends=ends), segments), "y")
        return float(found[found > 0.1 * exact][0] / exact - 1.0)  # but rigid motion

    coarse, fine = error(10), error(20)
    # A cantilever's is so small that the next order still counts.
    assert math.log2(coarse / fine) == pytest.approx(4.0, abs=0.7)
    # That of an infinite rod, as docs/theory/simulator.md derives it: no end adds to it.
    assert abs(fine) < 1.02 * 59.0 / 5760.0 * (ROOTS[ends] / 20.0) ** 4 + 1e-7


@pytest.mark.slow
@pytest.mark.parametrize(("inner", "fluid"), [(0.0, 0.0), (0.7e-3, 500.0)])
def test_moving_it_bends_and_stretches_at_these_frequencies(inner: float, fluid: float) -> None:
    """Steps in time included.  A tube moves along with its material alone, across with the fluids as well."""
    rod = SHORT.replace(inner_radius=inner, fluid_inside=fluid, fluid_outside=fluid, ends="hinged")
    mesh = DiscreteRod(rod, 40)
    bends = math.sqrt(rod.flexural_rigidity / rod.mass_per_length) * (math.pi / rod.length) ** 2
    stretches = math.pi * math.sqrt(rod.youngs_modulus / rod.density) / rod.length
    for field, shape, exact, tolerance in (
        ("vy", np.sin(math.pi * places(mesh)), bends, 1e-6),
        ("vx", np.cos(math.pi * places(mesh)), stretches, 3e-5),
    ):

        def start(record: Any, field: str = field, shape: np.ndarray = shape) -> None:
            mesh.nodes(record, field)[:] = 1e-6 * shape

        time, records = drive(mesh, 6 * math.pi / exact, start, part_of_step=0.2, **FREE_SPACE)
        values = np.array([shape @ mesh.nodes(record, field) for record in records])
        assert frequency(time, values, exact) == pytest.approx(exact, rel=tolerance)


@pytest.mark.parametrize(("held", "order", "within"), [(True, 4.0, 3e-7), (False, 3.0, 2e-5)])
def test_stretch_waves(held: bool, order: float, within: float) -> None:
    """Of fourth order between ends that are held along the channel, of third between ends that are pushed."""
    exact = math.pi * SHORT.wave_speed / SHORT.length
    errors = []
    for n in (20, 40):
        matrix, masses = stiffness(DiscreteRod(SHORT, n), "x")
        inner = slice(1, -1) if held else slice(None)
        scale = 1.0 / np.sqrt(masses[inner])
        squares = np.linalg.eigvalsh(scale[:, None] * matrix[inner, inner] * scale)
        errors.append(math.sqrt(squares[0 if held else 1]) / exact - 1.0)
    assert math.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)
    assert abs(errors[1]) < within


def test_twist_waves() -> None:
    n = 40
    mesh = DiscreteRod(SHORT, n)
    exact = math.pi * math.sqrt(mesh.shear_modulus / SHORT.density) / SHORT.length
    shape = np.cos(math.pi * places(mesh))

    def start(rod: Any) -> None:
        mesh.nodes(rod, "spin")[:] = 1e-6 * shape

    time, records = drive(mesh, 6 * math.pi / exact, start, friction=1e-6, part_of_step=0.2, **FREE_SPACE)
    values = np.array([shape @ mesh.nodes(record, "spin") for record in records])
    # Equal inertias on equal springs: sin(k l / 2) / (k l / 2) of the speed in a continuous rod.
    half = math.pi / (2 * n)
    assert frequency(time, values, exact) / exact == pytest.approx(math.sin(half) / half, rel=3e-5)


def test_euler_load() -> None:
    """In free space sigma^2 of mode 1 is linear in the force and vanishes at Euler's load."""
    mesh = DiscreteRod(SHORT, 10)
    euler = SHORT.flexural_rigidity * (math.pi / SHORT.length) ** 2
    shape = np.sin(math.pi * places(mesh))
    squares = []
    for part in (0.9, 1.1):
        scale = math.sqrt(0.1 * euler * (math.pi / SHORT.length) ** 2 / SHORT.mass_per_length)

        def start(rod: Any) -> None:
            mesh.nodes(rod, "z")[:] = 0.0
            mesh.nodes(rod, "y")[:] = 1e-7 * shape

        load = fr.AxialLoad(part * euler, 0.0, 1.0)
        time, records = drive(mesh, 1.5 / scale, start, load=load, **FREE_SPACE)
        values = np.array([shape @ mesh.nodes(record, "y") for record in records])
        values /= values[0]
        if part < 1.0:
            squares.append(-(frequency(time, values, scale) ** 2))
        else:
            squares.append((np.arccosh(values[-1]) / time[-1]) ** 2)
    zero = 0.9 + 0.2 * -squares[0] / (squares[1] - squares[0])
    sine = math.sin(math.pi / 20)
    # Curvature and slope of a sine as the scheme has them; the squeezed rod bends 1e-5 more easily.
    assert zero == pytest.approx((20 / math.pi * sine) ** 2 * (1.0 + sine**2 / 3.0), rel=3e-5)
    assert zero == pytest.approx(1.0, abs=3e-4)


@pytest.mark.parametrize(("ends", "part"), [("hinged", 5.0 - 4.0 / 16**2), ("clamped", 1.0), ("clamped-guided", 16.0)])
def test_static_sag(ends: str, part: float) -> None:
    """Under its own weight: w L^4 / (384 EI) times 5 hinged, 1 clamped, 16 at the guided end.

    At a hinge weight is distributed by the trapezoidal rule, as if a moment w l^2 / 12 were missing there: at 16
    segments 5 becomes 5 - 4 / 16^2.
    """
    rod = SHORT.replace(length=0.2, damping_rate=150.0, channel_radius=0.1, ends=ends)
    mesh = DiscreteRod(rod, 16)

    def start(record: Any) -> None:
        record["z"][:] = 0.0

    _, records = drive(mesh, 0.15, start, samples=1, contact=0.0)
    sag = -mesh.nodes(records[-1], "z").min()
    exact = part * rod.mass_per_length * rod.gravity * rod.length**4 / (384 * rod.flexural_rigidity)
    assert sag == pytest.approx(exact, rel=2e-4)
    assert energies(mesh, records[-1])["gravity"] < energies(mesh, records[0])["gravity"]


@pytest.mark.slow
@pytest.mark.parametrize("ends", [pytest.param("free", marks=pytest.mark.slow), "hinged-clamped"])
def test_energy_has_no_trend_in_a_million_steps(ends: str, rng: np.random.Generator) -> None:
    mesh = DiscreteRod(SHORT.replace(ends=ends), 8)

    def start(rod: Any) -> None:
        become(rod, shaken(mesh, rng, 1e-3))

    seconds = 1e6 * critical_time_step(mesh)[0] * 0.25
    time, records = drive(mesh, seconds, start, samples=500, part_of_step=0.25, **FREE_SPACE)
    total = np.array([elastic(mesh, record) + energies(mesh, record)["kinetic"] for record in records])
    slope = np.polyfit(time / seconds, total / total[0], 1)[0]
    noise = np.std(total / total[0]) / math.sqrt(len(total) / 12)
    assert abs(slope) < max(5 * noise, 1e-9)
    assert noise < 1e-2


def test_second_order_in_time(rng: np.random.Generator) -> None:
    mesh = DiscreteRod(LOOSE, 10)
    first, ends = shaken(mesh, rng, 1e-3), []
    for part in (0.1, 0.05, 0.025):
        _, records = drive(mesh, 5e-5, lambda rod: become(rod, first), samples=1, part_of_step=part, **FREE_SPACE)
        ends.append(np.array([mesh.nodes(records[-1], axis) for axis in "xyz"]))
    ratio = np.abs(ends[0] - ends[1]).max() / np.abs(ends[1] - ends[2]).max()
    assert ratio == pytest.approx(4.0, rel=0.15)


THICK = fr.Rod(youngs_modulus=68e9, density=6500.0, radius=0.01, inner_radius=0.0099, length=1.0, channel_radius=0.02)
"""A tube whose step bending limits where segments are as short as may be."""


@pytest.mark.parametrize(
    ("rod", "segments", "limit", "beyond"),
    [(LOOSE, 30, "stretch", 1.01), (SHORT, 200, "stretch", 1.01), (THICK.replace(ends="clamped"), 100, "bend", 1.02)],
)
def test_the_bound_on_the_step_is_sharp(
    rod: fr.Rod, segments: int, limit: str, beyond: float, rng: np.random.Generator
) -> None:
    mesh = DiscreteRod(rod, segments, contact_damping=0.0)
    bound, by = critical_time_step(mesh)
    assert by == limit
    grown = []
    for part in (0.99 / SAFETY, beyond / SAFETY):
        record = shaken(mesh, rng, 1e-9)
        _, physics = at_start(mesh, bound * part, **FREE_SPACE)
        compiled(rod_step.advance)(record, 3000, physics)
        grown.append(np.abs(mesh.nodes(record, "vy")).max() + np.abs(mesh.nodes(record, "vx")).max())
    assert grown[0] < 1e-2
    assert not grown[1] < 1e2  # NaN included


@pytest.mark.parametrize("ends", ["-".join(pair) for pair in itertools.product(ENDS, ENDS)])
@pytest.mark.parametrize("rod", [THICK, pytest.param(SHORT, marks=pytest.mark.slow)])
def test_no_motion_is_faster_than_the_bound_on_the_step_allows(rod: fr.Rod, ends: str) -> None:
    """Every eigenvalue, at segments as short as may be for the thick tube."""
    mesh = DiscreteRod(rod.replace(ends=ends), 40 if rod is SHORT else 100, contact_damping=0.0)
    fastest = max(frequencies(mesh, axis)[-1] for axis in "xy")
    assert SAFETY * 2.0 / fastest > 0.999 * critical_time_step(mesh)[0]


@pytest.mark.kernels
def test_damping_takes_its_own_rate_off_motion_across_and_along() -> None:
    """Free flight decays like e^(-2 c t), so that vibration decays like e^(-c t)."""
    mesh = DiscreteRod(LOOSE.replace(damping_rate=3.0), 8)
    rod, physics = at_start(mesh, 1e-5, **FREE_SPACE)
    physics = physics._replace(decay_along=math.exp(-7.0 * 1e-5))
    mesh.nodes(rod, "vx")[:], mesh.nodes(rod, "vy")[:] = 0.1, 0.2
    hold(mesh, rod)
    before = energies(mesh, rod)["kinetic"]
    compiled(rod_step.advance)(rod, 1000, physics)
    assert mesh.nodes(rod, "vx") == pytest.approx(0.1 * math.exp(-0.14), rel=1e-8)
    assert mesh.nodes(rod, "vy") == pytest.approx(0.2 * math.exp(-0.06), rel=1e-8)
    after = energies(mesh, rod)
    assert after["kinetic"] + after["dissipated_damping"] == pytest.approx(before, rel=1e-10)


@pytest.mark.kernels
def test_a_run_does_not_depend_on_how_it_is_divided(rng: np.random.Generator) -> None:
    mesh = DiscreteRod(SHORT, 8)
    load = fr.AxialLoad(0.1, 0.1, 500.0)
    rod, physics = at_start(mesh, critical_time_step(mesh)[0], load, 0.1)
    mesh.nodes(rod, "vy")[1:-1] = rng.uniform(-0.01, 0.01, 7)
    other, advance = rod.copy(), compiled(rod_step.advance)
    advance(rod, 30, physics)
    for part in (1, 12, 17):
        advance(other, part, physics)
    assert rod.tobytes() == other.tobytes()


def test_at_rest_is_at_rest() -> None:
    """Nothing but rounding moves a rod that lies on the floor, whatever its ends."""
    for ends in ENDS:
        mesh = DiscreteRod(SHORT.replace(ends=ends), 20)
        for friction in (0.0, 0.1):
            _, records = drive(mesh, 0.02, lambda rod: None, samples=1, load=AT_REST, friction=friction)
            for axis in ("vx", "vy", "vz"):
                assert np.abs(mesh.nodes(records[-1], axis)).max() < 1e-9
