"""A discretised rod driven by the kernels alone, for tests that want no gravity, no wall or a state of their own."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

import floquetrod as fr
from floquetrod._util.compilation import compiled
from floquetrod.simulation.driving import Driving
from floquetrod.simulation.kernels import rod_step
from floquetrod.simulation.rod_mesh import DiscreteRod
from floquetrod.simulation.rod_record import FIRST, Physics
from floquetrod.simulation.step_size import critical_time_step
from tests.inside import friction_along

SHORT = fr.Rod(youngs_modulus=68e9, density=6500.0, radius=0.8e-3, length=0.4, channel_radius=4.7e-3)
"""A piece of the reference rod, shorter than half a wave of its critical mode."""

LOOSE = SHORT.replace(ends="free")
"""The same with ends that nothing holds."""

AT_REST = fr.AxialLoad(0.0, 0.0, 1.0)
FREE_SPACE = {"gravity": 0.0, "contact": 0.0}
"""Physics without weight and wall."""

ALONG = (1.0, 0.0, 0.0)
"""The direction of the channel."""

ENDS = ("hinged", "clamped", "guided", "free")
ELASTIC = ("stretch", "bend", "twist")


def drive(
    mesh: DiscreteRod,
    seconds: float,
    start: Callable[[Any], None],
    *,
    samples: int = 200,
    load: fr.AxialLoad = AT_REST,
    friction: float = 0.0,
    part_of_step: float = 1.0,
    **changes: float,
) -> tuple[np.ndarray, list[Any]]:
    """Return times and records of a rod that ``start`` has put into its first state."""
    step = critical_time_step(mesh)[0] * part_of_step
    count = math.ceil(seconds / samples / step)
    step = seconds / samples / count
    rod, physics = at_start(mesh, step, load, friction, **changes)
    start(rod)
    hold(mesh, rod)
    advance, drift = compiled(rod_step.advance), compiled(rod_step.drift)
    drift(rod, 0.5 * step, mesh.segments)
    records = []
    for sample in range(samples + 1):
        record = rod.copy()
        drift(record, -0.5 * step, mesh.segments)
        records.append(record)
        if sample < samples:
            advance(rod, count, physics)
    return np.arange(samples + 1) * (count * step), records


def at_start(
    mesh: DiscreteRod, step: float, load: fr.AxialLoad = AT_REST, friction: float = 0.0, **changes: float
) -> tuple[Any, Physics]:
    """Return the record of a rod at rest on the floor, and its physics."""
    driving = Driving(mesh.rod, load)
    return (
        mesh.start(driving, np.zeros(mesh.segments + 1), friction),
        mesh.physics(driving, step, friction_along(friction))._replace(**changes),
    )


def hold(mesh: DiscreteRod, rod: Any) -> None:
    """Hold the ends where they are."""
    for place, node in enumerate((FIRST, FIRST + mesh.segments)):
        rod["anchor"][3 * place + 1 : 3 * place + 3] = rod["y"][node], rod["z"][node]


def energies(mesh: DiscreteRod, rod: Any) -> dict[str, float]:
    """Return the energies of a rod that no force pushes."""
    return mesh.energies(rod, Driving(mesh.rod, AT_REST))


def elastic(mesh: DiscreteRod, rod: Any) -> float:
    """Return the elastic energy of a rod."""
    found = energies(mesh, rod)
    return sum(found[name] for name in ELASTIC)


def places(mesh: DiscreteRod) -> np.ndarray:
    """Return the places of the nodes from 0 to 1."""
    return np.arange(mesh.segments + 1) / mesh.segments


def shaken(mesh: DiscreteRod, rng: np.random.Generator, size: float = 0.1) -> Any:
    """Return a rod with every node displaced and spun at random."""
    rod, _ = at_start(mesh, 1.0)
    for axis, scale in (
        ("x", mesh.segment_length),
        ("y", mesh.segment_length),
        ("z", mesh.segment_length),
        ("angle", 1),
    ):
        mesh.nodes(rod, axis)[:] += size * scale * rng.uniform(-1, 1, mesh.segments + 1)
    hold(mesh, rod)
    return rod


def become(rod: Any, other: Any) -> None:
    """Copy a record into another."""
    for name in rod.dtype.names:
        rod[name][:] = other[name]


def frequency(time: np.ndarray, values: np.ndarray, guess: float) -> float:
    """Return the frequency in rad/s of a cosine near ``guess``."""
    from scipy.optimize import curve_fit

    def cosine(t: np.ndarray, a: float, b: float, w: float) -> np.ndarray:
        return a * np.cos(w * t) + b * np.sin(w * t)

    size = np.abs(values).max()
    (_, _, found), _ = curve_fit(cosine, time, values / size, p0=[1.0, 0.0, guess])
    return float(found)


def bend(mesh: DiscreteRod, rod: Any, y: np.ndarray) -> None:
    """Put nodes at ``y`` across the channel, on the floor."""
    rest = mesh.rod.radial_clearance + mesh.depth_at_rest
    mesh.nodes(rod, "y")[:] = y
    mesh.nodes(rod, "z")[:] = -np.sqrt(rest**2 - y**2)


def stiffness(mesh: DiscreteRod, axis: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the stiffness matrix of a straight rod for small displacements along an axis, and the masses of its nodes.

    From the kernel's gradient by central differences; nodes at ends held across the channel are left out.
    """
    n, nodes = mesh.segments, slice(FIRST, FIRST + mesh.segments + 1)
    rod, physics = at_start(mesh, 1.0, **FREE_SPACE)
    mesh.nodes(rod, "z")[:] = 0.0
    mesh.nodes(rod, "x")[:] = mesh.places - 0.5 * mesh.rod.length
    gradient = compiled(rod_step.gradient)
    # Across, the square of a displacement over the radius, which stretching adds, is 1e-12; along, all is linear.
    small = 1e-3 * mesh.segment_length if axis == "x" else 1e-6 * mesh.rod.radius
    matrix = np.zeros((n + 1, n + 1))
    for j in range(n + 1):
        for sign in (1.0, -1.0):
            moved = rod.copy()
            moved[axis][FIRST + j] += sign * small
            gradient(moved, physics, (ALONG, ALONG), 0.0, 0.0)
            force = moved[{"x": "f1", "y": "f2", "z": "f3"}[axis]]
            here, left = force[nodes], force[FIRST - 1 : FIRST + n]
            far = force[FIRST + 1 : FIRST + n + 2] - force[FIRST - 2 : FIRST + n - 1]
            matrix[:, j] -= sign * (27.0 * (here - left) - far) / 24.0 / (2.0 * small)
    masses = (mesh.mass_along if axis == "x" else mesh.segment_mass) * mesh.nodes(rod, "share")
    kept = np.ones(n + 1, dtype=bool)
    if axis != "x":
        ends = mesh.rod.end_conditions
        kept[[0, n]] = [end not in ("hinged", "clamped") for end in (ends.upper, ends.lower)]
    return matrix[np.ix_(kept, kept)], masses[kept]


def frequencies(mesh: DiscreteRod, axis: str) -> np.ndarray:
    """Return the natural frequencies in rad/s of a straight rod for small displacements along an axis, ascending."""
    from scipy.linalg import eigh

    matrix, masses = stiffness(mesh, axis)
    return np.sqrt(np.maximum(eigh(0.5 * (matrix + matrix.T), np.diag(masses), eigvals_only=True), 0.0))
