"""The rod simulated in a well: forces, balance, rest, symmetry, growth against coupled modes of its own."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import expm

import floquetrod as fr
from floquetrod._util.compilation import compiled
from floquetrod.simulation.growth import fit_growth
from floquetrod.simulation.kernels import rod_step
from floquetrod.simulation.rod_record import FIRST
from floquetrod.wells.path import WellPath
from tests.conftest import some
from tests.inside import beside
from tests.seams import Tuned

ROD = fr.Rod.nitinol()
UNIT = ROD.critical_force
WEIGHT, ROOM = ROD.weight_per_length, ROD.radial_clearance
REST, KICK = fr.Perturbation(), fr.Perturbation.modes({7: 0.01})

pytestmark = pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")  # a laboratory's bends

Floats = NDArray[np.float64]


def on_path(path: WellPath, depth: float = 0.0, rod: fr.Rod = ROD) -> fr.Rod:
    """Return a rod on a path, its upper end at a measured depth."""
    return rod.replace(path=path, depth=depth)


def bend(upper: float, lower: float, turn: float = 0.0, north: float = 0.4) -> WellPath:
    """Return an arc along the rod between inclinations in degrees, which turns by as many degrees."""
    azimuth = (north, north + math.radians(turn))
    return WellPath.arc(length=ROD.length, inclination=np.radians([upper, lower]), azimuth=azimuth)


def push(mean: float, amplitude: float = 0.0, frequency: float = 1.0) -> fr.AxialLoad:
    """Return a load in critical forces, its mean in the middle of the rod."""
    return fr.AxialLoad(mean * UNIT, amplitude * UNIT, frequency, mean_at=0.5)


def simulated(rod: fr.Rod, load: Any, duration: float, **options: Any) -> fr.Simulation:
    """Return a run from rest."""
    given = {"segments": 60, "frames": 11, "perturbation": REST, **options}
    return fr.SimulationProblem(rod, load, duration=duration, **given).run()


SURVEY = WellPath([0.0, 1.2, 2.0, 3.5], np.radians([60.0, 75.0, 80.0, 84.0]), np.radians([10.0, 20.0, 18.0, 40.0]))


# --- the straight limit ---


@pytest.mark.parametrize(("inclination", "friction"), [(90.0, 0.0), (55.0, 0.0), (90.0, 0.1)])
def test_in_a_straight_well_it_moves_as_in_a_channel(inclination: float, friction: float) -> None:
    angle = math.radians(inclination)
    well = on_path(WellPath.straight(length=50.0, inclination=angle, azimuth=2.0), depth=11.0)
    kick = fr.Perturbation.modes({6: 0.01, 3: -0.02})
    (straight, bent) = (
        simulated(rod, push(0.2, 0.2, 150.0), 0.02, friction=friction, perturbation=kick)
        for rod in (ROD.replace(inclination=angle), well)
    )
    assert straight.largest_angle[-1] > 0.02
    # Of an inclined rod both are squeezed with errors of their own: 1e-9 of a segment at the ends.
    tolerances = {"positions": 1e-10, "angle": 1e-9, "velocities": 1e-5, "contact_force": 1e-8, "end_forces": 1e-12}
    for name, tolerance in tolerances.items():
        np.testing.assert_allclose(getattr(bent, name), getattr(straight, name), rtol=0.0, atol=tolerance, err_msg=name)
    for name in ("stretch", "bend", "kinetic", "dissipated", "work"):
        np.testing.assert_allclose(bent.energy[name], straight.energy[name], rtol=1e-5, atol=2e-11, err_msg=name)


# --- forces ---


@pytest.mark.parametrize("ends", ["hinged", "clamped", "free-guided"])
@pytest.mark.parametrize("natural", [0.0, 0.3, "path"])
def test_forces_are_the_gradient_of_the_energy(ends: str, natural: Any) -> None:
    rod = on_path(SURVEY, 0.1, ROD.replace(ends=ends))
    load = push(0.0)
    problem = fr.SimulationProblem(rod, load, segments=56, natural_curvature=natural, perturbation=REST, duration=0.01)
    mesh, driving = problem.mesh, problem.driving
    draw = np.random.default_rng(4)
    record, step = mesh.start(driving, np.zeros(57)), 1e-9
    inner = np.array([0.0, *np.ones(55), 0.0])[:, None]  # the ends are held, or take part in what holds them
    strained = inner * draw.normal(0.0, 1e-5, (57, 3))
    way = inner * draw.normal(0.0, 1.0, (57, 3))

    def moved(by: Floats) -> Any:
        copy = record.copy()
        for axis, name in enumerate("xyz"):
            mesh.nodes(copy, name)[:] += by[:, axis]
            mesh.nodes(copy, f"v{name}")[:] = 0.0
        return copy

    def energy(by: Floats) -> float:
        found = mesh.energies(moved(by), driving)
        return sum(found[name] for name in ("stretch", "bend", "gravity", "contact"))

    near = 1e-9
    slope = (energy(strained + near * way) - energy(strained - near * way)) / (2.0 * near)
    start, physics = moved(strained), mesh.physics(driving, step)
    axes = tuple(beside(start, FIRST + node)[1] for node in (0, 56))
    rod_step.gradient(start, physics, axes, 0.0, 0.0)
    rod_step.move_nodes(start, physics.well, None, None, physics)
    kicked = np.stack([mesh.nodes(start, f"v{name}") for name in "xyz"], axis=1) / step
    force = mesh.segment_mass * mesh.nodes(start, "share")[:, None] * kicked
    work = -np.sum(force * way)
    assert abs(work - slope) < 2e-6 * abs(slope)


def test_the_material_alone_moves_along_and_fluids_with_it_across() -> None:
    tube = ROD.replace(inner_radius=0.5e-3, fluid_inside=3000.0, fluid_outside=1000.0)
    problem = fr.SimulationProblem(on_path(SURVEY, 0.1, tube), push(0.0), segments=60, perturbation=REST, duration=0.01)
    mesh, driving = problem.mesh, problem.driving
    record, physics = mesh.start(driving, np.zeros(61)), mesh.physics(driving, 1e-6)
    places = mesh.recorded(record)[0] * [1.0, 0.5, 0.5]  # off the wall, where nothing but weight acts
    frames = mesh.axis.frames(places[:, 0])
    for axis, name in enumerate("xyz"):
        mesh.nodes(record, name)[:] = mesh.cartesian(places)[:, axis]
    rod_step.move_nodes(record, physics.well, None, None, physics)
    fall = np.stack([mesh.nodes(record, f"v{name}") for name in "xyz"], axis=1) / 1e-6
    along, up = (np.einsum("ij,ij->i", fall, axis) for axis in (frames.along, frames.up))
    inclination = SURVEY.inclination_at(0.1 + 0.5 * ROD.length + places[:, 0])
    np.testing.assert_allclose(along, tube.weight_per_length * np.cos(inclination) / tube.mass_along, rtol=1e-9)
    np.testing.assert_allclose(up, -tube.weight_per_length * np.sin(inclination) / tube.mass_per_length, rtol=1e-9)


# --- balance ---


@pytest.mark.parametrize(("friction", "ends"), [(0.0, "hinged"), (0.0, "free-clamped"), (0.15, "hinged")])
def test_the_error_of_the_energy_balance_is_of_second_order(friction: float, ends: str) -> None:
    rod = on_path(SURVEY, 0.2, ROD.replace(damping_rate=0.5, ends=ends))
    kick = fr.Perturbation.random(0.05, seed=2)
    errors = []
    for step in (1.2e-5, 6e-6):
        run = simulated(rod, push(0.5, 0.3, 130.0), 0.05, perturbation=kick, friction=friction, time_step=step)
        errors.append(abs(run.energy_error).max() / abs(run.energy["dissipated"]).max())
    assert errors[1] < 2e-3
    assert 3.0 < errors[0] / errors[1] < 5.5


@pytest.mark.slow
def test_without_contact_the_energy_wavers_as_the_square_of_the_step() -> None:
    # In a shaft so wide that a rod thrown across it meets no wall.
    wide = on_path(bend(60.0, 90.0), rod=ROD.replace(channel_radius=0.3, ends="free", gravity=1e-9))
    wavers = []
    for step in (1e-5, 5e-6):
        problem = fr.SimulationProblem(
            wide, push(0.0), duration=0.05, segments=40, perturbation=REST, frames=51, time_step=step
        )
        integration = problem._integration()
        mesh, record, draw = problem.mesh, integration.rod, np.random.default_rng(1)
        places = mesh.axis.frames(mesh.places - 0.5 * ROD.length).point
        for axis, name in enumerate("xyz"):
            mesh.nodes(record, name)[:] = places[:, axis]
            mesh.nodes(record, f"v{name}")[:] = draw.normal(0.0, 0.1, 41)
        run = integration.run(None)
        total = np.sum([run.energy[name][1:] for name in ("kinetic", "stretch", "bend", "gravity")], axis=0)
        assert run.energy["contact"][1:].max() == 0.0
        assert run.energy["bend"].max() > 0.1 * total[0]
        wavers.append(np.ptp(total) / total[0])
    assert wavers[1] < 0.02
    assert 2.5 < wavers[0] / wavers[1] < 6.0


@pytest.mark.kernels
@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_a_run_does_not_depend_on_how_it_is_divided(friction: float) -> None:
    rod = on_path(SURVEY, rod=ROD.replace(damping_rate=1.0))
    load, shape = push(0.5, 0.3, 130.0), {"segments": 56, "natural_curvature": "path"}
    problem = fr.SimulationProblem(rod, load, duration=0.01, friction=friction, **shape)
    whole, parts = (problem._integration() for _ in range(2))
    advance = rod_step.advance
    compiled(advance)(whole.rod, 100, whole.physics)
    for steps in (1, 36, 63):
        compiled(advance)(parts.rod, steps, parts.physics)
    assert whole.rod.tobytes() == parts.rod.tobytes()


def test_resumes_saves_and_loads_to_the_bit(tmp_path: Path, tuned: Tuned) -> None:
    tuned(element_steps_of_a_call=1000 * 60)
    problem = fr.SimulationProblem(
        on_path(SURVEY), push(0.5, 0.3, 130.0), duration=0.03, segments=60, frames=3, natural_curvature="path"
    )

    def stop(done: int, of: int) -> None:
        if done >= 2000:
            raise KeyboardInterrupt

    whole = problem.run()
    assert not problem.run(stop, checkpoint=tmp_path / "run.ckpt").complete
    resumed = problem.run(checkpoint=tmp_path / "run.ckpt")
    assert resumed == whole
    assert fr.Simulation.load(whole.save(tmp_path / "run.npz")) == whole


# --- rest ---


def test_at_rest_the_wall_bears_weight_and_bent_force() -> None:
    # A rod bent like the well, on its outer wall, where it bends with the radius 1 / kappa + R.
    upper, lower = math.radians(70.0), math.radians(90.0)
    kappa = (lower - upper) / ROD.length
    rod = on_path(bend(70.0, 90.0), rod=ROD.replace(damping_rate=3.0))
    run = simulated(rod, push(0.6), 0.2, natural_curvature="path")
    phi = np.linspace(upper, lower, 61)
    force = 0.6 * UNIT + WEIGHT / kappa * (np.sin(phi) - math.sin(0.5 * (upper + lower)))
    expected = WEIGHT * np.sin(phi) + force * kappa / (1.0 + kappa * ROOM)
    np.testing.assert_allclose(run.contact_force[-1][5:-5], expected[5:-5], rtol=1e-4)
    np.testing.assert_allclose(run.axial_force[-1], 0.5 * (force[1:] + force[:-1]), rtol=3e-4)
    assert (run.angle == 0.0).all() or run.largest_angle[-1] < 1e-9


@pytest.mark.parametrize("turn", [8.0, -8.0])
def test_in_a_turn_it_rests_where_weight_and_bent_force_press_it(turn: float) -> None:
    path = bend(88.0, 90.0, turn)
    rod = on_path(path, rod=ROD.replace(damping_rate=3.0))
    run = simulated(rod, push(0.6), 0.2, natural_curvature="path")
    depth = np.linspace(0.0, ROD.length, 61)
    build, side = path.curvature(depth)
    force = run.problem.driving.mean_force(depth)
    expected = np.arctan2(force * side, WEIGHT * np.sin(path.inclination_at(depth)) + force * build)
    assert 0.3 < abs(expected).max() < 0.33
    np.testing.assert_allclose(run.angle[-1], expected, rtol=0.0, atol=2e-3)


def test_a_turn_to_the_other_side_is_its_mirror_image() -> None:
    kick = {7: 0.01, 6: 0.004}
    left, right = (
        simulated(
            on_path(bend(70.0, 85.0, sign * 10.0, north=0.0)),
            push(0.5, 0.3, 130.0),
            0.03,
            perturbation=fr.Perturbation.modes({mode: sign * speed for mode, speed in kick.items()}),
        )
        for sign in (1.0, -1.0)
    )
    assert left.largest_angle[-1] > 0.1
    np.testing.assert_allclose(left.angle, -right.angle, rtol=0.0, atol=1e-8)


def test_it_does_not_matter_where_north_is() -> None:
    one, other = (
        simulated(on_path(bend(70.0, 85.0, 10.0, north)), push(0.5, 0.3, 130.0), 0.02, perturbation=KICK)
        for north in (0.0, 2.5)
    )
    np.testing.assert_allclose(one.positions, other.positions, rtol=0.0, atol=1e-10)


def test_it_does_not_matter_how_far_down_it_lies() -> None:
    angles, turns = np.radians([70.0, 85.0]), np.radians([20.0, 30.0])
    near = WellPath([0.0, ROD.length], angles, turns)
    far = WellPath([0.0, 2000.0, 6000.0, 6000.0 + ROD.length], [0.0, *angles[[0, 0]], angles[1]], turns[[0, 0, 0, 1]])
    one, other = (
        simulated(on_path(path, depth), push(0.5, 0.3, 130.0), 0.01, perturbation=KICK)
        for path, depth in ((near, 0.0), (far, 6000.0))
    )
    np.testing.assert_allclose(one.positions, other.positions, rtol=0.0, atol=1e-9)


# --- friction ---


def pushed_down(upper: float, lower: float, friction: float, far: float) -> float:
    """Return the force in N at the top of an arc that pushes an unbuckled string down it, the closed form."""
    kappa, square = (lower - upper) / ROD.length, friction**2
    part = (1.0 - square) / (1.0 + square), 2.0 * friction / (1.0 + square)

    def particular(phi: float) -> float:
        return WEIGHT / kappa * (part[0] * math.sin(phi) + part[1] * math.cos(phi))

    return (far - particular(lower)) * math.exp(friction * (lower - upper)) + particular(upper)


@pytest.mark.slow
@pytest.mark.parametrize(("upper", "lower"), [(45.0, 90.0), (90.0, 75.0)])
def test_friction_on_the_way_down_takes_what_the_closed_form_says(upper: float, lower: float) -> None:
    # Of a soft rod: the moment that bends a stiff straight one presses its ends to the wall besides.
    first, last = np.radians([upper, lower])
    well = WellPath.arc(length=2.0 * ROD.length, inclination=(first, 2.0 * last - first))
    soft = on_path(well, rod=ROD.replace(youngs_modulus=1e9))
    expected = pushed_down(first, last, 0.3, 0.4)
    load = fr.AxialLoad(expected, 0.0, 1.0, mean_at=0.0)
    run = simulated(soft, load, 1.0, friction=0.3, feed_speed=0.02, far_force=0.4, segments=270, frames=101)
    assert abs(run.end_forces[50:, 0].mean() / expected - 1.0) < 5e-3
    assert run.positions[-1, 0, 0] - run.positions[0, 0, 0] == pytest.approx(0.02, rel=2e-3)


# --- what is refused ---


@pytest.mark.parametrize(
    ("rod", "options", "message"),
    [
        (ROD, {"natural_curvature": 0.1}, r"natural_curvature is that of a rod with a path, got 0\.1 without one"),
        (ROD.replace(curvature=0.01), {}, r"rod must have a path to be simulated .* give path=WellPath\.arc"),
        (None, {"natural_curvature": "well"}, "natural_curvature must be one of 'path', got 'well'"),
        (None, {"natural_curvature": 1e4}, r"natural_curvature .*1/m, or \"path\""),
        (
            None,
            {"natural_curvature": "path", "feed_speed": 0.01},
            "natural_curvature must not be given with feed_speed",
        ),
    ],
)
def test_refuses_what_cannot_be(rod: fr.Rod | None, options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        simulated(rod or on_path(SURVEY), push(0.1), 0.01, **options)


def test_a_natural_curvature_is_given_with_its_unit() -> None:
    bent = simulated(on_path(SURVEY), push(0.1), 0.01, natural_curvature="3deg/100m")
    assert bent.problem.natural_curvature == pytest.approx(np.radians(0.03))


def test_refuses_a_path_that_bends_within_a_clearance() -> None:
    sharp = on_path(bend(60.0, 90.0), rod=ROD.replace(channel_radius=1.0))
    with pytest.raises(ValueError, match=r"rod must lie on a path that bends by less than 0\.1 of a radian"):
        simulated(sharp, push(0.0), 0.01)


# --- growth ---


def coupled_growth(upper: float, lower: float, mean: float, amplitude: float, frequency: float, ends: str) -> float:
    """Return the growth rate in 1/s by coupled modes: sines or clamped beams, Gauss quadrature, the axial wave kept."""
    s, weights = np.polynomial.legendre.leggauss(120)
    s, weights = 0.5 * ROD.length * (s + 1.0), 0.5 * ROD.length * weights
    first, last = math.radians(upper), math.radians(lower)
    kappa = (last - first) / ROD.length
    phi = first + kappa * s
    mass, middle = ROD.mass_per_length, 0.5 * (first + last)
    steady = mean * UNIT + WEIGHT / kappa * (np.sin(phi) - math.sin(middle))
    k = frequency / ROD.wave_speed
    shaken = amplitude * UNIT * np.cos(k * (s - 0.5 * ROD.length)) / math.cos(0.5 * k * ROD.length)
    shapes, slopes, stiffness = (_sines if ends == "hinged" else _clamped)(s)

    def integrals(functions: Floats, values: Floats) -> Floats:
        return (functions * (weights * values)) @ functions.T / mass

    still = stiffness - integrals(slopes, steady) + integrals(shapes, (WEIGHT * np.sin(phi) + steady * kappa) / ROOM)
    moving = -integrals(slopes, shaken) + integrals(shapes, shaken * kappa / ROOM)
    return _growth(still, moving, frequency)


def _sines(s: Floats) -> tuple[Floats, Floats, Floats]:
    k = np.arange(1, 17)[:, None] * math.pi / ROD.length
    unit = math.sqrt(2.0 / ROD.length)
    bending = ROD.flexural_rigidity / ROD.mass_per_length * np.diag(k[:, 0] ** 4)
    return unit * np.sin(k * s), unit * k * np.cos(k * s), bending


def _clamped(s: Floats) -> tuple[Floats, Floats, Floats]:
    from scipy.optimize import brentq

    many = np.arange(1, 31)
    z = np.array(
        [brentq(lambda x: math.cos(x) - 1 / math.cosh(x), (m + 0.2) * math.pi, (m + 0.8) * math.pi) for m in many]
    )
    z = z[:, None]
    over = np.exp(-z)  # sinh and cosh, divided by the larger exponential
    bottom = 0.5 * (1.0 - over**2) - over * np.sin(z)
    less = over * (np.cos(z) - np.sin(z) - over) / bottom  # 1 - sigma
    sigma, u = 1.0 - less, z * s / ROD.length
    shapes = 0.5 * (1.0 + sigma) * np.exp(-u) + 0.5 * less * np.exp(u) - np.cos(u) + sigma * np.sin(u)
    slopes = -0.5 * (1.0 + sigma) * np.exp(-u) + 0.5 * less * np.exp(u) + np.sin(u) + sigma * np.cos(u)
    unit, k = 1.0 / math.sqrt(ROD.length), z / ROD.length
    bending = ROD.flexural_rigidity / ROD.mass_per_length * np.diag(k[:, 0] ** 4)
    return unit * shapes, unit * k * slopes, bending


def _growth(still: Floats, moving: Floats, frequency: float) -> float:
    """Return the growth rate of q'' + (still + moving cos(omega t)) q = 0, by a Magnus integrator of fourth order."""
    n, steps, period = len(still), 600, 2.0 * math.pi / frequency
    h, nodes = period / steps, 0.5 + np.array([-1.0, 1.0]) * math.sqrt(3.0) / 6.0

    def equations(time: float) -> Floats:
        return np.block(
            [[np.zeros((n, n)), np.eye(n)], [-still - moving * math.cos(frequency * time), np.zeros((n, n))]]
        )

    state = np.eye(2 * n)
    for i in range(steps):
        a, b = (equations((i + node) * h) for node in nodes)
        state = expm(0.5 * h * (a + b) + math.sqrt(3.0) / 12.0 * h * h * (b @ a - a @ b)) @ state
    return math.log(abs(np.linalg.eigvals(state)).max()) / period


LOADS = (
    ((80.0, 90.0), (0.6, 0.35, 120.0)),
    ((86.0, 90.0), (0.5, 0.3, 133.0)),
    ((90.0, 86.0), (0.4, 0.25, 110.0)),
    ((70.0, 90.0), (0.7, 0.4, 130.0)),
    ((90.0, 80.0), (0.3, 0.3, 130.0)),
    ((85.0, 90.0), (0.3, 0.5, 150.0)),
    ((88.0, 90.0), (0.2, 0.25, 150.0)),
    ((60.0, 66.0), (0.6, 0.4, 120.0)),
)
"""Inclinations of the ends in degrees; mean and amplitude in critical forces of the straight rod, rad/s."""


def simulated_growth(
    angles: tuple[float, float], numbers: tuple[float, float, float], ends: str, natural: Any, segments: int = 80
) -> float:
    """Return the growth rate in 1/s of a simulated rod from tiny speeds, while its angles are below 0.005 rad."""
    period = 2.0 * math.pi / numbers[2]
    kick = fr.Perturbation.modes(dict.fromkeys((5, 6, 7, 8), 1e-12))
    rod = on_path(bend(*angles), rod=ROD.replace(ends=ends))
    options = {"perturbation": kick, "segments": segments, "frames": 70 * 16 + 1, "natural_curvature": natural}
    run = simulated(rod, push(*numbers), 70 * period, **options)
    linear = run.angle[: int(np.sum(np.logical_and.accumulate(run.largest_angle < 5e-3)))]
    fit = fit_growth(run.time[: len(linear)][len(linear) // 3 :], linear[len(linear) // 3 :], period, 0.0)
    assert fit.fit_error < 2e-3 * fit.rate
    return fit.rate


@pytest.mark.parametrize(
    ("angles", "numbers", "rate"), [(*LOADS[0], 5.8506196), (*LOADS[1], 5.2875361), (*LOADS[2], 5.1415913)]
)
def test_coupled_modes_are_those_of_the_record(angles: Any, numbers: Any, rate: float) -> None:
    # 5.8427648, 5.2757810 and 5.1337707 1/s without the axial wave.
    assert coupled_growth(*angles, *numbers, "hinged") == pytest.approx(rate, rel=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize(("angles", "numbers"), LOADS[:3])
def test_the_growth_rate_that_a_run_tells_holds_its_error(angles: Any, numbers: Any) -> None:
    period, load, rod = 2.0 * math.pi / numbers[2], push(*numbers), on_path(bend(*angles))
    wave = fr.AxialWave(load.mean, load.amplitude, load.frequency, mean_at=0.5, far_end="driven")
    kick = fr.Perturbation.random(1e-7, seed=1)
    options = {"perturbation": kick, "segments": None, "frames": 40 * 16 + 1, "natural_curvature": "path"}
    fit = simulated(rod, load, 40 * period, **options).growth_rate()
    assert abs(fit.rate - rod.stability(wave).growth_rate) < fit.error < 0.01


@pytest.mark.slow
@pytest.mark.parametrize(("angles", "numbers"), some(LOADS, 3, 2))
def test_growth_of_a_rod_bent_like_the_well_is_that_of_coupled_modes(angles: Any, numbers: Any) -> None:
    expected = coupled_growth(*angles, *numbers, "hinged")
    assert simulated_growth(angles, numbers, "hinged", "path") == pytest.approx(expected, rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("natural", [0.0, "path"])
@pytest.mark.parametrize(("angles", "numbers"), some(LOADS[:3] + LOADS[4:6] + LOADS[7:], 2, 1))
def test_growth_of_a_straight_rod_with_clamped_ends_is_that_of_coupled_modes(
    angles: Any, numbers: Any, natural: Any
) -> None:
    expected = coupled_growth(*angles, *numbers, "clamped")
    assert simulated_growth(angles, numbers, "clamped", natural) == pytest.approx(expected, rel=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("load", "rate"), [(LOADS[0], 6.19), (LOADS[1], 5.11)])
def test_a_straight_rod_with_hinged_ends_lifts_off_there_and_grows_otherwise(load: Any, rate: float) -> None:
    # As a discrete rod with springs for its wall does, by the record.
    assert simulated_growth(*load, "hinged", 0.0) == pytest.approx(rate, rel=5e-3)


@pytest.mark.slow
def test_growth_converges_with_the_square_of_the_segments() -> None:
    rates = [simulated_growth(*LOADS[0], "hinged", "path", n) for n in (60, 85, 120, 170)]
    errors = -np.diff(rates)
    assert abs(errors[2]) < 4e-5 * rates[-1]
    assert 1.5 < errors[0] / errors[1] < 2.8
    assert 1.5 < errors[1] / errors[2] < 2.8
