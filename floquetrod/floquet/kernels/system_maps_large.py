"""The map over a period of many equations u'' + K(t) u = 0, K symmetric, by numpy's products of matrices."""

from __future__ import annotations

import math

import numpy as np

from floquetrod._util.arrays import Complexes, Floats
from floquetrod.floquet.kernels.system_even_steps import balance
from floquetrod.floquet.kernels.system_large import (
    LEVELS,
    ModalEquations,
    chain,
    crossing,
    joined,
    norm_bound,
    split,
    stop_rule,
)
from floquetrod.floquet.kernels.system_series import MOST_TERMS, ROUNDING, coefficient_bound, plan_segments, reach

_FINEST = 1e-13  # error of a segment for each equation: below it the bounds of rounding in products outweigh it


def large_seconds(stiffness: Floats, harmonics: Complexes, period: float) -> float:
    """Return about how long the map takes and its eigenvalues, in seconds: measured on one core of 2024."""
    n, parts = len(stiffness), sum(bool(part.any()) for z in harmonics for part in (z.real, z.imag))
    size = norm_bound(stiffness) + sum(norm_bound(np.abs(z)) for z in harmonics)
    segments = max(1.0, 0.5 * period * math.sqrt(size) / reach(1e-12), 0.5 * len(harmonics))
    return n**3 * (6e-11 * segments * (30.0 * parts + 10.0) + 8e-9) + 1e-3


@np.errstate(over="ignore", under="ignore", invalid="ignore")  # of maps that overflow, whose errors are then not finite
def period_map_large(
    stiffness: Floats, harmonics: Complexes, period: float, coefficient_error: float, accuracy: float
) -> tuple[Floats, float, Floats]:
    """Return the map over a period of u'' + (S + Re sum_k Z_k exp(i k w t)) u = 0, its error, and its coordinates.

    Parameters
    ----------
    stiffness, harmonics : ndarray, (n, n), (H, n, n)
        S and Z_1..Z_H, symmetric.
    period : float
        2 pi / w.
    coefficient_error : float
        Error of K in the 2-norm.
    accuracy : float
        The error aimed at per segment, in balanced coordinates; no less than 1e-13 for each equation.

    Returns
    -------
    map : ndarray, (2 n, 2 n)
        Symplectic: of (v, p), u = basis v and u' = basis^-T p, basis eigenvectors of S over the roots of rates.
    error : float
        Bound of its Frobenius norm, absolute: truncation bounded from the computed terms, rounding and the effect of
        ``coefficient_error`` estimated.  Infinite where the period holds too many waves.
    basis : ndarray, (n, n)
        What u is in the coordinates v.
    """
    n, omega = len(stiffness), 2.0 * math.pi / period
    accuracy = max(accuracy, n * _FINEST)
    s, q, matrices, orders, turns, norms, slack, _ = ModalEquations.of(stiffness, harmonics)
    g = np.empty(n)
    size, slow, fast = balance(s, np.abs(np.reshape(matrices, (-1, n, n))), omega, g)
    bound = math.sqrt(coefficient_bound(size, norms, 1, 0.0))
    fewest = max(1, math.ceil(min(0.5 * period * bound / reach(accuracy), 1e9)))
    segments, order, ratio, phase = plan_segments(
        size, norms, 1, omega, 0.5 * period, fewest, accuracy, reach(accuracy), 2 * MOST_TERMS - 2, True
    )
    if segments == 0:
        return np.full((2 * n, 2 * n), math.nan), math.inf, q / g
    h = 0.5 * period / segments
    largest = coefficient_bound(size, norms, 1, omega * h)
    forcing = (largest - size) / largest if largest > 0.0 else 0.0
    noise = ROUNDING * (1.0 + 0.5 * phase) * (4.0 + forcing * (n + 6.0)) * math.cosh(phase)
    index = np.arange(order + 1)
    powers = (orders[:, None] * (omega * h)) ** index / np.cumprod(np.maximum(index, 1.0))
    # Powers of the factors too small to matter are left out.
    ends = np.cumsum((norms[orders - 1] @ powers)[::-1])[::-1] * 2.0 * h / slow
    most = max(int((ends > 0.1 * noise).sum()) - 1, 0)
    noise += slack * bound * bound / slow * h + (float(ends[most + 1]) if most < order else 0.0)
    dropped = max(ROUNDING * float(norms.sum()), 0.1 * accuracy * slow / (h * LEVELS))
    noise += LEVELS * dropped / slow * h
    stop = stop_rule(n, h * h * size, h * h * norms, 1, omega * h, (slow * h, fast * h), max(accuracy, noise))
    blocks = [split(matrix, dropped / len(matrices)) for matrix in matrices]
    maps, errors = [], []
    for segment in range(segments):
        place = orders * (2 * segment + 1) % (2 * segments) / segments  # of the centre, in half turns
        factors = np.cos(math.pi * (place + turns)[:, None] + 0.5 * math.pi * index) * powers
        forth, back, rest = crossing(s, blocks, factors, most, h, order, ratio, stop, constant=False)
        matrix, wrong = joined(forth, back, noise + rest, g, h, symmetric=True)
        maps.append(matrix)
        errors.append(wrong + 2.0 * h * coefficient_error / slow * max(norm_bound(matrix), 1.0) ** 2)
    return *chain(maps, errors), q / g
