"""The methods for responses: maps over a period, and Hill's matrix; they share nothing above the equations."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from floquetrod.equations import DelaySystem, Equation
from floquetrod.floquet import references
from floquetrod.floquet.problems import Problem, kind_of
from floquetrod.responses.forces import Force
from floquetrod.responses.motions import FourierMotion, Motion, trimmed


class Computed(NamedTuple):
    """A forced motion as a method returns it, and its error as a fraction of the largest value of a coordinate."""

    motion: Motion
    error: float


class ResponseMethod(NamedTuple):
    """A method for responses, and the sources that it rests upon."""

    name: str
    does: str
    call: Callable[[Problem, Force], Computed]
    refusal: Callable[[Problem, Force], str | None]
    sources: tuple[str, ...]
    delayed_sources: tuple[str, ...]


def _by_hill(problem: Problem, force: Force) -> Computed:
    from floquetrod.responses.harmonic_balance import balanced
    from floquetrod.responses.hill_arrays import hill_arrays

    arrays = hill_arrays(problem)
    shift = np.array([force.frequency or 0.0])
    values, error = balanced(arrays, force.amplitudes[None], shift, force.error)
    motion = FourierMotion(float(problem.period), force.frequency, trimmed(values[0]))
    return Computed(motion, float(error[0]))


def _by_maps(problem: Problem, force: Force) -> Computed:
    if isinstance(problem, DelaySystem):
        from floquetrod.responses.delayed_maps import marched_delayed

        return Computed(*marched_delayed(problem, force))
    from floquetrod.responses.period_maps import marched

    return Computed(*marched(problem, force))


def _series(problem: Problem, force: Force) -> str | None:
    """Return why Hill's matrix does not serve, None where it does: coefficients and force are Fourier series."""
    subjects = [problem]
    if isinstance(problem, DelaySystem):
        subjects = [problem.present, *(term.coefficient for term in problem.delayed)]
    name = "equation" if kind_of(problem).field == "equations" else "system"
    if not all(subject.is_smooth for subject in subjects if not isinstance(subject, DelaySystem)):
        return f"{name} must be one Fourier series for method='hill', and this one has several pieces"
    return (
        "force must be one Fourier series for method='hill', and this one has several pieces" if force.pieces else None
    )


def _any(problem: Problem, force: Force) -> str | None:
    return None


METHODS = (
    ResponseMethod(
        "hill",
        "Hill's matrix for the force: the amplitudes of all harmonics",
        _by_hill,
        _series,
        (references.THEORY,),
        (references.THEORY,),
    ),
    ResponseMethod(
        "monodromy",
        "the map over a period with the force, x(T) = Phi x(0) + p",
        _by_maps,
        _any,
        (references.THEORY, references.JORBA),
        (references.BREDA,),
    ),
)
"""Every method, in the order in which "auto" tries them and `floquetrod.compare` runs them."""

BY_NAME = {method.name: method for method in METHODS}
"""The methods by their names."""


def sources(problem: Problem, method: str) -> tuple[str, ...]:
    """Return the sources of the method that answered for a problem."""
    record = BY_NAME[method]
    return record.delayed_sources if isinstance(problem, DelaySystem) else record.sources


def is_scalar(problem: Problem) -> bool:
    """Return whether results are numbers rather than vectors of coordinates."""
    return isinstance(problem, Equation)
