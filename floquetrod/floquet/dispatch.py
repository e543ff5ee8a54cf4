"""`fr.stability`: one question, any method."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np

from floquetrod._util import validate
from floquetrod._util.calling import tells_arguments
from floquetrod.equations import Equation, HillSystem, Mathieu, Meissner, PeriodicSystem, matrices, require
from floquetrod.floquet.verdict import Stability, Verdict

if TYPE_CHECKING:
    from floquetrod.floquet.systems.result import SystemStability


class Family(NamedTuple):
    """Methods that judge one kind of problem.

    Attributes
    ----------
    code : callable
        Returns the module where each is a function of its name, imported when one is used.
    methods : dict of callable
        Every method, and whether it applies to a problem.
    in_turn : callable
        The methods that "auto" tries one after another: the fast path first, where there is one.
    """

    code: Callable[[], ModuleType]
    methods: dict[str, Callable[[Any], bool]]
    in_turn: Callable[[Any], tuple[str, ...]]


def _equation_in_turn(equation: Equation) -> tuple[str, ...]:
    if isinstance(equation, Mathieu):
        return "spectral", "reference"
    if isinstance(equation, Meissner):
        return "square_wave", "reference"
    return ("monodromy", "spectral", "reference") if equation.is_smooth else ("monodromy", "reference")


def _has_even_form(system: HillSystem | PeriodicSystem) -> bool:
    """Return whether half a period of the system freed of uniform damping tells its multipliers."""
    from floquetrod.floquet.systems.classification import undamped_pairs

    pairs = undamped_pairs(system)
    return pairs is not None and isinstance(pairs[0], HillSystem) and pairs[0].is_even


def _system_in_turn(system: HillSystem | PeriodicSystem) -> tuple[str, ...]:
    first = "half_period" if _has_even_form(system) else "monodromy"
    return first, "segmented", "reference"


def _equation_methods() -> ModuleType:
    from floquetrod.floquet import methods

    return methods


def _system_methods() -> ModuleType:
    from floquetrod.floquet import system_methods

    return system_methods


EQUATIONS = Family(
    _equation_methods,
    {
        "spectral": lambda equation: equation.is_smooth,
        "determinant": lambda equation: isinstance(equation, Mathieu),
        "monodromy": lambda equation: True,
        "square_wave": lambda equation: isinstance(equation, (Meissner, Mathieu)),
        "leapfrog": lambda equation: True,
        "reference": lambda equation: True,
    },
    _equation_in_turn,
)
"""Scalar equations."""

SYSTEMS = Family(
    _system_methods,
    {
        "half_period": _has_even_form,
        "monodromy": lambda system: True,
        "segmented": lambda system: True,
        "spectral": lambda system: system.is_smooth,
        "reference": lambda system: True,
    },
    _system_in_turn,
)
"""Systems of equations."""


def family_of(problem: Any) -> Family:
    """Return the family of a problem, checked; TypeError for what is none, ValueError for a batch."""
    if isinstance(problem, HillSystem | PeriodicSystem):
        matrices.require_one(problem, "equation")
        return SYSTEMS
    require(problem, hint="or a HillSystem or PeriodicSystem")
    return EQUATIONS


@overload
def stability(equation: Equation, method: str = "auto", **options: Any) -> Stability: ...
@overload
def stability(equation: HillSystem | PeriodicSystem, method: str = "auto", **options: Any) -> SystemStability: ...
@tells_arguments()
def stability(
    equation: Equation | HillSystem | PeriodicSystem, method: str = "auto", **options: Any
) -> Stability | SystemStability:
    """Classify an equation or a system: is it stable, how fast does it grow, and how sure is that?

    Parameters
    ----------
    equation : Equation, HillSystem or PeriodicSystem
        What to classify: `Mathieu`, `Meissner`, `Hill`, or any other `floquetrod.equations.Equation`; or a system of
        equations.
    method : str
        "auto", or the name of one: of equations "spectral", "determinant", "monodromy", "square_wave", "leapfrog",
        "reference"; of systems "half_period", "monodromy", "segmented", "spectral", "reference".  "auto" takes the
        fastest trustworthy one and continues with slower, more accurate ones while the verdict is undecided.
    **options
        Passed to the method: ``terms`` (determinant), ``rtol`` (monodromy, half_period, segmented), ``step``,
        ``periods``, ``limit`` (leapfrog), ``digits`` (reference), ``most_digits`` (reference, of systems).

    Returns
    -------
    Stability or SystemStability
        Verdict, growth rate, multipliers, error and cost.

    Examples
    --------
    >>> stability(Mathieu(alpha=0.5, beta=-0.2)).status
    'unstable'
    >>> stability(HillSystem([[1.0, 0.0], [0.0, 4.0]], cosines=[[[0.1, 0.2], [0.2, 0.16]]])).strongly_stable
    True
    """
    family = family_of(equation)
    validate.choice("method", method, ("auto", *family.methods))
    result: Stability | SystemStability
    if method != "auto":
        result = run(family, method, equation, **options)
        return result
    if options:
        raise TypeError(f"method='auto' accepts no options, got {', '.join(options)}; name a method to pass them to")
    result = judge(family, equation)
    return result


def judge(family: Family, equation: Equation | HillSystem | PeriodicSystem, **last: Any) -> Any:
    """Return what "auto" finds, one method after another; the last one, with many digits, is given ``last``."""
    *names, finest = family.in_turn(equation)
    result: Verdict | None = None
    for name in (*names, finest):
        found = run(family, name, equation, **(last if name == finest else {}))
        result = found if result is None else _better(result, found)
        if result.status != "undecided":
            break
    return result


def _better(result: Any, later: Any) -> Any:
    """Return the later of two results, unless its method has given up, at once or where the other has exponents."""
    return later if later.exponents or (later.cost.amount and not result.exponents) else result


@np.errstate(under="ignore")  # what is too small for a double is 0 to all methods, whatever a caller lets numpy raise
def run(family: Family, method: str, equation: Equation | HillSystem | PeriodicSystem, **options: Any) -> Any:
    """Call the method of this name of the equation's family."""
    call = getattr(family.code(), method)
    result: Verdict = tells_arguments()(call)(equation, **options) if options else call(equation)
    return result
