"""The reference: every public name is in its index, says what it returns and raises, and names pages that exist."""

from __future__ import annotations

import ast
import importlib
import inspect
import pkgutil
import re
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import floquetrod as fr
from tests.fuzz import calls

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
CHECK = re.compile(
    r"validate\.(?!short|iterable|progress|workers|shaped)\w+|units\.(array|number|quantity|single|tolerance|unit)"
)
DRAWN_INTO = {"ax", "figure", "progress"}  # objects of others, and what is called back


def extension(name: str) -> Any:
    """Return a module of the site."""
    sys.path.insert(0, str(DOCS))
    try:
        return importlib.import_module(name)
    finally:
        sys.path.remove(str(DOCS))


@pytest.fixture(scope="module")
def documented() -> list[Any]:
    """Return what the pages of the reference document."""
    return list(extension("name_index").documented())


def function_of(thing: Any) -> Any:
    """Return the function behind a method, a class method or what a decorator makes of one."""
    unwrapped = inspect.unwrap(thing)
    return getattr(unwrapped, "__func__", unwrapped)


def sections(thing: Any) -> set[str]:
    """Return the headings of a docstring."""
    return set(re.findall(r"^([A-Z]\w+)\n-+$", inspect.getdoc(thing) or "", re.MULTILINE))


def called_by_people() -> Iterator[tuple[str, Any]]:
    """Yield the public callables that the attack by junk calls, which refuse what they cannot answer."""
    for name in sorted(calls.public() - calls.LEFT_OUT.keys()):
        owners = [owner for owner in (fr, fr.results) if hasattr(owner, name.split(".")[0])]
        yield name, pkgutil.resolve_name(f"{owners[0].__name__}:{name}")


def refuses(function: Any) -> bool:
    """Return whether the code of a function itself refuses an argument, or has one checked."""
    body = list(ast.walk(ast.parse(textwrap.dedent(inspect.getsource(function)))))
    raised = [ast.unparse(node.exc) for node in body if isinstance(node, ast.Raise) and node.exc]
    checks = [ast.unparse(node.func) for node in body if isinstance(node, ast.Call)]
    refused = any(re.match(r"(TypeError|ValueError|validate\.wrong_\w+)\(", text) for text in raised)
    return refused or any(CHECK.fullmatch(text) for text in checks)


def test_every_public_name_is_in_the_index(documented: list[Any]) -> None:
    names = [entry.name for entry in documented]
    assert len(names) == len(set(names))
    short = {name.rpartition(".")[2] for name in names}
    modules = {name for name in fr.__all__ if inspect.ismodule(getattr(fr, name))}
    assert {*fr.__all__, *fr.results.__all__} - short - modules == {"SquareWave", "__version__"}
    text = (DOCS / "reference/index.rst").read_text(encoding="utf-8")
    assert [name for name in modules if f"``fr.{name}``" not in text] == []


def test_every_summary_is_one_sentence(documented: list[Any]) -> None:
    summary = extension("name_index").summary
    said = {entry.name: summary(inspect.getdoc(entry.thing) or "") for entry in documented}
    assert {name: text for name, text in said.items() if not re.match(r"[A-Z].*[.?]$", text)} == {}
    assert max(map(len, said.values())) <= 120


def test_every_function_says_what_it_returns(documented: list[Any]) -> None:
    """All that the reference documents, but what returns nothing."""
    lacking = []
    for entry in documented:
        function = function_of(entry.thing)
        if entry.kind != "class" and inspect.signature(function).return_annotation not in (None, "None"):
            lacking += [] if {"Returns", "Yields"} & sections(function) else [entry.name]
    assert lacking == []


@pytest.mark.slow
def test_what_refuses_arguments_says_what_it_raises(documented: list[Any]) -> None:
    """What the attack by junk calls with more than axes, and what has a statement that raises or checks."""
    lacking = []
    for name, thing in called_by_people():
        parameters = inspect.signature(thing).parameters.keys() - {"self", "cls"}
        lacking += [name] if parameters - DRAWN_INTO and "Raises" not in sections(function_of(thing)) else []
    for entry in documented:
        function = function_of(entry.thing)
        if entry.kind != "class" and refuses(function) and "Raises" not in sections(function):
            lacking.append(entry.name)
    assert lacking == []


def test_pages_named_in_docstrings_exist() -> None:
    named = set()
    for path in sorted((ROOT / "floquetrod").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        named |= set(re.findall(r"(?<!`)`((?:how_to|reference|start|theory)/\w+)`", text))
    assert [page for page in named if not any((DOCS / f"{page}.{kind}").is_file() for kind in ("md", "rst"))] == []
    assert len(named) > 10


@pytest.mark.slow
def test_every_name_of_the_index_leads_to_its_source(documented: list[Any]) -> None:
    written = extension("source_pages").written
    for entry in documented:
        place = written(entry.name)
        path = Path(str(sys.modules[place.module].__file__))
        near = path.read_text(encoding="utf-8").splitlines()[place.line - 1 :][:20]
        word = place.name.rpartition(".")[2]
        assert any(re.match(rf"\s*(def|class) {word}\b", line) for line in near), entry.name
    assert written("floquetrod.Rod.nitinol").name == "RodData.nitinol"
    assert written("floquetrod.Rod.length") is None


def test_short_names_in_docstrings_are_links(documented: list[Any]) -> None:
    links = extension("links")
    names = [entry.name for entry in documented]
    meant = {
        "stability": "floquetrod.stability",
        "fr.response": "floquetrod.response",
        "MathieuAQ": "floquetrod.equations.MathieuAQ",
        "RodStability.margin": "floquetrod.results.RodStability.margin",
        "as_dict": None,
        "nothing": None,
    }
    assert {short: links.chosen(short, names) for short in meant} == meant
    assert links.linked("(page `theory/ranges`)") == "(page :doc:`/theory/ranges`)"
    assert links.linked("``theory/ranges``, `Rod`") == "``theory/ranges``, `Rod`"
