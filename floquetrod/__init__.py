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
    from floquetrod import results as results
    from floquetrod import simulation as simulation
    from floquetrod import systems as systems
    from floquetrod._util.interchange import to_json as to_json
    from floquetrod._util.interchange import to_pandas as to_pandas
    from floquetrod._util.plausibility_warning import PlausibilityWarning as PlausibilityWarning
    from floquetrod._util.version import __version__ as __version__
    from floquetrod.ensembles.ensemble import ensemble as ensemble
    from floquetrod.ensembles.outcome_warnings import OutcomeWarning as OutcomeWarning
    from floquetrod.ensembles.study import Study as Study
    from floquetrod.equations import DelaySystem as DelaySystem
    from floquetrod.equations import FrictionalMathieu as FrictionalMathieu
    from floquetrod.equations import Hill as Hill
    from floquetrod.equations import HillSystem as HillSystem
    from floquetrod.equations import Mathieu as Mathieu
    from floquetrod.equations import Meissner as Meissner
    from floquetrod.equations import NonlinearSystem as NonlinearSystem
    from floquetrod.equations import PeriodicSystem as PeriodicSystem
    from floquetrod.equations import SquareWave as SquareWave
    from floquetrod.equations import TwoFrequencies as TwoFrequencies
    from floquetrod.equations import conventions as conventions
    from floquetrod.equations.second_moments import second_moments as second_moments
    from floquetrod.explorer import Explorer as Explorer
    from floquetrod.floquet.almost_sure import almost_sure_exponent as almost_sure_exponent
    from floquetrod.floquet.critical_noise import critical_noise as critical_noise
    from floquetrod.floquet.dispatch import stability as stability
    from floquetrod.floquet.filtered_noise import filtered_growth as filtered_growth
    from floquetrod.floquet.floquet_modes import floquet_solutions as floquet_solutions
    from floquetrod.floquet.margins import margin as margin
    from floquetrod.floquet.proof import certify as certify
    from floquetrod.floquet.quasiperiodic import quasiperiodic_growth as quasiperiodic_growth
    from floquetrod.floquet.solve import solve as solve
    from floquetrod.floquet.status import UndecidedWarning as UndecidedWarning
    from floquetrod.mathieu.paper_criterion import FiniteTimeCriterion as FiniteTimeCriterion
    from floquetrod.milling import Milling as Milling
    from floquetrod.milling import ToolMode as ToolMode
    from floquetrod.orbits import Branch as Branch
    from floquetrod.orbits import NoOrbitError as NoOrbitError
    from floquetrod.orbits import follow as follow
    from floquetrod.orbits import periodic_orbit as periodic_orbit
    from floquetrod.plane import Chart as Chart
    from floquetrod.responses.comparison import compare as compare
    from floquetrod.responses.gain import gain as gain
    from floquetrod.responses.output_noise import output_noise as output_noise
    from floquetrod.responses.steady_response import response as response
    from floquetrod.rod.hand_over import save_report as save_report
    from floquetrod.rod.loads.load import AxialLoad as AxialLoad
    from floquetrod.rod.loads.load import AxialWave as AxialWave
    from floquetrod.rod.loads.record import ForceRecord as ForceRecord
    from floquetrod.rod.loads.tool import VibrationTool as VibrationTool
    from floquetrod.rod.model.assumptions import ForcedAngleWarning as ForcedAngleWarning
    from floquetrod.rod.model.assumptions import UniformForceWarning as UniformForceWarning
    from floquetrod.rod.model.contact import LeavesWallError as LeavesWallError
    from floquetrod.rod.model.sections import Section as Section
    from floquetrod.rod.reach_probability import probability_of_reach as probability_of_reach
    from floquetrod.rod.rod import Rod as Rod
    from floquetrod.rod.stability_map import stability_map as stability_map
    from floquetrod.rod.uncertainty import probability_of_instability as probability_of_instability
    from floquetrod.simulation.checkpoints import CheckpointWarning as CheckpointWarning
    from floquetrod.simulation.integration import SimulationDiverged as SimulationDiverged
    from floquetrod.simulation.resolution import ResolutionWarning as ResolutionWarning
    from floquetrod.simulation.simulate import simulate as simulate
    from floquetrod.simulation.simulation_problem import Simulation as Simulation
    from floquetrod.simulation.simulation_problem import SimulationProblem as SimulationProblem
    from floquetrod.simulation.start import Perturbation as Perturbation
    from floquetrod.systems.energy_bands import bands as bands
    from floquetrod.systems.family_charts import chart as chart
    from floquetrod.wells.path import WellPath as WellPath

