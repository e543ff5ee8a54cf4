"""Two frequencies that are not commensurate: growth as the limit of periodic approximants.

With coefficients of the frequencies w_1 and w_2 the ratio phi = w_2 / w_1 is replaced by fractions p / q, so that the
coefficients have the period 2 pi q / w_1.  Growth depends smoothly on the ratio inside a tongue: a polynomial in
p / q - phi through the last fractions, at 0, is the answer, and its change from one fraction to the next the error.
Next to an edge growth is no smooth function of the ratio, and the error says so.  A tongue about phi that no fraction
meets is narrower than their distance from phi, and so is the growth in it: where no approximant grows, the error is
w_1 abs(p / q - phi).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod.equations import Equation, Hill, HillSystem, PeriodicSystem, matrices
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.problems import Problem, require_problem, require_without_delays
from floquetrod.floquet.status import Status

_FIRST = 4  # smallest denominator that counts: of smaller ones the polynomial is not one yet (a choice)
_DEGREE = 3  # of the polynomial at most
_SHARE = 1e-7  # error over the growth, or the tolerance, at which it is enough (a choice)
_FACTOR = 2.0  # error over the change from the fraction before (a choice)
_RATIO = 1e6  # of the two frequencies at most, either way
_LONGEST = 2000  # denominator at most


class QuasiperiodicGrowth(NamedTuple):
    """The growth of solutions under two frequencies, from periodic approximants.

    Attributes
    ----------
    rate : float
        Largest rate of growth per unit of time, the Lyapunov exponent; negative where solutions decay.
    error : float
        Estimate: twice the change from one fraction to the next, and the error of the exponents.
    tolerance : float
        Growth per unit of time up to which it counts as none.
    approximants : tuple of (Fraction, float)
        Fractions p / q in place of the ratio of the frequencies, and the growth rate with each.
    """

    rate: float
    error: float
    tolerance: float
    approximants: tuple[tuple[Fraction, float], ...]

    @property
    def status(self) -> Status:
        """Unstable where it grows faster than the tolerance, stable where it does not; never proved.

        Tongues are everywhere: where growth is below the tolerance, a thinner one may be there.
        """
        if self.rate - self.error > self.tolerance:
            return "unstable"
        return "stable" if self.rate + self.error <= self.tolerance else "undecided"

    def __repr__(self) -> str:
        """Return the answer as a sentence."""
        ratio = self.approximants[-1][0] if self.approximants else None
        words = {
            "unstable": f"grows at {self.rate:.9g} +- {self.error:.1g} per unit of time",
            "stable": f"does not grow faster than {self.tolerance:.3g} per unit of time",
            "undecided": f"growth {self.rate:.3g} +- {self.error:.1g} per unit of time, tolerance {self.tolerance:.3g}",
        }[self.status]
        return f"<{words}; ratio of frequencies up to {ratio}>"


def quasiperiodic_growth(
    equation: Problem,
    frequency: float,
    cosines: Any = (),
    sines: Any = (),
    *,
    tolerance: float = 1e-4,
    most: int = 144,
) -> QuasiperiodicGrowth:
    """Return how fast solutions grow whose coefficients have a second frequency, not commensurate with the first.

    Of A'' + 2 c A' = (p(tau) + sum_k a_k cos(k w tau) + b_k sin(k w tau)) A for a scalar equation; a_k and b_k are
    matrices, added to K(t) of a `HillSystem` and to A(t) of a `PeriodicSystem`.

    Parameters
    ----------
    equation : Equation, HillSystem or PeriodicSystem
        The equation with its own frequency, one Fourier series.
    frequency : float
        w, the second one, in radians per unit of time; within 1e-6 and 1e6 times the first.
    cosines : sequence of float or array_like (n, n)
        a_k, from the first harmonic on.
    sines : sequence of float or array_like (n, n)
        b_k, likewise.
    tolerance : float
        Growth rate per unit of time up to which solutions count as not growing, greater than 0.
    most : int
        Largest denominator q of a fraction, 10 to 2,000: the time it takes grows like its square.

    Returns
    -------
    QuasiperiodicGrowth
        Rate, its estimated error, and the approximants.

    Raises
    ------
    TypeError, ValueError
        For delays, for coefficients in several pieces, for matrices that do not fit, and for frequencies whose
        fractions have too many harmonics.

    Notes
    -----
    A. Ya. Gordon's and Y. Last's periodic approximants; the Lyapunov exponent is continuous in the frequency where
    coefficients are analytic (J. Bourgain and S. Jitomirskaya, J. Stat. Phys. 108 (2002) 1203,
    DOI 10.1023/A:1019751801035).

    Examples
    --------
    x'' + (1/4 + 0.2 cos t + 0.2 cos(phi t)) x = 0, phi the golden ratio:

    >>> import floquetrod as fr
    >>> fr.quasiperiodic_growth(fr.Hill(-0.25, cosines=(-0.2,)), (1.0 + math.sqrt(5.0)) / 2.0, cosines=(-0.2,))
    <grows at 0.09813918... +- ... per unit of time; ratio of frequencies up to ...>
    """
    require_problem(equation)
    require_without_delays(equation, "two frequencies")
    tolerance = validate.positive("tolerance", tolerance, "0 has no answer: tongues are everywhere")
    most = validate.integer("most", most, 10, _LONGEST)
    first = 2.0 * math.pi / float(equation.period)
    ratio = validate.positive("frequency", frequency) / first
    if not 1.0 / _RATIO <= ratio <= _RATIO:
        raise ValueError(
            f"frequency must be within 1e-6 and 1e6 times that of the equation, {first:g}, got {frequency:g}"
        )
    own = _series(equation)
    second = _second(equation, cosines, sines)
    rates: list[_Rate] = []
    found = QuasiperiodicGrowth(math.nan, math.inf, tolerance, ())
    for fraction in _fractions(ratio, most):
        if max(fraction.numerator * second.shape[1], fraction.denominator * own.shape[1]) > matrices.MOST_HARMONICS:
            break
        verdict: Any = stability(_approximant(equation, own, second, fraction))
        if not verdict.exponents:
            break
        slowest = max(range(len(verdict.exponents)), key=lambda i: verdict.exponents[i].real)
        error = 0.0 if verdict.status == "stable" else float(verdict.exponent_errors[slowest])
        rates.append(_Rate(fraction, float(verdict.exponents[slowest].real), error, verdict.status == "stable"))
        found = _limit(ratio, first, rates, tolerance)
        if (
            len(rates) > _DEGREE
            and found.error < _SHARE * max(abs(found.rate), tolerance)
            and found.status != "undecided"
        ):
            break
    if len(rates) < 2:
        raise ValueError(
            f"frequency must leave fractions with at most {matrices.MOST_HARMONICS} harmonics, got {frequency:g} "
            f"beside {first:g}; exchange the two, or give fewer harmonics"
        )
    return found


class _Rate(NamedTuple):
    """Growth of an approximant and its error, both per unit of time."""

    fraction: Fraction
    value: float
    error: float
    is_stable: bool


def _limit(ratio: float, first: float, rates: list[_Rate], tolerance: float) -> QuasiperiodicGrowth:
    """Return the growth at the ratio from those at the fractions."""
    limits = []
    for end in (len(rates) - 1, len(rates)):
        kept = [each for each in rates[:end] if each.fraction.denominator >= _FIRST][-_DEGREE - 1 :]
        limits.append(_at_zero(kept or rates[:end][-1:], ratio))
    last = rates[-_DEGREE - 1 :]
    change = abs(limits[1] - limits[0]) if limits[0] == limits[0] else math.inf
    if any(each.is_stable for each in last):
        change = max(change, first * abs(float(last[-1].fraction - Fraction(ratio))))
    approximants = tuple((each.fraction, each.value) for each in rates)
    error = _FACTOR * change + max(each.error for each in last)
    return QuasiperiodicGrowth(limits[1], error, tolerance, approximants)


def _at_zero(rates: list[_Rate], ratio: float) -> float:
    """Return the polynomial through growth over p / q - phi, at 0, by Neville's scheme; NaN of none."""
    if not rates:
        return math.nan
    values = [each.value for each in rates]
    x = [float(each.fraction - Fraction(ratio)) for each in rates]
    for step in range(1, len(x)):
        for i in range(len(x) - step):
            apart = x[i + step] - x[i]
            values[i] = (x[i + step] * values[i] - x[i] * values[i + 1]) / apart if apart else values[i + 1]
    return values[0]


