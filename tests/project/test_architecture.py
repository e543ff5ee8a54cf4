"""The layers drawn in docs/architecture.md hold, and importing the package stays cheap."""

from __future__ import annotations

import ast
import functools
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import floquetrod

ROOT = Path(__file__).parents[2]
PACKAGE = "floquetrod"
LAZY = {"numba", "llvmlite", "scipy", "mpmath", "sympy", "matplotlib", "contourpy"}
EXTRAS = {"pandas", "xarray", "zarr", "numcodecs", "cloudpickle", "shtab", "tornado", "openpyxl"}
COMES_WITH_MATPLOTLIB = {"contourpy"}
ALLOWED = (
    {"numpy", "numba", "scipy", "mpmath", "sympy", "matplotlib"}
    | COMES_WITH_MATPLOTLIB
    | EXTRAS
    | set(sys.stdlib_module_names)
)


def module_files() -> dict[str, Path]:
    """Return the file of every module, by its name within the package; "__init__" is the package itself."""
    files = {}
    for path in sorted((ROOT / PACKAGE).rglob("*.py")):
        parts = path.relative_to(ROOT / PACKAGE).with_suffix("").parts
        files[".".join(parts).removesuffix(".__init__")] = path
    return files


def drawn_layers(name: str = "layers") -> list[tuple[int, str]]:
    """Return (layer, module pattern) pairs from the drawing."""
    text = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")
    found = re.search(rf"```{name}\n(.*?)```", text, re.DOTALL)
    assert found, "docs/architecture.md has lost its drawing"
    lines = [re.split(r"\s{2,}", line.strip(), maxsplit=2) for line in found[1].splitlines()]
    return [(int(number), name) for number, names, _ in lines for name in names.split(", ")]


FILES = module_files()
DRAWN = drawn_layers()


def room_of(module: str) -> str:
    """Return the package a module lies in, or the module itself where it lies in none."""
    return "cli" if module == "__main__" else module.split(".")[0]


LAYERS = {name: layer for layer, name in DRAWN}


