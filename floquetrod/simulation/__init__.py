"""Simulation of the whole nonlinear rod, step by step: a confirmation independent of the mode equations."""

from __future__ import annotations

from floquetrod.simulation.growth import GrowthFit
from floquetrod.simulation.rod_mesh import DiscreteRod
from floquetrod.simulation.step_size import TimeSteps, critical_time_step

__all__ = ["DiscreteRod", "GrowthFit", "TimeSteps", "critical_time_step"]
