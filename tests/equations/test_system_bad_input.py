"""What is no system is refused, with the name of the argument, what came and the remedy."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import floquetrod as fr

K = [[1.0, 0.0], [0.0, 4.0]]
HUGE = np.broadcast_to(np.zeros(()), (100_000, 100_000))
"""A matrix that says it has ten thousand million entries, and holds one."""

COMPLEX = {"stiffness": [[1.0 + 1.0j]]}
"""Taken in first order."""

WRONG: list[tuple[dict[str, Any], type[Exception], str]] = [
    # shapes
    ({"stiffness": 1.0}, ValueError, r"stiffness must be a square matrix.*for one equation give \[\[1.0\]\]"),
    ({"stiffness": [1.0, 2.0]}, ValueError, r"stiffness must be a square matrix.*got shape \(2,\)"),
    ({"stiffness": [[1.0, 2.0]]}, ValueError, r"stiffness must be a square matrix.*got shape \(1, 2\)"),
    ({"stiffness": []}, ValueError, r"stiffness must be a square matrix.*got shape \(0,\)"),
    ({"stiffness": np.zeros((0, 0))}, ValueError, r"stiffness must be a square matrix.*got shape \(0, 0\)"),
    ({"stiffness": np.zeros((0, 2, 2))}, ValueError, r"stiffness must be a square matrix.*got shape \(0, 2, 2\)"),
    ({"stiffness": [[1.0, 2.0], [3.0]]}, ValueError, "stiffness must be an array or nested lists of equal lengths"),
    ({"stiffness": HUGE}, ValueError, r"stiffness must be at most 2000 x 2000, got shape \(100000, 100000\)"),
    (
        {"stiffness": np.broadcast_to(np.zeros(()), (10**9, 2, 2))},
        ValueError,
        "stiffness must hold at most 268,435,456 entries",
    ),
    ({"mass": [[1.0]]}, ValueError, r"mass must be 2 x 2 as stiffness is, got shape \(1, 1\)"),
    ({"damping": HUGE}, ValueError, "damping must be at most 2000 x 2000"),
    ({"damping": 0.1}, ValueError, "damping must be a square matrix"),
    ({"gyroscopic": np.zeros((3, 3))}, ValueError, "gyroscopic must be 2 x 2 as stiffness is"),
    ({"cosines": K}, ValueError, r"cosines must be a sequence of matrices.*cosines=\[matrix\]"),
    ({"cosines": np.array(K)}, ValueError, r"cosines must be a sequence of matrices.*cosines=\[matrix\]"),
    ({"sines": [1.0]}, ValueError, "sines must be a sequence of matrices"),
    ({"sines": 1.0}, TypeError, r"sines must be a sequence of numbers such as \[matrix\], got 1.0"),
    ({"sines": np.array(1.0)}, TypeError, "sines must be a sequence"),
    ({"cosines": [K, [[1.0]]]}, ValueError, r"cosines\[1\] must be 2 x 2 as stiffness is"),
    ({"cosines": [K, [[1.0], [1.0, 2.0]]]}, ValueError, r"cosines\[1\] must be .* equal lengths"),
    ({"cosines": [[[1.0], [1.0, 2.0]]]}, ValueError, r"cosines\[0\] must be .* equal lengths"),
    ({"cosines": np.zeros((1025, 2, 2))}, ValueError, "cosines must hold at most 1024 harmonics"),
    ({"cosines": np.broadcast_to(np.zeros(()), (10**9, 2, 2))}, ValueError, "cosines must hold at most 1024"),
    ({"cosines": {"first": K}}, TypeError, "cosines must be a sequence"),
    ({"period": [1.0, [2.0]]}, ValueError, "period must be an array or nested lists of equal lengths"),
    ({"period": []}, ValueError, "period must be one number, or an array of one for each system"),
    # numbers
    ({"stiffness": [[np.nan]]}, ValueError, r"stiffness must be finite.*stiffness\[0, 0\] = nan"),
    ({"mass": [[1.0, 0.0], [0.0, np.inf]]}, ValueError, r"mass must be finite.*mass\[1, 1\] = inf"),
    ({"cosines": [K, [[1.0, 0.0], [np.nan, 1.0]]]}, ValueError, r"cosines\[1\] must be finite.*\[1, 0\] = nan"),
    ({"stiffness": [[1e31]]}, ValueError, r"stiffness must be finite and lie between -1e\+30 and 1e\+30"),
    ({"stiffness": [[Fraction(1, 3)]]}, ValueError, r"stiffness\[0, 0\] = Fraction\(1, 3\) is not a binary number"),
    ({"stiffness": [[Decimal("0.1")]]}, ValueError, r"stiffness\[0, 0\] = Decimal\('0.1'\) is not a binary number"),
    ({"stiffness": [[2**60 + 1]]}, ValueError, r"stiffness\[0, 0\] = 1152921504606846977 is not a binary number"),
    ({"cosines": [np.full((2, 2), np.longdouble("0.1"))]}, ValueError, r"cosines\[0\]\[0, 0\] = .* is not a binary"),
    ({"period": Fraction(1, 3)}, ValueError, r"period = Fraction\(1, 3\) is not a binary number of 53 digits"),
    ({"period": 0.0}, ValueError, "period must be greater than zero, got 0.0"),
    ({"period": -1.0}, ValueError, "period must be greater than zero, got -1.0"),
    ({"period": np.nan}, ValueError, "period must be finite, got nan"),
    ({"period": [1.0, 0.0]}, ValueError, "period must be greater than zero, got 0.0 among 2 values"),
    ({"period": [1.0, np.nan]}, ValueError, r"period must be finite.*period\[1\] = nan"),
    # kinds
    (COMPLEX, TypeError, "stiffness must hold real numbers"),
    ({"stiffness": "1 0; 0 1"}, TypeError, "stiffness must hold real numbers, got '1 0; 0 1'"),
    ({"stiffness": [["1", "0"], ["0", "1"]]}, TypeError, "stiffness must hold real numbers"),
    ({"stiffness": [[True]]}, TypeError, "stiffness must hold real numbers"),
    ({"stiffness": None}, TypeError, "stiffness must be"),
    ({"stiffness": np.ma.array(K, mask=np.eye(2))}, TypeError, "stiffness must not be a masked array"),
    ({"cosines": [np.ma.array(K, mask=np.eye(2))]}, TypeError, r"cosines\[0\] must not be a masked array"),
    ({"cosines": np.ma.array([K], mask=[np.eye(2)])}, TypeError, "cosines must be a sequence"),
    ({"cosines": "abc"}, TypeError, "cosines must be a sequence"),
    ({"cosines": ["abc"]}, TypeError, r"cosines\[0\] must hold real numbers"),
    ({"cosines": None}, TypeError, "cosines must be a sequence"),
    ({"period": "1"}, TypeError, "period must be a real number, got '1'"),
    ({"period": True}, TypeError, "period must be a real number"),
    ({"period": None}, TypeError, "period must be a single real number"),
    ({"period": 1j}, TypeError, "period must be a single real number"),
    ({"period": np.ma.array([1.0, 2.0], mask=[1, 0])}, TypeError, "period must not be a masked array"),
    # what a mass and a gyroscopic matrix must be
    ({"mass": [[1.0, 0.1], [0.2, 1.0]]}, ValueError, "mass must be symmetric, got entries that differ by 0.1"),
    ({"mass": [[1.0, 2.0], [2.0, 1.0]]}, ValueError, "mass must be positive definite, got one with the eigenvalue -1"),
    ({"mass": [[1.0, 0.0], [0.0, 0.0]]}, ValueError, "mass must be positive definite, got one with the eigenvalue 0"),
    ({"mass": [K, -np.eye(2)]}, ValueError, "mass must be positive definite, got one with the eigenvalue -1"),
    ({"gyroscopic": np.eye(2)}, ValueError, "gyroscopic must equal minus its transpose.*into damping"),
    ({"gyroscopic": [[0.0, 1.0], [1.0, 0.0]]}, ValueError, "gyroscopic must equal minus its transpose"),
]


@pytest.mark.parametrize(("given", "error", "message"), WRONG)
def test_what_is_no_system_of_second_order(given: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        fr.HillSystem(**({"stiffness": K} | given))


@pytest.mark.parametrize(
    ("given", "error", "message"),
    [row for row in WRONG if not row[0].keys() & {"mass", "damping", "gyroscopic"} and row[0] is not COMPLEX],
)
def test_what_is_no_system_of_first_order(given: dict[str, Any], error: type[Exception], message: str) -> None:
    renamed = {"mean" if name == "stiffness" else name: value for name, value in given.items()}
    with pytest.raises(error, match=message.replace("stiffness", "mean").replace("2000", "4000")):
        fr.PeriodicSystem(**({"mean": K} | renamed))


@pytest.mark.parametrize(("value", "error"), [(-1.0, ValueError), (np.nan, ValueError), ("1", TypeError)])
def test_errors_of_coefficients_are_numbers(value: Any, error: type[Exception]) -> None:
    with pytest.raises(error, match="coefficient_error must be"):
        fr.PeriodicSystem(K, coefficient_error=value)


def test_small_and_large_entries_overflow_nothing() -> None:
    for scale in (1e-30, 1e29):
        system = fr.HillSystem(scale * np.array(K), mass=scale * np.array([[2.0, 1.0], [1.0, 2.0]]))
        form = system.even_form
        assert form is not None
        assert np.allclose(np.linalg.eigvalsh(form.stiffness), np.linalg.eigvals(np.linalg.solve([[2, 1], [1, 2]], K)))
    extreme = fr.HillSystem(1e30 * np.eye(2), mass=1e-300 * np.array([[2.0, 1.0], [1.0, 2.0]]), damping=np.eye(2))
    assert extreme.uniform_damping is None
    with pytest.raises(
        ValueError, match=r"mass must fit the other matrices: in coordinates of mass 1 they are beyond 1e\+30"
    ):
        extreme.as_periodic_system()


@pytest.mark.parametrize("value", [1.0, "system", None, [[1.0]], fr.HillSystem, np.eye(2)])
def test_what_is_no_equation_is_not_classified(value: Any) -> None:
    with pytest.raises(TypeError, match="equation must be"):
        fr.stability(value)


def test_methods_say_what_they_need() -> None:
    damped = fr.HillSystem(K, damping=[[0.1, 0.0], [0.0, 0.2]])
    with pytest.raises(ValueError, match="system must have a stiffness even about an instant"):
        fr.stability(damped, "half_period")
    with pytest.raises(ValueError, match="method must be one of 'auto', 'spectral', 'half_period'"):
        fr.stability(damped, "determinant")


def test_multipliers_that_would_take_too_long_are_nan() -> None:
    batch = fr.PeriodicSystem([[0.0, 1.0], [-1.0, -0.1]], period=np.array([1.0, 1e15]))
    found = fr.systems.multipliers(batch)
    assert np.isfinite(found[0]).all()
    assert np.isnan(found[1]).all()
    assert np.isnan(fr.systems.growth_rate(batch)).tolist() == [False, True]
    with pytest.warns(fr.UndecidedWarning, match="1 of 2 systems"):
        assert fr.systems.is_stable(batch).tolist() == [True, False]


def test_sparse_matrices_are_filled() -> None:
    from scipy import sparse

    one = np.array([[1.0, 0.0], [0.3, 2.0]])
    for kind in (sparse.csr_array, sparse.coo_matrix, sparse.lil_array):
        made = kind(one)
        assert fr.PeriodicSystem(-made, [made], [made]) == fr.PeriodicSystem(-one, [one], [one])
        assert fr.HillSystem(made, [made], mass=kind(np.eye(2)), damping=made) == fr.HillSystem(
            one, [one], mass=np.eye(2), damping=one
        )
        pieces, filled = ([(1.0, each), (0.5, 2.0 * each)] for each in (made, one))
        assert fr.HillSystem.from_pieces(pieces) == fr.HillSystem.from_pieces(filled)
        delayed = fr.DelaySystem(made, delayed=[(1.0, made, [made])])
        assert delayed == fr.DelaySystem(one, delayed=[(1.0, one, [one])])
        for call, words in (
            (lambda m: fr.PeriodicSystem(one, m), r"cosines must be a sequence.*cosines=\[matrix\]"),
            (lambda m: fr.PeriodicSystem(np.eye(3), [m]), r"cosines\[0\] must be 3 x 3"),
            (lambda m: fr.HillSystem(sparse.eye(3, 2)), "square matrix"),
            (lambda m: fr.HillSystem(sparse.eye(10**6)), "at most 2000 x 2000"),
            (lambda m: fr.HillSystem(one, [sparse.eye(10**6)]), r"cosines\[0\] must be at most"),
            (lambda m: fr.Hill(0.0, m), "must be a dense array"),
        ):
            with pytest.raises((TypeError, ValueError), match=words):
                call(made)
