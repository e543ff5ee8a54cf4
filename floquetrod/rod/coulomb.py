"""Coulomb friction between rod and channel floor, and what it and a kick come to in the mode equations."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from floquetrod._util import validate
from floquetrod._util.arrays import broadcast, shaped
from floquetrod.rod.data import RodData
from floquetrod.rod.load import AxialLoad, load_array

_LARGEST = 1e6  # coefficient of friction, and velocity in m/s (a choice: beyond any)


@dataclass(frozen=True)
class Coulomb:
    """Dry friction, and the transverse velocity with which the rod is disturbed.

    Parameters
    ----------
    mu : float
        Coefficient of friction, static and kinetic.
    velocity : float
        v_theta(0) in m/s, greater than zero: the amplitude of the disturbance in each mode.  Friction holds every rod
        that nothing disturbs, so that a verdict without a kick would say nothing.

    Notes
    -----
    Eqs. (15)-(18) of DOI 10.1115/1.4031710; what they come to for a rod under a load is `in_mode_equation`.

    Examples
    --------
    >>> rod = RodData.nitinol()
    >>> load = AxialLoad(mean=0.8 * rod.critical_force, amplitude=0.7 * rod.critical_force, frequency=150.0)
    >>> Coulomb(mu=0.1, velocity=0.05).in_mode_equation(rod, load)
    <friction gamma 0.01423, kick eps 0.08547; mu_theta 0.09999 of mu 0.1, axial sliding 0.6426 mm/s>
    """

    mu: float
    velocity: float

    def __post_init__(self) -> None:
        """Check and clean the parameters."""
        object.__setattr__(self, "mu", friction_coefficient(self.mu))
        hint = "friction needs a kick: give its size in m/s, 0.05 say; what it takes is told by critical_velocity"
        velocity = validate.positive("velocity", self.velocity, hint)
        object.__setattr__(self, "velocity", validate.within("velocity", velocity, 0.0, _LARGEST, "give it in m/s"))

    def in_mode_equation(self, rod: RodData, load: AxialLoad) -> ModeFriction:
        """Return gamma, epsilon and what they come from, the same for every mode."""
        validate.instance("load", load, AxialLoad)
        values = self.in_mode_equations(rod, load.amplitude, load.frequency)
        return ModeFriction(self.mu, *map(float, values))

    def in_mode_equations(self, rod: RodData, amplitude: Any, frequency: Any) -> tuple[Any, Any, Any, Any]:
        """Return mu_theta, v_a, gamma and epsilon, Eqs. (15)-(18), over amplitudes (N) and frequencies (rad/s)."""
        validate.instance("rod", rod, RodData)
        shape, (force, omega) = broadcast(
            amplitude=load_array("amplitude", amplitude), frequency=load_array("frequency", frequency)
        )
        axial = axial_velocity(rod, force, omega)
        share = self.velocity / np.hypot(axial, self.velocity)
        gamma = 4.0 * self.mu * share * rod.gravity / (math.pi * omega**2 * rod.radial_clearance)
        mu_theta, axial, gamma, epsilon = (
            shaped(part, shape)
            for part in (self.mu * share, axial, gamma, self.velocity / (omega * rod.radial_clearance))
        )
        return mu_theta, axial, gamma, epsilon


@dataclass(frozen=True, repr=False)
class ModeFriction:
    """What `Coulomb` friction comes to in the mode equations of a rod under a load.

    Attributes
    ----------
    mu : float
        Coefficient of friction.
    mu_theta : float
        Share of it that acts across the rod, Eq. (16): the rest opposes axial sliding.
    v_a : float
        Speed in m/s with which the ends slide axially, Eq. (17).
    gamma : float
        Friction in the mode equation, Eq. (15).
    epsilon : float
        Kick A'(0), Eq. (18).
    """

    mu: float
    mu_theta: float
    v_a: float
    gamma: float
    epsilon: float

    def __repr__(self) -> str:
        """Return the numbers with their names."""
        return (
            f"<friction gamma {self.gamma:.4g}, kick eps {self.epsilon:.4g}; mu_theta {self.mu_theta:.4g} of "
            f"mu {self.mu:g}, axial sliding {1e3 * self.v_a:.4g} mm/s>"
        )


def friction_coefficient(mu: Any, name: str = "mu") -> float:
    """Return a coefficient of friction as a float."""
    number = validate.nonnegative(name, mu, "friction opposes the motion")
    return validate.within(name, number, 0.0, _LARGEST, "it is a coefficient such as 0.1")


def axial_velocity(rod: RodData, amplitude: Any, frequency: Any) -> Any:
    """Return v_a = L dF omega / (2 pi E A) in m/s, Eq. (17); broadcasts."""
    return rod.length * amplitude * frequency / (2.0 * math.pi * rod.youngs_modulus * rod.area)


def critical_velocities(rod: RodData, amplitude: Any, frequency: Any, mu: float, ratio: Any) -> Any:
    """Return the velocities in m/s whose kick over friction, epsilon / gamma, is ``ratio``; broadcasts (N, rad/s).

    By (15)-(18) epsilon / gamma = pi omega sqrt(v_a^2 + v^2) / (4 g mu): zero where axial sliding alone is enough, and
    infinite where the ratio is, without friction too.
    """
    ratio = np.asarray(ratio, dtype=np.float64)
    whole = 4.0 * rod.gravity * mu / (math.pi * frequency) * np.where(np.isinf(ratio), 1.0, ratio)
    axial = axial_velocity(rod, amplitude, frequency)
    velocity = np.sqrt(np.maximum(0.0, (whole - axial) * (whole + axial)))
    return np.where(np.isinf(ratio), math.inf, velocity)
