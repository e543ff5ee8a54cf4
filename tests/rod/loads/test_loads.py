"""Loads: profiles of axial waves against their formulas in many digits, waveforms, copies, and every bad input."""

from __future__ import annotations

import copy
import math
import pickle
from collections.abc import Callable
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.rod.model.contact import added_mean
from tests.inside import Load

ROD = fr.Rod.nitinol()
TUBING = fr.Rod(
    207e9,
    7850.0,
    25.4e-3,
    60.0,
    62e-3,
    inner_radius=21.44e-3,
    fluid_inside=1000.0,
    fluid_outside=1000.0,
    added_mass_coefficient=2.29,
)
NUMBERS = {"mean": 5970.42, "amplitude": 3582.252, "frequency": 25.0}
FAR_ENDS = ("held", "free", "driven")
FORMULAS: dict[str, Callable[[Any, Any, Any], Any]] = {
    "held": lambda kappa, length, s: mp.cos(kappa * (length - s)) / mp.cos(kappa * length),
    "free": lambda kappa, length, s: mp.sin(kappa * (length - s)) / mp.sin(kappa * length),
    "driven": lambda kappa, length, s: mp.cos(kappa * (s - length / 2)) / mp.cos(kappa * length / 2),
}
"""Of the vibration of unit amplitude, far end by far end."""


def exact(wave: fr.AxialWave, speed: float, length: float, s: float, frequency: float) -> complex:
    """Return the vibration from the textbook's formula in 40 digits."""
    with mp.workdps(40):
        w = mp.mpf(frequency)
        kappa = mp.sqrt(w * w - 2j * mp.mpf(wave.axial_damping) * w) / mp.mpf(speed)
        return complex(FORMULAS[wave.far_end](kappa, mp.mpf(length), mp.mpf(s)))


def wave(far_end: str = "held", axial_damping: float = 0.0, **others: Any) -> fr.AxialWave:
    """Return an axial wave."""
    return fr.AxialWave(**(NUMBERS | others), far_end=far_end, axial_damping=axial_damping)  # type: ignore[arg-type]


# --- profiles ---


@given(
    st.sampled_from(FAR_ENDS),
    st.floats(0.01, 40.0),
    st.one_of(st.just(0.0), st.floats(1e-3, 1e3)),
    st.floats(1.0, 1e4),
)
def test_waves_are_those_of_the_formulas(far_end: str, turns: float, damping: float, length: float) -> None:
    speed = 5000.0
    frequency = turns * speed / length  # kappa L without damping
    load = wave(far_end, damping)
    s = np.linspace(0.0, length, 7)
    with mp.workdps(40):
        kappa = mp.sqrt(mp.mpf(frequency) ** 2 - 2j * mp.mpf(damping) * frequency) / speed
        ways = {"held": mp.cos(kappa * length), "free": mp.sin(kappa * length), "driven": mp.cos(kappa * length / 2)}
        room = float(abs(ways[far_end]))
    assume(room > 1e-3)
    found = load.profile(speed, length, s, frequency)
    expected = np.array([exact(load, speed, length, at, frequency) for at in s])
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-13 * (1.0 + turns) / room**2)
    assert np.isrealobj(found) == (damping == 0.0)


@pytest.mark.parametrize("damping", [0.0, 3.0, 400.0])
@pytest.mark.parametrize("far_end", FAR_ENDS)
def test_waves_obey_the_wave_equation_and_their_ends(far_end: str, damping: float) -> None:
    length, speed, frequency = 60.0, 5135.0, 300.0
    s = np.linspace(0.0, length, 2001)
    force = wave(far_end, damping).profile(speed, length, s, frequency).astype(complex)
    step = s[1]
    curvature = (force[2:] - 2.0 * force[1:-1] + force[:-2]) / step**2
    kappa2 = (frequency**2 - 2j * damping * frequency) / speed**2
    assert np.abs(curvature + kappa2 * force[1:-1]).max() < 1e-5 * abs(kappa2) * np.abs(force).max()
    assert force[0] == pytest.approx(1.0, abs=1e-14)
    if far_end == "held":  # no motion at s = L: the slope of the force is zero there
        slope = (1.5 * force[-1] - 2.0 * force[-2] + 0.5 * force[-3]) / step
        assert abs(slope) < 1e-4 * abs(kappa2) * length
    else:
        assert force[-1] == pytest.approx(0.0 if far_end == "free" else 1.0, abs=1e-13)


@pytest.mark.parametrize("far_end", ["held", "driven"])
def test_fast_waves_leave_the_force_uniform(far_end: str) -> None:
    s = np.linspace(0.0, 60.0, 11)
    for speed, room in ((1e5, 1e-3), (1e7, 1e-7)):
        assert np.abs(wave(far_end, 0.5).profile(speed, 60.0, s, 25.0) - 1.0).max() < room
    even = fr.AxialLoad(**NUMBERS)
    assert even.profile(1.0, 60.0, s, 25.0).tolist() == [1.0] * 11
    assert even.is_uniform
    assert not wave(far_end).is_uniform


