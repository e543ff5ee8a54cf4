"""White noise in the coefficients of systems with delays: growth of second moments, and how much noise is tolerated."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.sparse.linalg import LinearOperator, eigs

import floquetrod as fr
from floquetrod.equations.delayed_moments import DelayedMoments
from floquetrod.floquet.multipliers import renewal_equation
from tests.conftest import depth, some

ONE = [[1.0]]
TAU = 2.0 * math.pi
TABLE = [((1.2, 0.5, 0.1, 0.3), -0.148642993371), ((0.6, 0.8, 0.15, 0.2), -0.086036895109)]
"""d, e, c, s of y'' + 2 c y' + (d + e cos t) y = s y xi, and the growth rate of second moments."""


def growth(system: fr.DelaySystem, noise: Any, **options: Any) -> tuple[float, float]:
    """Return the growth rate of second moments and its error."""
    found = fr.stability(system, noise=noise, **options)
    return found.exponents[0].real, found.exponent_errors[0]


def by_steps(
    matrices: Callable[[float], tuple[Any, Any]], noise: tuple[Any, Any], delay: float, period: float, steps: int
) -> float:
    """Return the growth rate of E[Z Z^T], Z the last values of x' = A x + B x(t - delay) + (G x + H x(t - delay)) xi.

    Midpoint steps of the drift, kicks of variance h between them; errors are powers of h from the first on.
    """
    h = period / steps
    back = round(delay / h)
    assert abs(back * h - delay) < 1e-12
    both = np.concatenate([np.atleast_2d(matrix).astype(float) for matrix in noise], axis=1)
    n = len(both)
    now, last = np.arange(n), np.arange(n * back, n * (back + 1))
    steps_of = []
    for k in range(steps):
        a, b = (np.atleast_2d(matrix).astype(float) for matrix in matrices((k + 0.5) * h))
        inverse = np.linalg.inv(np.eye(n) - 0.5 * h * a)
        steps_of.append(inverse @ np.concatenate([np.eye(n) + 0.5 * h * a, 0.5 * h * b, 0.5 * h * b], axis=1))
    ends, used = np.concatenate([now, last]), np.concatenate([now, last - n, last])
    size = n * (back + 1)

    def over_period(flat: Any) -> Any:
        moments = flat.reshape(size, size).copy()
        moments = 0.5 * (moments + moments.T)
        for row in steps_of:
            moments[:n, :n] += h * both @ moments[np.ix_(ends, ends)] @ both.T
            new = row @ moments[used]
            corner = new[:, used] @ row.T
            moments[n:, n:] = moments[:-n, :-n]
            moments[:n, :n], moments[:n, n:], moments[n:, :n] = corner, new[:, :-n], new[:, :-n].T
        return moments.ravel()

    whole = LinearOperator((size**2, size**2), matvec=over_period, dtype=np.float64)
    values = eigs(whole, k=3, v0=np.eye(size).ravel(), ncv=24, tol=1e-11, return_eigenvectors=False)
    return math.log(float(values.real.max())) / period


def extrapolated(matrices: Any, noise: Any, delay: float, period: float, *, steps: int) -> tuple[float, float]:
    """Return the growth rate by steps, extrapolated by three sizes, and twice the last change."""
    rates = [by_steps(matrices, noise, delay, period, steps * 2**k) for k in range(4)]
    for power in (1, 2, 3):
        last = rates[-1]
        rates = [fine + (fine - coarse) / (2**power - 1) for coarse, fine in pairwise(rates)]
    return rates[0], 4.0 * abs(rates[0] - last) + 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(("numbers", "rate"), TABLE)
