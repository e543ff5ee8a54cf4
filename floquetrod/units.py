"""Quantities as people write them: "0.2Fcr", "24Hz", "0.8mm", "68GPa", "2.375in", "60deg"."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

from floquetrod._util.arguments import wrong_type, wrong_value
from floquetrod._util.measured import is_measured, magnitude, mapped
from floquetrod._util.suggest import did_you_mean, short

if TYPE_CHECKING:
    from floquetrod._util.arrays import Floats

_POUND = 0.45359237  # of mass, in kg
_POUNDS_PER_GALLON = _POUND / 3.785411784e-3  # of US gallons, in kg/m^3

_POUND_FORCE = 4.4482216152605  # in N

_UNITS: dict[str, dict[str, float]] = {
    "force": {"N": 1.0, "kN": 1e3, "MN": 1e6, "mN": 1e-3, "lbf": _POUND_FORCE, "kip": 1e3 * _POUND_FORCE},
    "force density": {"N^2/Hz": 1.0, "N2/Hz": 1.0, "kN^2/Hz": 1e6, "mN^2/Hz": 1e-6, "lbf^2/Hz": _POUND_FORCE**2},
    "frequency": {"rad/s": 1.0, "1/s": 1.0, "Hz": 2.0 * math.pi, "kHz": 2e3 * math.pi, "rpm": math.pi / 30.0},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0},
    "length": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "km": 1e3, "in": 0.0254, "ft": 0.3048},
    "mass": {"kg": 1.0, "g": 1e-3, "mg": 1e-6},
    "stiffness": {"N/m": 1.0, "N/mm": 1e3, "kN/m": 1e3, "N/um": 1e6, "MN/m": 1e6},
    "pressure": {
        "Pa": 1.0,
        "kPa": 1e3,
        "MPa": 1e6,
        "GPa": 1e9,
        "psi": 6894.757293168,
        "ksi": 6894757.293168,
        "Mpsi": 6894757293.168,
    },
    "density": {
        "kg/m3": 1.0,
        "kg/m^3": 1.0,
        "g/cm3": 1e3,
        "g/cm^3": 1e3,
        "lb/gal": _POUNDS_PER_GALLON,
        "ppg": _POUNDS_PER_GALLON,
        "lb/ft3": _POUND / 0.3048**3,
        "lb/in3": _POUND / 0.0254**3,
    },
    "acceleration": {"m/s2": 1.0, "m/s^2": 1.0, "ft/s2": 0.3048},
    "rate": {"1/s": 1.0, "/s": 1.0},
    "speed": {
        "m/s": 1.0,
        "cm/s": 1e-2,
        "mm/s": 1e-3,
        "ft/s": 0.3048,
        "m/min": 1.0 / 60.0,
        "ft/min": 0.3048 / 60.0,
        "m/h": 1.0 / 3600.0,
        "ft/h": 0.3048 / 3600.0,
    },
    "angle": {"rad": 1.0, "deg": math.pi / 180.0},
    "curvature": {
        "1/m": 1.0,
        "rad/m": 1.0,
        "deg/m": math.pi / 180.0,
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
    "hertz": "Hz",
    "rad/sec": "rad/s",
    "sec": "s",
    "inch": "in",
    "inches": "in",
    '"': "in",
    "feet": "ft",
    "n/mm2": "MPa",
    "n/mm^2": "MPa",
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


class AnswerUnits(NamedTuple):
    """The units that an answer is in, and those that follow from them.

    >>> shown = AnswerUnits.named(force="lbf")
    >>> shown.pressure.name, shown.per_length.name, shown.across.name, shown.speed.name
    ('ksi', 'lbf/ft', 'in', 'ft/s')
    """

    force: Unit
    length: Unit
    pressure: Unit
    frequency: Unit

    @classmethod
    def named(
        cls,
        force: str = "N",
        length: str | None = None,
        pressure: str | None = None,
        frequency: str = "Hz",
        what: Callable[[str], str] = str,
    ) -> AnswerUnits:
        """Return units by their names; beside pounds ft and ksi are usual, else m and MPa.

        ``what`` names them in messages.
        """
        of_force = unit(force, what("force"), "force")
        usual = ("ft", "ksi") if of_force.name in ("lbf", "kip") else ("m", "MPa")
        return cls(
            of_force,
            unit(usual[0] if length is None else length, what("length"), "length"),
            unit(usual[1] if pressure is None else pressure, what("pressure"), "pressure"),
            unit(frequency, what("frequency"), "frequency"),
        )

    @property
    def per_length(self) -> Unit:
        """Of forces per length."""
        return self.force.per(self.length)

    @property
    def across(self) -> Unit:
        """Of diameters."""
        return unit("in" if self._has_feet else "mm", "", "length")

    @property
    def speed(self) -> Unit:
        """Of speeds."""
        return unit("ft/s" if self._has_feet else "m/s", "", "speed")

    @property
    def mass_per_length(self) -> Unit:
        """Of masses per length."""
        return Unit("lb/ft", _POUND / _UNITS["length"]["ft"]) if self._has_feet else Unit("kg/m", 1.0)

    @property
    def rigidity(self) -> Unit:
        """Of flexural rigidities."""
        return Unit(f"{self.force.name} {self.length.name}^2", self.force.size * self.length.size**2)

    @property
    def _has_feet(self) -> bool:
        return self.length.name in ("ft", "in")

    def unit_for(self, kind: str, value: float, in_feet: str = "") -> Unit:
        """Return the unit in which to show a value of some kind, beside feet ``in_feet`` or the usual one.

        >>> AnswerUnits.named(force="lbf").unit_for("density", 1e3, "ppg").name
        'ppg'
        """
        if kind == "pressure" and value >= 1e9:
            return unit({"ksi": "Mpsi", "psi": "Mpsi"}.get(self.pressure.name, "GPa"), "", kind)
        if kind in ("length", "pressure"):
            return self.length if kind == "length" else self.pressure
        usual = in_feet or _IN_FEET.get(kind, "") if self._has_feet else ""
        return unit("deg" if kind == "angle" else usual, "", kind)


_IN_FEET = {"density": "lb/ft3", "acceleration": "ft/s2", "curvature": "deg/100ft"}
"""Units in which answers beside feet are shown."""

_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S*(?:\s*/\s*\d+\s*[a-zA-Z]+)?)\s*", re.ASCII)
_FRACTION = re.compile(r"\s*([-+]?)(?:(\d{1,9})(?:\s*-\s*|\s+))?(\d{1,9})/([1-9]\d{0,8})\s*([^\s\d/]*)\s*", re.ASCII)
_FRACTIONS_OF = ("in", "ft")

_BRACKETS = re.compile(r"(.*?)\s*(?:[\[(]\s*([^\[\]()]*?)\s*[\])]|/\s*(\S+))")
_LAST_WORD = re.compile(r"(.*[^\s_])[\s_]+([^\s_]+)")


def _known(name: str, units: Iterable[str]) -> str | None:
    """Return which of the units a name means, in any case but that of M for mega and m for milli; None for none.

    Without regard to case no two units of a kind are alike, which the tests check.  A pound is one of force where a
    force is asked for.
    """
    names = {_folded(unit): unit for unit in units}
    written = _folded(name)
    return names.get(written) or names.get(_folded(_ALSO.get(written, written)))


_IN_ASCII = {ord("\N{GREEK SMALL LETTER MU}"): "u", ord("\N{DEGREE SIGN}"): "deg"}


def _folded(name: str) -> str:
    """Return a unit in small letters, except M and m at its beginning; mu as u, raised digits as digits, ° as deg."""
    if not name.isascii():
        name = unicodedata.normalize("NFKC", name).translate(_IN_ASCII)
    return name[:1] + name[1:].lower() if name[:1] in ("m", "M") else name.lower()


def units_of(kind: str, critical_force: float | None = None) -> dict[str, float]:
    """Return the units of a kind of quantity and their size in the SI unit, which comes first."""
    units = dict(_UNITS[kind])
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
    chosen = _known(name or next(iter(units)), units)
    if chosen is None:
        raise wrong_value(what, f"must be a unit of {kind} ({', '.join(units)}), got {short(name)}{_hint(name, units)}")
    return Unit(chosen, units[chosen])


def is_unit(word: str, kind: str) -> bool:
    """Return whether a word is a unit of a kind of quantity, in any case; percent are of nothing known here."""
    return bool(word) and _known(word, _UNITS[kind]) is not None


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
    return next((kind for kind in _UNITS if name and _known(name, units_of(kind, 1.0))), None)


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
        value /= _UNITS["force"][unit_name]
    return f"{float(f'{value:.{digits}g}'):g} {unit_name}".strip()


def si(values: Any, name: str, kind: str) -> Any:
    """Return what has its unit with it in SI units: a text, a quantity of pint, sequences and arrays of them.

    Everything else is in SI units and stays as it is.
    """
    return mapped(name, values, is_written, lambda at, value: _one_in_si(value, at, kind))


def _one_in_si(value: Any, name: str, kind: str) -> Any:
    return in_si(value, name, kind) if is_measured(value) else quantity(value, name, kind)


def single(value: Any, name: str, kind: str) -> Any:
    """Return one value that has its unit with it in SI units; everything else stays as it is."""
    return quantity(value, name, kind) if is_written(value) else value


def number(
    name: str, value: Any, kind: str, least: float = -math.inf, largest: float = math.inf, hint: str = ""
) -> float:
    """Return a physical argument in SI units, from ``least`` to ``largest``: the one entrance of single numbers.

    A number alone is in the SI unit of its kind; others are texts such as "0.8mm" and quantities of pint.  Raises
    ValueError and TypeError that begin with the argument's name, as `floquetrod._util.validate.within` does.
    """
    from floquetrod._util import validate  # which needs numpy: texts alone do not

    return validate.within(name, single(value, name, kind), least, largest, hint)


def tolerance(name: str, value: Any) -> float:
    """Return a growth rate in 1/s up to which a motion counts as stable, as `floquetrod._util.validate.tolerance`."""
    from floquetrod._util import validate

    return validate.tolerance(name, single(value, name, "rate"))


def array(name: str, values: Any, kind: str, least: float, largest: float) -> Floats:
    """Return a physical argument as an array in SI units, from ``least`` to ``largest``: the one entrance of arrays.

    Numbers alone are in the SI unit of their kind; others are texts, quantities of pint, also of arrays, and sequences
    of them.  Raises as `floquetrod._util.validate.array` does.
    """
    from floquetrod._util import validate

    return validate.array(name, si(values, name, kind), least=least, largest=largest)


def quantity(
    value: Any,
    name: str,
    kind: str,
    *,
    critical_force: float | None = None,
    nominal: float | None = None,
    least: float = -math.inf,
    largest: float = math.inf,
    given: str | None = None,
) -> float:
    """Return a quantity in SI units.

    Parameters
    ----------
    value : str, number or quantity of pint
        A number with a unit, in any case but that of M for mega and m for milli; a number alone is in the SI unit of
        its kind.  Inches and feet may be fractions: "3/4in", "2-3/8in", "2 3/8in".  A percentage is one of ``nominal``
        where that is given, else of the critical force where a force is asked for, and of one where a ratio is.
    name : str
        Its name in messages.
    kind : str
        "force", "frequency" (angular, in rad/s), "length", "mass", "stiffness", "pressure", "density", "acceleration",
        "rate", "speed", "time", "angle", "force density" (one-sided spectral density) or "ratio" (which has no unit).
    critical_force : float, optional
        In N; with it, forces may be given in "Fcr".
    nominal : float, optional
        In the SI unit; with it, the quantity may be given in percent of it.
    least : float
        Least value in SI units.
    largest : float
        Largest value in SI units.
    given : str, optional
        Text quoted in messages in place of ``value``.

    Raises
    ------
    ValueError
        For anything else, naming what is accepted.

    Examples
    --------
    >>> quantity("0.8mm", "radius", "length")
    0.0008
    >>> quantity("0.5Fcr", "mean", "force", critical_force=1.7)
    0.85
    >>> quantity("50%", "mean", "force", critical_force=1.7), quantity("30%", "friction", "ratio")
    (0.85, 0.3)
    """
    units = units_of(kind, critical_force)
    if is_measured(value):
        converted = in_si(value, name, kind)
        if getattr(converted, "ndim", 0):
            raise wrong_value(name, f"{_wanted(kind, units)}, got several: {short(value)}")
        return _bounded(converted, name, units, least, largest, short(value))
    if isinstance(value, int | float) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:  # an integer of more than 308 digits, which a rod file may hold
            raise wrong_value(name, "must be finite, got an integer beyond 1e308") from None
        return _bounded(number, name, units, least, largest, repr(value) if given is None else given)
    given = short(value) if given is None else given
    if kind == "force" and critical_force is None and isinstance(value, str) and value.strip().lower().endswith("fcr"):
        raise wrong_value(
            name,
            f"must have a unit of force such as N or kN, got {given}: here no rod is known; give {name} as a number "
            "times rod.critical_force",
        )
    written = _written(value) if isinstance(value, str) else None
    if written is None or "," in written[1] or ":" in written[1]:
        raise wrong_value(name, f"{_wanted(kind, units)}, got {given}: {_why_no_number(value)}")
    number, unit_name = written
    whole = {"force": critical_force, "ratio": 1.0}.get(kind) if nominal is None else nominal
    if unit_name == "%" and whole == 0.0:
        raise wrong_value(name, f"must not be a percentage of zero, got {given}; give a number with its unit")
    if unit_name == "%" and whole is not None:
        return _bounded(number * whole / 100.0, name, units, least, largest, given)
    unit = _known(unit_name or next(iter(units)), units)
    if unit is None:
        raise wrong_value(
            name,
            f"{_wanted(kind, units)}, got {given}: unit {short(unit_name)} is not understood{_hint(unit_name, units)}",
        )
    return _bounded(number * units[unit], name, units, least, largest, given)


def is_written(value: Any) -> bool:
    """Return whether a value has its unit with it, as a text or as a quantity of pint."""
    return isinstance(value, str) or is_measured(value)


def in_si(value: Any, name: str, kind: str) -> Any:
    """Return a quantity of pint in the SI unit of a kind, a float or an array.

    To pint a hertz is 1/s and an angle has no dimension: what counts periods is given by the name of its unit.
    """
    counts = kind in ("frequency", "rate")
    target = re.sub(r"(?<=[a-z])(\d)$", r"^\1", next(iter(_UNITS[kind]))) or "dimensionless"
    try:
        if counts and re.search("hertz|count", str(getattr(value, "units", ""))):
            target = "hertz" if kind == "frequency" else "of a rate, not of a frequency"
        return magnitude(value, target) * (2.0 * math.pi if target == "hertz" else 1.0)
    except Exception as error:  # pint has its own for each way in which units differ
        raise wrong_value(name, f"{_wanted(kind, _UNITS[kind])}, got {short(value)}: {error}") from None


def _wanted(kind: str, units: Iterable[str]) -> str:
    accepted = f"a {kind} unit ({', '.join(units)}; none means {next(iter(units))})" if any(units) else "no unit"
    return f"must be a number with {accepted}"


def _why_no_number(value: Any) -> str:
    """Return why a text is no number with a unit."""
    if isinstance(value, str) and "," in value:
        return "a comma is not understood; write a point before decimals and nothing between thousands"
    if isinstance(value, str) and ":" in value:
        return "a range where one value is needed"
    return "this is not understood"


def _hint(name: str, units: Iterable[str]) -> str:
    """Return what may be meant by a unit that is not one of ``units``."""
    if re.match(r"-?\d*/\d", name, re.ASCII):
        return "; fractions are those of inches and feet, such as 3/4in, 2-3/8in or 2 3/8in; else write decimals"
    if name == "%":
        return "; a percentage needs something it is a part of, such as the critical force of a rod"
    other = kind_of(name)
    names = [*filter(None, units), *(also for also, unit in _ALSO.items() if unit in units)]
    return f"; it is a unit of {other}" if other else did_you_mean(name, names)


def _bounded(value: float, name: str, units: dict[str, float], least: float, largest: float, given: str) -> float:
    """Return ``value`` where it is finite and lies within bounds."""
    if not math.isfinite(value):
        raise wrong_value(name, f"must be finite, got {given}")
    if value <= 0.0 < least:
        raise wrong_value(name, f"must be greater than zero, got {given}")
    if value < 0.0 == least:
        raise wrong_value(name, f"must be zero or more, got {given}")
    if not least <= value <= largest:
        raise wrong_value(
            name, f"must lie between {least:g} and {largest:g} {next(iter(units))}, got {given}; check its unit"
        )
    return value


def unit_of(text: str) -> str | None:
    """Return the unit of a quantity as it is written, "" where it has none; None where it is no quantity.

    >>> unit_of("24Hz"), unit_of("150"), unit_of("fast")
    ('Hz', '', None)
    """
    written = _written(text)
    return None if written is None else written[1]


def same_unit(*texts: str) -> list[str]:
    """Return quantities as they are written, those without a unit with that of the last.

    >>> same_unit("10", "2kHz", "60Hz")
    ['10Hz', '2kHz', '60Hz']
    """
    last = unit_of(texts[-1]) or ""
    return [text if unit_of(text) != "" else f"{text}{last}" for text in texts]


def _written(text: str) -> tuple[float, str] | None:
    """Return the number and the unit of a quantity as it is written, None where it is none.

    >>> _written("24Hz"), _written("2-3/8in"), _written('2 3/8"'), _written("3 deg / 30 m"), _written("fast")
    ((24.0, 'Hz'), (2.375, 'in'), (2.375, '"'), (3.0, 'deg/30m'), None)
    """
    fraction = _FRACTION.fullmatch(text)
    if fraction is not None and _known(fraction[5], _FRACTIONS_OF):
        size = int(fraction[2] or 0) + int(fraction[3]) / int(fraction[4])
        return (-size if fraction[1] == "-" else size), fraction[5]
    match = _NUMBER.fullmatch(text)
    return (float(match[1]), re.sub(r"\s", "", match[2])) if match else None
