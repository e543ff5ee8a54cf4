"""Tongues followed from where an outline ends with a wide side to their tips, cross-section by cross-section.

A tongue may be of either colour: an unstable one going out of a region, or a stable one that goes into it.
"""

from __future__ import annotations

import numpy as np

from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.interpolation import lagrange_weights
from floquetrod.plane.places import Plane, between
from floquetrod.plane.region_rings import RegionRings

THINNEST = 10.0
"""Width below which a tongue is not followed, in multiples of the accuracy of vertices."""

_MOST_STEPS = 600  # of one tip (a choice)
_TOUCHING = 1e-6  # share of a step by which it may end before the edge of the plane that it goes to (rounding)
_LOOKS = 16  # parts of a step in which sides in the way are searched for (a choice)
_LONGEST = 0.08  # step along a tongue, as a fraction of the axes (a choice)
_OFFSETS = np.array([-1, 1, -2, 2, -3, 3, -4, 4]) / 3.0  # across a tongue, in widths, where its middle is missed


class _Tongue:
    """The last cross-section of a tongue that is followed, and the middles of those before it."""

    def __init__(self, outline: RegionRings, side: int, unstable: bool) -> None:
        start, end = (place[0] for place in outline.sides(np.array([side])))
        self.side, self.colour = side, unstable
        self.middles = [0.5 * (start + end)]
        self.width = float(np.hypot(*(end - start)))
        self.widths = [self.width]
        self.across = (end - start) / self.width
        right = np.array([self.across[1], -self.across[0]])
        self.ahead = right if unstable else -right
        self.step = self.width
        self.steps = 0
        self.at_edge = self.failed = False

    def aim(self, at: float) -> Floats:
        """Return the middle expected at a distance from the last one: a polynomial of the last four by arc length."""
        if len(self.middles) == 1:
            return np.asarray(self.middles[0] + at * self.ahead)
        recent = np.array(self.middles[-4:])
        return _curve(recent, at, recent)

    def plan(self) -> None:
        """Set where the next cross-section is searched for: its middle, direction and width."""
        here = self.middles[-1]
        place = self.aim(self.step)
        widths = np.array(self.widths[-3:])
        guess = _curve(np.array(self.middles[-3:]), self.step, widths[:, None])[0] if widths.size > 1 else widths[0]
        self.expected = float(np.clip(guess, self.width / 3.0, 2.0 * self.width))
        forward = place - here
        across = np.array([-forward[1], forward[0]]) / np.hypot(*forward)
        corners = np.array([place, place + 0.75 * self.expected * across, place - 0.75 * self.expected * across])
        beyond = ((corners < 0.0) | (corners > 1.0)).any(axis=0) & (forward != 0.0)  # an edge alongside is not met
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(beyond, np.where(forward > 0.0, 1.0 - here, -here) / forward, np.inf)
        axis = int(share.argmin())
        self.at_edge = bool(share[axis] <= 1.0 + 2.0 * self.expected / np.hypot(*forward))
        if self.at_edge:
            place = here + float(share[axis]) * forward
            place[axis] = float(forward[axis] > 0.0)
            across = np.array([float(axis == 1), float(axis == 0)])
        self.target = place
        self.next_across = across if across @ self.across >= 0.0 else -across
        self.distance = float(np.hypot(*(place - here)))

    def retreat(self, share: float = 0.5) -> None:
        """Take a shorter step next."""
        self.step *= share
        self.failed = True

    def is_at_tip(self, accuracy: float) -> bool:
        """Return whether the last step has failed and the next one would be too short to matter."""
        short = 0.5 * accuracy if len(self.middles) > 3 else min(0.5 * accuracy, self.width / 8.0)
        return self.failed and self.step < short


