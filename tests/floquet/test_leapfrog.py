"""The paper's test: what it sees, what it cannot see, and the order of its scheme."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings

import floquetrod as fr
from floquetrod._util.compilation import compiled
from floquetrod.methods import leapfrog
from tests.conftest import JIT, depth
from tests.inside import leapfrog_map_fill
from tests.seams import Tuned
from tests.strategies import decades, hills, mathieus, square_waves

EQUATIONS = [
    fr.Mathieu(0.9, -0.6),
    fr.Mathieu(0.5, -0.25),
    fr.Meissner(0.8, -0.4),
    fr.Hill(-0.5, (0.3, 0.2), (0.1, -0.4), period=5.0),
    fr.Mathieu(0.5, -0.25, damping=0.1),
]


@pytest.mark.kernels
@pytest.mark.parametrize("equation", EQUATIONS, ids=repr)
def test_second_order_in_the_step(equation: fr.Mathieu | fr.Meissner | fr.Hill) -> None:
    exact = fr.stability(equation, method="monodromy").discriminant
    steps = [0.08, 0.04, 0.02]
    results = [leapfrog(equation, step=h, periods=1) for h in steps]
    errors = [abs(r.discriminant - exact) for r in results]
    counts = [r.cost.amount for r in results]
    order = math.log(errors[0] / errors[2]) / math.log(counts[2] / counts[0])
    assert order == pytest.approx(2.0, abs=0.1)
    for r, error in zip(results, errors, strict=True):
        assert error <= 1.2 * r.error * max(1.0, abs(exact))


def test_thin_tongues_are_invisible() -> None:
    # F2-b: growth 5.0e-9 per unit tau, and 0.015 at alpha = 0.03, below the threshold of 0.022.
    for alpha in (1e-8, 0.03):
        assert leapfrog(fr.Mathieu(alpha, -0.25)).status == "stable"
        assert fr.stability(fr.Mathieu(alpha, -0.25)).status == "unstable"
    assert leapfrog(fr.Mathieu(0.06, -0.25)).status == "unstable"
    assert "0.022 per unit tau" in leapfrog(fr.Mathieu(0.03, -0.25)).note


@pytest.mark.kernels
@pytest.mark.parametrize("equation", EQUATIONS, ids=repr)
def test_machine_code_gives_the_bits_of_the_interpreter(
    equation: fr.Mathieu | fr.Meissner | fr.Hill, tuned: Tuned
) -> None:
    tuned(leapfrog_compiled_after=10**9)
    interpreted = leapfrog(equation)
    tuned(leapfrog_compiled_after=-1)
    assert leapfrog(equation) == interpreted


def test_claims_about_the_chart() -> None:
    # F2-a and F2-c.
    assert leapfrog(fr.Mathieu(0.0, 0.01)).status == "unstable"
    assert leapfrog(fr.Mathieu(1.5, -0.80)).status == "stable"
    assert leapfrog(fr.Mathieu(1.7, -0.80)).status == "unstable"


def test_growth_is_measured() -> None:
    equation = fr.Mathieu(0.5, -0.25)
    exact = fr.stability(equation).growth_rate
    assert leapfrog(equation).growth_rate == pytest.approx(exact, rel=1e-2)
    assert leapfrog(equation, step=5e-3, periods=2000).growth_rate == pytest.approx(exact, rel=1e-3)


@pytest.mark.kernels
def test_huge_growth_does_not_overflow() -> None:
    result = leapfrog(fr.Mathieu(100.0, 20000.0), periods=3)
    assert result.status == "unstable"
    assert result.log_abs_discriminant == pytest.approx(
        fr.stability(fr.Mathieu(100.0, 20000.0)).log_abs_discriminant, rel=1e-3
    )


@pytest.mark.kernels
def test_damping_shrinks_areas_exactly() -> None:
    # Each step of the scheme has determinant exp(-2 c step), so Liouville holds to rounding.
    wave, c = np.sin(np.arange(200) * (2.0 * math.pi / 200)), 0.05
    inputs, plain, found = (np.array([0.7]), np.array([-0.3]), np.array([c])), np.empty((1, 5)), np.empty((1, 5))
    leapfrog_map_fill(*(part.tolist() for part in inputs), plain, wave.tolist(), 2.0 * math.pi)
    a1, v1, a2, v2, taken = plain[0]
    assert taken == 0.0
    assert a1 * v2 - v1 * a2 == pytest.approx(math.exp(-4.0 * math.pi * c), rel=1e-12)
    compiled(leapfrog_map_fill)(*inputs, found, wave, 2.0 * math.pi)
    assert found == pytest.approx(plain, rel=1e-12)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"step": 0.0}, "step must be greater than zero"),
        ({"periods": 0}, "periods must be 1 or more"),
        ({"limit": 0.5}, "limit must be greater than 1"),
    ],
)
def test_bad_options(options: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        leapfrog(fr.Mathieu(0.5, -0.25), **options)  # type: ignore[arg-type]


def test_the_threshold_depends_on_where_the_growing_mode_stands_at_the_end() -> None:
    # At beta = -0.25 the growing mode is close to sin(tau / 2), zero at tau = 200 pi: growth of 0.022 is not enough.
    threshold = math.log(1e6) / (200.0 * math.pi)
    slow, fast = fr.Mathieu(0.052, -0.25), fr.Mathieu(0.054, -0.25)
    assert fr.stability(slow).growth_rate > 1.15 * threshold
    assert leapfrog(slow).status == "stable"
    assert leapfrog(fast).status == "unstable"
    # Without forcing A = sinh(g tau) / g, and 1 / g makes up for growth of less than 0.022.
    assert leapfrog(fr.Mathieu(0.0, 0.02**2)).status == "unstable"
    assert fr.stability(fr.Mathieu(0.0, 0.02**2)).growth_rate < threshold


def test_strong_damping_keeps_its_discriminant() -> None:
    for damping in (60.0, 130.0, 1000.0):
        equation = fr.Mathieu(0.5, -0.25, damping=damping)
        result, exact = leapfrog(equation), fr.stability(equation, method="monodromy").discriminant
        assert result.status == "stable"
        assert abs(result.discriminant - exact) <= 1.2 * result.error


def test_a_step_too_long_for_the_coefficient_is_told() -> None:
    equation = fr.Mathieu(0.0, -100.3)
    rough, fine = leapfrog(equation, step=1.0), leapfrog(equation)
    assert (rough.status, fine.status) == ("unstable", "stable")
    assert "the scheme itself is unstable" in rough.note
    assert "unstable" not in fine.note
    assert math.isfinite(leapfrog(fr.Mathieu(1e9, 0.0), step=0.05).growth_rate)
    with pytest.raises(ValueError, match="take a shorter step"):
        leapfrog(fr.Hill(1.0, period=1e200), step=1e199)


@pytest.mark.kernels
@settings(max_examples=depth(100, 25 if JIT else 6))
@given(
    mathieus(largest_alpha=1e4, beta=(-1e4, 1e3), largest_damping=10.0)
    | square_waves(largest=1e3, largest_damping=10.0)
    | hills(largest_damping=0.5),
    decades(1e-4, 0.1),
)
def test_an_error_that_leaves_digits_covers_the_truth(
    equation: fr.Mathieu | fr.Meissner | fr.Hill, share: float
) -> None:
    result = leapfrog(equation, step=share * equation.period, periods=1)
    assume(result.error < 0.1)
    exact = fr.stability(equation, method="monodromy")
    scale = max(1.0, abs(result.discriminant))
    assert abs(result.discriminant - exact.discriminant) <= (result.error + exact.error) * scale


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("equation", "step"),
    [
        (fr.Mathieu(0.5, -1e5), 5e-4),  # two radians behind after a period: the maps meet again by chance
        (fr.Meissner(-8.792147085056326, 1.1464426096028026), 2.0 * math.pi / 474),  # half of 474 steps is odd
        (fr.Hill(-0.3, (0.5, *[0.0] * 14, 0.4)), 2.0 * math.pi / 16),  # steps as long as the 16th harmonic's waves
        # The maps of 100 and of 50 steps meet by chance, that of 25 steps is far away.
        (fr.Hill(-10.375, (-7.0, -2.75, 14.5, -10.0), (12.0, 7.0)), 2.0 * math.pi / 100),
    ],
    ids=["phase", "jump", "resolution", "meeting"],
)
def test_chance_and_coarse_steps_do_not_pass_for_accuracy(equation: fr.Mathieu | fr.Hill, step: float) -> None:
    result, exact = leapfrog(equation, step=step, periods=1), fr.stability(equation, method="monodromy").discriminant
    assert abs(result.discriminant - exact) <= result.error * max(1.0, abs(result.discriminant))


@pytest.mark.kernels
@pytest.mark.parametrize(
    ("equation", "step"),
    [(fr.Mathieu(0.5, -0.25), 1e-9), (fr.Hill(1.0, period=1e6), 5e-4), (fr.Hill(1.0, period=1e300), 1e-300)],
    ids=["step", "period", "both"],
)
def test_too_many_steps_are_declined(equation: fr.Mathieu | fr.Hill, step: float) -> None:
    result = leapfrog(equation, step=step)
    assert result.status == "undecided"
    assert result.cost.amount == 0
    assert "take a longer step or fewer periods" in result.note
