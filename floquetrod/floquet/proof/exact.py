"""Matrices of fractions: sums, products, inverses and signs, exactly."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np

Exact = list[list[Fraction]]


def is_positive(matrix: Exact) -> bool:
    """Return whether a symmetric matrix is positive definite: all pivots are positive."""
    rows = [row[:] for row in matrix]
    for k, pivot_row in enumerate(rows):
        if pivot_row[k] <= 0:
            return False
        for row in rows[k + 1 :]:
            factor = row[k] / pivot_row[k]
            for j in range(k, len(rows)):
                row[j] -= factor * pivot_row[j]
    return True


def inverse(matrix: Exact) -> Exact:
    """Return the inverse of a positive definite matrix, exactly."""
    n = len(matrix)
    rows = [[*row, *unit] for row, unit in zip(matrix, identity(n), strict=True)]
    for k in range(n):
        rows[k] = [entry / rows[k][k] for entry in rows[k]]
        for i in range(n):
            if i != k:
                rows[i] = [a - rows[i][k] * b for a, b in zip(rows[i], rows[k], strict=True)]
    return [row[n:] for row in rows]


def exact(matrix: Any) -> Exact:
    """Return doubles as the fractions they are."""
    return [[Fraction(entry) for entry in row] for row in np.asarray(matrix, dtype=float).tolist()]


def identity(n: int) -> Exact:
    """Return the identity."""
    return [[Fraction(int(i == j)) for j in range(n)] for i in range(n)]


def transposed(matrix: Exact) -> Exact:
    """Return the transposed matrix."""
    return [list(column) for column in zip(*matrix, strict=True)]


def product(one: Exact, other: Exact) -> Exact:
    """Return the product."""
    columns = transposed(other)
    return [[sum((a * b for a, b in zip(row, column, strict=True)), Fraction(0)) for column in columns] for row in one]


def total(one: Exact, other: Exact) -> Exact:
    """Return the sum."""
    return [[a + b for a, b in zip(*rows, strict=True)] for rows in zip(one, other, strict=True)]
