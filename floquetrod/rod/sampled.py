"""Where coupled modes grow along one quantity of the load: sampled, and every change found located by bisection.

No count tells how many boundaries lie between two loads when modes are coupled, so that an unstable part narrower than
the distance of two samples may be missed; results say how wide that is.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.roots import bisected
from floquetrod.floquet.systems.result import Resonance
from floquetrod.rod.coupled import CoupledModes
from floquetrod.rod.load import Load, Loads, Progress, Quantity

Floats = NDArray[np.float64]

SAMPLES = 257  # of a search between bounds (a choice)
_MARGIN_SAMPLES = 17  # of each piece of a search for a margin (a choice)
_AT_ONCE = 32  # samples between two reports of progress
_ACCURACY = 1e-10  # relative, of a change


@dataclass(frozen=True)
class UnstablePart:
    """A part that is not stable between ``low`` and ``high``, and what grows just inside each end, if it has a name."""

    low: float
    high: float
    low_cause: Resonance | Literal["unnamed"]
    high_cause: Resonance | Literal["unnamed"]


def unstable_parts(
    varied: Quantity,
    modes: CoupledModes,
    load: Load,
    bounds: tuple[float, float],
    tolerance: float,
    progress: Progress | None = None,
    samples: int = SAMPLES,
) -> tuple[list[UnstablePart], float]:
    """Return the parts of ``bounds`` that are not stable, in order, and the distance of samples."""
    places = np.linspace(*bounds, samples)
    stable = np.empty(places.size, dtype=np.bool_)
    for start in range(0, places.size, _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        stable[part] = _stable(varied, modes, load, places[part], tolerance)
        if progress is not None:
            progress(min(start + _AT_ONCE, places.size), places.size)
    inside, _ = _changes(varied, modes, load, places, stable, tolerance)
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
    return parts, float(places[1] - places[0])


def first_change(
    varied: Quantity, modes: CoupledModes, load: Load, piece: tuple[float, float], tolerance: float
) -> float | None:
    """Return where the verdict first changes from ``piece[0]`` to ``piece[1]``; None where it is seen not to."""
    places = np.linspace(*piece, _MARGIN_SAMPLES)
    stable = _stable(varied, modes, load, places, tolerance)
    if (stable == stable[0]).all():
        return None
    last = int(np.argmax(stable != stable[0])) + 1
    found, _ = _changes(varied, modes, load, places[:last], stable[:last], tolerance)
    return float(found[0])


def _changes(
    varied: Quantity, modes: CoupledModes, load: Load, places: Floats, stable: NDArray[np.bool_], tolerance: float
) -> tuple[Floats, Floats]:
    """Return where verdicts of neighbouring places change: the last stable place, and the first that is not."""
    at = [i for i, (one, other) in enumerate(pairwise(stable.tolist())) if one != other]
    good = np.array([places[i] if stable[i] else places[i + 1] for i in at])
    bad = np.array([places[i + 1] if stable[i] else places[i] for i in at])
    if not at:
        return good, bad
    return bisected(lambda x: _stable(varied, modes, load, x, tolerance), good, bad, 50, relative=_ACCURACY)


def _stable(varied: Quantity, modes: CoupledModes, load: Load, places: Floats, tolerance: float) -> NDArray[np.bool_]:
    return np.equal(modes.answers(Loads.along(load, varied, places), tolerance, quick=True).status, 1)


def _cause(varied: Quantity, modes: CoupledModes, load: Load, at: float) -> Resonance | Literal["unnamed"]:
    """Return the fastest resonance at a place, "unnamed" where there is no name for it."""
    named = modes.resonances(load.varied(varied, at))
    return named[0] if named else "unnamed"
