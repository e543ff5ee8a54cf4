"""Systems as values: equality, copies, batches, structure and the forms they are turned into."""

from __future__ import annotations

import copy
import dataclasses
import math
import pickle
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.equations import in_batches, stack
from floquetrod.equations.hill_system import _is_multiple
from floquetrod.equations.matrices import MOST_EQUATIONS

K = [[1.0, 0.25], [0.25, 4.0]]
A = [[0.5, 1.0], [1.0, 0.8]]
B = [[0.0, -0.5], [-0.5, 0.25]]
M = [[3.0, 1.0], [1.0, 1.0]]
G = [[0.0, 0.5], [-0.5, 0.0]]
SKEW_FORCE = [[0.0, 0.25], [-0.125, 0.0]]
"""Not symmetric, as that of a follower load."""

MADE = {
    "plain": fr.HillSystem(K),
    "one harmonic": fr.HillSystem(K, [A], period=2.0),
    "all": fr.HillSystem(K, [A, B], [B], mass=M, damping=[[0.1, 0.0], [0.0, 0.2]], gyroscopic=G, period=3.0),
    "batch": fr.HillSystem([K, A], [A], period=[1.0, 2.0]),
    "first order": fr.PeriodicSystem([[0.0, 1.0], [-1.0, -0.1]], [B], [A, B], period=1.5, coefficient_error=1e-12),
}


def random_system(rng: np.random.Generator, n: int, **changes: Any) -> fr.HillSystem:
    """Return a Hamiltonian system of n oscillators with two harmonics and a mass matrix."""
    root = np.eye(n) + 0.1 * rng.uniform(-1.0, 1.0, (n, n))
    given = {
        "stiffness": symmetric(rng, n) + np.diag(np.arange(1.0, n + 1)),
        "cosines": [symmetric(rng, n), symmetric(rng, n)],
        "sines": [symmetric(rng, n)],
        "mass": tidy(root @ root.T),
        "period": float(rng.uniform(0.5, 3.0)),
    }
    return fr.HillSystem(**(given | changes))


def tidy(matrix: Any) -> np.ndarray:
    """Return the symmetric part."""
    return 0.5 * (matrix + matrix.T)


def symmetric(rng: np.random.Generator, n: int) -> np.ndarray:
    return tidy(rng.uniform(-1.0, 1.0, (n, n)))


def map_over_a_period(system: fr.PeriodicSystem, steps: int = 2000) -> np.ndarray:
    """Return the monodromy matrix by the classical Runge-Kutta method: independent of the package's integrators."""
    h = system.period / steps
    values = system.coefficient(np.arange(2 * steps + 1) * (0.5 * h))
    x = np.eye(system.order)
    for j in range(steps):
        first, middle, last = values[2 * j : 2 * j + 3]
        a = first @ x
        b = middle @ (x + 0.5 * h * a)
        c = middle @ (x + 0.5 * h * b)
        x = x + h / 6.0 * (a + 2.0 * b + 2.0 * c + last @ (x + h * c))
    return x


def spectrum(system: fr.HillSystem | fr.PeriodicSystem) -> np.ndarray:
    """Return coefficients of the characteristic polynomial of the map: the multipliers, in no order."""
    first = system.as_periodic_system() if isinstance(system, fr.HillSystem) else system
    return np.poly(map_over_a_period(first))


# --- values ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MADE)
def test_copies_are_equal_hash_alike_and_cannot_be_written_into(name: str) -> None:
    system = MADE[name]
    system.harmonics  # noqa: B018 - a cached value does not count
    for twin in (pickle.loads(pickle.dumps(system)), copy.deepcopy(system), copy.copy(system)):
        assert twin == system
        assert hash(twin) == hash(system)
        assert repr(twin) == repr(system)
        arrays = [twin.harmonics, *twin.cosines, getattr(twin, "stiffness", None), getattr(twin, "mean", None)]
        for array in arrays:
            if array is not None:
                assert not array.flags.writeable
    again = dataclasses.replace(system, period=7.0)
    assert again != system
    assert dataclasses.replace(again, period=system.period) == system


@pytest.mark.parametrize("name", MADE)
def test_the_repr_makes_the_system_again(name: str) -> None:
    names = {"HillSystem": fr.HillSystem, "PeriodicSystem": fr.PeriodicSystem}
    assert eval(repr(MADE[name]), names) == MADE[name]


