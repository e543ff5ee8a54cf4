"""What is proved of boxes: of Mathieu's equation, of loads and rods, of cells of maps; and the largest safe box."""

from __future__ import annotations

import math
import operator
import pickle
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod import methods
from floquetrod._util.interval import PI, RealInterval
from floquetrod.results import RegionProof
from tests.conftest import depth
from tests.coupled_cases import by_name
from tests.inside import RodBox, kind

ROD = fr.Rod.nitinol()
FORCE = ROD.critical_force
DAMPED = ROD.replace(damping_rate=0.5)
SAFE = {"mean": (0.33 * FORCE, 0.35 * FORCE), "amplitude": (0.19 * FORCE, 0.21 * FORCE), "frequency": (149.0, 151.0)}
"""Loads that are stable on the damped rod."""

FLOATS = st.floats(allow_nan=False, allow_infinity=False)


# --- intervals ---


@st.composite
def enclosed(draw: st.DrawFn) -> tuple[RealInterval, Fraction]:
    """Draw an interval and an exact number in it."""
    ends = sorted((draw(FLOATS), draw(FLOATS)))
    interval = RealInterval(*ends)
    share = Fraction(draw(st.integers(0, 16)), 16)
    return interval, Fraction(interval.low) + share * (Fraction(interval.high) - Fraction(interval.low))


@given(enclosed(), enclosed(), st.integers(0, 6))
def test_interval_arithmetic_encloses_exact_results(
    one: tuple[RealInterval, Fraction], other: tuple[RealInterval, Fraction], power: int
) -> None:
    (x, p), (y, q) = one, other
    for act in (operator.add, operator.sub, operator.mul):
        assert act(p, q) in act(x, y)
        assert act(p, Fraction(y.low)) in act(x, y.low)
        assert act(Fraction(y.low), p) in act(y.low, x)
    assert p**power in x**power
    assert -p in -x
    assert abs(p) in abs(x)
    root = abs(x).sqrt()
    assert Fraction(root.low) ** 2 <= abs(p)
    assert math.isinf(root.high) or abs(p) <= Fraction(root.high) ** 2
    if 0 in y:
        with pytest.raises(ZeroDivisionError):
            x / y
    else:
        assert p / q in x / y
        assert 1 / q in 1 / y


@given(st.fractions())
def test_an_exact_number_is_enclosed_by_neighbours(value: Fraction) -> None:
    found = RealInterval.of(value)
    assert value in found
    assert found.high <= math.nextafter(found.low, math.inf)


def test_intervals_are_rounded_outwards_where_doubles_are_not_exact() -> None:
    third = RealInterval.of(1.0) / 3
    assert third.low < Fraction(1, 3) < third.high
    assert RealInterval.of(0.1) + 0.2 != RealInterval.of(0.1 + 0.2)
    assert PI.low < Fraction("3.14159265358979323846") < PI.high
    assert RealInterval.of(10**400).low == math.nextafter(math.inf, 0.0)
    with pytest.raises(ValueError, match="low <= high"):
        RealInterval(1.0, math.nan)


# --- boxes of loads and rods ---


def random_question(rng: np.random.Generator) -> tuple[fr.Rod, dict[str, Any], float]:
    """Return a rod, a box of loads, in a third of the cases with tolerances of the rod, and a growth tolerance."""
    rod = ROD.replace(length=rng.uniform(1.0, 8.0), damping_rate=float(rng.choice([0.0, 0.05, 0.5, 5.0])))
    if rng.random() < 0.3:
        rod = rod.replace(inner_radius=0.3e-3, fluid_inside=1000.0, fluid_outside=900.0)
    force = rod.critical_force
    middle = {
        "mean": rng.uniform(-0.3, 1.0) * force,
        "amplitude": rng.uniform(0.01, 0.6) * force,
        "frequency": 10.0 ** rng.uniform(1.6, 2.5),
    }
    box: dict[str, Any] = {}
    for name, value in middle.items():
        half = abs(value) * 10.0 ** rng.uniform(-3.0, -0.7) * (rng.random() > 0.2)
        box[name] = (value - half, value + half)
    if rng.random() < 0.3:
        name = str(rng.choice(["length", "density", "youngs_modulus", "channel_radius", "radius", "damping_rate"]))
        value, half = getattr(rod, name), 10.0 ** rng.uniform(-4.0, -2.0)
        box["rod"] = {name: (value * (1.0 - half), value * (1.0 + half))}
    return rod, box, float(rng.choice([1e-6, 1e-3, 0.05, 0.5]))


