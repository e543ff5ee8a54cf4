"""Functions along a rod of several sections, in which its modes are written: its free vibrations without axial force.

They solve (e y'')'' = k^4 m y, e and m the rigidity and inertia of each part over those of the first, 0 <= x <= 1, and
are orthonormal with the weight m, so that inertia and damping couple none of them.  y, y', e y'' and (e y'')' are
continuous.  They are computed by the p-version of finite elements: on each element the cubics of Hermite and integrated
Legendre polynomials (Babuska, Szabo & Katz, SIAM J. Numer. Anal. 18 (1981) 515, DOI 10.1137/0718033), whose second
derivatives are orthogonal.

Motion under an axial force has jumps of (e y'')'' / m where parts meet, and values of it at the ends, that sums of the
free vibrations lack: eigenvalues converge like n^-5.  What is missing is (e w'')'' + r^4 m w = m s^q exp(-r s), s the
distance below an edge or from an end: four such functions for each edge and two for each end raise the order to n^-13
at edges and n^-9 at ends.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats
from floquetrod.equations.matrices import mirrored
from floquetrod.rod.model import beam
from floquetrod.rod.model.beam import Basis, EndConditions
from floquetrod.rod.model.data import RodData

_PHASES_AND_DEGREES = (24.0, 26), (48.0, 40)
"""Largest phase k h of the highest mode in an element, and the degree there, of few and of many modes.

Coefficients of a sine fall like those of Bessel functions, J_p(k h / 2): to 1e-7 of the highest mode.
"""

_MANY = 200  # modes from which elements are long: fewer unknowns, with more in each (a choice)
_AT_EDGES, _AT_ENDS = 4, 2  # functions added
_NARROWER = 8.0  # k of the highest mode over the rate r at which what is added falls (as in `beam`)
_MORE_POINTS = 6  # of the quadrature than the degree: products with a force that varies slowly (a choice)
_SAME = 1e-13  # of the largest, below which an added function is one of the others


class Profile(NamedTuple):
    """A rod's ends, and its parts: edges from 0 to 1, rigidity and inertia of each over those of the first."""

    ends: EndConditions
    edges: tuple[float, ...]
    rigidity: tuple[float, ...]
    inertia: tuple[float, ...]
    breaks: tuple[float, ...]  # places besides at which elements end, since integrands jump there

    @classmethod
    def of(cls, rod: RodData) -> Profile:
        """Return the profile of a rod."""
        parts = [part.rod for part in rod.uniform_parts]
        rigidity, inertia = ([getattr(p, name) for p in parts] for name in ("flexural_rigidity", "mass_per_length"))
        return cls(
            rod.end_conditions,
            rod.edges,
            tuple(each / rigidity[0] for each in rigidity),
            tuple(each / inertia[0] for each in inertia),
            rod.course.breaks,
        )

    @property
    def slowness(self) -> Floats:
        """(m / e)^(1/4) of each part: its wavenumber over that of the first."""
        return np.asarray(np.divide(self.inertia, self.rigidity) ** 0.25)

    def wavenumber(self, count: int) -> float:
        """Return about the wavenumber in the first part of a mode of so many half waves, for a length of 1."""
        return (count + 1) * math.pi / float(np.diff(self.edges) @ self.slowness)


@dataclass(frozen=True, eq=False)
class SectionBasis(Basis):
    """Functions along a rod of several sections; ``transform`` has their coefficients in those of the elements."""

    elements: Elements | None = field(default=None, kw_only=True)

    @property
    def _is_of_many_waves(self) -> bool:
        return False

    def shapes(self, x: Floats) -> Floats:
        """Return the functions at points, (n, len(x))."""
        assert self.elements is not None  # noqa: S101
        return self.elements.values_at(self.transform, x)


