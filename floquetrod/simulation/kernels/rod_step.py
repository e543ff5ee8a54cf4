"""Kernels for the simulated rod: one fused, explicit, reversible loop over the nodes and segments of one rod.

The rod is n segments of unstrained length l between n + 1 nodes.  Nodes carry position, velocity, and the spin of the
rod about its own axis.  With x_i the position of node i,

    t_i = (27 (x_i+1 - x_i) - (x_i+2 - x_i-1)) / 24        tangent of segment i times l
    d_i = t_i / |t_i|                                      its direction
    K_i = d_i - d_i-1                                      curvature at node i times l

each of fourth order, the elastic energy is

    sum over segments (EA / (2 l)) (|t| - l)^2  +  sum over segments (GJ / (2 l)) (psi_i+1 - psi_i)^2
  + (EI / (2 l)) [sum over nodes |K_i|^2  +  (1 / 12) sum over segments |K_i+1 - K_i|^2]

with psi the angle of spin, and forces and torques are its exact gradient, so that without contact nothing but rounding
makes energy drift.  Beyond the ends nodes and directions are extrapolated as the ends' conditions say, by which
the order holds up to the ends; only the error of the stretch is of the third at an end that is pushed.

In a well the same rod lies in a tube about a curved axis, positions and velocities being Cartesian: what differs is
where a node's wall is and which way is along the channel, which `anchors` tells.  ``well`` is `Physics.well`, None in a
straight channel: numba compiles one branch alone of an `if` on whether an argument is None.  A
rod of natural curvature is bent by the difference of its directions from its natural shape's, which stay where
the rod was laid; ghost cells and stencil being linear, that subtracts a constant from the stencil of every segment.

A rod that varies along has its numbers at nodes and segments in the record, `SECTIONS`, and the radius of its channel
in ``wall``, `Physics.wall`, which is None for a uniform rod.  With B_i the bending stiffness of node i and E_i that of
segment i the energy of bending is

    (1 / (2 l)) [sum over nodes B_i |K_i|^2  +  (1 / 12) sum over segments |B_i+1 K_i+1 - B_i K_i|^2 / E_i] ,

see `floquetrod.simulation.lumping`.

Positions are kept half a step ahead of velocities (position Verlet with its half drifts merged), so the result does not
depend on how a run is divided into calls.  Loops touch few arrays each, so that compilers vectorise them.
"""

from __future__ import annotations

import math
from typing import Any

from floquetrod._util.compilation import kernel
from floquetrod.simulation.kernels.well_anchors import beside, cross, dot, follow, from_axis, hold_beside, pushed
from floquetrod.simulation.rod_record import CLAMPED, FIRST, GUIDED, HINGED

BETWEEN_ANCHORS = 16
"""Steps after which nodes take the friction, and in a well the anchor, of where they are (a choice: at 10 m/s a node
moves by half a millimetre in so many)."""

TINY = 1e-300  # keeps 0 / 0 out of quotients whose value is not used
NEAR, FAR = 27.0 / 24.0, 1.0 / 24.0

# Of a clamped end, where K_0 = 2 (d_0 - e): the energy of its last nodes, A_00 K_0^2 + 2 A_01 K_0 K_1 + A_11 K_1^2 and
# so on in place of the bulk's, integrates the square of the curvature to fourth order (docs/theory/simulator.md).
_END = 4355.0 / 31212.0  # -A_01, and what A_11 has more than 1 + 1/12
_FIRST_END = 19961.0 / 31212.0  # A_00


def energy_of_clamped_end(first: float, both: float, next_one: float) -> float:
    """Return the squares by which a clamped end stores bending: of K_0, K_0 K_1 and K_1, as the bulk's."""
    return _FIRST_END * first - 2.0 * _END * both + _END * next_one


@kernel
def _vibration(rod: Any, time: float, frequency: float, harmonics: int) -> float:
    """Return the part of the force that vibrates, in N."""
    cosines, sines, force = rod["cosines"], rod["sines"], 0.0
    for k in range(harmonics):
        phase = (k + 1) * frequency * time
        force += cosines[k] * math.cos(phase) + sines[k] * math.sin(phase)
    return force


@kernel
def grip_at(place: float, p: Any) -> float:
    """Return the coefficient of friction at a place along the channel."""
    j = 0
    while j + 1 < len(p.grips) and place >= p.grips[j + 1, 0]:
        j += 1
    coefficient: float = p.grips[j, 1]
    return coefficient


@kernel
def _take_walls(rod: Any, wall: Any, places: Any, segments: int) -> None:
    """Give nodes the radial clearance of where they are, how fast it grows down the channel, and the place."""
    corners, gap, taper, mark, outer = wall.corners, rod["gap"], rod["taper"], rod["mark"], rod["outer"]
    j = 0
    for i in range(FIRST, FIRST + segments + 1):
        place = places[i]
        while j + 1 < len(corners) and place >= corners[j + 1, 0]:
            j += 1
        while j > 0 and place < corners[j, 0]:
            j -= 1
        taper[i], mark[i] = corners[j, 2], place
        gap[i] = corners[j, 1] + taper[i] * (place - corners[j, 0]) - outer[i]


