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
the order holds up to the ends; only that of stretch is the third at an end that is pushed.

Positions are kept half a step ahead of velocities (position Verlet with its half drifts merged), so the result does not
depend on how a run is divided into calls.  Loops touch few arrays each, so that compilers vectorise them.
"""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.compilation import kernel

FIRST = 2
"""Place of node 0 and of segment 0 in the fields of a record; before and after come ghost cells."""

NODE = ("x", "y", "z", "vx", "vy", "vz", "angle", "spin")
"""Of nodes: position, velocity; angle and rate of spin about the rod's own axis."""

LOST = ("lost_contact", "lost_friction", "lost_damping")
"""Of nodes: energy lost so far to each cause, per length of a node and per mass in motion across."""

PARTS = ("share", "grip")
"""Of nodes: their part of the rod, in segments; their coefficient of friction, 0 at an end that is held or moved, whose
share is taken apart."""

ONCE = ("anchor", "cosines", "sines", "work", "impulse", "clock")
"""Where ends are held across: y, z of the first and of the last node.  Cosines and sines of harmonics 1, 2, ... of the
vibration, in N.  Work done by the end forces so far.  Impulses by which the upper and the lower end have been pushed so
far.  Steps done so far."""

SCRATCH = ("d1", "d2", "d3", "inverse", "tension", "f1", "f2", "f3", "torque")
"""Of segments: direction, 1 / |t|, tension, gradient of the energy by t, torque of twist."""


def rod_type(segments: int) -> np.dtype[np.void]:
    """Return the record that holds a rod of so many segments.

    The lengths of its fields are part of its type: compilers then know that fields do not overlap, and vectorise loops
    over any number of them.  They come in few sizes because each is compiled again, for some five seconds: one serves
    every rod of up to 514 segments, and is no slower for few of them (measured).  Sizes are odd multiples of 64 bytes
    because rows at powers of two would compete for the same lines of the cache.
    """
    size = 512
    while size + 2 < segments:
        size *= 2
    fields = (*NODE, *LOST, *PARTS, *ONCE, *SCRATCH)
    return np.dtype([(name, np.float64, (size + 8,)) for name in fields])


HINGED, CLAMPED, GUIDED, FREE = range(4)
"""What an end may be across the channel."""

BETWEEN_GRIPS = 16
"""Steps after which nodes take the friction of where they are (a choice: at 10 m/s a node moves by half a millimetre in
so many)."""

TINY = 1e-300  # keeps 0 / 0 out of quotients whose value is not used
NEAR, FAR = 27.0 / 24.0, 1.0 / 24.0

# Of a clamped end, where K_0 = 2 (d_0 - e): the energy of its last nodes, A_00 K_0^2 + 2 A_01 K_0 K_1 + A_11 K_1^2 and
# so on in place of the bulk's, integrates the square of the curvature to fourth order (docs/theory/simulator.md).
_END = 4355.0 / 31212.0  # -A_01, and what A_11 has more than 1 + 1/12
_FIRST_END = 19961.0 / 31212.0  # A_00


class End(NamedTuple):
    """One end of a rod: what it may do across the channel and along it."""

    across: int  # HINGED, CLAMPED, GUIDED or FREE
    moved: bool  # whether it moves along the channel at a given speed, else it is pushed by a force
    speed: float  # the speed, in the direction of a push
    mean: float  # mean of the force that pushes it
    drive: float  # the part of the vibration that pushes it, 0 or 1

    @property
    def is_held(self) -> bool:
        """Whether it is held across the channel."""
        return self.across in (HINGED, CLAMPED)


class Tool(NamedTuple):
    """A tool in the rod that pushes it down and pulls it up with a sine."""

    amplitude: float  # 0 without a tool
    frequency: float
    node: int  # the last one above it
    beyond: float  # its distance from there, in segments


class Physics(NamedTuple):
    """Rod, channel, ends, load and time step as the loop uses them, in SI units."""

    segments: int
    step: float
    segment: float  # unstrained length of a segment
    mass: float  # of a segment in motion across the channel
    mass_along: float  # and along it
    inertia: float  # of a segment about its own axis
    stretch: float  # EA
    bend: float  # EI
    twist: float  # GJ
    radius: float
    radial_clearance: float  # R, where contact begins
    gravity: float  # acceleration towards the floor
    gravity_along: float  # and towards the lower end
    contact: float  # k in the contact acceleration k sqrt(d) (d + C v)
    contact_damping: float  # C
    friction: float  # the largest coefficient
    grips: NDArray[np.float64]  # a row each: a place along the channel, and the coefficient from there on
    decay: float  # factor on velocities across and on spins in half a step
    decay_along: float  # and on velocities along
    frequency: float
    harmonics: int  # of the vibration
    upper: End
    lower: End
    tool: Tool
    well: Any = None  # in a well its axis, and the weight about it, see `well_motion.Well`


