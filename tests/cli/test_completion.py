"""Completion in a shell: the scripts of --print-completion, tried in the shells themselves."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from floquetrod import cli
from floquetrod.cli.completion import SHELLS


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a script for bash, and files to complete."""
    pytest.importorskip("shtab")
    folder = tmp_path_factory.mktemp("completion")
    for name in ("my_rod.toml", "notes.txt", "record.csv"):
        (folder / name).touch()
    (folder / "rods").mkdir()
    return folder


def printed(shell: str, capsys: pytest.CaptureFixture[str]) -> str:
    """Return the script for a shell."""
    with pytest.raises(SystemExit) as stop:
        cli.main(["--print-completion", shell])
    assert stop.value.code == 0
    return capsys.readouterr().out


@pytest.mark.parametrize(
    ("line", "there", "absent"),
    [
        (["ch"], {"check"}, {"certify"}),
        (["check", "--fre"], {"--frequency"}, {"--mean"}),
        (["certify", "--lar"], {"--largest"}, set()),
        (["check", "--wave", ""], {"held", "free", "driven"}, {"sine"}),
        (["compare", "--waveform", "s"], {"sine", "square"}, {"held"}),
        (["check", "--rod", ""], {"nitinol", "my_rod.toml", "rods"}, {"notes.txt", "record.csv"}),
        (["check", "--rod", "my"], {"my_rod.toml"}, {"nitinol"}),
        (["check", "--rod", "nitinol", "--force", "re"], {"record.csv"}, {"notes.txt"}),
        (["map", "--rod", "nitinol", "--out", "no"], {"notes.txt"}, set()),
        (["ensemble", "my"], {"my_rod.toml"}, set()),
        (["example", "w"], {"well.toml", "wire.toml"}, {"notes.txt"}),
        (["example", "wire.toml", "--out", ""], {"rods"}, {"notes.txt"}),
        (["--print-completion", "z"], {"zsh"}, {"bash"}),
    ],
)
@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_bash_completes(
    line: list[str], there: set[str], absent: set[str], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    script = folder / "completion.bash"
    if not script.exists():
        script.write_text(printed("bash", capsys), encoding="utf-8")
    words = ["floquetrod", *line]
    ask = (
        'source completion.bash; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMP_LINE="$*"; COMP_POINT=${#COMP_LINE}; '
        'call=$(complete -p floquetrod | sed "s/.*-F \\([^ ]*\\).*/\\1/"); '
        '"$call" floquetrod "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD-1]}"; printf "%s\\n" "${COMPREPLY[@]}"'
    )
    run = subprocess.run(["bash", "-c", ask, "bash", *words], capture_output=True, text=True, cwd=folder, check=True)
    found = set(run.stdout.split())
    assert there <= found, run.stderr
    assert not absent & found


@pytest.mark.parametrize("shell", [shell for shell in SHELLS if shutil.which(shell)])
def test_shells_read_their_script(shell: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    script = folder / f"read.{shell}"
    script.write_text(printed(shell, capsys), encoding="utf-8")
    run = subprocess.run([shell, "-n", str(script)], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")


def test_without_the_extra_the_remedy_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert cli.main(["--print-completion", "bash"]) == 2
    assert "--print-completion bash needs shtab: install it with pip install 'flo" in capsys.readouterr().err
