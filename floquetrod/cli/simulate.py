"""`floquetrod simulate`: the whole rod through time, against theory."""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import floquetrod as fr
from floquetrod import units
from floquetrod._util.files import writable
from floquetrod.cli.common import (
    Answer,
    Progress,
    add_command,
    add_rod,
    add_units,
    number,
    read_rod,
    read_units,
    roughly,
    warnings_at_once,
)
from floquetrod.cli.loads import describe_load, read_load
from floquetrod.cli.starts import read_perturbation
from floquetrod.rod.stability import growth_of_modes
from floquetrod.simulation.growth import GrowthFit
from floquetrod.units import Unit

_HELP = """\
Simulate the whole nonlinear rod in its channel, with or without friction, and compare it with the theory.

examples:
  floquetrod simulate --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr --frequency 150 --out run.png --out run.npz
  floquetrod simulate --rod nitinol --mean 0.825Fcr --amplitude 0.7Fcr --frequency 150 --friction 0.1 --kick 9:50mm/s
  floquetrod simulate --rod nitinol --mean 0.424Fcr --amplitude 0.7Fcr --frequency 150 --mu 0.1 --case C:10 --seed 2
  floquetrod simulate --rod my_rod.toml --mean 6N --amplitude 2N --frequency 24Hz --duration 4s --out run.gif
  floquetrod simulate --rod my_rod.toml --mean 6N --amplitude 2N --frequency 24Hz --duration 60s --checkpoint run.ckpt

perturbations add up; none means --random 1mm/s.  Cases are those of the paper, with speeds of 50 mm/s: A one mode,
B modes 4, 6, 8, 10, C one mode and all others up to 20 at random, D every node at random; A:6, C:6 name the mode (8).

A .png, .pdf or .svg file shows the rod from above and the growth of its modes, a .gif or .mp4 moves (the latter needs
ffmpeg), a .npz holds everything (floquetrod.Simulation.load reads it).  Ctrl-C ends the run early: what was simulated
so far is written and reported, and with a checkpoint the same command continues later.  The exit status is then 130; it
is 2 for input that cannot be used, a run that diverges included, and where a file could not be written.

Segments cost: half as many take a quarter of the time.  Growth rates of the reference rod are right to 1 % with 250
segments, 3 % low with 100 and 10 % with 60.
"""

_FRAMES = 400  # at least: a picture every 5 ms of two seconds (a choice)
_FRAMES_A_PERIOD = 10  # of the forcing, without friction: two more than the fit of a growth rate asks for
_MOST_FRAMES = 100_000  # unless --frames names more (a choice)
_LONG = 60.0  # s: of runs that take longer, this is said at their beginning (a choice)


def add(commands: Any) -> None:
    """Add the command to the parser."""
    command = add_command(commands, "simulate", "simulate a rod and compare it with theory", _HELP, _simulate)
    add_rod(command, judged=False)
    add_units(command)
    command.add_argument("--mean", required=True, help="mean force, such as 0.2Fcr or 0.34N; negative pulls")
    command.add_argument("--amplitude", required=True, help="amplitude of the force")
    command.add_argument("--frequency", required=True, help="frequency, such as 150 (rad/s) or 24Hz")
    command.add_argument("--duration", default="2s", help="how long to simulate (default 2s)")
    command.add_argument("--friction", "--mu", type=float, default=0.0, help="coefficient of friction (default 0)")
    command.add_argument("--kick", action="append", default=[], help="speed in a mode, such as 8:50mm/s; repeatable")
    command.add_argument("--random", help="every node its own speed, up to this, such as 1mm/s")
    command.add_argument("--case", help="perturbation of the paper: A, B, C or D, with a mode as in A:6")
    command.add_argument("--seed", type=int, help="of what is drawn at random (default 1)")
    command.add_argument("--segments", type=int, default=250, help="segments of the rod (default 250)")
    command.add_argument("--time-step", help="largest step, such as 2us (default: the largest stable one)")
    command.add_argument("--frames", type=int, help="frames kept (default: 400, more where the growth rate asks it)")
    command.add_argument("--checkpoint", type=Path, help="file to keep up to date, and to continue from if it exists")
    command.add_argument("--out", action="append", default=[], type=Path, help="file to write; may be repeated")


