"""Functions along a rod of several sections, in which its modes are written: its free vibrations without axial force.

They solve (e y'')'' = k^4 m y, e and m the rigidity and inertia of each part relative to the first, 0 <= x <= 1, and
are orthonormal with the weight m, so that inertia and damping couple none of them.  y, y', e y'' and (e y'')' are
continuous.  They are computed by the p-version of finite elements: on each element the cubics of Hermite and integrated
Legendre polynomials (Babuska, Szabo & Katz, SIAM J. Numer. Anal. 18 (1981) 515, DOI 10.1137/0718033), whose second
derivatives are orthogonal.

Motion under an axial force has jumps of (e y'')'' / m where parts meet, and values of it at the ends, that sums of the
free vibrations lack: eigenvalues converge like n^-5.  What is missing is (e w'')'' + r^4 m w = m s^q exp(-r s), s the
distance below an edge or from an end: two such functions for each edge raise the order to n^-9.  The next two would
raise it to n^-13, and the highest frequency by a half.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats
from floquetrod._util.content import ByContent
from floquetrod.equations.matrices import mirrored
from floquetrod.rod.model import beam
from floquetrod.rod.model.beam import Basis, EndConditions
from floquetrod.rod.model.data import RodData

_PHASES_AND_DEGREES = (24.0, 20), (48.0, 32), (124.0, 64)
"""Largest phase k h of the highest mode in an element, and the degree there; those with the fewest unknowns are taken.

Coefficients of a sine fall like Bessel functions J_p(k h / 2), and errors of frequencies like their squares: to 1e-11
at 0.7 of the highest wavenumber.  Above it functions need not be vibrations, but complete the others.
"""

_AT_EDGES = 2  # functions added at each edge
_AT_ENDS = {"hinged": 1, "guided": 1, "clamped": 2, "free": 2}
"""Functions added at an end; of a free one besides a force across: an axial force F bends it by (e y'')' = -F y'."""

_NARROWER = 8.0  # k of the highest mode over the rate r at which what is added falls (as in `beam`)
_MORE_POINTS = 6  # of the quadrature than the degree: products with a force that varies slowly (a choice)
_SAME = 1e-10  # square of what is left of a function beside others, up to which it is one of them
_STIFFEST = 8.0  # wavenumber of an added function over that of the highest mode at most: a force at a point has 4
_OWN = 1e-3  # square of what is left of a further mode beside added functions, at least
_SHORTEST = 3e-5  # of the length; of shorter parts elements take the mean compliance (rounding of bending is near)


Product: TypeAlias = Callable[[Floats, Floats], Floats]
"""Of functions (n, unknowns) and others (m, unknowns), (n, m)."""


class Profile(NamedTuple):
    """A rod's ends, and its parts: edges from 0 to 1, rigidity and inertia of each relative to the first."""

    ends: EndConditions
    edges: tuple[float, ...]
    rigidity: tuple[float, ...]
    inertia: tuple[float, ...]
    breaks: tuple[float, ...]  # places besides at which elements end, since integrands jump there

    @classmethod
    def of(cls, rod: RodData) -> Profile:
        """Return the profile of a rod; a part that is too short is joined to the next one."""
        parts = [part.rod for part in rod.uniform_parts]
        rigidity, inertia = ([getattr(p, name) for p in parts] for name in ("flexural_rigidity", "mass_per_length"))
        compliance, mass = (np.divide(1.0, np.divide(rigidity, rigidity[0])), np.divide(inertia, inertia[0]))
        edges = _coarse(rod.edges)
        widths, shares = np.diff(edges), _overlaps(rod.edges, edges)
        return cls(
            rod.end_conditions,
            edges,
            tuple((widths / (shares @ compliance)).tolist()),
            tuple((shares @ mass / widths).tolist()),
            rod.course.breaks,
        )

    @property
    def cuts(self) -> Floats:
        """Places from 0 to 1 at which elements end in any case; breaks next to others are left to the quadrature."""
        cuts = list(self.edges)
        for place in self.breaks:
            if min(abs(place - cut) for cut in cuts) >= _SHORTEST:
                cuts.append(place)
        return np.sort(cuts)

    @property
    def slowness(self) -> Floats:
        """(m / e)^(1/4) of each part, its wavenumber relative to the first."""
        return np.asarray(np.divide(self.inertia, self.rigidity) ** 0.25)

    @property
    def free_ends(self) -> list[int]:
        """The places, 0 and 1, of free ends."""
        return [place for place, end in enumerate((self.ends.upper, self.ends.lower)) if end == "free"]

    @property
    def added(self) -> int:
        """Number of functions added to the free vibrations."""
        at_ends = _AT_ENDS[self.ends.upper] + _AT_ENDS[self.ends.lower] + len(self.free_ends)
        return _AT_EDGES * (len(self.edges) - 2) + at_ends

    def wavenumber(self, count: int) -> float:
        """Return about the wavenumber in the first part of a mode of so many half waves, for a length of 1."""
        return (count + 1) * math.pi / float(np.diff(self.edges) @ self.slowness)


