"""Spectra of signals and idlers: single responses, peaks, widths, the threshold, and what is refused."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

import floquetrod as fr


def amplifier(h: float, c: float = 0.01) -> fr.HillSystem:
    """Return x'' + 2 c x' + (1 + h sin 2t) x."""
    return fr.HillSystem([[1.0]], sines=[[[h]]], damping=[[2.0 * c]], period=math.pi)


PAIR = fr.HillSystem([[1.0, 0.2], [0.2, 3.0]], [[[0.1, 0.0], [0.0, 0.3]]], damping=np.diag([0.05, 0.1]), period=2.3)


def test_a_spectrum_is_made_of_single_responses() -> None:
    frequencies = np.linspace(0.5, 2.0, 7)
    spectrum = fr.gain(PAIR, at=0, out=1, frequency=frequencies, waves=(0, -1, 3))
    for i, w in enumerate(frequencies):
        waves = fr.response(PAIR, [1.0, 0.0], frequency=w).harmonics
        assert spectrum.amplitudes[i] == pytest.approx([waves[k][1] for k in (0, -1, 3)], rel=1e-10, abs=1e-16)
    assert spectrum.error.max() < 1e-11


def test_without_a_pump_the_peak_is_that_of_an_oscillator() -> None:
    c = 0.01
    spectrum = fr.gain(amplifier(0.0), frequency=(0.9, 1.1))
    where, height = spectrum.peak
    assert where == pytest.approx(math.sqrt(1.0 - 2.0 * c * c), abs=1e-7)
    assert height == pytest.approx(1.0 / (2.0 * c * math.sqrt(1.0 - c * c)), rel=1e-12)
    half = [math.sqrt(1.0 - 2.0 * c * c + s * 2.0 * c * math.sqrt(1.0 - c * c)) for s in (-1.0, 1.0)]
    assert spectrum.width == pytest.approx(half[1] - half[0], rel=1e-7)
    assert spectrum.slowest.decay_rate == pytest.approx(c, rel=1e-10)
    assert spectrum.slowest.frequency == pytest.approx(math.sqrt(1.0 - c * c), rel=1e-9)


def test_towards_the_threshold_the_peak_is_as_wide_as_motion_decays_slowly() -> None:
    products = []
    for h in (0.039, 0.0399, 0.03999):
        spectrum = fr.gain(amplifier(h), frequency=(0.9, 1.1))
        rate = spectrum.slowest.decay_rate
        products.append(spectrum.peak[1] * rate)
        assert spectrum.width == pytest.approx(2.0 * rate, rel=0.03)
    assert products[2] == pytest.approx(products[1], rel=5e-3)
    with pytest.raises(ValueError, match=r"^equation must be stable for a gain.*beyond the threshold"):
        fr.gain(amplifier(0.0405), frequency=(0.9, 1.1))


def test_frequencies_are_added_where_the_spectrum_bends() -> None:
    spectrum = fr.gain(amplifier(0.0399), frequency=(0.5, 1.5))
    gaps = np.diff(spectrum.frequency)
    assert gaps.min() < 1e-4 < 1e-2 < gaps.max()
    middle = 0.5 * (spectrum.frequency[1:] + spectrum.frequency[:-1])
    dense = fr.gain(amplifier(0.0399), frequency=middle).of(0)
    chord = 0.5 * (spectrum.of(0)[1:] + spectrum.of(0)[:-1])
    assert np.abs(dense - chord).max() < 0.03 * spectrum.peak[1]


def test_a_delayed_spectrum_has_a_closed_form() -> None:
    system = fr.DelaySystem.first_order([[-1.5]], delayed=[(1.0, [[-1.0]])], period=1.7)
    w = np.linspace(0.1, 5.0, 9)
    assert fr.gain(system, frequency=w).of(0) == pytest.approx(
        np.abs(1.0 / (1j * w + 1.5 + np.exp(-1j * w))), rel=1e-12
    )


def test_what_a_gain_says() -> None:
    spectrum = fr.gain(amplifier(0.03), frequency=(0.9, 1.1))
    assert "peak 114.281" in repr(spectrum)
    assert "wave k" in str(spectrum.report())
    assert json.loads(fr.to_json(spectrum))["result"]["peak"] == pytest.approx(114.281, rel=1e-5)
    assert len(spectrum.plot().lines) == 4
    narrow = fr.gain(amplifier(0.03), frequency=(1.001, 1.002))
    assert math.isnan(narrow.width)
    assert narrow.peak[0] == pytest.approx(1.001, rel=1e-6)


@pytest.mark.parametrize(
    ("arguments", "kind", "text"),
    [
        ({"frequency": 1.0}, ValueError, "frequency must be a range"),
        ({"frequency": (1.1, 0.9)}, ValueError, "frequency must increase"),
        ({"frequency": [1.0, 2.0, 1.5]}, ValueError, "frequency must increase"),
        ({"frequency": "0.9"}, TypeError, "frequency"),
        ({"frequency": (0.9, 1.1), "at": 2}, ValueError, "at must be at most 1"),
        ({"frequency": (0.9, 1.1), "out": -1}, ValueError, "out must be 0 or more"),
        ({"frequency": (0.9, 1.1), "waves": [1]}, ValueError, "waves must be different numbers, 0"),
        ({"frequency": (0.9, 1.1), "waves": [0, 0]}, ValueError, "waves must be different numbers"),
    ],
)
def test_bad_input_is_refused_in_a_line(arguments: dict[str, Any], kind: type[Exception], text: str) -> None:
    with pytest.raises(kind, match=text):
        fr.gain(PAIR, **arguments)


def test_jumps_and_resonances_are_refused() -> None:
    with pytest.raises(TypeError, match="one Fourier series for a spectrum"):
        fr.gain(fr.Meissner(0.3, -0.6, 0.15), frequency=(0.5, 1.0))
    with pytest.raises(ValueError, match=r"resonance.*got 1$"):
        fr.gain(fr.HillSystem([[1.0]], period=3.0), frequency=[0.5, 1.0, 1.5])
    with pytest.raises(ValueError, match="wave must be one of"):
        fr.gain(PAIR, frequency=[0.5, 1.0, 1.5]).of(7)
