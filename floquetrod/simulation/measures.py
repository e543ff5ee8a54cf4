"""What the frames of a simulated rod say about forces: of the wall on it, and along it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.compilation import compiled
from floquetrod.simulation import rod_motion
from floquetrod.simulation.driving import Driving
from floquetrod.simulation.mesh import DiscreteRod


def contact_force(
    mesh: DiscreteRod, driving: Driving, positions: NDArray[np.float64], velocities: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the force per length in N/m with which the wall pushes every node of every frame, (frames, nodes).

    It is what the kernel itself makes of the wall: the change of velocity in a step of one second without weight and
    without forces inside the rod.
    """
    physics = mesh.physics(driving, 1.0)._replace(gravity=0.0, gravity_along=0.0)
    step = compiled(rod_motion.frictionless_step)
    rod = mesh.start(driving, np.zeros(mesh.segments + 1))
    found = np.empty(positions.shape[:2])
    for frame, (places, speeds) in enumerate(zip(positions, velocities, strict=True)):
        for axis, name in enumerate("xyz"):
            mesh.nodes(rod, name)[:] = places[:, axis]
            mesh.nodes(rod, f"v{name}")[:] = speeds[:, axis]
        step(rod, physics)
        across = [mesh.nodes(rod, name) - speeds[:, axis] for axis, name in ((1, "vy"), (2, "vz"))]
        found[frame] = mesh.rod.mass_per_length * np.hypot(*across)
    return found


def axial_force(mesh: DiscreteRod, driving: Driving, positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the compression in N in the middle of every segment of every frame, (frames, segments)."""
    lengths = np.array([np.linalg.norm(mesh.tangents(places, driving), axis=1) for places in positions])
    return np.asarray(mesh.rod.axial_rigidity * (1.0 - lengths / mesh.segment_length))