def test_large_matrices_are_described_by_their_shape() -> None:
    assert "<20 x 20 array>" in repr(fr.HillSystem(np.eye(20)))


def test_the_matrices_are_copies() -> None:
    stiffness, forcing = np.array(K), np.array(A)
    system = fr.HillSystem(stiffness, [forcing])
    stiffness[0, 0] = forcing[0, 0] = 99.0
    assert system == fr.HillSystem(K, [A])
    with pytest.raises(ValueError, match="read-only"):
        system.stiffness[0, 0] = 2.0


def test_every_matrix_counts() -> None:
    base = MADE["all"]
    for name in ("stiffness", "mass", "damping"):
        other = np.array(getattr(base, name))
        other[1, 1] = np.nextafter(other[1, 1], 9.0)
        assert dataclasses.replace(base, **{name: other}) != base
    assert dataclasses.replace(base, sines=[A]) != base
    assert dataclasses.replace(base, cosines=[A]) != base


def test_what_is_absent_is_none() -> None:
    system = fr.HillSystem(K, mass=np.eye(2), damping=np.zeros((2, 2)), gyroscopic=np.zeros((2, 2)))
    assert system == fr.HillSystem(K)
    assert system.mass is None
    assert fr.HillSystem(K, [A, np.zeros((2, 2))]).harmonics.shape == (1, 2, 2)
    assert fr.HillSystem(K, [np.zeros((2, 2))]).is_constant
    assert not fr.HillSystem(K, sines=[A]).is_constant


def test_the_harmonics_are_the_coefficient(rng: np.random.Generator) -> None:
    system = MADE["all"]
    t = rng.uniform(-5.0, 5.0, size=(3, 4))
    w = 2.0 * math.pi / system.period
    expected = np.array(K) + np.cos(w * t)[..., None, None] * A + np.sin(w * t)[..., None, None] * B
    expected = expected + np.cos(2.0 * w * t)[..., None, None] * B
    assert system.coefficient(t).shape == (3, 4, 2, 2)
    assert np.allclose(system.coefficient(t), expected, rtol=0.0, atol=1e-14)
    assert fr.HillSystem(K).coefficient(1.0).tolist() == K


@pytest.mark.slow
def test_a_thousand_equations() -> None:
    system = fr.HillSystem(np.eye(1000) + 1.0, [np.ones((1000, 1000))], damping=0.5 * np.eye(1000))
    assert system.structure == "damped"
    assert system.uniform_damping == 0.25
    assert system.undamped is not None
    largest = fr.HillSystem(np.eye(MOST_EQUATIONS)).as_periodic_system()
    assert largest.order == 2 * MOST_EQUATIONS


# --- batches ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "shape"),
    [
        ({"stiffness": np.zeros((5, 1, 2, 2)), "period": [1.0, 2.0, 3.0]}, (5, 3)),
        ({"stiffness": K, "period": [1.0, 2.0]}, (2,)),
        ({"stiffness": K, "cosines": [np.zeros((4, 2, 2)), A]}, (4,)),
        ({"stiffness": K, "mass": [M, M]}, (2,)),
        ({"stiffness": K, "period": np.array(2.0)}, ()),
    ],
)
def test_leading_shapes(arguments: dict[str, Any], shape: tuple[int, ...]) -> None:
    system = fr.HillSystem(**arguments)
    assert system.shape == shape
    assert system.harmonics.shape[: len(shape)] == shape
    form = system.even_form
    assert form is not None
    assert form.stiffness.shape == (*shape, 2, 2)
    assert form.start.shape == form.error.shape == form.uncertainty.shape == shape
    first = system.as_periodic_system()
    assert first.shape == shape
    assert first.structure == "hamiltonian"


def test_leading_shapes_that_do_not_fit() -> None:
    with pytest.raises(ValueError, match=r"leading shapes must broadcast to one, got stiffness \(2,\), period \(3,\)"):
        fr.HillSystem([K, A], period=[1.0, 2.0, 3.0])
    with pytest.raises(ValueError, match=r"the leading shapes must make at most 67,108,864 systems"):
        fr.HillSystem(np.zeros((100_000, 1, 2, 2)), period=np.ones(1000))
    with pytest.raises(ValueError, match=r"a single system, got a batch of shape .*systems\.multipliers\(batch\)"):
        fr.stability(MADE["batch"])
    with pytest.raises(ValueError, match="a single system, got a batch of shape"):
        MADE["batch"].coefficient(0.0)


