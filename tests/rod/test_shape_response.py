"""Guards how much a rod that is not straight moves: truth, independent integration, doors, maps, bad input."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import floquetrod as fr
from floquetrod.cli.main import main
from floquetrod.plane import Chart
from floquetrod.rod.loads.load import Loads
from floquetrod.rod.mode_equations.coupled_matrices import CoupledModes
from floquetrod.rod.mode_equations.forced_modes import ForcedModes, shape_force
from floquetrod.rod.model.natural_shape import NaturalShape
from tests.conftest import depth, some

Floats = NDArray[np.float64]

ROD = fr.Rod.nitinol().replace(damping_rate=1.0)
UNIT = ROD.critical_force
LOAD = fr.AxialLoad(0.2 * UNIT, 0.2 * UNIT, 60.0)
WIDE = ROD.replace(channel_radius=9.4e-3)
REEL = {"curvature": "0.1rad/m"}
RANDOM = {"rms": "0.1mm", "correlation_length": "0.5m"}
PLACES = np.linspace(0.0, 1.0, 401)


def shaped(shape: Any, rod: fr.Rod = ROD, **changes: Any) -> fr.Rod:
    """Return a rod with a natural shape."""
    return rod.replace(natural_shape=shape, **changes)


def natural(rod: fr.Rod) -> NaturalShape:
    """Return the natural shape of a rod that has one."""
    assert rod.natural_shape is not None
    return rod.natural_shape


# --- truth: DOP853 at a tolerance of 1e-12, of the reference rod in a channel with a radius of 9.4 mm ---


@pytest.mark.parametrize(
    ("mode", "frequency", "damping", "largest", "mean"),
    [
        (5, 60.0, 0.5, 0.074718928, 0.059605680),
        (6, 60.0, 0.5, 0.136974059, 0.075280446),
        (7, 75.0, 1.0, 0.157748219, 0.087562402),
        (8, 92.0, 0.5, 0.182051689, 0.093217842),
    ],
)
def test_deflection_is_that_of_an_integration(
    mode: int, frequency: float, damping: float, largest: float, mean: float
) -> None:
    unit = WIDE.critical_force
    rod = shaped({mode: "0.1mm"}, WIDE, damping_rate=damping)
    response = rod.response(fr.AxialLoad(0.2 * unit, 0.2 * unit, frequency), unstable=True)
    assert 1e3 * response.largest == pytest.approx(largest, rel=5e-8)
    motion = ForcedModes.of(CoupledModes.of(rod, response.load, mode), response.load, natural(rod))
    middle = motion.deflection(np.array([0.5 / mode]))[0, motion.middle, 0]
    assert 1e3 * abs(middle) == pytest.approx(mean, rel=5e-8)
    assert 1e3 * np.abs(response.mean).max() == pytest.approx(mean, rel=2e-2)  # at nodes
    assert 1e3 * response.error < 1e-9
    assert response.contact is not None
    weight = rod.weight_per_length
    assert 0.9 * weight < response.contact[0] < weight < response.contact[1] < 1.1 * weight


# --- an independent computation: the equations of motion in time ---


def integrated(system: fr.HillSystem, damping: float, force: Floats) -> Floats:
    """Return the periodic q(t) of q'' + 2 c q' + K(t) q = f at 64 instants, by DOP853 from x(T) = Phi x(0) + p."""
    n, period = system.order, float(system.period)

    def rates(t: float, flat: Floats) -> Floats:
        x = flat.reshape(2 * n, -1)
        turns = np.exp(2j * math.pi * t / period * np.arange(1, len(system.harmonics) + 1))
        stiffness = system.stiffness + np.tensordot(turns, system.harmonics, 1).real
        out = np.concatenate([x[n:], -2.0 * damping * x[n:] - stiffness @ x[:n]])
        out[n:, -1] += force
        return out.ravel()

    start = np.hstack([np.eye(2 * n), np.zeros((2 * n, 1))])
    grid = np.arange(64) * period / 64
    options: dict[str, Any] = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-14}
    whole = solve_ivp(rates, (0.0, period), start.ravel(), **options).y[:, -1].reshape(2 * n, -1)
    first = np.linalg.solve(np.eye(2 * n) - whole[:, :-1], whole[:, -1])
    motion = solve_ivp(rates, (0.0, period), first[:, None].ravel(), t_eval=grid, **options).y
    return np.asarray(motion[:n])


