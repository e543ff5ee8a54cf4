"""Guards coupled modes under two sines: own models integrated for long, independent modes, waveforms, searches."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

import floquetrod as fr
from floquetrod.cli import main
from tests.conftest import some
from tests.rod.modes.test_two_frequencies import FCR, GOLDEN, OMEGA, ROD, TWO, drawn

FEW = range(1, 9)
CLAMPED = ROD.replace(ends="clamped", damping_rate=0.5)


def clamped(count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return b^4 and int phi_i' phi_j' of the first modes of a clamped beam of length 1 (Bolotin's equations)."""
    b = np.array([brentq(lambda x: math.cos(x) - 1.0 / math.cosh(x), math.pi * (i + 0.3), math.pi * (i + 0.7))
                  for i in range(1, count + 1)])  # fmt: skip
    s = (np.cosh(b) - np.cos(b)) / (np.sinh(b) - np.sin(b))
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = -8.0 * np.outer(b, b) ** 2 * (s * b - (s * b)[:, None]) / (b**4 - (b**4)[:, None])
    i = np.arange(count)
    slopes = np.where((i + i[:, None]) % 2 == 0, slopes, 0.0)
    slopes[i, i] = s * b * (s * b - 2.0)
    return b**4, slopes


def integrated(rod: fr.Rod, load: fr.AxialLoad, count: int, periods: int) -> float:
    """Return the growth in 1/s of the first modes together, by the classical method of Runge and Kutta.

    Of a rod with clamped ends, or with hinged ones and weight along, from its data sheet: no equation of the package.
    """
    assert load.second is not None
    m, length = rod.mass_per_length, rod.length
    if rod.ends == "clamped":
        fourth, slopes = clamped(count)
        weight = np.zeros((count, count))
    else:
        k = math.pi * np.arange(1, count + 1)
        fourth, slopes = k**4, np.diag(k**2)
        nodes, weights = np.polynomial.legendre.leggauss(6 * count)
        x, weights = 0.5 * (nodes + 1.0), 0.5 * weights
        along = np.sqrt(2.0) * k[:, None] * np.cos(np.outer(k, x))
        added = rod.weight_per_length * length * math.cos(rod.inclination) * (x - 0.5)
        weight = (along * added * weights) @ along.T
    restoring = rod.weight_per_length * math.sin(rod.inclination) / (m * rod.radial_clearance)
    free = np.diag(rod.flexural_rigidity * fourth / (m * length**4) + restoring) - weight / (m * length**2)
    push = slopes / (m * length**2)
    amplitude, frequency, *ahead = load.second
    largest = load.mean + load.amplitude + amplitude
    fastest = math.sqrt(float(np.linalg.eigvalsh(free).max()) + largest * float(np.linalg.eigvalsh(push).max()))
    steps = math.ceil(12.0 * max(fastest, frequency, load.frequency) / load.frequency)
    h = 2.0 * math.pi / load.frequency / steps
    half = 0.5 * h * np.arange(2 * steps * periods + 1)
    force = load.mean + load.amplitude * np.sin(load.frequency * half)
    force += amplitude * np.sin(frequency * half + (ahead[0] if ahead else 0.0))
    u, v = np.cos(np.arange(1.0, count + 1)), np.zeros(count)
    logs, drag = np.empty(periods), 2.0 * rod.damping_rate

    def slope(u: Any, v: Any, f: float) -> Any:
        return f * (push @ u) - free @ u - drag * v

    for period in range(periods):
        for i in range(2 * period * steps, 2 * (period + 1) * steps, 2):
            f0, f1, f2 = force[i : i + 3]
            a1 = slope(u, v, f0)
            a2 = slope(u + 0.5 * h * v, v + 0.5 * h * a1, f1)
            a3 = slope(u + 0.5 * h * (v + 0.5 * h * a1), v + 0.5 * h * a2, f1)
            a4 = slope(u + h * (v + 0.5 * h * a2), v + h * a3, f2)
            u = u + h * v + h * h / 6.0 * (a1 + a2 + a3)
            v = v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        size = math.sqrt(float((free @ u) @ u + v @ v))
        logs[period], u, v = math.log(size), u / size, v / size
    at = (np.arange(periods) + 0.5) / periods
    weights = np.exp(-1.0 / (at * (1.0 - at)))
    return float(weights @ logs / weights.sum() * load.frequency / (2.0 * math.pi))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [*some(range(0, 20, 2), 3, 1), *some(range(1, 20, 2), 3, 1)])
