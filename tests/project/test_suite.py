"""The suite itself: folders as in the package, files that say what they guard."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
PACKAGE = TESTS.parent / "floquetrod"
FILES = sorted(TESTS.rglob("test_*.py"))
BESIDE = {"agreement", "corpus", "data", "fuzz", "project", "public", "studies"}
"""Folders of the suite for which the package has none."""


def guards(source: str) -> str:
    """Return the line with which a test file says what it guards, "" where it does not."""
    line = (ast.get_docstring(ast.parse(source)) or "").partition("\n")[0]
    says_it = line.endswith(".") and len(line.split()) >= 4
    return line if says_it and source.startswith(f'"""{line}') else ""


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(TESTS).as_posix())
def test_each_file_opens_with_what_it_guards(path: Path) -> None:
    assert guards(path.read_text(encoding="utf-8"))


@pytest.mark.slow
def test_no_two_files_guard_the_same() -> None:
    lines = [guards(path.read_text(encoding="utf-8")) for path in FILES]
    assert sorted(set(lines)) == sorted(lines)


@pytest.mark.parametrize("source", ["", "import os", '"""Tests."""', '"""\nWhat an arc is and does.\n"""', "x = 1"])
def test_a_file_that_does_not_say_it_is_seen(source: str) -> None:
    assert guards(source) == ""


def test_folders_are_those_of_the_package() -> None:
    folders = {path.parent.relative_to(TESTS).as_posix() for path in TESTS.rglob("*.py")} - {"."}
    own = {folder for folder in folders if folder.split("/")[0] not in BESIDE}
    assert {folder for folder in own if not (PACKAGE / folder).is_dir()} == set()
    assert all((TESTS / folder / "__init__.py").exists() for folder in folders - {"data"})


def test_no_test_lies_beside_the_folders() -> None:
    assert [path.name for path in FILES if path.parent == TESTS] == []