@kernel
def _take_places(rod: Any, well: Any, wall: Any, p: Any) -> None:
    """Give nodes the anchors of where they are, and the friction except at ends whose share is taken apart."""
    if well is None:
        places = rod["x"]
    else:
        follow(rod, p)
        places = rod["place"]
    if wall is not None:
        _take_walls(rod, wall, places, p.segments)
    if len(p.grips) > 1:
        grip = rod["grip"]
        first = 1 if p.upper.moved or p.upper.across in (HINGED, CLAMPED) else 0
        last = p.segments - (1 if p.lower.moved or p.lower.across in (HINGED, CLAMPED) else 0)
        for i in range(first, last + 1):
            grip[i + 2] = grip_at(places[i + 2], p)


@kernel
def _beside(rod: Any, well: Any, i: int) -> Any:
    """Return the place of a node along the channel, the tangent of the channel there, and the offset from its axis."""
    if well is None:
        return rod["x"][i], (1.0, 0.0, 0.0), (0.0, rod["y"][i], rod["z"][i])
    return beside(rod, i)


@kernel
def _tool_force(tool: Any, time: float, segments: int) -> Any:
    """Return the force in N with which the tool pushes the rod down, and what the upper and lower end receive of it.

    The latter in the direction of a push.
    """
    if tool.node < 0:
        return 0.0, 0.0, 0.0
    force = tool.amplitude * math.sin(tool.frequency * time)
    force += tool.second_amplitude * math.sin(tool.second_frequency * time + tool.phase)
    upper = (1.0 - tool.beyond) * force if tool.node == 0 else 0.0
    lower = -tool.beyond * force if tool.node + 1 == segments else 0.0
    return force, upper, lower


@kernel
def _tool_ways(rod: Any, well: Any, tool: Any) -> Any:
    """Return the tangents of the channel at the nodes above and below the tool."""
    if tool.node < 0:
        return (1.0, 0.0, 0.0), (1.0, 0.0, 0.0)
    return _beside(rod, well, FIRST + tool.node)[1], _beside(rod, well, FIRST + tool.node + 1)[1]


@kernel
def _push_node(f: Any, i: int, force: float, last: int) -> None:
    """Add a force on the inner node ``i`` to the forces on segments: by their stencil a step passes it on."""
    if force != 0.0 and FIRST < i < last:
        for j in range(i, last + 2):
            f[j] += force


@kernel
def _pushed_speed(v: Any, i: int, last: int) -> float:
    """Return the velocity with which a force on node ``i`` does work: of the nodes that it is passed on to."""
    speed: float = v[i]
    if FIRST < i < last:
        speed += FAR * (2.0 * v[i] - v[i - 1] - v[i + 1])
    return speed


@kernel
def _tool_speed(rod: Any, ways: Any, tool: Any, last: int) -> float:
    """Return the velocity with which the tool does work, along the tangents at the nodes above and below it."""
    total = 0.0
    if tool.node >= 0:
        i, (above, below) = FIRST + tool.node, ways
        for v, k in ((rod["vx"], 0), (rod["vy"], 1), (rod["vz"], 2)):
            total += (1.0 - tool.beyond) * above[k] * _pushed_speed(v, i, last)
            total += tool.beyond * below[k] * _pushed_speed(v, i + 1, last)
    return total


@kernel
def _shake(rod: Any, force: float, ways: Any, tool: Any, last: int) -> None:
    """Add the force of the tool on inner nodes to the forces on segments."""
    if tool.node >= 0:
        i, (above, below) = FIRST + tool.node, ways
        for f, k in ((rod["f1"], 0), (rod["f2"], 1), (rod["f3"], 2)):
            _push_node(f, i, (1.0 - tool.beyond) * force * above[k], last)
            _push_node(f, i + 1, tool.beyond * force * below[k], last)


@kernel
def _ghost_node(v: Any, i: int, place: int, fixed: bool, back: float) -> None:
    """Write the ghost of a coordinate of the nodes beyond the end node ``i``, odd about it or ``back`` from inside."""
    inner = v[i + 1 - 2 * place]
    v[i - 1 + 2 * place] = inner - back if fixed else 2.0 * v[i] - inner


@kernel
def _ghost_nodes(rod: Any, well: Any, across: int, axis: Any, i: int, place: int) -> None:
    """Write the ghost node beyond an end: odd about it, but even across the channel where the end cannot rotate."""
    x, y, z, inner = rod["x"], rod["y"], rod["z"], i + 1 - 2 * place
    fixed = across in (CLAMPED, GUIDED)
    twice = 2.0 * dot((x[inner] - x[i], y[inner] - y[i], z[inner] - z[i]), axis) if fixed else 0.0
    _ghost_node(x, i, place, fixed, twice * axis[0])
    _ghost_node(y, i, place, fixed, twice * axis[1])
    _ghost_node(z, i, place, fixed, twice * axis[2])
    if well is not None and not fixed:
        shift, outer = rod["shift"], i - 1 + 2 * place
        x[outer] += shift[3 * place]
        y[outer] += shift[3 * place + 1]
        z[outer] += shift[3 * place + 2]


