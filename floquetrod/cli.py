"""The terminal: `floquetrod check`, `map`, `ranges` and `compare`."""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import sys
import time
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

import floquetrod as fr
from floquetrod import units

_CHECK = """\
Judge a rod under an axial load: stable or not, which modes grow, how fast, and how far the load is from a change.

examples:
  floquetrod check --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr --frequency 150
  floquetrod check --rod my_rod.toml --mean 12N --amplitude 3N --frequency 24Hz
  floquetrod check --rod nitinol --mean 0.3Fcr --amplitude 0.2Fcr --frequency 85 --growth-tolerance 0.7 --json

forces: N, kN, lbf or Fcr (the critical force of the rod).  frequencies: rad/s (none means this), Hz, rpm.
rod files: TOML with youngs_modulus, density, radius, length, channel_radius and, if you like, gravity and
damping_rate, as SI numbers or strings such as "68GPa"; radii, not diameters.
"""

_RANGES = """\
List every stable interval of one quantity of the load: give the other two, and what to search.

examples:
  floquetrod ranges --rod nitinol --amplitude 0.2Fcr --frequency 150 --mean 0:1.2Fcr
  floquetrod ranges --rod nitinol --mean 0.34Fcr --amplitude 0.2Fcr --frequency 10Hz:60Hz --growth-tolerance 0.05
  floquetrod ranges --rod my_rod.toml --mean 12N --frequency 24Hz --amplitude 0:5N

The intervals are complete: their ends are transition curves mapped back, not points of a grid, and resonance tongues
of any thinness count unless --growth-tolerance (1/s) says from which growth on they matter.
"""

_MAP = """\
Draw a rod's stability over two of mean force, amplitude and frequency; the third is fixed.

examples:
  floquetrod map --rod nitinol --amplitude 0.2Fcr --mean 0:1.1Fcr --frequency 20:200 --out map.png
  floquetrod map --rod nitinol --frequency 150 --mean 0:1.1Fcr --amplitude 0:0.5Fcr --growth --out map.npz
  floquetrod map --rod my_rod.toml --amplitude 2N --mean 0:12N --frequency 5Hz:60Hz --mark 6N,24Hz

A .png, .pdf or .svg file is a figure, a .npz file all the numbers (floquetrod.Chart.load reads it); give --out twice
for both.
"""

_COMPARE = """\
Judge one equation A'' + 2 c A' = (beta + alpha sin tau) A by every method and show where they agree.

examples:
  floquetrod compare --alpha 0.5 --beta -0.25
  floquetrod compare --alpha 0.5 --beta -0.25 --damping 0.1 --wave square
"""


_KINDS = {"mean": "force", "amplitude": "force", "frequency": "frequency"}
"""Quantities of a load and their kind."""

