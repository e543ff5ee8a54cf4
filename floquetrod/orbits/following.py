"""`fr.follow`: the branch of orbits that one of them lies on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple, overload

import numpy as np

from floquetrod._util import validate
from floquetrod._util.progress import Progress
from floquetrod.orbits import arclength, critical_curves, finding, orbit_mesh
from floquetrod.orbits.arclength import Measure
from floquetrod.orbits.bifurcation_curve import BifurcationCurve
from floquetrod.orbits.branch import Branch
from floquetrod.orbits.continuation import Continuation, Ended, Sample, Task, lowered, sampled, started
from floquetrod.orbits.critical_orbits import Values
from floquetrod.orbits.locating_special_points import Watch, settled
from floquetrod.orbits.newton import NoOrbitError
from floquetrod.orbits.orbit import PeriodicOrbit
from floquetrod.orbits.orbit_extent import returns_after
from floquetrod.orbits.special_points import SpecialPoint

_SAME = 1e-5  # of the extents of states, by which two orbits are distinguished (a choice)
_CLOSED = "the branch closes on itself"
_INTERRUPTED = "interrupted; fr.follow(branch) continues"


@overload
def follow(
    orbit: PeriodicOrbit | Branch,
    over: Mapping[str, tuple[float, float]] | None = None,
    *,
    steps: int = 400,
    longest: float = 0.04,
    tolerance: float = 1e-10,
    until: Callable[[PeriodicOrbit, PeriodicOrbit], str] | None = None,
    progress: Progress | None = None,
) -> Branch: ...


@overload
def follow(
    orbit: SpecialPoint,
    over: Mapping[str, tuple[float, float]] | None = None,
    *,
    steps: int = 400,
    longest: float = 0.04,
    tolerance: float = 1e-10,
    until: Callable[[PeriodicOrbit, PeriodicOrbit], str] | None = None,
    progress: Progress | None = None,
) -> BifurcationCurve: ...


def follow(
    orbit: PeriodicOrbit | Branch | SpecialPoint,
    over: Mapping[str, tuple[float, float]] | None = None,
    *,
    steps: int = 400,
    longest: float = 0.04,
    tolerance: float = 1e-10,
    until: Callable[[PeriodicOrbit, PeriodicOrbit], str] | None = None,
    progress: Progress | None = None,
) -> Branch | BifurcationCurve:
    """Return the branch of periodic orbits on which one lies, over a range of a parameter, with its special points.

    From a special point, return the curve of points of its kind over two parameters.

    By pseudo-arclength, so that the branch is followed round folds, too: from the orbit to both sides, until it leaves
    the range, closes on itself, shrinks to a state of rest, or cannot be continued; `Branch.ends` says which.  Meshes
    adapt to the orbits.  Every orbit has its verdict; where multipliers cross the unit circle between two of them, one
    or several together, the point is located, or `Branch.notes` says that it is not and why.  Two crossings of the same
    kind within a step, one in and one out, cancel and are not seen: make steps shorter.  Ctrl-C ends the search and
    returns the orbits so far.

    The curve of a special point is followed by pseudo-arclength in the orbit and both parameters, round folds and past
    cusps: the multiplier stays on the unit circle, and at a Neimark-Sacker point its angle is another unknown.  Points
    at which several multipliers cross together have no such curve, and branch points have one only where a symmetry or
    an invariant plane keeps them.

    Parameters
    ----------
    orbit : PeriodicOrbit, Branch or SpecialPoint
        Where to begin; a branch is continued from each of its ends that can be continued.
    over : mapping of str to (float, float)
        Name of the parameter, and the range; of a branch its own by default; of a special point two parameters, each
        with its range.  The period of the forcing may depend on the parameters.
    steps : int
        Largest number of orbits on each side.
    longest : float
        Length of the longest step, in units of the ranges and of the largest magnitudes of the states.
    tolerance : float
        Error of the states for which the meshes are chosen, from 1e-12 to 1e-3 of the largest of each.
    until : callable, optional
        Called with an orbit and the next one: where it returns a text, that side ends before the next, and
        `Branch.ends` holds the text.
    progress : callable, optional
        Called with the number of orbits found and the most there can be.

    Returns
    -------
    Branch or BifurcationCurve
        Orbits in order along the branch, or points in order along the curve.

    Raises
    ------
    ValueError
        Where there is no parameter of the name, where the orbit is not within the range, and where a special point does
        not lie on a curve.
    TypeError
        For anything but an orbit, a branch or a special point.

    Examples
    --------
    >>> import floquetrod as fr
    >>> def roessler(t, x, c):
    ...     return -x[1] - x[2], x[0] + 0.2 * x[1], 0.2 + x[2] * (x[0] - c)
    >>> orbit = fr.periodic_orbit(fr.NonlinearSystem(roessler, parameters={"c": 2.7}), [1.0, 1.0, 0.0], 5.75)
    >>> branch = fr.follow(orbit, over={"c": (2.5, 3.0)})
    >>> [(point.kind, round(point.value, 9)) for point in branch.special_points]
    [('period doubling', 2.832445028)]
    >>> round(branch.special_points[0].switch().period / orbit.period, 1)
    2.0

    The curve of a special point: a pair of multipliers leaves the unit circle where p = q.

    >>> import numpy as np
    >>> def spiral(t, x, p, q):
    ...     u, v = x[0] - np.cos(t), x[1]
    ...     growth = p - q - u**2 - v**2
    ...     return -np.sin(t) + growth * u - 0.3 * v, growth * v + 0.3 * u
    >>> system = fr.NonlinearSystem(spiral, period=2.0 * np.pi, parameters={"p": 0.3, "q": 0.5})
    >>> (point,) = fr.follow(fr.periodic_orbit(system, [1.0, 0.0]), {"p": (0.2, 1.0)}, longest=0.3).special_points
    >>> curve = fr.follow(point, {"p": (0.2, 1.0), "q": (0.4, 0.8)}, longest=0.3)
    >>> curve.kind, bool(np.allclose(curve.values[:, 0], curve.values[:, 1], rtol=0.0, atol=1e-12))
    ('Neimark-Sacker', True)
    """
    if not isinstance(orbit, Branch | SpecialPoint):
        hint = "find one with fr.periodic_orbit, or give a Branch or a SpecialPoint"
        validate.instance("orbit", orbit, PeriodicOrbit, hint)
    steps = validate.integer("steps", steps, 1, 100_000)
    longest = validate.within("longest", longest, 1e-5, 1.0)
    tolerance = validate.within("tolerance", tolerance, 1e-12, 1e-3)
    until = None if until is None else validate.function("until", until)
    validate.progress(progress)
    if isinstance(orbit, SpecialPoint):
        names, ranges = _plane(orbit, over)
        return critical_curves.followed(
            orbit, critical_curves.CurveTask(names, ranges, tolerance, longest, until), steps, progress
        )
    name, low, high = _range(orbit, over)
    task = Task(name, low, high, tolerance, longest, until)
    if isinstance(orbit, Branch):
        return _extended(orbit, task, steps, progress)
    for parts in (2, 3):
        if returns_after(orbit.collocation, orbit.point, parts):
            raise ValueError(
                f"orbit must be one round of it: it returns after 1/{parts} of its period; give fr.periodic_orbit the "
                f"period {orbit.period / parts:.9g}"
            )
    return _both_ways(orbit, task, steps, progress)


def _range(orbit: PeriodicOrbit | Branch, over: Any) -> tuple[str, float, float]:
    """Return the name of the parameter and its range, checked."""
    if over is None and isinstance(orbit, Branch):
        return orbit.parameter, *orbit.over
    if not isinstance(over, Mapping) or len(over) != 1:
        raise TypeError(
            f"over must be one parameter with its range, such as {{'omega': (0.5, 2.0)}}, got {validate.short(over)}"
        )
    ((name, ends),) = over.items()
    orbit.system.require_parameter(name, "over")
    low, high = validate.interval(f"over[{name!r}]", ends)
    if isinstance(orbit, Branch):
        if name != orbit.parameter:
            raise ValueError(f"over must be a range of {orbit.parameter!r}, as of the branch; follow one of its orbits")
        values = orbit.values
        if not (low <= values.min() and values.max() <= high):
            raise ValueError(
                f"over[{name!r}] must contain the branch, from {values.min():.6g} to {values.max():.6g}, got ({low:g}, "
                f"{high:g})"
            )
        return name, low, high
    value = orbit.system.parameters[name]
    if not low <= value <= high:
        raise ValueError(
            f"over[{name!r}] must contain the orbit's value, {value:.9g}, got ({low:g}, {high:g}); start from an orbit "
            "within the range"
        )
    return name, low, high


def _plane(point: SpecialPoint, over: Any) -> tuple[tuple[str, str], tuple[Values, Values]]:
    """Return the names of two parameters and their ranges, checked."""
    if not isinstance(over, Mapping) or len(over) != 2:
        raise TypeError(
            "over must be two parameters with their ranges for a special point, such as {'omega': (0.5, 2.0), 'force': "
            f"(0.0, 1.0)}}, got {validate.short(over)}"
        )
    if point.count > 1:
        raise ValueError(f"orbit must be a point at which one multiplier, or one pair, crosses by itself, got {point}")
    system = point.orbit.system
    for name in over:
        system.require_parameter(name, "over")
    (first, second), ranges = over, [validate.interval(f"over[{name!r}]", ends) for name, ends in over.items()]
    for name, (low, high) in zip(over, ranges, strict=True):
        value = system.parameters[name]
        if not low <= value <= high:
            raise ValueError(f"over[{name!r}] must contain the point's value, {value:.9g}, got ({low:g}, {high:g})")
    return (first, second), (ranges[0], ranges[1])


class _Way(NamedTuple):
    """What was found to one side: samples' orbits, special points by the number of orbits before them, and the end."""

    orbits: list[PeriodicOrbit]
    points: list[SpecialPoint]
    end: str
    notes: tuple[str, ...] = ()


