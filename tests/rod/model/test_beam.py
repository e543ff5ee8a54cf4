"""Beam functions of all ends: against roots of characteristic equations, end conditions, buckling and quadrature."""

from __future__ import annotations

import functools
import gc
import itertools
import math
import weakref
from collections.abc import Callable

import mpmath as mp
import numpy as np
import pytest
from numpy.polynomial import Chebyshev
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.linalg import eigh

from floquetrod.rod import EndConditions
from floquetrod.rod.model import beam

PAIRS = [EndConditions(*pair) for pair in itertools.product(beam.CONDITIONS, repeat=2)]
RIGID = {"free-free": 2, "free-hinged": 1, "free-guided": 1, "guided-guided": 1}
VANISHING = {"hinged": (0, 2), "clamped": (0, 1), "guided": (1, 3), "free": (2, 3)}
BUCKLING = {
    "hinged-hinged": math.pi**2,
    "clamped-clamped": 4.0 * math.pi**2,
    "clamped-hinged": 20.190728556426629,  # tan k = k
    "clamped-guided": math.pi**2,
    "clamped-free": 0.25 * math.pi**2,
    "guided-hinged": 0.25 * math.pi**2,
    "guided-guided": math.pi**2,
    "free-guided": 0.25 * math.pi**2,
}
"""Smallest buckling loads in EI/L^2 with the force along the channel, for ends in alphabetical order."""

CHARACTERISTIC: dict[str, Callable[[mp.mpf], mp.mpf]] = {
    "hinged-hinged": lambda k: mp.sin(k),
    "guided-guided": lambda k: mp.sin(k),
    "guided-hinged": lambda k: mp.cos(k),
    "clamped-clamped": lambda k: mp.cos(k) - mp.sech(k),
    "free-free": lambda k: mp.cos(k) - mp.sech(k),
    "clamped-free": lambda k: mp.cos(k) + mp.sech(k),
    "clamped-hinged": lambda k: mp.sin(k) - mp.cos(k) * mp.tanh(k),
    "free-hinged": lambda k: mp.sin(k) - mp.cos(k) * mp.tanh(k),
    "clamped-guided": lambda k: mp.sin(k) + mp.cos(k) * mp.tanh(k),
    "free-guided": lambda k: mp.sin(k) + mp.cos(k) * mp.tanh(k),
}
"""Zero at the wavenumbers of a beam, divided by what grows exponentially."""


def known_by(ends: EndConditions) -> str:
    """Return the two words in alphabetical order."""
    return "-".join(sorted((ends.upper, ends.lower)))


@functools.cache
def exact_wavenumbers(pair: str) -> tuple[mp.mpf, ...]:
    """Return the first wavenumbers, up to 50, to 40 digits."""
    equation = CHARACTERISTIC[pair]
    with mp.workdps(40):
        grid = [mp.mpf(i) / 10 + mp.mpf("0.53") for i in range(500)]
        signs = [equation(k) > 0 for k in grid]
        brackets = [(a, b) for a, b, one, other in zip(grid, grid[1:], signs, signs[1:], strict=False) if one != other]
        return tuple(mp.findroot(equation, bracket, solver="anderson", tol=1e-70) for bracket in brackets)


def exact_functions(ends: EndConditions, k: mp.mpf) -> list[mp.mpf]:
    """Return the coefficients of sin kx, cos kx, e^-kx, e^-k(1-x) of an eigenfunction, to 30 digits."""
    with mp.workdps(40):
        rows = mp.matrix(4, 4)
        conditions = [(at, d) for at, end in ((0, ends.upper), (1, ends.lower)) for d in VANISHING[end]]
        for i, (at, d) in enumerate(conditions):
            for j, value in enumerate(derivative(k, at, d)):
                rows[i, j] = value
        # All but singular: the solution lies along the null vector, but for 1e-30.
        found = mp.lu_solve(rows + mp.mpf("1e-30") * mp.eye(4), mp.matrix([1, 2, -1, 3]))
        return [value / mp.norm(found, mp.inf) for value in found]


