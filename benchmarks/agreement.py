"""Every method against every other over equations drawn as the property tests draw them, pair by pair.

python -m benchmarks.agreement [number of equations] [seed]

Two results for one equation may differ in two ways, and each method states how far it answers for both.  Discriminants,
and exponents of systems, may differ by the sum of the errors stated.  Verdicts may differ where one of the methods says
that it cannot see what the other saw: leapfrog's test is blind to slow growth and takes for real what too long a step
makes of a motion that is stable; a square wave is only like a sine.  What differs by more than that is a fault, and
there must be none.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from statistics import fmean, median
from typing import Any

import floquetrod as fr
from benchmarks.measure import Row
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.registry import applicable, names_of

Result = fr.results.Stability | SystemStability

BLIND = 1.25 * math.log(1e6) / 100.0  # growth over a period that leapfrog's 100 may miss, up to the factor it names


@dataclass
class Pair:
    """What two methods said about the equations to which both apply.

    Attributes
    ----------
    agree, undecided : int
        Equations on which both decide alike; on which one or both say "undecided".
    stated : int
        Equations on which the verdicts differ as one of the methods says they may.
    faults : list
        The pairs of results that differ by more than is stated, in verdict or discriminant.
    largest : float
        Largest difference of discriminants, relative to max(1, abs(discriminant)), approximations left out; of systems,
        of growth over a period.
    """

    agree: int = 0
    undecided: int = 0
    stated: int = 0
    faults: list[tuple[Result, Result]] = field(default_factory=list)
    largest: float = 0.0

    @property
    def total(self) -> int:
        """Number of equations."""
        return self.agree + self.undecided + self.stated + len(self.faults)


@dataclass
class Matrix:
    """Pairs of methods, and the seconds that each method took for each of its verdicts."""

    pairs: dict[tuple[str, str], Pair]
    seconds: dict[str, list[float]]

    @property
    def faults(self) -> list[tuple[Result, Result]]:
        """All pairs of results that differ by more than is stated."""
        return [fault for pair in self.pairs.values() for fault in pair.faults]

    def __str__(self) -> str:
        """Return two tables."""
        rows = [("methods", "", "equations", "agree", "undecided", "differ as stated", "beyond", "largest difference")]
        for (one, other), pair in self.pairs.items():
            counts = (pair.total, pair.agree, pair.undecided, pair.stated, len(pair.faults))
            rows.append((one, other, *map(str, counts), f"{pair.largest:.1e}" if pair.largest else ""))
        times = [("method", "verdicts", "median ms", "mean ms")]
        for name, taken in self.seconds.items():
            middle, mean = (1e3 * average(taken or [0.0]) for average in (median, fmean))
            times.append((name, str(len(taken)), f"{middle:.3g}", f"{mean:.3g}"))
        return f"{_table(rows)}\n\n{_table(times)}"


def draw(number: int, seed: int) -> list[Any]:
    """Return ``number`` equations drawn by the strategies of the property tests: every kind, also near boundaries."""
    from tests import strategies as st

    kinds = [
        st.mathieus(largest_alpha=30.0, beta=(-30.0, 5.0), largest_damping=0.3),
        st.mathieus(),
        st.near_boundary_points().map(lambda point: fr.Mathieu(*point)),
        st.square_waves(largest_damping=0.3),
        st.hills(largest=10.0, largest_damping=0.3),
    ]
    return _drawn(kinds, number, seed)


def draw_systems(number: int, seed: int) -> list[Any]:
    """Return ``number`` systems of equations drawn by the strategy of the property tests: every structure."""
    from tests import strategies as st

    kinds = ("hamiltonian", "reversible", "damped", "gyroscopic", "first")
    return _drawn([st.systems(kinds=(kind,)) for kind in kinds], number, seed)


def _drawn(kinds: Sequence[Any], number: int, seed: int) -> list[Any]:
    share = math.ceil(number / len(kinds))
    return [equation for kind in kinds for equation in _examples(kind, share, seed)][:number]


def _examples(strategy: Any, number: int, seed: int) -> Iterator[Any]:
    import hypothesis

    found = []

    @hypothesis.seed(seed)
    @hypothesis.settings(
        max_examples=number,
        database=None,
        deadline=None,
        phases=[hypothesis.Phase.generate],
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    @hypothesis.given(strategy)
    def collect(equation: Any) -> None:
        found.append(equation)

    collect()
    yield from found


def matrix(equations: Sequence[Any]) -> Matrix:
    """Judge every equation by every method that applies and compare the results pair by pair."""
    names = dict.fromkeys(name for equation in equations for name in names_of(equation)[1:])
    applying = [{method.name for method in applicable(equation)} for equation in equations]
    pairs = {(one, other): Pair() for one, other in combinations(names, 2) if any({one, other} <= a for a in applying)}
    seconds: dict[str, list[float]] = {name: [] for name in names}
    for equation in dict(zip(map(frozenset, applying), equations, strict=True)).values():
        fr.compare(equation)  # machine code is loaded before anything is timed
    for equation in equations:
        comparison = fr.compare(equation)
        for result, time in zip(comparison.results, comparison.seconds, strict=True):
            seconds[result.method].append(time)
        for one, other in combinations(comparison.results, 2):
            count(pairs[one.method, other.method], one, other)
    return Matrix(pairs, seconds)


def count(pair: Pair, one: Result, other: Result) -> None:
    """Count two results for one equation into ``pair``."""
    approximate = any("approximation" in result.note for result in (one, other))
    distance = 0.0 if approximate else difference(one, other)
    known = math.isfinite(one.error + other.error)
    if known:
        pair.largest = max(pair.largest, distance)
    if {one.status, other.status} == {"stable", "unstable"}:
        if approximate or _leapfrog_may_differ(one, other) or _leapfrog_may_differ(other, one):
            pair.stated += 1
        else:
            pair.faults.append((one, other))
    elif known and distance > one.error + other.error:
        pair.faults.append((one, other))
    elif "undecided" in (one.status, other.status):
        pair.undecided += 1
    else:
        pair.agree += 1


def difference(one: Result, other: Result) -> float:
    """Return the difference of two discriminants relative to max(1, abs(discriminant)), by logarithms where huge.

    Of systems, the largest difference of the growths of their solutions over a period.
    """
    if isinstance(one, SystemStability):
        growths = (sorted(exponent.real for exponent in result.exponents) for result in (one, other))
        return max((one.period * abs(a - b) for a, b in zip(*growths, strict=False)), default=0.0)
    if math.isfinite(one.discriminant) and math.isfinite(other.discriminant):
        return abs(one.discriminant - other.discriminant) / max(1.0, abs(one.discriminant), abs(other.discriminant))
    if (one.discriminant > 0.0) != (other.discriminant > 0.0):
        return 2.0
    return math.expm1(min(700.0, abs(one.log_abs_discriminant - other.log_abs_discriminant)))


def _leapfrog_may_differ(result: Result, other: Result) -> bool:
    """Whether leapfrog states a reason for a verdict unlike the other: slow growth, or an error of its own map."""
    if result.method != "leapfrog":
        return False
    if result.stable:
        return other.growth_rate * result.period < BLIND
    # Multipliers of product P lie within the unit circle when abs(D) < 1 + P.
    boundary = 1.0 + math.exp(-2.0 * result.equation.damping * result.period)
    size = abs(result.discriminant)
    return size - result.error * max(1.0, size) < boundary


def _table(rows: Sequence[Sequence[str]]) -> str:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)


def run() -> list[Row]:
    """Return the number of faults over some hundred equations and systems, for `python -m benchmarks`."""
    rows = []
    for what, found in (("", matrix(draw(500, seed=1))), (", systems", matrix(draw_systems(50, seed=1)))):
        compared = sum(pair.total for pair in found.pairs.values())
        rows.append(Row(f"comparisons of two methods{what}", compared, ""))
        rows.append(Row(f"differences beyond what the methods state{what}", len(found.faults), "", at_most=0.0))
    return rows


def main(arguments: Sequence[str]) -> int:
    """Print the matrices of equations and of a tenth as many systems, and every fault; return 1 if there is one."""
    number, seed = (int(given) for given in (*arguments, *("3000", "1")[len(arguments) :]))
    every = []
    for what, drawn in (("equations", draw(number, seed)), ("systems", draw_systems(math.ceil(number / 10), seed))):
        found = matrix(drawn)
        every += found.faults
        print(f"{len(drawn)} {what}, seed {seed}\n\n{found}\n")
    for one, other in every:
        print(f"\nbeyond what is stated:\n  {one!r}\n  {other!r}")
    return 1 if every else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
