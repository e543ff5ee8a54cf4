"""The coefficient of the equation with its damping removed, as a Fourier series with enclosed coefficients."""

from __future__ import annotations

from typing import Any, NamedTuple

from floquetrod.floquet.proof.exact_equation import ExactProblem
from floquetrod.floquet.proof.many_digits import pi, rational


class EnclosedWave(NamedTuple):
    """Enclosed coefficients of cos(k theta) and sin(k theta)."""

    cosine: Any
    sine: Any

    @property
    def size(self) -> Any:
        """A bound on the magnitude of the wave."""
        return abs(self.cosine) + abs(self.sine)


class EnclosedSeries(NamedTuple):
    """p(theta) = mean + sum over k = 1, 2, ... of waves, theta = 2 pi tau / period."""

    mean: Any
    waves: list[EnclosedWave]


def undamped_series(context: Any, problem: ExactProblem) -> EnclosedSeries:
    """Enclose the coefficient of u'' = p u, A = exp(-c tau) u, for a coefficient of one piece; time is theta."""
    (piece,) = problem.pieces
    square = time_unit(context, problem) ** 2
    mean = square * rational(context, piece.mean + problem.damping**2)
    waves = [EnclosedWave(*(square * rational(context, part) for part in wave)) for wave in piece.waves]
    return EnclosedSeries(mean, waves)


def time_unit(context: Any, problem: ExactProblem) -> Any:
    """Enclose period / (2 pi), which is 1 where the period is the exact 2 pi."""
    return context.one if problem.period is None else rational(context, problem.period) / (2 * pi(context))
