"""Noise in a band: white noise through a linear filter, whose states make the moments of the system an open hierarchy.

x' = (A(t) + G d.z) x with z' = F z + b xi.  Of the Hermite functions h_a of the filter's states, scaled to be
independent and of variance one, the moments M_a = E[x x^T h_a] obey a linear periodic system in which each asks for one
of higher order.  Those beyond an order are left out, and a higher order tells what that does (page `theory/noise`).

Low orders do not see noise that stays far from its mean.  With the density S0 of d.z at the frequency 0, staying at f
costs f^2 / 2 S0 per unit of time (Schilder's theorem, in the limit of slow noise): second moments grow about as fast as
the largest r(f) - f^2 / 2 S0, r the growth of second moments under A(t) + f G without noise.  A sine of amplitude f
costs half as much of the density at its frequency.
"""

from __future__ import annotations

import itertools
import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod.equations import PeriodicSystem, matrices
from floquetrod.equations import pieces as by_pieces
from floquetrod.equations.second_moments import linear_moments, of_first_order, source
from floquetrod.floquet.dispatch import run
from floquetrod.floquet.multipliers.whole_period_maps import seconds_needed
from floquetrod.floquet.problems import Problem
from floquetrod.floquet.status import Status, status_of

_MOST_SECONDS = 20.0  # of one order, estimated (a choice)
_MOST = 400  # moments of one truncation (a choice): a second or so
_FIRST, _STEP = 4, 2  # orders that are tried (a choice)
_FACTOR = 3.0  # error of a truncation over the change from the one before (a choice)
_HELD = np.geomspace(1e-3, 1.0, 40)  # values of the noise that are tried, over the largest that may matter (a choice)
_SEEN = 0.05  # of the growth under noise that stays, which a truncation may fall short of and have it (a choice)


class FilteredGrowth(NamedTuple):
    """The growth of second moments under noise in a band, from two truncations.

    Attributes
    ----------
    rate : float
        Growth rate of the second moments per unit of time, negative where they decay.
    error : float
        Estimate: three times the change from the next lower order, and the error of the exponent; no less than what
        noise that stays away from its mean may add.
    order : int
        Highest order of Hermite functions kept.
    """

    rate: float
    error: float
    order: int

    @property
    def status(self) -> Status:
        """Stable or unstable in mean square where the error leaves no doubt; an estimate, never proved."""
        return status_of(self.rate, self.error)


def filtered_growth(
    system: Problem, matrix: Any, filter: Any, *, accuracy: float = 1e-8, most: int = 24
) -> FilteredGrowth:
    """Return how fast second moments grow under noise that is white noise through a linear filter.

    Of M q'' + C q' + K(t) q + (d.z) G q = 0 for a `HillSystem`, x' = A(t) x + (d.z) G x for a `PeriodicSystem`,
    A'' + 2 c A' = (p(tau) + d.z) A for a scalar equation, with z' = F z + b xi and E[xi(t) xi(u)] = delta(t - u).

    Parameters
    ----------
    system : Equation, HillSystem or PeriodicSystem
        One system.
    matrix : array_like (n, n)
        G; [[1.0]] for a scalar equation.
    filter : (F, b, d)
        F (m, m), all of whose eigenvalues have negative real parts, b (m,) and d (m,): F = [[-1/t]] is noise of
        correlation time t; F = [[0, 1], [-w^2, -2 z w]], b = [0, 1], d = [0, s] a band about w, 2 z w wide.
    accuracy : float
        Change of the rate between two orders at which the order is high enough.
    most : int
        Highest order tried, 6 to 100; with fewer where there would be more than 400 moments.

    Returns
    -------
    FilteredGrowth
        Rate, its estimated error, and the order; white noise has no filter, see `floquetrod.second_moments`.

    Raises
    ------
    TypeError, ValueError
        For matrices that do not fit, unstable filters, filters with states that the noise does not reach, and
        systems too large for an order of 6.

    Examples
    --------
    x' = (z - 1) x with noise z of variance v and correlation time t: E[x^2] grows at 4 v t - 2.

    >>> import floquetrod as fr
    >>> found = fr.filtered_growth(fr.PeriodicSystem([[-1.0]]), [[1.0]], ([[-2.0]], [1.0], [1.0]))
    >>> round(found.rate, 9), found.status  # v = 1/4, t = 1/2
    (-1.5, 'stable')
    """
    accuracy = validate.positive("accuracy", accuracy)
    most = validate.integer("most", most, _FIRST + _STEP, 100)
    subject = of_first_order(system)
    matrices.require_one(subject)
    noise = source(system, matrix, 1.0, ("matrix", "matrix", "1"))
    if noise.matrix.ndim > 2:
        raise ValueError(f"matrix must be one matrix, got shape {noise.matrix.shape}")
    turned, through = _normal(*_filter(filter))
    rates: list[tuple[int, float, float]] = []
    held = _growth_of_held(subject, noise.matrix, *_filter(filter))
    seen = held - _SEEN * abs(held)
    for order in range(_FIRST, most + 1, _STEP):
        size = math.comb(order + len(through), order) * subject.order * (subject.order + 1) // 2
        if size > _MOST:
            break
        moments = _hierarchy(subject, noise.matrix, turned, through, order)
        seconds = seconds_needed(by_pieces.of_batch(moments))[0]
        if not seconds <= _MOST_SECONDS and len(rates) > 1:
            break
        if not seconds <= _MOST_SECONDS:
            raise ValueError(
                f"matrix and filter must be such that one period of the system can be computed in {_MOST_SECONDS:g} s, "
                f"got {seconds:.2g} s of computing: their numbers are large beside those of the system; scale the time "
                "such that the frequencies of the system and of the filter are about 1, and the noise such that "
                "matrix is"
            )
        verdict = run("monodromy", moments)
        if not verdict.exponents or not math.isfinite(verdict.exponents[0].real):
            break
        rates.append((order, verdict.exponents[0].real, verdict.exponent_errors[0]))
        if len(rates) > 1 and abs(rates[-1][1] - rates[-2][1]) <= accuracy and rates[-1][1] >= seen:
            break
    if len(rates) < 2:
        raise ValueError(f"system must be smaller: with this filter it has more than {_MOST} moments at order 6")
    order, rate, error = rates[-1]
    error += _FACTOR * abs(rate - rates[-2][1])
    return FilteredGrowth(rate, error if rate >= seen else max(error, held - rate), order)


