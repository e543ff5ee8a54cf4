"""Errors that know which argument they are about, so that a terminal or a file can give it the name that was typed."""

from __future__ import annotations

from typing import NamedTuple, TypeVar

E = TypeVar("E", ValueError, TypeError)


def wrong_value(argument: str, problem: str) -> ValueError:
    """Return an error that says which argument it is about, and carries that for `argument_of`."""
    return _about(argument, problem, ValueError(f"{argument} {problem}"))


def wrong_type(argument: str, problem: str) -> TypeError:
    """Return what `wrong_value` does as a TypeError."""
    return _about(argument, problem, TypeError(f"{argument} {problem}"))


def _about(argument: str, problem: str, error: E) -> E:
    error.__dict__["argument"] = argument, problem
    return error


class Argument(NamedTuple):
    """What an error is about.

    Attributes
    ----------
    name : str
        The argument.
    place : str
        Where in it, "2" in ``modes[2]`` and "kick" in ``over['kick']``; "" for all of it.
    problem : str
        What is wrong with it.
    """

    name: str
    place: str
    problem: str


def argument_of(error: BaseException) -> Argument | None:
    """Return what an error is about; None where it is not about one argument."""
    known: tuple[str, str] | None = getattr(error, "argument", None)
    if known is None:
        return None
    name, _, place = known[0].partition("[")
    return Argument(name, place.rstrip("]").strip("'"), known[1])
