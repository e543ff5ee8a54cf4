"""Kernels for A'' + 2 c A' = (beta + alpha sin tau) A - sign(A'), event by event, for ever.

By homogeneity gamma = 1 throughout.  A period is cut into equal cells short against every wave.  Between reversals of
A' the equation is linear with the forcing -s, s = sign(A'), so a cell is a 2 x 2 matrix and a vector, made once for all
orbits.  Only a cell that a bound cannot clear of reversals is looked into: the motion in it is one Taylor series, the
sign changes of its Bernstein coefficients tell whether A' has a zero, and bracketed Newton finds the first.

How an orbit ends for ever (proofs in docs/friction.md; p lies between -P and Q):

*Escape.*  E = A' psi - A (psi' - 2 c psi) obeys E' = -s psi, psi the decaying solution of psi'' - 2 c psi' = p psi.
Where abs(E) exceeds the integral of abs(psi) over all later time, E keeps its sign for good and the motion grows like
the growing Floquet solution.  Every motion that does not stay bounded passes this test at some time.

*Caught.*  At rest where (abs(alpha) + abs(beta)) abs(A) <= 1: for ever.  At rest where Q abs(A) <= 1 and
abs(alpha) abs(A) <= 2: no later stop lies farther out.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._compile import kernel

# Why a run ended; what is below LIMIT is final.
NO_GROWTH = 0  # without friction no solution grows
STUCK = 1  # at rest for ever
KEPT = 2  # at rest where energy allows no later stop farther out
TRAPPED = 3  # sticks and slips for ever
GROWS = 4  # the escape test
LIMIT = 5  # the bound on the number of cells was reached
SLOW_RELEASE = 6  # stuck, with a force that frees it by less than `_SLOW`: creeps outwards, too slowly to follow

MIXED = 7  # creeps outwards, and such orbits differ in fate: kicks that escape lie arbitrarily close

_ORDER = 16  # of Taylor series: with the cells below, what is left out is under 1e-17
_CELL_WAVE = 0.7  # longest cell times the largest sqrt(abs(p)), and times 2 c
_FEWEST_CELLS = 32  # a period
_SLOW = 5e-3  # relative excess of the freeing force below which creeping outwards is not followed (heuristic)
_SAMPLES = 8  # of creeping outwards (heuristic)
_WATCHED = 50  # periods in which sticking and slipping is watched for its range (heuristic)
_TRIED = 25  # amplitudes of that range tried (heuristic)
_FEW = 5  # while it is still growing (heuristic)
_GROWN = 20  # times that range is grown (heuristic)
_ROUNDING = 1e-12  # relative, in amplitudes a period apart (heuristic): what drifts by more is not at rest
_ROUNDED = 1e-12  # relative: a proved kick is lowered by it, far more than its error of rounding (measured)
_STEEP = 1e12  # a slope beyond which the kick that stops is at its limit, to rounding
_LONGEST_PUSH = 8.0 * math.pi  # how long first stops are followed (a choice: a shorter time gives a lower bound)
_HALVINGS = 45  # of a cell in search of a reversal
_NARROWEST = 2.0**-_HALVINGS
_NEAR = 1e-9  # relative step of Newton's method after which the next would be below rounding
_EPS = 2.220446049250313e-16

KNOWN = 5  # numbers that orbits of an equation have shown, see `workspace`
COLUMNS = 11  # of a table: matrix (4), forcing (2), bounds (3), escape test (2)


@kernel
def cell_count(alpha: float, beta: float, damping: float) -> int:
    """Return the number of cells of a period."""
    wave = math.sqrt(abs(alpha) + abs(beta))
    return max(_FEWEST_CELLS, int(2.0 * math.pi * max(wave, 2.0 * damping) / _CELL_WAVE) + 1)


@kernel
def _series(
    alpha: float, beta: float, c: float, s: float, tau: float, h: float, a0: float, a1: float, p: Any, a: Any
) -> None:
    """Fill ``a`` with the Taylor coefficients of A in x = (t - tau) / h, from A = a0 and h A' = a1 at tau."""
    sine = alpha * math.sin(tau) * h * h
    cosine = alpha * math.cos(tau) * h * h
    order = len(a) - 2  # of the arrays, not the constant: loops that the compiler need not unroll
    for i in range(order + 1):
        p[i] = sine
        sine, cosine = cosine * h / (i + 1.0), -sine * h / (i + 1.0)
    p[0] += beta * h * h
    a[0] = a0
    a[1] = a1
    for j in range(order):
        total = -2.0 * c * h * (j + 1.0) * a[j + 1]
        if j == 0:
            total -= s * h * h
        for i in range(j + 1):
            total += p[i] * a[j - i]
        a[j + 2] = total / ((j + 1.0) * (j + 2.0))


