"""Modes under a force of two frequencies: growth of independent modes, from periodic approximants."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, NoReturn, cast

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arguments import Mention, wrong_value
from floquetrod._util.arrays import Floats, Ints
from floquetrod._util.progress import Progress
from floquetrod.equations import Hill, TwoFrequencies
from floquetrod.floquet.quasiperiodic import ManyGrowths, growth_of_many
from floquetrod.floquet.status import STABLE, UNDECIDED, UNSTABLE, Status
from floquetrod.floquet.verdict import Cost
from floquetrod.rod.answers.evidence import TwoFrequencyEvidence
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import Load, Loads, Second, second_in_words
from floquetrod.rod.mode_equations.modal_systems import ModalSystem
from floquetrod.rod.model.assumptions import Assumption, assumptions
from floquetrod.rod.model.constants import ModeConstants, mode_constants
from floquetrod.rod.modes.mode_model import Answers, Statuses
from floquetrod.rod.modes.sampled_model import SampledModel
from floquetrod.rod.modes.verdict_samples import VerdictCounts

if TYPE_CHECKING:
    from floquetrod.rod.mode_equations.coupled_systems import CoupledEquations

_AT_ONCE = 256  # loads whose modes are examined at once (a choice)
_LEAST, _MOST = VerdictCounts(5, 8), VerdictCounts(33, 20)  # for a part of a search for a margin (a choice)

ASSUMED = Assumption(
    "two frequencies: growth from periodic approximants, which is no proof",
    "a tongue narrower than the distance of the last approximant may be missed; growth in it is within the error",
)


@dataclass(frozen=True)
class TwoFrequencyModel(SampledModel):
    """Independent modes of hinged ends in a straight channel, under a uniform force of two frequencies."""

    loads_at_once: ClassVar[int | None] = _AT_ONCE
    samples: ClassVar[int] = 129
    damping_source: ClassVar[str] = "that of the load whose growth is worst, by bisection"

    @property
    def _sine(self) -> tuple[float, float, float]:
        """Amplitude, frequency and phase of the second sine."""
        amplitude, frequency, *ahead = cast(Second, self.template.second)
        return amplitude, frequency, ahead[0] if ahead else 0.0

    @property
    def coupling(self) -> tuple[str, ...]:
        """The second sine, in words."""
        return (*super().coupling, second_in_words(self.template))

    def refusal(self, name: str) -> ValueError:
        """Return the error for questions that two frequencies have no answer to: proofs, friction, finite time."""
        there = second_in_words(self.template)
        return wrong_value(name, f"is not answered under {there}; leave ", Mention("second"), " out")

    # --- equations ---

    def equations(self, load: Load, modes: Iterable[int] | None = None) -> NoReturn:
        """Raise ValueError: equations with two frequencies are no periodic system."""
        raise self.refusal("modal_system")

    def in_modes(self, count: int) -> CoupledEquations:
        """Raise ValueError, as `equations` does."""
        raise self.refusal("modal_system")

    def modes_apart(self, modes: Iterable[int]) -> tuple[int, ...]:
        """Return the modes: each has an equation of its own."""
        return tuple(modes)

    def modes_needed(self, load: Load, growth_tolerance: float) -> tuple[int, float]:
        """Return how many modes decide a verdict, and a bound in 1/s on the growth of all others.

        Of one sine as strong as both together, and as fast as the faster of them, which tongues of no lower order need.
        """
        return mode_constants(self.rod).modes_needed(self._strongest(load), growth_tolerance)

    def _strongest(self, load: Load) -> Load:
        """Return one sine that reaches as high modes."""
        amplitude, frequency, _ = self._sine
        size = load.amplitude * float(np.abs(load.harmonics).sum()) + amplitude
        fastest = max(load.frequency * load.harmonics.size, frequency)
        return replace(load, amplitude=size, frequency=fastest, waveform="sine", second=None)

    def mode_equations(self, load: Load, modes: Iterable[int]) -> tuple[TwoFrequencies, ...]:
        """Return the equation of each mode, in the time tau = omega t of the first frequency."""
        constants: ModeConstants = mode_constants(self.rod)
        system = ModalSystem(constants, replace(load, second=None), tuple(modes))
        amplitude, frequency, phase = self._sine
        damping, rows = system.damping, (system.alpha, system.beta, amplitude * system.per_newton)
        cosines, sines = load.harmonics.real, -load.harmonics.imag
        return tuple(
            TwoFrequencies(
                Hill(beta, tuple((alpha * cosines).tolist()), tuple((alpha * sines).tolist()), damping=damping),
                frequency / load.frequency,
                (second * math.sin(phase),),
                (second * math.cos(phase),),
            )
            for alpha, beta, second in zip(*(row.tolist() for row in rows), strict=True)
        )

    # --- verdicts ---

    def verdict(
        self,
        load: Load,
        modes: Iterable[int] | None = None,
        growth_tolerance: float = 0.0,
        progress: Progress | None = None,
    ) -> RodStability:
        """Return the verdict under one load, put together from the growth of each mode."""
        omega, model = load.frequency, self.under(load)
        if modes is None:
            last, left_out = model.modes_needed(load, growth_tolerance)
            chosen = tuple(range(1, last + 1))
        else:
            chosen, left_out = validate.modes(modes), math.inf
        equations = model.mode_equations(load, chosen)
        found = growth_of_many(equations, growth_tolerance / omega)
        growths = tuple(found.single(i) for i in range(len(chosen)))
        rates, errors = omega * found.rate, omega * found.error
        known = np.where(np.isnan(rates), -np.inf, rates)
        status = _worst(found)
        fastest = float(known.max())
        unsure = found.status == UNDECIDED
        return RodStability(
            model=model,
            evidence=TwoFrequencyEvidence(chosen, growths, known, errors, left_out, equations),
            growth_tolerance=growth_tolerance,
            status=status,
            growth_rate=fastest if fastest > float(errors[known.argmax()]) else 0.0,
            exponents=tuple(sorted(map(complex, known.tolist()), key=lambda exponent: -exponent.real)),
            period=2.0 * math.pi / omega,
            error=float(errors.max()),
            cost=Cost(sum(len(growth.approximants) for growth in growths), "approximants"),
            note=advice(float((known + errors)[unsure].max()), self.rod.damping_rate) if status == "undecided" else "",
            assumptions=(*assumptions(self.rod, load), ASSUMED),
        )

    def answers(
        self, loads: Loads, growth_tolerance: float = 0.0, workers: int | None = None, progress: Progress | None = None
    ) -> Answers:
        """Return status, growth in 1/s and the fastest mode of each load."""
        status, growth = np.full(loads.size, UNDECIDED, dtype=np.int8), np.full(loads.size, np.nan)
        fastest = np.zeros(loads.size, dtype=np.int64)
        for start in range(0, loads.size, _AT_ONCE):
            block = slice(start, min(loads.size, start + _AT_ONCE))
            status[block], growth[block], fastest[block] = self._examined(loads.some(block), growth_tolerance, workers)
            if progress is not None:
                progress(block.stop, loads.size)
        return Answers(status, growth, fastest)

    def _examined(self, loads: Loads, growth_tolerance: float, workers: int | None) -> tuple[Statuses, Floats, Ints]:
        """Return status, growth and fastest mode of some loads, all modes of all of them at once."""
        equations: list[TwoFrequencies] = []
        ends, tolerances = [], []
        for numbers in zip(*(values.tolist() for values in loads.flat), strict=True):
            load = self.template.with_numbers(*numbers)
            last, _ = self.modes_needed(load, growth_tolerance)
            equations += self.mode_equations(load, range(1, last + 1))
            tolerances += [growth_tolerance / load.frequency] * last
            ends.append(len(equations))
        found = growth_of_many(equations, np.array(tolerances), precise=False, workers=workers)
        status, growth = np.empty(loads.size, dtype=np.int8), np.empty(loads.size)
        fastest = np.zeros(loads.size, dtype=np.int64)
        for i, (begin, end) in enumerate(zip([0, *ends[:-1]], ends, strict=True)):
            each, rates = found.status[begin:end], found.rate[begin:end]
            status[i] = UNSTABLE if (each == UNSTABLE).any() else UNDECIDED if (each == UNDECIDED).any() else STABLE
            known = np.where(np.isnan(rates), -np.inf, rates)
            mode = int(known.argmax())
            grows = known[mode] > found.error[begin + mode]
            growth[i] = loads.frequency[i] * known[mode] if grows else 0.0
            fastest[i] = mode + 1 if grows else 0
        return status, growth, fastest

    def growth_of_modes(self, load: Load, modes: Iterable[int]) -> tuple[float, ...]:
        """Return the growth in 1/s of modes."""
        rates = growth_of_many(self.under(load).mode_equations(load, modes), 0.0).rate
        return tuple((load.frequency * np.maximum(rates, 0.0)).tolist())

    # --- margins ---

    def margin_counts(self, verdict: RodStability, seconds: float, longest: float) -> VerdictCounts:
        """Return as many verdicts as time allows."""
        return _MOST.in_time(seconds, cast(TwoFrequencyEvidence, verdict.evidence).seconds_with(longest), _LEAST)

    def buckles(self, load: Load, growth_tolerance: float) -> bool:
        """Return whether the mean force alone buckles a mode."""
        last, _ = self.under(load).modes_needed(load, growth_tolerance)
        system = ModalSystem(mode_constants(self.rod), replace(load, second=None), tuple(range(1, last + 1)))
        return bool(system.beta.max() + system.damping**2 >= 0.0)


def _worst(found: ManyGrowths) -> Status:
    """Return the verdict on all modes together."""
    if (found.status == UNSTABLE).any():
        return "unstable"
    return "undecided" if (found.status == UNDECIDED).any() else "stable"


def advice(needed: float, damping_rate: float) -> str:
    """Return what decides a verdict, where that is possible."""
    if not math.isfinite(needed):
        return "the growth of a mode is not known"
    without = "" if damping_rate else "without damping tongues of two frequencies are everywhere: "
    return f"{without}approximants leave open growth of up to {needed:.2g} 1/s; give a growth tolerance above that"