def energy_of_fixed_end(across: int, first: float, both: float, next_one: float) -> float:
    """Return the squares by which an end that cannot rotate stores bending: of K_0, K_0 K_1 and K_1, as the bulk's."""
    if across == CLAMPED:
        return _FIRST_END * first - 2.0 * _END * both + _END * next_one
    return 0.5 * first + (first - 2.0 * both + next_one) / 12.0


@kernel
def vibration(rod: Any, time: float, p: Any) -> float:
    """Return the part of the force that vibrates, in N."""
    cosines, sines, force = rod["cosines"], rod["sines"], 0.0
    for k in range(p.harmonics):
        phase = (k + 1) * p.frequency * time
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
def set_grips(rod: Any, places: Any, p: Any) -> None:
    """Give nodes the friction of where they are, except for ends whose share is taken apart."""
    grip = rod["grip"]
    first = 1 if p.upper.moved or p.upper.across in (HINGED, CLAMPED) else 0
    last = p.segments - (1 if p.lower.moved or p.lower.across in (HINGED, CLAMPED) else 0)
    for i in range(first, last + 1):
        grip[i + 2] = grip_at(places[i + 2], p)


@kernel
def tool_force(time: float, p: Any) -> float:
    """Return the force in N with which the tool pushes the rod down."""
    force: float = p.tool.amplitude * math.sin(p.tool.frequency * time) if p.tool.amplitude > 0.0 else 0.0
    return force


@kernel
def on_ends(force: float, p: Any) -> Any:
    """Return what the upper and the lower end receive of the tool's force, in the direction of a push."""
    upper = (1.0 - p.tool.beyond) * force if p.tool.node == 0 else 0.0
    lower = -p.tool.beyond * force if p.tool.node + 1 == p.segments else 0.0
    return upper, lower


@kernel
def push_node(f: Any, i: int, force: float, p: Any) -> None:
    """Add a force on the inner node ``i`` to the forces on segments: by their stencil a step passes it on."""
    if FIRST < i < FIRST + p.segments:
        for j in range(i, FIRST + p.segments + 2):
            f[j] += force


@kernel
def pushed_speed(v: Any, i: int, p: Any) -> float:
    """Return the velocity with which a force on node ``i`` does work: that of the nodes to which it is passed on."""
    speed: float = v[i]
    if FIRST < i < FIRST + p.segments:
        speed += FAR * (2.0 * v[i] - v[i - 1] - v[i + 1])
    return speed


@kernel
def _tool_speed(rod: Any, p: Any) -> float:
    """Return the velocity along the channel with which the tool does work."""
    i, vx = FIRST + p.tool.node, rod["vx"]
    speed: float = (1.0 - p.tool.beyond) * pushed_speed(vx, i, p) + p.tool.beyond * pushed_speed(vx, i + 1, p)
    return speed


@kernel
def _shake(rod: Any, force: float, p: Any) -> None:
    """Add the force of the tool on inner nodes to the forces on segments."""
    i = FIRST + p.tool.node
    push_node(rod["f1"], i, (1.0 - p.tool.beyond) * force, p)
    push_node(rod["f1"], i + 1, p.tool.beyond * force, p)


@kernel
def _ghost_node(even: bool, v: Any, a: int, inward: int) -> None:
    """Write the ghost of a coordinate of the nodes beyond the end node ``a``, even or odd about it."""
    v[a - inward] = v[a + inward] if even else 2.0 * v[a] - v[a + inward]


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
def ghost_force(even: bool, f: Any, a: int, inward: int, push: float) -> None:
    """Write both ghosts of a component of the forces beyond the end segment ``a``, with a push on the end node.

    They pass on to the end nodes what the ghost node would receive, which is ``even`` about the end or odd.
    """
    if even:
        one, two = -f[a], -27.0 * f[a]
    else:
        one, two = f[a], 25.0 * f[a]
    f[a - inward], f[a - 2 * inward] = one, two + 24.0 * push


