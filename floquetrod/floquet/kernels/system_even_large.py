"""The map over half a period of many equations, one system at a time, by numpy's products of matrices."""

from __future__ import annotations

import math

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.floquet.kernels.system_even_steps import balance, cut_harmonics, plan
from floquetrod.floquet.kernels.system_large import (
    LEVELS,
    Matrix,
    Stop,
    TaylorTerms,
    chain,
    crossing,
    joined,
    norm_bound,
    split,
    stop_rule,
    tail,
    times,
)
from floquetrod.floquet.kernels.system_series import ROUNDING, coefficient_bound

_TOGETHER = 60  # equations up to which both ends of a half period are one series (measured)


@np.errstate(over="ignore", under="ignore", invalid="ignore")  # of maps that overflow, whose errors are then not finite
def half_period_large(
    s: Floats, f: Floats, first: int, omega: float, accuracy: float, reach: float, symmetric: bool, slack: float
) -> tuple[Floats, Floats, float]:
    """Return the map (2 n, 2 n) in balanced coordinates, their scales g and the error, as `half_period_fill` does."""
    # u'' + K(t) u = 0, K = diag(s) + sum_k F_k cos((k + first) w t), f = (F_k) (H, n, n), w = omega: the series of
    # `end_maps` and `inner_map`, by products of whole matrices.  With x = t / h, h = T / (4 segments), about an end of
    # the half period
    #     even u = sum_i u_i x^2i,    odd u = h sum_i u_i x^(2i+1),    u_(i+1) = -h^2 (K u)_i / ((2i+1)(2i+2)),
    # of odd ones over ((2i+2)(2i+3)); ``even[k, l]`` is the coefficient of x^2l in cos((k + first) w h x).  Maps act on
    # (g u, u' / g): a, b, c, d are their blocks (n, n).  About T/2 the cosines of odd k change sign; there the series
    # is that of the transposed equation, whose map inverts the other's, and since K is even and time runs back, the map
    # from T/2 - h to T/2 is [[d^T, b^T], [c^T, a^T]].  ``maps`` are, first acting first, [0, h], the inner segments,
    # [T/2 - h, T/2].  ``noise`` sums the errors that all maps share: rounding, harmonics cut off, and that of K itself.
    n = len(s)
    norms = np.array([norm_bound(matrix) for matrix in f])
    g = np.empty(n)
    size, slow, fast = balance(s, f, omega, g)
    segments, terms, ratio, rounding = plan(size, norms, first, omega, accuracy, reach, n)
    if segments == 0:
        return np.full((2 * n, 2 * n), math.nan), g, math.inf
    h = 0.5 * math.pi / (omega * segments)
    most, cut = cut_harmonics(norms, first, omega, h, terms, slow, accuracy)
    noise = rounding + cut + slack * coefficient_bound(size, norms, first, 0.0) / slow * h
    stop = stop_rule(n, h * h * size, h * h * norms, first, omega * h, (slow * h, fast * h), max(accuracy, noise))
    harmonics = np.arange(first, first + len(f))
    blocks: list[Matrix] = list(f)
    # Blocks of low rank make products cheaper; what they drop is an error of K at each of `LEVELS` levels.
    if symmetric:
        blocks = [split(matrix, ROUNDING * norm) for matrix, norm in zip(f, norms, strict=True)]
        noise += LEVELS * ROUNDING * float(norms.sum()) / slow * h
    transposed = blocks if symmetric else list(f.swapaxes(-1, -2))
    scale = g[:, None] / g[None, :]
    rate = h * g[:, None] * g[None, :]

    index = np.arange(float(terms))
    angles = harmonics[:, None] * (omega * h)
    even = np.cumprod(
        np.hstack([np.ones((len(f), 1)), -(angles**2) / ((2.0 * index[1:] - 1.0) * (2.0 * index[1:]))]), axis=1
    ).astype(float)
    ends = [blocks, [times(matrix, (-1.0) ** k) for matrix, k in zip(transposed, harmonics.tolist(), strict=True)]]
    # Few equations: both ends as one series (2, n, 2 n), half as many calls of numpy.
    together = (2,) if n <= _TOGETHER else ()
    if together:
        ends = [[np.stack(pair) for pair in zip(*ends, strict=True)]]
    maps: list[Floats] = []
    errors: list[float] = []
    x = np.zeros((most + 2, *together, n, 2 * n))
    for matrices in ends:
        series = TaylorTerms(s, matrices, even, most, x, constant=first == 0)
        sums, rest = _even_sums(series, h, terms, ratio, stop)
        for value, slope in sums:
            a, b = value[:, :n] * scale, value[:, n:] * rate
            c, d = slope[:, :n] / rate, (slope[:, n:] + value[:, n:]) / scale
            maps.append(np.block([[d.T, b.T], [c.T, a.T]] if maps else [[a, b], [c, d]]))
            errors.append(noise + rest)

    # Inner centres: K is not even there, all powers count, and c[k, i] are those of cos(centre + (k + first) w h x).
    order = 2 * terms
    index = np.arange(order + 1)
    factorials = np.cumprod(np.maximum(index, 1.0))
    for segment in range(1, segments):
        centre = math.pi * (harmonics * segment % (2 * segments)) / segments
        mixed = np.cos(centre[:, None] + 0.5 * math.pi * index) * angles**index / factorials
        forth, back, rest = crossing(s, blocks, mixed, 2 * most + 1, h, order, ratio, stop, constant=first == 0)
        matrix, wrong = joined(forth, back, noise + rest, g, h, symmetric=symmetric)
        maps.insert(-1, matrix)
        errors.insert(-1, wrong)
    product, error = chain(maps, errors)
    return product, g, error


