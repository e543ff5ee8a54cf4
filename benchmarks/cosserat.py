"""The former kernel of the simulated rod, kept as an independent model: a Cosserat rod of second order.

Shear, torsion that bends along, and rotary inertia are in it, which `floquetrod.simulation.kernels.rod_step` leaves
out; node positions, directions and friction are solved in another way.  It knows solid, horizontal, hinged rods under
an `AxialLoad`.  Tests compare the present simulator with it, `benchmarks.simulator` their times.

The rod is n segments between n + 1 nodes.  Nodes carry position and velocity, segments a unit quaternion (material axes
to space; the first material axis points along the rod) and an angular velocity in material axes.  With t the vector
between a segment's nodes, l its unstrained length and Q its rotation, the elastic energy is

    sum over segments  (l / 2) [EA (s1)^2 + kGA (s2^2 + s3^2)],   s = Q^T t / l - e1                 (stretch, shear)
  + sum over inner nodes (2 / l) [GJ b1^2 + EI (b2^2 + b3^2)],    b = vector part of conj(q_left) q_right  (twist, bend)

and forces and torques are its exact gradient, so that without contact nothing but rounding makes energy drift.

Positions and quaternions are kept half a step ahead of velocities (position Verlet with its half drifts merged), so the
result does not depend on how a run is divided into calls.  Loops touch few arrays each, so that compilers vectorise
them.
"""

from __future__ import annotations

import math
import time
from typing import Any, Literal, NamedTuple

import numpy as np

import floquetrod as fr
from floquetrod._util.compilation import compiled, compiled_for, kernel
from floquetrod.simulation.recorded_motion import RecordedMotion
from floquetrod.simulation.rod_mesh import DiscreteRod
from floquetrod.simulation.step_size import SAFETY, TimeSteps

NODE = ("x", "y", "z", "vx", "vy", "vz", "px", "pt", "spin_impulse", "slip_x", "slip_t")
"""Of nodes 0..n: position, velocity; impulse of friction in the last step, axial, circumferential and that which spins;
velocity of the rod's surface after it.  Impulses per mass of a node."""

LOST = ("lost_contact", "lost_friction", "lost_damping")
"""Of nodes: energy lost so far to each cause, per mass of a node."""

SEGMENT = ("q0", "q1", "q2", "q3", "w1", "w2", "w3", "lost_turning")
"""Of segments 0..n-1: quaternion, angular velocity in material axes, energy that damping took from their rotation."""

SCRATCH = ("fx", "fy", "fz", "h1", "h2", "h3", "c2", "c3")
"""Forces, of segment i at i + 1, between two ghost cells; moments at nodes."""

FRICTION_SCRATCH = ("t1", "t2", "t3", "spin", "ey", "ez", "roll_x", "roll_t", "limit", "spin_change")
"""Tangents and spins, of segment i at i + 1, between two ghost cells.  At nodes: the circumferential direction, surface
speeds that unit surface speed of spinning makes, largest impulse of friction, change of the impulse that spins."""

ONCE = ("anchor", "work", "clock")
"""Where ends are held: y, z of the first and of the last node.  In their first elements: work done by the end forces so
far, steps done so far."""


def rod_type(segments: int) -> np.dtype[np.void]:
    """Return the record that holds a rod of so many segments.

    The lengths of its fields are part of its type: compilers then know that fields do not overlap, and vectorise loops
    over any number of them.  They come in few sizes because each is compiled anew, and are odd multiples of 64 bytes
    because rows at powers of two would compete for the same lines of the cache.
    """
    size = 256
    while size + 6 < segments:
        size *= 2
    fields = (*NODE, *LOST, *SEGMENT, *ONCE, *SCRATCH, *FRICTION_SCRATCH)
    return np.dtype([(name, np.float64, (size + 8,)) for name in fields])


_TINY = 1e-300  # keeps 0 / 0 out of quotients whose value is not used


