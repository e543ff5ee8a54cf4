"""Where a simulated rod rests under its load while its ends are held where another run has held them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.simulation.driving import Driving
from floquetrod.simulation.recorded_motion import angles
from floquetrod.simulation.rod_mesh import DiscreteRod
from floquetrod.simulation.rod_record import CLAMPED

_SOFTEST = 0.95  # of the critical force, to which compression counts (a choice)


def rest_angles(mesh: DiscreteRod, driving: Driving, record: Any) -> Floats:
    """Return the angle of every node at rest in rad, (nodes,), of a rod whose held ends lie as in ``record``.

    In a well another mean force presses the rod to another side, and an end that is held stays: beside it the rod is
    bent out of its rest as a beam on an elastic foundation, by small angles,

        EI theta'''' + F theta'' + m_t g / R theta = 0.
    """
    rest = angles(mesh.recorded(mesh.start(driving, np.zeros(mesh.segments + 1)))[0])
    held = angles(mesh.recorded(record)[0])
    rod, s = mesh.rod, mesh.places
    along = np.broadcast_to(mesh.mass_per_length * mesh.gravity_on_wall / mesh.clearance, s.shape)
    for node, end, distance in zip((0, -1), driving.ends, (s, rod.length - s), strict=True):
        if end.is_held:
            stiffness, bending = along[node], mesh.bending_rigidity[node]
            offset = math.remainder(held[node] - rest[node], 2.0 * math.pi)
            # theta = e^(-a s) (cos b s + C sin b s), with theta'' = 0 at a hinge and theta' = 0 at a clamp.
            p = np.clip(end.mean / (2.0 * math.sqrt(bending * stiffness)), -_SOFTEST, _SOFTEST)
            a, b = (math.sqrt(0.5 * (1.0 + sign * p)) * (stiffness / bending) ** 0.25 for sign in (-1.0, 1.0))
            c = a / b if end.across == CLAMPED else 0.5 * (a / b - b / a)
            rest = rest + offset * np.exp(-a * distance) * (np.cos(b * distance) + c * np.sin(b * distance))
    return rest
