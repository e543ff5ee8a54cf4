"""The evidence of a verdict on a rod: one record for each kind of modes, and the facts that follow from it.

`floquetrod.rod.modes` fills the records, `floquetrod.rod.answers.rod_stability` puts them into words.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arrays import Floats
from floquetrod._util.caching import cached_property
from floquetrod.equations import HillSystem, Mathieu, TwoFrequencies
from floquetrod.floquet.multipliers.resonance_names import Resonance
from floquetrod.floquet.multipliers.system_stability import SystemStability
from floquetrod.floquet.quasiperiodic import QuasiperiodicGrowth
from floquetrod.floquet.references import NOISE, THEORY, references, united
from floquetrod.floquet.verdict import Stability, Status, tolerated
from floquetrod.rod.mode_equations.modal_systems import ModalSystem

if TYPE_CHECKING:
    from floquetrod.rod.mode_equations.coupled_systems import CoupledEquations

_SHAPE_POINTS, _SHAPE_INSTANTS = 12, 48  # for each mode, and in a period
_SECONDS_PER_MODE, _FEW_PERIODS = 5e-4, 5.0  # of two frequencies, as measured


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

    @property
    def position(self) -> float:
        """Where the motion is largest, in m from the upper end."""
        return float(self.s[self.envelope.argmax()])


class _ModeByMode:
    """Modes with an equation, and a verdict, each."""

    shares_growth: ClassVar[bool] = False

    mode_verdicts: tuple[Any, ...]
    mode_growth_rates: Floats
    if TYPE_CHECKING:

        @property
        def modes(self) -> tuple[int, ...]:
            """Modes examined."""

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite for the methods used."""
        return united(*(verdict.references for verdict in self.mode_verdicts))

    def unstable_modes(self, status: Status, growth_tolerance: float) -> tuple[int, ...]:
        """Return the modes that grow faster than the tolerance, drifting ones too where that is zero."""
        rows = zip(self.modes, self.mode_verdicts, self.mode_growth_rates, strict=True)
        return tuple(m for m, v, rate in rows if v.status == "unstable" and not tolerated(rate, growth_tolerance))


@dataclass(frozen=True)
class IndependentEvidence(_ModeByMode):
    """Independent modes under a sine: an equation of Mathieu's and a verdict for each.

    Attributes
    ----------
    system : ModalSystem
        The equations of the modes under the load.
    mode_verdicts : tuple of Stability
        Verdict on each mode.
    mode_growth_rates : ndarray
        Growth rate of each mode in 1/s.
    """

    kind: ClassVar[str] = "independent modes"
    has_exact_margins: ClassVar[bool] = True

    system: ModalSystem
    mode_verdicts: tuple[Stability, ...]
    mode_growth_rates: Floats = field(compare=False)

    @property
    def modes(self) -> tuple[int, ...]:
        """Modes examined."""
        return self.system.modes

    @property
    def mode_equations(self) -> tuple[Mathieu, ...]:
        """Equation of each mode, in the time tau = omega t."""
        return self.system.equations

    @property
    def left_out_bound(self) -> float:
        """Bound in 1/s on the growth of every other mode, infinite where the modes were chosen by the caller."""
        return self.system.left_out_bound

    @property
    def cutoff(self) -> str:
        """Why these modes and no others."""
        return self.system.cutoff

    @property
    def resonances(self) -> tuple[Resonance, ...]:
        """The modes that grow, the fastest first, each with the order m of its tongue; 0 for buckling."""
        resonances = []
        for i in np.argsort(-self.mode_growth_rates, kind="stable").tolist():
            verdict = self.mode_verdicts[i]
            if verdict.status == "unstable":
                order = _order(verdict, self.mode_equations[i])
                kind: Literal["direct", "buckling"] = "direct" if order else "buckling"
                resonances.append(Resonance(kind, (self.modes[i],), order, float(self.mode_growth_rates[i])))
        return tuple(resonances)

    def fastest_mode(self, growth_rate: float) -> int | None:
        """Return the mode that grows fastest, None when none grows."""
        return self.modes[int(self.mode_growth_rates.argmax())] if growth_rate > 0.0 else None


