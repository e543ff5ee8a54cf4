"""How probable instability is, and what matters: against rods judged one by one, closed forms and quadrature."""

from __future__ import annotations

import math
import pickle
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import special, stats

import floquetrod as fr
from floquetrod.rod.distributions import Sampling, quantiles
from floquetrod.rod.uncertainty import SobolIndex, sobol_indices
from tests.conftest import depth
from tests.inside import ModeConstants

ROD = fr.Rod.nitinol()
UNIT = ROD.critical_force
LOAD = fr.AxialLoad(0.34 * UNIT, 0.2 * UNIT, 150.0)
STATIC = fr.AxialLoad(0.9 * UNIT, 0.0, 150.0)
TUBE = ROD.replace(inner_radius=0.3e-3, fluid_inside=1000.0, fluid_outside=1000.0, damping_rate=0.01)
ALL: dict[str, Any] = {
    "youngs_modulus": stats.norm(68e9, 2e9),
    "density": (6400.0, 6600.0),
    "radius": stats.truncnorm(-2.0, 2.0, 0.8e-3, 0.01e-3),
    "length": stats.norm(3.1, 0.02),
    "channel_radius": (4.5e-3, 4.9e-3),
    "gravity": (9.80, 9.83),
    "damping_rate": (0.0, 0.05),
    "inner_radius": (0.0, 0.4e-3),
    "fluid_inside": (0.0, 1500.0),
    "fluid_outside": (0.0, 1200.0),
    "added_mass_coefficient": (2.0, 4.0),
    "mean": stats.norm(0.34 * UNIT, 0.1 * UNIT),
    "amplitude": (0.0, 0.4 * UNIT),
    "frequency": stats.uniform(100.0, 100.0),
}


def rods_and_loads(rod: fr.Rod, given: dict[str, Any], levels: NDArray[np.float64]) -> Any:
    """Yield each sample as a rod and a load."""
    for column in np.array([quantiles(n, g, u) for (n, g), u in zip(given.items(), levels, strict=True)]).T.tolist():
        sample = dict(zip(given, column, strict=True))
        load = {name: sample.pop(name, getattr(LOAD, name)) for name in ("mean", "amplitude", "frequency")}
        yield rod.replace(**sample), fr.AxialLoad(**load)


def buckling_force(modulus: float, length: float = ROD.length) -> float:
    """Return the smallest constant force that buckles a mode of the reference rod of another modulus."""
    c1, c2, squared, *_ = ModeConstants.of(ROD.parameters | {"youngs_modulus": modulus, "length": length})
    modes = np.arange(1.0, 40.0)
    return float(np.min((c1 * modes**4 + squared) / (c2 * modes**2)))


@pytest.mark.slow
@pytest.mark.kernels
@pytest.mark.parametrize("tolerance", [0.0, pytest.param(1e-6, marks=pytest.mark.slow), 0.05])
def test_samples_agree_with_rods_made_one_by_one(tolerance: float) -> None:
    levels = np.random.default_rng(5).uniform(0.001, 0.999, (len(ALL), depth(700, 250)))
    found = Sampling(TUBE, LOAD, ALL, tolerance, None).verdicts(levels)
    expected = [
        rod.is_stable(mean=load.mean, amplitude=load.amplitude, frequency=load.frequency, growth_tolerance=tolerance)
        for rod, load in rods_and_loads(TUBE, ALL, levels)
    ]
    assert np.array_equal(found == 1, expected)
    assert 0.1 < np.mean(found == 1) < 0.9


def test_one_uncertain_load_is_the_share_of_its_unstable_forces() -> None:
    low, high = 0.2 * UNIT, 0.5 * UNIT
    ranges = ROD.ranges("mean", amplitude=LOAD.amplitude, frequency=LOAD.frequency, bounds=(low, high))
    share = 1.0 - sum(part.high - part.low for part in ranges) / (high - low)
    found = fr.probability_of_instability(ROD, LOAD, {"mean": (low, high)}, samples=50_000, seed=3, confidence=0.999)
    assert found.interval[0] < share < found.interval[1]
    assert found.interval[1] - found.interval[0] < 0.02
    assert found.importance == {"mean": SobolIndex(1.0, 1.0, (1.0, 1.0), (1.0, 1.0))}


