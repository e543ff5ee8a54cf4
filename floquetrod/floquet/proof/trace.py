"""The trace of the map of u'' = p u over a period, enclosed in the balls of systems, as a system of one."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np

from floquetrod.equations import Hill
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.proof.digits import balls
from floquetrod.floquet.proof.exact_equation import ExactProblem
from floquetrod.floquet.proof.many_digits import exp, rational
from floquetrod.floquet.proof.system_flow import monodromy
from floquetrod.floquet.proof.system_problem import Arithmetic, BallPiece, Matrix, balanced, canonical_form

_LARGEST = 300.0  # exponent of a trace in doubles; growth beyond it is taken out (a choice: they reach 709)


def enclose_trace(context: Any, problem: ExactProblem) -> Any:
    """Enclose the trace of the equation with its damping removed, with the digits of a context of intervals."""
    arithmetic, shift = balls(context.dps), _shift(problem)
    flow = balanced([_stretch(arithmetic, problem, shift)], arithmetic.exact(canonical_form(2)))
    matrix = monodromy(arithmetic, flow)
    low, high = (matrix[0, 0] + matrix[1, 1]).ends()
    return context.mpf([rational(context, low).a, rational(context, high).b]) * exp(context, shift * context.one)


def _shift(problem: ExactProblem) -> int:
    """Return the s of exp(s t), t in periods, to take out of solutions that would leave the range of doubles."""
    (piece,) = problem.pieces
    period = 2.0 * math.pi if problem.period is None else float(problem.period)
    highest = float(piece.mean + problem.damping**2 + sum(abs(x) + abs(y) for x, y in piece.waves))
    if highest <= 0.0 or math.sqrt(highest) * period <= _LARGEST:
        return 0
    cosines, sines = ([float(wave[i]) for wave in piece.waves] for i in (0, 1))
    nearest = Hill(float(piece.mean), tuple(cosines), tuple(sines), period, float(problem.damping))
    growth = (stability(nearest).growth_rate + nearest.damping) * period
    return round(growth) if growth > _LARGEST else 0


def _stretch(arithmetic: Arithmetic, problem: ExactProblem, shift: int) -> BallPiece:
    """Return (u, u') exp(-shift t) with the period as the unit of time."""
    (piece,) = problem.pieces
    unit = arithmetic.two_pi() if problem.period is None else arithmetic.rational(problem.period)
    square = unit * unit

    def block(value: Matrix, *, real: bool) -> Matrix:
        matrix = arithmetic.zeros((2, 2), real=real)
        matrix[1, 0] = value * square
        return matrix

    mean = block(arithmetic.rational(piece.mean + problem.damping**2), real=True)
    mean[0, 1] = arithmetic.exact(np.array(1.0))
    mean = mean - arithmetic.exact(float(shift) * np.eye(2))
    waves = [block(arithmetic.rational(x) - arithmetic.rational(y).times_i(), real=False) for x, y in piece.waves]
    return BallPiece(Fraction(0), Fraction(1), mean, None, waves)
