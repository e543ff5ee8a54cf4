"""The discretised rod in a well: where it starts, its coordinates along the channel, its energies."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod._util.caching import cached_property
from floquetrod.simulation.driving import Driving
from floquetrod.simulation.kernels.rod_step import ghost_direction
from floquetrod.simulation.lumping import bending_stencil
from floquetrod.simulation.rod_mesh import DiscreteRod, Natural, tangents_between, total_of
from floquetrod.simulation.rod_record import FIRST, Physics, Well, rod_type
from floquetrod.simulation.well_axis import WellAxis, dot
from floquetrod.wells.drag import FRICTIONLESS, Friction


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
    def gravity_on_wall(self) -> Any:
        """Largest acceleration with which weight and mean force press the rod to the wall, in m/s^2."""
        x = np.linspace(-0.5, 0.5, 4 * self.segments + 1) * self.rod.length
        return float(self._pressing(x)[0].max()) / self.mass_per_length

    def _pressing(self, x: Floats) -> tuple[Floats, Floats]:
        """Return the force per length in N/m that presses to the wall at places of the axis, and to which angle."""
        frames = self.axis.frames(x)
        force = self.driving.mean_force(x + 0.5 * self.rod.length)
        # Pressed against the vector of curvature, and down.
        weight: Any = self.rod.weight_per_length
        if self.rod.varies:
            weight = self.rod.along(np.clip(x / self.rod.length + 0.5, 0.0, 1.0)).weight[:, None]
        outwards = weight * self.axis.gravity - force[:, None] * frames.bend
        aside, down = dot(outwards, frames.sideways), -dot(outwards, frames.up)
        return np.hypot(aside, down), np.arctan2(aside, down)

    def physics(self, driving: Driving, step: float, friction: Friction = FRICTIONLESS) -> Physics:
        """Return what the kernels compute with."""
        fall = self.axis.gravity if self.rod.varies else self._fall * self.axis.gravity
        has_weight = 0.0 if driving.load.mean_at is None else 1.0
        well = Well(tuple(fall.tolist()), has_weight, self.axis.arcs)
        return super().physics(driving, step, friction)._replace(well=well)

    @property
    def record_type(self) -> np.dtype[np.void]:
        """Type of the record that holds it."""
        return rod_type(self.segments, in_well=True, varies=self.rod.varies)

    @property
    def _fall(self) -> Any:
        """Acceleration of nodes in m/s^2 by weight, along gravity."""
        return self.weight_per_length / self.mass_per_length

    def _lay(self, rod: Any, driving: Driving, velocities: Floats, wave: tuple[Floats, Floats]) -> None:
        """Write where weight and mean force press the rod to the wall, how it moves, and where its ends are held."""
        places, turned = self._pressed(driving)
        frames = self.axis.frames(places[:, 0])
        off = places[:, 1:2] * frames.sideways + places[:, 2:] * frames.up
        rod["anchor"][:6] = off[[0, -1]].ravel()
        around = np.cos(turned)[:, None] * frames.sideways + np.sin(turned)[:, None] * frames.up
        places[:, 0] += wave[0] / (1.0 - dot(off, frames.bend))
        moving = wave[1][:, None] * frames.along + velocities[:, None] * around
        for axis, name in enumerate("xyz"):
            self.nodes(rod, name)[:] = self.axis.cartesian(places)[:, axis]
            self.nodes(rod, f"v{name}")[:] = moving[:, axis]
        # Anchors: point, tangent and curvature vector of the axis beside each node.
        x = places[:, 0]
        frames = self.axis.frames(x)
        for prefix, vectors in zip("ctk", (frames.point, frames.along, frames.bend), strict=True):
            for axis in range(3):
                self.nodes(rod, f"{prefix}{axis + 1}")[:] = vectors[:, axis]
        self.nodes(rod, "place")[:] = x
        self.nodes(rod, "arc")[:] = self.axis.arc_at(x)
        self._shape(rod, driving)

    def _shape(self, rod: Any, driving: Driving) -> None:
        """Write what the natural shape takes from bending, and from the ghost nodes."""
        natural, n = self._natural, self.segments
        for axis in range(3):
            d = np.zeros(n + 4)
            d[FIRST:-2] = natural.directions[:, axis]
            for end, a, inward, e in zip(driving.ends, (FIRST, FIRST + n - 1), (1, -1), natural.ends, strict=True):
                ghost_direction(end.across, d, a, inward, e[axis])
            if self.lumps is None:
                bent = 2.5 * d[2:-2] - 4.0 / 3.0 * (d[1:-3] + d[3:-1]) + (d[:-4] + d[4:]) / 12.0
            else:
                bent = bending_stencil(self.lumps.bend, self.lumps.bend_between).of(d) / self.segment_length
            rod[f"b{axis + 1}"][FIRST : FIRST + n] = bent
        rod["shift"][:6] = natural.shifts.ravel()

    @cached_property
    def _natural(self) -> Natural:
        """The natural shape, laid along the axis, with the deflection of the rod to its side."""
        length = self.segment_length
        nodes = self.places - 0.5 * self.rod.length
        frames = self.axis.frames(nodes)
        if self.natural_curvature == "path":
            outer = self.axis.frames(np.array([nodes[0] - length, nodes[-1] + length])).point
            ends = frames.point[[0, -1]]
            shifts = outer - 2.0 * ends + frames.point[[1, -2]]
            tangents = tangents_between(np.vstack([outer[0], frames.point, outer[1]]))
            directions, at_ends = tangents / np.linalg.norm(tangents, axis=1)[:, None], frames.along[[0, -1]]
        else:
            bend = float(self.natural_curvature) * frames.up
            directions = frames.along[0] - 0.5 * length * bend[0] + length * np.cumsum(bend[:-1], axis=0)
            at_ends = np.array([frames.along[0], directions[-1] + 0.5 * length * bend[-1]])
            shifts = length**2 * bend[[0, -1]]
        shape = self.rod.natural_shape
        if shape is None:
            return Natural(directions, at_ends, shifts)
        # Slopes dy_0/ds turn directions to the side, and y_0'' l^2 shifts ghosts; terms of the square of the slope are
        # left out.
        middles = (np.arange(self.segments) + 0.5) / self.segments
        between, outer_ends = (shape.patterns(x, self.rod.length) for x in (middles, np.array([0.0, 1.0])))
        side = self.axis.frames((middles - 0.5) * self.rod.length).sideways, frames.sideways[[0, -1]]
        slopes, slopes_at_ends = (each.slope[0][:, None] / self.rod.length for each in (between, outer_ends))
        bends = outer_ends.bend[0][:, None] / self.segments**2
        return Natural(directions + slopes * side[0], at_ends + slopes_at_ends * side[1], shifts + bends * side[1])

    # --- what frames hold, and energies ---

    def recorded(self, rod: Any) -> tuple[Floats, Floats]:
        """Return positions and velocities of a record along the axis, sideways and up."""
        places, moving = super().recorded(rod)
        if not np.isfinite(places).all():
            return places, moving
        positions, frames = self.axis.along(places, self.nodes(rod, "place"))
        across = [dot(moving, axis) for axis in (frames.along, frames.sideways, frames.up)]
        return positions, np.stack(across, axis=1)

    def cartesian(self, positions: Floats) -> Floats:
        """Return the Cartesian places of nodes at recorded positions."""
        return self.axis.cartesian(positions)

    def _axes(self, places: Floats) -> Floats:
        """Return the directions of the channel at both end nodes, (2, 3), of a rod at Cartesian places."""
        half = 0.5 * self.rod.length
        return self.axis.along(places[[0, -1]], np.array([-half, half]))[1].along

    def _places_along(self, rod: Any) -> Floats:
        """Return where nodes of a record are along the channel, in m from its middle."""
        return self.nodes(rod, "place")

    @property
    def _pressed_at_rest(self) -> float:
        """Measure of the energy of contact at rest, none along the axis."""
        return 0.0

    def _raised(self, driving: Driving, places: Floats, cartesian: Floats, share: Floats) -> float:
        """Return the energy in J by which weight pulls nodes at recorded places."""
        has_weight = driving.load.mean_at is not None
        fallen = cartesian if has_weight else cartesian - self.axis.frames(places[:, 0]).point
        return total_of(-self.weight_per_length * self.segment_length, share * (fallen @ self.axis.gravity))

    # --- how it is laid ---

    def _pressed(self, driving: Driving) -> tuple[Floats, Floats]:
        """Return the coordinates along the channel of a rod that rests on the wall under the mean force, and angles.

        Its segments have the lengths that the force gives them.
        """

        def placed(x: Floats) -> Floats:
            pressing, turned = self._pressing(x)
            radius = self._radius_at_rest(driving, pressing)
            return np.stack([x, radius * np.sin(turned), -radius * np.cos(turned)], axis=1)

        places = self._laid(driving, placed)
        return places, self._pressing(places[:, 0])[1]
