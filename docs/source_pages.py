"""Links from the reference to the source, and a page for each file that they lead to: nothing is fetched.

Sphinx's viewcode has no link for what is documented under another name than that of the module in which it is written,
such as an inherited method of `floquetrod.Rod`.
"""

from __future__ import annotations

import functools
import inspect
import pkgutil
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    import sphinx.application


class Written(NamedTuple):
    """Where something is written: its module, its name there, and the number of its line from 1."""

    module: str
    name: str
    line: int

    @property
    def page(self) -> str:
        """The page of its file."""
        return f"source/{self.module.replace('.', '/')}"


@functools.cache
def written(name: str) -> Written | None:
    """Return where a documented class, function, method or property is written, None of other attributes."""
    try:
        thing: Any = pkgutil.resolve_name(name)
    except (AttributeError, ImportError):
        return None
    thing = getattr(thing, "fget", None) or getattr(thing, "func", None) or thing
    thing = inspect.unwrap(getattr(thing, "__func__", thing))
    module = getattr(thing, "__module__", None) or ""
    if not module.startswith("floquetrod") or not (inspect.isclass(thing) or inspect.isfunction(thing)):
        return None
    line = thing.__code__.co_firstlineno if inspect.isfunction(thing) else inspect.getsourcelines(thing)[1]
    return Written(module, thing.__qualname__, line)


def link(app: sphinx.application.Sphinx, tree: Any) -> None:
    """Put a link behind each signature of a page."""
    from docutils import nodes
    from sphinx import addnodes

    for signature in tree.findall(addnodes.desc_signature):
        place = written(f"{signature.get('module')}.{signature.get('fullname')}")
        if place is not None and app.builder.format == "html":
            target = f"{app.builder.get_relative_uri(app.env.docname, place.page)}#{place.name}"
            words = nodes.inline("", "[source]", classes=["viewcode-link"])
            signature += nodes.reference("", "", words, internal=False, refuri=target)


def pages(app: sphinx.application.Sphinx) -> Iterator[tuple[str, dict[str, str], str]]:
    """Yield a page for each file, with an anchor at every name that links lead to."""
    if app.builder.format != "html":
        return
    places = filter(None, map(written, app.env.domains.python_domain.objects))
    by_page = defaultdict(set)
    for place in places:
        by_page[place.page].add(place)
    for page, names in sorted(by_page.items()):
        module = next(iter(names)).module
        text = Path(str(sys.modules[module].__file__)).read_text(encoding="utf-8")
        lines = app.builder.highlighter.highlight_block(text, "python").splitlines()
        for place in names:
            lines[place.line - 1] = f'<span id="{place.name}"></span>{lines[place.line - 1]}'
        body = f"<h1>Source of {module}</h1>\n" + "\n".join(lines)
        yield page, {"title": f"Source of {module}", "body": body}, "page.html"


def setup(app: sphinx.application.Sphinx) -> dict[str, bool]:
    """Link what is read, and write the pages in the end."""
    app.connect("doctree-read", link)
    app.connect("html-collect-pages", pages)
    return {"parallel_read_safe": True}
