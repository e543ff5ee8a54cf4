"""The axial wave of a tool along a string: reflected by its ends, and damped by friction.

With the velocity v + Re(q exp(i w t)), the vibration P of the compression and Z = A_s sqrt(E rho) = m c,

    dP/ds = -(i w m + 2 m delta + f(V) / V) q,    dq/ds = -i w P / (Z c),    V = abs(q),

upwards; at a tool P falls by its amplitude; where sections of other Z and c meet both are continuous; the lower end is
free, P = 0, and the upper one, which the injector moves steadily, held, q = 0.  f is the first harmonic of Coulomb's
friction, by harmonic balance:

    f(V) = (4 / pi) mu N sqrt(1 - v^2 / V^2)    where V > v, else 0.

It grows with V, so that no more than one wave solves this.  Of a tool with two frequencies, whose phases take all pairs
of values, each wave obeys this equation with the mean of f over the phase of the other wave, whose velocity V' cos is
added to v:

    f_i = 2 mu N dG/dV_i,    G(V_1, V_2) = mean of |v + V_1 cos(phi_1) + V_2 cos(phi_2)|,

which is convex, so that again no more than one pair of waves solves both (a dual-input describing function: Gelb and
Vander Velde, Multiple-Input Describing Functions, 1968, chapter 5).  Each is computed against the other in turns.

Between nodes a wave is a combination of two waves without damping, the basis functions of a Galerkin method, which is
exact without damping; friction acts at the midpoints of the parts of each cell.  The equations of the nodes are solved
by Newton's method.

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
_AGREES = 1e-3, 1e-6  # change of two waves in a turn, over the speed of sliding and over the largest velocity
_TURNS = 2  # between two waves, before the force is marched again
_FAINT = 1e-150  # m/s: its square is no normal number, and friction is linear there
_SOFTER = 1e-1  # rounding of the corner of friction from which it begins again where it has not converged

_X, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_ANGLES = 0.5 * math.pi * (1.0 + _X)
NODES, WEIGHTS = -np.cos(_ANGLES), 0.25 * math.pi * _WEIGHTS * np.sin(_ANGLES)
"""Of means over (-1, 1) of functions with square roots at the ends: those of Gauss and Legendre in acos(-x)."""


class ShakingForce(NamedTuple):
    """A tool's force on a string: amplitude in N; the speed of sliding in m/s, Z in N s/m, and the tool's node."""

    amplitude: float
    speed: float
    impedance: float
    node: int


class Cells(NamedTuple):
    """Cells without friction, of k kinds: of one length in one section, below the tool or above it."""

    kind: Any  # (n,), of each cell
    own: Any  # (k,), force in N s/m at a node, a quarter of a period behind the velocity of the same node
    beside: Any  # (k,), and of the node at the other end
    below: Any  # (k, PARTS), basis function of the node below at the midpoints of parts
    above: Any  # (k, PARTS), of the node above
    loss: Any  # (k,), of a part by the string's own damping, in N s/m


class Balance(NamedTuple):
    """Forces at the nodes of n cells, scratch arrays of Newton's method.

    A change z of a velocity changes a force by a z + b conj(z): rows a and b.
    """

    most: Any  # (PARTS n,), of parts of cells: 4 mu N / pi times their length in N
    other: Any  # (PARTS n,), amplitude of the velocity of the wave of another frequency in m/s, 0 without
    damping: Any  # (PARTS n,), friction over velocity in N s/m
    left: Any  # (PARTS n,), mean friction over that without vibration
    residual: Any  # (n + 1,), sum of the forces at a node in N
    own: Any  # (n + 1, 2), its derivative by the velocity of the same node
    beside: Any  # (n + 1, 2), by the velocity of the next node, which is the next one's by this velocity
    step: Any  # (n + 1,), of Newton's method
    trial: Any  # (n + 1,), velocities after a share of the step


class Wave(NamedTuple):
    """The wave of one frequency."""

    cells: Cells
    tool: ShakingForce
    q: Any  # (n + 1,), complex velocities of the nodes in m/s
    balance: Balance


def empty_balance(size: int) -> Balance:
    """Return the balance of ``size`` cells, all zero."""
    most, other, damping, left = np.zeros((4, PARTS * size))
    residual, step, trial = np.zeros((3, size + 1), complex)
    own, beside = np.zeros((2, size + 1, 2), complex)
    return Balance(most, other, damping, left, residual, own, beside, step, trial)


@kernel
def square(z: Any) -> Any:
    """Return the square of the size of a complex number."""
    return z.real * z.real + z.imag * z.imag


@kernel
def _corner(x: float, soft: float) -> tuple[float, float]:
    """Return the square root of x rounded at 0, where its slope is infinite, and ``wide``: its slope is root / 2 wide.

    x becomes (x + wide) / 2 with wide = hypot(x, 2 soft).
    """
    wide = math.sqrt(x * x + 4.0 * soft * soft)
    return math.sqrt(0.5 * (x + wide) if x > 0.0 else 2.0 * soft * soft / (wide - x)), wide


@kernel
def friction(most: float, speed: float, soft: float, size: float, other: float) -> tuple[float, float]:
    """Return f(V) / V in N s/m and df/dV for V = size, beside a wave of another frequency whose velocity is ``other``.

    The slope is infinite at V = v, and is rounded there.
    """
    if other == 0.0:
        ratio_to_sliding = max(size / speed, 1e-12)
        root, wide = _corner(1.0 - 1.0 / (ratio_to_sliding * ratio_to_sliding), soft)
        ratio = most * root / (ratio_to_sliding * speed)
        return ratio, ratio / (wide * ratio_to_sliding * ratio_to_sliding)
    # The mean over the phase p of the other wave, with v + V' cos p in place of v, piece by piece between the phases at
    # which that is V or -V.
    fast = max(size, 1e-12 * speed)
    begin, end = turning_phases(speed, fast, other)
    total, slopes = 0.0, 0.0
    for low, high in ((0.0, begin), (begin, end), (end, math.pi)):
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        if half > 0.0:
            for k in range(len(NODES)):
                share = (speed + other * math.cos(middle + half * NODES[k])) / fast
                root, wide = _corner(1.0 - share * share, soft)
                total += half * WEIGHTS[k] * root
                slopes += half * WEIGHTS[k] * root * share * share / wide
    most *= 2.0 / (math.pi * fast)
    return most * total, most * slopes


@kernel
def turning_phases(speed: float, size: float, other: float) -> tuple[float, float]:
    """Return the phases p in (0, pi) at which v + V' cos p is V and -V, between which a wave V turns the motion back.

    V is ``size`` and V' ``other``; without such a phase 0 or pi.
    """
    begin = math.acos(min(max((size - speed) / other, -1.0), 1.0))
    return begin, math.acos(min(max((-size - speed) / other, -1.0), 1.0))


@kernel
def friction_share(speed: float, one: float, other: float) -> float:
    """Return mean friction over that without vibration, under waves whose velocities are ``one`` and ``other``.

    (2 / pi) asin(v / V) of one, V > v; of two the mean of this over the phase of the weaker one, whose velocity is
    added to v, from -1 where that is less than -V to 1.
    """
    fast, slow = max(one, other), min(one, other)
    if slow == 0.0:
        return 2.0 / math.pi * math.asin(speed / max(fast, speed))
    begin, end = turning_phases(speed, fast, slow)
    middle, half = 0.5 * (begin + end), 0.5 * (end - begin)
    total = 0.0
    for k in range(len(NODES)):
        share = (speed + slow * math.cos(middle + half * NODES[k])) / fast
        total += WEIGHTS[k] * math.asin(min(max(share, -1.0), 1.0))
    return (begin - (math.pi - end) + 4.0 / math.pi * half * total) / math.pi


@kernel
def friction_shares(speed: float, one: Any, other: Any, out: Any) -> None:
    """Fill in `friction_share` at places."""
    for k in range(len(out)):
        out[k] = friction_share(speed, one[k], other[k])


@kernel
def residuals(cells: Cells, tool: ShakingForce, soft: float, q: Any, balance: Balance) -> tuple[float, float]:
    """Fill in the residuals at the nodes and their derivatives; return the norms of residuals and elastic forces."""
    # Galerkin's equations of node c, with the basis functions N_c and the velocity V = sum N_c q_c:
    #     r_c = sum over cells of K q + sum over their parts p of N_c(p) (f(|V|) / |V| + loss) V(p) - the tool's force,
    # K = -i own on the diagonal and +i beside off it, the exact dynamic stiffness of a cell without damping.
    # f(|V|) V / |V| is not analytic: a change z of a velocity changes it by a z + b conj(z), with (f' = slope)
    # a = (f / |V| + f') / 2, b = (f' - f / |V|) / 2 (V / |V|)^2, the two columns of `own` and of `beside`.
    # One pass from cell to cell, since the friction of a part acts on the two nodes of its cell alone.
    residual, own, beside = balance.residual, balance.own, balance.beside
    size = len(q) - 1
    for c in range(size + 1):
        residual[c], own[c, 0], own[c, 1] = 0.0, 0.0, 0.0
    elastic = 0.0
    for c in range(size):
        kind = cells.kind[c]
        stiff, across = -1j * cells.own[kind], 1j * cells.beside[kind]
        low, high = q[c], q[c + 1]
        residual[c] += stiff * low + across * high
        residual[c + 1] += stiff * high + across * low
        own[c, 0] += stiff
        own[c + 1, 0] += stiff
        beside[c, 0], beside[c, 1] = across, 0.0
        for p in range(PARTS):
            below, above = cells.below[kind, p], cells.above[kind, p]
            moves = below * low + above * high
            fast = math.sqrt(square(moves))
            part = PARTS * c + p
            ratio, slope = friction(balance.most[part], tool.speed, soft, fast, balance.other[part])
            balance.damping[part] = ratio
            ratio += cells.loss[kind]
            curl = 0.5 * (slope + cells.loss[kind] - ratio)
            direction = (1.0 / fast if fast > _FAINT else 0.0) * moves
            turned = curl * direction * direction
            residual[c] += below * ratio * moves
            residual[c + 1] += above * ratio * moves
            own[c, 0] += below * below * (ratio + curl)
            own[c, 1] += below * below * turned
            own[c + 1, 0] += above * above * (ratio + curl)
            own[c + 1, 1] += above * above * turned
            beside[c, 0] += below * above * (ratio + curl)
            beside[c, 1] += below * above * turned
    residual[tool.node] -= tool.amplitude
    off = 0.0
    for c in range(size):
        off += square(residual[c])
        elastic += own[c, 0].imag * own[c, 0].imag * square(q[c])
    return math.sqrt(off), math.sqrt(elastic)


@kernel
def newton_step(balance: Balance, size: int) -> None:
    """Fill in the step of Newton's method, by elimination from node to node; uses up residuals and derivatives.

    It needs no pivots, since damping is positive.  A pair (a, b) stands for z -> a z + b conj(z), whose inverse is
    (conj(a), -b) / (|a|^2 - |b|^2).
    """
    own, beside, residual, step = balance.own, balance.beside, balance.residual, balance.step
    for c in range(size):
        a, b = own[c, 0], own[c, 1]
        inverse = 1.0 / (square(a) - square(b))
        a, b = inverse * a.conjugate(), -inverse * b
        own[c, 0], own[c, 1] = a, b
        d, e = beside[c, 0], beside[c, 1]
        f, g = d * a + e * b.conjugate(), d * b + e * a.conjugate()
        own[c + 1, 0] -= f * d + g * e.conjugate()
        own[c + 1, 1] -= f * e + g * d.conjugate()
        residual[c + 1] -= f * residual[c] + g * residual[c].conjugate()
    step[size] = 0.0
    for c in range(size - 1, -1, -1):
        above = step[c + 1]
        force = residual[c] + beside[c, 0] * above + beside[c, 1] * above.conjugate()
        step[c] = -own[c, 0] * force - own[c, 1] * force.conjugate()


@kernel
def solve_newton(cells: Cells, tool: ShakingForce, soft: float, q: Any, balance: Balance) -> bool:
    """Fill in the wave by Newton's method with halved steps, from the wave in ``q``; return whether it converged."""
    # r(q) = 0 for complex velocities q (n + 1,), the last of them 0.  A step is taken in full if the norm of the
    # residual falls by a share of 1e-4 at least, and else halved until it does (Armijo's rule): the friction has a
    # corner at V = v, where full steps may jump to and fro.  The first turn, with a share of 0, only evaluates the
    # residual and its derivatives.  It ends at a residual small against the tool's force, or against the rounding of
    # the elastic forces that cancel.
    trial, step = balance.trial, balance.step
    size = len(q) - 1
    for c in range(size):
        step[c] = 0.0
    share, before, steps, shrinks = 0.0, math.inf, 0, 0
    while True:
        for c in range(size):
            trial[c] = q[c] + share * step[c]
        off, elastic = residuals(cells, tool, soft, trial, balance)
        if off > (1.0 - 1e-4 * share) * before and shrinks < _SHRINKS:
            share, shrinks = 0.5 * share, shrinks + 1
            continue
        for c in range(size):
            q[c] = trial[c]
        if off <= _CLOSE * tool.amplitude + _ROUNDING * elastic:
            return True
        if steps == _STEPS:
            return False
        newton_step(balance, size)
        share, before, steps, shrinks = 1.0, off, steps + 1, 0


