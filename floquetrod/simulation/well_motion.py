"""Kernels for the rod simulated in a well: the rod of `rod_motion` inside a tube about a curved axis.

Positions and velocities are Cartesian, so that stretch, bending and twist are those of the straight channel's rod, to
the letter.  What differs is where a node's wall is and which way is along the channel.  Each node has an anchor on the
axis: a point c, the tangent t and the vector of curvature k there.  With o = r - c the point of the axis nearest to the
node is, to the third order of its distance xi from the anchor,

    c + xi t + xi^2 k / 2,    xi = t.o / (1 - k.o),    tangent  t + xi k,    offset  q = o - xi t - xi^2 k / 2 .

Anchors follow the nodes along the exact arcs every few steps, in which a node moves by some micrometres.  That the loop
over the nodes reads anchors and not the arcs is what lets compilers vectorise it.

A rod of natural curvature is bent by the difference of its directions from those of its natural shape, which stay where
the rod was laid; ghost cells and stencil being linear, that subtracts a constant from the stencil of every segment.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.compilation import kernel
from floquetrod.simulation import rod_motion
from floquetrod.simulation.rod_motion import (
    CLAMPED,
    FAR,
    FIRST,
    GUIDED,
    HINGED,
    NEAR,
    TINY,
    directions,
    ghost_direction,
    ghost_force,
    grip_at,
    on_ends,
    push_node,
    pushed_speed,
    rub,
    set_grips,
    tool_force,
    vibration,
)

ANCHOR = ("c1", "c2", "c3", "t1", "t2", "t3", "k1", "k2", "k3", "place", "arc")
"""Of nodes: the point of the axis, its tangent and curvature; its distance along the axis, and the arc it lies on."""

NATURAL = ("b1", "b2", "b3")
"""Of segments: what the stencil of bending makes of the directions of the natural shape."""

HOLD = ("shift", "axis")
"""Of the upper and the lower end, three numbers each: what the ghost of a naturally curved rod has beside that of a
straight one, and the tangent of the axis of the channel."""

BETWEEN_ANCHORS = 16
"""Steps after which anchors follow the nodes (a choice: at 10 m/s a node moves by half a millimetre in so many)."""


def rod_type(segments: int) -> np.dtype[np.void]:
    """Return the record that holds a rod of so many segments, see `rod_motion.rod_type`.

    What it has beside comes first: to numba a record with more fields at its end is one of the shorter kind.
    """
    plain = rod_motion.rod_type(segments)
    fields = (*ANCHOR, *NATURAL, *HOLD, *(plain.names or ()))
    return np.dtype([(name, np.float64, plain["x"].shape) for name in fields])


class Well(NamedTuple):
    """What `rod_motion.Physics` has of a well: the axis of its channel, and the weight as a vector."""

    gravity: tuple[float, float, float]  # weight over the mass in motion across
    weight_along: float  # 1 where the weight acts along the channel too, else 0
    arcs: NDArray[np.float64]  # a row each: place of its upper end; point, tangent and normal there; curvature


@kernel
def _follow(rod: Any, first: int, last: int, p: Any) -> None:
    """Move the anchors of nodes to the points of the axis nearest to them."""
    arcs = p.well.arcs
    x, y, z, c1, c2, c3 = rod["x"], rod["y"], rod["z"], rod["c1"], rod["c2"], rod["c3"]
    t1, t2, t3, k1, k2, k3 = rod["t1"], rod["t2"], rod["t3"], rod["k1"], rod["k2"], rod["k3"]
    place, arc = rod["place"], rod["arc"]
    for i in range(first, last):
        o1, o2, o3 = x[i] - c1[i], y[i] - c2[i], z[i] - c3[i]
        room = 1.0 - (k1[i] * o1 + k2[i] * o2 + k3[i] * o3)
        s = place[i] + (t1[i] * o1 + t2[i] * o2 + t3[i] * o3) / room
        j = int(arc[i])
        while j + 1 < len(arcs) and s >= arcs[j + 1, 0]:
            j += 1
        while j > 0 and s < arcs[j, 0]:
            j -= 1
        below, bend = s - arcs[j, 0], arcs[j, 10]
        sine, cosine = math.sin(bend * below), math.cos(bend * below)
        half = math.sin(0.5 * bend * below)
        run, off = (sine / bend, 2.0 * half * half / bend) if bend > 0.0 else (below, 0.0)
        c1[i] = arcs[j, 1] + run * arcs[j, 4] + off * arcs[j, 7]
        c2[i] = arcs[j, 2] + run * arcs[j, 5] + off * arcs[j, 8]
        c3[i] = arcs[j, 3] + run * arcs[j, 6] + off * arcs[j, 9]
        t1[i] = cosine * arcs[j, 4] + sine * arcs[j, 7]
        t2[i] = cosine * arcs[j, 5] + sine * arcs[j, 8]
        t3[i] = cosine * arcs[j, 6] + sine * arcs[j, 9]
        k1[i] = bend * (cosine * arcs[j, 7] - sine * arcs[j, 4])
        k2[i] = bend * (cosine * arcs[j, 8] - sine * arcs[j, 5])
        k3[i] = bend * (cosine * arcs[j, 9] - sine * arcs[j, 6])
        place[i], arc[i] = s, j


@kernel
def _follow_end(rod: Any, i: int, place: int, p: Any) -> None:
    """Move the anchor of an end, and turn with its tangent where the end is held across."""
    hold = rod["anchor"]
    o1, o2, o3 = rod["t1"][i], rod["t2"][i], rod["t3"][i]
    _follow(rod, i, i + 1, p)
    n1, n2, n3 = rod["t1"][i], rod["t2"][i], rod["t3"][i]
    a, b, c = 3 * place, 3 * place + 1, 3 * place + 2
    part = (hold[a] * n1 + hold[b] * n2 + hold[c] * n3) / (1.0 + o1 * n1 + o2 * n2 + o3 * n3)
    hold[a] -= part * (o1 + n1)
    hold[b] -= part * (o2 + n2)
    hold[c] -= part * (o3 + n3)


@kernel
def follow(rod: Any, p: Any) -> None:
    """Move every anchor to the point of the axis nearest to its node."""
    a, b = FIRST, FIRST + p.segments
    _follow_end(rod, a, 0, p)
    _follow_end(rod, b, 1, p)
    _follow(rod, a + 1, b, p)


@kernel
def _beyond_anchor(o: Any, t: Any, k: Any) -> float:
    """Return the distance of the axis's point nearest to a node at o from its anchor; tangent t, curvature k there."""
    distance: float = (t[0] * o[0] + t[1] * o[1] + t[2] * o[2]) / (1.0 - (k[0] * o[0] + k[1] * o[1] + k[2] * o[2]))
    return distance


