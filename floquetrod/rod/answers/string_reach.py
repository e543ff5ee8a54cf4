"""How far a string can be pushed into a well, and what a tool that shakes it changes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent
from floquetrod._util.interchange import by_keys
from floquetrod._util.result_report import Printed, Report, Table
from floquetrod.rod.answers.assembly import (
    StringCells,
    at_the_wellhead,
    cells_of,
    deepest_of,
    name_of,
    reference_strength,
    require_depth,
    require_tube,
    weakness,
)
from floquetrod.rod.answers.growth_along import fastest_along, growth_along
from floquetrod.rod.answers.growth_of_two_sines import MOST_PLACES, growth_of_two_sines
from floquetrod.rod.answers.mean_force import (
    ASSUMED,
    MeanForce,
    bend_in_words,
    drag_of,
    force_in_newtons,
    harmonics_in_words,
    mean_forces,
    spans,
)
from floquetrod.rod.answers.pushing import (
    ASKED,
    END,
    LENGTH,
    LOCK_UP,
    MOST_FORCE,
    PUSH,
    RESOLUTION,
    STATICS,
    YIELD,
    Limits,
    Pushing,
    Reached,
    stress_limit,
)
from floquetrod.rod.answers.sliding import damping_across, least_speed
from floquetrod.rod.answers.stress_along import excess_inside
from floquetrod.rod.loads.tool import VibrationTool, tool_inside
from floquetrod.rod.model.cross_section import CrossSection
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.stress import Stress
from floquetrod.rod.model.wellhead import Wellhead
from floquetrod.units import AnswerUnits, Unit
from floquetrod.wells import strings
from floquetrod.wells.drag import CHECKED, SOUGHT, Drag, Friction, WellGeometry
from floquetrod.wells.helix_criteria import HELIX_RULES
from floquetrod.wells.kernels.wall_contact import MOST_PRESSED
from floquetrod.wells.path import WellPath

_DEPTHS = 100  # where none are asked for
_ERROR = 5e-4  # of a reach with a tool, measured
_FEW = 3  # lengths of a string that are listed one by one (a choice)
_SAID = 5e-3  # error over the growth, from which words have it: they have three digits
_GROWS = 1e-6  # 1/s: tenfold in a month (a choice)
_FIFTHS = 5  # of a depth still unknown, tried at once (a choice)
_FREQUENCIES = np.linspace(0.25, 2.0, 22)  # of the tool's, which is among them
_WAY = np.array([0.2, 0.45, 0.7, 0.95])  # fractions of the gain at which they are examined (a choice)
_SPACING = 10.0  # m along the string then (a choice)
_BITS = 12  # depths for which the force at the lower end is sought
_FREE_PHASES = (
    "the phases of the tool's two frequencies are independent; friction is a mean over both, and damps each wave by "
    "its component at the frequency of that wave; stress is that of the sum of both amplitudes"
)
_SPEEDS = np.array([0.4, 1.0, 4.0])  # of the speed of sliding, at which a tool's gain is told


@dataclass(frozen=True, eq=False, repr=False)
class Reach(units.InUnits, Printed, ByContent):
    """How far a string can be pushed into a well.

    Attributes
    ----------
    path : WellPath
    depth : ndarray (n,)
        Measured depths of the lower end in m.
    injector : ndarray (n,)
        Compression in N at the injector that it takes to push the lower end there, without a tool; negative for a pull
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
        Greatest compression in N that the injector gives, infinite for any.
    wellhead : Wellhead
        Pressures in Pa at the wellhead and friction of its stripper in N.
    wellhead_force : float
        Compression in N at the injector beyond the effective one below the stripper.
    yield_share : float or None
        Share of the yield strength that the stress may have anywhere along the string, None for any.  It limits nothing
        where ``yield_strength`` is None.
    reach : float
        Greatest measured depth in m to which the string can be pushed without a tool, through all depths before, within
        ``push`` and ``yield_share``; at most the deepest asked for.  `Rod.mean_force` is finite there, and where the
        string is stopped it is so no farther below than 1e-6 of the length of the path.
    reach_shaken : float
        The same with the tool, whose stress counts deeper than ``reach`` alone: before, it need not run.  Some 5e-4 of
        it are not known (measured), and a string that is stopped and goes on again between two of the depths examined,
        which are a hundredth of the path apart at most, is not seen to be.
    limit : str
        What limits ``reach``: "lock-up", "yield", "push", "end of the well", "length of the string" or "deepest asked
        for".
    limit_shaken : str
        The same with the tool.
    lock_up : float
        Measured depth in m at which the string locks up by statics alone, whatever its stress and the push;
        infinite where it does not, down to the deepest asked for.
    lock_up_shaken : float
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
    largest_stress : ndarray
        Von Mises' stress there in Pa at the inner or the outer radius, the sum of both where the pressures inside and
        outside are taken as equal.
    yield_strength : float or None
        That of the string in Pa, of several sections the largest; None where it is not known.
    weight_per_length : float
        Weight of the string in its fluids in N/m.
    fluids : tuple of float
        Densities in kg/m^3 of the fluids inside and outside, 0 for none.
    sliding : float
        Speed in m/s at which the string slides down.
    growth : ndarray
        Fastest growth in 1/s there of a lateral wave caused by the vibration, whose velocity is that at which the
        string slides, with the rod's damping rate and the friction of a sliding string.  0 where no wave grows, and
        where the mean force has buckled the string.  NaN, as the four that follow, with a tool of two frequencies
        so far apart, in so long a string, that it would take minutes.
    growth_free : ndarray
        The same without lateral friction.
    growth_error : ndarray or None
        Estimated error of both in 1/s with a tool of two frequencies: of the periodic approximants and of the search
        among waves, not of the mean force, the friction and the vibration.  None with one frequency.
    half_wave : ndarray
        Half wave in m that grows fastest, 0 where none grows even without friction.
    speed_to_grow : ndarray
        Lateral velocity in m/s above which a wave grows there against friction; infinite where none does.  With two
        frequencies above which one may, by ``growth_free`` and its error.
    frequencies : ndarray
        Frequencies of the tool in rad/s that were examined; none of a tool of two.
    frequency_depth : ndarray
        Measured depths in m of the lower end then, on the way from ``reach`` to ``reach_shaken``, 95 % of it the last.
    frequency_growth : ndarray
        Fastest ``growth`` with each frequency at any of these depths, under its own mean force and wave;
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
    wellhead: Wellhead
    wellhead_force: float
    yield_share: float | None
    reach: float
    reach_shaken: float
    limit: str
    limit_shaken: str
    lock_up: float
    lock_up_shaken: float
    tool: VibrationTool | None
    along: MeanForce
    amplitude: Floats
    axial_stress: Floats
    bending_stress: Floats
    largest_stress: Floats
    yield_strength: float | None
    weight_per_length: float
    fluids: tuple[float, float]
    sliding: float
    growth: Floats
    growth_free: Floats
    growth_error: Floats | None
    half_wave: Floats
    speed_to_grow: Floats
    frequencies: Floats
    frequency_depth: Floats
    frequency_growth: Floats
    frequency_speed: Floats
    _pushing: Pushing = field(compare=False)
    _limits: Limits = field(compare=False)

    @property
    def rod(self) -> RodData:
        """The rod whose section or sections the string has."""
        return self._pushing.rod

    @property
    def friction(self) -> Friction:
        """Friction with the wall."""
        return self._pushing.drag.friction

    @property
    def is_stopped(self) -> bool:
        """Whether the string without a tool is stopped before the deepest depth asked for."""
        return self.limit not in (END, LENGTH, ASKED)

    @property
    def is_stopped_shaken(self) -> bool:
        """The same with the tool."""
        return self.limit_shaken not in (END, LENGTH, ASKED)

    @property
    def speeds(self) -> Floats:
        """Speeds of sliding in m/s, 0.4, 1 and 4 times ``sliding``, (3,); empty without a tool."""
        return self.sliding * _SPEEDS if self.tool else np.empty(0)

    @cached_property
    def reach_at_speeds(self) -> Floats:
        """``reach_shaken`` while the string slides at each of ``speeds``; computed when it is first asked for."""
        shaking = self._pushing.drag.shaking
        depth = np.full(self.speeds.size, self.reach_shaken)
        for k in np.flatnonzero(self.speeds != self.sliding):
            if shaking is not None:
                drag_at_speed = replace(self._pushing.drag, shaking=replace(shaking, speed=float(self.speeds[k])))
                string = replace(self._pushing, drag=drag_at_speed)
                depth[k] = string.reached(float(self.depth[-1]), self._limits).depth
        return depth

    @cached_property
    def reach_at_frequencies(self) -> Floats:
        """Reach in m with the tool at each of ``frequencies``; computed when it is first asked for.

        NaN where ``frequency_growth`` is infinite: the string is stopped before.  Some 1e-3 of it are not known, and a
        string that is stopped and goes on again between two fifths of the rest of the well is not seen to be.
        """
        reach = np.full(self.frequencies.size, math.nan)
        chosen = np.flatnonzero(np.isfinite(self.frequency_growth))
        drag = self._pushing.drag
        if drag.shaking is None or not chosen.size:
            return reach
        # A string goes to ``low`` and is stopped at ``high``, frequency by frequency.
        low = np.full(chosen.size, float(self.frequency_depth[-1]))
        high, columns = np.maximum(low, float(self.depth[-1])), np.arange(chosen.size)
        while (high - low > _ERROR * high).any():
            depth = np.linspace(low, high, _FIFTHS + 1)
            frequency = np.broadcast_to(self.frequencies[chosen], depth[1:].shape).ravel()
            string = replace(self._pushing, drag=replace(drag, shaking=replace(drag.shaking, frequency=frequency)))
            goes = string.pushed(depth[1:].ravel(), SOUGHT, self._limits).within(self._limits)
            last = np.cumprod(goes.reshape(depth[1:].shape), axis=0).sum(axis=0)
            low, high = depth[last, columns], depth[np.minimum(last + 1, _FIFTHS), columns]
        reach[chosen] = low
        reach[np.isclose(self.frequencies, drag.shaking.frequency)] = self.reach_shaken
        return reach

    @cached_property
    def _injector_at_reach(self) -> tuple[float, float]:
        """Measured depth in m, ``reach`` or a little above lock-up, and compression in N at the injector there.

        Without a tool.
        """
        string = replace(self._pushing, drag=replace(self._pushing.drag, shaking=None), passed=-math.inf)
        bottom = string.shown_at(Reached(self.reach, self.limit))
        return bottom, float(string.pushed(np.array([bottom]), CHECKED[0], STATICS).force[0])

    @property
    def gain_at_speeds(self) -> Floats:
        """Increase of the reach by the tool in m, while the string slides at each of ``speeds``."""
        return np.array([_gained(self.reach, float(reach)) for reach in self.reach_at_speeds])

    @property
    def gain(self) -> float:
        """Increase of the reach by the tool in m; 0 where its size is less than the error of ``reach_shaken``."""
        return _gained(self.reach, self.reach_shaken)

    @property
    def stress(self) -> Stress:
        """The stress where it is largest along the string, its ``position`` from the upper end in m."""
        k, strength = self._most_stressed, self.yield_strength
        if self.along.section is not None:
            strength = self.rod.sections[self.along.section[k]].yield_strength
        position = float(self.along.depth[k] - self.along.depth[0])
        parts = float(self.axial_stress[k]), float(self.bending_stress[k])
        excess = excess_inside(self._pushing.rod, self.path, self.along.depth[k : k + 1], self.wellhead)
        if excess is None:
            return Stress(*parts, position, strength)
        return Stress(*parts, position, strength, float(excess[0]), float(self.largest_stress[k]))

    @property
    def _most_stressed(self) -> int:
        """Place along the string whose stress is nearest to yield."""
        return int(np.argmax(self._referred_stress))

    @property
    def _referred_stress(self) -> Floats:
        """Stress along the string in Pa, times the largest yield strength over the section's there."""
        return np.asarray(weakness(self.rod, cells_of(self.rod, self.along)) * self.largest_stress)

    @property
    def limiting_section(self) -> int | None:
        """Number of the section, from the upper end, that limits how deep the string goes, with the tool if it has one.

        At yield the section whose stress is nearest to it; at lock-up that whose helix takes most friction.  None where
        neither limits the reach, where no helix is seen just above lock-up, and of a string of one section.
        """
        along, section = self.along, self.along.section
        if section is None or self.limit_shaken not in (YIELD, LOCK_UP):
            return None
        if self.limit_shaken == YIELD:
            return int(section[self._most_stressed])
        cells, force = cells_of(self.rod, along), np.where(np.isfinite(along.force), along.force, 0.0)
        pressed = force**2 * cells.column("radial_clearance") / (4.0 * cells.column("flexural_rigidity"))
        rubs = np.bincount(section, np.where(along.is_helix, along.friction * pressed, 0.0) * np.gradient(along.depth))
        return int(np.argmax(rubs)) if rubs.any() else None

    def _limiting_in_words(self, unit: Unit) -> str:
        """Return the section that limits the reach, and where; "" for none."""
        number, along = self.limiting_section, self.along
        if number is None or along.section is None:
            return ""
        name = name_of(self.rod, number)
        if self.limit_shaken == YIELD:
            return f"{name} at {far(along.depth[self._most_stressed], unit)} {unit.name}"
        return f"{name} {_listed(along.depth, along.is_helix & (along.section == number), unit, 'from ')}"

    @property
    def yields(self) -> Bools:
        """Whether the stress exceeds the yield strength at the depths of ``along``; False if that is unknown."""
        strength = math.inf if self.yield_strength is None else self.yield_strength
        return np.asarray(self._referred_stress > strength)

    @property
    def stable_frequencies(self) -> tuple[tuple[float, float], ...]:
        """Ranges of the tool's frequency in rad/s, of those examined, with which no lateral wave grows."""
        return tuple(spans(self.frequencies, self.frequency_growth <= _GROWS))

    @property
    def useful_frequencies(self) -> tuple[tuple[float, float], ...]:
        """The ranges of `stable_frequencies` with which the string reaches the last of ``frequency_depth``."""
        is_useful = (self.frequency_growth <= _GROWS) & (self.frequency_speed > self.sliding)
        return tuple(spans(self.frequencies, is_useful))

    def _in_words(self, shown: AnswerUnits) -> str:
        """Return the answer: how far the string goes or, with a tool, whether that helps."""
        unit = shown.length
        goes = f"{far(self.reach, unit)} {unit.name}{self._ended(self.reach, self.limit, self.lock_up, shown)}"
        if self.tool is None:
            return f"How far does the string go? To {goes}."
        if not self.is_stopped:
            return f"Does the tool help? It is not needed: without it the string goes to {goes}."
        if self.gain == 0.0:
            speed = shown.speed.show(self.sliding, 3)
            return f"Does the tool help? No, not at a sliding speed of {speed}: {goes}, with it and without it."
        gained = far(self.reach_shaken, unit, less=self.reach)
        text = f"{far(self.reach_shaken, unit)} {unit.name} instead of {far(self.reach, unit)} ({gained} {unit.name})"
        ended = self._ended(self.reach_shaken, self.limit_shaken, self.lock_up_shaken, shown)
        if not self.gain > 0.0:
            return f"Does the tool help? No: {text}{ended}."
        return f"Does the tool help? Yes, sliding at {shown.speed.show(self.sliding, 3)}: {text}{ended}."

    def _ended(self, depth: float, limit: str, lock_up: float, shown: AnswerUnits) -> str:
        """Return what limits a reach, and the depth that would be reached whatever the stress and the push."""
        limiting = self._limiting_in_words(shown.length)
        if limit in (YIELD, PUSH):
            is_end = math.isinf(lock_up)
            farther = min(lock_up, float(self.depth[-1]))
            ended = f", {self._end_at(farther)}" if is_end else ""
            beyond = f"{far(farther, shown.length)}{ended}"
            of_section = f" of {limiting}" if limiting and limit == YIELD else ""
            why = {
                YIELD: f", within {self._percent} of yield{of_section}; not within it: ",
                PUSH: f", with {shown.force.show(self.push, 4)} at the surface; with more: ",
            }
            return why[limit] + beyond
        return {
            LOCK_UP: f", where it locks up{f', most by the helix of {limiting}' if limiting else ''}",
            END: ", the end of the well",
            LENGTH: ", the length of the string",
            ASKED: ", the deepest depth asked for",
        }[limit]

    def _end_at(self, depth: float) -> str:
        """Return the name of the end of the search that a depth is at, empty above it."""
        if depth < self.depth[-1] - 1e-9 * self.path.end:
            return ""
        if depth >= self.path.end:
            return "the end of the well"
        return "the length of the string" if depth >= deepest_of(self.rod, self.path) else "the deepest depth asked for"

    @property
    def _percent(self) -> str:
        return f"{100.0 * (self.yield_share or 0.0):.3g} %"

    def report(
        self,
        depth: str | None = None,
        force: str | None = None,
        pressure: str | None = None,
        frequency: str | None = None,
    ) -> Report:
        """Return the reach, the buckled and the unstable depths, and the force at the upper end.

        Parameters
        ----------
        depth : str, optional
            Unit of depths and lengths, such as "ft"; by default each quantity has the unit in which it was given, see
            `floquetrod.units.AnswerUnits`, else m, kN, MPa and Hz.
        force : str, optional
            Unit of forces, such as "lbf".
        pressure : str, optional
            Unit of stresses, such as "psi".
        frequency : str, optional
            Unit of the tool's frequencies.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.

        Raises
        ------
        ValueError
            For a unit of another kind.
        """
        along = self.along
        shown = self._units(force, depth, pressure, frequency)
        unit = shown.length
        lines = [
            ("string", weight_in_words(self.weight_per_length, self.fluids, shown, is_mean=bool(self.rod.sections))),
            ("limit", self._limit_in_words(shown)),
            ("lock-up", self._lock_up_in_words(shown)),
            *self._error_lines(unit),
        ]
        if self.wellhead_force:
            lines.append(("wellhead", self.wellhead.in_words(self._at_wellhead, "pushed", shown)))
        if self.along.end_contact:
            pressed = bend_in_words(shown.force.show(self.along.end_contact, 3))
            sections = self.rod.sections or (self.rod,)
            bent = max(each.youngs_modulus * each.radius for each in sections) * self.rod.residual_curvature
            bending = shown.pressure.show(bent, 3)
            lines.append(("bend", f"{pressed}; held straight it adds {bending} of bending stress"))
        lines += [("speed", self._speeds_in_words(shown))] if self.tool else []
        pushed = f"pushed to {far(along.depth[-1], unit)} {unit.name}{' with the tool' * (self.tool is not None)}"
        lines.append(("snaking", f"{_listed(along.depth, along.is_snaking, unit)} when {pushed}"))
        rule = HELIX_RULES[self._pushing.drag.helical]
        lines.append(("helix", f"{_listed(along.depth, along.is_helix, unit)} when {pushed}; {rule}"))
        lines += self._stress_lines(shown, pushed)
        if self.tool is not None:
            lines += [("tool", self._vibration_in_words(shown)), ("waves", self._growth_in_words(shown))]
            lines.append((f"tool {shown.frequency.name}", self._frequency_in_words(shown)))
        assumptions = self.assumptions_in(shown.speed)
        return Report(self._in_words(shown), lines, self._table(shown), assumptions=assumptions)

    @property
    def _at_wellhead(self) -> CrossSection:
        """The section at the upper end of the string, its lower end as deep as it reaches."""
        return at_the_wellhead(self.rod, self._pushing.drag, float(self.along.depth[-1]))

    def _limit_in_words(self, shown: AnswerUnits) -> str:
        """Return the limits of the reach."""
        if self.yield_strength is None:
            stress = "any stress, since no yield strength is given"
        elif self.yield_share is None:
            stress = "any stress"
        elif self.rod.sections:
            stress = f"{self._percent} of the yield strength of each section"
        else:
            stress = f"{self._percent} of the yield strength {shown.pressure.show(self.yield_strength, 3)}"
        push = f"{shown.force.show(self.push, 4)}" if math.isfinite(self.push) else "any force"
        return f"{stress}, and {push} at the surface"

    def _lock_up_in_words(self, shown: AnswerUnits) -> str:
        """Return where friction alone stops the string, or down to which depth it does not."""
        unit = shown.length

        def at(lock_up: float) -> str:
            depth, before = (lock_up, "at") if math.isfinite(lock_up) else (self.depth[-1], "nowhere down to")
            return f"{before} {far(depth, unit)} {unit.name}"

        stops = (
            f"without the tool {at(self.lock_up)}; with it {at(self.lock_up_shaken)}" if self.tool else at(self.lock_up)
        )
        return f"by friction, whatever the stress and the push: {stops}"

    def _error_lines(self, unit: Unit) -> list[tuple[str, str]]:
        """Return the error of the reach with a tool, and how far apart the depths lie that were examined."""
        lines = []
        if self.tool is not None and self.is_stopped_shaken:
            error = unit.show(_ERROR * self.reach_shaken, 1)
            lines.append(("error", f"some {error} with the tool, {100.0 * _ERROR:g} % of the depth"))
        if self.tool is not None or self.rod.sections:
            apart = unit.show(RESOLUTION * (self.path.end - self.path.start), 3)
            found = "a string that is stopped and goes on again between two of them is not seen to be"
            lines.append(("sampled", f"at depths {apart} apart or less: {found}"))
        return lines

    def _speeds_in_words(self, shown: AnswerUnits) -> str:
        """Return the depth gained by the tool while the string slides at its speed and at two others."""
        texts = []
        for speed, depth, gain in zip(self.speeds, self.reach_at_speeds, self.gain_at_speeds, strict=True):
            ends = f" (to {end})" if (end := self._end_at(depth)) else ""
            gained = f"{far(depth, shown.length, less=self.reach).removeprefix('+')} {shown.length.name}"
            text = gained if gain > 0.0 else "nothing"
            texts.append(f"{text} at {shown.speed.show(speed, 3)}{ends}")
        return f"by the speed at which the string slides, the tool gains {', '.join(texts)}"

    @property
    def _has_one_frequency(self) -> bool:
        shaking = self._pushing.drag.shaking
        return shaking is None or shaking.second is None

    @property
    def assumptions(self) -> tuple[str, ...]:
        """The assumptions, speeds in m/s."""
        return self.assumptions_in(units.unit("m/s", "", "speed"))

    def assumptions_in(self, speed: Unit) -> tuple[str, ...]:
        """Return the assumptions, with speeds in a unit."""
        local = (
            "growth is that of a long string under the force at each depth, with the rod's damping and with friction, "
            f"which damps a lateral wave less if it moves faster: here {speed.show(self.sliding, 3)}"
        )
        more = () if self.tool is None else (local,) if self._has_one_frequency else (_FREE_PHASES, local)
        pressed = "equal pressures" if self.wellhead.pressure_inside is None else "fluids at rest"
        return (*ASSUMED, *more, f"linear elasticity, beyond yield too; stress with {pressed} inside and outside")

    def _stress_lines(self, shown: AnswerUnits, pushed: str) -> list[tuple[str, str]]:
        stress, depth, unit = self.stress, self.along.depth, shown.length
        share, most = stress.share_of_yield, self.yield_share
        where = f"at {far(depth[0] + stress.position, unit)} {unit.name}"
        where += self._section_in_words(self._most_stressed)
        text = f"{stress.in_words(shown.pressure)}; {where} when {pushed}"
        if self.tool and self.limit_shaken == YIELD and share is not None and most is not None and share > most:
            text += f"; the tool need not run down to {far(self.reach, unit)} {unit.name}"
        lines = [("stress", text)]
        return [*lines, ("yields", _listed(depth, self.yields, unit))] if self.yields.any() else lines

    def _vibration_in_words(self, shown: AnswerUnits) -> str:
        smallest, most = self.along.friction.min(), shown.force.show(self.amplitude.max(), 3)
        tool = "" if self.tool is None else f"{self.tool.in_words(shown)}: "
        text = f"{tool}the force vibrates by at most {most}, and friction falls to {smallest:.3g} at least"
        return f"{text}; {harmonics_in_words(self.along)}" if self.along.gain_is_uncertain else text

    def _growth_in_words(self, shown: AnswerUnits) -> str:
        if np.isnan(self.growth).any():
            return "not examined: with frequencies so far apart, in so long a string, it would take minutes"
        grows, unit = self.growth > _GROWS, shown.length
        error = np.zeros(self.growth.size) if self.growth_error is None else self.growth_error
        if not grows.any():
            may = (error > _GROWS) & (self.speed_to_grow <= self.sliding)
            if may.any():
                return f"no lateral wave is seen to grow; growth of up to {error[may].max():.2g} 1/s is not excluded"
            return f"no lateral wave grows; {self._held_in_words(shown)}"
        k = int(np.argmax(self.growth))
        rate = f"{self.growth[k]:.3g}{f' +- {error[k]:.1g}' if error[k] > _SAID * self.growth[k] else ''}"
        return (
            f"lateral waves grow {_in_few_words(self.along.depth, grows, unit)}, fastest at "
            f"{far(self.along.depth[k], unit)} {unit.name}{self._section_in_words(k)}: {rate} 1/s in "
            f"half waves of {unit.show(self.half_wave[k], 3)}"
        )

    def _section_in_words(self, k: int) -> str:
        """Return the section at place k along the string, after a blank; "" for a string of one."""
        return "" if self.along.section is None else f" in {name_of(self.rod, int(self.along.section[k]))}"

    def _held_in_words(self, shown: AnswerUnits) -> str:
        """Which lateral waves friction holds back."""
        k = int(np.argmin(self.speed_to_grow))
        if not math.isfinite(self.speed_to_grow[k]):
            return "none would, however fast it moves"
        moves, depth = shown.speed.show(self.speed_to_grow[k], 3), far(self.along.depth[k], shown.length)
        where = f"{shown.length.name}{self._section_in_words(k)}"
        return f"at {depth} {where} one would that moves at {moves} or faster"

    def _frequency_in_words(self, units_of: AnswerUnits) -> str:
        """Return the frequencies with which the tool gains depth while no lateral wave grows."""
        shown, length, every = units_of.frequency, units_of.length, self.frequencies
        if not self._has_one_frequency:
            return "not examined with a tool of two frequencies"
        if self.tool is None or not self.gain > 0.0:
            return "not examined, because the tool gains no depth at its own frequency"
        tried = f"{every.size} frequencies from {shown.of(every[0]):.3g} to {shown.show(every[-1], 3)}"
        as_far = f"{far(self.frequency_depth[-1], length)} {length.name}"
        pushing = np.count_nonzero(np.isfinite(self.frequency_growth))
        if not pushing:
            return f"none of {tried} that were tried takes the string to {as_far}"
        reach, growth = self.reach_at_frequencies, self.frequency_growth
        k, slowest = int(np.nanargmax(reach)), int(np.argmin(growth))
        ended = f", {end}" if (end := self._end_at(float(reach[k]))) else ""
        waves = f"where lateral waves grow at {growth[k]:.3g} 1/s" if growth[k] > _GROWS else "without lateral waves"
        best = (
            f"farthest at {shown.show(every[k], 3)}: to {far(reach[k], length)} {length.name} "
            f"({far(reach[k], length, less=self.reach)} {length.name}){ended}, {waves}"
        )
        ranges = ", ".join(f"{_range(shown.of(a), shown.of(b))} {shown.name}" for a, b in self.useful_frequencies)
        if ranges:
            return f"{best}; {tried} were tried: at {ranges} the string goes to {as_far} at least without lateral waves"
        slow = f"{shown.show(every[slowest], 3)}: {growth[slowest]:.3g} 1/s"
        count = f"all {pushing}" if pushing == every.size else f"{pushing}"
        return (
            f"{best}; {tried} were tried: at {count} the string goes to {as_far} at least, each with lateral waves, "
            f"which grow most slowly at {slow}"
        )

    def _table(self, shown: AnswerUnits) -> Table:
        depth, force = shown.length, shown.force
        rows = np.searchsorted(self.depth, self.bit_depth)
        names = (f"surface {force.name}", f"lower end {force.name}"), (f"with tool {force.name}",) * 2
        forces = (self.injector[rows], self.bit), (self.injector_shaken[rows], self.bit_shaken)
        kept = range(2 if self.tool else 1)
        columns = [(f"depth {depth.name}", ">9"), *((names[k][i], ">12") for i in range(2) for k in kept)]
        deep = [self.bit_depth > reach for reach in (self.reach, self.reach_shaken)]
        beyond = [deep[k] & np.isfinite(forces[k][0]) for k in kept]
        texts = [
            [_force(f, force) + "*" * b for f, b in zip(forces[k][0], beyond[k].tolist(), strict=True)] for k in kept
        ]
        texts += [[">" * bool(self.is_limited(f)) + _force(f, force) for f in forces[k][1].tolist()] for k in kept]
        where = [f"{value:.0f}" for value in depth.of(self.bit_depth)]
        limited = any(self.is_limited(forces[k][1]).any() for k in kept)
        rest = ["* deeper than the string can be pushed within its limits"] * any(
            is_beyond.any() for is_beyond in beyond
        )
        most = f"no more than {MOST_FORCE:g} critical forces of a level hole was tried"
        rest += [f"> at the lower end: more may arrive, {most}"] * limited
        return Table(columns, list(zip(where, *texts, strict=True)), "\n".join(rest))

    def is_limited(self, force: Any) -> NDArray[np.bool_]:
        """Return whether forces in N at the lower end are the largest that was tried, so that more may arrive there.

        Returns
        -------
        ndarray of bool
            In the shape of ``force``.
        """
        return np.asarray(units.si(force, "force", "force")) >= (1.0 - 1e-9) * self.bit_limit

    def as_dict(self) -> dict[str, Any]:
        """Return everything as numbers for JSON, units in the keys; None where a force is infinite.

        Returns
        -------
        dict of str
            Numbers, texts and lists by name.
        """
        with_tool = self if self.tool else None
        return {
            **by_keys(self, "depth_m injector_N"),
            **by_keys(with_tool, "injector_with_tool_N=injector_shaken"),
            **by_keys(self, "bit_depth_m bit_N"),
            **by_keys(with_tool, "bit_with_tool_N=bit_shaken"),
            **by_keys(self, "bit_limit_N far_force_N push_N wellhead wellhead_force_N yield_share"),
            **by_keys(self, "reach_m limit is_stopped lock_up_m"),
            **({} if self.along.section is None else by_keys(self, "limiting_section")),
            **by_keys(
                with_tool,
                "reach_with_tool_m=reach_shaken limit_with_tool=limit_shaken is_stopped_with_tool=is_stopped_shaken "
                "lock_up_with_tool_m=lock_up_shaken speeds_m_per_s reach_with_tool_at_speeds_m=reach_at_speeds "
                "gain_at_speeds_m",
            ),
            **by_keys(
                self,
                "tool along amplitude_N axial_stress_Pa bending_stress_Pa largest_stress_Pa stress growth_per_s "
                "growth_without_friction_per_s=growth_free growth_error_per_s half_wave_m speed_to_grow_m_per_s "
                "weight_N_per_m=weight_per_length fluids_kg_per_m3=fluids sliding_m_per_s "
                "frequencies_rad_per_s frequency_depth_m "
                "reach_by_frequency_m=reach_at_frequencies "
                "growth_by_frequency_per_s=frequency_growth speed_by_frequency_m_per_s=frequency_speed "
                "useful_frequencies_rad_per_s assumptions",
            ),
        }

    def plot(
        self,
        figure: Any = None,
        *,
        depth: str | None = None,
        force: str | None = None,
        pressure: str | None = None,
        frequency: str | None = None,
    ) -> Any:
        """Draw the force at the injector over the depth, and force and stress along the string.

        Parameters
        ----------
        figure : matplotlib.figure.Figure or SubFigure, optional
            Figure to draw into; by default a new one.
        depth : str, optional
            Unit of depths, as in `report`.
        force : str, optional
            Unit of forces, as in `report`.
        pressure : str, optional
            Unit of stresses, as in `report`.
        frequency : str, optional
            Unit of frequencies in the title, as in `report`.

        Returns
        -------
        matplotlib.figure.Figure or SubFigure
            The figure drawn into.

        Raises
        ------
        TypeError, ValueError
            For another unit.
        """
        from floquetrod.plotting.reach_plot import draw_reach

        shown = self._units(force, depth, pressure, frequency)
        return draw_reach(self, shown, self._in_words(shown), figure)

    def _units(self, force: str | None, depth: str | None, pressure: str | None, frequency: str | None) -> AnswerUnits:
        """Return the units named, else the units in which the question was given."""
        given = self.given_units
        return AnswerUnits.named(force, depth, pressure, frequency, _argument, given=given, usual_force="kN")


