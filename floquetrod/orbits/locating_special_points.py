"""Special points between two places of a branch: which kinds there are, and where they lie."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import EPS, Floats
from floquetrod._util.interpolation import lagrange_weights
from floquetrod.orbits import arclength, crossings, orbit_mesh
from floquetrod.orbits.arclength import CurvePoint, Measure
from floquetrod.orbits.collocation import Point, Step
from floquetrod.orbits.continuation import Sample, sampled
from floquetrod.orbits.crossings import OrbitMultipliers, Ranks, Test, doubt, nearest
from floquetrod.orbits.newton import NoOrbitError
from floquetrod.orbits.orbit_extent import returns_after
from floquetrod.orbits.refined_multipliers import refined
from floquetrod.orbits.special_points import Kind, SpecialPoint

_ROOT = 1e-12  # length along the branch to which a test function's zero is found
_NEAR = 0.02  # distance of the places about a branch point from which it is interpolated, part of a step (a choice)
_MOST_STEPS = 25  # of Newton's method, which is slow where the equations are nearly singular
_HIDDEN = 20.0  # times the error of the parameter, up to which rounding decides the sign of its rate (a choice)
_SIDES = np.array([-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0])
_FAILURES = (ValueError, ArithmeticError, RuntimeError, np.linalg.LinAlgError)
_CLOSE = 1e-3  # of a multiplier to where it should be: what is farther is another thing that changes the sign
_APART = 10.0  # times the errors of multipliers, beyond which they do not cross together
_REAL = 1e-6  # of a multiplier, its imaginary part if that is rounding where several coincide (a choice)


class Crossing(NamedTuple):
    """A test function that changes sign between two samples, the kind of point that tells, and what crosses there."""

    kind: Kind
    test: Test
    start: Sample
    end: Sample
    measure: Measure
    ranks: Ranks = ()  # of the multipliers that cross; () where they are not known

    @property
    def together(self) -> int:
        """How many multipliers cross together, of pairs how many pairs."""
        return max(1, len(self.ranks) // 2 if self.kind == "Neimark-Sacker" else len(self.ranks))

    @property
    def change(self) -> int:
        """By how many the number of multipliers outside the unit circle changes; 0 where none need cross."""
        if self.kind == "branch point" and self.test == "turning":
            return 0
        return (2 if self.kind == "Neimark-Sacker" else 1) * self.together


class Located(NamedTuple):
    """Special points between two samples, and why others are not located, in words."""

    points: list[SpecialPoint]
    notes: list[str]
    changes: int = 0  # of the number of multipliers outside, that the points explain


class Watch:
    """The last samples at which the sign of each test function, and the number of multipliers outside, were known."""

    def __init__(self, start: Sample, measure: Measure) -> None:
        """Begin at a sample."""
        self.known = dict.fromkeys(("turning", "plus", "minus", "pairs"), (start, measure))
        self.counted = (start, measure)

    def located(self, sample: Sample, measure: Measure) -> Located:
        """Return the special points from the samples before to one more.

        Signs of products tell single crossings.  Where they do not explain by how many the number of multipliers
        outside the unit circle changes, an even number of them crosses, or several together: then each is located by
        its own magnitude.
        """
        crossings = self.crossings(sample, measure)
        known, count = self._counted(sample, measure)
        crossed = () if count is None else count.ranks
        singles = [each for each in crossings if each.kind != "Neimark-Sacker"]
        if known and sum(each.change for each in singles) == len(crossed):  # real multipliers with the product 1
            crossings = singles
        located = Located([], [])
        if count is None or _explains(sum(each.change for each in crossings if _may_be(each, crossed)), crossed):
            located = _all_located(crossings)
        if count is not None and not _explains(located.changes, crossed):
            turns = next((each for each in crossings if each.test == "turning"), None)
            located = _located_by_ranks(count, turns)
        return located

    def _counted(self, sample: Sample, measure: Measure) -> tuple[bool, Crossing | None]:
        """Return whether the number outside the unit circle is known, and the ranks it passes; None where it stays."""
        (start, units), now = self.counted, crossings.outside(sample.multipliers)
        before = crossings.outside(start.multipliers)
        if now is not None or before is None:
            self.counted = sample, measure
        if before is None or now is None or before == now:
            return before is not None and now is not None, None
        ranks = tuple(range(min(before, now), max(before, now)))
        return True, Crossing("branch point", ranks, start, sample, units, ranks)

    def crossings(self, sample: Sample, measure: Measure) -> list[Crossing]:
        """Return the changes of sign from the samples before to one more."""
        changed = {}
        for name, (before, units) in list(self.known.items()):
            old, new = getattr(before.tests, name), getattr(sample.tests, name)
            if old * new < 0.0:
                changed[name] = (before, units)
            if new != 0.0 or old == 0.0:
                self.known[name] = (sample, measure)
        kinds: list[tuple[Kind, str]] = []
        if "turning" in changed:
            sides = [crossings.value(each.multipliers, "plus") for each in (changed["turning"][0], sample)]
            only = "plus" not in changed and sides[0] * sides[1] > 0.0
            kinds.append(("branch point" if only else "fold", "turning"))
        elif "plus" in changed:
            kinds.append(("branch point", "plus"))
        kinds += [("period doubling", "minus")] if "minus" in changed else []
        kinds += [("Neimark-Sacker", "pairs")] if "pairs" in changed else []
        return [Crossing(kind, test, changed[test][0], sample, changed[test][1]) for kind, test in kinds]


def turning_sign(sample: Sample) -> float:
    """Return the sign of the parameter's rate along the branch; 0 where rounding of the parameter hides it."""
    rate = sample.tests.turning
    return 0.0 if abs(rate) <= _HIDDEN * sample.value_error else math.copysign(1.0, rate)


