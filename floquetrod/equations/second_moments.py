"""Second moments of linear systems with multiplicative white noise: a periodic linear system of their own.

x of dx = A(t) x dt + sum_i s_i G_i x dW_i, in Ito's sense, has P = E[x x^T] of P' = A P + P A^T + sum_i s_i^2 G_i P
G_i^T (L. Arnold, Stochastic Differential Equations, Wiley 1974, section 8.5).
"""

from __future__ import annotations

import math
from typing import Any, ClassVar, NamedTuple, cast

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import EPS, Floats, norms
from floquetrod.equations import matrices
from floquetrod.equations.base import Equation
from floquetrod.equations.delay_system import DelaySystem
from floquetrod.equations.hill_system import HillSystem, in_first_order, states
from floquetrod.equations.matrices import Matrix
from floquetrod.equations.periodic_system import PeriodicSystem
from floquetrod.equations.pieces import mapped

INTERPRETATIONS = ("ito", "stratonovich")
"""Meanings of the product of noise and solution."""

MOST_UNKNOWNS = 44
"""Most equations of first order under noise (a choice): their 990 moments take a minute."""

_LARGEST_INTENSITY = 1e15  # its square is the largest entry of a matrix
_EXAMPLE = "[(matrix, intensity), ...]"
_SPLIT = 134217729.0  # 2^27 + 1, which splits a double in halves (Veltkamp)
_LEAST_EXACT = 1e-280  # products above it have an exact remainder


class SecondMoments(PeriodicSystem):
    """The system p' = L(t) p of the second moments of another: p = P_11, P_12, ..., P_1n, P_22, ..., P = E[x x^T].

    Returned by `floquetrod.second_moments`.  Verdicts and growth concern the second moments, which are bounded exactly
    where all solutions are in mean square; an amplitude, as the root of a moment, grows half as fast.
    """

    MEANING: ClassVar[str] = "mean-square"


class NoiseSource(NamedTuple):
    """A source of white noise: the matrix G (..., N, N) of x' = ... + s G x xi, its error, the intensity s (...)."""

    matrix: Matrix
    error: float
    intensity: Floats


class _Bounded(NamedTuple):
    """Numbers and bounds of their errors."""

    value: Floats
    error: Floats | float = 0.0

    def plus(self, addend: _Bounded) -> _Bounded:
        """Return the sum; its rounding is known exactly (Knuth)."""
        a, b = self.value, addend.value
        total = np.asarray(a + b)
        virtual = total - a
        rounding = np.abs((a - (total - virtual)) + (b - virtual))
        return _Bounded(total, rounding + self.error + addend.error)

    def times(self, factor: _Bounded) -> _Bounded:
        """Return the product; its rounding is known exactly (Dekker), except for the smallest numbers."""
        a, b = np.broadcast_arrays(self.value, factor.value)
        product = a * b
        (high, low), (top, bottom) = _halves(a), _halves(b)
        rounding = np.abs(((high * top - product) + high * bottom + low * top) + low * bottom)
        size = np.abs(product)
        rounding = np.where((size > _LEAST_EXACT) | (a == 0.0) | (b == 0.0), rounding, EPS * size + 1e-300)
        spread = np.abs(a) * factor.error + np.abs(b) * self.error + np.multiply(self.error, factor.error)
        return _Bounded(product, rounding + spread)

    def where(self, condition: Any) -> _Bounded:
        """Return zero where a condition does not hold."""
        return _Bounded(np.where(condition, self.value, 0.0), np.where(condition, self.error, 0.0))

    def at(self, i: Any, j: Any) -> _Bounded:
        """Return the entries i, j of matrices."""
        error = self.error[..., i, j] if isinstance(self.error, np.ndarray) else self.error
        return _Bounded(self.value[..., i, j], error)


