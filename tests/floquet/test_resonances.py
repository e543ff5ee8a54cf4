"""Growing solutions are named as the literature names them."""

from __future__ import annotations

import math

import numpy as np
import pytest

import floquetrod as fr
from tests.conftest import depth
from tests.system_cases import beam, coupled, wide

FLUTTER = np.array([[2.0, -1.0], [-1.0, 1.0]]), np.array([[1.0, -0.5], [0.0, 0.5]])


def follower(force: float) -> fr.HillSystem:
    """Return a double pendulum under a follower force that hardly pulsates."""
    stiffness, load = FLUTTER
    return fr.HillSystem(stiffness - force * load, [-0.1 * load], mass=[[3.0, 1.0], [1.0, 1.0]], period=2.0)


def pair(w: float, forcing: list[list[float]], frequencies: tuple[float, float] = (1.0, 3.0)) -> fr.HillSystem:
    return fr.HillSystem(np.diag(np.square(frequencies)), [forcing], period=2.0 * math.pi / w)


@pytest.mark.parametrize(
    ("system", "name"),
    [
        (coupled(3.0), "sum resonance of modes 1 and 2, order 1"),
        (coupled(2.0), "direct resonance of mode 1, order 1"),
        (coupled(4.0), "direct resonance of mode 2, order 1"),
        (coupled(3.0, (0.01, 0.01)), "sum resonance of modes 1 and 2, order 1"),
        (beam(40.0), "direct resonance of mode 1, order 1"),
        (beam(136.25), "sum resonance of modes 1 and 3, order 1"),
        # 2 w_1 = w_2 - w_1 = w: the forcing couples either the first mode to itself, or one mode to the other.
        (pair(2.0, [[0.3, 0.0], [0.0, 0.3]]), "direct resonance of mode 1, order 1"),
        (pair(2.0, [[0.0, 0.3], [-0.3, 0.0]]), "difference resonance of modes 1 and 2, order 1"),
        (pair(1.0, [[0.0, 0.3], [-0.3, 0.0]], (1.0, 2.0)), "difference resonance of modes 1 and 2, order 1"),
        (follower(1.5), "buckling of mode 1"),
        (follower(2.5), "flutter of modes 1 and 2"),
        (wide(), "buckling of mode 1"),
    ],
    ids=str,
)
def test_names(system: fr.HillSystem, name: str) -> None:
    result = fr.stability(system)
    assert result.status == "unstable"
    assert str(result.resonances[0]) == name
    assert result.resonances[0].growth_rate == pytest.approx(result.growth_rate, rel=1e-12)


def test_a_stable_system_has_none() -> None:
    assert fr.stability(coupled(1.0)).resonances == ()


def test_every_growing_solution_is_named_once() -> None:
    both = fr.HillSystem(np.diag([1.0, 2.25]), [np.diag([0.3, 0.9])], period=2.0 * math.pi / 2.0)
    two = fr.HillSystem(np.diag([1.0, 9.0]), [np.diag([0.3, 0.0])], [], period=math.pi)
    assert [str(found) for found in fr.stability(two).resonances] == ["direct resonance of mode 1, order 1"]
    names = fr.stability(both).resonances
    assert len(names) == len(set(names)) >= 1


def test_many_modes_are_left_unnamed() -> None:
    n = 210
    system = fr.HillSystem(np.diag(np.linspace(1.0, 2.0, n)), [np.diag([0.5] + [0.0] * (n - 1))], period=math.pi)
    result = fr.stability(system)
    assert result.status == "unstable"
    assert result.resonances == ()


@pytest.mark.slow
def test_what_is_lost_in_rounding_has_no_name() -> None:
    """Beside solutions that grow by e^95 in a period others are known with errors larger than their growth."""
    rod = fr.Rod(
        youngs_modulus=206e9,
        density=7850.0,
        radius=0.0259012,
        inner_radius=0.022016,
        channel_radius=0.06,
        length=100.0,
        path=fr.WellPath.arc(length=150.0, inclination=(1.14161, 1.06841)),
        depth=20.0,
        ends="hinged-clamped",
        damping_rate=0.05,
    )
    load = fr.AxialLoad(70400.8, 9171.78, 5.76391)
    found = rod.stability(load)
    whole = found.evidence.whole
    certain = [
        rate.real for rate, error in zip(whole.exponents, whole.exponent_errors, strict=True) if rate.real > error
    ]
    assert len(certain) < sum(rate.real > 0.0 for rate in whole.exponents)
    assert {r.growth_rate for r in found.resonances} <= set(certain)
    nearby = rod.stability(load.varied("mean", load.mean * (1.0 + 1e-14)))
    assert nearby.unstable_modes == found.unstable_modes