class Physics(NamedTuple):
    """Rod, channel, ends, load and time step as the loop uses them, in SI units."""

    segments: int
    step: float
    segment: float  # unstrained length of a segment
    mass: float  # of a segment and an inner node; an end node has half of it
    inertia: float  # of a segment about its own axis
    cross_inertia: float  # and across it
    stretch: float  # EA
    shear: float  # kGA
    bend: float  # EI
    twist: float  # GJ
    radius: float
    radial_clearance: float  # R, where contact begins
    gravity: float
    contact: float  # k in the contact acceleration k sqrt(d) (d + C v)
    contact_damping: float  # C
    friction: float
    decay: float  # factor on every velocity in half a step
    mean: float
    amplitude: float
    frequency: float


@kernel
def _moments(rod: Any, p: Physics) -> None:
    """Write the moment of twist and bending at every inner node: h on the left, -h on the right, -c on both."""
    q0, q1, q2, q3 = rod["q0"], rod["q1"], rod["q2"], rod["q3"]
    h1, h2, h3, c2, c3 = rod["h1"], rod["h2"], rod["h3"], rod["c2"], rod["c3"]
    twist, bend = 2.0 * p.twist / p.segment, 2.0 * p.bend / p.segment
    for i in range(1, p.segments):
        a, b, c, d = q0[i - 1], q1[i - 1], q2[i - 1], q3[i - 1]
        e, f, g, h = q0[i], q1[i], q2[i], q3[i]
        r0 = a * e + b * f + c * g + d * h
        r1 = a * f - b * e - c * h + d * g
        r2 = a * g + b * h - c * e - d * f
        r3 = a * h - b * g + c * f - d * e
        h1[i] = twist * r0 * r1
        h2[i] = bend * r0 * r2
        h3[i] = bend * r0 * r3
        c2[i] = (bend - twist) * r1 * r3
        c3[i] = (twist - bend) * r1 * r2


@kernel
def _segment_forces(rod: Any, with_friction: Literal[True, False], p: Physics) -> None:
    """Write the force in every segment, and give the segments their new angular velocities.

    Half a step of torque, a turn about the rod's own axis that stands for the gyroscopic torque of a body with two
    equal inertias (it keeps the energy), half a step of torque.  ``with_friction`` also applies last step's impulses of
    friction to the spins, and writes the tangents and spins that this step's friction reads.
    """
    x, y, z = rod["x"], rod["y"], rod["z"]
    q0, q1, q2, q3 = rod["q0"], rod["q1"], rod["q2"], rod["q3"]
    w1, w2, w3 = rod["w1"], rod["w2"], rod["w3"]
    fx, fy, fz, t1s, t2s, t3s = rod["fx"], rod["fy"], rod["fz"], rod["t1"], rod["t2"], rod["t3"]
    spin, spin_impulse, rolling = rod["spin"], rod["spin_impulse"], 0.5 * p.mass * p.radius / p.inertia
    h1, h2, h3, c2, c3 = rod["h1"], rod["h2"], rod["h3"], rod["c2"], rod["c3"]
    rest, stretch, shear = p.stretch, p.stretch / p.segment, p.shear / p.segment
    half1, half2 = 0.5 * p.step / p.inertia, 0.5 * p.step / p.cross_inertia
    gyro = 0.5 * p.step * (p.cross_inertia - p.inertia) / p.cross_inertia
    for i in range(p.segments):
        a, b, c, d = q0[i], q1[i], q2[i], q3[i]
        dx, dy, dz = x[i + 1] - x[i], y[i + 1] - y[i], z[i + 1] - z[i]
        twice_b, twice_c, twice_d = b + b, c + c, d + d
        bb, cc, dd = b * twice_b, c * twice_c, d * twice_d
        bc, bd, cd = b * twice_c, b * twice_d, c * twice_d
        ab, ac, ad = a * twice_b, a * twice_c, a * twice_d
        r11, r12, r13 = 1.0 - cc - dd, bc - ad, bd + ac
        r21, r22, r23 = bc + ad, 1.0 - bb - dd, cd - ab
        r31, r32, r33 = bd - ac, cd + ab, 1.0 - bb - cc
        t1 = r11 * dx + r21 * dy + r31 * dz
        t2 = r12 * dx + r22 * dy + r32 * dz
        t3 = r13 * dx + r23 * dy + r33 * dz
        n1, n2, n3 = stretch * t1 - rest, shear * t2, shear * t3
        fx[i + 1] = r11 * n1 + r12 * n2 + r13 * n3
        fy[i + 1] = r21 * n1 + r22 * n2 + r23 * n3
        fz[i + 1] = r31 * n1 + r32 * n2 + r33 * n3
        a1 = half1 * (h1[i + 1] - h1[i])
        a2 = half2 * (t3 * n1 - t1 * n3 + h2[i + 1] - h2[i] - c2[i + 1] - c2[i])
        a3 = half2 * (t1 * n2 - t2 * n1 + h3[i + 1] - h3[i] - c3[i + 1] - c3[i])
        u, v, w = w1[i] + a1, w2[i] + a2, w3[i] + a3
        g = gyro * u
        scale = 1.0 - g * g * (1.0 - g * g)  # 1 / (1 + g^2): g is the turn in half a step, far below 0.01
        a = u + a1
        if with_friction:
            t1s[i + 1], t2s[i + 1], t3s[i + 1] = r11, r21, r31
            a += rolling * (spin_impulse[i] + spin_impulse[i + 1])
            spin[i + 1] = a
        w1[i] = a
        w2[i] = scale * ((1.0 - g * g) * v + 2.0 * g * w) + a2
        w3[i] = scale * ((1.0 - g * g) * w - 2.0 * g * v) + a3


