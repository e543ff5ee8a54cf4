"""The mean force along a string in a well, its contact with the wall, and where it is buckled."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.content import ByContent
from floquetrod._util.interchange import by_keys
from floquetrod._util.result_report import Printed, Report
from floquetrod._util.spans import runs
from floquetrod.parameter import require_known
from floquetrod.rod.answers.assembly import assembly_of, at_the_wellhead, numbers_along, require_depth
from floquetrod.rod.loads.tool import VibrationTool, independent_sines
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.parameters import ROD, friction_coefficient
from floquetrod.rod.model.wellhead import OPEN, Wellhead
from floquetrod.units import with_unit
from floquetrod.wells import strings
from floquetrod.wells.drag import (
    CHECKED,
    HELICAL,
    MOTIONS,
    TRIED,
    Drag,
    Fineness,
    Friction,
    Shaking,
    StringProperties,
    WellGeometry,
)
from floquetrod.wells.path import WellPath
from floquetrod.wells.survey import LENGTHS

_LARGEST = 1e12  # N
_SPEEDS = 1e-9, 1e3  # m/s of sliding
_SPACING = 10.0  # m between depths where none are asked for (a choice)
_MOST = 2000  # depths where none are asked for
_CLOSE = 1e-3  # of the largest speed and vibration: waves that differ by more are computed with finer cells
_FINER = (1, 1e-6), (4, 1e-7), (16, 1e-8)  # times as many, and their `Fineness.soft`, as long as the turns settle
_HARDLY_FASTER = 1.3  # times the sliding speed: below, harmonics of friction may take half of a tool's gain (measured)
_SAFETY = 3.0  # of the difference of two waves: friction beside the corner makes it fall unevenly (measured)


@dataclass(frozen=True, eq=False, repr=False)
class MeanForce(Printed, ByContent):
    """Mean force along a string in a well, from its upper end at the beginning of the path to its lower end.

    Attributes
    ----------
    depth : ndarray (n,)
        Measured depths in m, both ends among them.
    force : ndarray (n,)
        Effective compression in N, negative for a pull; infinite where the string is locked up.
    contact : ndarray (n,)
        Contact force in N/m, of a helix too.
    friction : ndarray (n,)
        Mean coefficient of friction, smaller where a tool vibrates the string.
    speed : ndarray (n,)
        Amplitude in m/s of the axial vibration, 0 without a tool; with two frequencies the sum of both amplitudes.
    vibration : ndarray (n,)
        Amplitude in N of the vibration of the force, with two frequencies likewise.
    is_snaking : ndarray of bool (n,)
        Whether the string is buckled, into waves or a helix.
    is_helix : ndarray of bool (n,)
        Whether it is buckled into a helix.
    motion : str
        "pushed", "standing" or "pulled".
    error : float
        Estimated error of ``force`` in N where it is finite, of the integration alone.  With a tool its wave and
        the force are computed alternately, and from above and below; infinite where these have not converged.
    speed_error : float
        Estimated error of ``speed`` in m/s, of the same solutions: largest next to an axial resonance.
    vibration_error : float
        Estimated error of ``vibration`` in N.
    wellhead : float
        Compression in N that the injector gives beyond the effective one below the stripper: wellhead pressure on the
        cross-section, and friction of the stripper, negative where that helps.
    end_contact : float
        Contact force in N concentrated at the lower end, of a string with a residual curvature; ``force`` there is
        that above it.
    section : ndarray of int (n,) or None
        Number of the section at each depth, from the upper end of the string; None for a string of one section.
    second_speed : ndarray (n,) or None
        Share of ``speed`` in m/s of the faster of a tool's two frequencies; None with one frequency.
    second_vibration : ndarray (n,) or None
        Its share of ``vibration`` in N.
    sliding : float
        Speed in m/s at which a string that a tool vibrates slides, else 0.
    """

    depth: Floats
    force: Floats
    contact: Floats
    friction: Floats
    speed: Floats
    vibration: Floats
    is_snaking: Bools
    is_helix: Bools
    motion: str
    error: float
    speed_error: float
    vibration_error: float
    wellhead: float = 0.0
    end_contact: float = 0.0
    section: NDArray[np.intp] | None = None
    second_speed: Floats | None = None
    second_vibration: Floats | None = None
    sliding: float = 0.0

    @property
    def at_top(self) -> float:
        """Effective compression in N at the upper end, below the stripper; negative for a pull, infinite if locked."""
        return float(self.force[0])

    @property
    def injector(self) -> float:
        """Compression in N required of the injector, negative for a pull; infinite if locked up."""
        return self.at_top + self.wellhead

    @property
    def surface_weight(self) -> float:
        """Weight in N that the injector or the hook carries, the negative of ``injector``."""
        return -self.injector

    @property
    def is_locked(self) -> bool:
        """Whether no force at the upper end moves the string."""
        return math.isinf(self.at_top)

    @property
    def gain_is_uncertain(self) -> bool:
        """Whether a tool moves the string faster than the string slides, but at most by 30 %.

        The harmonics of friction, which are neglected, may then take half of the tool's gain or more: see
        docs/theory/mean_force.md.
        """
        return bool(0.0 < self.sliding < self.speed.max() <= _HARDLY_FASTER * self.sliding)

    @property
    def _in_words(self) -> str:
        where = f"string {self.motion} to {self.depth[-1]:.6g} m"
        if self.is_locked:
            return f"{where} locks up at {float(self.depth[np.isinf(self.force)].max()):.4g} m"
        size = with_unit(abs(self.injector), "N", 4)
        return f"{where} needs {size} of {'push' if self.injector >= 0.0 else 'pull'} at {self.depth[0]:.6g} m"

    def report(self) -> Report:
        """Return the force and the buckled depths.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.
        """
        lines = [("snaking", _depths(self.depth, self.is_snaking)), ("helix", _depths(self.depth, self.is_helix))]
        if self.wellhead:
            added = with_unit(abs(self.wellhead), "N", 4)
            kind = "push" if self.wellhead > 0.0 else "pull"
            lines.insert(0, ("wellhead", f"pressure and stripper add {added} of {kind} at the injector"))
        if self.end_contact:
            lines.insert(0, ("bend", bend_in_words(with_unit(self.end_contact, "N", 3))))
        if self.gain_is_uncertain:
            lines.append(("tool", harmonics_in_words(self)))
        return Report(self._in_words, lines, assumptions=ASSUMED)

    def as_dict(self) -> dict[str, Any]:
        """Return everything as numbers for JSON, units in the keys.

        ``section`` is that of a string of several, and the second wave that of a tool of two frequencies.

        Returns
        -------
        dict of str
            Numbers and lists by name.
        """
        second = {} if self.second_speed is None else by_keys(self, "second_speed_m_per_s second_vibration_N")
        return super().as_dict() | ({} if self.section is None else by_keys(self, "section")) | second

    _keys = "motion depth_m force_N contact_N_per_m friction speed_m_per_s vibration_N is_snaking is_helix error_N "
    _keys += "speed_error_m_per_s vibration_error_N wellhead_N injector_N surface_weight_N end_contact_N "
    _keys += "sliding_m_per_s gain_is_uncertain"


ASSUMED = (
    "the string follows the well and transmits no shear force (soft string), but buckles",
    "effective force; a helix adds F^2 R / (4 E I) to the contact force, snaking nothing",
    "no torque",
    "waves of a tool lose energy to damping and to the first harmonic of friction, and are reflected by the lower end, "
    "which is free, and by the upper one, which moves steadily; the other harmonics may take half of the gain where a "
    f"wave is nowhere {_HARDLY_FASTER:g} times as fast as the string slides",
)
"""What mean forces assume."""


def bend_in_words(contact: str) -> str:
    """Return where the residual curvature of a string presses it to the wall, from its contact force there."""
    return f"that of the string without load presses it to the wall with {contact} at the lower end, and nowhere else"


def harmonics_in_words(along: MeanForce) -> str:
    """Return why what a tool gains is uncertain, of a string of which ``gain_is_uncertain`` is true."""
    return (
        f"it moves the string at most {along.speed.max() / along.sliding:.3g} times as fast as the string slides; of "
        "so slow a wave the neglected harmonics of friction may take half of the tool's gain or more"
    )


def _depths(depth: Floats, is_so: Bools) -> str:
    """Return where something is so, in words."""
    return ", ".join(f"{low:.6g} to {high:.6g} m" for low, high in spans(depth, is_so)) or "nowhere"


def spans(depth: Floats, is_so: Bools) -> Sequence[tuple[float, float]]:
    """Return the ends in m of the depths, one after the other, where something is so."""
    return [(float(depth[first]), float(depth[after - 1])) for first, after in runs(is_so)]


def drag_of(
    rod: RodData, path: Any, friction: Any, motion: Any, helical: Any, tool: VibrationTool | None, speed: Any
) -> Drag:
    """Return a string of a rod's section or sections in a well, from what people give."""
    require_known(rod, ROD, "strings")
    path = validate.instance("path", path, WellPath, "fr.WellPath.from_csv reads one from a survey")
    shaking, assembly = None, assembly_of(rod)
    if tool is not None:
        tool = validate.instance("tool", tool, VibrationTool, "such as fr.VibrationTool('5kN', '18Hz', '30m')")
        sliding = units.number("speed", speed, "speed", *_SPEEDS, "give it in m/s")
        waves = (rod.mass_along * rod.wave_speed, rod.wave_speed)
        if assembly is not None:
            waves = float(assembly.impedance.min()), float(assembly.wave_speed.min())
        (amplitude, frequency), *second = independent_sines(tool)
        along = *waves, rod.damping_rate, sliding
        shaking = Shaking(amplitude, frequency, tool.above_end, *along, *second)
    return Drag(
        path,
        StringProperties(rod.flexural_rigidity, rod.weight_per_length, rod.radial_clearance)
        if assembly is None
        else assembly.reference,
        friction_along(friction),
        validate.choice("motion", motion, MOTIONS),
        validate.choice("helical", helical, HELICAL),
        shaking,
        rod.residual_curvature,
        assembly,
    )


