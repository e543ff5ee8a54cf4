"""Hill's equation by counting: a banded matrix and what it leaves out.

Periodic and antiperiodic eigenvalues mu of -u'' + p u = mu u below zero are counted, mu = 0 lying in a band exactly
when their number is odd.  In the basis cos, sin the infinite symmetric matrix [H, C; C', R] is truncated at frequency
K.  With R >= delta > 0, H has at most as many negative eigenvalues as the whole, and H - C C' / delta at least as many.
A single interval matrix that contains both is factorised: if no pivot can be zero, both have the same count, and zero
is no eigenvalue.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple

from floquetrod.floquet.proof.many_digits import Unresolved, check_work, enclose, rational
from floquetrod.floquet.proof.pivots import Count, Pivots, closer, no_sign
from floquetrod.floquet.proof.series import EnclosedSeries

_Row = dict[int, Any]
"""The lower half of a row of a symmetric matrix: entries by column."""


class _Mode(NamedTuple):
    """A basis function cos(k theta), or sin(k theta)."""

    frequency: Fraction
    is_sine: bool


def count_eigenvalues(context: Any, series: EnclosedSeries) -> Count:
    """Count the periodic and antiperiodic eigenvalues below zero."""
    bound = sum((wave.size for wave in series.waves), context.zero)
    # Far enough for delta > bound, and with the digits for C C' / delta not to be felt at the other end (heuristic).
    need = max(0.0, float((2 * bound - series.mean + 1).b))
    check_work(context, 15.0 * math.sqrt(need) * (2.0 * len(series.waves) + 1.0) ** 2)
    last = len(series.waves) + 1 + math.ceil(math.sqrt(need)) + context.dps // 3
    below, enclosures = 0, []
    for name, start in (("periodic", Fraction(0)), ("antiperiodic", Fraction(1, 2))):
        frequencies = [start + k for k in range(last + 1)]
        pivots = _count_pivots(_rows(context, series, bound, frequencies))
        below += pivots.negative
        enclosures.append(enclose(f"pivot closest to zero, {name}", pivots.closest))
    return Count(below, tuple(enclosures))


def _rows(context: Any, series: EnclosedSeries, bound: Any, frequencies: list[Fraction]) -> list[_Row]:
    """Return the rows of a matrix that holds both H and H - C C' / delta.

    Twice the average of u'^2 + p u^2 over u = sum_k a_k cos(k theta) + b_k sin(k theta); the highest frequency first,
    so that the first pivots are positive and a vanishing mean does not give a vanishing pivot.
    """
    reach, top = len(series.waves), frequencies[-1]
    delta = rational(context, (top + 1) ** 2) + series.mean - bound
    if not delta > 0:
        raise Unresolved("the part of Hill's matrix that is left out cannot be bounded")
    modes = [_Mode(k, odd) for k in reversed(frequencies) for odd in (False, True) if k or not odd]
    beyond = [_Mode(top + k, odd) for k in range(1, reach + 1) for odd in (False, True)]
    rows: list[_Row] = []
    for i, mode in enumerate(modes):
        near = [j for j in range(max(0, i - 2 * reach - 1), i + 1) if modes[j].frequency - mode.frequency <= reach]
        row = {j: _coupling(context, series, mode, modes[j]) for j in near}
        row[i] += rational(context, mode.frequency**2)
        if top - mode.frequency < reach:
            for j in near:
                pairs = ((_coupling(context, series, modes[m], far) for m in (i, j)) for far in beyond)
                row[j] -= context.mpf([0, 1]) / delta * sum((x * y for x, y in pairs), context.zero)
        rows.append(row)
    return rows


def _coupling(context: Any, series: EnclosedSeries, one: _Mode, other: _Mode) -> Any:
    """Return twice the average of p times two modes."""
    difference, total = int(other.frequency - one.frequency), int(other.frequency + one.frequency)
    if one.is_sine == other.is_sine:
        near, far = (_cosine_part(series, m, context) for m in (difference, total))
        return (near - far if one.is_sine else near + far) / 2
    near, far = (_sine_part(series, m, context) for m in (difference, total))
    return (far + near if other.is_sine else far - near) / 2


def _cosine_part(series: EnclosedSeries, m: int, context: Any) -> Any:
    """Return twice the average of p cos(m theta)."""
    if m == 0:
        return 2 * series.mean
    return series.waves[abs(m) - 1].cosine if abs(m) <= len(series.waves) else context.zero


def _sine_part(series: EnclosedSeries, m: int, context: Any) -> Any:
    """Return twice the average of p sin(m theta)."""
    if m == 0 or abs(m) > len(series.waves):
        return context.zero
    value = series.waves[abs(m) - 1].sine
    return -value if m < 0 else value


def _count_pivots(rows: list[_Row]) -> Pivots:
    """Count the negative pivots of a banded symmetric matrix; ``rows`` is overwritten with its factors."""
    pivots: list[Any] = []
    count, least = 0, None
    for i, row in enumerate(rows):
        for j in sorted(row)[:-1]:
            lower = rows[j]
            for m in lower:
                if m < j and m in row:
                    row[j] -= row[m] * lower[m] / pivots[m]
        pivot = row[i]
        for j, entry in row.items():
            if j < i:
                pivot -= entry**2 / pivots[j]
        if not (pivot > 0 or pivot < 0):
            raise no_sign()
        count += bool(pivot < 0)
        least = closer(least, pivot)
        pivots.append(pivot)
    return Pivots(count, least)