def _coarse(edges: tuple[float, ...]) -> tuple[float, ...]:
    """Return edges from 0 to 1, `_SHORTEST` apart at least, from the upper end down."""
    kept = [0.0]
    for start, end in itertools.pairwise(edges):
        if start > kept[-1] and end - start >= _SHORTEST:  # what is too short lies before a part that is not
            kept.append(max(start, kept[-1] + _SHORTEST))
        if end - kept[-1] >= _SHORTEST:
            kept.append(end)
    if 1.0 - kept[-1] < _SHORTEST and len(kept) > 1:
        del kept[-1]
    return (*(each for each in kept if each < 1.0), 1.0)


def _overlaps(edges: tuple[float, ...], coarse: tuple[float, ...]) -> Floats:
    """Return how much of each of the coarse parts lies in each part, (coarse parts, parts)."""
    low, high = np.array(edges[:-1]), np.array(edges[1:])
    begin, end = np.array(coarse[:-1])[:, None], np.array(coarse[1:])[:, None]
    return np.asarray(np.maximum(0.0, np.minimum(high, end) - np.maximum(low, begin)))


@dataclass(frozen=True, eq=False)
class SectionBasis(Basis):
    """Functions along a rod of several sections, the added ones first: of fewer modes they are the first of these.

    ``transform`` has their coefficients in the functions of the elements.
    """

    elements: Elements = field(kw_only=True)

    @property
    def _is_of_many_waves(self) -> bool:
        return False

    @property
    def points_per_panel(self) -> int:
        """Number of nodes in each panel of the quadrature, an element."""
        return len(self.nodes) // self.elements.part.size

    def shapes(self, x: Floats) -> Floats:
        """Return the functions at points, (n, len(x))."""
        return self.elements.values_at(self.transform, x)


@dataclass(frozen=True, eq=False)
class Elements(ByContent):
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
        cuts = profile.cuts
        part = np.searchsorted(profile.edges[1:-1], 0.5 * (cuts[:-1] + cuts[1:]))
        phases = profile.wavenumber(count) * profile.slowness[part] * np.diff(cuts)
        choices = [
            (np.maximum(1, np.ceil(phases / phase)).astype(int), degree) for phase, degree in _PHASES_AND_DEGREES
        ]
        number, degree = min(choices, key=lambda choice: int(choice[0].sum()) * (choice[1] - 1))
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
        """Return the numbers of the unknowns of element i, at its nodes, then its bubbles."""
        first = i * self.stride
        return np.concatenate(
            [first + np.array([0, 1, self.stride, self.stride + 1]), np.arange(2, self.stride) + first]
        )

    def scales(self, i: int) -> Floats:
        """Return the factors of the reference functions in element i."""
        scale, j = np.ones(self.degree + 1), float(self.half[i])
        scale[[1, 3]], scale[4:] = j, j**1.5
        return scale

    def end(self, place: int) -> int:
        """Return the unknown that is the value at an end: 0 the upper, 1 the lower."""
        return place * self.stride * self.part.size

    def fixed(self, ends: EndConditions) -> list[int]:
        """Return the unknowns held at zero by the ends."""
        zero: list[int] = []
        for node, end in ((self.end(0), ends.upper), (self.end(1), ends.lower)):
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
    rate = profile.wavenumber(count) / _NARROWER
    driving = _added(profile, elements, nodes, rate) * weights * inertia[:, None]
    integrals = _integrals(elements, driving, tables[0])
    integrals = np.concatenate([integrals, np.eye(elements.size)[[elements.end(i) for i in profile.free_ends]]])
    modes, driven = np.zeros((count + 2 * len(integrals), elements.size)), np.zeros(integrals.shape)
    modes[:, free], driven[:, free] = _vibrations(mass, bending, rate**4, len(modes), integrals[:, free])
    heavy = (weights * inertia[:, None]).ravel()
    stiff = (weights * rigidity[:, None]).ravel()

    def size(a: Floats) -> Floats:
        return np.asarray(np.sqrt(elements.tabulated(a, tables[0], 0) ** 2 @ heavy)[:, None])

    def inner(a: Floats, b: Floats) -> Floats:
        return np.asarray((elements.tabulated(a, tables[0], 0) * heavy) @ elements.tabulated(b, tables[0], 0).T)

    def bent(a: Floats, b: Floats) -> Floats:
        return np.asarray((elements.tabulated(a, tables[2], 2) * stiff) @ elements.tabulated(b, tables[2], 2).T)

    rows = _orthonormal(driven, modes, count, size, inner, bent)
    values, slopes, bends = (elements.tabulated(rows, tables[d], d) for d in range(3))
    given, energy = (values, slopes, bends), mirrored((bends * stiff) @ bends.T)
    for part in (rows, energy, *given):
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


