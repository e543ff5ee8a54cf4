"""Strings of several sections, in several bores, in wells: the chain of uniform ones is the truth."""

from __future__ import annotations

import html
import itertools
import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

import floquetrod as fr
from floquetrod.cli.main import main
from tests.conftest import depth as depth_of_draws
from tests.conftest import some

STEEL = {"youngs_modulus": 2.07e11, "density": 7850.0}
WELL = fr.WellPath([0.0, 1000.0, 1450.0, 4000.0], ["0deg", "0deg", "90deg", "90deg"])
SECTIONS = [
    fr.Section("2.00x0.156 CT90", length="2000m"),
    fr.Section("2.00x0.203 CT90", length="1200m"),
    fr.Section(diameter="2.875in", inner_diameter="1in", length="5m"),
]
STRING = fr.Rod(sections=SECTIONS, bores=[("0m", "4.778in"), ("1500m", "6.184in")], fluid_inside=1e3, fluid_outside=1e3)

pytestmark = pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")


class Drawn(NamedTuple):
    """A string in a well, and how it moves."""

    rod: fr.Rod
    well: fr.WellPath
    friction: list[tuple[float, float]]
    motion: str
    helical: str
    far_force: float

    def mean_force(self, bottom: float, **others: Any) -> fr.results.MeanForce:
        """Return the mean force of the string to a depth."""
        return self.rod.mean_force(
            self.well,
            self.friction,
            motion=self.motion,
            helical=self.helical,
            far_force=self.far_force,
            bottom=bottom,
            **others,
        )

    def cells(self, bottom: float) -> list[tuple[float, float, fr.Rod]]:
        """Return the uniform parts of the string to a depth, from the lowest up: depths of their ends, and each rod."""
        parts, lower = [], bottom
        for section in self.rod.sections[::-1]:
            upper = max(lower - section.length, self.well.start)
            edges = [bore.depth for bore in self.rod.bores if upper < bore.depth < lower]
            for a, b in itertools.pairwise(sorted([upper, *edges, lower])[::-1]):
                diameters = [bore.diameter for bore in self.rod.bores if bore.depth <= b]
                diameter = diameters[-1] if diameters else 2.0 * self.rod.channel_radius
                own = {name: getattr(section, name) for name in ("youngs_modulus", "density", "radius", "inner_radius")}
                fluids = {name: getattr(self.rod, name) for name in ("fluid_inside", "fluid_outside")}
                bent = self.rod.residual_curvature if a == bottom else 0.0
                rod = fr.Rod(**own, **fluids, length=10.0, channel_radius=0.5 * diameter, residual_curvature=bent)
                parts.append((b, a, rod))
            lower = upper
            if lower <= self.well.start:
                break
        return parts

    def chain(self, bottom: float) -> dict[float, float]:
        """Return the force of the string to a depth where its uniform parts meet, one after the other from below."""
        force, forces = self.far_force, {}
        for upper, lower, rod in self.cells(bottom):
            if math.isfinite(force):
                force = rod.mean_force(
                    self.well.part(upper, lower),
                    self.friction,
                    motion=self.motion,
                    helical=self.helical,
                    far_force=force,
                    depth=[upper],
                ).at_top
            forces[upper] = force
        return forces


def drawn(seed: int) -> Drawn:
    """Return a drawn string of two to six sections in one to three bores of a well that builds, turns and undulates."""
    rng = np.random.default_rng([51, seed])
    size = int(rng.integers(3, 7))
    measured = np.append(0.0, np.cumsum(rng.uniform(150.0, 500.0, size)))
    inclination = np.concatenate([[0.0, 0.0], np.sort(rng.uniform(0.2, 1.75, size - 1))])
    well = fr.WellPath(measured, inclination, rng.normal(0.0, 0.15, size + 1))
    count, bores = int(rng.integers(2, 7)), int(rng.integers(1, 4))
    lengths = rng.dirichlet(np.ones(count)) * well.end * rng.uniform(1.0, 1.3)
    sections = [
        fr.Section(
            radius=radius,
            inner_radius=radius * rng.uniform(0.2, 0.85),
            length=length,
            youngs_modulus=rng.uniform(0.5, 1.0) * 2.07e11,
            density=rng.uniform(4500.0, 8000.0),
            yield_strength=rng.uniform(200e6, 700e6),
        )
        for radius, length in zip(rng.uniform(0.012, 0.035, count), np.maximum(lengths, 1.0), strict=True)
    ]
    starts = np.append(0.0, np.sort(rng.uniform(0.1, 0.9, bores - 1)) * well.end)
    rod = fr.Rod(
        sections=sections,
        bores=[(start, rng.uniform(0.09, 0.25)) for start in starts.tolist()],
        fluid_inside=1000.0,
        fluid_outside=rng.uniform(1000.0, 1400.0),
        residual_curvature=0.1 * rng.integers(0, 2),
    )
    friction = [(0.0, rng.uniform(0.1, 0.6)), (0.5 * well.end, rng.uniform(0.1, 0.6))]
    motion, helical = ["pushed", "pushed", "pulled", "standing"][seed % 4], ["energy", "loading", "always"][seed % 3]
    return Drawn(rod, well, friction, motion, helical, rng.uniform(-5e3, 4e3))