def test_coupled_modes_grow_as_in_long_integrations(seed: int) -> None:
    rod, load = drawn(np.random.default_rng(1000 + seed))
    rod = rod.replace(ends="clamped") if seed % 2 else rod.replace(inclination=f"{40 + 2 * seed}deg")
    verdict = rod.stability(load)
    periods = 600
    expected = integrated(rod, load, verdict.convergence[-1][0], periods)
    known = 0.5 * load.frequency / periods + 2e-3 * abs(expected + rod.damping_rate)
    assert abs(verdict.convergence[-1][1] - expected) < verdict.error + known
    if abs(expected) > 2.0 * known:
        assert verdict.status != ("stable" if expected > 0.0 else "unstable")


@pytest.mark.parametrize("rod", [ROD.replace(inclination="50deg"), pytest.param(CLAMPED, marks=pytest.mark.slow)])
def test_commensurate_sines_on_coupled_modes_are_one_load_with_harmonics(rod: fr.Rod) -> None:
    waveform = (0.0, -1.0j, -0.5j * np.exp(0.4j))
    one = fr.AxialLoad(0.2 * FCR, 0.3 * FCR, 50.0, waveform=waveform)
    both = fr.AxialLoad(0.2 * FCR, 0.3 * FCR, 100.0, second=(0.15 * FCR, 150.0, 0.4))
    expected, found = rod.stability(one, modes=FEW), rod.stability(both, modes=FEW)
    assert found.growth_rate == pytest.approx(expected.growth_rate, abs=1e-6, rel=1e-6)
    assert found.growth_rate > 0.1
    assert found.status == expected.status == "unstable"


def test_a_second_sine_of_no_amplitude_leaves_coupled_modes_as_they_are() -> None:
    plain = fr.AxialLoad(0.2 * FCR, 0.2 * FCR, OMEGA)
    none = fr.AxialLoad(0.2 * FCR, 0.2 * FCR, OMEGA, second=(0.0, GOLDEN * OMEGA))
    expected, found = (CLAMPED.stability(load, modes=FEW) for load in (plain, none))
    assert found.status == expected.status
    assert found.growth_rate == pytest.approx(expected.growth_rate, abs=found.error + expected.error)
    swapped = fr.AxialLoad(0.2 * FCR, 0.1 * FCR, GOLDEN * OMEGA, second=(0.2 * FCR, OMEGA))
    one, other = (CLAMPED.stability(load, modes=FEW) for load in (TWO, swapped))
    assert one.growth_rate == pytest.approx(other.growth_rate, abs=one.error + other.error)


def test_a_uniform_rod_in_sections_has_the_growth_of_independent_modes() -> None:
    rod = ROD.replace(damping_rate=0.5)
    sections = [
        fr.Section(length=share * rod.length, radius=rod.radius, youngs_modulus=young, density=rod.density)
        for share, young in ((0.4, rod.youngs_modulus), (0.6, (1.0 + 1e-10) * rod.youngs_modulus))
    ]
    string = fr.Rod(sections=sections, channel_radius=rod.channel_radius, damping_rate=rod.damping_rate)
    expected, found = rod.stability(TWO), string.stability(TWO, modes=range(1, 11))
    assert found.convergence[-1][0] == 10
    growth = expected.mode_verdicts[expected.fastest_mode - 1]
    assert found.growth_rate == pytest.approx(expected.growth_rate, abs=found.error + TWO.frequency * growth.error)
    assert found.error < 1e-4


