"""All ranges of kicks that escape."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.content import NoTruthValue
from floquetrod._util.roots import bisected
from floquetrod.equations import FrictionalMathieu, require
from floquetrod.friction.fate_of_kicks import ESCAPES, UNDECIDED, fates
from floquetrod.friction.inputs import MAX_STEPS
from floquetrod.friction.proved_kicks import certain_kicks

_MOST_SAMPLES = 1_000_000  # kicks followed (a choice)


class KickRange(NamedTuple):
    """Kicks between ``low`` and ``high``."""

    low: float
    high: float


@dataclass(frozen=True, repr=False)
class EscapeRanges(NoTruthValue):
    """All ranges of kicks that escape, as finely as kicks were tried.

    Attributes
    ----------
    equation : FrictionalMathieu
    intervals : tuple of KickRange
        Ranges of kicks that escape, increasing; the last is unbounded.
    bounded_up_to : float
        Proved: no kick up to it escapes.
    escapes_above : float
        Proved: every kick above it escapes.
    step : float
        Ratio of neighbouring kicks tried less one: ranges and gaps narrower than this may be missed.
    undecided : int
        Kicks tried whose fate could not be determined; they count as not escaping.
    """

    ask = ".intervals"

    equation: FrictionalMathieu
    intervals: tuple[KickRange, ...]
    bounded_up_to: float
    escapes_above: float
    step: float
    undecided: int

    def __contains__(self, kick: float) -> bool:
        """Return whether a kick of size ``kick`` lies in one of the ranges."""
        return any(r.low < abs(kick) < r.high for r in self.intervals)

    def __repr__(self) -> str:
        """Return the ranges as a sentence."""
        shown = [f"({r.low:.6g}, {r.high:.6g})" for r in self.intervals[:6]]
        more = f" and {len(self.intervals) - 6} more" if len(self.intervals) > 6 else ""
        what = f"escapes for kicks in {', '.join(shown)}{more}" if shown else "no kick escapes"
        unknown = f"; {self.undecided} kicks undecided" if self.undecided else ""
        return f"<{what}; tried in steps of {100.0 * self.step:.2g} %{unknown}>"


def escape_ranges(
    equation: FrictionalMathieu, *, samples: int = 2000, max_steps: int = MAX_STEPS, workers: int | None = None
) -> EscapeRanges:
    """Return all ranges of kicks that escape: a larger kick need not escape where a smaller one does.

    Between the largest kick proved bounded and the smallest proved to escape, ``samples`` kicks in geometric
    progression are followed, and every change of fate between neighbours is bisected to 1e-10.  The edges may be
    fractal: more samples then show more and narrower ranges.

    Parameters
    ----------
    samples : int
        Number of kicks followed, 2 or more.

    Returns
    -------
    EscapeRanges
        The ranges, in increasing order, and the proved kicks on both sides.

    Raises
    ------
    TypeError, ValueError
        For another equation, and for numbers out of these ranges.

    Examples
    --------
    >>> escape_ranges(FrictionalMathieu(alpha=0.0, beta=0.25, gamma=1.0))
    <escapes for kicks in (2, inf); tried in steps of 0 %>
    """
    require(equation, (FrictionalMathieu,), "escape_ranges")
    samples = validate.integer("samples", samples, 2, _MOST_SAMPLES)
    e = equation
    low, high = certain_kicks(e)
    if not high < math.inf:
        return EscapeRanges(e, (), low, high, 0.0, 0)
    if high <= low * (1.0 + 1e-10):
        return EscapeRanges(e, (KickRange(high, math.inf),), low, high, 0.0, 0)

    def follow(kicks: NDArray[np.float64]) -> NDArray[np.int8]:
        result = fates(e.alpha, e.beta, e.gamma, kicks, damping=e.damping, max_steps=max_steps, workers=workers)
        return np.asarray(result, dtype=np.int8)

    kicks = low * (high / low) ** np.linspace(0.0, 1.0, samples)
    kicks[-1] = high * (1.0 + 1e-10)
    kick_fates = follow(kicks)
    escaped = kick_fates == ESCAPES
    change = np.flatnonzero(escaped[1:] != escaped[:-1])
    _, above = bisected(
        lambda kick: (follow(kick) == ESCAPES) == escaped[change],
        kicks[change],
        kicks[change + 1],
        1200,  # doubles end before
        relative=1e-10,
    )
    edges = [*map(float, above), math.inf]
    intervals = tuple(KickRange(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True))
    return EscapeRanges(
        e, intervals, low, high, (high / low) ** (1.0 / samples) - 1.0, int((kick_fates == UNDECIDED).sum())
    )
