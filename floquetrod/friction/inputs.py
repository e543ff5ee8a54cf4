"""Inputs shared by all questions about kicks: broadcast arguments, growth without friction, orbits of kicks."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from floquetrod import mathieu
from floquetrod._util import validate
from floquetrod._util.arrays import Floats, Ints, broadcast
from floquetrod._util.compilation import over_chunks
from floquetrod.equations import FrictionalMathieu
from floquetrod.friction.kernels import stick_slip_motion as kernels
from floquetrod.friction.kernels.fates import follow_fill
from floquetrod.friction.kernels.records import COEFFICIENTS, FINDINGS, ORBIT, PERIOD
from floquetrod.friction.propagators import Propagators, Records, cell_counts, propagators
from floquetrod.mathieu.array_functions import flat_stable

MAX_STEPS = 500_000
"""Cells an orbit may take, 32 or more to a period: a few thousandths of a second."""

SHORT = 4000
"""Cells of one orbit that are interpreted, in up to a second: cheaper than numba is to load (measured)."""

_AT_ONCE = 100_000  # cells held at once: some 70 MB
_SAMPLES = 8  # orbits of slow outward motion (heuristic)


def arguments(alpha: Any, beta: Any, gamma: Any, damping: Any, **kicks: Floats) -> tuple[Any, ...]:
    """Return the common shape and the flat arrays of arguments that broadcast; ``kicks`` are checked already."""
    largest = np.finfo(np.float64).max
    arrays = {
        "alpha": validate.array("alpha", alpha),
        "beta": validate.array("beta", beta),
        "gamma": validate.array("gamma", gamma, least=0.0, largest=largest),
        "damping": validate.array("damping", damping, least=0.0, largest=validate.LARGEST_DAMPING),
        **kicks,
    }
    shape, flat = broadcast(**arrays)
    return (shape, *flat)


def size_of(kick: Any) -> Floats:
    """Return the magnitude of kicks: their sign only mirrors the motion."""
    largest = np.finfo(np.float64).max
    size: Floats = np.abs(validate.array("kick", kick, least=-largest, largest=largest))
    return size


def over_friction(kick: Floats, gamma: Floats) -> Floats:
    """Return kick / gamma, on which alone the motion depends; the kick itself where there is no friction."""
    with np.errstate(over="ignore"):
        return kick / np.where(gamma > 0.0, gamma, 1.0)


class Equations(NamedTuple):
    """Equations in flat arrays, without what friction adds."""

    alpha: Floats
    beta: Floats
    damping: Floats
    rate: Floats  # growth without friction, -1 where nothing grows; 0 where it is linear or too slow for a double

    @classmethod
    def of(cls, alpha: Floats, beta: Floats, damping: Floats, workers: int | None) -> Equations:
        """Return equations with their growth rates."""
        damped = damping if damping.any() else None
        # A kick takes longer than a verdict one by one, and that kernel is soon compiled.
        stable = flat_stable(alpha, beta, damped, workers=workers, in_blocks=False)
        rate = np.where(stable, -1.0, mathieu.growth_rate(alpha, beta, damping, workers=workers))
        return cls(alpha, beta, damping, rate)

    def some(self, chosen: Ints) -> Equations:
        """Return some of them."""
        return Equations(*(part[chosen] for part in self))

    def parts(self, chosen: Ints) -> list[Ints]:
        """Return the indices ``chosen`` in parts whose cells fit into memory at once."""
        if not chosen.size:
            return []
        part = np.cumsum(cell_counts(*self.some(chosen)[:3])) // _AT_ONCE
        return np.split(chosen, np.flatnonzero(np.diff(part)) + 1)

    def prepared(self, workers: int | None) -> Prepared:
        """Return them ready for kicks to be followed."""
        coefficients = np.empty(self.alpha.size, COEFFICIENTS)
        coefficients["alpha"], coefficients["beta"], coefficients["damping"] = self[:3]
        return Prepared(coefficients, propagators(*self, workers))


def growth_of(equation: FrictionalMathieu) -> float:
    """Return the growth rate of one equation without friction, as `Equations` have it."""
    alpha, beta, damping = (np.array([value]) for value in (equation.alpha, equation.beta, equation.damping))
    return float(Equations.of(alpha, beta, damping, 1).rate[0])


class Prepared(NamedTuple):
    """Equations that grow without friction, ready for kicks to be followed; gamma = 1."""

    coefficients: Records  # of `COEFFICIENTS`
    propagators: Propagators

    def no_findings(self) -> Records:
        """Return the `FINDINGS` on each equation before the first orbit was followed."""
        return np.full(len(self.coefficients), -1.0, FINDINGS)

    def follow(
        self,
        equation: Ints,
        kicks: Floats,
        max_steps: int,
        workers: int | None,
        findings: Records,
        follow_slow: bool,
    ) -> Records:
        """Return the orbits of rows of kicks, followed until decided, one equation per row; NaN stands for no kick.

        ``findings``, a record for each row, are used and added to.  Slow outward motion whose fate depends on where it
        began is followed when ``follow_slow``; otherwise its fate is `MIXED`.
        """
        alpha, beta = self.coefficients["alpha"][equation], self.coefficients["beta"][equation]
        kept = never_freed(alpha[:, None], beta[:, None], kicks)
        velocity = np.where(kept, math.nan, kicks)
        orbits = self._follow(equation, velocity, 0.0, 0.0, max_steps, workers, findings, follow_slow=False)
        fate = orbits["fate"]
        fate[kept] = kernels.STUCK
        slow = fate == kernels.SLOW_RELEASE
        rows = np.flatnonzero(slow.any(axis=1))
        if rows.size:
            new = rows[findings["slow_fate"][rows] < 0.0]
            findings["slow_fate"][new] = self._slow_fates(equation[new], max_steps, workers, findings[new])
            fate[...] = np.where(slow, findings["slow_fate"][:, None], fate)
            if follow_slow:
                self._follow_slow(equation, kicks, orbits, max_steps, workers, findings)
        return orbits

    def _follow(
        self,
        equation: Ints,
        velocity: Floats,
        a: Floats | float,
        phase: Floats | float,
        max_steps: int,
        workers: int | None,
        findings: Records,
        follow_slow: bool,
    ) -> Records:
        """Return the orbits of rows of starts, followed to their fates; a velocity NaN is none."""
        orbits = np.zeros(velocity.shape, ORBIT)
        orbits["a"], orbits["velocity"], orbits["phase"], orbits["fate"] = a, velocity, phase, math.nan
        first, cells, bases, _ = self.propagators
        constants = equation, self.coefficients, first, cells, bases, findings, max_steps, follow_slow
        rows = np.arange(equation.size)
        over_chunks(follow_fill, (rows,), orbits, *constants, workers=workers, chunk=32, interpret_up_to=0)
        return orbits

    def _slow_fates(self, equation: Ints, max_steps: int, workers: int | None, findings: Records) -> Floats:
        """Return the fate of orbits that move outwards slowly from where the largest force just releases them.

        They go from the relative excess d to d + (9/2) Q^2 / abs(alpha) d^2 + ..., so all pass through one step's
        length beginning at d = `SLOW`, anywhere in it.  Their fate is known where all fates sampled there agree.
        """
        alpha, outward = self.coefficients["alpha"][equation], self._outward(equation)
        step = _quadratic(alpha, outward) * kernels.SLOW**2
        excess = kernels.SLOW * (1.0 + 1e-9) + 1.2 * step[:, None] * np.linspace(0.0, 1.0, _SAMPLES)
        phase = np.where(alpha > 0.0, 1.5 * math.pi, 0.5 * math.pi)[:, None]
        a = (1.0 + excess) / outward[:, None]
        rest = np.zeros(a.shape)
        fates = self._follow(equation, rest, a, phase, max_steps, workers, findings, follow_slow=False)["fate"]
        escaped, bounded = fates == kernels.GROWS, fates < kernels.GROWS
        mixed = escaped.any(axis=1) & bounded.any(axis=1)
        result: Floats = np.select(
            [mixed, escaped.all(axis=1), bounded.all(axis=1)],
            [float(kernels.MIXED), float(kernels.GROWS), float(kernels.STICK_SLIP)],
            float(kernels.LIMIT),
        )
        return result

    def _follow_slow(
        self,
        equation: Ints,
        kicks: Floats,
        orbits: Records,
        max_steps: int,
        workers: int | None,
        findings: Records,
    ) -> None:
        """Follow kicks to the end where slow outward motion has no common fate, within ``max_steps`` periods."""
        mixed = orbits["fate"] == kernels.MIXED
        outward = self._outward(equation)[:, None]
        excess = np.where(mixed, outward * np.abs(orbits["a"]) - 1.0, 1.0)
        alpha = self.coefficients["alpha"][equation, None]
        periods = (1.0 / excess - 1.0 / kernels.SLOW) / _quadratic(alpha, outward)
        orbits["fate"][mixed] = kernels.LIMIT
        soon = mixed & (periods <= max_steps)
        rows = np.flatnonzero(soon.any(axis=1))
        if rows.size:
            again = np.where(soon, kicks, math.nan)[rows]
            ends = self._follow(equation[rows], again, 0.0, 0.0, max_steps, workers, findings[rows], follow_slow=True)
            orbits[rows] = np.where(soon[rows], ends, orbits[rows])

    def _outward(self, equation: Ints) -> Floats:
        of = self.coefficients[equation]
        outward: Floats = of["beta"] + np.abs(of["alpha"])
        return outward


def _quadratic(alpha: Floats, outward: Floats) -> Floats:
    """Return by how much the square of the excess exceeds the next one, in slow outward motion."""
    return 4.5 * outward * outward / np.abs(alpha)


def elapsed(orbits: Any) -> Any:
    """Return the time tau that orbits have been followed."""
    return orbits["phase"] + PERIOD * orbits["periods"]


def never_freed(alpha: Any, beta: Any, kick: Any) -> Any:
    """Return whether kicks stop no farther out than where the largest force may act for all time; gamma = 1."""
    return kick * np.sqrt(np.abs(alpha) + np.abs(beta)) <= 1.0


def prepare_one(equation: FrictionalMathieu, rate: float) -> Prepared:
    """Return one equation ready for kicks to be followed."""
    values = equation.alpha, equation.beta, equation.damping, rate
    return Equations(*(np.array([value]) for value in values)).prepared(1)
