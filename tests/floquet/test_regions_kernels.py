"""Compiled proofs over boxes: never wrong against independent computations, and rarely silent."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

import floquetrod as fr
from floquetrod._util.compilation import compiled
from floquetrod.floquet.kernels import mathieu_discriminant
from floquetrod.floquet.kernels.mathieu_discriminant import undamped_growth
from floquetrod.floquet.proof.kernels import double_intervals, regions, regions_boxes, regions_excess, regions_modes
from floquetrod.floquet.proof.kernels.double_intervals import Pair
from floquetrod.floquet.status import STABLE, UNDECIDED, UNSTABLE
from floquetrod.methods import discriminant_excess
from tests.conftest import JIT, depth, needs_jit
from tests.coupled_cases import by_name
from tests.inside import count_below, mode_constants
from tests.seams import Tuned

pytestmark = pytest.mark.kernels
in_python_anyway = pytest.mark.skipif(not JIT, reason="calls kernels as the Python they are with the compiler, too")

Floats = NDArray[np.float64]

OPERATIONS: dict[str, tuple[Callable[[Pair, Pair], Pair], Callable[[Fraction, Fraction], Fraction]]] = {
    "add": (double_intervals.add, lambda x, y: x + y),
    "subtract": (double_intervals.subtract, lambda x, y: x - y),
    "multiply": (double_intervals.multiply, lambda x, y: x * y),
    "divide": (double_intervals.divide, lambda x, y: x / y),
    "square": (lambda x, _: double_intervals.square(x), lambda x, _y: x * x),
}


def doubles(rng: np.random.Generator, n: int) -> list[float]:
    """Return random doubles of every kind: of all sizes, subnormal, whole, zeros of both signs."""
    size = 2.0 ** rng.choice([rng.uniform(-1074, -1000, n), rng.uniform(-3, 3, n), rng.uniform(500, 1000, n)])
    values = rng.choice([-1.0, 1.0], n) * size * rng.uniform(1.0, 2.0, n)
    values = np.where(rng.random(n) < 0.1, np.round(rng.uniform(-5, 5, n)), values)
    return [float(v) for v in np.where(rng.random(n) < 0.03, -0.0, values)]


def misses(name: str, seed: int = 0, draws: int = depth(3000, 600)) -> int:
    """Return how often an operation's enclosure, where it is finite, leaves out an exact result."""
    operation, exact = OPERATIONS[name]
    rng = np.random.default_rng(seed)
    wrong = 0
    for _ in range(draws):
        a, b = sorted(doubles(rng, 2))
        c, d = sorted(doubles(rng, 2))
        if rng.random() < 0.5:
            b, d = a, c
        low, high = operation((a, b), (c, d))
        if not (math.isfinite(low) and math.isfinite(high)):
            continue
        for x in (a, b, min(max(0.5 * a + 0.5 * b, a), b)):
            for y in (c, d, min(max(0.5 * c + 0.5 * d, c), d)):
                value = exact(Fraction(x), Fraction(y))
                wrong += not Fraction(low) <= value <= Fraction(high)
    return wrong


@pytest.mark.parametrize("name", OPERATIONS)
def test_operations_enclose_the_exact_result(name: str) -> None:
    assert misses(name) == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", OPERATIONS)
def test_without_the_outward_step_they_would_not(name: str, tuned: Tuned) -> None:
    tuned(unit_of_rounding=0.0, smallest_step_outwards=0.0)
    assert misses(name) > 100


def test_what_is_not_finite_is_never_a_bound() -> None:
    for a, b in ((math.nan, 1.0), (0.0, math.nan), (-math.inf, 1.0), (1.0, math.inf)):
        for operation, _ in OPERATIONS.values():
            low, high = operation((a, b), (1.0, 2.0))
            assert not (low > -math.inf and high < math.inf)
    assert all(map(math.isnan, double_intervals.divide((1.0, 1.0), (-1.0, 1.0))))
    assert all(map(math.isnan, double_intervals.divide((1.0, 1.0), (0.0, 1.0))))