@pytest.mark.slow
@pytest.mark.parametrize(
    "ends", ["clamped", *(pytest.param(ends, marks=pytest.mark.slow) for ends in ("hinged-clamped", "guided"))]
)
def test_coupled_modes_move_as_their_equations_integrated_in_time(ends: str) -> None:
    rod = shaped({3: 2e-4, 5: -1e-4}, ends=ends, length=1.2)
    load = fr.AxialLoad(0.2 * UNIT, 0.3 * UNIT, 75.0, waveform=(-1j, 0.3))
    modes = CoupledModes.of(rod, load, 10)
    force, _ = shape_force(modes, natural(rod))
    motion = ForcedModes.of(modes, load, natural(rod))
    turns = np.exp(2j * math.pi * np.arange(64)[:, None] / 64 * np.arange(-motion.middle, motion.middle + 1))
    found = (turns @ motion.amplitudes[0]).real.T
    expected = integrated(modes.system(Loads.single(load)), rod.damping_rate, force[0])
    assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()


def test_a_constant_force_bends_it_as_statics_says() -> None:
    # E I (y'' - y_0'')'' + F y'' + k y = 0 in one sine, k the weight over the clearance.
    m, force = 5, 0.4 * UNIT
    response = shaped({m: 1e-4}).response(fr.AxialLoad(force, 0.0, 10.0))
    k, rigidity = m * math.pi / ROD.length, ROD.flexural_rigidity
    restoring = ROD.mass_per_length * ROD.pendulum_frequency**2
    expected = 1e-4 * rigidity * k**4 / (rigidity * k**4 - force * k**2 + restoring)
    assert response.largest == pytest.approx(expected, rel=1e-12)
    assert response.moment == pytest.approx(rigidity * k**2 * abs(expected - 1e-4), rel=1e-4)
    assert response.stress == pytest.approx(response.moment * ROD.radius / ROD.second_moment, rel=1e-12)
    assert response.angle == pytest.approx(expected / ROD.radial_clearance, rel=1e-12)


# --- one shape by several doors ---


@pytest.mark.slow
def test_sampled_sines_are_sines() -> None:
    samples = 1e-4 * np.sin(5.0 * math.pi * np.linspace(0.0, 1.0, 81))
    for ends in ("hinged", "clamped"):
        one, other = (shaped(shape, ends=ends).response(LOAD) for shape in ({5: 1e-4}, samples.tolist()))
        assert other.largest == pytest.approx(one.largest, rel=1e-5)
        assert other.stress == pytest.approx(one.stress, rel=1e-4)


@pytest.mark.slow
def test_a_bend_is_the_sum_of_its_sines() -> None:
    # kappa_0 s (s - L) / 2 has the sine amplitudes -4 kappa_0 L^2 / (pi m)^3, m odd.
    odd = np.arange(1, depth(400, 200), 2)
    sines = dict(zip(odd.tolist(), (-0.4 * ROD.length**2 / (math.pi * odd) ** 3).tolist(), strict=True))
    one, other = shaped(REEL).response(LOAD), shaped(sines).response(LOAD)
    assert one.largest == pytest.approx(other.largest, rel=1e-4)
    assert abs(one.largest - other.largest) < 2.0 * one.error + 1e-9


def test_only_what_bends_across_the_floor_moves_it() -> None:
    straight_up = shaped({"curvature": 0.1, "direction": "0deg"}).response(LOAD)
    half = shaped({"curvature": 0.1, "direction": "30deg"}).response(LOAD)
    assert straight_up.largest == 0.0
    assert half.largest == pytest.approx(0.5 * shaped(REEL).response(LOAD).largest, rel=1e-12)


@settings(max_examples=12, deadline=None)
@given(st.integers(1, 9), st.floats(-2.0, 2.0), st.floats(0.0, 0.3), st.floats(20.0, 70.0))
def test_motion_is_linear_in_the_shape(mode: int, size: float, mean: float, frequency: float) -> None:
    load = fr.AxialLoad(mean * UNIT, 0.1 * UNIT, frequency)
    unit = shaped({mode: 1e-4}).response(load, unstable=True)
    response = shaped({mode: 1e-4 * size, 12: 0.0}).response(load, unstable=True)
    assert response.largest == pytest.approx(abs(size) * unit.largest, rel=1e-9, abs=1e-18)


