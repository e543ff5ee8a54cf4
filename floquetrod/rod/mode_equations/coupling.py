"""The causes that couple the modes of a rod, so that none obeys an equation of Mathieu's."""

from __future__ import annotations

from floquetrod._util.arguments import Mention, wrong_value
from floquetrod.rod.loads.load import Load
from floquetrod.rod.model.data import RodData

WAVEFORM = "a waveform other than a sine"
"""It leaves each mode an equation of its own."""


def coupling(rod: RodData, load: Load) -> tuple[str, ...]:
    """Return in words what keeps the modes from obeying an equation of Mathieu's each, empty where nothing does.

    They do with hinged ends, under a force that is a sine and uniform along the rod, in a channel whose inclination and
    curvature are given as uniform, or on a path that is straight there: along an arc the inclination changes, and with
    it the weight across.
    """
    ends = rod.end_conditions
    every = (
        (f"{ends} ends", not ends.are_hinged),
        ("sections or bores that differ", rod.varies),
        ("a path that bends", not rod.course.is_uniform),
        ("weight along the rod", rod.course.is_uniform and rod.weight_along > 0.0 and load.mean_at is not None),
        ("axial waves", not load.is_uniform),
        (WAVEFORM, load.waveform != "sine"),
    )
    return tuple(name for name, present in every if present)


def refusal(name: str, couplings: tuple[str, ...]) -> ValueError:
    """Return the error for a question that needs independent modes, given the causes of their coupling in words."""
    neglected = ("; ", Mention("mean_at", "mean_at=None", "none"), " neglects the weight along the rod")
    return wrong_value(
        name,
        "needs independent modes, those of hinged ends under a sine that is uniform along the rod, got "
        f"{', '.join(couplings)}",
        *(neglected if "weight along the rod" in couplings else ()),
    )
