"""Errors that carry the argument they are about, and messages that carry the other arguments they name.

So a terminal or a file can put in the names that were typed, and nobody reads an argument from a message.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeVar

E = TypeVar("E", ValueError, TypeError)


class Mention(NamedTuple):
    """A name in a message beside the argument it is about, most often in a remedy."""

    name: str  # the argument; "" for a text that makes sense in Python alone
    python: str = ""  # its text in Python where that is not the name: "mean_at=None"
    value: str = ""  # its value by the remedy, as typed in a terminal: "none"

    def __str__(self) -> str:
        return self.python or self.name


class Message(str):
    """A text of pieces, among them names of arguments; in Python it reads as one string.

    >>> remedy = Message("add ", Mention("axial_damping"))
    >>> str(remedy), remedy.with_names(lambda each: "--axial-damping")
    ('add axial_damping', 'add --axial-damping')
    """

    pieces: tuple[str | Mention, ...]

    def __new__(cls, *pieces: str | Mention) -> Message:
        """Return the text; a piece may be a `Message`."""
        message = super().__new__(cls, "".join(map(str, pieces)))
        message.pieces = tuple(
            piece_within
            for piece in pieces
            for piece_within in (piece.pieces if isinstance(piece, Message) else (piece,))
        )
        return message

    def with_names(self, name: Callable[[Mention], str]) -> str:
        """Return the text with other names for its mentions."""
        return "".join(name(piece) if isinstance(piece, Mention) else piece for piece in self.pieces)


def wrong_value(
    argument: str, problem: str, *more: str | Mention, kind: Callable[[str], ValueError] = ValueError
) -> ValueError:
    """Return an error that names the argument it is about, and carries it for `argument_of`.

    ``problem`` and the pieces after it may mention other arguments, see `Message`.
    """
    text = Message(problem, *more)
    return _about(argument, text, kind(Message(f"{argument} ", text)))


def wrong_type(argument: str, problem: str) -> TypeError:
    """Return the error of `wrong_value` as a TypeError."""
    return _about(argument, problem, TypeError(f"{argument} {problem}"))


def _about(argument: str, problem: str, error: E) -> E:
    error.__dict__["argument"] = argument, problem, ""
    return error


def error_in(where: str, error: Exception, colon: str = ": ") -> ValueError:
    """Return an error with the file or table that it is ``where``, still about the same argument."""
    said = error.args[0] if error.args and isinstance(error.args[0], Message) else str(error)
    located_error = ValueError(Message(f"{where}{colon}", said))
    if (known := getattr(error, "argument", None)) is not None:
        located_error.__dict__["argument"] = *known[:2], ": ".join(filter(None, [where, known[2]]))
    return located_error


class Argument(NamedTuple):
    """The argument that an error is about."""

    name: str
    place: str  # its element: "2" in modes[2], "kick" in over['kick'], "" for all of it
    problem: str  # the rest of the message
    where: str  # the file that gave it, "" for a call

    def named(self, name: str, mentioned: Callable[[Mention], str] = str) -> str:
        """Return the message with another name for the argument, and names for its mentions."""
        return ": ".join(filter(None, [self.where, f"{name} {text_with_names(self.problem, mentioned)}"]))


def argument_of(error: BaseException) -> Argument | None:
    """Return the argument that an error is about; None where it is not about one argument."""
    known: tuple[str, str, str] | None = getattr(error, "argument", None)
    if known is None:
        return None
    name, _, place = known[0].partition("[")
    return Argument(name, place.rstrip("]").strip("'"), *known[1:])


def text_with_names(text: object, mentioned: Callable[[Mention], str]) -> str:
    """Return a text, or the text of an error or a warning, with other names for its mentions."""
    said = text.args[0] if isinstance(text, BaseException) and text.args else text
    return said.with_names(mentioned) if isinstance(said, Message) else str(text)
