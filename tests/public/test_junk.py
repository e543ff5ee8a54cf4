"""Every argument of every public callable, given junk: TypeError or ValueError that names it, or a sane answer."""

from __future__ import annotations

import dataclasses
import datetime
import functools
import inspect
import math
import types
import zlib
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy

import floquetrod as fr
from floquetrod.floquet.verdict import FloquetVerdict
from floquetrod.methods import monodromy_matrix
from tests.conftest import depth
from tests.fuzz.junk import LONGEST_MESSAGE, Endless, Raising, loop, objects, tree
from tests.seams import Tuned

ROD = fr.Rod.nitinol()
TUBE = ROD.replace(inner_radius=0.4e-3)
WELL = fr.WellPath.straight(length=30.0, inclination=0.1)
LOAD = fr.AxialLoad(mean=0.3, amplitude=0.3, frequency=150.0)
MATHIEU = fr.Mathieu(0.5, -0.25)
CLAMPED = fr.Rod(207e9, 7850.0, 0.01, 9.0, 0.05, ends="clamped-hinged")
PUSH: dict[str, Any] = {"mean": 500.0, "amplitude": 700.0, "frequency": 29.0}
WAVE = fr.AxialWave(**PUSH, axial_damping=3.0)
UNCOUPLED: dict[str, Any] = {"criterion": None, "friction": None, "kick": None}
KICKED = fr.FrictionalMathieu(1.0, 0.3, 1.0)
TIME = np.linspace(0.0, 1.0, 200)
KICK = fr.Perturbation.modes({8: 0.05})
ALL: dict[str, Any] = {"alpha": 0.5, "beta": -0.25, "damping": 0.01, "workers": 1}
LOADS: dict[str, Any] = {"mean": 0.3, "amplitude": 0.3, "frequency": 150.0}
KICKS: dict[str, Any] = {"alpha": 1.0, "beta": 0.3, "gamma": 1.0, "damping": 0.01, "workers": 1}


def decays(t: Any, x: Any, rate: float) -> Any:
    return (np.cos(math.pi * t) - rate * x[0],)


DRIVEN = fr.NonlinearSystem(decays, period=2.0, parameters={"rate": 1.0})
DRIVEN_ORBIT = fr.periodic_orbit(DRIVEN, [0.3])
DAMPED = fr.HillSystem([[1.0]], damping=[[0.2]])

UNDER_NOISE = {"equation": DAMPED, "noise": [([[1.0]], 0.1)], "interpretation": "ito"}

OPTIONS: list[tuple[Any, str, dict[str, Any]]] = [
    (MATHIEU, "determinant", {"terms": 40}),
    (MATHIEU, "monodromy", {"rtol": 1e-10}),
    (MATHIEU, "leapfrog", {"step": 1e-2, "periods": 10, "limit": 1e6}),
    (MATHIEU, "reference", {"digits": 20}),
    (MATHIEU.as_system(), "reference", {"most_digits": 30}),
    (fr.DelaySystem([[1.0]], delayed=[(1.0, [[0.1]])]), "collocation", {"above": 0.2}),
    (fr.DelaySystem([[1.0]], delayed=[(1.0, [[0.1]])]), "winding", {"above": 0.2}),
]

