"""The verdict on a rod: modes, rates, the damping that would stabilise it, and its margins."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod.equations import Mathieu
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.verdict import Cost, Stability, Status, Verdict
from floquetrod.rod.data import RodData
from floquetrod.rod.load import AxialLoad, Quantity
from floquetrod.rod.modes import ModalSystem
from floquetrod.rod.tongues import HAIRLINE_GROWTH, gaps, unstable_loads

_SPANS = (1 / 32, 1 / 8, 0.5, 2.0, 8.0)
"""Reaches of the search for a margin: in critical forces, or as the factor less one by which a frequency changes."""


class Margin(NamedTuple):
    """How far one quantity of the load may fall or rise until the verdict changes; infinite when out of reach."""

    below: float
    above: float

    @property
    def nearest(self) -> float:
        """The smaller of both."""
        return min(self)


ASSUMPTIONS = ("axial force the same all along the rod", "small angles", "linear elasticity")
"""What the mode equations of every rod take for granted."""

INCLINED = "axial force uniform: the weight along the rod is neglected"
"""What they take for granted of the axial force in an inclined channel."""

IMMERSED = ("the load is the effective force, F_wall + p_i A_i - p_o A_o", "fluids at rest, added mass constant")
"""What they take for granted beside that with a fluid inside or outside."""


def assumptions(rod: RodData) -> tuple[str, ...]:
    """Return what the mode equations of a rod take for granted."""
    force, *others = ASSUMPTIONS
    force = INCLINED if rod.inclination < 0.5 * math.pi else force
    return (force, *others, *(IMMERSED if rod.fluid_inside or rod.fluid_outside else ()))


@dataclass(frozen=True, kw_only=True, repr=False)
class RodStability(Verdict):
    """Verdict on a rod under a load, in 1/s and s.

    Attributes
    ----------
    rod : Rod
    system : ModalSystem
        The equations of its modes under the load; ``load``, ``modes`` and ``mode_equations`` are taken from it.
    mode_verdicts : tuple of Stability
        Verdict on each of them.
    mode_growth_rates : ndarray
        Growth rate of each mode in 1/s.
    growth_tolerance : float
        Growth in 1/s up to which a mode counts as stable.
    status, growth_rate, exponents, multipliers, period, error, cost, note, assumptions
        As in every `Verdict`.  Stable when no mode grows faster than the tolerance; the growth rate is that of the
        fastest mode, within the tolerance or not; the exponents are those of all modes; ``error`` is the largest of a
        mode's discriminant.
    """

    rod: RodData
    system: ModalSystem
    mode_verdicts: tuple[Stability, ...]
    mode_growth_rates: NDArray[np.float64] = field(compare=False)
    growth_tolerance: float

    @property
    def load(self) -> AxialLoad:
        """The load."""
        return self.system.load

    @property
    def modes(self) -> tuple[int, ...]:
        """Modes looked at."""
        return self.system.modes

    @property
    def mode_equations(self) -> tuple[Mathieu, ...]:
        """Equation of each mode, in the time tau = omega t."""
        return self.system.equations

    @property
    def left_out_bound(self) -> float:
        """Bound in 1/s on the growth of every other mode, infinite where the modes were chosen by the caller."""
        return self.system.left_out_bound

    @property
    def cutoff(self) -> str:
        """Why these modes and no others."""
        return self.system.cutoff

    @property
    def modes_checked(self) -> int:
        """Number of modes looked at; `cutoff` says why that many."""
        return len(self.modes)

    @property
    def unstable_modes(self) -> tuple[int, ...]:
        """Modes that grow faster than the tolerance."""
        found = zip(self.modes, self.mode_verdicts, self.mode_growth_rates, strict=True)
        return tuple(m for m, v, rate in found if v.status == "unstable" and _grows(rate, self.growth_tolerance))

    @property
    def fastest_mode(self) -> int | None:
        """Mode that grows fastest, None when none grows."""
        return self.modes[int(self.mode_growth_rates.argmax())] if self.growth_rate > 0.0 else None

    def time_to_grow(self, factor: float = 10.0) -> float:
        """Return the time in s in which the fastest mode grows by ``factor``, infinite when none grows."""
        if not validate.finite("factor", factor) > 1.0:
            raise ValueError(f"factor must be greater than 1, got {factor!r}")
        return math.log(factor) / self.growth_rate if self.growth_rate > 0.0 else math.inf

    @cached_property
    def damping_to_stabilise(self) -> float:
        """Smallest damping rate in 1/s from which every larger one keeps all modes from growing.

        The rate meant is the rod's whole ``damping_rate``, whatever it is now, so all modes that matter without damping
        are looked at, or those the caller chose.  Infinite when the mean force alone buckles a mode: damping only slows
        that down.
        """
        undamped = self.rod.replace(damping_rate=0.0)
        return replace(self.system, modes=self._modes_for(undamped, self.load, 0.0)).damping_to_stabilise

    @cached_property
    def mean_force_margin(self) -> Margin:
        """Distance in N to the nearest mean forces at which the verdict changes, searched to 8 F_cr either way.

        Tongues that nowhere grow faster than `margin_tolerance` do not count, in this margin and the other two.
        """
        here, unit = self.load.mean, self.rod.critical_force
        return self._margin("mean", [here - x * unit for x in _SPANS], [here + x * unit for x in _SPANS])

    @cached_property
    def amplitude_margin(self) -> Margin:
        """Distance in N to the nearest amplitudes at which the verdict changes, searched to 2 F_cr above.

        Changes closer together than a thousandth of the distance searched may be passed over, as in
        `Rod.stable_amplitudes`.
        """
        here, unit = self.load.amplitude, self.rod.critical_force
        lower = [max(0.0, here - x * unit) for x in _SPANS]
        return self._margin("amplitude", lower, [here + x * unit for x in _SPANS if x <= 2.0])

    @cached_property
    def frequency_margin(self) -> Margin:
        """Distance in rad/s to the nearest frequencies at which the verdict changes, searched to 9 times either way."""
        here = self.load.frequency
        return self._margin("frequency", [here / (1.0 + x) for x in _SPANS], [here * (1.0 + x) for x in _SPANS])

    @property
    def margin_tolerance(self) -> float:
        """Growth in 1/s up to which loads count as stable in the margins.

        The growth tolerance, and at least 1e-6: a margin to a tongue in which nothing grows within a month would tell
        nothing.  Where the load itself lies in such a tongue the margins are those of the tongue.
        """
        least = max(self.growth_tolerance, HAIRLINE_GROWTH)
        return least if self.stable or self.growth_rate > least else self.growth_tolerance

    def _modes_for(self, rod: RodData, load: AxialLoad, growth_tolerance: float) -> tuple[int, ...]:
        """Return the modes that matter for another rod or load; those the caller chose stay as they are."""
        if math.isinf(self.left_out_bound):
            return self.modes
        last, _ = rod.modes_needed(load, growth_tolerance)
        return tuple(range(1, max(last, self.modes[-1]) + 1))

    def _margin(self, varied: Quantity, lower: list[float], upper: list[float]) -> Margin:
        here: float = getattr(self.load, varied)
        ends = (next(self._edges(varied, [here, *reach]), None) for reach in (lower, upper))
        return Margin(*(math.inf if end is None else abs(end - here) for end in ends))

    def _edges(self, varied: Quantity, way: list[float]) -> Iterator[float]:
        """Yield where the verdict changes on a way, the first on each of its pieces."""
        for piece in pairwise(way):
            end = self._edge(varied, piece)
            if end is not None:
                yield end

    def _edge(self, varied: Quantity, piece: tuple[float, float]) -> float | None:
        """Return where the verdict first changes from ``piece[0]`` to ``piece[1]``, None where it does not."""
        low, high = sorted(piece)
        if not low < high:
            return None
        tolerance = self.margin_tolerance
        modes = self._modes_for(self.rod, replace(self.load, **{varied: high}), tolerance)
        start = piece[0] if self.stable else None  # nothing beyond the first unstable part matters
        system = replace(self.system, modes=modes)
        found = unstable_loads(varied, system, tolerance, (low, high), union=True, nearest=start)
        stable = gaps(found.intervals, (low, high))
        if not stable:
            return piece[0] if self.stable else None
        near, far = stable[0] if piece[0] == low else stable[-1][::-1]
        if not self.stable:
            return near
        if near != piece[0]:
            return piece[0]
        return far if far != piece[1] else None

    def __repr__(self) -> str:
        """Return the verdict as a sentence."""
        if self.status == "stable":
            slow = f", growth {self.growth_rate:.3g} 1/s within the tolerance" if self.growth_rate > 0.0 else ""
            return f"<stable{slow}; {self.cutoff}>"
        if self.status == "undecided":
            return f"<undecided; {self.cutoff}>"
        names = ", ".join(map(str, self.unstable_modes))
        some = f"modes {names} grow" if len(self.unstable_modes) > 1 else f"mode {names} grows"
        return (
            f"<unstable: {some}; mode {self.fastest_mode} at "
            f"{self.growth_rate:.6g} 1/s, tenfold in {self.time_to_grow():.3g} s; {self.cutoff}>"
        )


def classify_modes(rod: RodData, system: ModalSystem, growth_tolerance: float) -> RodStability:
    """Classify every mode and put the verdicts together."""
    verdicts = tuple(stability(equation) for equation in system.equations)
    rates = np.array([verdict.growth_rate for verdict in verdicts]) * system.frequency
    grows = [v.status == "unstable" and _grows(r, growth_tolerance) for v, r in zip(verdicts, rates, strict=True)]
    unsure = [v.status == "undecided" and not r < growth_tolerance for v, r in zip(verdicts, rates, strict=True)]
    status: Status = "unstable" if any(grows) else "undecided" if any(unsure) else "stable"
    exponents = [exponent * system.frequency for verdict in verdicts for exponent in verdict.exponents]
    units = {verdict.cost.unit for verdict in verdicts}
    return RodStability(
        rod=rod,
        system=system,
        mode_verdicts=verdicts,
        mode_growth_rates=rates,
        growth_tolerance=growth_tolerance,
        status=status,
        growth_rate=float(rates.max()),
        exponents=tuple(sorted(exponents, key=lambda exponent: -exponent.real)),
        period=2.0 * math.pi / system.frequency,
        error=max(verdict.error for verdict in verdicts),
        cost=Cost(sum(verdict.cost.amount for verdict in verdicts), units.pop() if len(units) == 1 else "operations"),
        note="; ".join(dict.fromkeys(v.note for v, unknown in zip(verdicts, unsure, strict=True) if unknown)),
        assumptions=assumptions(rod),
    )


def _grows(rate: float, tolerance: float) -> bool:
    return rate > tolerance or tolerance == 0.0  # an unstable mode may grow at a rate too small for a double