def friction_along(given: Any) -> Friction:
    """Return a coefficient of friction, or pairs of a measured depth in m and the coefficient from there on."""
    if not isinstance(given, list | tuple):
        return Friction((0.0,), (friction_coefficient(given),))
    pairs = validate.listed("friction", given, validate.MOST_NUMBERS, "pairs")
    depths, values = [], []
    for i, pair in enumerate(pairs):
        if not isinstance(pair, list | tuple) or len(pair) != 2:
            raise validate.wrong_type(
                f"friction[{i}]", f"must be a depth and a coefficient, got {validate.short(pair)}"
            )
        depths.append(units.number(f"friction[{i}]", pair[0], "length", 0.0, LENGTHS[1]))
        values.append(friction_coefficient(pair[1]))
    if not depths or depths[0] > 0.0 or any(a >= b for a, b in itertools.pairwise(depths)):
        raise validate.wrong_value(
            "friction", f"must begin at depth 0 and continue with greater depths, got {validate.short(given)}"
        )
    return Friction(tuple(depths), tuple(values))


def force_in_newtons(name: str, value: Any) -> float:
    """Return a force in N, given as a number or with a unit; negative for a pull."""
    return units.number(name, value, "force", -_LARGEST, _LARGEST, "give it in N")


def mean_force(
    rod: RodData, drag: Drag, far_force: Any, bottom: Any, depth: Any, wellhead: Wellhead = OPEN
) -> MeanForce:
    """Return the mean force along a string; see `floquetrod.Rod.mean_force`."""
    path, force, end = drag.path, force_in_newtons("far_force", far_force), lower_end(drag.path, bottom)
    require_depth(rod, path, "bottom", end)
    depths, added = _answer_depths(drag, end, depth), wellhead.added(at_the_wellhead(rod, drag, end), drag.motion)
    run = functools.partial(strings.run, drag, path.start, np.array([end]), force, depths)
    fine, rough = map(run, CHECKED)
    forces, rough_forces = drag.force(fine.y[:, 0]), drag.force(rough.y[:, 0])
    is_free = np.isfinite(forces) & np.isfinite(rough_forces)
    if not (fine.is_settled[0] and rough.is_settled[0]):
        return _along(drag, fine, 0, end, (math.inf, math.inf, math.inf), added)
    error = float(np.abs(forces[is_free] - rough_forces[is_free]).max(initial=0.0))
    wave, errors = (fine.wave, (0.0, 0.0)) if drag.shaking is None else _refined_wave(run, fine, rough)
    return _along(drag, fine._replace(wave=wave), 0, end, (error, *errors), added)