CALLS: list[tuple[Callable[..., Any], dict[str, Any]]] = [
    (fr.Mathieu, {"alpha": 0.5, "beta": -0.25, "damping": 0.0}),
    (fr.Meissner, {"alpha": 0.5, "beta": -0.25, "damping": 0.0}),
    (fr.Hill, {"mean": -0.25, "cosines": (0.1,), "sines": (0.2,), "period": 6.0, "damping": 0.0}),
    (fr.FrictionalMathieu, {"alpha": 0.5, "beta": -0.25, "gamma": 1.0, "damping": 0.0}),
    (MATHIEU.coefficient, {"tau": 1.0}),
    (
        fr.HillSystem,
        {
            "stiffness": [[1.0]],
            "cosines": [[[0.1]]],
            "sines": [[[0.2]]],
            "mass": [[2.0]],
            "damping": [[0.1]],
            "gyroscopic": [[0.0]],
            "period": 6.0,
            "coefficient_error": 0.0,
            "pieces": (),
        },
    ),
    (
        fr.DelaySystem,
        {
            "stiffness": [[1.0]],
            "cosines": [[[0.1]]],
            "sines": [[[0.2]]],
            "mass": [[2.0]],
            "damping": [[0.1]],
            "gyroscopic": [[0.0]],
            "period": 6.0,
            "delayed": [(1.0, [[0.1]])],
            "coefficient_error": 0.0,
        },
    ),
    (
        fr.PeriodicSystem,
        {
            "mean": [[1.0]],
            "cosines": [[[0.1]]],
            "sines": [[[0.2]]],
            "period": 6.0,
            "coefficient_error": 0.0,
            "pieces": (),
        },
    ),
    (fr.PeriodicSystem.from_function, {"function": lambda t: [[1.0]], "period": 6.0, "jumps": [1.0]}),
    (fr.PeriodicSystem.from_samples, {"times": [0.0, 1.0, 2.0, 3.0, 4.0], "values": [[[1.0]]] * 5, "period": 5.0}),
    (
        fr.HillSystem.from_samples,
        {"times": [0.0, 1.0, 2.0, 3.0, 4.0], "values": [[[1.0]]] * 5, "period": 5.0}
        | {"mass": [[1.0]], "damping": [[0.1]], "gyroscopic": [[0.0]]},
    ),
    (
        fr.DelaySystem.from_function,
        {"function": lambda t: [[1.0]], "period": 6.0, "jumps": [1.0], "delayed": [(1.0, lambda t: [[0.1]])]}
        | {"mass": [[1.0]], "damping": [[0.1]], "gyroscopic": [[0.0]]},
    ),
    (
        fr.DelaySystem.from_samples,
        {"times": [0.0, 1.0, 2.0, 3.0, 4.0], "values": [[[1.0]]] * 5, "period": 5.0}
        | {"mass": [[1.0]], "damping": [[0.1]], "gyroscopic": [[0.0]], "delayed": [(1.0, [[0.1]])]},
    ),
    (fr.PeriodicSystem.from_pieces, {"pieces": [(1.0, [[1.0]])], "coefficient_error": 0.0}),
    (
        fr.HillSystem.from_pieces,
        {
            "pieces": [(1.0, [[1.0]]), (2.0, [[3.0]])],
            "mass": [[1.0]],
            "damping": [[0.1]],
            "gyroscopic": [[0.0]],
            "coefficient_error": 0.0,
        },
    ),
    (fr.Hill.from_function, {"function": lambda t: 1.0, "period": 6.0, "damping": 0.1, "jumps": [1.0]}),
    (fr.equations.Varying, {"start": [[1.0]], "slope": [[1.0]], "cosines": [[[1.0]]], "sines": [[[1.0]]]}),
    (fr.equations.Varying, {"mean": [[1.0]]}),
    (fr.HillSystem([[1.0]]).coefficient, {"t": 1.0}),
    (
        fr.chart,
        {
            "family": lambda **given: fr.Mathieu(given["a"], given["b"]),
            "over": {"a": (0.0, 1.0, 2), "b": (-1.0, 0.0, 2)},
            "growth": False,
            "growth_tolerance": 0.0,
            "workers": 1,
            "progress": None,
        },
    ),
    (fr.Meissner(0.5, -0.25).coefficient, {"tau": 1.0}),
    (fr.Hill(-0.25, (0.1,)).coefficient, {"tau": 1.0}),
    (fr.conventions.to_aq, {"alpha": 0.5, "beta": -0.25}),
    (fr.conventions.from_aq, {"a": 0.5, "q": -0.25}),
    (fr.conventions.to_delta_epsilon, {"alpha": 0.5, "beta": -0.25}),
    (fr.conventions.from_delta_epsilon, {"delta": 0.5, "epsilon": -0.25}),
    (fr.stability, {"equation": MATHIEU, "method": "spectral"}),
    (fr.stability, UNDER_NOISE),
    (fr.certify, UNDER_NOISE),
    (fr.compare, {"equation": MATHIEU}),
    (fr.compare, {"equation": MATHIEU, "force": 1.0, "frequency": 0.3, "unstable": True}),
    (
        fr.compare,
        {"equation": MATHIEU, "force": 1.0, "cosines": (0.5,), "sines": (0.1,), "jumps": (), "unstable": True},
    ),
    (
        fr.response,
        {"equation": MATHIEU, "force": 1.0, "cosines": (0.5,), "sines": (0.1,), "method": "hill", "unstable": True},
    ),
    (fr.response, {"equation": MATHIEU, "force": math.cos, "jumps": (0.0,), "frequency": None, "unstable": True}),
    (fr.gain, {"equation": DAMPED, "at": 0, "out": 0, "frequency": (0.5, 1.5), "waves": (0, -1)}),
    (fr.output_noise, {"equation": DAMPED, "intensity": [0.3], "density": None, "method": "auto"}),
    (fr.certify, {"equation": MATHIEU, "max_digits": 30, "growth_tolerance": 0.0, "max_boxes": 10, "seconds": 5.0}),
    (
        lambda **given: fr.certify(fr.Mathieu, **given),
        {"alpha": (0.4, 0.5), "beta": (-0.8, -0.7), "damping": 0, "growth_tolerance": 0.1, "max_boxes": 10},
    ),
    (lambda **given: fr.certify(fr.Mathieu, **given), {"alpha": "1/3", "beta": "-0.25", "damping": "0"}),
    (lambda **given: fr.stability(MATHIEU, "determinant", **given), {"terms": 40}),
    (lambda **given: fr.stability(MATHIEU, "monodromy", **given), {"rtol": 1e-10}),
    (lambda **given: fr.stability(MATHIEU, "leapfrog", **given), {"step": 0.01, "periods": 10, "limit": 1e3}),
    (lambda **given: fr.stability(MATHIEU, "reference", **given), {"digits": 20}),
    (monodromy_matrix, {"equation": MATHIEU, "rtol": 1e-10, "start": 0.5}),
    (fr.mathieu.is_stable, ALL),
    (fr.mathieu.growth_rate, ALL),
    (fr.mathieu.discriminant, ALL),
    (fr.mathieu.multipliers, ALL),
    (
        fr.mathieu.chart,
        {
            "alpha": (0.0, 1.0, 2),
            "beta": (-1.0, 0.0, 2),
            "damping": 0.0,
            "equation": fr.Mathieu,
            "growth": False,
            "growth_tolerance": 0.0,
            "criterion": None,
            "workers": 1,
            "progress": None,
        },
    ),
    (fr.mathieu.characteristic_values, {"order": 3, "q": 1.0, "kind": "a", "workers": 1}),
    (fr.mathieu.tongue_widths, {"order": 2, "q": 0.5, "workers": 1}),
    (fr.mathieu.real_order_values, {"order": 0.5, "q": 1.0}),
    (fr.mathieu.characteristic_function, {"order": 3, "q": 1.0, "kind": "a"}),
    (fr.mathieu.floquet_solutions, {"equation": fr.Mathieu(0.5, -0.3), "per": "z"}),
    (fr.mathieu.exponents, {"alpha": 0.5, "beta": -0.3, "damping": 0.1, "per": "z", "workers": 1}),
    (fr.NonlinearSystem, {"function": decays, "jacobian": None, "period": 2.0, "parameters": {"rate": 1.0}}),
    (fr.second_moments, {"system": DAMPED, "noise": [([[1.0]], 0.1)], "interpretation": "ito"}),
    (fr.critical_noise, {"system": DAMPED, "noise": [([[1.0]], 0.1)], "interpretation": "ito"}),
    (
        fr.almost_sure_exponent,
        {"system": DAMPED, "noise": [([[1.0]], 0.1)], "interpretation": "ito", "paths": 10, "time": 10.0}
        | {"confidence": 0.9, "seed": 1, "progress": None},
    ),
    (
        fr.filtered_growth,
        {"system": DAMPED, "matrix": [[1.0]], "filter": ([[-1.0]], [0.1], [1.0]), "accuracy": 1e-4, "most": 6},
    ),
    (
        fr.quasiperiodic_growth,
        {"equation": fr.TwoFrequencies(DAMPED, 1.7, [[[0.1]]]), "tolerance": 1e-2, "most": 10},
    ),
    (
        fr.TwoFrequencies,
        {"equation": DAMPED, "frequency": 1.7, "cosines": [[[0.1]]], "sines": ()},
    ),
    (
        fr.follow,
        {"orbit": DRIVEN_ORBIT, "over": {"rate": (0.9, 1.1)}, "steps": 2, "longest": 0.04, "tolerance": 1e-8}
        | {"until": None, "progress": None},
    ),
    (fr.periodic_orbit, {"system": DRIVEN, "start": [1.0], "period": 2.0, "winding": None, "tolerance": 1e-6}),
    (fr.solve, {"equation": fr.Mathieu(0.5, -0.3), "initial": (1.0, 0.0), "span": 2.0}),
    (fr.floquet_solutions, {"equation": fr.Meissner(0.5, -0.3)}),
    (fr.bands, {"potential": math.cos, "phase": [0.0, 1.0], "below": 2.0, "period": 6.0 * math.pi, "jumps": [1.0]}),
    (
        functools.partial(fr.margin, fr.Mathieu, alpha=0.1, beta=-0.5),
        {"along": "beta", "within": (-1.0, 0.0), "samples": 5},
    ),
    (fr.Mathieu.from_aq, {"a": 1.0, "q": 1.0, "damping": 0.1}),
    (fr.Mathieu.from_delta_epsilon, {"delta": 0.6, "epsilon": 0.2, "damping": 0.1}),
    (fr.mathieu.transition_curves, {"alpha": [0.1, 0.2], "orders": 2}),
    (fr.FiniteTimeCriterion, {"periods": 10, "limit": 1e6, "by": "exact", "step": 0.01}),
    (fr.FiniteTimeCriterion().growth, ALL),
    (fr.FiniteTimeCriterion().is_stable, ALL),
    (fr.AxialLoad, LOADS | {"mean_at": 0.3, "waveform": (0.5 - 1j, 0.2), "noise": 0.0, "second": (0.1, 37.0)}),
    (fr.AxialLoad.hertz, LOADS),
    (fr.VibrationTool, {"amplitude": 5e3, "frequency": 100.0, "above_end": 30.0, "second": (0.1, 37.0)}),
    (
        ROD.mean_force,
        {"path": WELL, "friction": 0.2, "motion": "pushed", "far_force": 0.1, "bottom": 20.0, "depth": [10.0]}
        | {"tool": fr.VibrationTool(1.0, 100.0, 3.0), "speed": 0.05, "helical": "energy"}
        | {"wellhead_pressure": 1e4, "stripper": 0.1},
    ),
    (
        ROD.surface_weights,
        {"path": WELL, "friction": [0.2, 0.3], "far_force": 0.1, "depth": [10.0], "helical": "energy"}
        | {"wellhead_pressure": 1e4, "stripper": 0.1},
    ),
    (
        TUBE.reach,
        {"path": WELL, "friction": 0.2, "tool": fr.VibrationTool(1.0, 100.0, 3.0), "speed": 0.05}
        | {"far_force": 0.1, "push": 3.0, "depth": [10.0], "helical": "energy", "yield_share": 0.8}
        | {"wellhead_pressure": 1e4, "stripper": 0.1, "pressure_inside": 2e4},
    ),
    (fr.ToolMode, {"frequency": "922Hz", "damping_ratio": 0.011, "mass": "39.93g"}),
    (fr.ToolMode, {"frequency": "922Hz", "damping_ratio": 0.011, "stiffness": "1.3N/um"}),
    (
        fr.Milling,
        {
            "x": [fr.ToolMode("922Hz", 0.011, "39.93g")],
            "y": [fr.ToolMode("922Hz", 0.011, "39.93g")],
            "teeth": 2,
            "tangential": "600MPa",
            "radial": "200MPa",
            "immersion": 0.5,
            "direction": "up",
            "pitch": ["170deg", "190deg"],
            "helix": "30deg",
            "diameter": "12mm",
            "runout": ["0um", "10um"],
            "feed_per_tooth": "0.1mm",
        },
    ),
    (fr.WellPath, {"depth": [0.0, 900.0], "inclination": [0.0, 0.1], "azimuth": [0.0, 0.5]}),
    (fr.WellPath.arc, {"length": 30.0, "inclination": (0.0, 0.1), "azimuth": 0.5, "depth": 900.0}),
    (fr.WellPath.straight, {"length": 30.0, "inclination": 0.1, "azimuth": 0.5, "depth": 900.0}),
    (WELL.part, {"start": 10.0, "end": 20.0}),
    (WELL.with_errors, {"inclination": 0.01, "azimuth": 0.5}),
    (WELL.position, {"depth": 10.0}),
    (WELL.curvature, {"depth": 10.0}),
    (fr.ForceRecord, {"time": TIME, "force": 3.0 + np.sin(40.0 * TIME), "harmonics": 3, "frequency": 40.0}),
    (fr.ForceRecord, {"time": TIME, "force": 3.0 + np.sin(40.0 * TIME) + 0.3 * np.sin(73.1 * TIME), "second": 73.1}),
    (fr.ForceRecord(TIME, 3.0 + np.sin(40.0 * TIME)).force, {"t": 0.5}),
    (
        fr.AxialWave,
        PUSH
        | {"far_end": "held", "axial_damping": 0.5, "mean_at": 0.3, "waveform": "sine", "noise": 0.0, "second": None},
    ),
    (fr.AxialWave.hertz, LOADS),
    (fr.Rod, dataclasses.asdict(ROD)),
    (
        fr.Rod,
        {
            "youngs_modulus": 207e9,
            "density": 7850.0,
            "diameter": 0.0508,
            "wall_thickness": 0.00396,
            "length": 60.0,
            "channel_diameter": 0.124,
            "fluid_outside": 1000.0,
        },
    ),
    (
        fr.Rod,
        {"youngs_modulus": 2e11, "density": 7e3, "radius": 0.03, "length": 60.0, "channel_radius": 0.1}
        | {"inner_diameter": 0.04},
    ),
    (fr.Rod, {"youngs_modulus": 2e11, "weight": 60.0, "radius": 0.03, "length": 60.0, "channel_radius": 0.1}),
    (fr.Section, {"length": 60.0, "radius": 0.03, "inner_radius": 0.02, "youngs_modulus": 2e11, "density": 7850.0}),
    (fr.Section, {"length": 60.0, "diameter": 0.05, "inner_diameter": 0.04}),
    (fr.Section, {"length": 60.0, "diameter": 0.05, "wall_thickness": 4e-3, "weight": 60.0}),
    (fr.Section, {"name": "2.00x0.156 CT90", "length": 60.0, "yield_strength": 5e8}),
    (fr.Rod, {"sections": [fr.Section(radius=8e-4, length=1.5)], "bores": [(0.0, 9.4e-3), (1.0, 12e-3)]}),
    (ROD.replace, {"length": 3.0, "damping_rate": 0.1, "inner_diameter": 0.4e-3, "inclination": 1.0}),
    (fr.Rod.catalogue, {"name": "2x.156 CT90", "bore": 0.12, "length": 60.0}),
    (ROD.lock_up, {"friction": 0.3, "far_force": 0.1}),
    (ROD.lock_up(0.3).force, {"distance": 10.0}),
    (ROD.lock_up(0.3).pushed_length, {"force": 0.1}),
    (
        ROD.stability,
        {"load": LOAD, "modes": (6, 7), "growth_tolerance": 0.0, "friction": 0.1, "kick": 0.05, "progress": None},
    ),
    (ROD.stability, {"load": LOAD}),
    (
        CLAMPED.stability,
        {"load": WAVE, "modes": range(1, 9), "growth_tolerance": 0.1, "friction": None, "kick": None, "progress": None},
    ),
    (CLAMPED.modal_system, {"load": WAVE, "modes": (1, 2, 3)}),
    (CLAMPED.modal_system, {"load": WAVE, **PUSH}),
    (CLAMPED.modes_needed, {"load": WAVE, "growth_tolerance": 0.1}),
    (CLAMPED.is_stable, {"load": WAVE, **PUSH, **UNCOUPLED, "growth_tolerance": 0.1, "workers": 1, "progress": None}),
    (CLAMPED.verdicts, {"load": WAVE, **PUSH, **UNCOUPLED, "growth_tolerance": 0.1, "workers": 1, "progress": None}),
    (CLAMPED.growth_rate, {"load": WAVE, **PUSH, "return_mode": True, "workers": 1, "progress": None}),
    (ROD.critical_kick, {"load": LOAD, "friction": 0.1, "growth_tolerance": 0.0}),
    (ROD.critical_kick, {"load": LOAD, **LOADS, "friction": 0.1, "growth_tolerance": 0.0, "workers": 1}),
    (
        ROD.is_stable,
        {
            "load": LOAD,
            **LOADS,
            "growth_tolerance": 0.0,
            "criterion": None,
            "friction": None,
            "kick": None,
            "workers": 1,
            "progress": None,
        },
    ),
    (ROD.verdicts, {**LOADS, "growth_tolerance": 0.0, "criterion": None, "friction": 0.1, "kick": 0.05, "workers": 1}),
    (ROD.verdicts, {"load": LOAD, **LOADS, "progress": None}),
    (ROD.growth_rate, {"load": LOAD, **LOADS, "return_mode": False, "workers": 1, "progress": None}),
    (
        ROD.ranges,
        {"quantity": "mean", "load": LOAD, "amplitude": 0.3, "frequency": 150.0, "bounds": (0.1, 0.5)}
        | {"growth_tolerance": 0.1, "progress": None},
    ),
    (
        ROD.ranges,
        {"quantity": "amplitude", "load": LOAD, "mean": 0.3, "frequency": 150.0, "bounds": (0.1, 0.5)}
        | {"growth_tolerance": 0.1, "progress": None},
    ),
    (
        ROD.ranges,
        {"quantity": "frequency", "load": LOAD, "mean": 0.3, "amplitude": 0.3, "bounds": (99.0, 150.0)}
        | {"growth_tolerance": 0.1, "progress": None},
    ),
    (
        ROD.critical,
        {"quantity": "mean", "load": LOAD, "amplitude": 0.3, "frequency": 150.0, "growth_tolerance": 0.1}
        | {"progress": None},
    ),
    (
        ROD.critical,
        {"quantity": "amplitude", "load": LOAD, "mean": 0.3, "frequency": 150.0, "growth_tolerance": 0.1}
        | {"progress": None},
    ),
    (
        ROD.certify,
        {
            "load": LOAD,
            **LOADS,
            "growth_tolerance": 0.1,
            "rod": {"length": (3.09, 3.1)},
            "max_boxes": 100,
            "progress": None,
        },
    ),
    (
        ROD.replace(damping_rate=9.0).largest_safe_box,
        {
            "load": LOAD,
            "vary": ("frequency",),
            "growth_tolerance": 0.1,
            "rod": {"length": 3.1},
            "accuracy": 0.5,
            "progress": None,
        },
    ),
    (ROD.natural_frequency, {"mode": 7}),
    (ROD.modal_system, {"load": LOAD, "modes": (6, 7)}),
    (ROD.modal_system, {"load": LOAD, **LOADS}),
    (ROD.modes_needed, {"load": LOAD, "growth_tolerance": 0.0}),
    (ROD.stability(LOAD).time_to_grow, {"factor": 10.0}),
    (
        fr.stability_map,
        {
            "rod": ROD,
            "load": LOAD,
            "mean": (0.1, 0.5, 2),
            "amplitude": 0.3,
            "frequency": (100.0, 150.0, 2),
            "growth": False,
            "growth_tolerance": 0.0,
            "damping": None,
            "criterion": None,
            "friction": None,
            "kick": None,
            "certified": False,
            "large_motion": False,
            "response": False,
            "workers": 1,
            "progress": None,
        },
    ),
    (
        fr.probability_of_instability,
        {
            "rod": ROD,
            "load": LOAD,
            "parameters": {"length": (3.0, 3.1)},
            "samples": 20,
            "growth_tolerance": 0.0,
            "seed": 1,
            "confidence": 0.9,
            "workers": 1,
            "progress": None,
        },
    ),
    (
        fr.probability_of_reach,
        {
            "rod": TUBE,
            "path": WELL,
            "friction": (0.2, 0.3),
            "parameters": {"density": (6e3, 7e3)},
            "depth": [20.0],
            "tool": None,
            "speed": 0.05,
            "far_force": 0.0,
            "push": 30.0,
            "wellhead_pressure": 1e4,
            "stripper": 0.1,
            "pressure_inside": 2e4,
            "helical": "energy",
            "yield_share": 0.8,
            "samples": 2,
            "seed": 1,
            "confidence": 0.9,
            "progress": None,
        },
    ),
    (fr.friction.fates, {**KICKS, "kick": 2.0, "max_steps": 1000}),
    (fr.friction.escapes, {**KICKS, "kick": 2.0, "max_steps": 10_000}),
    (fr.friction.critical_kick, {**KICKS, "largest": 10.0, "samples": 4, "max_steps": 1000}),
    (
        fr.friction.leapfrog_escapes,
        {
            "alpha": 1.0,
            "beta": 0.3,
            "gamma": 1.0,
            "kick": 2.0,
            "damping": 0.0,
            "periods": 2,
            "step": 0.1,
            "limit": 1e6,
        },
    ),
    (fr.friction.fate, {"equation": KICKED, "kick": 2.0, "max_steps": 1000}),
    (fr.friction.certain_kicks, {"equation": KICKED}),
    (fr.friction.escape_ranges, {"equation": KICKED, "samples": 4, "max_steps": 1000, "workers": 1}),
    (fr.friction.trajectory, {"equation": KICKED, "kick": 2.0, "periods": 2}),
    (fr.Perturbation.modes, {"speeds": {8: 0.05}}),
    (
        fr.SimulationProblem,
        {
            "rod": ROD,
            "load": LOAD,
            "duration": 0.1,
            "friction": 0.1,
            "perturbation": None,
            "segments": 60,
            "time_step": None,
            "frames": 3,
            "poisson_ratio": 0.3,
            "indentation": 1e-4,
            "contact_damping": 0.3,
            "feed_speed": None,
            "far_force": None,
            "stop_early": False,
            "natural_curvature": 0.0,
            "tool": None,
            "start": None,
        },
    ),
]
"""Callables with a valid call each."""

