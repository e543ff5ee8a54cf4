"""Public names that have another one now: they work, warn, and are removed in the version that the warning names."""

from __future__ import annotations

import warnings
from typing import Any


class Renamed:
    """An attribute, now called ``name``, under its earlier name, up to the version ``until``."""

    def __init__(self, name: str, until: str) -> None:
        self.name, self.until = name, until

    def __set_name__(self, owner: type, earlier: str) -> None:
        """Learn the earlier name."""
        self.earlier = earlier
        self.__doc__ = f"Earlier name of `{self.name}`, until version {self.until}."

    def __get__(self, instance: Any, owner: type) -> Any:
        """Return the attribute, with a `DeprecationWarning`."""
        if instance is None:
            return self
        text = f"{owner.__name__}.{self.earlier} is removed in version {self.until}; use {self.name}"
        warnings.warn(text, DeprecationWarning, stacklevel=2)
        return getattr(instance, self.name)
