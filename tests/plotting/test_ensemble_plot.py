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
    pyplot.close("all")


def test_a_table_has_a_row_for_each_run(tmp_path: Path) -> None:
    runs = drawn_runs(0)
    with runs.to_csv(tmp_path / "runs.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["kick (m/s)", "length (m)", "status", "buckled"]
    assert len(rows) == runs["status"].size
    assert [float(row["length (m)"]) for row in rows[:40]] == runs["length"].tolist()
    assert [row["buckled"] == "True" for row in rows] == runs["buckled"].ravel().tolist()


def test_without_draws_there_is_no_probability() -> None:
    runs = drawn_runs(0)
    chosen = {name: v._replace(dims=("kick", "amplitude")) for name, v in runs.variables.items() if name != "frames"}
    with pytest.raises(ValueError, match="runs must vary along sample, run or seed"):
        Runs(chosen, {}, {}).plot()
