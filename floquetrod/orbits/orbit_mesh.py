"""Meshes of periodic orbits: where errors are equal, and orbits moved from one to another."""

from __future__ import annotations

import functools
import math
from dataclasses import replace

import numpy as np

from floquetrod._util.arrays import Floats, norms
from floquetrod.floquet.multipliers import independent_solutions
from floquetrod.orbits.collocation import Collocation, Point, gauss, weights_at
from floquetrod.orbits.kernels import orbit_errors

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


def differences(collocation: Collocation, fine: Point, coarse: Point, shares: tuple[float, ...]) -> Floats:
    """Return the largest difference of two orbits in each interval (N,), as a fraction of the states.

    At the beginnings of intervals and at shares of them; ``collocation`` has the equations of the finer orbit.
    """
    scale, run = fine.scale, collocation.machine_code_of(orbit_errors.compared_fill, fine)
    if run is not None:
        errors, factors = np.empty(len(fine.nodes)), (_factors(each.stages.shape[1], shares) for each in (fine, coarse))
        run(fine.nodes, fine.stages, next(factors), coarse.nodes, coarse.stages, next(factors), scale, errors)
        return errors
    gaps = np.abs(evaluated_within(fine, shares) - evaluated_within(coarse, shares))
    nodes = np.abs(fine.nodes - coarse.nodes)
    return np.asarray(np.maximum((gaps / scale).max(axis=(1, 2)), (nodes / scale).max(axis=1)))


@functools.lru_cache(64)
def _factors(degree: int, shares: tuple[float, ...]) -> Floats:
    return weights_at(degree, np.array(shares))


def between_points(values: Floats, degree: int) -> Floats:
    """Return values (N, m, n) at the Gauss points, by polynomials through values at points of another degree."""
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
    top = last * (_leading(m) * (2.0 / steps) ** m)[:, None]
    jumps = np.abs(np.diff(top, axis=0, prepend=top[-1:])).max(axis=1) / collocation.weights
    next_one = np.maximum(jumps, np.append(jumps[1:], jumps[0]))
    return np.asarray(_constant(m) * steps ** (m + 1) * next_one)


@functools.cache
def _leading(degree: int) -> float:
    """Return the derivative of this order of the Legendre polynomial of this degree."""
    return math.comb(2 * degree, degree) / 2.0**degree * math.factorial(degree)


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
    density = sizes / _reach(collocation.degree, tolerance)
    return np.asarray(density * min(1.0, 0.5 * MOST / max(float((density * collocation.steps).sum()), 1e-300)))


def _reach(degree: int, tolerance: float) -> float:
    """Return the rate times length of an interval that a degree follows as accurately as a tolerance needs."""
    return float(_REACHES[degree] * max(1.0, tolerance / _USUAL) ** (1.0 / (2 * degree + 1)))


def adapted(collocation: Collocation, point: Point, jacobians: Floats, tolerance: float) -> Floats | None:
    """Return a mesh that resolves an orbit and is not much finer; None where its own mesh does.

    ``jacobians`` (N, m, n, n) are the derivatives of f at the Gauss points.
    """
    errors, least, largest, followed = _needs(collocation, point, jacobians, tolerance)
    density, wanted = _densities(collocation, errors, 0.3 * tolerance, least)
    rough = largest > tolerance or followed > FOLLOWED
    if (rough and len(errors) < MOST) or _count(wanted) + 1 <= 0.6 * len(collocation.mesh):
        return of_density(collocation.mesh, density, wanted)
    return None


def _needs(
    collocation: Collocation, point: Point, jacobians: Floats, tolerance: float
) -> tuple[Floats, Floats, float, float]:
    """Return `interior_errors`, `least_density`, the largest error, and the most that deviations turn in an interval.

    ``jacobians`` as of `adapted`.
    """
    run = collocation.machine_code_of(orbit_errors.interior_fill, point)
    follow = collocation.machine_code_of(orbit_errors.density_fill, point)
    if run is None or follow is None:
        errors = interior_errors(collocation, point)
        least = least_density(collocation, point.period * jacobians, tolerance)
        return errors, least, float(errors.max()), float((least * collocation.steps).max())
    (count, n), m, steps = point.nodes.shape, collocation.degree, collocation.steps
    tops, largest, errors, least, most = (np.empty(shape) for shape in ((count, n), (n, n), count, count, 2))
    leading = (gauss(m).to_series[-1], steps, collocation.weights, point.scale, _leading(m), _constant(m))
    run(point.nodes, point.stages, *leading, jacobians, tops, largest, errors)
    scales = independent_solutions.balance(largest) if n > 1 else np.ones(1)
    follow(jacobians, scales, steps, _reach(m, tolerance) / point.period, 0.5 * MOST, errors, least, most)
    return errors, least, float(most[0]), float(most[1])


def equidistributed(collocation: Collocation, errors: Floats, tolerance: float, least: Floats) -> Floats:
    """Return a mesh on which errors within intervals are about equal, and as small as the tolerance.

    ``least`` is a density that there is at least.
    """
    return of_density(collocation.mesh, *_densities(collocation, errors, tolerance, least))


def _densities(collocation: Collocation, errors: Floats, tolerance: float, least: Floats) -> tuple[Floats, float]:
    """Return the density (N,) of the mesh of `equidistributed`, and about how many intervals it has."""
    power = 1.0 / (collocation.degree + 1)
    share = (np.maximum(errors, 1e-18) / tolerance) ** power
    density = np.maximum(share / collocation.steps, least)
    smooth = np.empty(len(density))
    np.maximum(density[:-1], 0.5 * density[1:], out=smooth[:-1])
    smooth[-1] = max(density[-1], 0.5 * density[0])
    np.maximum(smooth[1:], 0.5 * density[:-1], out=smooth[1:])
    smooth[0] = max(smooth[0], 0.5 * density[-1])
    smooth += _FLOOR * float(smooth @ collocation.steps)
    return smooth, min(_SAFETY * float(smooth @ collocation.steps), max(64.0, 2.0 * len(errors)))


def of_density(mesh: Floats, density: Floats, wanted: float) -> Floats:
    """Return a mesh of about so many intervals, a multiple of four, with a density given between points of another."""
    count = _count(wanted)
    integral = np.concatenate([[0.0], np.cumsum(density * np.diff(mesh))])
    nodes = np.interp(np.linspace(0.0, integral[-1], count + 1), integral, mesh)
    nodes[0], nodes[-1] = 0.0, 1.0
    return nodes


def _count(wanted: float) -> int:
    """Return a number of intervals, a multiple of four, about as large as wanted."""
    return min(MOST, max(FEWEST, 4 * math.ceil(0.25 * min(wanted, MOST))))
