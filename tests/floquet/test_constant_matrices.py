"""Constant pieces of up to four equations: discs against eigenvalues in many digits, batches against general maps."""

from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest

import floquetrod as fr
from floquetrod._util.compilation import compiled
from floquetrod.equations.batches import pick
from floquetrod.floquet.kernels.constant_matrices import multipliers_fill, paired_fill, piece_multipliers
from floquetrod.systems import batch_verdicts
from tests.conftest import depth

KINDS = (
    "mild",
    "stiff",
    "short",
    "decaying",
    "defective",
    "triangular",
    "zero",
    "growing",
    "scaled",
    "equal",
    "turning",
)


def drawn(rng: np.random.Generator, n: int, kind: str) -> Any:
    """Return a drawn matrix of a kind."""
    mild = rng.normal(size=(n, n))
    scale = 10.0 ** rng.uniform(-3.0, 3.0, n)
    return {
        "mild": mild,
        "stiff": mild * 10.0 ** rng.uniform(0.0, 1.5) - 3.0 * np.eye(n),
        "short": 0.01 * mild,
        "decaying": 0.5 * mild - 8.0 * np.eye(n),
        "defective": rng.uniform(0.3, 3.0) * np.eye(n, k=1) - 0.1 * np.eye(n),
        "triangular": np.triu(mild) - 0.5 * np.eye(n),
        "zero": np.zeros((n, n)),
        "growing": mild + 3.0 * np.eye(n),
        "scaled": mild * scale[:, None] / scale[None, :],
        "equal": -0.3 * np.eye(n),
        "turning": 20.0 * (mild - mild.T) - 0.1 * np.eye(n),
    }[kind]


def second(rng: np.random.Generator, n: int, kind: str) -> Any:
    """Return the matrix of the second piece: of the same eigenvectors, where they matter."""
    if kind in ("defective", "equal"):
        return rng.uniform(0.3, 3.0) * np.eye(n, k=1) * (kind == "defective") + 0.05 * np.eye(n)
    return rng.normal(size=(n, n)) * (0.01 if kind == "short" else 1.0)


def true_multipliers(matrices: Any, length: Any) -> list[Any]:
    """Return the multipliers of one system from exponentials in many digits."""
    with mpmath.workdps(80):
        total = mpmath.eye(matrices.shape[-1])
        for matrix, duration in zip(matrices, length, strict=True):
            total = mpmath.expm(mpmath.matrix(matrix.tolist()) * mpmath.mpf(float(duration))) * total
        return [total[0]] if len(total) == 1 else list(mpmath.eig(total, left=False, right=False))


def enclosed(values: Any, radii: Any, true: list[Any]) -> bool:
    """Return whether discs that touch hold as many true values as there are discs."""
    n = len(values)
    near = np.abs(values[:, None] - values[None, :]) <= radii[:, None] + radii[None, :]
    for _ in range(n):
        near = near @ near
    for i in range(n):
        members = np.flatnonzero(near[i])
        inside = [any(abs(t - mpmath.mpc(complex(values[j]))) <= radii[j] for j in members) for t in true]
        if sum(inside) != len(members):
            return False
    return True


def interpreted(fill: Any, matrices: Any, length: Any, uncertainty: Any) -> tuple[Any, Any]:
    """Return values and radii of a kernel as it stands."""
    count = matrices.shape[-1] // (1 + (fill is paired_fill))
    out = np.empty((len(length), 3 * count))
    with np.errstate(all="ignore"):  # as in machine code
        fill(matrices.tolist(), length.tolist(), out, uncertainty.tolist())
    return out[:, :count] + 1j * out[:, count : 2 * count], out[:, 2 * count :]


@pytest.mark.kernels
@pytest.mark.parametrize("n", [1, 2, *(pytest.param(n, marks=pytest.mark.slow) for n in (3, 4))])
def test_discs_hold_the_multipliers_in_many_digits(n: int) -> None:
    rng = np.random.default_rng(n)
    relative = []
    for _ in range(depth(20, 1)):
        pieces = 2 + int(rng.integers(2))
        matrices = np.array(
            [[drawn(rng, n, kind), *(second(rng, n, kind) for _ in range(pieces - 1))] for kind in KINDS]
        )
        length = rng.uniform(0.5, 1.5, (len(KINDS), pieces))
        values, radii = interpreted(multipliers_fill, matrices, length, np.zeros((n, n)))
        for i, kind in enumerate(KINDS):
            if np.isfinite(radii[i]).all():
                assert enclosed(values[i], radii[i], true_multipliers(matrices[i], length[i])), (kind, matrices[i])
            if kind in ("mild", "short", "decaying"):
                largest = np.abs(values[i]).argmax()
                relative.append(radii[i, largest] / np.abs(values[i, largest]))
    assert max(relative) < 1e-9


