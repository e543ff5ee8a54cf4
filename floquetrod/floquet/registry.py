"""One registry of methods: what each of them serves, and in which order they are tried."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from floquetrod._util import validate
from floquetrod.equations import DelaySystem, Equation, HillSystem, Mathieu, Meissner, PeriodicSystem
from floquetrod.equations import require as require_equation
from floquetrod.floquet.problems import KINDS, Problem, kind_of

Served = Callable[[Any], "str | None"]


def _any(_: Any) -> None:
    """Serve every problem."""


def _series(equation: Equation) -> str | None:
    needed = "equation must be one Fourier series for the spectral method, such as Mathieu or Hill"
    return None if equation.is_smooth else needed


def _smooth(system: HillSystem | PeriodicSystem) -> str | None:
    needed = "system must be one Fourier series for the spectral method, and this one has several pieces"
    return None if system.is_smooth else needed


def _sine(equation: Equation) -> str | None:
    return None if isinstance(equation, Mathieu) else "equation must be Mathieu for Hill's four determinants"


def _two_levels(equation: Equation) -> str | None:
    needed = "equation must be Meissner, Mathieu for the square-wave method"
    return None if isinstance(equation, Meissner | Mathieu) else needed


def _even(system: HillSystem | PeriodicSystem) -> str | None:
    from floquetrod.floquet.systems.classification import undamped_pairs

    pairs = undamped_pairs(system)
    if pairs is not None and isinstance(pairs[0], HillSystem) and pairs[0].is_even:
        return None
    return (
        "system must have a stiffness even about an instant, no gyroscopic matrix, and damping 2 c M or none for "
        "half_period; method='monodromy' takes any"
    )


def _never(_: Any) -> bool:
    return False


def _always(_: Any) -> bool:
    return True


def _is_sine(equation: Equation) -> bool:
    return isinstance(equation, Mathieu)


class Method(NamedTuple):
    """A method: the function of its name in the file of `floquetrod.floquet.methods` named after it.

    That for systems is in a file of its own, ``system_`` before the name, and that for systems with delays, ``delay_``.
    What is served of each kind: a callable that returns None of a problem served, else the sentence that says what the
    method needs; None in place of it where nothing of that kind is.  ``approximates``: whether the stated error leaves
    out how far the method's own equation is from the problem.
    """

    name: str
    equations: Served | None = None
    systems: Served | None = None
    delays: Served | None = None
    approximates: Callable[[Any], bool] = _never

    def serves(self, problem: Problem) -> Served | None:
        """Return what tells whether it serves a problem of this kind; None where it serves none of the kind."""
        found: Served | None = getattr(self, kind_of(problem).field)
        return found

    def refusal(self, problem: Problem) -> str | None:
        """Return None where it serves the problem, else the sentence why not."""
        served = self.serves(problem)
        if served is not None:
            return served(problem)
        words = [kind.words for kind in KINDS if getattr(self, kind.field) is not None]
        return f"{self.name} is a method for {' and '.join(words)}, not for {kind_of(problem).words}"


METHODS = (
    Method("spectral", _series, _smooth),
    Method("determinant", _sine),
    Method("half_period", systems=_even),
    Method("monodromy", _any, _any),
    Method("segmented", systems=_any),
    Method("square_wave", _two_levels, approximates=_is_sine),
    Method("leapfrog", _any, approximates=_always),
    Method("reference", _any, _any),
    Method("collocation", delays=_any),
    Method("semi_discretisation", delays=_any),
)
"""Every method there is."""

_BY_NAME = {method.name: method for method in METHODS}

_NAMES = {
    kind: ("auto", *(method.name for method in METHODS if getattr(method, kind.field) is not None)) for kind in KINDS
}


def names_of(problem: Problem) -> tuple[str, ...]:
    """Return "auto" and the names of the methods for a problem of this kind."""
    return _NAMES[kind_of(problem)]


def applicable(problem: Problem) -> tuple[Method, ...]:
    """Return the methods that serve a problem."""
    return tuple(method for method in METHODS if method.refusal(problem) is None)


def refusal(problem: Problem, method: str) -> str | None:
    """Return None where the method of this name serves a problem, else the sentence why not."""
    return _BY_NAME[method].refusal(problem)


def is_approximation(problem: Problem, method: str) -> bool:
    """Return whether the method of this name solves an equation near the problem, and its errors are those of that."""
    return _BY_NAME[method].approximates(problem)


def require(equation: Any, method: str) -> None:
    """Raise TypeError unless the method of this name serves a scalar equation."""
    require_equation(equation)
    if needed := refusal(equation, method):
        raise TypeError(f"{needed}, got {validate.short(equation)}")


def in_turn(problem: Problem) -> tuple[str, ...]:
    """Return the methods that "auto" tries one after another, the fastest trustworthy one first."""
    if isinstance(problem, DelaySystem):
        return ("collocation",)
    if isinstance(problem, Mathieu):
        return "spectral", "reference"
    if isinstance(problem, Meissner):
        return "square_wave", "reference"
    if isinstance(problem, Equation):
        return ("monodromy", "spectral", "reference") if problem.is_smooth else ("monodromy", "reference")
    return "monodromy" if _even(problem) else "half_period", "segmented", "reference"
