"""Whether a period and delays are whole numbers of a step, and whether delays are long."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple

from floquetrod._util.arrays import EPS
from floquetrod.equations import DelaySystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.floquet.multipliers import delay_maps

_SMALLEST_SHARE = 64  # of the shortest delay that the step of constant coefficients may be (a choice)
_MOST_STATES = 24  # of all parts together (a choice: tens of milliseconds for a map)
_MOST_STEPS = 4000  # of the longest delay (a choice: seconds)
_ROUNDED = 4.0 * EPS  # part of a delay by which it may miss a whole number of steps
_TURN = 1.0  # radians that solutions of constant coefficients turn by in a step, about (a choice)
_LONG, _LONG_PHASE = 5.0, 100.0  # periods, or radians of constant coefficients, from which a delay is long (measured)


class Steps(NamedTuple):
    """How many steps a period and the delays last."""

    period: Fraction  # of the coefficients; of constant ones a part of the delays
    parts: int  # q
    delays: tuple[int, ...]  # p_j


def is_long(system: DelaySystem) -> bool:
    """Return whether delays are so long that maps of a period take less time than a map of the history."""
    if not system.delayed:
        return False
    if system.is_constant:
        return delay_maps.rate(system) * system.longest_delay > _LONG_PHASE and steps(system) is not None
    return system.longest_delay > _LONG * system.period


def steps(system: DelaySystem) -> Steps | None:
    """Return the fewest steps of a period and of the delays; None where they are too many, or no whole numbers.

    A delay may miss a whole number of steps by its rounding.
    """
    fewest = _fewest(system)
    return fewest if fewest is not None and max(fewest.delays) <= _MOST_STEPS else None


def _fewest(system: DelaySystem) -> Steps | None:
    period, states = by_pieces.exact_period(system.present), system.order * (1 + system.is_second_order)
    most = _MOST_STATES // states
    if not most or not system.delayed:
        return None
    delays = [Fraction(delay) for delay in system.delays]
    if system.is_constant:
        shortest = min(delays)
        shares = [_share(delay / shortest, _SMALLEST_SHARE) for delay in delays]
        if None in shares:
            return None
        whole = math.lcm(*(share.denominator for share in shares if share))
        step = shortest / whole
        step /= max(1, math.ceil(delay_maps.rate(system) * float(step) / _TURN))
        return Steps(step, 1, tuple(round(delay / step) for delay in delays))
    shares = [_share(delay / period, most) for delay in delays]
    if None in shares:
        return None
    parts = math.lcm(*(share.denominator for share in shares if share))
    if parts > most:
        return None
    return Steps(period, parts, tuple(round(delay * parts / period) for delay in delays))


def _share(ratio: Fraction, most: int) -> Fraction | None:
    """Return a ratio as a fraction of at most this denominator; None where it misses one by more than rounding."""
    nearest = ratio.limit_denominator(most)
    return nearest if abs(nearest - ratio) <= _ROUNDED * ratio else None
