"""What is said of a rod, of a load on it and of a verdict, in the units asked for."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol

from floquetrod import units as known
from floquetrod._util import validate
from floquetrod._util.report import Report, Reported, number
from floquetrod.floquet.verdict import Status
from floquetrod.rod.answers.margins import Margin
from floquetrod.rod.loads.axial import AxialResonance
from floquetrod.rod.loads.load import Load, Quantity
from floquetrod.rod.model.contact import added_mean
from floquetrod.rod.model.data import RodData, special_parameters
from floquetrod.units import AnswerUnits, Unit

ReportLine = tuple[str, str]
"""A label and a text."""

KICK = "mm/s"
"""The unit in which kicks are shown where none was asked for."""

_NAMES: dict[Quantity, tuple[str, str, str]] = {
    "mean": ("mean force", "mean_force", "N"),
    "amplitude": ("amplitude", "amplitude", "N"),
    "frequency": ("frequency", "frequency", "rad_per_s"),
}
"""Name of each quantity, and its name and unit among keys."""

_SEARCHED_TO: dict[Quantity, str] = {
    "mean": "within 8 Fcr either way",
    "amplitude": "from zero to 2 Fcr above",
    "frequency": "from a ninth to nine times this frequency",
}


_SHOWN: dict[str, str] = {
    "mean": "force",
    "amplitude": "force",
    "frequency": "frequency",
    "kick": "speed",
    "force": "force",
    "length": "length",
    "pressure": "pressure",
}


def shown_in(names: Mapping[str, str] | None, critical_force: float) -> dict[str, Unit]:
    """Return the unit to show each quantity of a load, a kick, and other forces, lengths and pressures in.

    Where none is named these are SI units and mm/s; other forces are then in the unit of the mean or the amplitude
    where that is not the critical force itself; lengths and pressures beside pounds in ft and ksi, else in m and MPa.
    """
    names = {} if names is None else names
    if not isinstance(names, Mapping):
        raise validate.wrong_type("units", f"must be a mapping such as {{'mean': 'Fcr'}}, got {validate.short(names)}")
    if not names.keys() <= _SHOWN.keys():
        raise validate.wrong_value("units", f"must be of {', '.join(_SHOWN)}, got {dict(names)!r}")
    of_load = {
        name: known.unit({"kick": KICK, **names}.get(name, ""), f"units[{name!r}]", _SHOWN[name], critical_force)
        for name in ("mean", "amplitude", "frequency", "kick")
    }
    forces = (of_load[name].name for name in ("mean", "amplitude") if names.get(name))
    usual = {"force": next((each for each in forces if each != "Fcr"), "N")}
    given = {**usual, **{name: names[name] for name in ("force", "length", "pressure") if name in names}}
    more = AnswerUnits.named(**given, what="units[{!r}]".format)
    return {**of_load, "force": more.force, "length": more.length, "pressure": more.pressure}


def answer_units(shown: Mapping[str, Unit]) -> AnswerUnits:
    """Return the units of what is not the load."""
    return AnswerUnits(shown["force"], shown["length"], shown["pressure"], shown["frequency"])


def describe_load(load: Load, shown: Mapping[str, Unit], rod: RodData) -> str:
    """Return the load in the units asked for, each quantity followed by its value in a second unit."""
    return ", ".join(
        [
            f"mean {_both(load.mean, 'mean', shown, rod)}",
            f"amplitude {_both(load.amplitude, 'amplitude', shown, rod)}",
            _both(load.frequency, "frequency", shown, rod),
        ]
    )


def describe_kind(load: Load, shown: Mapping[str, Unit], rod: RodData) -> list[str]:
    """Return lines about what varies along the rod, and about the waveform."""
    lines = [load.features] if load.features else []
    if (rod.weight_along > 0.0 or not rod.course.is_uniform) and load.mean_at is not None:
        upper, lower = (shown["mean"].show(float(load.mean + added_mean(rod, load, x))) for x in (0.0, 1.0))
        lines.append(f"mean force {upper} at the upper end, {lower} at the lower")
    if not load.is_uniform:
        found = rod.axial_response(load)
        if math.isfinite(found.factor):
            largest = _both(found.largest, "amplitude", shown, rod)
            times = f"{found.factor:.3g} times the amplitude"
            lines.append(f"vibration largest at {shown['length'].show(found.position, 4)}: {largest}, {times}")
        named = " and ".join(_resonance(r, shown, rod) for r in found.resonances)
        lines.append(f"axial resonance{'s' * (len(found.resonances) > 1)} nearby: {named}")
    return lines


def load_lines(load: Load, shown: Mapping[str, Unit], rod: RodData) -> list[ReportLine]:
    """Return the lines about a load."""
    return [("load", describe_load(load, shown, rod)), *(("", text) for text in describe_kind(load, shown, rod))]


def _resonance(found: AxialResonance, shown: Mapping[str, Unit], rod: RodData) -> str:
    of = f" of harmonic {found.harmonic}" if found.harmonic > 1 else ""
    return f"{_both(found.frequency, 'frequency', shown, rod)}{of}"


def _both(value: float, name: str, shown: Mapping[str, Unit], rod: RodData) -> str:
    """Return a quantity of the load in the unit asked for and in a second one."""
    first, kind = shown[name], _SHOWN[name]
    others = {"Fcr": shown["force"].name, "rad/s": "Hz", "1/s": "Hz"}
    other = others.get(first.name, "Fcr" if kind == "force" else "rad/s")
    return f"{first.show(value)} ({known.unit(other, other, kind, rod.critical_force).show(value, 4)})"


if TYPE_CHECKING:

    class _RodVerdict(Protocol):
        """What is used here of a `floquetrod.rod.answers.verdict.RodStability`."""

        @property
        def evidence(self) -> Any: ...
        @property
        def rod(self) -> RodData: ...
        @property
        def load(self) -> Load: ...
        @property
        def status(self) -> Status: ...
        @property
        def growth_rate(self) -> float: ...
        @property
        def growth_tolerance(self) -> float: ...
        @property
        def decay_rate(self) -> float: ...
        @property
        def note(self) -> str: ...
        @property
        def assumptions(self) -> tuple[str, ...]: ...
        @property
        def cutoff(self) -> str: ...
        @property
        def modes_checked(self) -> int: ...
        @property
        def unstable_modes(self) -> tuple[int, ...]: ...
        @property
        def fastest_mode(self) -> int | None: ...
        @property
        def damping_to_stabilise(self) -> float: ...

        def time_to_grow(self, factor: float = 10.0) -> float: ...

else:
    _RodVerdict = object


class ReportedVerdict(Reported, _RodVerdict):
    """A verdict on a rod that says itself.

    Its `Evidence` has the words, the table and the numbers that differ with the kind of modes.
    """

    def report(
        self, units: Mapping[str, str] | None = None, margins: Mapping[Quantity, Margin] | None = None
    ) -> Report:
        """Return the verdict in lines and a table: resonances, rod and load, growth, margins, method, modes.

        Parameters
        ----------
        units : mapping, optional
            In which to show mean, amplitude, frequency, other forces, lengths and pressures: ``{"mean": "Fcr",
            "frequency": "Hz", "force": "lbf", "length": "ft", "pressure": "ksi"}``; N, rad/s, m and MPa without, ft and
            ksi beside pounds.
        margins : mapping, optional
            The result of `margins`, reported with the damping that stabilises.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.
        """
        shown = shown_in(units, self.rod.critical_force)
        lines = [*self._subject(shown), *self._growth(), *self.evidence.named_lines(self)]
        lines += [] if margins is None else self._reach(margins, shown)
        lines += [("checked", self.cutoff), ("method", self.evidence.method(self))]
        lines += [("note", self.note)] if self.note else []
        return Report(
            ": ".join(filter(None, [self.status.upper(), self.evidence.headline(self)])), lines, self.evidence.table
        )

    def _subject(self, shown: Mapping[str, Unit]) -> list[ReportLine]:
        """Return lines about rod and load, and what is assumed where that is more than the study does."""
        rod, load, units = self.rod, self.load, answer_units(shown)
        critical = units.force.show(rod.critical_force, 4)
        lines = [("rod", f"critical force {critical}, critical mode {rod.critical_mode:.3g}")]
        special = special_parameters(rod, units)
        if special:
            mass, weight = units.mass_per_length.show(rod.mass_per_length, 4), units.per_length
            size = f"inertia {mass}, weight in fluid {weight.show(rod.weight_per_length, 4)}"
            half_wave = units.length.show(rod.critical_half_wave, 4)
            bend = f"E I {units.rigidity.show(rod.flexural_rigidity, 4)}, half wave {half_wave}"
            lines += [("", special), ("", f"{size}, {bend}")]
        lines += load_lines(load, shown, rod)
        if rod.yield_strength is not None:
            lines.append(("stress", rod.stress(load).in_words(units.pressure)))
        if special or load.features:
            lines.append(("assumed", "; ".join(self.assumptions)))
        return lines

    def _growth(self) -> list[ReportLine]:
        if not self.growth_rate > 0.0:
            return []
        return [
            (
                "growth",
                f"{self.growth_rate:.6g} 1/s{self.evidence.grows_in(self)}, tenfold in {self.time_to_grow(10.0):.4g} s",
            ),
        ]

    def _reach(self, margins: Mapping[Quantity, Margin], shown: Mapping[str, Unit]) -> list[ReportLine]:
        """Return how far the load is from a change of the verdict, and the damping it would take."""
        change = {"stable": "unstable", "unstable": "stable"}.get(self.status, "decided")
        lines: list[ReportLine] = []
        for name, margin in margins.items():
            sides = [(margin.below, "lower"), (margin.above, "higher")]
            found = [f"{shown[name].show(value, 4)} {way}" for value, way in sides if math.isfinite(value)]
            words = f"{change} {' or '.join(found)}" if found else _unchanged(margin, name, shown[name])
            lines.append(("" if lines else "margins", f"{_NAMES[name][0]:<11} {words}"))
        if not self.evidence.has_exact_margins:
            lines.append(("", "found by sampling: two changes close together may be missed"))
        rate = self.damping_to_stabilise
        if rate > 0.0:
            none = "no damping suffices: the mean force alone buckles a mode"
            lines.append(("damping", none if math.isinf(rate) else self.evidence.enough.format(f"{rate:.6g} 1/s")))
        return lines

    def as_dict(self, margins: Mapping[Quantity, Margin] | None = None) -> dict[str, Any]:
        """Return the verdict as numbers for JSON, units in the keys; None for numbers that are infinite or not known.

        With ``margins``, which `margins` returns, these and the damping that stabilises.
        """
        rod, load = self.rod, self.load
        return {
            "status": self.status,
            "unstable_modes": list(self.unstable_modes),
            "growth_rate_per_s": number(self.growth_rate),
            "decay_rate_per_s": self.decay_rate,
            "fastest_mode": self.fastest_mode,
            "time_to_grow_tenfold_s": number(self.time_to_grow(10.0)),
            **({} if margins is None else self._margins_as_dict(margins)),
            "modes_checked": self.modes_checked,
            "growth_tolerance_per_s": self.growth_tolerance,
            "critical_force_N": rod.critical_force,
            "rod": rod.as_dict(),
            "mass_per_length_kg_per_m": rod.mass_per_length,
            "weight_per_length_N_per_m": rod.weight_per_length,
            "flexural_rigidity_N_m2": rod.flexural_rigidity,
            "assumptions": list(self.assumptions),
            "mean_N": load.mean,
            "amplitude_N": load.amplitude,
            "frequency_rad_per_s": load.frequency,
            **({} if load.is_uniform else {"axial_response": rod.axial_response(load).as_dict()}),
            **({} if rod.yield_strength is None else {"stress": rod.stress(load).as_dict()}),
            **self.evidence.numbers(self),
        }

    def _margins_as_dict(self, margins: Mapping[Quantity, Margin]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for quantity, margin in margins.items():
            _, name, unit = _NAMES[quantity]
            found |= {
                f"{name}_margin_below_{unit}": number(margin.below),
                f"{name}_margin_above_{unit}": number(margin.above),
                f"{name}_margin_resolution_{unit}": margin.resolution,
                f"{name}_margin_searched_{unit}": [number(reach) for reach in margin.searched],
            }
        return {**found, "damping_to_stabilise_per_s": number(self.damping_to_stabilise)}


def _unchanged(margin: Margin, name: Quantity, unit: Unit) -> str:
    """Return that no change was found, and up to where was searched."""
    if not any(margin.searched):
        return "not searched: so many modes take minutes; in Python, verdict.margin continues, with progress"
    if not margin.resolution:
        return f"no change {_SEARCHED_TO[name]}"
    below, above = (unit.show(value, 4) for value in margin.searched)
    return f"no change from {below} lower to {above} higher"
