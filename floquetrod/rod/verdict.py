"""What every verdict on a rod has: the load, the modes that grow, and how far the load is from a change."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from floquetrod._util import validate
from floquetrod._util.caching import cached_property
from floquetrod.floquet.verdict import Verdict
from floquetrod.rod.constants import HAIRLINE_GROWTH
from floquetrod.rod.load import Load, Progress, Quantity
from floquetrod.rod.modal import ModalRod

_SPANS = (1 / 32, 1 / 8, 0.5, 2.0, 8.0)
"""Reaches of the search for a margin: in critical forces, or as the factor less one by which a frequency changes."""


_WAYS: dict[Quantity, Callable[[float, float], tuple[list[float], list[float]]]] = {
    "mean": lambda here, unit: ([here - x * unit for x in _SPANS], [here + x * unit for x in _SPANS]),
    "amplitude": lambda here, unit: (
        [max(0.0, here - x * unit) for x in _SPANS],
        [here + x * unit for x in _SPANS if x <= 2.0],
    ),
    "frequency": lambda here, unit: ([here / (1.0 + x) for x in _SPANS], [here * (1.0 + x) for x in _SPANS]),
}
"""The ends of the pieces of a search for a margin, down and up, from where the load is and the critical force."""

MARGIN_SECONDS = 10.0  # that a margin of coupled modes may take (a choice)


class _Distances(NamedTuple):
    below: float
    above: float


class Margin(_Distances):
    """How far one quantity of the load may fall or rise until the verdict changes; infinite when out of reach.

    Attributes
    ----------
    below, above : float
        The distances; ``below, above = margin``.
    resolution : float
        Changes closer together than this may have been passed over, in the unit of the distances; 0 where none can be.
    searched : (float, float)
        Up to which distances below and above was searched: where there is a change, it is that.

    Comparing compares the distances.
    """

    resolution: float
    searched: tuple[float, float]

    def __new__(
        cls, below: float, above: float, resolution: float = 0.0, searched: tuple[float, float] | None = None
    ) -> Margin:
        """Return a pair of distances with what is known of the search."""
        margin = super().__new__(cls, below, above)
        margin.resolution, margin.searched = resolution, (below, above) if searched is None else searched
        return margin

    @property
    def nearest(self) -> float:
        """The smaller of both."""
        return min(self)


class Edge(NamedTuple):
    """Where the verdict changes on a way, None where it does not, up to where was searched, and how finely."""

    at: float | None
    searched: float
    resolution: float


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

        Tongues that nowhere grow faster than `margin_tolerance` do not count, in this margin and the other two.  Where
        modes are coupled the search is sampled, and ends early where it would take more than about ten seconds: see
        `Margin.resolution` and `Margin.searched`; `margin` goes on.
        """
        return self.margin("mean", seconds=MARGIN_SECONDS)

    @cached_property
    def amplitude_margin(self) -> Margin:
        """Distance in N to the nearest amplitudes at which the verdict changes, searched to 2 F_cr above.

        `Margin.resolution` says which changes may be passed over, as in `Rod.stable_amplitudes`.
        """
        return self.margin("amplitude", seconds=MARGIN_SECONDS)

    @cached_property
    def frequency_margin(self) -> Margin:
        """Distance in rad/s to the nearest frequencies at which the verdict changes, searched to 9 times either way."""
        return self.margin("frequency", seconds=MARGIN_SECONDS)

    def margin(self, quantity: Quantity, *, seconds: float = math.inf, progress: Progress | None = None) -> Margin:
        """Return the margin of one quantity of the load, searched for as long as wanted.

        Parameters
        ----------
        quantity : "mean", "amplitude" or "frequency"
        seconds : float
            About how long the search for coupled modes may take: it takes fewer samples, and ends early, where it would
            take longer by an estimate that does not depend on the machine.
        progress : callable, optional
            Called with the numbers of parts of the search done and of all; a margin may be found before the last.

        Returns
        -------
        Margin
            In N or rad/s.

        Raises
        ------
        ValueError
            For another quantity, and for ``seconds`` that are not greater than zero.
        """
        validate.choice("quantity", quantity, _WAYS)
        if not (isinstance(seconds, float) and seconds == math.inf):
            seconds = validate.positive("seconds", seconds, "leave it out to search everything")
        validate.progress(progress)
        here: float = getattr(self.load, quantity)
        ways = [[here, *way] for way in _WAYS[quantity](here, self.rod.critical_force)]
        parts = sum(len(way) - 1 for way in ways)
        ends, done = [], 0
        for way in ways:
            found = Edge(None, way[0], 0.0)
            for number, piece in enumerate(pairwise(way), start=done + 1):
                found = self._extended(found, quantity, piece, seconds / parts)
                if progress is not None:
                    progress(number, parts)
                if found.at is not None or found.searched != piece[1]:
                    break
            ends.append(found)
            done += len(way) - 1
        if progress is not None:
            progress(parts, parts)
        below, above = (math.inf if end.at is None else abs(end.at - here) for end in ends)
        searched = abs(ends[0].searched - here), abs(ends[1].searched - here)
        return Margin(below, above, max(end.resolution for end in ends), searched)

    @property
    def margin_tolerance(self) -> float:
        """Growth in 1/s up to which loads count as stable in the margins.

        The growth tolerance, and at least 1e-6: a margin to a tongue in which nothing grows within a month would tell
        nothing.  Where the load itself lies in such a tongue the margins are those of the tongue.
        """
        least = max(self.growth_tolerance, HAIRLINE_GROWTH)
        return least if self.stable or self.growth_rate > least else self.growth_tolerance

    def _extended(self, found: Edge, varied: Quantity, piece: tuple[float, float], seconds: float) -> Edge:
        """Return what is found on a way after its next piece, which may be empty."""
        if piece[0] == piece[1]:
            return found
        edge = self._edge(varied, piece, seconds)
        return edge._replace(resolution=max(found.resolution, edge.resolution))

    @abstractmethod
    def _edge(self, varied: Quantity, piece: tuple[float, float], seconds: float) -> Edge:
        """Return where the verdict first changes from ``piece[0]`` to ``piece[1]``, in about so many seconds."""

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
