"""The terminal: one command, with one module for each of its subcommands."""

from __future__ import annotations

import argparse
import os
import re
import sys
import warnings
from collections.abc import Sequence
from typing import Any

import floquetrod as fr
from floquetrod.cli import certify, check, compare, ensemble, explore, ranges, reproduce, simulate, stability_map
from floquetrod.cli.common import compiling_told
from floquetrod.cli.completion import add_completion
from floquetrod.cli.parser import Parser
from floquetrod.cli.waiting import say
from floquetrod.rod.plausibility import SILENCE


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command and return the exit status.

    0: it answered; 1: a claim no longer holds (`reproduce`) or the rod is unstable (`check --exit-code`); 2: input it
    cannot use; 3: `check --exit-code` could not decide; 130: Ctrl-C.
    """
    options = argparse.Namespace()
    try:
        options = _parser().parse_args(_attached(sys.argv[1:] if argv is None else argv))
        with compiling_told(), warnings.catch_warnings():
            warnings.simplefilter("always", fr.UniformForceWarning)
            warnings.simplefilter("always", fr.PlausibilityWarning)
            telling = warnings.showwarning = _Telling(options)
            answer = options.run(options)
        telling.rest()
        print(answer.text, flush=True)
    except BrokenPipeError:  # the reader, head say, has seen enough; keep the interpreter from writing more at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except ArithmeticError as error:  # extreme input over- or underflows on the way
        given = ", ".join(f"--{name} {value}" for name, value in vars(options).items() if _is_quantity(value))
        what = f"numbers too large or too small to work with ({error}); check the units of {given}"
        print(f"floquetrod: error: {what}", file=sys.stderr)
        return 2
    except (ValueError, OSError) as error:
        print(f"floquetrod: error: {_naming_options(' '.join(str(error).split()), options)}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("floquetrod: interrupted", file=sys.stderr)
        return 130
    return int(answer.status)


class _Telling:
    """Prints warnings, each once: of implausible numbers at once, for they may take long, others with the answer."""

    def __init__(self, options: argparse.Namespace) -> None:
        self.options = options
        self.known: dict[str, bool] = {}  # texts, and whether they have been printed

    def __call__(self, message: Warning | str, category: type[Warning], *_: Any, **__: Any) -> None:
        text = str(message).removesuffix(SILENCE)
        at_once = issubclass(category, fr.PlausibilityWarning)
        if at_once and text not in self.known:
            self._say(text)
        self.known.setdefault(text, at_once)

    def rest(self) -> None:
        """Print what has been kept back."""
        for text in [text for text, printed in self.known.items() if not printed]:
            self._say(text)

    def _say(self, text: str) -> None:
        say(f"floquetrod: warning: {_in_options(text, self.options)}")


_ARGUMENTS = {"load": "mean", "criterion": "paper_criterion"}
"""Arguments of the library that an option of another name sets."""

_WORDS = {
    "mean_at=None": ("mean_at", "--mean-at none"),
    "axial_damping": ("axial_damping", "--axial-damping"),
    "AxialWave": ("wave", "--wave"),
    "range(1, n + 1)": ("modes", "--modes 1-n"),
}
"""What remedies of the library name, with the option that a command has for it."""


def _in_options(message: str, options: argparse.Namespace) -> str:
    """Return a message of the library with options in place of what its remedies name, where the command has them."""
    for words, (name, option) in _WORDS.items():
        if name in vars(options):
            message = message.replace(words, option)
    return message


def _naming_options(message: str, options: argparse.Namespace) -> str:
    """Return a message of the library with the option in place of the argument it begins with, and what was typed."""
    message = _in_options(message, options)
    match = re.match(r"(\w+)(?:\[\d+\])? (?=must|needs)", message)
    name = match[1] if match else ""
    if name not in vars(options):
        name = _ARGUMENTS.get(name, name)
    typed = vars(options).get(name)
    if match is None or typed is None:
        return message
    message = f"--{name.replace('_', '-')} {message[match.end() :]}"
    return message if str(typed) in message else f"{message}; it was given as {typed!r}"


def _is_quantity(value: object) -> bool:
    return isinstance(value, float) or (isinstance(value, str) and any(letter.isdigit() for letter in value))


def _attached(arguments: Sequence[str]) -> list[str]:
    """Return the arguments with each negative quantity attached to its option.

    argparse takes -0.2Fcr or -1e-3 for an option of its own; --mean=-0.2Fcr is unambiguous.
    """
    result: list[str] = []
    for argument in arguments:
        if re.fullmatch(r"--[\w-]+=--", argument):  # argparse takes the second -- for the end of the options
            raise ValueError(f"{argument[:-3]} needs a value, got '--'")
        if re.match(r"-\.?\d", argument) and result and re.fullmatch(r"--[\w-]+", result[-1]):
            result[-1] += f"={argument}"
        else:
            result.append(argument)
    return result


_EPILOG = """\
examples:
  floquetrod check --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr --frequency 150
  floquetrod check --help

completion, once floquetrod[completion] is installed:
  floquetrod --print-completion bash > ~/.local/share/bash-completion/completions/floquetrod
  floquetrod --print-completion zsh > a folder of $fpath, as _floquetrod
"""


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="floquetrod",
        description="Floquet stability of a rod vibrated in a channel, and of periodically forced equations.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"floquetrod {fr.__version__}")
    add_completion(parser)
    commands = parser.add_subparsers(dest="command", required=True, metavar="command", parser_class=Parser)
    for module in (check, certify, ranges, stability_map, explore, compare, simulate, ensemble, reproduce):
        module.add(commands)
    for name, command in commands.choices.items():
        others = [(other, each) for each, other in commands.choices.items() if each != name]
        own = command.options
        command.elsewhere = {
            o: f"; floquetrod {each} has it" for other, each in others for o in other.options if o not in own
        }
    return parser
