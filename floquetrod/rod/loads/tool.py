"""A tool in a string that shakes it along its axis."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.calling import constructor_hints
from floquetrod._util.result_report import Report, ShownInNotebook
from floquetrod.parameter import Parameter, by_name
from floquetrod.rod.loads.load import LOAD

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
)
"""Parameters of a tool by their names."""


@constructor_hints(at="the distance from the lower end is above_end", tool_at="the distance is above_end")
@dataclass(frozen=True)
class VibrationTool(units.InUnits, ShownInNotebook):
    """A tool in a string that pushes and pulls it along its axis with a sine.

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

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        self.given_in(units.GivenUnits.of(force=self.amplitude, frequency=self.frequency, length=self.above_end))
        for name, parameter in TOOL.items():
            object.__setattr__(self, name, parameter.number(getattr(self, name)))

    @property
    def share(self) -> float:
        """Part of the force that goes up the string."""
        return 0.5 if self.above_end else 1.0

    @property
    def hertz(self) -> float:
        """The frequency in Hz."""
        return self.frequency / (2.0 * math.pi)

    def in_words(self, shown: units.AnswerUnits) -> str:
        """Return what the tool does and where it is, in units.

        Returns
        -------
        str
            On one line.
        """
        shakes = f"{shown.force.show(self.amplitude)} at {shown.frequency.show(self.frequency)}"
        return f"{shakes}, {shown.length.show(self.above_end)} above the lower end"

    def _at_hand(self) -> Report:
        """Return the tool in the units in which it was given, for a notebook."""
        return Report(f"vibration tool: {self.in_words(units.AnswerUnits.named(given=self.given_units))}")

    def as_dict(self) -> dict[str, float]:
        """Return the parameters in SI units.

        Returns
        -------
        dict of str to float
            By the names of the parameters.
        """
        return {name: getattr(self, name) for name in TOOL}


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
