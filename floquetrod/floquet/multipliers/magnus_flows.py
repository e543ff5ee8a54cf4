"""Flows of x' = A(t) x over short steps, by Magnus's expansion to fourth order.

A. Iserles and S. P. Norsett, Phil. Trans. R. Soc. A 357 (1999) 983.
"""

from __future__ import annotations

import math

import numpy as np

from floquetrod._util.arrays import Floats

PLACES = np.array([-1.0, 1.0]) * math.sqrt(3.0) / 6.0
"""Gauss's two points of a step, from its middle, in steps."""


def flows(first: Floats, second: Floats, length: Floats | float) -> Floats:
    """Return the flows (k, n, n) over steps of some length (k, 1, 1), A known at both points of each, (k, n, n)."""
    from scipy.linalg import expm

    turning = second @ first - first @ second
    return np.asarray(expm(0.5 * length * (first + second) + math.sqrt(3.0) / 12.0 * length**2 * turning))