_LAST_MODE = 20_000  # far beyond any mode that matters: a slip of the keyboard must not fill the memory (a choice)


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        raise ValueError(f"{message} (see {self.prog} --help)")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return 0 when it answered, 2 for input it cannot use, 130 after Ctrl-C."""
    try:
        options = _parser().parse_args(_attached(sys.argv[1:] if argv is None else argv))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", fr.UniformForceWarning)
            text = options.run(options)
        for warning in caught:
            print(f"floquetrod: warning: {warning.message}", file=sys.stderr)
        print(text, flush=True)
    except BrokenPipeError:  # the reader, head say, has seen enough; keep the interpreter from writing more at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except ArithmeticError as error:  # extreme numbers over- or underflow on their way
        print(f"floquetrod: error: numbers too large or too small to work with ({error}); check units", file=sys.stderr)
        return 2
    except (ValueError, OSError) as error:
        print(f"floquetrod: error: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("floquetrod: interrupted", file=sys.stderr)
        return 130
    return 0


def _attached(arguments: Sequence[str]) -> list[str]:
    """Return the arguments with each negative quantity attached to its option.

    argparse takes -0.2Fcr or -1e-3 for an option of its own; --mean=-0.2Fcr leaves no doubt.
    """
    result: list[str] = []
    for argument in arguments:
        if re.match(r"-\.?\d", argument) and result and re.fullmatch(r"--[\w-]+", result[-1]):
            result[-1] += f"={argument}"
        else:
            result.append(argument)
    return result


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="floquetrod",
        description="Floquet stability of a rod vibrated in a channel, and of periodically forced equations.",
        epilog="Try: floquetrod check --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr --frequency 150",
    )
    parser.add_argument("--version", action="version", version=f"floquetrod {fr.__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="command", parser_class=_Parser)

    check = _command(commands, "check", "judge a rod under an axial load", _CHECK, _check)
    _add_rod(check)
    check.add_argument("--mean", required=True, help="mean force, such as 0.2Fcr or 0.34N; negative pulls")
    check.add_argument("--amplitude", required=True, help="amplitude of the force; 0 is the static limit")
    check.add_argument("--frequency", required=True, help="frequency, such as 150 (rad/s) or 24Hz")
    check.add_argument("--modes", help="modes to look at, such as 1-25 or 6,7,8 (default: all that can matter)")

    ranges = _command(commands, "ranges", "list every safe interval of one quantity of the load", _RANGES, _ranges)
    _add_rod(ranges)
    ranges.add_argument("--mean", required=True, help="mean force, or a range from zero such as 0:1.2Fcr")
    ranges.add_argument("--amplitude", required=True, help="amplitude, or a range from zero such as 0:0.5Fcr")
    ranges.add_argument("--frequency", required=True, help="frequency, or a range such as 10Hz:60Hz")

    chart = _command(commands, "map", "draw stability over two quantities of the load", _MAP, _map)
    _add_rod(chart)
    for name in _KINDS:
        chart.add_argument(f"--{name}", required=True, help="a range such as 0:1.1Fcr or 5Hz:60Hz, or one value")
    chart.add_argument("--points", default="400x300", help="columns x rows (default 400x300)")
    chart.add_argument("--growth", action="store_true", help="shade by growth rate")
    chart.add_argument(
        "--mark", help="a point to mark: both varied quantities, in the order mean, amplitude, frequency"
    )
    chart.add_argument("--out", action="append", required=True, type=Path, help="file to write; may be repeated")

    compare = _command(commands, "compare", "judge one equation by every method", _COMPARE, _compare)
    compare.add_argument("--alpha", required=True, type=float, help="amplitude of the coefficient")
    compare.add_argument("--beta", required=True, type=float, help="mean of the coefficient")
    compare.add_argument("--damping", type=float, default=0.0, help="c, per unit tau (default 0)")
    compare.add_argument("--wave", choices=("sine", "square"), default="sine", help="shape of the coefficient")
    return parser


def _command(commands: Any, name: str, summary: str, text: str, run: Any) -> argparse.ArgumentParser:
    first, _, rest = text.partition("\n\n")
    command: argparse.ArgumentParser = commands.add_parser(
        name, help=summary, description=first, epilog=rest, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    command.add_argument("--json", action="store_true", help="print JSON, units in the names")
    command.set_defaults(run=run)
    return command


def _add_rod(command: argparse.ArgumentParser) -> None:
    command.add_argument("--rod", required=True, help="nitinol (the reference rod), or a TOML file")
    command.add_argument("--damping-rate", help="decay rate of free motion in 1/s (replaces that of the rod)")
    command.add_argument("--growth-tolerance", default="0", help="growth in 1/s up to which a mode counts as stable")


def _quantity(text: str, name: str, rod: fr.Rod) -> float:
    """Return a quantity of the load in SI units."""
    return units.quantity(text, f"--{name}", _KINDS[name], critical_force=rod.critical_force)


def _rod(options: argparse.Namespace) -> fr.Rod:
    rod = fr.Rod.nitinol() if options.rod == "nitinol" else fr.Rod.from_toml(options.rod)
    if options.damping_rate is not None:
        rod = rod.replace(damping_rate=units.quantity(options.damping_rate, "--damping-rate", "rate"))
    return rod


# --- check -----------------------------------------------------------------------------------------------------------


def _check(options: argparse.Namespace) -> str:
    rod = _rod(options)
    load = fr.AxialLoad(**{name: _quantity(getattr(options, name), name, rod) for name in _KINDS})
    tolerance = units.quantity(options.growth_tolerance, "--growth-tolerance", "rate")
    result = rod.stability(load, modes=_modes(options.modes), growth_tolerance=tolerance)
    return json.dumps(_record(result), indent=2, allow_nan=False) if options.json else _report(result)


def _modes(text: str | None) -> list[int] | None:
    if text is None:
        return None
    modes: set[int] = set()
    for part in text.split(","):
        match = re.fullmatch(r"\s*(\d{1,9})\s*(?:-\s*(\d{1,9})\s*)?", part, re.ASCII)
        if match is None:
            raise ValueError(f"--modes must be like 1-25 or 6,7,8, got {text!r}")
        first, last = int(match[1]), int(match[2] or match[1])
        if not 1 <= first <= last <= _LAST_MODE:
            raise ValueError(f"--modes must count upwards between 1 and {_LAST_MODE}, got {part.strip()!r} in {text!r}")
        modes.update(range(first, last + 1))
    return sorted(modes)


def _report(result: fr.RodStability) -> str:
    rod, load = result.rod, result.load
    scale = rod.critical_force
    headline = result.status.upper()
    if result.status == "unstable":
        names = ", ".join(map(str, result.unstable_modes))
        headline += f": modes {names} grow" if len(result.unstable_modes) > 1 else f": mode {names} grows"
    lines = [
        headline,
        "",
        f"rod       critical force {scale:.4g} N, critical mode {rod.critical_mode:.3g}",
        f"load      mean {load.mean:.6g} N ({load.mean / scale:.4g} Fcr), amplitude {load.amplitude:.6g} N "
        f"({load.amplitude / scale:.4g} Fcr), {load.frequency:.6g} rad/s ({load.frequency / (2.0 * math.pi):.4g} Hz)",
    ]
    if result.growth_rate > 0.0:
        time = f"tenfold in {result.time_to_grow(10.0):.4g} s"
        lines.append(f"growth    {result.growth_rate:.6g} 1/s in mode {result.fastest_mode}, {time}")
    lines.append(f"margin    {_margin(result)}")
    damping = result.damping_to_stabilise
    if damping > 0.0:
        enough = "no damping suffices: the mean force alone buckles a mode"
        lines.append(f"damping   {enough if math.isinf(damping) else f'stable at any rate above {damping:.6g} 1/s'}")
    worst = max(verdict.error for verdict in result.mode_verdicts)
    methods = ", ".join(sorted({verdict.method for verdict in result.mode_verdicts}))
    lines += [
        f"checked   {result.cutoff}",
        f"method    {methods}; discriminants good to {worst:.0e} relative",
        "",
        "mode       alpha         beta  where                  growth 1/s",
    ]
    for mode, equation, verdict, rate in _near_trouble(result):
        where = str(verdict.interval) if verdict.interval else verdict.status
        lines.append(f"{mode:4d}  {equation.alpha:10.5g}  {equation.beta:11.6g}  {where:<21}  {rate:10.4g}")
    return "\n".join(lines)


def _margin(result: fr.RodStability) -> str:
    margin, scale = result.mean_force_margin, result.rod.critical_force
    sides = [(margin.below, "lower"), (margin.above, "higher")]
    known = [f"{value:.4g} N ({value / scale:.3g} Fcr) {way}" for value, way in sides if math.isfinite(value)]
    if not known:
        return "no change of verdict within 8 Fcr of this mean force"
    change = {"stable": "unstable", "unstable": "stable"}.get(result.status, "decided")
    return f"{change} at a mean force {' or '.join(known)}"


def _near_trouble(result: fr.RodStability) -> list[tuple[int, fr.Mathieu, fr.Stability, float]]:
    """Return the unstable modes and the five whose discriminants come nearest to the boundary, in order of mode."""
    rows = list(zip(result.modes, result.mode_equations, result.mode_verdicts, result.mode_growth_rates, strict=True))

    def room(row: tuple[int, fr.Mathieu, fr.Stability, float]) -> float:
        return -math.inf if row[2].status != "stable" else 2.0 - abs(row[2].discriminant)

    troubled = sum(row[2].status != "stable" for row in rows)
    return sorted(sorted(rows, key=room)[: max(5, troubled)])


def _record(result: fr.RodStability) -> dict[str, Any]:
    margin = result.mean_force_margin
    return {
        "status": result.status,
        "unstable_modes": list(result.unstable_modes),
        "growth_rate_per_s": result.growth_rate,
        "fastest_mode": result.fastest_mode,
        "time_to_grow_tenfold_s": _number(result.time_to_grow(10.0)),
        "mean_force_margin_below_N": _number(margin.below),
        "mean_force_margin_above_N": _number(margin.above),
        "damping_to_stabilise_per_s": _number(result.damping_to_stabilise),
        "modes_checked": result.modes_checked,
        "left_out_growth_bound_per_s": _number(result.left_out_bound),
        "growth_tolerance_per_s": result.growth_tolerance,
        "critical_force_N": result.rod.critical_force,
        "mean_N": result.load.mean,
        "amplitude_N": result.load.amplitude,
        "frequency_rad_per_s": result.load.frequency,
        "modes": [
            {
                "mode": mode,
                "alpha": equation.alpha,
                "beta": equation.beta,
                "status": verdict.status,
                "interval": str(verdict.interval) if verdict.interval else None,
                "growth_rate_per_s": float(rate),
                "discriminant": _number(verdict.discriminant),
                "discriminant_relative_error": _number(verdict.error),
                "method": verdict.method,
            }
            for mode, equation, verdict, rate in zip(
                result.modes, result.mode_equations, result.mode_verdicts, result.mode_growth_rates, strict=True
            )
        ],
        "version": fr.__version__,
    }


def _number(value: float) -> float | None:
    """Return ``value``, or None where JSON has no number for it: infinite means never, or not within reach."""
    return value if math.isfinite(value) else None


# --- ranges ---------------------------------------------------------------------------------------------------------


def _ranges(options: argparse.Namespace) -> str:
    rod = _rod(options)
    texts = {name: getattr(options, name) for name in _KINDS}
    varied = [name for name, text in texts.items() if ":" in text]
    if len(varied) != 1:
        raise ValueError(
            "exactly one of --mean, --amplitude, --frequency must be a range such as 0:1.2Fcr or 10Hz:60Hz, got "
            f"{len(varied)}"
        )
    tolerance = units.quantity(options.growth_tolerance, "--growth-tolerance", "rate")
    values = {name: [_quantity(part, name, rod) for part in text.split(":", 1)] for name, text in texts.items()}
    low, high = values.pop(varied[0])
    fixed = {name: value for name, (value,) in values.items()}
    if varied[0] == "frequency":
        found = rod.stable_frequencies(**fixed, between=(low, high), growth_tolerance=tolerance)
    elif low != 0.0:
        raise ValueError(f"--{varied[0]} must be a range from zero, got {texts[varied[0]]!r}")
    else:
        search = rod.stable_mean_forces if varied[0] == "mean" else rod.stable_amplitudes
        found = search(**fixed, upto=high, growth_tolerance=tolerance)
    if not options.json:
        return repr(found)
    unit = "N" if found.unit == "N" else "rad_per_s"
    record = {
        "quantity": found.quantity,
        f"searched_{unit}": list(found.between),
        "growth_tolerance_per_s": found.growth_tolerance,
        "modes_checked": found.modes,
        "stable": [
            {f"low_{unit}": part.low, f"high_{unit}": part.high, "low_end": part.low_end, "high_end": part.high_end}
            for part in found
        ],
        "ends_are": "[mode, tongue], or null at an end of the search",
        "version": fr.__version__,
    }
    return json.dumps(record, indent=2, allow_nan=False)


# --- map -------------------------------------------------------------------------------------------------------------


def _map(options: argparse.Namespace) -> str:
    from floquetrod import plotting

    rod = _rod(options)
    figures = (".png", ".pdf", ".svg")
    for path in options.out:
        if path.suffix not in (*figures, ".npz"):
            raise ValueError(f"--out must end in .png, .pdf, .svg or .npz, got {str(path)!r}")
        if not path.parent.is_dir():
            raise ValueError(f"--out: there is no folder {str(path.parent)!r}")
    columns, _, rows = options.points.partition("x")
    if not (columns.isdigit() and rows.isdigit() and int(columns) > 1 and int(rows) > 1):
        raise ValueError(f"--points must be like 400x300, got {options.points!r}")
    values = {name: [_quantity(text, name, rod) for text in getattr(options, name).split(":", 1)] for name in _KINDS}
    varied = [name for name, ends in values.items() if len(ends) == 2]
    if len(varied) != 2:
        raise ValueError(f"two of --mean, --amplitude, --frequency must be ranges such as 0:1.1Fcr, got {len(varied)}")
    across = "frequency" if "frequency" in varied else "mean"
    load: dict[str, Any] = {
        name: (*ends, int(columns if name == across else rows)) if name in varied else ends[0]
        for name, ends in values.items()
    }
    tolerance = units.quantity(options.growth_tolerance, "--growth-tolerance", "rate")
    chart = fr.stability_map(
        rod, **load, growth=options.growth, growth_tolerance=tolerance, progress=_Progress("points")
    )
    point = None
    if options.mark is not None:
        texts = options.mark.split(",")
        if len(texts) != 2:
            raise ValueError(f"--mark must be two quantities such as 0.2Fcr,150, got {options.mark!r}")
        place = {name: _quantity(text, name, rod) for name, text in zip(varied, texts, strict=True)}
        up = next(name for name in varied if name != across)
        point = (place[across], place[up])
    for path in options.out:
        if path.suffix == ".npz":
            chart.save(path)
            continue
        axes = chart.plot()
        if point is not None:
            plotting.mark(axes, *point, "the load")
        plotting.save_figure(axes, path)
    written = [str(path) for path in options.out]
    share = float(chart.stable.mean())
    if options.json:
        record = {
            "written": written,
            "points": int(chart.stable.size),
            "stable_share": share,
            "version": fr.__version__,
        }
        return json.dumps(record, indent=2, allow_nan=False)
    return f"{chart.caption}\nwritten: {', '.join(written)}"


class _Progress:
    """A line on stderr once work has taken a second, when there is a terminal to read it."""

    def __init__(self, what: str) -> None:
        self.what, self.start = what, time.monotonic()

    def __call__(self, done: int, total: int) -> None:
        """Report ``done`` of ``total``."""
        spent = time.monotonic() - self.start
        if spent > 1.0 and sys.stderr.isatty():
            left = spent * (total - done) / max(done, 1)
            end = "\n" if done == total else ""
            print(f"\r{done} of {total} {self.what}, {left:.0f} s left ", end=end, file=sys.stderr, flush=True)


# --- compare ---------------------------------------------------------------------------------------------------------


def _compare(options: argparse.Namespace) -> str:
    kind = fr.SquareWave if options.wave == "square" else fr.Mathieu
    comparison = fr.compare(kind(options.alpha, options.beta, options.damping))
    if not options.json:
        return repr(comparison)
    rows = [
        {
            "method": r.method,
            "status": r.status,
            "growth_rate_per_tau": _number(r.growth_rate),
            "discriminant": _number(r.discriminant),
            "log_abs_discriminant": _number(r.log_abs_discriminant),
            "discriminant_relative_error": _number(r.error),
            "cost": str(r.cost),
            "seconds": seconds,
            "note": r.note,
        }
        for r, seconds in zip(comparison.results, comparison.seconds, strict=True)
    ]
    record = {
        "agree": comparison.agree,
        "disagreements": list(comparison.disagreements),
        "methods": rows,
        "version": fr.__version__,
    }
    return json.dumps(record, indent=2, allow_nan=False)
