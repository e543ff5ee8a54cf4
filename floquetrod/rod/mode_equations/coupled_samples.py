"""Where coupled modes grow along one quantity of the load: sampled, and every change located by bisection.

No count tells how many boundaries lie between two loads when modes are coupled, so that an unstable part narrower than
the distance of two samples may be missed; results say how wide that is.  Samples are evenly spaced, and more are taken
where the modes that may resonate, most often far fewer than all, grow faster than between them: without damping a
tongue is wider than the part of it that outgrows the damping, about four times the largest growth in frequency.

Along a force, ranges and critical loads take the same samples: the first stable interval above zero ends at the
critical load.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.progress import Progress
from floquetrod._util.spans import runs
from floquetrod.equations import HillSystem
from floquetrod.equations.matrices import mirrored
from floquetrod.floquet.first_change import FirstChange, Locate, changes, first_change
from floquetrod.floquet.multipliers.resonance_names import Resonance
from floquetrod.rod.loads.load import Load, Loads, Quantity
from floquetrod.rod.mode_equations.coupled_systems import CoupledEquations
from floquetrod.systems.batch_verdicts import verdicts

SAMPLES = 257  # of a search between bounds, or of a piece of a search for a margin (a choice)
_AT_ONCE = 128  # steps between samples of all modes, unless fewer modes tell of more, and between reports (a choice)
_ACCURACY = 1e-10  # relative, of a change
_MOST_STEPS = 80  # to it: most often about ten
_EVERY = 4  # steps along a force between samples of all modes, where time does not matter (a choice)
_UNTOLD = 2.0  # seconds between two reports, about (a choice)
_CLOSE_LOOKS = 1.5  # verdicts of few modes for each step: some are examined more closely
_FEWEST_STEPS = 8  # of a search: with fewer it tells little (a choice)
_IN_REACH = 2.5  # frequencies of the load up to which a mode may resonate: to order five (a choice)
_NEAR = 0.2  # frequencies of the load about half of it within which modes grow fast (a choice)
_RULED = 5.0  # squared frequency over vibration up to which a mode is no follower of others (a choice)
_FEWEST = 4  # modes that are asked in place of all
_STRONGEST = 8  # harmonics of a load whose vibration of modes far above is taken into account
# Of a quantity, beyond a change, where growth is examined: tenfold by two, then by thousandths (a choice).
_BEYOND = np.append(np.logspace(-6.0, -3.0, 7), np.linspace(2e-3, 1e-2, 9))
_IN_A_BAND = 17  # places in a thin band at which growth is examined (a choice)
_MOST_SECONDS = 2.0  # for all of them (a choice)
_ABOUT = np.arange(-8.0, 9.0)  # steps from where all modes do not answer as few did, asked of all (a choice)
_CLOSER, _ROUNDS = 9, 2  # places between the neighbours of an extremum, each time it is examined more closely
_MOST_EXTREMA = 16  # that are examined more closely, those next to the level first (a choice)


@dataclass(frozen=True)
class SampledInterval:
    """An interval that is not stable, from samples, and the name of what grows just inside each end, if it has one."""

    low: float
    high: float
    low_cause: Resonance | Literal["unnamed"]
    high_cause: Resonance | Literal["unnamed"]


def unstable_intervals(
    values: Floats,
    stable: Bools,
    locate: Locate,
    piece: tuple[float, float],
    cause: Callable[[float, float], Resonance | Literal["unnamed"]] = lambda at, end: "unnamed",
) -> list[SampledInterval]:
    """Return the unstable intervals of a piece, in order, from samples in increasing order.

    ``cause(at, end)`` names the resonance that grows at the unstable sample ``at`` next to the ``end`` of an interval.
    """
    ends = dict(zip(np.flatnonzero(np.diff(stable)).tolist(), changes(values, stable, locate).tolist(), strict=True))
    intervals = []
    for first, after in runs(~stable):
        low, high = float(ends.get(first - 1, piece[0])), float(ends.get(after - 1, piece[1]))
        causes = cause(float(values[first]), low), cause(float(values[after - 1]), high)
        intervals.append(SampledInterval(low, high, *causes))
    return intervals


def unstable_parts(
    varied: Quantity,
    modes: CoupledEquations,
    load: Load,
    tolerance: float,
    bounds: tuple[float, float],
    samples: int,
    piece: tuple[float, float],
    progress: Progress | None = None,
) -> tuple[list[SampledInterval], float]:
    """Return the unstable intervals of ``piece``, in order, and the distance of samples.

    An end of the piece that is an end of ``bounds`` has no name.
    """
    search = _CoupledSamples(varied, modes, load, tolerance)
    even = np.linspace(*piece, samples)
    steps = _Spacing(even.size - 1, 1)
    if varied != "frequency":  # the steps of a critical load
        steps = _Spacing(search.costs(piece, grows=False).at_once, _EVERY)
    blocks = list(search.blocks(even, steps, progress=progress))
    values = np.concatenate([blocks[0][0][:1], *(block[1:] for block, _ in blocks)])
    stable = np.concatenate([blocks[0][1][:1], *(answers[1:] for _, answers in blocks)])

    def cause(at: float, end: float) -> Resonance | Literal["unnamed"]:
        return "unnamed" if end in bounds else _cause(varied, modes, load, at)

    return unstable_intervals(values, stable, search.locate, piece, cause), float(even[1] - even[0])


def first_growth_change(
    varied: Quantity,
    modes: CoupledEquations,
    load: Load,
    piece: tuple[float, float],
    tolerance: float,
    *,
    begins_stable: bool | None = None,
    most_seconds: float = math.inf,
    progress: Progress | None = None,
) -> FirstChange:
    """Return where the verdict on coupled modes first changes from ``piece[0]`` to ``piece[1]``.

    ``begins_stable`` is the verdict it changes from, that at ``piece[0]`` by default.  Samples are further apart where
    that many would take more than ``most_seconds``, as estimated; nothing is searched where even few would.
    ``progress`` is called with the numbers of samples examined and to examine.
    """
    search = _CoupledSamples(varied, modes, load, tolerance)
    if not search.costs(piece, grows=not begins_stable).steps(most_seconds):
        return FirstChange(None, piece[0], 0.0)
    here = search.stable(np.array(piece[:1])) if begins_stable is None else None
    begins = bool(begins_stable if here is None else here[0])
    costs = search.costs(piece, grows=not begins)
    steps = costs.steps(most_seconds)
    if not steps:
        return FirstChange(None, piece[0], 0.0, costs.each)
    values = np.linspace(*piece, steps + 1)
    distances = _Spacing(costs.at_once, _EVERY if math.isinf(most_seconds) else costs.at_once)
    blocks = search.blocks(values, distances, here, grows=not begins, progress=progress)
    change = first_change(blocks, begins, search.locate, piece, abs(float(values[1] - values[0])))
    return change._replace(seconds=costs.seconds(steps))


class GrowthBeyond(NamedTuple):
    """Growth just beyond a change, in 1/s, its cause, and whether it ends within a hundredth of the quantity."""

    cause: Resonance | Literal["unnamed"]
    growth: float
    is_thin: bool


def growth_beyond(
    varied: Quantity, modes: CoupledEquations, load: Load, tolerance: float, piece: tuple[float, float]
) -> GrowthBeyond | None:
    """Return the growth beyond a change at ``piece[0]``, towards ``piece[1]``; None without, or where it takes long.

    It is sampled up to a hundredth of the quantity; if it is stable at one of these places, more closely up to there.
    A stable part narrower than their distance may be missed: the band is then taken to be wider.
    """
    edge, end = piece
    each = _CoupledSamples(varied, modes, load, tolerance).costs(piece, grows=True).each
    if each * (_BEYOND.size + _IN_A_BAND) > _MOST_SECONDS:
        return None
    offsets = np.copysign(_BEYOND * abs(edge), end - edge)
    offsets = offsets[abs(offsets) <= abs(end - edge)]
    if not offsets.size:
        return None
    status, growth = modes.answers(Loads.along(load, varied, edge + offsets), tolerance, quick=True)
    stable = np.flatnonzero(status == 1)
    is_thin = bool(stable.size)
    if is_thin:
        offsets = np.linspace(0.0, offsets[stable[0]], _IN_A_BAND + 2)[1:-1]
        growth = modes.answers(Loads.along(load, varied, edge + offsets), tolerance, quick=True).growth
    growth = np.where(np.isnan(growth), 0.0, growth)
    most = int(growth.argmax())
    if growth[most] <= 0.0:
        return None
    return GrowthBeyond(_cause(varied, modes, load, float(edge + offsets[most])), float(growth[most]), is_thin)


class _Spacing(NamedTuple):
    """How many steps a block of samples has, and how many lie between samples of all modes."""

    at_once: int
    every: int


class _CoupledSamples(NamedTuple):
    """Samples along one quantity of a load: where coupled modes grow faster than a tolerance."""

    varied: Quantity
    modes: CoupledEquations
    load: Load
    tolerance: float

    def stable(self, places: Floats) -> Bools:
        """Return where all modes are stable."""
        return np.equal(self.modes.answers(self._loads(places), self.tolerance, quick=True).status, 1)

    @property
    def level(self) -> float:
        """Growth in 1/s, with damping removed, up to which loads are stable."""
        return self.modes.damping_rate + self.tolerance

    def _loads(self, places: Floats) -> Loads:
        return Loads.along(self.load, self.varied, places)

    def blocks(
        self,
        places: Floats,
        steps: _Spacing,
        first: Bools | None = None,
        *,
        grows: bool = False,
        progress: Progress | None = None,
    ) -> Iterator[tuple[Floats, Bools]]:
        """Yield samples, more where few modes show growth between them, and their stability, block by block in order.

        Neighbouring blocks share a place.  ``first`` is the verdict at the first place where it is known.
        """
        known = np.zeros(0, dtype=np.bool_) if first is None else first
        for start in range(0, places.size - 1, steps.at_once):
            closer = places[start : start + steps.at_once + 1]
            chosen = np.append(np.arange(0, closer.size - 1, steps.every), closer.size - 1)
            while known.size < chosen.size:
                known = np.append(known, self.stable(closer[chosen[known.size : known.size + _AT_ONCE]]))
                if progress is not None:
                    progress(start + int(chosen[known.size - 1]), places.size - 1)
            seen, stable = self.completed(closer[chosen], known, closer, grows=grows)
            yield seen, stable
            known = stable[-1:]

    def locate(self, good: Floats, bad: Floats) -> Floats:
        """Return the last stable values between stable and unstable ones."""
        return np.array([self._change(*ends) for ends in zip(good.tolist(), bad.tolist(), strict=True)])

    def _change(self, good: float, bad: float) -> float:
        """Return the last stable place between one that is stable and one that is not."""
        damping = self.modes.damping_rate
        secants = _Secants(self.level**2)
        widths = [math.inf] * 3
        for _ in range(_MOST_STEPS):
            width = abs(bad - good)
            if width <= _ACCURACY * abs(bad):
                break
            halve = width > 0.5 * widths.pop(0)
            widths.append(width)
            at = 0.5 * (good + bad) if halve else secants.proposal(good, bad)
            status, growth = self.modes.answers(self._loads(np.array([at])), self.tolerance, quick=True)
            if status[0] == 1:
                good = at
            else:
                bad = at
            if growth[0] > 0.0:
                secants.add(at, (damping + float(growth[0])) ** 2)
        return good

    def completed(self, places: Floats, stable: Bools, closer: Floats, *, grows: bool = False) -> tuple[Floats, Bools]:
        """Return samples and their stability, with more where the modes that may resonate show an interval without one.

        These few modes are asked at the places ``closer`` and about their extrema; where most places are expected to
        grow, first the fewer that may do so fast.
        """
        level = self.level

        def values(at: Floats) -> Floats:
            growth = self._growth_of_few(at, self._fast if grows else self._in_reach)
            slow = growth <= level
            if grows and slow.any():
                growth[slow] = self._growth_of_few(at[slow], self._in_reach)
            return growth

        at, growth = _with_extrema(values, closer, values(closer), level)
        above = growth > level
        ends = np.flatnonzero(np.diff(above)) + 1
        more: list[float] = []
        expected: list[bool] = []
        for run in np.split(np.arange(at.size), ends):
            low, high = sorted((at[run[0]], at[run[-1]]))
            here = (places >= low) & (places <= high)
            if not (stable[here] != above[run[0]]).any():
                expected.append(not above[run[0]])
                more.append(at[run[growth[run].argmax()]] if above[run[0]] else at[run[run.size // 2]])
        if not more:
            return places, stable
        at_once = np.array(more)
        told = self.stable(at_once)
        moved = at_once[told != np.array(expected)]  # few modes have it elsewhere, or all of them not at all
        about = moved[:, None] + (closer[1] - closer[0]) * _ABOUT
        about = np.clip(about.ravel(), closer.min(), closer.max())
        every = np.concatenate([places, at_once, about])
        answers = np.concatenate([stable, told, self.stable(about) if about.size else told[:0]])
        _, order = np.unique(np.abs(every - places[0]), return_index=True)
        return every[order], answers[order]

    def costs(self, piece: tuple[float, float], *, grows: bool) -> _SearchCosts:
        """Return the costs of verdicts on a piece, expected to grow or not."""
        loads = self._loads(np.array(piece))
        each = _seconds(self.modes.system(loads))
        step = 0.1 * each + _CLOSE_LOOKS * _seconds(self._few(loads, self._fast if grows else self._in_reach))
        return _SearchCosts(each, step)

    @property
    def _in_reach(self) -> tuple[float, float]:
        """Frequencies of the load between which natural frequencies may resonate."""
        return -math.inf, _IN_REACH * len(self.load.harmonics)

    @property
    def _fast(self) -> tuple[float, float]:
        """Frequencies of the load between which modes resonate alone, or nearly, to order one."""
        return 0.5 - _NEAR, 0.5 * len(self.load.harmonics) + _NEAR

    def _growth_of_few(self, places: Floats, reach: tuple[float, float]) -> Floats:
        """Return the undamped growth in 1/s of the modes that may resonate; infinite where unknown."""
        growths = []
        for start in range(0, places.size, _AT_ONCE):
            system = self._few(self._loads(places[start : start + _AT_ONCE]), reach)
            growth = verdicts(_freed(system), quick=True).growth
            growths.append(np.where(np.isnan(growth), np.inf, growth))
        return np.concatenate(growths)

    def _few(self, loads: Loads, reach: tuple[float, float]) -> HillSystem:
        """Return the systems of a few modes under the mean force: the lowest, and modes in reach or ruled.

        In reach are natural frequencies between so many frequencies of the load; the vibration rules modes whose
        stiffness it may outweigh.
        """
        every = self.modes.system(loads)
        means = every.stiffness if self.varied == "mean" else every.stiffness[:1]  # the same at all places
        squared, shapes = np.linalg.eigh(means)
        strongest = slice(None) if self.varied == "frequency" else [loads.amplitude.argmax()]
        vibration = sum(np.linalg.norm(part[strongest] @ shapes, axis=1) for part in every.cosines + every.sines)
        low, high = (share * loads.frequency[:, None] for share in reach)
        chosen = (squared <= _RULED * vibration) | ((squared >= low * abs(low)) & (squared <= high**2))
        chosen = chosen.any(axis=0)
        chosen[:_FEWEST] = True
        few, others = shapes[:, :, chosen], shapes[:, :, ~chosen]

        def projected(matrix: Floats) -> Floats:
            return mirrored(few.swapaxes(1, 2) @ matrix @ few)  # half a period is then enough

        followed = _followed(every.harmonics, few, others, squared[:, ~chosen])
        rate = self.modes.damping_rate
        return HillSystem(
            projected(every.stiffness) - followed[0].real,
            _less([projected(part) for part in every.cosines], [2.0 * part.real for part in followed[1:]]),
            _less([projected(part) for part in every.sines], [-2.0 * part.imag for part in followed[1:]]),
            damping=2.0 * rate * np.eye(few.shape[2]) if rate else None,
            period=every.period,
        )


def _followed(
    harmonics: NDArray[np.complex128], few: Floats, others: Floats, squared: Floats
) -> list[NDArray[np.complex128]]:
    """Return by how much the vibration of other modes softens a few: the terms of exp(i k w t), k = 0, 1, ...

    The others, of natural frequencies far above, follow at once what couples them to the few, K_of(t): they take
    K_of(t)^T K_oo^-1 K_of(t) from the stiffness of the few.  Without that, resonances of the few are displaced where
    the vibration is strong.  The strongest harmonics do it; of their products the terms up to the last harmonic of the
    load are returned, and the first few in any case.
    """
    strongest = np.argsort(-(np.abs(harmonics) ** 2).sum(axis=(0, 2, 3)), kind="stable")[:_STRONGEST]
    waves: dict[int, NDArray[np.complex128]] = {}
    for k in strongest.tolist():
        wave = np.asarray(others.swapaxes(1, 2) @ (0.5 * harmonics[:, k]) @ few)
        waves[k + 1], waves[-k - 1] = wave, wave.conj()
    highest = min(2 * max(waves, default=0), max(harmonics.shape[1], 2 * _STRONGEST))
    terms = [np.zeros((len(harmonics), few.shape[2], few.shape[2]), complex) for _ in range(highest + 1)]
    for j, first_wave in waves.items():
        for k, second_wave in waves.items():
            if 0 <= j + k <= highest:
                terms[j + k] += first_wave.swapaxes(1, 2) @ (second_wave / squared[:, :, None])
    return [mirrored(term) for term in terms]


def _less(parts: list[Floats], taken: list[Floats]) -> list[Floats]:
    """Return harmonics less others."""
    differences = [harmonic - taken_harmonic for harmonic, taken_harmonic in zip(parts, taken, strict=False)]
    return differences + parts[len(taken) :] + [-taken_harmonic for taken_harmonic in taken[len(parts) :]]


class _SearchCosts(NamedTuple):
    """Estimated seconds of a verdict with all modes, and of a step examined with few; none depends on the machine."""

    each: float
    step: float

    @property
    def at_once(self) -> int:
        """Number of steps between verdicts with all modes, few enough that progress is reported repeatedly."""
        return int(min(_AT_ONCE, max(_FEWEST_STEPS, _UNTOLD / self.step)))

    def seconds(self, steps: int) -> float:
        """Return how long so many steps take in which nothing changes; where there is a change some verdicts more."""
        return steps * self.step + (1 + math.ceil(steps / self.at_once)) * self.each

    def steps(self, seconds: float) -> int:
        """Return how many steps take no more than some seconds, 0 where even few would."""
        most = min(SAMPLES - 1.0, (seconds - 2.0 * self.each) / (self.step + self.each / self.at_once))
        return int(most) if most >= _FEWEST_STEPS else 0


def _seconds(systems: HillSystem) -> float:
    """Return about how many seconds the longest verdict on some systems takes (measured)."""
    fastest = np.sqrt(np.abs(np.linalg.eigvalsh(systems.stiffness)).max(axis=1))
    phase = 0.5 * float((fastest * systems.period).max())
    each = 3e-7 if _freed(systems).even_form is None else 4e-8
    return 1e-4 + phase * (1e-6 + each * systems.order**2) + 2e-8 * systems.order**3


def _freed(systems: HillSystem) -> HillSystem:
    """Return systems with uniform damping removed."""
    return (systems.undamped or (systems, 0.0))[0]


class _Secants:
    """Where the squared growth, with damping removed, comes down to a level: at an edge it ends like a straight line.

    Only values with growth carry information, mostly on one side of the edge.  The proposal therefore lies beyond the
    secant's zero, seen from the nearer end of the bracket, by as much as the zero moved last: both ends close in on it.
    """

    def __init__(self, level: float) -> None:
        self.level = level
        self.known: list[tuple[float, float]] = []
        self.zero, self.moved = math.nan, math.nan

    def add(self, at: float, value: float) -> None:
        """Take a place with the squared growth there."""
        self.known = [*self.known[-1:], (at, value)]
        if len(self.known) < 2:
            return
        (x, fx), (y, fy) = self.known
        before = self.zero
        self.zero = y + (self.level - fy) * (y - x) / (fy - fx) if fx != fy else math.nan
        self.moved = abs(self.zero - (y if math.isnan(before) else before))

    def proposal(self, good: float, bad: float) -> float:
        """Return where to look next between two places: the middle where nothing better is known."""
        far = good if abs(bad - self.zero) < abs(good - self.zero) else bad
        at = self.zero + math.copysign(max(self.moved, 0.25 * _ACCURACY * abs(bad)), far - self.zero)
        return at if min(good, bad) < at < max(good, bad) else 0.5 * (good + bad)


def _with_extrema(
    values: Callable[[Floats], Floats], places: Floats, values_there: Floats, level: float
) -> tuple[Floats, Floats]:
    """Return places and values with others about the extrema that may lie beyond the level, in the same order."""
    begin, nearest = places[0], math.log(max(level, sys.float_info.min))
    for _ in range(_ROUNDS):
        inner, left, right = values_there[1:-1], values_there[:-2], values_there[2:]
        below = (inner > 0.0) & (inner <= level) & (inner >= left) & (inner > right)
        above = (inner > level) & (inner <= left) & (inner < right)
        at = np.flatnonzero(below | above) + 1
        at = at[np.argsort(np.abs(np.log(values_there[at]) - nearest), kind="stable")[:_MOST_EXTREMA]]
        if not at.size:
            break
        more = np.linspace(places[at - 1], places[at + 1], _CLOSER + 2)[1:-1].ravel()
        every, all_values = np.concatenate([places, more]), np.concatenate([values_there, values(more)])
        _, order = np.unique(np.abs(every - begin), return_index=True)
        places, values_there = every[order], all_values[order]
    return places, values_there


def _cause(varied: Quantity, modes: CoupledEquations, load: Load, at: float) -> Resonance | Literal["unnamed"]:
    """Return the fastest resonance at a place, "unnamed" where there is no name for it."""
    named = modes.resonances(load.varied(varied, at))
    return named[0] if named else "unnamed"
