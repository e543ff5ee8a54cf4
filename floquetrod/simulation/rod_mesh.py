"""The discretised rod: its segments and nodes, the largest stable time step, the steps of a run, its energies."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod._util.caching import cached_property
from floquetrod.rod.loads.tool import VibrationTool
from floquetrod.rod.model.data import RodData
from floquetrod.simulation.driving import ACROSS, Driving
from floquetrod.simulation.kernels.rod_step import energy_of_clamped_end
from floquetrod.simulation.lumping import Lumps, bending_stencil, lumped, uniform_rods, wall_corners
from floquetrod.simulation.resting import resting_radius, steady_vibration
from floquetrod.simulation.rod_record import (
    CLAMPED,
    FIRST,
    FREE,
    GUIDED,
    LOST,
    NO_TOOL,
    NODE,
    PARTS,
    Physics,
    ToolForce,
    WallCorners,
    rod_type,
)
from floquetrod.simulation.start import LEAST_SEGMENTS, MOST_SEGMENTS
from floquetrod.wells.drag import FRICTIONLESS, Friction

ENERGIES = (
    "kinetic",
    "stretch",
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


class Natural(NamedTuple):
    """The shape of a rod without load: directions of its segments, (segments, 3), and of what continues them.

    ``ends`` are the directions at its ends, ``shifts`` the second differences of its places there, (2, 3) each.
    """

    directions: Floats
    ends: Floats
    shifts: Floats


_EVEN = 1e-9  # of the clearance, up to which a wall counts as one without steps
_LAID = 4  # rounds in which nodes are laid so that the segments have the lengths the mean force gives them


@dataclass(frozen=True)
class DiscreteRod:
    """A rod as equal segments between nodes.

    Of a rod that varies along, masses, stiffness and clearance are arrays, of the nodes or of the segments.

    Parameters
    ----------
    rod : RodData
    segments : int
        At least 8 and 6 for every half wave of the critical mode, none shorter than the rod's radius.
    poisson_ratio : float
        In (-1, 0.5]; with Young's modulus it gives the shear modulus, for twist.
    indentation : float
        Depth to which the weight of the rod at rest indents the floor, as a fraction of R: it sets the stiffness of the
        contact.
    contact_damping : float
        Damping of small motion against the wall about rest, as a fraction of the critical damping.

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
        rod, fewest = self.rod, 8
        ratio = validate.finite("poisson_ratio", self.poisson_ratio)
        if not -1.0 < ratio <= 0.5:
            raise validate.wrong_value(
                "poisson_ratio", f"must be above -1 and at most 0.5, got {ratio!r}; metals have 0.25 to 0.45"
            )
        indentation = validate.positive(
            "indentation", self.indentation, "it is a part of the radial clearance R, such as 1e-4"
        )
        if indentation > 0.1:
            raise validate.wrong_value(
                "indentation", f"must be at most 0.1 of the radial clearance R, got {indentation!r}"
            )
        damping = validate.nonnegative("contact_damping", self.contact_damping)
        mode = max(each.critical_mode for each in uniform_rods(rod))
        radius = max(each.radius for each in uniform_rods(rod))
        least, most = (
            math.ceil(min(LEAST_SEGMENTS * mode, 1e18)),
            math.floor(min(rod.length / radius, 1e18)),
        )
        if least > min(most, MOST_SEGMENTS):
            raise validate.wrong_value(
                "rod",
                f"cannot be simulated: {LEAST_SEGMENTS} segments for every half wave of its critical mode "
                f"{mode:.6g} are {least:,}, and at most {min(most, MOST_SEGMENTS):,} are possible; "
                "check the units",
            )
        if fewest > most:
            raise validate.wrong_value(
                "rod",
                f"cannot be simulated: of {fewest} segments each would be shorter than its radius {radius:g} m, as "
                f"it is {rod.length:g} m long; check the units",
            )
        segments = validate.integer("segments", self.segments, fewest)
        if segments < least:
            raise validate.wrong_value(
                "segments",
                f"must be at least {least}, got {segments}: {LEAST_SEGMENTS} for every half wave of the "
                f"critical mode {mode:.2f}",
            )
        if segments > most:
            raise validate.wrong_value(
                "segments",
                f"must be at most {most}, got {segments}: shorter ones than the radius {radius:g} m are "
                "no longer those of a slender rod",
            )
        if segments > MOST_SEGMENTS:
            raise validate.wrong_value("segments", f"must be at most {MOST_SEGMENTS:,}, got {segments:,}; take fewer")
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
    def places(self) -> Floats:
        """Distances of the nodes from the upper end along the rod in m, (nodes,)."""
        return np.asarray(np.arange(self.segments + 1) * self.segment_length, dtype=np.float64)

    @cached_property
    def lumps(self) -> Lumps | None:
        """What nodes and segments have of the sections of a rod that varies along, None of a uniform one."""
        if not self.rod.varies:
            return None
        ends = self.rod.end_conditions
        return lumped(self.rod, self.segments, (ACROSS[ends.upper], ACROSS[ends.lower]))

    @property
    def segment_mass(self) -> Any:
        """Mass m_t l of a segment in motion across the channel, and of every node but those next to the ends, in kg."""
        return self.mass_per_length * self.segment_length

    @property
    def mass_per_length(self) -> Any:
        """Mass m_t in kg/m."""
        return self.rod.mass_per_length if self.lumps is None else self.lumps.mass

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu)) in Pa."""
        return self.rod.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def torsional_rigidity(self) -> Any:
        """G J in N m^2."""
        if self.lumps is not None:
            return self.lumps.bend_between / (1.0 + self.poisson_ratio)
        return 2.0 * self.shear_modulus * self.rod.second_moment

    @property
    def bending_rigidity(self) -> Floats:
        """E I in N m^2 of the nodes."""
        return self._bending[0] * self._bending[1]

    @property
    def _bending(self) -> tuple[float, Floats, Floats]:
        """One bending stiffness in N m^2, and the stiffnesses of nodes and segments over it."""
        if self.lumps is None:
            return self.rod.flexural_rigidity, np.ones(self.segments + 1), np.ones(self.segments)
        one = float(self.lumps.bend[0])
        return one, self.lumps.bend / one, self.lumps.bend_between / one

    @property
    def axial_rigidity(self) -> Any:
        """E A in N."""
        return self.rod.axial_rigidity if self.lumps is None else self.lumps.stretch

    @property
    def mass_along(self) -> Any:
        """Mass in kg of a segment in motion along the channel, of its material alone."""
        return (self.rod.mass_along if self.lumps is None else self.lumps.mass_along) * self.segment_length

    @property
    def inertia(self) -> Any:
        """Moment of inertia of a segment about its own axis, 2 rho I l, in kg m^2."""
        if self.lumps is not None:
            return self.lumps.inertia * self.segment_length
        return 2.0 * self.rod.density * self.rod.second_moment * self.segment_length

    @property
    def weight_per_length(self) -> Any:
        """Weight in fluid in N/m."""
        return self.rod.weight_per_length if self.lumps is None else self.lumps.weight

    @property
    def gravity_on_wall(self) -> Any:
        """Acceleration in m/s^2 with which the rod at rest presses on the wall that `indentation` is about."""
        if self.lumps is not None:
            return self.lumps.weight * self._across / self.lumps.mass
        return self.rod.effective_gravity

    @property
    def _across(self) -> float:
        """The part of gravity that acts across the channel."""
        return self.rod.channel.gravity_across / self.rod.gravity

    @cached_property
    def wall(self) -> WallCorners | None:
        """The wall of the channel of a rod that varies along, None of a uniform one."""
        return WallCorners(wall_corners(self.rod, self.segment_length)) if self.rod.varies else None

    def clearance_at(self, x: Floats) -> Any:
        """Return the radial clearance in m of nodes (..., nodes) at places ``x`` along the channel.

        Returns
        -------
        float or ndarray
            In m.
        """
        if self.wall is None or self.lumps is None:
            return self.rod.radial_clearance
        places, radii, slopes = self.wall.corners.T
        row = np.maximum(np.searchsorted(places, x, side="right") - 1, 0)
        return radii[row] + slopes[row] * (x - places[row]) - self.lumps.radius

    @property
    def widest(self) -> float:
        """The largest radius of the channel in m."""
        return self.rod.channel_radius if self.wall is None else float(self.wall.corners[:, 1].max())

    @cached_property
    def clearance(self) -> Any:
        """Radial clearance R in m, of nodes where they lie without load."""
        return self.clearance_at(self.places - 0.5 * self.rod.length)

    @property
    def depth_at_rest(self) -> Any:
        """Depth to which the weight of the rod at rest indents the floor, in m."""
        return self.indentation * self.clearance

    @property
    def contact_stiffness(self) -> Any:
        """Factor k of the contact's acceleration k sqrt(d) (d + C v), which at rest carries the weight."""
        gap, depth = self.clearance, self.depth_at_rest
        d = depth * (1.0 + 0.5 * depth / gap)  # the measure of indentation of the kernels
        return self.gravity_on_wall / (_root(d) * d * (1.0 + depth / gap))

    @property
    def contact_time(self) -> Any:
        """C of the contact's acceleration in s, from the damping of small motion about rest."""
        return 2.0 * self.contact_damping * _root(1.5 * self.depth_at_rest / self.gravity_on_wall)

    def physics(self, driving: Driving, step: float, friction: Friction = FRICTIONLESS) -> Physics:
        """Return the record of numbers for the kernels."""
        rod, load = self.rod, driving.load
        upper, lower = driving.ends
        return Physics(
            segments=self.segments,
            step=step,
            segment=self.segment_length,
            **(dict.fromkeys(_UNIFORM, math.nan) if rod.varies else self._uniform_physics(driving)),
            friction=friction.largest,
            grips=np.column_stack([np.subtract(friction.depths, rod.depth + 0.5 * rod.length), friction.values]),
            decay=math.exp(-rod.damping_rate * step),
            decay_along=math.exp(-driving.axial_damping * step),
            frequency=load.frequency,
            harmonics=len(load.harmonics) if load.amplitude > 0.0 else 0,
            upper=upper,
            lower=lower,
            tool=self._tool(driving.tool),
            wall=self.wall,
        )

    def _uniform_physics(self, driving: Driving) -> dict[str, float]:
        """Return the numbers of the kernels that differ along a rod that varies, which has them in its record."""
        rod = self.rod
        numbers = (
            *(self.segment_mass, self.mass_along, self.inertia),
            *(rod.axial_rigidity, rod.flexural_rigidity, self.torsional_rigidity),
            *(rod.radius, rod.radial_clearance, rod.effective_gravity, driving.gravity_along),
            *(self.contact_stiffness, self.contact_time),
        )
        return dict(zip(_UNIFORM, map(float, numbers), strict=True))

    def _tool(self, tool: VibrationTool | None) -> ToolForce:
        """Return a tool between the nodes."""
        if tool is None:
            return NO_TOOL
        place = (self.rod.length - tool.above_end) / self.segment_length
        node = min(int(place), self.segments - 1)
        amplitude, frequency, *phase = (0.0, 0.0) if tool.second is None else tool.second
        second = amplitude, frequency, phase[0] if phase else 0.0
        return ToolForce(tool.amplitude, tool.frequency, node, place - node, *second)

    @property
    def record_type(self) -> np.dtype[np.void]:
        """Type of the record that holds it."""
        return rod_type(self.segments, varies=self.rod.varies)

    def start(self, driving: Driving, velocities: Floats, friction: float = 0.0) -> Any:
        """Return the record of the rod at its start, on the wall.

        It is squeezed by the mean forces and, without friction, vibrates along the channel as it will steadily;
        ``velocities`` across the channel, of all nodes in m/s, in a well around it.
        """
        rod = np.zeros(1, self.record_type)[0]
        self._set_parts(rod, driving, friction)
        if self.rod.varies:
            self._set_sections(rod, driving)
            self.nodes(rod, "gap")[:] = self.clearance
            self.nodes(rod, "mark")[:] = self.places - 0.5 * self.rod.length
        places = self.places
        if friction > 0.0:
            wave = np.zeros_like(places), np.zeros_like(places)
        elif self.rod.varies:
            wave = self._steady_vibration(driving, rod)
        else:
            wave = driving.wave(places)
        held = [node for node, end in zip((0, -1), driving.ends, strict=True) if end.is_held]
        velocities = velocities.copy()
        velocities[held] = 0.0
        self._lay(rod, driving, velocities, wave)
        return rod

    def resumed(self, record: bytes, driving: Driving, friction: Friction, *, same_friction: bool) -> Any:
        """Return a record of the rod with the friction and the driving of another run, and its clock at 0."""
        (rod,) = np.frombuffer(bytearray(record), self.record_type)
        kept = self.nodes(rod, "grip").copy()
        rod["cosines"][:] = rod["sines"][:] = rod["clock"][:] = 0.0
        self._set_parts(rod, driving, friction.largest)
        self._set_sections(rod, driving)
        if len(friction.values) > 1:
            grips = friction.at(self._places_along(rod) + (self.rod.depth + 0.5 * self.rod.length))
            if same_friction:  # taken from where nodes were up to 16 steps ago
                grips[1:-1] = kept[1:-1]
                grips = np.where(kept > 0.0, kept, grips)
            grip = self.nodes(rod, "grip")
            grip[:] = np.where(grip > 0.0, grips, 0.0)
        return rod

    def _lay(self, rod: Any, driving: Driving, velocities: Floats, wave: tuple[Floats, Floats]) -> None:
        """Write where the rod lies, how it moves, and where its ends are held; ``wave`` is displacement and speed."""
        if self.rod.varies:
            laid = self._laid(driving, lambda x: np.stack([x, np.zeros_like(x), -self._rest(driving)], axis=1))
            self.nodes(rod, "x")[:] = laid[:, 0] + wave[0]
            self.nodes(rod, "z")[:] = laid[:, 2]
        else:
            self.nodes(rod, "x")[:] = driving.squeezed(self.places) + wave[0]
            self.nodes(rod, "z")[:] = -(self.rod.radial_clearance + self.depth_at_rest)
        self.nodes(rod, "vx")[:] = wave[1]
        self.nodes(rod, "vy")[:] = velocities
        rod["anchor"][2:6:3] = self.nodes(rod, "z")[[0, -1]]

    def _rest(self, driving: Driving) -> Floats:
        """Return the distance in m of the nodes of a rod that varies from the channel's axis, at rest under weight."""
        return self._radius_at_rest(driving, self.gravity_on_wall * self.mass_per_length)

    def _radius_at_rest(self, driving: Driving, pressing: Floats) -> Floats:
        """Return the distance in m of nodes from the channel's axis where a force per length in N/m presses them."""
        lumps = self.lumps
        if lumps is None or np.ptp(self.clearance) <= _EVEN * self.clearance.max():
            return np.asarray(self.clearance + self._depth(pressing))
        return resting_radius(
            self.segment_length,
            (lumps.bend, lumps.bend_between),
            driving.mean_force(self.places[:-1] + 0.5 * self.segment_length),
            pressing,
            self.clearance,
            self.mass_per_length * self.contact_stiffness,
            (driving.ends[0].across, driving.ends[1].across),
        )

    def _depth(self, pressing: Floats) -> Floats:
        """Return the depth in m to which a force per length in N/m presses the rod into the wall."""
        mass = self.mass_per_length
        share = pressing / (mass * self.gravity_on_wall)
        gap, depth = self.clearance, self.depth_at_rest * share ** (2.0 / 3.0)
        scale = mass * self.contact_stiffness
        for _ in range(4):
            measured = depth * (1.0 + 0.5 * depth / gap)
            depth = depth * (pressing / (scale * measured**1.5 * (1.0 + depth / gap) + 1e-300)) ** (2.0 / 3.0)
        return np.asarray(depth)

    def _laid(self, driving: Driving, placed: Callable[[Floats], Floats]) -> Floats:
        """Return coordinates along the channel of nodes at x, (nodes, 3), that give segments their length under force.

        ``placed`` returns the values of nodes at x.
        """
        n, length = self.segments, self.segment_length
        force = driving.mean_force(self.places[:-1] + 0.5 * length)
        wanted = length * (1.0 - force / self.axial_rigidity)
        first = -0.5 * self.rod.length + self._half_shorter(driving)
        steps = np.full(n, length)
        for _ in range(_LAID):
            places = placed(first + np.concatenate([[0.0], np.cumsum(steps)]))
            lengths = np.linalg.norm(self.tangents(self.cartesian(places), driving), axis=1)
            steps = steps * wanted / lengths
        return places

    def _half_shorter(self, driving: Driving) -> float:
        """Return half of what the mean forces take from the length of the rod, in m."""
        if self.lumps is None:
            return 0.25 * sum(driving.mean_forces) * self.rod.length / self.rod.axial_rigidity
        force = driving.mean_force(self.places[:-1] + 0.5 * self.segment_length)
        return 0.5 * self.segment_length * float(np.sum(force / self.axial_rigidity))

    def _steady_vibration(self, driving: Driving, rod: Any) -> tuple[Floats, Floats]:
        """Return displacement and velocity of the nodes along the channel at the start, of the steady vibration."""
        still = np.zeros(self.segments + 1)
        if driving.load.amplitude == 0.0 or driving.feed_speed is not None:
            return still, still
        upper, lower = driving.ends
        return steady_vibration(
            self.segment_length,
            self.axial_rigidity / self.segment_length,
            self.mass_along * self.nodes(rod, "share"),
            driving.axial_damping,
            driving.load.frequency,
            driving.harmonics,
            (upper.drive, None if lower.moved else lower.drive),
        )

    def _set_sections(self, rod: Any, driving: Driving) -> None:
        """Write what nodes and segments have of the sections of a rod that varies along, wherever they are."""
        lumps, length = self.lumps, self.segment_length
        if lumps is None:
            return
        for name, values in (
            ("mass", self.segment_mass),
            ("mass_along", self.mass_along),
            ("inertia", self.inertia),
            ("gravity", self._fall),
            ("gravity_along", self._slide(driving)),
            ("outer", lumps.radius),
            ("contact", self.contact_stiffness),
            ("contact_time", self.contact_time),
        ):
            self.nodes(rod, name)[:] = values
        for name, values in (("stretch", self.axial_rigidity), ("twist", self.torsional_rigidity)):
            rod[name][FIRST : FIRST + self.segments] = values / length
        for name, values in zip(
            ("bend", "bend_next", "bend_second"), bending_stencil(lumps.bend, lumps.bend_between), strict=True
        ):
            rod[name][: values.size] = values / length

    def _slide(self, driving: Driving) -> Any:
        """Return the acceleration of nodes in m/s^2 by weight along a straight channel."""
        if self.lumps is None:
            return driving.gravity_along
        has_weight = 0.0 if driving.load.mean_at is None else self.rod.channel.gravity_along / self.rod.gravity
        return has_weight * self.lumps.weight / self.lumps.mass_along

    @property
    def _fall(self) -> Any:
        """Acceleration of nodes in m/s^2 by weight, across a straight channel."""
        return self.gravity_on_wall

    def _set_parts(self, rod: Any, driving: Driving, friction: float) -> None:
        """Write the parts of the rod that nodes have, their friction, and the vibration."""
        rod["share"][FIRST : FIRST + self.segments + 1], rod["grip"][FIRST : FIRST + self.segments + 1] = 1.0, friction
        for end, node, inwards in zip(driving.ends, (FIRST, FIRST + self.segments), (1, -1), strict=True):
            # Of the trapezoidal rule, and of Gregory's where an end may move with a slope.
            for distance, share in enumerate(_FREE_END if end.across == FREE else (0.5,)):
                rod["share"][node + distance * inwards] = share
            if end.is_held or end.moved:
                rod["grip"][node] = 0.0  # the kernels take its friction apart
        for name, values in (("cosines", driving.harmonics.real), ("sines", -driving.harmonics.imag)):
            rod[name][: values.size] = values

    def nodes(self, rod: Any, name: str) -> Floats:
        """Return the view of a field of a record that belongs to the nodes.

        Parameters
        ----------
        rod : structured ndarray
            The record.
        name : str
            The field.

        Returns
        -------
        ndarray
            (segments + 1, ...), a view.
        """
        values: Floats = rod[name][FIRST : FIRST + self.segments + 1]
        return values

    def recorded(self, rod: Any) -> tuple[Floats, Floats]:
        """Return positions and velocities of a record as frames hold them, (nodes, 3) each."""
        places, moving = (np.stack([self.nodes(rod, p + name) for name in "xyz"], axis=1) for p in ("", "v"))
        return places, moving

    def cartesian(self, positions: Floats) -> Floats:
        """Return the Cartesian positions of nodes at recorded positions."""
        return positions

    def energies(self, rod: Any, driving: Driving) -> dict[str, float]:
        """Return the energies in J of a record with positions and velocities at one time; see `ENERGIES`.

        Gravity and contact count from the rod at rest: straight on the floor, in a well along its axis.

        Returns
        -------
        dict of str to float
            By the names in `ENERGIES`.
        """
        node = {name: self.nodes(rod, name) for name in (*NODE, *LOST, *PARTS)}
        places, moving = self.recorded(rod)
        share, length, gap = node["share"], self.segment_length, self.clearance_at(places[:, 0])
        mass, along = self.segment_mass * share, self.mass_along * share
        cartesian = np.stack([node[axis] for axis in "xyz"], axis=1)
        tangents = self.tangents(cartesian, driving)
        lengths = np.linalg.norm(tangents, axis=1)
        directions = tangents / lengths[:, None] - self._natural.directions
        beyond = (places[:, 1] ** 2 + places[:, 2] ** 2 - gap**2) / (2.0 * gap)
        pressed = mass * (np.maximum(beyond, 0.0) ** 2.5 - self._pressed_at_rest)
        values = (
            0.5 * np.sum(mass * (moving[:, 1] ** 2 + moving[:, 2] ** 2) + along * moving[:, 0] ** 2)
            + 0.5 * np.sum(self.inertia * share * node["spin"] ** 2),
            total_of(0.5 * self.axial_rigidity / length, (lengths - length) ** 2),
            0.5
            * self._bending[0]
            / length
            * _curved(directions, driving, self._axes(cartesian) - self._natural.ends, *self._bending[1:]),
            total_of(0.5 * self.torsional_rigidity / length, np.diff(node["angle"]) ** 2),
            self._raised(driving, places, cartesian, share),
            total_of(0.4 * self.contact_stiffness, pressed),
            np.sum(mass * node["lost_contact"]),
            np.sum(mass * node["lost_friction"]),
            np.sum(mass * node["lost_damping"]),
            rod["work"][0],
        )
        return dict(zip(ENERGIES, map(float, values), strict=True))

    def tangents(self, places: Floats, driving: Driving) -> Floats:
        """Return the tangent of every segment times its length in m, (segments, 3), of nodes at Cartesian places."""
        ghosts = self._natural.shifts + 2.0 * places[[0, -1]] - places[[1, -2]]
        for ghost, end, axis, outer, inner in zip(
            ghosts, driving.ends, self._axes(places), places[[0, -1]], places[[1, -2]], strict=True
        ):
            if end.across in (CLAMPED, GUIDED):
                ghost[:] = inner - 2.0 * ((inner - outer) @ axis) * axis
        return tangents_between(np.vstack([ghosts[0], places, ghosts[1]]))

    # --- what is otherwise in a well ---

    @property
    def _natural(self) -> Natural:
        """The shape without load; a straight rod's takes nothing away."""
        return _STRAIGHT

    @property
    def _pressed_at_rest(self) -> Any:
        """Measure of the energy by which a node at rest indents the floor, the zero of the energy of contact."""
        gap, rest = self.clearance, self.clearance + self.depth_at_rest
        return ((rest**2 - gap**2) / (2.0 * gap)) ** 2.5

    def _axes(self, places: Floats) -> Floats:
        """Return the directions of the channel at both end nodes, (2, 3), of a rod at Cartesian places."""
        return _ALONG

    def _places_along(self, rod: Any) -> Floats:
        """Return where nodes of a record are along the channel, in m from its middle."""
        return self.nodes(rod, "x")

    def _raised(self, driving: Driving, places: Floats, cartesian: Floats, share: Floats) -> float:
        """Return the energy in J by which weight pulls nodes at recorded places."""
        up = places[:, 2] + (self.clearance + self.depth_at_rest)
        down = places[:, 0] - (self.places - 0.5 * self.rod.length)
        raised = total_of(self.gravity_on_wall, self.segment_mass * share * up)
        return raised - total_of(self._slide(driving), self.mass_along * share * down)