def test_exponential_and_hyperbolic_sine_enclose() -> None:
    rng = np.random.default_rng(3)
    with mpmath.workdps(50):
        for x in [*rng.uniform(-600, 600, 300), *(10.0 ** rng.uniform(-18, 0, 300)), 0.0, 1.0]:
            low, high = double_intervals.exp(float(x))
            assert low <= mpmath.exp(mpmath.mpf(float(x))) <= high
            assert high - low <= 1e-12 * high
        for x in [*rng.uniform(0, 300, 300), *(10.0 ** rng.uniform(-18, 0, 300)), 0.0, 0.5, 0.4999999999999999]:
            low, high = double_intervals.sinh_squared(float(x))
            assert low <= mpmath.sinh(mpmath.mpf(float(x))) ** 2 <= high
            assert high - low <= 1e-12 * high + 1e-300
    assert math.isnan(double_intervals.exp(700.0)[0])
    assert math.isnan(double_intervals.sinh_squared(-1.0)[0])


def random_equation(rng: np.random.Generator) -> tuple[float, float]:
    """Return a and q, from buckled to stiff and from unforced to strongly forced."""
    return float(rng.uniform(-20.0, 400.0)), float(10.0 ** rng.uniform(-6.0, math.log10(200.0)))


@pytest.mark.slow
def test_excess_encloses_and_both_add_up_to_minus_one() -> None:
    rng = np.random.default_rng(5)
    excess = compiled(regions_excess.excess)
    tight = 0
    for _ in range(600):
        a, q = random_equation(rng)
        omega = float(10.0 ** rng.uniform(-1.0, 2.0))
        kappa, p = 0.25 * a * omega**2, 0.5 * q * omega**2
        both = [excess((kappa, kappa), (p, p), (omega, omega), parity) for parity in (0, 1)]
        (el, eh), (ol, oh) = both
        assert el + ol <= -1.0 + 1e-9 * abs(el)
        assert eh + oh >= -1.0 - 1e-9 * abs(eh)
        sign, x, exponent, _, _ = mathieu_discriminant.discriminant_excess(0.5 * q, -0.25 * a, 0.0)
        value = math.ldexp(x, exponent)
        for low, high, true in (
            (el, eh, value if sign > 0 else -1.0 - value),
            (ol, oh, value if sign < 0 else -1.0 - value),
        ):
            slack = 1e-9 * (abs(true) + 1e-3)  # a and q are not exactly those of the box
            assert low - slack <= true <= high + slack
            tight += high - low <= 1e-3 * abs(true)
    assert tight > 800


def test_excess_against_many_digits() -> None:
    rng = np.random.default_rng(6)
    excess = compiled(regions_excess.excess)
    for _ in range(depth(25, 12)):
        alpha, beta = float(10.0 ** rng.uniform(-3.0, 1.0)), float(rng.uniform(-30.0, 2.0))
        exact = discriminant_excess(fr.Mathieu(alpha, beta), 30)
        true = exact.excess, -1 - exact.excess
        for parity, value in enumerate(true if exact.sign > 0 else true[::-1]):
            low, high = excess((-beta, -beta), (alpha, alpha), (1.0, 1.0), parity)
            assert low <= value <= high


def growth_at(kappa: float, p: float, omega: float) -> float:
    """Return the growth rate in 1/s of u'' + (kappa - p sin omega t) u = 0, NaN beside a boundary."""
    if p == 0.0:
        return math.sqrt(max(-kappa, 0.0))
    return float(undamped_growth(p / omega**2, -kappa / omega**2, 0.0)) * omega


ModeNumbers = tuple[tuple[float, float], ...]


