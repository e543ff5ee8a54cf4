"""The verdict on a rod whose modes are coupled: how many modes are enough, and which of them are judged."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from floquetrod._util.progress import Progress
from floquetrod.equations.hill_system import HillSystem, restricted
from floquetrod.floquet.dispatch import judge, stability
from floquetrod.floquet.methods.system_half_period import solved_pairs
from floquetrod.floquet.methods.system_monodromy import solved_many
from floquetrod.floquet.multipliers.fastest_solutions import fast_solutions
from floquetrod.floquet.multipliers.resonating_modes import Resonating, resonating
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.problems import undamped_pairs
from floquetrod.floquet.verdict import Status
from floquetrod.rod.answers.evidence import CoupledEvidence
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import Load, Loads
from floquetrod.rod.mode_equations.coupled_matrices import MOST_COUPLED, require_few
from floquetrod.rod.mode_equations.coupled_systems import SEVERAL, CoupledEquations
from floquetrod.rod.mode_equations.modal_systems import ModalSystems
from floquetrod.rod.model.assumptions import assumptions, forced_in_words
from floquetrod.rod.model.contact import constants_under
from floquetrod.rod.model.section_basis import are_enriched, are_nested
from floquetrod.rod.modes.fewer_modes import Fastest
from floquetrod.rod.modes.mode_model import ModeModel

_LONG = 200  # modes from which a verdict takes seconds, so that no more are taken than matter
_BESIDE = 2  # modes above the highest that a harmonic drives (measured)
_ENLARGEMENTS = 3  # times that more modes are taken while two numbers of them disagree (a choice)


def classify_coupled(
    model: ModeModel, load: Load, count: int | None, growth_tolerance: float, progress: Progress | None = None
) -> RodStability:
    """Classify a rod with as many modes as two numbers of them agree upon, or with ``count`` of them.

    ``progress`` is called with the numbers of trials made and, as far as is known by then, to make.
    """
    model = model.under(load)
    trials = _trials(model, load, count, growth_tolerance, progress)
    final = trials[-1]
    status, error, note = final.concluded(_compared(model, trials), growth_tolerance)
    whole = final.whole
    forced_angle = final.modes.forced_angle(load, final.system)
    return RodStability(
        model=model,
        evidence=CoupledEvidence(
            tuple((trial.modes.count, trial.whole.growth_rate) for trial in trials),
            final.modes,
            final.system,
            whole,
            model.rod.length,
            0 if final.resonating is None else final.resonating.below,
        ),
        growth_tolerance=growth_tolerance,
        status=status,
        growth_rate=whole.growth_rate,
        exponents=whole.exponents,
        period=whole.period,
        error=error,
        cost=whole.cost,
        note=note,
        assumptions=assumptions(model.rod, load) + (() if forced_angle is None else (forced_in_words(forced_angle),)),
    )


def _trials(
    model: ModeModel, load: Load, count: int | None, growth_tolerance: float, progress: Progress | None
) -> list[_Trial]:
    """Return the trials made, the fewest modes first."""
    # A trial is the verdict with the first M modes, coupled; its error is the difference between trials of different M.
    # The first trial has ``last`` modes, those that may grow by bounds on uncoupled modes; the others have the numbers
    # that `_numbers` chooses from it.  Larger M first, since the maps of a smaller M can follow from them
    # (`with_fewer`).  While modes beyond may change the answer, M grows by a quarter, `_ENLARGEMENTS` times at most.
    # Last comes the number that the bound on modes left out asks for.  ``trials`` is kept in the order of M, whatever
    # the order in which they are made.
    trials: list[_Trial] = []

    def add(modes: int, known: int) -> None:
        """Make a trial with so many modes: of fewer modes than the last one it follows from that, where possible."""
        chosen = model.in_modes(modes)
        index = sum(trial.modes.count < modes for trial in trials)
        larger = trials[-1] if index < len(trials) else None
        fewer = None if larger is None else larger.with_fewer(chosen)
        trials.insert(index, fewer or _Trial.of(chosen, load, None if larger is None else larger.system))
        if progress is not None:
            progress(len(trials), max(known, len(trials)))

    if count is not None:
        add(count, 1)
        return trials
    last, fewer = _modes_to_begin_with(model, load, growth_tolerance)
    add(last, 2)
    first = trials[0]
    numbers = _numbers(model, load, first, fewer, growth_tolerance)
    if last not in numbers:
        trials.clear()
    for modes in sorted(numbers - {last}, reverse=True):  # fewer follow from more
        add(modes, len(numbers))
    while trials[-1].more_modes_may_decide(_compared(model, trials), growth_tolerance):
        larger = math.ceil(1.25 * trials[-1].modes.count)
        if len(trials) == len(numbers) + _ENLARGEMENTS or larger > MOST_COUPLED or not trials[-1].is_sharp:
            break
        add(larger, 2)
    needed = 0 if trials[-1] is first else _more_needed(model, load, trials[-1], growth_tolerance)
    if needed:
        add(needed, 2)
    return trials


def _numbers(model: ModeModel, load: Load, first: _Trial, fewer: int, growth_tolerance: float) -> set[int]:
    """Return the numbers of modes whose verdicts are compared to begin with, two or three.

    The number of the first trial with a larger one where more modes may matter, else with a smaller one; or as many as
    harmonics drive, and more.  Three where two may agree by chance.
    """
    count = first.modes.count
    by_chance = bool(model.rod.course.breaks)
    needed = _more_needed(model, load, first, growth_tolerance)
    driven = _driven(model, load, first)
    if driven > max(count, needed):
        numbers = driven, driven + max(2, driven // 5)
    elif needed:
        numbers = count, needed
    else:
        if first.fastest is None:  # the second verdict takes as long as the first: the fewer modes the better
            fewer = min(fewer, count - max(2, count // left_out_share(model, count)))
        numbers = fewer, count
        by_chance = by_chance or has_functions_of_its_own(model, count)
    return {*numbers, sum(numbers) // 2} if by_chance else {*numbers}


def _compared(model: ModeModel, trials: Sequence[_Trial]) -> Sequence[_Trial]:
    """Return the trials with which the last one is compared: they tell how growth depends on the number of modes.

    Where the curvature of a channel jumps, growth goes up and down with it, as where modes are added that harmonics
    drive (see `_driven`): two numbers of modes may agree by chance.
    """
    rod = model.rod
    is_by_chance = rod.course.breaks or has_functions_of_its_own(model, trials[-1].modes.count)
    return trials[-3:-1] if is_by_chance else trials[-2:-1]


def _driven(model: ModeModel, load: Load, trial: _Trial) -> int:
    """Return up to which mode the harmonics of growing motion may drive one; 0 where none may be near them.

    Motion that grows has the frequencies nu + k w, and each may be near the frequency of a mode far above.
    Sines hardly drive such a mode, but other functions do: growth stands still over some numbers of modes, and changes
    once that mode is among them.  Taken are modes up to (H + 1) w - nu under a force of H harmonics, at most twice as
    many as there are, as modes driven farther above hardly move, and no more than a verdict takes a second for.
    """
    enriched, count = are_enriched(model.rod), trial.modes.count
    if not enriched or count > _LONG or not trial.low > -model.rod.damping_rate:
        return 0
    turns = abs(trial.whole.exponents[0].imag) / load.frequency
    highest = 1.0 + len(load.harmonics) - abs(turns - round(turns))
    uniform = require_few(model.rod, load, Loads.single(load), 0.0)
    below = constants_under(model.rod, uniform.mean).modes_below(highest * load.frequency, uniform.mean)
    return min(below + _BESIDE, 2 * count, _LONG)


def left_out_share(model: ModeModel, count: int) -> int:
    """Return n where the second trial leaves out one mode in n.

    More are left out where other functions join the beam functions: growth then hardly changes over a few numbers of
    modes, and goes on changing after them.
    """
    if has_functions_of_its_own(model, count):
        return 4
    return 6 if count <= _LONG else 10


def has_functions_of_its_own(model: ModeModel, count: int) -> bool:
    """Return whether functions join the modes that differ with the number of modes."""
    rod = model.rod
    return are_enriched(rod) and (count <= SEVERAL or not are_nested(rod))


def _more_needed(model: ModeModel, load: Load, trial: _Trial, growth_tolerance: float) -> int:
    """Return how many modes to take where modes left out may grow half as fast as the trial's or faster, else 0.

    So many more that both trials tell how the growth depends on their number.
    """
    count = trial.modes.count
    if count >= MOST_COUPLED:
        return 0
    slowest = max(growth_tolerance, 0.5 * trial.whole.growth_rate)
    needed = model.count_for(Loads.single(load), slowest)
    return min(max(needed, count + max(2, count // 9)), MOST_COUPLED) if needed > count else 0


def _modes_to_begin_with(model: ModeModel, load: Load, growth_tolerance: float) -> tuple[int, int]:
    """Return the numbers of modes of the first trial and of the second, which takes fewer.

    Of long strings the modes that may grow a quarter as fast as the fastest.  Of several modes, up to `_LONG`, these
    few are the second trial's, and hold the solution that grows, so that it can be followed; the first takes more.
    """
    rod, loads = model.rod, Loads.single(load)
    uniform = require_few(rod, load, loads, growth_tolerance)
    constants = constants_under(rod, uniform.mean)

    if constants.modes_needed(uniform, growth_tolerance)[0] <= _LONG:
        last = model.count_for(loads, growth_tolerance)
    else:
        # As much as the fastest mode grows if all were independent.
        free = ModalSystems(constants._replace(damping_rate=0.0), Loads.single(uniform))
        fastest = float(free.fastest(1)[0][0]) - constants.damping_rate
        last = model.count_for(loads, max(growth_tolerance, 0.25 * fastest))
    if SEVERAL < last <= _LONG and are_nested(rod):
        return last + max(2, last // 9), last
    return last, last - max(2, last // left_out_share(model, last))


def _judged(system: HillSystem, part: Resonating | None) -> tuple[SystemStability, Fastest | None, Resonating | None]:
    """Return the verdict on all equations or on the modes that may resonate, the fastest solution, and those modes.

    The solution is in the coordinates of all equations, None where it is not known.  Where solutions come in no pairs
    all equations are judged.
    """
    subject = system if part is None else part.system
    freed = subject.undamped
    if freed is None or freed[0].structure != "hamiltonian":
        return stability(system), None, None
    whole, fastest = _judged_in_pairs(subject, freed)
    if part is None or fastest is None:
        return whole, fastest, part
    return whole, fastest.among(system, part.basis), part


def _judged_in_pairs(system: HillSystem, freed: tuple[HillSystem, float]) -> tuple[SystemStability, Fastest | None]:
    """Return the verdict on a system and its fastest solution, given the system without damping and the rate removed.

    By half a period where that is enough, then by the solutions that grow fast alone, then by all.
    """
    if freed[0].is_even:
        pairs = solved_pairs(system)
        return judge(system, pairs.verdict), Fastest.of(pairs, freed)
    fast = fast_solutions(*freed)
    verdict = None if fast is None else fast.verdict(system)
    if fast is not None and verdict is not None and verdict.status != "undecided":
        return verdict, Fastest.followed(fast, freed)
    solved = solved_many(system)
    if solved is None:
        return stability(system), None
    return judge(system, solved.verdict), Fastest.of(solved, freed)


class _Trial(NamedTuple):
    """The verdict with one number of modes, and bounds on the rate of the fastest solution.

    Attributes
    ----------
    modes : CoupledEquations
    system : HillSystem
        Their equations under the load.
    whole : SystemStability
        Verdict on all of them, or on those that may resonate.
    low, high : float
        Lower and upper bound of the rate of the fastest solution in 1/s.
    fastest : Fastest or None
        That solution, of many modes and where it is known.
    resonating : Resonating or None
        The modes judged, where these are not all.
    """

    modes: CoupledEquations
    system: HillSystem
    whole: SystemStability
    low: float
    high: float
    fastest: Fastest | None = None
    resonating: Resonating | None = None

    @classmethod
    def of(cls, modes: CoupledEquations, load: Load, larger: HillSystem | None) -> _Trial:
        """Return the verdict with some modes; ``larger`` is the system of more of them, if it is known."""
        if larger is not None and modes.are_nested:
            system = restricted(larger, slice(modes.size))
        else:
            system = modes.system(Loads.single(load))
        if modes.count <= SEVERAL:
            return cls._bounded(modes, system, stability(system), None, None)
        return cls._bounded(modes, system, *_judged(system, resonating(system)))

    @classmethod
    def _bounded(
        cls,
        modes: CoupledEquations,
        system: HillSystem,
        whole: SystemStability,
        fastest: Fastest | None,
        part: Resonating | None,
    ) -> _Trial:
        """Return the trial of a verdict, with the bounds that its errors leave."""
        # Where solutions come in pairs only the one that decays more slowly matters of each: the error of the other's
        # multiplier may exceed it, where the first one grows fast.
        slower = slice(len(whole.exponents) // (2 if undamped_pairs(system) else 1))
        rates = np.array([exponent.real for exponent in whole.exponents[slower]])
        errors = np.array(whole.exponent_errors[slower])
        known = np.isfinite(errors)
        if not known.any():
            return cls(modes, system, whole, -math.inf, math.inf)
        # The errors of multipliers that cannot be distinguished reach below them, too.
        high = min(float((rates + errors)[known].max()) if known.all() else math.inf, whole.growth_below)
        low = float((rates - errors)[known].max())
        return cls(modes, system, whole, low, high, fastest if modes.are_nested else None, part)

    def with_fewer(self, modes: CoupledEquations) -> _Trial | None:
        """Return the trial with fewer modes, derived from this one; None where that is not possible.

        By following the fastest solution: a verdict on all their solutions would take as long as the one there is, and
        decides nothing, as how the growth depends on the number of modes is asked.  Or by a verdict on the modes that
        may resonate, the last functions kept at zero.
        """
        rate = None if self.fastest is None else self.fastest.rate_with(modes.size)
        if rate is None:
            if self.resonating is None or not modes.are_nested:
                return None
            part = self.resonating.without_last(self.modes.size - modes.size)
            return None if part is None else self._bounded(modes, self.system, *_judged(self.system, part))
        whole = replace(
            self.whole,
            status="unstable" if rate > 0.0 else "stable",
            growth_rate=max(rate, 0.0),
            exponents=(complex(rate, self.whole.exponents[0].imag),),
            exponent_errors=(0.0,),
            krein_signs=(0,),
        )
        return self._replace(modes=modes, whole=whole, low=rate, high=rate, fastest=None)

    @property
    def rate(self) -> float:
        """Rate of the fastest solution in 1/s, negative where it decays."""
        return self.whole.exponents[0].real if self.whole.exponents else math.nan

    @property
    def is_sharp(self) -> bool:
        """Whether rounding leaves room for a verdict that more modes could change."""
        return self.whole.status != "undecided"

    def more_modes_may_decide(self, fewer: Sequence[_Trial], tolerance: float) -> bool:
        """Return whether more modes may decide what these leave open: not where rounding hides the multipliers."""
        status, error, _ = self.concluded(fewer, tolerance)
        return status == "undecided" and error < math.inf

    def concluded(self, fewer: Sequence[_Trial], tolerance: float) -> tuple[Status, float, str]:
        """Return verdict, error of the growth rate in 1/s and note, given trials with fewer modes."""
        # The error for the modes left out is taken to fall as slowly as one over their number.
        count = self.modes.count
        changes = [trial.modes.count / (count - trial.modes.count) * abs(self.rate - trial.rate) for trial in fewer]
        change = max(changes, default=0.0)
        error = max(self.high - self.rate, self.rate - self.low) + change
        if not error < math.inf:
            if self.whole.status == "unstable" and self.low - change > tolerance:
                growth = f"growth is at least {self.low - change:.6g} 1/s"
                return "unstable", math.inf, f"{growth}, beside which slower solutions are lost in rounding"
            return "undecided", math.inf, self.whole.note or "multipliers could not be computed"
        if tolerance > 0.0:
            if self.low - change > tolerance:
                return "unstable", error, self.whole.note
            if self.high + change <= tolerance:
                return "stable", error, self.whole.note
            return "undecided", error, f"growth {self.rate:.3g} 1/s is within its error {error:.1g} of the tolerance"
        for trial in (trial for trial in fewer if trial.whole.status != self.whole.status):
            counts = f"{trial.modes.count} modes say {trial.whole.status}, {count} {self.whole.status}"
            return "undecided", error, counts
        # Without damping stable rates are zero, and as sure as the multipliers' verdict; all others may change sign.
        if abs(self.rate) <= change and change > self.high - self.rate:
            return "undecided", error, f"growth {self.rate:.3g} 1/s with {count} modes is within its error"
        return self.whole.status, error, self.whole.note
