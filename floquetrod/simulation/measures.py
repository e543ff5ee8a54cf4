"""What the frames of a simulated rod say about forces: of the wall on it, and along it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from floquetrod.simulation.driving import Driving
from floquetrod.simulation.rod_mesh import DiscreteRod


def contact_force(
    mesh: DiscreteRod, positions: NDArray[np.float64], velocities: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the force per length in N/m with which the wall pushes every node of every frame, (frames, nodes).

    By the law of the kernels: k sqrt(d) (d + C d') for the mass in motion across.
    """
    gap = mesh.clearance_at(positions[..., 0])
    y, z, vy, vz = (part[..., axis] / gap for part in (positions, velocities) for axis in (1, 2))
    square = y * y + z * z
    depth = np.maximum(0.5 * gap * (square - 1.0), 0.0)
    speed = gap * (y * vy + z * vz)
    push = np.maximum(mesh.contact_stiffness * np.sqrt(depth) * (depth + mesh.contact_time * speed), 0.0)
    return np.asarray(mesh.mass_per_length * push * np.sqrt(square))


def axial_force(mesh: DiscreteRod, driving: Driving, positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the compression in N in the middle of every segment of every frame, (frames, segments)."""
    lengths = np.array([np.linalg.norm(mesh.tangents(mesh.cartesian(places), driving), axis=1) for places in positions])
    return np.asarray(mesh.axial_rigidity * (1.0 - lengths / mesh.segment_length))
