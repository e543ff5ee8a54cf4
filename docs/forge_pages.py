"""Write the pages of the site as plain Markdown with outputs and pictures, which GitHub and GitLab show as they are.

python docs/forge_pages.py [--prose]

The pages lie in docs/pages.  Cells are executed where their code or the package changed (docs/executed.py), and not
again by `make docs`; with --prose only where their code did.  tests/project/test_forge_pages.py compares the text of
each page with its source.
"""

from __future__ import annotations

import base64
import hashlib
import io
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

HERE = Path(__file__).parent
PAGES = HERE / "pages"
FOLDERS = {"start": "Start", "how_to": "How to", "theory": "Theory", "reference": "Reference"}
"""Folders of pages, with their headings in the list of all pages."""

COLOURS = 32  # of a picture: enough for figures and small
_OUTPUT = re.compile(r"<!-- output of cell (\d+) -->\n\n(.*?)\n\n<!-- end -->\n", re.DOTALL)
_WARNING = re.compile(r"^.*?\b(\w+Warning: .*)$", re.MULTILINE)

_CELL = re.compile(
    r"^```\{code-cell\}[^\n]*\n(?P<options>(?::[^\n]*\n)*)\n*(?P<code>.*?)^```\n", re.DOTALL | re.MULTILINE
)
_HEADER = re.compile(r"\A---\n.*?^---\n+", re.DOTALL | re.MULTILINE)
_PROSE = re.compile(
    r"""^```\{literalinclude\}\ (?P<file>\S+)\n(?P<choice>.*?)^```
    | ^```\{image\}\ (?P<image>\S+)\n:alt:\ (?P<alt>.*?)\n(?::class:\ only-(?P<theme>\w+)\n)?.*?^```
    | ^```\{eval-rst\}\n(?P<reference>.*?)^```
    | (?P<kept>^```.*?^``` | (?<!\})`[^`]+`)
    | \{doc\}`(?P<link>[^`]+)`
    | \{(?:class|func|meth)\}`[^`]*?(?P<name>\w+)`
    | \$\$(?P<display>.+?)\$\$
    | \$(?P<formula>[^$\n]+(?:\n[^$\n]+)?)\$""",
    re.DOTALL | re.MULTILINE | re.VERBOSE,
)


class Cell(NamedTuple):
    """The code of a page, and how it is shown."""

    code: str
    tags: frozenset[str]
    alt: str  # in place of its picture


def sources() -> list[str]:
    """Return the names of the pages, such as "how_to/reach"."""
    paths = (path for folder in FOLDERS for path in sorted((HERE / folder).glob("*.md")))
    return [path.relative_to(HERE).with_suffix("").as_posix() for path in paths]


def source(name: str) -> str:
    """Return what a page is written in."""
    return (HERE / f"{name}.md").read_text(encoding="utf-8")


def blocks(text: str) -> Iterator[str | Cell]:
    """Yield the prose and the cells of a page in turn."""
    text, end = _HEADER.sub("", text), 0
    for cell in _CELL.finditer(text):
        yield text[end : cell.start()]
        tags, alt = (re.search(pattern, cell["options"]) for pattern in (r":tags: \[(.*)\]", r'alt: "(.*?)"\}'))
        names = frozenset(re.split(r",\s*", tags[1])) if tags else frozenset()
        yield Cell(cell["code"], names, alt[1] if alt else "Figure")
        end = cell.end()
    yield text[end:]


def cells(text: str) -> list[Cell]:
    """Return the cells of a page."""
    return [block for block in blocks(text) if isinstance(block, Cell)]


def title(name: str) -> str:
    """Return the title of a page or of an example of the gallery, "" where there is none of this name."""
    example = HERE.parent / f"examples/{name.removeprefix('gallery/')}.py"
    for path, pattern in (
        (HERE / f"{name}.md", r"^# (.+)$"),
        (HERE / f"{name}.rst", r"^(.+)\n==="),
        (example, r'^"""(?:\n)?(.+)\n==='),
    ):
        if path.is_file() and (found := re.search(pattern, path.read_text(encoding="utf-8"), re.MULTILINE)):
            return found[1]
    return ""


def link(text: str, page: str) -> str:
    """Return a link of a page in Markdown; its text alone where the target is a page of the site only.

    >>> link("/how_to/reach", "theory/bends")
    '[How far can I push it?](../how_to/reach.md)'
    """
    words, _, target = " ".join(text.split()).removesuffix(">").rpartition("<")
    folder = "" if target.startswith("/") else page.rpartition("/")[0]
    name = f"{folder}/{target}".strip("/")
    words = words.strip() or title(name)
    if name in sources():
        return f"[{words}]({Path(os.path.relpath(name, Path(page).parent)).as_posix()}.md)"
    example = name.replace("gallery/", "examples/")
    if (HERE.parent / f"{example}.py").is_file():
        return f"[{words}]({'../' * (page.count('/') + 2)}{example}.py)"
    return words