def _vibrations(mass: Floats, bending: Floats, shift: float, count: int, forces: Floats) -> tuple[Floats, Floats]:
    """Return the free vibrations of lowest frequencies, (count, unknowns), and what forces make with a shift.

    By the eigenvalues 1 / (k^4 + shift), which are all of one size: the frequencies of short elements are far higher,
    and would hide the lowest in rounding.
    """
    from scipy.linalg import solve_triangular

    root = np.linalg.cholesky(bending + shift * mass)
    half = solve_triangular(root, mass, lower=True)
    _, vectors = np.linalg.eigh(mirrored(solve_triangular(root, half.T, lower=True)))
    lowest = solve_triangular(root, vectors[:, : -count - 1 : -1], lower=True, trans="T").T
    moved = solve_triangular(root, solve_triangular(root, forces.T, lower=True), lower=True, trans="T").T
    return np.asarray(lowest), np.asarray(moved)


def _added(profile: Profile, elements: Elements, nodes: Floats, rate: float) -> Floats:
    """Return s^q exp(-s) below each edge and next to both ends at the nodes, s = ``rate`` times the distance."""
    rows, slow = [], profile.slowness
    distances = [((nodes - edge) * slow[i], _AT_EDGES) for i, edge in enumerate(profile.edges[1:-1], start=1)]
    distances.append((nodes * slow[0], _AT_ENDS[profile.ends.upper]))
    distances.append(((1.0 - nodes) * slow[-1], _AT_ENDS[profile.ends.lower]))
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


def _orthonormal(
    rows: Floats, modes: Floats, count: int, size: Callable[[Floats], Floats], inner: Product, bent: Product
) -> Floats:
    """Return functions added to the first ``count`` modes, orthogonal to them and each other, then those modes.

    ``size`` is their norm with the inertia, ``inner`` and ``bent`` the products of inertia and of
    bending.  Near combinations of others, and functions that bend far more than the modes, give way to further modes.
    """
    for _ in range(2):
        modes, rows = modes / size(modes), rows / size(rows)
        rows = rows - inner(rows, modes[:count]) @ modes[:count]
    rows = rows / size(rows)
    sizes, directions = np.linalg.eigh(inner(rows, rows))
    apart = sizes > _SAME
    functions = (directions[:, apart] / np.sqrt(sizes[apart])).T @ rows
    energies, directions = np.linalg.eigh(bent(functions, functions))
    highest = float(bent(modes[count - 1 : count], modes[count - 1 : count])[0, 0])
    functions = directions[:, energies < _STIFFEST**4 * highest].T @ functions
    for mode in modes[count:, None]:
        if len(functions) == len(rows):
            break
        beside = mode
        for _ in range(2):
            beside = beside - inner(beside, functions) @ functions
        left = size(beside)
        if left[0, 0] ** 2 > _OWN:
            functions = np.concatenate([functions, beside / left])
    for _ in range(2):  # rounding of combinations that nearly cancel
        functions = functions - inner(functions, modes[:count]) @ modes[:count]
        functions = np.linalg.solve(np.linalg.cholesky(inner(functions, functions)), functions)
    return np.concatenate([functions, modes[:count]])


def are_enriched(rod: RodData) -> bool:
    """Return whether further functions are added to the modes of a rod."""
    return rod.varies or beam.are_enriched(rod.end_conditions)


def are_nested(rod: RodData) -> bool:
    """Return whether the functions of fewer modes are the first among those for more modes."""
    return rod.varies or not beam.are_enriched(rod.end_conditions)


def number_of_functions(rod: RodData, count: int) -> int:
    """Return how many functions `functions_along` has for so many modes."""
    if rod.varies:
        return count + Profile.of(rod).added
    return functions_along(rod, count).size if are_enriched(rod) else count


def functions_along(rod: RodData, count: int) -> Basis:
    """Return the functions in which the coupled modes of a rod are written, ``count`` modes and a few others."""
    if rod.varies:
        return section_basis(Profile.of(rod), count)
    return beam.basis(rod.end_conditions, count, rod.course.breaks)