@kernel
def _frictionless_step(rod: Any, p: Physics) -> None:
    """Give the nodes of a frictionless rod their new velocities, and move them.

    The indentation is taken as d = (y^2 + z^2 - R^2) / (2 R), the distance beyond R but for a relative d / (2 R): its
    gradient (y, z) / R costs neither a root nor a quotient.
    """
    x, y, z, vx, vy, vz, lost = rod["x"], rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"], rod["lost_contact"]
    fx, fy, fz = rod["fx"], rod["fy"], rod["fz"]
    step, stiffness, damping = p.step, p.step * p.contact, p.contact_damping
    kick, fall = p.step / p.mass, p.step * p.gravity
    inverse, half_gap = 1.0 / p.radial_clearance, 0.5 * p.radial_clearance
    for i in range(p.segments + 1):
        ny, nz = inverse * y[i], inverse * z[i]
        depth = max(half_gap * (ny * ny + nz * nz - 1.0), 0.0)
        root = stiffness * math.sqrt(depth)
        before = vy[i] * ny + vz[i] * nz
        push = max(root * (depth + damping * before), 0.0)
        u = vx[i] + kick * (fx[i + 1] - fx[i])
        v = vy[i] + kick * (fy[i + 1] - fy[i]) - push * ny
        w = vz[i] + kick * (fz[i + 1] - fz[i]) - push * nz - fall
        lost[i] += 0.5 * (push - root * depth) * (before + v * ny + w * nz)
        vx[i], vy[i], vz[i] = u, v, w
        x[i] += step * u
        y[i] += step * v
        z[i] += step * w


@kernel
def _fill_ghost_cells(rod: Any, n: int, force: float) -> None:
    """Fill the ghost cells of the forces so that end nodes, of half a mass, feel their segment and ``force`` doubly.

    Tangents and spins are repeated beyond the ends.
    """
    t1, t2, t3, spin = rod["t1"], rod["t2"], rod["t3"], rod["spin"]
    spin[0], spin[n + 1] = spin[1], spin[n]
    t1[0], t2[0], t3[0], t1[n + 1], t2[n + 1], t3[n + 1] = t1[1], t2[1], t3[1], t1[n], t2[n], t3[n]
    fx, fy, fz = rod["fx"], rod["fy"], rod["fz"]
    fx[0], fy[0], fz[0] = -2.0 * force - fx[1], -fy[1], -fz[1]
    fx[n + 1], fy[n + 1], fz[n + 1] = -2.0 * force - fx[n], -fy[n], -fz[n]


