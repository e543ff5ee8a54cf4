"""What pages and examples come out as depends on their own text and on all else that `digest` covers.

Executed pages and examples are kept below docs/_build, under that digest: where it is the same and their own text is,
they are not executed again.  Docstrings, comments and layout of the package change no output, so they do not count.
"""

from __future__ import annotations

import ast
import functools
import hashlib
import shutil
import sys
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

import floquetrod

if TYPE_CHECKING:
    import sphinx.application

HERE = Path(__file__).parent
PACKAGE = Path(floquetrod.__file__).parent
LIBRARIES = {
    "numpy",
    "scipy",
    "numba",
    "mpmath",
    "matplotlib",
    "sympy",
    "xarray",
    "zarr",
    "ipykernel",
    "sphinx-gallery",
}
BESIDE = ("benchmarks/**/*.py", "tests/strategies.py", "tests/published.py", "tests/*_cases.py")
"""What pages take from beside the package."""

KEPT = "executed"
"""The folder beside the built site that holds one folder, named by the digest."""


def code(text: str) -> str:
    """Return what a Python file says without its docstrings, comments and layout."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node, clean=False):
            node.body = node.body[1:]
    return ast.dump(tree)


@functools.cache
def libraries() -> list[str]:
    """Return the versions of the libraries that are installed."""
    return sorted(f"{each.name} {each.version}" for each in metadata.distributions() if each.name in LIBRARIES)


def parts(package: Path, root: Path) -> Iterator[str]:
    """Yield everything the digest covers: versions, code, the data of examples, and how thumbnails are drawn."""
    yield sys.version
    yield from libraries()
    beside = [path for pattern in BESIDE for path in root.glob(pattern)]
    for path in [*package.rglob("*.py"), *beside, HERE / "thumbnails.py"]:
        yield f"{path.relative_to(root) if root in path.parents else path.name}: {code(path.read_text('utf-8'))}"
    for path in (*package.rglob("*"), *(root / "examples").glob("*")):
        if path.suffix in {".toml", ".csv", ".json", ".mplstyle"}:
            yield f"{path.name}: {path.read_text('utf-8')}"


@functools.cache
def digest(package: Path = PACKAGE, root: Path = HERE.parent) -> str:
    """Return the digest of all that a page or an example may use."""
    found = hashlib.sha256()
    for part in sorted(parts(package, root)):
        found.update(part.encode())
    return found.hexdigest()[:32]


def cache(build: Path = HERE / "_build") -> str:
    """Return where executed pages are kept."""
    return str(build / KEPT / digest())


def are_examples_stale(gallery: Path = HERE / "gallery") -> bool:
    """Return whether examples were made under another digest, so that those unchanged must be executed, too."""
    kept = gallery / "digest"
    return not kept.exists() or kept.read_text("utf-8") != digest()


def keep(app: sphinx.application.Sphinx, error: Exception | None) -> None:
    """Note under which digest the gallery was made, and remove pages executed under another one."""
    if error is None:
        (Path(app.srcdir) / "gallery/digest").write_text(digest(), encoding="utf-8")
        for old in Path(cache()).parent.glob("*"):
            if old.name != digest():
                shutil.rmtree(old)


def setup(app: sphinx.application.Sphinx) -> dict[str, bool]:
    """Do so when the site is built."""
    app.connect("build-finished", keep)
    return {"parallel_read_safe": True}
