"""Any number of digits: power series in t = tan(theta / 2), summed in fixed point over one full period.

With theta = 2 pi tau / period measured from the middle of a piece of the period, and r = exp(i theta),

    t = tan(theta / 2),   d theta = 2 dt / (1 + t^2),   r = (1 + i t) / (1 - i t),

so that A'' + 2 c A' = p A becomes a system with polynomial coefficients for A, B = A' and W_k = r^k A:

    (1 + t^2) A_t = 2 B,   (1 + t^2) B_t = 2 (p A - 2 c B),   (1 - i t) W_k = (1 + i t) W_(k-1),   W_0 = A,

with p A = mean A + sum_k Re(z_k W_k).  Its power series have radius 1 and recurrences of fixed length; even and odd
terms give the solution at both ends of the piece at once.  Where p has a slope, the power series is that in theta
itself; where all pieces of p are constant, the map is a product of exponentials.  The damping is integrated as it
stands and symmetries are not used: what the other methods derive by substitution or factorisation is checked here, not
assumed.

The map over a period is computed twice, in pieces of other length and origin and with other precision.  The error is
estimated from their difference and from Liouville's formula det M = exp(-2 c period); neither is a proven bound.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple

from floquetrod._util import validate
from floquetrod.equations import Equation, require
from floquetrod.floquet.fixed_point import GUARD_BITS, PrecisePiece, multiply, period_map
from floquetrod.floquet.proof.many_digits import TooMuchWork
from floquetrod.floquet.status import status_of
from floquetrod.floquet.verdict import Cost, Stability, classify

_LARGEST_RAISE = 20  # working digits go up to this many times the digits asked for (heuristic)
_LARGEST_WORK = 3e6  # terms of series times their cost, a few seconds' worth (heuristic)
_LARGEST_SIZE = 1e18  # of period^2 (abs(p) + c^2): beyond it no series is short enough, nor a double able to tell
_SETTLED = 2.0**60  # times its error: an excess that large is known as well as a double can hold it
_PIECES_PER_WAVE = 0.35  # pieces of the period per unit of sqrt(largest abs(p) + c^2), measured to be fastest
_MOST_DIGITS = 20_000  # that may be asked for: constant pieces take seconds, others give up before (a choice)
_LEAST_PIECES = 7  # the fewest for which tan(theta / 2) stays below 1/4


class DiscriminantExcess(NamedTuple):
    """The undamped discriminant D_u to many digits: its sign, X = (abs(D_u) - 2) / 4, the error of X, terms summed.

    ``excess`` and ``error`` are numbers of mpmath that hold all digits whatever the current precision.
    """

    sign: int
    excess: Any
    error: Any
    terms: int


def reference(equation: Equation, *, digits: int = 50) -> Stability:
    """Classify an equation with ``digits`` correct digits of its discriminant.

    Parameters
    ----------
    equation : Equation
        The parameters are taken as the exact binary numbers they are.
    digits : int
        Decimal digits of the excess X relative to max(1, abs(X)), 10 to 20,000.  More are used internally, up to 20
        times as many, while X cannot be distinguished from zero.

    Returns
    -------
    Stability
        Its ``error`` is an estimate: the difference of two computations, and Liouville's formula (see the module).
        "undecided" when X is zero within the digits allowed, or when the work would take more than a few seconds.

    Raises
    ------
    TypeError, ValueError
        For anything but an equation, and for ``digits`` other than a whole number from 10 to 20,000.

    Examples
    --------
    >>> from floquetrod.equations import Mathieu
    >>> reference(Mathieu(alpha=1e-8, beta=-0.25)).growth_rate
    5e-09
    """
    from mpmath.ctx_mp import MPContext

    try:
        computed = discriminant_excess(equation, digits)
    except TooMuchWork as reason:
        return Stability.declined(equation, "reference", Cost(0, "terms"), str(reason))
    context = MPContext()
    context.dps = 2 * digits + 20
    excess, error = (context.mpf(number) for number in (computed.excess, computed.error))
    status = status_of(excess, error)
    mantissa, exponent = _split(excess)
    compared = equation.damping > 0.0 and status == "unstable"
    return classify(
        equation,
        "reference",
        sign=computed.sign,
        excess=mantissa,
        exponent=exponent,
        excess_error=float(error / max(1, abs(excess))),
        undamped_status=status,
        growth=_net_growth(equation, context, excess, error) if compared else None,
        cost=Cost(computed.terms, "terms"),
    )


def discriminant_excess(equation: Equation, digits: int = 50) -> DiscriminantExcess:
    """Return the undamped excess X of an equation with its sign and error, as numbers of mpmath.

    Parameters
    ----------
    equation : Equation
        The parameters are taken as the exact binary numbers they are.
    digits : int
        Decimal digits of X relative to max(1, abs(X)), 10 to 20,000.

    Returns
    -------
    DiscriminantExcess
        Its ``sign``, ``excess``, ``error`` and ``terms``.

    Raises
    ------
    TooMuchWork
        When even a first attempt would take more than a few seconds.
    TypeError, ValueError
        For anything but an equation, and for ``digits`` other than a whole number from 10 to 20,000.

    Examples
    --------
    >>> from floquetrod.equations import Mathieu
    >>> found = discriminant_excess(Mathieu(alpha=0.0, beta=1.0), 30)  # X = sinh(pi)^2
    >>> str(found.excess)[:14], found.error < 1e-27
    ('133.3733807418', True)
    """
    import mpmath

    require(equation)
    digits = validate.integer("digits", digits, 10, _MOST_DIGITS)
    wanted, terms = digits, 0
    result: DiscriminantExcess | None = None
    while True:
        try:
            sign, excess, error, used = _attempt(equation, wanted)
        except TooMuchWork:
            if result is None:
                raise
            return result
        terms += used
        result = DiscriminantExcess(sign, mpmath.mp.make_mpf(excess._mpf_), mpmath.mp.make_mpf(error._mpf_), terms)
        settled = equation.level is not None or abs(excess) > error * _SETTLED
        missing = math.ceil(excess.context.log(error / max(1, abs(excess)), 10)) + digits
        if (settled and missing <= 0) or wanted >= _LARGEST_RAISE * digits:
            return result
        wanted = min(2 * wanted if missing <= 0 else wanted + missing, _LARGEST_RAISE * digits)


def _attempt(equation: Equation, digits: int) -> tuple[int, Any, Any, int]:
    """Return sign, X, its error and the terms summed, from working digits of about ``digits``."""
    from mpmath.ctx_mp import MPContext

    context = MPContext()
    context.prec = math.ceil(digits * math.log2(10.0)) + 2 * GUARD_BITS + 32
    if all(piece.is_constant for piece in equation.pieces()):
        trace, error, terms = _closed_form(equation, context)
    else:
        trace, error, terms = _twice(equation, context, digits)
    return (1 if trace >= 0 else -1), (abs(trace) - 2) / 4, error / 4, terms


def _closed_form(equation: Equation, context: Any) -> tuple[Any, Any, int]:
    """Return the undamped trace and its error for a coefficient made of constant pieces, and the entries computed.

    The exponential of h [[0, 1], [l, -2 c]] is exp(-c h) [C + c S, S; l S, C - c S] with C = cosh(h w),
    S = sinh(h w) / w and w^2 = l + c^2; entire in w^2.
    """
    stretches, damping = _stretches(equation, context)
    size = 4 * context.pi**2 * (max(stretch.size for stretch in stretches) + damping**2)
    _check_size(size)
    bits = context.prec - GUARD_BITS
    context.prec += max(0, context.mag(size))  # what the arguments of the sines lose
    stretches, damping = _stretches(equation, context)
    one, zero = context.one, context.zero
    total, sizes = (one, zero, zero, one), (one, zero, zero, one)
    for stretch in stretches:
        square = stretch.mean + damping**2
        root = context.sqrt(abs(square))
        if square > 0:
            even, odd = context.cosh(stretch.length * root), context.sinh(stretch.length * root) / root
        elif square < 0:
            even, odd = context.cos(stretch.length * root), context.sin(stretch.length * root) / root
        else:
            even, odd = one, stretch.length
        entries = (even + damping * odd, odd, stretch.mean * odd, even - damping * odd)
        total, sizes = multiply(entries, total), multiply(tuple(map(abs, entries)), sizes)
    return total[0] + total[3], context.ldexp(len(stretches) * (sizes[0] + sizes[3]), -bits), 4 * len(stretches)


def _twice(equation: Equation, context: Any, digits: int) -> tuple[Any, Any, int]:
    """Return the undamped trace, its estimated error and the terms summed, from two maps over the period."""
    stretches, damping = _stretches(equation, context)
    size = max(stretch.size for stretch in stretches) + damping**2
    _check_size(4 * context.pi**2 * size)
    harmonics = max(len(stretch.harmonics) for stretch in stretches)
    pieces = max(_LEAST_PIECES, math.ceil(_PIECES_PER_WAVE * math.pi * math.sqrt(size))) + len(stretches) - 1
    bits = math.ceil(digits * math.log2(10.0)) + GUARD_BITS + math.ceil(math.log2(pieces * (1.0 + size)))
    _check_work(pieces, bits, harmonics)
    context.prec = bits + 2 * GUARD_BITS
    stretches, damping = _stretches(equation, context)
    undamp = context.exp(2 * context.pi * damping)
    traces, terms = [], 0
    error = context.zero
    # The first of the two maps has more digits.
    for more, other, offset in ((GUARD_BITS, 0, 0.0), (0, 1, 0.6180339887)):
        matrix, exponent, used = period_map(stretches, damping, context, pieces, other, bits + more, offset)
        a, b, c, d = (undamp * context.ldexp(entry, exponent) for entry in matrix)
        norm = max(map(abs, (a, b, c, d, context.one)))
        liouville = abs(a * d - b * c - 1) / norm
        error = max(error, liouville, context.ldexp(norm, GUARD_BITS // 2 - bits))
        traces.append(a + d)
        terms += used
    return traces[0], max(error, abs(traces[0] - traces[1])), terms


def _stretches(equation: Equation, context: Any) -> tuple[list[PrecisePiece], Any]:
    """Return the pieces and the damping of an equation with time in units of period / 2 pi."""
    unit = _period(equation, context) / (2 * context.pi)
    pieces, share = [], Fraction(0)
    for piece in equation.pieces():
        begin, length = (2 * context.pi * _exactly(part, context) for part in (share, piece.share))
        harmonics = tuple((unit**2 * context.mpf(z.real), unit**2 * context.mpf(z.imag)) for z in piece.harmonics)
        mean, slope = unit**2 * _exactly(piece.start, context), unit**3 * _exactly(piece.slope, context)
        pieces.append(PrecisePiece(begin, length, mean, slope, harmonics))
        share += piece.share
    return pieces, unit * context.mpf(equation.damping)


def _exactly(number: Fraction | float, context: Any) -> Any:
    """Return a number in a context's precision."""
    exact = Fraction(number)
    return context.mpf(exact.numerator) / exact.denominator


