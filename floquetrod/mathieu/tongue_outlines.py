"""Outlines of tongues within a window: ranges of lines that they meet, and polygons as fine as an accuracy asks.

The position of a line in a range is given by a share from 0 to 1, whose square it goes with beside a tip: there edges
part like square roots, and are smooth in the share.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.roots import largest, roots
from floquetrod.mathieu.tongue_curves import TongueCurves
from floquetrod.plane.polygons import tidied

_SAMPLES = 33  # lines of a range on which edges are examined, where they may turn back (a choice)
_RIDGES = 9  # lines on which growth is compared with the level (a choice)
_TURNS = 20  # golden sections: to 1e-4 of where they began, growth beside its largest value to 1e-8 (a choice)
_LOOKS = 5  # lines of an outline on which growth is examined first (a choice)
_BESIDE = 1e-3  # share of an outline between its end and a look beside it (a choice)
_SNAP = 1e-12  # of the window, up to which an edge that meets its end is put there
_SAFE = 1.5  # departure of a chord's middle, in units of the accuracy; the middle becomes a vertex, which quarters it
_SUSPECT = 8.0  # the same of the chord divided before: halving a chord divides it by four (a choice)
_DEEPEST = 40  # halvings of a chord at most


class LineRanges(NamedTuple):
    """Lines from ``first`` to ``last`` on which the tongues ``which`` exceed the level, at a tip for the first time."""

    which: Ints
    first: Floats
    last: Floats
    tip_first: Bools
    tip_last: Bools

    def at(self, j: Ints, share: Floats) -> Floats:
        """Return the lines at shares of the ranges ``j``."""
        first, last, begins, ends = self.first[j], self.last[j], self.tip_first[j], self.tip_last[j]
        part = np.where(begins & ends, np.sin(0.5 * np.pi * share) ** 2, share)
        part = np.where(begins & ~ends, share * share, part)
        part = np.where(ends & ~begins, share * (2.0 - share), part)
        return np.where(share <= 0.0, first, np.where(share >= 1.0, last, first + (last - first) * part))


class Outlines(NamedTuple):
    """Polygons: vertices (line, place) one after another, ``size`` of them each; ``growth`` is largest at ``peak``.

    ``which`` are the tongues; growth is the rate in 1/s without damping, ``peak`` (n, 2) a line and a place on it.
    """

    which: Ints
    size: Ints
    line: Floats
    place: Floats
    growth: Floats
    peak: Floats


class _OutlinePieces(NamedTuple):
    """Parts of ranges, from share ``first`` to ``last``, on which each edge is within the window or beyond it.

    ``low`` and ``top`` (n, 2) are the edges at both ends, within the window; ``bends`` (n, 2) says of the lower and of
    the upper whether it is a curve, not the window's own edge.  ``outline`` numbers what hangs together.
    """

    j: Ints
    first: Floats
    last: Floats
    edges: Floats  # (n, 2 edges, 2 ends)
    bends: Bools
    outline: Ints


def outlines(curves: TongueCurves, first: Floats, last: Floats, accuracy: float) -> Outlines:
    """Return the outlines, within the window, of tongues above their level, on lines from ``first`` to ``last``.

    Edges depart from the curves between vertices by at most ``accuracy`` of the window.
    """
    ranges = _ranges(curves, first, last)
    pieces = _pieces(curves, ranges)
    growth, peak = _largest(curves, ranges, pieces)
    vertices = _vertices(curves, ranges, pieces, accuracy)
    which = ranges.which[pieces.j[_begins(pieces.outline)]]
    size, line, place = _polygons(vertices, which.size)
    kept = size >= 3
    chosen = np.repeat(kept, size)
    return Outlines(which[kept], size[kept], line[chosen], place[chosen], np.sqrt(growth[kept]), peak[kept])


def _begins(number: Ints) -> Bools:
    """Return where a new number begins."""
    return np.append(True, number[1:] != number[:-1])[: number.size]


def _ranges(curves: TongueCurves, first: Floats, last: Floats) -> LineRanges:
    """Return on which lines growth exceeds the level anywhere."""
    every = np.arange(first.size)
    never = np.zeros(first.size, dtype=np.bool_)
    if curves.rate == 0.0:
        return LineRanges(every, first, last, never, never)
    level = curves.rate**2
    share = np.linspace(0.0, 1.0, _RIDGES)
    at = first[:, None] + (last - first)[:, None] * share
    at[:, -1] = last
    i = np.repeat(every, _RIDGES)
    ridge = curves.ridge(i, at.ravel()).reshape(at.shape)
    above = ridge > level
    which, cell = np.nonzero(above[:, 1:] != above[:, :-1])
    with np.errstate(invalid="ignore"):
        surplus = np.where(np.isinf(ridge), level, ridge - level)
    tip = roots(
        lambda x, k: curves.ridge(which[k], x) - level,
        at[which, cell],
        at[which, cell + 1],
        surplus[which, cell],
        surplus[which, cell + 1],
    )
    rises = above[which, cell + 1]
    begin = np.concatenate([every[above[:, 0]], which[rises]]), np.concatenate([first[above[:, 0]], tip[rises]])
    end = np.concatenate([which[~rises], every[above[:, -1]]]), np.concatenate([tip[~rises], last[above[:, -1]]])
    tips = np.arange(begin[0].size) >= above[:, 0].sum(), np.arange(end[0].size) < (~rises).sum()
    order = [np.lexsort((place, which)) for which, place in (begin, end)]
    sorted_ends = [array[order[k]] for k, arrays in enumerate((begin, end)) for array in arrays]
    return LineRanges(sorted_ends[0], sorted_ends[1], sorted_ends[3], tips[0][order[0]], tips[1][order[1]])


def _edge(curves: TongueCurves, ranges: LineRanges, j: Ints, share: Floats, top: Bools) -> Floats:
    """Return edges at shares of ranges."""
    return curves.edge(ranges.which[j], ranges.at(j, share), top)


def _edges(curves: TongueCurves, ranges: LineRanges, j: Ints, share: Floats) -> tuple[Floats, Floats]:
    """Return lower and upper edges at shares of ranges."""
    return curves.edges(ranges.which[j], ranges.at(j, share))


def _pieces(curves: TongueCurves, ranges: LineRanges) -> _OutlinePieces:
    """Return the pieces of all non-empty ranges, between places where an edge meets an end of the window."""
    window = curves.window
    j, share = _meetings(curves, ranges)
    every = np.arange(ranges.which.size)
    j, share = np.concatenate([every, every, j]), np.concatenate([0.0 * every, 0.0 * every + 1.0, share])
    order = np.lexsort((share, j))
    j, share = j[order], share[order]
    new = np.append(True, (j[1:] != j[:-1]) | (share[1:] > share[:-1]))[: j.size]
    j, share = j[new], share[new]
    left = np.flatnonzero(j[1:] == j[:-1])
    low, top = _edges(curves, ranges, j[left], 0.5 * (share[left] + share[left + 1]))
    held = (low < window.high) & (top > window.low)
    left, low, top = left[held], low[held], top[held]
    bends = np.column_stack([low > window.low, top < window.high])
    # Ends of pieces that hang together are asked once.
    nodes = np.unique(np.concatenate([left, left + 1]))
    snapped = _snapped(np.stack(_edges(curves, ranges, j[nodes], share[nodes])), window.low, window.high)
    snapped[1] = np.maximum(snapped[0], snapped[1])
    number = np.searchsorted(nodes, np.column_stack([left, left + 1]))
    edges = np.stack([snapped[0][number], snapped[1][number]], axis=1)
    outline = np.cumsum(np.append(True, (left[1:] != left[:-1] + 1) | (j[left][1:] != j[left][:-1]))[: left.size]) - 1
    return _OutlinePieces(j[left], share[left], share[left + 1], edges, bends, outline)


def _snapped(place: Floats, low: float, high: float) -> Floats:
    """Return places within the window, those beside its ends put there."""
    close = _SNAP * (high - low)
    place = np.where(place < low + close, low, place)
    return np.where(place > high - close, high, place)


def _meetings(curves: TongueCurves, ranges: LineRanges) -> tuple[Ints, Floats]:
    """Return (range, share) of all places where an edge meets an end of the window.

    Where edges are monotone, along the frequency without a level, two lines tell; else edges are sampled, and cells
    where a curve may dip across an end and back are searched for its extremum.
    """
    window = curves.window
    monotone = window.over == "frequency" and curves.rate == 0.0
    share = np.linspace(0.0, 1.0, 2 if monotone else _SAMPLES)
    every = np.repeat(np.arange(ranges.which.size), share.size)
    cells: list[tuple[Ints, Floats, Floats, Bools, Floats]] = []  # range, ends, edge, limit
    for top, y in enumerate(_edges(curves, ranges, every, np.tile(share, ranges.which.size))):
        y = y.reshape(-1, share.size)
        for limit in (window.low, window.high):
            distance = y - limit
            j, k = np.nonzero((distance[:, 1:] > 0.0) != (distance[:, :-1] > 0.0))
            cells.append((j, share[k], share[k + 1], np.full(j.size, top == 1), np.full(j.size, limit)))
            if not monotone:
                cells += _dips(curves, ranges, share, distance, top == 1, limit)
    j, low, high, flag, limits = (np.concatenate(parts) for parts in zip(*cells, strict=True))

    def beyond(x: Floats, k: Ints) -> Floats:
        return np.asarray(np.clip(_edge(curves, ranges, j[k], x, flag[k]) - limits[k], -1e300, 1e300))

    number = np.arange(j.size)
    return j, roots(beyond, low, high, beyond(low, number), beyond(high, number))


def _dips(
    curves: TongueCurves, ranges: LineRanges, share: Floats, distance: Floats, top: bool, limit: float
) -> list[tuple[Ints, Floats, Floats, Bools, Floats]]:
    """Return cells in which a curve passes a limit, found between samples that lie on one side of it."""
    finite = np.where(np.isfinite(distance), distance, 0.0)
    bend = np.abs(np.diff(finite, 2, axis=1))
    bend = np.pad(bend, ((0, 0), (1, 1)), mode="edge")
    near = np.minimum(np.abs(distance[:, 1:]), np.abs(distance[:, :-1])) <= np.maximum(bend[:, 1:], bend[:, :-1])
    same = (distance[:, 1:] > 0.0) == (distance[:, :-1] > 0.0)
    j, k = np.nonzero(near & same & (distance[:, 1:] != distance[:, :-1]))
    if not j.size:
        return []
    side = np.where(distance[j, k] > 0.0, 1.0, -1.0)
    flag = np.full(j.size, top)

    def height(x: Floats, some: Ints) -> Floats:
        return np.asarray(-side[some] * (_edge(curves, ranges, j[some], x, flag[some]) - limit))

    place, value = largest(height, share[k], share[k + 1], _TURNS)
    across = value > 0.0
    j, k, place = j[across], k[across], place[across]
    flag, limits = np.full(j.size, top), np.full(j.size, limit)
    return [(j, share[k], place, flag, limits), (j, place, share[k + 1], flag, limits)]


def _largest(curves: TongueCurves, ranges: LineRanges, pieces: _OutlinePieces) -> tuple[Floats, Floats]:
    """Return the square of the largest growth rate of every outline, and the line and the place where it is."""
    window = curves.window
    first = np.flatnonzero(_begins(pieces.outline))
    last = np.append(first[1:], pieces.j.size)[: first.size] - 1
    j, begin, end = pieces.j[first], pieces.first[first], pieces.last[last]

    def on_line(share: Floats, some: Ints) -> tuple[Floats, Floats]:
        low, top = _edges(curves, ranges, j[some], share)
        low, top = np.clip(low, window.low, window.high), np.clip(top, window.low, window.high)
        return curves.summits(ranges.which[j[some]], ranges.at(j[some], share), low, np.maximum(low, top))

    every = np.arange(j.size)
    share = begin[:, None] + (end - begin)[:, None] * np.linspace(0.0, 1.0, _LOOKS)
    share[:, -1] = end
    growth = on_line(share.ravel(), np.repeat(every, _LOOKS))[1].reshape(share.shape)
    k = np.argmax(growth, axis=1)
    best, most = share[every, k], growth[every, k]
    # Mostly it is at an end, where one look beside it tells.
    beside = np.where(k == 0, best + _BESIDE * (end - begin), best - _BESIDE * (end - begin))
    some = np.flatnonzero((k > 0) & (k < _LOOKS - 1) | (on_line(beside, every)[1] > most))
    if some.size:
        low, high = share[some, np.maximum(k[some] - 1, 0)], share[some, np.minimum(k[some] + 1, _LOOKS - 1)]
        place, value = largest(lambda x, i: on_line(x, some[i])[1], low, high, _TURNS)
        better = value > most[some]
        best[some[better]], most[some[better]] = place[better], value[better]
    y, most = on_line(best, every)
    return most, np.column_stack([ranges.at(j, best), y])


def _vertices(
    curves: TongueCurves, ranges: LineRanges, pieces: _OutlinePieces, accuracy: float
) -> tuple[Ints, Bools, Floats, Floats, Floats]:
    """Return outline, edge, share, line and place of all vertices."""
    # Each outline consists of pieces, each between two lines, shares ``first`` and ``last`` of a range, with a lower
    # and an upper edge.  Of a vertex: its outline, whether it is on the upper edge, its share, the line x and the place
    # y there.  First the four corners of all pieces; then chords (xa, ya) - (xb, yb) of bent edges are halved in the
    # share, from a to b: the edge at the middle becomes a vertex in any case, and both halves are divided again where
    # it was off the chord by more than `_SAFE` times the accuracy.  off = |cross product| / length is that distance, x
    # and y in units of the window.  A smooth edge is four times closer to the halves than to the chord.  Arrays hold
    # all chords of one depth.
    window = curves.window
    width, height = window.span[1] - window.span[0], window.high - window.low
    n = pieces.j.size
    number = np.repeat(np.arange(n), 4)
    top = np.tile([False, False, True, True], n)
    end = np.tile([False, True], 2 * n)
    share = np.where(end, pieces.last[number], pieces.first[number])
    place = pieces.edges.reshape(-1)
    line = ranges.at(pieces.j[number], share)
    vertices = [(pieces.outline[number], top, share, line, place)]
    piece, side = np.nonzero(pieces.bends)
    a, b = pieces.first[piece], pieces.last[piece]
    xa, xb = (ranges.at(pieces.j[piece], s) for s in (a, b))
    ya, yb = pieces.edges[piece, side, 0], pieces.edges[piece, side, 1]
    parent = np.full(piece.size, np.inf)  # how far the middle of the chord divided before was off
    for _ in range(_DEEPEST):
        middle = 0.5 * (a + b)
        x = ranges.at(pieces.j[piece], middle)
        y = np.clip(curves.edge(ranges.which[pieces.j[piece]], x, side == 1), window.low, window.high)
        vertices.append((pieces.outline[piece], side == 1, middle, x, y))
        dx, dy = (xb - xa) / width, (yb - ya) / height
        length = np.hypot(dx, dy)
        across = np.abs(dx * (y - ya) / height - dy * (x - xa) / width)
        far = np.hypot((x - xa) / width, (y - ya) / height)
        with np.errstate(divide="ignore", invalid="ignore"):
            off = np.where(length > 0.0, across / length, far)
        # Where a chord's middle lies on it by chance, as beside an inflection, that of the chord before did not.
        go = (off > _SAFE * accuracy) | ((parent > _SUSPECT * accuracy) & (length > accuracy))
        go = np.flatnonzero(go & (middle > a) & (middle < b))
        if not go.size:
            break
        piece, side, parent = np.tile(piece[go], 2), np.tile(side[go], 2), np.tile(off[go], 2)
        a, b = np.concatenate([a[go], middle[go]]), np.concatenate([middle[go], b[go]])
        xa, xb = np.concatenate([xa[go], x[go]]), np.concatenate([x[go], xb[go]])
        ya, yb = np.concatenate([ya[go], y[go]]), np.concatenate([y[go], yb[go]])
    outline, flag, share, line, place = (np.concatenate(parts) for parts in zip(*vertices, strict=True))
    return outline, flag, share, line, place


def _polygons(vertices: tuple[Ints, Bools, Floats, Floats, Floats], count: int) -> tuple[Ints, Floats, Floats]:
    """Return sizes, lines and places of polygons: lower edges forwards, upper ones back."""
    outline, top, share, line, place = vertices
    order = np.lexsort((np.where(top, -share, share), top, outline))
    number, corners = tidied(outline[order], np.column_stack([line, place])[order])
    return np.bincount(number, minlength=count), *corners.T
