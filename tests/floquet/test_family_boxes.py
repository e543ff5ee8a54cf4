"""Boxes of the parameters of families of equations and systems: what is proved holds at every point that is tried."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.floquet.proof.family_boxes import corners
from tests.conftest import depth
from tests.equations.test_new_equation import Trapezoid
from tests.inside import Doubles, monodromy, system_problem


def coupled(stiffness: float, forcing: float, damping: float = 0.0, period: float = 5.0) -> fr.HillSystem:
    """Return two coupled Mathieu equations."""
    return fr.HillSystem(
        [[1.0, 0.0], [0.0, stiffness]],
        [[[0.1, forcing], [forcing, 0.16]]],
        damping=2.0 * damping * np.eye(2),
        period=period,
    )


def with_mass(added: float, twist: float) -> fr.HillSystem:
    """Return a gyroscopic system whose mass varies."""
    return fr.HillSystem(
        [[2.0, 0.1], [0.1, 5.0]],
        [[[0.1, 0.05], [0.05, 0.2]]],
        mass=[[1.0 + added, 0.1], [0.1, 1.5]],
        gyroscopic=[[0.0, twist], [-twist, 0.0]],
        period=2.0,
    )


def follower(load: float) -> fr.HillSystem:
    """Return a reversible system."""
    return fr.HillSystem([[2.0, load], [0.0, 5.0]], [[[0.1, 0.2], [0.0, 0.1]]], period=2.3)


def first_order(decay: float, forcing: float) -> fr.PeriodicSystem:
    """Return a damped equation in first order."""
    return fr.PeriodicSystem([[0.0, 1.0], [-1.3, -decay]], [[[0.0, 0.0], [forcing, 0.0]]])


def steps(high: float, damping: float) -> fr.HillSystem:
    """Return two coupled Meissner equations."""
    return fr.HillSystem.from_pieces(
        [(1.0, [[high, 0.1], [0.1, 4.0]]), (0.5, [[0.5, 0.0], [0.0, 3.0]])], damping=[[damping, 0.0], [0.0, 0.1]]
    )


BOXES: list[tuple[Callable[..., Any], dict[str, tuple[float, float]], str]] = [
    (coupled, {"stiffness": (4.2, 4.4), "forcing": (0.1, 0.2)}, "stable"),
    (coupled, {"stiffness": (4.2, 4.4), "forcing": (0.1, 0.2), "damping": (0.0, 0.05)}, "stable"),
    (coupled, {"stiffness": (4.2, 4.4), "forcing": (-0.05, 0.05), "period": (4.98, 5.02)}, "stable"),
    (coupled, {"stiffness": (-0.2, -0.1), "forcing": (0.0, 0.05)}, "unstable"),
    (with_mass, {"added": (0.0, 0.05), "twist": (0.1, 0.12)}, "stable"),
    (follower, {"load": (0.1, 0.12)}, "stable"),
    (first_order, {"decay": (0.1, 0.12), "forcing": (0.05, 0.1)}, "stable"),
    (first_order, {"decay": (-0.3, -0.29), "forcing": (0.0, 0.005)}, "unstable"),
    (steps, {"high": (1.9, 2.0), "damping": (0.1, 0.15)}, "stable"),
    (fr.Meissner, {"alpha": (0.4, 0.45), "beta": (-0.26, -0.24)}, "unstable"),
    (Trapezoid, {"alpha": (0.4, 0.404), "beta": (-0.7, -0.698), "damping": (0.04, 0.041)}, "stable"),
    (lambda k: fr.Hill(-k, cosines=(0.1,), sines=(0.1, 0.2)), {"k": (0.5, 0.52)}, "stable"),
    (lambda k: fr.HillSystem([[1.0, 0.0], [0.0, k]]), {"k": (0.5, 2.0)}, "stable"),
]


def drawn(box: dict[str, tuple[float, float]], rng: np.random.Generator, count: int) -> list[dict[str, float]]:
    """Return points of a box, corners and the middle among them."""
    shares = np.vstack([rng.uniform(0.0, 1.0, (count, len(box))), np.full((1, len(box)), 0.5)])
    shares[: count // 2] = np.round(shares[: count // 2])
    return [
        {name: low + s * (high - low) for s, (name, (low, high)) in zip(share, box.items(), strict=True)}
        for share in shares.tolist()
    ]


@pytest.mark.parametrize(
    ("family", "box", "status"),
    [pytest.param(*row, marks=[pytest.mark.slow] * (row[0] is first_order and row[2] == "stable")) for row in BOXES],
)
def test_what_is_proved_of_a_box_holds_at_its_points(
    family: Callable[..., Any], box: dict[str, tuple[float, float]], status: str, rng: np.random.Generator
) -> None:
    proof = fr.certify(family, **box)
    assert isinstance(proof, fr.results.RegionProof)
    assert proof.status == status, proof
    assert proof.statement.startswith("for every ")
    assert [(side.name, side.low, side.high) for side in proof.box] == [(name, *ends) for name, ends in box.items()]
    for point in drawn(box, rng, depth(20, 4)):
        assert fr.stability(family(**point)).status == status
    assert "affine" in proof.assumptions[0]
    assert proof.references == fr.certify(family(**{name: low for name, (low, _) in box.items()})).references
    assert proof.as_dict()["growth_tolerance_per_unit_time"] == 0.0
    assert status.upper() in str(proof.report())


@pytest.mark.slow
@pytest.mark.parametrize(("family", "box", "status"), BOXES[: depth(9, 4)])
def test_the_balls_hold_every_system_of_the_box(
    family: Callable[..., Any], box: dict[str, tuple[float, float]], status: str, rng: np.random.Generator
) -> None:
    """The map over a period of each point lies within that of the box."""
    narrow = {name: (low, low + 0.02 * (high - low)) for name, (low, high) in box.items()}
    problem = system_problem(*(family(**point) for point in corners(narrow)))
    every = monodromy(Doubles(), problem.flow(Doubles()))
    trace, reach = float(np.trace(every.mid)), float(np.trace(every.rad))
    for point in drawn(narrow, rng, depth(20, 4)):
        matrix, error = fr.stability(family(**point)).monodromy
        assert abs(np.trace(matrix) - trace) <= reach + len(matrix) * error
    assert reach < 1.0


def between_kinds(x: float) -> fr.HillSystem:
    """Return a reversible system at 0, a gyroscopic one at 1, whose multipliers come in pairs, and flutter between."""
    load, twist = 0.02 * (1.0 - x), 0.02 * x
    gyroscopic = [[0.0, twist], [-twist, 0.0]]
    return fr.HillSystem([[2.0, load], [0.0, 5.0]], [0.1 * np.eye(2)], gyroscopic=gyroscopic, period=2.3)


def between_kinds_of_first_order(x: float) -> fr.PeriodicSystem:
    """Return the same with constant coefficients, positions and momenta at 1."""
    load, twist = 0.02 * (1.0 - x), 0.02 * x
    return fr.PeriodicSystem(
        [[0.0, twist, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0], [-2.0, -load, 0.0, 0.0], [0.0, -5.0, -twist, 0.0]], period=2.3
    )


@pytest.mark.slow
@pytest.mark.parametrize("family", [between_kinds, between_kinds_of_first_order])
def test_pairs_at_the_corners_are_no_pairs_between_them(family: Callable[..., Any]) -> None:
    assert [family(x).structure for x in (0.0, 0.5, 1.0)] == ["reversible", "general", "hamiltonian"]
    assert fr.certify(family(0.5)).status == "unstable"
    assert fr.certify(family, x=(0.0, 1.0), max_boxes=40).status != "stable"


@pytest.mark.parametrize("of_first_order", [False, True])
def test_a_follower_load_from_nothing_on_is_reversible(of_first_order: bool) -> None:
    """The corner without it is Hamiltonian, and both corners are even about the same instant."""

    def family(load: float) -> Any:
        system = fr.HillSystem([[2.0, load], [0.0, 5.0]], [0.1 * np.eye(2)], period=2.3)
        return system.as_periodic_system() if of_first_order else system

    assert {family(0.0).structure, family(0.1).structure} == {"hamiltonian", "reversible"}
    assert fr.certify(family, load=(0.0, 0.02)).status == "stable"


def test_boundaries_within_a_box_are_told_by_an_example_on_either_side() -> None:
    proof = fr.certify(lambda k: fr.HillSystem([[1.0, 0.0], [0.0, k]], [0.05 * np.eye(2)], period=2.0), k=(-0.5, 2.0))
    assert isinstance(proof, fr.results.RegionProof)
    assert proof.status == "mixed"
    assert proof.boxes < 20
    assert {example.status for example in proof.examples} == {"stable", "unstable"}
    for example in proof.examples:
        assert fr.certify(example.equation).status == example.status


def test_a_thin_tongue_within_a_box_is_told() -> None:
    """The sum resonance of two oscillators, narrower than any part that intervals prove unstable soon."""
    box = {"stiffness": (3.9, 4.4), "forcing": (0.1, 0.5)}
    proof = fr.certify(lambda stiffness, forcing: coupled(stiffness, forcing, period=2.0 * np.pi / 3.0), **box)
    assert isinstance(proof, fr.results.RegionProof)
    assert proof.status == "mixed"
    assert {fr.stability(example.equation).status for example in proof.examples} == {"stable", "unstable"}


def test_a_box_that_takes_too_long_is_undecided_and_says_how_far_it_came() -> None:
    for work in ({"max_boxes": 3}, {"seconds": 1e-6}):
        proof = fr.certify(coupled, stiffness=(3.9, 4.4), forcing=(0.1, 0.5), **work)
        assert isinstance(proof, fr.results.RegionProof)
        assert proof.status == "undecided"
        assert "% of it proved stable" in proof.note
        assert proof.boxes <= 3


def test_without_ranges_one_equation_of_the_family_is_proved() -> None:
    proof = fr.certify(coupled, stiffness=4.3, forcing=0.1)
    assert isinstance(proof, fr.results.Proof)
    assert proof.equation == coupled(4.3, 0.1)
    assert proof.status == "stable"


def sampled(k: float, squeeze: float = 0.0) -> fr.HillSystem:
    """Return a system whose stiffness a function computes, which jumps."""

    def stiffness(t: float) -> list[list[float]]:
        if t % 2.0 < 0.7:
            return [[1.5 + k * math.exp(t % 2.0), 0.3], [0.3, 4.0]]
        return [
            [1.5 - 0.1 * (t % 2.0) ** 3, 0.1 * (t % 2.0)],
            [0.1 * (t % 2.0), 3.0 + squeeze * math.sin(5.0 * (t % 2.0))],
        ]

    return fr.HillSystem.from_function(stiffness, 2.0, jumps=[0.0, 0.7])


@pytest.mark.slow
@pytest.mark.parametrize("jumps", [False, True])
def test_boxes_of_functions_that_were_sampled(jumps: bool, rng: np.random.Generator) -> None:
    """Coefficients of what was sampled are affine up to its stated error, those of a fit to a piece in sum only."""

    def smooth(k: float) -> fr.HillSystem:
        return fr.HillSystem.from_function(lambda t: [[2.0 + k * math.exp(math.sin(t)), 0.1], [0.1, 5.0]], 2.0 * np.pi)

    family, box = (sampled, {"k": (0.9, 0.900001)}) if jumps else (smooth, {"k": (0.1, 0.11)})
    proof = fr.certify(family, **box)
    assert proof.status == "stable"
    for point in drawn(box, rng, 4):
        assert fr.stability(family(**point)).status == "stable"


@pytest.mark.parametrize(
    ("family", "error", "match"),
    [
        (
            lambda w: fr.HillSystem([[w * w]], [[[0.1]]]),
            ValueError,
            "affine in each parameter over the box, got a mean",
        ),
        (lambda w: fr.HillSystem(np.eye(1 + (w > 1.2))), ValueError, "got systems of different kinds or orders"),
        (lambda w: fr.HillSystem.from_pieces([(w, [[1.0]]), (1.0, [[2.0]])]), ValueError, "durations of pieces"),
        (lambda w: sampled(w, w * w), ValueError, "affine in each parameter over the box, got a coefficient"),
        (
            lambda w: w,
            TypeError,
            r"equation\(w=1\) must return a HillSystem, a PeriodicSystem, a DelaySystem or an Equation, got 1.0",
        ),
        (
            lambda w: fr.HillSystem(np.ones((3, 1, 1))),
            ValueError,
            r"equation\(w=1\) must return one system, got a batch",
        ),
        (lambda w: fr.Hill(-1.0 / (w - 1.5)), ValueError, r"equation\(w=1.5\) raised ZeroDivisionError: "),
    ],
)
def test_families_that_cannot_be_proved_are_refused(family: Any, error: type[Exception], match: str) -> None:
    with pytest.raises(error, match=match):
        fr.certify(family, w=(1.0, 1.5))


def test_ranges_are_checked() -> None:
    with pytest.raises(ValueError, match="stiffness must not decrease"):
        fr.certify(coupled, stiffness=(2.0, 1.0), forcing=0.1)
    with pytest.raises(ValueError, match="seconds must be"):
        fr.certify(coupled, stiffness=(1.0, 2.0), forcing=0.1, seconds=0.0)
    with pytest.raises(ValueError, match="at most 6 ranges, got 7"):
        fr.certify(lambda **k: coupled(2.0, 0.1), **{f"p{i}": (0.0, 1.0) for i in range(7)})
