"""Bands of energies: the energies of Bloch waves in a periodic potential over their phase, edges, gaps, states."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import EPS, Floats, shaped
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.result_report import Report, Reported, Table, number
from floquetrod.equations import Equation, Hill, HillSystem, Mathieu, MathieuAQ, Meissner, matrices
from floquetrod.equations.base import Piece
from floquetrod.equations.hill import JumpingHill
from floquetrod.floquet.bloch_elements import BlochElements, all_waves, grid_of, potential_range, require_rows
from floquetrod.floquet.problems import Problem
from floquetrod.floquet.proof import certify
from floquetrod.systems.batch_verdicts import multipliers

_DEGREES = (12, 14, 16)  # of the elements, in turn (a choice)
_FINEST = 8  # times as many elements as planned, at most (a choice)
_ROUNDING = 16.0 * EPS  # of energies, beside the highest above the lowest potential (measured: 4 EPS)
_PHASES = 65  # from 0 to pi, where none are given (a choice)
_EXACT = 1e-7  # rad, to which phases of extrema of bands are found: energies to its square, where bands cross to it
_ON_CIRCLE = 1e-7  # of multipliers: they count as on the unit circle (a choice)
_LISTED = 40  # bands in a report


class EdgeProof(NamedTuple):
    """What was proved of an edge of a band.

    Attributes
    ----------
    energy : float
        The edge as computed.
    within : float
        Half of the width of the interval about it that is tried.
    proved : bool
        Whether solutions grow on the side of the gap, and are bounded on the side of the band, of that interval.
    """

    energy: float
    within: float
    proved: bool


@dataclass(frozen=True, eq=False, repr=False)
class EnergyBands(Reported, NoTruthValue, ByContent):
    """Energies of Bloch waves over their phase.

    Attributes
    ----------
    potential : Equation or HillSystem
        The equation at the energy 0.
    below : float
        Energies are below this.
    phase : float or ndarray (m,)
        Phases of y over a period, in rad.
    energies : ndarray (k,) or (m, k)
        Energies of each phase, ascending; NaN where the k-th is not below ``below``.
    errors : ndarray (k,)
        Estimate of the error of each band's energies: twice their change to elements of a higher degree, and rounding.
    velocities : ndarray (k,) or (m, k)
        Derivatives of the energies by the phase.
    """

    ask = ".energies, .edges or .gaps"

    potential: Any
    below: float
    phase: Any
    energies: Floats
    errors: Floats
    velocities: Floats
    _waves: _Waves = field(compare=False)

    @cached_property
    def edges(self) -> Floats:
        """Lowest and highest energy (b, 2) of each band that begins below ``below``; the last may end above it.

        Of one equation they are at the phases 0 and pi.  Of a system they are also searched for between, from samples
        pi / 64 apart; bands of a system may overlap.
        """
        return self._edges[0]

    @property
    def edge_errors(self) -> Floats:
        """Estimates of their errors, (b, 2)."""
        return self._edges[1]

    @cached_property
    def _edges(self) -> tuple[Floats, Floats]:
        return self._waves.edges(self.below)

    @property
    def gaps(self) -> Floats:
        """Intervals (g, 2) between bands without energies, wider than their errors, that begin below ``below``."""
        gaps, top = [], -math.inf
        error = 0.0
        for (low, high), (of_low, of_high) in zip(self.edges.tolist(), self.edge_errors.tolist(), strict=True):
            if top > -math.inf and low - of_low > top + error:
                gaps.append((top, low))
            if high > top:
                top, error = high, of_high
        return np.array(gaps).reshape(-1, 2)

    def density(self, energy: Any) -> Any:
        """Return the density of states, per unit of energy and of time, at energies (array_like).

        1 / (pi T abs(dE / dphase)), added up over the Bloch waves of that energy with phases between 0 and pi: 0 in
        gaps, and infinite towards edges.  Over a band it adds up to 1 / T.

        Parameters
        ----------
        energy : float or array_like
            In the unit of the potential.

        Returns
        -------
        float or ndarray of float
            In the shape of ``energy``.

        Raises
        ------
        TypeError, ValueError
            For energies other than finite numbers.
        """
        energies = validate.array("energy", energy)
        return shaped(self._waves.density(energies.ravel()).reshape(energies.shape), energies.shape)

    def at(self, energy: float) -> Any:
        """Return the equation that the wave function obeys at an energy, for `fr.stability` and others.

        An equation has p - energy in place of p, a system K + energy M in place of K, rounded to doubles.

        Parameters
        ----------
        energy : float
            In the unit of the potential.

        Returns
        -------
        Equation or HillSystem
            Of the kind of the potential.

        Raises
        ------
        TypeError, ValueError
            For an energy that is no finite number.

        Examples
        --------
        >>> import floquetrod as fr
        >>> fr.bands(fr.Hill(0.0, cosines=(1.0,)), below=5.0).at(0.3)
        Hill(mean=-0.3, cosines=(1.0,), sines=(), period=6.283185307179586, damping=0.0)
        """
        return equation_at(self.potential, validate.finite("energy", energy))

    def certify(self, within: float | None = None) -> tuple[EdgeProof, ...]:
        """Prove the edges of the bands of one equation, each to lie within its error, or ``within``.

        `fr.certify` of the equation on both sides: on one a solution grows, on the other all are bounded, so that there
        is an edge between.  An edge of a gap narrower than that is not proved.

        Parameters
        ----------
        within : float, optional
            Half of the width of the interval about each edge.

        Returns
        -------
        tuple of EdgeProof
            From the lowest edge on.

        Raises
        ------
        TypeError
            For a system, whose solutions may grow inside a band.

        Examples
        --------
        >>> import floquetrod as fr
        >>> [edge.proved for edge in fr.bands(fr.Hill(0.0, cosines=(1.0,)), below=0.5).certify()]
        [True, True]
        """
        if self._waves.order > 1:
            raise TypeError(
                "bands must be of one equation to be proved, got a system: its solutions may grow in a band"
            )
        if within is not None:
            within = validate.positive("within", within)
        return tuple(
            self._waves.proved(energy, error if within is None else within, band_above=side == 0)
            for pair, errors in zip(self.edges.tolist(), self.edge_errors.tolist(), strict=True)
            for side, (energy, error) in enumerate(zip(pair, errors, strict=True))
        )

    def plot(self, ax: Any = None) -> Any:
        """Draw the energies over the phase, gaps shaded; on new axes with the density of states beside.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw the bands; a new figure by default.

        Returns
        -------
        matplotlib.axes.Axes
            Axes of the bands; new ones have the density of states as ``axes.figure.axes[1]``.

        Examples
        --------
        >>> import floquetrod as fr
        >>> fr.bands(fr.Hill(0.0, cosines=(1.0,)), below=3.0).plot().get_ylabel()
        'energy $E$'
        """
        from floquetrod.plotting.bands_plot import draw_bands

        return draw_bands(self, ax)

    def report(self) -> Report:
        """Return the edges of the bands, and the gaps above them."""
        rows = []
        edges, errors = self.edges, self.edge_errors
        for i, ((low, high), error) in enumerate(
            zip(edges[:_LISTED].tolist(), errors.max(axis=1).tolist(), strict=False)
        ):
            above = [gap for gap in self.gaps.tolist() if gap[0] == high]
            width = f"{above[0][1] - above[0][0]:.6g}" if above else ""
            rows.append((str(i), f"{low:.12g}", f"{high:.12g}", width, f"{error:.0e}"))
        head = ("band", "from", "to", "gap above", "error")
        rest = f"{len(edges) - _LISTED} more" if len(edges) > _LISTED else ""
        return Report(repr(self).strip("<>"), (), Table([(title, ">") for title in head], rows, rest))

    def as_dict(self) -> dict[str, Any]:
        """Return phases, energies and edges for JSON; None where an energy is not below ``below``."""
        energies = [[number(energy) for energy in row] for row in np.atleast_2d(self.energies).tolist()]
        return {
            "below": self.below,
            "phase_rad": np.atleast_1d(self.phase).tolist(),
            "energies": energies,
            "errors": self.errors.tolist(),
            "edges": self.edges.tolist(),
            "edge_errors": self.edge_errors.tolist(),
            "gaps": self.gaps.tolist(),
        }

    def __repr__(self) -> str:
        """Return the number of bands and of gaps."""
        count, gaps = len(self.edges), len(self.gaps)
        bands = f"{count} band{'' if count == 1 else 's'}"
        return (
            f"<{bands} below {self.below:g}, {gaps} gap{'' if gaps == 1 else 's'}, of {type(self.potential).__name__}>"
        )


def bands(
    potential: Problem | Callable[[float], Any],
    phase: Any = None,
    *,
    below: float,
    period: float | None = None,
    jumps: Any = (),
) -> EnergyBands:
    """Return the energies E of waves -y'' + V(t) y = E y with y(t + T) = exp(i phase) y(t), in a V of period T.

    Parameters
    ----------
    potential : Equation, HillSystem or callable (t) -> float or array_like (n, n)
        V itself as a function, symmetric where it is a matrix.  Or the equation at E = 0, undamped: y'' = p y, such as
        `Hill`, `Mathieu`, `Meissner`, whose p is V; or M y'' + K y = 0, a `HillSystem` with K symmetric, whose -K is V:
        its energies are of -M y'' + V y = E M y.
    phase : float or array_like (m,), optional
        In rad; by default 65 phases from 0 to pi.  Those of -phase and of phase + 2 pi are the same.
    below : float
        Energies below this are returned, in the unit of V, the inverse square of the unit of t.
    period : float, optional
        Of a function, which needs it.
    jumps : sequence of float
        Of a function: instants at which it jumps, or has a kink, as `HillSystem.from_function` takes them.

    Returns
    -------
    EnergyBands

    Raises
    ------
    TypeError, ValueError
        For damped equations, whose waves have no real energies, and ones with gyroscopic matrices or a K that
        is not symmetric; and where ``below`` is so high that the waves would take matrices of more than 1,500 rows.

    Notes
    -----
    Ritz's method with polynomials of degree 12 to 16 on parts of the period that end at the jumps of V
    (page `theory/bands`).

    Examples
    --------
    >>> import floquetrod as fr
    >>> waves = bands(fr.Hill(0.0, cosines=(2.0, 0.0, -0.4), sines=(0.0, 0.6)), phase=0.0, below=5.0)
    >>> [f"{energy:.11f}" for energy in waves.energies]
    ['-1.11489123888', '0.58918146095', '1.75769008375', '4.02555336946', '4.28559211491']
    >>> bands(fr.Meissner(alpha=2.0, beta=0.0), below=4.0)
    <4 bands below 4, 3 gaps, of Meissner>
    """
    equation = _potential(potential, period, jumps)
    below = validate.finite("below", below)
    phases = np.linspace(0.0, math.pi, _PHASES) if phase is None else validate.array("phase", phase)
    if phases.ndim > 1:
        raise ValueError(f"phase must be a number or a sequence of numbers, got shape {phases.shape}")
    waves = _Waves(equation, below)
    folded = _folded(phases.ravel())
    energies, velocities = waves.of(folded, waves.most_below(below))
    signs = np.where(np.remainder(phases.ravel(), 2.0 * math.pi) > math.pi, -1.0, 1.0)
    velocities = velocities * signs[:, None]
    with np.errstate(invalid="ignore"):
        above = ~(energies < below)
    count = int((~above).any(axis=0).sum())
    energies[above], velocities[above] = np.nan, np.nan
    shape = (*phases.shape, count)
    errors = waves.errors(np.nanmax(energies[:, :count], axis=0) if count else np.zeros(0))
    return EnergyBands(
        equation,
        below,
        phases if phases.ndim else float(phases),
        energies[:, :count].reshape(shape),
        errors,
        velocities[:, :count].reshape(shape),
        waves,
    )


def _potential(potential: Any, period: Any, jumps: Any) -> Any:
    """Return the equation at the energy 0, checked."""
    if isinstance(potential, Equation | HillSystem):
        if period is not None or jumps != ():
            raise TypeError("period and jumps are those of a function; leave them out, the potential has its own")
    elif callable(potential) and not isinstance(potential, type):
        if period is None:
            raise TypeError("period must be given where potential is a function")
        return _sampled(potential, period, jumps)
    else:
        raise validate.wrong_type(
            "potential",
            "must be an Equation such as Hill, a HillSystem, or a function of time with its period, got "
            f"{validate.short(potential)}",
        )
    if isinstance(potential, Equation):
        if potential.damping:
            raise ValueError(f"potential must be undamped, got {validate.short(potential)}; leave its damping out")
        return potential
    matrices.require_one(potential, "potential")
    if potential.damping is not None or potential.gyroscopic is not None or not potential.is_symmetric:
        raise ValueError(
            "potential must be a HillSystem with symmetric stiffness and neither damping nor gyroscopic matrix, whose "
            f"energies are real, got {validate.short(potential)}"
        )
    return potential


def _sampled(function: Callable[[float], Any], period: Any, jumps: Any) -> Any:
    """Return the system of a potential that a function computes, which states how well it is known."""
    period = validate.positive("period", period)
    first = function(0.31 * period)  # not at 0, which may be a jump
    negative: Callable[[float], Any] = (
        (lambda t: [[-function(t)]]) if np.ndim(first) == 0 else lambda t: -np.asarray(function(t))
    )
    return HillSystem.from_function(negative, period, jumps)


def _folded(phases: Floats) -> Floats:
    """Return phases between 0 and pi that have the same energies."""
    turned = np.remainder(phases, 2.0 * math.pi)
    return np.asarray(np.where(turned > math.pi, 2.0 * math.pi - turned, turned))


class _Waves:
    """The waves of one potential, in elements fine enough for energies up to ``below`` and a band above."""

    def __init__(self, potential: Any, below: float) -> None:
        system = potential.as_system() if isinstance(potential, Equation) else potential
        self.system, self.period, self.order = system, float(system.period), system.order
        self.potential = potential
        mass = matrices.mass_matrix(system)
        self.lightest = float(np.linalg.eigvalsh(mass)[0])
        self.lowest = potential_range(system)[0]
        self.elements, self.change = self._converged(below)
        # Coefficients known to an error move energies by no more than its norm, beside M.
        self.doubt = system.order * system.coefficient_error / self.lightest

    def most_below(self, energy: float) -> int:
        """Return a bound of the number of energies of a phase below one: of free waves in the lowest potential."""
        rate = math.sqrt(max(energy - self.lowest, 0.0))
        return self.order * (math.floor(self.period * rate / math.pi) + 2)

    def _converged(self, below: float) -> tuple[BlochElements, Floats]:
        """Return elements in which more functions change nothing, and twice the change of each band to fewer."""
        count = self.most_below(below) + 2 * self.order
        phases = np.array([0.0, 0.5 * math.pi, math.pi])
        finer, best = 1, None
        while best is None or finer <= _FINEST:
            grid, before = grid_of(self.system, below, finer), None
            for degree in _DEGREES:
                require_rows(grid, degree, self.order)
                elements = BlochElements.of(self.system, grid, degree)
                energies, _ = all_waves(elements, phases, count)
                if before is not None:
                    change = 2.0 * np.nan_to_num(np.abs(energies - before), nan=math.inf).max(axis=0)
                    wanted = energies.min(axis=0) < below
                    worst = float(change[wanted].max(initial=0.0))
                    if best is None or worst < best[0]:
                        best = worst, elements, change
                    if worst <= 2.0 * _ROUNDING * (float(energies[:, wanted].max(initial=below)) - elements.lowest):
                        return best[1:]
                before = energies
            finer *= 2
        return best[1:]

    def of(self, phases: Floats, count: int) -> tuple[Floats, Floats]:
        """Return energies and their derivatives, (m, count), of phases between 0 and pi."""
        return all_waves(self.elements, phases, count)

    def errors(self, energies: Floats) -> Floats:
        """Return the errors of the energies of bands 0, 1, ..."""
        scale = np.abs(energies) + energies.max(initial=self.elements.lowest) - self.elements.lowest
        return np.asarray(self.change[: len(energies)] + _ROUNDING * scale + self.doubt)

    def edges(self, below: float) -> tuple[Floats, Floats]:
        """Return the edges (b, 2) of the bands that begin below an energy, and their errors."""
        count = self.most_below(below) + self.order
        ends = np.array([0.0, math.pi]) if self.order == 1 else np.linspace(0.0, math.pi, _PHASES)
        energies, velocities = self.of(ends, count)
        edges = np.stack([energies.min(axis=0), energies.max(axis=0)], axis=1)
        places = np.zeros(edges.shape)
        if self.order > 1:
            for n in range(count):
                for side, extremum in enumerate((np.argmin, np.argmax)):
                    i = int(extremum(energies[:, n]))
                    edges[n, side], places[n, side] = self._extremum(n, ends, energies[:, n], velocities[:, n], i)
        kept = edges[:, 0] < below
        edges, places = edges[kept], places[kept]
        return edges, np.stack([self.errors(column) for column in edges.T], axis=1) + places

    def _extremum(self, n: int, ends: Floats, energies: Floats, velocities: Floats, i: int) -> tuple[float, float]:
        """Return the extremum of a system's band next to a sample, and what the error of its phase makes of it."""
        from scipy.optimize import brentq

        if i in (0, len(ends) - 1):
            return float(energies[i]), 0.0
        j = i + 1 if velocities[i] * velocities[i + 1] < 0.0 else i - 1
        if not velocities[i] * velocities[j] < 0.0:
            return float(energies[i]), 0.0
        low, high = sorted((float(ends[i]), float(ends[j])))

        def slope(phase: float) -> float:
            return float(self.elements.waves(phase, n + 1).velocities[n])

        found = self.elements.waves(brentq(slope, low, high, xtol=_EXACT), n + 1)
        at_it = float(found.energies[n])
        best = min(at_it, energies[i]) if energies[i] <= min(energies) else max(at_it, energies[i])
        return float(best), 2.0 * _EXACT * abs(float(found.velocities[n]))

    def density(self, energies: Floats) -> Floats:
        """Return the density of states at energies (e,)."""
        mass = matrices.mass_matrix(self.system)
        if not energies.size:
            return np.zeros(0)
        shifts = energies[:, None, None] * mass
        if self.system.pieces:
            pieces = [
                (duration, value.mapped(lambda start: start + shifts, np.asarray))
                for duration, value in self.system.pieces
            ]
            batch = HillSystem.from_pieces(pieces, mass=self.system.mass)
        else:
            batch = replace(self.system, stiffness=self.system.stiffness + shifts, coefficient_error=0.0)
        density = np.zeros(len(energies))
        for i, values in enumerate(multipliers(batch)):
            on_circle = (np.abs(np.abs(values) - 1.0) < _ON_CIRCLE) & (values.imag > 0.0)
            for phase in np.angle(values[on_circle]).tolist():
                waves = self.elements.waves(phase, self.most_below(float(energies[i])) + self.order)
                n = int(np.abs(waves.energies - energies[i]).argmin())
                density[i] += 1.0 / (math.pi * self.period * abs(float(waves.velocities[n])))
        return density

    def proved(self, energy: float, within: float, *, band_above: bool) -> EdgeProof:
        """Return whether an edge is proved to lie within a distance of an energy."""
        # Coefficients at an energy are rounded by an ulp of the largest at most: less than that must do.
        inner = within - 4.0 * EPS * (max(map(abs, potential_range(self.system))) + abs(energy))
        if not inner > 0.0:
            return EdgeProof(energy, within, proved=False)
        wanted = ("unstable", "stable") if band_above else ("stable", "unstable")
        sides = (energy - inner, energy + inner)
        proved = all(
            certify(equation_at(self.potential, side)).status == status
            for side, status in zip(sides, wanted, strict=True)
        )
        return EdgeProof(energy, within, proved)


def equation_at(potential: Any, energy: float) -> Any:
    """Return the equation of a potential at an energy."""
    if isinstance(potential, HillSystem):
        shift = energy * matrices.mass_matrix(potential)
        if not potential.pieces:
            return replace(potential, stiffness=potential.stiffness + shift)
        pieces = [
            (duration, value.mapped(lambda start: start + shift, np.asarray)) for duration, value in potential.pieces
        ]
        return HillSystem.from_pieces(pieces, mass=potential.mass, coefficient_error=potential.coefficient_error)
    if isinstance(potential, Mathieu | Meissner):
        return replace(potential, beta=potential.beta - energy)
    if isinstance(potential, MathieuAQ):
        return replace(potential, a=potential.a + energy)
    if isinstance(potential, Hill):
        return replace(potential, mean=potential.mean - energy)
    if potential.period_over_pi is not None:
        return equation_at(potential.as_system(), energy)
    parts = tuple(
        Piece(p.share, harmonics=p.harmonics, slope=p.slope, start=Fraction(p.start) - Fraction(energy))
        for p in potential.pieces()
    )
    return JumpingHill(parts, potential.period)
