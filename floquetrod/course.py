"""A simulation under way: pieces of steps, frames, checkpoints, Ctrl-C, divergence."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod import _files
from floquetrod._compile import compiled, compiled_for
from floquetrod.kernels import cosserat
from floquetrod.segmented import ENERGIES
from floquetrod.simulation import Setting, Simulation

Progress = Callable[[int, int], None]
"""Called with the number of steps done and their total."""

_FORMAT = "floquetrod checkpoint 1"
_AT_ONCE = 4_000_000  # element-steps in one call of the kernel: some 40 ms, so that Ctrl-C is heard (heuristic)
_LEAST_STEPS = 1000  # in one call, below which calling costs more than a hundredth (heuristic)
_BETWEEN_CHECKPOINTS = 5.0  # seconds of wall time (a choice)


class SimulationDiverged(RuntimeError):
    """A simulated rod left every sensible state; ``simulation`` holds the frames before."""

    def __init__(self, message: str, simulation: Simulation) -> None:
        """Keep the frames before."""
        super().__init__(message)
        self.simulation = simulation


class Course:
    """The state of a rod, which knows how many steps it has done, and the frames so far.

    ``checkpoint`` names a file to go on from, when it is there, and to keep up to date.
    """

    def __init__(self, setting: Setting, checkpoint: Path | None = None) -> None:
        """Start, or go on from the checkpoint; ValueError when that is damaged or belongs to another run."""
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
        # Compiled before the clock starts: the first run of a process, or ever, takes no longer than the others.
        advance = compiled_for(cosserat.advance, self.rod, 1, self.physics)
        compiled_for(cosserat.drift, self.rod, 1.0, self.physics)
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
        compiled(cosserat.drift)(rod, 0.5 * self.setting.time_step, self.physics)
        return rod

    def _keep_frame(self) -> None:
        """Keep the frame that the clock has reached, with positions taken back to the time of the velocities."""
        n, place = self.setting.segments, self.done // self.setting.steps_per_frame
        rod = self.rod.copy()
        compiled(cosserat.drift)(rod, -0.5 * self.setting.time_step, self.physics)
        for axis, name in enumerate("xyz"):
            self.frames["positions"][place, :, axis] = rod[name][: n + 1]
            self.frames["velocities"][place, :, axis] = rod[f"v{name}"][: n + 1]
        self.frames["energies"][place] = list(self.cut.energies(rod).values())

    def _check(self) -> None:
        """Raise `SimulationDiverged` when a node has left the channel or a segment has been torn or crushed."""
        n, rod = self.setting.segments, self.rod
        far = float(np.hypot(rod["y"][: n + 1], rod["z"][: n + 1]).max())
        stretch = float(np.abs(np.diff(rod["x"][: n + 1])).max()) / self.cut.segment_length
        inside, whole = far < 2.0 * self.setting.rod.channel_radius, stretch < 2.0  # both False for NaN
        if inside and whole:
            return
        when = self.done * self.setting.time_step
        kept = self.result_before()
        cause = (
            "the rod hit the wall harder than its contact can bear with this step"
            if whole
            else "motion too violent for the linear elasticity and the time step of this run"
        )
        raise SimulationDiverged(
            f"the simulation diverged before t = {when:.6g} s; likely cause: {cause}; check perturbation and load, or "
            f"set time_step below {self.setting.time_step:.3g} s; the {kept.time.size} frames before are kept",
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
            layout = cosserat.rod_type(other.segments)
            (self.rod,) = np.frombuffer(bytearray(arrays["state"].tobytes()), dtype=layout)
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
        for name, values in found.items():
            self.frames[name][: len(values)] = values
