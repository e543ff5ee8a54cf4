"""`floquetrod check --system` and `certify --system`: one system of equations from a file."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import floquetrod as fr
from floquetrod.cli.common import Answer, number, require_file, resonance_record
from floquetrod.cli.waiting import Waiting
from floquetrod.equations.system_files import read_system
from floquetrod.floquet.systems.result import SystemStability
from floquetrod.floquet.verdict import Status

_ROWS = 40
"""Multipliers listed; the others, which decay fastest, are in the JSON."""


def require_alone(options: argparse.Namespace, given: Sequence[str]) -> None:
    """Raise ValueError where options of a rod were given beside a system, by their names in the namespace."""
    if given:
        raise ValueError(
            f"--{given[0].replace('_', '-')} belongs to --rod, got {str(getattr(options, given[0]))!r}: a system "
            "is described by its file alone"
        )


def judge(options: argparse.Namespace) -> tuple[Answer, Status]:
    """Return what to print about the system of ``options.system``, and the verdict."""
    system = _read(options)
    with Waiting("deciding stability, and what damping it takes"):
        result = fr.stability(system, method=options.method or "auto")
        text = json.dumps(_record(result), indent=2, allow_nan=False) if options.json else "\n".join(_report(result))
    return Answer(text), result.status


def prove(options: argparse.Namespace) -> tuple[Answer, Status]:
    """Return what to print about the proof of the system of ``options.system``, and what was proved."""
    system = _read(options)
    with Waiting("proving"):
        proof = cast(fr.Proof, fr.certify(system))  # no box
    record = {"status": proof.status, "statement": proof.statement, "digits": proof.digits}
    heads = {"stable": "PROVED STABLE", "unstable": "PROVED UNSTABLE", "undecided": "UNDECIDED"}
    text = f"{heads[proof.status]}: {proof.statement} ({proof.digits} digits)"
    return Answer(json.dumps(record, indent=2) if options.json else text), proof.status


def _read(options: argparse.Namespace) -> fr.HillSystem | fr.PeriodicSystem:
    """Return the system of ``options.system``."""
    require_file("--system", Path(options.system), "a TOML or npz file")
    try:
        return read_system(options.system)
    except ValueError as error:
        raise ValueError(f"--system: {error}") from None


def _report(result: SystemStability) -> list[str]:
    system, count = result.system, result.system.harmonics.shape[-3]
    form = "second order" if isinstance(system, fr.HillSystem) else "first order"
    varies = f"{count} harmonic{'' if count == 1 else 's'}" if count else "constant coefficients"
    lines = [
        _headline(result),
        "",
        f"system    {system.order} equation{'' if system.order == 1 else 's'} of {form}, {result.structure}, {varies}, "
        f"period {result.period:.6g} (angular frequency {2.0 * math.pi / result.period:.6g})",
    ]
    if result.growth_rate > 0.0:
        lines.append(
            f"growth    {result.growth_rate:.6g} per unit time, tenfold in {math.log(10.0) / result.growth_rate:.4g}"
        )
    if result.decay_rate > 0.0:
        lines.append(f"decay     {result.decay_rate:.6g} per unit time, the slowest motion")
    for i, resonance in enumerate(result.resonances):
        name = f"{resonance}, growth {resonance.growth_rate:.6g}"
        lines.append(f"{'' if i else 'named':<8}  {name}{' (the nearest combination of frequencies)' if not i else ''}")
    lines.append(f"margin    {_margin(result)}")
    lines += _damping(result)
    lines.append(f"method    {result.method}, {result.cost}; multipliers good to {result.error:.0e} relative")
    if result.note:
        lines.append(f"note      {result.note}")
    if result.multipliers:
        lines += ["", "  multiplier                     magnitude      angle/pi    error     Krein sign"]
    rows = zip(result.multipliers, result.multiplier_errors, result.krein_signs, strict=True)
    for mu, error, sign in list(rows)[:_ROWS]:
        angle = math.atan2(mu.imag, mu.real) / math.pi
        krein = {1: "+", -1: "-"}.get(sign, "")
        written = f"{mu.real:+.9f} {mu.imag:+.9f}i" if abs(mu) < 1e4 else f"{mu.real:+.6e} {mu.imag:+.6e}i"
        lines.append(f"  {written:<29}  {abs(mu):<13.9g}  {angle:+9.6f}  {error:8.0e}  {krein:>5}".rstrip())
    if len(result.multipliers) > _ROWS:
        lines.append(f"  and {len(result.multipliers) - _ROWS} more, which decay faster (--json lists them)")
    return lines


def _damping(result: SystemStability) -> list[str]:
    """Return what uniform damping it takes, where it takes any."""
    rate = result.damping_to_stabilise
    if not rate > 0.0:
        return []
    if math.isinf(rate):
        return ["damping   no damping suffices: the mean stiffness alone is unstable"]
    tried = ", as far as tried" if isinstance(result.system, fr.HillSystem) else ""
    return [f"damping   stable at uniform rates above {rate:.6g} per unit time{tried}, added to what there is"]


def _headline(result: SystemStability) -> str:
    if result.status == "unstable":
        return f"UNSTABLE: grows at {result.growth_rate:.6g} per unit time"
    if result.status == "undecided":
        return "UNDECIDED: a multiplier is too close to the unit circle, or two multipliers are too close together"
    if _largest(result) < 0.0:
        return "STABLE: every motion decays"
    if result.strongly_stable:
        return "STABLE, strongly: small changes of the coefficients leave every motion bounded"
    return "STABLE: every motion stays bounded"


def _largest(result: SystemStability) -> float:
    """Return by how much the largest multiplier's magnitude exceeds 1; 0 where all lie on the circle, NaN unknown."""
    rate = max((exponent.real for exponent in result.exponents), default=math.nan)
    if result.status == "stable" and rate * result.period > -result.error:
        return 0.0
    return math.expm1(min(rate * result.period, 700.0)) if rate == rate else math.nan


