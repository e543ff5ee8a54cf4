"""Systems whose maps are nearly singular, overflow or have multipliers of hundreds of decades: no crash, no warning."""

from __future__ import annotations

import contextlib
import itertools
import math
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod._util.arrays import inverses, norms
from floquetrod.equations.matrices import mirrored
from floquetrod.floquet.kernels.system_even_pairs import pair_values
from floquetrod.floquet.methods.system_reference import reference
from floquetrod.floquet.multiplier_pairs import slopes
from floquetrod.floquet.multipliers import half_period_maps
from floquetrod.floquet.multipliers.spectra import touching
from floquetrod.systems import batch_verdicts
from tests.conftest import depth, some

System = fr.HillSystem | fr.PeriodicSystem
STATUS = {"stable": 1, "unstable": 0, "undecided": -1}


def ask_everything(system: System) -> Any:
    """Return the verdict, which that over arrays equals; multipliers, where squares are doubles, have its growth."""
    result = fr.stability(system)
    found = batch_verdicts.verdicts(system)
    assert found.status.tolist() == [STATUS[result.status]]
    undecided = pytest.warns(fr.UndecidedWarning) if result.status == "undecided" else contextlib.nullcontext()
    with undecided:
        assert fr.systems.is_stable(system) == (result.status == "stable")
    multipliers = fr.systems.multipliers(system)
    if result.status == "unstable" and result.growth_rate * float(system.period) < 350.0:  # e^700: 1e304
        assert np.log(abs(multipliers[0])) / system.period == pytest.approx(result.growth_rate, rel=1e-6)
    return result


@pytest.mark.parametrize(
    ("coupling", "growth"),
    [
        ([[0.0, 1.0], [0.5, 0.0]], math.sqrt(1e4 + math.sqrt(0.5))),
        ([[0.0, 1.0], [1.0, 0.0]], math.sqrt(1e4 + 1.0)),
        ([[0.0, 1.0, 0.0], [0.5, 0.0, 1.0], [0.0, 1.0, 0.0]], math.sqrt(1e4 + math.sqrt(1.5))),
    ],
)
def test_strong_buckling_is_unstable(coupling: list[list[float]], growth: float) -> None:
    stiffness = -1e4 * np.eye(len(coupling)) - np.array(coupling)
    still = ask_everything(fr.HillSystem(stiffness))
    assert still.status == "unstable"
    assert still.growth_rate == pytest.approx(growth, rel=1e-9)
    moving = ask_everything(fr.HillSystem(stiffness, cosines=[np.eye(len(coupling))]))
    assert moving.status == "unstable"
    assert moving.growth_rate == pytest.approx(growth, rel=1e-6)
    many = fr.HillSystem(np.stack([stiffness, np.diag(np.arange(1.3, 1.0 + len(coupling)))]))
    assert fr.systems.is_stable(many).tolist() == [False, True]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("size", "equations"),
    [
        (1e6, 3),
        pytest.param(3e4, 21, marks=pytest.mark.slow),
        *(pytest.param(size, n, marks=pytest.mark.slow) for size in (1e6, 3e4) for n in (1, 2)),
        pytest.param(3e4, 3, marks=pytest.mark.slow),
    ],
)
def test_maps_beyond_doubles_are_decided_by_the_matrix_of_hill(size: float, equations: int) -> None:
    rng = np.random.default_rng(equations)
    coupling = rng.normal(size=(equations, equations))
    for part in (coupling, coupling + coupling.T):
        system = fr.HillSystem(part - size * np.eye(equations), cosines=[np.eye(equations)])
        found = fr.stability(system)
        assert (found.method, found.status) == ("spectral", "unstable")
        assert found.growth_rate == pytest.approx(math.sqrt(size - np.linalg.eigvals(part).real.min()), rel=1e-4)
        assert fr.systems.is_stable(system) is False
        assert np.isnan(fr.systems.multipliers(system)).all()