def derivative(k: mp.mpf, x: mp.mpf, d: int) -> list[mp.mpf]:
    """Return the d-th derivatives of the four functions, over k^d."""
    return [
        mp.sin(k * x + d * mp.pi / 2),
        mp.cos(k * x + d * mp.pi / 2),
        (-1) ** d * mp.exp(-k * x),
        mp.exp(-k * (1 - x)),
    ]


def evaluated(ends: EndConditions, mode: int, x: np.ndarray, d: int = 0) -> np.ndarray:
    """Return the d-th derivative of the eigenfunction of an elastic mode, counted from 0, of any size."""
    k = exact_wavenumbers(known_by(ends))[mode]
    coefficients = exact_functions(ends, k)
    with mp.workdps(30):
        values = [mp.fdot(coefficients, derivative(k, mp.mpf(float(at)), d)) * k**d for at in x]
    return np.array(values, dtype=np.float64)


# --- single functions ---


@pytest.mark.slow
@pytest.mark.parametrize("ends", PAIRS, ids=str)
def test_wavenumbers_are_the_roots_of_the_characteristic_equation(ends: EndConditions) -> None:
    exact = np.array(exact_wavenumbers(known_by(ends)), dtype=np.float64)
    rigid = RIGID.get(known_by(ends), 0)
    found = beam.wavenumbers(ends, len(exact) + rigid)
    assert not found[:rigid].any()
    assert len(exact) > 14
    assert found[rigid:] == pytest.approx(exact, rel=1e-15, abs=0.0)
    for count in range(5):
        assert beam.wavenumbers(ends, count).tolist() == found[:count].tolist()


def test_first_frequencies_are_those_of_the_textbook() -> None:
    for word, value in {
        "clamped": 22.3733,
        "free": 22.3733,
        "clamped-hinged": 15.4182,
        "clamped-free": 3.5160,
        "clamped-guided": 5.5933,
    }.items():
        waves = beam.wavenumbers(EndConditions.of(word), 3)
        assert waves[waves > 0.0][0] ** 2 == pytest.approx(value, abs=5e-5)


@pytest.mark.slow
@pytest.mark.parametrize("ends", PAIRS, ids=str)
def test_functions_are_the_eigenfunctions(ends: EndConditions) -> None:
    x = np.linspace(0.0, 1.0, 41)
    rigid = RIGID.get(known_by(ends), 0)
    found = beam.basis(ends, 16 + rigid).shapes(x)
    for mode in (0, 1, 4, 11, 14):  # on both sides of where the ends no longer feel each other
        exact = evaluated(ends, mode, x)
        ours = found[rigid + mode]
        assert ours / np.linalg.norm(ours) == pytest.approx(
            math.copysign(1.0, exact @ ours) * exact / np.linalg.norm(exact), abs=1e-12
        )


@pytest.mark.parametrize("ends", PAIRS, ids=str)
def test_every_function_keeps_the_essential_conditions(ends: EndConditions) -> None:
    found = beam.basis(ends, 9)
    x = chebyshev_points(50)
    fitted = [Chebyshev.fit(x, row, 50, domain=[0.0, 1.0]) for row in found.shapes(x)]
    for at, end in ((0.0, ends.upper), (1.0, ends.lower)):
        for i, function in enumerate(fitted):
            for d in (d for d in VANISHING[end] if d < 2):
                varying = function.deriv(d)
                assert abs(varying(at)) < 1e-6 * max(1.0, abs(varying(np.linspace(0.0, 1.0, 50))).max()), (i, d)


def chebyshev_points(degree: int) -> np.ndarray:
    """Return degree + 1 points on 0 <= x <= 1."""
    return np.asarray(0.5 - 0.5 * np.cos(math.pi * np.arange(degree + 1) / degree))


# --- the basis ---


