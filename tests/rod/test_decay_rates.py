"""The slowest decay of a rod is that of all its modes, not of those alone that decide the verdict."""

from __future__ import annotations

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.results import RodStability
from tests.conftest import depth

DRAWS = {"one sine": depth(60, 10), "two sines": depth(40, 4), "noise": depth(25, 4), "noise in a band": depth(12, 5)}
MANY = 50  # modes, beyond which none of these decays more slowly


def drawn(kind: str, rng: np.random.Generator) -> tuple[fr.Rod, fr.AxialLoad]:
    """Return a damped rod and a load of some kind, most of them stable."""
    rod = fr.Rod.nitinol().replace(radius=rng.uniform(3e-4, 8e-4), damping_rate=rng.uniform(1.0, 8.0))
    critical = rod.critical_force
    more: dict[str, object] = {}
    if kind == "two sines":
        more["second"] = (0.1 * critical, rng.uniform(50.0, 500.0))
    elif kind == "noise":
        more["noise"] = rng.uniform(0.0, 1e-3) * critical**2
    elif kind == "noise in a band":
        start = rng.uniform(20.0, 150.0)
        density = rng.uniform(0.0, 3e-4) * critical**2
        more["noise"] = ((start, density), (start + rng.uniform(100.0, 300.0), density))
    mean, amplitude, frequency = rng.uniform([0.0, 0.0, 150.0], [0.8 * critical, 0.15 * critical, 600.0]).tolist()
    return rod, fr.AxialLoad(mean, amplitude, frequency, **more)


def slowest(rod: fr.Rod, load: fr.AxialLoad, modes: int) -> RodStability:
    """Return the verdict on so many modes."""
    return rod.stability(load, modes=range(1, modes + 1))


@pytest.mark.parametrize("kind", DRAWS)
def test_the_slowest_motion_may_be_one_of_a_mode_that_cannot_grow(kind: str) -> None:
    """Drawn rods: the rate is that of many modes; for some, not that of the modes examined."""
    rng = np.random.default_rng(2911)
    slower = 0
    for _ in range(DRAWS[kind]):
        rod, load = drawn(kind, rng)
        verdict = rod.stability(load)
        if not verdict.stable:
            continue
        every = slowest(rod, load, MANY)
        assert verdict.decay_rate == pytest.approx(every.decay_rate, rel=1e-9), (rod, load)
        examined = slowest(rod, load, verdict.modes_checked)
        slower += examined.decay_rate > (1.0 + 1e-9) * verdict.decay_rate
    assert slower > 0


def test_modes_chosen_have_the_rate_of_these() -> None:
    """Who asks for a mode is answered for that mode."""
    rod = fr.Rod.nitinol().replace(damping_rate=2.0)
    critical = rod.critical_force
    load = fr.AxialLoad(0.3 * critical, 0.3 * critical, 600.0)
    verdict = slowest(rod, load, 1)
    assert verdict.decay_rate == -verdict.mode_verdicts[0].exponents[0].real * 600.0 == pytest.approx(2.0)
