"""Second-order systems M q'' + (C + G) q' + K(t) q = 0 with periodic stiffness."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import EPS, Complexes, Floats, norms
from floquetrod._util.caching import cached_property
from floquetrod._util.calling import constructor_hints
from floquetrod.equations import matrices, sampling
from floquetrod.equations import pieces as by_pieces
from floquetrod.equations.matrices import Matrix, Structure
from floquetrod.equations.periodic_system import PeriodicSystem
from floquetrod.equations.sampled_tables import series_of


class EvenForm(NamedTuple):
    """The system u'' + (S + sum_k A_k cos k w s) u = 0, where q = L u, M^-1 = L L^T, and s = t - start.

    Attributes
    ----------
    stiffness : ndarray (..., n, n)
        Mean stiffness S.
    amplitudes : ndarray (..., H, n, n)
        A_k, k = 1, 2, ...
    start : ndarray (...)
        Instant about which the stiffness is even.
    error : ndarray (...)
        Bound on the rounding errors of the stiffness, in the 2-norm.
    uncertainty : ndarray (...)
        Part by which the stiffness may be uneven: zero where its coefficients show its evenness exactly.
    """

    stiffness: Matrix
    amplitudes: Matrix
    start: Floats
    error: Floats
    uncertainty: Floats


@constructor_hints(frequency="period is 2 pi / frequency")
@dataclass(frozen=True, eq=False, repr=False)
class HillSystem(matrices.PeriodicMatrixSystem):
    """The system M q'' + (C + G) q' + K(t) q = 0 of n equations, K(t) periodic: a finite Fourier series, or in pieces.

    As a series of period 2 pi / w, K(t) = stiffness + sum_k cosines[k-1] cos k w t + sines[k-1] sin k w t;
    `from_pieces` takes a K(t) that jumps.  Positive stiffness restores: the sign is opposite to the scalar `Hill`,
    whose positive coefficient pushes away, and ``damping`` is the matrix C, where the scalar's c stands for C = 2 c.
    ``Hill(...).as_system()`` converts.

    Any matrix may be an array of matrices with a leading shape, and ``period`` an array: together they are then a batch
    of systems, for `floquetrod.systems`.

    Parameters
    ----------
    stiffness : array_like (..., n, n)
        Mean of K; it need not be symmetric (a follower load makes it so).
    cosines : sequence of array_like (..., n, n)
        Coefficients of the cosines of K from the first harmonic on; none by default.
    sines : sequence of array_like (..., n, n)
        Coefficients of the sines of K from the first harmonic on; none by default.  There may be more or fewer of them
        than cosines.
    mass : array_like (..., n, n), optional
        M, symmetric and positive definite; the identity by default, which is kept as None.
    damping : array_like (..., n, n), optional
        C, any matrix; none by default, and None where it is zero.
    gyroscopic : array_like (..., n, n), optional
        G, which equals minus its transpose; none by default, and None where it is zero.
    period : float or array_like (...)
        Period of K.  Units are the caller's: with kg, N s/m and N/m it is in seconds.
    coefficient_error : float
        Bound or estimate of the error of K(t), entry by entry, in the unit of K; `from_function` states one.  Where K
        is symmetric its error is taken to be symmetric.
    pieces : sequence of (duration, matrix)
        The argument of `from_pieces`, with the mean ``stiffness`` and the ``period`` that follow from it; none by
        default.

    Raises
    ------
    TypeError, ValueError
        For matrices not square and real, or of another order than the stiffness, a mass that is not symmetric positive
        definite, a gyroscopic matrix that is not skew-symmetric, NaN, and periods of zero or less.

    Examples
    --------
    >>> HillSystem([[1.0, 0.0], [0.0, 4.0]], cosines=[[[0.1, 0.2], [0.2, 0.16]]], period=2.0).structure
    'hamiltonian'
    """

    MEAN: ClassVar[str] = "stiffness"

    stiffness: Matrix
    cosines: tuple[Matrix, ...] = ()
    sines: tuple[Matrix, ...] = ()
    mass: Matrix | None = None
    damping: Matrix | None = None
    gyroscopic: Matrix | None = None
    period: Any = 2.0 * math.pi
    coefficient_error: float = 0.0
    pieces: by_pieces.Pieces = ()

    _rounding = 0.0
    # Bound on the error of the stiffness, in the 2-norm; not zero where `undamped` computed it.

    def __init__(
        self,
        stiffness: Any,
        cosines: Any = (),
        sines: Any = (),
        *,
        mass: Any = None,
        damping: Any = None,
        gyroscopic: Any = None,
        period: Any = 2.0 * math.pi,
        coefficient_error: float = 0.0,
        pieces: Any = (),
    ) -> None:
        """Check and copy the parameters."""
        mean = matrices.square("stiffness", stiffness)
        order = mean.shape[-1]

        def optional(name: str, value: Any) -> Matrix | None:
            return None if value is None else matrices.square(name, value, order, "stiffness")

        values: dict[str, Any] = {
            "stiffness": mean,
            "cosines": matrices.by_harmonic("cosines", cosines, order, "stiffness"),
            "sines": matrices.by_harmonic("sines", sines, order, "stiffness"),
            "mass": _positive_definite(optional("mass", mass)),
            "damping": _unless_zero(optional("damping", damping)),
            "gyroscopic": _unless_zero(_skew(optional("gyroscopic", gyroscopic))),
            "period": matrices.periods(period),
            "coefficient_error": validate.nonnegative("coefficient_error", coefficient_error),
        }
        values["pieces"] = by_pieces.checked(pieces, values, self.MEAN)
        self._take(values)

    @classmethod
    def from_pieces(
        cls,
        pieces: Any,
        *,
        mass: Any = None,
        damping: Any = None,
        gyroscopic: Any = None,
        coefficient_error: float = 0.0,
    ) -> HillSystem:
        """Return the system whose K(t) is given piece by piece of the period, and may jump from one to the next.

        Parameters
        ----------
        pieces : sequence of (duration, K)
            From t = 0 on, over a period, which is the exact sum of the durations: positive numbers, `Fraction` among
            them, or arrays of them for a batch.  K is a matrix (..., n, n), constant over the piece, or a `Varying`.
        mass : array_like (..., n, n), optional
            M, as of the system.
        damping : array_like (..., n, n), optional
            C, as of the system.
        gyroscopic : array_like (..., n, n), optional
            G, as of the system.
        coefficient_error : float
            Of K(t), as of the system.

        Returns
        -------
        HillSystem
            One system, or a batch.

        Raises
        ------
        TypeError, ValueError
            For durations not above 0, matrices whose shapes do not fit, and a mass that is not positive
            definite.

        Examples
        --------
        Two coupled equations of Meissner, a square wave of period 2:

        >>> stiff, soft = [[1.5, 0.5], [0.5, 4.5]], [[0.5, -0.5], [-0.5, 3.5]]
        >>> system = HillSystem.from_pieces([(1.0, stiff), (1.0, soft)])
        >>> system.period, system.stiffness.tolist(), system.structure
        (2.0, [[1.0, 0.0], [0.0, 4.0]], 'hamiltonian')
        """
        others = {"mass": mass, "damping": damping, "gyroscopic": gyroscopic, "coefficient_error": coefficient_error}
        return by_pieces.made(cls, pieces, **others)

    @classmethod
    def from_function(
        cls,
        function: Callable[[float], Any],
        period: float,
        jumps: Any = (),
        *,
        mass: Any = None,
        damping: Any = None,
        gyroscopic: Any = None,
    ) -> HillSystem:
        """Return the system whose K(t) a function computes, expanded as `PeriodicSystem.from_function` does.

        Where all samples are symmetric, entry by entry, the result is symmetric, too.

        Parameters
        ----------
        function : callable (t) -> array_like (n, n)
            K, periodic and smooth except for its jumps.
        period : float
            Its period.
        jumps : sequence of float
            Instants from 0 up to the period at which K jumps, or has a kink; none by default.
        mass : array_like (n, n), optional
            M, as of the system.
        damping : array_like (n, n), optional
            C, as of the system.
        gyroscopic : array_like (n, n), optional
            G, as of the system.

        Returns
        -------
        HillSystem
            Its ``coefficient_error`` is estimated.

        Raises
        ------
        TypeError, ValueError
            Where K a period later differs, and where it is not smooth between the jumps; for matrices whose shapes
            do not fit.

        Examples
        --------
        >>> system = HillSystem.from_function(lambda t: [[2.0 + math.exp(math.sin(t))]], 2.0 * math.pi)
        >>> system.is_smooth, system.coefficient_error < 1e-13
        (True, True)
        """
        expansion = sampling.expanded(function, period, jumps, matrices.MOST_EQUATIONS)
        others = {"mass": mass, "damping": damping, "gyroscopic": gyroscopic}
        return cls.from_pieces(expansion.pieces, **others, coefficient_error=expansion.error)

    @classmethod
    def from_samples(
        cls,
        times: Any,
        values: Any,
        period: float,
        *,
        mass: Any = None,
        damping: Any = None,
        gyroscopic: Any = None,
    ) -> HillSystem:
        """Return the system whose K(t) goes through a table of matrices, as `PeriodicSystem.from_samples` does.

        Parameters
        ----------
        times : array_like (N,)
            Instants within one period, increasing, at least 5; of phases give the period 2 pi.
        values : array_like (N, n, n)
            K there.
        period : float
            Its period.
        mass : array_like (n, n), optional
            M, as of the system.
        damping : array_like (n, n), optional
            C, as of the system.
        gyroscopic : array_like (n, n), optional
            G, as of the system.

        Returns
        -------
        HillSystem
            Its ``coefficient_error`` is estimated.

        Raises
        ------
        TypeError, ValueError
            For instants that do not increase or lie further apart than a period, and for shapes that do not fit.

        Examples
        --------
        >>> azimuths = np.arange(36) * (2.0 * math.pi / 36)
        >>> system = HillSystem.from_samples(azimuths, [[[2.0 + math.exp(math.sin(t))]] for t in azimuths], 2 * math.pi)
        >>> len(system.cosines), system.coefficient_error < 1e-9
        (17, True)
        """
        table = series_of(times, values, period, matrices.MOST_EQUATIONS)
        others = {"mass": mass, "damping": damping, "gyroscopic": gyroscopic}
        return cls(table.mean, table.cosines, table.sines, **others, period=period, coefficient_error=table.error)

    @cached_property
    def is_symmetric(self) -> bool:
        """Whether K(t) is symmetric, entry by entry."""
        return all(matrices.symmetric(matrix) for matrix in self.every_matrix)

    @cached_property
    def uniform_damping(self) -> float | None:
        """The c of C = 2 c M, exactly, with which all motion decays; 0 without damping, None where C is otherwise.

        Of a batch: where it is one number for all.
        """
        if self.damping is None:
            return 0.0
        mass = matrices.mass_matrix(self)
        twice = float(self.damping.flat[0]) / float(mass.flat[0])
        return 0.5 * twice if 0.0 < twice < math.inf and _is_multiple(self.damping, twice, mass) else None

    @cached_property
    def structure(self) -> Structure:
        """Structure of the matrices, exactly, entry by entry; it decides how multipliers come in pairs.

        "hamiltonian": C = 0, K symmetric; multipliers in mu, 1 / mu.  "reversible": C = G = 0, K not symmetric, but
        even about an instant; in mu, 1 / mu too.  "damped": K symmetric, C symmetric and not negative (to rounding).
        "general": anything else.  Of a batch: of all its systems.
        """
        if self.damping is None and self.is_symmetric:
            return "hamiltonian"
        if self.damping is None:
            even = self.even_form
            seen = self.even_start is not None if even is None else not even.uncertainty.any()
            return "reversible" if seen else "general"
        return "damped" if self.is_symmetric and _dissipative(self.damping) else "general"

    @cached_property
    def undamped(self) -> tuple[HillSystem, float] | None:
        """The system without damping of u = exp(c t) q, and c; None where C is not 2 c M, and with both C and G."""
        c = self.uniform_damping
        if c is None or (c > 0.0 and self.gyroscopic is not None):
            return None
        if c == 0.0:
            return self, 0.0
        mass = matrices.mass_matrix(self)
        shift = c * c * mass
        others: dict[str, Any] = {"mass": self.mass, "coefficient_error": self.coefficient_error}
        freed = by_pieces.mapped(HillSystem, self, lambda m: m - shift, **others)
        if self.pieces:
            vars(freed)["even_start"] = self._even_instant  # of the numbers given, not of rounded ones
        means = [value.start for _, value in freed.pieces] or [freed.stiffness]
        largest = functools.reduce(np.maximum, map(norms, means))
        object.__setattr__(freed, "_rounding", EPS * (largest + 2.0 * c * c * norms(mass)))
        return freed, c

    @property
    def error_norm(self) -> Any:
        """Bound of the error of K(t) in the 2-norm, its rounding included."""
        return self._rounding + self.order * self.coefficient_error

    @cached_property
    def even_form(self) -> EvenForm | None:
        """The system of mass 1 about an instant of even stiffness; None without one, in pieces, and with C or G."""
        if self.damping is not None or self.gyroscopic is not None or self.pieces:
            return None
        turned = _even_amplitudes(self.harmonics)
        if turned is None:
            return None
        amplitudes, phase, uncertainty = turned
        stiffness = np.broadcast_to(self.stiffness, (*self.shape, self.order, self.order))
        error, rounding = uncertainty, np.asarray(self.error_norm)
        if self.mass is not None:
            inverse = np.linalg.inv(np.linalg.cholesky(self.mass))
            stiffness = _congruence(inverse, stiffness)
            amplitudes = _congruence(inverse[..., None, :, :], amplitudes)
            if self.is_symmetric:
                stiffness, amplitudes = matrices.mirrored(stiffness), matrices.mirrored(amplitudes)
            error = (error + 8.0 * self.order * EPS) * norms(self.mass) * norms(inverse) ** 2
            rounding = rounding * norms(inverse) ** 2
        error = error * (norms(stiffness) + norms(amplitudes).sum(axis=-1)) + rounding
        start = np.broadcast_to(phase * np.asarray(self.period) / (2.0 * math.pi), self.shape)
        return EvenForm(stiffness, amplitudes, start, error, uncertainty)

    @cached_property
    def even_start(self) -> Fraction | None:
        """Instant about which a stiffness in pieces is exactly even; None without one, and with C or G."""
        return None if self.damping is not None or self.gyroscopic is not None else self._even_instant

    @property
    def _even_instant(self) -> Fraction | None:
        """Instant about which a stiffness in pieces is exactly even, whatever the other matrices."""
        return by_pieces.even_start(by_pieces.in_time(self)) if self.pieces and not self.shape else None

    @property
    def is_even(self) -> bool:
        """Whether half a period is enough, as where the stiffness is even about an instant, without C and G."""
        return self.even_form is not None or self.even_start is not None

    def as_periodic_system(self) -> PeriodicSystem:
        """Return the same system in first order, of mass 1: x = (u, u') with q = L u, M^-1 = L L^T.

        Where the system is Hamiltonian, x = (u, p) with p = u' + G u / 2, in which it is Hamiltonian too.  Its
        ``coefficient_error`` includes the error of the system and the rounding.

        Returns
        -------
        PeriodicSystem
            Of N = 2 n equations.
        """
        inverse = None if self.mass is None else np.linalg.inv(np.linalg.cholesky(self.mass))
        canonical = self.structure == "hamiltonian"
        tidy = matrices.mirrored if canonical else np.asarray

        def reduced(matrix: Matrix | None) -> Matrix:
            matrix = np.zeros((self.order, self.order)) if matrix is None else matrix
            return matrix if inverse is None else _congruence(inverse, matrix)

        gyroscopic, friction = reduced(self.gyroscopic), reduced(self.damping)

        def whole(stiffness: Matrix) -> Matrix:
            return _first_order(tidy(reduced(stiffness)), friction, gyroscopic, canonical=canonical)

        def varying(matrix: Matrix) -> Matrix:
            return _lower(-tidy(reduced(matrix)))

        turned = [(duration, value.mapped(whole, varying)) for duration, value in self.pieces]
        mean = whole(self.stiffness)
        cosines, sines = ([varying(m) for m in series] for series in (self.cosines, self.sines))
        error = float(np.max(self.error_norm if inverse is None else self.error_norm * norms(inverse) ** 2))
        if inverse is not None or (canonical and self.gyroscopic is not None):
            sizes = [value.matrices for _, value in turned] or [(mean, *cosines, *sines)]
            size = max(sum(float(np.abs(matrix).max()) for matrix in series) for series in sizes)
            condition = 1.0 if inverse is None else float(np.max(norms(np.asarray(self.mass)) * norms(inverse) ** 2))
            error += 8.0 * self.order * EPS * condition * size
        if self.pieces:
            return PeriodicSystem.from_pieces(turned, coefficient_error=error)
        return PeriodicSystem(mean, cosines, sines, period=self.period, coefficient_error=error)

    def plot(self, ax: Any = None) -> Any:
        """Draw the varying entries of the matrix of one system over one period, on ``ax`` or on new axes.

        Of a symmetric matrix only entries on and above the diagonal; of a constant one all.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.

        Raises
        ------
        ValueError
            For a batch of systems.

        Examples
        --------
        >>> HillSystem.from_pieces([(1.0, [[1.5]]), (2.0, [[0.5]])]).plot().get_xlabel()
        '$t$, over a period of 3'
        """
        return by_pieces.draw(self, ax)

    def coefficient(self, t: Any) -> Floats:
        """Return K(t), of shape ``(*t.shape, n, n)``, the mean of both sides at a jump; of one system.

        Returns
        -------
        ndarray
            (..., n, n), behind the shape of ``t``.

        Raises
        ------
        TypeError, ValueError
            For instants other than finite numbers, and for a batch.
        """
        return by_pieces.value_at(self, t)


def damped(system: HillSystem, rate: float) -> HillSystem:
    """Return the system of q = exp(-c t) u, c = ``rate`` > 0, from the system of u, without damping, of one series."""
    mass = matrices.mass_matrix(system)
    shifted = {"stiffness": system.stiffness + rate * rate * mass, "damping": 2.0 * rate * mass}
    system_with_damping: HillSystem = matrices.remade(system, **shifted)
    vars(system_with_damping)["undamped"] = system, rate
    return system_with_damping


def restricted(system: HillSystem, kept: slice | NDArray[np.intp]) -> HillSystem:
    """Return the equations ``kept`` of a system of one Fourier series, without their coupling to the others."""

    def block(matrix: Matrix | None) -> Any:
        return None if matrix is None else matrix[..., kept, :][..., kept].copy()

    subsystem: HillSystem = matrices.remade(
        system,
        stiffness=block(system.stiffness),
        cosines=tuple(map(block, system.cosines)),
        sines=tuple(map(block, system.sines)),
        mass=_positive_definite(block(system.mass)),
        damping=_unless_zero(block(system.damping)),
        gyroscopic=_unless_zero(block(system.gyroscopic)),
    )
    object.__setattr__(subsystem, "_rounding", system._rounding)
    freed = vars(system).get("undamped")
    if freed is not None and freed[1] > 0.0:
        vars(subsystem)["undamped"] = restricted(freed[0], kept), freed[1]
    return subsystem


def in_first_order(system: HillSystem | PeriodicSystem) -> PeriodicSystem:
    """Return a system in first order, itself where it is."""
    return system.as_periodic_system() if isinstance(system, HillSystem) else system


def states(system: Any) -> int:
    """Return the number of first-order equations of a system."""
    return int(system.order) * (2 if isinstance(system, HillSystem) else 1)


def _first_order(stiffness: Matrix, damping: Matrix, gyroscopic: Matrix, *, canonical: bool) -> Matrix:
    """Return the matrix of u'' + (C + G) u' + K u = 0 for (u, u'), or for (u, u' + G u / 2) if ``canonical``."""
    n = stiffness.shape[-1]
    if canonical:
        half = 0.5 * gyroscopic
        half = 0.5 * (half - np.swapaxes(half, -1, -2))
        bent = _congruence(half, np.eye(n), "gyroscopic")
        stiffness, half = np.broadcast_arrays(stiffness + matrices.mirrored(bent), half)
        mean = _lower(-stiffness, -half)
        mean[..., :n, :n] = -half
    else:
        mean = _lower(*(-matrix for matrix in np.broadcast_arrays(stiffness, damping + gyroscopic)))
    mean[..., :n, n:] = np.eye(n)
    return mean


def _lower(left: Matrix, right: Matrix | None = None) -> Matrix:
    """Return [[0, 0], [left, right]]."""
    n = left.shape[-1]
    block = np.zeros((*left.shape[:-2], 2 * n, 2 * n))
    block[..., n:, :n] = left
    if right is not None:
        block[..., n:, n:] = right
    return block


def _positive_definite(mass: Matrix | None) -> Matrix | None:
    """Return M, checked, and None for the identity."""
    if mass is None:
        return None
    if not matrices.symmetric(mass):
        gap = float(np.abs(mass - np.swapaxes(mass, -1, -2)).max())
        raise ValueError(f"mass must be symmetric, got entries that differ by {gap:.3g} from their mirror images")
    try:
        np.linalg.cholesky(mass)
    except np.linalg.LinAlgError:
        lowest = float(np.linalg.eigvalsh(mass).min())
        raise ValueError(f"mass must be positive definite, got one with the eigenvalue {lowest:.3g}") from None
    return None if (mass == np.eye(mass.shape[-1])).all() else mass


def _skew(gyroscopic: Matrix | None) -> Matrix | None:
    """Return G, checked."""
    if gyroscopic is None or np.array_equal(gyroscopic, -np.swapaxes(gyroscopic, -1, -2)):
        return gyroscopic
    raise ValueError(
        "gyroscopic must equal minus its transpose, entry by entry, got one that does not; put its symmetric part "
        "into damping"
    )


def _unless_zero(matrix: Matrix | None) -> Matrix | None:
    return None if matrix is None or not matrix.any() else matrix


def _is_multiple(matrix: Matrix, factor: float, base: Matrix) -> bool:
    """Return whether ``matrix`` is exactly ``factor`` times ``base``; False where products leave the normal doubles.

    Where the rounded products agree, the exact ones differ by less than 2^63 units of their last places, if at all:
    the remainder modulo 2^64 tells.
    """
    with np.errstate(over="ignore", under="ignore"):
        product = factor * base
    matrix, product, base = np.broadcast_arrays(matrix, product, base)
    if not np.array_equal(matrix, product) or (base[matrix == 0.0] != 0.0).any():
        return False
    whole, last = matrix[matrix != 0.0], base[matrix != 0.0]
    if whole.size and not np.abs(whole).min() > 1e-280:
        return False
    factors = [np.frexp(values) for values in (whole, last, np.full(whole.shape, factor))]
    digits = [(fraction * 2.0**53).astype(np.int64).view(np.uint64) for fraction, _ in factors]
    shift = (factors[0][1] - factors[1][1] - factors[2][1] + 53).astype(np.uint64)
    return bool(np.array_equal(digits[0] << shift, digits[1] * digits[2]))


def _dissipative(damping: Matrix | None) -> bool:
    """Return whether C is symmetric and has no negative eigenvalue, to rounding."""
    if damping is None or not matrices.symmetric(damping):
        return False
    values = np.linalg.eigvalsh(damping)
    return bool((values[..., 0] >= -8.0 * EPS * values[..., -1]).all())


def _even_amplitudes(
    harmonics: Complexes,
) -> tuple[Matrix, Floats, Floats] | None:
    """Return the amplitudes about an instant of evenness, its phase w t, and their relative error; None without one.

    The uncertainty is zero where the evenness is seen in the coefficients as they stand: no sines, or one sine alone.
    """
    shape, count = harmonics.shape[:-3], harmonics.shape[-3]
    if count == 0:
        return harmonics.real.copy(), np.zeros(shape), np.zeros(shape)
    orders = np.arange(1, count + 1)
    present = harmonics.any(axis=(-2, -1))
    first = present.argmax(axis=-1)
    plain = ~harmonics.imag.any(axis=(-3, -2, -1))
    alone = ~plain & ~harmonics.real.any(axis=(-3, -2, -1)) & (present.sum(axis=-1) == 1)
    result = np.where(alone[..., None, None, None], -harmonics.imag, harmonics.real)
    phase = np.where(alone, 0.5 * math.pi / (first + 1), 0.0)
    settled = plain | alone
    if settled.all():
        return result, phase, np.zeros(shape)
    uncertainty = np.where(settled, 0.0, 16.0 * EPS * count)
    flat = np.take_along_axis(harmonics.reshape(*shape, count, -1), first[..., None, None], axis=-2)[..., 0, :]
    largest = np.take_along_axis(flat, np.abs(flat).argmax(axis=-1)[..., None], axis=-1)[..., 0]
    slack = 8.0 * EPS * orders[:, None, None] * np.abs(harmonics).max(axis=(-2, -1), keepdims=True)
    for turn in range(2 * (int(first.max()) + 1)):
        angle = (math.pi * turn - np.angle(largest)) / (first + 1)
        turned = harmonics * np.exp(1j * angle[..., None] * orders)[..., None, None]
        even = (np.abs(turned.imag) <= slack).all(axis=(-3, -2, -1)) & ~settled
        result[even], phase[even] = turned.real[even], angle[even]
        settled = settled | even
    return (result, phase, uncertainty) if settled.all() else None


def _congruence(left: Matrix, matrix: Matrix, name: str = "mass") -> Matrix:
    """Return L K L^T; ValueError where its entries are beyond the largest of a system."""
    with np.errstate(over="ignore", under="ignore", invalid="ignore"):
        result = np.asarray(left @ matrix @ np.swapaxes(left, -1, -2))
    if not (np.abs(result) <= matrices.LARGEST_ENTRY).all():
        raise ValueError(
            f"{name} must fit the other matrices: in coordinates of mass 1 they are beyond "
            f"{matrices.LARGEST_ENTRY:g}; check units"
        )
    return result