@pytest.mark.parametrize("count", [1, 2, 3, 12, *(pytest.param(n, marks=pytest.mark.slow) for n in (64, 70))])
@pytest.mark.parametrize("ends", PAIRS, ids=str)
def test_a_basis_is_orthonormal(ends: EndConditions, count: int) -> None:
    found = beam.basis(ends, count)
    gram = (found.values * found.weights) @ found.values.T
    assert gram == pytest.approx(np.eye(found.size), abs=1e-12)
    assert found.weights.sum() == pytest.approx(1.0, rel=1e-13)
    assert found.bending.tolist() == found.bending.T.tolist()
    assert np.linalg.eigvalsh(found.bending)[0] >= -1e-9 * found.bending.max()
    sines = {ends.upper, ends.lower} <= {"hinged", "guided"}
    assert (found.size == count) == sines
    assert count > 12 or sines or found.size >= count + 2


@pytest.mark.slow
@pytest.mark.parametrize("ends", PAIRS, ids=str)
def test_matrices_are_the_integrals_of_derivatives(ends: EndConditions) -> None:
    found = beam.basis(ends, 7)
    x = chebyshev_points(90)
    fitted = [Chebyshev.fit(x, row, 90, domain=[0.0, 1.0]) for row in found.shapes(x)]
    points, weights = np.polynomial.legendre.leggauss(120)
    points, weights = 0.5 + 0.5 * points, 0.5 * weights
    slopes, curvatures = (np.array([f.deriv(d)(points) for f in fitted]) for d in (1, 2))
    force = 1.0 + np.sin(5.0 * points) - points**2
    bending = (curvatures * weights) @ curvatures.T
    assert found.bending == pytest.approx(bending, abs=1e-6 * bending.max())
    coupling = (slopes * weights * force) @ slopes.T
    ours = found.coupling(1.0 + np.sin(5.0 * found.nodes) - found.nodes**2)
    assert ours == pytest.approx(coupling, abs=1e-7 * np.abs(coupling).max())
    assert ours.tolist() == ours.T.tolist()


@pytest.mark.slow
@pytest.mark.parametrize("word", ["hinged", "clamped", "guided-free", "clamped-hinged", "free"])
def test_coupling_is_that_of_quadrature(word: str) -> None:
    ends = EndConditions.of(word)
    rigid = RIGID.get(known_by(ends), 0)
    found = beam.basis(ends, 6 + rigid)
    coupling = found.coupling(np.exp(found.nodes) * np.cos(9.0 * found.nodes))
    signs = np.sign(found.shapes(np.array([0.3]))[:, 0])
    chosen = [0, 2, 3]
    coefficients = [exact_functions(ends, exact_wavenumbers(known_by(ends))[m]) for m in chosen]
    waves = [float(exact_wavenumbers(known_by(ends))[m]) for m in chosen]

    def function(i: int, x: float, d: int) -> float:
        k, (a, b, c, e) = waves[i], map(float, coefficients[i])
        turn = 0.5 * math.pi * d
        decay = (-1.0) ** d * c * math.exp(-k * x) + e * math.exp(k * (x - 1.0))
        return float(k**d * (a * math.sin(k * x + turn) + b * math.cos(k * x + turn) + decay))

    norms = [math.sqrt(quad(lambda x, i=i: function(i, x, 0) ** 2, 0.0, 1.0, epsabs=1e-13)[0]) for i in range(3)]
    for i, j in itertools.product(range(3), repeat=2):
        exact, _ = quad(
            lambda x, i=i, j=j: math.exp(x) * math.cos(9.0 * x) * function(i, x, 1) * function(j, x, 1),
            0.0,
            1.0,
            epsabs=1e-11,
            limit=200,
        )
        sign = math.prod(math.copysign(1.0, function(m, 0.3, 0)) * signs[rigid + chosen[m]] for m in (i, j))
        ours = coupling[rigid + chosen[i], rigid + chosen[j]]
        assert ours == pytest.approx(sign * exact / (norms[i] * norms[j]), rel=1e-9, abs=1e-9)


# --- how fast a series of them converges ---


def buckling_load(found: beam.Basis) -> float:
    """Return the smallest load in EI/L^2 at which something other than a rigid rotation buckles."""
    push = found.coupling(np.ones_like(found.nodes))
    values, vectors = np.linalg.eigh(push)
    kept = vectors[:, values > 1e-9 * values[-1]]  # without rigid shifts
    ratios = eigh(kept.T @ found.bending @ kept, kept.T @ push @ kept, eigvals_only=True)
    return float(ratios[0])


