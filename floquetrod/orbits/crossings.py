"""What tells that a multiplier crosses the unit circle between two points of a branch, and where."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import EPS, Complexes, Floats
from floquetrod.orbits.orbit import PeriodicOrbit

_LARGEST = 709.0  # logarithm of a multiplier that is not infinite as a double


class OrbitMultipliers(NamedTuple):
    """Multipliers of an orbit, its own motion's set aside, and errors; NaN where they are not known."""

    values: Complexes
    errors: Floats


class Tests(NamedTuple):
    """Functions that change sign along a branch, each smooth, 0 where their sign is not known."""

    turning: float  # rate of the parameter along the branch: changes sign at a fold
    plus: float  # product of 1 - mu over the multipliers, each part of 1 + |mu|: at a fold and at a branch point
    minus: float  # product of 1 + mu likewise: at a period doubling
    pairs: float  # product of 1 - mu_i mu_j over pairs: where a complex pair crosses the circle


Ranks = tuple[int, ...]
"""Places of multipliers in the order of their magnitudes, 0 the largest: that of rank k crosses the circle where the
number outside changes between k and k + 1, however many cross together."""
Test = str | Ranks
"""Name of a test function, or ranks of multipliers, the mean of whose logarithms is one."""


def multipliers_of(orbit: PeriodicOrbit) -> OrbitMultipliers:
    """Return the multipliers of an orbit, the largest first; those near the unit circle as the verdict has them."""
    logs = orbit.spectrum.logs
    if logs is None:
        missing = np.full(orbit.states.shape[1] - (1 if orbit.system.is_autonomous else 0), np.nan)
        return OrbitMultipliers(missing.astype(complex), missing)
    if orbit.spectrum.status is None:
        stability = orbit.stability
        return OrbitMultipliers(np.array(stability.multipliers), np.array(stability.multiplier_errors))
    every = zip(logs.values.tolist(), logs.errors.tolist(), strict=True)
    ordered = sorted(every, key=lambda each: (-each[0].real if math.isfinite(each[1]) else math.inf, each[0].imag))
    values, errors = zip(*(_multiplier(log, error) for log, error in ordered), strict=True) if ordered else ((), ())
    return OrbitMultipliers(np.array(values, dtype=np.complex128), np.array(errors, dtype=np.float64))


def _multiplier(log: complex, error: float) -> tuple[complex, float]:
    """Return a multiplier and its error from its logarithm and the error of that; NaN where this is not known."""
    if not math.isfinite(error):
        return complex(math.nan, 0.0), math.inf
    size = math.exp(log.real) if log.real < _LARGEST else math.inf
    blur = size * math.expm1(min(error + 4.0 * EPS * abs(log), 700.0))
    if abs(log.imag) >= math.pi * (1.0 - EPS):  # the half turn is exact, its sine is not
        return complex(-size, 0.0), blur
    return complex(size * math.cos(log.imag), size * math.sin(log.imag) if log.imag else 0.0), blur


def tests(multipliers: OrbitMultipliers, turning: float) -> Tests:
    """Return the test functions, from multipliers and the rate of the parameter; 0 where an error covers the sign."""
    return Tests(turning, *(_sure_product(*_factors(multipliers, name)) for name in ("plus", "minus", "pairs")))


def outside(multipliers: OrbitMultipliers) -> int | None:
    """Return how many multipliers lie outside the unit circle; None where an error covers the circle."""
    sizes = np.abs(multipliers.values)
    if not ((sizes - multipliers.errors > 1.0) | (sizes + multipliers.errors < 1.0)).all():
        return None
    return int(np.count_nonzero(sizes > 1.0))


def of_ranks(multipliers: OrbitMultipliers, ranks: Ranks) -> OrbitMultipliers:
    """Return the multipliers of these ranks."""
    order = np.argsort(-np.abs(multipliers.values), kind="stable")[list(ranks)]
    return OrbitMultipliers(multipliers.values[order], multipliers.errors[order])


def value(multipliers: OrbitMultipliers, test: Test) -> float:
    """Return a test function, whether or not its sign is known."""
    if not isinstance(test, str):
        return float(np.log(np.maximum(np.abs(of_ranks(multipliers, test).values), 1e-300)).mean())
    return _product(_factors(multipliers, test)[0])


def doubt(multipliers: OrbitMultipliers, test: Test) -> float:
    """Return the error of a test function."""
    if not isinstance(test, str):
        values, errors = of_ranks(multipliers, test)
        return float((errors / np.abs(values)).mean())
    x, errors = _factors(multipliers, test)
    parts, blurs = np.abs(1.0 - x) / (1.0 + np.abs(x)), errors / (1.0 + np.abs(x))
    return float(sum(blurs[k] * np.prod(np.delete(parts, k)) for k in range(len(x))))


def _factors(multipliers: OrbitMultipliers, test: str) -> tuple[Complexes, Floats]:
    """Return the numbers that a test function compares with 1, and their errors."""
    errors = multipliers.errors
    values = np.where(np.isinf(errors), 0.0, multipliers.values)  # beside the largest ones
    if test == "plus":
        return values, errors
    if test == "minus":
        return -values, errors
    if len(values) < 2:
        return values[:0], errors[:0]
    i, j = np.triu_indices(len(values), 1)
    sizes = np.abs(values)
    with np.errstate(over="ignore", invalid="ignore"):  # of errors that are not known
        return values[i] * values[j], sizes[i] * errors[j] + sizes[j] * errors[i] + errors[i] * errors[j]


def _product(x: Complexes) -> float:
    """Return the product of 1 - x, each part of 1 + |x|."""
    return float(np.prod((1.0 - x) / (1.0 + np.abs(x))).real)


def _sure_product(x: Complexes, errors: Floats) -> float:
    """Return the product of 1 - x likewise, 0 where an error covers a factor, and of none."""
    product = 1.0 + 0.0j
    for each, error in zip(x.tolist(), errors.tolist(), strict=True):
        if not abs(1.0 - each) > error:
            return 0.0
        product *= (1.0 - each) / (1.0 + abs(each))
    return product.real if len(x) else 0.0


def nearest(multipliers: OrbitMultipliers, kind: str) -> int:
    """Return which multiplier is nearest to where a kind of point has one."""
    values = multipliers.values
    if kind == "period doubling":
        return int(np.abs(values + 1.0).argmin())
    if kind == "Neimark-Sacker":
        return int(np.where(values.imag > 0.0, np.abs(np.abs(values) - 1.0), np.inf).argmin())
    return int(np.abs(values - 1.0).argmin())
