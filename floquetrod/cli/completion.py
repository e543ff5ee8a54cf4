"""Completion of commands, options, choices and files by the shell, with scripts that shtab writes."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from typing import Any

SHELLS = ("bash", "zsh", "tcsh")

_PATTERNS = {"system": ("*.toml", "*.npz"), "force": ("*.csv", "*.txt", "*.dat"), "study": ("*.toml",)}
"""Files that are completed, by option; of other options for files, all of them."""

_RODS = {
    "bash": "_floquetrod_rods",
    "zsh": "_floquetrod_rods",
    "tcsh": "f:*.toml",
    "preamble": {
        "bash": """\
_floquetrod_rods() {
  compgen -W nitinol -- $1
  compgen -f -X '!*.toml' -- $1
  compgen -d -- $1
}""",
        "zsh": """\
_floquetrod_rods() {
  compadd nitinol
  _files -g '*.toml'
}""",
    },
}
"""What --rod takes: nitinol, TOML files, and folders in which they may be."""


def add_completion(parser: argparse.ArgumentParser, every_command: Callable[[], argparse.ArgumentParser]) -> None:
    """Add the option that prints the script for a shell; ``every_command`` returns that with all of them."""
    parser.add_argument(
        "--print-completion",
        action=_Print,
        every_command=every_command,
        choices=SHELLS,
        help="print a script that lets the shell complete commands, options and files; needs floquetrod[completion]",
    )


class _Print(argparse.Action):
    """Print the script for a shell and exit."""

    def __init__(self, *, every_command: Callable[[], argparse.ArgumentParser], **rest: Any) -> None:
        super().__init__(**rest)
        self.every_command = every_command

    def __call__(self, parser: argparse.ArgumentParser, _: Any, shell: Any, __: Any = None) -> None:
        try:
            import shtab  # type: ignore[import-not-found,import-untyped,unused-ignore]
        except ImportError:
            raise ValueError(
                f"--print-completion {shell} needs shtab: install it with pip install 'floquetrod[completion]'"
            ) from None
        parser = self.every_command()
        for action in _actions(parser):
            if action.dest == "rod":
                action.complete = _RODS  # type: ignore[attr-defined]
            elif action.dest in _PATTERNS:
                action.complete = shtab.glob(*_PATTERNS[action.dest])  # type: ignore[attr-defined]
            elif action.metavar == "FILE":
                action.complete = shtab.FILE  # type: ignore[attr-defined]
            elif action.metavar == "FOLDER":
                action.complete = shtab.DIRECTORY  # type: ignore[attr-defined]
        print(shtab.complete(parser, shell=shell))
        parser.exit()


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Yield the options of a parser and of its commands."""
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _actions(command)