@kernel
def _value(a: Any, x: float) -> float:
    """Return A from its series."""
    total = 0.0
    for j in range(len(a) - 1, -1, -1):
        total = total * x + a[j]
    return total


@kernel
def _slope(a: Any, x: float) -> float:
    """Return dA/dx from the series of A."""
    total = 0.0
    for j in range(len(a) - 1, 0, -1):
        total = total * x + j * a[j]
    return total


@kernel
def _bracketed_root(q: Any, n: int, low: float, high: float) -> float:
    """Return the zero of the polynomial q of degree n in [low, high], where it falls from positive to not positive."""
    x = 0.5 * (low + high)
    if low == 0.0 and high == 1.0:  # a whole cell: from the chord
        end = q[n]
        for j in range(n - 1, -1, -1):
            end += q[j]
        if q[0] > 0.0 >= end:
            x = q[0] / (q[0] - end)
    for _ in range(80):
        f = q[n]
        d = 0.0
        for j in range(n - 1, -1, -1):
            d = d * x + f
            f = f * x + q[j]
        if f > 0.0:
            low = x
        else:
            high = x
        new = x - f / d if d != 0.0 else low
        inside = low < new < high
        if not inside:
            new = 0.5 * (low + high)
        if (inside and abs(new - x) <= _NEAR * x) or high - low <= 2.0 * _EPS * high:
            return new
        x = new
    return x


@kernel
def _first_root(q: Any, n: int, weights: Any, stack: Any) -> float:
    """Return the first zero in (0, 1] of the polynomial q of degree n, positive at 0; -1 where there is none.

    Most are monotone by a bound on the slope.  Else Bernstein coefficients without a change of sign exclude a zero, one
    change means one zero, more are halved.  Zeros that `_HALVINGS` do not part are a touch of zero: no reversal.
    """
    bound = 0.0
    end = 0.0
    for j in range(n, 1, -1):
        bound += j * abs(q[j])
        end += q[j]
    end += q[1] + q[0]
    if q[1] >= bound or (q[1] <= -bound and end > 0.0):
        return -1.0
    if q[1] <= -bound:
        return _bracketed_root(q, n, 0.0, 1.0)
    shift = (_ORDER - n) * (_ORDER + 2)
    for i in range(n + 1):
        total = 0.0
        for j in range(i + 1):
            total += weights[shift + i, j] * q[j]
        stack[0, i] = total
    depth = 0
    low = 0.0
    width = 1.0
    # stack[depth] is the piece looked at; below it lie right halves still to be looked at, widest first.
    while True:
        changes = 0
        positive = True
        for i in range(n + 1):
            if stack[depth, i] != 0.0 and (stack[depth, i] > 0.0) != positive:
                changes += 1
                positive = not positive
        if changes == 1 and not positive:
            return _bracketed_root(q, n, low, low + width)
        if changes == 0 or width < _NARROWEST:
            # Nothing here: on to the right half that was put by last.
            low += width
            if depth == 0 or low >= 1.0:
                return -1.0
            depth -= 1
            width = stack[depth, n + 1]
            continue
        # Halve (de Casteljau): the right half replaces the piece, the left is put on top.
        for i in range(n + 1):
            stack[depth + 1, i] = stack[depth, i]
        width *= 0.5
        for j in range(1, n + 1):
            for i in range(n + 1 - j):
                stack[depth, i] = 0.5 * (stack[depth, i] + stack[depth, i + 1])
            # stack[depth, 0] is the left half's next coefficient; the right half's come out in place, last first.
            stack[depth + 1, j] = stack[depth, 0]
        stack[depth, n + 1] = width
        depth += 1
        stack[depth, n + 1] = width