def random_mode_box(rng: np.random.Generator) -> ModeNumbers:
    """Return a box of one mode (kappa, p, omega) and a level."""
    a, q = random_equation(rng)
    exact = rng.random() < 0.5  # divided by a power of two, kappa and p lose no digit
    omega = float(2.0 ** rng.integers(-2, 7) if exact else 10.0 ** rng.uniform(-1.0, 2.5))
    kappa, p = 0.25 * a * omega**2, 0.5 * q * omega**2
    widths = 10.0 ** rng.uniform(-12.0, 0.0) * rng.choice([0.0, 1.0, 1.0], 3) * rng.uniform(0.1, 1.0, 3)
    level = float(rng.choice([0.0, omega * 10.0 ** rng.uniform(-8.0, 0.0)]))
    size = max(abs(kappa), p)
    return (
        (kappa, float(kappa + widths[0] * 0.25 * size)),
        (p, float(p + widths[1] * p)),
        (omega, omega if exact else float(omega * (1.0 + 0.3 * widths[2]))),
        (level, level),
    )


def points_of(rng: np.random.Generator, box: ModeNumbers, n: int) -> list[tuple[float, float, float]]:
    """Return corners and random points of a box (kappa, p, omega)."""
    kappa, p, omega = box[:3]
    inner = [(float(rng.uniform(*kappa)), float(rng.uniform(*p)), float(rng.uniform(*omega))) for _ in range(n)]
    return [*itertools.product(kappa, p, omega), *inner]


def check_answer(status: int, box: ModeNumbers, points: list[tuple[float, float, float]]) -> None:
    """Compare an answer with growth and counts in doubles, which may err by rounding only."""
    level = box[3][0]
    for kappa, p, omega in points:
        growth = growth_at(kappa, p, omega)
        if status == STABLE:
            assert growth <= level * (1.0 + 1e-9) + 3e-8 * omega, (box, kappa, p, omega)
        else:
            assert growth >= level * (1.0 - 1e-9) - 3e-8 * omega, (box, kappa, p, omega)
        if level == 0.0 and p > 0.0 and growth > 1e-6 * omega:
            assert status == UNSTABLE
            assert count_below(4.0 * kappa / omega**2, 2.0 * p / omega**2) % 2 == 0


def test_answers_about_a_mode_are_true() -> None:
    rng = np.random.default_rng(7)
    mode_status = compiled(regions_modes.mode_status)
    growth = compiled(undamped_growth)
    found = {STABLE: 0, UNSTABLE: 0, UNDECIDED: 0}
    nearest: list[tuple[float, int, float, tuple[float, float, float]]] = []
    for _ in range(many := 400 if JIT else 120):
        box = random_mode_box(rng)
        status = mode_status(*box)
        found[status] += 1
        if status == UNDECIDED:
            continue
        points = points_of(rng, box, 6)
        check_answer(status, box, points)
        for kappa, p, omega in points:
            if p > 0.0 and math.frexp(omega)[0] == 0.5:
                rate = growth(p / omega**2, -kappa / omega**2, 0.0) * omega
                nearest.append((abs(rate - box[3][0]) / omega, status, box[3][0], (kappa, p, omega)))
    assert found[STABLE] > many // 4
    assert found[UNSTABLE] > many // 14
    assert found[UNDECIDED] < 2 * many // 5
    nearest.sort()
    for _, status, level, point in nearest[:12]:
        assert judged_by_reference(level, *point) == status, (level, point)


def judged_by_reference(level: float, kappa: float, p: float, omega: float) -> int:
    """Return the answer at a point by 30 digits; ``omega`` is a power of two, so that no digit is lost."""
    exact = discriminant_excess(fr.Mathieu(p / omega**2, -kappa / omega**2), 30)
    with mpmath.workdps(40):
        allowed = mpmath.sinh(mpmath.pi * mpmath.mpf(level) / omega) ** 2
        assert abs(exact.excess - allowed) > exact.error
        return UNSTABLE if exact.excess > allowed else STABLE


CROWDED = [(order, q) for order in range(8) for q in (0.5, 1.0, 3.0, 7.3, 20.0)]


