"""Guards rods under two sines: long integrations, loads with harmonics, arrays, the terminal, refusals."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import floquetrod as fr
from floquetrod.cli import main
from tests.conftest import DEEP, depth, some
from tests.seams import Tuned

ROD = fr.Rod.nitinol()
FCR = ROD.critical_force
OMEGA = 150.0
GOLDEN = (1.0 + math.sqrt(5.0)) / 2.0
PLAIN = fr.AxialLoad(0.2 * FCR, 0.2 * FCR, OMEGA)
TWO = fr.AxialLoad(0.2 * FCR, 0.2 * FCR, OMEGA, second=(0.1 * FCR, GOLDEN * OMEGA))


def drawn(rng: np.random.Generator) -> tuple[fr.Rod, fr.AxialLoad]:
    """Return a damped rod and a load of two sines."""
    rod = ROD.replace(damping_rate=float(rng.uniform(0.05, 1.0)))
    mean, one, two = (float(FCR * rng.uniform(*ends)) for ends in ((-0.2, 0.7), (0.0, 0.5), (0.02, 0.5)))
    omega = float(rng.uniform(80.0, 250.0))
    second = (two, omega * float(rng.uniform(0.4, 2.5)), float(rng.uniform(0.0, 6.0)))
    return rod, fr.AxialLoad(mean, one, omega, second=second)


def integrated(rod: fr.Rod, load: fr.AxialLoad, modes: int, periods: int) -> NDArray[np.float64]:
    """Return the growth in 1/s of modes by the classical method of Runge and Kutta, averaged with smooth weights.

    Of q'' + 2 c q' + (E I k^4 - F(t) k^2 + w / R) q = 0 per mass, k = pi m / L: the data sheet alone, no equation of
    the package.
    """
    assert load.second is not None
    k2 = (math.pi * np.arange(1, modes + 1) / rod.length) ** 2 / rod.mass_per_length
    free = rod.natural_frequency(np.arange(1, modes + 1)) ** 2
    amplitude, frequency, *ahead = load.second
    fastest = math.sqrt(float(np.abs(free).max() + k2[-1] * (abs(load.mean) + load.amplitude + amplitude)))
    steps = math.ceil(16.0 * max(fastest, frequency, load.frequency) / load.frequency)
    h = 2.0 * math.pi / load.frequency / steps
    half = 0.5 * h * np.arange(2 * steps * periods + 1)
    force = load.mean + load.amplitude * np.sin(load.frequency * half)
    force += amplitude * np.sin(frequency * half + (ahead[0] if ahead else 0.0))
    x, v = np.ones(modes), np.full(modes, 0.3 * load.frequency)
    logs = np.empty((periods, modes))
    drag = 2.0 * rod.damping_rate

    def slope(u: Any, w: Any, push: float) -> Any:
        return (push * k2 - free) * u - drag * w

    for period in range(periods):
        for i in range(2 * period * steps, 2 * (period + 1) * steps, 2):
            f0, f1, f2 = force[i : i + 3]
            a1 = slope(x, v, f0)
            a2 = slope(x + 0.5 * h * v, v + 0.5 * h * a1, f1)
            a3 = slope(x + 0.5 * h * (v + 0.5 * h * a1), v + 0.5 * h * a2, f1)
            a4 = slope(x + h * (v + 0.5 * h * a2), v + h * a3, f2)
            x = x + h * v + h * h / 6.0 * (a1 + a2 + a3)
            v = v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        size = np.hypot(x, v / load.frequency)
        logs[period], x, v = np.log(size), x / size, v / size
    u = (np.arange(periods) + 0.5) / periods
    weights = np.exp(-1.0 / (u * (1.0 - u)))
    return np.asarray(weights @ logs / weights.sum() * load.frequency / (2.0 * math.pi))


def agree(seed: int, modes: int, periods: int) -> None:
    """Compare the growth of each mode with an integration, which knows it to half a unit over its length."""
    rod, load = drawn(np.random.default_rng(seed))
    verdict = rod.stability(load, modes=range(1, modes + 1))
    expected = integrated(rod, load, modes, periods)
    known = 0.5 * load.frequency / periods + 1e-3 * np.abs(expected + rod.damping_rate)
    evidence: Any = verdict.evidence
    assert (np.abs(verdict.mode_growth_rates - expected) < evidence.mode_growth_errors + known).all()
    if expected.max() > 2.0 * known.max():
        assert verdict.status == "unstable"
        assert int(expected.argmax()) + 1 in verdict.unstable_modes
    if expected.max() < -2.0 * known.max():
        assert verdict.status != "unstable"


@pytest.mark.parametrize("seed", range(depth(2, 1)))
def test_modes_grow_as_in_a_long_integration(seed: int) -> None:
    agree(seed, 7, 120)


@pytest.mark.slow
@pytest.mark.parametrize("seed", some(range(2, 102), 30, 10))
def test_modes_grow_as_in_long_integrations(seed: int) -> None:
    agree(seed, 10, 800)


@pytest.mark.slow
def test_commensurate_sines_are_one_load_with_harmonics() -> None:
    rng = np.random.default_rng(3)
    for _ in range(depth(60, 6)):
        rod, load = drawn(rng)
        p, q = (int(number) for number in rng.integers(1, 6, 2))
        two, _, phase = load.second or (0.0, 0.0, 0.0)
        load = replace(load, frequency=load.frequency * min(1.0, q / p))  # the force is uniform along the rod
        waveform = np.zeros(max(p, q), dtype=complex)
        waveform[q - 1] -= 1j
        waveform[p - 1] -= 1j * two / max(load.amplitude, 1e-9) * np.exp(1j * phase)
        one = fr.AxialLoad(load.mean, max(load.amplitude, 1e-9), load.frequency / q, waveform=tuple(waveform))
        both = fr.AxialLoad(load.mean, one.amplitude, load.frequency, second=(two, load.frequency * p / q, phase))
        expected, found = rod.stability(one), rod.stability(both)
        assert found.growth_rate == pytest.approx(expected.growth_rate, abs=1e-6, rel=1e-6)
        if abs(expected.growth_rate) > 1e-4 or found.status != "undecided":
            assert found.status == expected.status


def test_arrays_and_single_loads_have_one_answer() -> None:
    rng = np.random.default_rng(4)
    rod, load = drawn(rng)
    means = np.linspace(-0.1, 0.8, 7) * FCR
    for tolerance in (0.0, 0.05):
        single = [rod.stability(load.varied("mean", mean), growth_tolerance=tolerance) for mean in means]
        codes = [{"stable": 1, "unstable": 0, "undecided": -1}[verdict.status] for verdict in single]
        assert rod.verdicts(load, mean=means, growth_tolerance=tolerance).tolist() == codes
    growth, mode = rod.growth_rate(load, mean=means, return_mode=True)
    for verdict, rate, number in zip(single, growth, mode, strict=True):
        assert rate == pytest.approx(verdict.growth_rate, abs=verdict.error)
        if verdict.growth_rate > 0.1:
            assert number == verdict.fastest_mode


def test_a_second_sine_of_no_amplitude_changes_nothing() -> None:
    for rod in (ROD, ROD.replace(damping_rate=0.5)):
        none = fr.AxialLoad(PLAIN.mean, PLAIN.amplitude, OMEGA, second=(0.0, GOLDEN * OMEGA))
        plain, found = (rod.stability(load, growth_tolerance=0.01) for load in (PLAIN, none))
        assert found.status == plain.status == "unstable"
        assert found.growth_rate == pytest.approx(plain.growth_rate, abs=1e-6)
        assert found.unstable_modes == plain.unstable_modes


def test_a_verdict_says_its_tolerance() -> None:
    weak = fr.AxialLoad(0.1 * FCR, 0.02 * FCR, OMEGA, second=(0.01 * FCR, GOLDEN * OMEGA))
    tolerated = ROD.stability(weak, growth_tolerance=0.05)
    assert repr(tolerated).startswith("<stable: no mode grows faster than the tolerance of 0.05 1/s; modes 1 to ")
    assert "STABLE: no mode grows faster than the tolerance of 0.05 1/s" in str(tolerated.report())
    assert "two frequencies: growth from periodic approximants" in str(tolerated.report().assumptions)
    damped = ROD.replace(damping_rate=2.0).stability(weak)
    assert repr(damped).startswith("<stable: no mode grows: damping exceeds what approximants leave open")
    undecided = ROD.stability(weak)
    assert undecided.status == "undecided"
    assert "without damping tongues of two frequencies are everywhere" in undecided.note
    assert ROD.stability(TWO).unstable_modes == (7,)
    assert json.loads(json.dumps(tolerated.as_dict()))["load"]["second"] == [0.01 * FCR, GOLDEN * OMEGA]


@pytest.mark.slow
def test_searches_agree_with_verdicts(tuned: Tuned) -> None:
    if not DEEP:
        tuned(samples_of_ranges=65)
    rod = ROD.replace(damping_rate=2.0)
    found = rod.ranges("mean", TWO, (0.0, 0.12 * FCR), growth_tolerance=0.0)
    assert len(found) > 0
    for interval in found:
        for value in np.linspace(interval.low, interval.high, 4)[1:-1]:
            assert rod.is_stable(TWO, mean=float(value))
    critical = float(rod.critical("amplitude", TWO, growth_tolerance=0.0))
    assert rod.verdicts(TWO, amplitude=[0.999 * critical, 1.02 * critical]).tolist() == [1, 0]
    edge = rod.stability(TWO).margin("amplitude").below
    assert TWO.amplitude - edge == pytest.approx(critical, rel=1e-3)
    chart = fr.stability_map(rod, TWO, mean=(0.1 * FCR, 0.3 * FCR, 3), frequency=(120.0, 160.0, 2))
    for row, column in np.ndindex(*chart.stable.shape):
        frequency, mean = float(chart.x.values[column]), float(chart.y.values[row])
        assert chart.stable[row, column] == (rod.verdicts(TWO, mean=mean, frequency=frequency) == 1)


@pytest.mark.slow
def test_damping_that_stabilises_does() -> None:
    rate = ROD.stability(TWO).damping_to_stabilise
    assert ROD.replace(damping_rate=1.001 * rate).stability(TWO).status == "stable"
    assert ROD.replace(damping_rate=0.95 * rate).stability(TWO).status == "unstable"


def test_the_force_along_the_rod_counts_both_sines() -> None:
    assert ROD.axial_response(TWO).largest == pytest.approx(0.3 * FCR)
    assert ROD.stress(TWO).axial > ROD.stress(PLAIN).axial


def test_the_terminal_says_what_python_says(capsys: pytest.CaptureFixture[str]) -> None:
    point = ["--rod", "nitinol", "--mean", "0.2Fcr", "--amplitude", "0.2Fcr", "--frequency", "150"]
    sine = ["--second", f"{0.1 * FCR!r}N@{GOLDEN * OMEGA!r}rad/s", "--damping-rate", "1"]
    assert main(["check", *point, *sine, "--no-margins", "--json"]) in (0, 1)
    found = json.loads(capsys.readouterr().out)
    verdict = ROD.replace(damping_rate=1.0).stability(TWO)
    assert found["status"] == verdict.status
    assert found["growth_rate_per_s"] == pytest.approx(verdict.growth_rate, abs=1e-9)
    assert main(["check", *point, "--second", "3N"]) == 2
    assert "--second must be such as 0.1N@37Hz" in capsys.readouterr().err
    assert main(["check", *point, "--second", "1N@20Hz", "--wave", "held"]) == 2
    assert "with waves; leave --second out" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda: ROD.certify(TWO), "certify is not answered under a second sine of"),
        (lambda: ROD.stability(TWO, friction=0.1, kick=0.1), "friction is not answered under a second sine"),
        (lambda: ROD.critical_kick(TWO, friction=0.1), "friction is not answered"),
        (lambda: ROD.is_stable(TWO, criterion=fr.FiniteTimeCriterion()), "criterion is not answered"),
        (lambda: ROD.modal_system(TWO), "modal_system is not answered"),
        (lambda: ROD.largest_safe_box(TWO), "largest_safe_box is not answered"),
        (lambda: fr.simulate(ROD, TWO, duration=0.1), "second is not part of simulations, which would ignore it"),
        (lambda: ROD.steady_motion(TWO), "second is not part of large motion"),
        (lambda: ROD.follow(TWO, over={"mean": (0.0, 1.0)}), "second is not part of large motion"),
        (lambda: ROD.safe_kick(TWO), "second is not part of large motion"),
        (lambda: ROD.replace(natural_shape={5: "0.1mm"}).response(TWO), "second is not part of"),
        (lambda: ROD.replace(ends="clamped").certify(TWO), "certify is not answered under a second sine of"),
        (lambda: fr.AxialLoad(1.0, 1.0, 1.0, noise=0.1, second=(1.0, 2.0)), "second goes without noise"),
        (lambda: fr.AxialWave(1.0, 1.0, 1.0, second=(1.0, 2.0)), "with waves; leave second out"),
        (
            lambda: fr.AxialLoad(1.0, 1.0, 1.0, second=3.0),  # type: ignore[arg-type]
            r"second must be \(amplitude, frequency\)",
        ),
        (lambda: fr.AxialLoad(1.0, 1.0, 1.0, second=("1N", "0Hz")), r"second\[1\] must be"),
        (lambda: fr.AxialLoad(1.0, 1.0, 1.0, second=(-1.0, 2.0)), r"second\[0\] must be zero or more"),
        (lambda: fr.AxialLoad(1.0, 1.0, 1.0, second=(1.0, 2.0, math.nan)), r"second\[2\]"),
    ],
)
def test_what_would_ignore_the_second_sine_refuses_it(ask: Any, words: str) -> None:
    with pytest.raises((TypeError, ValueError), match=words) as error:
        ask()
    assert "\n" not in str(error.value)


@pytest.mark.slow
def test_a_range_in_which_no_mode_is_seen_to_grow_is_called_undecided() -> None:
    """Beats near a ratio of 5/2 are slower than the approximants resolve beside little damping."""
    rod, load = ROD.replace(damping_rate=0.2), fr.AxialLoad(0.3 * FCR, 0.1 * FCR, OMEGA, second=(0.2 * FCR, 375.345))
    assert rod.stability(load).status == "undecided"
    found = rod.ranges("mean", load, bounds=(0.3 * FCR, 0.301 * FCR))
    (band,) = found.unstable
    assert band.worst_growth == 0.0
    (row,) = [line for line in found.table().splitlines() if "undecided" in line]
    assert row.endswith("no mode is seen to grow")
    assert " unstable  " not in found.table()
    (listed,) = found.as_dict()["unstable"]
    assert (band.status, listed["status"], listed["cause"]) == ("undecided", "undecided", None)
    ax = found.plot()
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["stable", "undecided"]
