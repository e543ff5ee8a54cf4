"""The terminal: one command, with one module for each of its subcommands."""

from __future__ import annotations

import argparse
import io
import os
import re
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr
from functools import partial
from importlib import import_module
from typing import Any

import floquetrod as fr
from floquetrod._util.suggest import printable
from floquetrod._util.waiting import say
from floquetrod.cli.common import bare_numbers_typed, compiling_told, require_writable
from floquetrod.cli.completion import add_completion
from floquetrod.cli.messages import in_options
from floquetrod.cli.parser import Parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command and return the exit status.

    0: it answered; 1: the rod is unstable (`check --exit-code`); 2: input it cannot use; 3: `check --exit-code` could
    not decide; 130: Ctrl-C.
    """
    _take_one_thread_a_product()
    with _open_streams():
        try:
            return _run(sys.argv[1:] if argv is None else argv)
        finally:
            drop_unwritten()


def _take_one_thread_a_product() -> None:
    """Give NumPy's matrix products one thread each, in a process of the command's own, unless it is told otherwise.

    Maps and ensembles use all processors anyway, and where these are busy the threads of a product wait for one
    another: a verdict on coupled modes can then take ten times as long.
    """
    if "numpy" not in sys.modules and not _THREADS & os.environ.keys():
        os.environ.update(dict.fromkeys(_THREADS, "1"))


def _run(argv: Sequence[str]) -> int:
    """Run the command, its streams being open, and return the exit status."""
    options = argparse.Namespace()
    try:
        if sys.stdout is None:
            raise ValueError("standard output is closed, so the answer would be lost; direct it to a file or /dev/null")
        words = _attached(argv)
        parser = _parser(next((word for word in words if word in _COMMANDS), ""))
        options = parser.parse_args(words)
        if options.command is None:
            parser.error("command is missing; name one, such as floquetrod check")
        with compiling_told(), warnings.catch_warnings():
            if options.command != "compare":  # which knows no rods
                warnings.simplefilter("always", fr.UniformForceWarning)
                warnings.simplefilter("always", fr.PlausibilityWarning)
                warnings.simplefilter("ignore", import_module("floquetrod.rod.model.plausibility").HertzWarning)
            telling = warnings.showwarning = _Telling(options)
            require_writable(options)
            answer = options.run(options)
        if options.command not in ("chart", "compare", "lobes", "catalogue", "example"):  # which know no rods
            for warning in bare_numbers_typed(options):
                say(f"floquetrod: warning: {warning}")
        telling.rest()
        _print(answer.text)
    except BrokenPipeError:  # the reader, head say, has seen enough
        return 0
    except ArithmeticError as error:  # extreme input over- or underflows on the way
        given = ", ".join(f"--{name} {value}" for name, value in vars(options).items() if _is_quantity(value))
        what = f"numbers too large or too small to work with ({error}); check the units of {given}"
        say(f"floquetrod: error: {what}")
        return 2
    except (ValueError, OSError) as error:
        say(f"floquetrod: error: {' '.join(in_options(error, options).split())}")
        return 2
    except KeyboardInterrupt:
        say("floquetrod: interrupted")
        return 130
    return int(answer.status)


@contextmanager
def _open_streams() -> Iterator[None]:
    """Let nothing else take the place of standard streams that are closed, and errors be written to nowhere there.

    A file that is opened gets the lowest free number; as number 2 it would receive what libraries write to stderr.
    """
    if sys.stdin is not None and sys.stdout is not None and sys.stderr is not None:
        yield
        return
    while (held := os.open(os.devnull, os.O_RDWR)) <= 2:
        os.set_inheritable(held, True)
    os.close(held)
    with redirect_stderr(sys.stderr or io.StringIO()):
        yield


def _print(text: str) -> None:
    """Print the answer."""
    try:
        print(printable(text), flush=True)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OSError(f"the answer could not be written: {error.strerror}") from None


def drop_unwritten() -> None:
    """Drop what a stream cannot write; else the interpreter tries again when it ends, and fails."""
    for stream in filter(None, (sys.stdout, sys.stderr)):
        try:
            stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


class _Telling:
    """Prints warnings, each once: of implausible numbers at once, for they may take long, others with the answer."""

    def __init__(self, options: argparse.Namespace) -> None:
        self.options = options
        self.known: dict[str, bool] = {}  # texts, and whether they have been printed

    def __call__(self, message: Warning | str, category: type[Warning], *_: Any, **__: Any) -> None:
        text = in_options(message, self.options)
        at_once = issubclass(category, fr.PlausibilityWarning)
        if at_once and text not in self.known:
            self._say(text)
        self.known.setdefault(text, at_once)

    def rest(self) -> None:
        """Print the text kept back."""
        for text in [text for text, printed in self.known.items() if not printed]:
            self._say(text)

    def _say(self, text: str) -> None:
        say(f"floquetrod: warning: {text}")


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
  floquetrod check --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr --frequency 150rad/s
  floquetrod example
  floquetrod check --help
  floquetrod check --help-all

completion, once floquetrod[completion] is installed:
  floquetrod --print-completion bash > ~/.local/share/bash-completion/completions/floquetrod
  floquetrod --print-completion zsh > a folder of $fpath, as _floquetrod
"""