@kernel
def _left_vector(table: Any, decay: float) -> tuple[float, float]:
    """Return the left eigenvector of the period's matrix that belongs to the growing solution, of length 1.

    Rows of M - L I, L the smaller eigenvalue, are multiples of it (Cayley and Hamilton).  ``decay`` is the size of L.
    """
    a, b, c, d = 1.0, 0.0, 0.0, 1.0
    scale = 1.0
    for k in range(len(table)):
        m11, m12, m21, m22 = table[k, 0], table[k, 1], table[k, 2], table[k, 3]
        a, b, c, d = m11 * a + m12 * c, m11 * b + m12 * d, m21 * a + m22 * c, m21 * b + m22 * d
        size = max(abs(a), abs(b), abs(c), abs(d))
        if size > 1e100:
            a, b, c, d, scale = a / size, b / size, c / size, d / size, scale / size
    small = decay * scale if a + d >= 0.0 else -decay * scale
    a -= small
    d -= small
    first = math.hypot(a, b)
    second = math.hypot(c, d)
    if first >= second:
        return (a / first, b / first) if first > 0.0 else (0.0, 0.0)
    return c / second, d / second


@kernel
def _integral_of_size(a: Any) -> float:
    """Return the integral over x in [0, 1] of abs(A), A given by its series, with at most one change of sign."""
    end = 0.0
    whole = 0.0
    for j in range(len(a) - 1, -1, -1):
        whole += a[j] / (j + 1.0)
        end += a[j]
    if (a[0] >= 0.0) == (end >= 0.0):
        return abs(whole)
    low = 0.0
    high = 1.0
    for _ in range(60):
        x = 0.5 * (low + high)
        if (_value(a, x) >= 0.0) == (a[0] >= 0.0):
            low = x
        else:
            high = x
    part = 0.0
    for j in range(len(a) - 1, -1, -1):
        part = (part + a[j] / (j + 1.0)) * low
    return abs(part) + abs(whole - part)


@kernel
def prepare(alpha: float, beta: float, c: float, rate: float, table: Any, work: Any) -> None:
    """Fill ``table`` with the cells of a period and forget what was known.

    ``rate`` is the growth per unit tau, damping included, or zero.

    Columns: the matrix and the forcing of (A, A') over the cell for s = 1; bounds on what A = 1, A' = 1 and the
    forcing change in A' anywhere in it; the row (e1, e2) of the escape test abs(e1 A + e2 A') > 1 at its beginning.
    """
    count = len(table)
    h = 2.0 * math.pi / count
    p, a = work[0], work[1]
    _set(work[5], -1.0)
    for k in range(count):
        for column in range(3):
            s = 1.0 if column == 2 else 0.0
            _series(alpha, beta, c, s, k * h, h, 1.0 if column == 0 else 0.0, h if column == 1 else 0.0, p, a)
            bound = 0.0
            for j in range(len(a) - 1, 1, -1):
                bound += j * abs(a[j])
            value = _value(a, 1.0)
            slope = _slope(a, 1.0) / h
            if column == 2:
                table[k, 4] = value
                table[k, 5] = slope
            else:
                table[k, column] = value
                table[k, 2 + column] = slope
            table[k, 6 + column] = bound / h
        table[k, 9] = 0.0
        table[k, 10] = 0.0
    if rate > 0.0:
        _prepare_escape(alpha, beta, c, rate, p, a, table)


