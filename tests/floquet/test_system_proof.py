"""Proofs for systems: the arithmetic encloses, counts are those of dense matrices, verdicts those of the literature."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from itertools import pairwise
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import floquetrod as fr
from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.floquet.proof.inertia import inertia
from floquetrod.floquet.proof.krein import krein_sums
from floquetrod.floquet.proof.system_counts import _last, _matrix, _truncation
from floquetrod.floquet.proof.system_discs import enclose_eigenvalues
from floquetrod.floquet.proof.system_problem import canonical_form
from floquetrod.floquet.proof.systems import _attempt, certify_system
from floquetrod.results import Proof
from tests.conftest import depth
from tests.inside import Doubles, Integers, TooMuchWork, Unresolved, count, monodromy, system_problem

ARITHMETICS = [Doubles(), Integers(12), Integers(40)]
by_arithmetic = pytest.mark.parametrize("arithmetic", ARITHMETICS, ids=["doubles", "12 digits", "40 digits"])
seeds = st.integers(0, 2**32 - 1)


# --- systems with a known answer ---


def coupled_mathieu(w: float, damping: tuple[float, float] = (0.0, 0.0)) -> HillSystem:
    """Return two coupled Mathieu equations (after Hsu 1963)."""
    amplitude = 0.2 * np.array([[0.5, 1.0], [1.0, 0.8]])
    return HillSystem(np.diag([1.0, 4.0]), [amplitude], damping=2.0 * np.diag(damping), period=2.0 * math.pi / w)


def follower_load() -> HillSystem:
    """Return the double pendulum under a pulsating follower load."""
    r, g = np.array([[2.0, -1.0], [-1.0, 1.0]]), np.array([[1.0, -0.5], [0.0, 0.5]])
    mass = [[3.0, 1.0], [1.0, 1.0]]
    return HillSystem(r - 0.6 * g, [-0.8 * g], mass=mass, damping=0.02 * r, period=2.0 * math.pi / 3.0)


def clamped_beam(w: float, modes: int = 4) -> HillSystem:
    """Return Galerkin modes of a clamped beam under a pulsating axial load (Bolotin)."""
    b = np.array([float(mpmath.findroot(lambda x: mpmath.cos(x) - 1 / mpmath.cosh(x), (i + 1.5) * math.pi))
                  for i in range(modes)])  # fmt: skip
    s = (np.cosh(b) - np.cos(b)) / (np.sinh(b) - np.sin(b))
    matrix = np.diag(s * b * (s * b - 2.0))
    for i in range(modes):
        for j in range(i):
            if (i + j) % 2 == 0:
                entry = -8.0 * (b[i] * b[j]) ** 2 * (s[j] * b[j] - s[i] * b[i]) / (b[j] ** 4 - b[i] ** 4)
                matrix[i, j] = matrix[j, i] = entry
    return HillSystem(np.diag(b**4) - 10.0 * matrix, [-8.0 * matrix], period=2.0 * math.pi / w)


def rotor_blade(m: float) -> PeriodicSystem:
    """Return the flapping of a rotor blade in forward flight (Peters and Hohenemser 1971)."""
    first, second = 1.5 * (4.0 / 3.0) * m, 1.5 * m * m
    cosine = [[0.0, 0.0], [-first, 0.0]]
    return PeriodicSystem(
        [[0.0, 1.0], [-1.0, -1.5]], [cosine], [[[0.0, 0.0], [0.0, -first]], [[0.0, 0.0], [-second, 0.0]]]
    )


def largest(proof: Proof) -> tuple[float, float]:
    """Return bounds of the modulus of the multiplier that decided."""
    square = next(item for item in proof.enclosures if item.quantity.endswith("abs(multiplier)^2 - 1"))
    return math.sqrt(1.0 + float(square.low)), math.sqrt(1.0 + float(square.high))


@pytest.mark.parametrize(
    ("system", "growth"),
    [
        (coupled_mathieu(3.0), 0.03532777753665963),
        (coupled_mathieu(2.95), 0.02512182920908255),
        (coupled_mathieu(2.0), 0.02496431619264695),
        (coupled_mathieu(3.1, (0.002, 0.2)), 0.0027590001070383),
        (follower_load(), 0.1094453127093562),
        (clamped_beam(40.0), 1.123052773707724),
        (clamped_beam(136.25), 0.4303691990675693),
        (rotor_blade(1.5), 0.0906136082791130),
        (rotor_blade(1.0), -0.75),
    ],
    ids=str,
)
def test_growth_of_the_literature_is_proved(system: HillSystem | PeriodicSystem, growth: float) -> None:
    proof = fr.certify(system)
    assert proof.status == ("unstable" if growth > 0.0 else "stable")
    assert proof.digits == 15
    expected = math.exp(growth * system.period)
    low, high = largest(proof)
    assert low - 1e-9 <= expected <= high + 1e-9
    assert high - low < 1e-9


@pytest.mark.parametrize("system", [coupled_mathieu(1.0), coupled_mathieu(3.1), clamped_beam(80.0)], ids=str)
def test_strong_stability_is_proved_by_discs_and_by_counts(system: HillSystem) -> None:
    assert fr.certify(system).status == "stable"
    problem = system_problem(system)
    counts = count(Doubles(), problem.oscillators(Doubles(), problem.unit, freed=False), turns(system))
    assert counts.variation == system.order


def turns(system: HillSystem) -> list[float]:
    """Return angles between the multipliers, from an integration of its own."""
    values = np.abs(np.angle(np.linalg.eigvals(integrated(system)))) / (2.0 * math.pi)
    values = np.sort(values)[::2]
    middles = [round(float(x) * 2**30) / 2**30 for x in (values[1:] + values[:-1]) / 2.0]
    return [0.0, *middles, 0.5]


def integrated(system: HillSystem | PeriodicSystem) -> Any:
    """Return the map over a period as DOP853 integrates it, in q and q' or in x."""
    if isinstance(system, HillSystem):
        n = system.order
        mass = np.eye(n) if system.mass is None else system.mass
        friction = sum((m for m in (system.damping, system.gyroscopic) if m is not None), np.zeros((n, n)))

        def matrix(t: float) -> Any:
            forces = np.linalg.solve(mass, np.hstack([system.coefficient(t), friction]))
            return np.vstack([np.eye(n, 2 * n, n), -forces])

        size = 2 * n
    else:
        matrix, size = system.coefficient, system.order
    solution = solve_ivp(
        lambda t, y: (matrix(t) @ y.reshape(size, size)).ravel(),
        (0.0, system.period),
        np.eye(size).ravel(),
        method="DOP853",
        rtol=1e-12,
        atol=1e-13,
    )
    return solution.y[:, -1].reshape(size, size)