def imports(code: str, module: str, path: Path) -> Iterator[str]:
    """Yield the full names of what a module imports anywhere in it: functions, type checking and import_module too."""
    tree = ast.parse(code)
    here = [PACKAGE, *module.split(".")]
    if module == "__init__" or path.name != "__init__.py":
        here.pop()
    calls = "import_module" in code or "__import__" in code
    for node in ast.walk(tree) if calls else statements(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = here[: len(here) - node.level + 1] if node.level else []
            source = ".".join([*base, *filter(None, [node.module])])
            yield from (f"{source}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Call) and _called(node).endswith(("import_module", "__import__")):
            yield from _named(node.args[0])


def statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield a tree and the statements in it, of which there are a tenth as many as nodes."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        for block in ("body", "orelse", "finalbody", "handlers", "cases"):
            within = getattr(node, block, None)
            waiting += within if isinstance(within, list) else []


def _called(call: ast.Call) -> str:
    """Return the last part of the name of what is called."""
    return str(getattr(call.func, "attr", getattr(call.func, "id", "")))


def _named(argument: ast.expr) -> list[str]:
    """Return the modules that a string names, or an f-string may: all that begin so, of a folder of the package."""
    first = argument.values[0] if isinstance(argument, ast.JoinedStr) else argument
    assert isinstance(first, ast.Constant), f"cannot tell what import_module({ast.unparse(argument)}) imports"
    begins = str(first.value).removeprefix(f"{PACKAGE}.")
    below = [module for module in FILES if begins.endswith(".") and module.startswith(begins)]
    return [f"{PACKAGE}.{module}" for module in below] or [str(first.value)]


def own_module(name: str) -> str | None:
    """Return the module of this package that importing the full name ``name`` loads, None for another package."""
    if name.split(".")[0] != PACKAGE:
        return None
    inner = name.split(".")[1:]
    while inner and ".".join(inner) not in FILES:
        inner.pop()
    return ".".join(inner) or "__init__"


@functools.cache
def code_of(module: str) -> str:
    return FILES[module].read_text(encoding="utf-8")


@functools.cache
def imported(module: str) -> frozenset[str]:
    """Return the full names of what a module imports."""
    return frozenset(imports(code_of(module), module, FILES[module]))


def test_every_room_is_drawn_once_and_exists() -> None:
    drawn = [name for _, name in DRAWN]
    assert sorted(drawn) == sorted({room_of(module) for module in FILES})


def missing(text: str) -> list[str]:
    """Return the files that a page names and nobody finds; a bare name may be beside the one before it in its line."""
    lost = []
    for line in text.splitlines():
        beside = ROOT / PACKAGE
        for name in re.findall(r"`([\w/]+\.py)`", line):
            found = [path for folder in (ROOT / PACKAGE, ROOT, beside) if (path := folder / name).is_file()]
            lost += [] if found else [name]
            beside = found[0].parent if found else beside
    return lost


def test_every_file_on_the_map_of_the_code_exists() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    assert missing(text) == []
    assert missing("a: `rod/rod.py`, `stability_map.py`, `no.py`; `floquet/rod.py`") == ["no.py", "floquet/rod.py"]


def test_the_map_fits_two_pages_and_contributing_one() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 140
    assert sum(line.startswith("| ") for line in text.splitlines()) <= 40
    assert len((ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").splitlines()) <= 60


def test_a_row_of_the_map_names_at_least_one_file() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    rows = [line for line in text.splitlines() if line.startswith("| ")][2:]
    assert rows
    assert not [row for row in rows if not re.search(r"`[\w/]+\.py`", row)]


@functools.cache
def targets(module: str) -> set[str]:
    """Return the modules of this package that a module imports."""
    found = set()
    for name in imported(module):
        target = own_module(name)
        by_name = module in ("__init__", "_util.lazy") and name == "floquetrod."
        if target is not None and not by_name:  # names loaded when first used are listed for type checkers, too
            found.add(target)
    return found


def test_imports_go_downwards() -> None:
    pairs = ((module, target, room_of(module), room_of(target)) for module in FILES for target in targets(module))
    upwards = [
        f"{module} (layer {LAYERS[here]}) imports {target}"
        for module, target, here, there in pairs
        if not (there == here or LAYERS[there] < LAYERS[here])
    ]
    assert upwards == []


def test_the_folders_of_the_rod_have_layers() -> None:
    layers = {name: layer for layer, name in drawn_layers("layers of rod")}

    def folder(module: str) -> str:
        _, *inner = module.split(".")
        return inner[0] if FILES[module].parent.name != "rod" else "(files)"

    inside = [module for module in FILES if room_of(module) == "rod" and module != "rod"]
    assert {folder(module) for module in inside} == layers.keys()
    for module in inside:
        here = folder(module)
        for target in targets(module) & set(inside):
            assert folder(target) == here or layers[folder(target)] < layers[here], f"{module} imports {target}"


@pytest.mark.parametrize("room", LAYERS)
def test_imports_within_a_room_form_no_circle(room: str) -> None:
    inner = {module: {t for t in targets(module) if room_of(t) == room} for module in FILES if room_of(module) == room}
    # A package's own page of names imports its modules, and none of them asks for it.
    assert not [module for module, found in inner.items() if room in found - {module}]
    while inner:
        free = [module for module, found in inner.items() if not found & inner.keys() - {module}]
        assert free, f"a circle among {', '.join(sorted(inner))}"
        for module in free:
            del inner[module]


def test_no_method_imports_another() -> None:
    for module in FILES:
        if module.startswith("floquet.methods."):
            assert not {t for t in targets(module) if t.startswith("floquet.methods")}, module


def test_imports_only_what_is_declared() -> None:
    outside = {(name.split(".")[0], module) for module in FILES for name in imported(module)}
    assert [(name, module) for name, module in outside if name not in ALLOWED | {PACKAGE}] == []


def test_the_study_uses_the_package_and_what_that_declares() -> None:
    for path in sorted((ROOT / "studies").glob("*.py")):
        found = imports(path.read_text(encoding="utf-8"), "cli", path)
        assert {name.split(".")[0] for name in found} <= ALLOWED - EXTRAS | {PACKAGE, "studies"}, path.name


def test_no_property_is_kept_behind_a_lock() -> None:
    """Up to Python 3.11 the `cached_property` of the library is, and a forked process may find it locked for ever."""
    others = [module for module in FILES if module != "_util.caching"]
    assert [module for module in others if "functools.cached_property" in imported(module)] == []
    codes = ((module, code) for module in others if "cached_property" in (code := code_of(module)))
    attributes = ((node, module) for module, code in codes for node in ast.walk(ast.parse(code)))
    named = ((node, module) for node, module in attributes if getattr(node, "attr", "") == "cached_property")
    assert [module for node, module in named if ast.unparse(node) == "functools.cached_property"] == []


def test_the_analysis_sees_every_kind_of_import() -> None:
    code = """
from floquetrod import rod as r
from . import verdict
from ..methods.spectral import spectral
if TYPE_CHECKING:
    import floquetrod.cli
def later():
    from floquetrod.floquet.kernels import mathieu_discriminant
    importlib.import_module(f"floquetrod.methods.{name}")
"""
    found = set(imports(code, "kernels.mathieu", Path("mathieu.py")))
    assert found == {
        "floquetrod.rod",
        "floquetrod.kernels.verdict",
        "floquetrod.methods.spectral.spectral",
        "floquetrod.cli",
        "floquetrod.floquet.kernels.mathieu_discriminant",
        "floquetrod.methods.",
    }
    # Where nothing is imported by a call, statements alone are looked at.
    block = "try:\n pass\nexcept E:\n import a\nelse:\n import b\nfinally:\n import c\nmatch x:\n case 1:\n  import d\n"
    without = code[: code.index("    importlib")] + block + "while x:\n pass\nelse:\n with y:\n  import e\n"
    named = set(imports(without, "kernels.mathieu", Path("mathieu.py")))
    assert named == found - {"floquetrod.methods."} | {"a", "b", "c", "d", "e"}


SYSTEM = "fr.HillSystem([[1, 0], [0, 4]], cosines=[[[0.1, 0.2], [0.2, 0.16]]], damping={})"
VERDICTS = {
    "one equation": "fr.stability(fr.Mathieu(alpha=0.5, beta=-0.25))",
    **{
        name: f"s = {SYSTEM.format(damping)}; fr.stability(s); fr.systems.is_stable(s)"
        for name, damping in {"a system": "None", "a damped system": "[[0.1, 0.0], [0.0, 0.2]]"}.items()
    },
}


@pytest.fixture(scope="module")
def loaded() -> dict[str, set[str]]:
    """Return the packages of `LAZY` that a fresh interpreter has loaded after each of these, one after the other."""
    names = [f"{PACKAGE}.{module}" for module in FILES if not module.startswith("__")]
    names += [f"studies.{path.stem}" for path in sorted((ROOT / "studies").glob("*.py"))]
    work = {"the package": "import floquetrod as fr", "every module": f"import {', '.join(names)}", **VERDICTS}
    code = "import sys\n" + "\n".join(f"{statements}\nprint(*sys.modules)" for statements in work.values())
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    return {name: LAZY & set(line.split()) for name, line in zip(work, run.stdout.splitlines(), strict=True)}


@pytest.mark.parametrize("imported", ["the package", "every module"])
def test_imports_load_nothing_heavy(imported: str, loaded: dict[str, set[str]]) -> None:
    assert loaded[imported] == set()


@pytest.mark.parametrize("question", VERDICTS)
def test_a_single_verdict_needs_no_compiler(question: str, loaded: dict[str, set[str]]) -> None:
    assert "numba" not in loaded[question]


def test_methods_of_a_rod_only_call_what_computes() -> None:
    """A method is its docstring and three statements at most beside imports, none of which repeats or catches."""
    (rod,) = (node for node in ast.parse(code_of("rod.rod")).body if isinstance(node, ast.ClassDef))
    for method in (node for node in rod.body if isinstance(node, ast.FunctionDef)):
        statements = [node for node in method.body if not isinstance(node, ast.Expr | ast.ImportFrom)]
        assert len(statements) <= 3, method.name
        works = (ast.For, ast.While, ast.Try, ast.comprehension)
        assert not [node for node in ast.walk(method) if isinstance(node, works)], method.name


def test_type_checkers_know_every_public_name() -> None:
    listed = next(node for node in ast.parse(code_of("__init__")).body if isinstance(node, ast.If))
    named = {alias.asname for node in listed.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert named == set(floquetrod.__all__)
