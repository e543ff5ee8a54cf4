"""Guards growth under two frequencies: truth, long integrations, equations and systems alike, stated errors."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import floquetrod as fr
from floquetrod.floquet import quasiperiodic
from tests.conftest import JIT, depth

GOLDEN = (1.0 + math.sqrt(5.0)) / 2.0


def hill(d: float, e: float, damping: float = 0.0) -> fr.Hill:
    """Return x'' + 2 c x' + (d + e cos t) x = 0."""
    return fr.Hill(-d, cosines=(-e,), damping=damping)


@pytest.mark.parametrize(
    ("d", "e1", "e2", "ratio", "rate", "digits"),
    [
        (0.25, 0.2, 0.2, GOLDEN, 0.098139189, 5e-10),
        (0.66, 0.2, 0.3, GOLDEN, 0.09154450, 5e-9),
        (1.72, 0.4, 0.6, GOLDEN, 0.02103344, 5e-9),
        (0.095, 0.3, 0.3, GOLDEN, 0.09792258, 5e-9),
        (0.25, 0.2, 0.2, math.sqrt(2.0), 0.09887709, 5e-9),
    ],
)
def test_growth_is_that_of_the_shared_truth(
    d: float, e1: float, e2: float, ratio: float, rate: float, digits: float
) -> None:
    growth = fr.quasiperiodic_growth(fr.TwoFrequencies(hill(d, e1), ratio, cosines=(-e2,)))
    assert growth.status == "unstable"
    assert abs(growth.rate - rate) < digits + growth.error
    assert growth.error < 1e-7


def test_what_does_not_grow_is_never_simply_stable() -> None:
    growth = fr.quasiperiodic_growth(fr.TwoFrequencies(hill(0.85, 0.25), GOLDEN, cosines=(-0.25,)))
    assert growth.status == "stable"
    for text in (repr(growth), str(growth), f"{growth}"):
        assert text.startswith("<does not grow faster than 0.0001 per unit of time")
        assert "stable" not in text
    finest = growth.approximants[-1][0]
    assert growth.error >= abs(float(finest) - GOLDEN)
    finer = fr.quasiperiodic_growth(fr.TwoFrequencies(hill(0.85, 0.25), GOLDEN, cosines=(-0.25,)), tolerance=1e-9)
    assert finer.status == "undecided"  # a thinner tongue may be there
    assert "; most=2000 may not decide, try another tolerance; ratio" in repr(finer)


def test_more_terms_that_are_named_decide() -> None:
    equation = fr.TwoFrequencies(hill(0.85, 0.25), GOLDEN, cosines=(-0.25,))
    coarse = fr.quasiperiodic_growth(equation, tolerance=1e-3, most=13)
    assert coarse.status == "undecided"
    named = re.search(r"; try most=(\d+); ", repr(coarse))
    assert named is not None
    assert fr.quasiperiodic_growth(equation, tolerance=1e-3, most=int(named[1])).status == "stable"


@pytest.mark.parametrize("damping", [1e-3, 0.0065, 0.3])
@pytest.mark.parametrize("ratio", [1.5, math.sqrt(2.0), GOLDEN])
def test_decay_is_told_with_its_error(damping: float, ratio: float) -> None:
    growth = fr.quasiperiodic_growth(fr.TwoFrequencies(hill(0.85, 0.05, damping), ratio, cosines=(-0.05,)))
    words = r"<decays at (\S+) \+- (\S+) per unit of time; ratio of frequencies taken as (\S+)>"
    match = re.fullmatch(words, repr(growth))
    assert match is not None
    rate, error = float(match[1]), float(match[2])
    assert abs(rate + growth.rate) <= max(0.1 * growth.error, 1e-8 * rate)
    assert abs(rate - damping) <= error + 1e-8 * rate  # between tongues the solutions decay at the damping
    assert Fraction(match[3]) == growth.approximants[-1][0]
    assert (Fraction(match[3]) == Fraction(3, 2)) == (ratio == 1.5)


