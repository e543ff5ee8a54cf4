"""`make bite` counts how often properties are checked, and fails where one discards nearly everything."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import toothless

PROPERTIES = """
from hypothesis import HealthCheck, assume, given, settings, strategies as st

@given(st.integers(0, 1000))
def test_bites(number):
    assume(number % 2)

@settings(suppress_health_check=list(HealthCheck))
@given(st.integers(0, 1000))
def test_hardly_bites(number):
    assume(number % 7 == 0)

def test_without_examples():
    raise AssertionError
"""


def test_a_property_checked_too_rarely_is_named() -> None:
    assert toothless({"bites": (15, 5), "hardly": (1, 14), "never": (0, 0)}) == ["hardly", "never"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("workers", "left_out", "status"), [("0", "nothing", 1), ("0", "hardly", 0), ("1", "nothing", 1)]
)
def test_properties_that_discard_nearly_everything_fail(
    workers: str, left_out: str, status: int, tmp_path: Path
) -> None:
    (tmp_path / "conftest.py").write_text((Path(__file__).parents[1] / "conftest.py").read_text(encoding="utf-8"))
    (tmp_path / "test_some.py").write_text(PROPERTIES)
    command = [sys.executable, "-m", "pytest", "--bite", "-n", workers, "-k", f"not {left_out}", "."]
    run = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert run.returncode == status, run.stdout
    lines = [line.split() for line in run.stdout.splitlines() if "::test_" in line]
    assert all(int(line[0]) > 0 and int(line[1]) > 0 for line in lines)
    told = [(line[2].split("::")[1], line[3:]) for line in lines]
    assert told == [("test_hardly_bites", ["TOO", "FEW"])] * status + [("test_bites", [])]
