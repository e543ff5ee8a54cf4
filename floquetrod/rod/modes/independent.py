"""Independent modes: each an equation of Mathieu's, whose tongues are found by counting."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.caching import cached_property
from floquetrod._util.compilation import over_chunks
from floquetrod._util.parts import complement
from floquetrod._util.progress import Progress
from floquetrod.rod.answers.verdict import RodStability
from floquetrod.rod.loads.load import Load, Loads, Quantity
from floquetrod.rod.mode_equations.modal_systems import ModalSystem, ModalSystems
from floquetrod.rod.mode_equations.tongues import UnstableInterval, unstable_loads
from floquetrod.rod.model.constants import (
    NEGLIGIBLE_GROWTH,
    ModeConstants,
    are_in_reach,
    at_once,
    extent,
    mode_constants,
)
from floquetrod.rod.model.contact import LeavesWallError, constants_under, require_on_wall
from floquetrod.rod.modes.independent_verdict import classify_modes
from floquetrod.rod.modes.mode_model import Answers, BandFinder, ModeModel, Statuses

# Loaded by the methods that need them: a first verdict takes a quarter of the package.
if TYPE_CHECKING:
    from floquetrod.floquet.proof.region import RegionProof
    from floquetrod.mathieu.criterion import FiniteTimeCriterion
    from floquetrod.rod.answers.intervals import FoundIntervals, Search, UnstableBand
    from floquetrod.rod.answers.safe_box import SafeBox
    from floquetrod.rod.friction.kicks import CriticalKick, FrictionalRodStability
    from floquetrod.rod.mode_equations.coupled_systems import CoupledEquations

_PIECES: dict[Quantity, int] = {"mean": 32, "amplitude": 8}  # that the first edge is searched in, one by one (a choice)


@dataclass(frozen=True)
class IndependentModel(ModeModel):
    """Modes of hinged ends under a sine that is uniform along the rod."""

    prompt: ClassVar[bool] = True
    counted: ClassVar[str] = "modes"
    samples_at_once: ClassVar[int] = 1 << 17  # some 10 MB
    damping_of: ClassVar[str] = "every sampled load of the band"
    damping_found: ClassVar[str] = "sampled over the band; null where no damping suffices"

    def require(self, name: str) -> None:
        """Raise ValueError for friction where the channel bends; else do nothing: all can be asked."""
        if name == "friction" and not self.rod.course.is_straight:
            raise validate.wrong_value(
                name,
                "with a kick is evaluated in straight channels only: in this one the contact force changes with the "
                "force along the rod; leave friction out, or give no curvature",
            )

    @cached_property
    def constants(self) -> ModeConstants:
        """What the equations need of the rod."""
        return mode_constants(self.rod)

    # --- equations ---

    def equations(self, load: Load, modes: Iterable[int] | None = None) -> ModalSystem:
        """Return the equations of some modes, by default all that can matter, under one load."""
        if modes is None:
            return self._equations(load, 0.0)
        chosen = validate.modes(modes)
        constants = self._lying(load)
        constants.require_in_reach(Loads.single(load))
        return ModalSystem(constants, load, chosen)

    def _equations(self, load: Load, tolerance: float) -> ModalSystem:
        """Return the equations of all modes that can grow faster than the tolerance."""
        last, left_out = self.modes_needed(load, tolerance)
        return ModalSystem(self._lying(load), load, tuple(range(1, last + 1)), left_out)

    def _lying(self, load: Load) -> ModeConstants:
        """Return the constants on the side where the rod lies; LeavesWallError where it does not stay there."""
        require_on_wall(self.rod, load)
        return constants_under(self.rod, load.mean)

    def _sides(self, loads: Loads) -> Iterator[tuple[Ints, ModalSystems]]:
        """Yield the systems of flat loads on either side of the channel, with their places among all."""
        if self.rod.course.is_straight:
            yield np.arange(loads.size), self.systems(loads)
            return
        sides = self.constants.sides(*loads.flat[:2])
        if loads.shape == () and not sides.all():
            self._lying(self.like.with_numbers(*(float(part[0]) for part in loads.flat)))
        for side in (1, -1):
            at = np.flatnonzero(sides == side)
            if at.size:
                yield at, ModalSystems(self.constants.on_side(side), loads.some(at))

    def modes_needed(self, load: Load, growth_tolerance: float) -> tuple[int, float]:
        """Return how many modes decide a verdict, and a bound in 1/s on the growth of every mode beyond them."""
        return constants_under(self.rod, load.mean).modes_needed(load, growth_tolerance)

    def in_modes(self, count: int) -> CoupledEquations:
        """Return the first modes as systems of equations, one by one."""
        from floquetrod.rod.mode_equations.coupled_matrices import CoupledModes

        return CoupledModes.of(self.rod, self.like, count)

    def systems(self, loads: Loads) -> ModalSystems:
        """Return the equations of all modes under many loads."""
        self.constants.require_in_reach(loads)
        if not self.rod.course.is_straight and not (self.constants.sides(*loads.flat[:2]) == 1).all():
            raise LeavesWallError(
                "loads must leave the rod on the low side of its channel; ask for each by modal_system"
            )
        return ModalSystems(self.constants, loads)

    def among_tongues(self, load: Load, modes: Iterable[int]) -> ModalSystem:
        """Return the equations of some modes."""
        return self.equations(load, modes)

    # --- verdicts ---

    def verdict(
        self,
        load: Load,
        modes: Iterable[int] | None = None,
        growth_tolerance: float = 0.0,
        progress: Progress | None = None,
    ) -> RodStability:
        """Return the verdict under one load."""
        # The growth rate is that of all modes, tolerated or not.
        return classify_modes(self.rod, self.equations(load, modes), growth_tolerance)

    def status(
        self, loads: Loads, growth_tolerance: float = 0.0, workers: int | None = None, progress: Progress | None = None
    ) -> Statuses:
        """Return 1 where no mode grows faster than the tolerance, else 0."""
        self.constants.require_in_reach(loads)
        found = []
        for part in loads.in_parts(progress):
            status = np.full(part.size, -1, dtype=np.int8)
            for at, systems in self._sides(part):
                status[at] = systems.are_stable(growth_tolerance, workers)
            found.append(status)
        return np.concatenate(found)

    def fastest(
        self, loads: Loads, workers: int | None = None, progress: Progress | None = None
    ) -> tuple[Floats, Ints]:
        """Return the growth in 1/s and the number of the fastest mode; 0, 0 where none grows.

        NaN and 0 where the rod leaves its wall.
        """
        self.constants.require_in_reach(loads)
        found = []
        for part in loads.in_parts(progress):
            growth, mode = np.full(part.size, np.nan), np.zeros(part.size, dtype=np.int64)
            for at, systems in self._sides(part):
                growth[at], mode[at] = systems.fastest(workers)
            found.append((growth, mode))
        return tuple(map(np.concatenate, zip(*found, strict=True)))  # type: ignore[return-value]

    def answers(
        self, loads: Loads, growth_tolerance: float = 0.0, workers: int | None = None, progress: Progress | None = None
    ) -> Answers:
        """Return status, growth and fastest mode of each load, the status by itself: counts decide it sooner."""
        return Answers(self.status(loads, growth_tolerance, workers, progress), *self.fastest(loads, workers, progress))

    def growth_of_modes(self, load: Load, modes: Iterable[int]) -> tuple[float, ...]:
        """Return the growth in 1/s of modes."""
        return tuple(self.verdict(load, modes).mode_growth_rates.tolist())

    # --- along a quantity, and over two ---

    def ranges(self, search: Search, progress: Progress | None) -> FoundIntervals:
        """Return the stability intervals of one quantity of the load, complete except for ``resolution``."""
        from floquetrod.rod.answers.intervals import FoundIntervals, StabilityInterval

        varied, load, bounds, tolerance = search
        self.require_on_wall(search)
        system = self._equations(load, tolerance)
        found = unstable_loads(varied, system, tolerance, bounds, union=True, progress=progress)
        gaps = complement(bounds, found.intervals)
        stable = tuple(StabilityInterval(*gap[:2], _cause(gap.before), _cause(gap.after)) for gap in gaps)
        return FoundIntervals(stable, system.modes[-1], found.tongues_left_out, found.resolution)

    def first_unstable(self, search: Search, progress: Progress | None = None) -> float:
        """Return where a quantity that grows from zero first meets growth; infinite without any."""
        varied, load, bounds, tolerance = search
        self.require_on_wall(search)
        ends = np.linspace(*bounds, _PIECES[varied] + 1).tolist()
        for done, piece in enumerate(pairwise(ends), start=1):
            modes = self._equations(load.varied(varied, piece[1]), tolerance).modes
            system = ModalSystem(self.constants, load, modes)
            found = unstable_loads(varied, system, tolerance, piece, union=True, nearest=piece[0]).intervals
            if found:
                return min(part.low for part in found)
            if progress is not None:
                progress(done, _PIECES[varied])
        return math.inf

    def unstable_bands(
        self, search: Search, modes: int, bands: Sequence[tuple[float, float]], progress: Progress | None
    ) -> tuple[UnstableBand, ...]:
        """Return what grows in each band, sampled in every tongue of it."""
        from floquetrod.rod.modes.unstable_bands import BandSearch

        return BandSearch(self.rod, search, modes).unstable_bands(bands)

    def bands(self, across: Quantity, up: Quantity, fixed: float, growth_tolerance: float) -> BandFinder | None:
        """Return what finds the unstable bands of a map between exact curves."""
        from floquetrod.rod.modes.independent_bands import ExactBands

        return ExactBands(self.constants, across, up, fixed, growth_tolerance)

    # --- a kick against friction, and a test of finite time ---

    def passing(self, loads: Loads, criterion: FiniteTimeCriterion, workers: int | None) -> Statuses:
        """Return 1 where every mode passes the test, else 0; -1 where the rod leaves its wall."""
        self.constants.require_in_reach(loads)
        found = np.full(loads.size, -1, dtype=np.int8)
        for at, systems in self._sides(loads):
            found[at] = systems.pass_test(criterion, workers)
        return found

    def kicked(self, loads: Loads, friction: float, kick: float, tolerance: float, workers: int | None) -> Statuses:
        """Return 1 where a kick in m/s destabilises no mode, 0 where one, and -1 where that could not be decided."""
        from floquetrod.rod.friction.kicks import kicked_loads

        self.require("friction")

        return kicked_loads(self.rod, self.systems(loads), friction, kick, tolerance, workers)

    def with_kick(self, linear: RodStability, friction: float, kick: float) -> FrictionalRodStability:
        """Return the verdict with friction that follows on one without."""
        from floquetrod.rod.friction.kicks import classify_kick

        self.require("friction")

        return classify_kick(linear, friction, kick)

    def critical_kicks(self, loads: Loads, friction: float, tolerance: float, workers: int | None) -> CriticalKick:
        """Return the smallest kicks that destabilise a mode."""
        from floquetrod.rod.friction.kicks import critical_kicks

        self.require("friction")

        return critical_kicks(self.rod, self.systems(loads), friction, tolerance, workers)

    # --- samples and proofs ---

    def require_varied(self, names: Iterable[str]) -> None:
        """Do nothing: every number of rod and load may be different in every sample."""

    def sample_status(
        self,
        rods: Mapping[str, Any],
        loads: Loads,
        tolerance: float,
        workers: int | None,
        require: Callable[[Bools], None],
    ) -> Statuses:
        """Return the status of rods, by what is not given as a number an array, under loads, one by one.

        Those that leave their wall are not decided.
        """
        from floquetrod.rod.kernels.modes import samples_stable_fill

        mean, amplitude, frequency = loads.flat
        constants = ModeConstants.of(rods, sin=np.sin)
        side: Any = 1.0
        if np.any(constants.held):
            side = constants.sides(mean, amplitude)
            constants = constants.on_side(np.where(side == 0, 1, side))
        extents = extent(constants, np.maximum(0.0, mean + amplitude), np.abs(mean) + amplitude)
        require(are_in_reach(constants, extents, frequency))
        modes, fastest = extents
        out = np.empty(loads.size, dtype=np.bool_)
        over_chunks(
            samples_stable_fill,
            [*loads.flat, *(np.broadcast_to(np.asarray(part, dtype=np.float64), out.shape) for part in constants)],
            out,
            tolerance,
            NEGLIGIBLE_GROWTH,
            workers=workers,
            chunk=at_once(float(np.max(modes)), float(np.max(fastest / frequency))),
        )
        return np.where(side == 0, np.int8(-1), out.view(np.int8))

    def certify(self, *asked: Any) -> RegionProof:
        """Prove every load of a box stable or unstable."""
        from floquetrod.rod.answers.region import certify_rods

        return certify_rods(self.rod, self.like, *asked)

    def largest_safe_box(self, load: Load, *asked: Any) -> SafeBox:
        """Return the largest proved box about a load."""
        from floquetrod.rod.answers.safe_box import largest_safe_box

        return largest_safe_box(self.rod, load, partial(self.verdict, load, None), *asked)

    def certified_cells(self, *asked: Any) -> Statuses:
        """Return what is proved of every cell of a map."""
        from floquetrod.rod.answers.certified_map import certified_cells

        return certified_cells(self.rod, self.like, *asked)


def _cause(part: UnstableInterval | None) -> tuple[int, int] | None:
    """Return what grows next to a stability interval; None at an end of the search."""
    return None if part is None else (part.mode, part.tongue)