@kernel
def _prepare_escape(alpha: float, beta: float, c: float, rate: float, p: Any, a: Any, table: Any) -> None:
    """Fill the columns of the escape test: psi and its derivative over what is left of the integral of abs(psi)."""
    count = len(table)
    h = 2.0 * math.pi / count
    l1, l2 = _left_vector(table, math.exp(-2.0 * math.pi * (rate + 2.0 * c)))
    left = 0.0
    for sweep in range(2):
        for k in range(count - 1, -1, -1):
            m1 = l1 * table[k, 0] + l2 * table[k, 2]
            m2 = l1 * table[k, 1] + l2 * table[k, 3]
            size = math.hypot(m1, m2)
            l1, l2 = m1 / size, m2 / size
            _series(alpha, beta, -c, 0.0, k * h, h, l2, (2.0 * c * l2 - l1) * h, p, a)
            left = h * _integral_of_size(a) + left / size
            if sweep == 1:
                table[k, 9] = l1 / left
                table[k, 10] = l2 / left
        if sweep == 0:
            left /= -math.expm1(-2.0 * math.pi * rate)


@kernel
def _wait(theta: float, size: float, alpha: float, beta: float) -> float:
    """Return how long a stick at abs(A) = size lasts from phase theta; infinite where it is never freed.

    It is freed where abs(p) rises through 1 / size: where p = beta + alpha sin rises through it, or falls through its
    negative.
    """
    turn = 2.0 * math.pi
    phase = theta if alpha >= 0.0 else theta + math.pi
    best = math.inf
    level = 1.0 / size
    k = (level - beta) / abs(alpha) if alpha != 0.0 else math.inf
    if abs(k) < 1.0:
        best = (math.asin(k) - phase) % turn
    k = -(level + beta) / abs(alpha) if alpha != 0.0 else math.inf
    if abs(k) < 1.0:
        best = min(best, (math.pi - math.asin(k) - phase) % turn)
    return best


