"""`fr.methods`: the methods for equations as functions."""

from __future__ import annotations

from floquetrod.floquet.methods.determinant import determinant
from floquetrod.floquet.methods.leapfrog import leapfrog
from floquetrod.floquet.methods.monodromy import monodromy, monodromy_matrix
from floquetrod.floquet.methods.reference import discriminant_excess, reference
from floquetrod.floquet.methods.spectral import spectral
from floquetrod.floquet.methods.square_wave import square_wave

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
