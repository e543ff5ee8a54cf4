"""Systems whose coefficients lie between bounds, stated for a proof of all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.caching import cached_property
from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.equations.pieces import TimedPiece, exact_period, in_time
from floquetrod.floquet.proof.balls import Array, up
from floquetrod.floquet.proof.system_problem import (
    Arithmetic,
    FirstOrder,
    Flow,
    Matrix,
    Oscillators,
    SecondOrder,
    Stretch,
    balanced,
    canonical_form,
    congruence,
    oscillators,
    row_sum,
    stretches,
)

_ROUNDING = 8.0 * 2.0**-52  # of the coefficients that a family computes, relative to their largest at a corner


class NotAffine(ValueError):
    """Coefficients that are not affine in each parameter."""


class Coefficients(NamedTuple):
    """Every number of a system in arrays: mass, damping, gyroscopic matrix, and pieces of the period.

    Of a piece: its mean, slope and harmonics (H, n, n); ``durations`` are parts of the period.
    """

    kind: type
    durations: tuple[Fraction, ...]
    arrays: dict[str, Array]


class Bounds(NamedTuple):
    """Middles and radii of every number of the systems of a box, and what is so of all of them.

    ``paired``: with every multiplier mu there is 1 / conj(mu), of each of them; ``uniform``: what the c of a damping
    2 c M lies between, None where that of one is another.
    """

    kind: type
    durations: tuple[Fraction, ...]
    middle: dict[str, Array]
    radius: dict[str, Array]
    symmetric: bool
    paired: bool
    constant: bool
    uniform: tuple[float, float] | None

    def reach(self, name: str, stretch: Array, time: float, longer: float, power: int) -> Array:
        """Return the radii of X R X^T t^power, abs(X) given, of times t up to ``longer`` off ``time``."""
        own = _reach(self.radius[name], stretch) * up(time + longer) ** power
        if not (own.any() or longer):
            return np.zeros_like(own)
        more = up((time + longer) ** power - time**power) if longer and power else 0.0
        return up(up(own * (1.0 + 1e-12)) + up(_reach(np.abs(self.middle[name]), stretch) * more))

    @property
    def spread(self) -> float:
        """How much the coefficients vary, as row sums of radii added up, with the period as the unit of time."""
        time = float(self.middle["period"][0])
        order = 2 if issubclass(self.kind, HillSystem) else 1
        powers = {"mean": order, "cosines": order, "sines": order, "slope": order + 1, "damping": 1, "gyroscopic": 1}
        total = size = 0.0
        for name, radius in self.radius.items():
            power = powers.get(name.split()[0])
            if power is not None:
                total += float(radius.sum(axis=-1).max(initial=0.0)) * time**power
                size += float(np.abs(self.middle[name]).sum(axis=-1).max(initial=0.0)) * time**power
        relative = order * float(self.radius["period"][0]) / time
        if "mass" in self.radius:
            relative += float(self.radius["mass"].sum(axis=-1).max()) / float(np.abs(self.middle["mass"]).max())
        return total + size * relative


def coefficients(system: HillSystem | PeriodicSystem, harmonics: int) -> Coefficients:
    """Return the numbers of one system, with as many harmonics on every piece."""
    pieces, whole, n = in_time(system), exact_period(system), in_time(system)[0].mean.shape[-1]
    arrays: dict[str, Array] = {"period": np.array([float(whole)])}
    if isinstance(system, HillSystem):
        arrays["mass"] = np.eye(n) if system.mass is None else system.mass
        arrays["damping"] = np.zeros((n, n)) if system.damping is None else system.damping
        arrays["gyroscopic"] = np.zeros((n, n)) if system.gyroscopic is None else system.gyroscopic
    for i, piece in enumerate(pieces):
        waves = np.zeros((harmonics, n, n), dtype=complex)
        waves[: len(piece.harmonics)] = piece.harmonics
        arrays[f"mean {i}"], arrays[f"cosines {i}"], arrays[f"sines {i}"] = piece.mean, waves.real, -waves.imag
        arrays[f"slope {i}"] = np.zeros((n, n)) if piece.slope is None else piece.slope
    return Coefficients(type(system), tuple(piece.length / whole for piece in pieces), arrays)


def _alike(systems: Sequence[HillSystem | PeriodicSystem]) -> list[Coefficients]:
    """Return the numbers of several systems in arrays of the same shapes; NotAffine where they have others."""
    most = max(len(piece.harmonics) for system in systems for piece in in_time(system))
    every = [coefficients(system, most) for system in systems]
    first = every[0]
    for other in every:
        shapes = [{name: array.shape for name, array in one.arrays.items()} for one in (first, other)]
        if other.kind is not first.kind or shapes[0] != shapes[1]:
            raise NotAffine("systems of different kinds or orders")
        if other.durations != first.durations:
            raise NotAffine("durations of pieces that vary")
    return every


def require_affine(system: Any, weighted: Sequence[tuple[float, Any]]) -> None:
    """Raise `NotAffine` where a system is not the weighted sum of others, except for rounding and its stated error."""
    found, *others = _alike([system, *(other for _, other in weighted)])
    stated = system.coefficient_error + max(other.coefficient_error for _, other in weighted)
    gaps, rounding = {}, {}
    for name, array in found.arrays.items():
        expected = sum(weight * other.arrays[name] for (weight, _), other in zip(weighted, others, strict=True))
        gaps[name] = array - expected
        largest = np.maximum.reduce([np.abs(array), *(np.abs(other.arrays[name]) for other in others)])
        rounding[name] = 4.0 * _ROUNDING * largest
    if stated:
        times = found.durations, float(found.arrays["period"][0])
        gaps = _values(gaps, *times)
        rounding = {name: 2.0 * stated + size for name, size in _values(rounding, *times, bound=True).items()}
    for name, gap in gaps.items():
        if (np.abs(gap) > rounding[name]).any():
            off, what = np.abs(gap).max(), name.rstrip(" 0123456789")
            raise NotAffine(f"a {what} that differs by {off:.2g} from what its corners say")


def _values(
    arrays: dict[str, Array], shares: Sequence[Fraction], period: float, *, bound: bool = False
) -> dict[str, Array]:
    """Return arrays with those of a piece summed to values at times of it, of bounds to one bound.

    The terms of a function that was sampled are determined less well than their sum, of which an error is stated.
    """
    found = {name: array for name, array in arrays.items() if not name[-1].isdigit()}
    inner, begin = np.linspace(0.0, 1.0, 33)[:, None], 0.0
    for i, share in enumerate(map(float, shares)):
        mean, slope, cosines, sines = (arrays[f"{name} {i}"] for name in ("mean", "slope", "cosines", "sines"))
        angles = 2.0 * np.pi * (begin + share * inner) * np.arange(1, len(cosines) + 1)
        c, s = (np.ones_like(angles),) * 2 if bound else (np.cos(angles), np.sin(angles))
        steady = mean + share * inner[..., None] * (slope * period)
        found[f"coefficient {i}"] = steady + np.tensordot(c, cosines, axes=1) + np.tensordot(s, sines, axes=1)
        begin += share
    return found


def bounds_of(systems: Sequence[HillSystem | PeriodicSystem]) -> Bounds:
    """Return what numbers that are affine in each parameter lie between, from the systems at the corners of a box."""
    every = _alike(systems)
    middle, radius = {}, {}
    for name in every[0].arrays:
        values = np.stack([one.arrays[name] for one in every])
        low, high = values.min(axis=0), values.max(axis=0)
        middle[name] = np.where(low == high, low, 0.5 * (low + high))
        off = np.maximum(high - middle[name], middle[name] - low)
        radius[name] = np.where(low == high, 0.0, up(off + _ROUNDING * np.maximum(np.abs(low), np.abs(high))))
    error = max(system.coefficient_error for system in systems)
    if error:
        radius = {n: r + error if n.startswith("mean") else r for n, r in radius.items()}
    structures = {system.structure for system in systems}
    plain = not any(one.arrays[name].any() for one in every for name in one.arrays if name.startswith("sines"))
    one_piece = len(every[0].durations) == 1
    symmetric = all(system.is_symmetric for system in systems if isinstance(system, HillSystem))
    reversible = structures <= {"reversible", "hamiltonian"} and plain and one_piece and not middle["slope 0"].any()
    second = every[0].kind is HillSystem
    paired = (structures == {"hamiltonian"} and (second or not error)) or (reversible and not error)
    constant = all(system.is_constant for system in systems)
    uniform = _uniform(systems, mass_varies=bool(radius["mass"].any())) if second else None
    return Bounds(every[0].kind, every[0].durations, middle, radius, symmetric, paired, constant, uniform)


def _uniform(systems: Sequence[Any], *, mass_varies: bool) -> tuple[float, float] | None:
    """Return what the c of a damping 2 c M lies between, None where one system has another or none can be removed."""
    rates = [system.uniform_damping for system in systems]
    if not any(rates) and None not in rates:
        return 0.0, 0.0
    if None in rates or mass_varies or any(system.gyroscopic is not None for system in systems):
        return None
    return min(rates) * (1.0 - _ROUNDING), float(up(max(rates) * (1.0 + _ROUNDING)))


@dataclass(frozen=True, kw_only=True)
class BoxOfSecondOrder(SecondOrder):
    """All systems of second order within bounds, `SecondOrder` in their middle."""

    bounds: Bounds

    @cached_property
    def is_symmetric(self) -> bool:
        """Whether the stiffness of every one is symmetric."""
        return self.bounds.symmetric

    @cached_property
    def uniform_damping(self) -> Fraction | None:
        """About the middle of the c of a damping 2 c M, where every one has such a damping."""
        uniform = self.bounds.uniform
        return None if uniform is None else (Fraction(uniform[0]) + Fraction(uniform[1])) / 2

    @property
    def is_paired(self) -> bool:
        """Whether with every multiplier mu there is 1 / conj(mu), of every one."""
        return self.bounds.paired and not self.bounds.radius["damping"].any()

    def oscillators(self, arithmetic: Arithmetic, period: Fraction, *, freed: bool) -> Oscillators:
        """Return all of them in balls."""
        middle = oscillators(arithmetic, self, period, freed=freed)
        bounds, n = self.bounds, self.order
        stretch = np.eye(n) if np.array_equal(self.mass, np.eye(n)) else np.abs(congruence(self.mass))
        longest, longer = float(period), 0.0 if self.is_constant else float(bounds.radius["period"][0])

        def radius(name: str, power: int) -> Array:
            """Return the radii of a matrix in the coordinates and the time of ``middle``."""
            return bounds.reach(name, stretch, longest, longer, power)

        excess, uniform = middle.excess, bounds.uniform
        less = _reach(np.abs(self.mass), stretch) * up(longest + longer) ** 2
        less = less * (up(uniform[1] * uniform[1] - uniform[0] * uniform[0]) if freed and uniform else 0.0)
        if bounds.radius["mass"].any():
            plain = arithmetic.zeros((n, n), real=True) if excess is None else excess
            excess = plain.widened(radius("mass", 0))
        pieces = [_widened(arithmetic, piece, i, radius) for i, piece in enumerate(middle.pieces)]
        pieces = [piece._replace(mean=piece.mean.widened(up(less))) for piece in pieces] if less.any() else pieces
        return middle._replace(
            excess=excess,
            defect=row_sum(excess) if excess is not None else 0.0,
            damping=None if freed else _wider(arithmetic, middle.damping, radius("damping", 1), n),
            gyroscopic=_wider(arithmetic, middle.gyroscopic, radius("gyroscopic", 1), n),
            pieces=pieces,
        )


@dataclass(frozen=True, kw_only=True)
class BoxOfFirstOrder(FirstOrder):
    """All systems of first order within bounds, `FirstOrder` in their middle."""

    bounds: Bounds

    def flow(self, arithmetic: Arithmetic, period: Fraction) -> Flow:
        """Return all of them in balls."""
        factor, stretch = arithmetic.rational(period), np.eye(self.pieces[0].mean.shape[-1])
        longest, longer = float(period), 0.0 if self.is_constant else float(self.bounds.radius["period"][0])

        def radius(name: str, power: int) -> Array:
            return self.bounds.reach(name, stretch, longest, longer, power - 1)

        middle = stretches(arithmetic, self.pieces, period)
        scaled = [piece.each(lambda m: m * factor, lambda m: m * factor) for piece in middle]
        wide = [_widened(arithmetic, piece, i, radius) for i, piece in enumerate(scaled)]
        return balanced(wide, np.zeros(stretch.shape), arithmetic.exact(canonical_form(len(stretch))))


def _reach(radii: Array, stretch: Array) -> Array:
    """Return bounds of X R X^T of all R within radii, abs(X) given."""
    return up(up(stretch @ radii) @ np.swapaxes(stretch, -1, -2))


def _wider(arithmetic: Arithmetic, matrix: Matrix | None, radii: Array, n: int) -> Matrix | None:
    """Return a matrix widened, a zero one where it is None; None where both are zero."""
    if not radii.any():
        return matrix
    return (arithmetic.zeros((n, n), real=True) if matrix is None else matrix).widened(radii)


def _widened(arithmetic: Arithmetic, piece: Stretch, i: int, radius: Any) -> Stretch:
    """Return a piece with the radii of its matrices."""
    cosines, sines = radius(f"cosines {i}", 2), radius(f"sines {i}", 2)
    waves = []
    for wave, cosine, sine in zip(piece.waves, cosines, sines, strict=True):
        full = wave + arithmetic.zeros(wave.shape, real=False) if sine.any() else wave
        waves.append(full.widened(up(cosine + sine)))
    slope = None if piece.slope is None else piece.slope.widened(radius(f"slope {i}", 3))
    return piece._replace(mean=piece.mean.widened(radius(f"mean {i}", 2)), slope=slope, waves=waves)


def problem_of_bounds(bounds: Bounds) -> BoxOfSecondOrder | BoxOfFirstOrder:
    """Return the problem of all systems within bounds."""
    period = Fraction(float(bounds.middle["period"][0]))
    pieces, begin = [], Fraction(0)
    for i, share in enumerate(bounds.durations):
        length = share * period
        waves = bounds.middle[f"cosines {i}"] - 1j * bounds.middle[f"sines {i}"]
        sloped = bounds.middle[f"slope {i}"].any() or bounds.radius[f"slope {i}"].any()
        slope = bounds.middle[f"slope {i}"] if sloped else None
        waves = np.zeros((0, *waves.shape[1:])) if bounds.constant else waves
        pieces.append(TimedPiece(begin, length, bounds.middle[f"mean {i}"], slope, waves, begin))
        begin += length
    if issubclass(bounds.kind, HillSystem):
        mass, damping, gyroscopic = (bounds.middle[name] for name in ("mass", "damping", "gyroscopic"))
        return BoxOfSecondOrder(mass, damping, gyroscopic, tuple(pieces), period, False, 0.0, bounds=bounds)
    return BoxOfFirstOrder(tuple(pieces), period, 0.0, bounds.paired, bounds=bounds)
