"""Rods whose modes are coupled: known growth, beams, buckling, finite differences, limits, symmetry, bad input."""

from __future__ import annotations

import math
from itertools import zip_longest
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import floquetrod as fr
from floquetrod.rod.modes import coupled_verdict as coupled_stability
from tests import coupled_cases as cases
from tests import finite_differences as fd
from tests.conftest import some
from tests.coupled_cases import ENDS, FORCE, TUBING, WIRE, by_name
from tests.inside import wavenumber
from tests.published import hanging

KNOWN = cases.known()
COUPLED = tuple(ends for ends in ENDS if ends != "hinged-hinged")
BEAM = fr.Rod(207e9, 7850.0, 0.01, 2.0, 0.5, gravity=1e-3)
"""A rod whose bed hardly matters beside its bending."""

SHORT = fr.Rod(207e9, 7850.0, 0.01, 9.0, 0.05)
"""A rod of few modes, m_cr = 2.4."""


WAYS = ("even", "two harmonics", "held", "free", "driven")


def growing(rod: fr.Rod, way: str) -> Any:
    """Return a load at twice the frequency of the slowest free vibration, so that the rod grows."""
    unit, swing = rod.critical_force, rod.pendulum_frequency
    mean, amplitude = 0.2 * unit, 0.5 * unit
    least = float(fd.least_stiffness(cases.model(rod, fr.AxialLoad(mean, 0.0, swing)))[0])
    numbers = mean, amplitude, 2.0 * max(math.sqrt(max(least, 0.0)), 0.5 * swing)
    if way == "even":
        return fr.AxialLoad(*numbers)
    if way == "two harmonics":
        return fr.AxialLoad(*numbers, waveform=(0.7 - 0.4j, 0.5 + 0.3j), mean_at=0.4)
    if way == "held":
        return fr.AxialWave(*numbers, far_end="held", axial_damping=0.3 * swing)
    if way == "free":
        return fr.AxialWave(*numbers, far_end="free", axial_damping=20.0 * swing, mean_at=0.6)
    return fr.AxialWave(*numbers, far_end="driven", waveform=(-1j, 0.4), mean_at=None)


def mean_stiffness(rod: fr.Rod, mean: float) -> np.ndarray:
    """Return the mean stiffness less that of the bed, in 1/s^2."""
    system = rod.modal_system(fr.AxialLoad(mean, 0.0, 100.0), range(1, 25))
    bed = rod.weight_per_length * math.sin(rod.inclination) / (rod.radial_clearance * rod.mass_per_length)
    return np.asarray(system.stiffness) - bed * np.eye(len(system.stiffness))


# --- what is known ---


def test_a_string_that_hangs_buckles_at_its_lower_end() -> None:
    """Onset 1.71105 by Ritz's method with a hundred sines, of which eleven find 1.7586."""
    (rod, below), (_, beyond) = hanging(20.0, 1.70), hanging(20.0, 1.72)
    assert rod.stability(below).status == "stable"
    assert rod.stability(beyond).status == "unstable"
    assert rod.stability(beyond).growth_rate > 0.04


