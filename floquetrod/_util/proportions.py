"""Proportions of samples, with their confidence intervals."""

from __future__ import annotations

from typing import Any

import numpy as np

from floquetrod._util.arrays import Floats


def clopper_pearson(hits: Any, samples: Any, confidence: float, unknown: Any = 0) -> tuple[Floats, Floats]:
    """Return the ends of the interval of a proportion by Clopper and Pearson, of a coverage of ``confidence`` at least.

    Samples of an ``unknown`` outcome are among ``samples``; they are no hits at the lower end, and hits at the upper.
    """
    from scipy.stats import beta

    level, most = 0.5 * (1.0 - confidence), hits + unknown
    # As parameters of the beta distribution must be positive, the ends of the range are put in afterwards.
    low = np.where(hits > 0, beta.ppf(level, np.maximum(hits, 1), samples - hits + 1), 0.0)
    high = np.where(most < samples, beta.isf(level, most + 1, np.maximum(samples - most, 1)), 1.0)
    return low, high
