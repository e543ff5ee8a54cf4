"""Which loads are stable: every stability interval of one quantity of the load, in order."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from decimal import ROUND_CEILING, Context
from itertools import pairwise
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.caching import cached_property
from floquetrod._util.calling import level_of_caller
from floquetrod._util.content import NoTruthValue
from floquetrod.floquet.systems.result import Resonance
from floquetrod.friction.fate_of_kicks import UndecidedWarning
from floquetrod.rod.assumptions import warn_unless_uniform
from floquetrod.rod.axial import AxialGap, AxialResonanceError, between, gaps, joined
from floquetrod.rod.coupled import CoupledModes
from floquetrod.rod.load import KINDS, Load, Loads, Progress, Quantity, shifted
from floquetrod.rod.modal import ModalRod
from floquetrod.rod.modes import ModalSystem
from floquetrod.rod.sampled import SAMPLES, UnstablePart, first_change, unstable_parts
from floquetrod.rod.tongues import UnstableLoads, unstable_loads
from floquetrod.rod.unstable_bands import Named, Searched, UnstableBand

QUANTITIES: dict[Quantity, tuple[str, str]] = {
    "mean": ("mean force", "N"),
    "amplitude": ("amplitude", "N"),
    "frequency": ("frequency", "rad/s"),
}
"""Name and unit of what may vary."""

_GROUPS = 16  # of neighbouring frequencies of a wave, each with its own number of modes (a choice)
_LEAST_SAMPLES = 9  # of each (a choice)
_HALVINGS = 4  # of one that needs too many modes (a choice)
_PIECES: dict[Quantity, int] = {"mean": 32, "amplitude": 8}  # that the first edge is searched in, one by one (a choice)


Cause: TypeAlias = Named | Literal["axial resonance"] | None
"""What closes a stability interval: (mode, tongue), a resonance of coupled modes, or None at an end of the search.

