"""Tubes, fluids inside and outside, and inclined channels: sizes, weights, critical forces, growth, bad input."""

from __future__ import annotations

import copy
import dataclasses
import json
import math
import pickle
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import floquetrod as fr
from floquetrod import cli
from floquetrod.rod import Channel, CrossSection, Fluids
from floquetrod.rod.model.rod_in_words import special_parameters, table_of_parts
from floquetrod.units import AnswerUnits
from tests.conftest import depth
from tests.coupled_cases import solid_like
from tests.inside import ON_A_FLOOR, mode_friction

ROOT = Path(__file__).parents[3]
ROD = fr.Rod.nitinol()
INCH = 0.0254
STEEL = {"youngs_modulus": 207e9, "density": 7850.0}
WATER = {"fluid_inside": 1000.0, "fluid_outside": 1000.0}
COILED = fr.Rod(
    **STEEL,
    radius=25.4e-3,
    length=60.0,
    channel_radius=62e-3,
    inner_radius=21.44e-3,
    **WATER,
    added_mass_coefficient=2.29,
)
DAY = {name: value for name, value in dataclasses.asdict(ROD).items() if name in ROD.as_dict()}


def pushes(rod: fr.Rod, mean: float = 0.3, amplitude: float = 0.2, frequency: float = 3.0) -> fr.AxialLoad:
    """Return a uniform load in units of the rod's own critical force and pendulum frequency."""
    unit = rod.critical_force
    return fr.AxialLoad(mean * unit, amplitude * unit, frequency * rod.pendulum_frequency, mean_at=None)


# --- known numbers ---

# API 5ST sizes and a drill pipe: OD, wall, hole in inches; w_e N/m, EI kN m^2, R mm, F_p kN, half wave m.
SIZES = [
    (1.25, 0.109, 4.000, 16.9, 5.5, 34.9, 3.27, 5.8),
    (1.50, 0.125, 4.892, 23.4, 11.1, 43.1, 4.91, 6.7),
    (1.75, 0.134, 4.892, 29.5, 19.3, 39.9, 7.54, 7.1),
    (2.00, 0.156, 4.778, 39.2, 33.3, 35.3, 12.2, 7.4),
    (2.375, 0.175, 4.778, 52.4, 63.4, 30.5, 20.9, 7.7),
    (2.875, 0.204, 6.184, 74.2, 132.0, 42.0, 30.6, 9.2),
    (5.0, 0.362, 8.500, 229.0, 1228.0, 44.4, 159.0, 12.4),
]


@pytest.mark.parametrize(("od", "wall", "hole", "weight", "rigidity", "clearance", "force", "half_wave"), SIZES)
def test_sizes_of_the_trade(
    od: float,
    wall: float,
    hole: float,
    weight: float,
    rigidity: float,
    clearance: float,
    force: float,
    half_wave: float,
) -> None:
    sizes = {"diameter": od * INCH, "wall_thickness": wall * INCH, "channel_diameter": hole * INCH}
    pipe = fr.Rod(**STEEL, **sizes, length=100.0, **WATER)
    assert pipe.weight_per_length == pytest.approx(weight, rel=0.01)
    assert pipe.flexural_rigidity == pytest.approx(1e3 * rigidity, rel=0.01)
    assert pipe.radial_clearance == pytest.approx(1e-3 * clearance, rel=0.01)
    assert pipe.critical_force == pytest.approx(1e3 * force, rel=0.01)
    assert pipe.critical_half_wave == pytest.approx(half_wave, rel=0.01)


def test_coiled_tubing() -> None:
    assert COILED.flexural_rigidity == pytest.approx(33317.25, abs=5e-3)
    assert COILED.mass_per_length == pytest.approx(10.65992, abs=5e-6)
    assert COILED.weight_per_length == pytest.approx(39.15809, abs=5e-6)
    assert COILED.critical_force == pytest.approx(11940.84, abs=5e-3)
    assert COILED.wave_speed == pytest.approx(5135.117, abs=5e-4)
    assert COILED.stability(fr.AxialLoad.hertz(5970.42, 3582.252, 4.0)).growth_rate == pytest.approx(1.459902, abs=2e-6)
    longer = COILED.replace(length=120.0).stability(fr.AxialLoad.hertz(5970.42, 3582.252, 3.0))
    assert longer.growth_rate == pytest.approx(1.404350, abs=2e-6)


