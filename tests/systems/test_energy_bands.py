"""Bands of energies against Hill's matrix, transfer matrices of steps, Mathieu's values and closed forms; proofs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.optimize import brentq

import floquetrod as fr
from tests.conftest import depth

PRINTED = fr.Hill(0.0, cosines=(2.0, 0.0, -0.4), sines=(0.0, 0.6))
COUPLED = fr.HillSystem(
    -np.array([[1.0, 0.3], [0.3, 2.0]]), [-np.array([[1.0, 0.5], [0.5, 0.2]])], [-np.array([[0.0, 0.3], [0.3, 0.9]])]
)


def hill_matrix(system: fr.HillSystem, phase: float, cut: int = 50) -> NDArray[Any]:
    """Return the eigenvalues of -d^2/dt^2 + V, V = -K one Fourier series, in exp(i (k + phase / 2 pi) w t)."""
    n, omega = system.order, 2.0 * math.pi / float(system.period)
    size = 2 * cut + 1
    wave = omega * (np.arange(-cut, cut + 1) + phase / (2.0 * math.pi))
    blocks = np.zeros((size, n, size, n), dtype=complex)
    rows = np.arange(size)
    blocks[rows, :, rows, :] = wave[:, None, None] ** 2 * np.eye(n) - system.stiffness
    for k, amplitude in enumerate(system.harmonics, start=1):
        blocks[rows[k:], :, rows[:-k], :] = -0.5 * amplitude
        blocks[rows[:-k], :, rows[k:], :] = -0.5 * amplitude.conj()
    return np.asarray(np.linalg.eigvalsh(blocks.reshape(size * n, size * n)))


def step_energies(pieces: list[tuple[float, float]], phase: float, below: float) -> list[float]:
    """Return the energies of a potential of steps (length, V): zeros of the trace less 2 cos phase, by bisection."""

    def missing(energy: float) -> float:
        total = np.eye(2)
        for length, level in pieces:
            square = energy - level
            root = math.sqrt(abs(square))
            c, s = (math.cos, math.sin) if square > 0.0 else (math.cosh, math.sinh)
            turn = root * length
            total = np.array([[c(turn), s(turn) / root], [-math.copysign(root, square) * s(turn), c(turn)]]) @ total
        return float(np.trace(total)) - 2.0 * math.cos(phase)

    grid = np.linspace(min(level for _, level in pieces) + 1e-9, below, 6000)
    values = [missing(e) for e in grid]
    crossings = [i for i in range(len(grid) - 1) if values[i] * values[i + 1] < 0.0]
    return [brentq(missing, grid[i], grid[i + 1], xtol=1e-14, rtol=1e-14) for i in crossings]


# --- numbers known otherwise -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("phase", "energies"),
    [
        (0.0, [-1.114891238879, 0.589181460950, 1.757690083748, 4.025553369463, 4.285592114912, 9.059569332736]),
        (1.0, [-1.113749736271, 0.566944546496, 1.842423137741, 3.566378866403, 4.805684214430, 8.145014732469]),
        (math.pi, [-1.109885142510, 0.501856986098, 2.310637432680, 2.721097889836, 6.311860277183, 6.385321979556]),
    ],
)
def test_energies_to_forty_digits_rounded(phase: float, energies: list[float]) -> None:
    found = fr.bands(PRINTED, phase=phase, below=10.0)
    assert found.energies[:6] == pytest.approx(energies, abs=1.1e-12)
    assert found.errors.max() < 1e-12
    for turned in (-phase, phase + 2.0 * math.pi):
        assert fr.bands(PRINTED, turned, below=5.0).energies == pytest.approx(
            found.energies[found.energies < 5.0], abs=1e-13
        )


@pytest.mark.parametrize("q", [0.3, 1.0, 8.0])
def test_mathieu_has_the_same_values(q: float) -> None:
    equation = fr.Mathieu.from_aq(0.0, q)
    for order in (0.3, 0.5, 0.8):
        energies = fr.bands(equation, math.pi * order, below=30.0).energies
        expected = sorted(fr.mathieu.real_order_values(nu, q) for nu in (order, 2 - order, 2 + order, 4 - order))
        assert energies[:4] == pytest.approx(expected, abs=1e-12)
    edges = fr.bands(equation, 0.0, below=30.0).edges
    a, b = (fr.mathieu.characteristic_values(np.arange(1, 4), q, kind) for kind in "ab")
    expected = sorted([fr.mathieu.characteristic_values(0, q, "a"), *a, *b])
    assert edges.ravel()[:7] == pytest.approx(expected, abs=1e-12)


def test_free_waves() -> None:
    found = fr.bands(fr.Hill(0.5, period=2.0), [0.0, 1.0], below=20.0)
    free = sorted(0.5 + ((1.0 + 2.0 * math.pi * k) / 2.0) ** 2 for k in range(-3, 4))
    assert found.energies[1][: sum(e < 20.0 for e in free)] == pytest.approx([e for e in free if e < 20.0], abs=1e-12)
    assert found.gaps.shape == (0, 2)
    assert found.density(10.5) == pytest.approx(1.0 / (2.0 * math.pi * math.sqrt(10.0)), rel=1e-10)
    assert not any(edge.proved for edge in found.certify()[1:])


# --- drawn potentials ------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_drawn_potentials(rng: np.random.Generator) -> None:
    check(rng, depth(6, 3))


@pytest.mark.slow
def test_many_drawn_potentials(rng: np.random.Generator) -> None:
    check(rng, 70)


def check(rng: np.random.Generator, each: int) -> None:
    """Compare ``each`` series, systems and potentials of steps with independent computations."""
    for _ in range(each):
        period, phase = float(rng.uniform(0.5, 8.0)), float(rng.uniform(0.0, math.pi))
        unit = (2.0 * math.pi / period) ** 2
        count, below = int(rng.integers(1, 5)), unit * float(rng.uniform(1.0, 12.0))
        size = unit * 10.0 ** rng.uniform(-1.0, 1.0)
        series = fr.Hill(float(rng.normal()), size * rng.normal(size=count), size * rng.normal(size=count), period)
        compare(series, hill_matrix(series.as_system(), phase), phase, below)

        n = int(rng.integers(2, 4))
        waves = [0.5 * size * (m + m.T) for m in rng.normal(size=(3, n, n))]
        system = fr.HillSystem(waves[0], [waves[1]], [waves[2]], period=period)
        compare(system, hill_matrix(system, phase), phase, below)

        steps = [(float(length), float(level)) for length, level in rng.uniform(0.2, 3.0, (int(rng.integers(2, 5)), 2))]
        jumping = fr.HillSystem.from_pieces([(length, [[-level]]) for length, level in steps])
        compare(jumping, np.array(step_energies(steps, phase, 20.0)), phase, 20.0)


def compare(potential: Any, expected: NDArray[Any], phase: float, below: float) -> None:
    found = fr.bands(potential, phase, below=below)
    expected = expected[expected < below]
    assert len(found.energies) == len(expected)
    # Of Hill's matrix in doubles, whose largest entries round.
    slack = 4e-15 * (50.0 * 2.0 * math.pi / float(potential.period)) ** 2 + 4e-13 * (1.0 + np.abs(expected))
    assert (np.abs(found.energies - expected) <= slack + found.errors).all()
    assert (found.errors < 1e-12 * (1.0 + np.abs(expected).max(initial=0.0)) + 1e-12 * abs(below)).all()


# --- what else they tell ---------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_edges_gaps_and_proofs() -> None:
    found = fr.bands(PRINTED, below=3.0)
    assert found.energies.shape == (65, 4)
    assert np.nanmin(found.energies, axis=0) == pytest.approx(found.edges[:, 0], abs=1e-13)
    assert found.gaps[0] == pytest.approx([-1.109885142510, 0.501856986098], abs=1e-12)
    assert found.edge_errors.max() < 1e-12
    proofs = found.certify()
    assert all(edge.proved for edge in proofs)
    assert [edge.energy for edge in proofs] == found.edges.ravel().tolist()
    assert not any(edge.proved for edge in found.certify(within=1e-16))
    assert fr.stability(found.at(0.55)).stable
    assert fr.stability(found.at(1.0)).status == "unstable"


@pytest.mark.slow
@pytest.mark.parametrize(
    "potential",
    [
        fr.Meissner(2.0, 0.5),
        fr.Mathieu(1.0, 0.2),
        fr.Mathieu.from_aq(0.5, 1.0),
        fr.Hill.from_function(lambda t: 5.0 if t % 2.0 < 0.5 else 0.0, 2.0, jumps=[0.0, 0.5]),
        fr.HillSystem.from_pieces([(0.5, [[-5.0]]), (1.5, [[0.0]])]),
    ],
)
def test_edges_are_proved_of_every_kind_of_equation(potential: Any) -> None:
    found = fr.bands(potential, 0.0, below=3.0)
    assert len(found.certify()) >= 2
    assert all(edge.proved for edge in found.certify(within=1e-11))


def test_functions_are_the_equations_they_compute() -> None:
    by_function = fr.bands(
        lambda t: 2.0 * math.cos(t) + 0.6 * math.sin(2 * t) - 0.4 * math.cos(3 * t), 1.0, below=5.0, period=2 * math.pi
    )
    assert by_function.energies == pytest.approx(fr.bands(PRINTED, 1.0, below=5.0).energies, abs=1e-12)
    walls = fr.bands(lambda t: 5.0 if t % 2.0 < 0.5 else 0.0, 1.0, below=30.0, period=2.0, jumps=[0.0, 0.5])
    assert walls.energies == pytest.approx(step_energies([(0.5, 5.0), (1.5, 0.0)], 1.0, 30.0), abs=1e-12)
    matrix = fr.bands(lambda t: -COUPLED.coefficient(t), 1.0, below=5.0, period=2 * math.pi)
    assert matrix.energies == pytest.approx(fr.bands(COUPLED, 1.0, below=5.0).energies, abs=1e-11)


def test_bands_of_uncoupled_equations_are_theirs_together() -> None:
    one, other = fr.Hill(0.3, (1.0,)), fr.Hill(0.0, (0.5,), (0.2,))
    both = fr.HillSystem(np.diag([-0.3, 0.0]), [np.diag([-1.0, -0.5])], [np.diag([0.0, -0.2])])
    energies = fr.bands(both, 0.7, below=6.0).energies
    alone = np.concatenate([fr.bands(each, 0.7, below=6.0).energies for each in (one, other)])
    assert energies == pytest.approx(np.sort(alone), abs=1e-12)
    density = fr.bands(both, 0.7, below=6.0).density([2.0, 3.0])
    assert density == pytest.approx(sum(fr.bands(each, 0.7, below=6.0).density([2.0, 3.0]) for each in (one, other)))


def test_a_mass_divides_energies() -> None:
    heavy = fr.HillSystem(
        4.0 * COUPLED.stiffness, [4.0 * COUPLED.cosines[0]], [4.0 * COUPLED.sines[0]], mass=4.0 * np.eye(2)
    )
    assert fr.bands(heavy, 1.0, below=4.0).energies == pytest.approx(
        fr.bands(COUPLED, 1.0, below=4.0).energies, abs=1e-12
    )


@pytest.mark.slow
def test_edges_of_a_system_lie_between_phases_too() -> None:
    found = fr.bands(COUPLED, 0.0, below=4.0)
    phases = np.linspace(0.0, math.pi, 400)
    every = np.array([hill_matrix(COUPLED, phase, 25)[: len(found.edges)] for phase in phases])
    assert (found.edges[:, 0] <= every.min(axis=0) + 1e-9).all()
    assert (found.edges[:, 1] >= every.max(axis=0) - 1e-9).all()
    assert found.edges == pytest.approx(np.stack([every.min(axis=0), every.max(axis=0)], axis=1), abs=1e-4)
    assert 0.1 < phases[every[:, 4].argmin()] < 3.0


def test_a_band_holds_one_state_a_period() -> None:
    found = fr.bands(PRINTED, 0.0, below=3.0)
    low, high = found.edges[2]
    # E = low + (high - low) sin(x)^2 takes away the roots at both ends.
    width = high - low
    states = quad(
        lambda x: found.density(low + width * math.sin(x) ** 2) * width * math.sin(2 * x), 1e-4, 0.5 * math.pi - 1e-4
    )
    assert states[0] == pytest.approx(1.0 / (2.0 * math.pi), rel=1e-3)
    assert found.density([0.0, -5.0, 1.0]).tolist() == [0.0, 0.0, 0.0]
    assert found.density([]).shape == (0,)


def test_velocities_are_derivatives() -> None:
    for potential in (PRINTED, COUPLED):
        around = fr.bands(potential, [1.0 - 1e-4, 1.0, 1.0 + 1e-4], below=6.0)
        slopes = (around.energies[2] - around.energies[0]) / 2e-4
        assert around.velocities[1] == pytest.approx(slopes, abs=1e-6)
        assert fr.bands(potential, -1.0, below=6.0).velocities == pytest.approx(-around.velocities[1], abs=1e-9)


@pytest.mark.slow
def test_few_and_no_energies() -> None:
    none = fr.bands(PRINTED, [0.0, 1.0], below=-3.0)
    assert none.energies.shape == (2, 0)
    assert none.edges.shape == none.gaps.shape == (0, 2)
    assert none.certify() == ()
    some = fr.bands(PRINTED, [0.0, math.pi], below=0.55)
    assert np.isnan(some.energies).tolist() == [[False, True], [False, False]]


def test_pictures() -> None:
    axes = fr.bands(PRINTED, below=3.0).plot()
    assert len(axes.figure.axes) == 2
    assert axes.figure.axes[1].get_xlabel() == "density of states"
    assert fr.bands(PRINTED, 0.0, below=3.0).plot(axes) is axes


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: fr.bands(fr.Mathieu(0.5, -0.2, 0.1), below=1.0), "potential must be undamped"),
        (lambda: fr.bands(math.cos, below=1.0), "period must be given"),
        (lambda: fr.bands(PRINTED, below=1.0, period=2.0), "period and jumps are those of a function"),
        (lambda: fr.bands(PRINTED, [[0.0]], below=1.0), "phase must be a number or a sequence"),
        (lambda: fr.bands(1.0, below=1.0), "potential must be an Equation such as Hill"),
        (lambda: fr.bands(PRINTED, below=1e6), "below must be lower"),
        (lambda: fr.bands(PRINTED, below=math.nan), "below must be"),
        (lambda: fr.bands(fr.HillSystem([[1.0, 0.1], [0.0, 1.0]]), below=1.0), "symmetric stiffness"),
        (lambda: fr.bands(fr.PeriodicSystem([[1.0]]), below=1.0), "potential must be an Equation"),
        (lambda: fr.bands(COUPLED, 0.0, below=2.0).certify(), "bands must be of one equation to be proved"),
        (lambda: fr.bands(PRINTED, 0.0, below=2.0).certify(within=0.0), "within must be greater than zero"),
    ],
)
def test_what_is_refused(call: Any, message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        call()
