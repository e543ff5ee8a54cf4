"""A periodic orbit and its verdict."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import Complexes, Floats, shaped
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent, NoTruthValue
from floquetrod._util.result_report import Printed, Report
from floquetrod.equations import NonlinearSystem, PeriodicSystem, sampling
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.references import ORBITS, references
from floquetrod.floquet.status import Status
from floquetrod.orbits.collocation import Collocation, Point
from floquetrod.orbits.orbit_extent import Extremes, extremes
from floquetrod.orbits.orbit_mesh import evaluated
from floquetrod.orbits.orbit_multipliers import OrbitSpectrum, Segments, spectrum

_LATEST = 1e6  # periods (a choice: beyond it rounding of the phase costs more than ten digits)
_SAMPLES = 4096  # of a period, for harmonics
_NEGLIGIBLE = 1e-13  # part of the largest harmonic


@dataclass(frozen=True, eq=False, repr=False)
class PeriodicOrbit(ByContent, Printed, NoTruthValue):
    """A periodic solution of a nonlinear system, with the multipliers of the system linearised about it.

    A call, ``orbit(time)``, evaluates it anywhere.

    Attributes
    ----------
    system : NonlinearSystem
        With the values of its parameters.
    period : float
        In the unit of the system's time.
    period_error : float
        Estimate of the error of the period, in the same unit; 0 where it is given by the forcing.
    times : ndarray (N + 1,)
        Instants of the mesh, from 0 to the period.
    states : ndarray (N + 1, n)
        There; the last is the first, plus the growth of a motion that rotates.  Extremes lie between them: ``least``
        and ``largest``.
    error : float
        Estimate of the largest error of a state at any instant, as a fraction of the largest magnitude of its component
        over the period: twice the difference from the orbit with two points less in each interval of the mesh, and the
        effect of rounding on the equations.  Where the mesh resolves the orbit it is far more than the true error.
    steps : int
        Steps of Newton's method on all meshes.
    """

    ask = ".stability.stable (True, False, or None when undecided)"

    system: NonlinearSystem
    period: float
    period_error: float
    times: Floats
    states: Floats
    error: float
    steps: int = field(compare=False)
    collocation: Collocation = field(compare=False)
    point: Point = field(compare=False)
    segments: Segments = field(compare=False)

    def __call__(self, time: Any) -> Any:
        """Return the states at times (array_like), in the unit of the system's time: shape (*time.shape, n)."""
        times = validate.array("time", time, least=-_LATEST * self.period, largest=_LATEST * self.period)
        shares = times / self.period
        states = evaluated(self.collocation, self.point, (shares - np.floor(shares)).ravel())
        if self.collocation.winding:
            states = states + np.floor(shares).reshape(-1, 1) * np.array(self.collocation.winding)
        return shaped(states, (*times.shape, states.shape[1]))

    @property
    def least(self) -> Floats:
        """Least value of each state over the period (n,), between instants of the mesh, too."""
        return self.extremes.least

    @property
    def largest(self) -> Floats:
        """Largest value of each state over the period (n,), likewise."""
        return self.extremes.largest

    @cached_property
    def extremes(self) -> Extremes:
        """Extremes of the states, as accurate as the states, and where they are."""
        return extremes(self.collocation, self.point)

    @cached_property
    def linearised(self) -> PeriodicSystem:
        """The system x' = A(t) x of small deviations, A(t) the derivatives of f along the orbit, as a Fourier series.

        Its ``coefficient_error`` includes the errors of the orbit and of the truncated series.
        """
        series = sampling.smooth(self._derivatives, self.period, math.inf)
        return PeriodicSystem.from_pieces(series.pieces, coefficient_error=series.error + self._derivatives_error)

    def _derivatives(self, times: Floats) -> Floats:
        """Return the derivatives of f along the orbit (k, n, n)."""
        phase = times - np.floor(times / self.period) * self.period
        return self.system.jacobians(phase, self(phase))

    @property
    def _derivatives_error(self) -> float:
        """Estimate of the error of the derivatives along the orbit."""
        states, scale = self.states[:-1], self.point.scale
        signs = np.where(np.arange(states.size).reshape(states.shape) % 3 == 0, -1.0, 1.0)
        step = 1e-6 * scale * signs
        exact, moved = (self.system.jacobians(self.times[:-1], states + shift) for shift in (0.0, step))
        change = float(np.abs(moved - exact).max()) * self.error / 1e-6
        return 2.0 * change + self.system.evaluated.derivatives_error * float(np.abs(exact).max())

    @cached_property
    def spectrum(self) -> OrbitSpectrum:
        """Logarithms of the multipliers, and the verdict that follows from them alone."""
        return spectrum(self.segments, lambda: self.linearised.structure == "hamiltonian")

    @cached_property
    def stability(self) -> SystemStability:
        """The verdict of `floquetrod.stability` on the linearised system, from maps over the mesh.

        For an autonomous system, without the multiplier 1 of a shift along the orbit; "stable" then refers to the
        orbit, not to the phase on it.  The errors of the multipliers include the effect of the orbit's.
        """
        return self.spectrum.verdict(self.linearised)

    @property
    def status(self) -> Status:
        """The verdict in ``stability``."""
        return self.spectrum.status or self.stability.status

    @property
    def multipliers(self) -> tuple[complex, ...]:
        """Multipliers of the orbit from ``stability``, the largest first."""
        return self.stability.multipliers

    @property
    def trivial_multiplier_less_1(self) -> float | None:
        """Distance from 1 of the computed multiplier of a shift along the orbit; None for a forced system."""
        return self.spectrum.trivial

    @cached_property
    def harmonics(self) -> Complexes:
        """Amplitudes Z, complex (H + 1, n), of x(t) = Re sum_k Z_k exp(i k w t), w = 2 pi / period; Z_0 is the mean.

        Of a motion that rotates, of what it has beside its steady growth.  As many as exceed rounding, 2,047 at most;
        each is as accurate as the states.
        """
        shares = np.arange(_SAMPLES) / _SAMPLES
        values = self(shares * self.period)
        if self.collocation.winding:
            values = values - shares[:, None] * np.array(self.collocation.winding)
        series = np.fft.rfft(values, axis=0)[: _SAMPLES // 2] / _SAMPLES
        series[1:] *= 2.0
        sizes = (np.abs(series) / self.point.scale).max(axis=1)
        kept = int(np.flatnonzero(sizes > _NEGLIGIBLE * sizes.max()).max(initial=0))
        return series[: kept + 1]

    @property
    def frequency(self) -> float:
        """Angular frequency, 2 pi / period."""
        return 2.0 * math.pi / self.period

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite, in plain text with DOI, floquetrod first, then the sources of the methods used."""
        return references(ORBITS)

    def plot(self, ax: Any = None) -> Any:
        """Draw the states over a period: solid where the orbit is stable, dashed where not, dotted where undecided.

        Parameters
        ----------
        ax : matplotlib Axes, optional
            Axes to draw into; a new figure by default.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn into.
        """
        from floquetrod.plotting.orbit_plot import draw_orbit

        return draw_orbit(self, ax)

    def report(self) -> Report:
        """Return the orbit in lines, and the verdict with its table of multipliers.

        Returns
        -------
        Report
            Its text is ``str(report)``; a notebook shows it as a table.
        """
        verdict = self.stability.report()
        n, kind = self.states.shape[1], "autonomous" if self.system.is_autonomous else "forced"
        period = f"{self.period:.12g}" + (f" +- {self.period_error:.1g}" if self.period_error else "")
        listed = [f"{low:.6g} to {high:.6g}" for low, high in zip(self.least, self.largest, strict=True)]
        lines = [
            ("orbit", f"of {n} equations, {kind}, period {period} (angular frequency {self.frequency:.6g})"),
            ("states", "; ".join(listed[:6]) + ("; ..." if n > 6 else "")),
            ("error", f"{self.error:.1g} of the states, from two degrees on {len(self.times) - 1} intervals"),
        ]
        named = [f"{name} = {value:.6g}" for name, value in self.system.parameters.items()]
        lines += [("with", ", ".join(named))] if named else []
        kept = [line for line in verdict.lines if line[0] != "system"]
        return Report(verdict.headline, [*lines, *kept], verdict.table)

    _keys = (
        "status period period_error error parameters=system.parameters trivial_multiplier_less_1 times states stability"
    )

    def __repr__(self) -> str:
        """Return the orbit as a sentence."""
        kind = "autonomous" if self.system.is_autonomous else "forced"
        return (
            f"<{self.status} periodic orbit of {self.states.shape[1]} equations, {kind}, period {self.period:.10g}, "
            f"states +- {self.error:.1g} relative>"
        )