NAN_MEANS = {
    fr.follow: "NaN unknown",
    fr.stability_map: "NaN where rest is not stable",
    fr.mathieu.transition_curves: "order 0 has no second curve",
    fr.friction.critical_kick: "could not be decided",
    CLAMPED.growth_rate: "it cannot be computed",
}
"""Callables whose documentation says what NaN means."""

JUNK: list[Any] = [
    10**400,
    10**5000,
    1e-300,
    1e300,
    5e-324,
    2**64,
    -(2**64),
    -0.0,
    0,
    -1,
    math.nan,
    math.inf,
    1j,
    None,
    "x",
    "1/3",
    "",
    b"1",
    True,
    np.True_,
    Fraction(1, 3),
    Decimal("0.1"),
    Decimal("nan"),
    Decimal("sNaN"),
    datetime.date(2026, 1, 1),
    np.datetime64("2026"),
    np.timedelta64(1, "s"),
    [1.0, [2.0]],
    [[1.0, 2.0], [3.0]],
    [None],
    ["a"],
    [10**400],
    [],
    (),
    {},
    {1: 2},
    {"a"},
    (0.0, 1.0, 2.5),
    (0.0, 1.0, -1),
    (1.0, 0.0, 2),
    (0.0, 1.0, 10**400),
    [0.1, 0.2],
    np.array([]),
    np.array(0.5),
    np.array([0.5]),
    np.array([1.0, None], dtype=object),
    np.ma.array([1.0, 2.0], mask=[True, False]),
    np.ma.masked,
    np.float32(0.1),
    np.longdouble("1e400"),
    object(),
    ...,
    types.SimpleNamespace(),
    loop(),
    loop(0.3),
    loop(twice=True),
    tree(30),
    Endless(),
    Raising(),
    objects(0.3, Raising()),
    range(10**12),
    "x" * 10**6,
    ["x" * 10**6],
    np.broadcast_to(0.3, 10**12),
    np.broadcast_to(0.3, (10**6, 10**6)),
]


