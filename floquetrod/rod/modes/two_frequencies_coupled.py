"""Coupled modes under a force of two frequencies: their growth, from periodic approximants of the whole system."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple, cast

import numpy as np

from floquetrod._util.arguments import Mention, wrong_value
from floquetrod._util.progress import Progress
from floquetrod.equations import TwoFrequencies
from floquetrod.floquet.multipliers.stabilising_damping import least_damping
from floquetrod.floquet.quasiperiodic import QuasiperiodicGrowth, growth_of_many, seconds_of_maps
from floquetrod.floquet.status import STATUS_CODES, UNDECIDED, Status
from floquetrod.floquet.verdict import Cost
from floquetrod.rod.answers.evidence import TwoFrequencyCoupledEvidence
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import Load, Loads
from floquetrod.rod.mode_equations.coupled_matrices import CoupledModes, modes_needed
from floquetrod.rod.model.assumptions import assumptions, forced_in_words
from floquetrod.rod.model.contact import constants_under, on_wall, require_on_wall
from floquetrod.rod.model.section_basis import are_enriched
from floquetrod.rod.modes.coupled import chosen_count
from floquetrod.rod.modes.coupled_verdict import has_functions_of_its_own, left_out_share
from floquetrod.rod.modes.mode_model import Answers, ModeModel
from floquetrod.rod.modes.two_frequencies import ASSUMED, TwoFrequencyModel, advice
from floquetrod.rod.modes.verdict_samples import VerdictCounts

_MOST_SECONDS = 120.0  # that a verdict takes at most, as estimated (a choice)
_LONG = 200  # modes up to which those are taken that the frequencies drive
_LEAST, _MOST = VerdictCounts(3, 10), VerdictCounts(17, 20)  # for a part of a search for a margin (a choice)


@dataclass(frozen=True)
class TwoFrequencyCoupledModel(TwoFrequencyModel):
    """Coupled modes, of any rod, under a uniform force of two frequencies."""

    loads_at_once: ClassVar[int | None] = 50  # some seconds
    samples: ClassVar[int] = 33
    at_once: ClassVar[int] = 1

    # --- equations ---

    @property
    def _alone(self) -> Load:
        """The kind of load without its second sine."""
        return replace(self.template, second=None)

    def in_modes(self, count: int) -> CoupledModes:
        """Return the first modes as systems of equations without the second sine."""
        return CoupledModes.of(self.rod, self._alone, count)

    def modes_apart(self, modes: Iterable[int]) -> tuple[int, ...]:
        """Return none: all share one growth."""
        return ()

    def modes_needed(self, load: Load, growth_tolerance: float) -> tuple[int, float]:
        """Return how many modes to take, and the growth in 1/s that all others are expected not to exceed."""
        count = self.count_for(Loads.single(load), growth_tolerance)
        return count, growth_tolerance

    def count_for(self, loads: Loads, growth_tolerance: float) -> int:
        """Return how many modes serve all of some loads: as one sine as strong and as fast as both needs."""
        strongest = self._strongest(self.template.with_numbers(*(float(values.max()) for values in loads.flat)))
        return modes_needed(self.rod, strongest, Loads.single(strongest), growth_tolerance)

    def system(self, load: Load, modes: CoupledModes) -> TwoFrequencies:
        """Return the equations of some modes under a load, in seconds."""
        amplitude, frequency, phase = self._sine
        own = modes.system(Loads.single(load))
        sine = replace(self._other(load), amplitude=1.0)
        wave = amplitude * CoupledModes.of(self.rod, sine, modes.count).system(Loads.single(sine)).sines[0]
        return TwoFrequencies(own, frequency, (math.sin(phase) * wave,), (math.cos(phase) * wave,))

    def _counts(self, load: Load, growth_tolerance: float) -> tuple[int, ...]:
        """Return the numbers of modes whose growth is compared, the largest last.

        Of functions that are no sines as many as swing as fast as both frequencies drive motion that grows.  Three
        where two may agree by chance.
        """
        count = self.count_for(Loads.single(load), growth_tolerance)
        if are_enriched(self.rod) and count <= _LONG:
            one, two = load.frequency * load.harmonics.size, self._sine[1]
            fastest = max(one + two, 1.5 * max(one, two))
            driven = constants_under(self.rod, load.mean).modes_below(fastest, load.mean)
            count = max(count, min(driven + 2, 2 * count, _LONG))
        fewer = count - max(2, count // left_out_share(self, count))
        by_chance = self.rod.course.breaks or has_functions_of_its_own(self, count)
        return (fewer, (fewer + count) // 2, count) if by_chance else (fewer, count)

    def _trials(self, load: Load, counts: Iterable[int], growth_tolerance: float, *, precise: bool) -> _Trials:
        """Return the growth with some numbers of modes, the largest last."""
        numbers = tuple(dict.fromkeys(counts))
        systems = [self.system(load, self.in_modes(count)) for count in numbers]
        seconds = sum(map(seconds_of_maps, systems))
        if seconds > _MOST_SECONDS:
            raise wrong_value(
                "load",
                f"needs {numbers[-1]} coupled modes under two frequencies, about {seconds:.2g} s a verdict, more than "
                f"{_MOST_SECONDS:g}; give a ",
                Mention("growth_tolerance"),
                ", a shorter length, or choose the number of modes",
            )
        found = growth_of_many(systems, growth_tolerance, precise=precise)
        return _Trials(numbers, tuple(found.single(i) for i in range(len(numbers))), growth_tolerance, seconds)

    # --- verdicts ---

    def verdict(
        self,
        load: Load,
        modes: Iterable[int] | None = None,
        growth_tolerance: float = 0.0,
        progress: Progress | None = None,
    ) -> RodStability:
        """Return the verdict under one load, with as many modes as two numbers of them agree upon."""
        model = self.under(load)
        strongest = model._strongest(load)
        require_on_wall(self.rod, strongest)
        counts = model._counts(load, growth_tolerance) if modes is None else (chosen_count(modes),)
        trials = model._trials(load, counts, growth_tolerance, precise=True)
        final, status = trials.growths[-1], trials.status
        note = ""
        if status == "undecided" and trials.left_out > final.error:
            fewer, last = trials.counts[-2:]
            note = f"growth {final.rate:.3g} 1/s with {last} modes differs too much from that with {fewer}"
        elif status == "undecided":
            note = advice(final.rate + trials.error, self.rod.damping_rate)
        alone = replace(load, second=None), model._other(load)
        angles = [model.in_modes(counts[-1]).forced_angle(each) for each in alone]
        forced = () if None in angles else (forced_in_words(sum(filter(None, angles))),)
        return RodStability(
            model=model,
            evidence=TwoFrequencyCoupledEvidence(
                tuple(zip(trials.counts, (growth.rate for growth in trials.growths), strict=True)),
                final,
                trials.seconds,
            ),
            growth_tolerance=growth_tolerance,
            status=status,
            growth_rate=trials.growing,
            exponents=() if math.isnan(final.rate) else (complex(final.rate),),
            period=2.0 * math.pi / load.frequency,
            error=trials.error,
            cost=Cost(sum(len(growth.approximants) for growth in trials.growths), "approximants"),
            note=note,
            assumptions=(*assumptions(self.rod, load), *forced, ASSUMED),
        )

    def _other(self, load: Load) -> Load:
        """Return the second sine alone."""
        amplitude, frequency, _ = self._sine
        return replace(load, amplitude=amplitude, frequency=frequency, waveform="sine", second=None)

    def answers(
        self, loads: Loads, growth_tolerance: float = 0.0, workers: int | None = None, progress: Progress | None = None
    ) -> Answers:
        """Return status, growth in 1/s and -1 where something grows, as verdicts, one by one.

        Undecided, and NaN, where the rod leaves its wall; a single load is refused there.
        """
        status, growth = np.full(loads.size, UNDECIDED, dtype=np.int8), np.full(loads.size, np.nan)
        for i in range(loads.size):
            load = self.template.with_numbers(*(float(values[i]) for values in loads.flat))
            strongest = self._strongest(load)
            if loads.shape == ():
                require_on_wall(self.rod, strongest)
            if on_wall(self.rod, strongest, Loads.single(strongest))[0]:
                counts = self._counts(load, growth_tolerance)
                trials = self.under(load)._trials(load, counts, growth_tolerance, precise=False)
                status[i], growth[i] = STATUS_CODES[trials.status], trials.growing
            if progress is not None:
                progress(i + 1, loads.size)
        return Answers(status, growth, np.where(growth > 0.0, -1, 0))

    growth_of_modes = ModeModel.growth_of_modes

    # --- searches ---

    def margin_counts(self, verdict: RodStability, seconds: float, longest: float) -> VerdictCounts:
        """Return as many verdicts as time allows."""
        return _MOST.in_time(seconds, cast(TwoFrequencyCoupledEvidence, verdict.evidence).seconds * longest, _LEAST)

    def buckles(self, load: Load, growth_tolerance: float) -> bool:
        """Return whether the mean force alone buckles the rod."""
        system = self.in_modes(self.count_for(Loads.single(load), growth_tolerance)).system(Loads.single(load))
        return float(np.linalg.eigvalsh(system.stiffness)[0]) <= 0.0

    def damping_required(self, load: Load, growth_tolerance: float) -> float:
        """Return the damping rate in 1/s at which modes no longer grow faster than a tolerance, the error allowed for.

        With as many modes as the verdict, to ten digits, and tried at two, four and eight times as much.
        """
        if self.buckles(load, growth_tolerance):
            return math.inf
        under = self.under(load)
        counts = under._counts(load, growth_tolerance)[-1:]

        def excess(rate: float) -> float:
            damped = replace(under, rod=self.rod.replace(damping_rate=rate))
            growth = damped._trials(load, counts, growth_tolerance, precise=False).growths[-1]
            return growth.rate + growth.error - growth_tolerance

        undamped = excess(0.0)
        return undamped if math.isnan(undamped) else least_damping(excess, max(undamped, 0.0), load.frequency)


class _Trials(NamedTuple):
    """Growth with some numbers of modes, the largest last."""

    counts: tuple[int, ...]
    growths: tuple[QuasiperiodicGrowth, ...]
    tolerance: float
    seconds: float

    @property
    def left_out(self) -> float:
        """Error in 1/s for the modes left out, taken to fall as slowly as one over their number."""
        last, rate = self.counts[-1], self.growths[-1].rate
        fewer = zip(self.counts[:-1], self.growths[:-1], strict=True)
        return max((count / (last - count) * abs(rate - growth.rate) for count, growth in fewer), default=0.0)

    @property
    def error(self) -> float:
        """Error of the growth in 1/s."""
        return self.growths[-1].error + self.left_out

    @property
    def growing(self) -> float:
        """Growth in 1/s, 0 where it may be none."""
        rate = self.growths[-1].rate
        return rate if rate > self.error else 0.0

    @property
    def status(self) -> Status:
        """The verdict, as `QuasiperiodicGrowth.status`, with the error for the modes left out."""
        return self.growths[-1]._replace(error=self.error).status