def image(path: str, alt: str, theme: str | None, page: str) -> str:
    """Return a picture of the pages, one with a light and a dark form with that which suits the reader's page."""
    there = (HERE / page).parent / path
    address = Path(os.path.relpath(there, (PAGES / page).parent)).as_posix()
    if theme is None:
        return f"![{alt}]({address})"
    dark = f'<source media="(prefers-color-scheme: dark)" srcset="{address.replace("_light", "_dark")}">'
    return "" if theme == "dark" else f'<picture>{dark}<img src="{address}" width="460" alt="{alt}"></picture>'


def in_markdown(prose: str, page: str) -> str:
    """Return prose of a page with links, formulas and included files as forges write them."""

    def replaced(found: re.Match[str]) -> str:
        if found["file"]:
            first = re.search(r":lines: (\d+)-", found["choice"])
            path = (HERE / page).parent / found["file"]
            lines = path.read_text(encoding="utf-8").splitlines()[int(first[1]) - 1 if first else 0 :]
            return "\n".join([f"```{path.suffix.removeprefix('.')}", *lines, "```"])
        if found["image"]:
            return image(found["image"], found["alt"], found["theme"], page)
        if found["reference"]:
            names = ", ".join(f"`{each}`" for each in re.findall(r":: (\S+)", found["reference"]))
            return f"On the site: {names}."
        if found["link"]:
            return link(found["link"], page)
        if found["name"]:
            return f"`{found['name']}`"
        if found["display"]:
            return f"```math\n{found['display'].strip()}\n```"
        return f"$`{' '.join(found['formula'].split())}`$" if found["formula"] else found["kept"]

    return _PROSE.sub(replaced, prose)


def head(name: str) -> str:
    """Return the first line of a page in Markdown, which names its source and identifies the code of that."""
    code = "".join(cell.code for cell in cells(source(name)))
    digest = hashlib.sha256(code.encode()).hexdigest()[:16]
    return f"<!-- `make pages` writes this page from docs/{name}.md: edit that file. Its code: {digest} -->"


def written(name: str, outputs: Mapping[int, str]) -> str:
    """Return a page in Markdown, with the outputs of its cells in Markdown by the numbers of these."""
    text, number = f"{head(name)}\n\n", 0
    for block in blocks(source(name)):
        if isinstance(block, str):
            text += in_markdown(block, name)
            continue
        number += 1
        if "remove-cell" in block.tags:
            continue
        code = f"```python\n{block.code}```\n"
        if "hide-input" in block.tags:
            code = f"<details><summary>Show the computation</summary>\n\n{code}\n</details>\n"
        text += "" if "remove-input" in block.tags else code
        if output := outputs.get(number):
            text += f"\n<!-- output of cell {number} -->\n\n{output}\n\n<!-- end -->\n"
    return re.sub(r"\n{3,}", "\n\n", text).rstrip() + "\n"


def kept_outputs(text: str) -> dict[int, str]:
    """Return the outputs in a page in Markdown, by the numbers of their cells."""
    return {int(number): output for number, output in _OUTPUT.findall(text)}


def outputs_in_markdown(name: str, outputs: Sequence[Sequence[Any]], save: Callable[[bytes], str]) -> dict[int, str]:
    """Return the outputs of the cells of a page in Markdown, by the numbers of these.

    Parameters
    ----------
    name : str
        The name of the page.
    outputs : sequence of sequences
        Outputs of each cell, as a notebook has them.
    save : callable
        Takes a picture and returns the address that the page has it at.
    """
    made = {}
    for number, (cell, of_cell) in enumerate(zip(cells(source(name)), outputs, strict=True), 1):
        texts = (output_in_markdown(output, cell, save) for output in merged(of_cell))
        made[number] = "\n\n".join(filter(None, texts))
    return made


def merged(outputs: Sequence[Any]) -> list[Any]:
    """Return the outputs of a cell with all that it printed, and all its messages, in one each."""
    streams: dict[str, Any] = {}
    kept = []
    for output in outputs:
        if output.get("name") in streams:
            streams[output["name"]]["text"] += output["text"]
            continue
        kept.append(dict(output))
        if output["output_type"] == "stream":
            streams[output["name"]] = kept[-1]
    return kept