def random_system(rng: np.random.Generator, kind: int) -> System:
    """Return a system with stiffnesses of up to 1e5 of either sign, of one of eight structures."""
    n = int(rng.integers(1, 7))
    size, sign = 10.0 ** rng.uniform(0.0, 5.0), rng.choice([-1.0, 1.0])
    diagonal = sign * size * rng.choice([1.0, 1.0, 0.03], n) * (rng.choice([-1.0, 1.0], n) if rng.random() < 0.3 else 1)
    coupling = rng.normal(size=(n, n)) * 10.0 ** rng.uniform(-1.0, 1.0)
    stiffness = np.diag(diagonal) + coupling + coupling.T
    period = float(rng.choice([2.0 * math.pi, 10.0 ** rng.uniform(-1.0, 1.0)]))
    forcing = [rng.normal(size=(n, n)) * rng.choice([1.0, 0.3 * size]) for _ in range(int(rng.integers(0, 3)))]
    forcing = [np.eye(n)] if rng.random() < 0.3 else forcing
    even = [one + one.T for one in forcing]
    other = rng.normal(size=(n, n))
    positive = 0.5 * (other @ other.T + (other @ other.T).T) + np.eye(n)
    if kind == 0:
        return fr.HillSystem(stiffness, even, period=period)
    if kind == 1:
        return fr.HillSystem(np.diag(diagonal) + coupling, forcing, period=period)
    if kind == 2:
        return fr.HillSystem(np.diag(diagonal) + coupling, sines=forcing[:1], period=period)
    if kind == 3:
        damping = 2.0 ** float(rng.integers(-6, 5)) * positive
        return fr.HillSystem(stiffness, even, mass=positive, damping=damping, period=period)
    if kind == 4:
        gyroscopic = math.sqrt(size) * (other - other.T)
        return fr.HillSystem(stiffness, even, [one.T for one in even], gyroscopic=gyroscopic, period=period)
    if kind == 5:
        return fr.HillSystem(stiffness, even, damping=positive, period=period)
    if kind == 6:
        return fr.HillSystem(np.diag(diagonal) + coupling, forcing, damping=other, period=period)
    return fr.PeriodicSystem(0.1 * np.diag(diagonal) + coupling, forcing, period=period)


@pytest.mark.slow
@pytest.mark.parametrize("kind", range(8))
def test_stiffnesses_of_every_size(kind: int, rng: np.random.Generator) -> None:
    for _ in range(1 if kind in (3, 4, 5) else depth(3, 1)):
        ask_everything(random_system(rng, kind))


@pytest.mark.parametrize("n", [1, 3])
def test_what_decays_to_zero_within_a_period_is_stable(n: int) -> None:
    found = fr.stability(fr.PeriodicSystem(-2000.0 * np.eye(n), [np.eye(n)], period=1.0))
    assert (found.status, found.growth_rate) == ("stable", 0.0)