@kernel
def run(
    alpha: float,
    beta: float,
    c: float,
    table: Any,
    start: Any,
    most: int,
    record: Any,
    work: Any,
) -> int:
    """Follow one orbit until its fate is known, over at most ``most`` cells; return why it ended.

    ``start`` holds A, A', the phase in [0, 2 pi), the sign of E once it has escaped, the numbers of reversals and
    sticks and that of whole periods: as they are and then as they become, so that a run can be resumed; then the
    period at which to end.  ``record`` (rows of tau, A, A', state) is filled as far as it reaches; its last row is the
    one whose tau is infinite.  A run with rows to record goes on when its fate is known, but for rest for ever.
    ``work`` is scratch space from `workspace`.
    """
    decide = len(record) == 0
    span = start[7]
    count = len(table)
    h = 2.0 * math.pi / count
    p, a, q, weights, stack, known = work
    big = abs(alpha) + abs(beta)
    outward = beta + abs(alpha)  # Q: the largest p
    inward = abs(alpha) - beta  # P: the largest -p
    x, v, phase = start[0], start[1], start[2]
    k = min(int(phase / h), count - 1)
    offset = max(0.0, phase - k * h)
    side, reversals, sticks, periods = start[3], start[4], start[5], start[6]
    s = 1.0 if v > 0.0 else -1.0
    event = v == 0.0 or offset > 0.0
    rows = 0
    fate = LIMIT
    used = 0
    if rows < len(record):
        record[0, 0], record[0, 1], record[0, 2] = phase + periods * 2.0 * math.pi, x, v
        record[0, 3] = s if v != 0.0 else 0.0
        rows = 1
    while used < most and periods < span:
        used += 1
        if not event:
            e = table[k, 9] * x + table[k, 10] * v
            if abs(e) > 1.0 + 1e-13 and decide:
                side = e
                fate = GROWS
                break
            if abs(v) * (1.0 - table[k, 7]) > abs(x) * table[k, 6] + table[k, 8]:
                new = table[k, 0] * x + table[k, 1] * v + s * table[k, 4]
                v = table[k, 2] * x + table[k, 3] * v + s * table[k, 5]
                x = new
                k += 1
            else:
                _series(alpha, beta, c, s, k * h, h, x, v * h, p, a)
                for j in range(len(a) - 1):
                    q[j] = s * (j + 1.0) * a[j + 1]
                root = _first_root(q, len(a) - 2, weights, stack)
                if root < 0.0:
                    x = _value(a, 1.0)
                    v = _slope(a, 1.0) / h
                    k += 1
                    if s * v <= 0.0:
                        v = 0.0
                        offset = 0.0
                        event = True
                        reversals += 1.0
                else:
                    x = _value(a, root)
                    v = 0.0
                    offset = root * h
                    event = True
                    reversals += 1.0
        else:
            released = False
            if v == 0.0:
                tau = k * h + offset
                force = (beta + alpha * math.sin(tau)) * x
                size = abs(x)
                if decide and size * big > 1.0 and outward * size <= 1.0 and abs(alpha) * size <= 2.0:
                    fate = KEPT
                    break
                if abs(force) <= 1.0:
                    sticks += 1.0
                    if rows < len(record):
                        record[rows, 0] = tau + periods * 2.0 * math.pi
                        record[rows, 1], record[rows, 2], record[rows, 3] = x, 0.0, 0.0
                        rows += 1
                    if size * big <= 1.0:
                        fate = STUCK
                        break
                    if decide:
                        if outward * size > 1.0 and inward <= 0.0:
                            side = x
                            fate = GROWS
                            break
                        if 1.0 < outward * size < 1.0 + _SLOW and inward * size <= 1.0 and known[4] <= 0.0:
                            fate = SLOW_RELEASE
                            break
                    wait = _wait(tau, size, alpha, beta)
                    if wait == math.inf:
                        fate = STUCK
                        break
                    if decide and known[2] <= size <= known[3] and (known[1] - tau) % (2.0 * math.pi) <= wait:
                        fate = TRAPPED
                        break
                    tau += wait
                    turns = math.floor(tau / (2.0 * math.pi))
                    if turns > 0.0:
                        periods += turns
                        tau = max(0.0, tau - turns * 2.0 * math.pi)
                    k = min(int(tau / h), count - 1)
                    offset = min(h, max(0.0, tau - k * h))
                    force = (beta + alpha * math.sin(k * h + offset)) * x
                    released = True
                s = 1.0 if force > 0.0 else -1.0
                if rows < len(record):
                    record[rows, 0] = k * h + offset + periods * 2.0 * math.pi
                    record[rows, 1], record[rows, 2], record[rows, 3] = x, 0.0, s
                    rows += 1
            # Fly on from inside the cell, from rest (or from where the orbit starts).
            left = h - offset
            _series(alpha, beta, c, s, k * h + offset, left, x, v * left, p, a)
            first = 0 if v != 0.0 else 1
            if released:
                a[2] = 0.0  # the force is what holds it: exactly, not to rounding
                first = 2
            for j in range(len(a) - 1 - first):
                q[j] = s * (j + 1.0 + first) * a[j + 1 + first]
            root = _first_root(q, len(a) - 2 - first, weights, stack) if left > 0.0 else -1.0
            if root < 0.0:
                if left > 0.0:
                    x = _value(a, 1.0)
                    v = _slope(a, 1.0) / left
                k += 1
                offset = 0.0
                event = s * v <= 0.0
                if event:
                    v = 0.0
                    reversals += 1.0
            else:
                x = _value(a, root)
                v = 0.0
                offset += root * left
                reversals += 1.0
        if k == count:
            k = 0
            periods += 1.0
        if rows < len(record) and not event:
            record[rows, 0] = k * h + periods * 2.0 * math.pi
            record[rows, 1], record[rows, 2], record[rows, 3] = x, v, s
            rows += 1
    if rows < len(record):
        record[rows, 0] = math.inf
    start[0], start[1], start[2] = x, v, k * h + offset
    start[3], start[4], start[5], start[6] = side, reversals, sticks, periods
    return fate


