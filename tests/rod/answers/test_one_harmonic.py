"""A force of one harmonic, of any phase: what is searched along a quantity is that of the sine, by its tongues."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from tests.inside import CoupledModel, Resonance

ROD = fr.Rod.nitinol()


def _drawn(rng: np.random.Generator) -> tuple[fr.Rod, fr.AxialLoad, fr.AxialLoad]:
    """Return a drawn rod, a force of one harmonic and a drawn phase, and the sine."""
    rod = ROD.replace(length=float(rng.uniform(1.0, 3.0)), damping_rate=float(rng.choice([0.0, 0.2])))
    mean, amplitude = (rng.uniform([0.0, 0.02], [0.7, 0.4]) * rod.critical_force).tolist()
    sine = fr.AxialLoad(mean, amplitude, float(rng.uniform(60.0, 250.0)))
    return rod, replace(sine, waveform=(cmath.exp(1j * rng.uniform(0.0, 6.0)),)), sine


@pytest.mark.slow
def test_margins_and_damping_are_those_of_the_sine(rng: np.random.Generator) -> None:
    for _ in range(6):
        rod, load, sine = _drawn(rng)
        verdict, plain = rod.stability(load), rod.stability(sine)
        assert verdict.status == plain.status
        margins = verdict.margins()
        assert margins == plain.margins(), load
        assert verdict.damping_to_stabilise == plain.damping_to_stabilise, load
        said, expected = (str(v.report(None, v.margins())).splitlines() for v in (verdict, plain))
        first, second = ([text for text in report if "mean force  " in text] for report in (said, expected))
        assert first == second
        assert "found by sampling" not in " ".join(said)


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, pytest.param(6, marks=pytest.mark.slow)])
def test_ranges_and_limits_are_those_of_the_sine(count: int, rng: np.random.Generator) -> None:
    for _ in range(count):
        rod, load, sine = _drawn(rng)
        bounds = (0.9 * sine.frequency, 1.1 * sine.frequency)
        ranges, plain = (rod.ranges("frequency", force, bounds) for force in (load, sine))
        assert ranges.intervals == plain.intervals, load
        assert ranges.unstable == plain.unstable
        assert ranges.resolution == plain.resolution
        assert rod.critical("amplitude", load) == rod.critical("amplitude", sine)


@pytest.mark.parametrize("waveform", [(0.5j,), (0.0, 1j), (1j, 0.1)])
def test_other_waveforms_are_sampled(waveform: Any) -> None:
    load = fr.AxialLoad(1.0, 0.5, 100.0, waveform=waveform)
    assert type(ROD._modes_under(load)) is CoupledModel
    sine = replace(load, waveform=(1j,))
    assert type(ROD._modes_under(sine).under(load)) is CoupledModel


@pytest.mark.slow
def test_a_recorded_sine_ends_where_the_sine_does() -> None:
    rod = fr.Rod(youngs_modulus=40e9, density=1950.0, diameter=8e-3, length=4.0, channel_diameter=12e-3)
    t = np.arange(0.0, 2.0, 0.005)
    noise = 0.02 * np.random.default_rng(3).standard_normal(t.size)
    record = fr.ForceRecord(t, 5.0 + 20.0 * np.sin(40.0 * math.pi * t + 0.3) + noise)
    assert len(record.load.harmonics) == 1
    verdict = rod.stability(record.load)
    sine = rod.stability(fr.AxialLoad(record.mean, record.amplitude, record.frequency))
    margins = verdict.margins()
    for quantity, margin in sine.margins().items():
        assert margins[quantity] == pytest.approx(margin, rel=1e-9)
    thin = verdict.model.band_beyond(verdict, "mean", margins["mean"].above)
    assert thin is not None
    assert (thin.cause, thin.is_thin) == ((6, 3), True)
    mean = record.mean + margins["mean"].above
    found = rod.ranges("mean", record.load, (record.mean, 1.2 * mean)).intervals[0]
    assert found.high == pytest.approx(mean, rel=1e-9)


@pytest.mark.slow
def test_samples_beyond_a_margin_show_the_band_of_the_sine(rng: np.random.Generator) -> None:
    compared = thin = 0
    while compared < 6 or thin < 2:  # some of the first six may all be wide
        rod, load, _ = _drawn(rng)
        verdict = rod.stability(load)
        if not verdict.stable:
            continue
        above = verdict.margin("frequency").above
        if not math.isfinite(above):
            continue
        compared += 1
        assert compared < 60
        exact = verdict.model.band_beyond(verdict, "frequency", above)
        sampled = CoupledModel(rod, load).band_beyond(verdict, "frequency", above)
        assert exact is not None
        if sampled is None:  # narrower than the samples
            assert exact.growth < 1e-3, load
            continue
        assert exact.is_thin or not sampled.is_thin, load  # a stable part between samples may be missed
        thin += sampled.is_thin
        if sampled.is_thin:
            assert 0.97 * exact.growth <= sampled.growth, load
            assert sampled.growth <= exact.growth * (1.0 + 1e-3), load
            assert isinstance(sampled.cause, Resonance)
            assert sampled.cause.modes == (exact.cause[0],)


def test_a_wave_says_the_growth_beyond_its_margins_and_how_narrow_a_band_it_may_miss() -> None:
    rod = fr.Rod(youngs_modulus=40e9, density=1950.0, diameter=8e-3, length=4.0, channel_diameter=12e-3)
    verdict = rod.stability(fr.AxialWave.hertz(5.0, 20.0, 17.0, far_end="free"))
    found = fr.results.Margin(math.inf, 0.3626969763709, 0.033716587822, (8.0, 0.3626969763709))
    margins: dict[Any, Any] = {"frequency": found}
    said = str(verdict.report({"frequency": "Hz"}, margins))
    assert "unstable 0.05773 Hz higher (sum resonance of modes 4 and 6, order 3: thin, 0.0022 1/s)" in said
    assert "found by sampling: changes closer together than 0.0054 Hz in frequency may be missed" in said
    ends = verdict.as_dict(margins)["frequency_margin_ends_in"]
    assert set(ends) == {"above"}
    assert ends["above"]["is_thin"]
    assert list(ends["above"]["cause"]["modes"]) == [4, 6]
