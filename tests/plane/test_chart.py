"""Charts: the same verdicts as everywhere else, saved and loaded whole, drawn with labels."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import IO

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot

import floquetrod as fr
from floquetrod.equations import Equation
from tests.conftest import depth
from tests.drawn import note

mpl.use("Agg")

ROD = fr.Rod.nitinol()
FCR = ROD.critical_force


def small_map(growth: bool = True) -> fr.Chart:
    """Return a map of the reference rod."""
    return fr.stability_map(
        ROD, mean=(0.0, 1.1 * FCR, 12), amplitude=0.2 * FCR, frequency=(20.0, 200.0, 17), growth=growth
    )


def test_a_rod_map_is_its_array_of_verdicts() -> None:
    chart = small_map()
    mean, omega = np.meshgrid(chart.y.values, chart.x.values, indexing="ij")
    assert chart.stable.shape == (12, 17)
    assert np.array_equal(chart.stable, ROD.is_stable(mean=mean, amplitude=0.2 * FCR, frequency=omega))
    assert np.array_equal(chart.growth_rate, ROD.growth_rate(mean=mean, amplitude=0.2 * FCR, frequency=omega))
    assert chart.first_mode is not None
    assert np.array_equal(chart.first_mode > 0, ~chart.stable)
    assert "amplitude 0.339206 N, critical force 1.69603 N" in chart.caption
    assert repr(chart).startswith("<mean force over frequency; rod, amplitude")


@pytest.mark.parametrize("fixed", ["mean", "amplitude", "frequency"])
def test_any_two_axes(fixed: str) -> None:
    load = {"mean": (0.0, FCR, 4), "amplitude": np.linspace(0.0, 0.5, 5) * FCR, "frequency": (20.0, 200.0, 6)}
    load[fixed] = 150.0 if fixed == "frequency" else 0.3 * FCR
    chart = fr.stability_map(ROD, **load)
    assert chart.stable.shape == (chart.y.values.size, chart.x.values.size)
    assert fixed not in (chart.x.name.removesuffix(" force"), chart.y.name.removesuffix(" force"))


def test_an_equation_chart_is_its_array_of_verdicts() -> None:
    chart = fr.mathieu.chart((0.0, 3.0, 30), (-2.0, 0.5, 20), growth=True)
    assert np.array_equal(chart.stable, fr.mathieu.is_stable(chart.x.values, chart.y.values[:, None]))
    tolerant = fr.mathieu.chart((0.0, 3.0, 30), (-2.0, 0.5, 20), growth_tolerance=0.022)
    assert tolerant.growth_rate is None
    assert (tolerant.stable & ~chart.stable).any()
    assert not (chart.stable & ~tolerant.stable).any()


@pytest.mark.parametrize(
    ("family", "kind"),
    [
        (fr.Meissner, "Meissner's equation (square wave)"),
        (lambda a, b, c: fr.Hill(b, sines=(a, 0.4 * a), cosines=(0.2 * a,), damping=c), "Hill's equation"),
    ],
)
@pytest.mark.parametrize("damping", [0.1, pytest.param(0.0, marks=pytest.mark.slow)])
def test_charts_of_other_equations(
    family: Callable[[float, float, float], Equation], kind: str, damping: float
) -> None:
    points = (0.1, 3.0, depth(9, 5)), (-2.0, 0.5, depth(8, 4))
    chart = fr.mathieu.chart(*points, damping, equation=family, growth=True)
    assert chart.caption.startswith(f"{kind}, damping")
    assert chart.undecided == 0
    assert chart.growth_rate is not None
    for row, beta in enumerate(chart.y.values):
        for column, alpha in enumerate(chart.x.values):
            expected = fr.stability(family(float(alpha), float(beta), damping), method="reference", digits=30)
            assert chart.stable[row, column] == expected.stable
            assert chart.growth_rate[row, column] == pytest.approx(expected.growth_rate, rel=1e-8, abs=1e-12)
    tolerant = fr.mathieu.chart(*points, damping, equation=family, growth_tolerance=0.3)
    assert np.array_equal(tolerant.stable, chart.stable | (chart.growth_rate <= 0.3))


def test_an_error_of_the_equation_names_the_point() -> None:
    def family(alpha: float, beta: float, damping: float) -> fr.Meissner:
        return fr.Meissner(alpha, beta / (1.0 - alpha), damping)

    with pytest.raises(ValueError, match=r"equation\(alpha=1, beta=-1\) raised ZeroDivisionError"):
        fr.mathieu.chart((0.0, 2.0, 3), (-1.0, 0.0, 2), equation=family)


def test_undecided_points_are_counted_and_not_called_stable() -> None:
    # alpha = 4, beta = -5: the square wave's discriminant touches 2 without crossing.
    chart = fr.mathieu.chart((3.0, 4.0, 2), (-5.0, -4.0, 2), equation=fr.Meissner)
    decided = fr.stability(fr.Meissner(4.0, -5.0)).status != "undecided"
    assert chart.undecided == (0 if decided else 1)
    assert chart.stable[0, 1] == decided
    assert ("1 undecided" in chart.caption) != decided


def test_a_map_takes_a_damping_rate() -> None:
    load = {"mean": (0.0, 1.1 * FCR, 12), "amplitude": 0.2 * FCR, "frequency": (20.0, 200.0, 17)}
    damped = fr.stability_map(ROD, damping=2.0, **load)
    assert np.array_equal(damped.stable, fr.stability_map(ROD.replace(damping_rate=2.0), **load).stable)
    assert damped.subject["rod"]["damping_rate"] == 2.0
    assert damped.stable.sum() > small_map().stable.sum()


def test_progress_and_blocks() -> None:
    seen: list[tuple[int, int]] = []
    chart = fr.mathieu.chart(
        (0.0, 3.0, 3000), (-2.0, 0.5, 200), progress=lambda done, total: seen.append((done, total))
    )
    assert seen[-1] == (600_000, 600_000)
    assert len(seen) > 1
    assert np.array_equal(chart.stable[::50], fr.mathieu.is_stable(chart.x.values, chart.y.values[::50, None]))


@pytest.mark.parametrize("growth", [True, False])
def test_a_saved_chart_loads_identically(tmp_path: Path, growth: bool) -> None:
    chart = small_map(growth)
    loaded = fr.Chart.load(chart.save(tmp_path / "map.npz"))
    assert loaded == chart
    assert (loaded.subject, loaded.caption, loaded.version) == (chart.subject, chart.caption, fr.__version__)
    assert [path.name for path in tmp_path.iterdir()] == ["map.npz"]
    tolerant = fr.mathieu.chart((0.0, 3.0, 6), (-2.0, 0.5, 5), growth_tolerance=0.3)
    assert fr.Chart.load(tolerant.save(tmp_path / "tolerant.npz")) == tolerant


@pytest.mark.parametrize(("name", "remedy"), [("map.csv", "bands.to_csv"), ("map.PNG", "plot().figure.savefig")])
def test_a_save_under_the_name_of_a_table_or_a_picture_names_what_writes_it(
    tmp_path: Path, name: str, remedy: str
) -> None:
    with pytest.raises(ValueError, match=f"npz file, got '{name}'; {re.escape(remedy)}"):
        small_map().save(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_a_save_that_fails_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = small_map().save(tmp_path / "map.npz")
    before = path.read_bytes()

    def fail(file: IO[bytes], *_: object, **__: object) -> None:
        file.write(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr(np.lib.format, "write_array", fail)
    with pytest.raises(KeyboardInterrupt):
        small_map(growth=False).save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_damaged_and_foreign_files(tmp_path: Path) -> None:
    path = small_map().save(tmp_path / "map.npz")
    whole = path.read_bytes()
    (tmp_path / "half.npz").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "text.npz").write_text("no chart", encoding="utf-8")
    np.savez(tmp_path / "other.npz", meta=np.array('{"format": "something else"}'), stable=np.ones((2, 2)))
    for name in ("half.npz", "text.npz", "other.npz", "absent.npz"):
        with pytest.raises(ValueError, match=f"{name} is not a chart that can be read"):
            fr.Chart.load(tmp_path / name)


def test_a_chart_as_an_xarray_dataset() -> None:
    chart = small_map()
    data = chart.to_xarray()
    assert np.array_equal(data["stable"], chart.stable)
    assert np.array_equal(data["growth_rate"].sel(frequency=chart.x.values[3]), chart.growth_rate[:, 3])
    assert data["mean force"].attrs == {"units": "N"}
    assert data.attrs["growth_unit"] == "1/s"


@pytest.mark.parametrize("growth", [True, False])
def test_plots_are_labelled(growth: bool) -> None:
    ax = small_map(growth).plot(bands=False)
    assert ax.get_xlabel() == r"frequency $\omega$ / (rad/s)"
    assert ax.get_ylabel() == r"mean force $F_\mathrm{ave}$ / N"
    assert "points stable" in note(ax)
    curves = fr.mathieu.transition_curves(np.linspace(0.0, 3.0, 50), 3).plot(ax)
    assert [text.get_text() for text in curves.texts[:3]] == ["$a_{0}$", "$a_{1}$", "$b_{1}$"]
    assert len(fr.mathieu.transition_curves(np.linspace(0.0, 3.0, 50), 3).plot().lines) == 7
    own = pyplot.figure().subplots()
    assert fr.mathieu.chart((0.0, 3.0, 30), (-2.0, 0.5, 20)).plot(own) is own
    pyplot.close("all")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"frequency": 150.0}, "exactly one of mean, amplitude and frequency must be a single number"),
        ({"amplitude": (0.0, 1.0, 5)}, "single numbers here: none"),
        ({"mean": (1.0, 0.0, 5)}, "with low < high"),
        ({"mean": [0.0, 1.0, 0.5, 2.0]}, "mean must increase from value to value"),
        ({"mean": (0.0, 1.0, 1)}, r"mean\[2\] must be 2 or more"),
        ({"mean": (0.0, 1.0, 10**9)}, r"mean\[2\] must be at most 268,435,456, got 1,000,000,000; take fewer"),
        (
            {"mean": (0.0, 1.0, 10**5), "frequency": (20.0, 200.0, 10**5)},
            "the number of points must be at most 268,435,456, got 10,000,000,000",
        ),
        ({"frequency": (0.0, 1.0, 5)}, "frequency must be finite and lie between"),
        ({"amplitude": -1.0}, "amplitude must be zero or more"),
        ({"growth_tolerance": -1.0}, "growth_tolerance must be zero or more"),
        ({"growth": True, "friction": 0.1, "kick": 0.05}, "leave out either growth or friction"),
    ],
)
def test_bad_input(change: dict[str, object], message: str) -> None:
    good: dict[str, object] = {"mean": (0.0, 1.0, 5), "amplitude": 0.3, "frequency": (20.0, 200.0, 5)}
    with pytest.raises((ValueError, TypeError), match=message):
        fr.stability_map(ROD, **{**good, **change})  # type: ignore[arg-type]


def test_a_map_needs_a_rod() -> None:
    with pytest.raises(TypeError, match="rod must be a Rod"):
        fr.stability_map("rod", mean=1.0, amplitude=1.0, frequency=1.0)  # type: ignore[arg-type]


def test_a_chart_in_other_units_is_the_same_chart(tmp_path: Path) -> None:
    chart = fr.stability_map(ROD, mean=(0.0, FCR, 4), amplitude=0.2 * FCR, frequency=(20.0, 200.0, 5))
    shown = chart.in_units(mean="Fcr", amplitude="Fcr", frequency="Hz")
    assert shown.y.values.tolist() == pytest.approx([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0])
    assert shown.x.values == pytest.approx(chart.x.values / (2.0 * np.pi))
    assert (shown.x.unit, shown.y.unit) == ("Hz", "Fcr")
    assert shown.stable is chart.stable
    assert shown.caption.startswith("rod, amplitude 0.2 Fcr, critical force 1.69603 N: ")
    assert shown.plot().get_xlabel() == r"frequency $\omega/2\pi$ / Hz"
    back = fr.Chart.load(shown.save(tmp_path / "shown.npz")).in_units(mean="N", amplitude="N", frequency="rad/s")
    assert back.x.values == pytest.approx(chart.x.values)
    assert back.caption == chart.caption


@pytest.mark.parametrize(
    ("units", "message"),
    [
        ({"force": "N"}, "force must be a quantity with a unit of this chart: frequency, mean force, amplitude"),
        ({"mean": "Hz"}, r"mean must be a unit of force \(N, .*, Fcr\), got 'Hz'; it is a unit of frequency"),
        ({"frequency": "Fcr"}, "frequency must be a unit of frequency"),
    ],
)
def test_units_that_do_not_fit_a_chart(units: dict[str, str], message: str) -> None:
    chart = fr.stability_map(ROD, mean=(0.0, FCR, 2), amplitude=0.2 * FCR, frequency=(20.0, 200.0, 2))
    with pytest.raises(ValueError, match=message):
        chart.in_units(**units)
    with pytest.raises(ValueError, match="alpha must be a quantity with a unit"):
        fr.mathieu.chart((0.0, 1.0, 3), (-1.0, 0.0, 3)).in_units(alpha="N")
