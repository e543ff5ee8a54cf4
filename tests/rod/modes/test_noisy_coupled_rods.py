"""Coupled modes of rods under noise: clamped ends, weight along the rod, paths that bend."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.rod.modes.noisy_coupled import NoisyCoupledModel
from tests.conftest import depth
from tests.inside import Answers, Loads, ModeModel
from tests.seams import Heard

ROD = fr.Rod.nitinol().replace(damping_rate=1.0)
CLAMPED = ROD.replace(ends="clamped")
HIGH_MODES = 8.0 * ROD.damping_rate * ROD.flexural_rigidity * ROD.mass_per_length


def load(rod: fr.Rod, noise: object, mean: float = 0.3, amplitude: float = 0.1) -> fr.AxialLoad:
    return fr.AxialLoad(mean * rod.critical_force, amplitude * rod.critical_force, 150.0, noise=noise)


@pytest.mark.slow
def test_independent_modes_seen_as_coupled_grow_alike() -> None:
    """The modes of hinged ends, all at once and one by one, within the error that is stated."""
    force = load(ROD, 0.9 * HIGH_MODES, -0.3, 0.2)
    together, alone = NoisyCoupledModel(ROD, force).verdict(force), ROD.stability(force)
    assert together.status == alone.status == "stable"
    assert abs(together.exponents[0].real - float(alone.mode_growth_rates.max())) <= together.error < 1e-4


@pytest.mark.slow
def test_independent_modes_seen_as_coupled_bear_alike() -> None:
    rng, judged = np.random.default_rng(5), 0
    for _ in range(depth(20, 8)):
        force = load(ROD, float(rng.uniform(0.0, 1.2)) * HIGH_MODES, rng.uniform(-0.5, 0.6), rng.uniform(0.0, 0.3))
        alone = ROD.stability(force)
        model = NoisyCoupledModel(ROD, force)
        assert model.verdict(force).status in (alone.status, "undecided")
        judged += model.verdict(force).status == alone.status
        if ROD.stability(load(ROD, 0.0, force.mean / ROD.critical_force, 0.0)).status == alone.status == "stable":
            assert model.critical_noise(force, 0.0) == pytest.approx(ROD.critical("noise", force), rel=1e-5)
    assert judged > 5


def test_few_clamped_modes_grow_as_all_their_moments_do() -> None:
    force = load(CLAMPED, 0.4 * HIGH_MODES, 0.05)
    found = CLAMPED.stability(force, modes=range(1, 3))
    model = CLAMPED._modes_under(force)
    assert isinstance(model, NoisyCoupledModel)
    modes = model.in_modes(2)
    system = CLAMPED.modal_system(replace(force, noise=0.0), range(1, 3))
    s = float(np.sqrt(0.2 * HIGH_MODES))
    exact = fr.stability(fr.second_moments(system, [(modes.softening(force.mean), s)]), "monodromy")
    assert abs(found.exponents[0].real - exact.exponents[0].real) <= found.error + 1e-9
    assert found.error < 1e-4


@pytest.mark.slow
def test_clamped_ends_under_noise() -> None:
    quiet, loud = (CLAMPED.stability(load(CLAMPED, share * HIGH_MODES)) for share in (0.2, 0.6))
    assert (quiet.status, loud.status) == ("stable", "unstable")
    assert "in mean square" in str(loud)
    assert quiet.error < 1e-4
    assert str(loud.report()).count("coupled modes") == 3
    assert loud.as_dict()["in_mean_square"] is True


@pytest.mark.slow
def test_the_noise_that_clamped_ends_bear_separates_verdicts() -> None:
    unit = load(CLAMPED, 1.0)
    most = CLAMPED.critical("noise", unit)
    assert most < HIGH_MODES
    assert 0.0 < most.error < 1e-4 * most
    for factor, status in ((1.0 - 1e-4, "stable"), (1.0 + 1e-4, "unstable")):
        assert CLAMPED.stability(replace(unit, noise=factor * most)).status == status
    found = CLAMPED.stability(replace(unit, noise=1.3 * most))
    rate = found.damping_to_stabilise
    for factor, status in ((1.0 - 1e-3, "unstable"), (1.0 + 1e-3, "stable")):
        assert CLAMPED.replace(damping_rate=factor * rate).stability(found.load).status == status
    pulled = fr.AxialLoad(-1.0, 0.0, 150.0, noise=1.0)
    assert CLAMPED.critical("noise", pulled) == pytest.approx(HIGH_MODES, rel=1e-9)


def test_margins_pass_over_growth_within_their_tolerance(monkeypatch: pytest.MonkeyPatch) -> None:
    """As those of all other modes: loads whose growth is below `RodStability.margin_tolerance` count as stable."""
    force = load(CLAMPED, 0.2 * HIGH_MODES)
    verdict = CLAMPED.stability(force, modes=range(1, 3))
    assert (verdict.status, verdict.margin_tolerance) == ("stable", 1e-6)

    def answers(model: NoisyCoupledModel, loads: Loads, growth_tolerance: float = 0.0, *given: Any) -> Answers:
        growth = np.where(loads.amplitude > 3.0 * force.amplitude, 1.0, 0.0)
        growth[(loads.amplitude > 1.1 * force.amplitude) & (growth == 0.0)] = 5e-7
        return Answers((growth <= growth_tolerance).astype(np.int8), growth, np.zeros(loads.size, dtype=np.int64))

    monkeypatch.setattr(NoisyCoupledModel, "answers", answers)
    monkeypatch.setattr(NoisyCoupledModel, "status", ModeModel.status)
    margin = verdict.margin("amplitude", seconds=10.0)
    assert force.amplitude + margin.above == pytest.approx(3.0 * force.amplitude, rel=1e-5)


@pytest.mark.slow
def test_a_search_for_a_margin_keeps_to_its_time(heard: Heard) -> None:
    """By an estimate of what a verdict takes; a part that is begun takes seven of them at least."""
    verdict = CLAMPED.stability(load(CLAMPED, 0.4 * HIGH_MODES, 0.05))
    asked = heard(NoisyCoupledModel, "status")
    each = verdict.evidence.seconds
    assert verdict.margin("mean", seconds=2.0 * each).searched == (0.0, 0.0)
    assert not asked
    assert 0.0 < verdict.margin("mean", seconds=16.0 * each).above < np.inf
    assert sum(loads.size for _, loads, *_ in asked) <= 4 * 7


@pytest.mark.slow
def test_progress_counts_all_loads() -> None:
    """Those that grow without noise too; the search for these is the first half."""
    rod = CLAMPED.replace(length=0.3)
    force, told = load(rod, 0.1 * HIGH_MODES), []
    mean = np.array([100.0, 0.3, 110.0, 0.2, 120.0]) * rod.critical_force
    found = rod.verdicts(force, mean=mean, frequency=800.0, progress=lambda done, total: told.append((done, total)))
    assert found.tolist() == [0, 1, 0, 1, 0]
    assert told == sorted(told)
    assert (told[0], told[-1]) == ((2, 5), (5, 5))
    assert len(told) > 3


@pytest.mark.slow
def test_maps_and_arrays_say_what_single_loads_do() -> None:
    like = load(CLAMPED, 0.2 * HIGH_MODES)
    mean = np.array([0.1, 0.3, 0.5]) * CLAMPED.critical_force
    status = CLAMPED.verdicts(like, mean=mean)
    alone = [CLAMPED.stability(like.varied("mean", each)) for each in mean.tolist()]
    assert status.tolist() == [{"stable": 1, "unstable": 0}[each.status] for each in alone]
    growth = CLAMPED.growth_rate(like, mean=mean)
    assert growth == pytest.approx([each.growth_rate for each in alone], abs=1e-9)


@pytest.mark.slow
def test_noise_adds_to_the_growth_that_is_there_without_it() -> None:
    rod = ROD.replace(ends="clamped-hinged", length=0.97, damping_rate=0.35)
    like = fr.AxialLoad(0.33 * rod.critical_force, 0.2 * rod.critical_force, 274.0, noise=0.02)
    alone = rod.stability(like)
    assert rod.stability(replace(like, noise=0.0)).status == alone.status == "unstable"
    growth, mode = rod.growth_rate(like, return_mode=True)
    assert growth == pytest.approx(alone.growth_rate, abs=1e-9)
    assert mode == -1
    means = (0.1 * CLAMPED.critical_force, 0.5 * CLAMPED.critical_force, 3)
    chart = fr.stability_map(CLAMPED, like, mean=means, frequency=(100.0, 200.0, 3))
    single = [CLAMPED.stability(replace(like, mean=mean, frequency=150.0)) for mean in np.linspace(*means)]
    assert chart.stable[:, 1].tolist() == [each.stable for each in single]


@pytest.mark.slow
def test_a_density_that_varies_is_judged_by_its_largest() -> None:
    """Stable where white noise of the largest density is; else only what grows without noise is unstable."""
    share = ((0.0, 0.2 * HIGH_MODES), (300.0, 0.1 * HIGH_MODES), (301.0, 0.0))
    assert CLAMPED.stability(load(CLAMPED, share)).status == "stable"
    louder = tuple((at, 4.0 * density) for at, density in share)
    found = CLAMPED.stability(load(CLAMPED, louder))
    assert (found.status, found.note[:11]) == ("undecided", "white noise")
    assert CLAMPED.critical("noise", load(CLAMPED, share)) == pytest.approx(
        CLAMPED.critical("noise", load(CLAMPED, 0.2 * HIGH_MODES)), rel=1e-9
    )


def test_what_takes_too_long_or_is_not_known_is_told() -> None:
    force = load(CLAMPED, 0.1 * HIGH_MODES)
    with pytest.raises(ValueError, match="certify is not answered under noise"):
        CLAMPED.certify(force)
    with pytest.raises(ValueError, match="too many for their second moments"):
        CLAMPED.stability(replace(force, frequency=0.01))
