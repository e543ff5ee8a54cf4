"""`fr.periodic_orbit`: the orbit near a start, on a mesh that resolves it."""

from __future__ import annotations

import contextlib
import functools
import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import EPS, Floats
from floquetrod.equations import NonlinearSystem
from floquetrod.orbits import orbit_guesses, orbit_mesh
from floquetrod.orbits.collocation import BorderRow, Collocation, Condensed, Point, gauss
from floquetrod.orbits.kernels import orbit_errors
from floquetrod.orbits.newton import Corrected, Known, NoOrbitError, corrected
from floquetrod.orbits.orbit import PeriodicOrbit
from floquetrod.orbits.orbit_multipliers import Segments

_DEGREES = ((24, 8), (10**9, 6))  # Gauss points of systems of up to so many equations (a choice)
MORE = 2  # points of the finer of the two orbits that are compared
_FIRST = (24, 120)  # intervals of the first mesh, tried in turn
_JUMPING = (480, orbit_mesh.MOST)  # likewise, of motion that jumps
_LEAST_STEPS = 0.1  # of the mean density of an integrator's steps that there is everywhere (a choice)
_MOST_MESHES = 10
_SAME = 0.1  # of a period that was given, by which the one of motion that returns may differ (a choice)
_MOST_TURNS = 1000  # of the forcing in an orbit (a choice)
_TRIALS = (0.08, 0.29, 0.5, 0.71, 0.92)  # of an interval, where the two are compared


def periodic_orbit(
    system: NonlinearSystem,
    start: Any,
    period: float | None = None,
    *,
    winding: Mapping[int, float] | None = None,
    tolerance: float = 1e-10,
) -> PeriodicOrbit:
    """Return the periodic orbit near a start, stable or not, with its error and the verdict on it.

    By collocation at Gauss points on a mesh that is made finer where the orbit needs it, and Newton's method.  A start
    nearly on an orbit, which closes after a period to a fifth of the motion, goes straight to Newton's method; from any
    other start the motion is first followed until it settles.

    Parameters
    ----------
    system : NonlinearSystem
    start : array_like (n,), (times, states) or PeriodicOrbit
        A state at time 0; a record of motion of at least a period, times (k,) and states (k, n), the last seconds of a
        simulation, say; or the orbit for other values of the parameters.
    period : float, optional
        Of a forced system a whole multiple of its own, which is the default.  Of an autonomous one about the orbit's;
        if it is left out, it is estimated from motion that returns.
    winding : mapping of int to float, optional
        By how much states grow in every period of a motion that rotates, by their numbers from 0: ``{0: 2 * math.pi}``
        of a pendulum whose angle, state 0, turns once.  The rates must not change with such a shift.
    tolerance : float
        Error of the states to aim at, from 1e-12 to 1e-3 of the largest of each.

    Returns
    -------
    PeriodicOrbit

    Raises
    ------
    ValueError
        Where the function is not as required; where motion diverges or comes to rest; and, as `NoOrbitError`, where
        Newton's method does not converge, with its last point.

    Examples
    --------
    >>> import floquetrod as fr
    >>> def van_der_pol(t, x, mu):
    ...     return x[1], mu * (1 - x[0] ** 2) * x[1] - x[0]
    >>> orbit = fr.periodic_orbit(fr.NonlinearSystem(van_der_pol, parameters={"mu": 1.0}), [2.0, 0.0])
    >>> orbit.status, round(orbit.period, 10)
    ('stable', 6.6632868593)
    >>> [f"{mu.real:.8g}" for mu in orbit.stability.multipliers]
    ['0.00085969506']

    A pendulum that a torque turns over and over:

    >>> def pendulum(t, x):
    ...     return x[1], 1.2 - 0.5 * x[1] - np.sin(x[0])
    >>> turning = fr.periodic_orbit(fr.NonlinearSystem(pendulum), [0.0, 2.0], winding={0: 2 * math.pi})
    >>> turning.status, round(turning.period, 9)
    ('stable', 2.657435879)
    """
    validate.instance("system", system, NonlinearSystem)
    tolerance = validate.within("tolerance", tolerance, 1e-12, 1e-3)
    period = None if period is None else validate.positive("period", period)
    turns = _turns(system, period)
    if isinstance(start, PeriodicOrbit):
        if winding is not None:
            raise TypeError("winding is that of the orbit given as start; leave it out")
        return orbit_of(*_from_orbit(system, start, turns), tolerance)
    if winding is not None:
        return _rotating(system, start, period, turns, winding, tolerance)
    length = period if turns is None else turns * float(system.period or math.nan)
    try:
        return _near(system, orbit_guesses.guessed(system, start, length), turns, tolerance)
    except NoOrbitError as error:
        if turns is None and period is not None:
            with contextlib.suppress(ValueError):  # what the given period led to is the better message
                return _returning(system, start, period, tolerance)
        raise error