def integrated(d: float, e1: float, e2: float, ratio: float, periods: int) -> float:
    """Return the mean rate of growth over many periods by the classical method of Runge and Kutta, weighted.

    The rate over the whole is an average of the growth of each period, with weights that vanish smoothly at both ends
    (S. Das and others, Nonlinearity 30 (2017) 4111, DOI 10.1088/1361-6544/aa84c2), which takes out the oscillation.
    """
    steps = 64
    h = 2.0 * math.pi / steps
    x, v, logs = 1.0, 0.3, np.empty(periods)
    for period in range(periods):
        t = 0.5 * h * np.arange(2 * steps * period, 2 * steps * (period + 1) + 1)
        k = (-(d + e1 * np.cos(t) + e2 * np.cos(ratio * t))).tolist()
        for i in range(0, 2 * steps, 2):
            k0, k1, k2 = k[i : i + 3]
            a1 = k0 * x
            v2 = v + 0.5 * h * a1
            a2 = k1 * (x + 0.5 * h * v)
            v3 = v + 0.5 * h * a2
            a3 = k1 * (x + 0.5 * h * v2)
            v4 = v + h * a3
            a4 = k2 * (x + h * v3)
            x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
            v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        size = math.hypot(x, v)
        logs[period], x, v = math.log(size), x / size, v / size
    u = (np.arange(periods) + 0.5) / periods
    weights = np.exp(-1.0 / (u * (1.0 - u)))
    return float(weights @ logs / weights.sum()) / (2.0 * math.pi)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_growth_is_that_of_a_long_integration(seed: int) -> None:
    agree(seed, 600)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3, 103))
def test_growth_is_that_of_long_integrations(seed: int) -> None:
    agree(seed, 3000)


def agree(seed: int, periods: int) -> None:
    """Compare one pair of frequencies; growth below 1e-3 over so many periods counts as none."""
    rng = np.random.default_rng(seed)
    d, e1, e2 = rng.uniform(0.05, 2.0), rng.uniform(0.05, 0.5), rng.uniform(0.05, 0.5)
    ratio = rng.uniform(0.4, 3.0)
    growth = fr.quasiperiodic_growth(fr.TwoFrequencies(hill(d, e1), ratio, cosines=(-e2,)))
    expected = integrated(d, e1, e2, ratio, periods)
    assert abs(growth.rate - expected) < growth.error + 0.5 / periods + 2e-4 * abs(expected)


@pytest.mark.parametrize("fraction", [0.5, 1.0, 2.0, 2.5])
def test_next_to_a_fraction_a_weak_second_frequency_is_harmless_beside_damping(fraction: float) -> None:
    """Beats are slower than approximants resolve; growth is that of a long integration, and the status decided."""
    rng = np.random.default_rng(int(10 * fraction))
    decided, drawn = 0, depth(12, 4)
    for _ in range(drawn):
        d, e1, e2 = rng.uniform(0.05, 2.0), rng.uniform(0.05, 0.4), 10.0 ** rng.uniform(-6.0, -1.5)
        ratio = fraction + rng.choice([-1.0, 1.0]) * rng.uniform(2e-4, 2e-3)
        undamped, periods = integrated(d, e1, e2, ratio, 300), 300
        damping = undamped + rng.uniform(0.02, 0.05)
        equation = fr.TwoFrequencies(hill(d + damping**2, e1, damping), ratio, cosines=(-e2,))
        growth = fr.quasiperiodic_growth(equation)
        assert abs(growth.rate - (undamped - damping)) < growth.error + 1.0 / periods
        assert growth.status != "unstable"
        decided += growth.status == "stable"
    assert decided >= 0.7 * drawn


def test_without_its_amplitude_a_second_frequency_changes_nothing() -> None:
    for size in (1e-9, 0.0):
        growth = fr.quasiperiodic_growth(fr.TwoFrequencies(hill(0.85, 0.25, 0.01), 2.0003, cosines=(size,)))
        assert growth.status == "stable"
        assert abs(growth.rate + 0.01) <= growth.error < 1e-8


def test_damping_takes_its_rate() -> None:
    # x = exp(-c t) u, and u obeys the equation with d - c^2.
    equations = hill(0.66 - 0.05**2, 0.2), hill(0.66, 0.2, 0.05)
    free, damped, more = (
        fr.quasiperiodic_growth(fr.TwoFrequencies(equation, GOLDEN, cosines=(-0.3,)))
        for equation in (*equations, hill(0.66, 0.2, 0.2))
    )
    assert damped.rate == pytest.approx(free.rate - 0.05, abs=1e-8)
    assert more.status == "stable"


