"""Concave growth against a level: nothing above it is left out, nothing below it is counted."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from floquetrod._util.roots import bisected, roots
from floquetrod.mathieu.concave_growth import TOUCHING, level, parts_above
from tests.conftest import depth

Floats = NDArray[np.float64]


def arch(x: Floats, low: float, high: float, tilt: float) -> Floats:
    """Return a concave function that is zero at both ends, with vertical slopes there: like growth in a tongue."""
    inside = np.clip((x - low) * (high - x), 0.0, None)
    return np.sqrt(inside) * np.clip(1.0 + tilt * (x - low) / (high - low), 0.0, None) ** 0.5


@settings(max_examples=depth(300, 40))
@given(
    st.floats(0.01, 50.0),
    st.floats(-6.0, 1.0),
    st.floats(-0.9, 5.0),
    st.floats(1e-3, 1.3),
    st.floats(0.0, 1.0),
)
def test_the_part_above_is_found_whole(start: float, power: float, tilt: float, height: float, share: float) -> None:
    # sqrt of a product of positive concave functions: the arch is concave for every tilt above -1.
    low, high = start, start * (1.0 + 10.0**power)
    x = low + (high - low) * (0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, 5001)))
    values = arch(x, low, high, tilt)
    top = height * values.max()
    constant, root = share * top, (1.0 - share) * top / math.sqrt(low)
    parts = parts_above(
        lambda place, _: arch(place, low, high, tilt), np.array([low]), np.array([high]), level(constant, root, size=1)
    )
    surplus = values - constant - root * np.sqrt(x)
    found = np.zeros(x.size, dtype=bool)
    for first, last in zip(parts.first, parts.last, strict=True):
        found |= (x >= first) & (x <= last)
    clear = np.abs(surplus) > 1e-7 * top
    assert (found == (surplus > 0.0))[clear].all()


@given(st.floats(1e-9, 1e3), st.floats(1e-9, 1e3))
def test_a_part_that_fills_its_interval_ends_with_it_to_the_bit(low: float, width: float) -> None:
    ends = np.array([low]), np.array([low + width])
    parts = parts_above(lambda x, _: np.ones(x.size), *ends, level(0.5, size=1))
    assert (parts.first, parts.last) == ends


@pytest.mark.parametrize("excess", [1e-8, 1e-5, 1e-2])
@pytest.mark.parametrize("place", [0.013, 0.5, 0.9999])
def test_a_peak_barely_above_its_level_is_found(place: float, excess: float) -> None:
    def peak(x: Floats, _: object) -> Floats:
        return 1.0 - (x - place) ** 2

    low, high = np.array([0.0]), np.array([1.0])
    (first,), (last,) = parts_above(peak, low, high, level(1.0 - excess, size=1))[1:]
    assert first == pytest.approx(max(0.0, place - math.sqrt(excess)), abs=1e-7)
    assert last == pytest.approx(min(1.0, place + math.sqrt(excess)), abs=1e-7)
    assert not parts_above(peak, low, high, level(1.0 + 10.0 * TOUCHING, size=1)).which.size


def test_two_parts_of_one_tongue_are_two_parts() -> None:
    # A concave function can exceed a root twice: near its origin, where the root is steep, and further out.
    def growth(x: Floats, _: object) -> Floats:
        return np.minimum(0.2 + 1.35 * x, 0.9 + 0.135 * x)

    ((low, middle), (again, high)) = sorted(
        zip(*parts_above(growth, np.array([0.0]), np.array([2.0]), level(0.0, 1.1, size=1))[1:], strict=True)
    )
    assert low == 0.0
    assert 0.0 < middle < again < high
    for x in (middle, again, high):
        assert growth(np.array([x]), None)[0] == pytest.approx(1.1 * math.sqrt(x), rel=1e-12)


@given(st.floats(-5.0, 5.0), st.floats(0.1, 10.0), st.floats(0.3, 5.0))
def test_roots(place: float, width: float, power: float) -> None:
    assume(abs(place) > 1e-3)

    def function(x: Floats, _: object) -> Floats:
        return np.sign(x - place) * np.abs(x - place) ** power

    low, high = np.array([place - width]), np.array([place + 2.0 * width])
    (found,) = roots(function, low, high, function(low, None), function(high, None))
    assert abs(found - place) <= 1e-14 * (abs(place) + width)
    accuracy = np.array([1e-6 * width])
    (near,) = roots(function, low, high, function(low, None), function(high, None), accuracy)
    assert abs(near - place) <= 2.0 * accuracy[0]


def test_a_statement_is_bisected_to_where_it_ceases_to_hold() -> None:
    places, low, high = np.array([0.3, 2.0, 7.5]), np.zeros(3), np.full(3, 8.0)
    bottom, top = bisected(lambda x: x < places, low, high, 20)
    assert (bottom < places).all()
    assert (places <= top).all()
    assert (top - bottom == 8.0 / 2**20).all()
    looked: list[Floats] = []

    def noted(x: Floats) -> NDArray[np.bool_]:
        looked.append(x)
        return x < places

    bottom, top = bisected(noted, low, high, 1000, relative=1e-3)
    assert (top - bottom <= 1e-3 * top).all()
    assert len(looked) == 15  # 8 / 2^15 is the first below 1e-3 of 0.3
    assert (low == 0.0).all()  # what came in is left as it was
    bottom, top = bisected(noted, low[:0], high[:0], 1000)
    assert bottom.size == top.size == 0
    assert len(looked) == 15
