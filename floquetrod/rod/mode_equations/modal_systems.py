"""From a rod and a load to its equations: the modal system of one load, and the modal systems of arrays of loads.

The modes of a rod with hinged ends are independent, each an equation of Mathieu's with coefficients
alpha_m = A (m^2 - h) and beta_m = B m^2 - C m^4 - D, Eq. (4) of DOI 10.1115/1.4031710 in a straight channel, where
h = 0; in one that bends modes of m^2 < h are held by compression, and driven in opposite phase.  Nothing outside this
module and `tongues` depends on that form: what else asks for equations, coefficients or verdicts asks the system.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod import mathieu
from floquetrod._util import validate
from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.caching import cached_property
from floquetrod._util.compilation import INTERPRETED_UP_TO, is_at_hand, over_chunks
from floquetrod.equations import Mathieu
from floquetrod.mathieu.array_functions import flat_stable
from floquetrod.mathieu.paper_criterion import FiniteTimeCriterion
from floquetrod.mathieu.tongue_intervals import damping_to_stabilise
from floquetrod.rod.kernels import independent_modes as kernels
from floquetrod.rod.loads.load import AxialLoad, Load, Loads
from floquetrod.rod.model.constants import NEGLIGIBLE_GROWTH, ModeConstants

_LOADING = 1000.0  # ms of interpreted work after which numba is loaded, about as long as that takes (measured)


@dataclass(frozen=True, repr=False)
class ModalSystem:
    """The equations of a rod's modes under one load, in the time tau = omega t.

    Attributes
    ----------
    constants : ModeConstants
        The constants of the rod in the equations.
    load : AxialLoad
    modes : tuple of int
        Modes examined.
    left_out_bound : float
        Bound in 1/s on the growth of every mode beyond them; infinite without a bound.
    """

    constants: ModeConstants
    load: Load
    modes: tuple[int, ...]
    left_out_bound: float = math.inf

    @property
    def frequency(self) -> float:
        """Omega in rad/s."""
        return self.load.frequency

    @property
    def damping(self) -> float:
        """Decay rate c of free motion per unit tau, the same in every mode."""
        return float(self.constants.damping_rate / self.load.frequency)

    @cached_property
    def coefficients(self) -> tuple[float, float, float, float, float]:
        """A, B, C, D, h of alpha_m = A (m^2 - h), beta_m = B m^2 - C m^4 - D."""
        load = self.load
        return kernels.mode_family(*self.constants[:4], load.mean, load.amplitude, load.frequency)

    @property
    def alpha(self) -> Floats:
        """Amplitude of each mode's coefficient."""
        return np.asarray(kernels.mode_coefficients(*self.coefficients, self._numbers)[0])

    @property
    def beta(self) -> Floats:
        """Mean of each mode's coefficient."""
        return np.asarray(kernels.mode_coefficients(*self.coefficients, self._numbers)[1])

    @property
    def per_newton(self) -> Floats:
        """Increase of each alpha by a newton of amplitude, and of each beta by a newton of mean force."""
        unit, *_ = kernels.mode_family(*self.constants[:4], 0.0, 1.0, self.load.frequency)
        return np.asarray(unit * (self._numbers**2 - self.constants.neutral_squared))

    @property
    def in_seconds(self) -> tuple[Floats, Floats]:
        """Alpha omega^2 and beta omega^2 in 1/s^2, which do not depend on the frequency."""
        family = kernels.mode_family(*self.constants[:4], self.load.mean, self.load.amplitude, 1.0)
        alpha, beta = kernels.mode_coefficients(*family, self._numbers)
        return np.asarray(alpha), np.asarray(beta)

    @cached_property
    def equations(self) -> tuple[Mathieu, ...]:
        """The equation of each mode, damping included; ValueError for one whose coefficients are too large."""
        alpha, beta = self.alpha, self.beta
        for mode, size in zip(self.modes, np.maximum(abs(alpha), abs(beta)), strict=True):
            if size > validate.LARGEST:
                raise validate.wrong_value(
                    "modes",
                    f"must have coefficients up to {validate.LARGEST:g}, got {size:.3g} for mode {mode} at "
                    f"frequency {self.frequency:g} rad/s; leave out modes so high, or check the units",
                )
        return tuple(Mathieu(a, b, self.damping) for a, b in zip(alpha.tolist(), beta.tolist(), strict=True))

    @property
    def damping_to_stabilise(self) -> float:
        """Damping rate c in 1/s above which none of these modes grows, infinite where no rate is enough.

        It is the rod's whole ``damping_rate``, whose present value does not matter.
        """
        return self.frequency * float(damping_to_stabilise(self.alpha, self.beta).max())

    @property
    def cutoff(self) -> str:
        """The modes, and the bound on the growth of all others, in words."""
        if math.isinf(self.left_out_bound):
            return f"the {len(self.modes)} modes requested; others were not checked"
        if self.left_out_bound > 0.0:
            growth = f"every higher mode grows at less than {self.left_out_bound:.1g} per second"
            return f"modes 1 to {self.modes[-1]}: {growth}"
        return f"modes 1 to {self.modes[-1]}: no higher mode can grow"

    def __repr__(self) -> str:
        """Return load and modes."""
        return f"<modal system under {self.load}; {self.cutoff}>"

    @property
    def _numbers(self) -> Floats:
        return np.array(self.modes, dtype=np.float64)


