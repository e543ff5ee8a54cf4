"""Growth of a rod by finite differences along it and a symplectic integrator in time; shares no code with the package.

    m_t theta_tt + 2 c m_t theta_t + EI theta_ssss + (F(s, t) theta_s)_s + b theta = 0,   b = w_e sin(inclination) / R

The energies are sums over a uniform grid: curvatures at nodes, slopes and forces halfway between, half a cell at each
end.  Held ends follow from reflection, free ones by themselves.  All of it is of second order with errors in even
powers of the step, so the matrices of the lowest natural shapes of four grids extrapolate to eighth order, once
the shapes of each grid are turned to match those of the finest.  Multipliers are those of the product over a period of
commutator-free exponentials of fourth order (Blanes & Moan 2006).
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

Array = np.ndarray
GRIDS = (1, 2, 3, 4)
"""Steps of the coarsest grid over those of each."""

_ROUNDING = 1e-12  # of a period map, relative


class Line(NamedTuple):
    """What a rod is per length: EI in N m^2, m_t in kg/m, w_e in N/m."""

    rigidity: float
    inertia: float
    weight: float


def line(
    youngs_modulus: float,
    density: float,
    outer: float,
    inner: float = 0.0,
    fluid_inside: float = 0.0,
    fluid_outside: float = 0.0,
    added_mass: float = math.pi**2 / 3.0 - 1.0,
    gravity: float = 9.81,
) -> Line:
    """Return what a tube of these radii is per length, all in SI units."""
    whole, bore = math.pi * outer * outer, math.pi * inner * inner
    filled = density * (whole - bore) + fluid_inside * bore
    rigidity = youngs_modulus * math.pi * (outer**4 - inner**4) / 4.0
    return Line(rigidity, filled + added_mass * fluid_outside * whole, gravity * (filled - fluid_outside * whole))


class Model(NamedTuple):
    """The equation, in SI units: F(s, t) = mean(s) + Re sum_k waves[k-1](s) exp(i k frequency t)."""

    rigidity: float
    inertia: float
    bed: float
    length: float
    ends: tuple[str, str]
    mean: Callable[[Array], Array]
    waves: Sequence[Callable[[Array], Array]] = ()
    frequency: float = 1.0
    damping: float = 0.0


class Growth(NamedTuple):
    """Growth rate of the fastest solution in 1/s, negative where all decay, and an estimate of its error."""

    rate: float
    error: float


# --- forces ---


def even(force: complex) -> Callable[[Array], Array]:
    """Return a force that is the same all along."""
    return lambda s: np.full(np.shape(s), force)


def leaning(mean: float, slope: float, at: float) -> Callable[[Array], Array]:
    """Return a force of a given mean at ``at`` that grows by ``slope`` = w_e cos(inclination) per length."""
    return lambda s: mean + slope * (s - at)


def wave(
    force: complex, frequency: float, length: float, speed: float, damping: float = 0.0, far_end: str = "held"
) -> Callable[[Array], Array]:
    """Return the complex force of u_tt + 2 c_a u_t = c_0^2 u_ss under ``force`` exp(i frequency t) at s = 0.

    The end s = L does not move (held), bears no force (free) or is driven alike.
    """
    k = cmath.sqrt(frequency * (frequency - 2j * damping)) / speed
    # Two running waves, a exp(-i k s) + b exp(i k s); numpy solves for a and b.
    go = cmath.exp(-1j * k * length)
    far = {"held": ([go, -1.0 / go], 0.0), "free": ([go, 1.0 / go], 0.0), "driven": ([go, 1.0 / go], force)}
    row, value = far[far_end]
    a, b = np.linalg.solve(np.array([[1.0, 1.0], row]), np.array([force, value]))
    return lambda s: a * np.exp(-1j * k * s) + b * np.exp(1j * k * s)


# --- along the rod ---


class _Grid(NamedTuple):
    """A rod on a uniform grid, in coordinates of unit mass: nodes that move, the roots of their masses, and factors.

    Curvatures are ``bend`` times the coordinates and slopes ``turn`` times them, both weighted for energies; ``forces``
    are halfway between nodes, the mean and then a cosine and a sine for each wave.
    """

    node: Array
    root: Array
    bed: float
    bend: Array
    turn: Array
    forces: Array

    def mean_stiffness(self) -> Array:
        """Return the matrix of the mean stiffness."""
        pushed = (self.turn.T * self.forces[0]) @ self.turn
        return self.bend.T @ self.bend + self.bed * np.eye(len(self.node)) - pushed

    def in_shapes(self, basis: Array) -> Array:
        """Return the stacked stiffness matrices in orthonormal shapes, accurate where those are smooth."""
        bent, turned = self.bend @ basis, self.turn @ basis
        found = -np.swapaxes(turned[None] * self.forces[..., None], 1, 2) @ turned
        found[0] += bent.T @ bent + self.bed * (basis.T @ basis)
        return found


def _grid(model: Model, cells: int) -> _Grid:
    """Return a rod on a grid."""
    h = model.length / cells
    node, half = np.arange(cells + 1) * h, (np.arange(cells) + 0.5) * h
    share = np.full(cells + 1, h)
    share[[0, -1]] *= 0.5
    curvature = np.zeros((cells + 1, cells + 1))
    inner = np.arange(1, cells)
    curvature[inner, inner] = -2.0
    curvature[inner, inner - 1] = curvature[inner, inner + 1] = 1.0
    for end, kind in zip((0, cells), model.ends, strict=True):
        if kind in ("clamped", "guided"):  # reflected at the end, where the slope is zero
            curvature[end, end], curvature[end, abs(end - 1)] = -2.0, 2.0
    slope = np.eye(cells + 1)[1:] - np.eye(cells + 1)[:-1]
    moves = np.ones(cells + 1, dtype=bool)
    moves[[0, -1]] = [kind in ("guided", "free") for kind in model.ends]
    root = np.sqrt(model.inertia * share[moves])
    forces = [np.real(model.mean(half))]
    for profile in model.waves:
        force = np.asarray(profile(half), dtype=complex)
        forces += [force.real, -force.imag]
    bend = np.sqrt(model.rigidity * share)[:, None] * curvature[:, moves] / (h * h * root)
    turn = slope[:, moves] / (math.sqrt(h) * root)
    return _Grid(node[moves], root, model.bed / model.inertia, bend, turn, np.array(forces))


def _extrapolated(model: Model, cells: int, shapes: int) -> tuple[Array, Array]:
    """Return the stiffness matrices in the lowest natural shapes, extrapolated from three grids and from four."""
    found, samples = [], []
    for times in GRIDS:
        grid = _grid(model, times * cells)
        stiffness = grid.mean_stiffness()
        basis = _lowest(stiffness, shapes)
        basis = np.hstack([basis, _bent_statically(model, grid, stiffness, basis)])
        basis = basis @ np.linalg.eigh(grid.in_shapes(basis)[0])[1]
        found.append(grid.in_shapes(basis))
        common = np.rint(grid.node * times * cells / model.length).astype(int) % times == 0
        # Values of the shapes at the nodes that all grids share, weighted as the coarsest grid weights them.
        samples.append(basis[common] * math.sqrt(times))
    groups = _close(found[-1][0].diagonal(), model.bed / model.inertia)
    aligned = []
    for matrices, sample in zip(found, samples, strict=True):
        turn = np.zeros_like(matrices[0])
        for group in groups:  # shapes of nearly equal stiffness may be mixed differently on each grid
            left, _, right = np.linalg.svd(sample[:, group].T @ samples[-1][:, group])
            turn[group, group] = left @ right
        aligned.append(turn.T @ matrices @ turn)

    return _limit(aligned[1:]), _limit(aligned)


def _limit(values: Sequence[Array]) -> Array:
    """Return the value at step zero of the polynomial in its square through the finest grids."""
    squares = [1.0 / times**2 for times in GRIDS[-len(values) :]]
    weights = [math.prod(b / (b - a) for b in squares if b != a) for a in squares]
    return np.tensordot(weights, values, axes=1)


def _close(values: Array, scale: float) -> list[slice]:
    """Return runs of increasing values of which neighbours differ by less than a twentieth."""
    gaps = np.diff(values) > 0.05 * np.maximum(np.abs(values[1:]), scale + abs(values[0]))
    edges = [0, *(np.flatnonzero(gaps) + 1).tolist(), len(values)]
    return [slice(low, high) for low, high in pairwise(edges)]


def _lowest(stiffness: Array, count: int) -> Array:
    """Return the shapes of least stiffness."""
    from scipy.linalg import eigh

    return np.asarray(eigh(stiffness, subset_by_index=(0, min(count, len(stiffness)) - 1))[1])


def _bent_statically(model: Model, grid: _Grid, stiffness: Array, basis: Array) -> Array:
    """Return what static shapes under smooth loads and under forces at free ends add to the natural ones.

    A series of natural shapes converges slowly where the force that varies does not vanish at an end.
    """
    node, root = grid.node, grid.root
    loads = [root * (2.0 * node / model.length - 1.0) ** power for power in range(4)]
    loads += [
        np.eye(len(node))[end] / root[end] for end, kind in zip((0, -1), model.ends, strict=True) if kind == "free"
    ]
    # Under some loads a rod free to shift or to turn stays straight, which is a natural shape.
    shifts = all(kind in ("guided", "free") for kind in model.ends)
    turns = "free" in model.ends and all(kind in ("hinged", "free") for kind in model.ends)
    lift = model.bed / model.inertia + 2.0 * max(0.0, -float((basis[:, 0] @ stiffness) @ basis[:, 0]))
    bent = np.linalg.solve(stiffness + lift * np.eye(len(node)), np.array(loads).T)
    bent /= np.linalg.norm(bent, axis=0)
    bent -= basis @ (basis.T @ bent)
    bent = np.linalg.svd(bent, full_matrices=False)[0][:, : len(loads) - shifts - turns]
    return np.linalg.qr(bent - basis @ (basis.T @ bent))[0]


def least_stiffness(model: Model, count: int = 1, cells: int = 20) -> Array:
    """Return the least eigenvalues of the mean stiffness over the inertia, in 1/s^2, increasing."""
    found = []
    for times in GRIDS:
        grid = _grid(model, times * cells)
        stiffness = grid.in_shapes(_lowest(grid.mean_stiffness(), count + 6))[0]
        found.append(np.linalg.eigvalsh(stiffness)[:count])
    return _limit(found)


# --- in time ---


def _map(model: Model, matrices: Array, steps: int) -> Array:
    """Return the map over a period of u = exp(c t) theta."""
    count = matrices.shape[-1]
    period = 2.0 * math.pi / model.frequency
    step = period / steps
    offset = math.sqrt(3.0) / 6.0
    weights = np.array([[0.5 + 2.0 * offset, 0.5 - 2.0 * offset], [0.5 - 2.0 * offset, 0.5 + 2.0 * offset]])
    result = np.eye(2 * count)
    still = matrices[0] - model.damping**2 * np.eye(count)
    for part in np.array_split(np.arange(steps), max(1, steps // 64)):
        times = (part[:, None] + 0.5 + np.array([-offset, offset])) * step
        at = np.zeros((*times.shape, count, count))
        for k in range(1, (len(matrices) - 1) // 2 + 1):
            phase = (k * model.frequency * times)[..., None, None]
            at += np.cos(phase) * matrices[2 * k - 1] + np.sin(phase) * matrices[2 * k]
        for factor in _exponentials(still + np.einsum("ab,sbij->saij", weights, at), 0.5 * step):
            for one in factor:
                result = one @ result
    return result


def _exponentials(stiffness: Array, time: float) -> Array:
    """Return the maps over ``time`` of u'' + K u = 0, of many K."""
    values, vectors = np.linalg.eigh(stiffness)
    root = np.emath.sqrt(values + 0j)
    c = np.cos(root * time).real
    s = np.where(np.abs(root) * time > 1e-8, np.sin(root * time) / np.where(root == 0.0, 1.0, root), time).real
    turned = np.swapaxes(vectors, -1, -2)
    blocks = [[(vectors * f[..., None, :]) @ turned for f in row] for row in ((c, s), (-values * s, c))]
    return np.block(blocks)


def _rate(model: Model, matrices: Array, steps: int) -> tuple[float, float]:
    """Return the growth rate of a period map, and what rounding may do to it."""
    period = 2.0 * math.pi / model.frequency
    found = _map(model, matrices, steps)
    rate = math.log(float(np.abs(np.linalg.eigvals(found)).max())) / period
    # Two multipliers that meet are as uncertain as the root of the rounding of their map.
    rounding = _ROUNDING / max(rate * period, math.sqrt(_ROUNDING)) / period
    return rate - model.damping, rounding


def growth(model: Model, shapes: int | None = None, cells: int | None = None, steps: int | None = None) -> Growth:
    """Return the growth rate of the fastest solution and an estimate of its error.

    ``shapes`` natural shapes are kept, ``cells`` is the coarsest grid, ``steps`` divide the period.  The error adds up
    what a grid less, three quarters of the shapes and half the steps would change, and rounding.
    """
    shapes = enough_shapes(model) if shapes is None else shapes
    cells = 3 * shapes if cells is None else cells
    coarse, fine = _extrapolated(model, cells, shapes)
    _, fewer = _extrapolated(model, cells, math.ceil(0.75 * shapes))
    if steps is None:
        highest = math.sqrt(max(0.0, float(np.linalg.eigvalsh(fine[0])[-1])))
        steps = max(48 * max(1, len(model.waves)), math.ceil(0.7 * highest * 2.0 * math.pi / model.frequency))
    best, rounding = _rate(model, fine, 2 * steps)
    halved, *others = (_rate(model, matrices, steps)[0] for matrices in (fine, coarse, fewer))
    grows = min(best, halved) > rounding - model.damping
    rate = best + (best - halved) / 15.0 if grows else best
    return Growth(rate, 0.2 * abs(best - halved) + sum(abs(other - halved) for other in others) + rounding)


def enough_shapes(model: Model) -> int:
    """Return how many natural shapes are kept: twice those that the largest push or four times its frequency reach."""
    s = np.linspace(0.0, model.length, 1001)
    push = np.max(np.real(model.mean(s)) + sum(np.abs(profile(s)) for profile in model.waves))
    by_push = math.sqrt(max(0.0, float(push)) / model.rigidity)
    fastest = 4.0 * model.frequency * max(1, len(model.waves))
    by_frequency = (model.inertia * max(0.0, fastest**2 - model.bed / model.inertia) / model.rigidity) ** 0.25
    return 10 + math.ceil(2.0 * max(by_push, 0.6 * by_frequency) * model.length / math.pi)
