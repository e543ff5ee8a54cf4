"""A string that a tool shakes: its mean force by fixed steps, and its wave, in turns until the force stays.

The wave depends on the contact force along the string, and the force on the friction that the wave leaves.  The force
is marched up by the classical Runge-Kutta method of order 4, a step to each piece.  In a step within which the string
becomes a helix or ceases to be one, or both, it is one for a share of the step, by a parabola: an error of order 2, as
of the wave, and a contact force that follows the force without jumps, without which the turns need not settle.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from floquetrod._util.compilation import kernel
from floquetrod.wells.kernels.tool_wave import PARTS, Wave, amplitude_at, find_waves, friction_share
from floquetrod.wells.kernels.wall_contact import (
    LOCKED,
    MOST_PRESSED,
    SlidingString,
    contact,
    helix_excess,
    lying,
    slope,
)

_LOCKS = 4  # turns in a row with the string locked up, after which it counts as such: the depth may swing without end


class Pieces(NamedTuple):
    """Pieces of a string from its lower end up."""

    up: Any  # (m + 1,), heights of their ends above the lower end along the string in m
    friction: Any  # (m,), coefficients without vibration
    places: Any  # (m, 3, 4), sine and cosine of the inclination, curvatures in 1/m: at lower ends, middles, upper ends
    weight: Any  # (m,), of the string in N/m
    wound: Any  # (m,), of `SlidingString`


class Marched(NamedTuple):
    """Y along m pieces, with slopes, helices and friction."""

    y: Any  # (m + 1,), at their ends
    low: Any  # (m,), -dy/ds at the lower end within each
    high: Any  # (m,), at the upper end
    helix: Any  # (m,), the share of each that is a helix
    pressed: Any  # (m,), mu N in N/m without vibration in the middle, bounded where the string is locked up
    left: Any  # (m,), the share of friction that is left


@kernel
def _string(sliding: SlidingString, pieces: Pieces, i: int) -> SlidingString:
    """Return the string within piece i."""
    return SlidingString(pieces.weight[i], sliding.scale, sliding.sign, sliding.helical, pieces.wound[i])


@kernel
def _touching(sliding: SlidingString, places: Any, i: int, k: int, sine: float, cosine: float) -> Any:
    """Return the contact force of the string that lies at place k of piece i."""
    return lying(sliding, places[i, k, 0], places[i, k, 2], places[i, k, 3], sine, cosine)


@kernel
def _rise(sliding: SlidingString, places: Any, i: int, k: int, mu: float, y: float, helix: float) -> Any:
    """Return -dy/ds."""
    sine, cosine = math.sin(y), math.cos(y)
    touching = contact(sliding, _touching(sliding, places, i, k, sine, cosine), sine, helix)
    return -slope(sliding, places[i, k, 1], mu, cosine, touching)


@kernel
def _wants(sliding: SlidingString, places: Any, i: int, k: int, y: float) -> Any:
    sine, cosine = math.sin(y), math.cos(y)
    return helix_excess(sliding, _touching(sliding, places, i, k, sine, cosine), sine)


@kernel
def _step(
    sliding: SlidingString, places: Any, i: int, length: float, mu: float, y: float, helix: float
) -> tuple[float, float, float]:
    """Return y above a piece, and -dy/ds below and above."""
    # The classical Runge-Kutta method of order 4 for dy/ds' = f(s', y), s' upwards: y + (h / 6) (k1 + 2 k2 + 2 k3 +
    # k4), h = ``length``, with the inclination and curvatures at the lower end, the middle (twice) and the upper end of
    # the piece.
    half = 0.5 * length
    first = _rise(sliding, places, i, 0, mu, y, helix)
    second = _rise(sliding, places, i, 1, mu, y + half * first, helix)
    third = _rise(sliding, places, i, 1, mu, y + half * second, helix)
    fourth = _rise(sliding, places, i, 2, mu, y + length * third, helix)
    return y + half / 3.0 * (first + 2.0 * (second + third) + fourth), first, fourth


@kernel
def positive_share(first: float, middle: float, last: float) -> float:
    """Return the share of an interval in which the parabola through values at its ends and middle is positive."""
    # The parabola first + rise x + bend x^2, x from 0 to 1.  Between its zeros, clipped to [0, 1], its sign is
    # constant: at most three intervals, whose sign their midpoints tell.  Without a zero the middle tells all.
    bend, rise = 2.0 * (first - 2.0 * middle + last), 4.0 * middle - 3.0 * first - last
    square = rise * rise - 4.0 * bend * first
    if square <= 0.0:
        return 1.0 if middle >= 0.0 else 0.0
    # Zeros of first + rise x + bend x^2 without cancellation; a straight line has one of them at infinity.
    half = -0.5 * (rise + math.copysign(math.sqrt(square), rise))
    outer = half / bend if bend != 0.0 else math.inf
    inner = first / half
    low, high = min(max(min(outer, inner), 0.0), 1.0), min(max(max(outer, inner), 0.0), 1.0)
    share = 0.0
    for begin, end in ((0.0, low), (low, high), (high, 1.0)):
        x = 0.5 * (begin + end)
        if first + x * (rise + x * bend) >= 0.0:
            share += end - begin
    return share


@kernel
def march(sliding: SlidingString, pieces: Pieces, marched: Marched) -> float:
    """March a string up from its first y with the friction left by the wave; return the largest change of y.

    Where it is locked up it is so all the way.
    """
    # Upwards, piece by piece: y at the upper end by `_step`, with the friction that the wave leaves, mu left.  The
    # string is a helix where sin y - sqrt(h N / wound) >= 0 (`helix_excess`).  A step is first made as the lower end
    # is; the excess at the lower end, the middle (y from the cubic through both ends with both slopes) and the upper
    # end then tells the share of the piece that is a helix, and where that is another share the step is made once more
    # with it.
    moved, places = 0.0, pieces.places
    for i in range(len(pieces.friction)):
        y, new, low, high, string = marched.y[i], LOCKED, 0.0, 0.0, _string(sliding, pieces, i)
        before = _wants(string, places, i, 0, y)
        helix = 1.0 if before >= 0.0 else 0.0
        if y < LOCKED:
            length, mu = pieces.up[i + 1] - pieces.up[i], pieces.friction[i] * marched.left[i]
            new, low, high = _step(string, places, i, length, mu, y, helix)
            middle = 0.5 * (y + new) + 0.125 * length * (low - high)
            values = before, _wants(string, places, i, 1, middle), _wants(string, places, i, 2, new)
            share = positive_share(*values)
            if share != helix:
                helix = share
                new, low, high = _step(string, places, i, length, mu, y, helix)
            new = min(new, LOCKED)
        moved = max(moved, abs(new - marched.y[i + 1]))
        marched.y[i + 1], marched.low[i], marched.high[i], marched.helix[i] = new, low, high, helix
    return moved


@kernel
def press(sliding: SlidingString, pieces: Pieces, marched: Marched) -> None:
    """Fill in friction mu N in N/m without vibration, in the middle of pieces."""
    # mu N in the middle, where y is (y_i + y_(i+1)) / 2 plus h / 8 times the difference of the slopes (Hermite's
    # cubic), N over cos^2 y, since contact forces are kept times cos^2 y; bounded where the string locks up.
    for i in range(len(pieces.friction)):
        bulge = 0.125 * (pieces.up[i + 1] - pieces.up[i]) * (marched.low[i] - marched.high[i])
        y = min(0.5 * (marched.y[i] + marched.y[i + 1]) + bulge, LOCKED)
        sine, cosine, string = math.sin(y), math.cos(y), _string(sliding, pieces, i)
        touching = _touching(string, pieces.places, i, 1, sine, cosine)
        touching = contact(string, touching, sine, marched.helix[i])
        marched.pressed[i] = pieces.friction[i] * touching / max(cosine * cosine, 1.0 / MOST_PRESSED)


@kernel
def means(edges: Any, values: Any, to: Any, out: Any) -> None:
    """Fill in the means of a step function, constant between edges, between other edges."""
    # Both sets of edges rise from the same lowest to the same highest: one pass, each value times the length it shares.
    last = len(values) - 1
    i = 0
    for k in range(len(out)):
        low, total = to[k], 0.0
        while i < last and edges[i + 1] < to[k + 1]:
            total += values[i] * (edges[i + 1] - low)
            low = edges[i + 1]
            i += 1
        out[k] = (total + values[i] * (to[k + 1] - low)) / (to[k + 1] - to[k])


@kernel
def friction_left(waves: Any, left: Any) -> None:
    """Fill in the mean share of friction left by one wave or two in each part of the cells, as `friction_share`."""
    # A point that slides with v + V cos(phase), V > v, has the mean direction (2 / pi) asin(v / V) over a period: that
    # share of Coulomb's friction resists the mean motion, all of it where V <= v.
    for c in range(len(waves[0].q) - 1):
        for p in range(PARTS):
            other = amplitude_at(waves[-1], c, p) if len(waves) > 1 else 0.0
            left[PARTS * c + p] = friction_share(waves[0].tool.speed, amplitude_at(waves[0], c, p), other)


@kernel
def settle(
    sliding: SlidingString,
    pieces: Pieces,
    waves: tuple[Wave, ...],
    edges: Any,
    soft: float,
    stays: float,
    turns: int,
    marched: Marched,
) -> bool:
    """Fill in the force from its first y, and the waves; return whether all have settled.

    ``waves`` are one or two, of two frequencies, with one array of forces ``most``; ``edges`` are the heights of the
    parts of cells above the lower end in m; y has settled where it moves by less than ``stays`` in a turn.
    ``marched.left`` is the share of friction left before the wave is known.
    """
    # Fixed-point turns between the two halves of the problem, each exact for the other as it was:
    #     y -> mu N in the middle of pieces (`press`) -> 4 mu N ds / pi of the parts of cells (`means`)
    #       -> waves q by Newton's method (`find_waves`) -> share (2 / pi) asin(v / V) of friction (`friction_left`)
    #       -> means over pieces -> y by Runge-Kutta steps (`march`).
    # More wave leaves less friction, and less friction a lower force with less contact: the turns contract, except
    # where the string locks up, which ends them after `_LOCKS` turns in a row.
    most, left, last = waves[0].balance.most, waves[0].balance.left, len(pieces.friction)
    march(sliding, pieces, marched)
    locks = 0
    for _ in range(turns):
        press(sliding, pieces, marched)
        means(pieces.up, marched.pressed, edges, most)
        for k in range(len(most)):
            most[k] *= 4.0 / math.pi * (edges[k + 1] - edges[k])
        is_known = find_waves(waves, soft)
        friction_left(waves, left)
        means(edges, left, pieces.up, marched.left)
        moved = march(sliding, pieces, marched)
        if is_known and moved <= stays:
            return True
        locks = locks + 1 if marched.y[last] >= LOCKED else 0
        if locks == _LOCKS:
            return False
    return False
