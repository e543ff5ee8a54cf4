"""Probabilities over the runs of an ensemble, with confidence intervals."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import Any

from floquetrod._util.calling import level_of_caller
from floquetrod.ensembles.outcome_warnings import OutcomeWarning, doubts
from floquetrod.ensembles.runs import Runs, require_runs
from floquetrod.ensembles.shares import probability_of


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
        as true at the upper; pending ones do not count.  For ``buckled`` also ``moving``, the number of runs that
        did not count as buckled but still moved beyond 5 degrees at their end, and ``upper_moving``, the upper end of
        the interval if they buckle too.

    Warns
    -----
    OutcomeWarning
        For ``buckled``, where runs were still moving beyond 5 degrees at their end and did not count as buckled,
        where all runs of a cell are identical, and where some buckled under a load that theory calls stable.

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
    >>> import numpy as np
    >>> from floquetrod.ensembles.variables import Variable
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
