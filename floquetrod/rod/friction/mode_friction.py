"""Coulomb friction between rod and channel floor, and what friction and a kick become in the mode equations."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from floquetrod import units
from floquetrod._util import validate
from floquetrod._util.arrays import shaped
from floquetrod.rod.model.data import RodData
from floquetrod.rod.model.parameters import friction_coefficient

_LARGEST = 1e6  # kick in m/s: beyond any


@dataclass(frozen=True, repr=False)
class ModeFriction:
    """Coulomb friction and a kick in the mode equations of a rod under a load, the same in every mode.

    Attributes
    ----------
    friction : float
        Coefficient of friction mu, static and kinetic.
    mu_theta : float
        Share of it that acts across the rod, Eq. (16) of DOI 10.1115/1.4031710: the rest opposes axial sliding.
    v_a : float
        Speed in m/s with which the ends slide axially, Eq. (17).
    gamma : float
        Friction in the mode equation, Eq. (15).
    epsilon : float
        Kick A'(0) in the mode equation, Eq. (18).
    """

    friction: float
    mu_theta: Any
    v_a: Any
    gamma: Any
    epsilon: Any

    def __repr__(self) -> str:
        """Return the numbers with their names."""
        return (
            f"<friction gamma {self.gamma:.4g}, kick eps {self.epsilon:.4g}; mu_theta {self.mu_theta:.4g} of "
            f"mu {self.friction:g}, axial sliding {1e3 * self.v_a:.4g} mm/s>"
        )


def mode_friction(rod: RodData, friction: float, kick: float, amplitude: Any, frequency: Any) -> ModeFriction:
    """Return Eqs. (15)-(18) for a kick in m/s, amplitude in N and frequency in rad/s, both checked; broadcasts.

    The contact force per length is w_e sin(inclination), the rod's effective gravity times its inertia per length.

    Examples
    --------
    >>> rod = RodData.nitinol()
    >>> mode_friction(rod, 0.1, 0.05, 0.7 * rod.critical_force, 150.0)
    <friction gamma 0.01423, kick eps 0.08547; mu_theta 0.09999 of mu 0.1, axial sliding 0.6426 mm/s>
    """
    axial = axial_velocity(rod, amplitude, frequency)
    share = kick / np.hypot(axial, kick)
    gamma = 4.0 * friction * share * rod.effective_gravity / (math.pi * (frequency * frequency) * rod.radial_clearance)
    epsilon = kick / (frequency * rod.radial_clearance)
    shape = np.shape(share)
    parts = (shaped(np.asarray(part), shape) for part in np.broadcast_arrays(friction * share, axial, gamma, epsilon))
    return ModeFriction(friction, *parts)


def friction_and_kick(friction: Any, kick: Any) -> tuple[float, float] | None:
    """Return the coefficient of friction and the kick (m/s), None without either; ValueError for one alone.

    Friction of zero needs no kick: the rod is then the one without friction.
    """
    if friction is not None:
        friction = friction_coefficient(friction)
    if kick is None:
        if friction:
            raise validate.wrong_value(
                "kick",
                f"must be given with friction, got friction = {friction:g} alone: friction holds every "
                "undisturbed rod; give kick=0.05 (m/s), say, or compute the smallest kick with critical_kick",
            )
        return None
    if friction is None:
        raise validate.wrong_value(
            "friction",
            f"must be given with a kick, got kick = {validate.short(kick)} alone: without friction an "
            "unstable mode grows whatever the kick; give friction=0.1, say, or leave out both",
        )
    hint = "give the transverse velocity in m/s, 0.05 say; critical_kick computes the smallest that buckles"
    speed = units.number("kick", kick, "speed", math.ulp(0.0), hint=hint)
    return friction, validate.within("kick", speed, 0.0, _LARGEST, "give it in m/s")


def axial_velocity(rod: RodData, amplitude: Any, frequency: Any) -> Any:
    """Return v_a = L dF omega / (2 pi E A) in m/s, Eq. (17), A the area of the material; broadcasts."""
    return rod.length * amplitude * frequency / (2.0 * math.pi * rod.axial_rigidity)


def kicks_of(rod: RodData, friction: float, amplitude: Any, frequency: Any, ratio: Any) -> Any:
    """Return the kicks in m/s that come to ``ratio``, epsilon over gamma, in the mode equation; broadcasts (N, rad/s).

    By (15)-(18) epsilon / gamma = pi omega sqrt(v_a^2 + v^2) / (4 g mu), g the rod's effective gravity: zero where
    axial sliding alone is enough, and infinite where the ratio is, without friction too.
    """
    ratio = np.asarray(ratio, dtype=np.float64)
    whole = 4.0 * rod.effective_gravity * friction / (math.pi * frequency) * np.where(np.isinf(ratio), 1.0, ratio)
    axial = axial_velocity(rod, amplitude, frequency)
    kick = np.sqrt(np.maximum(0.0, (whole - axial) * (whole + axial)))
    return np.where(np.isinf(ratio), math.inf, kick)