def test_a_fast_wave_to_a_free_end_falls_linearly() -> None:
    s = np.linspace(0.0, 60.0, 11)
    assert np.abs(wave("free", 0.5).profile(1e7, 60.0, s, 25.0) - (1.0 - s / 60.0)).max() < 1e-7


def test_growth_under_a_fast_wave_is_that_under_a_uniform_force() -> None:
    # A short rod, c_0 / f far beyond it: the wave is all but uniform, and so is growth.
    load = fr.AxialLoad(0.2 * ROD.critical_force, 0.2 * ROD.critical_force, 150.0)
    held = fr.AxialWave(load.mean, load.amplitude, load.frequency)
    uniform, travelling = ROD.stability(load).growth_rate, ROD.stability(held).growth_rate
    ratio = 0.5 * (load.frequency * ROD.length / ROD.wave_speed) ** 2  # what cos kappa L lacks of 1
    assert 0.0 < abs(travelling - uniform) < 2.0 * ratio * uniform


@pytest.mark.parametrize("far_end", FAR_ENDS)
def test_strong_damping_does_not_overflow(far_end: str) -> None:
    s = np.linspace(0.0, 3000.0, 301)
    for damping in (1e3, 1e6, 1e12):
        load = wave(far_end, damping)
        found = load.profile(5135.0, 3000.0, s, 100.0)
        assert np.isfinite(found).all()
        assert found[0] == pytest.approx(1.0, abs=1e-12)
        assert np.abs(found).max() <= 1.0 + 1e-12
        assert found[1] == pytest.approx(exact(load, 5135.0, 3000.0, 10.0, 100.0), rel=1e-10)


@pytest.mark.parametrize(("far_end", "phase"), [("held", 0.5), ("held", 1.5), ("free", 1.0), ("driven", 1.0)])
def test_resonance_is_refused_without_damping_only(far_end: str, phase: float) -> None:
    frequency = phase * math.pi * TUBING.wave_speed / TUBING.length
    load = wave(far_end, frequency=frequency)
    message = rf"frequency .* is at the axial resonance of the rod at .* far end {far_end}: .*give axial_damping"
    for ask in (TUBING.stability, TUBING.modal_system):
        with pytest.raises(ValueError, match=message):
            ask(load)
    with pytest.raises(ValueError, match=message):
        TUBING.is_stable(load, mean=1.0, amplitude=1.0, frequency=frequency)
    s = np.linspace(0.0, 60.0, 11)
    damped = wave(far_end, 1.0).profile(TUBING.wave_speed, 60.0, s, frequency)
    assert np.isfinite(damped).all()
    assert np.abs(damped).max() > 5.0
    near = wave(far_end).profile(TUBING.wave_speed, 60.0, s, 0.999 * frequency)
    assert np.abs(near).max() > 50.0


def test_resonance_of_a_harmonic_is_refused() -> None:
    frequency = 0.25 * math.pi * TUBING.wave_speed / TUBING.length  # whose second harmonic resonates
    load = wave("held", frequency=frequency, waveform=(1.0, 0.5))
    with pytest.raises(ValueError, match="is where harmonic 2 of the load meets the axial resonance"):
        TUBING.stability(load)
    assert TUBING.modal_system(wave("held", frequency=frequency, waveform=(1.0, 0.0)), range(1, 4)).order == 3  # type: ignore[union-attr]


# --- what the equations make of a load ---


@pytest.mark.parametrize("mean_at", [0.0, 0.3, 0.5, 1.0, None])
def test_the_mean_force_holds_where_it_is_said_to(mean_at: float | None) -> None:
    rod = TUBING.replace(inclination=math.radians(30.0))
    load = fr.AxialLoad(1000.0, 0.0, 3.0, mean_at=mean_at)
    x = np.array([0.0, 0.3, 0.5, 1.0])
    along = 0.0 if mean_at is None else rod.weight_per_length * math.cos(math.radians(30.0)) * rod.length
    expected = along * (x - (mean_at or 0.0))
    assert added_mean(rod, load, x) == pytest.approx(expected, rel=1e-12, abs=1e-9)
    assert rod.weight_along == pytest.approx(rod.weight_per_length * math.cos(math.radians(30.0)), rel=1e-12)
    # The same force, said to hold elsewhere.
    there = load.mean + rod.weight_along * rod.length * (1.0 - (0.0 if mean_at is None else mean_at))
    if mean_at is not None:
        same = fr.AxialLoad(there, 0.0, 3.0, mean_at=1.0)
        one, other = (np.asarray(rod.modal_system(each, range(1, 13)).stiffness) for each in (load, same))
        assert one == pytest.approx(other, rel=1e-12, abs=1e-12 * np.abs(one).max())
    else:
        assert isinstance(rod.modal_system(load), fr.HillSystem) is False


