"""Shares of runs with a result, with their intervals: of an ensemble along its axes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod._util.probability_interval import clopper_pearson, mean_of_shares
from floquetrod.ensembles.variables import DONE, FAILED, PENDING, Variable
from floquetrod.ensembles.varied_axes import RUN_SEED
from floquetrod.rod.loads.load import LOAD
from floquetrod.simulation.outcome import KINDS, Outcome

RANDOM = ("sample", "run", "seed")
"""Dimensions along which runs are drawn; the values along all others are chosen."""

_BINS = 8  # at most, into which values that are drawn are put (a choice)
_IN_A_BIN = 10  # runs at least (a choice)

_MOVING = [place for place, kind in enumerate(KINDS) if Outcome(kind, 0.0).doubt]
"""Outcomes that a longer run may change."""


class ShareAlong(NamedTuple):
    """The share of runs with a result along one quantity in its SI unit: at points, or in bins from low to high.

    ``lower`` and ``upper`` are the ends of its interval.
    """

    name: str
    unit: str
    value: Floats
    low: Floats
    high: Floats
    share: Floats
    lower: Floats
    upper: Floats


def shares_along(runs: Any, name: str, confidence: Any) -> list[ShareAlong]:
    """Return the share of runs with a result along each quantity that varies, averaged over all others.

    Chosen values are points; drawn values are put into bins of as many runs each.  Empty where nothing is
    drawn.
    """
    dims = runs.variables["status"].dims
    found: list[ShareAlong] = []
    if not any(dim in RANDOM for dim in dims):
        return found
    for dim in dims:
        others = [other for other in dims if other != dim]
        for quantity, variable in runs.coords.items():
            if variable.dims != (dim,) or quantity in ("seed", RUN_SEED) or variable.values.dtype.kind not in "iuf":
                continue
            values = variable.values.astype(float)
            if np.unique(values).size < 2:
                continue
            if dim in RANDOM:
                bins = list(_bins(values))
                probabilities = [probability_of(_part(runs, dim, each), name, dims, confidence) for each in bins]
                ends = [[f(values[each]) for each in bins] for f in (np.median, np.min, np.max)]
            else:
                probabilities = [probability_of(runs, name, others, confidence)]
                ends = [values, values, values]
            columns = [
                np.concatenate([np.atleast_1d(each[column]) for each in probabilities])
                for column in ("probability", "lower", "upper")
            ]
            unit = variable.attrs.get("units", "1")
            found.append(ShareAlong(quantity, unit, *map(np.asarray, ends), *columns))
    return found


def overall(runs: Any, name: str, confidence: float) -> str:
    """Return the share of all runs with a result in words, with its interval unbroken where runs are drawn."""
    dims, done = runs.variables["status"].dims, runs["status"] == DONE
    words = f"{name}: {int((done & (runs[name] == 1)).sum()):,} of {int(done.sum()):,} runs"
    if not any(dim in RANDOM for dim in dims) or not done.any():
        return words
    found = probability_of(runs, name, dims, confidence)
    share, lower, upper = (float(found[end]) for end in ("probability", "lower", "upper"))
    chosen = [LOAD[name].words if name in LOAD else name.replace("_", " ") for name in chosen_quantities(runs)]
    *most, last = chosen or [""]
    averaged = f" on average over {' and '.join(filter(None, [', '.join(most), last]))}" if chosen else ""
    interval = f"{100.0 * confidence:g} % interval {lower:.3f} to {upper:.3f}".replace(" ", "\N{NO-BREAK SPACE}")
    return f"{words}; probability {share:.3f}{averaged}, {interval}"


class SharePlane(NamedTuple):
    """The share of runs with a result over two chosen quantities in their SI units, NaN where none is done.

    ``share`` has a row for each value of ``y``; ``is_drawn`` says whether runs are averaged over.
    """

    names: tuple[str, str]
    units: tuple[str, str]
    x: Floats
    y: Floats
    share: Floats
    is_drawn: bool


class RunsOver(NamedTuple):
    """Every run done over two quantities in their SI units, with its result."""

    names: tuple[str, str]
    units: tuple[str, str]
    x: Floats
    y: Floats
    result: NDArray[np.bool_]


def varied_quantities(runs: Any) -> dict[str, str]:
    """Return every quantity that varies, in their order, each with its dimension; seeds are none."""
    dims = runs.variables["status"].dims
    return {
        name: v.dims[0]
        for name, v in runs.coords.items()
        if len(v.dims) == 1
        and v.dims[0] in dims
        and name not in ("seed", RUN_SEED)
        and v.values.dtype.kind in "iuf"
        and np.unique(v.values).size > 1
    }


def runs_over(runs: Any, name: str, over: Any = None) -> RunsOver | None:
    """Return the runs over two quantities, by default the two that are drawn; None where there are not two of these."""
    varied = varied_quantities(runs)
    if over is None:
        over = [quantity for quantity, dim in varied.items() if dim in RANDOM]
        if len(over) != 2:
            return None
    names = tuple(
        validate.choice("over", each, varied) for each in validate.sequence("over", over, "('length', 'mean')")
    )
    if len(set(names)) != 2 or len(names) != 2:
        raise validate.wrong_value("over", f"must be two quantities that vary, got {validate.short(over)}")
    dims, done = runs.variables["status"].dims, runs["status"] == DONE

    def at_runs(quantity: str) -> Floats:
        values = runs[quantity].astype(float).reshape([-1 if dim == varied[quantity] else 1 for dim in dims])
        return np.asarray(np.broadcast_to(values, done.shape)[done])

    first, second = names
    units = runs.units[first], runs.units[second]
    return RunsOver((first, second), units, at_runs(first), at_runs(second), runs[name][done] == 1)


def chosen_quantities(runs: Any) -> dict[str, str]:
    """Return the chosen quantities that vary, in their order, each with its dimension."""
    chosen: dict[str, str] = {}
    for dim in runs.variables["status"].dims:
        if dim not in RANDOM:
            named = (name for name, v in runs.coords.items() if v.dims == (dim,) and v.values.dtype.kind in "iuf")
            chosen |= {name: dim for name in named if np.unique(runs[name]).size > 1}
    return chosen


def share_over(runs: Any, name: str) -> SharePlane | None:
    """Return the share of runs with a result over the two chosen quantities; None where there are not two."""
    chosen = chosen_quantities(runs)
    if len(chosen) != 2 or len(set(chosen.values())) != 2:
        return None
    (first, along), (second, up) = chosen.items()
    dims, done = runs.variables["status"].dims, runs["status"] == DONE
    averaged = tuple(i for i, dim in enumerate(dims) if dim not in (along, up))
    counts = done.sum(axis=averaged)
    share = np.where(counts, (done & (runs[name] == 1)).sum(axis=averaged) / np.maximum(counts, 1), np.nan)
    units = runs.units
    order_x, order_y = np.argsort(runs[first]), np.argsort(runs[second])
    share = (share.T if dims.index(along) < dims.index(up) else share)[np.ix_(order_y, order_x)]
    x, y = (np.sort(runs[each].astype(float)) for each in (first, second))
    return SharePlane((first, second), (units[first], units[second]), x, y, share, any(d in RANDOM for d in dims))


def _bins(values: Floats) -> Iterator[NDArray[np.intp]]:
    """Yield the places of values in bins of as many each, the smallest values first."""
    number = int(np.clip(values.size // _IN_A_BIN, 1, _BINS))
    yield from np.array_split(np.argsort(values, kind="stable"), number)


def _part(runs: Any, dim: str, places: NDArray[np.intp]) -> Any:
    """Return the runs at some places of a dimension."""

    def taken(of: dict[str, Variable]) -> dict[str, Variable]:
        return {
            name: v._replace(values=v.values.take(places, axis=v.dims.index(dim))) if dim in v.dims else v
            for name, v in of.items()
        }

    return type(runs)(taken(runs.variables), taken(runs.coords), runs.attrs)


def probability_of(runs: Any, name: str, over: Any, confidence: Any) -> Any:
    """Return what `probability` does for `Runs`, without its warnings."""
    # The share of runs that are true, over some dimensions, by groups of runs that do not depend on one another: true,
    # finished and lost are numbers (rows, groups), a row for each place of the dimensions left.  Runs that failed, or
    # are still to be done along a dimension of chosen values, may have either result: the interval covers both.  Where
    # each run is a group of its own the interval is that of Clopper and Pearson (Biometrika 26 (1934) 404,
    # doi:10.1093/biomet/26.4.404), else that of means of groups.
    confidence = validate.confidence(confidence)
    for needed in ("status", validate.choice("name", name, runs.variables)):
        if needed not in runs.variables:
            raise validate.wrong_value(
                "runs", f"must hold {needed}, as fr.ensemble returns them; got {', '.join(runs.variables)}"
            )
    dims = runs.variables["status"].dims
    if runs.variables[name].dims != dims:
        raise validate.wrong_value(
            "name", f"must be a result of every run, got {name!r}, which has {runs.variables[name].dims}"
        )
    averaged = [over] if isinstance(over, str) else validate.sequence("over", over, "('seed',)")
    places = tuple(sorted({dims.index(_dimension(runs, dims, dim)) for dim in averaged}))
    if not places:
        raise validate.wrong_value("over", f"must name at least one of {', '.join(dims)}, got none")
    status, values = runs["status"], runs[name]
    done = status == DONE
    if not np.isin(values[done], (0, 1)).all():
        raise validate.wrong_value(
            "name", f"must be a result that is true or false, 1 or 0, got {name!r}; compare it with a number"
        )
    left = tuple(dim for place, dim in enumerate(dims) if place not in places)
    group = _groups(runs, dims, places)
    order = [dims.index(dim) for dim in left] + list(places)
    shape = tuple(status.shape[dims.index(dim)] for dim in left)

    def by_group(of: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Return numbers of runs, (..., groups)."""
        flat = of.transpose(order).reshape(math.prod(shape), -1)
        counts = np.zeros((int(group.max(initial=-1)) + 1, len(flat)), dtype=np.int64)
        np.add.at(counts, group, flat.T)
        return counts.T

    true, finished, lost = by_group(done & (values == 1)), by_group(done), by_group(status == FAILED)
    chosen = any(dims[place] not in RANDOM for place in places)
    unknown = lost + by_group(status == PENDING) if chosen else lost

    def ends(finished: NDArray[np.int64], unknown: NDArray[np.int64]) -> Any:
        """Return both ends of the interval for every row."""
        if group.size == true.shape[1]:  # every run is a group
            return clopper_pearson(
                true.sum(axis=1), (finished + unknown).sum(axis=1), confidence, unknown=unknown.sum(axis=1)
            )
        rows = [_interval(*counts, confidence) for counts in zip(true, finished, unknown, strict=True)]
        return np.array(rows).reshape(-1, 2).T

    lower, upper = ends(finished, unknown)
    share = np.full(len(true), np.nan)
    for row in np.flatnonzero(finished.any(axis=1)):
        some = finished[row] > 0
        share[row] = np.mean(true[row, some] / finished[row, some])

    def variable(values: Any, text: str) -> Variable:
        return Variable(left, np.reshape(values, shape), {"long_name": text, "units": "1"})

    percent = f"{100.0 * confidence:g} % confidence"
    more = {}
    if name == "buckled" and "outcome" in runs.variables:
        moving = by_group(done & (values != 1) & np.isin(runs["outcome"], _MOVING))
        _, highest = ends(finished - moving, unknown + moving)
        more = {
            "moving": variable(moving.sum(axis=1), "runs not buckled, but still moving beyond 5 degrees at their end"),
            "upper_moving": variable(highest, f"upper end of the interval of {percent} if these runs buckle too"),
        }
    return type(runs)(
        {
            "probability": variable(share, f"share of runs with {name} among those done"),
            "lower": variable(lower, f"lower end of the interval of {percent}"),
            "upper": variable(upper, f"upper end of the interval of {percent}"),
            "done": variable(finished.sum(axis=1), "runs done"),
            "failed": variable(lost.sum(axis=1), "runs that failed"),
            **more,
        },
        {key: v for key, v in runs.coords.items() if set(v.dims) <= set(left)},
        {**runs.attrs, "result": name, "confidence": confidence},
    )