def _refined_wave(
    run: Callable[[Fineness], strings.Run], fine: strings.Run, rough: strings.Run
) -> tuple[Floats, tuple[float, float]]:
    """Return the wave of a tool, with finer cells next to an axial resonance, and the errors of speed and vibration.

    There elastic forces cancel, and what friction takes where the wave is hardly faster than the string slides, in few
    cells, decides how large it becomes: its corner is sharper, too.
    """
    wave, off = fine.wave, _largest(fine.wave - rough.wave)
    for k, (cells, soft) in enumerate(_FINER):
        finer = run(CHECKED[0]._replace(cells=cells * CHECKED[0].cells, soft=soft))
        if not finer.is_settled[0]:
            break
        # The first differs in the corner, the two before it in their cells: both errors count.
        change = _largest(finer.wave - wave)
        off, wave = np.maximum(change, off) if k == 0 else change, finer.wave
        if (off <= _CLOSE * _largest(wave)).all():
            break
    return wave, (float(_SAFETY * off[0]), float(_SAFETY * off[1]))


def _largest(wave: Floats) -> Floats:
    """Return the largest sizes of speed and vibration (2,) along one string."""
    return np.asarray(np.fmax.reduce(np.abs(wave[:2, :, 0]), axis=1, initial=0.0))


