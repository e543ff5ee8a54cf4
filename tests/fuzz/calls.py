"""Every public callable with arguments that it answers at once: what the attack by junk starts from."""

from __future__ import annotations

import functools
import math
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import floquetrod as fr
from floquetrod.units import InUnits

ROD = fr.Rod.nitinol()
TUBE = ROD.replace(inner_radius=0.4e-3)
SECTIONS = [fr.Section(radius=0.8e-3, length=1.5), fr.Section(radius=0.6e-3, length=1.0)]
LOAD = fr.AxialLoad(0.34, 0.34, 150.0)
_FOLLOWED = {"load": fr.AxialLoad(0.17, 0.51, 110.0), "over": {"frequency": (109.0, 111.0)}, "mode": 2, "steps": 1}
_FOLLOWED |= {"all_modes": False, "indentation": 1e-4, "longest": 0.3, "progress": None}
CLAMPED = fr.Rod(207e9, 7850.0, 0.01, 9.0, 0.05, ends="clamped-hinged", inclination=1.0)
PUSH = {"mean": 500.0, "amplitude": 700.0, "frequency": 29.0}
TRAVELLING = fr.AxialWave(**PUSH, axial_damping=3.0)
EQUATION = fr.Mathieu(0.5, -0.3, 0.01)
FRICTION = fr.FrictionalMathieu(1.0, 0.3, 1.0)
TIME = np.linspace(0.0, 1.0, 200)
FORCE = 3.0 + np.sin(40.0 * TIME)
WAVE = [[0.1, 0.2], [0.2, 0.16]]
SYSTEM = fr.HillSystem([[1.0, 0.0], [0.0, 4.0]], [WAVE], period=2.0)
FIRST_ORDER = fr.PeriodicSystem([[0.0, 1.0], [-1.0, -0.1]], [WAVE], period=2.0)
NOISY = fr.HillSystem([[1.2]], [[[0.5]]], damping=[[0.2]])
DRIVEN = {"force": 1.0, "cosines": (0.3,), "sines": (0.1,), "unstable": True}
NOISE = {"noise": [([[1.0]], 0.3)], "interpretation": "stratonovich"}

QUIET = ROD.replace(damping_rate=0.5)
SAFE = {"mean": (0.56, 0.59), "amplitude": 0.33, "frequency": 150.0}
SAFE_LOAD = fr.AxialLoad(0.57, 0.33, 150.0)

METHOD_OPTIONS: dict[str, dict[str, Any]] = {
    "determinant": {"terms": 40},
    "discriminant_excess": {"digits": 30},
    "leapfrog": {"step": 0.01, "periods": 10, "limit": 1e6},
    "monodromy": {"rtol": 1e-9},
    "monodromy_matrix": {"rtol": 1e-9, "start": 0.3},
    "reference": {"digits": 30},
}
"""Arguments of their own of the functions of `fr.methods`."""

STUDY = """\
rod = "rod.toml"
load = {mean = "0.3Fcr", amplitude = "0.3Fcr", frequency = "24Hz"}
run = {duration = "2ms", segments = 40, frames = 3}
over = {kick = ["10mm/s", "20mm/s"], seed = {from = 1, to = 3}}
"""

VALUES = (
    fr.Section,
    fr.AxialLoad,
    fr.AxialWave,
    fr.Perturbation,
    fr.FiniteTimeCriterion,
    fr.Rod,
    fr.Mathieu,
    fr.Meissner,
    fr.Hill,
)
VALUES += (
    fr.SimulationProblem,
    fr.DelaySystem,
    fr.Milling,
    fr.HillSystem,
    fr.PeriodicSystem,
    fr.ForceRecord,
    fr.Study,
    fr.WellPath,
    fr.VibrationTool,
    fr.NonlinearSystem,
)
"""Classes that people construct, and whose methods they call with arguments."""

RESULTS = (fr.Chart, fr.results.RodStability, fr.results.StabilityIntervals, fr.Simulation, fr.mathieu.TransitionCurves)
RESULTS += (fr.results.Bands, fr.results.SafeBox, fr.systems.FirstOrderTongue, fr.Branch, fr.results.RodBranches)
RESULTS += (fr.results.SpecialPoint, fr.results.BifurcationCurve)
"""Classes that only the package constructs, and whose methods people call with arguments."""

