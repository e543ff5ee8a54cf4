"""The pages in docs/pages, which forges show, have the text of their sources, and their links lead somewhere."""

from __future__ import annotations

import re
import runpy
import tomllib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "docs/pages"
REMEDY = "run `make pages`, or where only prose has changed `python docs/forge_pages.py --prose`"
FORGE = SimpleNamespace(**runpy.run_path(str(ROOT / "docs/forge_pages.py")))


def page(name: str) -> str:
    """Return a page as it is kept."""
    return (PAGES / f"{name}.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", FORGE.sources())
def test_a_page_has_the_text_of_its_source(name: str) -> None:
    outputs = FORGE.kept_outputs(page(name))
    assert page(name) == FORGE.written(name, outputs), f"docs/{name}.md has changed: {REMEDY}"
    for number, cell in enumerate(FORGE.cells(FORGE.source(name)), 1):
        prints = re.search(r"^print\(", cell.code, re.MULTILINE) and "remove-cell" not in cell.tags
        assert not prints or "```text" in outputs[number], cell.code


def test_pages_are_those_of_the_sources_and_their_list_is_whole() -> None:
    kept = {path.relative_to(PAGES).with_suffix("").as_posix() for path in PAGES.rglob("*.md")}
    assert kept == {"README", *FORGE.sources()}
    assert page("README") == FORGE.contents()
    assert {name for name in FORGE.sources() if f"({name}.md)" not in page("README")} == set()


def test_nothing_but_markdown_is_left_and_links_and_pictures_are_there() -> None:
    shown = set()
    for path in PAGES.rglob("*.md"):
        text = path.read_text(encoding="utf-8")
        roles = "code-cell|eval-rst|doc|class|func|meth|literalinclude|image|container"
        assert not re.search(rf"\{{(?:{roles})\}}|file_format: mystnb|^:tags:", text, re.MULTILINE), path.name
        prose = re.sub(r"^```.*?^```$|`[^`]*`", "", text, flags=re.DOTALL | re.MULTILINE)
        targets = [target for target in re.findall(r"\]\(([^)\s#]+)[^)\s]*\)", prose) if "://" not in target]
        targets += re.findall(r'src(?:set)?="([^"]+)"', text)
        assert [target for target in targets if not (path.parent / target).exists()] == [], path.name
        shown |= {(path.parent / target).resolve() for target in targets if target.endswith((".png", ".svg"))}
    assert {path.resolve() for path in PAGES.rglob("*.png")} <= shown
    assert {path.name for path in shown if path.suffix == ".svg"} == {
        path.name for path in (ROOT / "docs").glob("*.svg")
    }
    assert sum(path.stat().st_size for path in PAGES.rglob("*")) < 3_000_000


@pytest.mark.parametrize("name", FORGE.sources())
def test_no_output_has_the_path_of_a_temporary_file(name: str) -> None:
    """A warning on stderr has the path of a cell on the site, so a page prints the warnings that it shows."""
    for output in FORGE.kept_outputs(page(name)).values():
        assert not re.search(r"/tmp/|/var/folders/|ipykernel|^```text\n\w+Warning: ", output, re.MULTILINE), output


def test_the_front_door_leads_to_pages_that_a_forge_shows() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#\s]+\.(?:md|rst))\)", text):
        assert "{code-cell}" not in (ROOT / target).read_text(encoding="utf-8"), target
        assert not target.endswith(".rst"), "a forge shows no directive of Sphinx"


def cell(*tags: str) -> Any:
    return FORGE.Cell("f()\n", frozenset(tags), "A curve")


def output(**data: str) -> dict[str, Any]:
    return {"output_type": "execute_result", "data": {name.replace("_", "/"): text for name, text in data.items()}}


@pytest.mark.parametrize(
    ("given", "shown"),
    [
        (output(text_plain="<unstable>"), "```text\n<unstable>\n```"),
        (output(text_html="<table></table>", text_plain="no"), "<table></table>"),
        (output(text_html="<style></style>", text_plain="a dataset"), "```text\na dataset\n```"),
        (output(text_latex=r"$\displaystyle a_m$", text_plain="a_m"), "```math\na_m\n```"),
        (output(image_png="aGVsbG8=", text_plain="<Figure>"), "![A curve](hello.png)"),
        ({"output_type": "stream", "name": "stdout", "text": "1\n2\n"}, "```text\n1\n2\n```"),
        ({"output_type": "stream", "name": "stderr", "text": "simulating: 1 s\r"}, ""),
        (
            {"output_type": "stream", "name": "stderr", "text": "/a.py:1: RodWarning: long\n  f()\n"},
            "```text\nRodWarning: long\n```",
        ),
    ],
)
def test_outputs_in_markdown(given: dict[str, Any], shown: str) -> None:
    assert FORGE.output_in_markdown(given, cell(), lambda picture: f"{picture.decode()}.png") == shown


def test_prose_in_markdown() -> None:
    links = "See {doc}`/theory/bends`, {doc}`how\n</how_to/reach>`, `$x$`, {class}`floquetrod.Rod`"
    made = FORGE.in_markdown(f"{links} and $a\n< b$:\n\n$$\\theta_{{ss}}$$\n", "how_to/well")
    assert made.startswith(
        f"See [{FORGE.title('theory/bends')}](../theory/bends.md), [how](reach.md), `$x$`, `Rod` and"
    )
    assert made.endswith(" $`a < b`$:\n\n```math\n\\theta_{ss}\n```\n")


def test_derivations_are_folded_and_outputs_come_back_out_of_a_page() -> None:
    text = FORGE.written("theory/rod", {1: "```text\n1\n```", 3: "![A](rod_1.png)"})
    assert "<details><summary>Show the computation</summary>" in text
    assert FORGE.kept_outputs(text) == {1: "```text\n1\n```", 3: "![A](rod_1.png)"}
    assert text.startswith(FORGE.head("theory/rod"))


def test_what_a_cell_prints_is_one_output() -> None:
    lines = [{"output_type": "stream", "name": name, "text": f"{name}\n"} for name in ("stdout", "stderr", "stdout")]
    assert [output["text"] for output in FORGE.merged(lines)] == ["stdout\nstdout\n", "stderr\n"]


@pytest.mark.skipif(not (ROOT / ".readthedocs.yaml").exists(), reason="a copy without what only the repository has")
def test_the_site_is_published_by_targets_and_extras_that_there_are() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    config = (ROOT / ".readthedocs.yaml").read_text(encoding="utf-8")
    (extras,) = re.findall(r'-e "\.\[(.*)\]"', config)
    assert {"docs"} <= set(extras.split(",")) <= set(project["optional-dependencies"])
    assert all((ROOT / name).is_file() for name in re.findall(r"configuration: (\S+)|-c (\S+)", config)[0] if name)
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    for workflow in (ROOT / ".github/workflows").glob("*.yml"):
        assert set(re.findall(r"run: make (\w+)", workflow.read_text(encoding="utf-8"))) <= targets
