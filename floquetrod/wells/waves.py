"""The axial wave of a tool along strings: reflected by their ends, and damped by friction.

With the velocity v + Re(q exp(i w t)), the vibration P of the compression and Z = A_s sqrt(E rho) = m c,

    dP/ds = -(i w m + 2 m delta + f(V) / V) q,    dq/ds = -i w P / (Z c),    V = abs(q),

upwards; at a tool P falls by its amplitude; the lower end is free, P = 0, and the upper one, which the injector moves
steadily, held, q = 0.  f is the first harmonic of Coulomb's friction, by harmonic balance:

    f(V) = (4 / pi) mu N sqrt(1 - v^2 / V^2)    where V > v, else 0.

It grows with V, so that no more than one wave solves this.  Between nodes the wave is taken as one without damping, as
basis functions of a Galerkin method, which makes it exact without damping, and what friction takes in each cell, by the
midpoints of its parts, is what the tool gives.  All strings are solved at once by Newton's method.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Bools, Complexes, Floats
from floquetrod._util.content import ByContent
from floquetrod.wells.drag import Effort, Shaking

Ints = NDArray[np.intp]

_CLOSE, _ROUNDING = 1e-9, 1e-13  # residual over the force of the tool, and over the largest forces between nodes
_STEPS, _SHRINKS = 60, 30  # of Newton's method at most, and of a step: ten are usual
_SOFTER = 1e-1  # with which it begins again where it has not come to an end
_PARTS = 4  # of a cell, at whose midpoints friction acts
_LEAST = 1e-6  # damping ratio: without friction and damping a resonance is infinite (a choice)


@dataclass(frozen=True, eq=False)
class _Law(ByContent):
    """Friction of parts against a wave: most, 4 mu N / pi times their length in N, and the speed of sliding in m/s.

    Its slope is infinite at V = v, and is rounded there.
    """

    most: Floats
    speed: float
    soft: float

    def at(self, size: Floats) -> tuple[Floats, Floats]:
        """Return f(V) / V in N s/m and df/dV: the square x = 1 - v^2 / V^2 is (x + hypot(x, 2 soft)) / 2 instead."""
        some = np.maximum(size / self.speed, 1e-12)
        x = 1.0 - some**-2.0
        wide = np.sqrt(x * x + 4.0 * self.soft**2)
        root = np.sqrt(np.where(x > 0.0, 0.5 * (x + wide), 2.0 * self.soft**2 / (wide - np.minimum(x, 0.0))))
        return self.most * root / (some * self.speed), self.most * root / (wide * some**3 * self.speed)


class Waves:
    """Waves of tools along strings, whose nodes go from the lower to the upper end, one string after the other.

    Attributes
    ----------
    depth : list of ndarray
        Measured depths of the nodes of each string in m.
    q : list of ndarray
        Their velocities, complex, in m/s.
    """

    def __init__(self, shaking: Shaking, top: float, bottoms: Floats, effort: Effort) -> None:
        """Lay nodes along strings, so many cells to a wave, and to a string."""
        self.shaking, self.soft = shaking, effort.soft
        self.wavenumber = np.broadcast_to(shaking.frequency / shaking.wave_speed, bottoms.shape)
        divided = np.broadcast_to(shaking.divided, bottoms.shape)
        parts = [
            _nodes(top, bottom, bottom - shaking.above_end, longest / effort.cells)
            for bottom, longest in zip(bottoms.tolist(), np.minimum(divided, bottoms - top).tolist(), strict=True)
        ]
        self.depth = [each for each, _ in parts]
        size = np.array([each.size - 1 for each in self.depth])  # the upper end is held: as many cells
        self.first = np.concatenate([[0], np.cumsum(size)])
        self.tool = self.first[:-1] + np.array([tool for _, tool in parts])
        self.of = np.repeat(np.arange(size.size), size)
        self.length = np.concatenate([-np.diff(each) for each in self.depth])
        self.elastic = _Elastic.of(shaking, self.wavenumber[self.of], self.length, self.first)
        self.flat, self.most = np.zeros(self.of.size, complex), np.zeros((_PARTS, self.of.size))

    def feel(self, moving: Ints, ends: Floats, pressed: Floats) -> Bools:
        """Find the waves of some strings, k, against mu N of their pieces between measured depths, (m, k) in N/m.

        Returns whether each has been found.
        """
        for i, each in zip(moving.tolist(), pressed.T, strict=True):
            self.most[:, self.first[i] : self.first[i + 1]] = 4.0 / math.pi * self._dragged(i, ends, each)
        if not self.flat.any():
            self.flat = self._some(np.arange(len(self.depth)), self.soft).beginning()
        left = self._found(moving, self.soft)
        if left.size:
            self._found(left, _SOFTER)
            left = self._found(left, self.soft)
        return ~np.isin(moving, left)

    def _some(self, strings: Ints, soft: float) -> _Some:
        """Return the equations of some strings."""
        nodes = np.flatnonzero(np.isin(self.of, strings))
        first, of = np.searchsorted(self.of[nodes], strings), np.searchsorted(strings, self.of[nodes])
        source = np.zeros(nodes.size, complex)
        source[np.searchsorted(nodes, self.tool[strings])] = self.shaking.amplitude
        law = _Law(self.most[:, nodes], self.shaking.speed, soft)
        return _Some(self.shaking, nodes, first, of, law, self.elastic.some(nodes), source)

    def _found(self, moving: Ints, soft: float) -> Ints:
        """Take steps of Newton's method, and return the strings that have not come to an end."""
        if not moving.size:
            return moving
        some = self._some(moving, soft)
        now = some.at(self.flat[some.nodes])
        for _ in range(_STEPS):
            away = some.is_away(now)
            if not away.all():
                moving = moving[away]
                if not moving.size:
                    break
                some = self._some(moving, soft)
                now = some.at(self.flat[some.nodes])
            now = some.closer(now)
            self.flat[some.nodes] = now.q
        return moving

    @property
    def q(self) -> list[Complexes]:
        """Velocities of the nodes of each string in m/s."""
        return [np.append(each, 0.0) for each in np.split(self.flat, self.first[1:-1])]

    def at(self, depth: Floats, i: int) -> Floats:
        """Return the amplitudes of the velocity in m/s and of the force in N of string i at measured depths, (2, m).

        NaN below its lower end.
        """
        nodes, q, k = self.depth[i], self.q[i], self.wavenumber[i]
        cell = np.clip(np.searchsorted(-nodes, -depth, side="right") - 1, 0, nodes.size - 2)
        up, length = k * (nodes[cell] - depth), k * (nodes[cell] - nodes[cell + 1])
        speed = q[cell] * np.sin(length - up) + q[cell + 1] * np.sin(up)
        force = self.shaking.impedance * (q[cell + 1] * np.cos(up) - q[cell] * np.cos(length - up))
        lower, upper = self._held(i)
        held = 1j * (upper[cell] * up - lower[cell] * (length - up)) / length
        both = np.abs([speed / np.sin(length), force / np.sin(length) + held])
        return np.where(depth <= nodes[0], both, np.nan)

    def _held(self, i: int) -> tuple[Complexes, Complexes]:
        """Return what damping in the cells of string i adds to the forces in N at their lower and upper ends."""
        some = self._some(np.array([i]), self.soft)
        now = some.at(self.flat[some.nodes])
        force = (now.damping + some.elastic.loss) * now.within
        return np.sum(some.elastic.below * force, axis=0), np.sum(some.elastic.above * force, axis=0)

    def left(self, some: Ints, ends: Floats) -> Floats:
        """Return mean friction of some strings, k, over that without vibration, of pieces between measured depths.

        (m, k), integrated over cells by the midpoints of their parts.
        """
        found = np.ones((ends.size - 1, some.size))
        share = self.shaking.left(np.abs(self.elastic.within(self.flat))).mean(axis=0) * self.length
        for j, i in enumerate(some.tolist()):
            nodes = self.depth[i]
            total = np.concatenate([[0.0], np.cumsum(share[self.first[i] : self.first[i + 1]])])[::-1]
            there = np.clip(ends, nodes[-1], nodes[0])
            width = np.diff(there)
            has = width > 0.0
            found[has, j] = -np.diff(np.interp(there, nodes[::-1], total))[has] / width[has]
        return found

    def _dragged(self, i: int, ends: Floats, pressed: Floats) -> Floats:
        """Return mu N times the length of each part of the cells of a string in N, from mu N of pieces in N/m."""
        nodes = self.depth[i]
        total = np.concatenate([[0.0], np.cumsum(pressed * np.diff(ends))])
        edges = nodes[:-1] + np.arange(_PARTS + 1)[:, None] / _PARTS * np.diff(nodes)
        return np.asarray(-np.diff(np.interp(edges, ends, total), axis=0))


