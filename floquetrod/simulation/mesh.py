"""The discretised rod: its segments and nodes, the largest stable time step, the steps of a run, its energies."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod.kernels import cosserat
from floquetrod.rod.data import RodData
from floquetrod.rod.load import AxialLoad
from floquetrod.simulation.start import LEAST_SEGMENTS, MOST_SEGMENTS

SAFETY = 0.9  # of the largest time step of the linearised rod (heuristic: large motion never came near the rest)
_MOST_WORK = 1e14  # steps times segments, of which a core does some 1e8 in a second: two weeks (a choice)
_SMALLEST_PART = 1e-9  # of the critical step: a smaller one adds nothing but rounding (a choice)

ENERGIES = (
    "kinetic",
    "stretch",
    "shear",
    "bend",
    "twist",
    "gravity",
    "contact",
    "dissipated_contact",
    "dissipated_friction",
    "dissipated_damping",
    "work",
)
"""What `DiscreteRod.energies` returns."""

STEP_LIMITS = ("stretch", "shear", "contact", "choice")
"""What limits a time step: three motions of the rod, or the caller's choice of a smaller one."""


@dataclass(frozen=True)
class TimeSteps:
    """The time steps of a run: their number, how many lie between frames, their size in s, and what limits it."""

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
        """Return the steps of a run of ``duration`` s, ``per_frame`` of them between each two frames."""
        count = (frames - 1) * per_frame
        return cls(count, per_frame, duration / count, limit)