def _rotating(
    system: NonlinearSystem, start: Any, period: float | None, turns: int | None, winding: Any, tolerance: float
) -> PeriodicOrbit:
    """Return the orbit of a motion that rotates: its states grow by ``winding`` in every period."""
    state = validate.array("start", start)
    if state.ndim != 1 or not state.size:
        raise ValueError(f"start must be a state with winding, one number for each equation, got shape {state.shape}")
    growth = _growth(winding, state.size)
    system.evaluated.start(0.0, state, system.parameters)
    orbit_guesses.require_invariant(system, state, growth)
    length = period if turns is None else turns * float(system.period or math.nan)
    guess = orbit_guesses.rotating(system, state, length, growth)
    lost: NoOrbitError | None = None
    for intervals in _FIRST:
        try:
            return orbit_of(*_discretised(system, guess, turns, intervals, growth), tolerance)
        except NoOrbitError as error:
            lost = lost or error
    raise lost or NoOrbitError("no periodic orbit was found")


def _growth(winding: Any, order: int) -> Floats:
    """Return by how much each state grows in a period (n,)."""
    if not isinstance(winding, Mapping) or not winding:
        raise TypeError(
            f"winding must be a mapping of states by their number to their growth in a period, such as "
            f"{{0: 2 * math.pi}}, got {validate.short(winding)}"
        )
    growth = np.zeros(order)
    for number, amount in winding.items():
        index = validate.integer("winding (the number of a state)", number, 0, order - 1)
        growth[index] = validate.finite(f"winding[{index}]", amount)
    if not growth.any():
        raise ValueError("winding must not be 0; leave it out for motion that returns")
    return growth


def _returning(system: NonlinearSystem, start: Any, period: float, tolerance: float) -> PeriodicOrbit:
    """Return the orbit of an autonomous system of about a period, from motion that is followed until it returns.

    A period good to three digits does not close motion that jumps within a millionth of it.
    """
    guess = orbit_guesses.guessed(system, start, None)
    if abs(guess.period - period) > _SAME * period:
        raise NoOrbitError(f"motion from start returns after {guess.period:.6g}, not after about {period:.6g}")
    return _near(system, guess, None, tolerance)


def _near(system: NonlinearSystem, guess: orbit_guesses.Guess, turns: int | None, tolerance: float) -> PeriodicOrbit:
    """Return the orbit near a guess, from a finer first mesh where Newton's method fails on a coarse one."""
    lost: NoOrbitError | None = None
    for intervals in _FIRST:
        try:
            return orbit_of(*_discretised(system, guess, turns, intervals), tolerance)
        except NoOrbitError as error:
            lost = lost or error
    fine = orbit_guesses.jumping(system, guess) if guess.jumps else None
    for intervals in () if fine is None else _JUMPING:
        try:
            return orbit_of(*_discretised(system, fine or guess, turns, intervals), tolerance)
        except NoOrbitError:
            continue
    if guess.jumps and lost is not None:
        raise NoOrbitError(
            f"{lost}. The motion jumps within a small part of its period: begin with parameters with which it is "
            "smoother, and give that orbit as start for the next ones, or use fr.follow"
        )
    raise lost or NoOrbitError("no periodic orbit was found")


def _turns(system: NonlinearSystem, period: float | None) -> int | None:
    """Return how many of a forced system's periods an orbit takes; None of an autonomous one."""
    own = system.period
    if own is None:
        return None
    turns = 1 if period is None else round(min(period / own, 2.0 * _MOST_TURNS))
    if not 1 <= turns <= _MOST_TURNS or (period is not None and abs(period - turns * own) > 1e-6 * own):
        raise ValueError(f"period must be 1 to {_MOST_TURNS} times the system's, {own:.9g}, got {period!r}")
    return turns


