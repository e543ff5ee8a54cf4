"""What a verdict on a rod rests on, whatever couples its modes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.report import Table
from floquetrod.floquet.systems.result import Resonance
from floquetrod.rod.answers.margins import Edge
from floquetrod.rod.loads.load import Load, Progress, Quantity

if TYPE_CHECKING:
    from floquetrod.rod.answers.verdict import RodStability


class Shape(NamedTuple):
    """The fastest growing solution along the rod, freed of its growth; its largest deflection is 1.

    Attributes
    ----------
    s : ndarray
        Position in m from the upper end.
    deflection : ndarray
        At the instant of largest deflection.
    envelope : ndarray
        Largest deflection over a period, at each position.
    """

    s: NDArray[np.float64]
    deflection: NDArray[np.float64]
    envelope: NDArray[np.float64]


class Evidence(ABC):
    """What a verdict rests on: the equations of the modes under the load, and what was found of them.

    Every model of the modes has its own; a verdict asks it for what depends on the equations.
    """

    kind: ClassVar[str]
    """Of which modes it is, in words."""

    @property
    @abstractmethod
    def load(self) -> Load:
        """The load."""

    @property
    @abstractmethod
    def modes(self) -> tuple[int, ...]:
        """Modes looked at."""

    @property
    @abstractmethod
    def cutoff(self) -> str:
        """Why these modes and no others."""

    @property
    @abstractmethod
    def references(self) -> tuple[str, ...]:
        """What to cite for the methods used."""

    @property
    @abstractmethod
    def resonances(self) -> tuple[Resonance, ...]:
        """What grows, the fastest first."""

    def unstable_modes(self, verdict: RodStability) -> tuple[int, ...]:
        """Return the modes that take part in what grows faster than the tolerance."""
        if verdict.status != "unstable":
            return ()
        growing = [r for r in self.resonances if r.growth_rate > verdict.growth_tolerance]
        return tuple(sorted({mode for resonance in growing for mode in resonance.modes}))

    def fastest_mode(self, verdict: RodStability) -> int | None:
        """Return the mode that grows fastest, the lower one of a combination; None when none grows, or is named."""
        return min(self.resonances[0].modes) if self.resonances and verdict.growth_rate > 0.0 else None

    @abstractmethod
    def damping_to_stabilise(self, verdict: RodStability) -> float:
        """Return the smallest damping rate in 1/s from which every larger one keeps all modes from growing."""

    @abstractmethod
    def growth_of(self, verdict: RodStability, mode: int) -> float:
        """Return the growth rate of a mode in 1/s, of the rod where it has none of its own."""

    def is_fastest(self, verdict: RodStability, mode: int | None) -> bool:
        """Return whether the growth rate of the rod is that of a mode."""
        return mode == verdict.fastest_mode

    def plot(self, verdict: RodStability, ax: Any = None) -> Any:
        """Draw the shape in which the rod grows; return the axes."""
        from floquetrod.plotting.rod import draw_shape

        return draw_shape(verdict, ax)

    # --- what a report says of it ---

    has_exact_margins: ClassVar[bool] = False
    """Whether margins are computed in milliseconds from boundaries; else they are found by sampling."""

    enough: ClassVar[str] = "stable at every rate tried above {}"
    """Which damping rates stabilise, with {} for the least."""

    @abstractmethod
    def headline(self, verdict: RodStability) -> str:
        """Return what grows, or why that is not known; "" where there is nothing to say."""

    def fastest_in_words(self, verdict: RodStability) -> str:
        """Return what grows fastest, to stand before "at so many 1/s"."""
        return f"{self.resonances[0]}," if self.resonances else "growth"

    def grows_in(self, verdict: RodStability) -> str:
        """Return, to stand behind the growth rate, in which mode; "" where that is said elsewhere."""
        return ""

    @abstractmethod
    def method(self, verdict: RodStability) -> str:
        """Return how the verdict was found, and how good it is."""

    def named_lines(self, verdict: RodStability) -> list[tuple[str, str]]:
        """Return lines that name what grows."""
        return []

    @property
    def table(self) -> Table | None:
        """The modes nearest to trouble, where each has an equation of its own."""
        return None

    @abstractmethod
    def numbers(self, verdict: RodStability) -> dict[str, Any]:
        """Return what `RodStability.as_dict` has besides."""

    @abstractmethod
    def edge(
        self,
        verdict: RodStability,
        varied: Quantity,
        piece: tuple[float, float],
        seconds: float,
        progress: Progress | None,
    ) -> Edge:
        """Return where the verdict first changes from ``piece[0]`` to ``piece[1]``, in about so many seconds."""

    def sentence(self, verdict: RodStability) -> str:
        """Return status, growth and the modes that grow."""
        if verdict.status == "stable":
            slow = f", growth {verdict.growth_rate:.3g} 1/s within the tolerance" if verdict.growth_rate > 0.0 else ""
            return f"stable{slow}"
        if verdict.status == "undecided":
            return "undecided"
        names = ", ".join(map(str, verdict.unstable_modes))
        some = f"modes {names} grow" if len(verdict.unstable_modes) > 1 else f"mode {names} grows"
        return (
            f"unstable: {some}; mode {verdict.fastest_mode} at {verdict.growth_rate:.6g} 1/s, tenfold in "
            f"{verdict.time_to_grow():.3g} s"
        )
