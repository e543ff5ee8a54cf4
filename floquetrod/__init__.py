"""floquetrod: Floquet and spectral stability of periodically forced equations, and of a rod shaken in a channel.

>>> import floquetrod as fr
>>> fr.stability(fr.Mathieu(alpha=0.5, beta=-0.25)).status
'unstable'
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from floquetrod._version import __version__

if TYPE_CHECKING:
    from floquetrod import conventions as conventions
    from floquetrod import friction as friction
    from floquetrod import mathieu as mathieu
    from floquetrod.chart import Chart as Chart
    from floquetrod.comparison import Comparison as Comparison
    from floquetrod.comparison import compare as compare
    from floquetrod.coulomb import Coulomb as Coulomb
    from floquetrod.course import CheckpointWarning as CheckpointWarning
    from floquetrod.course import SimulationDiverged as SimulationDiverged
    from floquetrod.criterion import PaperCriterion as PaperCriterion
    from floquetrod.equations import FrictionalMathieu as FrictionalMathieu
    from floquetrod.equations import Hill as Hill
    from floquetrod.equations import Mathieu as Mathieu
    from floquetrod.equations import SquareWave as SquareWave
    from floquetrod.explorer import Explorer as Explorer
    from floquetrod.load import AxialLoad as AxialLoad
    from floquetrod.perturbation import Perturbation as Perturbation
    from floquetrod.proof import Proof as Proof
    from floquetrod.proof import certify as certify
    from floquetrod.result import Stability as Stability
    from floquetrod.rod import Rod as Rod
    from floquetrod.rod import UniformForceWarning as UniformForceWarning
    from floquetrod.rod_friction import RodFriction as RodFriction
    from floquetrod.rod_map import stability_map as stability_map
    from floquetrod.rod_ranges import SafeRanges as SafeRanges
    from floquetrod.rod_stability import RodStability as RodStability
    from floquetrod.simulation import Simulation as Simulation
    from floquetrod.simulator import simulate as simulate
    from floquetrod.verdict import stability as stability

_WHERE = {
    "AxialLoad": "load",
    "Chart": "chart",
    "CheckpointWarning": "course",
    "Comparison": "comparison",
    "Coulomb": "coulomb",
    "FrictionalMathieu": "equations",
    "Explorer": "explorer",
    "Hill": "equations",
    "Mathieu": "equations",
    "PaperCriterion": "criterion",
    "Perturbation": "perturbation",
    "Proof": "proof",
    "Rod": "rod",
    "RodFriction": "rod_friction",
    "RodStability": "rod_stability",
    "SafeRanges": "rod_ranges",
    "Simulation": "simulation",
    "SimulationDiverged": "course",
    "SquareWave": "equations",
    "Stability": "result",
    "UniformForceWarning": "rod",
    "certify": "proof",
    "compare": "comparison",
    "conventions": "",
    "friction": "",
    "mathieu": "",
    "simulate": "simulator",
    "stability": "verdict",
    "stability_map": "rod_map",
}

__all__ = ["__version__", *sorted(_WHERE)]


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used, so that importing the package costs next to nothing."""
    if name not in _WHERE:
        raise AttributeError(f"module 'floquetrod' has no attribute {name!r}; see dir(floquetrod)")
    module = importlib.import_module(f"floquetrod.{_WHERE[name] or name}")
    value = getattr(module, name) if _WHERE[name] else module
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