def _both_ways(orbit: PeriodicOrbit, task: Task, steps: int, progress: Progress | None) -> Branch:
    """Return the branch to both sides of an orbit."""
    measure = Measure(orbit.point.scale, task.high - task.low)
    try:
        start = sampled(started(orbit, task, measure), measure)
    except NoOrbitError as error:
        raise ValueError(
            f"orbit must not lie on a special point, where the parameter does not determine the direction: {error}"
        ) from None
    forward = _followed(Continuation(task, start, measure, 1.0), start, steps, progress, 0)
    if forward.end == _CLOSED:
        backward = _Way([], [], _CLOSED)
    elif forward.end == _INTERRUPTED:
        backward = _Way([], [], _INTERRUPTED)
    else:
        backward = _followed(Continuation(task, start, measure, -1.0), start, steps, progress, len(forward.orbits))
    return _joined(task, backward, _Way([start.orbit], [], ""), forward)


def _joined(task: Task, backward: _Way, middle: _Way, forward: _Way) -> Branch:
    """Return the branch made of what was found before and after known orbits."""
    before, orbits = len(backward.orbits), middle.orbits
    first = [replace(point, after=before - 1 - point.after) for point in reversed(backward.points)]
    known = [replace(point, after=before + point.after) for point in middle.points]
    last = [replace(point, after=before + len(orbits) - 1 + point.after) for point in forward.points]
    return Branch(
        task.parameter,
        (task.low, task.high),
        (*reversed(backward.orbits), *orbits, *forward.orbits),
        (*first, *known, *last),
        (backward.end, forward.end),
        task.tolerance,
        (*reversed(backward.notes), *middle.notes, *forward.notes),
    )


