"""`floquetrod certify`: proofs for every load of a box, on every rod within its tolerances."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from typing import Any

import floquetrod as fr
from floquetrod import units
from floquetrod._util.suggest import did_you_mean
from floquetrod._util.waiting import Waiting
from floquetrod.cli import system
from floquetrod.cli.common import LARGEST, ROD_AND_LOAD, add_subject, describe_command, require_no_values
from floquetrod.cli.loads import Ranges, add_question, read_ranges
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser, whole_number
from floquetrod.floquet.proof.proof import MAX_BOXES
from floquetrod.floquet.proof.region_proof import RegionProof
from floquetrod.rod.answers.safe_box import SafeBox
from floquetrod.rod.model.constants import SLOW_GROWTH
from floquetrod.rod.model.parameters import DIAMETERS, GIVEN

_HELP = """\
Prove that a rod is stable, or unstable, under every load of a box and for every rod within the tolerances;
or that a system of equations is.

examples:
  floquetrod example my_rod.toml system.toml
  floquetrod certify --rod nitinol --mean 0.33:0.35Fcr --amplitude 0.2Fcr --frequency 150rad/s --growth-tolerance 0.05
  floquetrod certify --rod my_rod.toml --mean 3.5N:4.5N --amplitude 2N --frequency 14Hz:15Hz --vary length=5.95:6.05
  floquetrod certify --rod nitinol --mean 0.34Fcr --amplitude 0.2Fcr --frequency 150rad/s --growth-tolerance 0.05
  floquetrod certify --rod my_rod.toml --mean 4N --amplitude 2N --frequency 14.5Hz --largest --vary length=5.95:6.05
  floquetrod certify --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr --frequency 149:151rad/s --json --exit-code
  floquetrod certify --system system.toml

