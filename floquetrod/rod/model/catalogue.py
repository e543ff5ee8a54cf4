"""A small catalogue of steel pipes by their size in inches: coiled tubing and drill pipe.

Sizes and grades are those of API Spec 5ST (a selection) and of API Spec 5DP (earlier 5D, as listed at
https://www.usisteels.com/newsdetail/api-spec-5d-drill-pipe-specifications.html); a grade is named after its least yield
strength in ksi.
"""

from __future__ import annotations

import functools
import re
from fractions import Fraction
from typing import Any, NamedTuple

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import Mention
from floquetrod.rod.model.parameters import BORE

YOUNGS_MODULUS = 207e9
"""E of steel in Pa."""

DENSITY = 7850.0
"""Density of steel in kg/m^3."""

_INCH = units.units_of("length")["in"]
_KSI = units.units_of("pressure")["ksi"]
_ALIKE = 5e-4  # inches; sizes are written to thousandths
_COILED = {"CT70": 70.0, "CT80": 80.0, "CT90": 90.0, "CT100": 100.0, "CT110": 110.0}
_DRILL = {"E75": 75.0, "X95": 95.0, "G105": 105.0, "S135": 135.0}
_COILED_SIZES = (
    (1.25, 0.109),
    (1.5, 0.125),
    (1.75, 0.134),
    (2.0, 0.156),
    (2.375, 0.175),
    (2.375, 0.190),
    (2.875, 0.204),
)
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
_NUMBER = r"\d{0,3}\.\d{1,6}|\d{1,3}\.?"
_INCHES = r'\s*(?:inch(?:es)?|in\.?|")?\s*'
_NAME = re.compile(
    rf"\s*(?:(?:(?P<whole>\d{{1,3}})[-\s]+)?(?P<parts>\d{{1,3}}/[1-9]\d{{0,2}})|(?P<od>{_NUMBER})){_INCHES}"
    rf"[x\u00d7]\s*(?P<wall>{_NUMBER}){_INCHES}(?P<grade>[a-z]{{1,2}}[-\s]?\d{{2,3}})?\s*",
    re.ASCII | re.IGNORECASE,
)


class CataloguePipe(NamedTuple):
    """A pipe of the catalogue; of drill pipe the body between the tool joints.

    Attributes
    ----------
    name : str
        Outer diameter and wall thickness in inches, such as "2.00x0.156".
    product : str
        "coiled tubing" or "drill pipe".
    diameter : float
        Outer diameter in m.
    wall_thickness : float
        In m.
    source : str
        The standard that lists it.
    grades : tuple of str
        Grades of steel that may be given.
    grade : str
        The grade that was given, "" without one.
    yield_strength : float or None
        Least yield strength of that grade in Pa.
    """

    name: str
    product: str
    diameter: float
    wall_thickness: float
    source: str
    grades: tuple[str, ...]
    grade: str = ""
    yield_strength: float | None = None


@functools.cache
def pipes() -> tuple[CataloguePipe, ...]:
    """Return every pipe of the catalogue, without a grade.

    >>> [pipe.name for pipe in pipes() if pipe.product == "coiled tubing"]
    ['1.25x0.109', '1.50x0.125', '1.75x0.134', '2.00x0.156', '2.375x0.175', '2.375x0.190', '2.875x0.204']
    """
    rows = [(*size, "coiled tubing", "API Spec 5ST", tuple(_COILED)) for size in _COILED_SIZES]
    for od, wall, initials in _DRILL_SIZES:
        rows.append((od, wall, "drill pipe", "API Spec 5DP", tuple(g for g in _DRILL if g[0] in initials)))
    return tuple(
        CataloguePipe(f"{_inches(od)}x{wall:.3f}", product, od * _INCH, wall * _INCH, source, grades)
        for od, wall, product, source, grades in rows
    )


def pipe(name: str) -> CataloguePipe:
    """Return a pipe of the catalogue by its size in inches and, if wanted, its grade.

    Parameters
    ----------
    name : str
        Outer diameter x wall thickness, then the grade: "2.00x0.156 CT90", "2 in x .156 in" or "2-7/8x0.204 ct-80".

    Raises
    ------
    TypeError, ValueError
        For anything but a text of this form, and for a size or grade that the catalogue does not hold.

    Examples
    --------
    >>> found = pipe("2x.156 CT90")
    >>> found.name, found.grade, f"{found.yield_strength / 1e6:.0f} MPa", found.source
    ('2.00x0.156', 'CT90', '621 MPa', 'API Spec 5ST')
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
            f"'2.00x0.156 CT90', got {validate.short(name)}; the catalogue holds {_names(pipes())}",
        )
    od = float(read["od"] or Fraction(read["parts"]) + int(read["whole"] or 0))
    wall = float(read["wall"])

    def distance(row: CataloguePipe) -> tuple[float, float]:
        return abs(row.diameter / _INCH - od), abs(row.wall_thickness / _INCH - wall)

    nearest = sorted(pipes(), key=distance)
    nearest_pipe = nearest[0]
    if max(distance(nearest_pipe)) > _ALIKE:
        raise validate.wrong_value(
            "name",
            f"must be the size of a pipe of the catalogue, got {validate.short(name)}; the closest are "
            f"{_names(nearest[:3])}; for another size write diameter and wall_thickness into a rod file (TOML)",
            Mention("", ", or give them to fr.Rod"),
        )
    if not read["grade"]:
        return nearest_pipe
    grade = re.sub(r"[-\s]", "", read["grade"]).upper()
    if grade not in nearest_pipe.grades:
        raise validate.wrong_value(
            "name",
            f"must end in a grade of {nearest_pipe.name} {nearest_pipe.product} "
            f"({', '.join(nearest_pipe.grades)}) or in none, got "
            f"{validate.short(name)}",
        )
    return nearest_pipe._replace(grade=grade, yield_strength=(_COILED | _DRILL)[grade] * _KSI)


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
    size = {}
    if not {"radius", "diameter"} & given.keys():
        size["diameter"] = steel_pipe.diameter
        if hole <= steel_pipe.diameter:
            raise validate.wrong_value(
                "bore",
                f"must exceed the outer diameter of the pipe, got {hole:g} m for {steel_pipe.diameter:g} m; it is the "
                'inner diameter of the hole in m, or a string with a unit such as "4.778in"',
            )
    if not {"inner_radius", "inner_diameter", "wall_thickness"} & given.keys():
        size["wall_thickness"] = steel_pipe.wall_thickness
    steel = {"youngs_modulus": YOUNGS_MODULUS, "density": DENSITY, "yield_strength": steel_pipe.yield_strength}
    return {**steel, **size, "channel_diameter": bore} | given


def _inches(value: float) -> str:
    """Return a diameter in inches to hundredths, or to thousandths where it has them."""
    return f"{value:.3f}".removesuffix("0")


def _names(found: tuple[CataloguePipe, ...] | list[CataloguePipe]) -> str:
    return ", ".join(row.name for row in found)
