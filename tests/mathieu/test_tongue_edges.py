"""The ends of Mathieu's tongues along lines, held against scipy's characteristic values."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.special

from floquetrod.mathieu.kernels.characteristic_bisection import PlaneLine
from floquetrod.mathieu.kernels.tongue_edges import tongue_end

pytestmark = pytest.mark.kernels


@pytest.mark.parametrize("odd", [False, True])
@pytest.mark.parametrize("order", [0, 1, 2, 3, 4, 7])
def test_a_tongue_ends_at_its_characteristic_value(order: int, odd: bool, rng: np.random.Generator) -> None:
    value = scipy.special.mathieu_b if odd else scipy.special.mathieu_a
    for _ in range(20):
        slope, q0, q1 = rng.uniform(0.5, 2.0), rng.uniform(0.0, 3.0), rng.uniform(0.0, 0.2)
        low, high = -20.0 + rng.random(), 200.0
        end = tongue_end(order, odd, PlaneLine(slope, q0, q1, 1.0, 0.0), low, high)
        if order == 0 and odd:  # there is no b_0: tongue 0 begins where the line does
            assert end == low
            continue
        q = q0 + q1 * end
        assert slope * end == pytest.approx(value(order, q), rel=1e-10, abs=1e-10)


def test_the_end_lies_beyond_the_value() -> None:
    # a_n is a double of its own where q is 0, and the next double is the first beyond.
    for order in (1, 2, 3, 5):
        end = tongue_end(order, False, PlaneLine(1.0, 0.0, 0.0, 1.0, 0.0), -5.0, 100.0)
        assert end == np.nextafter(float(order**2), np.inf)
