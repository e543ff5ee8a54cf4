"""Kernels for the modes of a rod: a family of Mathieu equations alpha_m = A (m^2 - h), beta_m = B m^2 - C m^4 - D.

A comes from the forcing, the amplitude of the axial force; B from its mean, a compression where positive; C from
bending; D from gravity, which makes the rod swing in the channel like a pendulum; h = m_0^2 from the curvature of the
channel, with which compression holds the rod down, so that D includes B h.
"""

from __future__ import annotations

import math
from typing import Any

from floquetrod._util.compilation import kernel
from floquetrod.floquet.kernels.mathieu_discriminant import growth, growth_bound, is_stable
from floquetrod.floquet.mathieu_chains.mathieu_counts import shown_by_count
from floquetrod.floquet.status import STABLE


@kernel
def mode_family(
    bending: Any, per_newton: Any, restoring: Any, neutral_squared: Any, mean: Any, amplitude: Any, frequency: Any
) -> tuple[Any, Any, Any, Any, Any]:
    """Return A, B, C, D and h of a rod's modes, Eq. (4) of DOI 10.1115/1.4031710 where h = 0.

    The first four arguments are fields of `floquetrod.rod.model.constants.ModeConstants`; mean and amplitude in N, the
    frequency in rad/s.
    """
    squared = frequency * frequency
    unit = per_newton / squared
    push = unit * mean
    return unit * amplitude, push, bending / squared, restoring / squared + push * neutral_squared, neutral_squared


@kernel
def mode_coefficients(
    forcing: Any, compression: Any, bending: Any, gravity: Any, neutral_squared: Any, mode: Any
) -> tuple[Any, Any]:
    """Return alpha = A (m^2 - h) and beta = B m^2 - C m^4 - D of a mode m, or of an array of them."""
    m2 = 1.0 * mode * mode
    return forcing * (m2 - neutral_squared), (compression - bending * m2) * m2 - gravity


@kernel
def modes_left_out(
    forcing: float, compression: float, bending: float, gravity: float, neutral_squared: float, last: int
) -> float:
    """Return a bound on the growth per unit tau of every mode after ``last``, infinite where none is known.

    In y = m^2 - h the family has h = 0, alpha = A y and beta = (B - 2 C h) y - C y^2 - (D - B h + C h^2); so
    what follows holds with y in place of m^2.

    From m = last + 1 on, and m^4 >= D / C, the ratio a / q grows with m and so does k1, so that the products of
    `growth_bound` only fall; its prefactor is A / 4 over the square root of C - (A + B) / m^2 + D / m^4, which is at
    least what it is with (A + B) and -D replaced by zero where negative.
    """
    m2 = (last + 1.0) * (last + 1.0) - neutral_squared
    if not m2 > 0.0:
        return math.inf
    gravity += (bending * neutral_squared - compression) * neutral_squared
    compression -= 2.0 * bending * neutral_squared
    room = bending - max(forcing + compression, 0.0) / m2 + min(gravity, 0.0) / (m2 * m2)
    if room <= 0.0 or bending * m2 * m2 < gravity:
        return math.inf
    if forcing == 0.0:
        return 0.0
    q = 2.0 * forcing * m2
    a = 4.0 * ((bending * m2 - compression) * m2 + gravity)
    if not a > 2.0 * q:
        return math.inf  # equal to rounding: ``room`` is all but used up
    here = growth_bound(a, q)
    return here / (0.25 * q / math.sqrt(a - 2.0 * q)) * 0.25 * forcing / math.sqrt(room)


@kernel
def modes_needed(
    forcing: float,
    compression: float,
    bending: float,
    gravity: float,
    neutral_squared: float,
    target: float,
    guess: int,
) -> int:
    """Return the least M >= 1 such that every mode after M grows at no more than ``target`` per unit tau.

    A good ``guess``, the answer for a load nearby, makes it quick.
    """
    # The bound B(M) of `modes_left_out` falls with M, so M is where it passes the target: low < M <= high, with B(low)
    # above the target (or low = 0) and B(high) not.  From the guess one end is carried away in steps 1, 2, 4, ...
    # until the other side is met (galloping: J. L. Bentley and A. C. Yao, doi:10.1016/0020-0190(76)90071-5), since
    # loads of an array change little from one to the next; then the interval is halved.
    low, high = 0, guess
    step = 1
    if modes_left_out(forcing, compression, bending, gravity, neutral_squared, guess) > target:
        low, high = guess, guess + 1
        while modes_left_out(forcing, compression, bending, gravity, neutral_squared, high) > target:
            step *= 2
            low, high = high, high + step
    else:
        while (
            high > 1
            and modes_left_out(forcing, compression, bending, gravity, neutral_squared, max(1, high - step)) <= target
        ):
            high = max(1, high - step)
            step *= 2
        low = max(0, high - step)
    while high - low > 1:
        middle = (low + high) // 2
        if modes_left_out(forcing, compression, bending, gravity, neutral_squared, middle) > target:
            low = middle
        else:
            high = middle
    return high


@kernel
def modes_needed_fill(
    forcing: Any, compression: Any, bending: Any, gravity: Any, target: Any, out: Any, neutral_squared: float
) -> None:
    """Fill ``out`` with `modes_needed`."""
    last = 1
    for i in range(len(forcing)):
        last = modes_needed(forcing[i], compression[i], bending[i], gravity[i], neutral_squared, target[i], last)
        out[i] = last


