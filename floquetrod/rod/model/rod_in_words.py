"""A rod in words: its size, its less common parameters, and the sections of a string in a table."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from floquetrod import units
from floquetrod._util.interchange import plain
from floquetrod._util.result_report import Report, Table
from floquetrod._util.suggest import listed
from floquetrod.rod.model.data import RodData, UniformPart
from floquetrod.rod.model.parameters import OF_A_LINE, ROD

if TYPE_CHECKING:
    from floquetrod.rod.model.sections import Section


def size_in_words(rod: RodData, shown: units.AnswerUnits) -> str:
    """Return diameter, wall, length and bore of a rod in words; of a string for each section.

    >>> from floquetrod.rod.rod import Rod
    >>> size_in_words(Rod.nitinol(), units.AnswerUnits.named())
    '1.6 mm rod, 3.1 m, in a 9.4 mm bore'
    """
    length = shown.length.show(rod.length, 4)
    if not rod.sections:
        return f"{cross_section_in_words(rod, shown)}, {length}, {_hole_in_words(rod, shown)}"
    sections = [f"{cross_section_in_words(each, shown)} {shown.length.show(each.length, 4)}" for each in rod.sections]
    return f"string of {len(sections)} sections, {length}: {listed(sections)}, {_hole_in_words(rod, shown)}"


def cross_section_in_words(section: Section | RodData, shown: units.AnswerUnits) -> str:
    """Return the size of a section in words: its name in the catalogue, or diameter and wall."""
    if name := getattr(section, "name", ""):  # which a rod has not
        return str(name)
    outer = shown.across.show(2.0 * section.radius, 4)
    wall = shown.across.show(section.radius - section.inner_radius, 4)
    return f"{outer} pipe of {wall} wall" if section.inner_radius else f"{outer} rod"


def _hole_in_words(rod: RodData, shown: units.AnswerUnits) -> str:
    """Return the bores that a rod lies in, each with the depth at which it begins."""
    bores = [bore for bore in rod.bores if bore.depth < rod.depth + rod.length]
    bores = bores[sum(bore.depth <= rod.depth for bore in bores) - 1 :]
    if len(bores) < 2:
        bore = shown.across.show(2.0 * rod.channel_radius, 4)
        is_spoken_with_a_vowel = bore.startswith("8") or bore.split()[0].partition(".")[0] in ("11", "18")
        return f"in {'an' if is_spoken_with_a_vowel else 'a'} {bore} bore"
    first, *others = (shown.across.show(bore.diameter, 4) for bore in bores)
    depths = (shown.length.show(bore.depth, 6) for bore in bores[1:])
    return f"in bores of {listed([first, *map('{} from {} on'.format, others, depths)])}"


def section_in_words(rod: RodData, position: float, shown: units.AnswerUnits) -> str:
    """Return the section of a string, and the bore where several differ, at a position in m from its upper end.

    >>> from floquetrod.rod.rod import Rod
    >>> from floquetrod.rod.model.sections import Section
    >>> wires = [Section(diameter="1.6mm", length=2.0), Section(diameter="1.2mm", length=1.0)]
    >>> section_in_words(Rod(sections=wires, channel_diameter="9.4mm"), 2.5, units.AnswerUnits.named())
    'section 2, 1.2 mm rod'
    """
    part = next((each for each in rod.uniform_parts if position < each.end), rod.uniform_parts[-1])
    bore = f"in the {shown.across.show(2.0 * part.rod.channel_radius, 4)} bore"
    if not rod.sections:
        return bore
    section = f"section {part.section + 1}, {cross_section_in_words(rod.sections[part.section], shown)}"
    return f"{section}, {bore}" if len({each.rod.channel_radius for each in rod.uniform_parts}) > 1 else section


def table_of_parts(rod: RodData, shown: units.AnswerUnits) -> Table | None:
    """Return the parts of a string with their numbers, from the upper end down; None of a uniform rod."""
    if not rod.varies:
        return None
    along, across, weight = shown.length, shown.across, shown.per_length
    mass, rigidity = shown.mass_per_length, shown.rigidity
    columns: dict[str, Callable[[UniformPart], str]] = {
        "section": lambda part: str(part.section + 1),
        "size": lambda part: cross_section_in_words(rod.sections[part.section] if rod.sections else rod, shown),
        f"from {along.name}": lambda part: f"{along.of(part.start):.6g}",
        f"to {along.name}": lambda part: f"{along.of(part.end):.6g}",
        f"bore {across.name}": lambda part: f"{across.of(2.0 * part.rod.channel_radius):.4g}",
        f"weight in fluid {weight.name}": lambda part: f"{weight.of(part.rod.weight_per_length):.4g}",
        f"inertia {mass.name}": lambda part: f"{mass.of(part.rod.mass_per_length):.4g}",
        f"E I {rigidity.name}": lambda part: _number(part.rod.flexural_rigidity, rigidity),
    }
    if any(part.rod.yield_strength for part in rod.uniform_parts):
        columns[f"yield {shown.pressure.name}"] = lambda part: _strength(part, shown)
    rows = [[text(part) for text in columns.values()] for part in rod.uniform_parts]
    widths = [max(map(len, column)) for column in zip(columns, *rows, strict=True)]
    sides = ("<" if title == "size" else ">" for title in columns)
    return Table([(title, f"{side}{width}") for title, side, width in zip(columns, sides, widths, strict=True)], rows)


def rod_report(rod: RodData) -> Report:
    """Return a report of a rod in the units in which it was given: size, material, weight, when it buckles, parts."""
    shown = units.AnswerUnits.named(given=rod.given_units)
    lines = []
    if not rod.sections:
        names = ["youngs_modulus", "density", *(["yield_strength"] if rod.yield_strength else [])]
        material = (" ".join(ROD[name].in_words(getattr(rod, name), shown)) for name in names)
        weight = shown.per_length.show(rod.weight_per_length, 4)
        rigidity = shown.rigidity.show(rod.flexural_rigidity, 4)
        lines = [("material", ", ".join(material)), ("section", f"weight in fluid {weight}, E I {rigidity}")]
    where = f" in {section_in_words(rod, rod.weakest_at, shown)}" if rod.varies else ""
    half_wave = shown.length.show(rod.critical_half_wave, 4)
    critical = (
        f"force {shown.force.show(rod.critical_force, 4)}{where}, mode {rod.critical_mode:.3g}, half wave {half_wave}"
    )
    special = special_parameters(rod, shown)
    lines += [("critical", critical), *([("also", special)] if special else [])]
    return Report(size_in_words(rod, shown), lines, table_of_parts(rod, shown))


def _strength(part: UniformPart, shown: units.AnswerUnits) -> str:
    """Return the yield strength of a part, without its unit, and a dash for an unknown one."""
    strength = part.rod.yield_strength
    return "-" if strength is None else _number(strength, shown.pressure)


def _number(value: float, shown: units.Unit) -> str:
    """Return a value in a unit to four digits, without the unit and a power of ten."""
    return shown._replace(name="").show(value, 4)


def parts_as_dicts(rod: RodData) -> list[dict[str, Any]]:
    """Return the parts of a string as numbers for JSON, from the upper end down."""
    return [
        {
            "section": part.section + 1,
            "name": rod.sections[part.section].name if rod.sections else "",
            "start_m": plain(part.start),
            "end_m": plain(part.end),
            "diameter_m": plain(2.0 * part.rod.radius),
            "inner_diameter_m": plain(2.0 * part.rod.inner_radius),
            "bore_m": plain(2.0 * part.rod.channel_radius),
            "mass_per_length_kg_per_m": plain(part.rod.mass_per_length),
            "weight_per_length_N_per_m": plain(part.rod.weight_per_length),
            "flexural_rigidity_N_m2": plain(part.rod.flexural_rigidity),
            "yield_strength_Pa": part.rod.yield_strength,
        }
        for part in rod.uniform_parts
    ]


def special_parameters(rod: RodData, shown: units.AnswerUnits) -> str:
    """Return in words what differs from a solid rod with hinged ends, horizontal and without fluids; "" if nothing."""
    special = [
        " ".join(parameter.in_words(getattr(rod, name), shown))
        for name, parameter in ROD.items()
        if parameter.is_echoed
        and getattr(rod, name) != parameter.default
        and not (rod.path is not None and name in OF_A_LINE)
        and not (rod.sections and name == "inner_radius")
    ]
    if rod.path is not None:
        special.append(f"{rod.path.in_words(shown.length)} from {shown.length.show(rod.depth)} on")
    return ", ".join(special)