def _margin(result: SystemStability) -> str:
    largest = _largest(result)
    if largest == 0.0:
        apart = _opposite_signs_apart(result)
        text = "all multipliers lie on the unit circle"
        return text if apart is None else f"{text}; those of opposite Krein signs are {apart:.4g} rad apart or more"
    if math.isnan(largest):
        return "unknown"
    way = "outside" if largest > 0.0 else "inside"
    return f"the largest multiplier lies {abs(largest):.4g} {way} the unit circle"


def _opposite_signs_apart(result: SystemStability) -> float | None:
    """Return the least angle between multipliers of opposite Krein signs, which must meet before any can grow."""
    signed = list(zip(result.exponents, result.krein_signs, strict=True))
    if not all(sign for _, sign in signed):
        return None
    plus, minus = ([e.imag * result.period for e, sign in signed if sign == wanted] for wanted in (1, -1))
    return min((abs(math.remainder(a - b, 2.0 * math.pi)) for a in plus for b in minus), default=None)


def _record(result: SystemStability) -> dict[str, Any]:
    rows = zip(
        result.multipliers,
        result.multiplier_errors,
        result.exponents,
        result.exponent_errors,
        result.krein_signs,
        strict=True,
    )
    return {
        "status": result.status,
        "strongly_stable": result.strongly_stable,
        "growth_rate_per_unit_time": number(result.growth_rate),
        "decay_rate_per_unit_time": result.decay_rate,
        "damping_to_stabilise_per_unit_time": number(result.damping_to_stabilise),
        "largest_multiplier_less_1": number(_largest(result)),
        "opposite_krein_signs_apart_rad": _opposite_signs_apart(result) if result.exponents else None,
        "resonances": [resonance_record(r, "growth_rate") for r in result.resonances],
        "multipliers": [
            {
                "real": number(mu.real),
                "imag": number(mu.imag),
                "error": number(error),
                "exponent_real": s.real,
                "exponent_imag": s.imag,
                "exponent_error": number(doubt),
                "krein_sign": sign,
            }
            for mu, error, s, doubt, sign in rows
        ],
        "equations": result.system.order,
        "structure": result.structure,
        "harmonics": int(result.system.harmonics.shape[-3]),
        "period": result.period,
        "method": result.method,
        "relative_error": number(result.error),
        "cost": str(result.cost),
        "note": result.note,
        "version": fr.__version__,
    }