def true_count(a: float, q: float) -> int:
    """Return how many characteristic values lie below a, from pivots with 60 digits."""
    with mpmath.workdps(60):
        x, g = mpmath.mpf(a), mpmath.mpf(q)
        total = 0
        for first, shift, factor in ((0, 0, 2), (2, 0, 1), (1, g, 1), (1, -g, 1)):
            pivot = first**2 - x + shift
            for k in range(first + 2, first + 120, 2):
                total += pivot < 0
                pivot = k * k - x - factor * g * g / pivot
                factor = 1
        return int(total)


def wrong_beside_boundaries() -> tuple[int, int]:
    """Return how many doubles at and beside characteristic values are misjudged, and how many judged at all.

    With omega = 2 the equation has a = kappa, and q = p / 2 exactly.
    """
    wrong = judged = 0
    for order, q in CROWDED:
        for name in "ab" if order else "a":
            value = float(fr.mathieu.characteristic_values(order, q, name))
            for step in range(-6, 7):
                a = value + step * np.spacing(value)
                status = regions_modes.mode_status((a, a), (2.0 * q, 2.0 * q), (2.0, 2.0), (0.0, 0.0))
                if status != UNDECIDED:
                    judged += 1
                    wrong += status != true_count(a, q) % 2
    return wrong, judged


@pytest.mark.slow
@in_python_anyway
def test_beside_a_boundary_nothing_is_misjudged() -> None:
    wrong, _ = wrong_beside_boundaries()
    assert wrong == 0


@pytest.mark.slow
@in_python_anyway
def test_broken_rounding_is_caught(tuned: Tuned) -> None:
    """Without the outward step the doubles beside boundaries are judged, and some of them wrongly."""
    tuned(unit_of_rounding=0.0, smallest_step_outwards=0.0)
    wrong, judged = wrong_beside_boundaries()
    assert judged > 500
    assert wrong > 20


@pytest.mark.slow
@in_python_anyway
def test_rounding_of_the_excess_is_needed(tuned: Tuned) -> None:
    """The excess alone, at doubles beside boundaries of period pi: its sign is right only with rounding outwards."""

    def wrong() -> int:
        missed = 0
        for q in (0.5, 1.0, 3.0, 7.3):
            for order in (2, 4, 6):
                for name in "ab":
                    value = float(fr.mathieu.characteristic_values(order, q, name))
                    for step in range(-4, 5):
                        a = value + step * np.spacing(value)
                        low, high = regions_excess.excess((a, a), (2.0 * q, 2.0 * q), (2.0, 2.0), 0)
                        stable = true_count(a, q) % 2 == 1
                        missed += bool(low > 0.0) if stable else bool(high < 0.0)
        return missed

    assert wrong() == 0
    tuned(unit_of_rounding=0.0, smallest_step_outwards=0.0)
    assert wrong() > 5


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("place", range(8))
def test_what_is_not_finite_is_not_judged(value: float, place: int) -> None:
    box = np.array([[1.0, 1.1], [0.1, 0.2], [3.0, 3.1], [0.1, 0.1]])
    assert regions_modes.mode_status(*map(tuple, box.tolist())) == STABLE
    box.flat[place] = value
    assert regions_modes.mode_status(*map(tuple, box.tolist())) == UNDECIDED


@pytest.mark.parametrize("size", [1e-300, 1e-160, 1e160, 1e300])
def test_extreme_sizes_are_judged_rightly_or_not_at_all(size: float) -> None:
    for a, q, level in ((0.5, 0.1, 0.0), (1.0, 0.5, 0.0), (-3.0, 0.1, 0.0), (1.0, 0.5, 3.0), (-40.0, 1.0, 0.1)):
        point = a * size, 2.0 * q * size, 2.0 * math.sqrt(size), level * math.sqrt(size)
        status = regions_modes.mode_status(*((x, x) for x in point))
        true = STABLE if undamped_growth(0.5 * q, -0.25 * a, 0.0) * 2.0 <= level else UNSTABLE
        assert status in (UNDECIDED, true)
    assert regions_modes.mode_status((-size, -size), (0.0, 0.0), (1.0, 1.0), (0.0, 0.0)) == UNSTABLE


