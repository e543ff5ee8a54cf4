"""Many loads judged in portions, between which what was found is shown."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from floquetrod.explorer.background import Stale
from floquetrod.rod.loads.load import Loads
from floquetrod.rod.modes.mode_model import ModeModel

_AT_ONCE = 0.15  # seconds after which what was found is shown (a choice)


def statuses_and_rates(model: ModeModel, loads: Loads) -> tuple[NDArray[np.int8], NDArray[np.float64]]:
    """Return statuses and growth rates in 1/s; -1 and NaN of loads that cannot be judged."""
    try:
        answers = model.answers(loads)
    except ValueError:  # a resonance of axial waves, or too many modes
        if loads.size == 1:
            return np.array([-1], dtype=np.int8), np.array([np.nan])
        each = [statuses_and_rates(model, loads.some(slice(i, i + 1))) for i in range(loads.size)]
        statuses, rates = zip(*each, strict=True)
        return np.concatenate(statuses), np.concatenate(rates)
    return answers.status, answers.growth


def in_portions(
    wanted: NDArray[np.int64], compute: Callable[[NDArray[np.int64]], None], stale: Stale
) -> Iterator[None]:
    """Compute the wanted points in portions, each about as long as a pause that nobody notices; yield after each."""
    at, size = 0, 4
    while at < len(wanted) and not stale():
        began = time.monotonic()
        compute(wanted[at : at + size])
        taken = time.monotonic() - began
        at += size
        yield
        size = int(np.clip(size * _AT_ONCE / max(taken, 1e-3), max(1, size // 2), 2 * size))