@dataclass(frozen=True)
class NoisyEvidence(_ModeByMode):
    """Independent modes under noise: the second moments of each, and a verdict on them.

    Attributes
    ----------
    modes : tuple of int
        Modes examined.
    mode_verdicts : tuple of SystemStability
        Verdict on the second moments of each mode, in units of time in which its own frequency is 1.
    mode_growth_rates : ndarray
        Growth rate of the second moments of each mode in 1/s, negative where they decay.
    mode_intensities : ndarray
        s of each mode, q'' + ... = s q xi, in 1/s^1.5.
    left_out_bound : float
        Bound in 1/s on the growth of every other mode in mean square, infinite where the modes were chosen.
    limit : float
        Growth in 1/s that high modes approach in mean square.
    growth_errors : tuple of float
        How much less and how much more than the growth rate the growth may be, in 1/s: estimates where the noise is
        uneven about twice the frequency of a mode, or slower.
    """

    kind: ClassVar[str] = "modes under noise"
    has_exact_margins: ClassVar[bool] = False

    modes: tuple[int, ...]
    mode_verdicts: tuple[SystemStability, ...]
    mode_growth_rates: Floats = field(compare=False)
    mode_intensities: Floats = field(compare=False)
    left_out_bound: float
    limit: float
    growth_errors: tuple[float, float]

    @property
    def cutoff(self) -> str:
        """Why these modes and no others."""
        if math.isinf(self.left_out_bound):
            return f"the {len(self.modes)} modes requested; others were not checked"
        if self.left_out_bound > 0.0:
            growth = f"every higher mode grows at less than {self.left_out_bound:.2g} per second"
            return f"modes 1 to {self.modes[-1]}, in mean square: {growth}"
        return f"modes 1 to {self.modes[-1]}, in mean square: no higher mode can grow"

    @property
    def resonances(self) -> tuple[Resonance, ...]:
        """No resonance, as noise may make modes grow that resonate with nothing."""
        return ()

    def fastest_mode(self, growth_rate: float) -> int | None:
        """Return the mode that grows fastest, None when none grows, or high modes grow faster."""
        fastest = int(self.mode_growth_rates.argmax())
        rate = self.mode_growth_rates[fastest]
        return self.modes[fastest] if rate > 0.0 and rate >= growth_rate else None


