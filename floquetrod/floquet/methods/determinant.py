"""Hill's four determinants, truncated as in the paper or taken as far as needed."""

from __future__ import annotations

import math

from floquetrod._util import validate
from floquetrod._util.arrays import EPS
from floquetrod.equations import Mathieu, MathieuAQ, in_tau
from floquetrod.floquet import registry
from floquetrod.floquet.mathieu_chains.truncated_determinant import ChainDeterminant
from floquetrod.floquet.status import status_of_count
from floquetrod.floquet.verdict import Cost, Interval, Stability, classify

_MOST_TERMS = 20000  # a choice: about 30 ms


def determinant(equation: Mathieu | MathieuAQ, *, terms: int | None = None) -> Stability:
    """Classify by the signs of Hill's four determinants, Eqs. (A1)-(A3) of DOI 10.1115/1.4031710.

    A boundary solution is a series in cos(k tau / 2), sin(k tau / 2), even or odd in k, symmetric or antisymmetric
    about the instant of symmetry: four homogeneous systems, four determinants.  Scaled by the determinants they have
    at alpha = 0 = beta they tend to the half-period values of the cosine- and sine-like solutions, so that their
    products decide: stable where det(even) det(odd) < 0 < det(1 + q) det(1 - q).

    Parameters
    ----------
    equation : Mathieu or MathieuAQ
        Damping is treated by the exact substitution beta -> beta + c^2.
    terms : int, optional
        Rows of the truncated determinants; the one with a constant term has one more (40 is the paper's 40 x 40 and
        41 x 41).  By default as many as the discriminant needs to about 1e-12.

    Returns
    -------
    Stability
        ``error`` is an estimate from the first terms left out.  "undecided" where the truncation cuts rows off that
        could still change a sign.

    Raises
    ------
    TypeError, ValueError
        For another equation, and for ``terms`` other than a whole number from 2.

    Examples
    --------
    >>> determinant(Mathieu(alpha=0.5, beta=-0.25), terms=40).status
    'unstable'
    """
    registry.require(equation, "determinant")
    same: Mathieu = in_tau(equation)
    rows = _enough(same) if terms is None else validate.integer("terms", terms, 2, _MOST_TERMS)
    q = 2.0 * abs(same.alpha)
    a = -4.0 * (same.beta + same.damping**2)
    even = ChainDeterminant(a, q, 0, rows + 1)
    odd = ChainDeterminant(a, q, 2, rows)
    plus = ChainDeterminant(a, q, 1, rows, q)
    minus = ChainDeterminant(a, q, 1, rows, -q)
    chains = (even, odd, plus, minus)
    below = sum(chain.negative for chain in chains)
    settled = all(chain.settled for chain in chains)
    size = even.value * odd.value * 0.25 * math.pi**2
    exponent = even.exponent + odd.exponent
    sign = 1
    if size < 0.0 and math.ldexp(size, min(exponent, 60)) < -0.5:
        sign, size, exponent = -1, -plus.value * minus.value, plus.exponent + minus.exponent
    scale = min(1.0, abs(math.ldexp(size, min(exponent, 60))))
    rounding = 16.0 * EPS * (rows + (abs(a) + 2.0 * q + 1e-300) * max(chain.sensitivity for chain in chains))
    error = (sum(chain.left_out for chain in chains) + rounding) * max(scale, 1e-300)
    # The signs are known to rounding only: where a determinant is within its rounding of zero they say nothing.
    is_known = settled and abs(size) != 0.0 and not rounding > 0.5
    status = status_of_count(below if is_known else None)
    return classify(
        equation,
        "determinant",
        sign=sign,
        excess=size,
        exponent=exponent,
        excess_error=error,
        interval=Interval.from_count(below) if status != "undecided" else None,
        undamped_status=status,
        cost=Cost(4 * rows + 1, "rows"),
        note=""
        if settled
        else f"{rows} terms are too few, or this is a boundary; raise terms, or leave them to be chosen",
    )


def _enough(equation: Mathieu) -> int:
    """Return the number of rows beyond which the coupling of the rows left out is known to about 1e-13."""
    h2 = abs(equation.beta + equation.damping**2)
    big_q = 0.25 * equation.alpha**2
    needed = (big_q * (1.6 * (1.0 + h2) ** 2 + big_q) * 1e13) ** (1.0 / 7.0)
    turning = math.sqrt(h2 + abs(equation.alpha))
    return int(min(_MOST_TERMS, max(40.0, needed, 3.0 * turning + 20.0)))