@pytest.mark.parametrize("damping", [0.0, 0.1])
@pytest.mark.parametrize(
    ("a", "q", "tongue"), [(0.347, 10.0, 2), (-2.0, 5.0, 1), (-5.0, 9.0, 1), (-10.0, 30.0, 2), (-5.0, 1.0, 0)]
)
def test_one_equation_is_named_by_its_tongue(a: float, q: float, tongue: int, damping: float) -> None:
    """Far above q = 0, too, where the nearest multiple of the frequency is another one: both doors give one number."""
    of_one = fr.HillSystem([[3.0 * a]], [[[-6.0 * q]]], mass=[[3.0]], damping=[[6.0 * damping]], period=math.pi)
    (found,) = fr.stability(of_one).resonances
    known = fr.stability(fr.Mathieu.from_aq(a, q, damping)).interval
    assert known == ("tongue", tongue)
    assert (found.kind, found.modes, found.order) == ("direct" if tongue else "buckling", (1,), tongue)


def test_the_tongue_of_one_equation_with_sines() -> None:
    sines = fr.HillSystem([[0.5]], [[[3.0]], [[1.0]]], [[[2.0]], [[-2.5]]], period=math.pi)
    hill = fr.stability(fr.Hill(-0.5, (-3.0, -1.0), (-2.0, 2.5), period=math.pi), method="spectral")
    (found,) = fr.stability(sines).resonances
    assert hill.interval == ("tongue", found.order)


def tongues_by_themselves(a: list[float], q: list[float], damping: float) -> set[tuple[int, int]]:
    """Return the modes and orders of the tongues in which Mathieu's equations lie where they are unstable."""
    numbers = np.argsort(np.argsort(a)) + 1
    equations = (fr.stability(fr.Mathieu.from_aq(*each, damping)) for each in zip(a, q, strict=True))
    unstable = [(int(i), found) for i, found in zip(numbers, equations, strict=True) if found.status == "unstable"]
    assert all(found.interval is not None and found.interval.kind == "tongue" for _, found in unstable)
    return {(i, found.interval.order) for i, found in unstable if found.interval is not None}


@pytest.mark.parametrize("seed", range(depth(100, 12)))
def test_equations_coupled_with_no_other_are_named_by_their_tongues(seed: int) -> None:
    drawn = np.random.default_rng([57, seed])
    n = int(drawn.integers(2, 4))
    a, q, damping = drawn.uniform(-6.0, 8.0, n), drawn.uniform(-6.0, 6.0, n), float(drawn.choice([0.0, 0.05, 0.3]))
    system = fr.HillSystem(np.diag(a), [np.diag(-2.0 * q)], damping=2.0 * damping * np.eye(n), period=math.pi)
    found = {(name.modes[0], name.order) for name in fr.stability(system).resonances}
    assert found == tongues_by_themselves(a.tolist(), q.tolist(), damping)


def test_a_trap_that_loses_its_ions_by_the_drive_does_not_buckle() -> None:
    """Both axes of a linear trap: the direct voltage pushes x away, which is lost with a multiplier below -1."""
    trap = fr.HillSystem(np.diag([-0.1, 0.1]), [np.diag([-2.4, 2.4])], period=math.pi)
    result = fr.stability(trap)
    assert min(multiplier.real for multiplier in result.multipliers) < -1.0
    assert [(name.kind, name.order) for name in result.resonances] == [("direct", 1)] * len(result.resonances)


@pytest.mark.parametrize("seed", range(depth(200, 25)))
def test_no_name_contradicts_the_sign_of_a_multiplier(seed: int) -> None:
    """Buckling and direct resonances of even order have multipliers above 1, direct ones of odd order below -1."""
    drawn = np.random.default_rng([58, seed])
    stiffness, forcing = (0.5 * (m + m.T) for m in drawn.uniform(-4.0, 4.0, (2, 3, 3)))
    result = fr.stability(fr.HillSystem(stiffness + 3.0 * np.eye(3), [forcing], period=math.pi))
    signs = {
        exponent.real: round(math.cos(exponent.imag * math.pi), 6) for exponent in result.exponents if exponent.real > 0
    }
    for name in result.resonances:
        if name.kind in ("buckling", "direct"):
            assert signs[name.growth_rate] * (-1) ** name.order > 0.0


def test_beside_an_equation_that_decays_below_all_doubles_the_other_has_its_name() -> None:
    """The first is held by a damping of 300, which takes a factor of exp(-940) in a period; the second buckles."""
    rate = 300.0
    stiffness, damping = np.diag([rate**2 + 1.0, -1.0]), np.diag([2.0 * rate, 0.0])
    result = fr.stability(fr.HillSystem(stiffness, [np.diag([1.0, 0.1])], damping=damping, period=math.pi))
    assert [(name.kind, name.order) for name in result.resonances] == [("buckling", 0)]