def settled(points: Sequence[SpecialPoint], samples: Sequence[Sample]) -> Located:
    """Return special points, ``after`` the samples before them, with folds and branch points decided by all samples.

    Where a multiplier passes 1 and rounding hides whether the parameter turns, as where a canard grows, the nearest
    samples at which its direction is known decide; where several points lie between these, nothing is decided.
    """
    signs = [turning_sign(sample) for sample in samples]
    passed = [crossings.value(sample.multipliers, "plus") for sample in samples]
    spans: list[tuple[int, int] | None] = []
    for point in points:
        i = point.after
        hidden = point.kind in ("fold", "branch point") and i + 1 < len(signs) and 0.0 in signs[i : i + 2]
        if not hidden or not passed[i] * passed[i + 1] < 0.0:
            spans.append(None)
            continue
        before = next((k for k in range(i, -1, -1) if signs[k]), -1)
        spans.append((before, next((k for k in range(i + 1, len(signs)) if signs[k]), len(signs))))
    kept, notes = [], []
    for point, span in zip(points, spans, strict=True):
        if span is None:
            kept.append(point)
        elif span[0] >= 0 and span[1] < len(signs) and spans.count(span) == 1:
            turned = signs[span[0]] != signs[span[1]]
            kept.append(replace(point, kind="fold" if turned else "branch point"))
        else:
            notes.append(
                f"a multiplier passes 1 at {point.parameter} = {point.value:.10g}, a fold or a branch point: rounding "
                f"of {point.parameter} hides whether the branch turns there"
            )
    return Located(kept, notes)


def _explains(changes: int, crossed: Ranks) -> bool:
    """Return whether changes of the number outside sum to one of so many, some perhaps in and some out."""
    return changes >= len(crossed) and (changes - len(crossed)) % 2 == 0


def _may_be(crossing: Crossing, crossed: Ranks) -> bool:
    """Return whether a change of sign may be a crossing: of pairs where the multipliers that cross come in pairs."""
    if crossing.kind != "Neimark-Sacker" or not crossed:
        return True
    ends = (crossings.of_ranks(each.multipliers, crossed).values for each in (crossing.start, crossing.end))
    return any((np.abs(values.imag) > _REAL * np.abs(values)).any() for values in ends)


def _all_located(crossings: Sequence[Crossing]) -> Located:
    """Return the special points that changes tell."""
    points, notes, changes = [], [], 0
    for crossing in crossings:
        try:
            special = located(crossing)
        except _FAILURES as error:
            notes.append(_not_located(crossing, f"a {crossing.kind} was not located", error))
        else:
            points += special
            changes += crossing.change if special else 0
    return Located(points, notes, changes)


def _not_located(crossing: Crossing, what: str, error: Exception | None = None) -> str:
    """Return where a special point lies that was not located, and why, in words."""
    name = crossing.start.place.collocation.parameter
    low, high = crossing.start.value, crossing.end.value
    numbers = [crossings.outside(each.multipliers) for each in (crossing.start, crossing.end)]
    where = f"between {name} = {low:.9g} and {high:.9g}"
    if numbers[0] != numbers[1] and None not in numbers:
        where += f", where the number of multipliers outside the unit circle changes from {numbers[0]} to {numbers[1]}"
    return f"{where}, {what}{f': {error}' if error is not None else ''}"


