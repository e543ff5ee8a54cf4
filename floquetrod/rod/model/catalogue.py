"""The catalogue of steel pipes and rods by their size in inches: coiled tubing, drill pipe, tubing and sucker rods.

Sizes and grades follow API Spec 5ST, with the walls and grades that makers of coiled tubing list beside it, API Spec
5DP (earlier 5D, https://www.usisteels.com/newsdetail/api-spec-5d-drill-pipe-specifications.html), API Spec 5CT
(http://api-pipes-tubes.blogspot.com/2014/07/tubing-with-threaded-non-upset-end-and_31.html) and API Spec 11B; weights
of sucker rods with their couplings follow API RP 11L.  Grades of pipes are named after their least yield strength in
ksi.
"""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Collection
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import Mention
from floquetrod._util.result_report import Report, Table
from floquetrod.rod.model.parameters import BORE

YOUNGS_MODULUS = 207e9
"""E of steel in Pa."""

DENSITY = 7850.0
"""Density of steel in kg/m^3."""

_INCH = units.units_of("length")["in"]
_KSI = units.units_of("pressure")["ksi"]
_POUNDS_PER_FOOT, _KILOGRAMS_PER_METRE = (units.units_of("weight")[name] for name in ("lb/ft", "kg/m"))
_ALIKE = 5e-4  # inches; sizes are written to thousandths

_YIELD = {
    **{f"CT{ksi}": float(ksi) for ksi in (70, 80, 90, 100, 110, 120, 130)},
    "E75": 75.0,
    "X95": 95.0,
    "G105": 105.0,
    "S135": 135.0,
    "H40": 40.0,
    "J55": 55.0,
    "N80": 80.0,
    "L80": 80.0,
    "C90": 90.0,
    "R95": 95.0,
    "T95": 95.0,
    "P110": 110.0,
    "K": 60.0,
    "C": 60.0,
    "D": 85.0,
    "KD": 85.0,
    "HL": 115.0,
}
"""Least yield strength of each grade in ksi; above CT110, and HL, by their makers alone."""

_COILED, _DRILL, _TUBING, _SUCKER = (
    tuple(name for name in _YIELD if re.fullmatch(pattern, name))
    for pattern in (r"CT\d+", "E75|X95|G105|S135", "H40|J55|N80|L80|C90|R95|T95|P110", "K|C|D|KD|HL")
)

_WALLS = (
    *(0.080, 0.087, 0.095, 0.102, 0.109, 0.118, 0.125, 0.134, 0.145, 0.156, 0.175, 0.188, 0.190, 0.203, 0.204, 0.224),
    *(0.250, 0.276, 0.300),
)
"""Walls of coiled tubing in inches; some makers list 0.188 and 0.203, others 0.190 and 0.204."""

_COILED_SIZES = {
    1.0: (0.080, 0.109),
    1.25: (0.080, 0.175),
    1.5: (0.095, 0.175),
    1.75: (0.109, 0.190),
    2.0: (0.109, 0.224),
    2.375: (0.125, 0.250),
    2.625: (0.134, 0.250),
    2.875: (0.125, 0.276),
    3.25: (0.156, 0.276),
    3.5: (0.156, 0.300),
}
"""Thinnest and thickest wall of coiled tubing in inches by its diameter."""

_DRILL_SIZES = (
    (2.375, 0.280, "EXGS"),
    (2.875, 0.362, "EXGS"),
    (3.5, 0.254, "E"),
    (3.5, 0.368, "EXGS"),
    (3.5, 0.449, "EXGS"),
    (4.0, 0.330, "EXGS"),
    (4.5, 0.271, "E"),
    (4.5, 0.337, "EXGS"),
    (4.5, 0.430, "EXGS"),
    (5.0, 0.296, "XGS"),
    (5.0, 0.362, "EXGS"),
)
"""Diameter and wall of drill pipe in inches, and the initials of its grades."""

_TUBING_SIZES = {
    1.05: (0.113, 0.154),
    1.315: (0.133, 0.179),
    1.66: (0.125, 0.140, 0.191),
    1.9: (0.125, 0.145, 0.200),
    2.375: (0.167, 0.190, 0.254, 0.295, 0.336),
    2.875: (0.217, 0.276, 0.308, 0.340, 0.392, 0.440),
    3.5: (0.216, 0.254, 0.289, 0.375, 0.430, 0.476, 0.530),
    4.0: (0.226, 0.262, 0.330, 0.415, 0.500, 0.610),
    4.5: (0.271, 0.337, 0.380, 0.430, 0.500, 0.560, 0.630),
}
"""Walls of tubing in inches by its diameter."""

