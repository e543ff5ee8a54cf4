"""Hypothesis strategies shared by the tests: equations of every kind, and where in their planes to look."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import strategies as st
from scipy.linalg import eigvalsh_tridiagonal

import floquetrod as fr

Point = tuple[float, float]

LARGEST_ALPHA = 400.0
BETA_RANGE = (-400.0, 50.0)


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    """Finite floats in [low, high]; subnormal ones are left to the tests of extreme parameters."""
    return st.floats(low, high, allow_nan=False, allow_infinity=False, allow_subnormal=False)


def decades(low: float, high: float) -> st.SearchStrategy[float]:
    """Positive floats between ``low`` and ``high``, uniform in their logarithm."""
    return numbers(math.log10(low), math.log10(high)).map(lambda power: min(max(10.0**power, low), high))


def dampings(largest: float = 0.5) -> st.SearchStrategy[float]:
    """Damping rates per unit tau: none, or anything from barely any to ``largest``."""
    return st.just(0.0) | decades(1e-9, largest)


def mathieu_points(
    largest_alpha: float = LARGEST_ALPHA, beta: tuple[float, float] = BETA_RANGE
) -> st.SearchStrategy[Point]:
    """Points (alpha, beta), half of them with |alpha| spread over decades: thin tongues live at small alpha."""
    sizes = numbers(0.0, largest_alpha) | decades(1e-9, largest_alpha)
    alphas = st.tuples(sizes, st.sampled_from((1.0, -1.0))).map(math.prod)
    return st.tuples(alphas, numbers(*beta))


@st.composite
def near_boundary_points(draw: st.DrawFn, largest_alpha: float = 20.0, orders: int = 8, nearest: float = 1e-9) -> Point:
    """Points (alpha, beta) beside a transition curve, at a distance in beta of ``nearest`` to 1e-2 relative to it."""
    alpha = draw(decades(1e-3, largest_alpha))
    curve = draw(st.sampled_from(transition_betas(alpha, orders)))
    offset = draw(decades(nearest, 1e-2)) * draw(st.sampled_from((1.0, -1.0)))
    return alpha, curve + offset * max(1.0, abs(curve))


def transition_betas(alpha: float, orders: int) -> list[float]:
    """Return the ``orders`` uppermost beta of each symmetry at which the solutions of Mathieu's equation have a period.

    Dense eigenvalues of Hill's matrices (DLMF 28.4), good to a few units of rounding of the largest entry;
    independent of the package.
    """
    q = 2.0 * abs(alpha)
    size = orders + 20 + int(2.0 * math.sqrt(q))
    even = [4.0 * k * k for k in range(size)]
    odd = [(2.0 * k + 1.0) ** 2 for k in range(size)]
    plain = [q] * (size - 2)
    chains = [
        (even, [math.sqrt(2.0) * q, *plain]),
        (even[1:], plain),
        ([odd[0] + q, *odd[1:]], [q, *plain]),
        ([odd[0] - q, *odd[1:]], [q, *plain]),
    ]
    values = [
        eigvalsh_tridiagonal(diagonal, coupling, select="i", select_range=(0, orders - 1))
        for diagonal, coupling in chains
    ]
    return sorted(-0.25 * float(a) for chain in values for a in chain)


def mathieus(
    largest_alpha: float = LARGEST_ALPHA, beta: tuple[float, float] = BETA_RANGE, largest_damping: float = 0.0
) -> st.SearchStrategy[fr.Mathieu]:
    """`Mathieu` values over `mathieu_points`, damped when ``largest_damping`` is above zero."""
    return st.builds(
        lambda point, damping: fr.Mathieu(*point, damping=damping),
        mathieu_points(largest_alpha, beta),
        dampings(largest_damping) if largest_damping else st.just(0.0),
    )


def square_waves(largest: float = 30.0, largest_damping: float = 0.0) -> st.SearchStrategy[fr.Meissner]:
    """`Meissner` values, the seams alpha = +-beta (where p or q vanishes) included."""
    sizes = numbers(-largest, largest)
    points = st.tuples(sizes, sizes) | sizes.map(lambda x: (x, x)) | sizes.map(lambda x: (x, -x))
    return st.builds(
        lambda point, damping: fr.Meissner(*point, damping=damping),
        points,
        dampings(largest_damping) if largest_damping else st.just(0.0),
    )


@st.composite
def hills(
    draw: st.DrawFn, harmonics: int = 4, largest: float = 20.0, largest_damping: float = 0.0, even: bool = False
) -> fr.Hill:
    """`Hill` values of up to ``harmonics`` harmonics and any period from 0.05 to 50.

    ``largest`` bounds each coefficient times (period / 2 pi)^2, which is what the difficulty depends on.  With ``even``
    there are no sines: tau = 0 is an instant of symmetry.
    """
    period = 2.0 * math.pi * draw(st.just(1.0) | decades(0.01, 8.0))
    scale = (2.0 * math.pi / period) ** 2
    terms = st.lists(numbers(-largest, largest).map(lambda x: scale * x), max_size=harmonics).map(tuple)
    return fr.Hill(
        scale * draw(numbers(-largest, largest)),
        cosines=draw(terms),
        sines=() if even else draw(terms),
        period=period,
        damping=draw(dampings(largest_damping)) * math.sqrt(scale) if largest_damping else 0.0,
    )


def random_matrix(seed: np.random.Generator, n: int, size: float, symmetric: bool = True) -> np.ndarray:
    matrix = seed.uniform(-size, size, (n, n))
    return 0.5 * (matrix + matrix.T) if symmetric else matrix


@st.composite
def systems(
    draw: st.DrawFn, kinds: tuple[str, ...] = ("hamiltonian", "reversible", "damped", "gyroscopic", "first")
) -> fr.HillSystem | fr.PeriodicSystem:
    """Systems of one to three equations of every structure, of moderate growth over a period."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    kind, n = draw(st.sampled_from(kinds)), draw(st.integers(1, 3))
    period = float(rng.uniform(1.0, 4.0))
    stiffness = np.diag(rng.uniform(-0.3, 6.0, n)) + random_matrix(rng, n, 0.5, kind != "reversible")
    waves = [random_matrix(rng, n, size, kind != "reversible") for size in (0.8, 0.3)]
    factor = rng.uniform(-0.4, 0.4, (n, n))
    mass = np.eye(n) + factor @ factor.T
    if kind == "first":
        return fr.PeriodicSystem(
            rng.uniform(-1.0, 1.0, (n, n)),
            [rng.uniform(-0.5, 0.5, (n, n))],
            [rng.uniform(-0.5, 0.5, (n, n))],
            period=period,
        )
    if kind == "reversible":
        return fr.HillSystem(stiffness, waves, mass=mass, period=period)
    if kind == "damped":
        damping = factor @ factor.T
        return fr.HillSystem(stiffness, waves, [waves[0] * 0.5], mass=mass, damping=damping, period=period)
    gyroscopic = factor - factor.T if kind == "gyroscopic" else None
    return fr.HillSystem(stiffness, waves, [waves[1] * 0.5], mass=mass, gyroscopic=gyroscopic, period=period)