@kernel
def _at_wall(o: Any, t: Any, k: Any, inverse: float) -> Any:
    """Return the tangent of the axis at a node, and the offset of that from there, in units of 1 / ``inverse``."""
    along = _beyond_anchor(o, t, k)
    half = 0.5 * along
    n1 = inverse * (o[0] - along * (t[0] + half * k[0]))
    n2 = inverse * (o[1] - along * (t[1] + half * k[1]))
    n3 = inverse * (o[2] - along * (t[2] + half * k[2]))
    return t[0] + along * k[0], t[1] + along * k[1], t[2] + along * k[2], n1, n2, n3


@kernel
def _anchored(rod: Any, i: int) -> Any:
    """Return where a node is from its anchor, and tangent and curvature of the axis there."""
    o = rod["x"][i] - rod["c1"][i], rod["y"][i] - rod["c2"][i], rod["z"][i] - rod["c3"][i]
    return o, (rod["t1"][i], rod["t2"][i], rod["t3"][i]), (rod["k1"][i], rod["k2"][i], rod["k3"][i])


@kernel
def _tangent(rod: Any, i: int) -> Any:
    """Return the tangent of the axis at a node."""
    o, t, k = _anchored(rod, i)
    return _at_wall(o, t, k, 1.0)[:3]


@kernel
def _set_axis(rod: Any, i: int, place: int) -> None:
    """Write the tangent of the axis at an end."""
    axis = rod["axis"]
    axis[3 * place], axis[3 * place + 1], axis[3 * place + 2] = _tangent(rod, i)