@pytest.mark.slow
@pytest.mark.parametrize(
    "seeds", [range(depth_of_draws(24, 3)), pytest.param(range(24, 500), marks=pytest.mark.slow)], ids=str
)
def test_a_string_is_the_chain_of_its_uniform_parts(seeds: range) -> None:
    for seed in some(seeds, 40, 24):
        string = drawn(seed)
        for bottom in (string.well.end, 0.63 * string.well.end):
            chain = string.chain(bottom)
            along = string.mean_force(bottom, depth=list(chain))
            force = dict(zip(along.depth.tolist(), along.force.tolist(), strict=True))
            for at, expected in chain.items():
                assert force[at] == pytest.approx(expected, rel=1e-6, abs=1e-3), (seed, bottom, at)


def test_a_string_is_the_solution_of_its_equation() -> None:
    """By another integrator for the force itself, in one section after the other, of a string that is no helix."""
    inclination, mu, bottom = 1.2, 0.35, 2500.0
    well = fr.WellPath.straight(length=3000.0, inclination=inclination)
    far_force, points = -3e3, np.linspace(100.0, 2400.0, 12)
    along = STRING.mean_force(well, mu, motion="pulled", far_force=far_force, bottom=bottom, depth=points)
    edges, weights = [bottom - 5.0, bottom - 1205.0], [part.rod.weight_per_length for part in STRING.uniform_parts]

    def slope(s: float, _: Any) -> float:
        weight = weights[0] if s < edges[1] else weights[-2] if s < edges[0] else weights[-1]
        return float(weight * (math.cos(inclination) + mu * math.sin(inclination)))

    force, at = far_force, {}
    for low, high in itertools.pairwise([bottom, *edges, 0.0]):
        inside = np.array(sorted([s for s in points if high <= s < low] + [high])[::-1])
        solved = solve_ivp(
            lambda s, f: [slope(s - 1e-9, f)], (low, high), [force], method="DOP853", t_eval=inside, rtol=1e-11
        )
        at |= dict(zip(inside.tolist(), solved.y[0].tolist(), strict=True))
        force = solved.y[0, -1]
    for depth, found in zip(along.depth.tolist(), along.force.tolist(), strict=True):
        if depth in at:
            assert found == pytest.approx(at[depth], rel=1e-7)


@pytest.mark.slow
def test_equal_sections_are_a_uniform_rod_to_the_bit() -> None:
    pipe = {"fluid_inside": 1e3, "fluid_outside": 1e3}
    halves = [fr.Section("2.00x0.156 CT90", length=length) for length in ("2000m", "3000m")]
    string = fr.Rod(sections=halves, bores=[("0m", "4.778in"), ("1500m", "4.778in")], **pipe)
    uniform = fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length="5000m", **pipe)
    assert string.reach(WELL, 0.3, depth=[2000.0, 4000.0]).as_dict() == (
        uniform.reach(WELL, 0.3, depth=[2000.0, 4000.0]).as_dict()
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "seeds", [range(1), *(pytest.param(range(a, a + 20), marks=pytest.mark.slow) for a in range(1, 81, 20))], ids=str
)
def test_a_reach_is_the_deepest_depth_to_which_a_string_goes_through_all_before(seeds: range) -> None:
    """Forces at depths by the mean force, and the reach by a search over many depths, for lock-up and the push."""
    for seed in some(seeds, 5, 2):
        string = drawn(4 * seed)  # pushed
        push = [20e3, None][seed % 2]
        depths = np.linspace(0.05, 1.0, 12) * string.well.end
        found = string.rod.reach(
            string.well,
            string.friction,
            far_force=string.far_force,
            helical=string.helical,
            push=push,
            yield_share=None,
            depth=depths,
        )
        tops = np.array([string.mean_force(float(depth), depth=[0.0]).at_top for depth in depths])
        np.testing.assert_allclose(found.injector, tops, rtol=1e-6, atol=0.01)
        goes = np.logical_and.accumulate(np.isfinite(tops) & (tops <= (math.inf if push is None else push)))
        assert (depths[goes] <= found.reach).all()
        if not goes.all():
            assert found.is_stopped
            assert found.reach < depths[~goes][0]
            step = 2e-6 * string.well.end
            assert string.mean_force(found.reach, depth=[0.0]).at_top <= found.push
            beyond = string.mean_force(found.reach + step, depth=[0.0])
            assert beyond.is_locked or beyond.at_top > found.push * (1.0 - 1e-9)
        elif not found.is_stopped:
            assert found.reach == string.well.end