def test_sections_that_are_alike_move_as_a_uniform_rod() -> None:
    material: dict[str, Any] = {"youngs_modulus": ROD.youngs_modulus, "density": ROD.density}
    halves = [fr.Section(length=0.5 * ROD.length, radius=radius, **material) for radius in (8e-4, 8e-4 * (1 + 1e-9))]
    string = fr.Rod(sections=halves, channel_radius=4.7e-3, damping_rate=1.0, natural_shape={5: 1e-4})
    assert string.varies
    one, other = string.response(LOAD), shaped({5: 1e-4}).response(LOAD)
    assert one.largest == pytest.approx(other.largest, rel=1e-6)
    assert one.contact == pytest.approx(other.contact, rel=1e-5)


def test_deviations_of_a_random_shape_are_those_of_its_sines() -> None:
    response = shaped(RANDOM).response(LOAD)
    assert response.is_random
    assert response.contact is None
    numbers, deviations = natural(shaped(RANDOM))._random(ROD.length)
    next_to_ends = math.sqrt(math.tau) * 0.5 * 1e-8 / (2.0 * ROD.length)
    assert np.sum(deviations**2) / 2.0 + next_to_ends == pytest.approx(1e-8, rel=1e-3)
    time = np.array([0.01, 0.05])
    squares: Any = 0.0
    for number, deviation in zip(numbers.astype(int).tolist(), deviations.tolist(), strict=True):
        alone = shaped({number: deviation}).response(LOAD, unstable=True)
        at = [np.interp(response.positions, alone.positions, y) for y in alone.deflection(time)]
        squares = squares + np.array(at) ** 2
    np.testing.assert_allclose(response.deflection(time), np.sqrt(squares), atol=0.02 * response.largest)


def test_it_grows_without_bound_towards_an_even_tongue_and_not_towards_an_odd_one() -> None:
    rod = shaped({6: 1e-4}, damping_rate=0.05)

    def at(frequency: float) -> fr.results.RodResponse:
        """Return the response at a frequency in rad/s."""
        return rod.response(fr.AxialLoad(0.2 * UNIT, 0.1 * UNIT, frequency), unstable=True)

    at_rest: Any = rod.modal_system(LOAD.varied("amplitude", 0.0), (6,))
    free = math.sqrt(-at_rest.beta[0]) * LOAD.frequency
    even, odd = at(free), at(2.0 * free)
    assert even.distance < 0.1 < odd.distance
    assert even.largest > 20.0 * odd.largest
    undamped = shaped({6: 1e-4}, damping_rate=0.0)
    loads = (fr.AxialLoad(0.2 * UNIT, 0.05 * UNIT, free * (1.0 + d)) for d in (0.01, 0.03, 0.1))
    nearer, near, far = (undamped.response(load, unstable=True) for load in loads)
    assert nearer.distance < near.distance < far.distance
    assert nearer.largest > 1.5 * near.largest > 2.0 * far.largest


# --- maps ---


@pytest.mark.slow
@pytest.mark.parametrize("shape", [{5: 1e-4}, {4: 1e-4, 7: -2e-4}, REEL, RANDOM], ids=str)
def test_a_map_has_the_deflection_of_each_load(shape: Any) -> None:
    rod = shaped(shape)
    chart = fr.stability_map(
        rod, mean=(0.0, 0.8 * UNIT, 5), frequency=(25.0, 120.0, 6), amplitude=0.2 * UNIT, response=True
    )
    assert chart.response is not None
    np.testing.assert_array_equal(np.isfinite(chart.response), chart.stable)
    for j, i in np.argwhere(chart.stable)[::4]:
        load = fr.AxialLoad(chart.y.values[j], 0.2 * UNIT, chart.x.values[i])
        assert chart.response[j, i] == pytest.approx(rod.response(load).largest, rel=6e-3)


@pytest.mark.slow
def test_a_map_of_coupled_modes_has_the_deflection_of_each_load() -> None:
    rod = shaped({3: 1e-4}, ends="clamped", length=1.2)
    chart = fr.stability_map(
        rod, mean=0.1 * UNIT, frequency=(30.0, 60.0, 2), amplitude=(0.0, 0.1 * UNIT, 2), response=True
    )
    assert chart.response is not None
    load = fr.AxialLoad(0.1 * UNIT, chart.y.values[1], chart.x.values[1])
    assert chart.response[1, 1] == pytest.approx(rod.response(load).largest, rel=1e-12)