def _argument(name: str) -> str:
    """Return how `Reach.report` calls a unit."""
    return {"length": "depth"}.get(name, name)


def frequency_table(reach: Reach, shown: AnswerUnits) -> Table | None:
    """Return reach, gain and growth of lateral waves by the frequency of the tool; None where none was examined."""
    if not np.isfinite(reach.frequency_growth).any():
        return None
    of, length = shown.frequency, shown.length
    columns = (
        (of.name, ">9"),
        (f"reach {length.name}", ">14"),
        (f"gain {length.name}", ">12"),
        ("lateral waves 1/s", ">18"),
    )
    rows = []
    for frequency, depth, growth in zip(
        reach.frequencies, reach.reach_at_frequencies, reach.frequency_growth, strict=True
    ):
        goes = (far(depth, length), far(depth, length, less=reach.reach), f"{growth:.3g}")
        less = (f"< {far(reach.frequency_depth[-1], length)}", "-", "not examined")
        rows.append((f"{of.of(frequency):.3g}", *(goes if math.isfinite(depth) else less)))
    return Table(columns, rows)


def weight_in_words(
    per_length: float, fluids: tuple[float, float], shown: AnswerUnits, *, is_mean: bool = False
) -> str:
    """Return what a string weighs per length, in N/m, between fluids of densities in kg/m^3, 0 for none."""
    empty = [name for name, density in zip(("inside", "outside"), fluids, strict=True) if not density]
    between = "in its fluids" + (f", with none {empty[0]}" if empty else "")
    weighs = "weighs on average" if is_mean else "weighs"
    return f"{weighs} {shown.per_length.show(per_length, 4)} {between if any(fluids) else 'in air: no fluids given'}"