"axial resonance" where nothing was computed beyond it, see `StabilityIntervals.not_computed`.
"unnamed" where coupled modes grow, or may grow, and none could be named: beyond 200 of them, or where undecided.
"""


class BucklingWarning(UserWarning):
    """The weight along the rod buckles it already where the quantity asked about is zero."""


class StabilityInterval(NamedTuple):
    """Stable from ``low`` to ``high``; what closes each end is (mode, tongue), where modes are coupled a `Resonance`.

    "unnamed" where that could not be told; None at an end of the search.
    """

    low: float
    high: float
    low_end: Cause
    high_end: Cause


@dataclass(frozen=True, repr=False)
class StabilityIntervals(NoTruthValue):
    """All stability intervals of one quantity of the load within bounds.

    Attributes
    ----------
    quantity : str
        What varies: "mean force", "amplitude" or "frequency".
    unit : str
        Its unit: "N" or "rad/s".
    bounds : tuple of float
        Where was searched, (low, high).
    intervals : tuple of StabilityInterval
        In increasing order; nothing between them is stable but, perhaps, what is ``not_computed``.
    growth_tolerance : float
        Growth in 1/s up to which a mode counts as stable; resonance tongues that never exceed it are left out.
    modes : int
        Modes looked at, 1 to this; every higher mode grows at less than 1e-12 per second or the tolerance.
    hairlines : int
        Resonance tongues within the stability intervals in which a mode grows, but nowhere faster than the tolerance.
    resolution : float
        Unstable parts up to this width may have been missed, in ``unit``: 0 where the search is complete.
    searched : Searched
        Rod and load, from which `unstable` is computed.
    not_computed : tuple of AxialGap
        Frequencies, each with its low and high end and its ``resonance``, that are neither stable nor unstable here:
        waves without axial damping are too near an axial resonance, see `Rod.axial_response`, or waves with little of
        it make so large a force that it needs too many modes.

    Iterating gives the intervals; ``value in intervals`` asks whether a value is stable.
    """

    ask = "len(...) or .intervals: how many intervals are stable says nothing of a load"

    quantity: str
    unit: str
    bounds: tuple[float, float]
    intervals: tuple[StabilityInterval, ...]
    growth_tolerance: float
    modes: int
    hairlines: int
    resolution: float
    searched: Searched = field(repr=False, compare=False)
    not_computed: tuple[AxialGap, ...] = ()

    def __iter__(self) -> Iterator[StabilityInterval]:
        """Iterate over the intervals."""
        return iter(self.intervals)

    def __len__(self) -> int:
        """Return the number of intervals."""
        return len(self.intervals)

    def __contains__(self, value: Any) -> bool:
        """Return whether ``value`` is stable; an end of the search may be, an end of a tongue is not."""
        return any(
            part.low < value < part.high
            or (value == part.low and part.low_end is None)
            or (value == part.high and part.high_end is None)
            for part in self.intervals
        )

    @cached_property
    def unstable(self) -> tuple[UnstableBand, ...]:
        """What lies between the stability intervals, the fastest growth and the damping required there; computed once.

        Where modes are independent, growth is evaluated at 17 loads in every tongue of a band and refined about the
        largest: along the mean force, where growth in a tongue is concave (docs/theory/ranges.md), that is its maximum;
        along the others a second, narrower maximum in a tongue may be passed over.  The damping is sampled: at the same
        loads, and in all modes at the ends and in the middle of each band, refined about the largest.

        Where modes are coupled, growth is evaluated at 17 loads of each band and refined about the largest, to a
        thousandth of the band; the damping is that of this one load.
        """
        return self.find_unstable()

    def find_unstable(self, progress: Progress | None = None) -> tuple[UnstableBand, ...]:
        """Return `unstable`; ``progress`` is called with the numbers of bands looked into and to look into."""
        validate.progress(progress)
        known: tuple[UnstableBand, ...] | None = self.__dict__.get("unstable")
        if known is None:
            ends = [self.bounds[0], *(end for part in self.intervals for end in part[:2]), self.bounds[1]]
            pairs = zip(ends[::2], ends[1::2], strict=True)
            bands = [band for pair in pairs if pair[0] < pair[1] for band in between(pair, self.not_computed)]
            known = self.__dict__["unstable"] = self.searched.unstable_bands(bands, progress)
        return known

    @property
    def required_damping(self) -> float:
        """Largest damping rate in 1/s that any of the unstable bands requires, 0 without any, infinite beyond reach.

        As sampled, see `unstable`; of coupled modes, that of the load of fastest growth in each band.
        """
        return max((band.required_damping for band in self.unstable), default=0.0)

    @property
    def note(self) -> str:
        """What has been left out."""
        slow = max(self.growth_tolerance, 1e-12)
        text = f"modes 1 to {self.modes}; growth at or below {slow:g} 1/s does not count"
        if self.hairlines:
            text += f": {self.hairlines} tongue{'s' * (self.hairlines > 1)} left out"
        return text

    def __repr__(self) -> str:
        """Return the stability intervals as a table; `table` also says what happens between them."""
        return self._table(self.unit, 1.0, ())

    def table(self, unit: str | None = None, size: float | None = None) -> str:
        """Return what is stable and what is not, in order, in another unit: "Hz", "rpm", "kN", "Fcr".

        ``size`` is that of a unit of one's own in `unit`.  Behind unstable bands stand what grows fastest in it, how
        fast and where, and the damping required.  ValueError for units that are unknown.
        """
        wanted = self.unit if unit is None else unit
        if not isinstance(wanted, str):
            raise TypeError(f"unit must be a word such as 'Hz', got {validate.short(unit)}")
        if size is None:
            kind = KINDS[self.searched.varied]
            wanted, size = units.unit(wanted, "unit", kind, self.searched.rod.critical_force)
        size = validate.positive("size", size, "give it in the unit of the intervals")
        return self._table(wanted, size, self.unstable)

    def _table(self, unit: str, size: float, unstable: tuple[UnstableBand, ...]) -> str:
        low, high = (value / size for value in self.bounds)
        lines = [f"stable {self.quantity} in {unit}, between {low:.6g} and {high:.6g}"]
        rows = [(part.low, part.high, f"{_end(part.low_end)} ... {_end(part.high_end)}") for part in self.intervals]
        rows += _unstable_rows(unstable, size) if unstable else ()
        lines += [f"  {low / size:12.9g} to {high / size:12.9g}   {text}" for low, high, text in sorted(rows)]
        if not self.intervals:
            lines.append("  none")
        lines += [
            f"  {gap.low / size:12.9g} to {gap.high / size:12.9g}   not computed: axial resonance at "
            f"{gap.resonance.frequency / size:.6g}"
            for gap in self.not_computed
        ]
        if unstable:
            what = "that load" if self.searched.has_coupled_modes else "every sampled load of the band"
            lines += [
                f"  (unstable: fastest growth, where it occurs, and damping rate above which {what} is stable)",
                f"  (largest damping rate required: {_rounded_up(self.required_damping)})",
            ]
        if self.resolution:
            lines.append(f"  (unstable parts narrower than {self.resolution / size:.2g} {unit} may have been missed)")
        return "\n".join([*lines, f"  ({self.note})"])


def stability_intervals(
    varied: Quantity,
    rod: ModalRod,
    largest: Load,
    bounds: tuple[float, float],
    growth_tolerance: float,
    progress: Progress | None,
) -> StabilityIntervals:
    """Return the stability intervals of one quantity within ``bounds``, with as many modes as ``largest`` needs."""
    validate.progress(progress)
    tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
    name, unit = QUANTITIES[varied]
    warn_unless_uniform(rod, largest)
    if not rod.coupled_numbers.has_mathieu_modes(largest):
        closed, count, resolution, left_out = _coupled_intervals(varied, rod, largest, bounds, tolerance, progress)
        searched = Searched(rod, varied, largest, tolerance, count)
        return StabilityIntervals(name, unit, bounds, closed, tolerance, count, 0, resolution, searched, left_out)
    system = _system(rod, largest, tolerance)
    found = unstable_loads(varied, system, tolerance, bounds, union=True, progress=progress)
    intervals = tuple(_between(found, bounds))
    last = system.modes[-1]
    searched = Searched(rod, varied, largest, tolerance, last)
    return StabilityIntervals(
        name, unit, bounds, intervals, tolerance, last, found.hairlines, found.resolution, searched
    )


def first_unstable(varied: Quantity, rod: ModalRod, largest: Load, growth_tolerance: float) -> float:
    """Return where one quantity, going from zero to that of ``largest``, first meets growth; infinite without any."""
    tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
    warn_unless_uniform(rod, largest)
    if not rod.coupled_numbers.has_mathieu_modes(largest):
        bounds = (0.0, getattr(largest, varied))
        coupled = _coupled(varied, rod, largest, bounds, tolerance)
        none = largest.varied(varied, 0.0)
        status = coupled.answers(Loads.single(none), tolerance, quick=True).status[0]
        if status != 1:
            _say_why_at_zero(varied, rod, coupled, none, status)
            return 0.0
        change = first_change(varied, coupled, largest, bounds, tolerance).at
        return math.inf if change is None else change
    ends = np.linspace(0.0, getattr(largest, varied), _PIECES[varied] + 1).tolist()
    for piece in pairwise(ends):
        modes = _system(rod, largest.varied(varied, piece[1]), tolerance).modes
        system = ModalSystem(rod.mode_constants, largest, modes)
        found = unstable_loads(varied, system, tolerance, piece, union=True, nearest=piece[0]).intervals
        if found:
            return min(part.low for part in found)
    return math.inf


def _say_why_at_zero(varied: Quantity, rod: ModalRod, modes: CoupledModes, load: Load, status: int) -> None:
    """Warn where the weight along the rod buckles it before the quantity grows from zero, or where that is not known.

    BucklingWarning, UndecidedWarning.
    """
    name = QUANTITIES[varied][0]
    if status == -1:
        warnings.warn(
            f"whether the rod is stable without {name} could not be decided, and counts as unstable",
            UndecidedWarning,
            stacklevel=level_of_caller(),
        )
        return
    added = [float(modes.numbers.added_mean(load, x)) for x in (0.0, 1.0)]
    alone = modes.static_answers(np.array([0.0, load.mean])).status
    if not any(added) or alone[1] != 0:
        return
    end = "upper" if added[0] > added[1] else "lower"
    what, force = "the weight along the rod alone buckles", max(added)
    if alone[0] != 0:
        what, force = "the mean force with the weight along the rod buckles", load.mean + max(added)
    remedy = "another mean_at" if varied == "mean" else "less mean force, another mean_at"
    warnings.warn(
        f"{name} 0 is the limit: {what} it, with {force:.4g} N, {force / rod.critical_force:.3g} critical forces, of "
        f"compression at the {end} end; give {remedy} or a shorter length",
        BucklingWarning,
        stacklevel=level_of_caller(),
    )


def _system(rod: ModalRod, load: Load, tolerance: float) -> ModalSystem:
    """Return the equations of all modes that can grow faster than the tolerance."""
    last, left_out = rod.modes_needed(load, tolerance)
    return ModalSystem(rod.mode_constants, load, tuple(range(1, last + 1)), left_out)


def _coupled(
    varied: Quantity, rod: ModalRod, largest: Load, bounds: tuple[float, float], tolerance: float
) -> CoupledModes:
    """Return as many coupled modes as all loads within bounds need."""
    loads = Loads.along(largest, varied, np.linspace(*bounds, 33))
    return CoupledModes(rod.coupled_numbers, largest, rod.coupled_numbers.modes_needed(loads, largest, tolerance))


def _coupled_intervals(
    varied: Quantity,
    rod: ModalRod,
    largest: Load,
    bounds: tuple[float, float],
    tolerance: float,
    progress: Progress | None,
) -> tuple[tuple[StabilityInterval, ...], int, float, tuple[AxialGap, ...]]:
    """Return what is stable, how many modes and what distance of samples were taken, and what was not computed."""
    skipped: list[AxialGap] = []
    if varied == "frequency" and not largest.is_uniform:
        pieces, skipped = _pieces_of_waves(rod, largest, bounds, tolerance)
    else:
        pieces = [(bounds, _coupled(varied, rod, largest, bounds, tolerance))]
    samples = [_share(piece, bounds, SAMPLES, _LEAST_SAMPLES) for piece, _ in pieces]
    segments: list[tuple[tuple[float, float], list[UnstablePart]]] = []
    resolution, done = 0.0, 0
    for (piece, modes), number in zip(pieces, samples, strict=True):
        told = shifted(progress, done, sum(samples) - number)
        parts, distance = unstable_parts(varied, modes, largest, piece, tolerance, told, number)
        resolution, done = max(resolution, distance), done + number
        if segments and segments[-1][0][1] == piece[0]:
            before, known = segments.pop()
            if known and parts and known[-1].high == parts[0].low:
                first = known.pop()
                parts[0] = replace(parts[0], low=first.low, low_cause=first.low_cause)
            piece, parts = (before[0], piece[1]), known + parts
        segments.append((piece, parts))
    stable = [_ended(part, bounds) for piece, parts in segments for part in _stable_between(parts, piece)]
    return tuple(stable), max(modes.count for _, modes in pieces), resolution, tuple(skipped)


def _pieces_of_waves(
    rod: ModalRod, largest: Load, bounds: tuple[float, float], tolerance: float
) -> tuple[list[tuple[tuple[float, float], CoupledModes]], list[AxialGap]]:
    """Return pieces of neighbouring frequencies with as many modes as each needs, and what axial resonances leave out.

    AxialResonanceError where they leave nothing.
    """
    numbers = rod.coupled_numbers
    skipped = gaps(largest, numbers.wave_speed, numbers.length, bounds)
    left_out = skipped.copy()
    pieces: list[tuple[tuple[float, float], CoupledModes]] = []

    def add(piece: tuple[float, float], halvings: int) -> None:
        try:
            pieces.append((piece, _coupled("frequency", rod, largest, piece, tolerance)))
        except AxialResonanceError:  # for all the damping there is
            middle = 0.5 * sum(piece)
            if halvings == 0:
                here = rod.axial_response(largest.varied("frequency", middle)).resonances
                left_out.append(AxialGap(*piece, min(here, key=lambda r: abs(r.frequency - middle))))
                return
            add((piece[0], middle), halvings - 1)
            add((middle, piece[1]), halvings - 1)

    for part in between(bounds, skipped):
        for piece in pairwise(np.linspace(*part, 1 + _share(part, bounds, _GROUPS, 1)).tolist()):
            add(piece, _HALVINGS)
    if not pieces:
        numbers.modes_needed(Loads.single(largest), largest, tolerance)  # says why
    return pieces, joined(left_out)


def _share(part: tuple[float, float], bounds: tuple[float, float], number: int, least: int) -> int:
    """Return the share of a number that falls to a part of bounds."""
    return max(least, math.ceil(number * (part[1] - part[0]) / (bounds[1] - bounds[0])))


def _ended(part: StabilityInterval, bounds: tuple[float, float]) -> StabilityInterval:
    """Return an interval whose ends, where it ends at no resonance of modes and at no bound, are named."""
    low = "axial resonance" if part.low_end is None and part.low > bounds[0] else part.low_end
    high = "axial resonance" if part.high_end is None and part.high < bounds[1] else part.high_end
    return part._replace(low_end=low, high_end=high)


def _stable_between(parts: list[UnstablePart], bounds: tuple[float, float]) -> Iterator[StabilityInterval]:
    """Yield what the unstable parts leave of ``bounds``."""
    at, closed_by = bounds[0], None
    for part in parts:
        if part.low > at:
            yield StabilityInterval(at, part.low, closed_by, part.low_cause)
        at, closed_by = part.high, part.high_cause
    if at < bounds[1]:
        yield StabilityInterval(at, bounds[1], closed_by, None)


def _between(unstable: UnstableLoads, bounds: tuple[float, float]) -> Iterator[StabilityInterval]:
    """Yield what the unstable loads leave of ``bounds``."""
    low, high = bounds
    at, closed_by = low, None
    for part in sorted(unstable.intervals):
        if part.high <= at or part.low >= high:
            continue
        cause = (part.mode, part.tongue)
        if part.low > at:
            yield StabilityInterval(at, part.low, closed_by, cause)
        at, closed_by = part.high, cause
    if at < high:
        yield StabilityInterval(at, high, closed_by, None)


def _unstable_rows(bands: Sequence[UnstableBand], size: float) -> Iterator[tuple[float, float, str]]:
    """Yield ends and text of unstable bands, the texts in columns."""
    columns = [
        (
            _end(band.cause),
            f"{band.worst_growth:.4g}",
            f"{band.at / size:.6g}",
            _rounded_up(band.required_damping),
        )
        for band in bands
    ]
    cause, growth, at, _ = (max(len(text) for text in column) for column in zip(*columns, strict=True))
    for band, (what, fast, where, damping) in zip(bands, columns, strict=True):
        text = f"unstable: {what:<{cause}}   {fast:>{growth}} 1/s at {where:<{at}}   damping {damping}"
        yield band.low, band.high, text


def _rounded_up(damping: float) -> str:
    """Return a damping rate with four digits that is not less than the rate itself; "none" for an infinite one."""
    if math.isinf(damping):
        return "none"
    return f"{Context(prec=4, rounding=ROUND_CEILING).create_decimal_from_float(damping):.4g} 1/s"


def _end(end: Cause) -> str:
    if end is None:
        return "end of the search"
    if end == "unnamed":
        return "not named"
    return str(end) if isinstance(end, Resonance | str) else f"mode {end[0]}, tongue {end[1]}"
