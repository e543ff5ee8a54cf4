"""What every verdict on a rod has: the load, the modes that grow, and how far the load is from a change."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from floquetrod._util import validate
from floquetrod._util.caching import cached_property
from floquetrod.floquet.verdict import Verdict
from floquetrod.rod.constants import HAIRLINE_GROWTH
from floquetrod.rod.load import Load, Quantity
from floquetrod.rod.modal import ModalRod

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


@dataclass(frozen=True, kw_only=True, repr=False)
class RodVerdict(Verdict):
    """Verdict on a rod under a load, in 1/s and s, whatever couples its modes.

    Attributes
    ----------
    rod : Rod
    growth_tolerance : float
        Growth in 1/s up to which a mode counts as stable.
    status, growth_rate, exponents, multipliers, period, error, cost, note, assumptions
        As in every `Verdict`.  Stable when nothing grows faster than the tolerance; the growth rate is that of the
        fastest solution, within the tolerance or not.
    """

    rod: ModalRod
    growth_tolerance: float

    @property
    @abstractmethod
    def load(self) -> Load:
        """The load."""

    @property
    @abstractmethod
    def references(self) -> tuple[str, ...]:
        """What to cite, in plain text with DOI, floquetrod first, then the sources of what was used."""

    @property
    @abstractmethod
    def modes_checked(self) -> int:
        """Number of modes looked at; `cutoff` says why that many."""

    @property
    @abstractmethod
    def cutoff(self) -> str:
        """Why these modes and no others."""

    @property
    @abstractmethod
    def unstable_modes(self) -> tuple[int, ...]:
        """Modes that grow faster than the tolerance."""

    @property
    @abstractmethod
    def fastest_mode(self) -> int | None:
        """Mode that grows fastest, None when none grows."""

    @property
    @abstractmethod
    def damping_to_stabilise(self) -> float:
        """Smallest damping rate in 1/s from which every larger one keeps all modes from growing."""

    def time_to_grow(self, factor: float = 10.0) -> float:
        """Return the time in s in which the fastest mode grows by ``factor``, infinite when none grows."""
        if not validate.finite("factor", factor) > 1.0:
            raise ValueError(f"factor must be greater than 1, got {factor!r}")
        return math.log(factor) / self.growth_rate if self.growth_rate > 0.0 else math.inf

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

    @abstractmethod
    def _edge(self, varied: Quantity, piece: tuple[float, float]) -> float | None:
        """Return where the verdict first changes from ``piece[0]`` to ``piece[1]``, None where it does not."""

    def _sentence(self) -> str:
        """Return status, growth and the modes that grow."""
        if self.status == "stable":
            slow = f", growth {self.growth_rate:.3g} 1/s within the tolerance" if self.growth_rate > 0.0 else ""
            return f"stable{slow}"
        if self.status == "undecided":
            return "undecided"
        names = ", ".join(map(str, self.unstable_modes))
        some = f"modes {names} grow" if len(self.unstable_modes) > 1 else f"mode {names} grows"
        return (
            f"unstable: {some}; mode {self.fastest_mode} at {self.growth_rate:.6g} 1/s, tenfold in "
            f"{self.time_to_grow():.3g} s"
        )

    def __repr__(self) -> str:
        """Return the verdict as a sentence."""
        return f"<{self._sentence()}; {self.cutoff}>"
