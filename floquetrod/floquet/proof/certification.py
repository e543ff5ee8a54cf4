"""The entry point: what is computed for a problem, with how many digits, and what follows from it.

Damping: A = exp(-c tau) u turns c into an addition of c^2 to the mean, and bounded u prove that A decays.  Where u
grows, its trace is compared with 2 cosh(c period).

Where a sign cannot be told, the precision is raised; where it may not be raised any further, the answer is "undecided".
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

from floquetrod._util import validate
from floquetrod.equations import Equation, HillSystem, Mathieu, PeriodicSystem
from floquetrod.equations.matrices import require_one
from floquetrod.floquet.proof import band, chains
from floquetrod.floquet.proof.closed_form import trace_factors
from floquetrod.floquet.proof.intervals import TooMuchWork, Unresolved, arithmetic, cosh_sinhc, enclose, pi, rational
from floquetrod.floquet.proof.pivots import Count
from floquetrod.floquet.proof.problem import (
    LISTS,
    MOST_DIGITS,
    ExactProblem,
    Parameters,
    exact_number,
    exact_problem,
    problem_of_one,
)
from floquetrod.floquet.proof.region import RegionProof, side_ends
from floquetrod.floquet.proof.region_equation import certify_box
from floquetrod.floquet.proof.result import MAX_BOXES, Enclosure, Proof
from floquetrod.floquet.proof.series import time_unit, undamped_series
from floquetrod.floquet.proof.systems import certify_system
from floquetrod.floquet.proof.trace import enclose_trace
from floquetrod.floquet.verdict import Interval, Status

_FIRST_DIGITS = 15


def certify(
    equation: Equation | type[Equation] | HillSystem | PeriodicSystem,
    *,
    max_digits: int = 200,
    growth_tolerance: float = 0.0,
    max_boxes: int = MAX_BOXES,
    **parameters: Any,
) -> Proof | RegionProof:
    """Prove an equation or a system stable or unstable, in interval arithmetic of as many digits as it takes.

    Or every equation of Mathieu's with parameters in a box, in doubles, the box halved where needed.

    Parameters
    ----------
    equation : Mathieu, Meissner, Hill, HillSystem or PeriodicSystem
        A value, whose parameters are taken as the exact binary numbers they are; so is the period of a `Hill`.  Or one
        of the first three classes, with its parameters following.  Of a `PeriodicSystem`, the verdict holds for all
        coefficients within its ``coefficient_error``.
    max_digits : int
        Decimal digits at which to stop trying, 5 to 10,000.
    growth_tolerance : float
        Growth per unit tau that counts as none; other than 0 for the class `Mathieu` only.
    max_boxes : int
        Of a box: parts of it to look at before it is given up.
    **parameters
        Of the class, by name: numbers that are taken exactly, int, float, Fraction, Decimal or text such as "1/3" or
        "-0.1".  The period of a `Hill` is the double nearest to 2 pi where it is left out.  Of `Mathieu` each may be
        (low, high), all values between which are meant; and in place of alpha and beta, a and q of
        y'' + 2 k y' + (a - 2 q cos 2 z) y = 0, with ``damping`` k, per unit z.

    Returns
    -------
    Proof or RegionProof
        "undecided" on a boundary, as far as the digits allowed can tell, or when the arithmetic would take more than
        several seconds.  The second where a parameter is (low, high), or growth tolerated.

    Raises
    ------
    TypeError
        For anything but these equations, for parameters that are not numbers or not of the class, and for parameters
        beside a value.
    ValueError
        For a batch of systems, numbers that are not finite or cannot be taken exactly, and those the class refuses.

    Examples
    --------
    >>> from floquetrod.equations import Mathieu
    >>> certify(Mathieu(alpha=1e-8, beta=-0.25)).status
    'unstable'

    To a double -0.25 - 1e-30 is -0.25, which lies within the tongue; the number itself does not:

    >>> certify(Mathieu, alpha="1e-30", beta=Fraction(-1, 4) - Fraction(1, 10**30)).status
    'stable'

    Every equation of a box:

    >>> certify(Mathieu, alpha=(0.4, 0.5), beta=(-0.8, -0.7)).status
    'stable'
    >>> certify(Mathieu, a=(1.9, 2.1), q=("0.8", "1.0")).statement
    'for every alpha 0.4 to 0.5, beta -0.525 to -0.475, damping 0 no solution grows'

    Two equal oscillators, which no search for separate multipliers can decide:

    >>> certify(HillSystem([[1.3, 0.0], [0.0, 1.3]], cosines=[[[0.2, 0.0], [0.0, 0.2]]], period=3.7)).status
    'stable'
    """
    max_digits = validate.integer("max_digits", max_digits, 5, MOST_DIGITS)
    growth_tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
    max_boxes = validate.integer("max_boxes", max_boxes, 1)
    if growth_tolerance and equation is not Mathieu:
        raise TypeError("growth_tolerance is for the class Mathieu and its parameters only; leave it out")
    if isinstance(equation, HillSystem | PeriodicSystem):
        if parameters:
            raise TypeError(f"{', '.join(parameters)} must be of the system: certify takes a system as a value only")
        require_one(equation, "equation")
        return _certify_system(equation, max_digits)
    if equation is Mathieu and parameters.keys() & {"a", "q"}:
        parameters = _from_aq(parameters)
    boxed = [name for name, value in parameters.items() if isinstance(value, tuple) and name not in LISTS]
    if equation is Mathieu and (boxed or growth_tolerance):

        def prove(exact: Parameters) -> Proof:
            return _certify(exact_problem(Mathieu, exact), max_digits)

        return certify_box(parameters, growth_tolerance, max_boxes, prove)
    if boxed:
        raise TypeError(
            f"{boxed[0]} must be a number, got {validate.short(parameters[boxed[0]])}: boxes of parameters are proved "
            "of the class Mathieu only; give one equation at a time"
        )
    return _certify(exact_problem(equation, parameters), max_digits)


def _from_aq(parameters: Parameters) -> dict[str, Any]:
    """Return alpha, beta and c for a, q and k, exactly."""
    if wrong := [name for name in ("a", "q") if name not in parameters]:
        raise TypeError(f"{wrong[0]} must be given, a number or (low, high), beside {'q' if wrong[0] == 'a' else 'a'}")
    if wrong := sorted(parameters.keys() - {"a", "q", "damping"}):
        raise TypeError(f"{', '.join(wrong)} must be left out beside a and q, with which damping may be given")
    found = {}
    for name, of, factor in (("alpha", "q", 2), ("beta", "a", -4), ("damping", "damping", 2)):
        value = parameters.get(of, 0)
        ends = sorted(end / factor for end in side_ends(of, value, exact_number))
        found[name] = tuple(ends) if isinstance(value, tuple) else ends[0]
    return found


def _certify_system(system: HillSystem | PeriodicSystem, max_digits: int) -> Proof:
    """Prove a verdict on a system; of one equation as on the equation, but where doubles decide and are faster."""
    single = problem_of_one(system) if isinstance(system, HillSystem) else None
    if single is None:
        return certify_system(system, max_digits)
    if single.damping > 0:
        proof = certify_system(system, min(_FIRST_DIGITS, max_digits))
        if proof.stable is not None:
            return proof
    return _certify(single, max_digits)


def _certify(problem: ExactProblem, max_digits: int) -> Proof:
    """Prove a verdict with as many digits as it takes."""
    elementary = _elementary(problem)
    if elementary is not None:
        return elementary
    digits = min(_FIRST_DIGITS, max_digits)
    while True:
        try:
            return _attempt(problem, digits)
        except Unresolved as reason:
            if digits >= max_digits:
                return _proof(problem, "undecided", None, digits, f"{reason} with {digits} digits")
        except TooMuchWork as reason:
            return _proof(problem, "undecided", None, digits, f"{reason} are more work than is worth waiting for")
        digits = min(2 * digits, max_digits)


def _attempt(problem: ExactProblem, digits: int) -> Proof:
    """Prove a verdict with ``digits`` digits, by what applies to the problem; raises `Unresolved` if they are too few.

    The one place that distinguishes kinds of coefficients.
    """
    context = arithmetic(digits)
    if problem.halves is not None:
        return _by_closed_form(context, problem, problem.halves)
    try:
        if problem.sinusoid is not None:
            count = chains.count_eigenvalues(context, *problem.sinusoid, problem.damping)
        else:
            count = band.count_eigenvalues(context, undamped_series(context, problem))
    except Unresolved:
        if problem.damping == 0:
            raise
        return by_trace(context, problem, None)  # on a boundary of u, damping decides
    return _by_count(context, problem, count)


def _elementary(problem: ExactProblem) -> Proof | None:
    """Return the verdict where the solutions are elementary, so that a boundary can be hit exactly."""
    if problem.constant is not None:
        level = problem.constant
        bounded = level < 0 or (level == 0 and problem.damping > 0)
        statement = f"the coefficient is constant and {_sign_name(level)}"
        return _proof(problem, "stable" if bounded else "unstable", None, 0, statement)
    if problem.halves is None or problem.damping > 0:
        return None
    for half, other in (problem.halves, problem.halves[::-1]):
        if half < 0 and half.denominator == 1 and math.isqrt(-half.numerator) ** 2 == -half:
            statement = (
                "over one half period the motion makes a whole number of half turns, so it is as bounded as with the "
                f"other half's coefficient throughout, which is {_sign_name(other)}"
            )
            return _proof(problem, "stable" if other < 0 else "unstable", None, 0, statement)
    return None


def _by_count(context: Any, problem: ExactProblem, count: Count) -> Proof:
    """Conclude from the number of eigenvalues below the equation's."""
    interval = Interval.from_count(count.below)
    known = f"{count.below} of Hill's periodic and antiperiodic eigenvalues lie below the equation's and none at it"
    if count.below % 2 == 1:
        end = "every solution decays" if problem.damping else "every solution is bounded"
        statement = f"{known}: an odd number, so {end}"
        return _proof(problem, "stable", interval, context.dps, statement, *count.enclosures)
    if problem.damping > 0:
        return by_trace(context, problem, interval)
    statement = f"{known}: an even number, so a solution grows"
    return _proof(problem, "unstable", interval, context.dps, statement, *count.enclosures)


