"""`Rod.certify`: proofs about every load of a box, on every rod within its tolerances."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np

from floquetrod import mathieu, units
from floquetrod._util import validate
from floquetrod._util.progress import Progress
from floquetrod._util.spans import complement
from floquetrod.floquet.proof.proof import MAX_BOXES
from floquetrod.floquet.proof.region_proof import (
    ModeBox,
    RegionProof,
    RegionStatus,
    Shares,
    Subdivision,
    modes_of_box,
    subdivide,
)
from floquetrod.rod.answers.rod_box import RodBox, RodExample
from floquetrod.rod.loads.load import QUANTITIES, Load, Loads, Quantity
from floquetrod.rod.mode_equations.modal_systems import ModalSystem
from floquetrod.rod.mode_equations.unstable_loads import unstable_loads
from floquetrod.rod.model.assumptions import rod_assumptions, warn_unless_uniform
from floquetrod.rod.model.constants import MOST_MODES, NEGLIGIBLE_GROWTH, mode_constants
from floquetrod.rod.model.data import RodData

_BOXES_A_ROD = 64  # parts of a box examined before its rods are halved: a millisecond or so
_FEWEST_RODS = 16  # boxes of rods examined, at least; at most one for each so many parts (a choice)
_BOTH = {"stable", "unstable"}
_CANDIDATES = 8  # times that parts are tried as examples, one of each kind: some milliseconds each
_LEAST_GROWTH = 1e-9  # in 1/s: growth that an example is searched with where less would do, tenfold in 73 years


def certify_rods(
    rod: RodData,
    like: Load,
    sides: tuple[Any, Any, Any],
    growth_tolerance: float,
    parameters: Mapping[str, Any] | None,
    max_boxes: int,
    progress: Progress | None,
) -> RegionProof:
    """Return the proof of `Rod.certify`; ``sides`` are the ranges of mean force, amplitude and frequency."""
    tolerance = units.tolerance("growth_tolerance", growth_tolerance)
    max_boxes = validate.integer("max_boxes", max_boxes, 1)
    validate.progress(progress)
    box = RodBox.of(rod, like, *sides, parameters)
    warn_unless_uniform(rod, box.template.with_numbers(*(box.loads[name].high for name in QUANTITIES)))
    require_in_reach(box)
    return prove(box, tolerance, max_boxes, progress).given_in(units_of_box(sides, like, rod))


def units_of_box(sides: tuple[Any, Any, Any], like: Load, rod: RodData) -> units.GivenUnits:
    """Return the units in which the sides of a box of loads were given, else the units of the load and the rod."""
    return units.GivenUnits.of(force=sides[:2], frequency=sides[2]).or_else(like.given_units, rod.given_units)


def require_in_reach(box: RodBox) -> None:
    """Raise ValueError for a box with loads that need too many modes, or whose mode equations are too large."""
    ends = [np.array([box.loads[name].low, box.loads[name].high]) for name in QUANTITIES]
    for each in box.corner_rods():
        mode_constants(each).require_in_reach(Loads((2,), *ends))


def prove(box: RodBox, tolerance: float, max_boxes: int = MAX_BOXES, progress: Progress | None = None) -> RegionProof:
    """Return the proof about a box that has been checked."""
    return _Proving(box, tolerance, max_boxes, progress).proof()


def is_proved_stable(box: RodBox, tolerance: float, max_boxes: int) -> bool:
    """Return whether all of a box that has been checked is proved stable; no examples are searched where it is not."""
    return _Proving(box, tolerance, max_boxes, None, searches=False).proof().status == "stable"


@dataclass
class _Proving:
    """A proof under way: boxes of rods wait, and are halved where the loads alone do not decide."""

    box: RodBox
    tolerance: float
    max_boxes: int
    progress: Progress | None
    searches: bool = True
    boxes: int = 0
    proved_stable: float = 0.0
    growing: float = 0.0
    unfinished: bool = False
    too_narrow: bool = False
    tried: int = 0
    examples: dict[str, RodExample] = field(default_factory=dict)
    candidates: dict[str, tuple[RodBox, ModeBox]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Count the modes that all of the box needs."""
        ends = self.box.mode_box()
        self.modes, self.left_out = modes_of_box(ends, self.tolerance, NEGLIGIBLE_GROWTH, MOST_MODES)
        self.tail_is_stable = self.left_out <= self.tolerance

    def proof(self) -> RegionProof:
        """Work until the box is decided, or the work allowed is done."""
        waiting: deque[tuple[RodBox, float]] = deque([(self.box, 1.0)])
        rods = max(_FEWEST_RODS, self.max_boxes // _BOXES_A_ROD)
        while waiting and self.boxes < self.max_boxes and rods > 0:
            rods -= 1
            part, share = waiting.popleft()
            subdivision = self._subdivided(part, _BOXES_A_ROD)
            if self._is_mixed():
                break
            if part is self.box and self.searches and not _is_decided(subdivision):
                self._search_lines(part, middle_only=True)
                if self._is_mixed():
                    break
            if not self.searches and subdivision.unstable_box is not None and not part.varied_parameters:
                self.unfinished = True
                break
            if not _is_decided(subdivision) and part.varied_parameters:
                waiting.extend((half, 0.5 * share) for half in part.halves())
                continue
            if not _is_decided(subdivision):
                subdivision = self._subdivided(part, self.max_boxes - self.boxes)
            self.unfinished = self.unfinished or not _is_decided(subdivision)
            self.too_narrow = self.too_narrow or subdivision.too_narrow
            self.proved_stable += share * subdivision.shares.stable
            self.growing += share * subdivision.shares.unstable
        self.unfinished = self.unfinished or bool(waiting)
        if self.searches and self.unfinished and not self._is_mixed():
            self._search_lines(self.box, middle_only=False)
        return self._concluded()

    def _subdivided(self, part: RodBox, most: int) -> Subdivision:
        """Look at up to ``most`` parts of the loads on a box of rods, and keep what may give an example."""

        def report(done: int) -> None:
            if self.progress is not None:
                self.progress(min(self.boxes + done, self.max_boxes), self.max_boxes)

        allowed = max(1, min(most, self.max_boxes - self.boxes))
        subdivision = subdivide(part.mode_box(), self.modes, self.tolerance, allowed, report)
        self.boxes += subdivision.boxes
        for status, example in (("stable", subdivision.stable_box), ("unstable", subdivision.unstable_box)):
            if example is not None:
                self.candidates[status] = part, example
        return subdivision

    def _is_mixed(self) -> bool:
        """Return whether there is a proved example of each kind; proves candidates where there is one of each.

        Subdivision halves the coefficients of the modes independently, so that a decided part may belong to no rod: a
        load on a rod in it is proved again.
        """
        if self.searches and self.tried < _CANDIDATES and self.examples.keys() | self.candidates.keys() >= _BOTH:
            self.tried += 1
            for status, (part, example) in list(self.candidates.items()):
                load = part.template.with_numbers(*(0.5 * (low + high) for low, high in example[:3]))
                if status not in self.examples:
                    any(self._keep(load, rod, status) for rod in part.corner_rods())
            self.candidates.clear()
        return len(self.examples) == 2

    def _keep(self, load: Load, rod: RodData, status: str) -> bool:
        """Keep a load on a rod as an example if it is proved to have this status; return whether it was."""
        example = self._point(load, rod)
        if example is not None and example.status == status:
            self.examples[status] = example
            return True
        return False

    def _point(self, load: Load, rod: RodData) -> RodExample | None:
        """Return the proof about one load on one rod, None where there is none."""
        box = self.box.point(load, rod).mode_box()
        modes, bound = modes_of_box(box, self.tolerance, NEGLIGIBLE_GROWTH, MOST_MODES)
        subdivision = subdivide(box, modes, self.tolerance, 1)
        self.boxes += subdivision.boxes
        limit = f"{self.tolerance:g} 1/s"
        if subdivision.unstable_box is not None:
            mode = subdivision.growing_mode
            return RodExample("unstable", load, rod, f"mode {mode} grows faster than {limit}{_rate(rod, load, mode)}")
        if subdivision.stable_box is None or bound > self.tolerance:
            return None
        rest = "no higher mode grows" if bound == 0.0 else f"every higher mode grows at less than {bound:.2g} 1/s"
        statement = f"modes 1 to {modes} grow at no more than {limit}, {rest}"
        return RodExample("stable", load, rod, statement)

    def _search_lines(self, part: RodBox, *, middle_only: bool) -> None:
        """Look for examples along lines through a box of loads, where tongues are found however thin."""
        for rod in part.corner_rods():
            for quantity, load in _lines(part, middle_only=middle_only):
                if len(self.examples) == 2:
                    return
                self._search_line(part, rod, quantity, load)

    def _search_line(self, part: RodBox, rod: RodData, quantity: Quantity, load: Load) -> None:
        """Look for examples along one quantity of the load: in the middle of the widest parts that grow, or do not."""
        side = part.loads[quantity]
        bounds = (side.low, side.high)
        level = max(self.tolerance, _LEAST_GROWTH)
        system = ModalSystem(mode_constants(rod), load.varied(quantity, side.high), tuple(range(1, self.modes + 1)))
        intervals = unstable_loads(quantity, system, level, bounds, union=True).intervals
        for status, parts in (("unstable", intervals), ("stable", complement(bounds, intervals))):
            widest = max(parts, key=lambda part: part.high - part.low, default=None)
            if widest is not None and status not in self.examples:
                middle = min(max(0.5 * (widest.low + widest.high), side.low), side.high)
                self._keep(load.varied(quantity, middle), rod, status)

    def _concluded(self) -> RegionProof:
        """Return the proof that the work came to."""
        status: RegionStatus = "undecided"
        if len(self.examples) == 2:
            status = "mixed"
        elif not self.unfinished and self.growing == 0.0:
            status = "stable" if self.tail_is_stable else "undecided"
        elif not self.unfinished and self.proved_stable == 0.0:
            status = "unstable"
        proved = Shares(min(1.0, self.proved_stable) if self.tail_is_stable else 0.0, min(1.0, self.growing))
        shares = proved.with_status(status)
        return RegionProof(
            subject=self.box.rod,
            status=status,
            box=self.box.sides,
            examples=tuple(self.examples[kind] for kind in ("stable", "unstable") if kind in self.examples)
            if status in ("mixed", "undecided")
            else (),
            growth_tolerance=self.tolerance,
            growth_unit="1/s",
            modes=self.modes,
            left_out_bound=self.left_out,
            boxes=self.boxes,
            shares=shares,
            statement=self._statement(status),
            note=self._note(status, shares),
            assumptions=_assumptions(self.box),
        )

    def _statement(self, status: RegionStatus) -> str:
        """Return the statement of the proof, in a sentence."""
        loads = ", ".join(str(side) for side in self.box.sides[:3])
        rods = ", ".join(str(side) for side in self.box.sides[3:])
        where = f"under every load of {loads}" + (f" on every rod of {rods}" if rods else "")
        limit = f"{self.tolerance:g} 1/s"
        if status == "stable":
            rest = "no higher mode grows" if self.left_out == 0.0 else f"every higher one below {self.left_out:.1g} 1/s"
            return f"{where} no mode grows faster than {limit}; modes 1 to {self.modes}, {rest}"
        if status == "unstable":
            return f"{where} a mode grows faster than {limit}"
        if status == "mixed":
            unstable = next(each for each in self.examples.values() if each.status == "unstable")
            return f"{where}: some are stable, some are not; {unstable.statement} under {unstable.load}"
        return f"{where} nothing is proved"

    def _note(self, status: RegionStatus, shares: Shares) -> str:
        """Return why nothing was decided."""
        if status != "undecided":
            return ""
        if self.tolerance == 0.0 and self.box.constants().damping_rate.low == 0.0:
            return (
                "without damping, tongues too thin to matter are everywhere: with growth_tolerance=0 no box is stable; "
                "1e-6 1/s is tenfold growth in a month"
            )
        known = f"{100.0 * shares.stable:.3g} % of it proved stable, {100.0 * shares.unstable:.3g} % unstable"
        if not self.tail_is_stable:
            return f"modes after {self.modes} are not proved to grow as slowly; {known}"
        why = "parts too narrow to be halved are open" if self.too_narrow else f"stopped after {self.boxes} parts"
        return f"{why}; {known}"


def _is_decided(subdivision: Subdivision) -> bool:
    """Return whether all of a box was proved, and proved alike."""
    return subdivision.finished and (subdivision.stable_box is None or subdivision.unstable_box is None)


def _lines(part: RodBox, *, middle_only: bool) -> Iterator[tuple[Quantity, Load]]:
    """Yield the varied quantities of a box of loads, each with the loads that the line passes through."""
    varied = [name for name in QUANTITIES if part.loads[name].width > 0.0]
    for quantity in varied:
        others = [name for name in QUANTITIES if name != quantity]
        sides = [part.loads[name] for name in others]
        for places in product(
            *([side.middle] if middle_only else {side.low, side.middle, side.high} for side in sides)
        ):
            numbers: dict[str, float] = dict(zip(others, places, strict=True))
            numbers[quantity] = part.loads[quantity].high
            yield quantity, part.template.with_numbers(**numbers)


def _rate(rod: RodData, load: Load, mode: int) -> str:
    """Return the computed growth rate of a mode as a phrase of a statement; "" where it is too slow for doubles."""
    system = ModalSystem(mode_constants(rod), load, (mode,))
    rate = float(mathieu.growth_rate(system.alpha, system.beta, system.damping)[0]) * system.frequency
    return f", at {rate:.4g} 1/s as computed" if rate > 0.0 and math.isfinite(rate) else ""


def _assumptions(box: RodBox) -> tuple[str, ...]:
    """Return the assumptions of the proof."""
    return (
        "Eq. (1): hinged ends, a sine force uniform along the rod, no friction",
        *rod_assumptions(box.rod, box.template, box.parameters),
        "each rod is uniform, its parameters constant in time",
        "doubles are added, multiplied and divided as IEEE 754 says, rounded to nearest",
    )