def _dimension(runs: Any, dims: tuple[str, ...], name: Any) -> str:
    """Return the name of a dimension of the runs; ValueError for another."""
    if name in dims:
        return str(name)
    drawn = [dim for dim in dims if dim in RANDOM] or [*dims]
    remedy = f"give over={drawn[0]!r}"
    if name in runs.coords:
        along = ", ".join(runs.coords[name].dims)
        remedy = f"which varies along {along}; {remedy}"
    raise validate.wrong_value(
        "over", f"must name a dimension of these runs, {', '.join(dims)}, got {validate.short(name)}; {remedy}"
    )


def _groups(runs: Any, dims: tuple[str, ...], places: tuple[int, ...]) -> NDArray[np.int64]:
    """Return to which group each run averaged over belongs, in the order of the dimensions; groups are independent.

    ``places`` are the indices of the dimensions averaged over.  Raises ValueError where there are no such groups.
    """
    averaged = [dims[place] for place in places]
    drawn = [dim for dim in RANDOM if dim in averaged]
    if not drawn:
        raise validate.wrong_value(
            "over",
            f"must name a dimension along which runs are drawn, got {', '.join(averaged)}, whose values are chosen; "
            f"{_drawn_remedy([dim for dim in dims if dim in RANDOM])}",
        )
    if len(drawn) > 1 and RUN_SEED not in runs.coords:
        raise validate.wrong_value(
            "over",
            f"names {' and '.join(drawn)}, but all samples have the same seeds, as in ensembles of earlier versions: "
            "their runs are not independent; average over one of them, or simulate again",
        )
    lengths = [runs["status"].shape[place] for place in places]
    number = np.indices(lengths)[averaged.index(drawn[0])].ravel()
    seeds = runs.coords.get("seed")
    if drawn == ["run"] and seeds is not None:
        _, number = np.unique(seeds.values, return_inverse=True)
    return np.asarray(number, dtype=np.int64)


def _drawn_remedy(drawn: list[str]) -> str:
    """Return what to give in place of dimensions of chosen values, where runs have ``drawn`` ones, and where not."""
    if drawn:
        return f"add {drawn[0]}, as in over=({drawn[0]!r}, ...)"
    return (
        "these runs have none: vary the seed, or where you drew the values yourself give them as a list, "
        'layout="list", or as a distribution'
    )


def _interval(
    true: NDArray[np.int64], finished: NDArray[np.int64], unknown: NDArray[np.int64], confidence: float
) -> tuple[float, float]:
    """Return the interval of a probability from the numbers of runs in each group."""
    runs = finished + unknown
    some = runs > 0
    return mean_of_shares(true[some] / runs[some], (true + unknown)[some] / runs[some], confidence)
