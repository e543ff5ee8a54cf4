"""Messages of the library with the options that were typed in place of the arguments that they carry."""

from __future__ import annotations

import argparse
from functools import partial

from floquetrod._util.arguments import Mention, argument_of, text_with_names

_OPTIONS = {
    "criterion": "--paper-criterion",
    "largest_safe_box": "--largest",
    "load": "--mean",
    "channel_diameter": "--bore, the channel diameter,",
    "channel_radius": "--bore, the channel radius,",
    "name": "--rod",
}
"""What sets an argument that has no option of its name, as messages call it; the first word is the option."""


def option(name: str) -> str:
    """Return the option that sets an argument, in the spelling of the terminal."""
    return name if name.startswith("--") else _OPTIONS.get(name, f"--{name.replace('_', '-')}")


def in_options(message: Exception | str, options: argparse.Namespace) -> str:
    """Return what an error or a warning says: with options for arguments, and what was typed where it is missing.

    An argument that no option of the command sets, or that was given in a file, keeps its name.
    """
    mentioned = partial(_mentioned, options)
    about = argument_of(message) if isinstance(message, Exception) else None
    if about is None or about.where:
        return text_with_names(message, mentioned)
    typed = _typed(about.name, options)
    if typed is None:
        return text_with_names(message, mentioned)
    said = about.named(option(about.name), mentioned)
    return said if typed is True or str(typed) in said else f"{said}; it was given as {str(typed)!r}"


def _mentioned(options: argparse.Namespace, mention: Mention) -> str:
    """Return how a message calls what it mentions: as an option where the command has one, else as in Python."""
    if not mention.name:
        return ""
    if mention.name not in vars(options):
        return str(mention)
    return " ".join(filter(None, [option(mention.name), mention.value]))


def _typed(name: str, options: argparse.Namespace) -> object:
    """Return what was typed for the option that sets an argument, None where it was left out or there is none."""
    first = option(name).split()[0].strip(",")
    return getattr(options, first.strip("-").replace("-", "_"), None)
