"""The fastest solutions of many equations, without the whole map, against the whole map."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.floquet.multipliers import fastest_solutions
from floquetrod.floquet.multipliers.fastest_solutions import FastSolutions, fast_solutions
from floquetrod.rod.modes import coupled_verdict
from tests.conftest import depth, some
from tests.coupled_cases import TUBING
from tests.inside import solved_many
from tests.seams import Tuned


def many(seed: int, damping: float, strongest: float = 0.3, n: int = 220) -> fr.HillSystem:
    """Return equations that the forcing couples to their neighbours, some much more strongly than others."""
    rng = np.random.default_rng(seed)
    squares = np.sort(rng.uniform(0.3, 0.9, n)) ** 2
    apart = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    place = np.exp(-(((np.arange(n) - rng.uniform(60.0, 160.0)) / 8.0) ** 2))
    size = (0.005 + strongest * np.sqrt(np.outer(place, place))) * np.exp(-apart / 2.0)
    cosine, sine = (size * (m + m.T) for m in rng.standard_normal((2, n, n)))
    return fr.HillSystem(np.diag(squares), [cosine], [sine], damping=2.0 * damping * np.eye(n), period=2.0 * math.pi)


def require_agreement(system: fr.HillSystem, fast: FastSolutions) -> None:
    """Check multipliers, growth and what is said of all others against the whole map."""
    found, whole = fast.verdict(system), solved_many(system)
    assert whole is not None
    expected = whole.verdict
    assert found.status == expected.status == "unstable"
    growth = np.array([exponent.real for exponent in expected.exponents])
    errors = np.array(expected.exponent_errors)
    assert abs(found.growth_rate - growth.max()) <= found.exponent_errors[0] + errors[growth.argmax()]
    damping = 0.0 if system.damping is None else 0.5 * float(system.damping[0, 0])
    rest = fast.rest / float(system.period) - damping
    grow = np.array([e.real for e in found.exponents])
    near = np.array(found.exponent_errors)
    for rate, error in zip(growth, errors, strict=True):
        assert rate <= rest + error or (np.abs(grow - rate) <= near + error).any()
    for rate, error in zip(grow[:-2], near[:-2], strict=True):
        assert rate <= rest or (np.abs(growth - rate) <= errors + error).any()


def beside(few: fr.HillSystem, n: int = 210) -> fr.HillSystem:
    """Return a system and many equations apart from it and stable, all in coordinates that mix them a little."""
    k = few.order
    rng = np.random.default_rng(3)
    turn = np.linalg.qr(np.eye(n) + 0.02 * np.tril(rng.standard_normal((n, n))))[0]
    stiffness = np.diag(np.linspace(0.3, 0.45, n) ** 2)
    cosine, sine = np.zeros((2, n, n))
    stiffness[:k, :k], cosine[:k, :k], sine[:k, :k] = few.stiffness, few.cosines[0], few.sines[0]
    stiffness, cosine, sine = (0.5 * (m + m.T) for m in (turn.T @ part @ turn for part in (stiffness, cosine, sine)))
    return fr.HillSystem(stiffness, [cosine], [sine], period=few.period)


@pytest.mark.slow
def test_the_fastest_of_a_few_is_found_among_many() -> None:
    rng = np.random.default_rng(2)
    cosine, sine = (0.15 * (m + m.T) for m in rng.standard_normal((2, 4, 4)))
    few = fr.HillSystem(np.diag([0.2, 0.25, 0.3, 0.35]), [cosine], [sine], period=2.0 * math.pi)
    fast = fast_solutions(beside(few), 0.0)
    assert fast is not None
    expected = fr.stability(few, method="monodromy")
    found = fast.verdict(beside(few))
    assert found.status == expected.status == "unstable"
    assert abs(found.growth_rate - expected.growth_rate) <= found.exponent_errors[0] + expected.exponent_errors[0]
    assert found.exponent_errors[0] < 1e-5
    multipliers = np.exp(np.array(expected.exponents) * few.period)  # their signs and angles too
    assert np.abs(multipliers / np.exp(found.exponents[0] * few.period) - 1.0).min() < 1e-4
    slower = [e.real for e in expected.exponents if e.real > fast.rest / float(few.period)]
    assert len(found.exponents) == 2 * len(slower) + 2  # their inverses, and two that stand for all others


@pytest.mark.parametrize("columns", [2, 6])
def test_a_random_subspace_meets_every_direction_as_often_as_stated(columns: int, tuned: Tuned) -> None:
    rows, each = 400, 0.02  # the chance for one vector; stated for rows / 2 of them
    tuned(columns_drawn_at_random=columns, chance_of_a_short_projection=each * rows / 2.0)
    rng = np.random.default_rng(7)
    drawn = np.concatenate([np.linalg.qr(rng.standard_normal((rows, columns)))[0] for _ in range(25)])
    real = float(np.mean(np.linalg.norm(drawn, axis=1) < math.sqrt(2.0) * fastest_solutions._shortest_projection(rows)))
    whirling = np.sqrt(0.5) * np.linalg.norm(drawn[::2] + 1j * drawn[1::2], axis=1)
    spread = math.sqrt(each / len(drawn))
    assert 0.8 * each - 3.0 * spread < real < each + 3.0 * spread
    assert np.mean(whirling < fastest_solutions._shortest_projection(rows)) < 0.2 * each


def multiplied(gap: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return a matrix that is not normal and its eigenvalues beyond 1, some near one another; others have size 0.3."""
    rng = np.random.default_rng(seed)
    outside = np.array([2.0, 1.6, 1.6, 1.6, 1.3])
    angles = rng.uniform(0.0, math.pi, 40)
    blocks = np.zeros((85, 85))
    blocks[:5, :5] = np.diag(outside)
    blocks[1:3, 1:3] += np.array([[0.0, 0.1], [gap, 0.0]])
    blocks[0, 4] = 5.0
    for i, angle in enumerate(angles):
        at = slice(5 + 2 * i, 7 + 2 * i)
        blocks[at, at] = 0.3 * np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    mixed = np.eye(85) + 0.03 * rng.standard_normal((85, 85))
    shift = math.sqrt(0.1 * gap)
    return np.linalg.solve(mixed, blocks @ mixed), np.array([2.0, 1.6 + shift, 1.6 - shift, 1.6, 1.3])