def test_a_map_with_deflections_is_saved_and_read(tmp_path: Path) -> None:
    chart = fr.stability_map(
        shaped({5: 1e-4}), mean=(0.0, UNIT, 4), frequency=(25.0, 120.0, 5), amplitude=0.2 * UNIT, response=True
    )
    chart.save(tmp_path / "map.npz")
    again = Chart.load(tmp_path / "map.npz")
    np.testing.assert_array_equal(again.response, chart.response)


# --- a rod with a shape is a value ---


@pytest.mark.parametrize("shape", [{5: "0.1mm"}, [0.0, 1e-4, 2e-4, 3e-4, 1e-4, 0.0], REEL, RANDOM], ids=str)
def test_a_shape_comes_back_as_it_was(shape: Any, tmp_path: Path) -> None:
    rod = shaped(shape)
    assert eval(repr(rod), {"Rod": fr.Rod}) == rod
    assert hash(fr.Rod(**rod.as_dict())) == hash(rod)
    assert rod.replace(length=3.0).natural_shape == rod.natural_shape
    file = tmp_path / "rod.toml"
    table = rod.as_dict()
    text = table.pop("natural_shape")
    lines = [f"{key} = {json.dumps(value)}" for key, value in table.items()]
    file.write_text("\n".join([*lines, "[natural_shape]", *(f'"{k}" = {json.dumps(v)}' for k, v in text.items())]))
    assert fr.Rod.from_toml(file) == rod
    assert rod != ROD


def test_a_shape_changes_no_verdict() -> None:
    for load in (LOAD, LOAD.varied("frequency", 150.0)):
        assert shaped({5: 1e-4}).stability(load).growth_rate == ROD.stability(load).growth_rate


def test_the_terminal_says_what_python_says(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "rod.toml"
    file.write_text("\n".join(f"{k} = {v!r}" for k, v in ROD.as_dict().items()) + '\n[natural_shape]\n5 = "0.1mm"\n')
    load = ["--mean", "0.2Fcr", "--amplitude", "0.2Fcr", "--frequency", "60rad/s"]
    assert main(["check", "--rod", str(file), *load, "--json", "--no-margins"]) == 0
    assert json.loads(capsys.readouterr().out)["moves_m"] == pytest.approx(shaped({5: 1e-4}).response(LOAD).largest)
    assert main(["check", "--rod", str(file), *load, "--no-margins"]) == 0
    assert "moves     by up to 0.069 mm, 1.01 degrees" in capsys.readouterr().out


def test_a_response_reports_and_draws_itself() -> None:
    response = shaped({5: 1e-4}).response(LOAD)
    text = str(response)
    assert "moves by up to 0.069 mm, 1.01 degrees, at" in text
    assert "natural shape 0.1 mm sin(5 pi s / L)" in text
    numbers = response.as_dict()
    assert numbers["largest_m"] == response.largest
    assert numbers["contact_N_per_m"][0] < ROD.weight_per_length
    axes = response.plot()
    assert "mm" in axes.get_ylabel()
    large = shaped({5: 3e-3}).response(LOAD)
    assert "small angles are assumed" in str(large)


# --- bad input, in one line each ---


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        (5, "natural_shape must be"),
        ("random", "natural_shape must be"),
        ({}, "natural_shape: keys must be"),
        ({"mode": 5}, "natural_shape: keys must be"),
        ({0: 1e-4}, "half waves must be from 1"),
        ({-3: 1e-4}, "keys must be"),
        ({3000: 1e-4}, "half waves must be from 1 to 2000, got 3000"),
        ({5: "1kg"}, "amplitude of 5 half waves must be a number with a length unit"),
        ({5: math.nan}, "amplitude of 5 half waves"),
        ({5: None}, "amplitude of 5 half waves"),
        ([0.0, 1e-4], "deflection must have 6 values at least, got 2"),
        ([0.0, 0.0, 0.0, "1s", 0.0, 0.0], r"deflection\[3\]"),
        ([[0.0] * 6] * 2, "natural_shape must be"),
        ({"curvature": 0.0}, "curvature must not be 0"),
        ({"curvature": "1m"}, "curvature"),
        ({"curvature": 0.1, "direction": "1m"}, "direction"),
        ({"curvature": 0.1, "angle": 1.0}, "keys must be"),
        ({"rms": "0.1mm"}, "keys must be"),
        ({"rms": -1.0, "correlation_length": 1.0}, "rms must be greater than zero"),
        ({"rms": 1e-4, "correlation_length": 0.0}, "correlation_length must be greater than zero"),
    ],
)
def test_a_wrong_shape_is_refused_in_one_line(shape: Any, words: str) -> None:
    with pytest.raises((TypeError, ValueError), match=words) as error:
        shaped(shape)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("rod", "load", "words"),
    [
        (ROD, LOAD, "natural_shape must be given for a response"),
        (shaped({5: 1e-4}), LOAD.varied("frequency", 110.0), "load must leave the rod stable.*unstable=True"),
        (shaped({5: 1e-4}), fr.AxialLoad(0.3, 0.1, 60.0, noise=1e-6), "without noise"),
        (shaped({"rms": 1e-4, "correlation_length": 1e-3}), LOAD, "give a longer one"),
    ],
)
def test_what_has_no_answer_is_refused(rod: fr.Rod, load: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words) as error:
        rod.response(load)
    assert "\n" not in str(error.value)


