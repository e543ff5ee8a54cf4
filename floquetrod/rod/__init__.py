"""A rod in a channel: its parts, its loads, the equations of its modes, and the answers about its stability."""

from __future__ import annotations

from floquetrod.rod.axial import AxialGap, AxialResonance, AxialResponse
from floquetrod.rod.buckling import BucklingForce
from floquetrod.rod.friction import CriticalKick
from floquetrod.rod.mode_friction import ModeFriction
from floquetrod.rod.modes import ModalSystem, ModalSystems
from floquetrod.rod.parts import Channel, Ends, Fluids, Material, Section
from floquetrod.rod.ranges import BucklingWarning, StabilityInterval
from floquetrod.rod.unstable_bands import UnstableBand
from floquetrod.rod.verdict import Margin

__all__ = [
    "AxialGap",
    "AxialResonance",
    "AxialResponse",
    "BucklingForce",
    "BucklingWarning",
    "Channel",
    "CriticalKick",
    "Ends",
    "Fluids",
    "Margin",
    "Material",
    "ModalSystem",
    "ModalSystems",
    "ModeFriction",
    "Section",
    "StabilityInterval",
    "UnstableBand",
]