def _simulate(options: argparse.Namespace) -> Answer:
    rod = read_rod(options)
    load = read_load(options, rod, fr.AxialLoad(0.0, 0.0, 1.0))
    duration = units.quantity(options.duration, "--duration", "time")
    step = None if options.time_step is None else units.quantity(options.time_step, "--time-step", "time")
    perturbation, shown = read_perturbation(options), read_units(options, rod)
    _check_kinds(options.out)
    _check_places([*options.out, *filter(None, [options.checkpoint])])
    progress = Progress("steps")
    problem = fr.SimulationProblem(
        rod,
        load,
        duration=duration,
        friction=options.friction,
        perturbation=perturbation,
        segments=options.segments,
        time_step=step,
        frames=_frames(load, duration, options.friction) if options.frames is None else options.frames,
    )
    try:
        with warnings_at_once(progress):
            run = problem.run(_Forewarning(progress), options.checkpoint)
    except fr.SimulationDiverged as error:
        progress.close()
        kept, missed = _write_all(error.simulation, [path for path in options.out if path.suffix == ".npz"])
        where = f", in {kept[0]}" if kept else ""
        raise ValueError("; ".join([f"{error}{where}", *missed])) from None
    progress.close()
    written, missed = _write_all(run, options.out)
    record = _record(run) | {
        "written": written,
        "not_written": missed,
        "checkpoint": None if options.checkpoint is None else str(options.checkpoint),
        "version": fr.__version__,
    }
    text = json.dumps(record, indent=2, allow_nan=False) if options.json else _report(run, record, shown)
    return Answer(text, 2 if missed else 0 if run.complete else 130)


class _Forewarning:
    """Progress that says how long a long run will take, estimated from its first second."""

    def __init__(self, progress: Progress) -> None:
        self.progress = progress
        self.start: tuple[float, int] | None = None
        self.due = True

    def __call__(self, done: int, total: int) -> None:
        """Report ``done`` of ``total``."""
        now = time.monotonic()
        since, begun = self.start = self.start or (now, done)
        if self.due and now - since >= 1.0:
            self.due = False
            left = (total - done) * (now - since) / (done - begun)
            if left > _LONG:
                self.progress.close()
                print(
                    f"floquetrod: {total:,} steps will take roughly {roughly(left)}; Ctrl-C ends them early, and what "
                    "was simulated by then is reported",
                    file=sys.stderr,
                    flush=True,
                )
        self.progress(done, total)


def _frames(load: fr.AxialLoad, duration: float, friction: float) -> int:
    if friction > 0.0 or load.amplitude == 0.0:
        return _FRAMES
    wanted = min(_FRAMES_A_PERIOD * duration * load.frequency / (2.0 * math.pi), _MOST_FRAMES)
    return max(_FRAMES, math.ceil(wanted) + 1)


def _check_places(paths: list[Path]) -> None:
    """Raise ValueError where a file could not be written or would be written over by another of this run."""
    for place, path in enumerate(paths):
        writable(path)
        if os.path.realpath(path) in map(os.path.realpath, paths[:place]):
            raise ValueError(f"{path} is named twice; give every file its own name")


def _check_kinds(paths: list[Path]) -> None:
    from floquetrod.plotting import charts, rod

    for path in paths:
        if path.suffix not in (*charts.FIGURES, *rod.ANIMATIONS, ".npz"):
            raise ValueError(f"--out must end in .png, .pdf, .svg, .gif, .mp4 or .npz, got {str(path)!r}")
        rod.require_writer(path)


def _write_all(run: fr.Simulation, paths: list[Path]) -> tuple[list[str], list[str]]:
    """Write files; return those written, and why others were not, with where the run was kept instead."""
    written, missed = [], []
    for path in paths:
        try:
            written.append(str(_write(run, path)))
        except OSError as error:
            missed.append(f"{path} could not be written: {error.strerror or error}")
    if missed:
        try:
            spare = run.save(Path(tempfile.mkdtemp(prefix="floquetrod-")) / "run.npz")
            missed.append(f"everything is kept in {spare}")
        except OSError as error:
            missed.append(f"nor could a copy: {error.strerror or error}")
    return written, missed


def _write(run: fr.Simulation, path: Path) -> Path:
    from floquetrod.plotting import charts, rod

    if path.suffix == ".npz":
        return run.save(path)
    if path.suffix in rod.ANIMATIONS:
        progress = Progress(f"pictures of {path.name}")
        return rod.save_animation(run.animate(), path, lambda done, total: progress(done + 1, total))
    return charts.save_figure(run.plot_run(), path)


