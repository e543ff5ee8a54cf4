"""The count for one equation in doubles, every pivot between two doubles rounded outwards: a count given is a proof."""

from __future__ import annotations

import math

from floquetrod._util.interval import down, up


def certain_count(alpha: float, beta: float, damping: float) -> tuple[int | None, int]:
    """Return the proved number of characteristic values below a (None where rounding hides it), and pivots used."""
    q = 2.0 * abs(alpha)
    a_low = a_high = -4.0 * beta
    if damping > 0.0:
        square = damping * damping
        a_low = down(a_low - up(4.0 * up(square)))
        a_high = up(a_high - down(4.0 * down(square)))
    count, pivots = 0, 0
    for start, doubled, shift in ((0.0, True, 0.0), (2.0, False, 0.0), (1.0, False, q), (1.0, False, -q)):
        k = start
        low, high = down(down(k * k - a_high) + shift), up(up(k * k - a_low) + shift)
        if a_low == a_high and k == 1.0:  # exact where 1 - a is: the tongue at a = 1 is then resolved at any q
            low, high = _one_less(a_low, shift)
        while True:
            pivots += 1
            if low <= 0.0 <= high:
                return None, pivots
            count += high < 0.0
            if low > q and down(k * k - a_high) >= 2.0 * q and not doubled:
                break
            square_low = down(q * down(q / high)) if q else 0.0
            square_high = up(q * up(q / low)) if q else 0.0
            if doubled:
                square_low, square_high, doubled = 2.0 * square_low, 2.0 * square_high, False
            k += 2.0
            low, high = down(down(k * k - a_high) - square_high), up(up(k * k - a_low) - square_low)
    return count, pivots


def _one_less(a: float, shift: float) -> tuple[float, float]:
    """Enclose 1 - a + shift, exactly where the double result is exact."""
    value = math.fsum((1.0, -a, shift))  # correctly rounded
    exact = math.fsum((1.0, -a, shift, -value)) == 0.0
    return (value, value) if exact else (down(value), up(value))
