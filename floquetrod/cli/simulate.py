"""`floquetrod simulate`: the whole rod through time, against theory."""

from __future__ import annotations

import argparse
import math
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import floquetrod as fr
from floquetrod import units
from floquetrod._util.progress import Progress
from floquetrod._util.waiting import Waiting, roughly, say
from floquetrod.cli.common import (
    ROD_AND_LOAD,
    add_tool,
    add_wall_friction,
    describe_command,
    figures,
    read_force,
    read_units,
    warnings_at_once,
)
from floquetrod.cli.loads import add_question, read_question, warn_of_hertz
from floquetrod.cli.messages import option
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser, whole_number
from floquetrod.rod.loads.load import Load
from floquetrod.rod.reading import read_friction, read_tool
from floquetrod.simulation.start_text import read_perturbation

_HELP = """\
Simulate the whole nonlinear rod in its channel, with or without friction, and compare it with the theory.

examples:
  floquetrod example my_rod.toml well.toml record.csv
  floquetrod simulate --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr --frequency 150rad/s --out run.png --out run.npz
  floquetrod simulate --rod nitinol --mean 0.825Fcr --amplitude 0.7Fcr --frequency 150rad/s --mu 0.1 --kick 9:50mm/s
  floquetrod simulate --rod nitinol --mean 0.42Fcr --amplitude 0.7Fcr --frequency 150rad/s --mu 0.1 --case C:10 --seed 2
  floquetrod simulate --rod my_rod.toml --mean 6N --amplitude 2N --frequency 24Hz --duration 4s --out run.gif
  floquetrod simulate --rod my_rod.toml --mean 6N --amplitude 2N --frequency 24Hz --duration 60s --checkpoint run.ckpt
  floquetrod simulate --continue run.npz --duration 2s --out longer.npz
  floquetrod simulate --start run.npz --rod nitinol --mean 0.1Fcr --amplitude 0.1Fcr --frequency 150rad/s --duration 2s
  floquetrod simulate --rod well.toml --mean 0.5Fcr --amplitude 0.3Fcr --frequency 4Hz --wave held
  floquetrod simulate --rod well.toml --mean 0.3Fcr --amplitude 0N --frequency 4Hz --tool 2kN@4Hz@1m
  floquetrod simulate --rod my_rod.toml --force record.csv --mean 12N --duration 5s
  floquetrod simulate --rod nitinol --mean 0N --amplitude 0N --frequency 1Hz --mu 0.2 --feed-speed 20mm/s --far-force 1N

perturbations add up; the default is --random 1mm/s.  The cases are those of the paper, with speeds of 50 mm/s: A one
mode, B modes 4, 6, 8, 10, C one mode and all others up to 20 at random, D every node at random; A:6, C:6 set the mode
(default 8).

A .png, .pdf or .svg file shows the rod from above and the growth of its modes, a .gif or .mp4 is an animation (the
latter needs ffmpeg), a .npz holds all results (floquetrod.Simulation.load reads it).  Ctrl-C ends the run early, writes
and reports the results so far, and with a checkpoint the same command continues later.  The exit status is then 130; it
is 2 for invalid input, for a run that diverges, and if a file could not be written.  --continue makes a run in a .npz
file longer, with its own time step: a run continued by as long again is one run of that length, bit for bit.
--start goes on from the last state of such a run under another load: the same rod, whose damping, and friction, may
differ; the file gives segments and perturbation.  Time goes on, and with it the phase of the load.

rods and loads are those of floquetrod check: tubes, fluids, inclined channels, all kinds of ends, axial waves from the
upper end, measured forces.  --feed-speed moves the upper end down the channel in place of the force there; --far-force
is the mean force that pushes the lower end.  --tool shakes the rod from within, like that of floquetrod reach.

Half as many segments take a quarter of the time.  The default is enough for growth rates accurate to a thousandth; half
as many give a hundredth.
"""

_FRAMES = 400  # at least: a picture every 5 ms of two seconds
_FRAMES_A_PERIOD = 10  # of the forcing, without friction: two more than the fit of a growth rate asks for
_MOST_FRAMES = 100_000  # unless --frames names more (a choice)
_LONG = 60.0  # s: of runs that take longer, this is said at their beginning (a choice)


