"""The explorer: what it shows is the verdict, and it follows its sliders."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from types import MappingProxyType

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot

import floquetrod as fr
from floquetrod import cli
from floquetrod.plotting import explorer as window

mpl.use("Agg")
ROD = fr.Rod.nitinol()
UNIT = ROD.critical_force


@pytest.fixture
def explorer() -> Iterator[fr.Explorer]:
    yield fr.Explorer(ROD, fr.AxialLoad(0.2 * UNIT, 0.2 * UNIT, 150.0))
    pyplot.close("all")


def pixels(explorer: fr.Explorer) -> np.ndarray:
    return np.asarray(explorer.window.figure.canvas.buffer_rgba()).copy()


def test_a_view_is_the_verdict(explorer: fr.Explorer) -> None:
    for mean, amplitude, omega in ((0.2, 0.2, 150.0), (0.34, 0.2, 150.0), (0.8, 0.6, 60.0)):
        view = explorer.view({"mean": mean * UNIT, "amplitude": amplitude * UNIT, "frequency": omega})
        verdict = ROD.stability(explorer.load)
        assert view.verdict.startswith("stable" if verdict.stable else "unstable")
        rates = verdict.mode_growth_rates
        count = min(len(rates), view.growth.size)
        assert view.growth[:count] == pytest.approx(rates[:count], rel=1e-8, abs=1e-12)
        limits = explorer.window.sliders["mean"].valmax, explorer.window.sliders["frequency"].valmax
        assert bool(view.unstable[-1, -1]) != ROD.is_stable(limits[0], amplitude * UNIT, limits[1])


def test_the_window_follows_its_sliders(explorer: fr.Explorer) -> None:
    explorer.window.figure.canvas.draw()
    before = pixels(explorer)
    explorer.window.sliders["mean"].set_val(0.34 * UNIT)
    assert explorer.load.mean == pytest.approx(0.34 * UNIT)
    after = pixels(explorer)
    assert (before != after).any()
    # What was drawn over the kept copy is what a full drawing would show.
    explorer.window.figure.canvas.draw()
    assert np.array_equal(after, pixels(explorer))


def test_sliders_and_axes_speak_the_units_asked_for() -> None:
    shown = fr.Explorer(ROD, fr.AxialLoad(0.2 * UNIT, 0.3, 150.0), {"mean": "Fcr", "frequency": "Hz"})
    sliders, hertz = shown.window.sliders, 2.0 * math.pi
    values = [sliders[name].val for name in ("mean", "amplitude", "frequency")]
    assert values == pytest.approx([0.2, 0.3, 150.0 / hertz])
    labels = [sliders[name].label.get_text() for name in ("mean", "amplitude", "frequency")]
    assert [label.rpartition(" / ")[2] for label in labels] == [r"$F_\mathrm{cr}$", "N", "Hz"]
    area = shown.window.figure.axes[0]
    assert (area.get_xlabel(), area.get_ylabel()) == (labels[2], labels[0])
    assert area.get_xlim() == pytest.approx((sliders["frequency"].valmin, sliders["frequency"].valmax))
    assert area.lines[0].get_xydata()[0].tolist() == pytest.approx([150.0 / hertz, 0.2])
    sliders["frequency"].set_val(30.0)
    assert shown.load.frequency == pytest.approx(30.0 * hertz)
    assert shown.load.mean == pytest.approx(0.2 * UNIT)
    assert area.lines[0].get_xydata()[0].tolist() == pytest.approx([30.0, 0.2])
    pyplot.close("all")


@pytest.mark.parametrize(
    ("units", "message"),
    [({"mean": "Hz"}, r"units\['mean'\] must be a unit of force"), ({"f": "Hz"}, "units must be of mean")],
)
def test_units_that_are_none(units: dict[str, str], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fr.Explorer(ROD, None, units)


def test_units_are_any_mapping() -> None:
    shown = fr.Explorer(ROD, None, MappingProxyType({"frequency": "Hz"}))
    assert "Hz" in shown.window.sliders["frequency"].label.get_text()
    pyplot.close("all")
    for wrong in ("Hz", 0, [("mean", "N")]):
        with pytest.raises(TypeError, match="units must be a mapping"):
            fr.Explorer(ROD, None, wrong)  # type: ignore[arg-type]


def test_a_canvas_that_keeps_no_copies_will_do(explorer: fr.Explorer) -> None:
    from matplotlib.backend_bases import FigureCanvasBase

    explorer.window.figure.canvas.draw()
    FigureCanvasBase(explorer.window.figure)  # what is left of it in a notebook once it has been shown
    explorer.window.sliders["mean"].set_val(0.34 * UNIT)
    assert explorer.load.mean == pytest.approx(0.34 * UNIT)


def test_a_damped_rod_of_its_own() -> None:
    rod = ROD.replace(length=10.0, damping_rate=3.0)
    shown = fr.Explorer(rod)
    verdict = rod.stability(shown.load)
    assert (
        shown.view(
            {"mean": shown.load.mean, "amplitude": shown.load.amplitude, "frequency": shown.load.frequency}
        ).verdict
        == "stable"
    ) == verdict.stable
    pyplot.close("all")


@pytest.mark.parametrize(("value", "step"), [(0.0, 1.0), (1.0, 2.0), (4.9, 5.0), (5.0, 10.0), (137.0, 200.0)])
def test_axes_grow_in_steps(value: float, step: float) -> None:
    assert window._step_above(value) == step


def test_the_picture_without_a_window(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "explorer.png"
    load = ["--mean", "0.2Fcr", "--amplitude", "0.2Fcr", "--frequency", "150"]
    assert cli.main(["explore", "--rod", "nitinol", *load, "--out", str(path)]) == 0
    assert path.read_bytes().startswith(b"\x89PNG")
    out = capsys.readouterr().out
    assert "mode 7 grows" in out
    assert out.splitlines()[1].startswith("mean 0.2 Fcr (0.3392 N), amplitude 0.2 Fcr")
    assert not pyplot.get_fignums()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--mean", "1N"], "go together; got only --mean"),
        (["--out", "x.gif"], "--out must end in .png, .pdf or .svg"),
        ([], "no window can be opened"),
    ],
)
def test_bad_input(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["explore", "--rod", "nitinol", *arguments]) == 2
    assert message in capsys.readouterr().err
    pyplot.close("all")


def test_the_default_load_is_in_the_middle_of_things() -> None:
    shown = fr.Explorer(ROD)
    assert math.isclose(shown.load.frequency, 3.0 * ROD.pendulum_frequency)
    pyplot.close("all")
