"""What has become of a simulated rod: the one rule by which a run, an ensemble and the published study call it buckled.

The paper (section 4.3 of DOI 10.1115/1.4031710) asks for 5 degrees at any time after 1 s.  A rod at rest on the wall,
where friction holds it, passes that too, and so does motion that a strong kick left and that dies out.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod.simulation.lumping import uniform_rods
from floquetrod.simulation.rod_mesh import DiscreteRod
from floquetrod.wells.drag import Friction

BUCKLED_ANGLE = math.radians(5.0)
"""The paper's angle, beyond which a rod may count as buckled."""

_CLEARLY_BUCKLED = math.radians(45.0)  # at which a run may stop early: from 19 degrees one fell back (a choice)
_STILL = math.radians(1.0)  # by which no node of a rod at rest swings (a choice: small waves run on for long)
_DIES_OUT = 0.95  # of the largest angle of the quarter before, below which that of a quarter is smaller (a choice)
_GROWN = 2.0  # times the swing of the kick alone, which a force short of the critical one amplifies too (a choice)
_OUTLIVED = 0.5  # of a run, after which nothing should be left of the kick (a choice)
_OVER = 1.0  # swing in rad of a kick alone, from which its energy may take a node over the top of the channel
_BENT = math.radians(2.0)  # beyond arctan(mu): bending held kicked rods without load at up to 1.2 degrees (measured)
_RUBS = 8.0  # times v / (mu g): rods without load rest after 12, one of 277 after 20: parts that stick swing (measured)
_LEFT = 3.0  # damping rate times time after which a twentieth is left of motion
_PERIODS = 3  # of the slowest mode over which the swing of a kick is searched for (a choice)
_TIMES = 96  # in these periods (a choice)

_AS_BRAKED = 0.5  # of the decay by damping alone, below which something keeps motion up (a choice)
_CLEARLY_LESS = 0.3  # of motion lost in a quarter, which is enough with any damping (a choice)
_AS_BEFORE = 0.5  # of the decay a quarter before, below which motion may approach a smaller one (a choice)
_AS_RUBBED = 0.1  # of motion that dies out against friction, lost in a quarter at least (a choice)

KINDS = ("quiet", "buckled", "at rest", "dying out", "swinging")
"""What may have become of a rod; the places are the numbers of ``outcome`` in ensembles."""

DEFINITION = (
    "beyond 5 degrees in the last quarter of the run, and neither at rest where friction holds, nor dying out, nor "
    "swinging at most twice as far as the kick alone makes it swing (any distance from one radian on), in a run "
    "too short for that to end"
)
"""When a rod has buckled, in words."""


class Outcome(NamedTuple):
    """What has become of a rod.

    Attributes
    ----------
    kind : {"quiet", "buckled", "at rest", "dying out", "swinging"}
        Quiet: within 5 degrees over the last quarter.  At rest: beyond, still, and no further than friction holds.
        Dying out: beyond, and less far from quarter to quarter; it comes to rest unless the load keeps some motion up,
        which it may even where rest is stable.  Swinging: beyond, and no further than the kick may
        have taken it, which nothing has ended yet.  Buckled: beyond otherwise.
    angle : float
        Largest angle of any node from rest, over the last quarter, in rad; rest is where a run began that was kicked.
    earlier : float
        Largest angle in rad that another run left the rod with, where the rod starts from it, else 0.
    """

    kind: str
    angle: float
    earlier: float = 0.0

    @property
    def words(self) -> str:
        """What it says of the rod."""
        at, earlier = (f"{math.degrees(angle):.3g} degrees" for angle in (self.angle, self.earlier))
        if self.kind == "dying out" and self.earlier > BUCKLED_ANGLE:
            return f"dying out at {at}, from {earlier} in the run before"
        return {
            "quiet": "not buckled",
            "buckled": "buckled",
            "at rest": f"not buckled, at rest at {at} where friction holds",
            "dying out": f"not buckled, dying out at {at}",
            "swinging": f"not buckled, swinging on to {at}",
        }[self.kind]

    @property
    def doubt(self) -> str:
        """Why a longer run may end otherwise, "" where nothing says so."""
        if self.kind == "dying out":
            return "still moving and dying out at the end, unless the load keeps it up: simulate longer"
        if self.kind == "swinging":
            return "still swinging as its kick may have left it, without growth: simulate longer, or kick less"
        return ""


