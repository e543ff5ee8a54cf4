"""A system that jumps, everywhere: coefficients in pieces against products of matrix exponentials in many digits."""

from __future__ import annotations

import dataclasses
import functools
import json
import math
import pickle
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import floquetrod as fr
from floquetrod.cli import main
from floquetrod.equations import Piece, Varying
from floquetrod.equations.base import Alternating
from floquetrod.equations.batches import pick
from floquetrod.equations.pieces import exact_period, in_time
from floquetrod.equations.system_files import read_system
from floquetrod.floquet import dispatch, registry
from floquetrod.systems import batch_verdicts
from tests.conftest import depth

STIFF = [[1.5, 0.5], [0.5, 4.5]]
SOFT = [[0.5, -0.5], [-0.5, 3.5]]
MASS = [[2.0, 0.5], [0.5, 1.0]]
SQUARE = fr.HillSystem.from_pieces([(1.0, STIFF), (2.0, SOFT)])
"""Two coupled equations of Meissner."""

MADE = {
    "square": SQUARE,
    "heavy": fr.HillSystem.from_pieces([(1.0, STIFF), (0.25, SOFT), (1.0, STIFF)], mass=MASS),
    "uniformly damped": fr.HillSystem.from_pieces([(1.0, STIFF), (2.0, SOFT)], damping=0.1 * np.eye(2)),
    "damped": fr.HillSystem.from_pieces([(1.0, STIFF), (2.0, SOFT)], damping=np.diag([0.1, 0.3]), mass=MASS),
    "follower": fr.HillSystem.from_pieces([(1.0, [[1.5, 0.5], [0.25, 4.5]]), (2.0, SOFT)], mass=MASS),
    "gyroscopic": fr.HillSystem.from_pieces([(1.0, STIFF), (2.0, SOFT)], gyroscopic=[[0.0, 0.5], [-0.5, 0.0]]),
    "ramps": fr.HillSystem.from_pieces(
        [
            (1.0, Varying(start=STIFF, slope=SOFT)),
            (0.5, Varying(start=SOFT, slope=[[-1.0, 0.0], [0.0, 0.5]])),
            (0.25, STIFF),
        ]
    ),
    "waves": fr.HillSystem.from_pieces(
        [
            (Fraction(1, 3), Varying(STIFF, cosines=[SOFT], sines=[STIFF, SOFT])),
            (1.5, Varying(None, SOFT, [STIFF], start=SOFT)),
        ],
        damping=np.diag([0.2, 0.1]),
    ),
    "first order": fr.PeriodicSystem.from_pieces(
        [
            (0.5, [[0.0, 1.0, 0.0], [-1.0, -0.5, 0.5], [0.0, 0.25, -0.5]]),
            (1.0, Varying(start=np.eye(3), slope=-np.eye(3))),
        ]
    ),
}
NAMES = {"HillSystem": fr.HillSystem, "PeriodicSystem": fr.PeriodicSystem, "Varying": Varying, "Fraction": Fraction}


@functools.cache
def true_map(system: fr.HillSystem | fr.PeriodicSystem) -> mpmath.matrix:
    """Return the map of (q, q'), or x, over a period, to 30 digits: exponentials of constant pieces, Taylor of others.

    From the definition of the coefficients alone.
    """
    with mpmath.workdps(40):
        total = None
        for piece in in_time(system):
            length = exactly(piece.length)
            if piece.is_constant:
                one = mpmath.expm(of_first_order(system, piece.mean, mean=True) * length, method="taylor")
            else:
                one = by_taylor(system, piece, length)
            total = one if total is None else one * total
        return total


def exactly(value: Fraction) -> Any:
    return mpmath.mpf(value.numerator) / value.denominator


def of_first_order(system: Any, values: Any, *, mean: bool = False) -> mpmath.matrix:
    """Return a matrix of the coefficient as one of the first-order system of (q, q'), or as it is."""
    given_ = mpmath.matrix(np.asarray(values).tolist())
    if isinstance(system, fr.PeriodicSystem):
        return given_
    n = system.order
    inverse = mpmath.inverse(mpmath.matrix((np.eye(n) if system.mass is None else system.mass).tolist()))
    found = mpmath.zeros(2 * n)
    found[n:, :n] = -inverse * given_
    if mean:
        found[:n, n:] = mpmath.eye(n)
        for matrix in (system.damping, system.gyroscopic):
            if matrix is not None:
                found[n:, n:] = found[n:, n:] - inverse * mpmath.matrix(matrix.tolist())
    return found


