"""The trace of the map of Hill's equation over a period, enclosed: Taylor series with Cauchy's bound on the rest."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from floquetrod.floquet.proof.intervals import check_work, cosh_sinhc, exp, pi
from floquetrod.floquet.proof.series import Series

_RADIUS = 4  # Taylor series are bounded on a disc of this many steps (heuristic)


class _State(NamedTuple):
    """A solution and its slope per step h: u and h u'."""

    u: Any
    slope: Any


class _Map(NamedTuple):
    """The states at the end for the states (1, 0) and (0, 1) at the start."""

    first: _State
    second: _State

    def after(self, earlier: _Map) -> _Map:
        """Return the composition of ``earlier`` followed by this map."""
        return _Map(self._of(earlier.first), self._of(earlier.second))

    def _of(self, state: _State) -> _State:
        return _State(
            self.first.u * state.u + self.second.u * state.slope,
            self.first.slope * state.u + self.second.slope * state.slope,
        )


def enclose_trace(context: Any, series: Series) -> Any:
    """Enclose the trace of the map of u'' = p u over a period 2 pi, in equal steps h.

    On a disc of radius R about a step's start abs(p) <= P, so with w^2 >= P a solution obeys max(w abs(u), abs(u'))
    <= exp(w R) max(w abs(u_0), abs(u'_0)) there, and by Cauchy's estimate its n-th term is below exp(w R) max(abs(u_0),
    abs(u'_0) / w) (h / R)^n.  The state is (u, h u').
    """
    rough = float(sum((wave.size for wave in series.waves), abs(series.mean)).b)
    order = math.ceil(1.7 * context.dps) + 10
    check_work(context, 6.0 * math.sqrt(rough) * order**2)
    steps = max(16 * len(series.waves), math.ceil(3.0 * math.sqrt(rough)))
    h = 2 * pi(context) / steps
    radius = _RADIUS * h
    bound = abs(series.mean)
    for k, wave in enumerate(series.waves, start=1):
        bound += wave.size * exp(context, k * radius)
    w = math.ceil(math.sqrt(max(1.0, float(bound.b))))
    growth = exp(context, w * radius)
    ratio = context.mpf(1) / _RADIUS
    starts = _Map(_State(context.one, context.zero), _State(context.zero, context.one))
    left_out = [size * ratio**order * context.mpf([-1, 1]) for size in (growth, growth / (w * h))]
    total = starts
    for step in range(steps):
        terms = _coefficient_terms(context, series, step * h, h, order)
        ends = (_advance(context, terms, *start, order) for start in zip(starts, left_out, strict=True))
        total = _Map(*ends).after(total)
    return total.first.u + total.second.slope


def _advance(context: Any, coefficient: list[Any], start: _State, left_out: Any, order: int) -> _State:
    """Sum ``order`` terms of u and h u' after a step, and enclose the rest.

    With terms below ``left_out`` (1/4)^(n - order) the rest is below 4/3 of it for u, and 2 order of it for h u'.
    """
    terms = list(start)
    while len(terms) < order:
        n = len(terms) - 2
        push = sum((coefficient[i] * terms[n - i] for i in range(n + 1)), context.zero)
        terms.append(push / ((n + 1) * (n + 2)))
    slope = sum((n * term for n, term in enumerate(terms)), context.zero)
    return _State(sum(terms, context.zero) + 2 * left_out, slope + 2 * order * left_out)


def _coefficient_terms(context: Any, series: Series, theta: Any, h: Any, order: int) -> list[Any]:
    """Return the Taylor coefficients of h^2 p(theta + h s) in s."""
    terms = [context.zero] * order
    terms[0] = h**2 * series.mean
    for k, (x, y) in enumerate(series.waves, start=1):
        angle = k * theta
        cosine, sinc = cosh_sinhc(context, -(angle**2))
        sine = angle * sinc
        # value and derivative of x cos + y sin repeat, with alternating signs, every other order
        now, after = h**2 * (x * cosine + y * sine), h**2 * (y * cosine - x * sine)
        for n in range(order):
            terms[n] += now
            now, after = after * (k * h) / (n + 1), -now * (k * h) / (n + 1)
    return terms
