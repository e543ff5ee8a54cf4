"""How far a string can be pushed: the closed form against the equation integrated, its limits, bad input."""

from __future__ import annotations

import copy
import math
import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

import floquetrod as fr
from floquetrod import cli
from floquetrod.rod.model.lock_up import LockUp
from tests.conftest import depth

PIPE = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=1000.0, fluid_inside=1000.0, fluid_outside=1000.0)
F_P = PIPE.critical_force


def slope(rod: fr.Rod, friction: float, force: float) -> float:
    """Return dF/dxi in N/m from the weight and the contact force of a helix."""
    pressed = rod.radial_clearance * force**2 / (4.0 * rod.flexural_rigidity) if force > 0.0 else 0.0
    contact = rod.weight_per_length * math.sin(rod.inclination) + pressed
    return friction * contact - rod.weight_per_length * math.cos(rod.inclination)


def integrated(rod: fr.Rod, friction: float, far_force: float, distance: float) -> float:
    """Return the force at a distance from the far end by integrating the equation along the string."""
    run = solve_ivp(
        lambda _, y: [slope(rod, friction, y[0] * F_P) / F_P],
        (0.0, distance),
        [far_force / F_P],
        rtol=1e-11,
        atol=1e-12,
        method="DOP853",
    )
    assert run.success
    return float(run.y[0, -1]) * F_P


def test_a_horizontal_string_locks_up_as_known() -> None:
    # F = F_p tan(mu w s / F_p + arctan(F_0 / F_p))
    found, w = PIPE.lock_up(0.3, 5000.0), PIPE.weight_per_length
    start = math.atan(5000.0 / F_P)
    assert found.length == pytest.approx((0.5 * math.pi - start) * F_P / (0.3 * w), rel=1e-14)
    distance = np.linspace(0.0, 0.99, 50) * found.length
    assert found.force(distance) == pytest.approx(F_P * np.tan(0.3 * w * distance / F_P + start), rel=1e-12)


strings = st.tuples(st.floats(0.02, 1.0), st.floats(-3.0, 4.0), st.floats(0.05, 0.5 * math.pi))


@settings(max_examples=depth(150, 20), deadline=None)
@given(strings, st.floats(0.01, 0.97))
@example((0.3, 0.0, 0.5 * math.pi), 0.5)
@example((0.3, 3.0, 1.0), 0.9)  # locks up although weight exceeds the friction of a straight string
@example((0.3, 0.5, 1.0), 0.9)
@example((0.3, -2.0, 0.4), 0.9)
def test_the_force_is_that_of_the_equation_integrated(string: tuple[float, float, float], share: float) -> None:
    friction, start, inclination = string
    rod = PIPE.replace(inclination=inclination)
    F0 = start * F_P
    balance = rod.weight_per_length * (math.cos(inclination) - friction * math.sin(inclination))
    near = abs(slope(rod, friction, F0)) / rod.weight_per_length
    assume(near > 1e-3)  # there a string hangs in the balance, and rounding decides
    found = rod.lock_up(friction, F0)
    distance = share * (found.length if math.isfinite(found.length) else 3000.0)
    expected = integrated(rod, friction, F0, distance)
    assert found.force(distance) == pytest.approx(expected, rel=1e-6, abs=1e-6 * F_P)
    assert (math.isinf(found.length)) == (slope(rod, friction, max(F0, 0.0)) <= 0.0 or (F0 < 0.0 < balance))


@settings(max_examples=depth(150, 20), deadline=None)
@given(strings, st.floats(0.0, 8.0))
def test_what_a_force_can_push(string: tuple[float, float, float], more: float) -> None:
    friction, start, inclination = string
    rod = PIPE.replace(inclination=inclination)
    F0, F1 = start * F_P, (start + more) * F_P
    found = rod.lock_up(friction, F0)
    if slope(rod, friction, F0) > 0.0 and math.isfinite(found.length):
        assume(slope(rod, friction, F0) > 1e-3 * rod.weight_per_length)
        corner = [0.0] if F0 < 0.0 < F1 else None
        expected = quad(lambda F: 1.0 / slope(rod, friction, F), F0, F1, points=corner, epsrel=1e-11)[0]
        assert found.pushed_length(F1) == pytest.approx(expected, rel=1e-6, abs=1e-6)
        assert found.pushed_length(F1) <= found.length
        assert found.pushed_length(F0 - 1.0) == 0.0
        if more > 0.01:
            assert found.force(found.pushed_length(F1)) == pytest.approx(F1, rel=1e-6, abs=1e-6 * F_P)
    elif slope(rod, friction, F0) < 0.0:
        assert math.isinf(found.pushed_length(F1))