def test_without_force() -> None:
    def status(kl: float, kh: float, level: float) -> int:
        return regions_modes.mode_status((kl, kh), (0.0, 0.0), (1.0, 1.0), (level, level))

    assert status(0.1, 2.0, 0.0) == STABLE  # also where k^2 = a, tongues have no width
    assert status(-2.0, -0.1, 0.0) == UNSTABLE
    assert status(0.0, 1.0, 0.0) == UNDECIDED  # at kappa = 0 the motion drifts
    assert status(-1.0, 1.0, 1.01) == STABLE
    assert status(-2.0, -1.1, 1.01) == UNSTABLE
    assert status(-2.0, -1.0, 1.01) == UNDECIDED
    assert status(-1.0, 1.0, 0.0) == UNDECIDED


@needs_jit
def test_flux_bound_holds_in_every_tongue_and_is_tight() -> None:
    bound = compiled(regions_modes.flux_bound)
    growth = compiled(undamped_growth)
    for order in range(1, 13):
        for q in (0.01, 0.3, 1.0, 3.0, 8.0, 25.0):
            low = float(fr.mathieu.characteristic_values(order, q, "b"))
            high = float(fr.mathieu.characteristic_values(order, q, "a"))
            most = max(growth(0.5 * q, -0.25 * a, 0.0) for a in np.linspace(low, high, 101))
            least = bound(0.25 * low, 0.5 * q, 1.0, 1.0, 0.0)
            assert most <= least * (1.0 + 1e-9)
            if 10.0 * q < low and most > 1e-7:
                assert least < 1.25 * most


def rod_box(rod: fr.Rod, mean: Any, amplitude: Any, frequency: Any) -> Floats:
    box = np.empty((8, 2))
    for row, value in zip(box, (mean, amplitude, frequency, *mode_constants(rod).equation), strict=True):
        row[:] = value
    box[[3, 4, 5], 0] *= 1.0 - 1e-15
    box[[3, 4, 5], 1] *= 1.0 + 1e-15
    return box


def random_loads(rng: np.random.Generator, n: int, low: Floats, high: Floats) -> Floats:
    """Return points of a box of loads, many of them on its faces."""
    at = np.where(rng.random((n, 3)) < 0.3, rng.integers(0, 2, (n, 3)), rng.random((n, 3)))
    return low + (high - low) * at


def answer(rod: fr.Rod, low: Floats, high: Floats, tolerance: float) -> tuple[str, regions.BoxSearch]:
    box = rod_box(rod, *zip(low, high, strict=True))
    last, bound = compiled(regions.tail_modes)(box, tolerance, 1e-12, 1000)
    assert bound <= max(tolerance, 1e-12)
    search = regions.box_search(box, last, 3000)
    while compiled(regions.certify_box)(*search, tolerance, tolerance, 100):
        pass
    stable, unstable = search.counts[regions.STABLE_PARTS], search.counts[regions.UNSTABLE_PARTS]
    if stable and unstable:
        return "mixed", search
    if search.counts[regions.WAITING] + search.counts[regions.OPEN_PARTS]:
        return "undecided", search
    return ("unstable" if unstable else "stable"), search


