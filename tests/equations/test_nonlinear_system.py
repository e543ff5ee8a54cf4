"""Nonlinear systems as values: how a function is called, its derivatives, and what is refused."""

from __future__ import annotations

import math
import pickle
from typing import Any

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

import floquetrod as fr
from tests.conftest import depth
from tests.orbits.test_periodic_orbits import DUFFING, VAN_DER_POL, duffing, van_der_pol

TIMES = np.array([0.1, 0.4, 2.0])
STATES = np.array([[0.3, -0.2], [1.1, 0.7], [-2.0, 0.4]])


def derivatives(mu: float = 1.0) -> Any:
    return np.array([[[0.0, 1.0], [-2.0 * mu * x * v - 1.0, mu * (1.0 - x * x)]] for x, v in STATES])


def singly(t: Any, x: Any, mu: float) -> Any:
    a, b = float(x[0]), float(x[1])
    return [b, mu * (1.0 - a**2) * b - a]


def filled(t: Any, x: Any, mu: float) -> Any:
    found = np.empty_like(x)
    found[0], found[1] = x[1], mu * (1.0 - x[0] ** 2) * x[1] - x[0]
    return found


def exact(t: Any, x: Any, mu: float) -> Any:
    return [[0.0, 1.0], [-2.0 * mu * x[0] * x[1] - 1.0, mu * (1.0 - x[0] ** 2)]]


@pytest.mark.parametrize(
    ("function", "jacobian", "error"),
    [(van_der_pol, None, 1e-14), (filled, None, 1e-14), (singly, None, 1e-10), (singly, exact, 1e-14)],
)
def test_functions_of_arrays_and_of_numbers(function: Any, jacobian: Any, error: float) -> None:
    system = fr.NonlinearSystem(function, jacobian, parameters={"mu": 1.0})
    known = np.array([van_der_pol(0.0, x, 1.0) for x in STATES])
    assert np.abs(system.rates(TIMES, STATES) - known).max() < 1e-15
    assert np.abs(system.jacobians(TIMES, STATES) - derivatives()).max() < error
    assert system.evaluated.derivatives_error < (1e-10 if error > 1e-12 else 1e-14)


def test_a_magnitude_has_no_derivative_by_complex_steps() -> None:
    system = fr.NonlinearSystem(lambda t, x: (x[1], -x[0] - x[1] * abs(x[1])))
    found = system.jacobians(TIMES, STATES)
    assert not system.evaluated.complex_steps
    assert np.abs(found[:, 1, 1] + 2.0 * np.abs(STATES[:, 1])).max() < 1e-9


def test_a_magnitude_that_shows_on_the_orbit_alone() -> None:
    """Where the trials at the start see nothing of it, complex steps are given up when the orbit is known."""

    def clearance(t: Any, x: Any) -> Any:
        gap = x[0] - 0.7
        return x[1], -x[0] - 0.4 * x[1] - 2.0 * (gap + abs(gap)) ** 2 + np.cos(1.2 * t)

    system = fr.NonlinearSystem(clearance, period=2.0 * math.pi / 1.2)
    orbit = fr.periodic_orbit(system, [-0.8, 0.0], tolerance=1e-5)
    assert not system.evaluated.complex_steps
    assert orbit.status == "stable"
    expected = system.evaluated.by_differences(orbit.times[:-1], orbit.states[:-1], {})
    assert np.abs(system.jacobians(orbit.times[:-1], orbit.states[:-1]) - expected).max() == 0.0


def test_a_wrong_jacobian_is_named_by_its_entry() -> None:
    def wrong(t: Any, x: Any, mu: float) -> Any:
        return [[0.0, 1.0], [-2.0 * mu * x[0] * x[1] + 1.0, mu * (1.0 - x[0] ** 2)]]

    system = fr.NonlinearSystem(van_der_pol, wrong, parameters={"mu": 1.0})
    with pytest.raises(ValueError, match=r"jacobian\[1, 0\] = .* disagrees with differences of function"):
        fr.periodic_orbit(system, [2.0, 0.0])


def test_a_jacobian_that_changes_within_a_step_of_differences_is_right() -> None:
    width = 3e-4

    def rates(t: Any, x: Any) -> Any:
        return x[1], -x[0] - 0.1 * np.tanh(x[1] / width)

    def right(t: Any, x: Any) -> Any:
        return [[0.0 * t, 1.0 + 0.0 * t], [-1.0 + 0.0 * t, 0.1 / width * (np.tanh(x[1] / width) ** 2 - 1.0)]]

    def wrong(t: Any, x: Any) -> Any:
        return [[0.0, 1.0], [-1.0, 0.11 / width * (np.tanh(x[1] / width) ** 2 - 1.0)]]

    times, states = np.zeros(2), np.array([[1.0, 1.0], [0.5, 1e-4]])
    fr.NonlinearSystem(rates, right).evaluated.require_derivatives(times, states, {})
    with pytest.raises(ValueError, match=r"jacobian\[1, 1\] = .* disagrees"):
        fr.NonlinearSystem(rates, wrong).evaluated.require_derivatives(times, states, {})


