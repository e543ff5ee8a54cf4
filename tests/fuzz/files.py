"""Damaged charts, simulations, ensembles and checkpoints: a ValueError, or what the file held before, to the bit.

Files of systems have no checksum, so that people can write them: of those, a ValueError or any system.
"""

from __future__ import annotations

import functools
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray

import floquetrod as fr
from floquetrod.ensembles import Runs
from floquetrod.ensembles.runs import require_runs
from floquetrod.equations.system_files import read_system
from tests.fuzz import runs
from tests.fuzz.calls import SYSTEM, folder, oscillators, system_files
from tests.fuzz.core import Found, TookTooLong, limit, told

CASES = 300
QUICK = 50

_IDENTITY = (".zmetadata", ".zattrs", ".zgroup", ".zarray")
"""Files without which a store may not be known for the one that it is."""
_STORED = {"kick": [0.01, 0.2], "friction": [0.1, 0.2, -1.0]}


class Kind(NamedTuple):
    """A file as it should be, how it is read, what it holds, and whether damage to what it holds is noticed."""

    path: Path
    read: Callable[[Path], Any]
    content: Any
    checked: bool = True


@functools.cache
def kinds() -> tuple[Kind, ...]:
    """Return one file of each kind; the checkpoint is of a run under way."""
    place = folder()
    chart = fr.mathieu.chart((0.0, 1.0, 9), (-1.0, 0.2, 8), growth=True)
    systems = fr.chart(oscillators, {"omega": (2.5, 3.5, 9), "epsilon": (0.1, 0.3, 8)}, growth=True)
    run = runs.reference()
    ensemble = require_runs(
        "found", fr.ensemble(runs.PROBLEM, {"kick": [0.01, 0.2], "friction": [0.1, -1.0]}, frames=True)
    )
    checkpoint = place / "begun.ckpt"
    _interrupted(checkpoint)
    return (
        Kind(chart.save(place / "damaged_chart.npz"), fr.Chart.load, chart),
        Kind(run.save(place / "damaged_run.npz"), fr.Simulation.load, run),
        Kind(checkpoint, runs.simulate, run),
        Kind(ensemble.save(place / "damaged_ensemble.npz"), Runs.load, ensemble),
        Kind(systems.save(place / "damaged_chart_of_systems.npz"), fr.Chart.load, systems),
        *(Kind(path, read_system, SYSTEM, checked=False) for path in system_files()),
    )


def _interrupted(checkpoint: Path) -> None:
    """Leave the checkpoint of a run that Ctrl-C ended half-way."""

    def stop(done: int, total: int) -> None:
        if done > total // 2:
            raise KeyboardInterrupt

    fr.simulate(
        runs.ROD, runs.LOAD, duration=0.05, friction=0.1, segments=40, frames=12, time_step=4e-6,
        checkpoint=checkpoint, progress=stop,
    )  # fmt: skip


def check(rng: np.random.Generator) -> Found:
    """Damage one file and read it, or one of a Zarr store and go on with that."""
    if rng.random() < 0.1:
        return _store(rng)
    kind = kinds()[int(rng.integers(len(kinds())))]
    good = kind.path.read_bytes()
    others = [other.path.read_bytes() for other in kinds()]
    bad, how = damage(good, others, rng)
    with tempfile.TemporaryDirectory(prefix="fuzz") as name:
        path = Path(name) / kind.path.name
        path.write_bytes(bad)
        wrong = read_damaged(kind, path)
        keep = folder() / "failed"
        if wrong:
            keep.mkdir(exist_ok=True)
            shutil.copy(path, keep)
    return Found(1, [f"{kind.path.name} {how}: {line}" for line in wrong])


@functools.cache
def whole_store() -> Path:
    """Return a Zarr store with frames."""
    place = folder() / "damaged_runs.zarr"
    fr.ensemble(runs.PROBLEM, _STORED, frames=True, store=place)
    return place


def _store(rng: np.random.Generator) -> Found:
    """Damage or remove one file of a Zarr store and go on: everything is there again, or a ValueError."""
    with tempfile.TemporaryDirectory(prefix="fuzz") as name:
        place = Path(name) / "runs.zarr"
        shutil.copytree(whole_store(), place)
        every = sorted(path for path in place.rglob("*") if path.is_file())
        path = every[int(rng.integers(len(every)))]
        good = path.read_bytes()
        bad, how = (None, "is gone") if rng.random() < 0.3 else damage(good, [every[0].read_bytes()], rng)
        path.unlink()
        if bad is not None:
            path.write_bytes(bad)
        try:
            wrong = go_on(place)
        except ValueError as error:
            told_of = path.name in _IDENTITY and str(error).startswith(f"store {place} ")
            wrong = [] if told_of else [told(error)]
    return Found(1, [f"{path.relative_to(name)} {how}: {line}" for line in wrong])


def go_on(place: Path) -> list[str]:
    """Return what is wrong about a store after it was continued, and about what that returned."""
    expected = runs.arrays(xarray.open_zarr(whole_store()))
    found = runs.arrays(fr.ensemble(runs.PROBLEM, _STORED, frames=True, store=place))
    stored = runs.arrays(xarray.open_zarr(place))
    answers = {"an ensemble returns": found, "the store holds": stored}
    return [
        f"{who} another {', '.join(different)}"
        for who, answer in answers.items()
        if (different := runs.differing(expected, answer))
    ]


def read_damaged(kind: Kind, path: Path) -> list[str]:
    """Return what is wrong about how a damaged file is read."""
    try:
        with limit():
            found = kind.read(path)
    except ValueError:
        return []
    except (Exception, TookTooLong) as error:
        return [told(error)]
    if not kind.checked:
        return [] if isinstance(found, fr.HillSystem | fr.PeriodicSystem) else [f"is read as {type(found).__name__}"]
    different = runs.differences(kind.content, found)
    return [f"loads with another {', '.join(different)}"] if different else []


def damage(good: bytes, others: list[bytes], rng: np.random.Generator) -> tuple[bytes, str]:
    """Return the bytes with one to three damages, and what they are."""
    data, told_of = good, []
    for _ in range(int(rng.choice([1, 1, 1, 2, 3]))):
        at, size = int(rng.integers(len(data) + 1)), int(2 ** rng.uniform(0.0, 12.0))
        what = str(rng.choice(["cut", "flip", "flip", "flip", "insert", "zero", "splice", "drop", "swap"]))
        data = _damaged(data, what, at, size, others, rng)
        told_of.append(f"{what} at {at}")
        if not data:
            break
    return data, ", ".join(told_of)


def _damaged(data: bytes, what: str, at: int, size: int, others: list[bytes], rng: np.random.Generator) -> bytes:
    before, after = data[:at], data[at:]
    if what == "cut":
        return before
    if what == "flip" and after:
        return before + bytes([after[0] ^ (1 << int(rng.integers(8)))]) + after[1:]
    if what == "insert":
        return before + rng.bytes(min(size, 64)) + after
    if what == "zero":
        return before + bytes(min(size, len(after))) + after[size:]
    if what == "splice":
        other = others[int(rng.integers(len(others)))]
        return before + other[at : at + size] + after[size:]
    if what == "drop":
        return before + after[size:]
    if what == "swap":
        other = int(rng.integers(len(data) + 1))
        first, second = sorted((at, other))
        return data[:first] + data[second : second + size] + data[first + size :]
    return data
