"""A simulation under way: pieces of steps, frames, checkpoints, Ctrl-C, divergence."""

from __future__ import annotations

import functools
import hashlib
import platform
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import compilation, files
from floquetrod._util.compilation import compiled, compiled_for
from floquetrod._util.version import __version__
from floquetrod.kernels import cosserat
from floquetrod.rod import data as rod_data
from floquetrod.rod import parts as rod_parts
from floquetrod.simulation import mesh as segmented
from floquetrod.simulation import result as simulation
from floquetrod.simulation.mesh import ENERGIES
from floquetrod.simulation.result import Setting, Simulation

Progress = Callable[[int, int], None]
"""Called with the number of steps done and their total."""

_FORMAT = "floquetrod checkpoint 2"
_AT_ONCE = 4_000_000  # element-steps in one call of the kernel: some 40 ms, so that Ctrl-C is heard (heuristic)
_LEAST_STEPS = 1000  # in one call, below which calling costs more than a hundredth (heuristic)
_BETWEEN_CHECKPOINTS = 5.0  # seconds of wall time (a choice)
_QUICK_SAVE = 0.25  # s: after one that takes longer, the next is put off as many times longer (a choice)


class SimulationDiverged(RuntimeError):
    """A simulated rod left every sensible state; ``simulation`` holds the frames before."""

    def __init__(self, message: str, simulation: Simulation) -> None:
        """Keep the frames before."""
        super().__init__(message)
        self.simulation = simulation

    def __reduce__(self) -> tuple[Any, ...]:
        """Tell pickle, and with it other processes, of both arguments."""
        return type(self), (str(self), self.simulation)


class CheckpointWarning(UserWarning):
    """A checkpoint could not be written; the run goes on, and its frames are kept in memory.

    Where warnings are errors, this one is raised at the end alone: ``simulation`` is then what `simulate` would have
    returned.
    """

    def __init__(self, message: str, simulation: Simulation | None = None) -> None:
        """Keep the result, if there is one yet."""
        super().__init__(message)
        self.simulation = simulation

    def __reduce__(self) -> tuple[Any, ...]:
        """Tell pickle of both arguments."""
        return type(self), (str(self), self.simulation)


