"""The time steps of a simulation: how large the largest stable one is, and how many are taken."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arguments import wrong_value
from floquetrod._util.arrays import Floats
from floquetrod.simulation.lumping import bending_stencil
from floquetrod.simulation.rod_mesh import DiscreteRod

SAFETY = 0.9  # of the largest time step of the linearised rod (heuristic: large motion never came near the rest)
_MOST_WORK = 1e14  # steps times segments, of which a core does some 1e8 in a second: two weeks
_MOST_MEMORY = 1 << 32  # bytes of all frames (a choice)
_SMALLEST_PART = 1e-9  # of the critical step: a smaller one adds nothing but rounding

STEP_LIMITS = ("stretch", "bend", "contact", "choice")
"""What limits a time step: three motions of the rod, or the caller's choice of a smaller one."""


@dataclass(frozen=True)
class TimeSteps:
    """The time steps of a run: their number, how many lie between frames, their size in s, and the limit on it."""

    count: int
    per_frame: int
    size: float
    limit: str

    @property
    def frames(self) -> int:
        """Frames kept, the start and the end among them."""
        return self.count // self.per_frame + 1

    @classmethod
    def between_frames(cls, duration: float, frames: int, per_frame: int, limit: str) -> TimeSteps:
        """Return the steps of a run of ``duration`` s, ``per_frame`` of them between each two frames.

        Raises ValueError or TypeError for fewer than two frames, no steps between them, and a duration that is not
        positive.
        """
        duration = units.number("duration", duration, "time", math.ulp(0.0), hint="in s")
        frames = validate.integer("frames", frames, 2, hint="the start and the end among them")
        per_frame = validate.integer("per_frame", per_frame, 1)
        count = (frames - 1) * per_frame
        return cls(count, per_frame, duration / count, limit)


def critical_time_step(mesh: DiscreteRod, impact_speed: float = 0.0) -> tuple[float, str]:
    """Return the largest stable time step in s, with a margin, and its limit: "stretch", "bend" or "contact".

    The fastest motion of the linearised rod in which neighbours move against each other has the frequency w; a step
    below 2 / w is stable.  Stretch: w = (7/6) (2 / l) sqrt(E / rho).  Bending: w^2 = (7/6)^2 (4/3) 16 E I / (m_t l^4).
    Contact adds to bending its stiffness and damping at the depth that ``impact_speed`` (m/s), on top of a fall across
    the channel, can reach.  Of a rod that varies along, every node has its own, and the least counts.

    Returns
    -------
    tuple of (float, str)
        The step in s, and what limits it.

    Raises
    ------
    TypeError, ValueError
        For a negative speed.

    Examples
    --------
    >>> from floquetrod.rod.rod import Rod
    >>> step, limit = critical_time_step(DiscreteRod(Rod.nitinol(), 250))
    >>> f"{1e6 * step:.2f} us, set by {limit}"
    '2.96 us, set by stretch'
    """
    impact_speed = units.number("impact_speed", impact_speed, "speed", 0.0, hint="in m/s")
    bound, limit = min(_stable_step(node, impact_speed) for node in _stiffness(mesh))
    return SAFETY * bound, limit


class _Stiffness(NamedTuple):
    """What bounds the step at a node: squares of frequencies of stretch and bending, and its contact."""

    stretch: float
    bend: float
    gravity: float
    clearance: float
    depth_at_rest: float
    contact: float
    contact_time: float


def _stiffness(mesh: DiscreteRod) -> Iterable[_Stiffness]:
    """Return the stiffness of a uniform rod, or of all different nodes of one that varies."""
    length, lumps = mesh.segment_length, mesh.lumps
    stretch: Any
    bend: Any
    if lumps is None:
        stretch = (7.0 / 3.0 * mesh.rod.wave_speed / length) ** 2
        bend = (7.0 / 6.0) ** 2 * (4.0 / 3.0) * 16.0 * mesh.rod.flexural_rigidity
        bend /= mesh.rod.mass_per_length * length**4
    else:
        # Sums of the sizes in a row of the matrix, which bound its eigenvalues (Gershgorin).
        own, first, second = (np.abs(each) for each in bending_stencil(lumps.bend, lumps.bend_between))
        rows = own[2:-2] + first[2:-2] + first[1:-3] + second[2:-2] + second[:-4]
        stretch = (7.0 / 3.0 / length) ** 2 * _largest_near(lumps.stretch) / lumps.mass_along
        bend = (7.0 / 3.0) ** 2 * _largest_near(rows) / (lumps.mass * length**4)
    contact = (mesh.gravity_on_wall, mesh.clearance, mesh.depth_at_rest, mesh.contact_stiffness, mesh.contact_time)
    every = np.broadcast_arrays(stretch, bend, *contact)
    return {_Stiffness(*map(float, node)) for node in zip(*map(np.ravel, every), strict=True)}