def _located_by_ranks(whole: Crossing, turning: Crossing | None) -> Located:
    """Return the points at which the multipliers of some ranks cross, those that cross together as one."""
    nothing = "no special point was located; shorter steps (longest=) may tell them apart"
    try:
        groups = _groups(whole, turning)
    except _FAILURES as error:
        return Located([], [_not_located(whole, nothing, error)])
    points = _all_located(groups)
    if not points.notes and not _explains(points.changes, whole.ranks):
        return points._replace(notes=[_not_located(whole, nothing)])
    return points


def _groups(whole: Crossing, turning: Crossing | None) -> list[Crossing]:
    """Return the crossings of multipliers of some ranks, each of those that cross at about the same place."""
    from scipy.optimize import brentq

    stretch = _BranchArc(whole)
    near = 0.2 * _NEAR * abs(stretch.whole)
    turn = None if turning is None else _BranchArc(turning).zero(near)
    gathered: dict[tuple[Kind, float], list[int]] = {}
    for rank in whole.ranks:
        length = float(brentq(partial(stretch.at, (rank,)), 0.0, stretch.whole, xtol=near, rtol=1e-14))
        kind = _kind(stretch.beside(length), rank)
        if kind == "branch point" and turn is not None and abs(turn - length) <= 4.0 * near:
            kind = "fold"
        place = next((at for name, at in gathered if name == kind and abs(at - length) <= 2.0 * near), length)
        gathered.setdefault((kind, place), []).append(rank)
    groups = []
    for (kind, _), ranks in sorted(gathered.items(), key=lambda each: each[0][1] / stretch.whole):
        test: Test = "turning" if kind == "fold" else tuple(ranks)
        groups.append(whole._replace(kind=kind, test=test, ranks=tuple(ranks)))
    return groups


def _kind(sample: Sample, rank: int) -> Kind:
    """Return the kind of point at which a multiplier crosses the circle, from its angle."""
    mu = complex(crossings.of_ranks(sample.multipliers, (rank,)).values[0])
    if abs(mu.imag) > _REAL * abs(mu):
        return "Neimark-Sacker"
    return "branch point" if mu.real > 0.0 else "period doubling"


class _BranchArc:
    """The branch from one sample to another by the length along the direction at the first."""

    def __init__(self, crossing: Crossing) -> None:
        """Lay it out on the mesh of the first sample."""
        self.measure, self.base, self.kind, self.test = crossing.measure, crossing.start.place, *crossing[:2]
        self.together = crossing.together
        place, end = self.base, crossing.end.place
        self.row = self.measure.row(place.collocation, place.point, place.direction)
        there = orbit_mesh.carried(end.collocation, end.point, place.collocation.mesh, place.collocation.degree)[1]
        self.change = arclength.between(place.collocation, place.point, there)
        self.whole = arclength.product(self.row, self.change)
        self.samples = {0.0: crossing.start, self.whole: crossing.end}
        self.values = {length: self._test(sample) for length, sample in self.samples.items()}

    def _test(self, sample: Sample) -> float:
        return sample.tests.turning if self.test == "turning" else crossings.value(sample.multipliers, self.test)

    def place(self, length: float) -> CurvePoint:
        """Return the place at a length."""
        collocation = self.base.collocation
        guess = collocation.moved(self.base.point, self.change, length / self.whole)
        ahead = self.row._replace(target=self.row.target + length)
        return arclength.placed(collocation, guess, ahead, self.row, self.measure, _MOST_STEPS)

    def sample(self, length: float) -> Sample:
        """Return the sample at a length."""
        if length not in self.samples:
            self.samples[length] = sampled(self.place(length), self.measure)
        return self.samples[length]

    def beside(self, length: float) -> Sample:
        """Return the sample at a length, or a little before it where the equations are nearly singular there."""
        with contextlib.suppress(NoOrbitError):
            sample = self.sample(length)
            if np.isfinite(sample.multipliers.values).all():
                return sample
        return self.sample(length - _NEAR * self.whole)

    def at(self, test: Test, length: float) -> float:
        """Return a test function of the multipliers at a length; 0 where they are not known, as at a branch point.

        There the equations are singular: Newton's method may fail, and next to it no multiplier may be resolved.
        """
        try:
            value = crossings.value(self.sample(length).multipliers, test)
        except NoOrbitError:
            return 0.0
        return 0.0 if np.isnan(value) else value

    def zero(self, xtol: float) -> float:
        """Return the length at which the test function is zero."""
        from scipy.optimize import brentq

        return float(brentq(self.value, 0.0, self.whole, xtol=xtol, rtol=1e-14))

    def value(self, length: float) -> float:
        """Return the test function at a length."""
        if length not in self.values:
            self.values[length] = self._computed(length)
        return self.values[length]

    def _computed(self, length: float) -> float:
        try:
            if self.test == "turning":
                return float(self.place(length).direction.scalars[-1])
            return self.at(self.test, length) if self.kind == "branch point" else self._test(self.sample(length))
        except NoOrbitError:
            if self.kind == "branch point":  # where the equations are singular, Newton's method may fail
                return 0.0
            raise

    def slope(self, length: float) -> float:
        """Return about the rate of the test function at a length, from the nearest value that is not too near."""
        others = [other for other in self.values if abs(other - length) > 1e-4 * abs(self.whole)]
        other = min(others, key=lambda each: abs(each - length))
        return (self.values[other] - self.value(length)) / (other - length)


