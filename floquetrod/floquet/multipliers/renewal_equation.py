"""Growth of second moments of systems with delays under noise, by the renewal equation of the noisy products.

A source of noise acts on the solution through few numbers: with s_i (G_i x + sum_k H_ik x(t - tau_k)) = D_i y_i, the
response of y_j at t to a kick D_i at u being g_ji(t, u), Ito's isometry gives for v_i = E[y_i y_i^T]

    v_j(t) = v_j0(t) + sum_i int g_ji(t, u) v_i(u) g_ji(t, u)^T du.

Its operator keeps matrices positive semidefinite, as does its adjoint on functions w of period T,

    (K w)_i(u) = sum_j int_u^inf exp(-sigma (t - u)) g_ji(t, u)^T w_j(t) g_ji(t, u) dt,

whose spectral radius falls with sigma.  Second moments grow at the sigma where it is 1, or at twice the rate without
noise where it is less for all larger sigma (M. G. Krein and M. A. Rutman, Amer. Math. Soc. Transl. 26 (1950)).

For each of some instants u the responses come from collocation of the periods that begin with the kick: of the first
ones by themselves, of all others in the invariant subspace of the leading multipliers, as a matrix geometric series.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple, Self

import numpy as np
from numpy.polynomial import legendre

from floquetrod._util.arrays import EPS, Floats
from floquetrod.equations import DelayedMoments, DelaySystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.equations.delay_system import moved
from floquetrod.floquet.multipliers import delay_maps, delay_spectra
from floquetrod.floquet.multipliers.delay_maps import rate
from floquetrod.floquet.multipliers.delay_mesh import DelayRows, Mesh, mesh, rule

_PHASE = 12.0  # radians that solutions turn by in a piece, about (a choice)
_TURNS = 8  # waves of solutions, above which those of their moments count on refinement alone (a choice)
_LEADING = 0.2  # times the largest modulus: multipliers above it make the subspace of late periods (a choice)
_EARLY = 400  # most periods by themselves
_LEFT_OUT = 1e-15  # share of a state beside the subspace with which the late periods begin
_NEARLY = 1e-9  # share with which they do where it falls no more, by the rounding of the subspace
_SMALLEST = -60.0  # logarithm of a factor of moments over a period, below which growth is not resolved
_LARGEST = 600.0
_RESOLVED = 0.02  # rounding of a logarithm above which it is an upper bound alone (a choice)
_BESIDE = 1e-3  # of a logarithm, the first interval of the search (a choice)
_DOUBLINGS = 60  # of a geometric series
_SINGULAR = 1e-14  # singular values of a source's matrix, relative, that are zero
_MOST_ROWS = 600  # of one instant (a choice: a tenth of a second each)
_MOST_WORK = 3e8  # cubes of rows, of all instants (a choice: some ten seconds)
_MOST_UNKNOWNS = 600  # of the operator: instants times pairs (a choice: a second)
_COUNTS = (8, 11, 15, 20, 26, 34, 44)  # nodes in a piece, tried in turn (a choice)
_UNCHANGED = 1e-10  # change at which refinement ends (a choice)
_SETTLED = 1e-7  # change below which a larger one is rounding, and ends refinement (a choice)
_PLENTY = 4000  # rows of all instants, above which larger changes end it (a choice)
_ROUNDING = 1e-12  # of a number, beside that of the growth without noise (heuristic)
_NEAREST = 1e-10  # distance to the growth without noise at which growth under noise is that (a choice)


class _Products(NamedTuple):
    """The noisy products: kicks D (n, R), rows of y over the present (R, n) and over delayed values."""

    kicks: Floats
    present: Floats
    delayed: tuple[tuple[float | Fraction, Floats], ...]
    pairs: tuple[tuple[int, int], ...]  # entries of v: of each source a <= b

    @classmethod
    def of(cls, moments: DelayedMoments) -> Self:
        """Return the products of all sources, a source of rank r as r of them."""
        n = moments.order
        delays = sorted({delay for source in moments.noise for delay, _ in source.delayed})
        kicks, rows, pairs = [np.zeros((n, 0))], [np.zeros((0, n * (1 + len(delays))))], []
        for source in moments.noise:
            own = dict(source.delayed)
            wide = [source.present, *(own.get(delay, np.zeros((n, n))) for delay in delays)]
            left, sizes, right = np.linalg.svd(source.intensity * np.concatenate(wide, axis=1), full_matrices=False)
            rank = int((sizes > _SINGULAR * sizes[0]).sum())
            first, root = sum(each.shape[1] for each in kicks), np.sqrt(sizes[:rank])
            pairs += [(first + a, first + b) for a in range(rank) for b in range(a, rank)]
            kicks.append(left[:, :rank] * root)
            rows.append(root[:, None] * right[:rank])
        whole = np.concatenate(rows)
        delayed = tuple((delay, whole[:, n * k : n * (k + 1)]) for k, delay in enumerate(delays, 1))
        return cls(np.concatenate(kicks, axis=1), whole[:, :n], delayed, tuple(pairs))


class _Kick(NamedTuple):
    """The responses y (R,) at F nodes of each period after kicks (R,) at one instant."""

    times: Floats  # (F,), of the nodes from the kick on, in periods
    weights: Floats  # (F,), of an integral over a period, in the unit of time
    scale: float  # logarithm of the factor by which responses are divided after each period
    early: Floats  # (P, R, F, R), y of the first periods to each kick
    late: Floats  # (R, F, L), y of a later period over the leading subspace
    state: Floats  # (L, R), at the first later period, of each kick
    step: Floats  # (L, L), over a period
    rate: float  # logarithm of the largest modulus
    rounding: float  # of that logarithm


class _Instants(NamedTuple):
    """Instants u of kicks, as parts of the period, and functions of period 1 between them.

    Trigonometric polynomials, or polynomials on pieces with Gauss's nodes where there are ``edges``.
    """

    places: Floats
    edges: Floats | None

    @classmethod
    def of(cls, breaks: Sequence[Fraction], turn: float, waves: int, count: int) -> Self:
        """Return the instants for functions that bend at breaks, and turn by about ``turn`` radians in a period."""
        if not breaks:
            wanted = 2 * (waves + min(_TURNS, math.ceil(turn / math.pi))) + (3 * count // 2 | 1)
            size = wanted if waves else 1
            return cls(np.arange(size) / size, None)
        edges = np.asarray(_cut(delay_maps.distinct(sorted({0.0, *map(float, breaks)})), turn))
        nodes = edges[:-1, None] + np.diff(edges)[:, None] * 0.5 * (rule(count)[0] + 1.0)
        return cls(nodes.ravel(), edges)

    def rows(self, times: Floats) -> Floats:
        """Return the values at times (F,) as rows (F, N) over the values at the instants."""
        size = len(self.places)
        if self.edges is None:
            angles = math.pi * (times[:, None] - self.places)
            met = np.abs(np.sin(angles)) < 1e-13
            below = np.where(met, 1.0, np.sin(angles))
            return np.asarray(np.where(met, 1.0, np.sin(size * angles) / (size * below)))
        pieces = len(self.edges) - 1
        count = size // pieces
        there = times % 1.0
        piece = np.clip(np.searchsorted(self.edges, there, side="right") - 1, 0, pieces - 1)
        place = 2.0 * (there - self.edges[piece]) / np.diff(self.edges)[piece] - 1.0
        rows = np.zeros((len(times), pieces, count))
        rows[np.arange(len(times)), piece] = legendre.legvander(place, count - 1) @ rule(count)[1]
        return rows.reshape(len(times), size)


class RenewalEquation(NamedTuple):
    """The operator of the renewal equation as a matrix, a function of the growth sigma."""

    period: float  # of the responses: the longest delay where nothing varies
    rows: int  # of the largest system of equations
    kicks: tuple[_Kick, ...]  # at each instant
    interpolation: tuple[Floats, ...]  # (F, N) of each kick, at its nodes
    pairs: tuple[tuple[int, int], ...]

    def radius(self, log: float) -> float:
        """Return the spectral radius for sigma period = ``log``; infinite where the integral diverges."""
        if not self.pairs:
            return 0.0
        if log <= self.growth_without_noise:
            return math.inf
        size, count = len(self.kicks), len(self.pairs)
        matrix = np.zeros((size, count, size, count))
        for i, (kick, rows) in enumerate(zip(self.kicks, self.interpolation, strict=True)):
            decay = kick.weights * np.exp(-log * kick.times)
            values = np.asarray(_squares(kick, self.pairs, log)) * decay  # (pairs of kicks, pairs of y, F)
            matrix[i] = (values @ rows).transpose(0, 2, 1)
        if not np.isfinite(matrix).all():
            return math.nan
        return float(np.abs(np.linalg.eigvals(matrix.reshape(size * count, -1))).max())

    @property
    def growth_without_noise(self) -> float:
        """The logarithm of the factor of second moments over a period without noise."""
        return max(_SMALLEST, 2.0 * max(kick.rate for kick in self.kicks))

    @property
    def rounding(self) -> float:
        """Error of ``growth_without_noise`` by rounding, the largest of all where that is only an upper bound."""
        rounding = 2.0 * max(kick.rounding for kick in self.kicks)
        return rounding if rounding < _RESOLVED and self.growth_without_noise > _SMALLEST else -_SMALLEST

    def uncertainty(self, growth: float) -> float:
        """Return the error of a growth by rounding of the multipliers, which matters less the larger growth is."""
        return self.rounding * min(1.0, 4.0 * math.exp(self.growth_without_noise - growth))

    def growth(self, near: float = math.nan) -> float:
        """Return sigma times the period, the larger of both; NaN beyond doubles.  The search may begin ``near`` it."""
        from scipy.optimize import brentq

        def excess(log: float) -> float:
            radius = self.radius(log)
            return -1.0 if math.isinf(radius) else min(1.0 / radius if radius else math.inf, 1e3) - 1.0

        lowest = self.growth_without_noise
        least = lowest + _NEAREST + 4.0 * min(self.rounding, 1e-3)
        beside = max(_BESIDE, 4.0 * (least - lowest))
        if near - beside > least and excess(near - beside) < 0.0:
            low, high = near - beside, near + beside
        elif excess(least) > 0.0:
            return lowest
        else:
            low, high = least, least + beside
        while not (above := excess(high)) >= 0.0:
            if not high < _LARGEST or math.isnan(above):
                return math.nan
            low, high = high, high + 4.0 * (high - low)
        return float(brentq(excess, low, high, xtol=1e-14, rtol=1e-14))


def _squares(kick: _Kick, pairs: Sequence[tuple[int, int]], log: float) -> list[list[Floats]]:
    """Return the sums over all periods of products of responses, (F,), by pairs of kicks and pairs of products."""
    apart = log - 2.0 * kick.scale
    factor = np.exp(-apart * np.arange(len(kick.early)))
    shrunk = math.exp(-0.5 * apart) * kick.step
    sums = []
    for a, b in pairs:
        later = np.outer(kick.state[:, a], kick.state[:, b])
        later = _geometric(shrunk, 0.5 * (later + later.T)) * math.exp(-apart * len(kick.early))
        row = []
        for c, d in pairs:
            one, other = (
                kick.early[:, c, :, a] * kick.early[:, d, :, b],
                kick.early[:, c, :, b] * kick.early[:, d, :, a],
            )
            total = factor @ (0.5 * (one + other)) + ((kick.late[c] @ later) * kick.late[d]).sum(axis=1)
            row.append(total if c == d else 2.0 * total)
        sums.append(row)
    return sums


def _geometric(step: Floats, first: Floats) -> Floats:
    """Return the sum of step^k first (step^k)^T over all k, by doubling."""
    for _ in range(_DOUBLINGS):
        more = step @ first @ step.T
        first = first + more
        if not np.abs(more).max(initial=0.0) > 1e-17 * np.abs(first).max(initial=0.0):
            break
        step = step @ step
    return first


class _Layout(NamedTuple):
    """Period, delays as parts of it, and what bends solutions and their moments, of all numbers of nodes."""

    moments: DelayedMoments
    products: _Products
    exact: Fraction
    delays: tuple[float | Fraction, ...]  # of the terms of the system, and then of noise
    jumps: tuple[Fraction, ...]  # of coefficients, and their images by delays in both directions
    images: tuple[Fraction, ...]  # of the kick

    @classmethod
    def of(cls, moments: DelayedMoments) -> Self:
        system, products = moments.system, _Products.of(moments)
        others = tuple(delay for delay, _ in products.delayed if delay not in system.delays)
        delays = (*system.delays, *others)
        exact = by_pieces.exact_period(system.present)
        if system.is_constant:
            exact = (
                max(Fraction(delay) for delay in delays)
                if delays
                else min(exact, Fraction(_PHASE / max(rate(system), 1e-100)))
            )
        matrices = (system.present, *(term.coefficient for term in system.delayed))
        own = {piece.begin / exact for m in matrices if m.pieces for piece in by_pieces.in_time(m)}
        apart = [Fraction(delay) / exact for delay in delays]
        jumps = delay_maps.with_images(own, apart) | delay_maps.with_images(own, [-delay for delay in apart])
        images = delay_maps.with_images({Fraction(0)}, apart)
        return cls(moments, products, exact, delays, tuple(jumps), tuple(images))

    @property
    def turn(self) -> float:
        """About the radians that solutions turn by in a period."""
        return rate(self.moments.system) * float(self.exact)

    def mesh(self, place: float, count: int) -> Mesh:
        """Return the mesh of the periods that begin with a kick."""
        system, period = self.moments.system, float(self.exact)
        bends = [*map(float, self.images), *((float(jump) - place) % 1.0 for jump in self.jumps)]
        breaks = _cut(delay_maps.distinct(sorted({0.0, *bends})), self.turn)
        middles = (np.asarray([0.5 * (low + high) for low, high in pairwise(breaks)]) + place) * period
        noisy = {delay for delay, _ in self.products.delayed}
        active = [
            tuple([True] * len(middles) if delay in noisy else delay_maps.presence(term.coefficient, middles))
            for delay, term in zip(system.delays, system.delayed, strict=True)
        ]
        active += [(True,) * len(middles)] * (len(self.delays) - len(active))
        derivatives = 2 if system.is_second_order else 1
        parts = tuple(float(Fraction(delay) / self.exact) for delay in self.delays)
        return mesh(tuple(breaks), count, derivatives, parts, tuple(active))

    def kick(self, place: float, on: Mesh, count: int) -> _Kick | None:
        """Return the responses to kicks at an instant; None where they are not finite."""
        system, period, n = self.moments.system, float(self.exact), self.moments.order
        given = delay_maps.coefficients(system, period, on.nodes + place)
        silent = (np.zeros_like(given.value),) * (len(self.delays) - len(system.delays))
        history = delay_maps.period_map(on, given._replace(delayed=(*given.delayed, *silent)))
        matrix = history.maps[0]
        unknowns = history.unknowns[0].reshape(len(on.nodes), n, -1)
        rows = np.einsum("rn,fns->rfs", self.products.present, _solution(unknowns, on.value, on.value_state))
        for delay, product in self.products.delayed:
            rows = rows + np.einsum("rn,fns->rfs", product, _earlier(unknowns, on.delays[self.delays.index(delay)]))
        kicks = np.zeros((len(matrix), self.products.kicks.shape[1]))
        if system.is_second_order:
            kicks[n : 2 * n] = period * delay_maps.inverse_mass(system) @ self.products.kicks
        else:
            kicks[:n] = self.products.kicks
        weights = (0.5 * np.diff(on.breaks)[:, None] * legendre.leggauss(count)[1]).ravel() * period
        return _kick(matrix, rows, kicks, on.nodes, weights, on.periods + 3)


def _solution(unknowns: Floats, rows: Floats, state_rows: Floats) -> Floats:
    """Return the solution at nodes (F, n, S) over the state, from its rows over the unknowns and over the state."""
    nodes, n, columns = unknowns.shape
    solution = (rows @ unknowns.reshape(nodes, n * columns)).reshape(-1, n, columns)
    for k in range(state_rows.shape[1]):
        for i in range(n):
            solution[:, i, k * n + i] += state_rows[:, k]
    return solution


def _earlier(unknowns: Floats, delayed: DelayRows) -> Floats:
    """Return delayed values at nodes (F, n, S) over the state."""
    n, derivatives = unknowns.shape[1], delayed.now_state.shape[1]
    values = _solution(unknowns, delayed.now, delayed.now_state)
    for i in range(n):
        values[:, i, derivatives * n + i :: n] += delayed.past
    return values


def _kick(matrix: Floats, rows: Floats, kicks: Floats, times: Floats, weights: Floats, halving: int) -> _Kick | None:
    """Return responses from the map over a period, the rows of y and the states of kicks.

    ``halving`` is the number of periods in which the share outside the leading subspace must halve, or it is rounding.
    """
    subspace = delay_spectra.leading_subspace(matrix, _LEADING) if np.isfinite(matrix).all() else None
    if subspace is None:
        return None
    basis, largest = subspace.basis, subspace.largest
    kicks, rows = kicks / subspace.scales[:, None], rows * subspace.scales
    growth = math.log(largest) if largest > 0.0 else -math.inf
    scale = max(growth, 0.5 * _SMALLEST)
    matrix = math.exp(-scale) * subspace.balanced
    early, shares, state = [rows @ kicks], [math.inf], matrix @ kicks
    while True:
        size = float(np.abs(state).max(initial=0.0))
        share = float(np.abs(state - basis @ (basis.T @ state)).max(initial=0.0)) / size if size else 0.0
        if share <= _LEFT_OUT or (share <= _NEARLY and share > 0.5 * min(shares[-1 - halving :])):
            break
        if len(early) == _EARLY:
            return None
        shares.append(share)
        early.append(rows @ state)
        state = matrix @ state
    rounding = 4.0 * EPS * math.sqrt(len(matrix)) * float(np.linalg.norm(subspace.balanced, 2))
    return _Kick(
        times,
        weights,
        scale,
        np.asarray(early),
        rows @ basis,
        basis.T @ state,
        math.exp(-scale) * subspace.block,
        growth,
        rounding / max(largest, 1e-300) + share,
    )


def _cut(edges: Sequence[float], turn: float) -> list[float]:
    """Return edges with pieces in which solutions turn by some radians, ``turn`` of them in all."""
    fine = [edges[0]]
    for low, high in pairwise(edges):
        fine += np.linspace(low, high, max(1, math.ceil((high - low) * turn / _PHASE)) + 1)[1:].tolist()
    return fine


def renewal_equation(moments: DelayedMoments, count: int) -> RenewalEquation | None:
    """Return the equation with ``count`` nodes in a piece; None if it is too large."""
    layout = _Layout.of(moments)
    instants = _Instants.of(layout.jumps, layout.turn, _waves(moments.system), count)
    kicks, rows = [], 0
    for place in instants.places.tolist():
        on = layout.mesh(place, count)
        rows = max(rows, moments.order * max(on.size, len(on.nodes)))
        work = float(rows) ** 3 * len(instants.places)
        if rows > _MOST_ROWS or work > _MOST_WORK or len(instants.places) * len(layout.products.pairs) > _MOST_UNKNOWNS:
            return None
        kick = layout.kick(place, on, count)
        if kick is None:
            return None
        kicks.append(kick)
    interpolation = tuple(
        instants.rows(place + kick.times) for place, kick in zip(instants.places.tolist(), kicks, strict=True)
    )
    return RenewalEquation(float(layout.exact), rows, tuple(kicks), interpolation, layout.products.pairs)


def _waves(system: DelaySystem) -> int:
    """Return the highest harmonic of the coefficients, 0 where nothing varies."""
    if system.is_constant:
        return 0
    parts = (system.present, *(term.coefficient for term in system.delayed))
    return max(1, *(int(piece.harmonics.shape[-3]) for part in parts for piece in by_pieces.in_time(part)))


class Refined(NamedTuple):
    """A number from the equation with enough nodes, its estimated error, and what it took."""

    value: float
    error: float
    equation: RenewalEquation


def refined(moments: DelayedMoments, number: Callable[[RenewalEquation, float], float]) -> Refined | None:
    """Return a number of the equation, with more nodes until it stays; None where it takes too much or is not known.

    ``number`` gets the equation and the number with fewer nodes, NaN at first.  The error is twice the last change,
    twice the change by each coefficient larger by its error, and rounding.
    """
    best: Refined | None = None
    before, count = math.nan, 0
    for nodes in _COUNTS:
        try:
            equation = renewal_equation(moments, nodes)
        except np.linalg.LinAlgError:
            continue
        if equation is None:
            break
        value = number(equation, before)
        change, before = abs(value - before), value  # NaN where either is not known
        if best is not None and best.error <= _SETTLED * max(1.0, abs(value)) and not change < best.error:
            break
        if not math.isnan(change):
            best, count = Refined(value, change, equation), nodes
            work = equation.rows * len(equation.kicks) / _PLENTY
            if change <= _UNCHANGED * max(1.0, abs(value), work**2):
                break
    if best is None:
        return None
    error = 2.0 * best.error + _ROUNDING * max(1.0, abs(best.value))
    for system in moved(moments.system) if moments.system.coefficient_error else ():
        near = renewal_equation(replace(moments, system=system), count)
        error += math.inf if near is None else 2.0 * abs(number(near, best.value) - best.value)
    return best._replace(error=error)