def named(call: Callable[..., Any]) -> str:
    """Return a name for the report."""
    call = getattr(call, "func", call)  # of a partial, what it calls
    return getattr(call, "__qualname__", repr(call))


CASES = [(call, given, name) for call, given in CALLS for name in given]
for problem, method, options in OPTIONS:
    CASES += [(fr.stability, {"equation": problem, "method": method, **options}, name) for name in options]
    CALLS.append((fr.stability, {"equation": problem, "method": method, **options}))


def short(value: Any) -> str:
    """Return what a value looks like, however long it is."""
    try:
        return repr(value)[:40]
    except (ValueError, ZeroDivisionError):
        return f"a {type(value).__name__}"


def numbers_in(result: Any) -> list[np.ndarray]:
    """Return the numbers of an answer."""
    if isinstance(result, FloquetVerdict) and not result.exponents:  # a method that gave up, and says so
        return []
    if dataclasses.is_dataclass(result) and not isinstance(result, type):
        values = {f.name: getattr(result, f.name) for f in dataclasses.fields(result)}
        if isinstance(result, fr.results.Reach):  # these are NaN where the string does not reach
            values["bit"] = result.bit[result.bit_depth <= result.reach]
            values["bit_shaken"] = result.bit_shaken[result.bit_depth <= result.reach_shaken]
        return [x for value in values.values() for x in numbers_in(value)]
    if isinstance(result, tuple | list):
        return [x for part in result for x in numbers_in(part)]
    if isinstance(result, int | float | complex | np.ndarray | np.generic) and not isinstance(result, bool):
        return [np.asarray(result)]
    return []


