"""A rod held by friction: which modes a kick destabilises, and the smallest kick that destabilises one."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util.arrays import shaped
from floquetrod._util.caching import cached_property
from floquetrod._util.interchange import by_keys, plain
from floquetrod._util.progress import Progress
from floquetrod._util.result_report import Report, Reported, Table
from floquetrod._util.suggest import listed
from floquetrod.equations import FrictionalMathieu, Mathieu
from floquetrod.floquet.margins import Margin
from floquetrod.floquet.verdict import Status, Verdict
from floquetrod.friction.critical_kicks import known_bounds
from floquetrod.friction.fate_of_kicks import BOUNDED, ESCAPES, UNDECIDED, Fate, known_fate, known_fates
from floquetrod.friction.inputs import Equations
from floquetrod.rod.answers.reports import shown_in
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.answers.search_pieces import MARGIN_SECONDS
from floquetrod.rod.friction.mode_friction import ModeFriction, kicks_of, mode_friction
from floquetrod.rod.loads.load import Quantity
from floquetrod.rod.mode_equations.modal_systems import GrowingModes, ModalSystems
from floquetrod.rod.model.data import RodData
from floquetrod.units import Unit

_AT_ONCE = 4096  # loads whose modes are held at once: some megabytes


class CriticalKick(NamedTuple):
    """Smallest kick found to buckle the rod, the mode it buckles into, and the proved bound.

    Attributes
    ----------
    kick : float or ndarray
        The smallest found, a transverse velocity in m/s; infinite where no kick buckles the rod, NaN where that could
        not be decided.
    mode : int or None, or ndarray
        The mode that it destabilises; none is 0 over arrays of loads.
    none_up_to : float or ndarray
        Proved: no kick up to it, m/s, destabilises a mode (that grows faster than the tolerance).
    """

    kick: Any
    mode: Any
    none_up_to: Any

    def needed(self, shown: Unit) -> str:
        """Return the smallest kick found, of one load, in a sentence."""
        if math.isinf(self.kick):
            return "no kick buckles the rod: no mode grows even without friction"
        if self.mode is None:
            return "the smallest kick that buckles the rod could not be decided"
        return f"{shown.show(self.kick)} is the smallest found to buckle the rod, into mode {self.mode}"

    def proved(self, shown: Unit) -> str:
        """Return the proved bound on kicks, of one load, in a sentence; "" where none is needed."""
        if not math.isfinite(self.none_up_to):
            return ""
        if self.none_up_to == 0.0:
            return "nothing for any kick, however small"
        return f"no kick up to {shown.show(self.none_up_to)} buckles the rod"


@dataclass(frozen=True, kw_only=True, repr=False)
class FrictionalRodStability(Reported, Verdict):
    """Verdict on a rod with friction whose modes are all kicked alike, in 1/s and s.

    It has all that every `Verdict` has.  Stable when no mode escapes; the growth rate is that at which the fastest mode
    that escapes grows in the end; exponents, error and cost are taken from ``linear``.

    Attributes
    ----------
    friction : float
        Coefficient of friction mu.
    kick : float
        Transverse velocity of each mode in m/s.
    in_modes : ModeFriction
        Friction and kick in the mode equations.
    linear : RodStability
        Verdict without friction; rod, load and modes are there.
    fates : tuple of Fate
        Of the modes in ``modes``.
    """

    friction: float
    kick: float
    in_modes: ModeFriction
    linear: RodStability
    fates: tuple[Fate, ...]

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite, in plain text with DOI, floquetrod first, then the sources of the methods used."""
        return self.linear.references

    @property
    def modes(self) -> tuple[int, ...]:
        """Modes that grow, or may grow, without friction; no kick destabilises any other."""
        return tuple(_growing(self.linear))

    @property
    def unstable_modes(self) -> tuple[int, ...]:
        """Modes that the kick destabilises; they escape."""
        return tuple(m for m, fate in zip(self.modes, self.fates, strict=True) if fate.status == "escapes")

    @cached_property
    def critical_kick(self) -> CriticalKick:
        """Smallest kick found to buckle the rod, the mode it buckles into, and the kick up to which none does."""
        return critical_kick(self.linear, self.friction)

    @cached_property
    def critical_kicks(self) -> dict[int, float]:
        """Smallest kick in m/s found to destabilise each of ``modes``."""
        growing, rod, load = _as_arrays(_growing(self.linear)), self.linear.rod, self.linear.load
        ones, every = np.ones(growing.load.size), Equations(*growing[2:])
        ratio = known_bounds(every, ones, np.inf * ones, None).smallest_found
        kicks = kicks_of(rod, self.friction, load.amplitude, load.frequency, ratio)
        return dict(zip(growing.mode.tolist(), kicks.tolist(), strict=True))

    @property
    def has_quick_margins(self) -> bool:
        """Whether the margins of ``linear`` take some seconds at most."""
        return self.linear.has_quick_margins

    def margins(self, seconds: float = MARGIN_SECONDS, progress: Progress | None = None) -> dict[Quantity, Margin]:
        """Return the margins of ``linear``, see `RodStability.margins`.

        Returns
        -------
        dict of str to Margin
            By "mean", "amplitude" and "frequency".

        Raises
        ------
        ValueError
            For ``seconds`` of zero or less.
        """
        return self.linear.margins(seconds, progress)

    def plot(self, ax: Any = None) -> Any:
        """Draw the verdict ``linear``.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.

        Raises
        ------
        ValueError
            Where modes are independent and none grows.
        """
        return self.linear.plot(ax)

    def report(
        self, units: Mapping[str, str] | None = None, margins: Mapping[Quantity, Margin] | None = None
    ) -> Report:
        """Return the verdict in lines, a table of the modes that grow without friction, and the report of `linear`.

        Parameters
        ----------
        units : mapping, optional
            In which to show mean, amplitude, frequency and kick: ``{"mean": "Fcr", "kick": "mm/s"}``.
        margins : mapping, optional
            The margins of ``linear``, which its ``margins`` returns.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.
        """
        shown = shown_in(units, self.linear.rod, self.linear.load)["kick"]
        known, inside = self.critical_kick, self.in_modes
        slides = shown.show(inside.v_a, 3)
        lines = [
            ("friction", f"mu {self.friction:g}: gamma {inside.gamma:.4g}; the rod slides axially at {slides}"),
            ("kick", f"{shown.show(self.kick)} in each mode: eps {inside.epsilon:.4g}"),
            ("needed", known.needed(shown)),
        ]
        proved = known.proved(shown)
        lines += [("proved", proved)] if proved else []
        modes = self.unstable_modes
        named = f"mode{'s' * (len(modes) > 1)} {listed(modes)}" if modes else "no mode"
        grows = "whether the kick destabilises a mode is not decided"
        if self.status != "undecided":
            grows = f"the kick of {shown.show(self.kick, 3)} destabilises {named}"
        without = self.linear.report(units, margins)
        without = replace(without, headline=f"without friction:\n{without.headline}", assumptions=())
        return Report(f"{self.status.upper()}: {grows}", lines, self._table(shown), without, self.assumptions)

    def _table(self, shown: Unit) -> Table | None:
        """Return the modes that grow without friction, None where none does."""
        rows = [
            (str(mode), f"{shown.of(self.critical_kicks[mode]):.6g}", f"{fate.status}: {fate.reason}")
            for mode, fate in zip(self.modes, self.fates, strict=True)
        ]
        columns = [("mode", ">4"), (f"kick needed {shown.name}", ">16"), ("this kick", "")]
        return Table(columns, rows) if rows else None

    def as_dict(self, margins: Mapping[Quantity, Margin] | None = None) -> dict[str, Any]:
        """Return the verdicts with and without friction as numbers for JSON, units in the keys.

        None stands for infinite or unknown numbers; ``margins`` are the margins of ``linear``.

        Returns
        -------
        dict of str
            Two dicts, ``with_friction`` and ``without_friction``.
        """
        modes = [
            {"mode": mode, "critical_kick_m_per_s": plain(self.critical_kicks[mode]), "fate": fate.status}
            for mode, fate in zip(self.modes, self.fates, strict=True)
        ]
        kicked = by_keys(
            self,
            "status unstable_modes mu=friction mu_theta=in_modes.mu_theta kick_m_per_s "
            "axial_velocity_m_per_s=in_modes.v_a gamma=in_modes.gamma epsilon=in_modes.epsilon",
        )
        needed = by_keys(
            self.critical_kick, "critical_kick_m_per_s=kick critical_mode=mode no_kick_buckles_up_to_m_per_s=none_up_to"
        )
        return {"with_friction": kicked | needed | {"modes": modes}, "without_friction": self.linear.as_dict(margins)}

    def __repr__(self) -> str:
        """Return the verdict as a sentence."""
        kick = f"a kick of {1e3 * self.kick:g} mm/s against mu = {self.friction:g}"
        if self.status == "unstable":
            what = f"destabilises mode{'s' * (len(self.unstable_modes) > 1)} {listed(self.unstable_modes)}"
        else:
            what = "destabilises no mode" if self.status == "stable" else "could not be decided"
        growing = f"without friction {listed(self.modes) or 'none'} would grow"
        return f"<{self.status}: {kick} {what}; {growing}>"


