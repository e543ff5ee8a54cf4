"""What is proved of a whole box, of an equation's parameters or of loads and rods, and the search that proves it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from floquetrod import units as known
from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod._util.compilation import compiled_for, runner
from floquetrod._util.content import NoTruthValue
from floquetrod._util.result_report import Report, Reported, number
from floquetrod.floquet.problems import KINDS
from floquetrod.floquet.proof.kernels import regions as kernels
from floquetrod.floquet.proof.kernels.regions_boxes import tail_modes
from floquetrod.floquet.references import ROD, references

_MOST_AT_ONCE = 100_000  # parts that wait in one search: tens of megabytes (a choice)
_STEPS = 2_000  # parts examined between two reports of progress: some tens of milliseconds (a choice)
_COMPILE_AFTER = 1000  # rows of the modes' Hill matrices judged before kernels are compiled (a choice)

_NAMES = {"mean": "mean force"}

RegionStatus: TypeAlias = Literal["stable", "unstable", "mixed", "undecided"]


class Side(NamedTuple):
    """One side of a box: every value of a quantity from ``low`` to ``high``, both included, in ``unit``."""

    name: str
    low: float
    high: float
    unit: str

    def __str__(self) -> str:
        """Return, say, "mean 0.5 to 0.6 N"."""
        return self.in_words(known.Unit(self.unit, 1.0))

    def in_words(self, unit: known.Unit) -> str:
        """Return name and ends in a unit."""
        return f"{self.name.replace('_', ' ')} {self.values(unit)}"

    def values(self, unit: known.Unit) -> str:
        """Return the ends in a unit."""
        return f"{'' if self.low == self.high else f'{unit.of(self.low):.6g} to '}{unit.show(self.high)}"


class Shares(NamedTuple):
    """How much of a box, by volume, was proved stable and unstable; the rest is open."""

    stable: float
    unstable: float

    def with_status(self, status: RegionStatus) -> Shares:
        """Return the same, of a box that is decided all or nothing."""
        is_decided = status in ("stable", "unstable")
        return Shares(float(status == "stable"), float(status == "unstable")) if is_decided else self


@dataclass(frozen=True, repr=False)
class RegionProof(known.InUnits, Reported, NoTruthValue):
    """A proof for every point of a box.

    Attributes
    ----------
    subject : Rod or callable
        The rod, which gives the fixed parameters; of equations their class, or a function of the parameters.
    status : {"stable", "unstable", "mixed", "undecided"}
        "stable": at every point nothing grows faster than ``growth_tolerance``; "unstable": at every point something
        does; "mixed": each holds somewhere, see ``examples``; "undecided": the work allowed was not enough.
    box : tuple of Side
        The box.
    examples : tuple
        Where mixed, a point proved stable and one proved unstable: `RodExample` with a load and a rod, of an equation
        `Proof`.  One of them where only one was found.
    growth_tolerance : float
        Growth in ``growth_unit`` that counts as none.
    growth_unit : str
        "1/s", of an equation "per tau" or, in a and q, "per z", of a family "per unit of time".
    modes : int
        Modes examined, 1 to this; 1 for an equation.
    left_out_bound : float
        Bound on the growth of every other mode, over the whole box; 0 for an equation.
    boxes : int
        Parts of the box that were examined.
    shares : Shares
        How much of the box was proved stable, and unstable.
    statement : str
        The proved statement, in a sentence.
    note : str
        Where undecided, why.
    assumptions : tuple of str
        Assumptions of the proof.
    """

    ask = ".stable (True, False, or None when mixed or undecided)"

    subject: Any
    status: RegionStatus
    box: tuple[Side, ...]
    examples: tuple[Any, ...]
    growth_tolerance: float
    growth_unit: str
    modes: int
    left_out_bound: float
    boxes: int
    shares: Shares
    statement: str
    note: str
    assumptions: tuple[str, ...]
    _sources: tuple[str, ...] = field(default=KINDS[0].proof_sources, kw_only=True)  # for `references`

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite, in plain text with DOI, floquetrod first, then the sources of the methods used."""
        return references(self._sources, ROD if self._is_of_rods else ())

    @property
    def stable(self) -> bool | None:
        """True, False, or None when mixed or undecided."""
        return {"stable": True, "unstable": False}.get(self.status)

    def report(self, units: Mapping[str, str] | None = None) -> Report:
        """Return the proof in lines: the box, examples, modes and assumptions.

        Parameters
        ----------
        units : mapping, optional
            In which to show sides of the box: ``{"mean": "Fcr", "frequency": "Hz"}``, for rods by kind:
            ``{"length": "ft", "pressure": "ksi"}``, radii beside feet in inches; by default as in the question, see
            `floquetrod.units.AnswerUnits`.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.
        """
        shown = self.units_of_sides({} if units is None else units)
        loads, rods = (self.box[:3], self.box[3:]) if self._is_of_rods else ((), ())
        lines = [
            ("" if i else "load", f"{_NAMES.get(side.name, side.name)} {side.values(shown[side.name])}")
            for i, side in enumerate(loads)
        ]
        lines += [("" if i else "rods", side.in_words(shown[side.name])) for i, side in enumerate(rods)]
        lines += [("" if i else "box", str(side)) for i, side in enumerate(() if self._is_of_rods else self.box)]
        if rods and any(unit.name == "Fcr" for unit in shown.values()):
            lines.append(("", "Fcr is that of the rod as it is described, for every rod of the box"))
        for each in self.examples:
            lines.append(("example", f"{each.status}: {each.where(shown, rods)}: {each.statement}"))
        if self._is_of_rods:
            rest = "no higher mode grows"
            if self.left_out_bound > 0.0:
                rest = f"every higher mode grows at less than {self.left_out_bound:.1g} 1/s"
            lines.append(("modes", f"1 to {self.modes}: {rest}"))
        lines += [("note", self.note)] if self.note else []
        return Report(self._headline, lines, assumptions=self.assumptions)

    @property
    def _is_of_rods(self) -> bool:
        return self.growth_unit == "1/s"

    def units_of_sides(self, names: Mapping[str, str]) -> dict[str, known.Unit]:
        """Return the unit to show each side in, see `report`."""
        critical, given = getattr(self.subject, "critical_force", None), self.given_units
        loads = {"mean": given.force, "amplitude": given.force, "frequency": given.frequency}
        usual = loads | {"length": given.length, "pressure": given.pressure}
        names = {name: unit for name, unit in usual.items() if unit} | dict(names)
        units = {}
        for side in self.box:
            kind = known.kind_of(side.unit) or "ratio"
            named = names.get(side.name, names.get(kind) if side in self.box[3:] else None)
            if named == "ft" and side.name.endswith("radius"):
                named = "in"
            units[side.name] = known.Unit(side.unit, 1.0) if named is None else known.unit(named, kind, kind, critical)
        return units

    @property
    def _headline(self) -> str:
        limit = f"{self.growth_tolerance:g} {self.growth_unit}"
        at, point, what = ("under", "load", "a mode") if self._is_of_rods else ("at", "point", "a solution")
        return {
            "stable": f"PROVED STABLE: {at} no {point} of the box does {what} grow faster than {limit}",
            "unstable": f"PROVED UNSTABLE: {at} every {point} of the box {what} grows faster than {limit}",
            "mixed": f"MIXED: {at} some {point}s of the box {what} grows faster than {limit}, {at} others none",
            "undecided": "UNDECIDED",
        }[self.status]

    def as_dict(self) -> dict[str, Any]:
        """Return the proof for JSON, in SI units; None for a bound that is infinite."""
        per = {"1/s": "per_s", "per tau": "per_tau", "per z": "per_z"}.get(self.growth_unit, "per_unit_time")
        return {
            "status": self.status,
            "box": [side._asdict() for side in self.box],
            f"growth_tolerance_{per}": self.growth_tolerance,
            "examples": [example.as_dict() for example in self.examples],
            "modes": self.modes,
            f"left_out_bound_{per}": number(self.left_out_bound),
            "boxes": self.boxes,
            "share_stable": self.shares.stable,
            "share_unstable": self.shares.unstable,
            "statement": self.statement,
            "note": self.note,
            "assumptions": list(self.assumptions),
        }

    def __repr__(self) -> str:
        """Return the proof as a sentence."""
        work = f"{self.boxes} box{'es' * (self.boxes != 1)}"
        return f"<{self.status}: {self.statement} ({'; '.join(filter(None, [self.note, work]))})>"


