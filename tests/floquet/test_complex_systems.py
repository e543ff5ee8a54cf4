"""Complex systems and systems that keep the norm, by every call, against DOP853 and closed forms."""

from __future__ import annotations

import functools
import itertools
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import linear_sum_assignment

import floquetrod as fr
from floquetrod.equations.complex_form import complex_matrix, real_matrix
from floquetrod.equations.system_files import read_system
from tests.conftest import depth

SX, SY, SZ = np.array([[0, 1], [1, 0]]), np.array([[0, -1j], [1j, 0]]), np.diag([1, -1])
UP = np.array([[0, 1], [0, 0]])


def atom(detuning: float, drive: float, omega: float) -> fr.PeriodicSystem:
    """Return H = detuning / 2 sigma_z + drive / 2 cos(omega t) sigma_x."""
    return fr.PeriodicSystem(-0.5j * detuning * SZ, cosines=[-0.5j * drive * SX], period=2.0 * math.pi / omega)


def lossy(gain: float = 0.0, omega: float = 1.0) -> fr.PeriodicSystem:
    """Return x' = [[-0.1 + i, 0.3 e^(i w t)], [0.2 e^(-i w t), -0.05 - 0.5 i]] x + gain x."""
    mean = np.diag([-0.1 + 1j, -0.05 - 0.5j]) + gain * np.eye(2)
    cosines, sines = 0.3 * UP + 0.2 * UP.T, 0.3j * UP - 0.2j * UP.T
    return fr.PeriodicSystem(mean, cosines=[cosines], sines=[sines], period=2.0 * math.pi / omega)


def skew(matrix: NDArray[Any]) -> NDArray[Any]:
    """Return a skew-Hermitian matrix, exactly."""
    return np.asarray(matrix - matrix.conj().T)


def drawn(rng: np.random.Generator, *, unitary: bool, real: bool = False) -> fr.PeriodicSystem:
    """Return a system of up to five equations, of harmonics or of pieces."""
    n = int(rng.integers(1, 6))

    def matrix(size: float) -> NDArray[Any]:
        entries = rng.normal(size=(n, n)) + (0.0 if real else 1j * rng.normal(size=(n, n)))
        return size * (skew(entries) if unitary else entries)

    period = float(rng.uniform(0.5, 6.0))
    if rng.random() < 0.25:
        shares = rng.uniform(0.3, 1.0, int(rng.integers(2, 5)))
        return fr.PeriodicSystem.from_pieces([(float(s * period), matrix(0.5)) for s in shares])
    mean = matrix(0.5) - (0.0 if unitary else rng.uniform(-0.5, 1.0) * np.eye(n))
    count = int(rng.integers(0, 4))
    return fr.PeriodicSystem(mean, [matrix(0.4) for _ in range(count)], [matrix(0.3)] * (count > 1), period=period)


def maps_over_pieces(system: fr.PeriodicSystem) -> list[NDArray[Any]]:
    """Return the maps from one jump to the next by DOP853, of a system without jumps the one over its period."""
    n, begin, maps = system.order, 0.0, []
    for duration, value in system.pieces or [(system.period, None)]:
        rates: Any = system.coefficient if value is None else lambda t, value=value: value.start
        span = (begin, begin + float(duration))

        def right(t: float, x: Any, rates: Any = rates) -> Any:
            """Return dx/dt of the map, flat."""
            return (rates(t) @ x.reshape(n, n)).ravel()

        start = np.eye(n, dtype=complex).ravel()
        maps.append(solve_ivp(right, span, start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1].reshape(n, n))
        begin = span[1]
    return maps


def apart(one: Any, other: Any) -> float:
    """Return the largest distance of two sets of numbers, paired one to one."""
    gaps = np.abs(np.asarray(one)[:, None] - np.asarray(other)[None, :])
    return float(gaps[linear_sum_assignment(gaps)].max())