def located(crossing: Crossing) -> list[SpecialPoint]:
    """Return the special point that a change of sign tells; none where none is there, as at a neutral saddle.

    Several where multipliers that were taken together cross one after the other.
    """
    # A test function has a zero on the arc of the branch between two samples, at ``length``, found to `_ROOT`;
    # but of a branch point, where the equations are singular, only to near it, and the orbit there interpolated from
    # both sides.  Then what crosses: of several multipliers together, each by itself where they are apart by more than
    # their errors; of one, mu, that it is where this kind of point has it (1, -1, the unit circle), or something else
    # has changed the sign, such as a neutral saddle, and there is no point; and of a turning orbit that is another one
    # run twice, a period doubling of that one.  The error is that of the zero, in the parameter, with the spread.
    stretch = _BranchArc(crossing)
    branching = crossing.kind == "branch point"
    length = stretch.zero(0.2 * _NEAR * abs(stretch.whole) if branching else _ROOT)
    sample, error, rate = _interpolated(stretch, length) if branching else _at(stretch, length)
    multipliers = sample.multipliers
    kind = crossing.kind
    if crossing.together > 1:
        spread, blur = _spread(multipliers, crossing.ranks)
        if spread > _APART * blur and crossing.test != "turning":
            singles = _singles(crossing)
            return [point for each in singles for point in located(each)]
        error += rate * spread
    which = nearest(multipliers, kind)
    mu = complex(multipliers.values[which])
    apart = {"period doubling": abs(mu + 1.0), "Neimark-Sacker": abs(abs(mu) - 1.0)}.get(kind, abs(mu - 1.0))
    if apart > _CLOSE + 10.0 * multipliers.errors[which] or (
        kind == "Neimark-Sacker" and not mu.imag > multipliers.errors[which]
    ):
        return []
    doubled = returns_after(sample.orbit.collocation, sample.orbit.point, 2)
    if kind == "branch point" and stretch.test == "turning" and doubled:
        kind = "period doubling"
    direction = sample.place.direction
    point = SpecialPoint(
        kind,
        sample.place.collocation.parameter or "",
        sample.value,
        error + 4.0 * EPS * abs(sample.value),
        mu,
        sample.orbit,
        direction=Step(direction.nodes, direction.stages[:, :0], direction.scalars),
        measure=crossing.measure,
        count=crossing.together,
    )
    return [point]


def _spread(multipliers: OrbitMultipliers, ranks: Ranks) -> tuple[float, float]:
    """Return how far the magnitudes of some multipliers are from 1, and their errors, at most, as logarithms."""
    values, errors = crossings.of_ranks(multipliers, ranks)
    sizes = np.abs(values)
    return float(np.abs(np.log(sizes)).max()), float((errors / sizes).max())


def _singles(crossing: Crossing) -> list[Crossing]:
    """Return the crossings one by one, of pairs pair by pair."""
    size = 2 if crossing.kind == "Neimark-Sacker" else 1
    every = [crossing.ranks[k : k + size] for k in range(0, len(crossing.ranks), size)]
    return [crossing._replace(test=ranks, ranks=ranks) for ranks in every]


