"""Earlier names of what is public: they work, and say what replaces them and until when."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import floquetrod as fr

ROD, LOAD = fr.Rod.nitinol(), fr.AxialWave(0.34, 0.34, 150.0)
TIME = np.linspace(0.0, 2.0, 801)
RENAMED: list[tuple[Callable[[], Any], str, str]] = [
    (
        lambda: fr.chart(fr.Mathieu, {"alpha": (0.0, 1.0, 2), "beta": (-1.0, 0.0, 2)}).bands,
        "hairlines",
        "tongues_left_out",
    ),
    (lambda: ROD.ranges("mean", amplitude=0.34, frequency=150.0, bounds=(0.0, 0.5)), "hairlines", "tongues_left_out"),
    (lambda: fr.ForceRecord(TIME, 1.0 + 0.5 * np.sin(20.0 * TIME)), "kept", "harmonic_numbers"),
    (lambda: LOAD, "departures", "features"),
    (lambda: ROD.reach(fr.WellPath([0.0, 10.0], ["90deg", "90deg"]), 0.3), "kick", "speed_to_grow"),
]


@pytest.mark.parametrize(("made", "earlier", "now"), RENAMED, ids=lambda x: x if isinstance(x, str) else "")
def test_an_earlier_name_works_and_warns(made: Callable[[], Any], earlier: str, now: str) -> None:
    value = made()
    with pytest.warns(
        DeprecationWarning, match=rf"{type(value).__name__}\.{earlier} is removed in version .*use {now}"
    ):
        found = getattr(value, earlier)
    assert np.array_equal(found, getattr(value, now))
    assert now in getattr(type(value), earlier).__doc__
