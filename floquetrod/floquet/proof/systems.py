"""Proofs for systems of equations, by the multipliers or by counts, with as many digits as it takes.

Two ways, each in balls.  The multipliers lie in discs: one of modulus above 1 proves instability, all of modulus below
1 prove decay, and where with every mu there is 1 / conj(mu), a disc that holds one multiplier and whose mirror image
meets no other holds it on the circle.  Where discs touch each other, the Krein signs of what they hold are summed: see
`krein`.  Where that fails, as at 1 and -1, or the map takes too long, Hill's operator is counted: see `system_counts`.

Uniform damping 2 c M: q = exp(-c t) u takes M c^2 from the stiffness and leaves u without damping.  A strongly stable u
proves that q decays.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from floquetrod.equations import HillSystem, PeriodicSystem
from floquetrod.equations import pieces as by_pieces
from floquetrod.floquet.proof.balls import Array, Doubles, up
from floquetrod.floquet.proof.digits import balls, settled
from floquetrod.floquet.proof.krein import krein_sums
from floquetrod.floquet.proof.many_digits import TooMuchWork, Unresolved
from floquetrod.floquet.proof.matrices_alone import expanding, norm_kept, overdamped, turning
from floquetrod.floquet.proof.proof import Enclosure, Proof
from floquetrod.floquet.proof.system_counts import Counts, angles_between, count
from floquetrod.floquet.proof.system_discs import EigenvalueDiscs, enclose_eigenvalues
from floquetrod.floquet.proof.system_flow import monodromy
from floquetrod.floquet.proof.system_numbers import system_problem
from floquetrod.floquet.proof.system_problem import Arithmetic, FirstOrder, Flow, Matrix, SystemProblem, row_sum
from floquetrod.floquet.verdict import Status

_MOST_SQUARES, _LARGEST_NORM = 12, 1e100  # of a map, and norm of a power, with which squaring stops (choices)
_MOST_DIGITS_OF_INEXACT = 30  # more do not help where the coefficients are known to about 15


class _Finding(NamedTuple):
    """A verdict, the sentence that says what was proved, and the quantities that decided."""

    status: Status
    statement: str
    enclosures: tuple[Enclosure, ...]


def certify_system(system: HillSystem | PeriodicSystem, max_digits: int) -> Proof:
    """Prove a system stable or unstable."""
    kept = norm_kept(system)
    if kept is not None and system.structure == "unitary":
        return Proof(system, "stable", None, 0, kept)
    problem = system_problem(by_pieces.real_form(system))
    if problem.error:
        max_digits = min(max_digits, _MOST_DIGITS_OF_INEXACT)

    def attempt(digits: int) -> Proof:
        finding = _attempt(balls(digits), problem)
        return Proof(system, finding.status, None, digits, finding.statement, finding.enclosures)

    def undecided(digits: int, reason: str) -> Proof:
        bounded, grows = kept or overdamped(system) or turning(system), expanding(system)
        if bounded or grows:
            return Proof(system, "stable" if bounded else "unstable", None, 0, bounded or grows or "")
        if problem.error:
            reason += f"; the coefficients are known only to {problem.error:.2g}"
        return Proof(system, "undecided", None, digits, reason)

    return settled(attempt, max_digits, undecided)


def status_of_all(problem: SystemProblem, multipliers: Array) -> Status | None:
    """Return what doubles prove of a problem that stands for many systems; None where they do not.

    Counts bear more variation of the coefficients than discs and come first; about ``multipliers`` they are taken.
    """
    arithmetic = Doubles()
    with np.errstate(all="ignore"):
        for attempt in (_by_count_between, _by_map):
            try:
                finding = attempt(arithmetic, problem, multipliers)
            except (Unresolved, TooMuchWork, np.linalg.LinAlgError):
                continue
            if finding is not None:
                return finding.status
    return None


def _by_count_between(arithmetic: Arithmetic, problem: SystemProblem, multipliers: Array) -> _Finding | None:
    """Conclude from counts at angles between multipliers; None where nothing follows, or there is nothing to count."""
    if isinstance(problem, FirstOrder) or not (problem.is_hamiltonian and problem.is_series):
        return None
    freed = problem.oscillators(arithmetic, problem.unit, freed=True)
    counts = count(arithmetic, freed, angles_between(multipliers))
    return _by_count(counts, problem.order, damped=problem.is_damped)


def _by_map(arithmetic: Arithmetic, problem: SystemProblem, _: Array) -> _Finding:
    """Conclude from the map over a period."""
    enclosed = _enclosed_map(arithmetic, problem.flow(arithmetic))
    return _of_map(arithmetic, problem, enclosed, enclose_eigenvalues(arithmetic, enclosed.matrix))


def _attempt(arithmetic: Arithmetic, problem: SystemProblem) -> _Finding:
    """Prove a verdict by the map or else by counting; raises `Unresolved` if the digits are too few."""
    multipliers = np.exp(2j * np.pi * np.linspace(0.0, 0.5, 17))  # where the map does not tell them
    try:
        enclosed = _enclosed_map(arithmetic, problem.flow(arithmetic))
        try:
            discs = enclose_eigenvalues(arithmetic, enclosed.matrix)
            multipliers = discs.centres
            finding = _of_map(arithmetic, problem, enclosed, discs)
        except Unresolved:
            by_powers = _by_powers(enclosed.matrix)
            if by_powers is None:
                raise
            finding = by_powers
    except (Unresolved, TooMuchWork):
        counted = _by_count_between(arithmetic, problem, multipliers)
        if counted is None:
            raise
        finding = counted
    if not problem.is_constant:
        return finding
    constant = f"the coefficients are constant; over a time of {float(problem.unit.low):g}, {finding.statement}"
    return finding._replace(statement=constant)


class _Enclosed(NamedTuple):
    """The map over a period in balls."""

    matrix: Matrix
    form: Matrix  # that it keeps where the system is Hamiltonian


def _enclosed_map(arithmetic: Arithmetic, flow: Flow) -> _Enclosed:
    """Return the map over a period."""
    return _Enclosed(monodromy(arithmetic, flow), flow.form)


def _of_map(arithmetic: Arithmetic, problem: SystemProblem, enclosed: _Enclosed, discs: EigenvalueDiscs) -> _Finding:
    """Conclude from discs that contain the multipliers of a map, or else from their Krein signs."""
    try:
        return _by_discs(discs, paired=problem.is_paired)
    except Unresolved:
        if not problem.is_hamiltonian:
            raise
        damped = problem.is_damped
        freed = _enclosed_map(arithmetic, problem.flow(arithmetic, freed=True)) if damped else enclosed
        finding = _by_signs(arithmetic, freed, angles_between(discs.centres), damped=damped)
        if finding is None:
            raise
        return finding


def _by_discs(discs: EigenvalueDiscs, *, paired: bool) -> _Finding:
    """Conclude from discs that contain the multipliers; ``paired``: with mu there is 1 / conj(mu)."""
    parts = discs.parts()
    outside = max(parts, key=lambda part: float(discs.low[part].min()))
    if discs.low[outside].min() > 0.0:
        statement = "a multiplier lies outside the unit circle, so a solution grows"
        square = _enclose("abs(multiplier)^2 - 1", discs.low[outside].min(), discs.high[outside].max())
        return _Finding("unstable", statement, (square,))
    if (discs.high < 0.0).all():
        statement = "every multiplier lies inside the unit circle, so every solution decays"
        square = _enclose("largest abs(multiplier)^2 - 1", discs.low.max(), discs.high.max())
        return _Finding("stable", statement, (square,))
    undecided = ~(discs.on_circle() if paired else discs.high < 0.0)
    if not undecided.any():
        statement = (
            "every multiplier mu is alone in a small disc; 1 / conj(mu) is a multiplier in that disc, thus mu itself, "
            "on the unit circle, so every solution is bounded, also after any small change that keeps the pairing"
        )
        together = discs.radii[:, None] + discs.radii[None, :]
        farthest = up(discs.gaps + 2.0 * together).min()
        return _Finding(
            "stable", statement, (_enclose("least distance of two multipliers", discs.gaps.min(), farthest),)
        )
    part = max((part for part in parts if undecided[part].any()), key=len)
    where = f"close to {complex(discs.centres[part[0]]):.4g}"
    if len(part) == 1:
        raise Unresolved(f"a multiplier {where} cannot be distinguished from the unit circle")
    krein = ", nor do counts show their Krein signs to agree" if paired else ""
    raise Unresolved(f"{len(part)} multipliers {where} cannot be distinguished{krein},")


def _by_powers(matrix: Matrix) -> _Finding | None:
    """Conclude from powers of a map whose multipliers cannot be distinguished, None where nothing follows.

    Where a norm of a power is below 1 all multipliers are inside the circle, and where none is outside it no trace of
    n rows exceeds n.
    """
    n = matrix.shape[0]
    power = matrix
    for exponent in range(_MOST_SQUARES):
        norm = row_sum(power)
        if norm < 1.0:
            statement = (
                f"the largest row sum of the {_ordinal(2**exponent)} power of the map is below 1, so every multiplier "
                "lies inside the unit circle and every solution decays"
            )
            return _Finding("stable", statement, (_enclose("largest row sum", 0.0, norm),))
        trace = power[0, 0]
        for i in range(1, n):
            trace = trace + power[i, i]
        least, most = float(trace.lower()), float(trace.upper())
        if least > n:
            statement = (
                f"the trace of the {_ordinal(2**exponent)} power of the map exceeds {n}, so a multiplier lies outside "
                "the unit circle, and a solution grows"
            )
            return _Finding("unstable", statement, (_enclose("abs(trace)", least, most),))
        if not norm < _LARGEST_NORM:
            break
        power = power @ power
    return None


def _ordinal(number: int) -> str:
    """Return, say, "4th"."""
    endings = {1: "st", 2: "nd", 3: "rd"}
    return f"{number}{'th' if number % 100 // 10 == 1 else endings.get(number % 10, 'th')}"


def _by_signs(arithmetic: Arithmetic, enclosed: _Enclosed, angles: list[float], *, damped: bool) -> _Finding | None:
    """Conclude from sums of Krein signs between angles, None where nothing follows."""
    try:
        arcs = krein_sums(arithmetic, enclosed.matrix, enclosed.form, angles)
    except Unresolved:
        return None
    if 2 * arcs.definite != enclosed.matrix.shape[0]:
        return None
    between = pairwise(arcs.angles)
    listed = ", ".join(
        f"{total} from {low:.6g} to {high:.6g}" for total, (low, high) in zip(arcs.sums, between, strict=True)
    )
    end = "every solution decays" if damped else "every solution is bounded"
    statement = (
        f"the Krein signs of multipliers, by angle in turns, add up to: {listed}; these are as many as there is room "
        f"for, so all multipliers are on the unit circle and definite, and {end}"
    )
    if damped:
        statement = f"with its damping removed, {statement}"
    return _Finding("stable", statement, (_enclose("least margin of a sign", arcs.margin, 1.0),))


def _by_count(counts: Counts, order: int, *, damped: bool) -> _Finding | None:
    """Conclude from counts, None where nothing follows."""
    listed = ", ".join(
        f"{negative} at {angle:.6g}" for angle, negative in zip(counts.angles, counts.negative, strict=True)
    )
    known = f"Hill's operator has as many negative eigenvalues, by angle in turns: {listed}"
    margin = _enclose("least margin of a sign", counts.margin, 1.0)
    if counts.variation == order:
        end = "every solution decays" if damped else "every solution is bounded"
        statement = f"{known}; they vary by {order}, so all multipliers are on the unit circle and definite, and {end}"
        if damped:
            statement = f"with its damping removed, {statement}"
        return _Finding("stable", statement, (margin,))
    across = counts.across
    if not damped and across is not None and (order - across) % 2 == 1:
        end = "a multiplier is real and off the unit circle, and a solution grows"
        statement = f"{known}; {order} less the difference of the outer two is odd, so {end}"
        return _Finding("unstable", statement, (margin,))
    return None


def _enclose(quantity: str, low: float, high: float) -> Enclosure:
    """Return an enclosure between two doubles."""
    import mpmath

    return Enclosure(quantity, mpmath.mpf(float(low)), mpmath.mpf(float(high)))
