"""One record for each method: what it does, what it serves, how accurate it is and where it comes from.

`floquetrod.stability` and its docstring, `floquetrod.compare`, `floquetrod.methods`, the terminal, the reference pages
and the tests over all methods read `METHODS`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from floquetrod._util import validate
from floquetrod.equations import (
    DelayedMoments,
    DelaySystem,
    Equation,
    HillSystem,
    Mathieu,
    MathieuAQ,
    Meissner,
    PeriodicSystem,
)
from floquetrod.equations import require as require_equation
from floquetrod.floquet import references
from floquetrod.floquet.problems import KINDS, Problem, kind_of, undamped_pairs


def _series(equation: Equation) -> str | None:
    needed = "equation must be one Fourier series for the spectral method, such as Mathieu or Hill"
    return None if equation.is_smooth else needed


def _smooth(system: HillSystem | PeriodicSystem) -> str | None:
    needed = "system must be one Fourier series for the spectral method, and this one has several pieces"
    return None if system.is_smooth else needed


def _sine(equation: Equation) -> str | None:
    return None if _is_sine(equation) else "equation must be Mathieu for Hill's four determinants"


def _two_levels(equation: Equation) -> str | None:
    needed = "equation must be Meissner, Mathieu for the square-wave method"
    return None if isinstance(equation, Meissner | Mathieu | MathieuAQ) else needed


def _even(system: HillSystem | PeriodicSystem) -> str | None:
    pairs = undamped_pairs(system)
    if pairs is not None and isinstance(pairs[0], HillSystem) and pairs[0].is_even:
        return None
    return (
        "system must have a stiffness even about an instant, no gyroscopic matrix, and damping 2 c M or none for "
        "half_period; method='monodromy' takes any"
    )


def _delayed(system: DelaySystem) -> str | None:
    return None if system.delayed else "system must have delays for winding; method='collocation' takes any"


def _is_long(system: DelaySystem) -> bool:
    from floquetrod.floquet.multipliers import whole_steps  # when asked: it takes long to import

    return whole_steps.is_long(system)


def _never(_: Any) -> bool:
    return False


def _always(_: Any) -> bool:
    return True


def _is_sine(equation: Equation) -> bool:
    return isinstance(equation, Mathieu | MathieuAQ)


class Service(NamedTuple):
    """How a method serves one kind of problem: equations, systems, or systems with delays."""

    does: str  # in a sentence
    sources: tuple[str, ...]
    refusal: Callable[[Any], str | None] | None = None
    """Of a problem of the kind: why the method does not serve it, None where it does; None where it serves all."""
    accuracy: float = 1e-13
    """Error of growth and multipliers, relative, on problems of moderate size and with the default options."""
    approximates: Callable[[Any], bool] = _never
    """Of a problem: whether the stated error leaves out how far the method's own equation is from it."""
    another: Callable[[Any], bool] = _never
    """Of a problem: whether the method's own equation has another coefficient."""


class Method(NamedTuple):
    """A method, and what it does for each kind of problem that it serves; None for the kinds it does not.

    Its function has its name, in the file of `floquetrod.floquet.methods` named after it: ``spectral`` for equations,
    ``system_spectral`` for systems, ``delay_spectral`` for systems with delays,
    ``moments_spectral`` for second moments of those.
    """

    name: str
    equations: Service | None = None
    systems: Service | None = None
    delays: Service | None = None
    delayed_moments: Service | None = None

    def service(self, problem: Problem) -> Service | None:
        """Return what the method does for problems of this kind, None where it does not serve the kind."""
        service: Service | None = getattr(self, kind_of(problem).field)
        return service

    def refusal(self, problem: Problem) -> str | None:
        """Return why the method does not serve a problem, None where it does."""
        service = self.service(problem)
        if service is not None:
            return None if service.refusal is None else service.refusal(problem)
        words = [kind.words for kind in KINDS if getattr(self, kind.field) is not None]
        return f"{self.name} is a method for {' and '.join(words)}, not for {kind_of(problem).words}"