def is_side(value: Any) -> bool:
    """Return whether a value is a side of a box, (low, high): a tuple or a list of two numbers, not of sequences."""
    is_pair = isinstance(value, tuple | list) and len(value) == 2
    return is_pair and all(isinstance(end, str) or not validate.iterable(end) for end in value)


def side_ends(name: str, value: Any, element: Callable[[str, Any], Any]) -> tuple[Any, Any]:
    """Return both ends of a side given as (low, high), or as a number, which is both."""
    if not isinstance(value, tuple | list):
        number = element(name, value)
        return number, number
    if not is_side(value):
        raise TypeError(f"{name} must be a number or two, (low, high), got {validate.short(value)}")
    low, high = (element(f"{name}[{i}]", end) for i, end in enumerate(value))
    if low > high:
        raise ValueError(f"{name} must not decrease, got {validate.short(tuple(value))}; give the lower end first")
    return low, high


LowHigh: TypeAlias = tuple[float, float]


class ModeBox(NamedTuple):
    """Low and high ends of all numbers in q'' + 2 c q' + (c1 m^4 - c2 (m^2 - m_0^2) F(t) + Omega^2) q = 0, in SI units.

    In the order of the rows that kernels take, `floquetrod.floquet.proof.kernels.regions_boxes`.
    """

    mean: LowHigh  # of the load, N
    amplitude: LowHigh  # N
    frequency: LowHigh  # rad/s
    bending: LowHigh  # c1, 1/s^2
    per_newton: LowHigh  # c2, 1/(N s^2)
    restoring: LowHigh  # Omega^2, 1/s^2
    neutral_squared: LowHigh  # m_0^2
    damping_rate: LowHigh  # c, 1/s


