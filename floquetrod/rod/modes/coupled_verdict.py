"""The verdict on a rod whose modes are coupled: how many are enough, which resonate, and the shape that grows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.caching import cached_property
from floquetrod._util.progress import Progress
from floquetrod._util.result_report import number
from floquetrod.equations.hill_system import HillSystem, restricted
from floquetrod.equations.pieces import of_batch
from floquetrod.floquet.dispatch import judge, stability
from floquetrod.floquet.methods.system_half_period import solved_pairs
from floquetrod.floquet.methods.system_monodromy import solved_many
from floquetrod.floquet.multipliers.fastest_solutions import fast_solutions
from floquetrod.floquet.multipliers.resonance_names import Resonance
from floquetrod.floquet.multipliers.resonating_modes import Resonating, resonating
from floquetrod.floquet.multipliers.stabilising_damping import least_damping
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.multipliers.whole_period_maps import period_maps
from floquetrod.floquet.problems import undamped_pairs
from floquetrod.floquet.verdict import Status
from floquetrod.rod.answers.margins import Edge
from floquetrod.rod.answers.verdict import Evidence, RodStability, Shape
from floquetrod.rod.loads.load import Load, Loads, Quantity
from floquetrod.rod.mode_equations.coupled_matrices import MOST_COUPLED, require_few, up_to_resonance
from floquetrod.rod.mode_equations.coupled_systems import SEVERAL, CoupledEquations
from floquetrod.rod.mode_equations.modal_systems import ModalSystems
from floquetrod.rod.mode_equations.sampled import first_change
from floquetrod.rod.model.assumptions import assumptions, forced_in_words
from floquetrod.rod.model.beam import are_enriched
from floquetrod.rod.model.contact import constants_under, up_to_wall
from floquetrod.rod.modes.fewer_modes import Fastest
from floquetrod.rod.modes.mode_model import ModeModel

_LONG = 200  # modes from which a verdict takes seconds, so that no more are taken than matter
_BESIDE = 2  # modes above the highest that a harmonic drives (measured)
_ENLARGEMENTS = 3  # times that more modes are taken while two numbers of them disagree (a choice)
_SHAPE_POINTS, _SHAPE_INSTANTS = 12, 48  # for each mode, and in a period
_LISTED = 10  # resonances in a report, the fastest


@dataclass(frozen=True)
class SharedGrowth(Evidence):
    """Coupled modes, as many as two numbers of them agree upon, of one growth.

    Attributes
    ----------
    model : ModeModel
        What the modes are under this load.
    convergence : tuple of (int, float)
        Numbers of modes and the growth rate in 1/s with each; the last one is the answer.
    """

    growth_in_words: ClassVar[str] = "growth"

    model: ModeModel = field(compare=False)
    convergence: tuple[tuple[int, float], ...]

    @property
    def load(self) -> Load:
        """The load."""
        return self.model.like

    @property
    def modes(self) -> tuple[int, ...]:
        """Modes examined."""
        return tuple(range(1, self.convergence[-1][0] + 1))

    @property
    def cutoff(self) -> str:
        """Why these modes and no others."""
        last, final = self.convergence[-1]
        if len(self.convergence) == 1:
            return f"{last} coupled modes, as requested"
        fewer, first = self.convergence[-2]
        change = abs(final - first)
        known = (
            f"{self.growth_in_words} differs by {change:.1g} 1/s"
            if math.isfinite(change)
            else "growth could not be compared"
        )
        return f"{last} coupled modes; with {fewer} {known}"

    def growth_of(self, verdict: RodStability, mode: int) -> float:
        """Return the growth rate in 1/s, which all modes share."""
        return verdict.growth_rate

    def is_fastest(self, verdict: RodStability, mode: int | None) -> bool:
        """Return that the growth rate is that of any mode: all take part in it."""
        return True


@dataclass(frozen=True)
class ModesTogether(SharedGrowth):
    """Coupled modes and their equations.

    Attributes
    ----------
    coupled : CoupledEquations
        The coordinates in which the motion is written.
    system : HillSystem
        The equations of motion, in seconds.
    whole : SystemStability
        Verdict on them, or on those that may resonate.
    below : int
        Modes of lower frequency than any of ``whole``.
    """

    kind: ClassVar[str] = "coupled modes"

    coupled: CoupledEquations = field(compare=False)
    system: HillSystem = field(compare=False)
    whole: SystemStability = field(compare=False)
    below: int = field(default=0, compare=False)

    @cached_property
    def resonances(self) -> tuple[Resonance, ...]:
        """What grows, the fastest first."""
        found = (r._replace(modes=tuple(self.below + mode for mode in r.modes)) for r in self.whole.resonances)
        return self.coupled.named(self.system, tuple(found))

    @property
    def references(self) -> tuple[str, ...]:
        """What to cite for the methods used."""
        return self.whole.references

    def damping_to_stabilise(self, verdict: RodStability) -> float:
        """Return the damping rate in 1/s at which this load no longer makes the rod grow faster than the tolerance.

        Found to ten digits, and tried at two, four and eight times as much.
        """
        if float(np.linalg.eigvalsh(self.system.stiffness)[0]) <= 0.0:
            return math.inf
        loads = Loads.single(self.load)

        def excess(rate: float) -> float:
            """Return the growth beyond the tolerance at a damping rate; below zero where everything decays."""
            growth = float(self.coupled.damped(rate).growth_without_decay(loads)[0])
            return -1.0 if math.isnan(growth) else growth - rate - verdict.growth_tolerance

        return least_damping(excess, verdict.growth_rate, self.load.frequency)

    @cached_property
    def shape(self) -> Shape:
        """Where along the rod the fastest solution moves most, growing or not."""
        from scipy.integrate import solve_ivp

        system = self.system
        undamped, _ = system.undamped or (system, 0.0)  # the factor of damping changes no shape
        first, n, period = undamped.as_periodic_system(), self.coupled.size, self.whole.period
        maps = period_maps(of_batch(first), 0.0, 1e-10, paired=True)
        values, vectors = np.linalg.eig(maps.matrix[0])
        fastest = int(np.abs(values).argmax())
        rate = math.log(abs(values[fastest])) / period
        start = (vectors[:, fastest] * maps.scaling[0]).astype(complex)
        series = np.concatenate([first.mean[None], first.harmonics])

        def slope(t: float, state: NDArray[np.complex128]) -> NDArray[np.complex128]:
            found = series[0] @ state
            for k, matrix in enumerate(series[1:], start=1):
                found = found + (matrix * np.exp(2j * math.pi * k * t / period)).real @ state
            return np.asarray(found)

        times = np.linspace(0.0, period, _SHAPE_INSTANTS + 1)
        path = solve_ivp(slope, (0.0, period), start, method="DOP853", t_eval=times, rtol=1e-8, atol=1e-12).y[:n]
        path = path * np.exp(-rate * times)
        x = np.linspace(0.0, 1.0, _SHAPE_POINTS * self.coupled.size + 1)
        moving = self.coupled.shapes(x).T @ path  # complex: its real part at any phase is a solution
        envelope = np.abs(moving).max(axis=1)
        size = float(envelope.max())
        at, instant = np.unravel_index(np.abs(moving).argmax(), moving.shape)
        turned = moving[:, instant] * np.exp(-1j * np.angle(moving[at, instant]))
        return Shape(x * self.model.rod.length, turned.real / size, envelope / size)

    def headline(self, verdict: RodStability) -> str:
        """Return the resonance that grows fastest, and how many more do."""
        if verdict.status == "undecided":
            return "the error of the growth rate is too large to decide whether the rod is stable"
        if verdict.status != "unstable":
            return ""
        growing = [r for r in self.resonances if r.growth_rate > verdict.growth_tolerance]
        name = str(growing[0]) if growing else f"grows at {verdict.growth_rate:.6g} 1/s"
        return name + (f", and {len(growing) - 1} more" if len(growing) > 1 else "")

    def named_lines(self, verdict: RodStability) -> list[tuple[str, str]]:
        """Return the fastest resonances by name."""
        lines = [
            ("" if i else "grows", f"{resonance}, {resonance.growth_rate:.6g} 1/s")
            for i, resonance in enumerate(self.resonances[:_LISTED])
        ]
        more = len(self.resonances) - _LISTED
        return lines + ([("", f"and {more} more, which grow more slowly (the JSON lists them)")] if more > 0 else [])

    def method(self, verdict: RodStability) -> str:
        """Return the method, and how good the growth rate is, unless only a lower bound is known, as the note says."""
        good = f"; growth good to {verdict.error:.0e} 1/s" if math.isfinite(verdict.error) else ""
        return f"{self.whole.method}, {verdict.cost}{good}"

    def numbers(self, verdict: RodStability) -> dict[str, Any]:
        """Return error, numbers of modes tried, resonances and the kind of load."""
        return {
            "growth_rate_error_per_s": number(verdict.error),
            "convergence": [{"modes": modes, "growth_rate_per_s": number(rate)} for modes, rate in self.convergence],
            "resonances": [resonance.as_dict("growth_rate_per_s") for resonance in self.resonances],
            "load": self.load.kind_as_dict(),
            "structure": self.whole.structure,
            "method": self.whole.method,
            "cost": str(verdict.cost),
            "note": verdict.note,
        }

    def edge(
        self,
        verdict: RodStability,
        varied: Quantity,
        piece: tuple[float, float],
        seconds: float,
        progress: Progress | None,
    ) -> Edge:
        """Return where the verdict first changes, with as many modes as the piece needs."""
        piece = up_to_wall(self.model.rod, self.load, varied, piece)
        if varied == "frequency":
            piece = up_to_resonance(self.model.rod, self.load, piece)
        if piece[0] == piece[1]:
            return Edge(None, piece[0], 0.0)
        begins = None if piece[0] == getattr(self.load, varied) else verdict.stable
        try:
            modes = self._modes_for(varied, piece, verdict.margin_tolerance)
        except ValueError:  # too many modes, or loads too large or too slow: nothing is known of them
            return Edge(None, piece[0], 0.0)
        return first_change(
            varied,
            modes,
            self.load,
            piece,
            verdict.margin_tolerance,
            begins_stable=begins,
            most_seconds=seconds,
            progress=progress,
        )

    def _modes_for(self, varied: Quantity, piece: tuple[float, float], tolerance: float) -> CoupledEquations:
        """Return as many modes as all loads of a piece need, and not fewer than here, or as many as were asked for."""
        if len(self.convergence) == 1:
            return self.coupled
        loads = Loads.along(self.load, varied, np.linspace(*piece, 33))
        needed = self.model.count_for(loads, tolerance)
        return self.model.in_modes(max(needed, self.coupled.count))

    def sentence(self, verdict: RodStability) -> str:
        """Return status, growth, what grows, and how large the vibration becomes."""
        wave = "" if self.load.is_uniform or not self.load.amplitude else f"; {verdict.axial.in_words}"
        if verdict.status != "unstable" or not self.resonances:
            slow = f": growth {verdict.growth_rate:.6g} 1/s" if verdict.growth_rate > 0.0 else ""
            return f"{verdict.status}{slow}{wave}"
        growth = f"{verdict.growth_rate:.6g} 1/s, tenfold in {verdict.time_to_grow():.3g} s"
        return f"unstable: {self.resonances[0]}; {growth}{wave}"


def classify_coupled(
    model: ModeModel, load: Load, count: int | None, growth_tolerance: float, progress: Progress | None = None
) -> RodStability:
    """Classify a rod with as many modes as two numbers of them agree upon, or with ``count`` of them.

    ``progress`` is called with the numbers of trials made and, as far as is known by then, to make.
    """
    model = model.under(load)
    found = _trials(model, load, count, growth_tolerance, progress)
    final = found[-1]
    status, error, note = final.concluded(_compared(model, found), growth_tolerance)
    whole = final.whole
    forced = final.modes.forced_angle(load, final.system)
    return RodStability(
        rod=model.rod,
        evidence=ModesTogether(
            model,
            tuple((trial.modes.count, trial.whole.growth_rate) for trial in found),
            final.modes,
            final.system,
            whole,
            0 if final.part is None else final.part.below,
        ),
        growth_tolerance=growth_tolerance,
        status=status,
        growth_rate=whole.growth_rate,
        exponents=whole.exponents,
        period=whole.period,
        error=error,
        cost=whole.cost,
        note=note,
        assumptions=assumptions(model.rod, load) + (() if forced is None else (forced_in_words(forced),)),
    )


def _trials(
    model: ModeModel, load: Load, count: int | None, growth_tolerance: float, progress: Progress | None
) -> list[_WithModes]:
    """Return the trials made, the fewest modes first."""
    found: list[_WithModes] = []

    def add(modes: int, known: int) -> None:
        chosen = model.in_modes(modes)
        place = sum(trial.modes.count < modes for trial in found)
        larger = found[-1] if place < len(found) else None
        fewer = None if larger is None else larger.with_fewer(chosen)
        found.insert(place, fewer or _WithModes.of(chosen, load, None if larger is None else larger.system))
        if progress is not None:
            progress(len(found), max(known, len(found)))

    if count is not None:
        add(count, 1)
        return found
    last, fewer = _modes_to_begin_with(model, load, growth_tolerance)
    add(last, 2)
    first = found[0]
    numbers = _numbers(model, load, first, fewer, growth_tolerance)
    if last not in numbers:
        found.clear()
    for modes in sorted(numbers - {last}, reverse=True):  # fewer follow from more
        add(modes, len(numbers))
    while _may_be_concluded(found[-1], _compared(model, found), growth_tolerance):
        larger = math.ceil(1.25 * found[-1].modes.count)
        if len(found) == len(numbers) + _ENLARGEMENTS or larger > MOST_COUPLED or not found[-1].is_sharp:
            break
        add(larger, 2)
    needed = 0 if found[-1] is first else _more_needed(model, load, found[-1], growth_tolerance)
    if needed:
        add(needed, 2)
    return found


def _numbers(model: ModeModel, load: Load, first: _WithModes, fewer: int, growth_tolerance: float) -> set[int]:
    """Return the numbers of modes whose verdicts are compared to begin with, two or three.

    That of the first verdict, with more where these may matter, else with fewer; or as many as harmonics drive, and
    more.  Three where two may agree by chance.
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
            fewer = min(fewer, count - max(2, count // _share(model, count)))
        numbers = fewer, count
        by_chance = by_chance or are_enriched(model.rod.end_conditions)
    return {*numbers, sum(numbers) // 2} if by_chance else {*numbers}


def _compared(model: ModeModel, found: Sequence[_WithModes]) -> Sequence[_WithModes]:
    """Return the trials that tell how the growth of the last one depends on the number of modes.

    Where the curvature of a channel jumps, growth goes up and down with it, as where modes are added that harmonics
    drive (see `_driven`): two numbers of modes may agree by chance.
    """
    rod = model.rod
    return found[-3:-1] if rod.course.breaks or are_enriched(rod.end_conditions) else found[-2:-1]


def _driven(model: ModeModel, load: Load, trial: _WithModes) -> int:
    """Return how many modes hold those that the harmonics of growing motion drive; 0 where none may be near them.

    Motion that grows has the frequencies nu + k w, each of which may be near that of a mode far above those that grow.
    Sines hardly drive such a mode, but other functions do: growth stands still over some numbers of modes, and changes
    once that mode is among them.  Taken are modes up to (H + 1) w - nu under a force of H harmonics, at most twice as
    many as there are, as what is driven farther above hardly moves, and no more than a verdict takes a second for.
    """
    enriched, count = are_enriched(model.rod.end_conditions), trial.modes.count
    if not enriched or count > _LONG or not trial.least > -model.rod.damping_rate:
        return 0
    turns = abs(trial.whole.exponents[0].imag) / load.frequency
    highest = 1.0 + len(load.harmonics) - abs(turns - round(turns))
    uniform = require_few(model.rod, load, Loads.single(load), 0.0)
    below = constants_under(model.rod, uniform.mean).modes_below(highest * load.frequency, uniform.mean)
    return min(below + _BESIDE, 2 * count, _LONG)


def _share(model: ModeModel, count: int) -> int:
    """Return which part of the modes, one in so many, the second trial leaves out.

    More where others join the beam functions: growth then hardly changes over a few numbers of modes and goes on
    changing after them.
    """
    if are_enriched(model.rod.end_conditions):
        return 4
    return 6 if count <= _LONG else 10


def _may_be_concluded(trial: _WithModes, fewer: Sequence[_WithModes], tolerance: float) -> bool:
    """Return whether more modes may decide what these leave open: not where rounding hides the multipliers."""
    status, error, _ = trial.concluded(fewer, tolerance)
    return status == "undecided" and error < math.inf


def _more_needed(model: ModeModel, load: Load, trial: _WithModes, growth_tolerance: float) -> int:
    """Return how many modes to take where those left out may grow faster than what was found, else 0.

    So many more that both trials tell how the growth depends on their number.
    """
    count = trial.modes.count
    if count >= MOST_COUPLED:
        return 0
    slowest = max(growth_tolerance, 0.5 * trial.whole.growth_rate)
    needed = model.count_for(Loads.single(load), slowest)
    return min(max(needed, count + max(2, count // 9)), MOST_COUPLED) if needed > count else 0


def _modes_to_begin_with(model: ModeModel, load: Load, growth_tolerance: float) -> tuple[int, int]:
    """Return how many modes to take, of long strings only those that may grow a quarter as fast as the fastest.

    And how many of these the second trial takes.  Of several these few, which hold what grows, so that it can be
    followed; the first trial then takes more.
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
    if SEVERAL < last <= _LONG and not are_enriched(rod.end_conditions):
        return last + max(2, last // 9), last
    return last, last - max(2, last // _share(model, last))


class _Judged(NamedTuple):
    """The verdict on many equations, the fastest solution where it is known, and which modes were judged, if not all.

    The solution is in the coordinates of all equations.
    """

    whole: SystemStability
    fastest: Fastest | None = None
    part: Resonating | None = None

    @classmethod
    def of(cls, system: HillSystem, part: Resonating | None) -> _Judged:
        """Return what is found of all equations, or of the modes of a part of them."""
        subject = system if part is None else part.system
        freed = subject.undamped
        if freed is None or freed[0].structure != "hamiltonian":
            return cls(stability(system))
        whole, fastest = cls._found(subject, freed)
        if part is None:
            return cls(whole, fastest)
        return cls(whole, None if fastest is None else fastest.among(system, part.basis), part)

    @staticmethod
    def _found(system: HillSystem, freed: tuple[HillSystem, float]) -> tuple[SystemStability, Fastest | None]:
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


class _WithModes(NamedTuple):
    """The verdict with one number of modes, and between what the rate of the fastest solution lies, in 1/s.

    Of many modes the fastest solution itself, too, where it is known, and those that may resonate, where the verdict is
    on them.
    """

    modes: CoupledEquations
    system: HillSystem
    whole: SystemStability
    least: float
    most: float
    fastest: Fastest | None = None
    part: Resonating | None = None

    @classmethod
    def of(cls, modes: CoupledEquations, load: Load, larger: HillSystem | None) -> _WithModes:
        """Return the verdict with some modes; ``larger`` is the system of more of them, if it is known."""
        nested = larger is not None and modes.are_nested
        system = restricted(larger, slice(modes.size)) if larger and nested else modes.system(Loads.single(load))
        if modes.count <= SEVERAL:
            return cls._judged(modes, system, _Judged(stability(system)))
        return cls._judged(modes, system, _Judged.of(system, resonating(system)))

    @classmethod
    def _judged(cls, modes: CoupledEquations, system: HillSystem, judged: _Judged) -> _WithModes:
        whole, fastest, part = judged
        fastest = fastest if modes.are_nested else None
        # Where solutions come in pairs only the one that decays more slowly matters of each: the error of the other's
        # multiplier may exceed it, where the first one grows fast.
        slower = slice(len(whole.exponents) // (2 if undamped_pairs(system) else 1))
        rates = np.array([exponent.real for exponent in whole.exponents[slower]])
        errors = np.array(whole.exponent_errors[slower])
        known = np.isfinite(errors)
        if not known.any():
            return cls(modes, system, whole, -math.inf, math.inf)
        # The errors of multipliers that cannot be distinguished reach below them, too.
        most = min(float((rates + errors)[known].max()) if known.all() else math.inf, whole.growth_below)
        return cls(modes, system, whole, float((rates - errors)[known].max()), most, fastest, part)

    def with_fewer(self, modes: CoupledEquations) -> _WithModes | None:
        """Return what fewer modes do, from what is known of these; None where that is not possible.

        By following the fastest solution: a verdict on all their solutions would take as long as the one there is, and
        decides nothing, as how the growth depends on the number of modes is what is asked.  Or by a verdict on the
        modes that may resonate, the last functions held at zero.
        """
        rate = None if self.fastest is None else self.fastest.rate_with(modes.count)
        if rate is None:
            held = self.modes.size - modes.size
            part = self.part.without_last(held) if self.part is not None and modes.are_nested else None
            return None if part is None else self._judged(modes, self.system, _Judged.of(self.system, part))
        whole = replace(
            self.whole,
            status="unstable" if rate > 0.0 else "stable",
            growth_rate=max(rate, 0.0),
            exponents=(complex(rate, self.whole.exponents[0].imag),),
            exponent_errors=(0.0,),
            krein_signs=(0,),
        )
        return self._replace(modes=modes, whole=whole, least=rate, most=rate, fastest=None)

    @property
    def rate(self) -> float:
        """Rate of the fastest solution in 1/s, negative where it decays."""
        return self.whole.exponents[0].real if self.whole.exponents else math.nan

    @property
    def is_sharp(self) -> bool:
        """Whether rounding leaves room for a verdict that more modes could change."""
        return self.whole.status != "undecided"

    def _change(self, fewer: _WithModes) -> float:
        """Return the error in 1/s for the modes left out, as if it fell as slowly as one over their number."""
        count = fewer.modes.count
        return count / (self.modes.count - count) * abs(self.rate - fewer.rate)

    def concluded(self, fewer: Sequence[_WithModes], tolerance: float) -> tuple[Status, float, str]:
        """Return verdict, error of the growth rate in 1/s and note, given other trials with fewer modes."""
        change = max(map(self._change, fewer), default=0.0)
        error = max(self.most - self.rate, self.rate - self.least) + change
        if not error < math.inf:
            if self.whole.status == "unstable" and self.least - change > tolerance:
                least = f"growth is at least {self.least - change:.6g} 1/s"
                return "unstable", math.inf, f"{least}, beside which slower solutions are lost in rounding"
            return "undecided", math.inf, self.whole.note or "multipliers could not be computed"
        if tolerance > 0.0:
            if self.least - change > tolerance:
                return "unstable", error, self.whole.note
            if self.most + change <= tolerance:
                return "stable", error, self.whole.note
            return "undecided", error, f"growth {self.rate:.3g} 1/s is within its error {error:.1g} of the tolerance"
        for other in (other for other in fewer if other.whole.status != self.whole.status):
            counts = f"{other.modes.count} modes say {other.whole.status}, {self.modes.count} {self.whole.status}"
            return "undecided", error, counts
        # Without damping stable rates are zero, and as sure as the multipliers' verdict; all others may change sign.
        if abs(self.rate) <= change and change > self.most - self.rate:
            return "undecided", error, f"growth {self.rate:.3g} 1/s with {self.modes.count} modes is within its error"
        return self.whole.status, error, self.whole.note
