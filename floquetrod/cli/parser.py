"""The parser of the terminal: errors of one line that name option, value and remedy."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Callable, Sequence
from itertools import takewhile
from pathlib import Path
from typing import Any, NoReturn

from floquetrod import units
from floquetrod._util.suggest import did_you_mean

POINTS = "COLUMNSxROWS"
"""What the help calls the value of an option that takes two numbers with an x between."""

_DASHES = "-\N{EN DASH}\N{EM DASH}\N{MINUS SIGN}"
_OPTION = re.compile(rf"([{_DASHES}]{{1,2}})([A-Za-z][\w-]*)(=.*)?", re.DOTALL)


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, and whose --help can leave options to --help-all.

    ``elsewhere`` returns what to say of an option that others have, or ""; ``common`` names what --help shows.
    """

    elsewhere: Callable[[str], str] = staticmethod(lambda _: "")
    common: tuple[str, ...] = ()

    def __init__(self, **options: Any) -> None:
        # Errors are raised, which know the option that they are about.
        super().__init__(**options, add_help=False, exit_on_error=False, allow_abbrev=False)
        for name in (None, "store"):
            self.register("action", name, _Store)
        self.add_argument("-h", "--help", action=_Help, help="show help and exit")

    def show_most_used(self, *common: str) -> None:
        """Let --help show these options alone, with the examples, and --help-all everything."""
        self.common = common
        self.add_argument("--help-all", action=argparse._HelpAction, help="show all options, with details, and exit")

    def add_output(
        self, name: str, kinds: Callable[[], Sequence[str]], text: str, *, default: str | None = None
    ) -> None:
        """Add an option that names files to write, of some kinds by their ends; each time it is given names one more.

        ``kinds`` is asked only where a file is named.
        """
        usual = "" if default is None else f" (default {default})"
        self.add_argument(
            name,
            action=OutputFiles,
            kinds=kinds,
            metavar="FILE",
            type=Path,
            default=[] if default is None else [Path(default)],
            help=f"{text}; may be repeated{usual}",
        )

    def format_short_help(self) -> str:
        """Return the help without options that few need, and without what follows the examples."""
        if not self.common:
            return self.format_help()
        shown = [each for each in self._actions if each.dest in ("help", "help_all", *self.common)]
        formatter = self._get_formatter()
        formatter.add_usage(self.usage, shown, self._mutually_exclusive_groups)
        formatter.add_text(self.description)
        formatter.start_section("options")
        formatter.add_arguments(shown)
        formatter.end_section()
        formatter.add_text((self.epilog or "").partition("\n\n")[0])
        formatter.add_text(f"all {len(self._actions)} options, with details: {self.prog} --help-all")
        return formatter.format_help()

    def error(self, message: str) -> NoReturn:
        """Raise ValueError, which the terminal shows as one line."""
        raise ValueError(f"{message} (see {self.prog} --help)")

    def _print_message(self, message: str, file: Any = None) -> None:
        """Print help or version; argparse passes over what cannot be written."""
        print(message, end="", file=file, flush=True)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Return what argparse does, where every word is known; an unknown word is an error here."""
        words = list(args)
        self.files: dict[str, Path] = {}
        for word in takewhile(lambda word: word != "--" and self._is_own(word), words):
            self._require_known(word)
        try:
            found, left = super().parse_known_args(words, namespace)
        except argparse.ArgumentError as error:
            self.error(_plain(error))
        if left:
            self.error(_alone(left[0], words, self._option_string_actions))
        return found, left

    @property
    def outputs(self) -> list[OutputFiles]:
        """The options that name files to write."""
        return [action for action in self._actions if isinstance(action, OutputFiles)]

    @property
    def options(self) -> tuple[str, ...]:
        """The options there are, as they are typed."""
        return tuple(self._option_string_actions)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse a word that is not among the choices of an option, or is no command."""
        known = list(action.choices or ())
        for word in value if isinstance(value, list) else [value]:  # the list is empty: of any number of words, none
            if known and word not in known:
                wrong = f"must be one of {', '.join(known)}, got {word!r}{did_you_mean(word, known)}"
                raise argparse.ArgumentError(action, wrong)

    def _is_own(self, word: str) -> bool:
        """Return whether a word is for this parser: words after the name of a command are not."""
        return self._subparsers is None or word[:1] in _DASHES

    def _require_known(self, word: str) -> None:
        """Refuse a word that looks like an option and is none, the beginning of one among them."""
        written = _OPTION.fullmatch(word)
        known = self._option_string_actions
        if written is None or written[1] + written[2] in known:
            return
        typed = written[1] + written[2]
        begun = [option for option in known if typed.startswith("--") and option.startswith(typed)]
        option = "--" + written[2].replace("_", "-")
        is_letter = len(option) == 3  # with which many options begin
        of_another = "" if option in known or (begun and not is_letter) else self.elsewhere(option)
        if begun and not of_another:
            self.error(f"unknown option {typed}; did you mean {' or '.join(begun[:3])}?")
        self.error(f"unknown option {typed}{of_another or did_you_mean(option, known)}")