def test_the_system_has_the_force_of_the_load() -> None:
    load = wave("held", 0.7, waveform=(0.3 - 1j, 0.0, 0.2j), mean_at=0.2)
    rod = TUBING.replace(inclination=1.0)
    system = rod.modal_system(load, range(1, 7))
    points, weights = np.polynomial.legendre.leggauss(200)
    x, weights = 0.5 + 0.5 * points, 0.5 * weights
    m = np.arange(1, 7)
    slopes = math.sqrt(2.0) * (m * math.pi)[:, None] * np.cos(m[:, None] * math.pi * x)
    bed = np.diag(
        rod.flexural_rigidity / rod.mass_per_length * (m * math.pi / rod.length) ** 4 + rod.pendulum_frequency**2
    )
    for t in (0.0, 0.031, 0.2):
        force = load.mean + rod.weight_along * rod.length * (x - 0.2)
        for k, h in ((1, 0.3 - 1j), (3, 0.2j)):
            along = [exact(load, rod.wave_speed, rod.length, at * rod.length, k * load.frequency) for at in x]
            force = force + load.amplitude * (h * np.array(along) * np.exp(1j * k * load.frequency * t)).real
        push = (slopes * weights * force) @ slopes.T / (rod.mass_per_length * rod.length**2)
        assert system.coefficient(t) == pytest.approx(bed - push, rel=1e-9, abs=1e-9 * np.abs(push).max())


def test_harmonics_of_a_sine() -> None:
    assert fr.AxialLoad(**NUMBERS).harmonics.tolist() == [-1j]
    t = np.linspace(0.0, 1.0, 7)
    assert (-1j * np.exp(25j * t)).real == pytest.approx(np.sin(25.0 * t))


def test_trailing_zeros_are_no_harmonics() -> None:
    load = fr.AxialLoad(**NUMBERS, waveform=[1, 0, 2j, 0.0, 0])  # type: ignore[arg-type]
    assert load.waveform == (1.0, 0.0, 2j)
    assert all(type(h) is complex for h in load.waveform)
    assert load == fr.AxialLoad(**NUMBERS, waveform=(1.0, 0.0, 2j))
    assert fr.AxialLoad(**NUMBERS, waveform=np.array([1.0 + 2j])).waveform == (1.0 + 2j,)  # type: ignore[arg-type]


# --- values ---

LOADS: list[Load] = [
    fr.AxialLoad(**NUMBERS),
    fr.AxialLoad(**NUMBERS, mean_at=None),
    fr.AxialLoad(**NUMBERS, mean_at=0.0, waveform=(0.5 - 1j, 0.25j)),
    wave(),
    wave("free", 0.5),
    wave("driven", mean_at=1.0, waveform=(1.0,)),
]


@pytest.mark.parametrize("load", LOADS, ids=repr)
def test_a_load_is_its_data(load: Load) -> None:
    names = {"AxialLoad": fr.AxialLoad, "AxialWave": fr.AxialWave}
    assert eval(repr(load), dict(names)) == load
    assert type(load)(**load.as_dict()) == load
    assert pickle.loads(pickle.dumps(load)) == load == copy.deepcopy(load)
    assert hash(load) == hash(copy.copy(load))
    assert load.varied("mean", 1.0).mean == 1.0
    assert load.varied("mean", 1.0).varied("mean", load.mean) == load
    other = load.with_numbers(1.0, 2.0, 3.0)
    assert (other.mean, other.amplitude, other.frequency) == (1.0, 2.0, 3.0)
    assert other.with_numbers(**NUMBERS) == load
    assert type(load).hertz(load.mean, load.amplitude, 4.0).frequency == pytest.approx(8.0 * math.pi)


def test_loads_differ_where_their_data_do() -> None:
    assert len(set(LOADS)) == len(LOADS)
    assert fr.AxialLoad(**NUMBERS) != wave()
    assert repr(fr.AxialLoad(1.0, 2.0, 3.0)) == "AxialLoad(mean=1.0, amplitude=2.0, frequency=3.0)"
    assert list(wave("free", mean_at=None).as_dict()) == ["mean", "amplitude", "frequency", "mean_at", "far_end"]
    for value in LOADS:
        with pytest.raises(AttributeError):
            value.mean = 1.0  # type: ignore[misc]


