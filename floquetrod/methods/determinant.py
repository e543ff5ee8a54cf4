"""Hill's four determinants, truncated as in the paper or taken as far as needed."""

from __future__ import annotations

import cmath
import math

from floquetrod import _validate, equations
from floquetrod.equations import Mathieu
from floquetrod.result import Cost, Interval, Stability, Status, judge

_EPS = 2.220446049250313e-16
_MOST_TERMS = 20000  # a choice: about 30 ms


def determinant(equation: Mathieu, *, terms: int | None = None) -> Stability:
    """Judge by the signs of Hill's four determinants, Eqs. (A1)-(A3) of DOI 10.1115/1.4031710.

    A boundary solution is a series in cos(k tau / 2), sin(k tau / 2), even or odd in k, symmetric or antisymmetric
    about the instant of symmetry: four homogeneous systems, four determinants.  Scaled by the determinants they have
    at alpha = 0 = beta they tend to the half-period values of the cosine- and sine-like solutions, so that their
    products decide: stable where det(even) det(odd) < 0 < det(1 + q) det(1 - q).

    Parameters
    ----------
    equation : Mathieu
        Damping is treated by the exact substitution beta -> beta + c^2.
    terms : int, optional
        Rows of the truncated determinants; the one with a constant term has one more (40 is the paper's 40 x 40 and
        41 x 41).  By default as many as the discriminant needs to about 1e-12.

    Returns
    -------
    Stability
        ``error`` is an estimate from the first terms left out.  "undecided" where the truncation cuts rows off that
        could still change a sign.

    Examples
    --------
    >>> determinant(Mathieu(alpha=0.5, beta=-0.25), terms=40).status
    'unstable'
    """
    equations.require(equation, (Mathieu,), by="Hill's four determinants")
    rows = _enough(equation) if terms is None else _validate.integer("terms", terms, 2)
    q = 2.0 * abs(equation.alpha)
    a = -4.0 * (equation.beta + equation.damping**2)
    even = _Chain(a, q, 0, rows + 1)
    odd = _Chain(a, q, 2, rows)
    plus = _Chain(a, q, 1, rows, q)
    minus = _Chain(a, q, 1, rows, -q)
    chains = (even, odd, plus, minus)
    below = sum(chain.negative for chain in chains)
    settled = all(chain.settled for chain in chains)
    size = even.value * odd.value * 0.25 * math.pi**2
    exponent = even.exponent + odd.exponent
    sign = 1
    if size < 0.0 and math.ldexp(size, min(exponent, 60)) < -0.5:
        sign, size, exponent = -1, -plus.value * minus.value, plus.exponent + minus.exponent
    scale = min(1.0, abs(math.ldexp(size, min(exponent, 60))))
    rounding = 16.0 * _EPS * (rows + (abs(a) + 2.0 * q) * max(chain.sensitivity for chain in chains))
    error = (sum(chain.left_out for chain in chains) + rounding) * max(scale, 1e-300)
    status: Status = "undecided" if not settled or abs(size) == 0.0 else "stable" if below % 2 else "unstable"
    # The signs are known to rounding only: where a determinant is within its rounding of zero they say nothing.
    if rounding > 0.5:
        status = "undecided"
    return judge(
        equation,
        "determinant",
        sign=sign,
        excess=size,
        exponent=exponent,
        excess_error=error,
        interval=Interval.from_count(below) if status != "undecided" else None,
        undamped_status=status,
        cost=Cost(4 * rows + 1, "rows"),
        note=f"{rows} terms are too few here; raise terms, or leave them to be chosen" if not settled else "",
    )


def _enough(equation: Mathieu) -> int:
    """Return the number of terms from which the first correction left out is below about 1e-13."""
    h2 = abs(equation.beta + equation.damping**2)
    big_q = 0.25 * equation.alpha**2
    needed = (big_q * (1.0 + 2.0 * h2 + big_q) * 1e13) ** 0.2
    turning = math.sqrt(h2 + abs(equation.alpha))
    return int(min(_MOST_TERMS, max(40.0, needed, 3.0 * turning + 20.0)))


