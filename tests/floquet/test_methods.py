"""Every method against every other, and the result they share."""

from __future__ import annotations

import cmath
import math

import mpmath
import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.floquet.mathieu_chains.truncated_determinant import _log_product
from floquetrod.floquet.registry import METHODS, applicable, is_approximation, service
from floquetrod.floquet.verdict import Cost, Interval, Verdict, classify
from floquetrod.methods import determinant, discriminant_excess, spectral
from tests.conftest import depth
from tests.strategies import decades, hills, mathieus, near_boundary_points, numbers, square_waves


def exact_results(equation: fr.Mathieu | fr.Meissner | fr.Hill) -> list[fr.results.Stability]:
    """Results of the methods that claim to be exact for this equation."""
    return [r for r in fr.compare(equation).results if not is_approximation(equation, r.method)]


def check_agreement(equation: fr.Mathieu | fr.Meissner | fr.Hill) -> None:
    results = exact_results(equation)
    truth = next(result for result in results if result.method == "reference")
    for one in (result for result in results if result is not truth):
        assert {one.status, truth.status} != {"stable", "unstable"}, (one, truth)
        if not (math.isfinite(one.error) and math.isfinite(truth.discriminant)):
            continue
        scale = max(1.0, abs(truth.discriminant))
        assert abs(one.discriminant - truth.discriminant) <= (one.error + truth.error) * scale, (one, truth)
        if one.status == truth.status == "unstable":
            # A growth rate follows from the excess; near a boundary it feels the square root of its error.
            rate = math.sqrt(one.error) / one.period
            assert one.growth_rate == pytest.approx(truth.growth_rate, rel=1e-7, abs=4.0 * rate), (one, truth)


@settings(max_examples=depth(40, 10))
@given(mathieus(largest_alpha=30.0, beta=(-30.0, 5.0), largest_damping=0.3))
def test_methods_agree_on_mathieu(equation: fr.Mathieu) -> None:
    check_agreement(equation)


@settings(max_examples=depth(30, 7))
@given(near_boundary_points())
def test_methods_agree_beside_boundaries(point: tuple[float, float]) -> None:
    check_agreement(fr.Mathieu(*point))


@settings(max_examples=depth(30, 7))
@given(square_waves(largest_damping=0.3))
def test_methods_agree_on_square_waves(equation: fr.Meissner) -> None:
    check_agreement(equation)


@settings(max_examples=depth(25, 6))
@given(hills(largest=10.0, largest_damping=0.3))
def test_methods_agree_on_hill(equation: fr.Hill) -> None:
    check_agreement(equation)


@settings(max_examples=depth(60, 15))
@given(mathieus(largest_damping=0.3) | square_waves(largest_damping=0.3))
def test_multipliers_follow_from_liouville_and_the_trace(equation: fr.Mathieu | fr.Meissner) -> None:
    result = fr.stability(equation)
    first, second = result.multipliers
    if cmath.isfinite(first):
        assert first * second == pytest.approx(cmath.exp(-4.0 * math.pi * equation.damping), rel=1e-9)
        assert first + second == pytest.approx(result.discriminant, rel=1e-9, abs=1e-9)
    else:
        assert math.isfinite(result.log_abs_discriminant)
        assert result.exponents[0].real * result.period == pytest.approx(result.log_abs_discriminant, rel=1e-9)
    assert abs(first) >= abs(second)


@given(near_boundary_points() | st.tuples(st.floats(0.01, 50.0), st.floats(-50.0, 5.0)))
def test_counts_agree_with_determinants(point: tuple[float, float]) -> None:
    one, other = spectral(fr.Mathieu(*point)), determinant(fr.Mathieu(*point))
    assume("undecided" not in (one.status, other.status))
    assert one.status == other.status
    assert one.interval == other.interval