def by_taylor(system: Any, piece: Any, length: Any, steps: int = 6, order: int = 36) -> mpmath.matrix:
    """Return the map over a piece by Taylor series over steps."""

    def array(values: Any, *, mean: bool = False) -> np.ndarray:
        return np.array(of_first_order(system, values, mean=mean).tolist(), dtype=object)

    w = 2 * mpmath.pi / exactly(exact_period(system))
    begin, h = exactly(piece.begin), length / steps
    mean, slope = array(piece.mean, mean=True), array(0.0 * piece.mean if piece.slope is None else piece.slope)
    waves = [(array(z.real), array(z.imag)) for z in piece.harmonics]
    total = np.array(mpmath.eye(len(mean)).tolist(), dtype=object)
    for step in range(steps):
        coefficients = [mean + slope * (step * h), slope, *(0 * mean for _ in range(order))]
        for m in range(len(coefficients)):
            for k, (real, imaginary) in enumerate(waves, start=1):
                turned, factor = k * w * (begin + step * h) + m * mpmath.pi / 2, (k * w) ** m / mpmath.factorial(m)
                coefficients[m] = coefficients[m] + factor * (
                    real * mpmath.cos(turned) - imaginary * mpmath.sin(turned)
                )
        last = order if waves else 1
        terms = [total]
        for m in range(order):
            terms.append(sum(coefficients[i] @ terms[m - i] for i in range(min(last, m) + 1)) / mpmath.mpf(m + 1))
        total = sum(term * h**m for m, term in enumerate(terms))
    return mpmath.matrix(total.tolist())


def true_multipliers(system: Any) -> list[complex]:
    """Return the multipliers of the map in many digits."""
    matrix = true_map(system)
    with mpmath.workdps(40):
        if len(matrix) == 1:
            return [complex(matrix[0, 0])]
        return [complex(mu) for mu in mpmath.eig(matrix, left=False, right=False)]


def farthest(found: Any, truth: Any) -> float:
    """Return the largest distance between multipliers, each matched with one."""
    left, worst = list(truth), 0.0
    for mu in found:
        nearest = min(left, key=lambda other: abs(other - mu))
        left.remove(nearest)
        worst = max(worst, abs(nearest - mu))
    return worst


def methods_of(system: Any) -> list[str]:
    """Return the methods that apply."""
    return [result.method for result in fr.compare(system).results]


# --- every method, comparison and proof -------------------------------------------------------------------------------

LONG = ("waves", "ramps", "heavy", "uniformly damped")
"""Systems that take longest, and those of which another has as much."""


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in MADE])
def test_every_method_finds_the_multipliers_of_the_product_of_exponentials(name: str) -> None:
    system, compared = MADE[name], fr.compare(MADE[name])
    truth = true_multipliers(system)
    size = max(map(abs, truth))
    assert compared.agree
    assert {result.status for result in compared.results} <= {"stable", "unstable"}
    for result in compared.results:
        accuracy = registry.service(system, result.method).accuracy
        assert farthest(result.multipliers, truth) <= max(1e-13, accuracy) * size
        assert farthest(result.multipliers, truth) <= size * result.error + 1e-15


def test_the_methods_that_apply() -> None:
    names = [method.name for method in registry.methods_for("systems")]
    assert methods_of(SQUARE) == methods_of(MADE["heavy"]) == [name for name in names if name != "spectral"]
    assert methods_of(MADE["damped"]) == [name for name in names if name not in ("spectral", "half_period")]
    assert fr.stability(SQUARE).method == "half_period"
    with pytest.raises(TypeError, match="must be one finite Fourier series"):
        fr.stability(SQUARE, "spectral")
    with pytest.raises(ValueError, match="even about an instant"):
        fr.stability(MADE["ramps"], "half_period")


def test_two_pieces_against_the_exponentials_of_scipy() -> None:
    def flow(stiffness: Any) -> np.ndarray:
        return np.block([[np.zeros((2, 2)), np.eye(2)], [-np.array(stiffness), np.zeros((2, 2))]])

    truth = np.linalg.eigvals(expm(2.0 * flow(SOFT)) @ expm(flow(STIFF)))
    assert farthest(fr.stability(SQUARE).multipliers, truth) < 1e-13


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name == "waves")) for name in MADE])
def test_certified(name: str) -> None:
    system = MADE[name]
    proof = fr.certify(system)
    assert proof.status == fr.stability(system).status
    assert proof.digits == 15
    if "abs(multiplier)^2 - 1" in (quantities := {e.quantity: e for e in proof.enclosures}):
        enclosed = quantities["abs(multiplier)^2 - 1"]
        largest = max(map(abs, true_multipliers(system))) ** 2 - 1.0
        assert enclosed.low - 1e-12 <= largest <= enclosed.high + 1e-12


@pytest.mark.parametrize("name", ["square", "ramps", pytest.param("waves", marks=pytest.mark.slow), "first order"])
def test_enclosed_maps_hold_the_true_one(name: str) -> None:
    """The trace does not depend on the coordinates that a proof chooses."""
    from tests.inside import Doubles, Integers, monodromy, system_problem

    system = MADE[name]
    with mpmath.workdps(40):
        matrix = true_map(system)
        truth = float(sum(matrix[i, i] for i in range(len(matrix))))
    problem = system_problem(system)
    for arithmetic, width in ((Doubles(), 1e-10), (Integers(30), 1e-13)):
        found = monodromy(arithmetic, problem.flow(arithmetic))
        centre, radius = found.centre().trace(), found.offset().trace()
        assert abs(centre - truth) <= radius + 1e-15 < width


def test_a_wrong_piece_would_be_noticed() -> None:
    other = fr.HillSystem.from_pieces([(1.0, STIFF), (np.nextafter(2.0, 3.0), SOFT)])
    near = fr.stability(other, "reference").multipliers
    assert 1e-17 < farthest(near, fr.stability(SQUARE, "reference").multipliers) < 1e-14


