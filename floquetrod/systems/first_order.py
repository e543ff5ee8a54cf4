"""Where parametric resonances lie and how wide they are, to first order in the forcing: an estimate, not a verdict.

In modal coordinates a harmonic of the stiffness couples modes i and j,

x_i'' + 2 c_i x_i' + w_i^2 x_i + sum_j Re(Z_ij exp(i k w t)) x_j = 0.

Averaging near k w = w_i + w_j (or w_i - w_j) leaves (s + c_i + i D / 2) (s + c_j - i D / 2) = g^2 for the exponent s of
the amplitudes, with D = k w - (w_i + w_j) and g^2 = Z_ij conj(Z_ji) / (16 w_i w_j), of the opposite sign for w_i - w_j.
The page on systems derives it.
Hsu, On the parametric excitation of a dynamic system having multiple degrees of freedom, J. Appl. Mech. 30 (1963) 367.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import EPS, Complexes, Floats, shaped
from floquetrod.equations import HillSystem, matrices

_NOTHING = 1e-12  # part of a harmonic's largest entry: a weaker coupling of two modes is rounding


@dataclass(frozen=True, repr=False)
class FirstOrderTongue:
    """One tongue of instability to first order in the forcing: an approximation, never a verdict.

    Attributes
    ----------
    kind : {"direct", "sum", "difference"}
        k w near 2 w_i, w_i + w_j or w_i - w_j.
    modes : tuple of int
        Modes of the mean system, counted from 1 in the order of their frequencies.
    order : int
        k, the harmonic of the stiffness that causes it.
    frequency : float
        Forcing frequency w = 2 pi / period at its centre, in radians per unit of time.
    coupling : float
        g, the growth rate at the centre if there were no damping.
    damping : tuple of float
        c_i and c_j, decay rates of the two modes alone; of a direct resonance twice the same.
    overlaps : bool
        Whether another tongue that shares a mode begins within this one, undamped: the two then interact, and neither
        is as described here.
    """

    kind: Literal["direct", "sum", "difference"]
    modes: tuple[int, ...]
    order: int
    frequency: float
    coupling: float
    damping: tuple[float, float]
    overlaps: bool

    @property
    def half_width(self) -> float:
        """Distance in w from the centre to either boundary; 0 where damping suppresses the resonance.

        Infinite where one of the two modes is damped and the other is not: growth then has no end in w, to this order.
        """
        ci, cj = self.damping
        if ci == cj == 0.0:
            return 2.0 * self.coupling / self.order
        if min(ci, cj) == 0.0:
            return math.inf
        mean = math.sqrt(ci) * math.sqrt(cj)
        beyond = max(0.0, (self.coupling - mean) * (self.coupling + mean))
        return (ci / mean + cj / mean) * math.sqrt(beyond) / self.order

    @property
    def growth_rate(self) -> float:
        """Growth rate at the centre, per unit of time; negative where damping suppresses the resonance."""
        return float(self.growth_rate_at(self.frequency))

    def growth_rate_at(self, frequency: Any) -> Any:
        """Return the growth rate of the faster of the two solutions, per unit of time.

        Parameters
        ----------
        frequency : array_like
            Forcing frequency w, in radians per unit of time.  Far from the centre the answer is not meaningful: the two
            modes are then independent, with their own decay rates.

        Returns
        -------
        float or ndarray
            Of the shape of ``frequency``; negative where both solutions decay.

        Raises
        ------
        TypeError, ValueError
            For frequencies other than finite numbers.
        """
        w = validate.array("frequency", frequency)
        ci, cj = self.damping
        detuning = self.order * (w - self.frequency)
        difference = 0.5 * (ci - cj + 1j * detuning)
        growth = np.sqrt(difference * difference + self.coupling**2).real - 0.5 * (ci + cj)
        return shaped(growth, w.shape)

    def __repr__(self) -> str:
        """Return the estimate as a sentence."""
        several = f"modes {self.modes[0]} and {self.modes[-1]}" if len(self.modes) > 1 else f"mode {self.modes[0]}"
        text = f"{self.kind} resonance of {several}, order {self.order}: w = {self.frequency:.6g} +- "
        text += f"{self.half_width:.3g}, growth {self.growth_rate:.3g} per unit time at the centre"
        text += ", so the damping removes it" if self.growth_rate < 0.0 else ""
        text += "; overlaps another" if self.overlaps else ""
        return f"<first-order approximation, never a verdict: {text}>"


def first_order_tongues(system: HillSystem) -> tuple[FirstOrderTongue, ...]:
    """Return the direct and combination resonances of a system to first order, the fastest growing first.

    They are tongues in the forcing frequency: the matrices stay as they are, and the system's own period does not
    enter.  Where the forcing depends on the frequency, as w^2 of a shaken support, a tongue holds for matrices at its
    own ``frequency``: give them there.  Each harmonic of the stiffness is taken alone, and so is each pair of modes.
    The error of a boundary is of second order in the forcing, and tongues of higher order are not seen at all: for a
    verdict ask `stability`.

    Parameters
    ----------
    system : HillSystem
        One system, its mean stiffness symmetric and positive definite, without gyroscopic terms.  Its harmonics are
        symmetric, or even about an instant.  Of the damping only the diagonal in modal coordinates counts, the decay
        rate of each mode.

    Returns
    -------
    tuple of FirstOrderTongue
        Tongues that would grow without damping, damped ones included: ``half_width`` is 0 where damping suppresses one.

    Raises
    ------
    TypeError, ValueError
        For anything but one HillSystem as described, and for modes whose decay rate is negative.

    Notes
    -----
    A difference resonance needs couplings of opposite sign, d_ij d_ji < 0, and a sum resonance of the same sign.  A
    symmetric stiffness therefore has no difference resonance.  A difference resonance broader than its frequency is
    left out: averaging does not apply to it.  Unequal damping widens a tongue: it ends at D^2 = (c_i + c_j)^2 (g^2 /
    (c_i c_j) - 1) in D = k w - (w_i + w_j), beyond 2 g where c_i and c_j differ enough.

    Examples
    --------
    >>> system = HillSystem([[1.0, 0.0], [0.0, 4.0]], cosines=[[[0.1, 0.2], [0.2, 0.16]]])
    >>> for tongue in first_order_tongues(system):
    ...     print(tongue.kind, tongue.modes, f"{tongue.frequency:.3f} +- {tongue.half_width:.3f}")
    sum (1, 2) 3.000 +- 0.071
    direct (1,) 2.000 +- 0.050
    direct (2,) 4.000 +- 0.040
    """
    _require_modes(system)
    frequencies, rates, harmonics = _modal(system)
    tongues = []
    for order, coupling in enumerate(harmonics, start=1):
        products = coupling * coupling.conj().T / (16.0 * np.outer(frequencies, frequencies))
        coupled = np.abs(coupling) > _NOTHING * np.abs(coupling).max(initial=0.0)
        for i, j in np.argwhere(np.triu(coupled & coupled.T)).tolist():
            product = complex(products[i, j])
            if abs(product.imag) > 1e-9 * abs(product):
                raise ValueError(
                    "system must have harmonics that are symmetric, or even about an instant, got one in which modes "
                    f"{i + 1} and {j + 1} act on each other with different phases; use stability(system)"
                )
            tongues += _tongue(i, j, order, frequencies, rates, product.real)
    tongues.sort(key=lambda tongue: (-tongue.growth_rate, tongue.frequency))
    meeting = _meeting(tongues)
    return tuple(replace(tongue, overlaps=number in meeting) for number, tongue in enumerate(tongues))


def _require_modes(system: Any) -> None:
    """Raise unless the mean system oscillates in real modes."""
    if not isinstance(system, HillSystem):
        raise TypeError(f"system must be a HillSystem, got {validate.short(system)}")
    matrices.require_one(system)
    if system.gyroscopic is not None:
        raise ValueError("system must have no gyroscopic terms: its modes would not be real; use stability(system)")
    if not matrices.symmetric(system.stiffness):
        raise ValueError("system must have a symmetric mean stiffness: its modes are used; use stability(system)")


def _modal(system: HillSystem) -> tuple[Floats, Floats, Complexes]:
    """Return natural frequencies in increasing order, decay rates, and harmonics (H, n, n) in modal coordinates."""
    inverse = np.linalg.inv(np.linalg.cholesky(matrices.mass_matrix(system)))
    squares, shapes = np.linalg.eigh(inverse @ system.stiffness @ inverse.T)
    modes = inverse.T @ shapes
    if squares[0] <= 8.0 * EPS * system.order * squares[-1]:
        raise ValueError(
            "system must have a positive definite mean stiffness, got one with the eigenvalue "
            f"{squares[0]:.3g}, relative to the mass: a mode without a frequency has no resonance of this kind"
        )
    rates = np.zeros(system.order)
    if system.damping is not None:
        rates = 0.5 * np.diagonal(modes.T @ system.damping @ modes)
        slack = 8.0 * EPS * system.order * float(np.abs(rates).max())
        if rates.min() < -slack:
            mode = int(rates.argmin())
            raise ValueError(
                f"system must have no negative damping, got the decay rate {rates[mode]:.3g} of mode {mode + 1}"
            )
        rates = np.where(rates > slack, rates, 0.0)
    return np.sqrt(squares), rates, modes.T @ system.harmonics @ modes


def _tongue(i: int, j: int, order: int, frequencies: Floats, rates: Floats, product: float) -> list[FirstOrderTongue]:
    """Return the tongue of modes i <= j, g^2 = ``product`` for the sum of their frequencies; none where none grows."""
    damping = (float(rates[i]), float(rates[j]))
    low, high = float(frequencies[i]), float(frequencies[j])
    if i == j:
        return [FirstOrderTongue("direct", (i + 1,), order, 2.0 * low / order, math.sqrt(product), damping, False)]
    modes, coupling = (i + 1, j + 1), math.sqrt(abs(product))
    if product > 0.0:
        return [FirstOrderTongue("sum", modes, order, (low + high) / order, coupling, damping, False)]
    if high - low <= 2.0 * coupling:
        return []
    return [FirstOrderTongue("difference", modes, order, (high - low) / order, coupling, damping, False)]


def _meeting(tongues: list[FirstOrderTongue]) -> set[int]:
    """Return the numbers of the tongues that meet another with a common mode, all without damping."""
    of_mode: dict[int, list[tuple[float, float, int]]] = {}
    for number, tongue in enumerate(tongues):
        reach = 2.0 * tongue.coupling / tongue.order
        for mode in tongue.modes:
            of_mode.setdefault(mode, []).append((tongue.frequency - reach, tongue.frequency + reach, number))
    result: set[int] = set()
    for spans in of_mode.values():
        spans.sort()
        _, furthest, last = spans[0]
        for low, high, number in spans[1:]:
            if low <= furthest:
                result |= {last, number}
            if high > furthest:
                furthest, last = high, number
    return result