def _from_orbit(system: NonlinearSystem, start: PeriodicOrbit, turns: int | None) -> tuple[Collocation, Point]:
    """Return the equations of a system on the mesh of another's orbit."""
    if start.system.is_autonomous != system.is_autonomous:
        raise ValueError("start must be an orbit of a system that is forced, or autonomous, as this one is")
    given = start.collocation
    collocation = Collocation(system, given.mesh, given.degree, turns, winding=given.winding)
    point = start.point._replace(value=0.0)
    return collocation, point._replace(period=collocation.period_at(point))


def _discretised(
    system: NonlinearSystem,
    guess: orbit_guesses.Guess,
    turns: int | None,
    intervals: int,
    growth: Floats | None = None,
) -> tuple[Collocation, Point]:
    """Return the equations on a first mesh, and a guess there; ``growth`` (n,) is the growth of states in a period."""
    n = guess.states.shape[1]
    shares = guess.times / guess.period
    density = _density(guess, shares)
    mesh, winding = orbit_mesh.of_density(shares, density, intervals), () if growth is None else tuple(growth.tolist())
    collocation = Collocation(system, mesh, _degree(n), turns, winding=winding)
    stages = guess.at(collocation.shares.ravel(), growth).reshape(*collocation.shares.shape, n)
    point = Point(guess.at(collocation.mesh[:-1], growth), stages, guess.period)
    system.evaluated.require_derivatives(guess.times[::20], guess.states[::20], system.parameters)
    return collocation, point


def _density(guess: orbit_guesses.Guess, shares: Floats) -> Floats:
    """Return the density of a first mesh between the samples of a guess.

    By the roots of second derivatives, of motion that jumps by the steps that an integrator took.
    """
    if guess.by_steps:
        return 1.0 / np.diff(shares) + _LEAST_STEPS * len(shares)
    size = np.maximum(np.ptp(guess.states, axis=0), 1e-6 * float(np.abs(guess.states).max()) + 1e-300)
    bend = np.linalg.norm(np.diff(guess.rates / size, axis=0), axis=1) * guess.period / np.diff(shares)
    return np.asarray(np.sqrt(bend) + 0.3 * float((np.sqrt(bend) * np.diff(shares)).sum()) + 1e-300)


def _degree(order: int) -> int:
    """Return the number of Gauss points in each interval for systems of so many equations."""
    return next(degree for most, degree in _DEGREES if order <= most)


def orbit_of(collocation: Collocation, point: Point, tolerance: float = 1e-10) -> PeriodicOrbit:
    """Return the orbit near a point, on a mesh fine enough for the tolerance; the parameter is fixed.

    The mesh is refined until the estimates of `orbit_mesh.interior_errors` are within the tolerance.  The orbit is then
    solved again with two more points in each interval: the difference is its error, and where this is too large the
    mesh is refined once more.  The finer orbit is returned.
    """
    known = collocation.with_value(point.value)
    collocation, point = orbit_mesh.carried(known, point._replace(value=0.0), known.mesh, _degree(point.nodes.shape[1]))
    _require_periodic(collocation, point)
    steps, best = 0, None
    for turn in range(_MOST_MESHES):
        coarse = corrected(collocation, point, _phase(collocation, point))
        steps += coarse.steps
        _require_motion(collocation, coarse.point)
        errors = orbit_mesh.interior_errors(collocation, coarse.point)
        jacobians = point.period * coarse.condensed.jacobians
        least = orbit_mesh.least_density(collocation, jacobians, tolerance)
        last = turn == _MOST_MESHES - 1 or len(errors) >= orbit_mesh.MOST
        followed = float((least * collocation.steps).max()) <= orbit_mesh.FOLLOWED
        if last or (float(errors.max()) <= tolerance and followed):
            finer = compared(collocation, coarse.point, coarse.condensed, _phase(collocation, coarse.point))
            steps, errors = steps + finer.steps, finer.errors
            best = finer if best is None or finer.error < best.error else best
            if last or finer.error <= 10.0 * tolerance or finer.rounding > tolerance:
                break
        mesh = orbit_mesh.equidistributed(collocation, errors, 0.3 * tolerance, least)
        collocation, point = orbit_mesh.carried(collocation, coarse.point, mesh, collocation.degree)
    return _finished(best, steps)


