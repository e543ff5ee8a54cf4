"""White noise in the coefficients: second moments, how much noise is borne, and what almost every path does."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.linalg import expm

import floquetrod as fr
from floquetrod.equations import Varying
from floquetrod.equations.batches import pick
from tests.conftest import depth

ONE = [[1.0]]
TABLE = [((1.2, 0.5, 0.1, 0.3), -0.1486429934), ((0.6, 0.8, 0.15, 0.2), -0.0860368951)]
"""d, e, c, s of y'' + 2 c y' + (d + e cos t) y = s y xi, and the growth rate of second moments.

From DOP853, and from products of 4000 and 8000 exponentials, extrapolated: -0.148642993371, -0.086036895109.
"""


def mathieu(d: float, e: float, c: float) -> fr.HillSystem:
    return fr.HillSystem([[d]], [[[e]]], damping=[[2.0 * c]])


def kronecker(a: Any, noise: Any) -> Any:
    """Return the matrix of vec P -> vec (A P + P A^T + sum s^2 G P G^T), which shares nothing with the package."""
    unit = np.eye(len(a))
    scattered: Any = sum(s * s * np.kron(g, g) for g, s in noise)
    return np.kron(unit, a) + np.kron(a, unit) + scattered


def growth_of_all_moments(coefficient: Any, noise: Any, period: float) -> float:
    """Return the growth rate of P by DOP853 on the Kronecker product of every instant."""
    size = len(coefficient(0.0)) ** 2

    def slope(t: float, state: Any) -> Any:
        return (kronecker(coefficient(t), noise) @ state.reshape(size, size)).ravel()

    found = solve_ivp(slope, (0.0, period), np.eye(size).ravel(), method="DOP853", rtol=1e-12, atol=1e-13)
    multipliers = np.linalg.eigvals(found.y[:, -1].reshape(size, size))
    return float(np.log(np.abs(multipliers).max()) / period)


@pytest.mark.parametrize(("numbers", "rate"), TABLE)
def test_second_moments_of_noisy_mathieu_equations_grow_as_the_table_says(numbers: Any, rate: float) -> None:
    *parameters, s = numbers
    verdict = fr.stability(mathieu(*parameters), noise=[(ONE, s)])
    assert verdict.exponents[0].real == pytest.approx(rate, abs=1e-9)
    assert verdict.status == "stable"
    assert "mean-square stable" in repr(verdict)
    d, e, c = parameters
    scalar = fr.stability(fr.Mathieu(alpha=-e, beta=-d, damping=c), noise=s)
    assert scalar.exponents[0].real == pytest.approx(rate, abs=1e-9)


def test_an_oscillator_bears_noise_up_to_four_c_w_squared() -> None:
    for c, squared in ((0.1, 1.0), (0.03, 2.5)):
        oscillator = fr.HillSystem([[squared]], damping=[[2.0 * c]])
        limit = math.sqrt(4.0 * c * squared)
        for factor, status in ((1.0 - 1e-9, "stable"), (1.0 + 1e-9, "unstable")):
            assert fr.stability(oscillator, noise=[(ONE, factor * limit)]).status == status
        found = fr.critical_noise(oscillator, [(ONE, 0.5)])
        assert abs(0.5 * found.factor - limit) <= 0.5 * found.error + 1e-15
        assert found.error < 1e-10 * found.factor
        assert (found.below.status, found.above.status) == ("stable", "unstable")  # type: ignore[union-attr]


def test_the_moments_of_single_systems_are_those_of_kronecker_products() -> None:
    rng = np.random.default_rng(3)
    for n in (1, 2, 3):
        a, g, h = (np.round(rng.normal(size=(n, n)), 2) for _ in range(3))
        moments = fr.second_moments(fr.PeriodicSystem(a), [(g, 0.5), (h, 0.3)])
        p = rng.normal(size=(n, n))
        p += p.T
        above = np.triu_indices(n)
        expected = (kronecker(a, [(g, 0.5), (h, 0.3)]) @ p.ravel()).reshape(n, n)[above]
        assert moments.mean @ p[above] == pytest.approx(expected, abs=1e-13)


def test_what_is_rounded_is_bounded_and_nothing_else() -> None:
    exact = fr.second_moments(mathieu(1.25, 0.5, 0.125), [(ONE, 0.5)])
    assert exact.coefficient_error == 0.0
    s, g = 0.3, 1.1
    moments = fr.second_moments(fr.PeriodicSystem([[0.1]]), [([[g]], s)])
    entry = 2 * Fraction(0.1) + Fraction(s) ** 2 * Fraction(g) ** 2
    assert abs(Fraction(float(moments.mean[0, 0])) - entry) <= Fraction(moments.coefficient_error) < Fraction(1, 10**15)


def test_mass_and_coordinates_change_no_moment() -> None:
    mass, stiffness, waves = np.array([[2.0, 0.5], [0.5, 1.0]]), np.diag([1.0, 4.0]), np.array([[0.1, 0.2], [0.2, 0.3]])
    damping, noise = np.array([[0.3, 0.1], [0.1, 0.4]]), np.array([[0.5, 0.2], [-0.1, 0.4]])
    system = fr.HillSystem(stiffness, [waves], mass=mass, damping=damping, period=2.5)
    inverse, zero = np.linalg.inv(mass), np.zeros((2, 2))

    def coefficient(t: float) -> Any:
        k = stiffness + waves * math.cos(2.0 * math.pi * t / 2.5)
        return np.block([[zero, np.eye(2)], [-inverse @ k, -inverse @ damping]])

    scattering = np.block([[zero, zero], [-inverse @ noise, zero]])
    expected = growth_of_all_moments(coefficient, [(scattering, 0.7)], 2.5)
    assert fr.stability(system, noise=[(noise, 0.7)]).exponents[0].real == pytest.approx(expected, abs=1e-9)


def test_in_stratonovichs_sense_noise_turns_without_growth() -> None:
    turning = [([[0.0, -1.0], [1.0, 0.0]], 0.5)]
    still = fr.PeriodicSystem(np.zeros((2, 2)), period=1.0)
    ito = fr.stability(still, noise=turning)
    assert ito.status == "unstable"
    assert ito.growth_rate == pytest.approx(0.25, abs=1e-12)
    stratonovich = fr.stability(still, noise=turning, interpretation="stratonovich")
    assert stratonovich.exponents[0].real == pytest.approx(0.0, abs=1e-12)
    both = [fr.stability(mathieu(1.2, 0.5, 0.1), noise=[(ONE, 0.3)], interpretation=i) for i in ("ito", "stratonovich")]
    assert both[0].exponents == both[1].exponents


def test_systems_that_jump_have_moments_that_are_products_of_exponentials() -> None:
    low, high, noise = (
        np.array([[0.0, 1.0], [-1.0, -0.3]]),
        np.array([[0.0, 1.0], [-4.0, -0.3]]),
        [([[0, 0], [1, 0]], 0.4)],
    )
    system = fr.PeriodicSystem.from_pieces([(0.75, low), (1.5, high)])
    product = expm(1.5 * kronecker(high, noise)) @ expm(0.75 * kronecker(low, noise))
    expected = math.log(np.abs(np.linalg.eigvals(product)).max()) / 2.25
    assert fr.stability(system, noise=noise).exponents[0].real == pytest.approx(expected, abs=1e-10)
    ramp = fr.PeriodicSystem.from_pieces([(1.0, Varying(start=low, slope=high - low)), (1.0, high)])

    def coefficient(t: float) -> Any:
        return low + (high - low) * min(t, 1.0)

    rate = growth_of_all_moments(coefficient, noise, 2.0)
    assert fr.stability(ramp, noise=noise).exponents[0].real == pytest.approx(rate, abs=1e-8)


def test_batches_of_intensities_and_systems_are_judged_together() -> None:
    s = np.array([0.1, 0.6, 0.7])
    moments = fr.second_moments(mathieu(1.2, 0.5, 0.1), [(ONE, s)])
    assert moments.shape == (3,)
    assert fr.systems.is_stable(moments).tolist() == [True, True, False]
    alone = [fr.stability(mathieu(1.2, 0.5, 0.1), noise=[(ONE, each)]) for each in s.tolist()]
    assert fr.systems.growth_rate(moments) == pytest.approx([v.growth_rate for v in alone], abs=1e-11)
    assert isinstance(pick(moments, 1), fr.results.SecondMoments)
    stiff = fr.HillSystem(np.array([1.0, 4.0])[:, None, None], damping=[[0.2]])
    assert fr.systems.is_stable(fr.second_moments(stiff, [(ONE, 0.9)])).tolist() == [False, True]


def test_noise_is_proved_in_mean_square() -> None:
    quiet, loud = (fr.certify(fr.Mathieu(0.5, -1.2, 0.1), noise=s) for s in (0.3, 0.7))
    assert (quiet.status, loud.status) == ("stable", "unstable")
    assert "second moments" in repr(quiet)
    assert "period, 2 pi, was taken" in repr(quiet)
    assert fr.certify(mathieu(1.2, 0.5, 0.1), noise=[(ONE, 0.3)]).status == "stable"

    def family(stiffness: float) -> fr.results.SecondMoments:
        return fr.second_moments(mathieu(stiffness, 0.5, 0.1), [(ONE, 0.3)])

    assert fr.certify(family, stiffness=(1.19, 1.21)).status == "stable"


@pytest.mark.slow
def test_a_chart_tells_the_threshold_to_a_millionth() -> None:
    def family(s: float, c: float) -> fr.results.SecondMoments:
        return fr.second_moments(fr.HillSystem([[1.0]], damping=[[2.0 * c]]), [(ONE, s)])

    bands = fr.chart(family, over={"s": (0.1, 1.0, 12), "c": (0.05, 0.2, 8)}).find_bands()
    (band,) = bands.bands
    vertices = zip(band.x.tolist(), band.y.tolist(), strict=True)
    edge = [(s, c) for s, c in vertices if 0.1001 < s < 0.999 and 0.0501 < c < 0.1999]
    assert len(edge) > 10
    assert max(abs(s - math.sqrt(4.0 * c)) for s, c in edge) < 1e-6


def test_more_noise_than_any_is_borne_where_moments_do_not_meet() -> None:
    chain = fr.PeriodicSystem([[-1.0, 0.0], [0.5, -2.0]])
    found = fr.critical_noise(chain, [([[0.0, 0.0], [1.0, 0.0]], 1.0)])
    assert found.factor == math.inf
    assert found.below is None


def exact_exponent(squared: float, s: float, c: float) -> float:
    """Return the almost-sure exponent of y'' + 2 c y' + w^2 y = s y xi (Halperin; Derrida and Gardner 1984)."""
    d = 0.5 * s * s
    k = (squared - c * c) / d ** (2.0 / 3.0)

    def moment(power: float) -> float:
        return float(
            quad(lambda u: 2.0 * u ** (2.0 * power + 1.0) * math.exp(-(u**6) / 12.0 - k * u * u), 0.0, 20.0)[0]
        )

    return 0.5 * d ** (1.0 / 3.0) * moment(0.5) / moment(-0.5) - c