@kernel
def _hold_ends(rod: Any, p: Physics) -> None:
    """Return the ends to where they are held across the channel, at rest."""
    n, anchor = p.segments, rod["anchor"]
    rod["y"][0], rod["z"][0], rod["y"][n], rod["z"][n] = anchor[0], anchor[1], anchor[2], anchor[3]
    rod["vy"][0] = rod["vz"][0] = rod["vy"][n] = rod["vz"][n] = 0.0


@kernel
def _rotate(rod: Any, with_friction: bool, time: float, p: Physics) -> None:
    """Turn the segments with their angular velocities, to which friction adds: Cayley's form of a small rotation."""
    spin_change, rolling = rod["spin_change"], 0.5 * p.mass * p.radius / p.inertia
    q0, q1, q2, q3 = rod["q0"], rod["q1"], rod["q2"], rod["q3"]
    w1, w2, w3 = rod["w1"], rod["w2"], rod["w3"]
    half = 0.5 * time
    for i in range(p.segments):
        if with_friction:
            w1[i] += rolling * (spin_change[i] + spin_change[i + 1])
        a, b, c, d = q0[i], q1[i], q2[i], q3[i]
        u, v, w = half * w1[i], half * w2[i], half * w3[i]
        e0 = a - b * u - c * v - d * w
        e1 = b + a * u + c * w - d * v
        e2 = c + a * v + d * u - b * w
        e3 = d + a * w + b * v - c * u
        size = e0 * e0 + e1 * e1 + e2 * e2 + e3 * e3
        scale = 1.875 - size * (1.25 - 0.375 * size)  # 1 / sqrt(size) near 1; the next step corrects what remains
        q0[i], q1[i], q2[i], q3[i] = scale * e0, scale * e1, scale * e2, scale * e3


@kernel
def _contact(rod: Any, p: Physics) -> None:
    """Give the nodes their velocities under elastic forces, contact, weight and last step's impulses of friction.

    Besides, write for every node what `_friction` reads: directions and the largest impulse.
    """
    y, z, vx, vy, vz, lost = rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"], rod["lost_contact"]
    fx, fy, fz, px, pt = rod["fx"], rod["fy"], rod["fz"], rod["px"], rod["pt"]
    t1, t2, t3, ey, ez = rod["t1"], rod["t2"], rod["t3"], rod["ey"], rod["ez"]
    roll_x, roll_t, limit = rod["roll_x"], rod["roll_t"], rod["limit"]
    stiffness, damping = p.step * p.contact, p.contact_damping
    kick, fall = p.step / p.mass, p.step * p.gravity
    inverse, gap = 1.0 / p.radial_clearance, p.radial_clearance
    for i in range(p.segments + 1):
        ny, nz = inverse * y[i], inverse * z[i]
        beyond = max(0.5 * (ny * ny + nz * nz - 1.0), 0.0)
        depth = gap * beyond
        root = stiffness * math.sqrt(depth)
        before = vy[i] * ny + vz[i] * nz
        push = max(root * (depth + damping * before), 0.0)
        unit = 1.0 - beyond * (1.0 - beyond * (1.5 - 2.5 * beyond))  # 1 / sqrt(1 + 2 beyond): R / distance
        e, f = -unit * nz, unit * ny
        along = -0.5 * ((t2[i] + t2[i + 1]) * e + (t3[i] + t3[i + 1]) * f)
        around = 0.5 * (t1[i] + t1[i + 1])
        u = vx[i] + kick * (fx[i + 1] - fx[i])
        v = vy[i] + kick * (fy[i + 1] - fy[i]) - push * ny
        w = vz[i] + kick * (fz[i + 1] - fz[i]) - push * nz - fall
        lost[i] += 0.5 * (push - root * depth) * (before + v * ny + w * nz)
        vx[i], vy[i], vz[i] = u + px[i], v + pt[i] * e, w + pt[i] * f
        ey[i], ez[i], roll_x[i], roll_t[i] = e, f, along, around
        limit[i] = p.friction * push * (1.0 + beyond)  # |(y, z)| / R, to second order


