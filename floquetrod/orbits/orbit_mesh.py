"""Meshes of periodic orbits: where errors are equal, and orbits moved from one to another."""

from __future__ import annotations

import functools
import math
from dataclasses import replace

import numpy as np

from floquetrod._util.arrays import Floats, norms
from floquetrod.floquet.multipliers import independent_solutions
from floquetrod.orbits.collocation import Collocation, Point, gauss, weights_at

FEWEST, MOST = 8, 1024
"""Intervals of a mesh."""

_REACHES = {8: 2.5, 6: 1.2}
"""Rate times length of an interval that a degree follows to about 1e-12: the error of its Pade approximant."""

FOLLOWED = 1.5
"""Rate times length of an interval, in the unit of `_REACHES`, up to which deviations are followed to about 1e-12."""

_USUAL = 1e-10  # tolerance of the states up to which they are followed that well

_FLOOR = 0.15  # of the mean density that there is everywhere (a choice)
_SAFETY = 1.15  # more intervals than the estimate asks for


def evaluated(collocation: Collocation, point: Point, shares: Floats) -> Floats:
    """Return the states (k, n) at shares of the period (k,), from 0 to 1."""
    place = np.clip(np.searchsorted(collocation.mesh, shares, side="right") - 1, 0, len(point.nodes) - 1)
    inner = (shares - collocation.mesh[place]) / collocation.steps[place]
    factors = weights_at(collocation.degree, inner)
    values = np.concatenate([point.nodes[:, None], point.stages], axis=1)
    return np.asarray(np.einsum("kj,kjn->kn", factors, values[place]))


def evaluated_within(point: Point, shares: tuple[float, ...]) -> Floats:
    """Return the states (N, k, n) at the same shares of every interval."""
    values = np.concatenate([point.nodes[:, None], point.stages], axis=1)
    return np.asarray(_factors(point.stages.shape[1], shares) @ values)


@functools.lru_cache(64)
def _factors(degree: int, shares: tuple[float, ...]) -> Floats:
    return weights_at(degree, np.array(shares))


def between_points(values: Floats, degree: int) -> Floats:
    """Return values (N, m, n) at the Gauss points at those of another degree, by the polynomials through them."""
    return np.asarray(_point_factors(values.shape[1], degree) @ values)


@functools.cache
def _point_factors(degree: int, other: int) -> Floats:
    from numpy.polynomial import legendre

    given, wanted = (legendre.legvander(2.0 * gauss(each).points - 1.0, degree - 1) for each in (degree, other))
    return np.asarray(wanted @ np.linalg.inv(given))


def carried(collocation: Collocation, point: Point, mesh: Floats, degree: int) -> tuple[Collocation, Point]:
    """Return the equations on another mesh or of another degree, and a point there with the same states."""
    other = replace(collocation, mesh=mesh, degree=degree)
    if mesh is collocation.mesh:
        return other, point._replace(stages=evaluated_within(point, tuple(gauss(degree).points.tolist())))
    count = len(mesh) - 1
    values = evaluated(collocation, point, np.concatenate([mesh[:-1], other.shares.ravel()]))
    return other, point._replace(nodes=values[:count], stages=values[count:].reshape(count, degree, -1))


def interior_errors(collocation: Collocation, point: Point) -> Floats:
    """Return estimates (N,) of the largest error of the polynomials in each interval, as a fraction of the states.

    From the derivative of order m + 1, estimated by differences of the m-th derivative between intervals
    (C. de Boor, Lecture Notes in Math. 363 (1974) 12).
    """
    m, steps = collocation.degree, collocation.steps
    series = gauss(m).to_series[-1]
    last = (series[0] * point.nodes + np.einsum("j,ijn->in", series[1:], point.stages)) / point.scale
    leading = math.comb(2 * m, m) / 2.0**m * math.factorial(m)  # of the Legendre polynomial's derivative
    top = last * (leading * (2.0 / steps) ** m)[:, None]
    jumps = np.abs(np.diff(top, axis=0, prepend=top[-1:])).max(axis=1) / collocation.weights
    next_one = np.maximum(jumps, np.append(jumps[1:], jumps[0]))
    return np.asarray(_constant(m) * steps ** (m + 1) * next_one)


@functools.cache
def _constant(degree: int) -> float:
    """Return the factor of h^(m + 1) times the derivative of order m + 1 in the error within an interval."""
    product = np.polynomial.Polynomial.fromroots(gauss(degree).points)
    return float(np.abs(product.integ()(np.linspace(0.0, 1.0, 201))).max()) / math.factorial(degree)


def least_density(collocation: Collocation, jacobians: Floats, tolerance: float) -> Floats:
    """Return how many intervals for each unit of the period it takes for deviations from the orbit, by intervals (N,).

    They may turn and decay far faster than the orbit does.  No more than half of all intervals that there may be.
    Where the orbit may have larger errors, so may they: the error goes like the length to the power 2 m + 1.
    """
    largest = np.abs(jacobians).max(axis=(0, 1))
    scales = independent_solutions.balance(largest)
    sizes = norms(jacobians * scales / scales[:, None]).max(axis=1)
    longer = max(1.0, tolerance / _USUAL) ** (1.0 / (2 * collocation.degree + 1))
    density = sizes / (_REACHES[collocation.degree] * longer)
    return np.asarray(density * min(1.0, 0.5 * MOST / max(float((density * collocation.steps).sum()), 1e-300)))


def adapted(collocation: Collocation, point: Point, jacobians: Floats, tolerance: float) -> Floats | None:
    """Return a mesh that resolves an orbit and is not much finer; None where its own mesh does.

    ``jacobians`` (N, m, n, n) are the derivatives of f at the Gauss points.
    """
    errors = interior_errors(collocation, point)
    least = least_density(collocation, point.period * jacobians, tolerance)
    mesh = equidistributed(collocation, errors, 0.3 * tolerance, least)
    rough = float(errors.max()) > tolerance or float((least * collocation.steps).max()) > FOLLOWED
    if (rough and len(errors) < MOST) or len(mesh) <= 0.6 * len(collocation.mesh):
        return mesh
    return None


def equidistributed(collocation: Collocation, errors: Floats, tolerance: float, least: Floats) -> Floats:
    """Return a mesh on which errors within intervals are about equal, and as small as the tolerance.

    ``least`` is a density that there is at least.
    """
    power = 1.0 / (collocation.degree + 1)
    share = (np.maximum(errors, 1e-18) / tolerance) ** power
    density = np.maximum(share / collocation.steps, least)
    beside = np.maximum(np.append(density[-1:], density[:-1]), np.append(density[1:], density[0]))
    smooth = np.maximum(density, 0.5 * beside)
    smooth = smooth + _FLOOR * float(smooth @ collocation.steps)
    wanted = min(_SAFETY * float(smooth @ collocation.steps), max(64.0, 2.0 * len(errors)))
    return of_density(collocation.mesh, smooth, wanted)


def of_density(mesh: Floats, density: Floats, wanted: float) -> Floats:
    """Return a mesh of about so many intervals, a multiple of four, with a density given between points of another."""
    count = min(MOST, max(FEWEST, 4 * math.ceil(0.25 * min(wanted, MOST))))
    integral = np.concatenate([[0.0], np.cumsum(density * np.diff(mesh))])
    nodes = np.interp(np.linspace(0.0, integral[-1], count + 1), integral, mesh)
    nodes[0], nodes[-1] = 0.0, 1.0
    return nodes
