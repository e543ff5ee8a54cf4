"""What nodes and segments of a discretised rod have of its sections: masses, weights, radii, stiffness.

Segments are equal, so sections may meet anywhere in them.  A node has of a density m(s) the mass

    integral of m(s) lambda((s - s_i) / l) ds ,

lambda the cardinal function of cubic interpolation: a sum over nodes is then the integral over the rod to fourth order
wherever m jumps.  Bending stiffness comes in series: 1 / B_i is the mean of 1 / (E I) over the cell of a node, half a
segment to either side, 1 / E_i and the axial and torsional stiffness of a segment that over the segment.  With the
moment M = B_i K_i / l, which is continuous, the error of the energy is of second order:

    of a cell             the variance of M in it, M'^2 l^3 / 12 at most, times 1 / (E I)
    of the directions     that of the four nodes' derivative across a jump J of the curvature, J l / 48 in both segments
                          beside it; in the sum it is M' J l^2 / 24 .
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.rod.model.data import RodData
from floquetrod.simulation.rod_record import CLAMPED

_LEAST_MASS = 0.5  # of the lightest section, that cubic weights may leave a node: where less, hats take their place
_HELD_ALIKE = 2.5  # segments next to a clamped end that have one stiffness: as far as its own energy of bending reaches
_BEYOND = 10.0  # segments beyond its ends by which a rod continues as it is there


class Lumps(NamedTuple):
    """What nodes, (nodes,), and segments, (segments,), have per length, in SI units."""

    mass: Floats  # across the channel, of nodes
    mass_along: Floats
    inertia: Floats  # about the rod's own axis
    weight: Floats  # in fluid
    radius: Floats  # outer, of nodes
    bend: Floats  # E I of nodes
    bend_between: Floats  # E I of segments
    stretch: Floats  # E A of segments


def uniform_rods(rod: RodData) -> tuple[RodData, ...]:
    """Return rods as long as this one, each uniform and like one of its parts; the rod itself where it is uniform."""
    if not rod.varies:
        return (rod,)
    return tuple(part.rod._uniform({"length": rod.length}) for part in rod.uniform_parts)


def lumped(rod: RodData, segments: int, ends: tuple[int, int]) -> Lumps:
    """Return what nodes and segments have of a rod that varies along; ``ends`` are what its ends are across."""
    # Values that jump along the rod, for nodes 0 to ``segments`` and the segments between; ``edges`` are the jumps, in
    # segments from the upper end.  Of a node (mass, weight, radius): the first value plus, of each jump, the part of
    # the node's weight function that lies beyond the edge, 1 - below(edge - node).  The function is cardinal for cubic
    # interpolation; where that makes a mass too small, or negative, a hat.  Of a segment, or about a node for bending,
    # pieces in series: length over the integral of 1 / stiffness, since the same moment or force goes through all of
    # them.
    length = rod.length / segments
    parts = [part.rod for part in rod.uniform_parts]
    edges = np.array([part.start for part in rod.uniform_parts[1:]]) / length
    nodes = np.arange(segments + 1.0)

    def of(value: Callable[[RodData], float]) -> Floats:
        return np.array([value(each) for each in parts])

    def spread(values: Floats, below: Callable[[Floats], Floats]) -> Floats:
        """Return the first value plus the jumps at all edges, each by what of a node is below it."""
        total = np.full(nodes.size, values[0])
        for edge, jump in zip(edges, np.diff(values), strict=True):
            total += jump * (1.0 - below(edge - nodes))
        return total

    mass, along = of(lambda each: each.mass_per_length), of(lambda each: each.mass_along)
    cubic = all((spread(each, _below_cubic) >= _LEAST_MASS * each.min()).all() for each in (mass, along))
    below = _below_cubic if cubic else _below_hat

    def in_series(values: Floats, starts: Floats, stops: Floats) -> Floats:
        """Return the stiffness of pieces of the rod, in segments from its upper end."""
        places = np.array([-_BEYOND, *edges, segments + _BEYOND])
        soft = np.concatenate([[0.0], np.cumsum(np.diff(places) / values)])
        return np.asarray((stops - starts) / (np.interp(stops, places, soft) - np.interp(starts, places, soft)))

    rigidity = of(lambda each: each.flexural_rigidity)
    bend = in_series(rigidity, nodes - 0.5, nodes + 0.5)
    between = in_series(rigidity, nodes[:-1], nodes[1:])
    # A clamped end: one stiffness for its first nodes and segments, that of the length which its energy of bending
    # covers.
    for condition, end in zip(ends, (slice(None), slice(None, None, -1)), strict=True):
        if condition == CLAMPED:  # views: the first is the end
            low, high = (0.0, _HELD_ALIKE) if end.step is None else (segments - _HELD_ALIKE, float(segments))
            bend[end][:3] = between[end][:2] = in_series(rigidity, np.array([low]), np.array([high]))
    return Lumps(
        mass=spread(mass, below),
        mass_along=spread(along, below),
        inertia=spread(of(lambda each: 2.0 * each.density * each.second_moment), below),
        weight=spread(of(lambda each: each.weight_per_length), below),
        radius=spread(of(lambda each: each.radius), _below_cell),
        bend=bend,
        bend_between=between,
        stretch=in_series(of(lambda each: each.axial_rigidity), nodes[:-1], nodes[1:]),
    )


def _below_cubic(t: Floats) -> Floats:
    """Return the integral up to t of the cardinal function of cubic interpolation, 1 in all."""
    size = np.minimum(np.abs(t), 2.0)
    near = size - size**2 / 4.0 - size**3 / 3.0 + size**4 / 8.0
    far = 1.0 / 6.0 + size - 11.0 / 12.0 * size**2 + size**3 / 3.0 - size**4 / 24.0
    return np.asarray(0.5 + np.sign(t) * np.where(size < 1.0, near, far))


def _below_hat(t: Floats) -> Floats:
    """Return the integral up to t of a hat."""
    size = np.minimum(np.abs(t), 1.0)
    return np.asarray(0.5 + np.sign(t) * (size - 0.5 * size**2))


def _below_cell(t: Floats) -> Floats:
    """Return the part of a node's cell up to t."""
    return np.clip(t + 0.5, 0.0, 1.0)