@kernel
def _friction(rod: Any, p: Physics) -> None:
    """Replace last step's impulses of friction by those of Coulomb's law, static = kinetic, and move the nodes.

    For each node the impulse that would stop its surface is computed; when it exceeds mu N dt the surface slips, and
    the impulse opposes its slip.  A neighbour's change of impulse reaches a node through their common segment's spin,
    one step late; where the rod sticks these corrections die out geometrically and nothing creeps.
    """
    x, y, z, vx, vy, vz, lost = rod["x"], rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"], rod["lost_friction"]
    px, pt, spin, ey, ez = rod["px"], rod["pt"], rod["spin"], rod["ey"], rod["ez"]
    spin_impulse, spin_change = rod["spin_impulse"], rod["spin_change"]
    roll_x, roll_t, limit, old_x, old_t = rod["roll_x"], rod["roll_t"], rod["limit"], rod["slip_x"], rod["slip_t"]
    step, half_radius = p.step, 0.5 * p.radius
    mobility = 1.0 + p.mass * p.radius * p.radius / p.inertia  # speed an impulse gives a surface that spins, too
    share, weight = 1.0 / mobility, 3.0 * mobility * mobility
    for i in range(p.segments + 1):
        surface = half_radius * (spin[i] + spin[i + 1])
        across = vy[i] * ey[i] + vz[i] * ez[i]
        free_x = vx[i] + surface * roll_x[i] - px[i]
        free_t = across + surface * roll_t[i] - mobility * pt[i]
        stop_x, stop_t = -free_x, -share * free_t
        # Fast slip is opposed along its own direction, slip that is about to stop along the impulse that stops it;
        # between the two the direction changes smoothly.
        square, squared_limit = free_x * free_x + free_t * free_t, limit[i] * limit[i]
        slip_x, slip_t = (
            -free_x * (square + mobility * weight * squared_limit),
            -free_t * (square + weight * squared_limit),
        )
        scale = limit[i] / (math.sqrt(slip_x * slip_x + slip_t * slip_t) + _TINY)
        sticks = stop_x * stop_x + stop_t * stop_t <= squared_limit
        new_x = stop_x if sticks else scale * slip_x
        new_t = stop_t if sticks else scale * slip_t
        left_x, left_t = free_x + new_x, free_t + mobility * new_t
        lost[i] -= 0.5 * (new_x * (old_x[i] + left_x) + new_t * (old_t[i] + left_t))
        old_x[i], old_t[i] = left_x, left_t
        dx, dt = new_x - px[i], new_t - pt[i]
        px[i], pt[i] = new_x, new_t
        new = new_x * roll_x[i] + new_t * roll_t[i]
        spin_change[i] = new - spin_impulse[i]
        spin_impulse[i] = new
        u, v, w = vx[i] + dx, vy[i] + dt * ey[i], vz[i] + dt * ez[i]
        vx[i], vy[i], vz[i] = u, v, w
        x[i] += step * u
        y[i] += step * v
        z[i] += step * w


@kernel
def _decay(rod: Any, p: Physics) -> None:
    """Damp every velocity for half a step and add up the energy lost."""
    vx, vy, vz, lost = rod["vx"], rod["vy"], rod["vz"], rod["lost_damping"]
    w1, w2, w3, lost_turning = rod["w1"], rod["w2"], rod["w3"], rod["lost_turning"]
    factor = p.decay
    share = 0.5 * (1.0 - factor * factor)
    for i in range(p.segments + 1):
        lost[i] += share * (vx[i] * vx[i] + vy[i] * vy[i] + vz[i] * vz[i])
        vx[i] *= factor
        vy[i] *= factor
        vz[i] *= factor
    for i in range(p.segments):
        square = w2[i] * w2[i] + w3[i] * w3[i]
        lost_turning[i] += share * (p.inertia * w1[i] * w1[i] + p.cross_inertia * square)
        w1[i] *= factor
        w2[i] *= factor
        w3[i] *= factor


