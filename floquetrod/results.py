"""The classes of answers, for annotations and `isinstance`: nobody constructs one, or reads one from a file.

>>> import floquetrod as fr
>>> isinstance(fr.stability(fr.Mathieu(alpha=0.5, beta=-0.25)), fr.results.Stability)
True
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from floquetrod._util.lazy import names_of

if TYPE_CHECKING:
    from floquetrod.equations.second_moments import SecondMoments as SecondMoments
    from floquetrod.floquet.almost_sure import AlmostSureExponent as AlmostSureExponent
    from floquetrod.floquet.comparison import Comparison as Comparison
    from floquetrod.floquet.critical_noise import CriticalNoise as CriticalNoise
    from floquetrod.floquet.filtered_noise import FilteredGrowth as FilteredGrowth
    from floquetrod.floquet.floquet_modes import FloquetMode as FloquetMode
    from floquetrod.floquet.margins import Margin as Margin
    from floquetrod.floquet.proof import Proof as Proof
    from floquetrod.floquet.proof.region_proof import RegionProof as RegionProof
    from floquetrod.floquet.quasiperiodic import QuasiperiodicGrowth as QuasiperiodicGrowth
    from floquetrod.floquet.solve import Solution as Solution
    from floquetrod.floquet.verdict import Stability as Stability
    from floquetrod.orbits import BifurcationCurve as BifurcationCurve
    from floquetrod.orbits import PeriodicOrbit as PeriodicOrbit
    from floquetrod.orbits import SpecialPoint as SpecialPoint
    from floquetrod.plane import Bands as Bands
    from floquetrod.responses.comparison import ResponseComparison as ResponseComparison
    from floquetrod.responses.gain import Gain as Gain
    from floquetrod.responses.output_noise import OutputNoise as OutputNoise
    from floquetrod.responses.steady_response import Response as Response
    from floquetrod.rod.answers.mean_force import MeanForce as MeanForce
    from floquetrod.rod.answers.rod_branches import RodBranches as RodBranches
    from floquetrod.rod.answers.rod_response import RodResponse as RodResponse
    from floquetrod.rod.answers.rod_stability import RodStability as RodStability
    from floquetrod.rod.answers.safe_box import SafeBox as SafeBox
    from floquetrod.rod.answers.safe_kick import SafeKick as SafeKick
    from floquetrod.rod.answers.stability_intervals import StabilityIntervals as StabilityIntervals
    from floquetrod.rod.answers.steady_motion import SteadyMotion as SteadyMotion
    from floquetrod.rod.answers.string_reach import Reach as Reach
    from floquetrod.rod.answers.surface_weights import SurfaceWeights as SurfaceWeights
    from floquetrod.rod.friction.kicks import FrictionalRodStability as FrictionalRodStability
    from floquetrod.rod.reach_probability import ReachProbability as ReachProbability
    from floquetrod.rod.uncertainty import InstabilityProbability as InstabilityProbability
    from floquetrod.systems.energy_bands import EnergyBands as EnergyBands

__all__ = [
    "AlmostSureExponent",
    "Bands",
    "BifurcationCurve",
    "Comparison",
    "CriticalNoise",
    "EnergyBands",
    "FilteredGrowth",
    "FloquetMode",
    "FrictionalRodStability",
    "Gain",
    "InstabilityProbability",
    "Margin",
    "MeanForce",
    "OutputNoise",
    "PeriodicOrbit",
    "Proof",
    "QuasiperiodicGrowth",
    "Reach",
    "ReachProbability",
    "RegionProof",
    "Response",
    "ResponseComparison",
    "RodBranches",
    "RodResponse",
    "RodStability",
    "SafeBox",
    "SafeKick",
    "SecondMoments",
    "Solution",
    "SpecialPoint",
    "Stability",
    "StabilityIntervals",
    "SteadyMotion",
    "SurfaceWeights",
]

__getattr__, __dir__ = names_of(
    __name__,
    {
        "equations.second_moments": ("SecondMoments",),
        "floquet.almost_sure": ("AlmostSureExponent",),
        "floquet.comparison": ("Comparison",),
        "floquet.critical_noise": ("CriticalNoise",),
        "floquet.filtered_noise": ("FilteredGrowth",),
        "floquet.quasiperiodic": ("QuasiperiodicGrowth",),
        "floquet.floquet_modes": ("FloquetMode",),
        "floquet.margins": ("Margin",),
        "floquet.proof": ("Proof",),
        "floquet.proof.region_proof": ("RegionProof",),
        "floquet.solve": ("Solution",),
        "floquet.verdict": ("Stability",),
        "orbits": ("BifurcationCurve", "PeriodicOrbit", "SpecialPoint"),
        "plane": ("Bands",),
        "responses.comparison": ("ResponseComparison",),
        "responses.gain": ("Gain",),
        "responses.output_noise": ("OutputNoise",),
        "responses.steady_response": ("Response",),
        "rod.answers.mean_force": ("MeanForce",),
        "rod.answers.rod_branches": ("RodBranches",),
        "rod.answers.rod_stability": ("RodStability",),
        "rod.answers.safe_box": ("SafeBox",),
        "rod.answers.safe_kick": ("SafeKick",),
        "rod.answers.rod_response": ("RodResponse",),
        "rod.answers.steady_motion": ("SteadyMotion",),
        "rod.answers.string_reach": ("Reach",),
        "rod.answers.surface_weights": ("SurfaceWeights",),
        "rod.friction.kicks": ("FrictionalRodStability",),
        "rod.answers.stability_intervals": ("StabilityIntervals",),
        "rod.reach_probability": ("ReachProbability",),
        "rod.uncertainty": ("InstabilityProbability",),
        "systems.energy_bands": ("EnergyBands",),
    },
)