def sampled(rng: np.random.Generator, rod: fr.Rod, box: dict[str, Any], loads: int) -> Any:
    """Yield rods of a box, each with loads of it, ends and corners among them."""
    for i in range(4 if "rod" in box else 1):
        numbers = {name: (ends[0], ends[1], rng.uniform(*ends))[i % 3] for name, ends in box.get("rod", {}).items()}
        shares = rng.random((loads, 3))
        shares[: loads // 4] = np.round(shares[: loads // 4])
        ends = np.array([box[name] for name in ("mean", "amplitude", "frequency")])
        yield rod.replace(**numbers), (ends[:, 0] + (ends[:, 1] - ends[:, 0]) * shares).T


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning")
def test_random_boxes_agree_with_the_verdicts_on_loads_and_rods_in_them(rng: np.random.Generator) -> None:
    statuses = []
    many = depth(150, 60)
    for _ in range(many):
        rod, box, tolerance = random_question(rng)
        proof = rod.certify(**box, growth_tolerance=tolerance, max_boxes=3000)
        statuses.append(proof.status)
        for each, loads in sampled(rng, rod, box, 200):
            stable = each.is_stable(**by_name(*loads), growth_tolerance=tolerance)
            assert proof.status != "stable" or stable.all(), (rod, box, tolerance)
            assert proof.status != "unstable" or not stable.any(), (rod, box, tolerance)
        for example in proof.examples:
            load = example.load
            found = example.rod.is_stable(
                mean=load.mean, amplitude=load.amplitude, frequency=load.frequency, growth_tolerance=tolerance
            )
            assert found == (example.status == "stable")
            assert all(box[n][0] <= getattr(load, n) <= box[n][1] for n in ("mean", "amplitude", "frequency"))
            assert all(a <= getattr(example.rod, n) <= b for n, (a, b) in box.get("rod", {}).items())
    assert {"stable", "unstable", "mixed"} <= set(statuses)
    assert statuses.count("undecided") <= 0.2 * many


@pytest.mark.slow
def test_loads_next_to_a_boundary_agree_with_many_digits() -> None:
    """The last box proved stable along the mean force, and the first proved unstable, a little apart."""
    tolerance = 0.05
    edge = next(iter(ROD.ranges("mean", amplitude=0.2 * FORCE, frequency=150.0, growth_tolerance=tolerance))).high
    below, above = edge * (1.0 - 1e-7), edge * (1.0 + 1e-7)
    inner = ROD.certify(
        mean=(edge * (1.0 - 1e-3), below), amplitude=0.2 * FORCE, frequency=150.0, growth_tolerance=tolerance
    )
    outer = ROD.certify(
        mean=(above, edge * (1.0 + 1e-3)), amplitude=0.2 * FORCE, frequency=150.0, growth_tolerance=tolerance
    )
    assert (inner.status, outer.status) == ("stable", "unstable")
    for mean, grows in ((below, False), (above, True)):
        system = ROD.modal_system(fr.AxialLoad(mean, 0.2 * FORCE, 150.0))
        rates = [methods.reference(equation).growth_rate * 150.0 for equation in system.equations]
        assert (max(rates) > tolerance) == grows


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::floquetrod.UniformForceWarning")
def test_most_boxes_with_a_margin_are_proved(rng: np.random.Generator) -> None:
    """Boxes whose enlargement by a hundredth of the values is stable on a dense sample."""
    proved = total = 0
    for _ in range(depth(300, 120)):
        rod, box, tolerance = random_question(rng)
        box.pop("rod", None)
        wide = {n: (a - 0.01 * abs(a), b + 0.01 * abs(b)) for n, (a, b) in box.items()}
        loads = next(iter(sampled(rng, rod, wide, 2000)))[1]
        if rod.is_stable(**by_name(*loads), growth_tolerance=tolerance).all():
            total += 1
            proved += rod.certify(**box, growth_tolerance=tolerance).status == "stable"
    assert total > depth(20, 8)
    assert proved >= 0.9 * total  # 0.95 of many; a sample that misses a thin tongue counts against it


def test_one_load_is_judged_as_by_stability() -> None:
    stable = ROD.certify(mean=0.34 * FORCE, amplitude=0.2 * FORCE, frequency=150.0, growth_tolerance=0.05)
    assert stable.stable is True
    assert stable.boxes == 1
    assert 0.0 < stable.left_out_bound <= 0.05
    unstable = ROD.certify(mean=0.2 * FORCE, amplitude=0.2 * FORCE, frequency=150.0)
    assert unstable.stable is False
    with pytest.raises(TypeError, match="stable"):
        bool(unstable)


def test_damping_decides_and_is_no_wider_than_given() -> None:
    rate = ROD.stability(fr.AxialLoad(0.2 * FORCE, 0.2 * FORCE, 150.0)).damping_to_stabilise
    load = {"mean": 0.2 * FORCE, "amplitude": 0.2 * FORCE, "frequency": 150.0, "growth_tolerance": 0.0}
    enough, short = rate * (1.0 + 1e-3), rate * (1.0 - 1e-3)
    assert ROD.certify(**load, rod={"damping_rate": (enough, 2.0 * rate)}).status == "stable"
    assert ROD.certify(**load, rod={"damping_rate": (0.5 * rate, short)}).status == "unstable"
    mixed = ROD.certify(**load, rod={"damping_rate": (short, enough)})
    assert mixed.status == "mixed"
    assert mixed.stable is None
    assert [example.status for example in mixed.examples] == ["stable", "unstable"]


def test_an_unstable_example_is_found_in_a_thin_tongue() -> None:
    part = next(gap for gap in _unstable(ROD, 1e-6) if 1e-7 < gap[1] - gap[0] < 1e-2 * FORCE and gap[1] < 0.9 * FORCE)
    width = part[1] - part[0]
    box = (part[0] - 20.0 * width, part[1] + 20.0 * width)
    proof = ROD.certify(mean=box, amplitude=0.2 * FORCE, frequency=150.0)
    assert proof.status == "mixed"
    unstable = proof.examples[1]
    assert part[0] <= unstable.load.mean <= part[1] or not ROD.is_stable(
        mean=unstable.load.mean, amplitude=0.2 * FORCE, frequency=150.0, growth_tolerance=1e-6
    )
    assert "grows faster than 1e-06 1/s" in unstable.statement


def _unstable(rod: fr.Rod, tolerance: float) -> list[tuple[float, float]]:
    found = list(rod.ranges("mean", amplitude=0.2 * FORCE, frequency=150.0, growth_tolerance=tolerance))
    return [(one.high, other.low) for one, other in pairwise(found)]


def test_without_damping_and_tolerance_nothing_wide_is_stable() -> None:
    proof = ROD.certify(**SAFE, growth_tolerance=0.0)
    assert proof.status == "undecided"
    assert "growth_tolerance=0" in proof.note
    wide = ROD.certify(
        mean=(0.19 * FORCE, 0.21 * FORCE), amplitude=0.2 * FORCE, frequency=(149.0, 151.0), growth_tolerance=0.0
    )
    assert wide.status == "unstable"


def test_work_is_bounded_and_told() -> None:
    calls: list[tuple[int, int]] = []
    proof = DAMPED.certify(
        **SAFE, rod={"length": (3.089, 3.111)}, max_boxes=5, progress=lambda done, total: calls.append((done, total))
    )
    assert proof.boxes < 40  # those of examples besides
    full = DAMPED.certify(
        mean=(0.3 * FORCE, 0.36 * FORCE),
        amplitude=(0.15 * FORCE, 0.21 * FORCE),
        frequency=(148.0, 152.0),
        rod={"length": (3.08, 3.12), "density": (6450.0, 6550.0)},
        max_boxes=300,
        progress=lambda done, total: calls.append((done, total)),
    )
    assert full.status == "undecided" or full.boxes < 400
    assert all(0 < done <= total for done, total in calls)
    assert 0.0 <= full.shares.stable <= 1.0


def test_interruption_ends_the_work() -> None:
    def stop(done: int, total: int) -> None:
        raise KeyboardInterrupt

    rate = ROD.stability(fr.AxialLoad(0.2 * FORCE, 0.2 * FORCE, 150.0)).damping_to_stabilise
    with pytest.raises(KeyboardInterrupt):
        ROD.certify(
            mean=0.2 * FORCE,
            amplitude=0.2 * FORCE,
            frequency=150.0,
            growth_tolerance=0.0,
            rod={"damping_rate": (rate, 2.0 * rate)},
            progress=stop,
        )


def test_tolerances_of_rods_in_diameters() -> None:
    one = DAMPED.certify(**SAFE, rod={"channel_diameter": (9.39e-3, 9.41e-3)})
    other = DAMPED.certify(**SAFE, rod={"channel_radius": (4.695e-3, 4.705e-3)})
    assert one == other
    assert one.status == "stable"
    assert one.box[3].name == "channel_radius"


def test_an_inclined_rod_needs_its_weight_neglected() -> None:
    inclined = DAMPED.replace(inclination=1.2)
    like = fr.AxialLoad(0.0, 0.0, 1.0, mean_at=None)
    with pytest.raises(ValueError, match=r"certify needs independent modes.*mean_at=None"):
        inclined.certify(**SAFE)
    proof = inclined.certify(like, **SAFE, rod={"inclination": (1.19, 1.21)})
    for angle in np.linspace(1.19, 1.21, 5):
        found = inclined.replace(inclination=angle).is_stable(
            like, mean=0.34 * FORCE, amplitude=0.2 * FORCE, frequency=150.0
        )
        assert proof.status == "mixed" or found == proof.stable
    assert "the weight along the rod is neglected" in proof.assumptions


@pytest.mark.parametrize("angle", [1e-3, 0.5, 1.0, 1.5, 0.5 * math.pi])
def test_the_sine_of_an_inclination_is_enclosed(angle: float) -> None:
    import mpmath

    rod = ROD.replace(inclination=angle)
    constants = RodBox.of(rod, fr.AxialLoad(0.0, 0.0, 1.0, mean_at=None), 0.1, 0.1, 1.0, None).constants()
    with mpmath.workdps(40):
        gravity, room = mpmath.mpf(rod.gravity), mpmath.mpf(rod.channel_radius) - mpmath.mpf(rod.radius)
        exact = gravity * mpmath.sin(mpmath.mpf(angle)) / room
        assert constants.restoring.low <= exact <= constants.restoring.high
    assert constants.restoring.width < 1e-13 * constants.restoring.high


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"mean": (2.0, 1.0)}, ValueError, "mean must not decrease"),
        ({"mean": (math.nan, 1.0)}, ValueError, r"mean\[0\] must be finite"),
        ({"mean": "much"}, ValueError, "mean must be a number with a force unit"),
        ({"mean": (1.0, 2.0, 3.0)}, TypeError, "a number or two"),
        ({"amplitude": (-0.1, 0.1)}, ValueError, "amplitude.* must be zero or more"),
        ({"frequency": (0.0, 10.0)}, ValueError, "frequency.* must be greater than zero"),
        ({"growth_tolerance": -1.0}, ValueError, "growth_tolerance must be zero or more"),
        ({"max_boxes": 0}, ValueError, "max_boxes must be 1 or more"),
        ({"progress": 3}, TypeError, "progress must be a function"),
        ({"rod": {"lenth": 3.0}}, ValueError, "must name parameters of a rod"),
        ({"rod": {"ends": "clamped"}}, ValueError, "not a number"),
        ({"rod": {"wall_thickness": 1e-4}}, ValueError, "give inner_radius"),
        ({"rod": {"radius": 1e-3, "diameter": 2e-3}}, ValueError, "once"),
        ({"rod": {"radius": (1e-3, 5e-3)}}, ValueError, "channel_radius must exceed"),
        ({"rod": {"fluid_outside": (0.0, 7000.0)}}, ValueError, "floats"),
        ({"rod": {"length": (-1.0, 1.0)}}, ValueError, "length must be greater than zero"),
        ({"rod": {"inclination": (1.0, 1.2)}}, ValueError, "independent modes"),
        ({"rod": [("length", 3.0)]}, TypeError, "mapping"),
        ({"mean": (0.0, 1e12)}, ValueError, "20000 modes"),
        ({"load": fr.AxialWave(0.0, 0.0, 1.0)}, ValueError, "axial waves"),
    ],
)
def test_refusals(changes: dict[str, Any], error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        DAMPED.certify(**(SAFE | changes))


def test_rods_with_coupled_modes_are_refused() -> None:
    with pytest.raises(ValueError, match=r"certify needs independent modes.*clamped ends"):
        DAMPED.replace(ends="clamped").certify(**SAFE)


# --- the largest safe box ---


@pytest.mark.slow
@pytest.mark.parametrize("tolerances", [{}, {"length": (3.098, 3.102)}])
def test_the_largest_safe_box_is_safe_and_cannot_be_widened(
    tolerances: dict[str, Any], rng: np.random.Generator
) -> None:
    load = fr.AxialLoad(0.34 * FORCE, 0.2 * FORCE, 150.0)
    calls: list[int] = []
    found = DAMPED.largest_safe_box(
        load, accuracy=0.05, rod=tolerances, progress=lambda done, total: calls.append(done)
    )
    assert found.proof.status == "stable"
    assert calls == sorted(calls)
    sides = {each.quantity: (each.low, each.high) for each in found.ranges}
    for quantity, (low, high) in sides.items():
        assert low < getattr(load, quantity) < high
        for wider in ((low - 0.3 * (high - low), high), (low, high + 0.3 * (high - low))):
            if tolerances or wider[0] < 0.0:  # with tolerances of the rod less work is allowed while searching
                continue
            box = sides | {quantity: wider}
            assert DAMPED.certify(**box, rod=tolerances, max_boxes=2000).status != "stable"
    for rod, loads in sampled(rng, DAMPED, {**sides, **({"rod": tolerances} if tolerances else {})}, 500):
        assert rod.is_stable(**by_name(*loads), growth_tolerance=1e-6).all()
    text = found.table(mean="Fcr", frequency="Hz")
    assert [line.split()[-1] for line in text.splitlines()[1:4]] == ["Fcr", "N", "Hz"]
    assert "no mode grows faster than 1e-06 1/s" in text
    assert ("length 3.098 to 3.102 m" in text) == bool(tolerances)


def test_what_does_not_vary_stays() -> None:
    load = fr.AxialLoad(0.34 * FORCE, 0.2 * FORCE, 150.0)
    found = DAMPED.largest_safe_box(load, vary=("mean",), accuracy=0.01)
    mean, amplitude, frequency = found.ranges
    assert amplitude.low == amplitude.high == load.amplitude
    assert frequency.low == frequency.high == load.frequency
    exact = next(
        part for part in DAMPED.ranges("mean", amplitude=load.amplitude, frequency=150.0) if load.mean in _range(part)
    )
    assert exact.low <= mean.low <= exact.low + 0.02 * (exact.high - exact.low)
    assert exact.high - 0.02 * (exact.high - exact.low) <= mean.high <= exact.high
    assert "fixed" in found.table()


def _range(part: Any) -> RealInterval:
    return RealInterval(part.low, part.high)


@pytest.mark.slow
def test_a_load_that_is_not_stable_has_no_safe_box() -> None:
    with pytest.raises(ValueError, match="load must be a load that is proved stable"):
        ROD.largest_safe_box(fr.AxialLoad(0.2 * FORCE, 0.2 * FORCE, 150.0))
    with pytest.raises(ValueError, match="vary must be one of"):
        ROD.largest_safe_box(fr.AxialLoad(0.2, 0.2, 150.0), vary=("force",))
    with pytest.raises(ValueError, match="vary must name"):
        ROD.largest_safe_box(fr.AxialLoad(0.2, 0.2, 150.0), vary=())
    with pytest.raises(TypeError, match="load must be"):
        ROD.largest_safe_box(0.2)
    with pytest.raises(ValueError, match="length must be one of"):
        DAMPED.largest_safe_box(fr.AxialLoad(0.34 * FORCE, 0.2 * FORCE, 150.0), accuracy=0.5).table(length="m")


# --- boxes of Mathieu's equation ---


@given(
    st.floats(-1.0, 1.0),
    st.floats(-3.0, 0.3),
    st.sampled_from([0.0, 0.01, 0.1]),
    st.floats(0.0, 0.2),
    st.floats(0.0, 0.2),
    st.sampled_from([0.0, 1e-3, 0.05]),
)
def test_boxes_of_mathieus_equation_agree_with_the_verdicts(
    alpha: float, beta: float, damping: float, wide: float, high: float, tolerance: float
) -> None:
    assume(wide or high)
    box = {"alpha": (alpha, alpha + wide), "beta": (beta, beta + high), "damping": (damping, 2.0 * damping)}
    proof = fr.certify(fr.Mathieu, **box, growth_tolerance=tolerance, max_boxes=500)
    assert isinstance(proof, RegionProof)
    a, b, c = (np.linspace(*ends, 7) for ends in box.values())
    growth = fr.mathieu.growth_rate(*np.meshgrid(a, b, c))
    stable = fr.mathieu.is_stable(*np.meshgrid(a, b, c)) if tolerance == 0.0 else growth <= tolerance
    if proof.status == "stable":
        assert stable.all()
    if proof.status == "unstable":
        assert not stable.any()
    for example in proof.examples:
        for name, (low, high_end) in box.items():
            assert low <= getattr(example.equation, name) <= high_end
        if example.status == "unstable":
            assert fr.stability(example.equation).growth_rate >= 0.999 * tolerance


def test_exact_ends_are_enclosed() -> None:
    edge = Fraction(-1, 4)  # for alpha = 0 tongue 1 begins there
    inside = fr.certify(fr.Mathieu, alpha=("1/10", Fraction(1, 5)), beta=("-0.27", "-0.23"))
    assert inside.status == "unstable"
    third = fr.certify(fr.Mathieu, alpha="1/3", beta=(-0.8, "-1/5"))
    assert third.status == "mixed"
    assert all(dict(example.exact)["alpha"] == Fraction(1, 3) for example in third.examples)
    assert fr.certify(fr.Mathieu, alpha=0, beta=(edge, "-0.1")).status == "stable"
    assert fr.certify(fr.Mathieu, alpha=0.3, beta=-0.25, growth_tolerance=0.5).status == "stable"


def test_sides_are_tuples_or_lists() -> None:
    for found in (
        fr.certify(fr.Mathieu, a=[1.9, 2.1], q=["0.8", "1.0"], damping=0),
        fr.certify(fr.Mathieu, a=(1.9, 2.1), q=["0.8", "1.0"]),
    ):
        assert found == fr.certify(fr.Mathieu, a=(1.9, 2.1), q=("0.8", "1.0"))
        assert found.box[0][:3] == ("a", 1.9, 2.1)
    for alpha, beta in ((0.4, [-0.8, -0.7]), ([0.4, 0.5], [-0.8, -0.7]), ((0.4, 0.5), [-0.8, -0.7])):
        ends = [tuple(side) if isinstance(side, list) else side for side in (alpha, beta)]
        found = fr.certify(fr.Mathieu, alpha=alpha, beta=beta)
        assert found == fr.certify(fr.Mathieu, alpha=ends[0], beta=ends[1])
        assert (found.box[1].low, found.box[1].high) == (-0.8, -0.7)
    for cosines in ((0.1, 0.2), [0.1, 0.2]):  # two numbers of one sequence
        for mean in ((-0.52, -0.5), [-0.52, -0.5]):
            found = fr.certify(fr.Hill, mean=mean, cosines=cosines)
            assert [side.name for side in found.box] == ["mean"]
            assert found.status == "stable"
    load = {"amplitude": 0.1 * FORCE, "frequency": [100.0, 101.0]}
    assert ROD.certify(mean=[0.1, 0.2], **load).box == ROD.certify(mean=(0.1, 0.2), **load).box


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: fr.certify(fr.Mathieu, a=[1.9, 2.0, 2.1], q=0.8), TypeError, "a must be a number or two"),
        (lambda: fr.certify(fr.Mathieu, a=np.array([1.9, 2.1]), q=0.8), TypeError, "a must be a real number"),
        (lambda: fr.certify(fr.Meissner, alpha=(0.5, 0.4), beta=-0.3), ValueError, "must not decrease"),
        (lambda: fr.certify(fr.Mathieu, alpha=(0.5, 0.4), beta=-0.3), ValueError, "must not decrease"),
        (lambda: fr.certify(fr.Mathieu, alpha=(0.4, 0.5)), TypeError, "beta must be given"),
        (lambda: fr.certify(fr.Mathieu, alpha=(0.4, 0.5), beta=0, gamma=1), TypeError, "gamma is not a parameter"),
        (lambda: fr.certify(fr.Mathieu, alpha=(0.4, 0.5), beta=0, damping=(-1, 0)), ValueError, "damping"),
        (lambda: fr.certify(fr.Mathieu, alpha=(0.4, "x"), beta=0), ValueError, r"alpha\[1\]"),
        (lambda: fr.certify(fr.Mathieu, alpha=(0.4, 1e10), beta=0), ValueError, "alpha"),
        (lambda: fr.certify(fr.Mathieu(0.4, -0.3), growth_tolerance=0.1), TypeError, "growth_tolerance"),
    ],
)
def test_refusals_of_equations(call: Any, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        call()


# --- maps ---


@pytest.fixture(scope="module")
def chart() -> fr.Chart:
    return fr.stability_map(
        ROD,
        mean=(0.0, 1.1 * FORCE, 40),
        amplitude=0.2 * FORCE,
        frequency=(20.0, 200.0, 50),
        growth_tolerance=0.05,
        certified=True,
    )


def test_every_cell_of_a_certified_map_agrees_with_loads_in_it(chart: fr.Chart, rng: np.random.Generator) -> None:
    x, y = chart.x.values, chart.y.values
    across, up = (np.concatenate([v[:1], 0.5 * (v[1:] + v[:-1]), v[-1:]]) for v in (x, y))
    assert chart.cells is not None
    j, i = (index.ravel() for index in np.indices(chart.cells.shape))
    shares = rng.random((2, 100, j.size))
    frequency = across[i] + shares[0] * (across[i + 1] - across[i])
    mean = up[j] + shares[1] * (up[j + 1] - up[j])
    stable = ROD.is_stable(mean=mean, amplitude=0.2 * FORCE, frequency=frequency, growth_tolerance=0.05)
    cells = chart.cells.ravel()
    assert stable[:, cells == 1].all()
    assert not stable[:, cells == 0].any()
    assert set(np.unique(cells)) <= {-1, 0, 1, 2}
    assert (cells == -1).mean() < 0.02
    crossed = (cells == 2) & (stable.min(axis=0) != stable.max(axis=0))
    assert crossed.any()  # where a boundary is proved, loads differ
    assert (chart.stable.ravel()[cells == 0] == 0).all()
    assert chart.stable.ravel()[cells == 1].all()


def test_a_certified_map_is_kept_drawn_and_described(chart: fr.Chart, tmp_path: Path) -> None:
    assert "proved stable" in chart.caption
    assert fr.Chart.load(chart.save(tmp_path / "chart.npz")) == chart
    assert chart.in_units(mean="Fcr").cells is chart.cells
    axes = chart.plot()
    assert axes.collections
    plain = fr.stability_map(ROD, mean=(0.0, 1.0, 3), amplitude=0.3, frequency=(20.0, 200.0, 4))
    assert plain.cells is None
    assert plain != chart


def test_damaged_cells_are_refused(chart: fr.Chart, tmp_path: Path) -> None:
    from dataclasses import replace

    assert chart.cells is not None
    wrong = replace(chart, cells=(chart.cells + 5).astype(np.int8))
    with pytest.raises(ValueError, match="cells must be"):
        fr.Chart.load(wrong.save(tmp_path / "chart.npz"))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"growth_tolerance": 0.0}, "certified needs a growth_tolerance above 0"),
        ({"friction": 0.1, "kick": 0.05}, "leave out either it or friction"),
        ({"criterion": fr.FiniteTimeCriterion(), "growth_tolerance": 0.0}, "leave out either it or criterion"),
        ({"load": fr.AxialWave(0.0, 0.0, 1.0)}, "certified needs independent modes"),
    ],
)
def test_maps_that_cannot_be_proved_are_refused(changes: dict[str, Any], words: str) -> None:
    plane: dict[str, Any] = {"mean": (0.0, 1.0, 3), "amplitude": 0.3, "frequency": (20.0, 200.0, 4)}
    with pytest.raises(ValueError, match=words):
        fr.stability_map(ROD, **(plane | {"growth_tolerance": 0.05} | changes), certified=True)


