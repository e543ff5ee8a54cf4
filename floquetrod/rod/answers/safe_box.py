"""The largest proved box about a working point: for each quantity from where to where it may go."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import islice, product
from typing import Any, NamedTuple

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.caching import cached_property
from floquetrod._util.content import NoTruthValue
from floquetrod._util.interval import RealInterval
from floquetrod._util.progress import Progress
from floquetrod._util.result_report import Report, Reported, Table
from floquetrod.floquet.proof.region_proof import RegionProof, Side
from floquetrod.rod.answers.reports import shown_in
from floquetrod.rod.answers.rod_box import RodBox
from floquetrod.rod.answers.rod_box_proof import is_proved_stable, prove, require_in_reach
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import LOAD, QUANTITIES, Load, Loads, Quantity
from floquetrod.rod.mode_equations.modal_systems import ModalSystems
from floquetrod.rod.model.assumptions import warn_unless_uniform
from floquetrod.rod.model.constants import mode_constants
from floquetrod.rod.model.data import RodData

_BOXES = 200  # parts of a box examined before it counts as not safe, in a search of many (a choice)
_ROUNDS = 8  # times that every side is moved, at most: two or three are usual
_GRID = 5  # loads a quantity that are judged before a proof is tried (a choice)
_CORNERS = 16  # corners of the tolerances of a rod whose rods are judged likewise: all those of four parameters
_HALVINGS = 40  # of a window before it counts as a point (a choice)


class SafeRange(NamedTuple):
    """One line of the table: a quantity may go from ``low`` to ``high``, and is now ``value``, in ``unit``."""

    quantity: Quantity
    low: float
    value: float
    high: float
    unit: str


@dataclass(frozen=True, repr=False)
class SafeBox(Reported, NoTruthValue):
    """A box of loads that is proved safe.

    Attributes
    ----------
    load : Load
        The working point.
    ranges : tuple of SafeRange
        Mean force, amplitude, frequency: range of each, independent of the others; SI units.
    accuracy : float
        How closely the sides were searched, as a fraction of their distance.
    proof : RegionProof
        That every load of the box is safe on every rod within its tolerances.
    """

    ask = ".proof.stable"

    load: Load
    ranges: tuple[SafeRange, ...]
    accuracy: float
    proof: RegionProof

    @property
    def growth_tolerance(self) -> float:
        """Growth rate in 1/s up to which a mode counts as stable."""
        return self.proof.growth_tolerance

    @property
    def rod_tolerances(self) -> tuple[Side, ...]:
        """Parameters of the rod that were given, and the range of each."""
        return self.proof.box[3:]

    def in_units(self, **names: str) -> tuple[SafeRange, ...]:
        """Return the ranges in other units: ``in_units(mean="Fcr", frequency="Hz")``.

        Returns
        -------
        tuple of SafeRange
            Low end, working point and high end of each quantity.

        Raises
        ------
        TypeError, ValueError
            For a quantity that is not of the load, and for another unit.
        """
        wanted = dict(names)
        found = []
        for each in self.ranges:
            name = wanted.pop(each.quantity, each.unit)
            unit = units.unit(name, each.quantity, LOAD[each.quantity].kind, self.proof.subject.critical_force)
            found.append(
                SafeRange(each.quantity, unit.of(each.low), unit.of(each.value), unit.of(each.high), unit.name)
            )
        if wanted:
            raise validate.wrong_value(next(iter(wanted)), f"must be one of {', '.join(QUANTITIES)}")
        return tuple(found)

    def table(self, **names: str) -> str:
        """Return a table for an operator, in units as for `in_units`.

        Ends are rounded inwards to six digits, so that the printed box is proved, too.

        Returns
        -------
        str
            The table and the proof.

        Raises
        ------
        TypeError, ValueError
            As `in_units`.
        """
        table = self._table(dict(names))
        return f"{table}\n{self._proved({})}"

    def _proved(self, names: Mapping[str, str]) -> str:
        shown = self.proof.units_of_sides(names)
        tolerances = "".join(f"; every rod of {side.in_words(shown[side.name])}" for side in self.rod_tolerances)
        grows = f"no mode grows faster than {self.growth_tolerance:g} 1/s{tolerances}"
        return f"proved: {grows}; other loads may be stable, too"

    def _table(self, names: Mapping[str, str]) -> Table:
        rows = []
        for quantity, low, now, high, unit in self.in_units(**names):
            ends = ("fixed", _shown(now), "") if low == high else (_inward(low, up=True), _shown(now), _inward(high))
            rows.append((LOAD[quantity].words, *ends, unit))
        titles = ("", "from", "now", "to", "unit")
        widths = [max(map(len, column)) for column in zip(titles, *rows, strict=True)]
        layout = [f"<{widths[0]}", *(f">{width}" for width in widths[1:4]), ""]
        return Table(list(zip(titles, layout, strict=True)), rows)

    def report(self, units: Mapping[str, str] | None = None) -> Report:
        """Return the `table` and the proof.

        ``units`` in which to show mean, amplitude, frequency and the lengths and pressures of rods: ``{"mean": "Fcr",
        "frequency": "Hz", "length": "ft"}``; by default as in the question, see `floquetrod.units.AnswerUnits`.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.

        Raises
        ------
        TypeError, ValueError
            For another unit.
        """
        shown = shown_in(units, self.proof.subject, self.proof)
        table = self._table({name: shown[name].name for name in QUANTITIES})
        proved = self._proved({} if units is None else units)
        return Report(proved, (), table, assumptions=self.proof.assumptions)

    def as_dict(self) -> dict[str, Any]:
        """Return the proof and the ranges for JSON, in SI units.

        Returns
        -------
        dict of str
            Among them ``safe``, a list with a dict for each quantity.
        """
        return self.proof.as_dict() | {"safe": [each._asdict() for each in self.ranges]}

    def __repr__(self) -> str:
        """Return the table."""
        return self.table()


def largest_safe_box(
    rod: RodData,
    load: Load,
    judge: Callable[[float], RodStability],
    vary: Iterable[Quantity],
    growth_tolerance: float,
    parameters: Mapping[str, Any] | None,
    accuracy: float,
    progress: Progress | None,
) -> SafeBox:
    """Return the box of `Rod.largest_safe_box` about a load; ``judge`` returns the verdict on it with a tolerance."""
    chosen = _chosen(vary)
    tolerance = units.tolerance("growth_tolerance", growth_tolerance)
    accuracy = validate.within("accuracy", accuracy, 1e-4, 0.5, "it is a share of the width of the box")
    validate.progress(progress)
    warn_unless_uniform(rod, load)
    box = RodBox.of(rod, load, load.mean, load.amplitude, load.frequency, parameters)
    require_in_reach(box)
    proof = prove(box, tolerance)
    if not proof.stable:
        raise validate.wrong_value("load", f"must be a load that is proved stable, got {load}: {proof!r}")
    search = _SafeBoxSearch(
        box, tolerance, accuracy, {name: _safe_alone(rod, judge(tolerance), name) for name in chosen}, progress
    )
    widest = search.widest()
    ranges = tuple(
        SafeRange(name, widest.loads[name].low, getattr(load, name), widest.loads[name].high, LOAD[name].unit)
        for name in QUANTITIES
    )
    given = load.given_units.or_else(rod.given_units)
    return SafeBox(load, ranges, accuracy, prove(widest, tolerance).given_in(given))


def _chosen(vary: Iterable[Quantity]) -> tuple[Quantity, ...]:
    """Return the quantities that may vary, checked."""
    given = [validate.choice("vary", name, QUANTITIES) for name in validate.sequence("vary", vary, '("mean",)')]
    if not given:
        raise validate.wrong_value("vary", f"must name one of {', '.join(QUANTITIES)} at least, got none")
    return tuple(name for name in QUANTITIES if name in given)


def _safe_alone(rod: RodData, verdict: RodStability, name: Quantity) -> RealInterval:
    """Return the range in which one quantity alone may vary on this rod; ranges safe with others varying lie within."""
    value = getattr(verdict.load, name)
    if name == "frequency":
        low, high = 0.5 * value, 2.0 * value
    else:
        low, high = value - rod.critical_force, value + rod.critical_force
    if verdict.stable:  # else the load lies in a tongue so thin that only the proof resolves it
        below, above = verdict.margin(name).searched
        low, high = max(low, value - below), min(high, value + above)
    return RealInterval(max(low, 0.0) if name == "amplitude" else low, high)


@dataclass(frozen=True)
class _SafeBoxSearch:
    """The search for the box: proofs of windows, wider and wider."""

    point: RodBox
    tolerance: float
    accuracy: float
    alone: Mapping[Quantity, RealInterval]
    progress: Progress | None

    @cached_property
    def rods(self) -> tuple[RodData, ...]:
        """The rod in the middle of the box, and the rods in some of its corners."""
        names = self.point.varied_parameters
        corners = islice(product(("low", "high"), repeat=len(names)), _CORNERS if names else 0)
        sides = self.point.parameters
        ends = ({n: getattr(sides[n], end) for n, end in zip(names, corner, strict=True)} for corner in corners)
        middle = self.point.middle_rod()
        return (middle, *(middle.replace(**each) for each in ends))

    def widest(self) -> RodBox:
        """Return the box found."""
        scale = {name: self._scale(name) for name in self.alone}

        def window(size: float) -> RodBox:
            box = self.point
            for name, unit in scale.items():
                middle, ends = self.point.loads[name].low, self.alone[name]
                box = _with(box, name, max(ends.low, middle - size * unit), min(ends.high, middle + size * unit))
            return box

        rooms = [(ends.high - self.point.loads[name].low) / scale[name] for name, ends in self.alone.items()]
        rooms += [(self.point.loads[name].low - ends.low) / scale[name] for name, ends in self.alone.items()]
        size = self._farthest(lambda t: window(t), 0.0, min(filter(None, rooms), default=0.0))
        box = window(size)
        faces = [(name, side) for name in self.alone for side in (-1, 1)]
        for turn in range(_ROUNDS):
            moved = False
            for i, (name, side) in enumerate(faces):
                wider = self._pushed(box, name, side)
                width = wider.loads[name].width
                moved = moved or width - box.loads[name].width > self.accuracy * width
                box = wider
                if self.progress is not None:
                    self.progress(turn * len(faces) + i + 1, _ROUNDS * len(faces))
            if not moved:
                break
        return box

    def _pushed(self, box: RodBox, name: Quantity, side: int) -> RodBox:
        """Return the box with the face on one side of a quantity moved outwards as long as the box is proved stable."""
        ends, limit = box.loads[name], self.alone[name]

        def moved(t: float) -> RodBox:
            if side < 0:
                return _with(box, name, t, ends.high)
            return _with(box, name, ends.low, t)

        here, far = (ends.low, limit.low) if side < 0 else (ends.high, limit.high)
        return box if here == far else moved(self._farthest(moved, here, far))

    def _farthest(self, box_at: Callable[[float], RodBox], near: float, far: float) -> float:
        """Return how far from ``near`` to ``far`` boxes are proved, to the accuracy asked for."""
        if near == far or self._is_safe(box_at(far)):
            return far
        start = near
        for _ in range(_HALVINGS):
            middle = 0.5 * (near + far)
            if self._is_safe(box_at(middle)):
                near = middle
            else:
                far = middle
            if abs(far - near) <= 0.5 * self.accuracy * abs(near - start):
                break
        return near

    def _is_safe(self, box: RodBox) -> bool:
        """Return whether a box is proved safe; one with an unsafe load among some on a grid is not worth the work."""
        sides = [np.linspace(box.loads[name].low, box.loads[name].high, _GRID) for name in QUANTITIES]
        fixed = [side[:1] if side[0] == side[-1] else side for side in sides]
        loads = np.meshgrid(*fixed, indexing="ij")
        for rod in self.rods:
            if not ModalSystems(mode_constants(rod), Loads.of(*loads)).are_stable(self.tolerance, 1).all():
                return False
        return is_proved_stable(box, self.tolerance, _BOXES)

    def _scale(self, name: Quantity) -> float:
        """Return the unit of the width of a window: the quantity, or a critical force where it is zero."""
        value = abs(self.point.loads[name].low)
        return value if value > 0.0 else self.point.rod.critical_force


def _with(box: RodBox, name: Quantity, low: float, high: float) -> RodBox:
    """Return a box of loads with one side changed."""
    return replace(box, loads={**box.loads, name: RealInterval(low, high)})


def _shown(value: float) -> str:
    return f"{value:.6g}"


def _inward(value: float, *, up: bool = False) -> str:
    """Return a number with six digits, rounded up or down."""
    if value == 0.0:
        return "0"
    unit = 10.0 ** (math.floor(math.log10(abs(value))) - 5)
    steps = value / unit
    return f"{(math.ceil(steps) if up else math.floor(steps)) * unit:.6g}"