def pendula(omega: float, epsilon: float) -> fr.HillSystem:
    """Return two damped pendula, of which mode 2 would resonate by itself at 4.70 and is damped."""
    cosines = np.array([[0.9, 1.0], [1.0, 0.5]])
    sines = np.array([[0.0, 0.6], [-0.6, 0.0]])
    return fr.HillSystem(
        np.array([[3.0, -0.4], [-0.4, 5.0]]),
        [epsilon * cosines],
        [epsilon * sines],
        mass=[[2.0, 0.3], [0.3, 1.0]],
        damping=np.diag([0.03, 0.06]),
        period=2.0 * math.pi / omega,
    )


def test_a_complex_pair_is_no_direct_resonance_of_a_mode_that_decays_beside_it() -> None:
    """The multipliers of mode 2 lie near -1 and decay; those that grow are near +-i, as on either side."""
    result = fr.stability(pendula(4.7, 1.15))
    assert max(abs(m) for m in result.multipliers if abs(m.imag) < 1e-9) < 0.96
    assert [str(name) for name in result.resonances] == ["sum resonance of modes 1 and 2, order 1"]
    over = {"omega": np.array([4.6, 4.7, 4.75]), "eps": np.array([1.14, 1.15, 1.16])}
    (band,) = fr.chart(lambda omega, eps: pendula(omega, eps), over=over).bands
    assert {(band.mode, band.partner, band.tongue)} | {tongue[:3] for tongue in band.merged} == {(1, 2, 1)}


def test_a_mode_that_its_damping_drives_is_no_resonance() -> None:
    """One equation of negative damping grows with the frequency that it has by itself: no multiple of the forcing's."""
    driven = fr.HillSystem([[1.0]], [[[0.1]]], damping=[[-0.1]], period=2.0 * math.pi / 1.7)
    result = fr.stability(driven)
    assert result.status == "unstable"
    assert min(abs(multiplier.imag) for multiplier in result.multipliers) > 0.1
    assert result.resonances == ()


def test_a_double_multiplier_that_rounding_splits_is_real_within_its_error() -> None:
    """One of two equal equations drives the other, in coordinates that hide it: the double multiplier is defective."""
    mixing = np.random.default_rng(2).normal(size=(2, 2))
    cosines = mixing @ np.array([[0.5, 0.2], [0.0, 0.5]]) @ np.linalg.inv(mixing)
    result = fr.stability(fr.HillSystem(np.eye(2), [cosines], damping=0.05 * np.eye(2), period=math.pi))
    (name,) = result.resonances
    assert (name.kind, name.order) == ("direct", 1)


def drawn_system(seed: int) -> fr.HillSystem | fr.PeriodicSystem:
    """Return a coupled system: symmetric and damped, general, gyroscopic, or of first order, by turns."""
    drawn = np.random.default_rng([77, seed])
    n, period = int(drawn.integers(1, 4)), float(drawn.uniform(1.0, 6.0))
    if seed % 4 == 3:
        mean, cosines = drawn.uniform(-1.5, 1.5, (2, 2 * n, 2 * n))
        return fr.PeriodicSystem(mean - 0.3 * np.eye(2 * n), [0.7 * cosines], period=period)
    stiffness, cosines, sines, turning = drawn.uniform(-2.0, 2.0, (4, n, n))
    damping = np.diag(drawn.uniform(0.0, 0.3, n))
    if seed % 4 == 1:
        return fr.HillSystem(stiffness + 2.5 * np.eye(n), [cosines], [sines], damping=damping, period=period)
    stiffness, cosines, sines = (0.5 * (m + m.T) for m in (stiffness, cosines, sines))
    gyroscopic = turning - turning.T if seed % 4 == 2 else None
    return fr.HillSystem(
        stiffness + 2.5 * np.eye(n), [cosines], [sines], damping=damping, gyroscopic=gyroscopic, period=period
    )


@pytest.mark.parametrize("part", range(4))
def test_direct_resonances_and_buckling_are_names_of_real_multipliers_of_their_sign(part: int) -> None:
    seen = 0
    for seed in range(part, 4 * depth(400, 40), 4):
        result = fr.stability(drawn_system(seed))
        growing = [exponent for exponent in result.exponents if exponent.real > 0.0]
        for name in result.resonances:
            if name.kind in ("direct", "buckling"):
                own = [exponent for exponent in growing if exponent.real == name.growth_rate]
                half_turns = [exponent.imag * result.period / math.pi for exponent in own]
                assert any(abs(math.remainder(angle - name.order, 2.0)) < 1e-6 for angle in half_turns)
                seen += 1
    assert seen
