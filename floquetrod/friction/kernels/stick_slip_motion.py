"""Kernels for A'' + 2 c A' = (beta + alpha sin tau) A - sign(A'), event by event, with the fate for all time.

By homogeneity gamma = 1 throughout.  A period is divided into equal cells short against every wave.  Between reversals
of A' the equation is linear with the forcing -s, s = sign(A'), so a cell is a 2 x 2 matrix and a vector, made once for
all orbits.  Only a cell that a bound cannot clear of reversals is looked into: the motion in it is one Taylor series,
the sign changes of its Bernstein coefficients tell whether A' has a zero, and bracketed Newton finds the first.

How the fate of an orbit is decided for all time (proofs on the page `theory/friction`; p lies between -P and Q):

*Escape.*  E = A' psi - A (psi' - 2 c psi) obeys E' = -s psi, psi the decaying solution of psi'' - 2 c psi' = p psi.
Where abs(E) exceeds the integral of abs(psi) over all later time, E keeps its sign for good and the motion grows like
the growing Floquet solution.  Every motion that does not stay bounded passes this test at some time.

*Stuck.*  At rest where (abs(alpha) + abs(beta)) abs(A) <= 1: for all time.  *Kept.*  At rest where Q abs(A) <= 1 and
abs(alpha) abs(A) <= 2: the motion never goes farther out again.
"""

from __future__ import annotations

import math
from typing import Any

from floquetrod._util.compilation import kernel
from floquetrod.friction.kernels.cell import at_the_end, first_root, series, value
from floquetrod.friction.kernels.records import PERIOD, Workspace

# Why a run ended; what is below LIMIT is final.
NO_GROWTH = 0  # without friction no solution grows
STUCK = 1  # at rest for all time
ENERGY_BOUND = 2  # at rest where energy allows no later stop farther out
STICK_SLIP = 3  # sticks and slips for all time
GROWS = 4  # the escape test
LIMIT = 5  # the bound on the number of cells, or of periods, was reached
SLOW_RELEASE = 6  # stuck, with a force that frees it by less than `SLOW`: moves outwards, too slowly to follow
MIXED = 7  # moves outwards slowly, and such orbits differ in fate: kicks that escape lie arbitrarily close

SLOW = 5e-3  # relative excess of the freeing force below which motion outwards is not followed (heuristic)


@kernel
def _wait(theta: float, size: float, alpha: float, beta: float) -> float:
    """Return how long a stick at abs(A) = size lasts from phase theta; infinite where it is never freed.

    It is freed where abs(p) rises through 1 / size: where p = beta + alpha sin rises through it, or falls through its
    negative.
    """
    phase = theta if alpha >= 0.0 else theta + math.pi
    best = math.inf
    level = 1.0 / size
    k = (level - beta) / abs(alpha) if alpha != 0.0 else math.inf
    if abs(k) < 1.0:
        best = (math.asin(k) - phase) % PERIOD
    k = -(level + beta) / abs(alpha) if alpha != 0.0 else math.inf
    if abs(k) < 1.0:
        best = min(best, (math.pi - math.asin(k) - phase) % PERIOD)
    return best


