"""The verdict on a rod, whatever couples its modes: what grows, how fast, and how far the load is from a change."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from itertools import islice
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arrays import Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.interchange import by_keys, plain
from floquetrod._util.progress import Progress
from floquetrod._util.result_report import Report, Reported, Table
from floquetrod._util.suggest import listed
from floquetrod.equations import HillSystem, Mathieu
from floquetrod.floquet.multipliers.resonance_names import Resonance
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.references import ROD, references, united
from floquetrod.floquet.verdict import Stability, Verdict
from floquetrod.rod.answers.margins import FEW_MODES, MARGIN_SECONDS, WAYS, Edge, Margin, in_hundredths, outward
from floquetrod.rod.answers.reports import margin_lines, margins_as_dict, shown_in, subject_lines
from floquetrod.rod.loads.axial import AxialResponse
from floquetrod.rod.loads.load import Load, Quantity
from floquetrod.rod.mode_equations.modal_systems import ModalSystem
from floquetrod.rod.model.constants import SLOW_GROWTH
from floquetrod.rod.model.data import RodData

if TYPE_CHECKING:
    from floquetrod.rod.mode_equations.coupled_systems import CoupledEquations


_TOLD_OF_ONE = ("mode_verdicts", "mode_growth_rates", "mode_equations", "whole", "convergence", "shape", "system")
"""Names that are defined for one kind of modes only."""


class Shape(NamedTuple):
    """The fastest growing solution along the rod, with its growth removed; its largest deflection is 1.

    Attributes
    ----------
    s : ndarray
        Position in m from the upper end.
    deflection : ndarray
        At the instant of largest deflection.
    envelope : ndarray
        Largest deflection over a period, at each position.
    """

    s: Floats
    deflection: Floats
    envelope: Floats


class Evidence(ABC):
    """What a verdict rests on: the equations of the modes under the load, and what was found of them.

    Every model of the modes has its own; a verdict asks it for what depends on the equations.
    """

    kind: ClassVar[str]
    """Of which modes it is, in words."""

    @property
    @abstractmethod
    def load(self) -> Load:
        """The load."""

    @property
    @abstractmethod
    def modes(self) -> tuple[int, ...]:
        """Modes examined."""

    @property
    @abstractmethod
    def cutoff(self) -> str:
        """Why these modes and no others."""

    @property
    @abstractmethod
    def references(self) -> tuple[str, ...]:
        """What to cite for the methods used."""

    @property
    @abstractmethod
    def resonances(self) -> tuple[Resonance, ...]:
        """What grows, the fastest first."""

    def unstable_modes(self, verdict: RodStability) -> tuple[int, ...]:
        """Return the modes that take part in what grows faster than the tolerance."""
        if verdict.status != "unstable":
            return ()
        growing = [r for r in self.resonances if r.growth_rate > verdict.growth_tolerance]
        return tuple(sorted({mode for resonance in growing for mode in resonance.modes}))

    def fastest_mode(self, verdict: RodStability) -> int | None:
        """Return the mode that grows fastest, the lower one of a combination; None when none grows, or is named."""
        return min(self.resonances[0].modes) if self.resonances and verdict.growth_rate > 0.0 else None

    @abstractmethod
    def damping_to_stabilise(self, verdict: RodStability) -> float:
        """Return the smallest damping rate in 1/s from which every larger one keeps all modes from growing."""

    @abstractmethod
    def growth_of(self, verdict: RodStability, mode: int) -> float:
        """Return the growth rate of a mode in 1/s, of the rod where it has none of its own."""

    def is_fastest(self, verdict: RodStability, mode: int | None) -> bool:
        """Return whether the growth rate of the rod is that of a mode."""
        return mode == verdict.fastest_mode

    def plot(self, verdict: RodStability, ax: Any = None) -> Any:
        """Draw the shape in which the rod grows; return the axes."""
        from floquetrod.plotting.rod_plot import draw_shape

        return draw_shape(verdict, verdict.shape, str(next(iter(verdict.resonances), "")), ax)

    # --- what a report says of it ---

    has_exact_margins: ClassVar[bool] = False
    """Whether margins are computed in milliseconds from boundaries; else they are found by sampling."""

    enough: ClassVar[str] = "stable at every rate tried above {}"
    """Which damping rates stabilise, with {} for the least."""

    @abstractmethod
    def headline(self, verdict: RodStability) -> str:
        """Return what grows, or why that is not known; "" where there is nothing to say."""

    def fastest_in_words(self, verdict: RodStability) -> str:
        """Return what grows fastest, to stand before "at so many 1/s"."""
        return f"{self.resonances[0]}," if self.resonances else "growth"

    def grows_in(self, verdict: RodStability) -> str:
        """Return, to stand behind the growth rate, in which mode; "" where that is said elsewhere."""
        return ""

    @abstractmethod
    def method(self, verdict: RodStability) -> str:
        """Return how the verdict was found, and how good it is."""

    def named_lines(self, verdict: RodStability) -> list[tuple[str, str]]:
        """Return lines that name what grows."""
        return []

    @property
    def table(self) -> Table | None:
        """The modes nearest to trouble, where each has an equation of its own."""
        return None

    @abstractmethod
    def numbers(self, verdict: RodStability) -> dict[str, Any]:
        """Return what `RodStability.as_dict` has besides."""

    @abstractmethod
    def edge(
        self,
        verdict: RodStability,
        varied: Quantity,
        piece: tuple[float, float],
        seconds: float,
        progress: Progress | None,
    ) -> Edge:
        """Return where the verdict first changes from ``piece[0]`` to ``piece[1]``, in about so many seconds."""

    def sentence(self, verdict: RodStability) -> str:
        """Return status, growth and the modes that grow."""
        if verdict.status == "stable":
            slow = f", growth {verdict.growth_rate:.3g} 1/s within the tolerance" if verdict.growth_rate > 0.0 else ""
            return f"stable{slow}"
        if verdict.status == "undecided":
            return "undecided"
        names = listed(verdict.unstable_modes)
        some = f"modes {names} grow" if len(verdict.unstable_modes) > 1 else f"mode {names} grows"
        return (
            f"unstable: {some}; mode {verdict.fastest_mode} at {verdict.growth_rate:.6g} 1/s, tenfold in "
            f"{verdict.time_to_grow():.3g} s"
        )


@dataclass(frozen=True, kw_only=True, repr=False)
class RodStability(Reported, Verdict):
    """Verdict on a rod under a load, in 1/s and s.

    It has all that every `Verdict` has.  Stable when nothing grows faster than the tolerance; the growth rate is that
    of the fastest solution, within the tolerance or not; the exponents are those of all modes, or, of more than 60 that
    are coupled, of those that may resonate.  Where modes are independent ``error`` is the largest of a mode's
    discriminant; where they are coupled that of the growth rate in 1/s, of the multipliers and, estimated, of the modes
    left out.  Of independent modes under noise it is that of the growth rate in 1/s, with a bound on all other modes.

    Attributes
    ----------
    rod : Rod
    growth_tolerance : float
        Growth in 1/s up to which a mode counts as stable.
    evidence : Evidence
        Basis of the verdict.

    Modes are numbered as those of the rod without axial force, which have the same ends.  Attributes of one kind of
    modes only, such as `mode_verdicts` or `shape`, raise an AttributeError that says so for the other.
    """

    rod: RodData
    growth_tolerance: float
    evidence: Evidence

    @property
    def load(self) -> Load:
        """The load."""
        return self.evidence.load

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
        return self.evidence.cutoff

    @property
    def resonances(self) -> tuple[Resonance, ...]:
        """The resonances that grow, the fastest first, such as "direct resonance of mode 7, order 1".

        A combination resonance has two modes.  Coupled modes are named by a heuristic, see `SystemStability`.
        """
        return self.evidence.resonances

    @property
    def unstable_modes(self) -> tuple[int, ...]:
        """Modes that grow, alone or in a combination, faster than the tolerance."""
        return self.evidence.unstable_modes(self)

    @property
    def fastest_mode(self) -> int | None:
        """Mode that grows fastest, the lower one of a combination; None when none grows or none could be named."""
        return self.evidence.fastest_mode(self)

    @cached_property
    def damping_to_stabilise(self) -> float:
        """Smallest damping rate in 1/s from which every larger one keeps all modes from growing.

        The rate meant is the rod's whole ``damping_rate``, whatever it is now.  Infinite when the mean force alone
        buckles the rod: damping only slows that down.  Where modes are coupled it is that from which this load no
        longer makes the rod grow faster than the tolerance, found to ten digits and tried at two, four and eight times
        as much.
        """
        return self.evidence.damping_to_stabilise(self)

    # --- defined for one kind of modes only ---

    @property
    def system(self) -> ModalSystem | HillSystem:
        """The equations, of independent modes a `ModalSystem`, of coupled ones a `HillSystem` in seconds."""
        found: ModalSystem | HillSystem = self._told("system")
        return found

    @property
    def mode_equations(self) -> tuple[Mathieu, ...]:
        """Equation of each independent mode, in the time tau = omega t."""
        return tuple(self._told("mode_equations"))

    @property
    def mode_verdicts(self) -> tuple[Stability, ...]:
        """Verdict on each independent mode."""
        return tuple(self._told("mode_verdicts"))

    @property
    def mode_growth_rates(self) -> Floats:
        """Growth rate of each independent mode in 1/s."""
        return np.asarray(self._told("mode_growth_rates"))

    @property
    def left_out_bound(self) -> float:
        """Bound in 1/s on the growth of every mode but these, infinite where the modes were chosen by the caller."""
        return float(self._told("left_out_bound"))

    @property
    def coupled(self) -> CoupledEquations:
        """The coordinates in which the motion of coupled modes is written, and their kind of load."""
        found: CoupledEquations = self._told("coupled")
        return found

    @property
    def whole(self) -> SystemStability:
        """Verdict on the system of coupled modes."""
        found: SystemStability = self._told("whole")
        return found

    @property
    def convergence(self) -> tuple[tuple[int, float], ...]:
        """Numbers of coupled modes and the growth rate in 1/s with each; the last one is the answer."""
        return tuple(self._told("convergence"))

    @property
    def shape(self) -> Shape:
        """Where along the rod the fastest solution of coupled modes moves most, growing or not."""
        found: Shape = self._told("shape")
        return found

    @property
    def axial(self) -> AxialResponse:
        """How large the vibration becomes along the rod, where, and the nearest axial resonances."""
        return self.rod.axial_response(self.load)

    def growth_of(self, mode: int) -> float:
        """Return the growth rate of a mode in 1/s, of the rod where modes are coupled."""
        return self.evidence.growth_of(self, validate.integer("mode", mode, 1, validate.MOST_NUMBERS))

    def is_fastest(self, mode: int | None) -> bool:
        """Return whether the growth rate is that of a mode; of coupled modes it is that of any."""
        return self.evidence.is_fastest(self, mode)

    def plot(self, ax: Any = None) -> Any:
        """Draw the `shape` in which the rod grows; return the axes.  ValueError where independent modes do not."""
        return self.evidence.plot(self, ax)

    def _told(self, name: str) -> Any:
        """Return an attribute of the evidence; AttributeError where it is not defined."""
        known = dir(self.evidence)
        if name in known:
            return getattr(self.evidence, name)
        told = ", ".join(each for each in _TOLD_OF_ONE if each in known)
        raise AttributeError(f"{name} is not defined for {self.evidence.kind}, the subject of this verdict; use {told}")

    def time_to_grow(self, factor: float = 10.0) -> float:
        """Return the time in s in which the fastest mode grows by ``factor``, infinite when none grows."""
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
            For another quantity, and for ``seconds`` that are not greater than zero.
        """
        validate.choice("quantity", quantity, WAYS)
        if not (isinstance(seconds, float) and seconds == math.inf):
            seconds = units.number("seconds", seconds, "time", math.ulp(0.0), hint="leave it out to search everything")
        validate.progress(progress)
        here: float = getattr(self.load, quantity)
        ways = [[here, *way] for way in WAYS[quantity](here, self.rod.critical_force)]
        parts = sum(len(way) - 1 for way in ways)
        told = (in_hundredths(progress, number, parts) for number in range(parts))
        edge = partial(self.evidence.edge, self, quantity)
        ends = [outward(way, edge, list(islice(told, len(way) - 1)), 0.5 * seconds) for way in ways]
        if progress is not None:
            progress(100 * parts, 100 * parts)
        below, above = (math.inf if end.at is None else abs(end.at - here) for end in ends)
        searched = abs(ends[0].searched - here), abs(ends[1].searched - here)
        return Margin(below, above, max(end.resolution for end in ends), searched)

    def margins(self, seconds: float = MARGIN_SECONDS, progress: Progress | None = None) -> dict[Quantity, Margin]:
        """Return the `margin` of every quantity, and find the damping that stabilises.

        Parameters
        ----------
        seconds : float
            About how long each may take, as for `margin`.
        progress : callable, optional
            Called with the numbers of hundredths done and of all, 100.

        Raises
        ------
        ValueError
            For ``seconds`` that are not greater than zero.
        """
        validate.progress(progress)
        found: dict[Quantity, Margin] = {}
        for i, quantity in enumerate(WAYS):

            def told(done: int, parts: int, before: int = 25 * i) -> None:
                if progress is not None:
                    progress(before + 25 * done // parts, 100)

            found[quantity] = self.margin(quantity, seconds=seconds, progress=told)
        _ = self.damping_to_stabilise  # kept with the verdict
        if progress is not None:
            progress(100, 100)
        return found

    @property
    def has_quick_margins(self) -> bool:
        """Whether margins take some seconds at most, as all do but those of many coupled modes."""
        return self.evidence.has_exact_margins or self.modes_checked <= FEW_MODES

    @property
    def margin_tolerance(self) -> float:
        """Growth in 1/s up to which loads count as stable in the margins.

        The growth tolerance, and at least 1e-6: a margin to a tongue in which nothing grows within a month would be of
        no use.  Where the load itself lies in such a tongue the margins are those of the tongue.
        """
        least = max(self.growth_tolerance, SLOW_GROWTH)
        return least if self.stable or self.growth_rate > least else self.growth_tolerance

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
        """
        evidence, shown = self.evidence, shown_in(units, self.rod.critical_force)
        lines = subject_lines(self.rod, self.load, shown, self.assumptions)
        if self.growth_rate > 0.0:
            rate = f"{self.growth_rate:.6g} 1/s{evidence.grows_in(self)}"
            lines.append(("growth", f"{rate}, tenfold in {self.time_to_grow(10.0):.4g} s"))
        lines += evidence.named_lines(self)
        if margins is not None:
            lines += margin_lines(margins, self.status, shown)
            if not evidence.has_exact_margins:
                lines.append(("", "found by sampling: two changes close together may be missed"))
            if (damping := self.damping_to_stabilise) > 0.0:
                none = "no damping suffices: the mean force alone buckles a mode"
                lines.append(("damping", none if math.isinf(damping) else evidence.enough.format(f"{damping:.6g} 1/s")))
        lines += [("checked", self.cutoff), ("method", evidence.method(self))]
        lines += [("note", self.note)] if self.note else []
        headline = ": ".join(filter(None, [self.status.upper(), evidence.headline(self)]))
        return Report(headline, lines, evidence.table)

    def as_dict(self, margins: Mapping[Quantity, Margin] | None = None) -> dict[str, Any]:
        """Return the verdict as numbers for JSON, units in the keys; None for numbers that are infinite or not known.

        With ``margins``, which `margins` returns, these and the damping that stabilises.
        """
        rod, load, near = self.rod, self.load, {}
        if margins is not None:
            near = margins_as_dict(margins) | by_keys(self, "damping_to_stabilise_per_s")
        return {
            **by_keys(self, "status unstable_modes growth_rate_per_s decay_rate_per_s fastest_mode"),
            "time_to_grow_tenfold_s": plain(self.time_to_grow(10.0)),
            **near,
            **by_keys(
                self,
                "modes_checked growth_tolerance_per_s critical_force_N=rod.critical_force rod "
                "mass_per_length_kg_per_m=rod.mass_per_length weight_per_length_N_per_m=rod.weight_per_length "
                "flexural_rigidity_N_m2=rod.flexural_rigidity assumptions mean_N=load.mean amplitude_N=load.amplitude "
                "frequency_rad_per_s=load.frequency",
            ),
            **({} if load.is_uniform else {"axial_response": rod.axial_response(load).as_dict()}),
            **({} if rod.yield_strength is None else {"stress": rod.stress(load).as_dict()}),
            **self.evidence.numbers(self),
        }

    def __repr__(self) -> str:
        """Return the verdict as a sentence."""
        return f"<{self.evidence.sentence(self)}; {self.cutoff}>"


CoupledRodStability = RodStability
"""Another name of it, until version 0.2: verdicts on coupled modes had a class of their own."""