_SUCKER_SIZES = {"5/8": 1.135, "3/4": 1.634, "7/8": 2.224, "1": 2.904, "1-1/8": 3.676}
"""Weight in air of sucker rods with their couplings in lb/ft, by their diameter in inches."""

_NUMBER = r"\d{0,3}\.\d{1,6}|\d{1,3}\.?"
_INCHES = r'\s*(?:inch(?:es)?|in\.?|")?\s*'
_SIZE = rf"(?:(?:(?P<whole>\d{{1,3}})[-\s]+)?(?P<parts>\d{{1,3}}/[1-9]\d{{0,2}})|(?P<od>{_NUMBER})){_INCHES}"
_NAME = re.compile(
    rf"\s*{_SIZE}(?:[x\u00d7]\s*(?P<wall>{_NUMBER}){_INCHES}|(?:sucker[-\s]*)?rods?\b\s*)"
    r"(?P<grade>[a-z]{1,2}(?:[-\s]?\d{2,3})?)?\s*",
    re.ASCII | re.IGNORECASE,
)
_BEGINS = re.compile(rf"\s*{_SIZE}(?:[x\u00d7]|(?:sucker[-\s]*)?rods?\b)", re.ASCII | re.IGNORECASE)


class CataloguePipe(NamedTuple):
    """A pipe or a rod of the catalogue; of drill pipe and tubing the body between the joints.

    Attributes
    ----------
    name : str
        Outer diameter and wall thickness in inches, such as "2.00x0.156"; of sucker rods the diameter, "3/4 rod".
    product : str
        "coiled tubing", "drill pipe", "tubing" or "sucker rod".
    diameter : float
        Outer diameter in m.
    wall_thickness : float
        In m; 0 for a solid rod.
    source : str
        The standard that lists it.
    grades : tuple of str
        Grades of steel that may be given.
    grade : str
        The grade that was given, "" without one.
    yield_strength : float or None
        Least yield strength of that grade in Pa.
    weight : float or None
        Weight in air per length in N/m, couplings included; None where it is the weight of the body.
    """

    name: str
    product: str
    diameter: float
    wall_thickness: float
    source: str
    grades: tuple[str, ...]
    grade: str = ""
    yield_strength: float | None = None
    weight: float | None = None


@functools.cache
def pipes() -> tuple[CataloguePipe, ...]:
    """Return every pipe and rod of the catalogue, without a grade.

    Returns
    -------
    tuple of CataloguePipe
        In the order of products and sizes.

    Examples
    --------
    >>> [pipe.name for pipe in pipes() if pipe.product == "sucker rod"]
    ['5/8 rod', '3/4 rod', '7/8 rod', '1 rod', '1-1/8 rod']
    """
    tubes: list[tuple[float, float, str, str, tuple[str, ...]]] = [
        (od, wall, "coiled tubing", "API Spec 5ST", _COILED)
        for od, (thinnest, thickest) in _COILED_SIZES.items()
        for wall in _WALLS
        if thinnest <= wall <= thickest
    ]
    for od, wall, initials in _DRILL_SIZES:
        tubes.append((od, wall, "drill pipe", "API Spec 5DP", tuple(g for g in _DRILL if g[0] in initials)))
    tubes += [(od, wall, "tubing", "API Spec 5CT", _TUBING) for od, walls in _TUBING_SIZES.items() for wall in walls]
    rods = [
        CataloguePipe(
            f"{size} rod",
            "sucker rod",
            _inches(size) * _INCH,
            0.0,
            "API Spec 11B",
            _SUCKER,
            weight=weight * _POUNDS_PER_FOOT,
        )
        for size, weight in _SUCKER_SIZES.items()
    ]
    return (
        *(
            CataloguePipe(
                f"{f'{od:.3f}'.removesuffix('0')}x{wall:.3f}", product, od * _INCH, wall * _INCH, source, grades
            )
            for od, wall, product, source, grades in tubes
        ),
        *rods,
    )


