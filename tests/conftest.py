"""Settings of the whole suite: hypothesis profiles, and random numbers that are fresh in every run yet repeatable."""

from __future__ import annotations

import os
import secrets
import zlib

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

SEED = "FLOQUETROD_TEST_SEED"

# Fresh examples in every run (no derandomize): the suite is meant to go on looking.  No deadline: nothing is timed.
settings.register_profile("default", deadline=None, print_blob=True)
# Without the compiler an example costs about a hundred times more.
settings.register_profile(
    "interpreted", deadline=None, print_blob=True, max_examples=10, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("interpreted" if os.environ.get("NUMBA_DISABLE_JIT", "0") == "1" else "default")


def pytest_configure(config: pytest.Config) -> None:
    """Choose the seed of the run before the worker processes start, so that all of them inherit it."""
    os.environ.setdefault(SEED, str(secrets.randbits(63)))


def pytest_report_header(config: pytest.Config) -> str:
    """Tell how to draw the same numbers again."""
    return f"random numbers: {SEED}={os.environ[SEED]}"


@pytest.fixture
def rng(request: pytest.FixtureRequest) -> np.random.Generator:
    """Random numbers of this run and this test; set FLOQUETROD_TEST_SEED to the printed value to draw them again."""
    return np.random.default_rng([int(os.environ[SEED]), zlib.crc32(request.node.nodeid.encode())])
