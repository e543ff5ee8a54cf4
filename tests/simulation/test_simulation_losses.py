"""Nothing is lost: runs killed during saves, full disks, saves that fail, files of other versions and machines."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod._util import sealed_files
from floquetrod.simulation import checkpoints, integration, rod_record, simulation_problem
from tests.damages import unpacked
from tests.seams import Forbidden, Tuned
from tests.simulation.test_simulation import ROD, Stop, run

HERE = Path(__file__).parent


def nursery(what: str, folder: Path, count: int, rng: np.random.Generator) -> dict[str, Any]:
    """Return what a process found that kills its children or fills their disk."""
    command = [sys.executable, str(HERE / "nursery.py"), what, str(folder), str(count), str(rng.integers(2**32))]
    done = subprocess.run(
        command, env={**os.environ, "PYTHONPATH": str(HERE.parents[1])}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("count", [3, 100])
def test_runs_killed_during_saves_end_in_the_same_bits(tmp_path: Path, rng: np.random.Generator, count: int) -> None:
    found = nursery("kills", tmp_path, count, rng)
    assert (found["killed"], found["wrong"], found["finished"]) == (count, 0, True), found
    assert found["left"] == ["run.ckpt"], found  # the parts of the dead are gone
    if count == 100:
        assert found["torn"] > 10, found
        assert found["resumed"] > 50, found


@pytest.mark.slow  # saves that fail are made to in this process, above
@pytest.mark.parametrize("count", [2, 20])
def test_full_disks_lose_nothing(tmp_path: Path, rng: np.random.Generator, count: int) -> None:
    found = nursery("disks", tmp_path, count, rng)
    assert (found["disks"], found["warned"], found["wrong"]) == (count, found["warned"], 0), found
    assert found["warned"] >= found["stale"] == count // 2, found
    assert found["recovered"] >= count // 2, found
    assert set(found["left"]) <= {"run.ckpt"}, found


def test_a_checkpoint_in_use_is_refused_and_left_alone(tmp_path: Path) -> None:
    """As by a second process, or the same command typed twice; the first run notices nothing."""
    path, expected, refused = tmp_path / "run.ckpt", run(), []

    def another(done: int, total: int) -> None:
        if not refused:
            with pytest.raises(ValueError, match=r"run\.ckpt is in use by another sim.*give another path") as caught:
                run(checkpoint=path)
            refused.append(caught)
            raise KeyboardInterrupt

    assert not run(checkpoint=path, progress=another).complete
    with pytest.raises(MemoryError):
        run(checkpoint=path, progress=_out_of_memory)
    assert run(checkpoint=path) == expected
    assert list(tmp_path.iterdir()) == [path]


def _out_of_memory(done: int, total: int) -> None:
    """End a run without asking."""
    raise MemoryError


def test_a_file_system_without_locks_costs_a_warning(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_locks(path: Path) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(checkpoints, "lock_beside", no_locks)
    with pytest.warns(fr.CheckpointWarning, match=r"cannot be locked \(No locks available\): make sure") as caught:
        assert run(checkpoint=tmp_path / "run.ckpt").complete
    assert caught[0].filename.endswith("test_simulation.py")


class Disk:
    """A disk whose saves fail while it is full."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, tuned: Tuned, number: int = errno.ENOSPC) -> None:
        self.full, self.saves = True, 0
        flush = os.fsync

        def fsync(handle: int) -> None:
            self.saves += 1
            if self.full:
                raise OSError(number, os.strerror(number))
            flush(handle)

        monkeypatch.setattr(os, "fsync", fsync)
        tuned(seconds_between_checkpoints=0.0)


@pytest.mark.parametrize(
    "number",
    [
        errno.ENOSPC,
        *(pytest.param(each, marks=pytest.mark.slow) for each in (errno.EACCES, errno.EIO, errno.EDQUOT)),
    ],
)
def test_a_save_that_fails_warns_and_costs_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tuned: Tuned, number: int
) -> None:
    path, expected = tmp_path / "run.ckpt", run()
    disk = Disk(monkeypatch, tuned, number)
    with pytest.warns(fr.CheckpointWarning) as caught:
        result = run(checkpoint=path)
    assert result == expected
    assert "has not been brought up to date" in str(caught[-1].message)
    assert disk.saves > 20  # it was tried again
    on_the_way = [warning for warning in caught if "the run continues, and tries again" in str(warning.message)]
    assert len(on_the_way) == disk.saves - 1
    assert all(os.strerror(number) in str(warning.message) for warning in caught)
    assert all(warning.filename.endswith("test_simulation.py") for warning in caught)  # the line that asked for it
    assert list(tmp_path.iterdir()) == []
    disk.full = False
    assert run(checkpoint=path) == expected
    assert list(tmp_path.iterdir()) == [path]


