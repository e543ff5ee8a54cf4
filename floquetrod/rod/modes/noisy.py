"""Modes under a force that is partly random: verdicts in mean square, from the second moments of independent modes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arguments import Mention, wrong_value
from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.parts import runs
from floquetrod._util.progress import Progress
from floquetrod.floquet.systems.many import STABLE, UNDECIDED, UNSTABLE
from floquetrod.floquet.verdict import tolerated
from floquetrod.rod.answers.intervals import FoundIntervals, Search, StabilityInterval, UnstableBand
from floquetrod.rod.answers.verdict import RodStability
from floquetrod.rod.loads.load import Load, Loads, noise_in_words
from floquetrod.rod.mode_equations.noisy_modes import NoisyModes
from floquetrod.rod.model.constants import mode_constants
from floquetrod.rod.model.contact import constants_under, require_on_wall
from floquetrod.rod.modes.mode_model import Answers, ModeModel, Statuses
from floquetrod.rod.modes.noisy_search import critical_noise, damping_required, edge, stable_at

if TYPE_CHECKING:
    from floquetrod.floquet.proof.region import RegionProof
    from floquetrod.rod.mode_equations.coupled_systems import CoupledEquations

_AT_ONCE = 1 << 17  # modes under loads that are judged at once (a choice)
_CLOSER = 17  # places in a band at which growth is examined (a choice)


@dataclass(frozen=True)
class NoisyModel(ModeModel):
    """Independent modes of hinged ends under a force that is uniform along the rod and has noise.

    Growth is that of second moments, twice that of amplitudes.
    """

    loads_at_once: ClassVar[int | None] = 2000
    samples: ClassVar[int] = 257
    """Places between the bounds of a search."""
    damping_found: ClassVar[str] = "that of the load whose growth in mean square is worst"

    @property
    def coupling(self) -> tuple[str, ...]:
        """What keeps the modes from obeying Mathieu's equation each, the noise and what couples them."""
        return (*super().coupling, noise_in_words(self.like.noise))

    def require(self, name: str) -> NoReturn:
        """Raise ValueError: friction, tests of finite time and the like are not asked of random motion."""
        raise refusal(name, self.like)

    def require_varied(self, names: Iterable[str]) -> None:
        """Do nothing: the load may vary, and where the rod does each sample is judged by itself."""
        for name in names:
            if name not in ("mean", "amplitude", "frequency"):
                raise refusal(f"{name} in parameters", self.like)

    # --- equations ---

    def _modes(self, mean: float) -> NoisyModes:
        """Return the modes on the side where the rod lies under a mean force."""
        return NoisyModes(constants_under(self.rod, mean), self.like)

    def equations(self, load: Load, modes: Iterable[int] | None = None) -> NoReturn:
        """Raise ValueError: what obeys a linear system are second moments."""
        raise refusal("modal_system", self.like)

    def modes_needed(self, load: Load, growth_tolerance: float) -> tuple[int, float]:
        """Return how many modes decide a verdict, and a bound in 1/s on the growth of all others in mean square."""
        return self._modes(load.mean).modes_needed(load, growth_tolerance)

    def growth_beyond(self, load: Load) -> float:
        """Return how fast in 1/s all high modes grow at least in mean square, 0 where that is not known."""
        return self._modes(load.mean).growth_beyond(load)

    def in_modes(self, count: int) -> CoupledEquations:
        """Raise ValueError: second moments are not systems of second order."""
        raise refusal("modal_system", self.like)

    def told_apart(self, modes: Iterable[int]) -> tuple[int, ...]:
        """Return the modes, each of which has an equation of its own."""
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
        from floquetrod.rod.modes.noisy_verdict import classify_noisy

        require_on_wall(self.rod, load)
        chosen = None if modes is None else validate.modes(modes)
        return classify_noisy(self.under(load), load, chosen, growth_tolerance, progress)

    def rates(self, loads: Loads, modes: Sequence[int], workers: int | None = None) -> tuple[Statuses, Floats]:
        """Return status and growth rate of second moments, (loads, modes); 0 where they decay.

        Undecided to about 1e-11 of a multiplier: many digits would take a second each.
        """
        from floquetrod.systems.arrays import verdicts

        status = np.full((loads.size, len(modes)), STABLE, dtype=np.int8)
        growth = np.zeros(status.shape)
        for at, some in self._sides(loads):
            parts = some.parts(loads.some(at), modes)
            open_ones = np.zeros(status.shape, dtype=np.bool_)
            most = np.broadcast_to(parts.growth_bounds[1], (at.size, len(modes)))
            unknown = np.logical_not(most < -1e-9 * parts.damping)
            open_ones[at] = unknown
            if unknown.any():
                found = verdicts(parts.moments(unknown), workers=workers, quick=True)
                status[open_ones] = found.status
                growth[open_ones] = found.growth * np.broadcast_to(parts.rate, unknown.shape)[unknown]
        return status, growth

    def _sides(self, loads: Loads) -> Iterator[tuple[Ints, NoisyModes]]:
        """Yield the modes on either side of the channel, with the places of the loads that hold the rod there."""
        constants = mode_constants(self.rod)
        if self.rod.course.is_straight:
            yield np.arange(loads.size), NoisyModes(constants, self.like)
            return
        sides = constants.sides(*loads.flat[:2])
        for side in (1, -1):
            at = np.flatnonzero(sides == side)
            if at.size:
                yield at, NoisyModes(constants.on_side(side), self.like)

    def answers(
        self, loads: Loads, growth_tolerance: float = 0.0, workers: int | None = None, progress: Progress | None = None
    ) -> Answers:
        """Return status, growth of second moments in 1/s and the number of the fastest mode."""
        mode_constants(self.rod).require_in_reach(loads)
        status, growth = np.full(loads.size, UNDECIDED, dtype=np.int8), np.full(loads.size, np.nan)
        fastest = np.zeros(loads.size, dtype=np.int64)
        lies = self._lying(loads)
        if lies.any():
            strongest = self.like.with_numbers(*(float(values[lies].max()) for values in loads.flat))
            last, left_out = self.modes_needed(strongest, growth_tolerance)
            beyond = self.growth_beyond(strongest)
        step = max(1, _AT_ONCE // max(1, last if lies.any() else 1))
        for start in range(0, loads.size, step):
            part = np.flatnonzero(lies[start : start + step]) + start
            if part.size:
                every, rates = self.rates(loads.some(part), range(1, last + 1), workers)
                status[part], growth[part] = _together(every, rates, growth_tolerance, left_out)
                if beyond > growth_tolerance:
                    status[part], growth[part] = UNSTABLE, np.maximum(growth[part], beyond)
                fastest[part] = np.where(growth[part] > 0.0, rates.argmax(axis=1) + 1, 0)
            if progress is not None:
                progress(min(loads.size, start + step), loads.size)
        return Answers(status, growth, fastest)

    def _lying(self, loads: Loads) -> Bools:
        """Return under which loads the rod stays on its wall; LeavesWallError for a single one where it does not."""
        if self.rod.course.is_straight:
            return np.ones(loads.size, dtype=np.bool_)
        if loads.shape == ():
            require_on_wall(self.rod, self.like.with_numbers(*(float(part[0]) for part in loads.flat)))
        return np.asarray(mode_constants(self.rod).sides(*loads.flat[:2]) != 0)

    def growth_of_modes(self, load: Load, modes: Iterable[int]) -> tuple[float, ...]:
        """Return the growth of the second moments of modes in 1/s."""
        return tuple(self.under(load).rates(Loads.single(load), list(modes))[1][0].tolist())

    # --- along a quantity ---

    def ranges(self, search: Search, progress: Progress | None) -> FoundIntervals:
        """Return the stability intervals of one quantity of the load, sampled; ``resolution`` is their distance."""
        self.require_on_wall(search)
        places = np.linspace(*search.bounds, self.samples)
        stable = stable_at(self, search, places, progress)
        found = []
        for first, after in runs(stable):
            low = search.bounds[0] if first == 0 else edge(self, search, places[first], places[first - 1])
            ends = after == self.samples
            high = search.bounds[1] if ends else edge(self, search, places[after - 1], places[after])
            found.append(StabilityInterval(low, high, None if first == 0 else "unnamed", None if ends else "unnamed"))
        modes = self.count_for(Loads.along(search.load, search.varied, places), search.growth_tolerance)
        return FoundIntervals(tuple(found), modes, 0, float(places[1] - places[0]))

    def first_unstable(self, search: Search, progress: Progress | None = None) -> float:
        """Return where a quantity that grows from zero first meets growth; infinite without any."""
        self.require_on_wall(search)
        places = np.linspace(*search.bounds, self.samples)
        stable = stable_at(self, search, places, progress)
        unstable = np.flatnonzero(~stable)
        if not unstable.size:
            return math.inf
        first = int(unstable[0])
        return 0.0 if first == 0 else edge(self, search, float(places[first - 1]), float(places[first]))

    def unstable_bands(
        self, search: Search, modes: int, bands: Sequence[tuple[float, float]], progress: Progress | None
    ) -> tuple[UnstableBand, ...]:
        """Return what grows in each band in mean square, sampled, and the damping that the fastest growth requires."""
        found, model = [], self.under(search.load)
        for done, (low, high) in enumerate(bands, start=1):
            places = np.linspace(low, high, _CLOSER)
            growth = model.answers(Loads.along(search.load, search.varied, places)).growth
            worst = int(np.nan_to_num(growth).argmax())
            at = float(places[worst])
            damping = model.damping_required(search.load.varied(search.varied, at), search.growth_tolerance)
            found.append(UnstableBand(low, high, float(np.nan_to_num(growth)[worst]), at, "unnamed", damping))
            if progress is not None:
                progress(done, len(bands))
        return tuple(found)

    def damping_required(self, load: Load, growth_tolerance: float) -> float:
        """Return the least damping rate in 1/s above which a load is stable in mean square, as far as tried."""
        return damping_required(self, load, growth_tolerance)

    def critical_noise(self, load: Load, growth_tolerance: float) -> float:
        """Return the largest factor of the noise of a load at which it is stable in mean square, to 1e-10."""
        return critical_noise(self, load, growth_tolerance)

    def certify(self, *asked: Any) -> RegionProof:
        """Prove every load of a box of forces at one frequency stable or unstable in mean square."""
        from floquetrod.rod.modes.noisy_proof import certify_noisy

        return certify_noisy(self, *asked)

    def largest_safe_box(self, *given: Any) -> NoReturn:
        """Raise ValueError: boxes are searched for without noise."""
        raise refusal("largest_safe_box", self.like)


def _together(status: Statuses, growth: Floats, growth_tolerance: float, left_out: float) -> tuple[Statuses, Floats]:
    """Return status and growth of all modes of each load from those of each mode."""
    fine = (status == STABLE) | ((status == UNSTABLE) & tolerated(growth, growth_tolerance))
    worst = np.where((status == UNSTABLE) & ~fine, UNSTABLE, np.where(fine, STABLE, UNDECIDED)).astype(np.int8)
    together = np.where((worst == UNSTABLE).any(axis=1), UNSTABLE, worst.min(axis=1)).astype(np.int8)
    if left_out > growth_tolerance:
        together[together == STABLE] = UNDECIDED
    return together, growth.max(axis=1)


def refusal(name: str, load: Load) -> ValueError:
    """Return the error for what is not asked of random motion."""
    return wrong_value(
        name, f"is not answered under {noise_in_words(load.noise)}; give the load ", Mention("noise", "noise=0", "0")
    )
