"""A rod in a channel: its parts, its loads, the equations of its modes, and the answers about its stability."""

from __future__ import annotations

from typing import TYPE_CHECKING

from floquetrod._util.lazy import names_of

if TYPE_CHECKING:
    from floquetrod.rod.axial import AxialGap, AxialResonance, AxialResponse
    from floquetrod.rod.buckling import BucklingForce
    from floquetrod.rod.friction import CriticalKick
    from floquetrod.rod.intervals import BucklingWarning, StabilityInterval, UnstableBand
    from floquetrod.rod.mode_friction import ModeFriction
    from floquetrod.rod.modes import ModalSystem, ModalSystems
    from floquetrod.rod.parts import Channel, Ends, Fluids, Material, Section
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

__getattr__ = names_of(
    __name__,
    {
        "rod.axial": (
            "AxialGap",
            "AxialResonance",
            "AxialResponse",
        ),
        "rod.buckling": ("BucklingForce",),
        "rod.friction": ("CriticalKick",),
        "rod.mode_friction": ("ModeFriction",),
        "rod.modes": (
            "ModalSystem",
            "ModalSystems",
        ),
        "rod.parts": (
            "Channel",
            "Ends",
            "Fluids",
            "Material",
            "Section",
        ),
        "rod.intervals": (
            "BucklingWarning",
            "StabilityInterval",
            "UnstableBand",
        ),
        "rod.verdict": ("Margin",),
    },
)


def __dir__() -> list[str]:
    return __all__
