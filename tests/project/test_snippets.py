"""What the README and the docstrings show is what happens."""

from __future__ import annotations

import contextlib
import doctest
import importlib
import inspect
import io
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from floquetrod import cli

ROOT = Path(__file__).parents[2]
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
PAGES = [
    "README.md",
    "CONTRIBUTING.md",
    "docs/architecture.md",
    "docs/start/first_ten_minutes.md",
    "benchmarks/README.md",
]
MODULES = [
    ".".join(part for part in path.relative_to(ROOT).with_suffix("").parts if part != "__init__")
    for path in sorted((ROOT / "floquetrod").rglob("*.py"))
    if path.name != "__main__.py" and ">>> " in path.read_text(encoding="utf-8")  # importing that runs the terminal
]
LONG = {
    "docs/start/first_ten_minutes.md",
    "floquetrod.explorer.explorer",
    "floquetrod.ensembles.ensemble",
    "floquetrod.milling.milling",
    "floquetrod.orbits.following",
    "floquetrod.rod.reach_probability",
    "floquetrod.rod.rod",
    "floquetrod.systems.energy_bands",
}
"""Whose examples take about a second and more."""


def quick(names: list[str]) -> list[Any]:
    """Return names as parameters, the long ones marked."""
    return [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in names]


def blocks(page: str, language: str) -> list[str]:
    """Return the fenced blocks of a page in one language."""
    return re.findall(
        rf"^```{language}\n(.*?)^```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )


@pytest.mark.parametrize("page", quick([page for page in PAGES if blocks(page, "python")]))
def test_python_snippets(page: str) -> None:
    examples = "\n".join(blocks(page, "python"))
    parsed = doctest.DocTestParser().get_doctest(examples, {}, page, page, 0)
    assert len(parsed.examples) >= len(blocks(page, "python")), (
        "write snippets as >>> examples, so that they are checked"
    )
    runner = doctest.DocTestRunner(optionflags=FLAGS)
    report: list[str] = []
    runner.run(parsed, out=report.append)
    assert runner.summarize(verbose=False).failed == 0, "".join(report)


def in_a_process(arguments: list[str], folder: Path) -> str:
    """Return what a command prints in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "floquetrod", *arguments],
        capture_output=True,
        text=True,
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    ).stdout


def in_this_process(arguments: list[str], folder: Path) -> str:
    """Return what a command prints."""
    with contextlib.chdir(folder), contextlib.redirect_stdout(io.StringIO()) as said:
        cli.main(arguments)
    return said.getvalue()


def require_as_shown(block: str, folder: Path, run: Callable[[list[str], Path], str]) -> None:
    """Run the command of a console block in a folder and compare; a last line "..." stands for any rest."""
    command, _, shown = block.replace("\\\n", " ").partition("\n")
    prompt, program, *arguments = shlex.split(command)
    assert (prompt, program) == ("$", "floquetrod")
    beginning, rest, _ = shown.strip().partition("\n...")
    came = run(arguments, folder).strip()
    assert (came[: len(beginning)] if rest else came).strip() == beginning.strip()


@pytest.mark.parametrize(
    ("page", "run"),
    [
        ("README.md", in_a_process),
        pytest.param("docs/start/first_ten_minutes.md", in_this_process, marks=pytest.mark.slow),
    ],
)
def test_terminal_snippets(page: str, run: Callable[[list[str], Path], str], tmp_path: Path) -> None:
    (rod,) = blocks(page, "toml")
    (tmp_path / "my_rod.toml").write_text(rod, encoding="utf-8")
    texts = blocks(page, "console")
    assert texts
    for text in texts:
        require_as_shown(text, tmp_path, run)


def test_what_the_front_door_points_to_is_there() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    local = [target for target in re.findall(r"\]\(([^)#]+)\)", text) if "://" not in target]
    assert "docs/picture.png" in local
    assert [target for target in local if not (ROOT / target).exists()] == []
    assert (ROOT / "docs/picture.png").stat().st_size < 100_000


@pytest.mark.parametrize("module", quick(MODULES))
def test_docstring_examples(module: str) -> None:
    report: list[str] = []
    loaded = importlib.import_module(module)
    tests = doctest.DocTestFinder().find(loaded)
    assert sum(len(test.examples) for test in tests) == inspect.getsource(loaded).count(">>> ")
    runner = doctest.DocTestRunner(optionflags=FLAGS)
    for test in tests:
        runner.run(test, out=report.append)
    assert runner.summarize(verbose=False).failed == 0, "".join(report)