@pytest.mark.parametrize(("call", "given", "name"), CASES, ids=[f"{named(c)}-{n}" for c, _, n in CASES])
def test_junk_is_refused_by_name_or_answered(
    call: Callable[..., Any], given: dict[str, Any], name: str, tuned: Tuned
) -> None:
    tuned(steps_of_a_solution=1000)  # of spans without end
    faults = []
    stride = depth(1, 18)  # every argument is given some of it, and all of it comes in turn
    for junk in JUNK[zlib.crc32(f"{named(call)}-{name}".encode()) % stride :: stride]:
        try:
            result = call(**{**given, name: junk})
        except (TypeError, ValueError) as error:
            if name not in str(error):
                faults.append(f"{short(junk)}: {type(error).__name__} does not name it: {error}")
            if len(str(error)) > LONGEST_MESSAGE:
                faults.append(f"{short(junk)}: {type(error).__name__} of {len(str(error))} characters")
        except (
            fr.UndecidedWarning,
            fr.UniformForceWarning,
            fr.PlausibilityWarning,
            fr.rod.BucklingWarning,
        ):  # warnings are errors here; these are answers
            continue
        except Exception as error:  # whatever else comes is the fault looked for
            faults.append(f"{short(junk)}: {type(error).__name__}: {error}")
        else:
            if call in NAN_MEANS:
                continue
            if any(x.dtype.kind in "fc" and np.isnan(x).any() for x in numbers_in(result)):
                faults.append(f"{short(junk)}: answered {str(result)[:200]}")
    assert not faults, "\n".join(faults)


