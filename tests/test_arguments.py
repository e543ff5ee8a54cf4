"""Errors carry the argument they are about, so that nobody has to read it from their message."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

import floquetrod as fr
from floquetrod._util.arguments import argument_of, located, wrong_type, wrong_value


def test_an_error_knows_its_argument() -> None:
    error = wrong_value("modes[2]", "must be 1 or more, got 0")
    assert str(error) == "modes[2] must be 1 or more, got 0"
    assert argument_of(error) == ("modes", "2", "must be 1 or more, got 0", "")
    assert type(wrong_type("over['kick']", "must be a list")) is TypeError
    assert argument_of(pickle.loads(pickle.dumps(error))) == argument_of(error)
    assert argument_of(ValueError("modes must be 1 or more")) is None


def test_an_error_in_a_file_keeps_its_argument() -> None:
    error = located("study s", located("rod file r", wrong_value("length", "must be finite")))
    assert str(error) == "study s: rod file r: length must be finite"
    about = argument_of(error)
    assert about is not None
    assert about.named("--length") == "study s: rod file r: --length must be finite"
    assert argument_of(located("file", ValueError("no"))) is None


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
