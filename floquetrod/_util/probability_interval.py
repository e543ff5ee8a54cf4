"""Proportions of samples, with their confidence intervals."""

from __future__ import annotations

from typing import Any

import numpy as np

from floquetrod._util.arrays import Floats

_MOST_GROUPS = 1000  # whose shares are weighed one by one; consecutive ones of more are averaged first (a choice)


def clopper_pearson(hits: Any, samples: Any, confidence: float, unknown: Any = 0) -> tuple[Floats, Floats]:
    """Return the ends of the interval of a proportion by Clopper and Pearson, of a coverage of ``confidence`` at least.

    Samples of an ``unknown`` outcome are among ``samples``; they are no hits at the lower end, and hits at the upper.
    """
    from scipy.stats import beta

    level, most = 0.5 * (1.0 - confidence), hits + unknown
    # As parameters of the beta distribution must be positive, the ends of the range are put in afterwards.
    low = np.where(hits > 0, beta.ppf(level, np.maximum(hits, 1), samples - hits + 1), 0.0)
    high = np.where(most < samples, beta.isf(level, most + 1, np.maximum(samples - most, 1)), 1.0)
    return low, high


def mean_of_shares(low: Floats, high: Floats, confidence: float) -> tuple[float, float]:
    """Return the ends of the interval of Gaffke for the mean of independent numbers between 0 and 1, the shares x_i.

    ``low`` and ``high`` (n,) bound each x_i.  The upper end is the quantile 1 - (1 - confidence) / 2 of the sum of
    D_i x_i and D_0, the lower end is one minus the same quantile for 1 - x_i; D is uniform on the simplex of n + 1
    weights.  For shares of 0 and 1 alone it is the interval of Clopper and Pearson.

    Sources: N. Gaffke, Math. Methods Statist. 14 (2005) 451-467; arXiv:1905.06208.  That it covers the mean at least as
    often as it states, whatever the distribution, is a conjecture without a known exception.
    """
    level = 0.5 * (1.0 - confidence)
    return 1.0 - _upper_end(1.0 - low, level), _upper_end(high, level)


def _upper_end(shares: Floats, level: float) -> float:
    """Return the quantile 1 - ``level`` of the sum of D_i x_i and D_0; x are the shares (n,)."""
    from scipy.optimize import brentq

    several = -(-shares.size // _MOST_GROUPS)
    if several > 1:  # averages of as many consecutive shares are shares too; a rest of less than a thousandth stays out
        shares = shares[: shares.size // several * several].reshape(-1, several).mean(axis=1)
    points = np.append(shares, 1.0)
    lowest = float(points.min())
    if lowest == 1.0:
        return 1.0
    return float(brentq(lambda t: _exceeds(points - t) - level, lowest, 1.0, xtol=1e-13, rtol=1e-13))


def _exceeds(offsets: Floats) -> float:
    """Return the probability that the sum of D_i d_i is positive; d are the offsets, D uniform on the simplex.

    D_i are exponential variables over their sum.  Positive d add up to one sum of exponential times of means a_i,
    negative d to another one of means b_j.  Of two such times that run at once, of means a and b, the second ends first
    with the probability a / (a + b), and both sums have no memory: with i and j times left,

        R(i, j) = a_i / (a_i + b_j) R(i, j - 1) + b_j / (a_i + b_j) R(i - 1, j),    R(i, 0) = 1,    R(0, j) = 0

    is the probability that the sum of the a lasts longer.  No term is negative, so nothing cancels.
    """
    a, b = offsets[offsets > 0.0], -offsets[offsets < 0.0]
    if not (a.size and b.size):
        return float(a.size > 0)
    row = np.zeros(a.size + 1)  # R(i, k - i) at place i, for the diagonal k
    row[1] = 1.0
    for k in range(2, a.size + b.size + 1):
        first, last = max(1, k - b.size), min(a.size, k - 1)
        i = np.arange(first, last + 1)
        share = a[i - 1] / (a[i - 1] + b[k - i - 1])
        row[first : last + 1] = share * row[first : last + 1] + (1.0 - share) * row[first - 1 : last]
        if k <= a.size:
            row[k] = 1.0
    return float(row[-1])
