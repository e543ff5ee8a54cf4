"""Steady motions under a force: truth by DOP853, closed forms, drawn problems, resonances, and two methods."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.responses.hill_arrays import hill_arrays
from floquetrod.responses.many import respond_to_many, scalar_responses
from tests.conftest import depth, some
from tests.forced_problems import by_dop853, drawn
from tests.fuzz.junk import tree

METHODS = ("hill", "monodromy")
CONSTANT = [
    (0.3, -0.6, 0.01, 1.400370873649, 2.51484499, 1.066569712549, 0.93910137),
    (0.5, -0.95, 0.02, 0.413830482024, 4.77804403, 4.128382172823, 0.88191138),
    (0.5, -1.1, 0.02, 5.711146709060, 26.27198692, 22.275645871686, 0.88191138),
    (0.2, -0.25, 0.06, 3.622047094084, 4.60472467, 0.957019500398, 1.27493739),
]
"""alpha, beta, c; mean, largest of 4,000 instants, first harmonic, largest multiplier: DOP853, rtol 1e-12."""
IDLERS = [
    (0.02, 0.01, 1.0, (0.041664974056, 33.332899335, 66.666124168, 0.083330354975)),
    (0.03, 0.01, 0.999, (0.148853632093, 79.4502947599, 106.554422273, 0.199934078172)),
    (0.5, 0.2, 0.8, (0.0206914800817, 0.77186672744, 1.99872974103, 0.0721214040479)),
]
"""h, c, w; amplitudes k = -2, -1, 0, 1: DOP853, rtol 1e-12."""


def amplifier(h: float, c: float) -> fr.HillSystem:
    """Return x'' + 2 c x' + (1 + h sin 2t) x."""
    return fr.HillSystem([[1.0]], sines=[[[h]]], damping=[[2.0 * c]], period=math.pi)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("alpha", "beta", "c", "mean", "largest", "first", "multiplier"), CONSTANT)
def test_a_constant_force(
    method: str, alpha: float, beta: float, c: float, mean: float, largest: float, first: float, multiplier: float
) -> None:
    equation = fr.Mathieu(alpha, beta, c)
    steady = fr.response(equation, 1.0, method=method, unstable=multiplier > 1.0)
    assert steady.mean == pytest.approx(mean, rel=4e-12)
    assert 2.0 * abs(steady.harmonics[1]) == pytest.approx(first, rel=4e-12)
    # The largest of instants is below the extreme.
    assert largest < steady.largest < largest * (1.0 + 2e-7)
    assert steady.error < 1e-10
    assert steady.status == ("unstable" if multiplier > 1.0 else "stable")
    assert np.max(np.abs(steady.solution(np.linspace(0.0, 2.0 * math.pi, 100_001)))) == pytest.approx(
        steady.largest, rel=1e-8
    )


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("h", "c", "w", "amplitudes"), IDLERS)
def test_a_signal_and_its_idlers(method: str, h: float, c: float, w: float, amplitudes: tuple[float, ...]) -> None:
    waves = fr.response(amplifier(h, c), 1.0, frequency=w, method=method).harmonics
    for k, value in zip((-2, -1, 0, 1), amplitudes, strict=True):
        assert abs(waves[k][0]) == pytest.approx(value, rel=1.5e-10)  # of the truth: next to a resonance it has 10


@pytest.mark.parametrize("method", METHODS)
def test_constant_coefficients_have_a_closed_form(method: str) -> None:
    mass, stiffness = np.array([[2.0, 0.3], [0.3, 1.0]]), np.array([[3.0, -1.0], [-0.5, 4.0]])
    damping, force = np.array([[0.3, 0.1], [0.0, 0.4]]), np.array([1.0 - 1.0j, 0.5])
    system = fr.HillSystem(stiffness, mass=mass, damping=damping, period=1.3)
    for w in (0.0, 0.9, -2.0, 40.0):
        exact = np.linalg.solve(-w * w * mass + 1j * w * damping + stiffness, force)
        steady = fr.response(system, force, frequency=w, method=method)
        assert steady.harmonics[0] == pytest.approx(exact, rel=1e-12)
        assert steady.largest == pytest.approx(np.abs(exact), rel=1e-12)
        assert steady.rms == pytest.approx(np.abs(exact), rel=1e-12)
    rest = fr.response(system, [1.0, 2.0], method=method)
    assert rest.mean == pytest.approx(np.linalg.solve(stiffness, [1.0, 2.0]), rel=1e-13)


