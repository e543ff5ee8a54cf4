"""Everything that is asked of a rod, asked in wells: each public method answers for the bend, or says why it cannot."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.rod.model.course import weight_gained
from tests.inside import wave_ratio, wavenumber

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::floquetrod.ForcedAngleWarning", "ignore::floquetrod.PlausibilityWarning"),
    pytest.mark.filterwarnings("ignore::floquetrod.rod.BucklingWarning", "ignore::floquetrod.UndecidedWarning"),
]

ROD = fr.Rod.nitinol().replace(length=1.6, damping_rate=0.3)
UNIT = ROD.critical_force
STRAIGHT = ROD.replace(inclination=math.radians(84.0))
ARC = fr.WellPath.arc(length=3.0, inclination=np.radians([80.0, 90.0]))
S_SHAPED = fr.WellPath([0.0, 0.8, 1.6, 3.0], np.radians([80.0, 86.0, 82.0, 85.0]))
TURNING = fr.WellPath([0.0, 0.8, 1.6, 3.0], np.radians([80.0, 83.0, 86.0, 88.0]), np.radians([0.0, 4.0, 7.0, 8.0]))
RODS = {name: ROD.replace(path=path) for name, path in (("arc", ARC), ("s", S_SHAPED), ("turn", TURNING))}
WAVE = fr.AxialLoad(0.42 * UNIT, 0.36 * UNIT, 150.0)
CALM = fr.AxialLoad(0.1 * UNIT, 0.02 * UNIT, 150.0)
NOISY = fr.AxialLoad(0.2 * UNIT, 0.05 * UNIT, 130.0, noise=1e-6)
LONG = fr.WellPath([0.0, 100.0, 200.0], ["10deg", "60deg", "90deg"])
NUMBERS = {"mean": WAVE.mean, "amplitude": WAVE.amplitude, "frequency": WAVE.frequency}

DIFFERS: dict[str, Callable[[fr.Rod], Any]] = {
    "stability": lambda rod: rod.stability(WAVE).growth_rate,
    "growth_rate": lambda rod: rod.growth_rate(**NUMBERS),
    "growth_rate with its mode": lambda rod: rod.growth_rate(**NUMBERS, return_mode=True)[0],
    "modal_system": lambda rod: rod.modal_system(WAVE, range(1, 6)).stiffness,
    "critical mean": lambda rod: rod.critical("mean", amplitude=0.0, frequency=130.0),
    "critical amplitude": lambda rod: rod.critical("amplitude", mean=0.2 * UNIT, frequency=130.0),
    "ranges of the amplitude": lambda rod: [
        part[:2] for part in rod.ranges("amplitude", mean=0.42 * UNIT, frequency=150.0, bounds=(0.0, 0.6))
    ],
    "ranges of the mean force": lambda rod: [
        part[:2] for part in rod.ranges("mean", amplitude=0.2 * UNIT, frequency=130.0, bounds=(0.0, 1.0))
    ],
    "ranges of the frequency": lambda rod: [
        part[:2] for part in rod.ranges("frequency", mean=0.3 * UNIT, amplitude=0.25 * UNIT, bounds=(110.0, 150.0))
    ],
    "stress": lambda rod: rod.stress(WAVE).largest,
    "weight_gained": lambda rod: weight_gained(rod, 1.0, 0.0),
    "critical_forces": lambda rod: [each.force for each in rod.critical_forces.values()],
    "natural_frequency": lambda rod: rod.natural_frequency(3),
    "response": lambda rod: rod.replace(natural_shape={5: 1e-4}).response(CALM).largest,
    "critical noise": lambda rod: rod.critical("noise", NOISY),
    "stability with noise": lambda rod: rod.stability(NOISY).exponents[0].real,
}
"""What is not that of a straight hole of the same mean inclination."""

SAME: dict[str, Callable[[fr.Rod], Any]] = {
    "modes_needed": lambda rod: rod.modes_needed(WAVE)[0] > 4,
    "is_stable": lambda rod: rod.is_stable(**NUMBERS) == (rod.stability(WAVE, growth_tolerance=0.0).status == "stable"),
    "verdicts": lambda rod: rod.verdicts(**NUMBERS) == (rod.stability(WAVE).growth_rate == 0.0),
    "the model of the modes": lambda rod: "a path that bends" in rod._modes_under(WAVE).coupling,
    "along": lambda rod: rod.along(0.3) == ROD.along(0.3),
    "surface_weights": lambda rod: (
        rod.surface_weights(LONG, 0.2, depth=[100.0]) == ROD.surface_weights(LONG, 0.2, depth=[100.0])
    ),
    "mean_force": lambda rod: rod.mean_force(LONG, 0.2).at_top == ROD.mean_force(LONG, 0.2).at_top,
    "reach": lambda rod: rod.reach(LONG, 0.2, depth=[100.0]).reach == ROD.reach(LONG, 0.2, depth=[100.0]).reach,
    "axial_response": lambda rod: rod.axial_response(WAVE).largest == ROD.axial_response(WAVE).largest,
    "wave_ratio": lambda rod: wave_ratio(rod, WAVE) == wave_ratio(ROD, WAVE),
    "wavenumber": lambda rod: wavenumber(rod, 3) == wavenumber(ROD, 3),
    "replace": lambda rod: rod.replace(length=1.6) == rod,
    "as_dict": lambda rod: fr.Rod(**rod.as_dict()) == rod,
}
"""What is as true in a well as elsewhere: a sentence about its own answer, or one that asks for no bend."""

REFUSED: dict[str, tuple[Callable[[fr.Rod], Any], str]] = {
    "modal_system of arrays": (lambda rod: rod.modal_system(WAVE, mean=[WAVE.mean]), "a path that bends"),
    "critical_kick": (lambda rod: rod.critical_kick(WAVE, friction=0.1), "a path that bends"),
    "critical_kick of arrays": (
        lambda rod: rod.critical_kick(WAVE, friction=0.1, mean=[WAVE.mean]),
        "a path that bends",
    ),
    "certify": (lambda rod: rod.certify(**NUMBERS), "a path that bends"),
    "largest_safe_box": (lambda rod: rod.largest_safe_box(WAVE), "a path that bends"),
    "lock_up": (lambda rod: rod.lock_up(0.2), "this one bends"),
    "steady_motion": (lambda rod: rod.steady_motion(WAVE), "bend"),
    "follow": (lambda rod: rod.follow(WAVE, {"frequency": (1.0, 2.0)}), "bend"),
    "safe_kick": (lambda rod: rod.safe_kick(WAVE), "bend"),
    "stability with friction": (lambda rod: rod.stability(WAVE, friction=0.1, kick=0.01), "a path that bends"),
    "verdicts with friction": (
        lambda rod: rod.verdicts(**NUMBERS, friction=0.1, kick=0.01),
        "a path that bends",
    ),
}
"""What is not known in a bend, and a word of the reason."""

NO_QUESTIONS = {"nitinol", "catalogue", "from_toml", "given_in", "in_cell"}
"""What makes a rod, of numbers or of another."""


def test_every_public_method_is_here() -> None:
    """A new method of a rod needs a row: what it answers in a well, or why it does not."""
    methods = {name for name, _ in inspect.getmembers(fr.Rod, callable) if not name.startswith("_")}
    assert methods <= {name.split(" ")[0] for name in (*DIFFERS, *SAME, *REFUSED)} | NO_QUESTIONS


@pytest.mark.parametrize("name", RODS)
@pytest.mark.parametrize("method", DIFFERS)
def test_answers_are_those_of_the_bend(method: str, name: str) -> None:
    """Finite, and another than in a straight hole of the mean inclination."""
    found, straight = (DIFFERS[method](rod) for rod in (RODS[name], STRAIGHT))
    found, straight = (np.asarray(each, dtype=float) for each in (found, straight))
    assert np.isfinite(found).all()
    assert found.shape != straight.shape or not np.allclose(found, straight, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("name", RODS)
@pytest.mark.parametrize("method", SAME)
def test_what_holds_elsewhere_holds_in_a_well(method: str, name: str) -> None:
    assert SAME[method](RODS[name])


@pytest.mark.parametrize("name", RODS)
@pytest.mark.parametrize("method", REFUSED)
def test_what_is_not_known_in_a_bend_is_refused_in_a_sentence(method: str, name: str) -> None:
    ask, words = REFUSED[method]
    with pytest.raises(ValueError, match=words) as caught:
        ask(RODS[name])
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400
