"""Kernels that count the characteristic values below a mode's number, in doubles rounded outwards, for boxes of loads.

Without its damping a mode is u'' + (kappa - p sin omega t) u = 0.  Multiplied by h = omega^2 / 4, the rows of the
four chains are k^2 h - kappa and their couplings g = p / 2, so that nothing is divided by omega.
"""

from __future__ import annotations

from floquetrod._util.compilation import kernel
from floquetrod.floquet.proof.kernels.double_intervals import down, up

MOST_ROWS = 20_000  # of a chain, after which nothing is concluded


@kernel
def _chain_count(kappa: float, g: float, h: float, first: float, shift: float, doubled: bool) -> int:
    """Return how many eigenvalues of a chain lie below kappa, all numbers exact, or -1 where rounding hides it."""
    # The eigenvalues below kappa are as many as negative pivots (Sylvester's law of inertia)
    #     d_first = first^2 h - kappa + shift,    d_k = k^2 h - kappa - g^2 / d_(k-2),    k = first + 2, first + 4, ...,
    # with 2 g^2 in place of the first g^2 in the even chain.  low <= d_k <= high: every operation is rounded outwards;
    # x and y are the ends of k^2 h - kappa.  A pivot that may be zero ends it with -1.  -g^2 / d rises with d on either
    # side of zero, so that low follows from low and high from high, with the end of g^2 that the sign of d asks for.
    # Beyond the first row, d_k > g and k'^2 h - kappa >= 2 g for all later rows k' leave no negative pivot: the count
    # is final.
    x = down(first * first * h)
    y = up(first * first * h)
    low = down(down(x - kappa) + shift)
    high = up(up(y - kappa) + shift)
    coupling_low = max(0.0, down(g * g))
    coupling_high = up(g * g)
    factor = 2.0 if doubled else 1.0
    count = 0
    k = first
    while k < MOST_ROWS:
        if not (low > 0.0 or high < 0.0):
            return -1
        k += 2.0
        x = down(down(k * k * h) - kappa)
        if k > first + 2.0 and low > g and x >= 2.0 * g:
            return count
        y = up(up(k * k * h) - kappa)
        if high < 0.0:
            count += 1
        if low > 0.0:
            low, high = down(x - up(factor * coupling_high / low)), up(y - down(factor * coupling_low / high))
        else:
            low, high = down(x - up(factor * coupling_low / low)), up(y - down(factor * coupling_high / high))
        factor = 1.0
    return -1


@kernel
def exact_count(kappa: float, p: float, fast: float, high: bool) -> int:
    """Return how many characteristic values lie below kappa where p is exact, and omega^2 / 4 rounded up or down.

    The number falls with omega: up (``high``) gives at most what it is at ``fast``, down at least.  -1 where rounding
    hides the answer.
    """
    h = up(up(fast * fast) * 0.25) if high else down(down(fast * fast) * 0.25)
    g = 0.5 * p
    if not (g > 1e-150 and h > 0.0):
        return -1
    total = 0
    for chain in range(4):
        first = (0.0, 2.0, 1.0, 1.0)[chain]
        shift = (0.0, 0.0, g, -g)[chain]
        count = _chain_count(kappa, g, h, first, shift, chain == 0)
        if count < 0:
            return -1
        total += count
    return total
