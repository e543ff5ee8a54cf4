"""Modes under a force that is partly random: verdicts in mean square, from the second moments of independent modes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, NoReturn

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arguments import Mention, wrong_value
from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.progress import Progress
from floquetrod.equations.batches import pick
from floquetrod.floquet.dispatch import run, stability
from floquetrod.floquet.first_change import root_below, separation
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.status import STABLE, STATUS_CODES, UNDECIDED, UNSTABLE
from floquetrod.floquet.verdict import Cost, Status, tolerated
from floquetrod.rod.answers.critical_value import CriticalValue
from floquetrod.rod.answers.evidence import NoisyEvidence
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import Load, Loads, largest_density, noise_in_words, scaled_noise
from floquetrod.rod.mode_equations.moment_coefficients import ModeCoefficients
from floquetrod.rod.mode_equations.noisy_equations import ASSUMED, NoisyModes
from floquetrod.rod.mode_equations.slow_noise import growth_as_stiffness_drifts, may_grow_as_stiffness_drifts
from floquetrod.rod.model.assumptions import assumptions
from floquetrod.rod.model.constants import mode_constants
from floquetrod.rod.model.contact import constants_under, require_on_wall
from floquetrod.rod.modes.mode_model import Answers, ModeModel
from floquetrod.rod.modes.sampled_model import SampledModel
from floquetrod.units import AnswerUnits

if TYPE_CHECKING:
    from floquetrod.floquet.multipliers.many_verdicts import ManyVerdicts
    from floquetrod.floquet.proof.region_proof import RegionProof
    from floquetrod.rod.mode_equations.coupled_systems import CoupledEquations

_MOST_IN_REACH = 512  # modes that noise in a band may make grow, at most (a choice)
_AT_ONCE = 1 << 11  # loads that are judged at once (a choice)
_STEP = 16  # modes that are examined before the bounds on others are asked again, then twice as many (a choice)
_LARGEST = 1e9  # density that is tried, in terms of the limit of high modes (a choice)
NEAREST = 1e-10  # of verdicts on both sides of a critical factor, relative (a choice)
_MOST_AGAIN = 64  # modes that a batch leaves undecided, judged one by one in some milliseconds each (a choice)
_MOST_DECISIVE = 256  # modes that a verdict next to a critical factor may need: a closer one would take long (a choice)
_UNEVEN = 1e-3  # of a factor, above which verdicts that are undecided are those of uneven noise (a choice)
_STEPS_UP, _STEP_UP = 80, 1.1  # of a factor in search of one at which the verdict is unstable (a choice)
_PARTS = 2  # of a search for a critical factor that are to come, at least


_HIGH_MODES_GROW = (
    "all high modes grow at {:.3g} 1/s in mean square: the noise has this density at every frequency; give pairs of "
    "frequency and density where it has not"
)

_UNDAMPED = "without damping even the weakest noise makes a mode grow"


@dataclass(frozen=True)
class NoisyModel(SampledModel):
    """Independent modes of hinged ends under a force that is uniform along the rod and has noise.

    Growth is the growth of second moments, twice the growth of amplitudes.
    """

    loads_at_once: ClassVar[int | None] = 2000
    damping_source: ClassVar[str] = "that of the load whose growth in mean square is worst"

    @property
    def coupling(self) -> tuple[str, ...]:
        """The noise, and all that couples the modes, in words."""
        return (*super().coupling, noise_in_words(self.template.noise))

    def refusal(self, name: str) -> ValueError:
        """Return the error for questions that random motion has no answer to: friction, tests of finite time."""
        there = noise_in_words(self.template.noise)
        return wrong_value(name, f"is not answered under {there}; give the load ", Mention("noise", "noise=0", "0"))

    # --- equations ---

    def _modes(self, mean: float) -> NoisyModes:
        """Return the modes on the side where the rod lies under a mean force."""
        return NoisyModes(constants_under(self.rod, mean), self.template)

    def equations(self, load: Load, modes: Iterable[int] | None = None) -> NoReturn:
        """Raise ValueError: what obeys a linear system are second moments."""
        raise self.refusal("modal_system")

    def modes_needed(self, load: Load, growth_tolerance: float) -> tuple[int, float]:
        """Return how many modes decide a verdict, and a bound in 1/s on the growth of all others in mean square."""
        return self._modes(load.mean).modes_needed(load, growth_tolerance)

    def growth_beyond(self, load: Load) -> float:
        """Return how fast in 1/s all high modes grow in mean square, 0 where they do not."""
        return max(0.0, NoisyModes(constants_under(self.rod, load.mean), load).limit())

    def in_modes(self, count: int) -> CoupledEquations:
        """Raise ValueError: second moments are not systems of second order."""
        raise self.refusal("modal_system")

    def modes_apart(self, modes: Iterable[int]) -> tuple[int, ...]:
        """Return the modes: each has an equation of its own."""
        return tuple(modes)

    # --- verdicts ---

    def verdict(
        self,
        load: Load,
        modes: Iterable[int] | None = None,
        growth_tolerance: float = 0.0,
        progress: Progress | None = None,
    ) -> RodStability:
        """Return the verdict in mean square under one load."""
        require_on_wall(self.rod, load)
        chosen = None if modes is None else validate.modes(modes)
        return classify_noisy(self.under(load), load, chosen, growth_tolerance, progress)

    def answers(
        self, loads: Loads, growth_tolerance: float = 0.0, workers: int | None = None, progress: Progress | None = None
    ) -> Answers:
        """Return status, growth of second moments in 1/s and the fastest mode, -1 where only the highest grow."""
        mode_constants(self.rod).require_in_reach(loads)
        status, growth = np.full(loads.size, UNDECIDED, dtype=np.int8), np.full(loads.size, np.nan)
        fastest = np.zeros(loads.size, dtype=np.int64)
        sides = list(self.on_sides(loads))
        done = loads.size - sum(at.size for at, *_ in sides)
        for at, constants, there in sides:
            modes = NoisyModes(constants, self.template)
            for start in range(0, at.size, _AT_ONCE):
                block = at[start : start + _AT_ONCE]
                block_loads = there.some(slice(start, start + _AT_ONCE))
                status[block], growth[block], fastest[block] = _examined(modes, block_loads, growth_tolerance, workers)
                done += block.size
                if progress is not None:
                    progress(done, loads.size)
        return Answers(status, growth, fastest)

    def growth_of_modes(self, load: Load, modes: Iterable[int]) -> tuple[float, ...]:
        """Return the growth of the second moments of modes in 1/s."""
        modes_there = NoisyModes(constants_under(self.rod, load.mean), load)
        parts = modes_there.parts(Loads.single(load), list(modes))
        return tuple(_rates(parts, np.ones(parts.squared.shape, dtype=np.bool_), None).growth.tolist())

    # --- margins ---

    def buckles(self, load: Load, growth_tolerance: float) -> bool:
        """Return whether the mean force alone buckles a mode."""
        modes = self.under(load)._modes(load.mean)
        last, _ = modes.constants.modes_needed(load, growth_tolerance)
        return bool(modes.parts(Loads((1,), *Loads.single(load).flat), range(1, last + 1)).squared.min() <= 0.0)

    def critical_noise(self, load: Load, growth_tolerance: float, progress: Progress | None = None) -> CriticalValue:
        """Return the largest factor of the noise of a load at which it is stable in mean square, and its error.

        Each mode grows the faster the more noise there is.  From a factor at which a mode grows, it is lowered to where
        the fastest mode no longer grows, until no other grows there.
        """
        require_on_wall(self.rod, load)
        search = _FactorSearch(self, load, growth_tolerance, progress)
        if not self.is_stable(replace(load, noise=0.0), growth_tolerance):
            raise unstable_without_noise()
        return search.critical()

    def is_stable(self, load: Load, growth_tolerance: float) -> bool:
        """Return whether a rod is seen to be stable in mean square under one load."""
        if self.under(load).growth_beyond(load) > growth_tolerance:
            return False
        return super().is_stable(load, growth_tolerance)

    def is_calm(self, load: Load, growth_tolerance: float) -> bool:
        """Return whether no second moment is seen to grow, as it may be where slow or uneven noise leaves that open."""
        growth = self.under(load).answers(Loads((1,), *Loads.single(load).flat), growth_tolerance).growth[0]
        return bool(growth <= growth_tolerance)

    def certify(
        self,
        sides: tuple[Any, Any, Any],
        growth_tolerance: float,
        rod: Mapping[str, Any] | None,
        max_boxes: int,
        progress: Progress | None,
    ) -> RegionProof:
        """Prove every load of a box of forces at one frequency stable or unstable in mean square."""
        from floquetrod.rod.answers.rod_box_proof import units_of_box
        from floquetrod.rod.modes.noisy_proof import certify_noisy

        proof = certify_noisy(self, sides, growth_tolerance, rod, max_boxes, progress)
        return proof.given_in(units_of_box(sides, self.template, self.rod))


def _examined(modes: NoisyModes, loads: Loads, growth_tolerance: float, workers: int | None) -> Answers:
    """Return status, growth and fastest mode of each load, from the modes that bounds do not exclude."""
    # Arrays over loads: best is the largest growth known, last the number of modes that may exceed it, from bounds that
    # fall with the mode.  Modes are examined in groups of growing size, for the loads still going; a mode is computed
    # only where its bound from above exceeds what is known, or may pass the tolerance.  ``low`` and ``high`` bound the
    # growth of a mode, in 1/s: where they decide its status nothing is computed.  Each group raises best and so lowers
    # last.
    bounds = modes.growth_bounds(loads)
    best, fastest = np.full(loads.size, bounds.limit), np.full(loads.size, -1)
    grows, unsure, lost = np.full(loads.size, bounds.limit > growth_tolerance), *np.zeros((2, loads.size), np.bool_)
    firm = grows.copy()  # whatever noise that is uneven about twice a mode's frequency does
    last, examined = bounds.modes_needed(bounds.least, growth_tolerance), np.zeros(loads.size, dtype=np.int64)
    first, step = 1, _STEP
    while (going := np.flatnonzero(last >= first)).size:
        numbers = np.arange(first, min(first + step - 1, int(last.max())) + 1)
        parts, known = modes.parts(loads.some(going), numbers), np.maximum(best, bounds.least)[going, None]
        low, high = parts.growth_bounds
        matters = (high > np.maximum(known, 0.0) + bounds.negligible) | (
            (high > growth_tolerance) & (known <= growth_tolerance)
        )
        chosen = (numbers <= last[going, None]) & matters
        answers = _rates(parts, chosen, workers)
        status, rates = np.where(low > growth_tolerance, UNSTABLE, STABLE), low.copy()
        status[chosen & (low <= growth_tolerance)] = answers.status[(low <= growth_tolerance)[chosen]]
        status[high <= growth_tolerance] = STABLE
        rates[chosen] = np.clip(answers.growth, low[chosen], high[chosen])
        lost[going] |= np.isnan(rates).any(axis=1)
        rates = np.where(np.isnan(rates), low, rates)
        grows[going] |= ((status == UNSTABLE) & ~tolerated(rates, growth_tolerance)).any(axis=1)
        least = _with_least_noise(modes, parts, status, rates, growth_tolerance, workers)
        firm[going] |= ((status == UNSTABLE) & (least > growth_tolerance)).any(axis=1)
        unsure[going] |= (status == UNDECIDED).any(axis=1)
        most, where = rates.max(axis=1), rates.argmax(axis=1)
        faster = most > best[going]
        best[going[faster]], fastest[going[faster]] = most[faster], numbers[where[faster]]
        examined[going] = np.minimum(last[going], numbers[-1])
        last[going] = bounds.some(going).modes_needed(np.maximum(best, bounds.least)[going], growth_tolerance)
        first, step = first + step, 2 * step
    unsure |= bounds.left_out(examined) > growth_tolerance
    left = np.flatnonzero(~(grows & firm))  # nothing that is uneven or slow makes these stable
    unsure[left] |= _with_most_noise(modes, loads.some(left), growth_tolerance, workers).growth > growth_tolerance
    status = np.where(grows & firm, UNSTABLE, np.where(grows | unsure, UNDECIDED, STABLE)).astype(np.int8)
    growth = np.where(lost, np.nan, np.maximum(best, 0.0))
    return Answers(status, growth, np.where(best > 0.0, fastest, 0))


def _with_least_noise(
    modes: NoisyModes, parts: ModeCoefficients, status: Any, rates: Floats, growth_tolerance: float, workers: int | None
) -> Floats:
    """Return the least growth in 1/s of modes that grow, as their noise is uneven or slow."""
    growing = status == UNSTABLE
    if not (isinstance(modes.template.noise, tuple) and growing.any()):
        return rates
    least = parts.with_density(modes.densities(parts).least)
    chosen = growing & (least.intensity < parts.intensity)
    found = rates.copy()
    found[chosen] = np.fmin(rates[chosen], _rates(least, chosen, workers).growth)
    return np.fmin(found, _as_stiffness_drifts(modes, parts, growth_tolerance, growing, workers))


def _as_stiffness_drifts(
    modes: NoisyModes, parts: ModeCoefficients, growth_tolerance: float, chosen: Bools, workers: int | None
) -> Floats:
    """Return the growth in 1/s of chosen modes as their stiffness drifts with slow noise, NaN where none grows."""
    return growth_as_stiffness_drifts(
        parts, modes.excess(parts), modes.template.noise, growth_tolerance, chosen, workers
    )


class _Strongest(NamedTuple):
    """Growth in 1/s of the mode that may grow fastest as its noise is uneven or slow, for each load; -inf: none grows.

    Its number, twice its frequency in Hz, the distance in Hz from there within which the noise acts together, and the
    root mean square in N of slow noise that makes the growth, 0 where uneven noise does.
    """

    growth: Floats
    mode: Ints
    hertz: Floats
    distance: Floats
    slow: Floats


def _with_most_noise(
    modes: NoisyModes, loads: Loads, growth_tolerance: float, workers: int | None, numbers: Ints | None = None
) -> _Strongest:
    """Return growth beyond a tolerance of the ``numbers``, by default of all modes, as their noise is uneven or slow.

    That is under the largest density with which noise may act that is uneven about twice their frequency, or as their
    stiffness drifts.
    """
    numbers = _in_reach(modes, loads, growth_tolerance) if numbers is None else numbers
    if not (numbers.size and loads.size):
        return _Strongest(np.full(loads.size, -np.inf), *np.zeros((4, loads.size)))
    parts = modes.parts(loads, numbers)
    densities = modes.densities(parts)
    most = parts.with_density(densities.most)
    high = most.growth_bounds[1]
    chosen = (most.intensity > parts.intensity) & (high > growth_tolerance)
    uneven = np.full(chosen.shape, -np.inf)
    if chosen.any():
        uneven[chosen] = np.fmin(np.nan_to_num(_rates(most, chosen, workers).growth, nan=np.inf), high[chosen])
    drifting = _as_stiffness_drifts(modes, parts, growth_tolerance, np.ones(chosen.shape, np.bool_), workers)
    growth = np.fmax(uneven, drifting)
    growth = np.where((growth > growth_tolerance) & ~tolerated(growth, growth_tolerance), growth, -np.inf)
    place, rows = growth.argmax(axis=1), np.arange(loads.size)
    at = rows, place
    slow = np.where(uneven[at] > growth_tolerance, 0.0, np.sqrt(modes.excess(parts).variance[at]))
    return _Strongest(growth[at], numbers[place], parts.reference[at], densities.distance[at], slow)


def _in_reach(modes: NoisyModes, loads: Loads, growth_tolerance: float) -> Ints:
    """Return the numbers of the modes that uneven or slow noise may make grow.

    Those up to twice the highest frequency of the noise, and those that a bound lets grow as their stiffness drifts.
    """
    noise, numbers = modes.template.noise, np.arange(1, _MOST_IN_REACH + 1)
    if not isinstance(noise, tuple) or not loads.size:
        return numbers[:0]
    largest = Loads((1,), *(np.array([values.max()]) for values in loads.flat))
    parts = modes.parts(largest, numbers)
    drifts = may_grow_as_stiffness_drifts(parts, modes.excess(parts), noise, growth_tolerance)[0]
    return np.asarray(numbers[(parts.hertz[0] <= 2.0 * noise[-1][0]) | drifts])


def _rates(parts: ModeCoefficients, chosen: Bools, workers: int | None) -> ManyVerdicts:
    """Return status and growth in 1/s of the second moments of some modes, in the order of C; 0 where they decay.

    Undecided to about 1e-11 of a multiplier: many digits would take a second each.
    """
    from floquetrod.floquet.multipliers.many_verdicts import ManyVerdicts
    from floquetrod.systems.batch_verdicts import verdicts

    if not chosen.any():
        return ManyVerdicts(np.zeros(0, dtype=np.int8), np.zeros(0))
    moments = parts.moments(chosen)
    status, growth = verdicts(moments, workers=workers, quick=True)
    # Multipliers many decades apart, as those of strong damping, have no joint error in a batch, but each its own.
    for i in np.flatnonzero(status == UNDECIDED)[:_MOST_AGAIN]:
        alone = run("monodromy", pick(moments, int(i)))
        if alone.status != "undecided":
            status[i], growth[i] = STATUS_CODES[alone.status], alone.growth_rate
    return ManyVerdicts(status, growth * np.broadcast_to(parts.rate, chosen.shape)[chosen])


def classify_noisy(
    model: ModeModel, load: Load, chosen: tuple[int, ...] | None, growth_tolerance: float, progress: Progress | None
) -> RodStability:
    """Classify the second moments of every mode that matters and put the verdicts together."""
    # Modes 1, 2, ... are examined in groups of `_STEP`.  ``limit`` is the growth that modes of high number approach
    # under white noise; bounds on all modes beyond the last one examined fall with its number, and give the number that
    # may still grow faster than ``best``, the fastest so far, or than the tolerance: the loop ends where as many are
    # examined.  Rates in 1/s.
    equations = NoisyModes(constants_under(model.rod, load.mean), load)
    examined = _Examined(equations, load)
    limit, left_out = -math.inf, math.inf
    if chosen:
        examined.add(chosen, len(chosen), progress)
    else:
        bounds = equations.growth_bounds(Loads.single(load))
        limit, best = bounds.limit, bounds.least
        while len(examined.modes) < (last := int(bounds.modes_needed(best, growth_tolerance)[0])):
            first = len(examined.modes) + 1
            examined.add(range(first, min(last, first + _STEP - 1) + 1), last, progress)
            best = np.maximum(best, examined.rates.max(initial=-math.inf))
        left_out = float(bounds.left_out(np.array([len(examined.modes)]))[0])
    rates = examined.rates
    status, note = _concluded(examined, (limit, left_out), growth_tolerance)
    status, (below, above), doubt = _under_uneven_noise(examined, status, limit, growth_tolerance, chosen)
    error = examined.error((limit, -math.inf if chosen else left_out))
    exponents = [*examined.exponents, *([complex(limit)] if limit > rates.max() else [])]
    costs = (verdict.cost.amount for verdict in examined.verdicts)
    return RodStability(
        model=model.under(load),
        evidence=NoisyEvidence(
            tuple(examined.modes),
            tuple(examined.verdicts),
            rates,
            np.array(examined.intensities),
            max(0.0, left_out),
            limit,
            (error + below, error + above),
        ),
        growth_tolerance=growth_tolerance,
        status=status,
        growth_rate=max(0.0, float(rates.max()), limit),
        exponents=tuple(sorted(exponents, key=lambda exponent: -exponent.real)),
        period=2.0 * math.pi / load.frequency,
        error=error + max(below, above),
        cost=Cost(sum(costs), "operations"),
        note="; ".join(filter(None, [note, doubt])),
        undecided_by=doubt if status == "undecided" else "",
        assumptions=(*assumptions(model.rod, load), *ASSUMED),
    )


def _under_uneven_noise(
    examined: _Examined, status: Status, limit: float, growth_tolerance: float, chosen: tuple[int, ...] | None
) -> tuple[Status, tuple[float, float], str]:
    """Return the verdict where noise may be uneven about twice a mode's frequency or slow, errors of growth, and why.

    Errors in 1/s: how much slower the growth may be under the least density about each mode, and how much faster under
    the largest; a drift of the stiffness that lowers growth may as well raise it.
    """
    modes, loads, rates = examined.equations, Loads.single(examined.load), examined.rates
    flat = Loads((1,), *loads.flat)
    strongest = _with_most_noise(modes, flat, growth_tolerance, None, None if chosen is None else np.array(chosen))
    most, fastest = float(strongest.growth[0]), max(0.0, float(rates.max()), limit)
    statuses = np.array([[STATUS_CODES[verdict.status] for verdict in examined.verdicts]])
    parts = modes.parts(flat, examined.modes)
    least = _with_least_noise(modes, parts, statuses, rates[None, :], growth_tolerance, None)[0]
    below = fastest - max(0.0, limit, float(least.max()))
    off = below, max(below, most - fastest)
    if status == "stable" and most > growth_tolerance:
        hertz, mode = f"{strongest.hertz[0]:.4g} Hz", f"twice the frequency of mode {int(strongest.mode[0])}"
        grows = f"the mode may grow at about {most:.2g} 1/s in mean square"
        if not strongest.slow[0]:
            within = f"within {strongest.distance[0]:.2g} Hz of {hertz}"
            doubt = f"the noise is uneven {within}, {mode}: {grows}"
        else:
            force = AnswerUnits.named(given=examined.load.given_units).force
            slow = f"noise of {force.show(float(strongest.slow[0]), 3)} below {hertz}"
            doubt = f"{slow}, {mode}, changes the stiffness slowly: {grows}"
        doubt += ", see fr.filtered_growth"
        return "undecided", off, doubt
    if status == "unstable" and max(limit, float(least.max())) <= growth_tolerance:
        doubt = "the noise is uneven about twice the frequencies of the modes that grow, or slower: see theory/noise"
        return "undecided", off, doubt
    return status, off, ""


def high_modes_grow(limit: float, damping_rate: float) -> str:
    """Return that all high modes grow, at ``limit`` in 1/s in mean square, and what would prevent it."""
    return _HIGH_MODES_GROW.format(limit) + (f"; {_UNDAMPED}" if damping_rate == 0.0 else "")


class _Examined:
    """Modes under a load: the verdict on the second moments of each, and their growth in 1/s between bounds."""

    def __init__(self, equations: NoisyModes, load: Load) -> None:
        """Take the equations; nothing is examined yet."""
        self.equations, self.load = equations, load
        self.modes: list[int] = []
        self.verdicts: list[SystemStability] = []
        self.intensities: list[float] = []
        self.exponents: list[complex] = []
        self.rates, self.low, self.high = np.zeros((3, 0))

    def add(self, modes: Sequence[int], total: int, progress: Progress | None) -> None:
        """Examine more modes; the bounds that hold for high ones are often closer than the errors of verdicts."""
        parts = self.equations.parts(Loads.single(self.load), modes)
        moments = parts.moments(np.ones((1, len(modes)), dtype=np.bool_))
        units = np.broadcast_to(parts.rate, (1, len(modes)))[0].tolist()
        growths = []
        for i, unit in enumerate(units):
            verdict = stability(pick(moments, i))
            self.verdicts.append(verdict)
            self.exponents.extend(unit * exponent for exponent in verdict.exponents)
            known = bool(verdict.exponents)
            rate, error = (verdict.exponents[0].real, verdict.exponent_errors[0]) if known else (math.nan, math.inf)
            growths.append((unit * rate, unit * error))
            if progress is not None:
                progress(len(self.verdicts), total)
        low, high = (bound[0] for bound in parts.growth_bounds)
        rates, errors = np.array(growths).T
        self.rates = np.append(self.rates, np.clip(np.fmax(rates, -math.inf), low, high))
        status = np.array([verdict.status for verdict in self.verdicts[len(self.modes) :]])
        low, high = np.fmax(low, rates - errors), np.fmin(high, rates + errors)
        self.low = np.append(self.low, np.where(status == "unstable", np.maximum(low, 0.0), low))
        self.high = np.append(self.high, np.where(status == "stable", np.minimum(high, 0.0), high))
        self.modes.extend(modes)
        self.intensities.extend(parts.intensity[0].tolist())

    def error(self, others: tuple[float, float]) -> float:
        """Return the error in 1/s of the growth rate, no less than of the fastest mode's.

        Of the other modes the limit of high ones and a bound.
        """
        limit, left_out = others
        fastest = int(self.rates.argmax())
        rate, low, high = (
            max(0.0, *values)
            for values in (
                (float(self.rates.max()), limit),
                (float(self.low.max()), limit),
                (float(self.high.max()), left_out),
            )
        )
        own = max(self.high[fastest] - self.rates[fastest], self.rates[fastest] - self.low[fastest])
        return float(max(rate - low, high - rate, own if self.rates[fastest] >= limit else 0.0))


def _concluded(examined: _Examined, others: tuple[float, float], growth_tolerance: float) -> tuple[Status, str]:
    """Return the verdict on all modes, and what to know of it; ``others`` grow at least, and at most, so fast."""
    limit, left_out = others
    verdicts, rates = examined.verdicts, examined.rates.tolist()
    damping_rate = float(examined.equations.constants.damping_rate)
    if limit > growth_tolerance:
        return "unstable", high_modes_grow(limit, damping_rate)
    grows = [
        v.status == "unstable" and not tolerated(rate, growth_tolerance)
        for v, rate in zip(verdicts, rates, strict=True)
    ]
    if any(grows) or examined.low.max() > growth_tolerance:
        is_shaken = any(g and s > 0.0 for g, s in zip(grows, examined.intensities, strict=True))
        return "unstable", _UNDAMPED if is_shaken and damping_rate == 0.0 else ""
    unsure = [
        v
        for v, high in zip(verdicts, examined.high, strict=True)
        if v.status == "undecided" and not high < growth_tolerance
    ]
    if unsure:
        return "undecided", "; ".join(dict.fromkeys(v.note for v in unsure))
    if growth_tolerance < left_out < math.inf:
        return "undecided", f"higher modes may grow at up to {left_out:.2g} 1/s in mean square"
    return "stable", ""


class _FactorSearch:
    """A search for the largest factor of the noise of a load at which a rod is stable in mean square."""

    def __init__(self, model: NoisyModel, load: Load, growth_tolerance: float, progress: Progress | None) -> None:
        """Take what does not vary."""
        self.model, self.load, self.tolerance, self.progress = model.under(load), load, growth_tolerance, progress
        self.constants = constants_under(model.rod, load.mean)
        self.done = 0

    def told(self, left: int) -> None:
        """Report that a part of the search is done, and how many there are still at least."""
        self.done += 1
        if self.progress is not None:
            self.progress(self.done, self.done + left)

    def scaled(self, factor: float) -> Load:
        """Return the load with its noise a factor as large."""
        return replace(self.load, noise=scaled_noise(self.load.noise, factor))

    def modes(self, factor: float) -> NoisyModes:
        """Return the modes under so much noise."""
        return NoisyModes(self.constants, self.scaled(factor))

    def critical(self) -> CriticalValue:
        """Return the factor."""
        decay = 2.0 * float(self.constants.damping_rate) + self.tolerance
        per_density = 0.25 * float(self.constants.per_newton) ** 2 / float(self.constants.bending)
        most = decay / (per_density * float(largest_density(self.load.noise, 0.0)))
        if not most > 0.0:  # else any noise that a mode feels makes it grow
            raise unstable_without_noise()
        factor, mode = most, None
        if isinstance(self.load.noise, tuple):  # high modes feel none
            farthest = _LARGEST * most
            while self.fastest(factor) is None:
                factor *= 4.0
                self.told(_PARTS)
                if factor > farthest:
                    searched = 0.25 * factor
                    return self.within_unevenness(math.inf, None, searched) or CriticalValue(
                        math.inf, "noise", searched=searched, error=math.inf
                    )
        while (faster := self.fastest(factor)) is not None and faster != mode:
            before, mode = factor, faster
            factor = self.root(faster, before)
            self.told(_PARTS)
            if not factor < before * (1.0 - 1e-13):  # two modes begin to grow together
                break
        uneven = self.within_unevenness(factor, mode, factor)
        if uneven is None:
            uneven = CriticalValue(factor, "noise", error=self.error(factor, mode), mode=mode)
        self.told(0)
        return uneven

    def within_unevenness(self, factor: float, mode: int | None, searched: float) -> CriticalValue | None:
        """Return the largest factor at which noise that is uneven about twice a mode's frequency leaves all stable.

        ``factor`` is that of white noise, where ``mode`` begins to grow.  The error reaches to a factor at which the
        verdict is unstable, infinite where none was found.  None where such verdicts change as under white noise.
        """
        # The largest density with which noise may act on a mode grows with the factor, as does the band that acts
        # together: the growth that it may make rises, and bisection finds where it passes the tolerance.
        loads = Loads((1,), *Loads.single(self.load).flat)

        def may_grow(trial: float) -> _Strongest | None:
            strongest = _with_most_noise(self.modes(trial), loads, self.tolerance, None)
            return strongest if strongest.growth[0] > self.tolerance else None

        def is_unstable(trial: float) -> bool:
            return int(self.model.under(self.scaled(trial)).status(loads, self.tolerance)[0]) == UNSTABLE

        if not isinstance(self.load.noise, tuple):
            return None
        low = high = searched * (1.0 - 4.0 * NEAREST)
        grown = may_grow(high)
        is_early = grown is not None
        if grown is None and (math.isinf(factor) or is_unstable(factor * (1.0 + _UNEVEN))):
            return None
        while grown is not None and may_grow(low) is not None:
            low, high = 0.25 * low, low
        while is_early and high > low * (1.0 + NEAREST):
            middle = math.sqrt(low * high)
            if (found := may_grow(middle)) is None:
                low = middle
            else:
                high, grown = middle, found
        above = factor * (1.0 + _UNEVEN)
        for _ in range(_STEPS_UP):
            if math.isinf(above) or is_unstable(above):
                break
            above *= _STEP_UP
        else:
            above = math.inf
        number = mode if grown is None else int(grown.mode[0])
        return CriticalValue(low, "noise", error=above - low, mode=number)

    def fastest(self, factor: float) -> int | None:
        """Return the mode that grows fastest beyond the tolerance, None where none does."""
        answers = _examined(self.modes(factor), Loads((1,), *Loads.single(self.load).flat), self.tolerance, None)
        return int(answers.mode[0]) if answers.growth[0] > self.tolerance and answers.mode[0] > 0 else None

    def root(self, mode: int, high: float) -> float:
        """Return the factor at which the growth of a mode is that tolerated, below one at which it is larger."""

        def excess(factor: float) -> float:
            parts = self.modes(factor).parts(Loads.single(self.load), [mode])
            low, most = (float(bound[0, 0]) for bound in parts.growth_bounds)
            moments = run("monodromy", pick(parts.moments(np.ones((1, 1), dtype=np.bool_)), 0))
            if not moments.exponents:
                raise wrong_value("load", f"must be one under which mode {mode} can be judged, got {self.load!r}")
            rate = moments.highest_rate * float(np.broadcast_to(parts.rate, (1, 1))[0, 0])
            return float(np.clip(rate, low, most)) - self.tolerance

        factor = root_below(excess, high, _LARGEST)
        if math.isnan(factor):
            raise unstable_without_noise()
        return factor

    def error(self, factor: float, mode: int | None) -> float:
        """Return how near to a factor verdicts, single ones and arrays, change from stable to unstable.

        ``mode`` is the one that begins to grow, None where all high modes do.
        """

        def is_apart(apart: float) -> bool:
            below, above = (self.scaled(factor * (1.0 + sign * apart)) for sign in (-1.0, 1.0))
            needed, _ = NoisyModes(self.constants, below).modes_needed(below, self.tolerance)
            return needed <= _MOST_DECISIVE and all(self.separate(below, above, mode))

        return separation(is_apart, NEAREST) * factor

    def separate(self, below: Load, above: Load, mode: int | None) -> Iterator[bool]:
        """Yield whether arrays say that one load is stable and another is not, and then whether verdicts do.

        Arrays judge all modes, to fewer digits than a verdict, which only the critical mode needs.
        """
        for load, status in ((below, STABLE), (above, UNSTABLE)):
            at = Loads((1,), *Loads.single(load).flat)
            yield int(self.model.under(load).status(at, self.tolerance)[0]) == status
        if mode is None:
            return
        for load, status in ((below, STABLE), (above, UNSTABLE)):
            verdict = self.model.under(load).verdict(load, [mode], growth_tolerance=self.tolerance)
            yield STATUS_CODES[verdict.status] == status


def unstable_without_noise() -> ValueError:
    """Return the error for a load without a critical noise."""
    return wrong_value("load", "must be stable without noise to have a critical one, got one that is not")
