"""The verdict on a rod whose modes are coupled: how many are enough, which resonate, and the shape that grows."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.roots import bisected
from floquetrod.equations import HillSystem
from floquetrod.floquet.dispatch import stability
from floquetrod.floquet.systems.result import Resonance, SystemStability
from floquetrod.floquet.verdict import Status
from floquetrod.rod.assumptions import assumptions
from floquetrod.rod.coupled import MOST_COUPLED, CoupledModes
from floquetrod.rod.data import RodData
from floquetrod.rod.load import Load, Loads, Quantity
from floquetrod.rod.sampled import first_change
from floquetrod.rod.verdict import RodVerdict

_ENLARGEMENTS = 3  # times that more modes are taken while two numbers of them disagree (a choice)
_SHAPE_POINTS, _SHAPE_INSTANTS = 401, 48  # along the rod and in a period


class Shape(NamedTuple):
    """The fastest growing solution along the rod, freed of its growth; its largest deflection is 1.

    Attributes
    ----------
    s : ndarray
        Position in m from the upper end.
    deflection : ndarray
        At the instant of largest deflection.
    envelope : ndarray
        Largest deflection over a period, at each position.
    """

    s: NDArray[np.float64]
    deflection: NDArray[np.float64]
    envelope: NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class CoupledRodStability(RodVerdict):
    """Verdict on a rod whose modes are coupled, in 1/s and s.

    Modes are numbered as those of the rod without axial force, which have the same ends.

    Attributes
    ----------
    rod : Rod
    coupled : CoupledModes
        The functions along the rod in which its motion is written, and its kind of load.
    whole : SystemStability
        Verdict on the system of equations.
    convergence : tuple of (int, float)
        Numbers of modes and the growth rate in 1/s with each; the last one is the answer.
    resonances : tuple of Resonance
        What grows, the fastest first: "direct resonance of mode 7, order 1", or a combination of two modes; named by a
        heuristic, see `SystemStability`.
    growth_tolerance : float
        Growth in 1/s up to which a mode counts as stable.
    status, growth_rate, exponents, multipliers, period, error, cost, note, assumptions
        As in every `Verdict`.  ``error`` is that of the growth rate in 1/s: that of the multipliers and an estimate of
        what the modes left out would change.
    """

    coupled: CoupledModes
    whole: SystemStability
    convergence: tuple[tuple[int, float], ...]
    resonances: tuple[Resonance, ...]

    @property
    def load(self) -> Load:
        """The load."""
        return self.coupled.like

    @property
    def system(self) -> HillSystem:
        """The equations, in seconds."""
        return self.coupled.system(Loads.single(self.load))

    @property
    def modes(self) -> tuple[int, ...]:
        """Modes looked at."""
        return tuple(range(1, self.coupled.count + 1))

    @property
    def modes_checked(self) -> int:
        """Number of modes looked at; `cutoff` says why that many."""
        return self.coupled.count

    @property
    def cutoff(self) -> str:
        """Why these modes and no others."""
        if len(self.convergence) == 1:
            return f"{self.modes_checked} coupled modes, as asked for"
        (fewer, first), (last, final) = self.convergence[-2:]
        change = abs(final - first)
        known = f"growth differs by {change:.1g} 1/s" if math.isfinite(change) else "growth could not be compared"
        return f"{last} coupled modes; with {fewer} {known}"

    @property
    def unstable_modes(self) -> tuple[int, ...]:
        """Modes that take part in what grows faster than the tolerance."""
        if self.status != "unstable":
            return ()
        growing = [r for r in self.resonances if r.growth_rate > self.growth_tolerance]
        return tuple(sorted({mode for resonance in growing for mode in resonance.modes}))

    @property
    def fastest_mode(self) -> int | None:
        """Mode that grows fastest, the lower one of a combination; None when none grows or none could be named."""
        return min(self.resonances[0].modes) if self.resonances and self.growth_rate > 0.0 else None

    @cached_property
    def damping_to_stabilise(self) -> float:
        """Damping rate in 1/s at which this load no longer makes the rod grow faster than the tolerance.

        The rate meant is the rod's whole ``damping_rate``, whatever it is now.  Found by bisection, and tried at two,
        four and eight times as much.  Infinite when the mean force alone buckles the rod: damping only slows that down.
        """
        if float(np.linalg.eigvalsh(self.system.stiffness)[0]) <= 0.0:
            return math.inf
        loads = Loads.single(self.load)

        def grows(rate: float) -> bool:
            constants = self.coupled.numbers.constants._replace(damping_rate=rate)
            modes = replace(self.coupled, numbers=self.coupled.numbers._replace(constants=constants))
            if modes.verdicts(loads, self.growth_tolerance, quick=True)[0] == 1:
                return False
            return (
                not modes.growth(loads, None)[0] <= self.growth_tolerance
            )  # next to a boundary, where quick is unsure

        least = max(self.growth_rate, 1e-6 * self.load.frequency)
        tried = least * 2.0 ** np.arange(-1, 4)
        growing = [rate for rate in (0.0, *tried.tolist()) if grows(rate)]
        if not growing:
            return 0.0
        low = growing[-1]
        high = 2.0 * low if low else float(tried[0])
        while grows(high):
            low, high = high, 2.0 * high
        holds = np.vectorize(grows, otypes=[np.bool_])
        return float(bisected(holds, np.array([low]), np.array([high]), 60, relative=1e-10)[1][0])

    @cached_property
    def shape(self) -> Shape:
        """Where along the rod the fastest solution moves most, growing or not."""
        from scipy.integrate import solve_ivp

        first = self.system.as_periodic_system()
        n, period = self.coupled.size, self.period

        def slope(t: float, y: NDArray[Any]) -> Any:
            block = y.reshape(2 * n, -1)
            return (first.coefficient(t) @ block).ravel()

        whole = solve_ivp(slope, (0.0, period), np.eye(2 * n).ravel(), method="DOP853", rtol=1e-8, atol=1e-10)
        values, vectors = np.linalg.eig(whole.y[:, -1].reshape(2 * n, 2 * n))
        fastest = int(np.abs(values).argmax())
        exponent = complex(np.log(values[fastest])) / period
        times = np.linspace(0.0, period, _SHAPE_INSTANTS + 1)
        start = vectors[:, fastest].astype(complex)
        path = solve_ivp(slope, (0.0, period), start, method="DOP853", t_eval=times, rtol=1e-8, atol=1e-10).y[:n]
        path = path * np.exp(-exponent.real * times)
        x = np.linspace(0.0, 1.0, _SHAPE_POINTS)
        moving = self.coupled.basis.shapes(x).T @ path  # complex: its real part at any phase is a solution
        envelope = np.abs(moving).max(axis=1)
        size = float(envelope.max())
        at, instant = np.unravel_index(np.abs(moving).argmax(), moving.shape)
        turned = moving[:, instant] * np.exp(-1j * np.angle(moving[at, instant]))
        return Shape(x * self.rod.length, turned.real / size, envelope / size)

    def plot(self, ax: Any = None) -> Any:
        """Draw the `shape` along the rod; return the axes."""
        from floquetrod.plotting.rod import draw_shape

        return draw_shape(self, ax)

    def _edge(self, varied: Quantity, piece: tuple[float, float]) -> float | None:
        return first_change(varied, self.coupled, self.load, piece, self.margin_tolerance)

    def _sentence(self) -> str:
        if self.status != "unstable" or not self.resonances:
            slow = f": growth {self.growth_rate:.6g} 1/s" if self.growth_rate > 0.0 else ""
            return f"{self.status}{slow}"
        growth = f"{self.growth_rate:.6g} 1/s, tenfold in {self.time_to_grow():.3g} s"
        return f"unstable: {self.resonances[0]}; {growth}"


def classify_coupled(rod: RodData, load: Load, count: int | None, growth_tolerance: float) -> CoupledRodStability:
    """Classify a rod with as many modes as two numbers of them agree upon, or with ``count`` of them."""
    if count is None:
        last = rod.coupled_numbers.modes_needed(Loads.single(load), load, growth_tolerance)
        counts = [last - max(2, last // 8), last]
    else:
        counts = [count]
    found = [_classified(rod, load, n) for n in counts]
    while count is None and _differ(found[-2][1], found[-1][1], growth_tolerance):
        larger = math.ceil(1.25 * found[-1][0].count)
        if len(found) == 2 + _ENLARGEMENTS or larger > MOST_COUPLED:
            break
        found.append(_classified(rod, load, larger))
    modes, whole = found[-1]
    error = whole.error / whole.period
    if len(found) > 1:
        error += abs(whole.growth_rate - found[-2][1].growth_rate)
    status, note = _status(whole, error, growth_tolerance), whole.note
    if len(found) > 1 and _differ(found[-2][1], whole, growth_tolerance):
        status, note = (
            "undecided",
            f"{found[-2][0].count} modes say {found[-2][1].status}, {modes.count} {whole.status}",
        )
    return CoupledRodStability(
        rod=rod,
        coupled=modes,
        whole=whole,
        convergence=tuple((m.count, w.growth_rate) for m, w in found),
        resonances=modes.named(modes.system(Loads.single(load)), whole.resonances),
        growth_tolerance=growth_tolerance,
        status=status,
        growth_rate=whole.growth_rate,
        exponents=whole.exponents,
        period=whole.period,
        error=error,
        cost=whole.cost,
        note=note,
        assumptions=assumptions(rod, load),
    )


def _classified(rod: RodData, load: Load, count: int) -> tuple[CoupledModes, SystemStability]:
    modes = CoupledModes(rod.coupled_numbers, load, count)
    return modes, stability(modes.system(Loads.single(load)))


def _status(whole: SystemStability, error: float, tolerance: float) -> Status:
    """Return the verdict with a tolerance: undecided where the error of the growth rate covers it."""
    if tolerance == 0.0 or whole.status == "stable":
        return whole.status
    if whole.growth_rate - error > tolerance and whole.status == "unstable":
        return "unstable"
    return "stable" if whole.growth_rate + error <= tolerance else "undecided"


def _differ(one: SystemStability, other: SystemStability, tolerance: float) -> bool:
    """Return whether two numbers of modes lead to different verdicts."""
    if tolerance > 0.0:
        return (one.growth_rate > tolerance) != (other.growth_rate > tolerance)
    return one.status != other.status
