"""A waveform of one harmonic: modes of hinged ends under a sine with a phase of its own, such as a recorded force."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar, cast

from floquetrod._util.progress import Progress
from floquetrod.floquet.first_change import FirstChange
from floquetrod.rod.answers.rod_stability import RodStability
from floquetrod.rod.loads.load import Load, Quantity
from floquetrod.rod.modes.coupled import CoupledModel
from floquetrod.rod.modes.independent import IndependentModel

if TYPE_CHECKING:
    from floquetrod.rod.answers.evidence import CoupledEvidence
    from floquetrod.rod.answers.stability_intervals import BandBeyond, Search, StabilityIntervals

_UNIT_SIZE = 1e-12  # relative error of a force, far below the error of any record (a choice)


def has_one_harmonic(load: Load) -> bool:
    """Return whether a load is a sine of its amplitude, of whatever phase."""
    return len(load.harmonics) == 1 and abs(abs(load.harmonics[0]) - 1.0) <= _UNIT_SIZE


@dataclass(frozen=True)
class OneHarmonicModel(CoupledModel):
    """Modes of hinged ends under one harmonic of any phase, uniform along the rod.

    Verdicts take the motion of the modes together, as the phase wants.  A phase is a beginning of time, which changes
    no stability: margins, ranges and limits are those of the sine, by the tongues of Mathieu's equation.
    """

    has_exact_margins: ClassVar[bool] = True

    def under(self, template: Load) -> CoupledModel:  # type: ignore[override]
        """Return the model under another load, of coupled modes where it is no sine of its amplitude."""
        return replace(self, template=template) if has_one_harmonic(template) else CoupledModel(self.rod, template)

    @property
    def sine(self) -> IndependentModel:
        """The modes under the sine."""
        return IndependentModel(self.rod, _sine(self.template))

    def sine_verdict(self, verdict: RodStability) -> RodStability:
        """Return the verdict under the sine, with the modes that the caller chose."""
        is_chosen = len(cast("CoupledEvidence", verdict.evidence).convergence) == 1
        modes = verdict.modes if is_chosen else None
        return self.sine.verdict(self.sine.template, modes, verdict.growth_tolerance)

    # --- margins ---

    def damping_to_stabilise(self, verdict: RodStability) -> float:
        """Return the smallest damping rate in 1/s at which, and at every larger one, no mode grows."""
        return self.sine.damping_to_stabilise(self.sine_verdict(verdict))

    def margin_edge(
        self,
        verdict: RodStability,
        quantity: Quantity,
        piece: tuple[float, float],
        seconds: float,
        progress: Progress | None,
    ) -> FirstChange:
        """Return where the verdict first changes from ``piece[0]`` to ``piece[1]``, by the tongues."""
        return self.sine.margin_edge(self.sine_verdict(verdict), quantity, piece, seconds, progress)

    def band_beyond(self, verdict: RodStability, quantity: Quantity, change: float) -> BandBeyond | None:
        """Return the unstable band in which a margin of a stable load ends."""
        return self.sine.band_beyond(self.sine_verdict(verdict), quantity, change)

    # --- along a quantity ---

    def ranges(self, search: Search, progress: Progress | None) -> StabilityIntervals:
        """Return the stability intervals of one quantity of the load, by the tongues."""
        return self.sine.ranges(_sine_search(search), progress)

    def first_unstable(self, search: Search, progress: Progress | None = None) -> FirstChange:
        """Return where a quantity that goes up from zero first meets growth, by the tongues."""
        return self.sine.first_unstable(_sine_search(search), progress)


def _sine(load: Load) -> Load:
    return replace(load, waveform="sine").given_in(load.given_units)


def _sine_search(search: Search) -> Search:
    return search._replace(load=_sine(search.load))
