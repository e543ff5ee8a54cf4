"""Intervals of doubles, rounded outwards: the same formulas give a number for floats and an enclosure for intervals."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias, Union

_INF = math.inf

Operand: TypeAlias = Union["RealInterval", float, int]
"""What arithmetic takes beside an interval: numbers stand for themselves, exactly."""


@dataclass(frozen=True, slots=True)
class RealInterval:
    """All real numbers from ``low`` to ``high``, both included.

    Sums, differences, products, quotients, whole powers and square roots enclose every value that they can take for
    numbers of their operands, each taken independently of the others.  They rely on IEEE arithmetic that rounds to
    nearest, and on nothing else.

    Raises
    ------
    ValueError
        Where ``low`` exceeds ``high``, or either is not a number.

    Examples
    --------
    >>> RealInterval(0.1, 0.1) + 0.2
    RealInterval(low=0.3, high=0.3000000000000001)
    >>> Fraction(1, 3) in RealInterval(1.0, 1.0) / 3
    True
    """

    low: float
    high: float

    __array_ufunc__ = None  # numpy leaves the arithmetic to this class

    def __post_init__(self) -> None:
        """Refuse ends in the wrong order, and NaN."""
        if not self.low <= self.high:
            raise ValueError(f"an interval needs low <= high, got {self.low!r} and {self.high!r}")

    @classmethod
    def of(cls, value: Operand | Fraction) -> RealInterval:
        """Return the interval itself, or the smallest that holds an exact number."""
        if isinstance(value, RealInterval):
            return value
        if isinstance(value, float):
            return cls(float(value), float(value))
        try:
            nearest = float(value)
        except OverflowError:
            edge = math.nextafter(_INF, 0.0)
            return cls(edge, _INF) if value > 0 else cls(-_INF, -edge)
        low = nearest if nearest <= value else math.nextafter(nearest, -_INF)
        high = nearest if nearest >= value else math.nextafter(nearest, _INF)
        return cls(low, high)

    @classmethod
    def hull(cls, values: Iterable[Operand | Fraction]) -> RealInterval:
        """Return the smallest interval that holds all of some numbers and intervals."""
        intervals = [cls.of(value) for value in values]
        return cls(min(interval.low for interval in intervals), max(interval.high for interval in intervals))

    @property
    def width(self) -> float:
        """The difference of the ends, rounded up."""
        return up(self.high - self.low) if self.high > self.low else 0.0

    @property
    def middle(self) -> float:
        """A number of the interval, halfway up to rounding."""
        middle = 0.5 * self.low + 0.5 * self.high
        return min(max(middle, self.low), self.high)

    def halves(self) -> tuple[RealInterval, RealInterval]:
        """Return the parts below and above the middle, which belongs to both."""
        return RealInterval(self.low, self.middle), RealInterval(self.middle, self.high)

    def __contains__(self, value: float | Fraction) -> bool:
        """Return whether a number lies within."""
        return self.low <= value <= self.high

    def __neg__(self) -> RealInterval:
        return RealInterval(-self.high, -self.low)

    def __add__(self, other: Operand) -> RealInterval:
        if not isinstance(other, _KINDS):
            return NotImplemented
        x = RealInterval.of(other)
        if x.low == x.high == 0.0:
            return self
        if self.low == self.high == 0.0:
            return x
        return RealInterval(down(self.low + x.low), up(self.high + x.high))

    __radd__ = __add__

    def __sub__(self, other: Operand) -> RealInterval:
        if not isinstance(other, _KINDS):
            return NotImplemented
        return self + -RealInterval.of(other)

    def __rsub__(self, other: Operand) -> RealInterval:
        if not isinstance(other, _KINDS):
            return NotImplemented
        return RealInterval.of(other) + -self

    def __mul__(self, other: Operand) -> RealInterval:
        if not isinstance(other, _KINDS):
            return NotImplemented
        x = RealInterval.of(other)
        pairs = [_product(a, b) for a in (self.low, self.high) for b in (x.low, x.high)]
        return RealInterval(min(low for low, _ in pairs), max(high for _, high in pairs))

    __rmul__ = __mul__

    def __truediv__(self, other: Operand) -> RealInterval:
        if not isinstance(other, _KINDS):
            return NotImplemented
        x = RealInterval.of(other)
        if 0.0 in x:
            raise ZeroDivisionError(f"division by {x!r}, which holds 0")
        pairs = [_quotient(a, b) for a in (self.low, self.high) for b in (x.low, x.high)]
        return RealInterval(min(low for low, _ in pairs), max(high for _, high in pairs))

    def __rtruediv__(self, other: Operand) -> RealInterval:
        if not isinstance(other, _KINDS):
            return NotImplemented
        return RealInterval.of(other) / self

    def __abs__(self) -> RealInterval:
        if self.low >= 0.0:
            return self
        return -self if self.high <= 0.0 else RealInterval(0.0, max(-self.low, self.high))

    def __pow__(self, power: int) -> RealInterval:
        if not isinstance(power, int) or power < 0:
            return NotImplemented
        base = abs(self) if power % 2 == 0 else self  # of one variable: not the product of independent factors
        low, high = (_power(end, power) for end in (base.low, base.high))
        return RealInterval(low.low, high.high)

    def sqrt(self) -> RealInterval:
        """Return the square roots; ValueError where the interval reaches below zero."""
        if self.low < 0.0:
            raise ValueError(f"the square root needs numbers from 0 up, got {self!r}")
        low, high = math.sqrt(self.low), math.sqrt(self.high)
        return RealInterval(max(0.0, down(low)) if low else 0.0, up(high) if high else 0.0)


_KINDS = (RealInterval, float, int)

PI = RealInterval(math.pi, math.nextafter(math.pi, _INF))
"""The circle constant: the double nearest to it lies below it, by less than a unit of the last place."""


def down(x: float) -> float:
    """Return a bound from below on what was rounded to ``x``; NaN, as of infinity less infinity, bounds nothing."""
    return -_INF if math.isnan(x) else math.nextafter(x, -_INF)


def up(x: float) -> float:
    """Return a bound from above on what was rounded to ``x``."""
    return _INF if math.isnan(x) else math.nextafter(x, _INF)


def _product(a: float, b: float) -> tuple[float, float]:
    """Enclose a product, exactly where a factor is 0 or 1."""
    if a == 0.0 or b == 0.0:
        return 0.0, 0.0
    if a == 1.0 or b == 1.0:
        return a * b, a * b
    return down(a * b), up(a * b)


def _quotient(a: float, b: float) -> tuple[float, float]:
    """Enclose a quotient, exactly where it is 0 or the divisor is 1."""
    if a == 0.0 or b == 1.0:
        return a, a
    return down(a / b), up(a / b)


def _power(base: float, power: int) -> RealInterval:
    """Enclose a whole power of a number."""
    result = RealInterval(1.0, 1.0)
    for _ in range(power):
        result = result * base
    return result
