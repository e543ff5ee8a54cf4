"""The explorer: what it shows is the verdict, and it follows its sliders."""

from __future__ import annotations

import itertools
import math
import shlex
import time
from collections.abc import Iterator
from pathlib import Path
from types import MappingProxyType

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.backend_bases import ResizeEvent

import floquetrod as fr
from floquetrod import cli, units
from floquetrod.explorer import commands, limits, portions
from floquetrod.explorer.background import Background, Stale, ViewParts
from floquetrod.explorer.verdict_words import margin_words
from floquetrod.explorer.view import View
from floquetrod.floquet.margins import Margin
from floquetrod.floquet.status import STATUS_CODES
from floquetrod.plotting import explorer_panels as panels
from tests.inside import Loads
from tests.seams import Tuned

mpl.use("Agg")
ROD = fr.Rod.nitinol()
UNIT = ROD.critical_force
TUBE = fr.Rod(
    207e9,
    7850.0,
    diameter=50.8e-3,
    wall_thickness=3.96e-3,
    length=60.0,
    channel_diameter=0.124,
    fluid_inside=1000.0,
    fluid_outside=1000.0,
)
STEEL = fr.Rod(207e9, 7850.0, radius=1.5e-3, length=6.0, channel_radius=6e-3)
SHORT = fr.Rod(207e9, 7850.0, radius=5e-3, length=1.0, channel_radius=8e-3)
CLAMPED = ROD.replace(ends="clamped")


@pytest.fixture(autouse=True)
def closed() -> Iterator[None]:
    yield
    pyplot.close("all")


@pytest.fixture
def explorer() -> fr.Explorer:
    return fr.Explorer(ROD, fr.AxialLoad(0.2 * UNIT, 0.2 * UNIT, 150.0))


@pytest.fixture
def coarse(tuned: Tuned) -> None:
    """Look at fewer loads of coupled modes."""
    tuned(
        cells_of_a_growing_map=(8, 8),
        coarsenings_of_a_growing_map=(4, 1),
        frequencies_of_a_line=(3, 5),
        modes_told_as_few=0,
    )


def pixels(explorer: fr.Explorer) -> np.ndarray:
    return np.asarray(explorer.window.figure.canvas.buffer_rgba()).copy()


@pytest.mark.slow
def test_what_is_shown_at_once_and_in_time_is_the_verdict(explorer: fr.Explorer) -> None:
    sliders = explorer.window.sliders
    ends = limits.Scale.of(ROD).limits(explorer.load)
    shown = View(ROD, explorer.load, ends)
    for mean, amplitude, omega in ((0.34, 0.2, 150.0), (0.8, 0.6, 60.0)):
        for name, value in (("mean", mean * UNIT), ("amplitude", amplitude * UNIT), ("frequency", omega)):
            sliders[name].set_val(value)
        verdict = ROD.stability(explorer.load)
        parts = shown.at_once(explorer.load)
        assert parts["verdict"].startswith(verdict.status)
        assert explorer.window.words["verdict"] == parts["verdict"]
        rates = verdict.mode_growth_rates
        count = min(len(rates), parts["rates"].growth.size)
        assert parts["rates"].growth[:count] == pytest.approx(rates[:count], rel=1e-8, abs=1e-12)
        assert parts["modes"].ratio[:count] ** 2 == pytest.approx(np.abs(verdict.system.beta[:count]))
        found = {name: part for each in shown.in_time(explorer.load, lambda: False) for name, part in each.items()}
        assert found["verdict"] == parts["verdict"]
        # The bands hold the points that are unstable.
        cells = found["map"].cells
        for row, column in ((3, 5), (90, 100), (170, 230)):
            force = np.linspace(*ends["mean"], cells.shape[0])[row]
            at = np.linspace(*ends["frequency"], cells.shape[1])[column]
            assert (cells[row, column] == STATUS_CODES["stable"]) == ROD.is_stable(
                mean=force, amplitude=explorer.load.amplitude, frequency=at
            )


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


