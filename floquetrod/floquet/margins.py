"""How far an equation or a system is from a change of its verdict, along a parameter."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.suggest import did_you_mean
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.problems import require_problem

_ACCURACY = 1e-10  # of a boundary, relative to what was searched (a choice)
_MOST_SAMPLES = 100_000  # on either side: ten seconds for a scalar equation (measured)


class _Distances(NamedTuple):
    below: float
    above: float


class Margin(_Distances):
    """How far one quantity may fall or rise until the verdict changes; infinite when out of reach.

    Attributes
    ----------
    below : float
        How far it may fall; ``below, above = margin``.
    above : float
        How far it may rise.
    resolution : float
        Changes closer together than this may have been passed over, in the unit of the distances; 0 where none can be.
    searched : (float, float)
        Distances below and above up to which was searched; where a change was found, its distance.

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
        """The smaller of the two distances."""
        return min(self)


class Edge(NamedTuple):
    """Where a verdict first changes on a way, None where it is seen not to, up to where was searched, and how finely.

    ``seconds`` is what the search takes, as estimated.
    """

    at: float | None
    searched: float
    resolution: float
    seconds: float = 0.0


def margin(
    family: Callable[..., Any], along: str, within: tuple[float, float], *, samples: int = 65, **at: Any
) -> Margin:
    """Return how far one parameter of a family may fall or rise until the verdict on its equation changes.

    Parameters
    ----------
    family : callable
        Makes an equation or a system of its arguments: a class such as `Mathieu`, or a function.
    along : str
        The parameter that varies, one of ``at``.
    within : (float, float)
        Values between which the change is searched for; that of ``at`` lies between them.
    samples : int
        Verdicts on either side, 2 to 100,000: a change and its reverse between two of them are passed over.
    **at
        Arguments of the family at which the verdict is, all of them.

    Returns
    -------
    Margin
        The nearest change on either side to 1e-10 of the range searched; its ``resolution`` is the distance of samples.

    Raises
    ------
    TypeError, ValueError
        For a family that makes something else, a parameter that is not among ``at``, and where the verdict at ``at`` is
        undecided.

    Examples
    --------
    >>> from floquetrod.equations import Mathieu
    >>> found = margin(Mathieu, "beta", (-1.0, 0.0), alpha=0.1, beta=-0.5)
    >>> f"{found.below:.6f} {found.above:.6f}"  # to the tongues at -1 and -1/4
    '0.499167 0.201281'
    """
    along = _given_by_name(along, at)
    here = validate.finite(along, at[along])
    given = validate.sequence("within", within)
    if len(given) != 2:
        raise ValueError(f"within must be two values, (low, high), got {validate.short(within)}")
    low, high = (validate.finite(f"within[{i}]", end) for i, end in enumerate(given))
    samples = validate.integer("samples", samples, 2, _MOST_SAMPLES)
    if not low <= here <= high:
        raise ValueError(f"within must hold {along} = {here:g}, got ({low:g}, {high:g})")

    def status(value: float) -> str:
        problem = family(**{**at, along: value})
        require_problem(problem)
        found: str = stability(problem).status
        return found

    own = status(here)
    if own == "undecided":
        raise ValueError(f"{along} must be where the verdict is known, got {here:g}, which is on a boundary")
    ends = [_first_change(status, own, here, end, samples) for end in (low, high)]
    below, above = (math.inf if end is None else abs(end - here) for end in ends)
    searched = tuple(min(reach, abs(end - here)) for reach, end in zip((below, above), (low, high), strict=True))
    return Margin(below, above, max(here - low, high - here) / (samples - 1), (searched[0], searched[1]))


def _given_by_name(along: Any, at: Mapping[str, Any]) -> str:
    """Return the parameter that varies; ValueError, with the remedy, unless its value is given by name."""
    if not isinstance(along, str):
        raise validate.wrong_type("along", f"must be the name of a parameter, got {validate.short(along)}")
    if along in at or did_you_mean(along, tuple(at)):
        return validate.choice("along", along, at)
    given = f"must be one of {', '.join(map(repr, at))}" if at else "must be an argument that is given by name"
    example = f"{along}=..." if along.isidentifier() else "alpha=0.1, beta=-0.5"
    raise validate.wrong_value(
        "along",
        f"{given}, got {validate.short(along)}{'' if at else ' and no arguments by name'}; give every argument of the "
        f"family by name, with its value where the verdict is, the one that varies too: {example}",
    )


def _first_change(status: Callable[[float], str], own: str, here: float, end: float, samples: int) -> float | None:
    """Return where the status first is another on the way to an end, None where it is not."""
    if here == end:
        return None
    before = here
    for value in np.linspace(here, end, samples)[1:].tolist():
        if status(value) != own:
            return _boundary(status, own, before, value, _ACCURACY * abs(end - here))
        before = value
    return None


def _boundary(status: Callable[[float], str], own: str, inside: float, outside: float, accuracy: float) -> float:
    """Return the boundary between a value of this status and one of another, by bisection."""
    while abs(outside - inside) > accuracy:
        middle = 0.5 * (inside + outside)
        if middle in (inside, outside):
            break
        inside, outside = (middle, outside) if status(middle) == own else (inside, middle)
    return 0.5 * (inside + outside)
