"""The problems that get a verdict: a scalar equation or a system, one and not a batch."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from floquetrod._util import validate
from floquetrod.equations import (
    DelayedMoments,
    DelaySystem,
    Equation,
    HillSystem,
    PeriodicSystem,
    TwoFrequencies,
    matrices,
)
from floquetrod.equations import require as require_equation
from floquetrod.floquet import references

System = HillSystem | PeriodicSystem
"""A system without delays."""

Problem = Equation | HillSystem | PeriodicSystem | DelaySystem
"""A scalar equation, or a system, with delays or without."""


class ProblemKind(NamedTuple):
    """A kind of problem, and where the registry, the files and the proofs keep what they have for it."""

    words: str
    field: str  # of `floquetrod.floquet.registry.Method`
    prefix: str  # of the files of methods
    proof_sources: tuple[str, ...]


KINDS = (
    ProblemKind("scalar equations", "equations", "", (references.DLMF, references.THEORY)),
    ProblemKind("systems", "systems", "system_", (references.THEORY, references.BOTT, references.RUMP)),
    ProblemKind("systems with delays", "delays", "delay_", (references.GU, references.SIEBER)),
    ProblemKind("second moments of systems with delays", "delayed_moments", "moments_", ()),
)


def kind_of(problem: Any) -> ProblemKind:
    """Return the kind of a problem."""
    if isinstance(problem, DelayedMoments):
        return KINDS[3]
    return KINDS[0 if isinstance(problem, Equation) else 2 if isinstance(problem, DelaySystem) else 1]


def require_problem(problem: Any) -> None:
    """Raise TypeError for anything but an equation or a system, ValueError for a batch."""
    if isinstance(problem, TwoFrequencies):
        raise TypeError(
            "equation must be periodic, got one with a second frequency; give it to fr.quasiperiodic_growth, or charts "
            "of it to fr.chart with a growth_tolerance"
        )
    if isinstance(problem, HillSystem | PeriodicSystem | DelaySystem):
        matrices.require_one(problem, "equation")
    else:
        require_equation(problem, hint="or a HillSystem, PeriodicSystem or DelaySystem")


def require_without_delays(problem: Any, what: str) -> None:
    """Raise TypeError for a system with delays, where ``what`` is not implemented for them."""
    if isinstance(problem, DelaySystem | DelayedMoments):
        raise TypeError(f"equation must be without delays for {what}, got {validate.short(problem)}")


def undamped_pairs(system: System | DelaySystem | DelayedMoments) -> tuple[System, float] | None:
    """Return the system without its uniform damping c, and c, where its multipliers come in mu, 1 / mu; else None."""
    if isinstance(system, DelaySystem | DelayedMoments):
        return None
    freed = system.undamped if isinstance(system, HillSystem) else (system, 0.0)
    return freed if freed is not None and freed[0].structure in ("hamiltonian", "reversible") else None


def member(
    family: Callable[..., Any],
    point: Mapping[str, Any],
    like: Problem | TwoFrequencies | None = None,
    argument: str = "family",
) -> Problem:
    """Return the member of a family at a point, checked, and of the kind of ``like``; messages name the point."""
    problem = any_member(family, point, like, argument)
    if isinstance(problem, TwoFrequencies):
        require_problem(problem)
    return problem  # type: ignore[return-value]


def any_member(
    family: Callable[..., Any],
    point: Mapping[str, Any],
    like: Problem | TwoFrequencies | None = None,
    argument: str = "family",
) -> Problem | TwoFrequencies:
    """Return the member of a family at a point, as `member` does; it may have a second frequency."""
    at = f"{argument}({', '.join(f'{name}={_written(value)}' for name, value in point.items())})"
    try:
        problem: Any = family(**point)
    except Exception as error:
        raise ValueError(f"{at} raised {type(error).__name__}: {error}") from error
    if isinstance(problem, TwoFrequencies):
        if like is not None and not isinstance(like, TwoFrequencies):
            raise TypeError(f"{at} must return one without a second frequency, as at other points, got {problem!r}")
        return problem
    if isinstance(like, TwoFrequencies):
        raise TypeError(f"{at} must return a TwoFrequencies, as at other points, got {validate.short(problem)}")
    if not isinstance(problem, Problem):
        wanted = "a HillSystem, a PeriodicSystem, a DelaySystem or an Equation"
        raise TypeError(f"{at} must return {wanted}, got {validate.short(problem)}")
    if not isinstance(problem, Equation) and problem.shape:
        raise ValueError(f"{at} must return one system, got a batch of shape {problem.shape}")
    if like is not None and isinstance(problem, Equation) != isinstance(like, Equation):
        what = "an Equation, as at other points" if isinstance(like, Equation) else "a system, as at other points"
        raise TypeError(f"{at} must return {what}, got {validate.short(problem)}")
    return problem


def _written(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float | int) else validate.short(value)
