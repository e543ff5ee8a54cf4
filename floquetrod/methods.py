"""`fr.methods`: the methods for equations as functions, each by the name it has in `floquetrod.floquet.registry`."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from floquetrod._util.lazy import names_of
from floquetrod.floquet.registry import methods_for

if TYPE_CHECKING:
    from floquetrod.floquet.methods.monodromy import monodromy_matrix as monodromy_matrix
    from floquetrod.floquet.methods.reference import discriminant_excess as discriminant_excess
    from floquetrod.floquet.verdict import Stability

    def __getattr__(name: str) -> Callable[..., Stability]: ...


_NAMES: dict[str, tuple[str, ...]] = {
    f"floquet.methods.{method.name}": (method.name,) for method in methods_for("equations")
}
_NAMES["floquet.methods.monodromy"] += ("monodromy_matrix",)
_NAMES["floquet.methods.reference"] += ("discriminant_excess",)

__all__ = sorted(name for names in _NAMES.values() for name in names)

if not TYPE_CHECKING:
    __getattr__, __dir__ = names_of(__name__, _NAMES)
