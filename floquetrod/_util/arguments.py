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
    error.__dict__["argument"] = argument, problem, ""
    return error


def located(where: str, error: Exception, colon: str = ": ") -> ValueError:
    """Return an error about something in a file or a table, which is still about the same argument."""
    found = ValueError(f"{where}{colon}{error}")
    if (known := getattr(error, "argument", None)) is not None:
        found.__dict__["argument"] = *known[:2], ": ".join(filter(None, [where, known[2]]))
    return found


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
    where : str
        In which file it was given, "" for a call.
    """

    name: str
    place: str
    problem: str
    where: str

    def named(self, name: str) -> str:
        """Return the message with another name for the argument."""
        return ": ".join(filter(None, [self.where, f"{name} {self.problem}"]))


def argument_of(error: BaseException) -> Argument | None:
    """Return what an error is about; None where it is not about one argument."""
    known: tuple[str, str, str] | None = getattr(error, "argument", None)
    if known is None:
        return None
    name, _, place = known[0].partition("[")
    return Argument(name, place.rstrip("]").strip("'"), *known[1:])
