"""How probable it is that a string reaches a depth, with friction, weights and a survey known by distributions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.content import ByContent
from floquetrod._util.probability_interval import clopper_pearson
from floquetrod._util.progress import Progress
from floquetrod._util.result_report import Printed, Report, Table
from floquetrod.rod.answers.assembly import require_tube
from floquetrod.rod.answers.mean_force import ASSUMED, drag_of, force_in_newtons
from floquetrod.rod.answers.pushing import Limits, Pushing, stress_limit
from floquetrod.rod.answers.string_reach import depths_of
from floquetrod.rod.distributions import (
    SURVEY,
    distribution,
    distributions,
    drawn,
    no_sample,
    quantile_function,
    rows,
    sampled_path,
    samples_of,
)
from floquetrod.rod.loads.tool import VibrationTool, tool_inside
from floquetrod.rod.model.data import require_free
from floquetrod.rod.model.parameters import NUMBERS, friction_coefficient
from floquetrod.rod.model.wellhead import Wellhead
from floquetrod.rod.rod import Rod
from floquetrod.rod.uncertainty import entropy, independence, random_levels
from floquetrod.wells.path import WellPath

_MOST_SAMPLES = 10**6  # a day or two
_DEPTHS = 20  # where none are asked for
_OF_STRING = tuple(name for name, parameter in NUMBERS.items() if "strings" in parameter.known_to)
"""Parameters of a rod that its mean force depends on."""


@dataclass(frozen=True, eq=False, repr=False)
class ReachProbability(Printed, ByContent):
    """The probability that a string can be pushed to measured depths.

    Attributes
    ----------
    depth : ndarray (n,)
        Measured depths of the lower end in m.
    probability : ndarray (n,)
        The share of samples pushed there and to all depths before it, within ``push`` and ``yield_share``.
    low : ndarray (n,)
        Lower end of its confidence interval by Clopper and Pearson, whose coverage is at least ``confidence``.
    high : ndarray (n,)
        Upper end of it.
    confidence : float
    samples : int
        Number of strings and wells drawn.
    seed : int
        Seed of the samples.
    assumptions : tuple of str
    """

    depth: Floats
    probability: Floats
    low: Floats
    high: Floats
    confidence: float
    samples: int
    seed: int
    assumptions: tuple[str, ...] = field(default=())

    @property
    def _in_words(self) -> str:
        return (
            f"reaches {self.depth[-1]:.6g} m with probability {self.probability[-1]:.3g}, between {self.low[-1]:.3g} "
            f"and {self.high[-1]:.3g} with {100.0 * self.confidence:g} % confidence; {self.samples:,} samples"
        )

    def report(self) -> Report:
        """Return the probability by depth.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.
        """
        table = zip(self.depth, self.probability, self.low, self.high, strict=True)
        columns = [("depth m", ">9"), ("probability", ">11"), ("from", ">6"), ("to", ">6")]
        rows = [[f"{depth:.6g}", *(f"{share:.3f}" for share in others)] for depth, *others in table]
        return Report(self._in_words, (), Table(columns, rows), assumptions=self.assumptions)

    _keys = "depth_m probability low high confidence samples seed assumptions"


class _Pushed(NamedTuple):
    """How strings are pushed, in all samples."""

    rod: Rod
    path: WellPath
    depths: Floats
    far_force: float
    push: float
    yield_share: float | None
    options: tuple[str, VibrationTool | None, Any]  # criterion of a helix, tool, speed
    wellhead: Wellhead

    def string(self, friction: Any, sample: Mapping[str, Any]) -> Pushing:
        """Return the string and the well of one sample."""
        rod = self.rod.replace(**{name: value for name, value in sample.items() if name in _OF_STRING})
        helical, tool, speed = self.options
        drag = drag_of(rod, sampled_path(self.path, sample), friction, "pushed", helical, tool, speed)
        return Pushing(rod, drag, self.far_force, wellhead=self.wellhead)

    def arrives(self, friction: Any, sample: Mapping[str, Any]) -> Bools:
        """Return which depths a string of one sample reaches."""
        pushing = self.string(friction, sample)
        limits = Limits(self.push, stress_limit(pushing.rod, self.yield_share))
        if pushing.drag.shaking is None:
            return pushing.passes(self.depths, limits)
        # Where it goes without its tool, which need not run before, the stress that its vibration adds does not count.
        every = pushing.examined(self.depths, limits)
        without = replace(pushing, drag=replace(pushing.drag, shaking=None)).passes(every, limits)
        passed = float(every[without][-1]) if without.any() else -math.inf
        return replace(pushing, passed=passed).passes(self.depths, limits)


def probability_of_reach(
    rod: Rod,
    path: WellPath,
    friction: Any,
    parameters: Mapping[str, Any] | None = None,
    *,
    depth: Any = None,
    tool: VibrationTool | None = None,
    speed: float | str = 0.05,
    far_force: float | str = 0.0,
    push: float | str | None = None,
    yield_share: float | None = 0.8,
    helical: str = "energy",
    wellhead_pressure: float | str = 0.0,
    stripper: float | str = 0.0,
    pressure_inside: float | str | None = None,
    samples: int = 200,
    seed: int | None = None,
    confidence: float = 0.95,
    progress: Progress | None = None,
) -> ReachProbability:
    """Return the probability that a string can be pushed to measured depths of a well.

    Parameters
    ----------
    rod : Rod
        Its length, inclination and path are not used, as in `Rod.reach`.
    path : WellPath
    friction : float, distribution or sequence of (float or str, float or distribution)
        Coefficient of friction with the wall: a number, a pair (low, high) between which all values are equally
        probable, or a distribution of `scipy.stats`; or pairs of a measured depth and the coefficient from there on,
        each independent of the others: ``[(0, 0.2), ("1500m", (0.3, 0.4))]``.
    parameters : mapping, optional
        Distributions by name, as in `probability_of_instability`: of the string's "density", "fluid_inside",
        "fluid_outside", "youngs_modulus", "radius", "inner_radius", "channel_radius" and of "gravity", in SI units, and
        of the errors of the survey, "inclination_systematic", "azimuth_systematic", "inclination_random" and
        "azimuth_random", in rad.
    depth : array_like, optional
        Measured depths in m of the lower end; twenty by default.  A string with a tool must pass a hundred depths along
        the path, too, as in `Rod.reach`: between two it may be stopped unseen.
    tool : VibrationTool, optional
        It vibrates the string, as in `Rod.reach`.
    speed : float or str
        Speed of sliding in m/s, which is used with a tool only.
    far_force : float or str
        Compression at the lower end in N.
    push : float or str, optional
        Greatest compression in N that the injector gives; by default any.
    yield_share : float or None
        Largest stress as a fraction of the rod's ``yield_strength``, as in `Rod.reach`; None for any.
    helical : str
        When a pushed string becomes a helix, as in `Rod.reach`.
    wellhead_pressure : float or str
        Pressure around the string below the stripper in Pa, as in `Rod.reach`.
    stripper : float or str
        Friction of the stripper in N.
    pressure_inside : float or str, optional
        Pressure in the string at its upper end in Pa, as in `Rod.reach`.
    samples : int
        Number of strings and wells drawn at random; each takes some tenths of a second.
    seed : int, optional
        The same gives the same samples; by default a new one, which the result contains.
    confidence : float
        Of the intervals, between 0 and 1.
    progress : callable, optional
        Called with the numbers of samples pushed and to push.

    Returns
    -------
    ReachProbability

    Raises
    ------
    ValueError
        Where nothing is distributed, and for samples without a possible string or well.
    TypeError
        For anything that is neither number nor distribution.

    Examples
    --------
    >>> import floquetrod as fr
    >>> well = fr.WellPath([0.0, 1000.0, 1450.0, 4000.0], ["0deg", "0deg", "90deg", "90deg"])
    >>> tubing = fr.Rod.catalogue("2.00x0.156", bore="4.778in", length=1.0, fluid_inside=1e3, fluid_outside=1e3)
    >>> fr.probability_of_reach(tubing, well, (0.25, 0.35), depth=[3000.0], samples=20, seed=1)
    <reaches 3000 m with probability 0.6, between 0.361 and 0.809 with 95 % confidence; 20 samples>
    """
    validate.instance("rod", rod, Rod, "Rod.nitinol(), say")
    path = validate.instance("path", path, WellPath, "fr.WellPath.from_csv reads one from a survey")
    depths = depths_of(rod, path, depth, _DEPTHS)
    many = validate.integer("samples", samples, 1, _MOST_SAMPLES)
    confidence = validate.confidence(confidence)
    seed = entropy() if seed is None else validate.integer("seed", seed, 0, 2**128 - 1)
    validate.progress(progress)
    limit = math.inf if push is None else force_in_newtons("push", push)
    stress_limit(rod, yield_share)  # refuses what is wrong
    options = helical, tool, speed
    wellhead = Wellhead.of(wellhead_pressure=wellhead_pressure, stripper=stripper, pressure_inside=pressure_inside)
    require_tube(wellhead, rod)
    force = force_in_newtons("far_force", far_force)
    pushed = _Pushed(rod, path, depths, force, limit, yield_share, options, wellhead)
    every, coefficients = _friction(friction)
    pushed.string(0.0 if every else friction, {})  # refuses what is wrong in every sample
    if tool is not None:
        tool_inside(tool, path.end - path.start, "string")
    every |= {} if parameters is None else distributions(parameters, (*_OF_STRING, *SURVEY), path)
    require_free(rod, every, "parameters")
    if not every:
        raise validate.wrong_value(
            "friction", "or one of the parameters must be distributed, such as (0.2, 0.3); Rod.reach answers without"
        )
    taken = rows(every, path)
    levels = random_levels(np.random.default_rng(seed), taken, many)
    hits = np.zeros(depths.size, dtype=np.int64)
    for done, sample in enumerate(samples_of(drawn(every, taken, levels)), 1):
        try:
            hits += pushed.arrives(coefficients(sample), sample)
        except ValueError as error:
            raise no_sample(sample, error, what="strings and wells") from None
        if progress is not None:
            progress(done, many)
    low, high = clopper_pearson(hits, many, confidence)
    return ReachProbability(depths, hits / many, low, high, confidence, many, seed, (*ASSUMED, *independence(every)))


def _friction(given: Any) -> tuple[dict[str, Any], Callable[[Mapping[str, Any]], Any]]:
    """Return the distributed coefficients of friction by name, and a function of samples to ``friction``."""
    is_by_depth = isinstance(given, list | tuple) and bool(given) and isinstance(given[0], list | tuple)
    pairs = list(given) if is_by_depth else [(0.0, given)]
    names = [f"friction[{i}]" if is_by_depth else "friction" for i in range(len(pairs))]
    distributions = {}
    for name, pair in zip(names, pairs, strict=True):
        if isinstance(pair, list | tuple) and len(pair) == 2 and not _is_number(pair[1]):
            distributions[name] = distribution(name, pair[1], lambda _, value: friction_coefficient(value))

    def of_sample(sample: Mapping[str, Any]) -> Any:
        known = [
            (pair[0], sample[name]) if name in distributions else pair for name, pair in zip(names, pairs, strict=True)
        ]
        return known if is_by_depth else known[0][1]

    return distributions, of_sample


def _is_number(value: Any) -> bool:
    """Return whether a coefficient is meant as a number, right or wrong, rather than a distribution."""
    return not isinstance(value, list | tuple) and quantile_function(value) is None
