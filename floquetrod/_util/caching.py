"""Properties computed once and kept, without a lock."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, Self, TypeVar, cast, overload

T = TypeVar("T")


class cached_property(functools.cached_property[T]):
    """A `functools.cached_property` that holds no lock while it computes.

    Up to Python 3.11 the library's property holds one lock for all instances of a class: instances wait for each
    other, and in a process forked while another thread computes, the lock stays held for ever.  Without it, several
    threads may compute the value of one instance at once; all of them get the one that was kept first.
    """

    def __init__(self, func: Callable[[Any], T]) -> None:
        super().__init__(func)
        self.__module__ = func.__module__  # as of Python 3.13: doctest leaves out objects of other modules

    @overload
    def __get__(self, instance: None, owner: type[Any] | None = None) -> Self: ...
    @overload
    def __get__(self, instance: object, owner: type[Any] | None = None) -> T: ...
    def __get__(self, instance: object | None, owner: type[Any] | None = None) -> Any:
        """Return the value kept in the instance, computed if there is none."""
        if instance is None:
            return self
        kept = vars(instance)
        name = cast(str, self.attrname)
        if name in kept:  # by another thread, since Python looked
            return kept[name]
        return kept.setdefault(name, self.func(instance))