def far(depth: float, unit: Unit, *, less: float | None = None) -> str:
    """Return a depth or, with its sign, what it is more than one that is ``less``: in whole units from 1,000 on.

    Differences are of the rounded numbers shown.

    >>> feet = units.unit("ft", "", "length")
    >>> far(3779.0, feet), far(3375.0, feet), far(3779.0, feet, less=3375.0)
    ('12,398', '11,073', '+1,325')
    """
    text = f"{unit.of(depth):,.0f}" if abs(unit.of(depth)) >= 1000.0 else f"{unit.of(depth):.4g}"
    if less is None:
        return text
    more = float(text.replace(",", "")) - float(far(less, unit).replace(",", ""))
    return f"{more:+,.0f}" if abs(more) >= 1000.0 else f"{more:+.4g}"


def _listed(depth: Floats, is_so: Bools, unit: Unit, before: str = "") -> str:
    lengths = [(far(a, unit), far(b, unit)) for a, b in spans(depth, is_so)]
    texts = [f"{before}{a} to {b} {unit.name}" if a != b else f"at {a} {unit.name}" for a, b in lengths]
    return ", ".join(texts) or "nowhere"


def _in_few_words(depth: Floats, is_so: Bools, unit: Unit) -> str:
    """Return where something is so: all lengths or, of more than some, their number, their sum and the longest."""
    lengths = spans(depth, is_so)
    if len(lengths) <= _FEW:
        return _listed(depth, is_so, unit, "from ")
    sizes = [high - low for low, high in lengths]
    low, high = lengths[int(np.argmax(sizes))]
    ends = f"from {far(lengths[0][0], unit)} to {far(lengths[-1][1], unit)} {unit.name}"
    longest = f"the longest from {far(low, unit)} to {far(high, unit)} {unit.name}"
    return f"over {far(sum(sizes), unit)} {unit.name} in {len(lengths)} pieces {ends}, {longest}"


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
    yield_share: Any,
    wellhead: Wellhead,
) -> Reach:
    """Return how deep a string can be pushed; see `floquetrod.Rod.reach`.

    ``ends`` are the force at the lower end and the greatest at the injector.
    """
    # Two questions, each by marches of the force upwards from many depths of the lower end (`Pushing`): without the
    # tool, and with it.  ``depths`` are the lower ends asked for, ``few`` the indices of those at which the force on
    # the bit is sought as well.  The answer without the tool comes first: the search with it takes that depth as
    # passed.  Forces and stresses along the string, and the growth of lateral waves by the tool, are those of the last
    # answer; other frequencies of the tool are tried at depths between both answers.
    drag = drag_of(rod, path, friction, "pushed", helical, tool, speed)
    if tool is not None:
        tool_inside(tool, path.end - path.start, "string")
    far_force = force_in_newtons("far_force", ends[0])
    push = math.inf if ends[1] is None else force_in_newtons("push", ends[1])
    require_tube(wellhead, rod)
    limits = Limits(push, stress_limit(rod, yield_share))
    depths = depths_of(rod, path, depth)
    few = np.unique(np.linspace(0, depths.size - 1, _BITS).round().astype(int))
    pushing = Pushing(rod, replace(drag, shaking=None), far_force, wellhead=wellhead)
    without = shaken = pushing.sought(depths, few, limits)
    by_itself = without.reached
    if tool is None or math.isfinite(limits.stress):  # with a tool, only for the stress at its places
        by_itself, along, stress = pushing.along(by_itself, limits)
    reached = by_itself
    if tool is not None:
        pushing = Pushing(rod, drag, far_force, by_itself.depth, wellhead)
        shaken = pushing.sought(depths, few, limits)
        reached, along, stress = pushing.along(shaken.reached, limits)
    sliding = 0.0 if drag.shaking is None else drag.shaking.speed
    lateral = _growth_with_tool(rod, drag, along, tool)
    other_frequencies = _other_frequencies(
        rod, drag, far_force, by_itself.depth + _WAY * _gained(by_itself.depth, reached.depth)
    )
    given = units.GivenUnits.of(length=depth, force=(ends[1], ends[0]), speed=speed).or_else(
        wellhead.given_units,
        *([tool.given_units._replace(length="")] if tool else []),
        path.given_units,
        rod.given_units,
    )
    return Reach(
        path=path,
        depth=depths,
        injector=without.injector,
        injector_shaken=shaken.injector,
        bit_depth=depths[few],
        bit=without.bit,
        bit_shaken=np.fmax(shaken.bit, without.bit) if tool else without.bit,
        bit_limit=MOST_FORCE * drag.scale,
        far_force=far_force,
        push=push,
        wellhead=wellhead,
        wellhead_force=wellhead.added(at_the_wellhead(rod, drag, along.depth[-1]), drag.motion),
        yield_share=None if yield_share is None else float(yield_share),
        reach=by_itself.depth,
        reach_shaken=reached.depth,
        limit=by_itself.limit,
        limit_shaken=reached.limit,
        lock_up=_locks_up(without.lock_up),
        lock_up_shaken=_locks_up(shaken.lock_up),
        tool=tool,
        along=along,
        amplitude=along.vibration,
        axial_stress=stress.axial,
        bending_stress=stress.bending,
        largest_stress=stress.largest,
        yield_strength=reference_strength(rod),
        weight_per_length=rod.weight_per_length,
        fluids=(rod.fluid_inside, rod.fluid_outside),
        sliding=sliding,
        growth=lateral.net,
        growth_free=lateral.free,
        growth_error=lateral.error,
        half_wave=lateral.half_wave,
        speed_to_grow=lateral.least_speed,
        frequencies=other_frequencies.frequency,
        frequency_depth=other_frequencies.depth,
        frequency_growth=other_frequencies.growth,
        frequency_speed=other_frequencies.speed,
        _pushing=pushing,
        _limits=limits,
    ).given_in(given)


