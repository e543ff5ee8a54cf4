"""Characteristic values and tongue widths: right for every order and q."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from scipy.linalg import eigvalsh_tridiagonal

import floquetrod as fr
from floquetrod.mathieu.characteristic_curves import tongue_widths
from tests.conftest import depth

pytestmark = pytest.mark.kernels


def chain(order: int, q: float, kind: str, rows: int) -> tuple[list[float], list[float]]:
    """Return diagonal and off-diagonal of the matrix that holds a_order or b_order (DLMF 28.4), and owes us nothing."""
    first = 1 if order % 2 else (0 if kind == "a" else 2)
    diagonal = [float((first + 2 * i) ** 2) for i in range(rows)]
    if order % 2:
        diagonal[0] += q if kind == "a" else -q
    off = [q] * (rows - 1)
    if first == 0:
        off[0] *= math.sqrt(2.0)
    return diagonal, off


@pytest.mark.parametrize("q", [0.0, 1e-3, 1.0, 15.5, 30.0, 300.0, 1e3, 1e4, -7.0])
def test_orders_0_to_40_to_1e_12(q: float) -> None:
    for kind, least in (("a", 0), ("b", 1)):
        orders = np.arange(least, 41)
        found = fr.mathieu.characteristic_values(orders, q, kind)
        rows = 60 + int(2.0 * math.sqrt(abs(q)))
        for order, value in zip(orders, found, strict=True):
            first = 1 if order % 2 else (0 if kind == "a" else 2)
            index = (order - first) // 2
            true = eigvalsh_tridiagonal(*chain(int(order), q, kind, rows), select="i", select_range=(index, index))[0]
            assert abs(value - true) <= 1e-12 * max(1.0, abs(true), abs(q)) * (8.0 if abs(q) > 1e3 else 1.0), order


@pytest.mark.slow
def test_against_twenty_digits() -> None:
    # The dense solver above is itself good to about 1e-12 of the matrix's norm only; these few are exact.
    with mpmath.workdps(40):
        for order, q, kind in ((0, 1e4, "a"), (5, 1e4, "b"), (40, 1e4, "a"), (7, 15.5, "a"), (3, 100.0, "a")):
            rows = 60 + int(2.0 * math.sqrt(q))
            diagonal, off = chain(order, q, kind, rows)
            found = mpmath.mpf(fr.mathieu.characteristic_values(order, q, kind))
            first = 1 if order % 2 else (0 if kind == "a" else 2)
            true = _nearest_eigenvalue(diagonal, off, found)
            assert abs(found - true) <= 1e-12 * max(1.0, abs(true), q)
            assert _count(diagonal, off, true + mpmath.mpf("1e-15") * q) == (order - first) // 2 + 1


def _count(diagonal: list[float], off: list[float], x: mpmath.mpf) -> int:
    pivot = mpmath.mpf(diagonal[0]) - x
    count = int(pivot < 0)
    for d, e in zip(diagonal[1:], off, strict=True):
        square = 2 * mpmath.mpf(off[1]) ** 2 if e != off[1] else mpmath.mpf(e) ** 2
        pivot = d - x - square / pivot
        count += pivot < 0
    return count


def _nearest_eigenvalue(diagonal: list[float], off: list[float], x: mpmath.mpf) -> mpmath.mpf:
    low, high = x - mpmath.mpf("1e-6"), x + mpmath.mpf("1e-6")
    below = _count(diagonal, off, low)
    assert _count(diagonal, off, high) == below + 1
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if _count(diagonal, off, middle) == below else (low, middle)
    return low


WIDTHS = [(1, 0.3), (4, 30.0), (7, 0.01), (10, 1.0), (12, 7.0), (15, 1.0), (20, 1.0)]


@pytest.mark.slow
@pytest.mark.parametrize(("order", "q"), WIDTHS[:: depth(1, 4)])
def test_widths_accurate_relative_to_themselves(order: int, q: float) -> None:
    with mpmath.workdps(90):
        ends = []
        for kind in "ab":
            diagonal, off = chain(order, q, kind, 60)
            ends.append(_sharp(diagonal, off, fr.mathieu.characteristic_values(order, q, kind), kind, order))
        true = abs(ends[0] - ends[1])
        assert abs(tongue_widths(order, q) / true - 1) < 1e-12


def _sharp(diagonal: list[float], off: list[float], x: float, kind: str, order: int) -> mpmath.mpf:
    low, high = mpmath.mpf(x) - mpmath.mpf("1e-9"), mpmath.mpf(x) + mpmath.mpf("1e-9")
    below = _count(diagonal, off, low)
    assert _count(diagonal, off, high) == below + 1
    for _ in range(250):
        middle = (low + high) / 2
        low, high = (middle, high) if _count(diagonal, off, middle) == below else (low, middle)
    return low


def test_narrow_tongues_follow_their_leading_term() -> None:
    # a_m - b_m -> 2 q^m / (2^(m-1) (m-1)!)^2 as q -> 0 (DLMF 28.6.15).
    q = 1e-3
    for order in range(1, 12):
        leading = 2.0 * q**order / (2.0 ** (order - 1) * math.factorial(order - 1)) ** 2
        assert tongue_widths(order, q) == pytest.approx(leading, rel=1e-5)


def test_curves_bound_the_verdicts() -> None:
    alpha = np.array([0.05, 0.5, 2.0, 5.0])
    curves = fr.mathieu.transition_curves(alpha, 6)
    assert curves.even.shape == curves.odd.shape == curves.width.shape == (7, 4)
    assert np.isnan(curves.odd[0]).all()
    assert np.isinf(curves.width[0]).all()
    step = 1e-11 * (1.0 + np.abs(curves.even))
    for m in range(7):
        # Below the curve of a_m in beta lies stability interval m; above that of b_m lies interval m - 1.
        assert fr.mathieu.is_stable(alpha, curves.even[m] - step[m]).all()
        if m:
            assert fr.mathieu.is_stable(alpha, curves.odd[m] + step[m]).all()
            wide = curves.width[m] > 1e-9
            middle = 0.5 * (curves.even[m] + curves.odd[m])
            assert not fr.mathieu.is_stable(alpha, middle)[wide].any()
    assert [curves.period(m) / math.pi for m in (0, 1, 2)] == [2.0, 4.0, 2.0]


def test_curves_say_what_they_hold() -> None:
    assert "orders 1, 2 at 2 values" in repr(fr.mathieu.transition_curves([0.0, 1.0], [1, 2]))


def test_signs_of_q() -> None:
    # DLMF 28.2.26-28: a and b of odd order change places, those of even order do not change.
    assert fr.mathieu.characteristic_values(3, -5.0, "a") == fr.mathieu.characteristic_values(3, 5.0, "b")
    assert fr.mathieu.characteristic_values(4, -5.0, "a") == fr.mathieu.characteristic_values(4, 5.0, "a")


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ((0, 1.0, "b"), ValueError, "order must lie between 1"),
        ((-1, 1.0, "a"), ValueError, "order must lie between 0"),
        ((1.5, 1.0, "a"), TypeError, "order must hold integers"),
        ((1, math.nan, "a"), ValueError, "q must be finite"),
        ((1, 1.0, "c"), ValueError, "kind must be one of"),
        (([1, 2], [1.0, 2.0, 3.0], "a"), ValueError, "must broadcast"),
    ],
)
def test_bad_input(arguments: tuple[object, ...], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        fr.mathieu.characteristic_values(*arguments)
    with pytest.raises(ValueError, match="one-dimensional"):
        fr.mathieu.transition_curves(np.ones((2, 2)), 3)
