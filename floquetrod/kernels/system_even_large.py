"""The map over half a period of many equations, one system at a time, by numpy's products of matrices."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from floquetrod.kernels.system_even_steps import balance, cut_harmonics, plan
from floquetrod.kernels.system_series import ROUNDING, coefficient_bound

Floats = NDArray[np.float64]


@np.errstate(over="ignore", invalid="ignore")  # of maps that overflow, whose errors are then not finite
def half_period_large(
    s: Floats, f: Floats, first: int, omega: float, accuracy: float, reach: float, symmetric: bool, slack: float
) -> tuple[Floats, Floats, float]:
    """Return the map (2 n, 2 n) in balanced coordinates, their scales g and the error, as `half_period_fill` does."""
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
    spread = math.sqrt(fast / slow)
    factor = spread * (2.0 * terms + 2.0) + fast * h + (2.0 * terms + 1.0) / (slow * h)
    harmonics = np.arange(first, first + len(f))
    signs = (-1.0) ** harmonics
    other = (f if symmetric else f.swapaxes(-1, -2)) * signs[:, None, None]
    scale = g[:, None] / g[None, :]
    rate = h * g[:, None] * g[None, :]

    index = np.arange(float(terms))
    angles = harmonics[:, None] * (omega * h)
    even = np.cumprod(
        np.hstack([np.ones((len(f), 1)), -(angles**2) / ((2.0 * index[1:] - 1.0) * (2.0 * index[1:]))]), axis=1
    ).astype(float)
    maps, errors = [], []
    for end, matrices in enumerate((f, other)):
        x = np.empty((terms, n, 2 * n))
        x[0] = np.hstack([np.eye(n), np.eye(n)])
        divisors = np.repeat([[1.0], [2.0]], n, axis=1).ravel()
        for i in range(terms - 1):
            out = _applied(x, i, even, most, s, matrices, first)
            np.multiply(out, -h * h / ((2.0 * i + divisors) * (2.0 * i + 1.0 + divisors)), out=x[i + 1])
        rest = _tail(x, ratio**-4.0)
        value = x[::-1].sum(axis=0)
        slope = np.tensordot(2.0 * index[::-1], x[::-1], 1)
        a, b = value[:, :n] * scale, value[:, n:] * rate
        c, d = slope[:, :n] / rate, (slope[:, n:] + value[:, n:]) / scale
        maps.append(np.block([[a, b], [c, d]] if end == 0 else [[d.T, b.T], [c.T, a.T]]))
        errors.append(noise + rest * factor / (1.0 - ratio**-2.0) ** 2)

    order = 2 * terms
    index = np.arange(order + 1)
    factorials = np.cumprod(np.maximum(index, 1.0))
    for segment in range(1, segments):
        centre = math.pi * (harmonics * segment % (2 * segments)) / segments
        mixed = np.cos(centre[:, None] + 0.5 * math.pi * index) * angles**index / factorials
        x = np.zeros((order + 1, n, 2 * n))
        x[0, :, :n] = x[1, :, n:] = np.eye(n)
        for i in range(order - 1):
            out = _applied(x, i, mixed, 2 * most + 1, s, f, first)
            np.multiply(out, -h * h / ((i + 1.0) * (i + 2.0)), out=x[i + 2])
        rest = _tail(x, ratio**-2.0)
        error = noise + rest * factor / (1.0 - 1.0 / ratio) ** 2
        sides = []
        for sign in (1.0, -1.0):
            value = np.tensordot((sign**index)[::-1], x[::-1], 1)
            slope = np.tensordot((index * sign ** (index + 1.0))[::-1], x[::-1], 1)
            sides.append(
                np.block([[value[:, :n] * scale, value[:, n:] * rate], [slope[:, :n] / rate, slope[:, n:] / scale]])
            )
        forth, back = sides
        if symmetric:
            back = np.block([[back[n:, n:].T, -back[:n, n:].T], [-back[n:, :n].T, back[:n, :n].T]])
        else:
            back = np.linalg.inv(back)
        one, two = norm_bound(forth), norm_bound(back)
        maps.insert(-1, forth @ back)
        wrong = error * (one + two + error) + ROUNDING * (2.0 * n + 2.0) * one * two
        if not symmetric:
            wrong += (error + 8.0 * n * ROUNDING) * one * two * two
        errors.insert(-1, wrong)
    return _chain(maps, errors, g)


def _applied(x: Floats, i: int, c: Floats, most: int, s: Floats, matrices: Floats, first: int) -> Floats:
    """Return s x_i + sum_k F_k sum_l c_kl x_(i-l)."""
    out: Floats = s[:, None] * x[i]
    start = max(0, i - most)
    flat = x[start : i + 1].reshape(i + 1 - start, -1)
    for k, matrix in enumerate(matrices):
        mixed = x[i] if k + first == 0 else (c[k, i - start :: -1][: len(flat)] @ flat).reshape(out.shape)
        out += matrix @ mixed
    return out


def _tail(x: Floats, shrink: float) -> float:
    """Return `system_even_steps.tail` of a series."""
    squares = np.array([float(np.vdot(term, term)) for term in x])
    return math.sqrt(float(squares @ shrink ** np.arange(len(x), 0, -1.0)))


def norm_bound(matrix: Floats) -> float:
    """Bound the spectral norm of a matrix from its entries."""
    sizes = np.abs(matrix)
    product = float(sizes.sum(axis=0).max()) * float(sizes.sum(axis=1).max())
    return min(float(np.linalg.norm(matrix)), math.sqrt(product))


def _chain(maps: list[Floats], errors: list[float], g: Floats) -> tuple[Floats, Floats, float]:
    """Return the product of the maps, g, and the product's error; see `system_series.chain_error`."""
    size = len(maps[0])
    prefixes = [np.eye(size), maps[0]]
    for factor in maps[1:]:
        prefixes.append(factor @ prefixes[-1])
    total, share, suffix = 0.0, 0.0, np.eye(size)
    for j in range(len(maps) - 1, -1, -1):
        norm = norm_bound(maps[j])
        local = errors[j] + (ROUNDING * (size + 2.0) * norm * math.sqrt(size) if j else 0.0)
        total += norm_bound(suffix) * local * norm_bound(prefixes[j])
        share += local / norm if norm > 0.0 else math.inf
        suffix = suffix @ maps[j] if j else suffix
    return prefixes[-1], g, total * math.exp(min(share * len(maps), 50.0))