def _by_closed_form(context: Any, problem: ExactProblem, halves: tuple[Fraction, Fraction]) -> Proof:
    """Conclude from the factorised trace of a coefficient that is constant over each half of its period."""
    factors = trace_factors(context, halves, problem.damping)
    enclosures = (enclose("(trace - 2) / 4", factors.minus), enclose("(trace + 2) / 4", factors.plus))
    if factors.minus < 0 and factors.plus > 0:
        end = "every solution decays" if problem.damping else "every solution is bounded"
        statement = f"the undamped trace lies between -2 and 2, so {end}"
        return _proof(problem, "stable", None, context.dps, statement, *enclosures)
    if problem.damping == 0:
        if factors.minus > 0 or factors.plus < 0:
            statement = "the trace exceeds 2 in magnitude, so a solution grows"
            return _proof(problem, "unstable", None, context.dps, statement, *enclosures)
        raise Unresolved("the trace cannot be distinguished from 2 in magnitude")
    rate = rational(context, problem.damping) * pi(context)
    limit = (rate * cosh_sinhc(context, rate**2).sinhc) ** 2
    return _against_damping(context, problem, factors.minus - limit, -factors.plus - limit, None)


def by_trace(context: Any, problem: ExactProblem, interval: Interval | None) -> Proof:
    """Conclude from the undamped trace and 2 cosh(c period)."""
    rate = rational(context, problem.damping) * time_unit(context, problem) * 2 * pi(context)
    limit = cosh_sinhc(context, rate**2).cosh / 2
    trace = enclose_trace(context, undamped_series(context, problem))
    return _against_damping(context, problem, trace / 4 - limit, -trace / 4 - limit, interval)


