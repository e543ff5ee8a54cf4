"""The layers drawn in docs/architecture.md hold, and importing the package stays cheap."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from fnmatch import fnmatch
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = "floquetrod"
LAZY = {"numba", "llvmlite", "scipy", "mpmath", "sympy", "matplotlib"}
ALLOWED = {"numpy", "numba", "scipy", "mpmath", "sympy", "matplotlib", "xarray"} | set(sys.stdlib_module_names)


def module_files() -> dict[str, Path]:
    """Return the file of every module, by its name within the package; "__init__" is the package itself."""
    files = {}
    for path in sorted((ROOT / PACKAGE).rglob("*.py")):
        parts = path.relative_to(ROOT / PACKAGE).with_suffix("").parts
        files[".".join(parts).removesuffix(".__init__")] = path
    return files


def drawn_layers() -> list[tuple[int, str]]:
    """Return (layer, module pattern) pairs from the drawing."""
    text = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")
    found = re.search(r"```layers\n(.*?)```", text, re.DOTALL)
    assert found, "docs/architecture.md has lost its drawing"
    lines = [re.split(r"\s{2,}", line.strip(), maxsplit=2) for line in found[1].splitlines()]
    return [(int(number), name) for number, names, _ in lines for name in names.split(", ")]


FILES = module_files()
DRAWN = drawn_layers()


def layers_of(module: str) -> list[int]:
    """Return every layer in which the drawing puts ``module``."""
    # A package within ours is of the layer its modules are in: "kernels" matches "kernels.*".
    return [layer for layer, pattern in DRAWN if fnmatch(module, pattern) or fnmatch(f"{module}.", pattern)]


def imports(tree: ast.AST, module: str, path: Path) -> Iterator[str]:
    """Yield the full names of what a module imports anywhere in it: functions, type checking and import_module too."""
    here = [PACKAGE, *module.split(".")]
    if module == "__init__" or path.name != "__init__.py":
        here.pop()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = here[: len(here) - node.level + 1] if node.level else []
            source = ".".join([*base, *filter(None, [node.module])])
            yield from (f"{source}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("import_module", "__import__")):
            yield _beginning(node.args[0])


def _beginning(argument: ast.expr) -> str:
    """Return the constant beginning of a module's name given as a string or an f-string."""
    first = argument.values[0] if isinstance(argument, ast.JoinedStr) else argument
    assert isinstance(first, ast.Constant), f"cannot tell what import_module({ast.unparse(argument)}) imports"
    return str(first.value)


def own_module(name: str) -> str | None:
    """Return the module of this package that importing the full name ``name`` loads, None for another package."""
    if name.split(".")[0] != PACKAGE:
        return None
    inner = name.split(".")[1:]
    while inner and ".".join(inner) not in FILES:
        inner.pop()
    return ".".join(inner) or "__init__"


def parse(module: str) -> ast.Module:
    return ast.parse(FILES[module].read_text(encoding="utf-8"))


@pytest.mark.parametrize("module", FILES)
def test_every_module_is_drawn_once(module: str) -> None:
    assert len(layers_of(module)) == 1, f"{module} is in layers {layers_of(module)} of docs/architecture.md"


def test_everything_drawn_exists() -> None:
    absent = [pattern for _, pattern in DRAWN if not any(fnmatch(module, pattern) for module in FILES)]
    assert not absent


@pytest.mark.parametrize("module", FILES)
def test_imports_go_downwards(module: str) -> None:
    (layer,) = layers_of(module)
    for name in imports(parse(module), module, FILES[module]):
        target = own_module(name)
        if name == "floquetrod." and module == "__init__":
            continue  # loads by name what it also lists for type checkers, above
        if target is not None:
            assert layers_of(target)[0] < layer, f"{module} (layer {layer}) imports {name}"


@pytest.mark.parametrize("module", FILES)
def test_imports_only_what_is_declared(module: str) -> None:
    outside = {name.split(".")[0] for name in imports(parse(module), module, FILES[module])} - {PACKAGE}
    assert outside <= ALLOWED


def test_the_analysis_sees_every_kind_of_import() -> None:
    code = """
from floquetrod import rod as r
from . import verdict
from ..methods.spectral import spectral
if TYPE_CHECKING:
    import floquetrod.cli
def later():
    from floquetrod.kernels import mathieu
    importlib.import_module(f"floquetrod.methods.{name}")
"""
    found = set(imports(ast.parse(code), "kernels.mathieu", Path("mathieu.py")))
    assert found == {
        "floquetrod.rod",
        "floquetrod.kernels.verdict",
        "floquetrod.methods.spectral.spectral",
        "floquetrod.cli",
        "floquetrod.kernels.mathieu",
        "floquetrod.methods.",
    }


def loaded_after(statements: str) -> set[str]:
    """Return the packages of `LAZY` that a fresh interpreter has loaded after ``statements``."""
    code = f"{statements}\nimport sys\nprint(*sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    return LAZY & set(run.stdout.split())


def test_import_loads_nothing_heavy() -> None:
    assert loaded_after("import floquetrod") == set()


def test_importing_every_module_loads_nothing_heavy() -> None:
    names = [f"{PACKAGE}.{module}" for module in FILES if not module.startswith("__")]
    assert loaded_after("\n".join(f"import {name}" for name in names)) == set()


def test_a_scalar_verdict_needs_no_compiler() -> None:
    assert "numba" not in loaded_after("import floquetrod as fr; fr.stability(fr.Mathieu(alpha=0.5, beta=-0.25))")
