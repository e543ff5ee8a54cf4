"""The stories of docs/how_to: each page runs, stays short, and what it finds agrees with an independent computation."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy import special
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from tests.project.test_docs import BLOCKS, STORIES, execute
from tests.project.test_snippets import in_this_process, require_as_shown

HOW_TO = Path(__file__).parents[2] / "docs/how_to"

Ran = Callable[[str], tuple[dict[str, Any], Path]]


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    """Return a function that executes a page once, in a folder of its own: the page's names, and the folder."""
    results: dict[str, tuple[dict[str, Any], Path]] = {}

    def run(story: str) -> tuple[dict[str, Any], Path]:
        if story not in results:
            folder = tmp_path_factory.mktemp(story)
            with pytest.MonkeyPatch.context() as patch:
                patch.chdir(folder)
                results[story] = execute((HOW_TO / f"{story}.md").read_text(encoding="utf-8")), folder
        return results[story]

    return run


def own_code(page: str) -> Iterator[tuple[str, list[str]]]:
    """Yield the heading over each code cell and its lines, imports aside; cells tagged "data" make input files."""
    heading = ""
    for block in BLOCKS.blocks(page):
        if isinstance(block, str):
            heading = [heading, *re.findall(r"^#+ (.*)$", block, re.MULTILINE)][-1]
        elif "data" not in block.tags:
            lines = [line for line in block.code.splitlines() if line.strip()]
            yield heading, [line for line in lines if not line.lstrip().startswith(("#", "import ", "from "))]


@pytest.mark.parametrize("story", STORIES)
def test_the_main_path_has_fewer_than_ten_lines_of_code(story: str) -> None:
    found = list(own_code((HOW_TO / f"{story}.md").read_text(encoding="utf-8")))
    main = sum(len(lines) for heading, lines in found if heading == found[0][0])  # up to the second heading
    assert 4 <= main < 10
    assert max(len(lines) for _, lines in found) < 10


