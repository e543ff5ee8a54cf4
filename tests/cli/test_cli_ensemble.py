"""`floquetrod ensemble`: study files, what it answers and keeps, how it is stopped and continued, what it refuses."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod import cli, units
from floquetrod._util import waiting
from floquetrod.ensembles import workers
from floquetrod.ensembles.runs import Runs
from floquetrod.ensembles.study import _INTEGERS
from floquetrod.ensembles.varied_axes import VARIED_KINDS, names_of
from tests.seams import Forbidden, Tuned

ROOT = Path(__file__).parents[2]
TABLES = {
    "": 'rod = "nitinol"',
    "load": 'mean = "0.3Fcr"\namplitude = "0.3Fcr"\nfrequency = "24Hz"',
    "run": 'duration = "10ms"\nsegments = 60\nframes = 4',
    "start": 'kick = {8 = "50mm/s"}\nrandom = "1mm/s"\nseed = 3',
    "over": 'kick = ["10mm/s", "0.9m/s"]\nseed = {from = 1, to = 3}',
}


def written(folder: Path, **changes: str | None) -> str:
    """Write a study with some tables replaced, or left out; return its path."""
    tables = TABLES | changes
    text = [(f"[{name}]\n" if name else "") + body for name, body in tables.items() if body is not None]
    path = folder / "study.toml"
    path.write_text("\n".join(text), encoding="utf-8")
    return str(path)


def answer(capsys: pytest.CaptureFixture[str], *arguments: str, status: int = 0) -> Any:
    """Return the answer as JSON."""
    assert cli.main(["ensemble", *arguments, "--json"]) == status
    return json.loads(capsys.readouterr().out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Return the error, which is one line."""
    assert cli.main(["ensemble", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("floquetrod: error: ")
    assert captured.err.count("\n") == 1
    return captured.err


# --- study files -----------------------------------------------------------------------------------------------------


def test_a_study_is_what_the_library_would_be_given(tmp_path: Path) -> None:
    study = fr.Study.from_toml(Path(written(tmp_path)))
    rod = fr.Rod.nitinol()
    load = fr.AxialLoad(*(units.quantity("0.3Fcr", "", "force", critical_force=rod.critical_force),) * 2, 48.0 * np.pi)
    start = fr.Perturbation.modes({8: 0.05}) + fr.Perturbation.random(1e-3, seed=3)
    assert study.problem == fr.SimulationProblem(rod, load, duration=0.01, segments=60, frames=4, perturbation=start)
    assert study.over == {"kick": [0.01, 0.9], "seed": range(1, 4)}
    assert study.units["kick"].name == "mm/s"


def test_rods_by_file_by_table_and_from_the_catalogue(tmp_path: Path) -> None:
    wire = (ROOT / "floquetrod/examples/wire.toml").read_text(encoding="utf-8")
    (tmp_path / "wire.toml").write_text(wire, encoding="utf-8")
    tables = {"run": 'duration = "1ms"', "start": None}
    by_name = fr.Study.from_toml(Path(written(tmp_path, **{"": 'rod = "wire.toml"'}, **tables))).problem
    by_table = fr.Study.from_toml(Path(written(tmp_path, **{"": ""}, rod=wire, **tables))).problem
    assert by_name.rod == by_table.rod == fr.Rod.from_toml(tmp_path / "wire.toml")
    assert by_name == by_table
    pipe = 'catalogue = "2.00x0.156 CT90"\nbore = "4.778in"\nlength = "200ft"'
    found = fr.Study.from_toml(Path(written(tmp_path, **{"": ""}, rod=pipe, **tables))).problem.rod
    assert found == fr.Rod.catalogue("2.00x0.156 CT90", bore="4.778in", length="200ft")


def test_waves_measured_forces_and_cases(tmp_path: Path) -> None:
    t = np.linspace(0.0, 1.0, 400, endpoint=False)
    rows = np.column_stack([t, 0.5 + 0.1 * np.sin(20.0 * np.pi * t)])
    np.savetxt(tmp_path / "force.csv", rows, delimiter=",", header="t (s),force (N)", comments="")
    measured = fr.Study.from_toml(Path(written(tmp_path, load='force = "force.csv"'))).problem.load
    assert measured.frequency == pytest.approx(20.0 * np.pi, rel=1e-3)
    body = TABLES["load"] + '\nwave = "held"\naxial_damping = "2/s"\nmean_at = "none"'
    wave = fr.Study.from_toml(Path(written(tmp_path, load=body))).problem.load
    assert isinstance(wave, fr.AxialWave)
    assert (wave.far_end, wave.axial_damping, wave.mean_at) == ("held", 2.0, None)
    start = fr.Study.from_toml(
        Path(written(tmp_path, start='case = "C:9"\nseed = 2', run="segments = 120", over="friction = [0.1]"))
    ).problem
    assert start.perturbation == fr.Perturbation.case("C", mode=9, seed=2)


def test_lists_ranges_and_distributions(tmp_path: Path) -> None:
    body = """
    friction = {from = 0.1, to = 0.4, steps = 4}
    frequency = {from = "60rpm", to = "6000rpm", steps = 3, spacing = "log"}
    segments = [60, 72]
    length = {distribution = "normal", mean = "3.1m", deviation = "5mm", high = "3.102m"}
    mean = {distribution = "uniform", low = "0.2Fcr", high = "0.3Fcr"}
    kick = {distribution = "loguniform", low = "1mm/s", high = "1m/s"}
    """
    study = fr.Study.from_toml(Path(written(tmp_path, over=body, ensemble='samples = 5\nseed = 3\nlayout = "grid"')))
    assert study.options == {"samples": 5, "seed": 3, "layout": "grid"}
    np.testing.assert_allclose(study.over["friction"], [0.1, 0.2, 0.3, 0.4])
    np.testing.assert_allclose(study.over["frequency"], 2.0 * np.pi * np.array([1.0, 10.0, 100.0]))
    assert study.over["segments"] == [60, 72]
    force = study.problem.rod.critical_force
    np.testing.assert_allclose(study.over["mean"].ppf([0.0, 1.0]), [0.2 * force, 0.3 * force])
    np.testing.assert_allclose(study.over["kick"].ppf([0.0, 0.5, 1.0]), [1e-3, np.sqrt(1e-3), 1.0])
    length = study.over["length"]
    assert length.ppf(1.0) == pytest.approx(3.102)
    levels = np.array([0.1, 0.7])  # a normal distribution, cut off at 0.4 of its deviation
    from scipy.stats import norm

    np.testing.assert_allclose(length.cdf(3.1 + 5e-3 * norm.ppf(levels * norm.cdf(0.4))), levels)


def test_everything_that_can_be_varied_has_a_kind(tmp_path: Path) -> None:
    problem = fr.Study.from_toml(Path(written(tmp_path))).problem
    wave = fr.AxialWave(0.3, 0.1, 150.0, far_end="free")
    for varied in (problem, problem.replace(load=wave)):
        names = {name for group in names_of(varied).values() for name in group}
        assert names - {*VARIED_KINDS, *_INTEGERS} == set()


def test_the_example_is_a_study() -> None:
    study = fr.Study.from_toml(ROOT / "floquetrod/examples/study.toml")
    assert study.problem.friction == 0.1
    assert len(study.over["seed"]) == 20


# --- answers ---------------------------------------------------------------------------------------------------------


def test_tells_how_probable_buckling_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["ensemble", written(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "6 of 6 runs done, 0 failed, 0 pending"
    assert lines[2] == "buckled   0 of 6; not buckled, but beyond 5 degrees: 3 swinging"
    assert lines[4].startswith("note      3 runs counted as not buckled, still swinging as its kick may have left it")
    assert "store     none: name one with --store" in lines
    assert re.fullmatch(r" +kick +runs done +share that buckled +95 % interval +if moving runs buckle too", lines[-3])
    assert re.fullmatch(r" 10 mm/s +3 +0\.000 +0\.000 to 0\.708 +up to 0\.708", lines[-2])
    assert re.fullmatch(r"900 mm/s +3 +0\.000 +0\.000 to 0\.708 +up to 1\.000", lines[-1])
    assert re.search(r"\ncost +[\d.e-]+ s; all 6 runs done took \d+ seconds, one after the other\n", "\n".join(lines))


def test_runs_that_cannot_differ_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    still = answer(capsys, written(tmp_path, over='kick = ["0mm/s", "10mm/s"]\nseed = [1, 2, 3]'))
    (note,) = (note for note in still["notes"] if "identical" in note)
    assert note.startswith("all runs of a cell are identical in 1 of 2 cells: they count as one run")
    alike = answer(capsys, written(tmp_path, over='kick = ["10mm/s"]\nseed = [1, 1]'))
    assert any(note.startswith("all runs of a cell are identical: they") for note in alike["notes"])
    drawn = 'friction = {distribution = "uniform", low = 0.1, high = 0.2}'
    fixed = answer(capsys, written(tmp_path, over=drawn, ensemble="samples = 2"))
    assert any(note.startswith("no seed varies: all runs start with the same random speeds") for note in fixed["notes"])
    chosen = answer(capsys, written(tmp_path, over='kick = ["10mm/s", "20mm/s"]'))
    assert any(note.startswith("neither a seed nor a distribution varies") for note in chosen["notes"])
    varied = answer(capsys, written(tmp_path))
    assert not any("identical" in note or "vari" in note for note in varied["notes"])


def test_friction_drawn_in_per_cent_is_suspected(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    drawn = 'friction = {{distribution = "uniform", low = {}, high = {}}}'
    for low, high, is_suspected in ((10, 20, True), (0.1, 0.2, False)):
        path = written(tmp_path, over=drawn.format(low, high), ensemble="samples = 2")
        assert cli.main(["ensemble", path]) == 0
        assert ("was it in per cent?" in capsys.readouterr().err) == is_suspected


def test_json_says_what_the_library_finds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record = answer(capsys, written(tmp_path), "--confidence", "0.8")
    study = fr.Study.from_toml(tmp_path / "study.toml")
    with pytest.warns(fr.OutcomeWarning, match="3 runs counted as not buckled"):
        found = fr.ensembles.probability(fr.ensemble(study.problem, study.over), over="seed", confidence=0.8)
    assert [row["kick_m_per_s"] for row in record["rows"]] == [0.01, 0.9]
    for name in ("probability", "lower", "upper", "done", "failed", "moving", "upper_moving"):
        assert [row[name] for row in record["rows"]] == found[name].values.tolist()
    assert (record["complete"], record["continue"], record["store"]) == (True, None, None)


def test_failures_are_grouped_by_their_reason(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, over="segments = [40, 44, 60]\nseed = [1, 2]")
    record = answer(capsys, path)
    assert (record["done"], record["failed"], record["pending"]) == (2, 4, 0)
    ((reason, runs),) = (failure.values() for failure in record["failures"])
    assert runs == 4
    assert "mode 8, which 40 segments cannot resolve" in reason
    assert cli.main(["ensemble", path]) == 0
    out = capsys.readouterr().out
    assert re.search(r"\nfailed    4: ValueError: perturbation names mode 8, ", out)
    assert re.search(r"\n +40 +0, 2 failed +-  0\.000 to 1\.000 +up to 1\.000\n", out)


@pytest.mark.parametrize("over", ["kick", "kick,kick", "kick,bore", "kick,seed", "kick,friction"])
def test_over_is_two_quantities_that_vary(over: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    body = 'kick = ["10mm/s", "0.9m/s"]\nseed = [1, 2]\nfriction = [0.1]\nlength = {lengths}'
    lengths = '{distribution = "normal", mean = "3.1m", deviation = "5mm"}'
    path = written(tmp_path, over=body.replace("{lengths}", lengths))
    said = refused(capsys, path, "--out", str(tmp_path / "a.png"), "--over", over)
    assert "--over must be two quantities that vary in [over]" in said
    assert f"these are kick, length; got {over!r}" in said


@pytest.mark.filterwarnings("default::floquetrod.ResolutionWarning")
@pytest.mark.parametrize("processes", [[], pytest.param(["--workers", "2"], marks=pytest.mark.slow)])
def test_too_few_segments_are_a_note_and_one_warning(
    processes: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    load = 'mean = "3Fcr"\namplitude = "0N"\nfrequency = "100rad/s"'
    study = written(
        tmp_path,
        load=load,
        run='duration = "0.3s"\nsegments = 37\nframes = 4',
        start='random = "1mm/s"',
        over="seed = [1, 2, 3]",
    )
    line = ["ensemble", study, "--store", str(tmp_path / "runs.npz"), *processes]
    assert cli.main(line) == 0
    first = capsys.readouterr()
    note = re.search(r"^note      runs are too coarse: (37 segments resolve modes up to 6, .*)$", first.out, re.M)
    assert note is not None
    assert "rates will be wrong; take " in note[1]
    assert first.err.count("rates will be wrong") == 1
    assert f"floquetrod: warning: {note[1]}\n" in first.err
    assert cli.main(line) == 0
    again = capsys.readouterr()
    assert note[0] in again.out
    assert "rates will be wrong" not in again.err


@pytest.mark.slow
@pytest.mark.filterwarnings("default::RuntimeWarning")
def test_workers_that_were_replaced_are_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    started, pools = workers._Pool.started, []

    def killed(alive: Any) -> Any:
        pools.append(started(alive))
        if len(pools) <= 2:
            for process in pools[-1].executor._processes.values():
                process.kill()
        return pools[-1]

    monkeypatch.setattr(workers._Pool, "started", killed)
    assert cli.main(["ensemble", written(tmp_path), "--workers", "2"]) == 0
    said = capsys.readouterr()
    assert "6 of 6 runs done, 0 failed" in said.out
    line = (
        "floquetrod: warning: 2 worker processes ended and were replaced, killed or out of memory; no finished run was"
    )
    assert said.err.count(line) == 1


def test_without_samples_there_are_no_probabilities(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    record = answer(capsys, written(tmp_path, over='kick = ["10mm/s", "0.9m/s"]'))
    assert (record["rows"], record["buckled"], record["outcomes"]["swinging"]) == ([], 0, 1)


def test_a_figure_without_draws_is_refused_before_anything_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], forbidden: Forbidden
) -> None:
    chosen = written(tmp_path, over='kick = ["10mm/s"]', run='duration = "1h"\nsegments = 60')
    store, figure, table = (str(tmp_path / name) for name in ("runs.npz", "buckling.png", "runs.csv"))
    said = refused(capsys, chosen, "--store", store, "--out", table, "--out", figure)
    assert f"--out {figure} needs one or two quantities that vary, or runs that are drawn, got none in [over]" in said
    assert "or write a .csv file" in said
    assert not any(Path(name).exists() for name in (store, figure, table))
    for over in ('kick = ["10mm/s"]\nseed = [1, 2]', 'kick = {distribution = "uniform", low = 0.1, high = 0.2}'):
        forbidden(fr.Study, "run")
        with pytest.raises(pytest.fail.Exception, match="run was called"):
            cli.main(["ensemble", written(tmp_path, over=over), "--out", figure])


def test_long_tables_are_cut(tmp_path: Path, capsys: pytest.CaptureFixture[str], tuned: Tuned) -> None:
    tuned(rows_of_a_printed_table=1)
    assert cli.main(["ensemble", written(tmp_path)]) == 0
    assert capsys.readouterr().out.endswith("\nand 1 more: --json lists them all\n")


# --- stores ----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_store_is_continued_as_in_python(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, store = written(tmp_path), str(tmp_path / "runs.npz")
    first = answer(capsys, path, "--store", store)
    assert answer(capsys, path, "--store", store)["done"] == answer(capsys, path, "--store", store, "--resume")["done"]
    again = answer(capsys, path, "--store", store)
    assert again["rows"] == first["rows"]
    assert (first["made_now"], again["made_now"]) == (6, 0)
    assert cli.main(["ensemble", path, "--store", store]) == 0
    assert "\n6 of 6 runs were in the store before; 0 were made now\n" in capsys.readouterr().out
    other = written(tmp_path, start='random = "2mm/s"')
    assert "another" in refused(capsys, other, "--store", store, "--resume")


@pytest.mark.slow
def test_parts_make_the_whole(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("zarr")
    path, store = written(tmp_path), str(tmp_path / "runs.zarr")
    whole = answer(capsys, path)
    first = answer(capsys, path, "--store", store, "--part", "1/2")
    assert first["complete"]
    assert first["pending"] == 3
    second = answer(capsys, path, "--store", store, "--part", "2/2")
    assert second["pending"] == 0
    assert second["rows"] == whole["rows"]


def interrupted_after(monkeypatch: pytest.MonkeyPatch, number: int, runs: int) -> None:
    """Send this process a signal once so many runs are done."""
    call = waiting.Waiting.__call__

    def report(self: Any, done: int, total: int) -> None:
        call(self, done, total)
        if done == runs:
            os.kill(os.getpid(), number)

    monkeypatch.setattr(waiting.Waiting, "__call__", report)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of POSIX")
@pytest.mark.parametrize("number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)])
def test_signals_keep_what_came(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    path, store = written(tmp_path, over="seed = {from = 1, to = 40}"), str(tmp_path / "runs.npz")
    with monkeypatch.context() as patched:
        interrupted_after(patched, number, 5)
        assert cli.main(["ensemble", path, "--store", store]) == 130
    out = capsys.readouterr().out
    assert out.startswith("INTERRUPTED: ")
    kept = int((Runs.load(store)["status"] == 1).sum())
    assert 5 <= kept < 40
    (command,) = re.findall(r"^continue  floquetrod (.*)$", out, re.MULTILINE)
    record = answer(capsys, *shlex.split(command)[1:])
    assert (record["done"], record["pending"]) == (40, 0)
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals are those of POSIX")
def test_a_terminated_command_leaves_its_store_whole(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    # The second run would take days: the command cannot come to its end before it is told to.
    path, store = written(tmp_path, over='duration = ["10ms", "100000s"]'), tmp_path / "runs.npz"
    command = [sys.executable, "-m", "floquetrod", "ensemble", path, "--store", str(store)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment) as process:
        while not (store.exists() and (Runs.load(store)["status"] == 1).any()):
            assert process.poll() is None
            time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        out, _ = process.communicate()
    assert process.returncode == 130
    assert out.startswith(b"INTERRUPTED: ")
    assert (Runs.load(store)["status"] == 1).tolist() == [True, False]


def test_interrupted_before_the_first_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(fr.Study, "run", interrupt)
    assert cli.main(["ensemble", written(tmp_path), "--store", "runs.npz", "--workers", "2"]) == 130
    out = capsys.readouterr().out
    assert out.startswith("INTERRUPTED before a run was done\ncontinue  floquetrod ensemble ")
    assert out.endswith("--store runs.npz --workers 2\n")
    assert cli.main(["ensemble", written(tmp_path)]) == 130
    assert "the same command starts from the beginning" in capsys.readouterr().out


# --- progress --------------------------------------------------------------------------------------------------------


def test_progress_tells_the_time_left(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    clock: list[float],
    tuned: Tuned,
) -> None:
    """In a log there is a line after ten seconds, and one a minute at last; a first pause may be for compiling."""
    seen: list[waiting.Waiting] = []

    def run(_: object, *, progress: waiting.Waiting, **__: object) -> None:
        seen.append(progress)
        raise KeyboardInterrupt

    def wait(pause: float) -> bool:
        pauses.append(pause)
        clock[0] += pause
        progress(int(1.0 + 0.1 * clock[0]), 26)
        return progress.is_complete

    monkeypatch.setattr(fr.Study, "run", run)
    assert cli.main(["ensemble", written(tmp_path)]) == 130
    pauses, (progress,) = [], seen
    tuned(seconds_between_plain_lines=10.0)
    monkeypatch.setattr(progress._left, "wait", wait)
    progress._start = 0.0
    progress(1, 26)
    capsys.readouterr()
    progress._speak()
    assert pauses == [10.0, 20.0, 40.0, 60.0, 60.0, 60.0]
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "floquetrod: simulating: 10 s, 2 of 26 runs (Ctrl-C ends it)"
    assert lines[1] == "floquetrod: simulating: 30 s, 4 of 26 runs, 4 minutes left (Ctrl-C ends it)"
    assert lines[-1] == "floquetrod: simulating: 190 s, 20 of 26 runs, 60 seconds left (Ctrl-C ends it)"


# --- what is refused -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"": 'rod = "nitinol'}, r"study file \S+ cannot be read: "),
        ({"": ""}, r"missing table \[rod\]; the tables are \[rod\], \[load\]"),
        ({"over": None}, r"missing table \[over\]"),
        ({"": 'rod = "nitinol"\nload = 3', "load": None}, r"load must be a table, .*got 3"),
        ({"extra": "x = 1"}, r"unknown key 'extra'"),
        ({"": "rod = 3"}, r"\[rod\] must be a table as in rod files, nitinol or a rod file, got 3"),
        ({"": 'rod = "absent.toml"'}, r"\[rod\] rod must be nitinol.*absent\.toml.: there is no such file"),
        ({"": "", "rod": 'radius = "1mm"'}, r"\[rod\] missing key 'youngs_modulus'"),
        ({"load": 'mean = "0.3Fcr"'}, r"\[load\] missing keys amplitude, frequency"),
        ({"load": TABLES["load"].replace("24Hz", "24cm")}, r"\[load\] frequency must be .*'24cm': unit 'cm'"),
        ({"load": TABLES["load"] + "\nwave = true"}, r"\[load\] wave must be .*got True"),
        ({"load": TABLES["load"] + '\nwave = "open"'}, r"\[load\] wave must be one of 'held', 'free', 'driven'"),
        ({"load": TABLES["load"] + '\naxial_damping = "2/s"'}, r"\[load\] axial_damping needs wave, got '2/s'"),
        ({"load": 'force = "absent.csv"'}, r"\[load\] force must be a text file"),
        ({"run": "segmets = 60"}, r"\[run\] unknown key 'segmets'; did you mean segments\?"),
        ({"run": 'duration = "2 m"'}, r"\[run\] duration must be a number with a time unit"),
        ({"run": "segments = 60.5"}, r"\[run\] segments must be an integer, got 60\.5"),
        ({"run": 'stop_early = "yes"'}, r"\[run\] stop_early must be True or False, got 'yes'"),
        ({"run": "segments = 40\nduration = 0.01"}, r"\[start\] perturbation names mode 8, which 40 segments"),
        ({"start": "kick = 3"}, r"\[start\] kick must map modes to speeds"),
        ({"start": 'kick = {a = "5mm/s"}'}, r"\[start\] kick must be a mode and a speed"),
        ({"start": 'case = "E"'}, r"\[start\] case must be A, B, C or D"),
        ({"start": "kick = {8 = 0.1}\nseed = 1"}, r"\[start\] seed draws nothing here"),
        ({"over": ""}, r"\[over\] needs at least one key"),
        ({"over": "frequencies = [1]"}, r"\[over\] unknown key 'frequencies'; did you mean frequency\?"),
        ({"over": 'frequency = "24Hz"'}, r"\[over\] frequency must be a list, a range .*got '24Hz'"),
        ({"over": 'frequency = ["24Hz", "24kg"]'}, r"\[over\] frequency must be .*'24kg'"),
        ({"over": "frequency = []"}, r"\[over\] frequency must have one dimension and at least one value"),
        ({"over": "frequency = [[1, 2]]"}, r"\[over\] frequency must be a number with"),
        ({"over": "frequency = {from = 1, to = 2}"}, r"\[over\] frequency needs from, to, steps, got"),
        ({"over": "friction = {from = 0.1, to = 1, steps = 1}"}, r"\[over\] friction: steps must be 2 or more, got 1"),
        ({"over": 'kick = {from = 0, to = 1, steps = 2, spacing = "log"}'}, r'\[over\] kick: spacing "log" needs'),
        ({"over": "seed = {from = 1, to = 3, steps = 2}"}, r"\[over\] unknown key 'steps'"),
        ({"over": "seed = [1.5]"}, r"\[over\] seed must be an integer, got 1\.5"),
        ({"over": "seed = {from = 4, to = 3}"}, r"\[over\] seed: to must be 4 or more, got 3"),
        ({"over": 'length = {distribution = "gauss"}'}, r"\[over\] length: distribution must be one of 'uniform'"),
        ({"over": 'length = {distribution = "uniform", low = 1}'}, r"\[over\] length needs low, high"),
        (
            {"over": 'length = {distribution = "uniform", low = "3m", high = "2m"}'},
            r"\[over\] length: low must lie below high, got '3m' and '2m'",
        ),
        (
            {"over": 'length = {distribution = "normal", mean = "3m", deviation = 0}'},
            r"\[over\] length: deviation must be (positive|greater than zero)",
        ),
        (
            {"over": 'length = {distribution = "normal", mean = "3m", deviation = "1mm"}'},
            r"\[ensemble\] samples must say how often",
        ),
        ({"ensemble": 'layout = "random"'}, r"\[ensemble\] layout must be one of 'grid', 'list'"),
        ({"ensemble": 'layout = "list"'}, r"\[over\] must hold as many values of each name"),
        ({"ensemble": "samples = 3"}, r"\[ensemble\] samples is for distributions"),
        ({"ensemble": "frames = true"}, r"\[ensemble\] frames needs a --store"),
    ],
)
def test_what_a_study_must_not_say(
    changes: dict[str, str | None], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    error = refused(capsys, written(tmp_path, **changes))
    assert f"study file {tmp_path / 'study.toml'}" in error
    assert re.search(message, error), error


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--workers", "0"], r"--workers must be 1 or more, got 0"),
        (["--part", "3"], r"--part must be the number of a part .*got '3'"),
        (["--part", "4/3", "--store", "s.zarr"], r"--part must be .*got '4/3'"),
        (["--part", "1/3"], r"--part needs --store"),
        (["--part", "1/3", "--store", "s.npz"], r"--part needs a store that many can write"),
        (["--store", "s.csv"], r"--store must end in \.zarr or \.npz, got 's\.csv'"),
        (["--confidence", "1"], r"--confidence must lie between 0 and 1, got 1"),
        (["--confidence", "nan"], r"--confidence must be a number such as 0.3, or 30%, got .nan."),
    ],
)
def test_options_that_cannot_be(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert re.search(message, refused(capsys, written(tmp_path), *arguments))


def test_no_study(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "there is no such file" in refused(capsys, str(tmp_path / "absent.toml"))
    assert "name a file in it" in refused(capsys, str(tmp_path))