@dataclass(frozen=True)
class DiscreteRod:
    """A rod as equal segments between nodes.

    Parameters
    ----------
    rod : RodData
    segments : int
        At least 6 for every half wave of the critical mode, none shorter than the rod's radius.
    poisson_ratio : float
        In (-1, 0.5]; with Young's modulus it gives the shear modulus.
    indentation : float
        Depth to which the weight of the rod at rest indents the floor, as a part of R: it sets the stiffness of the
        contact.
    contact_damping : float
        Damping of small motion against the wall about rest, as a part of the critical damping.

    Notes
    -----
    Shear factor of a circle: Cowper, J. Appl. Mech. 33 (1966) 335, 6 (1 + nu) / (7 + 6 nu).

    Examples
    --------
    >>> mesh = DiscreteRod(RodData.nitinol(), 250)
    >>> step, limit = mesh.critical_time_step()
    >>> f"{1e6 * step:.2f} us, set by {limit}"
    '2.91 us, set by shear'
    """

    rod: RodData
    segments: int
    poisson_ratio: float = 0.33
    indentation: float = 1e-4
    contact_damping: float = 0.3

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        rod, segments = self.rod, validate.integer("segments", self.segments, 4)
        ratio = validate.finite("poisson_ratio", self.poisson_ratio)
        if not -1.0 < ratio <= 0.5:
            raise ValueError(f"poisson_ratio must be above -1 and at most 0.5, got {ratio!r}; metals have 0.25 to 0.45")
        indentation = validate.positive(
            "indentation", self.indentation, "it is a part of the radial clearance R, such as 1e-4"
        )
        if indentation > 0.1:
            raise ValueError(f"indentation must be at most 0.1 of the radial clearance R, got {indentation!r}")
        damping = validate.nonnegative("contact_damping", self.contact_damping)
        least, most = (
            math.ceil(min(LEAST_SEGMENTS * rod.critical_mode, 1e18)),
            math.floor(min(rod.length / rod.radius, 1e18)),
        )
        if least > min(most, MOST_SEGMENTS):
            raise ValueError(
                f"rod cannot be simulated: {LEAST_SEGMENTS} segments for every half wave of its critical mode "
                f"{rod.critical_mode:.6g} are {least:,}, and at most {min(most, MOST_SEGMENTS):,} are possible; "
                "check the units"
            )
        if segments < least:
            raise ValueError(
                f"segments must be at least {least}, got {segments}: {LEAST_SEGMENTS} for every half wave of the "
                f"critical mode {rod.critical_mode:.2f}"
            )
        if segments > most:
            raise ValueError(
                f"segments must be at most {most}, got {segments}: shorter ones than the radius {rod.radius:g} m are "
                "no longer those of a slender rod"
            )
        if segments > MOST_SEGMENTS:
            raise ValueError(f"segments must be at most {MOST_SEGMENTS:,}, got {segments:,}; take fewer")
        for name, value in (
            ("segments", segments),
            ("poisson_ratio", ratio),
            ("indentation", indentation),
            ("contact_damping", damping),
        ):
            object.__setattr__(self, name, value)

    @property
    def segment_length(self) -> float:
        """Length of a segment, l, in m."""
        return self.rod.length / self.segments

    @property
    def segment_mass(self) -> float:
        """Mass of a segment, and of every node but the outer two, which have half of it, in kg."""
        return self.rod.mass_per_length * self.segment_length

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu)) in Pa."""
        return self.rod.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def shear_rigidity(self) -> float:
        """K G A in N, with Cowper's factor k."""
        ratio = self.poisson_ratio
        return 6.0 * (1.0 + ratio) / (7.0 + 6.0 * ratio) * self.shear_modulus * self.rod.area

    @property
    def torsional_rigidity(self) -> float:
        """G J in N m^2."""
        return 2.0 * self.shear_modulus * self.rod.second_moment

    @property
    def inertia(self) -> float:
        """Moment of inertia of a segment about its own axis, m r^2 / 2, in kg m^2."""
        return 0.5 * self.segment_mass * self.rod.radius**2

    @property
    def cross_inertia(self) -> float:
        """Moment of inertia of a segment across its axis, that of a rigid cylinder, m (r^2/4 + l^2/12), in kg m^2."""
        return self.segment_mass * (self.rod.radius**2 / 4.0 + self.segment_length**2 / 12.0)

    @property
    def depth_at_rest(self) -> float:
        """Depth to which the weight of the rod at rest indents the floor, in m."""
        return self.indentation * self.rod.radial_clearance

    @property
    def contact_stiffness(self) -> float:
        """Factor k of the contact's acceleration k sqrt(d) (d + C v), which at rest carries the weight."""
        gap, depth = self.rod.radial_clearance, self.depth_at_rest
        d = depth * (1.0 + 0.5 * depth / gap)  # the measure of indentation of the kernels
        return self.rod.gravity / (math.sqrt(d) * d * (1.0 + depth / gap))

    @property
    def contact_time(self) -> float:
        """C of the contact's acceleration in s, from the damping of small motion about rest."""
        return 2.0 * self.contact_damping * math.sqrt(1.5 * self.depth_at_rest / self.rod.gravity)

    def critical_time_step(self, impact_speed: float = 0.0) -> tuple[float, str]:
        """Return the largest stable time step in s, with a margin, and what limits it: "stretch", "shear" or "contact".

        The fastest motion of the linearised rod in which neighbours move against each other has the frequency w; a step
        below 2 / w is stable.  Stretch: w^2 = 4 E / (rho l^2).  Nodes against turning segments: the larger eigenvalue
        of two coupled oscillators (see docs/simulator.md).  Contact adds its stiffness and damping at the depth that
        ``impact_speed`` (m/s), on top of a fall across the channel, can reach.
        """
        length, mass, inertia = self.segment_length, self.segment_mass, self.cross_inertia
        stretch = 4.0 * self.rod.youngs_modulus / (self.rod.density * length**2)
        a = 4.0 * self.shear_rigidity / length / mass
        c = (self.shear_rigidity * length + 4.0 * self.rod.flexural_rigidity / length) / inertia
        b2 = 4.0 * self.shear_rigidity**2 / (mass * inertia)
        shear = 0.5 * (a + c) + math.sqrt(0.25 * (a - c) ** 2 + b2)
        speed2 = 4.0 * self.rod.gravity * self.rod.radial_clearance + impact_speed**2
        depth = self.depth_at_rest + (1.25 * speed2 / self.contact_stiffness) ** 0.4
        contact = 1.5 * self.contact_stiffness * math.sqrt(depth)
        fastest = max(stretch, shear)
        frequency = math.sqrt(fastest + contact)
        ratio = 0.5 * self.contact_stiffness * math.sqrt(depth) * self.contact_time / frequency
        bound = 2.0 / frequency * (math.sqrt(1.0 + ratio**2) - ratio)
        limit = "contact" if contact > fastest else "shear" if shear > stretch else "stretch"
        return SAFETY * bound, limit

    def physics(
        self, load: AxialLoad, step: float, friction: float = 0.0, ends: int = cosserat.HINGED
    ) -> cosserat.Physics:
        """Return what the kernels compute with."""
        return cosserat.Physics(
            segments=self.segments,
            ends=ends,
            step=step,
            segment=self.segment_length,
            mass=self.segment_mass,
            inertia=self.inertia,
            cross_inertia=self.cross_inertia,
            stretch=self.rod.youngs_modulus * self.rod.area,
            shear=self.shear_rigidity,
            bend=self.rod.flexural_rigidity,
            twist=self.torsional_rigidity,
            radius=self.rod.radius,
            radial_clearance=self.rod.radial_clearance,
            gravity=self.rod.gravity,
            contact=self.contact_stiffness,
            contact_damping=self.contact_time,
            friction=friction,
            decay=math.exp(-self.rod.damping_rate * step),
            mean=load.mean,
            amplitude=load.amplitude,
            frequency=load.frequency,
        )

    def time_steps(self, duration: float, frames: int, largest: float | None, speed: float) -> TimeSteps:
        """Return the steps of a run: as few as the critical time step allows, equally many between all frames.

        Parameters
        ----------
        duration : float
            In s.
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
            lie too close together.
        ArithmeticError
            For data so extreme that the critical time step is not a positive number.
        """
        step, limit = self._largest_step(largest, speed)
        steps, most = max(duration / step, frames - 1.0), _MOST_WORK / self.segments
        if steps > most:
            name, value = ("duration", duration) if largest is None else ("time_step", step)
            raise ValueError(
                f"{name} of {value:.4g} s makes {steps:.4g} steps of {step:.4g} s, at most {most:.4g} are taken with "
                f"{self.segments} segments (about two weeks on one core); simulate a shorter time, or take a longer "
                "step or fewer segments"
            )
        between = duration / (frames - 1)
        if between < _SMALLEST_PART * step:
            raise ValueError(
                f"duration must be at least {(frames - 1) * _SMALLEST_PART * step:.4g} s with {frames} frames, got "
                f"{duration:.4g} s"
            )
        return TimeSteps.between_frames(duration, frames, math.ceil(between / step), limit)

    def _largest_step(self, asked: float | None, speed: float) -> tuple[float, str]:
        """Return the largest step to take in s, and what limits it."""
        critical, limit = self.critical_time_step(speed)
        if not 0.0 < critical < math.inf:
            raise ArithmeticError(f"its critical time step is {critical} s")
        if asked is None:
            return critical, limit
        if asked > critical:
            raise ValueError(
                f"time_step must be at most {critical:.4g} s, got {asked:.4g} s: a longer one is unstable, by "
                f"{self.critical_time_step()[1]}; leave it out, or take fewer segments"
            )
        if asked < _SMALLEST_PART * critical:
            least = _SMALLEST_PART * critical
            raise ValueError(f"time_step must be at least {least:.4g} s, got {asked:.4g} s; leave it out")
        return asked, "choice"

    def straight(self, force: float = 0.0) -> Any:
        """Return the record of the rod at rest, straight on the floor, squeezed by ``force`` (N)."""
        rod = np.zeros(1, cosserat.rod_type(self.segments))[0]
        n = self.segments
        squeezed = 1.0 - force / (self.rod.youngs_modulus * self.rod.area)
        rod["x"][: n + 1] = (np.arange(n + 1) / n - 0.5) * (self.rod.length * squeezed)
        rod["z"][: n + 1] = -(self.rod.radial_clearance + self.depth_at_rest)
        rod["q0"][:n] = 1.0
        return rod

    def initialise(self, rod: Any) -> None:
        """Complete a record of positions and velocities before its first step: anchors, surface velocities."""
        for place, node in enumerate((0, 1, self.segments)):
            rod["anchor"][3 * place : 3 * place + 3] = [rod[axis][node] for axis in "xyz"]
        n = self.segments
        y, z, spin = rod["y"][: n + 1], rod["z"][: n + 1], np.pad(rod["w1"][:n], 1, mode="edge")
        around = (y * rod["vz"][: n + 1] - z * rod["vy"][: n + 1]) / np.maximum(np.hypot(y, z), 1e-300)
        rod["slip_x"][: n + 1] = rod["vx"][: n + 1]
        rod["slip_t"][: n + 1] = around + 0.5 * self.rod.radius * (spin[1:] + spin[:-1])

    def energies(self, rod: Any) -> dict[str, float]:
        """Return the energies in J of a record whose positions are those of its velocities' time; see `ENERGIES`.

        Gravity and contact count from the rod at rest on the floor.
        """
        n, mass = self.segments, np.full(self.segments + 1, self.segment_mass)
        mass[0] = mass[n] = 0.5 * self.segment_mass
        node = {name: rod[name][: n + 1] for name in (*cosserat.NODE, *cosserat.LOST)}
        seg = {name: rod[name][:n] for name in cosserat.SEGMENT}
        moving = node["vx"] ** 2 + node["vy"] ** 2 + node["vz"] ** 2
        turning = self.inertia * seg["w1"] ** 2 + self.cross_inertia * (seg["w2"] ** 2 + seg["w3"] ** 2)
        s1, s2, s3 = self._strains(node, seg)
        b1, b2, b3 = _relative_rotations(seg)
        half, inverse = 0.5 * self.segment_length, 2.0 / self.segment_length
        gap, rest = self.rod.radial_clearance, self.rod.radial_clearance + self.depth_at_rest
        beyond = (node["y"] ** 2 + node["z"] ** 2 - gap**2) / (2.0 * gap)
        at_rest = (rest**2 - gap**2) / (2.0 * gap)
        pressed = np.maximum(beyond, 0.0) ** 2.5 - at_rest**2.5
        values = (
            0.5 * np.sum(mass * moving) + 0.5 * np.sum(turning),
            half * self.rod.youngs_modulus * self.rod.area * np.sum(s1**2),
            half * self.shear_rigidity * np.sum(s2**2 + s3**2),
            inverse * self.rod.flexural_rigidity * np.sum(b2**2 + b3**2),
            inverse * self.torsional_rigidity * np.sum(b1**2),
            self.rod.gravity * np.sum(mass * (node["z"] + rest)),
            0.4 * self.contact_stiffness * np.sum(mass * pressed),
            np.sum(mass * node["lost_contact"]),
            np.sum(mass * node["lost_friction"]),
            np.sum(mass * node["lost_damping"]) + np.sum(seg["lost_turning"]),
            rod["work"][0],
        )
        return dict(zip(ENERGIES, map(float, values), strict=True))

    def _strains(self, node: dict[str, Any], seg: dict[str, Any]) -> tuple[Any, Any, Any]:
        """Return stretch and both shears of every segment."""
        a, b, c, d = (seg[name] for name in ("q0", "q1", "q2", "q3"))
        x, y, z = (np.diff(node[name]) / self.segment_length for name in "xyz")
        s1 = (1 - 2 * (c * c + d * d)) * x + 2 * (b * c + a * d) * y + 2 * (b * d - a * c) * z - 1
        s2 = 2 * (b * c - a * d) * x + (1 - 2 * (b * b + d * d)) * y + 2 * (c * d + a * b) * z
        s3 = 2 * (b * d + a * c) * x + 2 * (c * d - a * b) * y + (1 - 2 * (b * b + c * c)) * z
        return s1, s2, s3


def _relative_rotations(seg: dict[str, Any]) -> tuple[Any, Any, Any]:
    """Return the vector part of conj(left) right at every inner node."""
    a, b, c, d = (seg[name][:-1] for name in ("q0", "q1", "q2", "q3"))
    e, f, g, h = (seg[name][1:] for name in ("q0", "q1", "q2", "q3"))
    return a * f - b * e - c * h + d * g, a * g + b * h - c * e - d * f, a * h - b * g + c * f - d * e
