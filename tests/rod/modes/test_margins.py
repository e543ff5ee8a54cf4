"""Margins of drawn rods whose modes are coupled against the ranges of the same quantity."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from tests.fuzz import core, margins, real_rods

_MOST_PHASE = 120.0  # of the fastest motion over a period, for ranges that take a second


def drawn(rng: np.random.Generator) -> tuple[real_rods.Question, Any]:
    """Return a stable load on a short rod with verdicts that take milliseconds."""
    while True:
        question, verdict = margins.draw(rng)
        fastest = math.sqrt(float(np.linalg.eigvalsh(verdict.system.stiffness)[-1]))
        if verdict.stable and fastest * verdict.period < _MOST_PHASE:
            return question, verdict


@pytest.mark.slow
@pytest.mark.parametrize("quantity", ["mean", "amplitude", "frequency"])
def test_a_margin_ends_with_the_range_that_holds_the_load(quantity: Any, rng: np.random.Generator) -> None:
    with core.own_warnings_only():
        compare(quantity, rng, 20)


def compare(quantity: Any, rng: np.random.Generator, count: int) -> None:
    """Compare so many margins that end within reach with ranges."""
    real_rods.warm()
    compared = 0
    while compared < count:
        question, verdict = drawn(rng)
        above = verdict.margin(quantity, seconds=1.0).above
        if not math.isfinite(above):
            continue
        compared += 1
        rod, load = question.rod, question.load
        here = getattr(load, quantity)
        margin = verdict.margin(quantity, seconds=1.0)
        low, high = max(here, here + above - 20.0 * margin.resolution), here + above + 2.0 * margin.resolution
        ranges = rod.ranges(quantity, load, (low, high), growth_tolerance=verdict.margin_tolerance)
        first, slack = ranges.intervals[0], 1e-8 * abs(here + above)  # a mean force may be a pull
        assert first.low == low
        if first.high < here + above - slack:  # a part that the margin, which has fewer samples, passed over
            gap = ranges.intervals[1].low - first.high if len(ranges.intervals) > 1 else high - first.high
            assert gap <= margin.resolution, question
        elif first.high > here + above + slack:  # one that the ranges passed over
            beyond = load.varied(quantity, here + above + ranges.resolution)
            assert rod.stability(beyond, growth_tolerance=verdict.margin_tolerance).status != "unstable", question
        else:
            assert first.high == pytest.approx(here + above, rel=1e-8), question