def test_a_disk_that_has_room_again_gets_its_checkpoint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tuned: Tuned
) -> None:
    path, expected = tmp_path / "run.ckpt", run()
    disk = Disk(monkeypatch, tuned)

    def relieve(done: int, total: int) -> None:
        disk.full = done < total // 2
        if done > 0.7 * total:
            raise KeyboardInterrupt

    with pytest.warns(fr.CheckpointWarning, match="tries again") as caught:
        cut_short = run(checkpoint=path, progress=relieve)
    assert not any("up to date" in str(warning.message) for warning in caught)
    assert not cut_short.complete
    calls: list[int] = []
    assert run(checkpoint=path, progress=lambda done, total: calls.append(done)) == expected
    assert calls[0] > 0.7 * calls[-1]


def test_where_warnings_are_errors_the_run_is_still_carried_to_its_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tuned: Tuned
) -> None:
    expected = run()
    Disk(monkeypatch, tuned)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(fr.CheckpointWarning, match="has not been brought up to date") as caught:
            run(checkpoint=tmp_path / "run.ckpt")
    assert caught.value.simulation == expected


def test_a_folder_that_goes_away_costs_nothing(tmp_path: Path, tuned: Tuned) -> None:
    tuned(seconds_between_checkpoints=0.0)
    expected, folder = run(), tmp_path / "folder"
    folder.mkdir()

    def remove(done: int, total: int) -> None:
        if done > total // 2:
            for path in [*folder.glob("*"), folder] if folder.exists() else []:
                path.rmdir() if path.is_dir() else path.unlink()

    with pytest.warns(fr.CheckpointWarning, match="there is no folder"):
        assert run(checkpoint=folder / "run.ckpt", progress=remove) == expected


def test_control_c_during_a_save_keeps_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tuned: Tuned) -> None:
    path, expected, calls = tmp_path / "run.ckpt", run(), [0]
    flush = os.fsync

    def interrupted(handle: int) -> None:
        calls[0] += 1
        if calls[0] == stop:
            raise KeyboardInterrupt
        flush(handle)

    monkeypatch.setattr(os, "fsync", interrupted)
    stop = 1  # the save at the end, the only one
    with pytest.warns(fr.CheckpointWarning, match="KeyboardInterrupt"):
        assert run(checkpoint=path) == expected
    tuned(seconds_between_checkpoints=0.0)
    calls[0], stop = 0, 5  # one on the way
    cut_short = run(checkpoint=path)
    assert not cut_short.complete
    assert run(checkpoint=path) == expected
    assert list(tmp_path.iterdir()) == [path]


def test_slow_saves_become_rare(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, clock: list[float], tuned: Tuned
) -> None:
    """Of a run whose saves take long, saving is a small part."""
    saves = [0]
    tuned(element_steps_of_a_call=0)

    def save(self: checkpoints.Checkpoint, state: object) -> None:
        clock[0] += 10.0
        saves[0] += 1

    def computing(done: int, total: int) -> None:
        clock[0] += 10.0

    monkeypatch.setattr(checkpoints.Checkpoint, "_save", save)
    run(checkpoint=tmp_path / "run.ckpt", progress=computing)
    assert saves[0] > 1
    assert 10.0 * saves[0] < 0.1 * clock[0] + 20.0


def test_a_path_where_nothing_can_be_written_is_refused_before_the_run(tmp_path: Path, forbidden: Forbidden) -> None:
    forbidden(integration.Integration, "run")
    for path in (tmp_path / "no" / "run.ckpt", tmp_path, Path("/dev/full")):
        with pytest.raises(ValueError, match=r"there is no folder|is a folder|is a device"):
            run(checkpoint=path)
    with pytest.raises(TypeError, match="checkpoint must be a path such as"):
        run(checkpoint=5)


@pytest.mark.parametrize("name", ["simulator", "numba", "llvmlite", "numpy", "machine"])
def test_what_another_version_or_machine_wrote_is_refused_with_a_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    path, here = tmp_path / "run.ckpt", checkpoints.arithmetic()
    with monkeypatch.context() as other:
        other.setattr(checkpoints, "arithmetic", lambda: {**here, name: "7.5"})
        run(checkpoint=path, progress=Stop(3))
    before = path.read_bytes()
    with pytest.raises(ValueError, match=rf"cannot be continued bit for bit here: .* {name} 7\.5; continue .*remove"):
        run(checkpoint=path)
    assert path.read_bytes() == before
    meta, _ = unpacked(path)
    assert meta["version"] == fr.__version__