LEFT_OUT = {
    "to_json": "takes results: attacked in tests/public/test_interchange.py",
    "to_pandas": "takes results: attacked in tests/public/test_interchange.py",
    "NonlinearSystem.rates": "for the equations of an orbit, which hand over arrays of floats",
    "NonlinearSystem.jacobians": "for the equations of an orbit, which hand over arrays of floats",
    "NonlinearSystem.require_parameter": "raises",
    "NoOrbitError": "an exception",
    "PeriodicOrbit": "constructed by periodic_orbit",
    "Branch": "constructed by follow",
    **dict.fromkeys(
        ("Branch.report", "Branch.as_dict", "Branch.to_xarray", "SpecialPoint.as_dict"), "takes no argument"
    ),
    "SpecialPoint": "constructed by follow",
    "BifurcationCurve": "constructed by follow",
    **dict.fromkeys(
        ("BifurcationCurve.report", "BifurcationCurve.as_dict", "BifurcationCurve.to_xarray"), "takes no argument"
    ),
    "ForceRecord.in_words": "takes units, which are values",
    "ForceRecord.spectrum": "takes no argument",
    "Comparison": "constructed by compare",
    "Response": "constructed by response",
    "Gain": "constructed by gain",
    "OutputNoise": "constructed by output_noise",
    "ResponseComparison": "constructed by compare",
    "Proof": "constructed by certify",
    "RegionProof": "constructed by certify and Rod.certify",
    "SafeBox": "constructed by Rod.largest_safe_box",
    "Bands": "constructed by Chart.find_bands",
    "Bands.to_xarray": "takes no argument",
    "Bands.as_arrays": "takes no argument",
    "Bands.bands_of": "reads what files hold, which are damaged elsewhere",
    "Bands.scaled": "for Chart.in_units, whose arguments are checked there",
    "FrictionalRodStability": "constructed by Rod.stability",
    "InstabilityProbability": "constructed by probability_of_instability",
    "ReachProbability": "constructed by probability_of_reach",
    "CheckpointWarning": "a warning",
    "SimulationDiverged": "an exception",
    "SquareWave": "another name of Meissner",
    "FloquetMode": "constructed by floquet_solutions",
    "AlmostSureExponent": "constructed by almost_sure_exponent",
    "CriticalNoise": "constructed by critical_noise",
    "FilteredGrowth": "constructed by filtered_growth",
    "QuasiperiodicGrowth": "constructed by quasiperiodic_growth",
    "SecondMoments": "constructed by second_moments",
    "Margin": "constructed by margin and RodStability.margin",
    "EnergyBands": "constructed by bands",
    "Solution": "constructed by solve",
    "Stability": "constructed by every method",
    "mathieu.FloquetSolution": "constructed by characteristic_function and floquet_solutions",
    "PlausibilityWarning": "a warning",
    "OutcomeWarning": "a warning",
    "ResolutionWarning": "a warning",
    "ForcedAngleWarning": "a warning",
    "LeavesWallError": "an exception",
    "UndecidedWarning": "a warning",
    "UniformForceWarning": "a warning",
    "friction.EscapeRanges": "constructed by escape_ranges",
    "friction.Fate": "constructed by fate",
    "friction.CertainKicks": "a pair of numbers, constructed by certain_kicks",
    "friction.CriticalKickBounds": "a pair of numbers, constructed by critical_kick",
    "friction.KickRange": "a pair of numbers, constructed by escape_ranges",
    "friction.Trajectory": "constructed by trajectory",
    "friction.UndecidedWarning": "a warning",
    "FiniteTimeCriterion.require_alone": "for the maps of a rod, whose arguments are checked there",
    **{
        f"{kind}.{name}": "takes no argument" for kind in ("Hill", "Mathieu", "Meissner") for name in ("pieces", "half")
    },
    **{f"{kind}.as_system": "takes no argument" for kind in ("Hill", "Mathieu", "Meissner")},
    **{
        f"{kind}.plot": "its axes are an object of matplotlib"
        for kind in ("Hill", "HillSystem", "Mathieu", "Meissner", "PeriodicSystem")
    },
    "Hill.as_hill": "takes no argument",
    "HillSystem.as_periodic_system": "takes no argument",
    "Mathieu.as_hill": "takes no argument",
    "systems.FirstOrderTongue": "constructed by first_order_tongues",
    "systems.chart": "another name of chart",
    **{f"{kind}.as_dict": "takes no argument" for kind in ("AxialLoad", "AxialWave", "Rod")},
    **{f"{kind}.profile": "for the equations of a rod" for kind in ("AxialLoad", "AxialWave")},
    **{f"{kind}.varied": "for searches, whose arguments are checked there" for kind in ("AxialLoad", "AxialWave")},
    **{f"{kind}.kind_as_dict": "takes no argument" for kind in ("AxialLoad", "AxialWave")},
    **{f"{kind}.with_numbers": "for searches" for kind in ("AxialLoad", "AxialWave")},
    "Rod.nitinol": "takes no argument",
    "Rod.in_cell": "for strings in wells",
    "Section.as_dict": "takes no argument",
    "Chart.to_xarray": "takes no argument",
    "Simulation.animate": "takes no argument",
    "SimulationProblem.as_dict": "takes no argument",
    "SimulationProblem.from_dict": "reads what files hold, which are damaged elsewhere",
    "Chart": "constructed by charts and maps",
    **{f"{kind}.is_fastest": "compares" for kind in ("RodStability",)},
    **{
        f"{kind}.as_dict": "takes no argument"
        for kind in ("ForceRecord", "SafeBox", "Simulation", "StabilityIntervals")
    },
    "MeanForce": "constructed by Rod.mean_force",
    "SurfaceWeights": "constructed by Rod.surface_weights",
    "Reach": "constructed by Rod.reach",
    "SafeKick": "constructed by Rod.safe_kick",
    "RodResponse": "constructed by Rod.response",
    "SteadyMotion": "constructed by Rod.steady_motion",
    "RodBranches": "constructed by Rod.follow",
    "RodBranches.at": "of branches that take seconds: attacked in tests/rod/test_rod_branches.py",
    "RodBranches.plot": "of branches that take seconds: attacked in tests/rod/test_rod_branches.py",
    **dict.fromkeys(("RodBranches.report", "RodBranches.as_dict", "RodBranches.to_xarray"), "takes no argument"),
    "VibrationTool.as_dict": "takes no argument",
    "VibrationTool.in_words": "takes units, which are values",
    "Milling.in_words": "takes no argument",
    "WellPath.as_dict": "takes no argument",
    "WellPath.in_words": "takes a unit, which is a value",
    "WellPath.report": "takes no argument",
    "Study": "constructed by Study.from_toml",
    "Study.run": "for ensemble, whose arguments are checked there",
    "RodStability": "constructed by Rod.stability",
    "StabilityIntervals": "constructed by the methods of Rod",
    "Simulation": "constructed by simulate",
    "mathieu.TransitionCurves": "constructed by transition_curves",
}
"""Public callables that are not called with junk, each with the reason."""


class Call(NamedTuple):
    """A callable, and arguments by name that it answers."""

    function: Callable[..., Any]
    arguments: dict[str, Any]


def hardening(t: float, q: Any, velocity: Any) -> Any:
    """Return a force that a system has beside its linear ones."""
    return -(q**3)


def public() -> set[str]:
    """Return the names of all public callables, methods of the classes above included."""
    names = {name for owner in (fr, fr.results) for name in _callables(owner, owner.__all__)}
    names |= {
        f"{m.__name__.rpartition('.')[2]}.{n}"
        for m in (fr.mathieu, fr.friction, fr.systems, fr.methods)
        for n in _callables(m, m.__all__)
    }
    names |= {f"conventions.{name}" for name in _callables(fr.conventions, fr.conventions.__all__)}
    for kind in (*VALUES, *RESULTS):
        own = (
            name for name in _callables(kind, dir(kind)) if name not in vars(InUnits)
        )  # which is set while it is made
        names |= {f"{_title(kind)}.{name}" for name in own if not name.startswith("_")}
    return names


def _callables(owner: Any, names: Any) -> list[str]:
    return [name for name in names if callable(getattr(owner, name))]


def _title(kind: type) -> str:
    packages = {fr.mathieu.TransitionCurves: "mathieu.", fr.systems.FirstOrderTongue: "systems."}
    return packages.get(kind, "") + kind.__name__


@functools.cache
def folder() -> Path:
    """Return a folder for what the calls write, removed at the end."""
    keep = tempfile.TemporaryDirectory(prefix="fuzz")
    folder.keep = keep  # type: ignore[attr-defined]
    return Path(keep.name)