class Kick(NamedTuple):
    """How a rod is set moving, and what ends that motion.

    Attributes
    ----------
    swing : float
        Largest angle in rad that the rod reaches by its kick alone, without load, friction and damping.
    holding : float
        The largest coefficient of friction.
    ended : float
        Time in s after which friction or damping has ended the motion that the kick alone makes, infinite without.
    slowly : float
        Speed across in m/s of a swing of one radian on the floor, sqrt(g R).
    """

    swing: float
    holding: float
    ended: float
    slowly: float

    @classmethod
    def of(cls, mesh: DiscreteRod, friction: Friction, velocities: NDArray[np.float64]) -> Kick:
        """Return the kick of a rod whose nodes start with these speeds across the channel, (nodes,), in m/s."""
        rod, pressed = mesh.rod, np.broadcast_to(mesh.gravity_on_wall, velocities.shape)
        # Coulomb: some v / (mu g), the time of a block that slides, by the smallest mu; damping e^(-c t).
        rubbing = min(friction.values) * float(pressed.min())
        rubbed = _RUBS * float(np.abs(velocities).max()) / rubbing if rubbing > 0.0 else math.inf
        damped = _LEFT / rod.damping_rate if rod.damping_rate > 0.0 else math.inf
        # Of a rod that varies along, as far as one would turn that is like the part which turns most.
        swing, slowly = 0.0, math.inf
        for part, like in zip(rod.uniform_parts, uniform_rods(rod), strict=True):
            inside = (mesh.places >= part.start) & (mesh.places <= part.end)
            gravity = float(pressed[inside].min(initial=float(pressed.max())))
            bending, gap = like.flexural_rigidity / like.mass_per_length, like.radial_clearance
            swing = max(swing, kick_swing(velocities, rod.length, bending, gravity, gap))
            slowly = min(slowly, math.sqrt(gravity * gap))
        return cls(swing, friction.largest, min(rubbed, damped), slowly)

    @property
    def farthest(self) -> float:
        """Angle in rad up to which the kick may have taken the rod, a force short of the critical one helping.

        Any, from a swing of one radian on.  A node of mode m passes over the top where its energy v^2 / 2 is more than
        2 g R and what bends the rod by R, E I w^4 R^2 / (2 m_t); by its swing a, v = a R w_m (see `kick_swing`) this is

            a^2 (g / R + E I w^4 / m_t) > 4 g / R + E I w^4 / m_t ,

        which no a below 1 satisfies, and of short waves each a that is larger.
        """
        return math.inf if self.swing >= _OVER else _GROWN * self.swing

    @property
    def clearly_buckled(self) -> float:
        """Angle in rad at which a run may stop early, as the rod has buckled."""
        return max(_CLEARLY_BUCKLED, self.farthest)


class EarlierMotion(NamedTuple):
    """Motion that another run has left a rod with, and what may end it.

    Attributes
    ----------
    rest : ndarray (nodes,)
        Angles at which the rod rests under its load, in rad.
    angle : float
        Largest angle from rest in the last quarter of the other run, in rad.
    buckled : bool
        Whether the rod had buckled then.
    damping : float
        Decay rate in 1/s of free motion.
    friction : bool
        Whether there is friction everywhere.
    grows : bool
        Whether small motion about rest grows by theory, without friction.
    half_swing : float
        Half the period in s of a swing of the straight rod on the floor.
    """

    rest: NDArray[np.float64]
    angle: float
    buckled: bool
    damping: float
    friction: bool
    grows: bool
    half_swing: float

    def dies_out(self, away: NDArray[np.float64], quarter: int, seconds: float) -> bool:
        """Return whether the motion ``away`` from rest, (frames, nodes), decays as free motion does.

        From quarter to quarter, of so many frames and ``seconds``, by root mean squares over frames and nodes.
        """
        if self.grows or len(away) < 3 * quarter or seconds < 0.5 * self.half_swing:
            return False
        sizes = np.sqrt([np.mean(part**2) for part in np.split(away[-3 * quarter :], 3)])
        least = _AS_BRAKED * self.damping * seconds - self.friction * math.log1p(-_AS_RUBBED)
        before, now = np.log(sizes[:-1] / sizes[1:])
        # What approaches a smaller motion decays ever slower.
        return bool(min(before, now) >= min(least, -math.log1p(-_CLEARLY_LESS)) and now >= _AS_BEFORE * before)


