"""Kernels that follow many orbits against friction to their fates, and find those that stick and slip for all time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from floquetrod._util.compilation import kernel
from floquetrod.friction.kernels.records import ORBIT, PERIOD, SAMPLE, Workspace, workspace
from floquetrod.friction.kernels.stick_slip_motion import LIMIT, SLOW, STICK_SLIP, run

_WATCHED = 50  # periods in which sticking and slipping is watched for its range (heuristic)
_PHASES = 32  # of a period at which it is looked for
_TRIED = 25  # amplitudes of that range tried (heuristic)
_FEW = 5  # while it is still growing (heuristic)
_GROWN = 20  # times that range is grown (heuristic)
_ROUNDING = 1e-12  # relative, in amplitudes a period apart (heuristic): what drifts by more is not at rest


@kernel
def _stuck_at(record: Any, tau: float) -> float:
    """Return A where the recorded motion is stuck at ``tau``, zero where it moves or the record ends before."""
    for i in range(len(record) - 1):
        if not record[i]["tau"] <= tau:
            break
        if record[i]["state"] == 0.0 and record[i + 1]["tau"] >= tau:
            return float(record[i]["a"])
    return 0.0


@kernel
def _range_of_sticking(record: Any) -> tuple[float, float, float]:
    """Return the phase at which a motion sticks in each period and closest to escape, the least and the largest abs(A).

    The amplitudes are zero where there is no such phase.
    """
    # ``record`` is a motion over `_WATCHED` periods, sample after sample; at each of `_PHASES` phases of a period,
    # abs(A) where it sticks then, 0 where it moves.  The phase whose least value is largest sticks in all periods,
    # farthest out.
    best = -1.0
    phase = 0.0
    low, high = 0.0, 0.0
    for j in range(_PHASES):
        least, most = math.inf, 0.0
        at = PERIOD * j / _PHASES
        row = 0
        for period in range(1, _WATCHED - 1):
            tau = at + PERIOD * period
            while row + 1 < len(record) and record[row + 1]["tau"] < tau:
                row += 1
            size = abs(record[row]["a"]) if record[row]["state"] == 0.0 and record[row]["tau"] <= tau else 0.0
            least, most = min(least, size), max(most, size)
        if least > best:
            best, phase, low, high = least, at, least, most
    return phase, low, high


@kernel
def _has_invariant_interval(equation: Any, cells: Any, bases: Any, orbit: Any, findings: Any, work: Workspace) -> bool:
    """Return whether the motion continues for all time by sticking and slipping, having reached the state ``orbit``.

    It is followed for `_WATCHED` periods.  If it is stuck at some phase of each of them, the amplitudes there span an
    interval, and the period's map of that interval is one of a single variable.  The motion stays there when the map
    takes the interval, grown by its images up to `_GROWN` times, into itself: tried at `_TRIED` points of it.
    ``findings`` receives it.
    """
    # P takes the amplitude x at which the motion is stuck at a phase to that a period later.  An interval with P([low,
    # high]) inside [low, high] holds the motion for all time (docs/theory/friction.md).  Images of few amplitudes grow
    # the interval; only one that does not grow any more is tried at many.
    alpha, beta = equation["alpha"], equation["beta"]
    outward = beta + abs(alpha)
    inward = abs(alpha) - beta
    one = np.empty(1, ORBIT)[0]
    one["a"], one["velocity"], one["phase"], one["periods"] = orbit["a"], orbit["velocity"], orbit["phase"], 0.0
    one["reversals"] = one["sticks"] = 0.0
    whole = np.empty(_WATCHED * (len(cells) + 40), SAMPLE)
    run(equation, cells, bases, one, float(_WATCHED), len(whole), False, findings, whole, work)
    phase, low, high = _range_of_sticking(whole)
    if low <= 0.0 or (outward * low > 1.0 and outward * high < 1.0 + SLOW and inward * high <= 1.0):
        return False  # never held, or moving outwards, which may be too slow to show but has no end
    short = np.empty(3 * (len(cells) + 40), SAMPLE)
    tried = _FEW
    for _ in range(_GROWN):
        least, most = low, high
        for i in range(tried):
            size = low + (high - low) * i / (tried - 1.0)
            if abs((beta + alpha * math.sin(phase)) * size) > 1.0:
                return False
            one["a"], one["velocity"], one["phase"], one["periods"] = size, 0.0, phase, 0.0
            if run(equation, cells, bases, one, 2.0, len(short), False, findings, short, work) == LIMIT:
                after = abs(_stuck_at(short, phase + PERIOD))
                if after == 0.0:
                    return False
                least, most = min(least, after), max(most, after)
        if most - least <= (high - low) * (1.0 + 1e-6) + _ROUNDING * high:
            if tried == _TRIED:
                findings["invariant_phase"], findings["invariant_low"], findings["invariant_high"] = phase, low, high
                return True
            tried = _TRIED
        low, high = least, most
    return False


@kernel
def follow_fill(
    row: Any,
    orbits: Any,
    equation: Any,
    coefficients: Any,
    first: Any,
    cells: Any,
    bases: Any,
    findings: Any,
    most: int,
    follow_slow: bool,
) -> None:
    """Follow ``orbits``, one row of them for each in ``row``, to their fates, over at most ``most`` cells each.

    An orbit with A' NaN is none, and left alone.  A row has an equation, whose cells begin at ``first`` in ``cells``
    and ``bases``, and its ``findings``.  From time to time it is checked whether an orbit stays in such an interval.
    """
    # Pieces of 1, 8, 64, ... times `_WATCHED` periods: after each, a motion that has stuck is checked for an interval
    # of amplitudes that it never leaves, which costs `_WATCHED` periods more.  Pieces grow so that checks cost a share
    # of the whole; the motion goes on from where the piece ended, in ``orbit``.
    work = workspace()
    none = np.empty(0, SAMPLE)
    for i in range(len(row)):
        r = row[i]
        e = equation[r]
        own_cells = cells[first[e] : first[e + 1]]
        own_bases = bases[first[e] : first[e + 1]]
        for j in range(orbits.shape[1]):
            orbit = orbits[i, j]
            if math.isnan(orbit["velocity"]):
                continue
            left = most
            part = min(left, _WATCHED * len(own_cells))
            fate = LIMIT
            while fate == LIMIT and left > 0:
                fate = run(
                    coefficients[e], own_cells, own_bases, orbit, math.inf, part, follow_slow, findings[r], none, work
                )
                left -= part
                part = min(left, 8 * part)
                if (
                    fate == LIMIT
                    and orbit["sticks"] > 0.0
                    and _has_invariant_interval(coefficients[e], own_cells, own_bases, orbit, findings[r], work)
                ):
                    fate = STICK_SLIP
            orbit["fate"] = fate
