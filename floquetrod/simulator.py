"""`fr.simulate`: the whole nonlinear rod, step by step, as a confirmation that owes nothing to the mode analysis."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod import _files, _validate
from floquetrod._compile import compiled
from floquetrod.kernels import cosserat
from floquetrod.load import AxialLoad
from floquetrod.perturbation import Perturbation
from floquetrod.rod import Rod
from floquetrod.segmented import ENERGIES, SegmentedRod
from floquetrod.simulation import Setting, Simulation

Progress = Callable[[int, int], None]
"""Called with the number of steps done and their total."""

_FORMAT = "floquetrod checkpoint 1"
_AT_ONCE = 4_000_000  # element-steps in one call of the kernel: some 40 ms, so that Ctrl-C is heard (heuristic)
_LEAST_STEPS = 1000  # in one call, below which calling costs more than a hundredth (heuristic)
_BETWEEN_CHECKPOINTS = 5.0  # seconds of wall time (a choice)
_LARGEST_STRAIN = 0.02  # that a load may cause: beyond it linear elasticity has no meaning (a choice)


class SimulationDiverged(RuntimeError):
    """A simulated rod left every sensible state; ``simulation`` holds the frames before."""

    def __init__(self, message: str, simulation: Simulation) -> None:
        """Keep the frames before."""
        super().__init__(message)
        self.simulation = simulation


def simulate(
    rod: Rod,
    load: AxialLoad,
    duration: float = 2.0,
    friction: float = 0.0,
    perturbation: Perturbation | None = None,
    segments: int = 250,
    time_step: float | None = None,
    frames: int = 400,
    progress: Progress | None = None,
    checkpoint: str | Path | None = None,
    poisson_ratio: float = 0.33,
    indentation: float = 1e-4,
    contact_damping: float = 0.3,
) -> Simulation:
    """Simulate a rod in its channel: stretch, shear, bending and twist, contact with the wall, Coulomb friction.

    The rod starts straight on the floor, squeezed by the mean force, with the speeds of ``perturbation``; its ends are
    hinged there, free to move along the channel, and pushed inwards by F(t).

    Parameters
    ----------
    rod : Rod
    load : AxialLoad
        Must strain the rod by less than 0.02.
    duration : float
        s.
    friction : float
        mu, static = kinetic, along the channel and around it.
    perturbation : Perturbation, optional
        By default Perturbation.random(1e-3, seed=1).
    segments : int
        At least 6 for every half wave of the critical mode and of those the perturbation names; none shorter than the
        rod's radius.
    time_step : float, optional
        The largest step to take, in s; by default the largest safe one.  Frames come at equal numbers of steps, so the
        step taken is a little smaller.  ValueError for one that is not safe.
    frames : int
        Frames kept, the start and the end among them.
    progress : callable, optional
        Called with the numbers of steps done and to do.
    checkpoint : path, optional
        A file that is kept up to date; when it is there at the start, the run goes on from it, to the bit the same as
        if it had never stopped.  ValueError when it is damaged or belongs to another run.
    poisson_ratio, indentation, contact_damping : float
        See `floquetrod.segmented.SegmentedRod`.

    Returns
    -------
    Simulation
        With ``complete`` False, and the frames so far, when interrupted by Ctrl-C.

    Raises
    ------
    SimulationDiverged
        When the rod leaves every sensible state; its ``simulation`` holds the frames before.

    Notes
    -----
    The model of section 3.3 of DOI 10.1115/1.4031710, for any rod; docs/simulator.md says how it is discretised.

    Examples
    --------
    >>> rod = Rod.nitinol()
    >>> load = AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0)
    >>> run = simulate(rod, load, duration=0.01, segments=60, frames=5)
    >>> run.angle.shape, run.complete
    ((5, 61), True)
    """
    setting = _setting(
        rod, load, duration, friction, perturbation, segments, time_step, frames, poisson_ratio, indentation,
        contact_damping,
    )  # fmt: skip
    course = _Course(setting, None if checkpoint is None else Path(checkpoint))
    return course.run(progress)


def _setting(
    rod: Rod,
    load: AxialLoad,
    duration: float,
    friction: float,
    perturbation: Perturbation | None,
    segments: int,
    time_step: float | None,
    frames: int,
    poisson_ratio: float,
    indentation: float,
    contact_damping: float,
) -> Setting:
    """Check what was asked for, and choose the step."""
    if not isinstance(rod, Rod):
        raise TypeError(f"rod must be a Rod, got {rod!r}")
    if not isinstance(load, AxialLoad):
        raise TypeError(f"load must be an AxialLoad, got {load!r}")
    kick = Perturbation.random(1e-3, seed=1) if perturbation is None else perturbation
    if not isinstance(kick, Perturbation):
        raise TypeError(f"perturbation must be a Perturbation such as Perturbation.modes({{8: 0.05}}), got {kick!r}")
    duration = _validate.positive("duration", duration, "in s")
    frames = _validate.integer("frames", frames, 2)
    strain = (abs(load.mean) + load.amplitude) / (rod.youngs_modulus * rod.area)
    if strain > _LARGEST_STRAIN:
        raise ValueError(
            f"load strains the rod by {strain:.2g}, must be at most {_LARGEST_STRAIN:g}; its critical force is "
            f"{rod.critical_force:.4g} N: check the units"
        )
    cut = SegmentedRod(rod, segments, poisson_ratio, indentation, contact_damping)
    safe, limit = cut.safe_step(float(np.abs(kick.velocities(cut.segments)).max()))
    if time_step is None:
        step = safe
    else:
        step, limit = _validate.positive("time_step", time_step, "in s"), "choice"
        if step > safe:
            raise ValueError(
                f"time_step must be at most {safe:.4g} s, got {step:.4g} s: a longer one is unstable, by "
                f"{cut.safe_step()[1]}; leave it out, or take fewer segments"
            )
    return Setting(
        rod=rod,
        load=load,
        perturbation=kick,
        duration=duration,
        friction=_validate.nonnegative("friction", friction, "mu is a coefficient such as 0.1"),
        segments=cut.segments,
        frames=frames,
        steps_per_frame=math.ceil(duration / (frames - 1) / step),
        poisson_ratio=cut.poisson_ratio,
        indentation=cut.indentation,
        contact_damping=cut.contact_damping,
        step_limit=limit,
    )


class _Course:
    """A simulation under way: the state of the rod, which knows how many steps it has done, and the frames so far."""

    def __init__(self, setting: Setting, checkpoint: Path | None) -> None:
        self.setting = setting
        self.checkpoint = checkpoint
        self.cut = setting.segmented
        self.physics = self.cut.physics(setting.load, setting.time_step, setting.friction)
        frames, nodes = setting.frames, setting.segments + 1
        self.frames: dict[str, NDArray[np.float64]] = {
            "positions": np.zeros((frames, nodes, 3)),
            "velocities": np.zeros((frames, nodes, 3)),
            "energies": np.zeros((frames, len(ENERGIES))),
        }
        self.seconds = 0.0
        if checkpoint is not None and checkpoint.exists():
            self._resume(checkpoint)
        else:
            self.rod = self._start()
            self._keep_frame()

    @property
    def done(self) -> int:
        """Steps done."""
        return int(self.rod["clock"][0])

    def run(self, progress: Progress | None) -> Simulation:
        """Go on to the end, or to Ctrl-C."""
        setting = self.setting
        piece = max(_LEAST_STEPS, _AT_ONCE // setting.segments)
        advance = compiled(cosserat.advance)
        started, before = time.monotonic(), self.seconds
        saved = started
        try:
            while self.done < setting.steps:
                left = setting.steps_per_frame - self.done % setting.steps_per_frame
                advance(self.rod, min(piece, left), self.physics)
                self._check()
                if self.done % setting.steps_per_frame == 0:
                    self._keep_frame()
                now = time.monotonic()
                self.seconds = before + now - started
                if self.checkpoint is not None and now - saved > _BETWEEN_CHECKPOINTS:
                    self._save(self.checkpoint)
                    saved = now
                if progress is not None:
                    progress(self.done, setting.steps)
        except KeyboardInterrupt:
            # The state and its clock change together, inside the kernel; a frame may not have been kept yet.
            if self.done % setting.steps_per_frame == 0:
                self._keep_frame()
        if self.checkpoint is not None:
            self._save(self.checkpoint)
        return self.result()

    def result(self) -> Simulation:
        """Return what has been simulated so far."""
        setting = self.setting
        count = self.done // setting.steps_per_frame + 1
        energies = self.frames["energies"][:count]
        energy = dict(zip(ENERGIES, energies.T.copy(), strict=True))
        energy["dissipated"] = np.sum(
            [values for name, values in energy.items() if name.startswith("dissipated_")], axis=0
        )
        return Simulation(
            setting=setting,
            time=np.arange(count, dtype=np.float64) * setting.steps_per_frame * setting.time_step,
            positions=self.frames["positions"][:count],
            velocities=self.frames["velocities"][:count],
            energy=energy,
            complete=self.done == setting.steps,
            seconds=self.seconds,
        )

    def _start(self) -> Any:
        """Return the rod at the start; every segment turns with the nodes it lies between."""
        n, cut = self.setting.segments, self.cut
        rod = cut.at_rest(self.setting.load.mean)
        rod["vy"][: n + 1] = self.setting.perturbation.velocities(n)
        rod["w3"][:n] = np.diff(rod["vy"][: n + 1]) / cut.segment_length
        cut.set_off(rod)
        compiled(cosserat.drift)(rod, n, 0.5 * self.setting.time_step)
        return rod

    def _keep_frame(self) -> None:
        """Keep the frame that the clock has reached, with positions taken back to the time of the velocities."""
        n, place = self.setting.segments, self.done // self.setting.steps_per_frame
        rod = self.rod.copy()
        compiled(cosserat.drift)(rod, n, -0.5 * self.setting.time_step)
        for axis, name in enumerate("xyz"):
            self.frames["positions"][place, :, axis] = rod[name][: n + 1]
            self.frames["velocities"][place, :, axis] = rod[f"v{name}"][: n + 1]
        self.frames["energies"][place] = list(self.cut.energies(rod).values())

    def _check(self) -> None:
        """Raise `SimulationDiverged` when a node has left the channel or a segment has been torn or crushed."""
        n, rod = self.setting.segments, self.rod
        far = float(np.hypot(rod["y"][: n + 1], rod["z"][: n + 1]).max())
        stretch = float(np.abs(np.diff(rod["x"][: n + 1])).max()) / self.cut.segment_length
        sound = far < 2.0 * self.setting.rod.channel_radius and stretch < 2.0  # False for NaN
        if sound:
            return
        when = self.done * self.setting.time_step
        kept = self.result_before()
        cause = (
            "the rod hit the wall harder than its contact can bear with this step"
            if far >= 2.0 * self.setting.rod.channel_radius and stretch < 2.0
            else "motion too violent for the linear elasticity and the time step of this run"
        )
        raise SimulationDiverged(
            f"the simulation diverged before t = {when:.6g} s; likely cause: {cause}; check perturbation and load, or "
            f"set time_step below {self.setting.time_step:.3g} s. The {kept.time.size} frames before are in "
            "error.simulation",
            kept,
        )

    def result_before(self) -> Simulation:
        """Return the frames kept so far, when the state itself is no longer sound."""
        self.rod["clock"][0] -= (self.done - 1) % self.setting.steps_per_frame + 1
        return self.result()

    def _save(self, path: Path) -> None:
        """Write the checkpoint."""
        count = self.done // self.setting.steps_per_frame + 1
        meta = {"format": _FORMAT, "setting": self.setting.as_dict(), "seconds": self.seconds}
        state = np.frombuffer(self.rod.tobytes(), dtype=np.uint8)
        arrays = {name: values[:count] for name, values in self.frames.items()}
        _files.write_npz(path, meta, {"state": state, **arrays}, compress=False)

    def _resume(self, path: Path) -> None:
        """Read the checkpoint."""
        meta, arrays = _files.read_npz(path, _FORMAT, "a checkpoint of a simulation")
        try:
            other = Setting.from_dict(meta["setting"])
            state = arrays["state"].tobytes()
            self.seconds = float(meta["seconds"])
            found = {name: arrays[name] for name in self.frames}
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{path} is not a checkpoint of a simulation that can be read: {error}") from None
        if other != self.setting:
            wrong = [name for name, value in other.as_dict().items() if value != self.setting.as_dict()[name]]
            raise ValueError(
                f"checkpoint {path} belongs to another run, with another {', '.join(wrong)}; give another path, or "
                "remove it to start anew"
            )
        self.rod = np.frombuffer(bytearray(state), dtype=cosserat.rod_type(self.setting.segments))[0]
        for name, values in found.items():
            self.frames[name][: len(values)] = values
