"""The verdict on a rod: modes, rates, the damping that would stabilise it, and its margins."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.caching import cached_property
from floquetrod.equations import Mathieu
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.references import references, united
from floquetrod.floquet.verdict import Cost, Stability, Status, tolerated
from floquetrod.rod.assumptions import assumptions
from floquetrod.rod.load import Load, Quantity
from floquetrod.rod.modal import ModalRod
from floquetrod.rod.modes import ModalSystem
from floquetrod.rod.tongues import gaps, unstable_loads
from floquetrod.rod.verdict import Edge, RodVerdict


@dataclass(frozen=True, kw_only=True, repr=False)
class RodStability(RodVerdict):
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

    system: ModalSystem
    mode_verdicts: tuple[Stability, ...]
    mode_growth_rates: NDArray[np.float64] = field(compare=False)

    @property
    def references(self) -> tuple[str, ...]:
        """What to cite, in plain text with DOI, floquetrod first, then the sources of what was used."""
        return united(references(("rod", "model")), *(verdict.references for verdict in self.mode_verdicts))

    @property
    def load(self) -> Load:
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
        return tuple(m for m, v, rate in found if v.status == "unstable" and not tolerated(rate, self.growth_tolerance))

    @property
    def fastest_mode(self) -> int | None:
        """Mode that grows fastest, None when none grows."""
        return self.modes[int(self.mode_growth_rates.argmax())] if self.growth_rate > 0.0 else None

    @cached_property
    def damping_to_stabilise(self) -> float:
        """Smallest damping rate in 1/s from which every larger one keeps all modes from growing.

        The rate meant is the rod's whole ``damping_rate``, whatever it is now, so all modes that matter without damping
        are looked at, or those the caller chose.  Infinite when the mean force alone buckles a mode: damping only slows
        that down.
        """
        undamped = self.rod.replace(damping_rate=0.0)
        return replace(self.system, modes=self._modes_for(undamped, self.load, 0.0)).damping_to_stabilise

    def _modes_for(self, rod: ModalRod, load: Load, growth_tolerance: float) -> tuple[int, ...]:
        """Return the modes that matter for another rod or load; those the caller chose stay as they are."""
        if math.isinf(self.left_out_bound):
            return self.modes
        last, _ = rod.modes_needed(load, growth_tolerance)
        return tuple(range(1, max(last, self.modes[-1]) + 1))

    def _edge(self, varied: Quantity, piece: tuple[float, float], seconds: float) -> Edge:
        """Return where the verdict first changes from ``piece[0]`` to ``piece[1]``, which takes milliseconds."""
        low, high = sorted(piece)
        tolerance = self.margin_tolerance
        modes = self._modes_for(self.rod, self.load.varied(varied, high), tolerance)
        start = piece[0] if self.stable else None  # nothing beyond the first unstable part matters
        system = replace(self.system, modes=modes)
        found = unstable_loads(varied, system, tolerance, (low, high), union=True, nearest=start)
        stable = gaps(found.intervals, (low, high))
        if not stable:
            at = piece[0] if self.stable else None
        else:
            near, far = stable[0] if piece[0] == low else stable[-1][::-1]
            if not self.stable:
                at = near
            elif near != piece[0]:
                at = piece[0]
            else:
                at = far if far != piece[1] else None
        return Edge(at, piece[1] if at is None else at, found.resolution)


def classify_modes(rod: ModalRod, system: ModalSystem, growth_tolerance: float) -> RodStability:
    """Classify every mode and put the verdicts together."""
    verdicts = tuple(stability(equation) for equation in system.equations)
    rates = np.array([verdict.growth_rate for verdict in verdicts]) * system.frequency
    grows = [
        v.status == "unstable" and not tolerated(r, growth_tolerance) for v, r in zip(verdicts, rates, strict=True)
    ]
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
        assumptions=assumptions(rod, system.load),
    )


def growth_of_modes(rod: ModalRod, load: Load, modes: Iterable[int]) -> NDArray[np.float64]:
    """Return the growth rates in 1/s of modes that are independent."""
    return classify_modes(rod, rod.independent_modes(load, modes), 0.0).mode_growth_rates