@pytest.mark.kernels
def test_discs_hold_where_a_fast_neighbour_halves_the_steps_of_all() -> None:
    rng = np.random.default_rng(4)
    batch = 160
    matrices, length = rng.normal(size=(batch, 2, 1, 1)) * 0.02, rng.uniform(0.5, 1.5, (batch, 2))
    matrices[::8] *= 1500.0
    values, radii = interpreted(multipliers_fill, matrices, length, np.zeros((1, 1)))
    errors = []
    for i in range(batch):
        with mpmath.workdps(40):
            exponent = sum(mpmath.mpf(h) * mpmath.mpf(a) for h, a in zip(length[i], matrices[i].ravel(), strict=True))
            errors.append(float(abs(mpmath.exp(exponent) - mpmath.mpc(complex(values[i, 0])))))
    shares = np.array(errors) / radii[:, 0]
    assert shares.max() <= 1.0
    assert shares.max() > 0.01


@pytest.mark.kernels
@pytest.mark.parametrize("n", [1, 2])
def test_pairs_hold_the_numbers_of_a_hamiltonian_system(n: int) -> None:
    rng = np.random.default_rng(20 + n)
    turn = np.block([[np.zeros((n, n)), np.eye(n)], [-np.eye(n), np.zeros((n, n))]])
    batch = depth(80, 8)
    energies = rng.normal(size=(batch, 2, 2 * n, 2 * n))
    matrices = turn @ (energies + np.swapaxes(energies, -1, -2) + 0.5 * np.eye(2 * n))
    length = rng.uniform(0.2, 0.8, (batch, 2))
    values, radii = interpreted(paired_fill, matrices, length, np.zeros((2 * n, 2 * n)))
    for i in range(batch):
        for mu in true_multipliers(matrices[i], length[i]):
            y = (mu + 1 / mu - 2) / 4
            assert any(abs(y - mpmath.mpc(complex(v))) <= r for v, r in zip(values[i], radii[i], strict=True))
    assert np.median(radii / np.maximum(1.0, np.abs(values))) < 1e-11


@pytest.mark.kernels
@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_discs_hold_an_uncertainty_of_the_matrices(n: int) -> None:
    rng = np.random.default_rng(10 + n)
    batch, uncertainty = 8, 1e-6
    matrices, length = rng.normal(size=(batch, 3, n, n)), rng.uniform(0.2, 1.0, (batch, 3))
    values, radii = interpreted(multipliers_fill, matrices, length, np.full((n, n), uncertainty))
    change = uncertainty * np.sign(rng.normal(size=matrices.shape))
    moved, _ = interpreted(multipliers_fill, matrices + change, length, np.zeros((n, n)))
    assert all(enclosed(*row) for row in zip(values, radii, moved.tolist(), strict=True))
    assert (np.abs(moved - values).max(axis=1) > 1e-9).all()


@pytest.mark.parametrize("fill", [multipliers_fill, paired_fill])
def test_machine_code_has_the_same_numbers(fill: Any) -> None:
    rng = np.random.default_rng(3)
    matrices = np.array([[drawn(rng, 4, kind), rng.normal(size=(4, 4))] for kind in KINDS])
    length = rng.uniform(0.2, 1.0, (len(KINDS), 2))
    values, radii = interpreted(fill, matrices, length, np.zeros((4, 4)))
    out = np.empty((len(KINDS), 3 * values.shape[1]))
    compiled(fill)(matrices, length, out, np.zeros((4, 4)))
    count = values.shape[1]
    lost = np.isinf(radii)
    assert np.array_equal(lost, np.isinf(out[:, 2 * count :]))
    assert (np.abs(out[:, :count] + 1j * out[:, count : 2 * count] - values)[~lost] <= 2.0 * radii[~lost]).all()
    assert np.allclose(radii, out[:, 2 * count :], rtol=1e-3)


