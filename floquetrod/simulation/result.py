"""What a simulated rod did: frames, energies, modes, growth."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import files, validate
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.version import __version__
from floquetrod.rod.load import AxialLoad
from floquetrod.rod.rod import Rod
from floquetrod.simulation.growth import LEAST_PER_PERIOD, GrowthFit, fit_growth
from floquetrod.simulation.mesh import ENERGIES, STEP_LIMITS, DiscreteRod
from floquetrod.simulation.start import LEAST_SEGMENTS, Perturbation

BUCKLED_ANGLE = math.radians(5.0)
"""Angle beyond which a rod counts as buckled, that of the paper (section 4.3 of DOI 10.1115/1.4031710)."""

_LINEAR_UP_TO = 0.05  # rad: up to here sin(theta) is theta to 4e-4 (a choice)
_FORMAT = "floquetrod simulation 2"


@dataclass(frozen=True)
class Setting:
    """Everything a simulation's course depends on, in SI units; see `floquetrod.simulate.simulate`."""

    rod: Rod
    load: AxialLoad
    perturbation: Perturbation
    duration: float
    friction: float
    segments: int
    frames: int
    steps_per_frame: int
    poisson_ratio: float
    indentation: float
    contact_damping: float
    step_limit: str

    @property
    def time_step(self) -> float:
        """Length of a time step in s."""
        return self.duration / ((self.frames - 1) * self.steps_per_frame)

    @property
    def steps(self) -> int:
        """Number of time steps."""
        return (self.frames - 1) * self.steps_per_frame

    @property
    def segmented(self) -> DiscreteRod:
        """The rod as it is cut into segments."""
        return DiscreteRod(self.rod, self.segments, self.poisson_ratio, self.indentation, self.contact_damping)

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain data, for files: what JSON gives back as it was."""
        plain: dict[str, Any] = json.loads(json.dumps(asdict(self)))
        return plain

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Setting:
        """Return the setting that `as_dict` wrote; ValueError, KeyError or TypeError for anything else."""
        kick = Perturbation(*(tuple((a, b) for a, b in data["perturbation"][name]) for name in ("speeds", "noises")))
        rest = {name: value for name, value in data.items() if name not in ("rod", "load", "perturbation")}
        setting = cls(rod=Rod(**data["rod"]), load=AxialLoad(**data["load"]), perturbation=kick, **rest)
        validate.positive("duration", setting.duration)
        validate.nonnegative("friction", setting.friction)
        validate.integer("frames", setting.frames, 2)
        validate.integer("steps_per_frame", setting.steps_per_frame, 1)
        validate.choice("step_limit", setting.step_limit, STEP_LIMITS)
        kick.velocities(setting.segmented.segments)
        # As text: to Python 1, 1.0 and True are equal.
        if json.dumps(setting.as_dict(), sort_keys=True) != json.dumps(data, sort_keys=True):
            raise ValueError("its setting is not of the kinds it is written with")
        return setting


@dataclass(frozen=True, eq=False, repr=False)
class Simulation(NoTruthValue, ByContent):
    """The course of a simulated rod.

    Attributes
    ----------
    setting : Setting
        What was simulated: rod, load, perturbation, friction, segments and so on.
    time : ndarray (frames,)
        s.
    positions, velocities : ndarray (frames, nodes, 3)
        m and m/s; x along the channel, z up, the axis of the channel at y = z = 0.
    energy : dict of ndarray (frames,)
        J: kinetic, stretch, shear, bend, twist, gravity, contact (the latter two from rest on the floor), dissipated by
        contact, friction and damping together and apart ("dissipated_contact", ...), and the work of the end forces.
    complete : bool
        Whether it reached its end; False when it was interrupted.
    seconds : float
        Wall time it took.
    version : str
        Version of the package that made it.

    Simulations are equal when all but time taken and version is, to the bit.
    """

    ask = ".buckled"

    setting: Setting
    time: NDArray[np.float64]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]
    energy: dict[str, NDArray[np.float64]]
    complete: bool
    seconds: float = field(compare=False)
    version: str = field(default=__version__, compare=False)

    @property
    def rod(self) -> Rod:
        """The rod simulated."""
        return self.setting.rod

    @cached_property
    def angle(self) -> NDArray[np.float64]:
        """Angle theta of every node around the channel's axis in rad, 0 on the floor, (frames, nodes)."""
        return np.arctan2(self.positions[:, :, 1], -self.positions[:, :, 2])

    @property
    def largest_angle(self) -> NDArray[np.float64]:
        """Largest abs(theta) of any node in rad, (frames,)."""
        return np.asarray(np.abs(self.angle).max(axis=1))

    def mode_amplitudes(self, modes: Iterable[int]) -> NDArray[np.float64]:
        """Return A_m of theta = sum_m A_m sin(m pi s / L) in rad, (frames, modes).

        Raises ValueError for a mode that has fewer than 6 segments in half a wave.
        """
        return self._amplitudes(validate.integers("modes", modes, 1, self._most_modes, self._why_no_more))

    @property
    def _why_no_more(self) -> str:
        return f"with {self.setting.segments} segments no higher mode is resolved"

    @property
    def _most_modes(self) -> int:
        """The highest mode that has enough segments in half a wave."""
        return self.setting.segments // LEAST_SEGMENTS

    def _amplitudes(self, modes: Iterable[int]) -> NDArray[np.float64]:
        nodes = np.arange(self.setting.segments + 1) * (math.pi / self.setting.segments)
        shapes = np.sin(np.multiply.outer(nodes, np.asarray(tuple(modes), dtype=np.float64)))
        return np.asarray(self.angle @ shapes * (2.0 / self.setting.segments))

    def growth_rate(self, mode: int) -> GrowthFit:
        """Return the growth rate of a mode in 1/s with the times it was fitted to; zero when it does not grow.

        Fitted up to the time at which any node's angle passes 0.05 rad, beyond which the motion is no longer linear, by
        `floquetrod.growth.fit_growth`; best when frames fall on equal parts of the forcing period.  Raises ValueError
        when there is too little to fit: fewer than three forcing periods or 8 frames a period, or friction, with which
        nothing grows exponentially.

        Examples
        --------
        >>> import floquetrod as fr
        >>> rod = fr.Rod.nitinol()
        >>> load = fr.AxialLoad(mean=0.2 * rod.critical_force, amplitude=0.2 * rod.critical_force, frequency=150.0)
        >>> run = fr.simulate(rod, load, 0.4, perturbation=fr.Perturbation.modes({7: 1e-4}), segments=80)
        >>> 3.9 < run.growth_rate(7).rate < 4.1
        True
        """
        mode = validate.integer("mode", mode, 1, self._most_modes, self._why_no_more)
        if self.setting.friction > 0.0:
            raise ValueError("growth_rate asks for a frictionless run; with friction look at mode_amplitudes")
        beyond = np.flatnonzero(self.largest_angle > _LINEAR_UP_TO)
        count = int(beyond[0]) if beyond.size else self.time.size
        step = self.setting.duration / (self.setting.frames - 1)
        load = self.setting.load
        # Under a constant force any period will do.
        period = 2.0 * math.pi / load.frequency if load.amplitude > 0.0 else max(count, 9) * step / 4.0
        if period < LEAST_PER_PERIOD * step:
            frames = math.ceil(LEAST_PER_PERIOD * self.setting.duration / period) + 1
            raise ValueError(f"growth_rate needs {LEAST_PER_PERIOD} frames a forcing period: ask for {frames} frames")
        if (count - 1) * step < 3.0 * period:
            raise ValueError(
                f"growth_rate needs three forcing periods of motion below {_LINEAR_UP_TO:g} rad, got "
                f"{max(0, count - 1) * step / period:.2g}; simulate longer, or from a smaller perturbation"
            )
        amplitude = self._amplitudes([mode])[:count, 0]
        return fit_growth(self.time[:count], amplitude, period, self.rod.damping_rate)

    @property
    def buckled(self) -> bool:
        """Whether any node was beyond 5 degrees in the last quarter of the time simulated.

        The paper asks for 5 degrees at any time after 1 s, which the dying motion after a strong kick passes too.
        """
        return bool(self.largest_angle[-self._last_quarter :].max() > BUCKLED_ANGLE)

    @property
    def dominant_mode(self) -> int:
        """Mode with the largest root mean square amplitude over the last quarter of the time simulated."""
        return self.leading_modes[0]

    @property
    def energy_error(self) -> NDArray[np.float64]:
        """Change in J of kinetic + potential + dissipated - work since the start: what the simulation gets wrong."""
        names = ("kinetic", "stretch", "shear", "bend", "twist", "gravity", "contact", "dissipated")
        balance = np.sum([self.energy[name] for name in names], axis=0) - self.energy["work"]
        return np.asarray(balance - balance[0])

    @property
    def _power(self) -> NDArray[np.float64]:
        """Sum of squares of every mode's amplitude over the last quarter, from mode 1 on."""
        modes = range(1, self._most_modes + 1)
        return np.asarray(np.sum(self._amplitudes(modes)[-self._last_quarter :] ** 2, axis=0))

    @property
    def _predicted_rates(self) -> tuple[float, ...]:
        """Growth in 1/s that the mode equations predict the leading modes, zero with friction."""
        if self.setting.friction > 0.0:
            return (0.0,) * len(self.leading_modes)
        return tuple(map(float, self.rod.stability(self.setting.load, self.leading_modes).mode_growth_rates))

    @property
    def _last_quarter(self) -> int:
        return max(1, math.ceil(self.time.size / 4))

    def __repr__(self) -> str:
        """Return what was simulated, and what came of it."""
        setting = self.setting
        end = "" if self.complete else f", interrupted at {self.time[-1]:.4g} s"
        what = f"buckled in mode {self.dominant_mode}" if self.buckled else "not buckled"
        return (
            f"<{what}, largest angle {math.degrees(self.largest_angle.max()):.3g} degrees; {setting.duration:g} s of a "
            f"rod of {setting.segments} segments, friction {setting.friction:g}{end}; {setting.steps} steps of "
            f"{1e6 * setting.time_step:.3g} us, set by {setting.step_limit}>"
        )

    def plot(self, ax: Any = None) -> Any:
        """Draw the rod from above at five times of the last quarter, the last one black; return the axes."""
        from floquetrod.plotting.rod import draw_top_view

        return draw_top_view(self, ax)

    def plot_energy(self, ax: Any = None) -> Any:
        """Draw the energies over time; return the axes."""
        from floquetrod.plotting.rod import draw_energy

        return draw_energy(self, ax)

    @property
    def leading_modes(self) -> tuple[int, ...]:
        """The three modes of largest root mean square amplitude over the last quarter, the largest first."""
        return tuple(int(place) + 1 for place in np.argsort(-self._power)[:3])

    @property
    def caption(self) -> str:
        """What was simulated, in a line."""
        setting, scale = self.setting, self.rod.critical_force
        load = setting.load
        return (
            f"mean {load.mean / scale:.3g} Fcr, amplitude {load.amplitude / scale:.3g} Fcr, "
            f"{load.frequency:.4g} rad/s, friction {setting.friction:g}, {setting.perturbation}"
        )

    def plot_growth(self, ax: Any = None) -> Any:
        """Draw the leading modes over time, dashed the growth `Rod.stability` predicts them; return the axes.

        With friction nothing is predicted: what grows is not exponential.
        """
        from floquetrod.plotting.rod import draw_growth

        return draw_growth(self, self.leading_modes, self._predicted_rates, ax)

    def plot_run(self) -> Any:
        """Draw the rod from above over the growth of its leading modes; return the figure."""
        from floquetrod.plotting.rod import draw_run

        return draw_run(self, self.leading_modes, self._predicted_rates)

    def animate(self) -> Any:
        """Return a matplotlib animation of the rod from above, of at most 200 pictures."""
        from floquetrod.plotting.rod import animate_top_view

        return animate_top_view(self)

    def save(self, path: str | Path) -> Path:
        """Write everything to an npz file; an older file of that name stays whole until the new one is complete."""
        meta = {
            "format": _FORMAT,
            "version": self.version,
            "setting": self.setting.as_dict(),
            "complete": self.complete,
            "seconds": self.seconds,
        }
        arrays = {"time": self.time, "positions": self.positions, "velocities": self.velocities}
        energy = {f"energy_{name}": values for name, values in self.energy.items()}
        return files.write_npz(path, meta, {**arrays, **energy}, compress=True)

    @classmethod
    def load(cls, path: str | Path) -> Simulation:
        """Read a simulation that `save` wrote.

        Raises ValueError for a file that is damaged, if only in one bit, or foreign.
        """
        return files.read_npz(path, _FORMAT, "a simulation", _simulation)


def _simulation(meta: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> Simulation:
    """Return the simulation that a file describes; an error where it is not as `Simulation.save` writes it."""
    setting = Setting.from_dict(files.entry(meta, "setting", dict))
    complete, seconds = files.entry(meta, "complete", bool), files.entry(meta, "seconds", float)
    time = files.field(arrays, "time", np.float64, (None,), finite=True)
    count, nodes = time.size, setting.segments + 1
    if not 1 <= count <= setting.frames or (complete and count != setting.frames) or seconds < 0.0:
        raise ValueError(f"it has {count} of {setting.frames} frames, made in {seconds!r} s")
    positions, velocities = (
        files.field(arrays, name, np.float64, (count, nodes, 3), finite=True) for name in ("positions", "velocities")
    )
    energy = {
        name: files.field(arrays, f"energy_{name}", np.float64, (count,), finite=True)
        for name in (*ENERGIES, "dissipated")
    }
    return Simulation(
        setting, time, positions, velocities, energy, complete, seconds, files.entry(meta, "version", str)
    )
