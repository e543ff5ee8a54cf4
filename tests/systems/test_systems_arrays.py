"""Batches of systems give what each system alone gives, in any shape and on any number of threads."""

from __future__ import annotations

import importlib
import math
import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.equations.batches import in_batches, pick
from floquetrod.floquet.status import STABLE
from floquetrod.systems import batch_verdicts
from tests.conftest import depth
from tests.seams import Heard
from tests.strategies import systems

OMEGA, EPSILON = np.linspace(0.6, 5.0, 23), np.linspace(0.0, 0.8, 9)


def coupled(damping: Any = None, mass: Any = None) -> fr.HillSystem:
    """Two coupled Mathieu equations over frequency and forcing."""
    forcing = EPSILON[:, None, None, None] * np.array([[0.5, 1.0], [1.0, 0.8]])
    return fr.HillSystem(np.diag([1.0, 4.0]), [forcing], damping=damping, mass=mass, period=2.0 * math.pi / OMEGA)


def check(batch: fr.HillSystem | fr.PeriodicSystem, every: int = 1) -> None:
    """Assert that status, growth and multipliers are those of the systems one by one."""
    found = batch_verdicts.verdicts(batch)
    multipliers = fr.systems.multipliers(batch).reshape(found.status.size, -1)
    for i in range(0, found.status.size, every):
        alone = fr.stability(pick(batch, i))
        assert {"stable": 1, "unstable": 0, "undecided": -1}[alone.status] == found.status[i], (alone, i)
        assert found.growth[i] == pytest.approx(alone.growth_rate, rel=1e-7, abs=1e-9)
        sizes = np.sort(np.abs(alone.multipliers))[::-1]
        slack = max(alone.multiplier_errors) + 1e-6 * (1.0 + sizes[0])
        assert np.abs(np.abs(multipliers[i]) - sizes).max() <= slack, (alone, multipliers[i])


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"damping": 0.02 * np.eye(2)},
        {"damping": np.diag([0.004, 0.4])},
        {"mass": [[2.0, 0.3], [0.3, 1.0]]},
    ],
    ids=["undamped", "uniform", "unequal", "mass"],
)
def test_a_chart_is_its_points(options: dict[str, Any]) -> None:
    batch = coupled(**options)
    assert batch.shape == (9, 23)
    check(batch, every=7)
    stable = fr.systems.is_stable(batch)
    assert stable.shape == (9, 23)
    assert stable.dtype == bool
    assert 0.3 < stable.mean() < 1.0
    growth = fr.systems.growth_rate(batch)
    assert (growth[stable] == 0.0).all()
    assert (growth[~stable] > 0.0).all()


def test_the_truth_of_the_literature() -> None:
    forcing = 0.2 * np.array([[0.5, 1.0], [1.0, 0.8]])
    batch = fr.HillSystem(np.diag([1.0, 4.0]), [forcing], period=2.0 * math.pi / np.array([3.0, 2.95, 2.0, 1.0]))
    truth = [0.03532777753665963, 0.02512182920908255, 0.02496431619264695, 0.0]
    assert fr.systems.growth_rate(batch) == pytest.approx(truth, abs=1e-11)
    assert fr.systems.is_stable(batch).tolist() == [False, False, False, True]


@settings(max_examples=depth(20, 5), deadline=None)
@given(st.lists(systems(), min_size=1, max_size=6))
def test_systems_of_every_kind_in_batches(members: list[fr.HillSystem | fr.PeriodicSystem]) -> None:
    answers = in_batches(members, batch_verdicts.verdicts)
    for member, (status, growth) in zip(members, answers, strict=True):
        alone = fr.stability(member)
        assert {"stable": 1, "unstable": 0, "undecided": -1}[alone.status] == status
        assert growth == pytest.approx(alone.growth_rate, rel=1e-6, abs=1e-8)


def test_a_single_system_gives_python_numbers() -> None:
    system = pick(coupled(), 100)
    assert type(fr.systems.is_stable(system)) is bool
    assert type(fr.systems.growth_rate(system)) is float
    assert fr.systems.multipliers(system).shape == (4,)


def test_threads_change_nothing() -> None:
    one, two = (batch_verdicts.verdicts(coupled(), workers=workers) for workers in (1, 2))
    assert np.array_equal(one.status, two.status)
    assert np.array_equal(one.growth, two.growth)


def test_larger_systems_of_every_path() -> None:
    rng = np.random.default_rng(3)
    for n in (3, 5, 24):
        part = rng.normal(size=(4, n, n))
        forcing = 0.2 * (part + np.swapaxes(part, -1, -2)) / math.sqrt(n)
        stiffness = np.diag(rng.uniform(0.3, 4.0, n))
        check(fr.HillSystem(stiffness, [forcing], period=2.3))
        check(fr.HillSystem(stiffness, [0.3 * part / math.sqrt(n)], period=2.3))  # follower loads
        check(fr.HillSystem(stiffness, [forcing], [0.1 * forcing], period=2.3, damping=np.diag(rng.uniform(0, 0.1, n))))
        skew = part - np.swapaxes(part, -1, -2)
        check(fr.HillSystem(stiffness, [forcing], period=2.3, gyroscopic=0.3 * skew))


def test_what_the_quick_rules_leave_open_is_judged_alone(heard: Heard) -> None:
    same = fr.HillSystem(np.eye(2), [np.array([0.1, 0.2])[:, None, None] * np.eye(2)], period=2.0)
    asked = heard(batch_verdicts, "judge")
    found = batch_verdicts.verdicts(same)
    assert found.status.tolist() == [STABLE, STABLE]  # two pairs of equal multipliers, of one Krein sign
    assert len(asked) == 2


