"""The agreement matrix: no method contradicts another beyond what it states, and one that did would be seen."""

from __future__ import annotations

import dataclasses

import pytest

import floquetrod as fr
from benchmarks import agreement
from floquetrod.floquet.registry import methods_for
from tests.conftest import depth


def test_no_two_methods_differ_by_more_than_they_state() -> None:
    found = agreement.matrix(agreement.draw(20, seed=1))
    assert found.faults == []
    assert sum(map(len, found.seconds.values())) > 60
    assert all(pair.total == pair.agree + pair.undecided + pair.stated for pair in found.pairs.values())
    assert "spectral     reference" in str(found)


def test_no_two_methods_for_systems_differ_by_more_than_they_state() -> None:
    found = agreement.matrix(agreement.draw_systems(depth(10, 5), seed=1))
    assert found.faults == []
    assert {method.name for method in methods_for("systems")} == set(found.seconds)
    assert all(found.seconds.values())


def test_faults_of_systems_are_seen() -> None:
    system = fr.HillSystem([[1.0, 0.0], [0.0, 4.0]], cosines=[[[0.5, 0.2], [0.2, 0.4]]], period=2.0)
    one, other = (fr.stability(system, method=name) for name in ("monodromy", "segmented"))
    assert pair_of(one, other).agree == 1
    assert len(pair_of(dataclasses.replace(one, status="unstable"), other).faults) == 1
    off = dataclasses.replace(one, exponents=tuple(e + 1e-6 for e in one.exponents))
    assert len(pair_of(off, other).faults) == 1


def pair_of(one: fr.results.Stability, other: fr.results.Stability) -> agreement.Pair:
    pair = agreement.Pair()
    agreement.count(pair, one, other)
    return pair


def test_faults_are_seen() -> None:
    equation = fr.Mathieu(0.5, -0.25)
    spectral, reference = (fr.stability(equation, method=name) for name in ("spectral", "reference"))
    assert pair_of(spectral, reference).agree == 1
    assert len(pair_of(dataclasses.replace(spectral, status="stable"), reference).faults) == 1
    off = dataclasses.replace(spectral, discriminant=spectral.discriminant * (1.0 + 1e-9))
    found = pair_of(off, reference)
    assert len(found.faults) == 1
    assert found.largest == pytest.approx(1e-9, rel=1e-3)
    assert pair_of(dataclasses.replace(spectral, status="undecided"), reference).undecided == 1


def test_what_a_method_states_is_no_fault() -> None:
    slow, fast = fr.Mathieu(0.01, -0.25), fr.Mathieu(0.5, -0.25)
    assert pair_of(fr.stability(slow), fr.stability(slow, method="leapfrog")).stated == 1
    blind = dataclasses.replace(fr.stability(fast, method="leapfrog"), status="stable")
    assert len(pair_of(fr.stability(fast), blind).faults) == 1
    between = fr.Mathieu(0.1, -0.19)  # in the square wave's tongue, wider than the sine's
    assert pair_of(fr.stability(between), fr.stability(between, method="square_wave")).stated == 1


def test_huge_discriminants_are_compared_by_their_logarithms() -> None:
    huge = fr.stability(fr.Mathieu(1e6, 1e5))
    assert agreement.difference(huge, huge) == 0.0
    other = dataclasses.replace(huge, log_abs_discriminant=huge.log_abs_discriminant + 1e-3)
    assert agreement.difference(huge, other) == pytest.approx(1e-3, rel=1e-3)
    assert agreement.difference(huge, dataclasses.replace(huge, discriminant=-huge.discriminant)) == 2.0


@pytest.mark.slow
def test_the_command_reports_and_passes(capsys: pytest.CaptureFixture[str]) -> None:
    assert agreement.main(["200", "7"]) == 0
    assert "200 equations, seed 7" in capsys.readouterr().out


def test_growth_of_the_scheme_itself_is_stated() -> None:
    equation = fr.Mathieu(11.543376869548903, 9.205212903474198)  # grows and shrinks a billion times within a period
    exact, scheme = fr.stability(equation), fr.stability(equation, method="leapfrog")
    assert (exact.status, scheme.status) == ("stable", "unstable")
    assert pair_of(exact, scheme).stated == 1
