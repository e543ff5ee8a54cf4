"""The verdict on a rod, whatever couples its modes: status, growth, margins, and its words, tables and numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import islice
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.interchange import by_keys, plain
from floquetrod._util.progress import Progress
from floquetrod._util.result_report import Report, Reported, Table, number
from floquetrod._util.suggest import listed
from floquetrod.equations import HillSystem, Mathieu
from floquetrod.floquet.first_change import FirstChange, outward
from floquetrod.floquet.margins import Margin
from floquetrod.floquet.multipliers.resonance_names import Resonance
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.references import ROD, references, united
from floquetrod.floquet.verdict import Stability, Verdict
from floquetrod.rod.answers.evidence import (
    CoupledEvidence,
    Evidence,
    IndependentEvidence,
    NoisyCoupledEvidence,
    NoisyEvidence,
    Shape,
    TwoFrequencyCoupledEvidence,
    TwoFrequencyEvidence,
)
from floquetrod.rod.answers.reports import (
    ReportLine,
    answer_units,
    margin_lines,
    margins_as_dict,
    missed_changes,
    shown_in,
    subject_lines,
)
from floquetrod.rod.answers.search_pieces import FEW_MODES, MARGIN_SECONDS, WAYS, in_hundredths
from floquetrod.rod.loads.axial import AxialResponse
from floquetrod.rod.loads.load import Load, Quantity
from floquetrod.rod.mode_equations.coupling import WAVEFORM
from floquetrod.rod.mode_equations.modal_systems import ModalSystem
from floquetrod.rod.model.constants import SLOW_GROWTH
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.rod_in_words import parts_as_dicts, section_in_words, table_of_parts

if TYPE_CHECKING:
    from floquetrod.rod.answers.stability_intervals import BandBeyond
    from floquetrod.rod.mode_equations.coupled_systems import CoupledEquations

_OF_ONE_KIND = ("mode_verdicts", "mode_growth_rates", "mode_equations", "whole", "convergence", "shape", "system")
"""Names that are defined for one kind of modes only."""

_QUICK_SHAPE = 150  # functions of coupled modes up to which a report finds the shape, in about two seconds
_QUICK_VERDICT = 0.05  # s, of two frequencies: some hundred verdicts for all margins
_LISTED_RESONANCES = 10  # in a report, the fastest
_UNEVEN = 0.01  # of a growth rate, an error beyond which the two ends are given (a choice)
_LISTED_MODES = 5  # in a report besides the modes that grow: those next to growth


class VerdictModel(Protocol):
    """The modes of a rod under one load, asked by a verdict for its margins: a `ModeModel`."""

    @property
    def rod(self) -> RodData:
        """The rod."""

    @property
    def template(self) -> Load:
        """The load."""

    @property
    def coupling(self) -> tuple[str, ...]:
        """What keeps the modes from obeying an equation of Mathieu's each, in words."""

    @property
    def has_exact_margins(self) -> bool:
        """Whether margins follow from the tongues even where the evidence is coupled modes."""

    def damping_to_stabilise(self, verdict: RodStability) -> float:
        """Return the smallest damping rate in 1/s at which, and at every larger one, no mode grows."""

    def modes_needed(self, load: Load, growth_tolerance: float) -> tuple[int, float]:
        """Return how many modes decide a verdict, and a bound in 1/s on the growth of every mode beyond them."""

    def verdict(self, load: Load, modes: Iterable[int] | None = None) -> RodStability:
        """Return the verdict on some modes."""

    def growth_of_modes(self, load: Load, modes: tuple[int, ...]) -> tuple[float, ...]:
        """Return the growth in 1/s of modes."""

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


