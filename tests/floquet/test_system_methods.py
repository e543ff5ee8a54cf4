"""Every method for systems against the truth, the scalar methods, an independent integrator, and every other."""

from __future__ import annotations

import functools
import math
import sys
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import floquetrod as fr
from floquetrod.floquet.dispatch import run
from floquetrod.floquet.methods.system_reference import reference
from floquetrod.floquet.methods.system_segmented import segmented
from floquetrod.floquet.methods.system_spectral import spectral
from floquetrod.floquet.multipliers import precise_maps
from floquetrod.floquet.registry import applicable, methods_for, service
from tests.conftest import depth
from tests.fuzz import neutral
from tests.inside import Counts, Doubles, angles_between, count, system_problem
from tests.seams import Tuned
from tests.strategies import numbers, systems
from tests.system_cases import CASES, coupled, wide

EVERY = {m.name: functools.partial(run, m.name) for m in methods_for("systems")}
GYRATING = fr.HillSystem(np.eye(2), cosines=[np.eye(2)], sines=[np.eye(2)], gyroscopic=[[0.0, 1.0], [-1.0, 0.0]])
METHODS = {m.name: EVERY[m.name] for m in applicable(GYRATING)}  # they take any series
System = fr.HillSystem | fr.PeriodicSystem


def off(one: complex, other: complex, period: float) -> float:
    """Distance of exponents, times the period, whole turns aside."""
    gap = (one - other) * period
    return math.hypot(gap.real, (gap.imag + math.pi) % (2.0 * math.pi) - math.pi)


def check_exponents(one: Any, exponents: Any, errors: Any, slack: float) -> None:
    """Assert that each exponent has another within the errors of both."""
    period = one.period
    for exponent, error in zip(one.exponents, one.exponent_errors, strict=True):
        gaps = [off(exponent, e, period) - r * period for e, r in zip(exponents, errors, strict=True)]
        assert min(gaps) <= error * period + slack, (one, exponent, exponents)


def check_agreement(one: Any, truth: Any, slack: float = 1e-13) -> None:
    assert {one.status, truth.status} != {"stable", "unstable"}, (one, truth)
    if one.exponents and truth.exponents:
        check_exponents(one, truth.exponents, truth.exponent_errors, slack)
    signs = (
        {a * b for a, b in zip(sorted(one.krein_signs), sorted(truth.krein_signs), strict=True)}
        if one.krein_signs
        else {0}
    )
    if 0 not in one.krein_signs and 0 not in truth.krein_signs:
        assert signs == {1}, (one, truth)


# --- truth -----------------------------------------------------------------------------------------------------------

LONG = {("ground resonance", "reference")}
"""What takes a second and more."""


@pytest.mark.parametrize(
    ("case", "method"),
    [
        pytest.param(case, method.name, marks=[pytest.mark.slow] * ((case, method.name) in LONG))
        for case in CASES
        for method in applicable(CASES[case][0])
    ],
)
def test_truth(case: str, method: str) -> None:
    system, growth, status = CASES[case]
    result = EVERY[method](system)
    assert result.status == status, result
    accuracy = service(system, method).accuracy
    assert max(e.real for e in result.exponents) == pytest.approx(growth, abs=max(1e-10, accuracy))
    assert result.error < max(1e-6 if method in ("half_period", "monodromy") else 1e-9, accuracy)
    assert bool(result.resonances) == (status == "unstable")
    if growth == 0.0:
        assert result.strongly_stable
        assert 0 not in result.krein_signs


def test_modes_of_one_krein_sign_have_no_difference_resonance() -> None:
    """Near w = 1.9 the difference 2.9 - 1 fits as well as twice 1, and yet it cannot grow."""
    forcing, kinds = [[0.3, 0.2], [0.2, 0.1]], set()
    for w in np.linspace(1.9, 2.1, 41):
        system = fr.HillSystem(np.diag([1.0, 2.9**2]), cosines=[forcing], period=2.0 * np.pi / w)
        kinds |= {resonance.kind for resonance in fr.stability(system).resonances}
    assert kinds == {"direct"}