@functools.cache
def system_files() -> tuple[Path, Path]:
    """Return one system in a TOML file and in an npz file."""
    toml, npz = folder() / "system.toml", folder() / "system.npz"
    toml.write_text(f"[system]\nstiffness = [[1, 0], [0, 4]]\ncosines = [{WAVE}]\nperiod = 2.0\n", encoding="utf-8")
    np.savez(npz, stiffness=SYSTEM.stiffness, cosines=SYSTEM.cosines, period=SYSTEM.period)
    return toml, npz


@functools.cache
def record_file() -> Path:
    """Return a measured force in a file."""
    path = folder() / "force.csv"
    rows = [f"{t},{f}" for t, f in zip(TIME.tolist(), FORCE.tolist(), strict=True)]
    path.write_text("\n".join(["time,force", *rows]), encoding="utf-8")
    return path


@functools.cache
def survey_file() -> Path:
    """Return a survey in a file."""
    path = folder() / "survey.csv"
    path.write_text("MD (m),Inc (deg),Azi (deg)\n0,0,0\n900,3,20\n1300,80,20\n", encoding="utf-8")
    return path


@functools.cache
def simulation() -> fr.Simulation:
    """Return a short simulated rod."""
    return fr.simulate(ROD, LOAD, duration=0.15, segments=40, frames=80, perturbation=fr.Perturbation.random(1e-4, 1))


@functools.cache
def table() -> dict[str, Call]:
    """Return a call for every public callable that is not left out."""
    place = folder()
    chart = fr.mathieu.chart((0.0, 1.0, 5), (-1.0, 0.2, 4), growth=True)
    chart.save(place / "chart.npz")
    mapped = fr.stability_map(ROD, mean=(0.1, 0.5, 3), amplitude=0.3, frequency=(100.0, 150.0, 4))
    run = simulation()
    run.save(place / "run.npz")
    given = {name: getattr(ROD, name) for name in ROD.__dataclass_fields__}
    sheet = "\n".join(f"{name} = {value!r}" for name, value in given.items() if value not in (None, ()))
    (place / "rod.toml").write_text(sheet, encoding="utf-8")
    (place / "study.toml").write_text(STUDY, encoding="utf-8")
    good = system_files()[0].read_text(encoding="utf-8")
    shutil.copy(Path(__file__).parents[2] / "floquetrod/examples/family.toml", place)
    (place / "bad_system.toml").write_text(good.replace("0.16", "nan"), encoding="utf-8")
    calls = (
        _of_equations()
        | _of_rods(place)
        | _of_wells()
        | _of_coupled_rods()
        | _of_mathieu()
        | _of_friction()
        | _of_systems()
        | _of_orbits(place)
        | _of_milling()
    )
    criterion = fr.FiniteTimeCriterion()
    ranges, verdict = ROD.ranges("mean", amplitude=0.34, frequency=150.0, growth_tolerance=0.1), ROD.stability(LOAD)
    handed = {
        "project": "a job",
        "files": {"rod": "rod.toml"},
        "reach": None,
        "motion": None,
        "record": None,
        "units": {"mean": "Fcr"},
        "margins": False,
        "command": "",
        "progress": None,
    }
    safe = QUIET.largest_safe_box(SAFE_LOAD, vary=("mean",), accuracy=0.1)
    return calls | {
        "FiniteTimeCriterion": Call(fr.FiniteTimeCriterion, {"periods": 10, "limit": 1e3, "by": "exact", "step": 0.01}),
        "FiniteTimeCriterion.growth": Call(
            criterion.growth, {"alpha": 0.5, "beta": -0.3, "damping": 0.1, "workers": 1}
        ),
        "FiniteTimeCriterion.is_stable": Call(
            criterion.is_stable, {"alpha": 0.5, "beta": -0.3, "damping": 0.1, "workers": 1}
        ),
        "Chart.in_units": Call(mapped.in_units, {"mean": "Fcr", "frequency": "Hz"}),
        "Chart.find_bands": Call(mapped.find_bands, {"accuracy": 0.01}),
        "Bands.to_csv": Call(mapped.bands.to_csv, {"path": str(place / "bands.csv")}),
        **{
            name: Call(function, {"ax": None})
            for name, function in {
                "Bands.plot": mapped.bands.plot,
                "ForceRecord.plot": fr.ForceRecord(TIME, FORCE).plot,
                "RodStability.plot": verdict.plot,
                "Simulation.plot": run.plot,
                "Simulation.plot_energy": run.plot_energy,
                "Simulation.plot_growth": run.plot_growth,
                "mathieu.TransitionCurves.plot": fr.mathieu.transition_curves([0.1, 0.2], 2).plot,
            }.items()
        },
        "Chart.plot": Call(mapped.plot, {"ax": None, "bands": False}),
        "Simulation.plot_run": Call(run.plot_run, {"figure": None}),
        "save_report": Call(fr.save_report, {"result": verdict, "path": str(place / "report.html"), **handed}),
        "Chart.save": Call(chart.save, {"path": str(place / "again.npz")}),
        "Chart.load": Call(fr.Chart.load, {"path": str(place / "chart.npz")}),
        "RodStability.margin (coupled)": Call(
            CLAMPED.stability(TRAVELLING, range(1, 9)).margin, {"quantity": "frequency", "seconds": 0.1}
        ),
        "RodStability.time_to_grow (coupled)": Call(
            CLAMPED.stability(TRAVELLING, range(1, 9)).time_to_grow, {"factor": 10.0}
        ),
        "Rod.certify": Call(
            QUIET.certify,
            {"load": SAFE_LOAD, **SAFE, "growth_tolerance": 0.1, "rod": {"length": (3.09, 3.1)}, "max_boxes": 500},
        ),
        "Rod.largest_safe_box": Call(
            QUIET.largest_safe_box, {"load": SAFE_LOAD, "vary": ("mean",), "growth_tolerance": 0.1, "accuracy": 0.1}
        ),
        "SafeBox.table": Call(safe.table, {"mean": "Fcr"}),
        "SafeBox.in_units": Call(safe.in_units, {"mean": "Fcr"}),
        "RodStability.margin": Call(verdict.margin, {"quantity": "mean", "seconds": 5.0}),
        "RodStability.margins": Call(verdict.margins, {"seconds": 5.0, "progress": None}),
        "RodStability.growth_of": Call(verdict.growth_of, {"mode": 7}),
        "RodStability.report": Call(verdict.report, {"units": {"mean": "Fcr"}, "margins": verdict.margins()}),
        "RodStability.as_dict": Call(verdict.as_dict, {"margins": verdict.margins()}),
        "SafeBox.report": Call(safe.report, {"units": {"mean": "Fcr"}}),
        "Simulation.findings": Call(run.findings, {"theory": False}),
        "Simulation.report": Call(run.report, {"units": {"mean": "Fcr"}}),
        "StabilityIntervals.report": Call(ranges.report, {"unit": "N", "size": 1.0, "full": True}),
        "Study.from_toml": Call(fr.Study.from_toml, {"path": str(place / "study.toml")}),
        "RodStability.time_to_grow": Call(verdict.time_to_grow, {"factor": 10.0}),
        "StabilityIntervals.table": Call(ranges.table, {"unit": "N", "size": 1.0, "full": True}),
        "StabilityIntervals.plot": Call(ranges.plot, {"ax": None, "unit": "N"}),
        "StabilityIntervals.find_unstable": Call(ranges.find_unstable, {"progress": None}),
        "Simulation.save": Call(run.save, {"path": str(place / "again.npz")}),
        "Simulation.load": Call(fr.Simulation.load, {"path": str(place / "run.npz")}),
        "Simulation.continued": Call(run.continued, {"duration": "1ms", "progress": None, "checkpoint": None}),
        "Simulation.mode_amplitudes": Call(run.mode_amplitudes, {"modes": [1, 2]}),
        "Simulation.growth_rate": Call(run.growth_rate, {"mode": 3}),
        "mathieu.TransitionCurves.period": Call(fr.mathieu.transition_curves([0.1, 0.2], 2).period, {"order": 2}),
    }


