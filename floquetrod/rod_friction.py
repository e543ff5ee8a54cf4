"""A rod that has to overcome friction: which modes a kick sets off for good, and the smallest kick that does."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from floquetrod import mathieu
from floquetrod.coulomb import Coulomb, ModeFriction, critical_velocities
from floquetrod.equations import FrictionalMathieu
from floquetrod.friction.critical import critical_perturbation
from floquetrod.friction.fates import BOUNDED, ESCAPES, UNDECIDED, Fate, fate, outcome
from floquetrod.kernels.mathieu import mode_coefficients
from floquetrod.load import AxialLoad
from floquetrod.result import Status, Verdict
from floquetrod.rod_data import RodData
from floquetrod.rod_stability import RodStability

_AT_ONCE = 4096  # loads whose modes are held at once (a choice: some megabytes)


class CriticalKick(NamedTuple):
    """Smallest transverse velocity in m/s that buckles the rod, and the mode it buckles into.

    Infinite and None where no kick does; NaN and None where that could not be decided.
    """

    velocity: float
    mode: int | None


@dataclass(frozen=True, repr=False)
class RodFriction(Verdict):
    """Verdict on a rod with friction, every mode of which is kicked alike.

    Attributes
    ----------
    friction : Coulomb
        Coefficient of friction and kick.
    in_modes : ModeFriction
        What they come to in the mode equations.
    linear : RodStability
        Verdict without friction; rod, load and modes are there.
    fates : tuple of Fate
        Of the modes in ``modes``.
    """

    friction: Coulomb
    in_modes: ModeFriction
    linear: RodStability
    fates: tuple[Fate, ...]

    @property
    def modes(self) -> tuple[int, ...]:
        """Modes that grow, or may grow, without friction: no kick sets off any other."""
        return _growing(self.linear)

    @property
    def unstable_modes(self) -> tuple[int, ...]:
        """Modes that the kick sets off for good."""
        return tuple(m for m, fate in zip(self.modes, self.fates, strict=True) if fate.status == "escapes")

    @property
    def status(self) -> Status:
        """Verdict: stable when no mode escapes."""
        found = {fate.status for fate in self.fates}
        return "unstable" if "escapes" in found else "undecided" if "undecided" in found else "stable"

    @cached_property
    def critical_kick(self) -> CriticalKick:
        """Smallest kick that buckles the rod, and the mode it buckles into."""
        return critical_kick(self.linear, self.friction.mu)

    @cached_property
    def critical_velocities(self) -> dict[int, float]:
        """Smallest kick in m/s that sets off each of ``modes``."""
        return _critical_velocities(self.linear, self.friction.mu)

    def __repr__(self) -> str:
        """Return the verdict as a sentence."""
        kick = f"a kick of {1e3 * self.friction.velocity:g} mm/s against mu = {self.friction.mu:g}"
        if self.status == "unstable":
            what = f"sets off mode{'s' * (len(self.unstable_modes) > 1)} {', '.join(map(str, self.unstable_modes))}"
        else:
            what = "sets off no mode" if self.status == "stable" else "could not be decided"
        growing = f"without friction {', '.join(map(str, self.modes)) or 'none'} would grow"
        return f"<{self.status}: {kick} {what}; {growing}>"


def judge_kick(linear: RodStability, friction: Coulomb) -> RodFriction:
    """Return the verdict with friction that follows on one without."""
    inside = friction.in_mode_equation(linear.rod, linear.load)
    equations = dict(zip(linear.modes, linear.mode_equations, strict=True))
    fates = tuple(
        fate(FrictionalMathieu(e.alpha, e.beta, inside.gamma, e.damping), inside.epsilon)
        for e in (equations[mode] for mode in _growing(linear))
    )
    return RodFriction(friction, inside, linear, fates)


def critical_kick(linear: RodStability, mu: float) -> CriticalKick:
    """Return the smallest kick that sets off a mode, modes that grow fast asked first."""
    mode = np.array(_growing(linear), dtype=np.int64)
    best, first = np.full(1, math.inf), np.zeros(1, dtype=np.int64)
    _least_kicks((np.zeros(mode.size, dtype=np.int64), mode, *_parameters(linear)), 1, best, first)
    load = linear.load
    (velocity,) = critical_velocities(linear.rod, load.amplitude, load.frequency, mu, best)
    return CriticalKick(float(velocity), int(first[0]) or None)


def _growing(linear: RodStability) -> tuple[int, ...]:
    unsure = {m for m, v in zip(linear.modes, linear.mode_verdicts, strict=True) if v.status == "undecided"}
    return tuple(m for m in linear.modes if m in unsure or m in linear.unstable_modes)


def _parameters(linear: RodStability) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return alpha, beta and damping of the modes that grow."""
    equations = dict(zip(linear.modes, linear.mode_equations, strict=True))
    chosen = [equations[mode] for mode in _growing(linear)]
    return (
        np.array([e.alpha for e in chosen]),
        np.array([e.beta for e in chosen]),
        np.array([e.damping for e in chosen]),
    )


