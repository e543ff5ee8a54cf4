"""`fr.stability`: one question, any method."""

from __future__ import annotations

import textwrap
from importlib import import_module
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from floquetrod._util import validate
from floquetrod.equations import DelayedMoments, DelaySystem, Equation, HillSystem, PeriodicSystem
from floquetrod.equations.delayed_moments import delayed_moments
from floquetrod.equations.hill_system import states
from floquetrod.equations.second_moments import balanced_moments
from floquetrod.floquet.problems import Problem, kind_of, require_problem
from floquetrod.floquet.registry import in_turn, names_in_words, names_of, refusal
from floquetrod.floquet.verdict import FloquetVerdict, Stability, Verdict

if TYPE_CHECKING:
    from typing import TypedDict, Unpack

    from floquetrod.floquet.multipliers.system_stability import SystemStability

    class Options(TypedDict, total=False):
        """Options of the methods."""

        terms: int | None
        rtol: float | None
        step: float | None
        periods: int | None
        limit: float | None
        digits: int | None
        most_digits: int | None
        above: float | None


_FEW = 24  # first-order equations up to which unresolved multipliers are asked of another method: a second (a choice)
_OPTIONS = ("terms", "rtol", "step", "periods", "limit", "digits", "most_digits", "above")


@overload
def stability(equation: Equation, method: str = "auto", **options: Unpack[Options]) -> Stability: ...
@overload
def stability(
    equation: HillSystem | PeriodicSystem | DelaySystem, method: str = "auto", **options: Unpack[Options]
) -> SystemStability: ...
@overload
def stability(
    equation: Problem, method: str = "auto", *, noise: Any, interpretation: str = "ito", **options: Unpack[Options]
) -> SystemStability: ...
def stability(
    equation: Problem,
    method: str = "auto",
    *,
    noise: Any = None,
    interpretation: str = "ito",
    terms: int | None = None,
    rtol: float | None = None,
    step: float | None = None,
    periods: int | None = None,
    limit: float | None = None,
    digits: int | None = None,
    most_digits: int | None = None,
    above: float | None = None,
) -> Stability | SystemStability:
    """Classify an equation or a system: is it stable, and how fast does it grow?

    Parameters
    ----------
    equation : Equation, HillSystem, PeriodicSystem or DelaySystem
        The problem: `Mathieu`, `Meissner`, `Hill`, or any other `floquetrod.equations.Equation`; or a system of
        equations, with delays or without.
    method : str
        "auto", or the name of one of `floquetrod.floquet.registry.METHODS`.
        "auto" takes the fastest trustworthy one and continues with slower, more accurate ones while the verdict is
        undecided.
    noise : sequence of (matrix, intensity), or float, optional
        White noise in the coefficients, as `floquetrod.second_moments` takes it, whose system is then classified: the
        verdict is in mean square; growth and exponents belong to the second moments.  Of a system with delays,
        (matrix, intensity, [(delay, matrix), ...]) is a source that acts on delayed values as well; the one exponent
        is the growth rate of all second moments.
    interpretation : {"ito", "stratonovich"}
        Of the noise.
    terms : int, optional
        Of the determinant.  This and the options below are for a method that is named, whose page describes them;
        TypeError where it does not take them.
    rtol : float, optional
        Of monodromy, half_period, segmented, collocation, and of spectral for systems.
    step : float, optional
        Of leapfrog.
    periods : int, optional
        Of leapfrog.
    limit : float, optional
        Of leapfrog.
    digits : int, optional
        Of reference.
    most_digits : int, optional
        Of reference, for systems.
    above : float, optional
        Of collocation, winding and semi_discretisation: modulus above which multipliers are found.

    Returns
    -------
    Stability or SystemStability
        Verdict, growth rate, multipliers, error and cost.

    Raises
    ------
    TypeError
        For anything but a problem, and for options that the method does not take.
    ValueError
        For a method that is unknown or not for the problem, and for options out of range.

    Examples
    --------
    >>> from floquetrod.equations import HillSystem, Mathieu
    >>> stability(Mathieu(alpha=0.5, beta=-0.2)).status
    'unstable'
    >>> stability(HillSystem([[1.0, 0.0], [0.0, 4.0]], cosines=[[[0.1, 0.2], [0.2, 0.16]]])).strongly_stable
    True
    """
    if not isinstance(equation, Equation):  # whose pieces every method checks
        require_problem(equation)
    subject: Any = under_noise(equation, noise, interpretation)
    validate.choice("method", method, names_of(subject))
    given = terms, rtol, step, periods, limit, digits, most_digits, above
    options = {name: value for name, value in zip(_OPTIONS, given, strict=True) if value is not None}
    if method != "auto":
        named: Stability | SystemStability = run(method, subject, **options)
        return named
    if options:
        raise TypeError(f"method='auto' accepts no options, got {', '.join(options)}; name a method to pass them to")
    judged = judge(subject)
    automatic: Stability | SystemStability = judged
    return automatic if isinstance(subject, Equation | DelaySystem | DelayedMoments) else _resolved(subject, judged)