@pytest.mark.slow
def test_the_almost_sure_exponent_of_a_line_is_known() -> None:
    line = fr.PeriodicSystem([[-0.1]], period=1.0)
    told: list[tuple[int, int]] = []
    found = fr.almost_sure_exponent(
        line, [(ONE, 0.4)], paths=200, time=20.0, seed=4, progress=lambda *done: told.append(done)
    )
    assert found.interval[0] < -0.18 < found.interval[1]
    assert told[-1] == (20, 20)
    assert "estimated" in repr(found)
    again = fr.almost_sure_exponent(line, [(ONE, 0.4)], paths=200, time=20.0, seed=4)
    assert again == found
    with pytest.raises(KeyboardInterrupt):
        fr.almost_sure_exponent(line, [(ONE, 0.4)], paths=10, time=20.0, progress=_interrupt)


def _interrupt(done: int, total: int) -> None:
    raise KeyboardInterrupt


@pytest.mark.slow
@pytest.mark.parametrize(("squared", "s", "c"), [(1.0, 0.3, 0.0), (1.0, 1.0, 0.05), (-0.5, 1.0, 0.1)])
def test_almost_sure_exponents_of_oscillators_lie_in_their_intervals(squared: float, s: float, c: float) -> None:
    oscillator = fr.HillSystem([[squared]], damping=[[2.0 * c]])
    inside = 0
    for seed in range(10):
        found = fr.almost_sure_exponent(oscillator, [(ONE, s)], paths=300, time=400.0, seed=seed)
        inside += found.interval[0] < exact_exponent(squared, s, c) < found.interval[1]
    assert inside >= 7  # of ten at 95 %: fewer in one of a hundred thousand
    assert found.interval[1] - found.interval[0] < 0.05


