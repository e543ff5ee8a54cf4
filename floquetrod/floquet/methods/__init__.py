"""Six methods, each in a file of its own, none of which calls another: an equation in, a `Stability` out."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from floquetrod.floquet.methods.determinant import determinant as determinant
    from floquetrod.floquet.methods.leapfrog import leapfrog as leapfrog
    from floquetrod.floquet.methods.monodromy import monodromy as monodromy
    from floquetrod.floquet.methods.monodromy import monodromy_matrix as monodromy_matrix
    from floquetrod.floquet.methods.reference import discriminant_excess as discriminant_excess
    from floquetrod.floquet.methods.reference import reference as reference
    from floquetrod.floquet.methods.spectral import spectral as spectral
    from floquetrod.floquet.methods.square_wave import square_wave as square_wave

_WHERE = {
    "determinant": "determinant",
    "leapfrog": "leapfrog",
    "monodromy": "monodromy",
    "monodromy_matrix": "monodromy",
    "reference": "reference",
    "discriminant_excess": "reference",
    "spectral": "spectral",
    "square_wave": "square_wave",
}

__all__ = list(_WHERE)


def __getattr__(name: str) -> Any:
    """Load a method when it is first used: most of them need libraries that take time to load."""
    if name not in _WHERE:
        raise AttributeError(f"module 'floquetrod.methods' has no attribute {name!r}; see dir(floquetrod.methods)")
    return getattr(importlib.import_module(f"floquetrod.floquet.methods.{_WHERE[name]}"), name)


def __dir__() -> list[str]:
    return __all__
