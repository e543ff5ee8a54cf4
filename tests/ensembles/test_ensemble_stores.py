"""Stores of ensembles: continued where they were, shared by parts, read while they grow, foreign, being filled."""

from __future__ import annotations

import asyncio
import signal
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import floquetrod as fr
from floquetrod.ensembles import Runs, stores_disk, stores_zarr, workers
from floquetrod.simulation import checkpoints
from floquetrod.simulation.arithmetic import arithmetic
from tests.ensemble_cases import OVER, PROBLEM, RUNS, Stopped, assert_same, depth, script, stored, undisturbed
from tests.seams import Tuned

KINDS = ("runs.npz", "runs.zarr")


@pytest.fixture(autouse=True)
def _saved_at_once(tuned: Tuned) -> None:
    tuned(seconds_between_saves_of_stores=0.0, durations_between_saves_of_stores=0.0)


@pytest.mark.parametrize("kind", ["runs.npz", pytest.param("runs.zarr", marks=pytest.mark.slow)])
def test_a_store_continues_where_it_was(kind: str, tmp_path: Path) -> None:
    whole = undisturbed(depth, frames=True)
    place, made = tmp_path / kind, 0
    for after in (1, 2, 4):
        count = Stopped(after)
        found = fr.ensemble(PROBLEM, OVER, summary=depth, frames=True, store=place, progress=count)
        made += count.calls
        done = found.status.values == 1
        assert made <= done.sum() < RUNS
        assert np.array_equal(found.depth.values[done], whole.depth.values[done])
    count = Stopped()
    found = fr.ensemble(PROBLEM, OVER, summary=depth, frames=True, store=place, progress=count)
    assert_same(found, whole)
    assert made + count.calls <= RUNS  # those of the summary's names are made before
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


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("changed", "match"),
    [
        ({"problem": PROBLEM.replace(friction=0.1)}, "another study: friction .* there, 0.1 here; give"),
        ({"over": {"seed": [1, 2, 4]}}, "another study: it has other values of seed; give"),
        ({"over": {"friction": [1, 2, 3]}}, "another study: it varies seed, and this one friction; give"),
        ({"layout": "list"}, "another study: it combines them in another layout, grid or list; give"),
        ({"frames": True}, "another study: frames False there, True here; give"),
        ({"summary": depth}, "another study, with another summary"),
    ],
)
def test_a_store_of_another_study_is_refused(kind: str, changed: dict[str, Any], match: str, tmp_path: Path) -> None:
    same: dict[str, Any] = {"problem": PROBLEM, "over": {"seed": [1, 2, 3]}, "store": tmp_path / kind}
    before = fr.ensemble(**same)
    with pytest.raises(ValueError, match=f"store .*{kind} holds {match}.* another path"):
        fr.ensemble(**(same | changed))
    assert_same(fr.ensemble(**same), before)


@pytest.mark.parametrize("kind", KINDS)
def test_another_version_is_refused(kind: str, tmp_path: Path, tuned: Tuned) -> None:
    fr.ensemble(PROBLEM, {"seed": [1]}, store=tmp_path / kind)
    other = arithmetic() | {"numba": "7.5"}
    tuned(arithmetic_of_stores=lambda: other)
    with pytest.raises(ValueError, match=r"was made with numba .*; continue it where that is installed"):
        fr.ensemble(PROBLEM, {"seed": [1]}, store=tmp_path / kind)


@pytest.mark.slow
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


@pytest.mark.slow
def test_a_zarr_store_is_an_ordinary_dataset(tmp_path: Path) -> None:
    place = tmp_path / "runs.zarr"
    found = fr.ensemble(PROBLEM, OVER, store=place, summary=depth, frames=True)
    for options in ({}, {"chunks": None}, {"consolidated": False}):
        read = xarray.open_zarr(place, **options)
        assert_same(read, found)
        assert read.status.dtype == np.int8
        assert read.attrs == found.attrs
        assert read.time_to_buckle.attrs["units"] == "s"


