"""Verdicts on drawn strings of several sections beside a model of Hermite elements that shares nothing with them."""

from __future__ import annotations

import itertools
import math
import warnings
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod import LeavesWallError
from tests.conftest import depth as depth_of_draws
from tests.string_elements import StringModel, part

ROUNDING = 1e-11  # 1/s, of a rate that is 0 without damping
ENDS = ("hinged", "clamped", "guided", "free")


def drawn(seed: int) -> tuple[fr.Rod, fr.AxialLoad, StringModel]:
    """Return a string of two to six sections in one to three bores, a load, and the model of the string."""
    rng = np.random.default_rng([51, seed])
    number, fluids = int(rng.integers(2, 7)), tuple(rng.choice([0.0, 1000.0, 1300.0], 2).tolist())
    outer = rng.uniform(0.02, 0.04, number)
    tubes = [
        {
            "radius": float(r),
            "inner_radius": float(r * rng.choice([0.0, 0.6, 0.8])),
            "youngs_modulus": float(rng.choice([207e9, 110e9])),
            "density": float(rng.choice([7850.0, 4500.0])),
        }
        for r in outer
    ]
    lengths = rng.dirichlet(np.full(number, 1.5)) * rng.uniform(15.0, 70.0) + 0.3
    depths = [0.0, *np.sort(rng.uniform(0.0, lengths.sum(), int(rng.integers(0, 3))))]
    bores = [(float(depth), float(rng.uniform(0.1, 0.2))) for depth in depths]
    ends = tuple(rng.choice(ENDS, 2, p=[0.55, 0.25, 0.1, 0.1]).tolist())
    inclination = math.pi / 2 if rng.random() < 0.4 else float(rng.uniform(0.5, 1.5))
    curvature = 0.0 if rng.random() < 0.7 else float(rng.uniform(-2e-3, 6e-3))
    mean_at = float(rng.choice([0.0, 0.5, 1.0]))
    damping = float(rng.choice([0.0, 0.05, 0.3]))
    sections = [{**tube, "length": float(length)} for tube, length in zip(tubes, lengths, strict=True)]
    rod = fr.Rod(
        sections=sections,
        bores=bores,
        fluid_inside=fluids[0],
        fluid_outside=fluids[1],
        ends="-".join(ends),
        inclination=inclination,
        curvature=curvature,
        damping_rate=damping,
    )
    section_ends, parts = np.cumsum(lengths), []
    edges = np.unique([0.0, *section_ends, *depths])
    for a, b in itertools.pairwise(edges):
        tube = tubes[int(np.searchsorted(section_ends, 0.5 * (a + b)))]
        bore = [diameter for depth, diameter in bores if depth <= a][-1]
        parts.append(part(float(b - a), tube, bore, fluids))
    model = StringModel(parts, ends, inclination, curvature, mean_at)
    critical = abs(model.critical())
    mean, amplitude = float(rng.uniform(-0.2, 0.9)) * critical, float(rng.uniform(0.02, 0.8)) * critical
    squares = np.linalg.eigvalsh(model.still - mean * model.driving)
    natural = math.sqrt(max(float(squares[int(rng.integers(0, 6))]), 1.0))
    frequency = natural * 2.0 / float(rng.integers(1, 4)) * float(rng.uniform(0.9, 1.1))
    return rod, fr.AxialLoad(mean, amplitude, frequency, mean_at=mean_at), model


def compared(seed: int) -> str:
    """Return "agree", "undecided" or "refused"; fail where the verdict or its error is wrong."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rod, load, model = drawn(seed)
        try:
            verdict: Any = rod.stability(load)
        except (LeavesWallError, ValueError) as error:
            assert "wall" in str(error), error  # noqa: PT017
            return "refused"
    known = model.growth(load.mean, load.amplitude, load.frequency, rod.damping_rate)
    if verdict.status == "undecided":
        return "undecided"
    room = known.error + 1e-7
    if known.rate > room:
        assert verdict.status == "unstable", (seed, known, verdict)
    elif known.rate < -room or (rod.damping_rate == 0.0 and abs(known.rate) < ROUNDING):
        assert verdict.stable, (seed, known, verdict)
    else:
        return "undecided"
    if verdict.status == "unstable":
        assert abs(verdict.growth_rate - known.rate) <= verdict.error + room, (seed, known, verdict.growth_rate)
    return "agree"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth_of_draws(6, 2)))
def test_verdicts_agree_with_elements(seed: int) -> None:
    compared(seed)


@pytest.mark.slow
def test_five_hundred_verdicts_agree_with_elements() -> None:
    outcomes = [compared(seed) for seed in range(500)]
    assert outcomes.count("agree") > 400, {each: outcomes.count(each) for each in set(outcomes)}