# --- conclusions ---


@pytest.mark.parametrize("n", [2, 3])
def test_identical_oscillators_are_proved_strongly_stable(n: int) -> None:
    """Their multipliers are multiple and definite: discs cannot tell, Krein signs can, and so can counts."""
    system = HillSystem(1.3 * np.eye(n), [0.2 * np.eye(n)], period=2.0 * math.pi / 1.7)
    proof = fr.certify(system)
    assert proof.status == "stable"
    assert f"Krein signs of multipliers, by angle in turns, add up to: {n} from 0 to 0.5" in proof.statement
    arithmetic, problem = Doubles(), system_problem(system)
    assert count(arithmetic, problem.oscillators(arithmetic, problem.unit, freed=True), [0.0, 0.5]).variation == n


@pytest.mark.slow
def test_counts_decide_near_the_boundaries_of_real_multipliers() -> None:
    """Where two multipliers meet at -1, discs in doubles cannot tell, counts can: here over 1e-12 of the amplitude."""
    low, high = 0.0, 0.5
    statuses = []
    for _ in range(34):
        middle = 0.5 * (low + high)
        system = HillSystem(np.diag([1.0, 2.6]), [[[middle, 0.1], [0.1, 0.3]]], period=math.pi / 1.03)
        status = fr.certify(system, max_digits=15).status
        statuses.append(status)
        low, high = (middle, high) if status == "stable" else (low, middle)
    assert "undecided" not in statuses
    assert {"stable", "unstable"} == set(statuses)


def test_a_meeting_of_opposite_krein_signs_is_refused() -> None:
    """The third equation makes the system periodic; the multipliers of the first two meet, to rounding."""
    period = 2.0 * math.pi / 3.0
    system = HillSystem(np.diag([1.0, 4.0, 3.0]), [np.diag([0.0, 0.0, 0.5])], period=period)
    proof = fr.certify(system, max_digits=15)
    assert proof.status == "undecided"
    assert "Krein" in proof.statement


@pytest.mark.slow
def test_a_free_coordinate_is_refused() -> None:
    system = HillSystem(np.diag([0.0, 3.0]), [np.diag([0.0, 0.5])], period=2.3)
    proof = fr.certify(system, max_digits=30)
    assert proof.status == "undecided"
    assert proof.digits == 30


