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

from floquetrod._util.compilation import kernel
from floquetrod.kernels.frictional_cell import HALVINGS, TERMS, at_the_end, first_root, series, value

# Why a run ended; what is below LIMIT is final.
NO_GROWTH = 0  # without friction no solution grows
STUCK = 1  # at rest for ever
KEPT = 2  # at rest where energy allows no later stop farther out
TRAPPED = 3  # sticks and slips for ever
GROWS = 4  # the escape test
LIMIT = 5  # the bound on the number of cells was reached
SLOW_RELEASE = 6  # stuck, with a force that frees it by less than `SLOW`: creeps outwards, too slowly to follow

MIXED = 7  # creeps outwards, and such orbits differ in fate: kicks that escape lie arbitrarily close

SLOW = 5e-3  # relative excess of the freeing force below which creeping outwards is not followed (heuristic)
_WATCHED = 50  # periods in which sticking and slipping is watched for its range (heuristic)
_TRIED = 25  # amplitudes of that range tried (heuristic)
_FEW = 5  # while it is still growing (heuristic)
_GROWN = 20  # times that range is grown (heuristic)
_ROUNDING = 1e-12  # relative, in amplitudes a period apart (heuristic): what drifts by more is not at rest

TRAP = 3  # numbers that describe an interval of amplitudes that traps: its phase and its ends; below zero if not known
COLUMNS = 11  # of a table: matrix (4), forcing (2), bounds (3), escape test (2)


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
    basis: Any,
    start: Any,
    most: int,
    creep: bool,
    record: Any,
    trap: Any,
    work: Any,
) -> int:
    """Follow one orbit until its fate is known, over at most ``most`` cells; return why it ended.

    ``start`` holds A, A', the phase in [0, 2 pi), the sign of E once it has escaped, the numbers of reversals and
    sticks and that of whole periods: as they are and then as they become, so that a run can be resumed; then the
    period at which to end.  ``record`` (rows of tau, A, A', state) is filled as far as it reaches; its last row is the
    one whose tau is infinite.  A run with rows to record goes on when its fate is known, but for rest for ever.
    ``creep`` follows slow creeping; ``trap`` is what `_trapped` found; ``work`` is scratch space from `workspace`.
    """
    decide = len(record) == 0
    span = start[7]
    count = len(table)
    h = 2.0 * math.pi / count
    p, a, q, stack = work
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
                for j in range(len(a)):
                    a[j] = x * basis[k, 0, j] + v * basis[k, 1, j] + s * basis[k, 2, j]
                for j in range(len(a) - 1):
                    q[j] = s * (j + 1.0) * a[j + 1]
                root = first_root(q, len(a) - 2, stack)
                if root < 0.0:
                    new = table[k, 0] * x + table[k, 1] * v + s * table[k, 4]
                    v = table[k, 2] * x + table[k, 3] * v + s * table[k, 5]
                    x = new
                    k += 1
                    if s * v <= 0.0:
                        v = 0.0
                        offset = 0.0
                        event = True
                        reversals += 1.0
                else:
                    x = value(a, root)
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
                        if 1.0 < outward * size < 1.0 + SLOW and inward * size <= 1.0 and not creep:
                            fate = SLOW_RELEASE
                            break
                    wait = _wait(tau, size, alpha, beta)
                    if wait == math.inf:
                        fate = STUCK
                        break
                    if decide and trap[1] <= size <= trap[2] and (trap[0] - tau) % (2.0 * math.pi) <= wait:
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
            tau = k * h + offset
            series(alpha * math.sin(tau), alpha * math.cos(tau), beta, c, s, left, x, v * left, p, a)
            first = 0 if v != 0.0 else 1
            if released:
                a[2] = 0.0  # the force is what holds it: exactly, not to rounding
                first = 2
            for j in range(len(a) - 1 - first):
                q[j] = s * (j + 1.0 + first) * a[j + 1 + first]
            root = first_root(q, len(a) - 2 - first, stack) if left > 0.0 else -1.0
            if root < 0.0:
                if left > 0.0:
                    x, v = at_the_end(a)
                    v /= left
                k += 1
                offset = 0.0
                event = s * v <= 0.0
                if event:
                    v = 0.0
                    reversals += 1.0
            else:
                x = value(a, root)
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
def workspace() -> tuple[Any, Any, Any, Any]:
    """Return scratch arrays."""
    return np.empty(TERMS), np.empty(TERMS), np.empty(TERMS), np.empty((HALVINGS + 3, TERMS))


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
def _trapped(alpha: float, beta: float, c: float, table: Any, basis: Any, start: Any, trap: Any, work: Any) -> bool:
    """Return whether the motion goes on for ever by sticking and slipping, having reached the state in ``start``.

    It is followed for `_WATCHED` periods.  If it is stuck at some phase of each of them, the amplitudes there span an
    interval, and the period's map of that interval is one of a single variable.  The motion is trapped when the map
    takes the interval, grown by its images up to `_GROWN` times, into itself: tried at `_TRIED` points of it.  ``trap``
    receives it.
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
    run(alpha, beta, c, table, basis, here, len(whole), False, whole, trap, work)
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
    if low <= 0.0 or (outward * low > 1.0 and outward * high < 1.0 + SLOW and inward * high <= 1.0):
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
            if run(alpha, beta, c, table, basis, here, len(short), False, short, trap, work) == LIMIT:
                after = abs(_stuck_at(short, phase + turn))
                if after == 0.0:
                    return False
                least, most = min(least, after), max(most, after)
        if most - least <= (high - low) * (1.0 + 1e-6) + _ROUNDING * high:
            if tried == _TRIED:
                trap[0], trap[1], trap[2] = phase, low, high
                return True
            tried = _TRIED
        low, high = least, most
    return False


@kernel
def follow_fill(
    row: Any,
    out: Any,
    equation: Any,
    values: Any,
    first: Any,
    traps: Any,
    starts: Any,
    most: int,
    creep: bool,
    tables: Any,
    bases: Any,
) -> None:
    """Fill ``out`` with fate, time, reversals, sticks and A at the end of the starts in each row.

    A start is A, A' and the phase; one with A' NaN is none, and left alone.  A row has an equation, whose alpha, beta
    and damping are in ``values`` and whose cells begin at ``first`` in ``tables`` and ``bases``, and remembers in
    ``traps`` what its orbits have shown.  An orbit is followed like `run` does, over at most ``most`` cells, and from
    time to time it is seen whether it is trapped.
    """
    work = workspace()
    none = np.empty((0, 4))
    start = np.empty(8)
    for i in range(len(row)):
        r = row[i]
        e = equation[r]
        alpha, beta, c = values[e, 0], values[e, 1], values[e, 2]
        table = tables[first[e] : first[e + 1]]
        basis = bases[first[e] : first[e + 1]]
        for j in range(starts.shape[1]):
            if math.isnan(starts[r, j, 1]):
                continue
            for n in range(8):
                start[n] = starts[r, j, n] if n < 3 else 0.0
            start[7] = math.inf
            left = most
            part = min(left, _WATCHED * len(table))
            fate = LIMIT
            while fate == LIMIT and left > 0:
                fate = run(alpha, beta, c, table, basis, start, part, creep, none, traps[r], work)
                left -= part
                part = min(left, 8 * part)
                if fate == LIMIT and start[5] > 0.0 and _trapped(alpha, beta, c, table, basis, start, traps[r], work):
                    fate = TRAPPED
            out[i, j, 0] = fate
            out[i, j, 1] = start[2] + 2.0 * math.pi * start[6]
            out[i, j, 2], out[i, j, 3], out[i, j, 4] = start[4], start[5], start[0]
