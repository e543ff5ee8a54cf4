"""The colours of every picture: each has one meaning, differs in lightness from the others, and is named only here.

Stable is white and unstable orange, the darker the faster; between orange, white, grey and black nobody
has to tell red from green, and in print their lightness tells them apart.  Greys and black are lines, text and
whatever is neither stable nor unstable.

Figures keep their white ground on a dark page, where they lie on a card: stable is white, and a ground that showed the
page would be as dark as the fastest growth.
"""

from __future__ import annotations

from typing import Any

STABLE = "#ffffff"
UNSTABLE = "#e08a2e"
UNSEEN = "#f9d9a8"
"""Unstable, and growing too slowly for the paper's test over 100 periods to see."""

NEUTRAL = "#b3b3b3"
"""An area that says nothing about stability."""

UNKNOWN = "#e6e6e6"
"""An area that has not been examined yet."""

FASTEST = "#4a1500"
"""The end of the shades of growth; the slowest growth has the colour of `UNSEEN`."""

NO_KICK: dict[str, Any] = {"facecolor": STABLE, "hatch": "////", "edgecolor": NEUTRAL, "linewidth": 0.0}
"""Style of an area where no kick buckles a rod that is held by friction."""

OPEN: dict[str, Any] = {"facecolor": NEUTRAL, "hatch": "xxxxxx", "edgecolor": "black", "linewidth": 0.0}
"""Style of an area where stability is undecided."""

LARGE: dict[str, Any] = {"facecolor": "none", "hatch": "....", "edgecolor": "black", "linewidth": 0.0}
"""Style of an area where a rod that is stable at rest carries a large motion, too."""

BOX: dict[str, Any] = {"boxstyle": "round", "facecolor": STABLE, "edgecolor": "black", "linewidth": 0.6}
"""Style of the box about a remark."""

PAGE = {"ink": ("#1a1a1a", "#e6e6e6"), "page": (STABLE, "#161616"), "line": ("#c8c8c8", "#4a4a4a")}
"""Text, ground and lines of a page that shows pictures, in light and in the dark."""

POINT: dict[str, Any] = {"marker": "o", "color": "black", "markerfacecolor": STABLE}
"""Style of a load, or of a mode that does not grow; one that grows is filled with black."""


def shares() -> Any:
    """Return the map of colours for shares of runs, white for none and orange for all."""
    return _colours([STABLE, UNSTABLE], 256)


def verdicts() -> Any:
    """Return the map of colours for arrays with 0 where stable and 1 where not."""
    return _colours([STABLE, UNSTABLE], 2)


def shades(*, darkest_first: bool = False) -> Any:
    """Return the map of colours for how fast growth is, or how little it takes: the worse the darker."""
    ends = [UNSEEN, UNSTABLE, FASTEST]
    return _colours(ends[::-1] if darkest_first else ends, 256)


def _colours(ends: list[str], number: int) -> Any:
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("floquetrod", ends, N=number)