def test_a_processor_that_rounds_otherwise_is_found_out(tmp_path: Path) -> None:
    """The last steps are done again: a bit of the state they start from stands for one of another machine's sine."""
    path = tmp_path / "run.ckpt"
    run(checkpoint=path, progress=Stop(3))
    meta, arrays = unpacked(path)
    before = arrays["before"].copy()
    before[8 * rod_record.FIRST] ^= 1  # of the place of the first node
    sealed_files.write_npz(path, meta, {**arrays, "before": before}, compress=False)
    with pytest.raises(ValueError, match=r"its last \d+ steps come out otherwise; continue it on the machine .*remove"):
        run(checkpoint=path)


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("state", lambda state: state[:-8], "state is an array of uint8"),
        ("state", lambda state: state.astype(np.int64), "state is an array of int64"),
        ("before", lambda _: None, "it has no 'before'"),
        ("positions", lambda values: values[:1], "positions is an array"),
        ("energies", lambda values: values * np.nan, "energies is not finite"),
    ],
)
def test_every_field_of_a_checkpoint_is_checked(tmp_path: Path, name: str, change: Any, message: str) -> None:
    path = tmp_path / "run.ckpt"
    run(checkpoint=path, progress=Stop(3))
    meta, arrays = unpacked(path)
    changed = {**arrays, name: change(arrays[name])}
    sealed_files.write_npz(
        path, meta, {key: value for key, value in changed.items() if value is not None}, compress=False
    )
    with pytest.raises(ValueError, match=f"is not a checkpoint of a simulation that can be read: {message}"):
        run(checkpoint=path)


def test_a_clock_that_cannot_be_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.ckpt"
    run(checkpoint=path, progress=Stop(3))
    meta, arrays = unpacked(path)
    layout = rod_record.rod_type(60)
    for value in (np.nan, -1.0, 0.5, 1e300):
        (rod,) = np.frombuffer(bytearray(arrays["state"]), layout)
        rod["clock"][0] = value
        state = np.frombuffer(rod.tobytes(), np.uint8)
        sealed_files.write_npz(path, meta, {**arrays, "state": state}, compress=False)
        with pytest.raises(ValueError, match="the clock of its state shows"):
            run(checkpoint=path)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"duration": 1e300},
            r"duration of 1e\+300 s makes .* steps of .* s, at most 1\.667e\+12 are taken",
        ),
        ({"duration": 1e308, "frames": 2}, "duration of 1e.308 s makes .* steps"),
        ({"duration": 5e-324}, "duration must be at least"),
        ({"time_step": 5e-324}, "time_step must be at least"),
        ({"time_step": 1e-300}, "time_step must be at least"),
        ({"time_step": 2e-14, "duration": 1e3}, "time_step of 2e-14 s makes 5e.16 steps"),
        (
            {"frames": 10**9},
            r"frames must be at most 1,466,\d+ with 60 segments, got 1,000,000,000 of 2,928",
        ),
        ({"frames": 10**30}, "frames must be at most"),
        ({"segments": 10**7}, "segments must be at most 3875"),
        ({"segments": 10**18}, "segments must be at most 3875"),
        ({"perturbation": fr.Perturbation.random(1e5, 1), "duration": 1e9}, "duration of 1e.09 s makes"),
    ],
)
def test_absurd_runs_are_refused_before_anything_is_allocated(
    changes: dict[str, Any], message: str, forbidden: Forbidden
) -> None:
    forbidden(simulation_problem, "Integration")
    with pytest.raises(ValueError, match=message):
        run(**changes)


@pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")
def test_rods_too_slender_or_too_extreme_are_refused() -> None:
    thread = fr.Rod(youngs_modulus=68e9, density=6500.0, radius=1e-8, length=40.0, channel_radius=4.7e-3)
    with pytest.raises(ValueError, match="rod cannot be simulated: 6 segments for every half wave"):
        fr.simulate(thread, fr.AxialLoad(0.0, 0.0, 1.0), duration=0.1)
    extremes = {"youngs_modulus": (1e-12,), "density": (1e15,), "radius": (1e-12,), "length": (1e-12, 1e6, 1e15)}
    for name, values in extremes.items():
        for value in values:
            with pytest.raises(ValueError, match=r"rod|segments|strain|radius|duration"):
                fr.simulate(ROD.replace(**{name: value}), fr.AxialLoad(1e-3, 1e-3, 1.0), duration=1e-4, frames=2)
    with pytest.raises(ValueError, match=r"indentation .* too extreme to be simulated \(.*\); check the units of Rod"):
        fr.simulate(ROD, fr.AxialLoad(1e-3, 1e-3, 1.0), duration=1e-4, frames=2, indentation=1e-300)
