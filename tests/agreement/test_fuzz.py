"""A short run of every attack, and proof that each of them can fail."""

from __future__ import annotations

import dataclasses
import functools
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

import floquetrod as fr
from floquetrod import cli
from floquetrod.ensembles import stores_disk, stores_zarr
from floquetrod.rod import StabilityInterval
from tests.conftest import SEED
from tests.fuzz import (
    apart,
    calls,
    concurrency,
    core,
    disks,
    files,
    junk,
    kicks,
    kills,
    margins,
    oracle,
    ranges,
    real_rods,
    rods,
    runs,
    systems,
    terminal,
    verdicts,
)
from tests.fuzz.__main__ import Campaign

ROOT = Path(__file__).parents[2]
TRUST = (ROOT / "docs" / "theory" / "trust.md").read_text(encoding="utf-8")
ROD = fr.Rod.nitinol()


LONG = (
    "junk",
    "terminal",
    "disks",
    "real_rods",
    "concurrency",
    "margins",
    "kills",
    "kicks",
    "systems",
    "ranges",
    "files",
    "verdicts",
)
"""Attacks that take a second and more."""


@pytest.mark.parametrize("attack", [pytest.param(a, marks=[pytest.mark.slow] * (a in LONG)) for a in core.ATTACKS])
def test_short_attack(attack: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ranges, "POINTS", 1000)  # of a scan: a quarter of what the tool looks at
    seed = int(os.environ[SEED]) % 2**31
    tallies = list(core.run(attack, seed, range(core.load(attack).QUICK)))
    failures = [line for tally in tallies for line in tally.failures]
    assert not failures, "\n".join(failures)
    assert sum(tally.answers for tally in tallies) >= len(tallies)


def test_every_public_callable_is_attacked() -> None:
    assert {name.partition(" ")[0] for name in calls.table()} | set(calls.LEFT_OUT) == calls.public()
    assert not set(calls.table()) & set(calls.LEFT_OUT)


@pytest.mark.slow
def test_the_calls_that_junk_starts_from_are_answered() -> None:
    for name, call in calls.table().items():
        if name not in concurrency.QUIET:
            call.function(**call.arguments)


# The oracle.


@pytest.mark.slow
def test_the_oracle_and_thirty_digits_agree(rng: np.random.Generator) -> None:
    alpha, mean = rng.uniform(0.0, 5.0, 4), rng.uniform(-6.0, 2.0, 4)
    bounds = oracle.growth(alpha, mean)
    for a, b, low, high in zip(alpha, mean, bounds.low, bounds.high, strict=True):
        exact, _ = verdicts.exact(fr.Mathieu(float(a), float(b)))
        assert max(0.0, low) - 1e-15 <= exact <= max(0.0, high) + 1e-15


def test_the_oracle_is_sharp(rng: np.random.Generator) -> None:
    bounds = oracle.growth(rng.uniform(0.0, 8.0, 500), rng.uniform(-10.0, 2.0, 500))
    assert np.median(bounds.high - bounds.low) < 1e-9


def test_the_oracle_knows_constant_coefficients() -> None:
    b = np.array([-7.3, -0.3, -1e-12, 0.5, 3.0])
    bounds = oracle.growth(0.0, b)
    assert np.sqrt(np.maximum(b, 0.0)) == pytest.approx(np.maximum(bounds.middle, 0.0), rel=1e-12, abs=1e-6)


# Each attack can fail.


def stated(low: float, high: float, *parts: tuple[float, float]) -> fr.results.StabilityIntervals:
    found = ROD.ranges("frequency", mean=0.3, amplitude=0.3, bounds=(100.0, 110.0), growth_tolerance=0.1)
    intervals = tuple(StabilityInterval(*part, None, None) for part in parts)
    return dataclasses.replace(found, bounds=(low, high), intervals=intervals)


@pytest.mark.slow
def test_ranges_can_fail(rng: np.random.Generator) -> None:
    # The first is what a search over a clipped surplus of growth answered: mode 7 grows from 97.65 to 107.85 rad/s.
    rod = ROD.replace(damping_rate=12.0)
    unit = rod.critical_force
    question = rods.Question(rod, 0.6 * unit, 0.4 * unit, 100.0, 0.0)
    (missed,) = ranges.compare(question, "frequency", (90.0, 120.0), stated(90.0, 120.0, (90.0, 120.0)), rng)
    assert "missed band" in missed
    assert "mode 7 grows" in missed
    (invented,) = ranges.compare(question, "frequency", (90.0, 120.0), stated(90.0, 120.0), rng)
    assert "called unstable" in invented
    right = stated(90.0, 120.0, (90.0, 97.65), (107.85, 120.0))
    values = np.array([97.0, 102.0])
    assert ranges.inside(right, values).tolist() == [True, False]