def _against_damping(context: Any, problem: ExactProblem, above: Any, below: Any, interval: Interval | None) -> Proof:
    """Conclude from (trace - 2 cosh(c period)) / 4 and (-trace - 2 cosh(c period)) / 4, the trace undamped."""
    enclosures = (
        enclose("(trace - 2 cosh(c period)) / 4", above),
        enclose("(-trace - 2 cosh(c period)) / 4", below),
    )
    if above < 0 and below < 0:
        statement = "freed of its damping no solution grows as fast as the damping, so every solution decays"
        return _proof(problem, "stable", interval, context.dps, statement, *enclosures)
    if above > 0 or below > 0:
        statement = "freed of its damping a solution grows faster than the damping, so a solution grows"
        return _proof(problem, "unstable", interval, context.dps, statement, *enclosures)
    raise Unresolved("growth equals the damping within the error")


def _proof(
    problem: ExactProblem,
    status: Status,
    interval: Interval | None,
    digits: int,
    statement: str,
    *enclosures: Enclosure,
) -> Proof:
    """Return the `Proof` of a verdict on a problem."""
    return Proof(problem.equation, status, interval, digits, statement, enclosures, exact=problem.inexact)


def _sign_name(value: Fraction) -> str:
    return "negative" if value < 0 else "positive" if value > 0 else "zero"
