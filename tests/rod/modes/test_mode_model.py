"""A new kind of rod is one more model of its modes: two modes with a spring between them, written here alone."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np
import pytest
from numpy.typing import NDArray

import floquetrod as fr
from floquetrod.explorer.view import View
from floquetrod.plotting.explorer_panels import UNKNOWN
from floquetrod.rod.modes.coupled_verdict import classify_coupled
from tests.inside import AnyLoad, CoupledEquations, CoupledModel, Load, Loads, kind
from tests.seams import Tuned

Floats = NDArray[np.float64]

SPRING = 400.0  # 1/s^2
PACKAGE = Path(fr.__file__).parent


@dataclass(frozen=True)
class TwoModes(CoupledEquations):
    """Modes 1 and 2 of a rod with hinged ends, and a spring between their amplitudes."""

    rod: fr.Rod
    template: Load
    rate: float
    count: int = 2

    @property
    def size(self) -> int:
        """Two."""
        return 2

    @property
    def damping_rate(self) -> float:
        """Decay rate in 1/s."""
        return self.rate

    def damped(self, rate: float) -> Self:
        """Return the same with another."""
        return replace(self, rate=rate)

    def stiffness(self, mean: Floats) -> Floats:
        """Return that of the rod and of the spring."""
        spring = SPRING * np.array([[1.0, -1.0], [-1.0, 1.0]])
        return np.asarray(free(self.rod) + spring - mean[:, None, None] * per_newton(self.rod))

    def shapes(self, x: Floats) -> Floats:
        """Return sines."""
        return np.sin(np.pi * np.array([[1.0], [2.0]]) * x)

    def system(self, loads: Loads) -> fr.HillSystem:
        """Return the equations under loads that are a sine."""
        push = -loads.amplitude[:, None, None] * per_newton(self.rod)
        every = self.stiffness(loads.mean), push, 2.0 * math.pi / loads.frequency
        mean, sine, period = (part[0] for part in every) if loads.shape == () else every
        damping = 2.0 * self.rate * np.eye(2) if self.rate else None
        return fr.HillSystem(mean, sines=[sine], damping=damping, period=period)


class SpringModel(CoupledModel):
    """The two modes under any load that is uniform along the rod."""

    @property
    def coupling(self) -> tuple[str, ...]:
        """What couples the modes."""
        return ("a spring between the modes",)

    def in_modes(self, count: int) -> TwoModes:
        """Return both modes."""
        return TwoModes(self.rod, self.template, self.rod.damping_rate)  # type: ignore[arg-type]

    def count_for(self, loads: Loads, growth_tolerance: float) -> int:
        """Return 2: there are no more."""
        return 2

    def verdict(
        self, load: Load, modes: Iterable[int] | None = None, growth_tolerance: float = 0.0, progress: Any = None
    ) -> fr.results.RodStability:
        """Return the verdict with both modes."""
        return classify_coupled(self, load, 2, growth_tolerance, progress)


@dataclass(frozen=True, init=False, repr=False)
class SprungRod(fr.Rod):
    """A rod of two modes with a spring between them."""

    def _modes_under(self, template: AnyLoad | None = None) -> SpringModel:
        """Return the model above."""
        return SpringModel(self, kind(template))


def free(rod: fr.Rod) -> Floats:
    """Return the squares of the natural frequencies without force or spring, as a diagonal matrix."""
    return np.diag(rod.natural_frequency(np.array([1, 2])) ** 2)


def per_newton(rod: fr.Rod) -> Floats:
    """Return what a newton of compression takes from them."""
    return np.diag((np.array([1, 2]) * np.pi / rod.length) ** 2 / rod.mass_per_length)


ROD = SprungRod(68e9, 6500.0, 0.8e-3, 0.8, 4.7e-3)
STIFFNESS = free(ROD) + SPRING * np.array([[1.0, -1.0], [-1.0, 1.0]])
SLOW, FAST = np.sqrt(np.linalg.eigvalsh(STIFFNESS)).tolist()


def sum_growth(amplitude: float) -> float:
    """Return the growth in 1/s at the sum of the frequencies, to first order: amplitude |e_12| / (4 sqrt(w1 w2))."""
    one, two = np.linalg.eigh(STIFFNESS)[1].T
    return float(amplitude * abs(one @ per_newton(ROD) @ two) / (4.0 * math.sqrt(SLOW * FAST)))


def buckling() -> float:
    """Return the mean force at which the stiffness is singular, the lesser root of its determinant."""
    (a, _), (_, b) = STIFFNESS.tolist()
    c, d = np.diag(per_newton(ROD)).tolist()
    return float(min(np.roots([c * d, -(a * d + b * c), a * b - SPRING**2]).real))


AMPLITUDE = 0.02 * buckling()
LOAD = fr.AxialLoad(0.0, AMPLITUDE, SLOW + FAST)


def test_the_frequencies_are_those_of_the_closed_form() -> None:
    a, b = np.diag(free(ROD))
    middle, reach = 0.5 * (a + b) + SPRING, math.hypot(0.5 * (a - b), SPRING)
    assert pytest.approx([middle - reach, middle + reach], rel=1e-12) == [SLOW**2, FAST**2]


def test_a_verdict_names_the_resonance_that_the_spring_makes() -> None:
    found = ROD.stability(LOAD)
    assert (found.status, found.unstable_modes, found.fastest_mode) == ("unstable", (1, 2), 1)
    assert str(found.resonances[0]) == "sum resonance of modes 1 and 2, order 1"
    # The next order is the ratio of amplitude and stiffness, some percent.
    assert found.growth_rate == pytest.approx(sum_growth(AMPLITUDE), rel=0.02)
    # Damping c lowers the frequencies by c^2 / 2 w, which is c / 2 w of the width of the tongue.
    rate = found.growth_rate
    assert found.damping_to_stabilise == pytest.approx(rate, rel=rate / SLOW)
    assert fr.Rod(*list(ROD.as_dict().values())[:5]).stability(LOAD).stable  # without the spring


def test_arrays_of_loads_have_the_verdicts_of_single_ones() -> None:
    frequency = np.array([0.98, 1.0, 1.02]) * (SLOW + FAST)
    single = [ROD.stability(LOAD.varied("frequency", at)) for at in frequency.tolist()]
    assert ROD.verdicts(mean=0.0, amplitude=AMPLITUDE, frequency=frequency).tolist() == [
        int(each.status == "stable") for each in single
    ]
    growth, mode = ROD.growth_rate(mean=0.0, amplitude=AMPLITUDE, frequency=frequency, return_mode=True)
    assert growth == pytest.approx([each.growth_rate for each in single], rel=1e-9)
    assert mode.tolist() == [0, -1, 0]


def test_a_map() -> None:
    ends = 0.99 * (SLOW + FAST), 1.01 * (SLOW + FAST), 5
    chart = fr.stability_map(ROD, mean=0.0, amplitude=(0.0, AMPLITUDE, 3), frequency=ends, growth=True)
    assert chart.stable[:, 2].tolist() == [True, False, False]
    assert chart.stable[:, [0, 4]].all()
    assert chart.growth_rate is not None
    assert chart.growth_rate[:, 2] == pytest.approx([0.0, sum_growth(0.5 * AMPLITUDE), sum_growth(AMPLITUDE)], rel=0.02)


def test_ranges_and_margins_end_where_the_tongue_does() -> None:
    """To first order, of half the width 2 sigma with sigma the growth in its middle."""
    around = 0.98 * (SLOW + FAST), 1.02 * (SLOW + FAST)
    found = ROD.ranges("frequency", mean=0.0, amplitude=AMPLITUDE, bounds=around)
    below, above = found
    assert (above.low - below.high) == pytest.approx(4.0 * sum_growth(AMPLITUDE), rel=0.02)
    assert str(below.high_end) == "sum resonance of modes 1 and 2, order 1"
    (band,) = found.unstable
    assert band.worst_growth == pytest.approx(sum_growth(AMPLITUDE), rel=0.02)
    margin = ROD.stability(LOAD).margin("frequency", seconds=1.0)
    assert LOAD.frequency + margin.above == pytest.approx(above.low, rel=1e-8)
    assert LOAD.frequency - margin.below == pytest.approx(below.high, rel=1e-8)


def test_the_mean_force_that_buckles_is_that_of_the_closed_form() -> None:
    assert ROD.critical("mean", amplitude=0.0, frequency=1.0) == pytest.approx(buckling(), rel=1e-8)


@pytest.mark.slow
def test_the_probability_of_instability_is_the_share_of_the_range() -> None:
    around = 0.99 * (SLOW + FAST), 1.01 * (SLOW + FAST)
    below, above = ROD.ranges("frequency", mean=0.0, amplitude=AMPLITUDE, bounds=around)
    share = (above.low - below.high) / (around[1] - around[0])
    found = fr.probability_of_instability(ROD, LOAD, {"frequency": around}, samples=2000, seed=1)
    assert found.interval[0] <= share <= found.interval[1]
    lengths, load = (0.999 * ROD.length, 1.001 * ROD.length), LOAD.varied("frequency", SLOW + FAST)
    rods = fr.probability_of_instability(ROD, load, {"length": lengths}, samples=20, seed=1)
    levels = np.random.default_rng(np.random.SeedSequence(1).spawn(2)[0]).random(20)
    each = [ROD.replace(length=lengths[0] + (lengths[1] - lengths[0]) * u).stability(load).status for u in levels]
    assert 20 > rods.unstable == each.count("unstable") > 0


def test_the_terminal_prints_its_report() -> None:
    """What `floquetrod check` prints, in the units asked for, and its JSON."""
    found = ROD.stability(LOAD)
    text = str(found.report({"frequency": "Hz"}))
    assert text.startswith("UNSTABLE: sum resonance of modes 1 and 2, order 1; tenfold in ")
    assert f"growth    {found.growth_rate:.6g} 1/s" in text
    numbers = found.as_dict()
    assert (numbers["status"], numbers["unstable_modes"]) == ("unstable", [1, 2])
    assert numbers["resonances"][0]["growth_rate_per_s"] == found.growth_rate


@pytest.mark.slow
@pytest.mark.parametrize("prompt", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_the_explorer_shows_what_the_model_tells(prompt: bool, monkeypatch: pytest.MonkeyPatch, tuned: Tuned) -> None:
    """The map follows the sliders where verdicts are prompt; neither kind has bands or a place among the tongues."""
    monkeypatch.setattr(SpringModel, "prompt", prompt)
    tuned(points_of_a_chart=(24, 24), cells_of_a_growing_map=(24, 24), frequencies_of_a_line=(3, 5))
    found = ROD.stability(LOAD)
    shown = View(ROD, LOAD, {"mean": (0.0, 1.0), "amplitude": (0.0, 1.0), "frequency": (0.5 * SLOW, 2.0 * FAST)})
    assert shown.panels == ("line", "shape")
    parts = shown.at_once(LOAD)
    assert parts["verdict"].startswith(f"unstable: growth at {found.growth_rate:.3g}" if prompt else "being judged")
    assert ((parts["map"].cells != UNKNOWN) == prompt).all()
    for each in shown.in_time(LOAD, lambda: False):
        parts |= each
    assert parts["verdict"].startswith("unstable: sum resonance of modes 1 and 2, order 1, at")
    assert parts["shape"].deflection == pytest.approx(found.shape.deflection)
    monkeypatch.delattr(TwoModes, "shapes")  # a model need not say how its coordinates bend the rod
    assert list(shown.modes.first(LOAD, ROD.stability(LOAD), lambda: False))[-1] == {"shape": None}
    assert parts["line"].growth[-1] == ROD.growth_rate(mean=LOAD.mean, amplitude=LOAD.amplitude, frequency=2.0 * FAST)
    assert (parts["map"].cells != UNKNOWN).all()
    assert parts["margin"] == ("amplitude", found.amplitude_margin)


def test_what_the_model_cannot_do_it_refuses() -> None:
    for question in (
        lambda: ROD.stability(LOAD, friction=0.1, kick=0.05),
        lambda: ROD.critical_kick(LOAD, friction=0.1),
        lambda: ROD.certify(mean=0.0, amplitude=AMPLITUDE, frequency=SLOW),
        lambda: ROD.largest_safe_box(LOAD),
        lambda: ROD.modal_system(mean=[0.0], amplitude=AMPLITUDE, frequency=SLOW),
    ):
        with pytest.raises(ValueError, match="a spring between the modes"):
            question()


ASKED = ("has_mathieu_modes", "are_modes_apart", "IndependentModel", "CoupledModel")
"""What nobody asks but the models themselves, and the one place that chooses."""

MODELS = {
    "rod/modes/independent.py",
    "rod/modes/coupled.py",
    "rod/modes/noisy_coupled.py",
    "rod/modes/one_harmonic.py",
    "rod/rod.py",
    "rod/answers/rod_stability.py",
    "__init__.py",
}


@pytest.mark.slow
def test_nobody_asks_which_model_it_has() -> None:
    for path in PACKAGE.rglob("*.py"):
        name = path.relative_to(PACKAGE).as_posix()
        text = path.read_text(encoding="utf-8")
        if name not in MODELS:
            assert not [word for word in ASKED if re.search(rf"\b{word}\b(?!\")", text)], name
        assert not re.search(r"isinstance\([^()]*RodStability", text), name
