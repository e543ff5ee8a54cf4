"""Stores of ensembles: continued where they were, shared by parts, read while they grow, damaged, foreign, full."""

from __future__ import annotations

import asyncio
import shutil
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import floquetrod as fr
from ensemble_cases import OVER, PROBLEM, assert_same, depth, in_memory, kills_at_150, script
from floquetrod.ensembles import Runs, stores, stores_disk, stores_zarr, workers
from floquetrod.simulation import checkpoints

KINDS = ("runs.npz", "runs.zarr")


@pytest.fixture(autouse=True)
def _saved_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stores, "_SECONDS_BETWEEN", 0.0)
    monkeypatch.setattr(stores, "_LONGER", 0.0)


class Stopped:
    """Progress that interrupts after a number of runs, and counts all."""

    def __init__(self, after: float = np.inf) -> None:
        self.after, self.calls = after, 0

    def __call__(self, done: int, total: int) -> None:
        """Count a call."""
        self.calls += 1
        if self.calls == self.after:
            raise KeyboardInterrupt


@pytest.mark.parametrize("kind", KINDS)
def test_a_store_continues_where_it_was(kind: str, tmp_path: Path) -> None:
    whole = fr.ensemble(PROBLEM, OVER, summary=depth, frames=True)
    place, made = tmp_path / kind, 0
    for after in (1, 9, 11):
        count = Stopped(after)
        found = fr.ensemble(PROBLEM, OVER, summary=depth, frames=True, store=place, progress=count)
        made += count.calls
        done = found.status.values == 1
        assert made <= done.sum() < 30
        assert np.array_equal(found.depth.values[done], whole.depth.values[done])
    count = Stopped()
    found = fr.ensemble(PROBLEM, OVER, summary=depth, frames=True, store=place, progress=count)
    assert_same(found, whole)
    assert made + count.calls <= 30  # those of the summary's names are made before
    again = Stopped()
    assert_same(fr.ensemble(PROBLEM, OVER, summary=depth, frames=True, store=place, progress=again), whole)
    assert again.calls == 0


@pytest.mark.parametrize("kind", KINDS)
def test_failures_stay_recorded(kind: str, tmp_path: Path) -> None:
    over = {"friction": [0.1, -1.0, 0.2]}
    first = fr.ensemble(PROBLEM, over, store=tmp_path / kind)
    count = Stopped()
    assert_same(fr.ensemble(PROBLEM, over, store=tmp_path / kind, progress=count), first)
    assert count.calls == 0
    assert "friction must be zero or more" in str(first.reason.values[1])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("changed", "match"),
    [
        ({"problem": PROBLEM.replace(friction=0.1)}, "another study, with another problem"),
        ({"over": {"seed": [1, 2, 4]}}, "another study, with another axes"),
        ({"over": {"friction": [1, 2, 3]}}, "another study, with another axes"),
        ({"layout": "list"}, "another study, with another axes"),
        ({"frames": True}, "another study, with another frames"),
        ({"summary": depth}, "another study, with another summary"),
    ],
)
def test_a_store_of_another_study_is_refused(kind: str, changed: dict[str, Any], match: str, tmp_path: Path) -> None:
    same: dict[str, Any] = {"problem": PROBLEM, "over": {"seed": [1, 2, 3]}, "store": tmp_path / kind}
    before = fr.ensemble(**same)
    with pytest.raises(ValueError, match=f"store .*{kind} holds {match}; give another path"):
        fr.ensemble(**(same | changed))
    assert_same(fr.ensemble(**same), before)


