"""Systems of hundreds of equations: long strings whose modes an axial wave couples."""

from typing import Any

import numpy as np
import pytest
import scipy.linalg
from scipy.integrate import solve_ivp

import floquetrod as fr
from floquetrod.floquet.kernels import system_even_large, system_large
from floquetrod.floquet.kernels.system_maps_large import period_map_large
from floquetrod.floquet.multipliers import spectra
from floquetrod.floquet.registry import methods_for
from tests.inside import half_period_map
from tests.seams import Tuned


def string(
    n: int, *, axial_damping: float = 0.0, damping: float = 0.0, amplitude: float = 0.3, length: float = 600.0,
    frequency: float = 100.0,
) -> fr.HillSystem:  # fmt: skip
    """Return a coiled tubing of 2 in, its far end held, in the basis sin(m pi s / L); see the rods of the package."""
    rod = fr.Rod(
        207e9, 7850.0, 25.4e-3, length, 62e-3, inner_radius=21.44e-3, fluid_inside=1000.0, fluid_outside=1000.0,
        added_mass_coefficient=2.29,
    )  # fmt: skip
    stiffness, mass, force = rod.flexural_rigidity, rod.mass_per_length, rod.critical_force
    wave = np.sqrt(frequency**2 - 2j * frequency * axial_damping) / rod.wave_speed
    k = np.arange(1, n + 1) * np.pi / length
    q = np.arange(2 * n + 1) * np.pi / length
    # Integrals over s of cos(wave (L - s)) cos(q s), over cos(wave L).
    integrals = amplitude * force * wave * np.tan(wave * length) / (wave**2 - q**2)
    m = np.arange(1, n + 1)
    matrix = -np.outer(k, k) * (integrals[abs(m[:, None] - m)] + integrals[m[:, None] + m]) / (length * mass)
    matrix = 0.5 * (matrix + matrix.T)
    mean = (stiffness * k**4 - 0.5 * force * k**2 + rod.weight_per_length / rod.radial_clearance) / mass
    sines, cosines = ([matrix.real], [matrix.imag]) if axial_damping else ((), [matrix.real])
    period = 2.0 * np.pi / frequency
    return fr.HillSystem(
        np.diag(mean), cosines, sines, period=period, damping=2.0 * damping * np.eye(n) if damping else None
    )


def blocks(*systems: fr.HillSystem) -> fr.HillSystem:
    """Return the system of independent ones, of one period."""
    join = scipy.linalg.block_diag
    cosines, sines = ([join(*part)] for part in zip(*((s.cosines[0], s.sines[0]) for s in systems), strict=True))
    return fr.HillSystem(join(*(s.stiffness for s in systems)), cosines, sines, period=systems[0].period)


def monodromy_by_runge_kutta(system: fr.HillSystem) -> Any:
    """Return the map of (q, q') over a period, by scipy's DOP853."""
    n, w = system.order, 2.0 * np.pi / system.period
    cosine = system.cosines[0]
    sine = system.sines[0] if system.sines else np.zeros((n, n))
    friction = np.zeros((n, n)) if system.damping is None else system.damping

    def slope(t: float, x: Any) -> Any:
        q, v = x.reshape(2, n, 2 * n)
        force = system.stiffness + np.cos(w * t) * cosine + np.sin(w * t) * sine
        return np.concatenate([v, -force @ q - friction @ v]).ravel()

    run = solve_ivp(slope, (0.0, system.period), np.eye(2 * n).ravel(), method="DOP853", rtol=1e-12, atol=1e-12)
    return run.y[:, -1].reshape(2 * n, 2 * n)


def growth_of(matrix: Any, period: Any) -> float:
    return float(np.log(np.abs(np.linalg.eigvals(matrix)).max()) / period)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("damping", "amplitude", "axial_damping"),
    [
        (0.0, 0.3, 0.5),
        (0.2, 0.002, 0.5),
        *(pytest.param(*case, 0.5, marks=pytest.mark.slow) for case in ((0.05, 0.3), (0.2, 0.3))),
        *(
            pytest.param(d, a, 0.0, marks=pytest.mark.slow)
            for d, a in ((0, 0.3), (0.05, 0.3), (0.2, 0.3), (0.2, 0.002))
        ),
    ],
)
def test_long_strings_agree_with_runge_kutta(axial_damping: float, damping: float, amplitude: float) -> None:
    system = string(
        110, axial_damping=axial_damping, damping=damping, amplitude=amplitude, length=240.0, frequency=100.0
    )
    result = fr.stability(system)
    expected = growth_of(monodromy_by_runge_kutta(system), system.period)
    fastest = max(exponent.real for exponent in result.exponents)
    assert abs(fastest - expected) < 1e-7 + result.exponent_errors[0]
    assert result.status == ("unstable" if expected > 1e-6 else "stable")
    assert result.error < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("damping", [pytest.param(0.0, marks=pytest.mark.slow), 0.05])
