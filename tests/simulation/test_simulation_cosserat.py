"""The simulated rod against the full Cosserat rod, another model, with shear, rotary inertia and all of torsion."""

from __future__ import annotations

import math

import numpy as np
import pytest

import floquetrod as fr
from benchmarks import cosserat

ROD = fr.Rod.nitinol()
FORCE = ROD.critical_force


@pytest.mark.slow  # test_growth.py holds the same growth against theory
def test_growth() -> None:
    """The Cosserat rod in the limit of many segments, by its second order; at 250 it is 0.5 % off itself."""
    load, periods = fr.AxialLoad(0.2 * FORCE, 0.2 * FORCE, 150.0), 12
    problem = fr.SimulationProblem(
        ROD,
        load,
        duration=periods * 2.0 * math.pi / load.frequency,
        perturbation=fr.Perturbation.modes({7: 1e-5}),
        frames=16 * periods + 1,
        segments=125,
    )
    coarse, fine = (cosserat.simulate(problem.replace(segments=n)).growth_rate(7).rate for n in (125, 250))
    assert problem.run().growth_rate(7).rate == pytest.approx((4.0 * fine - coarse) / 3.0, rel=5e-4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mean", "amplitude", "mode", "part", "escapes", "within"),
    [(0.825, 0.7, 9, 0.8, False, 0.01), (0.825, 0.7, 9, 1.3, True, 0.05), (0.2, 0.2, 7, 1.0, False, 0.005)],
)
def test_friction(mean: float, amplitude: float, mode: int, part: float, escapes: bool, within: float) -> None:
    """Held by friction, escaping from it (where differences grow with the motion), and held from larger angles."""
    load = fr.AxialLoad(mean * FORCE, amplitude * FORCE, 150.0)
    kick = fr.Perturbation.modes({mode: part * ROD.critical_kick(load, friction=0.1).kick})
    problem = fr.SimulationProblem(ROD, load, duration=0.6, friction=0.1, perturbation=kick, frames=121)
    ours, theirs = problem.run(), cosserat.simulate(problem.replace(segments=250))
    assert ours.buckled == theirs.buckled == escapes
    ours_mode, theirs_mode = (run.mode_amplitudes([mode])[:, 0] for run in (ours, theirs))
    assert np.abs(ours_mode - theirs_mode).max() < within * np.abs(theirs_mode).max()


def test_it_refuses_what_it_does_not_know() -> None:
    problem = fr.SimulationProblem(ROD.replace(inner_radius=0.4e-3), fr.AxialLoad(0.1, 0.1, 150.0), duration=0.01)
    with pytest.raises(ValueError, match="solid, horizontal, hinged"):
        cosserat.simulate(problem)