class _Elastic(NamedTuple):
    """Strings without friction: the diagonal of the equations of nodes, and what is beside it, 0 where a string ends.

    And whether the node above a cell moves, as it does but at the upper end; the loss in N s/m of parts of cells; and
    the basis functions at their midpoints, (p, n), of the nodes below and above.
    """

    diagonal: Complexes
    beside: Complexes
    moves: Floats
    loss: Floats
    below: Floats
    above: Floats

    @classmethod
    def of(cls, shaking: Shaking, wavenumber: Floats, length: Floats, first: Ints) -> _Elastic:
        """Return that of cells of lengths in m; a string begins with each of ``first`` but the last."""
        phase = wavenumber * length
        parts = (np.arange(_PARTS)[:, None] + 0.5) / _PARTS
        below, above = np.sin(phase * (1.0 - parts)) / np.sin(phase), np.sin(phase * parts) / np.sin(phase)
        moves = np.ones(length.size)
        moves[first[1:] - 1] = 0.0
        z, cotangent = shaking.impedance, 1.0 / np.tan(phase)
        damping = np.maximum(shaking.damping, _LEAST * shaking.wave_speed * wavenumber)
        loss = 2.0 * damping * z / shaking.wave_speed * length / _PARTS
        own, across, other = (loss * np.sum(a * b, axis=0) for a, b in ((below, below), (below, above), (above, above)))
        beside = moves * (1j * z / np.sin(phase) + across)
        both = np.append(0.0, (moves * (other - 1j * z * cotangent))[:-1])
        return cls(own - 1j * z * cotangent + both, beside, moves, loss, below, above)

    def some(self, nodes: Ints) -> _Elastic:
        """Return that of some nodes."""
        parts: Any = (each[..., nodes] for each in self)
        return _Elastic(*parts)

    def within(self, q: Complexes) -> Complexes:
        """Return velocities at the midpoints of the parts of cells, (p, n)."""
        return np.asarray(self.below * q + self.above * (self.moves * np.append(q[1:], 0.0)))

    def at_nodes(self, force: Complexes) -> Complexes:
        """Return forces (n,) at nodes from those at the midpoints, (p, n)."""
        found = np.sum(self.below * force, axis=0)
        found[1:] += (self.moves * np.sum(self.above * force, axis=0))[:-1]
        return np.asarray(found)