@kernel
def directions(rod: Any, with_friction: Literal[True, False], p: Any) -> None:
    """Write direction, length and tension of every segment."""
    x, y, z = rod["x"], rod["y"], rod["z"]
    d1, d2, d3, inverse, tension = rod["d1"], rod["d2"], rod["d3"], rod["inverse"], rod["tension"]
    angle, torque = rod["angle"], rod["torque"]
    stretch, rest, twist = p.stretch / p.segment, p.stretch, p.twist / p.segment
    for i in range(p.segments):
        t1 = NEAR * (x[i + 3] - x[i + 2]) - FAR * (x[i + 4] - x[i + 1])
        t2 = NEAR * (y[i + 3] - y[i + 2]) - FAR * (y[i + 4] - y[i + 1])
        t3 = NEAR * (z[i + 3] - z[i + 2]) - FAR * (z[i + 4] - z[i + 1])
        length = math.sqrt(t1 * t1 + t2 * t2 + t3 * t3)
        one_over = 1.0 / length
        d1[i + 2], d2[i + 2], d3[i + 2] = one_over * t1, one_over * t2, one_over * t3
        inverse[i + 2], tension[i + 2] = one_over, stretch * length - rest
        if with_friction:
            torque[i + 2] = twist * (angle[i + 3] - angle[i + 2])


@kernel
def _forces(rod: Any, p: Any) -> None:
    """Write the gradient of the energy by the tangent of every segment."""
    d1, d2, d3, inverse, tension = rod["d1"], rod["d2"], rod["d3"], rod["inverse"], rod["tension"]
    f1, f2, f3 = rod["f1"], rod["f2"], rod["f3"]
    bend = p.bend / p.segment
    for i in range(p.segments):
        a, b, c = d1[i + 2], d2[i + 2], d3[i + 2]
        g1 = 2.5 * a - (4.0 / 3.0) * (d1[i + 1] + d1[i + 3]) + (1.0 / 12.0) * (d1[i] + d1[i + 4])
        g2 = 2.5 * b - (4.0 / 3.0) * (d2[i + 1] + d2[i + 3]) + (1.0 / 12.0) * (d2[i] + d2[i + 4])
        g3 = 2.5 * c - (4.0 / 3.0) * (d3[i + 1] + d3[i + 3]) + (1.0 / 12.0) * (d3[i] + d3[i + 4])
        scale = bend * inverse[i + 2]
        along = tension[i + 2] - scale * (g1 * a + g2 * b + g3 * c)
        f1[i + 2], f2[i + 2], f3[i + 2] = along * a + scale * g1, along * b + scale * g2, along * c + scale * g3


