"""Systems with delays as ordinary ones over a step that divides period and delays, to powers of 1 / nu.

A period holds q steps h, delay j holds p_j.  A solution with x(t + T) = mu x(t), mu = nu^q, is x(k h + s) = nu^k z_k(s)
with z_(k+q) = z_k, so that z' = (A + sum_j nu^-p_j B_j) z for all q parts together, where B_j reads part k - p_j mod q
for part k, and nu z_(k+1)(0) = z_k(h).  No longer time than h is crossed, whatever the delays are.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import EPS, Complexes, Floats
from floquetrod.equations import DelaySystem, HillSystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.equations.matrices import velocity_matrix
from floquetrod.equations.pieces import PieceArrays, TimedPiece
from floquetrod.floquet.multipliers import delay_maps, whole_period_maps
from floquetrod.floquet.multipliers.delay_series import DelaySeries
from floquetrod.floquet.multipliers.independent_solutions import balance
from floquetrod.floquet.multipliers.whole_steps import Steps

_MOST_POINTS = 4096  # of the circle on which maps are taken (a choice: a second)
_LEFT_OUT = 1e-16  # of a map: what the points are chosen for
_ACCURACY = 1e-12  # of a map, whose rounding is bounded by more than that (a choice)
_MOST_SECONDS = 5.0  # estimated, of all maps (a choice)


class StepPieces(NamedTuple):
    """A system over a step, all parts together, in balanced coordinates."""

    period: Fraction  # of the coefficients; of constant ones a part of the delays
    parts: int
    present: PieceArrays
    delayed: tuple[tuple[int, PieceArrays], ...]  # steps of each delay, and B_j
    rounding: float  # of every entry, as of a system with each B_j times 1
    missed: tuple[float, ...]  # by which entries of each B_j stand for a delay of another length

    @property
    def slowest(self) -> int:
        """Steps of a period or of the longest delay, whichever is longer."""
        return max(self.parts, *(back for back, _ in self.delayed))

    @property
    def order(self) -> int:
        """Unknowns of all parts."""
        return int(self.present.mean.shape[-1])


def step_pieces(system: DelaySystem, laid: Steps) -> StepPieces:
    """Return the coefficients of all parts over a step."""
    inverse = delay_maps.inverse_mass(system)
    first = [_first_order(system, system.present, inverse, present=True)]
    first += [_first_order(system, term.coefficient, inverse, present=False) for term in system.delayed]
    if system.is_constant:
        first = [(piece[0]._replace(begin=Fraction(0), length=laid.period, origin=Fraction(0)),) for piece in first]
    step = laid.period / laid.parts
    cuts = {piece.begin % step for pieces in first for piece in pieces} | {Fraction(0), step}
    present, *delayed = [
        _all_parts(pieces, sorted(cuts), step, laid, back)
        for pieces, back in zip(first, (0, *laid.delays), strict=True)
    ]
    total = np.asarray(sum(each.sizes.max(axis=1)[0] for each in (present, *delayed)))
    # The end of a part is the beginning of the next: all have the same coordinates.
    n = total.shape[0] // laid.parts
    scales = np.tile(balance(total.reshape(laid.parts, n, laid.parts, n).sum(axis=(0, 2))), laid.parts)[None]
    present, *delayed = [each.scaled(scales) for each in (present, *delayed)]
    size = max(float(each.sizes.max()) for each in (present, *delayed))
    rounding = 4.0 * EPS * size if system.is_second_order and not np.array_equal(inverse, np.eye(len(inverse))) else 0.0
    rate = delay_maps.rate(system)
    missed = tuple(
        rate * float(abs(Fraction(delay) - back * step)) * float(each.sizes.max())
        for delay, back, each in zip(system.delays, laid.delays, delayed, strict=True)
    )
    terms = tuple(zip(laid.delays, delayed, strict=True))
    return StepPieces(laid.period, laid.parts, present, terms, rounding, missed)


def _first_order(system: DelaySystem, coefficient: Any, inverse: Floats, *, present: bool) -> tuple[TimedPiece, ...]:
    """Return the pieces of a coefficient in the equations of first order, for q and q' where they are of second."""
    pieces = by_pieces.in_time(coefficient)
    if not isinstance(system.present, HillSystem):
        return pieces
    n = system.order
    moving = -inverse @ velocity_matrix(system.present) if present else np.zeros((n, n))

    def lower(matrix: Any) -> Any:
        block = np.zeros((*matrix.shape[:-2], 2 * n, 2 * n), dtype=matrix.dtype)
        block[..., n:, :n] = -inverse @ matrix
        return block

    def mean(matrix: Floats) -> Floats:
        block: Floats = lower(matrix)
        if present:
            block[:n, n:], block[n:, n:] = np.eye(n), moving
        return block

    return tuple(
        piece._replace(
            mean=mean(piece.mean),
            slope=None if piece.slope is None else lower(piece.slope),
            harmonics=lower(piece.harmonics),
        )
        for piece in pieces
    )