def test_decades_that_a_map_loses_are_in_its_error() -> None:
    result = METHODS["monodromy"](wide())
    for mu, error, true in zip(
        result.multipliers[1:3], result.multiplier_errors[1:3], (1.0546448, 0.9481865), strict=True
    ):
        assert abs(abs(mu) - true) < error
    assert fr.stability(wide()).method != "monodromy"


@pytest.mark.parametrize("method", ["segmented", "spectral", "reference"])
def test_decades_are_kept(method: str) -> None:
    result = METHODS[method](wide())
    sizes = [abs(mu) for mu in result.multipliers]
    assert sizes[1:3] == pytest.approx([1.0546448116136429, 0.9481865259166882], rel=1e-10)
    assert math.prod(sizes) == pytest.approx(1.0, rel=1e-8)
    assert sizes[0] > 1e16
    assert result.error < 1e-9


# --- one equation ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", METHODS)
@settings(max_examples=depth(15, 3))
@given(
    mean=numbers(-2.0, 1.0),
    waves=st.lists(st.tuples(numbers(-2.0, 2.0), numbers(-2.0, 2.0)), min_size=1, max_size=2),
    damping=st.just(0.0) | st.floats(1e-3, 0.3),
)
def test_one_equation_is_the_scalar_one(
    method: str, mean: float, waves: list[tuple[float, float]], damping: float
) -> None:
    period = 3.0
    cosines, sines = zip(*waves, strict=True)
    scalar = fr.stability(fr.Hill(mean, cosines, sines, damping=damping, period=period), method="reference")
    system = fr.HillSystem(
        [[-mean]],
        [[[-a]] for a in cosines],
        [[[-b]] for b in sines],
        damping=[[2.0 * damping]] if damping else None,
        period=period,
    )
    result = METHODS[method](system)
    assert {result.status, scalar.status} != {"stable", "unstable"}, (result, scalar)
    if method == "reference" and abs(mean) > 1e-50:  # of which 120 digits see enough
        assert result.status == scalar.status
    # Near a boundary exponents feel the square root of the scalar's error.
    check_exponents(result, scalar.exponents, [2.0 * math.sqrt(scalar.error)] * 2, 1e-12)
    if scalar.status == "unstable" and method == "reference":
        assert result.growth_rate == pytest.approx(scalar.growth_rate, rel=1e-9, abs=1e-15)


# --- against each other and another integrator -----------------------------------------------------------------------


@settings(max_examples=depth(25, 3))
@given(systems())
def test_methods_agree(system: System) -> None:
    truth = reference(system)
    assert truth.error < 1e-14 or truth.status == "undecided"
    for method in applicable(system):
        if method.name != "reference":
            check_agreement(EVERY[method.name](system), truth)


@settings(max_examples=depth(8, 3))
@given(systems())
def test_reference_is_what_an_integrator_finds(system: System) -> None:
    first = system.as_periodic_system() if isinstance(system, fr.HillSystem) else system
    n, period = first.order, float(first.period)

    def slope(t: float, x: np.ndarray) -> np.ndarray:
        return np.asarray((first.coefficient(t) @ x.reshape(n, n)).ravel())

    found = solve_ivp(slope, (0.0, period), np.eye(n).ravel(), method="DOP853", rtol=1e-12, atol=1e-13)
    expected = np.poly(found.y[:, -1].reshape(n, n))
    got = np.poly(np.array(reference(system).multipliers))
    assert got == pytest.approx(expected, rel=1e-8, abs=1e-8 * np.abs(expected).max())


# --- what is known of every system -----------------------------------------------------------------------------------


def turned(system: System, phase: float) -> System:
    """Return the system later by a phase."""
    series = [z * np.exp(1j * k * phase) for k, z in enumerate(system.harmonics, start=1)]
    cosines, sines = [z.real for z in series], [-z.imag for z in series]
    if isinstance(system, fr.PeriodicSystem):
        return fr.PeriodicSystem(system.mean, cosines, sines, period=system.period)
    return fr.HillSystem(
        system.stiffness,
        cosines,
        sines,
        mass=system.mass,
        damping=system.damping,
        gyroscopic=system.gyroscopic,
        period=system.period,
    )


