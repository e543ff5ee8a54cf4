"""Multipliers of a periodic orbit from the maps over the intervals of its mesh, with errors, and their verdict."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import EPS, Floats, norms
from floquetrod.equations import PeriodicSystem
from floquetrod.floquet.multipliers import cyclic_matrix, independent_solutions
from floquetrod.floquet.multipliers.classification import LogDiscs, classify_multipliers
from floquetrod.floquet.multipliers.independent_solutions import Solutions
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.status import Status
from floquetrod.floquet.verdict import Cost
from floquetrod.orbits import split_maps

_LARGEST_CONDITION = 100.0  # of the map over a segment: rounding then costs two digits (a choice)
_SURE = 1e-9  # of logarithms: errors with which nobody needs blocks (a choice)
_NEAR = -3.0  # logarithm of multipliers that may decide
_COARSE = 1e-7  # error of those that counts more than errors of the others (a choice)
_ROUNDED = 1e-3  # error of a logarithm up to which a multiplier may be told to be 1 to rounding (a choice)
_MOST_ROWS = 300  # of the cyclic matrix (a choice: some ten milliseconds)


class Segments(NamedTuple):
    """Maps over the intervals of a mesh, and errors."""

    maps: Floats  # (N, n, n), in the unit of the states
    errors: Floats  # (N, n, n), magnitudes of the errors of the entries
    flow: Floats | None  # (N, n), rates of change at the beginnings of the intervals, of an autonomous system
    trace: float  # integral of that of the derivatives over the period: logarithm of the product of all multipliers
    trace_error: float


class OrbitSpectrum(NamedTuple):
    """Logarithms of the multipliers of an orbit from the maps over its intervals, its own motion's set aside.

    Where all discs are clear of the unit circle they decide by themselves, and the matrix along the orbit, whose
    structure decides about multipliers on the circle, need not be expanded.
    """

    logs: LogDiscs | None  # None where the eigenvectors cannot be computed accurately enough
    solutions: Solutions | None  # of the cyclic matrix, whose Krein signs tell which multipliers stay on the circle
    trivial: float | None  # how far from 1 the multiplier of an autonomous orbit's own motion is; None of a forced one
    intervals: int

    @property
    def status(self) -> Status | None:
        """Verdict where every multiplier is inside the unit circle, or one outside; None where the circle is near."""
        if self.logs is None:
            return None
        if bool((self.logs.lowest > 0.0).any()):
            return "unstable"
        return "stable" if bool((self.logs.highest < 0.0).all()) else None

    def verdict(self, linearised: PeriodicSystem) -> SystemStability:
        """Return the verdict on the orbit, whose linearised system tells how multipliers come in pairs."""
        note, logs = "", self.logs
        if self.trivial is not None:
            note = f"the multiplier 1 of a shift along the orbit is left out, computed to within {self.trivial:.1g}"
            if logs is not None and bool(((np.abs(logs.values) <= logs.radii) & (logs.radii < _ROUNDED)).any()):
                note += "; another one is 1 to rounding, as where orbits form a family with one energy each"
        krein = None
        if self.trivial is None and self.solutions is not None and linearised.structure == "hamiltonian":
            krein = functools.partial(independent_solutions.krein_sign, self.solutions)
        cost = Cost(self.intervals, "intervals")
        verdict = classify_multipliers(
            linearised, "segmented", logs, krein=krein, cost=cost, note=note, are_all=self.trivial is None
        )
        return replace(verdict, along_orbit=True)


def spectrum(segments: Segments, is_hamiltonian: Callable[[], bool]) -> OrbitSpectrum:
    """Return the multipliers of an orbit from the maps over its intervals.

    For an autonomous system the frames move with the orbit, one axis along its motion.  Without this axis the maps act
    across the motion: their multipliers are all but the trivial one, however close to 1 another one is.
    ``is_hamiltonian`` tells the structure of the linearised system, of a forced one with large errors.
    """
    across = segments.maps.shape[1] - (segments.flow is not None)
    if across == 1:
        return OrbitSpectrum(_alone(segments), None, _along(segments), len(segments.maps))
    scales, maps, errors, trivial = _scaled(segments)
    logs, solutions = None, None
    if np.isfinite(maps).all():
        solutions = cyclic_matrix.solutions(*_merged(maps, errors), scales)
        logs = None if solutions is None else independent_solutions.log_discs(solutions, 0.0)
        rough = solutions is None or float(solutions.radii.max()) >= _SURE
        if rough and not (trivial is None and solutions is not None and is_hamiltonian()):
            logs = _least_doubtful(logs, _split(maps, errors))
    return OrbitSpectrum(logs, solutions, trivial, len(segments.maps))


def maps_across(segments: Segments) -> tuple[Floats, Floats]:
    """Return the maps over intervals, of an autonomous system across its motion, and their errors in the 2-norm."""
    return _scaled(segments)[1:3]


def _scaled(segments: Segments) -> tuple[Floats, Floats, Floats, float | None]:
    """Return scales of the states, maps of the scaled states, their errors, and how far the trivial one is."""
    largest = np.abs(segments.maps).max(axis=0) - np.eye(segments.maps.shape[1])
    scales = independent_solutions.balance(np.abs(largest))
    maps = segments.maps * scales / scales[:, None]
    errors = norms(segments.errors * scales / scales[:, None]) + _rounding(maps)
    if segments.flow is None:
        return scales, maps, errors, None
    maps, errors, trivial = _across(maps, errors, segments.flow / scales)
    return np.ones(maps.shape[1]), maps, errors, trivial


def _alone(segments: Segments) -> LogDiscs:
    """Return the logarithm where there is but one multiplier, by Liouville's formula."""
    error = segments.trace_error + 4.0 * EPS * abs(segments.trace)
    return LogDiscs.about(np.array([segments.trace + 0.0j]), np.array([error]), (np.array([0]),))


