"""How far a string can be pushed into a well, and what a tool that shakes it changes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.content import ByContent
from floquetrod._util.deprecation import Renamed
from floquetrod._util.interchange import by_keys
from floquetrod._util.report import Printed, Report, Table
from floquetrod.rod.answers.growth_along import fastest_along, growth_along
from floquetrod.rod.answers.mean_force import (
    ASSUMED,
    MeanForce,
    drag_of,
    force_in_newtons,
    mean_force,
    mean_forces,
    spans,
)
from floquetrod.rod.answers.sliding import damping_across, least_speed
from floquetrod.rod.answers.stress_along import stress_along
from floquetrod.rod.loads.tool import VibrationTool, tool_inside
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.stress import Stress
from floquetrod.units import AnswerUnits, Unit
from floquetrod.wells import strings
from floquetrod.wells.drag import FAST, SOUGHT, Drag, Effort, Place
from floquetrod.wells.kernels.contact import MOST_PRESSED
from floquetrod.wells.path import WellPath

_DEPTHS = 100  # where none are asked for
_PARTS = (25, 9, 9), (25, 2, 2, 2, 2, 2, 2)
"""Into how many parts what holds a limit sought is divided, one time after the other, without a tool and with it.

Many strings without a tool take hardly longer than one, side by side; with a tool each takes its time.
"""
_ERROR = 5e-4  # of a reach with a tool, measured
_GROWS = 1e-6  # 1/s: tenfold in a month (a choice)
_FREQUENCIES = np.linspace(0.25, 2.0, 22)  # of the tool's, which is among them
_WAY = np.array([0.2, 0.45, 0.7, 0.95])  # fractions of the gain at which they are examined (a choice)
_SPACING = 10.0  # m along the string then (a choice)
_BITS = 12  # depths for which the force at the lower end is sought
_MOST = 10.0  # critical forces, up to which they are tried (a choice: pipes yield before)


@dataclass(frozen=True, eq=False, repr=False)
class Reach(Printed, ByContent):
    """How far a string can be pushed into a well.

    Attributes
    ----------
    path : WellPath
    depth : ndarray (n,)
        Measured depths of the lower end in m.
    injector : ndarray (n,)
        Compression in N at the upper end that it takes to push the lower end there, without a tool; negative for a pull
        that holds it, infinite where it is locked up.
    injector_shaken : ndarray (n,)
        The same with the tool; infinite also where force and wave do not converge, as for a string that locks up.
    bit_depth : ndarray (m,)
        Some of the depths, 12 at most.
    bit : ndarray (m,)
        Greatest compression in N that reaches the lower end there without a tool, the upper end pushed with ``push``;
        NaN where the string does not reach.  Accurate to 4e-4 (S + F^2 / S), up to ``bit_limit``, with the critical
        force S in a level hole.
    bit_shaken : ndarray (m,)
        The same with the tool, accurate to 1e-2 (S + F^2 / S).
    bit_limit : float
        10 S in N: no more is tried at the lower end, and where so much arrives, more may.
    far_force : float
        Compression in N at the lower end.
    push : float
        Greatest compression in N that the upper end can be given, infinite for any.
    reach : float
        Measured depth in m to which the string can be pushed without a tool, at most that of the end of the path.
    reach_shaken : float
        The same with the tool, accurate to some 5e-4 of it (measured).
    is_stopped : bool
        Whether the string without a tool is stopped before the end of the path.
    is_stopped_shaken : bool
        The same with the tool.
    tool : VibrationTool or None
    along : MeanForce
        Along the string with the tool, its lower end as deep as it reaches.
    amplitude : ndarray
        Vibration of the force in N at the depths of ``along``.
    axial_stress : ndarray
        Size of force and vibration over the area of the wall in Pa at the depths of ``along``; infinite where the
        string is locked up.
    bending_stress : ndarray
        E r_o times the curvature of the well and of the helix there, in Pa; waves are taken as bent as a helix.
    yield_strength : float or None
        That of the string in Pa, None where it is not known.
    weight_per_length : float
        Weight of the string in its fluids in N/m.
    sliding : float
        Speed in m/s at which the string slides down.
    growth : ndarray
        Fastest growth in 1/s there of a lateral wave caused by the vibration, whose velocity is that at which the
        string slides, with the rod's damping rate and the friction of a sliding string.  0 where no wave grows, and
        where the mean force has buckled the string.
    growth_free : ndarray
        The same without lateral friction.
    half_wave : ndarray
        Half wave in m that grows fastest, 0 where none grows even without friction.
    speed_to_grow : ndarray
        Lateral velocity in m/s above which a wave grows there against friction; infinite where none does.
    frequencies : ndarray
        Frequencies of the tool in rad/s that were examined.
    frequency_depth : ndarray
        Measured depths in m of the lower end then, on the way from ``reach`` to ``reach_shaken``, 95 % of it the last.
    frequency_growth : ndarray
        Fastest ``growth`` with each of them at any of these depths, mean force and wave those of that frequency;
        infinite where the string is stopped before.
    frequency_speed : ndarray
        Largest axial velocity of the vibration in m/s with each of them; 0 where the string is stopped before.
    """

    path: WellPath
    depth: Floats
    injector: Floats
    injector_shaken: Floats
    bit_depth: Floats
    bit: Floats
    bit_shaken: Floats
    bit_limit: float
    far_force: float
    push: float
    reach: float
    reach_shaken: float
    is_stopped: bool
    is_stopped_shaken: bool
    tool: VibrationTool | None
    along: MeanForce
    amplitude: Floats
    axial_stress: Floats
    bending_stress: Floats
    yield_strength: float | None
    weight_per_length: float
    sliding: float
    growth: Floats
    growth_free: Floats
    half_wave: Floats
    speed_to_grow: Floats
    frequencies: Floats
    frequency_depth: Floats
    frequency_growth: Floats
    frequency_speed: Floats

    kick = Renamed("speed_to_grow", until="0.2")

    @property
    def gain(self) -> float:
        """Increase of the reach by the tool in m; 0 where its size is less than the error of ``reach_shaken``."""
        return _gained(self.reach, self.reach_shaken)

    @property
    def stress(self) -> Stress:
        """The stress where it is largest along the string, its ``position`` from the upper end in m."""
        k = int(np.argmax(self.axial_stress + self.bending_stress))
        position = float(self.along.depth[k] - self.along.depth[0])
        return Stress(float(self.axial_stress[k]), float(self.bending_stress[k]), position, self.yield_strength)

    @property
    def yields(self) -> Bools:
        """Whether the stress exceeds the yield strength at the depths of ``along``; False if that is unknown."""
        strength = math.inf if self.yield_strength is None else self.yield_strength
        return np.asarray(self.axial_stress + self.bending_stress > strength)

    @property
    def stable_frequencies(self) -> tuple[tuple[float, float], ...]:
        """Ranges of the tool's frequency in rad/s, of those examined, with which no lateral wave grows."""
        return tuple(spans(self.frequencies, self.frequency_growth <= _GROWS))

    @property
    def useful_frequencies(self) -> tuple[tuple[float, float], ...]:
        """The ranges of `stable_frequencies` with which the string reaches the last of ``frequency_depth``."""
        is_useful = (self.frequency_growth <= _GROWS) & (self.frequency_speed > self.sliding)
        return tuple(spans(self.frequencies, is_useful))

    def _in_words(self, unit: Unit) -> str:
        end = self.path.end
        text = _reached(self.reach, self.is_stopped, end, unit)
        if self.tool is None:
            return f"can be pushed {text}"
        with_tool = _reached(self.reach_shaken, self.is_stopped_shaken, end, unit)
        return f"can be pushed {text}, and with the tool {with_tool}"

    def report(self, depth: str = "m", force: str = "kN", pressure: str | None = None, frequency: str = "Hz") -> Report:
        """Return the reach, the buckled and the unstable depths, and the force at the upper end.

        Parameters
        ----------
        depth : str
            Unit of depths and lengths, such as "ft".
        force : str
            Unit of forces, such as "lbf".
        pressure : str, optional
            Unit of stresses, such as "psi"; by default MPa, beside pounds ksi.
        frequency : str
            Unit of the tool's frequencies.

        Raises
        ------
        ValueError
            For a unit that is not one of these.
        """
        along = self.along
        shown = AnswerUnits.named(force, depth, pressure, frequency, what=_argument)
        unit = shown.length
        lines = [
            ("string", f"weighs {shown.per_length.show(self.weight_per_length, 4)} in its fluids"),
            ("at", f"{unit.show(along.depth[-1])}, {'with the tool' if self.tool else 'pushed'}:"),
            ("snaking", _listed(along.depth, along.is_snaking, unit)),
            ("helix", _listed(along.depth, along.is_helix, unit)),
        ]
        lines += self._stress_lines(shown)
        if self.tool is not None:
            lines += [("tool", self._vibration_in_words(shown)), ("grows", self._growth_in_words(shown))]
            lines.append((f"tool {shown.frequency.name}", self._frequency_in_words(shown)))
        lines.append(("assumed", "; ".join(self.assumptions_in(shown.speed))))
        return Report(self._in_words(unit), lines, self._table(shown))

    @property
    def assumptions(self) -> tuple[str, ...]:
        """The assumptions, speeds in m/s."""
        return self.assumptions_in(units.unit("m/s", "", "speed"))

    def assumptions_in(self, speed: Unit) -> tuple[str, ...]:
        """Return what is assumed, speeds in a unit."""
        local = (
            "growth is that of a long string under the force at each depth, with the rod's damping and with friction, "
            f"which damps a lateral wave less if it moves faster: here {speed.show(self.sliding, 3)}"
        )
        more = (local,) if self.tool else ()
        return (*ASSUMED, *more, "linear elasticity, beyond yield too; stress with equal pressures inside and outside")

    def _stress_lines(self, shown: AnswerUnits) -> list[tuple[str, str]]:
        stress, depth, unit = self.stress, self.along.depth, shown.length
        lines = [("stress", f"{stress.in_words(shown.pressure)}; at {unit.show(depth[0] + stress.position)}")]
        return [*lines, ("yields", _listed(depth, self.yields, unit))] if self.yields.any() else lines

    def _vibration_in_words(self, shown: AnswerUnits) -> str:
        least, most = self.along.friction.min(), shown.force.show(self.amplitude.max(), 3)
        tool = "" if self.tool is None else f"{self.tool.in_words(shown)}: "
        return f"{tool}vibration of at most {most}, which reduces friction to {least:.3g}"

    def _growth_in_words(self, shown: AnswerUnits) -> str:
        grows, unit = self.growth > _GROWS, shown.length
        if not grows.any():
            return f"no lateral wave: {self._held_in_words(shown)}"
        k = int(np.argmax(self.growth))
        return (
            f"{_listed(self.along.depth, grows, unit)}: {self.growth[k]:.3g} 1/s at {unit.show(self.along.depth[k])} "
            f"in half waves of {unit.show(self.half_wave[k], 3)}"
        )

    def _held_in_words(self, shown: AnswerUnits) -> str:
        """Which lateral waves friction holds back."""
        k = int(np.argmin(self.speed_to_grow))
        if not math.isfinite(self.speed_to_grow[k]):
            return "none would, however fast it moves"
        moves, at = shown.speed.show(self.speed_to_grow[k], 3), shown.length.show(self.along.depth[k])
        return f"one that moves at {moves} would, at {at}"

    def _frequency_in_words(self, units_of: AnswerUnits) -> str:
        """With which frequencies the tool gains depth while no lateral wave grows."""
        if not self.gain > 0.0:
            return "the tool gains no depth at its own frequency"
        shown, every, depth = units_of.frequency, self.frequencies, self.frequency_depth
        looked = (
            f"of {every.size} from {shown.of(every[0]):.3g} to {shown.show(every[-1], 3)}, with the string at "
            f"{depth.size} depths from {units_of.length.of(depth[0]):.5g} to {units_of.length.show(depth[-1], 5)}"
        )
        ranges = ", ".join(f"{_range(shown.of(a), shown.of(b))} {shown.name}" for a, b in self.useful_frequencies)
        if ranges:
            return f"no lateral wave grows with {ranges}, {looked}"
        k = int(np.argmin(self.frequency_growth))
        least = f", most slowly with {shown.show(every[k], 3)}, at {self.frequency_growth[k]:.3g} 1/s"
        reached = np.count_nonzero(np.isfinite(self.frequency_growth))
        if not reached:
            return f"the string reaches them with none, {looked}"
        return f"lateral waves grow with all {reached} with which the string reaches them{least}, {looked}"

    def _table(self, shown: AnswerUnits) -> Table:
        depth, force = shown.length, shown.force
        rows = np.searchsorted(self.depth, self.bit_depth)
        names = (f"injector {force.name}", f"lower end {force.name}"), (f"with tool {force.name}",) * 2
        forces = (self.injector[rows], self.bit), (self.injector_shaken[rows], self.bit_shaken)
        kept = range(2 if self.tool else 1)
        columns = [(f"depth {depth.name}", ">9"), *((names[k][i], ">12") for i in range(2) for k in kept)]
        texts = [
            [f"{'>' if i and self.is_limited(each) else ''}{_force(each, force)}" for each in forces[k][i].tolist()]
            for i in range(2)
            for k in kept
        ]
        where = [f"{each:.0f}" for each in depth.of(self.bit_depth)]
        limited = any(self.is_limited(forces[k][1]).any() for k in kept)
        rest = f"> at the lower end: more may arrive, no more than {_MOST:g} critical forces of a level hole was tried"
        return Table(columns, list(zip(where, *texts, strict=True)), rest if limited else "")

    def is_limited(self, force: Any) -> NDArray[np.bool_]:
        """Return whether forces in N at the lower end are the largest that was tried, so that more may arrive there."""
        return np.asarray(np.asarray(force) >= (1.0 - 1e-9) * self.bit_limit)

    def as_dict(self) -> dict[str, Any]:
        """Return everything as numbers for JSON, units in the keys; None where a force is infinite."""
        with_tool = self if self.tool else None
        return {
            **by_keys(self, "depth_m injector_N"),
            **by_keys(with_tool, "injector_with_tool_N=injector_shaken"),
            **by_keys(self, "bit_depth_m bit_N"),
            **by_keys(with_tool, "bit_with_tool_N=bit_shaken"),
            **by_keys(self, "bit_limit_N far_force_N push_N reach_m is_stopped"),
            **by_keys(with_tool, "reach_with_tool_m=reach_shaken is_stopped_with_tool=is_stopped_shaken"),
            **by_keys(
                self,
                "tool along amplitude_N axial_stress_Pa bending_stress_Pa stress growth_per_s "
                "growth_without_friction_per_s=growth_free half_wave_m speed_to_grow_m_per_s "
                "weight_N_per_m=weight_per_length sliding_m_per_s frequencies_rad_per_s frequency_depth_m "
                "growth_by_frequency_per_s=frequency_growth speed_by_frequency_m_per_s=frequency_speed "
                "useful_frequencies_rad_per_s assumptions",
            ),
        }

    def plot(
        self,
        figure: Any = None,
        *,
        depth: str = "m",
        force: str = "kN",
        pressure: str | None = None,
        frequency: str = "Hz",
    ) -> Any:
        """Draw the section of the well, the force at the injector, and the results along the string.

        Draws into a figure or subfigure of matplotlib, a new one by default, which is returned; in the units of
        `report`.
        """
        from floquetrod.plotting.reach import draw_reach

        shown = AnswerUnits.named(force, depth, pressure, frequency, what=_argument)
        return draw_reach(self, shown, self._in_words(shown.length), figure)