@dataclass(frozen=True)
class TwoFrequencyEvidence(_ModeByMode):
    """Independent modes under two frequencies: the growth of each, from periodic approximants.

    Attributes
    ----------
    modes : tuple of int
        Modes examined.
    mode_verdicts : tuple of QuasiperiodicGrowth
        Growth of each mode, in the time tau = omega t of the first frequency.
    mode_growth_rates : ndarray
        Growth rate of each mode in 1/s, negative where it decays.
    mode_growth_errors : ndarray
        Their errors in 1/s.
    left_out_bound : float
        Bound in 1/s on the growth of every other mode, infinite where the modes were chosen by the caller.
    mode_equations : tuple of TwoFrequencies
        Equation of each mode, in the time tau.
    """

    kind: ClassVar[str] = "modes under two frequencies"
    has_exact_margins: ClassVar[bool] = False

    modes: tuple[int, ...]
    mode_verdicts: tuple[QuasiperiodicGrowth, ...]
    mode_growth_rates: Floats = field(compare=False)
    mode_growth_errors: Floats = field(compare=False)
    left_out_bound: float
    mode_equations: tuple[TwoFrequencies, ...] = field(compare=False)

    @property
    def seconds(self) -> float:
        """About how long a verdict takes, one of many."""
        return self.seconds_with(1.0)

    def seconds_with(self, longest: float) -> float:
        """Return about how long a verdict takes, one of many, with a first period ``longest`` times as long.

        Many periods of the second frequency in one of the first take as many steps.
        """
        ratio = longest * self.mode_equations[0].frequency
        return _SECONDS_PER_MODE * len(self.modes) * max(1.0, ratio / _FEW_PERIODS)

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite for the methods used."""
        return references(THEORY)

    @property
    def cutoff(self) -> str:
        """Why these modes and no others."""
        if math.isinf(self.left_out_bound):
            return f"the {len(self.modes)} modes requested; others were not checked"
        if self.left_out_bound > 0.0:
            growth = f"every higher mode grows at less than {self.left_out_bound:.1g} per second"
            return f"modes 1 to {self.modes[-1]}, two frequencies: {growth}"
        return f"modes 1 to {self.modes[-1]}, two frequencies: no higher mode can grow"

    @property
    def resonances(self) -> tuple[Resonance, ...]:
        """No resonance, as tongues of two frequencies have two orders."""
        return ()

    def fastest_mode(self, growth_rate: float) -> int | None:
        """Return the mode that grows fastest, None when none grows."""
        return self.modes[int(self.mode_growth_rates.argmax())] if growth_rate > 0.0 else None


class _SharedGrowth:
    """Coupled modes, as many as two numbers of them agree upon, with one growth rate."""

    shares_growth: ClassVar[bool] = True
    has_exact_margins: ClassVar[bool] = False
    growth_in_words: ClassVar[str]

    convergence: tuple[tuple[int, float], ...]
    if TYPE_CHECKING:

        @property
        def resonances(self) -> tuple[Resonance, ...]:
            """Resonances, the fastest first."""

    @property
    def modes(self) -> tuple[int, ...]:
        """Modes examined."""
        return tuple(range(1, self.convergence[-1][0] + 1))

    @property
    def cutoff(self) -> str:
        """Why these modes and no others."""
        last, final = self.convergence[-1]
        if len(self.convergence) == 1:
            return f"{last} coupled modes, as requested"
        fewer, first = self.convergence[-2]
        change = abs(final - first)
        known = (
            f"{self.growth_in_words} differs by {change:.1g} 1/s"
            if math.isfinite(change)
            else "growth could not be compared"
        )
        return f"{last} coupled modes; with {fewer} {known}"

    def unstable_modes(self, status: Status, growth_tolerance: float) -> tuple[int, ...]:
        """Return the modes of all resonances that grow faster than the tolerance."""
        if status != "unstable":
            return ()
        growing = [r for r in self.resonances if r.growth_rate > growth_tolerance]
        return tuple(sorted({mode for resonance in growing for mode in resonance.modes}))

    def fastest_mode(self, growth_rate: float) -> int | None:
        """Return the lower mode of the fastest resonance; None where nothing grows, or no resonance is named."""
        return min(self.resonances[0].modes) if self.resonances and growth_rate > 0.0 else None


@dataclass(frozen=True)
class CoupledEvidence(_SharedGrowth):
    """Coupled modes: their equations, and the verdict on all of them together.

    Attributes
    ----------
    convergence : tuple of (int, float)
        Numbers of modes and the growth rate in 1/s with each; the last one is the answer.
    coupled : CoupledEquations
        The coordinates in which the motion is written.
    system : HillSystem
        The equations of motion, in seconds.
    whole : SystemStability
        Verdict on them, or on the modes that may resonate.
    length : float
        Length of the rod in m.
    below : int
        Modes of lower frequency than any of ``whole``.
    """

    kind: ClassVar[str] = "coupled modes"
    growth_in_words: ClassVar[str] = "growth"

    convergence: tuple[tuple[int, float], ...]
    coupled: CoupledEquations = field(compare=False)
    system: HillSystem = field(compare=False)
    whole: SystemStability = field(compare=False)
    length: float = field(compare=False)
    below: int = field(default=0, compare=False)

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite for the methods used."""
        return self.whole.references

    @cached_property
    def resonances(self) -> tuple[Resonance, ...]:
        """Resonances that grow, the fastest first."""
        resonances = (r._replace(modes=tuple(self.below + mode for mode in r.modes)) for r in self.whole.resonances)
        return self.coupled.named(self.system, tuple(resonances))

    @cached_property
    def shape(self) -> Shape:
        """Where along the rod the fastest solution moves most, growing or not."""
        from scipy.integrate import solve_ivp

        from floquetrod.equations.pieces import of_batch
        from floquetrod.floquet.multipliers.whole_period_maps import period_maps

        # The map over a period of z' = A(t) z, z = (u, u'), gives the multiplier mu of the fastest solution and the
        # state in which it begins.  A uniform damping rate changes no shape, and is left out.
        system = self.system
        undamped, _ = system.undamped or (system, 0.0)
        first, n, period = undamped.as_periodic_system(), self.coupled.size, self.whole.period
        maps = period_maps(of_batch(first), 0.0, 1e-10, paired=True)
        values, vectors = np.linalg.eig(maps.matrix[0])
        fastest = int(np.abs(values).argmax())
        rate = math.log(abs(values[fastest])) / period
        start = (vectors[:, fastest] * maps.scaling[0]).astype(complex)
        series = np.concatenate([first.mean[None], first.harmonics])

        def slope(t: float, state: NDArray[np.complex128]) -> NDArray[np.complex128]:
            derivative = series[0] @ state
            for k, matrix in enumerate(series[1:], start=1):
                derivative = derivative + (matrix * np.exp(2j * math.pi * k * t / period)).real @ state
            return np.asarray(derivative)

        # Over one period u(t) exp(-rate t) is sampled along the rod; it is complex, and its real part at any phase is a
        # solution: the one drawn has the phase in which the largest deflection of all is real.
        times = np.linspace(0.0, period, _SHAPE_INSTANTS + 1)
        path = solve_ivp(slope, (0.0, period), start, method="DOP853", t_eval=times, rtol=1e-8, atol=1e-12).y[:n]
        path = path * np.exp(-rate * times)
        x = np.linspace(0.0, 1.0, _SHAPE_POINTS * self.coupled.size + 1)
        moving = self.coupled.shapes(x).T @ path
        envelope = np.abs(moving).max(axis=1)
        size = float(envelope.max())
        point, instant = np.unravel_index(np.abs(moving).argmax(), moving.shape)
        turned = moving[:, instant] * np.exp(-1j * np.angle(moving[point, instant]))
        return Shape(x * self.length, turned.real / size, envelope / size)