@kernel
def _along(v1: float, v2: float, v3: float, axis: Any, place: int) -> float:
    """Return the component of a vector along the axis at an end."""
    component: float = v1 * axis[3 * place] + v2 * axis[3 * place + 1] + v3 * axis[3 * place + 2]
    return component


@kernel
def _tool_speed(rod: Any, ways: Any, p: Any) -> float:
    """Return the velocity along ``ways``, the tangents at both nodes beside it, with which the tool does work."""
    i, total = FIRST + p.tool.node, 0.0
    for v, way, next_way in (
        (rod["vx"], ways[0], ways[3]),
        (rod["vy"], ways[1], ways[4]),
        (rod["vz"], ways[2], ways[5]),
    ):
        total += (1.0 - p.tool.beyond) * way * pushed_speed(v, i, p)
        total += p.tool.beyond * next_way * pushed_speed(v, i + 1, p)
    return total


@kernel
def _shake(rod: Any, force: float, ways: Any, p: Any) -> None:
    """Add the force of the tool on inner nodes to the forces on segments."""
    i = FIRST + p.tool.node
    for f, way, next_way in (
        (rod["f1"], ways[0], ways[3]),
        (rod["f2"], ways[1], ways[4]),
        (rod["f3"], ways[2], ways[5]),
    ):
        push_node(f, i, (1.0 - p.tool.beyond) * force * way, p)
        push_node(f, i + 1, p.tool.beyond * force * next_way, p)


@kernel
def _ghost_node(rod: Any, across: int, i: int, inward: int, place: int) -> None:
    """Write the ghost node beyond an end: odd about it, but even across the channel where the end cannot rotate."""
    x, y, z, axis, shift = rod["x"], rod["y"], rod["z"], rod["axis"], rod["shift"]
    if across in (CLAMPED, GUIDED):
        step = _along(x[i + inward] - x[i], y[i + inward] - y[i], z[i + inward] - z[i], axis, place)
        x[i - inward] = x[i + inward] - 2.0 * step * axis[3 * place]
        y[i - inward] = y[i + inward] - 2.0 * step * axis[3 * place + 1]
        z[i - inward] = z[i + inward] - 2.0 * step * axis[3 * place + 2]
    else:
        x[i - inward] = 2.0 * x[i] - x[i + inward] + shift[3 * place]
        y[i - inward] = 2.0 * y[i] - y[i + inward] + shift[3 * place + 1]
        z[i - inward] = 2.0 * z[i] - z[i + inward] + shift[3 * place + 2]


@kernel
def _ghost_directions(rod: Any, across: int, i: int, inward: int, place: int) -> None:
    """Write the ghosts of the directions beyond an end segment."""
    axis = rod["axis"]
    ghost_direction(across, rod["d1"], i, inward, axis[3 * place])
    ghost_direction(across, rod["d2"], i, inward, axis[3 * place + 1])
    ghost_direction(across, rod["d3"], i, inward, axis[3 * place + 2])


@kernel
def _ghost_forces(rod: Any, across: int, i: int, inward: int, place: int, push: float) -> None:
    """Write the ghosts of the forces beyond an end segment, with the force that pushes the end along the axis."""
    f1, f2, f3, axis = rod["f1"], rod["f2"], rod["f3"], rod["axis"]
    fixed = across in (CLAMPED, GUIDED)
    along = _along(f1[i], f2[i], f3[i], axis, place) if fixed else 0.0
    for f, e in ((f1, axis[3 * place]), (f2, axis[3 * place + 1]), (f3, axis[3 * place + 2])):
        ghost_force(fixed, f, i, inward, push * e)
        if fixed:  # even across, odd along
            f[i - inward] += 2.0 * along * e
            f[i - 2 * inward] += 52.0 * along * e