def test_a_batch_is_even_where_its_systems_are(rng: np.random.Generator) -> None:
    zero = np.zeros((2, 2))
    turned = [(math.cos(0.7 * k) * np.array(A), math.sin(0.7 * k) * np.array(A)) for k in (1, 2)]
    every = [
        fr.HillSystem(K, [A, B], period=2.0),
        fr.HillSystem(K, [zero, zero], [zero, B], period=2.0),
        fr.HillSystem(K, [c for c, _ in turned], [s for _, s in turned], period=2.0),
        fr.HillSystem(K, [zero, turned[1][0]], [zero, turned[1][1]], period=2.0),
        fr.HillSystem(K, [A], [zero, zero], period=2.0),
        fr.HillSystem(K, period=2.0),
    ]
    batch = stack(every)
    assert batch.even_form is not None
    for i, system in enumerate(every):
        assert system.even_form is not None
        assert (batch.even_form.uncertainty[i] == 0.0) == (system.even_form.uncertainty == 0.0) == (i not in (2, 3))
        assert_even(system, system.even_form, rng)
        amplitudes = batch.even_form.amplitudes[i]
        one = system.even_form._replace(amplitudes=amplitudes, start=batch.even_form.start[i])
        assert_even(system, one, rng)
    uneven = fr.HillSystem(K, [A], [zero, A], period=2.0)
    assert uneven.even_form is None
    assert stack([*every, uneven]).even_form is None


def test_stacking_keeps_every_system_and_shares_what_is_the_same() -> None:
    systems = [
        fr.HillSystem(K, [A], mass=M, damping=0.5 * np.array(M), period=2.0),
        fr.HillSystem(A, [A, B], [B], mass=M, damping=0.5 * np.array(M), period=3.0),
    ]
    batch = stack(systems)
    assert batch.shape == (2,)
    assert batch.mass is not None
    assert batch.mass.shape == (2, 2)
    assert batch.uniform_damping == 0.25
    assert batch.harmonics.shape == (2, 2, 2, 2)
    for i, system in enumerate(systems):
        count = len(system.harmonics)
        assert np.array_equal(batch.harmonics[i, :count], system.harmonics)
        assert not batch.harmonics[i, count:].any()
        assert batch.period[i] == system.period
    mixed = stack([fr.HillSystem(K), fr.HillSystem(K, mass=M, damping=M, gyroscopic=G)])
    assert mixed.mass is not None
    assert mixed.mass.tolist() == [np.eye(2).tolist(), M]
    assert mixed.damping is not None
    assert not mixed.damping[0].any()
    alone = stack([fr.HillSystem(K)])
    assert alone.shape == (1,)
    first = stack([MADE["first order"], fr.PeriodicSystem(K)])
    assert first.coefficient_error == 1e-12
    assert first.shape == (2,)