def _record(run: fr.Simulation) -> dict[str, Any]:
    problem, steps = run.problem, run.time_steps
    mode, linear = run.dominant_mode, run.rod.stability(problem.load)
    predicted = float(growth_of_modes(run.rod, problem.load, [mode])[0])
    fit: GrowthFit | None = None
    why_not: str | None = "with friction nothing grows exponentially"
    if problem.friction == 0.0:
        try:
            fit, why_not = run.growth_rate(mode), None
        except ValueError as error:
            why_not = str(error)
    needed = run.rod.critical_kick(problem.load, friction=problem.friction) if problem.friction > 0.0 else None
    work = float(abs(run.energy["work"]).max())
    return {
        "buckled": run.buckled,
        "dominant_mode": mode,
        "largest_angle_degrees": math.degrees(float(run.largest_angle.max())),
        "growth_rate_per_s": None if fit is None else fit.rate,
        "growth_rate_error_per_s": None if fit is None else fit.error,
        "growth_fitted_until_s": None if fit is None else fit.end,
        "growth_not_fitted_because": why_not,
        "predicted_growth_rate_per_s": predicted,
        "predicted_status": linear.status,
        "predicted_unstable_modes": list(linear.unstable_modes),
        "predicted_fastest_mode": linear.fastest_mode,
        "critical_kick_m_per_s": None if needed is None else number(needed.kick),
        "critical_kick_mode": None if needed is None else needed.mode,
        "perturbation": str(problem.perturbation),
        "mean_N": problem.load.mean,
        "amplitude_N": problem.load.amplitude,
        "frequency_rad_per_s": problem.load.frequency,
        "mu": problem.friction,
        "complete": run.complete,
        "simulated_s": float(run.time[-1]),
        "duration_s": problem.duration,
        "segments": problem.segments,
        "frames": int(run.time.size),
        "time_step_s": steps.size,
        "time_step_set_by": steps.limit,
        "steps": steps.count,
        "energy_error_J": float(abs(run.energy_error).max()),
        "energy_work_J": work,
        "wall_time_s": run.seconds,
    }


def _report(run: fr.Simulation, record: dict[str, Any], shown: dict[str, Unit]) -> str:
    problem, steps = run.problem, run.time_steps
    angle = f"largest angle {record['largest_angle_degrees']:.3g} degrees"
    status = f"BUCKLED: mode {record['dominant_mode']} leads, {angle}" if run.buckled else f"NOT BUCKLED: {angle}"
    lines = [
        status if run.complete else f"INTERRUPTED at {run.time[-1]:.4g} s of {problem.duration:g} s; so far {status}"
    ]
    lines += [
        "",
        f"load      {describe_load(problem.load, shown, run.rod)}",
        f"start     {record['perturbation']}; friction {problem.friction:g}",
        f"growth    {_growth(record)}",
        f"theory    {_theory(record, shown['kick'])}",
        f"energy    kinetic + potential + dissipated - work off by {record['energy_error_J']:.1g} J, of "
        f"{record['energy_work_J']:.3g} J of work",
        f"step      {1e6 * steps.size:.3g} us, set by {_BOUNDS[steps.limit]}",
        f"cost      {record['wall_time_s']:.3g} s of wall time for {record['simulated_s']:.4g} s of {problem.segments} "
        "segments",
    ]
    nothing = "nothing" if record["not_written"] else "nothing: name files with --out"
    lines.append(f"written   {', '.join(record['written']) or nothing}")
    lines += [f"not       {what}" for what in record["not_written"]]
    if not run.complete:
        resume = "; the same command continues from the checkpoint" if record["checkpoint"] else ""
        lines.append(f"kept      {record['frames']} of {problem.frames} frames{resume}")
    return "\n".join(lines)


_BOUNDS = {
    "stretch": "stretch: waves along the rod must not pass a segment in one step",
    "shear": "shear: neighbouring segments turning against each other are the fastest motion",
    "contact": "contact: the wall is stiffer than the rod",
    "choice": "--time-step",
}


def _growth(record: dict[str, Any]) -> str:
    mode, rate, predicted = record["dominant_mode"], record["growth_rate_per_s"], record["predicted_growth_rate_per_s"]
    if rate is None:
        return f"not fitted: {record['growth_not_fitted_because']}"
    off = f" ({100.0 * (rate / predicted - 1.0):+.2f} %)" if predicted > 0.0 else ""
    error = record["growth_rate_error_per_s"]
    return (
        f"{rate:.5g} +- {error:.1g} 1/s in mode {mode} up to {record['growth_fitted_until_s']:.3g} s; "
        f"predicted {predicted:.5g} 1/s{off}"
    )


def _theory(record: dict[str, Any], speed: Unit) -> str:
    modes = record["predicted_unstable_modes"]
    which = f"modes {', '.join(map(str, modes))} grow" if len(modes) > 1 else f"mode {modes[0]} grows" if modes else ""
    linear = f"{record['predicted_status']}{which and ': '}{which}"
    if record["mu"] == 0.0:
        return linear
    linear = f"without friction {linear}"
    if record["critical_kick_m_per_s"] is None:
        return linear
    kick = f"{speed.show(record['critical_kick_m_per_s'], 3)} in mode {record['critical_kick_mode']} alone"
    return f"{linear}; against friction the smallest kick found to buckle it is {kick}"