_NAMES = {
    "_util.plausibility_warning": ("PlausibilityWarning",),
    "_util.interchange": ("to_json", "to_pandas"),
    "_util.version": ("__version__",),
    "ensembles.outcome_warnings": ("OutcomeWarning",),
    "ensembles.ensemble": ("ensemble",),
    "ensembles.study": ("Study",),
    "equations": (
        "DelaySystem",
        "FrictionalMathieu",
        "Hill",
        "HillSystem",
        "Mathieu",
        "Meissner",
        "NonlinearSystem",
        "PeriodicSystem",
        "SquareWave",
        "TwoFrequencies",
    ),
    "equations.second_moments": ("second_moments",),
    "explorer": ("Explorer",),
    "floquet.almost_sure": ("almost_sure_exponent",),
    "floquet.critical_noise": ("critical_noise",),
    "floquet.dispatch": ("stability",),
    "floquet.filtered_noise": ("filtered_growth",),
    "floquet.margins": ("margin",),
    "floquet.proof": ("certify",),
    "floquet.floquet_modes": ("floquet_solutions",),
    "floquet.quasiperiodic": ("quasiperiodic_growth",),
    "floquet.solve": ("solve",),
    "floquet.status": ("UndecidedWarning",),
    "mathieu.paper_criterion": ("FiniteTimeCriterion",),
    "milling": ("Milling", "ToolMode"),
    "orbits": ("Branch", "NoOrbitError", "follow", "periodic_orbit"),
    "plane": ("Chart",),
    "responses.comparison": ("compare",),
    "responses.gain": ("gain",),
    "responses.output_noise": ("output_noise",),
    "responses.steady_response": ("response",),
    "rod.hand_over": ("save_report",),
    "rod.loads.load": ("AxialLoad", "AxialWave"),
    "rod.loads.record": ("ForceRecord",),
    "rod.loads.tool": ("VibrationTool",),
    "rod.model.sections": ("Section",),
    "rod.stability_map": ("stability_map",),
    "rod.model.assumptions": ("ForcedAngleWarning", "UniformForceWarning"),
    "rod.model.contact": ("LeavesWallError",),
    "rod.reach_probability": ("probability_of_reach",),
    "rod.rod": ("Rod",),
    "rod.uncertainty": ("probability_of_instability",),
    "simulation.checkpoints": ("CheckpointWarning",),
    "simulation.integration": ("SimulationDiverged",),
    "simulation.simulation_problem": ("Simulation", "SimulationProblem"),
    "simulation.resolution": ("ResolutionWarning",),
    "simulation.simulate": ("simulate",),
    "simulation.start": ("Perturbation",),
    "systems.energy_bands": ("bands",),
    "systems.family_charts": ("chart",),
    "wells.path": ("WellPath",),
}
"""Names by the module that each is taken from when it is first used."""

_MODULES = ("equations.conventions", "ensembles", "friction", "mathieu", "methods", "results", "simulation", "systems")
"""Modules that are names themselves."""

_WHERE = {name: module for module, names in _NAMES.items() for name in names}
_WHERE |= {module.split(".")[-1]: module for module in _MODULES}

__all__ = sorted(_WHERE)


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used, so that importing the package costs next to nothing."""
    if name not in _WHERE:
        from importlib.util import find_spec

        from floquetrod._util.suggest import did_you_mean

        hint = did_you_mean(name, __all__) or "; see dir(floquetrod)"
        if name in importlib.import_module("floquetrod.results").__all__:
            hint = f"; did you mean results.{name}?"
        if not name.startswith("_") and find_spec(f"floquetrod.{name}") is not None:
            hint = f"; it is a module: import floquetrod.{name}"
        raise AttributeError(f"module 'floquetrod' has no attribute {name!r}{hint}")
    module = importlib.import_module(f"floquetrod.{_WHERE[name]}")
    value = module if _WHERE[name] in _MODULES else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