@kernel
def _forces(rod: Any, p: Any) -> None:
    """Write the gradient of the energy by the tangent of every segment, as `rod_motion` does, of a rod bent by nature.

    Of a straight one the natural directions take nothing away.
    """
    d1, d2, d3, inverse, tension = rod["d1"], rod["d2"], rod["d3"], rod["inverse"], rod["tension"]
    f1, f2, f3, b1, b2, b3 = rod["f1"], rod["f2"], rod["f3"], rod["b1"], rod["b2"], rod["b3"]
    bend = p.bend / p.segment
    for i in range(p.segments):
        a, b, c = d1[i + 2], d2[i + 2], d3[i + 2]
        g1 = 2.5 * a - (4.0 / 3.0) * (d1[i + 1] + d1[i + 3]) + (1.0 / 12.0) * (d1[i] + d1[i + 4]) - b1[i + 2]
        g2 = 2.5 * b - (4.0 / 3.0) * (d2[i + 1] + d2[i + 3]) + (1.0 / 12.0) * (d2[i] + d2[i + 4]) - b2[i + 2]
        g3 = 2.5 * c - (4.0 / 3.0) * (d3[i + 1] + d3[i + 3]) + (1.0 / 12.0) * (d3[i] + d3[i + 4]) - b3[i + 2]
        scale = bend * inverse[i + 2]
        along = tension[i + 2] - scale * (g1 * a + g2 * b + g3 * c)
        f1[i + 2], f2[i + 2], f3[i + 2] = along * a + scale * g1, along * b + scale * g2, along * c + scale * g3


@kernel
def frictionless_step(rod: Any, p: Any) -> None:
    """Give the nodes of a frictionless rod their new velocities, and move them."""
    x, y, z, vx, vy, vz, lost = rod["x"], rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"], rod["lost_contact"]
    f1, f2, f3, share = rod["f1"], rod["f2"], rod["f3"], rod["share"]
    c1, c2, c3, t1, t2, t3 = rod["c1"], rod["c2"], rod["c3"], rod["t1"], rod["t2"], rod["t3"]
    k1, k2, k3 = rod["k1"], rod["k2"], rod["k3"]
    step, stiffness, damping = p.step, p.step * p.contact, p.contact_damping
    kick, lighter = p.step / p.mass, p.mass / p.mass_along - 1.0
    fall_1, fall_2, fall_3 = step * p.well.gravity[0], step * p.well.gravity[1], step * p.well.gravity[2]
    fall_along = p.well.weight_along * (lighter + 1.0) - 1.0
    inverse, half_gap = 1.0 / p.radial_clearance, 0.5 * p.radial_clearance
    for i in range(p.segments + 1):
        o = x[i + 2] - c1[i + 2], y[i + 2] - c2[i + 2], z[i + 2] - c3[i + 2]
        t, k = (t1[i + 2], t2[i + 2], t3[i + 2]), (k1[i + 2], k2[i + 2], k3[i + 2])
        e1, e2, e3, n1, n2, n3 = _at_wall(o, t, k, inverse)
        depth = max(half_gap * (n1 * n1 + n2 * n2 + n3 * n3 - 1.0), 0.0)
        root = stiffness * math.sqrt(depth)
        before = vx[i + 2] * n1 + vy[i + 2] * n2 + vz[i + 2] * n3
        push = max(root * (depth + damping * before), 0.0)
        part = kick / share[i + 2]
        g1 = part * (NEAR * (f1[i + 2] - f1[i + 1]) - FAR * (f1[i + 3] - f1[i]))
        g2 = part * (NEAR * (f2[i + 2] - f2[i + 1]) - FAR * (f2[i + 3] - f2[i]))
        g3 = part * (NEAR * (f3[i + 2] - f3[i + 1]) - FAR * (f3[i + 3] - f3[i]))
        more = lighter * (g1 * e1 + g2 * e2 + g3 * e3) + fall_along * (fall_1 * e1 + fall_2 * e2 + fall_3 * e3)
        u = vx[i + 2] + g1 + fall_1 + more * e1 - push * n1
        v = vy[i + 2] + g2 + fall_2 + more * e2 - push * n2
        w = vz[i + 2] + g3 + fall_3 + more * e3 - push * n3
        lost[i + 2] += 0.5 * (push - root * depth) * (before + u * n1 + v * n2 + w * n3)
        vx[i + 2], vy[i + 2], vz[i + 2] = u, v, w
        x[i + 2] += step * u
        y[i + 2] += step * v
        z[i + 2] += step * w


