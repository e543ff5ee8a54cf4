"""The equations of a rod that moves on its wall at finite angles, in a few modes, by Lagrange.

In orthonormal functions phi_j of x = s / L, theta = sum a_j phi_j, over m R^2 L, the energies are

    kinetic   int theta_t^2 / 2 + (m_a R^2 / m L^2) int (G[theta_x theta_xt])^2 / 2
    bending   (E I / 2 m L^4) int (theta_xx^2 + theta_x^4)
    force     -(1 / 2 m L^2) int F(x, t) theta_x^2
    weight    (w / m R) int (1 - cos theta)

and the energy that hinged ends save by lifting off (`rod/model/lift_off.py`).  A rod that waves is shorter by
int R^2 theta_s^2 / 2, and moves its own mass m_a along the channel: u_t = -R^2 G[theta_s theta_st], G f the integral of
f less its mean where nothing holds an end along the channel, otherwise the integral from the end that is held.  Damping
2 c theta_t is the same as in the linear modes.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from floquetrod._util.arrays import Floats
from floquetrod._util.caching import cached_property
from floquetrod._util.content import ByContent
from floquetrod.rod.loads import axial
from floquetrod.rod.loads.load import Load
from floquetrod.rod.mode_equations.coupled_matrices import CoupledModes
from floquetrod.rod.model.contact import added_mean
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.lift_off import LiftOff

_POINTS = 24  # of a panel of the quadrature of `rod/model/beam.py`
_ALIKE = 1e-12  # critical forces by which the weight along a rod may change the force, as that of a horizontal one does
_MIRRORED = 1e-9  # of the largest, by which what is alike from both ends may differ
_PLACES = 48  # of the largest angle, for every mode: it is found to (pi / 96)^2 / 2 of the finest, 5e-4


@dataclass(frozen=True, eq=False)
class Shapes(ByContent):
    """Modes of free motion about rest under the mean force, at the nodes of a quadrature in x = s / L.

    Attributes
    ----------
    numbers : ndarray of int (n,)
        Of the beam function that each is nearest to.
    even : ndarray of bool (n,)
        Whether each is even about the middle of the rod; all False where its ends differ.
    frequencies : ndarray (n,)
        Of free motion squared, in 1/s^2; negative where the mean force alone buckles.
    nodes, weights : ndarray (q,)
    values, slopes, curves, thirds : ndarray (n, q)
        phi and its first three derivatives by x.
    ends : ndarray (2, 2, n)
        First and third derivative at both ends.
    places : ndarray (p,)
        Fine enough to see how large a motion is anywhere.
    there : ndarray (n, p)
        phi at these places.
    """

    numbers: Any
    even: Any
    frequencies: Floats
    nodes: Floats
    weights: Floats
    values: Floats
    slopes: Floats
    curves: Floats
    thirds: Floats
    ends: Floats
    places: Floats
    there: Floats

    @classmethod
    def of(cls, rod: RodData, load: Load, count: int) -> Shapes:
        """Return the modes made of the first ``count`` beam functions."""
        modes = CoupledModes.of(rod, load, count)
        basis = modes.basis
        stiffness = modes.stiffness(np.array([load.mean]))[0]
        turned = _combinations(stiffness, _mirrored(basis) if _is_symmetric(rod, load) else None)
        values, slopes = turned.T @ basis.values, turned.T @ basis.slopes
        curves, thirds, ends = _derivatives(basis.nodes, slopes)
        parity = np.sign(np.sum(values * values[:, ::-1] * basis.weights, axis=1))
        numbers = 1 + np.argmax(np.abs(turned[:count]), axis=0)
        even = (parity > 0) & _is_symmetric(rod, load)
        frequencies = np.sum(turned * (stiffness @ turned), axis=0)
        places = np.linspace(0.0, 1.0, _PLACES * len(values) + 1)
        there = turned.T @ basis.shapes(places)
        nodes, weights = basis.nodes, basis.weights
        return cls(numbers, even, frequencies, nodes, weights, values, slopes, curves, thirds, ends, places, there)

    def some(self, chosen: Any) -> Shapes:
        """Return some of them, by index."""
        of_each = ("numbers", "even", "frequencies", "values", "slopes", "curves", "thirds", "there")
        parts: dict[str, Any] = {name: getattr(self, name)[chosen] for name in of_each}
        return replace(self, ends=self.ends[..., chosen], **parts)


def _is_symmetric(rod: RodData, load: Load) -> bool:
    """Return whether a rod and the force along it are the same seen from either end."""
    ends = rod.end_conditions
    is_alike = load.mean_at is None or abs(rod.weight_along) * rod.length < _ALIKE * rod.critical_force
    return ends.upper == ends.lower and is_alike and getattr(load, "far_end", "driven") == "driven"


def _mirrored(basis: Any) -> Floats:
    """Return the integrals of phi_i(x) phi_j(1 - x)."""
    return np.asarray((basis.values * basis.weights) @ basis.values[:, ::-1].T)


def _combinations(stiffness: Floats, mirrored: Floats | None) -> Floats:
    """Return the modes of a stiffness in its columns, each even or odd where the rod is symmetric."""
    if np.abs(stiffness - np.diag(np.diag(stiffness))).max() < 1e-9 * np.abs(np.diag(stiffness)).max():
        return np.eye(len(stiffness))
    if mirrored is None:
        return np.asarray(np.linalg.eigh(stiffness)[1])
    sign, sides = np.linalg.eigh(0.5 * (mirrored + mirrored.T))
    parts = [sides[:, of] for of in (sign < 0.0, sign > 0.0)]
    return np.hstack([part @ np.linalg.eigh(part.T @ stiffness @ part)[1] for part in parts if part.size])


def _derivatives(nodes: Floats, slopes: Floats) -> tuple[Floats, Floats, Floats]:
    """Return second and third derivatives, and first and third ones at both ends, panel by panel."""
    points = np.polynomial.legendre.leggauss(_POINTS)[0]
    vander = np.polynomial.legendre.legvander(points, _POINTS - 1)
    panels = slopes.reshape(len(slopes), -1, _POINTS)
    width = _widths(nodes)
    series = np.linalg.solve(vander, np.moveaxis(panels, -1, 0).reshape(_POINTS, -1))
    derivatives = []
    for order in (1, 2):
        turned = np.polynomial.legendre.legder(series, order)
        every = np.polynomial.legendre.legvander(points, _POINTS - 1 - order) @ turned
        derivatives.append(
            np.moveaxis(every.reshape(_POINTS, *panels.shape[:2]), 0, -1) * (2.0 / width[:, None]) ** order
        )
    ends = []
    for panel, at in ((0, -1.0), (-1, 1.0)):
        own = series.reshape(_POINTS, *panels.shape[:2])[..., panel]
        third = np.polynomial.legendre.legval(at, np.polynomial.legendre.legder(own, 2)) * (2.0 / width[panel]) ** 2
        ends.append([np.polynomial.legendre.legval(at, own), third])
    return derivatives[0].reshape(slopes.shape), derivatives[1].reshape(slopes.shape), np.array(ends)


def _widths(nodes: Floats) -> Floats:
    """Return the lengths of the panels."""
    first = np.polynomial.legendre.leggauss(_POINTS)[0][0]
    panels = nodes.reshape(-1, _POINTS)
    return np.asarray((panels[:, -1] - panels[:, 0]) / -first)


def _integrals(nodes: Floats, values: Floats, to_end: bool) -> Floats:
    """Return the integrals of functions (..., q) from 0 to the nodes, less their means, or less those to the end."""
    points, weights = np.polynomial.legendre.leggauss(_POINTS)
    vander = np.polynomial.legendre.legvander(points, _POINTS - 1)
    rising = np.polynomial.legendre.legint(np.linalg.inv(vander), lbnd=-1.0)
    inside = np.polynomial.legendre.legvander(points, _POINTS) @ rising
    half = 0.5 * _widths(nodes)
    panels = values.reshape(*values.shape[:-1], -1, _POINTS)
    whole = half * (panels @ weights)
    before = np.cumsum(whole, axis=-1) - whole
    integral = before[..., None] + half[:, None] * (panels @ inside.T)
    least = np.sum(whole, axis=-1) if to_end else np.sum(half * (integral @ weights), axis=-1)
    return np.asarray((integral - least[..., None, None]).reshape(values.shape))


@dataclass(frozen=True, eq=False)
class LargeMotion(ByContent):
    """The equations of motion of a rod on its wall in some shapes, states (a, a_t) of n modes in rad and rad/s.

    Parameters
    ----------
    rod : RodData
    load : Load
        The same all along the rod, except for the weight of an inclined one.
    shapes : Shapes
    indentation : float
        Depth to which the weight of the rod at rest indents the wall, as a fraction of the radial clearance; 0 keeps
        the rod on the wall up to hinged ends, where it lifts off a little.
    shortens : bool
        Whether the inertia of shortening counts.
    """

    rod: RodData
    load: Load
    shapes: Shapes
    indentation: float = 1e-4
    shortens: bool = True

    @property
    def size(self) -> int:
        """Number of modes."""
        return len(self.shapes.numbers)

    @cached_property
    def _bending(self) -> float:
        rod = self.rod
        return rod.flexural_rigidity / rod.mass_per_length / rod.length**4

    @cached_property
    def _swing(self) -> float:
        return self.rod.pendulum_frequency**2

    @cached_property
    def _along(self) -> float:
        rod = self.rod
        return rod.mass_along / rod.mass_per_length * (rod.radial_clearance / rod.length) ** 2

    @cached_property
    def _static(self) -> Floats:
        """Stiffness of bending less the mean force, in 1/s^2."""
        shapes = self.shapes
        bent = self._bending * (shapes.curves * shapes.weights) @ shapes.curves.T
        return bent - self._pushed(self._mean(shapes.nodes))

    @cached_property
    def vibrating(self) -> Floats:
        """The loss of stiffness under each part of the vibration, (2 H, n, n)."""
        return self._pushed(self._profiles(self.shapes.nodes))

    @cached_property
    def pushed_alike(self) -> Floats:
        """The loss of stiffness per newton of uniform force, (n, n)."""
        return self._pushed(np.ones_like(self.shapes.nodes))

    def _pushed(self, force: Floats) -> Floats:
        """Return the loss of stiffness under forces (..., q) in N, in 1/s^2, (..., n, n)."""
        slopes, weights = self.shapes.slopes, self.shapes.weights
        unit = 1.0 / (self.rod.mass_per_length * self.rod.length**2)
        return np.asarray(unit * (slopes * (weights * force)[..., None, :]) @ slopes.T)

    def _mean(self, x: Floats) -> Floats:
        """Return the mean force in N at places x = s / L."""
        return np.asarray(self.load.mean + added_mean(self.rod, self.load, x))

    def _profiles(self, x: Floats) -> Floats:
        """Return the forces in N at places with the cosine and the sine of each harmonic, (2 H, len(x))."""
        rod, load = self.rod, self.load
        every = load.amplitude * axial.along(load, rod.axial_line, rod.length * x, load.frequency)
        return np.concatenate([every.real, -every.imag])

    def parts(self, times: Floats) -> Floats:
        """Return cosine and sine of each harmonic at instants, (k, 2 H)."""
        phases = self.load.frequency * np.multiply.outer(times, np.arange(1, len(self.load.harmonics) + 1))
        return np.concatenate([np.cos(phases), np.sin(phases)], axis=-1)

    @cached_property
    def _is_mirrored(self) -> bool:
        """Whether motion in the shapes looks the same from either end, as all are even, or all odd."""
        values = self.shapes.values
        odd = -1.0 if float((values[0] * values[0, ::-1] * self.shapes.weights).sum()) < 0.0 else 1.0
        return bool(np.abs(values - odd * values[:, ::-1]).max() < _MIRRORED * np.abs(values).max())

    @cached_property
    def _quadrature(self) -> tuple[Floats, Floats, Floats]:
        """Weights (q,), functions and slopes (n, q) at nodes that suffice, half the rod where the other is alike."""
        shapes, half = self.shapes, len(self.shapes.nodes) // 2
        if not self._is_mirrored:
            return shapes.weights, shapes.values, shapes.slopes
        return 2.0 * shapes.weights[:half], shapes.values[:, :half].copy(), shapes.slopes[:, :half].copy()

    @cached_property
    def shortening_inertia(self) -> Floats:
        """G[phi_i' phi_j'] at nodes that suffice, (n, n, q), times the root of its share of inertia and of weights."""
        slopes, weights = self.shapes.slopes, self.shapes.weights
        pairs = slopes[:, None, :] * slopes[None, :, :]
        is_held = getattr(self.load, "far_end", "") == "held"
        every = _integrals(self.shapes.nodes, pairs, is_held)
        if self._is_mirrored and not is_held:
            weights = self._quadrature[0]
            every = every[..., : len(weights)]
        return every * np.sqrt(weights * self._along) if self.shortens else 0.0 * every

    def under(self, load: Load) -> LargeMotion:
        """Return the same shapes under another load of the same kind."""
        other = replace(self, load=load)
        kept = ("_is_mirrored", "_quadrature", "shortening_inertia", "_lift")
        vars(other).update({name: getattr(self, name) for name in kept})
        return other

    # --- the potential energy: its gradient and second derivatives ---

    @cached_property
    def _lift(self) -> LiftOff:
        rod, wall = self.rod, self.indentation * self.rod.radial_clearance
        return LiftOff(rod.flexural_rigidity, rod.effective_gravity * rod.mass_per_length, wall)

    @cached_property
    def _lifting(self) -> list[tuple[Floats, float, Floats, float]]:
        """Of ends that lift off, first and third derivatives by s (2, n), mean force, parts (2 H,) of vibration.

        And how many there are that do so alike.
        """
        ends, length = self.rod.end_conditions, self.rod.length
        per_metre = np.array([1.0 / length, 1.0 / length**3])[:, None]
        names, x = (ends.upper, ends.lower) if self.indentation else (), np.array([0.0, 1.0])
        mean, parts = self._mean(x), self._profiles(x)
        every = [
            (per_metre * self.shapes.ends[i], mean[i], parts[:, i], 1.0)
            for i, name in enumerate(names)
            if name == "hinged"
        ]
        near = _MIRRORED * self.rod.critical_force
        alike = abs(mean[0] - mean[1]) < near and np.abs(parts[:, 0] - parts[:, 1]).max() < near
        return [(*every[0][:3], 2.0)] if len(every) == 2 and alike and self._is_mirrored else every

    def _saved(self, end: Floats, a: Floats, force: Floats, with_stiffness: bool) -> tuple[Floats, Floats]:
        """Return the gradient (k, n) of what an end saves, over m R^2 L, and where wanted second derivatives."""
        rod, lift = self.rod, self._lift
        first, third = end
        p, r, gap = a @ first, a @ third, rod.radial_clearance
        contact, by = _contact_at_hinge(p, r, force * gap, rod.flexural_rigidity * gap, lift.weight)
        e = lift.energy(gap * p * p, contact)
        curve = 2.0 * gap * p
        slope = np.stack([e.by_curvature * curve + e.by_contact * by[0], e.by_contact * by[1]], axis=-1)
        unit = 1.0 / (rod.mass_per_length * gap * gap * rod.length)
        if not with_stiffness:
            return unit * slope @ end, np.empty((0, 0, 0))
        twice = np.empty((*p.shape, 2, 2))
        d = (curve, 0.0 * p)
        for i in (0, 1):
            for j in (0, 1):
                twice[..., i, j] = (
                    e.by_curvature_twice * d[i] * d[j]
                    + e.by_both * (d[i] * by[j] + d[j] * by[i])
                    + e.by_contact_twice * by[i] * by[j]
                    + e.by_contact * by[2 + i + j]
                )
        twice[..., 0, 0] += 2.0 * gap * e.by_curvature
        return unit * slope @ end, unit * np.swapaxes(end, 0, 1) @ twice @ end

    def potential(self, times: Floats, a: Floats, with_stiffness: bool) -> tuple[Floats, Floats]:
        """Return the gradient of the potential energy (k, n) and its second derivatives (k, n, n), in 1/s^2."""
        (weights, values, slopes), parts = self._quadrature, self.parts(times)
        linear = self._static - np.tensordot(parts, self.vibrating, axes=1)
        theta, slope = a @ values, a @ slopes
        quartic, squared = 2.0 * self._bending * weights, slope * slope
        gradient = (linear @ a[..., None])[..., 0] + (self._swing * weights * np.sin(theta)) @ values.T
        gradient += (quartic * squared * slope) @ slopes.T
        stiff = np.empty((0, 0, 0))
        if with_stiffness:
            hard, swing = 3.0 * quartic * squared, self._swing * weights * np.cos(theta)
            stiff = linear + (slopes * hard[:, None, :]) @ slopes.T
            stiff += (values * swing[:, None, :]) @ values.T
        for end, mean, vibrating, count in self._lifting:
            saved = self._saved(end, a, mean + parts @ vibrating, with_stiffness)
            gradient += count * saved[0]
            if with_stiffness:
                stiff += count * saved[1]
        return gradient, stiff

    def resting(self, a: Floats) -> Floats:
        """Return the gradient of the potential energy (k, n) under the mean force alone, in 1/s^2."""
        return self.under(self.load.varied("amplitude", 0.0)).potential(np.zeros(len(a)), a, False)[0]

    # --- the equations of first order ---

    def rates(self, times: Any, states: Any) -> Floats:
        """Return the derivatives in time of states (k, 2 n) at instants (k,)."""
        a, v = np.split(np.asarray(states), 2, axis=-1)
        return np.concatenate([v, self._accelerations(np.asarray(times), a, v, False)[0]], axis=-1)

    def jacobians(self, times: Any, states: Any) -> Floats:
        """Return the derivatives of `rates` with the states, (k, 2 n, 2 n)."""
        a, v = np.split(np.asarray(states), 2, axis=-1)
        n = a.shape[-1]
        jacobian = np.zeros((len(a), 2 * n, 2 * n))
        jacobian[:, :n, n:] = np.eye(n)
        jacobian[:, n:, :n], jacobian[:, n:, n:] = self._accelerations(np.asarray(times), a, v, True)[1:]
        return jacobian

    def _accelerations(self, times: Floats, a: Floats, v: Floats, derive: bool) -> tuple[Floats, Floats, Floats]:
        """Return a_tt (k, n), and where wanted its derivatives with a and with a_t."""
        g, c, n = self.shortening_inertia, self.rod.damping_rate, a.shape[-1]
        gradient, stiff = self.potential(times, a, derive)
        moved, moving = (np.tensordot(x, g, axes=1) for x in (a, v))  # (k, n, q)
        turning = (v[:, None, :] @ moving)[:, 0]  # what shortening speeds up by without a_tt
        mass = np.eye(n) + moved @ np.swapaxes(moved, 1, 2)
        right = -gradient - 2.0 * c * v - (moved @ turning[..., None])[..., 0]
        acceleration = np.linalg.solve(mass, right[..., None])[..., 0]
        if not derive:
            return np.asarray(acceleration), stiff, stiff
        sped = (acceleration[:, None, :] @ moved)[:, 0] + turning
        by_place = -stiff - np.tensordot(sped, g, axes=(1, 2))
        by_place -= moved @ np.swapaxes(np.tensordot(acceleration, g, axes=1), 1, 2)
        by_speed = -2.0 * c * np.eye(n) - 2.0 * moved @ np.swapaxes(moving, 1, 2)
        turned = np.linalg.solve(mass, np.concatenate([by_place, by_speed], axis=-1))
        return np.asarray(acceleration), turned[..., :n], turned[..., n:]

    # --- what a motion does to the rod ---

    def angles(self, states: Floats) -> Floats:
        """Return theta in rad at the places of the shapes, (k, p)."""
        return np.asarray(states[..., : self.size] @ self.shapes.there)

    def contact_force(self, times: Floats, states: Floats) -> Floats:
        """Return the force per length in N/m with which the rod presses on the wall, (k, q), negative where it pulls.

        N = w cos(theta) + F R theta_s^2 + m R theta_t^2 + E I R (4 theta_s theta_sss + 3 theta_ss^2 - theta_s^4), of a
        rod that stays on the wall up to its ends.
        """
        rod, shapes, length = self.rod, self.shapes, self.rod.length
        a, v = np.split(states, 2, axis=-1)
        theta, speed = a @ shapes.values, v @ shapes.values
        one, two, three = a @ shapes.slopes / length, a @ shapes.curves / length**2, a @ shapes.thirds / length**3
        force = (self._mean(shapes.nodes) + self.parts(times) @ self._profiles(shapes.nodes)) * one**2
        bent = rod.flexural_rigidity * (4.0 * one * three + 3.0 * two**2 - one**4)
        mass = rod.mass_per_length
        pressed = force + mass * speed**2 + bent
        return np.asarray(mass * rod.effective_gravity * np.cos(theta) + rod.radial_clearance * pressed)

    def shortening(self, states: Floats) -> Floats:
        """Return by how much in m the rod is shorter along the channel than a straight one, (k,)."""
        slope = states[..., : self.size] @ self.shapes.slopes
        return np.asarray(0.5 * self.rod.radial_clearance**2 / self.rod.length * (slope**2 @ self.shapes.weights))


def _contact_at_hinge(p: Floats, r: Floats, force: Floats, bent: float, weight: float) -> tuple[Floats, list[Any]]:
    """Return the contact force at a hinge over the weight, from the derivatives p, r of theta by s, and its own.

    Those by p, r, p p, p r and r r; ``force`` is F R, ``bent`` E I R.
    """
    wall_force = 1.0 + (force * p * p + bent * (4.0 * p * r - p**4)) / weight
    by_p = (2.0 * force * p + bent * (4.0 * r - 4.0 * p**3)) / weight
    by_r = 4.0 * bent * p / weight
    twice = (2.0 * force - 12.0 * bent * p * p) / weight
    return wall_force, [by_p, by_r, twice, 4.0 * bent / weight, 0.0]