def test_arrays_that_broadcast_beyond_memory_are_refused() -> None:
    column = np.full((20_000, 1), 0.3)
    with pytest.raises(ValueError, match=r"alpha, beta.* at most 100,000,000 elements, got 400000000"):
        fr.mathieu.is_stable(column, column.T)
    assert fr.mathieu.is_stable(np.empty((0, 10**9)), 0.3).shape == (0, 10**9)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: fr.Rod.nitinol().replace(sections=range(10**30)), "sections must be 1,000 at most"),
        (lambda: fr.Rod.nitinol().replace(natural_shape=tree(30)), "natural_shape must be"),
        (lambda: fr.bands(fr.Meissner(alpha=2.0, beta=0.0), below=2.0**63), "below must be lower"),
        (
            lambda: fr.DelaySystem.first_order_from_samples(
                np.linspace(0.0, 1.0, 8, endpoint=False), np.zeros((8, 1, 1)), period=1.0, delayed=[(0.5, tree(30))]
            ),
            r"delayed\[0\]\[1\]",
        ),
        (lambda: fr.periodic_orbit(circling(), ([0.0, 1.0], tree(30))), "start must"),
    ],
)
def test_what_would_take_ages_to_be_counted_is_refused_at_once(call: Callable[[], Any], name: str) -> None:
    with pytest.raises((TypeError, ValueError), match=rf"^{name}"):
        call()