def second_moments(
    system: Equation | HillSystem | PeriodicSystem | DelaySystem, noise: Any, interpretation: str = "ito"
) -> SecondMoments:
    """Return the periodic linear system of the second moments of a system with multiplicative white noise.

    Of M q'' + (C + G) q' + K(t) q + sum_i s_i G_i q xi_i = 0 for a `HillSystem`, of dx = A(t) x dt + sum_i s_i G_i x
    dW_i for a `PeriodicSystem`, of A'' + 2 c A' = (p(tau) + s xi) A for a scalar equation.  The sources xi_i are
    independent, and white: E[xi(t) xi(u)] = delta(t - u), so that s_i^2 has the unit of G_i^-2 per unit of time.

    `floquetrod.stability`, `certify`, `compare`, `chart`, `margin` and `floquetrod.systems` take the result as they
    take any system: that it is stable means that the system is, in mean square.

    Parameters
    ----------
    system : Equation, HillSystem or PeriodicSystem
        The system without noise, of at most 44 equations of first order; or a batch of systems.
    noise : sequence of (matrix, intensity), or float
        Sources: G_i, of as many rows as the system has equations, and s_i, zero or more.  Either may have a leading
        shape, which forms a batch with the system's.  A scalar equation takes s alone, too.
    interpretation : {"ito", "stratonovich"}
        Meaning of G x dW.  Stratonovich adds sum_i s_i^2 G_i^2 / 2 to A; where noise acts on positions alone, as in a
        `HillSystem` and in a scalar equation, G_i^2 = 0 and both are the same.

    Returns
    -------
    SecondMoments
        N = n (n + 1) / 2 equations for n of first order, 2 for an oscillator.  ``coefficient_error`` bounds the
        rounding and the effect of the system's error; it is zero where nothing was rounded.

    Raises
    ------
    TypeError, ValueError
        For noise that is no such sequence, matrices of another order, negative intensities, NaN or beyond 1e15, leading
        shapes that do not fit, another interpretation, and systems too large or with delays.

    Examples
    --------
    y'' + 0.2 y' + y = s y xi is stable in mean square exactly for s^2 < 0.4:

    >>> import floquetrod as fr
    >>> oscillator = fr.HillSystem([[1.0]], damping=[[0.2]])
    >>> moments = fr.second_moments(oscillator, [([[1.0]], 0.6)])
    >>> moments.mean.tolist()
    [[0.0, 2.0, 0.0], [-1.0, -0.2, 1.0], [0.36, -2.0, -0.4]]
    >>> fr.stability(moments).status, fr.stability(oscillator, noise=[([[1.0]], 0.7)]).status
    ('stable', 'unstable')

    L. Arnold, Stochastic Differential Equations, Wiley 1974, section 8.5.
    """
    return _moments_of(*_checked(system, noise, interpretation))


def balanced_moments(system: Any, noise: Any, interpretation: str = "ito") -> SecondMoments:
    """Return the second moments of unknowns scaled by powers of two to similar sizes, as `second_moments` otherwise.

    The exponents are the same, and the rounding of all entries has similar weight.
    """
    subject, sources, interpretation = _checked(system, noise, interpretation)
    sizes = sum((matrix_sizes(matrix) for matrix in subject.every_matrix), np.zeros((subject.order,) * 2))
    for matrix, _, intensity in sources:
        sizes = sizes + float(intensity.max(initial=0.0)) * matrix_sizes(matrix)
    if subject.order > 1 and sizes.any():
        from scipy.linalg import matrix_balance

        scale = matrix_balance(sizes, permute=False, separate=True)[1][0]
        subject, sources = _scaled(subject, sources, scale[None, :] / scale[:, None])
    return _moments_of(subject, sources, interpretation)


def matrix_sizes(matrix: Matrix) -> Matrix:
    """Return the largest magnitude of each entry over a batch."""
    return np.asarray(np.abs(matrix).reshape(-1, *matrix.shape[-2:]).max(axis=0))


def _scaled(
    system: PeriodicSystem, sources: list[NoiseSource], ratio: Matrix
) -> tuple[PeriodicSystem, list[NoiseSource]]:
    """Return a system and its noise for unknowns scaled by powers of two, of the ratios (n, n) ``ratio``."""
    error = system.coefficient_error * float(ratio.max())
    turned = [
        source._replace(matrix=source.matrix * ratio, error=source.error * float(ratio.max())) for source in sources
    ]

    def scale(matrix: Matrix) -> Matrix:
        return np.asarray(matrix * ratio)

    return mapped(PeriodicSystem, system, scale, scale, coefficient_error=error), turned


def _checked(system: Any, noise: Any, interpretation: str) -> tuple[PeriodicSystem, list[NoiseSource], str]:
    """Return the system in first order and the sources of noise, checked."""
    interpretation = validate.choice("interpretation", interpretation, INTERPRETATIONS)
    return of_first_order(system), sources_of(system, noise), interpretation


def _moments_of(subject: PeriodicSystem, sources: list[NoiseSource], interpretation: str) -> SecondMoments:
    """Return the second moments in the sense of ``interpretation``."""
    whole = with_drift(subject, sources, 0.5) if interpretation == "stratonovich" else (subject, 0.0)
    return _moments(*whole, sources)


