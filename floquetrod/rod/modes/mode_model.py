"""The interface to the modes of a rod under a kind of load: equations, verdicts, ranges, bands, proofs.

`floquetrod.rod.rod.Rod._modes_under` chooses the model; nothing else asks which one it has.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Bools, Floats, Ints
from floquetrod._util.progress import Progress
from floquetrod.equations import HillSystem
from floquetrod.floquet.first_change import FirstChange, outward
from floquetrod.parameter import require_known
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.answers.search_pieces import ends_between
from floquetrod.rod.loads.load import QUANTITIES, Load, Loads, Quantity
from floquetrod.rod.mode_equations.coupling import coupling, refusal
from floquetrod.rod.mode_equations.modal_systems import ModalSystem, ModalSystems
from floquetrod.rod.model.constants import ModeConstants, mode_constants
from floquetrod.rod.model.contact import require_on_wall
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.parameters import ROD

# What a first verdict needs not.
if TYPE_CHECKING:
    from floquetrod.floquet.proof.region_proof import RegionProof
    from floquetrod.mathieu.paper_criterion import FiniteTimeCriterion
    from floquetrod.plane import Axis, FoundBands
    from floquetrod.rod.answers.critical_value import CriticalValue
    from floquetrod.rod.answers.stability_intervals import BandBeyond, Search, StabilityIntervals, UnstableBand
    from floquetrod.rod.mode_equations.coupled_systems import CoupledEquations

Statuses = NDArray[np.int8]


class BandFinder(Protocol):
    """Finds the unstable bands of a map between the ends of two axes, see `floquetrod.plane.Family`."""

    def __call__(self, x: Axis, y: Axis, accuracy: float, progress: Progress | None) -> FoundBands | None:
        """Return them, None where verdicts must be traced."""


class Answers(NamedTuple):
    """Of flat loads: status 1, 0 or -1; growth in 1/s, NaN where unknown; fastest mode, 0 for none, -1 for several."""

    status: Statuses
    growth: Floats
    mode: Ints


@dataclass(frozen=True)
class ModeModel(ABC):
    """The modes of a rod under any load of one kind.

    A model need not override other methods than abstract ones: it then refuses, or does without.

    Attributes
    ----------
    rod : RodData
    template : Load
        The kind of load: everything but mean, amplitude and frequency.
    """

    rod: RodData
    template: Load

    prompt: ClassVar[bool] = False
    """Whether a verdict takes milliseconds, so that one may be had for a hint, or while a slider moves."""
    has_exact_margins: ClassVar[bool] = False
    """Whether margins follow from the tongues even where the evidence is coupled modes."""
    loads_at_once: ClassVar[int | None] = None
    """Loads of a map between two reports of progress; None for as many as charts choose."""
    samples_at_once: ClassVar[int] = 1 << 8
    damping_subject: ClassVar[str] = "at the load of its fastest growth"
    """What the damping required by an unstable band stabilises."""
    damping_source: ClassVar[str] = "that of the load whose growth is worst"
    """How that damping is computed, in words."""

    def under(self, template: Load) -> Self:
        """Return the model under another kind of load that couples the modes no more than this one."""
        return replace(self, template=template)

    @property
    def coupling(self) -> tuple[str, ...]:
        """What couples the modes, in words; empty where nothing does."""
        return coupling(self.rod, self.template)

    def refusal(self, name: str) -> ValueError:
        """Return the error, with the remedy, for an argument or method that asks for what this model cannot do."""
        return refusal(name, self.coupling)

    def require(self, name: str) -> None:
        """Raise ValueError unless each mode obeys an equation of Mathieu's, as an argument or method needs it."""
        if name == "friction":
            require_known(self.rod, ROD, "kicks")
        raise self.refusal(name)

    def on_sides(self, loads: Loads) -> Iterator[tuple[Ints, ModeConstants, Loads]]:
        """Yield the loads under which a rod stays on the low or the high side of its channel, where that is uniform.

        With their places among all, and the constants of the rod there.  LeavesWallError as `require_one_on_wall`.
        """
        constants = mode_constants(self.rod)
        self.require_one_on_wall(loads)
        sides = np.ones(loads.size) if self.rod.course.is_straight else constants.sides(*loads.flat[:2])
        for side in (1, -1):
            at = np.flatnonzero(sides == side)
            if at.size:
                yield at, constants.on_side(side), loads.some(at)

    def require_one_on_wall(self, loads: Loads) -> None:
        """Raise LeavesWallError for a single load, of the shape (), under which a rod leaves its wall."""
        if loads.shape == () and not self.rod.course.is_straight:
            require_on_wall(self.rod, self.template.with_numbers(*(float(values[0]) for values in loads.flat)))

    def require_on_wall(self, search: Search) -> None:
        """Raise LeavesWallError unless a rod lies on the low side of its channel all along a search."""
        varied, load, bounds, _ = search
        for value in bounds:
            require_on_wall(self.rod, load.varied(varied, value), only_low=True)

    # --- equations ---

    @abstractmethod
    def equations(self, load: Load, modes: Iterable[int] | None = None) -> ModalSystem | HillSystem:
        """Return the equations of some modes, by default all that can matter, under one load."""

    @abstractmethod
    def modes_needed(self, load: Load, growth_tolerance: float) -> tuple[int, float]:
        """Return how many modes decide a verdict, and a bound or estimate in 1/s of the growth of all others."""

    @abstractmethod
    def in_modes(self, count: int) -> CoupledEquations:
        """Return the first modes as systems of equations under any load of the kind."""

    def count_for(self, loads: Loads, growth_tolerance: float) -> int:
        """Return how many modes serve all of some loads, taken to be as strong and as fast as the strongest of them.

        ValueError where that would be too many.
        """
        largest = self.template.with_numbers(*(float(values.max()) for values in loads.flat))
        return self.modes_needed(largest, growth_tolerance)[0]

    def modes_apart(self, modes: Iterable[int]) -> tuple[int, ...]:
        """Return the modes whose growth follows from their own motion alone, among some modes."""
        return tuple(modes) if self.in_modes(1).are_apart else ()

    def showing(self, load: Load, mode: int | None, rate: float) -> CoupledEquations:
        """Return the modes up to one with an equation of its own, else as many as may grow at a rate in 1/s."""
        if mode is not None and self.modes_apart([mode]):
            return self.in_modes(mode)
        return self.in_modes(self.count_for(Loads.single(load), rate))

    def systems(self, loads: Loads) -> ModalSystems:
        """Return the equations of all modes under many loads, where each is Mathieu's."""
        raise ValueError(
            "mean, amplitude and frequency must be numbers, no arrays, for the modal_system of coupled modes, got "
            f"{', '.join(self.coupling)}; give one load at a time"
        )

    def among_tongues(self, load: Load, modes: Iterable[int]) -> ModalSystem | None:
        """Return the equations of some modes where each is Mathieu's, so that it lies among its tongues; else None."""
        return None

    # --- verdicts ---

    @abstractmethod
    def verdict(
        self,
        load: Load,
        modes: Iterable[int] | None = None,
        growth_tolerance: float = 0.0,
        progress: Progress | None = None,
    ) -> RodStability:
        """Return the verdict under one load, with some modes, by default all that can matter."""

    @abstractmethod
    def answers(
        self, loads: Loads, growth_tolerance: float = 0.0, workers: int | None = None, progress: Progress | None = None
    ) -> Answers:
        """Return status, growth and number of the fastest mode of the rod under each load."""

    def status(
        self, loads: Loads, growth_tolerance: float = 0.0, workers: int | None = None, progress: Progress | None = None
    ) -> Statuses:
        """Return 1 where the rod is stable, 0 where it is not, and -1 where that could not be decided."""
        return self.answers(loads, growth_tolerance, workers, progress).status

    def fastest(
        self, loads: Loads, workers: int | None = None, progress: Progress | None = None
    ) -> tuple[Floats, Ints]:
        """Return the growth in 1/s and the number of the fastest mode: 0, 0 where stable, -1 where it has no number."""
        answers = self.answers(loads, 0.0, workers, progress)
        return answers.growth, answers.mode

    def growth_estimate(self, loads: Loads, growth_tolerance: float = 0.0) -> Floats:
        """Return the growth in 1/s in short time, estimated where it need be; NaN where unknown."""
        return self.fastest(loads)[0]

    def growth_of_modes(self, load: Load, modes: Iterable[int]) -> tuple[float, ...]:
        """Return the growth in 1/s of modes, which coupled ones share."""
        return (self.verdict(load).growth_rate,) * len(tuple(modes))

    # --- margins ---

    @abstractmethod
    def damping_to_stabilise(self, verdict: RodStability) -> float:
        """Return the smallest damping rate in 1/s at which, and at every larger one, no mode grows."""

    @abstractmethod
    def margin_edge(
        self,
        verdict: RodStability,
        quantity: Quantity,
        piece: tuple[float, float],
        seconds: float,
        progress: Progress | None,
    ) -> FirstChange:
        """Return where the verdict first changes from ``piece[0]`` to ``piece[1]``, in about so many seconds."""

    def band_beyond(self, verdict: RodStability, quantity: Quantity, change: float) -> BandBeyond | None:
        """Return the unstable band in which a margin ends, ``change`` away from a stable load; None if not known."""
        return None

    # --- along a quantity, and over two ---

    @abstractmethod
    def ranges(self, search: Search, progress: Progress | None) -> StabilityIntervals:
        """Return the stability intervals of one quantity of the load."""

    def first_unstable(self, search: Search, progress: Progress | None = None) -> FirstChange:
        """Return where a quantity that goes up from zero first meets growth, searched outward in pieces.

        ``progress`` is called with a share of the largest value and with all of it.
        """
        self.require_on_wall(search)
        varied, _, (_, largest), _ = search
        way = ends_between(varied, (0.0, largest), self.rod.critical_force)
        reports = [_as_shares(progress, piece, largest) for piece in pairwise(way)]

        def first_growth(piece: tuple[float, float], seconds: float, progress: Progress | None) -> FirstChange:
            return self.first_growth(search._replace(bounds=piece), progress)

        return outward(way, first_growth, reports)

    @abstractmethod
    def first_growth(self, search: Search, progress: Progress | None) -> FirstChange:
        """Return where something first grows within bounds, from the low one up, where nothing does."""

    def critical_noise(self, load: Load, growth_tolerance: float, progress: Progress | None) -> CriticalValue:
        """Return the factor of the noise up to which the rod is stable in mean square."""
        raise self.refusal("critical_noise")

    @abstractmethod
    def unstable_bands(
        self, search: Search, modes: int, bands: Sequence[tuple[float, float]], progress: Progress | None
    ) -> tuple[UnstableBand, ...]:
        """Return the growth in bands without stable loads, given by their ends in increasing order."""

    def bands(self, across: Quantity, up: Quantity, fixed: float, growth_tolerance: float) -> BandFinder | None:
        """Return a finder of the unstable bands of a map between exact curves; None where verdicts must be traced."""
        return None

    # --- a test of finite time, samples and proofs ---

    def passing(
        self, loads: Loads, criterion: FiniteTimeCriterion, workers: int | None, progress: Progress | None
    ) -> Statuses:
        """Return 1 where every mode passes the test, else 0."""
        raise self.refusal("criterion")

    def require_varied(self, names: Iterable[str]) -> None:
        """Raise ValueError unless numbers of rod and load with these names may be different in every sample."""
        for name in names:
            if name not in QUANTITIES:
                raise self.refusal(f"{name} in parameters")

    def sample_status(
        self,
        rods: Mapping[str, Any],
        loads: Loads,
        tolerance: float,
        workers: int | None,
        require: Callable[[Bools], None],
    ) -> Statuses:
        """Return the status of rods under loads, one by one; ``require`` raises unless all samples are in reach."""
        return self.status(loads, tolerance, workers)

    def certify(
        self,
        sides: tuple[Any, Any, Any],
        growth_tolerance: float,
        rod: Mapping[str, Any] | None,
        max_boxes: int,
        progress: Progress | None,
    ) -> RegionProof:
        """Prove every load of a box stable or unstable; see `floquetrod.Rod.certify`."""
        raise self.refusal("certify")


_SHARES = 10_000  # of the largest value, in which searches from zero report how far they are


def _as_shares(progress: Progress | None, piece: tuple[float, float], largest: float) -> Progress | None:
    """Return a progress within a piece of a search, in shares of the largest value, rounded down."""
    if progress is None:
        return None
    low, high = piece

    def told(done: int, total: int) -> None:
        reached = high if done == total else low + (high - low) * done / total
        progress(math.floor(_SHARES * reached / largest), _SHARES)

    return told
