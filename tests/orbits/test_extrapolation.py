"""Guesses along branches: how near to the next orbit the cubic through two places is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.orbits import arclength
from floquetrod.orbits.arclength import CurvePoint, Measure
from floquetrod.orbits.continuation import Continuation, Task, sampled, started


def brusselator(t: Any, x: Any, p: float) -> Any:
    return 1.0 + x[0] ** 2 * x[1] - (p + 1.0) * x[0], p * x[0] - x[0] ** 2 * x[1]


def duffing(t: Any, x: Any, p: float) -> Any:
    return x[1], np.cos(p * t) - 0.2 * x[1] - x[0] - x[0] ** 3


def roessler(t: Any, x: Any, p: float) -> Any:
    return -x[1] - x[2], x[0] + 0.2 * x[1], 0.2 + x[2] * (x[0] - p)


def gaps(orbit: fr.results.PeriodicOrbit, over: tuple[float, float], longest: float) -> tuple[float, float]:
    """Return the largest distances of guesses from the orbits on a branch, by the cubic and along the tangent."""
    measure = Measure(orbit.point.scale, over[1] - over[0])
    task = Task("p", *over, 1e-10, longest)
    march = Continuation(task, sampled(started(orbit, task, measure), measure), measure, 1.0)
    places: list[tuple[CurvePoint, Measure]] = [(march.sample.place, march.measure)]
    for _ in range(12):
        places.append((march.advanced().place, march.measure))
    found = []
    for (behind, _), (here, units), (there, _) in zip(places[4:], places[5:], places[6:], strict=False):
        if there.collocation.mesh is not here.collocation.mesh:  # solved again, and turned by a little
            continue
        before, last = arclength.on_mesh(behind, here.collocation.mesh), here
        row = units.row(last.collocation, last.point, last.direction)
        length = arclength.product(row, arclength.between(last.collocation, last.point, there.point))
        guesses = (
            arclength.extrapolated(before, last, row, length),
            last.collocation.moved(last.point, last.direction, length),
        )
        found.append([float((np.abs(each.stages - there.point.stages) / measure.scale).max()) for each in guesses])
    cubic, tangent = np.array(found).max(axis=0).tolist()
    return cubic, tangent


@pytest.mark.slow
@pytest.mark.parametrize(
    ("function", "start", "value", "period", "over"),
    [
        (brusselator, (1.0, 2.0), 3.0, None, (2.0, 6.0)),
        (roessler, (1.0, 1.0, 0.0), 2.4, 5.7, (2.0, 3.0)),
        (duffing, (0.6, 0.0), 0.8, "2*pi/p", (0.5, 2.8)),
    ],
)
def test_the_cubic_is_of_the_fourth_order(
    function: Callable[..., Any], start: tuple[float, ...], value: float, period: Any, over: tuple[float, float]
) -> None:
    """Of autonomous systems in its phase, too: half the step, about sixteen times less of an error."""
    forced = isinstance(period, str)
    system = fr.NonlinearSystem(function, period=period if forced else None, parameters={"p": value})
    orbit = fr.periodic_orbit(system, start, None if forced else period)
    cubic, tangent = gaps(orbit, over, 0.02)
    shorter, straighter = gaps(orbit, over, 0.01)
    assert cubic <= 0.05 * tangent
    assert straighter >= 0.2 * tangent
    assert shorter <= 0.15 * cubic