class OutputFiles(argparse.Action):
    """An option whose values are files to write, all of them; ``kinds`` returns the ends their names may have."""

    def __init__(self, *, kinds: Callable[[], Sequence[str]], **rest: Any) -> None:
        super().__init__(**rest)
        self.kinds = kinds

    def __call__(self, _: Any, namespace: argparse.Namespace, value: Any, __: Any = None) -> None:
        """Add a file to those given before it, which take the place of the default."""
        before = getattr(namespace, self.dest)
        setattr(namespace, self.dest, [value] if before is self.default else [*before, value])


class _Store(argparse._StoreAction):
    """An option of one value, the last one given; a file is not dropped for another one in silence."""

    def __call__(self, parser: Any, namespace: argparse.Namespace, value: Any, option: Any = None) -> None:
        if self.type is Path and option is not None and (before := parser.files.setdefault(self.dest, value)) != value:
            raise argparse.ArgumentError(self, f"must be given once, got {str(before)!r} and {str(value)!r}")
        super().__call__(parser, namespace, value, option)


class _Help(argparse._HelpAction):
    """Show the short help and exit."""

    def __call__(self, parser: Any, *_: Any) -> None:
        parser._print_message(parser.format_short_help())
        parser.exit()


def _alone(word: str, words: Sequence[str], options: Any) -> str:
    """Return a message about a word that belongs to no option."""
    before = list(words[: words.index(word)])
    name, equals, value = word.partition("=")
    if equals and f"--{name}" in options:
        return f"{word!r} belongs to no option; did you mean --{name}={value}?"
    place = max((i for i, each in enumerate(before) if each.startswith("--")), default=None)
    if place is None or (place == len(before) - 1 and "=" not in before[place]):
        return f"{word!r} belongs to no option"
    option, _, attached = before[place].partition("=")
    values = [*filter(None, [attached, *before[place + 1 :], word])]
    value = ("x" if getattr(options.get(option), "metavar", None) == POINTS else " ").join(values)
    if value == "x".join(values):
        return f"{word!r} belongs to no option; did you mean {option} {value}?"
    return f"{word!r} belongs to no option; a value of several words needs quotes, as in {option} {shlex.quote(value)}"


def _plain(error: argparse.ArgumentError) -> str:
    """Return an error of argparse as the library words its own."""
    if error.argument_name is None:
        return str(error.message)
    problem = "needs a value" if error.message == "expected one argument" else error.message
    return f"{error.argument_name} {problem}"


def whole_number(text: str) -> int:
    """Return an integer that was typed."""
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"must be a whole number such as 200, got {text!r}") from None


def real_number(text: str) -> float:
    """Return a number without a unit that was typed."""
    return _typed(text, "must be a number such as 0.5")


def ratio(text: str) -> float:
    """Return a number that was typed, or a percentage."""
    return _typed(text, "must be a number such as 0.3, or 30%")


def _typed(text: str, wanted: str) -> float:
    try:
        if not wanted.endswith("%"):
            return float(text)
        return units.quantity(text, "it", "ratio")
    except ValueError:
        comma = "; write a point in place of the comma" if "," in text else ""
        raise argparse.ArgumentTypeError(f"{wanted}, got {text!r}{comma}") from None
