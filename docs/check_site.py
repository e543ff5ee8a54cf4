"""Check a built site: links lead somewhere, nothing is fetched from elsewhere, pages are small, near and described.

Pages, anchors, pictures and scripts exist; every page is at most CLICKS links from the first one and, but for source
files, LARGEST bytes of HTML; pictures have a text for those who do not see them.

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
CLICKS = 2
LARGEST = 170_000  # bytes of HTML, of which the contents at the side take 20,000 and colours of code half (a choice)
NOT_FETCHED = {"canonical", "next", "prev", "index", "search", "author", "copyright", "help"}  # kinds of <link>


class Page(HTMLParser):
    """Anchors of a page, what it refers to, and its pictures without a text."""

    def __init__(self, text: str) -> None:
        """Read the page."""
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.fetched: list[str] = []
        self.undescribed: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note anchors and references."""
        given = {name: value or "" for name, value in attrs}
        if tag == "img" and given.get("alt", ".png").endswith((".png", ".svg", ".jpg")):  # Sphinx's default is the file
            self.undescribed.append(given.get("src", ""))
        self.anchors |= {given[name] for name in ("id", "name") if name in given}
        for name in ("href", "src", "data"):
            if name not in given:
                continue
            kinds = set(given.get("rel", "").split())
            by_itself = (tag, name) in FETCHED and not (tag == "link" and kinds & NOT_FETCHED)
            (self.fetched if by_itself else self.links).append(given[name])


class Fault(NamedTuple):
    """What is wrong with a page, or with something it refers to."""

    page: str
    reference: str
    why: str


def faults(site: Path) -> list[Fault]:
    """Return what is wrong with the pages below ``site`` and their references."""
    site = site.resolve()
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(site.rglob("*.html"))}
    if not pages:
        raise FileNotFoundError(f"no pages below {site}; build the site first: make docs")
    found = []
    leads: dict[Path, set[Path]] = {path: set() for path in pages}
    for path, page in pages.items():
        name = str(path.relative_to(site))
        for reference in [*page.fetched, *page.links]:
            parts = urlsplit(reference)
            if parts.scheme or parts.netloc:
                if reference in page.fetched and parts.scheme != "data":
                    found.append(Fault(name, reference, "would be fetched from elsewhere"))
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            leads[path].add(target)
            if not target.is_file():
                found.append(Fault(name, reference, "no such file"))
            elif parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].anchors:
                found.append(Fault(name, reference, "no such anchor"))
        found += [Fault(name, picture, "has no text in place of the picture") for picture in page.undescribed]
        if (size := path.stat().st_size) > LARGEST and not name.startswith("source/"):  # as long as the file it shows
            found.append(Fault(name, "", f"has {size} bytes; at most {LARGEST} are wanted, split it"))
    near = {site / "index.html"}
    for _ in range(CLICKS):
        near = near.union(*(leads.get(path, set()) for path in near))
    far = [path for path in pages if path not in near]
    return found + [Fault(str(path.relative_to(site)), "", f"is more than {CLICKS} clicks away") for path in far]


if __name__ == "__main__":
    wrong = faults(Path(sys.argv[1]))
    for fault in wrong:
        print(f"{fault.page}: {fault.reference}: {fault.why}", file=sys.stderr)
    sys.exit(1 if wrong else 0)
