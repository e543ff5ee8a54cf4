"""The contact of a string with its wall and the slope of its y, of floats and of arrays; see `floquetrod.wells.drag`.

With the force F = S tan(y); contact forces are times cos^2 y, which is finite where the force is not.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util.compilation import kernel

LOCKED = 0.5 * math.pi
"""The y at which the force becomes infinite."""

MOST_PRESSED = 1e3  # times its weight: more does not damp the wave of a string that locks up (a choice)


class SlidingString(NamedTuple):
    """A string that slides along a well."""

    weight: float  # in fluid in N/m
    scale: float  # S of F = S tan(y) in N, the critical force in a level hole
    sign: float  # of friction upwards: 1 pushed, 0 standing, -1 pulled
    helical: float  # F^2 R / (4 E I) over the contact force of the lying string, above which it is a helix
    wound: float  # contact force S^2 R / (4 E I) of a helix under S, in N/m: the weight where S is the critical force


@kernel
def lying(sliding: SlidingString, level: Any, kappa_n: Any, kappa_b: Any, sine: Any, cosine: Any) -> Any:
    """Return the contact force of a string that lies; ``level`` is the sine of the inclination, the others of y."""
    push = sliding.scale * sine
    bent = sliding.weight * level * cosine + push * kappa_n
    return np.abs(cosine) * np.hypot(bent, push * kappa_b)


@kernel
def helix_excess(sliding: SlidingString, lying: Any, sine: Any) -> Any:
    """Return sin y - sqrt(h lying / wound), 0 or more where a string is a helix, steep at 0 in vertical wells too."""
    return sine - np.sqrt(sliding.helical * lying / sliding.wound)


@kernel
def helix_margin(sliding: SlidingString, lying: Any, sine: Any) -> Any:
    """Return W = sin|sin|^3 - (h lying / wound)^2, which has the sign of `helix_excess`.

    It is smooth where the string passes from one side of the wall to the other, where `lying` has a corner at 0 and
    `helix_excess` a cusp: its largest value between places is found by sections.
    """
    bound = sliding.helical * lying / sliding.wound
    return sine * np.abs(sine) ** 3 - bound * bound


@kernel
def contact(sliding: SlidingString, lying: Any, sine: Any, helix: Any) -> Any:
    """Return the contact force of a string, ``helix`` the share of it that is wound into a helix."""
    return lying + sliding.wound * helix * sine * sine


@kernel
def slope(sliding: SlidingString, down: Any, mu: Any, cosine: Any, contact: Any) -> Any:
    """Return d/ds of y downwards; ``down`` is the cosine of the inclination."""
    return (sliding.weight * down * cosine * cosine - sliding.sign * mu * contact) / sliding.scale
