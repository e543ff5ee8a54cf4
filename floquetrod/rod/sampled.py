"""Where coupled modes grow along one quantity of the load: sampled, and every change found located by bisection.

No count tells how many boundaries lie between two loads when modes are coupled, so that an unstable part narrower than
the distance of two samples may be missed; results say how wide that is.  Samples are evenly spaced, and more are taken
where the modes that may resonate, most often far fewer than all, grow faster than between them: freed of its damping a
tongue is wider than the part of it that outgrows the damping, about four times the largest growth in frequency.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.roots import bisected
from floquetrod.equations import HillSystem
from floquetrod.floquet.systems.result import Resonance
from floquetrod.rod.load import Load, Loads, Progress, Quantity
from floquetrod.rod.mode_systems import ModeSystems
from floquetrod.systems.arrays import verdicts

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

SAMPLES = 257  # of a search between bounds, or of a piece of a search for a margin (a choice)
_SPARSE = 32  # steps of the latter between samples of all modes, unless fewer modes tell of more (a choice)
_AT_ONCE = 32  # samples between two reports of progress
_ACCURACY = 1e-10  # relative, of a change
_BISECTIONS = 25  # about how many verdicts a change costs
_IN_REACH = 2.5  # frequencies of the load up to which a mode may resonate: to order five (a choice)
_FEWEST = 4  # modes that are asked in place of all (a choice)
_ABOUT = np.arange(-8, 9) / 2.0  # samples about where all modes do not answer as few did (a choice)
_CLOSER, _ROUNDS = 9, 2  # places between the neighbours of an extremum, each time it is looked at more closely
_MOST_EXTREMA = 16  # that are looked at more closely, those next to the level first (a choice)
_MOST_BISECTING = 3.0  # times as long as its samples that a change may take to be located (a choice)


@dataclass(frozen=True)
class UnstablePart:
    """A part that is not stable between ``low`` and ``high``, and what grows just inside each end, if it has a name."""

    low: float
    high: float
    low_cause: Resonance | Literal["unnamed"]
    high_cause: Resonance | Literal["unnamed"]


def unstable_parts(
    varied: Quantity,
    modes: ModeSystems,
    load: Load,
    bounds: tuple[float, float],
    tolerance: float,
    progress: Progress | None = None,
    samples: int = SAMPLES,
) -> tuple[list[UnstablePart], float]:
    """Return the parts of ``bounds`` that are not stable, in order, and the distance of samples."""
    search = _Search(varied, modes, load, tolerance)
    even = np.linspace(*bounds, samples)
    answers = []
    for start in range(0, even.size, _AT_ONCE):
        answers.append(search.stable(even[start : start + _AT_ONCE]))
        if progress is not None:
            progress(min(start + _AT_ONCE, even.size), even.size)
    places, stable = search.completed(even, np.concatenate(answers), even)
    inside, _ = search.changes(places, stable)
    ends = dict(zip(np.flatnonzero(stable[1:] != stable[:-1]).tolist(), inside.tolist(), strict=True))
    parts: list[UnstablePart] = []
    runs = np.flatnonzero(np.diff(np.concatenate([[True], stable, [True]]).astype(np.int8)))
    for first, after in zip(runs[::2].tolist(), runs[1::2].tolist(), strict=True):
        low, high = ends.get(first - 1, bounds[0]), ends.get(after - 1, bounds[1])
        # Named where something is sure to grow: at the samples next to the ends; an end of the search needs no name.
        causes = (
            "unnamed" if at_end else _cause(varied, modes, load, float(places[i]))
            for i, at_end in ((first, first == 0), (after - 1, after == places.size))
        )
        parts.append(UnstablePart(float(low), float(high), *causes))
    return parts, float(even[1] - even[0])


class Change(NamedTuple):
    """Where the verdict first changes, None where it is seen not to, up to where was searched, and how finely."""

    at: float | None
    searched: float
    resolution: float


def first_change(
    varied: Quantity,
    modes: ModeSystems,
    load: Load,
    piece: tuple[float, float],
    tolerance: float,
    *,
    begins_stable: bool | None = None,
    most_seconds: float = math.inf,
) -> Change:
    """Return where the verdict first changes from ``piece[0]`` to ``piece[1]``.

    ``begins_stable`` is the verdict it changes from, that at ``piece[0]`` by default.  Samples are further apart where
    that many would take more than ``most_seconds``, as estimated; nothing is searched where even few would.
    """
    search = _Search(varied, modes, load, tolerance)
    steps = SAMPLES - 1 if math.isinf(most_seconds) else search.affordable(piece, most_seconds) // _SPARSE * _SPARSE
    if not steps:
        return Change(None, piece[0], 0.0)
    places = np.linspace(*piece, steps + 1)
    step = places[1] - places[0]
    sparse = places[::_SPARSE]
    sparse_stable = search.stable(sparse)
    seen, stable = search.completed(sparse, sparse_stable, places)
    begins = bool(stable[0]) if begins_stable is None else begins_stable
    differ = np.flatnonzero(stable != begins)
    if not differ.size:
        return Change(None, piece[1], abs(float(step)))
    last = int(differ[0]) + 1
    if last == 1:
        return Change(piece[0], piece[0], abs(float(step)))
    found, _ = search.changes(seen[last - 2 : last], stable[last - 2 : last])
    return Change(float(found[0]), float(found[0]), abs(float(step)))


class _Search(NamedTuple):
    """What is asked along one quantity of a load: where coupled modes grow faster than a tolerance."""

    varied: Quantity
    modes: ModeSystems
    load: Load
    tolerance: float

    def stable(self, places: Floats) -> Bools:
        """Return where all modes are stable."""
        loads = Loads.along(self.load, self.varied, places)
        return np.equal(self.modes.answers(loads, self.tolerance, quick=True).status, 1)

    def changes(self, places: Floats, stable: Bools) -> tuple[Floats, Floats]:
        """Return where verdicts of neighbouring places change: the last stable place, and the first that is not."""
        at = [i for i, (one, other) in enumerate(pairwise(stable.tolist())) if one != other]
        good = np.array([places[i] if stable[i] else places[i + 1] for i in at])
        bad = np.array([places[i + 1] if stable[i] else places[i] for i in at])
        if not at:
            return good, bad
        return bisected(self.stable, good, bad, 50, relative=_ACCURACY)

    def completed(self, places: Floats, stable: Bools, closer: Floats) -> tuple[Floats, Bools]:
        """Return places and answers with those where the modes that may resonate tell of a part without a place.

        These few modes are asked at the places ``closer`` and about their extrema.
        """
        level = self.modes.damping_rate + self.tolerance
        at, growth = _with_extrema(self._growth_of_few, closer, self._growth_of_few(closer), level)
        grows = growth > level
        ends = np.flatnonzero(np.diff(grows)) + 1
        more: list[float] = []
        expected: list[bool] = []
        for run in np.split(np.arange(at.size), ends):
            low, high = sorted((at[run[0]], at[run[-1]]))
            here = (places >= low) & (places <= high)
            if not (stable[here] != grows[run[0]]).any():
                expected.append(not grows[run[0]])
                more.append(at[run[growth[run].argmax()]] if grows[run[0]] else at[run[run.size // 2]])
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

    def affordable(self, piece: tuple[float, float], seconds: float) -> int:
        """Return how many steps of a piece take no more than some seconds, as estimated."""
        ends = self.modes.system(Loads.along(self.load, self.varied, np.array(piece)))
        fastest = np.sqrt(np.abs(np.linalg.eigvalsh(ends.stiffness)).max(axis=1))
        phase = 0.5 * float((fastest * ends.period).max())
        few = self._few(Loads.along(self.load, self.varied, np.array(piece))).order
        each = phase * _cost(ends.order)
        if _BISECTIONS * each > _MOST_BISECTING * seconds:
            return 0
        per_step = each / _SPARSE + math.pi * _IN_REACH * len(self.load.harmonics) * _cost(few)
        return int(min(SAMPLES - 1, seconds / per_step))

    def _growth_of_few(self, places: Floats) -> Floats:
        """Return the growth in 1/s of the modes that may resonate, freed of their damping; infinite where unknown."""
        found = []
        for start in range(0, places.size, _AT_ONCE):
            system = self._few(Loads.along(self.load, self.varied, places[start : start + _AT_ONCE]))
            growth = verdicts((system.undamped or (system, 0.0))[0], quick=True).growth
            found.append(np.where(np.isnan(growth), np.inf, growth))
        return np.concatenate(found)

    def _few(self, loads: Loads) -> HillSystem:
        """Return the systems of the lowest modes under the mean force.

        They reach up to the highest mode that may resonate, or whose stiffness the vibration may outweigh.
        """
        every = self.modes.system(loads)
        squared, shapes = np.linalg.eigh(every.stiffness)
        vibration = sum(
            (np.linalg.norm(part, 2, axis=(-2, -1)) for part in every.cosines + every.sines), 0.0 * loads.mean
        )
        reach = _IN_REACH * len(self.load.harmonics) * loads.frequency
        count = int((squared <= np.maximum(reach**2, 2.0 * vibration)[:, None]).sum(axis=1).max())
        shapes = shapes[:, :, : max(count, _FEWEST)]

        def projected(matrix: Floats) -> Floats:
            return np.asarray(shapes.swapaxes(1, 2) @ matrix @ shapes)

        rate = self.modes.damping_rate
        return HillSystem(
            projected(every.stiffness),
            [projected(part) for part in every.cosines],
            [projected(part) for part in every.sines],
            damping=2.0 * rate * np.eye(shapes.shape[2]) if rate else None,
            period=every.period,
        )


def _cost(modes: int) -> float:
    """Return about how many seconds a verdict takes for each radian of the fastest of so many modes (measured)."""
    return 1e-6 + 3e-7 * modes * modes


def _with_extrema(
    values: Callable[[Floats], Floats], places: Floats, found: Floats, level: float
) -> tuple[Floats, Floats]:
    """Return places and values with others about the extrema that may lie beyond the level, in the same order."""
    begin, nearest = places[0], math.log(max(level, sys.float_info.min))
    for _ in range(_ROUNDS):
        inner, left, right = found[1:-1], found[:-2], found[2:]
        below = (inner > 0.0) & (inner <= level) & (inner >= left) & (inner > right)
        above = (inner > level) & (inner <= left) & (inner < right)
        at = np.flatnonzero(below | above) + 1
        at = at[np.argsort(np.abs(np.log(found[at]) - nearest), kind="stable")[:_MOST_EXTREMA]]
        if not at.size:
            break
        more = np.linspace(places[at - 1], places[at + 1], _CLOSER + 2)[1:-1].ravel()
        every, all_values = np.concatenate([places, more]), np.concatenate([found, values(more)])
        _, order = np.unique(np.abs(every - begin), return_index=True)
        places, found = every[order], all_values[order]
    return places, found


def _cause(varied: Quantity, modes: ModeSystems, load: Load, at: float) -> Resonance | Literal["unnamed"]:
    """Return the fastest resonance at a place, "unnamed" where there is no name for it."""
    named = modes.resonances(load.varied(varied, at))
    return named[0] if named else "unnamed"