class Stencil(NamedTuple):
    """What the gradient of the energy of bending has of a segment's direction, the next one's and the second one's.

    (segments + 4,) each: from two ghosts before the first segment to two behind the last.
    """

    own: Floats
    next_one: Floats
    second: Floats

    def of(self, directions: Floats) -> Floats:
        """Return the gradient in N m^2 of a component of directions with two ghosts beyond each end."""
        own, first, second = (each[2:-2] for each in self)
        inner = own * directions[2:-2] + first * directions[3:-1] + second * directions[4:]
        return np.asarray(inner + self.next_one[1:-3] * directions[1:-3] + self.second[:-4] * directions[:-4])


def bending_stencil(bend: Floats, between: Floats) -> Stencil:
    """Return the second derivatives of the energy of bending by the directions, mirrored beyond the ends, in N m^2.

    Of sum of B_i K_i^2 / 2 + sum of (B_i+1 K_i+1 - B_i K_i)^2 / (24 E_i), K_i = d_i - d_i-1.
    """
    n = between.size
    own, first, second = (np.zeros(n + 8) for _ in range(3))  # from segment -4 on
    nodes = np.concatenate([bend[3:0:-1], bend, bend[-2:-5:-1]])  # from node -3 on
    soft = 1.0 / (12.0 * np.concatenate([between[2::-1], between, between[:-4:-1]]))  # from segment -3 on
    low = np.arange(nodes.size)  # number of the segment above a node, from -4 on
    own[low + 1] += nodes
    own[low] += nodes
    first[low] -= nodes
    upper, lower, here = nodes[:-1], nodes[1:], low[:-1] + 1  # of a segment
    both = upper + lower
    own[here + 1] += soft * lower**2
    own[here] += soft * both**2
    own[here - 1] += soft * upper**2
    first[here] -= soft * lower * both
    first[here - 1] -= soft * upper * both
    second[here - 1] += soft * upper * lower
    return Stencil(*(each[2:-2] for each in (own, first, second)))


def wall_corners(rod: RodData, segment: float) -> Floats:
    """Return the corners of the wall as `floquetrod.simulation.rod_record.WallCorners` has them, (n, 3).

    Where bores meet, the wall is a cone as long as a segment (a choice): what slides over it is pushed, not thrown.
    """
    middle = rod.depth + 0.5 * rod.length
    if not rod.bores:
        return np.array([[-middle, rod.channel_radius, 0.0]])
    depths = np.array([bore.depth for bore in rod.bores]) - middle
    radii = 0.5 * np.array([bore.diameter for bore in rod.bores])
    rows: list[Any] = [[depths[0], radii[0], 0.0]]
    apart = np.concatenate([[np.inf], np.diff(depths[1:]), [np.inf]])
    for i, (above, below) in enumerate(itertools.pairwise(radii)):
        half = 0.5 * min(segment, apart[i], apart[i + 1])
        depth = depths[i + 1]
        rows += [[depth - half, above, (below - above) / (2.0 * half)], [depth + half, below, 0.0]]
    return np.array(rows)
