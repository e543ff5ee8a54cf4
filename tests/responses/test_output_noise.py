"""Covariances under additive noise: closed forms, the Lyapunov equation beside transfer functions, densities, paths."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from scipy.linalg import solve_continuous_lyapunov

import floquetrod as fr

PAIR = fr.HillSystem(
    [[2.0, 0.1], [0.1, 5.0]],
    [[[0.3, 0.1], [0.1, 0.2]]],
    mass=[[2.0, 0.3], [0.3, 1.0]],
    damping=[[0.1, 0.02], [0.03, 0.2]],
    period=3.0,
)
FIRST = fr.PeriodicSystem([[-1.0, 0.5], [-3.0, -0.2]], [[[0.0, 0.1], [0.5, 0.2]]], period=2.0)
CASES: list[tuple[Any, Any]] = [
    (fr.Mathieu(0.3, -0.6, 0.05), 1.0),
    (fr.HillSystem([[1.0]], sines=[[[0.03]]], damping=[[0.02]], period=math.pi), [1.0]),
    (PAIR, [1.0, 0.5]),
    (FIRST, [[1.0, 0.0], [0.3, 0.4]]),
]


@pytest.mark.parametrize("method", ["lyapunov", "transfer"])
def test_constant_coefficients_have_a_closed_form(method: str) -> None:
    found = fr.output_noise(fr.Mathieu(0.0, -4.0, 0.1), 0.5, method=method)
    assert found.variance == pytest.approx(0.25 / (4.0 * 0.1 * 4.0), rel=2e-11)
    a, b = np.array([[-1.0, 0.5], [-3.0, -0.2]]), np.array([[1.0, 0.2], [0.3, 0.4]])
    constant = fr.output_noise(fr.PeriodicSystem(a, period=1.0), b, method=method)
    assert constant.covariance(0.3) == pytest.approx(solve_continuous_lyapunov(a, -b @ b.T), rel=1e-9)


@pytest.mark.parametrize(("equation", "intensity"), CASES)
def test_the_lyapunov_equation_agrees_with_transfer_functions(equation: Any, intensity: Any) -> None:
    one, other = (fr.output_noise(equation, intensity, method=method) for method in ("lyapunov", "transfer"))
    times = np.linspace(-1.0, 5.0, 23)
    difference = np.abs(np.asarray(one.covariance(times)) - other.covariance(times)).max()
    assert difference <= (one.error + other.error) * np.max(one.variance) * 2.0
    assert max(one.error, other.error) < 1e-4
    assert one.variance == pytest.approx(other.variance, rel=1e-9)


@pytest.mark.slow
def test_the_density_integrates_to_the_variance() -> None:
    found = fr.output_noise(fr.Mathieu(0.3, -0.6, 0.2), 1.0)
    nodes, weights = np.polynomial.legendre.leggauss(16)
    ends = np.array([*np.linspace(0.0, 4.0, 17), 6.0, 10.0, 18.0, 34.0, 60.0])
    middle, half = 0.5 * (ends[1:] + ends[:-1]), 0.5 * np.diff(ends)
    density = found.density(middle[:, None] + half[:, None] * nodes)
    whole = half @ density @ weights
    assert whole + 1.0 / (3.0 * math.pi * 60.0**3) == pytest.approx(found.variance, rel=1e-7)


def test_noise_of_a_density_of_its_own() -> None:
    # x' = -x + eta, eta of variance 1 and correlation time t: variance t / (1 + t).
    t = 0.5
    found = fr.output_noise(
        fr.PeriodicSystem([[-1.0]]), [1.0], density=lambda w: 2.0 / math.pi * t / (1.0 + (w * t) ** 2)
    )
    assert found.method == "transfer"
    assert found.variance[0] == pytest.approx(t / (1.0 + t), rel=1e-9)
    white = fr.output_noise(PAIR, [1.0, 0.5], density=lambda w: 1.0 / math.pi)
    assert white.variance == pytest.approx(fr.output_noise(PAIR, [1.0, 0.5]).variance, rel=1e-9)


def test_jumping_coefficients_have_a_lyapunov_equation() -> None:
    # x' = -a x + xi on the first half, -b x + xi on the second.
    a, b = 1.0, 2.5
    found = fr.output_noise(fr.PeriodicSystem.from_pieces([(1.0, [[-a]]), (1.0, [[-b]])]), [1.0])
    p, q = 1.0 / (2.0 * a), 1.0 / (2.0 * b)
    start = (q * (1.0 - math.exp(-2 * b)) + p * (1.0 - math.exp(-2 * a)) * math.exp(-2 * b)) / (
        1.0 - math.exp(-2.0 * (a + b))
    )
    middle = p + (start - p) * math.exp(-2.0 * a)
    mean = 0.5 * (
        p + (start - p) * (1 - math.exp(-2 * a)) / (2 * a) + q + (middle - q) * (1 - math.exp(-2 * b)) / (2 * b)
    )
    assert found.variance[0] == pytest.approx(mean, rel=1e-12)


@pytest.mark.slow
def test_ten_thousand_paths_have_the_variance() -> None:
    # Euler and Maruyama, 20,000 paths of Mathieu's equation from rest for 10 decay times.
    equation, rng = fr.Mathieu(0.3, -0.6, 0.2), np.random.default_rng(1)
    steps, h = 16 * 512, 2.0 * math.pi / 512
    x, v = np.zeros(20_000), np.zeros(20_000)
    variances = np.empty(steps)
    p = equation.coefficient(np.arange(512) * h)
    for k in range(steps):
        v = v + h * (p[k % 512] * x - 0.4 * v) + math.sqrt(h) * rng.standard_normal(len(x))
        x = x + h * v
        variances[k] = np.mean(x * x)
    assert variances[-4 * 512 :].mean() == pytest.approx(fr.output_noise(equation, 1.0).variance, rel=0.03)


def test_what_it_says() -> None:
    found = fr.output_noise(PAIR, [1.0, 0.5])
    assert repr(found).startswith("<noise: rms 2.0679, 0.390772; lyapunov>")
    assert str(found.report()).count("variance") == 3
    assert len(json.loads(fr.to_json(found))["result"]["covariance"]) == 64
    assert found.plot().get_ylabel() == "variance"
    assert found.rms == pytest.approx(np.sqrt(found.variance))


DELAYED = fr.DelaySystem([[1.2]], damping=[[0.3]], delayed=[(1.0, [[-0.2]])])


@pytest.mark.parametrize(
    ("equation", "arguments", "kind", "text"),
    [
        (PAIR, {"intensity": 1.0}, ValueError, "intensity must be 2 numbers"),
        (PAIR, {"intensity": [[1.0, 2.0]]}, ValueError, "intensity must be 2 numbers"),
        (PAIR, {"intensity": "white"}, TypeError, "intensity"),
        (PAIR, {"intensity": [1.0, 1.0], "density": 0.3}, TypeError, "density"),
        (PAIR, {"intensity": [1.0, 1.0], "density": lambda w: -1.0}, ValueError, "density"),
        (PAIR, {"intensity": [1.0, 1.0], "density": math.cosh, "method": "lyapunov"}, TypeError, "density is of noise"),
        (PAIR, {"intensity": [1.0, 1.0], "method": "monodromy"}, ValueError, "method"),
        (DELAYED, {"intensity": [1.0]}, TypeError, "without delays"),
        (fr.Mathieu(0.3, -0.6), {"intensity": 1.0}, ValueError, "free motion that decays"),
        (fr.Mathieu(0.5, -0.25), {"intensity": 1.0}, ValueError, "unstable"),
        (fr.Meissner(0.3, -0.6, 0.15), {"intensity": 1.0, "method": "transfer"}, TypeError, "several pieces"),
    ],
)
def test_bad_input_is_refused_in_a_line(
    equation: Any, arguments: dict[str, Any], kind: type[Exception], text: str
) -> None:
    with pytest.raises(kind, match=text) as caught:
        fr.output_noise(equation, **arguments)
    assert "\n" not in str(caught.value)
