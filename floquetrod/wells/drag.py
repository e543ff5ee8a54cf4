"""The mean force along a string in a well: its weight, and friction against the wall that it is pressed to.

With the compression F, the weight in fluid w, the inclination phi and the curvatures kappa_n and kappa_b,

    dF/ds = w cos(phi) - mu N,    N = hypot(w sin(phi) + F kappa_n, F kappa_b) + h F^2 R / (4 E I),

downwards along a string that is pushed; pulled, friction changes its sign, and a string that stands has none.  h is 1
where a pushed string has buckled into a helix, else 0.  The string lies on the wall with its weight until F^2 R / (4 E
I) exceeds the first term of N: there it begins to snake, and at twice that, by energy, a helix is possible.

F = S tan(y) with the critical force S of a level hole is integrated for y, from the lower end up.  Where a helix locks
up F becomes infinite, and y passes through pi/2 as smoothly as anywhere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.caching import cached_property
from floquetrod.wells.arcs import Floats, Points, curvatures, turned
from floquetrod.wells.path import WellPath

HELICAL = {"energy": 2.0, "loading": 1.83**2, "alone": 8.0, "always": 0.0}
"""Criteria of a helix by name: F^2 R / (4 E I) over the contact force of the string that lies, from which on one forms.

In a straight well sqrt(2) (Chen, Lin & Cheatham 1990), 1.83 (Wu & Juvkam-Wold 1993) and 2 sqrt(2) (Mitchell 1996) times
the critical force; or wherever the string is compressed.  The first follows by energy in bent wells too
(docs/theory/mean_force.md), the other two are taken to keep their ratio to it.
"""


class Effort(NamedTuple):
    """How finely forces are integrated: relative tolerance, and least number of steps between stations."""

    tolerance: float
    steps: int


FINE, CHECKED, FAST, SOUGHT = Effort(1e-12, 2), Effort(1e-10, 1), Effort(1e-8, 1), Effort(1e-6, 1)
"""Of one string; of what it is compared with, whose error is the difference; of many strings; of a depth sought."""

_NEARLY = 0.5 * math.pi - 1e-13  # y beyond which the force is infinite to rounding
_MOST_CHANGES = 1000  # of shape on a piece: all strings change theirs a few times at most
_LEAST = 1e-3  # cos^2 y below which a wave is not damped any more: it has ended long before (a choice)

MOTIONS = {"pushed": 1.0, "standing": 0.0, "pulled": -1.0}
"""Ways in which a string moves, and the sign of friction upwards."""


@dataclass(frozen=True)
class Pipe:
    """What the mean force needs of a string.

    Attributes
    ----------
    rigidity : float
        E I in N m^2.
    weight : float
        Weight in fluid in N/m.
    clearance : float
        R in m.
    """

    rigidity: float
    weight: float
    clearance: float

    @property
    def scale(self) -> float:
        """S, the critical force in a level hole, in N."""
        return 2.0 * math.sqrt(self.rigidity * self.weight / self.clearance)

    def lying(self, force: Floats, place: Place) -> Floats:
        """Return the contact force in N/m of the string that lies on the wall under a compression in N."""
        bent = self.weight * place.sine + force * place.kappa_n
        return np.asarray(np.hypot(bent, force * place.kappa_b))

    def helix(self, force: Floats) -> Floats:
        """Return what a helix adds to the contact force, F^2 R / (4 E I), in N/m."""
        return np.asarray(np.maximum(force, 0.0) ** 2 * self.clearance / (4.0 * self.rigidity))


class Place(NamedTuple):
    """A well at measured depths: sine and cosine of the inclination, and curvatures in 1/m."""

    sine: Any
    cosine: Any
    kappa_n: Any
    kappa_b: Any

    @classmethod
    def at(cls, points: Points) -> Place:
        """Return a well at points of its arcs."""
        return cls(*points.seen)


@dataclass(frozen=True)
class Friction:
    """Coefficients of friction, each from a measured depth in m to the next."""

    depths: tuple[float, ...]
    values: tuple[float, ...]

    def at(self, depth: NDArray[np.float64]) -> Floats:
        """Return the coefficient at measured depths, that below on a boundary."""
        place = np.searchsorted(self.depths, depth, side="right") - 1
        return np.asarray(self.values)[np.maximum(place, 0)]


@dataclass(frozen=True)
class Shaking:
    """A wave that runs along the string from a tool, and what is left of friction.

    By energy: a wave whose velocity V exceeds the speed v of sliding loses (2 / pi) mu N sqrt(V^2 - v^2) a length, and
    so W = sqrt(V^2 - v^2) falls by 2 mu N / (pi Z) a length, Z = A_s sqrt(E rho); below v it loses nothing.

    Attributes
    ----------
    impedance : float
        Z in N s/m.
    speed : float
        v in m/s.
    source : float
        V in m/s where the wave leaves the tool.
    above_end : float
        Distance of the tool from the lower end of the string in m.
    """

    impedance: float
    speed: float
    source: float
    above_end: float = 0.0

    @property
    def wave(self) -> float:
        """W in m/s at the tool."""
        return math.sqrt(max(self.source**2 - self.speed**2, 0.0))

    def speed_of(self, wave: Floats) -> Floats:
        """Return the amplitude V in m/s for W: from that of sliding on friction takes nothing from a wave."""
        return np.asarray(np.hypot(np.maximum(wave, 0.0), min(self.speed, self.source)))

    def left(self, wave: Floats) -> Floats:
        """Return mean friction over that without vibration, (2 / pi) asin(v / V), for W in m/s."""
        return np.asarray(2.0 / math.pi * np.arctan2(self.speed, np.maximum(wave, 0.0)))


class Strings(NamedTuple):
    """Strings in one well: measured depths of their ends in m, and y and W at the lower one."""

    top: Floats
    bottom: Floats
    y: Floats
    wave: Floats


class States(NamedTuple):
    """Y and W of strings at measured depths, (m, n), NaN where a string is not."""

    depth: Floats
    y: Floats
    wave: Floats


@dataclass(frozen=True)
class Drag:
    """Mean force along strings of one pipe in one well."""

    path: WellPath
    pipe: Pipe
    friction: Friction
    motion: str = "pushed"
    helical: str = "energy"
    shaking: Shaking | None = None

    def force(self, y: Floats) -> Floats:
        """Return the compression in N, infinite from y = pi / 2 on."""
        below = np.minimum(y, _NEARLY)
        return np.where(y > below, math.inf, self.pipe.scale * np.tan(below))

    def y_of(self, force: Floats) -> Floats:
        """Return what stands for a compression in N."""
        return np.asarray(np.arctan(force / self.pipe.scale))

    def is_helix(self, place: Place, y: Floats) -> NDArray[np.bool_]:
        """Return whether strings are wound into a helix."""
        return np.asarray(self.wants_helix(place, y) >= 0.0)

    def up(self, strings: Strings, depths: Floats, effort: Effort, towards: float = -1.0) -> States:
        """Return the states of strings at measured depths in m and all ends, from those at their lower ends.

        W falls upwards with ``towards`` = -1, away from the tool, and grows with +1, towards it.
        """
        ends = np.concatenate([strings.top, strings.bottom])
        wanted = np.unique(np.concatenate([ends, depths]))
        breaks = np.unique(np.concatenate([self.path.stations, self.friction.depths, ends]))
        breaks = breaks[(breaks >= ends.min()) & (breaks <= ends.max())]
        states = np.full((2, strings.y.size, wanted.size), np.nan)
        now = np.array([strings.y, strings.wave])
        states[:, np.arange(strings.y.size), np.searchsorted(wanted, strings.bottom)] = now
        for upper, lower in zip(breaks[-2::-1], breaks[:0:-1], strict=True):
            here = np.flatnonzero((strings.top <= upper) & (strings.bottom >= lower))
            inside = np.flatnonzero((wanted >= upper) & (wanted < lower))
            locked = now[0, here] >= 0.5 * math.pi
            for k in here[locked]:
                states[:, k, inside] = now[:, k, None]
            if not locked.all():
                free = here[~locked]
                piece = _Piece(self, float(lower), float(upper), effort, towards)
                states[:, free[:, None], inside], now[:, free] = piece.along(now[:, free], wanted[inside])
        return States(wanted, states[0].T, states[1].T)

    def wants_helix(self, place: Place, y: Floats) -> Floats:
        """Return what is zero or more where a string is wound into a helix, which only one that is pushed is."""
        if self.motion != "pushed":
            return np.full(y.shape, -1.0)
        sine = np.sin(y)
        return np.asarray(sine * np.abs(sine) * self.pipe.weight - HELICAL[self.helical] * self._lying(place, y))

    def _lying(self, place: Place, y: Floats) -> Floats:
        """Return the contact force of the string that lies times cos^2 y, which is finite where the force is not."""
        sine, cosine, scale = np.sin(y), np.cos(y), self.pipe.scale
        bent = self.pipe.weight * place.sine * cosine + scale * sine * place.kappa_n
        return np.asarray(np.abs(cosine) * np.hypot(bent, scale * sine * place.kappa_b))

    def slopes(self, place: Place, mu: float, state: Floats, is_helix: NDArray[np.bool_], towards: float) -> Floats:
        """Return d/ds of y and W."""
        y, wave = state
        cosine = np.cos(y) ** 2
        contact = self._lying(place, y) + np.where(is_helix, np.sin(y) ** 2 * self.pipe.weight, 0.0)
        left = 1.0 if self.shaking is None else self.shaking.left(wave)
        slope = np.zeros_like(state)
        slope[0] = self.pipe.weight * place.cosine * cosine - MOTIONS[self.motion] * mu * left * contact
        slope[0] /= self.pipe.scale
        if self.shaking is not None:
            pressed = contact / np.maximum(cosine, _LEAST)
            slope[1] = -towards * 2.0 / math.pi * mu * pressed / self.shaking.impedance
        return slope


@dataclass(frozen=True)
class _Piece:
    """A piece of one arc with one coefficient of friction, in measured depths."""

    drag: Drag
    lower: float
    upper: float
    effort: Effort
    towards: float

    def place(self, depth: float) -> Place:
        """Return the well at a measured depth, in floats: what `Points.seen` does at twenty times the cost."""
        below = depth - self._start
        angle = self._kappa * below
        run = math.sin(angle) / self._kappa if angle else below
        level, down, moving = turned(
            math.hypot, *self._phi, math.cos(angle), run, self._kappa * math.sin(angle), *self._bend
        )
        ahead, aside = (level[0] / level[2], level[1] / level[2]) if level[2] else (1.0, 0.0)
        return Place(level[2], down, *curvatures(level[2], down, ahead, aside, moving))

    def places(self, depths: Floats) -> Place:
        """Return the well at measured depths."""
        return Place.at(Points(self.drag.path.arcs, np.full(depths.size, self._arc), depths - self._start))

    @cached_property
    def _arc(self) -> int:
        return int(self.drag.path.arcs.at(self._middle).arc[0])

    @cached_property
    def _start(self) -> float:
        return float(self.drag.path.arcs.start[self._arc])

    @cached_property
    def _kappa(self) -> float:
        return float(self.drag.path.arcs.curvature[self._arc])

    @cached_property
    def _phi(self) -> tuple[float, float]:
        phi = float(self.drag.path.arcs.inclination[self._arc])
        return math.sin(phi), math.cos(phi)

    @cached_property
    def _bend(self) -> tuple[float, float]:
        arcs = self.drag.path.arcs
        return float(arcs.kappa_n[self._arc]), float(arcs.kappa_b[self._arc])

    @property
    def _middle(self) -> Floats:
        return np.array([0.5 * (self.lower + self.upper)])

    def along(self, state: Floats, wanted: Floats) -> tuple[Floats, Floats]:
        """Return states (2, n, m) at measured depths and (2, n) at the upper end, from those at the lower end.

        Strings keep their shape, helix or none, as far as all of them do; there the one that changes it does so.
        """
        found = np.empty((*state.shape, wanted.size))
        lower, is_helix = self.lower, self.drag.is_helix(self.place(self.lower), state[0])
        for _ in range(_MOST_CHANGES):
            solved = self._solved(lower, state, is_helix)
            lower, which = self._first_change(solved, is_helix)
            kept = np.flatnonzero((wanted <= solved.t[0]) & (wanted >= lower))
            if kept.size:
                found[..., kept] = solved.sol(wanted[kept]).reshape(*state.shape, -1)
            if which is None:
                return found, solved.y[:, -1].reshape(state.shape)
            state = solved.sol(lower).reshape(state.shape)
            is_helix[which] = not is_helix[which]
        raise RuntimeError(f"a string at {lower:g} m changes its shape too often")

    def _solved(self, lower: float, state: Floats, is_helix: NDArray[np.bool_]) -> Any:
        """Return the solution from a measured depth up, where strings keep their shape."""
        from scipy.integrate import solve_ivp

        mu = float(self.drag.friction.at(self._middle)[0])
        rtol, steps = self.effort
        step = (self.lower - self.upper) / steps

        def slopes(s: float, flat: Floats) -> Floats:
            return self.drag.slopes(self.place(s), mu, flat.reshape(2, -1), is_helix, self.towards).ravel()

        ends, first = (lower, self.upper), min(step, lower - self.upper)
        options = {"rtol": rtol, "atol": rtol, "first_step": first, "max_step": step, "dense_output": True}
        return solve_ivp(slopes, ends, state.ravel(), "DOP853", **options)

    def _first_change(self, solved: Any, is_helix: NDArray[np.bool_]) -> tuple[float, int | None]:
        """Return where the first string changes its shape, and which; the upper end and None where none does."""
        y = solved.y[: is_helix.size]
        wants = self.drag.wants_helix(self.places(solved.t), y)
        changes = ((wants >= 0.0) != is_helix[:, None]) & (y < 0.5 * math.pi)
        changes[:, 0] = False  # where it has just changed
        if not changes.any():
            return self.upper, None
        step = int(np.argmax(changes.any(axis=0)))
        ends = solved.t[step], solved.t[step - 1]
        return max((self._change(solved.sol, k, ends), k) for k in np.flatnonzero(changes[:, step]).tolist())

    def _change(self, solution: Any, which: int, ends: tuple[float, float]) -> float:
        """Return the measured depth at which a string changes its shape."""
        from scipy.optimize import brentq

        def wants(s: float) -> float:
            return float(self.drag.wants_helix(self.place(s), solution(s)[which : which + 1])[0])

        if wants(ends[0]) * wants(ends[1]) >= 0.0:  # it begins on the very edge
            return ends[1]
        return float(brentq(wants, *ends, xtol=self.effort.tolerance * ends[1], maxiter=1000))