@pytest.mark.slow
@pytest.mark.parametrize(
    "system",
    [
        fr.HillSystem([[1.3, 0.3], [0.0, 1.3]], [[[0.2, 0.1], [0.0, 0.2]]], period=2.0),
        fr.PeriodicSystem([[0.0, 0.3], [0.0, 0.0]], [[[1.0, 0.5], [0.0, 0.7]]], period=2.0),
        pytest.param(
            fr.PeriodicSystem([[0.0, 0.7], [-0.7, 0.0]], [[[1.0, 0.5], [-0.5, 1.0]]], period=2.0),
            marks=pytest.mark.slow,
        ),
        pytest.param(
            fr.HillSystem([[1, -1], [-1, 1]], [[[0.1, -0.1], [-0.1, 0.1]]], damping=[[0.1, -0.1], [-0.1, 0.1]]),
            marks=pytest.mark.slow,
        ),
    ],
    ids=["triangular", "triangular of first order", "commuting", "damped with drift"],
)
def test_what_no_digits_decide_costs_arrays_no_more_than_sixty(
    system: fr.HillSystem | fr.PeriodicSystem, heard: Heard
) -> None:
    attempts = heard(importlib.import_module("floquetrod.floquet.methods.system_reference"), "_attempt")
    with pytest.warns(fr.UndecidedWarning, match="1 of 1 systems .* count as not stable"):
        assert fr.systems.is_stable(system) is False
    assert [digits for _, _, digits, _ in attempts] == [30, 60]
    result = fr.stability(system)
    assert [digits for _, _, digits, _ in attempts] == [30, 60, 30, 60, 120]
    assert result.status == "undecided"
    assert result.note.endswith("computed to 120 digits")


def test_what_is_no_system_is_refused() -> None:
    with pytest.raises(TypeError, match="systems must be a HillSystem or PeriodicSystem"):
        fr.systems.is_stable([[1.0]])
    with pytest.raises(ValueError, match="workers"):
        fr.systems.is_stable(coupled(), workers=0)
    with pytest.raises(ValueError, match="got a batch of shape"):
        fr.stability(coupled())


def test_one_that_takes_too_long_spoils_no_other() -> None:
    batch = fr.HillSystem(np.array([1.0, 1e20])[:, None, None] * np.eye(2), [0.1 * np.eye(2)], period=2.0)
    with pytest.warns(fr.UndecidedWarning, match="1 of 2"):
        assert fr.systems.is_stable(batch).tolist() == [True, False]
    assert np.isnan(fr.systems.growth_rate(batch)).tolist() == [False, True]
    assert np.isnan(fr.systems.multipliers(batch)).any(axis=1).tolist() == [False, True]
    result = fr.stability(pick(batch, 1))
    assert result.status == "undecided"
    assert "would take" in fr.stability(pick(batch, 1), method="half_period").note


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::floquetrod.UndecidedWarning")
def test_progress_counts_to_the_end_and_may_end_the_work() -> None:
    # The first and the last are decided by the quick rules; two equal oscillators coupled one way are judged alone.
    stiffness = np.array([np.diag([1.0, 4.0]), 1.3 * np.eye(2), 1.3 * np.eye(2), np.diag([1.0, 4.0])])
    waves = np.array([[[0.1, 0.15], [0.0, 0.1]]] * 4)
    several = fr.HillSystem(stiffness, [waves], period=2.5)
    for ask in (fr.systems.is_stable, fr.systems.growth_rate, fr.systems.multipliers):
        seen: list[tuple[int, int]] = []
        alone, told = ask(several), ask(several, progress=lambda *counts, seen=seen: seen.append(counts))
        np.testing.assert_array_equal(alone, told)
        assert seen[-1] == (4, 4)
        assert sorted(seen) == seen

    asked = []

    def enough(done: int, total: int) -> None:
        asked.append(done)
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fr.systems.is_stable(several, progress=enough)
    assert asked == [2, 3]


def test_a_system_picked_is_the_one_that_would_be_made_alone(rng: np.random.Generator) -> None:
    """Matrices that are the identity or zero in one system are none there, although others of the batch have them."""
    third, second = (np.arange(6)[:, None, None] % k > 0 for k in (3, 2))
    mass, damping = np.where(third, 1.0, 2.0) * np.eye(2), np.where(second, 0.1 * np.eye(2), 0.0)
    force, period = rng.normal(size=(6, 2, 2)), np.linspace(1.0, 2.0, 6)
    batch = fr.HillSystem(np.diag([1.0, 4.0]), [force], mass=mass, damping=damping, period=period)
    for i in range(6):
        alone = fr.HillSystem(
            np.diag([1.0, 4.0]), [force[i]], mass=mass[i], damping=damping[i], period=float(period[i])
        )
        found = pick(batch, i)
        assert found == alone
        assert (found.structure, found.shape) == (alone.structure, ())
        assert not found.cosines[0].flags.writeable


def test_one_system_answers_again_as_in_a_batch_and_a_copy_answers_alike() -> None:
    coupling = 0.2 * np.array([[0.5, 1.0], [1.0, 0.8]])
    single = fr.HillSystem(np.diag([1.0, 4.0]), [coupling], damping=0.02 * np.eye(2), period=2.0 * np.pi / 3.0)
    first, again = fr.systems.multipliers(single), fr.systems.multipliers(single)
    copied = fr.systems.multipliers(pickle.loads(pickle.dumps(single)))
    together = fr.systems.multipliers(fr.systems.stack([single, single]))
    assert all(np.array_equal(first, other) for other in (again, copied, *together))
