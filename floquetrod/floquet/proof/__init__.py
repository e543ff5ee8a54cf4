"""Verdicts that are proofs: the signs that decide are found in interval arithmetic, for parameters taken exactly.

`problem` states an equation in exact numbers, `certification` chooses what is computed and draws the conclusion;
`chains`, `band`, `trace` and `closed_form` enclose the quantities that decide.

Of systems of equations, `system_numbers` takes one, or all between several, `system_problem` states them in balls and
`systems` concludes; `system_flow` encloses the map over a period, `system_discs` its eigenvalues, `system_counts`
counts by `inertia`; `balls` and `integers` are the arithmetic.
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