@kernel
def ghost_direction(condition: int, d: Any, a: int, inward: int, axis: float) -> None:
    """Write both ghosts of a component of the directions beyond the end segment ``a``.

    With these ghosts the stencil of the bulk gives the gradient of the energy up to the end.  ``axis`` is this
    component of the channel's direction.
    """
    d0, d1 = d[a], d[a + inward]
    if condition == GUIDED:
        one, two = 2.0 * axis - d0, 2.0 * axis - d1
    elif condition == CLAMPED:
        d2 = d[a + 2 * inward]
        one = (12.0 * _END - 1.0) * d1 + (2.0 - 36.0 * _END) * d0 + 24.0 * _END * axis
        bent, straight = d1 - d0, 2.0 * (d0 - axis)
        moment_0 = _FIRST_END * straight - _END * bent
        moment_1 = (1.0 + 1.0 / 12.0 + _END) * bent - _END * straight - (d2 - d1) / 12.0
        two = 12.0 * (2.0 * moment_0 - moment_1 - 2.5 * d0 + 4.0 / 3.0 * (one + d1)) - d2
    else:
        one, two = d0, d1
    d[a - inward], d[a - 2 * inward] = one, two


@kernel
def _ghost_directions(rod: Any, across: int, axis: Any, a: int, place: int) -> None:
    """Write the ghosts of the directions beyond the end segment ``a``."""
    inward = 1 - 2 * place
    ghost_direction(across, rod["d1"], a, inward, axis[0])
    ghost_direction(across, rod["d2"], a, inward, axis[1])
    ghost_direction(across, rod["d3"], a, inward, axis[2])


@kernel
def _ghost_force(f: Any, a: int, inward: int, fixed: bool, along: float, push: float) -> None:
    """Write both ghosts of a component of the forces beyond the end segment ``a``, with a push on the end node.

    They pass on to the end nodes what the ghost node would receive, which is odd about the end; where that is fixed its
    part ``along`` the channel alone is, and that across is even.
    """
    odd = along if fixed else f[a]
    even = f[a] - odd
    f[a - inward], f[a - 2 * inward] = odd - even, 25.0 * odd - 27.0 * even + 24.0 * push


@kernel
def _ghost_forces(rod: Any, across: int, axis: Any, a: int, place: int, push: float) -> None:
    """Write the ghosts of the forces beyond the end segment ``a``, with the force that pushes the end along."""
    f1, f2, f3, inward = rod["f1"], rod["f2"], rod["f3"], 1 - 2 * place
    fixed = across in (CLAMPED, GUIDED)
    along = dot((f1[a], f2[a], f3[a]), axis) if fixed else 0.0
    _ghost_force(f1, a, inward, fixed, along * axis[0], push * axis[0])
    _ghost_force(f2, a, inward, fixed, along * axis[1], push * axis[1])
    _ghost_force(f3, a, inward, fixed, along * axis[2], push * axis[2])


@kernel
def _directions(rod: Any, wall: Any, p: Any) -> None:
    """Write direction, length and tension of every segment."""
    x, y, z = rod["x"], rod["y"], rod["z"]
    d1, d2, d3, inverse, tension = rod["d1"], rod["d2"], rod["d3"], rod["inverse"], rod["tension"]
    stretch, rest = p.stretch / p.segment, p.stretch
    if wall is not None:
        stretches = rod["stretch"]
    for i in range(p.segments):
        if wall is not None:
            stretch, rest = stretches[i + 2], stretches[i + 2] * p.segment
        t1 = NEAR * (x[i + 3] - x[i + 2]) - FAR * (x[i + 4] - x[i + 1])
        t2 = NEAR * (y[i + 3] - y[i + 2]) - FAR * (y[i + 4] - y[i + 1])
        t3 = NEAR * (z[i + 3] - z[i + 2]) - FAR * (z[i + 4] - z[i + 1])
        length = math.sqrt(t1 * t1 + t2 * t2 + t3 * t3)
        one_over = 1.0 / length
        d1[i + 2], d2[i + 2], d3[i + 2] = one_over * t1, one_over * t2, one_over * t3
        inverse[i + 2], tension[i + 2] = one_over, stretch * length - rest


@kernel
def _torques(rod: Any, wall: Any, p: Any) -> None:
    """Write the torque of every segment, and none beyond the ends."""
    angle, torque, twist = rod["angle"], rod["torque"], p.twist / p.segment
    if wall is not None:
        twists = rod["twist"]
    for i in range(p.segments):
        if wall is not None:
            twist = twists[i + 2]
        torque[i + 2] = twist * (angle[i + 3] - angle[i + 2])
    torque[FIRST - 1] = torque[FIRST + p.segments] = 0.0