def _growth_of_held(system: PeriodicSystem, matrix: Floats, f: Floats, b: Floats, d: Floats) -> float:
    """Return the largest growth of second moments under noise that stays at one value, less what staying costs.

    Of a constant system also under noise that stays a sine, of a frequency at which the filter resonates.
    """
    # Moments grow at most at twice the norm of the matrix: beyond 4 S |G| staying costs more than it brings.
    constant = not (system.pieces or any(part.any() for part in (*system.cosines, *system.sines)))
    resonant = sorted({float(each) for each in np.linalg.eigvals(f).imag if each > 0.0}) if constant else []
    best, norm = -math.inf, float(np.linalg.norm(matrix, 2))
    for w in (0.0, *resonant):
        density = abs(complex(d @ np.linalg.solve(1j * w * np.eye(len(f)) - f, b))) ** 2 * (2.0 if w else 1.0)
        farthest = 4.0 * density * norm
        if not 0.0 < farthest < math.inf:
            continue
        for value in (farthest * np.concatenate([_HELD] if w else [-_HELD, _HELD])).tolist():
            held = value * matrix
            verdict = run(
                "monodromy",
                PeriodicSystem(system.mean, [held], period=math.tau / w)
                if w
                else by_pieces.mapped(PeriodicSystem, system, held.__add__),
            )
            if verdict.exponents:
                best = max(best, 2.0 * verdict.exponents[0].real - value**2 / (2.0 * density))
    return best


def _filter(given: Any) -> tuple[Floats, Floats, Floats]:
    """Return F, b and d, checked."""
    if not isinstance(given, tuple | list) or len(given) != 3:
        raise TypeError(f"filter must be (F, b, d), got {validate.short(given)}")
    f = matrices.square("filter[0]", given[0])
    b, d = (validate.array(f"filter[{i}]", given[i]) for i in (1, 2))
    if f.ndim != 2 or b.shape != (len(f),) or d.shape != (len(f),):
        raise ValueError(f"filter must be (m, m), (m,) and (m,), got shapes {f.shape}, {b.shape} and {d.shape}")
    if not np.linalg.eigvals(f).real.max() < 0.0:
        raise ValueError("filter must be stable: every eigenvalue of filter[0] must have a negative real part")
    return f, b, d


def _normal(f: Floats, b: Floats, d: Floats) -> tuple[Floats, Floats]:
    """Return F and d for independent states of the filter of variance one."""
    from scipy.linalg import solve_continuous_lyapunov

    covariance = solve_continuous_lyapunov(f, -np.outer(b, b))
    try:
        root = np.linalg.cholesky(0.5 * (covariance + covariance.T))
    except np.linalg.LinAlgError:
        raise ValueError("filter must have states that the noise all reaches: leave out those it does not") from None
    return np.asarray(np.linalg.solve(root, f @ root)), np.asarray(root.T @ d)


def _hierarchy(system: PeriodicSystem, matrix: Floats, turned: Floats, through: Floats, order: int) -> PeriodicSystem:
    """Return the system of the moments M_a with Hermite functions up to an order."""
    states = len(through)
    every = [a for a in itertools.product(range(order + 1), repeat=states) if sum(a) <= order]
    place = {a: i for i, a in enumerate(every)}
    relaxing, coupling = np.zeros((2, len(every), len(every)))
    for a, row in place.items():
        for i, j in itertools.product(range(states), repeat=2):
            moved = [*a]
            moved[i] -= 1
            moved[j] += 1
            if a[i]:
                relaxing[row, place[tuple(moved)]] += turned[i, j] * math.sqrt(a[i] * moved[j])
        for j in range(states):
            above = (*a[:j], a[j] + 1, *a[j + 1 :])
            if above in place:
                weight = through[j] * math.sqrt(a[j] + 1)
                coupling[row, place[above]] += weight
                coupling[place[above], row] += weight
    unit = np.eye(len(every))

    def each(part: Floats) -> Floats:
        return np.asarray(np.kron(unit, linear_moments(part)))

    fixed = np.kron(coupling, linear_moments(matrix)) + np.kron(relaxing, np.eye(len(linear_moments(matrix))))
    return by_pieces.mapped(PeriodicSystem, system, lambda m: each(m) + fixed, each)
