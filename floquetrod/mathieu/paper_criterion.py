"""The paper's test as a criterion for charts: has the motion grown a million times in 100 periods?"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import broadcast, shaped
from floquetrod._util.calling import constructor_hints
from floquetrod._util.compilation import over_chunks
from floquetrod.floquet.kernels.leapfrog_map import leapfrog_map_fill
from floquetrod.floquet.kernels.powers import displacement_fill
from floquetrod.floquet.kernels.taylor import mathieu_map_fill

_CHUNK = 256  # points a thread takes at a time: each costs microseconds, by leapfrog a tenth of a millisecond


@constructor_hints()
@dataclass(frozen=True)
class FiniteTimeCriterion:
    """Stable when abs(A(end)) / A'(0) stays below a limit after a number of periods, from A(0) = 0.

    Parameters
    ----------
    periods : int
        Periods of 2 pi examined.
    limit : float
        Growth that counts as instability.
    by : {"exact", "leapfrog"}
        "exact" carries the motion with the map over a period to rounding, that is with the equation's own growth and
        phase; "leapfrog" with the map of the paper's scheme.
    step : float
        Longest step in tau of the leapfrog.

    Raises
    ------
    TypeError, ValueError
        For fewer periods than 1, a limit of 1 or less, a step that is not positive, and another ``by``.

    Notes
    -----
    Eq. (6) and section 3.2 of DOI 10.1115/1.4031710.  The scheme is linear and its coefficient periodic, so that its
    map over one period, raised to a power, ends where stepping through all periods would.

    The test is not a verdict on stability: growth below about ``threshold`` per unit tau passes it.  "About", because
    the motion ends at K exp(growth time), where K depends on the phase; `floquetrod.stability` decides for all time.

    Examples
    --------
    >>> FiniteTimeCriterion().is_stable([0.03, 0.1], -0.25)
    array([ True, False])
    """

    periods: int = 100
    limit: float = 1e6
    by: str = "exact"
    step: float = 5e-4

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        object.__setattr__(self, "periods", validate.integer("periods", self.periods, 1))
        object.__setattr__(self, "limit", validate.positive("limit", self.limit))
        if self.limit <= 1.0:
            raise ValueError(f"limit must be greater than 1, got {self.limit!r}: a bounded motion already reaches 1")
        object.__setattr__(self, "by", validate.choice("by", self.by, ("exact", "leapfrog")))
        object.__setattr__(self, "step", validate.within("step", self.step, 1e-6, 0.5))

    @property
    def threshold(self) -> float:
        """Growth per unit tau that reaches the limit in the time given, if it starts from 1."""
        return math.log(self.limit) / (2.0 * math.pi * self.periods)

    def require_alone(self, **others: float) -> None:
        """Raise ValueError unless every other criterion is zero."""
        for name, value in others.items():
            if value != 0.0:
                raise ValueError(f"{name} must be 0 with a criterion, got {value!r}: each says what counts as stable")

    def __str__(self) -> str:
        """Say what passes."""
        carried = "exactly" if self.by == "exact" else f"by leapfrog of step {self.step:g}"
        return f"stable means growth below {self.limit:g} in {self.periods} periods, computed {carried}"

    def growth(self, alpha: Any, beta: Any, damping: Any = 0.0, *, workers: int | None = None) -> Any:
        """Return log10 of abs(A(end)) / A'(0) for Mathieu's equation; arguments broadcast as in `mathieu.is_stable`.

        Returns
        -------
        float or ndarray of float
            In the broadcast shape.

        Raises
        ------
        TypeError, ValueError
            As `mathieu.is_stable`.
        """
        shape, inputs = broadcast(
            alpha=validate.array("alpha", alpha),
            beta=validate.array("beta", beta),
            damping=validate.array("damping", damping, least=0.0, largest=validate.LARGEST_DAMPING),
        )
        maps = np.empty((inputs[0].size, 5))
        if self.by == "exact":
            few = int(6.0 / (1.0 + 1e-2 * math.sqrt(max(np.abs(part).max(initial=0.0) for part in inputs[:2]))))
            over_chunks(mathieu_map_fill, inputs, maps, workers=workers, chunk=_CHUNK, interpret_up_to=few)
        else:
            count = 4 * math.ceil(0.5 * math.pi / self.step)
            sine = np.sin(np.arange(count) * (2.0 * math.pi / count))
            over_chunks(
                leapfrog_map_fill, inputs, maps, sine, 2.0 * math.pi, workers=workers, chunk=_CHUNK, interpret_up_to=0
            )
        out = np.empty(len(maps))
        over_chunks(displacement_fill, (maps,), out, self.periods, workers=workers)
        return shaped(out, shape)

    def is_stable(self, alpha: Any, beta: Any, damping: Any = 0.0, *, workers: int | None = None) -> Any:
        """Return whether the motion passes the test; arguments as in `growth`.

        Returns
        -------
        bool or ndarray of bool
            In the broadcast shape.

        Raises
        ------
        TypeError, ValueError
            As `growth`.
        """
        return self.growth(alpha, beta, damping, workers=workers) < math.log10(self.limit)