def test_what_leaves_the_range_of_doubles_has_infinite_errors() -> None:
    matrices = np.ones((6, 2, 3, 3))
    matrices[0, 0], matrices[1, 0], matrices[2, 0], matrices[3, 0] = 200.0, 1e20, 1e308, np.nan
    matrices[4, 0] = -1e8 * np.eye(3)
    values, radii = interpreted(multipliers_fill, matrices, np.ones((6, 2)), np.zeros((3, 3)))
    assert np.isnan(values[:5]).all()
    assert np.isinf(radii[:5]).all()
    assert np.isfinite(radii[5]).all()  # a neighbour is not harmed
    assert abs(values[5] - math.exp(6.0)).min() < 1e-9


def test_little_work_is_left_to_the_general_maps() -> None:
    assert piece_multipliers(np.zeros((1, 2, 2, 2)), np.ones((1, 2)), np.zeros((2, 2)), paired=False) is None


BATCH = 360  # enough for the kernels to be compiled


def pieces_of(rng: np.random.Generator, n: int, *, symmetric: bool, shift: float, waves: Any = 0.0) -> list[Any]:
    """Return two pieces of a batch of drawn matrices."""
    pieces = []
    for _ in range(2):
        square = rng.normal(size=(BATCH, n, n)) + waves * rng.normal(size=(BATCH, n, n))
        matrix = 0.5 * (square + np.swapaxes(square, 1, 2)) if symmetric else square
        pieces.append((rng.uniform(0.5, 1.5, BATCH), matrix + shift * np.eye(n)))
    return pieces


def batch_of(form: str) -> fr.HillSystem | fr.PeriodicSystem:
    """Return a batch of a form."""
    rng = np.random.default_rng(7)
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    hill, first = fr.HillSystem.from_pieces, fr.PeriodicSystem.from_pieces
    stiff = pieces_of(rng, 2, symmetric=True, shift=2.0)
    if form == "damped":
        return hill(stiff, damping=np.diag([0.1, 0.3]))
    if form == "damped by little":
        return hill(stiff, damping=1e-6 * np.diag([1.0, 3.0]))
    if form == "with mass":
        return hill(stiff, damping=np.diag([0.1, 0.3]), mass=[[2.0, 0.5], [0.5, 1.0]])
    if form == "in error":
        return hill(stiff, damping=np.diag([0.1, 0.3]), coefficient_error=1e-7)
    if form == "gyroscopic":
        return hill(stiff, gyroscopic=turn * rng.uniform(0.0, 3.0, (BATCH, 1, 1)))
    if form == "follower load":
        return hill(pieces_of(rng, 2, symmetric=False, shift=2.0), damping=np.diag([0.1, 0.3]))
    if form == "hamiltonian":
        return first([(h, turn @ energy) for h, energy in stiff])
    if form == "complex":
        return first(pieces_of(rng, 2, symmetric=False, shift=-1.0, waves=1j))
    if form == "defective":
        return first([(h, np.triu(matrix) * np.eye(2, k=1) - 0.1 * np.eye(2)) for h, matrix in stiff])
    order, shift = {"one": (1, -0.2), "two": (2, -0.8), "three": (3, -1.2), "four": (4, -1.5), "growing": (4, 20.0)}[
        form
    ]
    return first(pieces_of(rng, order, symmetric=False, shift=shift))


FORMS = (
    *("damped", "damped by little", "with mass", "in error", "gyroscopic", "follower load", "hamiltonian"),
    *("complex", "defective", "one", "two", "three", "four", "growing"),
)


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS)
def test_batches_answer_as_general_maps_and_as_each_system(form: str) -> None:
    systems = batch_of(form)
    batch = batch_verdicts._batch(systems)
    assert isinstance(batch, batch_verdicts._MatrixPieceBatch)
    answer = batch_verdicts.verdicts(systems)
    general = batch.general.verdicts(slice(0, BATCH))
    known = general.status >= 0
    assert known.mean() > 0.9
    assert np.array_equal(answer.status[known], general.status[known])
    assert np.allclose(answer.growth, general.growth, rtol=1e-7, atol=1e-9)
    assert (0 < answer.status.sum() < BATCH) or form in ("defective", "growing")
    for i in range(0, BATCH, depth(9, 90)):
        single = fr.stability(pick(systems, i))
        assert answer.status[i] == {"stable": 1, "unstable": 0, "undecided": -1}[single.status], i
        assert math.isclose(answer.growth[i], single.growth_rate, rel_tol=1e-7, abs_tol=1e-9), i
