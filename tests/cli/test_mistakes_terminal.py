"""Mistakes that people make in the terminal: each is answered in one line that names argument, value and remedy."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from floquetrod import cli

ROD = 'youngs_modulus = "68GPa"\ndensity = 6500\nradius = "0.8mm"\nlength = 3.1\nchannel_radius = "4.7mm"\n'
STUDY = """\
rod = "nitinol"
[load]
mean = "0.4Fcr"
amplitude = "20%"
frequency = "24Hz"
[run]
duration = "20ms"
[over]
kick = ["20mm/s"]
"""
FILES = {
    "my_rod.toml": ROD,
    "broken.toml": ROD + 'gravity = "9.81\n',
    "negative.toml": ROD.replace("3.1", "-3.1"),
    "typed.toml": ROD.replace("density", "desity"),
    "inches.toml": ROD.replace('"0.8mm"', '"0.8 inchs"'),
    "swapped.toml": ROD.replace('"0.8mm"', '"4.8mm"'),
    "study.toml": STUDY,
    "percent.toml": STUDY.replace('"24Hz"', '"24%"'),
    "misspelt.toml": STUDY.replace("duration", "duraton"),
    "wave.toml": STUDY.replace("[run]", 'wave = "fixed"\n[run]'),
    "pipe.toml": STUDY.replace("nitinol", "2.00x0.156 CT90"),
    "words.csv": "time force\n",
    "record.csv": "\n".join(f"{t:.4f},{np.sin(150.0 * t):.6f}" for t in np.arange(0.0, 0.5, 1e-3)),
}
LOAD = "--mean 0.2Fcr --amplitude 0.2Fcr --frequency 24Hz"
CHECK = f"check --rod nitinol {LOAD}"
RANGES = "ranges --rod nitinol --mean 0.2Fcr --amplitude 0.2Fcr"
MAP = "map --rod nitinol --mean 0:1Fcr --amplitude 0.2Fcr --frequency 5Hz:30Hz"
SIMULATE = f"simulate --rod nitinol {LOAD} --duration 10ms"

# The line that was typed; the argument, the value and the remedy of which the answer must hold words.
MISTAKES = [
    # units and numbers
    (f"{CHECK} --mean 0,2Fcr", "--mean", "'0,2Fcr'", "write a point"),
    (f"{CHECK} --mean 1,200N", "--mean", "'1,200N'", "nothing between thousands"),
    (f"{CHECK} --frequency 24 Hz", "--frequency", "'Hz'", "needs quotes, as in --frequency '24 Hz'"),
    (f"{CHECK} --frequency 24herz", "--frequency", "'24herz'", "did you mean"),
    (f"{CHECK} --frequency 24N", "--frequency", "'24N'", "it is a unit of force"),
    (f"{CHECK} --frequency 5%", "--frequency", "'5%'", "needs something it is a part of"),
    (f"{CHECK} --mean 24Hz", "--mean", "'24Hz'", "it is a unit of frequency"),
    (f"{CHECK} --mean 2Fkr", "--mean", "'2Fkr'", "did you mean Fcr?"),
    (f"{CHECK} --mean", "--mean", "--mean", "needs a value"),
    (f"{CHECK} --mean=", "--mean", "''", "must be a number with a force unit"),
    (f"{CHECK} --amplitude=-0.2Fcr", "--amplitude", "-0.2Fcr", "must be zero or more"),
    (f"{CHECK} --frequency 0", "--frequency", "'0'", "must be greater than zero"),
    (f"{CHECK} --frequency 24e9Hz", "--frequency", "'24e9Hz'", "check the units"),
    (f"{CHECK} --damping-rate 1Hz", "--damping-rate", "'1Hz'", "1/s"),
    (f"{CHECK} --unit herz", "--unit", "'herz'", "did you mean Hz?"),
    (f"{CHECK} --unit Hz,rpm", "--unit", "'Hz,rpm'", "one unit of frequency"),
    # options and commands
    (CHECK.replace("check", "chek"), "command", "'chek'", "did you mean check?"),
    ("", "command", "command", "such as floquetrod check"),
    (CHECK.replace("--frequency", "--freqency"), "--freqency", "--freqency", "did you mean --frequency?"),
    (f"{CHECK} --growth_tolerance 1", "option", "--growth_tolerance", "did you mean --growth-tolerance?"),
    (f"{CHECK} -mean 1", "option", "-mean", "did you mean --mean?"),
    (f"{CHECK} \N{EN DASH}kick 1mm/s", "option", "\N{EN DASH}kick", "did you mean --kick?"),
    (f"{CHECK} frequency=24Hz", "option", "'frequency=24Hz'", "did you mean --frequency=24Hz?"),
    (f"{CHECK} --largest", "option", "--largest", "floquetrod certify has it"),
    ("check --a 1.2 --q 0.9", "option", "--a", "a verdict on Mathieu's equation is floquetrod compare --a 1.2 --q 0.9"),
    ("report --q 0.9 --a 1.2 --out a.html", "option", "--q", "floquetrod compare --a 1.2 --q 0.9"),
    ("check --beta=-0.25 --alpha 0.5", "option", "--beta", "floquetrod compare --alpha 0.5 --beta -0.25"),
    (f"{CHECK} --f 0.1", "option", "--f", "or --friction?"),
    (
        "reach --well survey.csv --rod nitinol --friction 0.3 --figure reach.png",
        "option",
        "--figure",
        "did you mean --out?",
    ),
    (f"{MAP} --output map.png", "option", "--output", "did you mean --out?"),
    (f"check {LOAD}", "--rod", "--rod", "is required"),
    ("check --rod nitinol --mean 1N", "--amplitude", "--frequency", "are required"),
    (f"{CHECK} --wave fix", "--wave", "'fix'", "held, free, driven"),
    (f"{CHECK} --axial-damping 1", "--axial-damping", "'1'", "needs --wave"),
    (f"{CHECK} --friction 0.1", "--friction", "0.1", "such as --kick 50mm/s"),
    (f"{CHECK} --kick 5mm/s", "--kick", "'5mm/s'", "needs --friction"),
    (f"{CHECK} --friction 0,1 --kick 5mm/s", "--friction", "'0,1'", "write a point"),
    (f"{CHECK} --friction=-0.1 --kick 5mm/s", "--friction", "-0.1", "must be zero or more"),
    (f"{CHECK} --modes 0", "--modes", "'0'", "must count upwards between 1 and"),
    (f"{CHECK} --modes first", "--modes", "'first'", "must be like 1-25 or 6,7,8"),
    (f"{CHECK} --mean-at middle", "--mean-at", "'middle'", "a fraction of the length from 0"),
    (f"{CHECK} --method monodromy", "--method", "'monodromy'", "belongs to --system"),
    # rods and files
    (CHECK.replace("nitinol", "nitinal"), "--rod", "'nitinal'", "did you mean nitinol?"),
    (CHECK.replace("nitinol", "my_rod.tml"), "--rod", "'my_rod.tml'", "did you mean my_rod.toml?"),
    (CHECK.replace("nitinol", "rods/my_rod.toml"), "--rod", "'rods/my_rod.toml'", "there is no folder 'rods'"),
    (CHECK.replace("nitinol", "folder"), "--rod", "'folder'", "name a file in it"),
    (CHECK.replace("nitinol", "broken.toml"), "--rod", "broken.toml", "at line 6"),
    (CHECK.replace("nitinol", "negative.toml"), "length", "-3.1", "greater than zero"),
    (CHECK.replace("nitinol", "typed.toml"), "--rod", "'desity'", "did you mean density?"),
    (CHECK.replace("nitinol", "inches.toml"), "radius", "'0.8 inchs'", "did you mean"),
    (CHECK.replace("nitinol", "swapped.toml"), "channel_radius", "0.0047", "half of channel_diameter"),
    (CHECK.replace("nitinol", "'2.00x0.156 CT90'"), "--rod", "'2.00x0.156 CT90'", "needs --bore and --length"),
    (CHECK.replace("nitinol", "2.375x0.2"), "--rod", "'2.375x0.2'", "a pipe needs --bore and --length, too"),
    (
        CHECK.replace("nitinol", "2.375x0.2 --bore 4in"),
        "--rod",
        "2.375x0.190",
        "diameter and wall_thickness into a rod file",
    ),
    (
        CHECK.replace("nitinol", "'2.00x0.156 CT9' --bore 4in --length 9m"),
        "--rod",
        "'2.00x0.156 CT9'",
        "such as '2.00x0.156 CT90'",
    ),
    (
        CHECK.replace("nitinol", "2.1x0.156 --bore 4in --length 9m"),
        "--rod",
        "'2.1x0.156'",
        "the closest are 2.00",
    ),
    (CHECK.replace("nitinol", "2.00x0.156 --bore 1in --length 9m"), "--bore", "0.0254", "inner diameter of the hole"),
    (f"{CHECK} --force recrd.csv", "--force", "'recrd.csv'", "did you mean record.csv?"),
    (f"{CHECK} --force words.csv", "--force", "words.csv", "columns of time and force"),
    ("check --system sytem.toml", "--system", "'sytem.toml'", "there is no such file"),
    ("check --system my_rod.toml", "--system", "my_rod.toml", "no table [system]"),
    ("check --system my_rod.toml --frequency 3", "--frequency", "'3'", "belongs to --rod"),
    (f"{CHECK} --out shape.doc", "--out", "'shape.doc'", "must end in .png"),
    # ranges, maps, proofs
    (f"{RANGES} --frequency 24Hz", "--frequency", "got one value for each", "a range such as"),
    (f"{RANGES} --frequency 9Hz:24Hz --mean 0:1N", "--frequency", "ranges for --mean and --frequency", "exactly"),
    (f"{MAP} --frequency 24Hz", "--frequency", "got ranges for --mean", "two of"),
    (f"{CHECK} --mean 4:8N", "--mean", "'4:8N'", "floquetrod ranges takes a range of one quantity, map and certify"),
    (f"{SIMULATE} --frequency 4:8Hz", "--frequency", "'4:8Hz'", "map and certify take ranges of two"),
    (f"{RANGES} --mean 0:1N --frequency 4:8Hz", "--mean", "--mean and --frequency", "floquetrod map draws"),
    (f"{RANGES} --frequency 4Hz", "--frequency", "one value for each", "floquetrod check answers about one load"),
    ("check --rod nitinol --force missing.csv --modes 3-x", "--modes", "'3-x'", "1-25 or 6,7,8"),
    (f"{CHECK} --inclination 170deg", "--inclination", "2.96", "at most pi/2"),
    (f"{CHECK} --inclination steep", "--inclination", "'steep'", "deg"),
    (f"{CHECK} --force-unit kN", "--force-unit", "'kN'", "needs --force"),
    (f"{CHECK} --force-frequency 24Hz", "--force-frequency", "'24Hz'", "needs --force"),
    (f"{CHECK} --force record.csv --force-frequency 24Hs", "--force-frequency", "'24Hs'", "rad/s"),
    (f"{CHECK} --force record.csv --force-frequency 1e-3Hz", "--force-frequency", "0.0", "record longer"),
    (f"{CHECK} --force record.csv --force-column push", "--force-column", "'push'", "must be the number of a column"),
    (f"{CHECK} --force record.csv --force-unit stone", "--force-unit", "'stone'", "kN"),
    (f"{RANGES} --frequency 60:10Hz", "--frequency", "'60:10Hz'", "first end is the lower one"),
    (f"{RANGES} --frequency 10-60Hz", "--frequency", "'10-60Hz'", "write 10:60Hz"),
    (f"{RANGES} --frequency 0:60Hz", "--frequency", "'0' in '0:60Hz'", "greater than zero"),
    (f"{MAP} --out map.jpeg", "--out", "'map.jpeg'", "must end in .png"),
    (f"{MAP} --out maps/map.png", "--out", "'maps/map.png'", "make it first"),
    (f"{MAP} --points 400,300", "--points", "'400,300'", "such as 400x300"),
    (f"{MAP} --mark 0.2Fcr", "--mark", "'0.2Fcr'", "two quantities such as"),
    (f"{MAP} --paper-criterion exakt", "--paper-criterion", "'exakt'", "did you mean exact?"),
    (f"certify {LOAD} --rod nitinol --vary lenth=1%", "--vary", "'lenth=1%'", "did you mean length?"),
    (f"certify {LOAD} --rod nitinol --vary length", "--vary", "'length'", "such as length=3.05:3.15"),
    (f"certify {LOAD} --rod nitinol --vary length=4:3", "--vary", "'length=4:3'", "first end is the lower one"),
    (f"certify {LOAD} --rod nitinol --vary length=99%:101%", "--vary", "'length=99%:101%'", "such as length=3.05:3.15"),
    (f"certify {LOAD} --rod nitinol --vary damping_rate=1%", "--vary", "'damping_rate=1%'", "give a number with its"),
    (f"certify {LOAD} --rod nitinol --vary wall_thickness=1%", "--vary", "'wall_thickness=1%'", "inner_diameter"),
    (f"certify {LOAD} --rod nitinol --max-boxes 1e5", "--max-boxes", "'1e5'", "whole number"),
    # simulations and ensembles
    (f"{SIMULATE} --kick 50mm/s", "--kick", "'50mm/s'", "a mode and a speed such as 8:50mm/s"),
    (f"{SIMULATE} --kick 8:50m", "--kick", "'50m'", "it is a unit of length"),
    (f"{SIMULATE} --case E", "--case", "'E'", "must be A, B, C or D"),
    (f"{SIMULATE} --seed 1.5 --case C", "--seed", "'1.5'", "whole number"),
    (f"{SIMULATE} --duration 2sek", "--duration", "'2sek'", "did you mean"),
    (f"{SIMULATE} --out run.csv", "--out", "'run.csv'", "must end in .png"),
    (f"{SIMULATE} --out guarded.npz", "guarded.npz", "guarded.npz", "write-protected"),
    ("ensemble studi.toml", "study", "'studi.toml'", "did you mean study.toml?"),
    ("ensemble percent.toml", "frequency", "'24%'", "needs something it is a part of"),
    ("ensemble misspelt.toml", "[run]", "'duraton'", "did you mean duration?"),
    ("ensemble wave.toml", "wave", "'fixed'", "'held', 'free', 'driven'"),
    ("ensemble pipe.toml", "rod", "'2.00x0.156 CT90'", "needs a table [rod]"),
    ("ensemble study.toml --confidence 95", "--confidence", "95", "between 0 and 1"),
    ("ensemble study.toml --part 3of9", "--part", "'3of9'", "such as 3/100"),
    ("ensemble study.toml --store runs.csv", "store", "runs.csv", ".zarr"),
    ("ensemble study.toml --workers two", "--workers", "'two'", "whole number"),
    # the rest
    ("compare --alpha 0,5 --beta 1", "--alpha", "'0,5'", "write a point"),
    ("compare --alpha 0.5", "--beta", "--beta", "required"),
    ("--print-completion fsh", "--print-completion", "'fsh'", "bash, zsh, tcsh"),
]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Work in a folder with files."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    (tmp_path / "folder").mkdir()
    guarded = tmp_path / "guarded.npz"
    guarded.touch(mode=0o444)
    access = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path).name != guarded.name and access(path, mode))
    return tmp_path


@pytest.mark.parametrize(("line", "argument", "value", "remedy"), MISTAKES, ids=[mistake[0] for mistake in MISTAKES])
def test_the_answer_names_argument_value_and_remedy(
    line: str, argument: str, value: str, remedy: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sorted(folder.rglob("*"))
    assert cli.main(shlex.split(line)) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert re.fullmatch(r"floquetrod: error: .+\n", captured.err)
    for words in (argument, value, remedy):
        assert words in captured.err
    assert sorted(folder.rglob("*")) == before


def test_there_are_mistakes_enough() -> None:
    assert len({line for line, *_ in MISTAKES}) == len(MISTAKES) >= 40
