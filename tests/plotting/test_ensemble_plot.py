"""The figure and the table of an ensemble show its numbers."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot

from floquetrod.ensembles.runs import Runs
from floquetrod.ensembles.shares import shares_along
from floquetrod.ensembles.statistics import probability
from floquetrod.ensembles.variables import Variable


def drawn_runs(seed: int) -> Runs:
    """Return runs over three kicks and forty samples of a length, of which some failed."""
    rng = np.random.default_rng([50, 7, seed])
    dims, shape = ("kick", "sample"), (3, 40)
    status = rng.choice([1, 1, 1, 2], shape)
    return Runs(
        {
            "status": Variable(dims, status, {}),
            "buckled": Variable(dims, rng.random(shape) < 0.4, {}),
            "frames": Variable((*dims, "frame"), rng.random((*shape, 2)), {}),
        },
        {
            "kick": Variable(("kick",), np.array([0.01, 0.02, 0.05]), {"units": "m/s"}),
            "length": Variable(("sample",), rng.normal(3.0, 0.1, 40), {"units": "m"}),
        },
        {},
    )


@pytest.mark.parametrize("seed", range(4))
def test_a_panel_for_each_quantity_with_the_probability_that_is_computed(seed: int) -> None:
    runs = drawn_runs(seed)
    kick, length = shares_along(runs, "buckled", 0.9)
    asked = probability(runs, over="sample", confidence=0.9)
    assert (kick.name, length.name) == ("kick", "length")
    for ours, theirs in ((kick.share, "probability"), (kick.lower, "lower"), (kick.upper, "upper")):
        assert ours.tolist() == asked[theirs].tolist()
    assert np.all((length.low <= length.value) & (length.value <= length.high))
    assert np.all(length.high[:-1] < length.low[1:])  # each run is in one bin
    assert np.all((length.lower <= length.share) & (length.share <= length.upper))
    figure = runs.plot(confidence=0.9)
    above, _ = figure.axes
    points = above.containers[0].lines[0].get_xydata()
    assert points == pytest.approx(np.column_stack([kick.value, kick.share]))
    assert "kick / (m/s)" in above.get_xlabel()
    assert above.get_ylabel() == "buckled, share\nof runs done"
    whole = probability(runs, over=["kick", "sample"], confidence=0.9)
    share, lower, upper = (f"{float(whole[name]):.3f}" for name in ("probability", "lower", "upper"))
    done = runs["status"] == 1
    assert above.get_title().replace("\N{NO-BREAK SPACE}", " ") == (
        f"buckled: {(runs['buckled'] & done).sum()} of {done.sum()} runs; probability {share} on average over kick, "
        f"90 % interval {lower} to {upper}"
    )
    pyplot.close("all")


def test_a_table_has_a_row_for_each_run(tmp_path: Path) -> None:
    runs = drawn_runs(0)
    with runs.to_csv(tmp_path / "runs.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["kick (m/s)", "length (m)", "status", "buckled"]
    assert len(rows) == runs["status"].size
    assert [float(row["length (m)"]) for row in rows[:40]] == runs["length"].tolist()
    done = runs["status"].ravel() == 1
    assert [row["buckled"] == "True" for row in rows] == (runs["buckled"].ravel() & done).tolist()


def test_words_stand_for_codes_and_nothing_for_runs_that_are_not_done(tmp_path: Path) -> None:
    runs = drawn_runs(1)
    status = runs.variables["status"]
    codes = {"flag_values": [0, 1, 2], "flag_meanings": "quiet at_rest buckled"}
    outcome = Variable(status.dims, np.arange(status.values.size).reshape(status.values.shape) % 3, codes)
    named = status._replace(attrs={"flag_values": [0, 1, 2], "flag_meanings": "pending done failed"})
    written = Runs({**runs.variables, "status": named, "outcome": outcome}, runs.coords, {}).to_csv(
        tmp_path / "runs.csv"
    )
    with written.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    for row, code, true, kind in zip(
        rows, status.values.ravel(), runs["buckled"].ravel(), outcome.values.ravel(), strict=True
    ):
        done = code == 1
        assert row["status"] == ("done" if done else "failed")
        assert row["outcome"] == (["quiet", "at rest", "buckled"][kind] if done else "")
        assert row["buckled"] == (str(bool(true)) if done else "")


def chosen_runs(*shape: int, seed: int = 0) -> Runs:
    """Return runs over chosen kicks, amplitudes and lengths, as many as ``shape`` has, in no order; some failed."""
    rng = np.random.default_rng([55, seed])
    names = ("kick", "amplitude", "length")[: len(shape)]
    return Runs(
        {
            "status": Variable(names, rng.choice([1, 1, 1, 2], shape), {}),
            "buckled": Variable(names, rng.random(shape) < 0.5, {}),
        },
        {
            name: Variable((name,), rng.permutation(n) + 1.0, {"units": "m"})
            for name, n in zip(names, shape, strict=True)
        },
        {},
    )


@pytest.mark.parametrize("seed", range(3))
def test_two_chosen_quantities_make_a_plane(seed: int) -> None:
    runs = chosen_runs(4, 3, seed=seed)
    (ax,) = runs.plot().axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("kick / m", "amplitude / m")
    drawn = ax.collections[0].get_array().reshape(3, 4)
    for i, kick in enumerate(np.argsort(runs["kick"])):
        for j, amplitude in enumerate(np.argsort(runs["amplitude"])):
            is_done = runs["status"][kick, amplitude] == 1
            assert drawn.mask[j, i] == (not is_done)
            assert not is_done or drawn[j, i] == runs["buckled"][kick, amplitude]
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["buckled", "not buckled", "no run done"]
    pyplot.close("all")


@pytest.mark.slow
def test_two_chosen_quantities_with_drawn_runs_have_a_plane_and_panels() -> None:
    rng, shape, dims = np.random.default_rng(3), (3, 2, 20), ("mean", "amplitude", "seed")
    coords = {
        "mean": Variable(("mean",), np.arange(3.0), {}),
        "amplitude": Variable(("amplitude",), np.arange(2.0), {}),
    }
    variables = {
        "status": Variable(dims, np.ones(shape, dtype=int), {}),
        "buckled": Variable(dims, rng.random(shape) < 0.5, {}),
    }
    runs = Runs(variables, coords, {})
    plane, _, *panels = runs.plot().axes
    assert plane.collections[0].get_array().reshape(2, 3).tolist() == runs["buckled"].mean(axis=2).T.tolist()
    assert [ax.get_xlabel() for ax in panels] == ["mean force", "amplitude"]
    share = runs["buckled"].mean()
    title = plane.get_title().replace("\N{NO-BREAK SPACE}", " ")
    assert f"; probability {share:.3f} on average over mean force and amplitude, 95 % interval" in title
    for dpi in (60, 80, 100, 200):
        plane.figure.set_dpi(dpi)
        plane.figure.canvas.draw()
        first, interval = plane.title._get_wrapped_text().splitlines()
        assert first.endswith("amplitude,")
        assert interval.startswith("95\N{NO-BREAK SPACE}%\N{NO-BREAK SPACE}interval")
    pyplot.close("all")


def test_one_chosen_quantity_shows_each_run() -> None:
    runs = chosen_runs(5)
    (ax,) = runs.plot().axes
    done = runs["status"] == 1
    assert ax.lines[0].get_xydata().tolist() == [
        [kick, float(true)] for kick, true in zip(runs["kick"][done], runs["buckled"][done], strict=True)
    ]
    pyplot.close("all")


def test_three_chosen_quantities_without_draws_are_refused() -> None:
    with pytest.raises(ValueError, match=r"runs must vary with one or two .*got kick, amplitude, length; give all but"):
        chosen_runs(2, 2, 2).plot()


def two_drawn() -> Runs:
    """Return runs over two drawn quantities and two kicks, one of them failed."""
    dims, rng = ("kick", "sample"), np.random.default_rng(9)
    status = np.ones((2, 30), int)
    status[0, 3] = 2
    return Runs(
        {
            "status": Variable(dims, status, {}),
            "buckled": Variable(dims, rng.random((2, 30)) < 0.4, {}),
        },
        {
            "kick": Variable(("kick",), np.array([0.01, 0.02]), {"units": "m/s"}),
            "length": Variable(("sample",), rng.normal(3.0, 0.1, 30), {"units": "m"}),
            "mean": Variable(("sample",), rng.normal(1.0, 0.1, 30), {"units": "N"}),
        },
        {},
    )


@pytest.mark.parametrize("over", [None, ("length", "mean"), ("mean", "kick")])
def test_every_run_done_is_a_point_over_two_quantities(over: tuple[str, str] | None) -> None:
    runs = two_drawn()
    ax = runs.plot(over=over).axes[0]
    names = over or ("length", "mean")
    labels = {"length": "length / m", "mean": "mean force / N", "kick": "kick / (m/s)"}
    assert (ax.get_xlabel(), ax.get_ylabel()) == tuple(labels[name] for name in names)
    places = {name: np.broadcast_to(runs[name][:, None] if name == "kick" else runs[name], (2, 30)) for name in names}
    for line, result in zip(ax.lines, (False, True), strict=True):
        chosen = (runs["status"] == 1) & (runs["buckled"] == result)
        assert line.get_xydata() == pytest.approx(np.column_stack([places[name][chosen] for name in names]))
    pyplot.close("all")


@pytest.mark.parametrize("over", [("length",), ("length", "length"), ("length", "bore")])
def test_what_is_not_two_varied_quantities_is_refused(over: tuple[str, ...]) -> None:
    with pytest.raises(ValueError, match="over"):
        two_drawn().plot(over=over)
