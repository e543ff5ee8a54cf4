"""What fills panels of the explorer, at once and when there is time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping

from floquetrod.explorer.background import Stale, ViewParts
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import Load
from floquetrod.rod.modes.mode_model import ModeModel


class PanelSource(ABC):
    """What fills some of the panels; it keeps what the last move left as it was."""

    @abstractmethod
    def at_once(self, load: Load) -> ViewParts:
        """Return the panels that follow a slider; outdated ones come empty."""

    def first(self, load: Load, verdict: RodStability, stale: Stale) -> Iterator[ViewParts]:
        """Yield the panels shown soon after the verdict, by default none."""
        return iter(())

    def rest(self, load: Load, stale: Stale) -> Iterator[ViewParts]:
        """Yield the remaining panels, by default none."""
        return iter(())


def most_modes(model: ModeModel, limits: Mapping[str, tuple[float, float]], tolerance: float) -> int:
    """Return how many modes are needed under the strongest loads between limits, at either end of the frequencies."""
    (_, mean), (_, amplitude), frequencies = limits.values()
    return max(model.modes_needed(model.template.with_numbers(mean, amplitude, at), tolerance)[0] for at in frequencies)
