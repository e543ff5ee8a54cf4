"""`fr.chart`: any family of equations or systems over the plane of two of its parameters."""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import FunctionType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod._util.progress import Progress
from floquetrod.equations import DelaySystem, Equation, PeriodicSystem, TwoFrequencies
from floquetrod.equations.batches import in_batches
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.multipliers import delay_many
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.problems import Problem, any_member
from floquetrod.floquet.quasiperiodic import growth_of_many, require_tolerance
from floquetrod.floquet.status import STABLE, STATUS_CODES, UNDECIDED, UNSTABLE
from floquetrod.floquet.verdict import Stability, tolerated
from floquetrod.plane import Axis, Chart, Family, Verdicts, axis_values, charted
from floquetrod.plane.family import VERTEX, Names
from floquetrod.systems import batch_verdicts

_GREEK = re.compile(
    "alpha|beta|gamma|delta|epsilon|zeta|eta|theta|iota|kappa|lambda|mu|nu|xi|pi|rho|sigma|tau|upsilon|phi|chi|psi|omega"
    "|Gamma|Delta|Theta|Lambda|Xi|Pi|Sigma|Upsilon|Phi|Psi|Omega"
)


def chart(
    family: Callable[..., Problem | TwoFrequencies],
    over: Mapping[str, Any],
    *,
    growth: bool = False,
    growth_tolerance: float = 0.0,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Chart:
    """Return the stability chart of a family of systems over a rectangle in the plane of two parameters.

    Parameters
    ----------
    family : callable (keywords) -> HillSystem, PeriodicSystem, Equation or TwoFrequencies
        Called with the two parameters as keywords, once for each point.
    over : mapping of str to (low, high, number) or increasing array
        The two parameters, by the names of the keywords: first the columns (x), then the rows (y).
    growth : bool
        Whether to keep the growth rates: per unit of time, the unit of the periods, and per unit tau for equations, or
        per unit z for equations of `Mathieu.from_aq`.
    growth_tolerance : float
        Growth, in the same unit, up to which a point counts as stable; with two frequencies greater than 0.
    workers : int, optional
        Threads; by default one for each core when there is enough to do.
    progress : callable, optional
        Called with the numbers of points done and to do after every row.

    Returns
    -------
    Chart
        ``stable`` at every point.

    Raises
    ------
    TypeError
        Where the family returns something else, or equations at one point and systems at another.
    ValueError
        For invalid axes, and where the family raises an exception; the message names the point.

    Examples
    --------
    >>> import floquetrod as fr
    >>> def pendulums(omega, epsilon):
    ...     coupling = [[[0.5 * epsilon, epsilon], [epsilon, 0.8 * epsilon]]]
    ...     return fr.HillSystem([[1.0, 0.0], [0.0, 4.0]], coupling, period=2.0 * np.pi / omega)
    >>> chart(pendulums, over={"omega": (2.5, 3.5, 3), "epsilon": (0.1, 0.3, 2)}).stable.tolist()
    [[True, False, True], [True, False, True]]
    """
    validate.function("family", family)
    x, y = (Axis(name, _symbol(name), "", values) for name, values in _parameters(over))
    tolerance = validate.tolerance("growth_tolerance", growth_tolerance)
    growth, workers = validate.flag("growth", growth), validate.workers(workers)
    validate.progress(progress)
    corner = {axis.name: float(axis.values[0]) for axis in (x, y)}
    members = Members(family, (x.name, y.name), any_member(family, corner), tolerance, workers)
    return charted(members, x, y, growth=growth, progress=progress)


@dataclass(frozen=True)
class Members(Family):
    """A user's family: a function that returns the equation or system at a point of the plane."""

    function: Callable[..., Problem | TwoFrequencies]
    names: tuple[str, str]  # the keywords, of x and of y
    sample: (
        Problem | TwoFrequencies
    )  # a member: charts of equations are per unit of their time, of systems per their own unit of time
    growth_tolerance: float  # as in `chart`
    workers: int | None = None
    fixed: tuple[tuple[str, float, str], ...] = ()  # (name, value, unit) of the function's other arguments
    argument: str = "family"  # name of the function in errors
    kinds: set[str] = field(default_factory=set, compare=False)  # kinds of the members judged so far, in words

    def __post_init__(self) -> None:
        """Refuse a tolerance of zero for two frequencies."""
        if isinstance(self.sample, TwoFrequencies):
            require_tolerance("growth_tolerance", self.growth_tolerance)

    @property
    def growth_unit(self) -> str:  # type: ignore[override]
        """Growth per unit of their time for equations, tau or z; per unit of time, as of the period, for systems."""
        sample = self.sample.equation if isinstance(self.sample, TwoFrequencies) else self.sample
        return f"per {sample.time}" if isinstance(sample, Equation) else "per unit time"

    @property
    def vertex(self) -> float:
        """Closer to a boundary than this verdicts on systems are slow (a choice)."""
        if isinstance(self.sample, TwoFrequencies):
            return 1e-5
        return VERTEX if isinstance(self.sample, Equation) else 1e-8

    @property
    def prompt(self) -> bool:
        """Whether bands are found about as fast as the chart; not with two frequencies."""
        return not isinstance(self.sample, TwoFrequencies)

    @property
    def points_at_once(self) -> int:
        """One row."""
        return 1

    def subject(self) -> dict[str, Any]:
        """Return the kinds of members, fixed arguments, and the name of a user's function, where it has one."""
        function = self.function
        own = isinstance(function, FunctionType) and not (function.__module__ or "").startswith("floquetrod.")
        name = function.__name__ if own else ""
        named = {"name": name} if name.isidentifier() else {}  # as "<lambda>" is not
        return {"kind": ", ".join(sorted(self.kinds)), "fixed": [list(entry) for entry in self.fixed]} | named

    def members(self, x: Floats, y: Floats) -> list[Problem | TwoFrequencies]:
        """Return the members at places x, y (n,)."""
        points = (dict(zip(self.names, point, strict=True)) for point in zip(x.tolist(), y.tolist(), strict=True))
        problems = [any_member(self.function, point, self.sample, self.argument) for point in points]
        self.kinds.update(map(_kind, problems))
        return problems

    def verdicts(self, x: Floats, y: Floats, *, growth: bool = False, quick: bool = False) -> Verdicts:
        """Return status and growth rate at places x, y; the rates are part of every verdict."""
        x, y = np.broadcast_arrays(x, y)
        members = self.members(x.ravel(), y.ravel())
        quasiperiodic = [problem for problem in members if isinstance(problem, TwoFrequencies)]
        systems = [problem for problem in members if not isinstance(problem, Equation | DelaySystem | TwoFrequencies)]
        if quasiperiodic:
            found = growth_of_many(quasiperiodic, self.growth_tolerance, precise=growth, workers=self.workers)
            status, rate = found.status, np.maximum(found.rate, 0.0)
        elif len(systems) == len(members):
            answers = in_batches(
                systems, lambda batch: batch_verdicts.verdicts(batch, workers=self.workers, quick=quick)
            )
            status, rate = (np.array(column) for column in zip(*answers, strict=True))
        elif all(isinstance(problem, DelaySystem) for problem in members):
            status, rate = _delayed(members, growth=growth or self.growth_tolerance > 0.0)
        else:
            status, rate = _one_by_one(members)
        status[(status == UNSTABLE) & tolerated(rate, self.growth_tolerance)] = STABLE
        return Verdicts(status.reshape(x.shape), rate.reshape(x.shape))

    def name(self, x: float, y: float) -> Names:
        """Return the mode, its partner and the order of the fastest resonance at a point; None without a name.

        Buckling of systems is not named: a region of it may hold the buckling of several modes.  One equation has no
        number of a mode, and its tongue is the order; 0 is buckling.
        """
        (problem,) = self.members(np.array([x]), np.array([y]))
        verdict = None if isinstance(problem, TwoFrequencies) else stability(problem)
        if isinstance(problem, Equation):
            interval = verdict.interval if isinstance(verdict, Stability) else None
            return None, None, interval.order if interval is not None and interval.kind == "tongue" else None
        if not isinstance(verdict, SystemStability) or not verdict.resonances:
            return None, None, None
        resonance = verdict.resonances[0]
        if resonance.kind == "buckling" or not resonance.modes:
            return None, None, None
        if len(resonance.modes) == 1:
            return resonance.modes[0], None, resonance.order
        first, second = resonance.modes
        order = resonance.order or None
        return (second, -first, order) if resonance.kind == "difference" else (first, second, order)


def _delayed(systems: Sequence[Any], *, growth: bool) -> tuple[NDArray[np.int8], Floats]:
    """Return status and growth rate of systems with delays; without ``growth`` the rate only where it was needed."""
    status, rate = delay_many.of_systems(systems, growth=growth)
    for i in np.flatnonzero(status == UNDECIDED).tolist():
        verdict = stability(systems[i])
        status[i], rate[i] = STATUS_CODES[verdict.status], verdict.growth_rate
    return status, np.maximum(rate, 0.0)


def _one_by_one(equations: Sequence[Any]) -> tuple[NDArray[np.int8], Floats]:
    """Return status and growth rate of equations; as one batch of systems they would take twice to seventy times."""
    importlib.import_module("numba")  # once it is loaded, scalar methods run as machine code
    verdicts = [stability(equation) for equation in equations]
    status = np.array([STATUS_CODES[result.status] for result in verdicts], dtype=np.int8)
    return status, np.array([result.growth_rate for result in verdicts])


def _parameters(over: Any) -> list[tuple[str, Floats]]:
    """Return names and values of the two parameters, checked."""
    example = 'two parameters such as {"omega": (1.0, 4.0, 200), "epsilon": (0.0, 0.5, 100)}'
    if not isinstance(over, Mapping):
        raise TypeError(f"over must be a mapping of {example}, got {validate.short(over)}")
    for name in over:
        if not isinstance(name, str) or not name.isidentifier():
            raise TypeError(f"over must name parameters of the family, {example}, got {validate.short(name)}")
    if len(over) != 2:
        raise ValueError(f"over must hold {example}, got {len(over)}: {', '.join(over) or 'none'}")
    return [(name, axis_values(f"over[{name!r}]", values)) for name, values in over.items()]


def _kind(problem: Problem | TwoFrequencies) -> str:
    """Return the kind of a problem, in words."""
    if isinstance(problem, TwoFrequencies):
        return f"{_kind(problem.equation)} with a second frequency"
    if isinstance(problem, Equation):
        return problem.title
    plural = "" if problem.order == 1 else "s"
    if getattr(problem, "MEANING", ""):
        return f"second moments, system of {problem.order} equation{plural} of first order"
    first = isinstance(problem, PeriodicSystem) or (isinstance(problem, DelaySystem) and not problem.is_second_order)
    delays = " with delays" if isinstance(problem, DelaySystem) else ""
    return f"system of {problem.order} equation{plural}{' of first order' * first}{delays}"


def _symbol(name: str) -> str:
    r"""Return a parameter's symbol in mathematics: \omega_{1} of "omega_1", q_{x} of "q_x"; "" for a word."""
    match = re.fullmatch(r"([A-Za-z]+?)(?:_?(\d+)|_([A-Za-z]))?", name)
    if match is None or not (len(match[1]) == 1 or _GREEK.fullmatch(match[1])):
        return ""
    letter = match[1] if len(match[1]) == 1 else rf"\{match[1]}"
    index = match[2] or match[3]
    return letter + (f"_{{{index}}}" if index else "")
