"""What drives the ends of a simulated rod along the channel, and the axial state in which it starts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.caching import cached_property
from floquetrod.rod.loads.load import AxialWave, Load, with_waves
from floquetrod.rod.loads.tool import VibrationTool
from floquetrod.rod.model.course import weight_gained
from floquetrod.rod.model.data import RodData
from floquetrod.simulation.lumping import uniform_rods
from floquetrod.simulation.rod_record import CLAMPED, FREE, GUIDED, HINGED, End
from floquetrod.simulation.well_axis import WellAxis
from floquetrod.wells.path import WellPath

MOST_HARMONICS = 100  # of a simulated force: they are summed in every step
ACROSS = {"hinged": HINGED, "clamped": CLAMPED, "guided": GUIDED, "free": FREE}
"""What the ends of a rod may be across the channel, by the words for them."""
LARGEST_STRAIN = 0.02  # that a load may cause: beyond it linear elasticity has no meaning
_FINE = 513  # places at which a wave is examined for its largest force (a choice)
_NEAR = 1e-4  # of an axial wave or of the length, over which its profile is differentiated (heuristic)


@dataclass(frozen=True)
class Driving:
    """A load on the ends of a rod.

    Parameters
    ----------
    rod : RodData
    load : Load
    feed_speed : float, optional
        Speed in m/s at which the upper end moves down the channel, in place of the force there.
    far_force : float, optional
        Mean of the force that pushes the lower end, in N, where it is not what the load makes it.
    tool : VibrationTool, optional
        In the rod.
    """

    rod: RodData
    load: Load
    feed_speed: float | None = None
    far_force: float | None = None
    tool: VibrationTool | None = None

    @property
    def weight_along(self) -> float:
        """Weight along the channel in N/m, 0 where the load neglects it."""
        return 0.0 if self.load.mean_at is None else self.rod.weight_along

    @cached_property
    def gravity_along(self) -> float:
        """Acceleration along the channel by that weight, in m/s^2; the material alone moves along."""
        return self.weight_along / self.rod.mass_along

    @property
    def mean_forces(self) -> tuple[float, float]:
        """Means of the forces in N that push the upper and the lower end, or would if it were not held or moved."""
        upper, grown = self.load.mean, float(self._gained(1.0))
        if self.load.mean_at is not None:
            upper -= float(self._gained(self.load.mean_at))
        return upper, upper + grown if self.far_force is None else self.far_force

    def mean_force(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the mean force in N at places ``s`` of the rod; another force at the lower end grows evenly to it."""
        (first, last), x = self.mean_forces, s / self.rod.length
        return np.asarray(first + self._gained(x) + (last - first - self._gained(1.0)) * x)

    def _gained(self, x: Any) -> Any:
        """Return the weight in N that is hung along the channel between the upper end and places x = s / L."""
        return 0.0 * x if self.load.mean_at is None else weight_gained(self.rod, x, 0.0)

    @cached_property
    def axis(self) -> WellAxis | None:
        """The axis of the channel of a rod on a path, or of a straight channel with a rod that is not; else None."""
        rod = self.rod
        if rod.path is None and rod.natural_shape is not None and rod.course.is_straight:
            return WellAxis(WellPath.straight(length=rod.length, inclination=rod.inclination), 0.0, rod.length)
        return None if rod.path is None else WellAxis(rod.path, rod.depth, rod.length)

    @property
    def far_end(self) -> str:
        """What the lower end is, "held", "free" or "driven"."""
        return self._wave.far_end

    @property
    def axial_damping(self) -> float:
        """Decay rate in 1/s of motion along the channel, of axial waves if there are any, else as across the rod."""
        return self._wave.axial_damping

    @cached_property
    def ends(self) -> tuple[End, End]:
        """The upper and the lower end."""
        across, means = self.rod.end_conditions, self.mean_forces
        fed = self.feed_speed is not None
        upper = End(ACROSS[across.upper], fed, self.feed_speed or 0.0, means[0], 0.0 if fed else 1.0)
        lower = End(
            ACROSS[across.lower], self.far_end == "held", 0.0, means[1], 1.0 if self.far_end == "driven" else 0.0
        )
        return upper, lower

    @property
    def harmonics(self) -> NDArray[np.complex128]:
        """Complex amplitudes of the harmonics of the force in N."""
        return self.load.amplitude * self.load.harmonics

    def squeezed(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return where the mean forces put the places ``s`` of the rod along the channel, in m from its middle."""
        first, last = self.mean_forces
        length, rigidity = self.rod.length, self.rod.axial_rigidity
        shorter = (first * s + 0.5 * (last - first) * s**2 / length) / rigidity
        return s - 0.5 * length - shorter + 0.5 * (first + last) * 0.5 * length / rigidity

    def wave(self, s: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return displacement in m and velocity in m/s along the channel at the start, of the steady vibration.

        Zero where there is none: at a resonance without damping, and where the upper end is moved.
        """
        displacement, velocity = np.zeros_like(s), np.zeros_like(s)
        if self.load.amplitude == 0.0 or self.feed_speed is not None:
            return displacement, velocity
        wave, line = self._wave, self.rod.axial_line
        for k, harmonic in enumerate(self.harmonics, start=1):
            frequency = k * self.load.frequency
            near = _NEAR * min(self.rod.length, self.rod.wave_speed / frequency)
            try:
                below, above = (line.profile(wave, s + sign * near, frequency) for sign in (-1, 1))
            except ValueError:
                return np.zeros_like(s), np.zeros_like(s)
            inertia = self.rod.mass_along * complex(-(frequency**2), 2.0 * self.axial_damping * frequency)
            moved = -harmonic * (above - below) / (2.0 * near) / inertia
            displacement += moved.real
            velocity += (1j * frequency * moved).real
        return displacement, velocity

    def forces(self, places: int, harmonics: int) -> list[tuple[float, NDArray[np.float64], NDArray[np.float64]]]:
        """Return frequency in rad/s, and mean and amplitude in N along the rod, of each of the strongest harmonics.

        At so many places and where the vibration is largest; of as much as strains the rod by 0.02 at a resonance.
        """
        first, last = self.mean_forces
        vibrates = self.load.amplitude > 0.0 and any(end.drive for end in self.ends)
        forces = []
        for k in np.argsort(-np.abs(self.harmonics), kind="stable")[:harmonics] if vibrates else [0]:
            frequency = float((k + 1) * self.load.frequency)
            s = np.linspace(0.0, self.rod.length, places)
            amplitude = np.zeros(places)
            if vibrates:
                fine = np.linspace(0.0, self.rod.length, _FINE)
                profile = self._profile(fine, frequency)
                s = np.append(s, fine[int(np.argmax(profile))])
                amplitude = abs(self.harmonics[k]) * np.interp(s, fine, profile)
            most = LARGEST_STRAIN * least_axial_rigidity(self.rod)
            forces.append((frequency, first + (last - first) * s / self.rod.length, np.minimum(amplitude, most)))
        if self.tool is not None:  # of which half goes each way, as far as no end reflects it
            s = np.linspace(0.0, self.rod.length, places)
            for size, frequency in self.tool.sines:
                shaken = np.full(places, self.tool.share * size)
                forces.append((frequency, first + (last - first) * s / self.rod.length, shaken))
        return forces

    def _profile(self, s: NDArray[np.float64], frequency: float) -> NDArray[np.float64]:
        """Return the size along the rod of a vibration whose amplitude is 1 at the end that is driven."""
        try:
            return np.asarray(np.abs(self.rod.axial_line.profile(self._wave, s, frequency)))
        except ValueError:  # at a resonance
            return np.full(s.size, math.inf)

    @cached_property
    def _wave(self) -> AxialWave:
        """The load as waves; with the same force at both ends they start there, too."""
        load = self.load
        return load if isinstance(load, AxialWave) else with_waves(load, self.rod.damping_rate, "damping_rate")


def half_waves(rod: RodData, load: Load, tool: VibrationTool | None = None) -> float:
    """Return the number of half waves along the rod that a load is likely to excite, not rounded.

    Those of the critical mode; more where the force exceeds the critical one, as its square root; and of the free
    motion at half the frequency of the load, or of a tool, which is in resonance first.  Of a rod that varies along, as
    many as along one that is like the part with the shortest.
    """
    shaken = 0.0 if tool is None else tool.share * sum(amplitude for amplitude, _ in tool.sines)
    tool_frequencies = () if tool is None else (frequency for _, frequency in tool.sines)
    fastest = max(load.frequency if load.amplitude > 0.0 else 0.0, *tool_frequencies, 0.0)
    most = 0.0
    for like in uniform_rods(rod):
        strongest = (abs(load.mean) + load.amplitude + shaken) / like.critical_force
        bending = like.flexural_rigidity / like.mass_per_length
        rest = max(0.25 * fastest**2 - like.pendulum_frequency**2, 0.0)
        resonant = math.sqrt(math.sqrt(rest / bending)) * rod.length / math.pi
        most = max(most, like.critical_mode * math.sqrt(max(strongest, 1.0)), resonant)
    return most


def least_axial_rigidity(rod: RodData) -> float:
    """Return the smallest E A in N along a rod."""
    return min(like.axial_rigidity for like in uniform_rods(rod))
