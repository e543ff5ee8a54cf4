"""Sections of a string and the bores of its hole: as they are given, and the parts that both divide a string into."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple

from floquetrod import units
from floquetrod._util.arguments import error_in, wrong_type, wrong_value
from floquetrod._util.calling import TellsAttributes, constructor_hints
from floquetrod._util.suggest import short
from floquetrod.rod.model.catalogue import DENSITY, YOUNGS_MODULUS, of_pipe, pipe
from floquetrod.rod.model.parameters import BORE, INSTEAD, MEANT, OF_A_SECTION, ROD, in_si, is_given, units_given
from floquetrod.rod.model.possible_rod import HAS_WALL

MOST_SECTIONS = 1000
"""Sections of a string, and bores of a hole, at most (a choice)."""


@constructor_hints(**MEANT)
@dataclass(frozen=True, init=False, repr=False)
class Section(units.InUnits, TellsAttributes):
    """A length of a string with one cross section and one material.

    Parameters
    ----------
    name : str
        A pipe of the catalogue, `floquetrod.rod.model.catalogue.pipes`, such as "2.00x0.156 CT90", which gives all that
        is not given here but the length; "" for any other section, by default of steel: 207 GPa, 7850 kg/m^3.
    length : float or str
        Length in m, or with a unit such as "1200m"; greater than 0.
    radius : float or str
        Outer radius in m, or with a unit.  Give it or ``diameter``.
    inner_radius : float or str
        Inner radius in m, or with a unit, by default 0, a solid section.
    youngs_modulus : float or str
        E in Pa, or with a unit.
    density : float or str
        Of the material in kg/m^3, or with a unit.  Give it or ``weight``.
    yield_strength : float or str, optional
        In Pa, or with a unit.
    diameter : float or str, optional
        Outer diameter in m, or with a unit.
    inner_diameter : float or str, optional
        Inner diameter in m, or with a unit.
    wall_thickness : float or str, optional
        In m, or with a unit, in place of ``inner_radius``.
    weight : float or str, optional
        Weight in air per length in N/m, or with a unit such as "22.6lb/ft", joints included.

    Raises
    ------
    TypeError, ValueError
        For numbers out of these ranges, other units, a name outside the catalogue, and two arguments for one size.

    Examples
    --------
    >>> Section("2.00x0.156 CT90", length="1200m")
    Section('2.00x0.156 CT90', length=1200.0)
    >>> round(Section(diameter="2.875in", inner_diameter="1in", length="5m").radius, 7)
    0.0365125
    """

    length: float
    radius: float
    inner_radius: float
    youngs_modulus: float
    density: float
    yield_strength: float | None = None
    name: str = field(default="", compare=False)

    def __init__(
        self,
        name: str = "",
        *,
        length: float | str,
        radius: float | str | None = None,
        inner_radius: float | str | None = None,
        youngs_modulus: float | str | None = None,
        density: float | str | None = None,
        yield_strength: float | str | None = None,
        diameter: float | str | None = None,
        inner_diameter: float | str | None = None,
        wall_thickness: float | str | None = None,
        weight: float | str | None = None,
    ) -> None:
        """Check and clean the parameters."""
        given = {key: value for key, value in locals().items() if key not in ("self", "name")}
        if not isinstance(name, str):
            raise wrong_type("name", f"must be the size of a pipe such as '2.00x0.156 CT90', got {short(name)}")
        numbers = in_si(_with_defaults(name, given), OF_A_SECTION)
        HAS_WALL.check(numbers)
        for key, number in numbers.items():
            object.__setattr__(self, key, number)
        object.__setattr__(self, "name", name)
        self.given_in(units_given(given))

    def __repr__(self) -> str:
        """Return the expression that makes this section."""
        first = (repr(self.name),) if self.name else ()
        return f"Section({', '.join((*first, *(f'{k}={v!r}' for k, v in self.as_dict().items() if k != 'name')))})"

    def as_dict(self) -> dict[str, Any]:
        """Return the arguments that make an equal section, numbers in SI units; without what its name gives.

        Returns
        -------
        dict of str
            ``Section(**sheet)`` is an equal section.
        """
        default = Section(self.name, length=self.length) if self.name else None
        sheet = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in ("name", "length")}
        if default is not None:
            sheet = {key: value for key, value in sheet.items() if value != getattr(default, key)}
        else:
            sheet = {key: value for key, value in sheet.items() if value is not None}
        return ({"name": self.name} if self.name else {}) | {"length": self.length} | sheet


def _with_defaults(name: str, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of a section with what its name gives, or steel."""
    own = {key for key, value in given.items() if value is not None}
    if name:
        return {**given, **of_pipe(pipe(name), own)}
    steel = {"youngs_modulus": YOUNGS_MODULUS} | ({} if {"density", "weight"} & own else {"density": DENSITY})
    return {**given, **{key: value for key, value in steel.items() if key not in own}}


class Bore(NamedTuple):
    """A bore of the hole from a depth down to the next bore."""

    depth: float
    """In m: a measured depth in a well, and from the upper end of the rod without one."""
    diameter: float
    """Inner diameter of the hole in m."""


def sections_of(given: Any) -> tuple[Section, ...]:
    """Return sections from the upper end down, like neighbours joined; TypeError or ValueError for others."""
    if not is_given(given):
        return ()
    listed = _listed("sections", given, 'such as [fr.Section("2.00x0.156 CT90", length="1200m"), ...]')
    made: list[Section] = []
    for i, each in enumerate(listed):
        section = _section(each, f"sections[{i}]")
        if made and _are_alike(made[-1], section):
            made[-1] = _of_length(made[-1], made[-1].length + section.length)
        else:
            made.append(section)
    return tuple(made)