def test_junk_can_fail() -> None:
    def careless(number: float) -> float:
        if isinstance(number, str):
            raise ValueError("that is wrong")
        return number * math.nan

    call = junk.Call(careless, {"number": 1.0})
    assert "names no argument" in junk.attack("careless", call, {"number": "'x'"})[0]
    assert "answers NaN" in junk.attack("careless", call, {"number": "0.5"})[0]
    assert junk.attack("careless", call, {"number": "math.nan"}) == []
    dividing = junk.Call(lambda number: 1.0 / number, {"number": 1.0})
    assert "ZeroDivisionError" in junk.attack("dividing", dividing, {"number": "0"})[0]
    unmasked = junk.Call(lambda number: np.asarray(number), {"number": 1.0})
    assert (
        "loses the mask"
        in junk.attack("unmasked", unmasked, {"number": "np.ma.array([0.3, 0.4], mask=[False, True])"})[0]
    )
    warning = junk.Call(lambda number: np.float64(1.0) / number, {"number": 1.0})
    assert "RuntimeWarning" in junk.attack("warning", warning, {"number": "0.0"})[0]


def test_a_call_without_end_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    def busy(number: float) -> None:
        while True:
            number += 1.0

    monkeypatch.setattr(junk, "limit", lambda: core.limit(0.2))
    assert "TookTooLong" in junk.attack("busy", junk.Call(busy, {"number": 1.0}), {"number": "0"})[0]


@pytest.mark.parametrize("result", [7, RuntimeError("no")])
def test_terminal_can_fail(result: Any, monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator) -> None:
    def broken(words: list[str]) -> int:
        if isinstance(result, Exception):
            raise result
        return int(result)

    monkeypatch.setattr(cli, "main", broken)
    found = [line for _ in range(5) for line in terminal.check(rng).failures]
    assert any("exit status" in line for line in found)


@pytest.mark.slow
def test_files_can_fail(tmp_path: Path) -> None:
    kind = files.kinds()[0]
    path = tmp_path / "chart.npz"
    path.write_bytes(b"damaged")
    assert files.read_damaged(kind, path) == []
    other = dataclasses.replace(kind.content, undecided=7)
    assert "undecided" in files.read_damaged(kind._replace(read=lambda path: other), path)[0]
    careless = kind._replace(read=lambda path: {}["meta"])
    assert "KeyError" in files.read_damaged(careless, path)[0]


def test_damages_damage(rng: np.random.Generator) -> None:
    good = bytes(range(256)) * 8
    bad = [files.damage(good, [good[::-1]], rng)[0] for _ in range(60)]
    assert sum(data != good for data in bad) > 40


@pytest.mark.slow
def test_kills_can_fail(monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator) -> None:
    run = runs.reference()

    def careless(checkpoint: Path) -> fr.Simulation:
        (checkpoint.parent / ".run.ckpt.abc.part").write_bytes(b"")
        return dataclasses.replace(run, time=run.time + 1e-12)

    monkeypatch.setattr(runs, "simulate", careless)
    found = kills.checkpoint(rng).failures
    assert any("another time" in line for line in found)
    assert any("leaves .run.ckpt.abc.part" in line for line in found)


def test_kills_of_stores_can_fail() -> None:
    counts, work = [60, 40], functools.partial({}.pop, "runs")
    wrong = kills.stopped_and_killed(work, "is in use", lambda: counts.pop(0), [0.0, 0.0, 0.0])
    assert "a second process: KeyError" in wrong[0]
    assert wrong[1] == "of 60 40 are left"