METHODS = (
    Method(
        "spectral",
        equations=Service(
            "Hill's matrix: counts of its eigenvalues below that of the equation", (references.DLMF,), _series
        ),
        systems=Service(
            "Hill's matrix: its eigenvalues, and counts of its negative ones",
            (references.THEORY, references.BOTT),
            _smooth,
        ),
    ),
    Method(
        "determinant",
        equations=Service("Hill's four determinants, and their signs", (references.STUDY, references.DLMF), _sine),
    ),
    Method(
        "half_period",
        systems=Service("the map over half a period, from an instant of evenness", (references.THEORY,), _even),
    ),
    Method(
        "monodromy",
        equations=Service("the map over a period, by Taylor series", (references.THEORY,)),
        systems=Service("the map over a period, by Taylor series", (references.THEORY, references.MEHRMANN)),
    ),
    Method(
        "segmented",
        systems=Service("maps over segments of the period, which are never multiplied", (references.THEORY,)),
    ),
    Method(
        "square_wave",
        equations=Service(
            "the closed form of a coefficient with two values",
            (references.STUDY,),
            _two_levels,
            approximates=_is_sine,
            another=_is_sine,
        ),
    ),
    Method(
        "leapfrog",
        equations=Service(
            "the published study's test: 100 periods by leapfrog",
            (references.STUDY,),
            accuracy=1e-6,
            approximates=_always,
        ),
    ),
    Method(
        "reference",
        equations=Service("the map over a period in many digits, with bounds", (references.THEORY,)),
        systems=Service("the map over a period in many digits, with bounds", (references.THEORY, references.MEHRMANN)),
    ),
    Method(
        "collocation",
        delays=Service(
            "the map of the state and its history, by collocation at Gauss's nodes",
            (references.BREDA, references.INSPERGER),
            accuracy=1e-11,
        ),
    ),
    Method(
        "winding",
        delays=Service(
            "zeros of the determinant of one period, counted by a winding number",
            (references.SIEBER,),
            _delayed,
            accuracy=1e-9,
        ),
    ),
    Method(
        "semi_discretisation",
        delays=Service("short steps with constant coefficients, extrapolated", (references.INSPERGER,), accuracy=1e-5),
    ),
    Method(
        "renewal",
        delayed_moments=Service(
            "the renewal equation of the products of noise, by responses to kicks",
            (references.KUCHLER, references.BREDA),
            accuracy=1e-9,
        ),
    ),
)
"""Every method there is, in the order in which `floquetrod.compare` runs them."""

BY_NAME = {method.name: method for method in METHODS}
"""The methods by their names."""


def methods_for(kind: str) -> tuple[Method, ...]:
    """Return the methods that serve problems of a kind: "equations", "systems", "delays" or "delayed_moments"."""
    return tuple(method for method in METHODS if getattr(method, kind) is not None)


_NAMES = {kind: ("auto", *(method.name for method in methods_for(kind.field))) for kind in KINDS}


def names_of(problem: Problem) -> tuple[str, ...]:
    """Return "auto" and the names of the methods for a problem of this kind."""
    return _NAMES[kind_of(problem)]


def names_in_words() -> str:
    """Return the names of the methods by kind of problem, for the docstring of `floquetrod.stability`."""
    quoted = {kind.words: ", ".join(f'"{name}"' for name in names[1:]) for kind, names in _NAMES.items()}
    return "; ".join(f"of {words} {names}" for words, names in quoted.items())


def applicable(problem: Problem) -> tuple[Method, ...]:
    """Return the methods that serve a problem."""
    return tuple(method for method in METHODS if method.refusal(problem) is None)


def refusal(problem: Problem, method: str) -> str | None:
    """Return why the method of this name does not serve a problem, None where it does."""
    return BY_NAME[method].refusal(problem)


def service(problem: Problem, method: str) -> Service:
    """Return what the method of this name does for problems of this kind; ValueError where it does not serve it."""
    record = BY_NAME[method].service(problem)
    if record is None:
        raise ValueError(BY_NAME[method].refusal(problem))
    return record


def is_approximation(problem: Problem, method: str) -> bool:
    """Return whether the method solves an equation near the problem, whose distance its errors do not include."""
    return service(problem, method).approximates(problem)


def solves_another(problem: Problem, method: str) -> bool:
    """Return whether the method solves an equation with another coefficient."""
    return service(problem, method).another(problem)


def sources(problem: Problem, method: str) -> tuple[str, ...]:
    """Return the sources of the method that answered for a problem, and of second moments where it is such."""
    return service(problem, method).sources + _noise(problem)


def proof_sources(problem: Problem) -> tuple[str, ...]:
    """Return the sources of proofs for a problem."""
    return kind_of(problem).proof_sources + _noise(problem)


def _noise(problem: Any) -> tuple[str, ...]:
    return references.NOISE if getattr(problem, "MEANING", "") else ()


def require(equation: Any, method: str) -> None:
    """Raise TypeError unless the method of this name serves a scalar equation."""
    require_equation(equation)
    if needed := refusal(equation, method):
        raise TypeError(f"{needed}, got {validate.short(equation)}")


def in_turn(problem: Problem | DelayedMoments) -> tuple[str, ...]:
    """Return the methods that "auto" tries one after another, the fastest trustworthy one first."""
    if isinstance(problem, DelaySystem):
        return ("winding", "collocation") if _is_long(problem) else ("collocation",)
    if isinstance(problem, DelayedMoments):
        return ("renewal",)
    if isinstance(problem, Mathieu | MathieuAQ):
        return "spectral", "reference"
    if isinstance(problem, Meissner):
        return "square_wave", "reference"
    if isinstance(problem, Equation):
        return ("monodromy", "spectral", "reference") if problem.is_smooth else ("monodromy", "reference")
    return "monodromy" if _even(problem) else "half_period", "segmented", "reference"
