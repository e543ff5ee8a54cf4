"""One status, one strict answer: every door that gives truth values says the same, and counts what it does not know."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.floquet.status import STATUS_CODES, are
from tests.conftest import depth
from tests.strategies import Point, dampings, mathieu_points

ROD = fr.Rod.nitinol()
FRACTAL = 1.3817153980732138, 0.6107295815800908, 1.0
RESONANCE = 0.5 * math.pi * ROD.wave_speed / ROD.length


def as_systems(alpha: Any, beta: Any, damping: float) -> fr.HillSystem:
    """Return Mathieu's equation, one or many, as a system of one equation; its damping matrix is twice the rate."""
    alpha, beta = (np.asarray(part)[..., None, None] for part in np.broadcast_arrays(alpha, beta))
    return fr.HillSystem(-beta, sines=[-alpha], period=2.0 * math.pi, damping=[[2.0 * damping]])


@settings(max_examples=depth(100, 15), deadline=None)
@given(st.lists(mathieu_points(30.0, (-30.0, 10.0)), min_size=1, max_size=4), dampings())
def test_every_door_says_the_same_of_an_equation(points: list[Point], damping: float) -> None:
    each = [fr.stability(fr.Mathieu(*point, damping)) for point in points]
    alpha, beta = np.array(points).T
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fr.UndecidedWarning)
        doors = {
            "mathieu.is_stable": fr.mathieu.is_stable(alpha, beta, damping),
            "systems.is_stable": fr.systems.is_stable(as_systems(alpha, beta, damping)),
            "friction.escapes": np.logical_not(fr.friction.escapes(alpha, beta, 0.0, 1.0, damping=damping)),
        }
    for door, found in doors.items():
        assert found.dtype == np.bool_, door
        assert found.shape == (len(points),), door
        wrong = [one for one, said in zip(each, found, strict=True) if one.stable is not None and one.stable != said]
        assert not [one for one in wrong if abs(one.discriminant) > 2.0 + 1e-9 or one.stable], (door, wrong)


@settings(max_examples=depth(60, 8), deadline=None)
@given(st.lists(st.floats(0.0, 2.0), min_size=1, max_size=3), st.floats(0.0, 1.0), st.floats(40.0, 300.0))
def test_a_rod_is_stable_where_all_its_equations_are(means: list[float], amplitude: float, frequency: float) -> None:
    loads = [fr.AxialLoad(mean, amplitude, frequency) for mean in means]
    equations = [ROD.modal_system(load).equations for load in loads]
    expected = [all(fr.mathieu.is_stable(e.alpha, e.beta, e.damping) for e in each) for each in equations]
    assert ROD.is_stable(mean=means, amplitude=amplitude, frequency=frequency).tolist() == expected
    assert (
        ROD.verdicts(mean=means, amplitude=amplitude, frequency=frequency) == STATUS_CODES["stable"]
    ).tolist() == expected


DOORS: dict[str, tuple[Callable[[Any], Any], tuple[Any, Any]]] = {
    "Rod.is_stable": (
        lambda frequency: ROD.is_stable(fr.AxialWave(0.0, 0.0, 1.0), mean=0.0, amplitude=1e-3, frequency=frequency),
        (0.5 * RESONANCE, RESONANCE),
    ),
    "systems.is_stable": (
        lambda shear: fr.systems.is_stable(
            fr.HillSystem(
                1.3 * np.eye(2) + np.multiply.outer(shear, [[0.0, 1.0], [0.0, 0.0]]),
                [[[0.2, 0.0], [0.0, 0.2]]],
                period=2.0,
            )
        ),
        (0.0, 0.3),
    ),
    "friction.escapes": (
        lambda kick: fr.friction.escapes(*FRACTAL, kick, max_steps=10),
        (0.1, 1.03),
    ),
}


@pytest.mark.parametrize("door", DOORS)
def test_undecided_is_false_and_counted(door: str) -> None:
    ask, (known, unknown) = DOORS[door]
    with pytest.warns(
        fr.UndecidedWarning, match=r"^2 of 3 .* could not be decided and count as not .*; .* (shows|says) "
    ) as heard:
        three = ask(np.array([known, unknown, unknown]))
    assert len(heard) == 1
    assert heard[0].filename == __file__
    assert three[1:].tolist() == [False, False]
    assert three.dtype == np.bool_
    if door != "Rod.is_stable":  # one load that a rod cannot be judged under is refused, by name
        with pytest.warns(fr.UndecidedWarning, match="^1 of 1 "):
            assert ask(unknown) is False


@pytest.mark.parametrize("status", ["stable", "unstable"])
def test_codes_become_truth_values_of_their_shape(status: Any) -> None:
    codes = np.array([[1, 0, 1], [0, 0, 1]], dtype=np.int8)
    assert are(status, codes, "", "").tolist() == (codes == STATUS_CODES[status]).tolist()
    assert are(status, STATUS_CODES[status], "", "") is True


def test_there_is_one_warning_and_one_set_of_codes() -> None:
    assert fr.friction.UndecidedWarning is fr.UndecidedWarning
    assert (fr.friction.BOUNDED, fr.friction.ESCAPES, fr.friction.UNDECIDED) == (1, 0, -1)
    assert STATUS_CODES == {"stable": 1, "unstable": 0, "undecided": -1}