@pytest.mark.parametrize(
    ("systems", "error", "message"),
    [
        ([], ValueError, "systems must hold at least one system"),
        ([fr.HillSystem(K), fr.PeriodicSystem(K)], TypeError, r"systems\[1\] must be a HillSystem"),
        ([fr.HillSystem(K), fr.HillSystem([[1.0]])], ValueError, r"systems\[1\] .* of order 2, got one of order 1"),
        ([MADE["batch"]], ValueError, r"systems\[0\] .* got a batch of shape \(2,\)"),
        ([1.0], TypeError, r"systems\[0\] must be a PeriodicSystem"),
    ],
)
def test_what_cannot_be_stacked(systems: list[Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        stack(systems)


def test_systems_of_many_kinds_are_asked_about_in_batches() -> None:
    systems = [
        *(fr.HillSystem([[k + 1.0]]) for k in range(3)),
        fr.HillSystem(K),
        fr.PeriodicSystem(K),
        fr.HillSystem([[7.0]]),
        fr.HillSystem([[8.0]], damping=[[0.5]]),
    ]
    asked = []

    def ask(batch: Any) -> tuple[np.ndarray, list[str]]:
        asked.append((batch.shape, batch.structure))
        mean = getattr(batch, "stiffness", getattr(batch, "mean", None))
        return mean[:, 0, 0], [type(batch).__name__] * batch.shape[0]

    answers = in_batches(systems, ask)
    assert [value for value, _ in answers] == [1.0, 2.0, 3.0, 1.0, 1.0, 7.0, 8.0]
    assert [name for _, name in answers] == [type(system).__name__ for system in systems]
    assert sorted(asked) == sorted([((4,), "hamiltonian"), ((1,), "hamiltonian"), ((1,), "general"), ((1,), "damped")])


# --- structure -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "structure"),
    [
        ({}, "hamiltonian"),
        ({"gyroscopic": G}, "hamiltonian"),
        ({"mass": M, "sines": [B]}, "hamiltonian"),
        ({"cosines": [SKEW_FORCE]}, "reversible"),
        ({"cosines": [], "sines": [SKEW_FORCE]}, "reversible"),
        ({"cosines": [SKEW_FORCE], "mass": M}, "reversible"),
        ({"cosines": [SKEW_FORCE], "sines": [A]}, "general"),
        ({"cosines": [SKEW_FORCE], "gyroscopic": G}, "general"),
        ({"damping": [[0.1, 0.0], [0.0, 0.2]]}, "damped"),
        ({"damping": np.eye(2)}, "damped"),
        ({"damping": [[1.0, 1.0], [1.0, 1.0]]}, "damped"),
        ({"damping": [[0.1, 0.0], [0.0, -0.2]]}, "general"),
        ({"damping": [[0.1, 0.2], [0.0, 0.2]]}, "general"),
        ({"damping": np.eye(2), "cosines": [SKEW_FORCE]}, "general"),
    ],
)
def test_structure_of_second_order(arguments: dict[str, Any], structure: str) -> None:
    given = {"stiffness": K, "cosines": [A]} | arguments
    assert fr.HillSystem(**given).structure == structure
    doubled = fr.HillSystem(**(given | {"period": [1.0, 2.0]}))
    assert doubled.structure == structure


@pytest.mark.parametrize(
    ("mean", "cosines", "sines", "structure"),
    [
        ([[0.5, 1.0], [-2.0, -0.5]], [], [], "hamiltonian"),
        ([[0.0, 1.0], [-2.0, 0.0]], [[[0.0, 0.0], [1.0, 0.0]]], [[[0.0, 0.5], [1.0, 0.0]]], "hamiltonian"),
        ([[0.5, 1.0], [-2.0, -0.4]], [], [], "general"),
        (np.zeros((3, 3)), [], [], "unitary"),
        ([[0.0, 1.0, 0.0], [-1.0, 0.0, 2.0], [0.0, -2.0, 0.0]], [np.eye(3, k=1) - np.eye(3, k=-1)], [], "unitary"),
        ([[0.0, 1.0, 0.0], [-1.0, 0.0, 2.0], [0.0, -2.0, 0.0]], [np.eye(3, k=1)], [], "general"),
        ([[0.0, 1.0], [-2.0, 0.0]], [], [[[0.5, 0.0], [0.0, 0.5]]], "reversible"),
        ([[0.0, 1.0], [-2.0, 0.0]], [[[0.5, 0.0], [0.0, 0.5]]], [], "general"),
    ],
)
def test_structure_of_first_order(mean: Any, cosines: Any, sines: Any, structure: str) -> None:
    assert fr.PeriodicSystem(mean, cosines, sines).structure == structure


@pytest.mark.parametrize("name", ["stiffness", "cosines", "sines"])
def test_one_ulp_of_asymmetry_is_another_structure(name: str) -> None:
    matrices = {"stiffness": np.array(K), "cosines": np.array([A]), "sines": np.array([B])}
    assert fr.HillSystem(**matrices).structure == "hamiltonian"
    matrices[name][..., 0, 1] = np.nextafter(matrices[name][..., 0, 1], 9.0)
    assert fr.HillSystem(**matrices).structure in ("general", "reversible")


def test_one_ulp_decides_about_uniform_damping() -> None:
    for mass in (None, M):
        damping = 0.5 * (np.eye(2) if mass is None else np.array(mass))
        system = fr.HillSystem(K, [A], mass=mass, damping=damping)
        assert system.uniform_damping == 0.25
        for index in [(0, 0), (0, 1), (1, 1)]:
            other = damping.copy()
            other[index] = other[index[::-1]] = np.nextafter(other[index], 9.0)
            assert fr.HillSystem(K, [A], mass=mass, damping=other).uniform_damping is None
        assert fr.HillSystem(K, [A], mass=mass, damping=-damping).uniform_damping is None
        batch = fr.HillSystem([K, A], mass=mass, damping=np.stack([damping, damping]))
        assert batch.uniform_damping == 0.25
        assert fr.HillSystem([K, A], mass=mass, damping=np.stack([damping, 2.0 * damping])).uniform_damping is None
    assert fr.HillSystem(K, damping=[[0.1, 0.0], [0.0, 0.0]]).uniform_damping is None
    assert fr.HillSystem(K).uniform_damping == 0.0


SIZES = st.one_of(*(st.integers(1, 2**bits) for bits in (8, 26, 27, 45, 53)))


@given(SIZES, SIZES, st.integers(-60, 60), st.sampled_from((1.0, -1.0)), st.integers(-1, 1))
def test_multiples_are_told_exactly(whole: int, factor: int, power: int, sign: float, ulps: int) -> None:
    other, scale = sign * whole, math.ldexp(factor, power)
    product = other * scale
    for _ in range(abs(ulps)):
        product = math.nextafter(product, math.copysign(math.inf, ulps))
    expected = Fraction(product) == Fraction(other) * Fraction(scale)
    assert _is_multiple(np.array([[product]]), scale, np.array([[other]])) is expected


# --- forms -----------------------------------------------------------------------------------------------------------


def assert_even(system: fr.HillSystem, form: Any, rng: np.random.Generator) -> None:
    """Check the amplitudes about the instant of evenness against K(t), both ways from it."""
    root = np.eye(system.order) if system.mass is None else np.linalg.inv(np.linalg.cholesky(system.mass))
    s = rng.uniform(-3.0, 3.0, size=9)
    waves = np.cos(2.0 * math.pi / system.period * s[:, None] * np.arange(1, len(form.amplitudes) + 1))
    expected = form.stiffness + np.einsum("tk,kij->tij", waves, form.amplitudes)
    size = np.abs(form.stiffness).max() + np.abs(form.amplitudes).sum()
    for sign in (1.0, -1.0):
        found = root @ system.coefficient(form.start + sign * s) @ root.T
        assert np.abs(found - expected).max() <= 1e-13 * size + 2.0 * form.error


@pytest.mark.parametrize("mass", [None, M])
@pytest.mark.parametrize("start", [0.0, 0.3, -1.1])
@pytest.mark.parametrize("harmonics", [(1,), (2,), (1, 2, 3), (2, 3)])
def test_the_even_form_is_the_coefficient(
    mass: Any, start: float, harmonics: tuple[int, ...], rng: np.random.Generator
) -> None:
    series = {k: symmetric(rng, 2) if k in harmonics else np.zeros((2, 2)) for k in range(1, 4)}
    cosines = [math.cos(k * start) * matrix for k, matrix in series.items()]
    sines = [math.sin(k * start) * matrix for k, matrix in series.items()]
    system = fr.HillSystem(K, cosines, sines, mass=mass, period=2.5)
    form = system.even_form
    assert form is not None
    assert_even(system, form, rng)
    assert fr.HillSystem(K, cosines, sines, damping=np.eye(2)).even_form is None
    assert fr.HillSystem(K, cosines, sines, gyroscopic=G).even_form is None


def test_first_order_form_has_the_multipliers_of_the_equations(rng: np.random.Generator) -> None:
    """Check against the equations as they are written: (q, q') with the mass inverted."""
    for changes in ({}, {"gyroscopic": G}, {"damping": [[0.1, 0.05], [0.0, 0.2]]}, {"damping": M, "gyroscopic": G}):
        system = random_system(rng, 2, **changes)
        first = system.as_periodic_system()
        assert system.mass is not None
        inverse = np.linalg.inv(system.mass)
        zero, one = np.zeros((2, 2)), np.eye(2)
        rates = sum(m for m in (system.damping, system.gyroscopic) if m is not None) + zero

        def lower(matrix: Any, inverse: Any = inverse, zero: Any = zero) -> np.ndarray:
            return np.block([[zero, zero], [-inverse @ matrix, zero]])

        mean = np.block([[zero, one], [-inverse @ system.stiffness, -inverse @ rates]])
        plain = fr.PeriodicSystem(
            mean, [lower(m) for m in system.cosines], [lower(m) for m in system.sines], period=system.period
        )
        assert np.allclose(spectrum(first), spectrum(plain), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("n", [1, 2, 3, 5])
@pytest.mark.parametrize("turning", [False, True])
def test_hamiltonian_systems_stay_hamiltonian_in_first_order(n: int, turning: bool, rng: np.random.Generator) -> None:
    half = rng.uniform(-0.5, 0.5, (n, n))
    system = random_system(rng, n, gyroscopic=half - half.T if turning else None)
    first = system.as_periodic_system()
    assert first.structure == "hamiltonian"
    form = np.block([[np.zeros((n, n)), np.eye(n)], [-np.eye(n), np.zeros((n, n))]])
    for matrix in (first.mean, *first.cosines, *first.sines):
        assert np.array_equal(form @ matrix, (form @ matrix).T)
    assert 0.0 < first.coefficient_error < 1e-11
    full = map_over_a_period(first)
    assert np.allclose(full.T @ form @ full, form, rtol=0.0, atol=1e-8 * np.linalg.norm(full) ** 2)


def test_freeing_from_damping_shifts_the_exponents(rng: np.random.Generator) -> None:
    c = 0.125
    base = random_system(rng, 2)
    assert base.mass is not None
    system = fr.HillSystem(
        base.stiffness, base.cosines, base.sines, mass=base.mass, damping=2.0 * c * base.mass, period=base.period
    )
    assert system.undamped is not None
    freed, rate = system.undamped
    assert rate == c
    assert freed.structure == "hamiltonian"
    assert freed.even_form is None or freed.even_form.error > 0.0
    assert freed.as_periodic_system().coefficient_error > 0.0
    shifted = np.poly(math.exp(-c * base.period) * np.roots(spectrum(freed)))
    assert np.allclose(spectrum(system), shifted, rtol=1e-8, atol=1e-8)
    assert fr.HillSystem(K).undamped == (fr.HillSystem(K), 0.0)
    assert fr.HillSystem(K, damping=np.eye(2), gyroscopic=G).undamped is None
    assert fr.HillSystem(K, damping=[[0.1, 0.0], [0.0, 0.2]]).undamped is None


def test_rounding_of_what_is_freed_from_damping_is_covered() -> None:
    c = 0.1
    system = fr.HillSystem([[1.0]], [[[0.3]]], damping=[[2.0 * c]])
    assert system.undamped is not None
    freed, rate = system.undamped
    form = freed.even_form
    assert form is not None
    off = abs(Fraction(1) - Fraction(rate) ** 2 - Fraction(float(form.stiffness[0, 0])))
    assert 0 < off <= Fraction(float(form.error))


@pytest.mark.parametrize(
    "equation",
    [
        fr.Mathieu(0.5, -0.2, 0.1),
        fr.Mathieu(0.4, -0.3),
        fr.Hill(-0.2, cosines=(0.3, 0.1), sines=(0.2,), period=3.0, damping=0.05),
        fr.Hill(-0.7, period=2.0),
        fr.Meissner(0.4, -0.3, 0.05),
    ],
)
def test_scalar_equations_as_systems(equation: Any, rng: np.random.Generator) -> None:
    system = equation.as_system()
    t = rng.uniform(-4.0, 4.0, size=7)
    assert np.allclose(system.coefficient(t)[:, 0, 0], -equation.coefficient(t), rtol=0.0, atol=1e-14)
    assert system.period == equation.period
    assert system.uniform_damping == equation.damping
    expected = np.poly(np.array(fr.stability(equation, "reference").multipliers))
    assert np.allclose(spectrum(system), expected, rtol=1e-9, atol=1e-9)


def test_a_square_wave_has_no_finite_series() -> None:
    with pytest.raises(TypeError, match="must be one finite Fourier series, got one of 2 pieces"):
        fr.Meissner(0.5, -0.25).as_system().harmonics  # noqa: B018


# --- functions -------------------------------------------------------------------------------------------------------


def oscillator(stiffness: Any) -> Any:
    """Return A(t) of q'' + stiffness(t) q = 0."""
    return lambda t: [[0.0, 1.0], [-stiffness(t), 0.0]]


@pytest.mark.slow
@pytest.mark.parametrize(
    "stiffness",
    [
        lambda t: 1.0,
        lambda t: 1.0 / (1.1 + np.cos(t)),
        lambda t: 1.0 / (1.001 + np.cos(t)),
        lambda t: np.exp(-50.0 * (1.0 - np.cos(t - 1.0))),
        lambda t: 1.0 + 0.1 * np.cos(64.0 * t),  # which as many samples would take for a constant
        lambda t: 1.0 + 0.1 * np.sin(700.0 * t),
        lambda t: 1.0 + 1e-11 * np.sin(1e7 * math.sin(t)),  # noise, as that of an inverted matrix
        lambda t: 1e20 * (2.0 + np.sin(t)),
        lambda t: 1e-20 * (2.0 + np.sin(t)),
        lambda t: abs(np.sin(t)) ** 7,
    ],
)
def test_the_error_of_a_series_covers_its_distance_from_the_function(stiffness: Any, rng: np.random.Generator) -> None:
    period = 2.0 * math.pi
    system = fr.PeriodicSystem.from_function(oscillator(stiffness), period)
    t = rng.uniform(0.0, period, size=200)
    expected = np.array([oscillator(stiffness)(float(instant)) for instant in t])
    distance = np.abs(system.coefficient(t) - expected).max()
    size = np.abs(expected).max()
    assert distance <= system.coefficient_error + 4.0 * 2.2e-16 * size
    assert system.coefficient_error < 1e-8 * size
    assert fr.PeriodicSystem.from_function(oscillator(stiffness), period) == system


def test_a_finite_series_is_found_again(rng: np.random.Generator) -> None:
    given_ = fr.PeriodicSystem(
        rng.standard_normal((3, 3)), rng.standard_normal((2, 3, 3)), rng.standard_normal((4, 3, 3)), period=0.7
    )
    found = fr.PeriodicSystem.from_function(given_.coefficient, 0.7)
    assert np.abs(found.harmonics - given_.harmonics).max() <= found.coefficient_error < 1e-12
    assert np.abs(found.mean - given_.mean).max() <= found.coefficient_error


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (oscillator(lambda t: t), "function is not periodic: values a period of 6.28319 apart differ by"),
        (oscillator(lambda t: math.sin(0.5 * t)), "function is not periodic"),
        (oscillator(lambda t: float(math.fmod(t + 7.0, 2.0 * math.pi) > 3.0)), "function is not (smooth|periodic)"),
        (oscillator(lambda t: math.copysign(1.0, math.sin(t + 0.1))), "function is not smooth"),
        (oscillator(lambda t: abs(math.sin(t + 0.1))), "function is not smooth"),
        (oscillator(lambda t: 1.0 + math.cos(900.0 * t)), "function is not smooth"),
        (oscillator(lambda t: 1.0 + math.cos(2048.0 * t)), "function is not smooth"),
        (oscillator(lambda t: math.nan if t > 3.0 else 1.0), r"function\(.*\) must be finite"),
        (oscillator(lambda t: math.inf), r"function\(0\) must be finite"),
        (lambda t: 1.0, r"function\(0\) must be a square matrix.*give \[\[1.0\]\]"),
        (lambda t: [[1.0, 2.0]], r"function\(0\) must be a square matrix"),
        (lambda t: [[[1.0]]], "function must return one square matrix"),
        (lambda t: [[1.0]] if t < 3.0 else np.eye(2), "function must always return shape"),
        (lambda t: [[1.0, 2.0], [3.0]], r"function\(0\) must be .* equal lengths"),
    ],
)
def test_functions_that_are_refused(function: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fr.PeriodicSystem.from_function(function, 2.0 * math.pi)


@pytest.mark.parametrize(
    ("function", "period", "message"),
    [
        (1.0, 1.0, "function must be a function"),
        (lambda t: None, 1.0, r"function\(0\) must be a single real number"),
        (lambda t: [["1"]], 1.0, r"function\(0\) must hold real numbers"),
        (lambda t: [[1.0]], "1", "period must be a"),
    ],
)
def test_junk_in_place_of_functions(function: Any, period: Any, message: str) -> None:
    with pytest.raises(TypeError, match=message):
        fr.PeriodicSystem.from_function(function, period)


def test_an_error_inside_the_function_is_its_own() -> None:
    with pytest.raises(ZeroDivisionError):
        fr.PeriodicSystem.from_function(lambda t: [[1.0 / 0.0]], 1.0)