@pytest.mark.slow
def test_disks_under_ensembles_can_fail(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    warned = stores_disk.warn

    def careless() -> None:
        monkeypatch.setattr(stores_disk, "warn", lambda text: [warned(text), warned(text)])
        disks.break_os("replace", 1.0, np.random.default_rng(1))

    wrong = disks.ensemble(tmp_path / "runs.npz", False, 0, careless)
    assert wrong == ["warns 2 times that the store cannot be written"]
    monkeypatch.setattr(stores_disk.DiskStore, "_succeeds", lambda store, write: write())
    wrong = disks.ensemble(tmp_path / "more.npz", False, 0, careless)
    assert "the results of an ensemble are lost: OSError" in wrong[0]


@pytest.mark.slow
def test_damaged_stores_can_fail(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    place = tmp_path / "runs.zarr"
    shutil.copytree(files.whole_store(), place)
    (place / "kick" / "0").unlink()
    monkeypatch.setattr(stores_zarr.ZarrStore, "_write_known", lambda store: None)
    assert files.go_on(place) == ["the store holds another kick"]


def test_disks_can_fail(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    run = runs.reference()

    def careless(checkpoint: Path, progress: object) -> fr.Simulation:
        os.replace(checkpoint, checkpoint)  # noqa: PTH105  (what is broken below)
        return run

    monkeypatch.setattr(runs, "simulate", careless)
    broken = disks.run(tmp_path, lambda: disks.break_os("replace", 1.0, np.random.default_rng(1)))
    assert "the result of a run is lost: OSError" in broken[0]
    monkeypatch.setattr(runs, "simulate", lambda checkpoint, progress: run)
    assert disks.run(tmp_path, lambda: None) == ["no warning that nothing was saved"]


@pytest.mark.slow
def test_verdicts_can_fail(monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator) -> None:
    equation = fr.Mathieu(0.5, -0.25)
    rate, x = verdicts.exact(equation)
    right = fr.stability(equation)
    assert verdicts.judged(right, rate, x, decides=True) == []
    assert "states an error" in verdicts.judged(dataclasses.replace(right, error=0.0), rate, x)[0]
    assert "stable, growth is" in verdicts.judged(dataclasses.replace(right, status="stable"), rate, x)[0]
    assert "undecided" in verdicts.judged(dataclasses.replace(right, status="undecided"), rate, x, decides=True)[0]
    assert "NaN" in verdicts.judged(dataclasses.replace(right, error=math.nan), rate, x)[0]
    monkeypatch.setattr(fr.mathieu, "is_stable", lambda a, b, c: np.zeros(np.shape(a), dtype=bool))
    assert verdicts.over_arrays(rng)
    monkeypatch.setattr(fr.mathieu, "is_stable", lambda a, b, c: np.ones(np.shape(a), dtype=bool))
    assert "is stable and grows" in verdicts.beside_curves(rng)[0]


def test_systems_can_fail() -> None:
    system = fr.HillSystem([[1.0, 0.0], [0.0, 4.0]], [[[0.1, 0.2], [0.2, 0.16]]], period=2.0 * math.pi / 3.0)
    right = fr.stability(system)
    assert right.status == "unstable"
    assert systems.against_scipy(system, right) == []
    stable = dataclasses.replace(right, status="stable")
    assert "scipy has growth" in systems.against_scipy(system, stable)[0]
    assert "one says unstable, other stable" in systems.between({"one": right, "other": stable})[0]
    moved = dataclasses.replace(right, exponents=tuple(s + 1e-6 for s in right.exponents))
    assert "is no multiplier" in systems.against_scipy(system, moved)[0]
    assert "more than their errors" in systems.between({"one": right, "other": moved})[0]
    assert systems.sound(dataclasses.replace(right, status="undecided", note="")) == ["undecided without a reason"]


@pytest.mark.slow
def test_margins_can_fail() -> None:
    wire = ROD.replace(damping_rate=0.5, ends="clamped")
    load = fr.AxialLoad(0.1 * ROD.critical_force, 0.1 * ROD.critical_force, 20.0)
    question = real_rods.Question(wire, load, 0.0)
    verdict = real_rods.ask(question)
    end = 102.060348 - 20.0  # see test_coupled_answers
    values = np.linspace(20.5, 104.0, 200)
    right, wrong = (fr.rod.Margin(math.inf, above, 0.02) for above in (end, 84.0))
    assert not margins.at_its_end(question, verdict, "frequency", 20.0, end)
    for margin, expected in ((right, False), (wrong, True)):
        found = margins.within(
            question, verdict, "frequency", margin, margin.above, values[values < 20.0 + margin.above]
        )
        assert any("the verdict changes at 10" in line for line in found) == expected
    assert margins.at_its_end(question, verdict, "frequency", 20.0, end * (1.0 + 1e-3))
    assert margins.at_its_end(question, verdict, "frequency", 20.0, end * (1.0 - 1e-3))


@pytest.mark.slow
def test_real_rods_can_fail() -> None:
    rod = fr.Rod(207e9, 7850.0, 0.01, 9.0, 0.05, inclination=math.radians(60.0))  # of few modes
    load = fr.AxialLoad(0.2 * rod.critical_force, 0.5 * rod.critical_force, 2.2 * rod.pendulum_frequency)
    question = real_rods.Question(rod, load, 0.0)
    right = rod.stability(load)
    assert real_rods.sound(question, right) == real_rods.against_finite_differences(question, right) == []
    stable = dataclasses.replace(right, status="stable")
    assert "finite differences have 2.38776" in real_rods.against_finite_differences(question, stable)[0]
    assert "stable, growth" in real_rods.sound(question, stable)[0]
    rate, error = right.growth_rate, right.error
    faster = dataclasses.replace(right, growth_rate=rate + 1e-5 + 3.0 * error)
    assert "unstable, growth" in real_rods.against_finite_differences(question, faster)[0]
    assert "unstable, finite" in real_rods.compared(question._replace(tolerance=3.0), right, rate, 1e-6)[0]


@pytest.mark.slow  # test_margins_can_fail shows as much
def test_a_margin_of_coupled_modes_that_is_too_large_would_be_found(rng: np.random.Generator) -> None:
    rod = ROD.replace(ends="clamped", damping_rate=0.5)
    question = real_rods.Question(rod, fr.AxialLoad(0.1 * ROD.critical_force, 0.1 * ROD.critical_force, 20.0), 0.0)
    verdict = rod.stability(question.load)
    # What a search with 17 samples answered: three bands lie between 102 and 126 rad/s.
    vars(verdict)["frequency_margin"] = fr.rod.Margin(math.inf, 120.256751, 0.46875, (0.0, 120.256751))
    found = real_rods.along_a_margin(question, verdict, "frequency", rng)
    assert "changes before" in found[0]
    vars(verdict)["frequency_margin"] = fr.rod.Margin(math.inf, 82.060348, 0.46875, (0.0, 82.060348))
    assert real_rods.along_a_margin(question, verdict, "frequency", rng) == []


def test_kicks_can_fail(rng: np.random.Generator) -> None:
    alpha, beta, gamma = 1.0, 0.3, 1.0
    right = float(fr.friction.critical_kick(alpha, beta, gamma).smallest_found)
    assert kicks.compare(alpha, beta, 0.0, right, rng) == ([], False)
    wrong, missed = kicks.compare(alpha, beta, 0.0, 1.05 * right, rng)
    assert missed
    assert any("% too high" in line for line in wrong)
    assert kicks.compare(alpha, beta, 0.0, math.nan, rng)[0]
    assert any("outside what is proved" in line for line in kicks.compare(alpha, beta, 0.0, 0.3 * right, rng)[0])


def test_integration_tells_fates_apart() -> None:
    # Without forcing the rod escapes exactly for kicks above gamma / sqrt(beta).
    assert [kicks.integrate(0.0, 0.25, 0.0, kick, 2.0) for kick in (1.9, 2.1)] == [0, 1]


@pytest.mark.slow
def test_concurrency_can_fail(monkeypatch: pytest.MonkeyPatch, rng: np.random.Generator) -> None:
    monkeypatch.setattr(concurrency.pickle, "loads", lambda data: 5)
    assert any("another" in line for line in concurrency.handled(fr.Mathieu(0.5, -0.25)))
    monkeypatch.undo()
    assert any("== raises ValueError" in line for line in concurrency.handled(Careless(np.array([1.0, 2.0]))))
    names = iter(range(10**6))
    drifting = {f"call {k}": calls.Call(lambda: next(names), {}) for k in range(6)}
    monkeypatch.setattr(concurrency, "table", lambda: drifting)
    assert concurrency.threads(rng).failures
    growing = {f"call {k}": calls.Call(lambda: _titled(next(names)), {}) for k in range(6)}
    monkeypatch.setattr(concurrency, "table", lambda: growing)
    assert len(concurrency.threads(rng).failures) == 6
    elsewhere = {f"call {k}": calls.Call(os.getpid, {}) for k in range(6)}
    monkeypatch.setattr(concurrency, "table", lambda: elsewhere)
    # In forks: every tenth time it would be in fresh processes, which take seconds.
    assert concurrency.forks(np.random.default_rng(1)).failures
    monkeypatch.setattr(concurrency, "LONG", {"deaf": deaf})
    monkeypatch.setattr(concurrency, "PROMPT", 0.3)
    assert "does not hear" in concurrency.interrupts(rng).failures[0]


def _titled(number: int) -> Any:
    """Return axes that bear a number."""
    ax = Figure().subplots()
    ax.set_title(str(number))
    return ax


@dataclasses.dataclass
class Careless:
    """Not to be compared."""

    values: np.ndarray


def deaf() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    time.sleep(60.0)


def test_a_fork_answers_raises_or_dies() -> None:
    assert apart.answer(lambda: 5) == (True, 5)
    done, what = apart.answer(lambda: {}["x"])
    assert not done
    assert what.startswith("KeyError")
    assert apart.kill_after(lambda: time.sleep(60.0), 0.01)


# The table of guarantees.


def test_every_guarantee_names_tests_that_exist() -> None:
    rows = [line for line in TRUST.splitlines() if line.startswith("| ")]
    named = [re.findall(r"`(test_\w+\.py)::(\w+)(?:\[(\w+)\])?`", row) for row in rows]
    assert len(rows) > 20
    assert [row for row, tests in zip(rows[2:], named[2:], strict=True) if not tests] == []
    for file, name, attack in {test for tests in named for test in tests}:
        (path,) = (ROOT / "tests").rglob(file)
        source = path.read_text(encoding="utf-8")
        assert re.search(rf"^def {name}\(", source, re.MULTILINE), f"{file}::{name} does not exist"
        assert not attack or attack in core.ATTACKS


# The tool.


def tool(*words: str) -> subprocess.Popen[str]:
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "tests.fuzz", *words]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment, cwd=ROOT)


@pytest.mark.slow
def test_the_tool_prints_a_table() -> None:
    process = tool("--only", "verdicts", "--seed", "3", "--seeds", "2", "--cases", "1", "--workers", "2")
    text, _ = process.communicate(timeout=600)
    assert process.returncode == 0, text
    last = text.splitlines()[-1].split()
    assert last[:4] == ["verdicts", "2", "2,002", "0"]


@pytest.mark.skipif(shutil.which("false") is None, reason="there is no command that fails at once")
def test_an_attack_that_cannot_begin_is_a_failure(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "executable", shutil.which("false"))  # as Python ends where a module is missing
    campaign = Campaign(["verdicts"], 1)
    campaign.one("verdicts", 3)
    line = "python -m tests.fuzz --only verdicts --seed 3 --case 0  # ended with status 1"
    assert campaign.tallies["verdicts"].failures == [line]
    assert line in capsys.readouterr().out


@pytest.mark.slow
def test_ctrl_c_prints_what_was_found_so_far() -> None:
    process = tool("--only", "verdicts", "--seed", "3", "--seeds", "1000", "--cases", "1")
    assert process.stdout is not None
    process.stdout.readline()
    process.stdout.readline()
    process.send_signal(signal.SIGINT)
    text, _ = process.communicate(timeout=600)
    assert process.returncode == 130
    assert text.splitlines()[-1].split()[0] == "verdicts"


def test_failures_are_the_exit_status(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def one(campaign: Campaign, attack: str, seed: int) -> None:
        campaign.tallies[attack].add(core.Tally(attack, 1, 1, 0.0, [f"seed {seed}"]))

    monkeypatch.setattr(Campaign, "one", one)
    campaign = Campaign(["files"], None)
    assert campaign.run(first=5, seeds=3, minutes=None, workers=2) == 1
    assert sorted(campaign.tallies["files"].failures) == ["seed 5", "seed 6", "seed 7"]
    assert capsys.readouterr().out.splitlines()[-1].split()[:4] == ["files", "3", "3", "3"]


def test_a_failure_names_its_case(monkeypatch: pytest.MonkeyPatch) -> None:
    def check(rng: np.random.Generator) -> core.Found:
        raise ZeroDivisionError(f"drew {rng.random()}")

    monkeypatch.setattr(files, "check", check)
    first, second = core.run("files", 17, range(4, 6))
    assert first.failures[0].startswith(
        "python -m tests.fuzz --only files --seed 17 --case 4  # raised ZeroDivisionError: drew"
    )
    (again,) = core.run("files", 17, range(4, 5))
    assert again.failures == first.failures != second.failures