def test_without_a_delay_moments_grow_as_the_table_says(numbers: Any, rate: float) -> None:
    d, e, c, s = numbers
    system = fr.DelaySystem([[d]], [[[e]]], damping=[[2.0 * c]])
    found = fr.stability(system, noise=[(ONE, s)])
    assert abs(found.exponents[0].real - rate) <= found.exponent_errors[0] + 1e-12
    assert found.exponent_errors[0] < 1e-11
    assert found.status == "stable"
    assert "mean-square stable" in repr(found)
    assert "second moments decay" in str(found.report())


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(40, 4)))
def test_without_a_delay_the_verdict_is_that_of_the_system_without(seed: int) -> None:
    rng = np.random.default_rng([54, seed])
    n = int(rng.integers(1, 3))
    noise = [(rng.normal(size=(n, n)), 0.4) for _ in range(int(rng.integers(1, 3)))]
    period = float(rng.uniform(0.5, 4.0))
    interpretation = str(rng.choice(["ito", "stratonovich"]))
    kind = seed % 4
    plain: Any
    delayed: Any
    if kind == 0:  # of second order
        stiffness, wave = np.diag(rng.uniform(0.5, 3.0, n)), 0.3 * rng.normal(size=(n, n))
        named: dict[str, Any] = {"damping": np.diag(rng.uniform(0.1, 0.6, n)), "period": period}
        plain, delayed = fr.HillSystem(stiffness, [wave], **named), fr.DelaySystem(stiffness, [wave], **named)
    elif kind == 1:
        mean, waves = rng.normal(size=(n, n)) - np.eye(n), [0.5 * rng.normal(size=(n, n))]
        plain, delayed = (make(mean, waves, period=period) for make in (fr.PeriodicSystem, fr.DelaySystem.first_order))
    elif kind == 2:
        pieces = [(share * period, rng.normal(size=(n, n)) - np.eye(n)) for share in (0.3, 0.7)]
        plain = fr.PeriodicSystem.from_pieces(pieces)
        delayed = fr.DelaySystem.first_order_from_pieces(pieces)
    else:  # with a delayed term of zero
        mean = rng.normal(size=(n, n)) - np.eye(n)
        plain = fr.PeriodicSystem(mean, period=period)
        delayed = fr.DelaySystem.first_order(mean, period=period, delayed=[(0.7, np.zeros((n, n)))])
    expected = fr.stability(plain, noise=noise, interpretation=interpretation)
    rate, error = growth(delayed, noise, interpretation=interpretation)
    assert abs(rate - expected.exponents[0].real) <= error + expected.exponent_errors[0] + 1e-12
    assert error < 1e-7


def variance(a: float, b: float) -> float:
    """Return the variance of x' = a x + b x(t - 1) + xi, the integral of g^2 (Kuechler and Mensch 1992)."""
    if abs(b) < -a:
        root = math.sqrt(a * a - b * b)
        return (b * math.sinh(root) - root) / (2.0 * root * (a + b * math.cosh(root)))
    root = math.sqrt(b * b - a * a)
    return (b * math.sin(root) - root) / (2.0 * root * (a + b * math.cos(root)))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(60, 4)))
def test_noise_of_a_delayed_equation_is_tolerated_up_to_one_over_its_variance(seed: int) -> None:
    rng = np.random.default_rng([55, seed])
    a, b = rng.uniform(-2.0, 0.5), rng.uniform(-1.5, 1.5)
    while abs(abs(a) - abs(b)) < 0.05 or fr.stability(make := hayes(a, b)).status != "stable":
        a, b = rng.uniform(-2.0, 0.5), rng.uniform(-1.5, 1.5)
    limit = variance(a, b) ** -0.5
    # The delay of noise alone changes no integral of g^2, and slows growth and decay.
    for noise in ([(ONE, 1.0)], [([[0.0]], 1.0, [(float(rng.uniform(0.2, 2.0)), ONE)])]):
        found = fr.critical_noise(make, noise)
        assert abs(found.factor - limit) <= found.error + 1e-14
        assert found.error < 1e-8
        assert (found.below.status, found.above.status) == ("stable", "unstable")  # type: ignore[union-attr]
        grown = [fr.stability(make, noise=[(m, f * limit, *rest) for m, _, *rest in noise]) for f in (0.999, 1.001)]
        assert [one.status for one in grown] == ["stable", "unstable"]


def hayes(a: float, b: float) -> fr.DelaySystem:
    return fr.DelaySystem.first_order([[a]], delayed=[(1.0, [[b]])])