# --- one row: the scalar equations ------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True)
class Steps(Alternating):
    """beta + alpha (1, -1, 1/3), each for a third of the period."""

    def pieces(self) -> tuple[Piece, ...]:
        """Return the three parts."""
        a, b = Fraction(self.alpha), Fraction(self.beta)
        return tuple(Piece(Fraction(1, 3), b + a * share) for share in (1, -1, Fraction(1, 3)))


@dataclasses.dataclass(frozen=True)
class Ramped(Alternating):
    """A ramp, a wave and a constant."""

    def pieces(self) -> tuple[Piece, ...]:
        """Return the three parts."""
        return (
            Piece(Fraction(1, 4), start=self.beta, slope=0.25 * self.alpha),
            Piece(Fraction(1, 2), self.beta, (complex(self.alpha, 0.2 * self.alpha),)),
            Piece(Fraction(1, 4), self.beta - self.alpha),
        )


@pytest.mark.slow
@given(
    kind=st.sampled_from([fr.Meissner, Steps, Ramped]),
    alpha=st.floats(-1.5, 1.5, allow_subnormal=False),
    beta=st.floats(-2.0, 0.5, allow_subnormal=False),
    damping=st.sampled_from([0.0, 0.05]),
)
@settings(max_examples=depth(200, 12))
def test_a_scalar_equation_and_its_system_agree(kind: Any, alpha: float, beta: float, damping: float) -> None:
    equation = kind(alpha, beta, damping)
    scalar, system = fr.stability(equation), fr.stability(equation.as_system())
    if "undecided" not in (scalar.status, system.status):
        assert scalar.status == system.status
    allowed = 1e-11 + scalar.error + system.error / (2.0 * math.pi)
    if min(abs(scalar.growth_rate), abs(system.growth_rate)) > 1e-4:
        assert abs(scalar.growth_rate - system.growth_rate) <= allowed
    proof = fr.certify(equation.as_system(), max_digits=30)
    for verdict in (scalar, system):  # a proof may decide where a verdict does not
        assert {proof.status, verdict.status} != {"stable", "unstable"}
    assert system.status == "undecided" or proof.status in (system.status, "undecided")


def test_what_is_rounded_on_the_way_to_a_system_is_stated() -> None:
    assert fr.Meissner(0.5, -0.25).as_system().coefficient_error == 0.0
    equation = fr.Meissner(0.1, 1.0)
    system = equation.as_system()
    exact = [Fraction(piece.start) for piece in equation.pieces()]
    found = [Fraction(float(value.start[0, 0])) for _, value in system.pieces]
    off = max(abs(one + other) for one, other in zip(exact, found, strict=True))
    assert 0 < off <= Fraction(system.coefficient_error) < 2 * off


# --- solutions --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name == "waves")) for name in MADE])
def test_solve_follows_from_jump_to_jump(name: str) -> None:
    system = MADE[name]
    second = isinstance(system, fr.HillSystem)
    count = 2 * system.order if second else system.order
    initial = np.linspace(1.0, -0.5, count)
    solution = fr.solve(system, initial.reshape(2, -1) if second else initial, system.period)
    truth = np.array((true_map(system) * mpmath.matrix(initial.tolist())).tolist(), dtype=float).ravel()
    size = np.abs(solution.states).max()
    assert np.abs(solution.states[-1] - truth).max() <= size * (solution.error + 1e-14)
    breaks = np.cumsum([float(piece.length) for piece in in_time(system)])
    assert all(np.abs(solution.time - instant).min() < 1e-14 for instant in breaks)


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in MADE])
def test_floquet_solutions_gain_their_multiplier_in_a_period(name: str) -> None:
    system = MADE[name]
    found = fr.floquet_solutions(system)
    assert len(found) == len(true_map(system))
    for mode in found:
        before, after = (np.asarray(mode(t)) for t in (0.3, 0.3 + float(system.period)))
        assert np.allclose(after, np.exp(mode.exponent * mode.period) * before, rtol=0.0, atol=1e-11)
    assert farthest([np.exp(mode.exponent * mode.period) for mode in found], true_multipliers(system)) < 1e-11


def test_the_damping_that_stabilises() -> None:
    rate = fr.stability(SQUARE).damping_to_stabilise
    for factor, status in ((0.999, "unstable"), (1.001, "stable")):
        damped = dataclasses.replace(SQUARE, damping=2.0 * factor * rate * np.eye(2))
        assert fr.stability(damped).status == status


@pytest.mark.slow
def test_errors_of_coefficients_decide_nothing() -> None:
    """A verdict holds for all coefficients within their error, whatever finds it."""
    for system in (SQUARE, MADE["damped"], fr.HillSystem(STIFF, cosines=[SOFT], period=2.9)):
        rough = dataclasses.replace(system, coefficient_error=0.3)
        assert {result.status for result in fr.compare(rough).results} == {"undecided"}
        assert fr.certify(rough).status == "undecided"
        slightly = dataclasses.replace(system, coefficient_error=1e-8)
        exact = fr.stability(system)
        for result in fr.compare(slightly).results:
            assert result.status == exact.status
            assert 1e-9 < result.error < 1e-4
        assert fr.certify(slightly).status == exact.status