def _check_size(size: Any) -> None:
    if size > _LARGEST_SIZE:
        raise TooMuchWork("the period holds more waves than can be followed")


def _check_work(pieces: int, bits: int, harmonics: int) -> None:
    terms = 4.0 * pieces * bits / 2.0
    work = terms * (1.0 + 0.5 * harmonics) * (1.0 + (bits / 1500.0) ** 1.6)
    if work > _LARGEST_WORK:
        raise TooMuchWork(f"{pieces} pieces of the period with {bits} bits would take too long")


def _period(equation: Equation, context: Any) -> Any:
    """Return the period: the exact multiple of pi, or the double."""
    multiple = equation.period_over_pi
    return context.mpf(equation.period) if multiple is None else _exactly(multiple, context) * context.pi


def _split(excess: Any) -> tuple[float, int]:
    """Return X as mantissa and exponent: a plain double where one holds it, as a negative X always is."""
    if excess <= 0 or 1e-290 < excess < 1e290:
        return float(excess), 0
    mantissa, exponent = excess.context.frexp(excess)
    return float(mantissa), int(exponent)


def _net_growth(equation: Equation, context: Any, excess: Any, error: Any) -> tuple[float, float, float]:
    """Return growth less damping, and its bounds, with all the digits until they are rounded."""
    low, middle, high = (
        float(2 * context.asinh(context.sqrt(max(x, 0))) / _period(equation, context) - equation.damping)
        for x in (excess - error, excess, excess + error)
    )
    return low, middle, high
