"""Lines of reports about a rod, a load on it and the margins of a verdict, in chosen units."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from floquetrod import units as known
from floquetrod._util import validate
from floquetrod._util.interchange import by_keys, with_unit
from floquetrod.floquet.margins import Margin
from floquetrod.floquet.verdict import Status
from floquetrod.rod.loads.axial import AxialResonance
from floquetrod.rod.loads.load import LOAD, QUANTITIES, Load, Quantity
from floquetrod.rod.model.contact import added_mean
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.rod_in_words import section_in_words, size_in_words, special_parameters
from floquetrod.units import AnswerUnits, Unit

if TYPE_CHECKING:
    from floquetrod.rod.answers.stability_intervals import BandBeyond

ReportLine = tuple[str, str]
"""A label and a text."""

KICK = "mm/s"
"""The unit in which kicks are shown where none was asked for."""

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


def shown_in(names: Mapping[str, str] | None, rod: RodData, *others: known.InUnits) -> dict[str, Unit]:
    """Return the unit to show each quantity of a load, a kick, and other quantities in.

    The unit is the one in ``names``, else the one in which ``others``, then the rod, were given, by the rule of
    `floquetrod.units.AnswerUnits`; else N, rad/s, mm/s, m and MPa.  Other forces take the unit of the mean or of the
    amplitude, unless it is the critical force.
    """
    names = {} if names is None else names
    if not isinstance(names, Mapping):
        raise validate.wrong_type("units", f"must be a mapping such as {{'mean': 'Fcr'}}, got {validate.short(names)}")
    if not names.keys() <= _SHOWN.keys():
        raise validate.wrong_value("units", f"must be of {', '.join(_SHOWN)}, got {dict(names)!r}")
    wanted = {
        name: known.unit(names[name], f"units[{name!r}]", kind, rod.force_unit)
        for name, kind in _SHOWN.items()
        if name in names
    }
    forces = (wanted[name].name for name in ("mean", "amplitude") if names.get(name))
    of_load = next((name for name in forces if name != "Fcr"), None)
    given = known.GivenUnits().or_else(*(each.given_units for each in (*others, rod)))
    answer = AnswerUnits.named(
        names.get("force", of_load), names.get("length"), names.get("pressure"), what="units[{!r}]".format, given=given
    )
    usually = {
        "mean": answer.force,
        "amplitude": answer.force,
        "frequency": known.unit(given.frequency, "", "frequency"),
        "kick": known.unit(KICK, "", "speed"),
    }
    return {**answer._asdict(), **usually, **wanted}


def answer_units(shown: Mapping[str, Unit]) -> AnswerUnits:
    """Return the units of forces, lengths, pressures and frequencies, as opposed to the load's."""
    return AnswerUnits(**{name: shown[name] for name in AnswerUnits._fields})


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
        response = rod.axial_response(load)
        if math.isfinite(response.factor):
            largest = _both(response.largest, "amplitude", shown, rod)
            times = f"{response.factor:.3g} times the amplitude"
            place = f"{shown['length'].show(response.position, 4)}{response.in_section}"
            lines.append(f"vibration largest at {place}: {largest}, {times}")
        named = " and ".join(_resonance(r, shown, rod) for r in response.resonances)
        lines.append(f"axial resonance{'s' * (len(response.resonances) > 1)} nearby: {named}")
    return lines


def load_lines(load: Load, shown: Mapping[str, Unit], rod: RodData) -> list[ReportLine]:
    """Return the lines about a load."""
    return [("load", describe_load(load, shown, rod)), *(("", text) for text in describe_kind(load, shown, rod))]


def _resonance(resonance: AxialResonance, shown: Mapping[str, Unit], rod: RodData) -> str:
    of = f" of harmonic {resonance.harmonic}" if resonance.harmonic > 1 else ""
    return f"{_both(resonance.frequency, 'frequency', shown, rod)}{of}"


def _both(value: float, name: str, shown: Mapping[str, Unit], rod: RodData) -> str:
    """Return a quantity of the load in the unit asked for and in a second one."""
    first, kind = shown[name], _SHOWN[name]
    others = {"Fcr": shown["force"].name, "rad/s": "Hz", "1/s": "Hz"}
    second = others.get(first.name, "Fcr" if kind == "force" else "rad/s")
    return f"{first.show(value)} ({known.unit(second, second, kind, rod.critical_force).show(value, 4)})"