def _argument(name: str) -> str:
    """Return how `Reach.report` calls a unit."""
    return {"length": "depth"}.get(name, name)


def _reached(depth: float, is_stopped: bool, end: float, unit: Unit) -> str:
    if is_stopped:
        return f"to {unit.show(depth, 5)}"
    return (
        f"to the end of the well at {unit.show(end)}"
        if depth >= end
        else f"to {unit.show(depth)}, the deepest asked for"
    )


def _listed(depth: Floats, is_so: Bools, unit: Unit) -> str:
    found = [(f"{unit.of(a):.4g}", unit.show(b, 4)) for a, b in spans(depth, is_so)]
    return ", ".join(f"{a} to {b}" if a != b.split()[0] else f"at {b}" for a, b in found) or "nowhere"


def _range(low: float, high: float) -> str:
    """Return the ends of a range, or its only number."""
    return f"{low:.3g} to {high:.3g}" if high > low else f"{low:.3g}"


def _force(force: float, unit: Unit) -> str:
    """Return a force to about 10 N."""
    digits = max(0, round(math.log10(unit.size / 10.0)))
    return f"{unit.of(force):.{digits}f}" if math.isfinite(force) else "locked" if math.isinf(force) else "-"


def reach(
    rod: RodData,
    path: Any,
    friction: Any,
    helical: Any,
    tool: VibrationTool | None,
    speed: Any,
    ends: tuple[Any, Any],
    depth: Any,
) -> Reach:
    """Return what `Rod.reach` does; ``ends`` are the force at the lower end and the greatest at the upper one."""
    drag = drag_of(rod, path, friction, "pushed", helical, tool, speed)
    if tool is not None:
        tool_inside(tool, path.end - path.start, "string")
    far_force = force_in_newtons("far_force", ends[0])
    push = math.inf if ends[1] is None else force_in_newtons("push", ends[1])
    depths = depths_of(path, depth)
    still = replace(drag, shaking=None)
    searches = [_Search(each, far_force, push) for each in ([still, drag] if tool else [still])]
    forces = [search.injector(depths, far_force) for search in searches]
    few = np.unique(np.linspace(0, depths.size - 1, _BITS).round().astype(int))
    limits = [search.limits(depths, each, few) for search, each in zip(searches, forces, strict=True)]
    reached, bits = zip(*limits, strict=True)
    along = mean_force(drag, far_force, _standing_end(path, *reached[-1]), None)
    sliding = 0.0 if drag.shaking is None else drag.shaking.speed
    grown = _grown(rod, drag, along, tool)
    (without, _), (shaken, _) = reached[0], reached[-1]
    others = _with_others(rod, drag, far_force, without + _WAY * _gained(without, shaken))
    stress = stress_along(rod, path, along, along.vibration)
    return Reach(
        path=path,
        depth=depths,
        injector=forces[0],
        injector_shaken=forces[-1],
        bit_depth=depths[few],
        bit=bits[0],
        bit_shaken=bits[-1],
        bit_limit=_MOST * drag.pipe.scale,
        far_force=far_force,
        push=push,
        reach=reached[0][0],
        reach_shaken=reached[-1][0],
        is_stopped=reached[0][1],
        is_stopped_shaken=reached[-1][1],
        tool=tool,
        along=along,
        amplitude=along.vibration,
        axial_stress=stress.axial,
        bending_stress=stress.bending,
        yield_strength=rod.yield_strength,
        weight_per_length=rod.weight_per_length,
        sliding=sliding,
        growth=grown.net,
        growth_free=grown.free,
        half_wave=grown.half_wave,
        speed_to_grow=grown.least_speed,
        frequencies=others.frequency,
        frequency_depth=others.depth,
        frequency_growth=others.growth,
        frequency_speed=others.speed,
    )


