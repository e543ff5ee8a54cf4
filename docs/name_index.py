"""A directive that lists the names of the reference with their summaries, page by page: ``.. names::``.

They are what the pages of the reference document, whose directives are read here; a summary is the first sentence of a
docstring.
"""

from __future__ import annotations

import inspect
import itertools
import pkgutil
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import method_list

if TYPE_CHECKING:
    import sphinx.application

REFERENCE = Path(__file__).parent / "reference"
DIRECTIVE = re.compile(r"^\.\. auto(class|function|method|module):: (\S+)\n((?: +:?.*\n)*)", re.MULTILINE)
LISTED = re.compile(r"^\.\. methods:: (\w+)$", re.MULTILINE)


class Documented(NamedTuple):
    """A name that a page documents: the page, "class", "function" or "method", and the full name."""

    page: str
    kind: str
    name: str

    @property
    def owner(self) -> str:
        """The class or module that it belongs to."""
        return self.name.rpartition(".")[0]

    @property
    def thing(self) -> Any:
        """The class or function."""
        return pkgutil.resolve_name(self.name)


def source(page: Path) -> str:
    """Return the text of a page with the methods that its directive lists."""
    text = page.read_text(encoding="utf-8")
    return LISTED.sub(lambda found: "\n".join(method_list.described(found[1])), text)


def pages(folder: Path = REFERENCE) -> list[str]:
    """Return the names of the pages in the order of the reference."""
    index = (folder / "index.rst").read_text(encoding="utf-8")
    return [name for name in re.findall(r"^   (\w+)$", index, re.MULTILINE) if (folder / f"{name}.rst").is_file()]


def documented(folder: Path = REFERENCE) -> Iterator[Documented]:
    """Yield classes, functions and methods in the order of the pages, the methods of a class behind it."""
    for page in pages(folder):
        for kind, name, options in DIRECTIVE.findall(source(folder / f"{page}.rst") + "\n"):
            if ":no-index:" in options:
                continue
            if kind != "module":
                yield Documented(page, kind, name)
            for member in members(kind, pkgutil.resolve_name(name), " ".join(options.split())):
                below = getattr(pkgutil.resolve_name(name), member)
                within = "method" if kind == "class" else "class" if inspect.isclass(below) else "function"
                yield Documented(page, within, f"{name}.{member}")


def members(kind: str, thing: Any, options: str) -> Iterator[str]:
    """Yield what a directive documents below its name: of a module classes and functions, of a class its methods."""
    given = {name: re.findall(r"\w+", words) for name, words in re.findall(r":([\w-]+):([^:]*)", options)}
    if "members" not in given:
        return
    known = thing.__all__ if kind == "module" else dir(thing) if "inherited-members" in given else vars(thing)
    for name in given["members"] or known:
        if not name.startswith("_") and name not in given.get("exclude-members", []) and is_own(thing, name):
            yield name


def is_own(owner: Any, name: str) -> bool:
    """Return whether a member is a function or a class of the package with a docstring."""
    member = getattr(owner, name)
    module = getattr(inspect.unwrap(member), "__module__", None) if callable(member) else None
    return bool(module and module.startswith("floquetrod") and inspect.getdoc(member))


def summary(text: str) -> str:
    """Return the first sentence of a docstring, on one line."""
    paragraph = " ".join(text.partition("\n\n")[0].split())
    return re.split(r"(?<=\.) +(?=[A-Z])", paragraph)[0]


def listed(folder: Path = REFERENCE) -> list[Documented]:
    """Return what the index lists: classes, functions, and methods of a class that are on several pages."""
    every = list(documented(folder))
    home = {entry.name: entry.page for entry in every if entry.kind == "class"}
    spread = {
        entry.owner for entry in every if entry.kind == "method" and entry.page != home.get(entry.owner, entry.page)
    }
    return [entry for entry in every if entry.kind != "method" or entry.owner in spread]


def table(entries: list[Documented]) -> list[str]:
    """Return the lines of a table of names with their summaries; a method is shown with its class."""
    lines = [".. list-table::", "   :class: names", "   :widths: 30 70", ""]
    for entry in entries:
        role, depth = {"class": ("class", 1), "function": ("func", 1), "method": ("meth", 2)}[entry.kind]
        short = ".".join(entry.name.split(".")[-depth:])
        lines += [f"   * - :py:{role}:`{short} <{entry.name}>`", f"     - {summary(inspect.getdoc(entry.thing) or '')}"]
    return lines


def setup(app: sphinx.application.Sphinx) -> dict[str, bool]:
    """Register the directive; what it is made of comes with Sphinx, which the lists above do without."""
    from docutils import nodes
    from docutils.parsers.rst import Directive
    from docutils.statemachine import StringList
    from formulas import typeset
    from sphinx.util.nodes import nested_parse_with_titles

    class Names(Directive):
        """A section for each page of the reference: a link to the page, and the table of its names."""

        def run(self) -> list[nodes.Node]:
            """Return the sections."""
            node = nodes.section()
            node.document = self.state.document
            lines = []
            for page, entries in itertools.groupby(listed(), lambda entry: entry.page):
                title = source(REFERENCE / f"{page}.rst").partition("\n")[0]
                heading = f":doc:`{title} <{page}>`"
                lines += [heading, "~" * len(heading), "", *map(typeset, table(list(entries))), ""]
            nested_parse_with_titles(self.state, StringList(lines, source=__file__), node, self.content_offset)
            return node.children

    app.add_directive("names", Names)
    return {"parallel_read_safe": True}
