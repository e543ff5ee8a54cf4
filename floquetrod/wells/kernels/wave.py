"""The axial wave of a tool along a string: reflected by its ends, and damped by friction.

With the velocity v + Re(q exp(i w t)), the vibration P of the compression and Z = A_s sqrt(E rho) = m c,

    dP/ds = -(i w m + 2 m delta + f(V) / V) q,    dq/ds = -i w P / (Z c),    V = abs(q),

upwards; at a tool P falls by its amplitude; the lower end is free, P = 0, and the upper one, which the injector moves
steadily, held, q = 0.  f is the first harmonic of Coulomb's friction, by harmonic balance:

    f(V) = (4 / pi) mu N sqrt(1 - v^2 / V^2)    where V > v, else 0.

It grows with V, so that no more than one wave solves this.  Between nodes the wave is taken as one without damping, as
basis functions of a Galerkin method, which makes it exact without damping, and what friction takes in each cell, by the
midpoints of its parts, is what the tool gives.  It is solved by Newton's method.

Nodes go from the lower to the upper end, whose velocity is 0; velocities q are complex, (n + 1,), in m/s.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.compilation import kernel

PARTS = 4  # of a cell, at whose midpoints friction acts

_CLOSE, _ROUNDING = 1e-9, 1e-13  # residual over the force of the tool, and over the largest forces between nodes
_STEPS, _SHRINKS = 60, 30  # of Newton's method at most, and of a step: ten are usual
_SOFTER = 1e-1  # with which it begins again where it has not come to an end


class Tool(NamedTuple):
    """What shakes a string: amplitude of the force in N, speed of sliding in m/s, Z in N s/m, and the tool's node."""

    amplitude: float
    speed: float
    impedance: float
    node: int


class Cells(NamedTuple):
    """Cells without friction, those below the tool and those above it, (2, ...)."""

    own: Any  # (2,), force in N s/m at a node, a quarter of a period behind the velocity of the same node
    beside: Any  # (2,), and of the other
    below: Any  # (2, PARTS), basis function of the node below at the midpoints of parts
    above: Any  # (2, PARTS), of the node above
    loss: Any  # (2,), of a part by the string's own damping, in N s/m


class Balance(NamedTuple):
    """Forces at the nodes of n cells, scratch arrays of Newton's method.

    A change z of a velocity changes a force by a z + b conj(z): rows a and b.
    """

    most: Any  # (PARTS n,), of parts of cells: 4 mu N / pi times their length in N
    damping: Any  # (PARTS n,), friction over velocity in N s/m
    left: Any  # (PARTS n,), mean friction over that without vibration
    missing: Any  # (n + 1,), what is missing of the balance
    own: Any  # (n + 1, 2), how it changes with the velocity of the same node
    beside: Any  # (n + 1, 2), with that of the next one, which changes so with this
    step: Any  # (n + 1,), of Newton's method
    tried: Any  # (n + 1,), the velocities after a part of it


def balance_of(size: int) -> Balance:
    """Return that of so many cells, to be filled in."""
    most, damping, left = np.zeros((3, PARTS * size))
    missing, step, tried = np.zeros((3, size + 1), complex)
    own, beside = np.zeros((2, size + 1, 2), complex)
    return Balance(most, damping, left, missing, own, beside, step, tried)


@kernel
def square(z: Any) -> Any:
    """Return the square of the size of a complex number."""
    return z.real * z.real + z.imag * z.imag


@kernel
def friction(most: float, speed: float, soft: float, size: float) -> tuple[float, float]:
    """Return f(V) / V in N s/m and df/dV for V = size.

    The slope is infinite at V = v, and is rounded there: x = 1 - v^2 / V^2 becomes (x + hypot(x, 2 soft)) / 2.
    """
    some = max(size / speed, 1e-12)
    x = 1.0 - 1.0 / (some * some)
    wide = math.sqrt(x * x + 4.0 * soft * soft)
    root = math.sqrt(0.5 * (x + wide) if x > 0.0 else 2.0 * soft * soft / (wide - x))
    ratio = most * root / (some * speed)
    return ratio, ratio / (wide * some * some)