@dataclass(frozen=True, eq=False)
class Elements:
    """Elements between the nodes of a ``grid``, each with the degree ``degree``, and the part in which each lies.

    The unknowns are value and slope at the first node, the bubbles of the first element, value and slope at the second
    node, and so on.  Slopes are times half the length j of an element, and bubbles have unit bending energy.
    """

    grid: Floats
    part: NDArray[np.intp]
    degree: int

    @classmethod
    def of(cls, profile: Profile, count: int) -> Elements:
        """Return elements fine enough for so many modes."""
        phase, degree = _PHASES_AND_DEGREES[count >= _MANY]
        k, cuts = profile.wavenumber(count), np.union1d(profile.edges, profile.breaks)
        part = np.searchsorted(profile.edges[1:-1], 0.5 * (cuts[:-1] + cuts[1:]))
        number = np.maximum(1, np.ceil(k * profile.slowness[part] * np.diff(cuts) / phase)).astype(int)
        spans = zip(cuts[:-1], cuts[1:], number, strict=True)
        grid = np.concatenate([*(np.linspace(a, b, n, endpoint=False) for a, b, n in spans), [1.0]])
        return cls(grid, np.repeat(part, number), degree)

    @property
    def half(self) -> Floats:
        """Half the length of each."""
        return np.asarray(0.5 * np.diff(self.grid))

    @property
    def stride(self) -> int:
        """Unknowns from one element to the next."""
        return self.degree - 1

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return self.stride * self.part.size + 2

    def unknowns(self, i: int) -> NDArray[np.intp]:
        """Return the numbers of the unknowns of element i: those of its nodes, then its bubbles."""
        first = i * self.stride
        return np.concatenate(
            [first + np.array([0, 1, self.stride, self.stride + 1]), np.arange(2, self.stride) + first]
        )

    def scales(self, i: int) -> Floats:
        """Return the factors of the reference functions in element i."""
        scale, j = np.ones(self.degree + 1), float(self.half[i])
        scale[[1, 3]], scale[4:] = j, j**1.5
        return scale

    def fixed(self, ends: EndConditions) -> list[int]:
        """Return the unknowns that are zero where the ends are held."""
        last, zero = self.stride * self.part.size, []
        for node, end in ((0, ends.upper), (last, ends.lower)):
            zero += [node] * (end in ("hinged", "clamped")) + [node + 1] * (end in ("clamped", "guided"))
        return zero

    def quadrature(self) -> tuple[Floats, Floats, Floats]:
        """Return the points of the reference element, and nodes and weights of each element, (elements, points)."""
        points, weights = np.polynomial.legendre.leggauss(self.degree + _MORE_POINTS)
        half = self.half[:, None]
        return points, self.grid[:-1, None] + half * (points + 1.0), half * weights

    def tabulated(self, rows: Floats, table: Floats, derivative: int) -> Floats:
        """Return functions at all nodes of the quadrature, (n, q), from their coefficients (n, size) and a table."""
        parts = []
        for i, j in enumerate(self.half.tolist()):
            parts.append((rows[:, self.unknowns(i)] * (self.scales(i) * j**-derivative)) @ table)
        return np.concatenate(parts, axis=1)

    def values_at(self, rows: Floats, x: Floats) -> Floats:
        """Return functions at points between 0 and 1, (n, len(x))."""
        element = np.clip(np.searchsorted(self.grid, x, side="right") - 1, 0, self.part.size - 1)
        values = np.empty((len(rows), len(x)))
        for i in np.unique(element).tolist():
            at = np.flatnonzero(element == i)
            values_there = _reference((x[at] - self.grid[i]) / self.half[i] - 1.0, self.degree)[0]
            values[:, at] = (rows[:, self.unknowns(i)] * self.scales(i)) @ values_there
        return values


def _reference(x: Floats, degree: int) -> tuple[Floats, Floats, Floats]:
    """Return values and two derivatives of Hermite's cubics and of the bubbles on -1 <= x <= 1, (degree + 1, len(x)).

    Bubbles are the second integrals of sqrt((2 j + 1) / 2) P_j, j >= 2: values and slopes vanish at both ends.
    """
    one = np.ones_like(x)
    cubics = 0.25 * np.array([2 - 3 * x + x**3, 1 - x - x**2 + x**3, 2 + 3 * x - x**3, -1 - x + x**2 + x**3])
    slopes = 0.25 * np.array([-3 + 3 * x**2, -1 - 2 * x + 3 * x**2, 3 - 3 * x**2, -1 + 2 * x + 3 * x**2])
    curvatures = 0.25 * np.array([6 * x, -2 * one + 6 * x, -6 * x, 2 * one + 6 * x])
    p, j = np.polynomial.legendre.legvander(x, degree + 1).T, np.arange(2, degree - 1)
    size, width = np.sqrt((2 * j + 1) / 2)[:, None], (2 * j + 1)[:, None]
    integral = (p[j + 1] - p[j - 1]) / width
    twice = ((p[j + 2] - p[j]) / (width + 2) - (p[j] - p[j - 2]) / (width - 2)) / width
    return (
        np.concatenate([cubics, size * twice]),
        np.concatenate([slopes, size * integral]),
        np.concatenate([curvatures, size * p[j]]),
    )