def test_boxes_of_loads() -> None:
    rng = np.random.default_rng(11)
    found: dict[str, int] = dict.fromkeys(("stable", "unstable", "mixed", "undecided"), 0)
    for _ in range(60 if JIT else 20):
        rod = fr.Rod.nitinol().replace(damping_rate=float(rng.choice([0.0, rng.uniform(0.0, 12.0)])))
        unit = rod.critical_force
        tolerance = float(10.0 ** rng.uniform(-6.0, 0.0))
        low = np.array([rng.uniform(0.0, unit), 10.0 ** rng.uniform(-2.0, -0.2) * unit, rng.uniform(20.0, 200.0)])
        high = low * (1.0 + 10.0 ** rng.uniform(-3.0, math.log10(0.2), 3))
        status, search = answer(rod, low, high, tolerance)
        found[status] += 1
        loads = random_loads(rng, 200 if JIT else 40, low, high)
        stable = rod.is_stable(**by_name(*loads.T), growth_tolerance=tolerance)
        if status in ("stable", "unstable"):
            assert (stable == (status == "stable")).all()
        if status == "mixed":
            one, other = (example.mean(axis=1) for example in search.examples)
            assert rod.is_stable(**by_name(*one[:3]), growth_tolerance=tolerance)
            assert not rod.is_stable(**by_name(*other[:3]), growth_tolerance=tolerance)
            assert 0 < search.counts[regions.GROWING_MODE] <= search.last
    assert found["undecided"] == 0
    assert min(found["stable"], found["unstable"], found["mixed"]) >= (5 if JIT else 1)


@pytest.mark.slow
def test_modes_left_out_grow_no_more_than_is_said() -> None:
    rng = np.random.default_rng(13)
    tail = compiled(regions.tail_modes)
    for _ in range(40):
        rod = fr.Rod.nitinol().replace(damping_rate=float(rng.choice([0.0, rng.uniform(0.0, 12.0)])))
        unit = rod.critical_force
        low = np.array([rng.uniform(-unit, 2.0 * unit), rng.uniform(0.0, unit), rng.uniform(20.0, 200.0)])
        high = low + np.array([0.1, 0.1, 5.0])
        tolerance = float(10.0 ** rng.uniform(-9.0, 0.0))
        box = rod_box(rod, *zip(low, high, strict=True))
        last, bound = tail(box, tolerance, 1e-12, 1000)
        assert bound <= tolerance
        assert regions.tail_modes(box, tolerance, 1e-12, 1000) == (last, bound)
        for mean, amplitude, frequency in random_loads(rng, 10, low, high):
            for mode in range(last + 1, last + 6):
                (kappa, _), (p, _) = regions.mode_box(rod_box(rod, mean, amplitude, frequency), mode)
                assert growth_at(kappa, p, frequency) - rod.damping_rate <= bound + 1e-8
        if last > 1:  # none too many: the bound does not hold for one mode less
            assert regions_boxes.tail_bound(box, last - 1) > rod.damping_rate + tolerance


def test_no_bound_no_verdict() -> None:
    box = rod_box(fr.Rod.nitinol(), 1.0, (0.1, 1e6), 100.0)
    last, bound = regions.tail_modes(box, 1e-6, 1e-12, 20)
    assert (last, bound) == (20, math.inf)


def test_amplitude_zero() -> None:
    rod = fr.Rod.nitinol()
    unit = rod.critical_force
    assert answer(rod, np.array([0.0, 0.0, 50.0]), np.array([0.9 * unit, 0.0, 60.0]), 0.0)[0] == "stable"
    assert answer(rod, np.array([1.2 * unit, 0.0, 50.0]), np.array([1.3 * unit, 0.0, 60.0]), 0.0)[0] == "unstable"
    assert answer(rod, np.array([0.9 * unit, 0.0, 50.0]), np.array([1.3 * unit, 0.0, 60.0]), 0.0)[0] == "mixed"