def classify_kick(linear: RodStability, friction: float, kick: float) -> FrictionalRodStability:
    """Return the verdict with friction that follows on one without."""
    inside = mode_friction(linear.rod, friction, kick, linear.load.amplitude, linear.load.frequency)
    growing = _growing(linear)
    fates = tuple(
        known_fate(FrictionalMathieu(e.alpha, e.beta, inside.gamma, e.damping), inside.epsilon, rate)
        for e, rate in zip(growing.values(), _as_arrays(growing).rate.tolist(), strict=True)
    )
    rates = dict(zip(linear.modes, linear.mode_growth_rates.tolist(), strict=True))
    escaping = [rates[mode] for mode, fate in zip(growing, fates, strict=True) if fate.status == "escapes"]
    unsure = [fate.reason for fate in fates if fate.status == "undecided"]
    status: Status = "unstable" if escaping else "undecided" if unsure else "stable"
    return FrictionalRodStability(
        friction=friction,
        kick=kick,
        in_modes=inside,
        linear=linear,
        fates=fates,
        status=status,
        growth_rate=max(escaping, default=0.0),
        exponents=linear.exponents,
        period=linear.period,
        error=linear.error,
        cost=linear.cost,
        note="; ".join(dict.fromkeys(unsure)),
        assumptions=(*linear.assumptions, "friction acts on one mode at a time"),
    )