def _fractions(ratio: float, most: int) -> Iterator[Fraction]:
    """Yield convergents of a ratio, and of those between two the last ones, with growing denominators up to ``most``.

    The fractions (p_(k-1) + j p_k) / (q_(k-1) + j q_k) between two convergents are taken where these lie far apart.
    """
    p, q, p_before, q_before = 1, 0, 0, 1
    rest = Fraction(ratio)
    last = 0
    while True:
        whole = math.floor(rest)
        for j in sorted({max(1, whole // 2), max(1, whole - 1), whole} if whole > 1 else {whole}):
            numerator, denominator = p_before + j * p, q_before + j * q
            if denominator > most:
                break
            if numerator > 0 and denominator > last:
                last = denominator
                yield Fraction(numerator, denominator)
        if q_before + whole * q > most:
            # The largest denominator that is left: two frequencies nearly commensurate beat slowly.
            j = (most - q_before) // q if q else 0
            if j > 0 and q_before + j * q > last and p_before + j * p > 0:
                yield Fraction(p_before + j * p, q_before + j * q)
            return
        p, q, p_before, q_before = p_before + whole * p, q_before + whole * q, p, q
        if rest == whole:
            return
        rest = 1 / (rest - whole)


def _series(problem: Any) -> Any:
    """Return cosines and sines (2, H, n, n) of a problem of one Fourier series."""
    if not problem.is_smooth:
        raise ValueError(
            "equation must be one Fourier series beside a second frequency, and this one has several pieces"
        )
    if isinstance(problem, Equation):
        harmonics = np.array(problem.pieces()[0].harmonics, dtype=complex).reshape(-1, 1, 1)
        return np.stack([harmonics.real, -harmonics.imag])
    return _side_by_side(list(problem.cosines), list(problem.sines), problem.order)


def _second(problem: Any, cosines: Any, sines: Any) -> Any:
    """Return cosines and sines (2, H, n, n) of the second frequency."""
    order = 1 if isinstance(problem, Equation) else problem.order
    parts: list[list[Any]] = []
    for name, given in (("cosines", cosines), ("sines", sines)):
        listed = validate.listed(name, validate.sequence(name, given), matrices.MOST_HARMONICS, "harmonics")
        parts.append([_matrix(f"{name}[{k}]", value, order) for k, value in enumerate(listed)])
    series = _side_by_side(parts[0], parts[1], order)
    if not series.any():
        raise ValueError("cosines or sines of the second frequency must be given, got none; without, use stability")
    return series


def _side_by_side(cosines: list[Any], sines: list[Any], order: int) -> Any:
    """Return two lists of matrices, the shorter one filled up with zeros, (2, H, n, n)."""
    series = np.zeros((2, max(len(cosines), len(sines)), order, order), dtype=np.result_type(0.0, *cosines, *sines))
    for row, values in zip(series, (cosines, sines), strict=True):
        for k, value in enumerate(values):
            row[k] = value
    return series


def _matrix(name: str, value: Any, order: int) -> Floats:
    """Return a matrix of the order of a problem, or the number of a scalar equation."""
    array = validate.array(name, value)
    if array.shape not in ((order, order), *(((),) if order == 1 else ())):
        raise ValueError(f"{name} must be {order} x {order}, got shape {array.shape}")
    return np.asarray(array, dtype=float).reshape(order, order)


def _approximant(problem: Any, own: Any, second: Any, fraction: Fraction) -> Any:
    """Return the problem with a fraction p / q in place of the ratio of the frequencies, of q periods."""
    p, q, period = fraction.numerator, fraction.denominator, fraction.denominator * float(problem.period)
    count = max(p * second.shape[1], q * own.shape[1], 1)
    series = np.zeros((2, count, *second.shape[2:]), dtype=np.result_type(own, second))
    series[:, q - 1 : q * own.shape[1] : q] += own
    series[:, p - 1 : p * second.shape[1] : p] += second
    cosines, sines = list(series[0]), list(series[1])
    if isinstance(problem, Equation):
        even, odd = (tuple(float(matrix[0, 0]) for matrix in each) for each in (cosines, sines))
        return Hill(float(problem.pieces()[0].start), even, odd, period, problem.damping)
    if isinstance(problem, PeriodicSystem):
        return PeriodicSystem(problem.mean, cosines, sines, period=period)
    others = {"mass": problem.mass, "damping": problem.damping, "gyroscopic": problem.gyroscopic}
    return HillSystem(problem.stiffness, cosines, sines, **others, period=period)
