"""The mean force along wells by public torque-and-drag codes: welleng and torque_drag, station by station.

Both take one step from station to station with the force below it (Johancsik, Friesen and Dawson, SPE 11380): an error
of first order in the distance of stations.  There the change of inclination counts upwards, so that tension lifts a
string where the well builds; welleng 0.30 counts it downwards, and `johancsik` with that sign finds what it finds.
Neither knows buckling: the strings here are not pushed hard enough to buckle.

    pip install --target /tmp/peers welleng torque_drag pandas pint pydantic pyproj pyyaml openpyxl plotly
    PYTHONPATH=/tmp/peers python -m benchmarks drag
"""

from __future__ import annotations

import functools
import importlib.util
import math
import warnings
from collections.abc import Callable, Iterator

import numpy as np

import floquetrod as fr
from benchmarks.measure import Row, best_of

FRICTION = 0.25
TUBING = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
APART = 30.0, 10.0  # m between stations
MOTIONS = {"pushed": ("slackoff", "lowering"), "pulled": ("pickup", "hoisting")}
"""Of ours, what welleng and torque_drag call it."""

CORNERS = {
    "arc": ([0.0, 900.0], [60.0, 90.0], [0.0, 0.0]),
    "S": ([0.0, 300.0, 1200.0, 1800.0, 2700.0], [0.0, 0.0, 45.0, 45.0, 10.0], [0.0] * 5),
    "turn": ([0.0, 1500.0], [75.0, 85.0], [0.0, 90.0]),
}
"""Depths in m, inclinations and azimuths in degrees, between which they change evenly with depth."""


def run() -> list[Row]:
    """Return hook loads, ours and theirs; those of a code that is not installed are left out."""
    peers = {name: peer for name, peer in PEERS.items() if name not in INSTALLED or importlib.util.find_spec(name)}
    return [row for name in CORNERS for motion in MOTIONS for row in rows(name, motion, peers)]


Peer = Callable[[fr.WellPath, str], float]


def rows(name: str, motion: str, peers: dict[str, Peer]) -> Iterator[Row]:
    """Yield hook loads with either distance of stations: ours, and by how much others are off."""
    paths = [path(name, apart) for apart in APART]
    found = [-TUBING.mean_force(each, FRICTION, motion=motion, depth=[0.0]).at_top for each in paths]
    yield Row(f"{name}, {motion}: hook load", found[1], "N")
    if name == "arc":
        closed = arc(paths[1], FRICTION if motion == "pushed" else -FRICTION)
        yield Row(f"{name}, {motion}: off the closed form by", abs(found[1] - closed), "N", at_most=1e-6)
    for label, peer in peers.items():
        off = [peer(each, motion) - ours for each, ours in zip(paths, found, strict=True)]
        for apart, each in zip(APART, off, strict=True):
            yield Row(f"{name}, {motion}: {label}, stations {apart:g} m apart, off by", each, "N")
    if motion == "pushed":
        time = best_of(lambda: TUBING.mean_force(paths[1], FRICTION, depth=[0.0]))
        for label, peer in peers.items():
            if label not in INSTALLED:
                continue
            theirs = best_of(lambda peer=peer: peer(paths[1], motion))  # type: ignore[misc]
            yield Row(f"{name}: time", 1e3 * time, "ms", against=label, peer=1e3 * theirs)


def path(name: str, apart: float) -> fr.WellPath:
    """Return a well with stations so far apart."""
    depth, inclination, azimuth = (np.array(each) for each in CORNERS[name])
    stations = np.linspace(0.0, depth[-1], round(depth[-1] / apart) + 1)
    return fr.WellPath(stations, *(np.radians(np.interp(stations, depth, each)) for each in (inclination, azimuth)))


def arc(well: fr.WellPath, mu: float) -> float:
    """Return the hook load of a string in an arc in N, see docs/theory/mean_force.md."""
    upper, lower = well.inclination[[0, -1]].tolist()
    part = TUBING.weight_per_length * (well.end - well.start) / (lower - upper) / (1.0 + mu * mu)

    def steady(phi: float) -> float:
        return part * ((1.0 - mu * mu) * math.sin(phi) + 2.0 * mu * math.cos(phi))

    return steady(lower) * math.exp(mu * (lower - upper)) - steady(upper)


def johancsik(well: fr.WellPath, motion: str, upwards: float = 1.0) -> float:
    """Return the hook load in N from station to station, inclination counted ``upwards`` or, -1, downwards."""
    phi, psi = well.inclination, well.azimuth
    tension, sign = 0.0, 1.0 if motion == "pulled" else -1.0
    for k in range(len(phi) - 2, -1, -1):
        weight, middle = TUBING.weight_per_length * (well.depth[k + 1] - well.depth[k]), 0.5 * (phi[k] + phi[k + 1])
        bent = upwards * tension * (phi[k] - phi[k + 1]) + weight * math.sin(middle)
        normal = math.hypot(bent, tension * (psi[k] - psi[k + 1]) * math.sin(middle))
        tension += weight * math.cos(middle) + sign * FRICTION * normal
    return tension


def welleng(well: fr.WellPath, motion: str) -> float:
    """Return the hook load in N."""
    from welleng.architecture import BHA, WellBore
    from welleng.survey import Survey
    from welleng.torque_drag import TorqueDrag

    hole, string = WellBore("hole", 0.0, well.end, method="top_down"), BHA("string", 0.0, well.end, method="top_down")
    hole.add_section(bottom=well.end, od=0.2, id=0.12, coeff_friction_sliding=FRICTION)
    string.add_section(bottom=well.end, od=0.05, id=0.04, unit_weight=TUBING.weight_per_length, density=7.85)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that azimuths are taken as of the grid
        survey = Survey(md=well.depth, inc=np.degrees(well.inclination), azi=np.degrees(well.azimuth))
        found = TorqueDrag(survey, hole, string, fluid_density=0.0)
    return float(found.tension[MOTIONS[motion][0]][0])


def torque_drag(well: fr.WellPath, motion: str) -> float:
    """Return the hook load in N."""
    from torque_drag.main import calc

    columns = well.depth, np.degrees(well.inclination), np.degrees(well.azimuth)
    keys = "md", "inc", "azi"
    points = [dict(zip(keys, row, strict=True)) for row in np.transpose(columns).tolist()]
    for k, point in enumerate(points):
        point["delta"] = {key: point[key] - points[max(k - 1, 0)][key] for key in keys}
    pipe = {"od": 2.0, "id": 1.688, "shoe": well.end, "length": well.end}
    area = 0.25 * math.pi * (2.0**2 - 1.688**2) / 39.37**2
    densities = {"rhof": 0.0, "rhod": TUBING.weight_per_length / 9.81 / area / 1e3}
    case = MOTIONS[motion][1]
    found = calc(points, {"pipe": pipe, "odAnn": 4.778}, densities, case, fric=[FRICTION] * len(points))
    return 1e3 * float(found.force[case][0])


INSTALLED = "welleng", "torque_drag"
PEERS: dict[str, Peer] = {
    "welleng": welleng,
    "torque_drag": torque_drag,
    "johancsik": johancsik,
    "johancsik downwards": functools.partial(johancsik, upwards=-1.0),
}
