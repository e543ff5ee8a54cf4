"""Cutters whose teeth are unevenly spaced, helical or of different lengths: against a semi-discretisation of numpy."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.floquet.status import STABLE, UNSTABLE
from floquetrod.milling.stability_lobes import critical_depths, judged
from tests.conftest import DEEP, depth, some
from tests.milling.semi_discretisation import Cut, growth_in_a_turn

MODE = fr.ToolMode("922Hz", 0.011, mass="39.93g")
PLAIN: dict[str, Any] = {"x": [MODE], "tangential": "600MPa", "radial": "200MPa"}
EVEN = fr.Milling(**PLAIN, teeth=4, immersion=0.3, direction="down")
UNEVEN = fr.Milling(**PLAIN, teeth=4, immersion=0.3, direction="down", pitch=["70deg", "110deg", "70deg", "110deg"])


def milling(**changed: Any) -> fr.Milling:
    return fr.Milling(**{**PLAIN, "teeth": 2, **changed})


def own_growth(mill: fr.Milling, speed: float, deep: float, steps: int) -> float:
    """Return the logarithm of the largest multiplier of a turn by the semi-discretisation."""
    modes = [
        (axis, mode.frequency, mode.damping_ratio, mode.mass) for axis, m in enumerate((mill.x, mill.y)) for mode in m
    ]
    lag = 2.0 * math.tan(mill.helix) / mill.diameter * deep if mill.diameter else 0.0
    half = math.acos(1.0 - 2.0 * mill.immersion)
    entry, leave = (0.0, half) if mill.direction == "up" else (math.pi - half, math.pi)
    return growth_in_a_turn(
        Cut(
            modes,
            list(mill.pitch),
            list(mill.runout),
            mill.feed_per_tooth or 1e-4,
            (mill.tangential, mill.radial),
            entry,
            leave,
            lag,
            speed,
            deep,
        ),
        steps,
    )


def drawn(rng: np.random.Generator) -> tuple[fr.Milling, float, float]:
    """Return a cutter, a speed and a depth, about the least one at which it chatters."""
    teeth = int(rng.integers(1, 6))
    spread = rng.uniform(0.7, 1.3, teeth) if rng.random() < 0.6 else np.ones(teeth)
    if teeth % 2 == 0 and rng.random() < 0.4:
        spread = np.tile(spread[: teeth // 2], 2)
    feed = rng.uniform(0.02, 0.2)
    uneven: dict[str, Any] = {}
    if rng.random() < 0.6:
        uneven = {"helix": f"{rng.uniform(5.0, 50.0)}deg", "diameter": f"{rng.uniform(4.0, 30.0)}mm"}
    if rng.random() < 0.5:
        sizes = rng.uniform(0.0, feed * rng.choice([0.3, 1.0, 3.0]), teeth)
        uneven |= {"runout": [f"{size}mm" for size in sizes], "feed_per_tooth": f"{feed}mm"}
    modes = [
        fr.ToolMode(f"{rng.uniform(400, 1500)}Hz", rng.uniform(0.01, 0.05), mass=f"{rng.uniform(20, 200)}g")
        for _ in range(rng.integers(1, 4))
    ]
    along = int(rng.integers(0, len(modes) + 1))
    mill = fr.Milling(
        x=modes[:along],
        y=modes[along:],
        teeth=teeth,
        tangential="600MPa",
        radial=f"{rng.uniform(50, 400)}MPa",
        immersion=rng.choice([1.0, 0.5, 0.2, 0.05]) * rng.uniform(0.8, 1.0),
        direction=str(rng.choice(["up", "down"])),
        pitch=[f"{angle}deg" for angle in 360.0 * spread / spread.sum()],
        **uneven,
    )
    speed = min(mode.frequency for mode in modes) / rng.uniform(2.0, 12.0)
    least = min(2.0 * mode.damping_ratio * mode.stiffness for mode in modes) / 6e8
    return mill, speed, min(least * rng.uniform(0.5, 8.0), 0.02)


def require_agreement(mill: fr.Milling, speed: float, deep: float) -> float:
    """Require the growth and the verdict of the semi-discretisation; return the difference of growth."""
    quick = judged(mill, np.array([speed]), np.array([deep]), growth=True)
    turn = round(2.0 * math.pi / mill.cycle)
    vibrations = max(mode.frequency for mode in mill.modes) / speed
    steps = max(240, 40 * math.ceil(vibrations))
    coarse, fine = (own_growth(mill, speed, deep, steps * times) for times in (1, 2))
    own = fine + (fine - coarse) / 3.0
    error = abs(fine - coarse) + 5e-4 * (1.0 + abs(own))
    growth = turn * float(quick.growth[0])
    assert abs(growth - own) < error, (mill.in_words(), speed, deep, growth, own, error)
    if abs(own) > error:
        assert quick.status[0] == (UNSTABLE if own > 0.0 else STABLE)
    return abs(growth - own)


@pytest.mark.slow
def test_drawn_cutters_grow_as_a_semi_discretisation_says() -> None:
    rng = np.random.default_rng(54)
    for _ in range(depth(10, 3)):
        require_agreement(*drawn(rng))


@pytest.mark.slow
def test_a_hundred_drawn_cutters_grow_as_a_semi_discretisation_says() -> None:
    rng = np.random.default_rng(541)
    for cutter in some([drawn(rng) for _ in range(100)], 33, 10):
        require_agreement(*cutter)


@pytest.mark.parametrize(
    "uneven",
    [
        pytest.param({"teeth": 4, "pitch": ["70deg", "110deg", "70deg", "110deg"]}, marks=pytest.mark.slow),
        pytest.param({"teeth": 3, "pitch": ["100deg", "120deg", "140deg"]}, marks=pytest.mark.slow),
        pytest.param({"helix": "30deg", "diameter": "12mm"}, marks=pytest.mark.slow),
        {"runout": ["0um", "30um"], "feed_per_tooth": "0.05mm"},
    ],
)
def test_equations_and_quick_verdicts_agree(uneven: dict[str, Any]) -> None:
    mill = milling(**uneven, immersion=0.5, direction="down", y=[fr.ToolMode("1.1kHz", "1.2%", stiffness="2.4N/um")])
    verdict = mill.stability(950.0, 1.1e-3)
    log = judged(mill, np.array([950.0]), np.array([1.1e-3]), growth=True).growth[0]
    assert verdict.period == pytest.approx(mill.cycle / 950.0, rel=1e-12)
    assert log / verdict.period == pytest.approx(verdict.exponents[0].real, abs=1e-6 / verdict.period)


@pytest.mark.slow
def test_even_teeth_that_are_spelled_out_are_those_of_a_plain_cutter() -> None:
    spelled = milling(teeth=3, pitch=["120deg"] * 3, runout=["5um"] * 3, helix="0deg", feed_per_tooth="0.1mm")
    plain = milling(teeth=3)
    rounded = milling(teeth=3, pitch=["119.9999deg", "120.0001deg", "120deg"])
    assert repr(spelled) == repr(plain) == repr(rounded)
    for mill in (spelled, rounded):
        assert mill.pitch == plain.pitch
        assert mill.critical_depth("7000rpm") == plain.critical_depth("7000rpm")
        assert mill.system("7000rpm", "1mm") == plain.system("7000rpm", "1mm")


def test_pitches_that_repeat_are_judged_over_what_repeats() -> None:
    assert math.degrees(UNEVEN.cycle) == pytest.approx(180.0, rel=1e-14)
    assert [math.degrees(angle) for angle in UNEVEN.delays] == pytest.approx([70.0, 110.0])
    whole = fr.Milling(
        **PLAIN, teeth=4, immersion=0.3, direction="down", pitch=["70deg", "110deg", "70.01deg", "109.99deg"]
    )
    assert whole.cycle == 2.0 * math.pi
    assert whole.critical_depth("7000rpm") == pytest.approx(UNEVEN.critical_depth("7000rpm"), rel=1e-2)


def test_a_tooth_far_behind_cuts_nothing_and_the_other_cuts_two_pitches() -> None:
    lame = milling(runout=["0um", "60um"], feed_per_tooth="0.05mm", immersion=0.5)
    single = milling(teeth=1, immersion=0.5)
    assert lame.delays == (2.0 * math.pi,)
    assert lame.critical_depth("7000rpm") == pytest.approx(single.critical_depth("7000rpm"), rel=1e-9)
    both = milling(runout=["0um", "10um"], feed_per_tooth="0.05mm", immersion=0.5)
    assert both.delays == (math.pi, 2.0 * math.pi)  # while chips are thin
    assert {arc.tooth for arc in both.arcs} == {0, 1}


@pytest.mark.slow
def test_little_runout_and_little_helix_change_little() -> None:
    plain = milling(immersion=0.3, direction="down")
    for uneven in (
        {"runout": ["0um", "0.001um"], "feed_per_tooth": "0.2mm"},
        {"pitch": ["179.999deg", "180.001deg"]},
    ):
        mill = milling(immersion=0.3, direction="down", **uneven)
        assert mill.critical_depth("7000rpm") == pytest.approx(plain.critical_depth("7000rpm"), rel=1e-3)


def test_little_helix_changes_little() -> None:
    for speed, deep in ((500.0, 3e-4), (700.0, 9e-4), (900.0, 1.5e-3)):
        growths = [
            judged(mill, np.array([speed]), np.array([deep]), growth=True).growth[0]
            for mill in (
                EVEN,
                fr.Milling(**PLAIN, teeth=4, immersion=0.3, direction="down", helix=1e-4, diameter=0.012),
            )
        ]
        assert growths[1] == pytest.approx(growths[0], abs=1e-4)


def test_a_helix_that_winds_over_a_pitch_makes_cutting_constant() -> None:
    """The edges of a slot's cutter then cover all angles evenly, and nothing varies but what regenerates."""
    mill = milling(teeth=4, helix="45deg", diameter="10mm")
    deep = math.pi / 4.0 * 0.01  # over which an edge lags by one pitch
    system = mill.system("9000rpm", deep)
    values = np.array([system.present.coefficient(np.array([t]))[0, 0, 0] for t in np.linspace(0.0, system.period, 9)])
    assert np.ptp(values) < 1e-8 * np.abs(values).max()