def drawn(rng: np.random.Generator) -> tuple[fr.DelaySystem, Any, Any]:
    """Return a system of period 1, its noise, and the arguments of `by_steps`."""
    delay = float(rng.choice([0.5, 1.0, 1.5]))
    s, wave = float(rng.uniform(0.2, 0.9)), float(rng.uniform(0.0, 1.5))
    if rng.random() < 0.5:
        a, b = float(rng.uniform(-2.5, -1.0)), float(rng.uniform(-1.0, 1.0))
        g, later = float(rng.normal()), float(rng.normal())
        system = fr.DelaySystem.first_order([[a]], [[[wave]]], period=1.0, delayed=[(delay, [[b]])])
        noise = [([[g]], s, [(delay, [[later]])])]

        def matrices(t: float) -> Any:
            return [[a + wave * math.cos(TAU * t)]], [[b]]

        return system, noise, (matrices, (s * g, s * later), delay, 1.0)
    k, c, b = float(rng.uniform(2.0, 9.0)), float(rng.uniform(0.5, 1.5)), float(rng.uniform(-0.5, 0.5))
    g, later = float(rng.normal()), float(rng.normal())
    system = fr.DelaySystem([[k]], [[[wave]]], damping=[[c]], period=1.0, delayed=[(delay, [[0.0]], [[[b]]])])
    noise = [([[g]], s, [(delay, [[later]])])]

    def of_second_order(t: float) -> Any:
        w = math.cos(TAU * t)
        return [[0.0, 1.0], [-k - wave * w, -c]], [[0.0, 0.0], [-b * w, 0.0]]

    at_rate = [np.array([[0.0, 0.0], [s * value, 0.0]]) for value in (g, later)]
    return system, noise, (of_second_order, at_rate, delay, 1.0)


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(k, marks=pytest.mark.slow) for k in (0, *some(range(2, 40), 12, 6)))]
)
def test_moments_grow_as_those_of_short_steps(seed: int) -> None:
    system, noise, arguments = drawn(np.random.default_rng([56, seed]))
    expected, uncertain = extrapolated(*arguments, steps=8 if seed < 2 else 16)
    rate, error = growth(system, noise)
    assert abs(rate - expected) <= error + uncertain
    assert uncertain < 2e-2
    assert error < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in some(range(1, 12), 4, 2))])
def test_sources_of_rank_two_on_present_and_delayed_values(seed: int) -> None:
    rng = np.random.default_rng([59, seed])
    a, b, wave = rng.normal(size=(2, 2)) - 2.0 * np.eye(2), 0.5 * rng.normal(size=(2, 2)), 0.7 * rng.normal(size=(2, 2))
    g, later = 0.4 * rng.normal(size=(2, 2)), 0.4 * rng.normal(size=(2, 2))
    delay = (0.5, 1.0, 1.5)[seed % 3]
    system = fr.DelaySystem.first_order(a, [wave], period=1.0, delayed=[(delay, b)])

    def matrices(t: float) -> Any:
        return a + wave * math.cos(TAU * t), b

    expected, uncertain = extrapolated(matrices, (g, later), delay, 1.0, steps=8)
    rate, error = growth(system, [(g, 1.0, [(delay, later)])])
    assert abs(rate - expected) <= error + uncertain
    assert uncertain < 1e-2
    assert error < 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.slow) for k in some(range(1, 20), 6, 3))])
def test_the_verdict_changes_at_the_critical_noise(seed: int) -> None:
    system, noise, _ = drawn(np.random.default_rng([57, seed]))
    if fr.stability(system).status != "stable":
        with pytest.raises(ValueError, match="must decay without noise"):
            fr.critical_noise(system, noise)
        return
    found = fr.critical_noise(system, noise)
    assert found.error < 1e-7 * found.factor
    for factor, status in ((found.factor * (1 - 1e-6), "stable"), (found.factor * (1 + 1e-6), "unstable")):
        (matrix, s, later) = noise[0]
        assert fr.stability(system, noise=[(matrix, factor * s, later)]).status == status


@pytest.mark.slow
@pytest.mark.parametrize("seed", some(range(12), 4, 2))
def test_coefficients_that_jump(seed: int) -> None:
    rng = np.random.default_rng([58, seed])
    low, high, b = rng.uniform(-1.0, 1.0, 3).tolist()
    low, high = 1.5 * low - 1.5, 1.5 * high - 1.5
    delay, s, later = float(rng.choice([0.5, 1.0])), float(rng.uniform(0.2, 0.8)), float(rng.normal())
    system = fr.DelaySystem.first_order_from_pieces(
        [(0.25, [[low]]), (0.75, [[high]])], delayed=[(delay, [(0.25, [[b]]), (0.75, [[0.0]])])]
    )

    def matrices(t: float) -> Any:
        return ([[low]], [[b]]) if t < 0.25 else ([[high]], [[0.0]])

    expected, uncertain = extrapolated(matrices, (s, s * later), delay, 1.0, steps=16)
    rate, error = growth(system, [(ONE, s, [(delay, [[later]])])])
    assert abs(rate - expected) <= error + uncertain
    assert error < 1e-8