def test_a_verdict_on_coupled_modes_says_its_tolerance(capsys: pytest.CaptureFixture[str]) -> None:
    weak = fr.AxialLoad(0.1 * FCR, 0.002 * FCR, OMEGA, second=(0.001 * FCR, GOLDEN * OMEGA))
    calm = CLAMPED.replace(damping_rate=0.0)
    found = calm.stability(weak, modes=FEW, growth_tolerance=0.1)
    assert repr(found) == (
        "<stable: nothing grows faster than the tolerance of 0.1 1/s; 8 coupled modes, as requested>"
    )
    assert "STABLE: nothing grows faster than the tolerance of 0.1 1/s" in str(found.report())
    undecided = calm.stability(weak, modes=FEW)
    assert undecided.status == "undecided"
    assert "tongues of two frequencies are everywhere" in undecided.note
    assert json.loads(json.dumps(found.as_dict()))["convergence"][0]["modes"] == 8
    point = ["--rod", "nitinol", "--mean", f"{0.2 * FCR!r}N", "--amplitude", f"{0.3 * FCR!r}N"]
    sine = ["--second", f"{0.15 * FCR!r}N@161.8rad/s", "--damping-rate", "0.5", "--inclination", "50deg", "--modes=1-8"]
    sine += ["--frequency", "100rad/s"]
    assert main(["check", *point, *sine, "--no-margins", "--json"]) == 0
    written = json.loads(capsys.readouterr().out)
    load = fr.AxialLoad(0.2 * FCR, 0.3 * FCR, 100.0, second=(0.15 * FCR, 161.8))
    verdict = ROD.replace(inclination="50deg", damping_rate=0.5).stability(load, modes=FEW)
    assert written["growth_rate_per_s"] == pytest.approx(verdict.growth_rate, abs=1e-9)


@pytest.mark.slow
def test_searches_over_coupled_modes_agree_with_verdicts() -> None:
    rod = ROD.replace(inclination="50deg", length=0.5 * ROD.length, damping_rate=2.0)
    load = TWO.varied("amplitude", 0.3 * FCR)
    means = np.linspace(0.0, 0.4, 5) * FCR
    single = [rod.stability(load.varied("mean", mean)) for mean in means]
    codes = [{"stable": 1, "unstable": 0, "undecided": -1}[verdict.status] for verdict in single]
    assert rod.verdicts(load, mean=means).tolist() == codes
    for verdict, rate in zip(single, rod.growth_rate(load, mean=means), strict=True):
        assert rate == pytest.approx(verdict.growth_rate, abs=verdict.error + 0.02)
    for interval in rod.ranges("mean", load, (0.0, 0.2 * FCR), growth_tolerance=0.0):
        for value in np.linspace(interval.low, interval.high, 4)[1:-1]:
            assert rod.is_stable(load, mean=float(value))
    critical = float(rod.critical("amplitude", load, growth_tolerance=0.0))
    assert rod.verdicts(load, amplitude=[0.999 * critical, 1.02 * critical]).tolist() == [1, 0]
    above = rod.stability(load).margin("amplitude", seconds=60.0).above
    assert load.amplitude + above == pytest.approx(critical, rel=1e-3)
    chart = fr.stability_map(rod, load, mean=(0.1 * FCR, 0.3 * FCR, 3), frequency=(120.0, 160.0, 2))
    for row, column in np.ndindex(*chart.stable.shape):
        frequency, mean = float(chart.x.values[column]), float(chart.y.values[row])
        assert chart.stable[row, column] == (rod.verdicts(load, mean=mean, frequency=frequency) == 1)
    load = load.varied("mean", 0.3 * FCR)
    rate = rod.replace(damping_rate=0.0).stability(load).damping_to_stabilise
    assert rod.replace(damping_rate=1.01 * rate).stability(load).status == "stable"
    assert rod.replace(damping_rate=0.9 * rate).stability(load).status != "stable"


def test_kinds_that_two_frequencies_do_not_answer_say_so_of_coupled_modes() -> None:
    with pytest.raises(ValueError, match="modal_system is not answered under a second sine"):
        CLAMPED.modal_system(TWO)
    with pytest.raises(ValueError, match="leave the string on one side of its wall"):
        ROD.replace(curvature=-0.5).stability(TWO)


def test_what_approximants_leave_open_is_no_difference_between_numbers_of_modes() -> None:
    """Next to a ratio of 2, where bounds decide: one status of a load and an array, one rate with fewer modes."""
    rod = ROD.replace(radius=3.75e-4, damping_rate=1.0, curvature=0.02)
    load = fr.AxialLoad(0.1307, 0.0163, 300.0, second=(0.0017, 600.03))
    verdict = rod.stability(load)
    assert (verdict.status, int(rod.verdicts(load))) == ("stable", 1)
    (_, fewer), (_, rate) = verdict.convergence
    assert fewer == pytest.approx(rate, abs=1e-9) == -1.0