def test_numbers_beyond_a_double() -> None:
    # A growth of 800 per unit tau: the discriminant is beyond the range of a double, its logarithm is not.
    for method, error in (("spectral", 1e-6), ("leapfrog", 1e-2)):  # leapfrog's steps are short against tau, not 1/800
        verdict = fr.stability(fr.Mathieu(1.0, 6.4e5), method=method)
        assert verdict.discriminant == math.inf
        assert verdict.growth_rate == pytest.approx(800.0, rel=error)
        assert math.isinf(abs(verdict.multipliers[0]))
    found = fr.mathieu.discriminant([1.0, 0.0], [6.4e5, 0.25], [0.0, 0.1])
    assert found[0] == math.inf
    assert found[1] == pytest.approx(2.0 * math.cosh(2.0 * math.pi * math.sqrt(0.26)) * math.exp(-0.2 * math.pi))
    assert fr.stability(fr.Mathieu(1.0, 2.5e3), method="leapfrog").growth_rate == pytest.approx(50.0, rel=1e-3)


def test_the_papers_truncation() -> None:
    forty = determinant(fr.Mathieu(0.5, -0.25), terms=40)
    assert forty.cost == Cost(161, "rows")
    exact = spectral(fr.Mathieu(0.5, -0.25))
    assert abs(forty.discriminant - exact.discriminant) <= forty.error * abs(exact.discriminant)
    few = determinant(fr.Mathieu(400.0, -2000.0), terms=40)
    assert few.status == "undecided"
    assert "40 terms are too few" in few.note


def test_determinants_converge_as_the_seventh_power_of_the_terms() -> None:
    exact = spectral(fr.Mathieu(2.0, -1.3)).discriminant
    errors = [abs(determinant(fr.Mathieu(2.0, -1.3), terms=n).discriminant - exact) for n in (20, 40, 80)]
    orders = [math.log2(errors[i] / errors[i + 1]) for i in (0, 1)]
    assert orders == pytest.approx([7.0, 7.0], abs=0.4)


@given(decades(1.0, 2e4), numbers(-40.0, 0.999))
def test_the_product_of_the_rows_left_out_is_as_exact_as_stated(kappa: float, share: float) -> None:
    first = kappa + 1.0
    h2 = share * abs(share) * first * first
    value, rounding = _log_product(kappa, h2)
    with mpmath.workdps(60):
        h = mpmath.sqrt(mpmath.mpc(h2))
        truth = 2 * mpmath.loggamma(first) - mpmath.loggamma(first - h) - mpmath.loggamma(first + h)
        assert abs(truth.real - value) <= rounding


EXTREMES = st.sampled_from((0.0, 5e-324, -5e-324, 1e-320, 1e-300, -1e-200, 1e-160, 1e-120, 1e-30))
"""What leaves the range of a double when it is squared, and what is left of it."""


def extreme_equations() -> st.SearchStrategy[fr.Mathieu | fr.Meissner | fr.Hill]:
    """Equations at, near and far from boundaries, with denormal coefficients and long periods among them."""
    amplitudes = EXTREMES | numbers(-30.0, 30.0) | decades(1e-9, 1.0)
    edges = st.tuples(st.integers(0, 10), EXTREMES | numbers(-1e-9, 1e-9)).map(lambda p: -0.25 * p[0] ** 2 + p[1])
    means = EXTREMES | numbers(-60.0, 10.0) | edges
    damping = st.just(0.0) | decades(1e-9, 0.5) | st.just(5e-324)
    series = st.lists(EXTREMES | numbers(-3.0, 3.0), max_size=3).map(tuple)
    hill = st.builds(fr.Hill, EXTREMES | numbers(-3.0, 1.0), series, series, decades(1e-2, 30.0), damping)
    return st.builds(fr.Mathieu, amplitudes, means, damping) | st.builds(fr.Meissner, amplitudes, means, damping) | hill