class _Chain:
    """One determinant: its scaled value (value * 2**exponent), count of negative minors' ratios, and its errors."""

    def __init__(self, a: float, q: float, first: int, rows: int, shift: float = 0.0) -> None:
        """Expand the tridiagonal determinant of ``rows`` rows with diagonal first^2 - a + shift, (first + 2)^2 - a, ...

        Minors obey M_k = (D_k - a) M_(k-1) - q^2 M_(k-2); each is scaled by D_k (1 for D = 0) as it is made.
        """
        before, here = 1.0, first * first - a + shift
        slope_before, slope = 0.0, -1.0
        self.negative = int(here < 0.0)
        self.exponent = 0
        coupling = 2.0 * q * q if first == 0 else q * q
        k = first
        if k:
            here, slope = here / (k * k), slope / (k * k)
        scale = float(k * k or 1)
        for _ in range(rows - 1):
            k += 2
            d = float(k * k)
            here, before = ((d - a) * here - coupling / scale * before) / d, here
            slope, slope_before = (
                ((d - a) * slope - before - coupling / scale * slope_before) / d,
                slope,
            )
            self.negative += (here < 0.0) != (before < 0.0)
            coupling, scale = q * q, d
            if not 1e-100 < abs(here) + abs(before) < 1e100:
                power = math.frexp(abs(here) + abs(before))[1]
                here, before = math.ldexp(here, -power), math.ldexp(before, -power)
                slope, slope_before = math.ldexp(slope, -power), math.ldexp(slope_before, -power)
                self.exponent += power
        ratio = here * k * k / before if before else math.inf
        self.settled = ratio > q and (k + 2) ** 2 - a >= 2.0 * q
        self.sensitivity = abs(slope / here) if here else math.inf
        # What the rows left out would have done: exactly for the diagonal, to first order for the coupling.
        kappa, h2, big_q = 0.5 * k, 0.25 * a, q * q / 16.0
        log_rest = _log_rest(kappa, h2)
        cubic = big_q / (3.0 * (kappa + 1.0) ** 3)
        edge = big_q / ((kappa + 1.0) ** 2) * 4.0 / ratio if ratio else math.inf
        edge_scale = 1.0 / (1.0 - h2 / (kappa + 1.0) ** 2) if self.settled else 1.0
        factor = math.exp(-cubic) * (1.0 - edge * edge_scale) if self.settled else 1.0
        power = int(log_rest / math.log(2.0))
        value, shift_power = math.frexp(here * factor * math.exp(log_rest - power * math.log(2.0)))
        self.value = value
        self.exponent += power + shift_power
        fifth = (1.0 + 2.0 * abs(h2) + big_q) / (kappa + 1.0) ** 5
        self.left_out = big_q * fifth if self.settled else math.inf


def _log_rest(kappa: float, h2: float) -> float:
    """Return the logarithm of the product of 1 - h^2 / k^2 over k = kappa + 1, kappa + 2, ... (needs h < kappa + 1)."""
    if h2 >= (kappa + 1.0) ** 2:
        return 0.0
    if kappa >= 10.0 and abs(h2) < 0.25 * kappa * kappa:
        # Term by term, without the cancellation between logarithms of Gamma functions.
        total, power, j = 0.0, h2, 1
        while abs(power) * _zeta(2.0 * j, kappa + 1.0) > 1e-18 and j < 60:
            total -= power / j * _zeta(2.0 * j, kappa + 1.0)
            power, j = power * h2, j + 1
        return total
    if h2 >= 0.0:
        h = math.sqrt(h2)
        return 2.0 * math.lgamma(kappa + 1.0) - math.lgamma(kappa + 1.0 - h) - math.lgamma(kappa + 1.0 + h)
    h = math.sqrt(-h2)
    return 2.0 * (math.lgamma(kappa + 1.0) - _log_gamma(complex(kappa + 1.0, h)).real)


def _zeta(s: float, x: float) -> float:
    """Return the sum of k^-s over k = x, x + 1, ... by the Euler-Maclaurin series (DLMF 25.11.43), x >= 10."""
    i2 = 1.0 / (x * x)
    series = 1.0 / (s - 1.0) + 0.5 / x + s * i2 / 12.0
    last = s * (s + 1.0) * (s + 2.0) * i2 * i2
    series += -last / 720.0 + last * (s + 3.0) * (s + 4.0) * i2 / 30240.0
    return float(series * x ** (1.0 - s))


def _log_gamma(z: complex) -> complex:
    """Return log Gamma(z) by Stirling's series (DLMF 5.11.1) after moving z to the right; Re z > 0."""
    moved = 0j
    while abs(z) < 20.0:
        moved += cmath.log(z)
        z += 1.0
    series = 1.0 / (12.0 * z) - 1.0 / (360.0 * z**3) + 1.0 / (1260.0 * z**5) - 1.0 / (1680.0 * z**7)
    return (z - 0.5) * cmath.log(z) - z + 0.5 * math.log(2.0 * math.pi) + series - moved
