"""The discretised rod in a well: where it starts, its coordinates along the channel, its energies."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod._util.caching import cached_property
from floquetrod.simulation import rod_motion, well_motion
from floquetrod.simulation.driving import Driving
from floquetrod.simulation.mesh import ENERGIES, DiscreteRod
from floquetrod.simulation.rod_motion import CLAMPED, FIRST, GUIDED
from floquetrod.simulation.well_axis import Frames, WellAxis, dot
from floquetrod.wells.drag import FRICTIONLESS, Friction

_ROUNDS = 4  # in which nodes are laid so that the segments have the lengths the mean force gives them


class Natural(NamedTuple):
    """The shape of a rod without load: directions of its segments, (segments, 3), and of what continues them.

    ``ends`` are the directions at its ends, ``shifts`` the second differences of its places there, (2, 3) each.
    """

    directions: Floats
    ends: Floats
    shifts: Floats


@dataclass(frozen=True)
class RodInWell(DiscreteRod):
    """A rod as equal segments between nodes, in a channel about a curved axis.

    Parameters
    ----------
    axis : WellAxis
        That of the channel.
    driving : Driving
        What pushes it: the wall is as stiff as `indentation` says where the mean force presses the rod to it most.
    natural_curvature : float or str
        Curvature of the rod without load in 1/m, in the vertical plane; or "path".
    """

    _: KW_ONLY
    axis: WellAxis
    driving: Driving
    natural_curvature: float | str = 0.0

    @cached_property
    def gravity_on_wall(self) -> float:
        """Largest acceleration with which weight and mean force press the rod to the wall, in m/s^2."""
        x = np.linspace(-0.5, 0.5, 4 * self.segments + 1) * self.rod.length
        return float(self._pressing(x)[0].max()) / self.rod.mass_per_length

    def _pressing(self, x: Floats) -> tuple[Floats, Floats]:
        """Return the force per length in N/m that presses to the wall at places of the axis, and to which angle."""
        frames = self.axis.frames(x)
        force = self.driving.mean_force(x + 0.5 * self.rod.length)
        # Pressed against the vector of curvature, and down.
        outwards = self.rod.weight_per_length * self.axis.gravity - force[:, None] * frames.bend
        aside, down = dot(outwards, frames.sideways), -dot(outwards, frames.up)
        return np.hypot(aside, down), np.arctan2(aside, down)

    def physics(self, driving: Driving, step: float, friction: Friction = FRICTIONLESS) -> Any:
        """Return what the kernels compute with."""
        fall = self.rod.weight_per_length / self.rod.mass_per_length * self.axis.gravity
        has_weight = 0.0 if driving.load.mean_at is None else 1.0
        well = well_motion.Well(tuple(fall.tolist()), has_weight, self.axis.arcs)
        return super().physics(driving, step, friction)._replace(well=well)

    @property
    def motion(self) -> Any:
        """The module of the kernels that move it."""
        return well_motion

    def start(self, driving: Driving, velocities: Floats, friction: float = 0.0) -> Any:
        """Return the record of the rod at its start, where weight and mean force press it to the wall.

        See `DiscreteRod.start`; ``velocities`` are around the channel.
        """
        rod = np.zeros(1, well_motion.rod_type(self.segments))[0]
        self._set_parts(rod, driving, friction)
        places, turned = self._laid(driving)
        frames = self.axis.frames(places[:, 0])
        for place, (end, node) in enumerate(zip(driving.ends, (0, -1), strict=True)):
            if end.is_held:
                velocities = velocities.copy()
                velocities[node] = 0.0
            rod["anchor"][3 * place : 3 * place + 3] = _off(places, frames)[node]
        around = np.cos(turned)[:, None] * frames.sideways + np.sin(turned)[:, None] * frames.up
        speed = np.zeros(self.segments + 1)
        if friction == 0.0:
            displacement, speed = driving.wave(self.places)
            places[:, 0] += displacement / (1.0 - dot(_off(places, frames), frames.bend))
        moving = speed[:, None] * frames.along + velocities[:, None] * around
        for axis, name in enumerate("xyz"):
            self.nodes(rod, name)[:] = self.axis.cartesian(places)[:, axis]
            self.nodes(rod, f"v{name}")[:] = moving[:, axis]
        self._anchor(rod, places[:, 0])
        self._shape(rod, driving)
        return rod

    def _anchor(self, rod: Any, x: Floats) -> None:
        """Write the anchors of the nodes, at places ``x`` of the axis."""
        frames = self.axis.frames(x)
        for prefix, vectors in zip("ctk", (frames.point, frames.along, frames.bend), strict=True):
            for axis in range(3):
                self.nodes(rod, f"{prefix}{axis + 1}")[:] = vectors[:, axis]
        self.nodes(rod, "place")[:] = x
        self.nodes(rod, "arc")[:] = self.axis.arc_at(x)

    def _shape(self, rod: Any, driving: Driving) -> None:
        """Write what the natural shape takes from bending, and from the ghost nodes."""
        for axis in range(3):
            d, n = np.zeros(self.segments + 4), self.segments
            d[FIRST:-2] = self._natural.directions[:, axis]
            for end, a, inward, e in zip(
                driving.ends, (FIRST, FIRST + n - 1), (1, -1), self._natural.ends, strict=True
            ):
                rod_motion.ghost_direction(end.across, d, a, inward, e[axis])
            bent = 2.5 * d[2:-2] - 4.0 / 3.0 * (d[1:-3] + d[3:-1]) + (d[:-4] + d[4:]) / 12.0
            rod[f"b{axis + 1}"][FIRST : FIRST + n] = bent
        rod["shift"][:6] = self._natural.shifts.ravel()

    @cached_property
    def _natural(self) -> Natural:
        """The natural shape, laid along the axis."""
        length = self.segment_length
        nodes = self.places - 0.5 * self.rod.length
        frames = self.axis.frames(nodes)
        if self.natural_curvature == "path":
            outer = self.axis.frames(np.array([nodes[0] - length, nodes[-1] + length])).point
            ends = frames.point[[0, -1]]
            shifts = outer - 2.0 * ends + frames.point[[1, -2]]
            tangents = _tangents(np.vstack([outer[0], frames.point, outer[1]]))
            return Natural(tangents / np.linalg.norm(tangents, axis=1)[:, None], frames.along[[0, -1]], shifts)
        bend = float(self.natural_curvature) * frames.up
        turns = length * np.cumsum(bend[:-1], axis=0)
        directions = frames.along[0] - 0.5 * length * bend[0] + turns
        return Natural(
            directions, np.array([frames.along[0], directions[-1] + 0.5 * length * bend[-1]]), length**2 * bend[[0, -1]]
        )

    # --- what frames hold, and energies ---

    def recorded(self, rod: Any) -> tuple[Floats, Floats]:
        """Return positions and velocities of a record along the axis, sideways and up."""
        places, moving = super().recorded(rod)
        if not np.isfinite(places).all():
            return places, moving
        found, frames = self.axis.along(places, self.nodes(rod, "place"))
        across = [dot(moving, axis) for axis in (frames.along, frames.sideways, frames.up)]
        return found, np.stack(across, axis=1)

    def cartesian(self, positions: Floats) -> Floats:
        """Return the Cartesian places of nodes at recorded positions."""
        return self.axis.cartesian(positions)

    def tangents(self, places: Floats, driving: Driving) -> Floats:
        """Return the tangent of every segment times its length in m, (segments, 3), of nodes at Cartesian places."""
        ghosts = self._natural.shifts + 2.0 * places[[0, -1]] - places[[1, -2]]
        fixed = [place for place, end in enumerate(driving.ends) if end.across in (CLAMPED, GUIDED)]
        axes = self._end_axes(places) if fixed else ghosts
        for place in fixed:
            end, inner, e = places[-place], places[(1, -2)[place]], axes[place]
            ghosts[place] = inner - 2.0 * e * (e @ (inner - end))
        return _tangents(np.vstack([ghosts[:1], places, ghosts[1:]]))

    def _end_axes(self, places: Floats) -> Floats:
        """Return the tangents of the axis at the end nodes, (2, 3)."""
        half = 0.5 * self.rod.length
        return self.axis.along(places[[0, -1]], np.array([-half, half]))[1].along

    def energies(self, rod: Any, driving: Driving) -> dict[str, float]:
        """Return the energies in J of a record whose positions are those of its velocities' time; see `ENERGIES`.

        Gravity and contact count from the rod at rest along the axis, free of force.
        """
        node = {name: self.nodes(rod, name) for name in (*rod_motion.NODE, *rod_motion.LOST, *rod_motion.PARTS)}
        places, moving = super().recorded(rod)
        found, frames = self.axis.along(places, self.nodes(rod, "place"))
        mass, along = self.segment_mass * node["share"], self.mass_along * node["share"]
        speed = dot(moving, frames.along)
        tangents = self.tangents(places, driving)
        lengths = np.linalg.norm(tangents, axis=1)
        gap = self.rod.radial_clearance
        beyond = np.maximum((found[:, 1] ** 2 + found[:, 2] ** 2 - gap**2) / (2.0 * gap), 0.0)
        fallen = places if driving.load.mean_at is not None else places - frames.point
        weight = self.rod.weight_per_length * self.segment_length * node["share"]
        length = self.segment_length
        values = (
            0.5 * np.sum(mass * (dot(moving, moving) - speed**2) + along * speed**2)
            + 0.5 * np.sum(self.inertia * node["share"] * node["spin"] ** 2),
            0.5 * self.rod.axial_rigidity / length * np.sum((lengths - length) ** 2),
            0.5
            * self.rod.flexural_rigidity
            / length
            * self._bent(tangents / lengths[:, None], frames.along[[0, -1]], driving),
            0.5 * self.torsional_rigidity / length * np.sum(np.diff(node["angle"]) ** 2),
            -np.sum(weight * (fallen @ self.axis.gravity)),
            0.4 * self.contact_stiffness * np.sum(mass * beyond**2.5),
            np.sum(mass * node["lost_contact"]),
            np.sum(mass * node["lost_friction"]),
            np.sum(mass * node["lost_damping"]),
            rod["work"][0],
        )
        return dict(zip(ENERGIES, map(float, values), strict=True))

    def _bent(self, directions: Floats, axes: Floats, driving: Driving) -> float:
        """Return the sum of squares by which bending stores energy, ``axes`` being the channel's at both ends."""
        natural = self._natural
        return self._curved(directions - natural.directions, driving, axes - natural.ends)

    # --- how it is laid ---

    def _laid(self, driving: Driving) -> tuple[Floats, Floats]:
        """Return the coordinates along the channel of a rod that rests on the wall under the mean force, and angles.

        Its segments have the lengths that the force gives them.
        """
        n, length = self.segments, self.segment_length
        force = driving.mean_force(self.places[:-1] + 0.5 * length)
        wanted = length * (1.0 - force / self.rod.axial_rigidity)
        first = -0.5 * self.rod.length + 0.25 * sum(driving.mean_forces) * self.rod.length / self.rod.axial_rigidity
        steps = np.full(n, length)
        for _ in range(_ROUNDS):
            x = first + np.concatenate([[0.0], np.cumsum(steps)])
            pressing, turned = self._pressing(x)
            radius = self.rod.radial_clearance + self._depth(pressing)
            places = np.stack([x, radius * np.sin(turned), -radius * np.cos(turned)], axis=1)
            found = np.linalg.norm(self.tangents(self.axis.cartesian(places), driving), axis=1)
            steps = steps * wanted / found
        return places, turned

    def _depth(self, pressing: Floats) -> Floats:
        """Return the depth in m to which a force per length in N/m presses the rod into the wall."""
        share = pressing / (self.rod.mass_per_length * self.gravity_on_wall)
        gap, depth = self.rod.radial_clearance, self.depth_at_rest * share ** (2.0 / 3.0)
        scale = self.rod.mass_per_length * self.contact_stiffness
        for _ in range(4):
            measured = depth * (1.0 + 0.5 * depth / gap)
            depth = depth * (pressing / (scale * measured**1.5 * (1.0 + depth / gap) + 1e-300)) ** (2.0 / 3.0)
        return depth


def _off(places: Floats, frames: Frames) -> Floats:
    """Return the offsets of coordinates along the channel from its axis, (n, 3)."""
    return np.asarray(places[:, 1:2] * frames.sideways + places[:, 2:] * frames.up)


def _tangents(places: Floats) -> Floats:
    """Return the tangents between nodes times their length, of all nodes and a ghost beyond each end."""
    return np.asarray((27.0 * np.diff(places[1:-1], axis=0) - (places[3:] - places[:-3])) / 24.0)
