"""Every number of a system in arrays, and the problem of a proof: of one system, or of all between several."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.equations.matrices import mass_matrix
from floquetrod.equations.pieces import exact_period, in_time
from floquetrod.floquet.proof.balls import Array, up
from floquetrod.floquet.proof.system_problem import BallPiece, ExactRange, FirstOrder, Known, SecondOrder, SystemProblem

System = HillSystem | PeriodicSystem

_ROUNDING = 8.0 * 2.0**-52  # of the coefficients that a family computes, relative to their largest at a corner


class NotAffine(ValueError):
    """The coefficients are not affine in each parameter."""


class _Numbers(NamedTuple):
    """Every number of a system."""

    durations: tuple[Fraction, ...]  # of pieces, as parts of the period
    # "period", "mass", "damping", "gyroscopic"; of piece i "mean i", "cosines i" (H, n, n), ...
    arrays: dict[str, Array]


class Bounds(NamedTuple):
    """What every number of some systems lies between."""

    kind: type[System]
    durations: tuple[Fraction, ...]
    numbers: dict[str, Known]  # by the names of `_Numbers.arrays`

    @property
    def spread(self) -> float:
        """How much the coefficients vary, as row sums of radii added up, with the period as the unit of time."""
        time = float(self.numbers["period"].middle[0])
        order = 2 if issubclass(self.kind, HillSystem) else 1
        powers = {"mean": order, "cosines": order, "sines": order, "slope": order + 1, "damping": 1, "gyroscopic": 1}
        total = size = relative = 0.0
        for name, (middle, radius) in self.numbers.items():
            power = powers.get(name.split()[0])
            if power is not None:
                total += 0.0 if radius is None else float(radius.sum(axis=-1).max(initial=0.0)) * time**power
                size += float(np.abs(middle).sum(axis=-1).max(initial=0.0)) * time**power
            elif radius is not None:  # of the period or the mass
                relative += (order if name == "period" else 1) * float(radius.sum(axis=-1).max() / np.abs(middle).max())
        return total + size * relative


def _numbers(system: System, harmonics: int) -> _Numbers:
    """Return the numbers of one system, with as many harmonics on every piece."""
    pieces, whole, n = in_time(system), exact_period(system), system.order
    arrays: dict[str, Array] = {"period": np.array([float(whole)])}
    if isinstance(system, HillSystem):
        arrays["mass"] = mass_matrix(system)
        arrays["damping"] = np.zeros((n, n)) if system.damping is None else system.damping
        arrays["gyroscopic"] = np.zeros((n, n)) if system.gyroscopic is None else system.gyroscopic
    for i, piece in enumerate(pieces):
        waves = np.zeros((harmonics, n, n), dtype=complex)
        waves[: len(piece.harmonics)] = piece.harmonics
        arrays[f"mean {i}"], arrays[f"cosines {i}"], arrays[f"sines {i}"] = piece.mean, waves.real, -waves.imag
        arrays[f"slope {i}"] = np.zeros((n, n)) if piece.slope is None else piece.slope
    return _Numbers(tuple(piece.length / whole for piece in pieces), arrays)


def _alike(systems: Sequence[System]) -> list[_Numbers]:
    """Return the numbers of several systems in arrays of the same shapes; NotAffine where they have others."""
    most = max(len(piece.harmonics) for system in systems for piece in in_time(system))
    every = [_numbers(system, most) for system in systems]
    first = every[0]
    for system, other in zip(systems, every, strict=True):
        shapes = [{name: array.shape for name, array in one.arrays.items()} for one in (first, other)]
        if type(system) is not type(systems[0]) or shapes[0] != shapes[1]:
            raise NotAffine("systems of different kinds or orders")
        if other.durations != first.durations:
            raise NotAffine("durations of pieces that vary")
    return every


def require_affine(system: Any, weighted: Sequence[tuple[float, Any]]) -> None:
    """Raise `NotAffine` where a system is not the weighted sum of others, except for rounding and its stated error."""
    numbers, *corners = _alike([system, *(corner for _, corner in weighted)])
    stated = system.coefficient_error + max(corner.coefficient_error for _, corner in weighted)
    gaps, rounding = {}, {}
    for name, array in numbers.arrays.items():
        expected = sum(weight * corner.arrays[name] for (weight, _), corner in zip(weighted, corners, strict=True))
        gaps[name] = array - expected
        largest = np.maximum.reduce([np.abs(array), *(np.abs(corner.arrays[name]) for corner in corners)])
        rounding[name] = 4.0 * _ROUNDING * largest
    if stated:
        times = numbers.durations, float(numbers.arrays["period"][0])
        gaps = _values(gaps, *times)
        rounding = {name: 2.0 * stated + size for name, size in _values(rounding, *times, bound=True).items()}
    for name, gap in gaps.items():
        if (np.abs(gap) > rounding[name]).any():
            off, what = np.abs(gap).max(), name.rstrip(" 0123456789")
            raise NotAffine(f"a {what} that differs by {off:.2g} from what its corners say")


def _values(
    arrays: dict[str, Array], shares: Sequence[Fraction], period: float, *, bound: bool = False
) -> dict[str, Array]:
    """Return the values of the coefficients at 33 times of each piece, or bounds of them, beside the other arrays.

    Fourier coefficients of a sampled function are known less well than their sum, whose error is stated.
    """
    values = {name: array for name, array in arrays.items() if not name[-1].isdigit()}
    inner, begin = np.linspace(0.0, 1.0, 33)[:, None], 0.0
    for i, share in enumerate(map(float, shares)):
        mean, slope, cosines, sines = (arrays[f"{name} {i}"] for name in ("mean", "slope", "cosines", "sines"))
        angles = 2.0 * np.pi * (begin + share * inner) * np.arange(1, len(cosines) + 1)
        c, s = (np.ones_like(angles),) * 2 if bound else (np.cos(angles), np.sin(angles))
        steady = mean + share * inner[..., None] * (slope * period)
        values[f"coefficient {i}"] = steady + np.tensordot(c, cosines, axes=1) + np.tensordot(s, sines, axes=1)
        begin += share
    return values


def bounds_of(systems: Sequence[System]) -> Bounds:
    """Return the bounds of all numbers over a box, affine in each parameter, from the systems at its corners."""
    every = _alike(systems)
    names, arrays = every[0].arrays, [one.arrays for one in every]
    return Bounds(type(systems[0]), every[0].durations, {n: _known([each[n] for each in arrays]) for n in names})


def _known(values: list[Array]) -> Known:
    """Return what lies between arrays, rounding of what varies included."""
    low, high = np.minimum.reduce(values), np.maximum.reduce(values)
    varies = low != high
    if not varies.any():
        return Known(low, None)
    middle = np.where(varies, 0.5 * (low + high), low)
    off = np.maximum(high - middle, middle - low)
    return Known(middle, np.where(varies, up(off + _ROUNDING * np.maximum(np.abs(low), np.abs(high))), 0.0))


def system_problem(*systems: Any) -> SystemProblem:
    """Return the problem of one system, exactly, or of all systems between several, which must not be batches."""
    bounds = bounds_of(systems)
    error, periods = max(system.coefficient_error for system in systems), [exact_period(system) for system in systems]
    rounding = Fraction(_ROUNDING) if min(periods) < max(periods) else 0
    period = ExactRange(min(periods) * (1 - rounding), max(periods) * (1 + rounding))
    pieces = _stretches(bounds, is_constant=all(system.is_constant for system in systems))
    all_hamiltonian = all(system.structure == "hamiltonian" for system in systems)
    is_reversible = not error and _is_reversible(systems, bounds)
    if not issubclass(bounds.kind, HillSystem):
        is_hamiltonian = all_hamiltonian and not error
        return FirstOrder(pieces, period, error, is_hamiltonian or is_reversible, is_hamiltonian)
    mass, damping, gyroscopic = (bounds.numbers[name] for name in ("mass", "damping", "gyroscopic"))
    rates = _rates(systems, mass_varies=mass.radius is not None)
    can_be_freed = rates is not None and (not rates.high or gyroscopic.is_zero)
    is_hamiltonian = can_be_freed and all(system.is_symmetric for system in systems)
    is_paired = all_hamiltonian or is_reversible
    return SecondOrder(pieces, period, error, is_paired, is_hamiltonian, mass, damping, gyroscopic, rates)


def _is_reversible(systems: Sequence[System], bounds: Bounds) -> bool:
    """Return whether all systems are even about one instant: one system, or series about 0."""
    if len(systems) == 1:
        return systems[0].structure == "reversible"
    numbers, order = bounds.numbers, systems[0].order
    if len(bounds.durations) > 1 or not numbers["slope 0"].is_zero:
        return False
    if issubclass(bounds.kind, HillSystem):
        return all(numbers[name].is_zero for name in ("damping", "gyroscopic", "sines 0"))
    same = np.kron(np.eye(2, dtype=bool), np.ones((order // 2, order // 2), dtype=bool))
    even = (numbers[name].at((..., same)) for name in ("mean 0", "cosines 0"))
    return order % 2 == 0 and all(known.is_zero for known in (*even, numbers["sines 0"].at((..., ~same))))


def _stretches(bounds: Bounds, *, is_constant: bool) -> tuple[BallPiece, ...]:
    """Return the pieces of the period, of a constant coefficient one."""
    pieces, begin = [], Fraction(0)
    for i, length in enumerate(bounds.durations[: 1 if is_constant else None]):
        mean, slope, cosines, sines = (bounds.numbers[f"{name} {i}"] for name in ("mean", "slope", "cosines", "sines"))
        waves = [] if is_constant else [_wave(cosines.at(k), sines.at(k)) for k in range(len(cosines.middle))]
        pieces.append(BallPiece(begin, length, mean, None if slope.is_zero else slope, waves))
        begin += length
    return (pieces[0]._replace(length=Fraction(1)),) if is_constant else tuple(pieces)


def _wave(cosine: Known, sine: Known) -> Known:
    """Return the amplitude of a harmonic, a real one where it has no sine."""
    if sine.is_zero:
        return cosine
    radii = [known.radius for known in (cosine, sine) if known.radius is not None]
    return Known(cosine.middle - 1j * sine.middle, up(np.hypot.reduce(radii)) if radii else None)


def _rates(systems: Sequence[Any], *, mass_varies: bool) -> ExactRange | None:
    """Return what the c of a damping 2 c M lies between, None where a system has another or it cannot be determined."""
    every = [_rate(system) for system in systems]
    rates = [rate for rate in every if rate is not None]
    if len(rates) < len(every) or (mass_varies and min(rates) < max(rates)):
        return None
    rounding = Fraction(_ROUNDING) if min(rates) < max(rates) else 0
    return ExactRange(min(rates) * (1 - rounding), max(rates) * (1 + rounding))


def _rate(system: HillSystem) -> Fraction | None:
    """Return the c >= 0 of a damping 2 c M, exactly; None for any other."""
    if system.damping is None:
        return Fraction(0)
    mass = mass_matrix(system)
    twice = Fraction(float(system.damping[0, 0])) / Fraction(float(mass[0, 0]))
    pairs = zip(system.damping.ravel().tolist(), mass.ravel().tolist(), strict=True)
    return twice / 2 if twice >= 0 and all(Fraction(c) == twice * Fraction(m) for c, m in pairs) else None
