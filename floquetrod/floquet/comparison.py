"""Verdicts of every method that applies, side by side, for `fr.compare`."""

from __future__ import annotations

import math
import time
from abc import abstractmethod
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

from floquetrod._util.content import NoTruthValue
from floquetrod._util.result_report import Report, Reported, Table
from floquetrod.equations import Equation
from floquetrod.floquet import registry
from floquetrod.floquet.dispatch import run
from floquetrod.floquet.equation_margins import in_one_line
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.problems import Problem, require_problem
from floquetrod.floquet.references import united
from floquetrod.floquet.registry import METHODS, applicable, is_approximation
from floquetrod.floquet.verdict import Stability


class SideBySide(Reported, NoTruthValue):
    """Results of every method that applies, and the seconds that each took: what comparisons of any kind have."""

    results: tuple[Any, ...]
    seconds: tuple[float, ...]

    @property
    @abstractmethod
    def disagreements(self) -> tuple[tuple[Any, ...], ...]:
        """Pairs of methods that contradict each other, with the reason or the difference."""

    @property
    def agree(self) -> bool:
        """Whether no two methods contradict each other, within their stated errors."""
        return not self.disagreements

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite, in plain text with DOI, floquetrod first, then the sources of the methods used."""
        return united(*(result.references for result in self.results))

    def as_dict(self) -> dict[str, Any]:
        """Return the results as numbers for JSON, with the seconds that each took."""
        return {
            "agree": self.agree,
            "disagreements": [list(pair) for pair in self.disagreements],
            "methods": [
                {**result.as_dict(), "seconds": seconds}
                for result, seconds in zip(self.results, self.seconds, strict=True)
            ],
        }

    def __repr__(self) -> str:
        """Return the report."""
        return str(self.report())


@dataclass(frozen=True, repr=False)
class Comparison(SideBySide):
    """Results of several methods for one equation or system.

    Attributes
    ----------
    equation : Equation, HillSystem or PeriodicSystem
        The problem that was classified.
    results : tuple of Stability or SystemStability
        One for each method that applies, in a fixed order.
    seconds : tuple of float
        Wall time of each (the first call of a compiled method includes loading its machine code).
    """

    ask = ".agree, or .stable of each of its .results"

    equation: Problem
    results: tuple[Stability | SystemStability, ...]
    seconds: tuple[float, ...] = field(compare=False)

    @property
    def disagreements(self) -> tuple[tuple[str, str, str], ...]:
        """Pairs of methods that contradict each other, with the notes that may explain it.

        Two methods contradict each other when both decide and decide differently, and when the growth of the fastest
        solution differs by more than their stated errors.  Approximations never do: see ``approximations``.
        """
        contradictions = []
        judged = [result for result in self.results if not is_approximation(self.equation, result.method)]
        for one, other in combinations(judged, 2):
            if _contradict(one, other):
                notes = "; ".join(f"{r.method}: {r.note}" for r in (one, other) if r.note)
                contradictions.append((one.method, other.method, notes or "no reason known: one of them is wrong"))
        return tuple(contradictions)

    @property
    def approximations(self) -> tuple[str, ...]:
        """Methods that solve an equation near this one, as their notes say, and judge that one."""
        return tuple(result.method for result in self.results if is_approximation(self.equation, result.method))

    @property
    def _of_another_equation(self) -> tuple[str, ...]:
        """The approximations whose equation has another coefficient."""
        return tuple(r.method for r in self.results if registry.solves_another(self.equation, r.method))

    @property
    def left_out(self) -> tuple[tuple[str, str], ...]:
        """The methods that do not apply, each with the reason."""
        refusals = ((method.name, method.refusal(self.equation)) for method in METHODS)
        return tuple((name, refusal) for name, refusal in refusals if refusal is not None)

    def report(self) -> Report:
        """Return the verdict in a line, the table of methods, and whether they agree.

        Of Mathieu's equation and of Meissner's the verdict has the damping that stabilises it and the forcing that
        changes it.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.
        """
        what, unit = (
            ("discriminant", self.equation.time) if isinstance(self.equation, Equation) else ("structure", "unit time")
        )
        head = ("method", "verdict", f"growth per {unit}", what, "error", "cost", "ms")
        rows = [
            (
                f"{r.method} (another equation)" if r.method in self._of_another_equation else r.method,
                r.status,
                f"{r.growth_rate:.6g}",
                f"{r.discriminant:.12g}" if isinstance(r, Stability) else r.structure,
                f"{r.error:.1e}",
                str(r.cost),
                f"{1e3 * seconds:.3g}",
            )
            for r, seconds in zip(self.results, self.seconds, strict=True)
        ]
        rest = "\n".join([*(f"  {r.method}: {r.note}" for r in self.results if r.note), *self._agreement()])
        lines = [("equation" if isinstance(self.equation, Equation) else "system", repr(self.equation))]
        if formula := getattr(self.equation, "_formula", ""):
            lines.append(("", formula))
        return Report(self._headline, lines, Table([(title, "<") for title in head], rows, rest))

    @property
    def _verdict(self) -> Stability | SystemStability | None:
        """The verdict of the first method that decides, approximations aside; None where methods disagree."""
        if not self.agree:
            return None
        judged = [result for result in self.results if result.method not in self.approximations]
        return next((result for result in judged if result.status != "undecided"), judged[0])

    @property
    def _headline(self) -> str:
        """The verdict in one line."""
        verdict = self._verdict
        if verdict is None:
            return "METHODS DISAGREE"
        return in_one_line(verdict) if isinstance(verdict, Stability) else verdict._headline

    def _agreement(self) -> list[str]:
        if self.agree:
            return [self._agreed()]
        return [f"{one} and {other} disagree ({notes})" for one, other, notes in self.disagreements]

    def _agreed(self) -> str:
        """Return which methods agree, and which decide nothing, or say otherwise as approximations."""
        undecided = [r.method for r in self.results if r.status == "undecided"]
        deciding = [r for r in self.results if r.status != "undecided" and r.method not in self.approximations]
        verdicts = {r.status for r in deciding}
        others = [
            r.method
            for r in self.results
            if r.method in self.approximations and r.status != "undecided" and verdicts and r.status not in verdicts
        ]
        vague = [r.method for r in deciding if any(e != e for e in r.exponents)]
        another = self._of_another_equation
        agreeing = [r.method for r in self.results if r.method not in (*undecided, *others, *another)]
        everything = not (undecided or others) or not agreeing
        text = "all methods agree" if everything else f"{', '.join(agreeing)} agree"
        text = "no method decides" if not agreeing else text
        text += f"; {', '.join(another)} solves another equation" if another and everything else ""
        for what, names in (
            ("undecided", undecided),
            ("approximations that say otherwise", others),
            ("not all multipliers known", vague),
        ):
            text += f"; {what}: {', '.join(names)}" if names else ""
        return text

    def as_dict(self) -> dict[str, Any]:
        """Return the results as numbers for JSON, with the seconds that each took.

        Returns
        -------
        dict of str
            Among them ``status``, None where methods disagree, ``verdict``, the same in words, and ``methods``, a list
            with a dict for each.
        """
        whole, verdict = super().as_dict(), self._verdict
        methods, status = whole.pop("methods"), None if verdict is None else verdict.status
        return {
            "status": status,
            "verdict": self._headline,
            **whole,
            "approximations": list(self.approximations),
            "methods": methods,
        }


def _contradict(one: Stability | SystemStability, other: Stability | SystemStability) -> bool:
    """Return whether both decide and decide differently, or know growths that differ by more than their errors."""
    if {one.status, other.status} == {"stable", "unstable"}:
        return True
    (low, high), (least, most) = _growth_band(one), _growth_band(other)
    return low > most or least > high


def _growth_band(result: Stability | SystemStability) -> tuple[float, float]:
    """Return what the real part of the largest exponent lies between, as a method states it."""
    known = [
        (exponent.real, error)
        for exponent, error in zip(result.exponents, result.exponent_errors, strict=True)
        if exponent == exponent
    ]
    low = max((real - error for real, error in known), default=-math.inf)
    high = max((real + error for real, error in known), default=math.inf)
    return low, max(high, result.unknown_below) if isinstance(result, SystemStability) else high


def compare_verdicts(equation: Problem) -> Comparison:
    """Classify an equation or a system by every method that applies; see `floquetrod.compare`."""
    results, seconds = [], []
    require_problem(equation)
    for method in applicable(equation):
        start = time.perf_counter()
        results.append(run(method.name, equation))
        seconds.append(time.perf_counter() - start)
    return Comparison(equation, tuple(results), tuple(seconds))