@dataclass(frozen=True, kw_only=True, repr=False)
class RodStability(Reported, Verdict):
    """Verdict on a rod under a load, in 1/s and s.

    It has all that every `Verdict` has.  Stable when nothing grows faster than the tolerance; the growth rate is that
    of the fastest solution, within the tolerance or not; the exponents belong to the modes examined, or, of more than
    60 coupled ones, to those that may resonate.  Where modes are independent ``error`` is the largest error of a
    discriminant; where they are coupled the error of the growth rate in 1/s, from the multipliers and, estimated, from
    the modes left out.  Of independent modes under noise it is the error of the growth rate in 1/s, with a bound on all
    other modes; under two frequencies the largest error of a mode's growth rate in 1/s, or that of coupled modes, and
    "stable" means no more than that nothing grows faster than the tolerance.

    Attributes
    ----------
    model : ModeModel
        The modes of the rod under the load.
    growth_tolerance : float
        Growth in 1/s up to which a mode counts as stable.
    evidence : Evidence
        Basis of the verdict, of independent or coupled modes, with noise and two frequencies as their own kinds: the
        equations of the modes, and the verdict on each or on all together.
    left_out : str
        What margins leave out of a measured force, in words: its sines that the load does not hold, or what else leaves
        the verdict undecided; "" for nothing.
    undecided_by : str
        Why a verdict on a measured force or under noise is undecided, in words; "" where it is decided, or for other
        reasons.

    Modes are numbered as the modes of the rod without axial force, between the same ends.  Attributes of one kind of
    modes only, such as `mode_verdicts` or `shape`, raise an AttributeError that says so for the other.
    """

    model: VerdictModel
    growth_tolerance: float
    evidence: Evidence
    left_out: str = ""
    undecided_by: str = ""

    @property
    def rod(self) -> RodData:
        """The rod."""
        return self.model.rod

    @property
    def load(self) -> Load:
        """The load."""
        return self.model.template

    @property
    def linear(self) -> RodStability:
        """The verdict without friction, as a `FrictionalRodStability` has it, which is this one."""
        return self

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite, in plain text with DOI, floquetrod first, then the sources of the methods used."""
        return united(references(ROD), self.evidence.references)

    @property
    def modes(self) -> tuple[int, ...]:
        """Modes examined."""
        return self.evidence.modes

    @property
    def modes_checked(self) -> int:
        """Number of modes examined; `cutoff` says why that many."""
        return len(self.modes)

    @property
    def cutoff(self) -> str:
        """Why these modes and no others."""
        words = self.evidence.cutoff
        return words.replace(" coupled modes", " modes") if self.model.coupling == (WAVEFORM,) else words

    @property
    def resonances(self) -> tuple[Resonance, ...]:
        """The resonances that grow, the fastest first, such as "direct resonance of mode 7, order 1".

        A combination resonance has two modes.  Coupled modes are named by a heuristic, see `SystemStability`.
        """
        return self.evidence.resonances

    @property
    def unstable_modes(self) -> tuple[int, ...]:
        """Modes that grow, alone or in a combination, faster than the tolerance."""
        return self.evidence.unstable_modes(self.status, self.growth_tolerance)

    @property
    def fastest_mode(self) -> int | None:
        """Mode that grows fastest, the lower one of a combination; None when none grows or none could be named."""
        return self.evidence.fastest_mode(self.growth_rate)

    @cached_property
    def damping_to_stabilise(self) -> float:
        """Smallest damping rate in 1/s at which, and at every larger one, no mode grows.

        The rate meant is the rod's whole ``damping_rate``, whatever it is now.  Infinite when the mean force alone
        buckles the rod: damping only slows that down.  Where modes are coupled it is the rate at which this load no
        longer makes the rod grow faster than the tolerance, searched to ten digits and tried at two, four and eight
        times as much.
        """
        return self.model.damping_to_stabilise(self)

    @cached_property
    def decay_rate(self) -> float:
        """Rate in 1/s at which the slowest motion decays, of second moments under noise; 0 where none is known to.

        Independent modes beyond those examined cannot grow but may decay more slowly: they are examined when this
        attribute is read, under noise the first 128.  Where modes are coupled, or the caller chose them, it is the rate
        of the modes examined.
        """
        known = super().decay_rate
        if self.evidence.shares_growth or not known or math.isinf(self.left_out_bound):
            return known
        beyond = range(len(self.modes) + 1, self.model.modes_needed(self.load, -known)[0] + 1)
        return min(known, -self.model.verdict(self.load, beyond)._slowest) if beyond else known

    # --- defined for one kind of modes only ---

    @property
    def system(self) -> ModalSystem | HillSystem:
        """The equations, of independent modes a `ModalSystem`, of coupled ones a `HillSystem` in seconds."""
        system: ModalSystem | HillSystem = self._of_one_kind("system")
        return system

    @property
    def mode_equations(self) -> tuple[Mathieu, ...]:
        """Equation of each independent mode, in the time tau = omega t."""
        return tuple(self._of_one_kind("mode_equations"))

    @property
    def mode_verdicts(self) -> tuple[Stability, ...]:
        """Verdict on each independent mode."""
        return tuple(self._of_one_kind("mode_verdicts"))

    @property
    def mode_growth_rates(self) -> Floats:
        """Growth rate of each independent mode in 1/s."""
        return np.asarray(self._of_one_kind("mode_growth_rates"))

    @property
    def left_out_bound(self) -> float:
        """Bound in 1/s on the growth of every mode but these, infinite where the modes were chosen by the caller."""
        return float(self._of_one_kind("left_out_bound"))

    @property
    def coupled(self) -> CoupledEquations:
        """The coordinates in which the motion of coupled modes is written, and their kind of load."""
        coupled: CoupledEquations = self._of_one_kind("coupled")
        return coupled

    @property
    def whole(self) -> SystemStability:
        """Verdict on the system of coupled modes."""
        whole: SystemStability = self._of_one_kind("whole")
        return whole

    @property
    def convergence(self) -> tuple[tuple[int, float], ...]:
        """Numbers of coupled modes and the growth rate in 1/s with each; the last one is the answer."""
        return tuple(self._of_one_kind("convergence"))

    @property
    def shape(self) -> Shape:
        """Where along the rod the fastest solution of coupled modes moves most, growing or not."""
        shape: Shape = self._of_one_kind("shape")
        return shape

    def _of_one_kind(self, name: str) -> Any:
        """Return an attribute of the evidence; AttributeError where its kind of modes has none."""
        defined = dir(self.evidence)
        if name in defined:
            return getattr(self.evidence, name)
        others = ", ".join(other for other in _OF_ONE_KIND if other in defined)
        raise AttributeError(
            f"{name} is not defined for {self.evidence.kind}, the subject of this verdict; use {others}"
        )

    @property
    def axial(self) -> AxialResponse:
        """How large the vibration becomes along the rod, where, and the nearest axial resonances."""
        return self.rod.axial_response(self.load)

    def growth_of(self, mode: int) -> float:
        """Return the growth rate of a mode in 1/s, of the rod where modes are coupled.

        Returns
        -------
        float
            In 1/s; 0 where the mode does not grow.

        Raises
        ------
        TypeError, ValueError
            For anything but a whole number from 1.
        """
        mode = validate.integer("mode", mode, 1, validate.MOST_NUMBERS)
        return self.growth_rate if self.evidence.shares_growth else self.model.growth_of_modes(self.load, (mode,))[0]

    def is_fastest(self, mode: int | None) -> bool:
        """Return whether a mode has the growth rate of the rod, as all coupled modes have.

        Returns
        -------
        bool
            False for None.
        """
        return self.evidence.shares_growth or mode == self.fastest_mode

    def plot(self, ax: Any = None) -> Any:
        """Draw the `shape` in which the rod grows.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.

        Raises
        ------
        ValueError
            Where modes are independent and none grows.
        """
        shape, name = _drawn_shape(self)
        from floquetrod.plotting.rod_plot import draw_shape

        return draw_shape(self, shape, name, ax)

    def time_to_grow(self, factor: float = 10.0) -> float:
        """Return the time in s in which the fastest mode grows by ``factor``, infinite when none grows.

        Returns
        -------
        float
            In s.

        Raises
        ------
        TypeError, ValueError
            For a factor that is not greater than 1.
        """
        if not validate.finite("factor", factor) > 1.0:
            raise validate.wrong_value("factor", f"must be greater than 1, got {factor!r}")
        return math.log(factor) / self.growth_rate if self.growth_rate > 0.0 else math.inf

    @cached_property
    def mean_force_margin(self) -> Margin:
        """Distance in N to the nearest mean forces at which the verdict changes, searched to 8 F_cr either way.

        Tongues that nowhere grow faster than `margin_tolerance` do not count, in this margin and the other two.  Where
        modes are coupled the search is sampled, and ends early where it would take more than about ten seconds: see
        `Margin.resolution` and `Margin.searched`; `margin` continues the search.
        """
        return self.margin("mean", seconds=MARGIN_SECONDS)

    @cached_property
    def amplitude_margin(self) -> Margin:
        """Distance in N to the nearest amplitudes at which the verdict changes, searched to 2 F_cr above.

        `Margin.resolution` says which changes may be passed over, as in `Rod.stable_amplitudes`.
        """
        return self.margin("amplitude", seconds=MARGIN_SECONDS)

    @cached_property
    def frequency_margin(self) -> Margin:
        """Distance in rad/s to the nearest frequencies at which the verdict changes, searched to 9 times either way."""
        return self.margin("frequency", seconds=MARGIN_SECONDS)

    def margin(self, quantity: Quantity, *, seconds: float = math.inf, progress: Progress | None = None) -> Margin:
        """Return the margin of one quantity of the load, searched for as long as wanted.

        Parameters
        ----------
        quantity : "mean", "amplitude" or "frequency"
        seconds : float
            About how long the search for coupled modes may take: it takes fewer samples, and ends early, where it would
            take longer by an estimate that does not depend on the machine.
        progress : callable, optional
            Called with the numbers of hundredths of the parts of the search done and of all; a margin may be found
            before the last.  An exception that it raises ends the search.

        Returns
        -------
        Margin
            In N or rad/s.

        Raises
        ------
        ValueError
            For another quantity, and for ``seconds`` of zero or less.
        """
        validate.choice("quantity", quantity, WAYS)
        if not (isinstance(seconds, float) and seconds == math.inf):
            seconds = units.number("seconds", seconds, "time", math.ulp(0.0), hint="leave it out to search everything")
        validate.progress(progress)
        here: float = getattr(self.load, quantity)
        ways = [[here, *way] for way in WAYS[quantity](here, self.rod.critical_force)]
        pieces = sum(len(way) - 1 for way in ways)
        reports = (in_hundredths(progress, number, pieces) for number in range(pieces))
        edge = partial(self.model.margin_edge, self, quantity)
        below, above = (outward(way, edge, list(islice(reports, len(way) - 1)), 0.5 * seconds) for way in ways)
        if progress is not None:
            progress(100 * pieces, 100 * pieces)
        return Margin.between(below, above, here)

    def margins(self, seconds: float = MARGIN_SECONDS, progress: Progress | None = None) -> dict[Quantity, Margin]:
        """Return the `margin` of every quantity, and find the damping that stabilises.

        Parameters
        ----------
        seconds : float
            About how long each may take, as for `margin`.
        progress : callable, optional
            Called with the numbers of hundredths done and of all, 100.

        Returns
        -------
        dict of str to Margin
            By "mean", "amplitude" and "frequency".

        Raises
        ------
        ValueError
            For ``seconds`` of zero or less.
        """
        validate.progress(progress)
        margins: dict[Quantity, Margin] = {}
        for i, quantity in enumerate(WAYS):

            def quarter(done: int, parts: int, before: int = 25 * i) -> None:
                if progress is not None:
                    progress(before + 25 * done // parts, 100)

            margins[quantity] = self.margin(quantity, seconds=seconds, progress=quarter)
        _ = self.damping_to_stabilise  # kept with the verdict
        if progress is not None:
            progress(100, 100)
        return margins

    @property
    def has_quick_margins(self) -> bool:
        """Whether margins take some seconds at most, as they do except for many modes without exact margins.

        False, too, where they would leave out what counts in the verdict on a measured force.
        """
        if self.left_out:
            return False
        if isinstance(self.evidence, TwoFrequencyEvidence | TwoFrequencyCoupledEvidence):
            return self.evidence.seconds <= _QUICK_VERDICT
        return self.has_exact_margins or self.modes_checked <= FEW_MODES

    @property
    def has_exact_margins(self) -> bool:
        """Whether margins follow from the tongues, so that they miss nothing."""
        return self.evidence.has_exact_margins or self.model.has_exact_margins

    @property
    def margin_tolerance(self) -> float:
        """Growth in 1/s up to which loads count as stable in the margins.

        The growth tolerance, and at least 1e-6: a margin to a tongue in which nothing grows within a month would be of
        no use.  Where the load itself lies in such a tongue the margins end at the tongue's edges.
        """
        tolerance = max(self.growth_tolerance, SLOW_GROWTH)
        return tolerance if self.stable or self.growth_rate > tolerance else self.growth_tolerance

    def report(
        self, units: Mapping[str, str] | None = None, margins: Mapping[Quantity, Margin] | None = None
    ) -> Report:
        """Return the verdict in lines and a table: resonances, rod and load, growth, margins, method, modes.

        Parameters
        ----------
        units : mapping, optional
            In which to show mean, amplitude, frequency, other forces, lengths and pressures: ``{"mean": "Fcr",
            "frequency": "Hz", "force": "lbf", "length": "ft", "pressure": "ksi"}``; N, rad/s, m and MPa without, ft and
            ksi beside pounds.
        margins : mapping, optional
            The result of `margins`, reported with the damping that stabilises.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.

        Raises
        ------
        TypeError, ValueError
            For another unit.
        """
        evidence, shown = self.evidence, shown_in(units, self.rod, self.load)
        lines = subject_lines(self.rod, self.load, shown)
        if self.growth_rate > 0.0:
            rate = f"{self.growth_rate:.{_digits(self)}g} 1/s{_growing_mode(self)}"
            lines.append(("growth", f"{rate}, tenfold in {self.time_to_grow(10.0):.4g} s"))
        lines += _resonance_lines(evidence)
        if (place := self._place_of_growth) is not None:
            words = section_in_words(self.rod, place, answer_units(shown))
            lines.append(("", f"most in {words}, at {shown['length'].show(place, 4)} from the upper end"))
        if margins is not None:
            status = self.status
            if self.left_out:  # margins are of the fit, whose status is known
                status = "unstable" if self.growth_rate > self.growth_tolerance else "stable"
            lines += margin_lines(margins, status, shown, self._band_beyond)
            if self.left_out:
                lines.append(("", f"margins and damping are of the fit alone and leave out {self.left_out}"))
            if not self.has_exact_margins:
                lines.append(("", missed_changes(margins, shown)))
            lines += damping_lines(self)
        table = table_of_parts(self.rod, answer_units(shown)) if self.rod.varies else _mode_table(evidence)
        lines.append(("checked", self.cutoff))
        if table is not None and not self.rod.varies:
            lines.append(("", "of these modes the table lists those that grow and the nearest to growth"))
        lines.append(("method", _method(self)))
        lines += [("note", self.note)] if self.note else []
        return Report(_headline(self), lines, table, assumptions=self.assumptions)

    @property
    def _place_of_growth(self) -> float | None:
        """Where along a string of several sections it grows most, in m; None elsewhere, or where that takes long."""
        is_short = isinstance(self.evidence, CoupledEvidence) and self.evidence.coupled.size <= _QUICK_SHAPE
        grows = self.rod.varies and self.status == "unstable" and is_short
        return self.shape.position if grows else None

    def _band_beyond(self, quantity: Quantity, change: float) -> BandBeyond | None:
        """Return the unstable band in which a margin of a stable load ends, None where it is not known."""
        return self.model.band_beyond(self, quantity, change) if math.isfinite(change) else None

    def as_dict(self, margins: Mapping[Quantity, Margin] | None = None) -> dict[str, Any]:
        """Return the verdict as numbers for JSON, units in the keys; None for infinite or unknown numbers.

        With ``margins``, which `margins` returns, these and the damping that stabilises.

        Returns
        -------
        dict of str
            Numbers, texts and lists by name.

        Raises
        ------
        TypeError, ValueError
            For margins that `margins` does not return.
        """
        rod, load, near = self.rod, self.load, {}
        if margins is not None:
            near = margins_as_dict(margins, self._band_beyond) | by_keys(self, "damping_to_stabilise_per_s")
            near |= {"margins_leave_out": self.left_out} if self.left_out else {}
        return {
            **by_keys(self, "status unstable_modes growth_rate_per_s decay_rate_per_s fastest_mode"),
            "time_to_grow_tenfold_s": plain(self.time_to_grow(10.0)),
            **near,
            **by_keys(
                self,
                "modes_checked growth_tolerance_per_s critical_force_N=rod.critical_force rod "
                "mass_per_length_kg_per_m=rod.mass_per_length weight_per_length_N_per_m=rod.weight_per_length "
                f"{'' if rod.varies else 'flexural_rigidity_N_m2=rod.flexural_rigidity'} assumptions "
                "mean_N=load.mean amplitude_N=load.amplitude "
                "frequency_rad_per_s=load.frequency",
            ),
            **({} if load.is_uniform else {"axial_response": rod.axial_response(load).as_dict()}),
            **({"parts": parts_as_dicts(rod)} if rod.varies else {}),
            **({} if (place := self._place_of_growth) is None else {"grows_most_at_m": place}),
            **({} if rod.yield_strength is None else {"stress": rod.stress(load).as_dict()}),
            **_evidence_as_dict(self),
        }

    def __repr__(self) -> str:
        """Return the verdict as a sentence."""
        return f"<{_sentence(self)}; {self.cutoff}>"


# --- what a verdict says, for each kind of evidence ---


def growing_in_words(verdict: RodStability) -> str:
    """Return the fastest mode or resonance in words, to stand before "at so many 1/s"."""
    match verdict.evidence:
        case IndependentEvidence() | TwoFrequencyEvidence():
            return f"mode {verdict.fastest_mode} grows"
        case CoupledEvidence():
            return f"{verdict.resonances[0]}," if verdict.resonances else "growth"
        case NoisyEvidence():
            mode = verdict.fastest_mode
            return f"{'all high modes grow' if mode is None else f'mode {mode} grows'} in mean square"
        case NoisyCoupledEvidence():
            return "coupled modes grow in mean square"
        case TwoFrequencyCoupledEvidence():
            return "growth"


def damping_lines(verdict: RodStability) -> list[ReportLine]:
    """Return the damping that stabilises, in words; no line where the load is stable with any."""
    if math.isinf(damping := verdict.damping_to_stabilise):
        text = "strong damping does not stabilise it, as the mean force alone buckles a mode; weak damping may"
        is_sampled = isinstance(verdict.evidence, NoisyEvidence | TwoFrequencyEvidence)
        if is_sampled and not cast("Any", verdict.model).buckles(verdict.load, verdict.growth_tolerance):
            text = "every damping_rate tried leaves growth, up to ten times the frequencies of load and rod"
        return [("damping", text)]
    rates = "a damping_rate" if verdict.has_exact_margins else "every damping_rate tried"
    calm = "no mode grows in mean square" if isinstance(verdict.evidence, NoisyEvidence) else "stable"
    return [("damping", f"{calm} with {rates} above {damping:.6g} 1/s")] if damping > 0.0 else []


def _headline(verdict: RodStability) -> str:
    """Return the verdict, with the modes or resonances that grow and the time in which they do so tenfold."""
    evidence, status = verdict.evidence, verdict.status
    is_noisy = isinstance(evidence, NoisyEvidence | NoisyCoupledEvidence)
    subject = f"{status.upper()}{' in mean square' if is_noisy else ''}"
    tenfold = f"tenfold in {verdict.time_to_grow():.3g} s"
    if status == "stable" and isinstance(evidence, TwoFrequencyEvidence | TwoFrequencyCoupledEvidence):
        return f"{subject}: {_within(verdict)}"
    if status == "stable":
        slow = f"growth of {verdict.growth_rate:.3g} 1/s is within the tolerance of {verdict.growth_tolerance:g} 1/s"
        return f"{subject}: {slow if verdict.growth_rate > 0.0 else _nothing_grows(evidence)}"
    if status == "undecided":
        return f"{subject}: {_undecided(verdict)}"
    match evidence:
        case IndependentEvidence() | TwoFrequencyEvidence():
            modes = verdict.unstable_modes
            fastest = f"; mode {verdict.fastest_mode} fastest" if len(modes) > 1 else ""
            return f"{subject}: {_modes_grow(modes)}{fastest}, {tenfold}"
        case CoupledEvidence():
            growing = [r for r in evidence.resonances if r.growth_rate > verdict.growth_tolerance]
            more = f", and {len(growing) - 1} more" if len(growing) > 1 else ""
            return f"{subject}: {f'{growing[0]}{more}' if growing else 'the rod grows'}; {tenfold}"
        case NoisyEvidence():
            return f"{subject}: {_noisy_modes_grow(verdict, evidence)}; {tenfold}"
        case NoisyCoupledEvidence() | TwoFrequencyCoupledEvidence():
            return f"{subject}: coupled modes grow, {tenfold}"


def _digits(verdict: RodStability) -> int:
    """Return the digits of a growth rate that its error leaves, of a rod under noise; 6 else."""
    if not isinstance(verdict.evidence, NoisyEvidence) or not 0.0 < verdict.error < math.inf:
        return 6
    return min(6, max(2, math.ceil(math.log10(verdict.growth_rate / verdict.error)) + 1))


def _within(verdict: RodStability) -> str:
    """Return up to which rate no mode grows under two frequencies, and which modes are meant."""
    evidence = verdict.evidence
    modes = "nothing"
    if isinstance(evidence, TwoFrequencyEvidence):
        modes = "none of the modes checked" if math.isinf(evidence.left_out_bound) else "no mode"
    if verdict.growth_tolerance:
        return f"{modes} grows faster than the tolerance of {verdict.growth_tolerance:g} 1/s"
    return f"{modes} grows: damping exceeds what approximants leave open, {verdict.error:.1g} 1/s"


def _nothing_grows(evidence: Evidence) -> str:
    """Return that no mode grows, of all modes or of the modes that the caller chose."""
    match evidence:
        case IndependentEvidence() | NoisyEvidence() if math.isinf(evidence.left_out_bound):
            return "none of the modes checked grows"
        case IndependentEvidence() | NoisyEvidence():
            return "no mode grows"
        case _:
            return "nothing grows"


def _undecided(verdict: RodStability) -> str:
    """Return why a verdict is undecided."""
    if verdict.undecided_by:
        return verdict.undecided_by
    evidence = verdict.evidence
    match evidence:
        case TwoFrequencyEvidence():
            unsure = [i for i, growth in enumerate(evidence.mode_verdicts) if growth.status == "undecided"]
            i = max(unsure, key=evidence.mode_growth_rates.item)
            rate, error = evidence.mode_growth_rates[i], evidence.mode_growth_errors[i]
            others = f", and that of {len(unsure) - 1} others is uncertain too" if len(unsure) > 1 else ""
            return (
                f"growth of mode {evidence.modes[i]} is {rate:.3g} +- {error:.1g} 1/s by periodic approximants{others}"
            )
        case IndependentEvidence() | NoisyEvidence():
            rows: Any = zip(evidence.modes, evidence.mode_verdicts, strict=True)
            modes = [mode for mode, verdict in rows if verdict.status == "undecided"]
            if modes:
                lies = f"modes {listed(modes)} lie" if len(modes) > 1 else f"mode {modes[0]} lies"
                return f"{lies} nearer to a boundary of stability than the error"
    return "the error of the growth rate is too large to decide whether the rod is stable"


def _sentence(verdict: RodStability) -> str:
    """Return status, growth and the modes that grow, and of waves how large the vibration becomes."""
    evidence, status = verdict.evidence, verdict.status
    rate = f"{verdict.growth_rate:.6g} 1/s"
    growth = f"{rate}, tenfold in {verdict.time_to_grow():.3g} s"
    match evidence:
        case IndependentEvidence() if status == "stable":
            slow = f", growth {verdict.growth_rate:.3g} 1/s within the tolerance" if verdict.growth_rate > 0.0 else ""
            return f"stable{slow}"
        case TwoFrequencyEvidence() | TwoFrequencyCoupledEvidence() if status == "stable":
            return f"stable: {_within(verdict)}"
        case TwoFrequencyCoupledEvidence():
            return f"unstable: coupled modes grow at {growth}" if status == "unstable" else status
        case IndependentEvidence() | TwoFrequencyEvidence() if status == "undecided":
            return "undecided"
        case IndependentEvidence() | TwoFrequencyEvidence():
            return f"unstable: {_modes_grow(verdict.unstable_modes)}; mode {verdict.fastest_mode} at {growth}"
        case CoupledEvidence():
            wave = f"; {verdict.axial.in_words}" if not verdict.load.is_uniform and verdict.load.amplitude else ""
            if status == "unstable" and evidence.resonances:
                return f"unstable: {evidence.resonances[0]}; {growth}{wave}"
            return f"{status}: growth {rate}{wave}" if verdict.growth_rate > 0.0 else f"{status}{wave}"
    if status != "unstable":
        return f"{status} in mean square"
    if isinstance(evidence, NoisyCoupledEvidence):
        return f"unstable in mean square: {growth}"
    mode = "" if verdict.fastest_mode is None else f"mode {verdict.fastest_mode} at "
    return f"unstable in mean square: {_noisy_modes_grow(verdict, evidence)}; {mode}{growth}"


def _modes_grow(modes: tuple[int, ...]) -> str:
    return f"modes {listed(modes)} grow" if len(modes) > 1 else f"mode {listed(modes)} grows"


def _noisy_modes_grow(verdict: RodStability, evidence: NoisyEvidence) -> str:
    """Return the modes that grow in mean square, with all high ones where these do."""
    modes = verdict.unstable_modes
    beyond = math.isfinite(evidence.left_out_bound) and max(0.0, evidence.limit) > verdict.growth_tolerance
    if not modes:
        return "all high modes grow" if beyond else f"mode {verdict.fastest_mode} grows"
    others = ", and all high modes" if beyond else ""
    if len(modes) > 3:
        return f"{len(modes)} modes grow, {modes[0]} to {modes[-1]}{others}"
    return (f"modes {', '.join(map(str, modes))} grow" if len(modes) > 1 else f"mode {modes[0]} grows") + others


def _growing_mode(verdict: RodStability) -> str:
    """Return, to stand behind the growth rate, in which mode; "" where that is said elsewhere."""
    match verdict.evidence:
        case IndependentEvidence() | TwoFrequencyEvidence():
            return f" in mode {verdict.fastest_mode}"
        case CoupledEvidence() | TwoFrequencyCoupledEvidence():
            return ""
        case NoisyEvidence() if verdict.fastest_mode is not None:
            return f" in mean square in mode {verdict.fastest_mode}"
        case _:
            return " in mean square"


def _method(verdict: RodStability) -> str:
    """Return the methods and the error; no error of coupled modes where only a lower bound of growth is known."""
    evidence, error = verdict.evidence, f"{verdict.error:.0e}"
    match evidence:
        case IndependentEvidence():
            methods = ", ".join(sorted({mode_verdict.method for mode_verdict in evidence.mode_verdicts}))
            return f"{methods}; discriminants good to {error} relative"
        case NoisyEvidence():
            methods = ", ".join(sorted({mode_verdict.method for mode_verdict in evidence.mode_verdicts}))
            less, more = evidence.growth_errors
            rate = verdict.growth_rate
            if max(less, more) > _UNEVEN * rate > 0.0 and verdict.status == "unstable":
                known = f"from {max(0.0, rate - less):.3g} to {rate + more:.3g} 1/s, estimated"
                return f"second moments, {methods}; growth {known}, as the noise is uneven or slow"
            return f"second moments, {methods}; growth good to {error} 1/s"
        case CoupledEvidence():
            method = f"{evidence.whole.method}, {verdict.cost}"
        case TwoFrequencyEvidence() | TwoFrequencyCoupledEvidence():
            method = f"periodic approximants, {verdict.cost}"
        case NoisyCoupledEvidence():
            method = "second moments of coupled modes"
    return method + (f"; growth good to {error} 1/s" if math.isfinite(verdict.error) else "")


def _resonance_lines(evidence: Evidence) -> list[ReportLine]:
    """Return the fastest resonances of coupled modes; independent modes are in the table."""
    if not isinstance(evidence, CoupledEvidence):
        return []
    lines = [
        ("" if i else "grows", f"{resonance}, {resonance.growth_rate:.6g} 1/s")
        for i, resonance in enumerate(evidence.resonances[:_LISTED_RESONANCES])
    ]
    more = len(evidence.resonances) - _LISTED_RESONANCES
    return lines + ([("", f"and {more} more, which grow more slowly (the JSON lists them)")] if more > 0 else [])


def _mode_table(evidence: Evidence) -> Table | None:
    """Return the modes that grow and the five nearest to growth, in order; None of coupled modes.

    Without noise the nearest are those whose discriminants come nearest to the boundary.
    """
    if isinstance(evidence, IndependentEvidence | NoisyEvidence):
        troubled = sum(verdict.status != "stable" for verdict in evidence.mode_verdicts)
    match evidence:
        case IndependentEvidence():
            room = [-math.inf if v.status != "stable" else 2.0 - abs(v.discriminant) for v in evidence.mode_verdicts]
            nearest = sorted(range(len(room)), key=room.__getitem__)[: max(_LISTED_MODES, troubled)]
            modes, equations, rates = evidence.modes, evidence.mode_equations, evidence.mode_growth_rates
            return Table(
                [("mode", ">4"), ("alpha", ">10"), ("beta", ">11"), ("where", "<21"), ("growth 1/s", ">10")],
                [
                    (
                        str(modes[i]),
                        f"{equations[i].alpha:.5g}",
                        f"{equations[i].beta:.6g}",
                        str(evidence.mode_verdicts[i].interval or evidence.mode_verdicts[i].status),
                        f"{rates[i]:.4g}",
                    )
                    for i in sorted(nearest)
                ],
            )
        case NoisyEvidence():
            count = max(_LISTED_MODES, min(troubled, 4 * _LISTED_MODES))
            fastest = np.argsort(-evidence.mode_growth_rates, kind="stable")[:count]
            return Table(
                [("mode", ">4"), ("noise 1/s^1.5", ">14"), ("where", "<10"), ("growth of q^2 1/s", ">18")],
                [
                    (
                        str(evidence.modes[i]),
                        f"{evidence.mode_intensities[i]:.5g}",
                        evidence.mode_verdicts[i].status,
                        f"{evidence.mode_growth_rates[i]:.5g}",
                    )
                    for i in sorted(fastest.tolist())
                ],
            )
        case TwoFrequencyEvidence():
            fastest = np.argsort(-evidence.mode_growth_rates, kind="stable")[: 2 * _LISTED_MODES]
            return Table(
                [("mode", ">4"), ("where", "<10"), ("growth 1/s", ">10"), ("error 1/s", ">9"), ("ratio up to", ">11")],
                [
                    (
                        str(evidence.modes[i]),
                        evidence.mode_verdicts[i].status,
                        f"{evidence.mode_growth_rates[i]:.5g}",
                        f"{evidence.mode_growth_errors[i]:.1g}",
                        str(evidence.mode_verdicts[i].approximants[-1][0]),
                    )
                    for i in sorted(fastest.tolist())
                ],
            )
        case _:
            return None


def _evidence_as_dict(verdict: RodStability) -> dict[str, Any]:
    """Return the evidence as numbers for JSON: every mode, or numbers of modes tried and resonances."""
    evidence = verdict.evidence
    growth_error = {"growth_rate_error_per_s": number(verdict.error)}
    match evidence:
        case IndependentEvidence():
            return {
                "left_out_growth_bound_per_s": number(evidence.left_out_bound),
                "modes": [
                    {
                        "mode": mode,
                        "alpha": equation.alpha,
                        "beta": equation.beta,
                        "status": stability.status,
                        "interval": str(stability.interval) if stability.interval else None,
                        "growth_rate_per_s": float(rate),
                        "discriminant": number(stability.discriminant),
                        "discriminant_relative_error": number(stability.error),
                        "method": stability.method,
                    }
                    for mode, equation, stability, rate in zip(
                        evidence.modes,
                        evidence.mode_equations,
                        evidence.mode_verdicts,
                        evidence.mode_growth_rates,
                        strict=True,
                    )
                ],
            }
        case CoupledEvidence():
            return {
                **growth_error,
                "convergence": [{"modes": n, "growth_rate_per_s": number(rate)} for n, rate in evidence.convergence],
                "resonances": [resonance.as_dict("growth_rate_per_s") for resonance in evidence.resonances],
                "load": verdict.load.kind_as_dict(),
                "structure": evidence.whole.structure,
                "method": evidence.whole.method,
                "cost": str(verdict.cost),
                "note": verdict.note,
            }
        case NoisyEvidence():
            return {
                "in_mean_square": True,
                **growth_error,
                "left_out_growth_bound_per_s": number(evidence.left_out_bound),
                "load": verdict.load.kind_as_dict(),
                "modes": [
                    {
                        "mode": mode,
                        "status": moments.status,
                        "growth_of_second_moments_per_s": number(float(rate)),
                        "noise_per_s_1.5": float(intensity),
                        "method": moments.method,
                    }
                    for mode, moments, rate, intensity in zip(
                        evidence.modes,
                        evidence.mode_verdicts,
                        evidence.mode_growth_rates,
                        evidence.mode_intensities,
                        strict=True,
                    )
                ],
                "note": verdict.note,
            }
        case TwoFrequencyEvidence():
            return {
                **growth_error,
                "left_out_growth_bound_per_s": number(evidence.left_out_bound),
                "load": verdict.load.kind_as_dict(),
                "modes": [
                    {
                        "mode": mode,
                        "status": growth.status,
                        "growth_rate_per_s": number(float(rate)),
                        "growth_rate_error_per_s": number(float(error)),
                        "ratio_of_frequencies_up_to": str(growth.approximants[-1][0]),
                    }
                    for mode, growth, rate, error in zip(
                        evidence.modes,
                        evidence.mode_verdicts,
                        evidence.mode_growth_rates,
                        evidence.mode_growth_errors,
                        strict=True,
                    )
                ],
                "note": verdict.note,
            }
        case NoisyCoupledEvidence():
            return {
                "in_mean_square": True,
                **growth_error,
                "convergence": [
                    {"modes": n, "growth_of_second_moments_per_s": number(rate)} for n, rate in evidence.convergence
                ],
                "load": verdict.load.kind_as_dict(),
                "note": verdict.note,
            }
        case TwoFrequencyCoupledEvidence():
            return {
                **growth_error,
                "convergence": [{"modes": n, "growth_rate_per_s": number(rate)} for n, rate in evidence.convergence],
                "ratio_of_frequencies_up_to": str(evidence.growth.approximants[-1][0]),
                "load": verdict.load.kind_as_dict(),
                "note": verdict.note,
            }


def _drawn_shape(verdict: RodStability) -> tuple[Shape, str]:
    """Return the shape in which the rod grows, and the name of what grows; ValueError where there is none to draw."""
    evidence = verdict.evidence
    match evidence:
        case CoupledEvidence():
            return evidence.shape, str(next(iter(evidence.resonances), ""))
        case IndependentEvidence() | TwoFrequencyEvidence() if verdict.growth_rate > 0.0:
            mode = evidence.modes[int(evidence.mode_growth_rates.argmax())]
            s = np.linspace(0.0, verdict.rod.length, 24 * mode + 1)
            sine = np.sin(math.pi * mode * s / s[-1])
            return Shape(s, sine, np.abs(sine)), f"mode {mode}"
        case IndependentEvidence() | TwoFrequencyEvidence():
            missing = "draws the shape in which the rod grows, and of these modes none does"
        case NoisyEvidence():
            missing = "draws the shape in which coupled modes grow, and these modes are independent"
        case NoisyCoupledEvidence():
            missing = "draws the shape in which coupled modes grow, and random motion has none"
        case TwoFrequencyCoupledEvidence():
            missing = "draws the shape in which coupled modes grow, which two frequencies change all the time"
    raise validate.wrong_value("plot", missing)
