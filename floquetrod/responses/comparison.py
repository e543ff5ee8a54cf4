"""`fr.compare`: every method that applies, side by side, for a verdict or for the response to a force."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any, overload

import numpy as np

from floquetrod._util import validate
from floquetrod._util.result_report import Report, Table
from floquetrod.floquet.comparison import Comparison, SideBySide, compare_verdicts
from floquetrod.floquet.problems import Problem, require_problem
from floquetrod.responses.forces import Force, force_of, is_empty
from floquetrod.responses.methods import METHODS
from floquetrod.responses.steady_response import Response, respond

_INSTANTS = 97  # of the period at which responses are compared


@dataclass(frozen=True, repr=False)
class ResponseComparison(SideBySide):
    """Responses of one equation or system to one force by every method that applies.

    Attributes
    ----------
    equation : Equation, HillSystem, PeriodicSystem or DelaySystem
        The problem without the force.
    force : Force
        The force.
    results : tuple of Response
        One for each method that applies.
    seconds : tuple of float
        Wall time of each.
    """

    ask = ".agree, or .largest of each of its .results"

    equation: Problem
    force: Force
    results: tuple[Response, ...]
    seconds: tuple[float, ...] = field(compare=False)

    @property
    def disagreements(self) -> tuple[tuple[str, str, float], ...]:
        """Pairs of methods whose motions differ by more than their stated errors, with the difference.

        The difference is the largest over a period, as a fraction of the largest coordinate.
        """
        pairs = ((one, other, _difference(one, other)) for one, other in combinations(self.results, 2))
        return tuple(
            (one.method, other.method, apart) for one, other, apart in pairs if not apart <= one.error + other.error
        )

    @property
    def left_out(self) -> tuple[tuple[str, str], ...]:
        """The methods that do not apply, each with the reason."""
        refusals = ((method.name, method.refusal(self.equation, self.force)) for method in METHODS)
        return tuple((name, refusal) for name, refusal in refusals if refusal is not None)

    def report(self) -> Report:
        """Return the table of methods, and whether they agree.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.
        """
        head = ("method", "largest", "rms", "error", "ms")
        rows = [
            (
                r.method,
                f"{np.max(r.largest):.12g}",
                f"{np.max(r.rms):.12g}",
                f"{r.error:.1e}",
                f"{1e3 * seconds:.3g}",
            )
            for r, seconds in zip(self.results, self.seconds, strict=True)
        ]
        apart = [f"{one} and {other} differ by {size:.1e} of the largest" for one, other, size in self.disagreements]
        rest = "\n".join(apart or ["all methods agree" if len(rows) > 1 else "no other method applies"])
        table = Table([(title, "<" if title == "method" else ">") for title in head], rows, rest)
        return Report(f"{self.equation!r} under {self.force}", (), table)


def _difference(one: Response, other: Response) -> float:
    """Return the largest difference over a period as a fraction of the largest coordinate."""
    times = np.linspace(0.0, one.period, _INSTANTS)
    first, second = (np.asarray(each.solution(times)) for each in (one, other))
    size = max(float(np.max(one.largest)), float(np.max(other.largest)))
    return float(np.abs(first - second).max()) / size if size > 0.0 else 0.0


@overload
def compare(equation: Problem) -> Comparison: ...
@overload
def compare(
    equation: Problem, force: Any, frequency: float | None = None, *, cosines: Any = (), sines: Any = (),
    jumps: Any = (), unstable: bool = False,
) -> ResponseComparison: ...  # fmt: skip
def compare(
    equation: Problem,
    force: Any = None,
    frequency: float | None = None,
    *,
    cosines: Any = (),
    sines: Any = (),
    jumps: Any = (),
    unstable: bool = False,
) -> Comparison | ResponseComparison:
    """Answer by every method that applies, and report where they agree and where not.

    Parameters
    ----------
    equation : Equation, HillSystem, PeriodicSystem or DelaySystem
        The problem to classify.
    force : float, array_like (n,) or callable, optional
        A force, whose steady motion is then compared instead of verdicts.  It and the arguments below are those of
        `floquetrod.response`.
    frequency : float, optional
        Of the force.
    cosines : sequence, optional
        Of the force.
    sines : sequence, optional
        Of the force.
    jumps : sequence of float, optional
        Of the force.
    unstable : bool
        Whether to answer for a force where free motion grows.

    Returns
    -------
    Comparison
        Of verdicts; with a force a `floquetrod.results.ResponseComparison`.

    Raises
    ------
    TypeError, ValueError
        For anything but a problem, for arguments of a force without one, and as `floquetrod.response`.

    Examples
    --------
    >>> import floquetrod as fr
    >>> compare(fr.Mathieu(alpha=0.5, beta=-0.25)).agree
    True
    >>> compare(fr.Mathieu(alpha=0.3, beta=-0.6, damping=0.01), force=1.0).agree
    True
    """
    if force is None:
        given = {"frequency": frequency, "cosines": cosines, "sines": sines, "jumps": jumps, "unstable": unstable}
        for name, value in given.items():
            if not (value is None or value is False or is_empty(value)):
                raise TypeError(f"{name} is of a force, which must be given, too; got {validate.short(value)}")
        return compare_verdicts(equation)
    require_problem(equation)
    driving = force_of(equation, force, frequency, cosines, sines, jumps)
    results, seconds = [], []
    for method in METHODS:
        if method.refusal(equation, driving) is None:
            start = time.perf_counter()
            results.append(respond(equation, driving, method.name, unstable=unstable))
            seconds.append(time.perf_counter() - start)
    return ResponseComparison(equation, driving, tuple(results), tuple(seconds))