def critical_kick(linear: RodStability, friction: float) -> CriticalKick:
    """Return the smallest kick found to destabilise a mode, and the proved kick up to which none does."""
    record = _SmallestKicks.of(1)
    _lower_kicks(_as_arrays(_growing(linear)), None, record)
    load = linear.load
    ratios = np.concatenate([record.smallest, record.proved])
    kick, none_up_to = kicks_of(linear.rod, friction, load.amplitude, load.frequency, ratios)
    return CriticalKick(float(kick), int(record.mode[0]) or None, float(none_up_to))


def kicked_loads(
    rod: RodData, systems: ModalSystems, friction: float, kick: float, tolerance: float, workers: int | None
) -> NDArray[np.int8]:
    """Return whether the kick destabilises no mode (1), one (0), or cannot be determined (-1), for each load."""
    status = np.full(systems.loads.size, BOUNDED, dtype=np.int8)
    for block in _parts(systems.loads.size):
        loads = systems.loads.some(block)
        load, _, *growing = ModalSystems(systems.constants, loads).growing(tolerance, workers)
        inside = mode_friction(rod, friction, kick, loads.amplitude, loads.frequency)
        gamma, epsilon = inside.gamma[load], inside.epsilon[load]
        fates = known_fates(Equations(*growing), gamma, epsilon, workers=workers)
        status[block][load[fates == UNDECIDED]] = UNDECIDED
        status[block][load[fates == ESCAPES]] = ESCAPES
    return status