def of_first_order(system: Any) -> PeriodicSystem:
    """Return the system in first order, checked."""
    if isinstance(system, Equation):
        system = system.as_system()
    if isinstance(system, SecondMoments):
        raise TypeError("system must be the system that noise acts on, not second moments, which noise changed already")
    if isinstance(system, DelaySystem):
        raise TypeError(
            "system must be without delays here; of one with delays fr.stability(system, noise=...) and "
            "fr.critical_noise(system, noise) decide whether second moments grow"
        )
    if not isinstance(system, HillSystem | PeriodicSystem):
        kinds = "an Equation, such as Mathieu, Meissner or Hill, or a HillSystem or PeriodicSystem"
        raise TypeError(f"system must be {kinds}, got {validate.short(system)}")
    if isinstance(system, PeriodicSystem) and system.is_complex:
        raise ValueError(
            "system must be real under noise, got complex matrices; give its real_form, and noise for that"
        )
    unknowns = states(system)
    if unknowns > MOST_UNKNOWNS:
        raise ValueError(
            f"system must have at most {MOST_UNKNOWNS} equations of first order under noise, got {unknowns}: their "
            f"{unknowns * (unknowns + 1) // 2:,} second moments take too long; keep fewer modes"
        )
    return in_first_order(system)


def sources_of(system: Any, noise: Any) -> list[NoiseSource]:
    """Return the sources of noise in coordinates of first order, checked."""
    if isinstance(system, Equation):
        system = system.as_system()
        if not validate.iterable(noise) or isinstance(noise, str | bytes):
            noise = [([[1.0]], validate.nonnegative("noise", noise, "its square is a density"))]
    return [
        source(system, matrix, strength, (name, f"{name}[0]", f"{name}[1]"))
        for name, (matrix, strength) in given_sources(noise, (2,), _EXAMPLE)
    ]


def given_sources(noise: Any, lengths: tuple[int, ...], example: str) -> list[tuple[str, Any]]:
    """Return the sources of noise as they were given, with their names, each of one of the lengths."""
    if isinstance(noise, str | bytes) or not validate.iterable(noise):
        raise TypeError(f"noise must be a sequence {example}, got {validate.short(noise)}")
    listed = validate.listed("noise", noise, validate.MOST_NUMBERS, "sources")
    if not listed:
        raise ValueError(f"noise must be a sequence {example} of one source at least, got none; leave it out")
    sources = []
    for i, given in enumerate(listed):
        name = f"noise[{i}]"
        if not isinstance(given, tuple | list) or len(given) not in lengths:
            raise TypeError(f"noise must be a sequence {example}, got {validate.short(given)} as {name}")
        sources.append((name, given))
    return sources


def source(
    system: Equation | HillSystem | PeriodicSystem | DelaySystem, given: Any, strength: Any, names: tuple[str, str, str]
) -> NoiseSource:
    """Return a source from its matrix and intensity, checked; ``names`` of the pair, the matrix, the intensity."""
    if isinstance(system, Equation):
        system = system.as_system()
    assert not isinstance(system, DelaySystem)  # noqa: S101  # `of_first_order` has refused it
    matrix, intensity = checked_source(system, given, strength, names)
    if not isinstance(system, HillSystem):
        return NoiseSource(matrix, 0.0, intensity)
    return NoiseSource(*_on_positions(system, matrix), intensity)


def checked_source(
    system: HillSystem | PeriodicSystem, given: Any, strength: Any, names: tuple[str, str, str]
) -> tuple[Matrix, Floats]:
    """Return a matrix of noise as it was given and its intensity, checked; ``names`` as of `source`."""
    matrix = matrices.square(names[1], given, system.order, system.MEAN)
    intensity = validate.array(names[2], strength, least=-math.inf, largest=math.inf)
    if intensity.size and not (float(intensity.min()) >= 0.0 and float(intensity.max()) <= _LARGEST_INTENSITY):
        wrong = next(s for s in intensity.ravel().tolist() if not 0.0 <= s <= _LARGEST_INTENSITY)
        raise ValueError(f"{names[2]} must be from 0 to {_LARGEST_INTENSITY:g}, got {wrong!r}")
    if not (np.abs(matrix) <= _LARGEST_INTENSITY).all():
        raise ValueError(f"{names[1]} must hold entries up to {_LARGEST_INTENSITY:g}; put their scale elsewhere")
    try:
        np.broadcast_shapes(system.shape, matrix.shape[:-2], intensity.shape)
    except ValueError:
        shapes = f"matrix {matrix.shape[:-2]}, intensity {intensity.shape}, system {system.shape}"
        raise ValueError(f"{names[0]} must have a leading shape that fits the system's, got {shapes}") from None
    return matrix, intensity


