"""The almost-sure exponent of a system with multiplicative white noise, estimated from simulated paths.

Stratonovich's equation is split (Strang): the flow without noise over a step, then exp(sum_i s_i G_i dW_i) in its
middle.  Flows come from the fourth-order Magnus expansion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.progress import Progress
from floquetrod.equations import PeriodicSystem
from floquetrod.equations.matrices import require_one
from floquetrod.equations.pieces import TimedPiece, in_time
from floquetrod.equations.second_moments import INTERPRETATIONS, NoiseSource, of_first_order, sources_of, with_drift
from floquetrod.floquet.multipliers import magnus_flows
from floquetrod.floquet.problems import Problem

_LEAST_STEPS = 32  # a period (a choice), an even number
_MOST_STEPS = 1 << 16  # a period (a choice)
_STEP = 0.2  # of the fastest rate of the coefficients (a choice); half the steps tell what it does
_FORGOTTEN = 0.1  # share of the time in which paths forget how they began (a choice)
_ROUNDING = 1e-14  # of a step, relative
_MOST_TERMS = 60  # of the exponential of the noise in a step


@dataclass(frozen=True, eq=False)
class AlmostSureExponent(ByContent, NoTruthValue):
    """An estimate of the rate at which almost every solution grows, from simulated paths; it proves nothing.

    Attributes
    ----------
    estimate : float
        Mean of log|x| / time over the paths, per unit of time; negative: almost every solution decays.
    interval : (float, float)
        Confidence interval of the exponent: Student's for the mean of independent paths, widened on both sides by the
        change with steps twice as long.
    confidence : float
    discretisation : float
        Change of the estimate with steps twice as long, under the same noise.
    paths : int
    time : float
        Over which paths are followed, in which the first tenth is left out.
    step : float
        Longest time step.
    seed : int
        Seed of the paths.
    """

    estimate: float
    interval: tuple[float, float]
    confidence: float
    discretisation: float
    paths: int
    time: float
    step: float
    seed: int

    ask = ".estimate and .interval"

    def __repr__(self) -> str:
        """Return the estimate as a sentence."""
        low, high = self.interval
        return (
            f"<almost-sure exponent estimated {self.estimate:.4g} per unit time, between {low:.4g} and {high:.4g} with "
            f"confidence {self.confidence:g}; {self.paths:,} paths over {self.time:g}>"
        )


def almost_sure_exponent(
    system: Problem,
    noise: Any,
    interpretation: str = "ito",
    *,
    paths: int = 1000,
    time: float | None = None,
    confidence: float = 0.95,
    seed: int = 1,
    progress: Progress | None = None,
) -> AlmostSureExponent:
    """Estimate the rate at which almost every solution of a system with white noise grows, by simulation.

    Where it is negative almost every solution decays, though rare ones may be so large that second moments grow:
    stability in mean square (`floquetrod.stability` with noise) is stricter, and decided without simulation.

    Parameters
    ----------
    system : Equation, HillSystem or PeriodicSystem
        One system.
    noise : sequence of (matrix, intensity), or float
        As in `floquetrod.second_moments`.
    interpretation : {"ito", "stratonovich"}
        Of the noise.
    paths : int
        Independent paths, 10 to 1,000,000.
    time : float, optional
        How long each is followed, in the unit of the period; rounded up to whole periods, 200 of them by default.
    confidence : float
        Of the interval, between 0 and 1.
    seed : int
        Seed of the paths.
    progress : callable, optional
        Called with the numbers of periods done and to do after each.  An exception that it raises ends the work.

    Returns
    -------
    AlmostSureExponent
        An estimate with a confidence interval.

    Raises
    ------
    TypeError, ValueError
        As `floquetrod.second_moments`, and where a period would take more than 65,536 steps.

    Examples
    --------
    dx = -0.1 x dt + 0.4 x dW has the exponent -0.1 - 0.4^2 / 2 = -0.18, while E[x^2] decays at 0.04:

    >>> import floquetrod as fr
    >>> line = fr.PeriodicSystem([[-0.1]], period=1.0)
    >>> found = fr.almost_sure_exponent(line, [([[1.0]], 0.4)], paths=100, time=10.0)
    >>> found.interval[0] < -0.18 < found.interval[1]
    True
    """
    interpretation = validate.choice("interpretation", interpretation, INTERPRETATIONS)
    paths = validate.integer("paths", paths, 10, 1_000_000)
    confidence = validate.within("confidence", confidence, 0.01, 0.999999)
    seed = validate.integer("seed", seed, 0)
    validate.progress(progress)
    subject, sources = of_first_order(system), sources_of(system, noise)
    require_one(subject)
    _require_single(sources)
    period = float(subject.period)
    periods = 200 if time is None else math.ceil(validate.positive("time", time) / period)
    periods = validate.integer("time", max(periods, 10), 10, 10_000_000, "in periods")
    if interpretation == "ito":
        subject, _ = with_drift(subject, sources, -0.5)
    grid = _grid(subject)
    logs = _logarithms(grid, sources, paths, periods, seed, progress)
    return _estimated(logs, periods * period, confidence, paths, max(grid.lengths), seed)


def _require_single(sources: list[NoiseSource]) -> None:
    """Raise ValueError where sources are a batch."""
    for i, source in enumerate(sources):
        if source.matrix.ndim > 2 or source.intensity.ndim:
            shape = source.matrix.shape[:-2] or source.intensity.shape
            raise ValueError(f"noise[{i}] must be one matrix and one intensity, got a batch of shape {shape}")


class _NoiseSteps(NamedTuple):
    """Steps of a period, an even number, and flows between the instants at which noise acts, their middles.

    ``fine[k]`` leads from the middle of step k - 1 to the middle of step k, the last step of the period before for k =
    0; ``coarse`` does so for pairs of these steps.
    """

    lengths: list[float]
    fine: Floats
    coarse: Floats


def _grid(system: PeriodicSystem) -> _NoiseSteps:
    """Return the steps of a period, which jumps separate, and the flows."""
    halves: list[Floats] = []
    lengths: list[float] = []
    for piece in in_time(system):
        length = float(piece.length)
        count = _count(system, piece, length)
        lengths += [length / count] * count
        edges = np.linspace(0.0, length, 2 * count + 1)
        halves += _flows(system, piece, edges)
    half = np.array(halves)  # two to a step
    quarter = half[0::2], half[1::2]
    fine = np.einsum("kij,kjl->kil", quarter[0], np.roll(quarter[1], 1, axis=0))
    whole = np.einsum("kij,kjl->kil", quarter[1], quarter[0])
    coarse = np.einsum("kij,kjl->kil", whole[0::2], np.roll(whole[1::2], 1, axis=0))
    return _NoiseSteps(lengths, fine, coarse)


def _count(system: PeriodicSystem, piece: TimedPiece, length: float) -> int:
    """Return an even number of steps of a piece."""
    spots = np.linspace(0.0, length, 17)
    rates = np.abs(np.linalg.eigvals(piece.at(spots, float(system.period)))).max()
    share = length / float(system.period)
    count = 2 * math.ceil(0.5 * max(_LEAST_STEPS * share, length * float(rates) / _STEP, 1.0))
    if count > _MOST_STEPS:
        raise ValueError(f"system must need at most {_MOST_STEPS:,} steps a period, got {count:,}: its rates are fast")
    return count


def _flows(system: PeriodicSystem, piece: TimedPiece, edges: Floats) -> list[Floats]:
    """Return the flow without noise between neighbouring instants of a piece."""
    middle, length = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges)
    first, second = (piece.at(middle + place * length, float(system.period)) for place in magnus_flows.PLACES)
    return list(magnus_flows.flows(first, second, length[:, None, None]))


def _logarithms(
    grid: _NoiseSteps, sources: list[NoiseSource], paths: int, periods: int, seed: int, progress: Progress | None
) -> Floats:
    """Return the log growth of each path, fine and coarse (2, paths), after a run that forgets the start."""
    rng = np.random.default_rng(seed)
    fine = rng.standard_normal((paths, grid.fine.shape[-1]))
    coarse = fine.copy()
    logs = np.zeros((2, paths))
    left_out = math.floor(_FORGOTTEN * periods)
    for done in range(periods):
        fine, coarse = _over_period(grid, sources, rng, fine, coarse)
        for i, x in enumerate((fine, coarse)):
            size = np.linalg.norm(x, axis=1)
            x /= size[:, None]
            logs[i] += np.log(size) if done >= left_out else 0.0
        if progress is not None:
            progress(done + 1, periods)
    return logs * (periods / (periods - left_out))


def _over_period(
    grid: _NoiseSteps, sources: list[NoiseSource], rng: np.random.Generator, fine: Floats, coarse: Floats
) -> tuple[Floats, Floats]:
    """Return where paths are a period later, in steps and in pairs of steps under the same noise."""
    roots = np.sqrt(grid.lengths)
    for k in range(0, len(roots), 2):
        increments = roots[k : k + 2, None, None] * rng.standard_normal((2, len(sources), len(fine)))
        for j in (0, 1):
            fine = _kicked(fine @ grid.fine[k + j].T, sources, increments[j])
        coarse = _kicked(coarse @ grid.coarse[k // 2].T, sources, increments.sum(axis=0))
    return fine, coarse


def _kicked(x: Floats, sources: list[NoiseSource], increments: Floats) -> Floats:
    """Return exp(sum_i s_i G_i dW_i) x by its series."""
    term, result = x, x
    for order in range(1, _MOST_TERMS):
        moved: Any = 0.0
        for source, increment in zip(sources, increments, strict=True):
            moved = moved + (term @ source.matrix.T) * (float(source.intensity) * increment / order)[:, None]
        term = moved
        result = result + term
        if not np.abs(term).max() > 1e-17 * np.abs(result).max():
            break
    return result


def _estimated(logs: Floats, time: float, confidence: float, paths: int, step: float, seed: int) -> AlmostSureExponent:
    """Return the estimate of logarithms over a time."""
    from scipy.stats import t

    rates, coarse = logs / time
    change = float(np.mean(coarse - rates))
    half = float(t.ppf(0.5 + 0.5 * confidence, paths - 1)) * float(rates.std(ddof=1)) / math.sqrt(paths) + abs(change)
    half += _ROUNDING / step
    estimate = float(rates.mean())
    return AlmostSureExponent(estimate, (estimate - half, estimate + half), confidence, change, paths, time, step, seed)