@pytest.mark.parametrize("method", METHODS)
def test_a_delayed_force_balance_has_a_closed_form(method: str) -> None:
    system = fr.DelaySystem.first_order([[-1.5]], delayed=[(1.0, [[-1.0]])], period=1.7)
    for w in (0.0, 0.7, 3.0):
        steady = fr.response(system, 2.0, frequency=w, method=method)
        assert steady.harmonics[0][0] == pytest.approx(2.0 / (1j * w + 1.5 + np.exp(-1j * w)), rel=1e-12)
    assert fr.response(system, 2.0, method=method).mean[0] == pytest.approx(0.8, rel=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_a_delay_of_a_period_is_none_for_a_force_of_the_period(method: str) -> None:
    # q(t - T) = q(t) of the periodic motion: the delayed term is a stiffness.
    delayed = fr.DelaySystem([[1.2]], [[[0.5]]], damping=[[0.3]], delayed=[(2.0 * math.pi, [[-0.2]])])
    plain = fr.HillSystem([[1.0]], [[[0.5]]], damping=[[0.3]])
    one, other = (fr.response(each, 1.0, sines=[[0.4]], method=method) for each in (delayed, plain))
    times = np.linspace(-3.0, 9.0, 50)
    assert one.solution(times) == pytest.approx(other.solution(times), abs=2.0 * one.error + 1e-13)
    assert one.error < 1e-7


def test_a_square_force_on_a_square_wave() -> None:
    # x' = -a x + 1 on the first half, -b x on the second: exponentials.
    a, b = 1.0, 2.5
    system = fr.PeriodicSystem.from_pieces([(1.0, [[-a]]), (1.0, [[-b]])])
    steady = fr.response(system, lambda t: [1.0 if t % 2.0 < 1.0 else 0.0], jumps=[0.0, 1.0])
    assert steady.method == "monodromy"
    start = (1.0 - math.exp(-a)) / a * math.exp(-b) / (1.0 - math.exp(-a - b))
    middle = 1.0 / a + (start - 1.0 / a) * math.exp(-a)
    assert steady.solution([0.0, 1.0, 2.0, 5.0])[:, 0] == pytest.approx([start, middle, start, middle], rel=1e-13)
    assert steady.largest[0] == pytest.approx(middle, rel=1e-13)
    mean = 0.5 * (1.0 / a + (start - 1.0 / a) * (1.0 - math.exp(-a)) / a + middle * (1.0 - math.exp(-b)) / b)
    assert steady.mean[0] == pytest.approx(mean, rel=1e-13)


def test_a_force_with_jumps_on_a_smooth_equation() -> None:
    equation = fr.Mathieu(0.3, -0.6, 0.05)
    half = fr.response(equation, lambda t: 1.0 if t % (2.0 * math.pi) < 2.0 else 0.0, jumps=[0.0, 2.0])
    rest = fr.response(equation, lambda t: 0.0 if t % (2.0 * math.pi) < 2.0 else 1.0, jumps=[0.0, 2.0])
    whole = fr.response(equation, 1.0, method="hill")
    times = np.linspace(0.0, 20.0, 60)
    assert half.solution(times) + rest.solution(times) == pytest.approx(whole.solution(times), abs=1e-11)


def _errors(seed: int, method: str) -> tuple[float, float]:
    """Return the difference from DOP853 as a fraction of the largest coordinate, and the stated error."""
    forced = drawn(seed)
    steady = fr.response(forced.equation, forced.force, method=method, unstable=True, **forced.options)
    times, exact = by_dop853(forced)
    values = np.asarray(steady.solution(times)).reshape(exact.shape)
    return float(np.abs(values - exact).max() / np.max(steady.largest)), steady.error


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(15, 4)))
def test_drawn_problems_against_dop853(seed: int) -> None:
    for method in METHODS:
        difference, error = _errors(seed, method)
        assert error < 1e-5
        assert difference < error + 2e-11, method


@pytest.mark.slow
@pytest.mark.parametrize("block", range(4))
def test_two_hundred_drawn_problems_against_dop853(block: int) -> None:
    for seed in some(range(1000 + 50 * block, 1050 + 50 * block), 20, 10):
        for method in METHODS:
            difference, error = _errors(seed, method)
            assert difference < error + 1e-10, (seed, method)


