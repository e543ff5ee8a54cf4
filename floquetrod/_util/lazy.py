"""Names of a package that are loaded when they are first used, so that its modules can be imported one by one."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from typing import Any


def names_of(package: str, where: dict[str, tuple[str, ...]]) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return ``__getattr__`` and ``__dir__`` of a package whose names are in modules, ``where`` by module (PEP 562).

    A name must not be that of a module of the package, which takes its place once it is imported.
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
