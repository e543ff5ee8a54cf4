"""Growth enclosed from a single place along the amplitude, and what a search by enclosures finds and costs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.mathieu import enclosures, tongue_intervals
from tests.seams import Heard
from tests.strategies import decades, numbers


@given(
    numbers(0.05, 25.0), numbers(-30.0, -0.01), decades(1e-4, 0.5), st.lists(numbers(-1.0, 1.0), min_size=5, max_size=5)
)
def test_growth_lies_within_its_enclosure(alpha: float, b: float, share: float, shifts: list[float]) -> None:
    h = share * alpha
    rate = fr.mathieu.growth_rate(alpha, b)
    excess = np.array([2.0 * math.log(math.sinh(math.pi * rate)) if rate > 0.0 else -np.inf])
    bottom, top = enclosures.enclosed(*(np.array([x]) for x in (b, alpha, h)), excess, tongue_intervals.counts)
    if math.isinf(top[0]):  # a boundary may lie within h
        return
    for shift in (-1.0, 1.0, *shifts):
        near = fr.mathieu.growth_rate(alpha + shift * h, b)
        value = 2.0 * math.log(math.sinh(math.pi * near)) if near > 0.0 else -np.inf
        assert bottom[0] - 1e-6 <= value <= top[0] + 1e-6


def test_enclosures_decide_away_from_boundaries() -> None:
    b, alpha = np.array([-0.25, -2.25]), np.array([1.0, 6.0])  # in the middle of tongue 1, and far up
    rate = fr.mathieu.growth_rate(alpha, b)
    bottom, top = enclosures.enclosed(
        b, alpha, 0.002 * alpha, 2.0 * np.log(np.sinh(np.pi * rate)), tongue_intervals.counts
    )
    assert (rate > 0.1).all()
    assert (top - bottom < 0.5).all()


def test_thin_tongues_are_found_along_the_amplitude() -> None:
    # Tongue 5 is crossed within 0.0006 of a range of 24, a fortieth of the distance of samples.
    found = tongue_intervals.along_amplitude(*(np.array([x]) for x in (-6.260195028953647, 1.0369e-08, 0.0, 24.35)))
    assert [found.first[0], found.last[0]] == pytest.approx([0.6987674398, 0.6993840427], rel=1e-9)
    middle = 0.5 * (found.first[0] + found.last[0])
    outside = [found.first[0] * (1.0 - 1e-7), found.last[0] * (1.0 + 1e-7)]
    assert fr.mathieu.growth_rate([middle, *outside], -6.260195028953647).tolist() == [
        pytest.approx(2e-6, rel=0.9),
        0.0,
        0.0,
    ]


def test_margins_of_the_reference_rod_take_hundreds_of_growth_rates(heard: Heard) -> None:
    growth, counts = heard(tongue_intervals, "_growth"), heard(tongue_intervals, "counts")
    rod = fr.Rod.nitinol()
    unit = rod.critical_force
    found = rod.stability(fr.AxialLoad(0.2 * unit, 0.2 * unit, 150.0))
    assert found.amplitude_margin.below == pytest.approx(0.247736394904512, rel=1e-12)
    assert sum(first.size for first, _ in growth) <= 200  # 10,645 when growth was evaluated at even places
    assert sum(first.size for first, _ in counts) <= 3000  # 51,316
