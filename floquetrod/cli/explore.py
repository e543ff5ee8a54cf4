"""`floquetrod explore`: a load moved by sliders."""

from __future__ import annotations

import argparse
import webbrowser
from collections.abc import Callable

import floquetrod as fr
from floquetrod._util.waiting import say
from floquetrod.cli.common import (
    ROD_AND_LOAD,
    ROD_OPTIONS,
    describe_command,
    figures,
    read_units,
    write_figures,
)
from floquetrod.cli.loads import add_question, read_question, warn_of_hertz
from floquetrod.cli.messages import option
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser
from floquetrod.explorer.limits import Scale
from floquetrod.plotting import chart_plot
from floquetrod.plotting.web import Shown, require_tornado, serve
from floquetrod.rod.answers.reports import describe_load, shown_in
from floquetrod.rod.loads.load import QUANTITIES, Load
from floquetrod.rod.reading import RECORD_OPTIONS

_HELP = """\
Open a window with a slider for mean force, amplitude and frequency; map, modes, growth and verdict are updated.

examples:
  floquetrod example my_rod.toml well.toml record.csv
  floquetrod explore --rod nitinol
  floquetrod explore --rod my_rod.toml --mean 6N --amplitude 2N --frequency 24Hz
  floquetrod explore --rod nitinol --unit Fcr,Hz --out explorer.png
  floquetrod explore --rod well.toml --wave held --web
  floquetrod explore --rod my_rod.toml --force record.csv

The explorer accepts every rod and load of floquetrod check.  Slow results, such as those of coupled modes, appear
while the sliders rest.  --mean, --amplitude and --frequency, all three or none, are those of the first load.  Axes and
sliders are in the units of the given load, or of --unit.  The window shows the load as a command, and prints it when it
closes.

With --out the picture is written to a file and no window opens; this needs no screen.
With --web the window is a page in the browser of this machine (pip install floquetrod[web]).  Its address, which holds
a secret, is printed, and nobody can open the page without it; Ctrl-C ends the page.
"""

_LAST_PORT = 65_535


def add(explore: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(explore, _HELP, _explore, (*ROD_AND_LOAD, "web"))
    add_question(explore, classified=False)
    explore.add_output("--out", figures, "write the picture (.png, .pdf, .svg) and open no window")
    explore.add_argument("--web", action="store_true", help="show a page in the browser in place of a window")
    explore.add_argument("--port", type=int, help="port of the page (needs --web; default: any free one)")
    explore.add_argument("--open", action="store_true", help="open the page in the browser (needs --web)")


def _explore(options: argparse.Namespace) -> Output:
    _require_web(options)
    rod, load, is_given = _given(options)
    warn_of_hertz("--frequency", options.frequency, rod, [load])
    names = read_units(options, rod, load)
    shown = shown_in(names, rod)
    if not is_given:  # begin in the middle of things
        first = Scale.of(rod).first_load(shown)
        load = load.with_numbers(first.mean, first.amplitude, first.frequency)
    if options.web:
        import matplotlib as mpl

        mpl.use("agg")  # the window is a page
    units: dict[str, str] = {name: names[name] for name in QUANTITIES}

    def another() -> fr.Explorer:
        return fr.Explorer(rod, load, units, options=_named(options))

    explorer = another()
    written: list[str] = []
    if options.out:
        explorer.refine()
        written = write_figures(options.out, lambda: explorer.window.figure)
    elif options.web:
        explorer = _serve(explorer, another, options)
    else:
        chart_plot.show()
    load = explorer.load
    record = {
        "mean_N": load.mean,
        "amplitude_N": load.amplitude,
        "frequency_rad_per_s": load.frequency,
        "command": explorer.command,
    }
    said = f"{describe_load(load, shown, rod)}\n{rod.stability(load)}\n{explorer.command}"
    return output(options, lambda: said, lambda: record, written=written)


def _given(options: argparse.Namespace) -> tuple[fr.Rod, Load, bool]:
    """Return the rod and the load that the options describe, and whether they give its numbers."""
    given = [name for name in QUANTITIES if getattr(options, name) is not None]
    if given and len(given) < len(QUANTITIES) and options.force is None:
        raise ValueError(f"--mean, --amplitude and --frequency go together; got only --{', --'.join(given)}")
    rod, record, load, _ = read_question(options, required=False)
    return rod, load, bool(given) or record is not None


def _named(options: argparse.Namespace) -> list[str]:
    """Return the options that name the rod and the measured force."""
    given = {name: getattr(options, name) for name in (*ROD_OPTIONS, "force", *RECORD_OPTIONS)}
    return [word for name, text in given.items() if text is not None for word in (option(name), str(text))]


def _require_web(options: argparse.Namespace) -> None:
    """Raise ValueError for options that do not go with the page, or are for it alone."""
    for name in ("port", "open"):
        if getattr(options, name) not in (None, False) and not options.web:
            raise ValueError(f"--{name} needs --web, got --{name} alone")
    if options.port is not None and not 0 <= options.port <= _LAST_PORT:
        raise ValueError(f"--port must lie between 0 and {_LAST_PORT}, got {options.port}")
    if options.web and options.out:
        raise ValueError(
            f"--out writes a picture and opens no page, got {str(options.out[0])!r} with --web; leave one out"
        )
    if options.web:
        require_tornado()


def _serve(first: fr.Explorer, another: Callable[[], fr.Explorer], options: argparse.Namespace) -> fr.Explorer:
    """Show pages until Ctrl-C, each with an explorer of its own, and return the one that was drawn last."""
    unused, latest = [first], first

    def opened() -> Shown:
        explorer = unused.pop() if unused else another()

        def words() -> dict[str, str]:
            nonlocal latest
            latest = explorer
            return explorer.window.words

        return Shown(explorer.window.figure, words)

    def told(address: str) -> None:
        say(f"open {address} in the browser of this machine; Ctrl-C ends")
        if options.open:
            webbrowser.open(address)

    serve(opened, told, title="floquetrod: the explorer", port=options.port or 0)
    return latest