@kernel
def frictionless_step(rod: Any, p: Any) -> None:
    """Give the nodes of a frictionless rod their new velocities, and move them.

    The indentation is taken as d = (y^2 + z^2 - R^2) / (2 R), the distance beyond R except for a relative d / (2 R):
    its gradient (y, z) / R costs neither a root nor a quotient.
    """
    x, y, z, vx, vy, vz, lost = rod["x"], rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"], rod["lost_contact"]
    f1, f2, f3, share = rod["f1"], rod["f2"], rod["f3"], rod["share"]
    step, stiffness, damping = p.step, p.step * p.contact, p.contact_damping
    across, along = p.step / p.mass, p.step / p.mass_along
    fall, slide = p.step * p.gravity, p.step * p.gravity_along
    inverse, half_gap = 1.0 / p.radial_clearance, 0.5 * p.radial_clearance
    for i in range(p.segments + 1):
        ny, nz = inverse * y[i + 2], inverse * z[i + 2]
        depth = max(half_gap * (ny * ny + nz * nz - 1.0), 0.0)
        root = stiffness * math.sqrt(depth)
        before = vy[i + 2] * ny + vz[i + 2] * nz
        push = max(root * (depth + damping * before), 0.0)
        one_over = 1.0 / share[i + 2]
        kick = across * one_over
        u = vx[i + 2] + along * one_over * (NEAR * (f1[i + 2] - f1[i + 1]) - FAR * (f1[i + 3] - f1[i])) + slide
        v = vy[i + 2] + kick * (NEAR * (f2[i + 2] - f2[i + 1]) - FAR * (f2[i + 3] - f2[i])) - push * ny
        w = vz[i + 2] + kick * (NEAR * (f3[i + 2] - f3[i + 1]) - FAR * (f3[i + 3] - f3[i])) - push * nz - fall
        lost[i + 2] += 0.5 * (push - root * depth) * (before + v * ny + w * nz)
        vx[i + 2], vy[i + 2], vz[i + 2] = u, v, w
        x[i + 2] += step * u
        y[i + 2] += step * v
        z[i + 2] += step * w


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
def _frictional_step(rod: Any, p: Any) -> None:
    """Give the nodes their new velocities and spins under Coulomb's law, see `rub`, and move them."""
    x, y, z, vx, vy, vz = rod["x"], rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"]
    angle, spin, torque, share, grip = rod["angle"], rod["spin"], rod["torque"], rod["share"], rod["grip"]
    d1, d2, d3, f1, f2, f3 = rod["d1"], rod["d2"], rod["d3"], rod["f1"], rod["f2"], rod["f3"]
    lost, rubbed = rod["lost_contact"], rod["lost_friction"]
    step, stiffness, damping = p.step, p.step * p.contact, p.contact_damping
    across, along, turning = p.step / p.mass, p.step / p.mass_along, p.step / p.inertia
    fall, slide = p.step * p.gravity, p.step * p.gravity_along
    inverse, gap, radius = 1.0 / p.radial_clearance, p.radial_clearance, p.radius
    lighter = p.mass / p.mass_along  # speed along that an impulse gives, over that across
    rolling = p.mass * p.radius / p.inertia  # spin that it gives
    for i in range(p.segments + 1):
        ny, nz = inverse * y[i + 2], inverse * z[i + 2]
        beyond = max(0.5 * (ny * ny + nz * nz - 1.0), 0.0)
        depth = gap * beyond
        root = stiffness * math.sqrt(depth)
        before = vy[i + 2] * ny + vz[i + 2] * nz
        push = max(root * (depth + damping * before), 0.0)
        unit = 1.0 - beyond * (1.0 - beyond * (1.5 - 2.5 * beyond))  # 1 / sqrt(1 + 2 beyond): R / distance
        e, f = -unit * nz, unit * ny  # around the channel; the surface moves along and around with the spin:
        roll_x = -0.5 * ((d2[i + 1] + d2[i + 2]) * e + (d3[i + 1] + d3[i + 2]) * f)
        roll_t = 0.5 * (d1[i + 1] + d1[i + 2])
        surface = radius * spin[i + 2]
        old_x, old_t = vx[i + 2] + surface * roll_x, vy[i + 2] * e + vz[i + 2] * f + surface * roll_t
        one_over = 1.0 / share[i + 2]
        kick = across * one_over
        u = vx[i + 2] + along * one_over * (NEAR * (f1[i + 2] - f1[i + 1]) - FAR * (f1[i + 3] - f1[i])) + slide
        v = vy[i + 2] + kick * (NEAR * (f2[i + 2] - f2[i + 1]) - FAR * (f2[i + 3] - f2[i])) - push * ny
        w = vz[i + 2] + kick * (NEAR * (f3[i + 2] - f3[i + 1]) - FAR * (f3[i + 3] - f3[i])) - push * nz - fall
        turn = spin[i + 2] + turning * one_over * (torque[i + 2] - torque[i + 1])
        lost[i + 2] += 0.5 * (push - root * depth) * (before + v * ny + w * nz)
        free_x, free_t = u + radius * turn * roll_x, v * e + w * f + radius * turn * roll_t
        limit = grip[i + 2] * push * (1.0 + beyond)  # |(y, z)| / R, to second order
        px, pt, new_x, new_t = rub(free_x, free_t, roll_x, roll_t, limit, lighter, rolling * radius)
        rubbed[i + 2] -= 0.5 * (px * (old_x + new_x) + pt * (old_t + new_t))
        u, v, w = u + lighter * px, v + pt * e, w + pt * f
        turn += rolling * (px * roll_x + pt * roll_t)
        vx[i + 2], vy[i + 2], vz[i + 2], spin[i + 2] = u, v, w, turn
        x[i + 2] += step * u
        y[i + 2] += step * v
        z[i + 2] += step * w
        angle[i + 2] += step * turn


@kernel
def _ghost_nodes(rod: Any, across: int, a: int, inward: int) -> None:
    """Write the ghost node beyond the end node ``a``: even across the channel where the end cannot rotate."""
    even = across in (CLAMPED, GUIDED)
    _ghost_node(False, rod["x"], a, inward)
    _ghost_node(even, rod["y"], a, inward)
    _ghost_node(even, rod["z"], a, inward)