@kernel
def _frictional_step(rod: Any, p: Any) -> None:
    """Give the nodes their new velocities and spins under Coulomb's law, and move them; see `rod_motion`."""
    x, y, z, vx, vy, vz = rod["x"], rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"]
    angle, spin, torque, share, grip = rod["angle"], rod["spin"], rod["torque"], rod["share"], rod["grip"]
    d1, d2, d3, f1, f2, f3 = rod["d1"], rod["d2"], rod["d3"], rod["f1"], rod["f2"], rod["f3"]
    lost, rubbed = rod["lost_contact"], rod["lost_friction"]
    c1, c2, c3, t1, t2, t3 = rod["c1"], rod["c2"], rod["c3"], rod["t1"], rod["t2"], rod["t3"]
    k1, k2, k3 = rod["k1"], rod["k2"], rod["k3"]
    step, stiffness, damping = p.step, p.step * p.contact, p.contact_damping
    kick, turning = p.step / p.mass, p.step / p.inertia
    fall_1, fall_2, fall_3 = step * p.well.gravity[0], step * p.well.gravity[1], step * p.well.gravity[2]
    inverse, gap, radius = 1.0 / p.radial_clearance, p.radial_clearance, p.radius
    lighter = p.mass / p.mass_along
    fall_along = p.well.weight_along * lighter - 1.0
    rolling = p.mass * p.radius / p.inertia
    for i in range(p.segments + 1):
        o = x[i + 2] - c1[i + 2], y[i + 2] - c2[i + 2], z[i + 2] - c3[i + 2]
        t, k = (t1[i + 2], t2[i + 2], t3[i + 2]), (k1[i + 2], k2[i + 2], k3[i + 2])
        e1, e2, e3, n1, n2, n3 = _at_wall(o, t, k, inverse)
        beyond = max(0.5 * (n1 * n1 + n2 * n2 + n3 * n3 - 1.0), 0.0)
        depth = gap * beyond
        root = stiffness * math.sqrt(depth)
        before = vx[i + 2] * n1 + vy[i + 2] * n2 + vz[i + 2] * n3
        push = max(root * (depth + damping * before), 0.0)
        unit = 1.0 - beyond * (1.0 - beyond * (1.5 - 2.5 * beyond))
        a1, a2, a3 = unit * (e2 * n3 - e3 * n2), unit * (e3 * n1 - e1 * n3), unit * (e1 * n2 - e2 * n1)  # around
        h1, h2, h3 = 0.5 * (d1[i + 1] + d1[i + 2]), 0.5 * (d2[i + 1] + d2[i + 2]), 0.5 * (d3[i + 1] + d3[i + 2])
        roll_x, roll_t = -(h1 * a1 + h2 * a2 + h3 * a3), h1 * e1 + h2 * e2 + h3 * e3
        surface = radius * spin[i + 2]
        old_x = vx[i + 2] * e1 + vy[i + 2] * e2 + vz[i + 2] * e3 + surface * roll_x
        old_t = vx[i + 2] * a1 + vy[i + 2] * a2 + vz[i + 2] * a3 + surface * roll_t
        one_over = 1.0 / share[i + 2]
        part = kick * one_over
        g1 = part * (NEAR * (f1[i + 2] - f1[i + 1]) - FAR * (f1[i + 3] - f1[i]))
        g2 = part * (NEAR * (f2[i + 2] - f2[i + 1]) - FAR * (f2[i + 3] - f2[i]))
        g3 = part * (NEAR * (f3[i + 2] - f3[i + 1]) - FAR * (f3[i + 3] - f3[i]))
        more = (lighter - 1.0) * (g1 * e1 + g2 * e2 + g3 * e3)
        more += fall_along * (fall_1 * e1 + fall_2 * e2 + fall_3 * e3)
        u = vx[i + 2] + g1 + fall_1 + more * e1 - push * n1
        v = vy[i + 2] + g2 + fall_2 + more * e2 - push * n2
        w = vz[i + 2] + g3 + fall_3 + more * e3 - push * n3
        turn = spin[i + 2] + turning * one_over * (torque[i + 2] - torque[i + 1])
        lost[i + 2] += 0.5 * (push - root * depth) * (before + u * n1 + v * n2 + w * n3)
        free_x = u * e1 + v * e2 + w * e3 + radius * turn * roll_x
        free_t = u * a1 + v * a2 + w * a3 + radius * turn * roll_t
        limit = grip[i + 2] * push * (1.0 + beyond)
        px, pt, new_x, new_t = rub(free_x, free_t, roll_x, roll_t, limit, lighter, rolling * radius)
        rubbed[i + 2] -= 0.5 * (px * (old_x + new_x) + pt * (old_t + new_t))
        u, v, w = u + lighter * px * e1 + pt * a1, v + lighter * px * e2 + pt * a2, w + lighter * px * e3 + pt * a3
        turn += rolling * (px * roll_x + pt * roll_t)
        vx[i + 2], vy[i + 2], vz[i + 2], spin[i + 2] = u, v, w, turn
        x[i + 2] += step * u
        y[i + 2] += step * v
        z[i + 2] += step * w
        angle[i + 2] += step * turn


