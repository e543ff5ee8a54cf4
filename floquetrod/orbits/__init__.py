"""Periodic orbits of nonlinear systems, and their multipliers."""

from __future__ import annotations

from floquetrod.orbits.finding import periodic_orbit
from floquetrod.orbits.newton import NoOrbitError
from floquetrod.orbits.orbit import PeriodicOrbit

__all__ = ["NoOrbitError", "PeriodicOrbit", "periodic_orbit"]
