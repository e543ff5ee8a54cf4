"""`floquetrod lobes`: the stability lobes of a milling cutter."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path

import floquetrod as fr
from floquetrod import units
from floquetrod._util.tables import require_file
from floquetrod._util.waiting import Waiting
from floquetrod.cli.common import chart_files, describe_command, read_points, write_charts
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import POINTS, Parser
from floquetrod.milling.stability_lobes import ACCURACY, depth_step
from floquetrod.milling.tool_file import cutting_depth, read_tool, spindle_speed

_HELP = """\
Draw the stability lobes of a milling cutter: at which spindle speeds and depths of cut it chatters.

examples:
  floquetrod example tool.toml
  floquetrod lobes tool.toml
  floquetrod lobes tool.toml --speed 5000rpm:10000rpm --depth 0mm:4mm --points 400x200 --out lobes.png
  floquetrod lobes tool.toml --at 5000rpm --json

The file has the cutter's modes, teeth, immersion and cutting coefficients, and may have the ranges of speed and depth.
On a "Hopf" lobe the frequency of chatter is near that of a mode, on a "flip" lobe its period is twice the time between
teeth; the number of a lobe counts whole vibrations between two teeth, on average of unequal pitches.  With --at only
the critical depth of cut at that speed is printed.

A .png, .pdf or .svg file is a figure, a .csv file the vertices of the boundary in rpm and mm, a .npz file all the
numbers (floquetrod.Chart.load reads it); --out may be repeated.
"""

_CHART = "lobes.png"  # written where no other file is named

_READERS: dict[str, Callable[[str, str], float]] = {"speed": spindle_speed, "depth": cutting_depth}


def add(command: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(command, _HELP, _lobes, ("tool", "speed", "depth", "at", "out"))
    command.add_argument("tool", metavar="FILE", type=Path, help="the cutter, a TOML file")
    command.add_argument("--speed", metavar="LOW:HIGH", help="spindle speeds, such as 5000rpm:10000rpm (default: rpm)")
    command.add_argument("--depth", metavar="LOW:HIGH", help="axial depths of cut, such as 0mm:4mm")
    command.add_argument(
        "--points", metavar=POINTS, default="200x100", help="columns x rows (default 200x100); fewer take less time"
    )
    command.add_argument("--growth", action="store_true", help="shade by growth rate")
    command.add_argument("--at", metavar="SPEED", help="print only the critical depth at this speed (default: rpm)")
    command.add_output("--out", chart_files, "file to write", default=_CHART)


def _lobes(options: argparse.Namespace) -> Output:
    require_file("FILE", options.tool, "a TOML file of a milling cutter")
    mill = fr.Milling.from_toml(options.tool)
    if options.at is None:
        return _chart(options, mill)
    if options.out != [Path(_CHART)]:
        raise ValueError("--out writes a chart, and --at prints one critical depth: leave out one of them")
    return _critical_depth(options, mill)


def _critical_depth(options: argparse.Namespace, mill: fr.Milling) -> Output:
    speed = spindle_speed(options.at, "--at", 1e-6)
    depth = mill.critical_depth(f"{speed!r}rad/s")
    known = math.isfinite(depth)
    said = f"chatters from a depth of {1e3 * depth:.6g} mm on" if known else "does not chatter at any depth tried"
    step = depth_step(mill)
    text = f"{mill.in_words()}\n{repr(mill).strip('<>')}: at {30.0 * speed / math.pi:.6g} rpm it {said}\n"
    text += f"relative error below {ACCURACY:.0e}; " * known
    text += f"depths are tried every {1e3 * step:.2g} mm: a narrower range of chatter may be missed"
    record = {
        "speed_rad_per_s": speed,
        "critical_depth_m": depth if known else None,
        "relative_error": ACCURACY if known else None,
        "depth_step_m": step,
    }
    return output(options, lambda: text, lambda: record)


def _chart(options: argparse.Namespace, mill: fr.Milling) -> Output:
    columns, rows = read_points(options.points)
    ranges = {name: _range(options, name) for name in _READERS}
    speed, depth = (*(f"{end!r}rad/s" for end in ranges["speed"]), columns), (*ranges["depth"], rows)
    with Waiting("searching lobes", "percent") as progress:
        lobes = mill.lobes(speed, depth, growth=options.growth, progress=progress)
    with Waiting("finding the boundary", "steps along boundaries") as progress:
        lobes.chart.find_bands(progress=progress)
    written = write_charts(options.out, lobes.chart, lobes.chart, lobes.plot)
    text = f"{lobes.report()}\n{mill.in_words()}\n{lobes.chart.caption}"
    return output(options, lambda: text, lobes.as_dict, written=written)


def _range(options: argparse.Namespace, name: str) -> tuple[float, float]:
    """Return the ends of a range, of the option or of the file, in SI units."""
    text = getattr(options, name) or read_tool(options.tool).ranges.get(name)
    if text is None:
        raise ValueError(
            f"--{name} is required: a range such as {'5000rpm:10000rpm' if name == 'speed' else '0mm:4mm'}"
        )
    ends = text.split(":")
    if len(ends) != 2:
        raise ValueError(f"--{name} must be a range such as 0mm:4mm, two values with a colon between, got {text!r}")
    low, high = (_READERS[name](end, f"--{name}") for end in units.same_unit(*ends))
    if not low < high:
        raise ValueError(f"--{name} must be a range from less to more, got {text!r}")
    return low, high
