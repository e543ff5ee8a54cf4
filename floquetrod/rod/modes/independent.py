"""Independent modes: each an equation of Mathieu's, whose tongues are found by counting."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.caching import cached_property
from floquetrod._util.compilation import over_chunks
from floquetrod._util.progress import Progress
from floquetrod._util.spans import complement
from floquetrod.rod.answers.margins import Edge
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
    from floquetrod.floquet.proof.region_proof import RegionProof
    from floquetrod.mathieu.criterion import FiniteTimeCriterion
    from floquetrod.rod.answers.intervals import FoundIntervals, Search, UnstableBand
    from floquetrod.rod.mode_equations.coupled_systems import CoupledEquations


@dataclass(frozen=True)
class IndependentModel(ModeModel):
    """Modes of hinged ends under a sine that is uniform along the rod."""

    prompt: ClassVar[bool] = True
    counted: ClassVar[str] = "modes"
    samples_at_once: ClassVar[int] = 1 << 17  # some 10 MB
    damping_of: ClassVar[str] = "every sampled load of the band"
    damping_found: ClassVar[str] = "sampled over the band; null where no damping suffices"

    def require(self, name: str) -> None:
        """Raise ValueError for friction where the channel bends; else do nothing: each mode is Mathieu's equation."""
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

    def _filled(
        self, loads: Loads, progress: Progress | None, unknown: Any, ask: Callable[[ModalSystems], Any]
    ) -> NDArray[Any]:
        """Return what the systems of flat loads answer, ``unknown`` where the rod leaves its wall."""
        self.constants.require_in_reach(loads)
        found = []
        for part in loads.in_parts(progress):
            answers = np.full((part.size, *np.shape(unknown)), unknown)
            for at, constants, some in self.on_sides(part):
                answers[at] = ask(ModalSystems(constants, some))
            found.append(answers)
        return np.concatenate(found)

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
        return self._filled(loads, progress, np.int8(-1), lambda some: some.are_stable(growth_tolerance, workers))

    def fastest(
        self, loads: Loads, workers: int | None = None, progress: Progress | None = None
    ) -> tuple[Floats, Ints]:
        """Return the growth in 1/s and the number of the fastest mode; 0, 0 where none grows.

        NaN and 0 where the rod leaves its wall.
        """
        found = self._filled(loads, progress, (np.nan, 0.0), lambda some: np.column_stack(some.fastest(workers)))
        return found[:, 0], found[:, 1].astype(np.int64)

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

    def first_growth(self, search: Search, progress: Progress | None) -> Edge:
        """Return where a mode first grows within bounds, from the low one up, by its tongues."""
        varied, load, piece, tolerance = search
        modes = self._equations(load.varied(varied, piece[1]), tolerance).modes
        system = ModalSystem(self.constants, load, modes)
        found = unstable_loads(varied, system, tolerance, piece, union=True, nearest=piece[0])
        at = min((part.low for part in found.intervals), default=None)
        return Edge(at, piece[1] if at is None else at, found.resolution)

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

    # --- a test of finite time, samples and proofs ---

    def passing(
        self, loads: Loads, criterion: FiniteTimeCriterion, workers: int | None, progress: Progress | None
    ) -> Statuses:
        """Return 1 where every mode passes the test, else 0; -1 where the rod leaves its wall."""
        return self._filled(loads, progress, np.int8(-1), lambda some: some.pass_test(criterion, workers))

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
        from floquetrod.rod.kernels.modes import modes_stable_fill

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
            modes_stable_fill,
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


def _cause(part: UnstableInterval | None) -> tuple[int, int] | None:
    """Return what grows next to a stability interval; None at an end of the search."""
    return None if part is None else (part.mode, part.tongue)