stable: no mode of any rod grows faster than --growth-tolerance under any load of the box; the default is 1e-6 1/s,
tenfold in a month.  unstable: some mode grows faster under every load.  mixed: some loads are stable and some are
unstable, with a proved example of each.  undecided: --max-boxes was not enough work.
The proofs use interval arithmetic, rounded outwards, and cover all modes.
--largest: find the widest proved box about one load, which is given as three numbers.
Modes must be independent: ends hinged, no --wave, --mean-at none in an inclined channel.
exit status: 0 for every result; with --exit-code 0 stable, 1 unstable or mixed, 3 undecided; 2 for invalid input.
"""

_STATUS = {"stable": 0, "unstable": 1, "mixed": 1, "undecided": 3}
"""Exit statuses of --exit-code."""


def add(certify: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(certify, _HELP, _certify, ("system", *ROD_AND_LOAD), has_assumptions=True)
    add_question(certify, add_subject(certify), subsystem="proofs", ranges=True)
    certify.set_defaults(growth_tolerance=f"{SLOW_GROWTH:g}")
    certify.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="NAME=LOW:HIGH",
        help="a tolerance of the rod, such as length=3.05:3.15, radius=1%% or radius=±0.01mm, the latter two to either "
        "side of its own value, which may stand before: length=75ft±0.05ft; may be repeated",
    )
    certify.add_argument("--largest", action="store_true", help="find the widest safe box about one load")
    certify.add_argument(
        "--max-boxes", metavar="N", type=whole_number, default=MAX_BOXES, help=f"work allowed (default {MAX_BOXES})"
    )
    certify.add_argument(
        "--exit-code", action="store_true", help="exit with 1 when unstable or mixed, 3 when undecided"
    )


def _certify(options: argparse.Namespace) -> Output:
    if options.system is not None:
        system.require_alone(options)
        answer, status = system.prove(options)
        return answer._replace(status=_STATUS[status] if options.exit_code else 0)
    require_no_values(options)
    asked = read_ranges(options)
    rod, like, values, tolerance, shown, _ = asked
    shown = _typed(options.vary) | shown
    tolerances = dict(_tolerance(text, rod) for text in options.vary)
    asked.warn_of_hertz(options)
    if len(tolerances) < len(options.vary):
        raise ValueError(f"--vary must name a parameter once, got {', '.join(options.vary)}")
    if options.largest:
        if asked.varied:
            wide = asked.varied[0]
            raise ValueError(
                f"--largest needs one load to search about, got --{wide} {getattr(options, wide)}; give one value"
            )
        load = like.with_numbers(**{name: value for name, (value,) in values.items()})
        with Waiting("searching the widest safe box", "sides moved") as progress:
            largest = rod.largest_safe_box(load, growth_tolerance=tolerance, rod=tolerances, progress=progress)
        return _answer(options, largest, largest.proof, shown, asked)
    box: dict[str, Any] = {name: tuple(ends) if len(ends) > 1 else ends[0] for name, ends in values.items()}
    with Waiting("proving", "boxes") as progress:
        proof = rod.certify(
            like,
            **box,
            growth_tolerance=tolerance,
            rod=tolerances,
            max_boxes=options.max_boxes,
            progress=progress,
        )
    return _answer(options, proof, proof, shown, asked)


def _answer(
    options: argparse.Namespace,
    result: RegionProof | SafeBox,
    proof: RegionProof,
    shown: dict[str, str],
    asked: Ranges,
) -> Output:
    """Return the answer, and an exit status where that is asked for."""
    status = _STATUS[proof.status] if options.exit_code else 0
    return output(
        options, lambda: asked.titled(result.report(shown)), lambda: result.as_dict() | asked.as_numbers, status
    )


_ALIKE = 1e-6  # of a value typed and the rod's own, relatively: digits that are not written
_VARY = "a parameter of the rod and its range, such as length=3.05:3.15, length=1% or length=±5mm"


def _tolerance(text: str, rod: fr.Rod) -> tuple[str, tuple[float, float]]:
    """Return a parameter of the rod and both ends of it in SI units; an end without a unit has the unit of the other.

    A percentage, and what follows the sign ±, is a tolerance to either side of the rod's own value.
    """
    name, equals, ends = text.partition("=")
    name = name.strip().lower().replace("-", "_")
    name = "channel_diameter" if name == "bore" else name
    own = rod.parameters | {key: 2.0 * rod.parameters[radius] for key, radius in DIAMETERS.items()}
    if not equals or name not in own:
        hint = did_you_mean(name, own) or f"; the parameters are {', '.join(own)}"
        hint = "; give inner_diameter in its place" if name == "wall_thickness" else hint
        raise ValueError(f"--vary must be {_VARY}, got {text!r}{hint}")
    ends = ends.strip()
    if ":" in ends and "%" in ends:
        raise ValueError(f"--vary must be {_VARY}, got {text!r}; a percentage is a tolerance to either side")
    if about := re.fullmatch(r"([^±]+?)(?:±|\+/?-)(.+)", ends):
        return name, _about_a_value(own[name], about[1], about[2], name, text)
    either_side = re.sub(r"^(±|\+/?-)", "", ends)
    if either_side != ends or units.unit_of(ends) == "%":
        return name, _about(own[name], either_side, name, text)
    first, colon, last = ends.partition(":")
    if not colon:
        is_own = abs(_of_a_rod(ends, name, text) - own[name]) <= _ALIKE * abs(own[name])
        hint = f", the rod's own; a tolerance is {name}={ends}±1%"
        hint = hint if is_own else f"; a tolerance of that size is {name}=±{ends}"
        raise ValueError(f"--vary must be {_VARY}, got {text!r}, which is one value{hint}")
    low, high = (_of_a_rod(end, name, text) for end in units.same_unit(first, last))
    if low > high:
        raise ValueError(f"--vary must be a range whose first end is the lower one, got {text!r}")
    return name, (low, high)


def _about_a_value(own: float, value: str, tolerance: str, name: str, text: str) -> tuple[float, float]:
    """Return the ends of a range about a value that is typed too, which must be the rod's own."""
    unit = units.unit_of(tolerance)
    of_value = units.unit_of(value) or ("" if unit in (None, "%") else unit) or ""
    typed = _of_a_rod(value if units.unit_of(value) else f"{value}{of_value}", name, text)
    low, high = _about(own, tolerance if unit else f"{tolerance}{of_value}", name, text)
    if abs(typed - own) > _ALIKE * abs(own):
        size, shown = 0.5 * (high - low), units.unit(of_value, "--vary", GIVEN[name].kind)
        ends = f"{shown.of(typed - size):.6g}:{shown.of(typed + size):.6g}{shown.name}"
        raise ValueError(
            f"--vary must be a tolerance about the rod's own {name}, {shown.show(own)}, got {text!r}; write "
            f"{name}=±{tolerance.strip()}, or {name}={ends} for a range about another"
        )
    return low, high


def _typed(vary: Sequence[str]) -> dict[str, str]:
    """Return the unit of the first length, and of the first pressure, among tolerances."""
    shown_units: dict[str, str] = {}
    for text in vary:
        for part in reversed(re.split(r"[:±]|\+/?-", text.partition("=")[2])):
            typed = units.unit_of(part)
            kind = units.kind_of(typed or "")
            if typed and kind in ("length", "pressure") and kind not in shown_units:
                shown_units[kind] = units.unit(typed, "--vary", kind).name
    return shown_units


def _about(own: float, tolerance: str, name: str, text: str) -> tuple[float, float]:
    """Return the ends of a range about the rod's own value."""
    size = _of_a_rod(tolerance, name, text, own)
    if size < 0.0:
        raise ValueError(f"--vary must be a tolerance of zero or more, got {text!r}")
    return own - size, own + size


def _of_a_rod(value: str, name: str, text: str, own: float | None = None) -> float:
    return GIVEN[name].quantity(value, "--vary", nominal=own, largest=LARGEST * LARGEST, given=repr(text))