@kernel
def workspace() -> tuple[Any, Any, Any, Any, Any, Any]:
    """Return scratch arrays, matrices from powers to Bernstein coefficients, and what is known of an equation.

    Known are, from orbits followed before: the fate of creeping outwards, and the phase and the ends of an interval of
    amplitudes that traps; below zero where not known.  The last entry is positive while slow creeping is followed.
    """
    size = _ORDER + 2
    weights = np.empty((3 * size, size))  # binomial(i, j) / binomial(n, j), j <= i, for the degrees n that occur
    for less in range(3):
        n = _ORDER - less
        for i in range(n + 1):
            weight = 1.0
            for j in range(i + 1):
                weights[less * size + i, j] = weight
                weight *= (i - j) / max(1.0, float(n - j))
    known = np.empty(KNOWN)
    _set(known, -1.0)
    return np.empty(size), np.empty(size), np.empty(size), weights, np.empty((_HALVINGS + 3, size)), known


@kernel
def _set(values: Any, value: float) -> None:
    """Fill an array; like `numpy.full`, which takes longer to compile than all that is done with it here."""
    for i in range(len(values)):
        values[i] = value


@kernel
def _stuck_at(record: Any, tau: float) -> float:
    """Return A where the recorded motion is stuck at ``tau``, zero where it moves or the record ends before."""
    for i in range(len(record) - 1):
        if not record[i, 0] <= tau:
            break
        if record[i, 3] == 0.0 and record[i + 1, 0] >= tau:
            return float(record[i, 1])
    return 0.0


@kernel
def _trapped(alpha: float, beta: float, c: float, table: Any, start: Any, work: Any) -> bool:
    """Return whether the motion goes on for ever by sticking and slipping, having reached the state in ``start``.

    It is followed for `_WATCHED` periods.  If it is stuck at some phase of each of them, the amplitudes there span an
    interval, and the period's map of that interval is one of a single variable.  The motion is trapped when the map
    takes the interval, grown by its images up to `_GROWN` times, into itself: tried at `_TRIED` points of it.
    """
    turn = 2.0 * math.pi
    outward = beta + abs(alpha)
    inward = abs(alpha) - beta
    whole = np.empty((_WATCHED * (len(table) + 40), 4))
    here = np.empty(8)
    for i in range(6):
        here[i] = start[i]
    here[6] = 0.0
    here[7] = _WATCHED
    run(alpha, beta, c, table, here, len(whole), whole, work)
    phases = 32
    best = -1.0
    phase = 0.0
    low, high = 0.0, 0.0
    for j in range(phases):
        least, most = math.inf, 0.0
        at = turn * j / phases
        row = 0
        for period in range(1, _WATCHED - 1):
            tau = at + turn * period
            while row + 1 < len(whole) and whole[row + 1, 0] < tau:
                row += 1
            size = abs(whole[row, 1]) if whole[row, 3] == 0.0 and whole[row, 0] <= tau else 0.0
            least, most = min(least, size), max(most, size)
        if least > best:
            best, phase, low, high = least, at, least, most
    if low <= 0.0 or (outward * low > 1.0 and outward * high < 1.0 + _SLOW and inward * high <= 1.0):
        return False  # never held, or creeping outwards, which may be too slow to show but has no end
    short = np.empty((3 * (len(table) + 40), 4))
    tried = _FEW
    for _ in range(_GROWN):
        least, most = low, high
        for i in range(tried):
            size = low + (high - low) * i / (tried - 1.0)
            here[0], here[1], here[2], here[6], here[7] = size, 0.0, phase, 0.0, 2.0
            if abs((beta + alpha * math.sin(phase)) * size) > 1.0:
                return False
            if run(alpha, beta, c, table, here, len(short), short, work) == LIMIT:
                after = abs(_stuck_at(short, phase + turn))
                if after == 0.0:
                    return False
                least, most = min(least, after), max(most, after)
        if most - least <= (high - low) * (1.0 + 1e-6) + _ROUNDING * high:
            if tried == _TRIED:
                work[5][1], work[5][2], work[5][3] = phase, low, high
                return True
            tried = _TRIED
        low, high = least, most
    return False