def check_spectra(one: Any, other: Any, sign: float = 1.0) -> None:
    """Assert that two systems have the same multipliers, or inverse ones, as far as rounded coefficients allow."""
    size = max(abs(e) for e in one.exponents) + 1.0
    slack = 1e-13 * size * one.period
    close = [off(a, b, one.period) for a in one.exponents for b in one.exponents if a is not b]
    if min(close, default=1.0) < 1e-2:  # near a double multiplier changes grow
        slack = math.sqrt(slack)
    errors = other.exponent_errors
    check_exponents(one, [sign * e for e in other.exponents], errors, 10.0 * slack)


@pytest.mark.parametrize("method", [pytest.param(m, marks=[pytest.mark.slow] * (m == "reference")) for m in METHODS])
@settings(max_examples=depth(6, 3))
@given(system=systems(), phase=st.floats(0.1, 6.0))
def test_time_may_begin_anywhere(method: str, system: System, phase: float) -> None:
    check_spectra(METHODS[method](system), METHODS[method](turned(system, phase)))


@pytest.mark.parametrize("method", [pytest.param(m, marks=[pytest.mark.slow] * (m == "reference")) for m in METHODS])
@settings(max_examples=depth(6, 3))
@given(system=systems(), seed=st.integers(0, 2**32))
def test_coordinates_do_not_matter(method: str, system: System, seed: int) -> None:
    first = system.as_periodic_system() if isinstance(system, fr.HillSystem) else system
    change = np.eye(first.order) + np.random.default_rng(seed).uniform(-0.3, 0.3, (first.order, first.order))

    def seen(matrix: np.ndarray) -> np.ndarray:
        return np.asarray(np.linalg.solve(change, matrix @ change))

    other = fr.PeriodicSystem(
        seen(first.mean), [seen(m) for m in first.cosines], [seen(m) for m in first.sines], period=first.period
    )
    check_spectra(METHODS[method](other), METHODS[method](system))


@pytest.mark.parametrize("method", METHODS)
@settings(max_examples=depth(6, 3))
@given(system=systems(("first",)))
def test_backward_time_inverts_multipliers(method: str, system: fr.PeriodicSystem) -> None:
    backward = fr.PeriodicSystem(
        -system.mean, [-m for m in system.cosines], [m.copy() for m in system.sines], period=system.period
    )
    check_spectra(METHODS[method](backward), METHODS[method](system), -1.0)