@pytest.mark.slow
@pytest.mark.parametrize(
    "story", ["my_rod", *(pytest.param(story, marks=pytest.mark.slow) for story in ("recorded_force", "two_equations"))]
)
def test_what_the_terminal_shows(story: str, ran: Ran) -> None:
    _, folder = ran(story)
    text = (HOW_TO / f"{story}.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```console\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    assert blocks
    for block in blocks:
        require_as_shown(block, folder, in_this_process)


# --- my rod -----------------------------------------------------------------------------------------------------------


def rates(rod: Any, mean: float, amplitude: float, omega: float, modes: range) -> Any:
    """Return the growth rates in 1/s of modes 1, 2, ..., integrated in physical units from Eq. (1) by DOP853."""
    mass = rod.density * math.pi * rod.radius**2
    stiffness = rod.youngs_modulus * math.pi * rod.radius**4 / 4.0
    floor = mass * rod.gravity / (rod.channel_radius - rod.radius)
    n = np.array(modes)
    k = n * math.pi / rod.length

    def motion(t: float, y: Any) -> Any:
        u = y.reshape(n.size, 2, 2)  # mode, (displacement, speed), start
        force = mean + amplitude * math.sin(omega * t)
        pull = (stiffness * k**4 - force * k**2 + floor) / mass
        return np.stack([u[:, 1], -pull[:, None] * u[:, 0] - 2.0 * rod.damping_rate * u[:, 1]], axis=1).ravel()

    period = 2.0 * math.pi / omega
    start = np.broadcast_to(np.eye(2), (n.size, 2, 2)).ravel()
    end = solve_ivp(motion, (0.0, period), start, method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    return np.log(np.abs(np.linalg.eigvals(end.reshape(n.size, 2, 2))).max(axis=1)) / period


@pytest.mark.slow
def test_my_rod_is_stable_in_its_windows_alone(ran: Ran) -> None:
    names, _ = ran("my_rod")
    rod, windows = names["rod"], names["windows"]
    assert math.isclose(rod.length, 12.192)
    assert math.isclose(rod.radius, 0.00635)
    inside = [0.5 * (window.low + window.high) for window in windows]
    for omega in inside:
        assert rates(rod, names["mean"], names["amplitude"], omega, range(1, 13)).max() < 1e-6
    for band in windows.unstable:
        found = rates(rod, names["mean"], names["amplitude"], band.at, range(1, 13)).max()
        assert abs(found - band.worst_growth) < 1e-6
    assert windows.table() == windows.table("Hz") == windows.table("Hz", 2.0 * math.pi)  # in the unit of the question
    assert windows.table("rad/s") == windows.table("rad/s", 1.0)
    with pytest.raises(ValueError, match=r"unit must be a unit of frequency \(rad/s, .*, rpm\), got 'N'"):
        windows.table("N")


@pytest.mark.slow
def test_the_damping_that_the_band_of_my_rod_needs(ran: Ran) -> None:
    names, _ = ran("my_rod")
    rod, needed = names["rod"], names["damping"]
    worst = max(names["windows"].unstable, key=lambda band: band.required_damping)
    for factor, grows in ((0.995, True), (1.005, False)):
        damped = rod.replace(damping_rate=factor * needed)
        places = np.linspace(worst.at * 0.98, worst.at * 1.02, 41)
        found = max(rates(damped, names["mean"], names["amplitude"], w, range(5, 10)).max() for w in places)
        assert (float(found) > 0.0) is grows
    assert len(names["damped"]) == 1


def test_the_window_of_my_rod_is_safe_wherever_it_is_tried(ran: Ran) -> None:
    names, _ = ran("my_rod")
    rod, mean, amplitude, hertz = names["rod"], names["mean"], names["amplitude"], 2.0 * math.pi
    window = {"mean": (0.95 * mean, 1.05 * mean), "amplitude": (0.0, amplitude)}
    window["frequency"] = (14.0 * hertz, 15.0 * hertz)
    assert rod.certify(**window, rod={"length": (12.16, 12.22)}).status == "stable"
    for *load, length in itertools.product(*window.values(), (12.16, 12.22)):
        assert rates(rod.replace(length=length), *load, range(1, 12)).max() < 1e-6


# --- the ion trap -----------------------------------------------------------------------------------------------------


def characteristic(kind: str, q: float) -> Any:
    """Return a_0(q) or b_1(q) in 30 digits, an eigenvalue of a truncated matrix (DLMF 28.4)."""
    size = 16
    matrix = mpmath.zeros(size)
    for j in range(size):
        order = 2 * j if kind == "a" else 2 * j + 1
        matrix[j, j] = order * order
        if j:
            matrix[j, j - 1] = matrix[j - 1, j] = q * (mpmath.sqrt(2) if kind == "a" and j == 1 else 1)
    if kind == "b":
        matrix[0, 0] -= q
    return min(mpmath.eigsy(matrix, eigvals_only=True))


@pytest.mark.slow
def test_tip_and_area_of_the_ion_trap(ran: Ran) -> None:
    names, _ = ran("ion_trap")
    with mpmath.workdps(30):
        tip = mpmath.findroot(lambda q: characteristic("b", q) + characteristic("a", q), (0.70, 0.71), solver="secant")
        end = mpmath.findroot(lambda q: characteristic("b", q), (0.90, 0.91), solver="secant")
        assert abs(tip - names["tip"]) < 1e-13
        assert abs(end - names["end"]) < 1e-13
        assert abs(characteristic("b", tip) - names["edge_x"](names["tip"])) < 1e-13
    assert (round(names["tip"], 3), round(names["edge_x"](names["tip"]), 3)) == (0.706, 0.237)
    left = quad(lambda q: -float(characteristic("a", q)), 0.0, float(tip), epsabs=1e-11)[0]
    right = quad(lambda q: float(characteristic("b", q)), float(tip), float(end), epsabs=1e-11)[0]
    assert abs(2.0 * (left + right) - names["area"]) < 1e-10


@pytest.mark.slow
def test_the_edge_of_the_damped_ion_trap(ran: Ran) -> None:
    names, _ = ran("ion_trap")
    for axis in (1, -1):

        def growth(a: float, q: float = 0.7, k: float = 0.1, axis: int = axis) -> float:
            """Return the logarithm of the larger multiplier, by DOP853."""

            def motion(z: float, y: Any) -> Any:
                u = y.reshape(2, 2)
                return np.concatenate([u[1], -2.0 * k * u[1] - axis * (a - 2.0 * q * math.cos(2.0 * z)) * u[0]])

            end = solve_ivp(motion, (0.0, math.pi), np.eye(2).ravel(), method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
            return float(np.log(np.abs(np.linalg.eigvals(end.reshape(2, 2))).max()))

        assert abs(brentq(growth, 0.05, 0.9, xtol=1e-12) - names["edge"](0.7, 0.1, axis)) < 1e-9
    assert (names["x"].status, names["y"].status) == ("stable", "stable")


# --- a recorded force -------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_record_is_what_was_recorded(ran: Ran) -> None:
    names, _ = ran("recorded_force")
    record = names["record"]
    assert abs(record.frequency - names["w"]) < 4.0 * record.frequency_error < 0.01
    assert record.harmonic_numbers == (1, 2, 3)
    for found, error, true in zip(record.harmonics, record.harmonic_errors, (85.0, 58.0, 22.0), strict=False):
        assert abs(abs(found) - true) < 4.0 * error < 1.0


@pytest.mark.slow
def test_growth_under_the_record_and_none_under_the_sine(ran: Ran) -> None:
    names, _ = ran("recorded_force")
    rod, record = names["rod"], names["record"]
    mass = rod.density * math.pi * rod.radius**2
    stiffness = rod.youngs_modulus * math.pi * rod.radius**4 / 4.0
    floor = mass * rod.gravity / (rod.channel_radius - rod.radius)
    k = 11 * math.pi / rod.length

    def motion(t: float, y: Any) -> Any:
        u = y.reshape(2, 2)
        pull = (stiffness * k**4 - record.force(t) * k**2 + floor) / mass
        return np.concatenate([u[1], -pull * u[0] - 2.0 * rod.damping_rate * u[1]])

    end = solve_ivp(motion, (0.0, record.period), np.eye(2).ravel(), method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    growth = math.log(np.abs(np.linalg.eigvals(end.reshape(2, 2))).max()) / record.period
    verdict = rod.stability(record)
    assert verdict.status == "unstable"
    assert abs(growth - verdict.growth_rate) < 1e-5
    assert rates(rod, record.mean, record.amplitude, record.frequency, range(1, 14)).max() < 0.0
    assert rod.stability(names["sine"]).status == "stable"
    assert record.mean not in names["safe"]


# --- a crash ----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_nothing_is_lost_in_the_crash(ran: Ran) -> None:
    import floquetrod as fr

    names, folder = ran("cluster")
    (warning,) = names["warned"]
    assert warning.category is fr.OutcomeWarning
    assert "still swinging" in str(warning.message)
    study: dict[str, Any] = {"__name__": "study"}
    exec((folder / "study.py").read_text(encoding="utf-8"), study)
    whole = fr.ensemble(study["problem"], study["over"])
    assert np.array_equal(names["after"]["largest_angle"], whole["largest_angle"])
    assert np.array_equal(names["after"]["buckled"], whole["buckled"])
    beta = pytest.importorskip("scipy.stats").beta
    for row, (low, high) in enumerate(zip(names["chance"]["lower"], names["chance"]["upper"], strict=True)):
        hits, n = int(np.sum(whole["buckled"][row])), len(study["over"]["seed"])
        assert np.isclose(low, beta.ppf(0.025, hits, n - hits + 1) if hits else 0.0)
        assert np.isclose(high, beta.ppf(0.975, hits + 1, n - hits) if hits < n else 1.0)


# --- two equations ----------------------------------------------------------------------------------------------------


def monodromy_growth(system: Any, omega: float) -> float:
    """Return the growth rate of a damped system with one cosine, integrated by DOP853."""
    n = system.stiffness.shape[0]
    inverse = np.linalg.inv(np.eye(n) if system.mass is None else system.mass)
    none, one = np.zeros((n, n)), np.eye(n)
    mean = np.block([[none, one], [-inverse @ system.stiffness, -inverse @ system.damping]])
    wave = np.block([[none, none], [-inverse @ system.cosines[0], none]])

    def motion(t: float, y: Any) -> Any:
        return ((mean + wave * math.cos(omega * t)) @ y.reshape(2 * n, 2 * n)).ravel()

    start = np.eye(2 * n).ravel()
    end = solve_ivp(motion, (0.0, system.period), start, method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    return math.log(np.abs(np.linalg.eigvals(end.reshape(2 * n, 2 * n))).max()) / system.period


@pytest.mark.slow
def test_two_equations_grow_as_integrated(ran: Ran) -> None:
    names, _ = ran("two_equations")
    verdict = names["verdict"]
    assert abs(verdict.growth_rate - monodromy_growth(names["oscillators"](3.0, 0.2), 3.0)) < 1e-8
    assert (verdict.resonances[0].kind, verdict.resonances[0].modes) == ("sum", (1, 2))
    for omega, growing in ((9.6, True), (14.0, False)):
        growth = monodromy_growth(names["double_pendulum"](omega, 0.02), omega)
        assert (growth > 0.0) is growing
    # by hand: alone, each oscillator obeys an equation of its own and decays at this frequency
    for index in (0, 1):
        one = names["oscillators"](3.0, 0.2)
        alone = type(one)(
            one.stiffness[index : index + 1, index : index + 1],
            [one.cosines[0][index : index + 1, index : index + 1]],
            damping=[[0.02]],
            period=one.period,
        )
        assert monodromy_growth(alone, 3.0) < 0.0


# --- my equation, and the README -------------------------------------------------------------------------------------


def test_the_value_of_order_50_and_that_of_scipy() -> None:
    import floquetrod as fr

    size = 160
    matrix = np.diag([(2.0 * j) ** 2 for j in range(size)]) + 2000.0 * (np.eye(size, k=1) + np.eye(size, k=-1))
    matrix[0, 1] = matrix[1, 0] = 2000.0 * math.sqrt(2.0)
    even = np.linalg.eigvalsh(matrix)
    assert abs(fr.mathieu.characteristic_values(50, 2000.0, "a") - even[25]) < 1e-9 * even[25]
    assert abs(special.mathieu_a(50, 2000.0) - even[25]) > 100.0


@pytest.mark.slow
def test_my_equation_solved_in_z(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = (HOW_TO / "my_equation.md").read_text(encoding="utf-8")
    # The page's last part defines a class, which takes more lines.
    assert max(len(lines) for heading, lines in own_code(text) if not heading.startswith("An equation of my own")) < 10
    names = execute(text)
    with mpmath.workdps(20):
        y = mpmath.odefun(lambda z, y: [y[1], -(7 - 6 * mpmath.cos(2 * z)) * y[0]], 0, [1, 0])(3)
    assert abs(names["solution"](3.0) - y[0]) < 1e-12
    assert abs(names["solution"](3.0, derivative=1) - y[1]) < 1e-11


def test_the_readme_fits_one_screen() -> None:
    assert len((HOW_TO.parents[1] / "README.md").read_text(encoding="utf-8").splitlines()) <= 85