@settings(max_examples=depth(100, 6))
@given(extreme_equations(), st.none() | st.integers(2, 60) | st.integers(2, 5000))
@example(fr.Mathieu(1e-9, -23.0), 10)
@example(fr.Mathieu(5e-324, -0.25), None)
@example(fr.Mathieu(0.0, 0.0), 5)
@example(fr.Hill(-0.5, cosines=(0.7,), period=1000.0), None)
def test_stated_errors_cover_the_truth(equation: fr.Mathieu | fr.Meissner | fr.Hill, terms: int | None) -> None:
    exact = discriminant_excess(equation, 30)
    with mpmath.workdps(40):
        period = mpmath.mpf(equation.period) if isinstance(equation, fr.Hill) else 2 * mpmath.pi
        truth = exact.sign * (4 * exact.excess + 2) * mpmath.exp(-period * equation.damping)
    for name in (method.name for method in applicable(equation)):
        if name == "reference":
            continue
        if name == "square_wave" and is_approximation(equation, name):
            continue
        options = {"terms": terms} if name == "determinant" else {}
        result = fr.stability(equation, method=name, **options)
        assert not math.isnan(result.error)
        assert math.isnan(result.growth_rate) == (not result.exponents)
        if math.isinf(result.error):
            assert result.status == "undecided"
            assert result.note
        elif not is_approximation(equation, name):
            off = truth - result.discriminant if math.isfinite(result.discriminant) else 0
            assert abs(off) <= result.error * max(1, abs(truth))
            if abs(exact.excess) > exact.error and not equation.damping:
                assert result.status in ("undecided", "unstable" if exact.excess > 0 else "stable")


def test_a_period_too_long_for_eigenvalues_is_undecided_and_says_so() -> None:
    long = fr.Hill(-0.5, cosines=(0.7,), period=1000.0)
    result = fr.stability(long, method="spectral")
    assert result.status == "undecided"
    assert "use method='monodromy'" in result.note
    assert fr.stability(long).growth_rate == pytest.approx(0.0863327067952, rel=1e-10)  # by the reference method


def test_a_boundary_within_rounding_is_undecided_by_doubles_and_decided_by_more_digits() -> None:
    edge = -0.25 * fr.mathieu.characteristic_values(1, 2.0, "a")
    equation = fr.Mathieu(1.0, edge)
    assert spectral(equation).status == "undecided"
    assert fr.stability(equation).status == fr.certify(equation).status != "undecided"
    assert fr.stability(equation).method == "reference"


@pytest.mark.parametrize("mean", [1e-200, 0.0, -1e-200])
def test_damping_does_not_hide_a_boundary_within_rounding(mean: float) -> None:
    # Undamped motion u then grows at the damping rate, to all digits of a double.
    assert spectral(fr.Hill(mean, cosines=(1e-300,), damping=4e-7)).status == "undecided"


def test_intervals_are_numbered_as_in_the_field() -> None:
    assert spectral(fr.Mathieu(0.1, 0.3)).interval == Interval("tongue", 0)
    assert spectral(fr.Mathieu(0.1, -0.1)).interval == Interval("stability", 0)
    assert spectral(fr.Mathieu(0.1, -0.25)).interval == Interval("tongue", 1)
    assert spectral(fr.Mathieu(0.1, -0.5)).interval == Interval("stability", 1)
    assert spectral(fr.Mathieu(1.0, -1.0 - 1.0 / 12.0)).interval == Interval("tongue", 2)


THIN = fr.Mathieu(1e-8, -0.25)


def is_fine(method: str) -> bool:
    """Return whether the error that a method states in its record is below the growth in the thin tongue."""
    return not is_approximation(THIN, method) and service(THIN, method).accuracy < 1e-9


@pytest.mark.parametrize("method", [m.name for m in applicable(THIN) if is_fine(m.name)])
def test_the_thin_tongue_is_seen_by_every_exact_method(method: str) -> None:
    result = fr.stability(THIN, method=method)
    assert result.status == "unstable"
    assert result.growth_rate == pytest.approx(5.0e-9, rel=1e-6)


