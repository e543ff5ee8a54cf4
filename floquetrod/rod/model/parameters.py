"""The parameters of a rod: one record each, and how arguments given in place of them become them.

To add one: a record here, a field and an argument in `floquetrod.rod.model.data.RodData`, a paragraph in the docstring
of `floquetrod.Rod`, and the formula it enters; tests compare the four.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from floquetrod._util.arguments import Mention, Message, wrong_type, wrong_value
from floquetrod._util.calling import level_of_caller
from floquetrod._util.plausibility_warning import SILENCE, PlausibilityWarning, is_typed
from floquetrod._util.suggest import short
from floquetrod.parameter import EVERYWHERE, REQUIRED, Option, Parameter, Subsystem, by_name
from floquetrod.units import GivenUnits, units_of

if TYPE_CHECKING:
    from floquetrod.wells.path import WellPath

_LEAST, _LARGEST = 1e-12, 1e15  # of any parameter in its SI unit: what is computed from them stays in range (a choice)
_SHARPEST = 1e3  # curvature of a channel in 1/m: a bend of a millimetre (a choice: beyond any)
_LARGEST_FRICTION = 1e6  # (a choice: beyond any)
_STANDARD_GRAVITY = units_of("weight")["kg/m"]
_ROUGHEST = 1.5  # coefficient of friction: rubber on dry concrete has about 1 (a choice)

ON_A_FLOOR = math.pi**2 / 3.0 - 1.0
"""Added-mass coefficient of a cylinder that touches a plane floor, 2.29."""

_POSITIVE: dict[str, Any] = {"least": _LEAST, "largest": _LARGEST}
_NOT_NEGATIVE: dict[str, Any] = {"least": 0.0, "largest": _LARGEST}
_KNOW_SECTIONS: frozenset[Subsystem] = frozenset(
    {"modes", "bends", "critical force", "simulation", "stress", "strings"}
)


def _but(*subsystems: Subsystem) -> dict[str, Any]:
    """Return that all subsystems know a parameter but some, whose answers do not depend on it."""
    return {"known_to": EVERYWHERE - {*subsystems}, "without_effect_on": frozenset(subsystems)}


def _length(name: str, factor: float, least: float = _LEAST) -> Parameter:
    """Return what may be given in place of a length."""
    return Parameter(name=name, symbol="", kind="length", least=least, largest=_LARGEST, factor=factor)


BORE = Parameter(
    name="bore",
    symbol="",
    kind="length",
    **_POSITIVE,
    factor=2.0,
    option=Option("diameter of the channel such as 4.778in (replaces that of the rod)", "LENGTH"),
)
"""Diameter of the channel around a pipe of the catalogue."""

WEIGHT = Parameter(
    name="weight",
    symbol="",
    kind="weight",
    **_POSITIVE,
    hint='give the weight in air per length in N/m, or with a unit such as "22.6lb/ft"',
    option=Option("weight in air per length, joints included, such as 22.6lb/ft (replaces the density)", "WEIGHT"),
)
"""Weight in air per length, given in place of the density."""

ROD = by_name(
    Parameter(name="youngs_modulus", symbol="E", kind="pressure", **_POSITIVE, **_but()),
    Parameter(name="density", symbol="rho", kind="density", **_POSITIVE, **_but(), instead=(WEIGHT,)),
    Parameter(
        name="radius",
        symbol="r_o",
        kind="length",
        **_POSITIVE,
        **_but(),
        instead=(_length("diameter", 2.0),),
    ),
    Parameter(
        name="length",
        symbol="L",
        kind="length",
        **_POSITIVE,
        **_but("helix", "strings"),
        option=Option("length such as 200ft (replaces that of the rod)"),
    ),
    Parameter(
        name="channel_radius",
        symbol="R + r_o",
        kind="length",
        **_POSITIVE,
        **_but("stress"),
        instead=(_length("channel_diameter", 2.0), BORE),
    ),
    Parameter(name="gravity", symbol="g", kind="acceleration", **_POSITIVE, **_but(), default=9.81),
    Parameter(
        name="damping_rate",
        symbol="c",
        kind="rate",
        **_NOT_NEGATIVE,
        **_but("stress", "critical force", "helix"),
        default=0.0,
        hint="give the decay rate in 1/s",
        option=Option("decay rate of free motion in 1/s (replaces that of the rod)", "RATE"),
    ),
    Parameter(
        name="inner_radius",
        symbol="r_i",
        kind="length",
        **_NOT_NEGATIVE,
        **_but(),
        default=0.0,
        hint="give it in m; 0 for a solid rod",
        is_echoed=True,
        instead=(_length("inner_diameter", 2.0, 0.0), _length("wall_thickness", 1.0)),
    ),
    *(
        Parameter(
            name=f"fluid_{side}",
            symbol=f"rho_{side[0]}",
            kind="density",
            **_NOT_NEGATIVE,
            **_but(),
            default=0.0,
            is_echoed=True,
            in_feet="ppg",
            option=Option(
                f"density of the fluid {side} such as 8.5ppg or 1.02g/cm3 (replaces that of the rod)", "DENSITY"
            ),
        )
        for side in ("inside", "outside")
    ),
    Parameter(
        name="added_mass_coefficient",
        symbol="C_a",
        kind="ratio",
        **_NOT_NEGATIVE,
        **_but("stress", "critical force", "helix", "strings"),
        default=ON_A_FLOOR,
        hint="it is a ratio of masses such as 2.29",
    ),
    Parameter(
        name="inclination",
        symbol="phi",
        kind="angle",
        least=_LEAST,
        largest=0.5 * math.pi,
        **_but("strings"),
        range_in_words="above 0 and at most pi/2 = 1.5708 (horizontal)",
        default=0.5 * math.pi,
        hint='it is the angle from the vertical in radians: math.radians(60), or "60deg"',
        is_echoed=True,
        option=Option(
            "angle of the channel from the vertical such as 70deg, 90deg being horizontal (replaces that of the rod)",
            "ANGLE",
        ),
    ),
    Parameter(
        name="ends",
        symbol="",
        kind="",
        **_but("stress", "critical force", "helix", "strings"),
        default="hinged",
        is_echoed=True,
    ),
    Parameter(
        name="curvature",
        symbol="kappa",
        kind="curvature",
        least=-_SHARPEST,
        largest=_SHARPEST,
        **_but("strings"),
        default=0.0,
        hint="give it in 1/m, positive where the channel builds",
        is_echoed=True,
        option=Option(
            "curvature of the channel in its vertical plane such as 3deg/30m, positive where it builds (replaces that "
            "of the rod)",
            "CURVATURE",
            in_a_well=False,
        ),
    ),
    Parameter(
        name="path",
        symbol="",
        kind="",
        **_but("strings"),
        default=None,
        option=Option(
            "survey of the well that the rod lies in, a text file of columns such as MD (m), Inc (deg), Azi (deg)",
            "FILE",
            in_a_well=False,
        ),
    ),
    Parameter(
        name="depth",
        symbol="",
        kind="length",
        **_NOT_NEGATIVE,
        **_but("strings"),
        default=0.0,
        hint="give it in m, along the path",
        option=Option("measured depth of the rod's upper end such as 1200m (needs --path)", in_a_well=False),
    ),
    Parameter(
        name="residual_curvature",
        symbol="kappa_0",
        kind="curvature",
        least=0.0,
        largest=_SHARPEST,
        default=0.0,
        known_to=frozenset({"stress", "strings"}),
        hint="give it in 1/m, 1 over the radius to which the rod is bent without load",
        is_echoed=True,
        option=Option(
            "curvature of the rod without load, as of tubing from its reel, such as 0.1rad/m (replaces that of the "
            "rod)",
            "CURVATURE",
        ),
    ),
    Parameter(
        name="natural_shape",
        symbol="y_0",
        kind="",
        default=None,
        known_to=frozenset({"simulation"}),
        without_effect_on=frozenset({"modes", "bends", "proofs", "critical force", "stress"}),
        is_echoed=True,
    ),
    Parameter(
        name="yield_strength",
        symbol="",
        kind="pressure",
        **_POSITIVE,
        default=None,
        known_to=frozenset({"stress", "strings"}),
        without_effect_on=EVERYWHERE - {"stress", "strings"},
    ),
    Parameter(
        name="sections",
        symbol="",
        kind="",
        known_to=_KNOW_SECTIONS,
        default=(),
        hint="ask about one part alone, rod.uniform_parts[0].rod, say",
    ),
    Parameter(
        name="bores",
        symbol="",
        kind="",
        known_to=_KNOW_SECTIONS - {"stress"},
        without_effect_on=frozenset({"stress"}),
        default=(),
        hint="ask about one part alone, rod.uniform_parts[0].rod, say",
    ),
)
"""Parameters of a rod by their names."""

GIVEN = by_name(*(each for parameter in ROD.values() for each in (parameter, *parameter.instead)))
"""What a rod may be given by: its parameters, and what may be given in their place."""

INSTEAD = {each.name: name for name, parameter in ROD.items() for each in parameter.instead if each is not BORE}
"""Arguments that may be given in place of a parameter."""

DIAMETERS = {name: radius for name, radius in INSTEAD.items() if GIVEN[name].factor == 2.0}
"""Diameters that may be given in place of a radius."""

NUMBERS = {name: each for name, each in ROD.items() if each.kind and name not in ("depth", "yield_strength")}
"""Parameters that may vary: not a depth on a path, nor a strength, which may be unknown and moves nothing."""

ALONG = ("length", "depth")
"""Lengths along a rod or a well; all others are across."""

OF_A_SECTION = ("youngs_modulus", "density", "radius", "length", "inner_radius", "yield_strength")
"""Parameters that each section of a string has for itself."""

OF_A_LINE = ("inclination", "curvature")
"""What a path takes the place of."""

_MAY_BE_NONE = ("inner_radius", *OF_A_LINE, "yield_strength")  # arguments that are None where they are not given

_RATIO_OF_DAMPING = (
    "give damping_rate in 1/s, the ratio times the angular frequency of the mode it was measured on: 1 % at 8 Hz is "
    "0.01 * 2 pi * 8 Hz = 0.5 1/s"
)

MEANT = {
    "outer_diameter": "the outer diameter is diameter",
    "outer_radius": "the outer radius is radius",
    "od": "the outer diameter is diameter",
    "id": "the inner diameter is inner_diameter",
    "wall": "did you mean wall_thickness?",
    **dict.fromkeys(("damping_ratio", "zeta"), _RATIO_OF_DAMPING),
    **dict.fromkeys(
        ("log_decrement", "logarithmic_decrement"),
        "give damping_rate in 1/s, the decrement times the frequency in Hz of the mode it was measured on",
    ),
    "bore": "a hole of one bore has channel_diameter, one that changes bores; a catalogue pipe takes bore",
    "clearance": "give channel_radius, that of the rod and the clearance together",
}
"""What is often written for a parameter of a rod, with the remedy."""


def in_si(given: Mapping[str, Any], names: Iterable[str] = tuple(ROD)) -> dict[str, Any]:
    """Return a rod's numerical parameters, or those named, in SI units from its arguments.

    Diameters and a wall become radii, and None becomes the default.  TypeError or ValueError, naming the argument, for
    an argument missing, given twice or out of range.
    """
    radii = (name for name in ("radius", "channel_radius", "inner_radius") if name in given)
    given = {**given, **{name: _radius(given, name) for name in radii}}
    given["density"] = _density(given)
    numbers: dict[str, Any] = {}
    for name in names:
        value, parameter = given[name], ROD[name]
        if value is None and parameter.default is REQUIRED:
            raise _missing(name, given)
        if parameter.kind:
            numbers[name] = parameter.default if value is None and name in _MAY_BE_NONE else parameter.number(value)
    return numbers


def _missing(name: str, given: Mapping[str, Any]) -> TypeError:
    """Return the error for a parameter that is ``given`` neither by itself nor by another in its place."""
    other = next((f", or {alias}" for alias, replaced in INSTEAD.items() if replaced == name), "")
    is_of_a_section = name in ("youngs_modulus", "density", "radius", "length")
    more = ", or bores" if name == "channel_radius" else ", or sections" if is_of_a_section else ""
    if "sections" not in given:  # of a section alone
        more = ', or the name of a pipe such as "2.00x0.156 CT90"'
    return wrong_type(name, f"must be given, in {ROD[name].unit}{other}{more}")


def units_given(given: Mapping[str, Any]) -> GivenUnits:
    """Return the units in which parameters of a rod, or what may be given in their place, were written."""
    across = [name for name, each in GIVEN.items() if each.kind == "length" and name not in ALONG]
    return GivenUnits.of(
        length=tuple(given.get(name) for name in ALONG),
        across=tuple(given.get(name) for name in ("bore", "diameter", *across)),
        pressure=given.get("yield_strength"),
        density=tuple(given.get(name) for name in ("fluid_outside", "fluid_inside")),
        curvature=given.get("curvature"),
    )


def is_given(value: Any) -> bool:
    """Return whether sections or bores are given: not None and not (), the default."""
    return value is not None and not (isinstance(value, tuple) and not value)


def units_of_bores(given: Any) -> GivenUnits:
    """Return the units in which depths and diameters of bores were written."""
    depths, diameters = zip(*given, strict=True) if is_given(given) else ((), ())
    return GivenUnits.of(length=depths, across=diameters)


def _density(given: Mapping[str, Any]) -> Any:
    """Return the density in kg/m^3 given by itself, or by the weight in air per length; None where by neither.

    A weight w per length includes the joints, spread over the length: the density w / (g_n A_s), with the standard
    acceleration of gravity g_n, gives the mass per length w / g_n whatever the section A_s.
    """
    density, weight = given["density"], given["weight"]
    if weight is None:
        return density
    if density is not None:
        raise wrong_value(
            "weight", f"must not be given with density, got {short(weight)} and {short(density)}; give one of them"
        )
    mass = WEIGHT.number(weight) / _STANDARD_GRAVITY
    radii = (given[name] for name in ("radius", "inner_radius"))
    outer, inner = (0.0 if radius is None else ROD["inner_radius"].number(radius) for radius in radii)
    area = math.pi * (outer - inner) * (outer + inner)
    return mass / area if area > 0.0 else mass  # without a section, which is refused for what it is


def _radius(given: Mapping[str, Any], name: str) -> Any:
    """Return a radius in m given by itself, by its diameter or by the wall of a tube; None where by none of them."""
    ways = [alias for alias, radius in INSTEAD.items() if radius == name and given[alias] is not None]
    if given[name] is not None:
        ways.insert(0, name)
    if len(ways) > 1:
        first, alias = ways[:2]
        got = f"got {short(given[alias])} and {short(given[first])}"
        raise wrong_value(alias, f"must not be given with {first}, {got}; give one of them")
    if not ways or ways[0] == name:
        return given[name]
    size = GIVEN[ways[0]].number(given[ways[0]])
    if ways[0] in DIAMETERS:
        return 0.5 * size
    radius = _radius(given, "radius")
    if radius is None:
        raise _missing("radius", given)
    outer = ROD["radius"].number(radius)
    if size >= outer:
        raise wrong_value(
            "wall_thickness",
            f"must be less than the outer radius, got wall_thickness = {size:g} m and radius = {outer:g} m; leave it "
            "out for a solid rod",
        )
    return outer - size


def path_of(given: Mapping[str, Any], depth: float, length: float) -> WellPath | None:
    """Return the path of a rod of a length in m whose upper end is at a measured depth in m; None where none is given.

    It is given as a `floquetrod.WellPath`, or by its arguments, and determines inclination and curvature.
    """
    path = given["path"]
    if path is None:
        if depth:
            raise wrong_value(
                "depth",
                f"is the measured depth of the rod's upper end on a path, got {depth:g} m without one; give path",
            )
        return None
    from floquetrod._util import validate  # which needs numpy: options alone do not
    from floquetrod.wells.path import WellPath

    for name in OF_A_LINE:
        if (value := given[name]) is not None:
            raise wrong_value(
                name, f"must not be given with path, which determines it, got {short(value)}; give one of them"
            )
    if isinstance(path, Mapping):
        path = WellPath(**path)
    path = validate.instance("path", path, WellPath, "WellPath.from_csv(file), say")
    room = 1e-9 * max(path.end, length)
    if not path.start - room <= depth <= depth + length <= path.end + room:
        raise wrong_value(
            "depth",
            f"must leave all of the rod on its path from {path.start:g} to {path.end:g} m, and from {depth:g} m it "
            f"reaches to {depth + length:g} m",
        )
    return path


def friction_coefficient(value: Any) -> float:
    """Return a coefficient of friction as a float; warns of one that was probably meant in per cent."""
    from floquetrod._util import validate

    number = validate.nonnegative("friction", value, "friction opposes the motion")
    validate.within("friction", number, 0.0, _LARGEST_FRICTION, "it is a coefficient such as 0.1")
    warn_of_friction(number)
    return number


def warn_of_friction(number: float) -> None:
    """Warn of a coefficient of friction that was probably meant in per cent."""
    if _ROUGHEST < number <= 100.0 * _ROUGHEST and is_typed(number):
        warnings.warn(
            Message(
                Mention("friction"),
                f" = {number:g} is larger than that of rubber on concrete; was it in per cent? It is a coefficient: ",
                Mention("friction", f"friction={number / 100.0:g}", f"{number / 100.0:g}"),
                SILENCE,
            ),
            PlausibilityWarning,
            stacklevel=level_of_caller(),
        )
