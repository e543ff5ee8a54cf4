"""Branches of periodic orbits: time, errors of the period and of special points, beside AUTO-07p by bifpy.

AUTO is left out where bifpy is not installed: `pip install bifpy==0.3`, which takes gfortran and make.  Its model is
compiled beforehand; its time holds the process that it starts.  It begins at the Hopf point where the branch has one in
its range, else at the first orbit of our branch, and its forced oscillator has another one appended, u' = u + w v -
u (u^2 + v^2), v' = v - w u - v (u^2 + v^2), that turns with the force.
"""

from __future__ import annotations

import importlib
import importlib.util
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import floquetrod as fr
from benchmarks.measure import Row, best_of
from benchmarks.orbits import FOLDS, SWEPT, duffing


def brusselator(x: Any, p: Any) -> list[Any]:
    """Return the rates of the Brusselator with A = 1."""
    return [1.0 + x[0] * x[0] * x[1] - (p[0] + 1.0) * x[0], p[0] * x[0] - x[0] * x[0] * x[1]]


def lorenz(x: Any, p: Any) -> list[Any]:
    """Return the rates of Lorenz's equations with sigma = 10 and b = 8 / 3."""
    return [10.0 * (x[1] - x[0]), p[0] * x[0] - x[1] - x[0] * x[2], x[0] * x[1] - 8.0 / 3.0 * x[2]]


def van_der_pol(x: Any, p: Any) -> list[Any]:
    """Return the rates of van der Pol's oscillator."""
    return [x[1], p[0] * (1.0 - x[0] * x[0]) * x[1] - x[0]]


def roessler(x: Any, p: Any) -> list[Any]:
    """Return the rates of Roessler's equations with a = b = 0.2."""
    return [-x[1] - x[2], x[0] + 0.2 * x[1], 0.2 + x[2] * (x[0] - p[0])]


def turned_duffing(x: Any, p: Any) -> list[Any]:
    """Return the rates of the forced Duffing oscillator with one appended that turns as cos and -sin of the force."""
    size = x[2] * x[2] + x[3] * x[3]
    turned = [x[2] + p[0] * x[3] - x[2] * size, x[3] - p[0] * x[2] - x[3] * size]
    return [x[1], x[2] - 0.2 * x[1] - x[0] - x[0] * x[0] * x[0], *turned]


def at_rest_in_brusselator(x: Any, p: Any, t: Any) -> None:
    """Set the state of rest at B = 1.5."""
    p[0], x[0], x[1] = 1.5, 1.0, 1.5


def at_rest_in_lorenz(x: Any, p: Any, t: Any) -> None:
    """Set the state of rest at r = 22."""
    p[0], x[0], x[1], x[2] = 22.0, 7.483314773547883, 7.483314773547883, 21.0


class Case(NamedTuple):
    """A model, where an orbit is found, and the range of the parameter; and how AUTO begins."""

    name: str
    rates: Callable[[Any, Any], list[Any]]  # as AUTO has them
    value: float
    start: tuple[float, ...]
    period: float | None
    over: tuple[float, float]
    rest: Callable[[Any, Any, Any], None] | None = None  # a state of rest before the Hopf point
    special: tuple[float, ...] = ()  # values of the parameter at folds and period doublings, known to 1e-12
    forced: Callable[..., Any] | None = None  # the rates of a forced system

    @property
    def system(self) -> fr.NonlinearSystem:
        """The system, of the parameter p."""
        call, p = self.forced, {"p": self.value}
        if call is None:
            return fr.NonlinearSystem(lambda t, x, p: self.rates(x, [p]), parameters=p)
        return fr.NonlinearSystem(lambda t, x, p: call(t, x, p), period="2*pi/p", parameters=p)


DOUBLING = 2.8324450278625
"""The first period doubling of Roessler's orbits, by DOP853 at 3e-14 and Newton's method."""

CASES = [
    Case("Brusselator", brusselator, 3.0, (1.0, 2.0), None, (2.0, 6.0), at_rest_in_brusselator),
    Case("Lorenz", lorenz, 22.0, (-7.5, -7.5, 15.0), 0.8, (15.0, 25.0), at_rest_in_lorenz),
    Case("van der Pol", van_der_pol, 0.1, (2.0, 0.0), None, (0.1, 10.0)),
    Case("Duffing", turned_duffing, SWEPT[0], (0.6, 0.0), None, SWEPT, special=FOLDS, forced=duffing),
    Case("Roessler", roessler, 2.0, (1.0, 1.0, 0.0), 5.8, (2.0, 3.0), special=(DOUBLING,)),
]


def run() -> list[Row]:
    """Return times of branches, ours and AUTO's, and the errors of periods and special points."""
    return [row for case in CASES for row in rows_of(case)]