def test_systems_from_sympy() -> None:
    x, v, mu, t = sympy.symbols("x v mu t", real=True)
    system = fr.NonlinearSystem.from_sympy([v, mu * (1 - x**2) * v - x], [x, v], parameters={mu: 1.0})
    assert np.abs(system.jacobians(TIMES, STATES) - derivatives()).max() < 1e-15
    assert system.with_parameters(mu=2.0).jacobians(TIMES, STATES) == pytest.approx(derivatives(2.0))
    omega = sympy.Symbol("omega")
    forced = fr.NonlinearSystem.from_sympy(
        [v, sympy.cos(omega * t) - v / 5 - x - x**3],
        [x, v],
        time=t,
        period=2 * sympy.pi / omega,
        parameters={omega: 1.2},
    )
    assert forced.period == DUFFING.period
    assert forced.rates(TIMES, STATES) == pytest.approx(DUFFING.rates(TIMES, STATES), abs=1e-15)
    again = pickle.loads(pickle.dumps(forced))
    assert again == forced
    assert again.rates(TIMES, STATES).tolist() == forced.rates(TIMES, STATES).tolist()
    with pytest.raises(ValueError, match="equations have 'mu', which has no value"):
        fr.NonlinearSystem.from_sympy([v, -mu * x], [x, v])


def test_a_linear_system_with_a_force() -> None:
    """Mathieu's equation with a cubic spring, two of it with mass, damping and gyroscopic force."""
    linear = fr.HillSystem(
        [[1.0, 0.1], [0.1, 4.0]],
        cosines=[[[0.3, 0.0], [0.0, 0.2]]],
        mass=[[2.0, 0.1], [0.1, 1.0]],
        damping=[[0.1, 0.0], [0.0, 0.2]],
        gyroscopic=[[0.0, 0.3], [-0.3, 0.0]],
        period=2.0,
    )
    system = fr.NonlinearSystem.from_hill(linear, lambda t, q, v, k: -k * q**3, parameters={"k": 0.5})
    assert system.period == 2.0
    state = np.array([0.3, -0.2, 0.1, 0.5])
    q, v = state[:2], state[2:]
    pushed = -0.5 * q**3 - linear.coefficient(0.4) @ q - (linear.damping + linear.gyroscopic) @ v  # type: ignore[operator]
    expected = np.concatenate([v, np.linalg.solve(np.asarray(linear.mass), pushed)])
    assert system.rates([0.4], [state])[0] == pytest.approx(expected, abs=1e-14)
    still = fr.periodic_orbit(system, np.zeros(4))
    assert still.error == 0.0 or still.error < 1e-12
    mus = sorted(fr.stability(linear).multipliers, key=abs)
    for mu in still.stability.multipliers:
        assert min(abs(mu - other) for other in mus) < 1e-11


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"parameters": {"nu": 1.0}}, "parameters has 'nu', which function does not take; it takes mu"),
        ({}, "parameters must have a value of 'mu'"),
        ({"parameters": {"mu": math.nan}}, "must be finite"),
        ({"parameters": {"mu": 1.0}, "period": "2*pi/nu"}, "'nu', which is no parameter"),
        ({"parameters": {"mu": 1.0}, "period": "().__class__"}, "period must be a number or a formula"),
        ({"parameters": {"mu": 0.0}, "period": "2*pi/mu"}, "division by zero"),
        ({"parameters": {"mu": 1.0}, "period": "sqrt(-mu)"}, "period must be a number or a formula"),
        ({"parameters": {"mu": 1.0}, "period": "9**9**9"}, "its value is beyond 1e308"),
        ({"parameters": {"mu": 1.0}, "period": "1<<10**9"}, "period must be a number or a formula"),
        ({"parameters": {"mu": 1.0}, "period": "'a'*10**9"}, "not a formula"),
        ({"parameters": {"mu": 1.0}, "period": "(" * 5000}, "at most 1000 are read"),
        ({"parameters": {"mu": -1.0}, "period": "2*pi/mu"}, "period must be greater than zero"),
    ],
)
def test_what_is_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises((ValueError, TypeError), match=message.replace("(", r"\(").replace(")", r"\)")):
        fr.NonlinearSystem(van_der_pol, **arguments)


CODE = "__import__('floquetrod').__dict__.update(planted=True)"


class Written:
    """An object whose texts are code."""

    def __str__(self) -> str:
        return CODE

    __repr__ = __str__

    def _sympy_(self) -> str:
        return CODE


texts = st.sampled_from([CODE, CODE.encode(), bytearray(CODE.encode()), np.str_(CODE), np.array(CODE), Written()])
nested = st.recursive(
    texts,
    lambda inner: st.one_of(
        st.lists(inner, min_size=1, max_size=2),
        st.tuples(inner),
        inner.map(lambda each: np.array([each], dtype=object)),
        inner.map(lambda each: {"x": each}),
    ),
    max_leaves=4,
)


