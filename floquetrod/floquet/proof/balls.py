"""Arrays of balls in double precision: a midpoint and a radius for each entry, real or complex.

numpy computes the midpoints; a bound on its rounding errors, known beforehand, is added to the radii (S. M. Rump, Acta
Numerica 19, 2010).  The bounds hold for any order of summation and with fused operations.  The radii are rounded too: a
factor and an addend cover that.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from floquetrod.floquet.proof.many_digits import TooMuchWork, Unresolved

_UNIT = 2.0**-53  # largest relative error of one rounding
_SLACK = 1.0 + 1e-11  # radii: sums of up to 10,000 terms, several after each other
_TINY = 1e-290  # far above what underflow loses in such a sum

_LARGEST_WORK = 1e10  # several seconds' worth (heuristic)

Array = Any


def up(value: Array) -> Array:
    """Return an upper bound of a non-negative number that doubles computed in a few sums and products."""
    return value * _SLACK + _TINY


def down(value: Array) -> Array:
    """Return a lower bound of a number that doubles computed in a few sums and products of non-negative numbers."""
    return value / _SLACK - _TINY


class Balls:
    """An array of balls: all arrays whose entries are within ``rad`` of the entries of ``mid``."""

    __array_ufunc__ = None  # numpy leaves products with arrays to this class
    __slots__ = ("mid", "rad")

    def __init__(self, mid: Array, rad: Array) -> None:
        """Take midpoints, and radii of the same shape."""
        self.mid = mid
        self.rad = rad

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array."""
        return tuple(self.mid.shape)

    @property
    def is_real(self) -> bool:
        """Whether the midpoints have no imaginary part."""
        return not np.iscomplexobj(self.mid)

    def upper(self) -> Array:
        """Return an upper bound of each modulus, as doubles."""
        return up(np.abs(self.mid) + self.rad)

    def centre(self) -> Array:
        """Return the midpoints as doubles."""
        return self.mid

    def offset(self) -> Array:
        """Return an upper bound of the distance between an entry and the one of `centre`."""
        return self.rad

    def ends(self) -> tuple[Fraction, Fraction]:
        """Return exact ends of what a single real ball holds; `Unresolved` where it is not finite."""
        if not np.isfinite(self.mid + self.rad):
            raise Unresolved("the map over a period is too large")
        mid, rad = Fraction(float(self.mid)), Fraction(float(self.rad))
        return mid - rad, mid + rad

    def lower(self) -> Array:
        """Return a lower bound of each modulus, as doubles."""
        return np.maximum(down(np.abs(self.mid)) - self.rad, 0.0) * (1.0 - 4.0 * _UNIT)

    def centred(self) -> tuple[Balls, Array]:
        """Return the midpoints as balls without radius, and the radii."""
        return Balls(self.mid, np.zeros(self.shape)), self.rad

    def each(self, function: Callable[[Array], Array]) -> Balls:
        """Return the balls rearranged by a function such as a transposition."""
        return Balls(function(self.mid), function(self.rad))

    def __getitem__(self, index: Any) -> Balls:
        return Balls(self.mid[index], self.rad[index])

    def __setitem__(self, index: Any, value: Balls) -> None:
        self.mid[index] = value.mid
        self.rad[index] = value.rad

    def adjoint(self) -> Balls:
        """Return the conjugate of the transposed matrix."""
        return Balls(np.conj(self.mid).swapaxes(-1, -2), self.rad.swapaxes(-1, -2))

    def parts(self) -> tuple[Balls, Balls]:
        """Return the real and the imaginary part."""
        return Balls(np.real(self.mid).copy(), self.rad), Balls(np.imag(self.mid).copy(), self.rad)

    def times_i(self) -> Balls:
        """Return the product with the imaginary unit."""
        return Balls(1j * self.mid, self.rad)

    def widened(self, radius: Array) -> Balls:
        """Return balls with so much larger radii."""
        return Balls(self.mid, up(self.rad + radius))

    def __neg__(self) -> Balls:
        return Balls(-self.mid, self.rad)

    def __add__(self, other: Balls) -> Balls:
        mid = self.mid + other.mid
        return Balls(mid, up(self.rad + other.rad + _UNIT * np.abs(mid)))

    def __sub__(self, other: Balls) -> Balls:
        return self + -other

    def __mul__(self, other: Balls) -> Balls:
        size, other_size = np.abs(self.mid), np.abs(other.mid)
        rad = size * (other.rad + 4.0 * _UNIT * other_size) + self.rad * (other_size + other.rad)
        return Balls(self.mid * other.mid, up(rad))

    def __matmul__(self, other: Balls) -> Balls:
        size, other_size = np.abs(self.mid), np.abs(other.mid)
        error = 4.0 * (self.shape[-1] + 2) * _UNIT
        rad = size @ (other.rad + error * other_size)
        if self.rad.any():
            rad = rad + self.rad @ (other_size + other.rad)
        return Balls(self.mid @ other.mid, up(rad))

    def over(self, divisor: int) -> Balls:
        """Return the quotient by a positive integer."""
        mid = self.mid / divisor
        return Balls(mid, up(self.rad / divisor + 2.0 * _UNIT * np.abs(mid)))

    def shifted(self, power: Array) -> Balls:
        """Return the product with powers of two, given as doubles."""
        return Balls(self.mid * power, up(self.rad * power))

    def sum(self, axis: int) -> Balls:
        """Return the sum along an axis."""
        error = 2.0 * self.shape[axis] * _UNIT
        rad = (self.rad + error * np.abs(self.mid)).sum(axis)
        return Balls(self.mid.sum(axis), up(rad))


