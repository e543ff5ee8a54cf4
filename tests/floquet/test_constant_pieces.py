"""Constant pieces in closed form: errors against exponentials in many digits, verdicts of batches."""

from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest

import floquetrod as fr
from floquetrod.equations.batches import pick
from floquetrod.floquet.kernels.constant_pieces import piece_pairs, piece_pairs_fill
from floquetrod.systems import batch_verdicts
from tests.conftest import depth

KINDS = ("mild", "stiff", "zero", "rank one", "long", "pushed", "diagonal", "nearly equal")


def symmetric(rng: np.random.Generator, n: int, kind: str) -> Any:
    """Return a drawn stiffness of a kind."""
    square = rng.normal(size=(n, n))
    mild = 0.5 * (square + square.T)
    vector = rng.normal(size=(n, 1))
    return {
        "mild": mild + 2.0 * np.eye(n),
        "stiff": mild * 10.0 ** rng.uniform(-4.0, 4.0),
        "zero": np.zeros((n, n)),
        "rank one": vector @ vector.T,
        "long": 0.2 * mild + np.eye(n),
        "pushed": 10.0 * mild - 20.0 * np.eye(n),
        "diagonal": np.diag(10.0 ** rng.uniform(-6.0, 3.0, n)),
        "nearly equal": 3.0 * np.eye(n) + 1e-7 * mild,
    }[kind]


def true_pairs(stiffness: Any, length: Any) -> list[Any]:
    """Return (mu + 1/mu - 2) / 4 of one system from exponentials in many digits."""
    n = stiffness.shape[-1]
    with mpmath.workdps(250):
        total = mpmath.eye(2 * n)
        for matrix, duration in zip(stiffness, length, strict=True):
            rates = mpmath.zeros(2 * n)
            for i in range(n):
                rates[i, n + i] = 1
                for j in range(n):
                    rates[n + i, j] = -mpmath.mpf(float(matrix[i, j]))
            total = mpmath.expm(rates * mpmath.mpf(float(duration))) * total
        trace = sum(total[i, i] for i in range(2 * n))
        if n == 1:
            return [(trace - 2) / 4]
        minors = sum(
            total[i, i] * total[j, j] - total[i, j] * total[j, i] for i in range(2 * n) for j in range(i + 1, 2 * n)
        )
        root = mpmath.sqrt(trace * trace / 4 - minors + 2)
        return [(trace / 2 + sign * root - 2) / 4 for sign in (1, -1)]


def enclosed(values: Any, radii: Any, true: list[Any]) -> bool:
    """Return whether the discs, in one order or the other, hold the true values."""
    orders = [true, true[::-1]]
    return any(
        all(abs(mpmath.mpc(v) - t) <= r for v, r, t in zip(values.tolist(), radii, order, strict=True))
        for order in orders
    )


