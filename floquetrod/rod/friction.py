"""A rod that has to overcome friction: which modes a kick sets off for good, and the smallest kick that does."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from floquetrod import mathieu
from floquetrod.equations import FrictionalMathieu
from floquetrod.floquet.result import Status, Verdict
from floquetrod.friction.critical import critical_bounds, critical_perturbation
from floquetrod.friction.fates import BOUNDED, ESCAPES, UNDECIDED, Fate, fate, outcome
from floquetrod.kernels.rod_modes import mode_coefficients
from floquetrod.rod.coulomb import Coulomb, ModeFriction, critical_velocities
from floquetrod.rod.data import RodData
from floquetrod.rod.load import AxialLoad
from floquetrod.rod.stability import RodStability

_AT_ONCE = 4096  # loads whose modes are held at once (a choice: some megabytes)


class CriticalKick(NamedTuple):
    """Smallest transverse velocity found to buckle the rod, and the mode it buckles into; what is proved beside it.

    Attributes
    ----------
    velocity : float or ndarray
        The smallest found, m/s; infinite where no kick buckles the rod, NaN where that could not be decided.
    mode : int or None, or ndarray
        The mode that it sets off; none is 0 in an array.
    none_up_to : float or ndarray
        Proved: no velocity up to it, m/s, sets off a mode (that grows faster than the tolerance asked for).
    """

    velocity: Any
    mode: Any
    none_up_to: Any


@dataclass(frozen=True, repr=False)
class FrictionalRodStability(Verdict):
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
        """Smallest kick found to buckle the rod, the mode it buckles into, and the kick up to which none does."""
        return critical_kick(self.linear, self.friction.mu)

    @cached_property
    def critical_velocities(self) -> dict[int, float]:
        """Smallest kick in m/s found to set off each of ``modes``."""
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


def judge_kick(linear: RodStability, friction: Coulomb) -> FrictionalRodStability:
    """Return the verdict with friction that follows on one without."""
    inside = friction.in_mode_equation(linear.rod, linear.load)
    equations = dict(zip(linear.modes, linear.mode_equations, strict=True))
    fates = tuple(
        fate(FrictionalMathieu(e.alpha, e.beta, inside.gamma, e.damping), inside.epsilon)
        for e in (equations[mode] for mode in _growing(linear))
    )
    return FrictionalRodStability(friction, inside, linear, fates)


def critical_kick(linear: RodStability, mu: float) -> CriticalKick:
    """Return the smallest kick found to set off a mode, and that up to which none does."""
    mode = np.array(_growing(linear), dtype=np.int64)
    least = _Least.of(1)
    _least_kicks((np.zeros(mode.size, dtype=np.int64), mode, *_parameters(linear)), 1, least)
    load = linear.load
    ratios = np.concatenate([least.found, least.proved])
    velocity, none_up_to = critical_velocities(linear.rod, load.amplitude, load.frequency, mu, ratios)
    return CriticalKick(float(velocity), int(least.mode[0]) or None, float(none_up_to))


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
) -> CriticalKick:
    """Return what `critical_kick` does for flat arrays of loads."""
    least = _Least.of(loads[0].size)
    for part in _parts(loads[0].size):
        growing = growing_modes(rod, [values[part] for values in loads], tolerance, workers)
        _least_kicks(growing, workers, least.part(part))
    velocity, none_up_to = (critical_velocities(rod, loads[1], loads[2], mu, r) for r in (least.found, least.proved))
    return CriticalKick(velocity, least.mode, none_up_to)


class _Least(NamedTuple):
    """Of each load: the smallest kick over friction found to set off a mode, that mode, and the proved bound below."""

    found: NDArray[np.float64]
    mode: NDArray[np.int64]
    proved: NDArray[np.float64]

    @classmethod
    def of(cls, size: int) -> _Least:
        """Return what is known of loads before any mode is asked."""
        return cls(np.full(size, math.inf), np.zeros(size, dtype=np.int64), np.full(size, math.inf))

    def part(self, part: slice) -> _Least:
        """Return a view of some loads."""
        return _Least(self.found[part], self.mode[part], self.proved[part])


def _least_kicks(growing: GrowingModes, workers: int | None, least: _Least) -> None:
    """Lower ``least`` to what the growing modes of each load need; NaN where none was found and one is unknown."""
    load, mode, alpha, beta, damping = growing
    # The fastest mode of every load first: what it needs is as far as the others are followed.
    order = np.lexsort((-mathieu.growth_rate(alpha, beta, damping, workers=workers), load))
    place = np.arange(load.size) - np.searchsorted(load, load)  # of each mode among those of its load
    unknown = np.zeros(least.found.size, dtype=np.bool_)
    for turn in range(int(place.max(initial=-1)) + 1):
        now = order[place == turn]
        at = load[now]
        proved, found = critical_bounds(alpha[now], beta[now], 1.0, damping[now], upto=least.found[at], workers=workers)
        least.proved[at] = np.minimum(least.proved[at], proved)
        unknown[at] |= np.isnan(found)
        better = found < least.found[at]
        least.found[at[better]] = found[better]
        least.mode[at[better]] = mode[now][better]
    least.found[unknown & np.isinf(least.found)] = math.nan


def _parts(size: int) -> list[slice]:
    """Return slices of up to `_AT_ONCE`, so that memory follows the loads and not their modes."""
    return [slice(start, start + _AT_ONCE) for start in range(0, size, _AT_ONCE)]
