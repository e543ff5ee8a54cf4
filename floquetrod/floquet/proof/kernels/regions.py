"""Kernels that prove how the modes of a rod behave under every load and every rod of a box, subdividing it.

What a box is says `floquetrod.floquet.proof.kernels.regions_boxes`; all conclusions are proved, rounding included.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats, Ints
from floquetrod._util.compilation import kernel
from floquetrod.floquet.proof.kernels.regions_boxes import (
    AMPLITUDE,
    BENDING,
    DAMPING,
    FREQUENCY,
    HELD,
    MEAN,
    PUSH,
    SWING,
    mode_box,
    side,
    status_of_mode,
    tail_modes,
)
from floquetrod.floquet.proof.kernels.regions_excess import excess
from floquetrod.floquet.status import STABLE, UNDECIDED, UNSTABLE

DONE, WAITING, FIRST, STABLE_PARTS, UNSTABLE_PARTS, OPEN_PARTS, GROWING_MODE = range(7)
"""Entries of `BoxSearch.counts`."""

_LISTED = 62  # pending modes remembered one by one for each box
_FINEST = 1e-13  # relative width below which a side is not bisected


class BoxSearch(NamedTuple):
    """State of a subdivision, changed by `certify_box`: boxes wait in line, each half as large as the one it came from.

    ``counts``: boxes examined; boxes waiting and where the first of them is; parts proved stable, proved unstable
    (single points found on the way count as parts), given up (too small to be bisected); the mode that grows in the
    unstable example, 0 where there is none.
    """

    boxes: Floats  # (n, 8, 2): still to be examined, in a ring
    pending: Ints  # (n, 1 + listed): how many modes are not proved stable, which; -1, first: too many
    shares: Floats  # (n + 3,): of the volume proved stable, unstable, and given up; then of each box
    counts: Ints  # (7,)
    examples: Floats  # (2, 8, 2): proved stable and proved unstable; NaN where there is none
    last: int  # modes 1 to this are looked at


def box_search(box: Floats, last: int, max_boxes: int) -> BoxSearch:
    """Return the beginning of a subdivision of a box, shape (8, 2), which may come to ``max_boxes`` boxes.

    Its fields are the first arguments of `certify_box`.
    """
    room = max_boxes + 2
    search = BoxSearch(
        np.empty((room, 8, 2)),
        np.empty((room, 1 + min(last, _LISTED)), dtype=np.int64),
        np.empty(room + 3),
        np.empty(7, dtype=np.int64),
        np.empty((2, 8, 2)),
        last,
    )
    search.boxes[0] = box
    start_search(*search)
    return search


@kernel
def start_search(boxes: Any, pending: Any, shares: Any, counts: Any, examples: Any, last: int) -> None:
    """Make the first of ``boxes`` the one to be subdivided."""
    # One box waits, its share of the volume is 1; pending [-1, 1]: all modes from the first on.  No example yet: NaN.
    pending[0, 0] = -1
    pending[0, 1] = 1
    for i in range(3):
        shares[i] = 0.0
    for i in range(2):
        for row in range(8):
            examples[i, row, 0] = math.nan
            examples[i, row, 1] = math.nan
    shares[3] = 1.0
    for i in range(len(counts)):
        counts[i] = 0
    counts[WAITING] = 1


@kernel
def _side_to_bisect(box: Any, mode: int) -> int:
    """Return the row of the box whose width keeps the mode undecided most, -1 where all are too narrow."""
    # The width of each row of the box times the derivative of what decides, kappa = c1 m^4 - c2 m^2 F + Omega^2 or p =
    # c2 m^2 dF, by that row at the middle of the box: bisecting the largest shrinks the enclosure most. Frequency
    # scales both, so it counts with their sizes over omega.  Ends too close to bisect are passed over. Nothing is
    # proved here: any choice is right, and a bad one costs boxes only.
    m2 = float(mode) * float(mode)
    slow = box[FREQUENCY, 0]
    fast = box[FREQUENCY, 1]
    push = 0.5 * (box[PUSH, 0] + box[PUSH, 1]) * m2
    mean = 0.5 * (box[MEAN, 0] + box[MEAN, 1])
    amplitude = 0.5 * (box[AMPLITUDE, 0] + box[AMPLITUDE, 1])
    bending = 0.5 * (box[BENDING, 0] + box[BENDING, 1]) * m2 * m2
    swing = 0.5 * (box[SWING, 0] + box[SWING, 1])
    kappa = bending - push * mean + swing
    best = -1
    widest = 0.0
    for row in range(8):
        low = box[row, 0]
        high = box[row, 1]
        width = high - low
        # Too narrow to have a middle of its own between its ends.
        if not width > _FINEST * max(abs(low), abs(high)):
            continue
        if row == MEAN:
            effect = push * width
        elif row == AMPLITUDE:
            effect = 0.5 * push * width
        elif row == FREQUENCY:
            effect = 2.0 * (abs(kappa) + 0.5 * push * amplitude) * width / (0.5 * (slow + fast))
        elif row == BENDING:
            effect = m2 * m2 * width
        elif row == PUSH:
            effect = m2 * (abs(mean) + 0.5 * amplitude) * width
        elif row == SWING:
            effect = width
        elif row == HELD:
            effect = 0.5 * (box[PUSH, 0] + box[PUSH, 1]) * (abs(mean) + 0.5 * amplitude) * width
        else:
            effect = width * max(abs(low), abs(high)) * 2.0 + width * (slow + fast)
        if not effect <= widest:
            widest = effect
            best = row
    return best


@kernel
def _at(box: Any, along: float, force: float, point: Any) -> None:
    """Fill ``point`` with a point of a box: on the way to the smallest a, and on that to the largest amplitude."""
    # a = 4 kappa / omega^2 falls along 0 to 1 while bending and swing go from their highest to their lowest, and mean
    # force, frequency, c2 and h from their lowest to their highest values; ``force`` moves the amplitude up and damping
    # down, towards growth.
    for row in range(8):
        falls = row in (BENDING, SWING)
        share = 1.0 - along if falls else along
        if row == AMPLITUDE:
            share = force
        elif row == DAMPING:
            share = 1.0 - force
        value = box[row, 0] + share * (box[row, 1] - box[row, 0])
        point[row, 0] = min(max(value, box[row, 0]), box[row, 1])
        point[row, 1] = point[row, 0]


@kernel
def _excess_at(box: Any, mode: int, parity: int, along: float, point: Any) -> float:
    """Return the excess of a mode at `_at`, about, and leave the point in ``point``."""
    _at(box, along, 1.0, point)
    kappa, p = mode_box(point, mode)
    low, high = excess(kappa, p, side(point, FREQUENCY), parity)
    return 0.5 * (low + high) if low > -math.inf and high < math.inf else -math.inf


@kernel
def aim(box: Any, mode: int, point: Any) -> None:
    """Fill ``point`` with the middle of the first tongue of a mode in a box, about, where it grows if it does anywhere.

    Between two tongues of the other parity the excess has one maximum along a: a golden section finds it.
    """
    # A point is a place on the diagonal of the box, 0 to 1, along which sqrt(a) = 2 sqrt(kappa) / omega rises or falls;
    # a tongue of order n lies about sqrt(a) = n.  The bisection of the first loop finds the places where sqrt(a) is n +
    # 0.6 and n - 0.6, between which the excess of that parity has one maximum; the golden section below closes in on
    # it. It only looks for an example of growth, which is then proved by itself: no rounding matters here.
    kappa, _ = mode_box(box, mode)
    low = 2.0 * math.sqrt(max(kappa[0], 0.0)) / box[FREQUENCY, 1]
    high = 2.0 * math.sqrt(max(kappa[1], 0.0)) / box[FREQUENCY, 0]
    order = min(math.ceil(low - 0.2), math.floor(high + 0.2))
    parity = int(order) % 2
    left, right = 0.0, 1.0
    for _ in range(2):
        wanted = order + 0.6 if left == 0.0 else order - 0.6
        below, above = 0.0, 1.0
        for _ in range(12):
            middle = 0.5 * (below + above)
            _at(box, middle, 1.0, point)
            kappa, _ = mode_box(point, mode)
            if 2.0 * math.sqrt(max(kappa[0], 0.0)) > wanted * point[FREQUENCY, 0]:
                below = middle
            else:
                above = middle
        if left == 0.0:
            left = below
        else:
            right = above
    ratio = 0.6180339887498949
    first = right - ratio * (right - left)
    second = left + ratio * (right - left)
    at_first = _excess_at(box, mode, parity, first, point)
    at_second = _excess_at(box, mode, parity, second, point)
    for _ in range(50):
        if at_first >= at_second:
            right, second, at_second = second, first, at_first
            first = right - ratio * (right - left)
            at_first = _excess_at(box, mode, parity, first, point)
        else:
            left, first, at_first = first, second, at_second
            second = left + ratio * (right - left)
            at_second = _excess_at(box, mode, parity, second, point)
    _at(box, first if at_first >= at_second else second, 1.0, point)


@kernel
def _are_stable(box: Any, last: int, tolerance_low: float, tolerance_high: float) -> bool:
    """Return whether modes 1 to ``last`` are proved stable."""
    mode = 1
    while mode <= last and status_of_mode(box, mode, tolerance_low, tolerance_high) == STABLE:
        mode += 1
    return mode > last


@kernel
def _copy(box: Any, boxes: Any, place: int) -> None:
    """Store a box among others."""
    for row in range(8):
        boxes[place, row, 0] = box[row, 0]
        boxes[place, row, 1] = box[row, 1]


@kernel
def certify_box(
    boxes: Any,
    pending: Any,
    shares: Any,
    counts: Any,
    examples: Any,
    last: int,
    tolerance_low: float,
    tolerance_high: float,
    steps: int,
) -> bool:
    """Examine up to ``steps`` boxes of a `BoxSearch`, and return whether it goes on: call again.

    It ends when no box is left, when there is no room for more, or when one has been proved stable and one unstable.
    ``shares``, ``counts`` and ``examples`` then tell the answer: all is stable where no part was proved unstable, given
    up or is waiting, and so on.  "Stable" is said of modes 1 to ``last``; `tail_modes` covers the others.
    """
    # Branch and bound: boxes wait in a ring (``boxes``, from counts[FIRST], counts[WAITING] of them), widest first
    # since halves join at its end.  A box is proved by its modes one by one: one that grows everywhere decides it, all
    # stable decide it, else it is halved along `_side_to_bisect`.  Halves examine only the modes that were open, listed
    # in ``pending``: [number, modes], or [-1, first] where they are too many. ``shares`` add up volumes; now and then a
    # corner or an aimed point is tried as an example, so that "mixed" ends soon.
    room = len(boxes)
    point = np.empty((8, 2))
    for _ in range(steps):
        if counts[WAITING] == 0 or (counts[STABLE_PARTS] > 0 and counts[UNSTABLE_PARTS] > 0):
            return False
        if counts[WAITING] + 2 > room:
            return False
        here = counts[FIRST]
        box = boxes[here]
        listed = pending[here, 0]
        grows = 0
        left = 0
        undecided = 0
        first = pending[here, 1]
        # Modes still open are written over the list while it is read: never ahead of the place read.
        for i in range(listed if listed >= 0 else last - first + 1):
            mode = pending[here, 1 + i] if listed >= 0 else first + i
            status = status_of_mode(box, mode, tolerance_low, tolerance_high)
            if status == UNSTABLE:
                grows = mode
                break
            if status == UNDECIDED:
                left += 1
                if left == 1:
                    undecided = mode
                if left < pending.shape[1]:
                    pending[here, left] = mode
        counts[DONE] += 1
        counts[WAITING] -= 1
        counts[FIRST] = (here + 1) % room
        share = shares[3 + here]
        # Proved: all of the box grows in mode ``grows``, or all of its modes are stable.
        if grows > 0 or left == 0:
            kind = 1 if grows > 0 else 0
            if counts[STABLE_PARTS + kind] == 0:
                _copy(box, examples, kind)
                if grows > 0:
                    counts[GROWING_MODE] = grows
            counts[STABLE_PARTS + kind] += 1
            shares[kind] += share
            continue
        row = _side_to_bisect(box, undecided)
        if row < 0:
            counts[OPEN_PARTS] += 1
            shares[2] += share
            continue
        now_and_then = counts[DONE] & (counts[DONE] - 1) == 0  # 1, 2, 4, 8, ...
        if now_and_then and counts[STABLE_PARTS] == 0:
            for end in range(2):
                _at(box, float(end), 0.0, point)
                if _are_stable(point, last, tolerance_low, tolerance_high):
                    counts[STABLE_PARTS] = 1
                    _copy(point, examples, 0)
                    break
        if now_and_then and counts[UNSTABLE_PARTS] == 0:
            aim(box, undecided, point)
            if status_of_mode(point, undecided, tolerance_low, tolerance_high) == UNSTABLE:
                counts[UNSTABLE_PARTS] = 1
                counts[GROWING_MODE] = undecided
                _copy(point, examples, 1)
        # Both halves join at the end of the ring, with the modes left open and half of the volume.
        middle = 0.5 * (box[row, 0] + box[row, 1])
        for half in range(2):
            there = (counts[FIRST] + counts[WAITING]) % room
            _copy(box, boxes, there)
            boxes[there, row, 1 - half] = middle
            if left < pending.shape[1]:
                pending[there, 0] = left
                for i in range(1, left + 1):
                    pending[there, i] = pending[here, i]
            else:
                pending[there, 0] = -1
                pending[there, 1] = undecided
            shares[3 + there] = 0.5 * share
            counts[WAITING] += 1
    return True


@kernel
def certify_cells(
    mean_low: Any,
    mean_high: Any,
    amplitude_low: Any,
    amplitude_high: Any,
    frequency_low: Any,
    frequency_high: Any,
    out: Any,
    rod: Any,
    tolerance_low: float,
    tolerance_high: float,
    smallest: float,
    most: int,
    max_boxes: int,
) -> None:
    """Fill ``out`` (int8) with the proved status of many boxes of loads, subdividing each into at most ``max_boxes``.

    1: no mode grows faster than the tolerance; 0: one does everywhere; 2: both are proved of parts; -1: undecided.
    ``rod``, shape (5, 2), are the last rows of a box; ``smallest`` and ``most`` as in `tail_modes`.
    """
    # Each cell of a map is a box with the rod's rows in common, proved by the same subdivision as a single one. Arrays
    # are made once for all cells.  "Stable" also needs the modes beyond ``last``, which `tail_modes` bounds. "Unstable"
    # does not: one growing mode is enough.
    room = max_boxes + 2
    boxes = np.empty((room, 8, 2))
    pending = np.empty((room, 1 + _LISTED), dtype=np.int64)
    shares = np.empty(room + 3)
    counts = np.empty(7, dtype=np.int64)
    examples = np.empty((2, 8, 2))
    for i in range(len(out)):
        box = boxes[0]
        box[MEAN, 0] = mean_low[i]
        box[MEAN, 1] = mean_high[i]
        box[AMPLITUDE, 0] = amplitude_low[i]
        box[AMPLITUDE, 1] = amplitude_high[i]
        box[FREQUENCY, 0] = frequency_low[i]
        box[FREQUENCY, 1] = frequency_high[i]
        for row in range(5):
            box[BENDING + row, 0] = rod[row, 0]
            box[BENDING + row, 1] = rod[row, 1]
        last, bound = tail_modes(box, tolerance_low, smallest, most)
        start_search(boxes, pending, shares, counts, examples, last)
        certify_box(boxes, pending, shares, counts, examples, last, tolerance_low, tolerance_high, max_boxes)
        rest = counts[WAITING] + counts[OPEN_PARTS]
        others = bound <= max(tolerance_low, smallest)  # the modes not looked at are stable
        if counts[UNSTABLE_PARTS] > 0 and counts[STABLE_PARTS] > 0 and others:
            out[i] = 2
        elif counts[UNSTABLE_PARTS] == 0 and rest == 0 and others:
            out[i] = 1
        elif counts[STABLE_PARTS] == 0 and rest == 0:
            out[i] = 0
        else:
            out[i] = -1