def _of_equations() -> dict[str, Call]:
    point = {"alpha": 0.5, "beta": -0.3, "damping": 0.01}
    hill = {"mean": -0.3, "cosines": (0.1,), "sines": (0.2, 0.1), "period": 3.0, "damping": 0.01}
    kick = fr.Perturbation.modes({3: 0.01})
    return {
        "Mathieu": Call(fr.Mathieu, dict(point)),
        "Mathieu.coefficient": Call(EQUATION.coefficient, {"tau": 0.3}),
        "Meissner": Call(fr.Meissner, dict(point)),
        "Meissner.coefficient": Call(fr.Meissner(0.5, -0.3).coefficient, {"tau": 0.3}),
        "Hill": Call(fr.Hill, dict(hill)),
        "Hill.coefficient": Call(fr.Hill(**hill).coefficient, {"tau": 0.3}),
        "FrictionalMathieu": Call(fr.FrictionalMathieu, {**point, "gamma": 1.0}),
        "stability": Call(
            fr.stability, {"equation": EQUATION, "method": "auto", "noise": 0.1, "interpretation": "ito"}
        ),
        "second_moments": Call(fr.second_moments, {"system": NOISY, **NOISE}),
        "filtered_growth": Call(
            fr.filtered_growth,
            {"system": NOISY, "matrix": [[1.0]], "filter": ([[-2.0]], [1.0], [0.3]), "accuracy": 1e-6, "most": 8},
        ),
        "quasiperiodic_growth": Call(
            fr.quasiperiodic_growth,
            {"equation": fr.TwoFrequencies(EQUATION, 1.7, (0.1,), (0.0, 0.1)), "tolerance": 1e-3, "most": 20},
        ),
        "TwoFrequencies": Call(
            fr.TwoFrequencies, {"equation": EQUATION, "frequency": 1.7, "cosines": (0.1,), "sines": (0.0, 0.1)}
        ),
        **{
            f"methods.{name}": Call(getattr(fr.methods, name), {"equation": EQUATION, **METHOD_OPTIONS.get(name, {})})
            for name in fr.methods.__all__
        },
        "critical_noise": Call(fr.critical_noise, {"system": NOISY, **NOISE}),
        "almost_sure_exponent": Call(
            fr.almost_sure_exponent,
            {"system": NOISY, **NOISE, "paths": 10, "time": 20.0, "confidence": 0.9, "seed": 1, "progress": None},
        ),
        "compare": Call(fr.compare, {"equation": EQUATION}),
        "compare (of responses)": Call(fr.compare, {"equation": EQUATION, **DRIVEN}),
        "gain": Call(fr.gain, {"equation": NOISY, "at": 0, "out": 0, "frequency": (0.5, 1.5), "waves": (0, -1)}),
        "output_noise": Call(fr.output_noise, {"equation": NOISY, "intensity": [0.3], "method": "lyapunov"}),
        "response": Call(fr.response, {"equation": EQUATION, **DRIVEN, "method": "hill"}),
        "response (at a frequency)": Call(
            fr.response, {"equation": EQUATION, "force": 1.0, "frequency": 0.8, "unstable": True}
        ),
        "certify": Call(fr.certify, {"equation": EQUATION, "max_digits": 50}),
        "ForceRecord": Call(fr.ForceRecord, {"time": TIME, "force": FORCE, "harmonics": 3, "frequency": 40.0}),
        "ForceRecord.force": Call(fr.ForceRecord(TIME, FORCE).force, {"t": 0.5}),
        "ForceRecord.from_csv": Call(
            fr.ForceRecord.from_csv,
            {
                "path": record_file(),
                "time": 0,
                "force": "force",
                "time_unit": "s",
                "force_unit": "N",
                "delimiter": ",",
                "harmonics": 3,
                "frequency": 40.0,
            },
        ),
        "AxialLoad": Call(
            fr.AxialLoad,
            {**PUSH, "mean_at": 0.3, "waveform": (0.5 - 1j, 0.2), "noise": ((1.0, 0.02), (9.0, 0.01))}
            | {"second": None},
        ),
        "AxialWave": Call(
            fr.AxialWave, {**PUSH, "far_end": "free", "axial_damping": 0.5, "mean_at": None, "waveform": "sine"}
        ),
        "AxialWave.hertz": Call(fr.AxialWave.hertz, dict(PUSH)),
        "AxialLoad.hertz": Call(fr.AxialLoad.hertz, {"mean": 0.3, "amplitude": 0.3, "frequency": 24.0}),
        "Perturbation": Call(fr.Perturbation, {"speeds": ((3, 0.01),), "noises": ((0.01, 1),)}),
        "Perturbation.modes": Call(fr.Perturbation.modes, {"speeds": {3: 0.01}}),
        "Perturbation.random": Call(fr.Perturbation.random, {"speed": 0.01, "seed": 1}),
        "Perturbation.case": Call(
            fr.Perturbation.case, {"name": "C", "speed": 0.05, "mode": 8, "seed": 1, "highest": 20}
        ),
        "Perturbation.velocities": Call(kick.velocities, {"segments": 60}),
        "conventions.to_aq": Call(fr.conventions.to_aq, {"alpha": 0.5, "beta": -0.3}),
        "conventions.from_aq": Call(fr.conventions.from_aq, {"a": 0.5, "q": 0.3}),
        "conventions.to_delta_epsilon": Call(fr.conventions.to_delta_epsilon, {"alpha": 0.5, "beta": -0.3}),
        "conventions.from_delta_epsilon": Call(fr.conventions.from_delta_epsilon, {"delta": 0.5, "epsilon": 0.3}),
    }


