"""Names of a package loaded on first use, so that its modules can be imported one by one."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from typing import Any


def names_of(package: str, where: dict[str, tuple[str, ...]]) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return ``__getattr__`` and ``__dir__`` of a package whose names are in modules, ``where`` by module (PEP 562).

    No name may equal the name of a module of the package, which replaces it once it is imported.
    """
    module_of = {name: module for module, names in where.items() for name in names}

    def load(name: str) -> Any:
        """Import the module of a name, and keep the name in the package."""
        if name not in module_of:
            from floquetrod._util.suggest import did_you_mean

            hint = "" if name.startswith("_") else did_you_mean(name, module_of)
            raise AttributeError(f"module {package!r} has no attribute {name!r}{hint}")
        value = getattr(importlib.import_module(f"floquetrod.{module_of[name]}"), name)
        setattr(sys.modules[package], name, value)
        return value

    return load, lambda: sorted(module_of)