@functools.lru_cache(maxsize=8)
def section_basis(profile: Profile, count: int) -> SectionBasis:
    """Return the first ``count`` free vibrations of a rod of several sections, rigid motions included, and more."""
    elements = Elements.of(profile, count)
    points, nodes, weights = elements.quadrature()
    tables = _reference(points, elements.degree)
    rigidity, inertia = (np.array(each)[elements.part] for each in (profile.rigidity, profile.inertia))
    mass, bending = _matrices(elements, rigidity, inertia)
    free = np.setdiff1d(np.arange(elements.size), elements.fixed(profile.ends))
    mass, bending = (matrix[np.ix_(free, free)] for matrix in (mass, bending))
    rows = np.zeros((count, elements.size))
    rows[:, free] = _lowest(mass, bending, count)
    k = profile.wavenumber(count)
    driving = _added(profile, elements, nodes, k / _NARROWER)
    driven = np.zeros((len(driving), elements.size))
    integrals = _integrals(elements, driving * weights * inertia[:, None], tables[0])[:, free]
    driven[:, free] = np.linalg.solve(bending + (k / _NARROWER) ** 4 * mass, integrals.T).T
    heavy = (weights * inertia[:, None]).ravel()
    rows = _orthonormal(elements, rows, driven, tables[0], heavy)
    values, slopes, curved = (elements.tabulated(rows, table, d) for d, table in enumerate(tables))
    stiff = (weights * rigidity[:, None]).ravel()
    given = values, slopes
    energy = mirrored((curved * stiff) @ curved.T)
    for part in (rows, energy, values, slopes):
        part.flags.writeable = False
    return SectionBasis(profile.ends, count, energy, nodes.ravel(), weights.ravel(), rows, given, elements=elements)


def _matrices(elements: Elements, rigidity: Floats, inertia: Floats) -> tuple[Floats, Floats]:
    """Return the matrices of inertia and of bending, whose products are exact."""
    points, weights = np.polynomial.legendre.leggauss(elements.degree + 1)
    value, _, curvature = _reference(points, elements.degree)
    of_inertia, of_bending = (value * weights) @ value.T, (curvature * weights) @ curvature.T
    mass, bending = np.zeros((elements.size, elements.size)), np.zeros((elements.size, elements.size))
    for i, j in enumerate(elements.half.tolist()):
        scale, block = elements.scales(i), np.ix_(elements.unknowns(i), elements.unknowns(i))
        products = scale * scale[:, None]
        mass[block] += inertia[i] * j * products * of_inertia
        bending[block] += rigidity[i] / j**3 * products * of_bending
    return mass, bending


def _lowest(mass: Floats, bending: Floats, count: int) -> Floats:
    """Return the eigenvectors of the lowest frequencies, (count, unknowns)."""
    from scipy.linalg import solve_triangular

    root = np.linalg.cholesky(mass)
    half = solve_triangular(root, bending, lower=True)
    _, vectors = np.linalg.eigh(mirrored(solve_triangular(root, half.T, lower=True)))
    return np.asarray(solve_triangular(root, vectors[:, :count], lower=True, trans="T").T)


def _added(profile: Profile, elements: Elements, nodes: Floats, rate: float) -> Floats:
    """Return s^q exp(-s) below each edge and next to both ends at the nodes, s = ``rate`` times the distance."""
    rows, slow = [], profile.slowness
    distances = [((nodes - edge) * slow[i + 1], _AT_EDGES) for i, edge in enumerate(profile.edges[1:-1])]
    distances += [(nodes * slow[0], _AT_ENDS), ((1.0 - nodes) * slow[-1], _AT_ENDS)]
    for distance, number in distances:
        s = rate * np.maximum(distance, 0.0)
        rows += [np.where(distance > 0.0, s**q * np.exp(-s), 0.0) for q in range(number)]
    return np.array(rows)


def _integrals(elements: Elements, weighted: Floats, table: Floats) -> Floats:
    """Return the integrals of weighted values (n, elements, points) with the functions of the elements, (n, size)."""
    integrals = np.zeros((len(weighted), elements.size))
    for i in range(elements.part.size):
        integrals[:, elements.unknowns(i)] += weighted[:, i] @ (table * elements.scales(i)[:, None]).T
    return integrals


def _orthonormal(elements: Elements, modes: Floats, added: Floats, table: Floats, heavy: Floats) -> Floats:
    """Return modes, and added functions orthogonal to them and each other, of unit norm with the weight ``heavy``."""

    def product(a: Floats, b: Floats) -> Floats:
        return (elements.tabulated(a, table, 0) * heavy) @ elements.tabulated(b, table, 0).T

    for _ in range(2):
        modes = modes / np.sqrt(np.diagonal(product(modes, modes)))[:, None]
        added = added / np.sqrt(np.diagonal(product(added, added)))[:, None]
        added = added - product(added, modes) @ modes
        sizes, directions = np.linalg.eigh(product(added, added))
        kept = sizes > _SAME * sizes[-1]
        added = (directions[:, kept] / np.sqrt(sizes[kept])).T @ added
    return np.concatenate([modes, added])


def are_enriched(rod: RodData) -> bool:
    """Return whether further functions are added to the modes of a rod."""
    return rod.varies or beam.are_enriched(rod.end_conditions)


def functions_along(rod: RodData, count: int) -> Basis:
    """Return the functions in which the coupled modes of a rod are written, ``count`` modes and a few others."""
    if rod.varies:
        return section_basis(Profile.of(rod), count)
    return beam.basis(rod.end_conditions, count, rod.course.breaks)
