"""What follows from a rod's parameters: for floats to the bit, for arrays to rounding, for intervals enclosed."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod._util.interval import PI, RealInterval
from tests.inside import ModeConstants, mode_constants


def random_rods(count: int, seed: int) -> list[fr.Rod]:
    """Return rods, tubes among them, every second without fluids, some in inclined channels."""
    rng = np.random.default_rng(seed)
    rods = []
    while len(rods) < count:
        radius = 10.0 ** rng.uniform(-4, 0)
        density = rng.uniform(1000.0, 9000.0)
        fluids = rng.uniform(0.0, 900.0, 2) if rng.random() < 0.5 else np.zeros(2)
        rods.append(
            fr.Rod(
                10.0 ** rng.uniform(8, 12),
                density,
                radius,
                10.0 ** rng.uniform(-1, 3),
                radius * (1.0 + 10.0 ** rng.uniform(-2, 2)),
                rng.uniform(1.0, 30.0),
                rng.choice([0.0, rng.uniform(0.0, 3.0)]),
                inner_radius=rng.choice([0.0, radius * rng.uniform(0.0, 0.4)]),
                fluid_inside=fluids[0],
                fluid_outside=fluids[1],
                added_mass_coefficient=rng.uniform(1.0, 4.0),
                inclination=rng.choice([0.5 * math.pi, rng.uniform(0.1, 1.5)]),
            )
        )
    return rods


@pytest.mark.slow
def test_numbers_of_rods_are_those_of_the_formulas_as_first_written() -> None:
    """The values of earlier versions, to the bit."""
    for rod in random_rods(1000, 1):
        r, ri, rho = rod.radius, rod.inner_radius, rod.density
        area, bore, outer = math.pi * (r**2 - ri**2), math.pi * ri**2, math.pi * r**2
        moment = 0.25 * math.pi * (r**4 - ri**4)
        own = rho * area + rod.fluid_inside * bore
        mass = own + rod.added_mass_coefficient * rod.fluid_outside * outer
        weighing = own - rod.fluid_outside * outer
        across = rod.gravity * math.sin(rod.inclination)
        pull = across * (weighing / mass)
        swing = math.sqrt(pull / (rod.channel_radius - r))
        assert (rod.area, rod.second_moment, rod.section.inner_area, rod.section.outer_area) == (
            area,
            moment,
            bore,
            outer,
        )
        assert (rod.mass_per_length, rod.flexural_rigidity) == (mass, rod.youngs_modulus * moment)
        assert (rod.weight_per_length, rod.effective_gravity) == (rod.gravity * weighing, pull)
        assert (rod.radial_clearance, rod.pendulum_frequency) == (rod.channel_radius - r, swing)
        assert rod.critical_force == 2.0 * math.sqrt(rod.youngs_modulus * moment * mass) * swing


def from_the_data_sheet(rod: fr.Rod) -> tuple[float, ...]:
    """Return the constants of the mode equations by the inertia, weight and stiffness of the data sheet."""
    w2, mass = (math.pi / rod.length) ** 2, rod.mass_per_length
    held = rod.curvature / (rod.radial_clearance * w2)
    return rod.flexural_rigidity / mass * w2**2, w2 / mass, rod.pendulum_frequency**2, held, rod.damping_rate


def test_modes_have_the_inertia_weight_and_stiffness_of_the_data_sheet() -> None:
    """Two ways of writing the same: over the area of the material, and in SI units."""
    for rod in random_rods(300, 2):
        constants = mode_constants(rod)
        assert constants.equation == pytest.approx(from_the_data_sheet(rod), rel=1e-13)
        assert all(type(value) is float for value in constants)


def test_arrays_give_what_floats_do() -> None:
    rods = random_rods(200, 3)
    columns: dict[str, Any] = {name: np.array([rod.parameters[name] for rod in rods]) for name in rods[0].parameters}
    found = ModeConstants.of(columns, sin=np.sin)
    np.testing.assert_allclose(np.array(found), np.array([mode_constants(rod) for rod in rods]).T, rtol=1e-14)


def exact(rod: dict[str, float]) -> tuple[Fraction, Fraction, Fraction]:
    """Return the first three constants of a horizontal rod as fractions, for pi = 3."""
    p = {name: Fraction(value) for name, value in rod.items()}
    pi = 3
    ratio = (p["radius"] ** 2, p["inner_radius"] ** 2)
    area, bore, outer = pi * (ratio[0] - ratio[1]), pi * ratio[1], pi * ratio[0]
    moment = Fraction(pi, 4) * (p["radius"] ** 4 - p["inner_radius"] ** 4)
    own = p["density"] * area + p["fluid_inside"] * bore
    mass = own + p["added_mass_coefficient"] * p["fluid_outside"] * outer
    weighing = own - p["fluid_outside"] * outer
    w = pi / p["length"]
    swing = p["gravity"] * weighing / mass / (p["channel_radius"] - p["radius"])
    return p["youngs_modulus"] * moment / mass * w**4, w**2 / mass, swing


def test_intervals_enclose_exact_numbers() -> None:
    """Points and boxes of parameters, against fractions; the circle constant is 3 on both sides."""
    rng = np.random.default_rng(4)
    for rod in random_rods(100, 5):
        horizontal = rod.parameters | {"inclination": 0.5 * math.pi}
        point = ModeConstants.of({n: RealInterval(v, v) for n, v in horizontal.items()}, pi=3, sin=lambda _: 1.0)
        for value, interval in zip(exact(horizontal), point, strict=False):
            assert value in interval
            assert interval.width <= 1e-13 * interval.high
        spread = 0.002 * rng.random()
        box = {n: RealInterval(v * (1.0 - spread), v * (1.0 + spread)) for n, v in horizontal.items()}
        try:
            found = ModeConstants.of(box, pi=3, sin=lambda _: 1.0)
        except ZeroDivisionError:
            assert rod.radial_clearance < 2.0 * spread * rod.channel_radius
            continue
        for _ in range(10):
            inside = {n: float(rng.uniform(i.low, i.high)) for n, i in box.items()}
            for value, interval in zip(exact(inside), found, strict=False):
                assert value in interval


def test_intervals_of_a_solid_rod_are_tight() -> None:
    """Each parameter occurs once: the ends are values at corners of the box, but for rounding."""
    names = ("youngs_modulus", "density", "radius", "length", "channel_radius", "gravity")
    rod = fr.Rod.nitinol()
    box = {name: RealInterval(0.99 * getattr(rod, name), 1.01 * getattr(rod, name)) for name in names}
    found = ModeConstants.of(rod.parameters | box, pi=PI)
    corners = [
        ModeConstants.of(rod.parameters | dict(zip(names, corner, strict=True)))
        for corner in product(*((i.low, i.high) for i in box.values()))
    ]
    for interval, values in zip(found[:3], np.array(corners).T[:3], strict=True):
        assert interval.low == pytest.approx(values.min(), rel=1e-14)
        assert interval.high == pytest.approx(values.max(), rel=1e-14)
        assert interval.low <= values.min() <= values.max() <= interval.high
    assert found.damping_rate == 0.0
