"""`fr.simulate`: results, growth rates, checkpoints, interruption, divergence, and what it refuses."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.simulation.growth import fit_growth
from floquetrod.simulation.recorded_motion import angles
from tests.seams import Tuned

ROD = fr.Rod.nitinol()
LOAD = fr.AxialLoad(0.2 * ROD.critical_force, 0.2 * ROD.critical_force, 150.0)
LENGTHY = {"duration": 0.3, "segments": 60, "frames": 31, "friction": 0.1}


def run(**changes: Any) -> fr.Simulation:
    return fr.simulate(ROD, LOAD, **{**LENGTHY, **changes})


@pytest.mark.kernels
def test_a_very_short_run() -> None:
    for friction in (0.0, 0.1):
        result = fr.simulate(
            ROD.replace(damping_rate=1.0), LOAD, duration=1e-4, segments=40, frames=3, friction=friction
        )
        assert result.angle.shape == (3, 41)
        assert result.positions.shape == result.velocities.shape == (3, 41, 3)
        assert result.complete
        assert np.abs(result.energy_error).max() < 1e-3 * result.energy["kinetic"][0]


def test_starts_straight_squeezed_and_with_the_speeds_asked_for() -> None:
    kick = fr.Perturbation.modes({4: 0.01, 6: -0.02}) + fr.Perturbation.random(1e-3, seed=3)
    result = run(perturbation=kick)
    np.testing.assert_allclose(result.velocities[0, :, 1], kick.velocities(60), atol=1e-15)
    assert np.abs(result.angle[0]).max() < 1e-14
    strain = np.ptp(result.positions[0, :, 0]) / ROD.length - 1.0
    assert strain == pytest.approx(-LOAD.mean / (ROD.youngs_modulus * ROD.area), rel=1e-6)
    assert np.ptp(result.positions[:, 0, 1:], axis=0).max() == 0.0  # hinged


def test_same_seed_same_run_and_another_seed_another() -> None:
    one = run()
    assert one == run()
    assert one != run(perturbation=fr.Perturbation.random(1e-3, seed=2))


def test_two_threads_do_not_disturb_each_other() -> None:
    seeds = (1, 2)
    with ThreadPoolExecutor(2) as pool:
        both = list(pool.map(lambda seed: run(perturbation=fr.Perturbation.random(1e-3, seed=seed)), seeds))
    for seed, result in zip(seeds, both, strict=True):
        assert result == run(perturbation=fr.Perturbation.random(1e-3, seed=seed))


@pytest.mark.parametrize("friction", [0.0, 0.1])
@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_energy_balance(friction: float, damping: float) -> None:
    kick = fr.Perturbation.modes({5: 0.3})
    result = fr.simulate(
        ROD.replace(damping_rate=damping),
        LOAD,
        duration=0.3,
        friction=friction,
        perturbation=kick,
        segments=100,
        frames=30,
    )
    turned_over = result.energy["kinetic"][0] + np.abs(result.energy["work"]).max()
    assert np.abs(result.energy_error).max() < 1e-3 * turned_over
    assert (np.diff(result.energy["dissipated"]) >= 0.0).all()
    assert (result.energy["dissipated_friction"][-1] > 0.0) == (friction > 0.0)
    assert (result.energy["dissipated_damping"][-1] > 0.0) == (damping > 0.0)


WITH_THE_WAVE = 4.2434927
"""Growth in 1/s of mode 7 under LOAD by Floquet theory with the axial wave, by fourth-order Magnus steps."""


def test_growth_rate_of_a_mode_near_the_prediction() -> None:
    """At 84 segments, 12 for a half wave; `test_simulation_slow` follows it to the limit."""
    kick = fr.Perturbation.modes({7: 1e-4})
    result = fr.simulate(ROD, LOAD, duration=0.5, perturbation=kick, segments=84)
    fit = result.growth_rate(7)
    assert fit.rate == pytest.approx(WITH_THE_WAVE, rel=1e-3)
    assert fit.error < 0.01
    assert (fit.start, fit.end) == (0.0, pytest.approx(0.5))
    # Damping takes its rate off the growth, and a little more: it shifts beta by c^2.
    rod = ROD.replace(damping_rate=1.5)
    damped = fr.simulate(rod, LOAD, duration=0.5, perturbation=kick, segments=84)
    expected = rod.stability(LOAD).growth_rate - ROD.stability(LOAD).growth_rate
    assert damped.growth_rate(7).rate - fit.rate == pytest.approx(expected, abs=2e-3)  # 5e-4 of the rate


@pytest.mark.slow
def test_a_bounded_mode_does_not_grow() -> None:
    calm = fr.AxialLoad(0.05 * ROD.critical_force, 0.2 * ROD.critical_force, 150.0)
    result = fr.simulate(ROD, calm, duration=0.5, perturbation=fr.Perturbation.modes({7: 1e-3}), segments=60)
    assert result.growth_rate(7).rate == 0.0
    assert not result.buckled
    assert result.dominant_mode == 7


def test_growth_is_fitted_to_floquet_solutions_exactly() -> None:
    time = np.linspace(0.0, 2.0, 400)
    period, rate, damping = 0.0419, 1.3, 0.4
    shape = np.cos(math.pi * time / period) + 0.1 * np.sin(3.0 * math.pi * time / period)
    partner = np.sin(math.pi * time / period)
    undamped = np.exp(rate * time) * shape + 3.0 * np.exp(-rate * time) * partner
    for c in (0.0, damping):
        fit = fit_growth(time, np.exp(-c * time) * undamped, period, c)
        assert fit.rate == pytest.approx(rate - c, rel=5e-5)


@pytest.mark.slow
def test_buckling_under_a_constant_force() -> None:
    kick = fr.Perturbation.random(1e-3, seed=1)
    above = fr.AxialLoad(1.1 * ROD.critical_force, 0.0, 1.0)
    below = fr.AxialLoad(0.9 * ROD.critical_force, 0.0, 1.0)
    buckled = fr.simulate(ROD, above, duration=0.6, perturbation=kick, segments=100)
    calm = fr.simulate(ROD, below, duration=0.6, perturbation=kick, segments=100)
    assert buckled.buckled
    assert buckled.dominant_mode in ROD.stability(above).unstable_modes
    assert not calm.buckled
    assert calm.largest_angle.max() < 0.01


def test_modes_of_what_has_been_simulated() -> None:
    result = run(perturbation=fr.Perturbation.modes({3: 0.02}), friction=0.0)
    amplitudes = result.mode_amplitudes([1, 3, 5])
    assert amplitudes.shape == (31, 3)
    # Only the coupling that large angles bring reaches other modes, and with it those of an odd number of half waves.
    assert np.abs(amplitudes[:, [0, 2]]).max() < 1e-3 * np.abs(amplitudes[:, 1]).max()
    rebuilt = amplitudes @ np.sin(np.outer([1, 3, 5], np.arange(61) * math.pi / 60))
    np.testing.assert_allclose(rebuilt, result.angle, atol=1e-3 * np.abs(result.angle).max())


class Stop:
    """Progress that presses Ctrl-C after so many calls."""

    def __init__(self, calls: int) -> None:
        self.calls = calls

    def __call__(self, done: int, total: int) -> None:
        """Count down."""
        self.calls -= 1
        if self.calls == 0:
            raise KeyboardInterrupt


@pytest.mark.parametrize("calls", [7, *(pytest.param(calls, marks=pytest.mark.slow) for calls in (1, 20))])
def test_resumes_to_the_bit(tmp_path: Path, calls: int) -> None:
    path = tmp_path / "run.ckpt"
    cut_short = run(checkpoint=path, progress=Stop(calls))
    assert not cut_short.complete
    assert "interrupted" in repr(cut_short)
    assert 1 <= cut_short.time.size < 31
    assert run(checkpoint=path) == run()
    finished = run(checkpoint=path)  # nothing is left to do
    assert finished.complete


def test_resumes_within_a_frame(tmp_path: Path, tuned: Tuned) -> None:
    tuned(element_steps_of_a_call=60_000)
    path = tmp_path / "run.ckpt"
    long_frames = {"frames": 3, "checkpoint": path}
    assert run(**long_frames, progress=Stop(4)).time.size == 1
    assert run(**long_frames) == run(frames=3)


def test_checkpoints_are_written_on_the_way(tmp_path: Path, tuned: Tuned) -> None:
    tuned(seconds_between_checkpoints=0.0)
    path = tmp_path / "run.ckpt"

    def killed(done: int, total: int) -> None:
        if done > total // 2:
            raise MemoryError  # what ends a run without asking

    with pytest.raises(MemoryError):
        run(checkpoint=path, progress=killed)
    assert list(tmp_path.iterdir()) == [path]
    calls: list[int] = []
    assert run(checkpoint=path, progress=lambda done, total: calls.append(done)) == run()
    assert calls[0] > 0.5 * calls[-1]


def test_a_checkpoint_of_another_run_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.ckpt"
    run(checkpoint=path, progress=Stop(1))
    with pytest.raises(ValueError, match=r"belongs to another run, with another friction"):
        run(checkpoint=path, friction=0.2)


@pytest.mark.parametrize("damage", ["cut", "bits", "text", "foreign"])
def test_a_damaged_checkpoint_is_refused(tmp_path: Path, damage: str) -> None:
    path = tmp_path / "run.ckpt"
    cut_short = run(checkpoint=path, progress=Stop(2))
    whole = bytearray(path.read_bytes())
    if damage == "cut":
        path.write_bytes(whole[: len(whole) // 2])
    elif damage == "bits":
        whole[len(whole) // 3] ^= 255
        path.write_bytes(whole)
    elif damage == "text":
        path.write_text("not a checkpoint")
    else:
        cut_short.save(path)
    with pytest.raises(ValueError, match="is not a checkpoint of a simulation that can be read"):
        run(checkpoint=path)


def test_divergence_names_time_and_cause_and_keeps_the_frames_before(tuned: Tuned) -> None:
    tuned(share_of_the_critical_step=1.3)
    with pytest.raises(fr.SimulationDiverged, match=r"diverged before t = .* s; likely cause: ") as caught:
        run(frames=301, friction=0.0)
    kept = caught.value.simulation
    assert 1 <= kept.time.size < 301
    assert np.isfinite(kept.positions).all()
    assert not kept.complete


def test_saved_and_loaded_whole(tmp_path: Path) -> None:
    result = run()
    path = result.save(tmp_path / "run.npz")
    assert fr.Simulation.load(path) == result
    for content in (path.read_bytes()[:1000], b"nothing"):
        path.write_bytes(content)
        with pytest.raises(ValueError, match="is not a simulation that can be read"):
            fr.Simulation.load(path)


def test_repr_reads_like_a_sentence() -> None:
    assert repr(run()).startswith("<not buckled, largest angle 0.")
    assert "friction 0.1" in repr(run())
    assert "set by stretch" in repr(run())


@pytest.mark.slow
def test_drawings(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib").use("Agg")
    from matplotlib import pyplot

    result = run(frames=4)
    assert result.plot().get_xlabel().startswith("along the channel")
    assert len(result.plot_energy().lines) == 8
    animation = result.animate()
    animation.save(tmp_path / "run.gif", writer="pillow", dpi=20)
    assert (tmp_path / "run.gif").stat().st_size > 0
    pyplot.close("all")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"duration": 0.0}, "duration must be greater than zero"),
        ({"friction": -0.1}, "friction must be zero or more"),
        ({"frames": 1}, "frames must be 2 or more"),
        ({"segments": 20}, "segments must be at least 37, got 20: 6 for every half wave of the critical mode 6.14"),
        ({"segments": 5000}, "segments must be at most 3875"),
        ({"segments": 60, "perturbation": fr.Perturbation.modes({11: 0.1})}, "names mode 11, which 60 segments cannot"),
        ({"time_step": 1e-4}, r"time_step must be at most 1.2\d+e-05 s.* unstable, by stretch"),
        ({"poisson_ratio": 0.6}, "poisson_ratio must be above -1 and at most 0.5"),
        ({"indentation": 0.2}, "indentation must be at most 0.1 of the radial clearance"),
        ({"contact_damping": -1.0}, "contact_damping must be zero or more"),
    ],
)
def test_refuses_what_cannot_be(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        run(**changes)


def test_refuses_other_types_and_crushing_loads() -> None:
    with pytest.raises(TypeError, match="rod must be a Rod"):
        fr.simulate("rod", LOAD)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="load must be an AxialLoad"):
        fr.simulate(ROD, 0.3)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="perturbation must be a Perturbation"):
        run(perturbation={7: 0.1})
    with pytest.raises(ValueError, match=r"load strains the rod by 0\.07"):
        fr.simulate(ROD, fr.AxialLoad(1e4, 0.0, 1.0))


def test_a_smaller_step_may_be_asked_for() -> None:
    result = run(time_step=5e-6, duration=0.01)
    assert result.time_steps.size <= 5e-6
    assert result.time_steps.limit == "choice"
    stiff = run(indentation=1e-9, duration=1e-3, frames=2)
    assert stiff.time_steps.limit == "contact"


def test_growth_rate_refuses_what_it_cannot_fit() -> None:
    with pytest.raises(ValueError, match="frictionless"):
        run().growth_rate(7)
    with pytest.raises(ValueError, match=r"needs 8 frames a forcing period: ask for \d+ frames"):
        run(friction=0.0, frames=10).growth_rate(7)
    with pytest.raises(ValueError, match="needs three forcing periods"):
        run(friction=0.0, duration=0.1).growth_rate(7)
    with pytest.raises(ValueError, match=r"modes\[0\] must be at most 30, got 31; 60 segments resolve"):
        run().mode_amplitudes([31])


def test_perturbations_add_up() -> None:
    one, other = fr.Perturbation.modes({3: 0.1}), fr.Perturbation.random(0.2, seed=5)
    both = (one + other).velocities(100)
    np.testing.assert_allclose(both, one.velocities(100) + other.velocities(100))
    assert both[0] == both[-1] == 0.0
    assert np.abs(other.velocities(100)).max() <= 0.2


def test_cases_of_the_paper() -> None:
    case = fr.Perturbation.case
    assert case("A", mode=6) == fr.Perturbation.modes({6: 0.05})
    assert dict(case("B").speeds) == dict.fromkeys((4, 6, 8, 10), 0.05)
    c = dict(case("C", mode=10, seed=4).speeds)
    assert c[10] == 0.05
    assert sorted(c) == list(range(1, 21))
    assert max(map(abs, c.values())) <= 0.05
    assert case("D", seed=2) == fr.Perturbation.random(0.05, seed=2)
    for name in ("E", "AB", "CD", "ABCD", "", "a", "A "):
        with pytest.raises(ValueError, match="name must be one of 'A', 'B', 'C', 'D'"):
            case(name)


def test_perturbations_refused() -> None:
    with pytest.raises(TypeError, match="speeds must map modes to speeds"):
        fr.Perturbation.modes([8])  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="mode 0 must be 1 or more"):
        fr.Perturbation.modes({0: 0.1})
    with pytest.raises(ValueError, match="speed of mode 8 must be finite"):
        fr.Perturbation.modes({8: math.nan})
    with pytest.raises(ValueError, match="seed must be 0 or more"):
        fr.Perturbation.random(0.1, seed=-1)
    for speed in (1e6, -1e300):
        with pytest.raises(ValueError, match=r"speed must be at most 100000 m/s, got .* check the units"):
            fr.Perturbation.random(speed, seed=1)
        with pytest.raises(ValueError, match="speed of mode 8 must be at most"):
            fr.Perturbation.modes({8: speed})
    with pytest.raises(ValueError, match="highest must be at most 16,666"):
        fr.Perturbation.case("C", highest=10**12)
    with pytest.raises(ValueError, match="segments must be at most 100,000"):
        fr.Perturbation().velocities(10**9)
    with pytest.raises(TypeError):
        fr.Perturbation() + 1  # type: ignore[operator]


def test_angles_do_not_depend_on_where_in_memory_places_are() -> None:
    places = np.random.default_rng(1).standard_normal((5, 61, 3))
    known, kept = angles(places), []
    for i in range(300):
        kept.append(np.empty(7 * i % 911))  # so that the next copy comes to lie elsewhere
        assert np.array_equal(angles(places.copy()), known)
