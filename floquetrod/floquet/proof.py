"""Verdicts that are proofs: the deciding signs are found in interval arithmetic, with parameters taken exactly.

Every number is enclosed between two others, rounded outwards (mpmath's intervals; only their sums, products, quotients
and pi are used, the latter widened).  A sign is used only when the whole interval has it; otherwise the precision is
raised, and where it may not be raised any further the answer is "undecided".

*Mathieu, by counting.*  With a = -4 beta, q = 2 abs(alpha), the solutions are bounded exactly when an odd number of
characteristic values lies below a and none at it (DLMF 28.2, 28.4).  They are the eigenvalues of four symmetric
tridiagonal chains with diagonals D_k and squared couplings e_k; the negative pivots d_k = D_k - a - e_(k-1) / d_(k-1)
are counted.  A pivot that may be zero is taken together with the next: the pair [d, e; e, x] has one eigenvalue of
each sign if d x - e^2 < 0, and the pivot after it is D - a - q^2 d / (d x - e^2).

*Why a finite number of pivots decides.*  Let K be beyond the first row, whose coupling may be larger than the others,
and let d_K > q and D_k - a >= 2 q for all k > K.  Then d_(K+1) > 2 q - q^2 / q
= q, and so on: all later pivots exceed q.  So (u, (H - a) u) = sum_k d_k (u_k + sqrt(e_k) u_(k+1) / d_k)^2 has n
negative terms, n the count, and is positive on the subspace of codimension n where these vanish: were it zero there,
u_k = -(sqrt(e_k) / d_k) u_(k+1) would make abs(u_k) grow with k for ever, and u be no element of the space.  At most n
eigenvalues of the infinite matrix are therefore <= a; at least n are < a because the finite part has n of them.

*Hill, by counting.*  Periodic and antiperiodic eigenvalues mu of -u'' + p u = mu u below zero are counted, mu = 0
lying in a band exactly when their number is odd.  In the basis cos, sin the infinite symmetric matrix [H, C; C', R]
is cut at frequency K.  With R >= delta > 0, H has at most as many negative eigenvalues as the whole, and
H - C C' / delta at least as many.  A single interval matrix that contains both is factorised: if no pivot can be
zero, both have the same count, and zero is no eigenvalue.

*Square wave.*  With l1 = beta + alpha, l2 = beta - alpha, h = pi / 2, c = cosh(h sqrt l), s = sinh(h sqrt l) / sqrt l,
the map from the middle of one half period to the middle of the next is [y1, y2; y1', y2'] =
[c2, s2; l2 s2, c2] [c1, s1; l1 s1, c1], both instants are instants of even symmetry, and

    trace - 2 = 4 y1' y2,    trace + 2 = 4 y1 y2'.

*Damping.*  A = exp(-c tau) u turns c into an addition of c^2 to the mean: bounded u prove that A decays.  Where u
grows, its trace is enclosed (by Taylor series with Cauchy's bound on what is left out) and compared with
2 cosh(c period).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from decimal import Decimal
from fractions import Fraction
from itertools import zip_longest
from typing import Any, NamedTuple

from floquetrod._util import validate
from floquetrod.equations import Equation, Hill, Mathieu, Meissner, require
from floquetrod.floquet.result import Answer, Interval, Status

_FIRST_DIGITS = 15
_LARGEST_WORK = 4e6  # interval operations, about ten seconds' worth (heuristic)
_MOST_DIGITS = 10_000  # of an exact number, and of ``max_digits`` (a choice)
_RADIUS = 4  # Taylor series are bounded on a disc of this many steps (heuristic)


class Enclosure(NamedTuple):
    """A quantity that decided, with two numbers of mpmath it lies between."""

    quantity: str
    low: Any
    high: Any

    def __str__(self) -> str:
        """Return, say, "smallest pivot in [0.5, 0.5001]"."""
        import mpmath

        return f"{self.quantity} in [{mpmath.nstr(self.low, 8)}, {mpmath.nstr(self.high, 8)}]"


@dataclass(frozen=True, repr=False)
class Proof(Answer):
    """A proved verdict, or why there is none.

    Attributes
    ----------
    equation : Equation
        The equation judged, its parameters taken as the exact binary numbers they are, but for those in ``exact``.
    status : {"stable", "unstable", "undecided"}
        What was proved; "stable": every solution stays bounded (decays, if damped and not at rest).
    interval : Interval or None
        Stability interval or tongue of the equation freed of its damping, where the proof was by counting.
    digits : int
        Decimal digits of the arithmetic that decided, or of the last attempt; 0 where no arithmetic was needed.
    statement : str
        What was proved, in a sentence.
    enclosures : tuple of Enclosure
        The quantities whose signs decided.
    exact : tuple of (str, Fraction)
        Parameters that are not binary numbers: what was proved holds for these, ``equation`` has the nearest doubles.
    """

    equation: Equation
    status: Status
    interval: Interval | None
    digits: int
    statement: str
    enclosures: tuple[Enclosure, ...] = ()
    exact: tuple[tuple[str, Fraction], ...] = field(default=(), kw_only=True)

    def __repr__(self) -> str:
        """Return the proof as a sentence."""
        where = f", {self.interval}" if self.interval is not None else ""
        where += "".join(f", {name} = {value} exactly" for name, value in self.exact)
        return f"<{self.status}{where}: {self.statement} ({self.digits} digits)>"


def certify(equation: Equation | type[Equation], *, max_digits: int = 200, **parameters: Any) -> Proof:
    """Prove an equation stable or unstable, in interval arithmetic of as many digits as it takes.

    Parameters
    ----------
    equation : Mathieu, Meissner or Hill
        A value, whose parameters are taken as the exact binary numbers they are; so is the period of a `Hill`.  Or one
        of these classes, with its parameters following.
    max_digits : int
        Decimal digits at which to stop trying, 5 to 10,000.
    **parameters
        Of the class, by name: numbers that are taken exactly, int, float, Fraction, Decimal or text such as "1/3" or
        "-0.1".  The period of a `Hill` is the double nearest to 2 pi where it is left out.

    Returns
    -------
    Proof
        "undecided" on a boundary, as far as the digits allowed can tell, or when the arithmetic would take more than
        several seconds.

    Examples
    --------
    >>> from floquetrod.equations import Mathieu
    >>> certify(Mathieu(alpha=1e-8, beta=-0.25)).status
    'unstable'

    To a double -0.25 - 1e-30 is -0.25, which lies within the tongue; the number itself does not:

    >>> certify(Mathieu, alpha="1e-30", beta=Fraction(-1, 4) - Fraction(1, 10**30)).status
    'stable'
    """
    max_digits = validate.integer("max_digits", max_digits, 5, _MOST_DIGITS)
    if isinstance(equation, type) and issubclass(equation, Equation):
        problem = _exactly(equation, parameters)
    else:
        require(equation)
        if parameters:
            names = ", ".join(parameters)
            raise TypeError(f"{names} must follow a class: certify({type(equation).__name__}, ...), not a value of it")
        problem = _problem(equation)
    return _prove(problem, max_digits)


class _Problem(NamedTuple):
    """An equation with its parameters as exact numbers.

    ``waves`` are (cosine, sine) coefficients, and a period of None is the exact 2 pi; ``equation`` holds the nearest
    doubles.
    """

    equation: Equation
    mean: Fraction
    waves: tuple[tuple[Fraction, Fraction], ...]
    damping: Fraction
    period: Fraction | None
    inexact: tuple[tuple[str, Fraction], ...]

    @property
    def alpha(self) -> Fraction:
        """Amplitude of the only wave of `Mathieu` and `Meissner`."""
        return self.waves[0][1] if self.waves else Fraction(0)

    def proof(
        self, status: Status, interval: Interval | None, digits: int, statement: str, *enclosures: Enclosure
    ) -> Proof:
        """Return the `Proof` of a verdict on it."""
        return Proof(self.equation, status, interval, digits, statement, enclosures, exact=self.inexact)


def _problem(equation: Equation) -> _Problem:
    """Return the problem of an equation, its parameters the exact binary numbers they are."""
    return _exactly(type(equation), {f.name: getattr(equation, f.name) for f in fields(equation)})


def _exactly(kind: Any, parameters: dict[str, Any]) -> _Problem:
    """Return the problem with these parameters of an equation, given by name."""
    names = [f.name for f in fields(kind)]
    unknown = [name for name in parameters if name not in names]
    if unknown:
        raise TypeError(f"{', '.join(unknown)} is no parameter of {kind.__name__}; they are {', '.join(names)}")
    exact: dict[str, Any] = {}
    for name, value in parameters.items():
        if name in ("cosines", "sines"):
            listed = validate.sequence(name, value)
            exact[name] = tuple(_exact(f"{name}[{i}]", entry) for i, entry in enumerate(listed))
        else:
            exact[name] = _exact(name, value)
    equation: Equation = kind(**{name: _nearest(name, value) for name, value in exact.items()})
    given = [
        (f"{name}[{i}]" if isinstance(values, tuple) else name, value)
        for name, values in exact.items()
        for i, value in enumerate(values if isinstance(values, tuple) else (values,))
    ]
    inexact = tuple((name, value) for name, value in given if value != Fraction(float(value)))
    damping = exact.get("damping", Fraction(0))
    if damping < 0:
        raise ValueError("damping must be zero or more, got less; growth of the free motion is not damping")
    if isinstance(equation, Hill):
        pairs = zip_longest(exact.get("cosines", ()), exact.get("sines", ()), fillvalue=Fraction(0))
        waves = [*pairs]
        while waves and waves[-1] == (0, 0):
            waves.pop()
        period = exact.get("period", Fraction(equation.period))
        return _Problem(equation, exact["mean"], tuple(waves), damping, period, inexact)
    waves = [(Fraction(0), exact["alpha"])] if exact["alpha"] else []
    return _Problem(equation, exact["beta"], tuple(waves), damping, None, inexact)


def _nearest(name: str, value: Fraction | tuple[Fraction, ...]) -> float | tuple[float, ...]:
    """Return the nearest doubles."""
    if isinstance(value, tuple):
        return tuple(validate.finite(f"{name}[{i}]", entry) for i, entry in enumerate(value))
    return validate.finite(name, value)


def _exact(name: str, value: Any) -> Fraction:
    """Return a number as the exact fraction it is."""
    if isinstance(value, str):
        if len(value) > _MOST_DIGITS:
            raise ValueError(f"{name} must have at most {_MOST_DIGITS} digits, got {len(value)}")
        top, slash, bottom = value.partition("/")
        try:
            return Fraction(int(top), int(bottom)) if slash else _exact(name, Decimal(value))
        except (ArithmeticError, ValueError) as error:
            if isinstance(error, ZeroDivisionError) or not str(error).startswith(name):
                raise ValueError(f"{name} must be a number such as '1/3' or '-0.1', got {value!r}") from None
            raise
    if isinstance(value, Fraction):
        return value
    if isinstance(value, Decimal):
        if not value.is_finite() or (value and abs(value.adjusted()) > _MOST_DIGITS):
            raise ValueError(f"{name} must be finite, its exponent at most {_MOST_DIGITS}, got {value}")
        return Fraction(value)
    if isinstance(value, int) and not isinstance(value, bool):
        return Fraction(value)
    number = validate.finite(name, value, "give a number, or text such as '1/3'")
    if value != number:
        raise ValueError(f"{name} = {value!r} is not taken exactly; give a Fraction, a Decimal or text such as '1/3'")
    return Fraction(number)


def _prove(problem: _Problem, max_digits: int) -> Proof:
    """Return the proof, with as many digits as it takes."""
    elementary = _elementary(problem)
    if elementary is not None:
        return elementary
    digits = min(_FIRST_DIGITS, max_digits)
    while True:
        try:
            return _attempt(problem, digits)
        except _Unresolved as reason:
            if digits >= max_digits:
                return problem.proof("undecided", None, digits, f"{reason} with {digits} digits")
        except _TooMuchWork as reason:
            return problem.proof("undecided", None, digits, f"{reason} are more work than is worth waiting for")
        digits = min(2 * digits, max_digits)


class _Unresolved(Exception):
    """The sign of a quantity cannot be told at the present precision."""


class _TooMuchWork(Exception):
    """The arithmetic would take longer than a caller wants to wait."""


def _elementary(problem: _Problem) -> Proof | None:
    """Return the verdict where the solutions are elementary, so that a boundary can be hit exactly."""
    if not problem.waves:
        level = problem.mean
        bounded = level < 0 or (level == 0 and problem.damping > 0)
        statement = f"the coefficient is constant and {_sign_name(level)}"
        return problem.proof("stable" if bounded else "unstable", None, 0, statement)
    if not isinstance(problem.equation, Meissner) or problem.damping > 0:
        return None
    halves = [problem.mean + sign * problem.alpha for sign in (1, -1)]
    for half, other in (halves, halves[::-1]):
        if half < 0 and half.denominator == 1 and math.isqrt(-half.numerator) ** 2 == -half:
            statement = (
                "over one half period the motion makes a whole number of half turns, so it is as bounded as with the "
                f"other half's coefficient throughout, which is {_sign_name(other)}"
            )
            return problem.proof("stable" if other < 0 else "unstable", None, 0, statement)
    return None


def _attempt(problem: _Problem, digits: int) -> Proof:
    """Prove a verdict with ``digits`` digits; raises `_Unresolved` when they are too few."""
    from mpmath.ctx_iv import MPIntervalContext

    context = MPIntervalContext()  # our own: the precision of mpmath.iv is shared by the whole process
    context.dps = digits
    if isinstance(problem.equation, Meissner):
        return _prove_square_wave(problem, context)
    try:
        if isinstance(problem.equation, Mathieu):
            count, enclosures = _count_mathieu(problem, context)
        else:
            count, enclosures = _count_hill(problem, context)
    except _Unresolved:
        if problem.damping == 0:
            raise
        return _prove_by_trace(problem, context, None)  # on a boundary of u, damping decides
    interval = Interval.from_count(count)
    known = f"{count} of Hill's periodic and antiperiodic eigenvalues lie below the equation's and none at it"
    if count % 2 == 1:
        end = "every solution decays" if problem.damping else "every solution is bounded"
        return problem.proof("stable", interval, digits, f"{known}: an odd number, so {end}", *enclosures)
    if problem.damping > 0:
        return _prove_by_trace(problem, context, interval)
    return problem.proof("unstable", interval, digits, f"{known}: an even number, so a solution grows", *enclosures)


# --- Mathieu: pivots of four tridiagonal chains ---


def _count_mathieu(problem: _Problem, context: Any) -> tuple[int, tuple[Enclosure, ...]]:
    """Return the number of characteristic values below a = -4 (beta + c^2), with the pivots closest to zero."""
    a = _rational(-4 * (problem.mean + problem.damping**2), context)
    q = _rational(2 * abs(problem.alpha), context)
    _check_work(16.0 * (20.0 + math.sqrt(8.0 * abs(problem.alpha) + max(0.0, -4.0 * problem.mean))), context)
    square = q * q
    total, enclosures = 0, []
    for name, first, shift, coupling in (
        ("even, period pi", 0, 0 * q, 2 * square),
        ("odd, period pi", 2, 0 * q, square),
        ("even, period 2 pi", 1, q, square),
        ("odd, period 2 pi", 1, -q, square),
    ):
        count, least = _count_chain(context, a, q, first, shift, coupling)
        total += count
        enclosures.append(_enclose(f"pivot closest to zero, {name}", least))
    return total, tuple(enclosures)


def _count_chain(context: Any, a: Any, q: Any, first: int, shift: Any, coupling: Any) -> tuple[int, Any]:
    """Count the negative pivots of a chain whose diagonal is first^2 + shift, (first + 2)^2, (first + 4)^2, ...

    ``coupling`` is the square of the first off-diagonal entry; the others are q.  Returns the count and the pivot
    closest to zero (a pair's, divided by its off-diagonal entry q).
    """
    k, count, pivot = first, 0, (first * first - a) + shift
    square = q * q
    least = None
    while True:  # a first pivot never ends it: the coupling after it may be larger than q
        entry = (k + 2) ** 2 - a
        if pivot > 0 or pivot < 0:
            least = _closer(least, pivot)
            if k > first and pivot > q and entry >= 2 * q:
                return count, least
            count += bool(pivot < 0)
            pivot = entry - coupling / pivot
            k += 2
        else:
            pair = pivot * entry - coupling
            if not pair < 0:
                raise _Unresolved("a pivot of Hill's matrix cannot be told from zero")
            least = _closer(least, pair / q)
            count += 1
            pivot = ((k + 4) ** 2 - a) - square * (pivot / pair)
            k += 4
        coupling = square


# --- Hill: a banded matrix and what it leaves out ---


def _count_hill(problem: _Problem, context: Any) -> tuple[int, tuple[Enclosure, ...]]:
    """Return the number of periodic and antiperiodic eigenvalues below zero, with the pivots closest to zero."""
    mean, waves = _in_phase(problem, context)
    bound = sum((abs(x) + abs(y) for x, y in waves), context.zero)
    # Far enough for delta > bound, and with the digits for C C' / delta not to be felt at the other end (heuristic).
    need = max(0.0, float((2 * bound - mean + 1).b))
    _check_work(15.0 * math.sqrt(need) * (2.0 * len(waves) + 1.0) ** 2, context)
    cut = len(waves) + 1 + math.ceil(math.sqrt(need)) + context.dps // 3
    total, enclosures = 0, []
    for name, start in (("periodic", Fraction(0)), ("antiperiodic", Fraction(1, 2))):
        frequencies = [start + k for k in range(cut + 1)]
        count, least = _count_band(_band(context, mean, waves, bound, frequencies), context)
        total += count
        enclosures.append(_enclose(f"pivot closest to zero, {name}", least))
    return total, tuple(enclosures)


def _band(
    context: Any, mean: Any, waves: list[tuple[Any, Any]], bound: Any, frequencies: list[Fraction]
) -> list[dict[int, Any]]:
    """Return the rows (lower half, column: entry) of a matrix that holds both H and H - C C' / delta.

    Twice the average of u'^2 + p u^2 over u = sum_k a_k cos(k theta) + b_k sin(k theta); the highest frequency first,
    so that the pivots start out positive and a vanishing mean is no vanishing pivot.
    """
    reach, top = len(waves), frequencies[-1]
    delta = _rational((top + 1) ** 2, context) + mean - bound
    if not delta > 0:
        raise _Unresolved("the part of Hill's matrix that is left out cannot be bounded")
    modes = [(k, odd) for k in reversed(frequencies) for odd in (False, True) if k or not odd]
    beyond = [(top + k, odd) for k in range(1, reach + 1) for odd in (False, True)]
    rows: list[dict[int, Any]] = []
    for i, mode in enumerate(modes):
        near = [j for j in range(max(0, i - 2 * reach - 1), i + 1) if modes[j][0] - mode[0] <= reach]
        row = {j: _coupling(context, mean, waves, mode, modes[j]) for j in near}
        row[i] += _rational(mode[0] ** 2, context)
        if top - mode[0] < reach:
            for j in near:
                pairs = ((_coupling(context, mean, waves, modes[m], far) for m in (i, j)) for far in beyond)
                row[j] -= context.mpf([0, 1]) / delta * sum((x * y for x, y in pairs), context.zero)
        rows.append(row)
    return rows


def _coupling(
    context: Any, mean: Any, waves: list[tuple[Any, Any]], one: tuple[Fraction, bool], other: tuple[Fraction, bool]
) -> Any:
    """Return twice the average of p times two modes (frequency, whether a sine)."""
    (j, first), (k, second) = one, other
    if first == second:
        near, far = (_coefficient(context, mean, waves, m, 0) for m in (int(k - j), int(k + j)))
        return (near - far if first else near + far) / 2
    near, far = (_coefficient(context, mean, waves, m, 1) for m in (int(k - j), int(k + j)))
    return (far + near if second else far - near) / 2


def _coefficient(context: Any, mean: Any, waves: list[tuple[Any, Any]], m: int, sine: int) -> Any:
    """Return twice the average of p cos(m theta), or of p sin(m theta)."""
    if m == 0:
        return context.zero if sine else 2 * mean
    if abs(m) > len(waves):
        return context.zero
    value = waves[abs(m) - 1][sine]
    return -value if sine and m < 0 else value


def _count_band(rows: list[dict[int, Any]], context: Any) -> tuple[int, Any]:
    """Count the negative pivots of a banded symmetric matrix; ``rows`` is overwritten with its factors."""
    pivots: list[Any] = []
    count, least = 0, None
    for i, row in enumerate(rows):
        for j in sorted(row)[:-1]:
            lower = rows[j]
            for m in lower:
                if m < j and m in row:
                    row[j] -= row[m] * lower[m] / pivots[m]
        pivot = row[i]
        for j, entry in row.items():
            if j < i:
                pivot -= entry**2 / pivots[j]
        if not (pivot > 0 or pivot < 0):
            raise _Unresolved("a pivot of Hill's matrix cannot be told from zero")
        count += bool(pivot < 0)
        least = _closer(least, pivot)
        pivots.append(pivot)
    return count, least


# --- Square wave: the closed form, factorised ---


def _prove_square_wave(problem: _Problem, context: Any) -> Proof:
    alpha, beta, damping = (_rational(x, context) for x in (problem.alpha, problem.mean, problem.damping))
    mean = beta + damping**2
    half = _pi(context) / 2
    l1, l2 = mean + alpha, mean - alpha
    (c1, s1), (c2, s2) = ((c, half * s) for c, s in (_cosh_sinhc(half**2 * level, context) for level in (l1, l2)))
    y1, y2 = c2 * c1 + l1 * s2 * s1, c2 * s1 + s2 * c1
    v1, v2 = l2 * s2 * c1 + l1 * c2 * s1, l2 * s2 * s1 + c2 * c1
    above, below = v1 * y2, y1 * v2  # (trace - 2) / 4 and (trace + 2) / 4
    enclosures = (_enclose("(trace - 2) / 4", above), _enclose("(trace + 2) / 4", below))
    if above < 0 and below > 0:
        end = "every solution decays" if problem.damping else "every solution is bounded"
        statement = f"the undamped trace lies between -2 and 2, so {end}"
        return problem.proof("stable", None, context.dps, statement, *enclosures)
    if problem.damping == 0:
        if above > 0 or below < 0:
            statement = "the trace exceeds 2 in magnitude, so a solution grows"
            return problem.proof("unstable", None, context.dps, statement, *enclosures)
        raise _Unresolved("the trace cannot be told from 2 in magnitude")
    limit = (damping * _pi(context) * _cosh_sinhc((damping * _pi(context)) ** 2, context)[1]) ** 2
    return _against_damping(problem, context, above - limit, -below - limit, None)


def _against_damping(problem: _Problem, context: Any, above: Any, below: Any, interval: Interval | None) -> Proof:
    """Conclude from (trace - 2 cosh(c period)) / 4 and (-trace - 2 cosh(c period)) / 4, the trace undamped."""
    enclosures = (
        _enclose("(trace - 2 cosh(c period)) / 4", above),
        _enclose("(-trace - 2 cosh(c period)) / 4", below),
    )
    if above < 0 and below < 0:
        statement = "freed of its damping no solution grows as fast as the damping, so every solution decays"
        return problem.proof("stable", interval, context.dps, statement, *enclosures)
    if above > 0 or below > 0:
        statement = "freed of its damping a solution grows faster than the damping, so a solution grows"
        return problem.proof("unstable", interval, context.dps, statement, *enclosures)
    raise _Unresolved("growth and damping cannot be told apart")


# --- Damped Mathieu and Hill: the trace, by Taylor series ---


def _prove_by_trace(problem: _Problem, context: Any, interval: Interval | None) -> Proof:
    """Compare the undamped trace with 2 cosh(c period)."""
    mean, waves = _in_phase(problem, context)
    rate = _rational(problem.damping, context) * _unit(problem, context) * 2 * _pi(context)
    limit = _cosh_sinhc(rate**2, context)[0] / 2
    trace = _trace(context, mean, waves)
    return _against_damping(problem, context, trace / 4 - limit, -trace / 4 - limit, interval)


def _trace(context: Any, mean: Any, waves: list[tuple[Any, Any]]) -> Any:
    """Enclose the trace of the map of u'' = p u over a period 2 pi, in equal steps h.

    On a disc of radius R about a step's start abs(p) <= P, so with w^2 >= P a solution obeys max(w abs(u), abs(u'))
    <= exp(w R) max(w abs(u_0), abs(u'_0)) there, and by Cauchy's estimate its n-th term is below exp(w R) max(abs(u_0),
    abs(u'_0) / w) (h / R)^n.  The state is (u, h u').
    """
    rough = float(sum((abs(x) + abs(y) for x, y in waves), abs(mean)).b)
    order = math.ceil(1.7 * context.dps) + 10
    _check_work(6.0 * math.sqrt(rough) * order**2, context)
    steps = max(16 * len(waves), math.ceil(3.0 * math.sqrt(rough)))
    h = 2 * _pi(context) / steps
    radius = _RADIUS * h
    bound = abs(mean)
    for k, (x, y) in enumerate(waves, start=1):
        bound += (abs(x) + abs(y)) * _exp(k * radius, context)
    w = math.ceil(math.sqrt(max(1.0, float(bound.b))))
    growth = _exp(w * radius, context)
    ratio = context.mpf(1) / _RADIUS
    total = (context.one, context.zero, context.zero, context.one)
    for step in range(steps):
        series = _coefficient_series(context, mean, waves, step * h, h, order)
        columns = []
        for start, size in (((context.one, context.zero), growth), ((context.zero, context.one), growth / (w * h))):
            left_out = size * ratio**order * context.mpf([-1, 1])
            columns.append(_taylor(context, series, start, order, left_out))
        (a, c), (b, d) = columns
        e, f, g, i = total
        total = (a * e + b * g, a * f + b * i, c * e + d * g, c * f + d * i)
    return total[0] + total[3]


def _taylor(context: Any, series: list[Any], start: tuple[Any, Any], order: int, left_out: Any) -> tuple[Any, Any]:
    """Sum ``order`` terms of u and h u' after a step, and enclose the rest.

    With terms below ``left_out`` (1/4)^(n - order) the rest is below 4/3 of it for u, and 2 order of it for h u'.
    """
    terms = list(start)
    while len(terms) < order:
        n = len(terms) - 2
        push = sum((series[i] * terms[n - i] for i in range(n + 1)), context.zero)
        terms.append(push / ((n + 1) * (n + 2)))
    slope = sum((n * term for n, term in enumerate(terms)), context.zero)
    return sum(terms, context.zero) + 2 * left_out, slope + 2 * order * left_out


def _coefficient_series(
    context: Any, mean: Any, waves: list[tuple[Any, Any]], theta: Any, h: Any, order: int
) -> list[Any]:
    """Return the Taylor coefficients of h^2 p(theta + h s) in s."""
    series = [context.zero] * order
    series[0] = h**2 * mean
    for k, (x, y) in enumerate(waves, start=1):
        angle = k * theta
        cosine, sinc = _cosh_sinhc(-(angle**2), context)
        sine = angle * sinc
        # value and derivative of x cos + y sin repeat, with alternating signs, every other order
        now, after = h**2 * (x * cosine + y * sine), h**2 * (y * cosine - x * sine)
        for n in range(order):
            series[n] += now
            now, after = after * (k * h) / (n + 1), -now * (k * h) / (n + 1)
    return series


# --- Shared tools ---


def _unit(problem: _Problem, context: Any) -> Any:
    """Return period / (2 pi): 1 for Mathieu's equation, whose period is the exact 2 pi."""
    return context.one if problem.period is None else _rational(problem.period, context) / (2 * _pi(context))


def _in_phase(problem: _Problem, context: Any) -> tuple[Any, list[tuple[Any, Any]]]:
    """Return the mean, c^2 added, and the (cosine, sine) coefficients with time in units of period / (2 pi)."""
    square = _unit(problem, context) ** 2
    mean = square * _rational(problem.mean + problem.damping**2, context)
    return mean, [(square * _rational(x, context), square * _rational(y, context)) for x, y in problem.waves]


def _pi(context: Any) -> Any:
    """Enclose pi, a unit of the last place wider than mpmath does."""
    return context.pi * (1 + context.mpf([-1, 1]) / 2 ** (context.prec - 1))


def _cosh_sinhc(z: Any, context: Any) -> tuple[Any, Any]:
    """Enclose cosh(sqrt z) and sinh(sqrt z) / sqrt z, entire in z: series for z / 4^k, doubled k times.

    For abs(z) <= 1 what follows a term is below that term.
    """
    size = max(abs(float(z.a)), abs(float(z.b)))
    doublings = max(0, math.ceil(0.5 * math.log2(size))) + 1 if size > 0.0 else 0
    z = z / 4**doublings
    even = odd = term = context.one
    n = 0
    while not abs(term) < context.mpf(2) ** (-context.prec - 8) and n < context.prec:
        n += 1
        term = term * z / (2 * n * (2 * n - 1))
        even += term
        odd += term / (2 * n + 1)
    rest = abs(term) * context.mpf([-1, 1])
    even, odd = even + rest, odd + rest
    for _ in range(doublings):
        even, odd = 2 * even**2 - 1, odd * even
    return even, odd


def _exp(x: Any, context: Any) -> Any:
    even, odd = _cosh_sinhc(x**2, context)
    return even + x * odd


def _rational(value: Fraction, context: Any) -> Any:
    return context.mpf(value.numerator) / value.denominator


def _closer(least: Any, pivot: Any) -> Any:
    """Return whichever of two enclosures that exclude zero comes closer to it."""
    return pivot if least is None or _distance(pivot) < _distance(least) else least


def _distance(enclosure: Any) -> Any:
    return abs(enclosure).a


def _enclose(quantity: str, value: Any) -> Enclosure:
    import mpmath

    low, high = (mpmath.mp.make_mpf(end) for end in value._mpi_)
    return Enclosure(quantity, low, high)


def _check_work(operations: float, context: Any) -> None:
    if operations * (1.0 + context.prec / 2000.0) > _LARGEST_WORK:
        raise _TooMuchWork(f"{operations:.0e} operations with intervals")


def _sign_name(value: float | Fraction) -> str:
    return "negative" if value < 0 else "positive" if value > 0 else "zero"