class Course:
    """The state of a rod, which knows how many steps it has done, and the frames so far.

    ``checkpoint`` names a file to go on from, when it is there, and to keep up to date.
    """

    def __init__(self, setting: Setting, checkpoint: Path | None = None) -> None:
        """Start, or go on from the checkpoint; ValueError when that cannot be written, is damaged or of another run."""
        self.setting = setting
        self.checkpoint = None if checkpoint is None else files.writable(checkpoint)
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
            self.before = self.rod.copy()
            self._keep_frame()

    @property
    def done(self) -> int:
        """Steps done."""
        return int(self.rod["clock"][0])

    @property
    def _piece(self) -> int:
        """Steps done in one call of the kernel, at most."""
        return max(_LEAST_STEPS, _AT_ONCE // self.setting.segments)

    def run(self, progress: Progress | None) -> Simulation:
        """Go on to the end, or to Ctrl-C; a checkpoint that cannot be written costs nothing but itself."""
        setting = self.setting
        # Compiled before the clock starts: the first run of a process, or ever, takes no longer than the others.
        advance = compiled_for(cosserat.advance, self.rod, 1, self.physics)
        compiled_for(cosserat.drift, self.rod, 1.0, self.physics)
        started, earlier = time.monotonic(), self.seconds
        due = started + _BETWEEN_CHECKPOINTS
        try:
            while self.done < setting.steps:
                left = setting.steps_per_frame - self.done % setting.steps_per_frame
                self.before = self.rod.copy()
                advance(self.rod, min(self._piece, left), self.physics)
                self._check()
                if self.done % setting.steps_per_frame == 0:
                    self._keep_frame()
                now = time.monotonic()
                self.seconds = earlier + now - started
                if self.checkpoint is not None and now >= due:
                    self._save_on_the_way(self.checkpoint)
                    took = time.monotonic() - now
                    due = now + took + _BETWEEN_CHECKPOINTS * max(1.0, took / _QUICK_SAVE)
                if progress is not None:
                    progress(self.done, setting.steps)
        except KeyboardInterrupt:
            # The state and its clock change together, inside the kernel; a frame may not have been kept yet.
            if self.done % setting.steps_per_frame == 0:
                self._keep_frame()
        result = self.result()
        if self.checkpoint is not None:
            self._save_at_the_end(self.checkpoint, result)
        return result

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

    def _save_on_the_way(self, path: Path) -> None:
        """Write the checkpoint, or warn."""
        with suppress(CheckpointWarning):  # raised where warnings are errors: the run is worth more
            try:
                self._save(path)
            except (OSError, ValueError, MemoryError) as error:
                text = f"checkpoint {path} cannot be written ({_cause(error)}); the run goes on, and will try again"
                warnings.warn(CheckpointWarning(text), stacklevel=4)

    def _save_at_the_end(self, path: Path, result: Simulation) -> None:
        """Write the checkpoint, or warn, Ctrl-C included: the result is there and wants to be returned."""
        try:
            self._save(path)
        except (OSError, ValueError, MemoryError, KeyboardInterrupt) as error:
            text = f"checkpoint {path} has not been brought up to date ({_cause(error)}); the result is in memory"
            warnings.warn(CheckpointWarning(text, result), stacklevel=4)

    def _save(self, path: Path) -> None:
        """Write the checkpoint: the state, the one a piece of steps before it, and all frames."""
        count = self.done // self.setting.steps_per_frame + 1
        meta = {
            "format": _FORMAT,
            "version": __version__,
            "arithmetic": _arithmetic(),
            "setting": self.setting.as_dict(),
            "seconds": self.seconds,
        }
        states = {
            name: np.frombuffer(rod.tobytes(), np.uint8) for name, rod in (("state", self.rod), ("before", self.before))
        }
        arrays = {name: values[:count] for name, values in self.frames.items()}
        files.write_npz(path, meta, states | arrays, compress=False)

    def _resume(self, path: Path) -> None:
        """Go on from the checkpoint; ValueError when it is damaged, of another run, or not to be continued here."""
        foreign, self.seconds = files.read_npz(path, _FORMAT, "a checkpoint of a simulation", self._take)
        if foreign:
            raise ValueError(f"checkpoint {path} {foreign}, or remove it to start anew")

    def _take(self, meta: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> tuple[str, float]:
        """Take over what a checkpoint holds; return why it is not for this run, or "", and the seconds it took."""
        unlike = f"of floquetrod {files.entry(meta, 'version', str)} cannot be continued to the bit here"
        theirs, ours = files.entry(meta, "arithmetic", dict), _arithmetic()
        if theirs != ours:
            other = [f"{name} {value}" for name, value in theirs.items() if ours.get(name) != value]
            return f"{unlike}: it was computed with {', '.join(other)}; continue it where that is installed", 0.0
        mine, setting = self.setting.as_dict(), files.entry(meta, "setting", dict)
        if wrong := [name for name in mine if setting[name] != mine[name]]:
            return f"belongs to another run, with another {', '.join(wrong)}; give another path", 0.0
        self.before, self.rod = (self._state(arrays, name) for name in ("before", "state"))
        count = self.done // self.setting.steps_per_frame + 1
        for name, kept in self.frames.items():
            kept[:count] = files.field(arrays, name, np.float64, (count, *kept.shape[1:]), finite=True)
        rehearsed, steps = self.before.copy(), self.done - int(self.before["clock"][0])
        if not 0 <= steps <= self._piece:
            raise ValueError("its states do not follow one another")
        # The sources are the same, but a processor or a system's library may differ in a last digit.
        compiled(cosserat.advance)(rehearsed, steps, self.physics)
        if rehearsed.tobytes() != self.rod.tobytes():
            return f"{unlike}: its last {steps} steps come out otherwise; continue it on the machine that wrote it", 0.0
        return "", files.entry(meta, "seconds", float)

    def _state(self, arrays: dict[str, NDArray[Any]], name: str) -> Any:
        """Return the record of a rod that a checkpoint holds under ``name``."""
        layout = cosserat.rod_type(self.setting.segments)
        (rod,) = np.frombuffer(bytearray(files.field(arrays, name, np.uint8, (layout.itemsize,))), dtype=layout)
        clock = float(rod["clock"][0])
        if not (0.0 <= clock <= self.setting.steps and clock == int(clock)):
            raise ValueError(f"the clock of its {name} shows {clock!r} steps")
        return rod


def _cause(error: BaseException) -> str:
    """Return why a save failed, in a few words."""
    return getattr(error, "strerror", None) or str(error) or type(error).__name__


@functools.cache
def _arithmetic() -> dict[str, str]:
    """Return what the bits of a run depend on, other than its setting and the processor's own arithmetic."""
    import numba

    digest = hashlib.sha256(Path(__file__).read_bytes())
    for module in (compilation, cosserat, rod_data, rod_parts, segmented, simulation):
        digest.update(Path(str(module.__file__)).read_bytes())
    return {
        "floquetrod": __version__,
        "sources": digest.hexdigest()[:16],
        "numba": numba.__version__,
        "numpy": np.__version__,
        "machine": f"{platform.system()} {platform.machine()}",
    }
