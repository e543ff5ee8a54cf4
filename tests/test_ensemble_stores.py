"""Stores of ensembles: continued where they were, shared by parts, read while they grow, damaged, foreign, full."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import floquetrod as fr
from ensemble_cases import OVER, PROBLEM, assert_same, depth
from floquetrod.ensembles import Runs, stores, stores_zarr, workers
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
        if done == 10:  # some runs are stored by now, and the others wait for the reader
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
    assert seen[0] < 30
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
        calls.append(path)
        if 3 <= len(calls) < 6:
            raise OSError(28, "No space left on device")
        replace(path, content)

    monkeypatch.setattr(stores_zarr, "replace", full)
    with pytest.warns(checkpoints.CheckpointWarning, match=r"runs\.zarr cannot be written \(No space left on device\)"):
        found = fr.ensemble(PROBLEM, OVER, store=place)
    assert_same(found, whole)
    assert_same(xarray.open_zarr(place), whole)
    calls[:] = [place, place]
    with pytest.raises(ValueError, match=r"other\.zarr cannot be written: No space left on device"):
        fr.ensemble(PROBLEM, OVER, store=tmp_path / "other.zarr")
    assert not list(tmp_path.glob("*other*"))


def test_frames_that_cannot_be_written_stay_pending(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place, replace = tmp_path / "runs.zarr", stores_zarr.replace

    def full(path: Path, content: bytes) -> None:
        if f"positions{'/'}3" in path.as_posix():
            raise OSError(28, "No space left on device")
        replace(path, content)

    with monkeypatch.context() as patched:
        patched.setattr(stores_zarr, "replace", full)
        with pytest.warns(checkpoints.CheckpointWarning, match="No space left"):
            found = fr.ensemble(PROBLEM, {"seed": range(5)}, store=place, frames=True)
    assert found.status.values.tolist() == [1, 1, 1, 0, 1]
    assert_same(
        fr.ensemble(PROBLEM, {"seed": range(5)}, store=place, frames=True),
        fr.ensemble(PROBLEM, {"seed": range(5)}, frames=True),
    )


def test_a_store_that_another_process_fills_is_refused(tmp_path: Path) -> None:
    from ensemble_cases import script

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
    monkeypatch.setattr(stores, "_MOST_MEMORY", 10_000)
    monkeypatch.setattr(workers, "carry_out", None)
    with pytest.raises(ValueError, match=r"bytes of memory, at most 10,000; give a store that ends in \.zarr"):
        fr.ensemble(PROBLEM, OVER, frames=True)
