"""Probabilities over the runs of an ensemble, with confidence intervals."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.calling import level_of_caller
from floquetrod._util.probability_interval import clopper_pearson, mean_of_shares
from floquetrod.ensembles.outcome_warnings import OutcomeWarning, doubts
from floquetrod.ensembles.runs import DONE, FAILED, PENDING, Runs, Variable, require_runs
from floquetrod.ensembles.varied_axes import RUN_SEED

RANDOM = ("sample", "run", "seed")
"""Dimensions along which runs are drawn; the values along all others are chosen."""


def probability(runs: Any, name: str = "buckled", *, over: str | Iterable[str], confidence: float = 0.95) -> Any:
    """Return the probability of a result, with its confidence interval, along the axes not averaged over.

    Parameters
    ----------
    runs : xarray.Dataset or Runs
        The result of `floquetrod.ensemble`.
    name : str
        A result that is true or false, or 1 or 0.
    over : str or several
        Dimensions to average over, at least one along which runs are drawn: "seed", "sample", "run".
    confidence : float
        Of the interval, between 0 and 1.

    Returns
    -------
    the same kind as ``runs``
        ``probability``, the share of true results among the runs done, NaN where none is; ``lower`` and ``upper``,
        its interval; ``done`` and ``failed``, numbers of runs.  Those that failed count as false at the lower end and
        as true at the upper; pending ones do not count.

    Warns
    -----
    OutcomeWarning
        For ``buckled``, where runs were still moving beyond 5 degrees at their end and did not count as buckled, and
        where some buckled under a load that theory calls stable.

    Notes
    -----
    Over one dimension of draws runs are independent, and the interval is Clopper and Pearson's, whose coverage is
    at least ``confidence``.  Over several dimensions runs that share a draw are not: the runs of one sample, of one
    seed at several chosen values, of one seed in a list.  Such a group counts as one number, its share of true
    results; ``probability`` is the mean of these shares, and the interval Gaffke's
    (`floquetrod._util.probability_interval.mean_of_shares`), which is Clopper and Pearson's where groups have one run.
    Where chosen values are averaged over, their pending runs count as failed ones.

    Raises
    ------
    TypeError, ValueError
        For a result or a dimension that there is not, for results neither true nor false, for dimensions
        all of chosen values, and for samples with seeds in common, as in earlier versions.

    Examples
    --------
    >>> status = Variable(("seed",), np.array([1, 1, 1, 2]), {})
    >>> buckled = Variable(("seed",), np.array([True, False, False, False]), {})
    >>> found = probability(Runs({"status": status, "buckled": buckled}, {}, {}), over="seed")
    >>> round(float(found["probability"]), 3), round(float(found["lower"]), 3), round(float(found["upper"]), 3)
    (0.333, 0.006, 0.932)
    """
    checked = require_runs("runs", runs)
    answer = probability_of(checked, name, over, confidence)
    for text in doubts(checked) if name == "buckled" else []:
        warnings.warn(text, OutcomeWarning, stacklevel=level_of_caller())
    return answer if isinstance(runs, Runs) else answer.to_xarray()


def probability_of(runs: Runs, name: str, over: Any, confidence: Any) -> Runs:
    """Return what `probability` does for `Runs`, without its warnings."""
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
    places = tuple(sorted({dims.index(validate.choice("over", dim, dims)) for dim in averaged}))
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
    if group.size == true.shape[1]:  # every run is a group
        lower, upper = clopper_pearson(
            true.sum(axis=1), (finished + unknown).sum(axis=1), confidence, unknown=unknown.sum(axis=1)
        )
    else:
        lower, upper = (
            np.array([_interval(*counts, confidence) for counts in zip(true, finished, unknown, strict=True)])
            .reshape(-1, 2)
            .T
        )
    share = np.full(len(true), np.nan)
    for row in np.flatnonzero(finished.any(axis=1)):
        some = finished[row] > 0
        share[row] = np.mean(true[row, some] / finished[row, some])

    def variable(values: Any, text: str) -> Variable:
        return Variable(left, np.reshape(values, shape), {"long_name": text, "units": "1"})

    percent = f"{100.0 * confidence:g} % confidence"
    return Runs(
        {
            "probability": variable(share, f"share of runs with {name} among those done"),
            "lower": variable(lower, f"lower end of the interval of {percent}"),
            "upper": variable(upper, f"upper end of the interval of {percent}"),
            "done": variable(finished.sum(axis=1), "runs done"),
            "failed": variable(lost.sum(axis=1), "runs that failed"),
        },
        {key: v for key, v in runs.coords.items() if set(v.dims) <= set(left)},
        {**runs.attrs, "result": name, "confidence": confidence},
    )


def _groups(runs: Runs, dims: tuple[str, ...], places: tuple[int, ...]) -> NDArray[np.int64]:
    """Return to which group each run averaged over belongs, in the order of the dimensions; groups are independent.

    ``places`` are the indices of the dimensions averaged over.  Raises ValueError where there are no such groups.
    """
    averaged = [dims[place] for place in places]
    drawn = [dim for dim in RANDOM if dim in averaged]
    if not drawn:
        raise validate.wrong_value(
            "over",
            f"must name a dimension along which runs are drawn, {', '.join(RANDOM)}, got {', '.join(averaged)}, whose "
            'values are chosen; where you drew them yourself give them as a list, layout="list", or as a distribution',
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


def _interval(
    true: NDArray[np.int64], finished: NDArray[np.int64], unknown: NDArray[np.int64], confidence: float
) -> tuple[float, float]:
    """Return the interval of a probability from the numbers of runs in each group."""
    runs = finished + unknown
    some = runs > 0
    return mean_of_shares(true[some] / runs[some], (true + unknown)[some] / runs[some], confidence)
