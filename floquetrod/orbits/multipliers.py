"""Multipliers of a periodic orbit from the maps over the intervals of its mesh, with errors, and their verdict."""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import EPS, Floats, norms
from floquetrod.equations import PeriodicSystem
from floquetrod.floquet.systems import cyclic, independent_solutions
from floquetrod.floquet.systems.classification import classify_multipliers
from floquetrod.floquet.systems.independent_solutions import Solutions
from floquetrod.floquet.systems.result import SystemStability
from floquetrod.floquet.verdict import Cost

_LARGEST_CONDITION = 100.0  # of the map over a segment: rounding then costs two digits (a choice)
_SURE = 1e-9  # of logarithms: errors with which nobody needs other coordinates (a choice)
_NEAR = -3.0  # logarithm of multipliers that may decide
_COARSE = 1e-7  # error of those that counts more than errors of the others (a choice)
_MOST_ROWS = 300  # of the cyclic matrix (a choice: some ten milliseconds)


class Segments(NamedTuple):
    """Maps over the intervals of a mesh, and errors."""

    maps: Floats  # (N, n, n), in the unit of the states
    errors: Floats  # (N, n, n), magnitudes of the errors of the entries
    flow: Floats | None  # (N, n), rates of change at the beginnings of the intervals, of an autonomous system
    trace: float  # integral of that of the derivatives over the period: logarithm of the product of all multipliers
    trace_error: float


class OrbitVerdict(NamedTuple):
    """The verdict, and how far from 1 the multiplier of an autonomous orbit's own motion is; None of a forced one."""

    stability: SystemStability
    trivial: float | None


def judged(linearised: PeriodicSystem, segments: Segments) -> OrbitVerdict:
    """Return the verdict on an orbit from the maps over its intervals.

    Of an autonomous system in frames that move with the orbit, one axis along its motion: what is left without that
    axis are maps across the motion, whose multipliers are all others, however close to 1 one of them is.
    """
    scales, maps, errors, trivial = _scaled(segments)
    found: Solutions | None
    if maps.shape[1] == 1:
        found = _alone(segments)
    else:
        maps, errors = _merged(maps, errors)
        found = _solutions(maps, errors, scales) if np.isfinite(maps).all() else None
    cost = Cost(len(segments.maps), "intervals")
    logs = None if found is None else independent_solutions.log_discs(found, 0.0)
    krein = None
    if segments.flow is None and found is not None and linearised.structure == "hamiltonian":
        krein = functools.partial(independent_solutions.krein_sign, found)
    note = ""
    if trivial is not None:
        note = f"the multiplier 1 of a shift along the orbit is left out, computed to within {trivial:.1g}"
        if logs is not None and bool((np.abs(logs.values) <= logs.radii).any()):
            note += "; another one is 1 to rounding, as where orbits form a family with one energy each"
    stability = classify_multipliers(
        linearised,
        "segmented",
        logs,
        krein=krein,
        cost=cost,
        note=note,
        are_all=trivial is None,
    )
    return OrbitVerdict(stability, trivial)


def maps_across(segments: Segments) -> tuple[Floats, Floats]:
    """Return the maps over intervals, of an autonomous system across its motion, and their errors in the 2-norm."""
    return _scaled(segments)[1:3]


def _scaled(segments: Segments) -> tuple[Floats, Floats, Floats, float | None]:
    """Return scales of the states, maps of what is divided by them, their errors, and how far the trivial one is."""
    largest = np.abs(segments.maps).max(axis=0) - np.eye(segments.maps.shape[1])
    scales = independent_solutions.balance(np.abs(largest))
    maps = segments.maps * scales / scales[:, None]
    errors = norms(segments.errors * scales / scales[:, None]) + _rounding(maps)
    if segments.flow is None:
        return scales, maps, errors, None
    maps, errors, trivial = _across(maps, errors, segments.flow / scales)
    return np.ones(maps.shape[1]), maps, errors, trivial


def _alone(segments: Segments) -> Solutions:
    """Return the one solution where there is but one multiplier, by Liouville's formula."""
    error = segments.trace_error + 4.0 * EPS * abs(segments.trace)
    return Solutions(np.array([segments.trace + 0.0j]), np.array([error]), np.ones((1, 1), dtype=np.complex128))


def _solutions(maps: Floats, errors: Floats, scales: Floats) -> Solutions | None:
    """Return independent Floquet solutions, their states at the beginning of the mesh times ``scales``.

    In even coordinates where those say more: they help what decays unevenly, and cost digits where motion turns.
    """
    plain = cyclic.solutions(maps, errors, scales)
    if len(maps) == 1 or (plain is not None and float(plain.radii.max()) < _SURE):
        return plain
    even = cyclic.evened(maps, errors)
    found = cyclic.solutions(even.maps, even.errors, np.ones(len(scales)))
    if found is None or (plain is not None and _doubt(plain) <= _doubt(found)):
        return plain
    states = scales[:, None] * (even.basis @ found.states)
    return found._replace(states=states / np.linalg.norm(states, axis=0))


def _doubt(found: Solutions) -> tuple[float, float]:
    """Return the largest error of multipliers that may decide, 0 where it is small, and that of all."""
    deciding = float(found.radii[found.logs.real > _NEAR].max(initial=0.0))
    return deciding if deciding > _COARSE else 0.0, float(found.radii.max())


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


def _merged(maps: Floats, errors: Floats) -> tuple[Floats, Floats]:
    """Return products of neighbouring maps, as many as are well conditioned, and their errors."""
    limit = _LARGEST_CONDITION
    while len(maps) > 1:
        pairs = len(maps) // 2
        first, second = maps[: 2 * pairs : 2], maps[1::2]
        ahead, behind = errors[: 2 * pairs : 2], errors[1::2]
        products = second @ first
        finite = np.isfinite(products).all(axis=(1, 2))
        conditions = np.full(pairs, np.inf)
        conditions[finite] = np.linalg.cond(products[finite])
        joined = np.flatnonzero(conditions <= limit)
        if joined.size:
            bounds = behind * norms(first) + norms(second) * ahead + behind * ahead + _rounding(products)
            maps, errors = maps.copy(), errors.copy()
            maps[2 * joined], errors[2 * joined] = products[joined], bounds[joined]
            maps, errors = np.delete(maps, 2 * joined + 1, axis=0), np.delete(errors, 2 * joined + 1)
        elif maps.shape[0] * maps.shape[1] > _MOST_ROWS:
            limit *= limit
        else:
            break
    return maps, errors