def test_an_inclined_rod_grows_as_known() -> None:
    load = fr.AxialLoad(0.2 * ROD.critical_force, 0.2 * ROD.critical_force, 150.0)
    assert ROD.critical_force == pytest.approx(1.6960286, abs=5e-8)
    assert ROD.stability(load).growth_rate == pytest.approx(4.2356815, abs=5e-8)
    inclined, even = ROD.replace(inclination=math.radians(60.0)), replace(load, mean_at=None)
    assert inclined.stability(even).growth_rate == pytest.approx(2.827163, abs=5e-7)
    assert inclined.growth_rate(even, mean=load.mean, amplitude=load.amplitude, frequency=150.0) == pytest.approx(
        2.827163, abs=5e-7
    )
    assert inclined.critical_force == pytest.approx(ROD.critical_force * math.sqrt(math.sin(math.radians(60.0))))


def test_growth_is_that_of_the_equation_of_motion_integrated() -> None:
    # m_t q'' + 2 c m_t q' + (EI k^4 - F(t) k^2 + w_e sin(inclination) / R) q = 0, by another method altogether.
    rod = COILED.replace(inclination=math.radians(50.0), damping_rate=0.2)
    load = pushes(rod, 0.5, 0.4, 2.0)
    verdict = rod.stability(load)
    mode, k = verdict.fastest_mode, verdict.fastest_mode * math.pi / rod.length  # type: ignore[operator]
    solid, bore, outer = (math.pi * x for x in (0.0254**2 - 0.02144**2, 0.02144**2, 0.0254**2))
    inertia = 7850.0 * solid + 1000.0 * bore + 2.29 * 1000.0 * outer
    weight = 9.81 * (7850.0 * solid + 1000.0 * bore - 1000.0 * outer) * math.sin(math.radians(50.0))
    rigidity = 207e9 * math.pi * (0.0254**4 - 0.02144**4) / 4.0

    def motion(t: float, y: np.ndarray) -> list[float]:
        force = load.mean + load.amplitude * math.sin(load.frequency * t)
        stiffness = rigidity * k**4 - force * k**2 + weight / (0.062 - 0.0254)
        return [y[1], -0.4 * y[1] - stiffness / inertia * y[0]]

    period = 2.0 * math.pi / load.frequency
    ends = [solve_ivp(motion, (0.0, period), start, rtol=1e-12, atol=1e-14).y[:, -1] for start in ([1, 0], [0, 1])]
    growth = math.log(max(abs(np.linalg.eigvals(np.array(ends).T)))) / period
    assert mode is not None
    assert verdict.growth_rate == pytest.approx(growth, rel=1e-8)
    assert growth > 0.1


# --- what must not change, and what must be the same ---


def test_a_plain_rod_is_what_it_was_to_the_bit() -> None:
    plain = fr.Rod(**DAY, inner_radius=0.0, fluid_inside=0.0, fluid_outside=0.0, inclination=math.pi / 2)
    assert plain == ROD
    assert repr(plain) == repr(ROD) == f"Rod({', '.join(f'{name}={value!r}' for name, value in DAY.items())})"
    area, second = math.pi * ROD.radius**2, 0.25 * math.pi * ROD.radius**4
    assert (ROD.area, ROD.second_moment) == (area, second)
    assert (ROD.mass_per_length, ROD.flexural_rigidity) == (6500.0 * area, 68e9 * second)
    assert ROD.effective_gravity == 9.81
    assert ROD.pendulum_frequency == math.sqrt(9.81 / ROD.radial_clearance)
    assert ROD.weight_per_length == pytest.approx(9.81 * 6500.0 * area, rel=1e-15)
    assert special_parameters(ROD, AnswerUnits.named()) == ""


@pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")
@settings(max_examples=depth(200, 50), deadline=None)
@given(st.floats(1e-6, 10.0), st.floats(100.0, 2e4), st.floats(1e-3, 100.0))
def test_gravity_of_plain_rods_keeps_every_bit(radius: float, density: float, gravity: float) -> None:
    rod = fr.Rod(1e11, density, radius, 1000.0 * radius, 2.0 * radius, gravity)
    assert rod.effective_gravity == gravity
    assert rod.mass_per_length == density * (math.pi * radius**2)


tubes = st.builds(
    lambda wall, gap, inside, buoyancy, added, inclination: fr.Rod(
        **STEEL,
        radius=0.03,
        wall_thickness=wall * 0.03,
        length=50.0,
        channel_radius=0.03 * (1.0 + gap),
        fluid_inside=inside,
        fluid_outside=buoyancy * 7850.0 * (1.0 - (1.0 - wall) ** 2),  # a share of the weight of the steel
        added_mass_coefficient=added,
        inclination=inclination,
    ),
    st.floats(0.1, 0.9),
    st.floats(0.2, 4.0),
    st.floats(0.0, 2000.0),
    st.floats(0.0, 0.9),
    st.floats(0.0, 5.0),
    st.floats(0.2, math.pi / 2),
)


@settings(max_examples=depth(25, 6), deadline=None)
@given(tubes)
def test_a_tube_is_the_solid_rod_of_the_same_stiffness_inertia_and_weight(tube: fr.Rod) -> None:
    alike = solid_like(tube)
    solid = alike.replace(gravity=alike.gravity * math.sin(tube.inclination), inclination=0.5 * math.pi)
    assert tube.critical_force == pytest.approx(solid.critical_force, rel=1e-12)
    assert tube.critical_mode == pytest.approx(solid.critical_mode, rel=1e-12)
    load = pushes(tube)
    one, other = tube.modal_system(load, range(1, 20)), solid.modal_system(load, range(1, 20))
    assert one.alpha == pytest.approx(other.alpha, rel=1e-11)
    assert np.abs(one.beta - other.beta).max() <= 1e-11 * np.abs(other.beta).max()
    assert tube.modes_needed(load)[0] == solid.modes_needed(load)[0]
    assert tube.growth_rate(load) == pytest.approx(
        solid.growth_rate(mean=load.mean, amplitude=load.amplitude, frequency=load.frequency), rel=1e-6, abs=1e-9
    )
    # Friction acts through the contact force per length, w_e sin(inclination), over the inertia.
    kicked = mode_friction(tube, 0.2, 0.05, 0.0, load.frequency)
    assert kicked.gamma == pytest.approx(mode_friction(solid, 0.2, 0.05, 0.0, load.frequency).gamma, rel=1e-12)


@settings(max_examples=depth(25, 6), deadline=None)
@given(tubes)
def test_a_tube_is_its_data_sheet(tube: fr.Rod) -> None:
    assert eval("fr." + repr(tube)) == tube == pickle.loads(pickle.dumps(tube)) == copy.deepcopy(tube)
    assert fr.Rod(**json.loads(json.dumps(tube.as_dict()))) == tube
    assert tube.section == CrossSection(tube.radius, tube.inner_radius)
    assert tube.fluids == Fluids(tube.fluid_inside, tube.fluid_outside, tube.added_mass_coefficient)
    assert tube.channel == Channel(tube.channel_radius, tube.gravity, tube.inclination)
    assert hash(tube) == hash(tube.replace(damping_rate=0.0))