@pytest.mark.parametrize("name", KNOWN)
def test_growth_is_as_known(name: str) -> None:
    rod, load, _ = known = KNOWN[name]
    found = rod.stability(load)
    assert found.status == "unstable"
    assert found.error < 1e-4
    assert found.growth_rate == pytest.approx(known.rate, rel=0.0, abs=known.slack + found.error)
    # Half as many modes again give every digit.
    finer = rod.stability(load, modes=range(1, found.modes_checked * 3 // 2 + 1))
    assert finer.growth_rate == pytest.approx(known.rate, rel=0.0, abs=1.02 * known.slack)


@pytest.mark.parametrize("ends", COUPLED)
def test_free_vibration_is_that_of_a_beam(ends: str) -> None:
    unit = BEAM.flexural_rigidity / (BEAM.mass_per_length * BEAM.length**4)
    found = np.linalg.eigvalsh(mean_stiffness(BEAM.replace(ends=ends), 0.0)) / unit
    rigid = cases.rigid_motions(ends)
    assert np.abs(found[:rigid]).max(initial=0.0) < 1e-6
    assert np.sqrt(found[rigid : rigid + 4]) == pytest.approx(np.square(cases.beam_wavenumbers(ends)), rel=1e-8)


@pytest.mark.parametrize("ends", COUPLED)
def test_natural_frequencies_are_those_of_the_equations_without_force(ends: str) -> None:
    rod = WIRE.replace(ends=ends)
    stiffness = rod.modal_system(fr.AxialLoad(0.0, 0.0, 1.0), range(1, 41)).stiffness
    found = np.sqrt(np.linalg.eigvalsh(stiffness)[:20])
    assert rod.natural_frequency(np.arange(1, 21)) == pytest.approx(found, rel=1e-9)
    assert rod.natural_frequency(7) == pytest.approx(found[6], rel=1e-9)
    assert wavenumber(rod, [[2], [1]]).tolist() == [[wavenumber(rod, 2)], [wavenumber(rod, 1)]]
    assert np.count_nonzero(wavenumber(rod, np.arange(1, 6)) == 0.0) == cases.rigid_motions(ends)
    for wrong in (0, 2.5, [1.0, 1.5]):
        with pytest.raises(ValueError, match=r"^mode must be a whole number from 1 on for a rod with"):
            wavenumber(rod, wrong)


def test_textbook_numbers_of_beams() -> None:
    shown = {"clamped-clamped": 22.3733, "clamped-hinged": 15.4182, "clamped-free": 3.5160, "clamped-guided": 5.5933}
    for ends, value in shown.items():
        assert cases.beam_wavenumbers(ends)[0] ** 2 == pytest.approx(value, abs=5e-5)
    assert cases.buckling_load("clamped-hinged") == pytest.approx(20.190729, abs=5e-7)


@pytest.mark.parametrize("ends", COUPLED)
def test_a_beam_buckles_where_it_should(ends: str) -> None:
    from scipy.linalg import eigh

    rod = BEAM.replace(ends=ends)
    unit = rod.flexural_rigidity / rod.length**2
    scale = rod.mass_per_length * rod.length**4 / rod.flexural_rigidity
    bent = scale * mean_stiffness(rod, 0.0)
    push = bent - scale * mean_stiffness(rod, unit)
    # bent v = load push v, written as push v = (bent + push) v / (1 + load), with what moves under neither held.
    both = bent + push
    values, vectors = np.linalg.eigh(both)
    shift = vectors[:, values < 1e-6]
    share = eigh(push, both + shift @ shift.T, eigvals_only=True)[-1]
    assert 1.0 / share - 1.0 == pytest.approx(cases.buckling_load(ends), rel=1e-8, abs=1e-8)


# --- against finite differences ---


def close(rod: fr.Rod, load: Any) -> None:
    """Compare growth with finite differences, within the errors that both state, and to four digits."""
    found = rod.stability(load)
    rate, error = fd.growth(cases.model(rod, load))
    assert error < 1e-5 * (1.0 + abs(rate)), "finite differences have not converged"
    assert rate > 0.05, "nothing grows here: the comparison would show nothing"
    assert found.status == "unstable"
    assert found.growth_rate == pytest.approx(rate, rel=1e-9, abs=3.0 * error + found.error)
    assert found.growth_rate == pytest.approx(rate, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[] if name == "wire driven at 150" else pytest.mark.slow)
        for name in KNOWN
        if "120" not in name
    ],
)
def test_finite_differences_grow_as_known(name: str) -> None:
    known = KNOWN[name]
    rate, error = fd.growth(cases.model(known.rod, known.load))
    assert error < 1e-7
    assert rate == pytest.approx(known.rate, rel=0.0, abs=known.slack + error)


