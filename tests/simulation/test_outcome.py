"""Which simulated rods have buckled: none that friction holds at rest, none that goes on as it was kicked."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod import cli
from floquetrod.simulation import outcome
from floquetrod.simulation.outcome import Kick, outcome_of
from tests.conftest import depth
from tests.seams import Tuned

ROD = fr.Rod.nitinol()
FORCE = ROD.critical_force
NONE = fr.AxialLoad(0.0, 0.0, 150.0)
STABLE = fr.AxialLoad(0.2 * FORCE, 0.2 * FORCE, 85.0)
UNSTABLE = fr.AxialLoad(0.825 * FORCE, 0.7 * FORCE, 150.0)
RANDOM = fr.Perturbation.random(0.1, seed=1)


def kicked(load: fr.AxialLoad, speed: float, seeds: Any, **options: Any) -> Any:
    """Return rods that are kicked at random."""
    settings = {"duration": 0.4, "friction": 0.4, "segments": 60, "frames": 101, **options}
    problem = fr.SimulationProblem(ROD, load, perturbation=RANDOM, **settings)
    return fr.ensemble(problem, {"kick": [speed], "seed": seeds}).isel(kick=0)


def kinds(found: Any) -> list[str]:
    """Return what has become of every rod."""
    return [outcome.KINDS[number] for number in found.outcome.values.tolist()]


@pytest.mark.slow
def test_rods_that_lie_still_have_not_buckled() -> None:
    """Without any load, at rest at 5 to 10 degrees where friction 0.4 holds up to 21.8."""
    found = kicked(NONE, 0.16, range(depth(20, 8)))
    assert not found.buckled.any()
    assert set(kinds(found)) == {"quiet", "at rest"}
    rest = np.degrees(found.angle_in_the_end.values[found.outcome.values == outcome.KINDS.index("at rest")])
    assert len(rest) == depth(10, 2)
    assert 5.0 < rest.min() < rest.max() < 11.0
    assert float(found.floquetrod.probability(over="seed").upper) == pytest.approx(1.0 - 0.025 ** (1 / depth(20, 8)))


@pytest.mark.parametrize("friction", [0.4, pytest.param(0.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("duration", [0.4, pytest.param(2.0, marks=pytest.mark.slow)])
def test_under_a_stable_load_rods_do_not_buckle_however_long_they_are_watched(friction: float, duration: float) -> None:
    assert ROD.stability(STABLE).status == "stable"
    seeds = depth(8, 4)
    found = kicked(STABLE, 0.16, range(seeds), friction=friction, duration=duration)
    assert not found.buckled.any()
    assert (np.degrees(found.angle_in_the_end) > 5.0).any(), "nothing was beyond 5 degrees"
    if friction == 0.0:
        assert set(kinds(found)) == {"swinging"}
        with pytest.warns(fr.OutcomeWarning, match=f"{seeds} runs counted as not buckled, still swinging as its kick"):
            found.floquetrod.probability(over="seed")


@pytest.mark.slow
def test_rods_that_grow_against_friction_buckle() -> None:
    found = kicked(UNSTABLE, 0.12, range(6), friction=0.1)
    assert kinds(found) == ["buckled", "quiet", "buckled", "quiet", "quiet", "buckled"]
    assert (np.degrees(found.angle_in_the_end.values[found.buckled.values]) > 45.0).all()


@pytest.mark.slow
def test_without_a_load_nothing_buckles(rng: np.random.Generator) -> None:
    """Kicks in modes and at random, with and without friction and damping, short and long, stopped early or not."""
    for _ in range(depth(60, 6)):
        speed, mode = float(rng.uniform(0.02, 0.6)), int(rng.integers(1, 10))
        kick = fr.Perturbation.modes({mode: speed}) if rng.random() < 0.5 else fr.Perturbation.random(speed, mode)
        rod = ROD.replace(damping_rate=float(rng.choice([0.0, 0.5, 5.0])))
        problem = fr.SimulationProblem(
            rod,
            NONE,
            duration=float(rng.uniform(0.05, 0.8)),
            friction=float(rng.choice([0.0, 0.02, 0.1, 0.4, 0.8])),
            segments=60,
            frames=int(rng.integers(8, 120)),
            perturbation=kick,
            stop_early=bool(rng.random() < 0.5),
        )
        run = problem.run()
        assert not run.buckled, (problem, run)
        assert run.ended != "buckled"
        assert run.buckled_at is None
        assert "not buckled" in repr(run)


@pytest.mark.parametrize(
    ("kick", "friction", "damping_rate", "duration", "kinds"),
    [
        ({2: 0.14934691}, 0.8, 0.5, 0.288029, {"at rest"}),  # rings on, by a tenth of a degree
        ({3: 0.35894431}, 0.4, 0.0, 0.32469313, {"swinging"}),  # parts that friction holds swing on
        ({2: 0.37574751}, 0.8, 5.0, 0.41657185, {"at rest"}),  # at 39.9 degrees, beyond arctan(mu) = 38.7 degrees
        ({8: 0.59202954}, 0.0, 0.5, 0.1, {"swinging", "dying out"}),  # over the top of the channel
    ],
)
def test_what_a_strong_kick_does_without_a_load_is_not_buckling(
    kick: dict[int, float], friction: float, damping_rate: float, duration: float, kinds: set[str]
) -> None:
    problem = fr.SimulationProblem(
        ROD.replace(damping_rate=damping_rate),
        NONE,
        duration=duration,
        friction=friction,
        segments=60,
        frames=114,
        perturbation=fr.Perturbation.modes(kick),
        stop_early=True,
    )
    run = problem.run()
    assert run.ended != "buckled"
    assert run.outcome.kind in kinds
    assert run.outcome.angle > math.radians(10.0)


# --- the rule, on motion that is known ------------------------------------------------------------------------------

TIME = np.linspace(0.0, 2.0, 401)
SHAPE = np.sin(np.linspace(0.0, 3.0 * math.pi, 31))
SWING = np.sin(50.0 * TIME)


def kind(size: Any, *, friction: float = 0.0, ended: float = math.inf, swing: float = 3.0, shift: float = 0.0) -> str:
    """Return what has become of a rod whose nodes turn by SHAPE times a size in degrees, (frames,)."""
    angle = np.radians(np.multiply.outer(size, SHAPE)) + shift
    speeds = np.abs(np.gradient(angle, TIME, axis=0)) * 0.0039
    return outcome_of(TIME, angle, speeds, Kick(math.radians(swing), friction, ended, 0.1956)).kind


def test_the_rule() -> None:
    assert kind(4.0 * SWING) == "quiet"
    assert kind(20.0 * SWING) == "buckled"
    assert kind(20.0 * SWING, swing=11.0) == "swinging"
    assert kind(20.0 * SWING, swing=11.0, ended=0.2) == "buckled"
    assert kind(40.0 * np.exp(-TIME) * SWING, swing=11.0, ended=0.2) == "dying out"
    assert kind(40.0 * np.exp(-TIME) * SWING, swing=11.0) == "swinging"  # nothing brakes it: by chance
    by_chance = np.where(TIME < 1.5, 59.0, 55.0) * SWING  # a rod that stays buckled, long after its kick
    assert kind(by_chance, friction=0.1, ended=0.2, swing=40.0) == "buckled"
    rest = np.minimum(TIME, 1.0)
    assert kind(10.0 * rest, friction=0.4, ended=0.2) == "at rest"
    assert kind(10.0 * rest, friction=0.1, ended=0.2) == "buckled"  # friction holds up to 5.7 degrees
    assert kind(10.0 * rest) == "buckled"
    assert kind(10.0 * rest + 3.0 * SWING, friction=0.4, ended=0.2) == "buckled"
    assert kind(23.0 * rest, friction=0.4, ended=0.2) == "at rest"  # at up to 21.8 degrees, and 2 where it is bent
    assert kind(25.0 * rest, friction=0.4, ended=0.2) == "buckled"
    # A kick of a radian may take a rod over the top, unless it has ended.
    assert kind(160.0 * SWING, swing=58.0) == "swinging"
    assert kind(160.0 * SWING, swing=56.0) == kind(160.0 * SWING, swing=58.0, ended=0.2) == "buckled"
    # Frames may fall together with the zeros of the motion: its speed counts.
    angle = np.radians(np.multiply.outer([0.0, 10.0, 10.0, 10.0, 10.0], SHAPE))
    for speed, expected in ((1e-4, "at rest"), (0.05, "buckled")):
        speeds = np.full(angle.shape, speed)
        assert outcome_of(TIME[::100], angle, speeds, Kick(0.01, 0.4, 0.1, 0.1956)).kind == expected
    # A rod that only rings on is slow in some frames, also beside fast ones.
    angle = np.radians(np.multiply.outer(np.full(TIME.size, 10.0), SHAPE)) * (TIME[:, None] > 0.0)
    speeds = np.abs(np.cos(1000.0 * TIME))[:, None] * np.full(SHAPE.size, 0.01)
    assert outcome_of(TIME, angle, speeds, Kick(0.01, 0.4, 0.1, 0.1956)).kind == "at rest"


def test_angles_count_from_where_a_rod_began() -> None:
    """In a well a rod begins where weight and mean force press it to the wall, also beyond the other side."""
    for shift in (0.0, 1.0, 3.1, -3.1):
        assert kind(4.0 * SWING, shift=shift) == "quiet"
        assert kind(20.0 * SWING, shift=shift) == "buckled"


@pytest.mark.slow
def test_the_swing_of_a_kick_is_that_of_the_simulated_rod() -> None:
    kicks = fr.Perturbation.modes({8: 0.05}), fr.Perturbation.modes({3: 0.02}), fr.Perturbation.random(0.05, 2)
    for kick in kicks[depth(0, 1) :]:
        problem = fr.SimulationProblem(ROD, NONE, duration=0.4, segments=60, frames=801, perturbation=kick)
        assert problem.kick_alone.swing == pytest.approx(problem.run().largest_angle.max(), rel=0.15)
    assert problem.kick_alone.ended == math.inf
    assert problem.replace(friction=0.1).kick_alone.ended == pytest.approx(8.0 * 0.05 / 0.981, rel=0.1)
    assert problem.replace(rod=ROD.replace(damping_rate=6.0)).kick_alone.ended == 0.5


# --- what is said ---------------------------------------------------------------------------------------------------

STUDY = """
rod = "nitinol"
load = {mean = "0N", amplitude = "0N", frequency = "150rad/s"}
run = {duration = "0.4s", friction = 0.4, segments = 60, frames = 101}
start = {random = "50mm/s"}
over = {kick = ["160mm/s"], seed = {from = 2, to = 5}}
"""


@pytest.mark.slow
def test_the_terminal_says_what_buckled_means(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    assert cli.main(["ensemble", str(path)]) == 0
    out = capsys.readouterr().out
    assert re.search(
        r"\nbuckled   0 of 4; not buckled, but beyond 5 degrees: \d at rest at 5\.\d+ to \d\.\d+ degrees\n", out
    )
    assert f"buckled means {outcome.DEFINITION}\n" in out
    assert re.search(r"\n160 mm/s +4 +0\.000  0\.000 to 0\.602\n", out)
    line = "simulate --rod nitinol --mean 0N --amplitude 0N --frequency 150rad/s --mu 0.4 --duration 0.4s"
    assert cli.main([*line.split(), "--random", "0.16m/s", "--seed", "15", "--segments", "60"]) == 0
    out = capsys.readouterr().out
    assert re.match(r"NOT BUCKLED, at rest at \d+(\.\d+)? degrees where friction holds: largest angle", out)
    assert f"buckled   means {outcome.DEFINITION}" in out


@pytest.mark.slow
def test_buckling_under_a_load_that_theory_calls_stable_is_noted(tuned: Tuned) -> None:
    tuned(swings_that_are_growth=0.1)  # as if swinging on were growth
    found = kicked(STABLE, 0.16, range(3), friction=0.0)
    assert found.buckled.all()
    with pytest.warns(fr.OutcomeWarning, match="3 runs buckled, but by theory nothing grows under this load"):
        found.floquetrod.probability(over="seed")
    problem = fr.SimulationProblem(ROD, STABLE, duration=0.3, segments=60, perturbation=fr.Perturbation.random(0.16, 1))
    findings = problem.run().findings()
    assert "by theory nothing grows" in findings.as_dict()["against_theory"]
    assert "by theory nothing grows" in str(findings.report())
    fine = kicked(UNSTABLE, 0.12, [0], friction=0.1)
    assert fine.buckled.all()
    fine.floquetrod.probability(over="seed")  # without a warning
