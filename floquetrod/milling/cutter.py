"""A milling cutter as a value: modes, teeth, immersion and cutting coefficients.

Y. Altintas, Manufacturing Automation, Cambridge 2012, doi:10.1017/CBO9780511843723; T. Insperger and G. Stepan,
Semi-Discretization for Time-Delay Systems, Springer 2011, doi:10.1007/978-1-4614-0335-7.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import Message
from floquetrod._util.arrays import Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.calling import constructor_hints, level_of_caller
from floquetrod._util.content import ByContent
from floquetrod._util.plausibility_warning import SILENCE, PlausibilityWarning, is_typed
from floquetrod.equations import DelaySystem, PeriodicSystem, Varying
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.parameter import Parameter, by_name

_SOFTEST = 1e5  # Pa: foam takes ten times as much to cut (a choice)
_EDGE = 1e-12  # rad: a tooth so close to entering or leaving counts as beyond

MOST_TEETH = 64
"""Most teeth of a cutter (a choice)."""

TOOL_MODE = by_name(
    Parameter(name="frequency", symbol="omega", kind="frequency", least=1e-6, largest=1e9),
    Parameter(name="damping_ratio", symbol="zeta", kind="ratio", least=1e-9, largest=0.999),
    Parameter(
        name="mass",
        symbol="m",
        kind="mass",
        least=1e-12,
        largest=1e9,
        instead=(Parameter(name="stiffness", symbol="k", kind="stiffness", least=1e-9, largest=1e15),),
    ),
)
"""Parameters of a mode of a tool by their names; its stiffness may be given in place of the mass."""

CUTTER = by_name(
    Parameter(name="x", symbol="", kind="", default=()),
    Parameter(name="y", symbol="", kind="", default=()),
    Parameter(name="teeth", symbol="N", kind=""),
    Parameter(name="tangential", symbol="K_t", kind="pressure", least=1.0, largest=1e15),
    Parameter(name="radial", symbol="K_r", kind="pressure", least=-1e15, largest=1e15),
    Parameter(name="immersion", symbol="a / D", kind="ratio", least=1e-6, largest=1.0, default=1.0),
    Parameter(name="direction", symbol="", kind="", default="up"),
)
"""Parameters of a cutter by their names."""


@constructor_hints()
@dataclass(frozen=True, init=False)
class ToolMode:
    """A mode of vibration at the tool's tip.

    Parameters
    ----------
    frequency : str or float
        Natural frequency, such as "922Hz"; a number is in rad/s.
    damping_ratio : str or float
        Part of critical damping, above 0 and below 1: 0.011, or "1.1%".
    mass : str or float, optional
        Modal mass, such as "39.93g"; a number is in kg.
    stiffness : str or float, optional
        Modal stiffness in place of the mass, such as "1.34N/um"; a number is in N/m.

    Examples
    --------
    >>> mode = ToolMode("922Hz", 0.011, mass="39.93g")
    >>> round(mode.stiffness)
    1340050
    """

    frequency: float
    damping_ratio: float
    mass: float

    def __init__(self, frequency: Any, damping_ratio: Any, mass: Any = None, stiffness: Any = None) -> None:
        """Check the parameters and bring them into SI units."""
        omega = TOOL_MODE["frequency"].within_limits(frequency)
        ratio = TOOL_MODE["damping_ratio"].within_limits(damping_ratio)
        if (mass is None) == (stiffness is None):
            raise TypeError("mass or stiffness must be given, one of them")
        if mass is None:
            kilograms = TOOL_MODE["mass"].instead[0].within_limits(stiffness) / omega**2
        else:
            kilograms = TOOL_MODE["mass"].within_limits(mass)
        for name, value in (("frequency", omega), ("damping_ratio", ratio), ("mass", kilograms)):
            object.__setattr__(self, name, value)

    @property
    def stiffness(self) -> float:
        """Modal stiffness in N/m."""
        return self.mass * self.frequency**2


@constructor_hints(modes="x and y take the modes", flutes="teeth is their number")
@dataclass(frozen=True, eq=False, repr=False, init=False)
class Cutter(ByContent):
    """The parameters of a cutter, see `floquetrod.Milling`, and the equations that follow."""

    x: tuple[ToolMode, ...]
    y: tuple[ToolMode, ...]
    teeth: int
    tangential: float
    radial: float
    immersion: float
    direction: Literal["up", "down"]

    def __init__(
        self,
        x: Any = (),
        y: Any = (),
        *,
        teeth: int,
        tangential: Any,
        radial: Any,
        immersion: Any = 1.0,
        direction: Literal["up", "down"] = "up",
    ) -> None:
        """Check the parameters and bring them into SI units."""
        modes = {name: tuple(_modes(name, given)) for name, given in (("x", x), ("y", y))}
        if not modes["x"] and not modes["y"]:
            raise ValueError("x or y must hold a ToolMode, got none")
        vars(self).update(
            **modes,
            teeth=validate.integer("teeth", teeth, 1, MOST_TEETH),
            tangential=CUTTER["tangential"].within_limits(tangential),
            radial=CUTTER["radial"].within_limits(radial),
            immersion=CUTTER["immersion"].within_limits(immersion),
            direction=validate.choice("direction", direction, ("up", "down")),
        )
        _warn_of_soft(self.tangential)

    def in_words(self) -> str:
        """Return cutting coefficients and modes in usual units."""
        modes = [
            f"along {axis} {mode.frequency / (2.0 * math.pi):.6g} Hz, {100.0 * mode.damping_ratio:.4g} %, "
            f"{mode.mass:.4g} kg"
            for axis, listed in (("x", self.x), ("y", self.y))
            for mode in listed
        ]
        coefficients = f"tangential {1e-6 * self.tangential:.4g} N/mm2, radial {1e-6 * self.radial:.4g} N/mm2"
        return "; ".join([coefficients, *modes])

    @property
    def modes(self) -> tuple[ToolMode, ...]:
        """Every mode, those along x first."""
        return self.x + self.y

    @property
    def angles(self) -> tuple[float, float]:
        """Angles at which a tooth enters and leaves, in rad."""
        if self.direction == "up":
            return 0.0, math.acos(1.0 - 2.0 * self.immersion)
        return math.acos(2.0 * self.immersion - 1.0), math.pi

    @property
    def pitch(self) -> float:
        """Angle between teeth, in rad."""
        return 2.0 * math.pi / self.teeth

    @cached_property
    def jumps(self) -> tuple[float, ...]:
        """Angles within a pitch, from 0 on, at which a tooth enters or leaves the cut."""
        entry, leave = self.angles
        if abs(entry) < 1e-12 and abs(leave - math.pi) < 1e-12 and self.teeth % 2 == 0:
            return ()  # as one tooth leaves another enters, and neither cuts there
        jumps: list[float] = []
        for angle in sorted(angle % self.pitch for angle in (entry, leave)):
            at = 0.0 if self.pitch - angle < 1e-9 else angle
            jumps += [] if any(abs(at - other) < 1e-9 for other in jumps) else [at]
        return tuple(jumps)

    def cutting(self, angle: Any) -> Floats:
        """Return H, in Pa, of the modes, with a tooth at angles in rad (array_like): of shape (..., n, n).

        ValueError or TypeError for angles other than finite numbers.
        """
        angle = units.array("angle", angle, "angle", -validate.LARGEST, validate.LARGEST)
        entry, leave = self.angles
        teeth = angle[..., None] + self.pitch * np.arange(self.teeth)
        teeth = teeth - 2.0 * math.pi * np.floor(teeth / (2.0 * math.pi))
        cuts = ((teeth >= entry - _EDGE) & (teeth < leave - _EDGE)).astype(float)
        sine, cosine = np.sin(teeth), np.cos(teeth)
        forces = self.tangential * cosine + self.radial * sine, self.radial * cosine - self.tangential * sine
        along = [[(cuts * force * thick).sum(axis=-1) for thick in (sine, cosine)] for force in forces]
        axis = [0] * len(self.x) + [1] * len(self.y)
        rows = [np.stack([along[i][j] for j in axis], axis=-1) for i in axis]
        return np.stack(rows, axis=-2)

    @cached_property
    def _pieces(self) -> PeriodicSystem:
        """H over the angle between teeth, in pieces."""
        return PeriodicSystem.from_function(self.cutting, self.pitch, self.jumps)

    def system(self, speed: Any, depth: Any) -> DelaySystem:
        """Return the equations in kg, N and m at a spindle speed and an axial depth of cut.

        Parameters
        ----------
        speed : str or float
            Such as "5000rpm"; a number is in rad/s.
        depth : str or float
            Such as "0.5mm"; a number is in m.

        Examples
        --------
        >>> cutter = Cutter(y=[ToolMode(5000.0, 0.02, 0.1)], teeth=3, tangential="800MPa", radial="300MPa")
        >>> cutter.system("9000rpm", "1mm").order
        1
        """
        turn, deep = read_speed(speed), read_depth(depth)
        cut = self._pieces
        stiffness = np.diag([mode.stiffness for mode in self.modes])
        others: dict[str, Any] = {
            "mass": np.diag([mode.mass for mode in self.modes]),
            "damping": np.diag([2.0 * mode.damping_ratio * mode.frequency * mode.mass for mode in self.modes]),
            "coefficient_error": deep * cut.coefficient_error,
        }
        if not cut.pieces:
            cosines, sines = ([deep * each for each in part] for part in (cut.cosines, cut.sines))
            mean, period = deep * cut.mean, float(cut.period) / turn
            delayed = [(period, -mean, [-each for each in cosines], [-each for each in sines])]
            return DelaySystem(stiffness + mean, cosines, sines, period=period, delayed=delayed, **others)
        lengths = [float(duration) / turn for duration, _ in cut.pieces]
        values = [_scaled(value, deep, turn) for _, value in cut.pieces]
        now = [
            (length, value.mapped(lambda constant: stiffness + constant, np.asarray))
            for length, value in zip(lengths, values, strict=True)
        ]
        back = [(length, value.mapped(np.negative, np.negative)) for length, value in zip(lengths, values, strict=True)]
        return DelaySystem.from_pieces(now, delayed=[(sum(map(Fraction, lengths)), back)], **others)

    def stability(self, speed: Any, depth: Any) -> SystemStability:
        """Return the verdict at a spindle speed and an axial depth of cut; its period is the time between teeth.

        Parameters
        ----------
        speed : str or float
            As of `system`.
        depth : str or float
            As of `system`.
        """
        verdict: SystemStability = stability(self.system(speed, depth))
        return verdict

    def __repr__(self) -> str:
        """Return what the cutter is."""
        kind = "slot" if self.immersion == 1.0 else f"{self.direction} milling, immersion {self.immersion:g}"
        plural = "s" * (len(self.modes) > 1)
        return f"<Milling: {self.teeth} teeth, {kind}, {len(self.modes)} mode{plural}>"


def _warn_of_soft(tangential: float) -> None:
    """Warn of a cutting coefficient that is probably in N/mm2."""
    if is_typed(tangential) and tangential < _SOFTEST:
        text = (
            f"tangential = {tangential:g} Pa is less than anything is cut with; was it in N/mm2? A number is taken in "
            f'Pa: tangential="{tangential:g}N/mm2"'
        )
        warnings.warn(Message(text, SILENCE), PlausibilityWarning, stacklevel=level_of_caller())


def read_speed(value: Any, name: str = "speed") -> float:
    """Return a spindle speed in rad/s."""
    return units.quantity(value, name, "frequency", least=1e-6, largest=1e9)


def read_depth(value: Any, name: str = "depth") -> float:
    """Return a depth of cut in m."""
    return units.quantity(value, name, "length", least=0.0, largest=1e6)


def _modes(name: str, given: Any) -> list[ToolMode]:
    listed = [given] if isinstance(given, ToolMode) else validate.sequence(name, given, "[ToolMode(...)]")
    return [validate.instance(f"{name}[{i}]", mode, ToolMode) for i, mode in enumerate(listed)]


def _scaled(value: Varying, depth: float, speed: float) -> Varying:
    """Return H over angles as depth H over time."""
    slope = None if value.slope is None else depth * speed * value.slope
    cosines, sines = ([depth * m for m in series] for series in (value.cosines, value.sines))
    return Varying(None, slope, cosines, sines, start=depth * value.start)