@pytest.mark.parametrize("ends", [ends for ends in ENDS if ends.split("-") <= ends.split("-")[::-1]])
def test_finite_differences_know_beams(ends: str) -> None:
    rigid = cases.rigid_motions(ends)
    model = fd.Model(1.0, 1.0, 0.0, 1.0, tuple(ends.split("-")), fd.even(0.0))  # type: ignore[arg-type]
    free = fd.least_stiffness(model, rigid + 3)
    assert np.sqrt(free[rigid:]) == pytest.approx(np.square(cases.beam_wavenumbers(ends, 3)), rel=1e-7)
    pushed = model._replace(mean=fd.even(cases.buckling_load(ends)))
    assert np.abs(fd.least_stiffness(pushed, max(1, rigid))).max() < 1e-6


SOME = "clamped", "clamped-hinged", "hinged-clamped", "clamped-guided", "guided-free"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("ends", "way"),
    [
        # One, and all ends with all ways under `make slow`.
        pytest.param(ends, way, marks=[pytest.mark.slow] * ((ends, way) != (SOME[0], WAYS[0])))
        for ends in SOME
        for way in (WAYS if ends == SOME[0] else some(WAYS, 2, 1))
    ],
)
def test_growth_is_that_of_finite_differences(ends: str, way: str) -> None:
    rod = SHORT.replace(ends=ends, inclination=math.radians(70.0), damping_rate=0.005 * SHORT.pendulum_frequency)
    close(rod, growing(rod, way))


@pytest.mark.slow
@pytest.mark.parametrize(("ends", "way"), [(ends, way) for ends in ENDS for way in some(WAYS, 2, 1)])
def test_growth_is_that_of_finite_differences_for_all_ends(ends: str, way: str) -> None:
    rod = SHORT.replace(ends=ends, inclination=math.radians(50.0))
    close(rod, growing(rod, way))


# --- limits ---


def test_independent_modes_are_what_they_were() -> None:
    even = fr.AxialLoad(0.2 * FORCE, 0.2 * FORCE, 150.0)
    for load in (
        even,
        fr.AxialLoad(*cases.numbers(even), mean_at=None),
        fr.AxialLoad(*cases.numbers(even), mean_at=0.0),
    ):
        found = WIRE.stability(load)
        assert found.unstable_modes == (7,)
        alone = max(fr.stability(equation).growth_rate for equation in found.mode_equations)
        assert found.growth_rate == pytest.approx(150.0 * alone, rel=1e-12)
        assert found.growth_rate == WIRE.replace(ends="hinged-hinged").stability(load).growth_rate
    inclined = WIRE.replace(inclination=math.radians(60.0))
    light = inclined.stability(fr.AxialLoad(*cases.numbers(even), mean_at=None))
    assert light.unstable_modes == (7,)
    assert light.growth_rate == pytest.approx(
        inclined.growth_rate(light.load, **by_name(*cases.numbers(even))), rel=1e-9
    )


def test_coupled_modes_tend_to_independent_ones() -> None:
    even = fr.AxialLoad(0.2 * FORCE, 0.2 * FORCE, 150.0)
    level = WIRE.stability(even).growth_rate
    hardly = WIRE.replace(inclination=math.pi / 2 - 1e-6).stability(even)
    assert hardly.growth_rate == pytest.approx(level, abs=1e-8)
    # Inertia is that of the fluid, so axial waves in the light wall are fast: 2.6e8 m/s.
    fast = fr.Rod(68e9, 1e-6, 0.8e-3, 3.1, 4.7e-3, inner_radius=0.4e-3, fluid_inside=26000.0)
    load = fr.AxialLoad(0.2 * fast.critical_force, 0.2 * fast.critical_force, 3.0 * fast.pendulum_frequency)
    same = fast.stability(load).growth_rate
    assert same > 0.1
    for far_end in ("held", "driven"):
        wave = fr.AxialWave(*cases.numbers(load), far_end=far_end)
        assert fast.stability(wave).growth_rate == pytest.approx(same, abs=1e-8)


