"""What is stable along one quantity of a load: its intervals, the causes of their ends, and the bands between."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from decimal import ROUND_CEILING, Context
from typing import Any, Literal, NamedTuple, Protocol, TypeAlias

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.caching import cached_property
from floquetrod._util.content import NoTruthValue
from floquetrod._util.interchange import by_keys
from floquetrod._util.progress import Progress
from floquetrod._util.result_report import Report, Reported, Table
from floquetrod._util.spans import complement
from floquetrod.floquet.multipliers.resonance_names import Resonance
from floquetrod.rod.loads.axial import AxialGap
from floquetrod.rod.loads.load import LOAD, Load, Quantity
from floquetrod.rod.model.data import RodData

WhatGrows: TypeAlias = tuple[int, int] | Resonance | Literal["unnamed"]
"""The growing mode: (mode, tongue), a resonance of coupled modes, or "unnamed" where it could not be determined."""

Cause: TypeAlias = WhatGrows | Literal["axial resonance"] | None
"""The cause of an end of an interval: (mode, tongue), a resonance of coupled modes, or None at an end of the search.

"axial resonance" where nothing was computed beyond it, see `StabilityIntervals.not_computed`.
"unnamed" where coupled modes grow, or may grow, and none could be named: beyond 200 of them, or where undecided.
"""


class BucklingWarning(UserWarning):
    """The weight along the rod buckles it even where the quantity varied is zero."""


class StabilityInterval(NamedTuple):
    """Stable from ``low`` to ``high``; the cause of each end is (mode, tongue), where modes are coupled a `Resonance`.

    "unnamed" where that could not be determined; None at an end of the search.
    """

    low: float
    high: float
    low_end: Cause
    high_end: Cause


class UnstableBand(NamedTuple):
    """A range of one quantity of the load, in N or rad/s, in which some mode grows, or may grow where undecided.

    Attributes
    ----------
    low : float
        Where it begins: where a stability interval ends, or the search begins.
    high : float
        Where it ends likewise.
    worst_growth : float
        Largest growth rate in it, in 1/s; zero where none is seen to grow.
    at : float
        Where that is.
    cause : (int, int), Resonance or "unnamed"
        The mode and tongue that grow there, where modes are coupled a resonance.
    required_damping : float
        The rod's total damping rate in 1/s above which every rate stabilises all of the band, infinite where
        none does: the largest of samples, refined about it.  Where modes are coupled, that of the load ``at`` which
        growth is worst.
    """

    low: float
    high: float
    worst_growth: float
    at: float
    cause: WhatGrows
    required_damping: float


class Search(NamedTuple):
    """A search along one quantity of a load."""

    varied: Quantity
    load: Load  # with the largest value of what is varied
    bounds: tuple[float, float]
    growth_tolerance: float  # growth in 1/s up to which a mode counts as stable


class BandModel(Protocol):
    """The modes of a rod, asked for what happens in unstable bands: a `ModeModel`."""

    @property
    def rod(self) -> RodData:
        """The rod."""

    @property
    def damping_subject(self) -> str:
        """What the damping required by an unstable band stabilises."""

    @property
    def damping_source(self) -> str:
        """How that damping is computed, in words."""

    def unstable_bands(
        self, search: Search, modes: int, bands: Sequence[tuple[float, float]], progress: Progress | None
    ) -> tuple[UnstableBand, ...]:
        """Return the growth in bands without stable loads, given by their ends in increasing order."""


class RangeQuestion(NamedTuple):
    """A search along a quantity, and the model of the modes that judged its loads."""

    model: BandModel
    search: Search


@dataclass(frozen=True, repr=False)
class StabilityIntervals(units.InUnits, Reported, NoTruthValue):
    """All stability intervals of one quantity of the load within bounds.

    Attributes
    ----------
    quantity : str
        The quantity that varies: "mean force", "amplitude" or "frequency".
    unit : str
        Its unit: "N" or "rad/s".
    bounds : tuple of float
        Range of the search, (low, high).
    intervals : tuple of StabilityInterval
        In increasing order; between them nothing is stable, except perhaps in the gaps ``not_computed``.
    growth_tolerance : float
        Growth in 1/s up to which a mode counts as stable; resonance tongues that never exceed it are left out.
    modes : int
        Modes examined, 1 to this; every higher mode grows at less than 1e-12 per second or the tolerance.
    tongues_left_out : int
        Resonance tongues within the stability intervals in which a mode grows, but nowhere faster than the tolerance.
    resolution : float
        Unstable parts up to this width may have been missed, in ``unit``: 0 where the search is complete.
    searched : RangeQuestion
        From which `unstable` is computed.
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
    tongues_left_out: int
    resolution: float
    searched: RangeQuestion = field(repr=False, compare=False)
    not_computed: tuple[AxialGap, ...] = ()

    def __iter__(self) -> Iterator[StabilityInterval]:
        """Iterate over the intervals."""
        return iter(self.intervals)

    def __len__(self) -> int:
        """Return the number of intervals."""
        return len(self.intervals)

    def __contains__(self, value: Any) -> bool:
        """Return whether ``value`` is stable; an end of the search may be, an end of a tongue is not."""
        value = units.single(value, "value", units.kind_of(self.unit) or "ratio")
        return any(
            part.low < value < part.high
            or (value == part.low and part.low_end is None)
            or (value == part.high and part.high_end is None)
            for part in self.intervals
        )

    @cached_property
    def unstable(self) -> tuple[UnstableBand, ...]:
        """The bands between the stability intervals, with the fastest growth and the damping required; computed once.

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
            others: list[StabilityInterval | AxialGap] = [*self.intervals, *self.not_computed]
            bands = [gap[:2] for gap in complement(self.bounds, others)]
            model, search = self.searched
            known = self.__dict__["unstable"] = (
                model.unstable_bands(search, self.modes, bands, progress) if bands else ()
            )
        return known

    @property
    def required_damping(self) -> float:
        """Largest damping rate in 1/s that any of the unstable bands requires, 0 without any, infinite beyond reach.

        As sampled, see `unstable`; of coupled modes, that of the load of fastest growth in each band.
        """
        return max((band.required_damping for band in self.unstable), default=0.0)

    @property
    def note(self) -> str:
        """The tongues that were left out."""
        slow = max(self.growth_tolerance, 1e-12)
        text = f"modes 1 to {self.modes}; growth at or below {slow:g} 1/s does not count"
        if self.tongues_left_out:
            text += f": {self.tongues_left_out} tongue{'s' * (self.tongues_left_out > 1)} left out"
        return text

    def __repr__(self) -> str:
        """Return the stability intervals as a table; `table` also says what happens between them."""
        return str(self._report(*self._shown, ()))

    def table(self, unit: str | None = None, size: float | None = None) -> str:
        """Return the stable and unstable intervals, in order, in a unit such as "Hz", by default that of the bounds.

        ``size`` is that of a unit of your own in `unit`.  Unstable bands are followed by the mode that grows fastest,
        its growth and where, and the damping required.  ValueError for units that are unknown.
        """
        return str(self.report(unit, size))

    def report(self, unit: str | None = None, size: float | None = None) -> Report:
        """Return the `table`, whose text is ``str(report)``; a notebook shows it as a table."""
        wanted = self._shown.name if unit is None else unit
        if not isinstance(wanted, str):
            raise validate.wrong_type("unit", f"must be a word such as 'Hz', got {validate.short(unit)}")
        if size is None:
            model, search = self.searched
            wanted, size = units.unit(wanted, "unit", LOAD[search.varied].kind, model.rod.critical_force)
        size = validate.positive("size", size, "give it in the unit of the intervals")
        return self._report(wanted, size, self.unstable)

    def plot(self, ax: Any = None, *, unit: str | None = None) -> Any:
        """Draw what is stable along the quantity, and how fast the unstable bands grow; return the axes.

        In a unit such as "Hz", by default that of the bounds.  ValueError for a unit that is unknown.
        """
        from floquetrod.plotting.ranges_plot import draw_ranges

        model, search = self.searched
        name = self._shown.name if unit is None else unit
        shown = units.unit(name, "unit", LOAD[search.varied].kind, model.rod.critical_force)
        return draw_ranges(self, shown, _end, ax)

    def _at_hand(self) -> Report:
        """Return the stability intervals, and unstable bands that are known."""
        return self._report(*self._shown, self.__dict__.get("unstable", ()))

    @property
    def _shown(self) -> units.Unit:
        """The unit in which the question gave the quantity, else its own."""
        kind = LOAD[self.searched.search.varied].kind
        if kind == "frequency":
            return units.unit(self.given_units.frequency or self.unit, "", kind)
        return units.AnswerUnits.named(given=self.given_units).force

    def _report(self, unit: str, size: float, unstable: tuple[UnstableBand, ...]) -> Report:
        low, high = (value / size for value in self.bounds)
        parts = [(part.low, part.high, f"{_end(part.low_end)} ... {_end(part.high_end)}") for part in self.intervals]
        parts += _unstable_rows(unstable, size) if unstable else ()
        rows = [(f"  {low / size:12.9g} to {high / size:12.9g}", f" {text}") for low, high, text in sorted(parts)]
        rows += [] if self.intervals else [("  none", "")]
        for gap in self.not_computed:
            at = gap.resonance.frequency / size
            ends = f"  {gap.low / size:12.9g} to {gap.high / size:12.9g}"
            rows.append((ends, f" not computed: axial resonance at {at:.6g}"))
        lines = []
        if unstable:
            what = self.searched.model.damping_subject
            lines += [
                f"  (unstable: fastest growth, where it occurs, and damping rate above which {what} is stable)",
                f"  (largest damping rate required: {_rounded_up(self.required_damping)})",
            ]
        if self.resolution:
            lines.append(f"  (unstable parts narrower than {self.resolution / size:.2g} {unit} may have been missed)")
        rest = "\n".join([*lines, f"  ({self.note})"])
        headline = f"stable {self.quantity} in {unit}, between {low:.6g} and {high:.6g}"
        return Report(headline, (), Table([("", ""), ("", "")], rows, rest))

    def as_dict(self) -> dict[str, Any]:
        """Return the stability intervals and `unstable` as numbers for JSON, units in the keys; None for infinite."""
        unit = "N" if self.unit == "N" else "rad_per_s"
        ends = f"low_{unit} high_{unit}"
        grows = f"{ends} worst_growth_rate_per_s=worst_growth worst_at_{unit}=at"
        resonates = f"{ends} axial_resonance_{unit}=resonance.frequency harmonic=resonance.harmonic"
        return {
            "quantity": self.quantity,
            **by_keys(self, f"searched_{unit}=bounds growth_tolerance_per_s modes_checked=modes tongues_left_out"),
            f"parts_missed_up_to_{unit}": self.resolution,
            "stable": [
                by_keys(part, ends) | {"low_end": _end_for_json(part.low_end), "high_end": _end_for_json(part.high_end)}
                for part in self.intervals
            ],
            "unstable": [
                by_keys(band, grows)
                | {"cause": _end_for_json(band.cause)}
                | by_keys(band, "required_damping_rate_per_s=required_damping")
                for band in self.unstable
            ],
            "not_computed": [by_keys(gap, resonates) for gap in self.not_computed],
            "ends_are": "[mode, tongue], a resonance of coupled modes, 'axial resonance' next to what is not computed, "
            "'unnamed', or null at an end of the search",
            "required_damping_is": self.searched.model.damping_source,
        }


def intervals_along(
    model: BandModel,
    search: Search,
    intervals: tuple[StabilityInterval, ...],
    modes: int,
    resolution: float,
    *,
    tongues_left_out: int = 0,
    not_computed: tuple[AxialGap, ...] = (),
) -> StabilityIntervals:
    """Return the intervals that a model of the modes found along a quantity."""
    return StabilityIntervals(
        LOAD[search.varied].words,
        LOAD[search.varied].unit,
        search.bounds,
        intervals,
        search.growth_tolerance,
        modes,
        tongues_left_out,
        resolution,
        RangeQuestion(model, search),
        not_computed,
    )


def _unstable_rows(bands: Sequence[UnstableBand], size: float) -> Iterator[tuple[float, float, str]]:
    """Yield ends and text of unstable bands, the texts in columns."""
    columns = [
        (_end(band.cause), f"{band.worst_growth:.4g}", f"{band.at / size:.6g}", _rounded_up(band.required_damping))
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


def _end_for_json(end: Cause) -> Any:
    """Return the cause of an end of an interval for JSON."""
    return end.as_dict("growth_rate_per_s") if isinstance(end, Resonance) else end


def _end(end: Cause) -> str:
    if end is None:
        return "end of the search"
    if end == "unnamed":
        return "not named"
    return str(end) if isinstance(end, Resonance | str) else f"mode {end[0]}, tongue {end[1]}"
