"""Runs killed at any moment, saves included: the checkpoint goes on to the bit, and nothing is left lying about."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from fuzz import apart, runs
from fuzz.core import Found, told

CASES = 40
QUICK = 3

_LATEST = 0.25  # seconds: longer than a run takes


def check(rng: np.random.Generator) -> Found:
    """Kill a run up to three times, go on from what is there, and compare with the run that nothing disturbed."""
    expected = runs.reference()
    failures = []
    with tempfile.TemporaryDirectory(prefix="fuzz") as name:
        checkpoint = Path(name) / "run.ckpt"
        moments = [float(rng.uniform(0.0, _LATEST)) for _ in range(int(rng.integers(1, 4)))]
        for moment in moments:
            apart.kill_after(lambda: runs.simulate(checkpoint), moment)
        try:
            different = runs.differences(expected, runs.simulate(checkpoint))
            if different:
                failures.append(f"goes on to another {', '.join(different)}")
        except Exception as error:
            failures.append(f"does not go on: {told(error)}")
        left = runs.strays(Path(name))
        if left:
            failures.append(f"leaves {', '.join(left)}")
    return Found(len(moments), [f"killed after {moments} s: {line}" for line in failures])