def depths_of(path: WellPath, depth: Any) -> Floats:
    """Return the measured depths of the lower end that are asked for, increasing."""
    if depth is None:
        return np.linspace(path.start, path.end, _DEPTHS + 1)[1:]
    given = units.lengths("depth", depth)
    asked = np.unique(validate.array("depth", given, least=0.0, largest=1e6))
    if not asked.size or asked[0] < path.start + 1e-6 or asked[-1] > path.end + 1e-6:
        written = depth[-1] if isinstance(depth, list | tuple) and depth else depth
        name = units.unit_of(written) if isinstance(written, str) else None
        unit = units.unit(name or "m", "depth", "length")
        wrong = "none" if not asked.size else unit.show(asked[-1] if asked[-1] > path.end else asked[0])
        ends = f"{unit.of(path.start):.6g} to {unit.show(path.end)}"
        raise validate.wrong_value(
            "depth", f"must lie below the start of the path and down to its end, {ends}, got {wrong}"
        )
    return np.minimum(asked, path.end)


def _gained(without: float, shaken: float) -> float:
    """Return by how much a reach with a tool exceeds that without, 0 where its error may make all of that."""
    return shaken - without if abs(shaken - without) > _ERROR * shaken else 0.0


def _standing_end(path: WellPath, depth: float, is_stopped: bool) -> float:
    """Return a depth at which the string is not locked up yet, to rounding of the search."""
    return float(max(depth - 1e-3 * (depth - path.start), path.start + 1e-6)) if is_stopped else depth