@pytest.mark.slow
def test_parts_fill_one_store_at_once(tmp_path: Path) -> None:
    """Many jobs that start together, as those of an array do."""
    place, whole = tmp_path / "runs.zarr", undisturbed()
    with ThreadPoolExecutor(6) as pool:
        jobs = [pool.submit(fr.ensemble, PROBLEM, OVER, store=place, part=(k, 6)) for k in range(1, 7)]
        for job in jobs:
            job.result()
    assert_same(fr.ensemble(PROBLEM, OVER, store=place), whole)
    assert not list(tmp_path.glob(".*"))


@pytest.mark.slow
def test_a_second_reader_sees_whole_runs_while_a_store_grows(tmp_path: Path) -> None:
    place, whole, seen, wrong = tmp_path / "runs.zarr", undisturbed(depth), [], []
    begun, read_once, finished = (threading.Event() for _ in range(3))

    def read() -> None:
        begun.wait()
        last = False
        while not last:
            last = finished.is_set()
            found = xarray.open_zarr(place, chunks=None)
            done = found.status.values == 1
            wrong.extend(n for n in ("depth", "buckled") if (found[n].values[done] != whole[n].values[done]).any())
            seen.append(int(done.sum()))
            read_once.set()

    def shown(done: int, total: int) -> None:
        if done == 5:  # some runs are stored by now, and the others wait for the reader
            begun.set()
            read_once.wait()

    reader = threading.Thread(target=read)
    reader.start()
    try:
        fr.ensemble(PROBLEM, OVER, store=place, summary=depth, progress=shown)
    finally:
        begun.set()
        finished.set()
        reader.join()
    assert not wrong
    assert seen == sorted(seen)
    assert seen[0] < RUNS
    assert seen[-1] == RUNS


@pytest.mark.slow
def test_a_store_that_a_living_process_fills_is_refused(tmp_path: Path) -> None:
    """Even if it does nothing for long, as a process that has been stopped; one that was killed hinders nobody."""
    places = [tmp_path / kind for kind in KINDS]
    body = (
        "def wait(done, total):\n"
        "    if done == 9:\n"
        "        print('waits', flush=True)\n"
        "        sys.stdin.read()\n"
        "def other(done, total):\n"
        "    if done == 9:\n"
        "        fr.ensemble(PROBLEM, OVER, store=sys.argv[2], progress=wait)\n"
        "fr.ensemble(PROBLEM, OVER, store=sys.argv[1], progress=other)\n"
    )
    with script(body, *places, stdin=-1, stdout=-1) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "waits\n"
        for place in places:
            with pytest.raises(ValueError, match=rf"store .*{place.name} is being filled by another process"):
                fr.ensemble(PROBLEM, OVER, store=place)
        other.kill()
    for place in places:
        count = Stopped()
        assert_same(fr.ensemble(PROBLEM, OVER, store=place, progress=count), undisturbed())
        assert count.calls < RUNS
    assert not list(tmp_path.glob(".*"))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere locks belong to the process")
@pytest.mark.parametrize("kind", KINDS)
def test_a_store_that_this_process_fills_is_refused(kind: str, tmp_path: Path) -> None:
    refused = []

    def fill(done: int, total: int) -> None:
        with pytest.raises(ValueError, match="is being filled by another process, or another thread"):
            fr.ensemble(PROBLEM, OVER, store=tmp_path / kind)
        refused.append(done)

    found = fr.ensemble(PROBLEM, OVER, store=tmp_path / kind, progress=fill)
    assert len(refused) == RUNS
    assert_same(found, undisturbed())


def unlocked(*arguments: Any, **options: Any) -> None:
    """Stand for a lock on a file system that has none."""
    raise OSError(37, "No locks available")


@pytest.mark.slow
def test_without_locks_a_finished_file_is_taken_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place, whole = tmp_path / "runs.npz", undisturbed()
    monkeypatch.setattr(stores_disk, "lock_beside", unlocked)

    def finish(done: int, total: int) -> None:
        if done == 5:
            assert_same(fr.ensemble(PROBLEM, OVER, store=place), whole)
        if done == 8:
            raise KeyboardInterrupt

    with pytest.warns(checkpoints.CheckpointWarning, match=r"cannot be locked \(No locks available\): make sure"):
        found = fr.ensemble(PROBLEM, OVER, store=place, progress=finish)
    assert_same(found, whole)
    assert_same(Runs.load(place), whole)