def rows_of(case: Case) -> list[Row]:
    """Return the rows of one branch."""
    orbit = fr.periodic_orbit(case.system, case.start, case.period)
    seconds, branch = best_of(lambda: follow(orbit, case), repeats=5), follow(orbit, case)
    name, count = f"{case.name}, {len(branch.orbits)} orbits", len(branch.orbits)
    errors = [missed(each, float(each.system.parameters["p"]), each.period) for each in branch.orbits[:: count // 4]]
    rows = of_errors(case, "", max(errors), [point.value for point in branch.special_points])
    if importlib.util.find_spec("bifpy") is None:
        return [Row(name, 1e3 * seconds, "ms"), *rows]
    call = continuation(case, branch.orbits[0])
    points = call()
    theirs = best_of(call, repeats=5)
    kinds = "FOLD", "PERIOD_DOUBLING"
    special = [point.parameters[0] for point in points if point.point_type.name in kinds]
    far = [point for point in points if abs(point.parameters[0] - points[0].parameters[0]) > 0.2 * abs(case.value)]
    nearest = [int(abs(branch.values - point.parameters[0]).argmin()) for point in far]
    known = [(branch.orbits[k], p.parameters[0], p.parameters[1]) for k, p in zip(nearest, far, strict=True)]
    worst = max(missed(*each) for each in known[:: max(1, len(known) // 4)])
    return [
        Row(name, 1e3 * seconds, "ms", f"AUTO-07p, {len(points)}", 1e3 * theirs),
        *rows,
        *of_errors(case, " of AUTO-07p", worst, special),
    ]


def of_errors(case: Case, whose: str, period: float, special: list[float]) -> list[Row]:
    """Return the rows of errors: of the period, which a force gives, and of special points."""
    rows = [] if case.forced else [Row(f"{case.name}, error of the period{whose}", period, "relative")]
    errors = [min((abs(value - known) for value in special), default=math.inf) for known in case.special]
    return [*rows, *([Row(f"{case.name}, error of special points{whose}", max(errors), "of p")] if errors else [])]


def follow(orbit: fr.results.PeriodicOrbit, case: Case) -> fr.Branch:
    """Return our branch, every orbit judged."""
    branch = fr.follow(orbit, over={"p": case.over})
    _ = branch.status
    return branch


def missed(near: fr.results.PeriodicOrbit, value: float, period: float) -> float:
    """Return the error of a period, against an orbit to 1e-12 near another one."""
    exact = fr.periodic_orbit(near.system.with_parameters(p=value), near, tolerance=1e-12)
    return abs(period - exact.period) / exact.period


def continuation(case: Case, first: fr.results.PeriodicOrbit) -> Callable[[], Any]:
    """Return a call of AUTO's continuation from the first Hopf point, or from an orbit, which returns its points."""
    auto: Any = importlib.import_module("bifpy.auto")
    low, high = case.over
    settings: dict[str, Any] = {
        "ndim": len(case.start) + (2 if case.forced else 0),
        "npar": 11,
        "ntst": 50,
        "ncol": 4,
        "iad": 3,
        "ilp": 1,
        "isp": 2,
        "iads": 1,
        "itmx": 9,
    }
    settings |= {"itnw": 7, "nwtn": 3, "jac": 0, "dsmin": 1e-4, "nmx": 300, "a0": -1e300, "a1": 1e300}
    settings |= {"epsl": 1e-7, "epsu": 1e-7, "epss": 1e-5}
    orbits = settings | {"ips": auto.IPS_PERIODIC_ORBIT, "ds": 0.05, "dsmax": 0.3, "rl0": 0.99 * low, "rl1": high}
    if case.rest is not None:
        rest = settings | {"ips": auto.IPS_EQUILIBRIUM, "ds": 0.02, "dsmax": 0.1, "rl0": 0.5 * low, "rl1": 1.2 * high}
        found = auto.run(case.rates, case.rest, rest, icu=[1], transpile=True)
        begin = next(p for b in found.branches for p in b.points if p.point_type.name == "HOPF_BIFURCATION")
        source = auto.IPS_EQUILIBRIUM
    else:
        one = orbits | {"nmx": 1}
        found = auto.run(case.rates, guess(case, first), one, icu=[1, auto.PERIOD_INDEX], transpile=True)
        begin, source = found.branches[0].points[-1], auto.IPS_PERIODIC_ORBIT

    def call() -> Any:
        result = auto.restart(
            case.rates,
            orbits,
            begin,
            icu=[1, auto.PERIOD_INDEX],
            isw=auto.ISW_HOPF_TO_PERIODIC_ORBIT,  # 1, which goes on with a branch of orbits, too
            source_ips=source,
            transpile=True,
        )
        return result.branches[0].points

    return call


def guess(case: Case, orbit: fr.results.PeriodicOrbit) -> Callable[[Any, Any, Any], None]:
    """Return a function that sets an orbit by its largest harmonics, for AUTO to begin at."""
    series = orbit.harmonics[:12]

    def at(x: Any, p: Any, t: Any) -> None:
        p[0], p[10] = float(orbit.system.parameters["p"]), orbit.period
        waves = [(math.cos(2.0 * math.pi * k * t), math.sin(2.0 * math.pi * k * t)) for k in range(len(series))]
        for j in range(series.shape[1]):
            x[j] = sum(float(z.real) * c - float(z.imag) * s for z, (c, s) in zip(series[:, j], waves, strict=True))
        if case.forced:
            x[2], x[3] = waves[1][0], -waves[1][1]

    return at