class _Now(NamedTuple):
    """Velocities of nodes and parts, friction there and its slope, what is missing at nodes in N, and its norms."""

    q: Complexes
    within: Complexes
    damping: Floats
    slope: Floats
    off: Complexes
    size: Floats


@dataclass(frozen=True, eq=False)
class _Some(ByContent):
    """The equations of the nodes of some strings: what is missing of them, and Newton's steps."""

    shaking: Shaking
    nodes: Ints
    first: Ints
    of: Ints
    law: _Law
    elastic: _Elastic
    source: Complexes

    def beginning(self) -> Complexes:
        """Return waves against a friction that is linear: that of the wave that leaves the tool."""
        from scipy.linalg import solve_banded

        speed = max(self.shaking.amplitude / self.shaking.impedance, self.shaking.speed)
        band = np.zeros((3, self.nodes.size), complex)
        band[1] = self.elastic.diagonal + self.law.most.sum(axis=0) / speed
        band[0, 1:], band[2, :-1] = self.elastic.beside[:-1], self.elastic.beside[:-1]
        return np.asarray(solve_banded((1, 1), band, self.source, overwrite_ab=True, check_finite=False))

    def at(self, q: Complexes) -> _Now:
        """Return all that velocities of nodes in m/s make."""
        within = self.elastic.within(q)
        damping, slope = self.law.at(np.abs(within))
        off = self.elastic.diagonal * q - self.source + self.elastic.at_nodes(damping * within)
        off[:-1] += self.elastic.beside[:-1] * q[1:]
        off[1:] += self.elastic.beside[:-1] * q[:-1]
        return _Now(q, within, damping, slope, off, _norms(off, self.first))

    def is_away(self, now: _Now) -> Bools:
        """Return which strings lack more than rounding does."""
        rounding = _ROUNDING * _norms(self.elastic.diagonal * now.q, self.first)
        return now.size > _CLOSE * self.shaking.amplitude + rounding

    def closer(self, now: _Now) -> _Now:
        """Take a step of Newton's method, of each string as long as it makes less missing."""
        step, share = self.step(now), np.ones(self.first.size)
        for _ in range(_SHRINKS):
            found = self.at(now.q + share[self.of] * step)
            too_far = found.size > (1.0 - 1e-4 * share) * now.size
            if not too_far.any():
                break
            share = np.where(too_far, 0.5 * share, share)
        return found

    def step(self, now: _Now) -> Complexes:
        """Return Newton's step, from equations for real and imaginary parts, one after the other."""
        from scipy.linalg import solve_banded

        way, more = now.within / np.maximum(np.abs(now.within), 1e-300), now.slope - now.damping
        slopes = [now.damping + more * way.real**2, more * way.real * way.imag, now.damping + more * way.imag**2]
        below, above = self.elastic.below, self.elastic.moves * self.elastic.above
        (rr, ri, ii), across, other = (
            [np.sum(a * b * each, axis=0) for each in slopes]
            for a, b in ((below, below), (below, above), (above, above))
        )
        for own, of_below in zip((rr, ri, ii), other, strict=True):
            own[1:] += of_below[:-1]
        band = _band(self.elastic.diagonal, (rr, ri, ii), self.elastic.beside, across)
        parts = solve_banded((3, 3), band, -now.off.view(float), overwrite_ab=True, check_finite=False)
        return np.asarray(parts.view(complex))


