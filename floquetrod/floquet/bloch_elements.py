"""Bloch waves -M y'' + V(t) y = E M y, y(t + T) = exp(i phase) y(t), in finite elements of high degree.

Elements end at the jumps of V, so that y is smooth on each and errors fall exponentially with the degree.  Energies are
the least values of y's energy among the functions of all elements (Ritz): upper bounds, except for rounding, whose
errors are the squares of the errors of y.

The functions on an element are two linear ones and integrals of Legendre's polynomials, N_j = (P_j - P_(j-2)) /
sqrt(4 j - 2), j >= 2, whose derivatives are orthonormal (B. Szabo and I. Babuska, Finite Element Analysis, 1991).
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod._util.content import ByContent
from floquetrod.equations import HillSystem
from floquetrod.equations.matrices import mass_matrix
from floquetrod.equations.pieces import in_time

_PHASE = 5.0  # rad by which the shortest wave turns in an element (a choice: about 12 functions reach rounding then)
_MOST_ROWS = 1500  # of the matrices (a choice: seconds a phase)


class BlochWaves(NamedTuple):
    """Energies (k,) of one phase, ascending, and their derivatives by the phase, (k,)."""

    energies: Floats
    velocities: Floats


class Grid(NamedTuple):
    """The ends of elements, their length and, of each, the piece of the coefficient that it lies in."""

    begins: Floats  # (m,), from the beginning of the piece
    lengths: Floats  # (m,)
    pieces: list[int]


@dataclass(frozen=True, eq=False)
class BlochElements(ByContent):
    """The matrices of one system in elements of one degree, before the ends of the period are joined.

    ``energy`` is the matrix of y's energy less ``lowest`` times ``mass``, so that both are positive definite.
    """

    energy: Floats  # (rows + n, rows + n), the last n at the end of the period
    mass: Floats
    lowest: float
    order: int

    @classmethod
    def of(cls, system: HillSystem, grid: Grid, degree: int) -> BlochElements:
        """Return the matrices of a HillSystem whose -K is V."""
        n, period, pieces = system.order, float(system.period), in_time(system)
        mass = mass_matrix(system)
        waves = max(len(piece.harmonics) for piece in pieces)
        widest = float(grid.lengths.max()) / period
        shapes = _shapes(degree, degree + 12 + math.ceil(4.0 * waves * widest))
        values = [-pieces[j].at(b + 0.5 * h * (1.0 + shapes.nodes), period) for b, h, j in zip(*grid, strict=True)]
        lowest = min(least_potential(potential, mass) for potential in values) - (math.pi / period) ** 2
        count = len(grid.pieces)
        rows = (count * degree + 1) * n
        components = np.arange(n)
        energy, gram = np.zeros((2, count * degree + 1, n, count * degree + 1, n))
        for e, (potential, h) in enumerate(zip(values, grid.lengths.tolist(), strict=True)):
            ends = [e * degree, (e + 1) * degree]
            places = np.array([*ends, *range(e * degree + 1, (e + 1) * degree)])
            weights = 0.5 * h * shapes.weights
            block = np.einsum(
                "q,iq,jq,qab->iajb",
                weights,
                shapes.functions,
                shapes.functions,
                potential - lowest * mass,
                optimize=True,
            )
            block += (2.0 / h) * np.einsum("ij,ab->iajb", shapes.stiffness, mass)
            energy[np.ix_(places, components, places, components)] += block
            overlap = (shapes.functions * weights) @ shapes.functions.T
            gram[np.ix_(places, components, places, components)] += np.einsum("ij,ab->iajb", overlap, mass)
        return cls(energy.reshape(rows, rows), gram.reshape(rows, rows), lowest, n)

    def waves(self, phase: float, count: int) -> BlochWaves:
        """Return the lowest ``count`` energies of a phase, fewer where there are not as many."""
        from scipy.linalg import eigh

        turn: Any = complex(math.cos(phase), math.sin(phase))
        if phase in (0.0, math.pi):
            turn = math.cos(phase)
        joined, gram = self._joined(self.energy, turn), self._joined(self.mass, turn)
        size = len(joined)
        most = min(count + 2, size)
        # The largest 1 / (E - lowest) first, which are the most accurate.
        vectors = eigh(gram, joined, subset_by_index=[size - most, size - 1], check_finite=False)[1][:, ::-1]
        # Once more among these few functions, where rounding is that of the energies wanted, not of the largest.
        small, overlap = (vectors.conj().T @ matrix @ vectors for matrix in (joined, gram))
        excess, mixed = eigh(small, overlap, check_finite=False)
        ends = vectors @ mixed
        last = turn * ends[: self.order]
        # dE = 2 Re (P' u)^H (A - E B) P u: only the last values of P u change with the phase, by i times themselves.
        n, whole = self.order, np.concatenate([ends, last])
        rest = self.energy[-n:] @ whole - (self.mass[-n:] @ whole) * excess
        velocities = 2.0 * np.real(np.sum((1j * last).conj() * rest, axis=0))
        return BlochWaves(self.lowest + excess[:count], velocities[:count])

    def _joined(self, matrix: Floats, turn: Any) -> Any:
        """Return a matrix for functions whose last values are their first times a factor."""
        n = self.order
        joined = matrix[:-n, :-n].astype(type(turn))
        joined[:n, :n] += matrix[-n:, -n:]
        joined[:, :n] += turn * matrix[:-n, -n:]
        joined[:n] += np.conj(turn) * matrix[-n:, :-n]
        return joined


def grid_of(system: HillSystem, highest: float, finer: int = 1) -> Grid:
    """Return elements in which waves of energies up to ``highest`` turn by a few rad, ``finer`` times as many."""
    period = float(system.period)
    low, high = potential_range(system)
    rate = math.sqrt(max(highest - low, high - low, 0.0)) + 2.0 * math.pi / period
    begins: list[float] = []
    lengths: list[float] = []
    places: list[int] = []
    for j, piece in enumerate(in_time(system)):
        length = float(piece.length)
        fastest = max(rate, len(piece.harmonics) * 2.0 * math.pi / period)
        count = finer * math.ceil(length * fastest / _PHASE)
        if len(begins) + count > _MOST_ROWS:
            raise _too_many(len(begins) + count)
        begins += [length * k / count for k in range(count)]
        lengths += [length / count] * count
        places += [j] * count
    return Grid(np.array(begins), np.array(lengths), places)


def require_rows(grid: Grid, degree: int, order: int) -> None:
    """Raise ValueError where matrices would be too large."""
    rows = len(grid.pieces) * degree * order
    if rows > _MOST_ROWS:
        raise _too_many(rows)


def _too_many(rows: int) -> ValueError:
    return ValueError(
        f"below must be lower, or the potential flatter: its waves need matrices of {rows:,} rows and more, "
        f"at most {_MOST_ROWS:,} are taken"
    )


def least_potential(potential: Floats, mass: Floats) -> float:
    """Return the least eigenvalue of V beside M, of V (k, n, n) at several times."""
    return float(_eigenvalues(potential, mass).min())


def potential_range(system: HillSystem) -> tuple[float, float]:
    """Return about the lowest and the highest eigenvalue of V beside M over a period."""
    period, mass, values = float(system.period), mass_matrix(system), []
    for piece in in_time(system):
        into = float(piece.length) * np.linspace(0.0, 1.0, 33 + 8 * len(piece.harmonics))
        values.append(_eigenvalues(-piece.at(into, period), mass))
    return min(float(v.min()) for v in values), max(float(v.max()) for v in values)


def _eigenvalues(potential: Floats, mass: Floats) -> Floats:
    root = np.linalg.inv(np.linalg.cholesky(mass))
    return np.asarray(np.linalg.eigvalsh(root @ potential @ root.T))


class _Shapes(NamedTuple):
    """Functions of an element at Gauss's nodes on (-1, 1), the two linear ones first."""

    nodes: Floats
    weights: Floats
    functions: Floats  # (degree + 1, nodes)
    stiffness: Floats  # (degree + 1, degree + 1), integrals of products of derivatives


@functools.lru_cache(maxsize=32)
def _shapes(degree: int, count: int) -> _Shapes:
    """Return the functions of a degree at ``count`` nodes."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    legendre = np.polynomial.legendre.legvander(nodes, degree).T
    j = np.arange(2, degree + 1)
    bubbles = (legendre[2:] - legendre[:-2]) / np.sqrt(4.0 * j - 2.0)[:, None]
    functions = np.concatenate([[0.5 * (1.0 - nodes), 0.5 * (1.0 + nodes)], bubbles])
    stiffness = np.eye(degree + 1)
    stiffness[:2, :2] = [[0.5, -0.5], [-0.5, 0.5]]
    return _Shapes(nodes, weights, functions, stiffness)


def all_waves(elements: BlochElements, phases: Floats, count: int) -> tuple[Floats, Floats]:
    """Return energies and velocities (phases, count), NaN where there are fewer."""
    energies, velocities = np.full((2, len(phases), count), np.nan)
    for i, phase in enumerate(phases.tolist()):
        waves = elements.waves(phase, count)
        energies[i, : len(waves.energies)], velocities[i, : len(waves.energies)] = waves
    return energies, velocities
