"""`floquetrod example`, and that every command of help texts and pages works with the files it writes."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest

import floquetrod as fr
from floquetrod import cli
from floquetrod._util.example_files import commands, content, names, summary
from floquetrod.cli.main import _parser
from tests.cli.test_cli_options import _COMMANDS
from tests.project.test_docs import WRITTEN

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *WRITTEN]
LINE = rf"^(?:    |  )?(?:\$ )?(floquetrod (?:{'|'.join(_COMMANDS)})\b(?:.*\\\n)*.*)$"
NAMED = re.compile(r"[\w./-]+\.(?:toml|csv|npz)")
WRITES = ("--out", "--store", "--checkpoint")


def shown(text: str) -> list[str]:
    """Return the commands that a text shows, each on one line."""
    return [re.sub(r"\\\n\s*", " ", line) for line in re.findall(LINE, text, re.MULTILINE)]


def files_of(line: str) -> tuple[set[str], set[str]]:
    """Return the files that a command reads, and those it writes."""
    words = shlex.split(line)
    if words[1] == "example":
        return set(), {word for word in words if NAMED.fullmatch(word)}
    named = {i: word for i, word in enumerate(words) if NAMED.fullmatch(word)}
    written = {word for i, word in named.items() if words[i - 1] in WRITES}
    return set(named.values()) - written, written


HELP = {name: shown(command.epilog or "") for name, command in _COMMANDS.items() if shown(command.epilog or "")}
ON_PAGES = {
    path.relative_to(ROOT).as_posix(): lines for path in PAGES if (lines := shown(path.read_text(encoding="utf-8")))
}


def said(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert cli.main(["example", *words]) == 0
    return capsys.readouterr().out


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert cli.main(list(words)) == 2
    return capsys.readouterr().err


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


# --- the command ---


def test_without_a_name_each_file_has_a_line(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    lines = said(capsys).splitlines()
    assert [line.split()[0] for line in lines[:-2]] == names()
    assert all(len(line) <= 130 for line in lines)
    assert "floquetrod example NAME" in lines[-1]
    assert json.loads(said(capsys, "--json"))["examples"] == {name: summary(name) for name in names()}
    assert not list(tmp_path.iterdir())


def test_files_are_written_with_the_commands_that_read_them(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert said(capsys, "survey.csv").splitlines() == [
        "written: survey.csv",
        "",
        "try:",
        "  floquetrod example tubing.toml",
        *(f"  {line}" for line in commands("survey.csv")),
    ]
    assert (tmp_path / "survey.csv").read_text(encoding="utf-8") == content("survey.csv")
    there = said(capsys, "tubing.toml", "--out", "a/b")
    assert "written: a/b/tubing.toml" in there
    assert "try, in the folder a/b:" in there
    record = json.loads(said(capsys, "--all", "--out", "all", "--json"))
    assert record["written"] == [str(Path("all", name)) for name in names()]
    assert not [line for line in record["commands"] if line.startswith("floquetrod example")]


def test_a_file_is_replaced_on_request_only_and_all_are_written_or_none(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "wire.toml").write_text("mine", encoding="utf-8")
    error = refused(capsys, "example", "my_rod.toml", "wire.toml")
    assert "wire.toml is there already, and nothing was written; --overwrite replaces it, --out FOLDER" in error
    assert [path.name for path in tmp_path.iterdir()] == ["wire.toml"]
    assert (tmp_path / "wire.toml").read_text(encoding="utf-8") == "mine"
    said(capsys, "my_rod.toml", "wire.toml", "--overwrite")
    assert (tmp_path / "wire.toml").read_text(encoding="utf-8") == content("wire.toml")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("wire", "NAME must be one of family.toml, my_rod.toml, record.csv,"),
        ("wire", "got 'wire'; did you mean wire.toml?"),
        ("wire.toml --force", "unknown option --force; did you mean --overwrite?"),
        ("--out folder", "--out needs the name of a file, such as family.toml, or --all"),
        ("--overwrite", "--overwrite needs the name of a file"),
        ("wire.toml --all", "--all writes every file, got wire.toml beside it"),
        ("wire.toml --out file", "--out must be a folder, and 'file' is a file"),
    ],
)
def test_mistakes_teach(words: str, expected: str, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert expected in refused(capsys, "example", *words.split())
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_where_a_file_is_missing_the_command_that_writes_it_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    load = ["--mean", "1N", "--amplitude", "1N", "--frequency", "1Hz"]
    for name, words in {
        "my_rod.toml": ["check", "--rod", "my_rod.toml", *load],
        "record.csv": ["check", "--rod", "nitinol", "--force", "record.csv"],
        "system.toml": ["check", "--system", "system.toml"],
        "survey.csv": ["reach", "--rod", "nitinol", "--well", "survey.csv", "--friction", "0.3"],
        "study.toml": ["ensemble", "study.toml"],
        "tool.toml": ["lobes", "tool.toml"],
    }.items():
        assert f"there is no such file; floquetrod example {name} writes an example" in refused(capsys, *words)
    with pytest.raises(ValueError, match=r"there is no such file; floquetrod example wire.toml writes an example"):
        fr.Rod.from_toml("wire.toml")


# --- what help texts and pages show ---


def test_the_rod_of_the_pages_is_the_file() -> None:
    for page in ("README.md", "docs/start/first_ten_minutes.md"):
        (sheet,) = re.findall(
            r"^```toml\n(.*?)^```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
        )
        Path("sheet.toml").write_text(sheet, encoding="utf-8")
        Path("file.toml").write_text(content("my_rod.toml"), encoding="utf-8")
        assert fr.Rod.from_toml("sheet.toml") == fr.Rod.from_toml("file.toml")


@pytest.mark.parametrize("name", HELP)
def test_a_help_text_writes_the_files_it_reads(name: str) -> None:
    there: set[str] = set()
    for line in HELP[name]:
        read, written = files_of(line)
        assert read <= there, line
        there |= written


@pytest.mark.parametrize("page", ON_PAGES)
def test_a_page_reads_files_that_it_writes_or_that_are_examples(page: str) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    there = set(names()) | set(re.findall(r'"([\w.]+)"', text))
    for line in ON_PAGES[page]:
        read, written = files_of(line)
        assert read <= there, line
        there |= written


TEXTS = HELP | {page: [line for line in lines if files_of(line)[0] <= set(names())] for page, lines in ON_PAGES.items()}
"""Commands of help texts, and those of pages that read examples alone."""


@pytest.mark.parametrize("where", TEXTS)
def test_every_command_shown_is_understood(where: str) -> None:
    parser = _parser()
    for line in TEXTS[where]:
        assert parser.parse_args(shlex.split(line)[1:]).command in _COMMANDS


SMALLER = {
    "map": ["--points", "12x9"],
    "chart": ["--points", "12x9"],
    "lobes": ["--points", "12x9"],
    "simulate": ["--duration", "5ms"],
}
"""Options that make a command quick; the last one given counts."""


def with_fewer_runs(study: str) -> str:
    """Return the study that is an example with 4 of its 80 runs: several commands make the same ones."""
    for whole, part in (("steps = 4", "steps = 2"), ("to = 20 }", "to = 2 }")):
        assert study.count(whole) == 1
        study = study.replace(whole, part)
    return study


QUICK = {"catalogue", "example", "lock-up"}
"""Texts whose commands take no half second."""


@pytest.mark.parametrize(
    "where", [pytest.param(name, marks=[pytest.mark.slow] * (name not in QUICK)) for name in TEXTS]
)
def test_every_command_shown_works(where: str, capsys: pytest.CaptureFixture[str]) -> None:
    if where in ON_PAGES:
        said(capsys, "--all")
    for line in TEXTS[where]:
        words = shlex.split(line)[1:]
        if "--web" in words:  # serves until it is stopped
            continue
        if words[0] == "explore" and "--out" not in words:
            words += ["--out", "explorer.png"]
        if words[0] == "example" and len(words) > 1 and "--overwrite" not in words:
            words += ["--overwrite"]
        status = cli.main([*words, *SMALLER.get(words[0], [])])
        if words[0] == "example" and "study.toml" in words:
            Path("study.toml").write_text(with_fewer_runs(content("study.toml")), encoding="utf-8")
        assert status == 0 or "--exit-code" in words, (line, capsys.readouterr().err)
