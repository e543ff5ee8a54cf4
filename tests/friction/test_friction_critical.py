"""The smallest kick found to escape, against scans that know nothing of the search; and what is proved beside it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

import floquetrod as fr
from floquetrod.friction import BOUNDED, ESCAPES

HEALTHY = 1e-6  # growth per period without friction from which on a kick has to be found

Points = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


class Scan(NamedTuple):
    """What a scan makes of the smallest kicks found."""

    points: int
    too_high: int
    worst: float
    none: int
    below_the_proved: int

    def __str__(self) -> str:
        """Return the counts as a sentence."""
        return (
            f"{self.points} points: {self.too_high} too high, by up to {100.0 * self.worst:.2g} %; {self.none} without "
            f"a kick at healthy growth; {self.below_the_proved} with an escape below the proved bound"
        )


def unstable_points(rng: np.random.Generator, count: int) -> Points:
    """Return alpha, beta and damping of random equations that grow without friction, about half of them damped."""
    alpha, beta = rng.uniform(-4.0, 4.0, 8 * count), rng.uniform(-3.0, 1.0, 8 * count)
    damping = np.where(rng.random(8 * count) < 0.5, 0.0, rng.uniform(0.0, 0.1, 8 * count))
    healthy = 2.0 * math.pi * fr.mathieu.growth_rate(alpha, beta, damping) > HEALTHY
    assert healthy.sum() >= count
    return alpha[healthy][:count], beta[healthy][:count], damping[healthy][:count]


def slowly_growing_points(rng: np.random.Generator, count: int) -> Points:
    """Return equations damped so that they grow by 1e-6 to 1 a period, evenly on a logarithmic scale."""
    alpha, beta = rng.uniform(-4.0, 4.0, 8 * count), rng.uniform(-3.0, 1.0, 8 * count)
    wanted = 10.0 ** rng.uniform(math.log10(2.0 * HEALTHY), 0.0, alpha.size) / (2.0 * math.pi)
    some = fr.mathieu.growth_rate(alpha, beta) > 2.0 * wanted
    alpha, beta, wanted = alpha[some][:count], beta[some][:count], wanted[some][:count]
    assert alpha.size == count
    low, high = np.zeros(count), np.full(count, 4.0)
    for _ in range(60):
        middle = 0.5 * (low + high)
        grows = fr.mathieu.growth_rate(alpha, beta, middle) > wanted
        low, high = np.where(grows, middle, low), np.where(grows, high, middle)
    return alpha, beta, low


def scan(points: Points, kicks: int, found_over: float = 1.0, proved_over: float = 1.0) -> Scan:
    """Follow ``kicks`` kicks of each equation, from a little below the proved bound to the smallest found to escape.

    The factors falsify what was found or proved, to see that a scan notices.
    """
    alpha, beta, damping = points
    proved, found = fr.friction.critical_kick(alpha, beta, damping=damping)
    proved, found = proved * proved_over, found * found_over
    sound = np.isfinite(found)
    alpha, beta, damping, proved, found = (part[sound] for part in (alpha, beta, damping, proved, found))
    assert (proved <= found * proved_over).all()
    first = 0.95 * proved
    tried = first[:, None] * (found * (1.0 - 1e-6) / first)[:, None] ** np.linspace(0.0, 1.0, kicks)
    tried[:, 0] = proved
    fates = fr.friction.fates(alpha[:, None], beta[:, None], 1.0, tried, damping=damping[:, None], max_steps=20_000)
    least = np.where(fates == ESCAPES, tried, math.inf).min(axis=1)
    excess = np.where(np.isfinite(least), found / least - 1.0, 0.0)
    below = ((fates == ESCAPES) & (tried <= proved[:, None])).any(axis=1)
    return Scan(sound.size, int((excess > 1e-6).sum()), float(excess.max()), int((~sound).sum()), int(below.sum()))


@pytest.mark.slow
def test_a_thousand_smallest_kicks_against_scans_of_4000() -> None:
    result = scan(unstable_points(np.random.default_rng(3), 1000), 4000)
    assert result.too_high <= 5, str(result)
    assert result.worst < 3e-3, str(result)
    assert (result.none, result.below_the_proved) == (0, 0), str(result)


@pytest.mark.slow
def test_slow_growth_is_no_excuse() -> None:
    result = scan(slowly_growing_points(np.random.default_rng(4), 100), 50)
    assert result.too_high <= 1
    assert (result.none, result.below_the_proved) == (0, 0)


@pytest.mark.slow
def test_some_smallest_kicks_against_scans() -> None:
    result = scan(unstable_points(np.random.default_rng(5), 40), 200)
    assert result.too_high <= 1
    assert (result.none, result.below_the_proved) == (0, 0)
    assert scan(slowly_growing_points(np.random.default_rng(6), 4), 50)[3:] == (0, 0)


@pytest.mark.slow
def test_scans_notice() -> None:
    points = unstable_points(np.random.default_rng(7), 40)
    assert scan(points, 50, found_over=1.02).too_high > 10
    assert scan(points, 50, proved_over=1.02).below_the_proved > 5


@pytest.mark.parametrize(
    ("alpha", "beta", "damping", "escapes"),
    [
        pytest.param(
            0.9778302039436406, 0.25501564977814617, 0.06206520002228098, 1.059558952896728, marks=pytest.mark.slow
        ),
        (3.7056128930082877, -0.3295082664210822, 0.0, 0.7162793090434649),
        (2.742782398068307, -0.48776919315660994, 0.07228777576221265, 1.33),
        # Narrow ranges of kicks that escape, low among many that do not.
        (3.341538057367302, -0.3377495648326141, 0.04390015985984125, 0.784769376),
        (-3.3475790610918983, -0.25641337074726867, 0.0928942653409327, 2.184965136),
        (-3.3754031197553056, -0.2668784409986946, 0.0, 1.8422347765),
    ],
)
def test_points_that_were_hard(alpha: float, beta: float, damping: float, escapes: float) -> None:
    proved, found = fr.friction.critical_kick(alpha, beta, damping=damping)
    assert proved <= found <= escapes * (1.0 + 1e-6)
    above = found * (1.0 + np.append(0.0, np.geomspace(1e-12, 1e-3, 50)))  # found itself may be the edge of escapes
    assert (fr.friction.fates(alpha, beta, 1.0, above, damping=damping) == ESCAPES).any()
    assert fr.friction.fates(alpha, beta, 1.0, proved, damping=damping) == BOUNDED


@pytest.mark.slow
def test_few_steps_and_a_limit_still_find_a_kick() -> None:
    proved, found = fr.friction.critical_kick(1.0, 1e-300, damping=0.01, largest=10.0, samples=8, max_steps=1000)
    whole = fr.friction.critical_kick(1.0, 0.0, damping=0.01)
    assert proved == pytest.approx(whole.bounded_up_to, rel=1e-12)
    assert found == pytest.approx(whole.smallest_found, rel=1e-3)


@pytest.mark.slow
def test_the_proved_bound_is_where_the_first_stop_may_be_left_outwards() -> None:
    """Followed event by event: up to the bound the first stop is kept, from there on it lies too far out."""
    followed = 0
    for alpha, beta, damping in zip(*unstable_points(np.random.default_rng(8), 40), strict=True):
        low, high = fr.friction.certain_kicks(fr.FrictionalMathieu(alpha, beta, 1.0, damping))
        kept = min(2.0 / abs(alpha), 1.0 / max(abs(alpha) + beta, 1e-300))
        if low == high:  # all is proved: no need of a stop
            continue
        stops = []
        for kick in (low, low * (1.0 + 1e-4)):
            motion = fr.friction.trajectory(fr.FrictionalMathieu(alpha, beta, 1.0, damping), kick, periods=3)
            at_rest = motion.A[1:][motion.velocity[1:] == 0.0]
            stops.append(float(at_rest[0]) if at_rest.size else math.inf)
        assert stops[0] <= kept * (1.0 + 1e-9) < stops[1]
        followed += 1
    assert followed > 30


@pytest.mark.slow
def test_leapfrog_finds_no_escape_up_to_the_proved_bound() -> None:
    alpha, beta, _ = unstable_points(np.random.default_rng(9), 10)
    proved, found = fr.friction.critical_kick(alpha, beta)
    share = np.array([[0.5], [0.8], [0.95], [0.999]])
    assert not fr.friction.leapfrog_escapes(alpha, beta, 1.0, share * proved, periods=30).any()
    assert fr.friction.leapfrog_escapes(alpha, beta, 1.0, 1.05 * found).any()


def test_the_two_numbers_scale_with_friction_and_keep_the_shape() -> None:
    one = fr.friction.critical_kick([[1.0], [-0.7]], [0.3, 0.5, -3.0])
    five = fr.friction.critical_kick([[1.0], [-0.7]], [0.3, 0.5, -3.0], 5.0)
    assert one.smallest_found.shape == one.bounded_up_to.shape == (2, 3)
    for single, times in zip(one, five, strict=True):
        np.testing.assert_allclose(times, 5.0 * single, rtol=1e-12)
        assert np.isinf(single[:, 2]).all()  # nothing grows
