"""Kernels for boxes of loads and rods: their numbers for each mode, and a bound for all modes beyond.

A box is an array (8, 2) of doubles: the lowest and highest values of

    0  F       mean force, N                     4  c2       w^2 / mu, 1/(N s^2)       mu mass per length
    1  dF      amplitude of the force, N         5  Omega^2  square of the pendulum frequency, 1/s^2
    2  omega   frequency, rad/s                  6  h        m_0^2, of modes held down where the channel bends
    3  c1      E I w^4 / mu, 1/s^2, w = pi / l   7  lambda   damping rate, 1/s

Mode m moves as A'' + 2 lambda A' + (c1 m^4 - c2 (m^2 - h) (F + dF sin omega t) + Omega^2) A = 0.  All numbers are in
seconds, and all conclusions are proved, rounding included.
"""

from __future__ import annotations

import math
from typing import Any

from floquetrod._util.compilation import kernel
from floquetrod.floquet.proof.kernels.double_intervals import Pair, down, multiply, square, up
from floquetrod.floquet.proof.kernels.regions_modes import mode_status
from floquetrod.floquet.status import UNDECIDED

MEAN, AMPLITUDE, FREQUENCY, BENDING, PUSH, SWING, HELD, DAMPING = range(8)
"""Rows of a box."""


_NOTHING = 1e-60
"""Growth in 1/s below which no smaller bound is looked for."""


@kernel
def side(box: Any, row: int) -> Pair:
    """Return both ends of a row of a box."""
    return box[row, 0], box[row, 1]


@kernel
def mode_box(box: Any, mode: int) -> tuple[Pair, Pair]:
    """Enclose kappa and p, both in 1/s^2, of a mode freed of its damping: u'' + (kappa - p sin omega t) u = 0."""
    m2 = float(mode) * float(mode)
    driven = m2, m2
    if box[HELD, 0] != 0.0 or box[HELD, 1] != 0.0:
        driven = down(m2 - box[HELD, 1]), up(m2 - box[HELD, 0])
    push = multiply(side(box, PUSH), driven)
    force = multiply(push, side(box, MEAN))
    p = 0.0, 0.0
    if box[AMPLITUDE, 1] > 0.0:
        low, high = multiply(push, side(box, AMPLITUDE))
        # Of a mode that is held the vibration has the opposite phase; of one about m_0 no sign is known.
        p = (max(low, 0.0), high) if driven[0] >= 0.0 else (max(-high, 0.0), max(high, -low))
    bending = multiply(
        multiply(side(box, BENDING), (m2, m2)), (m2, m2)
    )  # m2 is exact as a double, its square need not be
    damping = square(side(box, DAMPING))
    low = down(down(bending[0] - force[1]) + down(box[SWING, 0] - damping[1]))
    high = up(up(bending[1] - force[0]) + up(box[SWING, 1] - damping[0]))
    return (low, high), p


