"""The fate of a kick, decided for all time: over arrays, and of one kick with the reason."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import Floats, Ints, shaped
from floquetrod._util.content import NoTruthValue
from floquetrod.equations import FrictionalMathieu, require
from floquetrod.floquet.status import STATUS_CODES, are
from floquetrod.friction.inputs import (
    MAX_STEPS,
    SHORT,
    Equations,
    Prepared,
    arguments,
    elapsed,
    growth_of,
    never_freed,
    over_friction,
    prepare_one,
    size_of,
)
from floquetrod.friction.kernels import stick_slip_motion as kernels
from floquetrod.friction.kernels.records import ORBIT, SAMPLE, workspace

UNDECIDED, BOUNDED, ESCAPES = STATUS_CODES["undecided"], STATUS_CODES["stable"], STATUS_CODES["unstable"]
"""Values of `fates`: -1, 1 and 0, those of every status, as what is bounded is stable."""

_ROW = 64  # kicks of one equation that a thread takes at a time (a choice)


def fates(
    alpha: Any,
    beta: Any,
    gamma: Any,
    kick: Any,
    *,
    damping: Any = 0.0,
    max_steps: int = MAX_STEPS,
    workers: int | None = None,
) -> Any:
    """Return the fate of each kick: `BOUNDED` (1), `ESCAPES` (0) or `UNDECIDED` (-1), as int8; of a single kick as int.

    Parameters
    ----------
    alpha : array_like
        Amplitude of the coefficient.  The five arrays broadcast against each other.
    beta : array_like
        Mean of the coefficient.
    gamma : array_like
        Friction force over inertia, zero or more.
    kick : array_like
        Initial velocity A'(0); a negative one is the mirror image of its positive.  Fastest where it varies along the
        last axis.
    damping : array_like
        c, the decay rate per unit tau, zero or more.
    max_steps : int
        Steps (32 or more to a period) that an orbit may take before it is given up as undecided.
    workers : int, optional
        Threads; by default all cores.

    Returns
    -------
    int or ndarray of int8
        In the broadcast shape.

    Raises
    ------
    TypeError, ValueError
        For numbers out of these ranges, and for shapes that do not broadcast.

    Notes
    -----
    Without friction an orbit escapes where Mathieu's equation is unstable and the kick is not zero.  Where it is
    stable no kick escapes: proved except for exact resonances, which no double hits (page `theory/friction`).

    Examples
    --------
    >>> fates(0.0, 0.25, 1.0, [1.999, 2.001]).tolist()
    [1, 0]
    """
    shape, alpha, beta, gamma, c, kick = arguments(alpha, beta, gamma, damping, kick=size_of(kick))
    max_steps = validate.integer("max_steps", max_steps, 1)
    return shaped(known_fates(Equations.of(alpha, beta, c, workers), gamma, kick, max_steps, workers), shape)


def known_fates(
    equations: Equations, gamma: Floats, kick: Floats, max_steps: int = MAX_STEPS, workers: int | None = None
) -> NDArray[np.int8]:
    """Return `fates` of checked flat arrays."""
    ends = np.full(kick.size, kernels.NO_GROWTH, dtype=np.int8)  # why each run ended, as the kernels number it
    if kick.size == 1:
        alpha, beta, damping, rate = (float(part[0]) for part in equations)
        one = FrictionalMathieu(alpha, beta, float(gamma[0]), damping)
        ends[0] = int(_end(one, float(kick[0]), rate, max_steps)[0])
    else:
        free, grows = gamma == 0.0, equations.rate >= 0.0
        ends[free & grows & (kick > 0.0)] = kernels.GROWS
        chosen = np.flatnonzero(~free & grows)
        ends[chosen] = _ends(equations.some(chosen), over_friction(kick, gamma)[chosen], max_steps, workers)
    result = np.where(ends == kernels.GROWS, ESCAPES, np.where(ends < kernels.GROWS, BOUNDED, UNDECIDED))
    return result.astype(np.int8)


def escapes(
    alpha: Any,
    beta: Any,
    gamma: Any,
    kick: Any,
    *,
    damping: Any = 0.0,
    max_steps: int = MAX_STEPS,
    workers: int | None = None,
) -> Any:
    """Return whether each kick escapes for good, as bool; arguments as in `fates`.

    Returns
    -------
    bool or ndarray of bool
        In the broadcast shape.

    Raises
    ------
    TypeError, ValueError
        As `fates`.

    Warns
    -----
    UndecidedWarning
        When some orbits could not be decided: False there means "not known to escape"; `fates` shows which.

    Examples
    --------
    >>> escapes(1.0, [0.3, -0.7], 1.0, 2.0).tolist()
    [True, False]
    """
    kick_fates = fates(alpha, beta, gamma, kick, damping=damping, max_steps=max_steps, workers=workers)
    what = "kicks could not be decided and count as not escaping"
    return are("unstable", kick_fates, what, "friction.fates shows which, a larger max_steps may decide them")


def _ends(every: Equations, kicks: Floats, max_steps: int, workers: int | None) -> NDArray[np.int8]:
    """Return why the run of each kick ended of equations that grow; gamma = 1."""
    out = np.empty(kicks.size, dtype=np.int8)
    # Kicks of one equation that come one after the other share its cells.
    new = np.ones(kicks.size, dtype=np.bool_)
    new[1:] = np.any([part[1:] != part[:-1] for part in every[:3]], axis=0)
    begins = np.flatnonzero(new)
    for part in every.parts(begins):
        end = begins[np.searchsorted(begins, part[-1]) + 1 :][:1]
        members = np.arange(part[0], end[0] if end.size else kicks.size)
        equations = every.some(part).prepared(workers)
        out[members] = _ends_of_rows(equations, np.cumsum(new[members]) - 1, kicks[members], max_steps, workers)
    return out


def _ends_of_rows(equations: Prepared, of: Ints, kicks: Floats, max_steps: int, workers: int | None) -> Floats:
    """Return why the run of each kick ended; ``of`` is its equation, ascending."""
    place = np.arange(of.size) - np.searchsorted(of, of)
    column = place % _ROW
    row = np.cumsum(column == 0) - 1
    rows = np.full((int(row[-1]) + 1, int(column.max()) + 1), math.nan)
    rows[row, column] = kicks
    equation = of[column == 0]
    orbits = equations.follow(equation, rows, max_steps, workers, equations.no_findings()[equation], follow_slow=True)
    ends: Floats = orbits["fate"][row, column]
    return ends


@dataclass(frozen=True, repr=False)
class Fate(NoTruthValue):
    """The motion after one kick, for all time.

    Attributes
    ----------
    equation : FrictionalMathieu
        The equation.
    kick : float
        The initial velocity.
    status : {"bounded", "escapes", "undecided"}
    reason : str
        How it is known.
    tau : float
        Time at which it was known.
    reversals : int
        How often the motion had come to a stop by then.
    sticks : int
        How often it had stuck by then.
    """

    ask = ".status"

    equation: FrictionalMathieu
    kick: float
    status: Literal["bounded", "escapes", "undecided"]
    reason: str
    tau: float
    reversals: int
    sticks: int

    def __repr__(self) -> str:
        """Return the fate as a sentence."""
        when = f" after {self.tau / (2.0 * math.pi):.3g} periods and {self.reversals} stops" if self.tau > 0.0 else ""
        return f"<{self.status}: {self.reason}; known{when or ' at once'}>"


_REASONS: dict[int, tuple[Literal["bounded", "escapes", "undecided"], str]] = {
    kernels.NO_GROWTH: ("bounded", "nothing grows without friction"),
    kernels.STUCK: ("bounded", "sticks for all time"),
    kernels.ENERGY_BOUND: ("bounded", "comes to rest, and never moves farther out again"),
    kernels.STICK_SLIP: ("bounded", "sticks and slips within bounds, as far as sampling shows"),
    kernels.GROWS: ("escapes", "the growing Floquet solution has outgrown friction"),
    kernels.LIMIT: ("undecided", "not decided within max_steps"),
}


def fate(equation: FrictionalMathieu, kick: float, *, max_steps: int = MAX_STEPS) -> Fate:
    """Return the fate of one kick A(0) = 0, A'(0) = kick, and how it is known.

    Returns
    -------
    Fate
        Status, and what proves it.

    Raises
    ------
    TypeError, ValueError
        For another equation, a kick that is not finite, and fewer steps than 1.

    Examples
    --------
    >>> fate(FrictionalMathieu(alpha=1.0, beta=0.3, gamma=1.0), 2.0).status
    'escapes'
    """
    require(equation, (FrictionalMathieu,), "fate")
    kick = validate.finite("kick", kick)
    max_steps = validate.integer("max_steps", max_steps, 1)
    return known_fate(equation, kick, growth_of(equation), max_steps)


def known_fate(equation: FrictionalMathieu, kick: float, rate: float, max_steps: int = MAX_STEPS) -> Fate:
    """Return `fate` of a kick that is checked, ``rate`` as `growth_of` has it."""
    code, tau, reversals, sticks = _end(equation, abs(kick), rate, max_steps)
    status, reason = _REASONS[int(code)]
    return Fate(equation, kick, status, reason, float(tau), int(reversals), int(sticks))


def _end(e: FrictionalMathieu, kick: float, rate: float, max_steps: int) -> Floats:
    """Return why the run of one kick ended, as the kernels number it, the time, and the numbers of stops and sticks."""
    orbit = np.zeros(1, ORBIT)[0]
    orbit["velocity"] = kick / e.gamma if e.gamma > 0.0 else kick
    if rate < 0.0 or e.gamma == 0.0 or never_freed(e.alpha, e.beta, orbit["velocity"]):
        escapes = rate >= 0.0 and e.gamma == 0.0 and kick > 0.0
        code = kernels.GROWS if escapes else kernels.NO_GROWTH if rate < 0.0 else kernels.STUCK
        return np.array([code, 0.0, 0.0, 0.0])
    # Interpreted where that is soon known, else compiled.
    equations = prepare_one(e, rate)
    most = min(max_steps, SHORT)
    _, cells, bases, _ = equations.propagators
    findings, none, one = equations.no_findings(), np.empty(0, SAMPLE), equations.coefficients[0]
    code = kernels.run(one, cells, bases, orbit, math.inf, most, False, findings[0], none, workspace())
    if not (code < kernels.LIMIT or (code == kernels.LIMIT and most == max_steps)):
        kicks = np.array([[kick / e.gamma]])
        orbit = equations.follow(np.zeros(1, dtype=np.int64), kicks, max_steps, 1, findings, follow_slow=True)[0, 0]
    return np.array([orbit["fate"], elapsed(orbit), orbit["reversals"], orbit["sticks"]])