_THREADS = {"OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"}
"""Variables that say how many threads a product of matrices takes."""

_COMMANDS = {
    "check": "say whether a rod under an axial load, or a system of equations, is stable",
    "certify": "prove stability for every load of a box",
    "ranges": "list every stability interval of one quantity of the load",
    "map": "draw stability over two quantities of the load",
    "chart": "draw the stability of a family of systems over two of its parameters",
    "explore": "show stability while sliders move the load",
    "compare": "decide one Mathieu equation by every method",
    "simulate": "simulate a rod and compare it with theory",
    "ensemble": "simulate a rod many times, with statistics",
    "lock-up": "say how far a string can be pushed down a straight channel",
    "reach": "say how far a string can be pushed into a well",
    "weights": "draw pick-up and slack-off weights of a string over its depth in a well",
    "report": "write a rod under a load into one file, a page or a PDF",
    "lobes": "draw the stability lobes of a milling cutter",
    "catalogue": "list the steel pipes and rods that are known by their size",
    "example": "write the files that the examples of the other commands use",
}
"""The commands in the order of the help, each with its line there."""


def _add_options(name: str, command: Parser) -> None:
    """Add the options of a command, whose module is imported for it alone."""
    import_module(f"floquetrod.cli.{name.replace('-', '_')}").add(command)


def _parser(only: str | None = None) -> Parser:
    """Return the parser: all commands with their options, or the options of ``only`` one of them."""
    parser = Parser(
        prog="floquetrod",
        description="Floquet stability of a rod vibrated in a channel, and of periodically forced equations.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"floquetrod {fr.__version__}")
    add_completion(parser, _parser)
    commands = parser.add_subparsers(dest="command", metavar="command", parser_class=Parser)
    for name, summary in _COMMANDS.items():
        command = commands.add_parser(name, help=summary)
        command.elsewhere = partial(_elsewhere, name)
        if only in (None, name):
            _add_options(name, command)
    return parser


_MEANT = {"--out": ("--output", "--figure", "--plot", "--plot-force"), "--overwrite": ("--force", "--replace")}
"""Options, and what is typed for them, words of other programs among them."""


def _elsewhere(name: str, option: str) -> str:
    """Return what to say of an unknown option: the command's own that does the same, or another command that has it."""
    own = _options(name)
    if meant := next((right for right, typed in _MEANT.items() if option in typed and right in own), None):
        return f"; did you mean {meant}?"
    from floquetrod.rod.model.parameters import MEANT

    if "--rod" in own and (remedy := MEANT.get(option[2:].replace("-", "_"))):
        return f"; {remedy.replace('damping_rate in', '--damping-rate in')}"
    other = next((other for other in _COMMANDS if other != name and option in _options(other)), None)
    if other == "compare":
        from floquetrod.cli.compare import with_parameter

        if example := with_parameter(option):
            return f"; a verdict on Mathieu's equation is floquetrod compare {example}"
    return "" if other is None else f"; floquetrod {other} has it"


def _options(name: str) -> tuple[str, ...]:
    command = Parser()
    _add_options(name, command)
    return command.options