@kernel
def tail_bound(box: Any, last: int) -> float:
    """Return a proved bound in 1/s on the growth of every mode after ``last`` freed of its damping; infinite if none.

    Let level be the least lambda.  From m0 = last + 1 on, and c1 m^4 >= Omega^2 - lambda^2 + level^2, kappa / p grows
    with m, and every factor of `flux_bound` falls, but the first times p: that one is at most (c2 dF)^2 over a lower
    bound of its pivot / m^4.  Growth up to the level is not bounded: the larger of both counts.

    Where the channel bends the same holds in y = m^2 - h >= (last + 1)^2 - h: kappa is c1 y^2 - (c2 F - 2 c1 h) y +
    Omega^2 + c1 h^2 - lambda^2.
    """
    # `flux_bound` for all modes from m0 on at once: factor by factor the largest over these modes and the box. m2 and
    # m4 are m0^2 and m0^4 (of y where the channel bends); kappa a lower bound of the detuning, p an upper bound of the
    # coupling at m0; swing and most what is added to c1 m^4, lowest and highest. room bounds pivot / m^4 from below:
    # the first factor falls like that, all others by themselves. Every operation is rounded to the side that makes the
    # bound larger.
    level = box[DAMPING, 0]
    m0 = last + 1.0
    m2 = m0 * m0
    c1 = box[BENDING, 0]
    push = up(box[PUSH, 1] * box[AMPLITUDE, 1])
    mean = up(box[MEAN, 1] * (box[PUSH, 1] if box[MEAN, 1] > 0.0 else box[PUSH, 0]))
    bent = 0.0, 0.0
    if box[HELD, 0] != 0.0 or box[HELD, 1] != 0.0:
        m2 = down(m2 - box[HELD, 1])
        if not m2 > 0.0:
            return math.inf
        neutral_squared = side(box, HELD)
        mean = up(mean - multiply((2.0 * c1, 2.0 * box[BENDING, 1]), neutral_squared)[0])
        bent = multiply(side(box, BENDING), square(neutral_squared))
    m4 = down(m2 * m2)
    swing = down(down(box[SWING, 0] - up(box[DAMPING, 1] * box[DAMPING, 1])) + max(0.0, down(level * level)))
    most = up(up(box[SWING, 1] - max(0.0, down(box[DAMPING, 0] * box[DAMPING, 0]))) + up(level * level))
    if bent[1] != 0.0:
        swing, most = down(swing + bent[0]), up(most + bent[1])
    if not down(c1 * m4) >= most:
        return math.inf
    kappa = down(down(down(c1 * m4) - up(mean * m2)) + swing)
    p = up(push * m2) if box[AMPLITUDE, 1] > 0.0 else 0.0
    slow = box[FREQUENCY, 0]
    fast = box[FREQUENCY, 1]
    if not (kappa > 0.0 and slow > 0.0):
        return math.inf
    if p == 0.0:
        return 0.0
    quarter = up(up(fast * fast) * 0.5)
    worst = 0.0
    for parity in range(2):
        best = math.inf
        k = float(parity)
        while True:
            first = down(down(2.0 * kappa) - up(k * k * quarter))
            if not first >= p:
                break
            room = down(2.0 * c1 - up(2.0 * max(mean, 0.0) / m2))
            room = down(room + min(down(down(2.0 * swing - up(k * k * quarter)) / m4), 0.0))
            if not room > 0.0:
                break
            # The first factor with its p: p^2 / pivot = (c2 dF)^2 / (pivot / m^4) for all m at once; the others are p /
            # pivot at m0.
            bound = up(up(push * push) / room)
            pivot = first
            settled = True
            j = 2.0 - k
            while j <= k:
                pivot = down(down(down(2.0 * kappa) - up(j * j * quarter)) - up(up(p * p) / pivot))
                if not pivot >= p:
                    settled = False
                    break
                bound = up(bound * up(p / pivot))
                j += 2.0
            if not settled:
                break
            best = min(best, up(bound / down(2.0 * (k + 2.0) * slow)))
            if best < _NOTHING:
                break  # further factors only lower it, and far above the forcing there are thousands
            k += 2.0
        worst = max(worst, best)
    return worst


@kernel
def tail_modes(box: Any, tolerance: float, smallest: float, most: int) -> tuple[int, float]:
    """Return the number of modes to examine, and the bound proved for all others.

    Parameters
    ----------
    box : ndarray, shape (8, 2)
        See above.
    tolerance : float
        Growth in 1/s that counts as none.
    smallest : float
        Where tolerance is smaller, growth in 1/s up to which modes are left out all the same.
    most : int
        No more modes than these.

    Returns
    -------
    last : int
        Every mode after it grows by no more than max(tolerance, smallest); ``most`` where that cannot be proved.
    bound : float
        On the growth of every mode after ``last``, damping taken off, in 1/s; infinite where none is proved.
    """
    # `tail_bound` falls with ``last`` from where it is finite: doubling finds a number of modes that suffices,
    # bisection the least.  The target is the damping rate plus the tolerance, since the bound is on growth freed of
    # damping. Where doubling meets ``most`` the bound of ``most`` is returned, which the caller compares with the
    # tolerance.
    target = down(box[DAMPING, 0] + max(tolerance, smallest))
    low, high = 0, 1
    while high < most and not tail_bound(box, high) <= target:
        low, high = high, 2 * high
    high = min(high, most)
    while high - low > 1:
        middle = (low + high) // 2
        if tail_bound(box, middle) <= target:
            high = middle
        else:
            low = middle
    bound = tail_bound(box, high)
    return high, max(0.0, up(bound - box[DAMPING, 0])) if bound > 0.0 else 0.0


@kernel
def status_of_mode(box: Any, mode: int, tolerance_low: float, tolerance_high: float) -> int:
    """Return `mode_status` of a mode over a box; its growth is judged against damping plus tolerance.

    Nothing is said where the contact force, Omega^2 + c2 h F in these units, may come to zero.
    """
    # Level = damping + tolerance, between its two ends; kappa and p are those of the mode without damping.
    if box[HELD, 0] != 0.0 or box[HELD, 1] != 0.0:
        bend = multiply(side(box, PUSH), side(box, HELD))
        force = down(box[MEAN, 0] - box[AMPLITUDE, 1]), up(box[MEAN, 1] + box[AMPLITUDE, 1])
        if not down(box[SWING, 0] + multiply(bend, force)[0]) > 0.0:
            return UNDECIDED
    kappa, p = mode_box(box, mode)
    low = max(0.0, down(box[DAMPING, 0] + tolerance_low)) if box[DAMPING, 0] > 0.0 else tolerance_low
    high = up(box[DAMPING, 1] + tolerance_high) if box[DAMPING, 1] > 0.0 else tolerance_high
    return mode_status(kappa, p, side(box, FREQUENCY), (low, high))