def _at(stretch: _BranchArc, length: float) -> tuple[Sample, float, float]:
    """Return the sample at the zero of a test function, the error of the parameter, and its rate with the function."""
    sample = stretch.sample(length)
    if stretch.test == "turning":
        return sample, sample.value_error, 0.0
    test, blur = _refined_test(sample, stretch)
    rate = abs(sample.place.direction.scalars[-1] / stretch.slope(length))
    return sample, float(rate * (blur + 2.0 * abs(test)) + sample.value_error), float(rate)  # the slope is a secant's


def _refined_test(sample: Sample, stretch: _BranchArc) -> tuple[float, float]:
    """Return the test function and its error, the multipliers that cross refined where they coincide.

    Beside one that crosses alone the others may have any error: the product is zero whatever they are.
    """
    multipliers, test = sample.multipliers, stretch.test
    if test == "turning":
        return sample.tests.turning, 0.0
    if not isinstance(test, str):
        values = crossings.of_ranks(multipliers, test).values
        if stretch.kind == "Neimark-Sacker":
            values = values[values.imag > 0.0]
        known = crossings.value(multipliers, test), doubt(multipliers, test)
        if not len(values) or np.abs(values - values.mean()).max() > _CLOSE:
            return known
        values, error = refined(values, sample.orbit.segments)
        return min(known, (float(np.log(np.abs(values)).mean()), error), key=lambda each: each[1])
    values, errors = multipliers.values.copy(), np.zeros(len(multipliers.values))
    which = nearest(multipliers, stretch.kind)
    pair = int(np.abs(values - values[which].conj()).argmin())
    (values[which],), error = refined(values[[which]], sample.orbit.segments)
    errors[which] = error * abs(values[which])
    if stretch.kind == "Neimark-Sacker":
        values[pair], errors[pair] = values[which].conj(), errors[which]
    multipliers = OrbitMultipliers(values, errors)
    return crossings.value(multipliers, test), doubt(multipliers, test)


def _interpolated(stretch: _BranchArc, length: float) -> tuple[Sample, float, float]:
    """Return the sample at a branch point, where the equations are singular, from places on both sides of it.

    Test function, states and parameter are interpolated by polynomials of degree seven and five, whose difference
    tells the error.
    """
    step = _NEAR * abs(stretch.whole)
    places = length + step * _SIDES
    samples = [stretch.sample(float(each)) for each in places]
    tests, blurs = np.array([_refined_test(each, stretch) for each in samples]).T
    roots, values = [], []
    for used in (slice(0, 8), slice(1, 7)):
        inverse = np.polynomial.Polynomial.fit(places[used], tests[used], len(places[used]) - 1)
        near = [float(root.real) for root in inverse.roots() if abs(root.imag) < step]
        if not near:
            raise ArithmeticError("the test function has no simple zero there")
        roots.append(min(near, key=lambda each: abs(each - length)))
        factors = lagrange_weights(places[used], roots[-1])
        values.append(float(factors @ [each.value for each in samples[used]]))
    factors = lagrange_weights(places, roots[0])
    sample = _combined(samples, factors)
    blur = float(np.abs(factors) @ blurs)
    slope = abs((tests[4] - tests[3]) / (places[4] - places[3]))
    rate = abs(sample.place.direction.scalars[-1]) / max(slope, 1e-300)
    gaps = max(each.value_error for each in samples)
    return sample, float(abs(values[1] - values[0]) + rate * blur + gaps), float(rate)


def _combined(samples: list[Sample], factors: Floats) -> Sample:
    """Return the sample between others."""
    first = samples[len(samples) // 2]
    of = first.compared.collocation
    points = [each.compared.point for each in samples]
    point = Point(*_weighed(factors, points))
    condensed = of.linearised(point)
    flow = None if of.turns else of.rates_at_mesh(point)
    traces = [each.compared.segments.trace for each in samples]
    segments = first.compared.segments._replace(maps=condensed.maps, flow=flow, trace=float(factors @ traces))
    compared = first.compared._replace(point=point, segments=segments)
    steps = [each.place.direction for each in samples]
    direction = Step(*_weighed(factors, steps))
    place = first.place._replace(direction=direction)
    return Sample.of(place, compared)


def _weighed(factors: Floats, every: Sequence[tuple[Any, ...]]) -> list[Any]:
    """Return the sum of tuples, each times its factor."""
    return [sum(f * part for f, part in zip(factors, parts, strict=True)) for parts in zip(*every, strict=True)]