def _van_der_pol(t: Any, x: Any, mu: float) -> Any:
    return x[1], mu * (1 - x[0] ** 2) * x[1] - x[0]


def _pitchfork(t: Any, x: Any, p: float, q: float) -> Any:
    y = x[0] - np.sin(t)
    return (np.cos(t) + p * y - q * y**3,)


def _of_orbits(place: Path) -> dict[str, Call]:
    import sympy

    x, mu = sympy.symbols("x mu")
    parameters = {"mu": 0.5}
    system = fr.NonlinearSystem(_van_der_pol, parameters=parameters)
    given = {"function": _van_der_pol, "jacobian": None, "period": None, "parameters": parameters}
    forked = fr.NonlinearSystem(_pitchfork, period=2.0 * math.pi, parameters={"p": -0.2, "q": 1.0})
    orbit = fr.periodic_orbit(forked, [0.0])
    branch = fr.follow(orbit, {"p": (-0.3, 0.3)}, longest=0.3)
    branch.save(place / "branch.npz")
    curve = fr.follow(branch.special_points[0], {"p": (-0.3, 0.3), "q": (0.5, 1.5)}, longest=0.3, steps=2)
    over = {"over": {"p": (-0.3, 0.3)}, "steps": 1, "longest": 0.3, "tolerance": 1e-8}
    over |= {"until": None, "progress": None}
    return {
        "NonlinearSystem": Call(fr.NonlinearSystem, given),
        "NonlinearSystem.with_parameters": Call(system.with_parameters, {"mu": 0.7}),
        "NonlinearSystem.from_sympy": Call(
            fr.NonlinearSystem.from_sympy,
            {"equations": [-mu * x], "states": [x], "time": None, "parameters": {mu: 1.0}},
        ),
        "NonlinearSystem.from_hill": Call(
            fr.NonlinearSystem.from_hill, {"system": SYSTEM, "force": hardening, "period": 2.0}
        ),
        "follow": Call(fr.follow, {"orbit": orbit, **over}),
        "SpecialPoint.switch": Call(branch.special_points[0].switch, {"side": 1, "distance": 0.1}),
        "BifurcationCurve.plot": Call(curve.plot, {"ax": None}),
        "Branch.plot": Call(branch.plot, {"ax": None, "state": 0, "quantity": "amplitude"}),
        "Branch.save": Call(branch.save, {"path": str(place / "again.npz")}),
        "Branch.load": Call(fr.Branch.load, {"path": str(place / "branch.npz"), "system": forked}),
        "periodic_orbit": Call(
            fr.periodic_orbit, {"system": system, "start": [2.0, 0.0], "winding": None, "tolerance": 1e-8}
        ),
    }


def _of_wells() -> dict[str, Call]:
    survey = {"depth": [0.0, 900.0, 1300.0], "inclination": [0.0, 0.1, 1.5], "azimuth": [0.0, 0.5, 0.5]}
    arc = {"length": 450.0, "inclination": (0.0, 1.5), "azimuth": 0.5, "depth": 900.0}
    path = fr.WellPath(**survey)
    along = {"path": path, "friction": 0.2, "motion": "pushed", "far_force": 0.1, "bottom": 1200.0, "depth": [300.0]}
    tool = {"tool": fr.VibrationTool(1.0, 100.0, 3.0), "speed": 0.05, "helical": "energy"}
    wellhead = {"wellhead_pressure": 20e6, "stripper": 10.0}
    along |= tool | wellhead
    pushed = {
        "path": path,
        "friction": 0.2,
        "far_force": 0.1,
        "push": 30.0,
        "depth": [300.0],
        "yield_share": 0.8,
        **tool,
        **wellhead,
        "pressure_inside": 27e6,
    }
    return {
        "VibrationTool": Call(
            fr.VibrationTool, {"amplitude": 5e3, "frequency": 113.0, "above_end": 30.0, "second": None}
        ),
        "Rod.mean_force": Call(ROD.mean_force, along),
        "Rod.reach": Call(TUBE.reach, pushed),
        "Rod.surface_weights": Call(
            ROD.surface_weights,
            {"path": path, "friction": [0.2, 0.3], "far_force": 0.1, "depth": [300.0], "helical": "energy", **wellhead},
        ),
        "WellPath": Call(fr.WellPath, survey),
        "WellPath.from_csv": Call(
            fr.WellPath.from_csv,
            {"path": survey_file(), "depth": 0, "inclination": "Inc (deg)", "azimuth": 2, "depth_unit": "m"}
            | {"angle_unit": "deg", "delimiter": ",", "sheet": None, "to": 1400.0},
        ),
        "WellPath.projected": Call(fr.WellPath.from_csv(survey_file()).projected, {"to": 1400.0}),
        "WellPath.arc": Call(fr.WellPath.arc, arc),
        "WellPath.straight": Call(fr.WellPath.straight, {**arc, "inclination": 1.0}),
        "probability_of_reach": Call(
            fr.probability_of_reach,
            {
                "rod": TUBE,
                **pushed,
                "friction": (0.2, 0.3),
                "parameters": {"density": (6e3, 7e3)},
                "samples": 2,
                "seed": 1,
            }
            | {"confidence": 0.9},
        ),
        "WellPath.with_errors": Call(path.with_errors, {"inclination": 0.001, "azimuth": [0.1, -0.1, 0.0]}),
        "WellPath.part": Call(path.part, {"start": 100.0, "end": 1000.0}),
        **{
            f"WellPath.{name}": Call(getattr(path, name), {"depth": 1000.0})
            for name in ("position", "inclination_at", "azimuth_at", "curvature")
        },
    }