@pytest.mark.parametrize("method", METHODS)
@settings(max_examples=depth(10, 3))
@given(system=systems())
def test_exponents_sum_to_the_trace(method: str, system: System) -> None:
    first = system.as_periodic_system() if isinstance(system, fr.HillSystem) else system
    result = METHODS[method](system)
    total = sum(result.exponents).real
    assert total == pytest.approx(float(np.trace(first.mean)), abs=sum(result.exponent_errors) + 1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@settings(max_examples=depth(10, 3))
@given(system=systems(("hamiltonian", "reversible", "gyroscopic")))
def test_multipliers_come_in_pairs(method: str, system: fr.HillSystem) -> None:
    result = METHODS[method](system)
    check_exponents(result, [-e for e in result.exponents], result.exponent_errors, 1e-12)


# --- double multipliers and points beside boundaries -----------------------------------------------------------------


def identical(n: int = 3) -> fr.HillSystem:
    """Return equal Mathieu equations, seen in other coordinates."""
    rotation = np.linalg.qr(np.arange(n * n).reshape(n, n) + np.eye(n))[0]
    mass = rotation @ np.diag([1.0, 2.0, 4.0][:n]) @ rotation.T
    mass = 0.5 * (mass + mass.T)
    return fr.HillSystem(1.25 * mass, [0.25 * mass], mass=mass)


@pytest.mark.parametrize("method", METHODS)
def test_identical_oscillators_are_strongly_stable(method: str) -> None:
    result = METHODS[method](identical())
    assert (result.status, result.strongly_stable) == ("stable", True), result
    assert sorted(result.krein_signs) == [-1, -1, -1, 1, 1, 1]


@pytest.mark.parametrize("method", METHODS)
def test_a_collision_of_unlike_signs_is_never_stable(method: str) -> None:
    # Two equal oscillators, one of negative energy, and nothing couples them: each multiplier is double, of both signs.
    mean = np.array([[0, 0, 1, 0], [0, 0, 0, -1], [-1.3, 0, 0, 0], [0, 1.3, 0, 0]], dtype=float)
    wave = np.array([[0, 0, 0, 0], [0, 0, 0, 0], [0.4, 0, 0, 0], [0, -0.4, 0, 0]], dtype=float)
    system = fr.PeriodicSystem(mean, [wave])
    assert system.structure == "hamiltonian"
    result = METHODS[method](system)
    assert (result.status, result.strongly_stable) == ("undecided", None), result
    assert max(abs(e.real) for e in result.exponents) < 1e-6


def test_reference_keeps_what_it_has_when_more_digits_are_too_much_work(
    monkeypatch: pytest.MonkeyPatch, tuned: Tuned
) -> None:
    system = fr.HillSystem([[2.0]], [[[0.5]]], damping=[[2e-9]])
    wanted = reference(system, digits=30)
    module = sys.modules["floquetrod.floquet.methods.system_reference"]
    tuned(relative_error_that_is_settled=0.0)  # never content
    work = iter([0.0, math.inf])
    monkeypatch.setattr(module, "_work", lambda problem, planned: next(work))
    result = reference(system, digits=30)
    assert (result.status, result.exponents) == (wanted.status, wanted.exponents)


def test_reference_decides_where_doubles_cannot() -> None:
    # A sum resonance of strength e grows at e / (4 sqrt 2) when its detuning is smaller: the period is a double, and
    # w is off 3 by 1e-16.  Such growth is beyond what eigenvalues of a map in doubles can show.
    strong, weak = (reference(coupled(3.0, strength=strength)) for strength in (1e-12, 1e-18))
    assert strong.status == "unstable"
    assert strong.growth_rate == pytest.approx(1e-12 / math.sqrt(32.0), rel=1e-6)
    assert weak.status == "stable"
    assert weak.strongly_stable
    assert fr.stability(coupled(3.0, strength=1e-12), method="monodromy").status == "undecided"


@pytest.mark.slow
def test_reference_decides_beside_every_kind_of_boundary() -> None:
    # The least beta of a double at which the equation is on one side, and its neighbour on the other; mu is -1 or +1.
    for curve in (-0.25, -1.0):
        low, high = curve - 0.05, curve + 0.05
        statuses = {x: reference(fr.HillSystem([[-x]], [[[-0.02]]])).status for x in (low, curve)}
        assert statuses == {low: "stable", curve: "unstable"}
        high = curve
        while np.nextafter(low, 1.0) < high:
            middle = 0.5 * (low + high)
            inside = reference(fr.HillSystem([[-middle]], [[[-0.02]]]))
            assert inside.status != "undecided"
            low, high = (low, middle) if inside.status == "unstable" else (middle, high)


def test_errors_of_exponents_hold_their_rounding_to_doubles() -> None:
    # A square wave of two equations, whose map is a product of two exponentials, and a constant one, which is one.
    stiff, soft = [[3.25, 0.125], [0.125, 1.5]], [[2.0, -0.5], [-0.5, 0.75]]
    with mpmath.workdps(40):
        for levels in ((stiff, soft), (stiff, stiff)):
            flows = [
                mpmath.expm(mpmath.matrix(np.block([[np.zeros((2, 2)), np.eye(2)], [-np.array(k), np.zeros((2, 2))]])))
                for k in levels
            ]
            logs = [mpmath.log(mu) for mu in mpmath.eig(flows[1] * flows[0], left=False, right=False)]
            found = reference(fr.HillSystem.from_pieces([(1.0, level) for level in levels]))
            for exponent, error in zip(found.exponents, found.exponent_errors, strict=True):
                assert min(abs(log / 2 - exponent) for log in logs) <= error <= 1e-14


@pytest.mark.slow
def test_reference_compares_growth_with_uniform_damping() -> None:
    c = reference(coupled(3.0)).growth_rate
    for _ in range(8):  # to the damping that growth balances
        c += max(e.real for e in reference(coupled(3.0, (c, c))).exponents)
    net = []
    for change in range(-3, 4):
        here = c * (1.0 + change * 2.0**-52)
        result = reference(coupled(3.0, (here, here)))
        assert result.status != "undecided"
        assert result.error < 1e-25
        net.append(max(e.real for e in result.exponents))
        assert (result.status == "unstable") == (net[-1] > 0.0)
    assert net == sorted(net, reverse=True)
    assert net[0] > 0.0 > net[-1]
    assert max(map(abs, net)) < 1e-16


def test_counts_tell_krein_signs() -> None:
    system = coupled(1.0)
    found, turns = counted(system)
    assert found.variation == system.order
    assert [found.krein_sign(turns[[i]]) for i in range(len(turns))] == list(reference(system).krein_signs)
    assert found.krein_sign(turns) == 0
    unstable = coupled(3.0)
    assert counted(unstable)[0].variation < unstable.order


def counted(system: fr.HillSystem) -> tuple[Counts, NDArray[np.float64]]:
    """Return counts at angles between multipliers, and the angles of these in turns."""
    turns = np.array([e.imag for e in reference(system).exponents]) * system.period / (2.0 * math.pi)
    problem: Any = system_problem(system)
    balls = problem.oscillators(Doubles(), problem.period, freed=True)
    return count(Doubles(), balls, angles_between(np.exp(2j * math.pi * turns))), turns


@pytest.mark.slow
@settings(max_examples=depth(10, 3))
@given(systems(("hamiltonian", "gyroscopic")))
def test_counts_agree_with_multipliers(system: fr.HillSystem) -> None:
    result = reference(system)
    found = counted(system)[0].variation == system.order
    if result.status == "unstable":
        assert not found
    elif found:
        assert result.strongly_stable


# --- errors and refusals ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("digits", [10, 30, pytest.param(100, marks=pytest.mark.slow)])
def test_the_bound_of_the_map_covers_its_error(digits: int, rng: np.random.Generator) -> None:
    """Where x' = f(t) x, f of mean zero, has the multiplier 1 exactly, what is not 1 is error."""
    context = mpmath.MPContext()
    for _ in range(depth(20, 6)):
        count = int(rng.integers(1, 4))
        waves = rng.normal(size=2 * count) * 10.0 ** rng.uniform(-2.0, 0.7)
        context.dps = 2 * digits + 40
        exact = np.array([context.mpf(v) for v in waves.tolist()], dtype=object).reshape(-1, 1, 1)
        mean, start = np.array([[context.mpf(0)]], dtype=object), context.mpf(rng.uniform())
        series = [precise_maps.PieceSeries(mean, exact, start, 2 * context.pi)]
        planned = precise_maps.plan(series, digits)
        assert planned is not None
        found = precise_maps.period_map(series, context, planned)
        assert 0 < abs(found.matrix[0, 0] - 1) <= found.error < 10.0 ** (6 - digits) * np.exp(np.abs(waves).sum())


NEUTRAL = {
    "a cosine": fr.PeriodicSystem([[0.0]], [[[1.0]]]),
    "decay beyond many digits": fr.PeriodicSystem([[-1e-300]], [[[1.0]]]),
    "triangular": fr.PeriodicSystem([[0.0, 0.3], [0.0, 0.0]], [[[1.0, 0.5], [0.0, 0.7]]], period=2.0),
    "triangular stiffness": fr.HillSystem(1.3 * np.eye(2), [[[0.1, 0.15], [0.0, 0.1]]], period=2.5),
    "a free body": fr.HillSystem([[1, -1], [-1, 1]], [[[0.1, -0.1], [-0.1, 0.1]]], damping=0.1 * np.eye(2)),
}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] * (name not in ("a cosine", "decay beyond many digits")))
        for name in NEUTRAL
    ],
)
def test_nothing_grows_exactly_and_nothing_is_said_to(name: str) -> None:
    system = NEUTRAL[name]
    for result in (fr.stability(system), *fr.compare(system).results):
        assert not (result.status == "unstable" and result.growth_rate > 0.0), result
        if system.structure == "general":
            assert result.status == "undecided", result
        if result.exponents and system.structure == "general":
            assert all(abs(e.real) <= error for e, error in zip(result.exponents, result.exponent_errors, strict=True))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::floquetrod.UndecidedWarning")  # what is undecided contradicts nothing