@dataclass(frozen=True)
class Catalogue:
    """Pipes and rods of the catalogue.

    Attributes
    ----------
    pipes : tuple of CataloguePipe
    by_diameter : bool
        Whether the report has one line a diameter and product, else one a pipe.
    """

    pipes: tuple[CataloguePipe, ...]
    by_diameter: bool

    def report(self) -> Report:
        """Return the pipes as a table, and their grades with the least yield strengths."""
        products = {row.product: row for row in self.pipes}
        grades = [
            (product, f"{row.source}; least yield strength: {', '.join(map(_grade_in_words, row.grades))}")
            for product, row in products.items()
        ]
        width = max(map(len, products))
        text = "\n".join(f"{product:<{width}}  {words}" for product, words in grades)
        table = self._by_diameter() if self.by_diameter else self._by_pipe()
        return Report(text, (), table._replace(rest="CT120, CT130 and HL are makers' grades"))

    def _by_diameter(self) -> Table:
        """Return a table of diameters, each with its walls."""
        walls: dict[tuple[str, str], list[str]] = {}
        for row in self.pipes:
            diameter, _, wall = row.name.partition("x")
            walls.setdefault((row.product, diameter), []).extend([wall] if wall else [])
        rows = [(product, diameter, " ".join(listed)) for (product, diameter), listed in walls.items()]
        return Table((("", "<13"), ("diameter in", "<11"), ("walls in", "<1")), rows)

    def _by_pipe(self) -> Table:
        """Return a table of pipes in inches, mm, kg/m and lb/ft."""
        rows = []
        for row in self.pipes:
            mass = weight_in_air(row) / _KILOGRAMS_PER_METRE
            sizes = f"{1e3 * row.diameter:.2f}", f"{1e3 * row.wall_thickness:.2f}" if row.wall_thickness else "solid"
            weights = f"{mass:.3f}", f"{weight_in_air(row) / _POUNDS_PER_FOOT:.3f}"
            rows.append((row.name, row.product, *sizes, *weights, " ".join(row.grades)))
        columns = ("name", "<11"), ("", "<13"), ("mm", ">7"), ("wall mm", ">7"), ("kg/m", ">7"), ("lb/ft", ">7")
        return Table((*columns, ("grades", "<1")), rows)

    def as_dict(self) -> dict[str, Any]:
        """Return the pipes and the grades as numbers for JSON, units in the keys."""
        listed = [
            {
                "name": row.name,
                "product": row.product,
                "source": row.source,
                "diameter_m": row.diameter,
                "wall_thickness_m": row.wall_thickness,
                "weight_in_air_N_per_m": weight_in_air(row),
                "grades": list(row.grades),
            }
            for row in self.pipes
        ]
        grades = dict.fromkeys(grade for row in self.pipes for grade in row.grades)
        return {"pipes": listed, "yield_strength_Pa": {grade: _YIELD[grade] * _KSI for grade in grades}}


def catalogue(beginning: str = "") -> Catalogue:
    """Return the catalogue, or the pipes and rods whose names begin so.

    Returns
    -------
    Catalogue
        Its text is a table.

    Raises
    ------
    ValueError
        Where no name begins so.
    """
    chosen = tuple(row for row in pipes() if row.name.startswith(beginning.strip()))
    if not chosen:
        diameters = ", ".join(dict.fromkeys(row.name.partition("x")[0] for row in pipes()))
        got = validate.short(beginning)
        raise ValueError(f"SIZE must begin the name of a pipe or a rod, got {got}; the diameters are {diameters}")
    return Catalogue(chosen, by_diameter=not beginning.strip())


def weight_in_air(row: CataloguePipe) -> float:
    """Return the weight in air of a pipe or a rod in N/m, of sucker rods with their couplings."""
    if row.weight is not None:
        return row.weight
    area = math.pi * row.wall_thickness * (row.diameter - row.wall_thickness)
    return DENSITY * area * _KILOGRAMS_PER_METRE


def _grade_in_words(grade: str) -> str:
    return f"{grade} {_YIELD[grade]:g} ksi"


def is_size(text: str) -> bool:
    """Return whether a text begins as the name of a pipe or a rod of the catalogue does."""
    return _BEGINS.match(text) is not None


