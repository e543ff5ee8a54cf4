"""The rod: the paper's frictionless numbers, the justified cut-off, margins and damping, arrays, bad input."""

from __future__ import annotations

import copy
import math
import pickle
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.mathieu.tongue_intervals import along_mean, damping_to_stabilise
from floquetrod.rod import Channel, CrossSection, EndConditions, Material
from floquetrod.rod.kernels import independent_modes as kernels
from tests.conftest import JIT, depth, needs_jit
from tests.coupled_cases import by_name
from tests.inside import wavenumber

pytestmark = pytest.mark.kernels

ROD = fr.Rod.nitinol()
FCR = ROD.critical_force


def load(mean: float, amplitude: float, frequency: float) -> fr.AxialLoad:
    """Return a load given in critical forces and rad/s."""
    return fr.AxialLoad(mean * FCR, amplitude * FCR, frequency)


rods = st.builds(
    lambda e, rho, r, slender, gap: fr.Rod(e, rho, r, slender * r, (1.0 + gap) * r),
    st.floats(1e9, 2e11),
    st.floats(1e3, 1e4),
    st.floats(1e-4, 1e-1),
    st.floats(500.0, 20000.0),
    st.floats(0.1, 10.0),
)


def test_the_reference_rod() -> None:
    assert pytest.approx(1.6960, abs=5e-5) == FCR
    assert ROD.critical_mode == pytest.approx(6.14, abs=5e-3)
    # The trap: with 9.4 mm as the radius neither number is the paper's.
    trap = ROD.replace(channel_radius=9.4e-3)
    assert trap.critical_force == pytest.approx(1.142, abs=5e-4)
    assert trap.critical_mode == pytest.approx(5.04, abs=5e-3)


def test_mode_equations_are_equation_4() -> None:
    rod, push = ROD.replace(damping_rate=0.3), load(0.2, 0.3, 150.0)
    (equation,) = rod.modal_system(push, [7]).equations
    w = 7.0 * math.pi / rod.length
    inertia = rod.density * math.pi * rod.radius**2 * 150.0**2
    weight = rod.density * math.pi * rod.radius**2 * 9.81 / rod.radial_clearance
    rigidity = rod.youngs_modulus * math.pi * rod.radius**4 / 4.0
    assert equation.alpha == pytest.approx(w**2 * push.amplitude / inertia, rel=1e-14)
    assert equation.beta == pytest.approx((push.mean * w**2 - rigidity * w**4 - weight) / inertia, rel=1e-12)
    assert equation.damping == 0.3 / 150.0
    free = rod.modal_system(fr.AxialLoad(0.0, 0.0, rod.natural_frequency(7)), [7]).equations[0]
    assert free.beta == pytest.approx(-1.0, rel=1e-14)


@pytest.mark.parametrize(("mean", "stable"), [(0.05, True), (0.34, True), (0.63, True), (0.20, False), (0.52, False)])
def test_claim_f3b(mean: float, stable: bool) -> None:
    assert ROD.stability(load(mean, 0.2, 150.0)).stable is stable


def test_claim_f3a() -> None:
    # Exactly, mode 8 is weakly unstable in a band around 0.28-0.29; 100 periods see growth above 0.022 per tau only.
    means = np.arange(0.005, 0.45, 0.005) * FCR
    growth = ROD.growth_rate(mean=means, amplitude=0.2 * FCR, frequency=85.0) / 85.0
    assert growth.max() < 0.022
    band = (means > 0.279 * FCR) & (means < 0.291 * FCR)
    assert growth[band].max() == pytest.approx(0.007, abs=5e-4)
    assert set(ROD.growth_rate(mean=means, amplitude=0.2 * FCR, frequency=85.0, return_mode=True)[1][band]) <= {0, 8}
    assert ROD.growth_rate(mean=0.47 * FCR, amplitude=0.2 * FCR, frequency=85.0) / 85.0 > 0.022