# --- printed numbers -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("system", "energies"),
    [
        (atom(1.0, 0.5, 1.0), [-0.375247278169, 0.375247278169]),
        (atom(2.0, 3.0, 2.5), [-0.509876707341, 0.509876707341]),
        (
            fr.PeriodicSystem(-0.5j * SZ, cosines=[-0.7j * SX], sines=[-0.7j * SY], period=2.0 * math.pi / 1.3),
            [-0.0658910531638, 0.0658910531638],
        ),
        (
            fr.PeriodicSystem(
                -1j * np.array([[0, 1, 0], [1, 0, 0], [0, 0, 0.5]]),
                cosines=[-0.4j * np.array([[0, 0, 0], [0, 0, 1], [0, 1, 0]])],
                sines=[-0.001j * np.diag([0, 0, 1])],
                period=math.pi,
            ),
            [-0.967672565010, 0.473033623995, 0.994638941015],
        ),
    ],
)
def test_quasienergies(system: fr.PeriodicSystem, energies: list[float]) -> None:
    for result in (fr.stability(system), *fr.compare(system).results):
        assert result.status == "stable"
        assert result.structure == "unitary"
        assert result.quasienergies == pytest.approx(energies, abs=1e-12)
        assert max(result.quasienergy_errors) < 3e-12
        assert all(exponent.real == 0.0 for exponent in result.exponents)


def test_a_rotating_field_has_a_closed_form() -> None:
    for omega, field in itertools.product((0.3, 1.3, 5.0), (0.1, 0.7)):
        system = fr.PeriodicSystem(
            -0.5j * SZ, cosines=[-1j * field * SX], sines=[-1j * field * SY], period=2.0 * math.pi / omega
        )
        # In the rotating frame H = (1 - omega) / 2 sigma_z + field sigma_x; the frame itself turns by half a turn.
        rabi = math.hypot(0.5 * (1.0 - omega), field)
        expected = [math.remainder(sign * rabi + 0.5 * omega, omega) for sign in (-1.0, 1.0)]
        result = fr.stability(system)
        assert result.quasienergies == pytest.approx(sorted(expected), abs=2e-12)


def test_losses_have_exponents_modulo_the_frequency() -> None:
    for result in fr.compare(lossy()).results:
        expected = [-0.001635012574 - 0.335190500527j, -0.148364987426 - 0.164809499473j]
        assert apart(result.exponents, expected) < 2e-12
        assert result.structure == "general"
        assert result.stable
        assert result.quasienergies == ()
    assert fr.stability(lossy(0.01)).growth_rate == pytest.approx(0.01 - 0.001635012574, abs=1e-12)


def test_an_energy_on_the_edge_is_half_the_frequency() -> None:
    result = fr.stability(fr.PeriodicSystem([[0.5j]], cosines=[[[0.25j]]]))
    assert result.quasienergies == pytest.approx([0.5], abs=1e-12)


# --- against an independent integration ------------------------------------------------------------------------------