def mean_forces(drag: Drag, far_force: float, bottoms: Floats, spacing: float) -> list[MeanForce | None]:
    """Return quick mean forces of strings to measured depths, every so many m; None where one is stopped before.

    Their tools have the frequencies of ``drag``, of each its own; errors are not known.
    """
    start, deepest = drag.path.start, float(bottoms.max())
    depths = np.append(np.linspace(start, deepest, 1 + math.ceil((deepest - start) / spacing)), bottoms)
    strings_run = strings.run(drag, start, bottoms, far_force, depths, TRIED)
    goes = strings_run.is_settled & np.isfinite(drag.force(strings_run.top_y))
    unknown = math.nan, math.nan, math.nan
    every = enumerate(bottoms.tolist())
    return [_along(drag, strings_run, k, bottom, unknown) if goes[k] else None for k, bottom in every]


def _along(
    drag: Drag,
    strings_run: strings.Run,
    k: int,
    bottom: float,
    errors: tuple[float, float, float],
    wellhead: float = 0.0,
) -> MeanForce:
    """Return the results along string k to a depth, with the errors of force, speed and vibration."""
    # From y of the march, at the depths where string k has one, F = S tan y, the contact force N of the lying string
    # and, where it is wound, of a helix, and the friction that the wave leaves, mu times the share at its speed.  F is
    # infinite where the string is locked up: contact forces are computed with F = 0 there, and replaced by infinity.
    there = np.isfinite(strings_run.y[:, k])
    depth, y = strings_run.depth[there], strings_run.y[there, k]
    speed, vibration, left, *second = strings_run.wave[:, there, k]
    has_second = drag.shaking is not None and drag.shaking.second is not None
    force, positions = drag.force(y), WellGeometry.at(drag.path.arcs.at(depth))
    finite_force, string = np.where(np.isfinite(force), force, 0.0), drag.at(depth, np.asarray(bottom))
    lying = string.pipe.lying(finite_force, positions)
    is_helix = string.is_helix(positions, y) | np.isinf(force)
    contact = lying + np.where(is_helix, string.pipe.helix(finite_force), 0.0)
    return MeanForce(
        depth=depth,
        force=force,
        contact=np.where(np.isfinite(force), contact, math.inf),
        friction=left * drag.friction.at(depth),
        speed=speed,
        vibration=vibration,
        is_snaking=string.is_snaking(positions, force),
        is_helix=is_helix,
        motion=drag.motion,
        error=errors[0],
        speed_error=errors[1],
        vibration_error=errors[2],
        wellhead=wellhead,
        end_contact=float(drag.at(np.asarray(bottom), np.asarray(bottom)).end_contact),
        section=numbers_along(drag, depth, bottom),
        second_speed=second[0] if has_second else None,
        second_vibration=second[1] if has_second else None,
        sliding=drag.shaking.speed if drag.shaking is not None and speed.any() else 0.0,
    )


def _answer_depths(drag: Drag, bottom: float, depth: Any) -> Floats:
    """Return the measured depths of an answer, increasing, with both ends.

    Where none are given those at which sections meet and bores change are among them, and those just above.
    """
    top = drag.path.start
    if depth is None:
        number = int(np.clip((bottom - top) / _SPACING, 50, _MOST))
        depths = np.linspace(top, bottom, number + 1)
        if drag.assembly is None:
            return depths
        changes = np.append(bottom - drag.assembly.inner, drag.assembly.bores)
        changes = np.append(changes, np.nextafter(changes, -math.inf))
        return np.union1d(depths, changes[(changes >= top) & (changes <= bottom)])
    depths = units.array("depth", depth, "length", 0.0, 1e6).ravel()
    outside = (depths < top) | (depths > bottom)
    if outside.any():
        raise validate.wrong_value(
            "depth", f"must lie from {top:g} m to bottom = {bottom:g} m, got {depths[outside][0]:g} m"
        )
    return np.unique(np.concatenate([[top, bottom], depths]))


def lower_end(path: Any, bottom: Any) -> float:
    """Return the measured depth of the lower end of a string, by default of the end of the path."""
    if bottom is None:
        return float(path.end)
    depth = units.number("bottom", bottom, "length")
    if not path.start + LENGTHS[0] <= depth <= path.end:
        raise validate.wrong_value(
            "bottom",
            f"must lie below {path.start:g} and not below {path.end:g} m, the end of the path, got {depth:g} m",
        )
    return depth