def _along(segments: Segments) -> float | None:
    """Return how far from 1 the multiplier along an autonomous orbit's motion is; None of a forced system."""
    if segments.flow is None:
        return None
    scales = np.maximum(np.abs(segments.flow).max(axis=0), 1e-300)
    ahead = np.concatenate([segments.flow[1:], segments.flow[:1]]) / scales
    moved = (segments.maps @ segments.flow[:, :, None])[:, :, 0] / scales
    shares = (ahead * moved).sum(axis=1) / (ahead * ahead).sum(axis=1)
    return abs(math.expm1(float(np.log(np.abs(shares)).sum())))


def _split(maps: Floats, errors: Floats) -> LogDiscs:
    """Return logarithms of the multipliers, block by block: each block has errors of its own.

    The unknown multipliers of a block are bounded by the product of the norms of its maps.
    """
    discs = [_of_block(*block) for block in split_maps.blocks(maps, errors)]
    values, low, high, radii = (np.concatenate(parts) for parts in zip(*(each[:4] for each in discs), strict=True))
    starts = np.cumsum([0, *(len(each.values) for each in discs)])
    clusters = (cluster + start for each, start in zip(discs, starts, strict=False) for cluster in each.clusters)
    return LogDiscs(values, low, high, radii, tuple(clusters))


def _of_block(maps: Floats, errors: Floats) -> LogDiscs:
    """Return logarithms of the multipliers of the maps of a block."""
    n = maps.shape[1]
    if n == 1:
        factors = maps[:, 0, 0]
        with np.errstate(divide="ignore"):
            log = float(np.log(np.abs(factors)).sum())
            radius = -float(np.log1p(-np.minimum(errors / np.abs(factors), 1.0)).sum())
        turned = np.array([log + (1j * math.pi if np.count_nonzero(factors < 0.0) % 2 else 0.0)])
        return LogDiscs.about(turned, np.array([radius + EPS * abs(log)]), (np.array([0]),))
    merged = _merged(maps, errors)
    solutions = cyclic_matrix.solutions(*merged, np.ones(n))
    if solutions is not None and np.isfinite(solutions.radii).all():
        return independent_solutions.log_discs(solutions, 0.0)
    largest = np.full(n, float(np.log(norms(merged[0]) + merged[1]).sum()))
    unknown = np.full(n, math.inf)
    return LogDiscs(largest + 0.0j, -unknown, largest, unknown, (np.arange(n),))