@kernel
def _forces(rod: Any, well: Any, wall: Any, p: Any) -> None:
    """Write the gradient of the energy by the tangent of every segment."""
    d1, d2, d3, inverse, tension = rod["d1"], rod["d2"], rod["d3"], rod["inverse"], rod["tension"]
    f1, f2, f3 = rod["f1"], rod["f2"], rod["f3"]
    if well is not None:
        b1, b2, b3 = rod["b1"], rod["b2"], rod["b3"]
    if wall is not None:
        own, next_one, second = rod["bend"], rod["bend_next"], rod["bend_second"]
    bend = p.bend / p.segment
    for i in range(p.segments):
        a, b, c = d1[i + 2], d2[i + 2], d3[i + 2]
        if wall is None:
            g1 = 2.5 * a - (4.0 / 3.0) * (d1[i + 1] + d1[i + 3]) + (1.0 / 12.0) * (d1[i] + d1[i + 4])
            g2 = 2.5 * b - (4.0 / 3.0) * (d2[i + 1] + d2[i + 3]) + (1.0 / 12.0) * (d2[i] + d2[i + 4])
            g3 = 2.5 * c - (4.0 / 3.0) * (d3[i + 1] + d3[i + 3]) + (1.0 / 12.0) * (d3[i] + d3[i + 4])
        else:
            k0, k1, k2, k3, k4 = second[i], next_one[i + 1], own[i + 2], next_one[i + 2], second[i + 2]
            g1 = k2 * a + k1 * d1[i + 1] + k3 * d1[i + 3] + k0 * d1[i] + k4 * d1[i + 4]
            g2 = k2 * b + k1 * d2[i + 1] + k3 * d2[i + 3] + k0 * d2[i] + k4 * d2[i + 4]
            g3 = k2 * c + k1 * d3[i + 1] + k3 * d3[i + 3] + k0 * d3[i] + k4 * d3[i + 4]
        if well is not None:
            g1, g2, g3 = g1 - b1[i + 2], g2 - b2[i + 2], g3 - b3[i + 2]
        scale = bend * inverse[i + 2] if wall is None else inverse[i + 2]
        along = tension[i + 2] - scale * (g1 * a + g2 * b + g3 * c)
        f1[i + 2], f2[i + 2], f3[i + 2] = along * a + scale * g1, along * b + scale * g2, along * c + scale * g3


@kernel
def rub(
    free_x: float, free_t: float, roll_x: float, roll_t: float, limit: float, lighter: float, by_spin: float
) -> Any:
    """Return the impulse of friction along and around, and the speed of the surface after it.

    Coulomb's law, static = kinetic: the impulse that would stop the surface, which else moves at ``free``; where that
    exceeds ``limit`` the surface slips, and the impulse opposes its slip.  Impulses are per mass in motion across.
    """
    # How an impulse changes the speed of the surface.
    a, b, c = lighter + by_spin * roll_x * roll_x, by_spin * roll_x * roll_t, 1.0 + by_spin * roll_t * roll_t
    determinant = a * c - b * b
    opposed_x, opposed_t = c * free_x - b * free_t, a * free_t - b * free_x
    share_x, share_t = opposed_x / determinant, opposed_t / determinant
    # Fast slip is opposed along its own direction, slip that is about to stop along the impulse that stops it;
    # between the two the direction changes smoothly.
    square, squared_limit = free_x * free_x + free_t * free_t, limit * limit
    weight = 3.0 * c * squared_limit
    slip_x, slip_t = free_x * square + weight * opposed_x, free_t * square + weight * opposed_t
    scale = limit / (math.sqrt(slip_x * slip_x + slip_t * slip_t) + TINY)
    sticks = share_x * share_x + share_t * share_t <= squared_limit
    px = -share_x if sticks else -scale * slip_x
    pt = -share_t if sticks else -scale * slip_t
    return px, pt, free_x + a * px + b * pt, free_t + b * px + c * pt