def subject_lines(rod: RodData, load: Load, shown: Mapping[str, Unit]) -> list[ReportLine]:
    """Return lines about rod and load."""
    units = answer_units(shown)
    critical = units.force.show(rod.critical_force, 4)
    lines = [("rod", size_in_words(rod, units))]
    special = special_parameters(rod, units)
    where = f" in {section_in_words(rod, rod.weakest_at, units)}" if rod.varies else ""
    lines.append(("", f"critical force {critical} (of a long rod){where}, critical mode {rod.critical_mode:.3g}"))
    if special and rod.varies:
        lines.append(("", special))
    elif special:
        mass, weight = units.mass_per_length.show(rod.mass_per_length, 4), units.per_length
        size = f"inertia {mass}, weight in fluid {weight.show(rod.weight_per_length, 4)}"
        half_wave = units.length.show(rod.critical_half_wave, 4)
        bend = f"E I {units.rigidity.show(rod.flexural_rigidity, 4)}, half wave {half_wave}"
        lines += [("", special), ("", f"{size}, {bend}")]
    lines += load_lines(load, shown, rod)
    if rod.yield_strength is not None:
        lines.append(("stress", rod.stress(load).in_words(units.pressure)))
    return lines


def margin_lines(
    margins: Mapping[Quantity, Margin],
    status: Status,
    shown: Mapping[str, Unit],
    beyond: Callable[[Quantity, float], BandBeyond | None],
) -> list[ReportLine]:
    """Return how far a load is from a change of the verdict, and the band ``beyond`` a change of a quantity."""
    require_margins(margins)
    change = {"stable": "unstable", "unstable": "stable"}.get(status, "decided")
    lines: list[ReportLine] = []
    for name, margin in margins.items():
        changes = []
        for distance, way in ((-margin.below, "lower"), (margin.above, "higher")):
            if math.isfinite(distance):
                band = beyond(name, distance)
                grows = f" ({band.words})" if band else ""
                changes.append(f"{shown[name].show(abs(distance), 4)} {way}{grows}")
        words = f"{change} {' or '.join(changes)}" if changes else _unchanged(margin, name, shown[name])
        if margin.resolution:
            words += f", in steps of {shown[name].show(margin.resolution, 2)}"
        lines.append(("" if lines else "margins", f"{LOAD[name].words:<11} {words}"))
    return lines


def missed_changes(margins: Mapping[Quantity, Margin], shown: Mapping[str, Unit]) -> str:
    """Return in one line how narrow an unstable band may be that sampled margins miss."""
    widths = [
        f"{shown[name].show(margin.resolution, 2)} in {LOAD[name].words}"
        for name, margin in margins.items()
        if margin.resolution
    ]
    if not widths:
        return "found by sampling: two changes close together may be missed"
    every = f"{', '.join(widths[:-1])} or {widths[-1]}" if len(widths) > 1 else widths[0]
    return f"found by sampling: changes closer together than {every} may be missed"


def margins_as_dict(
    margins: Mapping[Quantity, Margin], beyond: Callable[[Quantity, float], BandBeyond | None]
) -> dict[str, Any]:
    """Return margins as numbers for JSON, and the bands ``beyond`` them by "below" and "above"."""
    require_margins(margins)
    numbers: dict[str, Any] = {}
    for quantity, margin in margins.items():
        limits = LOAD[quantity]
        kinds = ("below", "above", "resolution", "searched")
        keys = {kind: with_unit(f"{limits.words} margin {kind}", limits.unit) for kind in kinds}
        numbers |= by_keys(margin, " ".join(f"{key}={kind}" for kind, key in keys.items()))
        bands = {"below": beyond(quantity, -margin.below), "above": beyond(quantity, margin.above)}
        known = {side: band.as_dict() for side, band in bands.items() if band}
        if known:
            numbers[f"{limits.words.replace(' ', '_')}_margin_ends_in"] = known
    return numbers


def require_margins(margins: Any) -> None:
    """Raise TypeError unless ``margins`` maps quantities of a load to their margins."""
    if not isinstance(margins, Mapping) or not all(
        name in QUANTITIES and isinstance(margin, Margin) for name, margin in margins.items()
    ):
        raise validate.wrong_type("margins", f"must be what verdict.margins() returns, got {validate.short(margins)}")


def _unchanged(margin: Margin, name: Quantity, unit: Unit) -> str:
    """Return how far a search went that met no change."""
    if not any(margin.searched):
        return "not searched: so many modes take minutes; in Python, verdict.margin continues, with progress"
    if not margin.resolution:
        return f"no change {_SEARCHED_TO[name]}"
    below, above = (unit.show(value, 4) for value in margin.searched)
    return f"no change from {below} lower to {above} higher"
