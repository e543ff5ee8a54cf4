"""Names of growing solutions: which natural frequencies of the mean system combine with the forcing.

A heuristic, except for one equation of second order, whose tongue is counted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Bools, Complexes, Floats
from floquetrod.equations import DelaySystem, HillSystem, PeriodicSystem
from floquetrod.equations.hill_system import in_first_order
from floquetrod.equations.pieces import fourier
from floquetrod.floquet.hill_count import hill_count
from floquetrod.floquet.verdict import Interval

Ints = NDArray[np.intp]

_HIGHEST_ORDER = 40  # of resonances searched for
_MOST_MODES = 200  # of a system whose resonances are named: their number grows with the square
_PER_ORDER = 0.05  # penalty of an order, in detuning relative to w: low orders grow faster
_UNCOUPLED = 0.2  # penalty, alike, where the harmonic of that order does not couple the modes
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
    system: HillSystem | PeriodicSystem | DelaySystem, exponents: Sequence[complex], *, of_orbit: bool = False
) -> tuple[Resonance, ...]:
    """Return the names of the growing solutions among ``exponents``, the fastest first, each name once.

    ``of_orbit`` says that the system is linearised along a periodic orbit, whose mean has no natural frequencies.
    """
    lowest = -_NOTHING / float(system.period)
    growing = [exponent for exponent in exponents if exponent.real > 0.0 and exponent.imag >= lowest]
    if isinstance(system, DelaySystem):
        return _by_multipliers(system, growing, ("hopf", "fold", "flip"))
    if of_orbit:
        return _by_multipliers(system, growing, ("Neimark-Sacker", "fold or branch point", "period doubling"))
    # The frequencies of second moments are sums and differences of the natural ones; complex modes have no conjugates.
    if system.MEANING or (isinstance(system, PeriodicSystem) and system.is_complex):
        return ()
    if growing and (tongue := _tongue(system)) is not None:
        kind: Literal["direct", "buckling"] = "direct" if tongue else "buckling"
        return (Resonance(kind, (1,), tongue, growing[0].real),)
    equations = system.order if isinstance(system, HillSystem) else 0.5 * system.order
    modes = _mean_modes(system) if growing and equations <= _MOST_MODES else None
    if modes is None or len(modes.poles) > _MOST_MODES:
        return ()
    differences = not isinstance(system, HillSystem) or system.gyroscopic is not None or not system.is_symmetric
    w = 2.0 * math.pi / float(system.period)
    names: dict[tuple[str, tuple[int, ...], int], Resonance] = {}
    pairs = _Pairs.of(modes, w, differences)
    for exponent in growing:
        candidates = [*_combinations(modes, pairs, exponent, w), *_of_the_mean(modes, exponent, w)]
        if candidates:
            best = min(candidates, key=lambda candidate: candidate[:3]).name
            names.setdefault((best.kind, best.modes, best.order), best)
    return tuple(names.values())


def _tongue(system: HillSystem | PeriodicSystem) -> int | None:
    """Return in which tongue of Hill's equation one equation of second order lies, its damping removed.

    None for other systems, with jumps, and where it lies in no tongue, or cannot be counted.
    """
    if not isinstance(system, HillSystem) or system.order > 1 or system.pieces:
        return None
    mass = 1.0 if system.mass is None else float(system.mass[0, 0])
    damping = 0.0 if system.damping is None else 0.5 * float(system.damping[0, 0]) / mass
    mean = damping**2 - float(system.stiffness[0, 0]) / mass
    harmonics = -np.asarray(system.harmonics, dtype=np.complex128)[:, 0, 0] / mass
    below = hill_count(mean, harmonics, 2.0 * math.pi / float(system.period)).below
    if below is None:
        return None
    interval = Interval.from_count(below)
    return interval.order if interval.kind == "tongue" else None


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


def _mean_modes(system: HillSystem | PeriodicSystem) -> _MeanModes | None:
    """Return the modes of the mean system; None where they cannot be computed."""
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
    return _MeanModes(values[up], up, partners, coupling)


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
        possible = ~_buckles(modes)[first]
        first, second = first[possible], second[possible]
        sums = _near(modes, f[first] + f[second], w, modes.up[first], modes.down[second])
        if not differences:
            return cls(first, second, *sums)
        orders, detuning, cost = _near(modes, f[second] - f[first], w, modes.up[first], modes.up[second])
        apart = orders, np.where((first == second)[:, None], math.inf, detuning), cost
        return cls(first, second, *(np.hstack(parts) for parts in zip(sums, apart, strict=True)))


def _combinations(modes: _MeanModes, pairs: _Pairs, exponent: complex, w: float) -> list[_Candidate]:
    """Return the best combination of modes with the forcing, by detuning and mismatch of the angle and the order."""
    f = modes.poles.imag
    first, second, orders = pairs.first, pairs.second, pairs.orders
    if not first.size:
        return []
    angle = np.minimum(_off(exponent, f, w), _off(exponent, -f, w))
    mismatch = np.repeat((angle[first] + angle[second])[:, None], orders.shape[1], axis=1)
    same = first == second
    mismatch[same] = 2.0 * _off(exponent, 0.5 * orders[same] * w, w)
    misfits = pairs.detuning + mismatch + pairs.cost + _PER_ORDER * orders
    # The first of the least, in the order of modes, kinds and orders.
    pair, column = divmod(int(np.where(np.isnan(misfits), math.inf, misfits).argmin()), misfits.shape[1])
    i, j, misfit = int(first[pair]), int(second[pair]), float(misfits[pair, column])
    if not misfit < math.inf:
        return []
    kind: Literal["direct", "sum", "difference"] = "direct" if i == j else "sum" if column < 3 else "difference"
    members = (i + 1,) if i == j else (i + 1, j + 1)
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


def _of_the_mean(modes: _MeanModes, exponent: complex, w: float) -> list[_Candidate]:
    """Return the candidates without forcing: buckling, and flutter, where two modes of the mean system have met."""
    poles, frequencies = modes.poles, modes.poles.imag
    candidates = []
    for i in np.flatnonzero(_buckles(modes)).tolist():
        misfit = _off(exponent, 0.0, w) + abs(poles[i].real - exponent.real) / w
        candidates.append(_Candidate(float(misfit), 0, i, Resonance("buckling", (i + 1,), 0, exponent.real)))
    for i, pole in enumerate(poles):
        if pole.real > _NOTHING * abs(pole) and pole.imag > 0.0 and len(poles) > 1:
            j = min((k for k in range(len(poles)) if k != i), key=lambda k: abs(frequencies[k] - pole.imag))
            members = (min(i, j) + 1, max(i, j) + 1)
            misfit = _off(exponent, pole.imag, w)
            candidates.append(_Candidate(float(misfit), 1, i, Resonance("difference", members, 0, exponent.real)))
    return candidates


def _buckles(modes: _MeanModes) -> Bools:
    """Return which modes of the mean system grow without oscillating."""
    return np.asarray((modes.poles.real > 0.0) & (modes.poles.imag == 0.0))


def _off(exponent: complex, angle: Any, w: float) -> Any:
    """Return the distance of the exponent's frequency from an angle, modulo w, over w."""
    return abs((exponent.imag - angle + 0.5 * w) % w - 0.5 * w) / w