@kernel
def move_nodes(rod: Any, well: Any, wall: Any, friction: Any, p: Any) -> None:
    """Give the nodes their new velocities, and move them; their new spins, too, under Coulomb's law, see `rub`.

    ``friction`` is None without.
    The indentation is taken as d = (q^2 - R^2) / (2 R) with q the distance from the axis, which is the distance beyond
    R except for a relative d / (2 R): its gradient q / R costs neither a root nor a quotient.  Where R changes down the
    channel, the wall pushes along it by the same energy, of which (q^2 / R^2 + 1) / 2 is the part of R.
    """
    x, y, z, vx, vy, vz = rod["x"], rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"]
    f1, f2, f3, share, lost = rod["f1"], rod["f2"], rod["f3"], rod["share"], rod["lost_contact"]
    time, stiffness, damping = p.step, p.step * p.contact, p.contact_damping
    across, along, inverse, gap = p.step / p.mass, p.step / p.mass_along, 1.0 / p.radial_clearance, p.radial_clearance
    lighter = p.mass / p.mass_along  # speed along that an impulse gives, over that across
    if friction is not None:
        angle, spin, torque, grip, rubbed = rod["angle"], rod["spin"], rod["torque"], rod["grip"], rod["lost_friction"]
        d1, d2, d3, radius, turning = rod["d1"], rod["d2"], rod["d3"], p.radius, p.step / p.inertia
        rolling = p.mass * radius / p.inertia  # spin that an impulse gives
    if well is None:
        fall, slide = p.step * p.gravity, p.step * p.gravity_along
    else:
        c1, c2, c3, t1, t2, t3 = rod["c1"], rod["c2"], rod["c3"], rod["t1"], rod["t2"], rod["t3"]
        k1, k2, k3, weight = rod["k1"], rod["k2"], rod["k3"], well.gravity
        falls, fall_along = (time * weight[0], time * weight[1], time * weight[2]), well.weight_along * lighter - 1.0
    if wall is not None:
        masses, masses_along, gaps, tapers, marks = (
            rod["mass"],
            rod["mass_along"],
            rod["gap"],
            rod["taper"],
            rod["mark"],
        )
        contacts, contact_times, gravity, gravity_along = (
            rod["contact"],
            rod["contact_time"],
            rod["gravity"],
            rod["gravity_along"],
        )
        outer, inertia = rod["outer"], rod["inertia"]
    for i in range(p.segments + 1):
        if wall is not None:
            mass, place = masses[i + 2], x[i + 2] if well is None else beside(rod, i + 2)[0]
            across, along, lighter = time / mass, time / masses_along[i + 2], mass / masses_along[i + 2]
            stiffness, damping = time * contacts[i + 2], contact_times[i + 2]
            gap = gaps[i + 2] + tapers[i + 2] * (place - marks[i + 2])
            inverse = 1.0 / gap
            if well is None:
                fall, slide = time * gravity[i + 2], time * gravity_along[i + 2]
            else:
                down = time * gravity[i + 2]
                falls, fall_along = (
                    (down * weight[0], down * weight[1], down * weight[2]),
                    well.weight_along * lighter - 1.0,
                )
            if friction is not None:
                radius, turning, rolling = (
                    outer[i + 2],
                    time / inertia[i + 2],
                    mass * outer[i + 2] / inertia[i + 2],
                )
        if well is None:
            n2, n3 = inverse * y[i + 2], inverse * z[i + 2]
            square, before = n2 * n2 + n3 * n3, vy[i + 2] * n2 + vz[i + 2] * n3
        else:
            o = x[i + 2] - c1[i + 2], y[i + 2] - c2[i + 2], z[i + 2] - c3[i + 2]
            t, k = (t1[i + 2], t2[i + 2], t3[i + 2]), (k1[i + 2], k2[i + 2], k3[i + 2])
            _, e, n = from_axis(o, t, k, inverse)
            old = vx[i + 2], vy[i + 2], vz[i + 2]
            square, before = dot(n, n), dot(old, n)
        beyond = max(0.5 * (square - 1.0), 0.0)
        depth = gap * beyond
        root = stiffness * math.sqrt(depth)
        push = max(root * (depth + damping * before), 0.0)
        one_over = 1.0 / share[i + 2]
        kick = across * one_over
        g1 = NEAR * (f1[i + 2] - f1[i + 1]) - FAR * (f1[i + 3] - f1[i])
        g2 = NEAR * (f2[i + 2] - f2[i + 1]) - FAR * (f2[i + 3] - f2[i])
        g3 = NEAR * (f3[i + 2] - f3[i + 1]) - FAR * (f3[i + 3] - f3[i])
        if well is None:
            u = vx[i + 2] + along * one_over * g1 + slide
            v = vy[i + 2] + kick * g2 - push * n2
            w = vz[i + 2] + kick * g3 - push * n3 - fall
            twice = before + v * n2 + w * n3
        else:
            u, v, w = pushed(old, (kick * g1, kick * g2, kick * g3), e, n, falls, push, lighter, fall_along)
            twice = before + dot((u, v, w), n)
        if wall is not None:
            out = lighter * root * depth * 0.5 * (square + 1.0) * tapers[i + 2]
            if well is None:
                u += out
            else:
                u, v, w = u + out * e[0], v + out * e[1], w + out * e[2]
        lost[i + 2] += 0.5 * (push - root * depth) * twice
        if friction is not None:
            unit = 1.0 - beyond * (1.0 - beyond * (1.5 - 2.5 * beyond))  # 1 / sqrt(1 + 2 beyond): R / distance
            s1, s2, s3 = d1[i + 1] + d1[i + 2], d2[i + 1] + d2[i + 2], d3[i + 1] + d3[i + 2]
            turn = spin[i + 2] + turning * one_over * (torque[i + 2] - torque[i + 1])
            # Around the channel is a; the surface moves along and around with the spin, by roll.
            if well is None:
                a2, a3 = -unit * n3, unit * n2
                roll_x, roll_t = -0.5 * (s2 * a2 + s3 * a3), 0.5 * s1
                old_x, old_t = vx[i + 2], vy[i + 2] * a2 + vz[i + 2] * a3
                free_x, free_t = u, v * a2 + w * a3
            else:
                a = cross(e, n, unit)
                roll_x, roll_t = -0.5 * dot((s1, s2, s3), a), 0.5 * dot((s1, s2, s3), e)
                old_x, old_t = dot(old, e), dot(old, a)
                free_x, free_t = dot((u, v, w), e), dot((u, v, w), a)
            old_x, old_t = old_x + radius * spin[i + 2] * roll_x, old_t + radius * spin[i + 2] * roll_t
            free_x, free_t = free_x + radius * turn * roll_x, free_t + radius * turn * roll_t
            limit = grip[i + 2] * push * (1.0 + beyond)  # q / R, to second order
            px, pt, new_x, new_t = rub(free_x, free_t, roll_x, roll_t, limit, lighter, rolling * radius)
            rubbed[i + 2] -= 0.5 * (px * (old_x + new_x) + pt * (old_t + new_t))
            by_x = lighter * px
            if well is None:
                u, v, w = u + by_x, v + pt * a2, w + pt * a3
            else:
                u, v, w = u + by_x * e[0] + pt * a[0], v + by_x * e[1] + pt * a[1], w + by_x * e[2] + pt * a[2]
            turn += rolling * (px * roll_x + pt * roll_t)
            spin[i + 2] = turn
            angle[i + 2] += time * turn
        vx[i + 2], vy[i + 2], vz[i + 2] = u, v, w
        x[i + 2] += time * u
        y[i + 2] += time * v
        z[i + 2] += time * w


