"""Kernels for the errors of an orbit on its mesh: of its polynomials, of its maps, and what the mesh must resolve.

They compute for branches of few equations what `orbit_mesh.interior_errors`, `orbit_mesh.least_density` and
`finding.comparison` compute with numpy for single orbits; the formulas stand there.
"""

from __future__ import annotations

import math
from typing import Any

from floquetrod._util.compilation import kernel


@kernel
def interior_fill(
    nodes: Any, stages: Any, series: Any, steps: Any, weights: Any, scale: Any, leading: float, constant: float,
    jacobians: Any, tops: Any, largest: Any, errors: Any,
) -> None:  # fmt: skip
    """Fill ``errors`` (N,) of the polynomials within intervals, and the ``largest`` magnitudes (n, n) of derivatives.

    ``series`` (m + 1,) leads from values at 0 and the Gauss points to the last coefficient of Legendre's polynomials,
    ``leading`` times (2 / h)^m from there to the m-th derivative, which fills ``tops`` (N, n).
    """
    count, m, n = stages.shape
    for a in range(n):
        for b in range(n):
            largest[a, b] = 0.0
    for i in range(count):
        factor = leading * (2.0 / steps[i]) ** m
        for a in range(n):
            total = series[0] * nodes[i, a]
            for j in range(m):
                total += series[j + 1] * stages[i, j, a]
                for b in range(n):
                    size = abs(jacobians[i, j, a, b])
                    if size > largest[a, b] or size != size:
                        largest[a, b] = size
            tops[i, a] = total / scale[a] * factor
    for i in range(count):
        errors[i] = 0.0
    for i in range(count):
        before, jump = (i - 1) % count, 0.0
        for a in range(n):
            jump = max(jump, abs(tops[i, a] - tops[before, a]))
        jump /= weights[i]
        errors[i] = max(errors[i], jump)
        errors[before] = max(errors[before], jump)
    for i in range(count):
        errors[i] *= constant * steps[i] ** (m + 1)


@kernel
def density_fill(
    jacobians: Any, scales: Any, steps: Any, unit: float, most: float, errors: Any, least: Any, followed: Any
) -> None:
    """Fill the density ``least`` (N,), at most ``most`` intervals in all, by norms of the derivatives over ``unit``.

    And ``followed`` with the largest of the ``errors`` (N,), and of the density times the length of an interval.
    """
    count, m, n = jacobians.shape[:3]
    total = 1e-300
    for i in range(count):
        largest = 0.0
        for j in range(m):
            square = 0.0
            for a in range(n):
                for b in range(n):
                    entry = jacobians[i, j, a, b] * scales[b] / scales[a]
                    square += entry * entry
            largest = max(largest, square)
        least[i] = math.sqrt(largest) / unit
        total += least[i] * steps[i]
    share = min(1.0, most / total)
    followed[0], followed[1] = 0.0, 0.0
    for i in range(count):
        least[i] *= share
        followed[0] = max(followed[0], errors[i])
        followed[1] = max(followed[1], least[i] * steps[i])


@kernel
def compared_fill(
    fine_nodes: Any, fine_stages: Any, fine_factors: Any, nodes: Any, stages: Any, factors: Any, scale: Any,
    errors: Any,
) -> None:  # fmt: skip
    """Fill ``errors`` (N,): the largest difference of two polynomials in each interval, as a fraction of the states.

    At its beginning, and at as many places as the factors have rows, (k, m + 1) of values at 0 and Gauss points.
    """
    count, n = nodes.shape
    for i in range(count):
        largest = 0.0
        for a in range(n):
            largest = max(largest, abs(fine_nodes[i, a] - nodes[i, a]) / scale[a])
            for k in range(len(factors)):
                total = fine_factors[k, 0] * fine_nodes[i, a] - factors[k, 0] * nodes[i, a]
                for j in range(fine_stages.shape[1]):
                    total += fine_factors[k, j + 1] * fine_stages[i, j, a]
                for j in range(stages.shape[1]):
                    total -= factors[k, j + 1] * stages[i, j, a]
                largest = max(largest, abs(total) / scale[a])
        errors[i] = largest


@kernel
def doubts_fill(
    lengths: Any, weights: Any, jacobians: Any, moved: Any, share: float, relative: float, maps: Any, coarse: Any,
    errors: Any,
) -> float:  # fmt: skip
    """Fill the ``errors`` (N, n, n) of maps, from ``coarse`` ones and from errors of the derivatives along the orbit.

    These are ``share`` of their change to ``moved`` and a ``relative`` part of them.  Return the integral over the
    period of their trace.
    """
    count, m, n = jacobians.shape[:3]
    trace = 0.0
    for i in range(count):
        stretch = 0.0
        for a in range(n):
            for b in range(n):
                total, largest = 0.0, 0.0
                for k in range(m):
                    size = abs(jacobians[i, k, a, b])
                    largest = max(largest, size)
                    total += weights[k] * (share * abs(moved[i, k, a, b] - jacobians[i, k, a, b]) + relative * size)
                errors[i, a, b] = lengths[i] * total
                stretch += (lengths[i] * largest) ** 2
                if a == b:
                    trace += lengths[i] * total
        grown = math.exp(min(math.sqrt(stretch), 5.0))
        for a in range(n):
            for b in range(n):
                errors[i, a, b] = 2.0 * abs(maps[i, a, b] - coarse[i, a, b]) + grown * errors[i, a, b]
    return trace