def test_maps_ranges_and_kicks_take_tubes() -> None:
    rod = COILED.replace(inclination=math.radians(70.0), damping_rate=0.05)
    load = pushes(rod, 0.3, 0.3, 2.5)
    unstable = rod.growth_rate(load) > 0.0
    assert rod.is_stable(load) != unstable
    found = rod.ranges("mean", load, growth_tolerance=0.01)
    assert (load.mean in found) == rod.stability(load, growth_tolerance=0.01).stable
    span = (0.0, rod.critical_force, 4)
    chart = fr.stability_map(rod, load, mean=span, frequency=(5.0, 20.0, 3))
    assert chart.subject["rod"] == rod.as_dict()
    assert "inclination" in chart.subject["rod"]
    # The critical kick's verdict is that of the mode equation, whose friction is mu w_e sin(inclination) per length.
    verdict = rod.stability(load, friction=0.3, kick=0.05)
    gamma = 4.0 * verdict.in_modes.mu_theta * rod.weight_per_length * math.sin(rod.inclination)
    gamma /= math.pi * rod.mass_per_length * load.frequency**2 * rod.radial_clearance
    assert verdict.in_modes.gamma == pytest.approx(gamma, rel=1e-12)


# --- sizes by other names ---


def test_diameters_and_walls_stand_for_radii() -> None:
    by_radii = {"radius": 0.0254, "inner_radius": 0.021, "channel_radius": 0.062}
    rod = fr.Rod(**STEEL, length=60.0, **by_radii)
    assert fr.Rod(**STEEL, length=60.0, diameter=0.0508, inner_diameter=0.042, channel_diameter=0.124) == rod
    walled = fr.Rod(**STEEL, length=60.0, radius=0.0254, wall_thickness=0.0044, channel_radius=0.062)
    assert walled.inner_radius == pytest.approx(0.021, rel=1e-15)
    assert fr.Rod(**STEEL, length=60.0, diameter=0.0508, inner_diameter=0.0, channel_diameter=0.124).inner_radius == 0.0


def test_replace_takes_them_too() -> None:
    assert COILED.replace(diameter=0.06).radius == 0.03
    assert COILED.replace(diameter=0.06).inner_radius == COILED.inner_radius
    assert COILED.replace(wall_thickness=0.0054).inner_radius == pytest.approx(0.02, rel=1e-15)
    assert COILED.replace(diameter=0.06, wall_thickness=0.01).inner_radius == pytest.approx(0.02, rel=1e-15)
    assert COILED.replace(channel_diameter=0.2).channel_radius == 0.1
    with pytest.raises(ValueError, match=r"^diameter must not be given with radius"):
        COILED.replace(diameter=0.06, radius=0.03)