@pytest.mark.parametrize("shift", [-1e-9, 1e-9])
def test_gyroscopic_stabilisation(shift: float) -> None:
    """The system q'' + g J q' - diag(a, b) q = 0 is stable where g exceeds sqrt(a) + sqrt(b)."""
    g = 3.0 + shift
    system = HillSystem(np.diag([-1.0, -4.0]), gyroscopic=[[0.0, g], [-g, 0.0]], period=1.0)
    assert fr.certify(system).status == ("stable" if shift > 0.0 else "unstable")


@pytest.mark.parametrize("shift", [-1e-9, 1e-9])
def test_uniform_damping_against_growth(shift: float) -> None:
    undamped = fr.certify(coupled_mathieu(3.0))
    rate = math.log(largest(undamped)[0]) / (2.0 * math.pi / 3.0)
    c = rate * (1.0 + shift)
    stiffness = np.diag([1.0, 4.0]) + c * c * np.eye(2)  # freed of its damping, the same
    system = HillSystem(
        stiffness, coupled_mathieu(3.0).cosines, damping=2.0 * c * np.eye(2), period=2.0 * math.pi / 3.0
    )
    assert fr.certify(system).status == ("stable" if shift > 0.0 else "unstable")


def test_a_little_uniform_damping_of_identical_oscillators() -> None:
    """The discs reach the unit circle; the counts of what is freed of its damping prove the decay."""
    system = HillSystem(1.3 * np.eye(2), [0.2 * np.eye(2)], damping=2e-17 * np.eye(2), period=3.5)
    proof = fr.certify(system, max_digits=15)
    assert proof.status == "stable"
    assert "decays" in proof.statement


@pytest.mark.slow
def test_more_digits_decide_on_the_boundary_of_a_combination_resonance() -> None:
    below, above = 3.0702237019907876, 3.0702237019907885
    assert math.nextafter(math.nextafter(below, 4.0), 4.0) == above
    proofs = [fr.certify(coupled_mathieu(w)) for w in (below, above)]
    assert [proof.status for proof in proofs] == ["unstable", "stable"]
    assert {proof.digits for proof in proofs} == {30}
    assert fr.certify(coupled_mathieu(below), max_digits=15).status == "undecided"


@pytest.mark.parametrize(
    "equation",
    [
        fr.Hill(mean=-1.0, cosines=(0.3,), period=6.0),
        fr.Hill(mean=-0.2, cosines=(0.6,), sines=(0.0, 0.2)),
        fr.Hill(mean=0.0, damping=0.1),  # at rest with any displacement: a multiplier 1
        fr.Hill(mean=0.0),
        fr.Hill(mean=-0.25),
    ],
    ids=str,
)
def test_one_equation_is_proved_as_the_scalar_is(equation: fr.Hill) -> None:
    scalar, system = fr.certify(equation), fr.certify(equation.as_system())
    assert (scalar.status, scalar.interval, scalar.statement) == (system.status, system.interval, system.statement)
    assert isinstance(system.equation, HillSystem)


@settings(max_examples=depth(30, 3), deadline=None)
@given(st.floats(-3.0, 1.0), st.floats(-2.0, 2.0), st.floats(0.0, 0.2), st.floats(0.5, 8.0))
def test_one_equation_is_proved_as_the_scalar_is_by_the_means_of_systems(
    mean: float, amplitude: float, damping: float, period: float
) -> None:
    equation = fr.Hill(mean=mean, cosines=(amplitude,), damping=damping, period=period)
    proof = certify_system(equation.as_system(), 15)
    assert proof.status in {fr.certify(equation).status, "undecided"}


def test_a_system_of_first_order_is_proved_as_that_of_second_is() -> None:
    for w in (1.0, 2.0, 3.0, 3.1):
        system = coupled_mathieu(w)
        assert fr.certify(system.as_periodic_system()).status == fr.certify(system).status


def test_coefficients_known_only_so_well() -> None:
    mean, amplitude = [[0.0, 1.0], [-1.0, -0.1]], [[0.0, 0.0], [0.3, 0.0]]
    close, rough = (PeriodicSystem(mean, [amplitude], coefficient_error=error) for error in (1e-9, 0.1))
    assert fr.certify(close).status == "stable"
    proof = fr.certify(rough)
    assert proof.status == "undecided"
    assert "known only to 0.1" in proof.statement


