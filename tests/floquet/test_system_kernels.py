"""Maps of periodic systems: errors against many digits, both forms against each other."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from floquetrod._util import compilation
from floquetrod.floquet.kernels import system_even, system_maps, system_series
from floquetrod.floquet.kernels.system_maps import product, segment_maps
from tests.conftest import depth, needs_jit
from tests.inside import half_period_map, pair_numbers
from tests.seams import Tuned

pytestmark = pytest.mark.kernels


@pytest.fixture(autouse=True)
def compiled_at_once(tuned: Tuned) -> None:
    tuned(is_series_kernel_on_disk=lambda function: False, maps_compiled_after=0.0)


Floats = NDArray[np.float64]


BITS = 256  # after the point, of numbers held as integers, which add and multiply much faster than those of mpmath


def fixed(values: Any) -> Any:
    """Return a number, or an array of them, as integers."""
    return np.vectorize(lambda value: int(mpmath.mpf(value) * 2**BITS), otypes=[object])(values)


def true_map(stiffness: Floats, amplitudes: Floats, period: float, share: float) -> Floats:
    """Return the map of (u, u') over a share of the period, by Taylor series with 60 digits."""
    n = len(stiffness)
    with mpmath.workdps(60):
        omega = 2 * mpmath.pi / mpmath.mpf(period)
        size = float(np.abs(stiffness).sum() + np.abs(amplitudes).sum())
        steps = int(4 + period * share * (np.sqrt(size) + len(amplitudes) * float(omega)))
        h = mpmath.mpf(period) * mpmath.mpf(share) / steps
        s, a, powers = fixed(stiffness), fixed(amplitudes), [fixed(h**i) for i in range(30)]
        value, slope = fixed(np.eye(n, 2 * n)), fixed(np.eye(n, 2 * n, n))
        for step in range(steps):
            k_terms = []
            for i in range(30):
                total = s * (1 if i == 0 else 0)
                for k, matrix in enumerate(a, 1):
                    wave = mpmath.cos(k * omega * h * step + i * mpmath.pi / 2) * (k * omega) ** i / mpmath.factorial(i)
                    total = total + (matrix * fixed(wave) >> BITS)
                k_terms.append(total)
            u = [value, slope]
            for i in range(28):
                force = sum((k_terms[j].dot(u[i - j]) for j in range(1, i + 1)), k_terms[0].dot(u[i])) >> BITS
                u.append(-force // ((i + 1) * (i + 2)))
            value = sum((u[i] * powers[i] for i in range(1, 30)), u[0] << BITS) >> BITS
            slope = sum((i * u[i] * powers[i - 1] for i in range(2, 30)), u[1] << BITS) >> BITS
    return (np.vstack([value, slope]) / 2**BITS).astype(float)


def random_system(
    rng: np.random.Generator, n: int, count: int, forcing: float, largest: float, symmetric: bool
) -> tuple[Floats, Floats, Floats]:
    stiffness = rng.normal(size=(1, n, n)) * 0.1 + np.diag(rng.uniform(-0.2, 1.0, n))
    amplitudes = forcing * rng.normal(size=(1, count, n, n))
    if symmetric:
        stiffness = stiffness + stiffness.swapaxes(-1, -2)
        amplitudes = amplitudes + amplitudes.swapaxes(-1, -2)
    return largest * stiffness, largest * amplitudes, np.array([rng.uniform(1.0, 6.0)])


def balanced(found: system_even.HalfPeriodMap, true: Floats) -> tuple[Floats, Floats]:
    basis = found.basis[0]
    n = len(basis)
    zero = np.zeros((n, n))
    inverse = np.linalg.inv(basis)
    change = np.block([[basis, zero], [zero, inverse.T]])
    back = np.block([[inverse, zero], [zero, basis.T]])
    return np.block([[found.a[0], found.b[0]], [found.c[0], found.d[0]]]), back @ true @ change


@pytest.mark.parametrize(
    ("n", "count", "symmetric"),
    [
        (1, 1, True),
        (1, 1, False),
        (2, 1, True),
        pytest.param(2, 1, False, marks=pytest.mark.slow),
        pytest.param(3, 3, True, marks=pytest.mark.slow),
        pytest.param(3, 3, False, marks=pytest.mark.slow),
    ],
)
def test_the_half_period_map_is_within_its_error(
    rng: np.random.Generator, n: int, count: int, symmetric: bool, tuned: Tuned
) -> None:
    for forcing, largest in [(0.5, 4.0), (0.05, 1.0), (0.1, 30.0)][: depth(3, 1) if n == 3 else 3]:
        system = random_system(rng, n, count, forcing, largest, symmetric)
        true = true_map(system[0][0], system[1][0], float(system[2][0]), 0.5)
        for accuracy in (1e-6, 1e-10, 1e-13):
            for small in (20, 0):
                tuned(equations_of_an_explicit_map=small)
                found = half_period_map(*system, accuracy)
                computed, expected = balanced(found, true)
                assert np.linalg.norm(computed - expected) <= found.error[0]


@pytest.mark.parametrize("symmetric", [True, False])
def test_two_equations_at_once_agree_with_the_monodromy_matrix(rng: np.random.Generator, symmetric: bool) -> None:
    for forcing, largest in [(0.05, 1.0), (0.3, 4.0), (0.1, 20.0)]:
        stiffness, amplitudes, period = random_system(rng, 2, 2, forcing, largest, symmetric)
        x, errors, _ = pair_numbers(stiffness, amplitudes, period, 1e-10)
        mean = np.zeros((1, 4, 4))
        mean[0, :2, 2:], mean[0, 2:, :2] = np.eye(2), -stiffness[0]
        harmonics = np.zeros((1, 2, 4, 4), dtype=complex)
        harmonics[0, :, 2:, :2] = -amplitudes[0]
        whole = product(segment_maps(mean, harmonics, period, 1e-12, 3))
        matrix = whole.matrix[0]
        # x are the double eigenvalues of M + M^-1, and of twice its first block about an instant of evenness
        expected = np.linalg.eigvals(2.0 * matrix[:2, :2])
        order = [0, 1] if abs(expected[0] - x[0, 0]) < abs(expected[1] - x[0, 0]) else [1, 0]
        slack = 1e-11 * np.linalg.norm(matrix) ** 2
        assert np.all(abs(expected[order] - x[0]) <= errors[0] + slack)


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_many_pairs_side_by_side_are_within_their_errors(rng: np.random.Generator, count: int) -> None:
    systems = [random_system(rng, 2, count, 0.2, size, True) for size in (0.3, 1.0, 3.0, 10.0) * depth(5, 1)]
    many = len(systems)
    systems.append((np.diag([1.0, 1.0])[None], np.zeros((1, count, 2, 2)), np.array([3.0])))
    systems.append(random_system(rng, 2, count, 0.2, 1.0, False))
    stiffness, amplitudes, period = (np.concatenate(parts) for parts in zip(*systems, strict=True))
    whole = [true_map(s, a, float(p), 1.0) for s, a, p in zip(stiffness, amplitudes, period, strict=True)]
    for accuracy in (1e-6, 1e-10, 1e-13):
        x, errors, krein = pair_numbers(stiffness, amplitudes, period, accuracy)
        for i, system in enumerate(systems):
            expected = np.linalg.eigvals(2.0 * whole[i][:2, :2])
            order = [0, 1] if abs(expected[0] - x[i, 0]) < abs(expected[1] - x[i, 0]) else [1, 0]
            slack = 1e-13 * np.linalg.norm(whole[i]) ** 2 + 1e-7 * (i == many)
            assert np.all(abs(expected[order] - x[i]) <= errors[i] + slack)
            alone, alone_errors, alone_krein = pair_numbers(*system, accuracy)
            assert np.all(abs(alone[0] - x[i]) <= errors[i] + alone_errors[0])
            decided = (krein[i] != 0.0) & (alone_krein[0] != 0.0)
            assert np.all(np.sign(krein[i, decided]) == np.sign(alone_krein[0, decided]))
        apart = (abs(x.imag) == 0.0) & (abs(x.real) < 1.9) & (abs(x[:, :1] - x[:, 1:]) > 0.1)
        assert np.all(krein[:many][apart[:many]] != 0.0)
        assert np.all(krein[many + 1] == 0.0)


def test_segment_maps_and_their_product_are_within_their_errors(rng: np.random.Generator) -> None:
    for forcing, largest in [(0.1, 1.0), (0.5, 10.0)][depth(0, 1) :]:
        stiffness, amplitudes, period = random_system(rng, 2, 2, forcing, largest, False)
        mean = np.zeros((1, 4, 4))
        mean[0, :2, 2:], mean[0, 2:, :2] = np.eye(2), -stiffness[0]
        harmonics = np.zeros((1, 2, 4, 4), dtype=complex)
        harmonics[0, :, 2:, :2] = -amplitudes[0]
        true = true_map(stiffness[0], amplitudes[0], float(period[0]), 1.0)
        first = true_map(stiffness[0], amplitudes[0], float(period[0]), 0.25)
        for accuracy in (1e-6, 1e-10, 1e-13):
            found = segment_maps(mean, harmonics, period, accuracy, 4)
            scale = found.scaling[0] / found.scaling[0][:, None]
            assert np.linalg.norm((found.maps[0, 0] - first) * scale) <= found.errors[0, 0]
            whole = product(found)
            assert np.linalg.norm((whole.matrix[0] - true) * scale) <= whole.error[0]


def true_flow(mean: Floats, harmonics: NDArray[np.complex128], period: float, share: float) -> Floats:
    """Return the map of x' = A(t) x over a share of the period from t = 0, by Taylor series with 60 digits."""
    n = len(mean)
    with mpmath.workdps(60):
        omega = 2 * mpmath.pi / mpmath.mpf(period)
        size = float(np.abs(mean).sum() + np.abs(harmonics).sum()) + len(harmonics) * float(omega)
        steps = int(2 + 2 * period * share * size / n)
        h = mpmath.mpf(period) * mpmath.mpf(share) / steps
        x, constant, powers = fixed(np.eye(n)), fixed(mean), [fixed(h**i) for i in range(30)]
        waves = [(fixed(z.real), fixed(z.imag)) for z in harmonics]
        for step in range(steps):
            tables = []
            for i in range(30):
                total = constant * (1 if i == 0 else 0)
                for k, (real, imaginary) in enumerate(waves, 1):
                    turned = mpmath.expjpi(2 * k * step * h / period) * (1j * k * omega) ** i / mpmath.factorial(i)
                    total = total + (real * fixed(turned.real) - imaginary * fixed(turned.imag) >> BITS)
                tables.append(total)
            terms = [x]
            for i in range(29):
                terms.append((sum(tables[j].dot(terms[i - j]) for j in range(i + 1)) >> BITS) // (i + 1))
            x = sum((term * power for term, power in zip(terms[1:], powers[1:], strict=True)), x << BITS) >> BITS
    return (x / 2**BITS).astype(float)


@pytest.mark.parametrize(
    ("n", "count"), [(1, 1), (2, 1), (4, 0), *(pytest.param(n, n - 1, marks=pytest.mark.slow) for n in (3, 4))]
)
def test_maps_of_any_form_are_within_their_errors(rng: np.random.Generator, n: int, count: int) -> None:
    for companion in (False, True)[: 1 + (n == 4)]:
        for size in (3.0, 0.3)[: depth(2, 1)]:
            mean = size * rng.normal(size=(1, n, n))
            harmonics = size * (rng.normal(size=(1, count, n, n)) + 1j * rng.normal(size=(1, count, n, n)))
            harmonics *= 10.0 ** -(3.0 * np.arange(count)[:, None, None])
            if companion:
                mean[:, :2] = np.eye(4)[2:]
                harmonics[:, :, :2] = 0.0
                harmonics[:, :, :, 3] = 0.0
            period = np.array([rng.uniform(1.0, 2.0)])
            true = true_flow(mean[0], harmonics[0], float(period[0]), 1.0)
            for accuracy in (1e-6, 1e-10, 1e-13):
                whole = product(segment_maps(mean, harmonics, period, accuracy, 2))
                scale = whole.scaling[0] / whole.scaling[0][:, None]
                wrong = np.linalg.norm((whole.matrix[0] - true) * scale)
                assert wrong <= whole.error[0]
                assert whole.error[0] <= 300.0 * accuracy * max(1.0, np.linalg.norm(true * scale)) ** 2


def test_large_systems_by_blas_agree_with_their_parts(rng: np.random.Generator) -> None:
    # Twelve independent pairs, coupled by a rotation of coordinates: 24 rows go through BLAS, 2 x 2 blocks do not.
    n = 12
    turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
    k0, k1 = np.diag(rng.uniform(1.0, 4.0, n)), 0.3 * np.diag(rng.normal(size=n))
    mean, harmonics = np.zeros((1, 2 * n, 2 * n)), np.zeros((1, 1, 2 * n, 2 * n), dtype=complex)
    mean[0, :n, n:], mean[0, n:, :n] = np.eye(n), -turn @ k0 @ turn.T
    harmonics[0, 0, n:, :n] = -turn @ k1 @ turn.T
    period = np.array([2.0])
    whole = product(segment_maps(mean, harmonics, period, 1e-12))
    change = np.kron(np.eye(2), turn)
    found = change.T @ whole.matrix[0] @ change
    for i in range(n):
        pair = np.array([[[0.0, 1.0], [-k0[i, i], 0.0]]])
        wave = np.array([[[[0.0, 0.0], [-k1[i, i], 0.0]]]], dtype=complex)
        alone = product(segment_maps(pair, wave, period, 1e-12))
        block = found[np.ix_([i, n + i], [i, n + i])]
        ratio = max(1.0, float(np.ptp(whole.scaling) / whole.scaling.min() + 1.0))
        assert np.linalg.norm(block - alone.matrix[0]) <= ratio**2 * (whole.error[0] + 4.0 * alone.error[0])


BAD = (np.nan, np.inf, -np.inf, 1e300, 1e149, 0.0)


@needs_jit
@pytest.mark.parametrize("compile_after", [0.0, 500.0])
@pytest.mark.parametrize("bad", BAD)
def test_unusable_coefficients_lose_only_their_own_system(
    rng: np.random.Generator, bad: float, compile_after: float, tuned: Tuned
) -> None:
    tuned(maps_compiled_after=compile_after)
    systems = [random_system(rng, 2, 1, 0.2, 1.0, True) for _ in range(5)]
    stiffness, amplitudes, period = (np.concatenate(parts) for parts in zip(*systems, strict=True))
    good = np.arange(5) != 3
    for name in ("stiffness", "amplitudes", "period"):
        if name == "period" or bad != 0.0:
            spoilt = {"stiffness": stiffness.copy(), "amplitudes": amplitudes.copy(), "period": period.copy()}
            spoilt[name][3] = bad
            x, errors, krein = pair_numbers(*spoilt.values())
            assert np.all(np.isinf(errors[3]) | np.isnan(errors[3]))
            assert np.all(krein[3] == 0.0)
            assert np.all(errors[good] < 1e-8)
            assert np.all(np.isfinite(x[good]))
            half = half_period_map(*spoilt.values())
            assert np.all(np.isinf(half.error) == ~good)
            assert half.symmetric
            mean, harmonics = as_first_order(spoilt["stiffness"], spoilt["amplitudes"])
            parts = segment_maps(mean, harmonics, spoilt["period"], least_segments=2)
            whole = product(parts)
            assert np.all(np.isinf(parts.errors[3]))
            assert np.isinf(whole.error[3]) or np.isnan(whole.error[3])
            assert np.all(parts.errors[good] < 1e-9)
            assert np.all(whole.error[good] < 1e-8)


def as_first_order(stiffness: Floats, amplitudes: Floats) -> tuple[Floats, NDArray[np.complex128]]:
    """Return mean and harmonics of x' = A(t) x, x = (u, u')."""
    batch, n = stiffness.shape[:2]
    mean = np.zeros((batch, 2 * n, 2 * n))
    harmonics = np.zeros((batch, amplitudes.shape[1], 2 * n, 2 * n), dtype=complex)
    mean[:, :n, n:], mean[:, n:, :n] = np.eye(n), -stiffness
    harmonics[:, :, n:, :n] = -amplitudes
    return mean, harmonics


@pytest.mark.parametrize("compile_after", [0.0, 500.0])
@pytest.mark.parametrize("n", [1, 2, 3])
def test_free_coordinates_drift(n: int, compile_after: float, tuned: Tuned) -> None:
    tuned(maps_compiled_after=compile_after)
    stiffness, amplitudes, period = np.zeros((3, n, n)), np.zeros((3, 1, n, n)), np.array([2.0, 1e-3, 1e4])
    amplitudes[2] = 1e-300
    half = half_period_map(stiffness, amplitudes, period)
    for i in range(3):
        one = system_even.HalfPeriodMap(*(value[i : i + 1] for value in half[:6]), half.symmetric)
        true = np.block([[np.eye(n), 0.5 * period[i] * np.eye(n)], [np.zeros((n, n)), np.eye(n)]])
        computed, expected = balanced(one, true)
        assert np.linalg.norm(computed - expected) <= half.error[i] < 1e-10
    if n == 2:
        x, errors, _ = pair_numbers(stiffness, amplitudes, period)
        assert np.all(abs(x - 2.0) <= errors)
        assert np.all(errors < 1e-4)
    whole = product(segment_maps(*as_first_order(stiffness, amplitudes), period))
    true = np.block([[np.eye(n), 2.0 * np.eye(n)], [np.zeros((n, n)), np.eye(n)]])
    scale = whole.scaling[0] / whole.scaling[0][:, None]
    assert np.linalg.norm((whole.matrix[0] - true) * scale) <= whole.error[0] < 1e-9


@pytest.mark.slow
@needs_jit
@pytest.mark.parametrize("n", [1, 2, 3, 5])
@pytest.mark.parametrize("symmetric", [True, False])
def test_small_work_is_done_without_the_compiler_to_the_same_bits(
    n: int, symmetric: bool, rng: np.random.Generator, tuned: Tuned
) -> None:
    """What a process has asked for before, on which compiling depends, changes no digit of an answer."""
    system = random_system(rng, n, 2, 0.3, 3.0, symmetric)

    def answers(compile_after: float) -> list[Floats]:
        tuned(maps_compiled_after=compile_after, often_asked_kernels=set(), interpreted_work={})
        whole = product(segment_maps(*as_first_order(*system[:2]), system[2], least_segments=2))
        pairs = pair_numbers(*system) if n == 2 else ()
        return [*half_period_map(*system)[:6], *pairs, *whole]

    for one, other in zip(answers(1e9), answers(0.0), strict=True):
        np.testing.assert_array_equal(one, other)


@needs_jit
def test_machine_code_that_loads_sooner_than_python_answers_is_taken(
    monkeypatch: pytest.MonkeyPatch, tuned: Tuned, tmp_path: Path
) -> None:
    tuned(is_series_kernel_on_disk=compilation.is_at_hand)
    maps = system_maps.segment_fill
    segment_maps(np.zeros((1, 2, 2)), np.zeros((1, 0, 2, 2)), np.ones(1))  # compiled, and kept

    def chosen(milliseconds: float) -> bool:
        tuned(often_asked_kernels=set(), interpreted_work={})
        return system_series.run_of(maps, 1000.0, lambda: milliseconds) is not maps

    assert [chosen(work) for work in (10.0, 40.0, 60.0, 900.0, 1100.0)] == [False, False, True, True, True]
    cache = compilation.compiled(maps)._cache  # type: ignore[attr-defined]
    with monkeypatch.context() as patch:  # of another version
        patch.setattr(cache, "_sources", b"other")
        assert [chosen(work) for work in (60.0, 900.0, 1100.0)] == [False, False, True]
    with monkeypatch.context() as patch:
        patch.setattr(cache, "cache_path", str(tmp_path))
        assert [chosen(work) for work in (60.0, 900.0, 1100.0)] == [False, False, True]
    with monkeypatch.context() as patch:  # no numba yet: loading it takes far longer
        patch.setattr(compilation, "_compiled", functools.cache(lambda function: None))
        assert not compilation.is_at_hand(maps)