@kernel
def _most_friction(rod: Any, well: Any, wall: Any, i: int, p: Any) -> float:
    """Return the impulse per mass by which friction can hold an end node in the coming step: mu times the wall's."""
    place, _, q = _beside(rod, well, i)
    gap, stiffness, damping = p.radial_clearance, p.contact, p.contact_damping
    if wall is not None:
        gap = rod["gap"][i] + rod["taper"][i] * (place - rod["mark"][i])
        stiffness, damping = rod["contact"][i], rod["contact_time"][i]
    n = q[0] / gap, q[1] / gap, q[2] / gap
    beyond = max(0.5 * (dot(n, n) - 1.0), 0.0)
    depth = gap * beyond
    before = dot((rod["vx"][i], rod["vy"][i], rod["vz"][i]), n)
    push = p.step * stiffness * math.sqrt(depth) * (depth + damping * before)
    limit: float = grip_at(place, p) * max(push, 0.0) * (1.0 + beyond)
    return limit


@kernel
def _brake_end(
    rod: Any,
    well: Any,
    end: Any,
    axis: Any,
    i: int,
    sign: float,
    limit: float,
    before: Any,
    time: float,
    lighter: float,
) -> None:
    """Give an end that is held across the channel, or moved along it, the impulse of its share of the friction.

    An end held across slips along alone; one that is moved slips along at its speed, in the direction of ``sign``,
    whatever friction does, and what moves it overcomes that.  Neither rolls.  ``limit`` is the largest impulse per mass
    in motion across, ``before`` the velocity before the step, ``lighter`` the speed along that an impulse gives, over
    that across.
    """
    held = end.across in (HINGED, CLAMPED)
    if not (held or end.moved):
        return
    x, y, z, vx, vy, vz = rod["x"], rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"]
    old, aside, around = (vx[i], vy[i], vz[i]), (0.0, 0.0, 0.0), 0.0
    # An end not held slides around the wall too: along the channel's axis x q, q its offset from that axis.
    if not held:
        _, _, q = _beside(rod, well, i)
        distance = math.sqrt(dot(q, q)) + TINY
        aside = cross(axis, (q[0] / distance, q[1] / distance, q[2] / distance), 1.0)
        around = dot(old, aside)
    # Coulomb's law, against the velocity (along, around): of an end moved at a speed, -limit v / |v|, and around no
    # more than stops it; of an end that slips along alone, what stops it up to the limit.
    if end.moved:
        along = sign * end.speed
        part = limit / (math.sqrt(along * along + around * around) + TINY)
        px, pt = -part * along, -min(part, 1.0) * around
    else:
        speed = dot(old, axis)
        px, pt = -min(max(speed / lighter, -limit), limit), 0.0
        along = speed + lighter * px
    # Work is impulse times the mean of the velocities before and after.
    rod["lost_friction"][i] -= 0.5 * (px * (dot(before, axis) + along) + pt * (dot(before, aside) + around + pt))
    u = lighter * px * axis[0] + pt * aside[0]
    v = lighter * px * axis[1] + pt * aside[1]
    w = lighter * px * axis[2] + pt * aside[2]
    vx[i], vy[i], vz[i] = vx[i] + u, vy[i] + v, vz[i] + w
    x[i] += time * u
    y[i] += time * v
    z[i] += time * w


