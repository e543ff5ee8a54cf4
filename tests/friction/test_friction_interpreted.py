"""The kernels of friction in small doses, so that they are run interpreted and with checked indices too."""

from __future__ import annotations

import math

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.friction import BOUNDED, ESCAPES

pytestmark = pytest.mark.kernels


@pytest.mark.parametrize(("alpha", "beta", "damping"), [(0.0, 0.25, 0.0), (-1.0, 0.3, 0.02), (1.3817, 0.6107, 0.0)])
def test_the_critical_kick_is_an_edge(alpha: float, beta: float, damping: float) -> None:
    critical = fr.friction.critical_kick(alpha, beta, 2.0, damping=damping, samples=3, max_steps=3000).smallest_found
    kicks = critical * np.array([1.0 - 1e-7, 1.0 + 1e-7])
    assert fr.friction.fates(alpha, beta, 2.0, kicks, damping=damping, max_steps=3000).tolist() == [BOUNDED, ESCAPES]


def test_limits_of_the_search() -> None:
    critical = fr.friction.critical_kick(1.0, 0.3, samples=3, max_steps=3000).smallest_found
    below, above = fr.friction.critical_kick(
        1.0, 0.3, largest=[0.9 * critical, 1.1 * critical], samples=3
    ).smallest_found
    assert below == math.inf
    assert above == pytest.approx(critical, rel=1e-8)
    assert fr.friction.critical_kick(1.0, 0.3, largest=0.1).smallest_found == math.inf
    assert fr.friction.critical_kick(0.5, -0.7).smallest_found == math.inf  # nothing grows without friction
    high = fr.friction.certain_kicks(fr.FrictionalMathieu(1.3817, 0.6107, 1.0)).escapes_above  # needs no run
    assert fr.friction.critical_kick(1.3817, 0.6107, samples=3, max_steps=5).smallest_found == high
    with pytest.raises(ValueError, match="largest must be greater than zero"):
        fr.friction.critical_kick(1.0, 0.3, largest=0.0)


@pytest.mark.parametrize(
    ("alpha", "beta", "kick", "status", "reason"),
    [
        (1.5668, -0.4321, 1.242, "bounded", "comes to rest, and never moves farther out again"),
        (-0.8761, 0.0769, 1.8419, "bounded", "sticks and slips"),
        # Freed by a force hardly larger than friction: outwards little by little, and in the end ...
        (1.56, 0.14, 0.8823, "bounded", "sticks and slips"),
        (1.83, 0.33, 0.7964, "escapes", "outgrown"),
        (0.95, 0.18, 1.1482, "bounded", "sticks for all time"),
    ],
)
def test_every_way_to_end(alpha: float, beta: float, kick: float, status: str, reason: str) -> None:
    fate = fr.friction.fate(fr.FrictionalMathieu(alpha, beta, 1.0), kick)
    assert fate.status == status
    assert reason in fate.reason


def test_many_kicks_of_one_equation_share_its_table() -> None:
    alpha, beta, kicks = [1.0, 1.0, 1.0, 0.5], [0.3, 0.3, 0.3, -0.7], [0.5, 2.0, -2.0, 2.0]
    assert fr.friction.fates(alpha, beta, 1.0, kicks).tolist() == [BOUNDED, ESCAPES, ESCAPES, BOUNDED]


def test_ranges_of_kicks_that_escape() -> None:
    equation = fr.FrictionalMathieu(0.0, 0.25, 1.0)
    assert fr.friction.escape_ranges(equation).intervals == ((pytest.approx(2.0), math.inf),)
    nothing = fr.friction.escape_ranges(fr.FrictionalMathieu(0.5, -0.7, 1.0))
    assert nothing.intervals == ()
    assert "no kick escapes" in repr(nothing)
