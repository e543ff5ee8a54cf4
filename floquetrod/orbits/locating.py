"""Special points between two places of a branch: which kinds there are, and where they lie."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod._util.interpolation import lagrange_weights
from floquetrod.orbits import arclength, crossings
from floquetrod.orbits import mesh as meshes
from floquetrod.orbits.arclength import Measure, Place
from floquetrod.orbits.collocation import Point, Step
from floquetrod.orbits.continuation import Sample, sampled
from floquetrod.orbits.crossings import Multipliers, doubt, nearest
from floquetrod.orbits.extents import returns_after
from floquetrod.orbits.newton import NoOrbitError
from floquetrod.orbits.sensitivity import error_of
from floquetrod.orbits.special_points import Kind, SpecialPoint

_ROOT = 1e-12  # length along the branch to which a test function's zero is found
_NEAR = 0.02  # distance of the places about a branch point from which it is interpolated, part of a step (a choice)
_MOST_STEPS = 25  # of Newton's method, which is slow where the equations are nearly singular
_SIDES = np.array([-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0])
_CLOSE = 1e-3  # of a multiplier to where it should be: what is farther is another thing that changes the sign


class Crossing(NamedTuple):
    """A test function that changes sign between two samples, and the kind of point that tells."""

    kind: Kind
    test: str
    start: Sample
    end: Sample
    measure: Measure


class Watch:
    """The last sample at which the sign of each test function was known."""

    def __init__(self, start: Sample, measure: Measure) -> None:
        """Begin at a sample."""
        self.known = dict.fromkeys(("turning", "plus", "minus", "pairs"), (start, measure))

    def crossings(self, found: Sample, measure: Measure) -> list[Crossing]:
        """Return the changes of sign from the samples before to one more."""
        changed = {}
        for name, (before, units) in list(self.known.items()):
            old, new = getattr(before.tests, name), getattr(found.tests, name)
            if old * new < 0.0:
                changed[name] = (before, units)
            if new != 0.0 or old == 0.0:
                self.known[name] = (found, measure)
        kinds: list[tuple[Kind, str]] = []
        if "turning" in changed:
            sides = [crossings.value(each.multipliers, "plus") for each in (changed["turning"][0], found)]
            only = "plus" not in changed and sides[0] * sides[1] > 0.0
            kinds.append(("branch point" if only else "fold", "turning"))
        elif "plus" in changed:
            kinds.append(("branch point", "plus"))
        kinds += [("period doubling", "minus")] if "minus" in changed else []
        kinds += [("Neimark-Sacker", "pairs")] if "pairs" in changed else []
        return [Crossing(kind, test, changed[test][0], found, changed[test][1]) for kind, test in kinds]


class _Stretch:
    """The branch from one sample to another by the length along the direction at the first."""

    def __init__(self, crossing: Crossing) -> None:
        """Lay it out on the mesh of the first sample."""
        self.measure, self.base, self.kind, self.test = crossing.measure, crossing.start.place, *crossing[:2]
        place, end = self.base, crossing.end.place
        self.row = self.measure.row(place.collocation, place.point, place.direction)
        there = meshes.carried(end.collocation, end.point, place.collocation.mesh, place.collocation.degree)[1]
        self.change = arclength.between(place.collocation, place.point, there)
        self.whole = arclength.product(self.row, self.change)
        self.values = {0.0: self._test(crossing.start), self.whole: self._test(crossing.end)}

    def _test(self, sample: Sample) -> float:
        return sample.tests.turning if self.test == "turning" else crossings.value(sample.multipliers, self.test)

    def place(self, length: float) -> Place:
        """Return the place at a length."""
        collocation = self.base.collocation
        guess = collocation.moved(self.base.point, self.change, length / self.whole)
        ahead = self.row._replace(target=self.row.target + length)
        return arclength.placed(collocation, guess, ahead, self.row, self.measure, _MOST_STEPS)

    def sample(self, length: float) -> Sample:
        """Return what is known at a length."""
        return sampled(self.place(length), self.measure)

    def value(self, length: float) -> float:
        """Return the test function at a length."""
        if length not in self.values:
            self.values[length] = self._computed(length)
        return self.values[length]

    def _computed(self, length: float) -> float:
        try:
            if self.test == "turning":
                return float(self.place(length).direction.scalars[-1])
            return self._test(self.sample(length))
        except NoOrbitError:
            if self.kind == "branch point":  # where the equations are singular, Newton's method may fail
                return 0.0
            raise

    def slope(self, length: float) -> float:
        """Return about the rate of the test function at a length, from the nearest value that is not too near."""
        others = [other for other in self.values if abs(other - length) > 1e-4 * abs(self.whole)]
        other = min(others, key=lambda each: abs(each - length))
        return (self.values[other] - self.value(length)) / (other - length)


def located(crossing: Crossing) -> SpecialPoint | None:
    """Return the special point that a change of sign tells; None where none is there, as at a neutral saddle."""
    from scipy.optimize import brentq

    stretch = _Stretch(crossing)
    branching = crossing.kind == "branch point"
    xtol = 0.2 * _NEAR * abs(stretch.whole) if branching else _ROOT
    length = float(brentq(stretch.value, 0.0, stretch.whole, xtol=xtol, rtol=1e-14))
    sample, error = _interpolated(stretch, length) if branching else _at(stretch, length)
    found = sample.multipliers
    kind = crossing.kind
    which = nearest(found, kind)
    mu = complex(found.values[which])
    apart = {"period doubling": abs(mu + 1.0), "Neimark-Sacker": abs(abs(mu) - 1.0)}.get(kind, abs(mu - 1.0))
    if apart > _CLOSE + 10.0 * found.errors[which] or (kind == "Neimark-Sacker" and not mu.imag > found.errors[which]):
        return None
    doubled = returns_after(sample.orbit.collocation, sample.orbit.point, 2)
    if kind == "branch point" and stretch.test == "turning" and doubled:
        kind = "period doubling"
    direction = sample.place.direction
    return SpecialPoint(
        kind,
        sample.place.collocation.parameter or "",
        sample.value,
        error,
        mu,
        sample.orbit,
        direction=Step(direction.nodes, direction.stages[:, :0], direction.scalars),
        measure=crossing.measure,
    )


def _at(stretch: _Stretch, length: float) -> tuple[Sample, float]:
    """Return the sample at the zero of a test function, and the error of the parameter there."""
    sample = stretch.sample(length)
    if stretch.test == "turning":
        return sample, sample.value_error
    blur = _blur(sample, stretch)
    rate = abs(sample.place.direction.scalars[-1] / stretch.slope(length))
    return sample, float(rate * (blur + abs(stretch.value(length))) + sample.value_error)


def _blur(sample: Sample, stretch: _Stretch) -> float:
    """Return the error of the test function from that of the multiplier that crosses."""
    values = sample.multipliers.values
    which = nearest(sample.multipliers, stretch.kind)
    errors = np.zeros(len(values))
    errors[which] = error_of(complex(values[which]), sample.orbit.segments)
    if stretch.kind == "Neimark-Sacker":
        errors[int(np.abs(values - values[which].conj()).argmin())] = errors[which]
    return doubt(Multipliers(values, errors), stretch.test)


def _interpolated(stretch: _Stretch, length: float) -> tuple[Sample, float]:
    """Return the sample at a branch point, where the equations are singular, from places on both sides of it.

    Test function, states and parameter are interpolated by polynomials of degree seven and five, whose difference
    tells the error.
    """
    step = _NEAR * abs(stretch.whole)
    places = length + step * _SIDES
    samples = [stretch.sample(float(each)) for each in places]
    tests = np.array([stretch._test(each) for each in samples])
    roots, values = [], []
    for used in (slice(0, 8), slice(1, 7)):
        inverse = np.polynomial.Polynomial.fit(places[used], tests[used], len(places[used]) - 1)
        near = [float(root.real) for root in inverse.roots() if abs(root.imag) < step]
        roots.append(min(near, key=lambda each: abs(each - length)))
        factors = lagrange_weights(places[used], roots[-1])
        values.append(float(factors @ [each.value for each in samples[used]]))
    factors = lagrange_weights(places, roots[0])
    sample = _combined(samples, factors)
    blur = _blur(samples[len(samples) // 2], stretch) if stretch.test == "plus" else 0.0
    slope = abs((tests[4] - tests[3]) / (places[4] - places[3]))
    rate = abs(sample.place.direction.scalars[-1]) / max(slope, 1e-300)
    gaps = max(each.value_error for each in samples)
    return sample, float(abs(values[1] - values[0]) + rate * blur + gaps)


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
