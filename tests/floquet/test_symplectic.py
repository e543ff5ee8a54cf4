"""The numbers of the pairs of symplectic maps and their Krein signs, against eigenvalues of the maps themselves."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.linalg import block_diag, expm

from floquetrod.floquet.multipliers import precise_spectra, spectra, symplectic


def flow(energy: Any, time: float) -> Any:
    """Return the map of z' = J H z after a time."""
    return expm(time * symplectic.symplectic_unit(len(energy) // 2) @ energy)


def drawn(n: int, seed: int, size: float) -> Any:
    """Return a symplectic map of no structure."""
    rng, found = np.random.default_rng(seed), np.eye(2 * n)
    for _ in range(3):
        energy = rng.standard_normal((2 * n, 2 * n))
        found = flow(energy + energy.T, size / np.sqrt(n)) @ found
    return found


def oscillators(squares: Any, signs: Any, time: float = 1.0) -> Any:
    """Return the map of independent oscillators, some of which have negative energy."""
    squares, signs = np.asarray(squares, float), np.asarray(signs, float)
    return flow(np.diag(np.concatenate([signs * squares, signs])), time)


def turned(full: Any, seed: int) -> Any:
    """Return a map in other canonical coordinates, which mix positions and momenta."""
    n = len(full) // 2
    other = np.linalg.qr(np.random.default_rng(seed).standard_normal((n, n)) + 1j * np.eye(n))[0]
    change = np.block([[other.real, -other.imag], [other.imag, other.real]])
    return change.T @ full @ change


def numbers(full: Any) -> Any:
    """Return y of each multiplier."""
    mu = np.linalg.eigvals(full)
    return 0.25 * (mu + 1.0 / mu - 2.0)


@pytest.mark.parametrize("n", [1, 2, 3, 8, 40])
@pytest.mark.parametrize("size", [0.1, 0.5, 1.5])
def test_each_pair_has_its_number_once(n: int, size: float) -> None:
    for seed in range(3):
        full = drawn(n, seed, size)
        found = symplectic.pair_matrix(full, 0.0)
        expected, scale = numbers(full), np.linalg.norm(full)
        y = np.linalg.eigvals(found.matrix)
        # Each is there twice among those of the map.
        distances = np.abs(expected[:, None] - y[None, :])
        nearest = distances.argmin(axis=1)
        assert distances.min(axis=1).max() < 1e-9 * scale**2
        assert np.array_equal(np.sort(nearest), np.repeat(np.arange(n), 2))


def test_the_basis_is_orthonormal_isotropic_and_invariant() -> None:
    cases = [
        drawn(20, 3, 1.0),
        oscillators([1.0, 4.0, 9.0], [1, 1, 1]),
        np.eye(6),
        turned(oscillators([2.0] * 5, [1] * 5), 1),
    ]
    for full in cases:
        n = len(full) // 2
        found, unit = symplectic.pair_matrix(full, 0.0), symplectic.symplectic_unit(n)
        w = 0.25 * (full + np.linalg.inv(full)) - 0.5 * np.eye(2 * n)
        size = np.linalg.norm(full)
        assert np.abs(found.basis.T @ found.basis - np.eye(n)).max() < 1e-14 * n
        assert np.abs(found.basis.T @ unit @ found.basis).max() < 1e-14 * n
        assert np.abs(w @ found.basis - found.basis @ found.matrix).max() < 1e-13 * size**2


def test_independent_pairs_stay_apart() -> None:
    """Those that grow by many decades cost the others no digit."""
    full = oscillators([1.0, 2.0, -900.0], [1, 1, 1])
    found = symplectic.pair_matrix(full, 0.0).matrix
    expected = -(np.sin(0.5 * np.sqrt([1.0, 2.0])) ** 2)
    assert np.abs(np.diagonal(found)[:2] / expected - 1.0).max() < 1e-14
    assert np.array_equal(found[:2, 2], [0.0, 0.0])


def expected_signs(full: Any) -> dict[float, int]:
    """Return the Krein sign of the multipliers on the upper half of the circle, from eigenvectors of the map, by y."""
    mu, vectors = np.linalg.eig(full)
    on = np.flatnonzero((np.abs(np.abs(mu) - 1.0) < 1e-9) & (mu.imag > 1e-6))
    values = np.einsum("ij,ij->j", vectors.conj(), symplectic.krein_form(vectors)).real
    return {float((0.25 * (mu[i] + 1.0 / mu[i] - 2.0)).real): int(np.sign(values[i])) for i in on}


@pytest.mark.parametrize("seed", range(6))
def test_krein_signs_are_those_of_eigenvectors_of_the_map(seed: int) -> None:
    rng = np.random.default_rng(seed)
    squares, signs = np.linspace(0.5, 7.0, 9) + rng.uniform(0.0, 0.3, 9), rng.choice([-1, 1], 9)
    energy = rng.standard_normal((12, 14))
    cases = [
        turned(oscillators(squares, signs), seed),
        flow(energy @ energy.T, 0.1) @ flow(energy[:, :1] @ energy[:, :1].T, 0.1),
    ]
    for full in cases:
        found = symplectic.pair_matrix(full, 1e-13)
        discs = spectra.eigenvalue_discs(found.matrix, found.error, found.eigen)
        krein, known = symplectic.krein_signs(found, discs), expected_signs(full)
        seen = 0
        for i, y in enumerate(discs.values):
            near = [sign for at, sign in known.items() if abs(at - y) < 1e-8]
            if len(near) == 1:
                assert krein(np.array([i])) == near[0]
                seen += 1
        assert seen == len(known) == len(full) // 2


def pairs_that_meet(signs: tuple[int, int], seed: int) -> Any:
    """Return the map of four oscillators, of which two have the same multipliers, in mixed coordinates."""
    return turned(oscillators([2.0, 2.0, 5.0, 7.0], [*signs, 1, -1]), seed)


@pytest.mark.slow
@pytest.mark.parametrize(("signs", "expected"), [((1, 1), 1), ((-1, -1), -1), ((1, -1), 0), ((-1, 1), 0)])
def test_signs_of_pairs_that_meet(signs: tuple[int, int], expected: int) -> None:
    for seed in range(4):
        full = pairs_that_meet(signs, seed)
        found = symplectic.pair_matrix(full, 1e-12)
        discs = spectra.eigenvalue_discs(found.matrix, found.error, found.eigen)
        (cluster,) = [each for each in discs.clusters if len(each) == 2]
        assert symplectic.krein_signs(found, discs)(cluster) == expected

        context = mpmath.mp.clone()
        context.prec = 60
        entries = np.array([[context.mpf(float(v)) for v in row] for row in full], dtype=object)
        precise = symplectic.pair_matrix(entries, 1e-12, 2.0**-60)
        pairs = precise_spectra.eigenvalue_discs(precise.matrix, precise.error, context)
        (cluster,) = [each for each in pairs.clusters if len(each) == 2]
        assert precise_spectra.krein_sign(precise, pairs, cluster) == expected


def test_the_error_covers_the_true_numbers() -> None:
    """A map perturbed among symplectic ones has its numbers within the discs of the unperturbed one."""
    for seed in range(20):
        rng = np.random.default_rng(seed)
        full = block_diag(drawn(2, seed, 0.7)) if seed % 2 else turned(oscillators([2.0, 2.0, 3.0], [1, 1, 1]), seed)
        n = len(full) // 2
        energy = rng.standard_normal((2 * n, 2 * n))
        other = flow(energy + energy.T, 1e-9) @ full
        found = symplectic.pair_matrix(full, float(np.linalg.norm(other - full, 2)))
        discs = spectra.eigenvalue_discs(found.matrix, found.error, found.eigen)
        assert discs is not None
        true = numbers(other)
        for cluster in discs.clusters:
            near = np.abs(true[None, :] - discs.values[cluster][:, None]) <= discs.radii[cluster][:, None]
            assert near.any(axis=0).sum() == 2 * len(cluster)


@pytest.mark.slow
def test_the_error_of_a_precise_subspace_covers_how_far_it_turns(rng: np.random.Generator) -> None:
    context = mpmath.MPContext()
    context.prec = 200
    for _ in range(20):
        n, error = 5, 1e-12
        apart = 10.0 ** rng.uniform(-4.0, -1.0)  # of two eigenvalues far from zero
        values = np.array([2.0, 2.0 + apart, -1.0, 0.5, 3.0])
        vectors = np.eye(n) + 0.4 * rng.standard_normal((n, n))
        matrix = vectors @ np.diag(values) @ np.linalg.inv(vectors)
        change = rng.standard_normal((n, n))
        change *= 1e-8 / np.linalg.norm(change)
        discs = precise_spectra.eigenvalue_discs(np.array(matrix.tolist(), dtype=object), error, context)
        assert discs is not None
        member = int(np.argmin([abs(complex(value) - 2.0) for value in discs.values]))
        bound = precise_spectra._subspace_error(discs, np.array([member])) / discs.error
        # For each unit of a small change the vector of 2 turns by at most the bound, which is not far too large.
        w, v = np.linalg.eig(matrix + change)
        one, other = vectors[:, 0] / np.linalg.norm(vectors[:, 0]), v[:, np.abs(w - 2.0).argmin()]
        turned = np.linalg.norm(other - one * (one @ other)) / 1e-8
        assert turned <= bound * 1.01
        assert bound <= 20.0 * np.linalg.cond(vectors) ** 2 / apart
    assert precise_spectra._subspace_error(discs, np.arange(n)) == 0.0