def _phase(collocation: Collocation, point: Point) -> list[BorderRow]:
    """Return the rows that an orbit needs beside the equations: a phase condition where it is autonomous."""
    return [] if collocation.turns else [collocation.phase(point)]


def _require_periodic(collocation: Collocation, point: Point) -> None:
    """Raise ValueError where f a period later differs, or depends on time in a system without a period."""
    times = point.period * np.array([0.0, 0.37, 0.71])
    states = point.nodes[[0, len(point.nodes) // 3, 2 * len(point.nodes) // 3]]
    system = collocation.system
    shift = point.period if system.period is None else system.period
    shift = 0.618034 * shift if system.period is None else shift
    here, there = system.rates(times, states), system.rates(times + shift, states)
    size = max(float(np.abs(collocation.rates(point)).max()), 1e-300)
    gap = float(np.abs(here - there).max())
    if not gap <= 1e-9 * size:
        others = times + 0.1937 * point.period  # at a jump rounding decides between both sides; elsewhere it does not
        if system.period is not None and np.allclose(
            system.rates(others, states), system.rates(others + shift, states), rtol=0.0, atol=1e-9 * size
        ):
            at = float(times[np.abs(here - there).reshape(len(times), -1).max(axis=1).argmax()])
            raise ValueError(
                f"function jumps at t = {at:.6g}: rates a period of {shift:.6g} apart agree elsewhere; orbits are of "
                "rates without jumps in time: smooth it, as by tanh(k sin(t)) in place of sign(sin(t))"
            )
        said = "depends on time; give its period" if system.period is None else f"is not periodic in {shift:.9g}"
        raise ValueError(f"function {said}: rates {shift:.6g} later differ by {gap:.3g}, of {size:.3g}")


def _require_motion(collocation: Collocation, point: Point) -> None:
    """Raise NoOrbitError where an orbit of an autonomous system has shrunk to a state of rest."""
    moves = float((np.ptp(point.nodes, axis=0) / point.scale).max())
    if collocation.turns is None and moves < 1e-7:
        rest = ", ".join(f"{value:.6g}" for value in point.nodes[0, :6])
        raise NoOrbitError(f"no periodic orbit was found: Newton's method came to a state of rest at ({rest})")


class Compared(NamedTuple):
    """An orbit with two points more in each interval, and how it differs from the one without them."""

    collocation: Collocation
    point: Point
    segments: Segments
    errors: Floats  # in each interval
    rounding: float
    error: float
    period_error: float
    value_error: float  # of the unknown parameter
    steps: int


def compared(collocation: Collocation, point: Point, condensed: Condensed, rows: list[BorderRow]) -> Compared:
    """Return the orbit of a degree two higher on the same mesh where rows hold, with errors from the difference."""
    fine, start = orbit_mesh.carried(collocation, point, collocation.mesh, collocation.degree + MORE)
    start, rates, residual = fine.settled(start)
    by_parameter = None if fine.parameter is None else orbit_mesh.between_points(condensed.drives[..., -1], fine.degree)
    finer = corrected(fine, start, rows, known=Known(rates, residual, by_parameter))
    gaps = rounding_gaps(fine, finer.point, finer.condensed)
    targets, scale = np.zeros((len(rows), gaps.shape[2])), finer.point.scale
    nodes, scalars = fine.responses(finer.condensed, rows, scale, gaps, targets)
    rounding = 2.0 * float((np.abs(nodes) / scale[:, None]).max())
    largest = (2.0 * np.abs(scalars).max(axis=1)).tolist()
    return comparison(
        collocation, point, condensed, fine, finer, rounding, dict(zip(fine.scalars, largest, strict=True))
    )


def comparison(
    collocation: Collocation,
    point: Point,
    condensed: Condensed,
    fine: Collocation,
    finer: Corrected,
    rounding: float,
    of_scalars: dict[str, float],
) -> Compared:
    """Return an orbit of a degree two higher on the same mesh, with errors from the difference and from rounding."""
    errors = orbit_mesh.differences(fine, finer.point, point, _TRIALS)
    moved, doubt = doubts(fine, finer.point, finer.condensed, rounding, condensed.maps)
    trace = finer.point.period * _trace(fine, finer.condensed.jacobians)
    before = point.period * _trace(collocation, condensed.jacobians)
    segments = Segments(
        finer.condensed.maps,
        moved,
        None if fine.turns else fine.rates_at_mesh(finer.point),
        trace,
        2.0 * abs(trace - before) + doubt,
    )
    return Compared(
        fine,
        finer.point,
        segments,
        errors,
        rounding,
        2.0 * float(errors.max()) + rounding,
        0.0 if fine.turns else 2.0 * abs(finer.point.period - point.period) + of_scalars["period"],
        2.0 * abs(finer.point.value - point.value) + of_scalars["parameter"] if fine.parameter else 0.0,
        finer.steps,
    )


def rounding_gaps(collocation: Collocation, point: Point, condensed: Condensed) -> Floats:
    """Return about the gaps (N, n, 3) that rounding leaves in the equations, with three patterns of signs."""
    terms = np.abs(condensed.rates) + np.einsum("ikab,ikb->ika", np.abs(condensed.jacobians), np.abs(point.stages))
    size = np.abs(point.nodes) + (point.period * collocation.steps)[:, None] * terms.max(axis=1)
    return np.asarray(2.0 * EPS * size[:, :, None] * _signs(size.shape))


@functools.lru_cache(32)
def _signs(shape: tuple[int, ...]) -> Floats:
    """Return three patterns of signs (N, n, 3)."""
    waves = np.cos(np.arange(math.prod(shape)).reshape(*shape, 1) * np.array([2.399, 0.731, 1.117]))
    return np.asarray(np.sign(waves))


def _trace(collocation: Collocation, matrices: Floats) -> float:
    """Return the mean over the period of the trace of matrices at the Gauss points."""
    return float(collocation.steps @ np.einsum("ikaa->ik", matrices) @ gauss(collocation.degree).weights)


def doubts(
    collocation: Collocation, point: Point, condensed: Condensed, rounding: float, coarse: Floats
) -> tuple[Floats, float]:
    """Return the errors of the maps, entry by entry, and of the integral of the trace of derivatives over the period.

    From twice the difference from ``coarse`` maps, and from errors of the derivatives along the orbit.
    """
    jacobians, moved = condensed.jacobians, point._replace(stages=point.stages + 1e-6 * point.scale)
    there, share = collocation.jacobians(moved), rounding / 1e-6
    lengths, weights = point.period * collocation.steps, gauss(collocation.degree).weights
    relative = collocation.system.evaluated.derivatives_error
    run = collocation.machine_code_of(orbit_errors.doubts_fill, point)
    if run is not None:
        errors = np.empty(coarse.shape)
        return errors, run(lengths, weights, jacobians, there, share, relative, condensed.maps, coarse, errors)
    doubt = np.abs(there - jacobians) * share + relative * np.abs(jacobians)
    mean = lengths[:, None, None] * np.einsum("k,ikab->iab", weights, doubt)
    stretch = np.linalg.norm(lengths[:, None, None] * np.abs(jacobians).max(axis=1), axis=(1, 2))
    errors = 2.0 * np.abs(condensed.maps - coarse) + mean * np.exp(np.minimum(stretch, 5.0))[:, None, None]
    return errors, point.period * _trace(collocation, doubt)


def _finished(finer: Any, steps: int) -> PeriodicOrbit:
    """Return the orbit as a result."""
    collocation, point = finer.collocation, finer.point
    evaluated = collocation.system.evaluated
    times = point.period * collocation.mesh
    was = evaluated.complex_steps
    evaluated.require_derivatives(times[:-1], point.nodes, collocation.system.parameters)
    if was and not evaluated.complex_steps:  # the derivatives were not those of the function
        return orbit_of(collocation, point)
    return as_orbit(finer, steps)


def as_orbit(finer: Compared, steps: int) -> PeriodicOrbit:
    """Return the orbit as a result, its parameter, where that was unknown, as it was found."""
    collocation, point = finer.collocation.with_value(finer.point.value), finer.point._replace(value=0.0)
    last = point.nodes[:1] + collocation.winding if collocation.winding else point.nodes[:1]
    times, states = point.period * collocation.mesh, np.concatenate([point.nodes, last])
    for array in (times, states):
        array.flags.writeable = False
    return PeriodicOrbit(
        collocation.system,
        point.period,
        finer.period_error,
        times,
        states,
        finer.error,
        steps,
        collocation,
        point,
        finer.segments,
    )