def test_equations_and_systems_of_both_orders_grow_alike() -> None:
    one = fr.quasiperiodic_growth(fr.TwoFrequencies(hill(0.66, 0.2), GOLDEN, cosines=(-0.3,), sines=(0.0, 0.05)))
    second = fr.HillSystem([[0.66]], cosines=[[[0.2]]])
    other = fr.quasiperiodic_growth(fr.TwoFrequencies(second, GOLDEN, cosines=[[[0.3]]], sines=[[[0.0]], [[-0.05]]]))
    zero = np.zeros((2, 2))

    def lower(value: float) -> Any:
        return [[0.0, 0.0], [value, 0.0]]

    first = fr.PeriodicSystem([[0.0, 1.0], [-0.66, 0.0]], cosines=[lower(-0.2)])
    third = fr.quasiperiodic_growth(fr.TwoFrequencies(first, GOLDEN, cosines=[lower(-0.3)], sines=[zero, lower(0.05)]))
    assert one.rate == pytest.approx(other.rate, abs=1e-10)
    assert one.rate == pytest.approx(third.rate, abs=1e-9)


def test_a_complex_system_grows_as_its_real_form() -> None:
    a, b = np.array([[-0.05, 0.3j], [0.4, 0.1j]]), np.array([[0.0, 0.3], [0.2j, 0.0]])
    system = fr.PeriodicSystem(a, cosines=[b])
    one = fr.quasiperiodic_growth(fr.TwoFrequencies(system, GOLDEN, cosines=[[[0.0, 0.2], [0.3, 0.0]]]))
    second = np.kron(np.eye(2), [[0.0, 0.2], [0.3, 0.0]])
    other = fr.quasiperiodic_growth(fr.TwoFrequencies(system.doubled, GOLDEN, cosines=[second]))
    assert one.rate == pytest.approx(other.rate, abs=1e-10)


SX, SZ = np.array([[0.0, 1.0], [1.0, 0.0]]), np.diag([1.0, -1.0])
LOSSES = np.diag([0.02, 0.6])


def real_form(matrix: Any) -> Any:
    """Return [[P, -Q], [Q, P]] of P + i Q."""
    return np.block([[matrix.real, -matrix.imag], [matrix.imag, matrix.real]])


def long_rate(mean: Any, first: Any, cosine: Any, sine: Any, periods: int) -> float:
    """Return the weighted mean growth of a complex solution over periods of 1, with the weights of `integrated`."""

    def slope(t: float, x: Any) -> Any:
        wave = np.cos(t) * first + np.cos(GOLDEN * t) * cosine + np.sin(GOLDEN * t) * sine
        return (mean + wave) @ x

    state, logs = np.array([1.0, 0.3j]), np.empty(periods)
    for k in range(periods):
        ends = 2.0 * math.pi * k, 2.0 * math.pi * (k + 1)
        state = solve_ivp(slope, ends, state, method="DOP853", rtol=1e-9, atol=1e-12).y[:, -1]
        size = float(np.linalg.norm(state))
        logs[k], state = math.log(size), state / size
    s = (np.arange(periods) + 0.5) / periods
    weights = np.exp(-1.0 / (s * (1.0 - s)))
    return float(weights @ logs / weights.sum() / (2.0 * math.pi))


@pytest.mark.slow
@pytest.mark.parametrize("gain", [0.0, 0.4])
def test_complex_second_terms_grow_as_a_long_integration_and_as_the_real_form(gain: float) -> None:
    mean = -0.5j * SZ - LOSSES + gain * SX
    first, cosine, sine = -0.25j * SX, -0.2j * SZ, (0.1 - 0.15j) * SX
    system = fr.PeriodicSystem(mean, cosines=[first])
    growth = fr.quasiperiodic_growth(fr.TwoFrequencies(system, GOLDEN, cosines=[cosine], sines=[sine]))
    doubled = fr.PeriodicSystem(real_form(mean), cosines=[real_form(first)])
    by_hand = fr.TwoFrequencies(doubled, GOLDEN, cosines=[real_form(cosine)], sines=[real_form(sine)])
    assert growth.rate == pytest.approx(fr.quasiperiodic_growth(by_hand).rate, abs=1e-10)
    assert growth.rate == pytest.approx(long_rate(mean, first, cosine, sine, 80), abs=1e-8)
    assert growth.status == ("unstable" if gain else "stable")