def test_huge_growth_is_carried_as_a_logarithm() -> None:
    result = fr.stability(fr.Mathieu(1e6, 1e5))
    assert math.isinf(result.discriminant)
    assert math.isfinite(result.log_abs_discriminant)
    assert result.growth_rate * 2.0 * math.pi == pytest.approx(result.log_abs_discriminant, rel=1e-12)
    assert result.multipliers[1] == 0.0
    assert "exp(" in repr(result)


def test_damping_can_destabilise() -> None:
    assert fr.stability(fr.Mathieu(1.0, 0.378488)).stable
    assert fr.stability(fr.Mathieu(1.0, 0.378488, damping=0.03)).stable is False
    strong = fr.stability(fr.Mathieu(0.3, -0.25, damping=0.2))
    assert strong.stable
    assert abs(strong.multipliers[0]) < 1.0


@pytest.mark.parametrize("damping", [0.0, 0.02, 0.4])
def test_a_report_says_which_discriminants_are_stable(damping: float, rng: np.random.Generator) -> None:
    for alpha, beta in rng.uniform((0.0, -2.0), (2.0, 0.5), (depth(40, 10), 2)).tolist():
        verdict = fr.stability(fr.Mathieu(alpha, beta, damping))
        text = dict(verdict.report().lines)["trace"]
        bound = float(text.rpartition("stable where its magnitude is below ")[2])
        assert bound == pytest.approx(1.0 + abs(np.prod(verdict.multipliers)), rel=1e-5)
        assert verdict.stable == (abs(verdict.discriminant) < bound)
    assert damping > 0.0 or bound == 2.0


def test_comparison_is_a_table() -> None:
    comparison = fr.compare(fr.Mathieu(0.5, -0.25))
    assert comparison.agree
    names = [r.method for r in comparison.results]
    assert names == [method.name for method in applicable(comparison.equation)]
    assert {"spectral", "determinant", "monodromy", "square_wave", "leapfrog", "reference"} <= set(names)
    lines = repr(comparison).splitlines()
    assert lines[0].startswith("UNSTABLE: grows at ")
    assert lines[5].split()[:2] == ["method", "verdict"]
    assert "all methods agree" in lines[-1]
    # A tongue that the 100-period test cannot see: an approximation says otherwise, with the reason.
    thin = fr.compare(fr.Mathieu(0.01, -0.25))
    assert thin.agree
    assert "leapfrog" in thin.approximations
    told = repr(thin).splitlines()
    assert "approximations that say otherwise: leapfrog" in told[-1]
    assert any("leapfrog: cannot see growth below" in line for line in told)


def test_auto_takes_no_options_and_names_are_checked() -> None:
    with pytest.raises(TypeError, match="method='auto' accepts no options"):
        fr.stability(fr.Mathieu(1.0, 0.0), digits=30)
    with pytest.raises(ValueError, match="method must be one of 'auto', 'spectral'"):
        fr.stability(fr.Mathieu(1.0, 0.0), method="magic")
    for method, taken in (
        ("spectral", "no options"),
        ("determinant", "terms"),
        ("leapfrog", "step and periods and limit"),
    ):
        with pytest.raises(TypeError, match=f"^method='{method}' takes {taken}, got digits$"):
            fr.stability(fr.Mathieu(1.0, 0.0), method=method, digits=30)
    with pytest.raises(TypeError, match=r"^method='reference' takes digits, got most_digits$"):
        fr.stability(fr.Mathieu(1.0, 0.0), method="reference", digits=30, most_digits=60)
    with pytest.raises(TypeError, match="equation must be an Equation, such as Mathieu"):
        fr.stability("Mathieu")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="equation must be one Fourier series"):
        fr.stability(fr.Meissner(1.0, 0.0), method="spectral")