class Doubles:
    """Arithmetic with doubles, 15 digits."""

    digits = 15

    def exact(self, array: Array) -> Balls:
        """Return an array of doubles as the exact numbers they are."""
        mid = np.asarray(array)
        mid = mid.astype(complex if np.iscomplexobj(mid) else float)
        return Balls(mid, np.zeros(mid.shape))

    def rational(self, value: Fraction) -> Balls:
        """Enclose an exact number."""
        mid = float(value)
        return Balls(np.array(mid), np.array(0.0 if Fraction(mid) == value else up(_UNIT * abs(mid))))

    def check_work(self, operations: float) -> None:
        """Raise `TooMuchWork` where that many multiplications would take too long."""
        if operations > _LARGEST_WORK:
            raise TooMuchWork(f"{operations:.0e} multiplications")

    def zeros(self, shape: Sequence[int], *, real: bool) -> Balls:
        """Return zeros."""
        return Balls(np.zeros(shape, dtype=float if real else complex), np.zeros(shape))

    def join(self, pieces: Sequence[Balls], axis: int) -> Balls:
        """Concatenate arrays along an axis."""
        return Balls(
            np.concatenate([piece.mid for piece in pieces], axis), np.concatenate([piece.rad for piece in pieces], axis)
        )

    def eigenvectors(self, matrix: Balls) -> tuple[Balls, Balls]:
        """Return about the eigenvectors of a matrix, as columns, and the inverse of their matrix."""
        try:
            vectors = np.linalg.eig(matrix.mid)[1]
            return self.exact(vectors), self.exact(np.linalg.inv(vectors))
        except np.linalg.LinAlgError:
            raise Unresolved("a multiple multiplier cannot be excluded") from None

    def reduced(self, matrix: Balls) -> Balls:
        """Return a congruent matrix that is closer to a diagonal one: with doubles, the same."""
        return matrix

    def two_pi(self) -> Balls:
        """Enclose 2 pi."""
        return Balls(np.array(2.0 * np.pi), np.array(2.5e-16))

    def turns(self, fractions: Array) -> tuple[Balls, Balls]:
        """Enclose cos and sin of 2 pi times doubles or Fractions in [-1/2, 1/2]."""
        angles = 2.0 * np.pi * np.asarray(fractions, dtype=float)
        rad = np.full(angles.shape, 2e-15)
        return Balls(np.cos(angles), rad), Balls(np.sin(angles), rad)