def critical_kicks(
    rod: RodData, systems: ModalSystems, friction: float, tolerance: float, workers: int | None
) -> CriticalKick:
    """Return the `critical_kick` of each of many loads, in their shape."""
    loads, tolerance = systems.loads, units.tolerance("growth_tolerance", tolerance)
    record = _SmallestKicks.of(loads.size)
    for block in _parts(loads.size):
        growing = ModalSystems(systems.constants, loads.some(block)).growing(tolerance, workers)
        _lower_kicks(growing, workers, record.part(block))
    kick, none_up_to = (
        kicks_of(rod, friction, loads.amplitude, loads.frequency, ratio) for ratio in (record.smallest, record.proved)
    )
    return CriticalKick(*(shaped(column, loads.shape) for column in (kick, record.mode, none_up_to)))


def _growing(linear: RodStability) -> dict[int, Mathieu]:
    """Return the equations of the modes that grow, or may grow, without friction, by mode."""
    rows = zip(linear.modes, linear.mode_equations, linear.mode_verdicts, strict=True)
    unstable = set(linear.unstable_modes)
    return {mode: e for mode, e, verdict in rows if verdict.status == "undecided" or mode in unstable}


def _as_arrays(growing: dict[int, Mathieu]) -> GrowingModes:
    """Return the equations of growing modes as arrays, with their growth rates."""
    values = np.array([(e.alpha, e.beta, e.damping) for e in growing.values()]).reshape(-1, 3)
    alpha, beta, damping = (np.ascontiguousarray(column) for column in values.T)
    mode = np.array(list(growing), dtype=np.int64)
    return GrowingModes(np.zeros(mode.size, dtype=np.int64), mode, *Equations.of(alpha, beta, damping, None))


class _SmallestKicks(NamedTuple):
    """For each load the smallest kick over friction found to destabilise a mode, the mode, and the proved bound."""

    smallest: NDArray[np.float64]
    mode: NDArray[np.int64]
    proved: NDArray[np.float64]

    @classmethod
    def of(cls, size: int) -> _SmallestKicks:
        """Return the record of loads before any mode is examined: no kick."""
        return cls(np.full(size, math.inf), np.zeros(size, dtype=np.int64), np.full(size, math.inf))

    def part(self, loads: slice) -> _SmallestKicks:
        """Return a view of some loads."""
        return _SmallestKicks(self.smallest[loads], self.mode[loads], self.proved[loads])


def _lower_kicks(growing: GrowingModes, workers: int | None, record: _SmallestKicks) -> None:
    """Lower ``record`` to the kicks of the growing modes of each load; NaN where none is known and one is undecided."""
    load = growing.load
    # The fastest mode of every load first: what it needs is as far as the others are followed.
    order = np.lexsort((-growing.rate, load))
    rank = np.arange(load.size) - np.searchsorted(load, load)  # of each mode among those of its load
    unknown = np.zeros(record.smallest.size, dtype=np.bool_)
    for number in range(int(rank.max(initial=-1)) + 1):
        now = order[rank == number]
        loads = load[now]
        equations = Equations(*growing[2:]).some(now)
        proved, smallest = known_bounds(equations, np.ones(now.size), record.smallest[loads], workers)
        record.proved[loads] = np.minimum(record.proved[loads], proved)
        unknown[loads] |= np.isnan(smallest)
        better = smallest < record.smallest[loads]
        record.smallest[loads[better]] = smallest[better]
        record.mode[loads[better]] = growing.mode[now][better]
    record.smallest[unknown & np.isinf(record.smallest)] = math.nan


def _parts(size: int) -> list[slice]:
    """Return slices of up to `_AT_ONCE`, so that memory does not grow with the number of modes."""
    return [slice(start, start + _AT_ONCE) for start in range(0, size, _AT_ONCE)]
