"""The answer of `floquetrod check` about a rod whose modes are coupled."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import floquetrod as fr
from floquetrod.cli import verdicts
from floquetrod.cli.common import number, resonance_record
from floquetrod.units import Unit

if TYPE_CHECKING:
    from floquetrod.rod.verdict import RodStability

_ROWS = 10
"""Resonances listed; the others, which grow more slowly, are in the JSON."""


def report(result: RodStability, shown: dict[str, Unit], margins: verdicts.Margins | None) -> list[str]:
    """Return the lines, the verdict first; quantities of the load in the units ``shown``.

    ``margins`` where they were searched.
    """
    lines = [_headline(result), "", *verdicts.subject(result, shown)]
    if result.growth_rate > 0.0:
        time = f"tenfold in {result.time_to_grow(10.0):.4g} s"
        lines.append(f"growth    {result.growth_rate:.6g} 1/s, {time}")
    for i, resonance in enumerate(result.resonances[:_ROWS]):
        lines.append(f"{'' if i else 'grows':<8}  {resonance}, {resonance.growth_rate:.6g} 1/s")
    if len(result.resonances) > _ROWS:
        lines.append(f"          and {len(result.resonances) - _ROWS} more, which grow more slowly (--json lists them)")
    if margins is not None:
        found = verdicts.margins(result, margins, shown, "stable at every rate tried above {}")
        lines += [*found[:3], "          found by sampling: two changes close together may be missed", *found[3:]]
    else:
        lines.append("margins   not searched, because this takes hundreds of verdicts; add --margins")
    lines += [
        f"checked   {result.cutoff}",
        f"method    {result.whole.method}, {result.cost}; growth good to {result.error:.0e} 1/s",
    ]
    if result.note:
        lines.append(f"note      {result.note}")
    return lines


def _headline(result: RodStability) -> str:
    if result.status == "unstable":
        growing = [r for r in result.resonances if r.growth_rate > result.growth_tolerance]
        name = str(growing[0]) if growing else f"grows at {result.growth_rate:.6g} 1/s"
        return f"UNSTABLE: {name}" + (f", and {len(growing) - 1} more" if len(growing) > 1 else "")
    if result.status == "undecided":
        return "UNDECIDED: the error of the growth rate is too large to decide whether the rod is stable"
    return "STABLE"


def record(result: RodStability, margins: verdicts.Margins | None) -> dict[str, Any]:
    """Return the same as numbers for JSON."""
    return {
        **verdicts.verdict_record(result, margins),
        "growth_rate_error_per_s": number(result.error),
        "convergence": [{"modes": modes, "growth_rate_per_s": number(rate)} for modes, rate in result.convergence],
        "resonances": [resonance_record(r, "growth_rate_per_s") for r in result.resonances],
        **verdicts.subject_record(result),
        "load": result.load.kind_as_dict(),
        "structure": result.whole.structure,
        "method": result.whole.method,
        "cost": str(result.cost),
        "note": result.note,
        "version": fr.__version__,
    }