def _of_rods(place: Path) -> dict[str, Call]:
    load = {"mean": 0.34, "amplitude": 0.34, "frequency": 150.0}
    sheet = {name: getattr(ROD, name) for name in ROD.__dataclass_fields__}
    section = {"length": 60.0, "radius": 0.03, "inner_radius": 0.02, "youngs_modulus": 2e11, "density": 7850.0}
    section |= {"yield_strength": 5e8}
    mu, tolerance = {"friction": 0.1}, {"growth_tolerance": 0.1}
    run = {"duration": 0.005, "friction": 0.1, "segments": 40, "time_step": None, "frames": 3}
    run |= {"perturbation": None, "poisson_ratio": 0.33, "indentation": 1e-4, "contact_damping": 0.3, "start": None}
    problem = fr.SimulationProblem(ROD, LOAD, duration=0.005, segments=40, frames=3)
    judged = {"criterion": None, "friction": None, "kick": None, "workers": 1, "progress": None}
    return {
        "Rod": Call(fr.Rod, sheet),
        "Rod (sections)": Call(fr.Rod, {"sections": SECTIONS, "bores": [(0.0, 9.4e-3), (1.0, 12e-3)]}),
        "Section": Call(fr.Section, section),
        "Section (wall)": Call(
            fr.Section,
            {"length": 60.0, "diameter": 0.05, "wall_thickness": 4e-3, "weight": 60.0, "youngs_modulus": 2e11},
        ),
        "Section (tube)": Call(fr.Section, {"length": 60.0, "diameter": 0.05, "inner_diameter": 0.04}),
        "Section (catalogue)": Call(fr.Section, {"name": "2.00x0.156 CT90", "length": 60.0}),
        "Rod.along": Call(ROD.along, {"x": 0.5}),
        "Rod.from_toml": Call(fr.Rod.from_toml, {"path": str(place / "rod.toml")}),
        "Rod.catalogue": Call(fr.Rod.catalogue, {"name": "2.00x0.156 CT90", "bore": "4.778in", "length": 60.0}),
        "Rod.lock_up": Call(ROD.lock_up, {"friction": 0.3, "far_force": 0.1}),
        "probability_of_instability": Call(
            fr.probability_of_instability,
            {"rod": ROD, "load": LOAD, "parameters": {"length": (3.0, 3.1)}, "samples": 30, "seed": 1, "workers": 1}
            | {"growth_tolerance": 0.1, "confidence": 0.9},
        ),
        "Rod.replace": Call(ROD.replace, {"length": 3.0, "damping_rate": 1.0}),
        "Rod.natural_frequency": Call(ROD.natural_frequency, {"mode": 3}),
        "Rod.modal_system": Call(ROD.modal_system, {"load": LOAD, "modes": [1, 2]}),
        "Rod.modal_system (arrays)": Call(ROD.modal_system, {"load": LOAD, **load}),
        "Rod.stress": Call(ROD.stress, {"load": TRAVELLING}),
        "Rod.axial_response": Call(ROD.axial_response, {"load": TRAVELLING}),
        "Rod.modes_needed": Call(ROD.modes_needed, {"load": LOAD, **tolerance}),
        "Rod.stability": Call(
            ROD.stability,
            {"load": LOAD, "modes": None, "friction": None, "kick": None, "progress": None, **tolerance},
        ),
        "Rod.safe_kick": Call(ROD.replace(damping_rate=1.0, length=1.0).safe_kick, {"load": LOAD, "indentation": 1e-4}),
        "Rod.follow": Call(ROD.replace(damping_rate=3.0, length=1.2).follow, _FOLLOWED),
        "Rod.response": Call(ROD.replace(natural_shape={5: 1e-4}).response, {"load": LOAD, "unstable": True}),
        "Rod.steady_motion": Call(ROD.steady_motion, {"load": LOAD, "mode": 2, "indentation": 1e-4}),
        "Rod.critical_kick": Call(ROD.critical_kick, {"load": LOAD, **mu, **tolerance}),
        "Rod.critical_kick (arrays)": Call(ROD.critical_kick, {"load": LOAD, **load, **mu, **tolerance, "workers": 1}),
        "Rod.ranges": Call(
            ROD.ranges,
            {
                "quantity": "mean",
                "load": LOAD,
                "amplitude": 0.34,
                "frequency": 150.0,
                "bounds": (0.1, 1.7),
                "progress": None,
                **tolerance,
            },
        ),
        "Rod.ranges (amplitude)": Call(
            ROD.ranges,
            {
                "quantity": "amplitude",
                "mean": 0.34,
                "frequency": 150.0,
                "bounds": (0.1, 1.7),
                "progress": None,
                **tolerance,
            },
        ),
        "Rod.ranges (frequency)": Call(
            ROD.ranges,
            {
                "quantity": "frequency",
                "mean": 0.34,
                "amplitude": 0.34,
                "bounds": (100.0, 150.0),
                "progress": None,
                **tolerance,
            },
        ),
        "Rod.critical (noise)": Call(
            QUIET.critical,
            {"quantity": "noise", "load": fr.AxialLoad(-1.0, 0.0, 150.0, noise=1.0), "progress": None, **tolerance},
        ),
        "Rod.critical": Call(
            ROD.critical,
            {"quantity": "mean", "load": LOAD, "amplitude": 0.34, "frequency": 150.0, "progress": None, **tolerance},
        ),
        "Rod.critical (amplitude)": Call(
            ROD.critical, {"quantity": "amplitude", "mean": 0.34, "frequency": 150.0, **tolerance}
        ),
        "Rod.is_stable": Call(ROD.is_stable, {**load, **tolerance, **judged, "load": LOAD}),
        "Rod.verdicts": Call(ROD.verdicts, {**load, **tolerance, **judged, "load": LOAD}),
        "Rod.growth_rate": Call(
            ROD.growth_rate, {**load, "return_mode": True, "load": LOAD, "workers": 1, "progress": None}
        ),
        "Explorer": Call(fr.Explorer, {"rod": ROD, "load": LOAD}),
        "simulate": Call(fr.simulate, {"rod": ROD, "load": LOAD, **run, "checkpoint": None}),
        "ensemble": Call(
            fr.ensemble,
            {"problem": problem, "over": {"friction": [0.1, 0.2]}, "layout": "grid", "samples": None, "seed": 0}
            | {"frames": False, "part": None},
        ),
        "SimulationProblem": Call(fr.SimulationProblem, {"rod": ROD, "load": LOAD, **run, "stop_early": False}),
        "SimulationProblem.replace": Call(problem.replace, run),
        "SimulationProblem.run": Call(problem.run, {"checkpoint": None}),
        "stability_map": Call(
            fr.stability_map,
            {
                "rod": ROD,
                "load": LOAD,
                "mean": (0.1, 0.5, 3),
                "amplitude": 0.3,
                "frequency": (100.0, 150.0, 4),
                "growth": False,
                "large_motion": False,
                "response": False,
                "damping": 1.0,
                **tolerance,
                **judged,
            },
        ),
    }


