"""How far an equation or a system is from a change of its verdict, along a parameter."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Bools, Floats
from floquetrod._util.suggest import did_you_mean
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.first_change import FirstChange, first_change
from floquetrod.floquet.problems import require_problem

_ACCURACY = 1e-10  # of a boundary, relative to what was searched (a choice)
_DIGITS = 9  # of a distance without an estimated error (a choice)
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
        Distances below and above up to which was searched; the distance of a change.
    errors : (float, float)
        Of ``below`` and ``above``: up to this much farther the verdict may be undecided.  NaN where a distance is
        infinite, and where the error is not estimated.

    Comparing compares the distances.
    """

    resolution: float
    searched: tuple[float, float]
    errors: tuple[float, float]

    def __new__(
        cls,
        below: float,
        above: float,
        resolution: float = 0.0,
        searched: tuple[float, float] | None = None,
        errors: tuple[float, float] = (math.nan, math.nan),
    ) -> Margin:
        """Return a pair of distances with their errors, the resolution and the ends of the search."""
        margin = super().__new__(cls, below, above)
        margin.resolution, margin.searched = resolution, (below, above) if searched is None else searched
        margin.errors = errors
        return margin

    @classmethod
    def between(cls, below: FirstChange, above: FirstChange, here: float) -> Margin:
        """Return the margin at a value from the searches below and above it."""
        fall, rise = (math.inf if end.at is None else abs(end.at - here) for end in (below, above))
        searched = abs(below.searched - here), abs(above.searched - here)
        return cls(fall, rise, max(below.resolution, above.resolution), searched, (below.error, above.error))

    def __repr__(self) -> str:
        """Return the distances to the digits that are certain, how far was searched, and in which steps."""
        below, above = (_distance(*end) for end in zip(self, self.errors, strict=True))
        sides = zip(self, self.searched, ("below", "above"), strict=True)
        ends = [f"{reach:.6g} {side}" for distance, reach, side in sides if math.isinf(distance)]
        searched = f"searched {'up to ' if ends else ''}{' and '.join(ends)}{' ' if ends else ''}"
        steps = f"in steps of {self.resolution:.3g}" if self.resolution else "without gaps"
        return f"Margin(below={below}, above={above}, {searched}{steps})"

    def _asdict(self) -> dict[str, Any]:
        """Return the distances for JSON, with all that is known of the search."""
        named = {name: getattr(self, name) for name in ("resolution", "searched", "errors")}
        return super()._asdict() | named

    @property
    def nearest(self) -> float:
        """The smaller of the two distances."""
        return min(self)


def _distance(distance: float, error: float) -> str:
    """Return a distance to the last digit that its error leaves."""
    if not 0.0 < error < distance < math.inf:
        return f"{distance:.{_DIGITS}g}"
    return f"{distance:.{max(0, -math.ceil(math.log10(error)))}f}"


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
        Ends of the range searched; the value in ``at`` lies between them.
    samples : int
        Verdicts on either side, 2 to 100,000: a change and its reverse between two of them are passed over, as a narrow
        stable band in an unstable range is.  More find narrower bands, and take as much longer.
    **at
        Arguments of the family at which the verdict is, all of them.

    Returns
    -------
    Margin
        The nearest change met on either side, its ``resolution`` the larger distance of samples.  The ``errors`` are
        1e-10 of the range searched, or the width in which the verdict is undecided where this is more.

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
        return str(stability(problem).status)

    own = status(here)
    if own == "undecided":
        raise ValueError(f"{along} must be where the verdict is known, got {here:g}, which is on a boundary")
    below, above = (status_change(status, own, (here, end), samples) for end in (low, high))
    return Margin.between(below, above, here)


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


def status_change(status: Callable[[float], str], own: str, piece: tuple[float, float], samples: int) -> FirstChange:
    """Return where the status first is another from ``piece[0]`` to ``piece[1]``, one sample at a time."""
    here, end = piece
    step = abs(end - here) / (samples - 1)
    if here == end:
        return FirstChange(None, end, step)
    accuracy = _ACCURACY * abs(end - here)

    def blocks() -> Iterator[tuple[Floats, Bools]]:
        for before, value in pairwise(np.linspace(here, end, samples).tolist()):
            yield np.array([before, value]), np.array([True, status(value) == own])

    def locate(inside: Floats, outside: Floats) -> Floats:
        return np.array([_boundary(status, own, float(inside[0]), float(outside[0]), accuracy)])

    change = first_change(blocks(), True, locate, piece, step)
    return change if change.at is None else change._replace(error=_undecided(status, change.at, end, accuracy))


def _undecided(status: Callable[[float], str], at: float, end: float, accuracy: float) -> float:
    """Return how far beyond a change the verdict may be undecided, ``accuracy`` at least."""
    apart = accuracy
    while apart < abs(end - at):
        if status(at + math.copysign(apart, end - at)) != "undecided":
            return apart
        apart *= 4.0
    return max(abs(end - at), accuracy)


def _boundary(status: Callable[[float], str], own: str, inside: float, outside: float, accuracy: float) -> float:
    """Return the boundary between a value of this status and one of another, by bisection."""
    while abs(outside - inside) > accuracy:
        middle = 0.5 * (inside + outside)
        if middle in (inside, outside):
            break
        inside, outside = (middle, outside) if status(middle) == own else (inside, middle)
    return 0.5 * (inside + outside)