@kernel
def _ghost_directions(rod: Any, across: int, a: int, inward: int) -> None:
    """Write the ghosts of the directions beyond the end segment ``a``."""
    ghost_direction(across, rod["d1"], a, inward, 1.0)
    ghost_direction(across, rod["d2"], a, inward, 0.0)
    ghost_direction(across, rod["d3"], a, inward, 0.0)


@kernel
def _ghost_forces(rod: Any, across: int, a: int, inward: int, push: float) -> None:
    """Write the ghosts of the forces beyond the end segment ``a``, with the force that pushes the end along."""
    even = across in (CLAMPED, GUIDED)
    ghost_force(False, rod["f1"], a, inward, push)
    ghost_force(even, rod["f2"], a, inward, 0.0)
    ghost_force(even, rod["f3"], a, inward, 0.0)


@kernel
def _most_friction(rod: Any, i: int, p: Any) -> float:
    """Return the impulse per mass by which friction can hold an end node in the coming step: mu times the wall's."""
    ny, nz = rod["y"][i] / p.radial_clearance, rod["z"][i] / p.radial_clearance
    beyond = max(0.5 * (ny * ny + nz * nz - 1.0), 0.0)
    depth = p.radial_clearance * beyond
    before = rod["vy"][i] * ny + rod["vz"][i] * nz
    push = p.step * p.contact * math.sqrt(depth) * (depth + p.contact_damping * before)
    limit: float = grip_at(rod["x"][i], p) * max(push, 0.0) * (1.0 + beyond)
    return limit


@kernel
def _brake_end(rod: Any, end: Any, i: int, push: float, limit: float, before: Any, p: Any) -> None:
    """Give an end that is held across the channel, or moved along it, the impulse of its share of the friction.

    An end held across slips along alone; one that is moved slips along at its speed, whatever friction does, and what
    moves it overcomes that.  Neither rolls.  ``limit`` is the largest impulse per mass in motion across, ``before`` the
    velocity before the step.
    """
    held = end.across in (HINGED, CLAMPED)
    if not (held or end.moved):
        return
    x, y, z, vx, vy, vz = rod["x"], rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"]
    lighter = p.mass / p.mass_along  # speed along that an impulse gives, over that across
    distance = math.sqrt(y[i] * y[i] + z[i] * z[i]) + TINY
    e, f = -z[i] / distance, y[i] / distance
    around = 0.0 if held else vy[i] * e + vz[i] * f
    if end.moved:
        along = push * end.speed
        part = limit / (math.sqrt(along * along + around * around) + TINY)
        px, pt = -part * along, -min(part, 1.0) * around
    else:
        px, pt = -min(max(vx[i] / lighter, -limit), limit), 0.0
        along = vx[i] + lighter * px
    slipped = px * (before[0] + along) + pt * (before[1] * e + before[2] * f + around + pt)
    rod["lost_friction"][i] -= 0.5 * slipped
    vx[i], vy[i], vz[i] = vx[i] + lighter * px, vy[i] + pt * e, vz[i] + pt * f
    x[i] += p.step * lighter * px
    y[i] += p.step * pt * e
    z[i] += p.step * pt * f


@kernel
def _hold_end(rod: Any, end: Any, i: int, place: int, push: float, before: float, p: Any) -> None:
    """Return an end that is held to where it is held; ``push`` is the sign of the direction in which it is pushed.

    ``before`` is its velocity along the channel before the step.
    """
    y, z, vy, vz, anchor = rod["y"], rod["z"], rod["vy"], rod["vz"], rod["anchor"]
    if end.across in (HINGED, CLAMPED):
        y[i], z[i] = anchor[2 * place], anchor[2 * place + 1]
        vy[i] = vz[i] = 0.0
    if end.across in (CLAMPED, GUIDED):
        rod["spin"][i] = rod["angle"][i] = 0.0
    if end.moved:
        x, vx, speed = rod["x"], rod["vx"], push * end.speed
        change = speed - vx[i]
        impulse = p.mass_along * rod["share"][i] * change
        x[i] += p.step * change
        vx[i] = speed
        rod["impulse"][place] += push * impulse
        rod["work"][0] += 0.5 * impulse * (before + speed)


