"""Names of growing solutions: which natural frequencies of the mean system combine with the forcing.

A heuristic, except for equations of second order that are coupled with no other, whose tongues are counted.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Bools, Complexes, Floats
from floquetrod.equations import DelaySystem, HillSystem, PeriodicSystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.equations.hill_system import in_first_order, restricted
from floquetrod.equations.pieces import fourier
from floquetrod.floquet.hill_count import hill_count
from floquetrod.floquet.multipliers import whole_period_maps
from floquetrod.floquet.verdict import Interval

Ints = NDArray[np.intp]

_HIGHEST_ORDER = 40  # of resonances searched for
_MOST_MODES = 200  # of a system whose resonances are named: their number grows with the square
_PER_ORDER = 0.05  # penalty of an order, in detuning relative to w: low orders grow faster
_UNCOUPLED = 0.2  # penalty, alike, where the harmonic of that order does not couple the modes
_ACCURACY = 1e-10  # of the maps of single equations, whose growth tells them apart
_ALIKE = 1e-6  # growth times period, relative above 1, and distance of multipliers on the unit circle (a choice)
_NOTHING = 1e-9  # an angle, or a share of the largest frequency or coupling, below it counts as 0

_UNNAMED = {"hopf": "Hopf instability", "flip": "period doubling", "fold": "growth without oscillation"}
"""Of systems with delays, whose modes are not counted."""

Kind = Literal[
    "direct",
    "sum",
    "difference",
    "buckling",
    "hopf",
    "flip",
    "fold",
    "fold or branch point",
    "period doubling",
    "Neimark-Sacker",
]


class Resonance(NamedTuple):
    """The name of an instability: the combination of natural frequencies of the mean system that explains it best.

    Attributes
    ----------
    kind : {"direct", "sum", "difference", "buckling", "hopf", "flip", "fold", ...}
        2 w_i = k w; w_i + w_j = k w; w_i - w_j = k w (k = 0: flutter of the mean system); negative mean stiffness.  Of
        systems with delays: a pair of multipliers, one below -1, one above 1.  Of periodic orbits the special point at
        which such multipliers leave the unit circle: "Neimark-Sacker", "period doubling", "fold or branch point".
    modes : tuple of int
        Modes of the mean system, counted from 1 in the order of their frequencies; none of systems with delays and of
        orbits.
    order : int
        k, in terms of w = 2 pi / period; 0 for buckling.
    growth_rate : float
        Of the solution it names, per unit of time.
    """

    kind: Kind
    modes: tuple[int, ...]
    order: int
    growth_rate: float

    def as_dict(self, growth: str = "growth_rate") -> dict[str, Any]:
        """Return it for JSON, the growth rate under the name ``growth``."""
        return {
            "name": str(self),
            "kind": self.kind,
            "modes": list(self.modes),
            "order": self.order,
            growth: self.growth_rate,
        }

    def __str__(self) -> str:
        """Return, say, "sum resonance of modes 1 and 2, order 1"."""
        if not self.modes:
            return _UNNAMED.get(self.kind, self.kind)
        if self.kind == "buckling":
            return f"buckling of mode {self.modes[0]}"
        if self.kind == "direct":
            return f"direct resonance of mode {self.modes[0]}, order {self.order}"
        modes = f"modes {self.modes[0]} and {self.modes[1]}"
        return f"{self.kind} resonance of {modes}, order {self.order}" if self.order else f"flutter of {modes}"


def name(
    system: HillSystem | PeriodicSystem | DelaySystem,
    exponents: Sequence[complex],
    errors: Sequence[float],
    *,
    of_orbit: bool = False,
) -> tuple[Resonance, ...]:
    """Return the names of the growing solutions among ``exponents``, the fastest first, each name once.

    The multiplier decides which names are admissible.  One mode of a real system has its frequency locked to a multiple
    of w / 2 where it grows, or does not oscillate: its multiplier is real, of sign (-1)^k for a direct resonance of
    order k and positive for buckling.  A pair of complex multipliers takes two modes.  ``errors`` are those of the
    exponents, within which a multiplier counts as real; ``of_orbit`` says that the system is linearised along a
    periodic orbit, whose mean has no natural frequencies.
    """
    lowest = -_NOTHING / float(system.period)
    known = zip(exponents, errors, strict=True)
    found = [(exponent, error) for exponent, error in known if exponent.real > 0.0 and exponent.imag >= lowest]
    growing = [exponent for exponent, _ in found]
    if isinstance(system, DelaySystem):
        return _by_multipliers(system, growing, ("hopf", "fold", "flip"))
    if of_orbit:
        return _by_multipliers(system, growing, ("Neimark-Sacker", "fold or branch point", "period doubling"))
    # The frequencies of second moments are sums and differences of the natural ones; complex modes have no conjugates.
    if system.MEANING or (isinstance(system, PeriodicSystem) and system.is_complex):
        return ()
    equations = system.order if isinstance(system, HillSystem) else 0.5 * system.order
    if not growing or equations > _MOST_MODES:
        return ()
    singles = _singles(system) if isinstance(system, HillSystem) and not system.pieces else []
    by_tongue = _by_tongues(singles, growing, float(system.period))
    modes = _mean_modes(system, singles)
    if modes is None or len(modes.poles) + len(singles) > _MOST_MODES:
        return ()
    differences = not isinstance(system, HillSystem) or system.gyroscopic is not None or not system.is_symmetric
    w = 2.0 * math.pi / float(system.period)
    names: dict[tuple[str, tuple[int, ...], int], Resonance] = {}
    pairs = _Pairs.of(modes, w, differences)
    for place, (exponent, error) in enumerate(found):
        if place in by_tongue:
            number = int(modes.of_singles[by_tongue[place]])
            tongue = singles[by_tongue[place]].tongue or 0
            best = Resonance("direct" if tongue else "buckling", (number,), tongue, exponent.real)
        else:
            real = _off(exponent, 0.0, 0.5 * w) <= max(error / w, _NOTHING)  # Im exponent = k w / 2
            candidates = [*_combinations(modes, pairs, exponent, w, real), *_of_the_mean(modes, exponent, w, real)]
            if not candidates:
                continue
            best = min(candidates, key=lambda candidate: candidate[:3]).name
        names.setdefault((best.kind, best.modes, best.order), best)
    return tuple(names.values())


class _Single(NamedTuple):
    """An equation of second order, not driven into growth by its damping, that is coupled with no other."""

    unknown: int  # its place in the system
    pole: complex  # exponent of its mean, growing or with positive imaginary part
    tongue: int | None  # of Hill's equation in which it lies, its damping removed; None in none
    growth_rate: float  # of its fastest solution, where it lies in a tongue; NaN where its map overflows


def _singles(system: HillSystem) -> list[_Single]:
    """Return the equations that are coupled with no other and whose tongue can be counted."""
    given = [m for m in (system.stiffness, system.mass, system.damping, system.gyroscopic) if m is not None]
    coupled = np.any([m != 0.0 for m in given], axis=0) | (system.harmonics != 0.0).any(axis=0)
    np.fill_diagonal(coupled, val=False)
    alone = ~(coupled.any(axis=0) | coupled.any(axis=1))
    singles = (_single(system, int(unknown)) for unknown in np.flatnonzero(alone))
    return [single for single in singles if single is not None]


def _single(system: HillSystem, unknown: int) -> _Single | None:
    """Return what is known of an equation by itself; None with damping below zero, or where it cannot be counted."""
    equation = restricted(system, np.array([unknown]))
    mass = 1.0 if equation.mass is None else float(equation.mass[0, 0])
    damping = 0.0 if equation.damping is None else 0.5 * float(equation.damping[0, 0]) / mass
    mean = damping**2 - float(equation.stiffness[0, 0]) / mass
    harmonics = -np.asarray(equation.harmonics, dtype=np.complex128)[:, 0, 0] / mass
    below = hill_count(mean, harmonics, 2.0 * math.pi / float(equation.period)).below
    if below is None or damping < 0.0:
        return None
    interval = Interval.from_count(below)
    pole = cmath.sqrt(mean) - damping
    if interval.kind != "tongue":
        return _Single(unknown, pole, None, -math.inf)
    growth = whole_period_maps.growth_rate(by_pieces.of_batch(equation.as_periodic_system()), _ACCURACY)
    return _Single(unknown, pole, interval.order, growth)


def _by_tongues(singles: Sequence[_Single], growing: Sequence[complex], period: float) -> dict[int, int]:
    """Return the places of growing exponents of single equations, and the places of these among ``singles``.

    Multipliers of tongue k have the sign of (-1)^k; of several equations that have it, the nearest in growth is meant.
    """
    left = {i: single for i, single in enumerate(singles) if single.tongue is not None and not single.growth_rate < 0.0}
    found: dict[int, int] = {}
    for place, exponent in enumerate(growing):
        half_turns = exponent.imag * period / math.pi
        apart = {
            i: 0.0 if math.isnan(single.growth_rate) else abs(single.growth_rate - exponent.real)
            for i, single in left.items()
            if abs((half_turns - (single.tongue or 0) + 1.0) % 2.0 - 1.0) < _ALIKE
        }
        nearest = min(apart, key=apart.__getitem__, default=None)
        if nearest is not None and apart[nearest] <= _ALIKE * max(exponent.real, 1.0 / period):
            found[place] = nearest
            del left[nearest]
    return found


def _by_multipliers(
    system: HillSystem | PeriodicSystem | DelaySystem, growing: list[complex], kinds: tuple[Kind, Kind, Kind]
) -> tuple[Resonance, ...]:
    """Return the names of the ways in which multipliers leave the unit circle: as a pair, through 1, through -1."""
    pair, one, minus_one = kinds
    names: dict[str, Resonance] = {}
    for exponent in growing:
        angle = exponent.imag * float(system.period)
        real = abs(angle) <= _NOTHING if system.is_constant else abs(math.sin(angle)) <= _NOTHING
        kind = pair if not real else one if math.cos(angle) > 0.0 else minus_one
        names.setdefault(kind, Resonance(kind, (), 0, exponent.real))
    return tuple(names.values())


class _MeanModes(NamedTuple):
    """Modes of the mean system, the lowest frequency first."""

    poles: Complexes  # (m,), an exponent of each, with positive imaginary part where it oscillates
    up: NDArray[np.intp]  # (m,), place of the exponent in ``coupling``
    down: NDArray[np.intp]  # (m,), place of its conjugate
    coupling: Floats  # (H, N, N), of exponents by each harmonic, both ways, relative to its strongest
    numbers: Ints  # (m,), of the modes among all
    of_singles: Ints  # numbers of single equations


def _mean_modes(system: HillSystem | PeriodicSystem, singles: Sequence[_Single] = ()) -> _MeanModes | None:
    """Return the modes of the mean system without its single equations; None where they cannot be computed."""
    alone = np.array([single.pole for single in singles], dtype=np.complex128)
    if isinstance(system, HillSystem) and singles:
        if len(singles) == system.order:
            none = np.zeros(0, dtype=np.intp)
            return _MeanModes(alone[:0], none, none, np.zeros((0, 0, 0)), none, _numbers(alone))
        system = restricted(system, np.setdiff1d(np.arange(system.order), [single.unknown for single in singles]))
    freed = system.undamped if isinstance(system, HillSystem) and system.is_symmetric else None
    is_plain = freed is not None and not freed[0].pieces and freed[0].mass is None and freed[0].gyroscopic is None
    spectrum = _symmetric(*freed) if freed is not None and is_plain else None
    if spectrum is None:
        spectrum = _of_first_order(in_first_order(system))
    if spectrum is None:
        return None
    values, couplings = spectrum
    size = float(np.abs(values).max(initial=0.0))
    oscillating = np.flatnonzero(values.imag > _NOTHING * size)
    oscillating = oscillating[np.argsort(values[oscillating].imag, kind="stable")]
    still = np.flatnonzero(np.abs(values.imag) <= _NOTHING * size)
    still = still[np.argsort(-values[still].real, kind="stable")]
    # Real exponents come in pairs, of which the growing one names a mode.
    up = np.concatenate([still[: math.ceil(len(still) / 2)], oscillating])
    partners = np.abs(values[None, :] - values[up][:, None].conj()).argmin(axis=1)
    with np.errstate(all="ignore"):
        strongest = couplings.max(axis=(-2, -1), keepdims=True, initial=0.0)
        coupling = np.nan_to_num(couplings / strongest)
    numbers = _numbers(np.concatenate([values[up], alone]))
    return _MeanModes(values[up], up, partners, coupling, numbers[: len(up)], numbers[len(up) :])


def _numbers(poles: Complexes) -> Ints:
    """Return the numbers of modes: those that do not oscillate first, the fastest of these first."""
    numbers = np.empty(len(poles), dtype=np.intp)
    numbers[np.lexsort([np.where(poles.imag == 0.0, -poles.real, 0.0), poles.imag])] = 1 + np.arange(len(poles))
    return numbers


def _of_first_order(first: PeriodicSystem) -> tuple[Complexes, Floats] | None:
    """Return the exponents of a mean system (N,), and how strongly each harmonic couples them, (H, N, N)."""
    try:
        values, vectors = np.linalg.eig(first.mean)
        inverse = np.linalg.inv(vectors)
    except np.linalg.LinAlgError:
        return None
    with np.errstate(all="ignore"):
        waves = fourier(first, _HIGHEST_ORDER)
        forward = np.abs(inverse @ waves @ vectors)
        backward = np.abs(inverse @ waves.conj() @ vectors)
        couplings = np.sqrt(forward * np.swapaxes(backward, -1, -2))
    return values.astype(np.complex128), couplings


def _symmetric(freed: HillSystem, damping: float) -> tuple[Complexes, Floats] | None:
    """Return exponents and couplings as `_of_first_order`, of q'' + 2 c q' + K q = 0 at a tenth of the cost.

    With exponents -c +- r and modes phi of length 1 a harmonic Z couples two by
    |phi_i . Z phi_j| / (2 sqrt(|r_i r_j|)).  None where an exponent is double.
    """
    squares, modes = np.linalg.eigh(freed.stiffness)
    root = np.sqrt(-squares.astype(np.complex128))
    if not np.abs(squares).min() > _NOTHING * np.abs(squares).max():
        return None
    waves = np.asarray(freed.harmonics).reshape(-1, *modes.shape)
    coupled = np.abs(modes.T @ waves @ modes) / (2.0 * np.sqrt(np.abs(np.outer(root, root))))
    return np.asarray(np.concatenate([root, -root]) - damping, complex), np.tile(coupled, (1, 2, 2))


class _Candidate(NamedTuple):
    """A name, its misfit, and the rank and first mode that decide between equal misfits."""

    misfit: float
    rank: int
    first: int
    name: Resonance


class _Pairs(NamedTuple):
    """Pairs of modes that may resonate, and the terms of their misfit that do not depend on the exponent."""

    first: Ints  # (p,), a mode
    second: Ints  # (p,), its partner; a mode with itself is a direct resonance
    orders: (
        Floats  # (p, 3) or (p, 6), multiples of the forcing nearest to the sum of the frequencies, then the difference
    )
    detuning: Floats  # alike, from each, infinite where there is no such resonance
    cost: Floats  # alike, of harmonics that do not couple them

    @classmethod
    def of(cls, modes: _MeanModes, w: float, differences: bool) -> _Pairs:
        """Return the pairs; without ``differences``, because all modes have one Krein sign, sums alone."""
        f = modes.poles.imag
        first, second = np.triu_indices(len(f))
        possible = ~_buckles(modes)[first] | (first == second)  # a mode pushed over may be held, and resonate
        first, second = first[possible], second[possible]
        sums = _near(modes, f[first] + f[second], w, modes.up[first], modes.down[second])
        if not differences:
            return cls(first, second, *sums)
        orders, detuning, cost = _near(modes, f[second] - f[first], w, modes.up[first], modes.up[second])
        apart = orders, np.where((first == second)[:, None], math.inf, detuning), cost
        return cls(first, second, *(np.hstack(parts) for parts in zip(sums, apart, strict=True)))


def _combinations(modes: _MeanModes, pairs: _Pairs, exponent: complex, w: float, real: bool) -> list[_Candidate]:
    """Return the best combination of modes with the forcing, by detuning and mismatch of the angle and the order.

    Direct resonances are among them where the multiplier is ``real``, of odd orders where it is negative, of even ones
    where it is positive.
    """
    f = modes.poles.imag
    first, second, orders = pairs.first, pairs.second, pairs.orders
    if not first.size:
        return []
    angle = np.minimum(_off(exponent, f, w), _off(exponent, -f, w))
    mismatch = np.repeat((angle[first] + angle[second])[:, None], orders.shape[1], axis=1)
    same = first == second
    mismatch[same] = 2.0 * _off(exponent, 0.5 * orders[same] * w, w)
    mismatch[same] = np.where(real & (mismatch[same] < 0.5), mismatch[same], math.inf)
    misfits = pairs.detuning + mismatch + pairs.cost + _PER_ORDER * orders
    # The first of the least, in the order of modes, kinds and orders.
    pair, column = divmod(int(np.where(np.isnan(misfits), math.inf, misfits).argmin()), misfits.shape[1])
    i, j, misfit = int(first[pair]), int(second[pair]), float(misfits[pair, column])
    if not misfit < math.inf:
        return []
    kind: Literal["direct", "sum", "difference"] = "direct" if i == j else "sum" if column < 3 else "difference"
    members = (int(modes.numbers[i]),) if i == j else _members(modes, i, j)
    return [_Candidate(misfit, 0, i, Resonance(kind, members, int(orders[pair, column]), exponent.real))]


def _near(modes: _MeanModes, total: Floats, w: float, first: Ints, second: Ints) -> tuple[Floats, Floats, Floats]:
    """Return the three orders k next to total = k w, their detuning, infinite beyond all orders, and their cost.

    A harmonic that does not couple two exponents has a cost: several harmonics together might.
    """
    orders = np.rint(np.minimum(total / w, 1e6))[:, None] + np.array([-1.0, 0.0, 1.0])
    looked_for = (orders >= 1.0) & (orders <= _HIGHEST_ORDER)
    detuning = np.where(looked_for, np.abs(total[:, None] - orders * w) / w, math.inf)
    harmonics = len(modes.coupling)
    known = looked_for & (orders <= harmonics)
    cost = np.zeros(orders.shape)
    if harmonics:
        harmonic = np.clip(orders, 1.0, harmonics).astype(np.intp) - 1
        coupling = modes.coupling[harmonic, first[:, None], second[:, None]]
        cost = np.where(known & (coupling < _NOTHING), _UNCOUPLED, 0.0)
    return orders, detuning, cost


def _of_the_mean(modes: _MeanModes, exponent: complex, w: float, real: bool) -> list[_Candidate]:
    """Return the candidates without forcing: buckling, and flutter, where two modes of the mean system have met.

    Buckling is among them where the multiplier is ``real`` and positive.
    """
    poles, frequencies = modes.poles, modes.poles.imag
    candidates = []
    for i in np.flatnonzero(_buckles(modes)).tolist():
        off = _off(exponent, 0.0, w)
        if real and off < 0.25:
            misfit = off + abs(poles[i].real - exponent.real) / w
            name = Resonance("buckling", (int(modes.numbers[i]),), 0, exponent.real)
            candidates.append(_Candidate(float(misfit), 0, i, name))
    for i, pole in enumerate(poles):
        if pole.real > _NOTHING * abs(pole) and pole.imag > 0.0 and len(poles) > 1:
            j = min((k for k in range(len(poles)) if k != i), key=lambda k: abs(frequencies[k] - pole.imag))
            members = _members(modes, i, j)
            misfit = _off(exponent, pole.imag, w)
            candidates.append(_Candidate(float(misfit), 1, i, Resonance("difference", members, 0, exponent.real)))
    return candidates


def _members(modes: _MeanModes, i: int, j: int) -> tuple[int, int]:
    """Return the numbers of two modes, the lower first."""
    first, second = sorted((int(modes.numbers[i]), int(modes.numbers[j])))
    return first, second


def _buckles(modes: _MeanModes) -> Bools:
    """Return which modes of the mean system grow without oscillating."""
    return np.asarray((modes.poles.real > 0.0) & (modes.poles.imag == 0.0))


def _off(exponent: complex, angle: Any, w: float) -> Any:
    """Return the distance of the exponent's frequency from an angle, modulo w, over w."""
    return abs((exponent.imag - angle + 0.5 * w) % w - 0.5 * w) / w