@kernel
def _follow(alpha: float, beta: float, c: float, table: Any, start: Any, most: int, work: Any) -> int:
    """Follow an orbit like `run`, and from time to time see whether it is trapped."""
    none = np.empty((0, 4))
    part = min(most, _WATCHED * len(table))
    fate = LIMIT
    while fate == LIMIT and most > 0:
        fate = run(alpha, beta, c, table, start, part, none, work)
        most -= part
        part = min(most, 8 * part)
        if fate == LIMIT and start[5] > 0.0 and _trapped(alpha, beta, c, table, start, work):
            return TRAPPED
    return fate


@kernel
def judge(
    alpha: float, beta: float, c: float, table: Any, kick: float, most: int, patient: bool, start: Any, work: Any
) -> int:
    """Return the fate of the orbit A(0) = 0, A'(0) = ``kick`` >= 0; `LIMIT` where it cannot be told.

    ``start`` receives what `run` leaves there.  Slow creeping whose end depends on where it began is followed when
    ``patient``, else it is `MIXED`.

    Orbits that creep outwards from where the largest force just frees them go from the relative excess d to
    d + (9/2) Q^2 / abs(alpha) d^2 + ..., so all pass through one step's length beginning at d = `_SLOW`, anywhere in
    it.  Their fate is known where all fates sampled there agree.
    """
    known = work[5]
    _set(start, 0.0)
    start[1] = kick
    start[7] = math.inf
    if kick * kick * (abs(alpha) + abs(beta)) <= 1.0:
        return STUCK  # stops no farther out than where the largest force may act for ever
    fate = _follow(alpha, beta, c, table, start, most, work)
    if fate != SLOW_RELEASE:
        return fate
    outward = beta + abs(alpha)
    quadratic = 4.5 * outward * outward / abs(alpha)
    if known[0] < 0.0:
        known[0] = LIMIT  # should one of the samples come back here
        step = quadratic * _SLOW * _SLOW
        here = np.empty(8)
        escaped, bounded = 0, 0
        for i in range(_SAMPLES):
            _set(here, 0.0)
            here[0] = (1.0 + _SLOW * (1.0 + 1e-9) + 1.2 * step * i / (_SAMPLES - 1.0)) / outward
            here[2] = 1.5 * math.pi if alpha > 0.0 else 0.5 * math.pi
            here[7] = math.inf
            fate = _follow(alpha, beta, c, table, here, most, work)
            escaped += 1 if fate == GROWS else 0
            bounded += 1 if fate < GROWS else 0
            if escaped > 0 and bounded > 0:
                known[0] = MIXED
                break
        if escaped == _SAMPLES:
            known[0] = GROWS
        elif bounded == _SAMPLES:
            known[0] = TRAPPED
    if known[0] == MIXED and patient:
        excess = outward * abs(start[0]) - 1.0
        if (1.0 / excess - 1.0 / _SLOW) / quadratic > most:
            return LIMIT  # more periods than cells are allowed
        known[4] = 1.0
        fate = _follow(alpha, beta, c, table, start, most, work)
        known[4] = -1.0
        return fate
    return int(known[0])