@pytest.mark.kernels
@pytest.mark.parametrize("n", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_errors_hold_against_exponentials_in_many_digits(n: int) -> None:
    rng = np.random.default_rng(n)
    relative = []
    for count in range(depth(12, 3)):
        for kind in KINDS:
            pieces = 2 + count % 2
            stiffness = np.array([symmetric(rng, n, kind), *(symmetric(rng, n, "mild") for _ in range(pieces - 1))])
            if kind in ("zero", "nearly equal"):
                stiffness[:] = stiffness[0]
            length = rng.uniform(0.5, 1.5, pieces)
            length[0] *= 100.0 if kind == "long" else 1.0
            values, radii = piece_pairs(stiffness[None], length[None], np.zeros(1))
            assert enclosed(values[0], radii[0], true_pairs(stiffness, length)), (kind, stiffness, length)
            if kind == "mild":
                relative.append((radii / np.maximum(1.0, np.abs(values))).max())
    assert max(relative) < 1e-11


@pytest.mark.kernels
@pytest.mark.parametrize("n", [1, 2])
def test_errors_hold_an_uncertainty_of_the_stiffness(n: int) -> None:
    rng = np.random.default_rng(10 + n)
    batch, uncertainty = 200, 1e-6
    stiffness = np.array([[symmetric(rng, n, "mild") for _ in range(3)] for _ in range(batch)])
    length = rng.uniform(0.2, 1.5, (batch, 3))
    change = np.array([[symmetric(rng, n, "mild") for _ in range(3)] for _ in range(batch)])
    change *= uncertainty / np.linalg.norm(change, 2, axis=(2, 3))[..., None, None]
    values, radii = piece_pairs(stiffness, length, np.full(batch, uncertainty))
    moved, _ = piece_pairs(stiffness + change, length, np.zeros(batch))
    assert all(enclosed(*row) for row in zip(values, radii, moved.tolist(), strict=True))
    assert (np.abs(moved - values).max(axis=1) > 1e-9).all()


def test_the_interpreted_kernel_has_the_same_numbers() -> None:
    rng = np.random.default_rng(3)
    stiffness = np.array([[symmetric(rng, 2, kind) for kind in KINDS[:3]] for _ in range(80)])
    length = rng.uniform(0.2, 1.5, (80, 3))
    values, radii = piece_pairs(stiffness, length, np.zeros(80))
    out = np.empty((80, 6))
    piece_pairs_fill(stiffness.tolist(), length.tolist(), [0.0] * 80, out)
    assert np.allclose(values.real, out[:, :2], rtol=1e-12, atol=1e-12)
    assert np.allclose(values.imag, out[:, 2:4], rtol=1e-12, atol=1e-12)
    assert np.allclose(radii, out[:, 4:], rtol=1e-9)


def test_what_leaves_the_range_of_doubles_has_infinite_errors() -> None:
    stiffness = np.array([[[[-1e6]], [[1.0]]], [[[1e20]], [[1.0]]], [[[1e308]], [[-1e308]]]])
    values, radii = piece_pairs(stiffness, np.ones((3, 2)), np.zeros(3))
    assert np.isnan(values).all()
    assert np.isinf(radii).all()
    system = fr.HillSystem.from_pieces([(1.0, stiffness[:2, 0]), (1.0, stiffness[:2, 1])])
    assert (batch_verdicts.verdicts(system, quick=True).status == -1).all()
    with pytest.warns(fr.UndecidedWarning, match="1 of 1 systems could not be decided"):
        assert not fr.systems.is_stable(pick(system, 0))


@pytest.mark.parametrize("n", [2, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    "form",
    [
        {},
        *(
            pytest.param(form, marks=pytest.mark.slow)
            for form in ({"damping": 0.2}, {"mass": 2.0}, {"coefficient_error": 1e-7})
        ),
    ],
)
def test_batches_answer_as_the_maps_of_each_system(n: int, form: dict[str, float]) -> None:
    rng = np.random.default_rng(5)
    kinds = [KINDS[i % len(KINDS)] for i in range(depth(720, 72))]
    first = np.array([symmetric(rng, n, kind) for kind in kinds])
    second = np.array([symmetric(rng, n, "mild") for _ in kinds])
    length = rng.uniform(0.5, 1.5, (2, len(kinds)))
    others: dict[str, Any] = {
        name: value if name == "coefficient_error" else value * np.eye(n) for name, value in form.items()
    }
    if "mass" in form and n == 2:
        others["mass"] = np.array([[2.0, 0.5], [0.5, 1.0]])
    batch = fr.HillSystem.from_pieces([(length[0], first), (length[1], second)], **others)
    answer = batch_verdicts.verdicts(batch)
    growing = 0
    for i in range(len(kinds)):
        single = fr.stability(pick(batch, i))
        assert answer.status[i] == {"stable": 1, "unstable": 0, "undecided": -1}[single.status], (kinds[i], i)
        if single.status == "unstable":
            growing += 1
            assert math.isclose(answer.growth[i], single.growth_rate, rel_tol=1e-7, abs_tol=1e-9), (kinds[i], i)
    assert 0 < growing < len(kinds)
