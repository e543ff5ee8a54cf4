"""Strings of several sections: truth, what a string is, and symmetries of its verdicts."""

from __future__ import annotations

import copy
import json
import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.rod.model.section_basis import Profile, section_basis
from tests.conftest import depth
from tests.inside import CoupledModes

TRUTH: list[dict[str, Any]] = json.loads((Path(__file__).parents[2] / "data" / "sections_truth.json").read_text())
CONFIRMATIONS = (1, 2, 3, 4, 5, 6, 7, 9, 10, 11)
"""Cases of `make slow`: all but one of two walls and one of a wire."""
IDS = [f"{i}-{each['name']}".replace(" ", "-") for i, each in enumerate(TRUTH)]
OF_TRUTH = 1e-6
"""By which two meshes of the truth agree, relative."""

WATER: dict[str, Any] = {"fluid_inside": 1000.0, "fluid_outside": 1000.0, "damping_rate": 0.2}
THIN, THICK = fr.Section("2.00x0.156 CT90", length="30m"), fr.Section("2.00x0.203 CT90", length="30m")
STRING = fr.Rod(sections=[THIN, THICK], channel_diameter="4.778in", **WATER)
UNIT = STRING.critical_force


def rod_of(case: dict[str, Any]) -> fr.Rod:
    """Return the string of a case, with a bore of its own for each section."""
    sections = [
        {k: s[k] for k in s if k not in ("channel_diameter", "fluid_inside", "fluid_outside")} for s in case["sections"]
    ]
    starts = np.cumsum([0.0, *(s["length"] for s in case["sections"])])
    bores = [(float(z), s["channel_diameter"]) for z, s in zip(starts, case["sections"], strict=False)]
    fluids = {key: case["sections"][0].get(key, 0.0) for key in ("fluid_inside", "fluid_outside")}
    return fr.Rod(
        sections=sections, bores=bores, inclination=case["inclination"], damping_rate=case["damping"], **fluids
    )


@pytest.mark.parametrize(
    "case",
    [pytest.param(each, id=IDS[k], marks=[pytest.mark.slow] * (k in CONFIRMATIONS)) for k, each in enumerate(TRUTH)],
)
def test_growth_and_static_limit_are_those_of_finite_elements(case: dict[str, Any]) -> None:
    rod = rod_of(case)
    load = fr.AxialLoad(case["mean"], case["amplitude"], case["frequency"], mean_at=0.0)
    verdict = rod.stability(load)
    assert verdict.status == ("unstable" if case["growth"] else "stable")
    assert verdict.growth_rate == pytest.approx(case["growth"], rel=OF_TRUTH, abs=1e-12)
    critical = rod.critical("mean", load.varied("amplitude", 0.0))
    assert float(critical) == pytest.approx(case["critical"], rel=OF_TRUTH)


def test_a_string_of_equal_sections_is_the_uniform_rod() -> None:
    cut = fr.Rod(
        sections=[THIN, {"name": "2.00x0.156 CT90", "length": "12m"}],
        bores=[("0m", "4.778in"), ("20m", "4.778in")],
        **WATER,
    )
    whole = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=42.0, **WATER)
    assert (cut.sections, cut.bores, cut.varies) == ((), (), False)
    assert cut == whole
    assert cut.as_dict() == whole.as_dict()


def test_sections_that_hardly_differ_hardly_differ_from_a_uniform_rod() -> None:
    """By another basis altogether: sines there, finite elements here."""
    whole = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length=60.0, inclination=1.2, **WATER)
    cut = whole.replace(sections=[THIN, {**THIN.as_dict(), "density": THIN.density * (1.0 + 1e-12)}])
    assert cut.varies
    for mean, amplitude, frequency in ((0.5, 0.3, 17.0), (0.7, 0.1, 9.0), (0.2, 0.5, 30.0)):
        load = fr.AxialLoad(mean * UNIT, amplitude * UNIT, frequency)
        one, other = whole.stability(load), cut.stability(load)
        assert one.status == other.status
        assert abs(one.growth_rate - other.growth_rate) <= one.error + other.error
        assert one.growth_rate == pytest.approx(other.growth_rate, rel=1e-6, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(4, 2)))