def _locks_up(reached: Reached) -> float:
    """Return the depth in m at which a string locks up, infinite where it does not."""
    return reached.depth if reached.limit == LOCK_UP else math.inf


def depths_of(rod: RodData, path: WellPath, depth: Any, number: int = _DEPTHS) -> Floats:
    """Return the measured depths of the lower end, increasing, checked; a number of them where none are given."""
    if depth is None:
        depths = np.linspace(path.start, deepest_of(rod, path), number + 1)[1:]
        require_depth(rod, path, "depth", float(depths[-1]))
        return depths
    depths = np.unique(units.array("depth", depth, "length", 0.0, 1e6))
    if not depths.size or depths[0] < path.start + 1e-6 or depths[-1] > path.end + 1e-6:
        written = depth[-1] if isinstance(depth, list | tuple) and depth else depth
        name = units.unit_of(written) if isinstance(written, str) else None
        unit = units.unit(name or "m", "depth", "length")
        wrong = "none" if not depths.size else unit.show(depths[-1] if depths[-1] > path.end else depths[0])
        ends = f"{unit.of(path.start):.6g} to {unit.show(path.end)}"
        raise validate.wrong_value(
            "depth", f"must lie below the start of the path and down to its end, {ends}, got {wrong}"
        )
    require_depth(rod, path, "depth", float(depths[-1]))
    return np.minimum(depths, deepest_of(rod, path))