def test_stated_errors_cover_exponents_that_are_known(rng: np.random.Generator) -> None:
    wrong = [line for _ in range(depth(4, 1)) for line in neutral.disagreements(rng)]
    assert not wrong, "\n".join(wrong)


@pytest.mark.slow
@pytest.mark.parametrize("digits", [10, 40, 70])
def test_the_stated_error_of_the_map_covers_fewer_digits(digits: int) -> None:
    few, many = reference(coupled(3.0), digits=digits), reference(coupled(3.0), digits=digits + 30)
    assert few.error < 10.0 ** (3 - digits)
    check_exponents(few, many.exponents, many.exponent_errors, 1e-15)


@pytest.mark.parametrize(
    ("method", "options", "name"),
    [
        (reference, {"digits": 5}, "digits"),
        (reference, {"digits": 2.5}, "digits"),
        (spectral, {"rtol": 1.0}, "rtol"),
        (segmented, {"rtol": 0.0}, "rtol"),
    ],
)
def test_options_are_checked(method: Any, options: dict[str, Any], name: str) -> None:
    with pytest.raises((TypeError, ValueError), match=name):
        method(coupled(3.0), **options)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_too_much_work_is_declined(method: str) -> None:
    system = fr.HillSystem(np.diag([1e12, 2e12]), [np.full((2, 2), -1e12)], period=1.0)
    result = METHODS[method](system)
    assert result.status == "undecided"
    assert result.note
    assert not result.exponents