# --- values -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MADE)
def test_copies_and_the_repr(name: str) -> None:
    system = MADE[name]
    twin = pickle.loads(pickle.dumps(system))
    assert twin == system
    assert hash(twin) == hash(system)
    assert not any(matrix.flags.writeable for matrix in twin.every_matrix)
    assert repr(twin) == repr(system)
    assert eval(repr(system), NAMES) == system or "array>" in repr(system)
    assert dataclasses.replace(system, coefficient_error=1e-9) != system
    assert dataclasses.replace(dataclasses.replace(system, coefficient_error=1e-9), coefficient_error=0.0) == system
    shorter = [(duration, value.start) for duration, value in system.pieces][:-1]
    assert type(system).from_pieces(shorter) != system


def test_a_system_in_pieces_is_not_taken_for_a_smooth_one() -> None:
    with pytest.raises(ValueError, match="pieces must be those of which stiffness and period are the mean and the sum"):
        dataclasses.replace(SQUARE, stiffness=STIFF)
    with pytest.raises(TypeError, match="must be one finite Fourier series, got one of 2 pieces"):
        SQUARE.harmonics  # noqa: B018
    assert not SQUARE.is_smooth
    assert fr.HillSystem.from_pieces([(2.0, Varying(STIFF, cosines=[SOFT]))]) == fr.HillSystem(
        STIFF, cosines=[SOFT], period=2.0
    )


@pytest.mark.parametrize("name", MADE)
def test_the_coefficient_and_its_mean(name: str) -> None:
    system = MADE[name]
    nodes, weights = np.polynomial.legendre.leggauss(30)
    mean = 0.0
    for piece in in_time(system):
        times = float(piece.begin) + 0.5 * float(piece.length) * (1.0 + nodes)
        mean = mean + np.tensordot(weights, system.coefficient(times), 1) * 0.5 * float(piece.length)
    assert np.allclose(mean / system.period, getattr(system, system.MEAN), rtol=0.0, atol=1e-14)
    assert np.allclose(system.coefficient([0.125 + system.period]), system.coefficient([0.125]), atol=1e-13)
    assert SQUARE.coefficient(1.0).tolist() == [[1.0, 0.0], [0.0, 4.0]]  # the mean of both sides


@pytest.mark.parametrize(
    ("pieces", "message"),
    [
        ([], "one at least, got none"),
        (3.0, "must be a sequence of"),
        ([STIFF], r"pieces\[0\]\[1\] must be a square matrix"),
        ([(1.0, STIFF, SOFT)], "must be a sequence of"),
        ([(0.0, STIFF)], r"pieces\[0\]\[0\] must be greater than zero"),
        ([(1.0, STIFF), (-1.0, SOFT)], r"pieces\[1\]\[0\] must be greater than zero"),
        ([(1.0, STIFF), (math.nan, SOFT)], r"pieces\[1\]\[0\] must be finite"),
        ([(1.0, STIFF), (1.0, [[1.0]])], r"pieces\[1\]\[1\] must be 2 x 2 as pieces\[0\]\[1\] is"),
        ([(1.0, [1.0, 2.0])], r"pieces\[0\]\[1\] must be a square matrix"),
        ([("soon", STIFF)], r"pieces\[0\]\[0\] must be a real number"),
    ],
)
def test_what_is_no_piece_is_refused(pieces: Any, message: str) -> None:
    for kind in (fr.HillSystem, fr.PeriodicSystem):
        with pytest.raises((TypeError, ValueError), match=message):
            kind.from_pieces(pieces)


# --- batches and charts -----------------------------------------------------------------------------------------------


def test_a_batch_answers_as_each_of_its_systems() -> None:
    frequency = np.linspace(0.7, 4.0, 23)
    singles = [
        fr.HillSystem.from_pieces([(math.pi / w, STIFF), (math.pi / w, Varying(start=SOFT, slope=0.1 * np.eye(2)))])
        for w in frequency
    ]
    batch = fr.HillSystem.from_pieces(
        [(math.pi / frequency, STIFF), (math.pi / frequency, Varying(start=SOFT, slope=0.1 * np.eye(2)))]
    )
    assert batch == fr.systems.stack(singles)
    assert batch.shape == (23,)
    assert pick(batch, 4) == singles[4]
    stable = fr.systems.is_stable(batch)
    one_by_one = [fr.stability(system) for system in singles]
    assert stable.tolist() == [result.stable for result in one_by_one]
    assert 2 < stable.sum() < 21
    assert np.allclose(fr.systems.growth_rate(batch), [result.growth_rate for result in one_by_one], atol=1e-12)
    assert fr.systems.multipliers(batch).shape == (23, 4)
    assert (batch_verdicts.verdicts(batch, quick=True).status != -1).mean() > 0.8
    with pytest.raises(ValueError, match="must have as many pieces as the first, 2, got 3"):
        fr.systems.stack([SQUARE, MADE["heavy"]])


