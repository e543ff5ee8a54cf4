"""The figure of ranges shows the numbers of the ranges."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot

import floquetrod as fr
from floquetrod import cli
from tests.conftest import depth

ROD = fr.Rod.nitinol()


@pytest.mark.parametrize("seed", range(depth(3, 1)))
def test_bars_and_named_ranges_are_those_of_the_answer(seed: int) -> None:
    """Drawn loads and bounds: a bar for each unstable band, and the safe ranges of the first line of the answer."""
    rng = np.random.default_rng([50, 9, seed])
    low, width = rng.uniform(8.0, 30.0), rng.uniform(5.0, 20.0)
    mean, amplitude = rng.uniform(0.05, 0.3, 2) * ROD.critical_force
    load = fr.AxialLoad(mean, amplitude, 150.0)
    found = ROD.ranges("frequency", load, (f"{low}Hz", f"{low + width}Hz"))
    ax = found.plot()
    bars = [patch for patch in ax.patches if type(patch).__name__ == "Polygon"]
    assert len(bars) == len(found.unstable)
    for bar, band in zip(bars, found.unstable, strict=True):
        x, y = bar.get_xy().T
        assert (x.min(), x.max(), y.max()) == pytest.approx(
            (band.low / (2 * np.pi), band.high / (2 * np.pi), band.worst_growth)
        )
    spans = [line for line in ax.lines if line.get_marker() == "|"]
    assert len(spans) == len(str(found.report()).split("\n")[0].split(" to ")) - 1  # a bracket for each safe range
    (labels,) = (each for each in ax.artists if type(each).__name__ == "Leaders")
    ranges = [text.get_text() for text in labels.texts if " to " in text.get_text()]
    listed = str(found.report()).split("safe: ")[1].split("\n")[0].replace(", except", " Hz, except").split(" Hz, ")
    assert ranges
    assert set(ranges) <= {each.removesuffix(" Hz") for each in listed}
    assert "Hz" in ax.get_xlabel()
    assert "rad/s" in found.plot(unit="rad/s").get_xlabel()
    pyplot.close("all")


@pytest.mark.slow
def test_the_terminal_writes_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "ranges.svg"
    load = ["--mean", "0.3Fcr", "--amplitude", "0.2Fcr", "--frequency", "20Hz:30Hz"]
    assert cli.main(["ranges", "--rod", "nitinol", *load, "--out", str(picture)]) == 0
    assert capsys.readouterr().out.endswith(f"written: {picture}\n")
    assert picture.stat().st_size > 1000
    assert cli.main(["ranges", "--rod", "nitinol", *load, "--out", "ranges.doc"]) == 2
    assert "--out must end in .png, .pdf or .svg, got 'ranges.doc'" in capsys.readouterr().err