def _critical_velocities(linear: RodStability, mu: float) -> dict[int, float]:
    alpha, beta, damping = _parameters(linear)
    ratio = critical_perturbation(alpha, beta, 1.0, damping)
    speeds = critical_velocities(linear.rod, linear.load.amplitude, linear.load.frequency, mu, ratio)
    return dict(zip(_growing(linear), map(float, speeds), strict=True))


GrowingModes: TypeAlias = tuple[
    NDArray[np.int64], NDArray[np.int64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]
]


def growing_modes(
    rod: RodData, loads: Sequence[NDArray[np.float64]], tolerance: float, workers: int | None
) -> GrowingModes:
    """Return index of the load, mode, alpha, beta and damping of all modes that grow without friction.

    ``loads`` are flat arrays of mean force, amplitude and frequency (N, N, rad/s); ``tolerance`` in 1/s.
    """
    mean, amplitude, frequency = loads
    last, _ = rod.modes_needed(AxialLoad(mean.max(), amplitude.max(), frequency.max()), tolerance)
    modes = np.arange(1, last + 1)
    a, b, c, d = (np.reshape(part, (-1, 1)) for part in rod.mode_family(mean, amplitude, frequency))
    alpha, beta = mode_coefficients(a, b, c, d, modes)
    damping = np.broadcast_to((rod.damping_rate / frequency)[:, None], alpha.shape)
    load, column = np.nonzero(~mathieu.is_stable(alpha, beta, damping, workers=workers))
    chosen = alpha[load, column], beta[load, column], damping[load, column]
    if tolerance > 0.0:
        fast = mathieu.growth_rate(*chosen, workers=workers) * frequency[load] > tolerance
        load, column = load[fast], column[fast]
        chosen = chosen[0][fast], chosen[1][fast], chosen[2][fast]
    return load, modes[column], *chosen


def kicked_loads(
    rod: RodData,
    loads: Sequence[NDArray[np.float64]],
    friction: Coulomb,
    tolerance: float,
    workers: int | None,
) -> NDArray[np.int8]:
    """Return whether the kick sets off no mode (1), one (0), or cannot be told (-1), for flat arrays of loads."""
    found = np.full(loads[0].size, BOUNDED, dtype=np.int8)
    for part in _parts(loads[0].size):
        some = [values[part] for values in loads]
        load, _, alpha, beta, damping = growing_modes(rod, some, tolerance, workers)
        _, _, gamma, epsilon = friction.in_mode_equations(rod, some[1], some[2])
        fates = outcome(alpha, beta, gamma[load], epsilon[load], damping, workers=workers)
        found[part][load[fates == UNDECIDED]] = UNDECIDED
        found[part][load[fates == ESCAPES]] = ESCAPES
    return np.where(found == UNDECIDED, -1, found == BOUNDED).astype(np.int8)


def critical_kicks(
    rod: RodData, loads: Sequence[NDArray[np.float64]], mu: float, tolerance: float, workers: int | None
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the smallest velocity in m/s that sets off a mode, and the mode (0 for none), for flat arrays of loads."""
    ratio = np.full(loads[0].size, math.inf)
    first = np.zeros(ratio.size, dtype=np.int64)
    for part in _parts(ratio.size):
        growing = growing_modes(rod, [values[part] for values in loads], tolerance, workers)
        _least_kicks(growing, workers, ratio[part], first[part])
    return critical_velocities(rod, loads[1], loads[2], mu, ratio), first


def _least_kicks(
    growing: GrowingModes, workers: int | None, best: NDArray[np.float64], first: NDArray[np.int64]
) -> None:
    """Lower ``best`` to the smallest kick over friction that sets off a mode of each load, ``first`` to the mode."""
    load, mode, alpha, beta, damping = growing
    # The fastest mode of every load first: what it needs is as far as the others are followed.
    order = np.lexsort((-mathieu.growth_rate(alpha, beta, damping, workers=workers), load))
    place = np.arange(load.size) - np.searchsorted(load, load)  # of each mode among those of its load
    for turn in range(int(place.max(initial=-1)) + 1):
        now = order[place == turn]
        now = now[~np.isnan(best[load[now]])]  # where it could not be told, it stays so
        at = load[now]
        ratio = critical_perturbation(alpha[now], beta[now], 1.0, damping[now], upto=best[at], workers=workers)
        better = ~(ratio >= best[at])
        best[at[better]] = ratio[better]
        first[at[better]] = np.where(np.isnan(ratio[better]), 0, mode[now][better])


def _parts(size: int) -> list[slice]:
    """Return slices of up to `_AT_ONCE`, so that memory follows the loads and not their modes."""
    return [slice(start, start + _AT_ONCE) for start in range(0, size, _AT_ONCE)]
