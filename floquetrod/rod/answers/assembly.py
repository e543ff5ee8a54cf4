"""A string of several sections, or in several bores, in a well: how deep it goes, and which section is where.

Sections are counted from the lower end of the string as it goes in; bores lie at measured depths.  Numbers of sections
in answers count from the upper end, as in `floquetrod.Rod`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arguments import wrong_value
from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod.rod.model.cross_section import CrossSection
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.wellhead import Wellhead
from floquetrod.units import AnswerUnits
from floquetrod.wells.drag import Drag, StringAssembly, StringProperties
from floquetrod.wells.path import WellPath

_ROUNDING = 1e-6  # m, by which a string may be too short


def assembly_of(rod: RodData) -> StringAssembly | None:
    """Return the sections and bores of a rod as a string in a well; None for a uniform rod."""
    if not (rod.sections or rod.bores):
        return None
    lengths = [section.length for section in rod.sections[::-1]] or [math.inf]  # from the lower end up
    bores = range(len(rod.bores) or 1)
    cells = [[rod.in_cell(k, bore) for bore in bores] for k in reversed(range(len(lengths)))]
    own = [row[0] for row in cells]
    clearance = np.array([[cell.radial_clearance for cell in row] for row in cells])
    longest = sorted(range(len(lengths)), key=lambda k: -lengths[k])
    reference = next(cells[k][bore] for k in longest for bore in bores if clearance[k, bore] > 0.0)
    return StringAssembly(
        heights=np.append(0.0, np.cumsum(lengths)),
        bores=np.array([bore.depth for bore in rod.bores] or [0.0]),
        rigidity=np.array([cell.flexural_rigidity for cell in own]),
        weight=np.array([cell.weight_per_length for cell in own]),
        clearance=clearance,
        reference=StringProperties(
            reference.flexural_rigidity, reference.weight_per_length, reference.radial_clearance
        ),
        impedance=np.array([cell.mass_along * cell.wave_speed for cell in own]),
        wave_speed=np.array([cell.wave_speed for cell in own]),
    )


# --- how deep it goes ---


def length_of(rod: RodData) -> float:
    """Return the length in m of a string of several sections, infinite of one section, which is as long as its well."""
    return sum(section.length for section in rod.sections) if rod.sections else math.inf


def deepest_of(rod: RodData, path: WellPath) -> float:
    """Return the measured depth in m to which a well and the length of a string let its lower end go."""
    return min(path.end, path.start + length_of(rod))


def require_depth(rod: RodData, path: WellPath, name: str, depth: float) -> None:
    """Raise ValueError where a string is too short for a measured depth in m, or does not pass a bore on the way."""
    shown = AnswerUnits.named(given=rod.given_units)
    length, most = length_of(rod), deepest_of(rod, path)
    if depth > most + _ROUNDING and depth <= path.end + _ROUNDING:
        raise wrong_value(
            name,
            f"must be no deeper than the string reaches: it is {shown.length.show(length, 6)} long and ends at "
            f"{shown.length.show(most, 6)}, got {shown.length.show(depth, 6)}; give longer sections, or a smaller "
            f"{name}",
        )
    _require_passes(rod, path, depth)


def _require_passes(rod: RodData, path: WellPath, depth: float) -> None:
    """Raise ValueError where a section does not pass a bore on the way down to a measured depth in m."""
    if not rod.bores:
        return
    shown = AnswerUnits.named(given=rod.given_units)
    if rod.bores[0].depth > path.start:
        raise wrong_value(
            "bores",
            f"must begin at or above the start of the well, at {shown.length.show(path.start, 6)}, got "
            f"{shown.length.show(rod.bores[0].depth, 6)} for the first",
        )
    assembly = assembly_of(rod)
    assert assembly is not None  # noqa: S101
    ends = np.append(assembly.bores[1:], math.inf)
    for k, height in enumerate(assembly.heights[:-1].tolist()):
        met = (assembly.bores < depth - height) & (ends > path.start) & (depth - height > path.start)
        tight = np.flatnonzero(met & ~(assembly.clearance[k] > 0.0))
        if tight.size:
            bore, number = rod.bores[int(tight[0])], len(assembly.weight) - 1 - k
            across = _units_of(rod, number).across
            diameter = 2.0 * rod.in_cell(number, 0).radius
            raise wrong_value(
                "bores",
                f"must let every section pass on the way to {shown.length.show(depth, 6)}: {name_of(rod, number)} has "
                f"a diameter of {across.show(diameter, 5)}, and the bore from "
                f"{shown.length.show(max(bore.depth, path.start), 6)} on {across.show(bore.diameter, 5)}",
            )


# --- which section is where ---


class CrossSections(NamedTuple):
    """What the stress of a string depends on, at places along it."""

    youngs_modulus: Any  # in Pa
    area: Any  # of the material in m^2
    radius: Any  # in m
    inner_radius: Any  # in m
    radial_clearance: Any  # in m
    flexural_rigidity: Any  # in N m^2
    residual_curvature: Any  # in 1/m


class StringCells(NamedTuple):
    """Sections in bores at places along strings: their codes, uniform rods, and which of these is at each place."""

    codes: Ints
    rods: list[RodData]
    order: Ints

    @classmethod
    def of(cls, rod: RodData, codes: Ints) -> StringCells:
        """Return the cells with codes: number of the section times bores plus number of the bore."""
        if not (rod.sections or rod.bores):
            return cls(codes, [rod], codes)
        used, index = np.unique(codes, return_inverse=True)
        rods = [rod.in_cell(*divmod(int(code), len(rod.bores) or 1)) for code in used]
        return cls(codes, rods, index.reshape(codes.shape))

    @classmethod
    def at(cls, rod: RodData, assembly: StringAssembly | None, depth: Any, bottom: Any) -> StringCells:
        """Return the cells at measured depths in m of strings to depths ``bottom``."""
        depth, bottom = np.broadcast_arrays(depth, bottom)
        if assembly is None:
            return cls.of(rod, np.zeros(depth.shape, np.intp))
        number = assembly.weight.size - 1 - assembly.section_at(depth, bottom)
        return cls.of(rod, number * assembly.bores.size + assembly.bore_at(depth))

    def column(self, name: str) -> Floats:
        """Return an attribute of the rods at the places."""
        return np.asarray(np.array([getattr(rod, name) for rod in self.rods])[self.order])

    @property
    def cross_sections(self) -> CrossSections:
        """The sections at the places."""
        return CrossSections(*map(self.column, CrossSections._fields))

    def groups(self) -> list[tuple[RodData, Bools]]:
        """Return each rod with its places."""
        return [(rod, np.asarray(self.order == k)) for k, rod in enumerate(self.rods)]


def cells_of(rod: RodData, along: Any) -> StringCells:
    """Return the uniform rods along a string, from its mean force."""
    return StringCells.at(rod, assembly_of(rod), along.depth, along.depth[-1])


def numbers_along(drag: Drag, depth: Floats, bottom: float) -> Ints | None:
    """Return the numbers of sections at measured depths in m, from the upper end; None of one section."""
    if drag.assembly is None or drag.assembly.weight.size == 1:
        return None
    return np.asarray(drag.assembly.weight.size - 1 - drag.assembly.section_at(depth, np.asarray(bottom)))


def at_the_wellhead(rod: RodData, drag: Drag, bottom: float) -> CrossSection:
    """Return the section at the upper end of a string to a measured depth in m."""
    return StringCells.at(rod, drag.assembly, drag.path.start, bottom).rods[0].section


def added_by(wellhead: Wellhead, rod: RodData, drag: Drag, bottoms: Floats) -> Any:
    """Return the compression in N at the injector beyond the effective one, of strings to measured depths in m."""
    cells = StringCells.at(rod, drag.assembly, drag.path.start, bottoms)
    return np.array([wellhead.added(cell.section, drag.motion) for cell in cells.rods])[cells.order]


def require_tube(wellhead: Wellhead, rod: RodData) -> None:
    """Raise ValueError for a pressure inside a string with a solid section."""
    for number in range(max(len(rod.sections), 1)):
        wellhead.require_tube(rod.in_cell(number, 0).section)


def name_of(rod: RodData, number: int) -> str:
    """Return how a section is called, by its number from the upper end, with its size in the unit of the question.

    >>> from floquetrod import Rod, Section
    >>> sections = [Section(diameter="2in", length=1.0), Section("2.00x0.156 CT90", length=1.0)]
    >>> string = Rod(sections=sections, channel_radius=0.05)
    >>> name_of(string, 0), name_of(string, 1)
    ('section 1 (2 in)', 'section 2 (2.00x0.156 CT90)')
    """
    if not rod.sections:
        return "the string"
    section = rod.sections[number]
    if section.name:
        return f"section {number + 1} ({section.name})"
    across = _units_of(rod, number).across
    wall = f" x {across.show(section.radius - section.inner_radius, 4)}" if section.inner_radius else ""
    return f"section {number + 1} ({across.show(2.0 * section.radius, 5)}{wall})"


def _units_of(rod: RodData, number: int) -> AnswerUnits:
    """Return the units in which a section was given, by its number from the upper end, else the string's."""
    given = rod.given_units
    return AnswerUnits.named(given=rod.sections[number].given_units.or_else(given) if rod.sections else given)


# --- how strong it is ---


def reference_strength(rod: RodData) -> float | None:
    """Return the largest yield strength of the sections in Pa, to which stresses are referred; None for none known."""
    strengths = [section.yield_strength for section in rod.sections] or [rod.yield_strength]
    return max((strength for strength in strengths if strength is not None), default=None)


def weakness(rod: RodData, cells: StringCells) -> Any:
    """Return the reference strength over the yield strength at places, 0 where it is not known; 1 of one section."""
    reference = reference_strength(rod)
    if not rod.sections or reference is None:
        return 1.0
    ratios = [reference / cell.yield_strength if cell.yield_strength else 0.0 for cell in cells.rods]
    return np.array(ratios)[cells.order]