@kernel
def weigh(cells: Cells, tool: Tool, soft: float, q: Any, balance: Balance) -> tuple[float, float]:
    """Fill in what is missing at nodes and how it changes; return the norms of it and of the elastic forces."""
    missing, own, beside = balance.missing, balance.own, balance.beside
    size = len(q) - 1
    for c in range(size + 1):
        missing[c], own[c, 0], own[c, 1] = 0.0, 0.0, 0.0
    elastic = 0.0
    for c in range(size):
        kind = 0 if c < tool.node else 1
        stiff, across = -1j * cells.own[kind], 1j * cells.beside[kind]
        low, high = q[c], q[c + 1]
        missing[c] += stiff * low + across * high
        missing[c + 1] += stiff * high + across * low
        own[c, 0] += stiff
        own[c + 1, 0] += stiff
        beside[c, 0], beside[c, 1] = across, 0.0
        for p in range(PARTS):
            below, above = cells.below[kind, p], cells.above[kind, p]
            moves = below * low + above * high
            fast = math.sqrt(square(moves))
            ratio, slope = friction(balance.most[PARTS * c + p], tool.speed, soft, fast)
            balance.damping[PARTS * c + p] = ratio
            ratio += cells.loss[kind]
            more = 0.5 * (slope + cells.loss[kind] - ratio)
            way = (1.0 / max(fast, 1e-300)) * moves
            turned = more * way * way
            missing[c] += below * ratio * moves
            missing[c + 1] += above * ratio * moves
            own[c, 0] += below * below * (ratio + more)
            own[c, 1] += below * below * turned
            own[c + 1, 0] += above * above * (ratio + more)
            own[c + 1, 1] += above * above * turned
            beside[c, 0] += below * above * (ratio + more)
            beside[c, 1] += below * above * turned
    missing[tool.node] -= tool.amplitude
    off = 0.0
    for c in range(size):
        off += square(missing[c])
        elastic += own[c, 0].imag * own[c, 0].imag * square(q[c])
    return math.sqrt(off), math.sqrt(elastic)


@kernel
def step_up(balance: Balance, size: int) -> None:
    """Fill in the step of Newton's method; what is missing and how it changes is used up.

    Elimination from node to node needs no pivots: what damps is positive.
    """
    own, beside, missing, step = balance.own, balance.beside, balance.missing, balance.step
    for c in range(size):
        a, b = own[c, 0], own[c, 1]
        one = 1.0 / (square(a) - square(b))
        a, b = one * a.conjugate(), -one * b
        own[c, 0], own[c, 1] = a, b
        d, e = beside[c, 0], beside[c, 1]
        f, g = d * a + e * b.conjugate(), d * b + e * a.conjugate()
        own[c + 1, 0] -= f * d + g * e.conjugate()
        own[c + 1, 1] -= f * e + g * d.conjugate()
        missing[c + 1] -= f * missing[c] + g * missing[c].conjugate()
    step[size] = 0.0
    for c in range(size - 1, -1, -1):
        above = step[c + 1]
        force = missing[c] + beside[c, 0] * above + beside[c, 1] * above.conjugate()
        step[c] = -own[c, 0] * force - own[c, 1] * force.conjugate()


@kernel
def is_found(cells: Cells, tool: Tool, soft: float, q: Any, balance: Balance) -> bool:
    """Find the wave from another by Newton's method, and return whether it is found."""
    tried, step = balance.tried, balance.step
    size = len(q) - 1
    for c in range(size):
        step[c] = 0.0
    share, before, steps, shrinks = 0.0, math.inf, 0, 0
    while True:
        for c in range(size):
            tried[c] = q[c] + share * step[c]
        off, elastic = weigh(cells, tool, soft, tried, balance)
        if off > (1.0 - 1e-4 * share) * before and shrinks < _SHRINKS:
            share, shrinks = 0.5 * share, shrinks + 1
            continue
        for c in range(size):
            q[c] = tried[c]
        if off <= _CLOSE * tool.amplitude + _ROUNDING * elastic:
            return True
        if steps == _STEPS:
            return False
        step_up(balance, size)
        share, before, steps, shrinks = 1.0, off, steps + 1, 0


@kernel
def feel(cells: Cells, tool: Tool, soft: float, q: Any, balance: Balance) -> bool:
    """Find the wave from one that is close, or from 0, and return whether it is found.

    It begins against a friction nearly linear, that of the wave that leaves the tool.
    """
    leaves = max(tool.amplitude / tool.impedance, tool.speed)
    for stage in range(0 if q[tool.node] == 0.0 else 1, 4):
        speed = leaves if stage == 0 else tool.speed
        rounded = 1.0 if stage == 0 else _SOFTER if stage == 2 else soft
        found = is_found(cells, Tool(tool.amplitude, speed, tool.impedance, tool.node), rounded, q, balance)
        if found and stage % 2 == 1:
            return True
    return False