@pytest.mark.slow
def test_a_string_goes_no_deeper_than_it_is_long() -> None:
    found = STRING.reach(WELL, 0.1, yield_share=None)
    assert (found.limit, found.reach) == ("length of the string", 3205.0)
    assert not found.is_stopped
    assert "To 3,205 m, the length of the string." in repr(found)
    assert found.depth[-1] == 3205.0
    with pytest.raises(ValueError, match=r"^depth must be no deeper .* 3205 m long and ends at 3205 m, got 3206 m"):
        STRING.reach(WELL, 0.1, depth=["3206m"])
    with pytest.raises(ValueError, match=r"^bottom must be no deeper .* got 4000 m; give longer sections"):
        STRING.mean_force(WELL, 0.1)
    with pytest.raises(ValueError, match=r"^depth must be no deeper"):
        STRING.surface_weights(WELL, 0.1, depth=[3500.0])


def test_a_wide_section_passes_all_bores_above_it() -> None:
    """It fits into the bore where it ends, and not into one on the way, where it is refused only if it goes so deep."""
    narrow = [("0m", "4.778in"), ("800m", "2.5in"), ("1000m", "4.778in")]
    with pytest.raises(ValueError, match=r"bores must leave room for every section"):
        fr.Rod(sections=SECTIONS, bores=[("0m", "4.778in"), ("3203m", "2.5in")])
    string = fr.Rod(sections=SECTIONS, bores=narrow)
    assert string.mean_force(WELL, 0.2, bottom=790.0).at_top < 0.0
    with pytest.raises(
        ValueError,
        match=r"^bores must let every section pass on the way to 1800 m: section 3 \(2.875 in x 0.9375 in\) has "
        r"a diameter of 2.875 in, and the bore from 800 m on 2.5 in$",
    ):
        string.mean_force(WELL, 0.2, bottom=1800.0)
    with pytest.raises(ValueError, match=r"^bores must let every section pass"):
        string.reach(WELL, 0.2)


