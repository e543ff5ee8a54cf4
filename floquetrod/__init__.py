"""floquetrod: Floquet and spectral stability of periodically forced equations, and of a rod vibrated in a channel.

>>> import floquetrod as fr
>>> fr.stability(fr.Mathieu(alpha=0.5, beta=-0.25)).status
'unstable'
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from floquetrod import ensembles as ensembles
    from floquetrod import friction as friction
    from floquetrod import mathieu as mathieu
    from floquetrod import methods as methods
    from floquetrod import simulation as simulation
    from floquetrod import systems as systems
    from floquetrod._util.implausible import PlausibilityWarning as PlausibilityWarning
    from floquetrod._util.interchange import to_json as to_json
    from floquetrod._util.interchange import to_pandas as to_pandas
    from floquetrod._util.version import __version__ as __version__
    from floquetrod.ensembles.ensemble import ensemble as ensemble
    from floquetrod.ensembles.study import Study as Study
    from floquetrod.equations import DelaySystem as DelaySystem
    from floquetrod.equations import FrictionalMathieu as FrictionalMathieu
    from floquetrod.equations import Hill as Hill
    from floquetrod.equations import HillSystem as HillSystem
    from floquetrod.equations import Mathieu as Mathieu
    from floquetrod.equations import Meissner as Meissner
    from floquetrod.equations import NonlinearSystem as NonlinearSystem
    from floquetrod.equations import PeriodicSystem as PeriodicSystem
    from floquetrod.equations import SecondMoments as SecondMoments
    from floquetrod.equations import SquareWave as SquareWave
    from floquetrod.equations import conventions as conventions
    from floquetrod.equations import second_moments as second_moments
    from floquetrod.explorer import Explorer as Explorer
    from floquetrod.floquet.almost_sure import AlmostSureExponent as AlmostSureExponent
    from floquetrod.floquet.almost_sure import almost_sure_exponent as almost_sure_exponent
    from floquetrod.floquet.comparison import Comparison as Comparison
    from floquetrod.floquet.comparison import compare as compare
    from floquetrod.floquet.critical_noise import CriticalNoise as CriticalNoise
    from floquetrod.floquet.critical_noise import critical_noise as critical_noise
    from floquetrod.floquet.dispatch import stability as stability
    from floquetrod.floquet.filtered_noise import FilteredGrowth as FilteredGrowth
    from floquetrod.floquet.filtered_noise import filtered_growth as filtered_growth
    from floquetrod.floquet.margins import Margin as Margin
    from floquetrod.floquet.margins import margin as margin
    from floquetrod.floquet.proof import Proof as Proof
    from floquetrod.floquet.proof import certify as certify
    from floquetrod.floquet.proof.region import RegionProof as RegionProof
    from floquetrod.floquet.solutions import FloquetMode as FloquetMode
    from floquetrod.floquet.solutions import floquet_solutions as floquet_solutions
    from floquetrod.floquet.solve import Solution as Solution
    from floquetrod.floquet.solve import solve as solve
    from floquetrod.floquet.status import UndecidedWarning as UndecidedWarning
    from floquetrod.floquet.verdict import Stability as Stability
    from floquetrod.mathieu.criterion import FiniteTimeCriterion as FiniteTimeCriterion
    from floquetrod.milling import Milling as Milling
    from floquetrod.milling import ToolMode as ToolMode
    from floquetrod.orbits import Branch as Branch
    from floquetrod.orbits import NoOrbitError as NoOrbitError
    from floquetrod.orbits import PeriodicOrbit as PeriodicOrbit
    from floquetrod.orbits import SpecialPoint as SpecialPoint
    from floquetrod.orbits import follow as follow
    from floquetrod.orbits import periodic_orbit as periodic_orbit
    from floquetrod.plane import Bands as Bands
    from floquetrod.plane import Chart as Chart
    from floquetrod.rod.answers.mean_force import MeanForce as MeanForce
    from floquetrod.rod.answers.reach import Reach as Reach
    from floquetrod.rod.answers.rod_branches import RodBranches as RodBranches
    from floquetrod.rod.answers.safe_box import SafeBox as SafeBox
    from floquetrod.rod.answers.safe_kick import SafeKick as SafeKick
    from floquetrod.rod.answers.steady_motion import SteadyMotion as SteadyMotion
    from floquetrod.rod.answers.verdict import CoupledRodStability as CoupledRodStability
    from floquetrod.rod.answers.verdict import RodStability as RodStability
    from floquetrod.rod.friction.kicks import FrictionalRodStability as FrictionalRodStability
    from floquetrod.rod.hand_over import save_report as save_report
    from floquetrod.rod.loads.load import AxialLoad as AxialLoad
    from floquetrod.rod.loads.load import AxialWave as AxialWave
    from floquetrod.rod.loads.record import ForceRecord as ForceRecord
    from floquetrod.rod.loads.tool import VibrationTool as VibrationTool
    from floquetrod.rod.map import stability_map as stability_map
    from floquetrod.rod.model.assumptions import ForcedAngleWarning as ForcedAngleWarning
    from floquetrod.rod.model.assumptions import UniformForceWarning as UniformForceWarning
    from floquetrod.rod.model.contact import LeavesWallError as LeavesWallError
    from floquetrod.rod.ranges import StabilityIntervals as StabilityIntervals
    from floquetrod.rod.reach_probability import ReachProbability as ReachProbability
    from floquetrod.rod.reach_probability import probability_of_reach as probability_of_reach
    from floquetrod.rod.rod import Rod as Rod
    from floquetrod.rod.uncertainty import InstabilityProbability as InstabilityProbability
    from floquetrod.rod.uncertainty import probability_of_instability as probability_of_instability
    from floquetrod.simulation.checkpoints import CheckpointWarning as CheckpointWarning
    from floquetrod.simulation.integration import SimulationDiverged as SimulationDiverged
    from floquetrod.simulation.problem import Simulation as Simulation
    from floquetrod.simulation.problem import SimulationProblem as SimulationProblem
    from floquetrod.simulation.resolution import ResolutionWarning as ResolutionWarning
    from floquetrod.simulation.simulate import simulate as simulate
    from floquetrod.simulation.start import Perturbation as Perturbation
    from floquetrod.systems.charts import chart as chart
    from floquetrod.wells.path import WellPath as WellPath

_WHERE = {
    "__version__": "_util.version",
    "AxialLoad": "rod.loads.load",
    "AxialWave": "rod.loads.load",
    "Bands": "plane",
    "Chart": "plane",
    "chart": "systems.charts",
    "CheckpointWarning": "simulation.checkpoints",
    "Comparison": "floquet.comparison",
    "CoupledRodStability": "rod.answers.verdict",
    "DelaySystem": "equations",
    "Explorer": "explorer",
    "ForceRecord": "rod.loads.record",
    "FloquetMode": "floquet.solutions",
    "FrictionalMathieu": "equations",
    "Hill": "equations",
    "HillSystem": "equations",
    "InstabilityProbability": "rod.uncertainty",
    "Margin": "floquet.margins",
    "margin": "floquet.margins",
    "Mathieu": "equations",
    "FiniteTimeCriterion": "mathieu.criterion",
    "NonlinearSystem": "equations",
    "Branch": "orbits",
    "follow": "orbits",
    "SpecialPoint": "orbits",
    "NoOrbitError": "orbits",
    "PeriodicOrbit": "orbits",
    "periodic_orbit": "orbits",
    "Milling": "milling",
    "ToolMode": "milling",
    "PeriodicSystem": "equations",
    "Perturbation": "simulation.start",
    "PlausibilityWarning": "_util.implausible",
    "Proof": "floquet.proof",
    "RegionProof": "floquet.proof.region",
    "Solution": "floquet.solve",
    "solve": "floquet.solve",
    "ResolutionWarning": "simulation.resolution",
    "Rod": "rod.rod",
    "SafeBox": "rod.answers.safe_box",
    "FrictionalRodStability": "rod.friction.kicks",
    "RodStability": "rod.answers.verdict",
    "Simulation": "simulation.problem",
    "SimulationDiverged": "simulation.integration",
    "SimulationProblem": "simulation.problem",
    "Meissner": "equations",
    "SquareWave": "equations",
    "Stability": "floquet.verdict",
    "StabilityIntervals": "rod.ranges",
    "RodBranches": "rod.answers.rod_branches",
    "SafeKick": "rod.answers.safe_kick",
    "SteadyMotion": "rod.answers.steady_motion",
    "Study": "ensembles.study",
    "UndecidedWarning": "floquet.status",
    "UniformForceWarning": "rod.model.assumptions",
    "ForcedAngleWarning": "rod.model.assumptions",
    "LeavesWallError": "rod.model.contact",
    "MeanForce": "rod.answers.mean_force",
    "Reach": "rod.answers.reach",
    "ReachProbability": "rod.reach_probability",
    "VibrationTool": "rod.loads.tool",
    "WellPath": "wells.path",
    "certify": "floquet.proof",
    "compare": "floquet.comparison",
    "conventions": "equations.conventions",
    "save_report": "rod.hand_over",
    "second_moments": "equations",
    "SecondMoments": "equations",
    "critical_noise": "floquet.critical_noise",
    "CriticalNoise": "floquet.critical_noise",
    "filtered_growth": "floquet.filtered_noise",
    "FilteredGrowth": "floquet.filtered_noise",
    "almost_sure_exponent": "floquet.almost_sure",
    "AlmostSureExponent": "floquet.almost_sure",
    "ensemble": "ensembles.ensemble",
    "floquet_solutions": "floquet.solutions",
    "friction": "friction",
    "mathieu": "mathieu",
    "methods": "methods",
    "probability_of_instability": "rod.uncertainty",
    "probability_of_reach": "rod.reach_probability",
    "ensembles": "ensembles",
    "simulation": "simulation",
    "simulate": "simulation.simulate",
    "stability": "floquet.dispatch",
    "stability_map": "rod.map",
    "systems": "systems",
    "to_json": "_util.interchange",
    "to_pandas": "_util.interchange",
}
_MODULES = {"conventions", "ensembles", "friction", "mathieu", "methods", "simulation", "systems"}

__all__ = sorted(_WHERE)


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used, so that importing the package costs next to nothing."""
    if name not in _WHERE:
        from importlib.util import find_spec

        from floquetrod._util.suggest import did_you_mean

        hint = did_you_mean(name, __all__) or "; see dir(floquetrod)"
        if not name.startswith("_") and find_spec(f"floquetrod.{name}") is not None:
            hint = f"; it is a module: import floquetrod.{name}"
        raise AttributeError(f"module 'floquetrod' has no attribute {name!r}{hint}")
    module = importlib.import_module(f"floquetrod.{_WHERE[name]}")
    value = module if name in _MODULES else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
