"""Probabilities over the runs of an ensemble, with confidence intervals."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.proportions import clopper_pearson
from floquetrod.ensembles.runs import DONE, FAILED, Runs, Variable, require_runs


def probability(runs: Any, name: str = "buckled", *, over: str | Iterable[str], confidence: float = 0.95) -> Any:
    """Return the probability of a result, with its confidence interval, along the axes that are not averaged.

    Parameters
    ----------
    runs : xarray.Dataset or Runs
        The result of `floquetrod.ensemble`.
    name : str
        A result that is true or false, or 1 or 0.
    over : str or several
        Dimensions along which runs are independent samples: "seed", "sample", "run".
    confidence : float
        Of the interval, between 0 and 1.

    Returns
    -------
    the same kind as ``runs``
        ``probability``, the share of runs that are true among those done, NaN where none is; ``lower`` and ``upper``,
        the interval by Clopper and Pearson, whose coverage is at least ``confidence``; ``done`` and ``failed``, numbers
        of runs.  Those that failed count as false at the lower end and as true at the upper; pending ones do not count.

    Raises
    ------
    TypeError, ValueError
        For a result or a dimension that there is not, and for results that are neither true nor false.

    Examples
    --------
    >>> status = Variable(("seed",), np.array([1, 1, 1, 2]), {})
    >>> buckled = Variable(("seed",), np.array([True, False, False, False]), {})
    >>> found = probability(Runs({"status": status, "buckled": buckled}, {}, {}), over="seed")
    >>> round(float(found["probability"]), 3), round(float(found["lower"]), 3), round(float(found["upper"]), 3)
    (0.333, 0.006, 0.932)
    """
    found = require_runs("runs", runs)
    confidence = validate.confidence(confidence)
    for needed in ("status", validate.choice("name", name, found.variables)):
        if needed not in found.variables:
            raise validate.wrong_value(
                "runs", f"must hold {needed}, as fr.ensemble returns them; got {', '.join(found.variables)}"
            )
    dims = found.variables["status"].dims
    if found.variables[name].dims != dims:
        raise validate.wrong_value(
            "name", f"must be a result of every run, got {name!r}, which has {found.variables[name].dims}"
        )
    averaged = [over] if isinstance(over, str) else validate.sequence("over", over, "('seed',)")
    places = tuple(sorted({dims.index(validate.choice("over", dim, dims)) for dim in averaged}))
    if not places:
        raise validate.wrong_value("over", f"must name at least one of {', '.join(dims)}, got none")
    status, values = found["status"], found[name]
    done = status == DONE
    if not np.isin(values[done], (0, 1)).all():
        raise validate.wrong_value(
            "name", f"must be a result that is true or false, 1 or 0, got {name!r}; compare it with a number"
        )
    left = tuple(dim for place, dim in enumerate(dims) if place not in places)
    counts = done.sum(axis=places)
    failed = (status == FAILED).sum(axis=places)
    true = (done & (values == 1)).sum(axis=places)
    lower, upper = clopper_pearson(true, counts + failed, confidence, unknown=failed)
    with np.errstate(invalid="ignore"):
        share = np.where(counts > 0, true / np.maximum(counts, 1), np.nan)

    def variable(values: Any, text: str) -> Variable:
        return Variable(left, np.asarray(values), {"long_name": text, "units": "1"})

    percent = f"{100.0 * confidence:g} % confidence"
    answer = Runs(
        {
            "probability": variable(share, f"share of runs with {name} among those done"),
            "lower": variable(lower, f"lower end of the interval of {percent}"),
            "upper": variable(upper, f"upper end of the interval of {percent}"),
            "done": variable(counts, "runs done"),
            "failed": variable(failed, "runs that failed"),
        },
        {key: v for key, v in found.coords.items() if set(v.dims) <= set(left)},
        {**found.attrs, "result": name, "confidence": confidence},
    )
    return answer if isinstance(runs, Runs) else answer.to_xarray()