def test_kind_of_load_is_checked_before_numbers() -> None:
    box = RodBox.of(ROD, kind(None), *SAFE.values(), {"length": (3.0, 3.1)})
    assert [side.name for side in box.sides] == ["mean", "amplitude", "frequency", "length"]
    assert str(box.sides[3]) == "length 3 to 3.1 m"


@pytest.mark.slow
@given(
    st.fractions(-5, 20, max_denominator=1000),
    st.fractions(-5, 5, max_denominator=1000),
    st.fractions(0, 1, max_denominator=100),
    st.fractions(0, Fraction(1, 2), max_denominator=100),
)
def test_a_box_of_a_and_q_is_the_box_of_alpha_and_beta(a: Fraction, q: Fraction, k: Fraction, width: Fraction) -> None:
    """Its ends exactly, whatever their signs."""
    aq = fr.certify(fr.Mathieu, a=(a, a + width), q=(q, q + width), damping=k, max_boxes=200)
    alpha, beta = (q / 2, (q + width) / 2), (-(a + width) / 4, -a / 4)
    same = fr.certify(fr.Mathieu, alpha=alpha, beta=beta, damping=k / 2, max_boxes=200)
    assert isinstance(aq, RegionProof)
    assert isinstance(same, RegionProof)
    assert aq.growth_unit == "per z"
    in_tau = {"box": same.box, "examples": same.examples, "statement": same.statement, "growth_unit": "per tau"}
    assert replace(aq, **in_tau) == same  # type: ignore[arg-type]
    assert [each.equation for each in aq.examples] == [each.equation for each in same.examples]
    point = fr.certify(fr.Mathieu, a=a, q=str(q), damping=k)
    assert isinstance(point, fr.results.Proof)
    unscaled = fr.certify(fr.Mathieu, alpha=q / 2, beta=-a / 4, damping=k / 2)
    assert replace(point, exact=unscaled.exact) == unscaled


