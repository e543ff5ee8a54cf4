"""Coupled modes: the equations of a rod whose force varies along it, or whose ends are not hinged, as a system.

In beam functions phi_j(x), x = s / L, of unit norm the deflection sum q_j phi_j obeys

    q'' + 2 c q' + K(t) q = 0,  K_ij = (E I / m L^4) int phi_i'' phi_j'' + (w_e sin(inc) / (R m)) delta_ij
                                       - (1 / m L^2) int F(s, t) phi_i' phi_j'.

Ritz's method: what is left out of the series only ever stiffens the rod.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import validate
from floquetrod._util.caching import cached_property
from floquetrod.equations import HillSystem
from floquetrod.floquet.systems.many import ManyVerdicts
from floquetrod.floquet.systems.result import Resonance
from floquetrod.floquet.verdict import tolerated
from floquetrod.rod import axial
from floquetrod.rod.axial import AxialResonanceError
from floquetrod.rod.beam import Basis, basis
from floquetrod.rod.constants import HAIRLINE_GROWTH, ModeConstants
from floquetrod.rod.load import AxialLoad, Load, Loads
from floquetrod.rod.parts import Ends

Floats = NDArray[np.float64]

MOST_COUPLED = 2000  # modes of a system: half a minute each verdict (a choice)
LEAST_COUPLED = 10  # modes at least, beside one and a half times the critical mode (a choice)
_WAVEFORM = "a waveform other than a sine"
_GROUPS = 16  # of loads by frequency, each with its own number of modes (a choice)
_AT_ONCE = 1 << 22  # numbers in the matrices of systems that are held at once (a choice: 32 megabytes)


class RodNumbers(NamedTuple):
    """All that coupled modes depend on besides the load, in SI units.

    Attributes
    ----------
    constants : ModeConstants
    ends : Ends
    length : float
    critical_mode : float
        The mode, not rounded, that the critical force of a long rod buckles.
    weight_along : float
        w_e cos(inclination) in N/m.
    wave_speed : float
        Of axial waves, m/s.
    """

    constants: ModeConstants
    ends: Ends
    length: float
    critical_mode: float
    weight_along: float
    wave_speed: float

    def has_mathieu_modes(self, load: Load) -> bool:
        """Return whether each mode obeys an equation of Mathieu's: hinged ends, a uniform force that is a pure sine."""
        return not self.departures(load)

    def are_modes_apart(self, load: Load) -> bool:
        """Return whether each mode obeys an equation of its own: hinged ends and a force uniform along the rod."""
        return set(self.departures(load)) <= {_WAVEFORM}

    def departures(self, load: Load) -> tuple[str, ...]:
        """Return, in words, what keeps the modes from obeying an equation of Mathieu's each; empty where they do."""
        every = (
            (f"{self.ends} ends", not self.ends.are_hinged),
            ("weight along the rod", self.weight_along > 0.0 and load.mean_at is not None),
            ("axial waves", not load.is_uniform),
            (_WAVEFORM, load.waveform != "sine"),
        )
        return tuple(name for name, present in every if present)

    def modes_needed(self, loads: Loads, like: Load, growth_tolerance: float) -> int:
        """Return how many modes to take for loads of a kind: as many as the largest force along the rod would need.

        An estimate: that force is taken as uniform, and modes beyond are expected to grow at less than 1e-6 per second,
        or the tolerance, if larger.  At least ten more than one and a half times the critical mode, for accuracy.
        """
        self.require_few(loads, like, growth_tolerance)
        uniform = self.largest_uniform(loads, like)
        needed, _ = self.constants.modes_needed(uniform, max(growth_tolerance, HAIRLINE_GROWTH))
        if needed > MOST_COUPLED:
            raise self._too_many(needed, uniform, loads, like, growth_tolerance)
        return max(math.ceil(1.5 * self.critical_mode) + LEAST_COUPLED, needed + 2)

    def _too_many(
        self, needed: int, uniform: AxialLoad, loads: Loads, like: Load, growth_tolerance: float
    ) -> ValueError:
        """Return the error that says why so many modes are needed, and the remedies that are left."""
        given = float(loads.amplitude.max())
        without_waves, _ = self.constants.modes_needed(
            uniform.varied("amplitude", given), max(growth_tolerance, HAIRLINE_GROWTH)
        )
        if without_waves <= MOST_COUPLED:
            frequency = max(np.unique(loads.frequency).tolist(), key=lambda at: self._largest_along(like, at))
            forces = (uniform.mean + uniform.amplitude) / self.constants.critical_force
            return AxialResonanceError(
                f"frequency {frequency:.6g} rad/s is next to an axial resonance of the rod, which makes "
                f"{uniform.amplitude:.3g} N of {given:.3g} N along it, {forces:.3g} critical forces, for which "
                f"{needed} coupled modes would be needed, more than {MOST_COUPLED}; give more axial_damping, another "
                "frequency, a shorter length, or choose the number of modes"
            )
        remedies = [
            *(["the rod its damping_rate"] if self.constants.damping_rate == 0.0 else []),
            *(["a growth_tolerance"] if growth_tolerance <= HAIRLINE_GROWTH else []),
            "a shorter length",
        ]
        return ValueError(
            f"load needs {needed} coupled modes, more than {MOST_COUPLED}: so long a rod has that many resonances "
            f"below the frequency; give {', '.join(remedies)}, or choose the number of modes"
        )

    def require_few(self, loads: Loads, like: Load, growth_tolerance: float) -> None:
        """Raise ValueError, at once, where the modes alone that the largest force outweighs are too many."""
        uniform = self.largest_uniform(loads, like)
        push = max(0.0, uniform.mean + uniform.amplitude)
        needed = math.ceil(math.sqrt(push / self.constants.rigidity / self.constants.w2))
        if needed > MOST_COUPLED:
            raise self._too_many(needed, uniform, loads, like, growth_tolerance)

    def largest_uniform(self, loads: Loads, like: Load) -> AxialLoad:
        """Return a sine, uniform along the rod, as strong and as fast as any part of any of the loads."""
        frequencies = np.unique(loads.frequency)
        largest = max(
            self._largest_along(like, frequency)
            for frequency in (frequencies[:1] if like.is_uniform else frequencies).tolist()
        )
        mean = float(loads.mean.max()) + max(self.added_mean(like, 0.0), self.added_mean(like, 1.0))
        fastest = float(loads.frequency.max()) * len(like.harmonics)
        return AxialLoad(mean, float(loads.amplitude.max()) * largest, fastest)

    def _largest_along(self, like: Load, frequency: float) -> float:
        """Return the largest force along the rod for an amplitude of one newton, if harmonics met in phase."""
        self.require_off_resonance(like, frequency)
        return axial.bound(like, self.wave_speed, self.length, frequency)

    def require_off_resonance(self, like: Load, frequency: float) -> None:
        """Raise AxialResonanceError where waves of a frequency resonate in the rod, without axial damping."""
        axial.require_off_resonance(like, self.wave_speed, self.length, frequency)

    def up_to_resonance(self, like: Load, piece: tuple[float, float]) -> tuple[float, float]:
        """Return a piece of frequencies, in either direction, cut where waves first resonate, without axial damping."""
        found = axial.gaps(like, self.wave_speed, self.length, (min(piece), max(piece)))
        if not found:
            return piece
        return piece[0], found[0].low if piece[0] < piece[1] else found[-1].high

    def added_mean(self, like: Load, x: Any) -> Any:
        """Return what the weight along the rod adds to the mean force at x = s / L, in N."""
        return 0.0 * x if like.mean_at is None else self.weight_along * self.length * (x - like.mean_at)


