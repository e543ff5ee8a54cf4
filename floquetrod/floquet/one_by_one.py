"""Verdicts on several problems, one after another."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.verdict import tolerated


def verdicts(problems: Sequence[Any], growth_tolerance: float) -> tuple[NDArray[np.int8], NDArray[np.float64]]:
    """Return 1 where stable, 0 where not and -1 where undecided, and the growth rates.

    Growth up to the tolerance counts as stable.
    """
    importlib.import_module("numba")  # once it is loaded, scalar methods run as machine code
    status, rate = np.empty(len(problems), dtype=np.int8), np.empty(len(problems))
    for i, problem in enumerate(problems):
        result = stability(problem)
        rate[i] = result.growth_rate
        stable = result.status == "stable" or tolerated(result.growth_rate, growth_tolerance)
        status[i] = -1 if result.status == "undecided" else stable
    return status, rate
