"""Mathieu's equation by counting: negative pivots of four tridiagonal chains.

With a = -4 beta, q = 2 abs(alpha), the solutions are bounded exactly when an odd number of characteristic values lies
below a and none at it (DLMF 28.2, 28.4).  They are the eigenvalues of four symmetric tridiagonal chains with diagonals
D_k and squared couplings e_k; the negative pivots d_k = D_k - a - e_(k-1) / d_(k-1) are counted.  A pivot that may be
zero is taken together with the next: the pair [d, e; e, x] has one eigenvalue of each sign if d x - e^2 < 0, and the
pivot after it is D - a - q^2 d / (d x - e^2).

*Why a finite number of pivots decides.*  Let K be beyond the first row, whose coupling may be larger than the others,
and let d_K > q and D_k - a >= 2 q for all k > K.  Then d_(K+1) > 2 q - q^2 / q = q, and so on: all later pivots exceed
q.  So (u, (H - a) u) = sum_k d_k (u_k + sqrt(e_k) u_(k+1) / d_k)^2 has n negative terms, n the count, and is positive
on the subspace of codimension n where these vanish: were it zero there, u_k = -(sqrt(e_k) / d_k) u_(k+1) would make
abs(u_k) grow with k without bound, and u would not be in the space.  At most n eigenvalues of the infinite matrix are
therefore <= a; at least n are < a because the finite part has n of them.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple

from floquetrod.floquet.proof.many_digits import check_work, enclose, rational
from floquetrod.floquet.proof.pivots import Count, Pivots, closer, no_sign


class ChainRows(NamedTuple):
    """A chain with the diagonal first^2 + shift, (first + 2)^2, (first + 4)^2, ...

    ``coupling`` is the square of the first off-diagonal entry; the others are q.
    """

    name: str
    first: int
    shift: Any
    coupling: Any


def count_eigenvalues(context: Any, mean: Fraction, amplitude: Fraction, damping: Fraction) -> Count:
    """Count the characteristic values below a = -4 (mean + c^2) for the coefficient mean + amplitude sin tau."""
    a = rational(context, -4 * (mean + damping**2))
    q = rational(context, 2 * abs(amplitude))
    check_work(context, 16.0 * (20.0 + math.sqrt(8.0 * abs(amplitude) + max(0.0, -4.0 * mean))))
    square = q * q
    chains = (
        ChainRows("even, period pi", 0, 0 * q, 2 * square),
        ChainRows("odd, period pi", 2, 0 * q, square),
        ChainRows("even, period 2 pi", 1, q, square),
        ChainRows("odd, period 2 pi", 1, -q, square),
    )
    pivots = [_count_chain(a, q, chain) for chain in chains]
    enclosures = (
        enclose(f"pivot closest to zero, {chain.name}", chain_pivots.closest)
        for chain, chain_pivots in zip(chains, pivots, strict=True)
    )
    return Count(sum(chain_pivots.negative for chain_pivots in pivots), tuple(enclosures))


def _count_chain(a: Any, q: Any, chain: ChainRows) -> Pivots:
    """Count the negative pivots of a chain; a pair's closest value is divided by its off-diagonal entry q."""
    k, coupling = chain.first, chain.coupling
    count, pivot = 0, (k * k - a) + chain.shift
    square = q * q
    least = None
    while True:  # a first pivot never ends it: the coupling after it may be larger than q
        entry = (k + 2) ** 2 - a
        if pivot > 0 or pivot < 0:
            least = closer(least, pivot)
            if k > chain.first and pivot > q and entry >= 2 * q:
                return Pivots(count, least)
            count += bool(pivot < 0)
            pivot = entry - coupling / pivot
            k += 2
        else:
            pair = pivot * entry - coupling
            if not pair < 0:
                raise no_sign()
            least = closer(least, pair / q)
            count += 1
            pivot = ((k + 4) ** 2 - a) - square * (pivot / pair)
            k += 4
        coupling = square