def tangents_between(places: Floats) -> Floats:
    """Return the tangents between nodes times their length, of all nodes and a ghost beyond each end."""
    return np.asarray((27.0 * np.diff(places[1:-1], axis=0) - (places[3:] - places[:-3])) / 24.0)


def _curved(directions: Floats, driving: Driving, axes: Floats, bend: Floats, between: Floats) -> float:
    """Return the sum of squares by which bending stores energy, see `floquetrod.simulation.kernels.rod_step`.

    ``axes`` are the directions of the channel at both ends; the natural shape's are taken away from all.  ``bend`` and
    ``between`` are the stiffness of nodes and segments over one that counts as 1.
    """
    inner = np.diff(directions, axis=0)
    moments = bend[1:-1, None] * inner
    total = np.sum(moments * inner) + np.sum(np.diff(moments, axis=0) ** 2 / between[1:-1, None]) / 12.0
    for end, axis, sign, first, next_one, moment, stiff, own in zip(
        driving.ends,
        axes,
        (1.0, -1.0),
        directions[[0, -1]],
        inner[[0, -1]],
        moments[[0, -1]],
        between[[0, -1]],
        bend[[0, -1]],
        strict=True,
    ):
        bent = 2.0 * sign * (first - axis)
        if end.across == CLAMPED:  # next to which the stiffness is one
            total += own * energy_of_clamped_end(bent @ bent, bent @ next_one, next_one @ next_one)
        elif end.across == GUIDED:
            turned = own * bent
            joint = turned @ turned / stiff - 2.0 * (turned @ moment / stiff) + moment @ moment / stiff
            total += 0.5 * (turned @ bent) + joint / 12.0
        else:
            total += moment @ moment / stiff / 12.0
    return float(total)


def total_of(factor: Any, values: Floats) -> float:
    """Return the sum of values times a factor, one or one for each."""
    return float(factor * np.sum(values) if np.ndim(factor) == 0 else np.sum(factor * values))


def _root(value: Any) -> Any:
    """Return the square root of a number or of numbers."""
    return math.sqrt(value) if isinstance(value, float) else np.sqrt(value)


_UNIFORM = (
    *("mass", "mass_along", "inertia", "stretch", "bend", "twist"),
    *("radius", "radial_clearance", "gravity", "gravity_along", "contact", "contact_damping"),
)  # numbers of `Physics` that differ along a rod that varies
_ALONG = np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])  # the straight channel, at both ends
_STRAIGHT = Natural(np.zeros(3), np.zeros((2, 3)), np.zeros((2, 3)))

_FREE_END = (3.0 / 8.0, 7.0 / 6.0, 23.0 / 24.0)