@pytest.mark.slow
def test_milling_with_noise_in_the_cutting_force_has_the_moments_of_short_steps() -> None:
    k, c, cut = 1.0, 0.3, 0.25
    tooth = [(1.5, [[k + cut]]), (2.5, [[k]])]
    system = fr.DelaySystem.from_pieces(tooth, damping=[[c]], delayed=[(4.0, [(1.5, [[-cut]]), (2.5, [[0.0]])])])

    def matrices(t: float) -> Any:
        on = cut if t < 1.5 else 0.0
        return [[0.0, 1.0], [-k - on, -c]], [[0.0, 0.0], [on, 0.0]]

    s = 0.2
    at_rate = [np.array([[0.0, 0.0], [value, 0.0]]) for value in (-s, s)]
    expected, uncertain = extrapolated(matrices, at_rate, 4.0, 4.0, steps=16)
    rate, error = growth(system, [(ONE, s, [(4.0, [[-1.0]])])])
    assert abs(rate - expected) <= error + uncertain
    assert uncertain < 1e-3
    assert error < 1e-9


def test_noise_beside_what_decays_slowest_leaves_growth_as_it_is() -> None:
    system = fr.DelaySystem.first_order(np.diag([-3.0, 0.0]), delayed=[(1.0, np.diag([0.0, -0.5]))])
    noiseless = fr.stability(system).exponents[0].real
    rate, error = growth(system, [(np.diag([1.0, 0.0]), 0.5)])
    assert abs(rate - 2.0 * noiseless) <= error + 1e-9
    assert error < 1e-6
    stronger = growth(system, [(np.diag([1.0, 0.0]), 3.0)])[0]
    assert stronger == pytest.approx(2.0 * -3.0 + 9.0, abs=1e-9)
    assert growth(system, [(np.eye(2), 0.0)])[0] == pytest.approx(rate, abs=1e-9)


def test_sources_are_independent_and_ranks_add_up() -> None:
    a = np.array([[-1.0, 0.4], [-0.7, -1.3]])
    b = np.array([[0.2, -0.1], [0.3, 0.1]])
    system = fr.DelaySystem.first_order(a, delayed=[(0.8, b)])
    turning = [[0.0, -1.0], [1.0, 0.0]]
    one = growth(system, [(turning, 0.5)])
    # Turned coordinates, x -> R x, turn every matrix.
    r = np.array([[0.6, -0.8], [0.8, 0.6]])
    other = growth(fr.DelaySystem.first_order(r @ a @ r.T, delayed=[(0.8, r @ b @ r.T)]), [(turning, 0.5)])
    assert abs(one[0] - other[0]) <= one[1] + other[1]
    # Two sources of one matrix are one source whose s^2 is the sum.
    two = growth(system, [(turning, 0.3), (turning, 0.4)])
    assert abs(one[0] - two[0]) <= one[1] + two[1]
    split = growth(system, [(turning, 0.5, [(Fraction(4, 5), np.eye(2)), (0.8, -np.eye(2))])])
    assert abs(one[0] - split[0]) <= one[1] + split[1]


def test_stratonovichs_drift_reaches_delayed_values() -> None:
    a, b, s, later = -1.0, 0.3, 0.6, 0.7
    noise = [(ONE, s, [(1.0, [[later]])])]
    given = growth(hayes(a, b), noise, interpretation="stratonovich")
    drift = 0.5 * s * s
    explicit = growth(hayes(a + drift, b + drift * later), noise)
    assert abs(given[0] - explicit[0]) <= given[1] + explicit[1] + 1e-13
    oscillator = fr.DelaySystem([[2.0]], damping=[[0.4]], delayed=[(1.0, [[0.3]])])
    both = [growth(oscillator, noise, interpretation=each) for each in ("ito", "stratonovich")]
    assert both[0] == both[1]


@pytest.mark.slow
def test_coefficients_with_errors_have_larger_ones() -> None:
    exact = fr.DelaySystem.first_order([[-1.0]], [[[0.4]]], period=1.0, delayed=[(1.0, [[0.5]])])
    off = fr.DelaySystem.first_order([[-1.0]], [[[0.4]]], period=1.0, delayed=[(1.0, [[0.5]])], coefficient_error=1e-4)
    one, other = growth(exact, [(ONE, 0.5)]), growth(off, [(ONE, 0.5)])
    assert one[0] == pytest.approx(other[0], abs=1e-12)
    assert one[1] < 1e-9
    assert 1e-4 < other[1] < 1e-2


