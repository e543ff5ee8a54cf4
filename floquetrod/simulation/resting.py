"""A rod that varies along before it moves: where it rests on a wall with steps, and how it vibrates along the channel.

Both are of the linearised discrete rod, whose matrices have few diagonals.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats
from floquetrod.simulation.kernels.rod_step import FAR, NEAR, energy_of_clamped_end
from floquetrod.simulation.rod_record import CLAMPED, GUIDED

_ROUNDS = 200  # of Newton's method at most (a choice: some 20 are usual)
_SETTLED = 1e-9  # of the force that presses, up to which it is balanced
_LARGEST_STRAIN = 0.02  # of a vibration: beyond it, at a resonance, the rod starts without


def resting_radius(
    segment: float,
    bend: tuple[Floats, Floats],
    force: Floats,
    pressing: Floats,
    clearance: Floats,
    stiffness: Floats,
    ends: tuple[int, int],
) -> Floats:
    """Return the distances in m of the nodes from the channel's axis, at rest on a wall with steps.

    The least of the energy of bending, of the compression ``force`` in N of the segments, of what presses the nodes
    outwards in N/m, and of the contact, ``stiffness`` times d^1.5 in N/m; by Newton's method.  Where compression
    would lift the rod as a whole it is left out.
    """
    nodes = pressing.size
    share = np.ones(nodes)
    share[[0, -1]] = 0.5
    push, spring = share * segment * pressing, share * segment * stiffness
    slope = _derivative(nodes - 1, ends) / segment
    bending = slope.T @ _bending(*bend, ends) @ slope / segment
    for matrix in (bending - segment * slope.T @ _diagonal(force) @ slope, bending):
        q = _balanced(matrix, push, spring, clearance)
        if q is not None:
            return q
    return np.asarray(clearance)


def _balanced(matrix: Any, push: Floats, spring: Floats, clearance: Floats) -> Floats | None:
    """Return the radii at which the energy is least, None where it has no least value."""
    from scipy.linalg import solveh_banded

    bands = _upper_bands(matrix)

    def contact(q: Floats) -> tuple[float, Floats, Floats]:
        depth = np.maximum((q * q - clearance * clearance) / (2.0 * clearance), 0.0)
        root, out = np.sqrt(depth), q / clearance
        curved = 1.5 * root * out * out + depth * root / clearance
        return float(0.4 * spring @ (depth * depth * root)), spring * depth * root * out, spring * curved

    def energy(q: Floats) -> float:
        return float(0.5 * q @ (matrix @ q) - push @ q) + contact(q)[0]

    q = clearance + (push / spring) ** (2.0 / 3.0)
    least = energy(q)
    for _ in range(_ROUNDS):
        _, held, stiff = contact(q)
        slope = matrix @ q - push + held
        if np.abs(slope).max() <= _SETTLED * np.abs(push).max():
            break
        both = bands.copy()
        both[-1] += stiff
        try:
            step = solveh_banded(both, -slope)
        except np.linalg.LinAlgError:
            return None
        part = 1.0
        while part > 1e-6 and energy(q + part * step) > least + 1e-4 * part * float(slope @ step):
            part *= 0.5
        q = q + part * step
        least = energy(q)
    return np.asarray(q)


def steady_vibration(
    segment: float,
    stiffness: Floats,
    masses: Floats,
    damping_rate: float,
    frequency: float,
    harmonics: NDArray[np.complex128],
    drives: tuple[float, float | None],
) -> tuple[Floats, Floats]:
    """Return displacement in m and velocity in m/s of nodes along the channel when a steady vibration begins.

    ``stiffness`` in N/m of segments of the length ``segment``, ``masses`` in kg of the nodes; ``harmonics`` of the
    force in N that pushes the ends, each times its drive, None for a lower end that is held.  Nothing moves at a
    resonance.
    """
    from scipy.sparse import csc_matrix, eye
    from scipy.sparse.linalg import spsolve

    nodes = masses.size
    slope = _derivative(nodes - 1, (-1, -1))
    matrix = slope.T @ _diagonal(stiffness) @ slope
    upper, lower = drives
    free = nodes - 1 if lower is None else nodes
    kept = eye(nodes, free, format="csc")
    push = np.zeros(nodes, dtype=complex)
    push[0], push[-1] = upper, -(lower or 0.0)
    displacement, velocity = np.zeros(nodes), np.zeros(nodes)
    for k, harmonic in enumerate(harmonics, start=1):
        rate = k * frequency
        inertia = _diagonal(masses * complex(-(rate**2), 2.0 * damping_rate * rate))
        moved = kept @ spsolve(csc_matrix(kept.T @ (matrix + inertia) @ kept), kept.T @ (harmonic * push))
        if not np.abs(slope @ moved).max() <= _LARGEST_STRAIN * segment:
            return np.zeros(nodes), np.zeros(nodes)
        displacement += moved.real
        velocity += (1j * rate * moved).real
    return displacement, velocity


def _diagonal(values: Any) -> Any:
    """Return a diagonal matrix."""
    from scipy.sparse import diags

    return diags(values, format="csr")


def _derivative(segments: int, ends: tuple[int, int]) -> Any:
    """Return what makes of nodes the differences along the segments, of fourth order, with ghosts beyond the ends.

    These are even where an end across the channel cannot rotate, else odd.
    """
    from scipy.sparse import lil_matrix

    matrix = lil_matrix((segments, segments + 1))
    rows = np.arange(segments)
    for offset, weight in ((-1, FAR), (0, -NEAR), (1, NEAR), (2, -FAR)):
        inside = (rows + offset >= 0) & (rows + offset <= segments)
        matrix[rows[inside], rows[inside] + offset] = weight
    for row, node, inner, weight, end in (
        (0, 0, 1, FAR, ends[0]),
        (segments - 1, segments, segments - 1, -FAR, ends[1]),
    ):
        fixed = end in (CLAMPED, GUIDED)
        matrix[row, inner] += weight if fixed else -weight
        matrix[row, node] += 0.0 if fixed else 2.0 * weight
    return matrix.tocsr()


def _bending(bend: Floats, between: Floats, ends: tuple[int, int]) -> Any:
    """Return the second derivatives by the directions of segments of the energy of bending across, times l."""
    from scipy.sparse import lil_matrix

    n = between.size
    curve = lil_matrix((n + 1, n))
    inner = np.arange(1, n)
    curve[inner, inner], curve[inner, inner - 1] = 1.0, -1.0
    for node, segment, sign, end in ((0, 0, 2.0, ends[0]), (n, n - 1, -2.0, ends[1])):
        curve[node, segment] = sign if end in (CLAMPED, GUIDED) else 0.0
    weights = bend.copy()
    weights[[0, -1]] *= 0.5
    joints = 1.0 / (12.0 * between)
    own = lil_matrix((n + 1, n + 1))
    for place, node, next_one, end in ((0, 0, 1, ends[0]), (-1, n, n - 1, ends[1])):
        if end == CLAMPED:
            # In place of the bulk's energy of its last node and segment.
            first, both, other = (
                energy_of_clamped_end(*squares) for squares in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
            )
            weights[place] = joints[place] = 0.0
            own[node, node], own[next_one, next_one] = bend[place] * first, bend[place] * other
            own[node, next_one] = own[next_one, node] = 0.5 * bend[place] * both
    steps = lil_matrix((n, n + 1))
    rows = np.arange(n)
    steps[rows, rows + 1], steps[rows, rows] = bend[1:], -bend[:-1]
    steps = steps.tocsr()
    form = _diagonal(weights) + steps.T @ _diagonal(joints) @ steps + own.tocsr()
    curve = curve.tocsr()
    return curve.T @ form @ curve


def _upper_bands(matrix: Any) -> Floats:
    """Return the diagonals of a symmetric matrix as `scipy.linalg.solveh_banded` takes them."""
    entries = matrix.tocoo()
    width = int(np.abs(entries.row - entries.col).max())
    bands = np.zeros((width + 1, matrix.shape[0]))
    upper = entries.row <= entries.col
    np.add.at(bands, (width + entries.row[upper] - entries.col[upper], entries.col[upper]), entries.data[upper])
    return bands