def _least_doubtful(whole: LogDiscs | None, split: LogDiscs) -> LogDiscs:
    """Return the logarithms with the smaller errors of those that may decide, of all where both are small."""
    return split if whole is None or _doubt(split) < _doubt(whole) else whole


def _doubt(logs: LogDiscs) -> tuple[float, float]:
    """Return the largest error of multipliers that may decide, 0 where it is small, and the largest of all."""
    deciding = float(logs.radii[logs.high > _NEAR].max(initial=0.0))
    return deciding if deciding > _COARSE else 0.0, float(logs.radii.max())


def _rounding(maps: Floats) -> Floats:
    """Return what rounding makes of maps, computed and multiplied."""
    return np.asarray(8.0 * maps.shape[1] * EPS * norms(maps))


def _across(maps: Floats, errors: Floats, flow: Floats) -> tuple[Floats, Floats, float]:
    """Return the maps across the motion, their errors, and how far from 1 the multiplier along it is."""
    speed = np.linalg.norm(flow, axis=1)
    frames = np.linalg.qr((flow / speed[:, None])[:, :, None], mode="complete")[0]
    ahead = np.roll(frames, -1, axis=0)
    turned = np.swapaxes(ahead, 1, 2) @ maps @ frames
    signs = np.sign((frames[:, :, 0] * flow).sum(axis=1))
    along = turned[:, 0, 0] * speed / np.roll(speed, -1) * signs * np.roll(signs, -1)
    leaks = np.linalg.norm(turned[:, 1:, 0], axis=1)  # which are zero up to errors
    return turned[:, 1:, 1:], errors + leaks, abs(math.expm1(float(np.log(np.abs(along)).sum())))


def _conditions(maps: Floats) -> Floats:
    """Return the condition numbers of maps in the 2-norm, of two rows by norm and determinant."""
    if maps.shape[1] != 2:
        return np.asarray(np.linalg.cond(maps))
    with np.errstate(all="ignore"):
        square = np.square(maps).sum(axis=(1, 2))
        area = 2.0 * np.abs(maps[:, 0, 0] * maps[:, 1, 1] - maps[:, 0, 1] * maps[:, 1, 0])
        ratios = (square + np.sqrt(np.maximum(square - area, 0.0) * (square + area))) / area
    return np.asarray(np.where(area > 0.0, ratios, np.inf))


def _merged(maps: Floats, errors: Floats) -> tuple[Floats, Floats]:
    """Return products of neighbouring maps, as many as are well conditioned, and their errors."""
    limit = _LARGEST_CONDITION
    while len(maps) > 1:
        pairs = len(maps) // 2
        first, second = maps[: 2 * pairs : 2], maps[1::2]
        ahead, behind = errors[: 2 * pairs : 2], errors[1::2]
        products, sizes = second @ first, norms(maps)
        finite = np.isfinite(products).all(axis=(1, 2))
        conditions = np.full(pairs, np.inf)
        conditions[finite] = _conditions(products[finite])
        joined = np.flatnonzero(conditions <= limit)
        if joined.size:
            bounds = behind * sizes[: 2 * pairs : 2] + sizes[1::2] * ahead + behind * ahead + _rounding(products)
        if joined.size == pairs:
            maps, errors = (np.concatenate(x) for x in ((products, maps[2 * pairs :]), (bounds, errors[2 * pairs :])))
        elif joined.size:
            maps, errors = maps.copy(), errors.copy()
            maps[2 * joined], errors[2 * joined] = products[joined], bounds[joined]
            maps, errors = np.delete(maps, 2 * joined + 1, axis=0), np.delete(errors, 2 * joined + 1)
        elif maps.shape[0] * maps.shape[1] > _MOST_ROWS:
            limit *= limit
        else:
            break
    return maps, errors