@kernel
def _hold_end(
    rod: Any, well: Any, end: Any, axis: Any, i: int, place: int, before: float, time: float, mass: float
) -> None:
    """Return an end that is held to where it is held; ``before`` is its velocity along the channel before the step.

    ``time`` is the time of the step, ``mass`` the mass of a segment in motion along the channel.
    """
    if end.across in (CLAMPED, GUIDED):
        rod["spin"][i] = rod["angle"][i] = 0.0
    if end.moved:
        x, y, z, vx, vy, vz = rod["x"], rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"]
        push, along = 1.0 - 2.0 * place, dot((vx[i], vy[i], vz[i]), axis)
        speed = push * end.speed
        moved = time * (speed - along)
        x[i] += moved * axis[0]
        y[i] += moved * axis[1]
        z[i] += moved * axis[2]
        vx[i] = vx[i] - along * axis[0] + speed * axis[0]
        vy[i] = vy[i] - along * axis[1] + speed * axis[1]
        vz[i] = vz[i] - along * axis[2] + speed * axis[2]
        impulse = mass * rod["share"][i] * (speed - along)
        rod["impulse"][place] += push * impulse
        rod["work"][0] += 0.5 * impulse * (before + speed)
    if end.across in (HINGED, CLAMPED):
        if well is None:
            rod["y"][i], rod["z"][i] = rod["anchor"][3 * place + 1], rod["anchor"][3 * place + 2]
            rod["vy"][i] = rod["vz"][i] = 0.0
        else:
            hold_beside(rod, i, place)


@kernel
def _masses(rod: Any, wall: Any, i: int, p: Any) -> Any:
    """Return the masses of a segment at a node, in motion across the channel and along it."""
    if wall is None:
        return p.mass, p.mass_along
    return rod["mass"][i], rod["mass_along"][i]


@kernel
def _decay(rod: Any, well: Any, wall: Any, p: Any) -> None:
    """Damp every velocity for half a step, except at an end moved at a given speed, and add up the energy lost."""
    # v' = -c v over half a step, exactly: factors f = exp(-c dt / 2) across and of spin, a = exp(-c_a dt / 2) along.
    # Of a node's mass m, with m_a along and the inertia I of its spin, the energy lost over m is
    #     (1 - f^2) (v_across^2 + (I / m) spin^2) / 2  +  (m_a / m) (1 - a^2) v_along^2 / 2 .
    # In a well v = u t + across with the tangent t, so that f v + (a - f) u t damps both parts; ends that are moved
    # keep u.  Nodes lie from index 2 on, behind two ghosts.
    vx, vy, vz, spin, lost = rod["vx"], rod["vy"], rod["vz"], rod["spin"], rod["lost_damping"]
    if well is not None:
        t1, t2, t3 = rod["t1"], rod["t2"], rod["t3"]
    factor, along, turning, half = p.decay, p.decay_along, p.inertia / p.mass, 0.5 * (p.mass_along / p.mass)
    part, part_along = 0.5 * (1.0 - factor * factor), half * (1.0 - along * along)
    first, last = 1 if p.upper.moved else 0, p.segments - 1 if p.lower.moved else p.segments
    if wall is not None:
        masses, masses_along, inertia = rod["mass"], rod["mass_along"], rod["inertia"]
    for i in range(p.segments + 1):
        if wall is not None:
            turning, half = inertia[i + 2] / masses[i + 2], 0.5 * (masses_along[i + 2] / masses[i + 2])
        square = vy[i + 2] * vy[i + 2] + vz[i + 2] * vz[i + 2]
        if well is None:
            vy[i + 2], vz[i + 2] = factor * vy[i + 2], factor * vz[i + 2]
        else:
            keep = along if first <= i <= last else 1.0
            speed = vx[i + 2] * t1[i + 2] + vy[i + 2] * t2[i + 2] + vz[i + 2] * t3[i + 2]
            square = vx[i + 2] * vx[i + 2] + square - speed * speed
            kept = (keep - factor) * speed
            vx[i + 2] = factor * vx[i + 2] + kept * t1[i + 2]
            vy[i + 2] = factor * vy[i + 2] + kept * t2[i + 2]
            vz[i + 2] = factor * vz[i + 2] + kept * t3[i + 2]
            lost[i + 2] += half * (1.0 - keep * keep) * speed * speed
        lost[i + 2] += part * (square + turning * spin[i + 2] * spin[i + 2])
        spin[i + 2] *= factor
    if well is None:  # a loop of its own is the faster one here
        for i in range(first, last + 1):
            if wall is not None:
                part_along = 0.5 * (masses_along[i + 2] / masses[i + 2]) * (1.0 - along * along)
            lost[i + 2] += part_along * vx[i + 2] * vx[i + 2]
            vx[i + 2] *= along


