"""The simulator with strings of several sections in holes of several bores."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import eigh

import floquetrod as fr
from floquetrod.simulation.driving import Driving
from floquetrod.simulation.kernels import rod_step
from floquetrod.simulation.lumping import bending_stencil
from floquetrod.simulation.rod_mesh import DiscreteRod
from floquetrod.simulation.rod_record import FIRST
from floquetrod.simulation.step_size import SAFETY, critical_time_step
from tests.driven import frequencies, stiffness
from tests.inside import beside
from tests.seams import Tuned

Floats = NDArray[np.float64]

ROD = fr.Rod.nitinol()
UNIT = ROD.critical_force
NITINOL = {"youngs_modulus": 68e9, "density": 6500.0}
STEEL = {"youngs_modulus": 200e9, "density": 7850.0}
REST, KICK = fr.Perturbation(), fr.Perturbation.modes({5: 0.01, 2: -0.004})
LOAD = fr.AxialLoad(0.3 * UNIT, 0.2 * UNIT, 150.0)
SURVEY = fr.WellPath([0.0, 1.2, 2.0, 4.0], np.radians([60.0, 75.0, 80.0, 84.0]), np.radians([10.0, 20.0, 18.0, 40.0]))

pytestmark = [
    pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning"),  # a laboratory's wires
    pytest.mark.filterwarnings("ignore::floquetrod.ResolutionWarning"),
]


def wire(*, bores: Any = ((0.0, 9.4e-3),), turned: bool = False, **changes: Any) -> fr.Rod:
    """Return a wire of nitinol, then a thinner one of steel, then a thick piece: edges anywhere in a segment."""
    sections = [
        fr.Section(length=1.31, radius=0.8e-3, **NITINOL),
        fr.Section(length=1.37, radius=0.6e-3, **STEEL),
        fr.Section(length=0.42, radius=1.1e-3, **NITINOL),
    ]
    return fr.Rod(sections=sections[::-1] if turned else sections, bores=list(bores), **changes)


def walls(**changes: Any) -> fr.Rod:
    """Return a tube of two walls, whose outer radius is the same."""
    sections = [
        fr.Section(length=length, radius=0.8e-3, inner_radius=inner, **STEEL)
        for length, inner in ((1.8, 5e-4), (1.3, 1e-4))
    ]
    return fr.Rod(sections=sections, channel_radius=4.7e-3, **changes)


STEPPED = ((0.0, 9.4e-3), (1.93, 10.1e-3))


def simulated(rod: fr.Rod, load: Any = LOAD, duration: float = 0.02, **options: Any) -> fr.Simulation:
    """Return a run."""
    given = {"segments": 64, "frames": 11, "perturbation": KICK, **options}
    return fr.SimulationProblem(rod, load, duration=duration, **given).run()


# --- one section ---


def test_sections_that_are_alike_are_one_to_the_bit() -> None:
    alike = fr.Rod(
        sections=[fr.Section(length=length, radius=0.8e-3, **NITINOL) for length in (1.0, 0.6, 1.5)],
        bores=[(0.0, 9.4e-3), (1.2, 9.4e-3)],
    )
    one, same = (
        simulated(ROD),
        simulated(alike.replace(length=3.1, sections=(), bores=(), channel_radius=4.7e-3, radius=0.8e-3, **NITINOL)),
    )
    several = simulated(alike)
    assert one.positions.tobytes() == same.positions.tobytes() == several.positions.tobytes()
    assert {name: values.tobytes() for name, values in one.energy.items()} == {
        name: values.tobytes() for name, values in several.energy.items()
    }


@pytest.mark.parametrize(
    ("changes", "options"),
    [
        ({}, {}),
        ({"ends": "clamped-guided", "damping_rate": 2.0}, {"friction": 0.1}),
        ({"ends": "free-clamped", "inclination": 1.0, "fluid_outside": 1000.0}, {"friction": ((0.0, 0.1), (1.0, 0.3))}),
        # The one quick run of a string of sections in a well would compile its kernel, for ten seconds.
        pytest.param(
            {"path": SURVEY}, {"friction": 0.1, "tool": fr.VibrationTool(0.1, 700.0, 1.0)}, marks=pytest.mark.slow
        ),
    ],
)
def test_sections_that_differ_in_strength_alone_move_as_one(changes: Any, options: Any) -> None:
    """The kernels of sections, with equal numbers in all of them; and bores that differ by a rounding."""
    pieces = [fr.Section(length=1.55, radius=0.8e-3, yield_strength=strength, **NITINOL) for strength in (1e9, 2e9)]
    string = fr.Rod(sections=pieces, bores=[(0.0, 9.4e-3), (2.0, 9.4e-3 * (1.0 + 1e-15))], **changes)
    assert string.varies
    one, several = simulated(ROD.replace(**changes), **options), simulated(string, **options)
    # In a well they are laid by their force along, not by those at the ends: 0.14 um further down.
    place = 2e-7 if string.path else 1e-9
    for name, tolerance in {
        "positions": place,
        "velocities": 5e-5,
        "contact_force": 1e4 * place,
        "end_forces": 1e-7,
    }.items():
        np.testing.assert_allclose(getattr(several, name), getattr(one, name), rtol=0.0, atol=tolerance, err_msg=name)
    assert several.time_steps.size == pytest.approx(one.time_steps.size, rel=1e-9)
    for name, values in one.energy.items():
        np.testing.assert_allclose(several.energy[name], values, rtol=1e-5, atol=1e-9, err_msg=name)


# --- the discretised string ---


def test_the_stencil_of_bending_is_that_of_a_uniform_rod() -> None:
    stencil = bending_stencil(np.full(13, 3.0), np.full(12, 3.0))
    for values, of_one in zip(stencil, (2.5, -4.0 / 3.0, 1.0 / 12.0), strict=True):
        np.testing.assert_allclose(values, 3.0 * of_one, rtol=1e-14)


def test_nodes_have_all_of_the_mass_and_weight() -> None:
    string, n = wire(fluid_outside=1000.0), 90
    mesh = DiscreteRod(string, n)
    share = np.array([0.5, *np.ones(n - 1), 0.5])
    assert share @ mesh.segment_mass == pytest.approx(string.mass_per_length * string.length, rel=1e-12)
    assert share @ mesh.mass_along == pytest.approx(string.mass_along * string.length, rel=1e-12)
    assert share @ mesh.weight_per_length * mesh.segment_length == pytest.approx(
        string.weight_per_length * string.length, rel=1e-12
    )


def test_sums_over_nodes_are_integrals_to_fourth_order() -> None:
    """Of a function without slope at the ends, where the trapezoidal rule has its own error of second order."""
    string, errors = wire(), []
    wave = 4.0 * math.pi / string.length
    for n in (93, 186):
        mesh = DiscreteRod(string, n)
        share = np.array([0.5, *np.ones(n - 1), 0.5])
        parts = ((p.rod.mass_per_length, p.start, p.end) for p in string.uniform_parts)
        whole = sum(m * (math.sin(wave * b) - math.sin(wave * a)) / wave for m, a, b in parts)
        errors.append(abs(share @ (mesh.segment_mass * np.cos(wave * mesh.places)) - whole))
    assert errors[0] < 1e-6 * string.mass_per_length * string.length
    assert errors[1] < errors[0] / 10.0


def exact(string: fr.Rod, pieces: int = 60) -> tuple[Floats, Floats, Floats]:
    """Return bending, slope and mass of Hermite elements, hinged."""
    places = np.unique([*np.linspace(0.0, string.length, pieces + 1), *(p.start for p in string.uniform_parts)])
    n = places.size
    matrices = np.zeros((3, 2 * n, 2 * n))
    along = string.along(0.5 * (places[1:] + places[:-1]) / string.length)
    for i, h in enumerate(np.diff(places)):
        here = np.ix_(range(2 * i, 2 * i + 4), range(2 * i, 2 * i + 4))
        one, two = [12, 6 * h, 4 * h * h, 2 * h * h], [36, 3 * h, 4 * h * h, -h * h]
        for k, (a, b, c, d), factor in ((0, one, along.rigidity[i] / h**3), (1, two, 1.0 / (30.0 * h))):
            matrices[k][here] += factor * np.array([[a, b, -a, b], [b, c, -b, d], [-a, -b, a, -b], [b, d, -b, c]])
        mass = [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h]]
        mass += [[54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]
        matrices[2][here] += along.inertia[i] * h / 420.0 * np.array(mass)
    kept = np.setdiff1d(np.arange(2 * n), [0, 2 * n - 2])
    bending, slope, mass = (each[np.ix_(kept, kept)] for each in matrices)
    return bending, slope, mass


@pytest.mark.parametrize("string", [wire(), walls()])
def test_bending_frequencies_are_those_of_elements_to_second_order(string: fr.Rod) -> None:
    bending, _, mass = exact(string)
    expected = np.sqrt(eigh(bending, mass, eigvals_only=True))[[0, 1, 3]]
    for n in (61, 122, 173):
        found = frequencies(DiscreteRod(string, n), "y")[[0, 1, 3]]
        assert np.abs(found / expected - 1.0).max() < 1.0 / n**2


@pytest.mark.parametrize(
    "ends",
    ["guided-free", *(pytest.param(ends, marks=pytest.mark.slow) for ends in ("free-clamped", "hinged", "clamped"))],
)
def test_linearised_forces_are_symmetric_and_the_step_is_stable(ends: str) -> None:
    string = wire(ends=ends)
    mesh = DiscreteRod(string, 61, contact_damping=0.0)
    fastest = []
    for axis in "xy":
        matrix, masses = stiffness(mesh, axis)
        scale = np.abs(matrix).max()
        np.testing.assert_allclose(matrix, matrix.T, rtol=0.0, atol=1e-6 * scale)
        values = eigh(0.5 * (matrix + matrix.T), np.diag(masses), eigvals_only=True)
        assert values[0] > -1e-6 * values[-1]
        fastest.append(math.sqrt(values[-1]))
    assert critical_time_step(mesh)[0] <= 1.001 * SAFETY * 2.0 / max(fastest)
    assert critical_time_step(mesh)[0] > 0.5 * SAFETY * 2.0 / max(fastest)


@pytest.mark.parametrize(
    ("ends", "path"),
    [
        ("free-guided", SURVEY),
        pytest.param("hinged", None, marks=pytest.mark.slow),
        *(pytest.param(ends, SURVEY, marks=pytest.mark.slow) for ends in ("hinged", "clamped")),
        pytest.param("clamped", None, marks=pytest.mark.slow),
        pytest.param("free-guided", None, marks=pytest.mark.slow),
    ],
)
def test_forces_are_the_gradient_of_the_energy(ends: str, path: Any) -> None:
    """Of bending, stretch, weight and contact, on a wall with a step and a string with steps of its own."""
    string = wire(bores=STEPPED, ends=ends, path=path)
    problem = fr.SimulationProblem(string, LOAD, segments=61, perturbation=REST, duration=0.01)
    mesh, driving = problem.mesh, problem.driving
    draw, record, step = np.random.default_rng(4), mesh.start(driving, np.zeros(62)), 1e-9
    inner = np.array([0.0, *np.ones(60), 0.0])[:, None]  # the ends are held, or take part in what holds them
    strained, way = inner * draw.normal(0.0, 1e-5, (62, 3)), inner * draw.normal(0.0, 1.0, (62, 3))

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
    rod_step._take_places(start, physics.well, physics.wall, physics)
    axes = ((1.0, 0.0, 0.0),) * 2
    if path is not None:
        axes = tuple(beside(start, FIRST + node)[1] for node in (0, 61))
    rod_step.gradient(start, physics, axes, 0.0, 0.0)
    rod_step.move_nodes(start, physics.well, physics.wall, None, physics)
    kicked = np.stack([mesh.nodes(start, f"v{name}") for name in "xyz"], axis=1) / step
    share = mesh.nodes(start, "share")
    if path is None:
        masses = np.stack([mesh.mass_along, mesh.segment_mass, mesh.segment_mass], axis=1)
        force = masses * share[:, None] * kicked
    else:
        tangent = np.stack([mesh.nodes(start, f"t{axis}") for axis in (1, 2, 3)], axis=1)
        along = np.sum(kicked * tangent, axis=1)[:, None] * tangent
        force = share[:, None] * (mesh.segment_mass[:, None] * (kicked - along) + mesh.mass_along[:, None] * along)
    assert abs(-np.sum(force * way) - slope) < 5e-6 * abs(slope)


# --- rest, balance, symmetry ---


@pytest.mark.slow
def test_a_string_laid_over_steps_of_the_wall_and_its_own_stays_at_rest() -> None:
    string = wire(bores=STEPPED, damping_rate=3.0)
    run = simulated(string, fr.AxialLoad(0.2, 0.0, 1.0), 0.05, perturbation=REST)
    gap = run.problem.mesh.clearance
    lifted = gap - np.hypot(*run.positions[0, :, 1:].T)
    assert 0.1 < run.problem.lifted < 0.3
    assert lifted.max() > 0.1 * np.ptp(gap)
    assert np.abs(run.positions[-1] - run.positions[0]).max() < 1e-7
    weight = string.weight_per_length * string.length
    share = np.array([0.5, *np.ones(63), 0.5]) * run.problem.mesh.segment_length
    assert share @ run.contact_force[-1] == pytest.approx(weight, rel=2e-3)  # small angles, indented
    assert run.left_wall == 0.0


@pytest.mark.slow
def test_a_string_turned_round_moves_as_its_mirror_image() -> None:
    kick = fr.Perturbation.modes({5: 0.01, 3: 0.004})  # which are even about the middle
    load = fr.AxialLoad(0.2 * UNIT, 0.2 * UNIT, 150.0)
    one = simulated(wire(bores=STEPPED), load, perturbation=kick)
    other = simulated(wire(bores=((0.0, 10.1e-3), (3.1 - 1.93, 9.4e-3)), turned=True), load, perturbation=kick)
    np.testing.assert_allclose(other.angle[:, ::-1], one.angle, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(other.axial_force[:, ::-1], one.axial_force, rtol=0.0, atol=1e-7)


@pytest.mark.parametrize(
    ("friction", "ends", "path"),
    [
        (0.0, "hinged", None),
        pytest.param(0.15, "free-clamped", SURVEY, marks=pytest.mark.slow),
        pytest.param(0.0, "hinged", SURVEY, marks=pytest.mark.slow),
        pytest.param(0.15, "free-clamped", None, marks=pytest.mark.slow),
    ],
)
def test_the_error_of_the_energy_balance_is_of_second_order(path: Any, friction: float, ends: str) -> None:
    string = wire(bores=STEPPED, damping_rate=0.5, ends=ends, path=path)
    load, kick = fr.AxialLoad(0.3, 0.2, 130.0, mean_at=0.0), fr.Perturbation.random(0.05, seed=2)
    errors = []
    for step in (6e-6, 3e-6):
        run = simulated(string, load, 0.05, perturbation=kick, friction=friction, time_step=step)
        errors.append(abs(run.energy_error).max() / abs(run.energy["dissipated"]).max())
    assert errors[1] < 2e-3
    assert (2.0 if friction else 3.0) < errors[0] / errors[1] < 6.0


# --- what a run is kept in ---


@pytest.mark.parametrize("path", [None, pytest.param(SURVEY, marks=pytest.mark.slow)])
def test_resumes_saves_continues_and_starts_again_to_the_bit(path: Any, tmp_path: Path, tuned: Tuned) -> None:
    tuned(element_steps_of_a_call=300 * 64, least_steps_of_a_call=300)
    string = wire(bores=STEPPED, path=path, damping_rate=0.5)
    load = fr.AxialLoad(0.3, 0.2, 130.0, mean_at=0.0)
    problem = fr.SimulationProblem(string, load, duration=0.01, segments=64, frames=3, friction=0.1, perturbation=KICK)

    def stop(done: int, of: int) -> None:
        if done >= 500:
            raise KeyboardInterrupt

    whole = problem.run()
    file = tmp_path / "run.ckpt"
    assert not problem.run(stop, checkpoint=file).complete
    assert problem.run(checkpoint=file) == whole
    assert fr.Simulation.load(whole.save(tmp_path / "run.npz")) == whole
    longer = whole.continued(0.01)
    assert longer == problem.replace(duration=0.02, frames=5).run()
    again = problem.replace(start=whole, perturbation=None).run()
    np.testing.assert_array_equal(again.positions[1:], longer.positions[3:])
    # Another string, in its sections or in its bores, is another run.
    for other in (wire(bores=STEPPED, path=path, damping_rate=0.5, turned=True), string.replace(bores=[(0.0, 9.4e-3)])):
        with pytest.raises(ValueError, match="belongs to another run, with another rod"):
            fr.SimulationProblem(other, load, **{**vars_of(problem), "segments": 64}).run(checkpoint=file)
        with pytest.raises(ValueError, match="start must be a run of the same rod"):
            problem.replace(rod=other, start=whole, perturbation=None)


def vars_of(problem: fr.SimulationProblem) -> dict[str, Any]:
    """Return the options of a problem."""
    names = ("duration", "frames", "friction", "perturbation")
    return {name: getattr(problem, name) for name in names}


@pytest.mark.slow
def test_an_ensemble_of_strings_has_the_runs_of_each() -> None:
    problem = fr.SimulationProblem(wire(bores=STEPPED), LOAD, duration=0.004, segments=64, frames=5, perturbation=KICK)
    means = [0.1, 0.5]
    found = fr.ensemble(problem, {"mean": means})
    for place, mean in enumerate(means):
        run = problem.replace(load=LOAD.with_numbers(mean, LOAD.amplitude, LOAD.frequency)).run()
        assert float(np.ravel(found["largest_angle"])[place]) == run.largest_angle.max()


@pytest.mark.slow
def test_a_run_of_a_string_is_drawn() -> None:
    run = simulated(wire(bores=STEPPED), frames=41)
    for axes in (run.plot(), run.plot_energy(), run.plot_growth()):
        assert axes.has_data()
    assert run.plot().get_ylim()[1] >= 0.1e3 * float(np.max(run.problem.mesh.clearance))


# --- the judge: growth, static limit, drag ---

TRUTH: list[dict[str, Any]] = json.loads((Path(__file__).parents[1] / "data" / "sections_truth.json").read_text())
"""Strings under loads, each twice: growing and stable."""

FLUIDS = ("fluid_inside", "fluid_outside")


def told(row: int) -> tuple[fr.Rod, fr.AxialLoad]:
    """Return a string and a load."""
    case, sections, bores, depth = TRUTH[row], [], [], 0.0
    for each in case["sections"]:
        own = {name: value for name, value in each.items() if name not in (*FLUIDS, "channel_diameter")}
        sections.append(fr.Section(**own))
        bores.append((depth, each["channel_diameter"]))
        depth += each["length"]
    fluids = {name: case["sections"][0][name] for name in FLUIDS}
    string = fr.Rod(
        sections=sections, bores=bores, inclination=case["inclination"], damping_rate=case["damping"], **fluids
    )
    weight = {"mean_at": 0.0} if case["inclination"] < 1.5 else {}
    return string, fr.AxialLoad(case["mean"], case["amplitude"], case["frequency"], **weight)


EVEN, STEPS = (0, 2, 10), (4, 6, 8)
"""Growing strings whose radius and bore are the same all along, and others."""


def grown(string: fr.Rod, load: fr.AxialLoad, rate: float, folds: float) -> tuple[fr.Simulation, Any]:
    """Return a run of so many e-foldings of a rate in 1/s, and its growth."""
    period = 2.0 * math.pi / load.frequency
    periods = max(12, math.ceil(folds / (rate * period)))
    kick = fr.Perturbation.random(1e-4, seed=1)
    run = fr.simulate(string, load, duration=periods * period, frames=16 * periods + 1, perturbation=kick)
    return run, run.growth_rate()


@pytest.mark.slow
@pytest.mark.parametrize("row", [*EVEN, *STEPS])
def test_growth_is_that_of_the_coupled_modes_within_its_error(row: int) -> None:
    """With axial waves; without steps of the clearance that error is small."""
    string, load = told(row)
    wave = fr.AxialWave(
        load.mean,
        load.amplitude,
        load.frequency,
        mean_at=load.mean_at,
        far_end="driven",
        axial_damping=string.damping_rate,
    )
    rate = string.stability(wave).growth_rate
    assert rate == pytest.approx(TRUTH[row]["growth"], rel=0.05)
    run, fit = grown(string, load, rate, 14.0 if row == 10 else 7.0)
    assert abs(fit.rate - rate) < fit.error
    assert abs(run.energy_error).max() < 1e-4 * abs(run.energy["work"]).max()
    if row in EVEN:
        assert run.problem.lifted == 0.0
        assert abs(fit.rate - rate) < 4e-3 * rate
        assert fit.error < 0.05 * rate
    else:
        assert 0.05 < run.problem.lifted < 0.15


@pytest.mark.slow
@pytest.mark.parametrize("row", [1, 3, 7, 9, 11])
def test_what_is_stable_stays(row: int) -> None:
    string, load = told(row)
    assert string.stability(load).status == "stable"
    run, fit = grown(string, load, 0.3, 7.0)
    assert fit.rate == 0.0
    assert run.largest_angle[-1] < 1e-4


@pytest.mark.slow
def test_beside_a_step_of_the_bore_a_string_grows_that_theory_calls_stable() -> None:
    """It rests off the wall along a tenth of its length, where theory has it pressed to the wall by its weight."""
    string, load = told(5)
    assert string.stability(load).status == "stable"
    run, fit = grown(string, load, 0.3, 7.0)
    assert 0.1 < run.problem.lifted < 0.15
    assert 0.4 < fit.rate < fit.model_error


@pytest.mark.parametrize("row", [0, 2])
def test_the_static_limit_is_that_of_the_continuous_string(row: int) -> None:
    """Where the push times what it shortens takes all of the energy of bending and of the weight."""
    string, critical = told(row)[0], TRUTH[row]["critical"]
    mesh, inner = DiscreteRod(string, 96), slice(1, -1)
    driving, bending = Driving(string, fr.AxialLoad(0.0, 0.0, 1.0)), stiffness(mesh, "y")[0]
    places = np.zeros((97, 97, 3))
    places[..., 1] = np.eye(97)  # each node aside by 1 m
    tangents = np.stack([mesh.tangents(each, driving)[:, 1] for each in places])
    shortened = (tangents @ tangents.T / mesh.segment_length)[inner, inner]
    wall = (mesh.weight_per_length / mesh.clearance * mesh.segment_length)[inner]
    found = 1.0 / eigh(shortened, bending + np.diag(wall), eigvals_only=True)[-1]
    assert found == pytest.approx(critical, rel=5e-5)


@pytest.mark.slow
@pytest.mark.parametrize("part", [0.96, 1.04])
def test_a_constant_push_buckles_it_beyond_the_static_limit(part: float) -> None:
    run = fr.simulate(told(0)[0], fr.AxialLoad(part * TRUTH[0]["critical"], 0.0, 1.0), duration=30.0)
    assert run.buckled == (part > 1.0)


# --- drag ---


def soft(**changes: Any) -> fr.Rod:
    """Return a string of three sections so soft that it follows a well, a thick one below and a step of the bore."""
    sections = [
        fr.Section(length=length, radius=radius, youngs_modulus=3e9, density=density)
        for length, radius, density in ((1.2, 0.8e-3, 6500.0), (1.2, 0.7e-3, 7850.0), (0.7, 1.0e-3, 6500.0))
    ]
    return fr.Rod(sections=sections, bores=[(0.0, 9.4e-3), (1.9, 9.8e-3)], damping_rate=2.0, **changes)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("inclination", "friction", "far_force"),
    [(90.0, 0.3, 0.05), (70.0, 0.4, 0.1), (80.0, ((0.0, 0.2), (1.0, 0.5), (2.2, 0.1)), 0.05)],
)
def test_drag_of_a_string_fed_down_a_channel_is_the_chain_of_its_sections(
    inclination: float, friction: Any, far_force: float
) -> None:
    string = soft(inclination=math.radians(inclination))
    well = fr.WellPath.straight(length=2.0 * string.length, inclination=math.radians(inclination))
    # Section after section from the lower end, each with the force below.
    force, along = far_force, []
    for part in string.uniform_parts[::-1]:
        pieces = friction if isinstance(friction, float) else part_of(friction, part.start, part.end)
        piece = well.part(part.start, part.end)
        depth = np.linspace(part.start, part.end, 41)
        theory = fr.Rod(**{**part.rod.as_dict(), "inclination": string.inclination}).mean_force(
            piece, pieces, bottom=part.end, far_force=force, depth=depth
        )
        along.append((depth, theory.force[-depth.size :]))
        force = theory.at_top
    run = fr.simulate(
        string,
        fr.AxialLoad(force, 0.0, 1.0, mean_at=0.0),
        far_force=far_force,
        feed_speed=0.003,
        friction=friction,
        duration=1.5,
        frames=101,
        segments=200,
        perturbation=REST,
    )
    assert run.end_forces[50:, 0].mean() == pytest.approx(force, rel=0.02)
    s = (np.arange(200) + 0.5) * string.length / 200
    depth, expected = (np.concatenate([each[k] for each in along[::-1]]) for k in (0, 1))
    # Beside an edge it presses to one node what it does not press to those about it.
    found = run.axial_force[50:].mean(axis=0)
    np.testing.assert_allclose(found[5:-5], np.interp(s, depth, expected)[5:-5], rtol=0.0, atol=0.04 * force)
    clear = np.abs(s[:, None] - [part.start for part in string.uniform_parts[1:]]).min(axis=1) > 0.12
    clear[:5] = clear[-5:] = False
    np.testing.assert_allclose(found[clear], np.interp(s, depth, expected)[clear], rtol=0.02)


def part_of(friction: Any, start: float, end: float) -> Any:
    """Return the intervals of friction between two depths."""
    inside = [(depth, value) for depth, value in friction if start < depth < end]
    return ((0.0, [value for depth, value in friction if depth <= start][-1]), *inside)


@pytest.mark.parametrize("path", [None, fr.WellPath.arc(length=4.0, inclination=(1.2, 1.4))])
def test_segments_resolve_the_section_with_the_shortest_waves(path: Any) -> None:
    string = wire(path=path)
    assert 0.0 < string.critical_force < math.inf
    problem = fr.SimulationProblem(string, LOAD, duration=0.01)
    shortest = min(part.rod.critical_half_wave for part in string.uniform_parts)
    assert problem.segments >= 10.0 * string.length / shortest
    with pytest.raises(ValueError, match="segments must be at least"):
        problem.replace(segments=math.floor(5.5 * string.length / shortest))
