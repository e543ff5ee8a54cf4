"""The answer of `floquetrod check` about a rod whose modes are independent."""

from __future__ import annotations

import math
from typing import Any

import floquetrod as fr
from floquetrod.cli import verdicts
from floquetrod.cli.common import number
from floquetrod.units import Unit


def report(result: fr.RodStability, shown: dict[str, Unit], margins: verdicts.Margins | None) -> list[str]:
    """Return the lines: the verdict first, a table of modes last; quantities of the load in the units ``shown``.

    ``margins`` where they were searched.
    """
    headline = result.status.upper()
    if result.status == "unstable":
        names = ", ".join(map(str, result.unstable_modes))
        headline += f": modes {names} grow" if len(result.unstable_modes) > 1 else f": mode {names} grows"
    lines = [headline, "", *verdicts.subject(result, shown)]
    if result.growth_rate > 0.0:
        time = f"tenfold in {result.time_to_grow(10.0):.4g} s"
        lines.append(f"growth    {result.growth_rate:.6g} 1/s in mode {result.fastest_mode}, {time}")
    if margins is not None:
        lines += verdicts.margins(result, margins, shown, "stable at any rate above {}")
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
    return lines


def _near_trouble(result: fr.RodStability) -> list[tuple[int, fr.Mathieu, fr.Stability, float]]:
    """Return the unstable modes and the five whose discriminants come nearest to the boundary, in order of mode."""
    rows = list(zip(result.modes, result.mode_equations, result.mode_verdicts, result.mode_growth_rates, strict=True))

    def room(row: tuple[int, fr.Mathieu, fr.Stability, float]) -> float:
        return -math.inf if row[2].status != "stable" else 2.0 - abs(row[2].discriminant)

    troubled = sum(row[2].status != "stable" for row in rows)
    return sorted(sorted(rows, key=room)[: max(5, troubled)])


def record(result: fr.RodStability, margins: verdicts.Margins | None) -> dict[str, Any]:
    """Return the same as numbers for JSON."""
    return {
        **verdicts.verdict_record(result, margins),
        "left_out_growth_bound_per_s": number(result.left_out_bound),
        **verdicts.subject_record(result),
        "modes": [
            {
                "mode": mode,
                "alpha": equation.alpha,
                "beta": equation.beta,
                "status": verdict.status,
                "interval": str(verdict.interval) if verdict.interval else None,
                "growth_rate_per_s": float(rate),
                "discriminant": number(verdict.discriminant),
                "discriminant_relative_error": number(verdict.error),
                "method": verdict.method,
            }
            for mode, equation, verdict, rate in zip(
                result.modes, result.mode_equations, result.mode_verdicts, result.mode_growth_rates, strict=True
            )
        ],
        "version": fr.__version__,
    }