@kernel
def _most_friction(rod: Any, i: int, p: Any) -> float:
    """Return the impulse per mass by which friction can hold an end node in the coming step: mu times the wall's."""
    o, t, k = _anchored(rod, i)
    _, _, _, n1, n2, n3 = _at_wall(o, t, k, 1.0 / p.radial_clearance)
    beyond = max(0.5 * (n1 * n1 + n2 * n2 + n3 * n3 - 1.0), 0.0)
    depth = p.radial_clearance * beyond
    before = rod["vx"][i] * n1 + rod["vy"][i] * n2 + rod["vz"][i] * n3
    push = p.step * p.contact * math.sqrt(depth) * (depth + p.contact_damping * before)
    limit: float = grip_at(rod["place"][i] + _beyond_anchor(o, t, k), p) * max(push, 0.0) * (1.0 + beyond)
    return limit


@kernel
def _brake_end(rod: Any, end: Any, i: int, place: int, push: float, limit: float, before: Any, p: Any) -> None:
    """Give an end that is held across the channel, or moved along it, the impulse of its share of the friction.

    See `rod_motion`; here ``before`` is the velocity as three components.
    """
    held = end.across in (HINGED, CLAMPED)
    if not (held or end.moved):
        return
    x, y, z, vx, vy, vz, axis = rod["x"], rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"], rod["axis"]
    lighter = p.mass / p.mass_along
    e1, e2, e3 = axis[3 * place], axis[3 * place + 1], axis[3 * place + 2]
    o, t, k = _anchored(rod, i)
    _, _, _, n1, n2, n3 = _at_wall(o, t, k, 1.0 / p.radial_clearance)
    unit = 1.0 / (math.sqrt(n1 * n1 + n2 * n2 + n3 * n3) + TINY)
    a1, a2, a3 = unit * (e2 * n3 - e3 * n2), unit * (e3 * n1 - e1 * n3), unit * (e1 * n2 - e2 * n1)
    around = 0.0 if held else vx[i] * a1 + vy[i] * a2 + vz[i] * a3
    if end.moved:
        along = push * end.speed
        part = limit / (math.sqrt(along * along + around * around) + TINY)
        px, pt = -part * along, -min(part, 1.0) * around
    else:
        speed = _along(vx[i], vy[i], vz[i], axis, place)
        px, pt = -min(max(speed / lighter, -limit), limit), 0.0
        along = speed + lighter * px
    first = before[0] * e1 + before[1] * e2 + before[2] * e3
    slipped = px * (first + along) + pt * (before[0] * a1 + before[1] * a2 + before[2] * a3 + around + pt)
    rod["lost_friction"][i] -= 0.5 * slipped
    u, v, w = lighter * px * e1 + pt * a1, lighter * px * e2 + pt * a2, lighter * px * e3 + pt * a3
    vx[i], vy[i], vz[i] = vx[i] + u, vy[i] + v, vz[i] + w
    x[i] += p.step * u
    y[i] += p.step * v
    z[i] += p.step * w