@pytest.mark.slow
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
    assert_same(found, undisturbed())
    assert place.read_bytes() == content


@pytest.mark.slow
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
    assert_same(fr.ensemble(PROBLEM, OVER, store=place), undisturbed())


@pytest.mark.slow
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


@pytest.mark.slow
def test_parts_of_other_sizes_share_a_store(tmp_path: Path) -> None:
    place = tmp_path / "runs.zarr"
    fr.ensemble(PROBLEM, OVER, store=place, part=(1, 3))
    for k in range(1, 6):
        found = fr.ensemble(PROBLEM, OVER, store=place, part=(k, 5))
    assert_same(found, undisturbed())


def test_an_npz_store_is_runs(tmp_path: Path) -> None:
    found = fr.ensemble(PROBLEM, OVER, store=tmp_path / "runs.npz")
    assert_same(Runs.load(tmp_path / "runs.npz"), found)


def test_too_many_frames_for_memory_are_refused(monkeypatch: pytest.MonkeyPatch, tuned: Tuned) -> None:
    tuned(bytes_of_frames_in_memory=10_000)
    monkeypatch.setattr(workers, "simulate_runs", None)
    with pytest.raises(ValueError, match=r"bytes of memory, at most 10,000; give a store that ends in \.zarr"):
        fr.ensemble(PROBLEM, OVER, frames=True)


def test_a_store_continues_where_only_runs_are_left_that_fail(tmp_path: Path) -> None:
    place, over = tmp_path / "runs.zarr", {"friction": [0.1, -1.0]}
    fr.ensemble(PROBLEM, over, store=place, summary=depth, part=(1, 2))
    assert fr.ensemble(PROBLEM, over, store=place, summary=depth).status.values.tolist() == [1, 2]


@pytest.mark.parametrize(
    ("name", "damage"),
    [
        # Each array and each damage once, and all to all under `make slow`.
        pytest.param(name, damage, marks=[pytest.mark.slow] * (i != (k + 2) % 4))
        for i, name in enumerate(["status", "largest_angle", "buckled", "positions"])
        for k, damage in enumerate(["cut", "empty", "flip", "gone"])
    ],
)
def test_damaged_chunks_are_computed_again(name: str, damage: str, tmp_path: Path) -> None:
    place, over = tmp_path / "runs.zarr", {"kick": [0.01, 0.02], "seed": range(2)}
    whole = stored(place, over, frames=True)
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
    assert count.calls == (1 if name == "positions" else 4)
    assert_same(found, whole)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    ["positions", *(pytest.param(name, marks=pytest.mark.slow) for name in ("status", "largest_angle", "buckled"))],
)
def test_chunks_that_change_places_are_computed_again(name: str, tmp_path: Path) -> None:
    """Within a store, and with the same chunk of a store of another study."""
    over, place, other = {"kick": [0.01, 0.05], "seed": range(2)}, tmp_path / "runs.zarr", tmp_path / "other.zarr"
    for k in range(1, 5):  # parts make chunks of one run each
        whole = fr.ensemble(PROBLEM, over, store=place, frames=True, part=(k, 4)).load()
    for k in range(1, 5):
        fr.ensemble(PROBLEM.replace(friction=0.3), over, store=other, frames=True, part=(k, 4))
    files = sorted(path for path in (place / name).rglob("*") if path.is_file() and not path.name.startswith("."))
    assert len(files) == 4
    first, last = files[0].read_bytes(), files[-1].read_bytes()
    files[0].write_bytes(last)
    files[-1].write_bytes(first)
    count = Stopped()
    assert_same(fr.ensemble(PROBLEM, over, store=place, frames=True, progress=count), whole)
    assert count.calls == 2
    files[1].write_bytes((other / files[1].relative_to(place)).read_bytes())
    count = Stopped()
    assert_same(fr.ensemble(PROBLEM, over, store=place, frames=True, progress=count), whole)
    assert count.calls == 1
    assert_same(xarray.open_zarr(place), whole)
