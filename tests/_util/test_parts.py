"""Parts of a line: runs of a mask, and what parts leave of bounds."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from floquetrod._util.interval import RealInterval
from floquetrod._util.spans import complement, runs

ENDS = st.integers(-2, 12).map(float)
PARTS = st.lists(st.tuples(ENDS, ENDS).map(lambda pair: RealInterval(min(pair), max(pair))), max_size=6)


@given(PARTS)
def test_bounds_are_what_parts_cover_and_what_they_leave(parts: list[RealInterval]) -> None:
    found = complement((0.0, 10.0), parts)
    for middle in np.arange(0.5, 10.0).tolist():  # all ends are whole
        is_covered = any(part.low < middle < part.high for part in parts)
        assert is_covered != any(gap.low < middle < gap.high for gap in found)
    assert all(0.0 <= gap.low < gap.high <= 10.0 for gap in found)
    assert all(one.high <= other.low for one, other in pairwise(found))
    for gap in found:
        assert (gap.before is None) <= (gap.low == 0.0)
        assert gap.before is None or gap.before.high == gap.low
        assert (gap.after is None) <= (gap.high == 10.0)
        assert gap.after is None or gap.after.low == gap.high


def test_bounds_without_a_width_and_equal_parts() -> None:
    assert [gap[:2] for gap in complement((1.0, 1.0), [])] == [(1.0, 1.0)]
    assert complement((1.0, 1.0), [RealInterval(0.0, 2.0)]) == []
    one, other, touching = RealInterval(1.0, 2.0), RealInterval(1.0, 2.0), RealInterval(2.0, 3.0)
    before, after = complement((0.0, 4.0), [touching, one, other])
    assert before.after is one
    assert after.before is touching


@pytest.mark.parametrize(
    ("mask", "expected"), [("", []), ("0", []), ("1", [(0, 1)]), ("0110", [(1, 3)]), ("1011", [(0, 1), (2, 4)])]
)
def test_runs_of_a_mask(mask: str, expected: list[tuple[int, int]]) -> None:
    assert runs(np.array([each == "1" for each in mask], dtype=np.bool_)) == expected
