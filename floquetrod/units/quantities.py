"""Numbers with a unit, as texts, as quantities of pint or alone, in SI units."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from decimal import Decimal
from typing import TYPE_CHECKING, Any

from floquetrod._util.arguments import wrong_value
from floquetrod._util.measured import is_measured, magnitude, mapped
from floquetrod._util.suggest import short
from floquetrod.units.table import UNITS, hint, meant, units_of

if TYPE_CHECKING:
    from floquetrod._util.arrays import Floats

_NUMBER = re.compile(
    r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S*(?:\s*/\s*(?:\d+\s*)?[a-zA-Z]+\d?)?)\s*", re.ASCII
)
_FRACTION = re.compile(r"\s*([-+]?)(?:(\d{1,9})(?:\s*-\s*|\s+))?(\d{1,9})/([1-9]\d{0,8})\s*([^\s\d/]*)\s*", re.ASCII)
_FRACTIONS_OF = ("in", "ft")
_ONE_CRITICAL_FORCE = "Fcr"  # stands alone, too, where every other unit has a number before it
_FEET_AND_INCHES = re.compile(
    r"\s*([-+]?)(\d{1,9})\s*(ft|feet|foot|')\s*-?\s*(\d{1,2}(?:\.\d*)?)\s*(in|inch|inches|\")\s*", re.ASCII
)


def si(values: Any, name: str, kind: str) -> Any:
    """Return values in SI units, converting text with a unit, quantities of pint, and sequences and arrays of them.

    Numbers alone count as SI and are returned unchanged.
    """
    return mapped(name, values, is_written, lambda at, value: _one_in_si(value, at, kind))


def _one_in_si(value: Any, name: str, kind: str) -> Any:
    return in_si(value, name, kind) if is_measured(value) else quantity(value, name, kind)


def single(value: Any, name: str, kind: str) -> Any:
    """Return one value in SI units, converting text with a unit or a quantity of pint; others are unchanged."""
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
        A number with a unit, whose case matters only between M for mega and m for milli; a number alone is in the SI
        unit of its kind.  Inches and feet may be fractions, "3/4in", "2-3/8in", "2 3/8in", or both, "9500ft 6in".  A
        percentage is of ``nominal`` if given, else of the critical force for kind "force", and of 1 for kind "ratio".
    name : str
        Its name in messages.
    kind : str
        "force", "frequency" (angular, in rad/s), "length", "mass", "stiffness", "pressure", "density", "weight" (per
        length), "acceleration", "rate", "speed", "time", "angle", "curvature", "force density" (one-sided spectral
        density) or "ratio" (which has no unit).
    critical_force : float, optional
        Critical force in N; with it, forces may be given in "Fcr".
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
        For anything else, naming the accepted forms.

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
        share = float(Decimal(repr(number)).scaleb(-2))  # rounded once: 26.9% is 0.269, where 26.9 / 100 is not
        return _bounded(share * whole, name, units, least, largest, given)
    unit = meant(unit_name or next(iter(units)), units)
    if unit is None:
        raise wrong_value(
            name,
            f"{_wanted(kind, units)}, got {given}: unit {short(unit_name)} is not understood{hint(unit_name, units)}",
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
    target = re.sub(r"(?<=[a-z])(\d)$", r"^\1", next(iter(UNITS[kind]))) or "dimensionless"
    try:
        if counts and re.search("hertz|count", str(getattr(value, "units", ""))):
            target = "hertz" if kind == "frequency" else "of a rate, not of a frequency"
        return magnitude(value, target) * (2.0 * math.pi if target == "hertz" else 1.0)
    except Exception as error:  # pint has its own for each way in which units differ
        raise wrong_value(name, f"{_wanted(kind, UNITS[kind])}, got {short(value)}: {error}") from None


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


def _bounded(value: float, name: str, units: dict[str, float], least: float, largest: float, given: str) -> float:
    """Return ``value`` where it is finite and lies within bounds."""
    if not math.isfinite(value):
        raise wrong_value(name, f"must be finite, got {given}")
    if value <= 0.0 < least:
        raise wrong_value(name, f"must be greater than zero, got {given}")
    if value < 0.0 == least:
        raise wrong_value(name, f"must be zero or more, got {given}")
    if not least <= value <= largest:
        unit = next(iter(units))
        within = " ".join(filter(None, [f"must lie between {least:g} and {largest:g}", unit]))
        in_percent = 2.0 <= value <= 100.0 and "%" not in given and least <= value / 100.0 <= largest
        percent = f'; write "{value:g}%" for percent' if in_percent else ""
        raise wrong_value(name, f"{within}, got {given}{'; check its unit' if unit else percent}")
    return value


def unit_of(text: str) -> str | None:
    """Return the unit of a quantity as typed, "" without a unit, None for text that is no quantity.

    >>> unit_of("24Hz"), unit_of("150"), unit_of("fast")
    ('Hz', '', None)
    """
    written = _written(text)
    return None if written is None else written[1]


def same_unit(*texts: str) -> list[str]:
    """Return quantities as typed, with the unit of the last appended to numbers without a unit.

    >>> same_unit("10", "2kHz", "60Hz")
    ['10Hz', '2kHz', '60Hz']
    """
    last = unit_of(texts[-1]) or ""
    return [text if unit_of(text) != "" else f"{text}{last}" for text in texts]


def _written(text: str) -> tuple[float, str] | None:
    """Return the number and the unit of a quantity as typed, None for text that is no quantity.

    >>> _written("24Hz"), _written("2-3/8in"), _written('2 3/8"'), _written("3 deg / 30 m"), _written("fast")
    ((24.0, 'Hz'), (2.375, 'in'), (2.375, '"'), (3.0, 'deg/30m'), None)
    >>> _written("9500ft 6in"), _written("Fcr")
    ((9500.5, 'ft'), (1.0, 'Fcr'))
    """
    if text.strip().lower() == _ONE_CRITICAL_FORCE.lower():
        return 1.0, _ONE_CRITICAL_FORCE
    both = _FEET_AND_INCHES.fullmatch(text)
    if both is not None and float(both[4]) < 12.0:
        size = int(both[2]) + float(both[4]) / 12.0
        return (-size if both[1] == "-" else size), "ft"
    fraction = _FRACTION.fullmatch(text)
    if fraction is not None and meant(fraction[5], _FRACTIONS_OF):
        size = int(fraction[2] or 0) + int(fraction[3]) / int(fraction[4])
        return (-size if fraction[1] == "-" else size), fraction[5]
    match = _NUMBER.fullmatch(text)
    return (float(match[1]), re.sub(r"\s", "", match[2])) if match else None
