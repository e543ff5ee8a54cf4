"""`floquetrod map`: a rod over a plane of loads."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import floquetrod as fr
from floquetrod import units
from floquetrod._files import writable
from floquetrod.cli.common import (
    KINDS,
    Answer,
    Progress,
    add_command,
    add_friction,
    add_rod,
    read_friction,
    read_quantity,
    read_range,
    read_rod,
)

_HELP = """\
Draw a rod's stability over two of mean force, amplitude and frequency; the third is fixed.

examples:
  floquetrod map --rod nitinol --amplitude 0.2Fcr --mean 0:1.1Fcr --frequency 20:200 --out map.png
  floquetrod map --rod nitinol --frequency 150 --mean 0:1.1Fcr --amplitude 0:0.5Fcr --growth --out map.npz
  floquetrod map --rod my_rod.toml --amplitude 2N --mean 0:12N --frequency 5Hz:60Hz --mark 6N,24Hz
  floquetrod map --rod nitinol --amplitude 0.2Fcr --mean 0:1.1Fcr --frequency 20:200 --paper-criterion exact --out m.png
  floquetrod map --rod nitinol --amplitude 0.7Fcr --mean 0:1.1Fcr --frequency 20:200 --mu 0.1 --kick 50mm/s --out k.png

A .png, .pdf or .svg file is a figure, a .npz file all the numbers (floquetrod.Chart.load reads it); give --out twice
for both.
"""


def add(commands: Any) -> None:
    """Add the command to the parser."""
    chart = add_command(commands, "map", "draw stability over two quantities of the load", _HELP, _map)
    add_rod(chart)
    add_friction(chart)
    for name in KINDS:
        chart.add_argument(f"--{name}", required=True, help="a range such as 0:1.1Fcr or 5Hz:60Hz, or one value")
    chart.add_argument("--points", default="400x300", help="columns x rows (default 400x300)")
    chart.add_argument("--growth", action="store_true", help="shade by growth rate")
    chart.add_argument(
        "--paper-criterion",
        choices=("exact", "leapfrog"),
        help="the paper's test (a millionfold growth in 100 periods) in place of stability, computed in this way",
    )
    chart.add_argument(
        "--mark", help="a point to mark: both varied quantities, in the order mean, amplitude, frequency"
    )
    chart.add_argument("--out", action="append", type=Path, help="file to write; may be repeated (default map.png)")


def _map(options: argparse.Namespace) -> Answer:
    from floquetrod.plotting import charts

    rod = read_rod(options)
    paths = options.out or [Path("map.png")]
    for path in paths:
        if path.suffix not in (*charts.FIGURES, ".npz"):
            raise ValueError(f"--out must end in .png, .pdf, .svg or .npz, got {str(path)!r}")
        writable(path)
    columns, _, rows = options.points.partition("x")
    if not (columns.isdigit() and rows.isdigit() and int(columns) > 1 and int(rows) > 1):
        raise ValueError(f"--points must be like 400x300, got {options.points!r}")
    values = {name: read_range(getattr(options, name), name, rod) for name in KINDS}
    varied = [name for name, ends in values.items() if len(ends) == 2]
    if len(varied) != 2:
        raise ValueError(f"two of --mean, --amplitude, --frequency must be ranges such as 0:1.1Fcr, got {len(varied)}")
    across = "frequency" if "frequency" in varied else "mean"
    load: dict[str, Any] = {
        name: (*ends, int(columns if name == across else rows)) if name in varied else ends[0]
        for name, ends in values.items()
    }
    tolerance = units.quantity(options.growth_tolerance, "--growth-tolerance", "rate")
    criterion = None if options.paper_criterion is None else fr.PaperCriterion(by=options.paper_criterion)
    chart = fr.stability_map(
        rod,
        **load,
        growth=options.growth,
        growth_tolerance=tolerance,
        criterion=criterion,
        friction=read_friction(options),
        progress=Progress("points"),
    )
    point = None
    if options.mark is not None:
        texts = options.mark.split(",")
        if len(texts) != 2:
            raise ValueError(f"--mark must be two quantities such as 0.2Fcr,150, got {options.mark!r}")
        place = {name: read_quantity(text, name, rod) for name, text in zip(varied, texts, strict=True)}
        up = next(name for name in varied if name != across)
        point = (place[across], place[up])
    for path in paths:
        if path.suffix == ".npz":
            chart.save(path)
            continue
        axes = chart.plot()
        if point is not None:
            charts.mark(axes, *point, "the load")
        charts.save_figure(axes, path)
    written = [str(path) for path in paths]
    share = float(chart.stable.mean())
    if options.json:
        record = {
            "written": written,
            "points": int(chart.stable.size),
            "stable_share": share,
            "version": fr.__version__,
        }
        return Answer(json.dumps(record, indent=2, allow_nan=False))
    return Answer(f"{chart.caption}\nwritten: {', '.join(written)}")