def output_in_markdown(output: Any, cell: Cell, save: Callable[[bytes], str]) -> str:
    """Return an output of a cell in Markdown, "" where none is to be seen: progress, and what the cell removes."""
    if output["output_type"] == "stream":
        text = output["text"]
        if output["name"] == "stderr":
            text = "\n".join([] if "remove-stderr" in cell.tags else _WARNING.findall(text))
        return f"```text\n{text.rstrip()}\n```" if text.strip() else ""
    data = output["data"]
    html = data.get("text/html", "")
    if html and "<style" not in html:
        return re.sub(r"(?<=</table>)|(?<=</details>)|(?<=</p>)|(?<=</tr>)(?=<tr>)", "\n", html).strip()
    if "image/png" in data:
        return f"![{cell.alt}]({save(base64.b64decode(data['image/png']))})"
    if "text/latex" in data:
        formula = data["text/latex"].strip("$\n ").removeprefix("\\displaystyle").strip()
        return f"```math\n{formula}\n```"
    return f"```text\n{data['text/plain']}\n```"


def contents() -> str:
    """Return the list of all pages."""
    lines = [
        "<!-- `make pages` writes this page. -->\n",
        "# Pages of floquetrod\n",
        "The pages of the site with the outputs of their code. `make docs` builds the site, with search, a gallery and",
        "the reference of all functions.",
    ]
    listed = re.findall(r"^(?:start|how_to|theory)/\w+$", (HERE / "index.md").read_text(encoding="utf-8"), re.MULTILINE)
    for folder, heading in FOLDERS.items():
        names = [name for name in (listed if folder != "reference" else sources()) if name.startswith(f"{folder}/")]
        lines += [f"\n## {heading}\n", *(f"- [{title(name)}]({name}.md)" for name in names)]
    return "\n".join(lines) + "\n"


def executed_outputs(name: str) -> list[Any]:
    """Return the outputs of the cells of a page, executed where they are not kept."""
    import logging

    import executed
    from myst_nb.core.config import NbParserConfig
    from myst_nb.core.execute import create_client
    from myst_nb.core.read import create_nb_reader
    from myst_parser.config.main import MdParserConfig

    config = NbParserConfig(
        execution_mode="cache",
        execution_cache_path=executed.cache(),
        execution_raise_on_error=True,
        execution_timeout=300,
        execution_in_temp=True,
        merge_streams=True,
    )
    path, text = str(HERE / f"{name}.md"), source(name)
    reader = create_nb_reader(path, MdParserConfig(), config, text)
    if reader is None:  # nothing to execute
        return []
    notebook = reader.read(text)
    with create_client(notebook, path, config, logging.getLogger("pages"), reader.read_fmt) as client:
        return [cell.outputs for cell in client.notebook.cells if cell.cell_type == "code"]


def write(folder: Path = PAGES, *, prose: bool = False) -> None:
    """Write all pages and remove what is no longer among them; with ``prose`` keep outputs where the code is kept."""
    made = {folder / "README.md": contents().encode()}
    for name in sources():
        path = folder / f"{name}.md"
        kept = path.read_text(encoding="utf-8") if path.exists() else ""
        if prose and kept.startswith(head(name)):
            outputs = kept_outputs(kept)
            pictures = [path.with_name(picture).read_bytes() for picture in re.findall(r"\]\((\w+\.png)\)", kept)]
        else:
            print(name, flush=True)
            outputs, pictures = executed_page(name)
        made[path] = written(name, outputs).encode()
        made |= {path.with_name(picture_name(name, number)): each for number, each in enumerate(pictures, 1)}
    for path, content in made.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    for path in folder.rglob("*.*"):
        if path not in made:
            path.unlink()


def picture_name(page: str, number: int) -> str:
    """Return the name of the file of a picture of a page."""
    return f"{page.rpartition('/')[2]}_{number}.png"


def executed_page(name: str) -> tuple[dict[int, str], list[bytes]]:
    """Return the outputs of a page in Markdown by the numbers of their cells, and its pictures."""
    pictures: list[bytes] = []

    def save(picture: bytes) -> str:
        pictures.append(with_few_colours(picture))
        return picture_name(name, len(pictures))

    return outputs_in_markdown(name, executed_outputs(name), save), pictures


def with_few_colours(picture: bytes) -> bytes:
    """Return a picture with so few colours that it is small."""
    from PIL import Image

    small = io.BytesIO()
    Image.open(io.BytesIO(picture)).convert("RGB").quantize(COLOURS).save(small, "png", optimize=True)
    return small.getvalue()


if __name__ == "__main__":
    sys.path.insert(0, str(HERE))
    import kernels

    kernels.setup(None)  # type: ignore[arg-type]
    write(prose="--prose" in sys.argv[1:])
