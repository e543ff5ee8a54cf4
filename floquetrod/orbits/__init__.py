"""Periodic orbits of nonlinear systems, and their multipliers."""

from __future__ import annotations

from floquetrod.orbits.bifurcation_curve import BifurcationCurve
from floquetrod.orbits.branch import Branch
from floquetrod.orbits.finding import periodic_orbit
from floquetrod.orbits.following import follow
from floquetrod.orbits.newton import NoOrbitError
from floquetrod.orbits.orbit import PeriodicOrbit
from floquetrod.orbits.special_points import SpecialPoint

__all__ = ["BifurcationCurve", "Branch", "NoOrbitError", "PeriodicOrbit", "SpecialPoint", "follow", "periodic_orbit"]