@kernel
def _stick(
    alpha: float, beta: float, tau: float, size: float, decide: bool, follow_slow: bool, findings: Any
) -> tuple[int, float]:
    """Return the fate of an orbit that sticks at abs(A) = size from phase tau, `LIMIT` if open, and how long it sticks.

    It is told only where it sticks for all time unless ``decide``.
    """
    # Stuck while |p A| <= 1, p = beta + alpha sin tau between -inward and outward.  Rules from the plainest on: never
    # |p| size > 1, stuck for all time; outward size > 1 and p never below 0, freed and driven outwards; freed so weakly
    # that it moves too slowly to follow; never freed from this phase on; within an interval known to keep what sticks
    # in it.  Else `LIMIT`, and the time until |p| size rises above 1 (`_wait`).
    outward = beta + abs(alpha)
    inward = abs(alpha) - beta
    if size * (abs(alpha) + abs(beta)) <= 1.0:
        return STUCK, math.inf
    if decide and outward * size > 1.0 and inward <= 0.0:
        return GROWS, math.inf
    if decide and 1.0 < outward * size < 1.0 + SLOW and inward * size <= 1.0 and not follow_slow:
        return SLOW_RELEASE, math.inf
    wait = _wait(tau, size, alpha, beta)
    if wait == math.inf:
        return STUCK, wait
    sticks_there = (findings["invariant_phase"] - tau) % PERIOD <= wait
    inside = findings["invariant_low"] <= size <= findings["invariant_high"] and sticks_there
    return STICK_SLIP if decide and inside else LIMIT, wait


@kernel
def _cross(cell: Any, x: float, v: float, s: float) -> tuple[float, float]:
    """Return A and A' at the end of a cell, of a motion that keeps its direction."""
    return cell["m11"] * x + cell["m12"] * v + s * cell["f1"], cell["m21"] * x + cell["m22"] * v + s * cell["f2"]


@kernel
def _note(record: Any, row: int, tau: float, x: float, v: float, state: float) -> int:
    """Write a row of a record, where there is one left, and return the next."""
    if row < len(record):
        sample = record[row]
        sample["tau"], sample["a"], sample["velocity"], sample["state"] = tau, x, v, state
        row += 1
    return row