def test_both_methods_for_many_equations_agree(damping: float) -> None:
    system = string(260, damping=damping)
    one, other = (fr.stability(system, method) for method in ("half_period", "monodromy"))
    assert one.status == other.status == "unstable"
    assert one.growth_rate == pytest.approx(other.growth_rate, abs=1e-7)
    growing = [np.sort([e.real for e in r.exponents if e.real > 1e-3]) for r in (one, other)]
    np.testing.assert_allclose(growing[0], growing[1], atol=1e-6)


def test_independent_blocks_keep_their_multipliers() -> None:
    parts = [string(60, axial_damping=0.5, length=130.0), string(70, axial_damping=0.5, amplitude=0.2, length=150.0)]
    whole = fr.stability(blocks(*parts), "monodromy")
    expected = np.concatenate([fr.stability(part, "monodromy").multipliers for part in parts])
    distances = np.abs(np.array(whole.multipliers)[:, None] - expected[None, :])
    rows, columns = scipy.optimize.linear_sum_assignment(distances)
    assert distances[rows, columns].max() < 1e-6


@pytest.mark.slow
def test_strings_that_no_wave_reaches_are_strongly_stable() -> None:
    system = string(150, axial_damping=0.5, amplitude=0.3, frequency=200.0)
    assert fr.stability(system).strongly_stable
    assert set(np.abs(fr.stability(system).krein_signs)) == {1}


@pytest.mark.slow
def test_a_map_by_products_of_numpy_is_symplectic_and_within_its_error() -> None:
    system = string(120, axial_damping=0.5, length=260.0)
    (cosine,), (sine,) = system.cosines, system.sines
    full, error, _ = period_map_large(system.stiffness, (cosine - 1j * sine)[None], system.period, 0.0, 1e-12)
    n = system.order
    unit = np.block([[np.zeros((n, n)), np.eye(n)], [-np.eye(n), np.zeros((n, n))]])
    assert np.abs(full.T @ unit @ full - unit).max() < error < 1e-8
    expected = np.sort_complex(np.linalg.eigvals(monodromy_by_runge_kutta(system)))
    np.testing.assert_allclose(np.sort(np.abs(np.linalg.eigvals(full))), np.sort(np.abs(expected)), atol=1e-7)


def test_a_full_stiffness_gives_the_multipliers_of_its_diagonal_form() -> None:
    system = string(100, axial_damping=0.5, length=220.0)
    turn = scipy.linalg.qr(np.random.default_rng(1).normal(size=(100, 100)))[0]

    def turned(matrix: Any) -> Any:
        matrix = turn @ matrix @ turn.T
        return 0.5 * (matrix + matrix.T)

    other = fr.HillSystem(
        turned(system.stiffness), [turned(system.cosines[0])], [turned(system.sines[0])], period=system.period
    )
    growth = [fr.stability(s, "monodromy").growth_rate for s in (system, other)]
    assert growth[0] == pytest.approx(growth[1], abs=1e-7)


@pytest.mark.parametrize("frequency", [15.0, 100.0])
def test_a_stopped_series_is_within_the_error_of_one_that_is_not(tuned: Tuned, frequency: float) -> None:
    form = string(110, length=240.0, frequency=frequency).even_form
    arrays = form.stiffness[None], form.amplitudes[None], np.array([2.0 * np.pi / frequency])
    stopped = half_period_map(*arrays)
    tuned(segments_worth_stopping=10**9)
    whole = half_period_map(*arrays)
    for name in "abcd":
        gap = getattr(stopped, name) - getattr(whole, name)
        assert np.linalg.norm(gap) <= stopped.error[0] + whole.error[0]


@pytest.mark.parametrize("n", [50, 240, 403])
def test_a_split_matrix_multiplies_as_the_matrix_does(n: int) -> None:
    matrix = string(max(n, 2), length=3.0 * n).cosines[0]
    size = float(np.linalg.norm(matrix, 2))
    parts = system_large.split(matrix, 1e-15 * size)
    assert isinstance(parts, np.ndarray) == (n < 200)
    x = np.random.default_rng(2).normal(size=(n, 7))
    out = np.ones((n, 7))
    system_large.add_product(parts, x, out, np.empty_like(out))
    bound = (1e-15 * system_large.LEVELS + 1e-15 * n) * size * np.linalg.norm(x)
    assert np.abs(out - 1.0 - matrix @ x).max() < bound
    system_large.add_product(system_large.times(parts, -1.0), x, out, np.empty_like(out))
    assert np.abs(out - 1.0).max() < 2.0 * bound