@pytest.mark.parametrize("kind", KINDS)
def test_another_version_is_refused(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fr.ensemble(PROBLEM, {"seed": [1]}, store=tmp_path / kind)
    other = checkpoints.arithmetic() | {"numba": "7.5"}
    monkeypatch.setattr(stores, "arithmetic", lambda: other)
    with pytest.raises(ValueError, match=r"was made with numba .*; continue it where that is installed"):
        fr.ensemble(PROBLEM, {"seed": [1]}, store=tmp_path / kind)


def test_another_summary_is_refused(tmp_path: Path) -> None:
    place = tmp_path / "runs.zarr"
    fr.ensemble(PROBLEM, OVER, store=place, summary=depth, progress=Stopped(5))
    with pytest.raises(ValueError, match="holds a summary of depth, early, got width"):
        fr.ensemble(PROBLEM, OVER, store=place, summary=lambda run: {"width": 1.0})
    with pytest.raises(ValueError, match="another study, with another summary"):
        fr.ensemble(PROBLEM, OVER, store=place)


def test_what_is_no_store_is_left_alone(tmp_path: Path) -> None:
    folder, file = tmp_path / "mine.zarr", tmp_path / "mine.npz"
    folder.mkdir()
    (folder / "notes").write_text("mine")
    np.savez(file, a=np.ones(3))
    xarray.Dataset({"a": ("x", [1.0])}).to_zarr(tmp_path / "other.zarr", zarr_format=2)
    for place in (folder, file, tmp_path / "other.zarr"):
        with pytest.raises(ValueError, match=r"is not one of fr\.ensemble|is not an ensemble that can be read"):
            fr.ensemble(PROBLEM, {"seed": [1]}, store=place)
    assert (folder / "notes").read_text() == "mine"


def test_a_zarr_store_is_an_ordinary_dataset(tmp_path: Path) -> None:
    place = tmp_path / "runs.zarr"
    found = fr.ensemble(PROBLEM, OVER, store=place, summary=depth, frames=True)
    for options in ({}, {"chunks": None}, {"consolidated": False}):
        read = xarray.open_zarr(place, **options)
        assert_same(read, found)
        assert read.status.dtype == np.int8
        assert read.attrs == found.attrs
        assert read.time_to_buckle.attrs["units"] == "s"


def test_parts_fill_one_store_at_once(tmp_path: Path) -> None:
    """Many jobs that start together, as those of an array do."""
    place, whole = tmp_path / "runs.zarr", fr.ensemble(PROBLEM, OVER)
    with ThreadPoolExecutor(12) as pool:
        jobs = [pool.submit(fr.ensemble, PROBLEM, OVER, store=place, part=(k, 12)) for k in range(1, 13)]
        for job in jobs:
            job.result()
    assert_same(fr.ensemble(PROBLEM, OVER, store=place), whole)
    assert not list(tmp_path.glob(".*"))


def test_a_second_reader_sees_whole_runs_while_a_store_grows(tmp_path: Path) -> None:
    place, whole, seen, wrong = tmp_path / "runs.zarr", fr.ensemble(PROBLEM, OVER, summary=depth), [], []

    def read() -> None:
        while not place.exists():
            pass
        while len(seen) < 1000 and (not seen or seen[-1] < 30):
            found = xarray.open_zarr(place, chunks=None)
            done = found.status.values == 1
            wrong.extend(n for n in ("depth", "buckled") if (found[n].values[done] != whole[n].values[done]).any())
            seen.append(int(done.sum()))

    reader = threading.Thread(target=read)
    reader.start()
    fr.ensemble(PROBLEM, OVER, store=place, summary=depth)
    reader.join()
    assert not wrong
    assert seen == sorted(seen)
    assert seen[-1] == 30


@pytest.mark.parametrize("damage", ["cut", "empty", "flip", "gone"])
@pytest.mark.parametrize("name", ["status", "largest_angle", "buckled", "positions"])
def test_damaged_chunks_are_computed_again(damage: str, name: str, tmp_path: Path) -> None:
    place, over = tmp_path / "runs.zarr", {"kick": [0.01, 0.02], "seed": range(4)}
    whole = fr.ensemble(PROBLEM, over, store=place, frames=True)
    file = sorted(path for path in (place / name).rglob("*") if path.is_file() and not path.name.startswith("."))[0]
    content = file.read_bytes()
    changed = {
        "cut": content[: len(content) // 2],
        "empty": b"",
        "flip": content[:-1] + bytes([content[-1] ^ 1]),
    }
    if damage == "gone":
        file.unlink()
    else:
        file.write_bytes(changed[damage])
    count = Stopped()
    found = fr.ensemble(PROBLEM, over, store=place, frames=True, progress=count)
    assert count.calls == (1 if name == "positions" else 8)
    assert_same(found, whole)


def test_a_full_disk_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place, whole = tmp_path / "runs.zarr", fr.ensemble(PROBLEM, OVER)
    replace, calls = stores_zarr.replace, []

    def full(path: Path, content: bytes) -> None:
        if place in path.parents:  # not while it is made, beside its place
            calls.append(path)
        if 3 <= len(calls) < 6:
            raise OSError(28, "No space left on device")
        replace(path, content)

    monkeypatch.setattr(stores_zarr, "replace", full)
    with pytest.warns(checkpoints.CheckpointWarning, match=r"runs\.zarr cannot be written \(No space left on device\)"):
        found = fr.ensemble(PROBLEM, OVER, store=place)
    assert_same(found, whole)
    assert_same(xarray.open_zarr(place), whole)
    calls[:] = [place] * 3
    with pytest.raises(ValueError, match=r"other\.zarr cannot be written: No space left on device"):
        fr.ensemble(PROBLEM, OVER, store=tmp_path / "other.zarr")
    assert not list(tmp_path.glob("*other*"))


def test_frames_that_cannot_be_written_are_pending_in_the_store(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place, replace = tmp_path / "runs.zarr", stores_zarr.replace

    def full(path: Path, content: bytes) -> None:
        if f"positions{'/'}3" in path.as_posix():
            raise OSError(28, "No space left on device")
        replace(path, content)

    with monkeypatch.context() as patched:
        patched.setattr(stores_zarr, "replace", full)
        with pytest.warns(checkpoints.CheckpointWarning, match="No space left"):
            found = fr.ensemble(PROBLEM, {"seed": range(5)}, store=place, frames=True)
    whole = fr.ensemble(PROBLEM, {"seed": range(5)}, frames=True)
    assert_same(found, whole)
    assert xarray.open_zarr(place).status.values.tolist() == [1, 1, 1, 0, 1]
    count = Stopped()
    assert_same(fr.ensemble(PROBLEM, {"seed": range(5)}, store=place, frames=True, progress=count), whole)
    assert count.calls == 1


@pytest.mark.parametrize("frames", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_a_disk_that_stays_full_costs_one_warning_and_no_results(
    kind: str, frames: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place, whole = tmp_path / kind, fr.ensemble(PROBLEM, OVER, frames=frames)

    def full(*arguments: Any, **options: Any) -> None:
        raise OSError(28, "No space left on device")

    def fill(done: int, total: int) -> None:
        monkeypatch.setattr(stores_zarr, "replace", full)
        monkeypatch.setattr(Runs, "save", full)

    with pytest.warns(checkpoints.CheckpointWarning, match="the same arguments") as heard:
        found = fr.ensemble(PROBLEM, OVER, frames=frames, store=place, progress=fill)
    assert len(heard) == 1
    assert_same(found, whole)
    monkeypatch.undo()
    count = Stopped()
    assert_same(fr.ensemble(PROBLEM, OVER, frames=frames, store=place, progress=count), whole)
    assert count.calls >= 29


def test_frames_that_neither_disk_nor_memory_holds_cost_no_other_results(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place, whole = tmp_path / "runs.zarr", fr.ensemble(PROBLEM, OVER)
    replace = stores_zarr.replace

    def full(path: Path, content: bytes) -> None:
        if "positions" in path.parts:
            raise OSError(28, "No space left on device")
        replace(path, content)

    monkeypatch.setattr(stores_zarr, "replace", full)
    monkeypatch.setattr(stores, "MOST_MEMORY", 40_000)  # the frames of four runs
    with pytest.warns(checkpoints.CheckpointWarning) as heard:
        found = fr.ensemble(PROBLEM, OVER, frames=True, store=place)
    assert len(heard) == 1
    assert np.isnan(found.positions).all()
    assert_same(found.drop_vars(["time", "angle", "positions"]), whole)
    assert (xarray.open_zarr(place).status == 0).all()


@pytest.mark.parametrize("frames", [False, True])
@pytest.mark.parametrize("damage", ["gone", "empty", "flip", "another"])
@pytest.mark.parametrize("name", list(OVER))
def test_damaged_coordinates_are_written_again(name: str, damage: str, frames: bool, tmp_path: Path) -> None:
    place, over = tmp_path / "runs.zarr", {"frequency": [120.0], "kick": [0.01], "seed": [4]}
    whole = fr.ensemble(PROBLEM, over, store=place, frames=frames)
    file = place / name / "0"
    content = file.read_bytes()
    if damage == "gone":
        file.unlink()
    elif damage == "another":
        file.write_bytes((place / ("kick" if name != "kick" else "frequency") / "0").read_bytes())
    else:
        file.write_bytes(b"" if damage == "empty" else content[:-1] + bytes([content[-1] ^ 1]))
    assert_same(fr.ensemble(PROBLEM, over, store=place, frames=frames), whole)
    assert file.read_bytes() == content
    assert_same(xarray.open_zarr(place), whole)


@pytest.mark.parametrize("damage", ["gone", "cut", "foreign"])
@pytest.mark.parametrize("name", ["kick/.zarray", "kick/.zattrs", "buckled/.zarray", "angle/.zattrs", "angle/.zarray"])
def test_damaged_metadata_is_written_again(name: str, damage: str, tmp_path: Path) -> None:
    place, over = tmp_path / "runs.zarr", {"kick": [0.01, 0.02]}
    whole = fr.ensemble(PROBLEM, over, store=place, frames=True)
    file = place / name
    content = file.read_bytes()
    if damage == "gone":
        file.unlink()
    else:
        file.write_bytes(content[1:] if damage == "cut" else b"{}")
    assert_same(fr.ensemble(PROBLEM, over, store=place, frames=True), whole)
    assert file.read_bytes() == content
    assert_same(xarray.open_zarr(place, consolidated=False), whole)


def failing_once(*errors: Exception) -> Callable[[fr.Simulation], dict[str, float]]:
    """Return a summary that raises each of these errors once, for the seeds from 1 on."""
    left = dict(enumerate(errors, 1))

    def summary(run: fr.Simulation) -> dict[str, float]:
        error = left.pop(run.problem.perturbation.noises[0][1], None)
        if error is not None:
            raise error
        return {"one": 1.0}

    return summary


PASSING = (
    MemoryError(),
    np._core._exceptions._ArrayMemoryError((9,), np.dtype(float)),
    FileNotFoundError(2, "gone"),
    shutil.Error("x"),
    socket.gaierror("no name"),
)


@pytest.mark.parametrize("kind", KINDS)
def test_runs_that_failed_for_what_passes_are_made_again(kind: str, tmp_path: Path) -> None:
    place, over = tmp_path / kind, {"seed": range(8)}
    whole = fr.ensemble(PROBLEM, over, summary=failing_once())
    summary = failing_once(*PASSING, ValueError("its own"))
    first = fr.ensemble(PROBLEM, over, store=place, summary=summary)
    assert first.status.values.tolist() == [1, 2, 2, 2, 2, 2, 2, 1]
    count = Stopped()
    same = fr.ensemble(PROBLEM, over, store=place, summary=summary, retry_failed=False, progress=count)
    assert_same(same, first)
    assert count.calls == 0
    again = fr.ensemble(PROBLEM, over, store=place, summary=summary, progress=count)
    assert count.calls == 5
    assert again.status.values.tolist() == [1, 1, 1, 1, 1, 1, 2, 1]
    assert again.reason.values.tolist() == [*[""] * 6, "ValueError: its own", ""]
    read = Runs.load(place) if kind.endswith("npz") else xarray.open_zarr(place)
    assert_same(read, again)
    assert_same(again.isel(seed=slice(6)), whole.isel(seed=slice(6)))


def test_runs_whose_workers_died_are_made_again(tmp_path: Path) -> None:
    place, reason = tmp_path / "runs.npz", "its worker process died 3 times: killed, or out of memory"
    found = in_memory(fr.ensemble(PROBLEM, {"seed": range(3)}, store=place))
    found["status"][1] = 2
    found.variables["reason"] = found.variables["reason"]._replace(values=np.array(["", reason, ""]))
    found.save(place)
    again = fr.ensemble(PROBLEM, {"seed": range(3)}, store=place)
    assert again.status.values.tolist() == [1, 1, 1]
    assert again.reason.values.tolist() == ["", "", ""]


def test_a_run_whose_reason_is_lost_is_made_again(tmp_path: Path) -> None:
    place, over = tmp_path / "runs.zarr", {"friction": [0.1, -1.0]}
    whole = fr.ensemble(PROBLEM, over, store=place)
    (place / "reason" / "0").unlink()
    assert_same(fr.ensemble(PROBLEM, over, store=place), whole)
    assert_same(xarray.open_zarr(place), whole)


@pytest.mark.parametrize("kind", KINDS)
def test_a_store_that_a_living_process_fills_is_refused(kind: str, tmp_path: Path) -> None:
    """Even if it does nothing for long, as a process that has been stopped; one that was killed hinders nobody."""
    place = tmp_path / kind
    body = (
        "def wait(done, total):\n"
        "    if done == 9:\n"
        "        print('waits', flush=True)\n"
        "        sys.stdin.read()\n"
        "fr.ensemble(PROBLEM, OVER, store=sys.argv[1], progress=wait)\n"
    )
    with script(body, place, stdin=-1, stdout=-1) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "waits\n"
        with pytest.raises(ValueError, match=rf"store .*{kind} is being filled by another process"):
            fr.ensemble(PROBLEM, OVER, store=place)
        other.kill()
    count = Stopped()
    assert_same(fr.ensemble(PROBLEM, OVER, store=place, progress=count), fr.ensemble(PROBLEM, OVER))
    assert count.calls < 30
    assert not list(tmp_path.glob(".*"))


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere locks belong to the process")
@pytest.mark.parametrize("kind", KINDS)
def test_a_store_that_this_process_fills_is_refused(kind: str, tmp_path: Path) -> None:
    refused = []

    def fill(done: int, total: int) -> None:
        with pytest.raises(ValueError, match="is being filled by another process, or another thread"):
            fr.ensemble(PROBLEM, OVER, store=tmp_path / kind)
        refused.append(done)

    found = fr.ensemble(PROBLEM, OVER, store=tmp_path / kind, progress=fill)
    assert len(refused) == 30
    assert_same(found, fr.ensemble(PROBLEM, OVER))


def unlocked(*arguments: Any, **options: Any) -> None:
    """Stand for a lock on a file system that has none."""
    raise OSError(37, "No locks available")


def test_without_locks_a_finished_file_is_taken_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place, whole = tmp_path / "runs.npz", fr.ensemble(PROBLEM, OVER)
    monkeypatch.setattr(stores_disk, "Lock", unlocked)

    def finish(done: int, total: int) -> None:
        if done == 5:
            assert_same(fr.ensemble(PROBLEM, OVER, store=place), whole)
        if done == 8:
            raise KeyboardInterrupt

    with pytest.warns(checkpoints.CheckpointWarning, match=r"cannot be locked \(No locks available\): make sure"):
        found = fr.ensemble(PROBLEM, OVER, store=place, progress=finish)
    assert_same(found, whole)
    assert_same(Runs.load(place), whole)


def test_a_file_of_another_study_that_appears_meanwhile_is_left_alone(tmp_path: Path) -> None:
    place, other = tmp_path / "runs.npz", tmp_path / "other.npz"
    fr.ensemble(PROBLEM, {"seed": [7]}, store=other)
    content = other.read_bytes()

    def move(done: int, total: int) -> None:
        if done == 5:
            other.replace(place)

    with pytest.warns(checkpoints.CheckpointWarning, match="cannot be written .*holds another study") as heard:
        found = fr.ensemble(PROBLEM, OVER, store=place, progress=move)
    assert len(heard) == 1
    assert_same(found, fr.ensemble(PROBLEM, OVER))
    assert place.read_bytes() == content


def test_ctrl_c_while_a_store_is_made_leaves_nothing_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from zarr.storage import LocalStore

    place, put, replace, written = tmp_path / "runs.zarr", LocalStore.set, stores_zarr.replace, []

    def interrupts() -> bool:
        written.append(len(written))
        if len(written) == 3:
            signal.raise_signal(signal.SIGINT)
        return len(written) == 3

    async def by_zarr(self: Any, key: str, value: Any) -> None:
        if interrupts():
            await asyncio.sleep(0.5)  # in a thread of zarr's: until the main thread has heard of it
        await put(self, key, value)

    def by_us(path: Path, content: bytes) -> None:
        interrupts()
        replace(path, content)

    monkeypatch.setattr(LocalStore, "set", by_zarr)
    monkeypatch.setattr(stores_zarr, "replace", by_us)
    with pytest.raises(KeyboardInterrupt):
        fr.ensemble(PROBLEM, OVER, store=place)
    time.sleep(1.0)
    assert [path.name for path in tmp_path.iterdir()] == ["runs.zarr"]
    assert_same(fr.ensemble(PROBLEM, OVER, store=place), fr.ensemble(PROBLEM, OVER))


def test_a_store_that_another_process_fills_is_refused(tmp_path: Path) -> None:
    place = tmp_path / "runs.zarr"
    fr.ensemble(PROBLEM, OVER, store=place, part=(1, 2))
    fcntl = pytest.importorskip("fcntl")
    assert fcntl
    other = script(
        "import fcntl\n"
        "file = open(sys.argv[1], 'r+b')\n"
        "fcntl.lockf(file, fcntl.LOCK_EX)\n"
        "print('locked', flush=True)\n"
        "sys.stdin.read()",
        place / "status" / ".lock",
        stdin=-1,
        stdout=-1,
    )
    with other:
        assert other.stdout is not None
        assert other.stdout.readline() == "locked\n"
        with pytest.raises(ValueError, match="is being filled by another process"):
            fr.ensemble(PROBLEM, OVER, store=place, part=(2, 2))
        other.communicate("")
    assert (fr.ensemble(PROBLEM, OVER, store=place, part=(2, 2)).status == 1).all()


def test_parts_of_other_sizes_share_a_store(tmp_path: Path) -> None:
    place = tmp_path / "runs.zarr"
    fr.ensemble(PROBLEM, OVER, store=place, part=(1, 3))
    for k in range(1, 6):
        found = fr.ensemble(PROBLEM, OVER, store=place, part=(k, 5))
    assert_same(found, fr.ensemble(PROBLEM, OVER))


def test_an_npz_store_is_runs(tmp_path: Path) -> None:
    found = fr.ensemble(PROBLEM, OVER, store=tmp_path / "runs.npz")
    assert_same(Runs.load(tmp_path / "runs.npz"), found)


def test_too_many_frames_for_memory_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stores, "MOST_MEMORY", 10_000)
    monkeypatch.setattr(workers, "carry_out", None)
    with pytest.raises(ValueError, match=r"bytes of memory, at most 10,000; give a store that ends in \.zarr"):
        fr.ensemble(PROBLEM, OVER, frames=True)


def test_a_store_continues_where_only_runs_are_left_that_fail(tmp_path: Path) -> None:
    place, over = tmp_path / "runs.zarr", {"friction": [0.1, -1.0]}
    fr.ensemble(PROBLEM, over, store=place, summary=depth, part=(1, 2))
    assert fr.ensemble(PROBLEM, over, store=place, summary=depth).status.values.tolist() == [1, 2]


def test_a_run_that_kills_its_workers_does_not_kill_who_resumes(tmp_path: Path) -> None:
    place, over = tmp_path / "runs.npz", {"frequency": [120.0, 150.0]}
    found = in_memory(fr.ensemble(PROBLEM, over, store=place, summary=lambda run: {"one": 1.0}))
    found["status"][1] = 2
    reason = np.array(["", "its worker process died 3 times: killed, or out of memory"])
    found.variables["reason"] = found.variables["reason"]._replace(values=reason)
    found.save(place)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(workers, "_DEATHS", 1)
        again = fr.ensemble(PROBLEM, over, store=place, summary=kills_at_150, workers=1)
    assert again.status.values.tolist() == [1, 2]
    with pytest.raises(ValueError, match="holds a summary of one, got two"):
        fr.ensemble(PROBLEM, over, store=place, summary=lambda run: {"two": 1.0})