@pytest.mark.slow
def test_undamped_coefficients_that_are_not_exact_prove_no_stability() -> None:
    system = coupled_mathieu(3.1).as_periodic_system()
    rough = PeriodicSystem(system.mean, system.cosines, period=system.period, coefficient_error=1e-12)
    assert fr.certify(rough).status == "undecided"


def test_what_is_refused() -> None:
    with pytest.raises(ValueError, match="batch"):
        fr.certify(HillSystem(np.ones((3, 1, 1))))
    with pytest.raises(TypeError, match="beta must follow a class or another callable"):
        fr.certify(coupled_mathieu(1.0), beta=1.0)


def test_too_much_work_is_said() -> None:
    proof = fr.certify(HillSystem(np.diag([1e12, 3.0]), [np.ones((2, 2))]))
    assert proof.status == "undecided"
    assert "would take too long" in proof.statement


# --- any system ---


def hamiltonian(seed: int, n: int) -> HillSystem:
    """Return a random system without damping; often near a resonance."""
    rng = np.random.default_rng(seed)
    frequencies = rng.uniform(0.3, 3.0, n)
    turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
    stiffness = turn @ np.diag(frequencies**2) @ turn.T
    amplitudes = 10.0 ** rng.uniform(-3.0, 0.3) * rng.normal(size=(2, n, n))
    mass = np.eye(n) + 0.2 * turn @ np.diag(rng.uniform(0.0, 1.0, n)) @ turn.T
    skew = rng.normal(size=(n, n)) * rng.integers(0, 2)
    w = (frequencies[rng.integers(n)] + frequencies[rng.integers(n)]) / rng.integers(1, 4)
    return HillSystem(
        stiffness + stiffness.T,
        [amplitudes[0] + amplitudes[0].T],
        [amplitudes[1] + amplitudes[1].T] if rng.random() < 0.5 else [],
        mass=mass + mass.T,
        gyroscopic=skew - skew.T,
        period=2.0 * math.pi / w,
    )


@settings(max_examples=depth(60, 6), deadline=None)
@given(seeds, st.integers(1, 4))
def test_no_proof_contradicts_an_integration(seed: int, n: int) -> None:
    system = hamiltonian(seed, n)
    values, vectors = np.linalg.eig(integrated(system))
    largest_modulus, doubt = np.abs(values).max(), 1e-8 * np.linalg.cond(vectors)
    status = certify_system(system, 15).status
    if status == "stable":
        assert largest_modulus < 1.0 + 1e-4
    elif largest_modulus > 1.0 + 100.0 * doubt:
        assert status == "unstable"


@pytest.mark.slow
def test_nearly_every_hamiltonian_system_is_decided_with_doubles() -> None:
    many = depth(200, 40)
    statuses = [certify_system(hamiltonian(seed, 1 + seed % 4), 15).status for seed in range(many)]
    assert statuses.count("undecided") <= 0.01 * many
    assert min(statuses.count("stable"), statuses.count("unstable")) > 0.1 * many


@pytest.mark.slow
@settings(max_examples=depth(8, 3), deadline=None)
@given(seeds, st.integers(1, 2))
@example(0, 3)
def test_more_digits_agree(seed: int, n: int) -> None:
    system = hamiltonian(seed, n)
    doubles = certify_system(system, 15)
    try:
        integers = _attempt(Integers(25), system_problem(system))
    except (Unresolved, TooMuchWork):
        return
    assert doubles.status in {integers.status, "undecided"}


# --- arithmetic ---


def exactly(matrix: Any) -> Any:
    """Return an array of doubles as fractions, real and imaginary parts on a last axis."""
    parts = np.stack([np.real(matrix), np.imag(matrix)], axis=-1)
    return np.frompyfunc(lambda value: Fraction(float(value)), 1, 1)(parts)


def midpoints(balls: Any) -> Any:
    """Return midpoints as `exactly` does."""
    if hasattr(balls, "mid"):
        return exactly(balls.mid)
    imaginary = balls.real * 0 if balls.imaginary is None else balls.imaginary
    return np.frompyfunc(lambda value: Fraction(value, 2**balls.bits), 1, 1)(np.stack([balls.real, imaginary], axis=-1))


def times(a: Any, b: Any) -> Any:
    """Return the exact product of complex matrices as `exactly` has them."""
    real = a[..., 0].dot(b[..., 0]) - a[..., 1].dot(b[..., 1])
    return np.stack([real, a[..., 0].dot(b[..., 1]) + a[..., 1].dot(b[..., 0])], axis=-1)