def _are_alike(one: Section, other: Section) -> bool:
    """Return whether sections differ in their length alone."""
    return all(getattr(one, name) == getattr(other, name) for name in OF_A_SECTION if name != "length")


def _of_length(section: Section, length: float) -> Section:
    """Return the same section with another length in m."""
    made = object.__new__(Section)
    for each in fields(section):
        object.__setattr__(made, each.name, getattr(section, each.name))
    object.__setattr__(made, "length", length)
    return made.given_in(section.given_units)


def _section(given: Any, name: str) -> Section:
    """Return a section that is given as one or by its arguments."""
    if isinstance(given, Section):
        return given
    if not isinstance(given, Mapping):
        raise wrong_type(
            name, f'must be a section such as fr.Section("2.00x0.156 CT90", length="1200m"), got {short(given)}'
        )
    try:
        return Section(**given)
    except (TypeError, ValueError) as error:
        raise error_in(name, error) from None


def bores_of(given: Any, top: float) -> tuple[Bore, ...]:
    """Return bores from the top down, neighbours of one diameter as one, for a rod whose upper end is at a depth in m.

    TypeError or ValueError for anything but pairs of increasing depths and diameters that begin at or above that end.
    """
    if not is_given(given):
        return ()
    made: list[Bore] = []
    listed = _listed("bores", given, 'such as [("0m", "4.778in"), ("1500m", "6.184in")]')
    before = -1.0
    for i, pair in enumerate(listed):
        if isinstance(pair, str) or not isinstance(pair, Sequence) or len(pair) != 2:
            raise wrong_type(
                f"bores[{i}]", f'must be a depth and a diameter such as ("0m", "4.778in"), got {short(pair)}'
            )
        depth = units.number(f"bores[{i}]", pair[0], "length", 0.0, ROD["depth"].largest, hint="give the depth in m")
        diameter = BORE.number(pair[1], f"bores[{i}]")
        if depth <= before:
            after = short(listed[i - 1][0])
            raise wrong_value(
                f"bores[{i}]",
                f"must begin below the bore before it, got {short(pair[0])} after {after}; list them from the top down",
            )
        if not made and depth > top:
            raise wrong_value(
                f"bores[{i}]",
                f"must begin at or above the upper end of the rod, at {top:g} m, got {short(pair[0])}; give the bore "
                "there, too",
            )
        before = depth
        if not made or made[-1].diameter != diameter:
            made.append(Bore(depth, diameter))
    return tuple(made)


def _listed(name: str, given: Any, such: str) -> list[Any]:
    """Return a list of one to `MOST_SECTIONS`."""
    if isinstance(given, str | bytes | Mapping) or not isinstance(given, Sequence):
        raise wrong_type(name, f"must be a list {such}, got {short(given)}")
    if not given:
        raise wrong_value(name, f"must be a list of one or more {such}, got an empty one; leave it out for none")
    if given[MOST_SECTIONS : MOST_SECTIONS + 1]:
        try:
            count = f"{len(given):,}"
        except OverflowError:  # of a range
            count = "more"
        raise wrong_value(name, f"must be {MOST_SECTIONS:,} at most, got {count}; give alike ones that adjoin as one")
    return list(given)


def at_the_upper_end(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of a rod, its upper section and bore in place of sections and bores.

    ``sections`` and ``bores`` are cleaned, and () where there is one section, or one bore, all along.
    """
    sections = sections_of(given["sections"])
    top = 0.0 if given["path"] is None else ROD["depth"].number(given["depth"])
    bores = bores_of(given["bores"], top)
    changed: dict[str, Any] = {}
    if sections:
        own = (*OF_A_SECTION, *(alias for alias, name in INSTEAD.items() if name in OF_A_SECTION))
        _require_absent(given, own, "sections", "each section has its own")
        upper = sections[0]
        changed = {name: getattr(upper, name) for name in OF_A_SECTION}
        changed["length"] = sum(each.length for each in sections)
    if bores:
        own = ("channel_radius", *(alias for alias, name in INSTEAD.items() if name == "channel_radius"))
        _require_absent(given, own, "bores", "each bore has its own diameter")
        changed["channel_radius"] = 0.5 * [bore for bore in bores if bore.depth <= top][-1].diameter
    return {
        **given,
        **changed,
        "sections": sections if len(sections) > 1 else (),
        "bores": bores if len(bores) > 1 else (),
    }


def _require_absent(given: Mapping[str, Any], names: Sequence[str], other: str, why: str) -> None:
    """Raise ValueError for an argument that another takes the place of."""
    for name in names:
        if given[name] is not None:
            raise wrong_value(name, f"must not be given with {other}, got {short(given[name])}; {why}")


def divided(
    sections: Sequence[Section], bores: Sequence[Bore], top: float, length: float
) -> list[tuple[float, float, int, float]]:
    """Return the parts of a string whose upper end is at a depth: start, end, number of the section, bore diameter.

    Starts and ends in m from the upper end; of a string of ``sections`` whose lengths come to ``length``.
    """
    ends = [*itertools.accumulate(each.length for each in sections)][:-1] if sections else []
    cuts = {0.0, length, *ends, *(bore.depth - top for bore in bores if 0.0 < bore.depth - top < length)}
    edges = sorted(cuts)
    parts = []
    for start, end in itertools.pairwise(edges):
        number = sum(edge <= start for edge in ends)
        diameter = next((bore.diameter for bore in reversed(bores) if bore.depth - top <= start), 0.0)
        parts.append((start, end, number, diameter))
    return parts
