"""Maps over the intervals of a period split into blocks, whose solutions grow at different rates.

In frames of orthogonal iteration, faster growing directions first, every map is block triangular up to errors,

    T_i = [[B_i, C_i], [E_i, D_i]].

A plane y = X_i x, invariant under the maps, obeys X_(i+1) (B_i + C_i X_i) = E_i + D_i X_i.  Where |X_0| <= x_0 implies
|X_N| <= x_0 by the bound

    x_(i+1) = (e_i + d_i x_i) b_i / (1 - b_i c_i x_i),    b_i = |B_i^-1|, c_i = |C_i|, d_i = |D_i|, e_i = |E_i|,

such a plane exists by Brouwer's theorem, and the multipliers of the T_i are exactly the multipliers of B_i + C_i X_i
together with the multipliers of D_i - X_(i+1) C_i.  The blocks B_i and D_i therefore stand for both, with errors larger
by c_i x_i and x_(i+1) c_i, and a multiplier of 1e-200 has its own error beside a multiplier of 1.2 (U. M. Ascher,
R. M. M. Mattheij and R. D. Russell, doi:10.1137/1.9781611971231, chapter 3).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import EPS, Floats

_ROUNDS = 3  # of orthogonal iteration (a choice)
_APART = 1.0  # difference of logarithms of multipliers from which a split is tried (a choice)
_TRIALS = 6  # of x_0, each twice what the bound makes of the one before (a choice)


class Block(NamedTuple):
    """Maps over intervals (N, k, k) with multipliers of their own, and bounds of their errors in the 2-norm (N,)."""

    maps: Floats
    errors: Floats


def blocks(maps: Floats, errors: Floats) -> list[Block]:
    """Return blocks of maps that have all multipliers of the maps (N, n, n) between them, the fastest growing first.

    One block where nothing grows faster than the rest by more than errors mix.
    """
    turned, growth = _triangular(maps)
    rounding = 8.0 * maps.shape[1] * EPS * np.linalg.norm(maps, axis=(1, 2))
    return _divided(Block(turned, errors + rounding), growth)


def _divided(block: Block, growth: Floats) -> list[Block]:
    """Return the blocks of one block of triangular maps, cut where growth differs most and a cut is sure."""
    gaps = growth[:-1] - growth[1:]
    for cut in np.argsort(-gaps).tolist():
        if gaps[cut] < _APART:
            break
        split = _split(*block, cut + 1)
        if split is not None:
            return [*_divided(split[0], growth[: cut + 1]), *_divided(split[1], growth[cut + 1 :])]
    return [block]


def _triangular(maps: Floats) -> tuple[Floats, Floats]:
    """Return the maps in frames of orthogonal iteration, and the logarithms of growth over the period along each axis.

    The last map leads to the first frame, which the iteration returns to up to errors: they stay below the diagonal.
    """
    frames, logs = _iterated_plane(maps) if maps.shape[1] == 2 else _iterated(maps)
    return np.swapaxes(np.roll(frames, -1, axis=0), 1, 2) @ maps @ frames, logs.sum(axis=0)


def _iterated(maps: Floats) -> tuple[Floats, Floats]:
    """Return the frames (N, n, n) of orthogonal iteration, and the logarithms (N, n) of growth along their axes."""
    count, n, _ = maps.shape
    frames, logs = np.empty((count, n, n)), np.empty((count, n))
    frame = np.eye(n)
    for _ in range(_ROUNDS):
        for i in range(count):
            frames[i] = frame
            frame, triangle = np.linalg.qr(maps[i] @ frame)
            logs[i] = np.log(np.maximum(np.abs(np.diag(triangle)), 1e-300))
    return frames, logs


def _iterated_plane(maps: Floats) -> tuple[Floats, Floats]:
    """Return the same of maps of the plane, whose frames are turned by one angle each, in plain numbers."""
    axes: list[tuple[float, float]] = []
    sizes: list[float] = []
    x, y = 1.0, 0.0
    entries = maps.reshape(-1, 4).tolist()
    for _ in range(_ROUNDS):
        axes, sizes = [], []
        for a, b, c, d in entries:
            axes.append((x, y))
            u, v = a * x + b * y, c * x + d * y
            size = math.hypot(u, v)
            sizes.append(size or 1e-300)
            if size:
                x, y = u / size, v / size
    first, grown = np.array(axes), np.array(sizes)
    areas = np.abs(maps[:, 0, 0] * maps[:, 1, 1] - maps[:, 0, 1] * maps[:, 1, 0])
    frames = np.stack([first, np.stack([-first[:, 1], first[:, 0]], axis=1)], axis=2)
    return frames, np.log(np.maximum(np.stack([grown, areas / grown], axis=1), 1e-300))


def _split(turned: Floats, errors: Floats, first: int) -> tuple[Block, Block] | None:
    """Return the leading block, of the ``first`` axes, and the trailing one; None if no invariant plane is proved."""
    leading, coupling = turned[:, :first, :first], turned[:, :first, first:]
    leak, trailing = turned[:, first:, :first], turned[:, first:, first:]
    least = np.linalg.svd(leading, compute_uv=False)[:, -1] - errors
    if not (least > 0.0).all():
        return None
    inverse = 1.0 / least
    norm_c, norm_d, norm_e = (np.linalg.norm(part, 2, axis=(1, 2)) + errors for part in (coupling, trailing, leak))
    tilt = np.zeros(len(turned) + 1)
    for _ in range(_TRIALS):
        for i, (b, c, d, e) in enumerate(zip(inverse, norm_c, norm_d, norm_e, strict=True)):
            room = 1.0 - b * c * tilt[i]
            if room <= 0.0:
                return None
            tilt[i + 1] = (e + d * tilt[i]) * b / room
        if tilt[-1] <= tilt[0]:
            return Block(leading, errors + norm_c * tilt[:-1]), Block(trailing, errors + norm_c * tilt[1:])
        tilt[0] = 2.0 * tilt[-1]
    return None