def circling() -> fr.NonlinearSystem:
    """Return an oscillator of two equations."""
    return fr.NonlinearSystem(lambda t, y: [y[1], -y[0]])


@pytest.mark.parametrize("names", ["speeds", "noises"])
@pytest.mark.parametrize("junk", [[Raising()], tree(30)])
def test_pairs_that_raise_or_hold_one_list_a_billion_times_are_refused(names: str, junk: Any) -> None:
    with pytest.raises((TypeError, ValueError), match=names):
        fr.Perturbation(**{names: junk})


def test_a_path_that_raises_when_it_is_shown_is_refused_by_name() -> None:
    with pytest.raises(TypeError, match=r"^path must"):
        fr.Milling.from_toml(objects(0.3, Raising()))


def test_equations_of_a_symbol_without_end_are_refused_shortly() -> None:
    with pytest.raises((TypeError, ValueError), match="equations") as caught:
        fr.NonlinearSystem.from_sympy([sympy.Symbol("y" * 10**5)], [sympy.Symbol("x")])
    assert len(str(caught.value)) < LONGEST_MESSAGE


@pytest.mark.parametrize("junk", [loop(0.3), [0.3], {1: 2}, True, Raising()])
def test_equations_that_are_no_expressions_are_refused(junk: object) -> None:
    with pytest.raises(TypeError, match=r"equations\[0\] must be an expression"):
        fr.NonlinearSystem.from_sympy([junk], [sympy.Symbol("x")])


@pytest.mark.slow
def test_an_equation_too_stiff_for_its_floquet_solutions_is_named() -> None:
    # Of many equations, whose maps take so much room that few steps are allowed.
    stiff = fr.HillSystem(np.eye(20), [np.eye(20)], damping=1e6 * np.diag(np.arange(1.0, 21.0)), period=1e3)
    with pytest.raises(ValueError, match=r"^equation must be one that can be solved over its period, and span takes"):
        fr.floquet_solutions(stiff)


def test_a_period_that_takes_no_parameters_is_named() -> None:
    spring = fr.HillSystem([[1.0]], [[[0.2]]], period=2.0)
    with pytest.raises(TypeError, match=r"^period must be a function of parameters"):
        fr.NonlinearSystem.from_hill(spring, lambda t, q, velocity: 0.1 * q**3, period=len)


def test_a_damping_rate_and_numbers_of_samples_beyond_reach_are_named() -> None:
    delayed = fr.DelaySystem([[1.0]], delayed=[(0.5, [[0.1]])])
    with pytest.raises(ValueError, match=r"^rate must"):
        delayed.damped(1e300)
    with pytest.raises(ValueError, match=r"^samples must .* 100000"):
        fr.margin(fr.Mathieu, "beta", (-1.0, 0.0), samples=10**9, alpha=0.1, beta=-0.5)