def _gained(without: float, shaken: float) -> float:
    """Return by how much a reach with a tool exceeds that without, 0 where its error may make all of that."""
    return shaken - without if abs(shaken - without) > _ERROR * shaken else 0.0


class _GrowthAlong(NamedTuple):
    """Growth of lateral waves along a string, see `Reach`."""

    net: Floats
    free: Floats
    half_wave: Floats
    least_speed: Floats
    error: Floats | None


def _growth_with_tool(rod: RodData, drag: Drag, along: MeanForce, tool: VibrationTool | None) -> _GrowthAlong:
    """Return the growth of lateral waves along a string with a tool."""
    size, second = along.depth.size, along.second_vibration
    net, free, half_wave, error = np.zeros((4, size))
    growth = _GrowthAlong(net, free, half_wave, np.full(size, math.inf), None if second is None else error)
    chosen = np.flatnonzero(~along.is_snaking & np.isfinite(along.force) & (along.vibration > 0.0))
    if tool is None or drag.shaking is None or not chosen.size:
        return growth
    places, (frequency, *others) = _Places.of(rod, drag, along, chosen), (each for _, each in drag.shaking.sines)
    if others and chosen.size * others[0] > MOST_PLACES * frequency:
        return _GrowthAlong(*np.full((5, size), math.nan))
    for part, there in StringCells.of(rod, places.cell).groups():
        at, i = places.some(there), chosen[there]
        if second is None:
            free[i], half_wave[i] = growth_along(part, at.place, at.force, at.vibration, frequency)
        else:
            amplitudes = at.vibration - second[i], second[i]
            found = growth_of_two_sines(part, at.place, at.force, amplitudes, (frequency, others[0]))
            free[i], half_wave[i], error[i] = found
    net[chosen] = np.maximum(free[chosen] - places.lost, 0.0)
    speeds = _speeds(along, chosen)
    growth.least_speed[chosen] = least_speed((free + error)[chosen], places.pressed, drag.shaking.speed, *speeds)
    return growth


