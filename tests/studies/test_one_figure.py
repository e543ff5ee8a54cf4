"""A figure of the study alone, or a panel of it: what is drawn is what its file of data has."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from floquetrod import mathieu
from studies import figures, reproduction
from studies.__main__ import main
from studies.one_figure import panels_of
from tests.studies.test_paper import COARSE

Rows = list[dict[str, str]]


def drawn(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> Rows:
    """Draw a figure coarsely and return its data."""
    monkeypatch.setattr("studies.__main__.QUICK", COARSE)
    assert main(["--quick", "--only", name, "--out", str(folder)]) == 0
    assert {path.name for path in folder.iterdir()} == {f"figure_{name}.{kind}" for kind in ("png", "pdf", "csv")}
    assert (folder / f"figure_{name}.pdf").read_bytes().startswith(b"%PDF")
    with (folder / f"figure_{name}.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_files_are_named_in_words_and_in_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("studies.__main__.draw_one", lambda folder, *_, **__: [folder / "a.png", folder / "a.csv"])
    files = [str(tmp_path / name) for name in ("a.png", "a.csv")]
    assert main(["--only", "3b", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().out == f"drawn: 3b\nwritten: {', '.join(files)}\n"
    assert main(["--only", "3b", "--out", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["written"] == files


@pytest.mark.slow
def test_a_panel_has_the_points_that_are_drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = drawn("2a", tmp_path / "new", monkeypatch)
    assert {row["panel"] for row in rows} == {"a"}
    marked = np.array([(row["alpha"], row["beta"]) for row in rows if row["shape"] == "unstable point"], dtype=float)
    alpha, beta = figures.window(COARSE.chart)
    unstable = ~figures.LEAPFROG.is_stable(alpha, beta)
    expected = np.column_stack([np.broadcast_to(each, unstable.shape)[unstable] for each in (alpha, beta)])
    np.testing.assert_allclose(marked, expected, rtol=1e-9, atol=1e-9)
    curves = mathieu.transition_curves(np.linspace(*figures.WINDOW[0], 400), range(7))
    third = [
        (row["alpha"], row["beta"]) for row in rows if (row["shape"], row["number"]) == ("even transition curve", "3")
    ]
    kept = np.isfinite(curves.even[2])
    np.testing.assert_allclose(
        np.array(third, dtype=float), np.column_stack([curves.alpha, curves.even[2]])[kept], rtol=1e-9, atol=1e-9
    )


@pytest.mark.slow
def test_a_whole_figure_has_the_data_of_every_panel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = drawn("2", tmp_path, monkeypatch)
    assert list(dict.fromkeys(row["panel"] for row in rows)) == ["a", "b", "c", "d"]
    modes = [row["shape"] for row in rows if row["panel"] == "c" and row["shape"].startswith("mode")]
    assert modes == [f"mode {m}, {'unstable' if m == 7 else 'stable'}" for m in range(1, 11)]


@pytest.mark.slow
def test_intervals_are_data_with_a_heading_of_their_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = drawn("3e", tmp_path, monkeypatch)
    expected = figures.unstable_intervals(0.2, 85.0, 1.1)
    assert len(rows) == 5 * len(expected)  # the corners of a bar, the first one again
    corners = np.array([row["F_ave / F_cr"] for row in rows], dtype=float).reshape(-1, 5)
    ends = sorted(zip(corners.min(axis=1), corners.max(axis=1), strict=True))
    np.testing.assert_allclose(ends, sorted((each.low, each.high) for each in expected), rtol=0.0, atol=1e-9)
    assert {row["shape"].partition(",")[0] for row in rows} == {
        f"unstable interval of mode {interval.mode}" for interval in expected
    }


def test_a_panel_alone_fills_its_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    figure = figures.figure_2(12)
    reproduction.one_figure.keep_panel(figure, "b")
    assert list(panels_of(figure)) == ["b"]
    figure.draw_without_rendering()
    box = figure.axes[0].get_position()
    assert (box.width > 0.7, box.height > 0.5) == (True, True)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--only", "9z"], "--only must name a figure, 2, 3, 4, 5, 6, 7, 8, kick, or a panel such as 3b, got '9z'"),
        (["--only", ""], "--only must name a figure"),
        (["--only", "2h"], "--only must name a panel of figure 2, got '2h'; it has a, b, c, d"),
        (["--only", "3", "--simulations"], "--simulations is for the whole study"),
    ],
)
def test_mistakes_teach(
    words: list[str], expected: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("studies.__main__.FULL", COARSE)
    assert main([*words, "--out", str(tmp_path / "new")]) == 2
    assert expected in capsys.readouterr().err