def test_a_batch_of_one_and_the_same_system_is_a_batch() -> None:
    batch = fr.systems.stack([SQUARE] * 3)
    assert batch.shape == (3,)
    assert fr.systems.is_stable(batch).tolist() == [fr.systems.is_stable(SQUARE)] * 3
    chart = fr.chart(lambda a, b: SQUARE, {"a": (0.0, 1.0, 3), "b": (0.0, 1.0, 2)})
    assert chart.stable.shape == (2, 3)


def test_a_batch_with_uniform_damping_and_pieces_that_all_share() -> None:
    steep = np.array([STIFF, 2.0 * np.array(STIFF)])
    batch = fr.HillSystem.from_pieces([(1.0, steep), (0.7, SOFT)], damping=0.2 * np.eye(2))
    assert fr.systems.is_stable(batch).tolist() == [fr.stability(pick(batch, i)).stable for i in (0, 1)]


@pytest.mark.slow
def test_charts_with_bands() -> None:
    def family(omega: float, epsilon: float) -> fr.HillSystem:
        force = epsilon * np.array([[0.5, 1.0], [1.0, 0.8]])
        half = math.pi / omega
        return fr.HillSystem.from_pieces([(half, np.diag([1.0, 4.0]) + force), (half, np.diag([1.0, 4.0]) - force)])

    chart = fr.chart(family, {"omega": (2.5, 3.5, 9), "epsilon": (0.05, 0.5, 7)})
    stable = np.array([[bool(fr.stability(family(w, e)).stable) for w in chart.x.values] for e in chart.y.values])
    assert (chart.stable == stable).all()
    assert 5 < stable.sum() < 58
    bands = list(chart.bands)
    assert bands
    for band in bands:
        assert abs(fr.stability(family(*band.place)).growth_rate - band.largest_growth) < 1e-6
        inner = (band.x > 2.5) & (band.x < 3.5) & (band.y > 0.05) & (band.y < 0.5)
        for w, e in list(zip(band.x[inner], band.y[inner], strict=True))[::5]:
            assert fr.stability(family(w, e)).growth_rate < 0.02 * band.largest_growth


# --- functions --------------------------------------------------------------------------------------------------------


def bent(t: float) -> list[list[float]]:
    """Return a stiffness that jumps at 0 and at 0.7 of a period of 2."""
    t = t % 2.0
    if t < 0.7:
        return [[1.5 + math.exp(t), 0.3], [0.3, 4.0]]
    return [[1.5 - 0.1 * t**3, 0.1 * t], [0.1 * t, 3.0 + math.sin(5.0 * t)]]


@pytest.mark.slow
def test_a_function_with_jumps_through_every_method(rng: np.random.Generator) -> None:
    system = fr.HillSystem.from_function(bent, 2.0, jumps=[0.7, 0.0], mass=MASS)
    assert system.structure == "hamiltonian"
    assert system.period == 2.0
    t = rng.uniform(0.0, 2.0, 300)
    distance = np.abs(system.coefficient(t) - np.array([bent(float(instant)) for instant in t])).max()
    assert 0.0 < distance <= system.coefficient_error < 1e-12
    inverse, state = np.linalg.inv(MASS), np.eye(4)
    for begin, end in ((0.0, 0.7), (0.7, 2.0)):

        def slope(t: float, x: np.ndarray, begin: float = begin, end: float = end) -> np.ndarray:
            force = inverse @ np.array(bent(min(max(t, begin), math.nextafter(end, 0.0))))
            return (np.block([[np.zeros((2, 2)), np.eye(2)], [-force, np.zeros((2, 2))]]) @ x.reshape(4, 4)).ravel()

        found = solve_ivp(slope, (begin, end), state.ravel(), method="DOP853", rtol=1e-13, atol=1e-14)
        state = found.y[:, -1].reshape(4, 4)
    compared = fr.compare(system)
    assert compared.agree
    for result in compared.results:
        assert farthest(result.multipliers, np.linalg.eigvals(state)) < 1e-11
    assert fr.certify(system).status == compared.results[0].status == "stable"


def test_functions_with_constant_pieces_are_found_exactly() -> None:
    def square(t: float) -> list[list[float]]:
        return STIFF if t % 3.0 < 1.0 else SOFT

    assert fr.HillSystem.from_function(square, 3.0, jumps=[1.0, 0.0]).coefficient(0.5).tolist() == STIFF
    found = fr.HillSystem.from_function(square, 3.0, jumps=[1.0])
    assert {repr(value.start.tolist()) for _, value in found.pieces} == {repr(STIFF), repr(SOFT)}
    assert found.coefficient_error == 0.0
    assert abs(fr.stability(found).growth_rate - fr.stability(SQUARE).growth_rate) < 1e-12


def test_jumps_that_are_not_named_are_refused() -> None:
    def square(t: float) -> list[list[float]]:
        return [[1.3 if t % 2.0 < 1.1 else 0.7]]

    with pytest.raises(ValueError, match=r"not smooth near t = 1\.(09|10)\d*, which is not among its jumps"):
        fr.HillSystem.from_function(square, 2.0, jumps=[1.0])
    with pytest.raises(ValueError, match="name its jumps and kinks in jumps"):
        fr.PeriodicSystem.from_function(square, 2.0)
    with pytest.raises(ValueError, match=r"jumps\[0\] must lie within a period"):
        fr.HillSystem.from_function(square, 2.0, jumps=[2.0])
    with pytest.raises(ValueError, match="not periodic"):
        fr.HillSystem.from_function(lambda t: [[t]], 2.0, jumps=[0.0])


