"""Errors carry the argument they are about, so that nobody has to read it from their message."""

from __future__ import annotations

import ast
import pickle
import re
from argparse import Namespace
from collections.abc import Callable
from pathlib import Path

import pytest

import floquetrod as fr
from floquetrod import cli
from floquetrod._util.arguments import Mention, Message, argument_of, error_in, text_with_names, wrong_type, wrong_value
from floquetrod.cli.messages import in_options


def test_an_error_knows_its_argument() -> None:
    error = wrong_value("modes[2]", "must be 1 or more, got 0")
    assert str(error) == "modes[2] must be 1 or more, got 0"
    assert argument_of(error) == ("modes", "2", "must be 1 or more, got 0", "")
    assert type(wrong_type("over['kick']", "must be a list")) is TypeError
    assert argument_of(pickle.loads(pickle.dumps(error))) == argument_of(error)
    assert argument_of(ValueError("modes must be 1 or more")) is None


def test_an_error_in_a_file_keeps_its_argument() -> None:
    error = error_in("study s", error_in("rod file r", wrong_value("length", "must be finite")))
    assert str(error) == "study s: rod file r: length must be finite"
    about = argument_of(error)
    assert about is not None
    assert about.named("--length") == "study s: rod file r: --length must be finite"
    assert argument_of(error_in("file", ValueError("no"))) is None


def test_errors_of_the_library_carry_their_arguments(tmp_path: Path) -> None:
    path = tmp_path / "rod.toml"
    path.write_text("youngs_modulus = 68e9\ndensity = -1\nradius = 1e-3\nlength = 3\nchannel_radius = 5e-3\n")
    with pytest.raises(ValueError, match="density") as caught:
        fr.Rod.from_toml(path)
    about = argument_of(caught.value)
    assert about is not None
    assert about[0::3] == ("density", f"rod file {path}")
    with pytest.raises(ValueError, match="needs independent modes") as caught:
        fr.Rod.nitinol().critical_kick(fr.AxialWave(0.3, 0.3, 150.0), friction=0.1)
    assert argument_of(caught.value) is not None


@pytest.mark.parametrize(
    ("call", "argument"),
    [
        (lambda: fr.Rod.nitinol().replace(inner_diameter=1.0), "inner_radius"),
        (lambda: fr.Rod.nitinol().replace(radius=1e-3, diameter=2e-3), "diameter"),
    ],
)
def test_errors_of_tubes_carry_their_arguments(call: Callable[[], object], argument: str) -> None:
    with pytest.raises(ValueError, match=f"^{argument} must") as caught:
        call()
    about = argument_of(caught.value)
    assert about is not None
    assert about.name == argument


def test_a_message_keeps_what_it_mentions() -> None:
    error = wrong_value("frequency", "resonates; give ", Mention("axial_damping"), ", or ", Mention("mean_at", "m=0"))
    assert str(error) == "frequency resonates; give axial_damping, or m=0"
    for known in (error, pickle.loads(pickle.dumps(error))):
        assert (
            text_with_names(known, lambda each: each.name.upper())
            == "frequency resonates; give AXIAL_DAMPING, or MEAN_AT"
        )
    inner = Message("a {brace} and ", Message("in it ", Mention("wave", "AxialWave")), "!")
    assert (inner, inner.with_names(lambda _: "--wave")) == (
        "a {brace} and in it AxialWave!",
        "a {brace} and in it --wave!",
    )
    assert text_with_names(ValueError("give AxialWave"), lambda _: "--wave") == "give AxialWave"


@pytest.mark.parametrize(
    ("error", "typed", "said"),
    [
        (
            wrong_value("growth_tolerance", "must be 0"),
            {"growth_tolerance": "1"},
            "--growth-tolerance must be 0; it was",
        ),
        (
            wrong_value("channel_radius", "is 1"),
            {"bore": "1mm"},
            "--bore, the channel radius, is 1; it was given as '1mm'",
        ),
        (wrong_value("channel_radius", "is 1"), {"bore": None}, "channel_radius is 1"),
        (wrong_value("modes[2]", "is 0; ", Mention("wave")), {"wave": None}, "modes[2] is 0; --wave"),
        (error_in("file", wrong_value("length", "is 0")), {"length": "1m"}, "file: length is 0"),
        (ValueError("use AxialWave, mean_at=None"), {"wave": None, "mean_at": None}, "use AxialWave, mean_at=None"),
    ],
)
def test_the_terminal_names_its_options(error: Exception, typed: dict[str, str], said: str) -> None:
    assert in_options(error, Namespace(**typed)).startswith(said)


_REWRITE = {"replace", "removeprefix", "removesuffix", "startswith", "endswith", "partition", "split", "translate"}


@pytest.mark.parametrize("path", sorted(Path(cli.__file__).parent.glob("*.py")), ids=lambda path: path.name)
def test_the_terminal_reads_nothing_from_messages(path: Path) -> None:
    """Neither regular expressions nor methods of strings are applied to what the library says."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
            continue
        owner = ast.unparse(node.func.value)
        subjects = [owner] if node.func.attr in _REWRITE and node.args else []  # split() at spaces makes one line
        if node.func.attr in {"match", "fullmatch", "search", "sub", "findall", "split", "finditer"}:
            subjects += [ast.unparse(each) for each in node.args]
        read = {name for text in subjects for name in re.findall(r"[a-z_]+", text)}
        assert not read & {"error", "message", "warning", "reason", "problem", "told"}, ast.unparse(node)
