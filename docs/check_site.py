"""Follow every link of a built site: pages, anchors, pictures and scripts exist, and nothing is fetched from elsewhere.

python docs/check_site.py docs/_build/html
"""

from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from typing import NamedTuple
from urllib.parse import unquote, urlsplit

# What a browser fetches by itself, in contrast to the links a reader may follow.
FETCHED = {("img", "src"), ("script", "src"), ("link", "href"), ("iframe", "src"), ("object", "data")}
NOT_FETCHED = {"canonical", "next", "prev", "index", "search", "author", "copyright", "help"}  # kinds of <link>


class Page(HTMLParser):
    """Anchors of a page, and what it refers to."""

    def __init__(self, text: str) -> None:
        """Read the page."""
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.fetched: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note anchors and references."""
        given = {name: value or "" for name, value in attrs}
        self.anchors |= {given[name] for name in ("id", "name") if name in given}
        for name in ("href", "src", "data"):
            if name not in given:
                continue
            kinds = set(given.get("rel", "").split())
            by_itself = (tag, name) in FETCHED and not (tag == "link" and kinds & NOT_FETCHED)
            (self.fetched if by_itself else self.links).append(given[name])


class Fault(NamedTuple):
    """A reference that leads nowhere, or that a browser would fetch from elsewhere."""

    page: str
    reference: str
    why: str


def faults(site: Path) -> list[Fault]:
    """Return what is wrong with the references of all pages below ``site``."""
    site = site.resolve()
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(site.rglob("*.html"))}
    if not pages:
        raise FileNotFoundError(f"no pages below {site}; build the site first: make docs")
    found = []
    for path, page in pages.items():
        for reference in [*page.fetched, *page.links]:
            parts = urlsplit(reference)
            if parts.scheme or parts.netloc:
                if reference in page.fetched and parts.scheme != "data":
                    found.append(Fault(str(path.relative_to(site)), reference, "would be fetched from elsewhere"))
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            if not target.is_file():
                why = "no such file"
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].anchors:
                why = "no such anchor"
            else:
                continue
            found.append(Fault(str(path.relative_to(site)), reference, why))
    return found


if __name__ == "__main__":
    wrong = faults(Path(sys.argv[1]))
    for fault in wrong:
        print(f"{fault.page}: {fault.reference}: {fault.why}", file=sys.stderr)
    sys.exit(1 if wrong else 0)