@kernel
def drift(rod: Any, time: float, segments: int) -> None:
    """Move nodes with their velocities for ``time``, which may be negative."""
    x, y, z, vx, vy, vz = rod["x"], rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"]
    angle, spin = rod["angle"], rod["spin"]
    for i in range(segments + 1):
        x[i + 2] += time * vx[i + 2]
        y[i + 2] += time * vy[i + 2]
        z[i + 2] += time * vz[i + 2]
        angle[i + 2] += time * spin[i + 2]


@kernel
def gradient(rod: Any, p: Any, axes: Any, upper: float, lower: float) -> None:
    """Write the forces of the rod on its segments, with ghost cells, under forces that push its ends along ``axes``."""
    a, b = FIRST, FIRST + p.segments
    _ghost_nodes(rod, p.well, p.upper.across, axes[0], a, 0)
    _ghost_nodes(rod, p.well, p.lower.across, axes[1], b, 1)
    _directions(rod, p.wall, p)
    if p.friction > 0.0:
        _torques(rod, p.wall, p)
    _ghost_directions(rod, p.upper.across, axes[0], a, 0)
    _ghost_directions(rod, p.lower.across, axes[1], b - 1, 1)
    _forces(rod, p.well, p.wall, p)
    _ghost_forces(rod, p.upper.across, axes[0], a, 0, upper)
    _ghost_forces(rod, p.lower.across, axes[1], b - 1, 1, lower)


@kernel
def advance(rod: Any, steps: int, p: Any) -> None:
    """Carry a rod whose positions are half a step ahead through ``steps`` steps, and count them on its clock."""
    a, b, vx, vy, vz = FIRST, FIRST + p.segments, rod["vx"], rod["vy"], rod["vz"]
    damped = p.decay != 1.0 or p.decay_along != 1.0
    first_mass, first_along = _masses(rod, p.wall, a, p)
    last_mass, last_along = _masses(rod, p.wall, b, p)
    done, earlier = int(rod["clock"][0]), int(p.steps_before)
    # Position Verlet, half drifts merged: with x half a step ahead, v += h F(x, t + h / 2) / m, then x += h v.  Damping
    # is split in halves about it (Strang), so that a step is reversible except for friction and damping.
    for number in range(done, done + steps):
        time = (p.steps_before + number + 0.5) * p.step
        if (number + earlier) % BETWEEN_ANCHORS == 0:
            _take_places(rod, p.well, p.wall, p)
        force = _vibration(rod, time, p.frequency, p.harmonics)
        upper = 0.0 if p.upper.moved else p.upper.mean + p.upper.drive * force
        lower = 0.0 if p.lower.moved else p.lower.mean + p.lower.drive * force
        if damped:
            _decay(rod, p.well, p.wall, p)
        axes, first, last = (
            (_beside(rod, p.well, a)[1], _beside(rod, p.well, b)[1]),
            (vx[a], vy[a], vz[a]),
            (vx[b], vy[b], vz[b]),
        )
        first_before, last_before = dot(first, axes[0]), dot(last, axes[1])
        shaking, on_upper, on_lower = _tool_force(p.tool, time, p.segments)
        ways = _tool_ways(rod, p.well, p.tool)
        tool_before = _tool_speed(rod, ways, p.tool, b)
        gradient(rod, p, axes, upper + on_upper, lower + on_lower)
        _shake(rod, shaking, ways, p.tool, b)
        # Ends have half a segment; friction on those held or moved is taken apart from the nodes', with its limit from
        # before anything moves.
        if p.friction > 0.0:
            first_limit = _most_friction(rod, p.well, p.wall, a, p)
            last_limit = _most_friction(rod, p.well, p.wall, b, p)
            move_nodes(rod, p.well, p.wall, p.friction, p)
            _brake_end(rod, p.well, p.upper, axes[0], a, 1.0, first_limit, first, p.step, first_mass / first_along)
            _brake_end(rod, p.well, p.lower, axes[1], b, -1.0, last_limit, last, p.step, last_mass / last_along)
        else:
            move_nodes(rod, p.well, p.wall, None, p)
        # Work of an end force: impulse times the mean of the velocities along before and after the step.
        first_both = first_before + dot((vx[a], vy[a], vz[a]), axes[0])
        last_both = last_before + dot((vx[b], vy[b], vz[b]), axes[1])
        rod["work"][0] += 0.5 * p.step * (upper * first_both - lower * last_both)
        rod["impulse"][0] += p.step * upper
        rod["impulse"][1] += p.step * lower
        _hold_end(rod, p.well, p.upper, axes[0], a, 0, first_before, p.step, first_along)
        _hold_end(rod, p.well, p.lower, axes[1], b, 1, last_before, p.step, last_along)
        rod["work"][0] += 0.5 * p.step * shaking * (tool_before + _tool_speed(rod, ways, p.tool, b))
        if damped:
            _decay(rod, p.well, p.wall, p)
    rod["clock"][0] = done + steps