@kernel
def _hold_end(rod: Any, end: Any, i: int, place: int, push: float, before: float, p: Any) -> None:
    """Return an end that is held to where it is held; ``push`` is the sign of the direction in which it is pushed.

    ``before`` is its velocity along the channel before the step.  An end held across slides along the curve that its
    offset from the axis describes, which does not wind about the axis.
    """
    x, y, z, vx, vy, vz = rod["x"], rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"]
    axis, hold = rod["axis"], rod["anchor"]
    if end.across in (CLAMPED, GUIDED):
        rod["spin"][i] = rod["angle"][i] = 0.0
    if end.moved:
        e1, e2, e3 = axis[3 * place], axis[3 * place + 1], axis[3 * place + 2]
        speed = push * end.speed
        change = speed - _along(vx[i], vy[i], vz[i], axis, place)
        impulse = p.mass_along * rod["share"][i] * change
        vx[i], vy[i], vz[i] = vx[i] + change * e1, vy[i] + change * e2, vz[i] + change * e3
        x[i] += p.step * change * e1
        y[i] += p.step * change * e2
        z[i] += p.step * change * e3
        rod["impulse"][place] += push * impulse
        rod["work"][0] += 0.5 * impulse * (before + speed)
    if end.across in (HINGED, CLAMPED):
        t1, t2, t3, k1, k2, k3 = rod["t1"][i], rod["t2"][i], rod["t3"][i], rod["k1"][i], rod["k2"][i], rod["k3"][i]
        c1, c2, c3 = (
            rod["c1"][i] + hold[3 * place],
            rod["c2"][i] + hold[3 * place + 1],
            rod["c3"][i] + hold[3 * place + 2],
        )
        room = 1.0 - (k1 * hold[3 * place] + k2 * hold[3 * place + 1] + k3 * hold[3 * place + 2])
        along = (t1 * (x[i] - c1) + t2 * (y[i] - c2) + t3 * (z[i] - c3)) / room
        half, run = 0.5 * along, room * along
        x[i], y[i], z[i] = c1 + run * (t1 + half * k1), c2 + run * (t2 + half * k2), c3 + run * (t3 + half * k3)
        e1, e2, e3 = t1 + along * k1, t2 + along * k2, t3 + along * k3
        speed = (vx[i] * e1 + vy[i] * e2 + vz[i] * e3) / (e1 * e1 + e2 * e2 + e3 * e3)
        vx[i], vy[i], vz[i] = speed * e1, speed * e2, speed * e3


@kernel
def _decay(rod: Any, p: Any) -> None:
    """Damp every velocity for half a step, but that of an end that is moved, and add up the energy lost."""
    vx, vy, vz, spin, lost = rod["vx"], rod["vy"], rod["vz"], rod["spin"], rod["lost_damping"]
    t1, t2, t3 = rod["t1"], rod["t2"], rod["t3"]
    factor, along = p.decay, p.decay_along
    heavier, turning = p.mass_along / p.mass, p.inertia / p.mass
    first, last = 1 if p.upper.moved else 0, p.segments - (1 if p.lower.moved else 0)
    for i in range(p.segments + 1):
        keep = along if first <= i <= last else 1.0
        speed = vx[i + 2] * t1[i + 2] + vy[i + 2] * t2[i + 2] + vz[i + 2] * t3[i + 2]
        square = (
            vx[i + 2] * vx[i + 2]
            + vy[i + 2] * vy[i + 2]
            + vz[i + 2] * vz[i + 2]
            - speed * speed
            + turning * spin[i + 2] * spin[i + 2]
        )
        lost[i + 2] += 0.5 * (1.0 - factor * factor) * square + 0.5 * heavier * (1.0 - keep * keep) * speed * speed
        more = (keep - factor) * speed
        vx[i + 2] = factor * vx[i + 2] + more * t1[i + 2]
        vy[i + 2] = factor * vy[i + 2] + more * t2[i + 2]
        vz[i + 2] = factor * vz[i + 2] + more * t3[i + 2]
        spin[i + 2] *= factor


