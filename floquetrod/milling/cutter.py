"""A milling cutter as a value: modes, teeth with their pitch, helix and runout, immersion and cutting coefficients.

Y. Altintas, Manufacturing Automation, Cambridge 2012, doi:10.1017/CBO9780511843723; T. Insperger and G. Stepan,
Semi-Discretization for Time-Delay Systems, Springer 2011, doi:10.1007/978-1-4614-0335-7.
"""

from __future__ import annotations

import functools
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
from floquetrod.bare_numbers import Quantity
from floquetrod.equations import DelaySystem, PeriodicSystem, Varying
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.milling import teeth as of_teeth
from floquetrod.milling.teeth import Arc
from floquetrod.parameter import Parameter, by_name

_SOFTEST = 1e5  # Pa: foam takes ten times as much to cut (a choice)
_FASTEST = 3000.0  # rad/s: 28,648 rpm, and machines show speeds of this size in rpm (a choice)
_EDGE = 1e-12  # rad: a tooth so close to entering or leaving counts as beyond
_WHOLE_TURN = math.radians(1e-3)  # by which pitches may miss it, rounded as on drawings (a choice)
_MOST_TURNS = 4  # of a helix over the depth of cut (a choice)

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
    Parameter(name="pitch", symbol="psi_j", kind="angle", least=1e-3, largest=2.0 * math.pi, default=()),
    Parameter(name="helix", symbol="eta", kind="angle", least=0.0, largest=math.radians(80.0), default=0.0),
    Parameter(name="diameter", symbol="D", kind="length", least=1e-6, largest=1e3, default=None),
    Parameter(name="runout", symbol="r_j", kind="length", least=-0.01, largest=0.01, default=()),
    Parameter(name="feed_per_tooth", symbol="f_z", kind="length", least=1e-9, largest=1.0, default=None),
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

    Raises
    ------
    TypeError, ValueError
        For numbers out of these ranges, for another unit, and unless exactly one of mass and stiffness is given.

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
    pitch: tuple[float, ...]
    helix: float
    diameter: float | None
    runout: tuple[float, ...]
    feed_per_tooth: float | None

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
        pitch: Any = (),
        helix: Any = 0.0,
        diameter: Any = None,
        runout: Any = (),
        feed_per_tooth: Any = None,
    ) -> None:
        """Check the parameters and bring them into SI units."""
        modes = {name: tuple(_modes(name, given)) for name, given in (("x", x), ("y", y))}
        if not modes["x"] and not modes["y"]:
            raise ValueError("x or y must hold a ToolMode, got none")
        count = validate.integer("teeth", teeth, 1, MOST_TEETH)
        given = {"diameter": diameter, "feed_per_tooth": feed_per_tooth}
        vars(self).update(
            **modes,
            teeth=count,
            tangential=CUTTER["tangential"].within_limits(tangential),
            radial=CUTTER["radial"].within_limits(radial),
            immersion=CUTTER["immersion"].within_limits(immersion),
            direction=validate.choice("direction", direction, ("up", "down")),
            pitch=_pitch(pitch, count),
            helix=CUTTER["helix"].within_limits(helix),
            runout=_runout(runout, count),
            **{name: None if each is None else CUTTER[name].within_limits(each) for name, each in given.items()},
        )
        if self.helix > 0.0 and self.diameter is None:
            raise ValueError('diameter must be given with a helix, which winds around it: diameter="12mm"')
        if any(self.runout) and self.feed_per_tooth is None:
            raise ValueError(
                'feed_per_tooth must be given with runout: chips thinner than it are not cut; feed_per_tooth="0.1mm"'
            )
        _warn_of_soft(self.tangential)

    def in_words(self) -> str:
        """Return cutting coefficients and modes in usual units.

        Returns
        -------
        str
            On one line.
        """
        modes = [
            f"along {axis} {mode.frequency / (2.0 * math.pi):.6g} Hz, {100.0 * mode.damping_ratio:.4g} %, "
            f"{mode.mass:.4g} kg"
            for axis, listed in (("x", self.x), ("y", self.y))
            for mode in listed
        ]
        coefficients = f"tangential {1e-6 * self.tangential:.4g} N/mm2, radial {1e-6 * self.radial:.4g} N/mm2"
        return "; ".join([coefficients, *self._teeth_in_words(), *modes])

    def _teeth_in_words(self) -> list[str]:
        """Return pitch, helix and runout, as far as the teeth are not straight, evenly spaced and of one length."""
        words = []
        if self.has_variable_pitch:
            words.append(f"pitch {', '.join(f'{math.degrees(angle):.6g}' for angle in self.pitch)} deg")
        if self.helix > 0.0 and self.diameter is not None:
            words.append(f"helix {math.degrees(self.helix):.4g} deg on a diameter of {1e3 * self.diameter:.6g} mm")
        if any(self.runout) and self.feed_per_tooth is not None:
            radii = ", ".join(f"{1e6 * radius:.6g}" for radius in self.runout)
            words.append(f"runout {radii} um, feed {1e3 * self.feed_per_tooth:.4g} mm a tooth")
        return words

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
    def has_variable_pitch(self) -> bool:
        """Whether the angles between teeth differ."""
        return len(set(self.pitch)) > 1

    @cached_property
    def cycle(self) -> float:
        """Angle in rad after which the teeth repeat; from each tooth to the next where all are alike."""
        return 2.0 * math.pi / (self.teeth // of_teeth.teeth_that_repeat(self.pitch, self.runout))

    @cached_property
    def arcs(self) -> tuple[Arc, ...]:
        """Angles over which each tooth cuts, and how much earlier the surface was left that it cuts."""
        return of_teeth.arcs(self.pitch, self.runout, self.teeth * (self.feed_per_tooth or 0.0), self.angles)

    @cached_property
    def delays(self) -> tuple[float, ...]:
        """Angles, from the smallest on, by which the cutter turned since the surface was left that a tooth cuts."""
        ascending = sorted({arc.delay for arc in self.arcs})
        return tuple(of_teeth.apart([*ascending, math.inf])[:-1])

    @property
    def jumps(self) -> tuple[float, ...]:
        """Angles within a cycle, from 0 on, at which a tooth's tip enters or leaves the cut, or the surface changes."""
        return jumps(self)

    def lag(self, depth: Any) -> float:
        """Return by how much the upper end of a tooth lags behind its tip, in rad, at a depth of cut.

        Parameters
        ----------
        depth : str or float
            Such as "0.5mm"; a number is in m.

        Returns
        -------
        float
            In rad; 0 without a helix.

        Raises
        ------
        TypeError, ValueError
            For another unit, a negative depth, and one over which the helix winds around the cutter more than four
            times.
        """
        deep = read_depth(depth)
        if self.helix == 0.0 or self.diameter is None:
            return 0.0
        lag = 2.0 * math.tan(self.helix) / self.diameter * deep
        if lag > 2.0 * math.pi * _MOST_TURNS:
            raise validate.wrong_value(
                "depth",
                f"must be at most {self.deepest:.4g} m, over which the helix winds around the cutter {_MOST_TURNS} "
                f"times, got {deep:.4g} m",
            )
        return lag

    @property
    def deepest(self) -> float:
        """The largest depth of cut in m, over which a helix winds around the cutter four times; else infinite."""
        if self.helix == 0.0 or self.diameter is None:
            return math.inf
        return math.pi * self.diameter * _MOST_TURNS / math.tan(self.helix)

    def cutting(self, angle: Any) -> Floats:
        """Return H, in Pa, of the modes at the tip, with a tooth at angles in rad (array_like): shape (..., n, n).

        Returns
        -------
        ndarray
            (..., n, n), in Pa.

        Raises
        ------
        TypeError, ValueError
            For angles other than finite numbers.
        """
        angle = units.array("angle", angle, "angle", -validate.LARGEST, validate.LARGEST)
        return np.asarray(cutting_by_delay(self, angle).sum(axis=0))

    def system(self, speed: Any, depth: Any) -> DelaySystem:
        """Return the equations in kg, N and m at a spindle speed and an axial depth of cut.

        Parameters
        ----------
        speed : str or float
            Such as "5000rpm"; a number is in rad/s, with a `PlausibilityWarning` where it may be meant in rpm.
        depth : str or float
            Such as "0.5mm"; a number is in m.

        Returns
        -------
        DelaySystem
            Its ``delayed`` terms are of the times between teeth.

        Raises
        ------
        TypeError, ValueError
            For another unit, and for a speed or depth out of range.

        Examples
        --------
        >>> cutter = Cutter(y=[ToolMode(5000.0, 0.02, 0.1)], teeth=3, tangential="800MPa", radial="300MPa")
        >>> cutter.system("9000rpm", "1mm").order
        1
        """
        turn, deep = read_speed(speed), read_depth(depth)
        cut, by_delay, shift = _expanded(self, self.lag(deep))
        stiffness = np.diag([mode.stiffness for mode in self.modes])
        others: dict[str, Any] = {
            "mass": np.diag([mode.mass for mode in self.modes]),
            "damping": np.diag([2.0 * mode.damping_ratio * mode.frequency * mode.mass for mode in self.modes]),
            "coefficient_error": deep * max(cut.coefficient_error, *(each.coefficient_error for each in by_delay)),
        }
        if not cut.pieces:
            cosines, sines = ([deep * each for each in part] for part in (cut.cosines, cut.sines))
            mean, period = deep * cut.mean, float(cut.period) / turn
            one = [(period, -mean, [-each for each in cosines], [-each for each in sines])]
            return DelaySystem(stiffness + mean, cosines, sines, period=period, delayed=one, **others)
        now = [
            (length, value.mapped(lambda constant: stiffness + constant, np.asarray))
            for length, value in _over_time(cut, deep, turn, shift, exactly=len(by_delay) > 1)
        ]
        whole = sum((Fraction(length) for length, _ in now), Fraction(0))
        delayed = [
            (
                of_teeth.part(delay, self.cycle) * whole,
                [
                    (length, value.mapped(np.negative, np.negative))
                    for length, value in _over_time(each, deep, turn, shift, exactly=len(by_delay) > 1)
                ],
            )
            for delay, each in zip(self.delays, by_delay, strict=True)
        ]
        return DelaySystem.from_pieces(now, delayed=delayed, **others)

    def stability(self, speed: Any, depth: Any) -> SystemStability:
        """Return the verdict at a spindle speed and an axial depth of cut; its period is the time until teeth repeat.

        Parameters
        ----------
        speed : str or float
            As of `system`.
        depth : str or float
            As of `system`.

        Returns
        -------
        SystemStability
            Growth is per s.

        Raises
        ------
        TypeError, ValueError
            As `system`.
        """
        verdict: SystemStability = stability(self.system(speed, depth))
        return verdict

    def __repr__(self) -> str:
        """Return what the cutter is."""
        uneven = [
            *(["variable pitch"] if self.has_variable_pitch else []),
            *([f"helix {math.degrees(self.helix):.4g} deg"] if self.helix else []),
            *(["runout"] if any(self.runout) else []),
        ]
        teeth = ", ".join([f"{self.teeth} teeth", *uneven])
        kind = "slot" if self.immersion == 1.0 else f"{self.direction} milling, immersion {self.immersion:g}"
        plural = "s" * (len(self.modes) > 1)
        return f"<Milling: {teeth}, {kind}, {len(self.modes)} mode{plural}>"


def _warn_of_soft(tangential: float) -> None:
    """Warn of a cutting coefficient that is probably in N/mm2."""
    if is_typed(tangential) and tangential < _SOFTEST:
        text = (
            f"tangential = {tangential:g} Pa is less than anything is cut with; was it in N/mm2? A number is taken in "
            f'Pa: tangential="{tangential:g}N/mm2"'
        )
        warnings.warn(Message(text, SILENCE), PlausibilityWarning, stacklevel=level_of_caller())


def read_speed(value: Any, name: str = "speed") -> float:
    """Return a spindle speed in rad/s, with a warning of a number alone that is probably in rpm."""
    speed = units.quantity(value, name, "frequency", least=1e-6, largest=1e9)
    typed = Quantity(name, value, "frequency")
    if typed.unit == "" and (isinstance(value, str) or (is_typed(speed) and speed >= _FASTEST)):
        number = str(value).strip()
        text = (
            f"{name} = {number} rad/s is {30.0 * speed / math.pi:.6g} rpm; was it in rpm? A number is taken in rad/s: "
            f'write "{number}rpm" or "{number}rad/s"'
        )
        warnings.warn(Message(text, SILENCE), PlausibilityWarning, stacklevel=level_of_caller())
    return speed


def read_depth(value: Any, name: str = "depth") -> float:
    """Return a depth of cut in m."""
    return units.quantity(value, name, "length", least=0.0, largest=1e6)


def _modes(name: str, given: Any) -> list[ToolMode]:
    listed = [given] if isinstance(given, ToolMode) else validate.sequence(name, given, "[ToolMode(...)]")
    return [validate.instance(f"{name}[{i}]", mode, ToolMode) for i, mode in enumerate(listed)]


def _scaled(value: Varying, depth: float, speed: float, shift: float) -> Varying:
    """Return H over angles, less a shift of its entries, as depth H over time."""
    slope = None if value.slope is None else depth * speed * value.slope
    cosines, sines = ([depth * m for m in series] for series in (value.cosines, value.sines))
    return Varying(None, slope, cosines, sines, start=depth * (value.start - shift))


def _over_time(
    cut: PeriodicSystem, depth: float, speed: float, shift: float, *, exactly: bool
) -> list[tuple[Any, Varying]]:
    """Return durations and depth H of pieces; exact durations, which add up to one period however H is cut."""
    return [
        (Fraction(length) / Fraction(speed) if exactly else float(length) / speed, _scaled(value, depth, speed, shift))
        for length, value in cut.pieces
    ]


def _pitch(given: Any, teeth: int) -> tuple[float, ...]:
    """Return the angle in rad from each tooth to the one before it, equal ones where none are given."""
    equal = 2.0 * math.pi / teeth
    angles = _of_each_tooth("pitch", given, teeth, '["70deg", "110deg", "70deg", "110deg"]')
    if not angles:
        return (equal,) * teeth
    total = math.fsum(angles)
    if abs(total - 2.0 * math.pi) > _WHOLE_TURN:
        raise validate.wrong_value(
            "pitch",
            f"must add up to 360 deg, got {math.degrees(total):.6g} deg; a number alone is in rad, "
            f"write {_in_degrees(given)}",
        )
    angles = [angle * (2.0 * math.pi / total) for angle in angles]
    return (equal,) * teeth if max(abs(angle - equal) for angle in angles) < _WHOLE_TURN / teeth else (*angles,)


def _in_degrees(given: Any) -> str:
    """Return how the first pitch is written in degrees."""
    first = next(iter(given))
    return f'"{first:g}deg"' if isinstance(first, int | float) else '"90deg"'


def _runout(given: Any, teeth: int) -> tuple[float, ...]:
    """Return the radii of teeth beyond the shortest one, in m."""
    radii = _of_each_tooth("runout", given, teeth, '["0um", "10um"]') or [0.0] * teeth
    return tuple(radius - min(radii) for radius in radii)


def _of_each_tooth(name: str, given: Any, teeth: int, example: str) -> list[float]:
    """Return a quantity of every tooth in the SI unit, none where none is given."""
    values = validate.sequence(name, given, example)
    if values and len(values) != teeth:
        raise validate.wrong_value(name, f"must have one value for each of {teeth} teeth, got {len(values)}")
    return [CUTTER[name].within_limits(value, f"{name}[{i}]") for i, value in enumerate(values)]


def cutting_by_delay(cutter: Cutter, angle: Floats, lag: float = 0.0) -> Floats:
    """Return the part of H, in Pa, of surfaces left by each of the delays, at angles in rad: (D, ..., n, n).

    With a lag the mean over the edge of helical teeth, whose upper ends come by so many rad later.
    """
    before = np.cumsum([0.0, *cutter.pitch[:-1]]) if cutter.has_variable_pitch else None
    ahead = cutter.pitch[0] * np.arange(cutter.teeth) if before is None else before
    teeth = angle[..., None] + ahead
    teeth = teeth - 2.0 * math.pi * np.floor(teeth / (2.0 * math.pi))
    # Means of sin^2, sin cos and cos^2 over each tooth's edge, where it cuts: of straight teeth the products there.
    sine, cosine = np.sin(teeth), np.cos(teeth)
    delays = np.asarray(cutter.delays)
    cuts = np.zeros((delays.size, 3 if lag > 0.0 else 1, *teeth.shape))
    for arc in cutter.arcs:
        total = cuts[int(np.abs(delays - arc.delay).argmin()), ..., arc.tooth]
        own = teeth[..., arc.tooth]
        if lag > 0.0:
            total += np.stack(of_teeth.means_of_products(own, lag, arc.start, arc.end))
        else:
            total += (own >= arc.start - _EDGE) & (own < arc.end - _EDGE)
    tangential, radial = cutter.tangential, cutter.radial
    if lag > 0.0:
        squares, products, others = (cuts[:, i].sum(axis=-1) for i in range(3))
        along = [
            [tangential * products + radial * squares, tangential * others + radial * products],
            [radial * products - tangential * squares, radial * others - tangential * products],
        ]
    else:
        forces = tangential * cosine + radial * sine, radial * cosine - tangential * sine
        along = [[(cuts[:, 0] * force * thick).sum(axis=-1) for thick in (sine, cosine)] for force in forces]
    axis = [0] * len(cutter.x) + [1] * len(cutter.y)
    rows = [np.stack([along[i][j] for j in axis], axis=-1) for i in axis]
    return np.stack(rows, axis=-2)


@functools.lru_cache(maxsize=256)
def jumps(cutter: Cutter, lag: float = 0.0) -> tuple[float, ...]:
    """Return the angles within a cycle, from 0 on, at which H jumps, or with a lag has a kink."""
    entry, leave = cutter.angles
    alike = not cutter.has_variable_pitch and not any(cutter.runout)
    if alike and lag == 0.0 and abs(entry) < 1e-12 and abs(leave - math.pi) < 1e-12 and cutter.teeth % 2 == 0:
        return ()  # as one tooth leaves another enters, and neither cuts there
    repeated = round(cutter.teeth * cutter.cycle / (2.0 * math.pi))
    ahead = np.cumsum([0.0, *cutter.pitch])
    ends = [
        end - float(ahead[arc.tooth]) + late
        for arc in cutter.arcs
        if arc.tooth < repeated
        for end in (arc.start, arc.end)
        for late in ((0.0, lag) if lag > 0.0 else (0.0,))
    ]
    listed: list[float] = []
    for angle in sorted(end % cutter.cycle for end in ends):
        at = 0.0 if cutter.cycle - angle < 1e-9 else angle
        listed += [] if any(abs(at - other) < 1e-9 for other in listed) else [at]
    return tuple(sorted(listed))


@functools.lru_cache(maxsize=32)
def _expanded(cutter: Cutter, lag: float) -> tuple[PeriodicSystem, tuple[PeriodicSystem, ...], float]:
    """Return H over a cycle in pieces, its part of each delay, and by how much their entries are shifted.

    Shifted, a piece over which H rises from zero is expanded as precisely as H is large elsewhere.
    """
    at = jumps(cutter, lag)
    alike = lag == 0.0 and len(cutter.delays) == 1
    shift = 0.0 if alike else max(cutter.tangential, abs(cutter.radial))

    @functools.cache
    def by_delay(angle: float) -> Floats:
        return cutting_by_delay(cutter, np.asarray(angle), lag)

    def sum_of(chosen: slice) -> PeriodicSystem:
        return PeriodicSystem.from_function(lambda angle: by_delay(angle)[chosen].sum(axis=0) + shift, cutter.cycle, at)

    total = sum_of(slice(None))
    if len(cutter.delays) == 1:
        return total, (total,), shift
    return total, tuple(sum_of(slice(i, i + 1)) for i in range(len(cutter.delays))), shift
