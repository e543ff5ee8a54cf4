"""A tool in a string that shakes it along its axis."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.calling import constructor_hints
from floquetrod._util.result_report import Report, ShownInNotebook
from floquetrod.parameter import Parameter, by_name
from floquetrod.rod.loads.load import LOAD, Second, second_sine

TOOL = by_name(
    replace(LOAD["amplitude"], known_to=frozenset({"strings", "simulation"}), option=None),
    replace(LOAD["frequency"], known_to=frozenset({"strings", "simulation"}), option=None),
    Parameter(
        name="above_end",
        symbol="",
        kind="length",
        least=0.0,
        largest=1e6,
        default=0.0,
        known_to=frozenset({"strings", "simulation"}),
    ),
    replace(LOAD["second"], known_to=frozenset({"strings", "simulation"}), option=None),
)
"""Parameters of a tool by their names."""

NUMBERS_OF_TOOL = {name: parameter for name, parameter in TOOL.items() if parameter.kind}
"""Those that are one number."""

_LOCKS, _BEATS = 20, 1e-4
"""Largest p + q of a ratio p/q of frequencies at which phases lock, and the beat from which they do not.

The beat is over the slower frequency: ten thousand periods.  Beyond, mean friction is that of free phases to 0.05 mu N
(drawn)."""


@constructor_hints(at="the distance from the lower end is above_end", tool_at="the distance is above_end")
@dataclass(frozen=True)
class VibrationTool(units.InUnits, ShownInNotebook):
    """A tool in a string that pushes and pulls it along its axis with a sine, or with two.

    Inside the string half the force goes each way, at its lower end all of it up.  The ends of the string reflect the
    waves: the lower end as a free one, at which the force stays, the upper one as held, as it moves steadily.

    Parameters
    ----------
    amplitude : float or str
        Of the force in N, or with a unit such as "5kN".
    frequency : float or str
        In rad/s, or with a unit such as "18Hz".
    above_end : float or str
        Distance of the tool from the lower end of the string in m, or with a unit; by default 0.
    second : tuple of float or str, optional
        Amplitude and frequency of a second sine, of another tool at the same place, such as ("3kN", "29Hz"); with
        a phase in rad as a third number it is amplitude sin(frequency t + phase).  Mean forces and reach take the
        phases as independent, and refuse frequencies whose ratio is a fraction of small integers, except 1: two of the
        same frequency are one, added as vectors (page `theory/two_frequencies`).

    Raises
    ------
    TypeError, ValueError
        For numbers out of range, and for other units.

    Examples
    --------
    >>> tool = VibrationTool("5kN", "18Hz", "30m")
    >>> tool
    VibrationTool(amplitude=5000.0, frequency=113.09733552923255, above_end=30.0)
    >>> tool.share
    0.5
    """

    amplitude: float
    frequency: float
    above_end: float = 0.0
    second: Second | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        self.given_in(units.GivenUnits.of(force=self.amplitude, frequency=self.frequency, length=self.above_end))
        for name, parameter in NUMBERS_OF_TOOL.items():
            object.__setattr__(self, name, parameter.number(getattr(self, name)))
        object.__setattr__(self, "second", second_sine(self.second))

    def __repr__(self) -> str:
        """Return the constructor's call, without a second sine where there is none."""
        return f"VibrationTool({', '.join(f'{name}={value!r}' for name, value in self.as_dict().items())})"

    @property
    def share(self) -> float:
        """Part of the force that goes up the string."""
        return 0.5 if self.above_end else 1.0

    @property
    def hertz(self) -> float:
        """The frequency in Hz."""
        return self.frequency / (2.0 * math.pi)

    def in_words(self, shown: units.AnswerUnits) -> str:
        """Return what the tool does and where it is, in units: as it was given, or to four digits in other units.

        Returns
        -------
        str
            On one line.
        """
        given = self.given_units
        force, frequency, length = (
            partial(unit.show, digits=6 if unit.name == name else 4)
            for unit, name in (
                (shown.force, given.force),
                (shown.frequency, given.frequency),
                (shown.length, given.length),
            )
        )
        shakes = f"{force(self.amplitude)} at {frequency(self.frequency)}"
        if self.second is not None:
            amplitude, other, *phase = self.second
            shakes += f" and {force(amplitude)} at {frequency(other)}"
            shakes += f", {phase[0]:.4g} rad ahead" if phase else ""
        return f"{shakes}, {length(self.above_end)} above the lower end"

    def _at_hand(self) -> Report:
        """Return the tool in the units in which it was given, for a notebook."""
        return Report(f"vibration tool: {self.in_words(units.AnswerUnits.named(given=self.given_units))}")

    def as_dict(self) -> dict[str, Any]:
        """Return the parameters in SI units.

        Returns
        -------
        dict of str to float
            By the names of the parameters; a second sine as a tuple, where there is one.
        """
        numbers = {name: getattr(self, name) for name in NUMBERS_OF_TOOL}
        return numbers if self.second is None else {**numbers, "second": self.second}

    @property
    def sines(self) -> tuple[tuple[float, float], ...]:
        """Amplitude in N and frequency in rad/s of each sine."""
        first = self.amplitude, self.frequency
        return (first,) if self.second is None else (first, (self.second[0], self.second[1]))


def tool_inside(given: Any, length: float, what: str) -> VibrationTool:
    """Return a tool that lies inside a rod or a string of a length in m; ``what`` names it."""
    tool: VibrationTool = validate.instance(
        "tool", given, VibrationTool, "such as fr.VibrationTool('5kN', '18Hz', '30m')"
    )
    if tool.above_end >= length:
        raise validate.wrong_value(
            "tool",
            f"must lie in the {what}, less than its length {length:g} m above the lower end, got above_end = "
            f"{tool.above_end:g} m",
        )
    return tool


def independent_sines(tool: VibrationTool) -> tuple[tuple[float, float], ...]:
    """Return amplitude in N and frequency in rad/s of each sine of a tool that moves the string, the slower first.

    Of two with the same frequency their sum, and none of amplitude 0 beside another.  Frequencies whose phases lock are
    refused.
    """
    first, *others = tool.sines
    if tool.second is None or tool.second[0] == 0.0:
        return (first,)
    (second,) = others
    if second[1] == first[1]:
        ahead = tool.second[2] if len(tool.second) == 3 else 0.0
        return ((math.hypot(first[0] + second[0] * math.cos(ahead), second[0] * math.sin(ahead)), first[1]),)
    if first[0] == 0.0:
        return (second,)
    _require_free_phases(tool)
    return (first, second) if first[1] < second[1] else (second, first)


def _require_free_phases(tool: VibrationTool) -> None:
    """Raise ValueError for two frequencies whose ratio is, or nearly is, a fraction of small integers."""
    slow, fast = sorted(frequency for _, frequency in tool.sines)
    for below in range(1, _LOCKS):
        above = round(below * fast / slow)
        if above <= _LOCKS - below and abs(below * fast / slow - above) < _BEATS:
            unit = units.unit(tool.given_units.frequency, "frequency", "frequency")
            raise validate.wrong_value(
                "tool",
                f"must have two frequencies whose phases are free, got {unit.show(fast)}, {above}/{below} of "
                f"{unit.show(slow)}: friction then depends on how the phases lock; two tools drift apart, so give a "
                "frequency that is some per mille different",
            )