def test_a_heading_without_end_is_refused_shortly(tmp_path: Path) -> None:
    survey = tmp_path / "survey.csv"
    survey.write_text("MD,INC,AZI\n0,0,0\n10,1,0\n")
    for name in ("depth", "azimuth"):
        with pytest.raises(ValueError, match="heading") as caught:
            fr.WellPath.from_csv(survey, **{name: "x" * 10**6})
        assert len(str(caught.value)) < LONGEST_MESSAGE


def test_what_would_take_minutes_or_gigabytes_is_refused_by_name() -> None:
    slot = fr.Milling(x=[fr.ToolMode("922Hz", 0.011, "39.93g")], teeth=2, tangential="600MPa", radial="200MPa")
    with pytest.raises(ValueError, match=r"^speed must be at least 230.5 rpm"):
        slot.critical_depth("100rpm")
    with pytest.raises(ValueError, match=r"^speed must"):
        slot.lobes(("100rpm", "5000rpm", 4), ("0mm", "1mm", 3))
    with pytest.raises(ValueError, match=r"^most must be at most 0.0\d+ m, 500 times the least"):
        slot.critical_depth("9000rpm", most=5.0)
    with pytest.raises(ValueError, match=r"^damping_rate must"):
        fr.simulate(ROD.replace(damping_rate=1e15), LOAD, duration=1e-3)
    with pytest.raises(ValueError, match=r"^frequency must make at most 100,000 axial waves"):
        ROD.stress(fr.AxialWave(0.3, 0.3, 1e12))
    assert ROD.stress(fr.AxialLoad(0.3, 0.3, 1e12)).largest > 0.0


def test_coefficients_of_which_nothing_is_known_have_no_floquet_solutions() -> None:
    with pytest.raises(ValueError, match=r"^equation must"):
        fr.floquet_solutions(fr.PeriodicSystem([[-1.0]], coefficient_error=1e300))


def test_a_delayed_equation_of_many_periods_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="period"):
        fr.DelaySystem(stiffness=[[1.0]], period=np.array([1.0, 2.0]), delayed=[(0.5, [[0.1]])])


@pytest.mark.parametrize("seconds", [np.array([]), np.ones(2), math.nan, 0.0, "soon", None])
def test_a_margin_in_no_time_is_refused(seconds: object) -> None:
    with pytest.raises((TypeError, ValueError), match="seconds must"):
        ROD.stability(LOAD).margin("mean", seconds=seconds)  # type: ignore[arg-type]


def test_the_table_has_every_public_function_and_every_argument() -> None:
    # In test_ensemble.py, a window, test_hand_over.py, test_interchange.py.
    elsewhere = {"simulate", "ensemble", "Explorer", "save_report", "to_json", "to_pandas"}
    results = {
        "Bands",
        "Chart",
        "Comparison",
        "FloquetMode",
        "Margin",
        "MeanForce",
        "AlmostSureExponent",
        "Branch",
        "CriticalNoise",
        "FilteredGrowth",
        "QuasiperiodicGrowth",
        "PeriodicOrbit",
        "SafeKick",
        "SecondMoments",
        "SpecialPoint",
        "RodResponse",
        "SteadyMotion",
        "Gain",
        "OutputNoise",
        "Response",
        "ResponseComparison",
        "RodBranches",
        "Proof",
        "Reach",
        "ReachProbability",
        "RegionProof",
        "SafeBox",
        "FrictionalRodStability",
        "InstabilityProbability",
        "RodStability",
        "StabilityIntervals",
        "Simulation",
        "Solution",
        "Stability",
        "Study",
    }
    public = {
        getattr(getattr(module, name), "__name__", name)  # an alias counts as what it is another name of
        for module in (fr, fr.mathieu, fr.friction, fr.conventions)
        for name in (getattr(module, "__all__", None) or dir(module))
        if callable(getattr(module, name)) and not name.startswith("_")
    }
    results |= {
        "CertainKicks",
        "CriticalKickBounds",
        "EscapeRanges",
        "Fate",
        "FloquetSolution",
        "KickRange",
        "Trajectory",
        "TransitionCurves",
    }
    errors = {name for name in public if name.endswith(("Warning", "Diverged", "Error"))}
    tabled = {getattr(call, "__name__", "") for call, _ in CALLS}
    missing = (
        public
        - tabled
        - elsewhere
        - results
        - errors
        - {"Perturbation", "certify", "margin", "SquareWave", "shaped", "Any"}
    )
    assert not missing, f"not in the table: {sorted(missing)}"
    for call, _ in CALLS:
        names = {
            name
            for name, p in inspect.signature(call).parameters.items()
            if p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)
        }
        covered = {name for other, given in CALLS if other == call for name in given}
        assert names <= covered, f"{named(call)}: {sorted(names - covered)} not in the table"


@pytest.mark.parametrize("texts", [np.array("0.3"), np.array(["0.3"]), np.array([["0.3"]])])
def test_an_array_of_texts_without_a_unit_is_refused(texts: Any) -> None:
    with pytest.raises(TypeError, match=r"alpha.* must be a real number"):
        fr.mathieu.is_stable(texts, 0.1)
