"""Solutions of many equations u'' + K(t) u = 0, K symmetric, carried over a period: some of them, not the whole map."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats
from floquetrod._util.content import ByContent
from floquetrod.floquet.kernels.system_even_steps import balance
from floquetrod.floquet.kernels.system_large import LEVELS, Matrix, ModalEquations, TaylorTerms, split
from floquetrod.floquet.kernels.system_series import MOST_TERMS, ROUNDING, coefficient_bound

_REACH = 4.0  # phase that a series crosses: beyond it as many terms are needed in all (measured)
_MOST_SEGMENTS = 100
_FEW, _NOTHING = 4, 1e-4  # terms in a row, as a part of the accuracy, below which a series has ended (a choice)


@dataclass(frozen=True, eq=False)
class March(ByContent):
    """The map over a period, or half, in the coordinates of `period_map_large`, as a linear function of states."""

    parts: ModalEquations  # the equations
    scaling: Floats  # (n,), g of the states (v, p) = (g u, u' / g), u in eigenvectors of the mean stiffness
    blocks: list[Matrix]  # the amplitudes of K
    factors: Floats  # (segments, parts, terms), Taylor coefficients of their factors from the beginning of a segment
    reach: float  # length of a segment
    terms: int  # highest power of each series
    error: float = math.inf  # of the map, in the 2-norm, estimated: what more terms would add to states drawn at random

    @classmethod
    def of(cls, parts: ModalEquations, period: float, accuracy: float, start: Floats) -> Self | None:
        """Return the map with the terms that orthonormal states drawn at random need; None where these are too many."""
        march = cls.with_all_terms(parts, period, accuracy)
        return None if march is None else march._shortened(start, accuracy)

    @classmethod
    def with_all_terms(
        cls, parts: ModalEquations, period: float, accuracy: float, most: float = _MOST_SEGMENTS, *, share: float = 1.0
    ) -> Self | None:
        """Return the map over a share of a period, a half or all of it, with all terms there may be.

        None where the period needs more than ``most`` segments, or very many.
        """
        n, omega = len(parts.rates), 2.0 * math.pi / period
        g = np.empty(n)
        size, slow, _ = balance(parts.rates, np.abs(np.reshape(parts.matrices, (-1, n, n))), omega, g)
        bound = coefficient_bound(size + parts.constant, parts.norms, 1, 0.0)
        phase = max(period * math.sqrt(bound), 2.0 * math.pi * len(parts.norms))
        if not 0 < math.ceil(min(phase / _REACH, 1e9)) <= min(most, _MOST_SEGMENTS):
            return None
        segments = math.ceil(share * phase / _REACH)
        h, index = share * period / segments, np.arange(2 * MOST_TERMS - 1)
        powers = (parts.orders[:, None] * (omega * h)) ** index / np.cumprod(np.maximum(index, 1.0))
        turns = 2.0 * share * parts.orders * np.arange(segments)[:, None] / segments + parts.turns
        factors = np.cos(math.pi * turns[..., None] + 0.5 * math.pi * index) * powers
        dropped = accuracy * slow / (period * LEVELS * max(1, len(parts.matrices)))
        blocks = [split(matrix, dropped) for matrix in parts.matrices]
        return cls(parts, g, blocks, factors, h, len(index) - 1)

    def _shortened(self, start: Floats, accuracy: float) -> Self | None:
        """Return the map with as many terms as some states need."""
        rest = np.zeros(self.terms + 1)
        state = self._entered(start)
        for factors in self.factors:
            x = self._series(state, factors, _NOTHING * accuracy)
            rest[: len(x)] += np.cumsum(self._sizes(x)[::-1])[::-1]
            state = _summed(x)
        more = math.sqrt(2.0 * len(self.scaling) / start.shape[1])  # of the whole map, in the Frobenius norm
        enough = np.flatnonzero(more * rest < accuracy)
        if not enough.size:
            return None
        rounding = ROUNDING * self.terms * math.exp(_REACH) * len(self.factors)
        return replace(self, terms=int(enough[0]) - 1, error=2.0 * accuracy + rounding)

    def motion(self, states: NDArray[Any]) -> NDArray[Any]:
        """Return (u, u') of states (v, p), (2 n, ...)."""
        q, (positions, momenta) = self.parts.basis, np.split(states, 2)
        return np.concatenate([q @ (positions.T / self.scaling).T, q @ (momenta.T * self.scaling).T])

    def states(self, motion: NDArray[Any]) -> NDArray[Any]:
        """Return the states (v, p), (2 n, ...), of motion (u, u')."""
        q, (positions, velocities) = self.parts.basis, np.split(motion, 2)
        return np.concatenate([((q.T @ positions).T * self.scaling).T, ((q.T @ velocities).T / self.scaling).T])

    def _entered(self, states: Floats) -> Floats:
        """Return u and h u' of states (v, p), (2, n, q)."""
        g, n = self.scaling[:, None], len(self.scaling)
        return np.array([states[:n] / g, states[n:] * g * self.reach])

    def _left(self, state: Floats) -> Floats:
        """Return states (v, p) of u and h u'."""
        g = self.scaling[:, None]
        return np.concatenate([state[0] * g, state[1] / (g * self.reach)])

    def _series(self, state: Floats, factors: Floats, least: float = 0.0) -> Floats:
        """Return the terms of u from the beginning of a segment, in powers of its length, down to ``least``."""
        x = np.zeros((self.terms + 1, *state.shape[1:]))
        x[:2] = state
        series = TaylorTerms(self.parts.rates, self.blocks, factors, self.terms, x, constant=self.parts.constant > 0.0)
        for i in range(self.terms - 1):
            series.append(i, i + 2, -(self.reach**2) / ((i + 1.0) * (i + 2.0)))
            if least and i % _FEW == _FEW - 1 and self._sizes(x[i + 3 - _FEW : i + 3], i + 3 - _FEW).max() < least:
                return x[: i + 3]
        return x

    def carried(self, states: Floats, accuracy: float) -> Floats:
        """Return states (2 n, q) at the end, each series as long as they need; not a linear function of them."""
        least = _NOTHING * accuracy * float(np.linalg.norm(states))
        state = self._entered(states)
        for factors in self.factors:
            state = _summed(self._series(state, factors, least))
        return self._left(state)

    def _sizes(self, x: Floats, first: int = 0) -> Floats:
        """Return the norm of each term's share of the state (u, u'); the first term has the power ``first``."""
        values = np.linalg.norm(x * self.scaling[:, None], axis=(1, 2))
        slopes = np.linalg.norm(x / self.scaling[:, None], axis=(1, 2)) * (first + np.arange(len(x))) / self.reach
        return np.asarray(np.hypot(values, slopes))

    def __call__(self, states: Floats) -> Floats:
        """Return states (2 n, q) after a period: the same linear function of them every time."""
        state = self._entered(states)
        for factors in self.factors:
            state = _summed(self._series(state, factors))
        return self._left(state)


def _summed(x: Floats) -> Floats:
    """Return u and h u' at the end of a segment from the terms of u."""
    flat = x.reshape(len(x), -1)
    weights = np.array([np.ones(len(x)), np.arange(len(x))])
    return (weights @ flat).reshape(2, *x.shape[1:])
