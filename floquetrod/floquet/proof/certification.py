"""`fr.certify`: chooses the proof for an equation, a system or a box of parameters.

A scalar equation of one Fourier series, or of two values over halves of its period, is proved in `scalar`, which is
fast; any other equation as the system that it is, in `systems`; boxes of the parameters of a family in `family`, of
boxes of Mathieu's parameters in `region_equation`, in doubles.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from floquetrod._util import validate
from floquetrod.equations import DelaySystem, Equation, HillSystem, Mathieu, PeriodicSystem
from floquetrod.equations.base import require
from floquetrod.equations.matrices import require_one
from floquetrod.floquet.dispatch import under_noise
from floquetrod.floquet.problems import Problem, require_without_delays
from floquetrod.floquet.proof.delayed import certify_delayed
from floquetrod.floquet.proof.digits import FIRST
from floquetrod.floquet.proof.exact_equation import (
    LISTS,
    MOST_DIGITS,
    Parameters,
    exact_number,
    exact_problem,
    is_readable,
    problem_of,
    problem_of_one,
)
from floquetrod.floquet.proof.family_boxes import certify_family
from floquetrod.floquet.proof.proof import MAX_BOXES, SECONDS, Proof
from floquetrod.floquet.proof.region_equation import certify_box, in_aq
from floquetrod.floquet.proof.region_proof import RegionProof, is_side, side_ends
from floquetrod.floquet.proof.scalar import certify_scalar
from floquetrod.floquet.proof.systems import certify_system

_ACCEPTED = "an Equation such as Mathieu, Meissner or Hill, a HillSystem, a PeriodicSystem or a DelaySystem"


def certify(
    equation: Problem | Callable[..., Any],
    *,
    max_digits: int = 200,
    growth_tolerance: float = 0.0,
    max_boxes: int = MAX_BOXES,
    seconds: float = SECONDS,
    noise: Any = None,
    interpretation: str = "ito",
    **parameters: Any,
) -> Proof | RegionProof:
    """Prove an equation or a system stable or unstable, in interval arithmetic of as many digits as it takes.

    Or every equation of a family with parameters in a box, the box halved where needed.

    Parameters
    ----------
    equation : Equation, HillSystem, PeriodicSystem or DelaySystem, or a class of equations
        A value, `Mathieu`, `Meissner`, `Hill` or an equation of your own, whose parameters, and period unless
        ``period_over_pi`` states it, are taken as exact binary numbers.  For a system the verdict holds for all
        coefficients within its ``coefficient_error``.  A system with delays is proved stable where it is stable for
        all delays; otherwise it is decided where delays and period are exact whole multiples of one step.  Or one of
        the three classes, with its parameters following.  Or a family, a callable that makes an equation or a system
        of its arguments: the coefficients must be affine in each argument.
    max_digits : int
        Decimal digits at which to stop trying, 5 to 10,000.
    growth_tolerance : float
        Growth per unit tau, beside a and q per unit z, that counts as none; other than 0 for the class `Mathieu` only.
    max_boxes : int
        Parts of a box to examine before it is given up.
    seconds : float
        Time after which a box of a family is given up.
    noise : sequence of (matrix, intensity), or float, optional
        White noise in the coefficients of a value, as `floquetrod.second_moments` takes it: the verdict in mean square
        is proved.  A family of parameters with noise is a callable that returns second moments.
    interpretation : {"ito", "stratonovich"}
        Interpretation of the noise.
    **parameters
        Parameters of the class by name: numbers, taken exactly, int, float, Fraction, Decimal or text such as "1/3"
        or "-0.1".  The default period of a `Hill` is the double nearest to 2 pi.  For `Mathieu` each may be an
        interval (low, high), a tuple or a list; and a and q of y'' + 2 k y' + (a - 2 q cos 2 z) y = 0, with
        ``damping`` k per unit z, may be given in place of alpha and beta: the answer uses the names given.  For a
        family its arguments, six at most, at least one of them an interval (low, high) of two floats; an argument
        that is itself a pair of numbers is given as an array.

    Returns
    -------
    Proof or RegionProof
        "undecided" on a boundary, as far as the digits allowed can tell, or when the arithmetic would take more than
        several seconds.  The second where a parameter is (low, high), or growth tolerated.

    Raises
    ------
    TypeError
        For anything but these equations, for parameters of another class or kind, and for parameters
        beside a value.
    ValueError
        For a batch of systems, and for numbers that the class refuses, infinite ones, or ones that are not exact.

    Examples
    --------
    >>> from floquetrod.equations import Mathieu
    >>> certify(Mathieu(alpha=1e-8, beta=-0.25)).status
    'unstable'

    To a double -0.25 - 1e-30 is -0.25, which lies within the tongue; the number itself does not:

    >>> from fractions import Fraction
    >>> certify(Mathieu, alpha="1e-30", beta=Fraction(-1, 4) - Fraction(1, 10**30)).status
    'stable'

    Every equation of a box:

    >>> certify(Mathieu, alpha=(0.4, 0.5), beta=(-0.8, -0.7)).status
    'stable'
    >>> certify(Mathieu, a=(1.9, 2.1), q=("0.8", "1.0")).statement
    'for every a 1.9 to 2.1, q 0.8 to 1, damping 0 no solution grows'

    Every system of a family:

    >>> def coupled(stiffness, forcing):
    ...     return HillSystem([[1.0, 0.0], [0.0, stiffness]], [[[0.1, forcing], [forcing, 0.16]]], period=5.0)
    >>> certify(coupled, stiffness=(4.2, 4.4), forcing=(0.1, 0.2)).statement
    'for every stiffness 4.2 to 4.4, forcing 0.1 to 0.2 no solution grows'

    Two equal oscillators, which no search for separate multipliers can decide:

    >>> certify(HillSystem([[1.3, 0.0], [0.0, 1.3]], cosines=[[[0.2, 0.0], [0.0, 0.2]]], period=3.7)).status
    'stable'
    """
    max_digits = validate.integer("max_digits", max_digits, 5, MOST_DIGITS)
    growth_tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
    max_boxes = validate.integer("max_boxes", max_boxes, 1)
    seconds = validate.positive("seconds", seconds)
    if growth_tolerance and equation is not Mathieu:
        raise TypeError("growth_tolerance is for the class Mathieu and its parameters only; leave it out")
    if isinstance(equation, Equation | HillSystem | PeriodicSystem | DelaySystem):
        if parameters:
            names, kind = ", ".join(parameters), type(equation).__name__
            raise TypeError(f"{names} must follow a class or another callable: certify({kind}, ...), not a value")
        return _under_noise(equation, noise, interpretation, max_digits)
    if noise is not None or interpretation != "ito":
        raise TypeError(
            f"equation must be an equation or a system where noise is given, got {validate.short(equation)}; of a "
            "family, give one that makes fr.second_moments(system, noise)"
        )
    if equation is Mathieu and parameters.keys() & {"a", "q"}:
        same = _from_aq(parameters)
        return in_aq(
            certify(
                Mathieu, max_digits=max_digits, growth_tolerance=0.5 * growth_tolerance, max_boxes=max_boxes, **same
            )
        )
    lists = LISTS if is_readable(equation) else ()
    boxed = {name: value for name, value in parameters.items() if is_side(value) and name not in lists}
    if equation is Mathieu and (boxed or growth_tolerance):

        def prove(exact: Parameters) -> Proof:
            return certify_scalar(exact_problem(Mathieu, exact), max_digits)

        return certify_box(parameters, growth_tolerance, max_boxes, prove)
    if is_readable(equation) and not boxed:
        return certify_scalar(exact_problem(equation, parameters), max_digits)
    if callable(equation) and parameters:
        given = {name: value for name, value in parameters.items() if name not in boxed}
        return certify_family(equation, boxed, given, max_boxes, seconds, lambda each: _of_value(each, max_digits))
    raise validate.wrong_type("equation", f"must be {_ACCEPTED}, got {validate.short(equation)}")


def _under_noise(problem: Problem, noise: Any, interpretation: str, max_digits: int) -> Proof:
    """Prove a verdict on an equation or a system, in mean square where there is noise."""
    if noise is not None:
        require_without_delays(problem, "a proof under noise")
    subject: Any = under_noise(problem, noise, interpretation)
    proof = _of_value(subject, max_digits)
    if subject is problem or not isinstance(problem, Equation):
        return proof
    return replace(proof, statement=f"{proof.statement}{_inexact(problem)}")


def _of_value(problem: Problem, max_digits: int) -> Proof:
    """Prove a verdict on an equation or a system by what applies to it."""
    if isinstance(problem, Equation):
        require(problem)
        exact = problem_of(problem)
        return _of_any_equation(problem, max_digits) if exact is None else certify_scalar(exact, max_digits)
    if isinstance(problem, DelaySystem):
        return certify_delayed(problem, max_digits)
    require_one(problem, "equation")
    if problem.MEANING:
        proof = certify_system(problem, max_digits)
        return replace(proof, statement=f"of the second moments, {proof.statement}")
    single = problem_of_one(problem) if isinstance(problem, HillSystem) else None
    if single is None:
        return certify_system(problem, max_digits)
    if single.damping > 0:  # doubles decide at once, or else the trace is faster
        proof = certify_system(problem, min(FIRST, max_digits))
        if proof.stable is not None:
            return proof
    return certify_scalar(single, max_digits)


def _of_any_equation(equation: Equation, max_digits: int) -> Proof:
    """Prove a verdict on a scalar equation as the system of one that it is."""
    proof = certify_system(equation.as_system(), max_digits)
    return replace(proof, equation=equation, statement=f"{proof.statement}{_inexact(equation)}")


def _inexact(equation: Equation) -> str:
    """Return what a proof of a system says of the period of the equation that it was, "" where that is exact."""
    multiple = equation.period_over_pi
    return "" if multiple is None else f"; its period, {multiple} pi, was taken as the double {equation.period!r}"


def _from_aq(parameters: Parameters) -> dict[str, Any]:
    """Return alpha, beta and c for a, q and k, exactly."""
    if wrong := [name for name in ("a", "q") if name not in parameters]:
        raise TypeError(f"{wrong[0]} must be given, a number or (low, high), beside {'q' if wrong[0] == 'a' else 'a'}")
    if wrong := sorted(parameters.keys() - {"a", "q", "damping"}):
        raise TypeError(f"{', '.join(wrong)} must be left out beside a and q, with which damping may be given")
    sides = {}
    for name, source, factor in (("alpha", "q", 2), ("beta", "a", -4), ("damping", "damping", 2)):
        value = parameters.get(source, 0)
        ends = sorted(end / factor for end in side_ends(source, value, exact_number))
        sides[name] = tuple(ends) if is_side(value) else ends[0]
    return sides