@pytest.mark.slow
def test_intervals_cover_the_probability_as_often_as_they_say() -> None:
    """Without vibration the rod buckles beyond a known force."""
    critical = buckling_force(ROD.youngs_modulus)
    for beyond in (0.02, 0.3):
        mean = stats.uniform(critical - (1.0 - beyond) * 0.1, 0.1)
        covered = 0
        for seed in range(200):
            found = fr.probability_of_instability(ROD, STATIC, {"mean": mean}, samples=300, seed=seed, confidence=0.9)
            covered += found.interval[0] <= beyond <= found.interval[1]
        assert 180 <= covered <= 200


def test_probability_and_importance_of_static_buckling() -> None:
    """Two distributions, against quadrature: E[f | mean] and E[f | modulus] are known."""
    mean, modulus = stats.norm(1.0 * UNIT, 0.03 * UNIT), stats.norm(68e9, 4e9)
    found = fr.probability_of_instability(
        ROD, STATIC, {"mean": mean, "youngs_modulus": modulus}, samples=400_000, seed=7, confidence=0.999
    )
    levels = (np.arange(4000) + 0.5) / 4000
    critical = np.sort([buckling_force(float(e)) for e in modulus.ppf(levels)])
    given_modulus = mean.sf(critical)
    given_mean = np.searchsorted(critical, mean.ppf(levels)) / levels.size
    p = given_modulus.mean()
    assert given_mean.mean() == pytest.approx(p, abs=1e-4)
    assert found.interval[0] < p < found.interval[1]
    first = {"mean": given_mean.var() / (p - p * p), "youngs_modulus": given_modulus.var() / (p - p * p)}
    assert found.importance is not None
    for name, other in (("mean", "youngs_modulus"), ("youngs_modulus", "mean")):
        index = found.importance[name]
        assert index.first_interval[0] - 1e-3 < first[name] < index.first_interval[1] + 1e-3
        assert index.total_interval[0] - 1e-3 < 1.0 - first[other] < index.total_interval[1] + 1e-3
        assert index.first_interval[0] < index.first < index.first_interval[1]
    assert found.most_important == max(first, key=lambda name: first[name])
    assert found.note == ""


def indices_of(unstable: Any, seed: int, count: int = 3) -> dict[str, SobolIndex]:
    """Return the Sobol indices of a function of levels."""
    stub: Any = SimpleNamespace(
        parameters=dict.fromkeys("abc"[:count]),
        at_once=1 << 12,
        rows={name: slice(i, i + 1) for i, name in enumerate("abc"[:count])},
        verdicts=lambda levels: np.where(unstable(*levels), 0, 1).astype(np.int8),
    )
    return sobol_indices(stub, 1 << 13, np.random.SeedSequence(seed), 0.95)


def test_indices_of_functions_with_known_ones() -> None:
    one = indices_of(lambda a, b, c: a < 0.3, 1)
    assert (one["a"].total, one["b"].total, one["c"].total) == pytest.approx((1.0, 0.0, 0.0), abs=0.01)
    assert one["a"].first == pytest.approx(1.0, abs=0.01)
    either = indices_of(lambda a, b, c: (a < 0.5) != (b < 0.5), 2)  # neither alone tells anything
    assert (either["a"].first, either["b"].first) == pytest.approx((0.0, 0.0), abs=0.05)
    assert (either["a"].total, either["b"].total) == pytest.approx((1.0, 1.0), abs=0.05)


