"""A mean, a trend and a Fourier series of unknown period fitted to samples, evenly spaced or not, by least squares."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from floquetrod._util.arrays import EPS, Complexes, Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent

_BLOCK = 4096  # samples whose basis functions fit into a cache
_SOME = 1 << 16  # samples of a long record that tell where its fit is (a choice)
_LONG = 4 * _SOME  # samples from which a record is long (a choice)
_EVEN = 1e-3  # of an interval that evenly spaced times may be off: no spectrum shows it
_STEPS = 40  # of Newton at most; four are usual
_ROUNDING = 4.0 * EPS  # of a frequency, relative to it


@dataclass(frozen=True, eq=False)
class Samples(ByContent):
    """Samples in the units of the fit: times from -1 to 1, values about 0 of size 1."""

    tau: Floats
    values: Floats
    centre: float
    half: float
    offset: float
    scale: float
    interval: float
    """Median distance of the times, in units of tau."""

    @classmethod
    def of(cls, time: Floats, force: Floats) -> Samples:
        """Return increasing times and forces, which are not all the same, in the units of the fit."""
        centre, half = 0.5 * (time[0] + time[-1]), 0.5 * (time[-1] - time[0])
        offset = 0.5 * (force.max() + force.min())
        scale = 0.5 * (force.max() - force.min())
        tau = (time - centre) / half
        return cls(tau, (force - offset) / scale, centre, half, offset, scale, float(np.median(np.diff(tau))))

    @cached_property
    def is_even(self) -> bool:
        """Whether the times are evenly spaced."""
        even = np.linspace(-1.0, 1.0, self.tau.size)
        return float(np.abs(self.tau - even).max()) <= _EVEN * self.interval

    @property
    def is_long(self) -> bool:
        """Whether some of the samples are enough to tell where the fit is."""
        return self.tau.size >= _LONG

    @cached_property
    def some(self) -> Samples:
        """Of a long record one sample, at random, of each of many parts of equal size; else the samples themselves.

        What is above half of the sampling rate of so few is not folded down, as it would be at equal distances.
        """
        if not self.is_long:
            return self
        ends = np.linspace(0, self.tau.size, _SOME + 1).astype(int)
        chosen = np.random.default_rng(0).integers(ends[:-1], ends[1:])
        return replace(self, tau=self.tau[chosen], values=self.values[chosen])

    @property
    def highest(self) -> float:
        """Largest frequency, in periods per record, that is distinct from its alias above half the sampling rate."""
        return max(0.0, 1.0 / self.interval - 1.0)

    @property
    def rounding(self) -> float:
        """Noise that the rounding of times and forces makes."""
        return 8.0 * EPS * (1.0 + abs(self.offset) / self.scale)


@dataclass(frozen=True, eq=False)
class Fit(ByContent):
    """A least-squares fit in the units of `Samples`, its phases from tau = 0."""

    omega: float  # angular frequency in tau
    numbers: tuple[int, ...]  # harmonics fitted
    coefficients: Floats  # mean, trend (0 where not fitted), then the cosines and the sines of the harmonics
    covariance: Floats  # of the coefficients and, last, of omega
    squares: float  # sum of the squared residuals
    free: int  # samples less unknowns

    @property
    def amplitudes(self) -> Complexes:
        """Complexes amplitudes c_h of Re sum c_h exp(i h omega tau)."""
        cosines, sines = self.coefficients[2:].reshape(2, -1)
        return cosines - 1j * sines

    @property
    def frequency_error(self) -> float:
        """Standard error of omega."""
        return math.sqrt(self.covariance[-1, -1])

    @property
    def variance(self) -> float:
        """Variance of the noise."""
        return self.squares / self.free

    def values(self, tau: Floats) -> Floats:
        """Return the fit at times."""
        result: Floats = self.coefficients[0] + self.coefficients[1] * tau
        return result + series(self.omega * tau, self.numbers, self.amplitudes)

    def log_chances(self) -> Floats:
        """Return for each harmonic the logarithm of the chance that noise alone makes it as large (F test)."""
        many = len(self.numbers)
        logs = np.empty(many)
        for place in range(many):
            pair = [2 + place, 2 + many + place]
            values = self.coefficients[pair]
            ratio = 0.5 * float(values @ np.linalg.solve(self.covariance[np.ix_(pair, pair)], values))
            logs[place] = -0.5 * self.free * math.log1p(2.0 * ratio / self.free)
        return logs

    def trend_chance(self) -> float:
        """Return the logarithm of a bound on the chance that noise alone makes a trend as large."""
        ratio = self.coefficients[1] ** 2 / self.covariance[1, 1]
        return -0.5 * self.free * math.log1p(ratio / self.free)

    def with_noise(self, factors: Floats) -> Fit:
        """Return the fit with noise stronger by these factors about frequency 0 and about each harmonic.

        A harmonic tells about the frequency as the square of its number times its size.
        """
        weights = (np.array(self.numbers) * np.abs(self.amplitudes)) ** 2
        moved = math.sqrt(float(weights @ factors[1:] ** 2 / weights.sum())) if self.numbers else 1.0
        every = np.concatenate([factors[[0, 0]], factors[1:], factors[1:], [moved]])
        return replace(self, covariance=self.covariance * np.outer(every, every))

    def sizes(self) -> tuple[Floats, Floats]:
        """Return the sizes of the harmonics and their standard errors."""
        many = len(self.numbers)
        pairs = self.coefficients[2:].reshape(2, many)
        sizes = np.hypot(*pairs)
        block = self.covariance[2:-1, 2:-1].reshape(2, many, 2, many)
        each = block[:, range(many), :, range(many)]  # (harmonic, 2, 2)
        along = np.divide(pairs, sizes, out=np.full_like(pairs, math.sqrt(0.5)), where=sizes > 0.0)
        return sizes, np.sqrt(np.einsum("ah,hab,bh->h", along, each, along))


def series(angle: Floats, numbers: tuple[int, ...], amplitudes: Complexes) -> Floats:
    """Return Re sum c_h exp(i h angle)."""
    flat = np.asarray(angle, dtype=float)
    result = np.zeros(flat.shape)
    wanted = dict(zip(numbers, amplitudes, strict=True))
    for start in range(0, flat.size, _BLOCK):
        turn = np.exp(1j * flat.reshape(-1)[start : start + _BLOCK])
        total = np.zeros_like(turn)
        for number in range(max(numbers, default=0), 0, -1):  # Horner's scheme
            total += wanted.get(number, 0.0)
            total *= turn
        result.reshape(-1)[start : start + _BLOCK] = total.real
    return result


# --- least squares ---


class _Sums(NamedTuple):
    """Sums over the samples where a fit is.

    Products of the derivatives by the unknowns, omega last, with each other (``gram``) and with the residual
    (``moments``), the residual squared, and times the second derivatives by omega and each unknown (``bend``).
    """

    gram: Floats
    moments: Floats
    squares: float
    bend: Floats


def _sums(samples: Samples, omega: float, numbers: tuple[int, ...], coefficients: Floats) -> _Sums:
    """Return the sums for mean, trend, cosines, sines and omega."""
    many, order = len(numbers), np.array(numbers)
    highest = max(numbers)
    cosines, sines = coefficients[2 : 2 + many], coefficients[2 + many :]
    slope = np.concatenate([order * sines, -order * cosines])  # of the waves by omega tau, in cosines and sines
    bend = -np.concatenate([order**2 * cosines, order**2 * sines])
    gram, moments, squares = np.zeros((2 * many + 3,) * 2), np.zeros(2 * many + 3), 0.0
    pulls = np.zeros(2 * many)
    bent = 0.0
    for start in range(0, samples.tau.size, _BLOCK):
        tau = samples.tau[start : start + _BLOCK]
        turn = np.exp(1j * omega * tau)
        basis = np.empty((2 * many + 3, tau.size))
        basis[0], basis[1] = 1.0, tau
        waves, power, place = basis[2:-1], np.ones_like(turn), 0
        for k in range(1, highest + 1):
            power *= turn
            if k == numbers[place]:
                waves[place], waves[many + place] = power.real, power.imag
                place += 1
        basis[-1] = tau * (slope @ waves)
        residual = samples.values[start : start + _BLOCK] - coefficients @ basis[:-1]
        gram += basis @ basis.T
        moments += basis @ residual
        squares += float(residual @ residual)
        pulls += waves @ (tau * residual)
        bent += float((tau**2 * residual) @ (bend @ waves))
    turned = np.concatenate([-order * pulls[many:], order * pulls[:many]])
    return _Sums(gram, moments, squares, np.concatenate([[0.0, 0.0], turned, [bent]]))


def fit(
    samples: Samples, omega: float, numbers: tuple[int, ...], *, trend: bool = True, precision: float = 1e-4
) -> Fit | None:
    """Return the fit of some harmonics that is nearest to ``omega``, None where the steps do not settle.

    Newton's method for the frequency and the coefficients together, Gauss and Newton's where the squares are not
    convex, until a step moves the frequency by ``precision`` of its error at most.  A step moves the phase of the
    highest harmonic at the ends of the record by a radian at most.
    """
    # Least squares of c_0 + c_1 tau + sum_k (a_k cos k w tau + b_k sin k w tau) to a record, w = omega unknown:
    # coefficients holds c_0, c_1, all a_k, then all b_k; with omega it is the last unknown.  The first step is linear,
    # of the coefficients alone: until they are known the frequency has no gradient.  Covariance of a converged fit:
    # (squares / free) times the inverse of the Gram matrix of all unknowns, ``free`` the samples less the unknowns;
    # rounding of samples is its least.
    size = 2 * len(numbers) + 2
    free = samples.tau.size - size - trend
    if free < 1:
        return None
    coefficients = np.zeros(size)
    fitted = [i for i in range(size) if trend or i != 1]
    settled = moving = False
    for _ in range(_STEPS):
        sums = _sums(samples, omega, numbers, coefficients)
        chosen = [*fitted, size] if moving else fitted
        inverse = _inverse(sums.gram[np.ix_(chosen, chosen)])
        if inverse is None:
            return None
        if settled:
            covariance = np.zeros((size + 1, size + 1))
            variance = max(sums.squares / free, samples.rounding**2)
            covariance[np.ix_(chosen, chosen)] = variance * inverse
            covariance[-1, -1] += (_ROUNDING * omega) ** 2
            return Fit(omega, numbers, coefficients, covariance, variance * free, free)
        step = np.zeros(size + 1)
        step[chosen] = _newton(sums, chosen, inverse) @ sums.moments[chosen]
        coefficients = coefficients + step[:-1]
        if moving:
            turned = float(np.clip(step[-1], -1.0 / max(numbers), 1.0 / max(numbers)))
            omega += turned
            error = math.sqrt(max(sums.squares / free, samples.rounding**2) * inverse[-1, -1])
            settled = abs(turned) <= max(precision * error, _ROUNDING * omega)
            if not 0.0 < omega * max(numbers) < math.pi / samples.interval:
                return None
        moving = True
    return None


def level(samples: Samples, omega: float, *, trend: bool) -> Fit:
    """Return the fit of a mean, and of a trend where wanted, without harmonics; ``omega`` is taken as exact."""
    fitted = [0, 1] if trend else [0]
    basis = np.array([np.ones_like(samples.tau), samples.tau])[fitted]
    inverse = np.linalg.inv(basis @ basis.T)
    coefficients, covariance = np.zeros(2), np.zeros((3, 3))
    coefficients[fitted] = inverse @ (basis @ samples.values)
    free = samples.tau.size - len(fitted)
    residual = samples.values - coefficients[fitted] @ basis
    variance = max(float(residual @ residual) / free, samples.rounding**2)
    covariance[np.ix_(fitted, fitted)] = variance * inverse
    return Fit(omega, (), coefficients, covariance, variance * free, free)


def freed(samples: Samples, found: Fit) -> tuple[Floats, Floats, Fit, Floats]:
    """Return how far each harmonic's frequency, free, is from its multiple of omega, with a covariance.

    And the fit with the squares that are then left, and its residual.
    """
    # Linear least squares about the fit: harmonic k at the frequency k omega + d has, to first order in d, the further
    # term d tau slope_k(tau), where slope_k is its derivative by the angle k omega tau.
    many = len(found.numbers)
    size = 3 * many + 2
    gram, moments = np.zeros((size, size)), np.zeros(size)
    residual = samples.values - found.values(samples.tau)
    blocks = [slice(start, start + _BLOCK) for start in range(0, samples.tau.size, _BLOCK)]
    for block in blocks:
        basis = _freed_basis(found, samples.tau[block])
        gram += basis @ basis.T
        moments += basis @ residual[block]
    scale = 1.0 / np.sqrt(gram.diagonal())
    inverse = np.linalg.pinv(gram * np.outer(scale, scale), hermitian=True) * np.outer(scale, scale)
    step = inverse @ moments
    for block in blocks:
        residual[block] -= step @ _freed_basis(found, samples.tau[block])
    free = max(1, found.free - many + 1)
    variance = max(float(residual @ residual) / free, samples.rounding**2)
    fitted = replace(found, squares=variance * free, free=free)
    rounded = np.diag((_ROUNDING * found.omega * np.array(found.numbers)) ** 2)
    return step[-many:], variance * inverse[-many:, -many:] + rounded, fitted, residual


def _freed_basis(found: Fit, tau: Floats) -> Floats:
    """Return 1, tau, the cosines, the sines and the derivatives by the frequencies of the harmonics of a fit."""
    waves = np.exp(1j * found.omega * np.outer(found.numbers, tau))
    by_angle = (1j * found.amplitudes[:, None] * waves).real
    return np.concatenate([[np.ones_like(tau), tau], waves.real, waves.imag, tau * by_angle])


def _newton(sums: _Sums, chosen: list[int], inverse: Floats) -> Floats:
    """Return the inverse of the squares' second derivatives, ``inverse`` where it is not positive."""
    second = sums.gram.copy()
    second[-1, :-1] -= sums.bend[:-1]
    second[:-1, -1] -= sums.bend[:-1]
    second[-1, -1] -= sums.bend[-1]
    better = _inverse(second[np.ix_(chosen, chosen)])
    return inverse if better is None else better


def _inverse(gram: Floats) -> Floats | None:
    """Return the inverse of a symmetric matrix, None where it is not positive beyond rounding."""
    diagonal = gram.diagonal()
    if not (diagonal > 0.0).all():
        return None
    scale = 1.0 / np.sqrt(diagonal)
    values, vectors = np.linalg.eigh(gram * np.outer(scale, scale))
    if values[0] < 1e-12 * values[-1]:
        return None
    result: Floats = (vectors / values @ vectors.T) * np.outer(scale, scale)
    return result
