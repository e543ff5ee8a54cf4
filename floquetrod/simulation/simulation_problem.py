"""A rod to be simulated, and what came of it: `SimulationProblem` -> `Simulation`, both plain picklable values."""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import KW_ONLY, asdict, dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod import units
from floquetrod._util import sealed_files, validate
from floquetrod._util.arguments import Mention
from floquetrod._util.caching import cached_property
from floquetrod._util.calling import level_of_caller
from floquetrod._util.progress import Progress
from floquetrod._util.result_report import Report, Reported
from floquetrod._util.version import __version__
from floquetrod.parameter import require_known
from floquetrod.rod.answers.mean_force import friction_along
from floquetrod.rod.loads.load import (
    QUANTITIES,
    Load,
    load_from_dict,
    load_number,
    noise_in_words,
    require_load,
    require_one_sine,
)
from floquetrod.rod.loads.tool import VibrationTool, tool_inside
from floquetrod.rod.model.parameters import ROD
from floquetrod.rod.rod import Rod
from floquetrod.simulation.checkpoints import Checkpoint, RunState, other_arithmetic
from floquetrod.simulation.driving import LARGEST_STRAIN, MOST_HARMONICS, Driving, half_waves, least_axial_rigidity
from floquetrod.simulation.findings import Findings
from floquetrod.simulation.growth import GrowthFit, growth_of_motion
from floquetrod.simulation.integration import Integration
from floquetrod.simulation.lumping import uniform_rods
from floquetrod.simulation.measures import axial_force, contact_force
from floquetrod.simulation.outcome import BUCKLED_ANGLE, EarlierMotion, Kick, Outcome, outcome_of, turned
from floquetrod.simulation.recorded_motion import ENDINGS, EarlyEnd, LastState, RecordedMotion
from floquetrod.simulation.resolution import GrowingWaves, ResolutionWarning, growing_waves
from floquetrod.simulation.rest_angles import rest_angles
from floquetrod.simulation.rod_mesh import ENERGIES, DiscreteRod
from floquetrod.simulation.start import LEAST_SEGMENTS, MOST_SEGMENTS, Perturbation, perturbation_from_dict
from floquetrod.simulation.start_state import StartState
from floquetrod.simulation.step_size import STEP_LIMITS, TimeSteps, time_steps
from floquetrod.simulation.well_mesh import RodInWell
from floquetrod.wells.drag import Friction

_SEGMENTS_IN_HALF_WAVE = 10  # by default, with which bending is 2e-4 too soft (a choice)
_SEGMENTS_OF_FASTEST = 8  # in half a wave of what grows fastest, where that is shorter: 6e-4 too soft
_LEAST_HALF_WAVES = 5.0  # that are resolved so in a short rod, where the ends matter more (a choice)
_OFF_THE_WALL = 0.01  # of the clearance, a hundred times the depth at rest (a choice)
_MOSTLY_ON = 0.5  # of the frames in which a rod may be off the wall for its mode to be named (a choice)
_LONG = 1000.0  # half swings, in which growth by a factor of 20 keeps a rod from coming to rest (a choice)
_FORMAT = "floquetrod simulation 4"
_SHARPEST = 0.1  # of a radian, by which a channel may bend over a radial clearance (a choice; 1e-3 is much)
_MOST_CURVED = 1e3  # 1/m, natural curvature (a choice: beyond any)


Intervals = tuple[tuple[float, float], ...]
"""Depths in m, each with the coefficient of friction from there on."""


