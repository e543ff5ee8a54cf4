"""A semi-discretisation of milling with uneven teeth, of numpy alone, which shares nothing with the package.

A turn has equal steps.  Over each the matrices are averaged over the step and the delayed surface is constant
(T. Insperger and G. Stepan, Semi-Discretization for Time-Delay Systems, Springer 2011), taken by cubic interpolation in
its middle.  The surface that a tooth cuts is the deepest of all that the last turn left at its angle, and its edge a
sum over its slices.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

_FINE = 24  # angles in each step at which it is asked what a tooth cuts


class Cut(NamedTuple):
    """A cutter and a cut, in SI units; ``pitch`` is the angle of every tooth to the one before it."""

    modes: list[tuple[int, float, float, float]]  # axis, 0 or 1, rad/s, damping ratio, kg
    pitch: list[float]
    runout: list[float]
    feed: float  # per tooth
    coefficients: tuple[float, float]  # tangential, radial
    entry: float
    leave: float
    lag: float  # of the upper end of the edge, in rad
    speed: float
    depth: float


def growth_in_a_turn(cut: Cut, steps: int) -> float:
    """Return the logarithm of the largest multiplier of a turn."""
    step = 2.0 * math.pi / cut.speed / steps
    axis = [mode[0] for mode in cut.modes]
    omega, ratio, mass = (np.array([mode[k] for mode in cut.modes]) for k in (1, 2, 3))
    spans, cutting = _cutting(cut, steps)
    force = cut.depth * cutting[:, :, axis][:, :, :, axis] / mass[:, None]  # (delay, step, n, n)
    n = len(mass)
    augmented = np.zeros((steps, 3 * n, 3 * n))
    augmented[:, :n, n : 2 * n] = np.eye(n)
    augmented[:, n : 2 * n, :n] = -np.diag(omega**2) - force.sum(axis=0)
    augmented[:, n : 2 * n, n : 2 * n] = -np.diag(2.0 * ratio * omega)
    augmented[:, n : 2 * n, 2 * n :] = np.eye(n)
    over_step = _exponential(augmented * step)[:, : 2 * n]
    places = [_places(span / (2.0 * math.pi) * steps - 0.5) for span in spans]
    used = [force[d].any(axis=(1, 2)) for d in range(len(spans))]

    def turned(history: Any) -> Any:
        """Return what a turn makes of q and q' now and of q at the last steps: rows q(0), q(-1), ..., then q'(0)."""
        past = np.concatenate([history[:-1][::-1], np.zeros((steps, *history.shape[1:]))])
        moving, first = history[-1], steps + 2
        for i in range(steps):
            at = first + i
            surface = 0.0
            for d, (whole, weights) in enumerate(places):
                if used[d][i]:
                    rows = past[at - whole - 2 : at - whole + 2]
                    surface = surface + force[d, i] @ np.tensordot(weights, rows, axes=1)
            state = np.concatenate([past[at], moving, surface + np.zeros_like(moving)])
            new = over_step[i] @ state
            past[at + 1], moving = new[:n], new[n:]
        return np.concatenate([past[-(steps + 3) :][::-1], moving[None]])

    width = 14
    vectors = np.random.default_rng(3).standard_normal((steps + 4, n, width))
    before, log = np.inf, 0.0
    for _ in range(60):
        flat = np.linalg.qr(vectors.reshape(-1, width))[0]
        made = turned(flat.reshape(vectors.shape))
        values = np.linalg.eigvals(flat.T @ made.reshape(-1, width))
        log = float(np.log(np.abs(values).max()))
        if abs(log - before) < 1e-8:
            break
        before, vectors = log, made
    return log


def _places(steps: float) -> tuple[int, Any]:
    """Return a delay's whole steps, and the weights of q two steps, one and none beyond them, and one before."""
    whole = math.floor(steps)
    x = 2.0 - (steps - whole)  # between the rows 1 and 2 of four at 0 to 3
    nodes = [0.0, 1.0, 2.0, 3.0]
    weights = [math.prod((x - b) / (a - b) for b in nodes if b != a) for a in nodes]
    return whole, np.array(weights)


def _cutting(cut: Cut, steps: int) -> tuple[list[float], Any]:
    """Return delays as angles, and of each the averages over steps of the forces of a displaced chip, in Pa."""
    teeth, fine = len(cut.pitch), steps * _FINE
    angles = (np.arange(fine) + 0.5) * 2.0 * math.pi / fine
    tangential, radial = cut.coefficients
    chips = np.stack([np.sin(angles), np.cos(angles)])
    forces = np.stack(
        [tangential * np.cos(angles) + radial * np.sin(angles), radial * np.cos(angles) - tangential * np.sin(angles)]
    )
    unit = forces[:, None] * chips * ((angles > cut.entry) & (angles < cut.leave))
    parts: dict[float, Any] = {}
    for tooth in range(teeth):
        spans = [sum(cut.pitch[(tooth + k) % teeth] for k in range(back)) for back in range(1, teeth + 1)]
        thick = np.stack(
            [
                teeth * cut.feed * span / (2.0 * math.pi) * np.sin(angles)
                + cut.runout[tooth]
                - cut.runout[(tooth + back) % teeth]
                for back, span in enumerate(spans, 1)
            ]
        )
        least = thick.argmin(axis=0)
        ahead = sum(cut.pitch[:tooth])
        for back, span in enumerate(spans):
            own = unit * ((least == back) & (thick.min(axis=0) > 0.0))
            if own.any():
                # The tooth is at angle + ahead, and its edge lags behind.
                key = next((old for old in parts if abs(old - span) < 1e-9), span)
                parts[key] = parts.get(key, 0.0) + _over_edge(own, ahead, cut.lag, steps)
    return list(parts), np.stack([np.moveaxis(values, -1, 0) for values in parts.values()])


def _over_edge(own: Any, ahead: float, lag: float, steps: int) -> Any:
    """Return means over steps, and over the edge of a tooth that is ahead, by sums over fine angles."""
    fine = own.shape[-1]
    sums = np.concatenate([np.zeros((2, 2, 1)), np.cumsum(own, axis=-1)], axis=-1)
    total = sums[..., -1]

    def up_to(place: Any) -> Any:
        turns = np.floor(place / fine)
        inside = place - turns * fine
        return np.stack(
            [
                np.stack([turns * total[i, j] + np.interp(inside, np.arange(fine + 1), sums[i, j]) for j in range(2)])
                for i in range(2)
            ]
        )

    shift = ahead / (2.0 * math.pi) * fine
    if lag == 0.0:
        ends = np.arange(steps + 1) * (fine / steps) + shift
        return np.diff(up_to(ends)) * steps / fine
    width = lag / (2.0 * math.pi) * fine
    middles = np.arange(fine) + 0.5 + shift
    means = (up_to(middles) - up_to(middles - width)) / width
    return means.reshape(2, 2, steps, -1).mean(axis=-1)


def _exponential(matrices: Any) -> Any:
    """Return the exponentials of matrices (k, m, m): Taylor's series of a sixteenth, squared."""
    small = matrices / 16.0
    term = result = np.broadcast_to(np.eye(matrices.shape[-1]), matrices.shape)
    for k in range(1, 13):
        term = term @ small / k
        result = result + term
    for _ in range(4):
        result = result @ result
    return result
