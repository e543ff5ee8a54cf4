"""Coupled modes under a force that is partly random: verdicts in mean square, from the second moments of all together.

One random force acts on all modes, q'' + 2 c q' + K(t) q = s B q xi, where a newton of compression takes B from the
stiffness and s^2 is half its one-sided density.  Where that depends on the frequency, sums and differences of
the modes' frequencies matter: the largest density of all then bounds the growth from above, none at all from
below, as more noise always means more growth.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple, cast

import numpy as np

from floquetrod._util.arguments import wrong_value
from floquetrod._util.progress import Progress, shifted
from floquetrod.floquet.first_change import separation
from floquetrod.floquet.multipliers.moment_growth import MomentGrowth, MomentRate
from floquetrod.floquet.multipliers.stabilising_damping import least_damping
from floquetrod.floquet.status import STATUS_CODES, UNDECIDED, UNSTABLE
from floquetrod.floquet.verdict import Cost, Status
from floquetrod.rod.answers.critical_value import CriticalValue
from floquetrod.rod.answers.evidence import NoisyCoupledEvidence
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import Load, Loads, largest_density
from floquetrod.rod.mode_equations.coupled_matrices import CoupledModes
from floquetrod.rod.mode_equations.noisy_equations import IN_MEAN_SQUARE
from floquetrod.rod.model.assumptions import assumptions
from floquetrod.rod.model.constants import mode_constants
from floquetrod.rod.model.contact import constants_under, require_on_wall
from floquetrod.rod.modes.coupled import CoupledModel, chosen_count
from floquetrod.rod.modes.mode_model import Answers, ModeModel, Statuses
from floquetrod.rod.modes.noisy_verdict import NEAREST, NoisyModel, high_modes_grow, unstable_without_noise
from floquetrod.rod.modes.verdict_samples import VerdictCounts

_LEFT_OUT = 5.0  # error over the change from 5/6 of the modes, as of modes without noise
_ENLARGEMENTS = 3  # times that more modes are taken while two numbers of them disagree (a choice)
_MOST_NUMBERS = 1 << 24  # of all steps of a period: half a gigabyte
_STILL = 0.1  # frequency over that of the fastest mode at which a force without vibration is examined
_LEAST, _MOST = VerdictCounts(3, 4), VerdictCounts(17, 20)  # for a part of a search for a margin (a choice)

_ASSUMED = (
    IN_MEAN_SQUARE,
    "one random force acts on all modes, as white noise of its density, where that varies of its largest",
)


@dataclass(frozen=True)
class NoisyCoupledModel(NoisyModel):
    """Coupled modes under a force that has noise."""

    loads_at_once: ClassVar[int | None] = 50  # some seconds
    samples: ClassVar[int] = 65
    at_once: ClassVar[int] = 1

    @property
    def quiet(self) -> CoupledModel:
        """The modes without noise."""
        return CoupledModel(self.rod, replace(self.template, noise=0.0))

    def modes_needed(self, load: Load, growth_tolerance: float) -> tuple[int, float]:
        """Return how many modes to take, and the growth in 1/s that all others are expected not to exceed."""
        return self.quiet.modes_needed(load, growth_tolerance)

    def count_for(self, loads: Loads, growth_tolerance: float) -> int:
        """Return how many modes serve all of some loads."""
        return self.quiet.count_for(loads, growth_tolerance)

    def in_modes(self, count: int) -> Any:
        """Return the first modes as systems of equations without noise."""
        return self.quiet.in_modes(count)

    def modes_apart(self, modes: Iterable[int]) -> tuple[int, ...]:
        """Return none: all share one growth."""
        return ()

    def density(self) -> float:
        """Return the density in N^2/Hz of white noise that makes everything grow as fast at least."""
        return float(largest_density(self.template.noise, 0.0))

    def trial(self, load: Load, count: int) -> Trial:
        """Return the trial of the first modes under a load."""
        return Trial.of(self.in_modes(count), replace(load, noise=0.0))

    # --- verdicts ---

    def verdict(
        self,
        load: Load,
        modes: Iterable[int] | None = None,
        growth_tolerance: float = 0.0,
        progress: Progress | None = None,
    ) -> RodStability:
        """Return the verdict in mean square under one load, with as many modes as two numbers of them agree upon."""
        require_on_wall(self.rod, load)
        count = None if modes is None else chosen_count(modes)
        return _classified(self.under(load), load, count, growth_tolerance, progress)

    def answers(
        self, loads: Loads, growth_tolerance: float = 0.0, workers: int | None = None, progress: Progress | None = None
    ) -> Answers:
        """Return status, growth of second moments in 1/s, and -1 where something grows, as verdicts, one by one."""
        status, growth = np.full(loads.size, UNDECIDED, dtype=np.int8), np.full(loads.size, np.nan)
        for i in range(loads.size):
            load = self.template.with_numbers(*(float(values[i]) for values in loads.flat))
            under = self.under(load)
            trials, growths = _counted(under, load, growth_tolerance)
            final = _with_left_out(growths)
            judged, _ = _judged(under, load, final, trials[-1].growth(0.0), growth_tolerance)
            status[i] = STATUS_CODES[judged]
            growth[i] = np.maximum(final.rate, under.growth_beyond(load))  # NaN where it is not known
            if progress is not None:
                progress(i + 1, loads.size)
        return Answers(status, growth, np.where(growth > 0.0, -1, 0))

    def status(
        self, loads: Loads, growth_tolerance: float = 0.0, workers: int | None = None, progress: Progress | None = None
    ) -> Statuses:
        """Return the status of each load, with the moments of those alone that do not grow without noise already."""

        def told(done: int, total: int) -> None:
            if progress is not None:
                progress(done * loads.size // total, loads.size)

        status = self.quiet.status(loads, 0.5 * growth_tolerance, workers, shifted(told, 0, loads.size)).copy()
        left = np.flatnonzero(status != UNSTABLE)
        known = 2 * loads.size - left.size
        told(known, 2 * loads.size)
        if left.size:
            answer_progress = shifted(told, known, known)
            status[left] = self.answers(loads.some(left), growth_tolerance, workers, answer_progress).status
        return status

    growth_of_modes = ModeModel.growth_of_modes

    # --- searches ---

    def margin_counts(self, verdict: RodStability, seconds: float, longest: float) -> VerdictCounts:
        """Return as many verdicts as time allows."""
        return _MOST.in_time(seconds, cast(NoisyCoupledEvidence, verdict.evidence).seconds * longest, _LEAST)

    def damping_required(self, load: Load, growth_tolerance: float) -> float:
        """Return the damping rate in 1/s at which second moments no longer grow faster than a tolerance."""
        count = self.count_for(Loads.single(load), growth_tolerance)
        modes, quiet = self.in_modes(count), replace(load, noise=0.0)
        if float(np.linalg.eigvalsh(modes.system(Loads.single(quiet)).stiffness)[0]) <= 0.0:
            return math.inf
        constants = mode_constants(self.rod)
        beyond = 0.0
        if not isinstance(load.noise, tuple):  # all high modes grow at their share of the density
            beyond = max(
                0.0, 0.125 * float(load.noise) * constants.per_newton**2 / constants.bending - 0.5 * growth_tolerance
            )

        def excess(rate: float) -> float:
            rate_of_moments = Trial.of(modes.damped(rate), quiet).growth(float(largest_density(load.noise, 0.0))).rate
            return -1.0 if math.isnan(rate_of_moments) else rate_of_moments - growth_tolerance

        start = max(beyond, 0.5 * self.rod.damping_rate, 1e-6 * load.frequency)
        return max(beyond, least_damping(excess, start, load.frequency))

    def critical_noise(self, load: Load, growth_tolerance: float, progress: Progress | None = None) -> CriticalValue:
        """Return the largest factor of the noise of a load at which it is stable in mean square, and its error.

        With as many modes as verdicts on both sides take, which they tell apart within the error, and the limit of high
        modes.  Of a density that depends on the frequency it is a lower bound, with the error of the bound.
        """
        from scipy.optimize import brentq

        require_on_wall(self.rod, load)
        under, constants = self.under(load), constants_under(self.rod, load.mean)
        trials, _ = _counted(under, load, growth_tolerance, progress)
        largest = under.density()
        decay = 8.0 * float(constants.damping_rate) + 4.0 * growth_tolerance
        most = decay * float(constants.bending) / float(constants.per_newton) ** 2 / largest
        is_white = not isinstance(load.noise, tuple)

        def growth(factor: float) -> MomentRate:
            final = _with_left_out([trial.growth(factor * largest) for trial in trials])
            if math.isnan(final.rate):
                raise wrong_value("load", "must be one whose second moments can be computed, got one where they cannot")
            return final

        def excess(factor: float) -> float:
            return growth(factor).rate - growth_tolerance

        if not excess(0.0) < 0.0:
            raise unstable_without_noise()
        high = most
        while not is_white and excess(high) < 0.0:
            high *= 4.0
        factor = high if excess(high) < 0.0 else brentq(excess, 0.0, high, xtol=1e-13 * high, rtol=1e-12)

        def is_apart(apart: float) -> bool:
            below, above = growth(factor * (1.0 - apart)), growth(factor * (1.0 + apart))
            grows = (is_white and factor * (1.0 + apart) > most) or above.rate - above.error > growth_tolerance
            return below.rate + below.error < growth_tolerance and grows

        return CriticalValue(float(factor), "noise", error=float(separation(is_apart, NEAREST) * factor))

    certify = ModeModel.certify


class Trial(NamedTuple):
    """The second moments of the first modes under one load.

    Attributes
    ----------
    mode_count : int
    moments : MomentGrowth
        Of intensities per newton.
    """

    mode_count: int
    moments: MomentGrowth

    @classmethod
    def of(cls, modes: CoupledModes, load: Load) -> Trial:
        """Return the second moments of modes; ValueError where a period takes too many steps."""
        at = Loads.single(load)
        system = modes.system(at)
        fastest = math.sqrt(float(np.abs(np.linalg.eigvalsh(system.stiffness)).max()))
        if load.amplitude == 0.0:
            system = replace(system, period=2.0 * math.pi / (_STILL * fastest))
        steps = fastest * float(system.period)
        if (steps + 64.0) * (2 * system.order) ** 2 > 0.2 * _MOST_NUMBERS:
            raise wrong_value(
                "load",
                f"needs {modes.count} coupled modes, the fastest of which turns {steps / 2.0 / math.pi:,.0f} times in "
                "a period: too many for their second moments; choose fewer modes, a shorter rod or a higher frequency",
            )
        return cls(modes.count, MomentGrowth.of(system, [modes.softening(load.mean)]))

    def growth(self, density: float) -> MomentRate:
        """Return the growth of second moments in 1/s under a one-sided density in N^2/Hz."""
        return self.moments(0.5 * density)


def _classified(
    model: NoisyCoupledModel, load: Load, count: int | None, growth_tolerance: float, progress: Progress | None
) -> RodStability:
    """Classify the second moments with as many modes as two numbers of them agree upon, or with ``count``."""
    trials, growths = _counted(model, load, growth_tolerance, progress) if count is None else _tried(model, load, count)
    final = _with_left_out(growths)
    status, note = _judged(model, load, final, trials[-1].growth(0.0), growth_tolerance)
    rate = max(0.0, float(np.nan_to_num(final.rate)), 0.0 if count else model.growth_beyond(load))
    steps = sum(len(trial.moments.fine.steps) for trial in trials)
    convergence = tuple((trial.mode_count, growth.rate) for trial, growth in zip(trials, growths, strict=True))
    return RodStability(
        model=model,
        evidence=NoisyCoupledEvidence(convergence, sum(trial.moments.seconds for trial in trials)),
        growth_tolerance=growth_tolerance,
        status=status,
        growth_rate=rate,
        exponents=() if math.isnan(final.rate) else (complex(final.rate),),
        period=2.0 * math.pi / load.frequency,
        error=final.error,
        cost=Cost(steps, "steps"),
        note=note,
        assumptions=(*assumptions(model.rod, load), *_ASSUMED),
    )


def _tried(model: NoisyCoupledModel, load: Load, *counts: int) -> tuple[list[Trial], list[MomentRate]]:
    """Return trials of so many modes each, and how fast they grow."""
    trials = [model.trial(load, count) for count in counts]
    return trials, [trial.growth(model.density()) for trial in trials]


def _counted(
    model: NoisyCoupledModel, load: Load, growth_tolerance: float, progress: Progress | None = None
) -> tuple[list[Trial], list[MomentRate]]:
    """Return the trials made, the fewest modes first, and how fast they grow."""
    last = model.count_for(Loads.single(load), growth_tolerance)
    trials, growths = _tried(model, load, last - max(2, last // 6), last)
    for _ in range(_ENLARGEMENTS):
        if progress is not None:
            progress(len(trials), len(trials) + 1)
        final = _with_left_out(growths)
        if not final.error < math.inf or abs(final.rate - growth_tolerance) > final.error:
            break
        more, faster = _tried(model, load, math.ceil(1.25 * trials[-1].mode_count))
        trials, growths = trials + more, growths + faster
    return trials, growths


def _with_left_out(growths: list[MomentRate]) -> MomentRate:
    """Return the growth with the most modes, its error enlarged for those left out, by what fewer change."""
    final = growths[-1]
    change = max((abs(final.rate - fewer.rate) for fewer in growths[-2:-1]), default=0.0)
    return MomentRate(final.rate, final.error + _LEFT_OUT * change)


def _judged(
    model: NoisyCoupledModel, load: Load, noisy: MomentRate, quiet: MomentRate, growth_tolerance: float
) -> tuple[Status, str]:
    """Return the verdict, and what to know of it, given the growth with noise and without."""
    beyond = model.growth_beyond(load)
    if beyond > growth_tolerance:
        return "unstable", high_modes_grow(beyond, model.rod.damping_rate)
    if not noisy.error < math.inf:
        return "undecided", "the growth of second moments could not be computed"
    if noisy.rate + noisy.error < growth_tolerance:
        return "stable", ""
    if isinstance(load.noise, tuple):
        if quiet.rate - quiet.error > growth_tolerance:
            return "unstable", "without noise already"
        return "undecided", "white noise of the largest density would make it grow, that given may not"
    if noisy.rate - noisy.error > growth_tolerance:
        return "unstable", ""
    return "undecided", f"growth {noisy.rate:.3g} 1/s in mean square is within its error {noisy.error:.1g}"