@pytest.mark.slow
def test_claim_f3c() -> None:
    # Near 20 rad/s: 0.76 F_cr with the 100-period test.  Exactly, the first tongue that grows by more than 1e-3 per tau
    # begins at 0.594, by more than 2e-4 at 0.47; thinner ones, which a grid steps over, lie lower: at 0.33 and 0.21.
    def first(growth_per_tau: float) -> float:
        intervals = [
            low
            for mode in range(1, 16)
            for low, high in unstable_forces(mode, 0.2 * FCR, 20.0, growth_per_tau, 0.9 * FCR)
            if high > low
        ]
        return min(intervals) / FCR

    assert first(0.022) == pytest.approx(0.759, abs=1e-3)
    assert first(1e-3) == pytest.approx(0.594, abs=1e-3)
    assert first(2e-4) == pytest.approx(0.470, abs=1e-3)
    assert first(1e-4) == pytest.approx(0.329, abs=1e-3)
    assert first(1e-5) == pytest.approx(0.215, abs=1e-3)


def unstable_forces(mode: int, amplitude: float, omega: float, growth: float, top: float) -> list[tuple[float, float]]:
    """Intervals of mean force in [0, top] where one mode grows by more than ``growth`` per tau."""
    ends = [ROD.modal_system(fr.AxialLoad(mean, amplitude, omega), [mode]).equations[0] for mean in (0.0, top)]
    parts = along_mean(*(np.array([x]) for x in (ends[0].alpha, growth, ends[0].beta, ends[1].beta)))
    scale = top / (ends[1].beta - ends[0].beta)
    forces = ((beta - ends[0].beta) * scale for beta in (parts.first, parts.last))
    return list(zip(*forces, strict=True))


def test_verdict_on_the_demonstration_load() -> None:
    result = ROD.stability(load(0.2, 0.2, 150.0))
    assert result.unstable_modes == (7,)
    assert result.fastest_mode == 7
    assert result.growth_rate == pytest.approx(4.2357, abs=5e-5)  # by an independent integration (solve_ivp, DOP853)
    assert result.time_to_grow(10.0) == pytest.approx(math.log(10.0) / result.growth_rate)
    assert result.modes_checked == len(result.modes) == result.modes[-1]
    assert repr(result).startswith("<unstable: mode 7 grows; mode 7 at 4.23568 1/s")
    assert repr(ROD.stability(load(0.05, 0.2, 150.0))).startswith("<stable")


def test_a_verdict_is_a_sentence() -> None:
    assert repr(ROD.stability(load(0.34, 0.2, 150.0))).startswith("<stable; ")
    assert "within the tolerance" in repr(ROD.stability(load(0.2, 0.2, 150.0), growth_tolerance=4.3))


def test_many_unstable_modes_are_counted_and_not_listed() -> None:
    rod = fr.Rod.nitinol()
    verdict = rod.stability(fr.AxialLoad(150.0, 1.0, 150.0))
    number = len(verdict.unstable_modes)
    assert number > 20
    for text in (repr(verdict), verdict.report().headline):
        assert f"modes 1, 2, 3, 4, 5, 6, 7, 8 and {number - 8} more grow" in text
    assert verdict.as_dict()["unstable_modes"] == list(verdict.unstable_modes)


def test_growth_tolerance() -> None:
    weak = load(0.285, 0.2, 85.0)
    assert ROD.stability(weak).unstable_modes == (8,)
    forgiving = ROD.stability(weak, growth_tolerance=1.0)
    assert forgiving.stable
    assert forgiving.growth_rate > 0.5
    assert ROD.is_stable(mean=weak.mean, amplitude=weak.amplitude, frequency=85.0, growth_tolerance=1.0)
    assert not ROD.is_stable(mean=weak.mean, amplitude=weak.amplitude, frequency=85.0)