def _of_coupled_rods() -> dict[str, Call]:
    """Return calls about a rod whose modes are coupled, by the method's name and what is special."""
    tolerance = {"growth_tolerance": 0.1, "load": TRAVELLING}
    found = {
        "stability": {"load": TRAVELLING, "modes": range(1, 9), "growth_tolerance": 0.1},
        "modal_system": {"load": TRAVELLING, "modes": [1, 2]},
        "modes_needed": {"load": TRAVELLING, "growth_tolerance": 0.1},
        "is_stable": {**PUSH, **tolerance, "workers": 1},
        "verdicts": {**PUSH, **tolerance, "workers": 1},
        "growth_rate": {**PUSH, "load": TRAVELLING, "return_mode": True, "workers": 1},
        "critical": {"quantity": "mean", "amplitude": 700.0, "frequency": 29.0, **tolerance},
    }
    calls = {f"Rod.{name} (coupled)": Call(getattr(CLAMPED, name), arguments) for name, arguments in found.items()}
    amplitude = {"quantity": "amplitude", "mean": 500.0, "frequency": 29.0, **tolerance}
    return calls | {"Rod.critical (coupled, amplitude)": Call(CLAMPED.critical, amplitude)}


def _of_mathieu() -> dict[str, Call]:
    point = {"alpha": 0.5, "beta": -0.3, "damping": 0.01, "workers": 1}
    chart = {"alpha": (0.0, 1.0, 3), "beta": (-1.0, 0.0, 4), "damping": 0.1, "equation": fr.Mathieu, "growth": True}
    functions = {
        name: getattr(fr.mathieu, name) for name in ("is_stable", "growth_rate", "discriminant", "multipliers")
    }
    return {f"mathieu.{name}": Call(function, dict(point)) for name, function in functions.items()} | {
        "mathieu.characteristic_values": Call(
            fr.mathieu.characteristic_values, {"order": 3, "q": 2.0, "kind": "a", "workers": 1}
        ),
        "mathieu.real_order_values": Call(fr.mathieu.real_order_values, {"order": 0.5, "q": 2.0}),
        "mathieu.characteristic_function": Call(
            fr.mathieu.characteristic_function, {"order": 3, "q": 2.0, "kind": "a"}
        ),
        "mathieu.floquet_solutions": Call(
            fr.mathieu.floquet_solutions, {"equation": fr.Mathieu(0.5, -0.3), "per": "z"}
        ),
        "mathieu.exponents": Call(
            fr.mathieu.exponents, {"alpha": 0.5, "beta": -0.3, "damping": 0.1, "per": "tau", "workers": 1}
        ),
        "margin": Call(
            lambda **given: fr.margin(fr.Mathieu, alpha=0.1, beta=-0.5, **given),
            {"along": "beta", "within": (-1.0, 0.0), "samples": 5},
        ),
        "bands": Call(fr.bands, {"potential": fr.Meissner(0.5, 0.0), "phase": [0.0, 1.0], "below": 2.0}),
        "bands (function)": Call(
            fr.bands, {"potential": math.cos, "phase": 0.5, "below": 2.0, "period": 2.0 * math.pi, "jumps": ()}
        ),
        "floquet_solutions": Call(fr.floquet_solutions, {"equation": fr.Meissner(0.5, -0.3)}),
        "solve": Call(fr.solve, {"equation": fr.Mathieu(0.5, -0.3), "initial": (1.0, 0.0), "span": 2.0}),
        "Mathieu.from_delta_epsilon": Call(
            fr.Mathieu.from_delta_epsilon, {"delta": 0.6, "epsilon": 0.2, "damping": 0.1}
        ),
        "Mathieu.from_aq": Call(fr.Mathieu.from_aq, {"a": 1.0, "q": 1.0, "damping": 0.1}),
        "mathieu.tongue_widths": Call(fr.mathieu.tongue_widths, {"order": 2, "q": 0.5, "workers": 1}),
        "mathieu.transition_curves": Call(fr.mathieu.transition_curves, {"alpha": [0.1, 0.2], "orders": 2}),
        "mathieu.chart": Call(fr.mathieu.chart, {**chart, "growth_tolerance": 0.1, "criterion": None, "workers": 1}),
    }


def _of_friction() -> dict[str, Call]:
    point = {"alpha": 1.0, "beta": 0.3, "gamma": 1.0, "damping": 0.01}
    kick = {**point, "kick": 1.5, "max_steps": 1000, "workers": 1}
    f = fr.friction
    return {
        "friction.fates": Call(f.fates, dict(kick)),
        "friction.escapes": Call(f.escapes, dict(kick)),
        "friction.fate": Call(f.fate, {"equation": FRICTION, "kick": 1.5, "max_steps": 1000}),
        "friction.critical_kick": Call(
            f.critical_kick, {**point, "largest": 10.0, "samples": 8, "max_steps": 1000, "workers": 1}
        ),
        "friction.certain_kicks": Call(f.certain_kicks, {"equation": FRICTION}),
        "friction.escape_ranges": Call(
            f.escape_ranges, {"equation": FRICTION, "samples": 20, "max_steps": 1000, "workers": 1}
        ),
        "friction.trajectory": Call(f.trajectory, {"equation": FRICTION, "kick": 1.5, "periods": 3}),
        "friction.leapfrog_escapes": Call(
            f.leapfrog_escapes, {**point, "kick": 1.5, "periods": 3, "step": 0.1, "limit": 1e3}
        ),
    }


def _of_milling() -> dict[str, Call]:
    mode = fr.ToolMode("922Hz", 0.011, "39.93g")
    cutter = {"x": [mode], "y": [mode], "teeth": 2, "tangential": "600MPa", "radial": "200MPa", "immersion": 0.5}
    mill = fr.Milling(**{**cutter, "y": []})
    place = {"speed": "9000rpm", "depth": "0.5mm"}
    return {
        "ToolMode": Call(fr.ToolMode, {"frequency": "922Hz", "damping_ratio": 0.011, "mass": 0.04, "stiffness": None}),
        "Milling": Call(
            fr.Milling,
            cutter
            | {"direction": "down", "pitch": ["170deg", "190deg"], "helix": "30deg", "diameter": "12mm"}
            | {"runout": ["0um", "10um"], "feed_per_tooth": "0.1mm"},
        ),
        "Milling.from_toml": Call(
            fr.Milling.from_toml, {"path": Path(__file__).parents[2] / "floquetrod/examples/tool.toml"}
        ),
        "Milling.cutting": Call(mill.cutting, {"angle": 0.3}),
        "Milling.lag": Call(mill.lag, {"depth": "0.5mm"}),
        "Milling.system": Call(mill.system, place),
        "Milling.stability": Call(mill.stability, place),
        "Milling.critical_depth": Call(mill.critical_depth, {"speed": "9000rpm", "most": "2mm"}),
        "Milling.lobes": Call(
            mill.lobes,
            {"speed": ("9000rpm", "9500rpm", 3), "depth": (0.0, "1mm", 3), "growth": False, "progress": None},
        ),
    }