@given(st.integers(0, 5), st.floats(0.1, 9.0), st.floats(0.1, 20.0))
@settings(max_examples=depth(300, 8), deadline=None)
def test_a_periodic_function_that_jumps_is_not_said_to_be_aperiodic(shift: int, size: float, period: float) -> None:
    """Rounding decides between the sides of a jump, also where values a period apart are compared."""
    share = (0.0, 0.37, 0.71, 0.25, 0.5, 0.9)[shift]

    def square(t: float) -> float:
        return size * float(np.sign(np.sin(2.0 * math.pi * (t / period - share))))

    with pytest.raises(ValueError, match=r"(jumps at t = .*; name all its jumps|name its jumps and kinks) .*jumps"):
        fr.Hill.from_function(square, period)
    inner = sorted((share + half) % 1.0 * period for half in (0.0, 0.5))
    found = fr.Hill.from_function(square, period, jumps=inner)
    assert sorted({abs(float(piece.start)) for piece in found.pieces()}) == pytest.approx([size])
    with pytest.raises(ValueError, match="not periodic"):
        fr.Hill.from_function(lambda t: square(t) + 1e-3 * size * math.sin(t / period), period, jumps=inner)


def test_a_scalar_function() -> None:
    def coefficient(tau: float) -> float:
        return -1.0 - 0.3 * math.exp(math.cos(tau))

    found = fr.Hill.from_function(coefficient, 2.0 * math.pi, damping=0.01)
    tau = np.linspace(0.0, 6.0, 50)
    assert np.abs(found.coefficient(tau) - [coefficient(t) for t in tau]).max() < 1e-12
    system = fr.HillSystem.from_function(lambda t: [[-coefficient(t)]], 2.0 * math.pi, damping=[[0.02]])
    assert abs(fr.stability(found).growth_rate - fr.stability(system).growth_rate) < 1e-11
    with pytest.raises(
        ValueError, match=r"agrees with it to 1e-12 of its size, got one to .*HillSystem\.from_function"
    ):
        fr.Hill.from_function(lambda tau: abs(math.sin(tau)) ** 3, math.pi)


def test_a_scalar_function_that_jumps() -> None:
    def coefficient(tau: float) -> float:
        tau %= 3.0
        return -2.0 - 0.3 * math.exp(tau) if tau < 1.1 else -0.5 + 0.1 * tau

    found = fr.Hill.from_function(coefficient, 3.0, 0.01, jumps=[0.0, 1.1])
    assert sum(piece.share for piece in found.pieces()) == 1
    tau = np.linspace(0.01, 2.99, 50)
    assert np.abs(found.coefficient(tau) - [coefficient(t) for t in tau]).max() < 1e-12
    system = fr.HillSystem.from_function(lambda t: [[-coefficient(t)]], 3.0, jumps=[0.0, 1.1], damping=[[0.02]])
    one, other = fr.stability(found), fr.stability(system)
    assert (one.status, fr.certify(found).status) == (other.status, other.status)
    assert abs(max(map(abs, one.multipliers)) - max(map(abs, other.multipliers))) < 1e-12
    assert fr.compare(found).agree
    assert pickle.loads(pickle.dumps(found)) == found
    wave = fr.Hill.from_function(lambda t: -2.0 if t % 2.0 < 1.0 else -0.5, 2.0, jumps=[0.0, 1.0])
    x, y = (math.sqrt(p) for p in (2.0, 0.5))
    trace = 2.0 * math.cos(x) * math.cos(y) - (x / y + y / x) * math.sin(x) * math.sin(y)
    assert fr.stability(wave).discriminant == pytest.approx(trace, abs=1e-14)
    with pytest.raises(ValueError, match="not smooth near"):
        fr.Hill.from_function(lambda t: -2.0 if t % 2.0 < 1.1 else -0.5, 2.0, jumps=[0.0, 1.0])


# --- files and the terminal -------------------------------------------------------------------------------------------

FILE = """
[system]
mass = [[2.0, 0.5], [0.5, 1.0]]

[[system.pieces]]
duration = "500ms"
stiffness = [[1.5, 0.5], [0.5, 4.5]]

[[system.pieces]]
duration = 2.0
stiffness_start = [[0.5, -0.5], [-0.5, 3.5]]
slope = [[0.1, 0.0], [0.0, 0.2]]
cosines = [[[0.1, 0.0], [0.0, 0.2]]]
"""


