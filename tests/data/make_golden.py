"""Make golden.npz: verdicts, growth rates and discriminants of 10,000 undamped Mathieu equations, from 50 digits.

Run from the root of the repository: python tests/data/make_golden.py
"""

from __future__ import annotations

import decimal
import math
import multiprocessing
from collections.abc import Iterator
from decimal import Decimal
from pathlib import Path

import numpy as np

from floquetrod.equations import Mathieu
from floquetrod.floquet.methods.reference import discriminant_excess
from floquetrod.floquet.proof import certify

SEED = 20160111  # the paper's volume and number, and its year
POINTS = 10_000
ALPHA = (0.0, 400.0)
BETA = (-400.0, 50.0)
NEAREST = 1e-12  # no point is closer to a transition curve than this, relative in beta
DIGITS = 50
OUT = Path(__file__).with_name("golden.npz")


def count_below(a: Decimal, q: Decimal) -> int:
    """Return how many characteristic values of Mathieu's equation lie below ``a`` (Sturm counts, 40 digits)."""
    total = 0
    chains = ((0, Decimal(0), 2 * q * q), (2, Decimal(0), q * q), (1, q, q * q), (1, -q, q * q))
    for first, shift, coupling in chains:
        k, pivot, square = first, first * first - a + shift, coupling
        while not (k > first and pivot > q and (k + 2) ** 2 - a >= 2 * q):
            total += pivot < 0
            k += 2
            pivot = k * k - a - square / (pivot or Decimal("1e-60"))
            square = q * q
    return total


def boundary_near(alpha: float, beta: float) -> float:
    """Return the beta of the transition curve just above ``beta``, or of the uppermost one if there is none."""
    decimal.getcontext().prec = 40
    q, a = 2 * Decimal(alpha), -4 * Decimal(beta)
    below = max(count_below(a, q), 1)
    low, high = min(a, Decimal(0)) - 2 * q - 1, max(a, Decimal(0))
    while high - low > Decimal("1e-22"):
        middle = (low + high) / 2
        low, high = (middle, high) if count_below(middle, q) < below else (low, middle)
    return float(low / -4)


def candidates() -> Iterator[tuple[float, float, float]]:
    """Yield (alpha, beta, distance) for ever; with a distance, a point that far from the curve above beta is meant."""
    rng = np.random.default_rng(SEED)
    while True:
        yield rng.uniform(*ALPHA), rng.uniform(*BETA), 0.0  # one anywhere, one beside a curve
        alpha = rng.uniform(*ALPHA) if rng.random() < 0.5 else 10.0 ** rng.uniform(-3.0, math.log10(ALPHA[1]))
        yield alpha, rng.uniform(*BETA), float(rng.choice((-1.0, 1.0))) * 10.0 ** rng.uniform(-11.0, -3.0)


def judged(candidate: tuple[float, float, float]) -> tuple[float, ...] | None:
    """Return the row of a candidate, or None when it lies too close to a curve or outside the range."""
    alpha, beta, distance = candidate
    if distance:
        beta = boundary_near(alpha, beta) * (1.0 + distance)
    if not BETA[0] <= beta <= BETA[1]:
        return None
    # Both neighbours proved to lie in the same stability interval or tongue: no curve runs between them.
    sides = [certify(Mathieu(alpha, beta * (1.0 + side * NEAREST))) for side in (-1.0, 1.0)]
    if sides[0].status == "undecided" or sides[0].interval != sides[1].interval:
        return None
    sign, excess, error, _ = discriminant_excess(Mathieu(alpha, beta), DIGITS)
    stable = excess < 0
    if abs(excess) <= 1e17 * error or stable != sides[0].stable:
        raise RuntimeError(f"the reference and the proof disagree at alpha = {alpha!r}, beta = {beta!r}")
    context = excess.context
    with context.workdps(2 * DIGITS):
        mantissa, exponent = context.frexp(excess)
        trace = sign * (2 + 4 * excess)
        growth = 0 if stable else context.asinh(context.sqrt(excess)) / context.pi
        size = float(context.log(abs(trace)))
        large = abs(trace) > context.mpf(np.finfo(float).max)
        trace = sign * math.inf if large else float(trace)
        return alpha, beta, float(stable), sign, float(mantissa), exponent, float(growth), trace, size


def main() -> None:
    """Judge candidates on all cores until there are enough, in an order that does not depend on the cores."""
    rows = []
    with multiprocessing.Pool() as pool:
        for row in pool.imap(judged, candidates_in_reach(), chunksize=8):
            if row is not None:
                rows.append(row)
    if len(rows) < POINTS:
        raise RuntimeError(f"only {len(rows)} of {POINTS} points: yield more candidates")
    alpha, beta, stable, sign, mantissa, exponent, growth, trace, size = np.array(rows[:POINTS]).T
    np.savez_compressed(
        OUT,
        alpha=alpha,
        beta=beta,
        stable=stable.astype(bool),
        sign=sign.astype(np.int8),
        excess_mantissa=mantissa,
        excess_exponent=exponent.astype(np.int16),
        growth_rate=growth,
        discriminant=trace,
        log_abs_discriminant=size,
    )


def candidates_in_reach() -> Iterator[tuple[float, float, float]]:
    """Yield a tenth more candidates than points: enough, since few are refused."""
    for _, candidate in zip(range(POINTS + POINTS // 10), candidates(), strict=False):
        yield candidate


if __name__ == "__main__":
    main()