def test_compare_says_which_methods_do_not_apply_and_why() -> None:
    for problem in (fr.Mathieu(0.5, -0.25), fr.Meissner(0.5, -0.25), fr.HillSystem([[1.0]], gyroscopic=None)):
        comparison = fr.compare(problem)
        assert [r.method for r in comparison.results] == [method.name for method in applicable(problem)]
        left_out = dict(comparison.left_out)
        assert {r.method for r in comparison.results} | left_out.keys() == {method.name for method in METHODS}
        for method, why in left_out.items():
            kind = next(each for each in METHODS if each.name == method).service(problem)
            with pytest.raises(
                ValueError if kind is None else TypeError, match="method must be" if kind is None else why
            ):
                fr.stability(problem, method)
    assert dict(fr.compare(fr.Mathieu(0.5, -0.25)).left_out)["segmented"] == (
        "segmented is a method for systems, not for scalar equations"
    )


def test_the_verdict_decides_only_beyond_the_error() -> None:
    equation = fr.Mathieu(0.5, -0.25)

    def status(excess: float, error: float) -> str:
        return classify(equation, "test", sign=1, excess=excess, excess_error=error, cost=Cost(1, "step")).status

    assert [status(x, 1e-6) for x in (1e-5, 1e-7, 0.0, -1e-7, -1e-5)] == [
        "unstable",
        "undecided",
        "undecided",
        "undecided",
        "stable",
    ]


def test_every_verdict_has_the_core() -> None:
    rod = fr.Rod.nitinol()
    load = fr.AxialLoad(0.825 * rod.critical_force, 0.7 * rod.critical_force, 150.0)
    verdicts = (fr.stability(fr.Mathieu(0.5, -0.25)), rod.stability(load), rod.stability(load, friction=0.1, kick=0.05))
    for verdict in verdicts:
        assert isinstance(verdict, Verdict)
        assert verdict.status == "unstable"
        assert verdict.stable is False
        assert verdict.growth_rate == pytest.approx(max(e.real for e in verdict.exponents), rel=1e-9)
        assert len(verdict.multipliers) == len(verdict.exponents)
        sizes = [round(abs(multiplier), 12) for multiplier in verdict.multipliers]
        assert sizes == sorted(sizes, reverse=True)
        assert sizes[0] == pytest.approx(math.exp(verdict.growth_rate * verdict.period), rel=1e-9)
        assert 0.0 <= verdict.error < 1e-6
        assert verdict.cost.amount > 0
    assert [bool(verdict.assumptions) for verdict in verdicts] == [False, True, True]


@pytest.mark.slow
def test_the_slowest_decay() -> None:
    rod = fr.Rod.nitinol()
    load = fr.AxialLoad(0.1 * rod.critical_force, 0.05 * rod.critical_force, 20.0)
    plain = {"stiffness": [[1.0, 0.0], [0.0, 4.0]], "cosines": [[[0.1, 0.2], [0.2, 0.16]]], "period": 2.0}
    undamped = [fr.stability(fr.Mathieu(0.1, -0.3)), rod.stability(load), fr.stability(fr.HillSystem(**plain))]
    assert [(v.status, v.decay_rate) for v in undamped] == [("stable", 0.0)] * 3
    damped = [
        fr.stability(fr.Mathieu(0.1, -0.5, 0.2)),
        rod.replace(damping_rate=0.5).stability(load),
        rod.replace(damping_rate=0.5, ends="clamped").stability(load),
    ]
    assert [v.decay_rate for v in damped] == pytest.approx([0.2, 0.5, 0.5], rel=1e-12)
    uneven = fr.stability(fr.HillSystem(**plain, damping=[[0.1, 0.0], [0.0, 0.2]]))
    solution = fr.solve(uneven.system, [[1.0, 0.3], [0.2, -0.1]], 1200.0)
    late, later = (np.abs(solution(np.linspace(t, t + 40.0, 2001))).max() for t in (200.0, 1160.0))
    assert np.log(late / later) / 960.0 == pytest.approx(uneven.decay_rate, rel=1e-2)
    assert uneven.decay_rate == -max(exponent.real for exponent in uneven.exponents)
    for unstable in (fr.stability(fr.Mathieu(0.5, -0.25)), fr.stability(fr.Mathieu(0.5, -0.25, 0.01))):
        assert (unstable.status, unstable.decay_rate) == ("unstable", 0.0)