@pytest.mark.parametrize("unitary", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_drawn_systems(unitary: bool, rng: np.random.Generator) -> None:
    check(rng, unitary=unitary, count=depth(15, 8))


@pytest.mark.slow
@pytest.mark.parametrize("unitary", [True, False])
def test_many_drawn_systems(unitary: bool, rng: np.random.Generator) -> None:
    check(rng, unitary=unitary, count=depth(100, 60))


def check(rng: np.random.Generator, *, unitary: bool, count: int) -> None:
    for i in range(count):
        system = drawn(rng, unitary=unitary, real=unitary and i % 5 == 0)
        maps = maps_over_pieces(system)
        multipliers = np.linalg.eigvals(functools.reduce(lambda before, after: after @ before, maps))
        result = fr.stability(system)
        assert result.multipliers == pytest.approx(fr.stability(system).multipliers)
        scale = max(1.0, float(np.abs(multipliers).max()))
        assert apart(result.multipliers, multipliers) < 1e-8 * scale + 2.0 * max(result.multiplier_errors), system
        check_batch(fr.systems.multipliers(system), multipliers, maps, unitary=unitary)
        largest = float(np.abs(multipliers).max())
        if unitary:
            assert result.stable
            assert max(result.quasienergy_errors) * result.period < 1e-8
            assert fr.certify(system).stable
        elif abs(largest - 1.0) > 1e-6:
            assert result.status == ("stable" if largest < 1.0 else "unstable"), system
            assert fr.systems.is_stable(system) == result.stable
        gaps = [abs(e.imag) * result.period for e in result.exponents]
        assert max(gaps) <= math.pi * (1.0 + 1e-14)


def check_batch(batch: Any, multipliers: Any, maps: list[NDArray[Any]], *, unitary: bool) -> None:
    """Check multipliers of `systems.multipliers`: all of a system that keeps the norm, else NaN where they are lost.

    The rounding in which they are lost grows as the product of the norms of the maps.
    """
    known = batch[: np.count_nonzero(np.isfinite(batch))]
    assert np.isfinite(known).all(), "NaN are last"
    assert len(known) == len(multipliers) or not unitary
    assert len(known) > 0
    gaps = np.abs(known[:, None] - multipliers[None, :])
    rows, columns = linear_sum_assignment(gaps)
    assert gaps[rows, columns].max() < 1e-8 * max(1.0, float(np.abs(multipliers).max()))
    rounding = 1e-8 * math.prod(float(np.linalg.norm(matrix, 2)) for matrix in maps)
    assert np.abs(np.delete(multipliers, columns)).max(initial=0.0) < rounding


def test_multipliers_lost_in_the_rounding_of_the_largest_are_nan_in_a_batch() -> None:
    system = fr.PeriodicSystem(np.diag([25.0 + 1j, 1j, -25.0]), [0.1 * np.eye(3)], period=1.0)
    batch = fr.systems.multipliers(system)
    assert np.isnan(batch).tolist() == [False, True, True]
    expected = np.exp([25.0 + 1j, 1j, -25.0])
    check_batch(batch, expected, [np.diag(expected)], unitary=False)
    assert fr.stability(system).multipliers == pytest.approx(expected, rel=1e-6)


def test_batches_are_the_single_answers(rng: np.random.Generator) -> None:
    omegas = np.linspace(0.7, 2.0, 7)
    systems = [lossy(float(gain), float(omega)) for gain, omega in zip(rng.uniform(-0.1, 0.1, 7), omegas, strict=True)]
    batch = fr.systems.stack(systems)
    assert batch.is_complex
    alone = [fr.stability(system) for system in systems]
    assert fr.systems.is_stable(batch).tolist() == [result.stable for result in alone]
    assert fr.systems.growth_rate(batch) == pytest.approx([result.growth_rate for result in alone], abs=1e-11)
    for row, result in zip(fr.systems.multipliers(batch), alone, strict=True):
        assert apart(row, result.multipliers) < 1e-11
    norms = fr.systems.multipliers(fr.PeriodicSystem(-0.5j * SZ, cosines=[-0.5j * SX], period=omegas))
    assert np.abs(norms) == pytest.approx(1.0, abs=1e-15)


def test_charts_take_families_that_are_complex_in_places() -> None:
    def family(gain: float, turn: float) -> fr.PeriodicSystem:
        return fr.PeriodicSystem([[gain + turn * 1j, 0.1], [0.0, -0.1 - turn * 1j]], period=2.0)

    chart = fr.chart(family, over={"gain": (-0.2, 0.2, 4), "turn": (0.0, 1.0, 3)})
    assert chart.stable.tolist() == [[True, True, False, False]] * 3


# --- systems that keep the norm --------------------------------------------------------------------------------------


@pytest.mark.slow
def test_equal_energies_cost_no_digits() -> None:
    copies = fr.PeriodicSystem(np.kron(np.eye(3), -0.5j * SZ), cosines=[np.kron(np.eye(3), -0.25j * SX)])
    for result in fr.compare(copies).results:
        assert result.stable
        assert result.quasienergies == pytest.approx([-0.375247278169] * 3 + [0.375247278169] * 3, abs=1e-11)
    turn = np.kron(np.array([[0.0, 1.0], [-1.0, 0.0]]), np.eye(2))
    for result in fr.compare(fr.PeriodicSystem(np.zeros((4, 4)), cosines=[turn], period=3.0)).results:
        assert result.stable
        assert max(result.exponent_errors) < 1e-11


def test_real_forms_written_by_hand_have_the_same_energies() -> None:
    system = atom(1.0, 0.5, 1.0)
    by_hand = fr.PeriodicSystem(real_matrix(system.mean), cosines=[real_matrix(system.cosines[0])])
    assert by_hand == system.real_form
    result = fr.stability(by_hand)
    assert result.stable
    assert result.quasienergies == pytest.approx([-0.375247278169] * 2 + [0.375247278169] * 2, abs=1e-12)
    assert max(result.exponent_errors) < 1e-12


def test_one_ulp_off_keeps_no_norm() -> None:
    off = np.array([[-0.5j, 1.0], [np.nextafter(-1.0, 0.0), 0.5j]])
    assert fr.PeriodicSystem(off).structure == "general"
    off[1, 0] = -1.0
    assert fr.PeriodicSystem(off).structure == "unitary"
    assert fr.PeriodicSystem(off + 1e-300 * np.eye(2)).structure == "general"


# --- the same questions as of real systems ---------------------------------------------------------------------------


def test_real_and_complex_matrices_are_one_algebra(rng: np.random.Generator) -> None:
    one, other = (rng.normal(size=(3, 3)) + 1j * rng.normal(size=(3, 3)) for _ in range(2))
    assert complex_matrix(real_matrix(one)) == pytest.approx(one, abs=0.0)
    assert complex_matrix(real_matrix(one) @ real_matrix(other)) == pytest.approx(one @ other)


def test_zero_imaginary_parts_make_a_real_system() -> None:
    given = np.array([[0.0, 1.0], [-1.0, 0.0]])
    assert fr.PeriodicSystem(given + 0j) == fr.PeriodicSystem(given)
    assert fr.PeriodicSystem(given + 0j).structure == "hamiltonian"


def test_solutions_and_modes() -> None:
    system = lossy(0.05)
    solution = fr.solve(system, [1.0, 1j], 20.0)
    right = solve_ivp(
        lambda t, x: system.coefficient(t) @ x,
        (0.0, 20.0),
        np.array([1.0, 1j]),
        method="DOP853",
        rtol=1e-12,
        atol=1e-12,
    )
    assert solution(20.0) == pytest.approx(right.y[:, -1], rel=1e-9)
    assert solution(3.0, 1) == pytest.approx(system.coefficient(3.0) @ solution(3.0), rel=1e-12)
    assert fr.solve(system, solution(20.0), (20.0, 0.0))(0.0) == pytest.approx([1.0, 1j], abs=1e-11)
    for mode, exponent in zip(fr.floquet_solutions(system), fr.stability(system).exponents, strict=True):
        assert mode.exponent == pytest.approx(exponent, abs=1e-11)
        assert mode(1.0) == pytest.approx(mode.periodic(1.0) * np.exp(exponent), abs=1e-11)
        assert mode(9.0, 1) == pytest.approx(system.coefficient(9.0) @ mode(9.0), abs=1e-11)
    pair = fr.solve(fr.PeriodicSystem([[0.0, 1.0], [-1.0, 0.0]]), [1.0, 1j], 2.0)
    assert pair(2.0) == pytest.approx([np.cos(2) + 1j * np.sin(2), -np.sin(2) + 1j * np.cos(2)], abs=1e-13)


def test_modes_of_a_unitary_system_are_orthonormal_at_all_times(rng: np.random.Generator) -> None:
    system = drawn(rng, unitary=True)
    modes = fr.floquet_solutions(system)
    for time in (0.0, 0.3 * system.period, 7.7 * system.period):
        states = np.array([mode(time) for mode in modes])
        assert states.conj() @ states.T == pytest.approx(np.eye(system.order), abs=1e-11)
    assert [-mode.exponent.imag for mode in modes] == pytest.approx(fr.stability(system).quasienergies, abs=1e-11)


def test_functions() -> None:
    turning = fr.PeriodicSystem.from_function(
        lambda t: -1j * (0.5 * SZ + 0.7 * (math.cos(1.3 * t) * SX + math.sin(1.3 * t) * SY)), 2.0 * math.pi / 1.3
    )
    assert turning.structure == "unitary"
    assert fr.stability(turning).quasienergies == pytest.approx([-0.0658910531638, 0.0658910531638], abs=1e-11)
    jumping = fr.PeriodicSystem.from_function(
        lambda t: -1j * (SZ if t % 3.0 < 1.0 else SX + 0.3 * SY), 3.0, jumps=[0.0, 1.0]
    )
    pieces = fr.PeriodicSystem.from_pieces([(1.0, -1j * SZ), (2.0, -1j * (SX + 0.3 * SY))])
    assert jumping.structure == pieces.structure == "unitary"
    energies = fr.stability(pieces).quasienergies
    assert fr.stability(jumping).quasienergies == pytest.approx(energies, abs=1e-11)


def test_proofs() -> None:
    assert "conjugate transpose" in fr.certify(atom(1.0, 0.5, 1.0)).statement
    assert fr.certify(lossy()).status == "stable"
    grows = fr.certify(lossy(0.01))
    assert grows.status == "unstable"
    assert grows.equation == lossy(0.01)
    expanding = fr.PeriodicSystem([[1e-3 + 2j, 5.0], [0.0, -1j]], coefficient_error=1e-6)
    assert fr.certify(expanding).status == "unstable"


def test_proofs_of_families() -> None:
    box = fr.certify(lambda d, a: atom(d, a, 2.0), d=(0.0, 1.0), a=(0.5, 2.0))
    assert box.status == "stable"
    partly = fr.certify(
        lambda turn: fr.PeriodicSystem([[-0.3 + turn * 1j, 0.1], [0, -0.2]], period=2.0), turn=(0.0, 1.0)
    )
    assert partly.status == "stable"


def test_files(tmp_path: Path) -> None:
    toml = tmp_path / "lossy.toml"
    toml.write_text(
        """[system]
mean = [["-0.1+1i", 0], [0, "-0.05 - 0.5i"]]
cosines = [[[0, 0.3], [0.2, 0]]]
sines = [[[0, "0.3i"], ["-2e-1j", 0]]]
frequency = 1.0
""",
        encoding="utf-8",
    )
    assert read_system(toml) == lossy()
    arrays = tmp_path / "lossy.npz"
    system = lossy()
    np.savez(arrays, mean=system.mean, cosines=np.array(system.cosines), sines=np.array(system.sines), period=2 * np.pi)
    assert read_system(arrays) == system
    toml.write_text(
        """[[system.pieces]]
duration = 1
mean = [["-i", 0], [0, "i"]]
[[system.pieces]]
duration = 2
matrix_start = [[0, "-i"], ["-i", 0]]
slope = [["0.1i", 0], [0, 0]]
""",
        encoding="utf-8",
    )
    assert read_system(toml).structure == "unitary"


@pytest.mark.parametrize("text", ["1+", "i1", "nan", "infi", "1+2i3", "--i", ""])
def test_texts_that_are_no_numbers(text: str, tmp_path: Path) -> None:
    toml = tmp_path / "system.toml"
    toml.write_text(f'[system]\nmean = [["{text}"]]\nperiod = 1.0\n', encoding="utf-8")
    with pytest.raises(ValueError, match=r"mean\[0\]\[0\] must be a number, or a text such as"):
        read_system(toml)


def test_reports() -> None:
    report = str(fr.stability(atom(1.0, 0.5, 1.0)).report())
    assert "2 complex equations of first order, unitary" in report
    assert "quasienergies -0.375247278169, 0.375247278169" in report
    verdict = fr.stability(lossy(0.01))
    assert verdict.resonances == ()
    first = verdict.exponents[0]
    line = f"none, since the system has losses or gain; its exponents, per unit time: {first.real:.6g} "
    assert line in " ".join(str(verdict.report()).split())
    decayed = fr.stability(fr.PeriodicSystem([[-0.1j - 0.2, 0.0], [0.0, 0.0]], period=1.0))
    words = " ".join(str(decayed.report()).split())
    assert re.search(r"per unit time: 0 within \de-\d+, -0\.2 - 0\.1i ", words)
    assert re.search(r"margin the largest multiplier lies on the unit circle within \de-\d+ ", words)
    assert "energies" not in str(fr.stability(fr.PeriodicSystem([[0.0, 1.0], [-1.0, -0.1]], period=1.0)).report())
    assert fr.stability(atom(1.0, 0.5, 1.0)).as_dict()["quasienergies"] == pytest.approx(
        [-0.375247278169, 0.375247278169]
    )


def test_plots() -> None:
    axes = lossy().plot()
    labels = {text.get_text() for text in axes.figure.findobj(lambda a: hasattr(a, "get_text"))}
    assert r"$\mathrm{Im}\,A_{12}$" in labels


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: fr.HillSystem([[1j]]), "stiffness must hold real numbers"),
        (lambda: fr.HillSystem.from_pieces([(1.0, [[1j]]), (2.0, [[3.0]])]), "stiffness must hold real numbers"),
        (lambda: fr.DelaySystem.first_order([[1j]], delayed=[(1.0, [[0.1]])]), "must be real in a system with delays"),
        (lambda: fr.second_moments(atom(1.0, 0.5, 1.0), [(np.eye(2), 0.1)]), "system must be real under noise"),
        (lambda: fr.PeriodicSystem([[complex(math.nan, 0.0)]]), "mean must be finite"),
        (lambda: fr.PeriodicSystem([[1j * 1e31]]), "mean must be finite and lie between"),
        (lambda: fr.solve(fr.Mathieu(alpha=1.0, beta=1.0), [1j, 2.0], 3.0), "initial must hold real numbers"),
        (lambda: lossy().harmonics, "take its real_form"),
    ],
)
def test_what_is_refused(call: Any, message: str) -> None:
    with pytest.raises((TypeError, ValueError), match=message):
        call()


@pytest.mark.slow
@pytest.mark.parametrize("detuning", [1e-3, 1e-8, 1e-11, 1e-13, 0.0])
def test_nearly_equal_quasienergies_leave_orthogonal_solutions(detuning: float) -> None:
    """Two equal spins in one field: an eigensolver of general matrices returns modes that are not orthogonal."""
    half_z, half_x, one = np.diag([0.5, -0.5]), np.array([[0.0, 0.5], [0.5, 0.0]]), np.eye(2)
    energy = np.kron(half_z, one) + (1.0 + detuning) * np.kron(one, half_z)
    field = 0.7 * (np.kron(half_x, one) + np.kron(one, half_x))
    solutions = fr.floquet_solutions(fr.PeriodicSystem(-1j * energy, [-1j * field], period=2.0 * math.pi / 1.3))
    states = np.array([solution([0.0, 1.0, 5.0]) for solution in solutions])
    assert len(solutions) == 4
    assert np.abs(np.einsum("itk,jtk->tij", states.conj(), states) - np.eye(4)).max() < 1e-13
    unsure = 0.0 < detuning < 1e-10  # quasienergies that differ, by so little that their solutions may be mixed
    assert (max(solution.error for solution in solutions) > 1e-4) == unsure
