"""The closed form of the square wave: exact for Meissner's equation, an approximation to Mathieu's."""

from __future__ import annotations

import math

from floquetrod._util.arrays import EPS
from floquetrod.equations import Mathieu, MathieuAQ, Meissner, in_tau
from floquetrod.floquet import registry
from floquetrod.floquet.kernels.square_wave_excess import square_wave_excess
from floquetrod.floquet.verdict import Cost, Stability, classify


def square_wave(equation: Meissner | Mathieu | MathieuAQ) -> Stability:
    """Classify by the closed form for a coefficient that takes two values.

    With r_1^2 = beta + alpha, r_2^2 = beta - alpha, C = cosh(h r), S = sinh(h r) / r and h = pi / 2, the solutions
    half a period after an instant of symmetry are

        y1 = C1 C2 + r_1^2 S1 S2,            y2 = S1 C2 + C1 S2,
        y1' = r_1^2 S1 C2 + r_2^2 C1 S2,     y2' = C1 C2 + r_2^2 S1 S2,

    trace - 2 = 4 y1' y2 and trace + 2 = 4 y1 y2'.  All are entire in alpha and beta, so the form holds for all real
    values; for alpha > abs(beta) the trace is Eq. (A4) of DOI 10.1115/1.4031710.

    Parameters
    ----------
    equation : Meissner or Mathieu
        For Mathieu the sine is replaced by a square wave of its amplitude, and ``note`` says so.  Damping by the exact
        substitution beta -> beta + c^2.

    Returns
    -------
    Stability
        ``error`` is a first-order bound on rounding; for Mathieu it does not include the replacement.

    Raises
    ------
    TypeError
        For another equation.

    Examples
    --------
    >>> square_wave(Meissner(alpha=0.0, beta=-0.16)).status
    'stable'
    """
    registry.require(equation, "square_wave")
    same: Meissner | Mathieu = in_tau(equation)
    c2 = same.damping**2
    high, low = math.fsum((same.beta, same.alpha, c2)), math.fsum((same.beta, -same.alpha, c2))
    sign, excess, exponent, error = square_wave_excess(high, low, EPS * c2)
    approximate = isinstance(same, Mathieu)
    return classify(
        equation,
        "square_wave",
        sign=sign,
        excess=excess,
        exponent=exponent,
        excess_error=error,
        cost=Cost(1, "evaluation"),
        note="approximation: a square wave in place of the sine" if approximate else "",
    )