@kernel
def run(
    equation: Any,
    cells: Any,
    bases: Any,
    orbit: Any,
    end: float,
    most: int,
    follow_slow: bool,
    findings: Any,
    record: Any,
    work: Workspace,
) -> int:
    """Follow one orbit until its fate is known, to the period ``end``, over at most ``most`` cells; return its fate.

    ``orbit`` is advanced, so that a run can be resumed.  ``record`` is filled as far as it reaches; its last row is the
    one whose tau is infinite.  A run with rows to record continues when its fate is known, except at rest for all time.
    ``follow_slow``: follow slow outward motion, too; ``findings`` are those on its equation.
    """
    # A'' = p(tau) A - 2 c A' - s, p = beta + alpha sin tau, s = sign(A'), from cell to cell: k is the cell, offset the
    # time in it, h its length; x and v are A and A'.  In motion a whole cell is (x, v) <- M (x, v) + s f, where |v| (1
    # - change_velocity) > |x| change_a + change_forced proves that A' keeps its sign; else A = x from_a + v
    # from_velocity + s forced is its series in (t - tau) / h, and the first zero of s A' is searched for
    # (`first_root`).  At a zero, an event: v = 0, the motion sticks while |p x| <= 1 (`_stick`), then goes on with s
    # the sign of the force, from inside the cell by a series of its own.  Tests of fate come before each step, since
    # what is decided needs no step: escape in motion, the rest at events.
    alpha, beta, c = float(equation["alpha"]), float(equation["beta"]), float(equation["damping"])
    outward = beta + abs(alpha)  # Q: the largest p
    decide = len(record) == 0
    count = len(cells)
    h = PERIOD / count
    x, v, phase, periods = orbit["a"], orbit["velocity"], orbit["phase"], orbit["periods"]
    reversals, sticks = orbit["reversals"], orbit["sticks"]
    k = min(int(phase / h), count - 1)
    offset = max(0.0, phase - k * h)
    s = 1.0 if v > 0.0 else -1.0
    event = v == 0.0 or offset > 0.0
    rows = _note(record, 0, phase + periods * PERIOD, x, v, s if v != 0.0 else 0.0)
    p, a, rate, pieces = work
    fate = LIMIT
    used = 0
    while used < most and periods < end:
        used += 1
        if not event:
            # A whole cell, entered in motion: nearly always the bound excludes that it comes to a stop.
            cell = cells[k]
            if decide and abs(cell["e1"] * x + cell["e2"] * v) > 1.0 + 1e-13:
                fate = GROWS
                break
            if abs(v) * (1.0 - cell["change_velocity"]) > abs(x) * cell["change_a"] + cell["change_forced"]:
                x, v = _cross(cell, x, v, s)
                k += 1
            else:
                basis = bases[k]
                from_a, from_velocity, forced = basis["from_a"], basis["from_velocity"], basis["forced"]
                for j in range(len(a)):
                    a[j] = x * from_a[j] + v * from_velocity[j] + s * forced[j]
                for j in range(len(a) - 1):
                    rate[j] = s * (j + 1.0) * a[j + 1]
                root = first_root(rate, len(a) - 2, pieces)
                if root < 0.0:
                    x, v = _cross(cell, x, v, s)
                    k += 1
                    event = s * v <= 0.0
                else:
                    x = value(a, root)
                    event = True
                if event:
                    v = 0.0
                    offset = max(0.0, root * h)
                    reversals += 1.0
        else:
            # At a stop: rest for all time, a stick, or motion that reverses at once.
            released = False
            if v == 0.0:
                tau = k * h + offset
                size = abs(x)
                force = (beta + alpha * math.sin(tau)) * x
                never_freed = size * (abs(alpha) + abs(beta)) <= 1.0
                if decide and not never_freed and outward * size <= 1.0 and abs(alpha) * size <= 2.0:
                    fate = ENERGY_BOUND
                    break
                if abs(force) <= 1.0:
                    sticks += 1.0
                    rows = _note(record, rows, tau + periods * PERIOD, x, 0.0, 0.0)
                    fate, wait = _stick(alpha, beta, tau, size, decide, follow_slow, findings)
                    if fate != LIMIT:
                        break
                    tau += wait
                    passed = math.floor(tau / PERIOD)
                    if passed > 0.0:
                        periods += passed
                        tau = max(0.0, tau - passed * PERIOD)
                    k = min(int(tau / h), count - 1)
                    offset = min(h, max(0.0, tau - k * h))
                    force = (beta + alpha * math.sin(k * h + offset)) * x
                    released = True
                s = 1.0 if force > 0.0 else -1.0
                rows = _note(record, rows, k * h + offset + periods * PERIOD, x, 0.0, s)
            # Continue from inside the cell: from rest, or from where the orbit starts.
            # A series from here to the end of the cell, in units of what is left of it.
            left = h - offset
            root = -1.0
            if left > 0.0:
                tau = k * h + offset
                series(alpha * math.sin(tau), alpha * math.cos(tau), beta, c, s, left, x, v * left, p, a)
                # From rest A' has a zero at x = 0, after a release a double one: divided out, so that the next is
                # found.
                zeros = 0 if v != 0.0 else 1  # of A' at the beginning
                if released:
                    a[2] = 0.0  # the force is what holds it: exactly, not to rounding
                    zeros = 2
                for j in range(len(a) - 1 - zeros):
                    rate[j] = s * (j + 1.0 + zeros) * a[j + 1 + zeros]
                root = first_root(rate, len(a) - 2 - zeros, pieces)
                if root < 0.0:
                    x, v = at_the_end(a)
                    v /= left
                else:
                    x = value(a, root)
            if root < 0.0:
                k += 1
                offset = 0.0
                event = s * v <= 0.0
            else:
                offset += root * left
            if event:
                v = 0.0
                reversals += 1.0
        if k == count:
            k = 0
            periods += 1.0
        if not (decide or event):
            rows = _note(record, rows, k * h + periods * PERIOD, x, v, s)
    if rows < len(record):
        record[rows]["tau"] = math.inf
    orbit["a"], orbit["velocity"], orbit["phase"], orbit["periods"] = x, v, k * h + offset, periods
    orbit["reversals"], orbit["sticks"], orbit["fate"] = reversals, sticks, fate
    return fate