@kernel
def drift(rod: Any, time: float, p: Physics) -> None:
    """Move nodes and turn segments with their velocities for ``time``, which may be negative."""
    x, y, z, vx, vy, vz = rod["x"], rod["y"], rod["z"], rod["vx"], rod["vy"], rod["vz"]
    for i in range(p.segments + 1):
        x[i] += time * vx[i]
        y[i] += time * vy[i]
        z[i] += time * vz[i]
    _rotate(rod, False, time, p)


@kernel
def advance(rod: Any, steps: int, p: Physics) -> None:
    """Carry a rod whose positions are half a step ahead through ``steps`` steps, and count them on its clock."""
    n, vx = p.segments, rod["vx"]
    first = int(rod["clock"][0])
    for number in range(first, first + steps):
        force = p.mean + p.amplitude * math.sin(p.frequency * (number + 0.5) * p.step)
        if p.decay != 1.0:
            _decay(rod, p)
        speed = vx[0] - vx[n]
        _moments(rod, p)
        if p.friction > 0.0:
            _segment_forces(rod, True, p)
            _fill_ghost_cells(rod, n, force)
            _contact(rod, p)
            rod["limit"][0] = rod["limit"][n] = 0.0  # the hinge bears the ends, not the wall
            _friction(rod, p)
        else:
            _segment_forces(rod, False, p)
            _fill_ghost_cells(rod, n, force)
            _frictionless_step(rod, p)
        _hold_ends(rod, p)
        rod["work"][0] += 0.5 * p.step * force * (speed + vx[0] - vx[n])
        if p.decay != 1.0:
            _decay(rod, p)
        _rotate(rod, p.friction > 0.0, p.step, p)
    rod["clock"][0] = first + steps


def physics(mesh: DiscreteRod, load: fr.AxialLoad, step: float, friction: float) -> Physics:
    """Return what the kernels compute with, for the rod, the contact and the number of segments of ``mesh``."""
    rod, mass, length = mesh.rod, mesh.segment_mass, mesh.segment_length
    plain = {"gravity": rod.gravity, "damping_rate": rod.damping_rate}
    if rod != fr.Rod(rod.youngs_modulus, rod.density, rod.radius, rod.length, rod.channel_radius, **plain):
        raise ValueError(f"the former simulator takes solid, horizontal, hinged rods without fluids, got {rod}")
    return Physics(
        segments=mesh.segments,
        step=step,
        segment=length,
        mass=mass,
        inertia=0.5 * mass * rod.radius**2,
        cross_inertia=mass * (rod.radius**2 / 4.0 + length**2 / 12.0),
        stretch=rod.youngs_modulus * rod.area,
        shear=_shear_rigidity(mesh),
        bend=rod.flexural_rigidity,
        twist=mesh.torsional_rigidity,
        radius=rod.radius,
        radial_clearance=rod.radial_clearance,
        gravity=rod.gravity,
        contact=mesh.contact_stiffness,
        contact_damping=mesh.contact_time,
        friction=friction,
        decay=math.exp(-rod.damping_rate * step),
        mean=load.mean,
        amplitude=load.amplitude,
        frequency=load.frequency,
    )


