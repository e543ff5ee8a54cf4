"""Coupled modes: beam functions under a force that varies along the rod, or between other ends than hinged ones."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar, cast

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.arguments import Mention
from floquetrod._util.arrays import Floats
from floquetrod._util.progress import Progress, shifted
from floquetrod.equations import HillSystem
from floquetrod.floquet.first_change import FirstChange
from floquetrod.floquet.multipliers.many_verdicts import ManyVerdicts
from floquetrod.floquet.multipliers.stabilising_damping import least_damping
from floquetrod.rod.answers.evidence import CoupledEvidence
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.answers.stability_intervals import BEYOND, BandBeyond, Search, StabilityIntervals, UnstableBand
from floquetrod.rod.loads.axial import AxialResonanceError
from floquetrod.rod.loads.load import Load, Loads, Quantity
from floquetrod.rod.mode_equations.coupled_matrices import MOST_COUPLED, CoupledModes, modes_needed, up_to_resonance
from floquetrod.rod.mode_equations.coupled_samples import first_growth_change, growth_beyond
from floquetrod.rod.mode_equations.coupled_systems import CoupledEquations
from floquetrod.rod.model.constants import SLOW_GROWTH
from floquetrod.rod.model.contact import require_on_wall, up_to_wall
from floquetrod.rod.modes.coupled_verdict import classify_coupled
from floquetrod.rod.modes.mode_model import Answers, ModeModel
from floquetrod.rod.modes.sampled_ranges import sampled_first_growth, sampled_ranges, zero_unless_stable
from floquetrod.rod.modes.unstable_bands import sampled_bands

_GROUPS = 16  # of loads by frequency, each with its own number of modes (a choice)


@dataclass(frozen=True)
class CoupledModel(ModeModel):
    """Modes that move together; a model with other equations overrides `in_modes` and `count_for`."""

    loads_at_once: ClassVar[int | None] = 2000  # some seconds

    # --- equations ---

    def equations(self, load: Load, modes: Iterable[int] | None = None) -> HillSystem:
        """Return the system of the first modes, by default of all that can matter, under one load."""
        count = self.count_for(Loads.single(load), 0.0) if modes is None else chosen_count(modes)
        return self.in_modes(count).system(Loads.single(load))

    def modes_needed(self, load: Load, growth_tolerance: float) -> tuple[int, float]:
        """Return how many modes to take, and the growth in 1/s that all others are expected not to exceed."""
        return self.count_for(Loads.single(load), growth_tolerance), max(growth_tolerance, SLOW_GROWTH)

    def in_modes(self, count: int) -> CoupledEquations:
        """Return the first modes as systems of equations under any load of the kind."""
        return CoupledModes.of(self.rod, self.template, count)

    def count_for(self, loads: Loads, growth_tolerance: float) -> int:
        """Return how many modes serve all of some loads; ValueError where that would be too many."""
        return modes_needed(self.rod, self.template, loads, growth_tolerance)

    # --- verdicts ---

    def verdict(
        self,
        load: Load,
        modes: Iterable[int] | None = None,
        growth_tolerance: float = 0.0,
        progress: Progress | None = None,
    ) -> RodStability:
        """Return the verdict under one load, with as many modes as two numbers of them agree upon."""
        require_on_wall(self.rod, load)
        count = None if modes is None else chosen_count(modes)
        return classify_coupled(self, load, count, growth_tolerance, progress)

    def answers(
        self, loads: Loads, growth_tolerance: float = 0.0, workers: int | None = None, progress: Progress | None = None
    ) -> Answers:
        """Return status, growth in 1/s, NaN where unknown, and -1 where something grows: `verdict` names the modes."""
        status, growth = self.judged(loads, growth_tolerance, workers, progress=progress)
        return Answers(status, growth, np.where(growth > 0.0, -1, 0))

    def growth_estimate(self, loads: Loads, growth_tolerance: float = 0.0) -> Floats:
        """Return the growth in 1/s, NaN where unknown, estimated next to a boundary."""
        return self.judged(loads, growth_tolerance, quick=True).growth

    def judged(
        self,
        loads: Loads,
        growth_tolerance: float = 0.0,
        workers: int | None = None,
        *,
        quick: bool = False,
        progress: Progress | None = None,
    ) -> ManyVerdicts:
        """Return statuses and growth rates in 1/s as `CoupledEquations.answers`.

        -1 and NaN at axial resonances, and where the rod leaves its wall; a single load is refused there.
        """
        status, growth = np.full(loads.size, -1, dtype=np.int8), np.full(loads.size, np.nan)
        self.require_one_on_wall(loads)
        done = 0
        for chosen, modes, block in self._groups(loads, growth_tolerance):
            block_progress = shifted(progress, done, loads.size - block.size)
            status[chosen], growth[chosen] = modes.answers(
                block, growth_tolerance, workers, quick=quick, progress=block_progress
            )
            done += block.size
        return ManyVerdicts(status, growth)

    def _groups(
        self, loads: Loads, growth_tolerance: float
    ) -> Iterator[tuple[NDArray[np.intp], CoupledEquations, Loads]]:
        """Yield loads of neighbouring frequencies, by their indices, with their modes."""
        order = np.argsort(loads.frequency, kind="stable")
        edges = np.searchsorted(loads.frequency[order], np.unique(loads.frequency))
        edges = edges[:: max(1, -(-len(edges) // _GROUPS))]
        for chosen in np.split(order, edges[1:]):
            if chosen.size:
                yield from self._with_modes(loads, growth_tolerance, chosen)

    def _with_modes(
        self, every: Loads, growth_tolerance: float, chosen: NDArray[np.intp]
    ) -> Iterator[tuple[NDArray[np.intp], CoupledEquations, Loads]]:
        """Yield loads, in the order of their frequencies, with their modes; without those at axial resonances.

        A single load, of the shape (), is refused there.
        """
        loads = Loads((chosen.size,), *(values[chosen] for values in every.flat))
        try:
            count = self.count_for(loads, growth_tolerance)
        except AxialResonanceError:
            if every.shape == ():
                raise
            edges = np.searchsorted(loads.frequency, np.unique(loads.frequency))
            if len(edges) > 1:
                for part in np.split(chosen, [edges[len(edges) // 2]]):
                    yield from self._with_modes(every, growth_tolerance, part)
        else:
            yield chosen, self.in_modes(count), loads

    # --- margins ---

    def damping_to_stabilise(self, verdict: RodStability) -> float:
        """Return the damping rate in 1/s at which this load no longer makes the rod grow faster than the tolerance.

        Searched to ten digits, and tried at two, four and eight times as much.
        """
        evidence = _evidence(verdict)
        if float(np.linalg.eigvalsh(evidence.system.stiffness)[0]) <= 0.0:
            return math.inf
        loads = Loads.single(self.template)

        def excess(rate: float) -> float:
            """Return the growth beyond the tolerance at a damping rate; below zero where everything decays."""
            growth = float(evidence.coupled.damped(rate).growth_without_decay(loads)[0])
            return -1.0 if math.isnan(growth) else growth - rate - verdict.growth_tolerance

        return least_damping(excess, verdict.growth_rate, self.template.frequency)

    def margin_edge(
        self,
        verdict: RodStability,
        quantity: Quantity,
        piece: tuple[float, float],
        seconds: float,
        progress: Progress | None,
    ) -> FirstChange:
        """Return where the verdict first changes from ``piece[0]`` to ``piece[1]``, with as many modes as it needs."""
        load, tolerance = self.template, verdict.margin_tolerance
        piece = up_to_wall(self.rod, load, quantity, piece)
        if quantity == "frequency":
            piece = up_to_resonance(self.rod, load, piece)
        if piece[0] == piece[1]:
            return FirstChange(None, piece[0], 0.0)
        begins_stable = None if piece[0] == getattr(load, quantity) else verdict.stable
        try:
            modes = self.modes_of_piece(verdict, quantity, piece)
        except ValueError:  # too many modes, or loads too large or too slow: nothing is known of them
            return FirstChange(None, piece[0], 0.0)
        return first_growth_change(
            quantity,
            modes,
            load,
            piece,
            tolerance,
            begins_stable=begins_stable,
            most_seconds=seconds,
            progress=progress,
        )

    def band_beyond(self, verdict: RodStability, quantity: Quantity, change: float) -> BandBeyond | None:
        """Return the unstable band in which a margin of a stable load ends, sampled; None where that takes long."""
        if not verdict.stable:
            return None
        edge = getattr(self.template, quantity) + change
        piece = up_to_wall(self.rod, self.template, quantity, (edge, edge + math.copysign(BEYOND * abs(edge), change)))
        if quantity == "frequency":
            piece = up_to_resonance(self.rod, self.template, piece)
        try:
            modes = self.modes_of_piece(verdict, quantity, piece)
        except ValueError:  # too many modes, or loads too large or too slow: nothing is known of them
            return None
        band = growth_beyond(quantity, modes, self.template, verdict.margin_tolerance, piece)
        return None if band is None else BandBeyond(*band)

    def modes_of_piece(self, verdict: RodStability, quantity: Quantity, piece: tuple[float, float]) -> CoupledEquations:
        """Return as many modes as all loads of a piece need, no fewer than the verdict; those the caller chose."""
        evidence = _evidence(verdict)
        if len(evidence.convergence) == 1:
            return evidence.coupled
        loads = Loads.along(self.template, quantity, np.linspace(*piece, 33))
        return self.in_modes(max(self.count_for(loads, verdict.margin_tolerance), evidence.coupled.count))

    # --- samples ---

    def require_varied(self, names: Iterable[str]) -> None:
        """Do nothing: rods that differ are judged one by one, each with modes of its own."""

    # --- along a quantity ---

    def ranges(self, search: Search, progress: Progress | None) -> StabilityIntervals:
        """Return the stability intervals of one quantity of the load, sampled; ``resolution`` is their distance."""
        self.require_on_wall(search)
        return sampled_ranges(self, search, progress)

    def first_unstable(self, search: Search, progress: Progress | None = None) -> FirstChange:
        """Return where a quantity that goes up from zero first meets growth, searched outward in pieces.

        At zero, with a warning, where the rod is not stable there.
        """
        self.require_on_wall(search)
        return zero_unless_stable(self, search) or super().first_unstable(search, progress)

    def first_growth(self, search: Search, progress: Progress | None) -> FirstChange:
        """Return where something first grows within bounds, from the low one up, by samples."""
        return sampled_first_growth(self, search, progress)

    def unstable_bands(
        self, search: Search, modes: int, bands: Sequence[tuple[float, float]], progress: Progress | None
    ) -> tuple[UnstableBand, ...]:
        """Return the growth in each band, sampled, and the damping that the load of fastest growth requires."""
        return sampled_bands(self, search, bands, progress)


def _evidence(verdict: RodStability) -> CoupledEvidence:
    return cast(CoupledEvidence, verdict.evidence)


def chosen_count(modes: Iterable[int]) -> int:
    """Return how many modes a caller chose: coupled modes are taken from the first on, without gaps."""
    chosen = validate.modes(modes)
    if chosen != tuple(range(1, len(chosen) + 1)):
        raise validate.wrong_value(
            "modes",
            f"of a rod whose modes are coupled must be 1 to some number, got {validate.short(list(chosen))}; give ",
            Mention("modes", "range(1, n + 1)", "1-n"),
        )
    return validate.integer("modes", len(chosen), 1, MOST_COUPLED)