def _followed(march: Continuation, start: Sample, steps: int, progress: Progress | None, before: int) -> _Way:
    """Return the orbits in one direction, special points numbered by the orbits before them."""
    watch = Watch(march.sample, march.measure)
    samples = [march.sample]
    orbits: list[PeriodicOrbit] = []
    points: list[SpecialPoint] = []
    notes: list[str] = []
    end = f"{steps} steps were made; fr.follow(branch) continues"
    try:
        while len(orbits) < steps:
            last = march.sample
            sample = march.advanced()
            if march.task.until is not None and (reason := march.task.until(last.orbit, sample.orbit)):
                raise Ended(reason)
            samples.append(sample)
            special = watch.located(sample, march.measure)
            points += [replace(point, after=len(orbits)) for point in special.points]
            notes += special.notes
            for point in special.points:
                if point.kind == "period doubling" and point.multiplier.real > 0.0:  # seen from the doubled orbits
                    raise Ended(f"the branch joins the orbits of half its period at {point}")
            orbits.append(sample.orbit)
            if progress is not None:
                progress(before + len(orbits), 2 * steps)
            if len(orbits) > 3 and _passes(march, start, last, sample):
                orbits[-1], end = start.orbit, _CLOSED
                break
    except Ended as ended:
        end = str(ended)
    except KeyboardInterrupt:
        end = _INTERRUPTED
    decided = settled(points, samples)
    return _Way(orbits, decided.points, end, (*notes, *decided.notes))


