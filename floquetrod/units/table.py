"""The units of each kind of quantity: their names, as people write them, and their size in the SI unit."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Iterable
from typing import Any, NamedTuple

from floquetrod._util.arguments import wrong_type, wrong_value
from floquetrod._util.suggest import did_you_mean, short

_GRAVITY = 9.80665  # standard acceleration of gravity in m/s^2, ISO 80000-3: in units of force, and gradients of muds
_FOOT = 0.3048  # m
_POUND = 0.45359237  # of mass, in kg
_POUND_FORCE = 4.4482216152605  # N: a pound times the standard acceleration of gravity
_POUNDS_PER_GALLON = _POUND / 3.785411784e-3  # of US gallons, in kg/m^3
_PSI = 6894.757293168  # Pa: a pound-force over a square inch

UNITS: dict[str, dict[str, float]] = {
    "force": {
        "N": 1.0,
        "kN": 1e3,
        "MN": 1e6,
        "mN": 1e-3,
        "daN": 10.0,
        "lbf": _POUND_FORCE,
        "klbf": 1e3 * _POUND_FORCE,
        "kip": 1e3 * _POUND_FORCE,
        "kgf": _GRAVITY,
        "tf": 1e3 * _GRAVITY,
    },
    "force density": {"N^2/Hz": 1.0, "N2/Hz": 1.0, "kN^2/Hz": 1e6, "mN^2/Hz": 1e-6, "lbf^2/Hz": _POUND_FORCE**2},
    "frequency": {
        "rad/s": 1.0,
        "1/s": 1.0,
        "Hz": 2.0 * math.pi,
        "kHz": 2e3 * math.pi,
        "MHz": 2e6 * math.pi,
        "GHz": 2e9 * math.pi,
        "rpm": math.pi / 30.0,
    },
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0},
    "length": {
        "m": 1.0,
        "mm": 1e-3,
        "cm": 1e-2,
        "um": 1e-6,
        "km": 1e3,
        "in": 0.0254,
        "ft": _FOOT,
        "ftUS": 1200.0 / 3937.0,  # the foot of surveys in the United States
    },
    "mass": {"kg": 1.0, "g": 1e-3, "mg": 1e-6, "lb": _POUND},
    "stiffness": {"N/m": 1.0, "N/mm": 1e3, "kN/m": 1e3, "N/um": 1e6, "MN/m": 1e6, "lbf/in": _POUND_FORCE / 0.0254},
    "pressure": {
        "Pa": 1.0,
        "kPa": 1e3,
        "MPa": 1e6,
        "GPa": 1e9,
        "bar": 1e5,
        "psi": _PSI,
        "ksi": 6894757.293168,
        "Mpsi": 6894757293.168,
        "Msi": 6894757293.168,  # a million psi, as data sheets write
    },
    "density": {
        "kg/m3": 1.0,
        "kg/m^3": 1.0,
        "g/cm3": 1e3,
        "g/cm^3": 1e3,
        "g/cc": 1e3,
        "kg/l": 1e3,
        "sg": 1e3,  # specific gravity: over that of water at 4 degrees Celsius, to 3e-5
        "lb/gal": _POUNDS_PER_GALLON,
        "ppg": _POUNDS_PER_GALLON,
        "lb/ft3": _POUND / _FOOT**3,
        "pcf": _POUND / _FOOT**3,
        "lb/in3": _POUND / 0.0254**3,
        "psi/ft": _PSI / (_FOOT * _GRAVITY),  # of a mud: the gradient of its pressure
        "kPa/m": 1e3 / _GRAVITY,
        "bar/m": 1e5 / _GRAVITY,
    },
    "weight": {
        "N/m": 1.0,
        "kN/m": 1e3,
        "daN/m": 10.0,
        "kg/m": _GRAVITY,
        "kgf/m": _GRAVITY,
        "lb/ft": _POUND_FORCE / _FOOT,
        "lbf/ft": _POUND_FORCE / _FOOT,
        "ppf": _POUND_FORCE / _FOOT,
    },
    "acceleration": {"m/s2": 1.0, "m/s^2": 1.0, "ft/s2": _FOOT},
    "rate": {"1/s": 1.0, "/s": 1.0},
    "speed": {
        "m/s": 1.0,
        "cm/s": 1e-2,
        "mm/s": 1e-3,
        "ft/s": _FOOT,
        "in/s": 0.0254,
        "m/min": 1.0 / 60.0,
        "ft/min": _FOOT / 60.0,
        "m/h": 1.0 / 3600.0,
        "ft/h": _FOOT / 3600.0,
    },
    "angle": {"rad": 1.0, "deg": math.pi / 180.0},
    "curvature": {
        "1/m": 1.0,
        "rad/m": 1.0,
        "deg/m": math.pi / 180.0,
        "deg/10m": math.pi / 1800.0,
        "deg/30m": math.pi / 5400.0,
        "deg/100m": math.pi / 18000.0,
        "deg/100ft": math.pi / (180.0 * 30.48),
    },
    "ratio": {"": 1.0},
}
"""Kinds of quantity: units and their size in the SI unit, which comes first."""

_ALSO = {
    "lb": "lbf",
    "lbs": "lbf",
    "kips": "kip",
    "klb": "klbf",
    "klbs": "klbf",
    "kp": "kgf",
    "hertz": "Hz",
    "rad/sec": "rad/s",
    "rev/min": "rpm",
    "sec": "s",
    "hr": "h",
    "hour": "h",
    "hours": "h",
    "metre": "m",
    "metres": "m",
    "meter": "m",
    "meters": "m",
    "inch": "in",
    "inches": "in",
    '"': "in",
    "foot": "ft",
    "feet": "ft",
    "usft": "ftUS",
    "us ft": "ftUS",
    "us survey ft": "ftUS",
    "n/mm2": "MPa",
    "n/mm^2": "MPa",
    "s.g.": "sg",
    "lbm/gal": "lb/gal",
    "lbs/gal": "lb/gal",
    "lbm/ft3": "lb/ft3",
    "lbs/ft": "lb/ft",
    "#/ft": "lb/ft",
    "fpm": "ft/min",
    "m/hr": "m/h",
    "ft/hr": "ft/h",
    "degree": "deg",
    "degrees": "deg",
}
"""Further names of units, in small letters, and the unit that each stands for."""

_CYCLES = ("Hz", "rpm")
"""Units of frequency that count periods rather than radians."""


class Unit(NamedTuple):
    """A unit to show values in: its name, and how much it is in the SI unit.

    >>> hertz = unit("Hz", "--unit", "frequency")
    >>> hertz.show(150.0)
    '23.8732 Hz'
    """

    name: str
    size: float

    def of(self, value: Any) -> Any:
        """Return an SI value, or an array of them, in this unit."""
        return value if self.size == 1.0 else value / self.size

    def si(self, value: Any) -> Any:
        """Return a value in this unit in SI."""
        return value * self.size

    def show(self, value: float, digits: int = 6) -> str:
        """Return an SI value as text in this unit, without a power of ten up to a billion."""
        text = f"{self.of(value):.{digits}g}"
        if "e+0" in text:
            text = f"{float(text):.0f}"
        return f"{text} {self.name}".strip()

    def per(self, other: Unit) -> Unit:
        """Return this unit over another one.

        >>> unit("lbf", "", "force").per(unit("ft", "", "length")).name
        'lbf/ft'
        """
        return Unit(f"{self.name}/{other.name}", self.size / other.size)


_BRACKETS = re.compile(r"(.*?)\s*(?:[\[(]\s*([^\[\]()]*?)\s*[\])]|/\s*(\S+))")
_LAST_WORD = re.compile(r"(.*[^\s_])[\s_]+([^\s_]+)")


_DEGREE_SIGNS = "\N{DEGREE SIGN}\N{MASCULINE ORDINAL INDICATOR}\N{RING ABOVE}"
_IN_ASCII = {ord("\N{GREEK SMALL LETTER MU}"): "u", **{ord(sign): "deg" for sign in _DEGREE_SIGNS}}
_FROM_A_DATUM = re.compile(
    r"(m|met(?:er|re)s?|ft|foot|feet|usft|ftus)[\s_.-]*(?:md[\s_.-]*)?(?:b?(?:rkb|kb|rt|df|gl))?", re.ASCII
)
"""A unit of length with what it is measured along or from: "m RKB", "mMD", "ft MD RKB"."""


def meant(name: str, units: Iterable[str]) -> str | None:
    """Return the unit that a name means, None for none; case matters only between M for mega and m for milli.

    Without regard to case no two units of a kind are alike, which the tests check.  A pound is one of force where a
    force is asked for, and lengths may name their datum.

    >>> meant("KN", units_of("force")), meant("lbs", units_of("force")), meant("m RKB", units_of("length"))
    ('kN', 'lbf', 'm')
    """
    names = {_folded(unit): unit for unit in units}
    written = _folded(name)
    datum = _FROM_A_DATUM.fullmatch(written.lower())
    for word in (written, datum[1] if datum else written):
        known = names.get(word, names.get(_folded(_ALSO.get(word.lower(), word))))
        if known is not None:
            return known
    return None


def _folded(name: str) -> str:
    """Return a unit in small letters, except M and m before a letter; mu as u, raised digits as digits, ° as deg."""
    if not name.isascii():
        name = unicodedata.normalize("NFKC", name.translate(_IN_ASCII)).translate(_IN_ASCII)
    return name[:1] + name[1:].lower() if name[:1] in ("m", "M") and name[1:2].isalpha() else name.lower()


def hint(name: str, units: Iterable[str]) -> str:
    """Return what may be meant by a unit that is not one of ``units``."""
    if re.match(r"-?\d*/\d", name, re.ASCII):
        return "; fractions are those of inches and feet, such as 3/4in, 2-3/8in or 2 3/8in; else write decimals"
    if name == "%" and "/s" in units:
        return "; a ratio of critical damping is a rate only times the angular frequency of its mode, 1 % at 8 Hz 0.5/s"
    if name == "%":
        return "; a percentage needs something it is a part of, such as the critical force of a rod"
    other = kind_of(name)
    names = [*filter(None, units), *(also for also, unit in _ALSO.items() if unit in units)]
    return f"; it is a unit of {other}" if other else did_you_mean(name, names)


def units_of(kind: str, critical_force: float | None = None) -> dict[str, float]:
    """Return the units of a kind of quantity and their size in the SI unit, which comes first."""
    units = dict(UNITS[kind])
    if kind == "force" and critical_force is not None:
        units["Fcr"] = critical_force
    return units


def unit(name: str, what: str, kind: str, critical_force: float | None = None) -> Unit:
    """Return a unit by its name, "" for the SI unit; ValueError, which begins with ``what``, for an unknown one."""
    if not isinstance(name, str):
        raise wrong_type(what, f"must be the name of a unit of {kind}, got {short(name)}")
    units = units_of(kind, critical_force)
    if name == "%":  # of what is known, which says in which unit to show it
        name = "Fcr" if "Fcr" in units else ""
    chosen = meant(name or next(iter(units)), units)
    if chosen is None:
        raise wrong_value(what, f"must be a unit of {kind} ({', '.join(units)}), got {short(name)}{hint(name, units)}")
    return Unit(chosen, units[chosen])


def is_unit(word: str, kind: str) -> bool:
    """Return whether a word is a unit of a kind of quantity, in any case; percent are of nothing known here."""
    return bool(word) and meant(word, UNITS[kind]) is not None


def heading(text: str, kind: str) -> tuple[str, str | None]:
    """Return the name and the unit of a column's heading, None without one; a last or only word counts if it is a unit.

    >>> heading("F [kN]", "force"), heading("time_ms", "time"), heading("lbf", "force"), heading("push", "force")
    (('F', 'kN'), ('time', 'ms'), ('', 'lbf'), ('push', None))
    """
    if is_unit(text, kind):
        return "", text
    if match := _BRACKETS.fullmatch(text):
        return match[1], match[2] or match[3] or ""
    match = _LAST_WORD.fullmatch(text)
    if match and is_unit(match[2], kind):
        return match[1], match[2]
    return text, None


def kind_of(name: str) -> str | None:
    """Return the kind of quantity that a unit measures, the first where several do; None for an unknown one.

    >>> kind_of("rpm"), kind_of("Fcr"), kind_of("parsec")
    ('frequency', 'force', None)
    """
    return next((kind for kind in UNITS if name and meant(name, units_of(kind, 1.0))), None)


def label(name: str, symbol: str, unit_name: str) -> str:
    r"""Return the label of an axis: name, symbol and unit in mathematics.

    >>> print(label("frequency", r"\omega", "Hz"))
    frequency $\omega/2\pi$ / Hz
    """
    written = r"$F_\mathrm{cr}$" if unit_name == "Fcr" else f"({unit_name})" if "/" in unit_name else unit_name
    turns = r"/2\pi" if unit_name in _CYCLES else ""
    return f"{name} ${symbol}{turns}$".strip() + (f" / {written}" if unit_name else "")


def with_unit(value: float, unit_name: str, digits: int = 6) -> str:
    """Return a value with its unit as captions and titles show it: newtons with the prefix that suits their size.

    >>> with_unit(62841.7, "N", 3), with_unit(0.3392, "N", 3), with_unit(0.00411, "N", 3), with_unit(1234.5, "rad/s", 3)
    ('62.8 kN', '0.339 N', '4.11 mN', '1230 rad/s')
    """
    if unit_name == "N" and value:
        size = abs(value)
        unit_name = "MN" if size >= 1e6 else "kN" if size >= 1e3 else "mN" if size < 0.01 else "N"
        value /= UNITS["force"][unit_name]
    return f"{float(f'{value:.{digits}g}'):g} {unit_name}".strip()
