"""Six methods, one per file, none of which calls another: from an equation to a `Stability`."""

from __future__ import annotations

from floquetrod.floquet.methods.determinant import determinant
from floquetrod.floquet.methods.leapfrog import leapfrog
from floquetrod.floquet.methods.monodromy import monodromy, monodromy_matrix
from floquetrod.floquet.methods.reference import discriminant_excess, reference
from floquetrod.floquet.methods.spectral import spectral
from floquetrod.floquet.methods.square_wave import square_wave

# Imported at once, not on first use: a module of the same name, imported later, would take the function's place.
__all__ = [
    "determinant",
    "discriminant_excess",
    "leapfrog",
    "monodromy",
    "monodromy_matrix",
    "reference",
    "spectral",
    "square_wave",
]