@pytest.mark.slow
def test_a_tool_shakes_sections_as_force_and_wave_integrated_together_say() -> None:
    """From the lower end up by another integrator, whose first velocity is sought so that the upper end is at rest."""
    inclination, mu, v, frequency, bottom, above_end = 1.35, 0.3, 0.05, 110.0, 700.0, 20.0
    sections = [
        fr.Section("2.00x0.156", length="500m"),
        fr.Section(diameter="2.2in", inner_diameter="1.5in", length="300m", youngs_modulus=1.1e11, density=4500.0),
        fr.Section(diameter="2.875in", inner_diameter="1in", length="15m"),
    ]
    string = fr.Rod(
        sections=sections,
        bores=[("0m", "4.778in"), ("300m", "6in")],
        fluid_inside=1e3,
        fluid_outside=1e3,
        damping_rate=0.3,
    )
    well = fr.WellPath.straight(length=1000.0, inclination=inclination)
    tool = fr.VibrationTool(6e3, frequency, above_end)
    points = np.linspace(20.0, 690.0, 14)
    along = string.mean_force(well, mu, far_force=-2e3, bottom=bottom, tool=tool, speed=v, depth=points)
    assert not along.is_helix.any()

    def slopes(_: float, state: Any, rod: Any) -> Any:
        _, p, q = state
        pressed, fast, m = mu * rod.weight_per_length * math.sin(inclination), abs(q), rod.mass_along
        left = 2.0 / math.pi * math.asin(v / max(fast, v))
        rubs = 4.0 / math.pi * pressed * math.sqrt(max(1.0 - (v / max(fast, v)) ** 2, 0.0)) / max(fast, v)
        damped = 1j * frequency * m + 2.0 * m * string.damping_rate + rubs
        return [
            left * pressed - rod.weight_per_length * math.cos(inclination),
            -damped * q,
            -1j * frequency * p / (rod.mass_along * rod.wave_speed**2),
        ]

    heights = [0.0, 15.0, above_end, 315.0, bottom]
    rods = [string.in_cell(number, 0) for number in (2, 1, 1, 0)]

    def integrated(first: Any) -> tuple[Any, dict[float, Any]]:
        """Return the velocity at the upper end, and the states at the points."""
        state, at = np.array([-2e3, 0.0, complex(*first)], complex), {}
        for (low, high), rod in zip(itertools.pairwise(heights), rods, strict=True):
            if low == above_end:
                state = state - np.array([0.0, tool.amplitude, 0.0])
            up = np.sort(np.append((bottom - points)[(bottom - points > low) & (bottom - points < high)], high))
            solved = solve_ivp(slopes, (low, high), state, args=(rod,), t_eval=up, rtol=1e-8, atol=1e-10)
            at |= dict(zip(up.tolist(), solved.y.T, strict=True))
            state = solved.y[:, -1]
        return [state[2].real, state[2].imag], at

    k = int(np.argmax(along.depth))
    first, _, is_found, _ = fsolve(
        lambda q: integrated(q)[0], [along.speed[k], 0.3 * along.speed[k]], xtol=1e-10, full_output=True
    )
    assert is_found == 1
    true = integrated(first)[1]
    for depth, force, speed, vibration in zip(along.depth, along.force, along.speed, along.vibration, strict=True):
        if depth in points:
            state = true[float(bottom - depth)]
            assert force == pytest.approx(state[0].real, abs=max(5.0, along.error))
            assert speed == pytest.approx(abs(state[2]), abs=5e-3 * along.speed.max())
            assert vibration == pytest.approx(abs(state[1]), abs=5e-3 * along.vibration.max())


@pytest.mark.slow
def test_a_reach_says_which_section_limits_it_and_where() -> None:
    """The weak one yields, although the other bears more; of helices that of the slender one takes most friction."""
    thin, thick = (
        fr.Section(name, length=length) for name, length in (("2.00x0.109", "2600m"), ("2.00x0.224", "600m"))
    )
    water = {"fluid_inside": 1e3, "fluid_outside": 1e3}
    string = fr.Rod(sections=[thin, thick], bores=[("0m", "4.778in"), ("1400m", "6.184in")], **water)
    found = string.reach(WELL, 0.4, depth=["3000m"])
    assert found.limit == "lock-up"
    assert found.limiting_section == found.as_dict()["limiting_section"] == 0
    assert "where it locks up, most by the helix of section 1 (2.00x0.109) from " in repr(found)
    only_snaking = replace(found, along=replace(found.along, is_helix=np.zeros_like(found.along.is_helix)))
    assert only_snaking.limiting_section is None
    assert repr(only_snaking).splitlines()[0].endswith("m, where it locks up.>")
    weak = fr.Section(diameter="2in", inner_diameter="1.6in", length="600m", yield_strength="30MPa")
    strong = fr.Section(diameter="2in", inner_diameter="1.7in", length="2600m", yield_strength="700MPa")
    found = fr.Rod(sections=[strong, weak], bores=[("0m", "4.778in")], **water).reach(WELL, 0.2, depth=["3000m"])
    assert (found.limit, found.limiting_section) == ("yield", 1)
    assert re.search(r"within 80 % of yield of section 2 \(2 in x 0.2 in\) at [\d,.]+ m; not", repr(found))
    assert re.search(r"at [\d,]+ m in section 2 \(2 in x 0.2 in\) when pushed to", str(found.report()))
    assert found.stress.yield_strength == 30e6
    assert found.stress.share_of_yield == pytest.approx(0.8, rel=0.05)
    assert found.yield_strength == 700e6


@pytest.mark.slow
def test_the_section_at_the_wellhead_bears_its_pressure() -> None:
    """Which is the lowest while the string goes in."""
    pressure, areas = 5e6, [math.pi * section.radius**2 for section in SECTIONS]
    for bottom, area in ((900.0, areas[1]), (3.0, areas[2]), (2000.0, areas[0]))[: depth_of_draws(3, 1)]:
        along = STRING.mean_force(WELL, 0.2, bottom=bottom, wellhead_pressure=pressure)
        assert along.wellhead == pytest.approx(pressure * area, rel=1e-12)
        weights = STRING.surface_weights(WELL, 0.2, depth=[bottom], wellhead_pressure=pressure)
        assert -weights.slack_off[0, 0] == pytest.approx(along.injector, rel=1e-6)
        reach = STRING.reach(WELL, 0.2, depth=[bottom], wellhead_pressure=pressure)
        assert reach.injector[0] == pytest.approx(along.injector, rel=1e-6)
        assert reach.wellhead_force == pytest.approx(pressure * area, rel=1e-12)