@pytest.mark.slow
@given(seed=st.integers(0, 100_000))
@settings(max_examples=depth(200, 15), deadline=None)
def test_methods_agree(seed: int) -> None:
    forced = drawn(seed)
    compared = fr.compare(forced.equation, force=forced.force, unstable=True, **forced.options)
    assert [result.method for result in compared.results] == list(METHODS)
    assert compared.agree
    one, other = compared.results
    slack = 4.0 * (one.error + other.error) + 1e-13
    assert np.max(np.abs(np.asarray(one.largest) - other.largest)) <= slack * np.max(one.largest)
    assert np.max(np.abs(np.asarray(one.rms) - other.rms)) <= slack * np.max(one.rms)
    times = np.linspace(-2.0, 30.0, 40)
    rate = np.abs(np.asarray(one.solution(times, 1))).max() + np.max(one.largest)
    assert np.abs(np.asarray(one.solution(times, 1)) - other.solution(times, 1)).max() <= 1e3 * slack * rate


@pytest.mark.parametrize("method", METHODS)
def test_errors_grow_honestly_next_to_a_resonance(method: str) -> None:
    # x'' + 2 c x' + x at w = 1: 1 / (2 i c), exactly.
    before = 0.0
    for c in (1e-2, 1e-4, 1e-6, 1e-8):
        system = fr.HillSystem([[1.0]], damping=[[2.0 * c]], period=3.0)
        steady = fr.response(system, 1.0, frequency=1.0, method=method)
        difference = abs(steady.harmonics[0][0] * 2j * c - 1.0)
        assert difference <= steady.error
        assert before < steady.error < 1e-3
        before = steady.error
        assert steady.distance == pytest.approx(3.0 * c, rel=0.02)


@pytest.mark.parametrize("method", METHODS)
def test_on_a_resonance_there_is_no_answer(method: str) -> None:
    free = fr.HillSystem([[1.0]], period=3.0)
    with pytest.raises(ValueError, match=r"^frequency must not be on a resonance.* lies .*e-1[3-9]|lies 0 "):
        fr.response(free, 1.0, frequency=1.0, method=method)
    with pytest.raises(ValueError, match=r"^force must not be on a resonance"):
        fr.response(fr.Mathieu(0.0, 0.0, 0.1), 1.0, method=method)  # a multiplier of 1
    assert "does not decay" in fr.response(free, 1.0, frequency=0.5, method=method).note


@pytest.mark.parametrize("method", METHODS)
def test_an_unstable_problem_answers_when_asked(method: str) -> None:
    equation = fr.Mathieu(0.2, -0.25, 0.06)
    with pytest.raises(ValueError, match=r"^equation must be stable.*0\.0386583.*unstable=True"):
        fr.response(equation, 1.0, method=method)
    steady = fr.response(equation, 1.0, method=method, unstable=True)
    assert steady.status == "unstable"
    assert "grows" in repr(steady)


def test_a_constant_force_feels_even_tongues_only() -> None:
    # Across the edge of the principal tongue, where a multiplier is -1, nothing happens; at the second one, of period
    # T, the motion grows beyond all bounds.
    edge = -0.25
    near = [fr.response(fr.Mathieu(0.1, edge + d, 0.0), 1.0, unstable=True).largest for d in (-0.052, -0.048)]
    assert near[0] == pytest.approx(near[1], rel=0.05)
    a2 = -fr.mathieu.characteristic_values(2, 2.0 * 0.3, "a") / 4.0
    sizes = [fr.response(fr.Mathieu(0.3, a2 - d), 1.0, unstable=True).largest for d in (1e-2, 1e-4, 1e-6)]
    b2 = -fr.mathieu.characteristic_values(2, 2.0 * 0.3, "b") / 4.0
    odd = [fr.response(fr.Mathieu(0.3, b2 + d), 1.0, unstable=True).largest for d in (1e-2, 1e-4, 1e-6)]
    grows = [each for each in (sizes, odd) if each[2] / each[0] > 1e3]
    assert len(grows) == 1  # the edge whose solution is even about the extremes of the sine, as a constant is


def test_linearity_and_time() -> None:
    system = drawn(4).equation
    n = system.order
    one, other = np.arange(1.0, n + 1.0), np.cos(np.arange(n))
    single = [fr.response(system, f, frequency=1.3) for f in (one, other, one - 2j * other)]
    t = np.linspace(0.0, 11.0, 7)
    assert single[2].solution(t) == pytest.approx(single[0].solution(t) - 2j * single[1].solution(t), rel=1e-12)
    # A frequency of the period itself is a harmonic of the force.
    w = 2.0 * math.pi / system.period
    wave = fr.response(system, one, frequency=w)
    assert wave.solution(t).real == pytest.approx(
        fr.response(system, np.zeros(n), cosines=[one]).solution(t), rel=1e-11, abs=1e-13
    )
    assert wave.mean.real == pytest.approx(fr.response(system, np.zeros(n), cosines=[one]).mean, abs=1e-13)