def critical_time_step(mesh: DiscreteRod, impact_speed: float) -> float:
    """Return the largest stable time step in s, with the simulator's margin."""
    rod, length, mass, rigidity = mesh.rod, mesh.segment_length, mesh.segment_mass, _shear_rigidity(mesh)
    inertia = mass * (rod.radius**2 / 4.0 + length**2 / 12.0)
    stretch = 4.0 * rod.youngs_modulus / (rod.density * length**2)
    a, c = 4.0 * rigidity / length / mass, (rigidity * length + 4.0 * rod.flexural_rigidity / length) / inertia
    shear = 0.5 * (a + c) + math.sqrt(0.25 * (a - c) ** 2 + 4.0 * rigidity**2 / (mass * inertia))
    speed2 = 4.0 * rod.gravity * rod.radial_clearance + impact_speed**2
    depth = mesh.depth_at_rest + (1.25 * speed2 / mesh.contact_stiffness) ** 0.4
    contact = 1.5 * mesh.contact_stiffness * math.sqrt(depth)
    frequency = math.sqrt(max(stretch, shear) + contact)
    ratio = 0.5 * mesh.contact_stiffness * math.sqrt(depth) * mesh.contact_time / frequency
    return SAFETY * 2.0 / frequency * (math.sqrt(1.0 + ratio**2) - ratio)


def start(problem: fr.SimulationProblem) -> Any:
    """Return the record of a rod on the floor, squeezed by the mean force, with the speeds of its perturbation."""
    mesh, n = problem.mesh, problem.segments
    rod = np.zeros(1, rod_type(n))[0]
    squeezed = 1.0 - problem.load.mean / (mesh.rod.youngs_modulus * mesh.rod.area)
    rod["x"][: n + 1] = (np.arange(n + 1) / n - 0.5) * (mesh.rod.length * squeezed)
    rod["z"][: n + 1] = -(mesh.rod.radial_clearance + mesh.depth_at_rest)
    rod["q0"][:n] = 1.0
    rod["vy"][: n + 1] = rod["slip_t"][: n + 1] = problem.perturbation.velocities(n)
    rod["w3"][:n] = np.diff(rod["vy"][: n + 1]) / mesh.segment_length
    for place, node in enumerate((0, n)):
        rod["anchor"][2 * place : 2 * place + 2] = rod["y"][node], rod["z"][node]
    return rod


def simulate(problem: fr.SimulationProblem) -> fr.Simulation:
    """Return what the former simulator makes of a problem; its energies and forces at the ends are left out."""
    speed = float(np.abs(problem.perturbation.velocities(problem.segments)).max())
    largest = critical_time_step(problem.mesh, speed)
    between = math.ceil(problem.duration / (problem.frames - 1) / largest)
    steps = TimeSteps.between_frames(problem.duration, problem.frames, between, "choice")
    constants = physics(problem.mesh, problem.load, steps.size, problem.friction)
    rod, nodes = start(problem), slice(problem.segments + 1)
    run = compiled_for(advance, rod, 1, constants)
    move = compiled(drift)
    move(rod, 0.5 * steps.size, constants)
    positions, velocities = np.empty((2, problem.frames, problem.segments + 1, 3))
    began = time.perf_counter()
    for frame in range(problem.frames):
        now = rod.copy()
        move(now, -0.5 * steps.size, constants)
        for axis, name in enumerate("xyz"):
            positions[frame, :, axis], velocities[frame, :, axis] = now[name][nodes], now[f"v{name}"][nodes]
        if frame + 1 < problem.frames:
            run(rod, steps.per_frame, constants)
    motion = RecordedMotion(
        time=np.arange(problem.frames) * (steps.per_frame * steps.size),
        positions=positions,
        velocities=velocities,
        end_forces=np.zeros((problem.frames, 2)),
        energy={},
        ended="duration",
        seconds=time.perf_counter() - began,
    )
    return fr.Simulation(problem=problem, time_steps=steps, **vars(motion))


def _shear_rigidity(mesh: DiscreteRod) -> float:
    """Return K G A in N, with Cowper's factor of a circle, J. Appl. Mech. 33 (1966) 335."""
    ratio = mesh.poisson_ratio
    return 6.0 * (1.0 + ratio) / (7.0 + 6.0 * ratio) * mesh.shear_modulus * mesh.rod.area