def _all_parts(
    pieces: tuple[TimedPiece, ...], cuts: list[Fraction], step: Fraction, laid: Steps, back: int
) -> PieceArrays:
    """Return a coefficient of all parts over the step, between its cuts, where part k reads part k - ``back``."""
    parts, n = laid.parts, pieces[0].mean.shape[-1]
    inside = tuple(
        by_pieces.between(pieces, k * step + low, high - low)[0] for k in range(parts) for low, high in pairwise(cuts)
    )
    arrays = by_pieces.arrays_of(inside, laid.period)
    count, size = len(cuts) - 1, parts * n

    def placed(array: Any) -> Any:
        inner = array.shape[2:-2]
        split = array[0].reshape(parts, count, *array.shape[2:])
        whole = np.zeros((1, count, *inner, size, size), dtype=array.dtype)
        for k in range(parts):
            column = (k - back) % parts
            whole[0, ..., k * n : (k + 1) * n, column * n : (column + 1) * n] = split[k]
        return whole

    slope = None if arrays.slope is None else placed(arrays.slope)
    return PieceArrays(
        placed(arrays.mean), slope, placed(arrays.harmonics), arrays.length[:, :count], arrays.period[:1]
    )


def series(pieces: StepPieces, reach: float) -> DelaySeries | None:
    """Return I - v P Phi(v^p_1, v^p_2, ...) as a power series in v = 1 / nu, P from each part to the next.

    Phi has entire coefficients: its Taylor series come from maps on a circle, by a fast Fourier transform.

    Parameters
    ----------
    pieces : StepPieces
    reach : float
        Largest |v|^p, p the steps of a period or of the longest delay, whichever is longer.

    Returns
    -------
    DelaySeries or None
        None where it would take too many points, or too long.
    """
    backs = [back for back, _ in pieces.delayed]
    common, longest = math.gcd(*backs), max(backs)
    powers = [back // common for back in backs]
    radius = reach ** (common / pieces.slowest)  # of u = v^common
    count, left_out = _points(pieces, powers, radius)
    if count > _MOST_POINTS:
        return None
    u = radius * np.exp(2j * math.pi / count * np.arange(count // 2 + 1))
    factors = [u**power for power in powers]
    real = _real_pieces(pieces, factors)
    if float(whole_period_maps.seconds_needed(real).sum()) > _MOST_SECONDS:
        return None
    sizes = [float(np.abs(factor[0])) for factor in factors]
    uncertainty = pieces.rounding * (1.0 + sum(sizes)) + sum(
        size * missed for size, missed in zip(sizes, pieces.missed, strict=True)
    )
    maps = whole_period_maps.period_maps(real, uncertainty, _ACCURACY, paired=False)
    matrix = maps.matrix * maps.scaling[:, :, None] / maps.scaling[:, None, :]
    errors = maps.error * maps.scaling.max(axis=1) / maps.scaling.min(axis=1)
    if not (np.isfinite(matrix).all() and np.isfinite(errors).all()):
        return None
    n = pieces.order
    values = 0.5 * (matrix[:, :n, :n] + matrix[:, n:, n:] + 1j * (matrix[:, n:, :n] - matrix[:, :n, n:]))
    at_reach = np.fft.hfft(values, count, axis=0) / count  # coefficients times powers of the radius
    # A polynomial through values at roots of unity is off by their errors times Lebesgue's constant, within the circle.
    error = float(errors.max()) * (1.0 + 2.0 / math.pi * math.log(count)) + left_out
    sizes_at_reach = np.linalg.norm(at_reach, axis=(1, 2))
    kept = sizes_at_reach > 0.01 * error / count
    error += float(sizes_at_reach[~kept].sum())
    powers_kept = np.flatnonzero(kept)
    taylor = at_reach[kept] * radius ** -powers_kept.astype(float)[:, None, None]
    moved = np.roll(taylor, n // pieces.parts, axis=1)
    exponents = common * powers_kept + 1
    return DelaySeries(exponents, moved, error * reach ** (1.0 / pieces.slowest), pieces.parts, longest)


def _points(pieces: StepPieces, powers: list[int], radius: float) -> tuple[int, float]:
    """Return at how many points of the circle maps are taken, and what the polynomial through them is off by on it.

    On a circle of radius R maps are at most exp(integral of |A| + sum_j R^p_j |B_j|), with a logarithmic norm for A.
    """
    steady = _growth(pieces.present, symmetric=True)
    grows = [_growth(each, symmetric=False) for _, each in pieces.delayed]
    best = math.inf, math.inf
    for ratio in np.geomspace(1.02, 1e3, 60).tolist():
        growth = steady + sum(g * min((radius * ratio) ** p, 1e6) for g, p in zip(grows, powers, strict=True))
        best = min(best, ((growth - math.log(_LEFT_OUT * (1.0 - 1.0 / ratio))) / math.log(ratio), ratio))
    if best[0] > _MOST_POINTS:
        return _MOST_POINTS + 1, math.inf
    count, ratio = 2 * math.ceil(0.5 * max(best[0], 8.0)), best[1]
    growth = steady + sum(g * (radius * ratio) ** p for g, p in zip(grows, powers, strict=True))
    return count, 2.0 * math.exp(growth - count * math.log(ratio)) / (1.0 - 1.0 / ratio)


def _growth(arrays: PieceArrays, *, symmetric: bool) -> float:
    """Return the integral over the step of a bound of a norm, or of a logarithmic norm where ``symmetric``."""
    total = 0.0
    for j, length in enumerate(arrays.length[0].tolist()):
        mean, waves = arrays.mean[0, j], arrays.harmonics[0, j]
        if symmetric:
            norm = float(np.linalg.eigvalsh(0.5 * (mean + mean.T))[-1])
            waves = 0.5 * (waves + waves.swapaxes(-1, -2))
        else:
            norm = float(np.linalg.norm(mean, 2))
        norm += sum(float(np.linalg.norm(wave, 2)) for wave in waves)
        if arrays.slope is not None:
            norm += length * float(np.linalg.norm(arrays.slope[0, j], 2))
        total += length * norm
    return total


def _real_pieces(pieces: StepPieces, factors: list[Complexes]) -> PieceArrays:
    """Return the systems with each B_j times its factors, (m,), as real ones of twice the order: real parts first."""
    unit = np.ones(len(factors[0]), dtype=complex)
    terms = [(unit, pieces.present), *zip(factors, (each for _, each in pieces.delayed), strict=True)]
    waves = max(each.harmonics.shape[2] for _, each in terms)

    def total(of: Callable[[PieceArrays], Any]) -> Any:
        whole: Any = 0.0
        for factor, each in terms:
            array = of(each)[0]
            turned = np.stack([np.stack([factor.real, -factor.imag]), np.stack([factor.imag, factor.real])])
            block = np.einsum("abm,...ij->m...aibj", turned, array)
            whole = whole + block.reshape(*block.shape[:-4], 2 * array.shape[-2], 2 * array.shape[-1])
        return whole

    def padded(each: PieceArrays) -> Complexes:
        lacking = waves - each.harmonics.shape[2]
        return np.asarray(np.pad(each.harmonics, ((0, 0), (0, 0), (0, lacking), (0, 0), (0, 0))))

    sloped = any(each.slope is not None for _, each in terms)
    slope = total(lambda each: np.zeros_like(each.mean) if each.slope is None else each.slope) if sloped else None
    present = pieces.present
    return PieceArrays(
        total(lambda each: each.mean),
        slope,
        total(padded),
        np.repeat(present.length, unit.size, axis=0),
        np.repeat(present.period, unit.size),
    )