def contains(balls: Any, exact: Any) -> bool:
    """Return whether each exact number lies in its ball."""
    gap = midpoints(balls) - exact
    squares = (gap**2).sum(axis=-1)
    radii = np.frompyfunc(lambda value: Fraction(float(value)) ** 2, 1, 1)(balls.rad)
    return bool(np.all(squares <= radii))


def random_matrices(seed: int, n: int, *, real: bool) -> tuple[Any, Any]:
    """Return matrices whose entries differ in size."""
    rng = np.random.default_rng(seed)
    sizes = 10.0 ** rng.uniform(-8.0, 8.0, (2, n, n))
    parts = rng.normal(size=(2, 2, n, n)) * sizes
    return tuple(parts[0]) if real else tuple(parts[0] + 1j * parts[1])  # type: ignore[return-value]


@by_arithmetic
@settings(max_examples=depth(25, 6), deadline=None)
@given(seeds, st.integers(1, 4), st.booleans())
def test_operations_enclose(arithmetic: Any, seed: int, n: int, real: bool) -> None:
    a, b = random_matrices(seed, n, real=real)
    x, y = arithmetic.exact(a), arithmetic.exact(b)
    exact_a, exact_b = exactly(a), exactly(b)
    assert contains(x, exact_a)
    assert contains(x + y, exact_a + exact_b)
    assert contains(x - y, exact_a - exact_b)
    product, exact_product = x @ y, times(exact_a, exact_b)
    assert contains(product, exact_product)
    assert contains(product @ product, times(exact_product, exact_product))
    assert contains(product.over(7), exact_product / 7)
    assert contains(product.shifted(np.array(2.0**-9)), exact_product / 512)
    assert contains(product.sum(0), exact_product.sum(axis=0))
    diagonal = (x * y)[np.arange(n), np.arange(n)]
    exact_diagonal = [times(exact_a[i : i + 1, i : i + 1], exact_b[i : i + 1, i : i + 1])[0, 0] for i in range(n)]
    assert contains(diagonal, np.array(exact_diagonal))
    squares = np.frompyfunc(lambda value: Fraction(float(value)) ** 2, 1, 1)
    sizes = (exact_product**2).sum(axis=-1)
    assert (squares(product.lower()) <= sizes).all()
    assert (sizes <= squares(product.upper())).all()


@by_arithmetic
def test_constants_enclose(arithmetic: Any) -> None:
    with mpmath.workdps(80):
        assert contains_number(arithmetic.two_pi(), 2 * mpmath.pi)
        fractions = np.array([0.0, 0.25, -0.5, 1.0 / 1024, 383.0 / 1024])
        for balls, function in zip(arithmetic.turns(fractions), (mpmath.cos, mpmath.sin), strict=True):
            for i, fraction in enumerate(fractions):
                assert contains_number(balls[i], function(2 * mpmath.pi * mpmath.mpf(fraction)))
    assert contains(arithmetic.rational(Fraction(1, 3)), np.array([Fraction(1, 3), Fraction(0)], dtype=object))


def contains_number(ball: Any, number: Any) -> bool:
    """Return whether a real number of mpmath lies in a ball."""
    middle = midpoints(ball)[..., 0].item() if np.ndim(ball.rad) == 0 else midpoints(ball)[0, 0]
    gap = abs(mpmath.mpf(middle.numerator) / middle.denominator - number)
    return bool(gap <= mpmath.mpf(float(ball.rad)))


# --- maps and multipliers ---


@by_arithmetic
def test_the_map_of_a_constant_system(arithmetic: Any) -> None:
    mean = np.array([[0.3, 1.1, 0.0], [-2.0, -0.4, 0.2], [0.1, 0.0, 0.7]])
    problem = system_problem(PeriodicSystem(mean, period=1.5))
    enclosed = monodromy(arithmetic, problem.flow(arithmetic))
    scaled, time = np.diag(scales(problem, arithmetic)), float(problem.unit.low)
    with mpmath.workdps(60):
        exact = mpmath.expm(mpmath.matrix((np.linalg.inv(scaled) @ mean @ scaled).tolist()) * mpmath.mpf(time))
        for i in range(3):
            for j in range(3):
                assert contains_number(enclosed[i, j], exact[i, j])
    assert enclosed.rad.max() < 10.0 ** (2 - arithmetic.digits)