if stability.__doc__:
    _wrapped = textwrap.fill(f"the name of one: {names_in_words()}.", 104).replace("\n", "\n        ")
    stability.__doc__ = stability.__doc__.replace("the name of one of `floquetrod.floquet.registry.METHODS`.", _wrapped)


def under_noise(problem: Problem, noise: Any, interpretation: str) -> Problem | DelayedMoments:
    """Return the second moments of an equation or a system where there is noise, itself where there is none."""
    if noise is not None:
        if isinstance(problem, DelaySystem):
            return delayed_moments(problem, noise, interpretation)
        return balanced_moments(problem, noise, interpretation)
    if interpretation != "ito":
        raise TypeError(f"interpretation={validate.short(interpretation)} is that of noise, which must be given, too")
    return problem


def _resolved(system: HillSystem | PeriodicSystem, judged: SystemStability) -> SystemStability:
    """Return the verdict with all its multipliers, from the first method that resolves them in less than a second.

    A map over the period loses small multipliers beside the largest; maps over segments and Hill's matrix keep them.
    The verdict stays where no other method resolves all multipliers.
    """
    if judged.status == "undecided" or judged.are_resolved or states(system) > _FEW:
        return judged
    for name in ("segmented", "spectral"):
        if name != judged.method and refusal(system, name) is None:
            resolved: SystemStability = run(name, system)
            if resolved.status == judged.status and resolved.are_resolved:
                return resolved
    return judged


def judge(problem: Problem | DelayedMoments, known: FloquetVerdict | None = None, **last: Any) -> Any:
    """Return the verdict of "auto", one method after another; the last one, with many digits, takes the options
    ``last``.

    A verdict that is ``known`` is not computed again.
    """
    *names, finest = in_turn(problem)
    result: Verdict | None = None
    for name in (*names, finest):
        if name == finest and _is_beyond_maps(problem, result):
            result = _better(result, run("spectral", problem))
            if result.status != "undecided":
                break
        if known is not None and known.method == name:
            verdict: Any = known
        else:
            verdict = run(name, problem, **(last if name == finest else {}))
        result = verdict if result is None else _better(result, verdict)
        if result.status != "undecided":
            break
    return result


def _is_beyond_maps(problem: Problem | DelayedMoments, result: Verdict | None) -> bool:
    """Return whether maps resolve no multiplier of a system, as where solutions grow or decay beyond doubles."""
    if result is None or not isinstance(problem, HillSystem | PeriodicSystem) or refusal(problem, "spectral"):
        return False
    return all(exponent != exponent for exponent in result.exponents)


def _better(result: Any, later: Any) -> Any:
    """Return the later of two results, unless it knows fewer exponents, or its method has given up at once."""
    if later.status != "undecided":
        return later
    known, before = (sum(e == e for e in each.exponents) for each in (later, result))
    return later if known >= before and (later.exponents or later.cost.amount) else result


@np.errstate(under="ignore")  # what is too small for a double is 0 to all methods, whatever a caller lets numpy raise
def run(method: str, problem: Problem | DelayedMoments, **options: Any) -> Any:
    """Call the method of this name, of a scalar equation or of a system."""
    file = f"{kind_of(problem).prefix}{method}"
    call = getattr(import_module(f"floquetrod.floquet.methods.{file}"), method)
    if options:
        _require_taken(method, call, options)
    result: Verdict = call(problem, **options)
    return result


def _require_taken(method: str, call: Any, options: dict[str, Any]) -> None:
    """Raise TypeError where an option is not the method's."""
    import inspect

    parameters = inspect.signature(call).parameters.values()
    taken = [parameter.name for parameter in parameters if parameter.kind is parameter.KEYWORD_ONLY]
    if unknown := [name for name in options if name not in taken]:
        raise TypeError(f"method={method!r} takes {' and '.join(taken) or 'no options'}, got {', '.join(unknown)}")
