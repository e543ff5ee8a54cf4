"""Strings in wells: a verdict on 300 m of tubing, straight, in a bend and in a turn, and how far one can be pushed.

Set OPENBLAS_NUM_THREADS=1 for times of one thread.
"""

from __future__ import annotations

import warnings
from functools import partial

import numpy as np

import floquetrod as fr
from benchmarks.measure import Row, best_of

SECTION = 300.0  # m
DEPTHS = 100  # at which the force at the upper end of a reach is computed
STATIONS = np.linspace(0.0, SECTION, 11)
PATHS = {
    "straight": None,
    "in a bend": fr.WellPath.arc(length=SECTION, inclination=(1.2, 1.5)),
    "in a turn": fr.WellPath(STATIONS, 1.2 + 0.002 * STATIONS**0.5, STATIONS / 1500.0),
}
"""Channels; in the bend and in the turn the weight along the string couples its modes."""


def run() -> list[Row]:
    """Return the times of verdicts and of a reach with what was promised."""
    return [*verdicts(), *reach()]


def verdicts() -> list[Row]:
    """Return the times of verdicts on 300 m of 2 inch tubing, shaken by a uniform force and by an axial wave."""
    tubing = _tubing(SECTION, damping_rate=0.2)
    rows = []
    for name, path in PATHS.items():
        rod = tubing if path is None else tubing.replace(path=path, inclination=None)
        forces = 0.4 * rod.critical_force, 0.1 * rod.critical_force, 18.0
        for kind, load in (("", fr.AxialLoad.hertz(*forces)), (", wave", fr.AxialWave.hertz(*forces))):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", fr.UniformForceWarning)
                modes = rod.stability(load).modes_checked
                spent = best_of(partial(rod.stability, load))
            rows.append(Row(f"300 m {name}{kind}, {modes} modes: a verdict", 1e3 * spent, "ms", at_most=10.0))
    return rows


def reach() -> list[Row]:
    """Return the times of a reach of 5 km, without and with a tool."""
    well = fr.WellPath([0.0, 1500.0, 2200.0, 5200.0], ["0deg", "0deg", "90deg", "90deg"])
    depths, shaken = np.linspace(100.0, 5000.0, DEPTHS), fr.VibrationTool(5000.0, "18Hz", 20.0)
    rows = []
    for string, rod in (("", _tubing(1.0)), (", five sections in two bores", _tapered())):
        for name, tool in (("", None), (" with a tool", shaken)):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                spent = best_of(lambda rod=rod, tool=tool: rod.reach(well, 0.25, tool=tool, depth=depths), repeats=2)
            rows.append(Row(f"reach of 5 km at {DEPTHS} depths{string}{name}", spent, "s", at_most=5.0))
    return rows


def _tapered() -> fr.Rod:
    """Return four walls of 2 inch tubing above a tool, in a casing and an open hole."""
    walls = zip((0.156, 0.175, 0.188, 0.203), (1800.0, 1500.0, 1200.0, 690.0), strict=True)
    tubing = [fr.Section(f"2.00x{wall:.3f}", length=length) for wall, length in walls]
    tool = fr.Section(diameter="2.875in", inner_diameter="1in", length="10m")
    bores = [("0m", "4.892in"), ("2200m", "6.1in")]
    return fr.Rod(sections=[*tubing, tool], bores=bores, fluid_inside=1000.0, fluid_outside=1000.0)


def _tubing(length: float, damping_rate: float = 0.0) -> fr.Rod:
    """Return 2 inch tubing in a 5.5 inch casing, filled with water in water."""
    water = {"fluid_inside": 1000.0, "fluid_outside": 1000.0}
    return fr.Rod.catalogue("2.00x0.156", bore="4.892in", length=length, damping_rate=damping_rate, **water)