def _band(diagonal: Complexes, own: tuple[Floats, Floats, Floats], beside: Complexes, across: list[Floats]) -> Floats:
    """Return the band of equations for real and imaginary parts, element (i, j) in row 3 + i - j.

    From complex ones, to which friction adds real blocks that are symmetric: their elements (0, 0), (0, 1) and (1, 1).
    """
    band = np.zeros((7, 2 * diagonal.size))
    band[3, 0::2], band[3, 1::2] = diagonal.real + own[0], diagonal.real + own[2]
    band[2, 1::2], band[4, 0::2] = own[1] - diagonal.imag, own[1] + diagonal.imag
    rr, ri, ii = (each[:-1] for each in across)
    real, imag = beside.real[:-1], beside.imag[:-1]
    band[1, 2::2], band[5, 0:-2:2] = real + rr, real + rr
    band[1, 3::2], band[5, 1:-2:2] = real + ii, real + ii
    band[0, 3::2], band[4, 1:-1:2] = ri - imag, ri - imag
    band[2, 2::2], band[6, 0:-3:2] = ri + imag, ri + imag
    return band


def _nodes(top: float, bottom: float, tool: float, longest: float) -> tuple[Floats, int]:
    """Return the measured depths of the nodes of a string from its lower end up, and the number of its tool's node.

    ``longest`` is the length of a cell at most.
    """
    below = max(1, math.ceil((bottom - tool) / longest)) if bottom > tool else 0
    above = max(2, math.ceil((tool - top) / longest))
    lower = np.linspace(bottom, tool, below + 1)[:-1]
    return np.concatenate([lower, np.linspace(tool, top, above + 1)]), below


def _norms(values: Complexes, first: Ints) -> Floats:
    """Return the norm of the values of each string."""
    return np.asarray(np.sqrt(np.add.reduceat(values.real**2 + values.imag**2, first)))