@pytest.mark.slow
def test_a_report_in_one_file_has_the_wellhead_of_a_string_of_several_sections(tmp_path: Path) -> None:
    reach = STRING.reach(WELL, 0.2, depth=[2000.0], wellhead_pressure=5e6, stripper="2kN")
    text = fr.save_report(reach, tmp_path / "reach.html").read_text()
    assert html.escape(dict(reach.report().lines)["wellhead"]) in text


FILE = """\
fluid_inside = "8.6ppg"
fluid_outside = "8.6ppg"
bores = [["0m", "4.778in"], ["1500m", "6.184in"]]
[[sections]]
name = "2.00x0.156 CT90"
length = "1200m"
[[sections]]
name = "2.00x0.203 CT90"
length = "600m"
[[sections]]
diameter = "2.875in"
inner_diameter = "1in"
length = "5m"
"""


@pytest.mark.slow
def test_the_terminal_answers_as_python_does(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, survey = tmp_path / "string.toml", tmp_path / "survey.csv"
    file.write_text(FILE)
    survey.write_text("MD (m),Inc (deg),Azi (deg)\n0,0,0\n500,0,0\n900,90,0\n3000,90,20\n")
    rod, well = fr.Rod.from_toml(file), fr.WellPath.from_csv(survey)
    asked = ["--well", str(survey), "--rod", str(file), "--friction", "0.2,0.45@700m", "--depths", "900m,1800m"]
    friction, depth = [(0.0, 0.2), ("700m", 0.45)], ["900m", "1800m"]
    for command, answer in (
        ("reach", rod.reach(well, friction, push="40kN", depth=depth)),
        ("weights", rod.surface_weights(well, [friction], depth=depth)),
    ):
        assert main([command, *asked, *(["--push", "40kN"] if command == "reach" else []), "--json"]) == 0
        told = json.loads(capsys.readouterr().out)
        assert {key: told[key] for key in told if key not in ("version", "written")} == answer.as_dict()
    assert main(["reach", *asked[:-1], "2000m"]) == 2
    assert "depth must be no deeper than the string reaches: it is 1805 m long" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("push", ["15kN", "60kN"])
def test_a_sample_reaches_a_depth_where_the_string_does(push: str) -> None:
    found = STRING.reach(WELL, 0.4, push=push, depth=[2000.0])
    share = fr.probability_of_reach(STRING, WELL, (0.4, 0.4 * (1.0 + 1e-12)), push=push, depth=[2000.0], samples=1)
    assert share.probability[0] == (not found.is_stopped)


@pytest.mark.parametrize(
    ("bottom", "above_end"),
    [("9000ft", "90ft"), pytest.param("10000ft", "4000.0000000000005ft", marks=pytest.mark.slow)],
)
def test_a_tool_bears_a_joint_that_rounding_sets_beside_an_end_or_the_tool(bottom: str, above_end: str) -> None:
    """Lengths of 4000 and 5000 ft and a depth of 9000 ft differ in metres by rounding: between them no piece fits."""
    names = {"2.00x0.204": "6000ft", "2.00x0.175": "5000ft", "2.00x0.156": "4000ft"}
    sections = [fr.Section(name, length=length) for name, length in names.items()]
    rod = fr.Rod(sections=sections, channel_diameter="4.67in", fluid_inside=1e3, fluid_outside=1e3)
    depths = 0.3048 * np.array([0.0, 3000.0, 4000.0, 14000.0])
    well = fr.WellPath(depths, ["0deg", "0deg", "80deg", "90deg"])
    tops = []
    for off in (-1e-3, 0.0, 1e-3):  # m
        tool = fr.VibrationTool("5kN", "16Hz", above_end)
        deep = 0.3048 * float(bottom.removesuffix("ft")) + off
        tops.append(rod.mean_force(well, 0.24, tool=tool, speed=0.1, bottom=deep).at_top)
    assert np.isfinite(tops).all()
    assert tops[1] == pytest.approx(0.5 * (tops[0] + tops[2]), abs=0.1)
