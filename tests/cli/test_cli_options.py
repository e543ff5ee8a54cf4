"""The same words for the same options in every command of the terminal."""

from __future__ import annotations

import argparse
import re

import pytest

from floquetrod.cli.main import _parser, main

_COMMANDS = next(a for a in _parser()._actions if isinstance(a, argparse._SubParsersAction)).choices

# Options that mean something else in some commands, which their help says.
_OTHERWISE = {
    "--out", "--kick", "--friction", "--mu", "--exit-code", "--speed", "--depth", "--unit",
    "--system", "--growth-tolerance",  # of a family of systems, which have no seconds
}  # fmt: skip


def _options() -> dict[str, list[tuple[str, argparse.Action]]]:
    found: dict[str, list[tuple[str, argparse.Action]]] = {}
    for name, command in _COMMANDS.items():
        for action in command._actions:
            for option in action.option_strings:
                found.setdefault(option, []).append((name, action))
    return found


@pytest.mark.parametrize("option", sorted(_options()))
def test_an_option_has_the_same_words_in_every_command(option: str) -> None:
    uses = _options()[option]
    for _, action in uses:
        assert action.help
    if option in _OTHERWISE:
        return
    helps = {re.sub(r", or a range such as [^;]+|\s*\(default[^)]*\)", "", str(action.help)) for _, action in uses}
    assert len(helps) <= 1
    assert len({(action.metavar, action.type, str(action.choices)) for _, action in uses}) <= 1


@pytest.mark.parametrize(
    ("name", "ignored"),
    [("check", set()), ("certify", {"--second"}), ("simulate", {"--noise", "--second"})],
)
def test_a_command_has_no_option_for_what_it_would_ignore(
    name: str, ignored: set[str], capsys: pytest.CaptureFixture[str]
) -> None:
    options = {option for action in _COMMANDS[name]._actions for option in action.option_strings}
    assert {"--noise", "--second"} - options == ignored
    for option in ignored:
        point = ["--rod", "nitinol", "--mean", "0N", "--amplitude", "0N", "--frequency", "1Hz"]
        assert main([name, *point, option, "1"]) == 2
        assert f"unknown option {option}; floquetrod check has it" in capsys.readouterr().err


def test_no_two_options_of_a_command_say_the_same() -> None:
    for command in _COMMANDS.values():
        helps = [action.help for action in command._actions]
        assert len(set(helps)) == len(helps)


def test_quantities_say_what_they_are_in() -> None:
    for name in ("check", "certify", "ranges", "map", "simulate"):
        text = _COMMANDS[name].format_help()
        assert "forces       N, kN" in text
        assert "Fcr (the critical force of the rod), % (of that force)" in text


@pytest.mark.parametrize("name", sorted(_COMMANDS))
def test_help_shows_five_options_and_the_examples_and_help_all_everything(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    command = _COMMANDS[name]
    shown = {}
    for option in ("--help", "--help-all"):
        with pytest.raises(SystemExit) as stop:
            command.parse_args([option])
        assert stop.value.code == 0
        shown[option] = capsys.readouterr().out
    assert shown["--help-all"] == command.format_help()
    listed = re.findall(r"^  (?!floquetrod)(\S+)", shown["--help"].partition("\nexamples:")[0], re.MULTILINE)
    assert len(listed) == 2 + len(command.common) <= 2 + 5  # two of them --help and --help-all
    assert set(command.common) <= {action.dest for action in command._actions}
    examples = re.findall(r"^  floquetrod .*$", shown["--help-all"], re.MULTILINE)
    assert examples == re.findall(r"^  floquetrod .*$", shown["--help"], re.MULTILINE)
    assert shown["--help"].rstrip().endswith(f"floquetrod {name} --help-all")
