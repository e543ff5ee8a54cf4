"""The equations, as small frozen values, and converters between the notations they are written in."""

from __future__ import annotations

from floquetrod.equations.scalar import Equation, FrictionalMathieu, Hill, Mathieu, Meissner, SquareWave, require

__all__ = ["Equation", "FrictionalMathieu", "Hill", "Mathieu", "Meissner", "SquareWave", "require"]