def add(command: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(command, _HELP, _simulate, (*ROD_AND_LOAD, "duration"))
    subject = command.add_mutually_exclusive_group(required=True)
    subject.add_argument(
        "--continue",
        dest="earlier",
        metavar="FILE",
        type=Path,
        help="a run in a .npz file, to be made longer by --duration, or brought to its end where it was interrupted",
    )
    add_question(command, subject, subsystem="simulation", classified=False)
    command.add_argument(
        "--feed-speed", metavar="SPEED", help="speed at which the upper end is moved down the channel, such as 10mm/s"
    )
    command.add_argument("--far-force", metavar="FORCE", help="mean force at the lower end (default: from the load)")
    add_tool(command)
    command.add_argument("--duration", metavar="TIME", help="how long to simulate (default 2s), or to add to a run")
    add_wall_friction(command, default="0")
    command.add_argument(
        "--natural-curvature",
        metavar="CURVATURE",
        default="0",
        help="shape of the rod without load: a curvature such as 3deg/30m, or path for that of its channel (default 0)",
    )
    command.add_argument(
        "--kick",
        metavar="MODE:SPEED",
        action="append",
        default=[],
        help="speed in a mode, such as 8:50mm/s; repeatable",
    )
    command.add_argument("--random", metavar="SPEED", help="a random speed at every node, up to this, such as 1mm/s")
    command.add_argument("--case", help="perturbation of the paper: A, B, C or D, with a mode as in A:6")
    command.add_argument("--seed", metavar="N", type=whole_number, help="seed of random speeds (default 1)")
    command.add_argument(
        "--start", metavar="FILE", type=Path, help="a run in a .npz file, from whose last state this one starts"
    )
    command.add_argument(
        "--segments", metavar="N", type=whole_number, help="segments of the rod (default: enough for the load)"
    )
    command.add_argument(
        "--time-step", metavar="TIME", help="largest step, such as 2us (default: the largest stable one)"
    )
    command.add_argument(
        "--frames",
        metavar="N",
        type=whole_number,
        help="frames to store (default: 400, more if the growth rate needs them)",
    )
    command.add_argument(
        "--theory",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="compare with theory (default), which for coupled modes of a kilometre takes half a minute",
    )
    command.add_argument(
        "--checkpoint", metavar="FILE", type=Path, help="file to keep up to date, and to continue from if it exists"
    )
    command.add_output("--out", _kinds, "file to write")


def _simulate(options: argparse.Namespace) -> Output:
    if options.earlier is not None:
        return _continue(options)
    rod, _, load, _ = read_question(options)
    feed = None if options.feed_speed is None else units.quantity(options.feed_speed, "--feed-speed", "speed")
    far = None if options.far_force is None else read_force(options.far_force, "--far-force", rod)
    friction: Any = read_friction(options.friction, "--friction")
    duration = units.quantity(options.duration or "2s", "--duration", "time")
    step = None if options.time_step is None else units.quantity(options.time_step, "--time-step", "time")
    perturbation, shown = _perturbation(options), read_units(options, rod, load)
    _require_writers(options.out, options.checkpoint)
    warn_of_hertz("--frequency", options.frequency, rod, [load])
    problem = fr.SimulationProblem(
        rod,
        load,
        duration=duration,
        friction=friction,
        perturbation=perturbation,  # type: ignore[arg-type]  # None stands for that of the start
        segments=options.segments,
        time_step=step,
        frames=_frames(load, duration, friction != 0.0) if options.frames is None else options.frames,
        feed_speed=feed,
        far_force=far,
        tool=None if options.tool is None else read_tool(options.tool, "--tool"),
        natural_curvature=options.natural_curvature,
        start=options.start,
    )
    return _ran(options, lambda progress: problem.run(progress, options.checkpoint), shown)


def _perturbation(options: argparse.Namespace) -> fr.Perturbation | None:
    """Return the perturbation that sets the rod moving, None where the rod starts from the state of a run."""
    if options.start is None:
        return read_perturbation(vars(options), option)
    for name in ("kick", "random", "case", "seed"):
        if (given := getattr(options, name)) not in (None, []):
            raise ValueError(
                f"{option(name)} must be left out with --start, whose rod is moving already, got {given!r}"
            )
    return None


_WITH_CONTINUE = ("earlier", "duration", "out", "checkpoint", "theory", "unit", "json")
"""Options that may be given with --continue: the file has the rest."""


def _continue(options: argparse.Namespace) -> Output:
    """Return the answer of a run that is made longer."""
    for action in options.parser._actions:
        given = getattr(options, action.dest, action.default)
        if action.dest not in _WITH_CONTINUE and given not in (action.default, argparse.SUPPRESS):
            raise ValueError(
                f"{action.option_strings[-1]} must be left out with --continue, whose file has it, got {given!r}"
            )
    added = "0s" if options.duration is None else options.duration
    seconds = units.quantity(added, "--duration", "time")
    run = fr.Simulation.load(options.earlier)
    if not seconds and run.ended == "duration":
        raise ValueError("--continue needs --duration, the time to add, because the run is complete; add --duration 2s")
    _require_writers(options.out, options.checkpoint)
    shown = read_units(options, run.rod)
    return _ran(
        options, lambda progress: run.continued(seconds, progress=progress, checkpoint=options.checkpoint), shown
    )


def _ran(options: argparse.Namespace, simulate: Callable[[Progress], fr.Simulation], shown: dict[str, str]) -> Output:
    """Return the answer of a run, with its files written."""
    try:
        with warnings_at_once(), _Forewarning("simulating", "steps") as progress:
            run = simulate(progress)
    except fr.SimulationDiverged as error:
        saved, missed = _write_all(error.simulation, [path for path in options.out if path.suffix == ".npz"])
        where = f", in {saved[0]}" if saved else ""
        raise ValueError("; ".join([f"{error}{where}", *missed])) from None
    written, missed = _write_all(run, options.out)
    with Waiting("comparing with theory"):
        found = run.findings(theory=options.theory)
    files = {
        "not_written": missed,
        "checkpoint": None if options.checkpoint is None else str(options.checkpoint),
    }
    return output(
        options,
        lambda: found.report(shown).with_lines(_left(run, missed, options)),
        lambda: found.as_dict() | files,
        2 if missed else 0 if run.complete else 130,
        written,
    )


def _left(run: fr.Simulation, missed: list[str], options: argparse.Namespace) -> list[tuple[str, str]]:
    """Return lines about what the run left behind beside the files written."""
    lines = [] if options.out else [("written", "nothing: name files with --out")]
    lines += [("not written", what) for what in missed]
    if not run.complete:
        resume = "; the same command continues from the checkpoint" if options.checkpoint else ""
        lines.append(("kept", f"{run.time.size} of {run.problem.frames} frames{resume}"))
    return lines


class _Forewarning(Waiting):
    """Progress that says how long a long run will take, estimated from its first second."""

    due = True

    def __call__(self, done: int, total: int) -> None:
        """Note that ``done`` of ``total`` is done."""
        super().__call__(done, total)
        if self.due and (left := self.remaining) is not None:
            self.due = False
            if left > _LONG:
                say(
                    f"floquetrod: {total:,} steps will take roughly {roughly(left)}; Ctrl-C ends them early, and what "
                    "was simulated by then is reported"
                )


def _frames(load: Load, duration: float, has_friction: bool) -> int:
    if has_friction or load.amplitude == 0.0:
        return _FRAMES
    wanted = min(_FRAMES_A_PERIOD * duration * load.frequency / (2.0 * math.pi), _MOST_FRAMES)
    return max(_FRAMES, math.ceil(wanted) + 1)


def _kinds() -> tuple[str, ...]:
    """Return the ends of names of files that hold a run: a picture, an animation or all its numbers."""
    from floquetrod.plotting import rod_plot

    return (*figures(), *rod_plot.ANIMATIONS, ".npz")


def _require_writers(paths: list[Path], checkpoint: Path | None) -> None:
    """Raise ValueError where an animation needs a program that is missing, or a checkpoint could not be written."""
    from floquetrod._util.sealed_files import writable
    from floquetrod.plotting import rod_plot

    for path in paths:
        rod_plot.require_writer(path)
    if checkpoint is not None:
        try:
            writable(checkpoint)
        except (ValueError, OSError) as error:
            raise ValueError(f"--checkpoint {str(checkpoint)!r}: {error}") from None


def _write_all(run: fr.Simulation, paths: list[Path]) -> tuple[list[str], list[str]]:
    """Write files; return those written, and why others were not, with where the run was kept instead."""
    written, missed = [], []
    for path in paths:
        try:
            with Waiting(f"writing {path}", "pictures") as progress:
                written.append(str(_write(run, path, progress)))
        except (OSError, ValueError) as error:  # a folder may close while a run takes its time
            missed.append(f"{path} could not be written: {getattr(error, 'strerror', None) or error}")
    if missed:
        try:
            spare = run.save(Path(tempfile.mkdtemp(prefix="floquetrod-")) / "run.npz")
            missed.append(f"everything is kept in {spare}")
        except OSError as error:
            missed.append(f"nor could a copy: {error.strerror or error}")
    return written, missed


def _write(run: fr.Simulation, path: Path, progress: Callable[[int, int], None]) -> Path:
    from floquetrod.plotting import chart_plot, rod_plot

    if path.suffix == ".npz":
        return run.save(path)
    if path.suffix in rod_plot.ANIMATIONS:
        return rod_plot.save_animation(run.animate(), path, lambda done, total: progress(done + 1, total))
    return chart_plot.save_figure(run.plot_run(), path)