def test_a_map_without_a_shape_is_refused() -> None:
    with pytest.raises(ValueError, match="natural_shape must be given"):
        fr.stability_map(ROD, mean=(0.0, UNIT, 3), frequency=(20.0, 40.0, 3), amplitude=0.1, response=True)


# --- the simulator ---


@pytest.mark.slow
def test_the_simulated_rod_comes_to_rest_as_statics_says() -> None:
    rod = shaped({5: 1e-4}, damping_rate=8.0)
    load = fr.AxialLoad(0.2 * UNIT, 0.0, 60.0)
    run = fr.SimulationProblem(rod, load, duration=1.2, segments=60, frames=5, perturbation=fr.Perturbation()).run()
    sine = np.sin(5.0 * math.pi * np.linspace(0.0, 1.0, 61))
    amplitude = run.positions[-1, :, 1] @ sine / (sine @ sine)
    assert amplitude == pytest.approx(rod.response(load).largest, rel=2e-3)
    with pytest.raises(ValueError, match="shape that is known"):
        fr.SimulationProblem(shaped(RANDOM), load, duration=1.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mode", "frequency", "damping"),
    some([(5, 60.0, 1.0), (6, 60.0, 1.0), (7, 75.0, 2.0), (8, 92.0, 2.0), (4, 40.0, 1.0), (3, 45.0, 1.0)], 2, 1),
)
def test_simulations_move_as_far_within_a_percent(mode: int, frequency: float, damping: float) -> None:
    unit = WIDE.critical_force
    rod = shaped({mode: 1e-4}, WIDE, damping_rate=damping)
    load = fr.AxialLoad(0.2 * unit, 0.2 * unit, frequency)
    period = 2.0 * math.pi / frequency
    periods = math.ceil(9.0 / damping / period)
    run = fr.SimulationProblem(
        rod, load, duration=periods * period, frames=64 * periods + 1, perturbation=fr.Perturbation()
    ).run()
    sine = np.sin(mode * math.pi * np.linspace(0.0, 1.0, run.positions.shape[1]))
    last = run.positions[-129:, :, 1] @ sine / (sine @ sine)
    assert np.abs(last).max() == pytest.approx(rod.response(load, unstable=True).largest, rel=1e-2)


@pytest.mark.parametrize(
    ("ends", "frequency"), [("hinged", 0.01), pytest.param("clamped", 0.1, marks=pytest.mark.slow)]
)
def test_a_load_too_slow_for_a_response_names_the_least_frequency(ends: str, frequency: float) -> None:
    rod = shaped({"curvature": 0.05}, ends=ends, length=2.0)
    with pytest.raises(ValueError, match=r"frequency must be at least about [\d.]+ rad/s for the response of") as error:
        rod.response(fr.AxialLoad(0.2 * UNIT, 0.1 * UNIT, frequency))
    assert "method=" not in str(error.value)
