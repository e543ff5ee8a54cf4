"""A tool in the simulated rod, and friction that varies along the channel: waves, balance, files, what is refused."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.ensembles.study import Study
from floquetrod.ensembles.varied_axes import varied
from tests.seams import Tuned

ROD = fr.Rod.nitinol()
WELL = fr.WellPath([0.0, 1.2, 2.0, 3.5], np.radians([60.0, 75.0, 80.0, 84.0]), np.radians([10.0, 20.0, 18.0, 40.0]))
REST = fr.Perturbation()
STILL = fr.AxialLoad(0.0, 0.0, 1.0)
INTERVALS = ((0.0, 0.2), (1.0, 0.5), (2.2, 0.1))

pytestmark = pytest.mark.filterwarnings("ignore::floquetrod.PlausibilityWarning")  # a laboratory's bends


def simulated(rod: fr.Rod = ROD, load: Any = STILL, duration: float = 0.01, **options: Any) -> fr.Simulation:
    """Return a run from rest."""
    given = {"segments": 60, "frames": 11, "perturbation": REST, **options}
    return fr.SimulationProblem(rod, load, duration=duration, **given).run()


# --- the tool ---


@pytest.mark.slow
@pytest.mark.parametrize("above_end", [1.55, 1.0, 0.0])
@pytest.mark.parametrize("path", [None, fr.WellPath.straight(length=5.0, inclination=1.0)])
def test_waves_run_from_it_both_ways_with_its_share(above_end: float, path: fr.WellPath | None) -> None:
    # Until they have been thrown back: A / (2 Z) sin(w (t - x / c)) each way, twice that from the lower end.
    tool = fr.VibrationTool(0.5, 2.0 * math.pi * 6e3, above_end)
    rod = ROD if path is None else ROD.replace(path=path)
    run = simulated(rod, duration=3e-4, segments=200, frames=31, tool=tool)
    place = np.linspace(0.0, ROD.length, 201)
    at = ROD.length - above_end
    late = run.time[:, None] - abs(place - at) / ROD.wave_speed
    size = tool.share * tool.amplitude / (ROD.mass_along * ROD.wave_speed)
    expected = np.where(late > 0.0, size * np.sin(tool.frequency * late), 0.0)
    way = np.minimum(place + at, 2.0 * ROD.length - place - at) if above_end else place + at
    direct = run.time[:, None] < way / ROD.wave_speed
    assert direct[-1].mean() > 0.3
    assert np.sqrt(np.mean((run.velocities[..., 0] - expected)[direct] ** 2)) < 0.01 * size


@pytest.mark.slow
@pytest.mark.parametrize("above_end", [1.0, 0.02, 3.09])
@pytest.mark.parametrize(("path", "friction"), [(None, 0.0), (None, INTERVALS), (WELL, INTERVALS)])
def test_the_error_of_the_energy_balance_is_of_second_order(above_end: float, path: Any, friction: Any) -> None:
    rod = ROD.replace(damping_rate=0.5) if path is None else ROD.replace(damping_rate=0.5, path=path)
    kick, tool = fr.Perturbation.random(0.05, seed=2), fr.VibrationTool(0.4, 700.0, above_end)
    errors = []
    for step in (1.2e-5, 6e-6):
        load = fr.AxialLoad(0.5, 0.1, 100.0)
        run = simulated(rod, load, 0.02, perturbation=kick, friction=friction, tool=tool, time_step=step)
        errors.append(abs(run.energy_error).max() / abs(run.energy["dissipated"]).max())
    assert errors[1] < 2e-3
    assert 2.8 < errors[0] / errors[1] < 5.5


def test_in_a_straight_well_tool_and_intervals_act_as_in_a_channel() -> None:
    well = ROD.replace(path=fr.WellPath.straight(length=50.0, inclination=0.5 * math.pi, azimuth=2.0), depth=11.0)
    load, tool = fr.AxialLoad(0.3, 0.0, 1.0, mean_at=0.5), fr.VibrationTool(0.4, 700.0, 1.01)
    below = ((0.0, 0.7), *((11.0 + depth, mu) for depth, mu in INTERVALS))
    straight, bent = (
        simulated(rod, load, 0.02, friction=friction, tool=tool, perturbation=fr.Perturbation.modes({6: 0.01}))
        for rod, friction in ((ROD, INTERVALS), (well, below))
    )
    assert straight.energy["dissipated_friction"][-1] > 0.0
    np.testing.assert_allclose(bent.positions, straight.positions, rtol=0.0, atol=1e-10)


# --- friction by interval ---


def test_intervals_with_one_coefficient_are_uniform_friction() -> None:
    kick = fr.Perturbation.random(0.05, seed=2)
    for rod in (ROD, ROD.replace(path=WELL)):
        runs = [simulated(rod, duration=5e-3, friction=mu, perturbation=kick) for mu in (0.2, [(0, 0.2), ("1m", 0.2)])]
        assert runs[0].positions.tobytes() == runs[1].positions.tobytes()
    assert fr.SimulationProblem(ROD, STILL, friction=[(0, 0.2)]) == fr.SimulationProblem(ROD, STILL, friction=0.2)


def test_a_node_has_the_friction_of_where_it_is() -> None:
    # A rod that slides a third of its length comes into the rough part of the channel.
    rod = ROD.replace(length=0.6, ends="free", damping_rate=60.0)  # that settles it
    run = simulated(rod, duration=0.4, friction=((0.0, 0.1), (0.6, 0.4)), feed_speed=0.5, segments=20, frames=41)
    inside = np.clip(run.positions[:, -1, 0] - 0.3, 0.0, None)
    weight = ROD.weight_per_length
    lost = run.energy["dissipated_friction"]
    expected = weight * (0.1 * 0.6 + (0.4 - 0.1) * inside) * 0.5
    whole = np.concatenate([[0.0], np.cumsum(0.5 * (expected[1:] + expected[:-1]) * np.diff(run.time))])
    assert expected[-1] > 1.9 * expected[0]
    np.testing.assert_allclose(lost[5:] - lost[5], whole[5:] - whole[5], rtol=0.0, atol=0.01 * whole[-1])


# --- files, checkpoints, ensembles ---


def both(**options: Any) -> fr.SimulationProblem:
    """Return a problem with a tool and friction by interval."""
    given = {"duration": 0.03, "frames": 3, "segments": 60, "friction": INTERVALS, **options}
    return fr.SimulationProblem(ROD, STILL, **{"tool": fr.VibrationTool(0.4, 700.0, 1.0), **given})


def test_resumes_saves_and_loads_to_the_bit(tmp_path: Path, tuned: Tuned) -> None:
    tuned(element_steps_of_a_call=1000 * 60)

    def stop(done: int, of: int) -> None:
        if done >= 2000:
            raise KeyboardInterrupt

    problem, file = both(), tmp_path / "run.ckpt"
    whole = problem.run()
    assert not problem.run(stop, checkpoint=file).complete
    for other in (both(tool=None), both(friction=0.5), both(tool=fr.VibrationTool(0.4, 700.0, 0.9))):
        with pytest.raises(ValueError, match=r"belongs to another run, with another (tool|friction)"):
            other.run(checkpoint=file)
    assert problem.run(checkpoint=file) == whole
    assert fr.Simulation.load(whole.save(tmp_path / "run.npz")) == whole
    assert "friction 0.2, 0.5 from 1 m on" in repr(whole)
    said = str(whole.findings().report())
    assert "tool of 0.4 N at 700 rad/s, 1 m above the lower end" in said
    assert whole.as_dict()["tool"] == {"amplitude": 0.4, "frequency": 700.0, "above_end": 1.0}


def test_two_sines_move_the_rod_as_each_of_them_together(tmp_path: Path) -> None:
    tools = (
        None,
        fr.VibrationTool(0.4, 700.0, 1.0),
        fr.VibrationTool(0.3, 1100.0, 1.0),
        fr.VibrationTool(0.4, 700.0, 1.0, second=(0.3, 1100.0)),
    )
    still, one, other, together = (both(tool=tool, friction=0.0, duration=5e-3).run() for tool in tools)
    moved = [run.positions[-1, :, 0] - still.positions[-1, :, 0] for run in (one, other, together)]
    assert abs(moved[1]).max() > 0.1 * abs(moved[0]).max()
    np.testing.assert_allclose(moved[0] + moved[1], moved[2], atol=1e-3 * abs(moved[2]).max())
    assert fr.Simulation.load(together.save(tmp_path / "run.npz")) == together
    said = str(together.findings().report())
    assert "tool of 0.4 N at 700 rad/s and 0.3 N at 1100 rad/s, 1 m above the lower end" in said
    assert together.as_dict()["tool"]["second"] == [0.3, 1100.0]


@pytest.mark.slow
def test_a_run_without_does_not_continue_one_with_a_natural_curvature(tmp_path: Path) -> None:
    bent = fr.SimulationProblem(ROD.replace(path=WELL), STILL, duration=1e-3, segments=56, natural_curvature="path")
    bent.run(checkpoint=tmp_path / "run.ckpt")
    with pytest.raises(ValueError, match="belongs to another run, with another natural_curvature"):
        bent.replace(natural_curvature=0.0).run(checkpoint=tmp_path / "run.ckpt")


def test_a_study_file_takes_both(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    text = 'rod = "nitinol"\nload = {mean = 0.1, amplitude = 0.1, frequency = "20Hz"}\nover = {mean = [0.1]}\n[run]\n'
    file.write_text(text + ('friction = "0.2,0.5@1m"\ntool = "0.4N@700rad/s@1m"'))
    problem = Study.from_toml(file).problem
    assert problem.friction == ((0.0, 0.2), (1.0, 0.5))
    assert problem.tool == fr.VibrationTool(0.4, 700.0, 1.0)
    file.write_text(text + ("friction = [[0, 0.2], [1, 0.5]]"))
    assert Study.from_toml(file).problem.friction == problem.friction
    file.write_text(text + ('tool = "0.4N@700rad/s@1m+0.3N@1100rad/s@90deg"'))
    assert Study.from_toml(file).problem.tool == fr.VibrationTool(0.4, 700.0, 1.0, second=(0.3, 1100.0, 0.5 * math.pi))
    file.write_text(text + ('tool = "0.4N@700rad/s@4m"'))
    with pytest.raises(ValueError, match=r"\[run\] tool must lie in the rod, less than its length 3\.1 m above"):
        Study.from_toml(file)


def test_an_ensemble_varies_the_tool_and_friction() -> None:
    problem = both()
    made = varied(problem, {"tool_amplitude": 0.3, "tool_frequency": 500.0, "tool_above_end": 0.5, "friction": 0.1})
    assert made == problem.replace(tool=fr.VibrationTool(0.3, 500.0, 0.5), friction=0.1)
    with pytest.raises(ValueError, match="tool_amplitude"):
        fr.ensemble(both(tool=None), {"tool_amplitude": [0.1]})


# --- what is refused ---


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"tool": fr.VibrationTool(1.0, 9.0, 3.1)}, ValueError, r"tool must lie in the rod, .* got above_end = 3\.1 m"),
        ({"tool": "5kN@18Hz"}, TypeError, r"tool must be .*VibrationTool"),
        ({"tool": fr.VibrationTool(1e5, 9.0)}, ValueError, "load with its tool strains the rod by"),
        ({"friction": math.nan}, ValueError, "friction must be"),
        ({"friction": -0.1}, ValueError, "friction must be"),
        ({"friction": [(0, 0.1), (1, -0.1)]}, ValueError, "friction must be"),
        ({"friction": [(0, 0.1), (1, math.nan)]}, ValueError, "friction must be"),
        (
            {"friction": [(0, 0.1), (2, 0.2), (1, 0.3)]},
            ValueError,
            "friction must begin at depth 0 and continue with gr",
        ),
        ({"friction": [(1, 0.1)]}, ValueError, "friction must begin at depth 0"),
        ({"friction": [(0, 1, 0.1)]}, TypeError, r"friction\[0\] must be a depth and a coefficient"),
        ({"friction": []}, ValueError, "friction must begin at depth 0"),
    ],
)
def test_refuses_what_cannot_be(options: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        fr.SimulationProblem(ROD, STILL, **options)


def test_growth_is_not_fitted_to_a_shaken_rod() -> None:
    run = simulated(tool=fr.VibrationTool(0.4, 700.0), duration=1e-3)
    with pytest.raises(ValueError, match="growth_rate needs a run without a tool"):
        run.growth_rate()
