"""What is stable along one quantity of a load: its intervals, the causes of their ends, and the bands between."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from decimal import ROUND_CEILING, Context, Decimal
from typing import Any, Literal, NamedTuple, Protocol, TypeAlias

from floquetrod import units
from floquetrod._util import suggest, validate
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

WhatGrows: TypeAlias = tuple[int, int] | int | Resonance | Literal["unnamed"]
"""The growing mode: (mode, tongue), a resonance of coupled modes, or "unnamed" where it could not be determined.

The mode alone under noise and two frequencies, where growth belongs to no single tongue.
"""

Cause: TypeAlias = WhatGrows | Literal["axial resonance"] | None
"""The cause of an end of an interval: (mode, tongue), a resonance of coupled modes, or None at an end of the search.

"axial resonance" where nothing was computed beyond it, see `StabilityIntervals.not_computed`.
"unnamed" where coupled modes grow, or may grow, and none could be named: beyond 200 of them, or where undecided.
"""


BEYOND = 0.01  # of a quantity, up to which the band is looked into in which a margin ends (a choice)

_OF_SQUARES = "is that of q^2 on average, twice that of amplitudes"
"""What growth is under noise."""


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
        Value of the quantity at which growth is largest.
    cause : (int, int), int, Resonance or "unnamed"
        The mode and tongue that grow there, under noise or two frequencies the mode, where modes are coupled a
        resonance.
    required_damping : float
        The rod's total damping rate in 1/s above which every rate stabilises all of the band, infinite where
        none does: the largest of samples, refined about it.  Where modes are coupled, the rate required at the load
        ``at`` alone.
    """

    low: float
    high: float
    worst_growth: float
    at: float
    cause: WhatGrows
    required_damping: float

    @property
    def status(self) -> Literal["unstable", "undecided"]:
        """The word "unstable", or "undecided" where no mode is seen to grow."""
        return "unstable" if self.worst_growth > 0.0 else "undecided"


class BandBeyond(NamedTuple):
    """The unstable band in which a margin ends, up to a hundredth of the quantity beyond its edge.

    Attributes
    ----------
    cause : (int, int), Resonance or "unnamed"
        The mode and tongue that grow at its edge; of coupled modes the resonance where growth is fastest.
    growth : float
        Largest growth rate in it, in 1/s; where modes are coupled the largest of samples.
    is_thin : bool
        Whether it ends within this hundredth.
    """

    cause: WhatGrows
    growth: float
    is_thin: bool

    @property
    def words(self) -> str:
        """What grows, and how fast at the most where the band is thin."""
        return f"{_end(self.cause)}{f': thin, {self.growth:.2g} 1/s' if self.is_thin else ''}"

    def as_dict(self) -> dict[str, Any]:
        """Return the band as numbers for JSON."""
        if isinstance(self.cause, Resonance | str | int):
            cause = {"cause": _end_for_json(self.cause)}
        else:
            cause = {"mode": self.cause[0], "tongue": self.cause[1]}
        return cause | by_keys(self, "growth_rate_per_s=growth is_thin")


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
        """At which loads of an unstable band the required damping stabilises it, in words."""

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


class ListedRanges(NamedTuple):
    """Safe ranges as they are listed, in three digits.

    Attributes
    ----------
    safe : tuple of (str, str)
        Ends rounded inwards; ranges with only a thin band between them are one.
    thin : tuple of (float, float)
        Unstable bands narrower than the last digit shown, in SI units.
    narrow : int
        Number of safe ranges that vanish by rounding.
    """

    safe: tuple[tuple[str, str], ...]
    thin: tuple[tuple[float, float], ...]
    narrow: int

    @classmethod
    def of(
        cls,
        bands: Sequence[tuple[float, float]],
        intervals: Sequence[tuple[float, float]],
        shown: units.Unit,
        width: float,
    ) -> ListedRanges:
        """Return the ranges of stability intervals between unstable bands, in a unit."""
        thin = tuple(
            band for band in bands if shown.of(band[1]) - shown.of(band[0]) < last_digit(shown.of(band[0]), width)
        )
        merged: list[tuple[float, float]] = []
        for low, high in intervals:
            if merged and (merged[-1][1], low) in thin:
                merged[-1] = merged[-1][0], high
            else:
                merged.append((low, high))
        # outward rounding of a band is inward rounding of the ranges beside it
        ends = [(outward(shown.of(low), width, up=True), outward(shown.of(high), width)) for low, high in merged]
        safe = tuple((low, high) for low, high in ends if float(low) < float(high))
        return cls(safe, thin, len(ends) - len(safe))

    def headline(self, unit: str, bounds: tuple[float, float]) -> str:
        """Return the answer: where it is safe within bounds, in a unit."""
        ranges = ", ".join(f"{low} to {high} {unit}" for low, high in self.safe)
        count = len(self.thin)
        less = f", except for {count} thin band{'s' * (count > 1)}" if count and ranges else ""
        return f"safe: {ranges}{less}" if ranges else f"safe: nowhere from {bounds[0]:.6g} to {bounds[1]:.6g} {unit}"


