"""Proofs for systems with delays: that they are stable whatever the delays, else by the count of `delay_counts`.

The first by a functional of Lyapunov and Krasovskii.  With A the constant part in first order, E and C what its other
terms act on and see, and w a bound of the sum of their norms, x' = A x - sum_m E Delta_m(t) C x(t - tau_m), tau_0 = 0.
Where P > 0 makes

    A^T P + P A + w (P E E^T P + C^T C) < 0,

V = x^T P x + sum_m w_m (integral over the last tau_m of |C x|^2) decreases, for 2 |E^T P x| w_m |C x(t - tau_m)| is at
most w_m (|E^T P x|^2 + |C x(t - tau_m)|^2): every solution decays.  P comes from doubles, both signs are decided with
fractions.  K. Gu, V. L. Kharitonov, J. Chen, Stability of Time-Delay Systems, Birkhaeuser 2003,
doi:10.1007/978-1-4612-0039-0.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod.equations import DelaySystem, HillSystem
from floquetrod.equations.matrices import mass_matrix
from floquetrod.equations.pieces import in_time
from floquetrod.floquet.proof.delay_counts import hindrance, outside
from floquetrod.floquet.proof.digits import FIRST, balls, settled
from floquetrod.floquet.proof.exact import Exact, exact, identity, inverse, is_positive, product, total, transposed
from floquetrod.floquet.proof.proof import Proof

_MOST_STATES = 12  # of the system in first order (a choice: a second with fractions)
_SLACK = 1.0 + 2.0**-40  # times what is computed in doubles bounds the true norm
_MARGINS = (1e-3, 1e-6)  # part of w that P is asked to leave (a choice)
_MOST_DIGITS = 60  # of a count: it takes seconds (a choice)


class _Terms(NamedTuple):
    """A, E, C exactly, in scaled coordinates and times, and w: a bound of all that varies or is delayed."""

    state: Exact
    acts: Exact
    sees: Exact
    bound: Fraction


def certify_delayed(system: DelaySystem, max_digits: int) -> Proof:
    """Return a proof that every solution decays whatever the delays are, or of how many multipliers are outside."""
    if system.order * (1 + system.is_second_order) <= _MOST_STATES and _decays_with_all_delays(system):
        statement = "every solution decays, whatever the delays are: a quadratic functional decreases"
        return Proof(system, "stable", None, 0, statement)

    why_not = hindrance(system)
    if why_not:
        return Proof(system, "undecided", None, 0, why_not)

    def attempt(digits: int) -> Proof:
        count = outside(balls(digits), system)
        if not count:
            statement = "every solution decays: no multiplier lies on the unit circle or outside it"
            return Proof(system, "stable", None, digits, statement)
        statement = f"{count} multiplier{'s lie' if count > 1 else ' lies'} outside the unit circle, and none on it"
        return Proof(system, "unstable", None, digits, statement)

    most = FIRST if system.coefficient_error else _MOST_DIGITS
    return settled(attempt, min(max_digits, most), lambda digits, why: Proof(system, "undecided", None, digits, why))


def _decays_with_all_delays(system: DelaySystem) -> bool:
    terms = _terms(system)
    functionals = (_functional(terms, margin) for margin in _MARGINS)
    return any(each is not None and _decreases(terms, each) for each in functionals)


def _terms(system: DelaySystem) -> _Terms:
    present, n = system.present, system.order
    bound = _size(present, np.asarray(getattr(present, present.MEAN)))
    bound += sum(_size(term.coefficient, np.zeros((n, n))) for term in system.delayed)
    bound += n * system.coefficient_error * (1 + len(system.delayed))
    one = identity(n)
    if not isinstance(present, HillSystem):
        return _Terms(exact(present.mean), one, one, Fraction(_SLACK * bound))
    none = [[Fraction(0)] * n for _ in range(n)]
    acts_on = inverse(exact(mass_matrix(present)))
    left, right = product(acts_on, exact(present.stiffness)), none
    for rates in (present.damping, present.gyroscopic):
        right = right if rates is None else total(right, product(acts_on, exact(rates)))
    turn = _power_of_two(math.sqrt(max(float(abs(entry)) for row in left for entry in row) or 1.0))
    size = _power_of_two(max(float(abs(entry)) for row in acts_on for entry in row))
    # States (q, q' / turn), time counted in 1 / turn; E over its size, by which w is multiplied.
    lower = [[-a / turn**2 for a in one_] + [-b / turn for b in other] for one_, other in zip(left, right, strict=True)]
    state = [[*row, *unit] for row, unit in zip(none, one, strict=True)] + lower
    acts = none + [[entry / size for entry in row] for row in acts_on]
    sees = [[*unit, *row] for unit, row in zip(one, none, strict=True)]
    return _Terms(state, acts, sees, Fraction(_SLACK * bound) * size / turn**2)


def _size(coefficient: Any, mean: Floats) -> float:
    """Return a bound, to rounding, of the norm of a coefficient less a constant matrix at any time."""
    largest = 0.0
    for piece in in_time(coefficient):
        rest = piece._replace(mean=piece.mean - mean).size + 2.0**-50 * (np.abs(piece.mean) + np.abs(mean))
        largest = max(largest, float(np.linalg.norm(rest)))
    return largest


def _functional(terms: _Terms, margin: float) -> Exact | None:
    """Return P from doubles, None where there is none: Riccati's equation, without delayed terms Lyapunov's."""
    from scipy.linalg import solve_continuous_are

    state, acts, sees = (np.array([[float(x) for x in row] for row in each]) for each in terms[:3])
    w = float(terms.bound)
    least = margin * max(w, 1e-6 * float(np.abs(state).max()))
    left = sees.T @ sees * w + least * np.eye(len(state))
    try:
        solution = solve_continuous_are(state, acts * math.sqrt(max(w, 1e-300)), left, -np.eye(acts.shape[1]))
    except (np.linalg.LinAlgError, ValueError):
        return None
    return exact(0.5 * (solution + solution.T)) if np.isfinite(solution).all() else None


def _decreases(terms: _Terms, functional: Exact) -> bool:
    """Return whether P is positive and the derivative of V negative, decided exactly."""
    state, acts, sees, w = terms
    moved = product(functional, state)
    forced = product(functional, acts)
    pushed, seen = product(forced, transposed(forced)), product(transposed(sees), sees)
    rate = [
        [-(moved[i][j] + moved[j][i] + w * (pushed[i][j] + seen[i][j])) for j in range(len(state))]
        for i in range(len(state))
    ]
    return is_positive(functional) and is_positive(rate)


def _power_of_two(value: float) -> Fraction:
    return Fraction(2) ** math.frexp(value)[1]
