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
    >>> f"{mesh.segment_length:.4f} m, {1e3 * mesh.segment_mass:.4f} g"
    '0.0124 m, 0.1621 g'
    """

    rod: RodData
    segments: int
    poisson_ratio: float = 0.33
    indentation: float = 1e-4
    contact_damping: float = 0.3

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        rod, segments = self.rod, validate.integer("segments", self.segments, 4)
        if rod.departures:
            raise ValueError(
                f"rod must be solid, horizontal, hinged and without fluids to be simulated, got {rod.departures}; its "
                "verdicts need no simulation: Rod.stability"
            )
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
