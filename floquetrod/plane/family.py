"""What a chart is of: problems over a plane, told by verdicts on places, and by exact bands where there are any.

Five families are charted: problems returned by a function of the user (`systems/family_charts.py`), Mathieu's equation
(`mathieu/mathieu_charts.py`), the loads of a rod (`rod/load_plane.py`), the speeds and depths of a cutter
(`milling/stability_lobes.py`), and verdicts returned by a function.  `floquetrod.plane.charted` makes a `Chart` of any
of them, with verdicts at points and a source of its bands: `plane/sources.py` uses exact ones, which are polygons
between the curves of tongues that counts find, or traces them by verdicts and states how narrow a band it may miss.
A further kind of chart is a `Family` with `verdicts`, with `exact_bands` where it knows them, and with `signed_growth`
where growth of stable places is known too, by which bands are traced in fewer places.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod._util.progress import Progress
from floquetrod.plane.bands import Band
from floquetrod.plane.plane_axes import Axis

Names: TypeAlias = tuple[int | None, int | None, int | None]
"""Mode, partner and tongue of what grows, see `floquetrod.plane.Band`; None for what is not known."""

VERTEX = 1e-10
"""Share of the axes between the places judged unstable and not, on whose middle a vertex is put."""


class Verdicts(NamedTuple):
    """Of places: status 1, 0 or -1, growth rate (NaN where not known), and the fastest mode (None without modes).

    Where nothing is undecided, the status may be whether it is stable.
    Each an array of the shape of the places, or one value for all.
    """

    status: Any
    growth: Any = np.nan
    mode: Any = None


class FoundBands(NamedTuple):
    """Bands, the number of tongues left out, accuracy and resolution, as in `floquetrod.plane.Bands`."""

    bands: tuple[Band, ...]
    tongues_left_out: int
    accuracy: float
    resolution: tuple[float, float]


class Family(ABC):
    """Problems over a plane; one that can be pickled makes a chart that can be.

    Subclasses define the abstract methods; the others have defaults.

    Attributes
    ----------
    growth_unit, growth_tolerance
        As in `floquetrod.plane.Chart`.
    """

    growth_unit: str
    growth_tolerance: float

    @abstractmethod
    def verdicts(self, x: Floats, y: Floats, *, growth: bool = False, quick: bool = False) -> Verdicts:
        """Return verdicts at places x, y, broadcast against each other.

        Parameters
        ----------
        growth : bool
            Whether growth must be known, and the mode where there is one; else it may be NaN.
        quick : bool
            Whether what would take long may stay undecided.
        """

    def subject(self) -> dict[str, Any]:
        """Return the chart's subject, see `floquetrod.plane.Chart`; called when all points have verdicts."""
        return {"kind": "", "fixed": []}

    def growth(self, x: Floats, y: Floats) -> Floats:
        """Return growth rates at places x, y (n,) in a band, NaN where they are not known."""
        return np.asarray(self.verdicts(x, y, growth=True).growth)

    def name(self, x: float, y: float) -> Names:
        """Return what grows at a place."""
        return None, None, None

    def exact_bands(self, x: Axis, y: Axis, accuracy: float, progress: Progress | None) -> FoundBands | None:
        """Return the bands between exact curves, None where verdicts must be traced."""
        return None

    @property
    def prompt(self) -> bool:
        """Whether bands are found about as fast as the chart, so that they may be drawn unasked."""
        return True

    @property
    def criterion(self) -> str:
        """What "stable" means where it is not the problem's own stability; "" where it is."""
        return ""

    @property
    def points_at_once(self) -> int:
        """Points judged between two reports of progress; whole rows or columns are, one at least."""
        return 1 << 18  # about a megabyte an array (a choice)

    @property
    def by_columns(self) -> bool:
        """Whether whole columns of a chart are judged at once, not rows."""
        return False

    @property
    def most_judged(self) -> int:
        """Places judged at most while bands are traced."""
        return 300_000  # a choice

    @property
    def signed_growth(self) -> Callable[[Floats, Floats], Floats] | None:
        """Function of places x, y (n,) that returns growth, negative where motion decays, whose zeros bound the bands.

        None where these are traced by verdicts.
        """
        return None

    @property
    def vertex(self) -> float:
        """How far traced vertices may be from the boundary, as a fraction of the axes.

        Tongues ten times as thin are not followed.
        """
        return VERTEX


@dataclass(frozen=True)
class Judged(Family):
    """A family told by a function from places x, y to status and growth rate alone."""

    judge: Callable[[Any, Any], tuple[Any, Any]]
    growth_unit: str = "per tau"
    growth_tolerance: float = 0.0

    def verdicts(self, x: Floats, y: Floats, *, growth: bool = False, quick: bool = False) -> Verdicts:
        """Return what the function says."""
        return Verdicts(*self.judge(x, y))
