"""Modes that may resonate, as a system of their own, against all modes."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.equations.hill_system import restricted
from floquetrod.equations.matrices import mirrored
from floquetrod.floquet.multipliers.resonating_modes import resonating
from floquetrod.floquet.status import STATUS_CODES
from tests.conftest import depth
from tests.coupled_cases import TUBING
from tests.inside import Load, Loads

FREQUENCIES = np.concatenate([[1.0, 2.0, 3.0], np.linspace(7.0, 8.0, 9)])
COUNT = len(FREQUENCIES)


def apart(w: float, amplitude: float = 0.1, **more: Any) -> fr.HillSystem:
    """Return oscillators that are coupled a little, under a stiffness of frequency w."""
    coupling = amplitude * (np.eye(COUNT) + 0.05 * np.ones((COUNT, COUNT)))
    return fr.HillSystem(np.diag(FREQUENCIES**2), [coupling], period=2.0 * np.pi / w, **more)


def test_modes_whose_frequencies_add_up_to_no_resonance_are_left_out() -> None:
    found = resonating(apart(16.0))
    assert found is not None
    assert found.below == 3
    assert found.system.stiffness == pytest.approx(np.diag(FREQUENCIES[3:] ** 2), abs=1e-12)
    assert np.abs(found.basis) == pytest.approx(np.eye(COUNT)[:, 3:], abs=1e-12)
    assert found.system.cosines[0] == pytest.approx(apart(16.0).cosines[0][3:, 3:], abs=1e-12)
    whole, part = fr.stability(apart(16.0)), fr.stability(found.system)
    assert (part.status, whole.status) == ("unstable", "unstable")
    assert part.growth_rate == pytest.approx(whole.growth_rate, rel=1e-4)  # few modes, close to one another


@pytest.mark.parametrize("damping", [0.0, 0.001])
def test_damping_is_that_of_all_modes(damping: float) -> None:
    found = resonating(apart(16.0, damping=2.0 * damping * np.eye(COUNT)))
    assert found is not None
    assert found.system.uniform_damping == pytest.approx(damping)
    assert fr.stability(found.system).growth_rate == pytest.approx(
        fr.stability(apart(16.0)).growth_rate - damping, rel=1e-3
    )


@pytest.mark.parametrize(
    ("system", "why"),
    [
        (apart(9.0), "1 + 8 = 9"),
        (apart(9.6), "near 1 + 8"),
        (apart(16.0, amplitude=0.7), "the stiffness of the slowest may be negative"),
        (apart(16.0, gyroscopic=np.eye(COUNT, k=1) - np.eye(COUNT, k=-1)), "gyroscopic"),
        (apart(16.0, mass=2.0 * np.eye(COUNT)), "another mass"),
        (apart(16.0, damping=np.diag(FREQUENCIES)), "uneven damping"),
        (fr.HillSystem(np.diag(FREQUENCIES**2), [np.eye(COUNT, k=1)], period=2.0 * np.pi / 16.0), "not symmetric"),
        (fr.HillSystem.from_pieces([(1.0, np.diag(FREQUENCIES)), (1.0, np.eye(COUNT))]), "pieces"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_of_other_systems_all_modes_are_kept(system: fr.HillSystem, why: str) -> None:
    assert resonating(system) is None, why


def test_without_any_resonance_the_fastest_are_left() -> None:
    found = resonating(apart(40.0))
    assert found is not None
    assert found.below == 3
    assert fr.stability(found.system).status == "stable"


def test_fewer_modes_are_those_in_which_the_last_coordinates_do_not_move() -> None:
    many = np.concatenate([[1.0, 2.0, 3.0, 4.0], np.linspace(7.0, 8.0, 13)])
    coupling = 0.1 * (np.eye(17) + 0.05 * np.ones((17, 17)))
    turned = np.linalg.qr(np.eye(17) + 0.1 * np.random.default_rng(5).standard_normal((17, 17)))[0]
    damping = {"damping": 0.02 * np.eye(17), "period": 2.0 * np.pi / 16.0}

    apart = resonating(fr.HillSystem(np.diag(many**2), [coupling], **damping))
    assert apart is not None
    fewer = apart.without_last(3)
    assert fewer is not None
    assert (fewer.below, fewer.basis.shape, fewer.system.uniform_damping) == (4, (17, 10), 0.01)
    assert fewer.system.stiffness == pytest.approx(np.diag(many[4:14] ** 2), abs=1e-12)
    assert apart.without_last(5) is None  # fewer than are worth it

    mixed = fr.HillSystem(mirrored(turned.T @ np.diag(many**2) @ turned), [mirrored(turned.T @ coupling @ turned)])
    found = resonating(fr.HillSystem(mixed.stiffness, mixed.cosines, **damping))
    assert found is not None
    held = found.without_last(3)
    assert held is not None
    assert np.abs(held.basis[-3:]).max() < 1e-14
    assert held.basis.T @ held.basis == pytest.approx(np.eye(held.basis.shape[1]), abs=1e-14)
    assert held.basis.T @ mixed.stiffness @ held.basis == pytest.approx(held.system.stiffness, abs=1e-12)
    assert held.basis.T @ mixed.cosines[0] @ held.basis == pytest.approx(held.free.cosines[0], abs=1e-14)


def drawn(seed: int) -> tuple[fr.Rod, Load]:
    """Return a string and a load under which some of its modes cannot resonate, as a rule."""
    random = np.random.default_rng(seed)
    length = float(random.uniform(120.0, 300.0))
    rod = TUBING.replace(length=length, damping_rate=float(random.choice([0.0, 0.05, 0.3])), ends="hinged")
    shape = random.integers(3)
    if shape == 1:
        rod = rod.replace(path=fr.WellPath.arc(length=length, inclination=(1.1, 1.4)), inclination=None)
    if shape == 2:
        depth = np.linspace(0.0, length, 6)
        rod = rod.replace(path=fr.WellPath(depth, 1.2 + 0.002 * np.sqrt(depth), depth / 2000.0), inclination=None)
    unit = rod.critical_force
    forces = unit * random.uniform(0.0, 0.5), unit * 10.0 ** random.uniform(-2.0, -0.6), random.uniform(12.0, 25.0)
    if random.random() < 0.6:
        return rod, fr.AxialWave.hertz(*forces, axial_damping=float(random.choice([0.0, 1.0])))
    return rod, fr.AxialLoad.hertz(*forces)


@pytest.mark.parametrize(
    "seeds", [range(1000, 1004), pytest.param(range(1004, 1020), marks=pytest.mark.slow)], ids=["some", "many"]
)
@pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning", "ignore::floquetrod.ForcedAngleWarning")
def test_arrays_of_loads_say_what_all_modes_do(seeds: range) -> None:
    """Status, and growth to 1e-6 1/s, in the order of the loads, static ones among them."""
    left_out = 0
    for rod, load in map(drawn, seeds):
        amplitudes = load.amplitude * np.array([1.0, 0.0, 0.3, 2.0])
        means = np.append(load.mean, 0.5 * load.mean)[:, None]
        loads = Loads((8,), *(np.broadcast_to(x, (2, 4)).ravel() for x in (means, amplitudes, load.frequency)))
        try:
            modes = rod._modes_under(load)
            equations = modes.in_modes(modes.count_for(loads, 0.0))
            status, growth = equations.answers(loads)
        except ValueError:
            continue
        for i in np.flatnonzero(~np.isnan(growth)):  # those with which it stays on its wall
            at = load.varied("mean", float(loads.mean[i])).varied("amplitude", float(loads.amplitude[i]))
            system = equations.system(Loads.single(at))
            part, whole = resonating(system), fr.stability(system)
            left_out += part is not None
            assert status[i] == STATUS_CODES[whole.status], (rod, load, i)
            assert abs(growth[i] - whole.growth_rate) < 1e-6 + whole.exponent_errors[0], (rod, load, i)
    assert left_out > len(seeds)


def found_fewer(system: fr.HillSystem) -> None:
    """Compare what is left of resonating modes without the last functions to all modes without these."""
    part, held = resonating(system), system.order // 8
    fewer = None if part is None else part.without_last(held)
    if fewer is None:
        return
    whole, found = fr.stability(restricted(system, slice(system.order - held))), fr.stability(fewer.system)
    error = whole.exponent_errors[0] + found.exponent_errors[0]
    assert abs(whole.exponents[0].real - found.exponents[0].real) < 5e-6 + error


@pytest.mark.slow
@pytest.mark.parametrize(
    "seeds", [range(16), pytest.param(range(16, depth(136, 64)), marks=pytest.mark.slow)], ids=["some", "many"]
)
@pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning", "ignore::floquetrod.ForcedAngleWarning")
def test_the_verdict_on_a_string_is_that_of_all_its_modes(seeds: range) -> None:
    """Status, growth to 1e-6 1/s, and the names of what grows."""
    left_out = 0
    for rod, load in map(drawn, seeds):
        try:
            found = rod.stability(load)
        except ValueError:  # the string leaves its wall, or needs too many modes
            continue
        evidence = found.evidence
        below = getattr(evidence, "below", 0)
        if not below:
            continue
        left_out += 1
        system = rod._modes_under(load).in_modes(found.modes_checked).system(Loads.single(load))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            whole = fr.stability(system)
        assert evidence.whole.status == whole.status, (rod, load)
        error = whole.exponent_errors[0] + evidence.whole.exponent_errors[0]
        assert abs(found.exponents[0].real - whole.exponents[0].real) < 1e-6 + error, (rod, load)
        found_fewer(system)
        growing = [r for r in whole.resonances if r.growth_rate > 1e-5]
        named = evidence.coupled.named(system, tuple(growing))
        assert [r.modes for r in found.resonances[: len(named)]] == [r.modes for r in named], (rod, load)
    assert left_out > len(seeds) // 8
