"""The uniform damping that a system takes to grow no more."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.mathieu.tongue_intervals import damping_to_stabilise as exactly
from tests.conftest import depth
from tests.seams import Tuned

FORCING = 0.2 * np.array([[0.5, 1.0], [1.0, 0.8]])


def coupled(w: float, rates: tuple[float, float] = (0.0, 0.0), more: float = 0.0) -> fr.HillSystem:
    """Return the coupled Mathieu equations, each with a decay rate of its own and one that both have."""
    damping = 2.0 * (np.diag(rates) + more * np.eye(2))
    return fr.HillSystem(np.diag([1.0, 4.0]), [FORCING], damping=damping, period=2.0 * math.pi / w)


@pytest.mark.slow
def test_one_equation_needs_what_is_known_exactly(rng: np.random.Generator) -> None:
    kinds, many = set(), depth(20, 7)
    for beta in -np.concatenate([np.zeros(3), rng.uniform(0.0, 2.0, many), rng.uniform(0.0, 3.0, many) ** 2]):
        alpha = float(rng.uniform(0.0, 3.0))
        expected = float(exactly(np.array([alpha]), np.array([beta]))[0])
        result = fr.stability(fr.Mathieu(alpha, float(beta)).as_system())
        assert result.damping_to_stabilise == pytest.approx(expected, rel=1e-8, abs=1e-11), (alpha, beta)
        kinds.add((result.status, expected > 0.0))
    assert {("unstable", True), ("stable", False)} <= kinds


def test_a_stable_equation_that_damping_makes_unstable_needs_more() -> None:
    # Damping leads them from a gap between wide tongues into the next one.
    rng = np.random.default_rng(4)
    alpha, beta = rng.uniform(0.0, 6.0, 4000), -rng.uniform(0.0, 9.0, 4000)
    expected = exactly(alpha, beta)
    some = np.flatnonzero(fr.mathieu.is_stable(alpha, beta) & (expected > 0.0))
    assert len(some) == 5
    for i in some.tolist():
        result = fr.stability(fr.Mathieu(alpha[i], beta[i]).as_system())
        assert result.stable
        assert result.damping_to_stabilise == pytest.approx(expected[i], rel=1e-8)


@pytest.mark.parametrize(("w", "rates"), [(3.0, (0.0, 0.0)), (2.95, (0.0, 0.0)), (3.1, (0.002, 0.2))])
def test_coupled_equations_grow_below_and_decay_above(w: float, rates: tuple[float, float]) -> None:
    needed = fr.stability(coupled(w, rates)).damping_to_stabilise
    assert 0.0 < needed < math.inf
    assert fr.stability(coupled(w, rates, needed * (1.0 - 1e-8))).status == "unstable"
    scan = needed * np.concatenate([[1.0 + 1e-8], np.geomspace(1.001, 1000.0, 40)])
    assert {fr.stability(coupled(w, rates, more)).status for more in scan.tolist()} == {"stable"}


@pytest.mark.parametrize("period", [2.25, 2.5, 4.0])
def test_mass_damping_and_rotation_count(period: float) -> None:
    mass, damping = np.array([[2.0, 0.5], [0.5, 1.0]]), np.diag([0.01, 0.0])

    def at(more: float) -> fr.results.Stability:
        turning = [[0.0, 0.4], [-0.4, 0.0]]
        total = damping + 2.0 * more * mass
        stiffness, waves = np.diag([1.0, 3.0]), [4.0 * FORCING]
        return fr.stability(
            fr.HillSystem(stiffness, waves, mass=mass, gyroscopic=turning, damping=total, period=period)
        )

    needed = at(0.0).damping_to_stabilise
    statuses = [at(share * needed).status for share in (0.0, 1.0 - 1e-7, 1.0 + 1e-7, 10.0)]
    assert statuses == ["unstable", "unstable", "stable", "stable"]


def test_of_first_order_it_is_the_growth_rate() -> None:
    system = fr.PeriodicSystem([[0.1, 1.0], [-1.0, 0.1]], [[[0.0, 0.0], [0.3, 0.0]]], period=3.0)
    result = fr.stability(system)
    assert result.damping_to_stabilise == result.growth_rate > 0.0
    shifted = fr.PeriodicSystem(system.mean - 1.001 * result.growth_rate * np.eye(2), system.cosines, period=3.0)
    assert fr.stability(shifted).status == "stable"


@pytest.mark.slow
def test_none_is_needed_none_suffices_or_none_is_known(tuned: Tuned) -> None:
    assert fr.stability(coupled(3.1)).damping_to_stabilise == 0.0
    assert fr.stability(fr.HillSystem(np.diag([-1.0, 1.0]), [FORCING])).damping_to_stabilise == math.inf
    held = fr.stability(fr.Mathieu.from_aq(-0.1, 0.6))  # stable, as the forcing holds what the mean would let go
    assert held.stable
    assert held.damping_to_stabilise == math.inf
    assert fr.stability(fr.Mathieu.from_aq(-0.1, 0.6, damping=10.0)).status == "unstable"
    free = np.array([[1.0, -1.0], [-1.0, 1.0]])  # which no damping lets decay
    assert math.isnan(fr.stability(fr.HillSystem(free, [0.1 * free])).damping_to_stabilise)
    tuned(seconds_of_a_damping_search=0.0)
    assert math.isnan(fr.stability(coupled(3.0)).damping_to_stabilise)


@pytest.mark.parametrize("mass", [None, 2.0])
def test_the_report_gives_the_damping_that_is_there_and_the_sum(mass: float | None) -> None:
    unit, inertia = ("I", np.eye(2)) if mass is None else ("M", mass * np.eye(2))
    waves = inertia @ np.array([[[1.5, 0.8], [0.8, 1.2]]])

    def line(damping: Any) -> str:
        others = {} if mass is None else {"mass": inertia}
        system = fr.HillSystem(inertia @ np.diag([1.0, 4.0]), waves, damping=damping, period=math.pi, **others)
        return str(fr.stability(system).report(damping=True)).partition("\ndamping ")[2].partition("\n")[0]

    found = re.search(rf"stable with more damping than C \+ (\S+) {unit} = (\S+) {unit}, ", line(0.2 * inertia))
    assert found is not None
    assert float(found[2]) == pytest.approx(0.2 + float(found[1]), rel=1e-5)
    alone = re.search(rf"stable with more damping than C \+ (\S+) {unit}, ", line(None))
    assert alone is not None
    assert float(alone[1]) == pytest.approx(float(found[2]), rel=1e-4)  # what suffices in all is one number
    assert " = " not in line(np.diag([0.02, 0.04]))  # no multiple of the mass
