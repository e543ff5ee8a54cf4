"""The recorded motion of a simulated rod: frames, energies, modes, buckling."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod.simulation.start import LEAST_SEGMENTS

BUCKLED_ANGLE = math.radians(5.0)
"""Angle beyond which a rod counts as buckled, that of the paper (section 4.3 of DOI 10.1115/1.4031710)."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class RecordedMotion(NoTruthValue, ByContent):
    """The frames of a simulated rod, and what follows from them alone; `Simulation` adds the problem.

    Its attributes are described at `floquetrod.simulation.problem.Simulation`.
    """

    ask = ".buckled"

    time: NDArray[np.float64]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]
    end_forces: NDArray[np.float64]
    energy: dict[str, NDArray[np.float64]]
    complete: bool
    seconds: float = field(compare=False)

    @cached_property
    def angle(self) -> NDArray[np.float64]:
        """Angle theta of every node around the channel's axis in rad, 0 on the floor, (frames, nodes)."""
        return np.arctan2(self.positions[:, :, 1], -self.positions[:, :, 2])

    @cached_property
    def winding(self) -> NDArray[np.float64]:
        """Angle of every node around the channel's axis in rad, continuous along the rod, (frames, nodes).

        It begins at the upper end with `angle` and counts turns from there, 2 pi for each turn of a helix.
        """
        return np.unwrap(self.angle, axis=1)

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
    def buckled(self) -> bool:
        """Whether any node was beyond 5 degrees in the last quarter of the time simulated.

        The paper asks for 5 degrees at any time after 1 s, which the decaying motion after a strong kick passes too.
        """
        return bool(self.largest_angle[-self._last_quarter :].max() > BUCKLED_ANGLE)

    @property
    def dominant_mode(self) -> int:
        """Mode with the largest root mean square amplitude over the last quarter of the time simulated."""
        return self.leading_modes[0]

    @property
    def leading_modes(self) -> tuple[int, ...]:
        """The three modes of largest root mean square amplitude over the last quarter, the largest first."""
        modes = range(1, self._most_modes + 1)
        power = np.sum(self._amplitudes(modes)[-self._last_quarter :] ** 2, axis=0)
        return tuple(int(place) + 1 for place in np.argsort(-power)[:3])

    @property
    def energy_error(self) -> NDArray[np.float64]:
        """Change in J of kinetic + potential + dissipated - work since the start, the error of the balance."""
        names = ("kinetic", "stretch", "bend", "twist", "gravity", "contact", "dissipated")
        balance = np.sum([self.energy[name] for name in names], axis=0) - self.energy["work"]
        return np.asarray(balance - balance[0])

    @property
    def _segments(self) -> int:
        return int(self.positions.shape[1]) - 1

    @property
    def _most_modes(self) -> int:
        """The highest mode that has enough segments in half a wave."""
        return self._segments // LEAST_SEGMENTS

    @property
    def _why_no_more(self) -> str:
        return f"with {self._segments} segments no higher mode is resolved"

    @property
    def _last_quarter(self) -> int:
        return max(1, math.ceil(self.time.size / 4))

    def _amplitudes(self, modes: Iterable[int]) -> NDArray[np.float64]:
        nodes = np.arange(self._segments + 1) * (math.pi / self._segments)
        shapes = np.sin(np.multiply.outer(nodes, np.asarray(tuple(modes), dtype=np.float64)))
        return np.asarray(self.angle @ shapes * (2.0 / self._segments))
