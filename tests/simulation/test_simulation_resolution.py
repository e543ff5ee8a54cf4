"""How many segments the waves need that a load makes grow, what is said of too few, and of a rod off the wall."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.simulation.driving import Driving
from floquetrod.simulation.resolution import growing_waves

ROD = fr.Rod.nitinol()
FORCE = ROD.critical_force
STRONG = fr.AxialLoad(3.0 * FORCE, 0.0, 100.0)


@pytest.mark.parametrize(
    "load",
    [
        STRONG,
        fr.AxialLoad(3.0 * FORCE, 0.5 * FORCE, 100.0),
        fr.AxialLoad(1.1 * FORCE, 0.0, 100.0),
        fr.AxialLoad(0.8 * FORCE, 0.7 * FORCE, 60.0),
    ],
)
def test_the_waves_that_grow_are_those_of_the_verdict(load: fr.AxialLoad) -> None:
    verdict, waves = ROD.stability(load), growing_waves(Driving(ROD, load), duration=2.0)
    fast = verdict.mode_growth_rates >= 0.5 * verdict.growth_rate
    # Inertia along the rod, which the simulated rod has, changes growth a little.
    assert waves.rate == pytest.approx(verdict.growth_rate, rel=5e-3)
    assert waves.fastest == verdict.fastest_mode
    assert waves.highest == verdict.modes[int(np.flatnonzero(fast)[-1])]
    assert waves.least_segments == 6 * waves.highest


def test_what_hardly_grows_in_the_time_simulated_needs_no_segments() -> None:
    load = fr.AxialLoad(0.2 * FORCE, 0.2 * FORCE, 150.0)  # mode 7 grows at 4.2 1/s
    assert growing_waves(Driving(ROD, load), 0.1).highest == 0
    assert growing_waves(Driving(ROD, load), 2.0).highest == 7


def test_waves_that_grow_slowly_count_in_a_long_time() -> None:
    load = fr.AxialLoad(0.2 * FORCE, 0.063 * FORCE, 150.0)
    verdict, waves = ROD.stability(load), growing_waves(Driving(ROD, load), 60.0)
    assert 0.1 < verdict.growth_rate < 1.0
    assert waves.rate == pytest.approx(verdict.growth_rate, abs=0.01)
    assert waves.fastest == verdict.fastest_mode


@pytest.mark.parametrize("ends", ["hinged", "clamped"])
def test_segments_follow_the_force_that_a_wave_makes_along_the_rod(ends: str) -> None:
    """Near a resonance of the held rod the force inside is several times that at the end that is driven."""
    resonance = 0.5 * math.pi * ROD.wave_speed / ROD.length
    loads = [
        fr.AxialWave(0.0, 0.3 * FORCE, part * resonance, far_end="free", axial_damping=1.0) for part in (0.5, 1.97)
    ]
    far, near = (fr.SimulationProblem(ROD.replace(ends=ends), load) for load in loads)
    strongest = near.driving.forces(9, 4)[0][2].max()
    assert strongest > 5.0 * far.driving.forces(9, 4)[0][2].max()
    waves = growing_waves(near.driving, 2.0)
    assert (waves.rate, waves.fastest) == ROD.growth_rate(
        mean=0.0, amplitude=strongest, frequency=near.load.frequency, return_mode=True
    )
    assert near.segments >= waves.least_segments > 0
    assert near.unresolved == far.unresolved == ""


def test_too_few_segments_are_told_with_numbers() -> None:
    problem = fr.SimulationProblem(ROD, STRONG, duration=0.3, segments=37, frames=100)
    assert fr.SimulationProblem(ROD, STRONG, duration=0.3).segments >= 84
    with pytest.warns(fr.ResolutionWarning) as caught:
        run = problem.run()
    assert [str(warning.message) for warning in caught] == [
        "37 segments resolve modes up to 6, and by theory mode 11 grows fastest and modes up to 14 at half its rate or "
        "more: the growing modes and their rates will be wrong; take 84 or more, or leave segments out for 107"
    ]
    assert caught[0].filename == __file__
    assert "by theory mode 11 grows fastest" in run.note
    assert run.note in repr(run)
    assert "buckled in mode" not in repr(run)
    # The mode named is that of the nodes, not the highest of those resolved.
    assert run.dominant_mode > 6


def test_enough_segments_are_taken_without_a_word() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = fr.simulate(ROD, STRONG, duration=0.02, segments=84, frames=5)
        assert run.note == ""


def test_growth_of_modes_that_segments_hardly_resolve_has_an_error_that_says_so() -> None:
    """The error stays honest: the fit lies within it of theory, and it grows as segments are taken away."""
    errors = []
    for segments in (44, 66, 110):
        kick = fr.Perturbation(noises=((1e-6, 3),))
        problem = fr.SimulationProblem(ROD, STRONG, duration=0.08, segments=segments, frames=81, perturbation=kick)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", fr.ResolutionWarning)
            fit = problem.run().growth_rate(11)
        assert abs(fit.rate - ROD.stability(STRONG, [11]).growth_rate) < fit.error
        errors.append(fit.model_error)
    assert errors == sorted(errors, reverse=True)


@pytest.mark.slow
def test_a_rod_that_has_left_the_wall_says_so_in_place_of_a_mode() -> None:
    load = fr.AxialLoad(0.2 * FORCE, 0.2 * FORCE, 150.0)
    thrown = fr.simulate(ROD, load, duration=0.5, perturbation=fr.Perturbation.modes({3: 3.0}))
    radius = np.hypot(thrown.positions[-100:, :, 1], thrown.positions[-100:, :, 2])
    off = radius.min(axis=1) < 0.99 * ROD.radial_clearance
    assert thrown.left_wall == off.mean() > 0.5
    assert thrown.note == f"off the wall in {100 * off.mean():.0f} % of the frames of the last quarter"
    assert repr(thrown).startswith("<not buckled, swinging on to")  # 3 m/s throw it as far without any load
    lying = fr.simulate(ROD, load, duration=0.5, perturbation=fr.Perturbation.modes({7: 0.02}))
    assert (lying.left_wall < 0.5, lying.note) == (True, "")
