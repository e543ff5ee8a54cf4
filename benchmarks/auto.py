"""Branches of periodic orbits from Hopf points: time, and error of the period, beside AUTO-07p by bifpy.

AUTO is left out where bifpy is not installed: `pip install bifpy==0.3`, which takes gfortran and make.  Its model is
compiled beforehand; its time holds the process that it starts.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Callable
from typing import Any, NamedTuple

import floquetrod as fr
from benchmarks.measure import Row, best_of


def brusselator(x: Any, p: Any) -> list[Any]:
    """Return the rates of the Brusselator with A = 1."""
    return [1.0 + x[0] * x[0] * x[1] - (p[0] + 1.0) * x[0], p[0] * x[0] - x[0] * x[0] * x[1]]


def lorenz(x: Any, p: Any) -> list[Any]:
    """Return the rates of Lorenz's equations with sigma = 10 and b = 8 / 3."""
    return [10.0 * (x[1] - x[0]), p[0] * x[0] - x[1] - x[0] * x[2], x[0] * x[1] - 8.0 / 3.0 * x[2]]


def at_rest_in_brusselator(x: Any, p: Any, t: Any) -> None:
    """Set the state of rest at B = 1.5."""
    p[0], x[0], x[1] = 1.5, 1.0, 1.5


def at_rest_in_lorenz(x: Any, p: Any, t: Any) -> None:
    """Set the state of rest at r = 22."""
    p[0], x[0], x[1], x[2] = 22.0, 7.483314773547883, 7.483314773547883, 21.0


class Case(NamedTuple):
    """A model, its state of rest before the Hopf point, where an orbit is found, and the range of the parameter."""

    name: str
    rates: Callable[[Any, Any], list[Any]]
    rest: Callable[[Any, Any, Any], None]
    value: float
    start: tuple[float, ...]
    period: float | None
    over: tuple[float, float]


CASES = [
    Case("Brusselator", brusselator, at_rest_in_brusselator, 3.0, (1.0, 2.0), None, (2.0, 6.0)),
    Case("Lorenz", lorenz, at_rest_in_lorenz, 22.0, (-7.5, -7.5, 15.0), 0.8, (15.0, 25.0)),
]


def run() -> list[Row]:
    """Return times of branches, ours and AUTO's, and the errors of the period at their ends."""
    return [row for case in CASES for row in rows_of(case)]


def rows_of(case: Case) -> list[Row]:
    """Return the rows of one branch."""
    system = fr.NonlinearSystem(lambda t, x, p: case.rates(x, [p]), parameters={"p": case.value})
    orbit = fr.periodic_orbit(system, case.start, case.period)
    seconds, branch = best_of(lambda: follow(orbit, case), repeats=5), follow(orbit, case)
    name, count = f"{case.name}, {len(branch.orbits)} orbits", len(branch.orbits)
    errors = [missed(each, float(each.system.parameters["p"]), each.period) for each in branch.orbits[:: count // 4]]
    rows = [Row(f"{case.name}, error of the period", max(errors), "relative")]
    if importlib.util.find_spec("bifpy") is None:
        return [Row(name, 1e3 * seconds, "ms"), *rows]
    call = continuation(case)
    points = call()
    theirs = best_of(call, repeats=5)
    far = [point for point in points if abs(point.parameters[0] - points[0].parameters[0]) > 0.2 * abs(case.value)]
    nearest = [int(abs(branch.values - point.parameters[0]).argmin()) for point in far]
    known = [(branch.orbits[k], p.parameters[0], p.parameters[1]) for k, p in zip(nearest, far, strict=True)]
    worst = max(missed(*each) for each in known[:: max(1, len(known) // 4)])
    return [
        Row(name, 1e3 * seconds, "ms", f"AUTO-07p, {len(points)}", 1e3 * theirs),
        *rows,
        Row(f"{case.name}, that of AUTO-07p", worst, "relative"),
    ]


def follow(orbit: fr.results.PeriodicOrbit, case: Case) -> fr.Branch:
    """Return our branch, every orbit judged."""
    branch = fr.follow(orbit, over={"p": case.over})
    _ = branch.status
    return branch


def missed(near: fr.results.PeriodicOrbit, value: float, period: float) -> float:
    """Return the error of a period, against an orbit to 1e-12 near another one."""
    exact = fr.periodic_orbit(near.system.with_parameters(p=value), near, tolerance=1e-12)
    return abs(period - exact.period) / exact.period


def continuation(case: Case) -> Callable[[], Any]:
    """Return a call of AUTO's continuation of the orbits from the first Hopf point, which returns its points."""
    auto: Any = importlib.import_module("bifpy.auto")
    low, high = case.over
    n = len(case.start)
    settings: dict[str, Any] = {
        "ndim": n,
        "npar": 1,
        "ntst": 50,
        "ncol": 4,
        "iad": 3,
        "ilp": 1,
        "isp": 2,
        "iads": 1,
        "itmx": 9,
    }
    settings |= {"itnw": 7, "nwtn": 3, "jac": 0, "dsmin": 1e-4, "nmx": 200, "a0": -1e300, "a1": 1e300}
    settings |= {"epsl": 1e-7, "epsu": 1e-7, "epss": 1e-5}
    rest = settings | {"ips": auto.IPS_EQUILIBRIUM, "ds": 0.02, "dsmax": 0.1, "rl0": 0.5 * low, "rl1": 1.2 * high}
    found = auto.run(case.rates, case.rest, rest, icu=[1], transpile=True)
    hopf = next(p for b in found.branches for p in b.points if p.point_type.name == "HOPF_BIFURCATION")
    orbits = settings | {"ips": auto.IPS_PERIODIC_ORBIT, "ds": 0.05, "dsmax": 0.3, "rl0": 0.99 * low, "rl1": high}

    def call() -> Any:
        result = auto.restart(
            case.rates,
            orbits,
            hopf,
            icu=[1, auto.PERIOD_INDEX],
            isw=auto.ISW_HOPF_TO_PERIODIC_ORBIT,
            source_ips=auto.IPS_EQUILIBRIUM,
            transpile=True,
        )
        return result.branches[0].points

    return call
