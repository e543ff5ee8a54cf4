"""Proofs for scalar equations: by counting, by the closed form of a square wave, or by the trace.

Damping: A = exp(-c tau) u turns c into an addition of c^2 to the mean, and bounded u prove that A decays.  Where u
grows, its trace is compared with 2 cosh(c period).
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

from floquetrod.floquet.mathieu_chains import enclosed_counts
from floquetrod.floquet.proof import band
from floquetrod.floquet.proof.closed_form import trace_factors
from floquetrod.floquet.proof.digits import settled
from floquetrod.floquet.proof.exact_equation import ExactProblem
from floquetrod.floquet.proof.many_digits import Unresolved, arithmetic, cosh_sinhc, enclose, pi, rational
from floquetrod.floquet.proof.pivots import Count
from floquetrod.floquet.proof.proof import Enclosure, Proof
from floquetrod.floquet.proof.series import time_unit, undamped_series
from floquetrod.floquet.proof.trace import enclose_trace
from floquetrod.floquet.verdict import Interval, Status, static_status


def certify_scalar(problem: ExactProblem, max_digits: int) -> Proof:
    """Prove a verdict on a scalar equation with as many digits as it takes."""
    elementary = _elementary(problem)
    if elementary is not None:
        return elementary
    return settled(
        lambda digits: _attempt(problem, digits),
        max_digits,
        lambda digits, reason: _proof(problem, "undecided", None, digits, reason),
    )


def _attempt(problem: ExactProblem, digits: int) -> Proof:
    """Prove a verdict with ``digits`` digits, by what applies to the problem; raises `Unresolved` if they are too few.

    The one place that distinguishes kinds of coefficients.
    """
    context = arithmetic(digits)
    if problem.halves is not None:
        return _by_closed_form(context, problem, problem.halves)
    try:
        if problem.sinusoid is not None:
            count = enclosed_counts.count_eigenvalues(context, *problem.sinusoid, problem.damping)
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
        status = static_status(-level, 0.0, problem.damping)
        return _proof(problem, status, None, 0, f"the coefficient is constant and {_sign_name(level)}")
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
    known = _below(count.below, "without its damping, " if problem.damping else "")
    if count.below % 2 == 1:
        end = "every solution decays" if problem.damping else "every solution is bounded"
        statement = f"{known}; above an odd number of them {end}"
        return _proof(problem, "stable", interval, context.dps, statement, *count.enclosures)
    if problem.damping > 0:
        return by_trace(context, problem, interval)
    statement = f"{known}; {'above an even number of them' if count.below else 'below the first'} a solution grows"
    return _proof(problem, "unstable", interval, context.dps, statement, *count.enclosures)


def _below(boundaries: int, without: str) -> str:
    """Return how many transition curves lie below an equation: eigenvalues of Hill's, periodic and antiperiodic."""
    number = {0: "no boundary of stability lies", 1: "1 boundary of stability lies"}.get(
        boundaries, f"{boundaries} boundaries of stability lie"
    )
    return f"{without}{number} below its mean stiffness and none on it"


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
    trace = enclose_trace(context, problem)
    return _against_damping(context, problem, trace / 4 - limit, -trace / 4 - limit, interval)


def _against_damping(context: Any, problem: ExactProblem, above: Any, below: Any, interval: Interval | None) -> Proof:
    """Conclude from (trace - 2 cosh(c period)) / 4 and (-trace - 2 cosh(c period)) / 4, the trace undamped."""
    enclosures = (enclose("(trace - 2 cosh(c period)) / 4", above), enclose("(-trace - 2 cosh(c period)) / 4", below))
    if above < 0 and below < 0:
        statement = "with its damping removed no solution grows as fast as the damping, so every solution decays"
        return _proof(problem, "stable", interval, context.dps, statement, *enclosures)
    if above > 0 or below > 0:
        statement = "with its damping removed a solution grows faster than the damping, so a solution grows"
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