def test_a_weak_inclination_changes_growth_smoothly() -> None:
    rates = []
    for degrees in (90.0, 89.0, 88.0, 86.0):
        rod = WIRE.replace(inclination=math.radians(degrees))
        load = fr.AxialLoad(0.2 * FORCE, 0.2 * FORCE, 150.0)
        even = fr.AxialLoad(*cases.numbers(load), mean_at=None)
        rates.append(rod.stability(load).growth_rate - rod.stability(even).growth_rate)
    # Mean in the middle: the effect is of second order in the weight along the rod.
    assert rates[0] == 0.0
    assert rates[2] / rates[1] == pytest.approx(4.0, abs=0.3)
    assert rates[3] / rates[2] == pytest.approx(4.0, abs=0.6)


@pytest.mark.parametrize("ends", ["hinged", "clamped", "clamped-free"])
def test_a_tube_is_the_solid_rod_of_the_same_stiffness_inertia_and_weight(ends: str) -> None:
    tube = TUBING.replace(length=40.0, inclination=math.radians(70.0), damping_rate=0.05, ends=ends)
    solid = cases.solid_like(tube)
    load = fr.AxialLoad(0.3 * tube.critical_force, 0.4 * tube.critical_force, 2.2 * tube.pendulum_frequency)
    one, other = tube.stability(load), solid.stability(load)
    assert one.growth_rate > 0.05
    assert one.status == other.status == "unstable"
    assert one.growth_rate == pytest.approx(other.growth_rate, rel=1e-8)


# --- symmetry ---


@pytest.mark.parametrize(
    "ends",
    [
        *(pytest.param(ends, marks=pytest.mark.slow) for ends in ("clamped-hinged", "free-clamped", "clamped-guided")),
        "hinged-guided",
    ],
)
def test_a_rod_turned_round_grows_alike(ends: str) -> None:
    upper, lower = ends.split("-")
    one, other = SHORT.replace(ends=ends), SHORT.replace(ends=f"{lower}-{upper}")
    for way in ("even", "driven"):
        load = growing(one, way)
        rates = one.stability(load).growth_rate, other.stability(load).growth_rate
        assert rates[0] > 0.05, "nothing grows here: the comparison would show nothing"
        assert rates[0] == pytest.approx(rates[1], rel=1e-7)


@pytest.mark.slow
def test_finite_differences_turned_round_grow_alike() -> None:
    rod = SHORT.replace(ends="clamped-free", inclination=1.0)
    model = cases.model(rod, growing(rod, "free"))
    waves = [lambda s, wave=wave: wave(model.length - s) for wave in model.waves]
    turned = model._replace(ends=("free", "clamped"), mean=lambda s: model.mean(model.length - s), waves=waves)
    assert fd.growth(turned).rate == pytest.approx(fd.growth(model).rate, rel=1e-8)


@pytest.mark.slow
def test_a_load_half_a_period_later_grows_alike() -> None:
    rod = SHORT.replace(ends="clamped")
    load = growing(rod, "two harmonics")
    later = fr.AxialLoad(*cases.numbers(load), waveform=(-load.waveform[0], load.waveform[1]), mean_at=load.mean_at)
    assert rod.stability(later).growth_rate == pytest.approx(rod.stability(load).growth_rate, rel=1e-7)


# --- modes ---


PUSHED = fr.Rod(
    1095550189.928827, 5854.809227598114, 0.0006408550539060105, 0.06695269269773463, 0.0008628171293648579,
    18.342355968276713, 2.947411049258759, ends="hinged-clamped",
)  # fmt: skip
"""A short and stiff rod."""