@dataclass(frozen=True)
class NoisyCoupledEvidence(_SharedGrowth):
    """Coupled modes under noise: the growth of their second moments, negative where they decay.

    Attributes
    ----------
    convergence : tuple of (int, float)
        Numbers of modes and the growth rate of second moments in 1/s with each; the last one is the answer.
    seconds : float
        About how long a verdict takes.
    """

    kind: ClassVar[str] = "coupled modes under noise"
    growth_in_words: ClassVar[str] = "growth in mean square"

    convergence: tuple[tuple[int, float], ...]
    seconds: float = field(compare=False, repr=False)

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite for the methods used."""
        return references(NOISE)

    @property
    def resonances(self) -> tuple[Resonance, ...]:
        """No resonance, as noise may make modes grow that resonate with nothing."""
        return ()


@dataclass(frozen=True)
class TwoFrequencyCoupledEvidence(_SharedGrowth):
    """Coupled modes under two frequencies: the growth of all together, from periodic approximants.

    Attributes
    ----------
    convergence : tuple of (int, float)
        Numbers of modes and the growth rate in 1/s with each, negative where they decay; the last one is the answer.
    growth : QuasiperiodicGrowth
        Growth with the last number of modes, in 1/s.
    seconds : float
        About how long a verdict takes.
    """

    kind: ClassVar[str] = "coupled modes under two frequencies"
    growth_in_words: ClassVar[str] = "growth"

    convergence: tuple[tuple[int, float], ...]
    growth: QuasiperiodicGrowth
    seconds: float = field(compare=False, repr=False)

    @property
    def references(self) -> tuple[str, ...]:
        """Publications to cite for the methods used."""
        return references(THEORY)

    @property
    def resonances(self) -> tuple[Resonance, ...]:
        """No resonance, as tongues of two frequencies have two orders."""
        return ()


Evidence = (
    IndependentEvidence
    | CoupledEvidence
    | NoisyEvidence
    | NoisyCoupledEvidence
    | TwoFrequencyEvidence
    | TwoFrequencyCoupledEvidence
)


def _order(verdict: Stability, equation: Mathieu) -> int:
    """Return the order of the resonance of a mode, 0 for buckling: of its tongue, or the nearest where unknown."""
    if verdict.interval is not None:
        return verdict.interval.order
    return max(1, round(2.0 * math.sqrt(-equation.beta))) if equation.beta < 0.0 else 0
