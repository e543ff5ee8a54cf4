"""Curves of special points in the plane of two parameters, followed by pseudo-arclength from a point that is known.

The unknowns are the orbit and both parameters; a step goes a length along the curve and is corrected across it, with
the length of `floquetrod.orbits.arclength` over both parameters.  Meshes adapt as along a branch.  Every point is
solved again with two more Gauss points in each interval: the difference is its error, with the effect of rounding and
of errors of the derivatives on the orbit and on the test function.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import EPS, Floats
from floquetrod._util.progress import Progress
from floquetrod.orbits import continuation, critical_orbits, finding, orbit_mesh
from floquetrod.orbits.bifurcation_curve import BifurcationCurve
from floquetrod.orbits.continuation import Ended
from floquetrod.orbits.critical_orbits import CriticalEquations, CriticalOrbit, Solved, Values
from floquetrod.orbits.crossings import multipliers_of
from floquetrod.orbits.newton import Corrected, NoOrbitError
from floquetrod.orbits.orbit import PeriodicOrbit
from floquetrod.orbits.orbit_extent import extremes, returns_after
from floquetrod.orbits.special_points import SpecialPoint, deviation_scale

_PARTED = 1e-6  # residual of orbits at a branch point, of the states, above which branches do not cross (a choice)
_RESONANT = 2e-3  # angle of a pair, from a resonance, up to which its curve is followed (a choice)
_CLOSE = 1e-3  # distance of the critical multiplier from its place on the circle, beyond which it is not critical
_KNOWN = 0.1  # error of the critical multiplier beyond which it is not known, or distance of another (a choice)
_HIDDEN = 0.01  # change of the states by an error of g, beyond which the curve is not known (a choice)
_SAME = 1e-6  # difference of two points of a curve that are the same, of the ranges and the states (a choice)
_CLOSED = "the curve closes on itself"
_RESONANCES = {3: 2.0 * math.pi / 3.0, 4: 0.5 * math.pi}


class CurveTask(NamedTuple):
    """Two parameters by name, their ranges, the tolerance of the states, the longest step, and when to stop."""

    names: tuple[str, str]
    over: tuple[Values, Values]
    tolerance: float
    longest: float
    until: Callable[[PeriodicOrbit, PeriodicOrbit], str] | None


class _Sample(NamedTuple):
    """A point of the curve, and the orbit of a higher degree there with the errors of both parameters."""

    solved: Solved
    orbit: PeriodicOrbit
    values: Values
    errors: Values
    extra: float


class _Side(NamedTuple):
    """Samples to one side of the start, the reason of their end, and notes."""

    samples: list[_Sample]
    end: str
    notes: list[str]


def followed(point: SpecialPoint, task: CurveTask, steps: int, progress: Progress | None) -> BifurcationCurve:
    """Return the curve of special points through one, to both sides."""
    equations, start = _begun(point, task)
    forward = _one_way(_March(equations, task, start, 1.0), start, steps, progress, 0)
    if forward.end in (_CLOSED, "interrupted"):
        backward = _Side([], forward.end, [])
    else:
        backward = _one_way(_March(equations, task, start, -1.0), start, steps, progress, len(forward.samples))
    if not forward.samples and not backward.samples and forward.end == backward.end != "interrupted":
        raise ValueError(f"orbit must be a point that lies on a curve, got {point}: {forward.end}")
    samples = [*reversed(backward.samples), start, *forward.samples]
    return BifurcationCurve(
        point.kind,
        task.names,
        task.over,
        tuple(sample.orbit for sample in samples),
        np.array([sample.errors for sample in samples]),
        len(backward.samples),
        (backward.end, forward.end),
        task.tolerance,
        (*reversed(backward.notes), *forward.notes),
    )


def _begun(point: SpecialPoint, task: CurveTask) -> tuple[CriticalEquations, _Sample]:
    """Return the equations of the curve, and its first sample."""
    orbit = point.orbit
    if point.kind == "period doubling" and returns_after(orbit.collocation, orbit.point, 2):  # of doubled orbits
        orbit = finding.periodic_orbit(orbit.system, orbit.states[0], 0.5 * orbit.period)
    first, second = task.names
    widths = tuple(high - low for low, high in task.over)
    scale = deviation_scale(orbit.point.scale)
    across = (1.0, 0.0) if point.parameter != second else (0.0, 1.0)
    equations = CriticalEquations(point.kind, task.names, (widths[0], widths[1]), scale, across)
    angle = float(np.angle(point.multiplier)) if point.kind == "Neimark-Sacker" else 0.0
    given = orbit.collocation
    collocation, states = orbit_mesh.carried(given, orbit.point, given.mesh, given.degree - finding.MORE)
    critical = CriticalOrbit(collocation, states, angle)
    try:
        solved = equations.corrected(critical, equations.begun(critical))
        along = dict(zip(equations.scalars(critical), np.abs(solved.direction.scalars).tolist(), strict=True))
        held = second if point.parameter == first or along[first] < along[second] else first
        if along[held] > 0.1 * max(along[first], along[second]):
            value = orbit.system.parameters[held]
            solved = equations.corrected(solved.orbit, solved.linear.borders, solved.direction, (held, value))
        return equations, _sampled(equations, solved, None)
    except (NoOrbitError, np.linalg.LinAlgError, Ended) as error:
        raise ValueError(
            f"orbit must be a point at which one multiplier, or one pair, crosses by itself, got {point}: {error}"
        ) from None


def _one_way(march: _March, start: _Sample, steps: int, progress: Progress | None, before: int) -> _Side:
    """Return the samples in one direction."""
    samples: list[_Sample] = []
    notes: list[str] = []
    end = f"{steps} steps were made"
    try:
        while len(samples) < steps:
            last = march.sample
            sample = march.advanced()
            if march.task.until is not None and (reason := march.task.until(last.orbit, sample.orbit)):
                raise Ended(reason)
            samples.append(sample)
            notes += _passed(march, last, sample)
            if progress is not None:
                progress(before + len(samples), 2 * steps)
            if len(samples) > 3 and _passes(march, start, last, sample):
                samples[-1], end = start, _CLOSED
                break
    except Ended as ended:
        end = str(ended)
    except KeyboardInterrupt:
        end = "interrupted"
    return _Side(samples, end, notes)


class _March:
    """The march along a curve from a sample; it changes its own sample, step and units."""

    def __init__(self, equations: CriticalEquations, task: CurveTask, start: _Sample, sign: float) -> None:
        """Begin at a sample, in its direction or against it."""
        self.equations, self.task, self.length = equations, task, min(continuation.FIRST_LENGTH, task.longest)
        direction = critical_orbits.Vector(*(sign * part for part in start.solved.direction))
        self.sample = start._replace(solved=start.solved._replace(direction=direction))
        self.at_end = ""
        rates = _rates(equations, self.sample.solved)
        for name, value, rate, ends in zip(task.names, start.values, rates, task.over, strict=True):
            bound = ends[1] if rate > 0.0 else ends[0]
            if rate != 0.0 and abs(bound - value) <= 1e-12 * (ends[1] - ends[0]):
                self.at_end = f"{name} = {value:.6g} is the end of the range"

    def advanced(self) -> _Sample:
        """Return the next sample, on the end of a range where the curve leaves it.  Raises Ended."""
        if self.at_end:
            raise Ended(self.at_end)
        if self.equations.kind == "branch point":
            self._turn_across()
        solved = self._stepped()
        pinned = self._bound_passed(solved)
        if pinned is not None:
            solved = self._at(pinned, solved)
            self.at_end = f"{pinned[0]} = {pinned[1]:.6g} is the end of the range"
        try:
            sample = _sampled(self.equations, self._resolved(solved, pinned), pinned)
        except (NoOrbitError, np.linalg.LinAlgError, ValueError) as error:
            raise Ended(f"the orbit at {self._where(solved.orbit)} was lost: {error}") from None
        self._require_motion(sample)
        self._require_crossing(sample)
        self.sample = sample
        return sample

    def _turn_across(self) -> None:
        """Take the direction of the second test function of branch points across the curve."""
        first, second = _rates(self.equations, self.sample.solved)
        size = math.hypot(first, second)
        if size > 1e-3:
            self.equations = replace(self.equations, across=(second / size, -first / size))

    def _stepped(self) -> Solved:
        """Return the point a step on, the step as long as Newton's method and the curve's bends allow."""
        reason = ""
        before = self.sample.solved
        while self.length >= continuation.LEAST_LENGTH:
            try:
                guess = self.equations.ahead(before, self.length)
                solved = self.equations.corrected(guess, before.linear.borders, before.direction)
            except (ValueError, ArithmeticError, np.linalg.LinAlgError) as error:
                reason = str(error)
                self.length *= 0.5
                continue
            cosine = self.equations.product(before.orbit, before.direction, solved.direction)
            if cosine < continuation.SHARPEST_TURN:
                reason = "it bends too sharply"
                self.length *= 0.5
                continue
            if self.equations.kind == "Neimark-Sacker" and not 0.0 < solved.orbit.extra < math.pi:
                self._end_resonant(solved)
                self.length *= 0.5
                continue
            self.length = continuation.next_length(self.length, self.task.longest, solved.steps, cosine)
            return solved
        raise Ended(f"no orbit was found beyond {self._where(before.orbit)}, however short the step: {reason}")

    def _end_resonant(self, solved: Solved) -> None:
        """Raise Ended where the angle of a pair has come to 0 or pi, at which curves of pairs end."""
        angle, there = self.sample.extra, solved.orbit.extra
        end, name = (0.0, "1:1") if there <= 0.0 else (math.pi, "1:2")
        if abs(angle - end) > _RESONANT:
            return
        squares = [(each - end) ** 2 for each in (angle, there)]
        share = squares[0] / (squares[0] - squares[1]) if abs(squares[0] - squares[1]) > 1e-30 else 0.0
        share = share if abs(share) < 10.0 else 0.0
        pairs = zip(self.sample.values, self.equations.values(solved.orbit), strict=True)
        where = [f"{name} = {a + share * (b - a):.4g}" for name, (a, b) in zip(self.task.names, pairs, strict=True)]
        pair = "two multipliers +1" if end == 0.0 else "two multipliers -1"
        raise Ended(f"the pair meets on the real axis ({name} resonance, {pair}) near {', '.join(where)}")

    def _where(self, orbit: CriticalOrbit) -> str:
        """Return names and values of both parameters as text."""
        numbers = zip(self.task.names, self.equations.values(orbit), self.equations.widths, strict=True)
        return ", ".join(
            f"{name} = {value if abs(value) > 1e-12 * width else 0.0:.9g}" for name, value, width in numbers
        )

    def _bound_passed(self, solved: Solved) -> tuple[str, float] | None:
        """Return the parameter that has left its range first, and the end of its range; None inside."""
        first: tuple[float, str, float] | None = None
        there = self.equations.values(solved.orbit)
        for name, (low, high), before, value in zip(
            self.task.names, self.task.over, self.sample.values, there, strict=True
        ):
            if low <= value <= high:
                continue
            bound = low if value < low else high
            share = (bound - before) / (value - before)
            if first is None or share < first[0]:
                first = share, name, bound
        return None if first is None else first[1:]

    def _at(self, pinned: tuple[str, float], solved: Solved) -> Solved:
        """Return the point between the present one and another where a parameter has a value."""
        before = self.sample.solved
        which = self.task.names.index(pinned[0])
        start, end = self.sample.values[which], self.equations.values(solved.orbit)[which]
        share = (pinned[1] - start) / (end - start)
        given, other = before.orbit, solved.orbit
        values = zip(self.task.names, self.sample.values, self.equations.values(other), strict=True)
        guess = critical_orbits.with_values(
            given,
            given.point._replace(
                nodes=given.point.nodes + share * (other.point.nodes - given.point.nodes),
                stages=given.point.stages + share * (other.point.stages - given.point.stages),
                period=given.point.period + share * (other.point.period - given.point.period),
            ),
            {name: a + share * (b - a) for name, a, b in values},
        )
        guess = guess._replace(extra=given.extra + share * (other.extra - given.extra))
        try:
            return self.equations.corrected(guess, solved.linear.borders, solved.direction, pinned)
        except (NoOrbitError, np.linalg.LinAlgError) as error:
            raise Ended(f"no orbit was found at the end of the range: {error}") from None

    def _resolved(self, solved: Solved, pinned: tuple[str, float] | None) -> Solved:
        """Return the point on a mesh that resolves it, and is not much finer."""
        for _ in range(continuation.MOST_MESHES):
            given, jacobians = solved.orbit.collocation, solved.linear.condensed.jacobians
            mesh = orbit_mesh.adapted(given, solved.orbit.point, jacobians, self.task.tolerance)
            if mesh is None:
                return solved
            orbit, borders, direction = self.equations.carried(
                solved.orbit, solved.linear.borders, solved.direction, mesh, given.degree
            )
            solved = self.equations.corrected(orbit, borders, direction, pinned)
        return solved

    def _require_motion(self, sample: _Sample) -> None:
        """Raise Ended where an orbit of an autonomous system has shrunk to a state of rest, or passed through one."""
        if continuation.has_shrunk(self.sample.orbit, sample.orbit, self.equations.scale):
            raise Ended(f"the orbit shrinks to a state of rest near {self._where(sample.solved.orbit)}")

    def _require_crossing(self, sample: _Sample) -> None:
        """Raise Ended where the branches of a branch point do not cross any more."""
        if self.equations.kind == "branch point" and abs(sample.extra) > _PARTED:
            raise Ended(
                f"the branches that cross part beyond {self._where(self.sample.solved.orbit)}: no symmetry and no "
                "invariant plane keeps the branch point; follow a fold of one of them"
            )


def _rates(equations: CriticalEquations, solved: Solved) -> Values:
    """Return the rates of both parameters along the curve, in units of their ranges."""
    names = equations.scalars(solved.orbit)
    first, second = (float(solved.direction.scalars[names.index(name)]) for name in equations.names)
    return first, second


def _sampled(equations: CriticalEquations, solved: Solved, pinned: tuple[str, float] | None) -> _Sample:
    """Return the sample of a point: the critical orbit of a higher degree, and errors of the parameters."""
    coarse = solved.orbit
    given = coarse.collocation
    orbit, borders, direction = equations.carried(
        coarse, solved.linear.borders, solved.direction, given.mesh, given.degree + finding.MORE
    )
    finer = equations.corrected(orbit, borders, direction, pinned)
    fine = finer.orbit
    if pinned is not None:  # Newton's last step may miss it by rounding
        fine = critical_orbits.with_values(fine, fine.point, {pinned[0]: pinned[1]})
    gaps = finding.rounding_gaps(fine.collocation, fine.point, finer.linear.condensed)
    names = equations.scalars(fine)
    states, scalars = _moved(equations, finer, gaps, 0.0)
    compared = finding.comparison(
        given,
        coarse.point,
        solved.linear.condensed,
        fine.collocation,
        Corrected(fine.point, finer.linear.condensed, finer.steps),
        states,
        dict(zip(names, (2.0 * np.abs(scalars[:, :-1]).max(axis=1)).tolist(), strict=True)),
    )
    blur = _blur(equations, finer, states)
    miss = _miss(equations, fine, finding.as_orbit(compared, 0))
    shifted, scalars = _moved(equations, finer, gaps, blur if miss is None else min(blur, finer.linear.rate * miss))
    shift = shifted - states
    if miss is None and not shift <= _HIDDEN:
        raise _hidden(equations, fine, "is not known")
    if "period" in names:
        compared = compared._replace(
            period_error=compared.period_error + abs(float(scalars[names.index("period"), -1]))
        )
    compared = compared._replace(rounding=shifted, error=compared.error + shift)
    values = equations.values(fine)
    across = _across(equations, finer, scalars) + shift * shift
    pairs = zip(values, equations.values(coarse), equations.widths, strict=True)
    first, second = (2.0 * abs(a - b) + across * width + 4.0 * EPS * abs(a) for a, b, width in pairs)
    found = finding.as_orbit(compared, solved.steps + finer.steps)
    return _Sample(solved, found, values, (first, second), fine.extra)


def _blur(equations: CriticalEquations, solved: Solved, states: float) -> float:
    """Return a bound of the error of g by errors of the maps, of derivatives and of states, and by rounding."""
    condensed, scale = solved.linear.condensed, equations.scale
    doubted, _ = finding.doubts(solved.orbit.collocation, solved.orbit.point, condensed, states, condensed.maps)
    doubted = doubted + 8.0 * len(scale) * EPS * np.abs(condensed.maps)
    return float((solved.linear.blur * doubted / scale[:, None] * scale).sum())


def _miss(equations: CriticalEquations, critical: CriticalOrbit, orbit: PeriodicOrbit) -> float | None:
    """Return how far the critical multiplier is from 1, -1 or its place on the circle, its error added.

    None where it is not known, or where another one is so near that g does not change in proportion.  Raises Ended
    where it is not there.
    """
    values, errors = multipliers_of(orbit)
    there = equations.multiplier(critical)
    apart = np.where(np.isfinite(values), np.abs(values - there), np.inf)
    which = int(apart.argmin())
    miss, error = float(apart[which]), float(errors[which])
    if not error <= _KNOWN:
        return None
    if miss > _CLOSE + 10.0 * error:
        mu = complex(values[which])
        size = f"{mu.real:.4g}" if mu.imag == 0.0 else f"{abs(mu):.4g} in magnitude"
        raise _hidden(equations, critical, f"is {size}, not {_wanted(there)}")
    return None if int(np.count_nonzero(apart < _KNOWN)) > 1 else miss + error


def _wanted(there: complex) -> str:
    return "on the unit circle" if there.imag else f"{there.real:g}"


def _hidden(equations: CriticalEquations, critical: CriticalOrbit, observed: str) -> Ended:
    """Return the end of a curve at a point whose multiplier, computed by itself, is not critical."""
    wanted = _wanted(equations.multiplier(critical))
    pairs = zip(equations.names, equations.values(critical), strict=True)
    where = ", ".join(f"{name} = {value:.9g}" for name, value in pairs)
    return Ended(
        f"at {where} the multiplier of the {equations.kind} {observed}: rounding of the parameters hides "
        f"where it is {wanted}, as where a canard grows, and the curve cannot be followed here"
    )


def _across(equations: CriticalEquations, solved: Solved, scalars: Floats) -> float:
    """Return the distance from the curve that changes of the scalars (S, k + 1) cause, in units of the ranges.

    Changes along the curve are left out, as they lead to other points of it.
    """
    names = equations.scalars(solved.orbit)
    rows = [names.index(name) for name in equations.names]
    along = np.array(_rates(equations, solved))
    size = float(np.linalg.norm(along))
    changes = scalars[rows] / np.array(equations.widths)[:, None]
    if size > 1e-3:
        distances = np.abs(along[0] * changes[1] - along[1] * changes[0]) / size
    else:  # the curve hardly moves in the plane of the parameters
        distances = np.linalg.norm(changes, axis=0)
    return 2.0 * float(distances[:-1].max()) + float(distances[-1])


def _moved(equations: CriticalEquations, solved: Solved, gaps: Floats, blur: float) -> tuple[float, Floats]:
    """Return the largest change of the states, relative, and changes of the scalars, by gaps and by an error of g."""
    nodes, scalars = equations.changes(solved, gaps, blur)
    return 2.0 * float(nodes[:-1].max()) + float(nodes[-1]), scalars


def _passed(march: _March, last: _Sample, sample: _Sample) -> list[str]:
    """Return notes on cusps of folds and strong resonances of pairs between two samples."""
    if march.equations.kind == "Neimark-Sacker":
        start, end = last.extra, sample.extra
        shares = {f"1:{k} resonance": (angle - start) / (end - start or 1.0) for k, angle in _RESONANCES.items()}
    elif march.equations.kind == "fold":
        before, after = (np.array(_rates(march.equations, each.solved)) for each in (last, sample))
        ahead, back = float(before @ before), float(before @ after)
        shares = {"cusp": ahead / (ahead - back) if back < 0.0 else -1.0}
    else:
        return []
    notes = []
    for name, share in shares.items():
        if 0.0 < share <= 1.0:
            there = np.array(last.values) + share * (np.array(sample.values) - last.values)
            where = [f"{each} = {value:.4g}" for each, value in zip(march.task.names, there.tolist(), strict=True)]
            notes.append(f"{name} near {', '.join(where)}")
    return notes


def _passes(march: _March, start: _Sample, last: _Sample, sample: _Sample) -> bool:
    """Return whether the curve has passed its start between two samples."""
    widths = np.array(march.equations.widths)
    way = (np.array(sample.values) - last.values) / widths
    back = (np.array(start.values) - last.values) / widths
    share = float(way @ back) / max(float(way @ way), 1e-300)
    if not 0.0 < share <= 1.0 or float(np.abs(back - share * way).max()) > 0.1 * float(np.abs(way).max()):
        return False
    name = march.task.names[int(np.abs(way).argmax())]
    value = start.values[march.task.names.index(name)]
    given = sample.solved
    try:
        there = march.equations.corrected(given.orbit, given.linear.borders, given.direction, (name, value)).orbit
    except (NoOrbitError, np.linalg.LinAlgError):
        return False
    near = np.abs(np.array(march.equations.values(there)) - start.values) <= _SAME * widths
    reach = extremes(there.collocation, there.point)
    gaps = np.abs([reach.least - start.orbit.least, reach.largest - start.orbit.largest])
    return bool(near.all() and (gaps <= _SAME * march.equations.scale).all())