@kernel
def find_wave(cells: Cells, tool: ShakingForce, soft: float, q: Any, balance: Balance) -> bool:
    """Fill in the wave, from a close one or from 0; return whether it converged.

    From 0 it begins against a nearly linear friction, linearised about the wave that leaves the tool.
    """
    # Stages 1 and 3 solve the problem itself; 0 and 2 prepare them.  0, from no wave: friction of a corner at the speed
    # with which a wave leaves the tool, amplitude / Z, rounded fully; 2, after a failure of stage 1: the true corner,
    # rounded more.  Where an old wave is known stage 1 comes first.  ``soft`` is the rounding of the problem itself.
    leaves = max(tool.amplitude / tool.impedance, tool.speed)
    for stage in range(0 if q[tool.node] == 0.0 else 1, 4):
        speed = leaves if stage == 0 else tool.speed
        rounded = 1.0 if stage == 0 else _SOFTER if stage == 2 else soft
        is_solved = solve_newton(
            cells, ShakingForce(tool.amplitude, speed, tool.impedance, tool.node), rounded, q, balance
        )
        if is_solved and stage % 2 == 1:
            return True
    return False


@kernel
def amplitude_at(wave: Wave, c: int, p: int) -> Any:
    """Return the amplitude of the velocity in m/s at the midpoint of part p of cell c."""
    kind = wave.cells.kind[c]
    below, above = wave.cells.below[kind, p], wave.cells.above[kind, p]
    return abs(below * wave.q[c] + above * wave.q[c + 1])


@kernel
def find_waves(waves: Any, soft: float) -> bool:
    """Fill in one wave, or two of different frequencies on the same cells; return whether they have converged."""
    # In turns, each wave against the other.  With the linearised friction A, B, B', D of the two and the elastic forces
    # i S, i S', a turn multiplies errors by (i S + A)^-1 B (i S' + D)^-1 B', whose norm in A and D is 1 at most, since
    # the second derivatives of G are positive.
    if len(waves) == 1:
        return find_wave(waves[0].cells, waves[0].tool, soft, waves[0].q, waves[0].balance)
    is_known = False
    for _ in range(_TURNS):
        moved, largest, is_known = 0.0, 0.0, True
        for w in range(2):
            other = waves[w].balance.other
            for k in range(len(other)):
                fast = amplitude_at(waves[1 - w], k // PARTS, k % PARTS)
                moved, largest = max(moved, abs(fast - other[k])), max(largest, fast)
                other[k] = fast
            is_known &= find_wave(waves[w].cells, waves[w].tool, soft, waves[w].q, waves[w].balance)
        is_known &= moved <= _AGREES[0] * waves[0].tool.speed + _AGREES[1] * largest
    return is_known