def test_a_file_with_pieces(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "square.toml"
    path.write_text(FILE)
    varying = Varying(None, np.diag([0.1, 0.2]), [np.diag([0.1, 0.2])], start=SOFT)
    system = fr.HillSystem.from_pieces([(0.5, STIFF), (2.0, varying)], mass=MASS)
    assert read_system(path) == system
    expected = fr.stability(system)
    assert main(["check", "--system", str(path), "--json"]) == (0 if expected.stable else 1)
    said = json.loads(capsys.readouterr().out)
    assert (said["status"], said["pieces"], said["period"]) == (expected.status, 2, 2.5)
    main(["certify", "--system", str(path)])
    assert f"PROVED {expected.status.upper()}" in capsys.readouterr().out


def test_an_npz_file_with_pieces(tmp_path: Path) -> None:
    path = tmp_path / "square.npz"
    matrices = np.array([STIFF, SOFT])
    slope = np.array([np.zeros((2, 2)), np.diag([0.1, 0.2])])
    cosines = slope[:, None]
    np.savez(path, durations=[0.5, 2.0], stiffness_start=matrices, slope=slope, cosines=cosines, mass=MASS)
    pieces = [
        (t, Varying(None, ramp, waves, start=start))
        for t, start, ramp, waves in zip([0.5, 2.0], matrices, slope, cosines, strict=True)
    ]
    assert read_system(path) == fr.HillSystem.from_pieces(pieces, mass=MASS)
    np.savez(path, durations=[0.5, 2.0], mean=matrices)
    assert read_system(path) == fr.PeriodicSystem.from_pieces([(0.5, STIFF), (2.0, SOFT)])
    np.savez(path, durations=[0.5, 2.0, 1.0], stiffness=matrices)
    with pytest.raises(ValueError, match="array 'stiffness' must have 3 pieces as durations has"):
        read_system(path)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (("duration = 2.0", ""), r"pieces\[1\]: it must have a duration and a stiffness"),
        (("duration = 2.0", "duration = 0.0"), r"pieces\[1\]: duration must be greater than zero"),
        (("slope =", "slop ="), r"pieces\[1\]: unknown key 'slop'"),
        (("[system]", "[system]\nperiod = 1.0"), "key 'period' belongs to the pieces"),
        (("stiffness = [[1.5", "mean = [[1.5"), "pieces with stiffness and pieces with mean"),
        (("[[0.5, -0.5], [-0.5, 3.5]]", "[[0.5]]"), r"pieces\[1\]: slope must be 1 x 1 as start is"),
        (
            ("stiffness_start = ", "stiffness = "),
            r"pieces\[1\]: stiffness beside a slope .* stiffness_start = stiffness -",
        ),
        (("stiffness_start = ", "stiffness = [[1.0]]\nstiffness_start = "), "it has stiffness and stiffness_start"),
        (("stiffness_start = ", "matrix_start = "), "pieces with stiffness and pieces with mean"),
    ],
)
def test_a_file_with_wrong_pieces(tmp_path: Path, changed: tuple[str, str], message: str) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(FILE.replace(*changed))
    with pytest.raises(ValueError, match=message):
        read_system(path)


# --- random pieces ----------------------------------------------------------------------------------------------------


def drawn(rng: np.random.Generator) -> fr.HillSystem | fr.PeriodicSystem:
    """Return a random system in constant pieces."""
    n, count = int(rng.integers(1, 4)), int(rng.integers(2, 5))
    durations = rng.uniform(0.1, 1.5, count)
    if rng.random() < 0.3:
        return fr.PeriodicSystem.from_pieces([(d, rng.normal(size=(n, n))) for d in durations])
    pieces = []
    for duration in durations:
        matrix = rng.normal(size=(n, n)) + 2.0 * np.eye(n)
        pieces.append((duration, 0.5 * (matrix + matrix.T) if rng.random() < 0.8 else matrix))
    if rng.random() < 0.4:
        pieces += pieces[::-1]
    others: dict[str, Any] = {}
    if rng.random() < 0.5:
        root = np.eye(n) + 0.2 * rng.normal(size=(n, n))
        others["mass"] = 0.5 * (root @ root.T + (root @ root.T).T)
    kind = rng.integers(0, 4)
    if kind == 1:
        others["damping"] = np.diag(rng.uniform(0.0, 0.4, n))
    elif kind == 2:
        others["damping"] = 0.25 * others.get("mass", np.eye(n))
    elif kind == 3:
        half = rng.normal(size=(n, n))
        others["gyroscopic"] = half - half.T
    return fr.HillSystem.from_pieces(pieces, **others)


@pytest.mark.slow
def test_stated_errors_cover_the_truth_of_random_pieces(rng: np.random.Generator) -> None:
    for _ in range(depth(50, 8)):
        system = drawn(rng)
        truth = true_multipliers(system)
        size = max(map(abs, truth))
        for name in (method.name for method in registry.applicable(system)):
            result = dispatch.run(name, system)
            if not result.exponents:
                continue
            assert farthest(result.multipliers, truth) <= size * min(1.0, result.error) + 1e-14 * size, (name, system)
            if result.status == "stable":
                assert size <= 1.0 + 1e-12, (name, system)
            if result.status == "unstable":
                assert size > 1.0, (name, system)


def cut(rng: np.random.Generator, period: float, count: int) -> list[float]:
    """Return durations, short binary numbers, that add up to a period."""
    edges = np.sort(rng.choice(np.arange(1, 64), count - 1, replace=False)) * (period / 64.0)
    return np.diff([0.0, *edges, period]).tolist()