def _speeds(along: MeanForce, chosen: NDArray[np.intp]) -> tuple[Floats, Floats | None]:
    """Return the amplitudes of the axial velocity at some places, of the second wave None without."""
    if along.second_speed is None:
        return along.speed[chosen], None
    second = along.second_speed[chosen]
    return along.speed[chosen] - second, second


class _Places(NamedTuple):
    """Places along a string, what shakes it there, and what friction takes from waves across in 1/s."""

    place: WellGeometry
    force: Floats
    vibration: Floats
    pressed: Floats
    lost: Floats
    cell: Ints

    @classmethod
    def of(cls, rod: RodData, drag: Drag, along: MeanForce, chosen: NDArray[np.intp]) -> _Places:
        """Return some places of a string that slides; mu N is over its mass per length, in m/s^2."""
        depth = along.depth[chosen]
        cells = StringCells.at(rod, drag.assembly, depth, along.depth[-1])
        contact = np.minimum(along.contact[chosen], MOST_PRESSED * cells.column("weight_per_length"))
        pressed = drag.friction.at(depth) * contact / cells.column("mass_per_length")
        sliding = 0.0 if drag.shaking is None else drag.shaking.speed
        speed, other = _speeds(along, chosen)
        lost = damping_across(pressed, sliding, speed, np.full(chosen.size, sliding), other)
        place = WellGeometry.at(drag.path.arcs.at(depth))
        return cls(place, along.force[chosen], along.vibration[chosen], pressed, lost, cells.codes)

    def some(self, i: Any) -> _Places:
        """Return the places ``i``."""
        place, *others = self
        return _Places(WellGeometry(*(each[i] for each in place)), *(each[i] for each in others))

    @classmethod
    def joined(cls, several: Sequence[_Places]) -> _Places:
        """Return several one after the other."""
        place, *others = zip(*several, strict=True)
        return cls(WellGeometry(*map(np.concatenate, zip(*place, strict=True))), *map(np.concatenate, others))


