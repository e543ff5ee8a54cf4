"""Critical loads of coupled rods against every other answer to the same question: margins, ranges, dense verdicts."""

from __future__ import annotations

import copy
import json
import math
import pickle
from typing import Any, NamedTuple

import numpy as np
import pytest

import floquetrod as fr
from tests.conftest import depth, some
from tests.fuzz.rods import decades
from tests.inside import CoupledModel, Load

SLOW = 1e-6
"""Growth in 1/s up to which a load counts as stable, that of critical loads, ranges and margins."""

KINDS = ("clamped", "clamped-hinged", "hinged-clamped", "clamped-free", "clamped-guided", "weight", "wave", "curved")


class Question(NamedTuple):
    """A rod, the kind of load, and the quantity of the load that goes up from zero; the others are kept."""

    rod: fr.Rod
    like: Load
    varied: str
    load: Load

    def growth(self, values: Any) -> np.ndarray:
        """Return the growth in 1/s where the quantity has these values."""
        numbers = {name: getattr(self.load, name) for name in ("mean", "amplitude", "frequency")}
        return np.asarray(self.rod.growth_rate(self.like, **numbers | {self.varied: np.asarray(values)}))

    def critical(self) -> fr.rod.CriticalValue:
        """Return the critical load."""
        if self.varied == "mean":
            return self.rod.critical("mean", self.like, amplitude=self.load.amplitude, frequency=self.load.frequency)
        return self.rod.critical("amplitude", self.like, mean=self.load.mean, frequency=self.load.frequency)

    def ranges(self) -> fr.results.StabilityIntervals:
        """Return the stable intervals of the quantity."""
        if self.varied == "mean":
            return self.rod.ranges("mean", self.like, amplitude=self.load.amplitude, frequency=self.load.frequency)
        return self.rod.ranges("amplitude", self.like, mean=self.load.mean, frequency=self.load.frequency)


def drawn(rng: np.random.Generator) -> Question:
    """Return a question about a rod of a few half waves whose ends, weight, force or channel couple its modes."""
    kind = str(rng.choice(KINDS))
    rod, like = fr.Rod.nitinol(), fr.AxialLoad(0.0, 0.0, 1.0)
    if rng.random() < 0.5:
        radius = decades(rng, 3e-4, 5e-3)
        channel = radius * (1.0 + decades(rng, 0.3, 10.0))
        rod = fr.Rod(decades(rng, 1e9, 2.5e11), decades(rng, 900.0, 9000.0), radius, 1.0, channel)
    rod = rod.replace(length=decades(rng, 1.0, 2.2) / rod.critical_mode)
    rates = (0.0, decades(rng, 1e-4, 0.02), decades(rng, 0.02, 0.3))
    rod = rod.replace(damping_rate=rod.pendulum_frequency * float(rng.choice(rates)))
    unit, swing = rod.critical_force, rod.pendulum_frequency
    if kind == "weight":
        rod = rod.replace(inclination=float(rng.uniform(0.7, 1.3)))
    elif kind == "curved":
        weight = rod.mass_per_length * rod.effective_gravity
        rod = rod.replace(curvature=float(rng.uniform(-0.02, 0.02)) * weight / unit)
    elif kind == "wave":
        far_end = str(rng.choice(["held", "free", "driven"]))
        like = fr.AxialWave(0.0, 0.0, 1.0, far_end=far_end, axial_damping=20.0)
    else:
        rod = rod.replace(ends=kind)
    varied = str(rng.choice(["mean", "amplitude"]))
    mean, amplitude = float(rng.uniform(0.0, 0.7)) * unit, decades(rng, 0.02, 0.6) * unit
    numbers = {"mean": mean, "amplitude": amplitude, "frequency": decades(rng, 2.0, 6.0) * swing} | {varied: 0.0}
    return Question(rod, like, varied, like.with_numbers(**numbers))


def disagreements(question: Question, with_ranges: bool, dense: int) -> list[str]:
    """Return where answers to one question differ by more than the resolutions that they state.

    A band of growth below an answer may have been passed over only where it is narrower than the resolution.
    """
    critical, unit = question.critical(), question.rod.critical_force
    limit = critical.searched
    answers = {"the critical load": (float(critical), critical.resolution)}
    here = question.rod.stability(question.load)
    if here.status == "undecided":
        return []
    margin = here.margin(question.varied) if here.stable else fr.results.Margin(math.inf, 0.0)
    answers["the margin"] = (margin.above, margin.resolution)
    if with_ranges:
        ranges = question.ranges()
        first = ranges.intervals[0] if ranges.intervals else None
        if first is None or first.low > 0.0:
            answers["the range"] = (0.0, 0.0)
        else:
            answers["the range"] = (math.inf if first.high_end is None else first.high, ranges.resolution)
    lowest = min(value for value, _ in answers.values())
    # Dense verdicts up to the lowest answer, and just above it.
    values = np.linspace(0.0, min(lowest, limit), dense, endpoint=False)
    growing = np.flatnonzero(question.growth(values) > SLOW)
    starts = list(values[growing[np.diff(growing, prepend=-2) > 1]]) if growing.size else []
    wrong = []
    if with_ranges and isinstance(ranges.searched.model, CoupledModel) and answers["the range"][0] != critical:
        wrong.append(f"the range ends at {answers['the range'][0]!r}, the critical load is {float(critical)!r}")
    if lowest < math.inf:
        starts.append(lowest)
        above = question.growth(lowest + 1e-7 * unit + critical.resolution * np.linspace(0.0, 1.0, 9))
        if lowest > 0.0 and not (above > SLOW).any():
            wrong.append(f"nothing grows above {lowest!r}")
    for name, (value, resolution) in answers.items():
        for start in starts:
            if start < value - 1e-6 * unit and start <= limit and not _is_narrow(question, start, resolution):
                wrong.append(f"{name} is {value!r} +- {resolution!r}, and from {start!r} on something grows")
    return wrong