@pytest.mark.slow
def test_a_series_cut_into_pieces_is_the_same_system(rng: np.random.Generator) -> None:
    """One path has the period as its piece, the other breaks anywhere: maps, many digits, proofs and solutions."""
    for _ in range(depth(20, 5)):
        n, period = int(rng.integers(1, 4)), float(rng.choice([1.5, 3.0, 6.0]))
        first = rng.random() < 0.4
        matrices = 0.5 * rng.normal(size=(5, n, n))
        if not first:
            matrices = matrices + matrices.swapaxes(1, 2) + np.eye(n) * np.array([1.5, 0, 0, 0, 0])[:, None, None]
        mean, series = matrices[0], (list(matrices[1:3]), list(matrices[3:]))
        pieces = [(d, Varying(mean, None, *series)) for d in cut(rng, period, int(rng.integers(2, 5)))]
        kind = fr.PeriodicSystem if first else fr.HillSystem
        whole, parts = kind(mean, *series, period=period), kind.from_pieces(pieces)
        assert np.allclose(parts.coefficient([0.1, 1.3]), whole.coefficient([0.1, 1.3]), rtol=0.0, atol=1e-14)
        for name in (method.name for method in registry.methods_for("systems") if method.systems.refusal is None):
            one, other = fr.stability(whole, name), fr.stability(parts, name)
            size = abs(one.multipliers[0])
            assert farthest(one.multipliers, other.multipliers) <= size * (one.error + other.error)
            accuracy = registry.service(whole, name).accuracy
            assert farthest(one.multipliers, other.multipliers) <= max(1e-12, accuracy) * size
        if "undecided" not in (one.status, (proof := fr.certify(parts)).status):
            assert proof.status == one.status
        state = np.ones(n) if first else np.ones((2, n))
        ends = [fr.solve(system, state, 2.5 * period).states[-1] for system in (whole, parts)]
        assert np.allclose(*ends, rtol=1e-12, atol=1e-12 * np.abs(ends[0]).max())


@pytest.mark.slow
def test_the_same_ramps_written_otherwise(rng: np.random.Generator) -> None:
    """Cut further, begun later in the period, and in another unit of time."""
    for _ in range(depth(60, 2)):
        n = int(rng.integers(1, 4))
        whole = []
        for _ in range(int(rng.integers(1, 4))):
            mean, slope = np.round(rng.normal(size=(2, n, n)) * 16.0) / 16.0
            mean, slope = mean + mean.T + 2.0 * np.eye(n), slope + slope.T
            whole.append((float(rng.integers(1, 9)) / 4.0, mean, slope))

        def made(pieces: list[Any]) -> fr.HillSystem:
            return fr.HillSystem.from_pieces([(d, Varying(start=mean, slope=slope)) for d, mean, slope in pieces])

        halves = [part for d, m, s in whole for part in ((d / 2.0, m, s), (d / 2.0, m + d / 2.0 * s, s))]
        one = fr.stability(made(whole), "reference")
        for other, scale in (
            (made(halves), 1.0),
            (made([*halves[1:], halves[0]]), 1.0),
            (made([(d / 4.0, 16.0 * m, 64.0 * s) for d, m, s in whole]), 4.0),
        ):
            for name in (method.name for method in registry.methods_for("systems") if method.systems.refusal is None):
                found = fr.stability(other, name)
                size = abs(one.multipliers[0])
                assert farthest(one.multipliers, found.multipliers) <= size * (found.error + 1e-15)
                if "undecided" not in (one.status, found.status):
                    assert found.status == one.status
                    assert abs(found.growth_rate / scale - one.growth_rate) <= found.error + 1e-14


@pytest.mark.parametrize("seed", [17, 21])  # where the residual of the map is less than the error
def test_floquet_solutions_begin_within_their_error(seed: int) -> None:
    """The start of each solution against the eigenvector of a product of exponentials in 40 digits."""
    rng = np.random.default_rng(seed)
    pieces = [(float(t), rng.normal(size=(2, 2))) for t in rng.uniform(0.2, 1.0, 2)]
    with mpmath.workdps(40):
        product = mpmath.eye(2)
        for duration, matrix in pieces:
            product = mpmath.expm(mpmath.matrix(matrix) * mpmath.mpf(duration)) * product
        values, vectors = mpmath.eig(product)
        for mode in fr.floquet_solutions(fr.PeriodicSystem.from_pieces(pieces)):
            i = min((0, 1), key=lambda k: abs(values[k] - mpmath.exp(mode.exponent * mpmath.mpf(mode.period))))
            start = mpmath.matrix([complex(x) for x in mode(0.0)])
            true = vectors[:, i] / mpmath.norm(vectors[:, i])
            off = mpmath.norm(start - (true.H * start)[0] * true)
            size = np.abs(mode(np.linspace(0.0, mode.period, 101))).max()
            assert off <= mode.error * size < 1e-13


@pytest.mark.slow
@pytest.mark.parametrize("name", MADE)
def test_the_matrix_of_a_verdict_is_the_map_within_its_error(name: str) -> None:
    truth, (matrix, error) = true_map(MADE[name]), fr.stability(MADE[name]).monodromy
    off = max(abs(entry) for entry in truth - mpmath.matrix(matrix.tolist()))
    assert off <= error < 1e-12 * max(1.0, np.abs(matrix).max())