@pytest.mark.slow
def test_ten_thousand_paths_have_the_second_moments() -> None:
    system, s, paths, steps = mathieu(1.2, 0.5, 0.1), 0.5, 10_000, 400
    moments = fr.second_moments(system, [(ONE, s)])
    end = 3.0 * 2.0 * math.pi
    expected = fr.solve(moments, [1.0, 0.0, 0.0], (0.0, end))(end)
    rng, x = np.random.default_rng(5), np.tile([1.0, 0.0], (paths, 1))
    h = 2.0 * math.pi / steps
    for k in range(3 * steps):  # half a flow, a kick, half a flow: of the second weak order
        for part in (0.25, 0.75):
            t = (k + part) * h
            x = x @ expm(0.5 * h * np.array([[0.0, 1.0], [-1.2 - 0.5 * math.cos(t), -0.2]])).T
            if part == 0.25:
                x[:, 1] += s * math.sqrt(h) * rng.standard_normal(paths) * x[:, 0]
    for value, sample in zip(expected, (x[:, 0] ** 2, x[:, 0] * x[:, 1], x[:, 1] ** 2), strict=True):
        assert abs(float(sample.mean()) - value) < 3.0 * float(sample.std()) / math.sqrt(paths) + 1e-4


@pytest.mark.slow
def test_random_systems_have_the_moments_of_kronecker_products() -> None:
    rng, count = np.random.default_rng(6), depth(100, 60)
    wrong, decided = 0, 0
    for _ in range(count):
        n, period = int(rng.integers(1, 4)), float(rng.uniform(1.0, 4.0))
        a, b, c = (rng.normal(scale=scale, size=(n, n)) for scale in (0.6, 0.4, 0.4))
        a -= rng.uniform(0.0, 1.5) * np.eye(n)
        noise = [(rng.normal(size=(n, n)), float(rng.uniform(0.0, 0.8))) for _ in range(int(rng.integers(1, 3)))]
        verdict = fr.stability(fr.PeriodicSystem(a, [b], [c], period=period), noise=noise)
        w = 2.0 * math.pi / period
        rate = growth_of_all_moments(
            lambda t, a=a, b=b, c=c, w=w: a + b * math.cos(w * t) + c * math.sin(w * t), noise, period
        )
        assert abs(verdict.exponents[0].real - rate) <= verdict.exponent_errors[0] + 1e-8
        decided += verdict.status != "undecided"
        wrong += (verdict.status == "stable" and rate > 1e-8) or (verdict.status == "unstable" and rate < -1e-8)
    assert wrong == 0
    assert decided > 0.9 * count


