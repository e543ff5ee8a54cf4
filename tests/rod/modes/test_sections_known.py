"""Whatever a rod of several sections is asked: the answer depends on all of them, or is refused in one line."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from tests.conftest import needs_jit

UPPER = fr.Section(diameter="1.6mm", length=1.0, youngs_modulus="68GPa", density=6500.0, yield_strength="500MPa")
STRING = fr.Rod(
    sections=[UPPER, fr.Section(diameter="1.3mm", length=0.8, yield_strength="400MPa")],
    channel_diameter="18.8mm",
    damping_rate=0.3,
    inclination="80deg",
)
LOWER = {  # another lower section, or bore below the upper end
    "a thinner lower section": {"sections": [UPPER, fr.Section(diameter="1.0mm", length=0.8, yield_strength="400MPa")]},
    "a shorter lower section": {"sections": [UPPER, fr.Section(diameter="1.3mm", length=0.5, yield_strength="400MPa")]},
    "another material below": {
        "sections": [UPPER, fr.Section(diameter="1.3mm", length=0.8, youngs_modulus="50GPa", yield_strength="100MPa")]
    },
}
LOAD = fr.AxialLoad(0.15, 0.3, 60.0)
WAVE = fr.AxialWave(0.15, 0.3, 60.0)
WELL = fr.WellPath([0.0, 100.0, 550.0, 600.0], ["0deg", "0deg", "90deg", "90deg"])
BOX: dict[str, Any] = {"mean": (0.1, 0.11), "amplitude": 0.1, "frequency": 20.0}

QUESTIONS: dict[str, Callable[[fr.Rod], Any]] = {
    # methods with their arguments
    "axial_response": lambda rod: rod.axial_response(WAVE).resonances,
    "certify": lambda rod: rod.certify(**BOX),
    "critical": lambda rod: float(rod.critical("amplitude", LOAD)),
    "critical_kick": lambda rod: rod.critical_kick(LOAD, friction=0.1),
    "follow": lambda rod: rod.follow(LOAD, over={"frequency": (59.0, 61.0)}, steps=1),
    "growth_rate": lambda rod: rod.growth_rate(LOAD),
    "is_stable": lambda rod: rod.is_stable(mean=0.15, amplitude=np.linspace(0.0, 0.6, 13), frequency=60.0),
    "largest_safe_box": lambda rod: rod.largest_safe_box(LOAD),
    "lock_up": lambda rod: rod.lock_up(0.2),
    "mean_force": lambda rod: rod.mean_force(WELL, 0.2, bottom=580.0).at_top,
    "modal_system": lambda rod: rod.modal_system(LOAD, modes=range(1, 7)).stiffness,
    "modes_needed": lambda rod: rod.modes_needed(LOAD),
    "natural_frequency": lambda rod: rod.natural_frequency(1),
    "ranges": lambda rod: rod.ranges("amplitude", LOAD, bounds=(0.0, 1.0)),
    "reach": lambda rod: rod.reach(WELL, 0.2, depth=[580.0]).force,
    "response": lambda rod: rod.replace(natural_shape={3: 1e-4}).response(LOAD, unstable=True).largest,
    "safe_kick": lambda rod: rod.safe_kick(LOAD),
    "stability": lambda rod: rod.stability(LOAD).growth_rate,
    "steady_motion": lambda rod: rod.steady_motion(LOAD),
    "stress": lambda rod: rod.stress(fr.AxialLoad(0.15, 0.3, 60.0, mean_at=0.0)).share_of_yield,
    "surface_weights": lambda rod: rod.surface_weights(WELL, 0.2, depth=[580.0]).slack_off,
    "verdicts": lambda rod: rod.verdicts(mean=0.15, amplitude=np.linspace(0.0, 0.6, 13), frequency=60.0),
}
OTHERS: dict[str, Callable[[fr.Rod], Any]] = {
    # functions of a rod
    "stress under a wave": lambda rod: rod.stress(WAVE).largest,
    "stability under a wave": lambda rod: rod.stability(WAVE).growth_rate,
    "stability with a kick": lambda rod: rod.stability(LOAD, friction=0.1, kick=0.05),
    "stability under noise": lambda rod: rod.stability(fr.AxialLoad(0.15, 0.3, 60.0, noise=1e-4)).growth_rate,
    "stability_map": lambda rod: fr.stability_map(rod, LOAD, mean=(0.0, 0.4, 12), frequency=(50.0, 70.0, 12)).stable,
    "probability_of_reach": lambda rod: fr.probability_of_reach(rod, WELL, 0.2, {"density": (6e3, 7e3)}, samples=100),
    "probability": lambda rod: fr.probability_of_instability(rod, LOAD, {"youngs_modulus": (6e10, 7e10)}, samples=100),
    "simulate": lambda rod: fr.SimulationProblem(rod, LOAD, duration=1e-3, segments=60, frames=2).mesh,
}
LONG = {"stability under noise", "stability_map", "ranges", "critical"}
"""What takes a second."""

UNTOUCHED = {
    "catalogue": "makes a rod",
    "from_toml": "makes a rod",
    "nitinol": "makes a rod",
    "replace": "makes a rod",
    "uniform_parts": "the parts themselves",
    "edges": "where they lie, without what they are",
    "along": "takes places",
    "in_cell": "takes a section",
    "given_in": "units",
    "given_units": "units",
    "bores": "a parameter",
    "channel": "inclination and gravity, and the bore at the upper end",
    "channel_radius": "of the bore at the upper end, as documented",
    "course": "the channel",
    "end_conditions": "a parameter",
    "fluids": "a parameter",
    "varies": "whether it does",
    "weakest_at": "the upper section is the weakest here",
}
PARAMETERS = {"youngs_modulus", "density", "radius", "inner_radius", "yield_strength"}
"""Of the first section, as the docstring of `Rod` says."""


def answered(question: Callable[[fr.Rod], Any], rod: fr.Rod) -> tuple[Any, str]:
    """Return an answer, or the line in which it is refused."""
    try:
        return question(rod), ""
    except (ValueError, TypeError) as error:
        return None, str(error)


def same(one: Any, other: Any) -> bool:
    """Return whether two answers are alike."""
    if isinstance(one, dict | tuple | str) or not np.ndim(one):
        return str(one) == str(other)
    return bool(np.shape(one) == np.shape(other) and np.all(one == other))


def require_all_sections(question: Callable[[fr.Rod], Any]) -> None:
    """Fail where an answer about a string does not change with its lower section, nor is refused."""
    answer, refusal = answered(question, STRING)
    if refusal:
        assert "\n" not in refusal
        assert "section" in refusal or "parts" in refusal or "coupled" in refusal, refusal
        assert len(refusal) < 300, refusal
        return
    assert any(not same(answer, answered(question, STRING.replace(**change))[0]) for change in LOWER.values())


@needs_jit
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in dir(fr.Rod) if not name.startswith("_")],
)
@pytest.mark.filterwarnings("ignore")
def test_every_public_attribute_knows_every_section_or_refuses(name: str) -> None:
    if name in UNTOUCHED or (name in fr.Rod.__dataclass_fields__ and name != "length"):
        return
    is_method = inspect.isfunction(inspect.getattr_static(fr.Rod, name))
    if is_method and name not in QUESTIONS:
        assert name == "as_dict"  # a new method needs a question here
    require_all_sections(QUESTIONS.get(name, lambda rod: getattr(rod, name)() if is_method else getattr(rod, name)))


@needs_jit
@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in OTHERS])
@pytest.mark.filterwarnings("ignore")
def test_every_function_of_a_rod_knows_every_section_or_refuses(name: str) -> None:
    require_all_sections(OTHERS[name])


def test_parameters_of_a_section_are_those_of_the_first() -> None:
    for name in PARAMETERS:
        assert getattr(STRING, name) == getattr(UPPER, name)
    assert STRING.length == pytest.approx(1.8)
