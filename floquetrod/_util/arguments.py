"""Errors that know which argument they are about, and messages which others they name.

So a terminal or a file can give them the names that were typed, and nobody reads an argument from a message.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeVar

E = TypeVar("E", ValueError, TypeError)


class Mention(NamedTuple):
    """What a message names beside the argument that it is about, most often in a remedy."""

    name: str  # the argument; "" for what makes sense in Python alone
    python: str = ""  # how it is written in Python, where that is not the name: "mean_at=None"
    value: str = ""  # what the remedy sets it to, as it is typed in a terminal: "none"

    def __str__(self) -> str:
        return self.python or self.name


class Message(str):
    """A text of pieces, some of which name arguments; in Python it reads as one string.

    >>> remedy = Message("add ", Mention("axial_damping"))
    >>> str(remedy), remedy.written(lambda each: "--axial-damping")
    ('add axial_damping', 'add --axial-damping')
    """

    pieces: tuple[str | Mention, ...]

    def __new__(cls, *pieces: str | Mention) -> Message:
        """Return the text; a piece may be such a text."""
        made = super().__new__(cls, "".join(map(str, pieces)))
        made.pieces = tuple(
            each for piece in pieces for each in (piece.pieces if isinstance(piece, Message) else (piece,))
        )
        return made

    def written(self, name: Callable[[Mention], str]) -> str:
        """Return the text with other names of what it mentions."""
        return "".join(name(piece) if isinstance(piece, Mention) else piece for piece in self.pieces)


def wrong_value(
    argument: str, problem: str, *more: str | Mention, kind: Callable[[str], ValueError] = ValueError
) -> ValueError:
    """Return an error that says which argument it is about, and carries that for `argument_of`.

    ``problem`` and what follows it may mention others, see `Message`.
    """
    text = Message(problem, *more)
    return _about(argument, text, kind(Message(f"{argument} ", text)))


def wrong_type(argument: str, problem: str) -> TypeError:
    """Return what `wrong_value` does as a TypeError."""
    return _about(argument, problem, TypeError(f"{argument} {problem}"))


def _about(argument: str, problem: str, error: E) -> E:
    error.__dict__["argument"] = argument, problem, ""
    return error


def located(where: str, error: Exception, colon: str = ": ") -> ValueError:
    """Return an error about something in a file or a table, which is still about the same argument."""
    said = error.args[0] if error.args and isinstance(error.args[0], Message) else str(error)
    found = ValueError(Message(f"{where}{colon}", said))
    if (known := getattr(error, "argument", None)) is not None:
        found.__dict__["argument"] = *known[:2], ": ".join(filter(None, [where, known[2]]))
    return found


class Argument(NamedTuple):
    """What an error is about."""

    name: str  # the argument
    place: str  # where in it: "2" in modes[2], "kick" in over['kick'], "" for all of it
    problem: str  # what is wrong with it
    where: str  # in which file it was given, "" for a call

    def named(self, name: str, mentioned: Callable[[Mention], str] = str) -> str:
        """Return the message with another name for the argument, and for those that are mentioned."""
        return ": ".join(filter(None, [self.where, f"{name} {written(self.problem, mentioned)}"]))


def argument_of(error: BaseException) -> Argument | None:
    """Return what an error is about; None where it is not about one argument."""
    known: tuple[str, str, str] | None = getattr(error, "argument", None)
    if known is None:
        return None
    name, _, place = known[0].partition("[")
    return Argument(name, place.rstrip("]").strip("'"), *known[1:])


def written(text: object, mentioned: Callable[[Mention], str]) -> str:
    """Return a text, or that of an error or a warning, with other names for the arguments that it mentions."""
    said = text.args[0] if isinstance(text, BaseException) and text.args else text
    return said.written(mentioned) if isinstance(said, Message) else str(text)