def scales(problem: Any, arithmetic: Any) -> Any:
    """Return the powers of two by which the unknowns are scaled, found from a map with and one without."""
    balanced = problem.flow(arithmetic).pieces[0].mean.centre() / float(problem.unit.low)
    mean = problem.pieces[0].mean.middle
    ratio = balanced / np.where(mean == 0.0, 1.0, mean)
    return np.array([1.0, ratio[0, 1], ratio[0, 1] * ratio[1, 2]])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(depth(6, 2)))
def test_maps_with_few_and_with_many_digits_overlap(seed: int) -> None:
    problem = system_problem(hamiltonian(seed, 2))
    maps = []
    for arithmetic in (Integers(30), Doubles(), Integers(6)):  # with 6, what the Taylor series leave out decides
        maps.append(monodromy(arithmetic, problem.flow(arithmetic)))
    fine, *coarse = maps
    for enclosed, tolerance in zip(coarse, (1e-9, 1e-2), strict=True):
        gap = np.abs(enclosed.centre() - fine.centre())
        assert (gap <= enclosed.offset() + fine.offset()).all()
        assert enclosed.rad.max() < tolerance * np.abs(fine.centre()).max()
    multipliers = np.sort(np.abs(np.linalg.eigvals(integrated(hamiltonian(seed, 2)))))
    assert np.allclose(np.sort(np.abs(np.linalg.eigvals(fine.centre()))), multipliers, rtol=1e-6, atol=1e-6)


@pytest.mark.slow
def test_errors_of_coefficients_widen_the_map() -> None:
    """Coefficients changed by up to their error, also periodically, leave the map enclosed."""
    error = 1e-3
    mean, amplitude = np.array([[0.0, 1.0], [-1.0, -0.1]]), np.array([[0.0, 0.0], [0.3, 0.0]])
    rough = system_problem(PeriodicSystem(mean, [amplitude], coefficient_error=error))
    flow = rough.flow(Doubles())
    enclosed = monodromy(Doubles(), flow)
    scale = flow.pieces[0].mean.centre()[0, 1] / float(rough.period.low)
    size = np.array([[1.0, scale], [1.0 / scale, 1.0]])
    for sign in (-1.0, 1.0):
        for shape in ([[1.0, 0.0], [0.0, -1.0]], [[0.5, 0.5], [0.5, 0.5]], [[1.0, 1.0], [1.0, 1.0]]):
            change = sign * error * np.array(shape)
            for changed in (
                PeriodicSystem(mean + change, [amplitude]),
                PeriodicSystem(mean, [amplitude], [0.0 * change, change]),
            ):
                assert (np.abs(integrated(changed) * size - enclosed.centre()) <= enclosed.rad + 1e-9).all()


