"""The motion itself."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.compilation import runner
from floquetrod._util.content import ByContent
from floquetrod.equations import FrictionalMathieu, require
from floquetrod.friction.inputs import SHORT, prepare_one
from floquetrod.kernels import friction as kernels

_MOST = 5_000_000  # rows of a record (a choice: 160 MB, a second or two)
_HARD = 1e100  # kick over friction at which friction is lost in rounding: what follows a motion without any


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(ByContent):
    """A motion from A(0) = 0, A'(0) = kick.

    Attributes
    ----------
    equation, kick : FrictionalMathieu, float
    tau, A, velocity : ndarray
        Times, A and A', at equal steps and at every stop and release.
    state : ndarray of int8
        1 or -1, the sign of A', where it moves (at a stop: into which it moves off); 0 where it sticks.
    """

    equation: FrictionalMathieu
    kick: float
    tau: NDArray[np.float64]
    A: NDArray[np.float64]
    velocity: NDArray[np.float64]
    state: NDArray[np.int8]

    def __repr__(self) -> str:
        """Return what was followed."""
        end = f"A = {self.A[-1]:.6g}, A' = {self.velocity[-1]:.6g}"
        return f"<motion from A' = {self.kick:g} over {self.tau[-1] / (2.0 * math.pi):.4g} periods, to {end}>"


def trajectory(equation: FrictionalMathieu, kick: float, *, periods: int = 20) -> Trajectory:
    """Return the motion from A(0) = 0, A'(0) = kick over whole periods, to rounding.

    It ends before where it outgrows the range of a double.

    Examples
    --------
    >>> motion = trajectory(FrictionalMathieu(alpha=0.0, beta=0.25, gamma=1.0), 1.9)
    >>> int(motion.state[-1]), bool(motion.A[-1] < 4.0)
    (0, True)
    """
    require(equation, (FrictionalMathieu,), "trajectory")
    kick = validate.finite("kick", kick)
    periods = validate.integer("periods", periods, 1)
    e = equation
    _, table, basis, _ = prepare_one(e, 0.0).cells
    most = periods * (2 * len(table) + 40)
    if most > _MOST:
        raise ValueError(
            f"periods must be at most {_MOST // (2 * len(table) + 40)} for this equation, got {periods}: "
            f"the record would have up to {most} rows; friction.fate decides about all time"
        )
    start = np.zeros(8)
    with np.errstate(over="ignore"):
        start[1] = abs(kick) / e.gamma if e.gamma > 0.0 else _HARD if kick != 0.0 else 0.0
    scale, more = (e.gamma, 1.0) if e.gamma > 0.0 else (abs(kick), 1.0 / _HARD)
    start[7] = periods
    record = np.empty((most + 16, 4))
    run = runner(kernels.run, most, interpret_up_to=SHORT)
    with np.errstate(over="ignore", invalid="ignore"):
        none, work = np.full(kernels.TRAP, -1.0), kernels.workspace()
        run(e.alpha, e.beta, e.damping, table, basis, start, most, False, record, none, work)
        rows = record[: int(np.argmax(np.isinf(record[:, 0])))]
        rows[:, 1:3] *= more
        rows[:, 1:3] *= math.copysign(scale, kick)
    rows[:, 3] *= math.copysign(1.0, kick)
    rows = rows[: int(np.argmin(np.append(np.isfinite(rows[:, 1:3]).all(axis=1), False)))]
    end = 2.0 * math.pi * periods
    rows = rows[rows[:, 0] <= end * (1.0 + 1e-12)]  # a stick may last beyond
    if rows[-1, 0] < end and rows[-1, 3] == 0.0:
        rows = np.vstack([rows, [end, rows[-1, 1], 0.0, 0.0]])
    tau, a, v, state = (np.ascontiguousarray(column) for column in rows.T)
    return Trajectory(e, kick, tau, a, v, state.astype(np.int8))