@kernel
def floor_of(alpha: float, beta: float, c: float, work: Any) -> float:
    """Return a kick up to which none escapes: none of these stops first beyond ``safe``, where a stop is kept.

    Up to the first stop A = kick S + F, S and F the motions from A' = 1 without friction and from rest with it; the
    kick g = -F' / S' stops at tau, at A = g S + F.  Both grow with tau until A is ``safe`` (docs/friction.md), and the
    kick that stops there is returned, or that of the time where S' is so steep that g has its limit to rounding.
    """
    if alpha == 0.0 and beta == 0.0:
        return math.inf
    outward = beta + abs(alpha)
    safe = 2.0 / abs(alpha) if alpha != 0.0 else math.inf
    if outward > 0.0:
        safe = min(safe, 1.0 / outward)
    h = 2.0 * math.pi / cell_count(alpha, beta, c)
    p, a, b = work[0], work[1], work[2]
    s0, s1, f0, f1 = 0.0, 1.0, 0.0, 0.0
    best = 1.0 / math.sqrt(abs(alpha) + abs(beta))  # by comparison with the largest force throughout
    k = 0
    while s1 < _STEEP and k * h < _LONGEST_PUSH:
        _series(alpha, beta, c, 0.0, k * h, h, s0, s1 * h, p, a)
        _series(alpha, beta, c, 1.0, k * h, h, f0, f1 * h, p, b)
        s0, s1, f0, f1 = _value(a, 1.0), _slope(a, 1.0) / h, _value(b, 1.0), _slope(b, 1.0) / h
        if s1 * (safe - f0) + s0 * f1 <= 0.0:  # the kick that stops here stops beyond ``safe``: halve down to it
            low, high = 0.0, 1.0
            for _ in range(60):
                x = 0.5 * (low + high)
                slope = _slope(a, x)
                if slope * (safe - _value(b, x)) + _value(a, x) * _slope(b, x) <= 0.0:
                    high = x
                else:
                    low = x
            if low > 0.0:
                best = max(best, -_slope(b, low) / _slope(a, low))
            break
        best = max(best, -f1 / s1)
        k += 1
    return best * (1.0 - _ROUNDED)


@kernel
def prepare_fill(alpha: Any, beta: Any, damping: Any, rate: Any, first: Any, out: Any, tables: Any) -> None:
    """Fill the rows of ``tables`` from ``first`` on with the cells of each equation, ``out`` with `floor_of`."""
    work = workspace()
    for i in range(len(alpha)):
        count = cell_count(alpha[i], beta[i], damping[i])
        prepare(alpha[i], beta[i], damping[i], rate[i], tables[first[i] : first[i] + count], work)
        out[i] = floor_of(alpha[i], beta[i], damping[i], work)


@kernel
def judge_fill(
    row: Any,
    out: Any,
    equation: Any,
    values: Any,
    first: Any,
    known: Any,
    kicks: Any,
    most: int,
    patient: bool,
    tables: Any,
) -> None:
    """Fill ``out`` with fate, time, reversals and sticks of the kicks in each row; NaN is no kick, and left alone.

    A row has an equation, whose alpha, beta and damping are in ``values`` and whose cells begin at ``first`` in
    ``tables``, and remembers in ``known`` what its orbits have shown.
    """
    work = workspace()
    start = np.empty(8)
    for i in range(len(row)):
        r = row[i]
        e = equation[r]
        alpha, beta, c = values[e, 0], values[e, 1], values[e, 2]
        table = tables[first[e] : first[e] + cell_count(alpha, beta, c)]
        for j in range(KNOWN):
            work[5][j] = known[r, j]
        for j in range(kicks.shape[1]):
            if not math.isnan(kicks[r, j]):
                out[i, j, 0] = judge(alpha, beta, c, table, kicks[r, j], most, patient, start, work)
                out[i, j, 1] = start[2] + 2.0 * math.pi * start[6]
                out[i, j, 2], out[i, j, 3] = start[4], start[5]
        for j in range(KNOWN):
            known[r, j] = work[5][j]
