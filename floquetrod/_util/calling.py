"""TypeErrors and AttributeErrors of wrong calls, with the remedy, and the stack level of warnings."""

from __future__ import annotations

import functools
import inspect
import re
import sys
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

from floquetrod._util.suggest import did_you_mean

T = TypeVar("T")
F = TypeVar("F", bound=Callable[..., Any])

_UNKNOWN = re.compile(r"(.+ got an unexpected keyword argument '(\w+)')")


def constructor_hints(**instead: str) -> Callable[[type[T]], type[T]]:
    """Return a decorator of dataclasses, so that TypeErrors about their construction name the remedy.

    The remedy is the argument nearest to an unknown one, or all arguments.  ``instead`` has remedies for common wrong
    names.
    """

    def decorate(target: type[T]) -> type[T]:
        construct: Callable[..., None] = vars(target)["__init__"]

        @functools.wraps(construct)
        def called(self: T, *given: Any, **named: Any) -> None:
            try:
                construct(self, *given, **named)
            except TypeError as error:
                # One entry: raised by the call itself, before anything inside ran.
                if error.__traceback__ is None or error.__traceback__.tb_next is not None:
                    raise
                # Named after the class that was called, which may be derived.
                message = str(error).replace(f"{construct.__qualname__}()", f"{type(self).__name__}()")
                raise TypeError(_with_remedy(message, construct, instead)) from None

        setattr(target, "__init__", called)  # noqa: B010  (an assignment, which mypy takes for unsound)
        return target

    return decorate


def call_hints(positional: str = "", /, **instead: str) -> Callable[[F], F]:
    """Return a decorator of functions, so that TypeErrors about their calls name the remedy, likewise.

    ``positional`` is the remedy for more positional arguments than the function takes.
    """

    def decorate(function: F) -> F:
        @functools.wraps(function)
        def called(*given: Any, **named: Any) -> Any:
            try:
                return function(*given, **named)
            except TypeError as error:
                if error.__traceback__ is None or error.__traceback__.tb_next is not None:
                    raise
                if positional and "positional argument" in str(error) and "given" in str(error):
                    raise TypeError(f"{error}; {positional}") from None
                raise TypeError(_with_remedy(str(error), function, instead)) from None

        return cast(F, called)

    return decorate


def level_of_caller() -> int:
    """Return the stack level, for the caller of this function, of the first frame outside the package."""
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith("floquetrod."):
        level, frame = level + 1, frame.f_back
    return level


def _with_remedy(message: str, function: Callable[..., Any], instead: Mapping[str, str]) -> str:
    """Return the message of a TypeError about a call of a function, with the remedy."""
    parameters = [p for p in inspect.signature(function).parameters.values() if p.name not in ("self", "cls")]
    written = ", ".join(p.name if p.default is p.empty else f"{p.name}={p.default!r}" for p in parameters)
    match = _UNKNOWN.match(message)
    if match is None:
        return f"{message}; its arguments are {written}"
    text, name = match.groups()  # newer Pythons add a guess of their own, which is left out
    hint = f"; {instead[name]}" if name in instead else did_you_mean(name, [p.name for p in parameters])
    return text + (hint or f"; its arguments are {written}")


class TellsAttributes:
    """Base of classes whose AttributeErrors name the public attribute nearest to the unknown one, or all of them."""

    if not TYPE_CHECKING:  # a type checker would take every attribute to exist

        def __getattr__(self, name: str) -> Any:
            """Raise AttributeError for an attribute that does not exist."""
            if hasattr(type(self), name):  # a property that raised AttributeError itself: again, for its message
                return object.__getattribute__(self, name)
            message = f"{type(self).__name__!r} object has no attribute {name!r}"
            if name.startswith("_"):
                raise AttributeError(message, name=name)
            public = sorted(each for each in {*dir(type(self)), *vars(self)} if not each.startswith("_"))
            # With a name and no object, so that Python adds no guess of its own.
            raise AttributeError(message + (did_you_mean(name, public) or f"; it has {', '.join(public)}"), name=name)