@pytest.mark.slow
def test_intervals_of_indices_cover_them() -> None:
    p, q = 0.2, 0.6
    variance = p * q * (1.0 - p * q)
    exact = {"a": (q * q * p * (1 - p) / variance, q * p * (1 - p) / variance)}
    exact["b"] = (p * p * q * (1 - q) / variance, p * q * (1 - q) / variance)
    covered = 0
    for seed in range(50):
        found = indices_of(lambda a, b: (a < p) & (b < q), seed, 2)
        for name, (first, total) in exact.items():
            index = found[name]
            covered += index.first_interval[0] <= first <= index.first_interval[1]
            covered += index.total_interval[0] <= total <= index.total_interval[1]
    assert covered >= 180  # of 200, 190 expected


def test_what_is_certain_has_no_importance() -> None:
    never = fr.probability_of_instability(ROD, STATIC, {"mean": (0.0, 0.5), "length": (3.0, 3.1)}, samples=1000, seed=1)
    assert never.probability == 0.0 == never.interval[0]
    assert never.interval[1] == pytest.approx(1.0 - 0.025 ** (1 / 1000))
    assert never.importance is never.most_important is None
    assert "no sample was unstable" in never.note
    always = fr.probability_of_instability(ROD, STATIC, {"mean": (2.0, 2.5), "length": (3.0, 3.1)}, samples=100, seed=1)
    assert always.probability == 1.0 == always.interval[1]
    assert always.importance is None
    assert "no sample was stable" in always.note
    rare = {"mean": stats.uniform(buckling_force(ROD.youngs_modulus) - 0.1, 0.101), "length": (3.0999, 3.1)}
    seldom = fr.probability_of_instability(ROD, STATIC, rare, samples=2000, seed=1)
    assert 0 < seldom.unstable < 60
    assert seldom.importance is None
    assert f"{seldom.unstable} unstable samples are too few" in seldom.note


@pytest.mark.slow
def test_the_same_seed_gives_the_same_samples() -> None:
    given = {"mean": stats.norm(0.34 * UNIT, 0.03 * UNIT), "length": (3.05, 3.15)}
    calls: list[tuple[int, int]] = []
    one = fr.probability_of_instability(
        ROD, LOAD, given, samples=140_000, workers=1, progress=lambda *n: calls.append(n)
    )
    again = fr.probability_of_instability(ROD, LOAD, given, samples=140_000, workers=2, seed=one.seed)
    assert one == again
    assert one.importance == again.importance
    assert calls == [(131_072, 140_000), (140_000, 140_000)]
    other = fr.probability_of_instability(ROD, LOAD, given, samples=140_000)
    assert other.seed != one.seed
    copy = pickle.loads(pickle.dumps(one))
    assert copy == one
    assert copy.importance == one.importance
    assert repr(one).startswith("<unstable with probability 0.")
    assert "95 % confidence; 140,000 samples" in repr(one)
    with pytest.raises(TypeError, match="truth value"):
        bool(one)


def test_every_kind_of_distribution_is_taken() -> None:
    """A pair, a frozen distribution, a discrete one, one from data, anything with a quantile function."""
    low, high = 0.3 * UNIT, 0.4 * UNIT
    counts = np.histogram(np.linspace(low, high, 1001), 20)
    kinds: list[Any] = [
        (low, high),
        [low, high],
        stats.uniform(low, high - low),
        stats.rv_histogram(counts)(),
        SimpleNamespace(icdf=lambda p: low + (high - low) * p),
    ]
    if hasattr(stats, "Uniform"):
        kinds.append(stats.Uniform(a=low, b=high))
    found = {fr.probability_of_instability(ROD, LOAD, {"mean": kind}, samples=4000, seed=1).unstable for kind in kinds}
    assert max(found) - min(found) <= 4
    steps = fr.probability_of_instability(ROD, LOAD, {"damping_rate": stats.bernoulli(0.25)}, samples=500, seed=1)
    assert steps.unstable in (0, 500)


