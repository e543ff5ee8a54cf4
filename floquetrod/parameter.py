"""The record of a parameter of a rod, a load, a tool or a cutter: its name, unit, limits, default, option and use.

Checks, units, files, options of the terminal with their help, reports and the explorer follow from the records; the
field and the argument of a class, which Python needs, are compared with them by a test.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias

from floquetrod import units
from floquetrod._util.arguments import wrong_value

Subsystem: TypeAlias = Literal[
    "modes",
    "bends",
    "proofs",
    "large motion",
    "kicks",
    "stress",
    "critical force",
    "helix",
    "strings",
    "simulation",
]
"""What computes answers from a problem.

"bends" is asked in place of "modes" where the channel bends, and besides "critical force" there; "proofs", "kicks" and
"large motion" are asked besides "modes" or "bends".
"""

NAMES: dict[Subsystem, str] = {
    "modes": "verdicts on modes",
    "bends": "verdicts in channels that bend",
    "proofs": "proofs over boxes",
    "large motion": "large motion",
    "kicks": "kicks against friction",
    "stress": "stresses",
    "critical force": "critical forces and modes",
    "helix": "helical buckling and lock-up",
    "strings": "mean force and reach in a well",
    "simulation": "simulations",
}
"""Subsystems, as messages call them."""

REQUIRED: Any = ...
"""Default of a parameter that must be given."""

EVERYWHERE: frozenset[Subsystem] = frozenset(NAMES)


class Option(NamedTuple):
    """The option of the terminal that sets a parameter: the words of its help, and for what a value stands."""

    help: str
    metavar: str | None = None
    range: str = ""  # an example of one, where the command takes ranges, which the help says at {range}
    in_a_well: bool = True  # whether also of a string that takes its channel from a well
    name: str = ""  # where it is not that of the parameter
    choices: tuple[str, ...] | None = None


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """A parameter of a problem.

    Parameters
    ----------
    name : str
        Name of its field and its argument.
    symbol : str
        As the equations have it.
    kind : str
        Kind of quantity, whose units `floquetrod.units` knows; "" for a word.
    least, largest : float
        Limits in the SI unit, whatever the other parameters are.
    range_in_words : str
        How a message says the limits, where the numbers alone do not.
    default : object
        `REQUIRED` where a value must be given.
    hint : str
        What to do about a wrong value; by default, to give it in its SI unit.
    option : Option
        Its option of the terminal, None without one.
    known_to, without_effect_on : frozenset of str
        Subsystems whose answers change with it, and subsystems whose answers by physics do not.  All others refuse any
        value but the default, see `require_known`.
    is_echoed : bool
        Whether reports say it where it differs from the default.
    called : str
        Its name in a sentence, where that is another.
    in_feet : str
        The unit in which it is shown beside feet, where that is not the one of its kind.
    instead : tuple of Parameter
        Aliases that may be given in its place.
    factor : float
        Ratio of an alias to the parameter it stands for: 2 for a diameter given in place of a radius.
    """

    name: str
    symbol: str
    kind: str
    least: float = -math.inf
    largest: float = math.inf
    range_in_words: str = ""
    default: Any = REQUIRED
    hint: str = ""
    option: Option | None = None
    known_to: frozenset[Subsystem] = frozenset()
    without_effect_on: frozenset[Subsystem] = frozenset()
    is_echoed: bool = False
    called: str = ""
    in_feet: str = ""
    instead: tuple[Parameter, ...] = ()
    factor: float = 1.0

    @property
    def unit(self) -> str:
        """Its SI unit."""
        return next(iter(units.units_of(self.kind)))

    @property
    def words(self) -> str:
        """Its name in a sentence."""
        return self.called or self.name.replace("_", " ")

    @property
    def remedy(self) -> str:
        """What to do about a wrong value."""
        return self.hint or f"give it in {self.unit}"

    @property
    def is_shown_as_diameter(self) -> bool:
        """Whether it is a radius, which reports show as a diameter, as on drawings."""
        return any(alias.factor == 2.0 for alias in self.instead)

    def number(self, value: Any, name: str | None = None) -> float:
        """Return a value in the SI unit, within the limits; ``name`` is the argument's, where it is another."""
        from floquetrod._util import validate  # which needs numpy: options alone do not

        name = name or self.name
        sign = math.ulp(0.0) if self.least > 0.0 else 0.0 if self.least == 0.0 else -math.inf
        number = units.number(name, value, self.kind, -math.inf if self.range_in_words else sign, hint=self.remedy)
        if self.range_in_words and not self.least <= number <= self.largest:
            raise wrong_value(name, f"must be {self.range_in_words}, got {number:g}; {self.remedy}")
        return validate.within(name, number, self.least, self.largest, f"give it in {self.unit}")

    def quantity(self, text: Any, name: str, **options: Any) -> float:
        """Return what was written, with a unit or without, in the SI unit; options as there."""
        return units.quantity(text, name, self.kind, **options)

    def within_limits(self, text: Any, name: str | None = None) -> float:
        """Return what was written, with a unit or without, in the SI unit and within the limits."""
        return units.quantity(text, name or self.name, self.kind, least=self.least, largest=self.largest)

    def in_words(self, value: Any, shown: units.AnswerUnits | None = None) -> tuple[str, str]:
        """Return name and value in the units of an answer, by default in SI units."""
        if not self.kind or not isinstance(value, float):
            in_words = getattr(value, "in_words", None)  # of values with units of their own
            return self.words, str(value) if in_words is None or shown is None else in_words(shown)
        if shown is None:
            return self.words, units.unit("", self.name, self.kind).show(value)
        if self.is_shown_as_diameter:
            return self.words.replace("radius", "diameter"), shown.across.show(2.0 * value)
        return self.words, shown.unit_for(self.kind, value, self.in_feet).show(value)


def by_name(*parameters: Parameter) -> dict[str, Parameter]:
    """Return a table of parameters by their names."""
    return {each.name: each for each in parameters}


def unknown(parameters: Mapping[str, Parameter], subsystem: Subsystem) -> list[Parameter]:
    """Return the parameters that a subsystem would ignore, though they may have an effect."""
    return [each for each in parameters.values() if subsystem not in each.known_to | each.without_effect_on]


def is_known(numbers: Mapping[str, Any], parameters: Mapping[str, Parameter], subsystem: Subsystem) -> Any:
    """Return whether a subsystem ignores none of the numbers by name that differ from their default; also of arrays."""
    known: Any = True
    for parameter in unknown(parameters, subsystem):
        if parameter.name in numbers:
            known = known & (numbers[parameter.name] == parameter.default)
    return known


def require_known(
    problem: Any, parameters: Mapping[str, Parameter], subsystem: Subsystem, shown: units.AnswerUnits | None = None
) -> None:
    """Raise ValueError where a subsystem would ignore a parameter of a problem that has not its default."""
    for parameter in unknown(parameters, subsystem):
        name, value = parameter.name, getattr(problem, parameter.name, parameter.default)
        if value != parameter.default:
            if isinstance(value, tuple):
                raise wrong_value(
                    name,
                    f"are not part of {NAMES[subsystem]}, which would ignore all but the first: got {len(value)} of "
                    f"them; {parameter.remedy}",
                )
            words = parameter.in_words(value, units.AnswerUnits.named() if shown is None else shown)
            raise wrong_value(
                name,
                f"is not part of {NAMES[subsystem]}, which would ignore it: got {' '.join(words)}; "
                f"leave it out, or ask with {name}={parameter.default!r}",
            )