@pytest.mark.parametrize(
    ("noise", "kind", "says"),
    [
        ([(ONE, -0.1)], ValueError, r"noise\[0\]\[1\] must be from 0"),
        ([(ONE, math.nan)], ValueError, r"noise\[0\]\[1\]"),
        ([(ONE, 1e300)], ValueError, r"noise\[0\]\[1\] must be from 0 to 1e\+15"),
        ([(np.eye(2), 0.1)], ValueError, r"noise\[0\]\[0\] must be 1 x 1"),
        ([([[math.inf]], 0.1)], ValueError, r"noise\[0\]\[0\]"),
        ([(ONE, "loud")], TypeError, r"noise\[0\]\[1\]"),
        ([(ONE,)], TypeError, r"noise must be a sequence \[\(matrix, intensity\)"),
        ([], ValueError, "noise must be .* one source at least"),
        (0.3, TypeError, r"noise must be a sequence \[\(matrix, intensity\)"),
        ([(np.ones((3, 1, 1)), [0.1, 0.2])], ValueError, r"noise\[0\] must have a leading shape that fits"),
    ],
)
def test_bad_noise_is_told(noise: Any, kind: type[Exception], says: str) -> None:
    with pytest.raises(kind, match=says):
        fr.stability(mathieu(1.2, 0.5, 0.1), noise=noise)


def test_what_noise_cannot_be_asked_is_told() -> None:
    system, noise = mathieu(1.2, 0.5, 0.1), [(ONE, 0.3)]
    with pytest.raises(ValueError, match="interpretation must be one of"):
        fr.stability(system, noise=noise, interpretation="strato")
    with pytest.raises(TypeError, match=r"interpretation=.* is that of noise"):
        fr.stability(system, interpretation="stratonovich")
    with pytest.raises(ValueError, match="noise must be zero or more"):
        fr.stability(fr.Mathieu(0.5, -1.2, 0.1), noise=-0.3)
    with pytest.raises(ValueError, match=r"must decay without noise.*only bounded"):
        fr.critical_noise(fr.HillSystem([[1.0]]), noise)
    with pytest.raises(ValueError, match="noise must have an intensity above zero"):
        fr.critical_noise(system, [(ONE, 0.0)])
    with pytest.raises(ValueError, match="at most 44 equations"):
        fr.second_moments(fr.HillSystem(np.eye(23)), [(np.eye(23), 0.1)])
    with pytest.raises(TypeError, match="must be an equation or a system where noise is given"):
        fr.certify(fr.Mathieu, alpha=0.5, beta=-1.2, noise=0.3)
    with pytest.raises(TypeError, match="not second moments"):
        fr.second_moments(fr.second_moments(system, noise), [(np.eye(3), 0.1)])


