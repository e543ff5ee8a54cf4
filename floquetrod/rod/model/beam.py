"""Beam functions: the free vibrations of a beam without axial force, for all ends, as a basis on 0 <= x <= 1.

phi'''' = k^4 phi with two conditions at each end: phi is a sine and a cosine, with an exponential that decays from
each end.  Where an end is clamped or free, solutions under an axial force have derivatives there that no beam function
has, and eigenvalues converge only like n^-5 or n^-3.  A few polynomials that fulfil the essential conditions mend that,
or, beside many beam functions, a few functions next to the ends, as wide as some waves of the last one.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import Complexes, Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent
from floquetrod._util.roots import roots
from floquetrod._util.suggest import did_you_mean
from floquetrod.equations.matrices import mirrored

_ASYMPTOTIC = 40.0  # wavenumber from which the ends no longer feel each other: e^-40 is below rounding
_POLYNOMIALS_UP_TO = 64  # functions; what polynomials add to more of them is lost in rounding (measured)
_POLYNOMIALS = 4  # added (a choice: more would raise the highest frequency further, for little)
_SAME = 1e-7  # length of what is left of a polynomial beside the beam functions below which it adds nothing
_NARROW, _NARROWEST = 45.0, 8.0  # decay rate of functions next to an end at least, and k of the last over it (measured)
_POINTS = 24  # of Gauss-Legendre quadrature in a panel, exact to rounding for 6 half waves of a product
_PER_PANEL = 12.0  # largest wavenumber times length of a panel
_ROUNDING = 2.2e-16  # of F and of its product with a weight, summed over the nodes, over the integral of |F|
_LARGE = 200  # functions beyond which only one basis is kept (a choice)
_MANY_WAVES = 48  # sines or cosines from which integrals by Fourier's transform take less time (measured)

_DERIVATIVES = {"hinged": (0, 2), "clamped": (0, 1), "guided": (1, 3), "free": (2, 3)}
"""Derivatives that vanish at an end."""

_PHASES = {"hinged": 0.0, "clamped": 0.25 * math.pi, "free": 0.25 * math.pi, "guided": -0.5 * math.pi}
"""What an end adds to m pi in the wavenumbers of high modes."""

_ESSENTIAL = {"hinged": (0,), "clamped": (0, 1), "guided": (1,), "free": ()}
"""Derivatives up to the first that vanish at an end: what every function of a Ritz basis must fulfil."""

_MISSING = {"hinged": (4,), "clamped": (4, 5), "guided": (5,), "free": (3, 4)}
"""Powers of the distance from an end that motion under a force begins with, and sums of beam functions lack."""


CONDITIONS = ("hinged", "clamped", "guided", "free")
"""What an end of a rod may be."""


@dataclass(frozen=True)
class EndConditions:
    """How the two ends are held across the channel; the axial force acts through both, along the channel.

    Parameters
    ----------
    upper : {"hinged", "clamped", "guided", "free"}
        At s = 0, the upper end of an inclined rod.  Hinged: no displacement, no moment.  Clamped: no displacement, no
        rotation.  Guided: no rotation, no force across.  Free: no moment, no force across.
    lower : {"hinged", "clamped", "guided", "free"}
        At s = L.
    """

    upper: str = "hinged"
    lower: str = "hinged"

    @classmethod
    def of(cls, word: Any) -> EndConditions:
        """Return the ends that a word names: "clamped" for both, or "clamped-hinged", the upper end first."""
        conditions = word.lower().replace(" ", "").split("-") if isinstance(word, str) else []
        unknown = [condition for condition in conditions if condition not in CONDITIONS]
        if unknown or not 1 <= len(conditions) <= 2:
            meant = did_you_mean(unknown[0], CONDITIONS) if unknown else ""
            raise validate.wrong_value(
                "ends",
                f"must be one of {', '.join(CONDITIONS)}, or two of them joined by a hyphen, the upper end first, "
                f'such as "clamped-hinged"; got {validate.short(word)}{meant}',
            )
        return cls(conditions[0], conditions[-1])

    @property
    def are_hinged(self) -> bool:
        """Whether both are hinged, so that the modes of a rod under a uniform force are independent sines."""
        return self.upper == self.lower == "hinged"

    def __str__(self) -> str:
        """Return the word for them."""
        return self.upper if self.upper == self.lower else f"{self.upper}-{self.lower}"


@dataclass(frozen=True, eq=False)
class Basis(ByContent):
    """Orthonormal functions on 0 <= x <= 1 with their derivatives at the nodes of a quadrature."""

    ends: EndConditions
    count: int  # beam functions, which come first, rigid motions before all; any others are added, see above
    bending: Floats  # (n, n), integrals of phi_i'' phi_j''
    nodes: Floats  # (q,), of the quadrature, as the weights
    weights: Floats
    transform: Floats  # from plain beam functions and those added to these
    given: tuple[Floats, Floats, Floats] | None = None  # (n, q), phi, phi', phi'' at the nodes; of waves when needed

    @property
    def size(self) -> int:
        """Number of functions."""
        return len(self.bending)

    @cached_property
    def values(self) -> Floats:
        """Phi at the nodes, (n, q)."""
        return self.given[0] if self.given else self._waves(0)

    @cached_property
    def slopes(self) -> Floats:
        """Phi' at the nodes, (n, q)."""
        return self.given[1] if self.given else self._waves(1)

    @property
    def points_per_panel(self) -> int:
        """Number of nodes in each panel of the quadrature."""
        return _POINTS

    @property
    def bends(self) -> Floats:
        """Phi'' at the nodes, (n, q)."""
        return self.given[2] if self.given else self._waves(2)

    def _waves(self, derivative: int) -> Floats:
        """Return sines or cosines at the nodes, or a derivative of them."""
        waves = wavenumbers(self.ends, self.count)
        values = np.diagonal(self.transform)[:, None] * _trigonometric(self.ends, waves, self.nodes, derivative)
        values.flags.writeable = False
        return values

    def coupling(self, force: Floats) -> Floats:
        """Return the integrals of F phi_i' phi_j', symmetric bit for bit; force (..., q) at the nodes."""
        return self._products(force, derivative=True)

    @cached_property
    def softening(self) -> Floats:
        """The integrals of phi_i' phi_j', symmetric bit for bit."""
        return self.coupling(np.ones_like(self.nodes))

    def pressing(self, density: Floats) -> Floats:
        """Return the integrals of d phi_i phi_j, symmetric bit for bit; density (..., q) at the nodes."""
        return self._products(density, derivative=False)

    def _products(self, factor: Floats, *, derivative: bool) -> Floats:
        """Return the integrals of the products of functions, or of their slopes, with one another and a factor."""
        if not factor.any():
            return np.zeros((*factor.shape[:-1], self.size, self.size))
        weighted = factor * self.weights
        if self._is_of_many_waves:
            return self._products_of_waves(weighted, derivative=derivative)
        functions = self.slopes if derivative else self.values
        return mirrored((functions * weighted[..., None, :]) @ functions.T)

    @property
    def _is_of_many_waves(self) -> bool:
        """Whether these are many sines or cosines."""
        return _are_trigonometric(self.ends) and self.count >= _MANY_WAVES

    def _products_of_waves(self, weighted: Floats, *, derivative: bool) -> Floats:
        """Return `_products` from the integrals of the factor times cos(m pi x), far faster than by matrices."""
        moments = self._moments(weighted)
        size = np.abs(weighted).sum(axis=-1, keepdims=True)
        moments[np.abs(moments) < _ROUNDING * size] = 0.0  # what is uniform couples nothing, and matrices stay sparse
        waves = wavenumbers(self.ends, self.count)
        apart, both = self._places
        sign = 1.0 if (self.ends.upper == "hinged") == derivative else -1.0
        sizes = 0.5 * np.diagonal(self.transform) * (waves if derivative else 1.0)
        integrals = moments.take(apart, axis=-1) + sign * moments.take(both, axis=-1)
        return np.asarray(integrals * (sizes[:, None] * (2.0 * sizes)))

    @cached_property
    def _places(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Of the product of each two waves, the m of its two cosines."""
        waves = wavenumbers(self.ends, self.count) / math.pi
        apart = np.rint(np.abs(np.subtract.outer(waves, waves))).astype(int)
        return apart, np.rint(np.add.outer(waves, waves)).astype(int)

    def _moments(self, weighted: Floats) -> Floats:
        """Return the sums of values (..., q) at the nodes times cos(m pi x), m up to twice the number of functions.

        Points of the same place in each of P panels of equal length add up to a discrete Fourier transform of 2 P
        numbers.
        """
        panels, cosines, sines = self._turns
        if not panels:
            return np.asarray(weighted @ cosines)
        each = np.swapaxes(weighted.reshape(*weighted.shape[:-1], panels, _POINTS), -1, -2)
        turned = np.fft.fft(each, 2 * panels)[..., np.arange(2 * self.count + 1) % (2 * panels)]
        return np.asarray((turned.real * cosines + turned.imag * sines).sum(axis=-2))

    @cached_property
    def _turns(self) -> tuple[int, Floats, Floats]:
        """Number of panels of equal length, cosines and sines of m pi x in the first; or 0, and those at all nodes."""
        panels = len(self.nodes) // _POINTS
        are_equal = np.array_equal(self.nodes, _quadrature(panels, ())[0])
        if not are_equal:
            return 0, _turned(self.nodes, 2 * self.count).real.copy(), np.empty(0)
        angles = math.pi * self.nodes[:_POINTS, None] * np.arange(2 * self.count + 1)
        return panels, np.cos(angles), np.sin(angles)

    def shapes(self, x: Floats) -> Floats:
        """Return the functions at points, (n, len(x))."""
        return np.asarray(self.transform @ _all_functions(self.ends, self.count, x)[0])


def basis(ends: EndConditions, count: int, breaks: tuple[float, ...] = ()) -> Basis:
    """Return the first ``count`` beam functions, rigid motions included, and others where they help.

    Panels of the quadrature end at ``breaks`` between 0 and 1, where integrands may jump.  The last 16 bases are kept;
    of bases with more than 200 functions, up to a hundred megabytes each, only the last.
    """
    return (_large_basis if count > _LARGE else _small_basis)(ends, count, breaks)


@functools.cache
def _gauss() -> tuple[Floats, Floats]:
    """Return nodes and weights of a panel from -1 to 1."""
    points, weights = np.polynomial.legendre.leggauss(_POINTS)
    points.flags.writeable = weights.flags.writeable = False
    return points, weights


def _quadrature(panels: int, breaks: tuple[float, ...]) -> tuple[Floats, Floats]:
    """Return nodes and weights on panels of equal length, cut at breaks."""
    points, weights = _gauss()
    edges, share = np.arange(panels) / panels, np.full(panels, float(panels))
    if breaks:
        edges = np.unique(np.concatenate([edges, breaks]))
        share = 1.0 / np.diff(np.append(edges, 1.0))
    nodes = (edges[:, None] + 0.5 * (points + 1.0) / share[:, None]).ravel()
    return nodes, (0.5 * weights / share[:, None]).ravel()


def _basis(ends: EndConditions, count: int, breaks: tuple[float, ...] = ()) -> Basis:
    """Return what `basis` does, computed."""
    waves = wavenumbers(ends, count)
    panels = math.ceil(float(waves[-1]) / _PER_PANEL) + 1
    nodes, weights = _quadrature(panels, breaks)
    if _are_trigonometric(ends):
        bending, transform = np.diag(waves**4), np.diag(np.where(waves > 0.0, math.sqrt(2.0), 1.0))
        for part in (nodes, weights, bending, transform):
            part.flags.writeable = False
        return Basis(ends, count, bending, nodes, weights, transform)
    values, slopes, curvatures = _all_functions(ends, count, nodes)
    root = np.sqrt(weights)
    transform = _orthogonal(values * root, count)
    kept = len(transform)
    sizes = np.diagonal(transform)[:count, None]
    parts = [np.concatenate([sizes * part[:count], transform[count:] @ part]) for part in (values, slopes, curvatures)]
    for i in range(count, kept):
        # Combinations that nearly cancel have lost digits: they are made orthonormal at the nodes, where they are used.
        weighted = weights * parts[0][i]
        beside = parts[0][:i] @ weighted
        size = math.sqrt(float(weighted @ parts[0][i]) - float(beside @ beside))
        for part in (transform, *parts):
            part[i] = (part[i] - beside @ part[:i]) / size
    values, slopes, curved = parts[0], parts[1], parts[2] * root
    bending = np.zeros((kept, kept))
    bending[count:] = curved[count:] @ curved.T
    bending[:count, count:] = bending[count:, :count].T
    bending = mirrored(bending)
    bending[np.arange(count), np.arange(count)] = waves**4
    curvatures = parts[2]
    for part in (nodes, weights, bending, values, slopes, curvatures, transform):
        part.flags.writeable = False
    return Basis(ends, count, bending, nodes, weights, transform, (values, slopes, curvatures))


_small_basis = functools.lru_cache(maxsize=16)(_basis)
_large_basis = functools.lru_cache(maxsize=1)(_basis)


def _orthogonal(rows: Floats, count: int) -> Floats:
    """Return coefficients of nearly orthonormal combinations of rows; the first ``count`` rows must be orthogonal."""
    orthonormal = np.zeros((len(rows), len(rows)))
    np.fill_diagonal(orthonormal[:count, :count], 1.0 / np.linalg.norm(rows[:count], axis=1))
    kept = count
    for i in range(count, len(rows)):
        unit = np.zeros(len(rows))
        unit[i] = 1.0 / np.linalg.norm(rows[i])
        for _ in range(2):
            unit -= (orthonormal[:kept] @ (rows @ (unit @ rows))) @ orthonormal[:kept]
        left = float(np.linalg.norm(unit @ rows))
        if left > _SAME:
            orthonormal[kept] = unit / left
            kept += 1
    return orthonormal[:kept]


def wavenumbers(ends: EndConditions, count: int) -> Floats:
    """Return k of the first ``count`` beam functions, for a length of 1; 0 for rigid motions."""
    near = np.arange(count + 3) * math.pi + (_PHASES[ends.upper] + _PHASES[ends.lower])
    near = near[near > 0.3]
    if not _are_trigonometric(ends):
        near = np.concatenate([_roots(ends, near[near < _ASYMPTOTIC]), near[near >= _ASYMPTOTIC]])
    return np.concatenate([np.zeros(_rigid(ends)), near])[:count]


def _roots(ends: EndConditions, near: NDArray[Any]) -> Floats:
    """Return the wavenumbers within 0.6 of the asymptotic values ``near``; the lowest values may have none."""

    def determinant(k: Floats, _: Any = None) -> Floats:
        return np.asarray(np.linalg.det(_conditions(ends, k)))

    low, high = np.maximum(near - 0.6, 0.2), near + 0.6
    at_low, at_high = determinant(low), determinant(high)
    bracketed = at_low * at_high <= 0.0
    return roots(determinant, low[bracketed], high[bracketed], at_low[bracketed], at_high[bracketed])


def _are_trigonometric(ends: EndConditions) -> bool:
    """Return whether the beam functions are sines and cosines alone."""
    return {ends.upper, ends.lower} <= {"hinged", "guided"}


def _rigid(ends: EndConditions) -> int:
    """Return how many rigid motions the ends allow: a shift, a rotation about a hinge, or both."""
    pair = {ends.upper, ends.lower}
    if pair == {"free"}:
        return 2
    return int(pair in ({"free", "hinged"}, {"free", "guided"}, {"guided"}))


def _conditions(ends: EndConditions, k: Floats) -> Floats:
    """Return the four end conditions on (sin kx, cos kx, e^-kx, e^-k(1-x)), (len(k), 4, 4), scaled by powers of k."""
    rows = []
    for at, end in ((0.0, ends.upper), (1.0, ends.lower)):
        derivatives = _functions(k, at)
        rows += [derivatives[d] for d in _DERIVATIVES[end]]
    return np.moveaxis(np.array(rows), -1, 0)


def _functions(k: Floats, x: float | Floats) -> list[Floats]:
    """Return (sin kx, cos kx, e^-kx, e^-k(1-x)) and derivatives over k to the third, each (4, ...)."""
    sine, cosine = np.sin(k * x), np.cos(k * x)
    first, last = np.exp(-k * x), np.exp(-k * (1.0 - x))
    return [
        np.array([sine, cosine, first, last]),
        np.array([cosine, -sine, -first, last]),
        np.array([-sine, -cosine, first, last]),
        np.array([-cosine, sine, -first, last]),
    ]


def _all_functions(ends: EndConditions, count: int, x: Floats) -> tuple[Floats, Floats, Floats]:
    """Return values, slopes and second derivatives of beam functions and those added, (n, len(x)) each."""
    waves = wavenumbers(ends, count)
    rigid = min(_rigid(ends), count)
    beams = _beam_functions(ends, waves[rigid:], x)
    rows = [np.concatenate([_rigid_motions(ends, x)[d][:rigid], beams[d]]) for d in range(3)]
    if not are_enriched(ends):
        return rows[0], rows[1], rows[2]
    added = _polynomials(ends, x) if count <= _POLYNOMIALS_UP_TO else _next_to_ends(ends, float(waves[-1]), x)
    return tuple(np.concatenate([row, more]) for row, more in zip(rows, added, strict=True))  # type: ignore[return-value]


def are_enriched(ends: EndConditions) -> bool:
    """Return whether further functions are added to the beam functions."""
    return not _are_trigonometric(ends)


def _rigid_motions(ends: EndConditions, x: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the rigid motions that the ends allow."""
    one, nothing = np.ones_like(x), np.zeros_like(x)
    if "hinged" in (ends.upper, ends.lower):
        about = x if ends.upper == "hinged" else 1.0 - x
        return np.array([about]), np.array([one if ends.upper == "hinged" else -one]), np.array([nothing])
    return np.array([one, x - 0.5]), np.array([nothing, one]), np.array([nothing, nothing])


def _beam_functions(ends: EndConditions, waves: Floats, x: Floats) -> tuple[Floats, Floats, Floats]:
    """Return elastic beam functions and two derivatives, each with a sine of amplitude about 1."""
    if not waves.size:
        empty = np.empty((0, len(x)))
        return empty, empty, empty
    if _are_trigonometric(ends):
        value, slope, bend = (_trigonometric(ends, waves, x, derivative) for derivative in range(3))
        return value, slope, bend
    mixture = np.linalg.svd(_conditions(ends, waves))[2][:, -1, :]
    largest = np.take_along_axis(mixture, np.abs(mixture[:, :2]).argmax(axis=1)[:, None], axis=1)
    mixture = mixture / largest
    k = waves[:, None]
    a, b, c, d = (part[:, None] for part in mixture.T)
    sine, cosine = np.sin(k * x), np.cos(k * x)
    waving, turned = a * sine + b * cosine, a * cosine - b * sine
    first, last = c * np.exp(-k * x), d * np.exp(-k * (1.0 - x))
    return waving + first + last, k * (turned - first + last), k * k * (first + last - waving)


def _trigonometric(ends: EndConditions, waves: Floats, x: Floats, derivative: int) -> Floats:
    """Return sines, or cosines if the upper end is guided, or their first or second derivatives."""
    k = waves[:, None]
    sign = -1.0 if derivative == 2 or (derivative == 1 and ends.upper == "guided") else 1.0
    wave = np.sin if (ends.upper == "hinged") == (derivative != 1) else np.cos
    return np.asarray(sign * k**derivative * wave(k * x))


def _turned(x: Floats, most: int) -> Complexes:
    """Return exp(i m pi x), m up to ``most``, (len(x), most + 1): products of those before, which takes less time."""
    powers = np.ones((len(x), most + 1), dtype=np.complex128)
    powers[:, 1] = np.exp(1j * math.pi * x)
    known = 2
    while known <= most:
        some = min(known, most + 1 - known)
        following = powers[:, known - 1] * powers[:, 1]
        np.multiply(following[:, None], powers[:, :some], out=powers[:, known : known + some])
        known += some
    return powers


def _polynomials(ends: EndConditions, x: Floats) -> tuple[Floats, Floats, Floats]:
    """Return polynomials of lowest degree that fulfil the essential conditions, with two derivatives."""
    from numpy.polynomial import Legendre

    needed = [(at, d) for at, end in ((0.0, ends.upper), (1.0, ends.lower)) for d in _ESSENTIAL[end]]
    degrees = _POLYNOMIALS + _rigid(ends) + len(needed)  # rigid motions are polynomials too
    whole = [Legendre.basis(j, domain=[0.0, 1.0]) for j in range(degrees)]
    if needed:
        conditions = np.array([[p.deriv(d)(at) if d else p(at) for p in whole] for at, d in needed])
        space = np.linalg.svd(conditions)[2][len(needed) :]
    else:
        space = np.eye(degrees)
    return tuple(space @ np.array([p.deriv(d)(x) if d else p(x) for p in whole]) for d in range(3))


def _next_to_ends(ends: EndConditions, wavenumber: float, x: Floats) -> tuple[Floats, Floats, Floats]:
    """Return z^p exp(-z), z = a (distance from an end), with two derivatives; ``wavenumber`` is the largest of all."""
    rate = max(_NARROW, wavenumber / _NARROWEST)
    terms = []
    for end, sign, distance in ((ends.upper, 1.0, x), (ends.lower, -1.0, 1.0 - x)):
        z = rate * distance
        for p in _MISSING[end]:
            base = z ** (p - 2) * np.exp(-z)
            slope, curvature = z * (p - z), p * (p - 1) - 2 * p * z + z * z
            terms.append((z * z * base, sign * rate * slope * base, rate * rate * curvature * base))
    return tuple(np.array(part) for part in zip(*terms, strict=True))  # type: ignore[return-value]