def test_a_string_and_its_mirror_image_grow_alike(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sections = [
        fr.Section(radius=r, length=each) for r, each in rng.uniform((0.02, 5.0), (0.03, 20.0), (3, 2)).tolist()
    ]
    length = sum(each.length for each in sections)
    widths, cut = rng.uniform(0.09, 0.14, 2).tolist(), float(rng.uniform(0.2, 0.8)) * length
    string = fr.Rod(
        sections=sections, bores=[(0.0, widths[0]), (cut, widths[1])], ends="clamped-hinged", damping_rate=0.1
    )
    mirror = fr.Rod(
        sections=sections[::-1],
        bores=[(0.0, widths[1]), (length - cut, widths[0])],
        ends="hinged-clamped",
        damping_rate=0.1,
    )
    load = fr.AxialLoad(0.6 * string.critical_force, 0.4 * string.critical_force, float(rng.uniform(5.0, 40.0)))
    one, other = string.stability(load), mirror.stability(load)
    assert one.status == other.status
    assert abs(one.growth_rate - other.growth_rate) <= one.error + other.error
    assert one.growth_rate == pytest.approx(other.growth_rate, rel=1e-5, abs=1e-9)


def test_the_order_of_sections_matters() -> None:
    inclined = STRING.replace(inclination=1.0)
    turned = inclined.replace(sections=[THICK, THIN])
    load = fr.AxialLoad(0.6 * UNIT, 0.4 * UNIT, 16.0)
    assert inclined.growth_rate(load) != pytest.approx(turned.growth_rate(load), rel=1e-3)


def test_a_scalar_and_an_array_are_judged_alike() -> None:
    means = np.linspace(0.0, 1.2 * UNIT, 9)
    status = STRING.verdicts(mean=means, amplitude=0.3 * UNIT, frequency=16.0)
    growth = STRING.growth_rate(mean=means, amplitude=0.3 * UNIT, frequency=16.0)
    for i, mean in enumerate(means.tolist()):
        verdict = STRING.stability(fr.AxialLoad(mean, 0.3 * UNIT, 16.0))
        assert verdict.status == {1: "stable", 0: "unstable"}[status[i]]
        assert growth[i] == pytest.approx(verdict.growth_rate, rel=1e-6, abs=1e-7)


@pytest.mark.slow
def test_one_critical_force_by_all_doors() -> None:
    load = fr.AxialLoad(0.0, 0.25 * UNIT, 16.0)
    critical = float(STRING.critical("mean", load))
    ranges = STRING.ranges("mean", load)
    assert ranges.intervals[0][:2] == (0.0, critical)
    assert STRING.stability(load).margin("mean").above == pytest.approx(critical, rel=1e-6)


def test_a_string_is_a_value() -> None:
    rod = STRING.replace(bores=[("0m", "4.778in"), ("45m", "6.184in")], inclination="70deg")
    assert eval(repr(rod), {"Rod": fr.Rod}) == rod
    assert fr.Rod(**rod.as_dict()) == rod == pickle.loads(pickle.dumps(rod)) == copy.deepcopy(rod)
    assert hash(rod) == hash(fr.Rod(**rod.as_dict()))
    assert [part.end for part in rod.uniform_parts] == [30.0, 45.0, 60.0]
    assert rod.replace(damping_rate=1.0).sections == rod.sections
    assert rod.replace(sections=[THICK, THIN]).radius == THICK.radius
    assert json.loads(json.dumps(rod.as_dict()))["sections"][0]["name"] == "2.00x0.156 CT90"


@pytest.mark.parametrize("ends", ["hinged", "clamped", "free", "guided", "free-hinged", "clamped-free", "guided-free"])
@pytest.mark.parametrize("count", [12, *(pytest.param(count, marks=pytest.mark.slow) for count in (60, 210))])
def test_the_basis_is_orthonormal_and_holds_its_ends(ends: str, count: int) -> None:
    rod = STRING.replace(ends=ends, bores=[(0.0, 0.12), (30.0 + 1e-5, 0.15)], channel_diameter=None)
    profile = Profile.of(rod)
    basis = section_basis(profile, count)
    assert basis.size == CoupledModes.of(rod, fr.AxialLoad(0.0, 0.0, 1.0), count).size
    inertia = rod.along(basis.nodes).inertia / rod.along(0.0).inertia
    assert basis.pressing(inertia) == pytest.approx(np.eye(basis.size), abs=1e-9)
    shapes = basis.shapes(np.array([0.0, 1.0]))
    for i, end in enumerate((rod.end_conditions.upper, rod.end_conditions.lower)):
        assert end not in ("hinged", "clamped") or np.abs(shapes[:, i]).max() < 1e-9
    waves = np.sqrt(np.sqrt(np.maximum(np.linalg.eigvalsh(basis.bending), 0.0)))
    assert waves[-1] < 3.5 * math.pi * count


@pytest.mark.parametrize("beside", [0.0, 1e-13, 1e-9, 1e-4])
def test_sections_may_meet_next_to_a_station(beside: float) -> None:
    well = fr.WellPath([0.0, 700.0, 730.0, 760.0, 1000.0], ["30deg", "40deg", "43deg", "45deg", "50deg"], "10deg")
    first = fr.Section("2.00x0.156 CT90", length=30.0 + beside)
    string = STRING.replace(sections=[first, THICK], path=well, depth=700.0)
    growth = string.stability(fr.AxialLoad(0.6 * UNIT, 0.4 * UNIT, 16.0))
    known = STRING.replace(sections=[fr.Section("2.00x0.156 CT90", length=29.99), THICK], path=well, depth=700.0)
    assert growth.growth_rate == pytest.approx(known.growth_rate(fr.AxialLoad(0.6 * UNIT, 0.4 * UNIT, 16.0)), rel=5e-3)
    assert growth.error < 1e-3
