"""First-order systems x' = A(t) x with periodic A."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Complexes
from floquetrod._util.caching import cached_property
from floquetrod._util.calling import constructor_hints
from floquetrod.equations import matrices, sampling
from floquetrod.equations import pieces as by_pieces
from floquetrod.equations.complex_form import real_matrix
from floquetrod.equations.matrices import Matrix, Structure
from floquetrod.equations.sampled_tables import series_of


@constructor_hints(frequency="period is 2 pi / frequency")
@dataclass(frozen=True, eq=False, repr=False)
class PeriodicSystem(matrices.PeriodicMatrixSystem):
    """The system x' = A(t) x of N equations with A(t) = mean + sum_k cosines[k-1] cos k w t + sines[k-1] sin k w t.

    w = 2 pi / period.  Any matrix may be an array of matrices with a leading shape, and ``period`` an array: together
    they are then a batch of systems, for `floquetrod.systems`.  Matrices may be complex, as A = -i H of a Hamiltonian H
    in units of hbar: there are then N complex solutions, whose multipliers need not come in conjugate pairs.

    Parameters
    ----------
    mean : array_like (..., N, N)
        Mean of A, per unit of time.
    cosines : sequence of array_like (..., N, N)
        Coefficients of the cosines from the first harmonic on; none by default.
    sines : sequence of array_like (..., N, N)
        Coefficients of the sines from the first harmonic on; none by default.  There may be more or fewer of them than
        cosines.
    period : float or array_like (...)
        Period of A, in the unit of time, the inverse of A's unit.
    coefficient_error : float
        Bound or estimate of the error of A(t), entry by entry, in the unit of A; `from_function` states one.
    pieces : sequence of (duration, matrix)
        The argument of `from_pieces`, with the ``mean`` and the ``period`` that follow from it; none by default.

    Raises
    ------
    TypeError, ValueError
        For matrices whose shapes do not fit, entries that are not finite, and a period not above 0.

    Examples
    --------
    >>> PeriodicSystem([[0.0, 1.0], [-1.0, -0.1]], cosines=[[[0.0, 0.0], [-0.2, 0.0]]]).order
    2

    A two-level atom, H = sigma_z / 2 + cos(t) sigma_x / 4:

    >>> import numpy as np
    >>> atom = PeriodicSystem(-0.5j * np.diag([1, -1]), cosines=[-0.25j * np.array([[0, 1], [1, 0]])])
    >>> atom.structure
    'unitary'
    """

    MEAN: ClassVar[str] = "mean"

    mean: Matrix
    cosines: tuple[Matrix, ...] = ()
    sines: tuple[Matrix, ...] = ()
    period: Any = 2.0 * math.pi
    coefficient_error: float = 0.0
    pieces: by_pieces.Pieces = ()

    def __init__(
        self,
        mean: Any,
        cosines: Any = (),
        sines: Any = (),
        *,
        period: Any = 2.0 * math.pi,
        coefficient_error: float = 0.0,
        pieces: Any = (),
    ) -> None:
        """Check and copy the parameters."""
        average = matrices.square("mean", mean, most=2 * matrices.MOST_EQUATIONS, complex_too=True)
        order = average.shape[-1]
        values: dict[str, Any] = {
            "mean": average,
            "cosines": matrices.by_harmonic("cosines", cosines, order, "mean", complex_too=True),
            "sines": matrices.by_harmonic("sines", sines, order, "mean", complex_too=True),
            "period": matrices.periods(period),
            "coefficient_error": validate.nonnegative("coefficient_error", coefficient_error),
        }
        values["pieces"] = by_pieces.checked(pieces, values, self.MEAN)
        self._take(values)
        if self.is_complex and order > matrices.MOST_EQUATIONS:
            raise ValueError(
                f"mean must be at most {matrices.MOST_EQUATIONS} x {matrices.MOST_EQUATIONS} where "
                f"matrices are complex, got shape {average.shape}"
            )

    @classmethod
    def from_pieces(cls, pieces: Any, *, coefficient_error: float = 0.0) -> PeriodicSystem:
        """Return the system whose A(t) is given piece by piece of the period, and may jump from one to the next.

        Parameters
        ----------
        pieces : sequence of (duration, A)
            From t = 0 on, over a period, which is the exact sum of the durations: positive numbers, `Fraction` among
            them, or arrays of them for a batch.  A is a matrix (..., N, N), constant over the piece, or a `Varying`.
        coefficient_error : float
            Of A(t), as of the system.

        Returns
        -------
        PeriodicSystem
            One system, or a batch.

        Raises
        ------
        TypeError, ValueError
            For durations not above 0, and matrices whose shapes do not fit.

        Examples
        --------
        >>> PeriodicSystem.from_pieces([(0.5, [[0.0, 1.0], [-4.0, 0.0]]), (1.5, [[0.0, 1.0], [-1.0, 0.0]])]).period
        2.0
        """
        return by_pieces.made(cls, pieces, coefficient_error=coefficient_error)

    @classmethod
    def from_function(cls, function: Callable[[float], Any], period: float, jumps: Any = ()) -> PeriodicSystem:
        """Return the system whose A(t) a function computes, expanded in a Fourier series, or in pieces between jumps.

        Without jumps A is sampled over the period at twice as many instants until its harmonics have decayed to
        rounding, or to the noise of its values, and the series agrees with it at instants in between.  Between jumps,
        and there never at the jumps themselves, a few harmonics are fitted, over pieces halved until they agree with A
        in between.  ``coefficient_error`` is an estimate of the neglected harmonics, and of their aliases by sampling.
        A change far shorter than a hundredth of the period, or of a piece, may be missed.

        Parameters
        ----------
        function : callable (t) -> array_like (N, N)
            A, real or complex, periodic and smooth except for its jumps.
        period : float
            Its period.
        jumps : sequence of float
            Instants from 0 up to the period at which A jumps, or has a kink; none by default.

        Returns
        -------
        PeriodicSystem
            Its ``coefficient_error`` is estimated.

        Raises
        ------
        ValueError
            Where A a period later differs, and where it is not smooth between the jumps: a jump or a kink that is not
            named, or without jumps more than 768 harmonics that matter.

        Examples
        --------
        >>> import numpy as np
        >>> system = PeriodicSystem.from_function(lambda t: [[0.0, 1.0], [-1.0 / (1.1 + np.cos(t)), 0.0]], 2 * np.pi)
        >>> len(system.cosines), system.coefficient_error < 1e-12
        (74, True)
        >>> def saw(t):
        ...     return [[0.0, 1.0], [-(t % 2.0), -0.1]]
        >>> len(PeriodicSystem.from_function(saw, 2.0, jumps=[0.0]).pieces)
        2
        """
        expansion = sampling.expanded(function, period, jumps, 2 * matrices.MOST_EQUATIONS, complex_too=True)
        return cls.from_pieces(expansion.pieces, coefficient_error=expansion.error)

    @classmethod
    def from_samples(cls, times: Any, values: Any, period: float) -> PeriodicSystem:
        """Return the system whose A(t) goes through a table of matrices: a Fourier series of (N - 1) // 2 harmonics.

        At equal distances it is the trigonometric interpolation, at other distances a periodic cubic spline.
        ``coefficient_error`` estimates its error, which verdicts include, from how fast harmonics fall; where noise of
        the values keeps them from falling it is the sum of those in the upper third.  A table with jumps has large
        errors: give pieces.

        Parameters
        ----------
        times : array_like (N,)
            Instants within one period, increasing, at least 5; of phases give the period 2 pi.
        values : array_like (N, n, n)
            A there, real or complex.
        period : float
            Its period.

        Returns
        -------
        PeriodicSystem
            Its ``coefficient_error`` is estimated.

        Raises
        ------
        ValueError
            For instants that do not increase or lie further apart than a period, and for shapes that do not fit.

        Examples
        --------
        >>> import numpy as np
        >>> t = np.linspace(0.0, 2.0, 24, endpoint=False)
        >>> table = [[[0.0, 1.0], [-2.0 - np.cos(np.pi * s), -0.1]] for s in t]
        >>> system = PeriodicSystem.from_samples(t, table, 2.0)
        >>> round(float(system.cosines[0][1, 0]), 12), system.coefficient_error < 1e-14
        (-1.0, True)
        """
        table = series_of(times, values, period, 2 * matrices.MOST_EQUATIONS, complex_too=True)
        return cls(table.mean, table.cosines, table.sines, period=period, coefficient_error=table.error)

    @cached_property
    def structure(self) -> Structure:
        """Structure of A, exactly, entry by entry; it decides how multipliers come in pairs.

        "hamiltonian" where J A(t) is symmetric, J = [[0, I], [-I, 0]], x = (q, p); "reversible" where R A(-t) R = -A(t)
        with R = diag(I, -I), x = (q, q'), and A is one Fourier series; "unitary" where ``keeps_norm``; else "general".
        A complex A is "unitary" or "general".  Of a batch: of all its systems.
        """
        return self._paired_structure or ("unitary" if self.keeps_norm else "general")

    @cached_property
    def keeps_norm(self) -> bool:
        """Whether A(t) is minus its conjugate transpose, entry by entry, so that every solution keeps its norm.

        The ``coefficient_error`` of such an A is taken to be skew-Hermitian, too.  Of a batch: whether all A are.
        """
        return all(np.array_equal(matrix, -np.swapaxes(matrix, -1, -2).conj()) for matrix in self.every_matrix)

    @cached_property
    def is_complex(self) -> bool:
        """Whether a matrix has complex entries; of a batch, whether a matrix of any system has."""
        return any(matrix.dtype.kind == "c" for matrix in self.every_matrix)

    @property
    def real_form(self) -> PeriodicSystem:
        """The real system of 2 N equations for (u, v), where x = u + i v solves the complex one; a real system itself.

        Its multipliers are the complex system's and their conjugates.

        Examples
        --------
        >>> PeriodicSystem([[-0.1 + 2.0j]]).real_form.mean.tolist()
        [[-0.1, -2.0], [2.0, -0.1]]
        """
        return self.doubled if self.is_complex else self

    @cached_property
    def doubled(self) -> PeriodicSystem:
        """The system of the real and imaginary parts of x, 2 N real equations, of a real system two copies of it."""
        changes: dict[str, Any] = {name: tuple(map(real_matrix, getattr(self, name))) for name in ("cosines", "sines")}
        pieces = tuple((duration, value.mapped(real_matrix, real_matrix)) for duration, value in self.pieces)
        doubled: PeriodicSystem = matrices.remade(self, mean=real_matrix(self.mean), pieces=pieces, **changes)
        return doubled

    @cached_property
    def harmonics(self) -> Complexes:
        """Amplitudes Z, complex (..., H, N, N), of mean + sum_k Re(Z_k exp(i k w t)); trailing zeros dropped.

        Raises TypeError for a system in pieces, which has no finite Fourier series, and for a complex one, whose
        ``real_form`` has them.
        """
        if self.is_complex:
            raise TypeError("system must be real to be the real part of a series; take its real_form")
        return super().harmonics

    @property
    def _waves(self) -> int:
        return int(self.real_form.harmonics.shape[-3])

    @property
    def _paired_structure(self) -> Structure | None:
        """Structure by which multipliers come in mu, 1 / mu; None without one."""
        if self.order % 2 or self.is_complex:
            return None
        half = self.order // 2
        blocks = self.every_matrix
        if all(matrices.symmetric(np.concatenate([m[..., half:, :], -m[..., :half, :]], axis=-2)) for m in blocks):
            return "hamiltonian"
        if self.pieces:
            return None
        outer = all(
            not m[..., :half, :half].any() and not m[..., half:, half:].any() for m in (self.mean, *self.cosines)
        )
        inner = all(not m[..., :half, half:].any() and not m[..., half:, :half].any() for m in self.sines)
        return "reversible" if outer and inner else None

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
        >>> PeriodicSystem.from_pieces([(1.0, [[-1.5]]), (2.0, [[0.5]])]).plot().get_xlabel()
        '$t$, over a period of 3'
        """
        return by_pieces.draw(self, ax)

    def coefficient(self, t: Any) -> Any:
        """Return A(t), of shape ``(*t.shape, N, N)``, the mean of both sides at a jump; of one system.

        Complex where the system is.

        Returns
        -------
        ndarray
            (..., N, N), behind the shape of ``t``.

        Raises
        ------
        TypeError, ValueError
            For instants other than finite numbers, and for a batch.
        """
        return by_pieces.value_at(self, t)
