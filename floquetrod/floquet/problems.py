"""What verdicts are on: a scalar equation or a system, one and not a batch."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from floquetrod._util import validate
from floquetrod.equations import DelaySystem, Equation, HillSystem, PeriodicSystem, matrices
from floquetrod.equations import require as require_equation

Problem = Equation | HillSystem | PeriodicSystem | DelaySystem
"""A scalar equation, or a system, with delays or without."""


class Kind(NamedTuple):
    """A kind of problem: what it is called, and its names where methods, their files and sources are listed by kind."""

    words: str
    field: str  # of a method in the registry
    prefix: str  # of the file of a method
    name: str  # beside that of a method in `floquetrod.floquet.references.SOURCES`


KINDS = (
    Kind("scalar equations", "equations", "", "equation"),
    Kind("systems", "systems", "system_", "system"),
    Kind("systems with delays", "delays", "delay_", "delays"),
)


def kind_of(problem: Any) -> Kind:
    """Return the kind of a problem."""
    return KINDS[0 if isinstance(problem, Equation) else 2 if isinstance(problem, DelaySystem) else 1]


def require_problem(problem: Any) -> None:
    """Raise TypeError for what is neither an equation nor a system, ValueError for a batch."""
    if isinstance(problem, HillSystem | PeriodicSystem | DelaySystem):
        matrices.require_one(problem, "equation")
    else:
        require_equation(problem, hint="or a HillSystem, PeriodicSystem or DelaySystem")


def require_without_delays(problem: Any, what: str) -> None:
    """Raise TypeError for a system with delays, of which there is no such thing."""
    if isinstance(problem, DelaySystem):
        raise TypeError(f"equation must be without delays for {what}, got {validate.short(problem)}")


def member(
    family: Callable[..., Any], point: Mapping[str, Any], like: Problem | None = None, argument: str = "family"
) -> Problem:
    """Return the member of a family at a point, checked, and of the kind of ``like``; messages name the point."""
    at = f"{argument}({', '.join(f'{name}={_written(value)}' for name, value in point.items())})"
    try:
        found: Any = family(**point)
    except Exception as error:
        raise ValueError(f"{at} raised {type(error).__name__}: {error}") from error
    if not isinstance(found, Problem):
        wanted = "a HillSystem, a PeriodicSystem, a DelaySystem or an Equation"
        raise TypeError(f"{at} must return {wanted}, got {validate.short(found)}")
    if not isinstance(found, Equation) and found.shape:
        raise ValueError(f"{at} must return one system, got a batch of shape {found.shape}")
    if like is not None and isinstance(found, Equation) != isinstance(like, Equation):
        what = "an Equation, as at other points" if isinstance(like, Equation) else "a system, as at other points"
        raise TypeError(f"{at} must return {what}, got {validate.short(found)}")
    return found


def _written(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float | int) else validate.short(value)
