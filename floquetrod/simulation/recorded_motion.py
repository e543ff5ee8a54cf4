"""The recorded motion of a simulated rod: frames, energies, modes."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod.floquet.references import ROD, references
from floquetrod.simulation.outcome import BUCKLED_ANGLE
from floquetrod.simulation.start import SEGMENTS_TO_SEE

_AT_REST = 1e-5  # rad: a node that turns by no more in a period of the force has come to rest (a choice)

ENDINGS = ("duration", "buckled", "at rest", "interrupted")
"""How a run may end."""


@dataclass(frozen=True)
class EarlyEnd:
    """When a run may stop before its duration: beyond the angle ``buckled``, or where ``friction`` holds it at rest.

    At rest no node's angle has changed by more than 1e-5 rad for ``frames``, which cover a period of the force, and
    none is beyond 5 degrees.
    """

    friction: float
    frames: int
    buckled: float  # rad

    def of(self, positions: NDArray[np.float64]) -> str | None:
        """Return how a run of these frames (frames, nodes, 3) has ended at the last of them, None where it has not."""
        last = angles(positions[-1])
        largest = float(np.abs(last).max())
        if largest > self.buckled:
            return "buckled"
        if self.friction == 0.0 or largest >= BUCKLED_ANGLE or len(positions) <= self.frames:
            return None
        # The first frame of the period alone shows most runs to be moving.
        if np.abs(last - angles(positions[-1 - self.frames])).max() > _AT_REST:
            return None
        return "at rest" if np.ptp(angles(positions[-1 - self.frames :]), axis=0).max() <= _AT_REST else None


def angles(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the angle theta around the channel's axis in rad, 0 on the floor, of places (..., 3)."""
    # Of numbers that are not side by side NumPy 1.26 rounds arctan2 differently, depending on where in memory they are.
    return np.asarray(np.arctan2(np.ascontiguousarray(positions[..., 1]), -positions[..., 2]))


class LastState(NamedTuple):
    """The state with which a run can be continued bit for bit, and the arithmetic that it needs.

    Attributes
    ----------
    record : ndarray of uint8
        Bytes of the record of the rod after the last step.
    before : ndarray of uint8
        The same one call of the kernel earlier.
    impulses : ndarray (frames, 2)
        Impulses in N s by which the ends had been pushed at each frame.
    arithmetic : dict of str
        See `floquetrod.simulation.arithmetic`.
    """

    record: NDArray[np.uint8]
    before: NDArray[np.uint8]
    impulses: NDArray[np.float64]
    arithmetic: dict[str, str]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class RecordedMotion(NoTruthValue, ByContent):
    """The frames of a simulated rod, and what follows from them alone; `Simulation` adds the problem.

    Its attributes are described at `floquetrod.simulation.simulation_problem.Simulation`.
    """

    ask = ".buckled"

    time: NDArray[np.float64]
    positions: NDArray[np.float64]
    velocities: NDArray[np.float64]
    end_forces: NDArray[np.float64]
    energy: dict[str, NDArray[np.float64]]
    ended: str
    seconds: float = field(compare=False)
    last_state: LastState | None = field(default=None, compare=False)

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite, in plain text with DOI, floquetrod first, then the sources of the methods used."""
        return references(ROD)

    @property
    def complete(self) -> bool:
        """Whether the run reached its end; False when it was interrupted."""
        return self.ended != "interrupted"

    @cached_property
    def angle(self) -> NDArray[np.float64]:
        """Angle theta of every node around the channel's axis in rad, 0 on the floor, (frames, nodes)."""
        return angles(self.positions)

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

        A mode with fewer than 6 segments in half a wave moves like a rod 5 % or more too soft.

        Returns
        -------
        ndarray
            (frames, modes), in rad.

        Raises
        ------
        TypeError, ValueError
            For a mode that has fewer than 2 segments in half a wave.
        """
        return self._amplitudes(validate.integers("modes", modes, 1, self._most_modes, self._why_no_more))

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
        """The highest mode that the nodes can tell from others, two segments in half a wave."""
        return self._segments // SEGMENTS_TO_SEE

    @property
    def _why_no_more(self) -> str:
        return f"{self._segments} segments resolve no higher mode"

    @property
    def _last_quarter(self) -> int:
        return max(1, math.ceil(self.time.size / 4))

    def _amplitudes(self, modes: Iterable[int]) -> NDArray[np.float64]:
        nodes = np.arange(self._segments + 1) * (math.pi / self._segments)
        shapes = np.sin(np.multiply.outer(nodes, np.asarray(tuple(modes), dtype=np.float64)))
        return np.asarray(self.angle @ shapes * (2.0 / self._segments))
