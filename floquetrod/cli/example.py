"""`floquetrod example`: the files that help texts and pages use, written where they can be tried and changed."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path

from floquetrod._util.example_files import commands, content, names, summary
from floquetrod._util.sealed_files import atomic_file, writable
from floquetrod.cli.common import describe_command
from floquetrod.cli.output import Output, output
from floquetrod.cli.parser import Parser

_HELP = """\
Write the files that the examples of --help and of the documentation use: rods, a well, a measured force, and others.

examples:
  floquetrod example
  floquetrod example my_rod.toml
  floquetrod example tubing.toml survey.csv --out trial
  floquetrod example --all --overwrite

Without a name it lists the files, a line each; with names it writes them and shows commands to try.  A file that is
there already is not touched: --overwrite replaces it, and --out writes into another folder, which is made if it is not
there.
"""


def add(command: Parser) -> None:
    """Add help and options of the command to its parser."""
    describe_command(command, _HELP, _example, ("names", "all", "folder", "overwrite"))
    command.add_argument("names", metavar="NAME", nargs="*", choices=names(), help="a file, such as my_rod.toml")
    command.add_argument("--all", action="store_true", help="write every file")
    command.add_argument(
        "--out",
        dest="folder",
        metavar="FOLDER",
        type=Path,
        default=Path(),
        help="folder to write into (default: this one)",
    )
    command.add_argument("--overwrite", action="store_true", help="replace files that are there already")


def _example(options: argparse.Namespace) -> Output:
    if options.all and options.names:
        raise ValueError(f"--all writes every file, got {' '.join(options.names)} beside it; leave out one of both")
    if not options.all and not options.names:
        if options.overwrite or options.folder != Path():
            option = "--overwrite" if options.overwrite else "--out"
            raise ValueError(f"{option} needs the name of a file, such as {names()[0]}, or --all")
        return output(options, _list, lambda: {"examples": {name: summary(name) for name in names()}})
    chosen = names() if options.all else list(dict.fromkeys(options.names))
    written = [str(path) for path in _write(chosen, options.folder, options.overwrite)]
    tried = _commands(chosen, options.folder)
    where = "try" if options.folder == Path() else f"try, in the folder {options.folder}"
    lines = [f"written: {', '.join(written)}", "", f"{where}:", *(f"  {line}" for line in tried)]
    return output(options, lambda: "\n".join(lines), lambda: {"written": written, "commands": tried})


def _commands(chosen: list[str], folder: Path) -> list[str]:
    """Return commands to try with the files that were written, first the one that writes others they name."""
    tried = list(dict.fromkeys(line for name in chosen for line in commands(name)))
    named = dict.fromkeys(word for line in tried for word in shlex.split(line) if word in names())
    missing = [name for name in named if not (folder / name).exists()]
    return [*([f"floquetrod example {' '.join(missing)}"] if missing else []), *tried]


def _list() -> str:
    """Return a line for each file."""
    width = max(map(len, names()))
    lines = [f"{name:{width}}  {summary(name)}" for name in names()]
    return "\n".join(
        [*lines, "", "floquetrod example NAME writes one of them here, floquetrod example --all every one."]
    )


def _write(chosen: list[str], folder: Path, overwrite: bool) -> list[Path]:
    """Write files into a folder, all of them or none, and return where they are."""
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"--out must be a folder, and {str(folder)!r} is a file")
    paths = [folder / name for name in chosen]
    there = [path for path in paths if path.exists()]
    if there and not overwrite:
        verb = "is" if len(there) == 1 else "are"
        raise ValueError(
            f"{', '.join(map(str, there))} {verb} there already, and nothing was written; --overwrite replaces "
            f"{'it' if len(there) == 1 else 'them'}, --out FOLDER writes elsewhere"
        )
    folder.mkdir(parents=True, exist_ok=True)
    for path in paths:
        writable(path)
    for path in paths:
        with atomic_file(path) as file:
            file.write(content(path.name).encode())
    return paths