@dataclass(frozen=True)
class _Search:
    """Pushes strings as far as they go."""

    drag: Drag
    far_force: float
    push: float

    def injector(self, bottoms: Floats, far_force: Any, effort: Effort = FAST) -> Floats:
        """Return the compression in N at the upper end of strings to measured depths, infinite where one is stopped."""
        found = strings.run(self.drag, self.drag.path.start, bottoms, far_force, np.empty(0), effort)
        return np.where(found.is_settled, self.drag.force(found.top_y), math.inf)

    def goes(self, force: Floats) -> Bools:
        """Return whether strings that need a force at the upper end are not stopped."""
        return np.isfinite(force) & (force <= self.push)

    def limits(self, depths: Floats, forces: Floats, few: NDArray[np.intp]) -> tuple[tuple[float, bool], Floats]:
        """Return how deep the lower end reaches and whether it is stopped there, from the forces of ``injector``.

        And the greatest compression in N at the lower end at a ``few`` of the depths, NaN where no string arrives.
        """
        goes, bit, scale = self.goes(forces), np.full(few.size, math.nan), self.drag.pipe.scale
        there, stopped = few[goes[few]], np.flatnonzero(~goes)[:1]
        before = np.append(self.drag.path.start, depths)[stopped]
        y = float(self.drag.y_of(np.array(self.far_force)))
        low, high = np.full((2, 2, there.size + stopped.size), y)
        low[0], high[0] = np.append(depths[there], before), np.append(depths[there], depths[stopped])
        high[1, : there.size] = max(y, math.atan(_MOST))
        if low.size:
            low, high = self._narrowed(low, high)
        found = 0.5 * (low + high)
        bit[goes[few]] = scale * np.tan(found[1, : there.size])
        return (float(found[0, -1]), True) if stopped.size else (float(depths[-1]), False), bit

    def _narrowed(self, low: Floats, high: Floats) -> tuple[Floats, Floats]:
        """Return what is between strings that go and those that are stopped, depths and y of lower ends in rows."""
        for k, parts in enumerate(_PARTS[self.drag.shaking is not None]):
            steps = np.linspace(low, high, parts + 1, axis=1)
            bottoms, y = steps[:, 1:] if k == 0 else steps[:, 1:-1]
            force = self.injector(bottoms.ravel(), self.drag.pipe.scale * np.tan(y.ravel()), SOUGHT)
            last = np.cumprod(self.goes(force).reshape(y.shape), axis=0).sum(axis=0)
            each = np.arange(last.size)
            low, high = steps[:, last, each], steps[:, np.minimum(last + 1, parts), each]
        return low, high