def test_weight_carries_a_steep_string() -> None:
    steep = PIPE.replace(inclination=math.radians(40.0))
    found = steep.lock_up(0.3)
    assert math.isinf(found.length)
    assert found.force(1000.0) == pytest.approx(
        -1000.0 * PIPE.weight_per_length * (math.cos(2 * math.pi / 9) - 0.3 * math.sin(2 * math.pi / 9))
    )
    assert repr(found) == "<never locks up with friction 0.3>"
    pushed = steep.lock_up(0.3, 3.0 * steep.critical_force)
    assert math.isfinite(pushed.length)
    assert "N at that end>" in repr(pushed)


def test_a_balance_of_weight_and_friction() -> None:
    # Friction of a straight string carries its weight exactly: dF/dxi = mu w sin(inclination) F^2 / F_p^2.
    found = LockUp(0.25, 2.0, 4.0, 2.0, 0.5)
    assert found.length == pytest.approx(4.0**2 / (0.5 * 2.0))
    assert found.force(8.0) == pytest.approx(1.0 / (1.0 / 2.0 - 0.5 * 8.0 / 4.0**2))
    assert found.pushed_length(4.0) == pytest.approx(8.0)
    assert found.pushed_length(1.0) == 0.0
    loose = replace(found, far_force=0.0)
    assert (loose.length, loose.force(1e6), loose.pushed_length(0.0)) == (math.inf, 0.0, math.inf)


def test_without_friction_only_weight_counts() -> None:
    level = PIPE.lock_up(0.0, 100.0)
    assert math.isinf(level.length)
    assert level.force([0.0, 1e6]) == pytest.approx([100.0, 100.0], rel=1e-15)
    assert level.pushed_length([99.0, 100.0]).tolist() == [0.0, math.inf]
    inclined = PIPE.replace(inclination=1.0)
    down = inclined.weight_per_length * math.cos(1.0)
    assert inclined.lock_up(0.0, 100.0).force([0.0, 50.0]) == pytest.approx([100.0, 100.0 - 50.0 * down])


def test_lengths_are_continuous_where_weight_balances_friction() -> None:
    around = [math.atan(1.0 / 0.4) + d for d in (-1e-9, 0.0, 1e-9)]
    lengths = [PIPE.replace(inclination=angle).lock_up(0.4, 2.0 * F_P).length for angle in around]
    assert lengths == pytest.approx([lengths[1]] * 3, rel=1e-7)


def test_beyond_the_length_no_force_is_enough() -> None:
    found = PIPE.lock_up(0.3)
    forces = found.force([[0.0, found.length], [2.0 * found.length, 1e9]])
    assert forces.tolist() == [[0.0, math.inf], [math.inf, math.inf]]
    assert found.pushed_length(1e15) == pytest.approx(found.length, rel=1e-9)
    assert isinstance(found.force(1.0), float)


def test_results_say_what_they_take_for_granted() -> None:
    found = PIPE.lock_up(0.3)
    assert "helical critical force" in " ".join(found.assumptions)
    assert pickle.loads(pickle.dumps(found)) == copy.deepcopy(found) == found
    assert found == PIPE.replace(length=5.0).lock_up(0.3)


@pytest.mark.parametrize(
    ("friction", "far_force", "error", "message"),
    [
        (-0.1, 0.0, ValueError, "^friction must be zero or more"),
        ("0.3", 0.0, TypeError, "^friction must be a real number"),
        (math.inf, 0.0, ValueError, "^friction must be finite"),
        (0.3, math.nan, ValueError, "^far_force must be finite"),
        (0.3, 1e16, ValueError, "^far_force must lie between"),
        (0.3, None, TypeError, "^far_force must be a single real number"),
    ],
)
def test_bad_questions(friction: Any, far_force: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        PIPE.lock_up(friction, far_force)


def test_bad_distances_and_forces() -> None:
    found = PIPE.lock_up(0.3)
    with pytest.raises(ValueError, match=r"^distance must be finite and lie between 0 and"):
        found.force(-1.0)
    assert found.pushed_length("1kN") == found.pushed_length(1e3)
    with pytest.raises(ValueError, match=r"^force must"):
        found.pushed_length("1m")


def test_it_answers_in_the_units_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    tubing = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=1000.0)
    found = tubing.lock_up(0.3)
    text = str(found.report(20e3, length="ft", force="lbf"))
    assert text.startswith(f"locks up {found.length / 0.3048:.4g} ft from the far end")
    assert f"pushed    4496.18 lbf at the upper end pushes {found.pushed_length(20e3) / 0.3048:.4g} ft" in text
    line = ["lock-up", "--rod", "2.00x0.156", "--bore", "4.778in", "--friction", "0.3", "--push", "20kN"]
    assert cli.main([*line, "--length", "1000m", "--unit", "ft,lbf"]) == 0
    assert capsys.readouterr().out == f"{text}\n"
    assert cli.main([*line, "--length", "3000ft"]) == 0  # the units of the question
    assert " ft from the far end" in (answer := capsys.readouterr().out)
    assert "20 kN at the upper end" in answer
    assert cli.main([*line, "--length", "1000m", "--unit", "psi"]) == 2
    assert "--unit must name units such as ft,lbf, got 'psi'" in capsys.readouterr().err