def _even_sums(series: TaylorTerms, h: float, terms: int, ratio: float, stop: Stop) -> tuple[Floats, float]:
    """Return values and slopes at h of the even solutions and, over h, of the odd ones, and the truncation error.

    As (ends, 2, n, 2 n), where the terms of the series are (ends, n, 2 n), or (n, 2 n) of a single one.
    """
    # At x = 1 values are sum u_i and slopes sum 2i u_i (of odd solutions (2i + 1) u_i, which the caller completes).  x
    # is a ring of the last ``rows`` terms, all that the recurrence reads: before one is overwritten, the terms in it
    # are added to ``sums``.  The series ends as soon as `Stop` bounds what is left by its tolerance; else Cauchy's
    # bound holds, the terms beyond falling like ratio^-2i.
    x = series.terms
    rows, n = len(x), x.shape[-2]
    divisors = np.repeat([1.0, 2.0], n)
    x[0, ..., :n] = x[0, ..., n:] = np.eye(n)
    sizes = np.zeros(2 * terms - 1)
    sizes[0] = math.sqrt(x[0].size / n)
    sums, added = np.zeros((2, x[0].size)), 0  # of the first terms

    def with_terms(end: int) -> Floats:
        """Return the sums with the terms not yet added, all of them in rows of ``x``."""
        places = np.arange(added, end)
        weights = np.zeros((2, min(end, rows)))
        weights[:, places % rows] = np.ones_like(places), 2.0 * places
        return np.asarray(sums + weights @ x[: weights.shape[1]].reshape(weights.shape[1], -1))

    for i in range(terms - 1):
        if i + 1 - added == rows:  # the next term takes the place of one of them
            sums, added = with_terms(i + 1), i + 1
        term = series.append(i, i + 1, -h * h / ((2.0 * i + divisors) * (2.0 * i + 1.0 + divisors)))
        sizes[2 * i + 2] = math.sqrt(float(np.vdot(term, term)))
        rest = stop.left_out(sizes[: 2 * i + 3])
        if rest < stop.tolerance:
            break
    else:
        i = terms - 2
        rest = stop.factor(2 * terms) * tail(sizes[::2], ratio**-4.0) / (1.0 - ratio**-2.0) ** 2
    return with_terms(i + 2).reshape(2, -1, n, 2 * n).swapaxes(0, 1), rest