def test_a_real_system_takes_complex_second_terms() -> None:
    mean, wave = np.array([[0.0, 1.0], [-0.3, -0.1]]), np.array([[0.0, 0.0], [0.2 + 0.3j, 0.0]])
    growth = fr.quasiperiodic_growth(fr.TwoFrequencies(fr.PeriodicSystem(mean), GOLDEN, cosines=[wave]))
    by_hand = fr.TwoFrequencies(fr.PeriodicSystem(real_form(mean)), GOLDEN, cosines=[real_form(wave)])
    assert growth.rate == pytest.approx(fr.quasiperiodic_growth(by_hand).rate, abs=1e-10)


@pytest.mark.parametrize("mean", [-0.5j * SZ, np.array([[0.0, 0.7], [-0.7, 0.0]])])
def test_nothing_grows_where_the_norm_is_kept(mean: Any) -> None:
    problem = fr.TwoFrequencies(fr.PeriodicSystem(mean), GOLDEN, cosines=[-0.25j * SX], sines=[-0.1j * SZ])
    growth = fr.quasiperiodic_growth(problem, tolerance=1e-12)
    assert (growth.rate, growth.error, growth.approximants) == (0.0, 0.0, ())
    assert str(growth) == "<keeps its norm: nothing grows>"
    lossy = fr.PeriodicSystem(mean - 1e-3 * np.eye(2))
    decaying = fr.quasiperiodic_growth(fr.TwoFrequencies(lossy, GOLDEN, cosines=[-0.25j * SX], sines=[-0.1j * SZ]))
    assert decaying.rate == pytest.approx(-1e-3, abs=1e-8)
    assert decaying.approximants


def test_a_chart_of_complex_second_terms_says_what_single_points_say() -> None:
    def family(loss: float, e: float) -> fr.TwoFrequencies:
        system = fr.PeriodicSystem(-0.5j * SZ - loss * np.eye(2), cosines=[-0.2j * SX])
        return fr.TwoFrequencies(system, GOLDEN, cosines=[-1j * e * SZ])

    axes = {"loss": np.array([-0.1, 0.0, 0.1]), "e": np.array([0.1, 0.3])}
    chart = fr.chart(family, axes, growth_tolerance=1e-3)
    assert chart.stable.tolist() == [[False, True, True]] * 2
    assert str(fr.quasiperiodic_growth(family(0.0, 0.1))) == "<keeps its norm: nothing grows>"


@pytest.mark.parametrize(("p", "q"), [(1, 2), (3, 1), (3, 2), (5, 7)])
def test_commensurate_frequencies_are_one_equation_with_harmonics(p: int, q: int) -> None:
    series = np.zeros((2, max(p, q)))
    series[0, q - 1] -= 0.3
    series[1, p - 1] -= 0.25
    one = fr.Hill(-0.3, cosines=series[0], sines=series[1], period=2.0 * math.pi * q)
    growth = fr.quasiperiodic_growth(fr.TwoFrequencies(hill(0.3, 0.3), p / q, sines=(-0.25,)))
    assert growth.approximants[-1][0] == Fraction(p, q)
    assert growth.rate == pytest.approx(fr.stability(one).growth_rate, abs=1e-9)
    assert growth.status == fr.stability(one).status