@pytest.mark.slow
def test_noise_of_a_correlation_time_grows_as_lognormals_do() -> None:
    for variance, time in ((0.25, 0.5), (0.1, 2.0)):
        b = math.sqrt(2.0 * variance / time)
        found = fr.filtered_growth(fr.PeriodicSystem([[-1.0]]), ONE, ([[-1.0 / time]], [b], [1.0]))
        exact = 4.0 * variance * time - 2.0  # E exp(2 int z) = exp(2 var int z), var int z = 2 v t per unit of time
        assert abs(found.rate - exact) <= found.error + 1e-12
        assert found.error < 1e-6
        assert found.status == "stable"


@pytest.mark.slow
def test_fast_noise_is_white_and_noise_in_a_band_acts_by_its_density_at_twice_the_frequency() -> None:
    oscillator, s = mathieu(1.0, 0.0, 0.05), 0.3
    white = fr.stability(oscillator, noise=[(ONE, s)]).exponents[0].real
    rates = [fr.filtered_growth(oscillator, ONE, ([[-1.0 / t]], [s / t], [1.0])).rate for t in (0.02, 0.01)]
    assert abs(2.0 * rates[1] - rates[0] - white) < 2e-4
    assert abs(rates[1] - white) < 2e-3
    band = {}
    for centre in (1.0, 2.0):
        width = 0.4
        found = fr.filtered_growth(
            oscillator, ONE, ([[0.0, 1.0], [-(centre**2), -width]], [0.0, 1.0], [0.0, 0.1]), accuracy=1e-4
        )
        band[centre] = found.rate
    # Of density (0.1 / width)^2 at its centre: 2 c less s^2 / 2 w^2, as for white noise of that density at 2 w.
    assert band[2.0] == pytest.approx(-0.1 + 0.5 * (0.1 / 0.4) ** 2, abs=0.01)
    assert band[1.0] < band[2.0] - 0.02


def test_growth_that_rare_noise_makes_is_not_passed_over() -> None:
    """Orders up to 8 agree on 0.00058; noise of five root mean squares, which lasts, buckles the oscillator."""
    found = fr.filtered_growth(fr.HillSystem([[1.0]]), ONE, ([[-0.05]], [math.sqrt(0.1)], [0.2]), most=38)
    assert abs(found.rate - 0.765056) < 1e-4
    few = fr.filtered_growth(fr.HillSystem([[1.0]]), ONE, ([[-0.05]], [math.sqrt(0.1)], [0.2]), most=8)
    assert few.rate < 1e-3
    assert few.rate + few.error > 0.76
    assert few.status == "undecided"
    w, half, rms = 1.815, 0.0045, 0.07  # a sine beside twice the frequency, which reaches it when it is large
    band = [[0.0, 1.0], [-(w**2), -2.0 * half]], [0.0, 1.0], [rms * math.sqrt(4.0 * half) * w, 0.0]
    assert fr.filtered_growth(mathieu(1.0, 0.0, 0.0043), ONE, band, most=6).status == "undecided"


@pytest.mark.parametrize(
    ("filter_", "kind", "says"),
    [
        (([[1.0]], [1.0], [1.0]), ValueError, "filter must be stable"),
        (([[-1.0]], [0.0], [1.0]), ValueError, "filter must have states that the noise all reaches"),
        (([[-1.0]], [1.0, 2.0], [1.0]), ValueError, r"filter must be .* got shapes"),
        ([[-1.0]], TypeError, r"filter must be \(F, b, d\)"),
    ],
)
def test_bad_filters_are_told(filter_: Any, kind: type[Exception], says: str) -> None:
    with pytest.raises(kind, match=says):
        fr.filtered_growth(mathieu(1.0, 0.0, 0.05), ONE, filter_)


def test_filtered_noise_that_takes_too_long_is_refused_with_the_seconds_and_a_remedy() -> None:
    """The numbers are those of a force in newtons on a mode of 6 Hz; scaled with its frequency they are answered."""
    oscillator = mathieu(1500.0, 0.0, 0.8)
    with pytest.raises(ValueError, match=r"computed in \d+ s, got \d\S* s of computing: .*scale the time"):
        fr.filtered_growth(oscillator, [[36.0]], ([[0.0, 1.0], [-5780.0, -4.4]], [0.0, 1.0], [567.0, 0.0]))


def test_a_growth_that_is_never_known_ends_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    rates = itertools.chain([1.0], itertools.repeat(math.nan))
    monkeypatch.setattr("floquetrod.floquet.critical_noise.run", lambda *_: SimpleNamespace(highest_rate=next(rates)))
    with pytest.raises(ValueError, match="noise must have a largest stable intensity that growth can tell"):
        fr.critical_noise(fr.HillSystem([[1.0]], damping=[[0.2]]), [([[1.0]], 1.0)])