def _passes(march: Continuation, start: Sample, last: Sample, sample: Sample) -> bool:
    """Return whether the branch has passed its start between two samples, in the direction in which it left it."""
    same_side = (last.value - start.value) * (sample.value - start.value) > 0.0
    if same_side or sample.tests.turning * start.tests.turning < 0:
        return False
    given = sample.place.collocation
    share = (start.value - last.value) / (sample.value - last.value)
    was = orbit_mesh.carried(last.place.collocation, last.place.point, given.mesh, given.degree)[1]
    guess = given.moved(was, arclength.between(given, was, sample.place.point), share)
    try:
        there = finding.orbit_of(given.with_value(start.value), guess._replace(value=0.0))
    except ValueError:
        return False
    gaps = np.abs([there.least - start.orbit.least, there.largest - start.orbit.largest])
    same = gaps <= _SAME * march.measure.scale
    alike = start.place.collocation.turns is None or np.allclose(
        there.states[0], start.orbit.states[0], rtol=0.0, atol=_SAME * float(march.measure.scale.max())
    )
    return bool(same.all() and alike)


def _extended(branch: Branch, task: Task, steps: int, progress: Progress | None) -> Branch:
    """Return the branch with what follows both of its ends."""
    if len(branch.orbits) < 2:
        return _both_ways(branch.orbits[0], task, steps, progress)
    if branch.ends[1] == _CLOSED:
        return branch
    forward = _onward(branch, task, steps, progress, 0)
    turned = replace(branch, orbits=branch.orbits[::-1], ends=branch.ends[::-1])
    backward = _onward(turned, task, steps, progress, len(forward.orbits))
    known = _Way(list(branch.orbits), list(branch.special_points), "", branch.notes)
    return _joined(task, backward, known, forward)


def _onward(branch: Branch, task: Task, steps: int, progress: Progress | None, before: int) -> _Way:
    """Return what follows the last orbit of a branch."""
    if branch.ends[1].startswith(("the branch joins", "the orbit shrinks")):
        return _Way([], [], branch.ends[1])
    scale = np.max([orbit.point.scale for orbit in branch.orbits], axis=0)
    measure = Measure(scale, task.high - task.low)
    try:
        start = sampled(_last_place(branch, task, measure), measure)
    except NoOrbitError as error:
        return _Way([], [], f"no orbit was found at the end of the branch: {error}")
    return _followed(Continuation(task, start, measure, 1.0), start, steps, progress, before)


def _last_place(branch: Branch, task: Task, measure: Measure) -> arclength.CurvePoint:
    """Return the place of the last orbit, going on from the one before it."""
    last = branch.orbits[-1].collocation
    (_, old), (collocation, point) = (lowered(orbit, task.parameter, last) for orbit in branch.orbits[-2:])
    step = measure.unit(collocation, point, arclength.between(collocation, old, point))
    row = measure.row(collocation, point, step)
    return arclength.placed(collocation, point, row, row, measure)