@pytest.mark.slow
@pytest.mark.parametrize(
    ("p", "q", "edge", "first", "second"),
    [
        (3, 2, -0.8233454447331807, 0.07004693007977626, 0.5573519299907256),
        (7, 5, -0.4937003475021119, 0.5502000188731133, 0.2661337441753649),
        (2, 1, -0.41543315537931625, 0.4799657675448516, 0.25397841591351794),
    ],
)
def test_errors_hold_next_to_an_edge(p: int, q: int, edge: float, first: float, second: float) -> None:
    # Growth leaves zero as a square root there, by which the rounding of the maps' product enters.
    cosines = [0.0] * max(p, q)
    cosines[q - 1] += first
    cosines[p - 1] += second
    for exponent in (8, 10, 12, 14):
        for off in (10.0**-exponent, -(10.0**-exponent)):
            hill = fr.Hill(edge + off, cosines=tuple(cosines), period=2.0 * math.pi * q)
            exact = fr.stability(hill, method="reference", digits=40).growth_rate
            equation = fr.TwoFrequencies(fr.Hill(edge + off, cosines=(first,)), p / q, cosines=(second,))
            growth = fr.quasiperiodic_growth(equation, tolerance=1e-9)
            assert exact is not None
            assert abs(growth.rate - exact) <= growth.error
            assert growth.error < 1e-6


@pytest.mark.parametrize("name", ["Hill", "HillSystem"])
def test_a_chart_says_what_single_points_say(name: str) -> None:
    def family(d: float, e: float) -> fr.TwoFrequencies:
        if name == "Hill":
            return fr.TwoFrequencies(hill(d, e), GOLDEN, cosines=(-0.3,))
        stiffness, wave = [[d, 0.1], [0.1, 2.0 * d]], [[e, 0.5 * e], [0.5 * e, e]]
        return fr.TwoFrequencies(fr.HillSystem(stiffness, [wave]), GOLDEN, cosines=[[[0.3, 0.0], [0.0, 0.1]]])

    axes = {"d": np.linspace(0.1, 1.3, 5), "e": np.array([0.0, 0.2, 0.4])}
    done: list[tuple[int, int]] = []
    chart = fr.chart(family, axes, growth_tolerance=1e-3, growth=True, progress=lambda i, n: done.append((i, n)))
    assert done[-1] == (15, 15)
    for row, e in enumerate(axes["e"]):
        for column, d in enumerate(axes["d"]):
            single = fr.quasiperiodic_growth(family(d, e), tolerance=1e-3)
            assert chart.stable[row, column] == (single.status == "stable")
            assert chart.growth_rate is not None
            assert chart.growth_rate[row, column] == pytest.approx(max(single.rate, 0.0), abs=1e-9 + single.error)
    assert "second frequency" in str(chart)


def test_a_chart_over_the_second_frequency_has_its_tongues() -> None:
    def family(frequency: float, e: float) -> fr.TwoFrequencies:
        return fr.TwoFrequencies(hill(1.0, 0.1), frequency, cosines=(-e,))

    axes = {"frequency": np.array([1.7, 1.98, 2.3]), "e": np.array([0.0, 0.2])}
    chart = fr.chart(family, axes, growth_tolerance=2e-3)
    alpha = fr.mathieu.chart(
        (0.0, 0.2, 2),
        (-1.0, -0.9, 2),
        equation=lambda a, b, c: fr.TwoFrequencies(fr.Hill(b, (-0.1,), damping=c), 1.98, cosines=(-a,)),
        growth_tolerance=2e-3,
    )
    assert chart.stable.tolist() == [[True, True, True], [True, False, True]]
    assert alpha.stable[0].tolist() == [True, False]


def test_charts_and_verdicts_without_a_tolerance_are_refused() -> None:
    def family(d: float, e: float) -> fr.TwoFrequencies:
        return fr.TwoFrequencies(hill(d, e), GOLDEN, cosines=(-0.3,))

    axes = {"d": (0.1, 0.2, 2), "e": (0.1, 0.2, 2)}
    with pytest.raises(ValueError, match=r"growth_tolerance must be greater than zero.*such as 1e-3: 0 has no answer"):
        fr.chart(family, axes)
    with pytest.raises(TypeError, match=r"second frequency; give it to fr\.quasiperiodic_growth"):
        fr.stability(family(0.1, 0.1))  # type: ignore[call-overload]
    with pytest.raises(TypeError, match="must return a TwoFrequencies, as at other points"):
        fr.chart(lambda d, e: family(d, e) if d < 0.15 else hill(d, e), axes, growth_tolerance=1e-3)