def test_static_and_tensile_loads() -> None:
    long = ROD.replace(length=31.0)
    assert long.stability(fr.AxialLoad(0.999 * FCR, 0.0, 10.0)).stable
    static = long.stability(fr.AxialLoad(1.001 * FCR, 0.0, 10.0))
    assert static.stable is False
    assert static.fastest_mode == round(long.critical_mode)
    assert static.damping_to_stabilise == math.inf
    # The static limit does not depend on the frequency.
    rates = [long.growth_rate(mean=1.01 * FCR, amplitude=0.0, frequency=omega) for omega in (1.0, 50.0, 1000.0)]
    assert rates == pytest.approx([rates[0]] * 3, rel=1e-9)
    assert ROD.stability(load(0.0, 0.05, 150.0)).stable
    assert ROD.stability(load(-0.5, 0.0, 150.0)).stable
    assert ROD.stability(load(-0.5, 0.0, 150.0)).left_out_bound == 0.0


@pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning")
def test_twenty_five_modes_are_wrong_for_a_long_rod() -> None:
    long = ROD.replace(length=50.0)
    push = fr.AxialLoad(0.2 * FCR, 0.2 * FCR, 150.0)
    everything = long.stability(push)
    assert everything.modes_checked > 300
    assert min(everything.unstable_modes) > 25
    assert long.stability(push, modes=range(1, 26)).stable


@settings(max_examples=depth(60, 15))
@given(rods, st.floats(-0.5, 1.2), st.floats(0.01, 0.8), st.floats(0.5, 20.0))
def test_no_mode_beyond_the_cut_off_matters(rod: fr.Rod, mean: float, amplitude: float, speed: float) -> None:
    omega = speed * rod.pendulum_frequency
    push = fr.AxialLoad(mean * rod.critical_force, amplitude * rod.critical_force, omega)
    last, bound = rod.modes_needed(push)
    assert bound <= 1e-12
    coarse, coarse_bound = rod.modes_needed(push, growth_tolerance=1e-4)
    assert coarse <= last
    beyond = np.arange(coarse + 1, 2 * last + 20)
    system = rod.modal_system(push, beyond)
    assert (omega * fr.mathieu.growth_rate(system.alpha, system.beta)).max() <= coarse_bound * (1.0 + 1e-9)


@settings(max_examples=depth(200, 50))
@given(st.integers(1, 30), st.floats(-2.0, 2.3), st.floats(-0.5, 1.5))
def test_the_growth_bound_bounds(order: int, power: float, place: float) -> None:
    q = 10.0**power
    ends = [fr.mathieu.characteristic_values(order, q, kind) for kind in "ab"]
    a = ends[1] + place * (ends[0] - ends[1])
    assume(a > 2.0 * q * (1.0 + 1e-9))
    assert kernels.growth(0.5 * q, -0.25 * a, 0.0) <= kernels.growth_bound(a, q) * (1.0 + 1e-9) + 1e-14


@pytest.mark.slow
def test_a_mode_at_the_edge_of_the_bound_is_looked_at() -> None:
    # a = 2 q in doubles where the room that is left is not zero in them.
    rod = fr.Rod(1e9, 900.0, 0.0023274128510754337, 8.296067484796886, 0.004654825702150867, 2.766561392000476)
    load = fr.AxialLoad(0.0, 1.2954625223428762, 34.47731541234874)
    damped = rod.replace(damping_rate=load.frequency).stability(load, growth_tolerance=0.7313716233765307)
    assert damped.amplitude_margin == (math.inf, math.inf)


def test_without_coupling_nothing_grows_even_at_a_resonance() -> None:
    assert kernels.growth_bound(4.0, 0.0) == 0.0


@pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning")
@settings(max_examples=depth(40, 10))
@given(rods, st.floats(0.0, 1.1), st.floats(0.0, 0.6), st.floats(1.0, 10.0), st.just(0.0) | st.floats(0.001, 0.1))
def test_arrays_and_single_loads_agree(
    rod: fr.Rod, mean: float, amplitude: float, speed: float, damping: float
) -> None:
    rod = rod.replace(damping_rate=damping * rod.pendulum_frequency)
    omega = speed * rod.pendulum_frequency
    forces = mean * rod.critical_force, amplitude * rod.critical_force
    result = rod.stability(fr.AxialLoad(*forces, omega))
    assume(result.status != "undecided")
    assert rod.is_stable(**by_name(*forces, omega)) is result.stable
    assert rod.growth_rate(**by_name(*forces, omega)) == pytest.approx(result.growth_rate, rel=1e-9, abs=1e-12)
    compiled = rod.is_stable(mean=np.full(100, forces[0]), amplitude=forces[1], frequency=omega)
    assert compiled.all() == result.stable
    assert compiled.all() == compiled.any()


def test_scaling() -> None:
    # In the units of F_cr, sqrt(g / R) and m_cr every rod of the same m_cr has the same map.
    other = fr.Rod(200e9, 7850.0, 1.5e-3, 6.0, 12e-3)
    other = other.replace(length=other.length * ROD.critical_mode / other.critical_mode)
    mean, amplitude = np.meshgrid(np.linspace(0.0, 1.1, 30), np.linspace(0.05, 0.5, 20))
    speed = 150.0 / ROD.pendulum_frequency
    maps = [
        r.growth_rate(
            mean=mean * r.critical_force, amplitude=amplitude * r.critical_force, frequency=speed * r.pendulum_frequency
        )
        / r.pendulum_frequency
        for r in (ROD, other)
    ]
    assert maps[0] == pytest.approx(maps[1], rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(
    ("mean", "omega", "tolerance", "damping"),
    [
        (0.05, 150.0, 0.0, 0.0),
        (0.20, 150.0, 0.0, 0.0),
        (0.52, 150.0, 0.0, 0.4),
        (0.3, 85.0, 0.7, 0.0),
        pytest.param(0.9, 20, 0.1, 0.1, marks=pytest.mark.slow),
    ],
)
def test_the_verdict_changes_at_the_margin(mean: float, omega: float, tolerance: float, damping: float) -> None:
    rod = ROD.replace(damping_rate=damping)
    push = load(mean, 0.2, omega)
    result = rod.stability(push, growth_tolerance=tolerance)
    assert math.isfinite(result.mean_force_margin.nearest)
    for sign, margin in zip((-1.0, 1.0), result.mean_force_margin, strict=True):
        if not math.isfinite(margin):
            continue
        inside = push.mean + sign * margin * (1.0 - 1e-7)
        outside = push.mean + sign * (margin + 1e-7 * FCR)
        found = rod.is_stable(
            mean=[inside, outside], amplitude=push.amplitude, frequency=omega, growth_tolerance=tolerance
        )
        assert found.tolist() == [result.stable, not result.stable]
        # And nowhere in between.
        between = np.linspace(push.mean, inside, 4001 if JIT else 401)
        assert (
            rod.is_stable(mean=between, amplitude=push.amplitude, frequency=omega, growth_tolerance=tolerance)
            == result.stable
        ).all()


@pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")  # at 20 rad/s
@settings(max_examples=depth(25, 6))
@given(st.floats(0.02, 0.95), st.floats(0.05, 0.5), st.floats(20.0, 300.0))
def test_damping_to_stabilise(mean: float, amplitude: float, omega: float) -> None:
    result = ROD.stability(load(mean, amplitude, omega))
    rate = result.damping_to_stabilise
    assert math.isfinite(rate)
    forces = result.load.mean, result.load.amplitude, omega
    for larger in (rate * (1.0 + 1e-6) + 1e-9, *(rate + np.geomspace(1e-3, 300.0, 12))):
        assert ROD.replace(damping_rate=float(larger)).is_stable(**by_name(*forces))
    if rate > 1e-6:
        assert not ROD.replace(damping_rate=rate * (1.0 - 1e-6)).is_stable(**by_name(*forces))


@given(st.floats(1.05, 3.0), st.floats(0.0, 0.02))
def test_no_damping_stabilises_a_rod_buckled_by_its_mean_force(mean: float, amplitude: float) -> None:
    result = ROD.stability(load(mean, amplitude, 20.0))
    assert max(equation.beta for equation in result.mode_equations) > 0.0
    assert math.isinf(result.damping_to_stabilise)


@pytest.mark.parametrize("has", [1.0, 5.0, 20.0, 60.0])
def test_damping_to_stabilise_does_not_depend_on_the_damping_there_is(has: float) -> None:
    # A damped rod needs fewer modes for its verdict; the modes that damping keeps quiet are the ones this is about.
    push = load(0.2, 0.2, 150.0)
    expected = ROD.stability(push).damping_to_stabilise
    assert expected > 4.0
    assert ROD.replace(damping_rate=has).stability(push).damping_to_stabilise == expected
    assert ROD.stability(push, growth_tolerance=has).damping_to_stabilise == expected


@pytest.mark.parametrize("tolerance", [5.0, 20.0, 50.0, 100.0, 200.0])
def test_the_margin_looks_at_the_modes_that_larger_forces_need(tolerance: float) -> None:
    # Static limit: growth^2 = (F w^2 - E I w^4) / (rho A) - g / R, so every mode's force is known in closed form.
    result = ROD.stability(load(0.1, 0.0, 150.0), growth_tolerance=tolerance)
    mass = ROD.mass_per_length
    forces = []
    for mode in range(1, 60):
        w2 = (mode * math.pi / ROD.length) ** 2
        forces.append(mass * (tolerance**2 + ROD.pendulum_frequency**2) / w2 + ROD.flexural_rigidity * w2)
    assert result.mean_force_margin.above == pytest.approx(min(forces) - 0.1 * FCR, rel=1e-12)


def test_the_end_of_the_search_is_no_margin() -> None:
    rod = ROD.replace(damping_rate=0.3)
    push = fr.AxialLoad(0.6045857342263995, 0.7684148719102359, 215.26110484616336)
    above = rod.stability(push).amplitude_margin.above
    outside = push.amplitude + above * (1.0 + 1e-6)
    assert math.isinf(above) or rod.is_stable(mean=push.mean, amplitude=outside, frequency=push.frequency)


@settings(max_examples=depth(200, 50))
@given(rods, st.floats(-1.0, 3.0), st.floats(0.0, 2.0), st.floats(0.5, 50.0), st.floats(1.0, 9.0), st.floats(0.0, 0.2))
def test_more_of_a_load_never_needs_fewer_modes(
    rod: fr.Rod, mean: float, amplitude: float, speed: float, more: float, damping: float
) -> None:
    rod = rod.replace(damping_rate=damping * rod.pendulum_frequency)
    unit = rod.critical_force
    omega = speed * rod.pendulum_frequency
    here = rod.modes_needed(fr.AxialLoad(mean * unit, amplitude * unit, omega))[0]
    assert rod.modes_needed(fr.AxialLoad((mean + more) * unit, amplitude * unit, omega))[0] >= here
    assert rod.modes_needed(fr.AxialLoad(mean * unit, (amplitude + more) * unit, omega))[0] >= here
    assert rod.modes_needed(fr.AxialLoad(mean * unit, amplitude * unit, omega * more))[0] >= here


def test_damping_can_destabilise_a_mode() -> None:
    # In the strip beta > 0 that vibration stabilises no damping is enough, and none is needed.
    assert fr.mathieu.is_stable(1.0, 0.378)
    assert damping_to_stabilise(np.array([1.0]), np.array([0.378])) == math.inf
    for c in (0.1, 1.0, 10.0):
        assert fr.mathieu.growth_rate(1.0, 0.378, c) > 0.0
    assert fr.mathieu.growth_rate(1.0, 0.378, 30.0) == pytest.approx(0.378 / 60.0, rel=1e-2)


def test_a_fast_load_gets_a_warning() -> None:
    with pytest.warns(fr.UniformForceWarning, match=r"0\.3[0-9] axial wavelengths long"):
        ROD.stability(fr.AxialLoad(0.1, 0.1, 2200.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ROD.stability(load(0.1, 0.1, 150.0))


@pytest.mark.slow
@needs_jit
@pytest.mark.parametrize(
    "ask",
    [
        lambda omega: ROD.ranges("frequency", mean=0.3, amplitude=0.1, bounds=(0.9 * omega, omega)),
        lambda omega: ROD.ranges("mean", amplitude=0.1, frequency=omega, bounds=(0.0, 0.5)),
        lambda omega: ROD.critical("amplitude", mean=0.3, frequency=omega, growth_tolerance=0.1),
        lambda omega: ROD.certify(mean=0.3, amplitude=1e-3, frequency=(0.9 * omega, omega)),
        lambda omega: ROD.largest_safe_box(fr.AxialLoad(0.3, 1e-3, omega), vary=("mean",), accuracy=0.3),
        lambda omega: fr.stability_map(ROD, mean=(0.0, 0.5, 4), amplitude=0.1, frequency=(0.9 * omega, omega, 4)),
        lambda omega: ROD.stability(fr.AxialLoad(0.3, 0.1, omega / 3.0, waveform=(1.0, 0.0, 0.2))),
    ],
)
def test_every_answer_on_a_fast_load_gets_the_warning(ask: Callable[[float], Any]) -> None:
    """As a verdict does: ranges, proofs and maps rest on the same uniform force; harmonics count."""
    with pytest.warns(fr.UniformForceWarning, match=r"at 2200 rad/s .* 0\.34 axial wavelengths long") as caught:
        ask(2200.0)
    assert [warning.filename for warning in caught] == [__file__]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ask(500.0)


def test_hertz() -> None:
    assert fr.AxialLoad.hertz(1.0, 2.0, 24.0) == fr.AxialLoad(1.0, 2.0, 48.0 * math.pi)


SHEET = {"youngs_modulus": 68e9, "density": 6500.0, "radius": 0.8e-3, "length": 3.1, "channel_radius": 4.7e-3}


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"length": -3.1}, ValueError, "length must be greater than zero, got -3.1; give it in m"),
        ({"radius": 5e-3}, ValueError, "half of channel_diameter"),
        ({"density": math.nan}, ValueError, "density must be finite"),
        ({"youngs_modulus": "68Gpu"}, ValueError, "youngs_modulus must be a number with a pressure unit"),
        ({"gravity": 0.0}, ValueError, "gravity must be greater than zero"),
        ({"damping_rate": -1.0}, ValueError, "damping_rate must be zero or more"),
    ],
)
def test_bad_rods(change: dict[str, object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        fr.Rod(**{**SHEET, **change})  # type: ignore[arg-type]


def test_a_rod_is_its_parts() -> None:
    rod = ROD.replace(damping_rate=0.3)
    assert rod.material == Material(rod.youngs_modulus, rod.density)
    assert rod.section == CrossSection(rod.radius)
    assert rod.channel == Channel(rod.channel_radius, rod.gravity)
    assert rod.end_conditions == EndConditions()
    assert rod.flexural_rigidity == rod.material.youngs_modulus * rod.section.second_moment
    assert wavenumber(rod, 3) == 3.0 * (math.pi / rod.length)
    assert rod.replace(radius=1e-3).section.area == math.pi * 1e-6


def test_a_rod_with_its_parts_is_still_its_data_sheet() -> None:
    rod, again = fr.Rod(**SHEET), fr.Rod(**SHEET)
    assert rod.section.area > 0.0
    assert rod == again
    assert hash(rod) == hash(again)
    assert eval("fr." + repr(rod)) == rod == pickle.loads(pickle.dumps(rod)) == copy.deepcopy(rod)
    assert rod.as_dict() == {**SHEET, "gravity": 9.81, "damping_rate": 0.0}


@pytest.mark.parametrize("amplitude", [0.0, 0.3])
def test_the_modal_system_is_what_a_verdict_looks_at(amplitude: float) -> None:
    rod, push = ROD.replace(damping_rate=0.2), load(0.3, amplitude, 150.0)
    system, verdict = rod.modal_system(push), rod.stability(push)
    assert verdict.system == system
    assert (verdict.modes, verdict.mode_equations, verdict.load) == (system.modes, system.equations, push)
    assert (len(system.modes), system.left_out_bound) == rod.modes_needed(push)
    assert [(e.alpha, e.beta, e.damping) for e in system.equations] == [
        (a, b, system.damping) for a, b in zip(system.alpha, system.beta, strict=True)
    ]
    assert "every higher mode" in system.cutoff or "no higher mode" in system.cutoff
    assert "others were not checked" in rod.modal_system(push, (6, 7)).cutoff
    more = rod.modal_system(fr.AxialLoad(push.mean + 1.0, push.amplitude + 1.0, 150.0), system.modes)
    assert more.beta - system.beta == pytest.approx(system.per_newton, rel=1e-9)
    assert more.alpha - system.alpha == pytest.approx(system.per_newton, rel=1e-9)
    in_seconds = [150.0**2 * part for part in (system.alpha, system.beta)]
    assert np.array(system.in_seconds) == pytest.approx(np.array(in_seconds), rel=1e-12)


def test_modal_systems_of_arrays_are_those_of_single_loads() -> None:
    means = np.array([0.1, 0.5, 0.9]) * FCR
    alpha, beta = ROD.modal_system(mean=means, amplitude=0.3 * FCR, frequency=150.0).coefficients(7)
    for mean, *pair in zip(means, alpha, beta, strict=True):
        (equation,) = ROD.modal_system(fr.AxialLoad(mean, 0.3 * FCR, 150.0), [7]).equations
        assert [equation.alpha, equation.beta] == pair


def test_bad_modal_systems() -> None:
    with pytest.raises(ValueError, match=r"modes\[1\] must be 1 or more"):
        ROD.modal_system(load(0.1, 0.1, 150.0), [1, 0])
    with pytest.raises(ValueError, match=r"modes must have coefficients up to 1e.09, got .* for mode 20000"):
        _ = ROD.modal_system(load(0.1, 0.1, 1.0), [20_000]).equations
    with pytest.raises(ValueError, match="frequency must be at least"):
        ROD.modal_system(mean=0.1, amplitude=0.1, frequency=[150.0, 1e-8])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((1.0, 1.0, 0.0), "frequency must be greater than zero"),
        ((1.0, -1.0, 10.0), "amplitude must be zero or more"),
        ((math.nan, 1.0, 10.0), "mean must be finite"),
        ((1.0, 1.0, math.inf), "frequency must be finite"),
    ],
)
def test_bad_loads(arguments: tuple[float, float, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fr.AxialLoad(*arguments)
    with pytest.raises(ValueError, match=message.split(" must")[0]):
        ROD.is_stable(**by_name(*arguments))


def test_bad_questions() -> None:
    push = load(0.1, 0.1, 150.0)
    with pytest.raises(ValueError, match="modes must name at least one mode"):
        ROD.stability(push, modes=[])
    with pytest.raises(ValueError, match=r"modes\[0\] must be 1 or more"):
        ROD.stability(push, modes=[0])
    with pytest.raises(TypeError, match="load must be an AxialLoad"):
        ROD.stability((0.1, 0.1, 150.0))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="growth_tolerance must be zero or more"):
        ROD.stability(push, growth_tolerance=-1.0)
    with pytest.raises(ValueError, match="factor must be greater than 1"):
        ROD.stability(push).time_to_grow(1.0)
    with pytest.raises(ValueError, match="must broadcast"):
        ROD.is_stable(mean=[1.0, 2.0], amplitude=[1.0, 2.0, 3.0], frequency=150.0)
    with pytest.raises(ValueError, match="more than 20000 modes"):
        ROD.stability(fr.AxialLoad(1e9, 1.0, 150.0))
