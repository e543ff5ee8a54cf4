"""A study file read in Python: the same values as in the terminal, and warnings and errors that name file and table."""

from __future__ import annotations

import inspect
import warnings
from pathlib import Path

import pytest

import floquetrod as fr

STUDY = """rod = "nitinol"
[load]
mean = "0.3Fcr"
amplitude = "0.2Fcr"
frequency = {}
[run]
duration = "1ms"
segments = 40
frames = 2
[over]
{}
"""


def _written(folder: Path, own: str, over: str) -> Path:
    path = folder / "study.toml"
    path.write_text(STUDY.format(own, over), encoding="utf-8")
    return path


def test_a_study_runs_as_the_ensemble_that_it_describes(tmp_path: Path) -> None:
    study = fr.Study.from_toml(_written(tmp_path, '"24Hz"', 'kick = ["1mm/s", "2mm/s"]'))
    assert study.units["kick"].name == "mm/s"
    found, same = study.run(), fr.ensemble(study.problem, {"kick": [1e-3, 2e-3]})
    assert (found["largest_angle"] == same["largest_angle"]).all()
    with pytest.raises(ValueError, match=rf"^study file {study.path}: \[ensemble\] samples is for distributions"):
        fr.Study(study.problem, study.over, {"samples": 3}, study.units, study.path).run()
    with pytest.raises(ValueError, match=r"^samples is for distributions"):  # not the file's
        study.run(samples=3)


def test_a_study_takes_every_option_of_an_ensemble_by_name() -> None:
    own, theirs = (inspect.signature(function).parameters for function in (fr.Study.run, fr.ensemble))
    assert list(own)[1:] == list(theirs)[2:]
    assert {option.kind for option in list(own.values())[1:]} == {inspect.Parameter.KEYWORD_ONLY}


@pytest.mark.parametrize(
    ("own", "over", "typed"),
    [
        ("16", "seed = [1, 2]", "16"),
        ('"16Hz"', 'frequency = ["30Hz", 152, 16]', "16"),
        ('"16Hz"', 'frequency = {from = 15, to = "16rad/s", steps = 16}', "15"),
        ('"16Hz"', 'frequency = {distribution = "uniform", low = 16, high = 152}', "16"),
        ("24", 'mean = ["0.3Fcr", "0.5Fcr"]', "24"),  # at the second mean alone
        ("24", "seed = [1, 2]", None),
        ("16", 'frequency = ["16rad/s", "16Hz", 152]', None),  # the own one is not used
    ],
)
def test_a_bare_frequency_is_suspected(own: str, over: str, typed: str | None, tmp_path: Path) -> None:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", fr.PlausibilityWarning)
        fr.Study.from_toml(_written(tmp_path, own, over))
    texts = [str(each.message) for each in told]
    assert [text.partition("frequency ")[2].split()[0] for text in texts] == [typed] * (typed is not None)
    assert all("is taken in rad/s: at " in text and f"write {typed}rad/s or {typed}Hz" in text for text in texts)
    assert all(each.filename == __file__ for each in told)


@pytest.mark.parametrize("key", ["noise", "second"])
def test_a_load_has_no_key_for_what_a_simulation_would_ignore(key: str, tmp_path: Path) -> None:
    path = _written(tmp_path, f'"24Hz"\n{key} = "1"', "seed = [1, 2]")
    with pytest.raises(ValueError, match=rf"\[load\] unknown key '{key}'"):
        fr.Study.from_toml(path)