@dataclass(frozen=True)
class SimulationProblem:
    """A rod, its load, and how both are simulated: everything a simulation depends on, in SI units.

    The rod starts on the floor, compressed by the mean force, with the speeds of ``perturbation``; in a well it starts
    where weight and mean force press it to the wall.  Across the channel its ends are held as `Rod.ends` says.  Along
    it both are pushed inwards by the force of an `AxialLoad`; under an `AxialWave` only the upper one, with the lower
    one held, pushed by the mean force, or pushed by the same force.  Options are given by keyword.

    Parameters
    ----------
    rod : Rod
    load : AxialLoad, AxialWave or ForceRecord
        Must strain the rod by at most 0.02; up to 100 harmonics.
    duration : float
        In s.
    friction : float or sequence of (float or str, float)
        mu, static = kinetic, along the channel and around it; or pairs of a depth in m and the coefficient from there
        on, the first at 0.  Depths are measured depths in a well, else distances down the channel from where the upper
        end of the rod lies without load; a node has the friction of where it is.
    perturbation : Perturbation, optional
        By default Perturbation.random(1e-3, seed=1), which the problem then holds.
    segments : int, optional
        At least 6 for every half wave of the critical mode and of those the perturbation names; none shorter than the
        rod's radius.  By default 10 for every half wave of the mode that the load is likely to excite, or that the
        perturbation names, at least 8 of the one that by theory grows fastest and 6 of the highest that grows at half
        its rate; the problem then holds the number.  With fewer than these 6 a run warns with `ResolutionWarning`.
    time_step : float, optional
        The largest step to take, in s; by default the critical one with a margin.  Frames come at equal numbers of
        steps, so the step taken, ``time_steps.size``, is a little smaller.
    frames : int
        Frames kept, the start and the end among them.
    poisson_ratio : float
        In (-1, 0.5]; with Young's modulus it gives the shear modulus.
    indentation : float
        Depth to which the weight of the rod at rest indents the floor, as a fraction of the radial clearance R.
    contact_damping : float
        Damping of small motion against the wall about rest, as a fraction of the critical damping.
    feed_speed : float, optional
        Speed in m/s at which the upper end is moved down the channel, in place of the force there.  A vibration then
        acts on the lower end alone.
    far_force : float, optional
        Mean effective compression at the lower end in N, where that end is pushed; by default the mean of the load.
    tool : VibrationTool, optional
        In the rod, which it pushes down the channel and pulls up by amplitude * sin(frequency * t), shared by the two
        nodes beside it; waves run from it both ways, and the ends reflect them.
    stop_early : bool
        Whether the run ends at the frame at which it has clearly buckled, the largest angle beyond 45 degrees (a
        choice) and beyond twice what the kick does by itself, or at which friction holds it at rest: no node's angle
        has changed by more than 1e-5 rad over the last full period of the force, and none is beyond 5 degrees.
    natural_curvature : float, str or "path"
        Curvature in 1/m, or with its unit, of a rod with a path when no load acts; "path" is the curvature of the well.
    start : Simulation, path or StartState, optional
        Another run of the same rod, or its npz file, from whose last state this one starts, in place of the floor.
        Load, friction, tool, forces on the ends, and the rod's damping rate and gravity may differ; all else must be
        that of the run, and so are segments and perturbation where they are left out.  Time goes on: the first frame
        has the time of the state, vibrations continue with their phase, of another frequency with that which it would
        have had by then, and work and losses are added to those before.  A load that differs acts at once.  Whether
        the rod has buckled is judged by the rest under its load; see `floquetrod.simulation.outcome`.

    Raises
    ------
    TypeError, ValueError
        For problems that cannot be simulated: among others an unstable time step, a run of more than 1e14 steps times
        segments, some two weeks, and frames that take more than 4 GiB.

    Notes
    -----
    The model of section 3.3 of DOI 10.1115/1.4031710, for any rod; the page `theory/simulator` discretises it.

    Examples
    --------
    >>> from floquetrod.rod.loads.load import AxialLoad
    >>> problem = SimulationProblem(Rod.nitinol(), AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0), duration=0.01)
    >>> problem.time_steps.count, problem.replace(duration=0.02).time_steps.count
    (1197, 1995)
    """

    rod: Rod
    load: Load
    _: KW_ONLY
    duration: float = 2.0
    friction: float | Intervals = 0.0
    perturbation: Perturbation = None  # type: ignore[assignment]  # never None once it is made
    segments: int = None  # type: ignore[assignment]
    time_step: float | None = None
    frames: int = 400
    poisson_ratio: float = DiscreteRod.poisson_ratio
    indentation: float = DiscreteRod.indentation
    contact_damping: float = DiscreteRod.contact_damping
    feed_speed: float | None = None
    far_force: float | None = None
    tool: VibrationTool | None = None
    stop_early: bool = False
    natural_curvature: float | str = 0.0
    start: StartState | None = None

    def __post_init__(self) -> None:
        """Check and clean the parameters; the derived numbers raise for what they cannot be computed from."""
        require_known(validate.instance("rod", self.rod, Rod), ROD, "simulation")
        load = require_load("load", self.load)
        require_one_sine(load, "simulation")
        if load.noise:
            raise validate.wrong_value(
                "load",
                f"must have no noise to be simulated, got {noise_in_words(load.noise)}; give it ",
                Mention("noise", "noise=0", "0"),
            )
        start = _start(self.start)
        kick = self._first_kick(start)
        cleaned: dict[str, Any] = {
            "load": load,
            "perturbation": kick,
            "start": start,
            "duration": units.number("duration", self.duration, "time", math.ulp(0.0), hint="in s"),
            "frames": validate.integer("frames", self.frames, 2),
            "stop_early": validate.flag("stop_early", self.stop_early),
            "friction": _friction(self.friction),
            "time_step": None
            if self.time_step is None
            else units.number("time_step", self.time_step, "time", math.ulp(0.0), hint="in s"),
            "feed_speed": None
            if self.feed_speed is None
            else units.number("feed_speed", self.feed_speed, "speed", 0.0, hint="in m/s"),
            "far_force": None if self.far_force is None else load_number("mean", self.far_force, "far_force"),
            "natural_curvature": _natural_curvature(self.natural_curvature),
            "tool": None if self.tool is None else tool_inside(self.tool, self.rod.length, "rod"),
        }
        self._hold(cleaned)
        if start is not None:
            start.require_rod(self.rod)
            self._hold({"segments": start.segments if self.segments is None else self.segments})
        try:
            self._require_possible_ends()
            self._require_possible_channel()
            self._require_small_strain()
            self._hold({"segments": self._fair_segments() if self.segments is None else self.segments})
            mesh = self.mesh
            self._hold({name: getattr(mesh, name) for name in _OF_THE_MESH})
            kick.velocities(self.segments)
            if start is not None:
                start.require_mesh(self)
            _ = self.time_steps
        except ArithmeticError as error:  # of a rod whose data lie further apart than a double reaches
            raise ValueError(
                f"rod, load, indentation or contact_damping too extreme to be simulated ({error.args[-1]}); check "
                f"the units of {self.rod}"
            ) from None

    def __getstate__(self) -> dict[str, Any]:
        """Return the parameters alone: what follows from them is computed again in another process."""
        return {part.name: getattr(self, part.name) for part in fields(self)}

    @cached_property
    def mesh(self) -> DiscreteRod:
        """The discretised rod."""
        parts = {name: getattr(self, name) for name in _OF_THE_MESH}
        axis = self.driving.axis
        if axis is None:
            return DiscreteRod(self.rod, **parts)
        return RodInWell(self.rod, **parts, axis=axis, driving=self.driving, natural_curvature=self.natural_curvature)

    @cached_property
    def driving(self) -> Driving:
        """The driving of the ends along the channel."""
        return Driving(self.rod, self.load, self.feed_speed, self.far_force, self.tool)

    @property
    def wall_friction(self) -> Friction:
        """The friction along the channel."""
        return friction_along(self.friction)

    @cached_property
    def kick_alone(self) -> Kick:
        """What the perturbation does by itself, and what ends that motion."""
        return Kick.of(self.mesh, self.wall_friction, self.perturbation.velocities(self.segments))

    @cached_property
    def time_steps(self) -> TimeSteps:
        """The steps to be taken, with their number, how many between frames, their size in s, and the limit on it."""
        speed = float(np.abs(self.perturbation.velocities(self.segments)).max())
        steps = time_steps(self.mesh, self.duration, self.frames, self.time_step, speed)
        return steps if self.start is None else self.start.in_its_step(steps)

    @cached_property
    def lifted(self) -> float:
        """The part of the rod that rests off the wall, beside steps of the wall or of its radius; 0 for most rods."""
        if not self.rod.varies:
            return 0.0
        mesh = self.mesh
        places = mesh.recorded(mesh.start(self.driving, np.zeros(self.segments + 1)))[0]
        return float(np.mean(np.hypot(places[:, 1], places[:, 2]) < mesh.clearance_at(places[:, 0])))

    @property
    def start_words(self) -> str:
        """How the rod is set moving, in words."""
        if self.start is None:
            return str(self.perturbation)
        return f"the state of another run at {self.start.time:.4g} s, set moving by {self.perturbation}"

    @cached_property
    def earlier_motion(self) -> EarlierMotion | None:
        """The motion with which another run has left the rod, None for a rod that starts on the floor."""
        start, mesh = self.start, self.mesh
        if start is None:
            return None
        friction = self.wall_friction
        half_swing = math.pi * math.sqrt(float(np.max(mesh.clearance / mesh.gravity_on_wall)))
        return EarlierMotion(
            rest=rest_angles(
                mesh, self.driving, mesh.resumed(start.record, self.driving, friction, same_friction=True)
            ),
            angle=start.angle,
            buckled=start.buckled,
            damping=self.rod.damping_rate,
            friction=min(friction.values) > 0.0,
            grows=growing_waves(self.driving, _LONG * half_swing).fastest > 0,
            half_swing=half_swing,
        )

    @property
    def unresolved(self) -> str:
        """Modes that grow by theory and that too few segments cannot represent, in words; "" without any.

        An estimate: the growth with hinged ends under the largest force along the rod.
        """
        waves = self._growing
        if self.segments >= waves.least_segments:
            return ""
        highest = f" and modes up to {waves.highest} at half its rate or more" if waves.highest > waves.fastest else ""
        return (
            f"{self.segments} segments resolve modes up to {self.segments // LEAST_SEGMENTS}, and by theory mode "
            f"{waves.fastest} grows fastest{highest}"
        )

    @property
    def _coarseness(self) -> str:
        """What too few segments make wrong, and how many are enough, in words; "" where there are enough."""
        if not self.unresolved:
            return ""
        remedy = f"take {self._growing.least_segments} or more, or leave segments out for {self._fair_segments()}"
        if self.start is not None:
            remedy = f"take {self._growing.least_segments} or more in the run it starts from"
        return f"{self.unresolved}: the growing modes and their rates will be wrong; {remedy}"

    def replace(self, **changes: Any) -> SimulationProblem:
        """Return a copy with some parameters changed, checked again; a default number of segments is chosen again.

        Returns
        -------
        SimulationProblem
            Checked.

        Raises
        ------
        TypeError, ValueError
            As `SimulationProblem`.
        """
        if self.segments == self._fair_segments():
            changes = {"segments": None, **changes}
        return replace(self, **changes)

    def run(self, progress: Progress | None = None, checkpoint: str | Path | None = None) -> Simulation:
        """Simulate.

        Parameters
        ----------
        progress : callable, optional
            Called with the numbers of steps done and to do.
        checkpoint : path, optional
            A file that is kept up to date; when it exists at the start, the run continues from it, bit for bit the same
            as if it had never stopped.  A save that fails later warns with `CheckpointWarning`, is tried again, and
            loses no frame.

        Returns
        -------
        Simulation
            With ``complete`` False, and the frames so far, when interrupted by Ctrl-C.

        Raises
        ------
        SimulationDiverged
            When the rod leaves the range of the model; its ``simulation`` holds the frames before.
        ValueError
            Before anything is computed, for a checkpoint that cannot be written, is damaged, belongs to another run, is
            in use by one under way, or cannot be continued bit for bit here (the page `theory/simulator` says when).
        """
        place = None if checkpoint is None else validate.path("checkpoint", checkpoint)
        validate.progress(progress)
        if self._coarseness:
            warnings.warn(self._coarseness, ResolutionWarning, stacklevel=level_of_caller())
        return self._run(self.time_steps, progress, place)

    def _run(
        self, steps: TimeSteps, progress: Progress | None, place: Path | None, state: RunState | None = None
    ) -> Simulation:
        """Return the run from its start, from its checkpoint or from a state."""
        file = None if place is None else Checkpoint(place, self.as_dict() | {"time_steps": asdict(steps)})
        with file or nullcontext():
            return self._integration(file, steps, state).run(progress)

    def _integration(
        self, file: Checkpoint | None = None, steps: TimeSteps | None = None, state: RunState | None = None
    ) -> Integration[Simulation]:
        """Return the run at its start, or where its checkpoint or a state has come to."""
        steps = self.time_steps if steps is None else steps
        velocities = self.perturbation.velocities(self.segments)
        early = None
        if self.stop_early:
            clearly, start = self.kick_alone.clearly_buckled, self.start
            if start is not None and (start.buckled or start.angle > clearly):
                clearly = math.inf  # it began so
            early = EarlyEnd(self.wall_friction.largest, self._frames_in_a_period, clearly)
        result = partial(self._result, steps)
        return Integration(
            self.mesh, self.driving, self.wall_friction, steps, velocities, result, early, file, self.start, state
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the parameters as plain data, for files, which JSON preserves."""
        load = self.load.kind_as_dict() | {name: getattr(self.load, name) for name in QUANTITIES}
        start = None if self.start is None else self.start.as_dict()
        tool = None if self.tool is None else self.tool.as_dict()
        values = asdict(self) | {"rod": self.rod.as_dict(), "load": load, "start": start, "tool": tool}
        plain: dict[str, Any] = json.loads(json.dumps(values))
        for name, usual in (("natural_curvature", 0.0), ("tool", None), ("start", None)):
            if plain[name] == usual:
                del plain[name]  # files of rods without are those of versions without
        return plain

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> SimulationProblem:
        """Return the problem that `as_dict` wrote; ValueError, KeyError or TypeError for anything else."""
        kick = perturbation_from_dict(data["perturbation"])
        parts = {"rod": Rod(**data["rod"]), "load": load_from_dict(data["load"]), "perturbation": kick}
        if "start" in data:
            parts["start"] = StartState.from_dict(data["start"], _friction)
        if "tool" in data:
            parts["tool"] = VibrationTool(**data["tool"])
        problem = cls(**{**data, **parts})
        # As text: to Python 1, 1.0 and True are equal.
        if json.dumps(problem.as_dict(), sort_keys=True) != json.dumps(data, sort_keys=True):
            raise ValueError("its problem is not of the kinds it is written with")
        return problem

    def _first_kick(self, start: StartState | None) -> Perturbation:
        """Return what first set the rod moving."""
        kick = self.perturbation
        if start is not None:
            if kick is not None and kick != start.perturbation:
                raise validate.wrong_value(
                    "perturbation", f"must be left out with start, whose rod is moving already, got {kick}"
                )
            return start.perturbation
        kick = Perturbation.random(1e-3, seed=1) if kick is None else kick
        return validate.instance("perturbation", kick, Perturbation, "such as Perturbation.modes({8: 0.05})")

    def _hold(self, values: Mapping[str, Any]) -> None:
        """Set fields of this frozen value while it is made."""
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def _result(self, steps: TimeSteps, motion: RecordedMotion) -> Simulation:
        """Return the simulation whose frames these are."""
        recorded = {part.name: getattr(motion, part.name) for part in fields(motion)}
        return Simulation(problem=self, time_steps=steps, **recorded)

    @property
    def _frames_in_a_period(self) -> int:
        """The least number of frames that cover a period of the force and of the tool, at most all there are."""
        between = self.time_steps.per_frame * self.time_steps.size
        sines = () if self.tool is None else self.tool.sines
        slowest = min([self.load.frequency, *(frequency for _, frequency in sines)])
        return math.ceil(min(2.0 * math.pi / (slowest * between), float(self.frames)))

    def _fair_segments(self) -> int:
        """Return the number of segments that resolves the modes the load or the perturbation excites."""
        growing = self._growing
        likely = max(half_waves(self.rod, self.load, self.tool), self.perturbation.highest_mode, _LEAST_HALF_WAVES)
        wanted = max(_SEGMENTS_IN_HALF_WAVE * likely, _SEGMENTS_OF_FASTEST * growing.fastest, growing.least_segments)
        widest = max(like.radius for like in uniform_rods(self.rod))
        return min(math.ceil(min(wanted, MOST_SEGMENTS)), math.floor(min(self.rod.length / widest, 1e18)))

    @cached_property
    def _growing(self) -> GrowingWaves:
        """The modes that theory expects to grow."""
        return growing_waves(self.driving, self.duration)

    def _require_possible_ends(self) -> None:
        """Raise ValueError for a load that cannot be simulated, and for ends with two tasks at once."""
        load = self.load
        if len(load.harmonics) > MOST_HARMONICS:
            raise validate.wrong_value(
                "load",
                f"must have at most {MOST_HARMONICS} harmonics to be simulated, got {len(load.harmonics)}; leave "
                "out the highest",
            )
        lower = self.driving.far_end
        if self.feed_speed is not None and load.amplitude > 0.0 and lower != "driven":
            raise validate.wrong_value(
                "feed_speed",
                f"must not be given with a vibration of the upper end, got {self.feed_speed:g} m/s and an "
                f"amplitude of {load.amplitude:g} N; an AxialLoad vibrates the lower end",
            )
        if self.far_force is not None and lower == "held":
            raise validate.wrong_value(
                "far_force",
                f'must not be given with a lower end that is held, got {self.far_force:g} N; take far_end="free"',
            )

    def _require_possible_channel(self) -> None:
        """Raise ValueError for a channel that cannot be simulated, and a natural shape where there is none to have."""
        axis, natural = self.driving.axis, self.natural_curvature
        if axis is None and self.rod.curvature != 0.0:
            raise validate.wrong_value(
                "rod",
                "must have a path to be simulated where its channel bends: a curvature alone does not determine how "
                "the inclination changes; give path=WellPath.arc(...)",
            )
        shape = self.rod.natural_shape
        if shape is not None and shape.is_random:
            raise validate.wrong_value(
                "rod",
                f"must have a shape that is known to be simulated, got one {shape}; draw its deflection, and give that "
                "as natural_shape",
            )
        if shape is not None and self.feed_speed is not None:
            raise validate.wrong_value(
                "feed_speed", f"must not be given with a natural_shape, got {self.feed_speed!r}: it would stay behind"
            )
        if natural != 0.0 and axis is None:
            raise validate.wrong_value(
                "natural_curvature", f"is that of a rod with a path, got {natural!r} without one"
            )
        if natural != 0.0 and self.feed_speed is not None:
            raise validate.wrong_value(
                "natural_curvature", f"must not be given with feed_speed, got {natural!r}: it would stay behind"
            )
        gap = max(like.radial_clearance for like in uniform_rods(self.rod))
        if axis is not None and axis.sharpest * gap > _SHARPEST:
            raise validate.wrong_value(
                "rod",
                f"must lie on a path that bends by less than {_SHARPEST:g} of a radian over its radial clearance "
                f"{gap:g} m, got {axis.sharpest:.4g} 1/m; check the units of the survey",
            )

    def _require_small_strain(self) -> None:
        """Raise ValueError for a load beyond linear elasticity."""
        force = max(map(abs, self.driving.mean_forces)) + self.load.amplitude * np.abs(self.load.harmonics).sum()
        shaken = 0.0 if self.tool is None else sum(amplitude for amplitude, _ in self.tool.sines)
        strain = (force + shaken) / least_axial_rigidity(self.rod)
        if strain > LARGEST_STRAIN:
            raise validate.wrong_value(
                "load" if self.tool is None else "load with its tool",
                f"strains the rod by {strain:.2g}, must be at most {LARGEST_STRAIN:g}; its critical force is "
                f"{self.rod.critical_force:.4g} N: check the units",
            )


def _natural_curvature(value: Any) -> float | str:
    """Return the natural curvature of a rod in 1/m, which may be given with its unit, or "path"."""
    if isinstance(value, str) and units.unit_of(value) is None:
        return validate.choice("natural_curvature", value.strip().lower(), ("path",))
    hint = 'give it in 1/m, or "path"'
    return units.number("natural_curvature", value, "curvature", -_MOST_CURVED, _MOST_CURVED, hint)


def _friction(given: Any) -> float | Intervals:
    """Return a coefficient of friction, or pairs of a depth in m and the coefficient from there on."""
    along = friction_along(given)
    return along.values[0] if len(along.values) == 1 else tuple(zip(along.depths, along.values, strict=True))


def _start(given: Any) -> StartState | None:
    """Return the state of another run, given as a simulation, its file or the state."""
    if given is None or isinstance(given, StartState):
        return given
    if isinstance(given, Simulation):
        return StartState.after(given)
    if not isinstance(given, str | Path):
        raise validate.wrong_type(
            "start", f"must be a Simulation, or the path of its npz file, got {validate.short(given)}"
        )
    path = validate.path("start", given)
    try:
        run = Simulation.load(path)
    except ValueError as error:
        raise validate.wrong_value("start", f"must be a run in a npz file: {error}") from None
    return StartState.after(run)


_OF_THE_MESH = [part.name for part in fields(DiscreteRod) if part.name != "rod"]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Simulation(Reported, RecordedMotion):
    """The motion of a simulated rod.

    Attributes
    ----------
    problem : SimulationProblem
        The problem: rod, load, perturbation, friction, segments and so on.
    time_steps : TimeSteps
        The steps taken: their number, how many between frames, their size in s, and the limit on it.
    time : ndarray (frames,)
        In s.
    positions : ndarray (frames, nodes, 3)
        In m; x along the channel, z up, the axis of the channel at y = z = 0.  In a well x is the distance along its
        axis from the middle of the rod, z to the high side.
    velocities : ndarray (frames, nodes, 3)
        In m/s.
    end_forces : ndarray (frames, 2)
        Forces in N that push the upper and the lower end, each its mean since the frame before.
    energy : dict of ndarray (frames,)
        J: kinetic, stretch, bend, twist, gravity, contact (the latter two from rest on the floor), dissipated by
        contact, friction and damping together and apart ("dissipated_contact", ...), and the work of the end forces.
    ended : str
        How it ended: "duration" where nothing stopped it, "buckled" or "at rest" where it stopped early, "interrupted"
        by Ctrl-C; except for the last it is ``complete``.
    seconds : float
        Wall time it took.
    version : str
        Version of the package that made it.
    last_state : LastState or None
        The state after the last step, with which `continued` begins; None where a run diverged, and of files of
        versions that did not keep it.

    Simulations are equal when all but time taken and version is, bit for bit.
    """

    problem: SimulationProblem
    time_steps: TimeSteps
    version: str = field(default=__version__, compare=False)

    @property
    def rod(self) -> Rod:
        """The rod simulated."""
        return self.problem.rod

    def continued(
        self,
        duration: float | str = 0.0,
        *,
        progress: Progress | None = None,
        checkpoint: str | Path | None = None,
    ) -> Simulation:
        """Return the run made longer: all its frames, and those that follow from its last state.

        A run of T continued by T is one of 2 T with frames at the same distance, bit for bit.  It keeps its step: where
        the duration is no power of two times the first one, that of a run asked for at once may differ in the last
        digit.  It continues past an early end, and with the number of segments that it has.

        Parameters
        ----------
        duration : float or str
            Time to add in s, at least, in whole frames; 0 goes on to the end that was asked for at first, for a run
            that was interrupted or stopped early.
        progress : callable, optional
            Called with the numbers of steps done and to do.
        checkpoint : path, optional
            A file kept up to date, as for `SimulationProblem.run`.

        Returns
        -------
        Simulation

        Raises
        ------
        ValueError
            For a run without a last state, or whose last state cannot be continued bit for bit here, by the rule of
            checkpoints (page `theory/simulator`); for a duration of 0 of a run that is complete.

        Examples
        --------
        >>> import floquetrod as fr
        >>> load = fr.AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0)
        >>> run = fr.simulate(fr.Rod.nitinol(), load, duration=0.01, segments=60, frames=5)
        >>> longer = run.continued("10ms")
        >>> longer.time.size, longer == fr.simulate(run.rod, load, duration=0.02, segments=60, frames=9)
        (9, True)
        """
        validate.progress(progress)
        place = None if checkpoint is None else validate.path("checkpoint", checkpoint)
        added = units.number("duration", duration, "time", 0.0, hint="in s, 0 for the rest of the run")
        problem, steps, last = self.problem, self.time_steps, self.last_state
        more = math.ceil(added / (steps.per_frame * steps.size) - 1e-9)
        if not more and self.ended == "duration":
            raise validate.wrong_value(
                "duration", "must be positive for a run that is complete, got 0 s; give the time to add, such as 2 s"
            )
        if last is None:
            raise ValueError(
                "the run has no last state to continue from: it diverged, or an earlier version saved it; simulate it "
                "again with the longer duration"
            )
        if other := other_arithmetic(last.arithmetic):
            raise ValueError(f"the run cannot be continued bit for bit here: {other}")
        frames = problem.frames + more
        longer = replace(
            problem,
            duration=_longer(problem.duration, problem.frames - 1, frames - 1, steps),
            frames=frames,
            stop_early=problem.stop_early and self.ended not in ("buckled", "at rest"),
        )
        taken = replace(steps, count=(frames - 1) * steps.per_frame)
        (rod,), (before,) = (np.frombuffer(bytearray(part), problem.mesh.record_type) for part in last[:2])
        recorded = {
            "positions": self.positions,
            "velocities": self.velocities,
            "energies": np.stack([self.energy[name] for name in ENERGIES], axis=1),
            "impulses": last.impulses,
        }
        return longer._run(taken, progress, place, RunState(rod, before, recorded, self.seconds))

    def growth_rate(self, mode: int | None = None) -> GrowthFit:
        """Return the growth rate in 1/s of a mode or, by default, of the whole rod, with its error; zero for none.

        The whole rod is the fastest of the modes that show (1 % of the largest or more) where modes are independent,
        and the motion of all its nodes where they are coupled: by ends other than hinged, or a force that varies
        along the rod.  The motion is fitted up to an angle between 0.005 and 0.05 rad, the one with the least error,
        by `floquetrod.simulation.growth.fit_growth`; best when frames fall on equal parts of the forcing period.

        The error estimates the distance from Floquet theory with the axial wave kept, which is ``AxialWave(...,
        far_end="driven")`` for an `AxialLoad`: the error of the fit, and of the simulated rod, by theory.

        Returns
        -------
        GrowthFit
            ``rate`` in 1/s, with its error.

        Raises
        ------
        TypeError, ValueError
            For a mode that the segments cannot resolve, and where there is too little to fit: fewer than three
            forcing periods or 8 frames a period, a tool, or friction, with which nothing grows exponentially.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = fr.Rod.nitinol()
        >>> load = fr.AxialLoad(mean=0.2 * rod.critical_force, amplitude=0.2 * rod.critical_force, frequency=150.0)
        >>> run = fr.simulate(rod, load, duration=0.4, perturbation=fr.Perturbation.modes({7: 1e-4}))
        >>> fit = run.growth_rate()
        >>> abs(fit.rate - 4.2434927) < fit.error < 0.1
        True
        """
        if mode is not None:
            mode = validate.integer("mode", mode, 1, self._most_modes, self._why_no_more)
        problem = self.problem
        if problem.wall_friction.largest > 0.0:
            raise validate.wrong_value("growth_rate", "needs a frictionless run; with friction use mode_amplitudes")
        if problem.tool is not None:
            raise validate.wrong_value("growth_rate", "needs a run without a tool; with one use mode_amplitudes")
        return growth_of_motion(
            self, problem.rod, problem.load, mode, problem.duration, problem.frames, problem.indentation, problem.lifted
        )

    @cached_property
    def outcome(self) -> Outcome:
        """What has become of the rod, with the angle in rad at which it is; its ``kind`` "buckled" or another."""
        speeds = np.hypot(self.velocities[..., 1], self.velocities[..., 2])
        return outcome_of(self.time, self.angle, speeds, self.problem.kick_alone, self.problem.earlier_motion)

    @property
    def buckled(self) -> bool:
        """Whether the rod has buckled, by the rule of `floquetrod.simulation.outcome`.

        It was beyond 5 degrees in the last quarter of the time simulated, and neither at rest where friction holds it
        (up to arctan mu and 2 degrees), nor dying out, nor swinging at most twice as far as its kick alone makes it
        swing (any distance from one radian on), in a run too short for that to end; ``outcome`` distinguishes these.
        """
        return self.outcome.kind == "buckled"

    @property
    def buckled_at(self) -> float | None:
        """The first recorded time in s at which a node was beyond 5 degrees, None where the rod has not `buckled`."""
        earlier = self.problem.earlier_motion
        away = turned(self.angle, None if earlier is None else earlier.rest)
        beyond = np.abs(away).max(axis=1) > BUCKLED_ANGLE
        return float(self.time[np.argmax(beyond)]) if self.buckled else None

    def findings(self, *, theory: bool = True) -> Findings:
        """Return the fitted and the theoretical growth as `Findings`, which can be read as a report.

        Without ``theory`` only the simulation; theory takes half a minute for coupled modes of a kilometre.

        Returns
        -------
        Findings
            Its ``report()`` compares them.

        Raises
        ------
        TypeError
            For a ``theory`` other than True and False.
        """
        return Findings.of(self, theory=validate.flag("theory", theory))

    def report(self, units: Mapping[str, str] | None = None) -> Report:
        """Return the simulation in lines, without theory; `findings` compares.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.

        Raises
        ------
        TypeError, ValueError
            For another unit.
        """
        return self.findings(theory=False).report(units)

    def as_dict(self) -> dict[str, Any]:
        """Return the simulation as numbers for JSON, without theory, units in the keys; `findings` compares.

        Returns
        -------
        dict of str
            Numbers, texts and lists by name.
        """
        return self.findings(theory=False).as_dict()

    @cached_property
    def contact_force(self) -> NDArray[np.float64]:
        """Force per length in N/m with which the wall pushes every node, (frames, nodes); 0 where it is off the wall.

        By the contact law of the model, without the force that holds an end across the channel.
        """
        return contact_force(self.problem.mesh, self.positions, self.velocities)

    @cached_property
    def axial_force(self) -> NDArray[np.float64]:
        """Effective compression of every segment in N, (frames, segments); axial waves are part of it."""
        return axial_force(self.problem.mesh, self.problem.driving, self.positions)

    @property
    def left_wall(self) -> float:
        """Share of the frames of the last quarter in which a node is off the wall by more than 1 % of the clearance.

        Modes of the angle describe a rod that lies on the wall along its whole length.
        """
        radius = np.hypot(*np.moveaxis(self.positions[-self._last_quarter :, :, 1:], -1, 0))
        wall = self.problem.mesh.clearance_at(self.positions[-self._last_quarter :, :, 0])
        if self.rod.varies:  # beside a step of the wall the rod rests off it
            wall = np.minimum(wall, np.hypot(*self.positions[0, :, 1:].T))
        off = (radius < (1.0 - _OFF_THE_WALL) * wall).any(axis=1)
        return float(np.mean(off))

    @property
    def note(self) -> str:
        """Why the rod's mode may be another than the one named, "" without a reason.

        Too few segments for the modes that grow by theory, or a rod that has left the wall.
        """
        notes = [self.problem.unresolved] if self.buckled else []
        if self.left_wall > _MOSTLY_ON:
            notes.append(f"off the wall in {100.0 * self.left_wall:.0f} % of the frames of the last quarter")
        return "; ".join(filter(None, notes))

    @property
    def _outcome(self) -> str:
        """What came of the rod, with the mode where one can be named."""
        if not self.buckled:
            return self.outcome.words
        return "buckled" if self.named_mode is None else f"buckled in mode {self.named_mode}"

    @property
    def named_mode(self) -> int | None:
        """The dominant mode, or None for a rod that was off the wall during most of the last quarter of the run."""
        return None if self.left_wall > _MOSTLY_ON else self.dominant_mode

    @property
    def caption(self) -> str:
        """Load and friction of the simulation, in a line."""
        load, scale = self.problem.load, self.rod.critical_force
        return (
            f"mean {load.mean / scale:.3g} Fcr, amplitude {load.amplitude / scale:.3g} Fcr, "
            f"{load.frequency:.4g} rad/s, friction {self.problem.wall_friction}"
        )

    def __repr__(self) -> str:
        """Return what was simulated, and what came of it."""
        problem, steps = self.problem, self.time_steps
        early = f", {'interrupted' if self.ended == 'interrupted' else 'stopped'} at {self.time[-1]:.4g} s"
        end = "" if self.ended == "duration" else early
        note = f"; {self.note}" if self.note else ""
        return (
            f"<{self._outcome}, largest angle {math.degrees(self.largest_angle.max()):.3g} degrees; "
            f"{problem.duration:g} s of a rod of {problem.segments} segments, friction {problem.wall_friction}{end}; "
            f"{steps.count} steps of {1e6 * steps.size:.3g} us, set by {steps.limit}{note}>"
        )

    def plot(self, ax: Any = None) -> Any:
        """Draw the rod from above at five times of the last quarter, the last one black.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.
        """
        from floquetrod.plotting.rod_plot import draw_top_view

        return draw_top_view(self, ax)

    def plot_energy(self, ax: Any = None) -> Any:
        """Draw the energies over time.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.
        """
        from floquetrod.plotting.rod_plot import draw_energy

        return draw_energy(self, ax)

    def plot_growth(self, ax: Any = None) -> Any:
        """Draw the leading modes over time, dashed the growth that `Rod.stability` predicts.

        With friction nothing is predicted: growth is not exponential.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.
        """
        from floquetrod.plotting.rod_plot import draw_growth

        return draw_growth(self, self.leading_modes, self._predicted_rates, ax)

    def plot_run(self, figure: Any = None) -> Any:
        """Draw the rod from above over the growth of its leading modes, in a new figure by default.

        ``figure`` may be a figure or subfigure of matplotlib.

        Returns
        -------
        matplotlib.figure.Figure or SubFigure
            The figure drawn into.
        """
        from floquetrod.plotting.rod_plot import draw_run

        return draw_run(self, self.leading_modes, self._predicted_rates, figure)

    def animate(self) -> Any:
        """Return a matplotlib animation of the rod from above, of at most 200 pictures.

        Returns
        -------
        matplotlib.animation.FuncAnimation
            Keep it as long as it is shown.
        """
        from floquetrod.plotting.rod_plot import animate_top_view

        return animate_top_view(self)

    @property
    def _predicted_rates(self) -> tuple[float, ...]:
        """Growth in 1/s that the equations predict the leading modes, zero where they do not apply."""
        problem, load, modes = self.problem, self.problem.load, self.leading_modes
        driven = (problem.feed_speed, problem.far_force, problem.tool)
        if problem.wall_friction.largest > 0.0 or any(each is not None for each in driven):
            return (0.0,) * len(modes)
        return self.rod._modes_under(load).growth_of_modes(load, modes)

    def save(self, path: str | Path) -> Path:
        """Write everything to an npz file; an older file of that name is kept until the new one is complete.

        Returns
        -------
        Path
            Of the file written.

        Raises
        ------
        TypeError, ValueError
            For a path that is no text or path.
        OSError
            Where the file cannot be written.
        """
        meta = {
            "format": _FORMAT,
            "version": self.version,
            "problem": self.problem.as_dict(),
            "steps_per_frame": self.time_steps.per_frame,
            "step_limit": self.time_steps.limit,
            "step_size": self.time_steps.size,
            "ended": self.ended,
            "seconds": self.seconds,
        }
        arrays = {name: getattr(self, name) for name in ("time", "positions", "velocities", "end_forces")}
        if (last := self.last_state) is not None:
            meta["arithmetic"] = last.arithmetic
            arrays |= {f"last_{name}": getattr(last, name) for name in ("record", "before", "impulses")}
        energy = {f"energy_{name}": values for name, values in self.energy.items()}
        return sealed_files.write_npz(path, meta, {**arrays, **energy}, compress=True)

    @classmethod
    def load(cls, path: str | Path) -> Simulation:
        """Read a simulation that `save` wrote.

        Returns
        -------
        Simulation
            Equal to the simulation saved.

        Raises
        ------
        TypeError, ValueError
            For a file that is damaged, if only in one bit, or foreign.
        """
        return sealed_files.read_npz(path, _FORMAT, "a simulation", _simulation)


def _simulation(meta: dict[str, Any], arrays: sealed_files.Arrays) -> Simulation:
    """Return the simulation that a file describes; an error where it is not as `Simulation.save` writes it."""
    problem = SimulationProblem.from_dict(sealed_files.entry(meta, "problem", dict))
    # As they were taken: another version may choose others for the same problem.
    per_frame = validate.integer("steps_per_frame", sealed_files.entry(meta, "steps_per_frame", int), 1)
    limit = validate.choice("step_limit", meta["step_limit"], STEP_LIMITS)
    ended, seconds = validate.choice("ended", meta["ended"], ENDINGS), sealed_files.entry(meta, "seconds", float)
    (count,), nodes = sealed_files.require_shape(arrays, "time", (None,)), problem.segments + 1
    fits = (ended == "duration") == (count == problem.frames) and (problem.stop_early or ended in ENDINGS[::3])
    if not (1 <= count <= problem.frames and fits and seconds >= 0.0):
        raise validate.wrong_value(
            "it", f"has {count} of {problem.frames} frames, made in {seconds!r} s, and ended: {ended}"
        )
    time = sealed_files.field(arrays, "time", np.float64, (count,), finite=True)
    positions, velocities = (
        sealed_files.field(arrays, name, np.float64, (count, nodes, 3), finite=True)
        for name in ("positions", "velocities")
    )
    steps = TimeSteps.between_frames(problem.duration, problem.frames, per_frame, limit)
    if "step_size" in meta:  # of a run that was continued the last digit of a step may differ
        size = sealed_files.entry(meta, "step_size", float)
        low, high = (steps.size * factor for factor in (1.0 - 1e-12, 1.0 + 1e-12))
        steps = replace(steps, size=validate.within("step_size", size, low, high))
    energy = {
        name: sealed_files.field(arrays, f"energy_{name}", np.float64, (count,), finite=True)
        for name in (*ENERGIES, "dissipated")
    }
    return Simulation(
        problem=problem,
        time_steps=steps,
        time=time,
        positions=positions,
        velocities=velocities,
        end_forces=sealed_files.field(arrays, "end_forces", np.float64, (count, 2), finite=True),
        energy=energy,
        ended=ended,
        seconds=seconds,
        version=sealed_files.entry(meta, "version", str),
        last_state=_last_state(meta, arrays, problem.mesh.record_type.itemsize, count),
    )


def _longer(duration: float, before: int, after: int, steps: TimeSteps) -> float:
    """Return the duration in s of ``after`` frames from the duration of ``before`` frames.

    It is exact for whole multiples; otherwise the number of fifteen digits, as people write it, where the step taken
    follows from it.
    """
    product = duration * (after / before)
    written = float(f"{product:.15g}")
    is_written = after % before > 0 and written / (after * steps.per_frame) == steps.size
    return written if is_written else product


def _last_state(meta: dict[str, Any], arrays: sealed_files.Arrays, size: int, frames: int) -> LastState | None:
    """Return the state after the last step of a simulation in a file, None where the file has none."""
    if "arithmetic" not in meta:
        return None
    record, before = (sealed_files.field(arrays, f"last_{name}", np.uint8, (size,)) for name in ("record", "before"))
    impulses = sealed_files.field(arrays, "last_impulses", np.float64, (frames, 2), finite=True)
    return LastState(record, before, impulses, sealed_files.entry(meta, "arithmetic", dict))
