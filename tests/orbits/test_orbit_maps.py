"""Maps over the intervals of an orbit's mesh: of the plane in plain numbers, as in any number of dimensions."""

from __future__ import annotations

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.orbits import orbit_multipliers, split_maps


@pytest.mark.parametrize("seed", range(20))
def test_maps_of_the_plane_are_judged_as_others(seed: int) -> None:
    rng = np.random.default_rng(seed)
    maps = rng.normal(size=(17, 2, 2)) * np.array([1.0, 10.0 ** rng.uniform(-4.0, 0.0)])
    (frames, growth), (known, expected) = split_maps._iterated_plane(maps), split_maps._iterated(maps)
    assert np.allclose(np.abs(np.einsum("iab,iab->ib", frames, known)), 1.0, rtol=0.0, atol=1e-8)
    assert np.allclose(growth.sum(axis=0), expected.sum(axis=0), rtol=1e-9, atol=1e-9)
    assert np.allclose(orbit_multipliers._conditions(maps), np.linalg.cond(maps), rtol=1e-9)


def test_a_singular_map_has_no_condition_number() -> None:
    assert np.isinf(orbit_multipliers._conditions(np.array([[[1.0, 2.0], [2.0, 4.0]]]))).all()


def test_the_trivial_multiplier_of_two_equations_is_1() -> None:
    """States of very different size: position in metres, velocity in micrometres a second."""
    system = fr.NonlinearSystem(lambda t, x: (1e-6 * x[1], (1.0 - x[0] ** 2) * x[1] - 1e6 * x[0]))
    orbit = fr.periodic_orbit(system, [2.0, 0.0])
    assert orbit.trivial_multiplier_less_1 == pytest.approx(0.0, abs=1e-11)
    assert orbit.multipliers[0].real == pytest.approx(8.5969506e-4, rel=1e-6)
