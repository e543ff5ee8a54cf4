"""Arrays of balls with any number of digits: midpoints are Python integers times a power of two, radii are doubles.

numpy holds the integers in arrays of objects, real and imaginary parts apart.  Sums and products of integers are exact;
a bound on the bits cut off is added to the radii.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from floquetrod.floquet.proof.balls import Array, up
from floquetrod.floquet.proof.many_digits import TooMuchWork, Unresolved

_LARGEST_WORK = 2e7  # multiplications, several seconds' worth (heuristic)
_GUARD = 20  # bits beyond the digits asked for
_ROUND = 2.0**-52


class Wide:
    """An array of balls: all arrays whose entries are within ``rad`` of (``real`` + i ``imaginary``) / 2^``bits``."""

    __array_ufunc__ = None
    __slots__ = ("bits", "imaginary", "rad", "real")

    def __init__(self, real: Array, imaginary: Array | None, rad: Array, bits: int) -> None:
        """Take integers in arrays of objects, None where all imaginary parts are zero, and radii of the same shape."""
        self.real, self.rad, self.bits = np.asarray(real, dtype=object), rad, bits
        self.imaginary = None if imaginary is None else np.asarray(imaginary, dtype=object)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array."""
        return tuple(self.rad.shape)

    @property
    def is_real(self) -> bool:
        """Whether the midpoints have no imaginary part."""
        return self.imaginary is None

    def _like(self, real: Array, imaginary: Array | None, rad: Array) -> Wide:
        return Wide(real, imaginary, rad, self.bits)

    def _size(self) -> Array:
        """Return the moduli of the midpoints, to some digits."""
        real = _doubles(self.real, self.bits)
        return np.abs(real) if self.imaginary is None else np.hypot(real, _doubles(self.imaginary, self.bits))

    def upper(self) -> Array:
        """Return an upper bound of each modulus, as doubles."""
        return up(up(self._size()) + self.rad)

    def ends(self) -> tuple[Fraction, Fraction]:
        """Return exact ends of what a single real ball holds; `Unresolved` where it is not finite."""
        if not np.isfinite(self.rad):
            raise Unresolved("the map over a period is too large")
        mid, rad = Fraction(int(self.real), 1 << self.bits), Fraction(float(self.rad))
        return mid - rad, mid + rad

    def lower(self) -> Array:
        """Return a lower bound of each modulus, as doubles."""
        return np.maximum(self._size() * (1.0 - 1e-11) - self.rad, 0.0) * (1.0 - _ROUND)

    def centre(self) -> Array:
        """Return the doubles nearest to the midpoints."""
        real = _doubles(self.real, self.bits)
        return real if self.imaginary is None else real + 1j * _doubles(self.imaginary, self.bits)

    def offset(self) -> Array:
        """Return an upper bound of the distance between an entry and the one of `centre`."""
        return up(self.rad + 4.0 * _ROUND * self._size())

    def centred(self) -> tuple[Wide, Array]:
        """Return the midpoints as balls without radius, and the radii."""
        return self._like(self.real, self.imaginary, np.zeros(self.shape)), self.rad

    def each(self, function: Callable[[Array], Array]) -> Wide:
        """Return the balls rearranged by a function such as a transposition."""
        imaginary = None if self.imaginary is None else function(self.imaginary)
        return self._like(function(self.real), imaginary, function(self.rad))

    def __getitem__(self, index: Any) -> Wide:
        return self.each(lambda a: np.asarray(a[index], dtype=a.dtype))

    def __setitem__(self, index: Any, value: Wide) -> None:
        self.real[index] = _items(value.real)
        self.rad[index] = value.rad
        if self.imaginary is not None:
            self.imaginary[index] = 0 if value.imaginary is None else _items(value.imaginary)
        elif value.imaginary is not None:
            raise TypeError("complex entries for an array of real ones")

    def adjoint(self) -> Wide:
        """Return the conjugate of the transposed matrix."""
        swapped = self.each(lambda a: a.swapaxes(-1, -2))
        return swapped if swapped.imaginary is None else self._like(swapped.real, -swapped.imaginary, swapped.rad)

    def parts(self) -> tuple[Wide, Wide]:
        """Return the real and the imaginary part."""
        imaginary = self.real * 0 if self.imaginary is None else self.imaginary
        return self._like(self.real, None, self.rad), self._like(imaginary, None, self.rad)

    def times_i(self) -> Wide:
        """Return the product with the imaginary unit."""
        imaginary = self.real * 0 if self.imaginary is None else self.imaginary
        return self._like(-imaginary, self.real, self.rad)

    def widened(self, radius: Array) -> Wide:
        """Return balls with so much larger radii."""
        return self._like(self.real, self.imaginary, up(self.rad + radius))

    def __neg__(self) -> Wide:
        return self._like(-self.real, None if self.imaginary is None else -self.imaginary, self.rad)

    def __add__(self, other: Wide) -> Wide:
        real = self.real + other.real
        if self.imaginary is None and other.imaginary is None:
            imaginary = None
        else:
            imaginary = _zero_for_none(self.imaginary) + _zero_for_none(other.imaginary)
            imaginary = imaginary + real * 0  # broadcast
        return self._like(real, imaginary, up(self.rad + other.rad))

    def __sub__(self, other: Wide) -> Wide:
        return self + -other

    def __mul__(self, other: Wide) -> Wide:
        return self._product(other, lambda a, b: a * b)

    def __matmul__(self, other: Wide) -> Wide:
        return self._product(other, lambda a, b: a @ b)

    def _product(self, other: Wide, times: Callable[[Array, Array], Array]) -> Wide:
        """Return a product, bilinear and with sums of products of entries."""
        real, imaginary = times(self.real, other.real), None
        if self.imaginary is not None and other.imaginary is not None:
            real = real - times(self.imaginary, other.imaginary)
            imaginary = times(self.imaginary, other.real) + times(self.real, other.imaginary)
        elif self.imaginary is not None:
            imaginary = times(self.imaginary, other.real)
        elif other.imaginary is not None:
            imaginary = times(self.real, other.imaginary)
        size, other_size = up(self._size()), up(other._size())
        rad = up(up(times(size, other.rad) + times(self.rad, up(other_size + other.rad))) + 2.0 ** (1 - self.bits))
        return self._like(real >> self.bits, None if imaginary is None else imaginary >> self.bits, rad)

    def over(self, divisor: int) -> Wide:
        """Return the quotient by a positive integer."""
        imaginary = None if self.imaginary is None else self.imaginary // divisor
        return self._like(self.real // divisor, imaginary, up(self.rad / divisor + 2.0 ** (1 - self.bits)))

    def inverse(self) -> Wide:
        """Return the reciprocals of real balls without zero."""
        least = self.lower()
        if not (least > 0.0).all() or self.imaginary is not None:
            raise Unresolved("a number cannot be distinguished from zero")
        real = np.asarray((1 << (2 * self.bits)) // self.real, dtype=object)
        with np.errstate(over="ignore"):
            return self._like(real, None, up(up(self.rad / least) / least + 2.0 ** (1 - self.bits)))

    def shifted(self, power: Array) -> Wide:
        """Return the product with powers of two, given as doubles."""
        shift = np.frexp(power)[1] - 1
        imaginary = None if self.imaginary is None else _shift(self.imaginary, shift)
        return self._like(_shift(self.real, shift), imaginary, up(self.rad * power + 2.0 ** (1 - self.bits)))

    def sum(self, axis: int) -> Wide:
        """Return the sum along an axis."""
        imaginary = None if self.imaginary is None else self.imaginary.sum(axis)
        return self._like(self.real.sum(axis), imaginary, up(self.rad.sum(axis)))


def _items(array: Array) -> Array:
    """Return an array for assignment; one without axes as the number it holds."""
    return array.item() if np.ndim(array) == 0 and isinstance(array, np.ndarray) else array


def _zero_for_none(array: Array | None) -> Array:
    return 0 if array is None else array


_shift = np.frompyfunc(lambda value, by: value << int(by) if by >= 0 else value >> int(-by), 2, 1)


def _doubles(integers: Array, bits: int) -> Array:
    """Return integers / 2^bits as doubles, infinite where too large."""
    return np.asarray(np.frompyfunc(lambda value: _double(value, bits), 1, 1)(integers), dtype=float)


def _double(value: int, bits: int) -> float:
    excess = value.bit_length() - 64
    try:
        return math.ldexp(float(value >> excess), excess - bits) if excess > 0 else math.ldexp(float(value), -bits)
    except OverflowError:
        return math.inf


class Integers:
    """Fixed-point arithmetic with integers, with the given number of digits after the point."""

    def __init__(self, digits: int) -> None:
        """Take the decimal digits to work with."""
        import mpmath

        self.digits = digits
        self.bits = math.ceil(digits * math.log2(10.0)) + _GUARD
        self._context = mpmath.mp.clone()
        self._context.prec = self.bits + 30

    def check_work(self, operations: float) -> None:
        """Raise `TooMuchWork` where that many multiplications would take too long."""
        if operations * (1.0 + self.bits / 2000.0) > _LARGEST_WORK:
            raise TooMuchWork(f"{operations:.0e} multiplications with {self.digits} digits")

    def exact(self, array: Array) -> Wide:
        """Return an array of doubles as the exact numbers they are, except for what lies below the last bit."""
        array = np.asarray(array)
        real, rest = self._integers(np.real(array))
        if not np.iscomplexobj(array):
            return Wide(real, None, rest, self.bits)
        imaginary, other = self._integers(np.imag(array))
        return Wide(real, imaginary, rest + other, self.bits)

    def _integers(self, array: Array) -> tuple[Array, Array]:
        """Return doubles times 2^bits, rounded down, and bounds of what that leaves."""
        divided: Any = np.frompyfunc(self._divided, 1, 2)(array)
        return np.asarray(divided[0], dtype=object), np.asarray(divided[1], dtype=float) * 2.0**-self.bits

    def _divided(self, value: float) -> tuple[int, float]:
        top, bottom = float(value).as_integer_ratio()
        whole, rest = divmod(top << self.bits, bottom)
        return whole, 1.0 if rest else 0.0

    def rational(self, value: Fraction) -> Wide:
        """Enclose an exact number."""
        whole, rest = divmod(value.numerator << self.bits, value.denominator)
        return Wide(whole, None, np.array(2.0**-self.bits if rest else 0.0), self.bits)

    def zeros(self, shape: Sequence[int], *, real: bool) -> Wide:
        """Return zeros."""
        zeros = np.zeros(shape, dtype=object)
        return Wide(zeros, None if real else zeros.copy(), np.zeros(shape), self.bits)

    def join(self, pieces: Sequence[Wide], axis: int) -> Wide:
        """Concatenate real arrays along an axis."""
        real = np.concatenate([piece.real for piece in pieces], axis)
        return Wide(real, None, np.concatenate([piece.rad for piece in pieces], axis), self.bits)

    def two_pi(self) -> Wide:
        """Enclose 2 pi."""
        return self._enclosed(np.array(2 * self._context.pi))

    def turns(self, fractions: Array) -> tuple[Wide, Wide]:
        """Enclose cos and sin of 2 pi times doubles or Fractions in [-1/2, 1/2]."""
        functions = (self._context.cospi, self._context.sinpi)
        cosine, sine = (
            self._enclosed(np.frompyfunc(lambda value, f=function: f(self._doubled(value)), 1, 1)(fractions))
            for function in functions
        )
        return cosine, sine

    def _doubled(self, value: float | Fraction) -> Any:
        exact = 2 * Fraction(value)
        return self._context.mpf(exact.numerator) / exact.denominator

    def _enclosed(self, numbers: Array) -> Wide:
        """Return numbers of mpmath, 30 bits finer than ours, as balls; the last of those bits may be wrong."""
        integers = np.frompyfunc(lambda value: int(self._context.ldexp(value, self.bits)), 1, 1)(numbers)
        return Wide(integers, None, np.full(np.shape(numbers), 2.0 ** (2 - self.bits)), self.bits)

    def eigenvectors(self, matrix: Wide) -> tuple[Wide, Wide]:
        """Return about the eigenvectors of a real matrix, as columns, and the inverse of their matrix."""
        context, n = self._context, matrix.shape[0]
        entries = [[context.ldexp(context.mpf(value), -self.bits) for value in row] for row in matrix.real.tolist()]
        try:
            vectors = context.eig(context.matrix(entries))[1]
            pair = vectors, context.inverse(vectors)
        except (ZeroDivisionError, RuntimeError):
            raise Unresolved("a multiple multiplier cannot be excluded") from None
        columns, inverse = (
            np.array([[context.mpc(array[i, j]) for j in range(n)] for i in range(n)], dtype=object) for array in pair
        )
        return self._nearest(columns), self._nearest(inverse)

    def _nearest(self, numbers: Array) -> Wide:
        """Return complex numbers of mpmath, cut off, as balls without radius."""
        real, imaginary = (
            np.frompyfunc(lambda value, of=of: int(self._context.ldexp(getattr(value, of), self.bits)), 1, 1)(numbers)
            for of in ("real", "imag")
        )
        return Wide(real, imaginary, np.zeros(numbers.shape), self.bits)

    def reduced(self, matrix: Wide) -> Wide:
        """Return a diagonal matrix that is congruent to a Hermitian one, close to diagonal: its pivots."""
        n = matrix.shape[0]
        order = np.argsort(-np.abs(matrix.centre()[np.arange(n), np.arange(n)]))
        rest = matrix.each(lambda a: a[np.ix_(order, order)])
        pivots = self.zeros((n, n), real=True)
        for k in range(n):
            pivot = rest[0, 0].parts()[0]
            pivots[k, k] = pivot
            if k < n - 1:
                column = rest[1:, :1]
                rest = rest[1:, 1:] - column @ column.adjoint() * pivot.inverse()
        return pivots