def last_digit(value: float, width: float) -> float:
    """Return the unit of the third digit of a value, or of the width of a search where that is less.

    >>> last_digit(24.1, 50.0), last_digit(0.0744, 1.2), last_digit(100.2, 1.0)
    (0.1, 0.0001, 0.01)
    """
    return float(f"1e{_last_place(value, width)}")


def _last_place(value: float, width: float) -> int:
    return math.floor(math.log10(min(abs(value), width) if value else width)) - 2


def outward(value: float, width: float, *, up: bool = False) -> str:
    """Return a value rounded down or up to its `last_digit`; to the nearest where that is off by 1e-9 of it at most.

    >>> outward(10.7965, 50.0), outward(10.8075, 50.0, up=True), outward(10.000000000000002, 50.0, up=True)
    ('10.7', '10.9', '10')
    """
    place = _last_place(value, width)
    steps = value / float(f"1e{place}")
    nearest = round(steps)
    if abs(steps - nearest) > 1e-9 * abs(steps):
        nearest = math.ceil(steps) if up else math.floor(steps)
    text = format(Decimal(nearest).scaleb(place), "f")
    return text.rstrip("0").rstrip(".") if "." in text else text


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
        The search from which `unstable` is computed.
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
        largest: along the mean force this is the maximum, since growth in a tongue is concave (page `theory/ranges`);
        along amplitude or frequency a second, narrower maximum in a tongue may be passed over.  The damping is sampled
        at the same loads, and in all modes at the ends and in the middle of each band, refined about the largest.

        Where modes are coupled, growth is evaluated at 17 loads of each band and refined about the largest, to a
        thousandth of the band; the damping is for this one load.
        """
        return self.find_unstable()

    def find_unstable(self, progress: Progress | None = None) -> tuple[UnstableBand, ...]:
        """Return `unstable`; ``progress`` is called with the numbers of bands looked into and to look into.

        Returns
        -------
        tuple of UnstableBand
            From the lowest on.

        Raises
        ------
        TypeError
            For a ``progress`` that cannot be called.
        """
        validate.progress(progress)
        known: tuple[UnstableBand, ...] | None = self.__dict__.get("unstable")
        if known is None:
            bands = self._bands()
            model, search = self.searched
            known = self.__dict__["unstable"] = (
                model.unstable_bands(search, self.modes, bands, progress) if bands else ()
            )
        return known

    @property
    def required_damping(self) -> float:
        """Largest damping rate in 1/s that any of the unstable bands requires, 0 without any, infinite beyond reach.

        It is sampled, see `unstable`; with coupled modes, at the load of fastest growth in each band alone.
        """
        return max((band.required_damping for band in self.unstable), default=0.0)

    @property
    def note(self) -> str:
        """The modes examined, and the growth up to which they count as stable."""
        return f"modes 1 to {self.modes}; growth of {max(self.growth_tolerance, 1e-12):g} 1/s or less does not count"

    def __repr__(self) -> str:
        """Return the stability intervals as a table; `table` also says what happens between them."""
        return str(self._report(self._shown, (), full=False))

    def table(self, unit: str | None = None, size: float | None = None, *, full: bool = False) -> str:
        """Return the `report` as text.

        Returns
        -------
        str
            The lines and the table.

        Raises
        ------
        TypeError, ValueError
            As `report`.
        """
        return str(self.report(unit, size, full=full))

    def report(self, unit: str | None = None, size: float | None = None, *, full: bool = False) -> Report:
        """Return the safe ranges, and a table of the unstable bands: fastest growth, where, damping required, mode.

        Numbers have three digits, of the value or of the width searched where that is less; safe ranges are rounded
        inwards, bands outwards.  Bands narrower than the last digit are no rows of the table: above it stand their
        number, their middles and the fastest growth in them.

        Parameters
        ----------
        unit : str, optional
            Such as "Hz"; by default the unit of the bounds.
        size : float, optional
            Of a unit of your own in `unit`.
        full : bool
            Whether to list every interval and every band, with nine digits, and what ends them.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.

        Raises
        ------
        TypeError, ValueError
            For another unit, and for a size that is not positive.
        """
        wanted = self._shown.name if unit is None else unit
        if not isinstance(wanted, str):
            raise validate.wrong_type("unit", f"must be a word such as 'Hz', got {validate.short(unit)}")
        if size is None:
            model, search = self.searched
            wanted, size = units.unit(wanted, "unit", LOAD[search.varied].kind, model.rod.critical_force)
        size = validate.positive("size", size, "give it in the unit of the intervals")
        return self._report(units.Unit(wanted, size), self.unstable, full=validate.flag("full", full))

    def plot(self, ax: Any = None, *, unit: str | None = None) -> Any:
        """Draw the stability intervals along the quantity and the growth in unstable bands.

        In a unit such as "Hz", by default the unit of the bounds.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.

        Raises
        ------
        TypeError, ValueError
            For another unit.
        """
        from floquetrod.plotting.ranges_plot import draw_ranges

        model, search = self.searched
        name = self._shown.name if unit is None else unit
        shown = units.unit(name, "unit", LOAD[search.varied].kind, model.rod.critical_force)
        return draw_ranges(self, shown, self._listed(shown).safe, _end, ax)

    def _at_hand(self) -> Report:
        """Return the stability intervals, and the unstable bands if they have been computed."""
        return self._report(self._shown, self.__dict__.get("unstable", ()), full=False)

    @property
    def _shown(self) -> units.Unit:
        """The unit in which the question gave the quantity, else its own."""
        kind = LOAD[self.searched.search.varied].kind
        if kind == "frequency":
            return units.unit(self.given_units.frequency or self.unit, "", kind)
        return units.AnswerUnits.named(given=self.given_units).force

    def _listed(self, shown: units.Unit) -> ListedRanges:
        """Return the ranges as the report lists them and the figure names them, in a unit."""
        width = shown.of(self.bounds[1]) - shown.of(self.bounds[0])
        return ListedRanges.of(self._bands(), [part[:2] for part in self.intervals], shown, width)

    def _report(self, shown: units.Unit, unstable: tuple[UnstableBand, ...], *, full: bool) -> Report:
        """Return the report, with the growth in bands where that is known."""
        low, high = (shown.of(value) for value in self.bounds)
        width, unit = high - low, shown.name
        listed = self._listed(shown)
        lines = [("searched", f"{self.quantity} from {low:.6g} to {high:.6g} {unit}; {self.note}")]
        if self._has_noise:
            lines.append(("noise", f"safe is stable in mean square; growth {_OF_SQUARES}"))
        left_out = self._left_out(listed._replace(thin=(), narrow=0) if full else listed, shown, unstable)
        lines += [("left out" if i == 0 else "", text) for i, text in enumerate(left_out)]
        for gap in self.not_computed:
            at = f"axial resonance at {shown.show(gap.resonance.frequency)}"
            ends = f"{outward(shown.of(gap.low), width)} to {outward(shown.of(gap.high), width, up=True)} {unit}"
            lines.append(("gap", f"{ends} not computed: {at}"))
        if self.resolution:
            narrow = f"{self.resolution / shown.size:.2g} {unit}"
            lines.append(("sampled", f"unstable bands narrower than {narrow} may have been missed"))
        if unstable:
            what = self.searched.model.damping_subject
            most, above = _rounded_up(self.required_damping), f"a band is stable above its rate, {what}"
            largest = "no rate stabilises all bands" if most == "none" else f"{most} is the largest rate required"
            lines.append(("damping", f"{largest}; {above}"))
        rows = self._rows(shown, width, unstable, () if full else listed.thin, full=full)
        growth = "growth of q^2 1/s" if self._has_noise else "growth 1/s"
        columns = [(unit, ">"), ("", "<"), (growth, ">"), (f"at {unit}", ">"), ("damping", ">"), ("", "<")]
        widths = [max(map(len, column)) for column in zip(*([title for title, _ in columns], *rows), strict=True)]
        layout = [(title, f"{way}{width}") for (title, way), width in zip(columns, widths, strict=True)]
        return Report(listed.headline(unit, (low, high)), lines, Table(layout, rows) if rows else None)

    @property
    def _has_noise(self) -> bool:
        """Whether growth is that of second moments."""
        return bool(self.searched.search.load.noise)

    def _bands(self) -> list[tuple[float, float]]:
        """Return the ends of the unstable bands, which are known without what grows in them."""
        others: list[StabilityInterval | AxialGap] = [*self.intervals, *self.not_computed]
        return [gap[:2] for gap in complement(self.bounds, others)]

    def _left_out(self, listed: ListedRanges, shown: units.Unit, unstable: tuple[UnstableBand, ...]) -> list[str]:
        """Return what the table leaves out, so that a reader who adds up its rows misses no band."""
        texts = []
        if count := len(listed.thin):
            thin = [band for band in unstable if band[:2] in listed.thin]
            fastest = max(thin, key=lambda band: band.worst_growth, default=None)
            grows = ""
            if fastest is not None:
                at = f", at {shown.show(fastest.at, 4)}" if count > 1 else ""
                grows = f"; fastest growth {fastest.worst_growth:.3g} 1/s{at}"
            middles = suggest.listed([f"{shown.of(0.5 * sum(band)):.4g}" for band in listed.thin])
            places = f"{'their middles' if count > 1 else 'its middle'} in {shown.name}: {middles}"
            bands = f"{count} unstable band{'s' * (count > 1)} narrower than the last digit shown"
            texts.append(f"{bands}, {places}{grows}")
        if listed.narrow:
            are = "ranges" if listed.narrow > 1 else "range"
            texts.append(f"{listed.narrow} safe {are} narrower than the last digit shown")
        if count := self.tongues_left_out:
            slow = max(self.growth_tolerance, 1e-12)
            texts.append(f"{count} tongue{'s' * (count > 1)} in which nothing grows faster than {slow:g} 1/s")
        return texts

    def _rows(
        self,
        shown: units.Unit,
        width: float,
        unstable: tuple[UnstableBand, ...],
        thin: Sequence[tuple[float, float]],
        *,
        full: bool,
    ) -> list[tuple[str, ...]]:
        """Return the rows of the unstable bands but the ``thin`` ones, in ``full`` with the stability intervals."""
        rows: list[tuple[float, tuple[str, ...]]] = []
        for band in unstable:
            if band[:2] not in thin:
                low, high, at = (float(shown.of(value)) for value in (band.low, band.high, band.at))
                ends = (f"{low:.9g}", f"{high:.9g}") if full else (outward(low, width), outward(high, width, up=True))
                growth, damping = (
                    f"{band.worst_growth:.4g}" if full else f"{band.worst_growth:.3g}",
                    band.required_damping,
                )
                where = f"{at:.6g}" if full else f"{at:.4g}"
                cause = _end(band.cause) if band.status == "unstable" else "no mode is seen to grow"
                texts = (" to ".join(ends), band.status, growth, where, _rounded_up(damping), cause)
                rows.append((band.low, texts))
        for part in self.intervals if full else ():
            between = f"{shown.of(part.low):.9g} to {shown.of(part.high):.9g}"
            rows.append((part.low, (between, "stable", "", "", "", f"{_end(part.low_end)} ... {_end(part.high_end)}")))
        return [texts for _, texts in sorted(rows)]

    def as_dict(self) -> dict[str, Any]:
        """Return the stability intervals and `unstable` as numbers for JSON, units in the keys; None for infinite.

        Returns
        -------
        dict of str
            Among them ``stable`` and ``unstable``, lists with a dict for each interval; in ``unstable`` the ``status``
            is "undecided", and the ``cause`` None, where no mode is seen to grow.
        """
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
                by_keys(band, f"status {grows}")
                | {"cause": _end_for_json(band.cause) if band.status == "unstable" else None}
                | by_keys(band, "required_damping_rate_per_s=required_damping")
                for band in self.unstable
            ],
            "not_computed": [by_keys(gap, resonates) for gap in self.not_computed],
            **({"growth_is": _OF_SQUARES} if self._has_noise else {}),
            "ends_are": "[mode, tongue], a mode, a resonance of coupled modes, 'axial resonance' next to what is not "
            "computed, 'unnamed', or null at an end of the search",
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
    if isinstance(end, int):
        return f"mode {end}"
    return str(end) if isinstance(end, Resonance | str) else f"mode {end[0]}, tongue {end[1]}"
