"""The paper's simulations: how they are carried out and judged, on runs too short to find anything themselves."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import floquetrod as fr
from floquetrod.simulation.growth import LEAST_PER_PERIOD
from studies import reproduction, simulation_claims, simulations
from studies.__main__ import main
from studies.simulation_claims import SimulationStudy, friction_share

SHORT = 5e-3  # s

every_trial = simulation_claims.trials


def changed(trial: simulations.Trial, **options: float) -> simulations.Trial:
    """Return a trial with some options of its problem changed, as coarse as other rods, whose kernel is compiled."""
    return replace(trial, problem=trial.problem.replace(**{"segments": 120} | options))


def short(quick: bool) -> list[list[simulations.Trial]]:
    """Return all trials, cut short."""
    return [[changed(trial, duration=SHORT, frames=9) for trial in group] for group in every_trial(True)]


@pytest.fixture(scope="module")
def made() -> Iterator[tuple[SimulationStudy, list[str]]]:
    said: list[str] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(simulation_claims, "trials", short)
        yield simulation_claims.make_study(True, said.append), said


def as_the_paper_says(study: SimulationStudy) -> SimulationStudy:
    """Return the study with every outcome replaced by what was expected."""

    def all_of(outcomes: tuple[simulations.TrialOutcome, ...]) -> tuple[simulations.TrialOutcome, ...]:
        return tuple(
            replace(o, buckled=bool(o.trial.expected_modes), mode=max(o.trial.expected_modes, default=0))
            for o in outcomes
        )

    return replace(study, figure_4=all_of(study.figure_4), figure_7=all_of(study.figure_7))


def test_frames_are_close_enough_for_fits_of_growth() -> None:
    for trial in simulations.figure_4():
        spacing = trial.problem.duration / (trial.problem.frames - 1)
        assert LEAST_PER_PERIOD * spacing <= 2.0 * np.pi / trial.frequency, str(trial)


def test_draws_that_end_as_expected_are_counted() -> None:
    stays, leads = (simulations.figure_4()[place] for place in (0, 8))
    assert (stays.expected_modes, leads.expected_modes) == ((), (8,))
    buckled, modes = np.array([True, True, False]), np.array([8, 7, 8], dtype=np.int16)
    assert simulations.Draws(stays, buckled, modes).agree == 1
    assert simulations.Draws(leads, buckled, modes).agree == 1
    trials = [changed(trial, duration=SHORT, frames=9) for trial in simulations.figure_4()[:2]]
    first, second = simulations.redraw(trials, 3)
    for seed, found in enumerate(second.modes, start=1):
        kick = fr.Perturbation.random(1e-3, seed)
        assert found == trials[1].problem.replace(perturbation=kick).run().dominant_mode
    assert first.agree == 3


@pytest.mark.slow
def test_everything_is_simulated_and_told(made: tuple[SimulationStudy, list[str]]) -> None:
    study, said = made
    assert (len(study.figure_4), len(study.figure_7), len(study.redrawn), len(study.draws)) == (10, 30, 5, 4)
    again = [what for what in said if what == "Simulated Figure 4, drawn again"]
    assert (len(study.redrawn_4), len(again), len(said)) == (10, 20, sum(map(len, short(True))) + 20)
    said = [what for what in said if what not in again]
    assert sorted(said) == sorted(f"Simulated {trial}" for group in short(True) for trial in group)
    for outcome, trial in zip(study.figure_7, short(True)[1], strict=True):
        assert outcome.trial == trial
    assert len({str(trial) for group in short(True) for trial in group}) == len(said)


@pytest.mark.slow
def test_parts_of_a_draw(made: tuple[SimulationStudy, list[str]]) -> None:
    for draw in made[0].draws:
        whole = dict(draw.whole.trial.problem.perturbation.speeds)
        without = dict(draw.without.trial.problem.perturbation.speeds)
        assert draw.modes == {0.118: (6, 7), 0.424: (7, 8)}[draw.whole.trial.mean]
        assert without == {mode: speed for mode, speed in whole.items() if mode not in draw.modes}
        for mode, part in zip(draw.modes, draw.alone, strict=True):
            assert part.trial.problem.perturbation == fr.Perturbation.modes({mode: whole[mode]})
    assert [draw.seed for draw in made[0].draws] == [1, 2, 1, 2]


def test_friction_is_shared() -> None:
    assert friction_share(fr.Perturbation.modes({7: -0.02}), 7) == pytest.approx(1.0, abs=1e-3)
    both = fr.Perturbation.modes({7: 0.02, 8: 0.04})
    assert 0.0 < friction_share(both, 7) < friction_share(both, 8) < 1.0
    # What moves a thousandth as fast turns the sign of the sum hardly anywhere.
    small = fr.Perturbation.modes({1: 1.0, 2: 1e-3})
    assert friction_share(small, 2) < 1e-2


def test_claims_find_nothing_in_so_short_a_time(made: tuple[SimulationStudy, list[str]]) -> None:
    study, _ = made
    found = {name: claim() for name, claim in simulation_claims.simulation_claims(lambda: study).items()}
    assert list(found) == ["F4", "F4-D", "F7", "F7-C", "E"]
    assert not any(claim.holds for claim in found.values())
    assert "0.20 stays" in found["F4"].computed
    assert "predicted modes 7" in found["F4"].why
    assert "A at 150 rad/s and 0.424 F_cr: stays, the paper: mode 8" in found["F7"].computed


def test_claims_notice_a_change(made: tuple[SimulationStudy, list[str]]) -> None:
    right = as_the_paper_says(made[0])
    claim = simulation_claims.f7(right)
    assert claim.agrees
    assert claim.holds
    assert claim.why == ""
    for place, holds in ((0, False), (18, True)):  # case A at 85 rad/s; case C 10 at 150 rad/s and 0.118 Fcr
        outcomes = list(right.figure_7)
        outcomes[place] = replace(outcomes[place], buckled=True, mode=6)
        claim = simulation_claims.f7(replace(right, figure_7=tuple(outcomes)))
        assert (claim.agrees, claim.holds) == (False, holds)
        assert "mode 6, the paper: stays" in claim.computed


@pytest.mark.slow
def test_figures(made: tuple[SimulationStudy, list[str]], tmp_path: Path) -> None:
    drawings = reproduction._simulated(lambda: made[0])
    assert [name for _, name, _ in drawings] == ["figure_4.png", "figure_7.png"]
    for (_, _, draw), panels in zip(drawings, (10, 30), strict=True):
        figure = draw()
        assert len(figure.axes) == panels
        figure.set_layout_engine("none")  # which takes most of the time
        figure.savefig(tmp_path / "figure.png", dpi=20)
    titles = [ax.get_title() for ax in figure.axes]
    assert titles[0] == "stays"
    assert titles[10] == "stays (paper: mode 6)"


@pytest.mark.slow
def test_control_c_ends_the_runs_under_way() -> None:
    trial = changed(simulations.figure_4()[0], duration=100.0)  # minutes

    def stop(done: object, number: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulations.run_trials([changed(trial, duration=1e-3), *[trial] * 3], workers=2, progress=stop)


def shaped(theta: NDArray[np.float64]) -> fr.Simulation:
    """Return a run of the reference rod with angles theta around the channel, (frames, nodes), and no spin."""
    trial = changed(simulations.figure_4()[0], duration=SHORT, segments=theta.shape[1] - 1, frames=9)
    run, rod = trial.run().run, simulations.ROD
    places = np.broadcast_to(np.linspace(0.0, rod.length, theta.shape[1]), theta.shape)
    positions = np.stack([places, rod.radial_clearance * np.sin(theta), -rod.radial_clearance * np.cos(theta)], axis=2)
    energy = run.energy | {"twist": np.zeros(len(theta)), "bend": np.zeros(len(theta))}
    return replace(run, positions=positions, energy=energy)


WAVE = 7 * np.pi / simulations.ROD.length
SINE = np.sin(WAVE * np.linspace(0.0, simulations.ROD.length, 401))
COSINE = np.cos(WAVE * np.linspace(0.0, simulations.ROD.length, 401))


def test_the_energy_of_shear() -> None:
    """Of a rod bent to a sine it is (E I R A k^3)^2 / (k G A) L / 4."""
    run, rod, amplitude = shaped(1e-3 * np.array([[0.0], [1.0]]) * SINE), simulations.ROD, 1e-3
    force = rod.flexural_rigidity * rod.radial_clearance * amplitude * WAVE**3
    rigidity = 6.0 * 1.33 / (7.0 + 6.0 * 0.33) * run.problem.mesh.shear_modulus * rod.area
    assert simulations.shear(run) == pytest.approx([0.0, 0.25 * rod.length * force**2 / rigidity], rel=1e-3, abs=1e-25)


def test_the_energy_of_torsion() -> None:
    """A sine that grows where it lies against the wall turns by -R^2 A^3 k^3 cos(k s) / 3 per length, and back."""
    rod, size = simulations.ROD, 0.05 * np.linspace(0.0, 1.0, 41)
    run = shaped(np.concatenate([size, size[::-1]])[:, None] * SINE)
    rate = rod.radial_clearance**2 * 0.05**3 * WAVE**3 * COSINE / 3.0
    expected = 0.5 * run.problem.mesh.torsional_rigidity * np.sum(rate**2) * rod.length / 400
    found = simulations.torsion(run)
    assert found[40] == pytest.approx(expected, rel=1e-2)
    assert found[-1] < 1e-4 * found[40]
    # The spin of sections may act alike: then the angles add up, not the energies.
    spun = simulations.torsion(replace(run, energy=run.energy | {"twist": np.full(82, 4.0 * expected)}))
    assert spun[40] == pytest.approx(9.0 * expected, rel=1e-2)


def test_what_torsion_holds() -> None:
    run = shaped(np.zeros((3, 61)))
    energy = {"twist": np.array([2.0, 4.0, 2.0]), "bend": np.array([98.0, 16.0, 0.01])}
    share = simulations.torsion_and_shear_share(replace(run, energy=run.energy | energy))
    assert share == pytest.approx((8.0 / 122.01, 0.2, 16.0 / 98.0, 1.0))


@pytest.mark.slow
def test_the_report_holds_the_simulations(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(simulation_claims, "trials", short)
    for name in ("frictionless_claims", "friction_claims"):
        monkeypatch.setattr(reproduction, name, lambda points: {})
    monkeypatch.setattr(reproduction, "_drawings", lambda quick: [])
    monkeypatch.setattr(reproduction, "_simulated", lambda study: [])  # drawn in another test
    assert main(["--quick", "--simulations", "--out", str(tmp_path), "--json"]) == 1
    captured = capsys.readouterr()
    assert list(json.loads(captured.out)["claims"]) == ["F4", "F4-D", "F7", "F7-C", "E"]
    assert "Simulated 150 rad/s, mean 0.424 Fcr, friction 0.1, C 10, seed 2, without modes 7 and 8" in captured.err
    steps = [(int(done), int(total)) for done, total in re.findall(r"\[ *(\d+)/(\d+)\]", captured.err)]
    assert steps == [(done, 86) for done in range(87)]
