"""`floquetrod simulate`: what it answers, what it writes, what Ctrl-C and divergence leave, what it refuses."""

from __future__ import annotations

import errno
import json
import math
import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod import cli
from floquetrod._util import waiting
from floquetrod.cli import simulate
from tests.seams import Tuned

LOAD = ["--mean", "0.2Fcr", "--amplitude", "0.2Fcr", "--frequency", "150"]
SHORT = ["simulate", "--rod", "nitinol", *LOAD, "--segments", "60", "--duration", "0.2s"]


@pytest.fixture(autouse=True)
def no_window(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MPLBACKEND", "Agg")


def answer(capsys: pytest.CaptureFixture[str], *arguments: str, status: int = 0) -> Any:
    """Return the answer as JSON."""
    assert cli.main([*SHORT, *arguments, "--json"]) == status
    return json.loads(capsys.readouterr().out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))


def test_tells_all_a_user_needs(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*SHORT, "--kick", "7:0.1mm/s"]) == 0
    text = capsys.readouterr().out
    assert re.match(r"GROWING, not yet buckled after 0\.2 s: mode 7 at 4\.\d+ 1/s, 5 degrees at about [12]", text)
    for line in (
        r"start     0\.1 mm/s in mode 7; friction 0",
        r"growth    4\.2\d+ \+- \S+ 1/s in mode 7 up to 0\.2 s; predicted 4\.2435 1/s \([+-]0\.\d\d %\) with "
        r"inertia along the rod, 4\.2357 1/s without",
        r"theory    unstable: mode 7 grows",
        r"step      12\.2 us, set by stretch: ",
        r"cost      \S+ s of wall time for 0\.2 s of 60 segments",
        r"written   nothing: name files with --out",
    ):
        assert re.search(line, text), line


@pytest.mark.slow
def test_what_has_not_buckled_yet_says_when_it_will(capsys: pytest.CaptureFixture[str]) -> None:
    early = answer(capsys, "--kick", "7:0.1mm/s", "--duration", "0.6s")
    late = answer(capsys, "--kick", "7:0.1mm/s", "--duration", "1.8s")
    assert (early["buckled"], early["growing"]) == (False, True)
    assert (late["buckled"], late["growing"], late["buckles_at_about_s"]) == (True, True, None)
    load = fr.AxialLoad(0.2 * fr.Rod.nitinol().critical_force, 0.2 * fr.Rod.nitinol().critical_force, 150.0)
    kick = fr.Perturbation.modes({7: 1e-4})
    run = fr.simulate(fr.Rod.nitinol(), load, duration=1.8, perturbation=kick, segments=60)
    assert early["buckles_at_about_s"] == pytest.approx(run.buckled_at, rel=0.05)