@given(nested, st.sampled_from(["equations", "equation", "states", "time", "period", "value", "name"]))
@settings(max_examples=depth(500, 30), deadline=None)
def test_no_text_is_run_as_code(code: Any, argument: str) -> None:
    x, v = sympy.symbols("x v")
    given: dict[str, Any] = {"equations": [v, -x], "states": [x, v]}
    changed = {
        "equations": {"equations": code},
        "equation": {"equations": [v, code]},
        "states": {"states": [x, code]},
        "time": {"time": code},
        "period": {"period": code},
        "value": {"parameters": {"mu": code}},
        "name": {"parameters": {str(code): 1.0}},
    }[argument]
    with pytest.raises((TypeError, ValueError)):
        fr.NonlinearSystem.from_sympy(**given | changed)
    assert not hasattr(fr, "planted")


def test_functions_that_sympy_cannot_compute_are_refused() -> None:
    x, v = sympy.symbols("x v")
    for expression in (sympy.Function(CODE)(x), x + sympy.Function("f")(v) ** 2):
        with pytest.raises(TypeError, match=r"equations\[1\] must be of functions that sympy can compute"):
            fr.NonlinearSystem.from_sympy([v, expression], [x, v])
    assert not hasattr(fr, "planted")
    numbers = (2, 0.5, np.float64(3.0), np.int64(4))
    system = fr.NonlinearSystem.from_sympy([*numbers], sympy.symbols("a b c d"))
    assert system.rates([0.0], np.zeros((1, 4))).tolist() == [[2.0, 0.5, 3.0, 4.0]]


formulas = st.recursive(
    st.sampled_from(["2", "0.5", "pi", "mu", "3", "1e3"]),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*/"), inner).map(lambda parts: f"({''.join(parts)})"),
        st.tuples(st.sampled_from(["sqrt", "exp", "sin"]), inner).map(lambda parts: f"{parts[0]}({parts[1]})"),
        inner.map(lambda each: f"-{each}"),
    ),
    max_leaves=8,
)


@given(formulas)
@settings(max_examples=depth(500, 30), deadline=None)
def test_a_formula_of_the_period_means_what_python_makes_of_it(formula: str) -> None:
    try:
        expected = eval(formula, {"__builtins__": {}}, vars(math) | {"mu": 1.5})
    except (ArithmeticError, ValueError):
        expected = math.nan
    if math.isfinite(expected) and expected > 0.0:
        system = fr.NonlinearSystem(van_der_pol, period=formula, parameters={"mu": 1.5})
        assert system.period == pytest.approx(expected, rel=1e-14)
    else:
        with pytest.raises(ValueError, match="period"):
            fr.NonlinearSystem(van_der_pol, period=formula, parameters={"mu": 1.5})


def test_parameters() -> None:
    with pytest.raises(ValueError, match="parameters has 'omeg', which is no parameter; did you mean omega"):
        DUFFING.with_parameters(omeg=1.0)
    called = fr.NonlinearSystem(duffing, period=lambda omega: 2.0 * math.pi / omega, parameters={"omega": 1.2})
    assert called.period == DUFFING.period
    assert called.with_parameters(omega=2.4).period == DUFFING.with_parameters(omega=2.4).period
    assert VAN_DER_POL.period is None
    assert fr.NonlinearSystem(van_der_pol, parameters={"mu": 1.0}) == VAN_DER_POL
    assert "mu" in repr(VAN_DER_POL)


@pytest.mark.slow
def test_functions_compiled_by_numba() -> None:
    import numba

    compiled: Any = numba.njit(van_der_pol)
    system = fr.NonlinearSystem(compiled, parameters={"mu": 1.0})
    orbit = fr.periodic_orbit(system, [2.0, 0.0])
    assert abs(orbit.period - 6.663286859323131) < 1e-12
    given = fr.NonlinearSystem(compiled, numba.njit(exact_compiled), parameters={"mu": 1.0})
    assert np.abs(given.jacobians(TIMES, STATES) - derivatives()).max() < 1e-14


def exact_compiled(t: Any, x: Any, mu: float) -> Any:
    return ((0.0, 1.0), (-2.0 * mu * x[0] * x[1] - 1.0, mu * (1.0 - x[0] ** 2)))


def test_parameters_may_come_in_one_mapping() -> None:
    def by_name(t: Any, x: Any, mu: float, nu: float) -> Any:
        return x[1], mu * (1 - x[0] ** 2) * x[1] - nu * x[0]

    def at_once(t: Any, x: Any, p: Any) -> Any:
        return x[1], p["mu"] * (1 - x[0] ** 2) * x[1] - p["nu"] * x[0]

    values = {"mu": 1.0, "nu": 1.1}
    one, other = (fr.NonlinearSystem(f, parameters=values) for f in (by_name, at_once))
    x = np.array([[1.0, 2.0], [0.3, 0.4]])
    np.testing.assert_array_equal(one.rates([0.0, 0.0], x), other.rates([0.0, 0.0], x))
    assert fr.periodic_orbit(one, [2.0, 0.0]).period == fr.periodic_orbit(other, [2.0, 0.0]).period
    with pytest.raises(ValueError, match="parameters has 'mi', which function does not take; it takes mu, nu"):
        fr.NonlinearSystem(by_name, parameters={"mi": 1.0, "nu": 1.0})