def _largest_near(values: Floats) -> Floats:
    """Return the largest value of the two segments on either side of a node."""
    least = np.full(2, -math.inf)
    padded = np.concatenate([least, values, least])
    return np.asarray(np.lib.stride_tricks.sliding_window_view(padded, 4).max(axis=1))


def _stable_step(node: _Stiffness, impact_speed: float) -> tuple[float, str]:
    """Return the largest stable step in s, and its limit."""
    speed2 = 4.0 * node.gravity * node.clearance + impact_speed**2
    depth = node.depth_at_rest + (1.25 * speed2 / node.contact) ** 0.4
    contact = 1.5 * node.contact * math.sqrt(depth)
    frequency = math.sqrt(node.bend + contact)
    ratio = 0.5 * node.contact * math.sqrt(depth) * node.contact_time / frequency
    across = 2.0 / frequency * (math.sqrt(1.0 + ratio**2) - ratio)
    bound = min(2.0 / math.sqrt(node.stretch), across)
    return bound, "stretch" if bound < across else "contact" if contact > node.bend else "bend"


def time_steps(mesh: DiscreteRod, duration: float, frames: int, largest: float | None, speed: float) -> TimeSteps:
    """Return the steps of a run: as few as the critical time step allows, equally many between all frames.

    Parameters
    ----------
    duration : float
        Time simulated, in s.
    frames : int
        Frames kept, the start and the end among them.
    largest : float or None
        The largest step in s that the caller wants, None to leave it to the critical time step.
    speed : float
        The largest speed across the channel at the start, in m/s.

    Raises
    ------
    ValueError
        For a step that is unstable or far too small, for more than 1e14 steps times segments, and for frames that
        lie too close together or take more than 4 GiB.
    ArithmeticError
        For data so extreme that the critical time step is not a positive number.
    """
    frame = 6 * 8 * (mesh.segments + 1)  # bytes
    if frames > _MOST_MEMORY // frame:
        raise wrong_value(
            "frames",
            f"must be at most {_MOST_MEMORY // frame:,} with {mesh.segments} segments, got {frames:,} of "
            f"{frame:,} bytes each; take fewer",
        )
    step, limit = _largest_step(mesh, largest, speed)
    steps, most = max(duration / step, frames - 1.0), _MOST_WORK / mesh.segments
    if steps > most:
        name, value = ("duration", duration) if largest is None else ("time_step", step)
        raise wrong_value(
            name,
            f"of {value:.4g} s makes {steps:.4g} steps of {step:.4g} s, at most {most:.4g} are taken with "
            f"{mesh.segments} segments (about two weeks on one core); simulate a shorter time, or take a longer "
            "step or fewer segments",
        )
    between = duration / (frames - 1)
    if between < _SMALLEST_PART * step:
        raise wrong_value(
            "duration",
            f"must be at least {(frames - 1) * _SMALLEST_PART * step:.4g} s with {frames} frames, got {duration:.4g} s",
        )
    return TimeSteps.between_frames(duration, frames, math.ceil(between / step), limit)


def _largest_step(mesh: DiscreteRod, asked: float | None, speed: float) -> tuple[float, str]:
    """Return the largest step to take in s, and what limits it."""
    critical, limit = critical_time_step(mesh, speed)
    if not 0.0 < critical < math.inf:
        raise ArithmeticError(f"its critical time step is {critical} s")
    if asked is None:
        return critical, limit
    if asked > critical:
        raise wrong_value(
            "time_step",
            f"must be at most {critical:.4g} s, got {asked:.4g} s: a longer one is unstable, by "
            f"{critical_time_step(mesh)[1]}; leave it out, or take fewer segments",
        )
    if asked < _SMALLEST_PART * critical:
        least = _SMALLEST_PART * critical
        raise wrong_value("time_step", f"must be at least {least:.4g} s, got {asked:.4g} s; leave it out")
    return asked, "choice"
