"""First-order tongues against the verdicts of `fr.stability`, from which they differ by terms of second order."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import floquetrod as fr
from floquetrod.systems import FirstOrderTongue, first_order_tongues

MEAN = np.diag([1.0, 4.0])
SYMMETRIC = np.array([[0.5, 1.0], [1.0, 0.8]])
OPPOSED = np.array([[0.0, 1.0], [-1.0, 0.0]])


def system(forcing: float, w: float = 1.0, shape: np.ndarray = SYMMETRIC, **others: object) -> fr.HillSystem:
    return fr.HillSystem(MEAN, cosines=[forcing * shape], period=2.0 * math.pi / w, **others)


def tongue(problem: fr.HillSystem, kind: str, modes: tuple[int, ...]) -> FirstOrderTongue:
    (found,) = [one for one in first_order_tongues(problem) if (one.kind, one.modes) == (kind, modes)]
    return found


def growth(problem: fr.HillSystem) -> float:
    """Growth rate, negative where all motion decays."""
    return max(exponent.real for exponent in fr.stability(problem, method="monodromy").exponents)


@pytest.mark.parametrize(
    ("kind", "modes", "shape", "centre"),
    [
        ("sum", (1, 2), SYMMETRIC, 3.0),
        ("direct", (1,), SYMMETRIC, 2.0),
        ("direct", (2,), SYMMETRIC, 4.0),
        ("difference", (1, 2), OPPOSED, 1.0),
    ],
)
@pytest.mark.parametrize("place", [0.0, 0.6, -0.6])
def test_growth_is_right_to_first_order(
    kind: str, modes: tuple[int, ...], shape: np.ndarray, centre: float, place: float
) -> None:
    errors = []
    for forcing in (0.04, 0.02, 0.01):
        found = tongue(system(forcing, shape=shape), kind, modes)
        assert found.frequency == pytest.approx(centre, rel=1e-14)
        w = centre + place * found.half_width
        exact = growth(system(forcing, w, shape))
        assert exact > 0.0
        errors.append(abs(found.growth_rate_at(w) - exact))
    assert errors[0] < 0.1 * 0.04
    for coarse, fine in pairwise(errors):
        assert fine < 0.3 * coarse  # a quarter where the error is of second order


@pytest.mark.parametrize(
    ("kind", "modes", "shape"),
    [("sum", (1, 2), SYMMETRIC), ("difference", (1, 2), OPPOSED), ("direct", (1,), SYMMETRIC)],
)
def test_boundaries_are_right_to_first_order(kind: str, modes: tuple[int, ...], shape: np.ndarray) -> None:
    for forcing in (0.04, 0.02, 0.01):
        found = tongue(system(forcing, shape=shape), kind, modes)
        off = 0.4 * forcing**2
        assert off < 0.2 * found.half_width
        for side in (-1.0, 1.0):
            edge = found.frequency + side * found.half_width
            assert fr.stability(system(forcing, edge - side * off, shape)).status == "unstable"
            assert fr.stability(system(forcing, edge + side * off, shape)).status == "stable"


def test_a_symmetric_stiffness_has_no_difference_resonance() -> None:
    assert {one.kind for one in first_order_tongues(system(0.1))} == {"direct", "sum"}
    assert fr.stability(system(0.1, 1.0)).strongly_stable
    assert {one.kind for one in first_order_tongues(system(0.1, shape=OPPOSED))} == {"difference"}
    assert fr.stability(system(0.1, 3.0, OPPOSED)).stable


def test_unequal_damping_widens_a_tongue() -> None:
    damping = (0.0005, 0.02)
    free = tongue(system(0.04), "sum", (1, 2))
    damped = tongue(system(0.04, damping=2.0 * np.diag(damping)), "sum", (1, 2))
    assert damped.damping == damping
    assert damped.half_width > 1.2 * free.half_width
    total, product = sum(damping), math.prod(damping)
    assert damped.half_width == pytest.approx(total * math.sqrt(0.04**2 / 32.0 / product - 1.0))
    w = 3.0 + 0.5 * (free.half_width + damped.half_width)
    assert fr.stability(system(0.04, w)).strongly_stable
    assert fr.stability(system(0.04, w, damping=2.0 * np.diag(damping))).status == "unstable"


@pytest.mark.parametrize("damping", [(0.005, 0.002), (0.02, 0.02)])
@pytest.mark.parametrize("place", [0.0, 0.05])
def test_growth_with_damping(damping: tuple[float, float], place: float) -> None:
    errors = []
    for part in (1.0, 0.5, 0.25):
        problem = {"damping": 2.0 * part * np.diag(damping)}
        found = tongue(system(0.04 * part, **problem), "sum", (1, 2))
        w = 3.0 + place * part
        errors.append(abs(found.growth_rate_at(w) - growth(system(0.04 * part, w, **problem))))
    for coarse, fine in pairwise(errors):
        assert fine < 0.3 * coarse + 1e-14  # equal damping outside the tongue: both are exact


def test_damping_beyond_the_coupling_suppresses() -> None:
    found = tongue(system(0.04, damping=0.1 * np.eye(2)), "sum", (1, 2))
    assert found.half_width == 0.0
    assert found.growth_rate == pytest.approx(0.04 / math.sqrt(32.0) - 0.05)
    assert fr.stability(system(0.04, 3.0, damping=0.1 * np.eye(2))).stable


def test_one_undamped_mode_leaves_no_boundary() -> None:
    found = tongue(system(0.04, damping=np.diag([0.0, 0.1])), "sum", (1, 2))
    assert found.half_width == math.inf
    assert found.growth_rate_at(3.3) > 0.0
    assert fr.stability(system(0.04, 3.3, damping=np.diag([0.0, 0.1]))).status == "unstable"


@given(
    gaps=st.tuples(*[st.floats(0.1, 1.5)] * 3),
    angle=st.floats(0.1, 3.0),
    masses=st.tuples(*[st.floats(0.2, 5.0)] * 3),
)
def test_coordinates_do_not_matter(gaps: tuple[float, ...], angle: float, masses: tuple[float, ...]) -> None:
    w = 0.5 + np.cumsum(gaps)
    turn = np.eye(3)
    turn[:2, :2] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    shape = np.array([[0.3, 0.1, 0.2], [0.1, -0.4, 0.5], [0.2, 0.5, 0.7]])
    plain = fr.HillSystem(np.diag(w**2), cosines=[0.01 * shape])
    root = turn @ np.diag(np.sqrt(masses))  # q = root^-T u has the mass root root^T
    turned = fr.HillSystem(
        (lambda k: 0.5 * (k + k.T))(root @ np.diag(w**2) @ root.T),
        cosines=[(lambda k: 0.5 * (k + k.T))(root @ (0.01 * shape) @ root.T)],
        mass=(lambda m: 0.5 * (m + m.T))(root @ root.T),
    )
    ours = {(one.kind, one.modes): one for one in first_order_tongues(plain)}
    theirs = {(one.kind, one.modes): one for one in first_order_tongues(turned)}
    assert ours.keys() == theirs.keys()
    for key, one in ours.items():
        assert theirs[key].frequency == pytest.approx(one.frequency, rel=1e-9)
        assert theirs[key].coupling == pytest.approx(one.coupling, rel=1e-9)


def test_every_harmonic_has_its_tongues() -> None:
    first = fr.HillSystem(MEAN, cosines=[0.02 * SYMMETRIC])
    second = fr.HillSystem(MEAN, cosines=[np.zeros((2, 2)), 0.02 * SYMMETRIC])
    shifted = fr.HillSystem(MEAN, sines=[np.zeros((2, 2)), 0.02 * SYMMETRIC])
    for one, other, same in zip(*map(first_order_tongues, (first, second, shifted)), strict=True):
        assert (other.kind, other.modes, other.order) == (one.kind, one.modes, 2) == (same.kind, same.modes, same.order)
        assert other.frequency == same.frequency == pytest.approx(0.5 * one.frequency)
        assert other.half_width == pytest.approx(0.5 * one.half_width)
        assert other.growth_rate == pytest.approx(one.growth_rate)
        assert same.growth_rate == pytest.approx(one.growth_rate)
    assert first_order_tongues(fr.HillSystem(MEAN)) == ()


def test_the_scalar_equation_agrees_with_its_tongue() -> None:
    (found,) = first_order_tongues(fr.Mathieu(alpha=0.01, beta=-0.25).as_system())
    assert (found.kind, found.modes) == ("direct", (1,))
    assert found.frequency == pytest.approx(1.0)
    assert found.growth_rate == pytest.approx(fr.stability(fr.Mathieu(alpha=0.01, beta=-0.25)).growth_rate, rel=1e-4)


def test_tongues_that_meet_are_marked() -> None:
    assert not any(one.overlaps for one in first_order_tongues(system(0.04)))
    close = fr.HillSystem(np.diag([1.0, 1.0001]), cosines=[0.04 * SYMMETRIC])
    assert all(one.overlaps for one in first_order_tongues(close))
    apart = fr.HillSystem(np.diag([1.0, 1.0001]), cosines=[0.04 * np.diag([1.0, 1.0])])
    assert not any(one.overlaps for one in first_order_tongues(apart))  # no mode in common
    assert not any(one.kind == "sum" for one in first_order_tongues(apart))


def test_it_says_what_it_is() -> None:
    texts = [repr(one) for one in first_order_tongues(system(0.2))]
    assert texts[0] == (
        "<first-order approximation, never a verdict: sum resonance of modes 1 and 2, order 1: w = 3 +- 0.0707, "
        "growth 0.0354 per unit time at the centre>"
    )
    assert all(text.startswith("<first-order approximation, never a verdict") for text in texts)
    suppressed = fr.HillSystem(np.diag([1.0, 4.0]), cosines=[0.02 * SYMMETRIC], damping=0.2 * np.eye(2))
    tongues = first_order_tongues(suppressed)
    assert all(tongue.growth_rate < 0.0 for tongue in tongues)
    assert all(repr(tongue).endswith(" at the centre, so the damping removes it>") for tongue in tongues)
    assert not hasattr(first_order_tongues(system(0.2))[0], "status")
    values = first_order_tongues(system(0.2))[0].growth_rate_at([2.9, 3.0, 3.2])
    assert values.shape == (3,)
    assert isinstance(first_order_tongues(system(0.2))[0].growth_rate_at(3), float)


@pytest.mark.parametrize(
    ("problem", "error", "message"),
    [
        (fr.Mathieu(0.5, -0.25), TypeError, "system must be a HillSystem, got Mathieu"),
        (fr.HillSystem(np.ones((3, 1, 1))), ValueError, "system must be a single system"),
        (fr.HillSystem(MEAN, gyroscopic=OPPOSED), ValueError, "no gyroscopic terms"),
        (fr.HillSystem(MEAN + OPPOSED), ValueError, "symmetric mean stiffness"),
        (fr.HillSystem(-MEAN), ValueError, "positive definite mean stiffness, got one with the eigenvalue -4"),
        (fr.HillSystem(np.diag([0.0, 1.0])), ValueError, "positive definite mean stiffness"),
        (fr.HillSystem(MEAN, damping=-MEAN), ValueError, "got the decay rate -2 of mode 2"),
        (fr.HillSystem(MEAN, [[[0, 1], [0, 0]]], [[[0, 0], [1, 0]]]), ValueError, "modes 1 and 2 act on each other"),
    ],
)
def test_what_has_no_such_tongues_is_refused(problem: object, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        first_order_tongues(problem)  # type: ignore[arg-type]