def _is_narrow(question: Question, start: float, width: float) -> bool:
    """Return whether the band that begins at a value ends within a width of it."""
    if width == 0.0:
        return False
    return bool((question.growth(start + width * np.linspace(0.02, 1.0, 50)) <= SLOW).any())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "amplitude", "frequency", "share"),
    [
        ({"ends": "clamped-hinged", "length": 3.6254783670219677}, 0.055708870618028705, 157.66443184038263, 0.03185),
        pytest.param(
            {"ends": "clamped-free", "length": 2.4658167476469655, "damping_rate": 0.05},
            0.08483359862503231,
            77.67098964857985,
            0.27081,
            marks=pytest.mark.slow,
        ),
    ],
)
def test_no_unstable_band_wider_than_the_resolution_is_stepped_over(
    changes: dict[str, Any], amplitude: float, frequency: float, share: float
) -> None:
    rod = fr.Rod.nitinol().replace(**changes)
    critical = rod.critical("mean", amplitude=amplitude, frequency=frequency)
    load = fr.AxialLoad(0.0, amplitude, frequency)
    assert critical / rod.critical_force == pytest.approx(share, abs=1e-5)
    assert critical == pytest.approx(rod.stability(load).margin("mean").above, rel=1e-9)
    assert 0.0 < critical.resolution < 0.002 * rod.critical_force
    assert critical.searched == critical
    end = 0.125 if share < 0.125 else 0.5  # of a piece that is searched
    ranges = rod.ranges("mean", amplitude=amplitude, frequency=frequency, bounds=(0.0, end * rod.critical_force))
    assert ranges.intervals[0][:2] == (0.0, float(critical))
    assert all("unnamed" not in part[2:] for part in ranges)
    assert ranges.resolution < 0.002 * rod.critical_force
    assert rod.stability(fr.AxialLoad(critical * 0.9999, amplitude, frequency)).status == "stable"
    assert rod.stability(fr.AxialLoad(critical * 1.01, amplitude, frequency)).status == "unstable"


@pytest.mark.slow
def test_ranges_begin_with_the_interval_up_to_the_critical_load() -> None:
    for seed in (12, *some(range(15), 5, 0)):
        question = drawn(np.random.default_rng([77, seed]))
        critical, ranges = question.critical(), question.ranges()
        if isinstance(ranges.searched.model, CoupledModel) and critical > 0.0:
            first = ranges.intervals[0]
            assert first.low == 0.0, (seed, question)
            assert (math.inf if first.high_end is None else first.high) == critical, (seed, question)
            assert first.high == critical.searched, (seed, question)
            assert critical.resolution <= ranges.resolution, (seed, question)
        else:
            assert seed != 12


@pytest.mark.slow
def test_critical_loads_margins_and_verdicts_of_drawn_rods_agree() -> None:
    for seed in range(depth(25, 1)):
        question = drawn(np.random.default_rng([31, seed]))
        assert not disagreements(question, with_ranges=seed % 5 == 4, dense=depth(51, 21)), (seed, question)


@pytest.mark.slow
@pytest.mark.parametrize("seeds", [range(start, start + 10) for start in range(0, 30, 10)], ids=str)
def test_thirty_critical_loads_agree_with_margins_and_dense_verdicts(seeds: range) -> None:
    wrong = {}
    for seed in (seeds[0], *some(seeds[1:], 1, 1)):
        question = drawn(np.random.default_rng([32, seed]))
        if different := disagreements(question, with_ranges=seed % 10 == 0, dense=401):
            wrong[seed] = (question, different)
    assert not wrong


def test_independent_modes_are_searched_without_gaps() -> None:
    rod = fr.Rod.nitinol()
    critical = rod.critical("mean", amplitude=0.2 * rod.critical_force, frequency=150.0)
    assert critical.resolution == 0.0
    assert repr(critical) == f"<critical mean force {float(critical):.9g} N>"
    stiff = rod.replace(damping_rate=200.0, length=0.3)
    none = stiff.critical("amplitude", mean=0.0, frequency=150.0)
    assert math.isinf(none)
    assert none.searched == pytest.approx(rod.critical_force, rel=1e-9)
    assert repr(none).startswith(f"<no critical amplitude up to {none.searched:.6g} N")


def test_a_critical_load_is_a_number_that_says_how_it_was_found() -> None:
    critical = fr.rod.CriticalValue(0.25, "amplitude", 0.001, 0.25)
    assert critical / 0.5 == 0.5
    assert f"{critical:.3f}" == "0.250"
    assert type(2.0 * critical) is float
    assert repr(critical) == ("<critical amplitude 0.25 N; unstable bands narrower than 0.001 N may have been missed>")
    for other in (pickle.loads(pickle.dumps(critical)), copy.deepcopy(critical)):
        assert (other, other.quantity, other.resolution, other.searched) == (0.25, "amplitude", 0.001, 0.25)
    none = fr.rod.CriticalValue(math.inf, "mean", 0.002, 1.5)
    assert json.loads(fr.to_json(none))["result"] == {
        "critical_mean_force_N": None,
        "resolution_N": 0.002,
        "searched_N": 1.5,
    }
    assert repr(none) == (
        "<no critical mean force up to 1.5 N; unstable bands narrower than 0.002 N may have been missed>"
    )
