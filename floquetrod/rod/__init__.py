"""A rod in a channel: its parts, its loads, the equations of its modes, and the answers about its stability."""

from __future__ import annotations

from typing import TYPE_CHECKING

from floquetrod._util.lazy import names_of

if TYPE_CHECKING:
    from floquetrod.floquet.margins import Margin
    from floquetrod.rod.answers.critical_value import CriticalValue
    from floquetrod.rod.answers.stability_intervals import BucklingWarning, StabilityInterval, UnstableBand
    from floquetrod.rod.friction.kicks import CriticalKick
    from floquetrod.rod.friction.mode_friction import ModeFriction
    from floquetrod.rod.loads.axial import AxialGap, AxialResonance, AxialResponse
    from floquetrod.rod.mode_equations.modal_systems import ModalSystem, ModalSystems
    from floquetrod.rod.model.beam import EndConditions
    from floquetrod.rod.model.buckling import BucklingForce
    from floquetrod.rod.model.course import Channel
    from floquetrod.rod.model.cross_section import CrossSection, Fluids, Material
    from floquetrod.rod.model.stress import Stress

__all__ = [
    "AxialGap",
    "AxialResonance",
    "AxialResponse",
    "BucklingForce",
    "BucklingWarning",
    "Channel",
    "CriticalKick",
    "CriticalValue",
    "CrossSection",
    "EndConditions",
    "Fluids",
    "Margin",
    "Material",
    "ModalSystem",
    "ModalSystems",
    "ModeFriction",
    "StabilityInterval",
    "Stress",
    "UnstableBand",
]

__getattr__, __dir__ = names_of(
    __name__,
    {
        "rod.loads.axial": ("AxialGap", "AxialResonance", "AxialResponse"),
        "rod.model.buckling": ("BucklingForce",),
        "rod.friction.kicks": ("CriticalKick",),
        "rod.friction.mode_friction": ("ModeFriction",),
        "rod.mode_equations.modal_systems": ("ModalSystem", "ModalSystems"),
        "rod.model.beam": ("EndConditions",),
        "rod.model.course": ("Channel",),
        "rod.model.cross_section": ("CrossSection", "Fluids", "Material"),
        "rod.model.stress": ("Stress",),
        "rod.answers.critical_value": ("CriticalValue",),
        "rod.answers.stability_intervals": ("BucklingWarning", "StabilityInterval", "UnstableBand"),
        "floquet.margins": ("Margin",),
    },
)