class _Grown(NamedTuple):
    """What grows along a string, see `Reach`."""

    net: Floats
    free: Floats
    half_wave: Floats
    least_speed: Floats


def _grown(rod: RodData, drag: Drag, along: MeanForce, tool: VibrationTool | None) -> _Grown:
    """Return what grows along a string with a tool."""
    size = along.depth.size
    none = np.zeros((3, size))
    found = _Grown(none[0], none[1], none[2], np.full(size, math.inf))
    chosen = np.flatnonzero(~along.is_snaking & np.isfinite(along.force) & (along.vibration > 0.0))
    if tool is None or drag.shaking is None or not chosen.size:
        return found
    some = _Places.of(rod, drag, along, chosen)
    found.free[chosen], found.half_wave[chosen] = growth_along(
        rod, some.place, some.force, some.vibration, tool.frequency
    )
    found.net[chosen] = np.maximum(found.free[chosen] - some.lost, 0.0)
    found.least_speed[chosen] = least_speed(found.free[chosen], some.pressed, drag.shaking.speed, some.speed)
    return found


class _Places(NamedTuple):
    """Places along a string, what shakes it there, and what friction takes from waves across in 1/s."""

    place: Place
    force: Floats
    speed: Floats
    vibration: Floats
    pressed: Floats
    lost: Floats

    @classmethod
    def of(cls, rod: RodData, drag: Drag, along: MeanForce, chosen: NDArray[np.intp]) -> _Places:
        """Return some places of a string that slides; mu N is over its mass per length, in m/s^2."""
        depth, speed = along.depth[chosen], along.speed[chosen]
        contact = np.minimum(along.contact[chosen], MOST_PRESSED * rod.weight_per_length)
        pressed = drag.friction.at(depth) * contact / rod.mass_per_length
        sliding = 0.0 if drag.shaking is None else drag.shaking.speed
        lost = damping_across(pressed, sliding, speed, np.full(chosen.size, sliding))
        place = Place.at(drag.path.arcs.at(depth))
        return cls(place, along.force[chosen], speed, along.vibration[chosen], pressed, lost)

    @classmethod
    def joined(cls, several: Sequence[_Places]) -> _Places:
        """Return several one after the other."""
        place, *others = zip(*several, strict=True)
        return cls(Place(*map(np.concatenate, zip(*place, strict=True))), *map(np.concatenate, others))