class Subdivision(NamedTuple):
    """What a subdivision of one box of loads and of the numbers of the modes came to."""

    shares: Shares  # without growth beyond the tolerance, and with
    finished: bool  # nothing is open
    too_narrow: bool  # parts are open that cannot be halved any more
    stable_box: ModeBox | None  # a part proved stable
    unstable_box: ModeBox | None  # a part proved unstable
    growing_mode: int  # the mode that grows in it; 0 without
    boxes: int  # parts examined


def subdivide(
    box: ModeBox, last: int, tolerance: float, max_boxes: int, progress: Callable[[int], None] | None = None
) -> Subdivision:
    """Prove what can be proved of the modes 1 to ``last`` over a box, halved until it is decided.

    Parameters
    ----------
    box : ModeBox
    last : int
    tolerance : float
        Growth in 1/s that counts as none.
    max_boxes : int
        Parts to look at before it is given up.  It ends, too, once one is proved stable and one unstable.
    progress : callable, optional
        Called repeatedly with the number of parts examined.
    """
    search = kernels.box_search(np.array(box), last, min(max_boxes, _MOST_AT_ONCE))
    counts = search.counts
    # The box as a whole is judged by interpreted kernels, while there are few: most need no more, and no numba.
    first: Any = runner(kernels.certify_box, last * _rows(box), interpret_up_to=1, compile_after=_COMPILE_AFTER)
    with np.errstate(all="ignore"):
        goes_on = first(*search, tolerance, tolerance, 1)
    if goes_on and counts[kernels.WAITING]:
        run: Any = compiled_for(kernels.certify_box, *search, tolerance, tolerance, _STEPS)
        while goes_on and counts[kernels.DONE] < max_boxes:
            goes_on = run(*search, tolerance, tolerance, min(_STEPS, max_boxes - int(counts[kernels.DONE])))
            if progress is not None:
                progress(int(counts[kernels.DONE]))
    stable, unstable = map(_box, search.examples)
    return Subdivision(
        Shares(*search.shares[:2].tolist()),
        not counts[kernels.WAITING] and not counts[kernels.OPEN_PARTS],
        counts[kernels.OPEN_PARTS] > 0,
        stable,
        unstable,
        int(counts[kernels.GROWING_MODE]),
        int(counts[kernels.DONE]),
    )


def modes_of_box(box: ModeBox, tolerance: float, negligible: float, most: int) -> tuple[int, float]:
    """Return how many modes to look at over a box, at most ``most``, and a bound in 1/s on the growth of all others.

    The bound is at most the tolerance, or ``negligible`` where tolerance and damping together are less.
    """
    smallest = 0.0 if tolerance + box.damping_rate[0] >= negligible else negligible
    run: Any = runner(tail_modes, _rows(box), interpret_up_to=1, compile_after=_COMPILE_AFTER)
    with np.errstate(all="ignore"):
        last, bound = run(np.array(box), tolerance, smallest, most)
    return int(last), float(bound)


def _rows(box: ModeBox) -> int:
    """Return about how many rows of its Hill matrix the mode has that the largest force pushes hardest."""
    force, swing = (max(box.mean[1], 0.0) + box.amplitude[1]) * box.per_newton[1], abs(box.restoring[1])
    fastest = math.sqrt(max(force * force / max(box.bending[0], 1e-300), swing) if force else swing)
    return 2 + int(min(2.0 * fastest / box.frequency[0], 1e6))


def _box(part: Floats) -> ModeBox | None:
    """Return a box from the rows of the kernels, None for one of NaN."""
    return None if np.isnan(part).any() else ModeBox(*((low, high) for low, high in part.tolist()))
