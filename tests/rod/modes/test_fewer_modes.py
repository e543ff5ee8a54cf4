"""The growth of fewer modes, followed from the fastest solution of all, against verdicts on the fewer."""

from __future__ import annotations

import math

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.floquet.methods.system_monodromy import monodromy
from floquetrod.rod.modes import coupled_verdict
from floquetrod.rod.modes.fewer_modes import Fastest
from tests.coupled_cases import TUBING
from tests.inside import Loads, half_period, solved_many, solved_pairs
from tests.seams import Heard, Tuned

STRING = TUBING.replace(length=100.0, damping_rate=0.3, ends="hinged")
UNIT = STRING.critical_force
LOAD = fr.AxialWave.hertz(0.4 * UNIT, 0.3 * UNIT, 4.0, axial_damping=0.5)
COUNT, FEWER = 44, 36


@pytest.fixture(autouse=True)
def _few_are_many(tuned: Tuned) -> None:
    tuned(equations_of_many=20, modes_of_a_long_rod=20, modes_judged_together=20, modes_worth_following=1.0)


@pytest.fixture(scope="module")
def many() -> fr.HillSystem:
    return STRING._modes_under(LOAD).in_modes(COUNT).system(Loads.single(LOAD))


def test_the_growth_of_fewer_modes_is_that_of_their_own_verdict(many: fr.HillSystem) -> None:
    solved, freed = solved_many(many), many.undamped
    assert solved is not None
    assert freed is not None
    fastest = Fastest.of(solved, freed)
    assert fastest is not None
    assert fastest.rate_with(COUNT) == pytest.approx(solved.verdict.growth_rate, abs=1e-10)
    fewer = STRING._modes_under(LOAD).in_modes(FEWER).system(Loads.single(LOAD))
    assert np.abs(fewer.stiffness - many.stiffness[:FEWER, :FEWER]).max() < 1e-9 * np.abs(fewer.stiffness).max()
    expected = monodromy(fewer)
    found = fastest.rate_with(FEWER)
    assert found == pytest.approx(expected.growth_rate, abs=1e-8)
    assert fastest.rate_with(8) is None  # its modes are not among them


def test_nothing_is_followed_where_nothing_is_certain_to_grow(many: fr.HillSystem) -> None:
    still = fr.HillSystem(many.stiffness, [1e-9 * many.cosines[0]], [1e-9 * many.sines[0]], period=many.period)
    solved, freed = solved_many(still), still.undamped
    assert solved is not None
    assert freed is not None
    assert Fastest.of(solved, freed) is None
    few = fr.HillSystem(many.stiffness[:5, :5], [many.cosines[0][:5, :5]], period=many.period)
    assert solved_many(few) is None


def test_long_rods_are_judged_once_and_followed_once(monkeypatch: pytest.MonkeyPatch, heard: Heard) -> None:
    asked = heard(coupled_verdict._Trial, "of")
    found = STRING.stability(LOAD)
    (fewer, first), (count, last) = found.convergence
    assert [modes.count for modes, *_ in asked] == [count]
    assert fewer < count
    assert first == pytest.approx(last, abs=found.error)
    assert found.status == "unstable"
    monkeypatch.setattr(coupled_verdict._Trial, "with_fewer", lambda self, modes: None)
    asked.clear()
    whole = STRING.stability(LOAD)
    assert [modes.count for modes, *_ in asked] == [count, fewer]
    assert whole.growth_rate == found.growth_rate
    assert whole.convergence[0][1] == pytest.approx(first, abs=1e-9)


def test_the_growth_of_fewer_modes_of_an_even_system_is_that_of_their_own_verdict() -> None:
    load = fr.AxialWave.hertz(0.4 * UNIT, 0.3 * UNIT, 4.0)
    many = STRING._modes_under(load).in_modes(COUNT).system(Loads.single(load))
    freed = many.undamped
    assert freed is not None
    assert freed[0].is_even
    solved = solved_pairs(many)
    fastest = Fastest.of(solved, freed)
    assert fastest is not None
    assert fastest.rate_with(COUNT) == pytest.approx(solved.verdict.growth_rate, abs=1e-9)
    fewer = STRING._modes_under(load).in_modes(FEWER).system(Loads.single(load))
    assert fastest.rate_with(FEWER) == pytest.approx(half_period(fewer).growth_rate, abs=1e-7)
    assert fastest.rate_with(8) is None  # its modes are not among them


@pytest.mark.parametrize("start", [0.0, 0.3])
@pytest.mark.parametrize(("epsilon", "complex_pair"), [(0.3, False), (0.6, True)])
def test_the_fastest_solution_is_one_of_the_map(start: float, epsilon: float, complex_pair: bool) -> None:
    """From the instant of evenness on, growing by a real or a complex multiplier (a combination of two modes)."""
    mean = np.array([[1.0, 0.2, 0.0], [0.2, 4.1, 0.3], [0.0, 0.3, 9.3]])
    coupled = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.5], [0.0, 0.5, 0.0]]) if complex_pair else np.eye(3)
    omega = 3.0 if complex_pair else 2.0
    system = fr.HillSystem(
        mean,
        [epsilon * math.cos(omega * start) * coupled],
        [epsilon * math.sin(omega * start) * coupled],
        period=2.0 * math.pi / omega,
    )
    form = system.even_form
    assert form is not None
    found = solved_pairs(system).fastest()
    assert found is not None
    mu, error, state, partner = found
    assert abs(mu) > 1.05
    assert (abs(mu.imag) > 1e-3) is complex_pair
    assert error < 1e-9
    shifted = fr.HillSystem(mean, list(form.amplitudes), period=system.period)
    whole = fr.stability(shifted).monodromy.matrix
    assert np.abs(whole @ state - mu * state).max() < 1e-9 * np.abs(state).max() * abs(mu)
    assert np.abs(whole @ partner - partner / np.conj(mu)).max() < 1e-9 * np.abs(partner).max()