def _of_systems() -> dict[str, Call]:
    matrix, wave = [[2.0, 0.5], [0.5, 1.0]], [WAVE]
    hill = {"stiffness": matrix, "cosines": wave, "sines": wave, "mass": matrix, "damping": matrix, "period": 2.0}
    first = {"mean": matrix, "cosines": wave, "sines": wave, "period": 2.0, "coefficient_error": 1e-12}
    pieces = [(0.5, matrix), (1.5, fr.equations.Varying(None, [[0.1, 0.0], [0.0, 0.2]], wave, start=matrix))]
    delayed = [(0.7, matrix, wave, wave), (3.1, matrix)]
    others = {"mass": matrix, "damping": matrix, "gyroscopic": [[0.0, 1.0], [-1.0, 0.0]]}
    axes = {"omega": (2.5, 3.5, 3), "epsilon": (0.1, 0.3, 2)}
    charted = {"family": oscillators, "over": axes, "growth": True, "growth_tolerance": 0.1, "workers": 1}
    several = fr.systems.stack([SYSTEM, fr.HillSystem(matrix, period=1.0)])
    functions = {name: getattr(fr.systems, name) for name in ("is_stable", "growth_rate", "multipliers")}
    for function in functions.values():  # compiled here, not within the time that a call may take
        function(several)
        function(FIRST_ORDER)
    (tongue, *_) = fr.systems.first_order_tongues(SYSTEM)
    return {
        f"systems.{name}": Call(function, {"systems": several, "workers": 1}) for name, function in functions.items()
    } | {
        "systems.stack": Call(fr.systems.stack, {"systems": [SYSTEM, SYSTEM]}),
        "systems.first_order_tongues": Call(fr.systems.first_order_tongues, {"system": SYSTEM}),
        "systems.FirstOrderTongue.growth_rate_at": Call(tongue.growth_rate_at, {"frequency": 3.0}),
        "chart": Call(fr.chart, charted | {"progress": None}),
        "DelaySystem": Call(fr.DelaySystem, hill | {"delayed": delayed, "coefficient_error": 1e-12}),
        "DelaySystem.from_pieces": Call(
            fr.DelaySystem.from_pieces,
            {"pieces": pieces, "mass": matrix, "damping": matrix, "delayed": [(0.7, pieces)]},
        ),
        "DelaySystem.first_order": Call(fr.DelaySystem.first_order, first | {"delayed": delayed}),
        "DelaySystem.first_order_from_pieces": Call(
            fr.DelaySystem.first_order_from_pieces, {"pieces": pieces, "delayed": [(0.7, pieces)]}
        ),
        "DelaySystem.from_function": Call(
            fr.DelaySystem.from_function,
            others | {"function": swing, "period": 2.0, "jumps": [0.0, 1.0], "delayed": [(0.7, swing), (3.0, matrix)]},
        ),
        "DelaySystem.from_samples": Call(
            fr.DelaySystem.from_samples,
            others
            | {"times": np.arange(8.0), "values": [matrix] * 8, "period": 8.0}
            | {"delayed": [(0.7, [matrix] * 8), (3.0, matrix)]},
        ),
        "DelaySystem.first_order_from_function": Call(
            fr.DelaySystem.first_order_from_function,
            {"function": swing, "period": 2.0, "jumps": [0.5], "delayed": [(0.7, swing)]},
        ),
        "DelaySystem.first_order_from_samples": Call(
            fr.DelaySystem.first_order_from_samples,
            {"times": np.arange(8.0), "values": [matrix] * 8, "period": 8.0, "delayed": [(0.7, matrix)]},
        ),
        "DelaySystem.damped": Call(fr.DelaySystem(matrix, delayed=[(0.7, matrix)]).damped, {"rate": 0.1}),
        "HillSystem": Call(fr.HillSystem, hill | {"gyroscopic": [[0.0, 1.0], [-1.0, 0.0]]}),
        "HillSystem.coefficient": Call(SYSTEM.coefficient, {"t": 0.3}),
        "HillSystem.from_pieces": Call(
            fr.HillSystem.from_pieces, others | {"pieces": pieces, "coefficient_error": 1e-12}
        ),
        "HillSystem.from_function": Call(
            fr.HillSystem.from_function, others | {"function": swing, "period": 2.0, "jumps": [0.0, 1.0]}
        ),
        "HillSystem.from_samples": Call(
            fr.HillSystem.from_samples,
            others
            | {"times": np.arange(8.0), "values": [[[1.0 + k % 2, 0.1], [0.1, 4.0]] for k in range(8)], "period": 8.0},
        ),
        "PeriodicSystem.from_samples": Call(
            fr.PeriodicSystem.from_samples, {"times": np.arange(8.0), "values": [matrix] * 8, "period": 8.0}
        ),
        "Hill.from_function": Call(
            fr.Hill.from_function, {"function": math.cos, "period": 2.0 * math.pi, "damping": 0.1, "jumps": [1.0]}
        ),
        "PeriodicSystem": Call(fr.PeriodicSystem, first),
        "PeriodicSystem.from_pieces": Call(
            fr.PeriodicSystem.from_pieces, {"pieces": pieces, "coefficient_error": 1e-12}
        ),
        "PeriodicSystem.coefficient": Call(FIRST_ORDER.coefficient, {"t": 0.3}),
        "PeriodicSystem.from_function": Call(
            fr.PeriodicSystem.from_function, {"function": swing, "period": 2.0, "jumps": [0.5]}
        ),
    }


def oscillators(omega: float, epsilon: float) -> fr.HillSystem:
    """Return two oscillators coupled by what varies: a family for charts."""
    wave = [[0.5 * epsilon, epsilon], [epsilon, 0.8 * epsilon]]
    return fr.HillSystem([[1.0, 0.0], [0.0, 4.0]], [wave], period=2.0 * math.pi / omega)


def swing(t: float) -> list[list[float]]:
    """Return the matrix of a swing whose length varies with period 2."""
    return [[0.0, 1.0], [-1.0 / (1.5 + math.cos(math.pi * t)), -0.1]]
