"""`floquetrod explore`: a load moved by sliders."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import floquetrod as fr
from floquetrod.cli.common import (
    KINDS,
    Answer,
    add_command,
    add_rod,
    add_units,
    check_out,
    read_quantity,
    read_rod,
    read_units,
)
from floquetrod.cli.loads import describe_load
from floquetrod.plotting import charts

_HELP = """\
Open a window with a slider for mean force, amplitude and frequency; map, modes, growth and verdict follow.

examples:
  floquetrod explore --rod nitinol
  floquetrod explore --rod my_rod.toml --mean 6N --amplitude 2N --frequency 24Hz
  floquetrod explore --rod nitinol --unit Fcr,Hz --out explorer.png

With --out the picture is written and no window opened, which needs no screen.  Axes
and sliders are in the units of the load given, or of --unit.
"""


def add(commands: Any) -> None:
    """Add the command to the parser."""
    explore = add_command(commands, "explore", "move a load by sliders and watch", _HELP, _explore)
    add_rod(explore, judged=False)
    add_units(explore)
    for name in KINDS:
        explore.add_argument(f"--{name}", help=f"{name} to begin with; give all three or none")
    explore.add_argument("--out", type=Path, help="write the picture (.png, .pdf, .svg) and open no window")


def _explore(options: argparse.Namespace) -> Answer:
    rod = read_rod(options)
    given = [name for name in KINDS if getattr(options, name) is not None]
    if given and len(given) < len(KINDS):
        raise ValueError(f"--mean, --amplitude and --frequency go together; got only --{', --'.join(given)}")
    values = {name: read_quantity(getattr(options, name), name, rod) for name in given}
    load = fr.AxialLoad(values["mean"], values["amplitude"], values["frequency"]) if values else None
    if options.out is not None:
        check_out(options.out, charts.FIGURES)
    shown = read_units(options, rod)
    explorer = fr.Explorer(rod, load, {name: shown[name].name for name in KINDS})
    if options.out is not None:
        charts.save_figure(explorer.window.figure, options.out)
    else:
        charts.show()
    load = explorer.load
    if options.json:
        record = {"mean_N": load.mean, "amplitude_N": load.amplitude, "frequency_rad_per_s": load.frequency}
        return Answer(json.dumps(record, indent=2, allow_nan=False))
    where = f"written: {options.out}\n" if options.out is not None else ""
    return Answer(f"{where}{describe_load(load, shown, rod)}\n{rod.stability(load)}")