class GrowingModes(NamedTuple):
    """Modes that grow without friction, of many loads: flat arrays of one length.

    Attributes
    ----------
    load : ndarray of int
        Index of the load.
    mode : ndarray of int
    alpha, beta, damping : ndarray
        Of the mode's equation.
    rate : ndarray
        Growth without friction per unit tau; 0 where it is too slow for a double.
    """

    load: Ints
    mode: Ints
    alpha: Floats
    beta: Floats
    damping: Floats
    rate: Floats


@dataclass(frozen=True, eq=False)
class ModalSystems:
    """The modal systems of a rod under many loads, every mode that can matter; nothing is stored of single modes.

    Attributes
    ----------
    constants : ModeConstants
        What the equations need of the rod.
    loads : Loads
    """

    constants: ModeConstants
    loads: Loads

    def coefficients(self, modes: Any) -> tuple[Floats, Floats]:
        """Return alpha and beta of modes that broadcast against the flat loads, each a mode number or array."""
        alpha, beta = kernels.mode_coefficients(*self._family(), modes)
        return np.asarray(alpha), np.asarray(beta)

    def are_stable(self, growth_tolerance: float, workers: int | None) -> Bools:
        """Return under which loads no mode grows faster than the tolerance (1/s)."""
        out = np.empty(self.loads.size, dtype=np.bool_)
        constants = tuple(np.full(out.size, float(part)) for part in self.constants.equation)
        self._fill(kernels.modes_stable_fill, out, constants, (growth_tolerance, NEGLIGIBLE_GROWTH), workers)
        return out

    def fastest(self, workers: int | None) -> tuple[Floats, Ints]:
        """Return the growth rate in 1/s and the number of the fastest mode; 0, 0 where none grows."""
        out = np.empty((self.loads.size, 2))
        self._fill(kernels.modes_growth_fill, out, (), (self.constants.equation, NEGLIGIBLE_GROWTH), workers)
        return out[:, 0], out[:, 1].astype(np.int64)

    def pass_test(self, criterion: FiniteTimeCriterion, workers: int | None) -> Bools:
        """Return under which loads every mode passes a test of finite time.

        Half the threshold of growth bounds the modes left out: they are far from resonance, abs(A) / A'(0) is below 1
        at first, and what grows at half the rate ends at the square root of the limit.
        """
        *family, neutral_squared = self._family()
        a, b, c, d = (np.broadcast_to(part, self.loads.frequency.shape) for part in family)
        damping = self._damping()
        last = np.empty(damping.size, dtype=np.int64)
        inputs = (a, b, c, d - damping * damping, damping + 0.5 * criterion.threshold)
        over_chunks(kernels.modes_needed_fill, inputs, last, neutral_squared, workers=workers, chunk=4096)
        out = np.ones(damping.size, dtype=np.bool_)
        for mode in range(1, int(last.max(initial=0)) + 1):
            at = np.flatnonzero(out & (mode <= last))
            alpha, beta = kernels.mode_coefficients(a[at], b[at], c[at], d[at], neutral_squared, mode)
            out[at] = criterion.is_stable(alpha, beta, damping[at], workers=workers)
        return out

    def growing(self, growth_tolerance: float, workers: int | None) -> GrowingModes:
        """Return all modes that grow faster than the tolerance (1/s) without friction."""
        mean, amplitude, frequency = self.loads.flat
        last, _ = self.constants.modes_needed(AxialLoad(mean.max(), amplitude.max(), frequency.max()), growth_tolerance)
        modes = np.arange(1, last + 1)
        *family, neutral_squared = self._family()
        a, b, c, d = (np.reshape(part, (-1, 1)) for part in family)
        alpha, beta = kernels.mode_coefficients(a, b, c, d, neutral_squared, modes)
        damping = np.broadcast_to(self._damping()[:, None], alpha.shape)
        every = alpha.ravel(), beta.ravel(), damping.ravel() if damping.any() else None
        # Kicks follow, which take longer than a verdict one by one.
        stable = flat_stable(*every, workers=workers, in_blocks=False)
        load, column = np.nonzero(~stable.reshape(alpha.shape))
        chosen = alpha[load, column], beta[load, column], damping[load, column]
        rate = mathieu.growth_rate(*chosen, workers=workers)
        found = GrowingModes(load, modes[column], *chosen, rate)
        if growth_tolerance > 0.0:
            fast = rate * frequency[load] > growth_tolerance
            found = GrowingModes(*(part[fast] for part in found))
        return found

    def _family(self) -> tuple[Any, Any, Any, Any, Any]:
        return kernels.mode_family(*self.constants[:4], *self.loads.flat)

    def _damping(self) -> Floats:
        return np.asarray(self.constants.damping_rate / self.loads.frequency)

    def _fill(
        self, kernel: Any, out: NDArray[Any], inputs: tuple[Any, ...], limits: tuple[Any, ...], workers: int | None
    ) -> None:
        constants, inputs = self.constants, (*self.loads.flat, *inputs)
        chunk = constants.loads_at_once(self.loads)
        later = 0 if is_at_hand(kernel) else int(_LOADING / (INTERPRETED_UP_TO * constants.interpreted_ms(self.loads)))
        over_chunks(kernel, inputs, out, *limits, workers=workers, chunk=chunk, compile_after=later)