def kick_swing(
    velocities: NDArray[np.float64], length: float, bending: float, gravity: float, clearance: float
) -> float:
    """Return the largest angle in rad that a kick causes by itself: no load, no friction, small motion, hinged ends.

    Mode m of wavenumber w = m pi / L turns by b_m sin(w_m t) / w_m, w_m^2 = g / R + (EI / m_t) w^4; b_m are the
    coefficients of v(s) / R.  The nodes follow from them at equal times of three periods of the slowest mode.
    """
    from scipy.fft import dst

    segments = velocities.size - 1
    rates = dst(velocities[1:-1] / clearance, type=1) / segments
    frequencies = np.sqrt(gravity / clearance + bending * (np.arange(1, segments) * (math.pi / length)) ** 4)
    times = np.linspace(0.0, _PERIODS * 2.0 * math.pi / float(frequencies[0]), _TIMES + 1)[1:]
    largest = 0.0
    for time in times:  # one after another: a hundred thousand segments take little memory so
        largest = max(largest, float(np.abs(dst(rates * np.sin(frequencies * time) / frequencies, type=1)).max()) / 2.0)
    return largest


def turned(angle: NDArray[np.float64], rest: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
    """Return by how much nodes have turned from ``rest``, by default the first frame, in (-pi, pi], (frames, nodes)."""
    away = angle - (angle[0] if rest is None else rest)
    return np.asarray(np.arctan2(np.sin(away), np.cos(away))) if np.abs(away).max() > math.pi else away


def outcome_of(
    time: NDArray[np.float64],
    angle: NDArray[np.float64],
    speeds: NDArray[np.float64],
    kick: Kick,
    earlier: EarlierMotion | None = None,
) -> Outcome:
    """Return the outcome of a run: quiet, buckled, at rest, dying out or swinging.

    Angles are measured from the first frame, at rest; of a run that starts from another one's state, from where
    the rod rests under its load.  Motion beyond 5 degrees that such a run inherits is dying out while it decays from
    quarter to quarter at half the rate of free motion, or by 30 %, and no slower than before by half, under a load that
    makes nothing grow; a rod that had buckled is else still buckled, until it is at rest or within 5 degrees.

    Parameters
    ----------
    time : ndarray (frames,)
        In s.
    angle : ndarray (frames, nodes)
        Around the channel's axis, in rad.
    speeds : ndarray (frames, nodes)
        Across the channel, in m/s.
    kick : Kick
    earlier : EarlierMotion, optional
        Of a run that starts from the state of another one.
    """
    away = turned(angle, None if earlier is None else earlier.rest)
    largest, quarter = np.abs(away).max(axis=1), max(1, math.ceil(time.size / 4))
    last = float(largest[-quarter:].max())
    moving, seconds = float(speeds[-quarter:].max()) / kick.slowly, quarter * float(time[-1] - time[0]) / time.size
    left = 0.0 if earlier is None else earlier.angle
    # A buckled rod may swing through rest, in less time than a swing takes.
    passing = earlier is not None and earlier.buckled and seconds < earlier.half_swing and moving > BUCKLED_ANGLE
    if last <= BUCKLED_ANGLE and not passing:
        return Outcome("quiet", last, left)
    # Frames may fall together with the zeros of the motion, where all of them are fast.  A speed is that of a swing of
    # the rod on the floor: a rod that friction holds rings on faster, by a tenth of a degree, as it twists and bends.
    swing, least = float(np.ptp(away[-quarter:], axis=0).max()), float(speeds[-quarter:].max(axis=1).min())
    if max(swing, least / kick.slowly) < _STILL:
        held = kick.holding > 0.0 and last <= math.atan(kick.holding) + _BENT
        return Outcome("at rest" if held else "buckled", last, left)
    # From quarter to quarter: a rod that stays buckled swings less far in one of them by chance.
    third, second = largest[-2 * quarter : -quarter], largest[-3 * quarter : -2 * quarter]
    brakes = kick.holding > 0.0 or math.isfinite(kick.ended)
    dies_out = brakes and second.size > 0 and last < _DIES_OUT * float(third.max()) < _DIES_OUT**2 * float(second.max())
    if earlier is not None:
        if dies_out and last < left and earlier.dies_out(away, quarter, seconds):
            return Outcome("dying out", last, left)
        if earlier.buckled:
            return Outcome("buckled", last, left)
    outlived = kick.ended < _OUTLIVED * float(time[-1] - time[0])
    if last > kick.farthest or (outlived and not dies_out):
        return Outcome("buckled", last, left)
    return Outcome("dying out" if dies_out else "swinging", last, left)
