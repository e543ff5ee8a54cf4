"""One question asked in every way the package has: the answers agree just inside and outside every stated end."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.rod import StabilityInterval
from tests.conftest import depth
from tests.fuzz import consistency, rods
from tests.strategies import decades, numbers

pytestmark = pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning")
QUICK = settings(max_examples=2)
SLOW = settings(max_examples=depth(30, 10), suppress_health_check=[HealthCheck.too_slow])


@st.composite
def questions(draw: st.DrawFn) -> rods.Question:
    """Rods about as realistic as the reference rod, loads of the order of their own forces and frequencies."""
    radius = draw(decades(3e-4, 5e-3))
    rod = fr.Rod(
        draw(decades(1e9, 2.5e11)),
        draw(decades(900.0, 9000.0)),
        radius,
        1.0,
        radius * (1.0 + draw(decades(0.3, 10.0))),
        draw(numbers(1.0, 20.0)),
    )
    rod = rod.replace(length=draw(decades(1.5, 14.0)) / rod.critical_mode)
    if draw(st.booleans()):
        rod = fr.Rod.nitinol()
    unit, pendulum = rod.critical_force, rod.pendulum_frequency
    return rods.Question(
        rod.replace(damping_rate=pendulum * draw(st.just(0.0) | decades(1e-4, 1.0))),
        draw(numbers(-0.2, 1.2)) * unit,
        draw(decades(0.01, 1.2)) * unit,
        draw(decades(0.5, 6.0)) * pendulum,
        draw(st.just(0.0) | decades(1e-6, 0.1 * pendulum)),
    )


def check(question: rods.Question, parts: tuple[str, ...]) -> None:
    found = consistency.disagreements(question, np.random.default_rng(1), parts)
    assert not found, "\n".join(found)


@pytest.mark.slow
@QUICK
@given(questions())
def test_ranges_and_verdicts_agree(question: rods.Question) -> None:
    check(question, ("ranges",))


@QUICK
@given(questions())
def test_margins_and_verdicts_agree(question: rods.Question) -> None:
    check(question, ("margins",))


@QUICK
@given(questions())
def test_damping_that_stabilises_does(question: rods.Question) -> None:
    check(question, ("damping",))


@pytest.mark.slow
@settings(max_examples=1)
@given(questions())
def test_the_terminal_and_the_library_agree(question: rods.Question) -> None:
    check(question, ("terminal",))


@pytest.mark.slow
@SLOW
@given(questions())
def test_all_answers_agree(question: rods.Question) -> None:
    check(question, ("ranges", "margins", "damping"))


def test_the_clipped_search_would_be_found(monkeypatch: pytest.MonkeyPatch) -> None:
    # What a search that walks past the hump of a damped tongue answered: 97.65 to 107.85 rad/s called stable.
    rod = fr.Rod.nitinol().replace(damping_rate=12.0)
    unit = rod.critical_force
    question = rods.Question(rod, 0.6 * unit, 0.4 * unit, 96.0, 0.0)
    right = fr.Rod.ranges

    def clipped(self: fr.Rod, *arguments: object, **options: object) -> fr.results.StabilityIntervals:
        found = right(self, *arguments, **options)  # type: ignore[arg-type]  # passed on as they come
        return dataclasses.replace(found, intervals=(StabilityInterval(*found.bounds, None, None),))

    monkeypatch.setattr(fr.Rod, "ranges", clipped)
    found = consistency.disagreements(question, np.random.default_rng(1), ("ranges",))
    assert any("ranges says stable" in line for line in found)


def test_a_margin_that_is_too_large_would_be_found() -> None:
    rod = fr.Rod.nitinol()
    unit = rod.critical_force
    question = rods.Question(rod, 0.34 * unit, 0.2 * unit, 150.0, 0.01)
    margin = rod.stability(fr.AxialLoad(*question[1:4]), growth_tolerance=0.01).mean_force_margin.above
    ends = {
        factor: list(consistency.margin_lines(question, 0.01, True, "mean", question.mean, factor * margin))
        for factor in (0.99, 1.0, 1.01)
    }
    assert "stays the same beyond" in ends[0.99][0]
    assert ends[1.0] == []
    assert "changes before" in ends[1.01][0]