@pytest.mark.parametrize("symmetric", [True, False])
def test_both_ends_of_a_half_period_are_one_series_where_equations_are_few(symmetric: bool, tuned: Tuned) -> None:
    system = string(30, length=100.0)
    cosines = np.stack([system.cosines[0], 0.3 * system.cosines[0]])
    if not symmetric:
        cosines[1, 0, 5] *= 1.5
    arrays = system.stiffness[None], cosines[None], [float(system.period)]
    together = half_period_map(*arrays)
    tuned(equations_of_both_ends_at_once=0)
    apart = half_period_map(*arrays)
    assert together.symmetric == symmetric
    for name in "abcd":
        gap = getattr(together, name) - getattr(apart, name)
        assert np.linalg.norm(gap) <= apart.error[0] + together.error[0] < 1e-9


def test_a_matrix_of_full_rank_is_not_split() -> None:
    matrix = np.random.default_rng(3).normal(size=(240, 240))
    matrix = matrix + matrix.T
    assert system_large.split(matrix, 1e-15) is matrix


def test_discs_of_a_large_matrix_hold_the_eigenvalues_of_those_near_it() -> None:
    rng = np.random.default_rng(4)
    n = 260
    values = np.concatenate([np.linspace(1.0, 3.0, n - 2), [0.5, 0.5]])
    matrix = np.diag(values)
    matrix[-1, -2], matrix[-2, -1] = -0.3, 0.3  # a complex pair
    matrix = matrix + 1e-3 * rng.normal(size=(n, n))
    error = 1e-9
    discs = spectra.eigenvalue_discs(matrix, error)
    np.testing.assert_allclose(discs.left @ discs.right, np.eye(n), atol=1e-9)
    change = rng.normal(size=(n, n))
    moved = np.linalg.eigvals(matrix + error * change / np.linalg.norm(change, 2))
    for cluster in discs.clusters:
        near = np.abs(moved[None, :] - discs.values[cluster][:, None]) <= discs.radii[cluster][:, None]
        assert near.any(axis=0).sum() == len(cluster)


def test_signs_are_those_of_the_form_on_eigenvectors() -> None:
    rng = np.random.default_rng(5)
    form = np.diag(np.where(np.arange(12) % 2, 1.0, -1.0))
    symmetric = np.diag(np.arange(12.0)) + 0.01 * (lambda m: m + m.T)(rng.normal(size=(12, 12)))
    discs = spectra.eigenvalue_discs(form @ symmetric, 1e-12)
    sign = spectra.Signs(discs, form.__matmul__, 1.0, 1e-14)
    for i, vector in enumerate(discs.right.T):
        assert sign(np.array([i])) == np.sign((vector.conj() @ form @ vector).real)
    assert spectra.Signs(discs, form.__matmul__, 1.0, 1.0)(np.array([0])) == 0  # within the error of the form


@pytest.mark.slow
def test_what_would_take_minutes_is_declined_at_once() -> None:
    n = 1200
    matrix = np.diag(np.full(n - 1, 0.1), 1)
    matrix = matrix + matrix.T
    system = fr.HillSystem(np.diag(np.linspace(1.0, 1e4, n)), [matrix], [np.eye(n)], period=2.0)
    for method in (method.name for method in methods_for("systems") if method.systems.refusal is None):
        result = fr.stability(system, method)
        assert result.status == "undecided"
        assert not result.exponents
        assert result.note


def test_kernels_know_a_period_too_long() -> None:
    matrix = np.eye(2)
    full, error, _ = period_map_large(1e12 * matrix, np.zeros((0, 2, 2), dtype=complex), 1e9, 0.0, 1e-12)
    assert np.isinf(error)
    assert np.isnan(full).all()
    stiffness = np.full(2, 1e12)
    maps = system_even_large.half_period_large(stiffness, np.zeros((0, 2, 2)), 1, 1e-9, 1e-12, 5.0, True, 0.0)
    assert np.isinf(maps[2])


@pytest.mark.parametrize("n", [49, 50, 81, 199, 200])
def test_a_norm_is_never_underestimated(n: int) -> None:
    rng = np.random.default_rng(n)
    square = rng.standard_normal((n, n))
    cases = [square, 1e200 * square, square + 1j * square.T, np.linalg.qr(square)[0], np.diag(np.exp(60.0 * square[0]))]
    for matrix in [*cases, rng.standard_normal((2 * n, n)), np.zeros((n, n))]:
        exact = np.linalg.norm(matrix, 2)
        with np.errstate(over="ignore"):  # squares of the largest
            bound = spectra.spectral_norm(matrix)
        assert exact * (1.0 - 1e-12) <= bound
        assert n >= 200 or bound <= 1.5 * exact