@pytest.mark.slow
def test_what_does_not_grow_has_not_buckled(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (["--frequency", "190rad/s"], ["--mu", "0.1"]):
        assert cli.main([*SHORT, *arguments, "--kick", "7:0.1mm/s"]) == 0
        assert capsys.readouterr().out.startswith("NOT BUCKLED: largest angle 0.0")
    record = answer(capsys, "--mu", "0.1")
    assert (record["growing"], record["buckles_at_about_s"]) == (False, None)


@pytest.mark.slow
def test_json_says_what_the_library_finds(capsys: pytest.CaptureFixture[str]) -> None:
    record = answer(capsys, "--kick", "7:0.1mm/s")
    rod = fr.Rod.nitinol()
    load = fr.AxialLoad(0.2 * rod.critical_force, 0.2 * rod.critical_force, 150.0)
    run = fr.simulate(rod, load, duration=0.2, perturbation=fr.Perturbation.modes({7: 1e-4}), segments=60)
    assert record["growth_rate_per_s"] == run.growth_rate(7).rate
    assert record["predicted_growth_rate_per_s"] == rod.stability(load).growth_rate
    assert (record["buckled"], record["dominant_mode"], record["complete"]) == (False, 7, True)
    assert record["time_step_s"] == run.time_steps.size
    assert record["time_step_set_by"] == "stretch"
    assert record["predicted_with_axial_wave_per_s"] == pytest.approx(4.2434927, abs=1e-7)
    assert record["growth_rate_per_s"] == pytest.approx(4.2434927, rel=3e-3)


WELL = """\
catalogue = "2.00x0.156"
bore = "4.778in"
length = "60m"
fluid_inside = 1000.0
fluid_outside = 1000.0
inclination = "60deg"
damping_rate = "0.1 1/s"
ends = "clamped-hinged"
"""


@pytest.mark.slow
def test_real_rods_and_loads(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "well.toml"
    file.write_text(WELL, encoding="utf-8")
    load = ["--mean", "0.5Fcr", "--amplitude", "0.3Fcr", "--frequency", "4Hz", "--mean-at", "1"]
    load += ["--wave", "held", "--axial-damping", "0.5 1/s"]
    command = ["simulate", "--rod", str(file), *load, "--kick", "9:0.01mm/s", "--duration", "8s"]
    path = tmp_path / "run.npz"
    assert cli.main([*command, "--out", str(path)]) == 0
    text = capsys.readouterr().out
    for line in (
        r"BUCKLED: mode \d+ leads",
        r"rod       inner diameter .* in, .*ends clamped-hinged",
        r"          axial waves, lower end held, axial damping 0\.5 1/s, mean force at 1 of the length",
        r"          mean force 0\.3\d+ Fcr at the upper end, 0\.5 Fcr at the lower",
        r"theory    unstable: mode",
    ):
        assert re.search(line, text), line
    run = fr.Simulation.load(path)
    rod = fr.Rod.from_toml(file)
    like = fr.AxialWave(0.0, 0.0, 1.0, mean_at=1.0, axial_damping=0.5)
    force = rod.critical_force
    assert run.problem.rod == rod
    assert run.problem.load == like.with_numbers(0.5 * force, 0.3 * force, 2.0 * np.pi * 4.0)
    assert cli.main([*command, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["segments"] == run.problem.segments  # chosen for the load
    assert record["predicted_growth_rate_per_s"] == rod.stability(run.problem.load).growth_rate
    assert record["growth_rate_per_s"] == pytest.approx(record["predicted_growth_rate_per_s"], rel=0.1)
    assert cli.main([*command, "--duration", "0.5s", "--friction", "0.3", "--no-theory"]) == 0
    assert "theory    not requested" in capsys.readouterr().out
    assert cli.main([*command, "--duration", "0.5s", "--friction", "0.3"]) == 0
    assert "; no critical kick: friction needs independent modes" in capsys.readouterr().out


@pytest.mark.slow
def test_friction_by_interval(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "run.npz"
    assert cli.main([*SHORT, "--mu", "20%,0.3@1.5m", "--out", str(path)]) == 0
    assert "friction 0.2, 0.3 from 1.5 m on" in capsys.readouterr().out
    assert fr.Simulation.load(path).problem.friction == ((0.0, 0.2), (1.5, 0.3))


def test_ends_that_are_moved_or_pushed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "run.npz"
    load = ["--mean", "0", "--amplitude", "0", "--frequency", "1", "--mu", "0.2"]
    push = ["--feed-speed", "20mm/s", "--far-force", "0.5Fcr", "--out", str(path)]
    assert cli.main([*SHORT, *load, *push]) == 0
    text = capsys.readouterr().out
    assert re.search(r"upper end moved at 20 mm/s, which took at most \S+ N\n", text)
    assert "lower end pushed by 0.848" in text
    assert "theory    none: theory needs the force of the load at both ends" in text
    problem = fr.Simulation.load(path).problem
    assert problem.feed_speed == 0.02
    assert problem.far_force == 0.5 * problem.rod.critical_force


@pytest.mark.slow
def test_a_measured_force(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    time = np.arange(0.0, 2.0, 1e-3)
    force = 0.3 + 0.2 * np.sin(150.0 * time) + 0.05 * np.sin(300.0 * time)
    file, path = tmp_path / "record.csv", tmp_path / "run.npz"
    np.savetxt(file, np.stack([time, force], axis=1), delimiter=",", header="time/s,force/N", comments="")
    command = ["simulate", "--rod", "nitinol", "--force", str(file), "--mean", "0.4N", "--duration", "50ms"]
    assert cli.main([*command, "--out", str(path)]) == 0
    assert "          waveform of " in capsys.readouterr().out
    load = fr.Simulation.load(path).problem.load
    assert load.mean == 0.4
    assert load.waveform == fr.ForceRecord.from_csv(file).load.waveform


@pytest.mark.slow
def test_a_rod_off_the_wall_has_no_mode(capsys: pytest.CaptureFixture[str]) -> None:
    thrown = ["--kick", "3:3m/s", "--duration", "0.5s"]
    assert cli.main([*SHORT, *thrown]) == 0
    text = capsys.readouterr().out
    assert re.match(r"NOT BUCKLED, swinging on to \S+ degrees: largest angle \S+ degrees\n", text)
    assert re.search(r"^note      off the wall in \d+ % of the frames of the last quarter$", text, re.MULTILINE)
    assert "growth    not fitted: it has left the wall" in text
    record = answer(capsys, *thrown)
    assert (record["buckled"], record["outcome"], record["dominant_mode"]) == (False, "swinging", None)
    assert record["note"].startswith("off the wall in ")


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::floquetrod.ResolutionWarning")
def test_too_few_segments_are_a_note(capsys: pytest.CaptureFixture[str]) -> None:
    few = ["--mean", "3Fcr", "--amplitude", "0", "--segments", "37", "--duration", "0.3s"]
    assert cli.main([*SHORT, *few]) == 0
    assert re.search(
        r"^note      37 segments resolve modes up to 6, .*mode 11 grows fastest", capsys.readouterr().out, re.M
    )
    assert answer(capsys, "--kick", "7:0.1mm/s")["note"] == ""


@pytest.mark.slow
def test_a_rod_that_buckles_and_one_that_friction_holds(capsys: pytest.CaptureFixture[str]) -> None:
    load = ["--mean", "1.1Fcr", "--amplitude", "0", "--duration", "0.6s"]
    free = answer(capsys, *load)
    assert free["buckled"]
    assert free["dominant_mode"] in free["predicted_unstable_modes"]
    held = answer(capsys, *load, "--mu", "0.1", "--kick", "6:1mm/s")
    assert not held["buckled"]
    assert held["growth_rate_per_s"] is None
    assert held["critical_kick_m_per_s"] > 1e-3
    assert cli.main([*SHORT, *load, "--mu", "0.1", "--duration", "0.01s"]) == 0
    out = capsys.readouterr().out
    assert "growth    not fitted: with friction nothing grows exponentially" in out
    assert "against friction the smallest kick found to buckle it is" in out


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ([], fr.Perturbation.random(1e-3, 1)),
        (["--seed", "5"], fr.Perturbation.random(1e-3, 5)),
        (["--kick", "8:50mm/s", "--kick", "6:-1cm/s"], fr.Perturbation.modes({8: 0.05, 6: -0.01})),
        (["--kick", "8:5cm/s", "--random", "2mm/s"], fr.Perturbation(speeds=((8, 0.05),), noises=((2e-3, 1),))),
        (["--case", "A:6"], fr.Perturbation.case("A", mode=6)),
        (["--case", "B"], fr.Perturbation.case("B")),
        (["--case", "C", "--seed", "3"], fr.Perturbation.case("C", seed=3)),
        (["--case", "D", "--seed", "3"], fr.Perturbation.case("D", seed=3)),
    ],
)
def test_perturbations(
    arguments: list[str], expected: fr.Perturbation, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    path = tmp_path / "run.npz"
    size = ["--segments", "120", "--duration", "1ms", "--frames", "2", "--out", str(path)]
    assert cli.main([*SHORT, *size, *arguments]) == 0
    assert fr.Simulation.load(path).problem.perturbation == expected


@pytest.mark.slow
def test_writes_every_kind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    paths = [tmp_path / name for name in ("run.npz", "run.png", "run.gif")]
    out = [word for path in paths for word in ("--out", str(path))]
    record = answer(capsys, "--frames", "4", "--duration", "10ms", "--kick", "7:1mm/s", *out)
    assert record["written"] == list(map(str, paths))
    assert sorted(tmp_path.iterdir()) == sorted(paths)  # nothing half-written is left
    assert fr.Simulation.load(paths[0]).time.size == 4
    assert paths[1].read_bytes().startswith(b"\x89PNG")
    assert paths[2].read_bytes().startswith(b"GIF8")


@pytest.mark.slow
def test_enough_frames_for_the_growth_rate(capsys: pytest.CaptureFixture[str]) -> None:
    fast = answer(capsys, "--mean", "0.3Fcr", "--amplitude", "0.1Fcr", "--frequency", "1400", "--kick", "7:0.1mm/s")
    assert fast["frames"] == 447  # 44.6 periods, ten frames each
    assert fast["growth_rate_per_s"] is not None


@pytest.mark.slow
def test_a_tool_shakes_the_rod(capsys: pytest.CaptureFixture[str]) -> None:
    shaken = answer(capsys, "--tool", "0.5N@200Hz@1m", "--duration", "20ms")
    assert shaken["tool"] == {"amplitude": 0.5, "frequency": pytest.approx(400.0 * math.pi), "above_end": 1.0}
    assert shaken["no_theory_because"] == "none: theory knows no tool inside the rod"
    still = answer(capsys, "--duration", "20ms")
    assert still["tool"] is None
    assert shaken["energy_work_J"] > 2.0 * still["energy_work_J"]


def interrupt_after(calls: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Press Ctrl-C after so many reports of progress."""
    left = [calls]

    def stop(self: object, done: int, total: int) -> None:
        left[0] -= 1
        if left[0] == 0:
            raise KeyboardInterrupt

    monkeypatch.setattr(waiting.Waiting, "__call__", stop)


def test_control_c_keeps_what_there_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, checkpoint = tmp_path / "run.npz", tmp_path / "run.ckpt"
    arguments = [*SHORT, "--frames", "41", "--out", str(path), "--checkpoint", str(checkpoint)]
    with monkeypatch.context() as patch:
        interrupt_after(10, patch)
        assert cli.main(arguments) == 130
    out = capsys.readouterr().out
    assert out.startswith(
        "INTERRUPTED at 0.05 s of 0.2 s; so far GROWING, not yet buckled after 0.05 s: mode 7, by theory"
    )
    assert "kept      11 of 41 frames; the same command continues from the checkpoint" in out
    assert fr.Simulation.load(path).time.size == 11
    assert cli.main(arguments) == 0
    assert fr.Simulation.load(path).complete
    whole = tmp_path / "whole.npz"
    assert cli.main([*SHORT, "--frames", "41", "--out", str(whole)]) == 0
    assert np.array_equal(fr.Simulation.load(path).positions, fr.Simulation.load(whole).positions)


def test_divergence_keeps_the_frames_before(tmp_path: Path, capsys: pytest.CaptureFixture[str], tuned: Tuned) -> None:
    tuned(share_of_the_critical_step=1.3)
    path = tmp_path / "run.npz"
    assert cli.main([*SHORT, "--out", str(path)]) == 2
    error = capsys.readouterr().err
    assert re.search(
        r"error: the simulation diverged before t = .* the \d+ frames before are kept, in .*run.npz", error
    )
    assert not fr.Simulation.load(path).complete


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--kick", "8"], "--kick must be a mode and a speed such as 8:50mm/s, got '8'"),
        (["--kick", "0:50mm/s"], "mode 0 must be 1 or more"),
        (["--kick", "11:50mm/s"], "names mode 11, which 60 segments cannot resolve"),
        (["--kick", "8:50mph"], "unit 'mph' is not understood"),
        (["--case", "E"], "--case must be A, B, C or D"),
        (["--case", "B:4"], "--case must be A, B, C or D, A and C with a mode"),
        (["--case", "A", "--seed", "2"], "--seed draws nothing here"),
        (["--seed", "-2"], "seed must be 0 or more"),
        (["--duration", "2 weeks"], "--duration must be a number with a time unit"),
        (["--friction", "-1"], "--friction must be zero or more"),
        (["--friction", "0.2,0.3"], "--friction must be such as 0.2 or, with another from 1500 m on"),
        (["--segments", "20"], "segments must be at least 37"),
        (["--wave", "held", "--feed-speed", "1mm/s"], "--feed-speed must not be given with a vibration of"),
        (["--feed-speed", "-1mm/s"], "--feed-speed must be zero or more"),
        (["--wave", "held", "--far-force", "1N"], "--far-force must not be given with a lower end that is held"),
        (["--far-force", "1s"], "--far-force must be a number with a force unit"),
        (["--tool", "1N"], "--tool must be such as 5kN@18Hz"),
        (["--tool", "1N@18Hz@10m"], "--tool must lie in the rod, less than its length 3.1 m above"),
        (["--axial-damping", "1"], "--axial-damping needs --wave"),
        (["--mean-at", "2"], "--mean-at must be a fraction"),
        (["--time-step", "1ms"], "--time-step must be at most"),
        (["--out", "run.doc"], r"--out must end in \.png"),
        (["--out", "no/run.png"], "there is no folder 'no' to write run.png to"),
        (["--checkpoint", "no/run.ckpt"], "there is no folder 'no' to write run.ckpt to"),
        (["--out", "run.npz", "--checkpoint", "./run.npz"], "run.npz is named twice; give every file its own name"),
        (["--frames", "1000000000"], "frames must be at most"),
        (["--duration", "1e308s"], "duration of 1e.308 s makes"),
        (["--duration", "1e300s"], "duration of 1e.300 s makes"),
    ],
)
def test_refuses_in_a_line(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*SHORT, *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1
    assert re.search(message, captured.err)


def test_mp4_needs_ffmpeg(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    from matplotlib import animation

    monkeypatch.setattr(animation.writers, "is_available", lambda name: False)
    assert cli.main([*SHORT, "--out", "run.mp4"]) == 2
    assert "run.mp4 needs the program ffmpeg" in capsys.readouterr().err


def test_progress_tells_rate_and_time_left(clock: list[float]) -> None:
    progress = waiting.Waiting("simulating", "steps")
    assert progress._line() == "simulating: 0 s (Ctrl-C ends it)"
    for clock[0], done, told in (
        (1.0, 1000, "1 s, 1,000 of 9,000 steps"),  # done by an earlier run
        (3.0, 5000, "3 s, 5,000 of 9,000 steps"),  # one pause may be for compiling
        (4.0, 7000, "4 s, 7,000 of 9,000 steps, 2,000 a second, 1 seconds left"),
        (5.0, 9000, "5 s, 9,000 of 9,000 steps, 2,000 a second, 0 seconds left"),
    ):
        progress(done, 9000)
        assert progress._line() == f"simulating: {told} (Ctrl-C ends it)"


def test_time_left_does_not_count_the_pause_in_which_code_is_compiled(clock: list[float]) -> None:
    progress = waiting.Waiting("deciding stability", "points")
    for clock[0], done in ((0.0, 120), (1.0, 240), (2.0, 360)):
        progress(done, 1200)
    for clock[0] in (10.0, 19.0):  # no call while code is compiled
        assert progress._line().endswith(
            f"{clock[0]:.0f} s, 360 of 1,200 points, 120 a second, 7 seconds left (Ctrl-C ends it)"
        )
    progress(480, 1200)
    for clock[0], done in ((20.0, 600), (21.0, 720)):
        progress(done, 1200)
    assert progress._line().endswith("21 s, 720 of 1,200 points, 120 a second, 4 seconds left (Ctrl-C ends it)")


@pytest.mark.parametrize(
    ("steps", "total", "told"),
    [
        (1, 50, ""),
        (500_000, 100_000_000_000, "100,000,000,000 steps will take roughly 28 hours; Ctrl-C ends"),
    ],
)
def test_a_long_run_says_so_at_its_beginning(
    steps: int, total: int, told: str, capsys: pytest.CaptureFixture[str], clock: list[float]
) -> None:
    progress = simulate._Forewarning("simulating", "steps")
    for turn in range(4):
        clock[0] = 0.5 * turn
        progress(steps * turn, total)
    assert f", {3 * steps:,} of {total:,} steps" in progress._line()
    err = capsys.readouterr().err
    assert told in err
    assert err.count("\n") == bool(told)


def test_times_are_told_roughly() -> None:
    told = {61.0: "61 seconds", 121.0: "2 minutes", 7300.0: "2 hours", 3e5: "3 days"}
    assert {seconds: waiting.roughly(seconds) for seconds in told} == told


class FullDisk:
    """A disk that is full wherever this is asked to be written."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
        replace = Path.replace

        def refuse(part: Path, target: Path) -> Path:
            if Path(target).is_relative_to(folder):
                raise OSError(errno.ENOSPC, "No space left on device")
            return replace(part, target)

        monkeypatch.setattr(Path, "replace", refuse)


@pytest.mark.slow
def test_a_full_disk_at_the_end_loses_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    full, spare = tmp_path / "full", tmp_path / "spare"
    full.mkdir()
    spare.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(spare))
    FullDisk(monkeypatch, full)
    paths = [full / "run.npz", full / "run.png", tmp_path / "run.png"]
    out = [word for path in paths for word in ("--out", str(path))]
    assert cli.main([*SHORT, *out]) == 2
    text = capsys.readouterr().out
    assert text.startswith("GROWING, not yet buckled")
    assert re.search(r"not written +\S+full/run\.npz could not be written: No space left on dev", text)
    assert re.search(r"^written: \S+/run\.png$", text, re.MULTILINE)
    (kept,) = spare.rglob("run.npz")
    assert f"everything is kept in {kept}" in text
    whole = tmp_path / "whole.npz"
    assert cli.main([*SHORT, "--out", str(whole)]) == 0
    assert fr.Simulation.load(kept) == fr.Simulation.load(whole)
    assert list(full.iterdir()) == []
    FullDisk(monkeypatch, tmp_path)
    capsys.readouterr()
    record = answer(capsys, "--out", str(paths[0]), status=2)
    assert record["written"] == []
    assert [text.split(": ")[0] for text in record["not_written"]] == [
        f"{paths[0]} could not be written",
        "nor could a copy",
    ]


def test_a_checkpoint_that_cannot_be_written_is_told_at_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tuned: Tuned
) -> None:
    tuned(seconds_between_checkpoints=0.0)
    told: list[str] = []
    monkeypatch.setattr(waiting.Waiting, "__call__", lambda *_: told.append(capsys.readouterr().err))
    FullDisk(monkeypatch, tmp_path)
    record = answer(capsys, "--frames", "21", "--checkpoint", str(tmp_path / "run.ckpt"))
    assert record["complete"]
    assert re.fullmatch(r"floquetrod: warning: checkpoint \S+ cannot be written \(No space .*\n", told[0])
    assert not any(told[1:])  # once is enough
