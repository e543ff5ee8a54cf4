"""The motion after a kick, as arrays."""

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
from floquetrod.friction.kernels import stick_slip_motion as kernels
from floquetrod.friction.kernels.records import ORBIT, SAMPLE, workspace

_MOST = 5_000_000  # rows of a record: 160 MB, a second or two
_HARD = 1e100  # kick over friction at which friction is lost in rounding: the motion recorded is that without friction


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(ByContent):
    """A motion from A(0) = 0, A'(0) = kick.

    Attributes
    ----------
    equation : FrictionalMathieu
        The equation solved.
    kick : float
        The initial velocity.
    tau : ndarray
        Times, at equal steps and at every stop and release.
    A : ndarray
        Displacement at these times.
    velocity : ndarray
        A' at these times.
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
        """Return the equation, the kick and the time followed."""
        end = f"A = {self.A[-1]:.6g}, A' = {self.velocity[-1]:.6g}"
        return f"<motion from A' = {self.kick:g} over {self.tau[-1] / (2.0 * math.pi):.4g} periods, to {end}>"


def trajectory(equation: FrictionalMathieu, kick: float, *, periods: int = 20) -> Trajectory:
    """Return the motion from A(0) = 0, A'(0) = kick over whole periods, to rounding.

    It ends early where it would exceed the range of a double.

    Parameters
    ----------
    periods : int
        Periods 2 pi of the coefficient followed, 1 or more.

    Returns
    -------
    Trajectory
        ``tau``, ``A`` and ``velocity``, at equal steps and at every stop and release.

    Raises
    ------
    TypeError, ValueError
        For another equation, a kick that is not finite, and for more periods than a record can hold.

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
    prepared = prepare_one(e, 0.0)
    _, cells, bases, _ = prepared.propagators
    most = periods * (2 * len(cells) + 40)
    if most > _MOST:
        raise validate.wrong_value(
            "periods",
            f"must be at most {_MOST // (2 * len(cells) + 40)} for this equation, got {periods}: "
            f"the record would have up to {most} rows; friction.fate decides about all time",
        )
    orbit, findings = np.zeros(1, ORBIT)[0], prepared.no_findings()[0]
    with np.errstate(over="ignore"):
        orbit["velocity"] = abs(kick) / e.gamma if e.gamma > 0.0 else _HARD if kick != 0.0 else 0.0
    scale, more = (e.gamma, 1.0) if e.gamma > 0.0 else (abs(kick), 1.0 / _HARD)
    record = np.empty(most + 16, SAMPLE)
    run = runner(kernels.run, most, interpret_up_to=SHORT)
    with np.errstate(over="ignore", invalid="ignore"):
        one = prepared.coefficients[0]
        run(one, cells, bases, orbit, float(periods), most, False, findings, record, workspace())
        rows = record[: int(np.argmax(np.isinf(record["tau"])))]
        for name in ("a", "velocity"):
            rows[name] *= more
            rows[name] *= math.copysign(scale, kick)
    rows["state"] *= math.copysign(1.0, kick)
    finite = np.isfinite(rows["a"]) & np.isfinite(rows["velocity"])
    rows = rows[: int(np.argmin(np.append(finite, False)))]
    end = 2.0 * math.pi * periods
    rows = rows[rows["tau"] <= end * (1.0 + 1e-12)]  # a stick may last beyond
    if rows[-1]["tau"] < end and rows[-1]["state"] == 0.0:
        rows = np.append(rows, np.array([(end, rows[-1]["a"], 0.0, 0.0)], SAMPLE))
    tau, a, v, state = (np.ascontiguousarray(rows[name]) for name in SAMPLE.names or ())
    return Trajectory(e, kick, tau, a, v, state.astype(np.int8))
