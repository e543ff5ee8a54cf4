"""The equations, as small frozen values, and converters between the notations they are written in."""

from __future__ import annotations

from floquetrod.equations.base import Equation, Piece, require
from floquetrod.equations.batches import in_batches, stack
from floquetrod.equations.delay_system import DelayedTerm, DelaySystem
from floquetrod.equations.delayed_moments import DelayedMoments, DelayedNoise
from floquetrod.equations.hill import Hill
from floquetrod.equations.hill_system import HillSystem
from floquetrod.equations.mathieu import FrictionalMathieu, Mathieu, MathieuAQ, in_tau
from floquetrod.equations.meissner import Meissner, SquareWave
from floquetrod.equations.nonlinear_system import NonlinearSystem
from floquetrod.equations.periodic_system import PeriodicSystem
from floquetrod.equations.pieces import Varying
from floquetrod.equations.second_moments import SecondMoments, second_moments
from floquetrod.equations.two_frequencies import TwoFrequencies

__all__ = [
    "DelaySystem",
    "DelayedMoments",
    "DelayedNoise",
    "DelayedTerm",
    "Equation",
    "FrictionalMathieu",
    "Hill",
    "HillSystem",
    "Mathieu",
    "MathieuAQ",
    "Meissner",
    "NonlinearSystem",
    "PeriodicSystem",
    "Piece",
    "SecondMoments",
    "SquareWave",
    "TwoFrequencies",
    "Varying",
    "in_batches",
    "in_tau",
    "require",
    "second_moments",
    "stack",
]