@pytest.mark.parametrize(
    ("given", "kind", "words"),
    [
        ({}, ValueError, "at least one"),
        ([("mean", (0, 1))], TypeError, "parameters must map"),
        ({"ends": (0, 1)}, ValueError, "parameters must be among mean, .* got 'ends'"),
        ({"diameter": (1e-3, 2e-3)}, ValueError, "radius"),
        ({1: (0, 1)}, ValueError, "got 1"),
        ({"mean": 0.3}, TypeError, r"parameters\['mean'\] must be a pair"),
        ({"mean": (1.0, 0.5)}, ValueError, r"parameters\['mean'\] must increase"),
        ({"mean": (0.0, float("nan"))}, ValueError, r"parameters\['mean'\]\[1\]"),
        ({"mean": stats.norm}, TypeError, "frozen"),
        ({"mean": stats.norm([1.0, 2.0])}, TypeError, "of one number"),
        ({"mean": SimpleNamespace(ppf=lambda p: p + 1j)}, TypeError, "of one number"),
        ({"mean": SimpleNamespace(ppf=3)}, TypeError, "pair"),
        ({"mean": SimpleNamespace(ppf=lambda p: p * np.nan)}, ValueError, "4 of 4|1,000 of 1,000"),
        ({"length": stats.norm(3.1, 2.0)}, ValueError, "of 1,000 samples do not.*length must be greater.*truncnorm"),
        ({"channel_radius": (0.5e-3, 5e-3)}, ValueError, "channel_radius must exceed the rod's radius"),
        ({"inner_radius": (0.0, 0.9e-3)}, ValueError, "inner_radius"),
        ({"fluid_outside": (0.0, 9000.0)}, ValueError, "this rod floats"),
        ({"amplitude": stats.norm(0.1, 0.1)}, ValueError, "amplitude must be zero or more"),
        ({"frequency": (-1.0, 100.0)}, ValueError, "frequency must be greater than zero"),
        ({"length": (1e-9, 2e-9)}, ValueError, "frequency must be at least"),
        ({"mean": (0.0, 1e11)}, ValueError, "needs more than 20000 modes"),
        ({"inclination_random": (0.0, 0.1)}, ValueError, "names inclination_random, .* the rod is on no path"),
        ({"mean": ("0.1N", "2m")}, ValueError, r"parameters\['mean'\]\[1\] must .*force"),
    ],
)
def test_what_cannot_be_sampled_is_refused(given: Any, kind: type[Exception], words: str) -> None:
    with pytest.raises(kind, match=words):
        fr.probability_of_instability(ROD, LOAD, given, samples=1000, seed=1)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"samples": 0}, "samples"),
        ({"confidence": 1.0}, "confidence must be less than 1"),
        ({"confidence": 0.0}, "confidence must be greater"),
        ({"seed": -1}, "seed"),
        ({"growth_tolerance": -1.0}, "growth_tolerance"),
    ],
)
def test_arguments_are_checked(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        fr.probability_of_instability(ROD, LOAD, {"mean": (0.1, 0.2)}, **changes)


@pytest.mark.slow
def test_samples_are_refused_where_rods_and_loads_are() -> None:
    """Each sample alone: the rule for arrays is that of the constructors."""
    given: dict[str, Any] = {
        "radius": (-0.2e-3, 3e-3),
        "channel_radius": (1e-3, 5e-3),
        "inner_radius": (-0.2e-3, 2e-3),
        "fluid_outside": (-500.0, 9000.0),
        "damping_rate": (-0.1, 1.0),
        "length": stats.loguniform(1e-6, 10.0),
        "amplitude": (-0.1, 1.0),
        "frequency": stats.loguniform(1e-3, 1e9),
    }
    sampling = Sampling(ROD, LOAD, given, 1e-6, 1)
    refused = 0
    many = depth(400, 150)
    levels = np.random.default_rng(8).uniform(0.01, 0.99, (len(given), many))
    for column in levels.T:
        try:
            ((rod, load),) = rods_and_loads(ROD, given, column[:, None])
            expected = rod.verdicts(
                mean=load.mean, amplitude=load.amplitude, frequency=load.frequency, growth_tolerance=1e-6
            )
        except ValueError:
            refused += 1
            with pytest.raises(ValueError, match=r"1 of 1 samples do not") as error:
                sampling.verdicts(column[:, None])
            assert "it is out of range" not in str(error.value)
        else:
            assert sampling.verdicts(column[:, None])[0] == expected
    assert 0.25 * many < refused < 0.975 * many


def test_coupled_modes_take_distributed_loads() -> None:
    clamped = ROD.replace(ends="clamped", damping_rate=0.05)
    found = fr.probability_of_instability(clamped, LOAD, {"mean": (0.1 * UNIT, 0.9 * UNIT)}, samples=60, seed=2)
    assert 0 < found.unstable < 60


@pytest.mark.slow
def test_coupled_modes_take_distributed_rods() -> None:
    """Rods with clamped ends, and inclined ones with weight along them, are judged one by one."""
    for rod, name, bounds in ((ROD.replace(ends="clamped"), "length", (3.0, 3.4)), (ROD, "inclination", (1.0, 1.5))):
        given: dict[str, Any] = {name: bounds, "mean": (0.2 * UNIT, 0.6 * UNIT)}
        levels = np.random.default_rng(2).uniform(size=(2, 12))
        found = Sampling(rod, LOAD, given, 1e-6, 1).verdicts(levels)
        expected = [
            each.is_stable(mean=load.mean, amplitude=load.amplitude, frequency=load.frequency, growth_tolerance=1e-6)
            for each, load in rods_and_loads(rod, given, levels)
        ]
        assert np.array_equal(found == 1, expected)
        assert 0 < np.count_nonzero(found == 1) < 12
    with pytest.raises(ValueError, match=r"must describe possible rods and loads, but there is length = -.*truncnorm"):
        fr.probability_of_instability(ROD.replace(ends="clamped"), LOAD, {"length": (-2.0, -1.0)}, samples=60)


# --- errors of a survey ---

TURNS = ROD.replace(  # on the way down its third station it passes the vertical in some samples
    path=fr.WellPath([0.0, 2.0, 3.5, 5.0], np.radians([74.0, 80.0, 86.0, 88.0]), np.radians([10.0, 12.0, 15.0, 13.0])),
    depth=0.7,
)
OFF: dict[str, Any] = {
    "inclination_random": stats.norm(0.0, math.radians(0.7)),
    "density": (6300.0, 6700.0),
    "inclination_systematic": (-0.03, 0.03),
    "azimuth_random": stats.norm(0.0, math.radians(0.5)),
    "azimuth_systematic": (-3.0, 3.0),
}


def wells_and_rods(levels: NDArray[np.float64]) -> Any:
    """Yield the rods of `OFF` made by hand: 4 levels, one, one, 4, and one."""
    phi, psi = TURNS.path.inclination, TURNS.path.azimuth
    for u in levels.T:
        off = math.radians(0.7) * special.ndtri(u[:4]) + 0.06 * u[5] - 0.03
        turned = math.radians(0.5) * special.ndtri(u[6:10]) - 3.0 + 6.0 * u[10]
        path = fr.WellPath(TURNS.path.depth, phi + off, psi + turned)
        yield TURNS.replace(path=path, density=6300.0 + 400.0 * u[4])


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::floquetrod.ForcedAngleWarning")
def test_errors_of_a_survey_give_the_verdicts_of_the_wells_they_make() -> None:
    levels = np.random.default_rng(3).uniform(0.01, 0.99, (11, depth(300, 16)))
    sampling = Sampling(TURNS, LOAD, OFF, 1e-6, 1)
    expected = [rod.stability(LOAD, growth_tolerance=1e-6).status for rod in wells_and_rods(levels)]
    found = sampling.verdicts(levels)
    assert [{1: "stable", 0: "unstable", -1: "undecided"}[each] for each in found.tolist()] == expected
    assert 0 < expected.count("unstable") < len(expected)


@pytest.mark.slow
def test_the_probability_with_a_bad_survey_is_that_of_a_monte_carlo_of_its_own() -> None:
    found = fr.probability_of_instability(TURNS, LOAD, OFF, samples=1500, seed=4, confidence=0.999)
    levels = np.random.default_rng(99).uniform(size=(11, 1500))
    own = sum(
        rod.verdicts(mean=LOAD.mean, amplitude=LOAD.amplitude, frequency=LOAD.frequency, growth_tolerance=1e-6) == 0
        for rod in wells_and_rods(levels)
    )
    low, high = stats.binomtest(int(own), 1500).proportion_ci(0.999, "exact")
    assert found.interval[0] < high
    assert low < found.interval[1]
    assert found.samples == 1500
    assert "inclination_random, azimuth_random: independent from station to station" in found.assumptions


@pytest.mark.slow
def test_where_north_is_matters_to_no_rod() -> None:
    given: dict[str, Any] = {"mean": (0.2 * UNIT, 0.5 * UNIT), "azimuth_systematic": (-3.0, 3.0)}
    sampling = Sampling(TURNS, LOAD, given, 1e-6, 1)
    levels = np.random.default_rng(1).uniform(size=(2, 12))
    found = sampling.verdicts(levels)
    assert np.array_equal(found, sampling.verdicts(np.array([levels[0], levels[1, ::-1]])))
    assert 0 < np.count_nonzero(found == 1) < 12


def test_errors_of_all_stations_are_one_quantity() -> None:
    """Of the sum of four normal errors and one of their size, against shares of the variance by quadrature."""
    stub: Any = SimpleNamespace(
        parameters=dict.fromkeys(("stations", "one")),
        at_once=1 << 12,
        rows={"stations": slice(0, 4), "one": slice(4, 5)},
        verdicts=lambda u: np.where(special.ndtri(u[:4]).sum(axis=0) + special.ndtri(u[4]) > 1.0, 0, 1).astype(np.int8),
    )
    found = sobol_indices(stub, 1 << 13, np.random.SeedSequence(5), 0.99)
    z = stats.norm().ppf((np.arange(20_000) + 0.5) / 20_000)
    for name, known, other in (("stations", 2.0, 1.0), ("one", 1.0, 2.0)):
        given = stats.norm.sf((1.0 - known * z) / other)
        p = stats.norm.sf(1.0 / math.sqrt(5.0))
        assert found[name].first_interval[0] < given.var() / (p - p * p) < found[name].first_interval[1]


def test_where_a_sample_leaves_the_wall_it_is_not_decided() -> None:
    drops = ROD.replace(path=fr.WellPath([0.0, 3.1], [1.5, 1.4]))
    load = fr.AxialLoad(0.4, 0.3, 150.0)
    found = fr.probability_of_instability(drops, load, {"inclination_random": (-0.4, 0.4)}, samples=24, seed=1)
    assert 0 < found.undecided < 24
    assert found.interval[1] - found.interval[0] > found.undecided / 24


def test_undecided_samples_widen_the_interval(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Sampling, "verdicts", lambda _, levels: np.array([-1, 0, 1, 1], dtype=np.int8))
    found = fr.probability_of_instability(ROD, LOAD, {"mean": (0.1, 0.2)}, samples=4)
    low, high = (stats.binomtest(k, 4).proportion_ci(0.95, "exact") for k in (1, 2))
    assert (found.unstable, found.undecided) == (1, 1)
    assert found.interval == pytest.approx((low.low, high.high), rel=1e-12)  # which SciPy finds as a root
    assert "1 of the samples could not be decided" in found.note
    assert repr(found).endswith("4 samples, 1 undecided>")