@pytest.mark.parametrize("pair", BUCKLING)
def test_buckling_loads_are_those_of_the_textbook(pair: str) -> None:
    for word in (pair, "-".join(reversed(pair.split("-")))):
        assert buckling_load(beam.basis(EndConditions.of(word), 10)) == pytest.approx(BUCKLING[pair], rel=1e-8)


@pytest.mark.parametrize("word", ["free", "hinged-free"])
def test_a_rod_that_may_turn_buckles_under_any_push(word: str) -> None:
    assert abs(buckling_load(beam.basis(EndConditions.of(word), 10))) < 1e-7


@pytest.mark.parametrize("word", ["clamped", "clamped-free", "clamped-hinged", "free-guided", "clamped-guided"])
def test_beam_functions_alone_converge_like_the_cube_of_their_number(
    word: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    ends = EndConditions.of(word)
    exact = BUCKLING[known_by(ends)]
    monkeypatch.setattr(beam, "are_enriched", lambda _: False)
    counts = np.array([12, 24, 48])
    errors = np.array([buckling_load(beam._basis(ends, n)) / exact - 1.0 for n in counts])
    assert (errors > 0.0).all()  # Ritz: from above
    assert (np.diff(np.log(errors)) / np.diff(np.log(counts)) < -2.7).all()
    monkeypatch.undo()
    enriched = buckling_load(beam.basis(ends, 12)) / exact - 1.0
    assert abs(enriched) < 1e-9
    assert abs(enriched) < 1e-4 * errors[0]


@pytest.mark.parametrize("word", ["clamped", "clamped-free", "clamped-hinged", "clamped-guided"])
def test_many_functions_converge_under_a_force_that_varies(word: str) -> None:
    """Beside so many, polynomials add nothing: functions next to the ends do."""

    def loads(count: int) -> NDArray[np.float64]:
        found = beam.basis(EndConditions.of(word), count)
        push = found.coupling(1.0 - 0.7 * found.nodes + 0.3 * np.sin(3.0 * found.nodes))
        return 1.0 / eigh(push, found.bending, eigvals_only=True)[:-5:-1]

    known = loads(64)  # with polynomials
    assert np.abs(loads(66) / known - 1.0).max() < 1e-9
    assert np.abs(loads(120) / known - 1.0).max() < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("word", ["clamped", pytest.param("guided-free", marks=pytest.mark.slow)])
def test_a_thousand_functions_are_orthonormal(word: str) -> None:
    found = beam.basis(EndConditions.of(word), 1000)
    gram = (found.values * found.weights) @ found.values.T
    assert np.abs(gram - np.eye(found.size)).max() < 1e-11
    assert 1000 < found.size <= 1004
    push = found.coupling(np.ones_like(found.nodes))
    # Far from the ends functions are sines, so that the integral of phi'^2 is k^2, but for what the ends add.
    waves = beam.wavenumbers(EndConditions.of(word), 1000)
    assert np.abs(push.diagonal()[990:1000] / waves[990:] ** 2 - 1.0).max() < 2e-3
    assert np.diff(waves[-500:]) == pytest.approx(math.pi, rel=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("word", ["hinged", "guided"])
def test_a_uniform_force_couples_hardly_any_of_many_waves(word: str) -> None:
    found = beam.basis(EndConditions.of(word), 240)
    push = found.coupling(np.full_like(found.nodes, 0.3))
    assert np.count_nonzero(push) < 0.05 * push.size


def test_of_large_bases_only_the_last_is_kept() -> None:
    ends = EndConditions.of("clamped")
    small = beam.basis(ends, 20)
    first = weakref.ref(beam.basis(ends, 201))
    assert beam.basis(ends, 201) is first()
    beam.basis(ends, 202)
    gc.collect()
    assert first() is None
    assert beam.basis(ends, 20) is small