@pytest.mark.slow
@pytest.mark.parametrize("count", [4, pytest.param(None, marks=pytest.mark.slow)])
def test_a_short_stiff_rod_that_is_pushed_slowly_grows_as_its_slowest_mode(count: int | None) -> None:
    """It grows by 33 decades in a period, in which the stiffest function swings some thousand times.

    Other modes follow the slowest one at once: q'' + s(t) q = 0, s the least eigenvalue of the stiffness.
    """
    load = fr.AxialLoad(0.8248148647308485, 0.965394061103273, 18.417307731225396)
    system = PUSHED.modal_system(load, modes=range(1, 4))

    def slope(t: float, state: Any) -> Any:
        least = np.linalg.eigvalsh(_at(system, t))[0]
        return [state[1], -least * state[0], state[3], -least * state[2]]

    end = solve_ivp(slope, (0.0, system.period), [1.0, 0.0, 0.0, 1.0], rtol=1e-8, atol=1e-8).y[:, -1]
    expected = math.log(end[0] + end[3]) / system.period - PUSHED.damping_rate
    found = PUSHED.stability(load, modes=None if count is None else range(1, count + 1))
    assert found.status == "unstable"
    assert found.error < 1e-5 * found.growth_rate
    assert found.growth_rate == pytest.approx(221.248548, abs=1e-5 + found.error)
    assert found.growth_rate == pytest.approx(expected, rel=2e-3)


def _at(system: Any, t: float) -> Any:
    """Return the stiffness of a system at a time."""
    angle, found = 2.0 * math.pi * t / system.period, system.stiffness
    for k, (one, other) in enumerate(zip_longest(system.cosines, system.sines), start=1):
        found = found + (0.0 if one is None else one) * math.cos(k * angle)
        found = found + (0.0 if other is None else other) * math.sin(k * angle)
    return found


@pytest.mark.slow
@pytest.mark.parametrize(
    "ends", ["hinged", *(pytest.param(ends, marks=pytest.mark.slow) for ends in ("clamped", "clamped-free"))]
)
def test_growth_converges_in_modes(ends: str) -> None:
    rod = WIRE.replace(ends=ends, inclination=math.radians(60.0))
    load = growing(rod, "even")
    rate, error = fd.growth(cases.model(rod, load))
    assert error < 1e-5 < rate
    best = rod.stability(load)
    assert best.growth_rate == pytest.approx(rate, rel=0.0, abs=best.error + error)
    errors = [abs(rod.stability(load, modes=range(1, n + 1)).growth_rate - rate) for n in (10, 14, 20, 30)]
    assert max(errors[2:]) < 0.2 * errors[0]
    assert errors[3] < 1e-6 + 2.0 * error
    numbers, shown = zip(*best.convergence, strict=True)
    assert numbers == tuple(sorted(numbers))
    assert numbers[-1] == best.modes_checked
    assert shown[-1] == best.growth_rate


@pytest.mark.slow
def test_the_error_covers_growth_that_hardly_changes_over_a_few_numbers_of_modes() -> None:
    """With 19 and 22 modes growth is the same to 7e-8, and to come is 1.3e-5."""
    rod = fr.Rod(
        31.038e9, 1521.7, 1.34685e-3, 6.20746, 4.40843e-3, 13.52, damping_rate=0.00427, fluid_outside=671.8,
        added_mass_coefficient=1.7716, ends="hinged-free",
    )  # fmt: skip
    load = fr.AxialLoad(3.1217, 0.06865, 123.43, mean_at=0.0)
    verdict = rod.stability(load)
    converged = rod.stability(load, modes=range(1, 61)).growth_rate
    assert verdict.error < 1e-3 * verdict.growth_rate
    assert verdict.growth_rate == pytest.approx(converged, abs=verdict.error)


def test_what_a_coupled_verdict_tells() -> None:
    rod = WIRE.replace(inclination=math.radians(60.0))
    load = fr.AxialLoad(0.2 * FORCE, 0.2 * FORCE, 150.0)
    found = rod.stability(load)
    assert found.load == load
    assert found.fastest_mode in found.unstable_modes
    assert found.time_to_grow(10.0) == pytest.approx(math.log(10.0) / found.growth_rate)
    assert isinstance(found.system, fr.HillSystem)
    assert rod.growth_rate(load) == pytest.approx(found.growth_rate, rel=1e-6)
    assert not rod.is_stable(load)
    damped = rod.replace(damping_rate=found.damping_to_stabilise * 1.001).stability(load)
    assert damped.status == "stable"
    assert rod.replace(damping_rate=0.99 * found.damping_to_stabilise).stability(load).status == "unstable"