@dataclass(frozen=True, eq=False)
class CoupledModes:
    """The modes of a rod under one kind of load, ``count`` of them, as systems of equations in seconds.

    Attributes
    ----------
    numbers : RodNumbers
    like : Load
        What the loads have in common: everything but mean, amplitude and frequency.
    count : int
        Beam functions; polynomials may be added to them.
    """

    numbers: RodNumbers
    like: Load
    count: int

    @cached_property
    def basis(self) -> Basis:
        """The functions along the rod."""
        return basis(self.numbers.ends, self.count)

    @property
    def size(self) -> int:
        """Number of equations."""
        return self.basis.size

    @cached_property
    def _static(self) -> tuple[Floats, Floats]:
        """Stiffness without mean force in 1/s^2, and what a newton of uniform compression takes from it."""
        constants, length = self.numbers.constants, self.numbers.length
        bending = constants.rigidity / constants.mass_per_length / length**4 * self.basis.bending
        weight = self._coupling(self.numbers.added_mean(self.like, self.basis.nodes))
        swing = constants.pendulum_frequency**2 * np.eye(self.size)
        return bending + swing - weight, self._coupling(np.ones_like(self.basis.nodes))

    def _coupling(self, force: NDArray[Any]) -> Floats:
        """Return (1 / m L^2) int F phi_i' phi_j' for a force in N at the nodes."""
        return self.basis.coupling(force) / (self.numbers.constants.mass_per_length * self.numbers.length**2)

    def _vibration(self, frequency: float) -> NDArray[np.float64]:
        """Return cosine and sine matrices of every harmonic for an amplitude of one newton, (2, H, n, n)."""
        numbers, s = self.numbers, self.basis.nodes * self.numbers.length
        numbers.require_off_resonance(self.like, frequency)
        every = axial.along(self.like, numbers.wave_speed, numbers.length, s, frequency)
        found = [(-self._coupling(force.real), self._coupling(force.imag)) for force in every]
        return np.array(found).swapaxes(0, 1)

    def system(self, loads: Loads) -> HillSystem:
        """Return the systems of flat loads as one batch, or a single one where there is one load of the shape ()."""
        stiffness, push = self._static
        frequencies, inverse = np.unique(loads.frequency, return_inverse=True)
        if self.like.is_uniform:  # the same at all frequencies
            vibration = self._vibration(float(frequencies[0]))[None]
            inverse = np.zeros_like(inverse)
        else:
            vibration = np.array([self._vibration(float(frequency)) for frequency in frequencies])
        mean = stiffness - loads.mean[:, None, None] * push
        forcing = loads.amplitude[:, None, None, None, None] * vibration[inverse]
        single = loads.shape == ()
        parts = [[m[0] if single else m for m in np.moveaxis(forcing[:, i], 1, 0)] for i in (0, 1)]
        cosines, sines = ([] if not any(m.any() for m in series) else series for series in parts)
        damping = 2.0 * self.numbers.constants.damping_rate * np.eye(self.size)
        period = 2.0 * math.pi / loads.frequency
        return HillSystem(
            mean[0] if single else mean,
            cosines,
            sines,
            damping=damping if damping.any() else None,
            period=float(period[0]) if single else period,
        )

    @property
    def _are_apart(self) -> bool:
        """Whether the functions are the modes themselves, each with an equation of its own."""
        return self.numbers.are_modes_apart(self.like)

    def answers(
        self, loads: Loads, growth_tolerance: float = 0.0, workers: int | None = None, *, quick: bool = False
    ) -> ManyVerdicts:
        """Return statuses and growth rates in 1/s of the fastest solutions, estimates where undecided.

        The status is 1 where no solution grows faster than the tolerance (1/s), 0 where one does, -1 where undecided.
        With ``quick`` more loads are undecided, those next to a boundary, none of which then takes long.
        """
        status, growth = np.empty(loads.size, dtype=np.int8), np.empty(loads.size)
        for part in self._parts(loads):
            status[part], growth[part] = self._answers(loads.part(part), workers, quick)
        status[tolerated(growth, growth_tolerance)] = 1
        return ManyVerdicts(status, growth)

    def _answers(self, loads: Loads, workers: int | None, quick: bool) -> ManyVerdicts:
        """Return statuses without tolerance, and growth rates, of loads whose matrices are held at once."""
        still = loads.amplitude == 0.0
        if not still.any():
            return self._judged(self.system(loads), workers, quick)
        status, growth = np.empty(loads.size, dtype=np.int8), np.empty(loads.size)
        status[still], growth[still] = self.static_answers(loads.mean[still])
        if not still.all():
            at = np.flatnonzero(~still)
            moving = Loads((at.size,), *(values[at] for values in loads.flat))
            status[at], growth[at] = self._judged(self.system(moving), workers, quick)
        return ManyVerdicts(status, growth)

    def static_answers(self, mean: Floats) -> ManyVerdicts:
        """Return statuses and growth rates in 1/s under mean forces (N) alone, from the least eigenvalue of stiffness.

        Undecided where rounding hides its sign; the growth rate is the largest possible one then.
        """
        stiffness, push = self._static
        squared = np.linalg.eigvalsh(stiffness - mean[:, None, None] * push)
        error = self.size * np.finfo(np.float64).eps * np.abs(squared).max(axis=1)
        least, rate = squared[:, 0], self.numbers.constants.damping_rate
        status = np.where(least > error, 1, np.where(least < -error, 0, -1)).astype(np.int8)
        against = np.maximum(0.0, np.where(status == -1, error - least, -least))
        return ManyVerdicts(status, against / (rate + np.sqrt(rate * rate + against) + (against == 0.0)))

    def growth_without_decay(self, loads: Loads) -> Floats:
        """Return the growth in 1/s of exp(c t) q, c the damping rate: that of q and c more; NaN where unknown."""
        system = self.system(loads)
        freed, _ = system.undamped or (system, 0.0)
        return self._judged(freed, None, quick=True).growth

    def _judged(self, system: HillSystem, workers: int | None, quick: bool) -> ManyVerdicts:
        """Return statuses and growth rates of systems, where modes are apart each by its own equation."""
        from floquetrod.systems.arrays import verdicts

        if not self._are_apart:
            return verdicts(system, workers=workers, quick=quick)
        status, growth = verdicts(_one_by_one(system), workers=workers, quick=quick)
        status, growth = status.reshape(-1, self.size), growth.reshape(-1, self.size)
        worst = np.where((status == 0).any(axis=1), 0, status.min(axis=1)).astype(np.int8)
        return ManyVerdicts(worst, growth.max(axis=1))

    def resonances(self, load: Load) -> tuple[Resonance, ...]:
        """Return what grows under one load, the fastest first, modes numbered as those without axial force."""
        from floquetrod.floquet.dispatch import stability

        system = self.system(Loads.single(load))
        return self.named(system, stability(system).resonances)

    def named(self, system: HillSystem, resonances: tuple[Resonance, ...]) -> tuple[Resonance, ...]:
        """Return resonances whose modes are counted by frequency under the mean force, with their own numbers."""
        if not resonances:
            return ()
        if self._are_apart:
            return _direct(system)
        left = np.abs(np.linalg.eigh(system.stiffness)[1])  # functions by modes
        names = {}
        for _ in range(len(left)):  # each mode is named after the function that it has most of, the clearest first
            function, mode = np.unravel_index(left.argmax(), left.shape)
            names[int(mode) + 1] = int(function) + 1
            left[function, :] = left[:, mode] = -1.0
        return tuple(r._replace(modes=tuple(sorted(names[i] for i in r.modes))) for r in resonances)

    def _parts(self, loads: Loads) -> list[slice]:
        each = self.size**2 * (1 + 2 * len(self.like.harmonics))
        step = max(1, _AT_ONCE // each)
        return [slice(i, min(i + step, loads.size)) for i in range(0, loads.size, step)]


@dataclass(frozen=True, eq=False)
class CoupledLoads:
    """A rod under many loads of one kind, with as many modes as each frequency needs.

    Attributes
    ----------
    numbers : RodNumbers
    like : Load
        What the loads have in common.
    loads : Loads
    growth_tolerance : float
        Growth in 1/s up to which a mode counts as stable.
    """

    numbers: RodNumbers
    like: Load
    loads: Loads
    growth_tolerance: float = 0.0

    def answers(self, workers: int | None = None, *, quick: bool = False) -> ManyVerdicts:
        """Return statuses and growth rates in 1/s as `CoupledModes.answers` does; -1 and NaN at axial resonances."""
        status, growth = np.full(self.loads.size, -1, dtype=np.int8), np.full(self.loads.size, np.nan)
        for chosen, modes, loads in self._groups():
            status[chosen], growth[chosen] = modes.answers(loads, self.growth_tolerance, workers, quick=quick)
        return ManyVerdicts(status, growth)

    def _groups(self) -> Iterator[tuple[NDArray[np.intp], CoupledModes, Loads]]:
        """Yield loads of neighbouring frequencies, by their indices, with their modes."""
        order = np.argsort(self.loads.frequency, kind="stable")
        edges = np.searchsorted(self.loads.frequency[order], np.unique(self.loads.frequency))
        edges = edges[:: max(1, -(-len(edges) // _GROUPS))]
        for chosen in np.split(order, edges[1:]):
            if chosen.size:
                yield from self._with_modes(chosen)

    def _with_modes(self, chosen: NDArray[np.intp]) -> Iterator[tuple[NDArray[np.intp], CoupledModes, Loads]]:
        """Yield loads, in the order of their frequencies, with their modes; without those at axial resonances.

        A single load, of the shape (), is refused there.
        """
        loads = Loads((chosen.size,), *(values[chosen] for values in self.loads.flat))
        try:
            count = self.numbers.modes_needed(loads, self.like, self.growth_tolerance)
        except AxialResonanceError:
            if self.loads.shape == ():
                raise
            edges = np.searchsorted(loads.frequency, np.unique(loads.frequency))
            if len(edges) > 1:
                for part in np.split(chosen, [edges[len(edges) // 2]]):
                    yield from self._with_modes(part)
        else:
            yield chosen, CoupledModes(self.numbers, self.like, count), loads


def _direct(system: HillSystem) -> tuple[Resonance, ...]:
    """Return what grows in a system of modes that are apart, each by its own equation, the fastest first."""
    from floquetrod.systems.arrays import verdicts

    status, growth = verdicts(_one_by_one(system))
    found = []
    for i in np.argsort(-growth, kind="stable").tolist():
        if status[i] == 0:
            squared = float(system.stiffness[i, i])
            order = round(math.sqrt(max(squared, 0.0)) * float(system.period) / math.pi)
            kind: Literal["direct", "buckling"] = "direct" if squared > 0.0 else "buckling"
            found.append(Resonance(kind, (i + 1,), max(order, 1) if squared > 0.0 else 0, float(growth[i])))
    return tuple(found)


def _one_by_one(systems: HillSystem) -> HillSystem:
    """Return the diagonals of a system (n, n), or of a batch (b, n, n), as single equations (b n, 1, 1)."""

    def diagonal(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.diagonal(matrix, axis1=-2, axis2=-1).reshape(-1, 1, 1)

    damping = systems.damping
    return HillSystem(
        diagonal(systems.stiffness),
        [diagonal(matrix) for matrix in systems.cosines],
        [diagonal(matrix) for matrix in systems.sines],
        damping=None if damping is None else damping[..., :1, :1],
        period=np.repeat(systems.period, systems.order),
    )


def chosen_count(modes: Any) -> int:
    """Return how many modes a caller chose: coupled modes are taken from the first on, without gaps."""
    chosen = validate.modes(modes)
    if chosen != tuple(range(1, len(chosen) + 1)):
        raise ValueError(
            f"modes of a rod whose modes are coupled must be 1 to some number, got {validate.short(list(chosen))}; "
            "give range(1, n + 1)"
        )
    return validate.integer("modes", len(chosen), 1, MOST_COUPLED)