@kernel
def _modes_of_load(
    constants: Any, mean: float, amplitude: float, omega: float, slowest: float, guess: int
) -> tuple[float, float, float, float, float, float, int]:
    """Return A, B, C, D, h and c of a rod under a load, and how many modes show growth of ``slowest`` (1/s)."""
    # c = lambda / omega, the damping rate per unit tau.  Without damping a mode has beta + c^2, that is D - c^2; it
    # grows by c + slowest / omega or less exactly when its net growth per second is at most ``slowest``.
    bending, per_newton, restoring, neutral_squared, damping_rate = constants
    c = damping_rate / omega
    forcing, compression, stiffness, gravity, neutral_squared = mode_family(
        bending, per_newton, restoring, neutral_squared, mean, amplitude, omega
    )
    last = modes_needed(forcing, compression, stiffness, gravity - c * c, neutral_squared, c + slowest / omega, guess)
    return forcing, compression, stiffness, gravity, neutral_squared, c, last


@kernel
def _mode_stable(
    forcing: float,
    compression: float,
    bending: float,
    gravity: float,
    neutral_squared: float,
    mode: int,
    damping: float,
    tolerance: float,
) -> bool:
    """Return whether one mode of a family grows no faster than ``tolerance``."""
    # A'' + 2 c A' = (beta + alpha sin tau) A, c = ``damping``, all per unit tau = omega t.
    alpha, beta = mode_coefficients(forcing, compression, bending, gravity, neutral_squared, mode)
    return is_stable(alpha, beta, damping, tolerance)


@kernel
def rod_is_stable(
    constants: Any,
    mean: float,
    amplitude: float,
    omega: float,
    tolerance: float,
    slowest: float,
    last: int,
    suspect: int,
) -> tuple[bool, int, int]:
    """Return whether no mode of a rod grows faster than ``tolerance`` (1/s), how many were needed and which to suspect.

    ``constants`` are `floquetrod.rod.model.constants.ModeConstants.equation`.  Growth below ``slowest`` (1/s) may be
    left out.  ``last`` and ``suspect`` are the answers for a rod and load nearby: neighbours need about as many modes
    and mostly fail in the same one, which is tested first.
    """
    # Modes 1 to ``last`` decide; later ones grow less than ``slowest`` (`modes_needed`).  The suspect, then the others
    # from the lowest up, until the first that grows: most unstable rods are decided by one mode.
    forcing, compression, bending, gravity, neutral_squared, c, last = _modes_of_load(
        constants, mean, amplitude, omega, slowest, last
    )
    # In tau = omega t: alpha_m = forcing (m^2 - h), beta_m = compression m^2 - bending m^4 - gravity, and damping c.
    level = tolerance / omega
    suspect = min(suspect, last)
    # Each verdict is a count of one tridiagonal matrix, see `_mode_stable`.
    if not _mode_stable(forcing, compression, bending, gravity, neutral_squared, suspect, c, level):
        return False, last, suspect
    for mode in range(1, last + 1):
        if mode != suspect and not _mode_stable(
            forcing, compression, bending, gravity, neutral_squared, mode, c, level
        ):
            return False, last, mode
    return True, last, suspect


@kernel
def modes_stable_fill(
    mean: Any,
    amplitude: Any,
    frequency: Any,
    bending: Any,
    per_newton: Any,
    restoring: Any,
    neutral_squared: Any,
    damping_rate: Any,
    out: Any,
    tolerance: float,
    smallest: float,
) -> None:
    """Fill ``out`` with whether no mode of each rod grows faster than ``tolerance`` under its load (rates per second).

    Rates below ``smallest`` may be left out.
    """
    # Arrays (n,): a rod and a load each, F and dF in N, omega in rad/s, constants as in `ModeConstants.equation`.  The
    # number of modes and the suspect go from one to the next: neighbours in an array are alike, and the answers do not
    # depend on it.
    slowest = max(tolerance, smallest)
    last = 1
    suspect = 1
    for i in range(len(mean)):
        constants = bending[i], per_newton[i], restoring[i], neutral_squared[i], damping_rate[i]
        out[i], last, suspect = rod_is_stable(
            constants, mean[i], amplitude[i], frequency[i], tolerance, slowest, last, suspect
        )


@kernel
def modes_growth_fill(mean: Any, amplitude: Any, frequency: Any, out: Any, constants: Any, smallest: float) -> None:
    """Fill ``out`` (n, 2) with the largest growth rate per second and the mode that has it (0 where none grows)."""
    # The largest of growth(alpha_m, beta_m, c) omega over the modes m that may grow (`_modes_of_load`).  A mode that
    # the count of curves shows bounded without its damping, beta + c^2, cannot grow: the determinants of `growth` are
    # spared.
    last = 1
    for i in range(len(mean)):
        forcing, compression, bending, gravity, neutral_squared, c, last = _modes_of_load(
            constants, mean[i], amplitude[i], frequency[i], smallest, last
        )
        best = 0.0
        first = 0
        for mode in range(1, last + 1):
            alpha, beta = mode_coefficients(forcing, compression, bending, gravity, neutral_squared, mode)
            if shown_by_count(alpha, beta + c * c) != STABLE:
                rate = growth(alpha, beta, c)
                if rate > best:
                    best = rate
                    first = mode
        out[i, 0] = best * frequency[i]
        out[i, 1] = first