@kernel
def _decay(rod: Any, p: Any) -> None:
    """Damp every velocity for half a step, but that of an end that is moved, and add up the energy lost."""
    vx, vy, vz, spin, lost = rod["vx"], rod["vy"], rod["vz"], rod["spin"], rod["lost_damping"]
    factor, along = p.decay, p.decay_along
    heavier, turning = p.mass_along / p.mass, p.inertia / p.mass
    part, part_along = 0.5 * (1.0 - factor * factor), 0.5 * heavier * (1.0 - along * along)
    for i in range(p.segments + 1):
        across = vy[i + 2] * vy[i + 2] + vz[i + 2] * vz[i + 2] + turning * spin[i + 2] * spin[i + 2]
        lost[i + 2] += part * across
        vy[i + 2] *= factor
        vz[i + 2] *= factor
        spin[i + 2] *= factor
    for i in range(1 if p.upper.moved else 0, p.segments if p.lower.moved else p.segments + 1):
        lost[i + 2] += part_along * vx[i + 2] * vx[i + 2]
        vx[i + 2] *= along


@kernel
def drift(rod: Any, time: float, p: Any) -> None:
    """Move nodes with their velocities for ``time``, which may be negative."""
    x, y, z, vx, vy, vz = rod["x"], rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"]
    angle, spin = rod["angle"], rod["spin"]
    for i in range(p.segments + 1):
        x[i + 2] += time * vx[i + 2]
        y[i + 2] += time * vy[i + 2]
        z[i + 2] += time * vz[i + 2]
        angle[i + 2] += time * spin[i + 2]


@kernel
def gradient(rod: Any, p: Any, upper: float, lower: float) -> None:
    """Write the forces of the rod on its segments, with ghost cells, under forces that push its ends."""
    a, b = FIRST, FIRST + p.segments
    _ghost_nodes(rod, p.upper.across, a, 1)
    _ghost_nodes(rod, p.lower.across, b, -1)
    if p.friction > 0.0:
        directions(rod, True, p)
        rod["torque"][a - 1] = rod["torque"][b] = 0.0
    else:
        directions(rod, False, p)
    _ghost_directions(rod, p.upper.across, a, 1)
    _ghost_directions(rod, p.lower.across, b - 1, -1)
    _forces(rod, p)
    _ghost_forces(rod, p.upper.across, a, 1, upper)
    _ghost_forces(rod, p.lower.across, b - 1, -1, lower)


@kernel
def advance(rod: Any, steps: int, p: Any) -> None:
    """Carry a rod whose positions are half a step ahead through ``steps`` steps, and count them on its clock."""
    a, b, vx, vy, vz = FIRST, FIRST + p.segments, rod["vx"], rod["vy"], rod["vz"]
    damped = p.decay != 1.0 or p.decay_along != 1.0
    done = int(rod["clock"][0])
    for number in range(done, done + steps):
        if len(p.grips) > 1 and number % BETWEEN_GRIPS == 0:
            set_grips(rod, rod["x"], p)
        force = vibration(rod, (number + 0.5) * p.step, p)
        upper = 0.0 if p.upper.moved else p.upper.mean + p.upper.drive * force
        lower = 0.0 if p.lower.moved else p.lower.mean + p.lower.drive * force
        if damped:
            _decay(rod, p)
        first_before, last_before = vx[a], vx[b]
        shaking = tool_force((number + 0.5) * p.step, p)
        on_upper, on_lower = on_ends(shaking, p)
        tool_before = _tool_speed(rod, p)
        gradient(rod, p, upper + on_upper, lower + on_lower)
        if shaking != 0.0:
            _shake(rod, shaking, p)
        if p.friction > 0.0:
            first, last = (vx[a], vy[a], vz[a]), (vx[b], vy[b], vz[b])
            first_limit, last_limit = _most_friction(rod, a, p), _most_friction(rod, b, p)
            _frictional_step(rod, p)
            _brake_end(rod, p.upper, a, 1.0, first_limit, first, p)
            _brake_end(rod, p.lower, b, -1.0, last_limit, last, p)
        else:
            frictionless_step(rod, p)
        rod["work"][0] += 0.5 * p.step * (upper * (first_before + vx[a]) - lower * (last_before + vx[b]))
        rod["impulse"][0] += p.step * upper
        rod["impulse"][1] += p.step * lower
        _hold_end(rod, p.upper, a, 0, 1.0, first_before, p)
        _hold_end(rod, p.lower, b, 1, -1.0, last_before, p)
        if shaking != 0.0:
            rod["work"][0] += 0.5 * p.step * shaking * (tool_before + _tool_speed(rod, p))
        if damped:
            _decay(rod, p)
    rod["clock"][0] = done + steps
