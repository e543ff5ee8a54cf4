"""Independent modes: each obeys an equation of Mathieu's, whose tongues are located by counts."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, cast

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.caching import cached_property
from floquetrod._util.compilation import over_chunks
from floquetrod._util.progress import Progress
from floquetrod._util.spans import complement
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.first_change import FirstChange
from floquetrod.floquet.verdict import Cost, tolerated
from floquetrod.parameter import require_known
from floquetrod.rod.answers.evidence import IndependentEvidence
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import Load, Loads, Quantity
from floquetrod.rod.mode_equations.modal_systems import ModalSystem, ModalSystems
from floquetrod.rod.mode_equations.unstable_loads import UnstableInterval, unstable_loads
from floquetrod.rod.model.assumptions import assumptions
from floquetrod.rod.model.constants import (
    NEGLIGIBLE_GROWTH,
    ModeConstants,
    are_in_reach,
    at_once,
    extent,
    mode_constants,
)
from floquetrod.rod.model.contact import LeavesWallError, constants_under, require_on_wall, up_to_wall
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.parameters import ROD
from floquetrod.rod.modes.mode_model import Answers, BandFinder, ModeModel, Statuses

# Loaded by the methods that need them: a first verdict takes a quarter of the package.
if TYPE_CHECKING:
    from floquetrod.floquet.proof.region_proof import RegionProof
    from floquetrod.mathieu.paper_criterion import FiniteTimeCriterion
    from floquetrod.rod.answers.stability_intervals import BandBeyond, Search, StabilityIntervals, UnstableBand
    from floquetrod.rod.mode_equations.coupled_systems import CoupledEquations


@dataclass(frozen=True)
class IndependentModel(ModeModel):
    """Modes of hinged ends under a sine that is uniform along the rod."""

    prompt: ClassVar[bool] = True
    samples_at_once: ClassVar[int] = 1 << 17  # some 10 MB
    damping_subject: ClassVar[str] = "at every load sampled in it"
    damping_source: ClassVar[str] = "sampled over the band; null where no damping suffices"

    def require(self, name: str) -> None:
        """Raise ValueError for friction where the channel bends; else do nothing: each mode is Mathieu's equation."""
        if name == "friction":
            require_known(self.rod, ROD, "kicks")
        if name == "friction" and not self.rod.course.is_straight:
            raise validate.wrong_value(
                name,
                "with a kick is evaluated in straight channels only: in this one the contact force changes with the "
                "force along the rod; leave friction out, or give no curvature",
            )

    @cached_property
    def constants(self) -> ModeConstants:
        """Constants of the rod in the equations of its modes."""
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
        """Return an answer of the systems of flat loads, ``unknown`` where the rod leaves its wall."""
        self.constants.require_in_reach(loads)
        blocks = []
        for block in loads.in_parts(progress):
            answers = np.full((block.size, *np.shape(unknown)), unknown)
            for at, constants, on_side in self.on_sides(block):
                answers[at] = ask(ModalSystems(constants, on_side))
            blocks.append(answers)
        return np.concatenate(blocks)

    def modes_needed(self, load: Load, growth_tolerance: float) -> tuple[int, float]:
        """Return how many modes decide a verdict, and a bound in 1/s on the growth of every mode beyond them."""
        return constants_under(self.rod, load.mean).modes_needed(load, growth_tolerance)

    def in_modes(self, count: int) -> CoupledEquations:
        """Return the first modes as systems of equations, one by one."""
        from floquetrod.rod.mode_equations.coupled_matrices import CoupledModes

        return CoupledModes.of(self.rod, self.template, count)

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
        """Return the verdict under one load, put together from the verdict on each mode."""
        # All modes that may grow are examined, tolerated or not: the growth rate is the fastest of all.
        system = self.equations(load, modes)
        verdicts = tuple(stability(equation) for equation in system.equations)
        rates = np.array([verdict.growth_rate for verdict in verdicts]) * system.frequency
        rows = list(zip(verdicts, rates, strict=True))
        grows = [v.status == "unstable" and not tolerated(rate, growth_tolerance) for v, rate in rows]
        unsure = [v.status == "undecided" and not rate < growth_tolerance for v, rate in rows]
        exponents = [exponent * system.frequency for verdict in verdicts for exponent in verdict.exponents]
        units = {verdict.cost.unit for verdict in verdicts}
        notes = dict.fromkeys(v.note for v, unknown in zip(verdicts, unsure, strict=True) if unknown)
        return RodStability(
            model=self.under(load),
            evidence=IndependentEvidence(system, verdicts, rates),
            growth_tolerance=growth_tolerance,
            status="unstable" if any(grows) else "undecided" if any(unsure) else "stable",
            growth_rate=float(rates.max()),
            exponents=tuple(sorted(exponents, key=lambda exponent: -exponent.real)),
            period=2.0 * math.pi / system.frequency,
            error=max(verdict.error for verdict in verdicts),
            cost=Cost(
                sum(verdict.cost.amount for verdict in verdicts), units.pop() if len(units) == 1 else "operations"
            ),
            note="; ".join(notes),
            assumptions=assumptions(self.rod, load),
        )

    def status(
        self, loads: Loads, growth_tolerance: float = 0.0, workers: int | None = None, progress: Progress | None = None
    ) -> Statuses:
        """Return 1 where no mode grows faster than the tolerance, else 0."""
        return self._filled(loads, progress, np.int8(-1), lambda systems: systems.are_stable(growth_tolerance, workers))

    def fastest(
        self, loads: Loads, workers: int | None = None, progress: Progress | None = None
    ) -> tuple[Floats, Ints]:
        """Return the growth in 1/s and the number of the fastest mode; 0, 0 where none grows.

        NaN and 0 where the rod leaves its wall.
        """
        columns = self._filled(
            loads, progress, (np.nan, 0.0), lambda systems: np.column_stack(systems.fastest(workers))
        )
        return columns[:, 0], columns[:, 1].astype(np.int64)

    def answers(
        self, loads: Loads, growth_tolerance: float = 0.0, workers: int | None = None, progress: Progress | None = None
    ) -> Answers:
        """Return status, growth and fastest mode of each load, the status by itself: counts decide it sooner."""
        return Answers(self.status(loads, growth_tolerance, workers, progress), *self.fastest(loads, workers, progress))

    def growth_of_modes(self, load: Load, modes: Iterable[int]) -> tuple[float, ...]:
        """Return the growth in 1/s of modes."""
        return tuple(self.verdict(load, modes).mode_growth_rates.tolist())

    # --- margins ---

    def damping_to_stabilise(self, verdict: RodStability) -> float:
        """Return the smallest damping rate in 1/s at which, and at every larger one, no mode grows.

        All modes that matter without damping are examined, or those the caller chose.
        """
        undamped = self.rod.replace(damping_rate=0.0)
        modes = _modes_for(verdict, undamped, self.template, 0.0)
        return replace(_system(verdict), modes=modes).damping_to_stabilise

    def margin_edge(
        self,
        verdict: RodStability,
        quantity: Quantity,
        piece: tuple[float, float],
        seconds: float,
        progress: Progress | None,
    ) -> FirstChange:
        """Return where the verdict first changes from ``piece[0]`` to ``piece[1]``, which takes milliseconds."""
        load, tolerance = self.template, verdict.margin_tolerance
        piece = up_to_wall(self.rod, load, quantity, piece)
        low, high = sorted(piece)
        if low == high:
            return FirstChange(None, piece[0], 0.0)
        modes = _modes_for(verdict, self.rod, load.varied(quantity, high), tolerance)
        start = piece[0] if verdict.stable else None  # nothing beyond the first unstable interval matters
        unstable = unstable_loads(
            quantity, replace(_system(verdict), modes=modes), tolerance, (low, high), union=True, nearest=start
        )
        stable = [gap[:2] for gap in complement((low, high), unstable.intervals)]
        if not stable:
            change = piece[0] if verdict.stable else None
        else:
            near, far = stable[0] if piece[0] == low else stable[-1][::-1]
            if not verdict.stable:
                change = near
            elif near != piece[0]:
                change = piece[0]
            else:
                change = far if far != piece[1] else None
        return FirstChange(change, piece[1] if change is None else change, unstable.resolution)

    def band_beyond(self, verdict: RodStability, quantity: Quantity, change: float) -> BandBeyond | None:
        """Return the unstable band in which a margin of a stable load ends, of all modes that matter."""
        if not verdict.stable or math.isinf(_system(verdict).left_out_bound):
            return None
        from floquetrod.rod.answers.stability_intervals import BEYOND, Search
        from floquetrod.rod.modes.unstable_bands import BandSearch

        load, tolerance = self.template, verdict.margin_tolerance
        edge = getattr(load, quantity) + change
        piece = up_to_wall(self.rod, load, quantity, (edge, edge + math.copysign(BEYOND * abs(edge), change)))
        low, high = sorted(piece)
        if low == high:
            return None
        last = _modes_for(verdict, self.rod, load.varied(quantity, high), tolerance)[-1]
        search = Search(quantity, load.varied(quantity, high), (low, high), tolerance)
        return BandSearch(self.rod, search, last).band_beyond(edge)

    # --- along a quantity, and over two ---

    def ranges(self, search: Search, progress: Progress | None) -> StabilityIntervals:
        """Return the stability intervals of one quantity of the load, complete except for ``resolution``."""
        from floquetrod.rod.answers.stability_intervals import StabilityInterval, intervals_along

        varied, load, bounds, tolerance = search
        self.require_on_wall(search)
        system = self._equations(load, tolerance)
        unstable = unstable_loads(varied, system, tolerance, bounds, union=True, progress=progress)
        gaps = complement(bounds, unstable.intervals)
        stable = tuple(StabilityInterval(*gap[:2], _cause(gap.before), _cause(gap.after)) for gap in gaps)
        return intervals_along(
            self,
            search,
            stable,
            system.modes[-1],
            unstable.resolution,
            tongues_left_out=unstable.tongues_left_out,
        )

    def first_growth(self, search: Search, progress: Progress | None) -> FirstChange:
        """Return where a mode first grows within bounds, from the low one up, by its tongues."""
        varied, load, piece, tolerance = search
        modes = self._equations(load.varied(varied, piece[1]), tolerance).modes
        system = ModalSystem(self.constants, load, modes)
        unstable = unstable_loads(varied, system, tolerance, piece, union=True, nearest=piece[0])
        low = min((interval.low for interval in unstable.intervals), default=None)
        return FirstChange(low, piece[1] if low is None else low, unstable.resolution)

    def unstable_bands(
        self, search: Search, modes: int, bands: Sequence[tuple[float, float]], progress: Progress | None
    ) -> tuple[UnstableBand, ...]:
        """Return the growth in each band, sampled in each of its tongues."""
        from floquetrod.rod.modes.unstable_bands import BandSearch

        return BandSearch(self.rod, search, modes).unstable_bands(bands)

    def bands(self, across: Quantity, up: Quantity, fixed: float, growth_tolerance: float) -> BandFinder | None:
        """Return a finder of the unstable bands of a map between exact curves."""
        from floquetrod.rod.modes.independent_bands import ExactBands

        return ExactBands(self.constants, across, up, fixed, growth_tolerance)

    # --- a test of finite time, samples and proofs ---

    def passing(
        self, loads: Loads, criterion: FiniteTimeCriterion, workers: int | None, progress: Progress | None
    ) -> Statuses:
        """Return 1 where every mode passes the test, else 0; -1 where the rod leaves its wall."""
        return self._filled(loads, progress, np.int8(-1), lambda systems: systems.pass_test(criterion, workers))

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
        """Return the status of rods, whose parameters are numbers or arrays, under loads, one by one.

        Those that leave their wall are not decided.
        """
        # Arrays over samples: F, dF, omega and the constants of the modes, each as `modes_stable_fill` takes them.
        # Where the channel bends, the side of the wall on which the rod lies (1 or -1) comes first, since the constants
        # depend on it, 0 where it leaves the wall; then the reach of the formulas; then all samples in threads, in
        # pieces by the work of the largest.
        from floquetrod.rod.kernels.independent_modes import modes_stable_fill

        mean, amplitude, frequency = loads.flat
        constants = ModeConstants.of(rods, sin=np.sin)
        side: Any = 1.0
        if np.any(constants.neutral_squared):
            side = constants.sides(mean, amplitude)
            constants = constants.on_side(np.where(side == 0, 1, side))
        extents = extent(constants, np.maximum(0.0, mean + amplitude), np.abs(mean) + amplitude)
        require(are_in_reach(constants, extents, frequency))
        modes, fastest = extents
        out = np.empty(loads.size, dtype=np.bool_)
        over_chunks(
            modes_stable_fill,
            [
                *loads.flat,
                *(
                    np.broadcast_to(np.asarray(constant, dtype=np.float64), out.shape)
                    for constant in constants.equation
                ),
            ],
            out,
            tolerance,
            NEGLIGIBLE_GROWTH,
            workers=workers,
            chunk=at_once(float(np.max(modes)), float(np.max(fastest / frequency))),
        )
        return np.where(side == 0, np.int8(-1), out.view(np.int8))

    def certify(
        self,
        sides: tuple[Any, Any, Any],
        growth_tolerance: float,
        rod: Mapping[str, Any] | None,
        max_boxes: int,
        progress: Progress | None,
    ) -> RegionProof:
        """Prove every load of a box stable or unstable."""
        from floquetrod.rod.answers.rod_box_proof import certify_rods

        return certify_rods(self.rod, self.template, sides, growth_tolerance, rod, max_boxes, progress)


def _system(verdict: RodStability) -> ModalSystem:
    return cast(IndependentEvidence, verdict.evidence).system


def _modes_for(verdict: RodStability, rod: RodData, load: Load, growth_tolerance: float) -> tuple[int, ...]:
    """Return the modes that matter for another rod or load; modes that the caller chose stay as they are."""
    modes = verdict.modes
    if math.isinf(_system(verdict).left_out_bound):
        return modes
    last, _ = constants_under(rod, load.mean).modes_needed(load, growth_tolerance)
    return tuple(range(1, max(last, modes[-1]) + 1))


def _cause(interval: UnstableInterval | None) -> tuple[int, int] | None:
    """Return mode and tongue next to a stability interval; None at an end of the search."""
    return None if interval is None else (interval.mode, interval.tongue)