def test_rods_within_tolerances() -> None:
    """A box in all seven numbers: rods drawn from it agree."""
    rng = np.random.default_rng(17)
    rod = fr.Rod.nitinol().replace(damping_rate=3.0)
    unit = rod.critical_force
    box = rod_box(rod, (0.3 * unit, 0.32 * unit), (0.2 * unit, 0.21 * unit), (150.0, 152.0))
    box[3:, 0] *= 0.99
    box[3:, 1] *= 1.01
    last, bound = compiled(regions.tail_modes)(box, 0.5, 1e-12, 1000)
    search = regions.box_search(box, last, 20_000)
    compiled(regions.certify_box)(*search, 0.5, 0.5, 20_000)
    counts = search.counts
    assert bound <= 0.5
    assert counts[regions.WAITING] == counts[regions.OPEN_PARTS] == counts[regions.UNSTABLE_PARTS] == 0
    for _ in range(100):
        f, df, w, c1, c2, swing, _, damping = rng.uniform(box[:, 0], box[:, 1])
        for mode in range(1, last + 4):
            kappa = c1 * mode**4 - c2 * mode**2 * f + swing - damping**2
            assert growth_at(float(kappa), float(c2 * mode**2 * df), float(w)) <= damping + 0.5 + 1e-7


def test_cells_are_proved() -> None:
    rod = fr.Rod.nitinol().replace(damping_rate=1.0)
    unit = rod.critical_force
    x, y = np.linspace(0.1 * unit, 1.1 * unit, 9), np.linspace(0.005 * unit, 0.2 * unit, 7)
    some = slice(None, None, 1 if JIT else 3)
    corners = [edge.ravel()[some] for edge in (*np.meshgrid(x[:-1], y[:-1]), *np.meshgrid(x[1:], y[1:]))]
    many = corners[0].size
    out = np.empty(many, dtype=np.int8)
    w = np.full(many, 120.0)
    rods = rod_box(rod, 0.0, 0.0, 1.0)[3:]
    compiled(regions.certify_cells)(
        corners[0], corners[2], corners[1], corners[3], w, w, out, rods, 0.01, 0.01, 1e-12, 1000, 500
    )
    assert set(out.tolist()) == {1, 0, 2}
    rng = np.random.default_rng(19)
    for cell in range(many):
        at = rng.random((2, 300 if JIT else 30))
        mean = corners[0][cell] + at[0] * (corners[2][cell] - corners[0][cell])
        amplitude = corners[1][cell] + at[1] * (corners[3][cell] - corners[1][cell])
        stable = rod.is_stable(mean=mean, amplitude=amplitude, frequency=120.0, growth_tolerance=0.01)
        if out[cell] < 2:
            assert (stable == bool(out[cell])).all()


def test_more_pending_modes_than_are_listed(monkeypatch: pytest.MonkeyPatch, tuned: Tuned) -> None:
    """Modes that are not listed one by one are asked again; the answer is the same."""
    rng = np.random.default_rng(23)
    rod = fr.Rod.nitinol().replace(damping_rate=1.0)
    unit = rod.critical_force
    examined = 0
    for _ in range(25 if JIT else 8):
        low = np.array([rng.uniform(0.2, 0.8) * unit, rng.uniform(0.01, 0.1) * unit, rng.uniform(100.0, 150.0)])
        high = low * np.array([1.1, 1.2, 1.02])
        monkeypatch.undo()
        status, search = answer(rod, low, high, 1e-3)
        tuned(pending_modes_listed=2)
        again, searched = answer(rod, low, high, 1e-3)
        assert status == again
        np.testing.assert_array_equal(search.counts, searched.counts)
        np.testing.assert_array_equal(search.examples, searched.examples)
        examined = max(examined, search.counts[regions.DONE])
    assert examined > 3


def test_work_is_bounded_and_can_be_continued() -> None:
    box = rod_box(fr.Rod.nitinol(), (0.5, 0.50001), (0.3, 0.30001), (100.0, 100.001))
    whole = regions.box_search(box, 10, 40)
    pieces = regions.box_search(box, 10, 40)
    whole_goes_on = compiled(regions.certify_box)(*whole, 0.0, 0.0, 1000)
    while compiled(regions.certify_box)(*pieces, 0.0, 0.0, 7):
        pass
    assert not whole_goes_on
    assert whole.counts[regions.DONE] <= 42
    for one, other in ((whole.counts, pieces.counts), (whole.examples, pieces.examples)):
        np.testing.assert_array_equal(one, other)
