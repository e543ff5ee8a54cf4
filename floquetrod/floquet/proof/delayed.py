"""Proofs for systems with delays: none yet, which is what is said."""

from __future__ import annotations

from floquetrod.equations import DelaySystem
from floquetrod.floquet.proof.result import Proof


def certify_delayed(system: DelaySystem) -> Proof:
    """Return what is proved of a system with delays."""
    statement = "not implemented for systems with delays; fr.stability and fr.compare judge with estimated errors"
    return Proof(system, "undecided", None, 0, statement)
