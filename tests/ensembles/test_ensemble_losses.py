"""What stores of ensembles survive: full disks, damaged files, and failures of runs that pass."""

from __future__ import annotations

import json
import shutil
import socket
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import floquetrod as fr
from floquetrod.ensembles import Runs, stores_zarr, workers
from floquetrod.simulation import checkpoints
from tests.ensemble_cases import (
    OVER,
    PROBLEM,
    RUNS,
    Stopped,
    assert_same,
    depth,
    in_memory,
    kills_at_150,
    stored,
    undisturbed,
)
from tests.seams import Tuned

KINDS = ("runs.npz", "runs.zarr")


@pytest.fixture(autouse=True)
def _saved_at_once(tuned: Tuned) -> None:
    tuned(seconds_between_saves_of_stores=0.0, durations_between_saves_of_stores=0.0)


def test_a_full_disk_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place, whole = tmp_path / "runs.zarr", undisturbed()
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


@pytest.mark.slow
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


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "frames"),
    [
        pytest.param(kind, frames, marks=[pytest.mark.slow] * (frames == (kind == KINDS[0])))
        for kind in KINDS
        for frames in (False, True)
    ],
)
def test_a_disk_that_stays_full_costs_one_warning_and_no_results(
    kind: str, frames: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place, whole = tmp_path / kind, undisturbed(frames=frames)

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
    assert count.calls >= RUNS - 1


@pytest.mark.slow
def test_frames_that_neither_disk_nor_memory_holds_cost_no_other_results(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tuned: Tuned
) -> None:
    place, whole = tmp_path / "runs.zarr", undisturbed()
    replace = stores_zarr.replace

    def full(path: Path, content: bytes) -> None:
        if "positions" in path.parts and not path.name.startswith("."):  # metadata
            raise OSError(28, "No space left on device")
        replace(path, content)

    monkeypatch.setattr(stores_zarr, "replace", full)
    tuned(bytes_of_frames_in_memory=40_000)  # the frames of four runs
    with pytest.warns(checkpoints.CheckpointWarning) as heard:
        found = fr.ensemble(PROBLEM, OVER, frames=True, store=place)
    assert len(heard) == 1
    assert np.isnan(found.positions).all()
    assert_same(found.drop_vars(["time", "angle", "positions"]), whole)
    assert (xarray.open_zarr(place).status == 0).all()


@pytest.mark.parametrize("frames", [False, pytest.param(True, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("name", "damage"),
    [
        # Each of both at least once, and all of one with all of the other under `make slow`.
        pytest.param(name, damage, marks=[pytest.mark.slow] * (i != k % len(OVER)))
        for i, name in enumerate(OVER)
        for k, damage in enumerate(["gone", "empty", "flip", "another"])
    ],
)
def test_damaged_coordinates_are_written_again(name: str, damage: str, frames: bool, tmp_path: Path) -> None:
    place, over = tmp_path / "runs.zarr", {"frequency": [120.0], "kick": [0.01], "seed": [4]}
    whole = stored(place, over, frames=frames)
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


@pytest.mark.parametrize(
    ("name", "damage"),
    [
        # Each damage once, and each to all under `make slow`.
        pytest.param(name, damage, marks=[pytest.mark.slow] * (i != k + 2))
        for i, name in enumerate(["kick/.zarray", "kick/.zattrs", "buckled/.zarray", "angle/.zattrs", "angle/.zarray"])
        for k, damage in enumerate(["gone", "cut", "foreign"])
    ],
)
def test_damaged_metadata_is_written_again(name: str, damage: str, tmp_path: Path) -> None:
    place, over = tmp_path / "runs.zarr", {"kick": [0.01, 0.02]}
    whole = stored(place, over, frames=True)
    file = place / name
    content = file.read_bytes()
    if damage == "gone":
        file.unlink()
    else:
        file.write_bytes(content[1:] if damage == "cut" else b"{}")
    assert_same(fr.ensemble(PROBLEM, over, store=place, frames=True), whole)
    assert file.read_bytes() == content
    assert_same(xarray.open_zarr(place, consolidated=False), whole)


@pytest.mark.parametrize(
    ("old", "new"),
    [("3", "9"), *(pytest.param(*each, marks=pytest.mark.slow) for each in (("5", "4"), ("2", "1"), ("3", "0")))],
)
def test_a_store_whose_chunks_are_damaged_is_refused(old: str, new: str, tmp_path: Path) -> None:
    place, over = tmp_path / "runs.zarr", {**OVER, "seed": range(5)}
    fr.ensemble(PROBLEM, over, store=place, progress=Stopped(1))
    (place / ".zmetadata").unlink()
    file = place / "status" / ".zarray"
    before, found, after = file.read_text().partition('"chunks": [')
    file.write_text(before + found + after.replace(old, new, 1))
    if (old, new) == ("2", "1"):  # ranges of runs, too
        assert_same(fr.ensemble(PROBLEM, over, store=place), fr.ensemble(PROBLEM, over))
        return
    with pytest.raises(ValueError, match=r"has damaged metadata|is not one of fr\.ensemble"):
        fr.ensemble(PROBLEM, over, store=place)


@pytest.mark.parametrize("kind", KINDS)
def test_a_store_of_an_earlier_version_is_read_and_not_continued(kind: str, tmp_path: Path, tuned: Tuned) -> None:
    """`data/ensembles.zip` has stores that commit 8ea4ce4 left when it was interrupted after four of six runs."""
    with zipfile.ZipFile(Path(__file__).parents[1] / "data" / "ensembles.zip") as archive:
        archive.extractall(tmp_path)
    place, problem = tmp_path / kind, PROBLEM.replace(frames=2)
    content = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    before = Runs.load(place) if kind.endswith("npz") else in_memory(xarray.open_zarr(place))
    assert np.bincount(before["status"].ravel()).tolist() == [2, 2, 2]
    assert fr.ensembles.probability(before, over="seed")["done"].tolist() == [2, 0]
    made_with = json.loads(before.attrs["study"])["arithmetic"]
    tuned(arithmetic_of_stores=lambda: made_with)  # another version of numba is another study
    with pytest.raises(ValueError, match=r"another rule for which rods have buckled; it can be read, .* another path"):
        fr.ensemble(problem, {"friction": [0.1, -1.0], "seed": range(3)}, store=place, summary=depth, frames=True)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == content


def failing_once(*errors: Exception) -> Callable[[fr.Simulation], dict[str, float]]:
    """Return a summary that raises each of these errors once, for the seeds from 1 on."""
    left = dict(enumerate(errors, 1))

    def summary(run: fr.Simulation) -> dict[str, float]:
        error = left.pop(run.problem.perturbation.noises[0][1], None)
        if error is not None:
            raise error
        return {"one": 1.0}

    return summary


def _memory_error() -> MemoryError:
    """Return numpy's own, which is raised for arrays that memory does not hold."""
    with pytest.raises(MemoryError) as caught:
        np.empty(1 << 60, dtype=np.int8)
    assert type(caught.value) is not MemoryError
    return caught.value


PASSING = (
    MemoryError(),
    _memory_error(),
    FileNotFoundError(2, "gone"),
    shutil.Error("x"),
    socket.gaierror("no name"),
)


@pytest.mark.slow
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


@pytest.mark.slow
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