@pytest.mark.slow
def test_sliders_and_axes_speak_the_units_asked_for() -> None:
    shown = fr.Explorer(ROD, fr.AxialLoad(0.2 * UNIT, 0.3, 150.0), {"mean": "Fcr", "frequency": "Hz"})
    sliders, hertz = shown.window.sliders, 2.0 * math.pi
    labels = [sliders[name].label.get_text() for name in ("mean", "amplitude", "frequency")]
    assert [label.rpartition(" / ")[2] for label in labels] == [r"$F_\mathrm{cr}$", "N", "Hz"]
    area = shown.window.figure.axes[0]
    assert (area.get_xlabel(), area.get_ylabel()) == (labels[2], labels[0])
    assert area.get_xlim() == pytest.approx((sliders["frequency"].valmin, sliders["frequency"].valmax))
    assert area.lines[0].get_xydata()[0].tolist() == pytest.approx([150.0 / hertz, 0.2])
    sliders["frequency"].set_val(30.0)
    assert shown.load.frequency == pytest.approx(30.0 * hertz)
    assert shown.load.mean == 0.2 * UNIT  # to the bit: it has not been moved
    assert area.lines[0].get_xydata()[0].tolist() == pytest.approx([30.0, 0.2])


@pytest.mark.parametrize(
    ("units", "message"),
    [({"mean": "Hz"}, r"units\['mean'\] must be a unit of force"), ({"f": "Hz"}, "units must be of mean")],
)
def test_units_that_are_none(units: dict[str, str], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        fr.Explorer(ROD, None, units)


@pytest.mark.slow
def test_units_are_any_mapping() -> None:
    shown = fr.Explorer(ROD, None, MappingProxyType({"frequency": "Hz"}))
    assert "Hz" in shown.window.sliders["frequency"].label.get_text()
    for wrong in ("Hz", 0, [("mean", "N")]):
        with pytest.raises(TypeError, match="units must be a mapping"):
            fr.Explorer(ROD, None, wrong)  # type: ignore[arg-type]


@pytest.mark.slow
def test_a_canvas_that_keeps_no_copies_will_do(explorer: fr.Explorer) -> None:
    from matplotlib.backend_bases import FigureCanvasBase

    explorer.window.figure.canvas.draw()
    FigureCanvasBase(explorer.window.figure)  # what is left of it in a notebook once it has been shown
    explorer.window.sliders["mean"].set_val(0.34 * UNIT)
    assert explorer.load.mean == pytest.approx(0.34 * UNIT)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:omega L")
@pytest.mark.parametrize("rod", [TUBE, *(pytest.param(rod, marks=pytest.mark.slow) for rod in (STEEL, SHORT))])
def test_axes_follow_the_rod(rod: fr.Rod) -> None:
    shown = fr.Explorer(rod)
    sliders = shown.window.sliders
    for mean, frequency in ((0.1, 0.1), (0.9, 0.9), (0.95, 0.02)):
        for name, share in (("mean", mean), ("frequency", frequency)):
            slider = sliders[name]
            slider.set_val(slider.valmin + share * (slider.valmax - slider.valmin))
        verdict = rod.stability(shown.load)
        assert shown.window.words["verdict"].startswith(verdict.status)
        chart = shown.window.figure.axes[1]
        x, y = chart.lines[0].get_data()
        (left, right), (bottom, top) = chart.get_xlim(), chart.get_ylim()
        assert ((left <= x) & (x <= right) & (bottom <= y) & (y <= top)).all()
        assert verdict.fastest_mode is None or verdict.fastest_mode <= len(x)


def test_the_axis_of_natural_frequencies_and_back() -> None:
    ratio = np.array([-300.0, -2.0, -0.5, 0.0, 1.0, 2.0, 2.1, 59.0])
    places = panels.straightened(ratio)
    assert (np.diff(places) > 0.0).all()
    assert panels.straightened(places, back=True) == pytest.approx(ratio)


@pytest.mark.parametrize(("value", "top"), [(0.0, 1.0), (1.0, 2.0), (4.9, 5.0), (5.0, 10.0), (137.0, 200.0)])
def test_axes_grow_in_steps(value: float, top: float) -> None:
    assert panels.fitting(value, 0.0) == pytest.approx(top)
    assert panels.fitting(value, 3.0 * top) == 3.0 * top
    assert value == 0.0 or panels.fitting(value, 30.0 * top) == pytest.approx(top)


@pytest.mark.slow
def test_the_default_load_is_in_the_middle_of_things() -> None:
    shown = fr.Explorer(ROD)
    assert math.isclose(shown.load.frequency, 3.0 * ROD.pendulum_frequency, rel_tol=5e-3)
    assert (shown.load.mean, shown.load.frequency) == (0.339, 150.0)
    first = fr.Explorer(SHORT, None, {"frequency": "Hz"}).load
    assert first.frequency == pytest.approx(3.0 * SHORT.natural_frequency(1), rel=5e-3)
    # The force of a short rod is what buckles it: all of it leaves nothing of the first mode's frequency.
    system = SHORT.modal_system(fr.AxialLoad(limits.Scale.of(SHORT).force, 0.0, 1.0), modes=(1,))
    assert abs(system.beta[0]) < 1e-9 * SHORT.natural_frequency(1) ** 2


@pytest.mark.slow
def test_sliders_reach_the_load_given_and_stand_at_round_numbers() -> None:
    load = fr.AxialLoad(-3.0, 9.0, 2.0)
    shown = fr.Explorer(ROD, load)
    assert shown.load == load
    for name, slider in shown.window.sliders.items():
        assert slider.valmin <= getattr(load, name) <= slider.valmax
        assert f"{slider.valstep:e}"[0] in "125"
    slider = shown.window.sliders["frequency"]
    slider.set_val(slider._stepped_value(100.0001))
    assert shown.command.endswith("--frequency 100rad/s")


@pytest.mark.slow
def test_coupled_modes_show_growth_over_frequency_and_the_shape(coarse: None) -> None:
    load = fr.AxialLoad(0.9 * UNIT, 0.5 * UNIT, 125.0)
    shown = fr.Explorer(CLAMPED, load, {"frequency": "Hz"})
    assert shown.window.words["verdict"] == "being judged ..."
    shown.refine()
    verdict = CLAMPED.stability(load)
    assert shown.window.words["verdict"].startswith(f"{verdict.status}: {verdict.resonances[0]}")
    chart, line, shape = shown.window.figure.axes[:3]
    frequency, growth = line.lines[0].get_data()
    expected = CLAMPED.growth_rate(load, frequency=2.0 * math.pi * frequency)
    assert growth == pytest.approx(expected, rel=1e-9, abs=1e-12)
    assert shape.lines[0].get_ydata() == pytest.approx(verdict.shape.deflection)
    cells = np.asarray(chart.images[0].get_array())
    assert set(np.unique(cells)) <= set(STATUS_CODES.values())
    (left, right), (low, high) = chart.get_xlim(), chart.get_ylim()
    for row, column in ((1, 1), (5, 3), (7, 7)):
        at = left + (column + 0.5) * (right - left) / 8, low + (row + 0.5) * (high - low) / 8
        stable = CLAMPED.is_stable(load, mean=at[1], frequency=2.0 * math.pi * at[0])
        assert (cells[row, column] == STATUS_CODES["stable"]) == stable
    # Another amplitude: nothing of the old map stays.
    shown.window.sliders["amplitude"].set_val(0.3)
    assert (np.asarray(chart.images[0].get_array()) == panels.UNKNOWN).all()


def test_loads_that_cannot_be_judged_are_shown_so() -> None:
    # A quarter wave of the rod: without damping the axial wave is infinite.
    resonant = 0.5 * math.pi * ROD.wave_speed / ROD.length
    load = fr.AxialWave(0.2, 0.1, resonant)
    shown = View(ROD, load, limits.Scale.of(ROD).limits(load))
    assert next(shown.in_time(load, lambda: False))["verdict"].startswith("no verdict: frequency")
    status, growth = portions.statuses_and_rates(shown.model, Loads.single(load))
    assert (status.tolist(), np.isnan(growth).tolist()) == ([-1], [True])


@pytest.mark.slow
@pytest.mark.parametrize(
    "load",
    [
        fr.AxialLoad(0.3, 0.1, 100.0, waveform=(-1j, 0.0, -0.3j)),
        pytest.param(fr.AxialWave(0.3, 0.1, 100.0, far_end="free", axial_damping=2.0), marks=pytest.mark.slow),
    ],
)
def test_loads_of_every_kind(load: fr.AxialLoad | fr.AxialWave) -> None:
    shown = fr.Explorer(ROD, load)
    shown.window.sliders["mean"].set_val(0.4)
    assert shown.load == load.varied("mean", 0.4)
    assert next(shown._in_time(lambda: False))["verdict"].startswith(ROD.stability(shown.load).status)


@pytest.mark.slow
def test_without_the_weight_along_it_an_inclined_rod_has_independent_modes() -> None:
    rod = ROD.replace(inclination=1.0)
    load = fr.AxialLoad(0.3, 0.1, 100.0, mean_at=None)
    shown = fr.Explorer(rod, load)
    shown.window.sliders["mean"].set_val(0.4)
    assert shown.load.mean_at is None
    assert shown.window.words["verdict"].startswith(rod.stability(shown.load).status)
    assert "--mean-at none" in commands.command(rod, shown.load, shown._units, ["--rod", "x.toml"])


@pytest.mark.slow
def test_the_command_gives_the_same_verdict(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "my rod.toml"
    path.write_text(
        'youngs_modulus = "68GPa"\ndensity = 6450.0\nradius = "0.8mm"\nlength = 3.0\nchannel_radius = 0.01\n'
    )
    rod = fr.Rod.from_toml(path)
    given = {"mean": "lbf", "amplitude": "Fcr", "frequency": "rpm"}
    shown = fr.Explorer(rod, fr.AxialLoad(0.1, 0.2, 87.654321), given, options=["--rod", str(path)])
    for move in ((), ("mean", 0.077), ("amplitude", 0.123), ("frequency", 1234.5), ("mean", 0.0)):
        if move:
            shown.window.sliders[move[0]].set_val(move[1])
        program, *arguments = shlex.split(shown.command)
        assert program == "floquetrod"
        assert cli.main([*arguments, "--json", "--no-margins"]) == 0
        answer = capsys.readouterr().out
        rate = rod.stability(shown.load).growth_rate
        assert f'"growth_rate_per_s": {rate!r}' in answer
    python = fr.Explorer(rod).command
    assert repr(eval(python, {"rod": rod, "fr": fr})) == repr(rod.stability(fr.Explorer(rod).load))


def test_the_command_names_the_kind_of_load() -> None:
    shown = {name: units.unit("", name, kind) for name, kind in (("mean", "force"), ("frequency", "frequency"))}
    wave = fr.AxialWave(-1.0, 0.1, 9.0, mean_at=0.25, far_end="free", axial_damping=0.1)
    expected = "floquetrod check --rod nitinol --damping-rate 0.5 --mean-at 0.25 --wave free --axial-damping 0.1 "
    damped = ROD.replace(damping_rate=0.5)
    assert commands.command(damped, wave, shown, None) == expected + "--mean=-1N --frequency 9rad/s"
    square = fr.AxialLoad(1.0, 0.1, 9.0, waveform=(-1j, 0.0, -0.3j))
    assert commands.command(ROD, square, shown, None) == f"rod.stability(fr.{square!r})"
    assert "--force record.csv" in commands.command(ROD, square, shown, ["--rod", "a", "--force", "record.csv"])


def test_margins_in_words() -> None:
    verdict = ROD.stability(fr.AxialLoad(0.34 * UNIT, 0.2 * UNIT, 150.0))
    shown = {"mean": units.unit("N", "mean", "force"), "frequency": units.unit("Hz", "frequency", "frequency")}
    words = margin_words(
        {"mean": verdict.mean_force_margin, "frequency": Margin(math.inf, math.inf)}, verdict.load, shown
    )
    low = verdict.load.mean - verdict.mean_force_margin.below
    assert words.startswith(f"same verdict for mean {low:.4g} to ")
    assert words.endswith(" N, any frequency in reach")


def test_the_latest_job_replaces_the_others() -> None:
    background, told = Background(), []

    def endless(stale: Stale) -> Iterator[ViewParts]:
        while not stale():
            yield {"old": 1}
            time.sleep(0.001)
        told.append("ended")

    def short(stale: Stale) -> Iterator[ViewParts]:
        yield {"new": 1}

    def failing(stale: Stale) -> Iterator[ViewParts]:
        raise ArithmeticError("no")
        yield {}

    def waited() -> list[ViewParts]:
        found, busy = [], True
        while busy:
            parts, busy = background.fetch()
            found += parts
        return found

    background.start(endless)
    background.start(short)
    assert waited() == [{"new": 1}]
    background.start(failing)
    with pytest.raises(ArithmeticError, match="no"):
        waited()
    background.start(endless)
    assert list(background.run(short)) == [{"new": 1}]  # waits until the other has ended
    assert background.fetch() == ([], False)
    background.stop()


@pytest.mark.slow
def test_the_picture_without_a_window(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "explorer.png"
    load = ["--mean", "0.2Fcr", "--amplitude", "0.2Fcr", "--frequency", "150"]
    assert cli.main(["explore", "--rod", "nitinol", *load, "--out", str(path)]) == 0
    assert path.read_bytes().startswith(b"\x89PNG")
    out = capsys.readouterr().out
    load, verdict, command, written = out.splitlines()
    assert load.startswith("mean 0.2 Fcr (0.3392 N), amplitude 0.2 Fcr")
    assert "mode 7 grows" in verdict
    assert command == "floquetrod check --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr --frequency 150rad/s"
    assert written == f"written: {path}"
    assert not pyplot.get_fignums()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--mean", "1N"], "go together; got only --mean"),
        (["--out", "x.gif"], "--out must end in .png, .pdf or .svg"),
        ([], "no window can be opened"),
        (["--port", "80"], "--port needs --web"),
        (["--open"], "--open needs --web"),
        (["--web", "--port", "70000"], "--port must lie between 0 and 65535, got 70000"),
        (["--web", "--out", "x.png"], "--out writes a picture and opens no page"),
    ],
)
def test_bad_input(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["explore", "--rod", "nitinol", *arguments]) == 2
    assert message in capsys.readouterr().err


OTHER_SIZES = (3.9, 10.14), (7.9, 10.14), (8.0, 5.6)


@pytest.mark.slow
@pytest.mark.parametrize(
    "size", [(3.2, 10.14), *(pytest.param(size, marks=pytest.mark.slow) for size in ((11.0, 7.0), *OTHER_SIZES))]
)
def test_nothing_is_cut_off_or_overlaps_on_a_screen_or_a_phone(size: tuple[float, float]) -> None:
    explorer = fr.Explorer(ROD)
    explorer.refine()
    window = explorer.window
    figure = window.figure
    figure.set_size_inches(*size)
    figure.canvas.callbacks.process("resize_event", ResizeEvent("resize_event", figure.canvas))
    figure.canvas.draw()
    (modes,) = (ax for ax in window._areas if ax.get_title() == "modes among resonance tongues")
    low, high = modes.get_xlim()
    assert sum(low <= tick <= high for tick in modes.get_xticks()) == len(modes.get_xticks()) > 2
    renderer = figure.canvas.get_renderer()
    boxes = {name: text.get_window_extent(renderer) for name, text in window._texts.items() if text.get_text()}
    for number, ax in enumerate(window._areas):
        boxes |= {f"{part} {number}": getattr(ax, part).get_window_extent(renderer) for part in ("title", "patch")}
        boxes |= {f"{a} {number}": getattr(ax, a).label.get_window_extent(renderer) for a in ("xaxis", "yaxis")}
        low, high = ax.get_xlim()
        ticks = [tick for tick in ax.get_xticklabels() if low <= tick.get_position()[0] <= high]
        boxes |= {f"tick {tick.get_text()} of {number}": tick.get_window_extent(renderer) for tick in ticks}
    for name, slider in window.sliders.items():
        boxes |= {f"{part} {name}": getattr(slider, part).get_window_extent(renderer) for part in ("label", "valtext")}
        boxes[f"slider {name}"] = slider.ax.get_window_extent(renderer)
    for name, box in boxes.items():
        assert min(box.x0, box.y0) >= 0.0, name
        assert box.x1 <= figure.bbox.width, name
        assert box.y1 <= figure.bbox.height, name
    for (one, box), (other, beside) in itertools.combinations(boxes.items(), 2):
        assert not box.padded(-1.0).overlaps(beside.padded(-1.0)), (one, other)