@pytest.mark.slow
@pytest.mark.parametrize("harmonic", [1, 2, 3])
def test_a_single_sine_is_reversible_about_a_quarter_of_its_period(harmonic: int) -> None:
    sines = [np.zeros((2, 2))] * (harmonic - 1) + [np.array([[0.3, 0.5], [0.1, 0.2]])]
    system = fr.HillSystem([[1.0, 0.2], [-0.1, 4.0]], sines=sines, period=2.0)
    assert system.structure == "reversible"
    first = system.as_periodic_system()

    def slope(t: float, x: np.ndarray) -> np.ndarray:
        return np.asarray((first.coefficient(t) @ x.reshape(4, 4)).ravel())

    found = solve_ivp(slope, (0.0, 2.0), np.eye(4).ravel(), method="DOP853", rtol=1e-12, atol=1e-13)
    expected = np.poly(found.y[:, -1].reshape(4, 4))
    assert [method.name for method in applicable(system)] == list(EVERY)
    for method in EVERY.values():
        result = method(system)
        assert result.status == "stable", result
        assert np.poly(np.array(result.multipliers)) == pytest.approx(expected, abs=1e-9)


@pytest.mark.slow
def test_gyroscopic_systems_of_a_tiny_period_are_not_called_unstable() -> None:
    # The numbers y are 1e-60 beside a coupling of 1e-33 between the halves of the map: reference once said "unstable".
    stiffness, wave = [[1.0, 0.3], [0.3, 2.0]], [[0.1, 0.2], [0.2, 0.16]]
    for period in (1e-10, 1e-20, 1e-30, 1e-40):
        system = fr.HillSystem(stiffness, [wave], gyroscopic=[[0.0, 0.2], [-0.2, 0.0]], period=period)
        assert {fr.stability(system, name).status for name in ("monodromy", "reference")} <= {"stable", "undecided"}
        assert fr.stability(system).status == "stable"


def test_segmented_finds_both_of_two_nearly_equal_pairs() -> None:
    """Exponents 4e-11 apart of two uncoupled equations, and those of coupled ones that are nearly these."""
    k, f, period = 3.616844176880306, -3.620777130126953, 1.6455678642150124
    for turn in (0.0, 0.3):
        rotation = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
        stiffness = rotation @ np.diag([k, k + 9.0096e-10]) @ rotation.T
        system = fr.HillSystem(0.5 * (stiffness + stiffness.T), [f * np.eye(2)], period=period)
        found, true = fr.stability(system, method="segmented"), fr.stability(system, method="reference")
        for exponent, error, other in zip(found.exponents, found.exponent_errors, true.exponents, strict=True):
            assert abs(exponent.real - other.real) <= error + 1e-13
