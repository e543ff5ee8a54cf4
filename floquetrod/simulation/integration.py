"""The integration of a simulated rod: pieces of steps, frames, checkpoints, Ctrl-C, divergence."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.compilation import compiled, compiled_for
from floquetrod._util.progress import Progress
from floquetrod.rod.answers.mean_force import friction_along
from floquetrod.simulation.arithmetic import arithmetic
from floquetrod.simulation.checkpoints import Checkpoint, Resumable, RunState, frame_shapes
from floquetrod.simulation.driving import Driving
from floquetrod.simulation.kernels import rod_step
from floquetrod.simulation.recorded_motion import EarlyEnd, LastState, RecordedMotion
from floquetrod.simulation.rod_mesh import ENERGIES, DiscreteRod
from floquetrod.simulation.start_state import StartState
from floquetrod.simulation.step_size import TimeSteps
from floquetrod.wells.drag import Friction

Result = TypeVar("Result", bound=RecordedMotion)

_ELEMENT_STEPS = 4_000_000  # in one call of the kernel: some 40 ms, so that Ctrl-C is handled (heuristic)
_LEAST_STEPS = 1000  # in one call, below which calling costs more than a hundredth (heuristic)


class SimulationDiverged(RuntimeError):
    """A simulated rod left the range of the model; ``simulation``, a `Simulation`, holds the frames before."""

    def __init__(self, message: str, simulation: Any) -> None:
        """Keep the frames before."""
        super().__init__(message)
        self.simulation = simulation

    def __reduce__(self) -> tuple[Any, ...]:
        """Tell pickle, and with it other processes, of both arguments."""
        return type(self), (str(self), self.simulation)


class Integration(Generic[Result]):
    """The state of a rod, whose clock counts the steps done, and the frames so far.

    Parameters
    ----------
    mesh : DiscreteRod
    driving : Driving
        Of the rod of this mesh.
    friction : Friction
        Along the channel.
    time_steps : TimeSteps
    velocities : ndarray (nodes,)
        Across the channel at the start, in m/s.
    result : callable
        Makes the result of a recorded motion.
    early_end : EarlyEnd, optional
        When to stop before the last step.
    checkpoint : Checkpoint, optional
        Continued from, where its file exists, and kept up to date.  ValueError for a file that cannot be continued.
    start : StartState, optional
        The state after another run, in place of the velocities.
    state : RunState, optional
        Continued from, without a checkpoint.  ValueError where it cannot be.
    """

    def __init__(
        self,
        mesh: DiscreteRod,
        driving: Driving,
        friction: Friction,
        time_steps: TimeSteps,
        velocities: NDArray[np.float64],
        result: Callable[[RecordedMotion], Result],
        early_end: EarlyEnd | None = None,
        checkpoint: Checkpoint | None = None,
        start: StartState | None = None,
        state: RunState | None = None,
    ) -> None:
        """Start, or continue from the checkpoint."""
        self.mesh, self.driving, self.time_steps = mesh, driving, time_steps
        self._steps_before = 0.0 if start is None else start.steps_before(time_steps.size)
        self.physics = mesh.physics(driving, time_steps.size, friction)._replace(steps_before=self._steps_before)
        self._make_result, self._early_end, self._checkpoint = result, early_end, checkpoint
        self._frames: dict[str, NDArray[np.float64]] = {
            name: np.zeros((time_steps.frames, *shape)) for name, shape in frame_shapes(mesh.segments).items()
        }
        self.seconds = 0.0
        if checkpoint is not None and checkpoint.exists():
            self._take(checkpoint.load(self._resumable))
        elif state is not None:
            done, before = (float(record["clock"][0]) for record in (state.rod, state.before))
            is_whole = done == int(done) and len(state.frames["impulses"]) == int(done) // time_steps.per_frame + 1
            if not (is_whole and 0.0 <= done - before <= self._piece):
                raise ValueError("the run cannot be continued: its last state does not belong to its frames")
            if other := self._resumable.other_rounding(state.before, state.rod):
                raise ValueError(f"the run cannot be continued bit for bit here: {other}")
            self._take(state)
        else:
            self.rod = self._start(velocities) if start is None else self._resumed(start, friction)
            self._before = self.rod.copy()
            self._keep_frame()

    @property
    def done(self) -> int:
        """Steps done."""
        return int(self.rod["clock"][0])

    @property
    def _piece(self) -> int:
        """Steps done in one call of the kernel, at most."""
        return max(_LEAST_STEPS, _ELEMENT_STEPS // self.mesh.segments)

    @property
    def _between_frames(self) -> int:
        """Steps done since the last frame."""
        return self.done % self.time_steps.per_frame

    def run(self, progress: Progress | None) -> Result:
        """Continue to the end, or to Ctrl-C; a checkpoint that cannot be written does not stop the run."""
        # Compiled before the clock starts: the first run of a process, or ever, takes no longer than the others.
        advance = compiled_for(rod_step.advance, self.rod, 1, self.physics)
        compiled_for(rod_step.drift, self.rod, 1.0, self.mesh.segments)
        started, earlier = time.monotonic(), self.seconds
        checkpoint, count = self._checkpoint, self.time_steps.count
        if checkpoint is not None:
            checkpoint.start_clock()
        try:
            while self._between_frames > 0 or self._ended() is None:
                left = self.time_steps.per_frame - self._between_frames
                self._before = self.rod.copy()
                advance(self.rod, min(self._piece, left), self.physics)
                self._require_sound()
                if self._between_frames == 0:
                    self._keep_frame()
                self.seconds = earlier + time.monotonic() - started
                if checkpoint is not None:
                    checkpoint.save_when_due(self._state)
                if progress is not None:
                    progress(self.done, count)
        except KeyboardInterrupt:
            # The state and its clock change together, inside the kernel; a frame may not have been kept yet.
            if self._between_frames == 0:
                self._keep_frame()
        result = self.result()
        if checkpoint is not None:
            checkpoint.save_at_the_end(self._state(), result)
        return result

    def result(self) -> Result:
        """Return the frames simulated so far."""
        steps, count = self.time_steps, self.done // self.time_steps.per_frame + 1
        energies = self._frames["energies"][:count]
        energy = dict(zip(ENERGIES, energies.T.copy(), strict=True))
        energy["dissipated"] = np.sum(
            [values for name, values in energy.items() if name.startswith("dissipated_")], axis=0
        )
        return self._make_result(
            RecordedMotion(
                time=(self._steps_before + np.arange(count, dtype=np.float64) * steps.per_frame) * steps.size,
                end_forces=self._end_forces(count),
                positions=self._frames["positions"][:count],
                velocities=self._frames["velocities"][:count],
                energy=energy,
                ended=self._ended() or "interrupted",
                seconds=self.seconds,
                last_state=LastState(
                    np.frombuffer(self.rod.tobytes(), np.uint8),
                    np.frombuffer(self._before.tobytes(), np.uint8),
                    self._frames["impulses"][:count],
                    arithmetic(),
                ),
            )
        )

    def _ended(self) -> str | None:
        """Return how the run has ended at the last frame kept, None where it goes on."""
        if self.done == self.time_steps.count:
            return "duration"
        kept = self.done // self.time_steps.per_frame + 1
        return None if self._early_end is None else self._early_end.of(self._frames["positions"][:kept])

    def _end_forces(self, count: int) -> NDArray[np.float64]:
        """Return the forces in N that push both ends, each its mean since the frame before, at first its mean."""
        forces = np.empty((count, 2))
        forces[0] = self.driving.mean_forces
        between = self.time_steps.per_frame * self.time_steps.size
        forces[1:] = np.diff(self._frames["impulses"][:count], axis=0) / between
        return forces

    def _start(self, velocities: NDArray[np.float64]) -> Any:
        """Return the rod at the start."""
        rod = self.mesh.start(self.driving, velocities, self.physics.friction)
        compiled(rod_step.drift)(rod, 0.5 * self.physics.step, self.mesh.segments)
        return rod

    def _resumed(self, start: StartState, friction: Friction) -> Any:
        """Return the rod as another run left it, with positions half a step of this run ahead."""
        rod = self.mesh.resumed(
            start.record, self.driving, friction, same_friction=friction_along(start.friction) == friction
        )
        if start.step != self.physics.step:
            for half in (-0.5 * start.step, 0.5 * self.physics.step):
                compiled(rod_step.drift)(rod, half, self.mesh.segments)
        return rod

    def _keep_frame(self) -> None:
        """Keep the frame that the clock has reached, with positions taken back to the time of the velocities."""
        place = self.done // self.time_steps.per_frame
        rod = self.rod.copy()
        compiled(rod_step.drift)(rod, -0.5 * self.physics.step, self.mesh.segments)
        self._frames["positions"][place], self._frames["velocities"][place] = self.mesh.recorded(rod)
        self._frames["energies"][place] = list(self.mesh.energies(rod, self.driving).values())
        self._frames["impulses"][place] = rod["impulse"][:2]

    def _require_sound(self) -> None:
        """Raise `SimulationDiverged` when a node has left the channel or a segment has been torn or crushed."""
        x, y, z = self.mesh.recorded(self.rod)[0].T
        step = self.time_steps.size
        far = float(np.hypot(y, z).max())
        stretch = float(np.abs(np.diff(x)).max()) / self.mesh.segment_length
        inside, whole = far < 2.0 * self.mesh.widest, stretch < 2.0  # both False for NaN
        if inside and whole:
            return
        when = self.done * step
        self.rod["clock"][0] -= (self.done - 1) % self.time_steps.per_frame + 1  # back to the last frame kept
        kept = replace(self.result(), last_state=None)
        cause = (
            "the rod hit the wall harder than its contact can bear with this step"
            if whole
            else "motion too violent for the linear elasticity and the time step of this run"
        )
        raise SimulationDiverged(
            f"the simulation diverged before t = {when:.6g} s; likely cause: {cause}; check perturbation and load, or "
            f"set time_step below {step:.3g} s; the {kept.time.size} frames before are kept",
            kept,
        )

    def _state(self) -> RunState:
        """Return what a checkpoint holds."""
        count = self.done // self.time_steps.per_frame + 1
        frames = {name: values[:count] for name, values in self._frames.items()}
        return RunState(self.rod, self._before, frames, self.seconds)

    @property
    def _resumable(self) -> Resumable:
        """What a state that is taken over is checked against."""

        def advance(rod: Any, steps: int) -> None:
            compiled(rod_step.advance)(rod, steps, self.physics)

        return Resumable(self.mesh.segments, self.mesh.record_type, self.time_steps, self._piece, advance)

    def _take(self, state: RunState) -> None:
        """Take over a state."""
        self.rod, self._before, frames, self.seconds = state
        for name, values in frames.items():
            self._frames[name][: len(values)] = values
