"""`floquetrod map`: a rod over a plane of loads."""

from __future__ import annotations

import argparse
from typing import Any

import floquetrod as fr
from floquetrod import units
from floquetrod._util.waiting import Waiting
from floquetrod.cli.common import (
    ROD_AND_LOAD,
    add_picture,
    bands_in_numbers,
    bands_listed,
    describe_command,
    find_bands,
    read_friction,
    read_points,
    read_quantity,
    require_bands_of_csv,
    write_charts,
)
from floquetrod.cli.loads import add_question, read_ranges, warn_of_hertz
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser
from floquetrod.rod.answers.reports import shown_in
from floquetrod.rod.loads.load import QUANTITIES, Quantity

_HELP = """\
Draw a rod's stability over two of mean force, amplitude and frequency; the third is fixed.

examples:
  floquetrod example my_rod.toml wire.toml well.toml
  floquetrod map --rod nitinol --amplitude 0.2Fcr --mean 0:1.1Fcr --frequency 20:200rad/s --out map.png
  floquetrod map --rod nitinol --frequency 150rad/s --mean 0:1.1Fcr --amplitude 0:0.5Fcr --growth --out map.npz
  floquetrod map --rod nitinol --amplitude 0.2Fcr --mean 0:1.1Fcr --frequency 20:200rad/s --growth-tolerance 1
  floquetrod map --rod nitinol --amplitude 0.2Fcr --mean 0:1.1Fcr --frequency 20:200rad/s --pixels --points 1200x900
  floquetrod map --rod my_rod.toml --amplitude 2N --mean 0:12N --frequency 5Hz:60Hz --mark 6N,24Hz
  floquetrod map --rod nitinol --amplitude 0.2Fcr --mean 0:1.1Fcr --frequency 20:200rad/s --paper-criterion exact
  floquetrod map --rod nitinol --amplitude 0.7Fcr --mean 0:1.1Fcr --frequency 20:200rad/s --friction 0.1 --kick 50mm/s
  floquetrod map --rod wire.toml --frequency 20Hz --mean 0:1Fcr --amplitude 0:0.5Fcr --points 60x40
  floquetrod map --rod well.toml --frequency 4Hz --mean 0:1Fcr --amplitude 0:0.5Fcr --wave free --points 40x30

The unstable bands are drawn as shapes between their boundaries; a label 7·1 says mode 7, tongue 1:
tongue m is where the frequency is about 2/m times the mode's.  With --pixels the verdicts at the --points are drawn
instead.

A .png, .pdf or .svg file is a figure, a .csv file the vertices of the bands, a .npz file all the numbers
(floquetrod.Chart.load reads it); give --out twice for both.  Axes, caption and .csv are in the units of the ranges, or
of --unit; a .npz file is in N and rad/s.

Ends that are not hinged, weight along an inclined rod and axial waves (--wave) couple the modes.  A point then takes a
millisecond or more: begin with few points.
"""


def add(chart: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(chart, _HELP, _map, (*ROD_AND_LOAD, "out"))
    add_question(chart, friction=True, ranges=True)
    add_picture(chart, "400x300", "map.png")
    chart.add_argument(
        "--large-motion",
        action="store_true",
        help="hatch where the rod at rest is stable and a large motion of one mode was found, too",
    )
    chart.add_argument(
        "--response",
        action="store_true",
        help="draw lines of the largest deflection of a rod with a natural_shape where it is stable",
    )
    chart.add_argument(
        "--paper-criterion",
        choices=("exact", "leapfrog"),
        help="the paper's test (a millionfold growth in 100 periods) in place of stability, computed in this way",
    )
    chart.add_argument(
        "--mark", help="a point to mark: both varied quantities, in the order mean, amplitude, frequency"
    )


def _map(options: argparse.Namespace) -> Output:
    from floquetrod.plotting import chart_plot

    require_bands_of_csv(options)
    columns, rows = read_points(options.points)
    ranges, mu_and_kick = read_ranges(options), read_friction(options)
    rod, like, values, tolerance, shown, _ = ranges
    varied = ranges.varied
    if len(varied) != 2:
        raise ValueError(
            f"two of --mean, --amplitude, --frequency must be ranges such as 0:1.1Fcr, got {ranges.varied_in_words}"
        )
    ranges.warn_of_hertz(options)
    across = "frequency" if "frequency" in varied else "mean"
    load: dict[str, Any] = {
        name: (*ends, columns if name == across else rows) if name in varied else ends[0]
        for name, ends in values.items()
    }
    criterion = None if options.paper_criterion is None else fr.FiniteTimeCriterion(by=options.paper_criterion)
    point = None if options.mark is None else _point(options.mark, varied, across, rod)
    if point is not None and "frequency" in point:
        marked = like.with_numbers(**({name: ends[0] for name, ends in values.items()} | point))
        warn_of_hertz("--mark frequency", options.mark.rpartition(",")[2], rod, [marked], tolerance)
    with Waiting("deciding stability", "points") as progress:
        chart = fr.stability_map(
            rod,
            like,
            **load,
            growth=options.growth,
            growth_tolerance=tolerance,
            criterion=criterion,
            friction=None if mu_and_kick is None else mu_and_kick[0],
            kick=None if mu_and_kick is None else mu_and_kick[1],
            large_motion=options.large_motion,
            response=options.response,
            progress=progress,
        )
    bands = find_bands(options, chart)
    forces = (shown.get("force"), shown["mean"], shown["amplitude"])  # a critical force is none for itself
    force = next((name for name in forces if name and units.is_unit(name, "force")), "N")
    named = {name: shown[name] for name in ("kick", *QUANTITIES)[mu_and_kick is None :]}
    drawn = chart.in_units(**named, critical=force)

    def draw() -> Any:
        axes = drawn.plot(bands=bands)
        if point is not None:
            x, y = (shown_in(shown, rod)[name].of(value) for name, value in point.items())
            chart_plot.mark(axes, x, y, "the load")
        return axes

    written = write_charts(options.out, chart, drawn, draw)
    share = float(chart.stable.mean())
    record = {
        "points": int(chart.stable.size),
        "stable_share": share,
        "with_large_motion": int(chart.carries_large_motion.sum()) if options.large_motion else None,
        "bands": len(chart.bands) if bands else None,
        "tongues_left_out": chart.bands.tongues_left_out if bands else None,
        "unstable": bands_in_numbers(chart.bands) if bands else None,
    }
    lines = [ranges.with_left_out(drawn.caption), *([bands_listed(drawn.bands)] if bands else [])]
    return output(options, lambda: "\n".join(lines), lambda: record | ranges.as_numbers, written=written)


def _point(text: str, varied: list[Quantity], across: str, rod: fr.Rod) -> dict[Quantity, float]:
    """Return the point to mark in SI units, by quantity, the one drawn to the right first."""
    parts = text.split(",")
    if len(parts) != 2:
        raise ValueError(f"--mark must be two quantities such as 0.2Fcr,150, got {text!r}")
    try:
        place = {name: read_quantity(part, name, rod) for name, part in zip(varied, parts, strict=True)}
    except ValueError as error:
        raise ValueError(f"--mark {text!r}: {error}") from None
    return dict(sorted(place.items(), key=lambda item: item[0] != across))
