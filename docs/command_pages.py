"""A page for every command of the terminal, made from the help it prints each time the site is built."""

from __future__ import annotations

import argparse
import re
import textwrap
import tomllib
from collections.abc import Iterator
from pathlib import Path

import sphinx.application

WIDTH = 116  # columns of a console block, so that it fits the column of text (tests/project/test_docs.py)


def parsers() -> tuple[argparse.ArgumentParser, dict[str, tuple[str, argparse.ArgumentParser]]]:
    """Return the parser of the terminal, and of each command its summary and parser."""
    from floquetrod.cli.main import _parser

    parser = _parser()
    (commands,) = (action for action in parser._actions if isinstance(action, argparse._SubParsersAction))
    summaries = {action.dest: action.help or "" for action in commands._choices_actions}
    return parser, {name: (summaries[name], commands.choices[name]) for name in summaries}


def escaped(text: str) -> str:
    """Return plain text of the terminal as reStructuredText, options, files and names of parameters as code."""
    parts = re.split(r"((?<![\w-])--[a-z][\w-]*|\b[\w.]+\.(?:toml|csv|npz|zarr|png|md|json|html)\b|\b\w+_\w+\b)", text)
    return "".join(
        f"``{part}``" if number % 2 else re.sub(r"([\\*`|_<>])", r"\\\1", part) for number, part in enumerate(parts)
    )


def block(lines: list[str]) -> str:
    """Return indented lines of a help text as a block of code: commands, TOML or plain text."""
    text = textwrap.dedent("\n".join(lines))
    language = "text"
    if all(line.startswith("floquetrod ") for line in text.splitlines()):
        text, language = "\n".join(wrapped(f"$ {line}") for line in text.splitlines()), "console"
    else:
        try:
            tomllib.loads(text)
            language = "toml"
        except tomllib.TOMLDecodeError:
            pass
    return f".. code-block:: {language}\n\n{textwrap.indent(text, '   ')}\n"


def wrapped(command: str) -> str:
    """Return a command that a shell understands on lines of at most WIDTH columns, broken before options."""
    lines = textwrap.wrap(
        command.replace(" --", "\n--").replace(" ", "\0").replace("\n", " "),  # a space is where a line may end
        WIDTH - 2,
        subsequent_indent="    ",
        break_long_words=False,
        break_on_hyphens=False,
    )
    return " \\\n".join(lines).replace("\0", " ")


def paragraphs(text: str) -> Iterator[str]:
    """Yield what a help text says: paragraphs, the first word in bold where it is followed by a colon, and blocks."""
    kind, lines = "", list[str]()
    for line in [*text.splitlines(), ""]:
        indented = line.startswith("  ")
        labelled = re.match(r"[\w-]+(?: [\w-]+){0,2}: ", line) and (not lines or lines[-1].endswith((".", ":")))
        if lines and (not line or labelled or indented != (kind == "block")):
            yield block(lines) if kind == "block" else prose(" ".join(lines))
            lines = []
        if line:
            kind = "block" if indented else "prose"
            lines.append(line)


def prose(text: str) -> str:
    """Return a paragraph; what introduces examples is a heading."""
    if re.fullmatch(r"[\w-]+:", text):
        return f".. rubric:: {text[:-1].capitalize()}\n"
    label, colon, rest = text.partition(": ")
    if colon and re.fullmatch(r"[\w-]+(?: [\w-]+){0,2}", label):
        label = escaped(label) if label.startswith("--") else f"**{label}**"
        return f"{label}: {escaped(rest)}\n"
    return f"{escaped(text)}\n"


def option(parser: argparse.ArgumentParser, action: argparse.Action) -> str:
    """Return one option or argument with its help."""
    value = "" if action.nargs == 0 else str(action.metavar or action.dest.upper())
    if action.choices and not action.metavar:
        value = "{" + ",".join(map(str, action.choices)) + "}"
    names = ", ".join(f"{name} {value}".strip() for name in action.option_strings) or str(action.metavar or action.dest)
    needed = "*required*; " if action.required and action.option_strings else ""
    said = parser._get_formatter()._expand_help(action) if action.help else ""
    return f".. option:: {names}\n\n   {needed}{escaped(' '.join(said.split()))}\n"


def section(title: str, *parts: str) -> str:
    """Return a section of a page; none without content."""
    return "\n".join([f"{title}\n{'-' * len(title)}\n", *parts]) if parts else ""


def page(parser: argparse.ArgumentParser) -> str:
    """Return the page of a command."""
    formatter = parser.formatter_class(prog=parser.prog, width=WIDTH)
    formatter.add_usage(parser.usage, parser._actions, parser._mutually_exclusive_groups, prefix="")
    details = list(paragraphs(parser.epilog or ""))
    first = 2 if details and details[0].startswith(".. rubric:: Examples") else 0
    parts = [f"{parser.prog}\n{'=' * len(parser.prog)}\n", *paragraphs(parser.description or "")]
    parts += [section("Examples", *details[1:first])]
    parts += [section("Usage", f".. code-block:: text\n\n{textwrap.indent(formatter.format_help().rstrip(), '   ')}\n")]
    parts += [f".. program:: {parser.prog}\n"]
    for group in parser._action_groups:
        told = [action for action in group._group_actions if action.help != argparse.SUPPRESS]
        parts += [section((group.title or "options").capitalize(), *(option(parser, action) for action in told))]
    return "\n".join([*parts, section("Details", *details[first:])])


def index(parser: argparse.ArgumentParser, commands: dict[str, tuple[str, argparse.ArgumentParser]]) -> str:
    """Return the page that lists the commands."""
    title = "Commands"
    rows = "".join(f"   * - :doc:`{name}`\n     - {escaped(summary)}\n" for name, (summary, _) in commands.items())
    names = "".join(f"   {name}\n" for name in commands)
    return (
        f"{title}\n{'=' * len(title)}\n\n{escaped(parser.description or '')}\n\n"
        f".. list-table::\n   :header-rows: 1\n   :widths: 20 80\n\n   * - command\n     - what it does\n{rows}\n"
        f".. toctree::\n   :hidden:\n\n{names}"
    )


def write(folder: Path) -> None:
    """Write the pages, and no page of a command that is no more."""
    folder.mkdir(parents=True, exist_ok=True)
    parser, commands = parsers()
    texts = {name: page(command) for name, (_, command) in commands.items()} | {"index": index(parser, commands)}
    for old in folder.glob("*.rst"):
        if old.stem not in texts:
            old.unlink()
    for name, text in texts.items():
        path = folder / f"{name}.rst"
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def setup(app: sphinx.application.Sphinx) -> dict[str, bool]:
    """Write the pages before Sphinx looks which there are."""
    app.connect("builder-inited", lambda app: write(Path(app.srcdir) / "reference/commands"))
    return {"parallel_read_safe": True}