def _on_positions(system: HillSystem, matrix: Matrix) -> tuple[Matrix, float]:
    """Return the matrix of noise in a stiffness, for positions and velocities of mass 1, and its error."""
    error = 0.0
    if system.mass is not None:
        inverse = np.linalg.inv(np.linalg.cholesky(system.mass))
        matrix = inverse @ matrix @ np.swapaxes(inverse, -1, -2)
        condition = float(np.max(norms(system.mass) * norms(inverse) ** 2))
        error = 8.0 * system.order * EPS * condition * float(np.abs(matrix).max())
    n = system.order
    whole = np.zeros((*matrix.shape[:-2], 2 * n, 2 * n))
    whole[..., n:, :n] = -matrix
    return whole, error


def with_drift(system: PeriodicSystem, sources: list[NoiseSource], share: float) -> tuple[PeriodicSystem, float]:
    """Return the system with ``share`` times the sum of s^2 G^2 added to A, and a bound of its rounding."""
    n, drift, error = system.order, np.zeros((system.order,) * 2), 0.0
    for matrix, unknown, intensity in sources:
        square = abs(share) * np.square(intensity)[..., None, None]
        drift = drift + math.copysign(1.0, share) * square * (matrix @ matrix)
        size = float((square * (np.abs(matrix) @ np.abs(matrix))).max(initial=0.0))
        error += (n + 4) * EPS * size + 2.0 * n * unknown * float((square * np.abs(matrix)).max(initial=0.0))
    if not drift.any():
        return system, error
    moved = mapped(PeriodicSystem, system, lambda m: m + drift, coefficient_error=system.coefficient_error)
    means = [value.start for _, value in moved.pieces] or [moved.mean]
    return moved, error + EPS * max(float(np.abs(mean).max()) for mean in means)


def _moments(system: PeriodicSystem, rounding: float, sources: list[NoiseSource]) -> SecondMoments:
    """Return the system of second moments of a system of first order in Ito's sense."""
    scattered = _Bounded(np.zeros((1, 1)))
    for source in sources:
        strength = _Bounded(source.intensity[..., None, None])
        scattered = scattered.plus(strength.times(strength).times(_scattering(source)))
    errors: list[float] = []

    def linear(matrix: Matrix) -> Matrix:
        image = _drift(_Bounded(matrix))
        errors.append(float(np.max(image.error, initial=0.0)))
        return image.value

    def whole(matrix: Matrix) -> Matrix:
        image = _drift(_Bounded(matrix)).plus(scattered)
        errors.append(float(np.max(image.error, initial=0.0)))
        return image.value

    turned = [(duration, value.mapped(whole, linear)) for duration, value in system.pieces]
    mean = whole(system.mean)
    series = [[linear(m) for m in coefficients] for coefficients in (system.cosines, system.sines)]
    error = 2.0 * (system.coefficient_error + rounding) + (1.0 + 1e-12) * sum(errors)
    if turned:
        return cast("SecondMoments", SecondMoments.from_pieces(turned, coefficient_error=error))
    return SecondMoments(mean, *series, period=system.period, coefficient_error=error)


def _drift(matrix: _Bounded) -> _Bounded:
    """Return the matrix of P -> A P + P A^T for the entries P_ij, i <= j, of a symmetric P."""
    (i, j), (k, m) = _entries(matrix.value.shape[-1])
    upper = matrix.at(i, k).where(m == j).plus(matrix.at(j, k).where(m == i))
    mirrored = matrix.at(i, m).where((k == j) & (k < m)).plus(matrix.at(j, m).where((k == i) & (k < m)))
    return upper.plus(mirrored)


def linear_moments(matrix: Matrix) -> Matrix:
    """Return the matrix of P -> A P + P A^T for the entries P_ij, i <= j, of a symmetric P."""
    return _drift(_Bounded(matrix)).value


def _scattering(source: NoiseSource) -> _Bounded:
    """Return the matrix of P -> G P G^T for the entries P_ij, i <= j, of a symmetric P."""
    (i, j), (k, m) = _entries(source.matrix.shape[-1])
    matrix = _Bounded(source.matrix, source.error)
    crossed = matrix.at(i, m).times(matrix.at(j, k)).where(k < m)
    return matrix.at(i, k).times(matrix.at(j, m)).plus(crossed)


def _entries(order: int) -> tuple[Any, Any]:
    """Return the indices (i, j) of the moments of rows, (m, 1), and of columns, (1, m)."""
    i, j = np.triu_indices(order)
    return (i[:, None], j[:, None]), (i[None, :], j[None, :])


def _halves(a: Floats) -> tuple[Floats, Floats]:
    """Return a number as the sum of two numbers of half as many digits (Veltkamp)."""
    scaled = _SPLIT * a
    high = scaled - (scaled - a)
    return high, a - high