def held(matrix: np.ndarray, multipliers: np.ndarray, seed: int) -> list[bool]:
    """Return whether the discs of each Krylov space that has any hold all multipliers outside the circle."""
    rows, found = len(matrix), []
    start = np.linalg.qr(np.random.default_rng(seed).standard_normal((rows, fastest_solutions._COLUMNS)))[0]
    space = fastest_solutions._Space(start, matrix @ start, slice(0, fastest_solutions._COLUMNS))
    for _ in range(9):
        spectrum = fastest_solutions._Spectrum.of(space)
        for radius in (1.05, 1.2, 1.5, 1.8):
            radii = spectrum.radii(radius, fastest_solutions._shortest_projection(rows), 1e-12)
            if radii is not None:
                outside = multipliers[multipliers > radius]
                apart = np.abs(np.subtract.outer(outside, spectrum.values))
                found.append(bool((apart <= np.where(radii > 0.0, radii, -1.0)).any(axis=1).all()))
        space = fastest_solutions._longer(lambda states: matrix @ states, space)
    return found


@pytest.mark.parametrize("gap", [1e-3, 1e-8, 0.0])
def test_discs_hold_all_multipliers_outside_the_circle_nearly_defective_ones_too(gap: float) -> None:
    found = [held(*multiplied(gap, seed), seed + 50) for seed in range(depth(20, 1))]
    assert all(all(each) for each in found)
    assert all(len(each) > 2 for each in found)  # some spaces are large enough for the bound to say something


def test_nothing_is_said_where_nothing_grows_fast() -> None:
    still = many(1, 0.01, strongest=0.0)
    freed = still.undamped
    assert freed is not None
    assert fast_solutions(*freed) is None
    few = fr.HillSystem(still.stiffness[:50, :50], [still.cosines[0][:50, :50]], period=still.period)
    assert fast_solutions(few, 0.0) is None


def test_nothing_is_said_of_other_systems() -> None:
    system = many(4, 0.0)
    turn = np.diag(np.full(219, 0.1), 1)
    others: list[dict[str, Any]] = [{"gyroscopic": turn - turn.T}, {"mass": 2.0 * np.eye(220)}]
    for given in others:
        other = fr.HillSystem(system.stiffness, system.cosines, system.sines, period=system.period, **given)
        assert fast_solutions(other, 0.0) is None
    follower = fr.HillSystem(system.stiffness + turn, system.cosines, system.sines, period=system.period)
    assert fast_solutions(follower, 0.0) is None


@pytest.mark.slow
@pytest.mark.parametrize("seed", some(range(24), 9, 8))
def test_the_fastest_are_those_of_the_whole_map(seed: int) -> None:
    damping = (0.0, 0.001, 0.05, 0.2)[seed % 4]
    system = many(seed, damping, strongest=(0.3, 0.2, 0.15)[seed % 3])
    freed = system.undamped
    assert freed is not None
    fast = fast_solutions(*freed)
    if fast is not None:
        require_agreement(system, fast)
    elif seed % 3 == 0:
        raise AssertionError("not found")


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.98, 1.0, 1.02])
def test_a_second_place_where_motion_grows_is_not_missed(share: float) -> None:
    one, other = many(4, 0.0), many(5, 0.0)
    cosines, sines = (
        [a[0] + share * b[0][::-1, ::-1]] for a, b in ((one.cosines, other.cosines), (one.sines, other.sines))
    )
    system = fr.HillSystem(one.stiffness, cosines, sines, period=one.period)
    fast = fast_solutions(system, 0.0)
    assert fast is not None
    require_agreement(system, fast)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("length", "damping", "inclination"), [(839.0, 0.3, 60.0), (1000.0, 0.1, 60.0), (900.0, 0.0, 70.0)]
)
def test_long_rods_have_the_verdict_of_the_whole_map(
    length: float, damping: float, inclination: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    rod = TUBING.replace(length=length, damping_rate=damping, inclination=math.radians(inclination))
    unit = rod.critical_force
    load = fr.AxialWave.hertz(0.57 * unit, 0.23 * unit, 1.92, axial_damping=0.5)
    found = rod.stability(load, range(1, 233))
    assert "solutions over a period" in str(found.cost)
    monkeypatch.setattr(coupled_verdict, "fast_solutions", lambda *_: None)
    expected = rod.stability(load, range(1, 233))
    assert found.status == expected.status == "unstable"
    assert abs(found.growth_rate - expected.growth_rate) <= found.error + expected.error
    assert found.error < 1e-5 * found.growth_rate