@kernel
def gradient(rod: Any, p: Any, upper: float, lower: float) -> None:
    """Write the forces of the rod on its segments, with ghost cells, under forces that push its ends."""
    a, b = FIRST, FIRST + p.segments
    _set_axis(rod, a, 0)
    _set_axis(rod, b, 1)
    _ghost_node(rod, p.upper.across, a, 1, 0)
    _ghost_node(rod, p.lower.across, b, -1, 1)
    if p.friction > 0.0:
        directions(rod, True, p)
        rod["torque"][a - 1] = rod["torque"][b] = 0.0
    else:
        directions(rod, False, p)
    _ghost_directions(rod, p.upper.across, a, 1, 0)
    _ghost_directions(rod, p.lower.across, b - 1, -1, 1)
    _forces(rod, p)
    _ghost_forces(rod, p.upper.across, a, 1, 0, upper)
    _ghost_forces(rod, p.lower.across, b - 1, -1, 1, lower)


@kernel
def advance(rod: Any, steps: int, p: Any) -> None:
    """Carry a rod whose positions are half a step ahead through ``steps`` steps, and count them on its clock."""
    a, b, vx, vy, vz, axis = FIRST, FIRST + p.segments, rod["vx"], rod["vy"], rod["vz"], rod["axis"]
    damped = p.decay != 1.0 or p.decay_along != 1.0
    done = int(rod["clock"][0])
    for number in range(done, done + steps):
        if number % BETWEEN_ANCHORS == 0:
            follow(rod, p)
            if len(p.grips) > 1:
                set_grips(rod, rod["place"], p)
        force = vibration(rod, (number + 0.5) * p.step, p)
        upper = 0.0 if p.upper.moved else p.upper.mean + p.upper.drive * force
        lower = 0.0 if p.lower.moved else p.lower.mean + p.lower.drive * force
        if damped:
            _decay(rod, p)
        first, last = (vx[a], vy[a], vz[a]), (vx[b], vy[b], vz[b])
        shaking = tool_force((number + 0.5) * p.step, p)
        on_upper, on_lower = on_ends(shaking, p)
        ways = _tangent(rod, a + p.tool.node) + _tangent(rod, a + p.tool.node + 1)
        tool_before = _tool_speed(rod, ways, p)
        gradient(rod, p, upper + on_upper, lower + on_lower)
        if shaking != 0.0:
            _shake(rod, shaking, ways, p)
        first_before = _along(first[0], first[1], first[2], axis, 0)
        last_before = _along(last[0], last[1], last[2], axis, 1)
        if p.friction > 0.0:
            first_limit, last_limit = _most_friction(rod, a, p), _most_friction(rod, b, p)
            _frictional_step(rod, p)
            _brake_end(rod, p.upper, a, 0, 1.0, first_limit, first, p)
            _brake_end(rod, p.lower, b, 1, -1.0, last_limit, last, p)
        else:
            frictionless_step(rod, p)
        first_after = _along(vx[a], vy[a], vz[a], axis, 0)
        last_after = _along(vx[b], vy[b], vz[b], axis, 1)
        rod["work"][0] += 0.5 * p.step * (upper * (first_before + first_after) - lower * (last_before + last_after))
        rod["impulse"][0] += p.step * upper
        rod["impulse"][1] += p.step * lower
        _hold_end(rod, p.upper, a, 0, 1.0, first_before, p)
        _hold_end(rod, p.lower, b, 1, -1.0, last_before, p)
        if shaking != 0.0:
            rod["work"][0] += 0.5 * p.step * shaking * (tool_before + _tool_speed(rod, ways, p))
        if damped:
            _decay(rod, p)
    rod["clock"][0] = done + steps
