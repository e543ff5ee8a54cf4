"""The renewal equation of the products of noise: growth of second moments of systems with delays.

Its kernel is the square of the responses without noise, as in U. Kuechler and B. Mensch, Stochastics and Stochastics
Reports 40 (1992) 23, for constant coefficients and noise that is added.
"""

from __future__ import annotations

import math

import numpy as np

from floquetrod.equations import DelayedMoments
from floquetrod.floquet.multipliers import renewal_equation
from floquetrod.floquet.multipliers.classification import LogDiscs, classify_multipliers
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.verdict import Cost

_NOTE = "one exponent, the growth rate of all second moments"
_LARGEST_ERROR = 0.1  # of the logarithm of the growth over a period, above which it is not known (a choice)
_BOUND = 1.0  # added to a growth that is known as an upper bound alone (a choice)


def renewal(moments: DelayedMoments) -> SystemStability:
    """Classify second moments by the growth at which the operator of their renewal equation has the spectral radius 1.

    The products y of a source s (G x(t) + sum_k H_k x(t - tau_k)) xi have second moments v that obey v(t) = v_0(t) +
    int g(t, u)^2 v(u) du, g the response of y to a kick through the noise.  With exp(-sigma (t - u)) the operator acts
    on functions of the period of the coefficients; they are interpolated between the instants of kicks, whose
    responses come from collocation.  Of several sources, and of one whose matrix has a rank above 1, v is a matrix.

    Parameters
    ----------
    moments : DelayedMoments
        Of a system of at most 600 rows of collocation, less with coefficients that vary, as every instant of a kick
        takes so many: delays up to about three periods with one equation of second order.  Else undecided.

    Returns
    -------
    SystemStability
        One exponent, real.  Its error is an estimate: twice the change to fewer nodes and instants, twice that by
        coefficients off by their error, and rounding.

    Examples
    --------
    x' = b x(t - 1) + s x xi is stable in mean square for s^2 < -2 b cos b / (1 - sin b) while -pi / 2 < b < 0:

    >>> import floquetrod as fr
    >>> system = fr.DelaySystem.first_order([[0.0]], delayed=[(1.0, [[-1.0]])])
    >>> [fr.stability(system, noise=[([[1.0]], s)]).status for s in (0.76, 0.77)]
    ['stable', 'unstable']
    """
    found = renewal_equation.refined(moments, renewal_equation.RenewalEquation.growth)
    if found is None:
        return SystemStability.declined(moments, "renewal", Cost(0, "rows"), "needs collocation of too many rows")
    equation, ratio = found.equation, float(moments.period) / found.equation.period
    error = found.error + equation.uncertainty(found.value)
    cost = Cost(equation.rows, "rows")
    high = np.array([ratio * (found.value + min(error, found.error + _BOUND))])
    known = error < _LARGEST_ERROR
    if not known and not high[0] < 0.0:
        return SystemStability.declined(moments, "renewal", cost, "growth over a period is not resolved")
    value, radius = np.array([complex(ratio * found.value)]), np.array([ratio * error if known else math.inf])
    logs = LogDiscs(value, value.real - radius, high, radius, (np.arange(1),))
    return classify_multipliers(moments, "renewal", logs, cost=cost, note=_NOTE)
