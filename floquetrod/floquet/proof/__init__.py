"""Proved verdicts: the signs that decide are found in interval arithmetic, for parameters taken exactly.

`exact_equation` states an equation in exact numbers, `scalar` chooses the proof and draws the conclusion from the signs
of quantities that `floquetrod.floquet.mathieu_chains.enclosed_counts`, `band`, `trace` and `closed_form` enclose.

Of systems of equations, `system_numbers` takes one, or all between several, `system_problem` states them in balls and
`systems` concludes; `system_flow` encloses the map over a period, `system_discs` its eigenvalues, `system_counts`
counts by `inertia`.

*Arithmetic.*  Three kinds of numbers are rounded outwards.  Pairs of doubles: `kernels.double_intervals` in compiled
code; `floquetrod._util.interval` for formulas of rods and for `mathieu_chains.certain_count`, interpreted and to the
next double.  Arrays of balls, a midpoint and a radius: `balls` in doubles, and with the same operations `integers` in
any number of digits; `digits` doubles the digits until a proof succeeds.  Intervals of many digits for single numbers:
`many_digits`, of mpmath's intervals their four operations.  A proof is "undecided" where `Unresolved` was raised: the
arithmetic does not show a sign.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from floquetrod._util.lazy import names_of

if TYPE_CHECKING:
    from floquetrod.floquet.proof.certification import certify
    from floquetrod.floquet.proof.proof import Enclosure, Proof

__all__ = ["Enclosure", "Proof", "certify"]

__getattr__, __dir__ = names_of(
    __name__, {"floquet.proof.certification": ("certify",), "floquet.proof.proof": ("Enclosure", "Proof")}
)