# --- bad input ---


@pytest.mark.parametrize("ends", ["fixed", "clamped-", "clamped-hinged-free", "", "-", None, 3, ("clamped", "hinged")])
def test_unknown_ends_are_refused(ends: Any) -> None:
    with pytest.raises((TypeError, ValueError), match=r"^ends must"):
        WIRE.replace(ends=ends)


@pytest.mark.parametrize("value", [math.nan, math.inf, -0.1, 1.1, "top", True, 1j])
def test_the_mean_has_its_place_on_the_rod(value: Any) -> None:
    for kind in (fr.AxialLoad, fr.AxialWave):
        with pytest.raises((TypeError, ValueError), match=r"^mean_at must"):
            kind(0.3, 0.3, 150.0, mean_at=value)


@pytest.mark.parametrize("value", ["open", "", None, 1, "HELD "])
def test_unknown_far_ends_are_refused(value: Any) -> None:
    with pytest.raises((TypeError, ValueError), match=r"^far_end must"):
        fr.AxialWave(0.3, 0.3, 150.0, far_end=value)


@pytest.mark.parametrize("value", [-1e-9, math.nan, math.inf, None, "0.1N", True])
def test_axial_damping_is_a_decay_rate(value: Any) -> None:
    with pytest.raises((TypeError, ValueError), match=r"^axial_damping must"):
        fr.AxialWave(0.3, 0.3, 150.0, axial_damping=value)


@pytest.mark.parametrize("value", ["sawtooth", (), (0.0,), (math.nan,), (1.0, math.inf), None, 3.0, ("a",), [[1.0]]])
def test_waveforms_are_words_or_harmonics(value: Any) -> None:
    with pytest.raises((TypeError, ValueError), match=r"^waveform must"):
        fr.AxialLoad(0.3, 0.3, 150.0, waveform=value)


@pytest.mark.parametrize(("far_end", "quarters"), [("held", 1), ("held", 3), ("free", 2), ("driven", 2)])
def test_resonance_of_an_undamped_wave_is_refused(far_end: str, quarters: int) -> None:
    frequency = 0.5 * math.pi * quarters * TUBING.wave_speed / TUBING.length
    wave = fr.AxialWave(6e3, 1e3, frequency, far_end=far_end)
    with pytest.raises(ValueError, match="axial_damping"):
        TUBING.stability(wave)
    damped = fr.AxialWave(6e3, 1.0, frequency, far_end=far_end, axial_damping=50.0)
    system = TUBING.modal_system(damped)
    assert np.isfinite(np.asarray(system.cosines)).all()


# --- trials with several numbers of modes ---


def test_a_verdict_tells_of_its_trials() -> None:
    calls: list[tuple[int, int]] = []
    load = growing(SHORT, "held")
    found = SHORT.stability(load, progress=lambda *of: calls.append(of))
    assert calls == [(1, 2), (2, 2)]
    assert len(found.convergence) == 2
    calls.clear()
    SHORT.stability(load, range(1, 9), progress=lambda *of: calls.append(of))
    assert calls == [(1, 1)]
    with pytest.raises(TypeError, match="progress"):
        SHORT.stability(load, progress=3)  # type: ignore[call-overload]


def test_where_more_modes_are_needed_fewer_than_the_first_are_not_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """What decays with the modes that may grow fastest is asked again with all that may grow, and no third time."""
    asked: list[int] = []

    def trial(modes: Any, load: Any, larger: Any) -> Any:
        asked.append(modes.count)
        whole = SimpleNamespace(status="stable", growth_rate=0.0, exponents=(-1.0 + 0.0j,), note="")
        return coupled_stability._Trial(modes, None, whole, -1.0, -1.0)  # type: ignore[arg-type]

    monkeypatch.setattr(coupled_stability._Trial, "of", trial)
    rod = TUBING.replace(length=3000.0, damping_rate=0.01)
    unit = rod.critical_force
    load = fr.AxialWave(0.5 * unit, 0.3 * unit, 25.0, axial_damping=0.5)
    calls: list[tuple[int, int]] = []
    found = coupled_stability._trials(rod._modes_under(load), load, None, 0.0, lambda *of: calls.append(of))
    needed, _ = rod.modes_needed(load)
    assert asked == [one.modes.count for one in found]
    assert len(asked) == 2
    assert asked[1] >= max(needed, 1.1 * asked[0])
    assert calls == [(1, 2), (2, 2)]