def follow(plane: Plane, outline: RegionRings, sides: Ints, unstable: Bools, accuracy: float) -> int:
    """Follow the tongues that begin at wide sides to their tips, the edge of the plane, or another outline.

    Parameters
    ----------
    unstable : ndarray of bool
        Of each side, whether the tongue is unstable and goes outward, or stable and goes inward.
    accuracy : float
        How far the tip and the middle between two cross-sections may be from where they should, as a fraction of the
        axes.

    Returns
    -------
    Number of tips that were given up before that.
    """
    tongues = [_Tongue(outline, int(side), bool(colour)) for side, colour in zip(sides, unstable, strict=True)]
    for side in sides.tolist():
        outline.done[side] = True
    given_up = 0
    while tongues:
        for tongue in tongues:
            tongue.steps += 1
            tongue.plan()
        hit = _hits(plane, tongues)
        for tongue, place in zip(tongues, hit, strict=True):
            if place is None:
                tongue.retreat()
        some = [(tongue, place) for tongue, place in zip(tongues, hit, strict=True) if place is not None]
        ended = _advance(plane, outline, some, accuracy) if some else set()
        rest = []
        for tongue in tongues:
            if id(tongue) in ended or tongue.is_at_tip(accuracy) or tongue.width < THINNEST * plane.vertex:
                continue
            if tongue.steps > _MOST_STEPS:
                given_up += 1
                continue
            rest.append(tongue)
        # another tongue may have been joined to this one, or have taken its side
        tongues = [tongue for tongue in rest if outline.done[tongue.side]]
    return given_up


def _hits(plane: Plane, tongues: list[_Tongue]) -> list[Floats | None]:
    """Return a place in each tongue near where its middle is expected, None where there is none."""
    colour = np.array([tongue.colour for tongue in tongues])
    places = np.array([tongue.target for tongue in tongues])
    struck = _inside(places) & (plane.unstable(places, quick=True)[0] == colour)
    result: list[Floats | None] = [place if hit else None for place, hit in zip(places, struck, strict=True)]
    missed = np.flatnonzero(~struck)
    if missed.size:
        across = np.array([tongues[i].next_across * tongues[i].expected for i in missed])
        tries = places[missed, None] + _OFFSETS[:, None] * across[:, None]
        verdict, _ = plane.unstable(tries.reshape(-1, 2), quick=True)
        good = (verdict.reshape(missed.size, -1) == colour[missed, None]) & _inside(tries)
        for row, i in enumerate(missed.tolist()):
            if good[row].any():
                result[i] = tries[row, int(good[row].argmax())]
    return result


def _inside(places: Floats) -> Bools:
    return np.asarray(((places >= 0.0) & (places <= 1.0)).all(axis=-1))


def _advance(plane: Plane, outline: RegionRings, some: list[tuple[_Tongue, Floats]], accuracy: float) -> set[int]:
    """Find the cross-sections about places in tongues and append them; return which tongues have come to their end."""
    # One step of all tongues at once, for the plane to evaluate many places in one call.  Place and direction come from
    # the middles before; from there rays to both sides end at walls, the boundary on them (reached, ends, walls (2 k,
    # 2)).  Then tongue by tongue: a wall missing, or a cross-section not joined to the last one through places of the
    # same colour, or the way between bent by more than the accuracy: a shorter step, until the tongue counts as ended.
    # The sag of an arc is as the square of its step, hence the factor sqrt(accuracy / sag).  An open way is appended; a
    # side in the way is joined once the tongue has come close to it.
    across = np.array([tongue.next_across for tongue, _ in some])
    start = np.array([place for _, place in some])
    width = np.array([max(tongue.width, tongue.expected) for tongue, _ in some])
    colour = np.array([tongue.colour for tongue, _ in some])
    along = np.concatenate([-across, across])
    start2, colour2 = np.concatenate([start, start]), np.concatenate([colour, colour])
    width2 = np.concatenate([width, width])
    reached, before, now = plane.march(start2, along, 0.35 * width2, 4.0 * width2, colour2)
    walls = np.full((2 * len(some), 2), np.nan)
    ends = between(start2, along, before, now, colour2)
    walls[reached] = plane.boundary(ends[0][reached], ends[1][reached])
    first, second = walls[: len(some)], walls[len(some) :]
    both = reached[: len(some)] & reached[len(some) :]
    ways = [_halfway(tongue, p, q) for (tongue, _), p, q in zip(some, first, second, strict=True)]
    halfway, sags = np.array([way[0] for way in ways]), [way[1] for way in ways]
    connected = plane.unstable(np.where(both[:, None], halfway, -1.0))[0] == colour
    ended: set[int] = set()
    for k, (tongue, _) in enumerate(some):
        if not outline.done[tongue.side]:
            continue
        if not both[k] or not connected[k]:
            tongue.retreat()
            if tongue.step < tongue.width / 8.0:
                ended.add(id(tongue))
            continue
        middle = 0.5 * (first[k] + second[k])
        sag = sags[k]
        near_edge = tongue.at_edge and tongue.distance < 4.0 * tongue.width
        if sag > accuracy and tongue.step > accuracy and not near_edge:
            tongue.retreat(max(0.2, 0.8 * float(np.sqrt(accuracy / sag))))
            continue
        reach, hit = _met(outline, tongue, middle)
        if tongue.at_edge and (hit < 0 or outline.on_edge(np.array([hit]))[0]):
            _append(outline, tongue, first[k], second[k], done=False)
            if hit >= 0:
                outline.join(tongue.side, hit)
            ended.add(id(tongue))
        elif hit < 0:
            _append(outline, tongue, first[k], second[k], done=True)
            tongue.failed = False
            tongue.step = min(tongue.step * min(2.0, 0.9 * float(np.sqrt(accuracy / max(sag, 1e-300)))), _LONGEST)
        elif reach > max(2.0 * accuracy, 2.0 * tongue.width):
            tongue.step = 0.9 * reach
        else:
            outline.join(tongue.side, hit)
            ended.add(id(tongue))
    return ended


