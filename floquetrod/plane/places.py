"""Points of a plane judged in batches, and boundaries found between them.

Places are shares (u, v) of the two axes, each from 0 to 1.  What lies beyond them counts as not unstable, so that the
edge of the plane bounds an unstable region like any other boundary; nothing is asked about places beyond.
"""

from __future__ import annotations

import numpy as np

from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.roots import roots
from floquetrod.plane.family import Family
from floquetrod.plane.plane_axes import Axis

_HALVINGS = 60


class OutOfBudget(Exception):
    """More points would have to be judged than are allowed."""


class Plane:
    """Verdicts at points given as shares of two axes, with a count of them."""

    def __init__(self, family: Family, x: Axis, y: Axis, most: int) -> None:
        self.family = family
        self.low = np.array([x.values[0], y.values[0]])
        self.high = np.array([x.values[-1], y.values[-1]])
        self.most = min(most, family.most_judged)
        self.vertex = family.vertex
        self.judged = 0
        self._excess: dict[tuple[float, float], float] = {}  # by place, of signed growth

    def places(self, shares: Floats) -> Floats:
        """Return shares of the axes (n, 2) as places in their units."""
        result: Floats = np.clip(self.low + shares * (self.high - self.low), self.low, self.high)
        return np.where(shares >= 1.0, self.high, result)

    def unstable(self, shares: Floats, *, quick: bool = False) -> tuple[Bools, Floats]:
        """Return where a place is unstable, and by how much its growth exceeds the level (NaN where not known).

        Quickly, what would take long may stay undecided.
        """
        inside = ((shares >= 0.0) & (shares <= 1.0)).all(axis=1)
        unstable, excess = np.zeros(len(shares), dtype=np.bool_), np.full(len(shares), np.nan)
        count = int(inside.sum())
        if count:
            if self.judged + count > self.most:
                raise OutOfBudget
            self.judged += count
            place = self.places(shares[inside])
            if self.family.signed_growth is None:
                verdicts = self.family.verdicts(place[:, 0], place[:, 1], quick=quick)
                unstable[inside] = verdicts.status == 0
                excess[inside] = verdicts.growth - self.family.growth_tolerance
            else:
                excess[inside] = self.family.signed_growth(*place.T) - self.family.growth_tolerance
                unstable[inside] = excess[inside] > 0.0
                self._excess.update(zip(map(tuple, shares[inside].tolist()), excess[inside].tolist(), strict=True))
        return unstable, excess

    def boundary(self, inside: Floats, outside: Floats) -> Floats:
        """Return a place of the boundary on each line from an unstable place to one that is not, (n, 2).

        Where growth is known of stable places too, it is a zero of growth.  Where it is known of unstable ones, it is
        interpolated, inversely so that the boundary may be a root of growth or of its square; the bracket itself is of
        verdicts only.
        """
        if self.family.signed_growth is not None:
            return self._at_edges(self._zeros(inside, outside))
        # A place on line k is inside + t (outside - inside), t from 0 to 1, (n,) of them side by side; low is the
        # largest t known unstable, high the least that is not.  t where growth vanishes is predicted from the last
        # three unstable places (`_extrapolated`); the next place lies off the prediction by as much as that changed
        # since the last, on the side whose end has not moved just now, so that both ends close in.  Where that has
        # failed to halve a bracket twice, it is halved.  It ends when the bracket is shorter than ``vertex`` in the
        # plane.
        span = outside - inside
        length = np.hypot(*span.T)
        low, high = np.zeros(len(span)), np.ones(len(span))
        known_t, known_g = np.full((len(span), 3), np.nan), np.full((len(span), 3), np.nan)
        last = np.full(len(span), np.nan)
        slow = np.zeros(len(span), dtype=np.int64)  # how often running the bracket was not halved
        below = np.zeros(len(span), dtype=np.bool_)  # whether the next place aims at the unstable side of a prediction
        for _ in range(2 * _HALVINGS):
            active = np.flatnonzero((high - low) * length > self.vertex)
            if not active.size:
                break
            width = high[active] - low[active]
            guess = _extrapolated(known_t[active], known_g[active])
            error = np.abs(guess - last[active])
            last[active] = guess
            error = np.where(np.isfinite(error), error, 0.1 * width)
            shift = np.maximum(error, 0.4 * self.vertex / length[active])
            aim = guess + np.where(below[active], -shift, shift)
            middle = low[active] + 0.5 * width
            fit = (aim > low[active]) & (aim < high[active]) & (slow[active] < 2)
            t = np.where(fit, aim, middle)
            unstable, excess = self.unstable(inside[active] + t[:, None] * span[active])
            low[active] = np.where(unstable, t, low[active])
            high[active] = np.where(unstable, high[active], t)
            below[active] = ~unstable
            halved = high[active] - low[active] <= 0.5 * width
            slow[active] = np.where(halved | ~fit, 0, slow[active] + 1)
            new = active[unstable & (excess > 0.0)]
            known_t[new] = np.column_stack([known_t[new, 1:], t[unstable & (excess > 0.0)]])
            known_g[new] = np.column_stack([known_g[new, 1:], excess[unstable & (excess > 0.0)]])
        return self._at_edges(inside + (0.5 * (low + high))[:, None] * span)

    def _zeros(self, inside: Floats, outside: Floats) -> Floats:
        """Return the places of `boundary` as zeros of signed growth."""
        span = outside - inside
        accuracy = 0.5 * self.vertex / np.maximum(np.hypot(*span.T), self.vertex)  # as parts of the lines

        def growth(part: Floats, line: Ints) -> Floats:
            return self.unstable(inside[line] + part[:, None] * span[line])[1]

        ends = np.zeros(len(span)), np.ones(len(span))
        zero = roots(growth, *ends, self._growth(inside), self._growth(outside), accuracy)
        return np.asarray(inside + zero[:, None] * span)

    def _growth(self, shares: Floats) -> Floats:
        """Return signed growth at places, mostly judged before; NaN beyond the plane."""
        places = list(map(tuple, shares.tolist()))
        new = [place for place in places if place not in self._excess]
        if new:
            self.unstable(np.array(new))  # keeps growth, but beyond the plane
        return np.array([self._excess.get(place, np.nan) for place in places])

    def _at_edges(self, shares: Floats) -> Floats:
        """Return places, moved to an edge where they are nearer to it than vertices are accurate."""
        near = (np.abs(shares) < 2.0 * self.vertex, np.abs(shares - 1.0) < 2.0 * self.vertex)
        return np.where(near[0], 0.0, np.where(near[1], 1.0, shares))

    def march(
        self, start: Floats, along: Floats, first: Floats, most: Floats, colour: Bools
    ) -> tuple[Bools, Floats, Floats]:
        """Walk from places of a colour (True: unstable) until it changes, in steps that double.

        Returns whether it changed within ``most``, and the distances of the last two places.
        """
        count = len(start)
        reached, before, now = np.zeros(count, dtype=np.bool_), np.zeros(count), np.minimum(first, most)
        active = np.arange(count)
        while active.size:
            unstable, _ = self.unstable(start[active] + now[active, None] * along[active])
            changed = unstable != colour[active]
            reached[active[changed]] = True
            active = active[~changed & (now[active] < most[active])]
            before[active] = now[active]
            now[active] = np.minimum(2.0 * now[active], most[active])
        return reached, before, now


def between(start: Floats, along: Floats, before: Floats, now: Floats, colour: Bools) -> tuple[Floats, Floats]:
    """Return the unstable and the other end of what `Plane.march` has found, for `Plane.boundary`."""
    first, last = start + before[:, None] * along, start + now[:, None] * along
    unstable = colour[:, None]
    return np.where(unstable, first, last), np.where(unstable, last, first)


def _extrapolated(t: Floats, g: Floats) -> Floats:
    """Return where growth vanishes, t a quadratic in growth by three values, t linear in its square by two, else NaN.

    Of the square: without damping growth is a square root near the boundary.
    """
    t0, t1, t2 = t.T
    g0, g1, g2 = g.T
    with np.errstate(all="ignore"):
        two = t2 - (t2 - t1) * g2**2 / (g2**2 - g1**2)
        d1, d2 = (t1 - t0) / (g1 - g0), (t2 - t1) / (g2 - g1)
        three = t2 - g2 * d2 + g2 * g1 * (d2 - d1) / (g2 - g0)
        result: Floats = np.where(np.isfinite(three), three, two)
    return np.where(np.isfinite(result), result, np.nan)
