"""Open every page of a built site in a browser, look for what a reader would stumble over, and save pictures of all.

python docs/look.py docs/_build/html pictures [page ...]

Each page is opened on a desktop, on a phone and in the dark.  Reported are pages and, on the desktop, blocks of code
that scroll sideways, formulas, pictures and tables cut off at the right, violations of accessibility found by axe-core,
errors of scripts, and a search without excerpts or in the wrong order.
Needs the extra site-check and a Chromium: that of $CHROMIUM, or the first found on the path.
"""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

VIEWS = {"desktop": (1400, 900, "light"), "phone": (390, 844, "light"), "dark": (1400, 900, "dark")}
RULES: dict[str, dict[str, Any]] = {
    "desktop": {},
    "phone": {"rules": {"color-contrast": {"enabled": False}}},
    "dark": {"runOnly": ["color-contrast", "link-in-text-block"]},
}
"""Of the rules of axe-core: all on the desktop; a narrower page changes no contrast, and the dark nothing else."""

TALLEST = 12_000  # pixels of a page in its picture
FOUND_FIRST = {
    "safe frequency": "/how_to/my_rod.html",
    "own equation": "/how_to/my_equation.html",
    "discriminant": ".html",
}
"""Words that are searched for, and how the address of the first result ends (search_order.js)."""

SCROLLS = """() => {
  const wide = document.documentElement.scrollWidth - document.documentElement.clientWidth;
  const code = [...document.querySelectorAll("article pre")].filter(e => e.scrollWidth > e.clientWidth);
  return [wide, code.map(e => `${e.scrollWidth - e.clientWidth} px: ${e.textContent.trim().slice(0, 60)}`)];
}"""
CUT_OFF = """() => {
  const right = document.documentElement.clientWidth;
  const scrolls = e => e && e.tagName !== "ARTICLE" &&
    (["auto", "scroll"].includes(getComputedStyle(e).overflowX) || scrolls(e.parentElement));
  return [...document.querySelectorAll("article mjx-container, article img, article table, article code")]
    .filter(e => e.getBoundingClientRect().right > right + 1 && !scrolls(e))
    .map(e => e.textContent.trim().slice(0, 60) || e.tagName.toLowerCase());
}"""
UNFOLD = "() => document.querySelectorAll('details').forEach(each => each.open = true)"
READY = "() => window.MathJax && MathJax.startup ? MathJax.startup.promise.then(() => true) : true"


def chromium() -> str:
    """Return where the browser is."""
    found = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, ("chromium", "google-chrome"))), None)
    if found is None:
        raise FileNotFoundError("no Chromium on the path; install one, or name it in $CHROMIUM")
    return found


def violations(page: Any, view: str) -> Iterator[str]:
    """Yield what the rules of axe-core for a view find on an open page."""
    from axe_playwright_python.sync_playwright import Axe

    for found in Axe().run(page, options={"preload": False, **RULES[view]}).response["violations"]:
        # axe does not read MathML, which MathJax writes beside each formula for those who hear it.
        nodes = [
            node
            for node in found["nodes"]
            if found["id"] != "empty-table-header" or not page.locator(f"{node['target'][0]} mjx-container").count()
        ]
        if not nodes:
            continue
        places = [" ".join(map(str, node["target"])) for node in nodes]
        why = nodes[0]["failureSummary"].split("\n")[1].strip()
        yield f"{found['id']} ({len(places)}): {', '.join(places[:3])}: {why}"


def faults(page: Any, address: str, view: str, picture: Path) -> Iterator[str]:
    """Open a page, save its picture and yield what is wrong with it."""
    errors: list[str] = []
    page.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.goto(address)
    page.evaluate(READY)
    page.wait_for_timeout(100)
    picture.parent.mkdir(parents=True, exist_ok=True)
    height = min(page.evaluate("() => document.documentElement.scrollHeight"), TALLEST)
    page.screenshot(path=picture, full_page=True, clip={"x": 0, "y": 0, "width": VIEWS[view][0], "height": height})
    page.evaluate(UNFOLD)
    page.wait_for_timeout(500)  # what is unfolded fades in
    wide, code = page.evaluate(SCROLLS)
    if wide > 0:
        yield f"the page scrolls sideways by {wide} px"
    yield from (f"cut off at the right: {each}" for each in page.evaluate(CUT_OFF))
    if view == "desktop":
        yield from (f"code scrolls sideways by {each}" for each in code)
    yield from (f"error of a script: {error}" for error in errors)
    yield from violations(page, view)


def search_faults(page: Any, site: Path) -> Iterator[str]:
    """Search for words and yield what is wrong with the results."""
    for words, first in FOUND_FIRST.items():
        page.goto(f"{(site / 'search.html').as_uri()}?q={words.replace(' ', '+')}")
        page.wait_for_timeout(1500)
        results = page.evaluate("() => [...document.querySelectorAll('#search-results li a')].map(e => e.pathname)")
        if not results or not results[0].endswith(first):
            yield f"a search for {words!r} finds {results[0] if results else 'nothing'} first, not {first}"
    excerpts = page.evaluate("() => [...document.querySelectorAll('#search-results p.context')].map(e => e.innerText)")
    if not any(words in excerpt.lower() for excerpt in excerpts):
        yield "a search from disk shows no excerpts"


def look(site: Path, folder: Path, names: list[str]) -> Iterator[str]:
    """Open the pages of a site in every view, save pictures and yield what is wrong."""
    from playwright.sync_api import sync_playwright

    pages = [path for path in sorted(site.rglob("*.html")) if not names or path.relative_to(site).as_posix() in names]
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])
        for view, (width, height, scheme) in VIEWS.items():
            context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
            for path in pages:
                name = path.relative_to(site).as_posix()
                page = context.new_page()
                picture = folder / view / f"{name.replace('/', '.')}.png"
                yield from (f"{view}: {name}: {fault}" for fault in faults(page, path.as_uri(), view, picture))
                page.close()
            if view == "desktop":
                yield from (f"{view}: search.html: {fault}" for fault in search_faults(context.new_page(), site))
            context.close()
        browser.close()


if __name__ == "__main__":
    number = 0
    for fault in look(Path(sys.argv[1]).resolve(), Path(sys.argv[2]), sys.argv[3:]):
        number += 1
        print(fault, file=sys.stderr, flush=True)
    print(f"{number} faults; pictures in {sys.argv[2]}")
    sys.exit(1 if number else 0)
