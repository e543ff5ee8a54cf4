"""The motion itself."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floquetrod import _validate
from floquetrod._compile import fastest
from floquetrod._content import ByContent
from floquetrod.equations import FrictionalMathieu, require
from floquetrod.friction.preparation import cells
from floquetrod.kernels import friction as kernels


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(ByContent):
    """A motion from A(0) = 0, A'(0) = epsilon.

    Attributes
    ----------
    equation, epsilon : FrictionalMathieu, float
    tau, A, velocity : ndarray
        Times, A and A', at equal steps and at every stop and release.
    state : ndarray of int8
        1 or -1, the sign of A', where it moves (at a stop: into which it moves off); 0 where it sticks.
    """

    equation: FrictionalMathieu
    epsilon: float
    tau: NDArray[np.float64]
    A: NDArray[np.float64]
    velocity: NDArray[np.float64]
    state: NDArray[np.int8]

    def __repr__(self) -> str:
        """Return what was followed."""
        end = f"A = {self.A[-1]:.6g}, A' = {self.velocity[-1]:.6g}"
        return f"<motion from A' = {self.epsilon:g} over {self.tau[-1] / (2.0 * math.pi):.4g} periods, to {end}>"


def trajectory(equation: FrictionalMathieu, epsilon: float, *, periods: int = 20) -> Trajectory:
    """Return the motion from A(0) = 0, A'(0) = epsilon over whole periods, to rounding.

    It ends before where it outgrows the range of a double.

    Examples
    --------
    >>> motion = trajectory(FrictionalMathieu(alpha=0.0, beta=0.25, gamma=1.0), 1.9)
    >>> int(motion.state[-1]), bool(motion.A[-1] < 4.0)
    (0, True)
    """
    require(equation, (FrictionalMathieu,), "trajectory")
    epsilon = _validate.finite("epsilon", epsilon)
    periods = _validate.integer("periods", periods, 1)
    e = equation
    scale = e.gamma if e.gamma > 0.0 else abs(epsilon)
    table, work = cells(e, 0.0)
    if e.gamma == 0.0:
        table[:, 4:6] = 0.0
    start = np.zeros(7)
    start[1] = abs(epsilon) / scale if scale > 0.0 else 0.0
    most = periods * (2 * len(table) + 40)
    record = np.empty((most + 16, 4))
    run = fastest(kernels.run, most // 1000)
    with np.errstate(over="ignore", invalid="ignore"):
        run(e.alpha, e.beta, e.damping, table, start, most, periods, False, record, work)
        rows = record[: int(np.argmax(np.isinf(record[:, 0])))]
        rows[:, 1:3] *= math.copysign(scale, epsilon)
    rows[:, 3] *= math.copysign(1.0, epsilon)
    rows = rows[: int(np.argmin(np.append(np.isfinite(rows[:, 1:3]).all(axis=1), False)))]
    end = 2.0 * math.pi * periods
    rows = rows[rows[:, 0] <= end * (1.0 + 1e-12)]  # a stick may last beyond
    if rows[-1, 0] < end and rows[-1, 3] == 0.0:
        rows = np.vstack([rows, [end, rows[-1, 1], 0.0, 0.0]])
    tau, a, v, state = (np.ascontiguousarray(column) for column in rows.T)
    return Trajectory(e, epsilon, tau, a, v, state.astype(np.int8))
