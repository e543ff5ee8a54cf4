"""An answer has the units of its question: one rule for the terminal, reports, figures and tables.

Kind by kind of quantity the unit is the first of these:

1. the one that was asked for, ``--unit ft,lbf`` or ``report(force="kN")``;
2. the one in which the question gave such a quantity: in the arguments of the call, then in the load, the measured
   force or the tool, the survey, the rod.  A number alone, a percentage and a critical force give none;
3. the one usual beside the lengths of the answer: beside feet and inches pounds-force, ksi, ft/min, ppg and deg/100ft.
   Where no length was given, pounds-force count as feet.

A question in feet of surveys in the United States is answered in feet, which differ by 2 parts in a million, less than
the digits of an answer; messages about a survey are in the feet of its file.

What holds a question's quantities remembers their units, `InUnits.given_units`; a result joins these, and its report
and its figure ask `AnswerUnits.named`:

>>> from floquetrod.wells.path import WellPath
>>> path, push = WellPath(["0ft", "3000ft"], 0.5), 20e3
>>> given = GivenUnits.of(force=push, speed="40ft/min").or_else(path.given_units)
>>> shown = AnswerUnits.named(given=given)
>>> shown.length.show(914.4), shown.force.show(push, 4), shown.speed.show(0.2032)
('3000 ft', '4496 lbf', '40 ft/min')
>>> AnswerUnits.named(force="kN", given=given).force.show(push)
'20 kN'
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple, Self

from floquetrod._util.measured import is_measured
from floquetrod.units.quantities import unit_of
from floquetrod.units.table import UNITS, Unit, meant, unit

_FEW = 100  # elements of a list that are read for a unit (a choice)
_PER_LENGTH = {"kN": "N", "MN": "N", "klbf": "lbf", "tf": "kgf"}
_DEEPEST = 2  # lists in lists that are read: pairs of a depth and a number
_KINDS = {"across": "length"}
"""Kinds of quantity of the fields of `GivenUnits` that are not named after theirs."""


class GivenUnits(NamedTuple):
    """The units in which the quantities of a question were given, "" where a kind of them has none.

    ``length`` is the unit of lengths and depths along a rod or a well, ``across`` of diameters and walls, ``density``
    of fluids; ``force``, ``pressure``, ``frequency``, ``speed`` and ``curvature`` are the units of their kinds.
    """

    length: str = ""
    across: str = ""
    force: str = ""
    pressure: str = ""
    density: str = ""
    frequency: str = ""
    speed: str = ""
    curvature: str = ""

    @classmethod
    def of(cls, **values: Any) -> GivenUnits:
        """Return the unit of each kind in the first of its values that has one: texts, quantities of pint, lists.

        >>> GivenUnits.of(force=(20e3, "3klbf"), frequency=("10", "60hz"), length=None)
        GivenUnits(length='', across='', force='klbf', pressure='', density='', frequency='Hz', speed='', curvature='')
        """
        return cls(**{kind: next(_units_in(value, _KINDS.get(kind, kind)), "") for kind, value in values.items()})

    def or_else(self, *others: GivenUnits) -> GivenUnits:
        """Return these units, each missing one taken from the first of ``others`` that has it."""
        return GivenUnits(*(next(filter(None, names), "") for names in zip(self, *others, strict=True)))


def _units_in(value: Any, kind: str, depth: int = _DEEPEST) -> Iterator[str]:
    """Yield the names of the units of a kind in a value, or in the elements of a list and of the lists in it."""
    if isinstance(value, str):
        words = [unit_of(value) or ""]
    elif is_measured(value):
        words = _names_of_measured(value)
    elif isinstance(value, list | tuple) and depth:
        for element in value if len(value) <= _FEW else (value[0], value[-1]):
            yield from _units_in(element, kind, depth - 1)
        return
    else:
        return
    yield from filter(None, (meant(word, UNITS[kind]) for word in words if word))


def _names_of_measured(value: Any) -> list[str]:
    """Return how a quantity of pint may call its unit."""
    given = getattr(value, "units", getattr(value, "unit", ""))
    try:
        return [str(given), format(given, "~").replace(" ", "")]
    except (TypeError, ValueError):  # another library, which has no short names
        return [str(given)]


_NONE_GIVEN = GivenUnits()


class InUnits:
    """Base of frozen values that remember in which units they were given, which changes neither them nor equality."""

    @property
    def given_units(self) -> GivenUnits:
        """The units in which its quantities were given."""
        given: GivenUnits = vars(self).get("_given_units", _NONE_GIVEN)
        return given

    def given_in(self, given: GivenUnits) -> Self:
        """Set the units in which its quantities were given, while it is made, and return it."""
        object.__setattr__(self, "_given_units", given)
        return self


_BESIDE_FEET = GivenUnits(
    across="in", force="lbf", pressure="ksi", density="ppg", frequency="Hz", speed="ft/min", curvature="deg/100ft"
)
_BESIDE_METRES = GivenUnits(across="mm", pressure="MPa", frequency="Hz")
_FEET, _POUNDS = ("ft", "ftUS", "in"), ("lbf", "klbf", "kip")
_OF_SURVEYS = {"ftUS": "ft"}
"""Units of lengths that answers replace."""

_IN_FEET = {"density": "lb/ft3", "acceleration": "ft/s2"}
"""Units of other quantities than those of `GivenUnits` beside feet; densities of solids."""


class AnswerUnits(NamedTuple):
    """The units that an answer is in, by the rule of this module, and those that follow from them.

    >>> shown = AnswerUnits.named(force="lbf")
    >>> shown.pressure.name, shown.per_length.name, shown.across.name, shown.speed.name
    ('ksi', 'lbf/ft', 'in', 'ft/min')
    """

    force: Unit
    length: Unit
    pressure: Unit
    frequency: Unit
    across: Unit
    density: Unit
    speed: Unit
    curvature: Unit

    @classmethod
    def named(
        cls,
        force: str | None = None,
        length: str | None = None,
        pressure: str | None = None,
        frequency: str | None = None,
        what: Callable[[str], str] = str,
        *,
        given: GivenUnits = _NONE_GIVEN,
        usual_force: str = "N",
    ) -> AnswerUnits:
        """Return the units that were asked for, by name, else ``given`` by the question, else the usual ones.

        ``what`` names the arguments in messages; ``usual_force`` is the unit of forces beside metres.  ValueError for
        names of no such unit.
        """
        wanted = {"force": force, "length": length, "pressure": pressure, "frequency": frequency}
        asked = {kind: unit(name, what(kind), kind).name for kind, name in wanted.items() if name is not None}
        known = GivenUnits(**asked).or_else(given._replace(length=_OF_SURVEYS.get(given.length, given.length)))
        along = known.length or ("ft" if known.force in _POUNDS else "m")
        usual = _BESIDE_FEET if along in _FEET else _BESIDE_METRES._replace(force=usual_force)
        names = known.or_else(GivenUnits(length=along), usual)._asdict()
        return cls(**{name: unit(names[name], "", _KINDS.get(name, name)) for name in cls._fields})

    @property
    def per_length(self) -> Unit:
        """Of forces per length, in N or kgf, since kN is for the force on a whole string; in lbf beside feet.

        >>> AnswerUnits.named(force="klbf", length="ft").per_length.name
        'lbf/ft'
        >>> AnswerUnits.named(force="kN", length="ft").per_length.name
        'lbf/ft'
        """
        name = "lbf" if self._has_feet else _PER_LENGTH.get(self.force.name, self.force.name)
        return unit(name, "", "force").per(self.length)

    @property
    def mass_per_length(self) -> Unit:
        """Of masses per length."""
        return unit("lb", "", "mass").per(unit("ft", "", "length")) if self._has_feet else Unit("kg/m", 1.0)

    @property
    def rigidity(self) -> Unit:
        """Of flexural rigidities, beside feet in pounds."""
        force = unit("lbf", "", "force") if self._has_feet and self.force.name not in _POUNDS else self.force
        return Unit(f"{force.name} {self.length.name}^2", force.size * self.length.size**2)

    @property
    def _has_feet(self) -> bool:
        return self.length.name in _FEET

    def unit_for(self, kind: str, value: float, in_feet: str = "") -> Unit:
        """Return the unit in which to show a value of some kind; a density is of a fluid where ``in_feet`` is ppg.

        >>> AnswerUnits.named(force="lbf").unit_for("density", 1e3, "ppg").name
        'ppg'
        """
        if kind == "pressure" and value >= 1e9:
            return unit({"ksi": "Mpsi", "psi": "Mpsi"}.get(self.pressure.name, "GPa"), "", kind)
        if kind in ("length", "pressure", "curvature"):
            known: Unit = getattr(self, kind)
            return known
        if kind == "density" and in_feet:
            return self.density
        return unit("deg" if kind == "angle" else _IN_FEET.get(kind, "") if self._has_feet else "", "", kind)
