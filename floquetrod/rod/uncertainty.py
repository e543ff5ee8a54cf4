"""How probable it is that a rod is unstable when its parameters and its load are known by distributions only."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.content import NoTruthValue
from floquetrod._util.probability_interval import clopper_pearson
from floquetrod._util.progress import Progress
from floquetrod.rod.distributions import SURVEY, Sampling, distributions
from floquetrod.rod.loads.load import QUANTITIES, AnyLoad, require_load
from floquetrod.rod.model.assumptions import assumptions
from floquetrod.rod.model.constants import SLOW_GROWTH
from floquetrod.rod.model.data import require_free
from floquetrod.rod.model.parameters import NUMBERS
from floquetrod.rod.rod import Rod

_MOST_SAMPLES = 10**8  # a minute or two
_SAMPLES, _SAMPLES_ONE_BY_ONE = 1_000_000, 1_000  # seconds either way
_REPLICATES = 16  # independent sets of points whose spread gives the errors of Sobol indices, themselves to a fifth
_LEAST_POINTS, _MOST_POINTS = 1 << 8, 1 << 20  # of a Sobol index (choices: too few for anything, and held at once)
_LEAST_EVENTS = 16  # unstable points, and stable ones, expected in each replicate: none has none
_HALF_CELL = 2.0**-31  # half the spacing of SciPy's Sobol points: moved by it they lie within (0, 1)


class SobolIndex(NamedTuple):
    """The share of the variance of the verdict that is due to one uncertain quantity.

    Attributes
    ----------
    first : float
        First-order index: the share that would go if this quantity were known.
    total : float
        Total index: the share that would stay if everything else were known.
    first_interval : tuple of float
        Confidence interval of ``first``.
    total_interval : tuple of float
        Confidence interval of ``total``.
    """

    first: float
    total: float
    first_interval: tuple[float, float]
    total_interval: tuple[float, float]


@dataclass(frozen=True, repr=False)
class InstabilityProbability(NoTruthValue):
    """The probability that a rod is unstable.

    Attributes
    ----------
    probability : float
        Fraction of the samples found unstable.
    interval : tuple of float
        Confidence interval of the probability by Clopper and Pearson, whose coverage is at least ``confidence``.
        Samples that could not be decided count as stable at its lower end and as unstable at its upper.
    confidence : float
    samples : int
        Number of rods and loads drawn.
    unstable : int
        How many of them are unstable.
    undecided : int
        How many of them could not be decided.
    growth_tolerance : float
        Growth in 1/s up to which a mode counts as stable.
    seed : int
        Seed of the samples.
    assumptions : tuple of str
    sampling : Sampling
        The rod, the load and the distributions.
    """

    ask = ".probability and .interval"

    probability: float
    interval: tuple[float, float]
    confidence: float
    samples: int
    unstable: int
    undecided: int
    growth_tolerance: float
    seed: int
    assumptions: tuple[str, ...]
    sampling: Sampling = field(compare=False)

    @cached_property
    def importance(self) -> dict[str, SobolIndex] | None:
        """Sobol indices by name, how much each quantity matters for the verdict; None where ``note`` says why not.

        Computed when first asked for, from about as many further samples as the probability took, by
        `scipy.stats.sobol_indices`.  Their confidence intervals come from the spread of 16 independent sets of points.
        """
        if self._too_few:
            return None
        if len(self.sampling.parameters) == 1:
            return dict.fromkeys(self.sampling.parameters, SobolIndex(1.0, 1.0, (1.0, 1.0), (1.0, 1.0)))
        return sobol_indices(self.sampling, self._points, self._streams[1], self.confidence)

    @property
    def most_important(self) -> str | None:
        """The quantity with the largest total index, None where `importance` is."""
        importance = self.importance
        return None if importance is None else max(importance, key=lambda name: importance[name].total)

    @property
    def note(self) -> str:
        """Samples that were not decided, and indices that were not computed; "" without any."""
        doubts = []
        if self.undecided:
            doubts.append(f"{self.undecided:,} of the samples could not be decided")
        if self._too_few:
            doubts.append(self._too_few)
        return "; ".join(doubts)

    def __repr__(self) -> str:
        """Return the probability as a sentence."""
        low, high = self.interval
        digits = 4 if self.unstable else 2
        unsure = f", {self.undecided:,} undecided" if self.undecided else ""
        return (
            f"<unstable with probability {self.probability:.{digits}g}, between {low:.{digits}g} and "
            f"{high:.{digits}g} with {100.0 * self.confidence:g} % confidence; {self.samples:,} samples{unsure}>"
        )

    @property
    def _streams(self) -> list[np.random.SeedSequence]:
        """Seeds of the samples and of the points of Sobol indices."""
        return np.random.SeedSequence(self.seed).spawn(2)

    @property
    def _points(self) -> int:
        """Number of points of a Sobol index, a power of two with which it takes about as long as the samples."""
        several = self.samples // (len(self.sampling.parameters) + 2)
        return min(max(1 << max(several.bit_length() - 1, 0), _LEAST_POINTS), _MOST_POINTS)

    @property
    def _too_few(self) -> str:
        """Why there are no Sobol indices, "" where there are."""
        fewer, kind = min((self.unstable, "unstable"), (self.samples - self.unstable, "stable"))
        if not fewer:
            return f"no sample was {kind}: no parameter matters more than another"
        if 2 * self._points * fewer >= _LEAST_EVENTS * _REPLICATES * self.samples:
            return ""
        remedy = "; take more samples" if self._points < _MOST_POINTS else ""
        return f"{fewer:,} {kind} samples are too few to say what is most important{remedy}"


def probability_of_instability(
    rod: Rod,
    load: AnyLoad,
    parameters: Mapping[str, Any],
    *,
    samples: int | None = None,
    growth_tolerance: float = SLOW_GROWTH,
    seed: int | None = None,
    confidence: float = 0.95,
    workers: int | None = None,
    progress: Progress | None = None,
) -> InstabilityProbability:
    """Return the probability that a rod is unstable under a load when some of their numbers are distributed.

    Parameters
    ----------
    rod : Rod
    load : AxialLoad, AxialWave or ForceRecord
        Both give everything that ``parameters`` does not.
    parameters : mapping
        Distributions by name: of "mean", "amplitude" (N) and "frequency" (rad/s) of the load, and of the numerical
        parameters of the rod ("length", "youngs_modulus", ...), in SI units.  For a rod on a path also errors of its
        survey in rad: "inclination_systematic" and "azimuth_systematic", the same at all stations, and
        "inclination_random" and "azimuth_random", at each station its own.  Each a pair (low, high), between which all
        values are equally probable, such as ``("-0.5deg", "0.5deg")``, or a distribution of `scipy.stats` with its
        parameters given; any object with a method ``ppf`` or ``icdf``, the quantile function, is accepted.  They are
        independent of each other.
    samples : int, optional
        Number of rods and loads drawn at random; by default 1,000,000, and 1,000 where each is a rod with coupled modes
        of its own, which takes some ten milliseconds.
    growth_tolerance : float
        Growth rate in 1/s up to which a mode counts as stable; the default neglects growth of less than tenfold in a
        month.
    seed : int, optional
        The same gives the same samples, on any number of threads; by default a new one, which the result contains.
    confidence : float
        Of the intervals, between 0 and 1.
    workers : int, optional
        Threads; by default one per core.
    progress : callable, optional
        Called with the numbers of samples decided and to decide.

    Returns
    -------
    InstabilityProbability

    Raises
    ------
    ValueError
        For samples that are no rod or no load; for errors of a survey of a rod on no path; for parameters of a rod
        under noise, where only the numbers of the load may be distributed.
    TypeError
        For anything that is not a distribution.

    Examples
    --------
    >>> import floquetrod as fr
    >>> rod = fr.Rod.nitinol()
    >>> load = fr.AxialLoad(mean=0.34 * rod.critical_force, amplitude=0.2 * rod.critical_force, frequency=150.0)
    >>> probability = fr.probability_of_instability(
    ...     rod, load, {"length": (3.09, 3.11), "frequency": (145.0, 155.0)}, samples=20_000, seed=1
    ... )
    >>> probability
    <unstable with probability 0.092, between 0.08803 and 0.09609 with 95 % confidence; 20,000 samples>
    >>> probability.most_important
    'frequency'
    """
    validate.instance("rod", rod, Rod, "Rod.nitinol(), say")
    load = require_load("load", load)
    samples = None if samples is None else validate.integer("samples", samples, 1, _MOST_SAMPLES)
    tolerance = units.tolerance("growth_tolerance", growth_tolerance)
    confidence = validate.confidence(confidence)
    seed = entropy() if seed is None else validate.integer("seed", seed, 0, 2**128 - 1)
    workers = validate.workers(workers)
    validate.progress(progress)
    checked = distributions(parameters, (*QUANTITIES, *NUMBERS, *SURVEY), rod.path)
    if not checked:
        raise validate.wrong_value("parameters", "must name at least one number of the rod or the load, got none")
    sampling = Sampling(rod, load, checked, tolerance, workers)
    require_free(rod, sampling.parameters, "parameters")
    sampling.model.require_varied(parameters)
    samples = samples or (_SAMPLES_ONE_BY_ONE if sampling.is_one_by_one else _SAMPLES)

    rng = np.random.default_rng(np.random.SeedSequence(seed).spawn(2)[0])
    unstable = undecided = 0
    for done in range(0, samples, sampling.at_once):
        verdicts = sampling.verdicts(random_levels(rng, sampling.rows, min(sampling.at_once, samples - done)))
        unstable += int(np.count_nonzero(verdicts == 0))
        undecided += int(np.count_nonzero(verdicts == -1))
        if progress is not None:
            progress(done + verdicts.size, samples)
    low, high = map(float, clopper_pearson(unstable, samples, confidence, unknown=undecided))
    return InstabilityProbability(
        unstable / samples,
        (low, high),
        confidence,
        samples,
        unstable,
        undecided,
        tolerance,
        seed,
        (*assumptions(rod, load), *independence(parameters)),
        sampling,
    )


def random_levels(rng: np.random.Generator, rows: Mapping[str, slice], many: int) -> Floats:
    """Return levels of probability drawn at random, (rows, many)."""
    # a level of 0 would be an infinite quantile
    return np.maximum(rng.random((max(row.stop for row in rows.values()), many)), 2.0**-54)


def independence(names: Iterable[str]) -> tuple[str, ...]:
    """Return the assumptions of independence about the distributions ``names``."""
    stations = [name for name in names if SURVEY.get(name, ("", ""))[1] == "random"]
    more = (f"{', '.join(stations)}: independent from station to station",) if stations else ()
    return (f"{', '.join(names)}: independent of each other", *more)


def sobol_indices(
    sampling: Sampling, points: int, seed: np.random.SeedSequence, confidence: float
) -> dict[str, SobolIndex]:
    """Return first-order and total Sobol indices of being unstable, two quantities at least, from ``points`` points.

    SciPy's own intervals, a bootstrap corrected for bias and skewness, take as many passes over the points as there are
    points.  Here they come from `_REPLICATES` independently scrambled Sobol sequences, by Student's distribution.
    """
    # Saltelli's scheme (Computer Physics Communications 181 (2010) 259, doi:10.1016/j.cpc.2009.09.018): f = 1 where the
    # rod is unstable, else 0; A and B are independent points of all quantities, AB_i is A with quantity i taken from B:
    #     first_i = mean(f_B (f_AB_i - f_A)) / var f,    total_i = mean((f_A - f_AB_i)^2) / (2 var f).
    # a and b (width, points) hold the levels of A and B, both halves of Sobol points in 2 width dimensions; quantity i
    # has the rows rows[i].  f is (replicates, each).  The estimate is from all points, the interval from the spread of
    # replicates.
    from scipy import stats

    rows = sampling.rows
    width, each = max(row.stop for row in rows.values()), points // _REPLICATES
    sets = [
        stats.qmc.Sobol(2 * width, seed=np.random.default_rng(child)).random(each) + _HALF_CELL
        for child in seed.spawn(_REPLICATES)
    ]
    a, b = np.split(np.concatenate(sets).T, 2)

    def unstable(levels: Floats) -> Floats:
        """Return 1 where unstable, else 0, by replicate."""
        blocks = range(0, points, sampling.at_once)
        statuses = [sampling.verdicts(levels[:, start : start + blocks.step]) for start in blocks]
        flat = np.asarray(np.concatenate(statuses) == 0, dtype=np.float64)
        return flat.reshape(_REPLICATES, each)

    mixed = []
    for row in rows.values():  # errors of all stations are one quantity, a group of levels (Saltelli & al. 2008)
        levels = a.copy()
        levels[row] = b[row]
        mixed.append(unstable(levels))
    values = {"f_A": unstable(a), "f_B": unstable(b), "f_AB": np.stack(mixed)}
    pooled = stats.sobol_indices(
        func={name: array.reshape(*array.shape[:-2], 1, points) for name, array in values.items()}, n=points
    )
    spread = stats.sobol_indices(func=values, n=each)
    quantile = float(stats.t.ppf(0.5 + 0.5 * confidence, _REPLICATES - 1)) / _REPLICATES**0.5

    def with_interval(value: float, replicates: Floats) -> tuple[float, tuple[float, float]]:
        """Return an index and its confidence interval."""
        error = quantile * float(replicates.std(ddof=1))
        return value, (value - error, value + error)

    indices = {}
    for i, name in enumerate(rows):
        first, first_interval = with_interval(float(pooled.first_order[i]), spread.first_order[:, i])
        total, total_interval = with_interval(float(pooled.total_order[i]), spread.total_order[:, i])
        indices[name] = SobolIndex(first, total, first_interval, total_interval)
    return indices


def entropy() -> int:
    """Return a seed that has not been used."""
    return int(np.random.SeedSequence().generate_state(1, np.uint64)[0])