def test_a_function_is_its_series() -> None:
    equation = fr.Hill(-0.7, cosines=(0.2,), period=3.0, damping=0.05)
    w = 2.0 * math.pi / 3.0
    given_ = fr.response(equation, lambda t: 0.5 + 0.3 * math.cos(2.0 * w * t) - 0.2 * math.sin(w * t))
    series = fr.response(equation, 0.5, cosines=(0.0, 0.3), sines=(-0.2,))
    assert given_.largest == pytest.approx(series.largest, rel=1e-11)
    assert given_.error < 1e-10


@given(seed=st.integers(0, 100_000))
@settings(max_examples=depth(60, 6), deadline=None)
def test_many_equations_are_single_ones(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mean, alpha, c = -rng.uniform(0.1, 30.0, 7), rng.uniform(-1.0, 1.0, 7), rng.uniform(0.01, 0.3, 7)
    many = scalar_responses(mean, -1j * alpha[:, None], c, 1.0, 0.5)
    for i in range(7):
        single = fr.response(fr.Mathieu(alpha[i], mean[i], c[i]), 0.5, unstable=True, method="hill")
        assert many.largest[i, 0] == pytest.approx(single.largest, rel=1e-11 + 2.0 * single.error)
        assert many.mean[i, 0] == pytest.approx(single.mean, rel=1e-11, abs=1e-12 * single.largest)


@pytest.mark.kernels
def test_many_systems_are_single_ones() -> None:
    listed = [drawn(seed).equation for seed in range(1, 60, 3) if drawn(seed).order == 2][:3]
    batch = fr.equations.stack(listed)
    many = respond_to_many(hill_arrays(batch), np.tile([[1.0 + 0j, -2.0]], (3, 1))[:, None], np.full(3, 0.7))
    for i, system in enumerate(listed):
        single = fr.response(system, [1.0, -2.0], frequency=0.7)
        assert many.largest[i] == pytest.approx(single.largest, rel=1e-11)
        assert many.error[i] == pytest.approx(single.error, rel=5.0)


@pytest.mark.kernels
def test_one_answer_interpreted_is_one_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    from floquetrod.responses import harmonic_balance, motions

    system, force = (
        fr.HillSystem([[1.0, 0.1], [0.2, 3.0]], [[[0.1, 0.0], [0.1, 0.2]]], damping=np.eye(2) / 5),
        [1.0, 1j],
    )
    compiled = fr.response(system, force, frequency=0.8)
    for module in (harmonic_balance, motions):
        monkeypatch.setattr(module, "runner", lambda function, *_, **__: function)
    plain = fr.response(system, force, frequency=0.8)
    assert plain.harmonics[0] == pytest.approx(compiled.harmonics[0], rel=1e-13)
    assert plain.largest == pytest.approx(compiled.largest, rel=1e-13)


def test_what_a_response_says() -> None:
    steady = fr.response(fr.Mathieu(0.3, -0.6, 0.01), 1.0)
    assert str(steady.report()).splitlines()[0] == "largest 2.51485"
    assert repr(steady).startswith("<response: largest 2.51485, error")
    assert json.loads(fr.to_json(steady))["result"]["mean"] == pytest.approx(1.400370873649)
    with pytest.raises(TypeError, match="truth value"):
        bool(steady)
    signal = fr.response(amplifier(0.03, 0.01), 1.0, frequency=0.999)
    assert "k = 0: 106.554; k = -1: 79.4503" in str(signal.report())
    assert signal.mean.tolist() == [0j]
    assert signal.references[0].startswith("The floquetrod developers")
    assert steady.plot().get_ylabel() == "steady motion $A$"
    assert signal.plot().get_ylabel() == "modulus $|q|$ of the steady motion"


def test_a_comparison_says_which_methods_apply() -> None:
    smooth = fr.compare(fr.Mathieu(0.3, -0.6, 0.01), force=1.0)
    assert "all methods agree" in repr(smooth)
    jumping = fr.compare(fr.Meissner(0.3, -0.6, 0.15), force=1.0)
    assert [result.method for result in jumping.results] == ["monodromy"]
    assert jumping.left_out[0][0] == "hill"
    assert "no other method applies" in repr(jumping)


MATHIEU = fr.Mathieu(0.3, -0.6, 0.05)
PAIR = fr.HillSystem([[1.0, 0.0], [0.0, 2.0]], damping=[[0.1, 0.0], [0.0, 0.1]])
BAD: list[tuple[Any, dict[str, Any], type[Exception], str]] = [
    (MATHIEU, {"force": "1 N"}, TypeError, "force"),
    (MATHIEU, {"force": None}, TypeError, "force"),
    (MATHIEU, {"force": math.nan}, ValueError, "force"),
    (MATHIEU, {"force": [1.0, 2.0]}, ValueError, "force must be one number"),
    (PAIR, {"force": 1.0}, ValueError, "force must be 2 numbers"),
    (PAIR, {"force": [1.0, 2.0, 3.0]}, ValueError, "force must be 2 numbers"),
    (MATHIEU, {"force": 1.0 + 1.0j}, TypeError, "force must be real without a frequency"),
    (MATHIEU, {"force": 1.0, "frequency": math.inf}, ValueError, "frequency"),
    (MATHIEU, {"force": 1.0, "frequency": "1 Hz"}, TypeError, "frequency"),
    (MATHIEU, {"force": 1.0, "frequency": 1e15}, ValueError, "frequency must be at most"),
    (MATHIEU, {"force": 1.0, "frequency": 1.0, "cosines": [1.0]}, TypeError, "frequency goes with one amplitude"),
    (MATHIEU, {"force": math.sin, "frequency": 1.0}, TypeError, "frequency goes with one amplitude"),
    (MATHIEU, {"force": math.sin, "sines": [1.0]}, TypeError, "sines goes with the mean"),
    (MATHIEU, {"force": 1.0, "jumps": [0.0]}, TypeError, "jumps goes with a function"),
    (MATHIEU, {"force": 1.0, "cosines": 0.5}, TypeError, "cosines"),
    (PAIR, {"force": [1.0, 2.0], "cosines": [0.5]}, ValueError, r"cosines\[0\] must be 2 numbers"),
    (MATHIEU, {"force": lambda t: t}, ValueError, "force is not periodic"),
    (MATHIEU, {"force": lambda t: 1.0 if t % (2 * math.pi) < 1 else 0.0}, ValueError, "force"),
    (MATHIEU, {"force": math.sin, "jumps": [7.0]}, ValueError, r"jumps\[0\] must lie within a period"),
    (PAIR, {"force": lambda t: [t, 1.0, 2.0]}, ValueError, "must be 2 numbers"),
    (MATHIEU, {"force": 1.0, "method": "spectral"}, ValueError, "method"),
    (fr.Meissner(0.3, -0.6, 0.15), {"force": 1.0, "method": "hill"}, TypeError, "one Fourier series"),
    (MATHIEU, {"force": math.copysign}, TypeError, "copysign"),
    (MATHIEU, {"force": 1.0, "unstable": 1}, TypeError, "unstable"),
    (0.5, {"force": 1.0}, TypeError, "equation must be"),
    (fr.PeriodicSystem([[-1.0 + 1.0j]]), {"force": 1.0}, TypeError, "equation must be real"),
    (fr.HillSystem(np.ones((2, 1, 1))), {"force": 1.0}, ValueError, "single system"),
]


@pytest.mark.parametrize(("equation", "arguments", "kind", "text"), BAD)
def test_bad_input_is_refused_in_a_line(
    equation: Any, arguments: dict[str, Any], kind: type[Exception], text: str
) -> None:
    with pytest.raises(kind, match=text) as caught:
        fr.response(equation, **arguments)
    assert "\n" not in str(caught.value)


def test_what_is_of_a_force_needs_one() -> None:
    with pytest.raises(TypeError, match=r"^frequency is of a force"):
        fr.compare(MATHIEU, frequency=1.0)  # type: ignore[call-overload]


def test_a_force_of_nested_lists_is_refused_at_once() -> None:
    """Thirty levels of one list twice have 2^30 numbers, which nobody looks through."""
    with pytest.raises(ValueError, match="force must have at most"):
        fr.response(fr.Mathieu(0.1, -0.3, 0.05), tree(30))
    with pytest.raises(TypeError, match="force must hold real numbers"):
        fr.response(fr.Mathieu(0.1, -0.3, 0.05), [[1.0, 2.0j]])