LARGEST_LOST = {(0, 0), (7, 1), (7, 2)}
"""Seeds and kinds of which `fr.systems.multipliers` of one system has no multiplier, where `fr.stability` has all."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "kind"),
    [
        pytest.param(*drawn, marks=[pytest.mark.xfail(raises=AssertionError, strict=True)] * (drawn in LARGEST_LOST))
        for drawn in some(itertools.product(range(10), range(8)), 20, 8)
    ],
)
def test_many_stiffnesses_of_every_size(seed: int, kind: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(4):
        system = random_system(rng, kind)
        result = ask_everything(system)
        if system.order <= 2:
            other = fr.stability(system, method="reference")
            assert {result.status, other.status} != {"stable", "unstable"}, (system, result, other)


@pytest.mark.slow
def test_a_map_whose_error_has_no_square_is_decided() -> None:
    rng = np.random.default_rng(1)
    systems = [random_system(rng, 3) for _ in range(4)]
    found = [ask_everything(system) for system in systems]
    assert [verdict.status for verdict in found] == ["stable", "unstable", "unstable", "unstable"]
    assert found[-1].growth_rate == pytest.approx(fr.stability(systems[-1], "reference").growth_rate, rel=1e-9)


@pytest.mark.parametrize("seed", range(depth(40, 8)))
def test_stiff_modes_do_not_spoil_the_growth_of_a_slow_one(seed: int) -> None:
    """One mode grows by many decades in a period while others, a thousand times as fast, swing: in any coordinates.

    The slow mode is apart, so that the growth is that of Mathieu's equation.
    """
    rng = np.random.default_rng([21, seed])
    n = int(rng.integers(2, 6))
    alpha, beta = float(rng.uniform(600.0, 1500.0)), float(rng.uniform(-100.0, 0.0))
    stiff = np.sort(10.0 ** rng.uniform(5.0, 8.0, n - 1))
    turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
    mean, wave = np.diag([-beta, *stiff]), np.zeros((n, n))
    wave[1:, 1:] = mirrored(rng.uniform(-0.1, 0.1, (n - 1, n - 1))) * np.sqrt(
        np.outer(stiff, stiff)
    )  # too slow to resonate
    wave[0, 0] = -alpha
    mean, wave = (mirrored(turn @ matrix @ turn.T) for matrix in (mean, wave))
    phase = float(rng.uniform(0.1, 3.0))  # the instant of evenness is then known to rounding
    system = fr.HillSystem(mean, [math.cos(phase) * wave], [math.sin(phase) * wave], period=2.0 * math.pi)
    growth = fr.stability(fr.Mathieu(alpha, beta)).growth_rate
    assert growth * 2.0 * math.pi > 40.0
    found = fr.stability(system)
    assert found.status == "unstable", found
    error = found.exponent_errors[0]
    assert error < 1e-4 * growth
    assert abs(found.growth_rate - growth) <= error + 1e-9 * growth
    over = batch_verdicts.verdicts(system)
    assert over.status.tolist() == [0]
    assert over.growth[0] == pytest.approx(growth, rel=1e-6)


# --- parts -----------------------------------------------------------------------------------------------------------


def test_a_singular_matrix_spoils_no_other_inverse() -> None:
    good = np.array([[2.0, 1.0], [1.0, 1.0]])
    stack = np.array([good, np.ones((2, 2)), np.full((2, 2), np.inf), np.eye(2)])
    found = inverses(stack)
    assert np.array_equal(found[0], np.linalg.inv(good))
    assert np.array_equal(found[3], np.eye(2))
    assert np.isnan(found[1:3]).all()
    assert np.isnan(inverses(np.zeros((1, 2, 2), dtype=complex))).all()
    assert norms(np.array([good, np.full((2, 2), 1e200)])).tolist() == [math.sqrt(7.0), math.inf]


def test_the_map_of_the_other_half_is_the_inverse(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(3)
    arguments = (
        rng.normal(size=(4, 3, 3)) + 2.0 * np.eye(3),
        rng.normal(size=(4, 2, 3, 3)),
        np.full(4, 2.0),
        np.zeros(4),
    )
    inverted = half_period_maps.pair_matrices(*arguments, 1e-13)
    monkeypatch.setattr(half_period_maps, "inverses", lambda matrices: np.full_like(matrices, np.nan))
    integrated = half_period_maps.pair_matrices(*arguments, 1e-13)
    assert integrated.matrix == pytest.approx(inverted.matrix, rel=1e-9)
    gaps = norms(integrated.matrix - inverted.matrix)
    assert (gaps <= integrated.error + inverted.error).all()
    assert (integrated.error < 1e-8 * norms(integrated.matrix)).all()


def test_numbers_whose_squares_overflow() -> None:
    one, two = np.empty(8), np.empty(8)
    y, form = np.array([[3.0, 1.0], [0.5, 2.0]]), np.array([[1.0, 0.2], [0.2, 2.0]])
    pair_values(y.copy(), 1e-12, form, 1e-12, one)
    pair_values(np.ldexp(y, 900), math.ldexp(1e-12, 900), form, 1e-12, two)
    assert two[:4] == pytest.approx(np.ldexp(one[:4] - [2.0, 0.0, 2.0, 0.0], 900), rel=1e-14)
    assert two[4:6] == pytest.approx(np.ldexp(one[4:6], 900), rel=1e-3)
    assert two[6:].tolist() == one[6:].tolist()

    y = np.array([1e250, 2.0])
    errors = slopes(y, 1.0 + y, 1e-9 * y)
    assert errors == pytest.approx([2e-9, 2e-9 * 2.0 / math.sqrt(6.0)])


def test_discs_that_touch_by_others_between_them() -> None:
    centres = np.array([0.0, 5.0, 1.0, 2.0, 9.0])
    gaps = np.abs(centres[:, None] - centres[None, :])
    assert [list(part) for part in touching(gaps, np.full(5, 0.5))] == [[0, 2, 3], [1], [4]]
    assert [list(part) for part in touching(gaps, np.full(5, 0.1))] == [[0], [1], [2], [3], [4]]
    assert [list(part) for part in touching(gaps, np.full(5, np.inf))] == [[0, 1, 2, 3, 4]]


def test_many_digits_are_not_begun_for_hundreds_of_harmonics() -> None:
    rng = np.random.default_rng(4)
    harmonics = 0.01 * rng.standard_normal((400, 20, 20)) / np.arange(1.0, 401.0)[:, None, None] ** 2
    found = reference(fr.PeriodicSystem(rng.standard_normal((20, 20)), list(harmonics)))
    assert found.status == "undecided"
    assert found.cost.amount == 0
    assert "30 digits would take too long" in found.note
