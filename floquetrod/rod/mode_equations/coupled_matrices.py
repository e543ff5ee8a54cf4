"""Coupled modes: the equations of a rod whose force varies along it, or whose ends are not hinged, as a system.

In beam functions phi_j(x), x = s / L, of unit norm the deflection sum q_j phi_j obeys

    q'' + 2 c q' + K(t) q = 0,  K_ij = (E I / m L^4) int phi_i'' phi_j'' + (w_e sin(inc) / (R m)) delta_ij
                                       - (1 / m L^2) int F(s, t) phi_i' phi_j'.

Where the channel bends (1 / (R m)) int N(s, t) phi_i phi_j stands in place of the second term, N the contact force.
Of a rod of several sections E I and N / R, or w_e sin(inc) / R, are in the integrals, and the functions are orthonormal
with m, so that K is divided by the m of the first section.

Ritz's method: truncating the series never makes the rod softer.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from floquetrod._util.arguments import Mention, wrong_value
from floquetrod._util.arrays import Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.progress import Progress
from floquetrod.equations import HillSystem
from floquetrod.floquet.multipliers.many_verdicts import ManyVerdicts
from floquetrod.rod.loads import axial
from floquetrod.rod.loads.axial import AxialResonanceError
from floquetrod.rod.loads.load import AxialLoad, Load, Loads
from floquetrod.rod.mode_equations.coupled_systems import SEVERAL, CoupledEquations
from floquetrod.rod.mode_equations.coupling import WAVEFORM, coupling
from floquetrod.rod.model.beam import Basis
from floquetrod.rod.model.constants import SLOW_GROWTH, ModeConstants, mode_constants
from floquetrod.rod.model.contact import Lying, Wall, added_mean, constants_under, on_wall
from floquetrod.rod.model.course import weight_gained
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.section_basis import are_nested, functions_along, number_of_functions

MOST_COUPLED = 2000  # modes of a system: half a minute each verdict
LEAST_COUPLED = 10  # modes at least, beside one and a half times the critical mode (a choice)
_HANGING = 4.0  # k (E I / w_along)^(1/3) of the last: the onset of a string that hangs comes out 2e-4 late (measured)


def modes_needed(rod: RodData, template: Load, loads: Loads, growth_tolerance: float) -> int:
    """Return how many modes to take for loads of a kind: as many as the largest force along the rod would need.

    An estimate: that force is taken as uniform, and modes beyond are expected to grow at less than 1e-6 per second, or
    the tolerance, if larger.  At least ten more than one and a half times the critical mode, for accuracy, and as many
    as follow the shape of a steep string, which the weight along it confines to the end that is pushed.
    """
    uniform = require_few(rod, template, loads, growth_tolerance)
    needed, _ = constants_under(rod, uniform.mean).modes_needed(uniform, max(growth_tolerance, SLOW_GROWTH))
    if needed > MOST_COUPLED:
        raise _too_many(needed, rod, uniform, loads, template, growth_tolerance)
    return max(math.ceil(1.5 * rod.critical_mode) + LEAST_COUPLED, needed + 2, _confined(rod))


@functools.lru_cache(maxsize=64)
def _confined(rod: RodData) -> int:
    """Return how many modes follow waves of the length (E I / w)^(1/3), over which weight along a rod confines them."""
    x = np.union1d(np.linspace(0.0, 1.0, 33), rod.course.samples)
    steepest = float(np.max(np.abs(np.diff(weight_gained(rod, x, 0.0)) / np.diff(x)))) / rod.length
    rigidity = min(part.rod.flexural_rigidity for part in rod.uniform_parts)
    return math.ceil(_HANGING * rod.length / math.pi * math.cbrt(steepest / rigidity))


def _too_many(
    needed: int, rod: RodData, uniform: AxialLoad, loads: Loads, template: Load, growth_tolerance: float
) -> ValueError:
    """Return the error for too many modes, with their cause and the remedies left."""
    given = float(loads.amplitude.max())
    without_waves, _ = constants_under(rod, uniform.mean).modes_needed(
        uniform.varied("amplitude", given), max(growth_tolerance, SLOW_GROWTH)
    )
    if without_waves <= MOST_COUPLED:
        frequency = max(np.unique(loads.frequency).tolist(), key=lambda at: _largest_along(rod, template, at))
        forces = (uniform.mean + uniform.amplitude) / rod.critical_force
        return wrong_value(
            "frequency",
            f"{frequency:.6g} rad/s is next to an axial resonance of the rod, which makes "
            f"{uniform.amplitude:.3g} N of {given:.3g} N along it, {forces:.3g} critical forces, for which "
            f"{needed} coupled modes would be needed, more than {MOST_COUPLED}; give more ",
            Mention("axial_damping"),
            ", another frequency, a shorter length, or choose the number of modes",
            kind=AxialResonanceError,
        )
    is_free, is_strict = rod.damping_rate == 0.0, growth_tolerance <= SLOW_GROWTH
    return wrong_value(
        "load",
        f"needs {needed} coupled modes, more than {MOST_COUPLED}: so long a rod has that many resonances below the "
        "frequency; give ",
        *(("the rod its ", Mention("damping_rate"), ", ") if is_free else ()),
        *(("a ", Mention("growth_tolerance"), ", ") if is_strict else ()),
        "a shorter length, or choose the number of modes",
    )


def require_few(rod: RodData, template: Load, loads: Loads, growth_tolerance: float) -> AxialLoad:
    """Return `_largest_uniform`; ValueError, at once, where the modes alone that it outweighs are too many."""
    uniform = _largest_uniform(rod, template, loads)
    constants, push = constants_under(rod, uniform.mean), max(0.0, uniform.mean + uniform.amplitude)
    needed = math.ceil(math.sqrt(push * constants.per_newton / constants.bending))
    if needed > MOST_COUPLED:
        raise _too_many(needed, rod, uniform, loads, template, growth_tolerance)
    return uniform


def _largest_uniform(rod: RodData, template: Load, loads: Loads) -> AxialLoad:
    """Return a sine, uniform along the rod, as strong and as fast as any part of any of the loads."""
    frequencies = np.unique(loads.frequency)
    largest = max(
        _largest_along(rod, template, frequency)
        for frequency in (frequencies[:1] if template.is_uniform else frequencies).tolist()
    )
    mean = float(loads.mean.max()) + _most_added(rod, template.mean_at)
    fastest = float(loads.frequency.max()) * len(template.harmonics)
    return AxialLoad(mean, float(loads.amplitude.max()) * largest, fastest)


@functools.lru_cache(maxsize=64)
def _most_added(rod: RodData, mean_at: float | None) -> float:
    """Return the most that weight along a rod adds to the mean force at the place where that is given, in N."""
    return 0.0 if mean_at is None else float(np.max(weight_gained(rod, rod.course.samples, mean_at)))


@functools.lru_cache(maxsize=64)  # asked several times in a verdict
def _largest_along(rod: RodData, template: Load, frequency: float) -> float:
    """Return the largest force along the rod for an amplitude of one newton, if harmonics met in phase."""
    axial.require_off_resonance(template, rod.axial_line, frequency)
    return axial.bound(template, rod.axial_line, frequency)


def up_to_resonance(rod: RodData, template: Load, piece: tuple[float, float]) -> tuple[float, float]:
    """Return a piece of frequencies, in either direction, cut where waves first resonate, without axial damping."""
    gaps = axial.gaps(template, rod.axial_line, (min(piece), max(piece)))
    if not gaps:
        return piece
    return piece[0], gaps[0].low if piece[0] < piece[1] else gaps[-1].high


@dataclass(frozen=True, eq=False)
class CoupledModes(CoupledEquations):
    """The modes of a rod under one kind of load, ``count`` of them, as systems of equations in seconds.

    Attributes
    ----------
    rod : RodData
        Gives ends, length and wave speed.
    template : Load
        Gives all properties of the loads except mean, amplitude and frequency.
    count : int
        Beam functions; a few others may be added to them.
    constants : ModeConstants
        Constants of the modes, the rod's or close to them.
    along : float
        Factor of the rod's weight along the channel: 1, or close to it.
    """

    rod: RodData
    template: Load
    count: int
    constants: ModeConstants
    along: float = 1.0

    @classmethod
    def of(cls, rod: RodData, template: Load, count: int) -> Self:
        """Return the first modes of a rod."""
        return cls(rod, template, count, mode_constants(rod))

    @cached_property
    def basis(self) -> Basis:
        """The functions along the rod."""
        return functions_along(self.rod, self.count)

    @property
    def size(self) -> int:
        """Number of equations."""
        return number_of_functions(self.rod, self.count)

    @cached_property
    def _static(self) -> tuple[Floats, Floats]:
        """Stiffness without mean force in 1/s^2, and its loss per newton of uniform compression."""
        bending = self.constants.bending / math.pi**4 * self.basis.bending
        weight = self._coupling(self._added)
        pressed = 0.0 if self.rod.course.is_straight else self.constants.weight  # of a bend `_pressed` has the contact
        swing = (self.constants.restoring - pressed) * np.eye(self.size)
        if self.rod.varies:
            rest = self.constants.restoring - self.constants.weight
            swing = rest * np.eye(self.size)
            if self.rod.course.is_straight:
                swing = swing + self.basis.pressing(self.constants.weight * self._weight_over_clearance)
        return bending + swing - weight, self.basis.softening * float(self.constants.per_newton / math.pi**2)

    @cached_property
    def _weight_over_clearance(self) -> Floats:
        """w_e / R at the nodes, relative to the upper end."""
        along, upper = self.rod.along(self.basis.nodes), self.rod.along(0.0)
        return np.asarray(along.weight / along.clearance / (upper.weight / upper.clearance))

    @cached_property
    def _added(self) -> Floats:
        """The mean force of the weight along the rod at the nodes, in N."""
        return np.asarray(self.along * added_mean(self.rod, self.template, self.basis.nodes))

    @cached_property
    def _wall(self) -> Wall:
        """The wall of a channel that bends, at the nodes; contact forces in its units are N / (R m), in 1/s^2."""
        rod, nodes = self.rod, self.basis.nodes
        clearance = rod.along(nodes).clearance if rod.varies else rod.radial_clearance
        per_newton = self.constants.per_newton * (rod.length / math.pi) ** 2 / clearance
        weight = self.constants.weight / math.sin(rod.inclination)
        if rod.varies:
            weight = weight * self._weight_over_clearance
        return Wall(rod.course.place(nodes), weight, per_newton)

    def _lying(self, mean: float) -> Lying:
        """Return the string at rest on the wall under a mean force in N."""
        return self._wall.lying(mean + self._added)

    def _pressed(self, mean: Floats) -> Floats:
        """Return the stiffness due to the mean contact force, in 1/s^2: (loads, size, size)."""
        values, inverse = np.unique(mean, return_inverse=True)
        if self._wall.place.turns or len(values) < 3:
            every = np.array([self.basis.pressing(self._lying(value).contact) for value in values.tolist()])
            return np.asarray(every[inverse])
        # In a plane it is affine in the mean force on either side of the channel.
        unit = self.basis.pressing(self._wall.per_newton * self._wall.place.kappa_n)
        none = self.basis.pressing(self._wall.across(self._added))
        side = np.array([self._lying(value).side for value in values.tolist()])[inverse]
        return np.asarray(side[:, None, None] * (none + mean[:, None, None] * unit))

    def _coupling(self, force: NDArray[Any]) -> Floats:
        """Return (1 / m L^2) int F phi_i' phi_j' for a force in N at the nodes."""
        return self.basis.coupling(force) * float(self.constants.per_newton / math.pi**2)

    def softening(self, mean: float) -> Floats:
        """Return what a newton of compression, uniform along the rod, takes from the stiffness, in 1/(N s^2).

        In a channel that bends it presses the string on its wall, too, by what holds next to a mean force.
        """
        taken = self._static[1]
        if self.rod.course.is_straight:
            return taken
        return np.asarray(taken - self.basis.pressing(self._wall.per_newton * self._lying(mean).bend))

    def _vibration(self, frequency: float) -> NDArray[np.float64]:
        """Return cosine and sine matrices of every harmonic for an amplitude of one newton, (2, H, n, n)."""
        line = self.rod.axial_line
        axial.require_off_resonance(self.template, line, frequency)
        every = axial.along(self.template, line, self.basis.nodes * self.rod.length, frequency)
        found = [(-self._coupling(force.real), self._coupling(force.imag)) for force in every]
        return np.array(found).swapaxes(0, 1)

    def _pressing(self, mean: float, frequency: float) -> NDArray[np.float64]:
        """Return the matrices of the vibrating contact force, which add to `_vibration`, under a mean force."""
        line = self.rod.axial_line
        forces = axial.along(self.template, line, self.basis.nodes * self.rod.length, frequency)
        bend = self._wall.per_newton * self._lying(mean).bend
        waves = [(self.basis.pressing(bend * f.real), -self.basis.pressing(bend * f.imag)) for f in forces]
        return np.array(waves).swapaxes(0, 1)

    def _bent_vibration(self, loads: Loads) -> NDArray[np.float64]:
        """Return `_pressing` under each load, (loads, 2, H, n, n)."""
        mean, frequency = loads.mean, loads.frequency
        if not self._wall.place.turns:  # it depends on the side alone
            sides = {value: self._lying(value).side for value in np.unique(mean).tolist()}
            mean = np.array([next(v for v in sides if sides[v] == sides[value]) for value in mean.tolist()])
        if self.template.is_uniform:
            frequency = np.full_like(frequency, frequency[0])
        pairs, inverse = np.unique(np.stack([mean, frequency]), axis=1, return_inverse=True)
        return np.array([self._pressing(*pair) for pair in pairs.T.tolist()])[inverse.ravel()]

    def system(self, loads: Loads) -> HillSystem:
        """Return the systems of flat loads as one batch, or a single one where there is one load of the shape ()."""
        frequencies, inverse = np.unique(loads.frequency, return_inverse=True)
        if self.template.is_uniform:  # the same at all frequencies
            vibration = self._vibration(float(frequencies[0]))[None]
            inverse = np.zeros_like(inverse)
        else:
            vibration = np.array([self._vibration(float(frequency)) for frequency in frequencies])
        mean, vibration = self.stiffness(loads.mean), vibration[inverse]
        if not self.rod.course.is_straight:
            vibration = vibration + self._bent_vibration(loads)
        forcing = loads.amplitude[:, None, None, None, None] * vibration
        single = loads.shape == ()
        parts = [[m[0] if single else m for m in np.moveaxis(forcing[:, i], 1, 0)] for i in (0, 1)]
        cosines, sines = ([] if not any(m.any() for m in series) else series for series in parts)
        damping = 2.0 * self.damping_rate * np.eye(self.size)
        period = 2.0 * math.pi / loads.frequency
        return HillSystem(
            mean[0] if single else mean,
            cosines,
            sines,
            damping=damping if damping.any() else None,
            period=float(period[0]) if single else period,
        )

    def shapes(self, x: Floats) -> Floats:
        """Return the functions at x = s / L: (size, len(x))."""
        return self.basis.shapes(x)

    @property
    def damping_rate(self) -> float:
        """Decay rate c of free motion in 1/s."""
        return float(self.constants.damping_rate)

    def damped(self, rate: float) -> Self:
        """Return the same modes with another decay rate."""
        return replace(self, constants=self.constants._replace(damping_rate=rate))

    def changed(self, bending: float, force: float, weight: float) -> Self:
        """Return the same modes with bending stiffness, weight along and weight across the rod changed by factors."""
        constants = self.constants.pressed(weight * self.constants.weight)
        constants = constants._replace(bending=bending * constants.bending)
        return replace(self, constants=constants, along=force * self.along)

    def stiffness(self, mean: Floats) -> Floats:
        """Return the stiffness under mean forces in N, in 1/s^2: (loads, size, size)."""
        stiffness, push = self._static
        found = np.asarray(stiffness - mean[:, None, None] * push)
        return found if self.rod.course.is_straight else found + self._pressed(mean)

    def is_affine(self, low: float, high: float) -> bool:
        """Return whether the mean of K is affine in the mean force between two: where the string stays on one side."""
        if self.rod.course.is_straight or self._wall.place.turns:
            return self.rod.course.is_straight
        # What presses a place down is itself affine, so that a place on one side at both ends is there between them.
        one, other = (self._lying(mean).side for mean in (low, high))
        return one == other != 0.0

    def forced_angle(self, load: Load, system: HillSystem | None = None) -> float | None:
        """Return how far in rad the vibration moves a rod in a channel that turns along the wall, to first order.

        That of (K + 2 i c w - w^2) q = (1 / (R m)) int f aside phi, all harmonics in phase; None in a plane.
        """
        if self.rod.course.is_straight or not self._wall.place.turns:
            return None
        aside = self._wall.per_newton * self._lying(load.mean).aside * self.basis.weights
        line = self.rod.axial_line
        every = axial.along(load, line, self.basis.nodes * self.rod.length, load.frequency)
        stiffness = self.stiffness(np.array([load.mean]))[0] if system is None else system.stiffness
        angle = np.zeros(self.basis.nodes.size)
        for k, force in enumerate(every, start=1):
            w = k * load.frequency
            resisting = stiffness + (2j * self.damping_rate * w - w * w) * np.eye(self.size)
            driven = self.basis.values @ np.stack([aside * force.real, aside * force.imag], axis=1)  # stays real
            moved = np.linalg.solve(resisting, driven[:, 0] + 1j * driven[:, 1])
            angle += np.hypot(moved.real @ self.basis.values, moved.imag @ self.basis.values)
        return load.amplitude * float(angle.max())

    def answers(
        self,
        loads: Loads,
        growth_tolerance: float = 0.0,
        workers: int | None = None,
        *,
        quick: bool = False,
        progress: Progress | None = None,
    ) -> ManyVerdicts:
        """Return status and growth as `CoupledEquations.answers`; -1 and NaN where the rod leaves its wall."""
        lies = np.flatnonzero(on_wall(self.rod, self.template, loads))
        if lies.size == loads.size:
            return super().answers(loads, growth_tolerance, workers, quick=quick, progress=progress)
        status, growth = np.full(loads.size, -1, dtype=np.int8), np.full(loads.size, np.nan)
        if lies.size:
            some = super().answers(loads.some(lies), growth_tolerance, workers, quick=quick, progress=progress)
            status[lies], growth[lies] = some
        return ManyVerdicts(status, growth)

    @property
    def are_apart(self) -> bool:
        """Whether the functions are the modes themselves, each with an equation of its own."""
        return set(coupling(self.rod, self.template)) <= {WAVEFORM}

    @property
    def are_nested(self) -> bool:
        """Whether the equations of fewer modes are the first of these, as where no other functions are added.

        Of few modes of several sections not: functions are added that suit their number, on which growth depends less.
        """
        return are_nested(self.rod) and (not self.rod.varies or self.count > SEVERAL)

    @property
    def added(self) -> int:
        """Functions that come before the modes."""
        return self.size - self.count if self.rod.varies else 0