def pipe(name: str) -> CataloguePipe:
    """Return a pipe or a rod of the catalogue by its size in inches and, if wanted, its grade.

    Parameters
    ----------
    name : str
        Outer diameter x wall thickness, then the grade: "2.00x0.156 CT90", "2 in x .156 in" or "2-7/8x0.217 n-80"; of
        sucker rods "3/4 rod D".  Where several products have a size, the grade tells which is meant.

    Returns
    -------
    CataloguePipe
        With sizes in m and, with a grade, its yield strength in Pa.

    Raises
    ------
    TypeError, ValueError
        For anything but a text of this form, and for a size or grade that the catalogue does not hold.

    Examples
    --------
    >>> tubing = pipe("2x.156 CT90")
    >>> tubing.name, tubing.grade, f"{tubing.yield_strength / 1e6:.0f} MPa", tubing.source
    ('2.00x0.156', 'CT90', '621 MPa', 'API Spec 5ST')
    >>> pipe("2-3/8x0.190 L80").product, pipe("3/4 sucker rod D").name
    ('tubing', '3/4 rod')
    """
    if not isinstance(name, str):
        raise validate.wrong_type(
            "name", f"must be the size of a pipe such as '2.00x0.156 CT90', got {validate.short(name)}"
        )
    read = _NAME.fullmatch(name)
    if read is None:
        raise validate.wrong_value(
            "name",
            "must be an outer diameter and a wall thickness in inches, with or without a grade, such as "
            f"'2.00x0.156 CT90', or a sucker rod such as '3/4 rod D', got {validate.short(name)}; floquetrod catalogue "
            "lists them",
        )
    od = float(read["od"] or Fraction(read["parts"]) + int(read["whole"] or 0))
    wall = float(read["wall"] or 0.0)

    def distance(row: CataloguePipe) -> tuple[float, float]:
        return abs(row.diameter / _INCH - od), abs(row.wall_thickness / _INCH - wall)

    nearest = sorted((row for row in pipes() if bool(row.wall_thickness) == bool(wall)), key=distance)
    of_size = [row for row in nearest if max(distance(row)) <= _ALIKE]
    if not of_size:
        raise validate.wrong_value(
            "name",
            f"must be the size of a pipe of the catalogue, got {validate.short(name)}; the closest are "
            f"{', '.join(dict.fromkeys(row.name for row in nearest[:4]))}; for another size write diameter and "
            "wall_thickness into a rod file (TOML)",
            Mention("", ", or give them to fr.Rod"),
        )
    if not read["grade"]:
        return of_size[0]
    grade = re.sub(r"[-\s]", "", read["grade"]).upper()
    of_grade = [row for row in of_size if grade in row.grades]
    if not of_grade:
        known = " or ".join(f"{row.name} {row.product} ({', '.join(row.grades)})" for row in of_size)
        raise validate.wrong_value("name", f"must end in a grade of {known} or in none, got {validate.short(name)}")
    return of_grade[0]._replace(grade=grade, yield_strength=_YIELD[grade] * _KSI)


def of_pipe(row: CataloguePipe, given: Collection[str]) -> dict[str, Any]:
    """Return what a pipe gives besides the arguments ``given`` by name: size, steel and yield strength."""
    size: dict[str, Any] = {}
    if not {"radius", "diameter"} & set(given):
        size["diameter"] = row.diameter
    if row.wall_thickness and not {"inner_radius", "inner_diameter", "wall_thickness"} & set(given):
        size["wall_thickness"] = row.wall_thickness
    if not {"density", "weight"} & set(given):
        size |= {"density": DENSITY} if row.weight is None else {"weight": row.weight}
    steel = {"youngs_modulus": YOUNGS_MODULUS, "yield_strength": row.yield_strength, **size}
    return {name: value for name, value in steel.items() if name not in given}


def pipe_in_a_hole(name: str, bore: float | str, length: float | str, changes: dict[str, Any]) -> dict[str, Any]:
    """Return the arguments of the rod that is a pipe of the catalogue; strings are quantities with their unit."""
    steel_pipe = pipe(name)
    given = changes | {"length": length}
    hole = BORE.number(bore)
    for other in ("channel_radius", "channel_diameter"):
        if other in given:
            raise validate.wrong_value(
                other, f"must not be given with bore, got {validate.short(changes[other])}; drop it"
            )
    own = of_pipe(steel_pipe, given.keys())
    if "diameter" in own and hole <= steel_pipe.diameter:
        raise validate.wrong_value(
            "bore",
            f"must exceed the outer diameter of the pipe, got {hole:g} m for {steel_pipe.diameter:g} m; it is the "
            'inner diameter of the hole in m, or a string with a unit such as "4.778in"',
        )
    return {**own, "channel_diameter": bore} | given


def _inches(size: str) -> float:
    """Return a diameter in inches that is written as a fraction, such as 1-1/8."""
    return float(sum(map(Fraction, size.split("-"))))