class _OtherFrequencies(NamedTuple):
    """Frequencies of a tool in rad/s, depths of a string in m; the fastest growth in 1/s and largest speed in m/s."""

    frequency: Floats
    depth: Floats
    growth: Floats
    speed: Floats


def _other_frequencies(rod: RodData, drag: Drag, far_force: float, depth: Floats) -> _OtherFrequencies:
    """Return growth and speed of a string to measured depths in m with other frequencies of its tool."""
    if drag.shaking is None or drag.shaking.second is not None or not depth[-1] > depth[0]:
        return _OtherFrequencies(np.empty(0), np.empty(0), np.empty(0), np.empty(0))
    frequency = drag.shaking.frequency * _FREQUENCIES
    frequency = frequency[frequency <= strings.highest_frequency(drag.shaking, depth[-1] - drag.path.start)]
    frequencies, bottom = (values.ravel() for values in np.meshgrid(frequency, depth, indexing="ij"))
    drags = replace(drag, shaking=replace(drag.shaking, frequency=frequencies))
    growth, speed = np.full(frequencies.size, math.inf), np.zeros(frequencies.size)
    places, string = [], []
    for k, along in enumerate(mean_forces(drags, far_force, bottom, _SPACING)):
        if along is not None:
            growth[k], speed[k] = 0.0, along.speed.max()
            places.append(_Places.of(rod, drags, along, np.flatnonzero(~along.is_snaking & (along.vibration > 0.0))))
            string.append(np.full(places[-1].force.size, k))
    if places:
        joined, string_numbers = _Places.joined(places), np.concatenate(string)
        for part, there in StringCells.of(rod, joined.cell).groups():
            at, which = joined.some(there), string_numbers[there]
            grows = fastest_along(part, at.place, at.force, at.vibration, frequencies[which], at.lost, which)
            np.maximum.at(growth, which, grows)
    growth, speed = (values.reshape(frequency.size, depth.size) for values in (growth, speed))
    return _OtherFrequencies(frequency, depth, growth.max(axis=1), speed.min(axis=1))