@by_arithmetic
@settings(max_examples=depth(10, 3), deadline=None)
@given(seeds, st.integers(1, 4))
def test_discs_contain_the_eigenvalues(arithmetic: Any, seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    matrix = rng.normal(size=(n, n)) * 10.0 ** rng.uniform(-2.0, 2.0)
    if n > 1 and rng.random() < 0.5:  # close to a multiple eigenvalue
        matrix = np.eye(n) + 10.0 ** rng.uniform(-12.0, -1.0) * matrix
    try:
        discs = enclose_eigenvalues(arithmetic, arithmetic.exact(matrix))
    except Unresolved:
        return
    with mpmath.workdps(50):
        exact = mpmath.matrix(matrix.tolist())
        values = mpmath.eig(exact)[0] if n > 1 else [exact[0, 0]]
        for part in discs.parts():
            reach = discs.radii[part] + 1e-14 * np.abs(matrix).max() * n
            held = [
                value
                for value in values
                if any(abs(value - discs.centres[i]) <= r for i, r in zip(part, reach, strict=True))
            ]
            assert len(held) >= len(part)
        squares = [float(abs(value) ** 2 - 1) for value in values]
    slack = 1e-12 * max(1.0, *map(abs, squares))
    assert min(squares) >= discs.low.min() - slack
    assert max(squares) <= discs.high.max() + slack


# --- counts ---


@by_arithmetic
def test_inertia(arithmetic: Any) -> None:
    rng = np.random.default_rng(5)
    for n in (1, 2, 5, 9):
        lower = np.tril(rng.integers(-2, 3, (n, n)), -1) + np.eye(n)
        signs = np.where(rng.random(n) < 0.5, -1.0, 1.0)
        matrix = lower @ np.diag(signs * 2.0 ** rng.integers(-12, 3, n)) @ lower.T  # exact
        found = inertia(arithmetic, arithmetic.exact(matrix), np.abs(matrix).sum(1))
        assert found.negative == (signs < 0.0).sum()
        singular = lower @ np.diag(np.r_[signs[:-1], 0.0]) @ lower.T
        with pytest.raises(Unresolved):
            inertia(arithmetic, arithmetic.exact(singular), np.abs(singular).sum(1) + 1.0)


def test_inertia_of_a_matrix_that_doubles_cannot_tell_from_a_singular_one() -> None:
    close = 2.0**-60
    matrix = Integers(40).exact(np.array([[1.0, 1.0], [1.0, 1.0]])) + Integers(40).exact(np.diag([0.0, -close]))
    assert inertia(Integers(40), matrix, np.ones(2)).negative == 1


@pytest.mark.parametrize("digits", [12, 40])
def test_only_real_balls_without_zero_have_reciprocals(digits: int) -> None:
    balls = Integers(digits).exact(np.array([4.0, -0.5, 1e-3]))
    found = balls.inverse()
    assert np.abs(found.centre() - [0.25, -2.0, 1000.0]).max() <= found.offset().max() < 1e-3
    for wrong in (Integers(digits).exact(np.array([1.0, 0.0])), balls.times_i()):
        with pytest.raises(Unresolved, match="cannot be distinguished from zero"):
            wrong.inverse()


@pytest.mark.slow
@pytest.mark.parametrize("arithmetic", [Doubles(), Integers(25)], ids=["doubles", "25 digits"])
@pytest.mark.parametrize("seed", range(depth(8, 2)))
def test_counts_are_those_of_a_larger_dense_matrix(arithmetic: Any, seed: int) -> None:
    system, angles = hamiltonian(seed, 2), [0.0, 0.125, 0.3125, 0.5]
    problem = system_problem(system)
    found = count(arithmetic, problem.oscillators(arithmetic, problem.unit, freed=False), angles)
    expected = dict(zip(angles, (dense_count(system, angle) for angle in angles), strict=True))
    assert len(found.angles) >= 3
    assert list(found.negative) == [expected[angle] for angle in found.angles]


@pytest.mark.parametrize("seed", range(8))
def test_what_the_cut_leaves_out_is_enclosed(seed: int) -> None:
    """Eliminating the blocks that are cut off, out to far away, leaves a matrix that is enclosed."""
    system = hamiltonian(seed, 2)
    problem = system_problem(system)
    balls = problem.oscillators(Doubles(), problem.unit, freed=False)
    regular = _last(Doubles(), balls)
    for last in {max(len(balls.waves), regular - 4), regular}:
        truncation = _truncation(balls, last)
        enclosed, _ = _matrix(Doubles(), balls, truncation, 0.125)
        size, far = enclosed.shape[0], 20 * system.order
        scale = np.kron(np.eye(2 * (last + 20) + 1), np.linalg.inv(np.linalg.cholesky(system.mass)) * system.period)
        whole = scale @ dense(system, 0.125, last + 20) @ scale.T
        kept, beyond = np.arange(far, far + size), np.r_[:far, far + size : len(whole)]
        coupling = whole[np.ix_(kept, beyond)]
        rest = coupling @ np.linalg.solve(whole[np.ix_(beyond, beyond)], coupling.conj().T)
        gap = np.abs(whole[np.ix_(kept, kept)] - rest - enclosed.mid)
        assert (gap <= enclosed.rad + 1e-12 * np.abs(whole).max()).all()


@pytest.mark.parametrize("seed", range(4))
def test_counts_hold_for_stiffnesses_within_their_error(seed: int) -> None:
    """Whatever the error does in a period: here a constant, a harmonic or both, as large as stated."""
    exact, error, angles = hamiltonian(seed, 2), 1e-2, [0.0, 0.125, 0.3125, 0.5]
    others = {"mass": exact.mass, "gyroscopic": exact.gyroscopic, "period": exact.period}
    rough = system_problem(HillSystem(exact.stiffness, exact.cosines, exact.sines, coefficient_error=error, **others))
    found = count(Doubles(), rough.oscillators(Doubles(), rough.unit, freed=False), angles)
    assert len(found.angles) >= 2
    for steady, shape in itertools.product((-1.0, 0.0, 1.0), ([[1, 1], [1, 1]], [[1, -1], [-1, 1]], [[1, 0], [0, -1]])):
        change = error * np.array(shape, dtype=float)
        cosines = [*exact.cosines, (1.0 - abs(steady)) * change]
        changed = HillSystem(exact.stiffness + steady * change, cosines, exact.sines, **others)
        assert [dense_count(changed, angle) for angle in found.angles] == list(found.negative)


def dense_count(system: HillSystem, angle: float) -> int:
    """Count the negative eigenvalues of Hill's matrix, cut off far out."""
    return int((np.linalg.eigvalsh(dense(system, angle, 25)) < 0.0).sum())


def dense(system: HillSystem, angle: float, last: int) -> Any:
    """Return Hill's matrix with blocks up to ``last``."""
    n, blocks = system.order, 2 * last + 1
    matrix = np.zeros((blocks, n, blocks, n), dtype=complex)
    gyroscopic = np.zeros((n, n)) if system.gyroscopic is None else system.gyroscopic
    for k in range(blocks):
        nu = 2.0 * math.pi * (angle + k - last) / system.period
        matrix[k, :, k, :] = nu * nu * system.mass - 1j * nu * gyroscopic - system.stiffness
        for j, amplitude in enumerate(system.harmonics, 1):
            if k + j < blocks:
                matrix[k + j, :, k, :] = -amplitude / 2.0
                matrix[k, :, k + j, :] = -amplitude.conj() / 2.0
    return matrix.reshape(blocks * n, blocks * n)


# --- Krein signs of a map ---------------------------------------------------------------------------------------------


def jumping(n: int, apart: float = 0.0, **others: Any) -> fr.HillSystem:
    """Return n oscillators whose stiffness jumps, each ``apart`` from the next: their multipliers meet, of one sign."""
    spread = apart * np.diag(np.arange(n))
    return fr.HillSystem.from_pieces([(1.0, 1.5 * np.eye(n) + spread), (1.0, 0.5 * np.eye(n) + spread)], **others)


@pytest.mark.parametrize(
    "system",
    [
        jumping(2),
        jumping(3, 1e-15),
        jumping(2, mass=2.0 * np.eye(2)),
        jumping(2, gyroscopic=[[0.0, 1e-15], [-1e-15, 0.0]]),
        jumping(2, damping=1e-15 * np.eye(2)),
        jumping(2).as_periodic_system(),
    ],
)
def test_multipliers_of_one_krein_sign_that_meet_are_proved_stable(system: Any) -> None:
    proof = fr.certify(system)
    assert proof.status == "stable"
    assert "Krein signs" in proof.statement
    assert float(proof.enclosures[0].low) > 0.5


def test_multipliers_of_opposite_krein_signs_that_meet_are_not() -> None:
    """Of the energy (q1^2 + p1^2 - q2^2 - p2^2) / 2, times what jumps: any coupling decides.

    Without it A + A^T = 0: the norm is kept, which no multipliers prove.
    """
    first, unit = (
        np.diag([1.0, -1.0, 1.0, -1.0]),
        np.block([[np.zeros((2, 2)), np.eye(2)], [-np.eye(2), np.zeros((2, 2))]]),
    )
    for size, status in ((0.0, "stable"), (1e-3, "unstable")):
        couple = size * (np.eye(4)[[0]].T @ np.eye(4)[[1]])
        pieces = [(1.0, unit @ first), (0.5, unit @ (2.0 * first + couple + couple.T))]
        assert fr.certify(fr.PeriodicSystem.from_pieces(pieces)).status == status


def test_sums_of_krein_signs_on_arcs(rng: np.random.Generator) -> None:
    """Against the signs of the eigenvectors of random symplectic maps, pairs off the circle among them."""
    arithmetic, off = Doubles(), 0
    for _ in range(depth(200, 30)):
        n = int(rng.integers(1, 4))
        unit = np.block([[np.zeros((n, n)), np.eye(n)], [-np.eye(n), np.zeros((n, n))]])
        energy = rng.normal(size=(2 * n, 2 * n))
        matrix = expm(unit @ (energy + energy.T))
        values, vectors = np.linalg.eig(matrix)
        signs = np.sign(np.einsum("ij,ij->j", vectors.conj(), 1j * (unit @ vectors)).real)
        on = np.abs(np.abs(values) - 1.0) < 1e-9
        off += not on.all()
        turns = np.angle(values) / (2.0 * np.pi)
        angles = [0.0, *np.sort(np.round(rng.uniform(0.0, 0.5, 2) * 1024.0) / 1024.0), 0.5]
        found = krein_sums(arithmetic, arithmetic.exact(matrix), arithmetic.exact(canonical_form(2 * n)), angles)
        for total, (low, high) in zip(found.sums, pairwise(angles), strict=True):
            assert abs(total) == abs(signs[on & (low < turns) & (turns < high)].sum())
    assert off > 5