def test_modes_of_a_direction_add_up() -> None:
    """Twin modes of twice the mass move the tip as one mode does."""
    twins = milling(x=[fr.ToolMode("922Hz", 0.011, mass="79.86g")] * 2, teeth=3, immersion=0.5)
    assert twins.critical_depth("7000rpm") == pytest.approx(milling(teeth=3, immersion=0.5).critical_depth("7000rpm"))


@pytest.mark.slow
@pytest.mark.parametrize("helical", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_critical_depths_separate_verdicts(helical: bool) -> None:
    uneven = milling(teeth=3, pitch=["100deg", "120deg", "140deg"], helix="30deg", diameter="12mm", immersion=0.5)
    for mill in (uneven,) if helical else (UNEVEN,):
        speeds = np.array([700.0, 900.0])
        for speed, deep in zip(speeds, critical_depths(mill, speeds), strict=True):
            assert [mill.stability(speed, deep * (1.0 + by)).status for by in (-1e-5, 1e-5)] == ["stable", "unstable"]


@pytest.mark.slow
def test_lobes_of_uneven_teeth_agree_with_single_verdicts() -> None:
    helical = milling(teeth=4, pitch=["70deg", "110deg"] * 2, helix="30deg", diameter="12mm", immersion=0.3)
    for mill in (UNEVEN, helical) if DEEP else (UNEVEN,):
        lobes = mill.lobes(("6000rpm", "9000rpm", 6), ("0.2mm", "3mm", 4))
        rng = np.random.default_rng(6)
        for i, j in zip(rng.integers(0, 4, 3), rng.integers(0, 6, 3), strict=True):
            verdict = mill.stability(float(lobes.speeds[j]), 1e-3 * float(lobes.chart.y.values[i]))
            assert (verdict.status == "stable") == bool(lobes.chart.stable[i, j])


@pytest.mark.slow
@pytest.mark.parametrize("helical", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_bands_of_uneven_teeth_lie_on_the_boundary(helical: bool) -> None:
    bent = {"helix": "30deg", "diameter": "12mm"} if helical else {}
    mill = milling(teeth=4, pitch=["80deg", "100deg", "85deg", "95deg"], immersion=0.5, **bent)
    lobes = mill.lobes(("10000rpm", "12000rpm", 5), ("0mm", "2mm", 4), growth=True)
    bands, rate = lobes.chart.find_bands(0.03), lobes.chart.growth_rate
    assert rate is not None
    assert rate.min() == 0.0
    for band in bands:
        inner = (band.y < 1.999) & (band.x > 10001.0) & (band.x < 11999.0)
        speeds, depths = band.x[inner] * math.pi / 30.0, 1e-3 * band.y[inner]
        slope = judged(mill, speeds, depths * 1.001, growth=True).growth
        logs = judged(mill, speeds, depths, growth=True).growth
        assert np.abs(logs).max() < (2e-5 if helical else 1e-6)
        assert np.abs(logs / (slope - logs)).max() < 0.1  # of a thousandth of a depth


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"pitch": "70deg"}, "pitch must be"),
        ({"pitch": ["180deg"]}, "pitch must have one value for each of 2 teeth, got 1"),
        ({"pitch": ["170deg", "180deg"]}, r"pitch must add up to 360 deg, got 350 deg"),
        ({"pitch": [170, 190]}, r"pitch\[0\] must"),
        (
            {"pitch": [1.0, 2.0]},
            r'pitch must add up to 360 deg, got 171.887 deg; a number alone is in rad, write "1deg"',
        ),
        ({"pitch": ["0deg", "360deg"]}, r"pitch\[0\] must"),
        ({"pitch": ["170mm", "190mm"]}, r"pitch\[0\] must be a number with a angle unit"),
        ({"helix": "30deg"}, 'diameter must be given with a helix, which winds around it: diameter="12mm"'),
        ({"helix": "-30deg", "diameter": "12mm"}, "helix must"),
        ({"helix": "85deg", "diameter": "12mm"}, "helix must"),
        ({"helix": "30deg", "diameter": "0mm"}, "diameter must"),
        ({"runout": "10um"}, "runout must be"),
        ({"runout": ["0um", "10um"]}, "feed_per_tooth must be given with runout"),
        (
            {"runout": ["0um", "5um", "7um"], "feed_per_tooth": "0.1mm"},
            "runout must have one value for each of 2 teeth",
        ),
        ({"runout": ["0um", "5m"], "feed_per_tooth": "0.1mm"}, r"runout\[1\] must"),
        ({"runout": ["0um", "5um"], "feed_per_tooth": "0mm"}, "feed_per_tooth must"),
        ({"runout": ["0um", math.nan], "feed_per_tooth": "0.1mm"}, r"runout\[1\] must"),
    ],
)
def test_bad_teeth_have_one_clear_error(given: dict[str, Any], message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message) as error:
        milling(**given)
    assert "\n" not in str(error.value)


def test_a_depth_over_which_a_helix_winds_many_times_is_refused() -> None:
    mill = milling(helix="60deg", diameter="2mm")
    with pytest.raises(ValueError, match=r"depth must be at most .* winds around the cutter 4 times"):
        mill.stability("9000rpm", "50mm")
    with pytest.raises(ValueError, match="at most"):
        mill.critical_depth("9000rpm", most="40mm")
