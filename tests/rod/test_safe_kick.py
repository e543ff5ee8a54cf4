"""Kicks that lead to a large motion of a rod that is stable at rest, held to orbits and to the simulator."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.rod import kicked_motion
from tests.inside import Orbit

ROD = fr.Rod.nitinol().replace(damping_rate=3.0)
CRITICAL = ROD.critical_force
ABOVE_A_TONGUE = fr.AxialLoad(0.2 * CRITICAL, 0.15 * CRITICAL, 156.0)


def test_where_nothing_large_is_found_it_says_what_was_searched() -> None:
    found = ROD.replace(length=1.2).safe_kick(fr.AxialLoad(0.1, 0.01, 40.0))
    assert math.isinf(found.safe_up_to)
    assert math.isinf(found.escapes_at)
    assert found.as_dict()["escapes_at_m_per_s"] is None
    assert repr(found) == "<no large motion of one mode found up to 40 degrees>"
    assert "nothing is proved" in str(found)
    assert found.tried == found.safe_mode == 0


def test_the_two_sides_may_be_of_different_modes(monkeypatch: pytest.MonkeyPatch) -> None:
    def scanned(equation: Any, large: Any) -> Any:
        mode = equation.motion.shapes.numbers[0]
        return kicked_motion._Scan(5.0, math.inf, 0.0) if mode == 6 else kicked_motion._Scan(9.0, 10.0, 1.0)

    monkeypatch.setattr(kicked_motion, "_scanned", scanned)
    monkeypatch.setattr(
        kicked_motion, "orbits_alone", lambda equation: _stable(equation) if _is(equation, 6, 7) else []
    )
    found = ROD.safe_kick(ABOVE_A_TONGUE)
    assert (found.safe_mode, found.mode) == (6, 7)
    assert found.safe_up_to < found.escapes_at
    assert repr(found).startswith("<kicks of mode 6 up to ")
    assert " mm/s of mode 7 leads to " in repr(found)
    monkeypatch.setattr(kicked_motion, "orbits_alone", lambda equation: _stable(equation) if _is(equation, 6) else [])
    found = ROD.safe_kick(ABOVE_A_TONGUE)
    assert (found.safe_mode, found.mode) == (6, 0)
    assert math.isfinite(found.safe_up_to)
    assert repr(found).endswith("came to rest; none was found that does not>")


def _is(equation: Any, *modes: int) -> bool:
    return bool(equation.motion.shapes.numbers[0] in modes)


def _stable(equation: Any) -> list[Orbit]:
    return [Orbit(2, np.zeros((4, 2)), 0.4, np.array([0.5, 0.5]))]


@pytest.mark.slow
def test_a_load_above_a_tongue_is_stable_and_not_safe_against_every_kick() -> None:
    found = ROD.safe_kick(ABOVE_A_TONGUE)
    assert ROD.stability(ABOVE_A_TONGUE).status == "stable"
    assert 0.08 < found.safe_up_to < found.escapes_at < 0.11
    assert found.escapes_at - found.safe_up_to < 0.01 * found.escapes_at
    assert (found.mode, found.large) == (7, pytest.approx(0.443, abs=0.005))
    assert "mode 7" in repr(found)


@pytest.mark.parametrize(
    ("rod", "load", "words"),
    [
        (ROD.replace(damping_rate=0.0), ABOVE_A_TONGUE, "damping_rate"),
        (ROD, fr.AxialLoad(0.2 * CRITICAL, 0.25 * CRITICAL, 140.0), "stable at rest"),
    ],
)
def test_rods_that_never_come_to_rest_are_refused(rod: fr.Rod, load: fr.AxialLoad, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        rod.safe_kick(load)


@pytest.mark.slow
def test_the_simulator_rests_after_less_and_moves_on_after_more() -> None:
    found = ROD.safe_kick(ABOVE_A_TONGUE)
    for factor, moves in ((0.85, False), (1.2, True)):
        kick = fr.Perturbation.modes({found.mode: factor * found.escapes_at})
        run = fr.simulate(ROD, ABOVE_A_TONGUE, duration=2.0, segments=140, frames=400, perturbation=kick)
        assert (run.largest_angle[-30:].max() > 0.5 * found.large) == moves