class _Others(NamedTuple):
    """Frequencies of a tool in rad/s, depths of a string in m; the fastest growth in 1/s and largest speed in m/s."""

    frequency: Floats
    depth: Floats
    growth: Floats
    speed: Floats


def _with_others(rod: RodData, drag: Drag, far_force: float, depth: Floats) -> _Others:
    """Return what a string to measured depths in m would do with other frequencies of its tool."""
    if drag.shaking is None or not depth[-1] > depth[0]:
        return _Others(np.empty(0), np.empty(0), np.empty(0), np.empty(0))
    frequency = drag.shaking.frequency * _FREQUENCIES
    frequency = frequency[frequency <= strings.highest_frequency(drag.shaking, depth[-1] - drag.path.start)]
    one, bottom = (each.ravel() for each in np.meshgrid(frequency, depth, indexing="ij"))
    together = replace(drag, shaking=replace(drag.shaking, frequency=one))
    growth, speed = np.full(one.size, math.inf), np.zeros(one.size)
    some, string = [], []
    for k, along in enumerate(mean_forces(together, far_force, bottom, _SPACING)):
        if along is not None:
            growth[k], speed[k] = 0.0, along.speed.max()
            some.append(_Places.of(rod, together, along, np.flatnonzero(~along.is_snaking & (along.vibration > 0.0))))
            string.append(np.full(some[-1].force.size, k))
    if some:
        all_, of = _Places.joined(some), np.concatenate(string)
        grows = fastest_along(rod, all_.place, all_.force, all_.vibration, one[of], all_.lost, of)
        np.maximum.at(growth, of, grows)
    growth, speed = (each.reshape(frequency.size, depth.size) for each in (growth, speed))
    return _Others(frequency, depth, growth.max(axis=1), speed.min(axis=1))
