"""Stability intervals along one quantity of the load, sampled piece by piece."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from floquetrod._util.calling import level_of_caller
from floquetrod._util.progress import Progress, shifted
from floquetrod._util.spans import Gap, complement
from floquetrod.floquet.first_change import FirstChange
from floquetrod.floquet.status import UndecidedWarning
from floquetrod.rod.answers.search_pieces import ends_between
from floquetrod.rod.answers.stability_intervals import (
    BucklingWarning,
    Search,
    StabilityInterval,
    StabilityIntervals,
    intervals_along,
)
from floquetrod.rod.loads.axial import AxialGap, AxialResonanceError, axial_response, gaps, joined
from floquetrod.rod.loads.load import LOAD, Load, Loads, Quantity
from floquetrod.rod.mode_equations.coupled_samples import SAMPLES, SampledInterval, first_growth_change, unstable_parts
from floquetrod.rod.mode_equations.coupled_systems import CoupledEquations
from floquetrod.rod.model.contact import added_mean
from floquetrod.rod.modes.mode_model import ModeModel

_GROUPS = 16  # of neighbouring frequencies of a wave, each with its own number of modes (a choice)
_LEAST_SAMPLES = 9  # of each (a choice)
_HALVINGS = 4  # of one that needs too many modes: what is left of it, a sixteenth, is not computed


def zero_unless_stable(model: ModeModel, search: Search) -> FirstChange | None:
    """Return that a quantity of zero is the limit, with a warning that says why, where the rod is not stable there."""
    varied, largest, _, tolerance = search
    none = largest.varied(varied, 0.0)
    modes = _modes(model, search._replace(bounds=(0.0, 0.0)))
    status = modes.answers(Loads.single(none), tolerance, quick=True).status[0]
    if status == 1:
        return None
    _say_why_at_zero(model, varied, modes, none, status)
    return FirstChange(0.0, 0.0, 0.0)


def sampled_first_growth(model: ModeModel, search: Search, progress: Progress | None = None) -> FirstChange:
    """Return where something first grows within bounds, from the low one up, where nothing does."""
    varied, largest, piece, tolerance = search
    modes = _modes(model, search)
    return first_growth_change(varied, modes, largest, piece, tolerance, begins_stable=True, progress=progress)


def _say_why_at_zero(model: ModeModel, varied: Quantity, modes: CoupledEquations, load: Load, status: int) -> None:
    """Warn where the weight along the rod buckles it before the quantity grows from zero, or where that is not known.

    BucklingWarning, UndecidedWarning.
    """
    name = LOAD[varied].words
    if status == -1:
        warnings.warn(
            f"whether the rod is stable without {name} could not be decided, and counts as unstable",
            UndecidedWarning,
            stacklevel=level_of_caller(),
        )
        return
    added = [float(added_mean(model.rod, load, x)) for x in (0.0, 1.0)]
    alone = modes.static_answers(np.array([0.0, load.mean])).status
    if not any(added) or alone[1] != 0:
        return
    end = "upper" if added[0] > added[1] else "lower"
    what, force = "the weight along the rod alone buckles", max(added)
    if alone[0] != 0:
        what, force = "the mean force with the weight along the rod buckles", load.mean + max(added)
    remedy = "another mean_at" if varied == "mean" else "less mean force, another mean_at"
    warnings.warn(
        f"{name} 0 is the limit: {what} it, with {force:.4g} N, {force / model.rod.critical_force:.3g} critical "
        f"forces, of compression at the {end} end; give {remedy} or a shorter length",
        BucklingWarning,
        stacklevel=level_of_caller(),
    )


def _modes(model: ModeModel, search: Search) -> CoupledEquations:
    """Return as many modes as all loads within bounds need."""
    loads = Loads.along(search.load, search.varied, np.linspace(*search.bounds, 33))
    return model.in_modes(model.count_for(loads, search.growth_tolerance))


class SampledPiece(NamedTuple):
    """A piece of a quantity that is sampled, with the source of its unstable intervals and the distance of samples."""

    low: float
    high: float
    steps: int  # in which its progress is reported
    unstable: Callable[[tuple[float, float], Progress | None], tuple[list[SampledInterval], float]]


def pieces_of(search: Search, unit: float) -> list[tuple[float, float]]:
    """Return the pieces in which a quantity is sampled: the pieces of a critical load for a force, ``unit`` in N."""
    ends = search.bounds if search.varied == "frequency" else ends_between(search.varied, search.bounds, unit)
    return list(pairwise(ends))


def joined_intervals(
    bounds: tuple[float, float], pieces: Sequence[SampledPiece], progress: Progress | None
) -> tuple[tuple[StabilityInterval, ...], float]:
    """Return the stability intervals of all pieces, and the largest distance of samples."""
    segments: list[tuple[tuple[float, float], list[SampledInterval]]] = []
    resolution, done, total = 0.0, 0, sum(piece.steps for piece in pieces)
    for low, high, steps, unstable in pieces:
        intervals, distance = unstable((low, high), shifted(progress, done, total - steps))
        resolution, done = max(resolution, distance), done + steps
        if segments and segments[-1][0][1] == low:
            (low, _), before = segments.pop()
            if before and intervals and before[-1].high == intervals[0].low:  # one interval, cut between two pieces
                first = before.pop()
                intervals[0] = replace(intervals[0], low=first.low, low_cause=first.low_cause)
            intervals = before + intervals
        segments.append(((low, high), intervals))
    stable = [_ended(_stable_between(gap), bounds) for segment in segments for gap in complement(*segment)]
    return tuple(stable), resolution


def sampled_ranges(model: ModeModel, search: Search, progress: Progress | None) -> StabilityIntervals:
    """Return the stability intervals of coupled modes, with the frequencies that axial resonances leave out."""
    varied, largest, bounds, tolerance = search
    skipped: list[AxialGap] = []
    if varied == "frequency" and not largest.is_uniform:
        pieces, skipped = _pieces_of_waves(model, search)
    else:
        pieces = [
            (piece, _modes(model, search._replace(bounds=piece)))
            for piece in pieces_of(search, model.rod.critical_force)
        ]

    def sampled(piece: tuple[float, float], modes: CoupledEquations) -> SampledPiece:
        # Along a force each piece has as many samples as the piece of a critical load.
        samples = _share(piece, bounds, SAMPLES, _LEAST_SAMPLES) if varied == "frequency" else SAMPLES
        search_piece = partial(unstable_parts, varied, modes, largest, tolerance, bounds, samples)
        return SampledPiece(*piece, samples - 1, search_piece)

    intervals, resolution = joined_intervals(bounds, [sampled(*piece) for piece in pieces], progress)
    most = max(modes.count for _, modes in pieces)
    return intervals_along(model, search, intervals, most, resolution, not_computed=tuple(skipped))


def _pieces_of_waves(
    model: ModeModel, search: Search
) -> tuple[list[tuple[tuple[float, float], CoupledEquations]], list[AxialGap]]:
    """Return pieces of neighbouring frequencies with as many modes as each needs, and the gaps at axial resonances.

    AxialResonanceError where they leave nothing.
    """
    rod, largest, bounds = model.rod, search.load, search.bounds
    skipped = gaps(largest, rod.axial_line, bounds)
    left_out = skipped.copy()
    pieces: list[tuple[tuple[float, float], CoupledEquations]] = []

    def add(piece: tuple[float, float], halvings: int) -> None:
        try:
            pieces.append((piece, _modes(model, search._replace(bounds=piece))))
        except AxialResonanceError:  # for all the damping there is
            middle = 0.5 * sum(piece)
            if halvings == 0:
                load = largest.varied("frequency", middle)
                here = axial_response(load, rod.axial_line, rod.critical_force).resonances
                left_out.append(AxialGap(*piece, min(here, key=lambda r: abs(r.frequency - middle))))
                return
            add((piece[0], middle), halvings - 1)
            add((middle, piece[1]), halvings - 1)

    for part in complement(bounds, skipped):
        for piece in pairwise(np.linspace(*part[:2], 1 + _share(part[:2], bounds, _GROUPS, 1)).tolist()):
            add(piece, _HALVINGS)
    if not pieces:
        model.count_for(Loads.single(largest), search.growth_tolerance)  # says why
    return pieces, joined(left_out)


def _share(part: tuple[float, float], bounds: tuple[float, float], number: int, least: int) -> int:
    """Return the share of a number that falls to a part of bounds."""
    return max(least, math.ceil(number * (part[1] - part[0]) / (bounds[1] - bounds[0])))


def _ended(part: StabilityInterval, bounds: tuple[float, float]) -> StabilityInterval:
    """Return an interval whose ends, where it ends at no resonance of modes and at no bound, are named."""
    low = "axial resonance" if part.low_end is None and part.low > bounds[0] else part.low_end
    high = "axial resonance" if part.high_end is None and part.high < bounds[1] else part.high_end
    return part._replace(low_end=low, high_end=high)


def _stable_between(gap: Gap[SampledInterval]) -> StabilityInterval:
    """Return the stability interval between two unstable ones, with the causes of its ends."""
    low_end = None if gap.before is None else gap.before.high_cause
    return StabilityInterval(gap.low, gap.high, low_end, None if gap.after is None else gap.after.low_cause)