def _met(outline: RegionRings, tongue: _Tongue, middle: Floats) -> tuple[float, int]:
    """Return how far along a tongue, on the way to a new middle, another side is met, and that side; -1 if none."""
    length = float(np.hypot(*(middle - tongue.middles[-1])))
    recent = np.array([*tongue.middles[-3:], middle])
    way = np.array([_curve(recent, -length * share, recent) for share in np.linspace(1.0, 0.0, _LOOKS + 1)])
    along = np.diff(way, axis=0)
    distance, hit = outline.hits(way[:-1], along, np.full(_LOOKS, tongue.side))
    met = np.flatnonzero(distance <= (1.0 + _TOUCHING if tongue.at_edge else 1.0))
    if not met.size:
        return np.inf, -1
    first = int(met[0])
    return length * (first + float(distance[first])) / _LOOKS, int(hit[first])


def _halfway(tongue: _Tongue, first: Floats, second: Floats) -> tuple[Floats, float]:
    """Return the middle of a tongue half-way to a new cross-section, and how far its walls are from straight lines.

    By polynomials of the last cross-sections and the new one.
    """
    middle = 0.5 * (first + second)
    middles = np.array([*tongue.middles[-3:], middle])
    widths = np.array([*tongue.widths[-3:], np.hypot(*(second - first))])[:, None]
    back = -0.5 * float(np.hypot(*(middle - tongue.middles[-1])))
    place, width = _curve(middles, back, middles), _curve(middles, back, widths)[0]
    sag = np.hypot(*(place - 0.5 * (middles[-2] + middle))) + 0.5 * abs(width - widths[-2:].mean())
    return place, float(sag)


def _curve(places: Floats, at: float, values: Floats) -> Floats:
    """Return the polynomial of values at places, by length along the line through them, at a length after its end."""
    s = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))])
    return np.asarray(lagrange_weights(s, float(s[-1]) + at) @ values)


def _append(outline: RegionRings, tongue: _Tongue, first: Floats, second: Floats, done: bool) -> None:
    """Append a cross-section to a tongue; which goes on from its side; its walls need work unless done.

    The first walls always do: they lead from a side that may be wider than the tongue, and nothing tells how they bend.
    """
    node = outline.divide(tongue.side, first, done)
    last = outline.divide(node, second, done)
    if len(tongue.middles) == 1:
        outline.done[[tongue.side, last]] = False
    middle = 0.5 * (first + second)
    tongue.width = float(np.hypot(*(second - first)))
    tongue.widths.append(tongue.width)
    tongue.across = (second - first) / max(tongue.width, 1e-300)
    tongue.middles.append(middle)
    tongue.side = node
