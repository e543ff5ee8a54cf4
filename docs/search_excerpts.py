"""Excerpts in the results of the search, also where the site is read from disk.

Sphinx fetches each page it finds to show a piece of it, which a browser refuses to do from disk.  Here the texts of all
pages are written into one script when the site is built; `search_excerpts.js` hands them to Sphinx's search.
"""

from __future__ import annotations

import json
from html.parser import HTMLParser
from pathlib import Path

import sphinx.application

APART = {"p", "li", "dt", "dd", "td", "th", "pre", "div", "h1", "h2", "h3", "h4"}
VOID = {"area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "source", "track", "wbr"}


class Text(HTMLParser):
    """What is to be read in a page's article, by the section it stands in."""

    def __init__(self, html: str) -> None:
        """Read the page."""
        super().__init__()
        self.sections: dict[str, list[str]] = {}
        self._open: list[tuple[bool, str]] = []  # of each element about this place: is it read, and its section
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Enter the article, a section, or something that is not read."""
        given = dict(attrs)
        if tag in APART:
            self.handle_data(" ")
        read, anchor = self._open[-1] if self._open else (False, "")
        if tag == "article":
            read = True
        if tag in {"script", "style"} or "headerlink" in (given.get("class") or ""):
            read = False
        if given.get("id") and tag in {"section", "dt"}:
            anchor = f"#{given['id']}"
        if tag not in VOID:
            self._open.append((read, anchor))

    def handle_endtag(self, tag: str) -> None:
        """Leave the element."""
        if tag not in VOID and self._open:
            self._open.pop()

    def handle_data(self, data: str) -> None:
        """Keep text that is read."""
        if self._open and self._open[-1][0]:
            self.sections.setdefault(self._open[-1][1], []).append(data)


def texts(site: Path, pages: list[str]) -> dict[str, dict[str, str]]:
    """Return the text of pages, section by section, in the order of the page."""
    found = {}
    for page in pages:
        path = site / f"{page}.html"
        if path.is_file():
            sections = Text(path.read_text(encoding="utf-8")).sections
            plain = {anchor: " ".join("".join(parts).split()) for anchor, parts in sections.items()}
            found[page] = {anchor: text for anchor, text in plain.items() if text}
    return found


def write(app: sphinx.application.Sphinx, error: Exception | None) -> None:
    """Write the texts of a site that has been built."""
    if error is None and app.builder.name == "html":
        said = json.dumps(texts(Path(app.outdir), sorted(app.env.found_docs)), ensure_ascii=False)
        (Path(app.outdir) / "_static/page_texts.js").write_text(f"const pageTexts = {said};\n", encoding="utf-8")


def add_scripts(
    app: sphinx.application.Sphinx, page: str, template: str, context: dict[str, object], tree: object
) -> None:
    """Load the texts where they are needed, on the page of the search."""
    if page == "search":
        app.add_js_file("page_texts.js", loading_method="defer")
        app.add_js_file("search_excerpts.js", loading_method="defer")


def setup(app: sphinx.application.Sphinx) -> dict[str, bool]:
    """Add the scripts to the page of the search, and write the texts in the end."""
    app.connect("html-page-context", add_scripts)
    app.connect("build-finished", write)
    return {"parallel_read_safe": True}
