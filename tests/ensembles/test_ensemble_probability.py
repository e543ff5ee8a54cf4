"""Probabilities over the runs of an ensemble: intervals that cover, where runs share a sample or a seed, too."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

import floquetrod as fr
from floquetrod import cli
from floquetrod._util.probability_interval import clopper_pearson, mean_of_shares
from floquetrod.ensembles import Runs, probability, varied_axes
from floquetrod.ensembles.shares import probability_of
from floquetrod.ensembles.variables import Variable
from tests.ensemble_cases import PROBLEM, assert_same, in_memory

FRICTION = stats.uniform(0.1, 0.1)
"""Of samples."""


def depth(many: int, few: int) -> Any:
    """Return a parameter: few draws, and many under `make slow`."""
    return pytest.mark.parametrize("draws", [few, pytest.param(many, marks=pytest.mark.slow)])


def runs_of(true: NDArray[Any], dims: tuple[str, ...], coords: dict[str, tuple[tuple[str, ...], Any]]) -> Runs:
    """Return runs that are all done, with a result."""
    values = {"status": np.ones(true.shape, int), "far": true}
    return Runs(
        {name: Variable(dims, each, {}) for name, each in values.items()},
        {name: Variable(of, np.asarray(each), {}) for name, (of, each) in coords.items()},
        {},
    )


def limits(runs: Runs, over: Any, confidence: float = 0.95) -> tuple[float, float, float]:
    """Return the probability over everything and the ends of its interval."""
    found = probability(runs, "far", over=over, confidence=confidence)
    return float(found["probability"]), float(found["lower"]), float(found["upper"])


# --- the interval ----------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("n", [1, 2, 7, 40])
def test_the_interval_of_whole_shares_is_that_of_clopper_and_pearson(n: int) -> None:
    for hits in range(n + 1):
        shares = np.r_[np.ones(hits), np.zeros(n - hits)]
        expected = [float(end) for end in clopper_pearson(hits, n, 0.9)]
        assert mean_of_shares(shares, shares, 0.9) == pytest.approx(expected, abs=1e-11)


def test_its_ends_are_quantiles_of_weighted_sums(rng: np.random.Generator) -> None:
    for n in (1, 3, 12):
        shares = rng.binomial(5, 0.7, n) / 5.0
        weights = rng.dirichlet(np.ones(n + 1), 200_000)
        low, high = mean_of_shares(shares, shares, 0.9)
        assert np.mean(weights @ np.append(shares, 1.0) > high) == pytest.approx(0.05, abs=0.003)
        assert np.mean(weights @ np.append(shares, 0.0) < low) == pytest.approx(0.05, abs=0.003)


@pytest.mark.slow
def test_of_thousands_of_shares_some_are_averaged_first(rng: np.random.Generator) -> None:
    shares = rng.binomial(4, 0.3, 2500) / 4.0
    low, high = mean_of_shares(shares, shares, 0.95)
    normal = 1.96 * shares.std() / 50.0
    assert low == pytest.approx(shares.mean() - normal, abs=0.4 * normal)
    assert high == pytest.approx(shares.mean() + normal, abs=0.4 * normal)


KINDS: dict[str, Callable[[np.random.Generator, float, int], NDArray[np.float64]]] = {
    "seed alone": lambda rng, p, n: np.full(n, p),
    "sample alone": lambda rng, p, n: (rng.random(n) < p).astype(float),
    "both": lambda rng, p, n: rng.beta(2.0 * p, 2.0 * (1.0 - p), n),
    "a rare kind of sample": lambda rng, p, n: np.where(rng.random(n) < 0.04, 1.0, (p - 0.04) / 0.96),
}
"""How probable the result is in each of n samples, p on average."""


@pytest.mark.slow
@depth(600, 30)
@pytest.mark.parametrize("kind", KINDS)
def test_the_interval_covers_what_is_true(kind: str, draws: int) -> None:
    """Of samples with seeds of their own, as the ensemble derives them; the seed of a run decides about it."""
    rng = np.random.default_rng(draws + list(KINDS).index(kind))
    for p, samples, seeds in ((0.83, 20, 10), (0.08, 12, 5), (0.5, 4, 6)):
        hits, widths = 0, 0.0
        for draw in range(draws // 3):
            over = {"friction": FRICTION, "seed": range(seeds)}
            study = varied_axes.design_of(PROBLEM, over, "grid", samples, draw)
            uniform = np.vectorize(lambda seed: np.random.default_rng(seed).random())(study.own_seeds)
            true = uniform < KINDS[kind](rng, p, samples)[:, None]
            run_seed = ("sample", "seed"), study.own_seeds
            share, low, high = limits(runs_of(true, ("sample", "seed"), {"run_seed": run_seed}), ["seed", "sample"])
            assert share == pytest.approx(true.mean())
            assert low <= share <= high
            hits, widths = hits + (low <= p <= high), widths + high - low
        count = draws // 3
        assert hits / count >= 0.95 - 3.0 * np.sqrt(0.95 * 0.05 / count), f"{hits} of {count} at {p}"
        if kind == "seed alone" and samples == 20:  # and seeds are worth something
            assert widths / count < 0.8 * np.subtract(*clopper_pearson(17, 20, 0.95)[::-1])


@pytest.mark.slow
def test_runs_that_share_seeds_would_not_be_covered() -> None:
    """Of samples that all have the same ten seeds, pooled as if independent, two intervals in three miss."""
    rng, p, missed = np.random.default_rng(1), 0.83, 0
    for _ in range(300):
        true = np.tile(rng.random(10) < p, (20, 1))
        low, high = clopper_pearson(true.sum(), 200, 0.95)
        missed += not low <= p <= high
        with pytest.raises(ValueError, match="over names sample and seed, but all samples have the same seeds"):
            limits(runs_of(true, ("sample", "seed"), {}), ("sample", "seed"))
        for over in ("sample", "seed"):
            probability(runs_of(true, ("sample", "seed"), {}), "far", over=over)
    assert missed > 150


@pytest.mark.slow
@depth(2000, 80)
def test_chosen_values_are_averaged_within_a_seed(draws: int) -> None:
    """Of kicks that have their seeds in common, each seed counts once."""
    rng, covered, naive = np.random.default_rng(draws), 0, 0
    for _ in range(draws):
        true = np.tile(rng.random(15) < 0.6, (4, 1)) & (np.arange(4) != 3)[:, None]
        _, low, high = limits(runs_of(true, ("kick", "seed"), {}), ("kick", "seed"))
        covered += low <= 0.45 <= high
        naive += bool(np.less_equal(*clopper_pearson(true.sum(), 60, 0.95)[:1], 0.45)) and bool(
            clopper_pearson(true.sum(), 60, 0.95)[1] >= 0.45
        )
    assert covered >= (0.95 - 3.0 * np.sqrt(0.0475 / draws)) * draws
    assert naive < 0.9 * draws
    with pytest.raises(ValueError, match=r"over must name a dimension along which runs are drawn.*got kick, whose"):
        limits(runs_of(true[:, :1], ("kick", "seed"), {}), "kick")


def test_rows_of_a_list_with_one_seed_count_once() -> None:
    true = np.tile(np.arange(12) < 7, 5)
    crossed = runs_of(true, ("run",), {"seed": (("run",), np.tile(np.arange(12), 5))})
    assert limits(crossed, "run") == pytest.approx(limits(runs_of(true[:12], ("run",), {}), "run"))
    apart = runs_of(true, ("run",), {"seed": (("run",), np.arange(60))})
    assert limits(apart, "run")[1:] == pytest.approx([float(end) for end in clopper_pearson(35, 60, 0.95)])


def test_failed_and_pending_runs_widen_the_interval() -> None:
    def interval(status: Any, over: tuple[str, ...] = ("kick", "seed")) -> tuple[float, float, float]:
        status = np.array(status)
        far = Variable(("kick", "seed"), status == 1, {})
        return limits(Runs({"status": Variable(("kick", "seed"), status, {}), "far": far}, {}, {}), over)

    share, low, high = interval([[1, 1, 1], [1, 1, 2]])
    assert share == 1.0
    assert (low, high) == pytest.approx((mean_of_shares(np.array([1, 1, 0.5]), np.ones(3), 0.95)[0], 1.0))
    assert interval([[1, 1, 1], [1, 1, 0]]) == (share, low, high)
    share, low, high = interval([[0, 0, 0], [0, 0, 0]])
    assert np.isnan(share)
    assert (low, high) == (0.0, 1.0)


# --- seeds -----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_every_sample_has_seeds_of_its_own() -> None:
    over = {"seed": [3, 4, 5], "friction": FRICTION, "kick": [0.02, 0.1]}
    found = fr.ensemble(PROBLEM, over, samples=4, seed=9)
    assert dict(found.sizes) == {"seed": 3, "sample": 4, "kick": 2}
    assert found.run_seed.dims == ("sample", "seed")
    assert np.unique(found.run_seed).size == 12
    one = found.isel(seed=2, sample=1, kick=1)
    values = {"friction": float(one.friction), "seed": int(one.run_seed), "kick": 0.1}
    assert float(one.largest_angle) == varied_axes.varied(PROBLEM, values).run().largest_angle.max()
    assert_same(found, fr.ensemble(PROBLEM, over, samples=4, seed=9))
    # More seeds leave those that there were; another seed of the ensemble changes all.
    more = varied_axes.design_of(PROBLEM, over | {"seed": [4, 5, 6]}, "grid", 4, 9).own_seeds
    assert np.array_equal(more[:, :2], found.run_seed.values[:, 1:])
    assert not np.isin(varied_axes.design_of(PROBLEM, over, "grid", 4, 10).own_seeds, found.run_seed.values).any()
    assert "run_seed" not in fr.ensemble(PROBLEM, {"seed": [1], "kick": [0.1]}).coords
    with pytest.raises(ValueError, match="names that are not taken, got 'run_seed'"):
        fr.ensemble(PROBLEM, over, samples=4, summary=lambda run: {"run_seed": 1.0})


def test_seeds_of_any_numbers_differ() -> None:
    pairs = [(i, k) for i in (0, 1, 7, 2**20) for k in (0, 1, 7, 2**31, 2**32, 2**32 + 1, 2**62 - 1)]
    seeds = {varied_axes._own_seed(drawn, *pair) for pair in pairs for drawn in (0, 1, 2**40)}
    assert len(seeds) == 3 * len(pairs)
    assert all(0 <= seed < 2**62 for seed in seeds)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["runs.npz", "runs.zarr"])
def test_a_store_of_samples_and_seeds_goes_on(kind: str, tmp_path: Path) -> None:
    place, over = tmp_path / kind, {"friction": FRICTION, "seed": range(3)}

    def interrupt(done: int, total: int) -> None:
        if done == 4:
            raise KeyboardInterrupt

    fr.ensemble(PROBLEM, over, samples=4, store=place, progress=interrupt)
    assert_same(fr.ensemble(PROBLEM, over, samples=4, store=place), fr.ensemble(PROBLEM, over, samples=4))
    with pytest.raises(ValueError, match=r"it has other values of friction; seeds \[0, .* there, \[1, .* here; give"):
        fr.ensemble(PROBLEM, over, samples=4, seed=1, store=place)


STUDY = """
rod = "nitinol"
load = {mean = "0.3N", amplitude = "0.3N", frequency = "150rad/s"}
run = {duration = "10ms", segments = 60, frames = 5}
ensemble = {samples = 4, seed = 9}
[over]
friction = {distribution = "uniform", low = 0.1, high = 0.2}
seed = {from = 3, to = 5}
kick = ["20mm/s", "100mm/s"]
"""


@pytest.mark.slow
def test_python_a_study_and_the_terminal_say_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import json

    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    study = fr.Study.from_toml(path).run()
    over = {"friction": FRICTION, "seed": [3, 4, 5], "kick": [0.02, 0.1]}
    assert_same(study, fr.ensemble(PROBLEM, over, samples=4, seed=9))
    with pytest.warns(fr.OutcomeWarning, match="runs counted as not buckled, still swinging"):
        expected = study.floquetrod.probability(over=["sample", "seed"])
    with pytest.warns(fr.OutcomeWarning):
        assert np.array_equal(probability(in_memory(study), over=("seed", "sample"))["upper"], expected.upper)
    assert cli.main(["ensemble", str(path), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert [row["upper"] for row in answer["rows"]] == expected.upper.values.tolist()
    assert [row["lower"] for row in answer["rows"]] == expected.lower.values.tolist()
    assert answer["outcomes"]["swinging"] == int((study.outcome == 4).sum()) > 0
    assert any("still swinging" in note for note in answer["notes"])


# --- motion at the end of runs ---


@pytest.mark.parametrize("dims", [("sample",), ("sample", "seed")])
def test_runs_still_moving_are_counted_either_way(dims: tuple[str, ...], rng: np.random.Generator) -> None:
    shape = (12, 3)[: len(dims)]
    outcome = rng.integers(0, 5, shape)  # 1 is buckled, 3 dying out, 4 swinging
    coords = {name: Variable((name,), np.arange(size), {}) for name, size in zip(dims, shape, strict=True)}
    coords["run_seed"] = Variable(dims, np.arange(outcome.size).reshape(shape), {})

    def with_buckled(buckled: NDArray[np.bool_]) -> Runs:
        values = {"status": np.ones(shape, int), "buckled": buckled, "outcome": outcome}
        return Runs({name: Variable(dims, each, {}) for name, each in values.items()}, coords, {})

    moving = outcome >= 3
    found = probability_of(with_buckled(outcome == 1), "buckled", dims, 0.95)
    most = probability_of(with_buckled((outcome == 1) | moving), "buckled", dims, 0.95)
    assert int(found["moving"]) == int(moving.sum())
    assert float(found["upper_moving"]) == pytest.approx(float(most["upper"]), abs=1e-12)
    assert float(found["upper"]) < float(found["upper_moving"])