def test_frequencies_may_be_exchanged() -> None:
    one = fr.quasiperiodic_growth(fr.TwoFrequencies(hill(0.66, 0.2), GOLDEN, cosines=(-0.3,)))
    turned = fr.Hill(-0.66, cosines=(-0.3,), period=2.0 * math.pi / GOLDEN)
    other = fr.quasiperiodic_growth(fr.TwoFrequencies(turned, 1.0, cosines=(-0.2,)))
    assert abs(one.rate - other.rate) < one.error + other.error + 1e-9


def test_growth_under_slow_beats_is_its_average_over_the_phase() -> None:
    ratio, phases = 3.00001, 64
    growth = fr.quasiperiodic_growth(fr.TwoFrequencies(hill(0.25, 0.2), ratio, cosines=(-0.2,)))
    frozen = [
        fr.stability(fr.Hill(-0.25, (-0.2, 0.0, -0.2 * math.cos(y)), (0.0, 0.0, 0.2 * math.sin(y)))).growth_rate
        for y in np.arange(phases) * (2.0 * math.pi / phases)
    ]
    assert growth.status == "unstable"
    assert abs(growth.rate - np.mean(frozen)) < growth.error < 2e-3


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"frequency": 0.0}, "frequency must be greater than zero"),
        ({"frequency": 1e9}, "frequency must be within 1e-6 and 1e6 times"),
        ({"frequency": math.nan}, "frequency"),
        ({"cosines": ()}, "cosines or sines of the second frequency must be given"),
        ({"cosines": ([[1.0, 0.0]],)}, r"cosines\[0\] must be 1 x 1, got shape"),
        ({"cosines": (math.inf,)}, r"cosines\[0\]"),
        ({"cosines": (0.1j,)}, r"cosines\[0\] must hold real numbers"),
        ({"cosines": 0.2}, "cosines"),
        ({"tolerance": 0.0}, "tolerance must be greater than zero.*tongues are everywhere"),
        ({"most": 5}, "most must be"),
        ({"equation": fr.SquareWave(0.5, -0.2)}, "equation must be one Fourier series"),
        ({"equation": fr.DelaySystem([[1.0]], delayed=[(1.0, [[0.1]])])}, "without delays for two frequencies"),
        ({"equation": 3}, "equation must be"),
    ],
)
def test_wrong_input_is_refused_in_one_line(arguments: dict[str, Any], words: str) -> None:
    given: dict[str, Any] = {"equation": hill(0.66, 0.2), "frequency": GOLDEN, "cosines": (-0.3,), **arguments}
    options = {name: given.pop(name) for name in ("tolerance", "most") if name in given}
    with pytest.raises((TypeError, ValueError), match=words) as error:
        fr.quasiperiodic_growth(fr.TwoFrequencies(**given), **options)
    assert "\n" not in str(error.value)


@pytest.mark.slow
@pytest.mark.kernels
def test_waves_of_one_matrix_have_the_maps_of_waves_of_any(monkeypatch: pytest.MonkeyPatch) -> None:
    slowed = 1.0 if JIT else 0.03  # interpreted, thousands of steps through a period take half a minute
    rng = np.random.default_rng(5)
    shape, stiffness = (slowed * (a + a.T) for a in rng.normal(size=(2, 4, 4)))
    damping = 0.1 * (shape @ shape.T)
    system = fr.HillSystem(stiffness @ stiffness.T, [0.3 * shape, 0.1 * shape], [0.2 * shape], damping=damping)
    problem = fr.TwoFrequencies(system, golden := 0.5 * (1.0 + math.sqrt(5.0)), [0.25 * shape], [0.05 * shape])
    wanted, ratio = np.array([True]), np.array([golden])
    few = quasiperiodic._FewShapes
    found = quasiperiodic._first_order(problem).few
    assert found is not None
    assert len(found.shapes) == 1
    (one,), errors = quasiperiodic._phase_series([problem], ratio, wanted, None)
    monkeypatch.setattr(few, "of", lambda *waves: None)
    (any_waves,), others = quasiperiodic._phase_series([problem], ratio, wanted, None)
    assert np.abs(one - any_waves).max() < errors[0] + others[0]
    assert max(errors[0], others[0]) < 1e-9 * np.abs(one).max()