def test_what_is_asked_in_a_and_q_is_answered_in_them() -> None:
    found = fr.certify(fr.Mathieu, a=(1.9, 2.1), q=("0.8", "1.0"), damping=0.5)
    assert isinstance(found, RegionProof)
    assert [(side.name, side.low, side.high) for side in found.box] == [
        ("a", 1.9, 2.1),
        ("q", 0.8, 1.0),
        ("damping", 0.5, 0.5),
    ]
    assert "for every a 1.9 to 2.1, q 0.8 to 1, damping 0.5 no solution grows" in repr(found)
    mixed = fr.certify(fr.Mathieu, a=(0.9, 2.1), q=(0.2, 1.0))
    text = str(mixed.report())
    assert mixed.status == "mixed"
    assert text.count("a = ") == 2
    assert "alpha" not in text
    assert pickle.loads(pickle.dumps(mixed)) == mixed
    assert fr.certify(fr.Mathieu, a="1/3", q=1).exact == (("a", Fraction(1, 3)),)
    with pytest.raises(ValueError, match=r"^q must not decrease, got \(0\.7, 0\.68\); give the lower end first"):
        fr.certify(fr.Mathieu, a=(5.2, 5.3), q=(0.7, 0.68))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"a": 1.0}, "q must be given, a number or .* beside a"),
        ({"a": 1.0, "q": 1.0, "beta": 0.0}, "beta must be left out beside a and q"),
        ({"a": 1.0, "q": (1.0, 0.0)}, "q must not decrease"),
        ({"a": "x", "q": 1.0}, "a must be a number"),
    ],
)
def test_boxes_of_a_and_q_that_are_none(given: dict[str, Any], message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        fr.certify(fr.Mathieu, **given)


def test_a_rod_far_stiffer_than_its_load_is_quick() -> None:
    """Its first mode is thousands of times faster than the load: the bound of the others must not count them all."""
    stub = fr.Rod(youngs_modulus=2e11, density=7850.0, radius=0.02, length=0.5, channel_radius=0.05)
    proof = stub.certify(mean=(0.0, 2000.0), amplitude=(0.0, 1000.0), frequency=(0.5, 90.0))
    assert (proof.status, proof.modes, proof.boxes) == ("stable", 1, 1)
    assert 0.0 <= proof.left_out_bound < 1e-50
