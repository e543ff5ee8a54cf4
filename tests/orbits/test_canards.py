"""FitzHugh and Nagumo's cycles, whose folds lie where a canard grows within the rounding of the parameter."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import floquetrod as fr
from floquetrod.orbits.locating_special_points import settled
from tests.conftest import depth


def fitzhugh_nagumo(t: Any, x: Any, I: float, eps: float) -> Any:  # noqa: E741
    return x[0] - x[0] ** 3 / 3.0 - x[1] + I, eps * (x[0] + 0.7 - 0.8 * x[1])


def branch(eps: float, *, start: float = 0.45, highest: float = 0.5) -> fr.Branch:
    """Return the cycles over I, from the relaxation oscillation down to the Hopf point."""
    system = fr.NonlinearSystem(fitzhugh_nagumo, parameters={"I": start, "eps": eps})
    return fr.follow(fr.periodic_orbit(system, [-1.0, -0.3]), {"I": (0.2, highest)}, longest=0.1)


def fold(eps: float) -> Any:
    (point,) = branch(eps).special_points
    assert point.kind == "fold"
    return point


@pytest.mark.slow
def test_curve_ends_where_the_multiplier_of_its_fold_is_not_1() -> None:
    curve = fr.follow(fold(0.08), {"I": (0.3, 1.0), "eps": (0.02, 0.3)}, steps=20)
    assert np.abs(curve.critical - 1.0).max() < 2e-3
    assert not curve.notes
    assert all("the multiplier of the fold is" in end and ", not 1: rounding" in end for end in curve.ends)


@pytest.mark.slow
def test_errors_along_a_curve_of_folds_agree_with_folds_of_branches() -> None:
    curve = fr.follow(fold(0.15), {"I": (0.3, 1.0), "eps": (0.13, 0.16)}, longest=0.1)
    assert curve.errors.max() < 1e-10
    for row, eps in ((0, 0.13), (-1, 0.16))[depth(0, 1) :]:
        assert curve.values[row, 1] == eps
        point = fold(eps)
        assert abs(curve.values[row, 0] - point.value) <= curve.errors[row, 0] + point.error
    assert "I error" in str(curve.report())


@pytest.mark.slow
def test_fold_of_a_canard_is_no_branch_point() -> None:
    (point,) = branch(0.03840985).special_points
    assert point.kind == "fold"
    assert math.isclose(point.value, 0.3072702264306, rel_tol=1e-12)


def _sample(rate: float, mu: float) -> Any:
    multipliers = SimpleNamespace(values=np.array([mu + 0.0j]), errors=np.array([1e-12]))
    return SimpleNamespace(tests=SimpleNamespace(turning=rate), value_error=1e-15, multipliers=multipliers)


@pytest.mark.parametrize(
    ("rates", "kind"),
    [
        ((-0.1, -1e-15, 1e-16, 0.1), "fold"),
        ((-0.1, -1e-16, 1e-16, -0.1), "branch point"),
        ((-0.1, -0.1, 0.1, 0.1), "branch point"),
        ((-0.1, -1e-16, 1e-16, 1e-16), None),
        ((1e-16, -1e-16, 1e-16, 0.1), None),
    ],
)
def test_kind_at_which_rounding_hides_the_turn_is_decided_by_samples_beside(
    rates: tuple[float, ...], kind: str | None
) -> None:
    system = fr.NonlinearSystem(lambda t, x, p: (p - x[0] + np.cos(t),), period=2.0 * math.pi, parameters={"p": 0.0})
    orbit = fr.periodic_orbit(system, [0.0])
    unused: Any = None  # `settled` reads neither direction nor units
    point = fr.results.SpecialPoint(
        "branch point", "p", 0.0, 1e-15, 1.0 + 0.0j, orbit, after=1, direction=unused, measure=unused
    )
    samples = [_sample(rate, mu) for rate, mu in zip(rates, (0.1, 0.5, 2.0, 9.0), strict=True)]
    points, notes, _ = settled([point], cast("Any", samples))
    assert [each.kind for each in points] == ([] if kind is None else [kind])
    assert len(notes) == (1 if kind is None else 0)