SIZED = {**STEEL, "radius": 0.0254, "length": 60.0, "channel_radius": 0.062}


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"inner_radius": 0.0254}, ValueError, "inner_radius.* must be less than the outer radius"),
        ({"inner_radius": 0.03}, ValueError, "half of channel_diameter|half of inner_diameter"),
        ({"inner_radius": 0.0254 * (1.0 - 1e-9)}, ValueError, "inner_radius.* must be less than the outer radius"),
        ({"inner_radius": -0.01}, ValueError, "inner_radius must be zero or more"),
        ({"inner_radius": "21min"}, ValueError, "inner_radius must be a number with a length unit"),
        ({"inner_diameter": 0.0508}, ValueError, "inner_radius.* must be less than the outer radius"),
        ({"inner_diameter": -0.1}, ValueError, "inner_diameter must be zero or more"),
        ({"wall_thickness": 0.0254}, ValueError, "wall_thickness must be less than the outer radius"),
        ({"wall_thickness": 0.0}, ValueError, "wall_thickness must be greater than zero"),
        ({"diameter": 0.0508}, ValueError, "diameter must not be given with radius, got 0.0508 and 0.0254"),
        ({"channel_diameter": 0.124}, ValueError, "channel_diameter must not be given with channel_radius"),
        ({"inner_radius": 0.02, "inner_diameter": 0.04}, ValueError, "inner_diameter must not .* with inner_radius"),
        ({"inner_radius": 0.0, "wall_thickness": 0.004}, ValueError, "wall_thickness must not .* with inner_radius"),
        ({"inner_diameter": 0.04, "wall_thickness": 0.0054}, ValueError, "wall_thickness must not .* inner_diameter"),
        ({"radius": None}, TypeError, "radius must be given, in m, or diameter, or sections$"),
        ({"radius": None, "wall_thickness": 1e-4}, TypeError, "radius must be given, in m, or diameter, or sections$"),
        ({"length": None}, TypeError, "length must be given, in m, or sections$"),
        ({"channel_radius": None}, TypeError, "channel_radius must be given, in m, or channel_diameter, or bores$"),
        ({"radius": None, "diameter": 0.0}, ValueError, "^diameter must be greater than zero"),
        ({"fluid_inside": -1.0}, ValueError, "fluid_inside must be zero or more"),
        ({"fluid_outside": math.nan}, ValueError, "fluid_outside must be finite"),
        ({"added_mass_coefficient": -1.0}, ValueError, "added_mass_coefficient must be zero or more"),
        ({"inclination": 0.0}, ValueError, "inclination must be above 0 and at most pi/2"),
        ({"inclination": -0.5}, ValueError, "inclination must be above 0 and at most pi/2"),
        ({"inclination": 120.0}, ValueError, r"at most pi/2 .* got 120; .* in radians: math\.radians\(60\)"),
        ({"inclination": math.radians(120.0)}, ValueError, "inclination must be above 0 and at most pi/2"),
        ({"inclination": "60dag"}, ValueError, "inclination must be a number with a"),
        (
            {"inner_radius": 0.0253, "fluid_outside": 1000.0},
            ValueError,
            r"^fluid_outside must be lighter than the rod .* weight of -\d.* N/m: this rod floats",
        ),
        ({"fluid_outside": 7850.0}, ValueError, "this rod floats"),
        ({"fluid_outside": 7850.0 * (1.0 - 1e-12)}, ValueError, "this rod floats"),
    ],
)
def test_bad_rods(change: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        fr.Rod(**{**SIZED, **change})


def test_parts_refuse_what_rods_do() -> None:
    with pytest.raises(ValueError, match=r"inner_radius.* must be less"):
        CrossSection(0.01, 0.01)
    with pytest.raises(ValueError, match="fluid_inside must be zero or more"):
        Fluids(-1.0)
    assert Fluids().added_mass_coefficient == ON_A_FLOOR == pytest.approx(2.29, abs=2e-4)


# --- criteria, assumptions, files of simulations ---


def test_critical_forces_name_every_criterion_and_its_source() -> None:
    found = COILED.critical_forces
    ratios = {name: found[name].force / COILED.critical_force for name in list(found)[:-1]}
    expected = {"sinusoidal": 1.0, "helical, energy": 2**0.5, "helical, loading": 1.83, "helical, alone": 8**0.5}
    assert ratios == pytest.approx(expected, rel=1e-15)
    assert found["vertical"].force == pytest.approx(1.94 * (33317.25 * 39.15809**2) ** (1 / 3), rel=1e-6)
    assert all(re.search(r"[A-Z].* (19|20)\d\d$", criterion.source) for criterion in found.values())


@settings(max_examples=depth(25, 6), deadline=None)
@given(tubes, st.floats(0.3, 1.0))
def test_the_vertical_criterion_does_not_depend_on_the_inclination(tube: fr.Rod, inclination: float) -> None:
    assume(inclination != tube.inclination)
    other = tube.replace(inclination=inclination)
    assert other.critical_forces["vertical"] == tube.critical_forces["vertical"]
    assert other.critical_force != tube.critical_force


def test_results_list_what_they_neglect() -> None:
    plain = ROD.stability(pushes(ROD)).assumptions
    assert plain[:2] == ("vibration uniform along the rod, which is 0.023 axial wavelengths long", "small angles")
    assert {"linear elasticity", "the load is the compression in the wall"} < set(plain)
    inclined = ROD.replace(inclination=1.0)
    along = "the weight along the rod is neglected"
    assert along in inclined.stability(pushes(inclined)).assumptions
    assert along not in inclined.stability(replace(pushes(inclined), mean_at=0.5)).assumptions
    kicked = inclined.stability(pushes(inclined), friction=0.1, kick=0.05)
    assert along in kicked.assumptions
    wet = " ".join(COILED.stability(pushes(COILED)).assumptions)
    assert "effective force" in wet
    assert "added mass" in wet
    assert along not in wet


def test_files_of_simulations_hold_rods_as_before() -> None:
    problem = fr.SimulationProblem(ROD, fr.AxialLoad(0.3, 0.3, 150.0), segments=60, frames=3, duration=0.01)
    assert problem.as_dict()["rod"] == DAY
    assert fr.SimulationProblem.from_dict(problem.as_dict()) == problem


# --- files and the command line ---


@pytest.mark.slow
def test_the_example_file(capsys: pytest.CaptureFixture[str]) -> None:
    path = ROOT / "floquetrod/examples/tubing.toml"
    rod = fr.Rod.from_toml(path)
    water = 8.345 * 0.45359237 / 3.785411784e-3
    expected = fr.Rod(
        30e6 * 6894.757293168,
        7850.0,
        diameter=2.0 * INCH,
        wall_thickness=0.156 * INCH,
        length=60.96,
        channel_diameter=4.778 * INCH,
        fluid_inside=water,
        fluid_outside=water,
        inclination=math.radians(60.0),
    )
    assert rod.as_dict() == pytest.approx(expected.as_dict(), rel=1e-14)
    question = ["check", "--rod", str(path), "--mean", "0.5Fcr", "--amplitude", "0.3Fcr", "--frequency", "4Hz"]
    question += ["--mean-at", "none"]
    assert cli.main(question) == 0
    shown = capsys.readouterr().out
    assert "weight in fluid 2.685 lbf/ft" in shown
    assert "the weight along the rod is neglected" not in shown
    assert cli.main([*question, "--no-margins", "--assumptions"]) == 0
    assert "the weight along the rod is neglected" in capsys.readouterr().out
    assert cli.main([*question, "--no-margins", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert fr.Rod(**record["rod"]) == rod
    assert record["weight_per_length_N_per_m"] == rod.weight_per_length
    assert "the weight along the rod is neglected" in record["assumptions"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('radius = "25mm"\ndiameter = "50mm"', "diameter must not be given with radius"),
        ('radius = "25mm"\ninclination = 60', "inclination must be above 0 and at most pi/2"),
        ('radius = "25mm"\ninclination = "120deg"', "inclination must be above 0 and at most pi/2"),
        ('radius = "25mm"\nadded_mass_coefficient = "2 m"', "added_mass_coefficient must be a number with no unit"),
        ('radius = "25mm"\ninner_radius = "25mm"', "inner_radius.* must be less than the outer radius"),
        ('radius = "25mm"\nwall = 1', "unknown key 'wall'; did you mean wall_thickness"),
        ('inner_diameter = "20mm"', "missing key 'radius'"),
    ],
)
def test_bad_files(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "tube.toml"
    path.write_text(f'youngs_modulus = "207GPa"\ndensity = 7850\nlength = "60m"\nchannel_diameter = "124mm"\n{text}\n')
    with pytest.raises(ValueError, match=f"^rod file .*tube.toml: .*{message}"):
        fr.Rod.from_toml(path)


def test_ninety_degrees_are_horizontal_to_the_bit(tmp_path: Path) -> None:
    path = tmp_path / "rod.toml"
    lines = [f"{name} = {value!r}" for name, value in DAY.items()]
    path.write_text("\n".join([*lines, 'inclination = "90deg"']))
    assert fr.Rod.from_toml(path) == ROD


def test_the_table_of_sections_has_no_powers_of_ten() -> None:
    sections = [fr.Section("2.00x0.156 CT90", length="35ft"), fr.Section("2.00x0.203 CT90", length="20ft")]
    table = table_of_parts(fr.Rod(sections=sections, channel_diameter="4.778in"), AnswerUnits.named("lbf", "ft", "psi"))
    assert table is not None
    assert [row[-1] for row in table.rows] == ["90000", "90000"]
    assert not [text for row in table.rows for text in row if "e+" in text]
