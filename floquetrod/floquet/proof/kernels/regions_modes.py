"""Kernels that prove how one mode behaves for every value of its numbers in a box.

Freed of its damping a mode is u'' + (kappa - p sin omega t) u = 0, Mathieu's equation with a = 4 kappa / omega^2 and
q = 2 p / omega^2.  Multiplied by h = omega^2 / 4, the rows of the four chains of `mathieu_counts`
are k^2 h - kappa and their couplings g = p / 2, so that nothing is divided by omega.
"""

from __future__ import annotations

import math

from floquetrod._util.compilation import kernel
from floquetrod.floquet.mathieu_chains.box_count import MOST_ROWS, exact_count
from floquetrod.floquet.proof.kernels.double_intervals import PI_HIGH, PI_LOW, Pair, down, sinh_squared, up
from floquetrod.floquet.proof.kernels.regions_excess import excess
from floquetrod.floquet.status import STABLE, UNDECIDED, UNSTABLE


@kernel
def flux_bound(kappa: float, p: float, slow: float, fast: float, enough: float) -> float:
    """Return a bound in 1/s on the growth of every mode with at least this kappa, at most this p, omega in a range.

    That of the page `theory/regions`, the lowest of a few K for each parity, or the first that is at most ``enough``;
    infinite where there is none.
    """
    # docs/theory/regions.md: cut the waves exp(+-i k omega t / 2) at an index K beyond which nothing resonates.  What
    # flows across is p / (2 (K + 2) omega) times the product of p / d_j from -K to K, d_j = 2 kappa - j^2 omega^2 / 2 -
    # p^2 / d_(j-1) the pivots between, all at least p.  Waves of even and odd index do not mix: the worse parity
    # counts. k begins at the last index with a pivot of at least p and goes down a few, for the lowest product; all
    # roundings make the bound larger.
    if p == 0.0 and kappa > 0.0:
        return 0.0
    half = up(up(fast * fast) * 0.5)
    twice = 2.0 * kappa
    squared = up(p * p)
    worst = 0.0
    for parity in range(2):
        best = up(p / down(2.0 * slow)) if parity == 1 else math.inf
        k = float(parity)
        while down(twice - up((k + 2.0) * (k + 2.0) * half)) >= p and k < MOST_ROWS:
            k += 2.0
        tried = 0
        while k >= 0.0 and tried < 3 and not best <= enough:
            pivot = down(twice - up(k * k * half))
            product = up(p / down(2.0 * (k + 2.0) * slow))
            j = -k
            while pivot >= p:
                product = up(product * up(p / pivot))
                j += 2.0
                if j > k:
                    break
                pivot = down(down(twice - up(j * j * half)) - up(squared / pivot))
            if j > k:
                best = min(best, product)
                tried += 1
            k -= 2.0
        worst = max(worst, best)
    return worst


@kernel
def mode_status(kappa: Pair, p: Pair, omega: Pair, level: Pair) -> int:
    """Return whether every point of a box grows at no more than a level, or every one faster.

    Parameters
    ----------
    kappa, p : (float, float)
        The equation u'' + (kappa - p sin omega t) u = 0, in 1/s^2; p >= 0.
    omega : (float, float)
        rad/s, above zero.
    level : (float, float)
        What the level lies between, in 1/s: the damping rate plus what growth is tolerated.

    Returns
    -------
    int
        `STABLE`: every solution of every equation of the box grows at no more than the lower level, and where that is 0
        is bounded.  `UNSTABLE`: each has a solution that grows faster than the upper.  `UNDECIDED`: not proved, or an
        argument is not finite.
    """
    # In the order of their price: without forcing the sign of kappa against the level; the flux bound, which proves
    # decay by damping far from tongues; counts of the chains at the two corners where the number is least and largest,
    # since it grows with kappa and falls with omega, p moved by ``shift`` to its middle (its perturbation is at most
    # that in norm); and the enclosure of the excess, which also decides growth against a level. Equal odd counts prove
    # boundedness of every equation between, equal even ones growth.
    kappa_low, kappa_high = kappa
    p_low, p_high = p
    slow, fast = omega
    level_low, level_high = level
    if not (
        kappa_low <= kappa_high and 0.0 <= p_low <= p_high and 0.0 < slow <= fast and 0.0 <= level_low <= level_high
    ):
        return UNDECIDED
    if not up(abs(kappa_low) + abs(kappa_high) + p_high + fast + level_high) < math.inf:
        return UNDECIDED
    if p_high == 0.0:
        if kappa_low > 0.0 or (level_low > 0.0 and -kappa_low <= down(level_low * level_low)):
            return STABLE
        return UNSTABLE if kappa_high < 0.0 and -kappa_high > up(level_high * level_high) else UNDECIDED
    if level_low > 0.0:
        lifted = down(kappa_low + max(0.0, down(level_low * level_low)))
        if flux_bound(lifted, p_high, slow, fast, level_low) <= level_low:
            return STABLE
    if kappa_low > p_high and math.sqrt(kappa_high) - math.sqrt(kappa_low) > 0.5 * fast + math.sqrt(kappa_low) * (
        fast / slow - 1.0
    ):
        return UNDECIDED  # more than two tongues wide: no verdict can be the same everywhere, or only by `flux_bound`
    middle = 0.5 * (p_low + p_high)
    shift = up(max(p_high - middle, middle - p_low))
    least = exact_count(down(kappa_low - shift), middle, fast, True)
    if least >= 0 and least == exact_count(up(kappa_high + shift), middle, slow, False):
        if least % 2 == 1:
            return STABLE
        if level_high == 0.0:
            return UNSTABLE
    return _by_excess(kappa, p, omega, level)


@kernel
def _by_excess(kappa: Pair, p: Pair, omega: Pair, level: Pair) -> int:
    """Return `mode_status` from enclosures of the excess: for the parity of the nearest tongue, then for the other."""
    # Growth over a period 2 pi / omega is 2 asinh(sqrt X), X the positive one of both excesses: growth at a
    # level means X = sinh^2(pi level / omega).  ``few`` is a lower bound of this X at the lower level, ``many`` an
    # upper bound at the upper one.  a and b enclose the excesses of both parities, whose sum is -1: each bounds the
    # other, too; one and other are the upper bounds that follow.  Stable where both are negative or below ``few``,
    # unstable where a lower bound exceeds ``many``.  The order n = 2 sqrt(kappa) / omega of the nearest tongue gives
    # the parity that is enclosed first: mostly it decides alone, and the second enclosure costs as much.
    few = 0.0
    if level[0] > 0.0:
        few = sinh_squared(min(down(PI_LOW * down(level[0] / omega[1])), 300.0))[0]
    many = 0.0
    if level[1] > 0.0:
        x = up(PI_HIGH * up(level[1] / omega[0]))
        many = sinh_squared(x)[1] if x < 300.0 else math.inf
    nearest = int(2.0 * math.sqrt(max(0.5 * (kappa[0] + kappa[1]), 0.0)) / (0.5 * (omega[0] + omega[1])) + 0.5) % 2
    a = excess(kappa, p, omega, nearest)
    b = -math.inf, math.inf
    for attempt in range(2):
        if attempt == 1:
            b = excess(kappa, p, omega, 1 - nearest)
        one = min(a[1], up(-1.0 - b[0]))
        other = min(b[1], up(-1.0 - a[0]))
        if (one < 0.0 and other < 0.0) or max(one, other) < few:
            return STABLE
        if max(a[0], down(-1.0 - b[1])) > many or max(b[0], down(-1.0 - a[1])) > many:
            return UNSTABLE
    return UNDECIDED