BAD: list[tuple[dict[str, Any], type[Exception] | tuple[type[Exception], ...], str]] = [
    ({"mean": math.nan}, ValueError, "^mean must be finite"),
    ({"mean": "3kNm"}, ValueError, "^mean must be a number with a force unit"),
    ({"mean": "0.3Fcr"}, ValueError, "^mean must have a unit of force .* times rod.critical_force"),
    ({"mean": 1e13}, ValueError, "^mean must lie between"),
    ({"mean": [1.0]}, TypeError, "^mean must be"),
    ({"amplitude": -1.0}, ValueError, "^amplitude must be zero or more.*give its size"),
    ({"amplitude": None}, TypeError, "^amplitude must be"),
    ({"frequency": 0.0}, ValueError, "^frequency must be greater than zero.*set amplitude=0"),
    ({"frequency": 1e13}, ValueError, "^frequency must lie between"),
    ({"mean_at": 1.5}, ValueError, "^mean_at must lie between 0 and 1.*a fraction of the length"),
    ({"mean_at": -0.1}, ValueError, "^mean_at must be zero or more"),
    ({"mean_at": "top"}, TypeError, "^mean_at must be a real number"),
    ({"mean_at": True}, TypeError, "^mean_at must be a real number"),
    (
        {"waveform": "square"},
        (TypeError, ValueError),
        "^waveform must be 'sine' or a sequence.*a square wave has -4i/pi",
    ),
    ({"waveform": None}, (TypeError, ValueError), "^waveform must be 'sine' or a sequence"),
    ({"waveform": 1j}, (TypeError, ValueError), "^waveform must be 'sine' or a sequence"),
    ({"waveform": ()}, (TypeError, ValueError), "^waveform must be 'sine' or a sequence"),
    ({"waveform": ("1j",)}, (TypeError, ValueError), "^waveform must be 'sine' or a sequence"),
    ({"waveform": (True,)}, (TypeError, ValueError), "^waveform must be 'sine' or a sequence"),
    ({"waveform": [[1.0], [2.0, 3.0]]}, (TypeError, ValueError), "^waveform must be 'sine' or a sequence"),
    ({"waveform": [[1.0, 2.0]]}, (TypeError, ValueError), "^waveform must be 'sine' or a sequence"),
    ({"waveform": {1.0, 2.0}}, (TypeError, ValueError), "^waveform must be 'sine' or a sequence"),
    ({"waveform": {1: 2.0}}, (TypeError, ValueError), "^waveform must be 'sine' or a sequence"),
    ({"waveform": [10**400]}, (TypeError, ValueError), "^waveform must"),
    ({"waveform": np.ma.array([1.0, 2.0], mask=[0, 1])}, (TypeError, ValueError), "^waveform must not be a masked"),
    ({"waveform": (0.0, 0.0)}, ValueError, "^waveform must hold a harmonic other than zero.*set amplitude=0"),
    ({"waveform": (math.nan,)}, ValueError, "^waveform must hold finite numbers"),
    ({"waveform": (1j * math.inf,)}, ValueError, "^waveform must hold finite numbers"),
    ({"waveform": (1e7,)}, ValueError, "^waveform must hold finite numbers up to 1e6"),
    ({"waveform": np.ones(100_000)}, ValueError, "^waveform must hold at most"),
]


@pytest.mark.parametrize("kind", [fr.AxialLoad, fr.AxialWave])
@pytest.mark.parametrize(("change", "error", "message"), BAD, ids=[repr(b[0])[:40] for b in BAD])
def test_bad_loads(
    kind: type[Load], change: dict[str, Any], error: type[Exception] | tuple[type[Exception], ...], message: str
) -> None:
    with pytest.raises(error, match=message):
        kind(**(NUMBERS | change))
    with pytest.raises(error, match=message):
        kind(**NUMBERS).varied(*next(iter(change.items())))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"far_end": "open"}, ValueError, "^far_end must be one of 'held', 'free', 'driven', got 'open'"),
        ({"far_end": None}, TypeError, "^far_end must be one of"),
        ({"axial_damping": -0.1}, ValueError, "^axial_damping must be zero or more.*decay rate in 1/s"),
        ({"axial_damping": "0.5N"}, ValueError, "^axial_damping must be a number with a rate unit"),
        ({"axial_damping": 1e13}, ValueError, "^axial_damping must lie between"),
        ({"axial_damping": math.nan}, ValueError, "^axial_damping must be finite"),
    ],
)
def test_bad_waves(change: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        fr.AxialWave(**(NUMBERS | change))


def test_other_data_is_by_name_only() -> None:
    with pytest.raises(TypeError):
        fr.AxialLoad(1.0, 2.0, 3.0, 0.5)  # type: ignore[misc]
    with pytest.raises(TypeError, match="axial_damping"):
        fr.AxialLoad(1.0, 2.0, 3.0, axial_damping=0.5)  # type: ignore[call-arg]