@pytest.mark.slow
def test_a_long_rod_that_buckles_fast_is_unstable_with_every_number_of_modes() -> None:
    """It grows 2,600-fold in a period: multipliers that decay as fast are lost in rounding, and decide nothing."""
    rod = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=250.0, inclination=1.22, ends="clamped")
    unit = rod.critical_force
    found = rod.replace(damping_rate=0.2).stability(fr.AxialWave.hertz(2.2 * unit, 0.3 * unit, 4.0, axial_damping=0.5))
    assert not np.isfinite(found.whole.exponent_errors).all()
    assert found.status == "unstable"
    assert len(found.convergence) == 3
    assert 0.0 < found.error < 1e-3
    assert found.growth_rate == pytest.approx(31.4846942, abs=found.error)  # of 140 modes and more


DRIVEN_FAR_ABOVE = {
    "clamped, a mode at the third half harmonic": (
        ("clamped", 8.326587861712492, 0.3),
        fr.AxialLoad(0.16551941210874235, 0.242064487585648, 190.02284565154687),
        2.796126,
        1e-5,
    ),
    "free, short": (
        ("clamped-free", 24.00747954854086, 0.3),
        fr.AxialLoad(0.32428654528876827, 0.09774224314140394, 111.58690536155243),
        0.6384665,
        1e-3,
    ),
    "free, steep waves at the end": (
        ("free-hinged", 36.362410763855415, 1.0),
        fr.AxialWave(0.9036686275352149, 0.2800578039988986, 188.05535278225102),
        16.09591,
        1e-2,
    ),
    "free, a mode at the fifth half harmonic": (
        ("clamped-free", 29.753966767506675, 1.0),
        fr.AxialWave(0.795239947866832, 0.32612906454506807, 142.65251105999948),
        26.70447,
        1.0,
    ),
}
"""Ends, length in m, damping rate in 1/s; load; growth in 1/s of 160 modes and more; largest error to be stated."""


@pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning")
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (k > 0)) for k, name in enumerate(DRIVEN_FAR_ABOVE)]
)
def test_modes_far_above_those_that_grow_are_in_the_error(name: str) -> None:
    """Where ends are not hinged a harmonic of the motion drives them, and growth jumps where they join."""
    (ends, length, rate), load, growth, most = DRIVEN_FAR_ABOVE[name]
    found = fr.Rod.nitinol().replace(ends=ends, length=length, damping_rate=rate).stability(load)
    assert found.status == "unstable"
    assert found.growth_rate == pytest.approx(growth, abs=found.error + 1e-6)
    assert found.error < most


@pytest.mark.parametrize(("tolerance", "status"), [(0.0, "unstable"), (1.8, "unstable"), (2.1, "undecided")])
def test_growth_beside_which_others_are_lost_is_a_lower_bound(tolerance: float, status: str) -> None:
    """Where rounding hides slower solutions what grows for certain decides, and the error is not said to be known."""
    whole: Any = SimpleNamespace(status="unstable", exponents=(2.0 + 0.0j, -2.4 + 0.0j), note="")
    fewer, trial = (
        coupled_stability._Trial(SimpleNamespace(count=count), None, whole, least, math.inf)  # type: ignore[arg-type]
        for count, least in ((18, 1.9), (22, 1.95))
    )
    found, error, note = trial.concluded([fewer], tolerance)
    assert (found, error) == (status, math.inf)
    assert note == (
        "growth is at least 1.95 1/s, beside which slower solutions are lost in rounding"
        if status == "unstable"
        else "multipliers could not be computed"
    )
