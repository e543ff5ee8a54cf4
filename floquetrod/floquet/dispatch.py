"""`fr.stability`: one question, any method."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from floquetrod import equations
from floquetrod._util import validate
from floquetrod.equations import Equation, Mathieu, Meissner
from floquetrod.floquet import methods
from floquetrod.floquet.verdict import Stability

METHODS: dict[str, Callable[[Equation], bool]] = {
    "spectral": lambda equation: equation.is_smooth,
    "determinant": lambda equation: isinstance(equation, Mathieu),
    "monodromy": lambda equation: True,
    "square_wave": lambda equation: isinstance(equation, (Meissner, Mathieu)),
    "leapfrog": lambda equation: True,
    "reference": lambda equation: True,
}
"""Every method, and the equations it applies to."""


def _in_turn(equation: Equation) -> tuple[str, ...]:
    """Return the methods that "auto" tries one after another: the fast path first, where there is one."""
    if isinstance(equation, Mathieu):
        return "spectral", "reference"
    if isinstance(equation, Meissner):
        return "square_wave", "reference"
    return ("monodromy", "spectral", "reference") if equation.is_smooth else ("monodromy", "reference")


def stability(equation: Equation, method: str = "auto", **options: Any) -> Stability:
    """Classify an equation: is it stable, how fast does it grow, and how sure is that?

    Parameters
    ----------
    equation : Equation
        What to classify: `Mathieu`, `Meissner`, `Hill`, or any other `floquetrod.equations.Equation`.
    method : str
        "auto", or one of "spectral", "determinant", "monodromy", "square_wave", "leapfrog", "reference".  "auto" takes
        the fastest trustworthy one for the equation and continues with slower, more accurate ones while the verdict is
        undecided.
    **options
        Passed to the method: ``terms`` (determinant), ``rtol`` (monodromy), ``step``, ``periods``, ``limit``
        (leapfrog), ``digits`` (reference).

    Returns
    -------
    Stability
        Verdict, growth rate, discriminant, multipliers, error and cost.

    Examples
    --------
    >>> stability(Mathieu(alpha=0.5, beta=-0.2)).status
    'unstable'
    """
    equations.require(equation)
    validate.choice("method", method, ("auto", *METHODS))
    if method != "auto":
        return run(method, equation, **options)
    if options:
        raise TypeError(f"method='auto' takes no options, got {', '.join(options)}; name a method to pass them to")
    first, *finer = _in_turn(equation)
    result = run(first, equation)
    for name in finer:
        if result.status != "undecided":
            break
        result = run(name, equation)
    return result


def run(method: str, equation: Equation, **options: Any) -> Stability:
    """Call the method of this name."""
    result: Stability = getattr(methods, method)(equation, **options)
    return result
