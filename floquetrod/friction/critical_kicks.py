"""The smallest kick that escapes."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Floats, Ints, shaped
from floquetrod.friction.inputs import Equations, Prepared, arguments, elapsed, over_friction
from floquetrod.friction.kernels import stick_slip_motion as kernels
from floquetrod.friction.proved_kicks import proved

_LARGEST = 1e12  # kick over the floor: up to here kicks are tried where none is proved to escape
_MOST_SAMPLES = 10_000  # kicks tried on the way up (a choice)
_CLOSE = 1e-9  # relative accuracy of an edge
_STEEPEST = 0.1  # largest step on the way up, logarithmic: a tenth of the kick
_BLOCK = 4  # kicks tried at once on the way up: with more, more are wasted
_CLOSER = ((8, 1e-3, 0.0),) * 6 + ((8, 1e-4, 15.0),) * 4 + ((3, 1e-8, 0.0),) * 8
"""Rounds of refinement (heuristic, measured): how many intervals of an equation are halved at most, how narrow they
may be, relative to the kick, and how long one of their ends must live."""


class CriticalKickBounds(NamedTuple):
    """Two bounds of the critical kick: below which every kick is proved bounded, and the smallest found to escape.

    Attributes
    ----------
    bounded_up_to : float or ndarray
        Proved: no kick up to it escapes.
    smallest_found : float or ndarray
        The smallest kick found to escape: infinite where none was, NaN where that could not be decided.
    """

    bounded_up_to: Any
    smallest_found: Any


def critical_kick(
    alpha: Any,
    beta: Any,
    gamma: Any = 1.0,
    *,
    damping: Any = 0.0,
    largest: Any = math.inf,
    samples: int = 24,
    max_steps: int = 20_000,
    workers: int | None = None,
) -> CriticalKickBounds:
    """Return the smallest kick found to escape, and the kick up to which none escapes, which is proved.

    Parameters
    ----------
    alpha : array_like
        Amplitude of the coefficient.  The four arrays broadcast against each other.
    beta : array_like
        Mean of the coefficient.
    gamma : array_like
        Friction force over inertia, zero or more; the result is proportional to it.
    damping : array_like
        c, the decay rate per unit tau, zero or more.
    largest : array_like
        Largest kick to search, which shortens it: ``smallest_found`` is infinite where none up to it was found.
    samples : int
        Kicks tried on the way up from the proved bound; more are tried where neighbouring orbits differ in kind.
    max_steps : int
        As in `fates`.  A kick that cannot be decided counts as not found to escape.
    workers : int, optional
        Threads; by default all cores.

    Returns
    -------
    CriticalKickBounds
        Two floats, or two arrays in the common shape.  ``smallest_found`` is an edge accurate to 1e-9;
        ``bounded_up_to`` does not depend on ``largest``, ``samples`` and ``max_steps``.

    Raises
    ------
    ValueError, TypeError
        Where an argument is not a number or out of its range, or shapes do not broadcast; named in the message.

    Notes
    -----
    A range of escaping kicks that lies lower and between two kicks tried is missed; the page
    `theory/friction` says how often.  ``smallest_found`` is NaN where a motion grows without friction, too slowly for a
    kick tried to be seen to escape.

    Examples
    --------
    >>> round(critical_kick(0.0, 0.25).smallest_found, 9)
    2.0
    >>> bounded_up_to, smallest_found = critical_kick(1.0, 0.3)
    >>> round(bounded_up_to, 6), round(smallest_found, 6)
    (0.973181, 0.973181)
    """
    limited = validate.array("largest", largest, least=0.0, largest=math.inf)
    if not (limited > 0.0).all():
        raise validate.wrong_value(
            "largest", f"must be greater than zero, got {largest!r}; leave it out to look at every kick"
        )
    shape, alpha, beta, gamma, c, limit = arguments(alpha, beta, gamma, damping, largest=limited)
    samples = validate.integer("samples", samples, 1, _MOST_SAMPLES)
    max_steps = validate.integer("max_steps", max_steps, 1)
    result = known_bounds(Equations.of(alpha, beta, c, workers), gamma, limit, workers, samples, max_steps)
    return CriticalKickBounds(*(shaped(part, shape) for part in result))


def known_bounds(
    every: Equations, gamma: Floats, limit: Floats, workers: int | None, samples: int = 24, max_steps: int = 20_000
) -> CriticalKickBounds:
    """Return `critical_kick` of checked flat arrays."""
    grows = every.rate >= 0.0
    floor = np.where(grows & (gamma == 0.0), 0.0, math.inf)  # without friction the slightest kick
    bounds = floor.copy()
    limit = over_friction(limit, gamma)
    for part in every.parts(np.flatnonzero(grows & (gamma > 0.0) & ((every.alpha != 0.0) | (every.beta != 0.0)))):
        search = _KickSearch(every.some(part).prepared(workers), limit[part], max_steps, workers)
        floor[part] = gamma[part] * search.floor
        smallest = search.smallest(samples)
        unknown = np.isinf(smallest) & np.isinf(limit[part])
        bounds[part] = np.where(unknown, math.nan, gamma[part] * smallest)
    return CriticalKickBounds(floor, bounds)


class _KickSearch:
    """The search for the smallest kick that escapes, for many equations at once; gamma = 1.

    ``tried`` are the kicks so far, a row for each equation, increasing, NaN after the last, none above
    ``escaping``, the smallest that escapes; ``kind`` distinguishes their orbits, and ``life`` is how long each went on.
    """

    def __init__(self, equations: Prepared, limit: Floats, max_steps: int, workers: int | None) -> None:
        self.equations, self.max_steps, self.workers = equations, max_steps, workers
        self.floor, ceiling = proved(equations)
        self.top = np.minimum(np.minimum(ceiling, _LARGEST * self.floor), limit)
        self.escaping = np.where(ceiling <= limit, ceiling, math.inf)
        self.tried = self.floor[:, None]
        self.kind = np.full(self.tried.shape, float(kernels.STUCK))
        self.life = np.zeros(self.tried.shape)
        self.findings = equations.no_findings()

    def smallest(self, samples: int) -> Floats:
        """Return the smallest kick found to escape, infinite where none up to the limit was."""
        self.try_the_floor()
        self.climb(samples)
        self.look_closer()
        return self.narrow()

    def look(self, which: Ints, kicks: Floats) -> None:
        """Follow kicks, a row for each equation in ``which`` (NaN is none), and note what becomes of them."""
        if not kicks.size:
            return
        findings = self.findings[which]
        orbits = self.equations.follow(which, kicks, self.max_steps, self.workers, findings, follow_slow=False)
        self.findings[which] = findings
        fate = orbits["fate"]
        escaped = (fate == kernels.GROWS) | (fate == kernels.MIXED)  # mixed: kicks that escape lie arbitrarily close
        self.escaping[which] = np.minimum(self.escaping[which], np.where(escaped, kicks, math.inf).min(axis=1))
        rests = (fate == kernels.STUCK) | (fate == kernels.ENERGY_BOUND)
        self._insert(
            which, kicks, np.where(rests, 10.0 + orbits["reversals"] + 1e6 * orbits["sticks"], fate), elapsed(orbits)
        )

    def _insert(self, which: Ints, *news: Floats) -> None:
        """Sort kicks, their kinds and lives into the rows ``which``."""
        whole = []
        for old, new in zip((self.tried, self.kind, self.life), news, strict=True):
            more = np.full((len(old), new.shape[1]), math.nan)
            more[which] = new
            whole.append(np.hstack([old, more]))
        whole[0][whole[0] > self.escaping[:, None]] = math.nan
        longest = int((~np.isnan(whole[0])).sum(axis=1).max(initial=1))
        order = np.argsort(whole[0], axis=1)[:, :longest]
        self.tried, self.kind, self.life = (np.take_along_axis(part, order, axis=1) for part in whole)

    def try_the_floor(self) -> None:
        """Try the kick just above the proved floor: the critical one where slow outward motion ends in escape."""
        near = self.floor * (1.0 + _CLOSE)
        which = np.flatnonzero(near < self.top)
        self.look(which, near[which, None])

    def climb(self, samples: int) -> None:
        """Try kicks upwards in geometric steps, a few at once, until one escapes."""
        floor = self.floor
        ratio = np.maximum(self.top / floor, 1.0)
        steps = np.maximum(samples, np.ceil(np.log(ratio) / _STEEPEST))
        for block in range(0, int(steps.max(initial=0.0)), _BLOCK):
            which = np.flatnonzero((ratio > 1.0) & (block < steps) & ~(self.escaping < self.top))
            share = np.arange(block + 1.0, block + _BLOCK + 1.0) / steps[which, None]
            kicks = floor[which, None] * ratio[which, None] ** np.minimum(share, 1.0)
            kicks = np.where(share == 1.0, self.top[which, None], kicks)
            self.look(which, np.where(share > 1.0, math.nan, kicks))

    def look_closer(self) -> None:
        """Halve intervals between kicks whose orbits differ in kind: the wide ones, then where they live longest.

        An orbit that lives long passes close to one that neither comes to rest nor escapes: an edge is near.
        """
        for most, narrowest, lasting in _CLOSER:
            low, high = self.tried[:, :-1], self.tried[:, 1:]
            life = np.maximum(self.life[:, :-1], self.life[:, 1:])
            differ = (self.kind[:, :-1] != self.kind[:, 1:]) & (high - low > narrowest * high) & (life > lasting)
            life = np.where(differ, life, -1.0)
            middle = np.where(differ, 0.5 * (low + high), math.nan)
            longest = np.argsort(-life, axis=1, kind="stable")[:, :most]
            kicks = np.take_along_axis(middle, longest, axis=1)
            which = np.flatnonzero(~np.isnan(kicks).all(axis=1))
            self.look(which, kicks[which])

    def narrow(self) -> Floats:
        """Bisect down to an edge below the smallest kick that escapes, and return it."""
        low = np.where(self.tried < self.escaping[:, None], self.tried, 0.0).max(axis=1)
        while True:
            which = np.flatnonzero(np.isfinite(self.escaping) & (self.escaping - low > _CLOSE * self.escaping))
            if not which.size:
                return self.escaping
            middle = 0.5 * (low[which] + self.escaping[which])
            self.look(which, middle[:, None])
            caught = self.escaping[which] > middle
            low[which[caught]] = middle[caught]