def test_what_takes_too_much_is_undecided_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(renewal_equation, "_MOST_ROWS", 5)
    found = fr.stability(hayes(-1.0, 0.3), noise=[(ONE, 0.1)])
    assert found.status == "undecided"
    assert "too many rows" in found.note
    with pytest.raises(ValueError, match="largest stable intensity"):
        fr.critical_noise(hayes(-1.0, 0.3), [(ONE, 0.1)])


@pytest.mark.slow
def test_the_verdict_has_what_other_verdicts_have() -> None:
    system = fr.DelaySystem([[1.2]], [[[0.5]]], damping=[[0.3]], delayed=[(2.0, [[0.1]])])
    found = fr.stability(system, noise=[(ONE, 0.9, [(3.0, ONE)])])
    assert isinstance(found.equation, DelayedMoments)
    assert found.equation == fr.stability(system, noise=[(ONE, 0.9, [(3.0, ONE)])]).equation
    assert found.method == "renewal"
    numbers = found.as_dict()
    assert numbers["delays"] == [2.0, 3.0]
    assert numbers["status"] == found.status == "unstable"
    assert found.resonances == ()
    assert math.isnan(found.damping_to_stabilise)
    assert any("Kuechler" in reference for reference in found.references)
    assert "1 noise source" in str(found.report())
    with pytest.raises(TypeError, match="without delays for a monodromy matrix"):
        _ = found.monodromy


@pytest.mark.parametrize(
    ("noise", "kind", "says"),
    [
        (0.3, TypeError, "noise must be a sequence"),
        ([], ValueError, "one source at least"),
        ([(ONE,)], TypeError, r"as noise\[0\]"),
        ([(ONE, -1.0)], ValueError, r"noise\[0\]\[1\] must be from 0"),
        ([(ONE, [0.1, 0.2])], ValueError, r"noise\[0\] must be one matrix and one intensity"),
        ([(np.eye(2), 1.0)], ValueError, r"noise\[0\]\[0\]"),
        ([(ONE, 1.0, 2.0)], TypeError, r"noise\[0\]\[2\] must be a sequence of \(delay, matrix\)"),
        ([(ONE, 1.0, [(0.0, ONE)])], ValueError, r"noise\[0\]\[2\]\[0\]\[0\] must be"),
        ([(ONE, 1.0, [(1.0, np.eye(2))])], ValueError, r"noise\[0\]\[2\]\[0\]\[1\]"),
        ([(ONE, math.nan)], ValueError, r"noise\[0\]\[1\]"),
    ],
)
def test_bad_noise_is_told(noise: Any, kind: type[Exception], says: str) -> None:
    for ask in (lambda: fr.stability(hayes(-1.0, 0.3), noise=noise), lambda: fr.critical_noise(hayes(-1, 0.3), noise)):
        with pytest.raises(kind, match=says):
            ask()


def test_what_noise_with_delays_cannot_be_asked_is_told() -> None:
    system, noise = hayes(-1.0, 0.3), [(ONE, 0.3)]
    assert fr.stability(system, "renewal", noise=noise) == fr.stability(system, noise=noise)
    with pytest.raises(ValueError, match="method must be one of 'auto', 'renewal'"):
        fr.stability(system, "collocation", noise=noise)
    with pytest.raises(TypeError, match="must be without delays here"):
        fr.second_moments(system, noise)
    with pytest.raises(TypeError, match="without delays for a proof under noise"):
        fr.certify(system, noise=noise)
    with pytest.raises(ValueError, match="interpretation must be 'ito'"):
        fr.critical_noise(system, noise, "stratonovich")
    with pytest.raises(ValueError, match="must decay without noise"):
        fr.critical_noise(hayes(0.5, 0.3), noise)
    with pytest.raises(ValueError, match="noise must have an intensity above zero"):
        fr.critical_noise(system, [(ONE, 0.0)])
    with pytest.raises(TypeError, match=r"noise must be a sequence .*as noise\[0\]"):
        fr.stability(fr.PeriodicSystem([[-1.0]]), noise=[(ONE, 0.1, [(1.0, ONE)])])
    with pytest.raises(TypeError, match="equation must be"):
        fr.stability(fr.stability(system, noise=noise).equation)
